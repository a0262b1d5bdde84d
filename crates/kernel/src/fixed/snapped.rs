//! Snapped geometry: triangles and rays with integer coordinates.

use super::numbers::{f32s, i32s, pow2};
use crate::{Triangle as Corners, TriangleOf};

/// A triangle whose corners are grid points.
///
/// ```
/// use intertri::fixed::{Bits, Grid};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let triangle = grid.triangle_of([[0, 0, 5], [1, 0, 5], [0, 1, 5]])?;
/// assert_eq!(triangle.corners()[1], [1, 0, 5]);
/// assert_eq!(triangle.to_f32().0[1], [1.0, 0.0, 5.0]);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle(pub(super) [[i32; 3]; 3]);

impl Triangle {
    /// Returns the corners of the triangle.
    #[inline(always)]
    pub fn corners(&self) -> [[i32; 3]; 3] {
        self.0
    }

    /// Returns the same triangle in f32, in units of the grid. The conversion is exact, and so are
    /// boxes around the triangle.
    pub fn to_f32(&self) -> Corners {
        Corners(self.0.map(f32s))
    }

    /// Reverses [`Triangle::to_f32`].
    ///
    /// ```
    /// use intertri::fixed::{Bits, Grid, Triangle};
    /// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
    /// let triangle = grid.triangle_of([[0, 0, 5], [1, 0, -5], [0, 1, 1 << 20]])?;
    /// assert_eq!(Triangle::from_f32(&triangle.to_f32()), triangle);
    /// # Ok::<_, intertri::fixed::GridError>(())
    /// ```
    #[inline(always)]
    pub fn from_f32(&TriangleOf([a, b, c]): &Corners) -> Self {
        Self([i32s(a), i32s(b), i32s(c)])
    }
}

/// A ray whose origin and direction are integers on a grid.
///
/// ```
/// use intertri::fixed::{Bits, Grid};
/// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
/// let ray = grid.ray(&intertri::Ray::new([3.0, 4.0, 5.0], [0.0, 0.0, 0.5]))?.between(1.0, 8.0);
/// assert_eq!(ray.origin(), [3, 4, 5]);
/// // The snapped direction uses all bits. It is the original times two to the exponent.
/// let unit = f64::from(ray.exponent()).exp2();
/// assert_eq!(f64::from(ray.dir()[2]), 0.5 * unit);
/// // The same ray in f32, in units of the grid.
/// assert_eq!((ray.to_f32().origin, ray.to_f32().dir), ([3.0, 4.0, 5.0], [0.0, 0.0, ray.dir()[2] as f32]));
/// assert_eq!(f64::from(ray.to_f32().t_max), 8.0 / unit);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Integers, which are exact in f32. The interval is in multiples of the snapped direction.
    pub(super) line: crate::Ray,
    /// The caller's `t` is `t` in multiples of the snapped direction, times two to this power.
    pub(super) exponent: i32,
}

impl Ray {
    /// Creates a ray from integers, with the interval `0 < t`.
    pub(super) fn new(origin: [i32; 3], dir: [i32; 3]) -> Self {
        Self { line: crate::Ray::new(f32s(origin), f32s(dir)), exponent: 0 }
    }

    /// Returns the snapped origin.
    #[inline(always)]
    pub fn origin(&self) -> [i32; 3] {
        i32s(self.line.origin)
    }

    /// Returns the snapped direction.
    #[inline(always)]
    pub fn dir(&self) -> [i32; 3] {
        i32s(self.line.dir)
    }

    /// Returns the exponent e for which `t` in multiples of the direction before snapping is `2^e`
    /// times `t` in multiples of [`Ray::dir`].
    #[inline(always)]
    pub fn exponent(&self) -> i32 {
        self.exponent
    }

    /// Converts a `t` in multiples of [`Ray::dir`] to multiples of the direction before snapping.
    /// This is exact because the factor is a power of two.
    ///
    /// ```
    /// use intertri::fixed::{Bits, Grid};
    /// let grid = Grid::at(Bits::FINE, 0, [0; 3])?;
    /// let ray = grid.ray(&intertri::Ray::new([0.0; 3], [0.0, 0.0, 0.5]))?;
    /// assert_eq!(ray.t_of_caller(0.75), 0.75 * f64::from(ray.exponent()).exp2());
    /// # Ok::<_, intertri::fixed::GridError>(())
    /// ```
    #[inline(always)]
    pub fn t_of_caller(&self, t: f64) -> f64 {
        t * pow2(self.exponent)
    }

    /// Limits the ray to the interval `t_min <= t < t_max`, in addition to `0 < t`. The limits are
    /// in multiples of the direction before snapping.
    #[inline(always)]
    pub fn between(self, t_min: f32, t_max: f32) -> Self {
        // This is exact except where no crossing is possible: within the bit budgets,
        // `2^-62 < t <= 2^64`.
        let unit = pow2(-self.exponent);
        let end = |t: f32| (f64::from(t) * unit) as f32;
        Self { line: self.line.between(end(t_min), end(t_max)), ..self }
    }

    /// Returns the same ray in f32, in units of the grid and of [`Ray::dir`]. Its interval is exact
    /// wherever a crossing is possible.
    #[inline(always)]
    pub fn to_f32(&self) -> &crate::Ray {
        &self.line
    }
}
