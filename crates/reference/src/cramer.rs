//! Document D: ray-triangle intersection by Cramer's rule, for many rays from one origin.
//!
//! The line `P + t PN` and the plane `A + u AB + v AC` meet where
//!
//! ```text
//! u AB + v AC - t PN = AP        AP = P - A
//! ```
//!
//! By Cramer's rule, each unknown is a quotient of two determinants, and each determinant is a dot
//! product with a vector that does not depend on the ray's direction:
//!
//! ```text
//! D = AC ^ AB     den = D & PN      D and T depend on the triangle only    -> calc_triangle
//! T = AB ^ AC     t = T & AP / den  U, V and T & AP also on the origin     -> Trig::seen_from
//! U = AC ^ AP     u = U & PN / den  three dot products per ray             -> Viewpoint::inter
//! V = AP ^ AB     v = V & PN / den  divisions only after a hit
//! ```
//!
//! # Errors in the document
//! - Its **listing** accepts a negative `T & AP` (called `t` there, though it is not yet divided).
//!   The listing requires `den > 0`, so such a point is behind the viewer: a triangle in front of
//!   the eye is not drawn, but its mirror image behind the eye is. Here, the test is `> 0`.
//! - Its **example** puts the triangle at z = 0, in the plane of the eye, where `T & AP` is 0 and
//!   neither version of the test draws anything. Put the triangle at z = 1 instead.
//!
//! # Edge cases of the listing, kept as they are
//! - The conditions on u and v imply `den > 0`: only **one side** of the triangle is visible, the
//!   side that the normal `T` points to.
//! - The edge opposite A, `u + v = 1`, is **outside**; the other two edges and A are inside.
//! - NaN counts as a miss, and so does a degenerate triangle.

use crate::vector::Vector;

/// A corner: its position and texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The position.
    pub pos: Vector,
    /// The first texture coordinate, in texels.
    pub u: f64,
    /// The second texture coordinate, in texels.
    pub v: f64,
}

impl Corner {
    /// Creates a corner from its position and texture coordinates.
    pub fn new(pos: impl Into<Vector>, u: f64, v: f64) -> Self {
        Self { pos: pos.into(), u, v }
    }
}

/// The coefficients that depend only on the triangle, computed once for a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trig {
    /// The corner A.
    pub a: Vector,
    /// `B - A`
    pub ab: Vector,
    /// `C - A`
    pub ac: Vector,
    /// The coefficients of the common denominator.
    pub d: Vector,
    /// The coefficients of `t`, a normal of the triangle: `-d`.
    pub t: Vector,
    /// The first texture coordinate: its value at A, its increase along AB, and its increase along
    /// AC.
    pub tu: Vector,
    /// The second texture coordinate, in the same form.
    pub tv: Vector,
}

/// The coefficients that also depend on the origin of the rays, computed once for a viewpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The coefficients of `u`.
    pub u: Vector,
    /// The coefficients of `v`.
    pub v: Vector,
    /// The coefficients of the denominator, as in [`Trig::d`].
    pub d: Vector,
    /// The numerator of `t`.
    pub t_ap: f64,
}

/// The point where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// The distance, always positive, in multiples of the length of the ray's direction.
    pub t: f64,
    /// The weight of B.
    pub u: f64,
    /// The weight of C.
    pub v: f64,
}

/// Computes the part of the document's `calc_triangle` that does not depend on the viewpoint.
pub fn calc_triangle([a, b, c]: [Corner; 3]) -> Trig {
    let ab = b.pos - a.pos;
    let ac = c.pos - a.pos;
    Trig {
        a: a.pos,
        ab,
        ac,
        d: ac ^ ab,
        t: ab ^ ac,
        tu: Vector::new(a.u, b.u - a.u, c.u - a.u),
        tv: Vector::new(a.v, b.v - a.v, c.v - a.v),
    }
}

impl Trig {
    /// Computes the part of the document's `calc_triangle` that depends on the viewpoint `p`.
    pub fn seen_from(&self, p: Vector) -> Viewpoint {
        let ap = p - self.a;
        Viewpoint { u: self.ac ^ ap, v: ap ^ self.ab, d: self.d, t_ap: self.t & ap }
    }

    /// Returns the texture coordinates `(tx, ty)` at the point with the weights `u` and `v`.
    pub fn texture(&self, u: f64, v: f64) -> (f64, f64) {
        let at = |k: Vector| k.x + k.y * u + k.z * v;
        (at(self.tu), at(self.tv))
    }
}

impl Viewpoint {
    /// Applies the corrected version of the document's test to the ray from this viewpoint along
    /// `dir`.
    ///
    /// Only the side that the normal `AB ^ AC` points to is visible, so `dir` must run against the
    /// normal. Points on AB and AC are hits. Points on BC, including its ends, are misses, and so
    /// is a point at the viewpoint.
    pub fn inter(&self, dir: Vector) -> Option<Intersection> {
        let u = self.u & dir;
        let v = self.v & dir;
        let d = self.d & dir;
        let hit = u + v < d && u >= 0.0 && v >= 0.0 && self.t_ap > 0.0;
        hit.then(|| Intersection { t: self.t_ap / d, u: u / d, v: v / d })
    }
}

/// Computes the document's texture: 256 times the exclusive or of the coordinates, each rounded
/// toward 0. Read as a colour 0xRRGGBB, the value is a shade of green for coordinates from 0 to
/// 255. The green component repeats every 256 texels.
///
/// Coordinates outside the range of `i32` are clamped to the range, and NaN counts as 0. A product
/// that overflows `i32` loses its high bits.
pub fn xor_pattern(tx: f64, ty: f64) -> i32 {
    (tx as i32 ^ ty as i32).wrapping_mul(256)
}
