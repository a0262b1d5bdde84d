//! Tests that loading a saved scene restores it unchanged, and that loading damaged bytes either
//! fails with a one-line error or yields a sound scene.

use std::sync::Arc;

use intertri::{Ray64, Triangle64};
use intertri_trace::internal::{checksum, seal_scene};
use intertri_trace::{
    Bvh, InstanceId, SAVED_SCENE_MAGIC, Scene, SceneError, SceneLoadError, SceneMesh,
};

use crate::scenes::{KINDS, Mesh, Numbers, ONE, matrix, meshes, placed, placement};
use crate::{Pair, check};

/// The size of a saved scene's header, in bytes.
const HEADER: usize = 64;
/// The size of an entry in the table of sections, in bytes.
const ENTRY: usize = 32;

/// Returns the address of an instance's mesh, which shows whether two instances share a mesh.
fn address(scene: &Scene, id: InstanceId) -> usize {
    match scene.mesh(id).unwrap() {
        SceneMesh::F32(mesh) => Arc::as_ptr(mesh).addr(),
        SceneMesh::F64(mesh) => Arc::as_ptr(mesh).addr(),
    }
}

#[test]
fn scenes_come_back_the_same() {
    let mut numbers = Numbers(3);
    let meshes = meshes(&mut numbers);
    for kind in 0..KINDS {
        let mut pair = Pair::new();
        let ids: Vec<InstanceId> = (0..20)
            .map(|i| pair.add(&meshes[i % meshes.len()], placement(&mut numbers, kind)))
            .collect();
        // Remove all instances of one mesh and one instance of another. Their instance numbers
        // become free.
        for &id in [&ids[2], &ids[10], &ids[18]].into_iter().chain([&ids[7]]) {
            pair.remove(id);
        }
        pair.set_mask(ids[4], 0b10);
        pair.set_mask(ids[5], 0);

        let saved = pair.scene.to_bytes();
        let mut loaded = Scene::from_bytes(&saved).unwrap();
        assert_eq!(loaded.to_bytes(), saved);
        assert!(loaded.instances().eq(pair.scene.instances()) && loaded.len() == 16);
        for a in loaded.instances() {
            let state = |scene: &Scene| (scene.matrix(a), scene.mask(a), scene.contains(a));
            assert_eq!(state(&loaded), state(&pair.scene));
            for b in loaded.instances() {
                let shared = |scene: &Scene| address(scene, a) == address(scene, b);
                assert_eq!(shared(&loaded), shared(&pair.scene));
            }
        }
        std::mem::swap(&mut pair.scene, &mut loaded);
        check(&mut pair, &mut numbers, 60, "loaded");

        // Editing continues as in the saved scene: free numbers are reused in the same order, and a
        // mesh is dropped along with its last instance.
        for _ in 0..6 {
            let matrix = placement(&mut numbers, 1);
            let id = pair.add(&meshes[3], matrix);
            assert_eq!(loaded.add(meshes[3].shared.clone(), matrix), Ok(id));
        }
        for id in pair.placed.keys().copied().collect::<Vec<_>>() {
            pair.remove(id);
        }
        assert_eq!(pair.scene.remove(ids[0]), Err(SceneError::NoInstance(ids[0])));
        assert!(pair.scene.is_empty() && pair.scene.to_bytes().len() < 3000);
    }
}

/// Makes a scene with two small meshes, one of them in f64, and a free instance number.
fn small() -> Scene {
    let corners = [[0.1, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.3, 0.2, 1.0 / 3.0]];
    let triangle = |a: usize, b: usize, c: usize| Triangle64([corners[a], corners[b], corners[c]]);
    let [a, b] = [vec![triangle(0, 1, 2), triangle(1, 3, 2)], vec![triangle(0, 1, 3)]];
    let (a, b) = (Mesh::in_f64(vec![a.clone(), b.clone()]), Mesh::in_f32(&[a, b]));
    let mut scene = Scene::new();
    let at = |x: f64| matrix(ONE, [1.0, -1.5, 0.1], [x, 1e-3, 2.0 * x]);
    scene.add(a.shared.clone(), at(0.0)).unwrap();
    let removed = scene.add(a.shared.clone(), at(1.0)).unwrap();
    scene.add(b.shared, at(-2.0)).unwrap();
    let masked = scene.add(a.shared, at(0.1)).unwrap();
    scene.set_mask(masked, 0b110).unwrap();
    scene.remove(removed).unwrap();
    scene
}

/// A saved scene must have the same bytes on every machine. If the format changes, its version must
/// be incremented.
#[test]
fn the_format_is_the_specified_one() {
    let bytes = small().to_bytes();
    assert_eq!((bytes.len(), checksum(&bytes)), (FORMAT.0, FORMAT.1));
    assert!(bytes.starts_with(&SAVED_SCENE_MAGIC));
    let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    assert_eq!([16, 24, 32].map(word), [4, 2, 0]);
    // Each mesh is stored as a saved hierarchy.
    let mesh = (word(40) as usize).next_multiple_of(64);
    let bvh = Bvh::<f64>::read_from(&bytes[mesh..]).unwrap();
    assert_eq!((bvh.len(), bvh.geometries()), (3, 2));
}

/// The length and checksum of the scene from `small` when it is saved.
const FORMAT: (usize, u64) = (2888, 15_097_455_072_652_631_154);

