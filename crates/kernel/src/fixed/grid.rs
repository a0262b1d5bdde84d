//! The grid converts f32 coordinates to integers. The conversion is the only step of the `fixed`
//! mode that rounds, apart from the final conversion of the results.
//!
//! ```text
//!   scene, f32                      grid, integers
//!   p            ── * 2^scale, rounded, - centre ──►   -2^b ..= 2^b
//!   dir          ── * its own 2^k, rounded       ──►   2^(q-1) <= longest component < 2^q
//!   t            ◄── * 2^(k - scale)             ──    num / den
//! ```
//!
//! Multiplying an f32 by a power of two is exact in f64, so each coordinate is rounded only once,
//! to the nearest integer, ties to even. A snapped point converts back to the scene exactly, and
//! snapping it again does not change it.

use core::fmt;

use super::numbers::{exponent, pow2, round};
use super::{Ray, Triangle};
use crate::{Triangle as Corners, TriangleOf};

/// The bit widths of a grid's integers.
///
/// Coordinates are in `-2^b ..= 2^b`, and components of directions are in `-2^q ..= 2^q`. The lanes
/// compute in i64, which is sufficient for every intermediate value if `2 b + q <= 58`.
///
/// ```
/// use intertri::fixed::Bits;
/// assert_eq!((Bits::FINE.b(), Bits::FINE.q()), (20, 18));
/// assert_eq!((Bits::COARSE.b(), Bits::COARSE.q()), (16, 16));
/// assert_eq!(Bits::of_grid(19)?.q(), 20);
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bits {
    b: u32,
    q: u32,
}

impl Bits {
    /// `b = 20`, `q = 18`: the finest grid.
    pub const FINE: Self = Self { b: 20, q: 18 };
    /// `b = 16`, `q = 16`: every edge determinant is also exact in f64.
    pub const COARSE: Self = Self { b: 16, q: 16 };

    /// Creates custom bit widths: `1 <= b <= 20`, `1 <= q <= 24`, `2 b + q <= 58`.
    ///
    /// # Errors
    /// Returns an error if `b` or `q` is outside these limits.
    ///
    /// ```
    /// use intertri::fixed::Bits;
    /// assert_eq!(Bits::new(20, 18).unwrap(), Bits::FINE);
    /// assert!(Bits::new(20, 19).is_err());
    /// ```
    pub fn new(b: u32, q: u32) -> Result<Self, GridError> {
        if (1..=20).contains(&b) && (1..=24).contains(&q) && 2 * b + q <= 58 {
            Ok(Self { b, q })
        } else {
            Err(GridError::Bits { b, q })
        }
    }

    /// Returns the bit widths of a grid with `b` bits per coordinate and the largest `q` that this
    /// allows.
    ///
    /// # Errors
    /// Returns an error if `b` is not in `1..=20`.
    pub fn of_grid(b: u32) -> Result<Self, GridError> {
        let q = 58_u32.saturating_sub(b.saturating_mul(2)).clamp(1, 24);
        Self::new(b, q)
    }

    /// Returns the number of bits per coordinate.
    pub fn b(self) -> u32 {
        self.b
    }

    /// Returns the number of bits per component of a direction.
    pub fn q(self) -> u32 {
        self.q
    }
}

impl Default for Bits {
    fn default() -> Self {
        Self::FINE
    }
}

/// The reason why an input does not fit on a grid.
///
/// ```
/// use intertri::fixed::{Bits, Grid, GridError};
/// let grid = Grid::around([[0.0; 3], [1.0; 3]], Bits::FINE)?;
/// assert!(grid.snap([f32::NAN, 0.0, 0.0]).is_err());
/// let outside: GridError = grid.snap([9.0, 0.0, 0.0]).unwrap_err();
/// println!("{outside}");
/// # Ok::<_, GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridError {
    /// Bit widths outside the limits.
    Bits {
        /// The number of bits per coordinate.
        b: u32,
        /// The number of bits per component of a direction.
        q: u32,
    },
    /// A scale or a centre outside the limits of a grid.
    Place {
        /// The exponent of the scale.
        scale: i32,
        /// The grid's centre.
        centre: [i64; 3],
    },
    /// A point with a NaN or infinite coordinate.
    NotFinite([f32; 3]),
    /// A point outside the grid.
    Outside([f32; 3]),
    /// A direction that is zero or has a NaN or infinite component.
    Direction([f32; 3]),
    /// Integers outside the grid's limits.
    Integers([i32; 3]),
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bits { b, q } => write!(
                f,
                "invalid grid of {b} bits with directions of {q} bits: choose 1 to 20 and 1 to 24, with 2 * grid + direction <= 58"
            ),
            Self::Place { scale, centre } => write!(
                f,
                "invalid grid of scale 2^{scale} around {centre:?}: choose a scale of 2^-149 to 2^149 and a centre within 2^50"
            ),
            Self::NotFinite(p) => {
                write!(f, "the point {p:?} is not finite: remove it before snapping")
            }
            Self::Outside(p) => write!(
                f,
                "the point {p:?} is outside the grid: create the grid around all points you need"
            ),
            Self::Direction(d) => {
                write!(f, "the direction {d:?} is zero or not finite")
            }
            Self::Integers(i) => {
                write!(f, "the integers {i:?} are outside the grid's bits, or a direction is zero")
            }
        }
    }
}

