//! Chooses the frame onto which the rays of a bundle are projected.

use intertri::internal::Frame;
use intertri::simd::{Lanes, Simd, Vec3};
use intertri::{Filter, Ray};

use super::principal_axis::Spread;
use super::rays::{BundleRays, Common, half};
use crate::util::lane_ops::{smallest, total};

/// The maximum magnitude of an origin's coordinate: 2^30.
const LARGEST: f32 = (1 << 30) as f32;

/// The maximum magnitude of a scene coordinate: 2^80. No distance from a plane then overflows.
const LARGEST_REACH: f32 = (1_u128 << 80) as f32;

/// The maximum number of rays to sample when choosing the frame.
const SAMPLE: usize = 64;

/// For parallel rays: the largest distance of a sampled origin from the centre of the projection, of
/// 0.5 that all origins may have.
const SAMPLED: f32 = 0.4;

/// For parallel rays: the largest depth of an origin, as a multiple of the sampled depths.
const DEEPER: f32 = 2.0;

/// Parallel rays are not projected if their origins are this many times as far apart along the rays as
/// across (2^12): the points would not be known well enough.
const SLANTED: f32 = (1 << 12) as f32;

/// The same limit for the coordinates of the origins (2^18): boxes would be too wide.
const FAR_OUT: f32 = (1 << 18) as f32;

/// The same limit for the coordinates of the scene (2^58): products would overflow.
const FARTHEST: f32 = (1_u64 << 58) as f32;

/// The largest extent of parallel rays, and the inverse of the smallest (2^30).
const LARGEST_SPREAD: f32 = (1 << 30) as f32;

/// Creates a frame for the rays of a bundle.
#[inline(always)]
pub(super) fn frame<S: Simd>(
    filter: &Filter<'_>,
    rays: &BundleRays<'_>,
    reach: f32,
) -> Option<Frame> {
    let (all, common) = (rays.rays, rays.common);
    let origin = match common {
        Common::Origin => all[0].origin,
        Common::End(end) => end.point,
        Common::Direction { reversed } => {
            let frame = frame_along::<S>(all, reversed, reach)?;
            return Some(frame.level_along(filter.level_axes(all, rays.first)));
        }
    };
    let [first, second] = [all[0].dir, all[1].dir];
    // A sample is enough to estimate the centre and spread: any frame gives correct results, and a
    // good frame only makes tracing faster.
    let (apart, mut sum) = (all.len().div_ceil(SAMPLE), [S::F32x16::splat(0.0); 3]);
    let mut spread = Spread::about(first);
    for begin in (0..all.len()).step_by(16 * apart) {
        let some = |i: usize| half(&all[(begin + i * apart).min(all.len() - 1)], 1);
        let [x, y, z, _] = S::columns(some);
        sum = [sum[0] + x, sum[1] + y, sum[2] + z];
        spread.add([x, y, z]);
    }
    let sign = if common.is_reversed() { -1.0 } else { 1.0 };
    let sum = [sign * total(sum[0]), sign * total(sum[1]), sign * total(sum[2])];
    let step = [0, 1, 2].map(|k| second[k] - first[k]);
    toward(origin, sum, step, &spread, reach)
}

