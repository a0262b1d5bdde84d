//! Document E: clips edges and facets in homogeneous coordinates to the canonical view volume.
//!
//! The volume is the cube `-w < x < w`, `-w < y < w`, `-w < z < w`. Each of its six walls has a
//! boundary coordinate that is positive inside the wall and changes linearly along an edge:
//!
//! ```text
//!          wall             in               The cut is at t = b_in / (b_in - b_out), always
//!   inside  |  outside        \              counted from the inside end. Two facets at an edge
//!           |             -----+---- wall    list its ends in opposite order, but both get the
//!                               \            same bits.
//!                                out
//! ```
//!
//! A point on a wall counts as outside. Nothing is divided by w here, so points behind the eye (w <
//! 0) and at infinity do not need special treatment.

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

/// All six walls, for [`clip_facet`]: bit `i` is wall `i`.
pub const ALL_WALLS: u8 = 0b11_1111;

/// All walls except the far one: bits 0 to 3 are the sides of the image, bit 4 is the near wall.
pub const NO_FAR_WALL: u8 = 0b01_1111;

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

    /// Returns `self + t * (to - self)`, computed for each coordinate.
    fn toward(self, to: Self, t: f64) -> Self {
        Self {
            x: self.x + t * (to.x - self.x),
            y: self.y + t * (to.y - self.y),
            z: self.z + t * (to.z - self.z),
            w: self.w + t * (to.w - self.w),
        }
    }

    /// Moves a point that is on wall `i`, up to rounding, exactly onto the wall.
    fn on_wall(self, i: usize) -> Self {
        let w = self.w;
        match i {
            0 => Self { x: -w, ..self },
            1 => Self { x: w, ..self },
            2 => Self { y: -w, ..self },
            3 => Self { y: w, ..self },
            4 => Self { z: -w, ..self },
            _ => Self { z: w, ..self },
        }
    }
}

/// Returns the outcode of a point. Bit `i` is 0 if the point is inside wall `i`, that is, if
/// boundary coordinate `i` is positive, and 1 if the point is outside, on the wall, or NaN.
pub fn outcode(boundaries: [f64; 6]) -> u8 {
    (0..6).fold(0, |code, i| code | if boundaries[i] > 0.0 { 0 } else { 1 << i })
}

/// Returns whether differences between these boundary coordinates, and between the coordinates they
/// come from, cannot overflow. If a coordinate is NaN, the result is false.
fn in_range(boundaries: [f64; 6]) -> bool {
    boundaries.iter().all(|bc| bc.abs() <= f64::MAX / 4.0)
}

/// Returns the part of an edge that is inside the canonical view volume, or `None` if no part is.
///
/// An end that is inside keeps its bits, a clipped end is exactly on its wall, and the edge from
/// `c` to `a` yields the same two points in reverse. The result is `None` if a coordinate is NaN,
/// infinite, or so large that a boundary coordinate such as `w + x` exceeds a quarter of the
/// largest f64.
///
/// ```
/// use intertri_raster::{Point4, clip_edge};
/// let inside = Point4::new(0.0, 0.0, 0.0, 1.0);
/// let right = Point4::new(2.0, 0.0, 0.0, 1.0);
/// let (a, c) = clip_edge(inside, right).unwrap();
/// assert_eq!((a, c), (inside, Point4::new(1.0, 0.0, 0.0, 1.0)));
/// ```
pub fn clip_edge(a: Point4, c: Point4) -> Option<(Point4, Point4)> {
    let (a_bc, c_bc) = (a.boundaries(), c.boundaries());
    if !(in_range(a_bc) && in_range(c_bc)) {
        return None;
    }

    // The trivial cases: both ends are outside the same wall, or both are inside all walls.
    let (a_outcode, c_outcode) = (outcode(a_bc), outcode(c_bc));
    if a_outcode & c_outcode != 0 {
        return None;
    }
    if a_outcode | c_outcode == 0 {
        return Some((a, c));
    }

    // Find how far the visible part can reach from a toward c, and from c toward a. If one end is
    // outside a wall, the wall limits how far the part reaches from the other end. Edges with both
    // ends outside the same wall have already been rejected.
    let (mut from_a, mut from_c) = ((1.0, None), (1.0, None));
    for i in 0..6 {
        if c_outcode >> i & 1 == 1 {
            let t = a_bc[i] / (a_bc[i] - c_bc[i]);
            if t < from_a.0 || from_a.1.is_none() {
                from_a = (t, Some(i));
            }
        } else if a_outcode >> i & 1 == 1 {
            let t = c_bc[i] / (c_bc[i] - a_bc[i]);
            if t < from_c.0 || from_c.1.is_none() {
                from_c = (t, Some(i));
            }
        }
    }

    // The edge is visible only if the two parts overlap.
    if from_a.0 + from_c.0 < 1.0 {
        return None;
    }
    let cut = |from: Point4, to: Point4, (t, wall): (f64, Option<usize>)| {
        wall.map_or(to, |wall| from.toward(to, t).on_wall(wall))
    };
    Some((cut(c, a, from_c), cut(a, c, from_a)))
}

/// Two buffers that [`clip_facet`] uses alternately, kept between calls to reuse their memory.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    outline: Vec<Point4>,
    next: Vec<Point4>,
}

/// Returns the part of a flat facet that is inside the given walls, as an outline in the facet's
/// order. The outline is empty if no part is inside.
///
/// A convex facet has a convex outline. The outline of a concave facet may have several parts,
/// connected by edges that run back and forth along a wall. Corners that are inside keep their
/// bits, and a clipped corner depends only on the ends of its edge, not on their order or on the
/// facet. The result is empty if a coordinate is NaN, infinite, or so large that a boundary
/// coordinate such as `w + x` exceeds a quarter of the largest f64.
pub fn clip_facet(
    corners: impl IntoIterator<Item = Point4>,
    walls: u8,
    scratch: &mut Scratch,
) -> &[Point4] {
    let Scratch { outline, next } = scratch;
    outline.clear();
    outline.extend(corners);

    // Find the walls that have every corner outside, and the walls that have at least one corner
    // outside.
    let (mut all, mut any, mut usable) = (walls, 0, true);
    for corner in &*outline {
        let boundaries = corner.boundaries();
        usable &= in_range(boundaries);
        let code = outcode(boundaries) & walls;
        all &= code;
        any |= code;
    }
    if all != 0 || !usable {
        outline.clear();
    }

    // Each wall with a corner outside clips what remains after the previous walls.
    for i in (0..6).filter(|i| any >> i & 1 == 1) {
        next.clear();
        let Some(&last) = outline.last() else { break };
        let (mut from, mut from_bc) = (last, last.boundaries()[i]);
        for &to in &*outline {
            let to_bc = to.boundaries()[i];
            match (from_bc > 0.0, to_bc > 0.0) {
                (true, true) => next.push(to),
                (true, false) => {
                    next.push(from.toward(to, from_bc / (from_bc - to_bc)).on_wall(i));
                }
                (false, true) => {
                    next.push(to.toward(from, to_bc / (to_bc - from_bc)).on_wall(i));
                    next.push(to);
                }
                (false, false) => {}
            }
            (from, from_bc) = (to, to_bc);
        }
        std::mem::swap(outline, next);
    }
    outline
}
