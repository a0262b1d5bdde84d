//! Projects triangles from the point at which rays start or, if they are reversed, end.
//!
//! `docs/numerics/projection.md`, sections 2 to 4 and 6, has the bounds.

use super::super::super::bound;
use super::super::frame::Frame;
use super::Forms;
use super::lanes::{around, corners, into, load, minus, planes};
use crate::packet::TriangleBlock;
use crate::simd::{Lanes, Simd, Vec3};

impl<F: Lanes<Scalar = f32>> Forms<F> {
    /// Projects triangles from the origin of the frame.
    #[inline(always)]
    pub(super) fn from_point<S: Simd<F32x16 = F>>(
        blocks: [&TriangleBlock<8>; 2],
        frame: &Frame,
        parallel: f32,
        exact: bool,
    ) -> Self {
        let planes = Planes::new::<S>(blocks, frame);
        let corners = Corners::new::<S>(blocks, frame);
        let sizes = Sizes::of(&planes, corners.a.norm1(), frame, parallel);
        let rectangle = corners.rectangle(planes.turn, frame, exact);
        let (edges, unit) = corners.edges(frame);
        let sure = planes.is_sure(corners.a.norm1(), sizes.size, frame);
        let (Planes { s, turn, .. }, Sizes { err, least, slanted, .. }) = (planes, sizes);
        Self { edges, unit, turn, sure, s, err, least, slanted, rectangle, horizon: 0.0 }
    }
}

/// The planes of sixteen triangles, computed in f64.
pub(super) struct Planes<F> {
    /// The inverse depth, 1 / depth = D / T, as a form.
    s: [F; 3],
    /// `h^2 / |T|`
    q: F,
    /// The magnitude of N, with the sign of T.
    turn: F,
}

impl<F: Lanes<Scalar = f32>> Planes<F> {
    #[inline(always)]
    pub(super) fn new<S: Simd<F32x16 = F>>(blocks: [&TriangleBlock<8>; 2], frame: &Frame) -> Self {
        let (mut s, mut q, mut normal) = ([[0.0; 16]; 3], [0.0; 16], [0.0; 16]);
        for (half, block) in blocks.into_iter().enumerate() {
            // Compute T and n in f64, because the inverse depth decides which of two triangles is
            // nearer (projection.md, section 3).
            let (n, t) = planes::<S>(block, frame);
            let recip = S::F64x8::splat(1.0) / t;
            // In the dual axes, N·(M d) equals n·d, although the frame's own axes are orthogonal
            // only up to rounding.
            let n = into(n, &frame.dual);
            let to = 8 * half;
            (n.x * recip).store_f32(&mut s[0][to..]);
            (n.y * recip).store_f32(&mut s[1][to..]);
            (n.z * recip).store_f32(&mut s[2][to..]);
            let h = S::F64x8::load_f32(block.longest_edges());
            (h * h * recip.abs()).store_f32(&mut q[to..]);
            n.norm1().flip(t).store_f32(&mut normal[to..]);
        }
        Self { s: load(&s), q: F::load(&q), turn: F::load(&normal) }
    }

    /// Returns the lanes in which the sign of T is known, for triangles at a distance of `away`
    /// from the origin.
    #[inline(always)]
    pub(super) fn is_sure(&self, away: F, size: F, frame: &Frame) -> F::Mask {
        // For rays that miss the origin, T changes by `|s|₁ off` relative to itself; for rays
        // through it, `off` is 0.
        let off = size * frame.off_at(away) * F::splat(bound::OFF_PLANE);
        // The sign of T is known if its total error is less than T; 0.99 leaves a margin for the
        // rounding of this sum.
        (self.q * away).mul_add(F::splat(frame.shares.plane), off).lt(F::splat(0.99))
    }
}

/// The error of the inverse depth, and the limits that follow from it.
pub(super) struct Sizes<F> {
    pub(super) size: F,
    pub(super) err: F,
    least: F,
    slanted: F,
}

impl<F: Lanes<Scalar = f32>> Sizes<F> {
    #[inline(always)]
    pub(super) fn of(
        Planes { s, q, .. }: &Planes<F>,
        away: F,
        frame: &Frame,
        parallel: f32,
    ) -> Self {
        let (splat, q) = (F::splat, *q);
        let size = s[0].abs() + s[1].abs() + s[2].abs();
        let off = frame.off_at(away);
        let [x, y] = frame.reach;
        // The largest |s| on the part of the projection that rays reach. The errors of offset rays
        // and copies depend only on the values of s there.
        let most = s[2].abs().mul_add(splat(y), s[1].abs().mul_add(splat(x), s[0].abs()));
        let share = most.mul_add(off * splat(bound::OFF_DEPTH), splat(bound::DEPTH));
        // `DEPTH |s|₁ + LOST q`, plus `OFF_DEPTH off |s|₁ most` for rays that miss the origin
        // (projection.md, sections 3 and 6).
        let err = size.mul_add(share, q * splat(bound::LOST));
        let shares = &frame.shares;
        let err = if shares.copies {
            let slant = (away * most).mul_add(splat(shares.slant), splat(shares.depth));
            q.mul_add(slant, err)
        } else {
            err
        };
        // Below this, the ray grazes the plane, and the sign of D is unknown:
        // `GRAZING LEAN q + SCREEN |s|₁`.
        let least = size.mul_add(splat(shares.screen), q * splat(bound::GRAZING * bound::LEAN));
        let slanted = size.mul_add(splat(parallel), least);
        Self { size, err, least, slanted }
    }
}

