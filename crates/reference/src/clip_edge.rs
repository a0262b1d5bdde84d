//! Document E: clips an edge in homogeneous coordinates to the canonical view volume.
//!
//! The volume is the cube `-w < x < w`, `-w < y < w`, `-w < z < w`; its points have `w > 0`, so a
//! point behind the eye is outside. Each of the six walls has a boundary coordinate that is
//! positive inside the wall and changes linearly along the edge:
//!
//! ```text
//!          wall             A                       aBC > 0        tHit = aBC / (aBC - cBC)
//!   inside  |  outside       \
//!           |             ----+---- wall            If C is outside, the edge leaves at tHit and
//!                              \                    tOut shrinks. If A is outside, the edge
//!                               C    cBC < 0         enters at tHit and tIn grows.
//! ```
//!
//! # What is illegible in the scanned document, and how it is read here
//! - **The listing** is legible except for its last lines, which the text below it describes.
//! - **A point on a wall.** According to the text, the point is outside (`aBC > 0` is inside), so
//!   an edge within a wall is rejected, but an edge that only starts on a wall is kept.
//! - **`A = tmp`** at the end would assign garbage if A was inside and nothing was stored in `tmp`.
//!   Here `A` changes only if `tIn` did, and `C` is computed from the old `A`.
//! - **NaN and infinity** are not mentioned. Here, an edge with such a coordinate is rejected, and
//!   so is an edge whose boundary coordinates are so large that their difference could overflow.

/// A point in homogeneous coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point4 {
    /// The first coordinate, times w.
    pub x: f64,
    /// The second coordinate, times w.
    pub y: f64,
    /// The third coordinate, times w.
    pub z: f64,
    /// The coordinate by which the other three are divided.
    pub w: f64,
}

impl Point4 {
    /// Creates a point from its four coordinates.
    pub const fn new(x: f64, y: f64, z: f64, w: f64) -> Self {
        Self { x, y, z, w }
    }

    /// Returns the six boundary coordinates: `w + x, w - x, w + y, w - y, w + z, w - z`.
    pub fn boundaries(self) -> [f64; 6] {
        let Self { x, y, z, w } = self;
        [w + x, w - x, w + y, w - y, w + z, w - z]
    }

    /// Returns `self + t * (c - self)`, computed for each coordinate.
    fn toward(self, c: Self, t: f64) -> Self {
        Self {
            x: self.x + t * (c.x - self.x),
            y: self.y + t * (c.y - self.y),
            z: self.z + t * (c.z - self.z),
            w: self.w + t * (c.w - self.w),
        }
    }
}

/// Returns the outcode of a point. Bit `i` is 0 if the point is inside wall `i`, that is, if
/// boundary coordinate `i` is positive, and 1 if the point is outside, on the wall, or NaN.
pub fn outcode(boundaries: [f64; 6]) -> u8 {
    let bit = |i: usize| if boundaries[i] > 0.0 { 0 } else { 1 << i };
    (0..6).map(bit).sum()
}

/// Clips the edge from `a` to `c` to the canonical view volume. If part of the edge is inside, `a`
/// and `c` become the ends of that part, and the result is 1. Otherwise `a` and `c` are unchanged,
/// and the result is 0.
///
/// An end that is inside keeps its bits. Rounding may leave a clipped end slightly outside its
/// wall. The remaining part can be a single point if the edge touches an edge of the volume. The
/// result is also 0 if a coordinate is NaN, infinite, or so large that a boundary coordinate such
/// as `w + x` exceeds a quarter of the largest f64.
pub fn clip_edge(a: &mut Point4, c: &mut Point4) -> i32 {
    let a_bc = a.boundaries();
    let c_bc = c.boundaries();
    // Up to this limit, no difference between two boundary coordinates or two coordinates
    // overflows.
    if !a_bc.iter().chain(&c_bc).all(|bc| bc.abs() <= f64::MAX / 4.0) {
        return 0;
    }

    // The trivial cases: both ends are outside the same wall, or both are inside all walls.
    let a_outcode = outcode(a_bc);
    let c_outcode = outcode(c_bc);
    if a_outcode & c_outcode != 0 {
        return 0;
    }
    if a_outcode | c_outcode == 0 {
        return 1;
    }

    // The edge is inside for t from t_in to t_out. Each wall that the edge crosses may shrink this
    // range.
    let mut t_in = 0.0;
    let mut t_out = 1.0;
    for i in 0..6 {
        let (a_outside, c_outside) = (a_outcode >> i & 1 == 1, c_outcode >> i & 1 == 1);
        let t_hit = a_bc[i] / (a_bc[i] - c_bc[i]);
        if c_outside && t_hit < t_out {
            t_out = t_hit;
        } else if a_outside && t_hit > t_in {
            t_in = t_hit;
        }
        if t_in > t_out {
            return 0;
        }
    }

    // Move an end only if its t has changed, and compute both ends from the old A.
    let old_a = *a;
    if t_in > 0.0 {
        *a = old_a.toward(*c, t_in);
    }
    if t_out < 1.0 {
        *c = old_a.toward(*c, t_out);
    }
    1
}
