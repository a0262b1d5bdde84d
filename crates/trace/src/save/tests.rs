//! Tests that saved hierarchies load unchanged, and that damaged ones are rejected or still load as
//! sound hierarchies.

use intertri::{Mode, Ray, Triangle};

use super::format::{ENTRY, HEADER, OPTIONAL};
use super::seal;
use crate::util::test_numbers::random;
use crate::{Bvh, LoadError};

/// Returns random triangles. Some are needles, some coincide, some are degenerate, and some are not
/// finite.
fn soup(count: usize) -> Vec<Triangle> {
    let mut number = random();
    let mut triangles: Vec<Triangle> = (0..count)
        .map(|_| {
            let at = [(); 3].map(|()| number() * 4.0 - 2.0);
            Triangle([(); 3].map(|()| at.map(|x| x + number() * 0.3)))
        })
        .collect();
    for i in (0..count).step_by(7) {
        match i / 7 % 5 {
            0 => triangles[i].0[2] = triangles[i].0[1],
            1 => triangles[i].0[1][2] = f32::NAN,
            2 => triangles[i] = triangles[i / 2],
            // Needles, whose boxes are padded.
            3 => triangles[i] = Triangle([[0.0; 3], [1.0, 1e-9, 0.5], [2.0, 3e-9, 1.0]]),
            _ => triangles[i] = Triangle([[0.1; 3], [1.1, 0.1, 0.1], [2.1, 0.100_000_01, 0.1]]),
        }
    }
    triangles
}

fn rays(count: usize) -> Vec<Ray> {
    let mut number = random();
    let mut point = move || [(); 3].map(|()| number() * 5.0 - 2.5);
    (0..count).map(|_| Ray::new(point(), point())).collect()
}

/// Asserts that two hierarchies return the same results.
fn assert_same(a: &Bvh, b: &Bvh) {
    assert_eq!(
        (a.len(), a.bounds(), a.tree.stack, a.tree.reach),
        (b.len(), b.bounds(), b.tree.stack, b.tree.reach)
    );
    for ray in rays(200) {
        assert_eq!(a.all(&ray), b.all(&ray));
        assert_eq!(
            a.query().mode(Mode::certified()).closest(&ray),
            b.query().mode(Mode::certified()).closest(&ray)
        );
        let near = |bvh: &Bvh| bvh.closest_point(ray.origin, f64::INFINITY);
        assert_eq!(near(a), near(b));
    }
}

#[test]
fn geometries_and_masks_are_saved() {
    let soup = soup(3000);
    for meshes in [vec![&soup[..]], vec![&soup[..99], &[], &soup[99..]], vec![&[][..], &[]], vec![]]
    {
        let mut bvh = Bvh::from_meshes(&meshes).unwrap();
        if !meshes.is_empty() {
            bvh.set_mask(0, 0b110);
        }
        let bytes = bvh.to_bytes();
        let loaded = Bvh::<f32>::from_bytes(&bytes).unwrap();
        assert_same(&bvh, &loaded);
        assert_eq!(bvh.geometries(), loaded.geometries());
        assert!(bytes == loaded.to_bytes());
        for ray in rays(200) {
            let of = |bvh: &Bvh| bvh.query().mask(0b001).closest(&ray);
            assert_eq!(of(&bvh), of(&loaded));
        }
    }

    // Claim that a geometry has one triangle too many.
    let mut bytes = Bvh::from_meshes(&[&soup[..9], &soup[9..99]]).unwrap().to_bytes();
    let last = bytes.len() - 16;
    bytes[last] += 1;
    seal(&mut bytes);
    let error = Bvh::<f32>::from_bytes(&bytes).unwrap_err().to_string();
    assert!(error.contains("geometries"), "{error}");
}