impl core::error::Error for GridError {}

/// An integer grid over a scene.
///
/// ```
/// use intertri::fixed::{Bits, Grid};
/// let grid = Grid::around([[-1.0, 0.0, 0.0], [1.0, 0.5, 0.0]], Bits::FINE).unwrap();
/// assert_eq!(grid.snap([1.0, 0.0, 0.0]).unwrap()[0], 1 << 20);
/// assert!(grid.snap([9.0, 0.0, 0.0]).is_err());
/// assert!(grid.moved([0.1, 0.2, 0.3]).unwrap() <= grid.step() / 2.0);
/// ```
///
/// ```
/// use intertri::fixed::{Bits, Grid};
/// use intertri::{Ray, Triangle};
/// // The same grid for every scene: sixteen steps per unit.
/// let grid = Grid::at(Bits::COARSE, 4, [0; 3])?;
/// assert_eq!((grid.bits(), grid.scale(), grid.step()), (Bits::COARSE, 4, 1.0 / 16.0));
/// assert_eq!(grid.unsnap(grid.snap([1.0, 2.01, -3.0])?), [1.0, 2.0, -3.0]);
/// let floor = grid.triangle(&Triangle::new([0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]))?;
/// assert_eq!(floor, grid.triangle_of([[0, 0, 0], [32, 0, 0], [0, 0, 32]])?);
/// let down = grid.ray_of([5, 80, 5], [0, -1, 0])?;
/// assert_eq!(grid.ray(&Ray::new([0.3, 5.0, 0.3], [0.0, -1.0, 0.0]))?.origin(), down.origin());
/// # Ok::<_, intertri::fixed::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    bits: Bits,
    scale: i32,
    centre: [i64; 3],
}

/// Points whose scaled coordinates exceed this value are not snapped, because [`round`] accepts
/// numbers only up to this limit.
const FAR: f64 = (1_i64 << 51) as f64;

impl Grid {
    /// Returns the finest grid that contains all of the points. Pass the corners of the scene and
    /// the origins of the rays.
    ///
    /// # Errors
    /// Returns an error if a point is not finite.
    pub fn around(
        points: impl IntoIterator<Item = [f32; 3]>,
        bits: Bits,
    ) -> Result<Self, GridError> {
        let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in points {
            if !p.iter().all(|x| x.is_finite()) {
                return Err(GridError::NotFinite(p));
            }
            for axis in 0..3 {
                lo[axis] = if p[axis] < lo[axis] { p[axis] } else { lo[axis] };
                hi[axis] = if p[axis] > hi[axis] { p[axis] } else { hi[axis] };
            }
        }

        // If there are no points, or if all coordinates are zero, any scale works.
        let far = lo.iter().chain(&hi).fold(0.0, |far: f64, &x| {
            let x = f64::from(x).abs();
            if x > far { x } else { far }
        });
        if far == 0.0 || far == f64::INFINITY {
            return Ok(Self { bits, scale: 0, centre: [0; 3] });
        }

        // Start at the finest scale at which all coordinates are below 2^50, because `round`
        // accepts numbers only up to 2^51. Then reduce the scale until the scene is no wider than
        // the grid.
        let mut scale = (49 - exponent(far)).min(149);
        loop {
            let ends: [[i64; 2]; 3] = [0, 1, 2]
                .map(|axis| [lo[axis], hi[axis]].map(|x| round(f64::from(x) * pow2(scale))));
            if ends.iter().all(|[lo, hi]| hi - lo <= 2 << bits.b) {
                let centre = ends.map(|[lo, hi]| lo + (hi - lo) / 2);
                return Ok(Self { bits, scale, centre });
            }
            scale -= 1;
        }
    }

