//! Fuzzes saved hierarchies over f32 and f64. Whatever the bytes are, loading must return either an
//! error or a hierarchy that answers correctly.

use intertri::{Hit, Mode, RayOf, TriangleOf};
use intertri_trace::internal::seal;
use intertri_trace::{Bvh, BvhScalar, LoadError, SAVED_MAGIC};

use super::input::Input;

/// Loads a hierarchy and checks it. The first byte selects the input: a file as it is, a file with
/// repaired checksums, or the saved hierarchy of a scene with one or several meshes, with some
/// words damaged and the checksums repaired. The highest bit selects f64.
pub fn saved(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else { return };
    match (first % 4, first >> 7) {
        (0, _) => loaded(rest, rest),
        (1, _) => {
            let mut file = [&SAVED_MAGIC[..], rest].concat();
            seal(&mut file);
            loaded(&file, rest);
        }
        (kind, 0) => damaged::<f32>(rest, kind == 3),
        (kind, _) => damaged::<f64>(rest, kind == 3),
    }
}

/// Loads a file both as an f32 hierarchy and as an f64 hierarchy.
fn loaded(file: &[u8], more: &[u8]) {
    let scalar = |found: &Result<(), LoadError>| matches!(found, Err(LoadError::Scalar { .. }));
    let (one, other) = (answers::<f32>(file, more), answers::<f64>(file, more));
    // If the header is valid, exactly one of the two loads reports a scalar mismatch.
    assert!(!(scalar(&one) && scalar(&other)));
    assert!(!(one.is_ok() && other.is_ok()));
    assert!(scalar(&one) || scalar(&other) || (one.is_err() && other.is_err()));
}

