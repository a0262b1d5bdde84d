//! Cases with all that is said of them: by the truth, by the reference, by every subject.

use intertri::lanes::Level;
use intertri::{Ray, Triangle};
use intertri_reference as reference;

use crate::families::Case;
use crate::subjects::{Answer, SUBJECTS};
use crate::truth::{Truth, truth};

/// What is said of some cases.
pub(crate) struct Asked {
    /// What is exactly true.
    pub(crate) truth: Vec<Truth>,
    /// Whether the scalar f64 reference sees a hit; one at infinity is none.
    pub(crate) reference: Vec<bool>,
    /// What each subject of the table says.
    pub(crate) answers: Vec<Vec<Answer>>,
}

impl Asked {
    /// Asks, each case with its own threshold.
    pub(crate) fn of(cases: &[Case]) -> Self {
        let by_reference = |case: &Case| {
            let scene = reference::Scene::from_triangles([case.triangle.0]);
            let line = reference::Ray::new(case.ray.origin, case.ray.dir);
            let scene = scene.with_threshold(case.threshold);
            scene.hit(0, &line, f64::NEG_INFINITY, f64::INFINITY).is_some()
        };
        let mut answers = vec![Vec::with_capacity(cases.len()); SUBJECTS.len()];
        for same in cases.chunk_by(|a, b| a.threshold.to_bits() == b.threshold.to_bits()) {
            let triangles: Vec<Triangle> = same.iter().map(|case| case.triangle).collect();
            let rays: Vec<Ray> = same.iter().map(|case| case.ray).collect();
            let mut to = vec![Answer::default(); same.len()];
            for (subject, answers) in SUBJECTS.iter().zip(&mut answers) {
                subject.pairs(Level::best(), same[0].threshold, &triangles, &rays, &mut to);
                answers.extend_from_slice(&to);
            }
        }
        Self {
            truth: cases.iter().map(|case| truth(&case.triangle, &case.ray)).collect(),
            reference: cases.iter().map(by_reference).collect(),
            answers,
        }
    }
}

/// Whether a ray passes clear of all that is hard by design: it meets the plane in front of its
/// origin, and no closer to a side than a hundredth of the way across, inside or out. What fails here
/// fails by the shape or the range of the numbers, not for the last bit.
pub(crate) fn is_clear(case: &Case) -> bool {
    let wide = |p: [f32; 3]| p.map(f64::from);
    let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    // The edge form: it moves to the corner first, so that f64 is far better than the hundredth.
    let [c1, c2, c3] = case.triangle.0.map(wide);
    let (a, d) = (sub(c1, wide(case.ray.origin)), wide(case.ray.dir));
    let (h4, h5) = (sub(c2, c1), sub(c3, c1));
    let (r, n) = (cross(d, a), cross(h4, h5));
    let den = dot(n, d);
    let (v, w) = (-dot(h5, r) / den, dot(h4, r) / den);
    let u = 1.0 - v - w;
    let inside = u > 0.01 && v > 0.01 && w > 0.01;
    let outside = u < -0.01 || v < -0.01 || w < -0.01;
    dot(n, a) / den > 0.0 && (inside || outside) && u.abs() < 1e3 && v.abs() < 1e3
}
