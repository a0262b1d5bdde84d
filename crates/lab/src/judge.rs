//! How often the methods are wrong on a workload: against the truth, and against the reference.

use intertri::lanes::Level;
use intertri::{Ray, Triangle};
use intertri_reference as reference;
use rayon::prelude::*;
use robust::Coord3D;
use serde::Serialize;

use crate::families::adversarial;
use crate::rng::Rng;
use crate::subjects::{
    Answer, Bundle, Form, Layout, Nearest, SUBJECTS, Subject, on_grid, reference_closest,
};
use crate::truth::truth;
use crate::workloads::{Model, Workload};

/// How often a method was wrong.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// The workload.
    pub workload: &'static str,
    /// The subject; [`ON_GRID`] is the mode `fixed` on inputs that it need not snap.
    pub method: &'static str,
    /// Rays, or pairs of the mix.
    pub trials: u64,
    /// Answers that are not the exact one. For `camera` and `secondary`: another closest triangle, a
    /// hit that is none, a miss that is none. For `edges`: see the next two. For `mix`: hit or miss.
    pub wrong: u64,
    /// Of `edges`: rays that leave the closed mesh without hitting it.
    pub leaks: u64,
    /// Of `edges`: rays that leave it once and hit two or more triangles.
    pub doubles: u64,
    /// Answers that are not the scalar f64 reference's: another closest triangle, another count of
    /// hits, another hit or miss.
    pub not_reference: u64,
}

/// The name of the mode `fixed` on inputs that were snapped before anybody saw them.
pub const ON_GRID: &str = "fixed, on its grid";

/// So many rays make one piece of work, with a seed of its own.
const PIECE: u64 = 256;

/// Judges every subject on at least so many rays; only those that such rays are for. `step` is told
/// how many more are done. The counts depend on the seed, the number and the model alone.
pub fn judge(
    workload: Workload,
    model: &Model,
    seed: u64,
    rays: u64,
    step: &(impl Fn(u64) + Sync),
) -> Vec<Verdict> {
    let pieces = rays.div_ceil(PIECE);
    let none = || {
        let names = SUBJECTS.iter().map(|subject| subject.name).chain([ON_GRID]);
        let verdict = |method| Verdict { workload: workload.name(), method, ..Verdict::default() };
        names.map(verdict).collect::<Vec<_>>()
    };
    let mut verdicts = (0..pieces)
        .into_par_iter()
        .map(|piece| {
            let mut rng = Rng::new(seed ^ (workload as u64) << 56 ^ piece << 8);
            let mut verdicts = none();
            let mut done = 0;
            while done < PIECE {
                done += match workload {
                    Workload::Mix => pairs(&mut rng, &mut verdicts),
                    Workload::Edges => edges(&workload.bundle(&mut rng, model), &mut verdicts),
                    _ => closest(&workload.bundle(&mut rng, model), &mut verdicts),
                };
            }
            step(done);
            verdicts
        })
        .reduce(none, |mut sum, more| {
            for (sum, more) in sum.iter_mut().zip(more) {
                sum.trials += more.trials;
                sum.wrong += more.wrong;
                sum.leaks += more.leaks;
                sum.doubles += more.doubles;
                sum.not_reference += more.not_reference;
            }
            sum
        });
    verdicts.retain(|verdict| verdict.trials > 0);
    verdicts
}

/// Closest hits.
fn closest(bundle: &Bundle, verdicts: &mut [Verdict]) -> u64 {
    let rays = bundle.rays.len() as u64;
    let layout = Layout { form: Form::Packets, lanes: 8 };
    let mut nearest = Vec::new();
    let mut ask = |subject: &Subject, bundle: &Bundle, known: &Known, verdict: &mut Verdict| {
        let bundles = bundle_slice(bundle);
        if subject.closest(Level::best(), bundles, layout, &mut nearest).is_some() {
            verdict.trials += rays;
            verdict.wrong += known.right.wrong(&nearest);
            let differs = |(a, b): &(&Nearest, &Nearest)| a.triangle != b.triangle;
            let differ = nearest.iter().zip(&known.reference).filter(differs).count();
            verdict.not_reference += differ as u64;
        }
    };
    let known = Known::of(bundle);
    for (subject, verdict) in SUBJECTS.iter().zip(&mut *verdicts) {
        ask(subject, bundle, &known, verdict);
    }
    if let (Some(snapped), Some(verdict), Some(fixed)) =
        (on_grid(bundle), verdicts.last_mut(), SUBJECTS.last())
    {
        ask(fixed, &snapped, &Known::of(&snapped), verdict);
    }
    rays
}

