//! Tests that f64 hierarchies that were saved and loaded, or refitted, return the same results as
//! newly built ones.

use intertri::{Ray64, Triangle64};
use intertri_lab::rng::Rng;
use intertri_trace::internal::seal;
use intertri_trace::{Bvh, LoadError};

use super::hierarchy::soup;

/// Generates triangles, including segments, needles, duplicates, and some that are not finite.
fn mixed(count: usize, scale: f64, moved: f64, rng: &mut Rng) -> Vec<Triangle64> {
    let mut triangles = soup(count, 0.1, scale, moved, rng);
    for i in (0..count).step_by(5) {
        match i / 5 % 5 {
            0 => triangles[i].0[2] = triangles[i].0[1],
            1 => triangles[i].0[1][2] = f64::NAN,
            2 => triangles[i] = triangles[i / 2],
            3 => triangles[i].0[1][0] = f64::INFINITY,
            _ => triangles[i].0[2] = triangles[i].0[0].map(f64::next_up),
        }
    }
    triangles
}

fn rays(count: usize, scale: f64, moved: f64, rng: &mut Rng) -> Vec<Ray64> {
    let mut ray = || {
        let (from, to) = (rng.cube().map(|x| 2.0 * x), rng.cube());
        let place = |p: [f64; 3]| p.map(|x| x * scale + moved);
        Ray64::new(place(from), [0, 1, 2].map(|k| (to[k] - from[k]) * scale))
    };
    (0..count).map(|_| ray()).collect()
}

/// Asserts that two hierarchies return the same results.
fn assert_same(one: &Bvh<f64>, other: &Bvh<f64>, rays: &[Ray64], what: &str) {
    assert_eq!((one.len(), one.bounds()), (other.len(), other.bounds()), "{what}");
    assert_eq!(one.closest_batch(rays), other.closest_batch(rays), "{what}");
    for ray in rays {
        assert_eq!(one.all(ray), other.all(ray), "{what}: {ray:?}");
        assert_eq!(one.crossings(ray), other.crossings(ray), "{what}: {ray:?}");
        let near = |bvh: &Bvh<f64>| bvh.closest_point(ray.origin, f64::INFINITY);
        assert_eq!(near(one), near(other), "{what}: {ray:?}");
    }
}

#[test]
fn what_is_saved_is_loaded() {
    let mut rng = Rng::new(1);
    for (scale, moved) in [(1.0, 0.0), (3.0, 5e6), (1e-200, 0.0), (1e250, 0.0), (1e-5, 1e9)] {
        for count in [0, 1, 9, 700] {
            let bvh = Bvh::new(&mixed(count, scale, moved, &mut rng)).unwrap();
            let bytes = bvh.to_bytes();
            let loaded = Bvh::<f64>::from_bytes(&bytes).unwrap();
            let what = format!("{count} of {scale} at {moved}");
            assert_same(&bvh, &loaded, &rays(60, scale, moved, &mut rng), &what);
            assert!(bytes == loaded.to_bytes(), "{what}");
            let bits = |t: &Triangle64| t.0.map(|corner| corner.map(f64::to_bits));
            let (one, other) = (bvh.to_triangles(), loaded.to_triangles());
            assert!(one.iter().map(bits).eq(other.iter().map(bits)), "{what}");

            // A loader must report a file's scalar type as wrong before it reports any other error.
            let error = Bvh::<f32>::from_bytes(&bytes).unwrap_err();
            assert!(matches!(error, LoadError::Scalar { found: "f64" }), "{error}");
        }
    }
    let bytes = Bvh::<f32>::new(&[]).unwrap().to_bytes();
    assert!(matches!(Bvh::<f64>::from_bytes(&bytes), Err(LoadError::Scalar { found: "f32" })));
}