#[test]
fn every_cut_and_every_damage_is_an_error() {
    let good = small().to_bytes();
    let refused = |bytes: &[u8], what: &str| {
        let errors = [Scene::from_bytes(bytes), Scene::read_from(bytes)];
        for error in errors.map(|read| read.expect_err(what).to_string()) {
            assert!(!error.contains('\n') && error.len() < 120, "{error}");
        }
    };
    for end in 0..good.len() {
        refused(&good[..end], &format!("cut at {end}"));
    }
    for place in 0..good.len() {
        for bit in 0..8 {
            let mut bytes = good.clone();
            bytes[place] ^= 1 << bit;
            refused(&bytes, &format!("bit {bit} of byte {place}"));
        }
    }
    // Trailing bytes are an error, except in a stream.
    let longer = [&good[..], b"x"].concat();
    assert!(matches!(Scene::from_bytes(&longer), Err(SceneLoadError::Damaged { .. })));
    assert!(Scene::read_from(&longer[..]).is_ok());
    assert!(matches!(Scene::from_bytes(b"solid"), Err(SceneLoadError::NotSaved)));
    let mesh = Bvh::<f32>::new(&[]).unwrap().to_bytes();
    assert!(matches!(Scene::from_bytes(&mesh), Err(SceneLoadError::NotSaved)));
    let mut newer = good.clone();
    newer[8] = 2;
    assert!(matches!(Scene::from_bytes(&newer), Err(SceneLoadError::Newer { .. })));
}

/// Replacing a mesh with a mesh from another scene is an error, even if the new mesh is intact.
#[test]
fn meshes_cannot_be_exchanged() {
    let good = small().to_bytes();
    let first =
        (u64::from_le_bytes(good[40..48].try_into().unwrap()) as usize).next_multiple_of(64);
    let mut other = Bvh::<f64>::read_from(&good[first..]).unwrap();
    let size = other.to_bytes().len();
    other.set_mask(0, 0b1000);
    let other = other.to_bytes();
    assert_eq!(other.len(), size);
    let exchanged = [&good[..first], &other[..], &good[first + size..]].concat();
    let error = Scene::from_bytes(&exchanged).unwrap_err().to_string();
    assert_eq!(error, "the saved scene is damaged: its meshes do not belong together");
}

/// If a word is changed and the checksums are updated to match, loading must either fail or yield a
/// sound scene.
#[test]
fn no_word_makes_an_answer_wrong() {
    let good = small().to_bytes();
    let sections = u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    let end = u64::from_le_bytes(good[40..48].try_into().unwrap()) as usize;
    assert_eq!(sections, 3);
    let ray = Ray64::new([0.2, -0.4, -9.0], [0.003, 0.001, 1.0]);
    let mut loaded = 0;
    for place in (0..end).step_by(4) {
        let was = u32::from_le_bytes(good[place..place + 4].try_into().unwrap());
        let words = [0, 1, 2, 3, 4, 1 << 31, u32::MAX, u32::MAX >> 1, 0x7ff0_0000, 0xfff8_0000];
        for word in
            words.into_iter().chain([was ^ 1, was.wrapping_add(1), was.wrapping_sub(1), was << 1])
        {
            let mut bytes = good.clone();
            bytes[place..place + 4].copy_from_slice(&word.to_le_bytes());
            seal_scene(&mut bytes);
            let (scene, streamed) = (Scene::from_bytes(&bytes), Scene::read_from(&bytes[..]));
            let Ok(scene) = scene else {
                assert!(streamed.is_err() || word == was, "{place} {word}");
                continue;
            };
            // Queries must return every hit on the triangles that the scene contains.
            let mut all = Vec::new();
            for id in scene.instances() {
                let m = scene.matrix(id).unwrap();
                let flat = |t: Triangle64| Triangle64(t.0.map(|corner| placed(&m, corner)));
                let triangles: Vec<Triangle64> = match scene.mesh(id).unwrap() {
                    SceneMesh::F64(mesh) => mesh.to_triangles().into_iter().map(flat).collect(),
                    SceneMesh::F32(mesh) => {
                        let exact = |x: [f32; 3]| x.map(f64::from);
                        mesh.to_triangles()
                            .into_iter()
                            .map(|t| flat(Triangle64(t.0.map(exact))))
                            .collect()
                    }
                };
                if scene.mask(id) != Some(0) {
                    all.extend(triangles);
                }
            }
            let flat = Bvh::new(&all).unwrap();
            let snapshot = scene.commit().unwrap();
            let expected: Vec<f64> = flat.all(&ray).iter().map(|hit| hit.t).collect();
            let found: Vec<f64> = snapshot.all(&ray).iter().map(|hit| hit.hit.t).collect();
            assert_eq!(found, expected, "{place} {word}");
            loaded += 1;
        }
    }
    assert!(loaded > 100, "{loaded}");
    // Sections that claim to contain more records than the file has bytes must be rejected.
    let mut bytes = good;
    for entry in 0..sections {
        let at = HEADER + entry * ENTRY + 16;
        bytes[at..at + 8].copy_from_slice(&(104_u64 << 30).to_le_bytes());
    }
    seal_scene(&mut bytes);
    assert!(Scene::from_bytes(&bytes).is_err());
}