/// Saves a scene's hierarchy, damages some words of the file, and repairs the checksums.
fn damaged<S: FuzzScalar>(bytes: &[u8], in_meshes: bool) {
    let mut input = Input::new(bytes);
    let triangles = S::triangles(&mut input, 60);
    let mut bvh = if in_meshes {
        let (one, other) = triangles.split_at(input.below(triangles.len() + 1));
        let mut bvh = Bvh::from_meshes(&[one, &[], other]).unwrap();
        bvh.set_mask(input.below(3), input.number().to_bits());
        bvh
    } else {
        Bvh::new(&triangles).unwrap()
    };
    if input.below(2) == 1 {
        // Refit to rearranged triangles, for which no build would create this tree.
        let moved: Vec<_> = (0..triangles.len()).map(|_| input.one_of(&triangles)).collect();
        bvh.refit(&moved).unwrap();
    }
    let mut file = bvh.to_bytes();
    assert!(Bvh::<S>::from_bytes(&file).unwrap().to_bytes() == file);
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

/// Loads a file. The loaded hierarchy must return the same results as one built over the same
/// triangles.
fn answers<S: FuzzScalar>(file: &[u8], more: &[u8]) -> Result<(), LoadError> {
    let mut bvh = match Bvh::<S>::from_bytes(file) {
        Ok(bvh) => bvh,
        Err(error) => {
            let text = error.to_string();
            assert!(text.len() < 200 && !text.contains(char::is_control), "{text:?}");
            return Err(error);
        }
    };
    let triangles = bvh.to_triangles();
    if triangles.len() > 2000 {
        return Ok(());
    }

    let mut input = Input::new(more);
    let nothing = [TriangleOf([[S::ZERO; 3]; 3])];
    let all = if triangles.is_empty() { &nothing[..] } else { &triangles };
    let rays: Vec<RayOf<S>> = (0..8).map(|_| S::ray(&mut input, all)).collect();

    // Every triangle belongs to one of the meshes; the queries below treat them as one mesh.
    assert!(Bvh::<S>::from_bytes(&bvh.to_bytes()).is_ok());
    let several = bvh.clone();
    bvh = bvh.into_one_mesh();
    names_are_sound(&several, &bvh, &rays);
    same(&bvh, &Bvh::new(&triangles).unwrap(), &rays);

    // Check that a loaded hierarchy can be refitted.
    let moved: Vec<_> = (0..triangles.len()).map(|_| input.one_of(all)).collect();
    bvh.refit(&moved).unwrap();
    same(&bvh, &Bvh::new(&moved).unwrap(), &rays);
    Ok(())
}

/// Checks that the hits on several meshes are a subset of the hits on the same triangles in one
/// mesh, in the same order. The ids differ, but each hit must identify the same triangle.
fn names_are_sound<S: FuzzScalar>(several: &Bvh<S>, one: &Bvh<S>, rays: &[RayOf<S>]) {
    let mut names = Vec::new();
    for ray in rays {
        let all = one.all(ray);
        let mut rest = all.iter();
        for hit in several.all(ray) {
            assert!((hit.geometry as usize) < several.geometries(), "{hit:?}");
            let triangle = several.triangle(&hit);
            let is_same = |found: &&Hit| {
                let numbers = |hit: &Hit| [hit.t, hit.u, hit.v].map(f64::to_bits);
                numbers(found) == numbers(&hit) && one.triangle(found) == triangle
            };
            let found = rest.find(is_same).expect("the single mesh has this hit");
            // Identical triangles at the same t cannot be distinguished.
            let twins = all.iter().filter(is_same).count();
            if twins == 1 {
                names.push((found.triangle, (hit.geometry, hit.triangle)));
            }
        }
    }
    names.sort_unstable();
    assert!(names.is_sorted_by_key(|(_, name)| *name), "{names:?}");
}

fn same<S: FuzzScalar>(one: &Bvh<S>, other: &Bvh<S>, rays: &[RayOf<S>]) {
    for ray in rays {
        assert_eq!(one.all(ray), other.all(ray), "{ray:?}");
        assert_eq!(one.closest(ray), other.closest(ray), "{ray:?}");
        assert_eq!(one.crossings(ray), other.crossings(ray), "{ray:?}");
        S::same_by_others(one, other, ray);
        let near = |bvh: &Bvh<S>| bvh.closest_point(ray.origin, f64::INFINITY);
        assert_eq!(near(one), near(other), "{:?}", ray.origin);
    }
    assert_eq!(one.closest_batch(rays), other.closest_batch(rays));
}

/// A scalar type for which triangles and rays can be generated from bytes.
trait FuzzScalar: BvhScalar {
    /// Generates a few triangles.
    fn triangles(input: &mut Input<'_>, at_most: usize) -> Vec<TriangleOf<Self>>;
    /// Generates a ray, often toward one of the triangles.
    fn ray(input: &mut Input<'_>, triangles: &[TriangleOf<Self>]) -> RayOf<Self>;
    /// Compares two hierarchies in the other modes that this scalar supports.
    fn same_by_others(one: &Bvh<Self>, other: &Bvh<Self>, ray: &RayOf<Self>);
}

impl FuzzScalar for f32 {
    fn triangles(input: &mut Input<'_>, at_most: usize) -> Vec<TriangleOf<Self>> {
        input.triangles(at_most)
    }

    fn ray(input: &mut Input<'_>, triangles: &[TriangleOf<Self>]) -> RayOf<Self> {
        input.ray(triangles)
    }

    fn same_by_others(one: &Bvh<Self>, other: &Bvh<Self>, ray: &RayOf<Self>) {
        let mode = Mode::certified();
        // The weights in the reference's results may be NaN, so compare bits.
        let bits = |bvh: &Bvh<Self>| {
            let number = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
            let hit = bvh.query().mode(mode).closest(ray);
            hit.map(|hit| (hit.triangle, [hit.t, hit.u, hit.v].map(number)))
        };
        assert_eq!(bits(one), bits(other), "{ray:?}");
    }
}

/// Moves and scales f32 coordinates, so that the resulting coordinates use more digits of f64.
impl FuzzScalar for f64 {
    fn triangles(input: &mut Input<'_>, at_most: usize) -> Vec<TriangleOf<Self>> {
        let triangles = input.triangles(at_most);
        let moved = input.one_of(&[0.0, 0.0, 1e6, 1e12, 1e300]);
        let scale = input.one_of(&[1.0, 1.0 / 3.0, 1e-300, 1e270]);
        let place = |x: f32| Self::from(x) * scale + moved;
        triangles.iter().map(|t| TriangleOf(t.0.map(|corner| corner.map(place)))).collect()
    }

    fn ray(input: &mut Input<'_>, triangles: &[TriangleOf<Self>]) -> RayOf<Self> {
        let [a, b, c] = input.one_of(triangles).0;
        let (shares, to) = ([input.number(), input.number()].map(Self::from), input.below(4));
        let origin =
            [0, 1, 2].map(|k| a[k] + shares[0] * (b[k] - c[k]) + shares[1] * (b[k] - a[k]));
        let target = match to {
            0 => a,
            1 => [0, 1, 2].map(|k| a[k] * 0.5 + b[k] * 0.5),
            2 => [0, 1, 2].map(|k| a[k] * 0.25 + b[k] * 0.25 + c[k] * 0.5),
            _ => input.point().map(Self::from),
        };
        RayOf::new(origin, [0, 1, 2].map(|k| target[k] - origin[k]))
    }

    fn same_by_others(_: &Bvh<Self>, _: &Bvh<Self>, _: &RayOf<Self>) {}
}
