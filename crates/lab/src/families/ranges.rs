//! Families that vary the magnitude of the inputs: scale, offset, zeros, subnormals, overflow, and
//! NaN.

use intertri::{Ray, Triangle};

use super::aim::{
    Point, add, aim, aimed, around, inside, nudge, round, shoot, soup, target, weigh, wide,
};
use super::scene::Scene;
use super::shapes::triangle;
use crate::rng::Rng;

/// Returns a random triangle of a given size around a centre.
fn sized(rng: &mut Rng, centre: Point, size: f64) -> Triangle {
    Triangle([0; 3].map(|_| round(add(centre, rng.cube(), size))))
}

pub(super) fn scale(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    let shape = |rng: &mut Rng, place: Point| sized(rng, place.map(|p| p * x), x);
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let to = weigh(triangle, target(rng));
        let origin = around(rng, to, x);
        let way = add(to, wide(origin), -1.0).map(|d| d / x);
        Ray::new(origin, nudge(rng, round(way)))
    })
}

pub(super) fn offset(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    let away = rng.direction();
    let shape = |rng: &mut Rng, place| sized(rng, add(place, away, x), 1.0);
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let to = weigh(triangle, target(rng));
        let origin = around(rng, to, 1.0);
        shoot(rng, origin, to)
    })
}

pub(super) fn offset_large(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    let (away, size) = (rng.direction(), x / 10_000.0);
    aimed(rng, triangles, rays, |rng, place| {
        let centre = add(place.map(|p| p * size), away, x);
        sized(rng, centre, size)
    })
}

pub(super) fn direction(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    soup(rng, triangles, rays, triangle, |rng, triangle| {
        let ray = aim(rng, triangle);
        let [dx, dy, dz] = wide(ray.dir);
        let length = (dx * dx + dy * dy + dz * dz).sqrt();
        Ray { dir: nudge(rng, round([dx, dy, dz].map(|d| d / length * x))), ..ray }
    })
}

pub(super) fn overflow(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    // The coordinates of the centres are at most half the size, so that not all corners overflow.
    let shape = |rng: &mut Rng, _| {
        let centre = rng.cube().map(|p| p * x / 2.0);
        sized(rng, centre, x / 2.0)
    };
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let origin = round(rng.cube().map(|p| p * x));
        let to = weigh(triangle, target(rng));
        shoot(rng, origin, to)
    })
}

pub(super) fn underflow(rng: &mut Rng, x: f64, triangles: usize, rays: usize) -> Scene {
    let shape = |rng: &mut Rng, _| {
        // A third of the triangles are small along only two of the axes.
        let sizes = if rng.one_in(3) { [x, 1.0, x] } else { [x; 3] };
        Triangle([0; 3].map(|_| [0, 1, 2].map(|k| (rng.signed() * sizes[k]) as f32)))
    };
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let to = weigh(triangle, target(rng));
        let distance = if rng.one_in(2) { x } else { 1.0 };
        let origin = around(rng, to, distance);
        shoot(rng, origin, to)
    })
}

pub(super) fn zeros(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    const FEW: &[f32] = &[0.0, 0.0, -0.0, -0.0, 1.0, -1.0, 0.5, 1e-45, -1e-45, 1e-38];
    let few = |rng: &mut Rng| [0; 3].map(|_| rng.pick(FEW));
    let shape = |rng: &mut Rng, _| Triangle([0; 3].map(|_| few(rng)));
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let origin = few(rng);
        if rng.one_in(2) {
            return Ray::new(origin, few(rng));
        }
        let to = weigh(triangle, target(rng));
        shoot(rng, origin, to)
    })
}

pub(super) fn bits(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    fn any(rng: &mut Rng) -> [f32; 3] {
        [0; 3].map(|_| {
            loop {
                let x = f32::from_bits(rng.bits() as u32);
                if x.is_finite() {
                    return x;
                }
            }
        })
    }
    let shape = |rng: &mut Rng, _| Triangle([0; 3].map(|_| any(rng)));
    soup(rng, triangles, rays, shape, |rng, triangle| {
        let origin = any(rng);
        if rng.one_in(2) {
            return Ray::new(origin, any(rng));
        }
        let to = weigh(triangle, inside(rng));
        shoot(rng, origin, to)
    })
}

pub(super) fn not_finite(rng: &mut Rng, _: f64, triangles: usize, rays: usize) -> Scene {
    const ODD: &[f32] = &[f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let Scene { mut triangles, mut rays, threshold } = soup(rng, triangles, rays, triangle, aim);

    // In a scene, change one triangle in four, one ray in four, and one interval in eight. In a
    // single pair, change the triangle, the ray, the interval, or any combination of them.
    let alone = triangles.len() == 1 && rays.len() == 1;
    let which = rng.below(7) + 1;
    for triangle in &mut triangles {
        if if alone { which & 1 != 0 } else { rng.one_in(4) } {
            for _ in 0..=rng.below(2) {
                triangle.0[rng.below(3)][rng.below(3)] = rng.pick(ODD);
            }
        }
    }
    for ray in &mut rays {
        if if alone { which & 2 != 0 } else { rng.one_in(4) } {
            match rng.below(2) {
                0 => ray.origin[rng.below(3)] = rng.pick(ODD),
                _ => ray.dir[rng.below(3)] = rng.pick(ODD),
            }
        }
        if if alone { which & 4 != 0 } else { rng.one_in(8) } {
            match rng.below(2) {
                0 => ray.t_min = rng.pick(ODD),
                _ => ray.t_max = rng.pick(ODD),
            }
        }
    }
    Scene { triangles, rays, threshold }
}
