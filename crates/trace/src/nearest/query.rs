//! Finds the closest points for many query points, on one thread.

use intertri::TriangleId;
use intertri::internal::Bits;
use intertri::simd::{Level, Simd, WithSimd};

use super::found::{Candidate, ClosestPoint, closest_of};
use super::mesh::Mesh;
use super::search::Search;
use crate::morton::along_curve;
use crate::walk::single::TraversalScratch;

/// Finds the closest point within a radius for each query point, on this thread.
pub(crate) fn closest_points<M: Mesh>(
    mesh: M,
    points: &[[M::Scalar; 3]],
    radius: f64,
    closest: &mut [ClosestPoint],
) {
    Level::best().run(Points { mesh, points, radius, closest });
}

struct Points<'a, M: Mesh> {
    mesh: M,
    points: &'a [[M::Scalar; 3]],
    radius: f64,
    closest: &'a mut [ClosestPoint],
}

impl<M: Mesh> WithSimd for Points<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { mesh, points, radius, closest } = self;
        let tree = mesh.tree();
        let mut kept = TraversalScratch::lend(tree);
        let mut candidates: Vec<Candidate> = Vec::new();

        // Search slightly beyond the radius. The final distances decide which results are kept.
        let scaled = mesh.scaled(radius);
        let within = scaled * scaled * (1.0 + 1e-6) + 1e-60;
        let mut likely = None;
        // Process points that are close together one after another, because the last leaf found is
        // then a good first guess. If there is not enough memory to sort the points, keep the given
        // order.
        let order =
            along_curve(&tree.bounds(), points.len(), |i| mesh.at(points[i]).within[0]).ok();
        for i in 0..points.len() {
            let number = order.as_ref().map_or(i, |order| order[i] as usize);
            let point = points[number];
            let closest = &mut closest[number];
            *closest = ClosestPoint::NONE;
            let is_asked = radius >= 0.0 && point.iter().all(|x| Bits::is_finite(*x));
            if !is_asked {
                continue;
            }
            let candidates = &mut candidates;
            let mut search = Search { mesh, at: mesh.at(point), most: within, candidates };
            search.run::<S>(likely, &mut kept);
            if let Some((slot, found)) = closest_of(mesh, point, search.candidates)
                && found.distance <= radius
            {
                // The next point is often nearby, so start its search at this leaf.
                likely = Some(slot.0 / 8);
                *closest = found;
                let name = tree.geometries.name(TriangleId(found.triangle));
                (closest.geometry, closest.triangle) = (name.geometry, name.triangle);
            }
        }
    }
}
