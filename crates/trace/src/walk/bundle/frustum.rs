//! The frustum around rays of one apex, tested against the eight boxes of a node.
//!
//! Based on Reshetov, Soupikov, and Hurley, *Multi-Level Ray Tracing Algorithm* (2005): a node is
//! culled for all rays at once.
//!
//! ```text
//!            ╱│ far corner: inside all four planes?
//!         ╱ ┌─┼──┐
//!   o  ◄────┤ │  │   near corner: before the farthest t that still counts?
//!         ╲ └────┘
//!            ╲
//! ```
//!
//! No individual ray is tested against a box. `docs/numerics/hierarchy.md` proves that no hit is
//! lost.

use intertri::internal::{Frame, Parallel};
use intertri::simd::{Lanes, Mask};

use super::end_plane::EndPlane;
use super::plane::CullingPlane;
use crate::tree::{Margin, Node};

/// The slope by which the side planes are tilted away from every ray: 2^-18.
const MARGIN: f32 = 1.0 / (1 << 18) as f32;

/// The padding of planes around parallel rays, as a fraction of the largest distance of an origin
/// from the frame's: 24u.
const PAD_AWAY: f32 = 24.0 / (1 << 24) as f32;

/// Four planes around rays of one apex, and the main axis of the rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    sides: [CullingPlane; 4],
    axis: CullingPlane,
    /// Bit k is set if the axis is negative along coordinate k.
    pub(crate) octant: usize,
}

impl Frustum {
    /// Creates the frustum around a rectangle on a frame's projection plane.
    pub(crate) fn new(frame: &Frame, (lo, hi): ([f32; 2], [f32; 2]), margin: &Margin) -> Self {
        let (depth, [right, up]) = (frame.depth(), frame.across());
        let octant = (0..3).map(|k| usize::from(depth[k] < 0.0) << k).sum();
        if let Some(limits) = frame.parallel_rays() {
            return Self { octant, ..Self::parallel(frame, limits, (lo, hi), margin) };
        }
        let side = |across: [f32; 3], slope: f32, sign: f32| {
            // Each plane is tilted outward to cover the rounding of the slopes (hierarchy.md,
            // section 5).
            let slope = slope - sign * MARGIN;
            let normal = [0, 1, 2].map(|k| sign * (across[k] - slope * depth[k]));
            CullingPlane::new(normal, frame, margin)
        };
        let sides = [
            side(right, lo[0], 1.0),
            side(right, hi[0], -1.0),
            side(up, lo[1], 1.0),
            side(up, hi[1], -1.0),
        ];
        Self { sides, axis: CullingPlane::new(depth, frame, margin), octant }
    }

    /// Creates the volume around parallel rays: the planes do not meet in the apex.
    fn parallel(
        frame: &Frame,
        Parallel { length, scale, away, forward, .. }: Parallel,
        (lo, hi): ([f32; 2], [f32; 2]),
        margin: &Margin,
    ) -> Self {
        let (depth, [right, up]) = (frame.depth(), frame.across());
        // The direction of the rays, which may be traced backward, as a form that grows by 1 per unit
        // of length.
        let along = depth.map(|x| forward * x * length);
        let side = |across: [f32; 3], bound: f32, sign: f32| {
            // Each plane is tilted outward in the direction of the rays, starting in front of all
            // origins (hierarchy.md, section 5).
            let tilt = MARGIN * scale;
            let normal = [0, 1, 2].map(|k| sign * across[k] + tilt * along[k]);
            let plane = CullingPlane::new(normal, frame, margin);
            let pad = PAD_AWAY * away * plane.size() + 4.0 * PAD_AWAY;
            plane.moved(sign * bound - tilt * away * 1.01, pad)
        };
        let sides = [
            side(right, lo[0], 1.0),
            side(right, hi[0], -1.0),
            side(up, lo[1], 1.0),
            side(up, hi[1], -1.0),
        ];
        let axis = CullingPlane::new(depth, frame, margin);
        let pad = PAD_AWAY * away * axis.size();
        Self { sides, axis: axis.moved(0.0, pad), octant: 0 }
    }

    /// Returns a mask of a node's boxes that a ray may reach before the depth `far` and, if an end
    /// plane is known, before the rays end. Also returns the depth at which each box begins.
    #[inline(always)]
    pub(crate) fn meet<F: Lanes<Scalar = f32>>(
        &self,
        node: &Node,
        far: f32,
        ends: Option<&EndPlane>,
    ) -> (u32, F) {
        let near = self.axis.of_boxes::<F>(node, true) - F::splat(self.axis.pad);
        let mut met = near.le(F::splat(far));
        if let Some(ends) = ends {
            met = met & ends.may_meet::<F>(node);
        }
        for side in &self.sides {
            // Test the innermost corner: if it is outside, so is the whole box.
            met = met & side.of_boxes::<F>(node, false).ge(F::splat(-side.pad));
        }
        (met.bits(), near)
    }

