//! Computes the solid angle of a boundary. Added to the crossings of a ray, it gives the winding
//! number.
//!
//! ```text
//!                 d                 Ω(-d, a, b) = 2 arg Z,
//!                 ▲   b             Z = (|A| - A·d)(|B| - B·d) + A'·B' - i d·(A' × B')
//!                 │  ↗ ╲
//!         p ·─────┼─a   ╲           A, B: the ends relative to p. A', B': their parts perpendicular to d.
//!                 │  ╲   ╲
//!                -d ──────╲         If d·(A × B) = 0 and Z < 0, the ray hits the edge.
//! ```
//!
//! `docs/numerics/winding.md` has the derivation and the bound.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use intertri::Scalar;
use intertri::internal::exact::edge_side;

use super::boundary::Boundary;
use super::classify::WINDING_DIR;
use super::seen_corner::{Axes, SeenCorner};

/// A bound on the error of the cross product of two corners' components perpendicular to the ray,
/// relative to `room` in `edge_number`.
const SIDE: f64 = 64.0 * f64::EPSILON;

/// Returns the solid angle of a boundary as seen from a point, as a fraction of the full sphere, to
/// be added to the signed crossings of the ray from that point. The point must be finite and not on
/// any triangle.
pub(super) fn turns<S: Scalar>(boundary: &Boundary<S>, point: [S; 3]) -> f64 {
    let mut sum = Sum::default();
    for corners in boundary.loops() {
        sum.add_loop(&boundary.axes, point, corners);
    }
    sum.turns()
}

/// A compensated sum of half solid angles.
#[derive(Default)]
struct Sum {
    angle: f64,
    /// The accumulated rounding error.
    lost: f64,
}

impl Sum {
    fn add(&mut self, angle: f64) {
        let next = self.angle + angle;
        let [large, small] =
            if self.angle.abs() > angle.abs() { [self.angle, angle] } else { [angle, self.angle] };
        self.lost += (large - next) + small;
        self.angle = next;
    }

    fn turns(self) -> f64 {
        (self.angle + self.lost) / TAU
    }

    /// Adds the angles of a loop. The angle of each edge is the argument of a complex number. Up to
    /// whole turns, which are counted separately, the argument of the product of these numbers is
    /// the sum of the angles.
    #[inline]
    fn add_loop<S: Scalar>(&mut self, axes: &Axes, point: [S; 3], corners: &[[S; 3]]) {
        let (mut re, mut im, mut turns) = (1.0_f64, 0.0_f64, 0.0);
        let mut from = axes.seen(point, corners[0]);
        for edge in corners.windows(2) {
            let to = axes.seen(point, edge[1]);
            let (x, y, is_settled) = edge_number(&from, &to);
            from = to;
            if is_settled {
                self.add(settled(point, [edge[0], edge[1]], y.atan2(x)));
                continue;
            }
            let (a, b) = (re * x - im * y, re * y + im * x);
            let size = a.abs() + b.abs();
            // Seen from one of its own ends, an edge has no angle.
            if size == 0.0 {
                continue;
            }
            // If two angles on the same side of 0 have a sum on the other side, a turn was
            // completed.
            let is_below = im.is_sign_negative();
            if is_below == y.is_sign_negative() && is_below != b.is_sign_negative() {
                turns += if is_below { -1.0 } else { 1.0 };
            }
            (re, im) = (a / size, b / size);
        }
        self.add(im.atan2(re));
        self.add(turns * TAU);
    }
}

/// Returns a complex number whose argument is half the solid angle between an edge and the
/// direction opposite to the ray, and whether the side on which the ray passes must be determined
/// exactly.
#[inline(always)]
fn edge_number(a: &SeenCorner, b: &SeenCorner) -> (f64, f64, bool) {
    let ([ax, ay], [bx, by]) = (a.across, b.across);
    let re = a.excess * b.excess + (ax * bx + ay * by);
    let im = ay * bx - ax * by;
    let room = a.size * (bx.abs() + by.abs()) + b.size * (ax.abs() + ay.abs());
    (re, im, re < 0.0 && im.abs() <= SIDE * room)
}

/// Corrects an angle close to half a turn. The ray then passes so close to the edge that the side
/// on which it passes is determined exactly.
#[cold]
#[inline(never)]
fn settled<S: Scalar>(point: [S; 3], edge: [[S; 3]; 2], angle: f64) -> f64 {
    match edge_side(point, WINDING_DIR.map(S::from), edge) {
        Ordering::Greater if angle > 0.0 => angle - TAU,
        Ordering::Less if angle < 0.0 => angle + TAU,
        // The edge is seen end-on, or the point lies on it.
        Ordering::Equal => 0.0,
        _ => angle,
    }
}