    /// Creates a grid that does not depend on the scene. A coordinate x becomes `x * 2^scale`,
    /// rounded, minus the centre.
    ///
    /// # Errors
    /// Returns an error if the scale is not in `-149..=149` or if the centre is not in
    /// `-2^50..=2^50`.
    pub fn at(bits: Bits, scale: i32, centre: [i64; 3]) -> Result<Self, GridError> {
        if scale.unsigned_abs() <= 149 && centre.iter().all(|x| x.unsigned_abs() <= 1 << 50) {
            Ok(Self { bits, scale, centre })
        } else {
            Err(GridError::Place { scale, centre })
        }
    }

    /// Returns the bit widths of the grid's integers.
    pub fn bits(&self) -> Bits {
        self.bits
    }

    /// Returns the exponent of the scale: there are `2^scale` grid steps per unit.
    pub fn scale(&self) -> i32 {
        self.scale
    }

    /// Returns the distance between neighbouring grid points, in units of the scene. Snapping moves
    /// each coordinate by at most half this distance.
    pub fn step(&self) -> f64 {
        pow2(-self.scale)
    }

    /// Returns the grid point nearest to a point in the scene.
    ///
    /// # Errors
    /// Returns an error if the point is not finite or is outside the grid.
    #[inline]
    pub fn snap(&self, p: [f32; 3]) -> Result<[i32; 3], GridError> {
        let (mut snapped, mut inside) = ([0; 3], true);
        for axis in 0..3 {
            let x = f64::from(p[axis]) * pow2(self.scale);
            let on_grid = round(x).wrapping_sub(self.centre[axis]);
            // Check both limits without a branch. The kind of error is determined later.
            inside &= (x.abs() <= FAR) & (on_grid.unsigned_abs() <= 1 << self.bits.b);
            snapped[axis] = on_grid as i32;
        }
        if inside {
            Ok(snapped)
        } else if p.iter().all(|x| x.is_finite()) {
            Err(GridError::Outside(p))
        } else {
            Err(GridError::NotFinite(p))
        }
    }

    /// Returns the exact position of a grid point in the scene.
    pub fn unsnap(&self, i: [i32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (i64::from(i[axis]) + self.centre[axis]) as f64 * self.step())
    }

    /// Returns the distance by which snapping moves a point, along the axis on which it moves
    /// farthest, in units of the scene.
    ///
    /// # Errors
    /// Returns the same errors as [`Grid::snap`].
    pub fn moved(&self, p: [f32; 3]) -> Result<f64, GridError> {
        let to = self.unsnap(self.snap(p)?);
        let moved = [0, 1, 2].map(|axis| (to[axis] - f64::from(p[axis])).abs());
        Ok(moved.into_iter().fold(0.0, |far, x| if x > far { x } else { far }))
    }

    /// Snaps the corners of a triangle. If the triangle becomes degenerate, no ray hits it.
    ///
    /// # Errors
    /// Returns the same errors as [`Grid::snap`].
    pub fn triangle(&self, &TriangleOf([c1, c2, c3]): &Corners) -> Result<Triangle, GridError> {
        Ok(Triangle([self.snap(c1)?, self.snap(c2)?, self.snap(c3)?]))
    }

    /// Creates a triangle from integers.
    ///
    /// # Errors
    /// Returns an error if a coordinate is outside `-2^b ..= 2^b`.
    pub fn triangle_of(&self, corners: [[i32; 3]; 3]) -> Result<Triangle, GridError> {
        match corners.into_iter().find(|&c| exceeds(c, self.bits.b)) {
            Some(corner) => Err(GridError::Integers(corner)),
            None => Ok(Triangle(corners)),
        }
    }

    /// Creates a ray from integers, with the interval `0 < t` and `t` in multiples of the
    /// direction.
    ///
    /// # Errors
    /// Returns an error if a coordinate is outside `-2^b ..= 2^b`, a component of the direction is
    /// outside `-2^q ..= 2^q`, or the direction is zero.
    pub fn ray_of(&self, origin: [i32; 3], dir: [i32; 3]) -> Result<Ray, GridError> {
        if exceeds(origin, self.bits.b) {
            return Err(GridError::Integers(origin));
        }
        if exceeds(dir, self.bits.q) || dir == [0; 3] {
            return Err(GridError::Integers(dir));
        }
        Ok(Ray::new(origin, dir))
    }
}

/// Returns whether a component is outside `-2^bits ..= 2^bits`.
fn exceeds(p: [i32; 3], bits: u32) -> bool {
    p.iter().any(|x| x.unsigned_abs() > 1 << bits)
}

mod rays;
#[cfg(test)]
mod tests;