/// Creates a frame that looks along parallel rays or, if `backward` is set, against them. It has room
/// for a sample of the rays, and for others that are a bit farther away.
#[inline(always)]
fn frame_along<S: Simd>(all: &[Ray], backward: bool, reach: f32) -> Option<Frame> {
    let splat = S::F32x16::splat;
    let apart = all.len().div_ceil(SAMPLE);
    let begins = (0..all.len()).step_by(16 * apart);
    let some = |begin: usize, i: usize| half(&all[(begin + i * apart).min(all.len() - 1)], 0);

    // The box around the origins, and their spread.
    let first = all[0].origin;
    let (mut spread, mut lo, mut hi) =
        (Spread::about(first), [splat(f32::INFINITY); 3], [splat(f32::NEG_INFINITY); 3]);
    for begin in begins.clone() {
        let [x, y, z, _] = S::columns(
            #[inline(always)]
            |i| some(begin, i),
        );
        spread.add([x, y, z]);
        for (k, at) in [x, y, z].into_iter().enumerate() {
            (lo[k], hi[k]) = (at.min(lo[k]), at.max(hi[k]));
        }
    }
    let mut middle = [0.0; 3];
    for k in 0..3 {
        middle[k] = 0.5 * smallest::<S>(lo[k]) - 0.5 * smallest::<S>(-hi[k]);
    }
    let step = [0, 1, 2].map(|k| all[1].origin[k] - first[k]);
    let (dir, forward) = (all[0].dir, if backward { -1.0 } else { 1.0 });
    let size = dir.iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    let away = middle.iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    if !(size < LARGEST && size > 1.0 / LARGEST && away < LARGEST && reach < LARGEST_REACH) {
        return None;
    }
    let [right, _] = axes_across(unit(dir)?, step, &spread)?;

    // The extent of the origins along these axes.
    let unscaled = Frame::parallel(middle, (dir, forward), right, 1.0, 0.0);
    let (mut across, mut deep) = (splat(0.0), splat(0.0));
    for begin in begins {
        let [x, y, z, _] = S::columns(
            #[inline(always)]
            |i| some(begin, i),
        );
        let at = unscaled.origins(Vec3 { x, y, z });
        (across, deep) = (across.max(at.x.abs()).max(at.y.abs()), deep.max(at.z.abs()));
    }
    let [across, deep] = [-smallest::<S>(-across), -smallest::<S>(-deep)];
    let length = unscaled.parallel_rays()?.length;
    let is_wide = across.max(deep * length) < LARGEST_SPREAD
        && across > 1.0 / LARGEST_SPREAD
        && SLANTED * across > deep * length
        && FAR_OUT * across > away
        && FARTHEST * across > reach;
    let deep = DEEPER * deep + across / length;
    is_wide.then(|| Frame::parallel(middle, (dir, forward), right, SAMPLED / across, deep))
}

/// Creates a frame that looks along `sum`. One of its axes follows the direction in which the rays
/// spread most or, if no direction stands out, `step`. Returns `None` if there is no direction, or
/// if coordinates are too large.
#[inline(always)]
fn toward<F: Lanes<Scalar = f32>>(
    origin: [f32; 3],
    sum: [f32; 3],
    step: [f32; 3],
    spread: &Spread<F>,
    reach: f32,
) -> Option<Frame> {
    if reach >= LARGEST_REACH || origin.iter().any(|x| x.abs() >= LARGEST) {
        return None;
    }
    let depth = unit(sum)?;
    let [right, up] = axes_across(depth, step, spread)?;
    Some(Frame::new(origin, depth, right, up))
}

/// Chooses two axes perpendicular to `depth`. One of them follows the direction of the spread or, if no
/// direction stands out, `step`.
#[inline(always)]
fn axes_across<F: Lanes<Scalar = f32>>(
    depth: [f32; 3],
    step: [f32; 3],
    spread: &Spread<F>,
) -> Option<[[f32; 3]; 2]> {
    let axes = across(depth, step)?;
    // With an axis along the spread, the bounding rectangles of packets are tight
    // (`principal_axis`).
    match spread.principal_axis(axes) {
        Some(axis) => across(depth, axis),
        None => Some(axes),
    }
}

/// Returns two orthogonal axes perpendicular to `depth`. The first is as close as possible to the
/// direction of `step`.
fn across(depth: [f32; 3], step: [f32; 3]) -> Option<[[f32; 3]; 2]> {
    let along = dot(step, depth);
    let right = unit([0, 1, 2].map(|k| step[k] - along * depth[k]))
        // If the step is almost parallel to the depth axis, the remainder is small and its
        // direction is mostly rounding error.
        .filter(|right| dot(*right, depth).abs() < 1e-6)
        .or_else(|| unit(cross(depth, [1.0, 0.0, 0.0])))
        .or_else(|| unit(cross(depth, [0.0, 1.0, 0.0])))?;
    Some([right, cross(depth, right)])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the normalized vector, or `None` if the vector's length is almost zero or not finite.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let square = dot(v, v);
    let sane = square > f32::MIN_POSITIVE * LARGEST && square < f32::MAX;
    sane.then(|| v.map(|x| x / square.sqrt()))
}
