//! Compares winding numbers of open and damaged meshes with sums of solid angles over all
//! triangles.

mod damaged;
mod high_precision;

use intertri::{Ray, Scalar, Triangle, Triangle64, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_tests::oracle;
use intertri_trace::internal::WINDING_DIR;
use intertri_trace::{BvhScalar, Containment, Solid};

use damaged::mesh;
use high_precision::winding_number;

/// The number of points in the ordinary run. Set `INTERTRI_WINDING_POINTS` to test more.
const POINTS: usize = 12_000;

/// The number of points to test per mesh.
const EACH: usize = 100;

/// Statistics of the winding numbers of several meshes.
#[derive(Debug, Default)]
struct Seen {
    points: usize,
    surface: usize,
    inside: usize,
    fractions: usize,
    edges: usize,
    /// The largest error at points whose bound is below 1e-10, that is, points that are not next to
    /// an open edge.
    largest_error: f64,
    /// The largest error as a share of the bound.
    largest_share: f64,
}

/// Returns the edges that are traversed more often in one direction than in the other, found by
/// counting.
fn open_edges<S: Scalar>(mesh: &[TriangleOf<S>]) -> Vec<[[S; 3]; 2]> {
    let edges = mesh.iter().flat_map(|TriangleOf([a, b, c])| [[*a, *b], [*b, *c], [*c, *a]]);
    let mut left: Vec<([[S; 3]; 2], i32)> = Vec::new();
    for [a, b] in edges {
        if let Some((_, times)) = left.iter_mut().find(|(edge, _)| *edge == [b, a]) {
            *times -= 1;
        } else if let Some((_, times)) = left.iter_mut().find(|(edge, _)| *edge == [a, b]) {
            *times += 1;
        } else {
            left.push(([a, b], 1));
        }
    }
    left.into_iter()
        .filter(|(edge, times)| *times != 0 && edge[0] != edge[1])
        .map(|(edge, _)| edge)
        .collect()
}

/// Returns the error bound: `2^-47` for each edge, times the ratio of the edge's length to its
/// distance from the point if this ratio is above 1, plus `f64::EPSILON`.
fn allowed<S: Scalar>(edges: &[[[S; 3]; 2]], point: [S; 3]) -> f64 {
    let each = |edge: &[[S; 3]; 2]| {
        let seen =
            |c: [S; 3]| [0, 1, 2].map(|k| Into::<f64>::into(c[k]) - Into::<f64>::into(point[k]));
        let [a, b] = edge.map(seen);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let e = [0, 1, 2].map(|k| b[k] - a[k]);
        let along = (-dot(a, e) / dot(e, e)).clamp(0.0, 1.0);
        let foot = [0, 1, 2].map(|k| a[k] + along * e[k]);
        2.0_f64.powi(-47) * (dot(e, e) / dot(foot, foot)).sqrt().max(1.0)
    };
    edges.iter().map(each).sum::<f64>() + f64::EPSILON
}

/// Checks all points against a mesh, one by one and in a batch.
fn compare<S: BvhScalar>(mesh: &[TriangleOf<S>], points: &[[S; 3]], seen: &mut Seen) {
    let solid = Solid::from_soup(mesh).unwrap();
    let edges = open_edges(mesh);
    seen.edges += edges.len();
    assert_eq!(solid.open_edges() == 0, edges.is_empty());
    let numbers = solid.winding_number_batch(points);
    let (containments, contains) = (solid.classify_batch(points), solid.contains_batch(points));
    for (i, &point) in points.iter().enumerate() {
        seen.points += 1;
        let is_on = mesh.iter().any(|triangle| oracle::is_on(point, triangle));
        assert_eq!(numbers[i], solid.winding_number(point), "{point:?} alone");
        assert_eq!(containments[i], solid.classify(point), "{point:?} alone");
        assert_eq!(contains[i], containments[i] != Containment::Outside, "{point:?}");
        assert_eq!(numbers[i].is_none(), is_on, "{point:?}");
        let Some(number) = numbers[i] else {
            assert_eq!(containments[i], Containment::Surface);
            assert_eq!(solid.signed_distance(point), 0.0);
            seen.surface += 1;
            continue;
        };
        let truth = winding_number(mesh, point);
        let (error, allowed) = ((number - truth).abs(), allowed(&edges, point));
        assert!(error <= allowed, "{number} for {truth} at {point:?}, {} edges", edges.len());
        if allowed < 1e-10 {
            seen.largest_error = seen.largest_error.max(error);
        }
        seen.largest_share = seen.largest_share.max(error / allowed);
        seen.fractions += usize::from((truth - truth.round()).abs() > 1e-3);
        if (truth.abs().fract() - 0.5).abs() > allowed {
            let times = truth.round() as i32;
            let expected =
                if times == 0 { Containment::Outside } else { Containment::Inside(times) };
            assert_eq!(containments[i], expected, "{truth} at {point:?}");
            assert_eq!(solid.signed_distance(point) < 0.0, times != 0, "{truth} at {point:?}");
            seen.inside += usize::from(times != 0);
        }
    }
}

/// Generates points around a mesh, and points from which rays meet corners and edges exactly,
/// preferably open edges and their corners.
fn points(mesh: &[Triangle64], rng: &mut Rng) -> Vec<[f64; 3]> {
    let open = open_edges(mesh);
    let aimed = |at: [f64; 3], rng: &mut Rng| {
        let far = 2.0_f64.powi(-(rng.unit() * 20.0) as i32);
        [0, 1, 2].map(|k| at[k] - far * f64::from(WINDING_DIR[k]))
    };
    let mut points = Vec::new();
    for i in 0..EACH {
        let [a, b, c] = rng.pick(mesh).0;
        let [a, b] = if open.is_empty() || i % 4 == 3 { [a, b] } else { rng.pick(&open) };
        let middle = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
        let near = |at: [f64; 3], size: f64, rng: &mut Rng| at.map(|x| x + size * rng.signed());
        let size = 10.0_f64.powf(-9.0 * rng.unit());
        points.push(match i % 10 {
            0 | 1 => aimed(a, rng),
            2 | 3 => aimed(middle, rng),
            4 => near(aimed(middle, rng), 1e-16, rng),
            5 => near(aimed(a, rng), size * 1e-6, rng),
            6 => near(a, size, rng),
            7 => near(middle, size, rng),
            8 => [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0),
            _ => [0; 3].map(|_| 0.8 * rng.signed()),
        });
    }
    points
}

/// Generates a mesh and a point in f32. The point is the coordinate origin, and the mesh is moved
/// so that the ray along [`WINDING_DIR`] meets a corner or the midpoint of an edge.
fn in_f32(mesh: &[Triangle64], rng: &mut Rng) -> (Vec<Triangle>, [f32; 3]) {
    let open = open_edges(mesh);
    let [a, b] = if open.is_empty() { [mesh[0].0[0]; 2] } else { rng.pick(&open) };
    let at = if rng.unit() < 0.5 { a } else { [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])) };
    // At a sixteenth of the size, the sums below can be represented in 24 bits.
    let moved = |x: f64, k: usize| ((x - at[k]) / 16.0 + f64::from(WINDING_DIR[k])) as f32;
    let corner = |c: [f64; 3]| [0, 1, 2].map(|k| moved(c[k], k));
    (mesh.iter().map(|triangle| TriangleOf(triangle.0.map(corner))).collect(), [0.0; 3])
}

