//! The answers that the oracle, the reference implementation, and every method give for a list of
//! cases.

use intertri::simd::Level;
use intertri::{Ray, Triangle};
use intertri_reference as reference;

use crate::families::Case;
use crate::methods::METHODS;
use crate::oracle::{self, OracleAnswer};
use crate::test_batch::Answer;

/// The answers of the oracle, the reference implementation, and the methods. Each list of answers
/// has one entry per case.
pub(crate) struct CaseAnswers {
    /// The exact answers.
    pub(crate) oracle: Vec<OracleAnswer>,
    /// Whether the scalar f64 reference reports a hit; a hit at infinity does not count.
    pub(crate) reference: Vec<bool>,
    /// The answers of each method in the table.
    pub(crate) answers: Vec<Vec<Answer>>,
}

impl CaseAnswers {
    /// Computes the answers, using each case's own threshold.
    pub(crate) fn of(cases: &[Case]) -> Self {
        let by_reference = |case: &Case| {
            let scene = reference::Scene::from_triangles([case.triangle.0]);
            let line = reference::Ray::new(case.ray.origin, case.ray.dir);
            let scene = scene.with_threshold(case.threshold);
            scene.hit(0, &line, f64::NEG_INFINITY, f64::INFINITY).is_some()
        };
        let mut answers = vec![Vec::with_capacity(cases.len()); METHODS.len()];
        for same in cases.chunk_by(|a, b| a.threshold.to_bits() == b.threshold.to_bits()) {
            let triangles: Vec<Triangle> = same.iter().map(|case| case.triangle).collect();
            let rays: Vec<Ray> = same.iter().map(|case| case.ray).collect();
            let mut to = vec![Answer::default(); same.len()];
            for (method, answers) in METHODS.iter().zip(&mut answers) {
                method.pairs(Level::best(), same[0].threshold, &triangles, &rays, &mut to);
                answers.extend_from_slice(&to);
            }
        }
        Self {
            oracle: cases.iter().map(|case| oracle::answer(&case.triangle, &case.ray)).collect(),
            reference: cases.iter().map(by_reference).collect(),
            answers,
        }
    }
}
