//! Runs an ordinary query repeatedly, to count its instructions (`.ci/instructions`):
//!
//!     cases NAME TIMES
//!
//! The difference between the counts of two runs with different TIMES is the cost of the queries
//! alone. Without arguments, the program prints all names.

use std::hint::black_box;

use intertri::{Hit, Mode, Ray, Triangle};
use intertri_lab::rng::Rng;
use intertri_scene::Scene;
use intertri_trace::Bvh;

/// The name of a case, and a function that runs 256 queries the given number of times.
type Case = (&'static str, fn(times: u64));

const CASES: [Case; 12] = [
    ("slice closest", |times| slice(times, |mode, some, ray| mode.closest(some, ray).is_some())),
    ("slice any", |times| slice(times, Mode::any)),
    ("closest", |times| single(&built_in(), &camera(), times)),
    ("closest of a batch", |times| {
        let (bvh, rays) = (built_in(), tile());
        let mut hits = vec![Hit::MISS; rays.len()];
        for _ in 0..times {
            bvh.query().closest_batch_into(black_box(&rays), &mut hits);
            black_box(&hits);
        }
    }),
    ("closest of parallel rays", |times| {
        let (bvh, rays) = (built_in(), parallel());
        let mut hits = vec![Hit::MISS; rays.len()];
        for _ in 0..times {
            bvh.query().closest_batch_into(black_box(&rays), &mut hits);
            black_box(&hits);
        }
    }),
    ("any of parallel rays", |times| {
        let (bvh, rays) = (built_in(), parallel());
        let mut any = vec![false; rays.len()];
        for _ in 0..times {
            bvh.query().any_batch_into(black_box(&rays), &mut any);
            black_box(&any);
        }
    }),
    ("any", |times| {
        let (bvh, rays) = (built_in(), scattered());
        for _ in 0..times {
            for ray in &rays {
                black_box(bvh.any(black_box(ray)));
            }
        }
    }),
    ("with a far triangle", |times| {
        let mut triangles = Scene::built_in().mesh.to_triangles();
        let far = 1e5;
        triangles.push(Triangle([[far, 0.0, 0.0], [far + 1.0, 0.0, 0.0], [far, 1.0, 0.0]]));
        single(&Bvh::new(&triangles).expect("few triangles"), &scattered(), times);
    }),
    ("poles of quads", |times| single(&ball(), &around(), times)),
    ("from far away", |times| {
        let far = |ray: Ray| {
            let origin = [0, 1, 2].map(|k| ray.origin[k] - 1e4 * ray.dir[k]);
            Ray::new(origin, ray.dir)
        };
        single(&built_in(), &camera().into_iter().map(far).collect::<Vec<_>>(), times);
    }),
    ("without a direction", |times| {
        let still = |(i, ray): (usize, Ray)| match i % 16 {
            0 => Ray { dir: [0.0; 3], ..ray },
            _ => ray,
        };
        let rays: Vec<_> = scattered().into_iter().enumerate().map(still).collect();
        single(&built_in(), &rays, times);
    }),
    ("closest point", |times| {
        let (bvh, rays) = (built_in(), scattered());
        for _ in 0..times {
            for ray in &rays {
                black_box(bvh.closest_point(black_box(ray.origin), f64::INFINITY));
            }
        }
    }),
];

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let Some(name) = args.get(1) else {
        for (name, _) in CASES {
            println!("{name}");
        }
        return;
    };
    let times = args.get(2).and_then(|times| times.parse().ok());
    let case = CASES.iter().find(|(known, _)| known == name);
    let (Some((_, run)), Some(times)) = (case, times) else { panic!("give NAME TIMES") };
    run(times);
}

/// Tests 256 rays, one after another, against a slice of 256 triangles.
fn slice(times: u64, query: fn(Mode, &[Triangle], &Ray) -> bool) {
    let mut rng = Rng::new(3);
    let mut point = |size: f64| rng.cube().map(|x| (size * x) as f32);
    let triangle = |point: &mut dyn FnMut(f64) -> [f32; 3]| {
        let (middle, mut corner) = (point(1.0), || point(0.4));
        let corners = [corner(), corner(), corner()];
        Triangle(corners.map(|c| [0, 1, 2].map(|k| middle[k] + c[k])))
    };
    let triangles: Vec<_> = (0..256).map(|_| triangle(&mut point)).collect();
    let (mode, rays) = (Mode::exact(), scattered());
    for _ in 0..times {
        for ray in &rays {
            black_box(query(mode, black_box(&triangles), ray));
        }
    }
}

/// Finds closest hits through a hierarchy, one ray after another.
fn single(bvh: &Bvh, rays: &[Ray], times: u64) {
    for _ in 0..times {
        for ray in rays {
            black_box(bvh.closest(black_box(ray)));
        }
    }
}

fn built_in() -> Bvh {
    Bvh::new(&Scene::built_in().mesh.to_triangles()).expect("few triangles")
}

/// Returns the camera rays of a 16×16 image of the built-in scene.
fn camera() -> Vec<Ray> {
    let camera = Scene::built_in().camera;
    (0..256).map(|i| camera.ray(i % 16, i / 16, 16, 16)).collect()
}

/// Returns parallel rays through 16×16 neighbouring pixels.
fn parallel() -> Vec<Ray> {
    let rays = tile();
    let dir = rays[0].dir;
    rays.into_iter()
        .map(|ray| Ray { origin: [0, 1, 2].map(|k| ray.origin[k] + ray.dir[k]), dir, ..ray })
        .collect()
}

/// Returns the camera rays of 16×16 neighbouring pixels.
fn tile() -> Vec<Ray> {
    let camera = Scene::built_in().camera;
    (0..256).map(|i| camera.ray(180 + i % 16, 180 + i / 16, 400, 400)).collect()
}

/// Returns rays in all directions from around the middle of the built-in scene.
fn scattered() -> Vec<Ray> {
    let mut rng = Rng::new(5);
    let mut ray = || {
        let [x, y, z] = rng.cube().map(|x| x as f32);
        Ray::new([x, 1.0 + 0.8 * y, z], rng.direction().map(|x| x as f32))
    };
    (0..256).map(|_| ray()).collect()
}

/// Builds a hierarchy over a ball of quads in rings. At the poles, half of the triangles are
/// needles.
fn ball() -> Bvh {
    let (around, rings) = (64, 32);
    let point = |i: usize, j: usize| {
        let turn = std::f64::consts::TAU * i as f64 / f64::from(around);
        let tilt = std::f64::consts::PI * (0.5 - j as f64 / f64::from(rings));
        [tilt.cos() * turn.sin(), tilt.sin(), tilt.cos() * turn.cos()].map(|x| x as f32)
    };
    let mut triangles = Vec::new();
    for j in 0..rings as usize {
        for i in 0..around as usize {
            let [a, b] = [point(i, j), point(i + 1, j)];
            let [c, d] = [point(i, j + 1), point(i + 1, j + 1)];
            triangles.extend([Triangle([a, c, b]), Triangle([b, c, d])]);
        }
    }
    Bvh::new(&triangles).expect("few triangles")
}

/// Returns rays that start outside that ball, toward points in a cube around its centre.
fn around() -> Vec<Ray> {
    let mut rng = Rng::new(9);
    let mut ray = || {
        let from = rng.direction().map(|x| 3.0 * x as f32);
        let to = rng.cube().map(|x| 0.8 * x as f32);
        Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))
    };
    (0..256).map(|_| ray()).collect()
}
