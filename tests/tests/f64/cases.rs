//! Generates f64 rays and triangles whose intersections are hard to decide.

use intertri::{Ray64, Triangle64};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;

/// The number of kinds of pairs that [`case`] generates.
pub(crate) const KINDS: usize = 15;

/// Generates a pair of the given kind.
pub(crate) fn case(kind: usize, rng: &mut Rng) -> (Ray64, Triangle64) {
    match kind {
        0 => in_f32(rng),
        1 => any(rng),
        2 => aimed(rng, Rng::signed),
        3 => aimed(rng, |rng| f64::from(rng.within(4))),
        4 => aimed(rng, |rng| f64::from(rng.within(1 << 10)) / 1024.0),
        5 => aimed(rng, |rng| f64::from_bits(rng.bits() >> 12) * sign(rng)),
        6 => aimed(rng, |rng| f64::MAX * rng.signed()),
        7 => aimed(rng, |rng| rng.signed() * 2.0_f64.powi(rng.within(1000))),
        8 => aimed(rng, |rng| rng.signed() * 2.0_f64.powi(rng.within(3) * 40)),
        9 => aimed(rng, |rng| 528_980.0 + rng.signed()),
        10 => aimed(rng, |rng| 1e12 * f64::from(rng.within(1)) + rng.signed()),
        11 => aimed(rng, |rng| rng.signed() * 2.0_f64.powi(-240 + rng.within(60))),
        12 => in_plane(rng),
        13 => sliver(rng),
        _ => duplicated(rng),
    }
}

fn sign(rng: &mut Rng) -> f64 {
    if rng.one_in(2) { 1.0 } else { -1.0 }
}

fn vector(rng: &mut Rng, number: &mut impl FnMut(&mut Rng) -> f64) -> [f64; 3] {
    [number(rng), number(rng), number(rng)]
}

/// Generates a pair from a family, converted to f64 and moved, so that its coordinates use more
/// digits.
fn in_f32(rng: &mut Rng) -> (Ray64, Triangle64) {
    let case = rng.pick(FAMILIES).case(rng);
    let moved = rng.pick(&[0.0, 1e3, 1e6, 1e9, 1e12]);
    let at = |v: [f32; 3]| v.map(|x| f64::from(x) + moved);
    let ray = Ray64::new(at(case.ray.origin), case.ray.dir.map(f64::from));
    let ray = ray.between(f64::from(case.ray.t_min), f64::from(case.ray.t_max));
    (ray, Triangle64(case.triangle.0.map(at)))
}

/// Generates a ray and a triangle whose coordinates have arbitrary bit patterns.
fn any(rng: &mut Rng) -> (Ray64, Triangle64) {
    let mut bits = |rng: &mut Rng| {
        // Keep some of the numbers that are not finite.
        let x = f64::from_bits(rng.bits());
        if x.is_finite() || rng.one_in(4) { x } else { f64::from(rng.within(2)) }
    };
    let ray = Ray64::new(vector(rng, &mut bits), vector(rng, &mut bits));
    (ray, Triangle64([(); 3].map(|()| vector(rng, &mut bits))))
}

/// Generates a triangle, and a ray toward a corner, a point on an edge, a point inside, or an
/// arbitrary point. The ray starts at an arbitrary point, at a corner, or at the coordinate origin,
/// where computing the direction involves no subtraction error.
fn aimed(rng: &mut Rng, mut number: impl FnMut(&mut Rng) -> f64) -> (Ray64, Triangle64) {
    let triangle = Triangle64([(); 3].map(|()| vector(rng, &mut number)));
    let [c1, c2, c3] = triangle.0;
    let origin = match rng.below(16) {
        0 => c1,
        1 => c2,
        2 => [0.0; 3],
        _ => vector(rng, &mut number),
    };
    let (a, b) = (rng.unit(), rng.unit());
    let (p, q) = match rng.below(8) {
        0 => (0.0, 0.0),
        1 => (1.0, 0.0),
        2 => (0.5, 0.5),
        3 => (0.5, 0.0),
        4 => (a, 0.0),
        5 => (a, 1.0 - a),
        _ => (a, b * (1.0 - a)),
    };
    // Use a quarter of each coordinate, because the full sum may overflow f64.
    let at = |k: usize| {
        let (x, y, z) = (0.25 * c1[k], 0.25 * c2[k], 0.25 * c3[k]);
        (x + p * (y - x) + q * (z - x)) - 0.25 * origin[k]
    };
    let dir = if rng.one_in(8) { vector(rng, &mut number) } else { [at(0), at(1), at(2)] };
    (Ray64::new(origin, dir), triangle)
}

/// Generates a triangle, and a ray that starts in the triangle's plane and often lies entirely in
/// it.
fn in_plane(rng: &mut Rng) -> (Ray64, Triangle64) {
    let (axis, z) = (rng.below(3), f64::from(rng.within(3)) * 0.1);
    let flat = |rng: &mut Rng| {
        let mut v = [f64::from(rng.within(5)), rng.signed(), f64::from(rng.within(3))];
        v[axis] = z;
        v
    };
    let triangle = Triangle64([(); 3].map(|()| flat(rng)));
    let origin = flat(rng);
    let mut dir = flat(rng);
    dir[axis] = if rng.one_in(2) { 0.0 } else { 1.0 };
    (Ray64::new(origin, dir), triangle)
}

/// Generates a triangle whose corners are within a few ulps of a line, and a ray toward it.
fn sliver(rng: &mut Rng) -> (Ray64, Triangle64) {
    let (from, to) = (rng.cube(), rng.cube());
    let on = |share: f64, rng: &mut Rng| {
        [0, 1, 2].map(|k| {
            let x = from[k] + share * (to[k] - from[k]);
            f64::from_bits((x.to_bits() as i64 + i64::from(rng.within(2))) as u64)
        })
    };
    let share = rng.unit();
    let triangle = Triangle64([on(0.0, rng), on(1.0, rng), on(share, rng)]);
    let aim = rng.unit();
    let (target, origin) = (on(aim, rng), rng.cube().map(|x| 4.0 * x));
    (Ray64::new(origin, [0, 1, 2].map(|k| target[k] - origin[k])), triangle)
}

/// Generates a triangle with two or three equal corners, or a ray along one of the triangle's
/// edges.
fn duplicated(rng: &mut Rng) -> (Ray64, Triangle64) {
    let (mut ray, mut triangle) = aimed(rng, |rng| f64::from(rng.within(3)));
    match rng.below(4) {
        0 => triangle.0[2] = triangle.0[1],
        1 => triangle.0[1] = triangle.0[0],
        2 => triangle.0 = [triangle.0[0]; 3],
        _ => ray.dir = [0, 1, 2].map(|k| triangle.0[1][k] - triangle.0[0][k]),
    }
    (ray, triangle)
}
