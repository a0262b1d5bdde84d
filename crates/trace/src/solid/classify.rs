//! Classifies points as inside, outside, or on a mesh.

use intertri::internal::exact::is_on;
use intertri::internal::prefetch;
use intertri::{Counts, Mode, RayId, RayOf};

use crate::batch::{Choice, RayBatch, chunks};
use crate::bvh::Bvh;
use crate::containment::Containment;
use crate::scalar::BvhScalar;
use crate::util::memory::{NoMemory, filled};
use crate::walk::beam::order;
use crate::walk::single::{SingleRay, TraversalScratch, is_held};
use crate::walk::{BatchOutput, one_ray};

/// The direction in which crossings are counted. For a closed mesh, all directions give the same
/// result, but rays in an irregular direction rarely hit edges exactly.
pub const WINDING_DIR: [f32; 3] = [0.537_21, 0.351_37, 0.766_91];

// If a component were 0, the filter would leave out triangles that a point may be on
// (`docs/numerics/exact.md`, section 9).
const _: () = assert!(WINDING_DIR[0] != 0.0 && WINDING_DIR[1] != 0.0 && WINDING_DIR[2] != 0.0);

/// The number of points to sort at once.
const SLAB: usize = 1 << 21;

/// The number of rays to generate at once.
const PIECE: usize = 1 << 12;

/// The prefetch distance, in points.
const AHEAD: usize = 16;

/// Classifies a point.
pub(crate) fn classify<S: BvhScalar>(bvh: &Bvh<S>, point: [S; 3]) -> Containment {
    let (tree, originals) = (&bvh.tree, &bvh.originals);
    let seen = S::point(originals, point);
    // A point on the surface is neither inside nor outside, and counting crossings from it would
    // depend on the direction.
    if is_held(tree, seen, |slot| is_on(&bvh.triangle_in(slot), point)) {
        return Containment::Surface;
    }
    let ray = RayOf::new(point, WINDING_DIR.map(S::from));
    S::with_ray(tree, originals, Mode::once(), &ray, |filter, ray| {
        let scratch = &mut *TraversalScratch::lend(tree);
        one_ray::winding(SingleRay { tree, filter, ray, id: RayId(0), selection: &None, scratch })
    })
}

/// Classifies points by crossings alone. `answer` converts the results, given the rays from the
/// points.
pub(crate) fn classify_batch<S: BvhScalar, A: Copy + Default + Send>(
    bvh: &Bvh<S>,
    points: &[[S; 3]],
    answers: &mut [A],
    answer: impl Fn(&[RayOf<S>], &mut [Containment], &mut [A]) + Sync,
) {
    assert_eq!(points.len(), answers.len(), "one result per point");
    for (points, answers) in points.chunks(SLAB).zip(answers.chunks_mut(SLAB)) {
        classify_slab(bvh, points, answers, &answer);
    }
}

/// Classifies the points of a slab. If memory runs out, classifies each half separately.
fn classify_slab<S: BvhScalar, A: Copy + Default + Send>(
    bvh: &Bvh<S>,
    points: &[[S; 3]],
    answers: &mut [A],
    answer: &(impl Fn(&[RayOf<S>], &mut [Containment], &mut [A]) + Sync),
) {
    // The order of the points and their results take memory proportional to the number of points.
    let is_done = try_classify_slab(bvh, points, answers, answer).is_ok();
    if is_done {
        return;
    }
    if let [point] = *points {
        let ray = RayOf::new(point, WINDING_DIR.map(S::from));
        answer(&[ray], &mut [classify(bvh, point)], answers);
        return;
    }
    let half = points.len() / 2;
    let (answers, others) = answers.split_at_mut(half);
    classify_slab(bvh, &points[..half], answers, answer);
    classify_slab(bvh, &points[half..], others, answer);
}

fn try_classify_slab<S: BvhScalar, A: Copy + Default + Send>(
    bvh: &Bvh<S>,
    points: &[[S; 3]],
    answers: &mut [A],
    answer: &(impl Fn(&[RayOf<S>], &mut [Containment], &mut [A]) + Sync),
) -> Result<(), NoMemory> {
    // Parallel rays from neighbouring points stay close together, so beams can trace sixteen of
    // them at once.
    let order = order(points, WINDING_DIR.map(f64::from))?;
    let mut in_order = filled(points.len(), A::default())?;
    chunks(&order, &mut in_order, |order, answers| {
        let (mut rays, mut all) = (Vec::new(), Vec::new());
        let mut counts = Counts::default();
        for (order, answers) in order.chunks(PIECE).zip(answers.chunks_mut(PIECE)) {
            gather(points, order, &mut rays);
            all.clear();
            all.resize(rays.len(), Containment::Outside);
            let (tree, originals) = (&bvh.tree, &bvh.originals);
            let batch: RayBatch<'_, S> =
                RayBatch { tree, originals, mode: Mode::once(), selection: None, rays: &rays };
            let output = BatchOutput::Containments(&mut all);
            counts += batch.trace_part(0..rays.len(), output, &mut Choice::new(false));
            answer(&rays, &mut all, answers);
        }
        counts
    });
    for (&i, &answer) in order.iter().zip(&in_order) {
        answers[i as usize] = answer;
    }
    Ok(())
}

/// Creates the rays that start at the points with the given indices.
fn gather<S: BvhScalar>(points: &[[S; 3]], numbers: &[u32], rays: &mut Vec<RayOf<S>>) {
    rays.clear();
    let ray = |(i, &number): (usize, &u32)| {
        // In sorted order, successive points are scattered in memory, so each access would be a
        // cache miss.
        if let Some(&later) = numbers.get(i + AHEAD) {
            prefetch(&points[later as usize..][..1]);
        }
        RayOf::new(points[number as usize], WINDING_DIR.map(S::from))
    };
    rays.extend(numbers.iter().enumerate().map(ray));
}