#[test]
fn winding_numbers_are_sums_of_solid_angles() {
    let wanted = std::env::var("INTERTRI_WINDING_POINTS").ok().and_then(|count| count.parse().ok());
    let wanted = wanted.unwrap_or(POINTS);
    let (mut rng, mut seen, mut of_f32) = (Rng::new(57), Seen::default(), Seen::default());
    let meshes = (wanted / EACH).min(200);
    for number in 0..meshes {
        let mesh = mesh(number, &mut rng);
        for _ in 0..wanted / EACH / meshes {
            compare(&mesh, &points(&mesh, &mut rng), &mut seen);
        }
        for _ in 0..4 {
            let (mesh, point) = in_f32(&mesh, &mut rng);
            compare(&mesh, &[point], &mut of_f32);
        }
        let plain = mesh.map_f32();
        let around: Vec<[f32; 3]> =
            (0..20).map(|_| [0; 3].map(|_| 0.8 * rng.signed() as f32)).collect();
        compare(&plain, &around, &mut of_f32);
    }
    println!("{meshes} meshes\nf64: {seen:?}\nf32: {of_f32:?}");
    let Seen { surface, inside, fractions, edges, .. } = seen;
    assert!(surface > 100 && inside > 1000 && fractions > 5000 && edges > 1000);
    assert!(of_f32.inside > 100 && of_f32.fractions > 1000);
}

