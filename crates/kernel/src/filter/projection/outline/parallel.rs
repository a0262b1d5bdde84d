//! Projects triangles along the direction of parallel rays.
//!
//! ```text
//!       up                    A ray is the point (x, y) at which its line meets the plane of the axes.
//!   ───►│                     U, V, and W are linear in x and y, as in a rasterizer without
//!   ───►│──────►  depth       perspective. D is the same for all rays, and T / D is linear.
//!   ───►o right
//! ```
//!
//! `docs/numerics/projection.md`, section 7, has the bounds.

use super::super::super::bound;
use super::super::frame::{Frame, Parallel};
use super::Forms;
use super::lanes::{around, corners, into, load, planes};
use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Simd, Vec3};

impl<F: Lanes<Scalar = f32>> Forms<F> {
    /// Projects triangles along the rays. All hits must be on their triangles.
    #[inline(always)]
    pub(super) fn along<S: Simd<F32x16 = F>>(
        blocks: [&TriangleBlock<8>; 2],
        frame: &Frame,
        &Parallel { length, scale, away, .. }: &Parallel,
    ) -> Self {
        let splat = F::splat;
        let Planes { s, q, turn } = Planes::new::<S>(blocks, frame, length);
        let sure = (q * splat(bound::GRAZING_ALONG)).lt(splat(0.99));

        // The corners and edges as seen along the rays.
        let ([c1, c2, c3], h) = corners::<S>(blocks);
        let from = c1 - Vec3::splat(frame.origin);
        let a = flat(from, frame);
        let (h4, h5, h6) = if frame.shares.copies {
            // A block of copies contains a corner and the edges -h4 and h5.
            let [x, y] = flat(c2, frame);
            ([-x, -y], flat(c3, frame), flat(c3 + c2, frame))
        } else {
            (flat(c2 - c1, frame), flat(c3 - c1, frame), flat(c3 - c2, frame))
        };
        let (b, c) = ([a[0] + h4[0], a[1] + h4[1]], [a[0] + h5[0], a[1] + h5[1]]);

        // The cross product of an edge and the vector from one of its ends to the point.
        let u = Vec3 { x: cross(b, h6), y: -h6[1], z: h6[0] };
        let v = Vec3 { x: cross(h5, a), y: h5[1], z: -h5[0] };
        let w = Vec3 { x: cross(a, h4), y: -h4[1], z: h4[0] };
        let shares = &frame.shares.along;
        // Copies also move by a share of their coordinates.
        let apart = if frame.shares.copies { frame.distance() } else { 0.0 };
        let from = from.norm1();
        let noise = (from + h + splat(2.0 * away + bound::COPY_APART * apart))
            * (h * splat(shares.edges * scale * scale));
        let form = u.norm1().max(v.norm1()).max(w.norm1());
        let unit = form.mul_add(splat(bound::SCREEN), noise);

        let size = s[0].abs() + s[1].abs() + s[2].abs();
        let share = bound::DEPTH + bound::PLACE * scale * away;
        let lost = (from + splat(2.0 * (away + apart))) * splat(1.0 / length);
        let lost = if frame.shares.copies { lost + size } else { lost };
        let err = size.mul_add(splat(share), lost * (q * splat(shares.lost)));

        let room =
            (from + h + splat(away + bound::COPY_APART * apart)) * splat(shares.room * scale);
        // Next to a coordinate that is too large, `h` is NaN.
        let known = from.lt(splat(bound::LARGEST)) & room.lt(splat(f32::INFINITY));
        let room = room + splat(bound::ROOM_SCREEN);
        let rectangle =
            [around([a[0], b[0], c[0]], room, known), around([a[1], b[1], c[1]], room, known)];

        // If the sign of D is known, no ray grazes the plane.
        let (least, slanted) = (splat(-1.0), splat(f32::NEG_INFINITY));
        let horizon = f32::NEG_INFINITY;
        Self { edges: [u, v, w], unit, turn, sure, s, err, least, slanted, rectangle, horizon }
    }
}

/// The planes of sixteen triangles, computed in f64.
struct Planes<F> {
    /// The negative depth of the plane as a form: -T / D.
    s: [F; 3],
    /// `h² |d|₂ / |D|`
    q: F,
    /// 1 with the sign of D.
    turn: F,
}

impl<F: Lanes<Scalar = f32>> Planes<F> {
    #[inline(always)]
    fn new<S: Simd<F32x16 = F>>(
        blocks: [&TriangleBlock<8>; 2],
        frame: &Frame,
        length: f32,
    ) -> Self {
        let (mut s, mut q, mut turn) = ([[0.0; 16]; 3], [0.0; 16], [0.0; 16]);
        let (one, length) = (S::F64x8::splat(1.0), S::F64x8::splat(length.into()));
        for (half, block) in blocks.into_iter().enumerate() {
            let (n, t) = planes::<S>(block, frame);
            // D, and how much T decreases per unit of x and y.
            let n = into(n, &frame.dual);
            let recip = one / n.x;
            let (to, h) = (8 * half, S::F64x8::load_f32(block.longest_edges()));
            (-(t * recip)).store_f32(&mut s[0][to..]);
            (n.y * recip).store_f32(&mut s[1][to..]);
            (n.z * recip).store_f32(&mut s[2][to..]);
            (h * h * recip.abs() * length).store_f32(&mut q[to..]);
            one.flip(n.x).store_f32(&mut turn[to..]);
        }
        Self { s: load(&s), q: F::load(&q), turn: F::load(&turn) }
    }
}

/// Returns the components of a vector along x and y.
#[inline(always)]
fn flat<F: Lanes<Scalar = f32>>(v: Vec3<F>, frame: &Frame) -> [F; 2] {
    [v.dot_fused(Vec3::splat(frame.right)), v.dot_fused(Vec3::splat(frame.up))]
}

#[inline(always)]
fn cross<F: Lanes<Scalar = f32>>(a: [F; 2], b: [F; 2]) -> F {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(all(test, feature = "std"))]
mod tests;