#[test]
fn what_is_saved_is_loaded() {
    for count in [0, 1, 2, 8, 9, 100, 3000, 20_000] {
        let bvh = Bvh::new(&soup(count)).unwrap();
        let bytes = bvh.to_bytes();
        let loaded = Bvh::<f32>::from_bytes(&bytes).unwrap();
        assert_same(&bvh, &loaded);
        assert!(bytes == loaded.to_bytes(), "{count}");
        let streamed = Bvh::<f32>::read_from(&*[&bytes[..], b"and more"].concat()).unwrap();
        assert!(bytes == streamed.to_bytes(), "{count}");
        let bits = |t: &Triangle| t.0.map(|corner| corner.map(f32::to_bits));
        let (one, other) = (bvh.to_triangles(), loaded.to_triangles());
        assert!(one.iter().map(bits).eq(other.iter().map(bits)));
    }
}

#[test]
fn the_same_bytes_everywhere() {
    let bytes = Bvh::new(&soup(5000)).unwrap().to_bytes();
    assert_eq!(super::checksum::checksum(&bytes), GOLDEN, "of {} bytes", bytes.len());
    #[cfg(feature = "parallel")]
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let other = pool.install(|| Bvh::<f32>::from_bytes(&bytes).unwrap().to_bytes());
        assert!(bytes == other);
    }
}

/// The checksum of a saved soup of 5000 triangles. It changes if the builder or the format changes.
/// If the format changes, increment the version.
const GOLDEN: u64 = 491_421_215_413_427_236;

#[test]
fn files_are_loaded() {
    let bvh = Bvh::new(&soup(3000)).unwrap();
    let path = std::env::temp_dir().join(format!("intertri-saved-{}", std::process::id()));
    std::fs::write(&path, bvh.to_bytes()).unwrap();
    let loaded = Bvh::<f32>::load(&path);
    std::fs::write(&path, [bvh.to_bytes(), vec![0]].concat()).unwrap();
    let longer = Bvh::<f32>::load(&path);
    std::fs::write(&path, &bvh.to_bytes()[..9999]).unwrap();
    let shorter = Bvh::<f32>::load(&path);
    std::fs::remove_file(&path).unwrap();
    assert_same(&bvh, &loaded.unwrap());
    assert!(matches!(longer, Err(LoadError::Damaged { .. })));
    assert!(matches!(shorter, Err(LoadError::CutOff)));
    assert!(matches!(Bvh::<f32>::load(&path), Err(LoadError::Io(_))));
}

#[test]
fn every_cut_and_every_damage_is_told() {
    let bytes = Bvh::new(&soup(60)).unwrap().to_bytes();
    for end in 0..bytes.len() {
        let error = Bvh::<f32>::from_bytes(&bytes[..end]).unwrap_err();
        let expected = if end < HEADER {
            "is not a saved hierarchy (bad magic number)"
        } else {
            "the saved hierarchy is cut off"
        };
        assert_eq!(error.to_string(), expected, "{end}");
        assert!(Bvh::<f32>::read_from(&bytes[..end]).is_err());
    }
    let mut damaged = bytes.clone();
    for bit in 0..8 * bytes.len() {
        damaged[bit / 8] ^= 1 << (bit % 8);
        let error = Bvh::<f32>::from_bytes(&damaged).expect_err("a bit is flipped").to_string();
        assert!(error.len() < 120 && !error.contains('\n'), "{error}");
        damaged[bit / 8] = bytes[bit / 8];
    }
    assert!(Bvh::<f32>::from_bytes(&damaged).is_ok());
}

/// Changes one word of a saved hierarchy at a time and recomputes all checksums. Loading the result
/// must return an error or a sound hierarchy.
#[test]
fn no_word_makes_an_answer_wrong() {
    let triangles = soup(120);
    let bytes = Bvh::new(&triangles).unwrap().to_bytes();
    let (mut loaded, mut refused) = (0, 0);
    for word in 0..bytes.len() / 4 {
        for value in [0, 1, 7, u32::MAX, 1 << 31, 0x7fc0_0000, 0x3f80_0000, 0xff80_0000] {
            let mut changed = bytes.clone();
            changed[4 * word..4 * word + 4].copy_from_slice(&value.to_le_bytes());
            seal(&mut changed);
            let Ok(bvh) = Bvh::<f32>::from_bytes(&changed) else {
                refused += 1;
                continue;
            };
            loaded += 1;
            // The results must equal those of a new tree over the same triangles.
            let anew = Bvh::new(&bvh.to_triangles()).unwrap();
            for ray in &rays(4) {
                let mode = Mode::exact();
                assert_eq!(
                    bvh.query().mode(mode).all(ray),
                    anew.query().mode(mode).all(ray),
                    "word {word} is {value:x}"
                );
            }
        }
    }
    assert!(loaded > 1000 && refused > 1000, "{loaded} loaded, {refused} refused");
}

