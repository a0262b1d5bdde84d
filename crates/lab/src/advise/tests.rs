//! Checks that the prediction is never optimistic, for any family, view, or grid.

use intertri::fixed::{Bits, Fixed, Grid, blocks};
use intertri::{Hit, Mode, Ray, Threshold, Triangle};

use super::{Arithmetic, PinholeCamera, SampledPixel, needs, scan};
use crate::families::FAMILIES;
use crate::meshes::Mesh;
use crate::rng::Rng;

const SIZE: (u32, u32) = (44, 33);

/// A camera at `eye` with `target` in the centre of the image.
struct Camera {
    eye: [f32; 3],
    axes: [[f64; 3]; 3],
    half_height: f64,
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

impl Camera {
    fn new(eye: [f32; 3], target: [f32; 3], up: [f64; 3], half_height: f64) -> Self {
        let forward = unit([0, 1, 2].map(|k| f64::from(target[k]) - f64::from(eye[k])));
        let right = unit(cross(forward, up));
        Self { eye, axes: [right, cross(right, forward), forward], half_height }
    }

    fn ray(&self, x: u32, y: u32) -> Ray {
        let (width, height) = SIZE;
        let half = f64::from(height) * 0.5;
        let across = (f64::from(x) + 0.5 - f64::from(width) * 0.5) / half * self.half_height;
        let above = (half - f64::from(y) - 0.5) / half * self.half_height;
        let [right, up, forward] = self.axes;
        let dir = [0, 1, 2].map(|k| forward[k] + across * right[k] + above * up[k]);
        Ray::new(self.eye, unit(dir).map(|x| x as f32))
    }
}

/// Returns, for each arithmetic, the predicted and the actual number of wrong pixels.
fn compare(what: &str, triangles: &[Triangle], camera: &Camera) -> Vec<(Arithmetic, u64, u64)> {
    let pixel = |x, y| camera.ray(x, y);
    let camera = PinholeCamera {
        eye: camera.eye,
        axes: camera.axes,
        half_height: camera.half_height,
        size: SIZE,
        ray: &pixel,
    };
    let rays: Vec<Ray> = (0..SIZE.1)
        .flat_map(|y| (0..SIZE.0).map(move |x| (x, y)))
        .map(|(x, y)| pixel(x, y))
        .collect();
    let closest = |threshold: f64| -> Vec<Hit> {
        let mode = Mode::certified_with(Threshold::new(threshold).unwrap());
        rays.iter().map(|ray| mode.closest(triangles, ray).unwrap_or(Hit::MISS)).collect()
    };
    let seen = closest(0.0);
    let threshold = needs(triangles, &camera, &seen, 1e-9).threshold;

    let mut arithmetics = vec![Arithmetic::Double { threshold }, Arithmetic::Single];
    let mut grids = vec![];
    for b in [8, 10, 13, 16, 19, 20] {
        let points = triangles.iter().flat_map(|t| t.0).chain([camera.eye]);
        if let Ok(grid) = Grid::around(points, Bits::of_grid(b).unwrap()) {
            arithmetics.push(Arithmetic::Grid { step: grid.step(), q: grid.bits().q() });
            grids.push(grid);
        }
    }
    let found = scan(triangles, &camera, &seen, &arithmetics, 1, &|_| ());
    assert_eq!(found.doubtful, found.doubtful_in_sample);

    let wrong = |answers: &mut dyn Iterator<Item = Option<u32>>| {
        let pairs = found.sample.iter().zip(answers);
        pairs.filter(|(exact, answer): &(&SampledPixel, _)| !exact.allows(*answer)).count() as u64
    };
    let told = |hit: Option<Hit>| hit.map(|hit| hit.triangle);
    let mut counted = vec![
        wrong(&mut closest(threshold).into_iter().map(Hit::some).map(told)),
        wrong(&mut found.sample.iter().map(|e| e.single)),
    ];
    for grid in grids {
        let facets: Vec<_> = triangles.iter().map(|t| grid.triangle(t).unwrap()).collect();
        let scene = blocks(&facets);
        let ask = |ray| told(Fixed::default().closest(&scene, &grid.ray(ray).unwrap()));
        counted.push(wrong(&mut rays.iter().map(ask)));
    }

    for ((arithmetic, most), counted) in arithmetics.iter().zip(&found.doubtful).zip(&counted) {
        assert!(counted <= most, "{what}, {arithmetic:?}: {counted} wrong, {most} predicted");
    }
    let each = arithmetics.into_iter().zip(found.doubtful).zip(counted);
    each.map(|((arithmetic, most), counted)| (arithmetic, most, counted)).collect()
}

#[test]
fn never_optimistic_on_any_family() {
    let (mut most, mut counted) = (0, 0);
    for family in FAMILIES {
        for seed in 0..6 {
            let mut rng = Rng::new(seed);
            let scene = family.scene(&mut rng, 24, 4);
            let finite = |t: &&Triangle| t.0.as_flattened().iter().all(|x| x.abs() < 1e15);
            let triangles: Vec<_> = scene.triangles.iter().filter(finite).copied().collect();
            let Some(ray) = scene.rays.iter().find(|ray| {
                ray.origin.iter().chain(&ray.dir).all(|x| x.is_finite()) && ray.dir != [0.0; 3]
            }) else {
                continue;
            };
            if triangles.is_empty() {
                continue;
            }
            // Half of the cameras look along one of the family's rays, half along an axis.
            let target = triangles[0].0[0];
            let mut eye = ray.origin;
            if seed % 2 == 0 {
                let size =
                    triangles[0].0.as_flattened().iter().fold(0.0, |a: f32, x| a.max(x.abs()));
                eye = target;
                eye[(seed / 2) as usize] += 4.0 * size + 1e-3 * size;
            }
            let camera = Camera::new(eye, target, [0.3, 1.0, 0.2], 0.4);
            if !camera.axes.as_flattened().iter().all(|x| x.is_finite()) {
                continue;
            }
            let what = format!("{}, seed {seed}", family.name);
            for (_, a, b) in compare(&what, &triangles, &camera) {
                most += a;
                counted += b;
            }
        }
    }
    println!("{counted} wrong, {most} predicted");
    assert!(counted > 1000, "too few wrong answers: {counted}");
}

#[test]
fn a_closed_mesh_is_predicted_within_bounds_that_are_of_use() {
    let place = |[x, y, z]: [f64; 3]| [y + 0.1 * x + 0.37, z - 0.2 * y - 0.21, x + 0.3 * z];
    let triangles = Mesh::icosphere(2).map(place).triangles();
    let camera = Camera::new([2.9, 1.3, 3.1], [0.4, -0.2, 0.0], [0.0, 1.0, 0.0], 0.4);
    let rows = compare("icosphere", &triangles, &camera);
    for (arithmetic, most, counted) in &rows {
        println!("{arithmetic:?}: {counted} of {most}");
    }
    let most = |k: usize| rows[k].1;
    // f64 has no doubtful pixels. The coarsest grid gets pixels wrong, and its bound is close
    // enough to be useful.
    assert_eq!(most(0), 0);
    assert!(most(1) <= 3);
    assert!(rows[2].2 > 20 && most(2) < 40 * rows[2].2, "{rows:?}");
    assert!(most(2) > most(3) && most(3) > most(4) && most(4) > most(5));
}
