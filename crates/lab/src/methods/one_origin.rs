//! The `certified` and `exact` modes for rays that share an origin, as camera rays and hard shadow
//! rays do. The tests are based on document D.
//!
//! ```text
//!   with A = c1 - o, once per triangle:   V = (h5 × A)    W = (A × h4)    U = n - V - W
//!   per ray:                              V·d, W·d, U·d: three products
//! ```
//!
//! The forms are computed in f64 and negated where T = n·A is negative, so all of them are positive
//! for a hit in front of the origin. They are divided by their common error bound, so the bound
//! becomes |d|. The forms rule out most rays, and the kernel's filter tests the others. Section 7
//! of `docs/numerics/certified.md` contains the bounds and their proof. Like all per-triangle
//! constants, the forms are computed before the timed part, because all rays of an image share
//! them.

use std::time::Instant;

use intertri::simd::{Lane, Lanes, Mask, Simd, Vec3, Width, WithSimd};
use intertri::{
    ClosestHits, Counts, Filter, LeafSlot, PreparedPacket, PreparedTriangle, Ray, RayPacket,
    Triangle, TriangleId,
};

use super::closest::{Seconds, one_register, packets_of, rays_of};
use super::kernel::answers;
use crate::layout::{Form, Layout};
use crate::test_batch::{Answer, ClosestHit, TestBatch};

/// Half an ulp of 1 in f32.
const U: f64 = 1.0 / (1 << 24) as f64;

/// The error of a form due to rounding to f32, relative to `|form|₂ |d|₂`.
const FORM: f64 = 4.25 * U;

/// The rounding noise of the reference implementation, relative to `|d|₂ h (|A|₂ + h)`.
const NOISE: f64 = 0.25 * U;

/// The error due to rounding the origin, relative to `|d|₂ h |o|₁`.
const ORIGIN: f64 = 1.0 / (1_u64 << 51) as f64;

/// The sign of a form is decisive only if D = n·d exceeds this share of `|d|₂ h²`.
const GRAZING: f64 = 24.0 * U;

/// The assumed minimum length of the longest edge, 2^-48.
const SHORTEST: f64 = 1.0 / (1_u64 << 48) as f64;

/// Multiplying the square root of a sum of squares by this factor rounds it up.
const NORM_UP: f32 = 1.0 + 16.0 * U as f32;
/// 2^-49, which is added to the length to cover underflow.
const NORM_ADD: f32 = 1.0 / (1_u64 << 49) as f32;

/// A triangle relative to one origin.
#[derive(Clone, Copy)]
struct SeenTriangle {
    /// U, V, and W.
    forms: [Vec3<f32>; 3],
    /// The sign of the sum of U, V, and W is uncertain if its absolute value is at most `|d|` times
    /// this value.
    doubtful: f32,
    triangle: PreparedTriangle,
}

impl SeenTriangle {
    fn new(triangle: &Triangle, origin: [f32; 3]) -> Self {
        let vec3 = |p: [f32; 3]| Vec3::<f64>::splat(p.map(f64::from));
        let [c1, c2, c3] = triangle.0.map(vec3);
        let eye = vec3(origin);
        let (a, h4, h5, h6) = (c1 - eye, c2 - c1, c3 - c1, c3 - c2);
        let (n, v, w) = (h4.cross(h5), h5.cross(a), a.cross(h4));
        let (u, t) = (n - v - w, n.dot(a));

        // Cover the errors of the forms, the noise of the reference implementation, and the
        // rounding of the origin.
        let length = |x: Vec3<f64>| x.dot(x).sqrt();
        let longest = |x, y, z| length(x).max(length(y)).max(length(z));
        let (h, away) = (longest(h4, h5, h6).max(SHORTEST), length(a));
        let bound = FORM * longest(u, v, w) + NOISE * h * (away + h) + ORIGIN * h * eye.norm1();

        // T has the same sign as D wherever the triangle is hit in front of the origin.
        let sure = t.abs() > NOISE * h * h * away;
        let turn = if sure { 1.0_f64.copysign(t) / bound } else { f64::NAN };
        let form = |f: Vec3<f64>| Vec3 {
            x: (f.x * turn) as f32,
            y: (f.y * turn) as f32,
            z: (f.z * turn) as f32,
        };
        Self {
            forms: [form(u), form(v), form(w)],
            doubtful: (GRAZING * h * h / bound + 8.0) as f32,
            triangle: PreparedTriangle::new(triangle),
        }
    }

    /// Returns the rays that may hit the triangle, given their directions and lengths.
    #[inline(always)]
    fn maybe<F: Lanes<Scalar = f32>>(&self, dir: Vec3<F>, len: F) -> u32 {
        // Each form's error bound is |d|, so a value below -|d| is a certain miss.
        let [u, v, w] = &self.forms;
        let u = dir.dot_fused(Vec3::splat([u.x, u.y, u.z]));
        let v = dir.dot_fused(Vec3::splat([v.x, v.y, v.z]));
        let w = dir.dot_fused(Vec3::splat([w.x, w.y, w.z]));
        let sure = (u + v + w).abs().gt(len * F::splat(self.doubtful));
        let outside = u.lt(-len) | v.lt(-len) | w.lt(-len);
        (!(sure & outside)).bits()
    }
}