/// What is known of a bundle before a subject is asked.
struct Known {
    right: RightAnswers,
    reference: Vec<Nearest>,
}

impl Known {
    fn of(bundle: &Bundle) -> Self {
        let mut reference = Vec::new();
        reference_closest(bundle_slice(bundle), &mut reference);
        Self { right: RightAnswers::of(bundle), reference }
    }
}

fn bundle_slice(bundle: &Bundle) -> &[Bundle] {
    std::slice::from_ref(bundle)
}

/// For each ray the triangles that are exactly closest; none where nothing is hit.
struct RightAnswers(Vec<Vec<u32>>);

impl RightAnswers {
    fn of(bundle: &Bundle) -> Self {
        let of_ray = |ray: &Ray| {
            let hits: Vec<(f64, u32)> = (0..)
                .zip(&bundle.triangles)
                .filter(|(_, triangle)| truth(triangle, ray).is_hit())
                .map(|(k, triangle)| (t(triangle, ray), k))
                .collect();
            // Two that share the edge that is met have the same t, but for rounding.
            let least = hits.iter().fold(f64::INFINITY, |least, hit| least.min(hit.0));
            let is_least = |hit: &&(f64, u32)| hit.0 <= least * (1.0 + 1e-9);
            hits.iter().filter(is_least).map(|hit| hit.1).collect()
        };
        Self(bundle.rays.iter().map(of_ray).collect())
    }

    fn wrong(&self, nearest: &[Nearest]) -> u64 {
        let is_wrong = |(right, got): &(&Vec<u32>, &Nearest)| {
            if right.is_empty() { **got != Nearest::MISS } else { !right.contains(&got.triangle) }
        };
        self.0.iter().zip(nearest).filter(is_wrong).count() as u64
    }
}

/// `t` in f64, good to some 1e-12.
fn t(triangle: &Triangle, ray: &Ray) -> f64 {
    let scene = reference::Scene::from_triangles([triangle.0]).with_threshold(0.0);
    let mut t = f64::NAN;
    scene.inter_tri(0, &reference::Ray::new(ray.origin, ray.dir), &mut t);
    t
}

/// Whether a point lies within a closed convex mesh: on the same side of all triangles.
pub(crate) fn is_within(triangles: &[Triangle], point: [f32; 3]) -> bool {
    let coord = |[x, y, z]: [f32; 3]| Coord3D { x, y, z };
    triangles.iter().all(|Triangle(corners)| {
        let [a, b, c] = corners.map(coord);
        robust::orient3d(a, b, c, coord(point)) > 0.0
    })
}

/// Leaks and double counts of rays that leave a mesh in one point. Verdicts are as many as subjects,
/// or one more for [`ON_GRID`].
pub(crate) fn edges(bundle: &Bundle, verdicts: &mut [Verdict]) -> u64 {
    let rays = bundle.rays.len() as u64;
    let reference = |bundle: &Bundle| -> Vec<u32> {
        let scene = reference::Scene::from_triangles(bundle.triangles.iter().map(|t| t.0));
        let hits = |ray: &Ray| {
            let line = reference::Ray::new(ray.origin, ray.dir);
            scene.all(&line, 0.0, f64::INFINITY).len() as u32
        };
        bundle.rays.iter().map(hits).collect()
    };
    let add = |verdict: &mut Verdict, counts: &[u32], reference: &[u32]| {
        verdict.trials += rays;
        verdict.leaks += counts.iter().filter(|&&n| n == 0).count() as u64;
        verdict.doubles += counts.iter().filter(|&&n| n > 1).count() as u64;
        verdict.wrong = verdict.leaks + verdict.doubles;
        let differ = counts.iter().zip(reference).filter(|(a, b)| a != b).count();
        verdict.not_reference += differ as u64;
    };
    let expected = reference(bundle);
    for (subject, verdict) in SUBJECTS.iter().zip(&mut *verdicts) {
        add(verdict, &subject.counts(Level::best(), bundle), &expected);
    }
    if let (Some(snapped), Some(verdict), Some(fixed)) =
        (on_grid(bundle), verdicts.get_mut(SUBJECTS.len()), SUBJECTS.last())
    {
        add(verdict, &fixed.counts(Level::best(), &snapped), &reference(&snapped));
    }
    rays
}

