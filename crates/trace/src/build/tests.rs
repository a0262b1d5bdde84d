//! Tests that the builder produces valid, low-cost trees with any number of threads.

use super::layout::{Layout, MAX_DEPTH};
use super::{BuildError, binary, layout_at, prim_refs, wide};
use crate::Bvh;
use crate::tree::EMPTY;
use intertri::simd::Level;
use intertri::{Mode, Ray, Triangle};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A small random number generator that yields the same numbers on every platform.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn point(&mut self) -> [f32; 3] {
        [self.unit(), self.unit(), self.unit()]
    }
}

fn soup(count: usize, size: f32, scale: f32) -> Vec<Triangle> {
    let mut random = Random(count as u64);
    let triangle = |_| {
        let at = random.point();
        let corner = |o: [f32; 3]| [0, 1, 2].map(|k| (at[k] - 0.5 + size * (o[k] - 0.5)) * scale);
        Triangle([(); 3].map(|()| corner(random.point())))
    };
    (0..count).map(triangle).collect()
}

/// Returns small triangles, stretching every eighth one far along one axis.
fn room(count: usize) -> Vec<Triangle> {
    let mut triangles = soup(count, 0.01, 1.0);
    for (i, triangle) in triangles.iter_mut().enumerate().step_by(8) {
        triangle.0[0][i / 8 % 3] += 0.7;
    }
    triangles
}

fn checked(triangles: &[Triangle]) -> Layout {
    let tree = layout_at(triangles, Level::best(), &|_, _| ()).expect("the mesh is small enough");
    if let Err(why) = tree.check(triangles) {
        panic!("{} triangles: {why}", triangles.len());
    }
    tree
}

#[test]
fn every_count() {
    for count in (0..70).chain([127, 128, 129, 1000, 4095, 4096, 4097, 20_000]) {
        checked(&soup(count, 0.1, 1.0));
        checked(&soup(count, 3.0, 1.0));
    }
    assert_eq!(checked(&[]).nodes[0].children(), &[EMPTY; 8]);
    assert_eq!(checked(&soup(1, 1.0, 1.0)).blocks.len(), 1);
}

#[test]
fn every_unit() {
    let plain = checked(&soup(5000, 0.1, 1.0)).cost();
    for exponent in [-149, -140, -126, -120, -70, 70, 120, 127] {
        let triangles = soup(5000, 0.1, (exponent as f32).exp2());
        let tree = checked(&triangles);
        // As long as no coordinate loses bits, the cost does not depend on the unit of length.
        if exponent > -126 {
            assert!((tree.cost() / plain - 1.0).abs() < 0.01, "{exponent}: {}", tree.cost());
        }
    }
}

#[test]
fn extremes() {
    let m = f32::MAX;
    let mut triangles = soup(300, 1.0, 1.0);
    triangles.push(Triangle([[-m, -m, -m], [m, m, m], [m, -m, m]]));
    triangles.push(Triangle([[m, m, m], [m, m, -m], [m, -m, 0.0]]));
    triangles.push(Triangle([[-m, 0.0, m], [-m, 1e30, m], [-m, 0.0, m - 1e32]]));
    triangles.push(Triangle([[1e-45, -0.0, 0.0], [-1e-45, 0.0, -0.0], [1e-45, 1e-45, 0.0]]));
    triangles.push(Triangle([[m; 3]; 3]));
    assert!(checked(&triangles).cost().is_finite());
    // Build a tree over the extreme triangles alone.
    checked(&triangles[300..]);
    let corners = (0..5000_u32).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { m } else { -m }));
    let small = |[x, y, z]: [f32; 3]| Triangle([[x, y, z], [x * 0.9, y, z], [x, y * 0.9, z]]);
    assert_eq!(checked(&corners.map(small).collect::<Vec<_>>()).blocks.len() / 100, 6);
}

#[test]
fn triangles_that_are_never_hit_are_left_out() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut triangles = soup(100, 0.1, 1.0);
        for i in 0..9 {
            triangles[i * 11].0[i / 3][i % 3] = bad;
        }
        checked(&triangles);
        let none = vec![Triangle([[bad; 3]; 3]); 20];
        assert_eq!(checked(&none).blocks.len(), 0);
    }
}

#[test]
fn triangles_at_one_place() {
    let t = Triangle([[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 3.0, 4.0]]);
    // Degenerate cases: a triangle in an axis-aligned plane, whose box has no volume, and two
    // triangles so small that the areas of their boxes are practically zero.
    let flat = Triangle([[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 3.0, 3.0]]);
    let speck =
        Triangle([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0_f32.next_up()], [1.0_f32.next_up(), 2.0, 3.0]]);
    let tiny = Triangle([[0.0; 3], [1e-44, 0.0, 0.0], [0.0, 1e-44, 0.0]]);
    for one in [t, flat, speck, tiny] {
        let tree = checked(&vec![one; 100_000]);
        // Identical triangles are halved repeatedly, and a node has at most eight children.
        assert!(tree.depth <= 17, "{}", tree.depth);
        assert!(tree.blocks.len() == 100_000 / 8, "{}", tree.blocks.len());
    }
    // Nested boxes around a common point.
    let nested = |i: usize| {
        let r = i as f32;
        Triangle([[r, r, r], [-r, -r, -r], [r, -r, r]])
    };
    checked(&(1..10_000).map(nested).collect::<Vec<_>>());
}