/// Updates a packet's closest hits with the packet's hits on the triangles.
#[inline(always)]
fn offer_all<S: Simd, const N: usize>(
    filter: &Filter<'_>,
    rays: (&RayPacket<N>, &PreparedPacket<'_, S, N>),
    seen: &[SeenTriangle],
    closest: &mut ClosestHits<<Lane<N> as Width>::F<S>, N>,
) where
    Lane<N>: Width,
{
    let (packet, prepared) = rays;
    let dir = Vec3::<<Lane<N> as Width>::F<S>>::load(&packet.dir);
    let len = dir.dot_fused(dir).sqrt().mul_add(Lanes::splat(NORM_UP), Lanes::splat(NORM_ADD));
    let (live, counts) = (packet.live(), &mut Counts::default());
    let find = |LeafSlot(slot)| *seen[slot as usize].triangle.triangle();
    for (i, triangle) in (0..).zip(seen) {
        let maybe = triangle.maybe(dir, len) & live;
        if maybe != 0 {
            let names = (TriangleId(i), LeafSlot(i));
            filter.packet_closest_in(
                prepared,
                &triangle.triangle,
                names,
                find,
                maybe,
                closest,
                counts,
            );
        }
    }
}

/// Tests pairs, treating each ray as the only one with its origin.
pub(super) fn pairs(filter: Filter<'_>, triangles: &[Triangle], rays: &[Ray], to: &mut [Answer]) {
    filter.level().run(Pairs { filter, triangles, rays, to });
}

/// Finds the closest hits of batches. Returns `None` unless the layout is packets and the rays of
/// each batch share one origin.
pub(super) fn closest(
    filter: Filter<'_>,
    batches: &[TestBatch],
    layout: Layout,
    nearest: &mut Vec<ClosestHit>,
) -> Option<Seconds> {
    let bits = |ray: &Ray| ray.origin.map(f32::to_bits);
    let shared =
        |batch: &TestBatch| batch.rays.windows(2).all(|two| bits(&two[0]) == bits(&two[1]));
    let has = layout.form == Form::Packets && layout.lanes > 1 && batches.iter().all(shared);
    let work = Closest { filter, batches, lanes: layout.lanes, nearest };
    if has { filter.level().run(work) } else { None }
}

struct Pairs<'a> {
    filter: Filter<'a>,
    triangles: &'a [Triangle],
    rays: &'a [Ray],
    to: &'a mut [Answer],
}

impl WithSimd for Pairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { filter, triangles, rays, to } = self;
        for ((triangle, ray), to) in triangles.iter().zip(rays).zip(to) {
            let packet = RayPacket::<4>::new(&[Ray::new(ray.origin, ray.dir)]);
            let seen = [SeenTriangle::new(triangle, ray.origin)];
            let lanes = filter.prepare_packet_in::<S, 4>(&packet);
            let mut closest = ClosestHits::new(&packet.t_max);
            offer_all::<S, 4>(&filter, (&packet, &lanes), &seen, &mut closest);
            let hit = filter.hit(&packet.ray(0), &closest.lane(0), |_| *triangle);
            *to = hit.map_or(Answer::default(), |hit| Answer { hit: true, t: hit.t });
        }
    }
}

struct Closest<'a> {
    filter: Filter<'a>,
    batches: &'a [TestBatch],
    lanes: usize,
    nearest: &'a mut Vec<ClosestHit>,
}

impl WithSimd for Closest<'_> {
    type Output = Option<Seconds>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Seconds> {
        let Self { filter, batches, lanes, nearest } = self;
        nearest.clear();
        nearest.reserve(rays_of(batches, 0));
        match lanes {
            4 => Some(packets::<S, 4>(filter, batches, nearest)),
            8 => Some(packets::<S, 8>(filter, batches, nearest)),
            _ if const { one_register::<S>() } => Some(packets::<S, 16>(filter, batches, nearest)),
            _ => None,
        }
    }
}

/// Tests N rays from one origin against one triangle after another.
#[inline(always)]
fn packets<S: Simd, const N: usize>(
    filter: Filter<'_>,
    batches: &[TestBatch],
    nearest: &mut Vec<ClosestHit>,
) -> Seconds
where
    Lane<N>: Width,
{
    let (packets, triangles) = (packets_of::<N>(batches), triangles_of(batches));
    let start = Instant::now();
    for (i, batch) in batches.iter().enumerate() {
        let (packets, seen) = (&packets[i], &triangles[i]);
        let find = |LeafSlot(slot)| batch.triangles[slot as usize];
        for packet in packets {
            let rays = filter.prepare_packet_in::<S, N>(packet);
            let mut closest = ClosestHits::new(&packet.t_max);
            offer_all::<S, N>(&filter, (packet, &rays), seen, &mut closest);
            answers::<S, N>(&filter, &rays, &closest, find, packet.live(), nearest);
        }
    }
    start.elapsed().as_secs_f64()
}

/// Prepares the triangles of each batch, relative to the origin of its rays.
#[inline(never)]
fn triangles_of(batches: &[TestBatch]) -> Vec<Vec<SeenTriangle>> {
    let seen = |batch: &TestBatch| {
        let origin = batch.rays.first().map_or([0.0; 3], |ray| ray.origin);
        batch.triangles.iter().map(|triangle| SeenTriangle::new(triangle, origin)).collect()
    };
    batches.iter().map(seen).collect()
}
