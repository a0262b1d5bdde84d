//! Generates rays and triangles whose intersections are hard to decide.

use intertri::{Ray, Triangle};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;

/// The number of kinds of pairs that [`case`] generates.
pub(crate) const KINDS: usize = 13;

/// Generates a pair of the given kind.
pub(crate) fn case(kind: usize, rng: &mut Rng) -> (Ray, Triangle) {
    match kind {
        0 => {
            let case = rng.pick(FAMILIES).case(rng);
            (case.ray, case.triangle)
        }
        1 => any(rng),
        2 => aimed(rng, |rng| rng.signed() as f32),
        3 => aimed(rng, |rng| rng.within(4) as f32),
        4 => aimed(rng, |rng| (rng.within(1 << 10) as f32 / 1024.0).powi(3)),
        5 => aimed(rng, |rng| f32::from_bits(rng.below(1 << 24) as u32) * sign(rng)),
        6 => aimed(rng, |rng| f32::MAX * (rng.signed() as f32)),
        7 => aimed(rng, |rng| rng.signed() as f32 * 2.0_f32.powi(rng.within(126))),
        8 => aimed(rng, |rng| rng.signed() as f32 * 2.0_f32.powi(rng.within(3) * 19)),
        9 => in_plane(rng),
        10 => sliver(rng),
        11 => duplicated(rng),
        _ => lost_normal(rng),
    }
}

fn sign(rng: &mut Rng) -> f32 {
    if rng.one_in(2) { 1.0 } else { -1.0 }
}

fn vector(rng: &mut Rng, number: &mut impl FnMut(&mut Rng) -> f32) -> [f32; 3] {
    [number(rng), number(rng), number(rng)]
}

/// Generates a ray and a triangle whose coordinates have arbitrary bit patterns.
fn any(rng: &mut Rng) -> (Ray, Triangle) {
    let mut bits = |rng: &mut Rng| {
        // Keep some of the numbers that are not finite.
        let x = f32::from_bits(rng.bits() as u32);
        if x.is_finite() || rng.one_in(4) { x } else { rng.within(2) as f32 }
    };
    let ray = Ray::new(vector(rng, &mut bits), vector(rng, &mut bits));
    (ray, Triangle([(); 3].map(|()| vector(rng, &mut bits))))
}

/// Generates a triangle, and a ray toward a corner, a point on an edge, a point inside, or an
/// arbitrary point. The ray starts at an arbitrary point, at a corner, or at the coordinate origin,
/// where computing the direction involves no subtraction error.
fn aimed(rng: &mut Rng, mut number: impl FnMut(&mut Rng) -> f32) -> (Ray, Triangle) {
    let triangle = Triangle([(); 3].map(|()| vector(rng, &mut number)));
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
    let at = |k: usize| {
        let (x, y, z) = (f64::from(c1[k]), f64::from(c2[k]), f64::from(c3[k]));
        ((x + p * (y - x) + q * (z - x)) - f64::from(origin[k])) as f32
    };
    let to = [at(0), at(1), at(2)].map(|x| if x.is_finite() { x } else { 1.0 });
    let dir = if rng.one_in(8) { vector(rng, &mut number) } else { to };
    (Ray::new(origin, dir), triangle)
}

/// Generates a triangle, and a ray that starts in the triangle's plane and often lies entirely in
/// it.
fn in_plane(rng: &mut Rng) -> (Ray, Triangle) {
    let (axis, z) = (rng.below(3), rng.within(3) as f32 * 0.1);
    let flat = |rng: &mut Rng| {
        let mut v = [rng.within(5) as f32, rng.signed() as f32, rng.within(3) as f32];
        v[axis] = z;
        v
    };
    let triangle = Triangle([(); 3].map(|()| flat(rng)));
    let origin = flat(rng);
    let mut dir = flat(rng);
    dir[axis] = if rng.one_in(2) { 0.0 } else { 1.0 };
    (Ray::new(origin, dir), triangle)
}

/// Generates a triangle whose corners are within a few ulps of a line, and a ray toward it.
fn sliver(rng: &mut Rng) -> (Ray, Triangle) {
    let (from, to) = (rng.cube(), rng.cube());
    let on = |share: f64, rng: &mut Rng| {
        [0, 1, 2].map(|k| {
            let x = (from[k] + share * (to[k] - from[k])) as f32;
            f32::from_bits((x.to_bits() as i32 + rng.within(2)) as u32)
        })
    };
    let share = rng.unit();
    let triangle = Triangle([on(0.0, rng), on(1.0, rng), on(share, rng)]);
    let aim = rng.unit();
    let (target, origin) = (on(aim, rng), rng.cube().map(|x| (4.0 * x) as f32));
    (Ray::new(origin, [0, 1, 2].map(|k| target[k] - origin[k])), triangle)
}

/// Generates a triangle with two or three equal corners, or a ray along one of the triangle's
/// edges.
fn duplicated(rng: &mut Rng) -> (Ray, Triangle) {
    let (mut ray, mut triangle) = aimed(rng, |rng| rng.within(3) as f32);
    match rng.below(4) {
        0 => triangle.0[2] = triangle.0[1],
        1 => triangle.0[1] = triangle.0[0],
        2 => triangle.0 = [triangle.0[0]; 3],
        _ => ray.dir = [0, 1, 2].map(|k| triangle.0[1][k] - triangle.0[0][k]),
    }
    (ray, triangle)
}

/// Generates a triangle whose f64 normal is often zero although the triangle is not degenerate, and
/// a ray toward one of its corners.
fn lost_normal(rng: &mut Rng) -> (Ray, Triangle) {
    let (x, small) = (rng.unit() as f32 + 1.0, 2.0_f32.powi(-rng.within(5).abs() - 26));
    let mut at = |scale: f32| {
        let mut moved = |x: f32| f32::from_bits(x.to_bits() + rng.below(3) as u32);
        [moved(x * scale), moved(x * scale), 0.0]
    };
    let triangle = Triangle([at(small), [x, x, 0.0], [2.0 * x, 2.0 * x, 0.0]]);
    let [x, y, _] = rng.pick(&triangle.0);
    (Ray::new([x, y, 1.0], [0.0, 0.0, -1.0]), triangle)
}