#[test]
fn geometries_are_saved_and_moved() {
    let mut rng = Rng::new(9);
    let soup = mixed(300, 1.0, 1e6, &mut rng);
    let mut bvh = Bvh::from_meshes(&[&soup[..100], &[], &soup[100..]]).unwrap();
    bvh.set_mask(2, 0b10);
    let rays = rays(100, 1.0, 1e6, &mut rng);
    let loaded = Bvh::<f64>::from_bytes(&bvh.to_bytes()).unwrap();
    assert_same(&bvh, &loaded, &rays, "geometries");
    assert_eq!(loaded.geometries(), 3);
    bvh.refit(&soup).unwrap();
    assert_same(&bvh, &loaded, &rays, "refitted");
    assert!(bvh.to_bytes() != loaded.to_bytes(), "a refit records the cost as built");
}

#[test]
fn every_cut_and_every_damage_is_told() {
    let bytes = Bvh::new(&mixed(30, 1.0, 1e5, &mut Rng::new(2))).unwrap().to_bytes();
    for end in 0..bytes.len() {
        assert!(Bvh::<f64>::from_bytes(&bytes[..end]).is_err());
    }
    let mut damaged = bytes.clone();
    for bit in 0..8 * bytes.len() {
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(Bvh::<f64>::from_bytes(&damaged).is_err(), "bit {bit}");
        damaged[bit / 8] = bytes[bit / 8];
    }
}

/// If a word of the file is changed and all checksums are repaired, loading must return either an
/// error or a sound hierarchy.
#[test]
fn no_word_makes_an_answer_wrong() {
    let mut rng = Rng::new(3);
    let bytes = Bvh::new(&mixed(60, 1.0, 1e5, &mut rng)).unwrap().to_bytes();
    let rays = rays(4, 1.0, 1e5, &mut rng);
    let (mut loaded, mut refused) = (0, 0);
    for word in 0..bytes.len() / 4 {
        for value in [0, 1, 7, u32::MAX, 1 << 31, 0x7ff0_0000, 0x3f80_0000, 0x40f8_6a10] {
            let mut changed = bytes.clone();
            changed[4 * word..4 * word + 4].copy_from_slice(&u32::to_le_bytes(value));
            seal(&mut changed);
            let Ok(bvh) = Bvh::<f64>::from_bytes(&changed) else {
                refused += 1;
                continue;
            };
            loaded += 1;
            let anew = Bvh::new(&bvh.to_triangles()).unwrap();
            assert_same(&bvh, &anew, &rays, &format!("word {word} is {value:x}"));
        }
    }
    assert!(loaded > 500 && refused > 500, "{loaded} loaded, {refused} refused");
}

/// Refits to triangles that are moved, scaled, rearranged or degenerate, and then back to the
/// original triangles.
#[test]
fn refits_answer_as_new_builds() {
    let mut rng = Rng::new(4);
    let first = mixed(400, 1.0, 1e6, &mut rng);
    let mut bvh = Bvh::new(&first).unwrap();
    for (i, (scale, moved)) in
        [(1.0, 1e6), (2.0, -3e9), (1e-250, 0.0), (1e280, 0.0), (1.0, 0.0)].into_iter().enumerate()
    {
        let next = if i % 2 == 0 {
            mixed(400, scale, moved, &mut rng)
        } else {
            soup(400, 0.02, scale, moved, &mut rng)
        };
        bvh.refit(&next).unwrap();
        let (anew, rays) = (Bvh::new(&next).unwrap(), rays(80, scale, moved, &mut rng));
        assert_same(&bvh, &anew, &rays, &format!("{scale} at {moved}"));
        let loaded = Bvh::<f64>::from_bytes(&bvh.to_bytes()).unwrap();
        assert_same(&bvh, &loaded, &rays, "saved as it is");
    }
    let refit = bvh.refit(&first).unwrap();
    assert!((refit.ratio() - 1.0).abs() < 1e-12, "{refit:?}");
    assert!(bvh.refit(&first[1..]).is_err());
}
