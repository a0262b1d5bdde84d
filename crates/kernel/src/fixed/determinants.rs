//! The determinants of a ray and a triangle as plain integers. They determine exactly where the ray
//! crosses the triangle.

use super::crossing::Crossing;
use super::edges::{Edges, cross_i64, i64s, splat, volume};
use super::prepared::minus;
use super::ratio::Ratio;
use super::snapped::{Ray, Triangle};
use crate::simd::{Ints, WrappingI64};

impl Crossing {
    /// Returns where a ray crosses a triangle, or `None` if it does not. This function performs the
    /// same test as the lanes, for a single pair.
    ///
    /// ```
    /// use intertri::fixed::{Bits, Crossing, Grid, scalar};
    /// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
    /// let wall = grid.triangle_of([[0, 0, 5], [4, 0, 5], [0, 4, 5]])?;
    /// let ray = grid.ray_of([1, 1, 0], [0, 0, 1])?;
    /// assert_eq!(Crossing::of(&ray, &wall), scalar::crossing(&ray, &wall));
    /// # Ok::<_, intertri::fixed::GridError>(())
    /// ```
    pub fn of(ray: &Ray, &Triangle([c1, c2, c3]): &Triangle) -> Option<Self> {
        let (a, h4, h5) = (minus(c1, ray.origin()), minus(c2, c1), minus(c3, c1));
        let (a, h4, h5) = (i64s(a), i64s(h4), i64s(h5));
        let triangle = [splat(a), splat(h4), splat(h5), splat(cross_i64(h4, h5))];
        let edges = Edges::<WrappingI64>::new(splat([0; 3]), splat(i64s(ray.dir())), triangle);
        let (with, against) = edges.sides(1);
        if with | against == 0 {
            return None;
        }
        let at = Determinants::new(edges.u, edges.v, edges.w);
        at.crossing(0, volume(a, h4, h5), with != 0, ray)
    }
}

/// The determinants as plain integers, for the few lanes that cross.
pub(super) struct Determinants {
    u: [i64; 8],
    v: [i64; 8],
    w: [i64; 8],
}

impl Determinants {
    #[inline(always)]
    pub(super) fn of<I: Ints>(edges: &Edges<I>) -> Self {
        Self::new(edges.u, edges.v, edges.w)
    }

    /// Stores the determinants of up to eight lanes.
    #[inline(always)]
    pub(super) fn new<I: Ints>(u: I, v: I, w: I) -> Self {
        let mut at = Self { u: [0; 8], v: [0; 8], w: [0; 8] };
        u.store(&mut at.u);
        v.store(&mut at.v);
        w.store(&mut at.w);
        at
    }

    /// Returns the crossing in a lane whose determinants have the same sign, if it is in front of
    /// the origin and within the ray's interval.
    #[inline(always)]
    pub(super) fn crossing(
        &self,
        lane: usize,
        num: i128,
        leaves: bool,
        ray: &Ray,
    ) -> Option<Crossing> {
        // T and D must have the same sign; otherwise, the crossing is behind the origin. If T = 0,
        // the ray starts in the plane, or the triangle is degenerate.
        if num == 0 || (num > 0) != leaves {
            return None;
        }
        // The three determinants have the same sign or are 0. They are not all 0, because `num` is
        // not.
        let u = self.u[lane].unsigned_abs();
        let v = self.v[lane].unsigned_abs();
        let w = self.w[lane].unsigned_abs();
        let t = Ratio { num: num.unsigned_abs(), den: u + v + w };
        t.within(ray.to_f32()).then_some(Crossing { t, v, w, leaves })
    }
}
