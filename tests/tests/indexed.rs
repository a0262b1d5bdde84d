//! Tests indexed meshes. The hierarchy over an indexed mesh must equal the hierarchy over the
//! mesh's triangles, and an invalid index must be an error.

use intertri::{Ray, Scalar, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_trace::{BuildError, Bvh, BvhScalar, IndexedMesh, RefitError};

/// A mesh: vertices, and triangles that refer to the vertices by index.
struct Indexed<S> {
    vertices: Vec<[S; 3]>,
    indices: Vec<[u32; 3]>,
}

impl<S: Scalar> Indexed<S> {
    /// Generates random vertices and triangles. Some triangles are not finite or use the same
    /// vertex twice.
    fn random(vertices: usize, triangles: usize, rng: &mut Rng) -> Self {
        let vertex = |i: usize, rng: &mut Rng| {
            let mut p = rng.cube().map(S::nearest);
            if i % 29 == 28 {
                p[i % 3] = S::INFINITY;
            }
            p
        };
        let mut all: Vec<[S; 3]> = (0..vertices).map(|i| vertex(i, rng)).collect();
        if let Some(p) = all.get_mut(7) {
            p[0] = S::nearest(f64::NAN);
        }
        let index = |rng: &mut Rng| rng.below(vertices) as u32;
        let indices = (0..triangles).map(|_| [(); 3].map(|()| index(rng))).collect();
        Self { vertices: all, indices }
    }

    fn mesh(&self) -> IndexedMesh<'_, S> {
        IndexedMesh { vertices: &self.vertices, indices: &self.indices }
    }

    /// Returns the triangles with the coordinates of their corners.
    fn triangles(&self) -> Vec<TriangleOf<S>> {
        let corner = |i: u32| self.vertices[i as usize];
        self.indices.iter().map(|triangle| TriangleOf(triangle.map(corner))).collect()
    }
}

/// Asserts that two hierarchies are the same. A saved file contains the whole state, so comparing
/// the bytes is enough.
fn assert_same<S: BvhScalar>(one: &Bvh<S>, other: &Bvh<S>, what: &str) {
    assert!(one.to_bytes() == other.to_bytes(), "{what}");
}

fn good_indices<S: BvhScalar>() {
    let mut rng = Rng::new(1);
    for (vertices, triangles) in [(0, 0), (5, 0), (1, 3), (3, 1), (40, 9), (300, 2000)] {
        let what = format!("{vertices} vertices, {triangles} triangles");
        let first = Indexed::<S>::random(vertices, triangles, &mut rng);
        let mut bvh = Bvh::from_indexed(&first.vertices, &first.indices).unwrap();
        assert_same(&bvh, &Bvh::new(&first.triangles()).unwrap(), &what);

        // Refit to other vertices, and to other triangles.
        let mut other = Bvh::new(&first.triangles()).unwrap();
        for _ in 0..3 {
            let moved = Indexed::<S>::random(vertices, triangles, &mut rng);
            let refit = bvh.refit_indexed(&moved.vertices, &moved.indices).unwrap();
            let of_triangles = other.refit(&moved.triangles()).unwrap();
            let bits = |refit: f64| refit.to_bits();
            assert_eq!(bits(refit.cost), bits(of_triangles.cost), "{what}");
            assert_same(&bvh, &other, &what);
        }
    }
}

#[test]
fn good_indices_in_f32() {
    good_indices::<f32>();
}

#[test]
fn good_indices_in_f64() {
    good_indices::<f64>();
}