fn changed(bytes: &[u8], at: usize, to: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + to.len()].copy_from_slice(to);
    seal(&mut bytes);
    bytes
}

#[test]
fn other_versions_are_told() {
    let bytes = Bvh::new(&soup(60)).unwrap().to_bytes();
    let text = |bytes: &[u8]| Bvh::<f32>::from_bytes(bytes).unwrap_err().to_string();
    assert!(text(&changed(&bytes, 8, &[3])).contains("newer version"));
    // Version 1 may have omitted triangles with zero area.
    assert!(text(&changed(&bytes, 8, &[1])).contains("version 1"));
    // The third section lists the omitted triangles. Give it an unknown kind, once required and
    // once optional.
    let kind = HEADER + 2 * ENTRY;
    assert!(text(&changed(&bytes, kind, &7_u32.to_le_bytes())).contains("kind 7"));
    let optional = changed(&bytes, kind, &(7 | OPTIONAL).to_le_bytes());
    assert!(text(&optional).contains("numbers"), "no triangle was left out");
    let none_left_out = Bvh::new(&soup(1)[..0]).unwrap().to_bytes();
    assert!(
        Bvh::<f32>::from_bytes(&changed(&none_left_out, kind, &(7 | OPTIONAL).to_le_bytes()))
            .is_ok()
    );
}

/// A count in a header must not determine how much memory is allocated.
#[test]
fn promises_need_no_memory() {
    let bytes = Bvh::new(&soup(60)).unwrap().to_bytes();
    // Claim that the leaf section holds two billion leaves.
    let mut long = bytes.clone();
    let (nodes, leaves, left_out) = (HEADER, HEADER + ENTRY, HEADER + 2 * ENTRY);
    let size = 320 * ((1_u64 << 31) - 8);
    long[leaves + 16..leaves + 24].copy_from_slice(&size.to_le_bytes());
    let word = |at: usize| u64::from_le_bytes(long[at..at + 8].try_into().unwrap());
    let place = (word(leaves + 8) + size).next_multiple_of(64);
    let end = place + word(left_out + 16);
    assert!(word(nodes + 8) > 0);
    long[left_out + 8..left_out + 16].copy_from_slice(&place.to_le_bytes());
    long[40..48].copy_from_slice(&end.to_le_bytes());
    // Recompute only the checksum of the header; the sections are missing.
    let front = [&long[..HEADER - 8], &long[HEADER..HEADER + 3 * ENTRY]].concat();
    let sum = super::checksum::checksum(&front);
    long[HEADER - 8..HEADER].copy_from_slice(&sum.to_le_bytes());
    assert!(matches!(Bvh::<f32>::from_bytes(&long), Err(LoadError::CutOff)));
    assert!(matches!(Bvh::<f32>::read_from(&*long), Err(LoadError::CutOff)));
}

#[test]
fn subnormal_triangles_are_saved_and_loaded() {
    // Boxes with sides at 0 and at the first few subnormal numbers, in many combinations.
    let mut number = random();
    let mut side =
        || f32::from_bits((number() * 4.0) as u32) * if number() < 0.5 { -1.0 } else { 1.0 };
    for _ in 0..300 {
        let soup: Vec<Triangle> =
            (0..40).map(|_| Triangle([(); 3].map(|()| [(); 3].map(|()| side())))).collect();
        let bvh = Bvh::new(&soup).unwrap();
        assert_same(&bvh, &Bvh::from_bytes(&bvh.to_bytes()).unwrap());
    }
}
