//! Compares the hierarchy with a plain loop that calls the reference implementation, for all
//! families and scenes of all sizes.

use crate::common;
use intertri::simd::Level;
use intertri::{Mode, Ray, Triangle};
use intertri_lab::families::find;
use intertri_lab::rng::Rng;
use intertri_tests::{Scene, as_source, check_hierarchy};
use intertri_trace::Bvh;

/// Tests every family in scenes of 1 to 5,000 triangles, each at one level.
fn scenes(each: usize, seed: u64) {
    let levels: Vec<Level> = Level::all().collect();
    common::each_family(|_, family| {
        let mut rng = Rng::new(seed);
        let (mut rays, mut hits) = (0, 0);
        for i in 0..each {
            // Sizes are log-uniform.
            let size = rng.log(1.0, 5000.0) as usize;
            let level = &levels[i % levels.len()..][..1];
            let scene = common::scene(family, &mut rng, size, 40);
            hits += check_hierarchy(&scene, level).unwrap_or_else(|difference| {
                let small = if size < 20 { as_source(&scene) } else { String::new() };
                panic!("{} (seed {seed}, scene {i}): {difference}\n{small}", family.name)
            });
            rays += scene.rays.len();
        }
        println!("{:20} {each:5} scenes, {rays:7} rays, {hits:7} hits", family.name);
    });
}

#[test]
fn every_family_in_scenes_of_all_sizes() {
    scenes(60, 3);
}

#[test]
#[ignore = "slow: takes several minutes"]
fn every_family_in_many_scenes_of_all_sizes() {
    scenes(2000, 4);
}

/// Tests small scenes, including every number of triangles at which a block or a node becomes full.
#[test]
fn small_scenes_of_every_size() {
    let levels: Vec<Level> = Level::all().collect();
    for family in ["random", "cube-exact", "stack", "zero-area", "axis", "needle"] {
        let family = find(family).expect("the family exists");
        let mut rng = Rng::new(5);
        for size in (0..80).chain([511, 512, 513]) {
            let scene = common::scene(family, &mut rng, size, 10);
            if let Err(difference) = check_hierarchy(&scene, &levels) {
                panic!("{} of {size}: {difference}\n{}", family.name, as_source(&scene));
            }
        }
    }
}

fn checked(triangles: Vec<Triangle>, rays: Vec<Ray>) -> usize {
    let scene = Scene { triangles, rays, threshold: 1e-9 };
    check_hierarchy(&scene, &Level::all().collect::<Vec<_>>()).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn no_triangles_and_triangles_at_one_point() {
    let rays = || vec![Ray::new([0.0; 3], [0.0, 0.0, 1.0]), Ray::new([1.0; 3], [1.0, -1.0, 0.5])];
    assert_eq!(checked(vec![], rays()), 0);
    assert_eq!(checked(vec![Triangle([[1.0; 3]; 3]); 100], rays()), 0);

    // Among a hundred copies of one triangle, the lowest index must win.
    let triangle = Triangle::new([-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 1.0, 2.0]);
    assert_eq!(checked(vec![triangle; 100], rays()), 1);
    let bvh = Bvh::new(&vec![triangle; 100_000]).unwrap();
    let ray = Ray::new([0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(bvh.query().mode(Mode::certified()).closest(&ray).unwrap().triangle, 0);
    assert_eq!(bvh.query().mode(Mode::certified()).all(&ray).len(), 100_000);
}

/// Tests axis-parallel rays in the faces of boxes, from inside boxes, and along their edges.
#[test]
fn rays_in_the_faces_of_boxes() {
    let mut triangles = Vec::new();
    for i in 0..200 {
        let [x, y, z] = [i % 6, i / 6 % 6, i / 36].map(|k| k as f32);
        triangles.push(Triangle::new([x, y, z], [x + 1.0, y, z], [x, y + 1.0, z]));
        triangles.push(Triangle::new([x, y, z], [x, y + 1.0, z], [x, y, z + 1.0]));
    }
    let mut rays = Vec::new();
    for axis in 0..3 {
        for i in 0..500 {
            let mut origin = [i % 7, i / 7 % 7, i / 49 % 7].map(|k| k as f32 * 0.5 + 0.5);
            let mut dir = [0.0, -0.0, 0.0];
            dir[axis] = if i % 2 == 0 { 1.0 } else { -2.0 };
            rays.push(Ray::new(origin, dir));
            origin[axis] = -20.0;
            rays.push(Ray::new(origin, dir.map(f32::abs)));
        }
    }
    assert!(checked(triangles, rays) > 500);
}

/// Tests a triangle that spans the range of f32 next to tiny triangles.
#[test]
fn the_whole_range_of_f32() {
    let max = f32::MAX;
    let mut triangles = vec![Triangle::new([-max, -max, 3.0], [max, -max, 3.0], [0.0, max, 3.0])];
    let dust = |i: usize| {
        let x = i as f32 * 1e-3;
        Triangle::new([x, 0.0, 1.0], [x + 1e-3, 0.0, 1.0], [x, 1e-3, 1.0])
    };
    triangles.extend((0..100).map(dust));
    triangles.push(Triangle([[1e-45, 0.0, 0.0], [0.0, 1e-45, 0.0], [0.0, 0.0, 1e-45]]));
    let rays = (0..100).map(|i| Ray::new([i as f32 * 1e-3 + 1e-4, 1e-4, 0.0], [0.0, 0.0, 1.0]));
    assert_eq!(checked(triangles, rays.collect()), 100);
}