    /// Returns the far depths of a node's boxes.
    #[inline(always)]
    pub(crate) fn far<F: Lanes<Scalar = f32>>(&self, node: &Node) -> F {
        self.axis.of_boxes::<F>(node, false)
    }
}

#[cfg(test)]
mod tests {
    use intertri::simd::{Level, Simd, WithSimd};
    use intertri::{Mode, Ray};

    use super::{EndPlane, Frustum};
    use crate::tree::{Aabb, Margin, Node};
    use crate::util::prefetch::Prefetch;
    use crate::util::test_numbers::random;
    use crate::walk::bundle::projection::Projection;
    use crate::walk::bundle::rays::{BundleRays, Common};

    /// Finds the first ray whose point at t = 1 is lost because it is outside the rays' frustum, beyond
    /// its own depth, or beyond the end plane.
    struct Lost<'a>(&'a [Ray], Common);

    impl WithSimd for Lost<'_> {
        type Output = Option<Ray>;
        #[inline(always)]
        fn run<S: Simd>(self) -> Option<Ray> {
            let Self(rays, common) = self;
            let mut projection = Projection::<S>::empty();
            let bundle = BundleRays { rays, first: intertri::RayId(0), next: &[], common };
            let (filter, mut prefetch) = (Mode::exact().filter(), Prefetch::of(&[], 0));
            let window = projection.project(&filter, &bundle, 1.0, &mut prefetch)?;
            let margin = Margin::new((1 << 23) as f32, None);
            let frustum = Frustum::new(&projection.frame, window, &margin);
            let ends = EndPlane::new::<S>(&projection, &margin);
            let (depth, origin) = (projection.frame.depth(), projection.frame.origin());
            let is_lost = |&number: &usize| {
                let (o, d) = (rays[number].origin, rays[number].dir);
                let [x, y, z] = [0, 1, 2].map(|k| o[k] + d[k]);
                let mut node = Node::NO_CHILDREN;
                node.set(5, &Aabb { lo: [x, y, z, 0.0], hi: [x, y, z, 0.0] }, 0);
                // Compute the largest depth at which a hit still counts, as bundles do.
                let of =
                    |k: usize, x: f32| f64::from(depth[k]) * (f64::from(x) - f64::from(origin[k]));
                let far = (of(0, x) + of(1, y) + of(2, z)) as f32;
                let far = far + far.abs() * (1.0 / (1 << 18) as f32);
                !projection.is_outlier(number)
                    && frustum.meet::<S::F32x8>(&node, far, Some(&ends)).0 != 1 << 5
            };
            (0..rays.len()).find(is_lost).map(|number| rays[number])
        }
    }

    /// Tests points that have no rounding error: integers multiplied by a power of two.
    #[test]
    fn a_frustum_holds_the_points_of_its_rays() {
        let mut random = random();
        let levels: Vec<Level> = Level::all().collect();
        for i in 0..40_000 {
            // Relative to the magnitude of the origin's coordinates, place the points either close
            // to the origin or far from it.
            let [away, long] = [22.0, 21.0].map(|most| (most * random()).exp2());
            let mut whole = |size: f32| (size * (2.0 * random() - 1.0)).round();
            let [origin, middle] = [away, long].map(|size| [(); 3].map(|()| whole(size)));
            let spread = 0.3 * long;
            let ray = |_| Ray::new(origin, middle.map(|x| x + whole(spread)));
            let rays: Vec<Ray> = (0..3 + i % 4).map(ray).collect();
            let level = levels[i % levels.len()];
            let lost = level.run(Lost(&rays, Common::Origin));
            assert!(lost.is_none(), "{}: {lost:?} of {rays:?}", level.name());
        }
    }
    /// The same for parallel rays, forward and backward.
    #[test]
    fn the_volume_around_parallel_rays_holds_their_points() {
        let mut random = random();
        let levels: Vec<Level> = Level::all().collect();
        for i in 0..40_000 {
            let [away, long, wide] = [21.0, 21.0, 20.0].map(|most| (most * random()).exp2());
            let mut whole = |size: f32| (size * (2.0 * random() - 1.0)).round();
            let [middle, dir] = [away, long].map(|size| [(); 3].map(|()| whole(size)));
            let (count, t_max) = (3 + i % 30, if i % 2 == 0 { 1.0 } else { f32::INFINITY });
            let ray = |_| Ray::new(middle.map(|x| x + whole(wide)), dir).between(0.0, t_max);
            let rays: Vec<Ray> = (0..count).map(ray).collect();
            let (level, reversed) = (levels[i % levels.len()], i % 5 < 2);
            let lost = level.run(Lost(&rays, Common::Direction { reversed }));
            assert!(lost.is_none(), "{} {reversed}: {lost:?} of {rays:?}", level.name());
        }
    }
}