fn several_meshes<S: BvhScalar>() {
    let mut rng = Rng::new(2);
    let sizes = [(30, 40), (0, 0), (9, 0), (3, 1), (100, 700)];
    for count in 0..=sizes.len() {
        let mut mesh = |&(vertices, triangles): &(usize, usize)| {
            Indexed::<S>::random(vertices, triangles, &mut rng)
        };
        let all: Vec<Indexed<S>> = sizes[..count].iter().map(&mut mesh).collect();
        let meshes: Vec<IndexedMesh<'_, S>> = all.iter().map(Indexed::mesh).collect();
        let triangles: Vec<Vec<TriangleOf<S>>> = all.iter().map(Indexed::triangles).collect();
        let slices: Vec<&[TriangleOf<S>]> = triangles.iter().map(|mesh| &mesh[..]).collect();
        let indexed = Bvh::from_indexed_meshes(&meshes).unwrap();
        let of_triangles = Bvh::from_meshes(&slices).unwrap();
        assert_same(&indexed, &of_triangles, &format!("{count} meshes"));
        assert_eq!((indexed.geometries(), indexed.len()), (count, triangles.concat().len()));
    }
}

#[test]
fn several_meshes_in_f32() {
    several_meshes::<f32>();
}

#[test]
fn several_meshes_in_f64() {
    several_meshes::<f64>();
}

const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [1.0, 1.0, 5.0]];

/// The error must name the first invalid index and its triangle, as well as the mesh if it is not
/// the first one.
#[test]
fn a_bad_index_is_named() {
    let bad = |indices: &[[u32; 3]]| Bvh::from_indexed(&SQUARE, indices).unwrap_err();
    let named =
        |triangle, index| BuildError::BadIndex { geometry: 0, triangle, index, vertices: 4 };
    assert_eq!(bad(&[[0, 1, 4]]), named(0, 4));
    assert_eq!(bad(&[[0, 1, 2], [3, u32::MAX, 9], [7, 7, 7]]), named(1, u32::MAX));
    let none = Bvh::<f32>::from_indexed(&[], &[[0, 0, 0]]).unwrap_err();
    assert_eq!(none.to_string(), "triangle 0 has vertex 0, but there are 0 vertices");

    let good = IndexedMesh { vertices: &SQUARE, indices: &[[0, 1, 2], [3, 2, 1]] };
    let short = IndexedMesh { vertices: &SQUARE[..3], ..good };
    let error = Bvh::from_indexed_meshes(&[good, good, short, short]).unwrap_err();
    assert_eq!(error, BuildError::BadIndex { geometry: 2, triangle: 1, index: 3, vertices: 3 });
    assert_eq!(error.to_string(), "mesh 2: triangle 1 has vertex 3, but there are 3 vertices");
    let error = Bvh::from_indexed_meshes(&[short, good]).unwrap_err();
    assert_eq!(error.to_string(), "triangle 1 has vertex 3, but there are 3 vertices");
}

/// A refit that fails must not change anything.
#[test]
fn a_refit_with_a_bad_index_changes_nothing() {
    let mut bvh = Bvh::from_indexed(&SQUARE, &[[0, 1, 2], [3, 2, 1]]).unwrap();
    let before = bvh.to_bytes();
    let raised = SQUARE.map(|[x, y, z]| [x, y, z + 2.0]);
    let error = bvh.refit_indexed(&raised, &[[0, 1, 2], [3, 2, 4]]).unwrap_err();
    assert_eq!(error, RefitError::BadIndex { triangle: 1, index: 4, vertices: 4 });
    assert_eq!(error.to_string(), "triangle 1 has vertex 4, but there are 4 vertices");
    let error = bvh.refit_indexed(&raised, &[[0, 1, 2]]).unwrap_err();
    assert_eq!(error, RefitError::Count { expected: 2, found: 1 });
    assert!(bvh.to_bytes() == before);
    let ray = Ray::new([0.7, 0.7, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!(bvh.closest(&ray).map(|hit| (hit.triangle, hit.t)), Some((1, 5.0)));
    let corner = |hit| bvh.triangle(&hit).map(|triangle| triangle.0[0]);
    assert_eq!(corner(bvh.closest(&ray).unwrap()), Some(SQUARE[3]));

    bvh.refit_indexed(&raised, &[[0, 1, 2], [3, 2, 1]]).unwrap();
    assert_eq!(bvh.closest(&ray).map(|hit| (hit.triangle, hit.t)), Some((1, 7.0)));
}