/// Converts a mesh to f32.
trait InF32 {
    fn map_f32(&self) -> Vec<Triangle>;
}

impl InF32 for Vec<Triangle64> {
    fn map_f32(&self) -> Vec<Triangle> {
        self.iter().map(|t| TriangleOf(t.0.map(|c| c.map(|x| x as f32)))).collect()
    }
}

/// Checks that crossings are counted along [`WINDING_DIR`], the direction in which the tests aim
/// their rays.
#[test]
fn rays_are_aimed_where_crossings_are_counted() {
    // The ray goes exactly to the centre of a fan, a corner that all triangles of the fan share.
    let d = WINDING_DIR.map(f64::from);
    let ring: [[f64; 3]; 4] =
        [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [-0.1, 0.0, 0.0], [0.0, -0.1, 0.0]];
    let corner = |i: usize| [0, 1, 2].map(|k| d[k] + ring[i % 4][k]);
    let fan: Vec<Triangle64> = (0..4).map(|i| TriangleOf([d, corner(i), corner(i + 1)])).collect();
    let (solid, ray) = (Solid::from_soup(&fan).unwrap(), Ray::new([0.0; 3], WINDING_DIR));
    let truth = winding_number(&fan, [0.0; 3]);
    assert!((solid.winding_number([0.0; 3]).unwrap() - truth).abs() < 1e-14);
    let flat = Solid::from_soup(&fan.map_f32()).unwrap();
    assert_eq!(flat.bvh().query().once().all(&ray).len(), 1);
    // If one of the four triangles is missing, the ray goes to a common end of two open edges.
    for i in 0..4 {
        let open: Vec<_> = (0..4).filter(|&k| k != i).map(|k| fan[k]).collect();
        let (solid, truth) = (Solid::from_soup(&open).unwrap(), winding_number(&open, [0.0; 3]));
        assert!((solid.winding_number([0.0; 3]).unwrap() - truth).abs() < 1e-14, "{i}: {truth}");
    }
}

/// Tests meshes whose sizes are at the limits of the exponents, coordinates that are not finite,
/// and equal corners.
#[test]
fn any_numbers_have_a_winding_number() {
    let mut rng = Rng::new(3);
    for exponent in [-1060, -700, -300, 0, 300, 700, 1021] {
        // Multiply by two powers, because a single power of the full exponent might be subnormal.
        let scale = 2.0_f64.powi(exponent / 2) * 2.0_f64.powi(exponent - exponent / 2);
        for number in [0, 4, 7] {
            let plain = mesh(number, &mut rng);
            let scaled = |c: [f64; 3]| c.map(|x| 2.0 * x * scale);
            let large: Vec<_> = plain.iter().map(|t| TriangleOf(t.0.map(scaled))).collect();
            let solids = [&plain, &large].map(|mesh| Solid::from_soup(mesh).unwrap());
            for _ in 0..50 {
                // The point is on the grid, so that scaling is exact.
                let point = [0; 3].map(|_| (rng.signed() * 1000.0).round() / 1024.0);
                let numbers =
                    [solids[0].winding_number(point), solids[1].winding_number(scaled(point))];
                let near = |[a, b]: [f64; 2]| (a - b).abs() < 1e-11;
                let same = match numbers {
                    [Some(a), Some(b)] => near([a, b]),
                    [a, b] => a == b,
                };
                assert!(same, "{exponent} {number}: {numbers:?} at {point:?}");
            }
        }
    }
    let nan = TriangleOf([[f64::NAN, 0.0, 0.0], [1.0; 3], [2.0, 0.0, f64::INFINITY]]);
    let mut open = mesh(4, &mut rng);
    let without = Solid::from_soup(&open).unwrap();
    open.push(nan);
    let solid = Solid::from_soup(&open).unwrap();
    assert_eq!(solid.winding_number([0.1; 3]), without.winding_number([0.1; 3]));
    for point in [[f64::NAN, 0.0, 0.0], [f64::INFINITY; 3]] {
        assert_eq!(solid.winding_number(point), Some(0.0));
        assert_eq!(solid.classify(point), Containment::Outside);
    }
    assert_eq!(solid.winding_number([f64::MAX; 3]).map(|number| number.abs() < 1e-300), Some(true));
    assert_eq!(Solid::<f64>::from_soup(&[]).unwrap().winding_number([0.0; 3]), Some(0.0));
}