/// The corners and edges of sixteen triangles in the axes of a frame.
pub(super) struct Corners<F> {
    pub(super) a: Vec3<F>,
    b: Vec3<F>,
    c: Vec3<F>,
    h4: Vec3<F>,
    h5: Vec3<F>,
    h6: Vec3<F>,
    /// The longest edge.
    h: F,
}

impl<F: Lanes<Scalar = f32>> Corners<F> {
    #[inline(always)]
    pub(super) fn new<S: Simd<F32x16 = F>>(blocks: [&TriangleBlock<8>; 2], frame: &Frame) -> Self {
        let ([c1, c2, c3], h) = corners::<S>(blocks);
        let axes = [frame.depth, frame.right, frame.up];
        if frame.shares.copies {
            // A block of copies contains a corner and the edges -h4 and h5.
            let (a, minus_h4) = (into(c1 - Vec3::splat(frame.origin), &axes), into(c2, &axes));
            let (h5, h6) = (into(c3, &axes), into(c3 + c2, &axes));
            let (h4, b, c) = (minus(minus_h4), a - minus_h4, a + h5);
            return Self { a, b, c, h4, h5, h6, h };
        }
        let (a, h4) = (into(c1 - Vec3::splat(frame.origin), &axes), into(c2 - c1, &axes));
        let (h5, h6) = (into(c3 - c1, &axes), into(c3 - c2, &axes));
        Self { a, b: a + h4, c: a + h5, h4, h5, h6, h }
    }

    /// Returns the bounding rectangles of triangles in front of the origin, widened by the errors
    /// of the corners and of the reference.
    #[inline(always)]
    pub(super) fn rectangle(&self, turn: F, frame: &Frame, exact: bool) -> [(F, F); 2] {
        let (splat, &Self { a, b, c, h, .. }) = (F::splat, self);
        let away = a.norm1();
        //        ┌──────────────┐
        //        │     ╱╲       │   The box around the projected corners, widened on all sides by `room`:
        //        │   ╱    ╲     │   how far a hit may be outside its triangle, plus the error of the
        //        │ ╱________╲   │   corners, divided by the least depth (projection.md, section 4).
        //        └──────────────┘
        let nearest = a.x.min(b.x).min(c.x);
        let apart = splat(frame.distance() * bound::ROOM_AWAY);
        let apart = frame.off_at(away).mul_add(splat(bound::OFF_ROOM), apart);
        let room = h.mul_add(splat(bound::ROOM), away.mul_add(splat(bound::CORNER), apart));
        // A corner that is behind the origin, or nearly so, may project to any point. Such a
        // triangle has no bounding rectangle and is tested against every packet.
        let mut known = nearest.gt(room * splat(8.0))
            & nearest.gt(splat(bound::SHORTEST_DIR))
            & away.lt(splat(bound::LARGEST));
        if !exact {
            // The reference may accept points outside a thin triangle.
            known = known & (h * h).lt(turn.abs() * splat(bound::THIN));
        }
        let one = splat(1.0);
        let (ra, rb, rc) = (one / a.x, one / b.x, one / c.x);
        let room = room.mul_add(ra.max(rb).max(rc), splat(bound::ROOM_SCREEN));
        let (x, y) = ([a.y * ra, b.y * rb, c.y * rc], [a.z * ra, b.z * rb, c.z * rc]);
        [around(x, room, known), around(y, room, known)]
    }

    /// Returns the edges as forms, and the error bound on these forms.
    #[inline(always)]
    pub(super) fn edges(&self, frame: &Frame) -> ([Vec3<F>; 3], F) {
        let (splat, &Self { a, b, h4, h5, h6, h, .. }) = (F::splat, self);
        // Each form is the normal of the plane through the origin and an edge. Its sign shows on
        // which side of the edge a ray passes.
        let (u, v, w) = (b.cross_fused(h6), h5.cross_fused(a), a.cross_fused(h4));
        let form = u.norm1().max(v.norm1()).max(w.norm1());
        let (away, apart) = (a.norm1(), splat(frame.distance() * bound::ORIGIN * bound::LEAN));
        let apart = frame.off_at(away).mul_add(splat(bound::OFF_EDGE), apart);
        let noise = (away + h).mul_add(splat(frame.shares.edges), apart);
        ([u, v, w], form.mul_add(splat(frame.shares.screen), noise * h))
    }
}