#[test]
fn triangles_on_a_line() {
    let along = |x: f32| Triangle([[x, 0.0, 0.0], [x * 1.5, 0.0, 0.0], [x, 0.0, x]]);
    checked(&(1..10_000).map(|i| along(i as f32)).collect::<Vec<_>>());
    // Each triangle is twice as far out as the previous one, so the heuristic would split off one
    // triangle at a time.
    let far = (0..250).map(|i| along((i as f32 - 125.0).exp2()));
    let tree = checked(&far.flat_map(|t| [t; 40]).collect::<Vec<_>>());
    assert!(tree.depth <= MAX_DEPTH);
}

#[test]
fn large_triangles_are_put_where_they_cost_less() {
    for count in [20_000, 30_000, 100_000] {
        let triangles = room(count);
        let refs = prim_refs::collect(&triangles[..]).expect("the mesh is small enough").refs;
        let plain =
            binary::build(refs, Level::best(), &|_, _| ()).expect("the mesh is small enough");
        let plain = wide::write(&plain).expect("the mesh is small enough");
        plain.check(&triangles).expect("the tree is valid");
        let (cost, before) = (checked(&triangles).cost(), plain.cost());
        assert!(cost < 0.95 * before, "{cost}, before {before}");
    }
}

#[test]
fn same_tree_on_any_number_of_threads() {
    for triangles in [soup(200_000, 0.01, 1.0), room(100_000)] {
        let one = checked(&triangles);
        #[cfg(feature = "parallel")]
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("the thread pool starts");
            let other = pool
                .install(|| layout_at(&triangles[..], Level::best(), &|_, _| ()))
                .expect("the mesh is small enough");
            assert_eq!(one.blocks, other.blocks);
            assert_eq!(format!("{:?}", one.nodes), format!("{:?}", other.nodes));
        }
        assert!(one.depth <= 14, "{}", one.depth);
    }
}

#[test]
fn same_tree_at_every_level() {
    for triangles in [soup(30_000, 0.05, 3.0), room(30_000)] {
        let best = checked(&triangles);
        for level in Level::all() {
            let other =
                layout_at(&triangles[..], level, &|_, _| ()).expect("the mesh is small enough");
            assert_eq!(best.blocks, other.blocks, "{}", level.name());
            let nodes = |layout: &Layout| format!("{:?}", layout.nodes);
            assert_eq!(nodes(&best), nodes(&other), "{}", level.name());
        }
    }
}

#[test]
fn progress_reaches_the_end() {
    let triangles = soup(50_000, 0.01, 1.0);
    let (most, calls) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let tell = |done: usize, total: usize| {
        assert_eq!(total, 50_000);
        most.fetch_max(done, Ordering::Relaxed);
        calls.fetch_add(1, Ordering::Relaxed);
    };
    layout_at(&triangles[..], Level::best(), &tell).expect("the mesh is small enough");
    assert_eq!(most.into_inner(), 50_000);
    assert!((10..1000).contains(&calls.into_inner()));
}

#[test]
fn errors_are_for_people() {
    let text = BuildError::TooManyTriangles { count: 1 << 31 }.to_string();
    assert!(text.contains("2147483648") && text.contains("2147483647"), "{text}");
}

/// Compares query results with those of a brute-force loop for a new hierarchy, for one refitted to
/// other positions and back, and for one saved and loaded.
#[test]
fn moved_parts_change_no_answer() {
    let (triangles, mut random) = (room(20_000), Random(7));
    let mode = Mode::exact();
    let mut bvh = Bvh::new(&triangles).expect("the mesh is small enough");
    // Aim rays from random points at the centres of triangles.
    let rays: Vec<Ray> = (0..400)
        .map(|i| {
            let [a, b, c] = triangles[i * 49].0;
            let from = random.point().map(|x| 2.0 * x - 1.0);
            Ray::new(from, [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0 - from[k]))
        })
        .collect();
    let expected: Vec<_> = rays.iter().map(|ray| mode.all(&triangles, ray)).collect();
    assert!(expected.iter().map(Vec::len).sum::<usize>() > 400);
    let check = |bvh: &Bvh| {
        for (ray, expected) in rays.iter().zip(&expected) {
            assert_eq!(&bvh.query().mode(mode).all(ray), expected);
            assert_eq!(bvh.query().mode(mode).closest(ray).as_ref(), expected.first());
            assert_eq!(bvh.query().mode(mode).any(ray), !expected.is_empty());
        }
    };
    check(&bvh);
    let elsewhere: Vec<_> = triangles.iter().rev().copied().collect();
    bvh.refit(&elsewhere).expect("the number of triangles is unchanged");
    bvh.refit(&triangles).expect("the number of triangles is unchanged");
    check(&bvh);
    let bytes = bvh.to_bytes();
    check(&Bvh::from_bytes(&bytes).expect("the bytes are a saved hierarchy"));
}