/// Pairs of the adversarial mix, hit or miss.
fn pairs(rng: &mut Rng, verdicts: &mut [Verdict]) -> u64 {
    let case = adversarial(rng);
    let (triangles, rays) = ([case.triangle], [case.ray]);
    let is_hit = truth(&case.triangle, &case.ray).is_hit();
    let reference = |triangle: &Triangle, ray: &Ray, threshold| {
        let scene = reference::Scene::from_triangles([triangle.0]).with_threshold(threshold);
        let line = reference::Ray::new(ray.origin, ray.dir);
        scene.hit(0, &line, f64::NEG_INFINITY, f64::INFINITY).is_some()
    };
    let expected = reference(&case.triangle, &case.ray, case.threshold);
    for (subject, verdict) in SUBJECTS.iter().zip(&mut *verdicts) {
        let mut to = [Answer::default()];
        subject.pairs(Level::best(), case.threshold, &triangles, &rays, &mut to);
        verdict.trials += 1;
        verdict.wrong += u64::from(to[0].hit != is_hit);
        verdict.not_reference += u64::from(to[0].hit != expected);
    }
    let bundle = Bundle { rays: rays.to_vec(), triangles: triangles.to_vec() };
    if let (Some(snapped), Some(verdict), Some(fixed)) =
        (on_grid(&bundle), verdicts.last_mut(), SUBJECTS.last())
    {
        // On an edge or a corner the tie rule gives the hit to one of its triangles; both are right.
        let exact = truth(&snapped.triangles[0], &snapped.rays[0]);
        let tie =
            matches!(exact.place, crate::truth::Place::Edge(_) | crate::truth::Place::Vertex(_));
        let mut to = [Answer::default()];
        fixed.pairs(Level::best(), 0.0, &snapped.triangles, &snapped.rays, &mut to);
        verdict.trials += 1;
        verdict.wrong += u64::from(!tie && to[0].hit != exact.is_hit());
        let expected = reference(&snapped.triangles[0], &snapped.rays[0], 0.0);
        verdict.not_reference += u64::from(to[0].hit != expected);
    }
    1
}

#[cfg(test)]
mod tests {
    use super::{ON_GRID, Verdict, judge};
    use crate::subjects::OF_THE_REFERENCE;
    use crate::workloads::{Model, Workload};

    fn of<'a>(verdicts: &'a [Verdict], method: &str) -> &'a Verdict {
        verdicts.iter().find(|verdict| verdict.method == method).unwrap()
    }

    #[test]
    fn a_seed_gives_the_same_counts_and_promises_are_kept() {
        let model = Model::built_in();
        for workload in Workload::ALL {
            let verdicts = judge(workload, &model, 4, 3000, &|_| ());
            assert_eq!(verdicts, judge(workload, &model, 4, 3000, &|_| ()));
            assert_ne!(verdicts, judge(workload, &model, 5, 3000, &|_| ()), "{workload:?}");
            assert!(verdicts.iter().all(|verdict| verdict.trials > 2900), "{verdicts:?}");
            for method in OF_THE_REFERENCE
                .iter()
                .filter(|method| verdicts.iter().any(|v| v.method == **method))
            {
                assert_eq!(of(&verdicts, method).not_reference, 0, "{workload:?} {method}");
            }
            assert_eq!(of(&verdicts, ON_GRID).wrong, 0, "{workload:?}");
            // What is no more than f32 is wrong somewhere, at edges most of the time.
            let plain = of(&verdicts, "Möller–Trumbore f32");
            match workload {
                Workload::Edges => assert!(plain.leaks > 30 && plain.doubles > 1000, "{plain:?}"),
                Workload::Mix => assert!(plain.wrong > 100, "{plain:?}"),
                _ => assert!(plain.wrong < 10, "{plain:?}"),
            }
        }
    }
}
