//! Saved hierarchies: whatever the bytes are, an error or a hierarchy that answers rightly.

use intertri::{Certified, Exact, Ray, Triangle};
use intertri_trace::internal::seal;
use intertri_trace::{Bvh, SAVED_MAGIC};

use super::input::Input;

/// The first byte chooses: a file as it is, the same with its checksums mended, or a scene that is saved, damaged
/// here and there, and mended.
pub fn saved(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else { return };
    match first % 4 {
        0 => loaded(rest, rest),
        1 => {
            let mut file = [&SAVED_MAGIC[..], rest].concat();
            seal(&mut file);
            loaded(&file, rest);
        }
        _ => damaged(rest),
    }
}

/// A scene that is saved, damaged at some words, and mended.
fn damaged(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let triangles = input.triangles(60);
    let mut bvh = Bvh::new(&triangles).unwrap();
    if input.below(2) == 1 {
        // The triangles of another order are in no tree that was built.
        let moved: Vec<Triangle> = (0..triangles.len()).map(|_| input.one_of(&triangles)).collect();
        bvh.refit(&moved).unwrap();
    }
    let mut file = bvh.to_bytes();
    assert!(Bvh::from_bytes(&file).unwrap().to_bytes() == file);
    for _ in 0..input.below(6) {
        let at = 4 * input.below(file.len() / 4);
        let word = u32::from_le_bytes(file[at..at + 4].try_into().unwrap());
        let to = match input.below(5) {
            0 => input.number().to_bits(),
            1 => input.below(64) as u32,
            2 => word ^ 1 << input.below(32),
            3 => word.wrapping_add_signed(input.within(3)),
            _ => input.below(64) as u32 | 1 << 31,
        };
        file[at..at + 4].copy_from_slice(&to.to_le_bytes());
    }
    let end = file.len() - if input.below(8) == 0 { input.below(file.len()) } else { 0 };
    seal(&mut file[..end]);
    loaded(&file[..end], bytes);
}

/// Loads a file; what it holds must answer as a hierarchy that is built over the same triangles.
fn loaded(file: &[u8], more: &[u8]) {
    let mut bvh = match Bvh::from_bytes(file) {
        Ok(bvh) => bvh,
        Err(error) => {
            let text = error.to_string();
            assert!(text.len() < 200 && !text.contains(char::is_control), "{text:?}");
            return;
        }
    };
    let triangles = bvh.to_triangles();
    if triangles.len() > 2000 {
        return;
    }
    let mut input = Input::new(more);
    let all = if triangles.is_empty() { vec![Triangle([[0.0; 3]; 3])] } else { triangles.clone() };
    let rays: Vec<Ray> = (0..8).map(|_| input.ray(&all)).collect();
    same(&bvh, &Bvh::new(&triangles).unwrap(), &rays);
    assert!(Bvh::from_bytes(&bvh.to_bytes()).is_ok());

    // What was loaded can be moved.
    let moved: Vec<Triangle> = (0..triangles.len()).map(|_| input.one_of(&all)).collect();
    bvh.refit(&moved).unwrap();
    same(&bvh, &Bvh::new(&moved).unwrap(), &rays);
}

fn same(one: &Bvh, other: &Bvh, rays: &[Ray]) {
    let (exact, certified) = (Exact::default(), Certified::default());
    for ray in rays {
        assert_eq!(one.all(&exact, ray), other.all(&exact, ray), "{ray:?}");
        assert_eq!(one.closest(&exact, ray), other.closest(&exact, ray), "{ray:?}");
        assert_eq!(one.closest(&certified, ray), other.closest(&certified, ray), "{ray:?}");
        let near = |bvh: &Bvh| bvh.closest_point(ray.origin, f64::INFINITY);
        assert_eq!(near(one), near(other), "{:?}", ray.origin);
    }
    let closest = |bvh: &Bvh| {
        let mut hits = vec![intertri::Hit::MISS; rays.len()];
        bvh.closest_batch(&exact, rays, &mut hits);
        hits
    };
    assert_eq!(closest(one), closest(other));
}
