//! Document E: an edge in homogeneous coordinates, clipped to the canonical view volume.
//!
//! The volume is the cube `-w < x < w`, `-w < y < w`, `-w < z < w`; its points have `w > 0`, so a point
//! behind the eye is outside. Each of the six walls has a boundary coordinate that is positive inside it and
//! changes linearly along the edge:
//!
//! ```text
//!          wall             A                       aBC > 0        tHit = aBC / (aBC - cBC)
//!   inside  |  outside       \
//!           |             ----+---- wall            tHit: C is outside, so the edge leaves here,
//!                              \                          tOut shrinks; where A is outside, the
//!                               C                   cBC < 0      edge enters, and tIn grows
//! ```
//!
//! # What the scan lost, and how it is read here
//! - **The listing** is legible except for its last lines; the text under it describes the rest.
//! - **A point on a wall.** According to the text it is outside (`aBC > 0` is inside), so an edge in a wall
//!   is rejected, and one that only starts there is kept.
//! - **`A = tmp`** at the end would assign garbage if A was inside and nothing was stored in `tmp`. Here `A`
//!   changes only if `tIn` did, and `C` is computed from the old `A`.
//! - **NaN and infinity** are not mentioned. Here such an edge has no part in the volume; nor has one so
//!   large that a difference of its boundary coordinates could overflow.

/// A point in homogeneous coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point4 {
    /// The first coordinate, times w.
    pub x: f64,
    /// The second coordinate, times w.
    pub y: f64,
    /// The third coordinate, times w.
    pub z: f64,
    /// The divisor.
    pub w: f64,
}

impl Point4 {
    /// A point from its four coordinates.
    pub const fn new(x: f64, y: f64, z: f64, w: f64) -> Self {
        Self { x, y, z, w }
    }

    /// The six boundary coordinates: `w + x, w - x, w + y, w - y, w + z, w - z`.
    pub fn boundaries(self) -> [f64; 6] {
        let Self { x, y, z, w } = self;
        [w + x, w - x, w + y, w - y, w + z, w - z]
    }

    /// `self + t * (c - self)`, for each coordinate.
    fn toward(self, c: Self, t: f64) -> Self {
        Self {
            x: self.x + t * (c.x - self.x),
            y: self.y + t * (c.y - self.y),
            z: self.z + t * (c.z - self.z),
            w: self.w + t * (c.w - self.w),
        }
    }
}

/// Bit `i` is 0 if the point is inside wall `i`, that is, if its boundary coordinate is positive; 1 if it is
/// outside, on the wall, or NaN.
pub fn outcode(boundaries: [f64; 6]) -> u8 {
    let bit = |i: usize| if boundaries[i] > 0.0 { 0 } else { 1 << i };
    (0..6).map(bit).sum()
}

/// Clips the edge from `a` to `c` to the canonical view volume. Returns 1 if a part of it is inside, and `a`
/// and `c` become the ends of that part; returns 0 if none is, and they stay as they were.
///
/// An end that is inside keeps its bits. A clipped end may lie outside its wall by rounding. The part can be
/// a single point, if an edge touches an edge of the volume. An edge with a coordinate that is NaN, infinite,
/// or so large that `w + x` and the like exceed a quarter of the largest f64 returns 0.
pub fn clip_edge(a: &mut Point4, c: &mut Point4) -> i32 {
    let a_bc = a.boundaries();
    let c_bc = c.boundaries();
    // Below this limit, no difference of two boundary coordinates, nor of two coordinates, overflows.
    if !a_bc.iter().chain(&c_bc).all(|bc| bc.abs() <= f64::MAX / 4.0) {
        return 0;
    }

    // Are both ends outside one wall, or both inside all?
    let a_outcode = outcode(a_bc);
    let c_outcode = outcode(c_bc);
    if a_outcode & c_outcode != 0 {
        return 0;
    }
    if a_outcode | c_outcode == 0 {
        return 1;
    }

    // The edge is inside for t from t_in to t_out. Each wall that it crosses may shrink that range.
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

    // Only an end whose t has changed moves, and both are computed from the old A.
    let old_a = *a;
    if t_in > 0.0 {
        *a = old_a.toward(*c, t_in);
    }
    if t_out < 1.0 {
        *c = old_a.toward(*c, t_out);
    }
    1
}
