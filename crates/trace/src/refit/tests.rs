//! Tests that a refitted hierarchy returns the same results as a newly built one.

use intertri::{Mode, Ray, Triangle};

use crate::util::test_numbers::random;
use crate::{Bvh, Refit, RefitError};

/// Returns a sphere with the given number of rings, applying `moved` to each corner.
fn ball(rings: usize, moved: impl Fn([f32; 3]) -> [f32; 3]) -> Vec<Triangle> {
    use std::f32::consts::PI;
    let corner = |i: usize, j: usize| {
        let (a, b) = (PI * i as f32 / rings as f32, PI * (j % (2 * rings)) as f32 / rings as f32);
        moved([a.sin() * b.cos(), a.cos(), a.sin() * b.sin()])
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j), corner(i + 1, j + 1)];
        [Triangle([a, b, c]), Triangle([b, d, c])]
    };
    let squares = (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j)));
    squares.flat_map(|(i, j)| square(i, j)).collect()
}

/// Checks that query results equal those of a newly built hierarchy.
fn assert_as_new(bvh: &Bvh, triangles: &[Triangle]) {
    let anew = Bvh::new(triangles).unwrap();
    assert_eq!(bvh.bounds(), anew.bounds());
    let [lo, hi] = anew.bounds().unwrap_or([[-1.0; 3], [1.0; 3]]);
    let mut number = random();
    let mut point = || {
        [0, 1, 2].map(|k| {
            let share = number() * 1.4 - 0.2;
            lo[k] * (1.0 - share) + hi[k] * share
        })
    };
    let rays: Vec<Ray> = (0..300)
        .map(|_| {
            let (from, to) = (point(), point());
            Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k]))
        })
        .collect();
    for ray in &rays {
        assert_eq!(bvh.all(ray), anew.all(ray));
        assert_eq!(bvh.closest(ray), anew.closest(ray));
        let mode = Mode::certified();
        assert_eq!(bvh.query().mode(mode).closest(ray), anew.query().mode(mode).closest(ray));
        let near = |bvh: &Bvh| bvh.closest_point(ray.origin, f64::INFINITY);
        assert_eq!(near(bvh), near(&anew));
    }

    // Trace the rays of an image to test bundles.
    let middle = [0, 1, 2].map(|k| lo[k] * 0.5 + hi[k] * 0.5);
    let eye = [0, 1, 2].map(|k| middle[k] * 2.0 + (hi[k] - lo[k]) * 1.5 + 1.0);
    let pixel = |i: usize| {
        let (x, y) = ((i % 64) as f32 / 32.0 - 1.0, (i / 64) as f32 / 32.0 - 1.0);
        let to = [middle[0] + x * (hi[0] - lo[0]), middle[1] + y * (hi[1] - lo[1]), middle[2]];
        Ray::new(eye, [0, 1, 2].map(|k| to[k] - eye[k]))
    };
    let picture: Vec<Ray> = (0..4096).map(pixel).collect();
    let hits = |bvh: &Bvh| {
        let mut hits = vec![intertri::Hit::MISS; picture.len()];
        bvh.query().closest_batch_into(&picture, &mut hits);
        hits
    };
    assert_eq!(hits(bvh), hits(&anew));

    // Saving and loading must work after a refit.
    let bytes = bvh.to_bytes();
    let loaded = Bvh::<f32>::from_bytes(&bytes).unwrap();
    assert!(loaded.to_bytes() == bytes);
    assert_eq!(loaded.tree.cost_as_built, bvh.tree.cost_as_built);
}

#[test]
fn a_ball_is_twisted_exploded_and_folded() {
    let still = |p: [f32; 3]| p;
    let mut bvh = Bvh::new(&ball(24, still)).unwrap();
    let mut last = 0.0;
    for turn in [0.0, 0.1, 0.5, 2.0, 10.0] {
        let twisted = ball(24, |[x, y, z]| {
            let (s, c) = (y * turn).sin_cos();
            [x * c - z * s, y, x * s + z * c]
        });
        let refit = bvh.refit(&twisted).unwrap();
        assert!(refit.ratio() >= last * 0.99, "{refit:?}");
        last = refit.ratio();
        assert_as_new(&bvh, &twisted);
    }

    // Move every triangle by a random offset, then fold the sphere.
    let mut number = random();
    let exploded: Vec<Triangle> = ball(24, still)
        .iter()
        .map(|t| {
            let by = [(); 3].map(|()| number() * 40.0);
            Triangle(t.0.map(|p| [0, 1, 2].map(|k| p[k] + by[k])))
        })
        .collect();
    let refit = bvh.refit(&exploded).unwrap();
    assert!(refit.is_worn() && refit.ratio() > 10.0, "{refit:?}");
    assert_as_new(&bvh, &exploded);
    let folded = ball(24, |p| p.map(|x| (x * 4096.0) % 1.0));
    bvh.refit(&folded).unwrap();
    assert_as_new(&bvh, &folded);

    // Once the triangles are back in place, the tree is as good as new.
    let back = ball(24, still);
    let Refit { cost, cost_as_built, .. } = bvh.refit(&back).unwrap();
    assert!((cost / cost_as_built - 1.0).abs() < 1e-12);
    assert_as_new(&bvh, &back);
}

/// Triangles become degenerate, unbounded needles, or non-finite, both before the build and in
/// later refits.
#[test]
fn triangles_vanish_and_come_back() {
    let whole = ball(12, |p| p);
    let mut number = random();
    let mut spoil = |triangles: &mut [Triangle], share: f32| {
        for t in triangles {
            if number() < share {
                match (number() * 6.0) as usize {
                    0 => t.0[1][1] = f32::NAN,
                    1 => t.0[2] = t.0[0],
                    2 => t.0 = [[7.0; 3]; 3],
                    3 => t.0[2] = [f32::INFINITY, 0.0, 0.0],
                    4 => t.0 = [[0.0; 3], [1.0, 1e-18, 0.0], [2.0, 3e-18, 0.0]],
                    _ => t.0 = [[0.0; 3], [1.0, 1e-9, 0.0], [2.0, 3e-9, 0.0]],
                }
            }
        }
    };
    for share in [0.02, 0.5, 0.95, 1.1] {
        let mut first = whole.clone();
        spoil(&mut first, share);
        let mut bvh = Bvh::new(&first).unwrap();
        for _ in 0..4 {
            let mut next = whole.clone();
            spoil(&mut next, share);
            bvh.refit(&next).unwrap();
            assert_as_new(&bvh, &next);
        }
        bvh.refit(&whole).unwrap();
        assert_as_new(&bvh, &whole);
    }
}

#[test]
fn the_number_of_triangles_stays() {
    let triangles = ball(4, |p| p);
    let mut bvh = Bvh::new(&triangles).unwrap();
    let (expected, found) = (triangles.len(), 5);
    let error = bvh.refit(&triangles[..5]).unwrap_err();
    assert_eq!(error, RefitError::Count { expected, found });
    assert!(error.to_string().contains("cannot be refitted to 5"));
    assert_as_new(&bvh, &triangles);
    assert!(Bvh::<f32>::new(&[]).unwrap().refit(&[]).unwrap().ratio() == 1.0);
}
