//! A crossing of a ray and a triangle, and the closest of several crossings.

use super::numbers::pow2;
use super::quotient::{parts, quotient};
use super::ratio::Ratio;
use super::snapped::Ray;
use crate::Hit;

/// Where a ray crosses a triangle.
///
/// ```
/// use intertri::fixed::{Bits, Grid, scalar};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let wall = grid.triangle_of([[0, 0, 5], [4, 0, 5], [0, 4, 5]])?;
/// let ray = grid.ray_of([1, 2, 0], [0, 0, 3])?;
/// let crossing = scalar::crossing(&ray, &wall).unwrap();
/// assert_eq!(crossing.t.num() * 3, 5 * u128::from(crossing.t.den()));
/// assert!(crossing.leaves);
/// let hit = crossing.to_hit(&ray, 7);
/// assert_eq!((hit.triangle, hit.t, hit.u, hit.v), (7, 5.0 / 3.0, 0.25, 0.5));
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// t in multiples of the snapped direction.
    pub t: Ratio,
    /// The weight of the second corner, times the denominator of t.
    pub v: u64,
    /// The weight of the third corner, times the denominator of t.
    pub w: u64,
    /// Whether the ray crosses in the direction of the normal `(c2 - c1) x (c3 - c1)`, that is,
    /// leaves a mesh whose triangles are counter-clockwise as seen from outside.
    pub leaves: bool,
}

impl Crossing {
    /// Converts the crossing to f64, with `t` in multiples of the direction before snapping. t, u,
    /// and v are all correctly rounded.
    #[inline(always)]
    pub fn to_hit(&self, ray: &Ray, triangle: u32) -> Hit {
        let Self { t, v, w, .. } = *self;
        let geometry = 0;
        // The denominator, v, and w are always below this limit.
        if t.num < 1 << 62 {
            let den = parts(t.den);
            let over = |num: u64| quotient(parts(num), den);
            let ((t, a), (u, b), (v, c)) = (over(t.num as u64), over(v), over(w));
            if a & b & c {
                return Hit { t: t * pow2(ray.exponent()), u, v, triangle, geometry };
            }
        }
        let weight = |num: u64| Ratio { num: num.into(), den: t.den }.to_f64(0);
        Hit { t: t.to_f64(ray.exponent()), u: weight(v), v: weight(w), triangle, geometry }
    }
}

/// The closest crossing of a ray so far. If several crossings have the same t, the lowest index
/// wins.
///
/// ```
/// use intertri::fixed::{Best, Bits, Grid, scalar};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let ray = grid.ray_of([1, 1, 0], [0, 0, 1])?;
/// let mut best = Best::default();
/// assert_eq!(best.t_hi(), f32::INFINITY);
/// for (index, z) in [5, 3, 3].into_iter().enumerate() {
///     let wall = grid.triangle_of([[0, 0, z], [4, 0, z], [0, 4, z]])?;
///     best.offer(scalar::crossing(&ray, &wall).unwrap(), index as u32);
/// }
/// assert_eq!((best.get().unwrap().1, best.to_hit(&ray).unwrap().t), (1, 3.0));
/// assert!(3.0 <= best.t_hi() && best.t_hi() < 3.001);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Best(Option<(Crossing, u32)>);

impl Best {
    /// Returns the closest crossing and the index of its triangle.
    pub fn get(&self) -> Option<(Crossing, u32)> {
        self.0
    }

    /// Offers a crossing. The order of the offers does not matter.
    #[inline(always)]
    pub fn offer(&mut self, crossing: Crossing, triangle: u32) {
        if self.0.is_none_or(|(best, index)| (crossing.t, triangle) < (best.t, index)) {
            self.0 = Some((crossing, triangle));
        }
    }

    /// Returns an upper bound on t in multiples of the snapped direction, or infinity before the
    /// first crossing. You can skip BVH boxes that begin beyond it.
    pub fn t_hi(&self) -> f32 {
        self.0.map_or(f32::INFINITY, |(crossing, _)| {
            // Three f64 roundings are far smaller than one f32 rounding, so two steps up are
            // enough.
            let Ratio { num, den } = crossing.t;
            ((num as f64 / den as f64) as f32).next_up().next_up()
        })
    }

    /// Returns the closest hit in f64.
    pub fn to_hit(&self, ray: &Ray) -> Option<Hit> {
        self.0.map(|(crossing, triangle)| crossing.to_hit(ray, triangle))
    }
}
