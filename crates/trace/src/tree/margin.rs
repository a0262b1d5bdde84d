//! The margin by which traversal widens boxes.
//!
//! Boxes are purely geometric: each contains its triangles, and the rounding errors of traversal
//! are relative to the ray's coordinates. Only the reference implementation may report hits outside
//! a triangle, because of rounding. `docs/numerics/hierarchy.md`, section 1, has the bound.

/// The distance outside a triangle at which the reference implementation may report hits, as a
/// fraction of the largest coordinate of the ray's origin and of the scene: 2^-46. The part of the
/// distance that depends on the triangle's shape is not included.
const BESIDE: f32 = 1.0 / (1_u64 << 46) as f32;

/// The padding of a tree's boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Margin {
    /// The largest coordinate magnitude of any triangle.
    pub(crate) reach: f32,
    /// The padding that boxes receive for every ray.
    pub(crate) lean: f32,
    /// The additional padding, as a fraction of the origin's largest coordinate.
    pub(crate) beside: f32,
}

impl Margin {
    /// Creates the margin for a tree whose coordinates range over ±`reach`. If hits may lie outside
    /// boxes, `lean` is the maximum distance.
    #[inline(always)]
    pub(crate) fn new(reach: f32, lean: Option<f32>) -> Self {
        // Exact hits lie on their triangles, so boxes need no margin.
        let (lean, beside) = lean.map_or((0.0, 0.0), |lean| (lean + BESIDE * reach, BESIDE));
        Self { reach, lean, beside }
    }

    /// Returns the padding of boxes for a ray whose origin's largest coordinate is `away`.
    #[inline(always)]
    pub(crate) fn room(&self, away: f32) -> f32 {
        // Traversal waits for this number. If hits are exact, it need not wait for `away`.
        if self.beside == 0.0 { self.lean } else { self.beside * away + self.lean }
    }
}

#[cfg(test)]
mod tests {
    use intertri::{Mode, Ray, Triangle};

    use crate::Bvh;
    use crate::util::test_numbers::random;

    /// Tests rays that start in the plane of a box's side and immediately leave the box. The
    /// reference implementation reports hits outside an edge that lies along this side, but the
    /// rays' coordinates along the axis of the side are too small to widen the box enough.
    #[test]
    fn hits_beside_a_box_are_found() {
        let (mut random, mode) = (random(), Mode::certified());
        let mut beside = 0;
        for i in 0..100_000 {
            let slant = (4.0 * random() - 2.0).exp2();
            let away = (10.0 * random()).exp2();
            let off = away * (-48.0 - 8.0 * random()).exp2();
            let (long, height) = (0.3 + random(), random() - 0.5);
            // Test rays that leave along each of the three axes.
            let turned = |[x, y, z]: [f32; 3]| {
                let mut point = [x, y, z];
                point.rotate_right(i % 3);
                point
            };
            let corners = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, slant, 0.0]];
            let triangle = Triangle(corners.map(turned));
            let dir = [-off * long, away * long, 0.0];
            let ray = Ray::new(turned([0.0, -away, height]), turned(dir));
            let wanted = mode.closest(&[triangle], &ray);
            let bvh = Bvh::new(&[triangle]).unwrap();
            assert_eq!(bvh.query().mode(mode).closest(&ray), wanted, "{ray:?} {triangle:?}");
            let exact = Mode::exact().closest(&[triangle], &ray);
            beside += usize::from(wanted.is_some() && exact.is_none());
        }
        assert!(beside > 1000, "{beside}");
    }
}
