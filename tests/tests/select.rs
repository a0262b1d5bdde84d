//! Tests queries with several meshes, masks, culled faces and skipped triangles against a plain
//! loop over the selected triangles.

use crate::common;
use dashu_ratio::RBig;
use intertri::simd::Level;
use intertri::{Crossing, Crossings, Hit, Mode, Ray, Threshold, Triangle};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;
use intertri_tests::Scene;
use intertri_trace::{Bvh, Faces, MeshTriangle, Query};

/// A scene divided into three meshes, the second of which is empty.
struct Meshes {
    scene: Scene,
    first: usize,
    bvh: Bvh,
}

/// The settings that select triangles.
#[derive(Clone, Copy, Debug)]
struct Selection<'a> {
    mask: u32,
    faces: Faces,
    skip: &'a [&'a [Hit]],
}

impl<'a> Selection<'a> {
    const ALL: Selection<'static> = Selection { mask: u32::MAX, faces: Faces::Both, skip: &[] };

    /// Returns a query with this selection.
    fn query(self, bvh: &'a Bvh, mode: Mode) -> Query<'a> {
        bvh.query().mode(mode).mask(self.mask).faces(self.faces).skip(self.skip)
    }

    /// Returns the same query, applying its settings in a different order.
    fn reordered(self, bvh: &'a Bvh, mode: Mode) -> Query<'a> {
        bvh.query().skip(self.skip).faces(self.faces).mask(self.mask).mode(mode)
    }

    /// Returns the selection that applies when the i-th ray is queried alone.
    fn alone(self, i: usize) -> Self {
        Self { skip: self.skip.get(i..i + 1).unwrap_or(&[]), ..self }
    }
}

/// The masks of the meshes.
const MASKS: [u32; 3] = [0b0011, 0b1111, 0b0110];

impl Meshes {
    fn new(scene: Scene, first: usize) -> Self {
        let (one, other) = scene.triangles.split_at(first);
        let mut bvh = Bvh::from_meshes(&[one, &[], other]).unwrap();
        for (geometry, mask) in MASKS.into_iter().enumerate() {
            bvh.set_mask(geometry, mask);
        }
        Self { scene, first, bvh }
    }

    /// Converts a hit whose triangle index runs through all meshes to the ids that queries report.
    fn renamed(&self, hit: Hit) -> Hit {
        let (geometry, triangle) = match hit.triangle {
            Hit::NO_TRIANGLE => (0, Hit::NO_TRIANGLE),
            i if (i as usize) < self.first => (0, i),
            i => (2, i - self.first as u32),
        };
        Hit { geometry, triangle, ..hit }
    }

    /// Returns the triangles that are selected for a ray, as indices that run through all meshes.
    fn counting(&self, selection: &Selection<'_>, number: usize, ray: &Ray) -> Vec<u32> {
        let skipped = selection.skip.get(number).copied().unwrap_or(&[]);
        let counts = |i: &u32| {
            let renamed = self.renamed(Hit { triangle: *i, ..Hit::MISS });
            MASKS[renamed.geometry as usize] & selection.mask != 0
                && !skipped
                    .iter()
                    .any(|h| (h.geometry, h.triangle) == (renamed.geometry, renamed.triangle))
                && match selection.faces {
                    Faces::Both => true,
                    Faces::Front => along_normal(ray, &self.scene.triangles[*i as usize]) < 0,
                    Faces::Back => along_normal(ray, &self.scene.triangles[*i as usize]) > 0,
                }
        };
        (0..self.scene.triangles.len() as u32).filter(counts).collect()
    }

    /// Converts a hit whose index is a position in `counting` to the ids that queries report.
    fn of_counting(&self, counting: &[u32], hit: Hit) -> Hit {
        self.renamed(Hit { triangle: counting[hit.triangle as usize], ..hit })
    }

    /// Returns the selected triangles with the given indices.
    fn triangles(&self, counting: &[u32]) -> Vec<Triangle> {
        counting.iter().map(|&i| self.scene.triangles[i as usize]).collect()
    }

    /// Checks every query for every ray. Returns the number of hits.
    fn check(&self, mode: Mode, selection: &Selection<'_>) -> usize {
        let (rays, query) = (&self.scene.rays[..], selection.query(&self.bvh, mode));
        let (closest, any) = (query.closest_batch(rays), query.any_batch(rays));
        let triangles = query.closest_triangle_batch(rays);
        let lists = query.all_batch(rays, None).unwrap();
        let few = query.all_batch(rays, Some(2)).unwrap();
        for (i, ray) in rays.iter().enumerate() {
            let counting = self.counting(selection, i, ray);
            let some = self.triangles(&counting);
            let renamed = |hit| self.of_counting(&counting, hit);
            let first = mode.closest(&some, ray);
            let want = first.map_or(Hit::MISS, renamed);
            let at = || format!("{} ray {i}: {ray:?}, {selection:?}", mode.level().name());
            assert_eq!(bits(&closest[i]), bits(&want), "{}", at());
            assert_eq!(any[i], first.is_some(), "{}", at());
            let name = MeshTriangle { triangle: want.triangle, geometry: want.geometry };
            assert_eq!(triangles[i], name, "{}", at());
            let all: Vec<_> = mode.all(&some, ray).into_iter().map(renamed).collect();
            assert!(lists.of(i).iter().map(bits).eq(all.iter().map(bits)), "{}", at());
            assert!(few.of(i).iter().map(bits).eq(all.iter().take(2).map(bits)), "{}", at());

            let alone = selection.alone(i);
            let queries = [alone.query(&self.bvh, mode), alone.reordered(&self.bvh, mode)];
            for mut query in queries {
                let hit = query.closest(ray).unwrap_or(Hit::MISS);
                assert_eq!(bits(&hit), bits(&want), "{}", at());
                assert_eq!(query.any(ray), first.is_some(), "{}", at());
                assert!(query.all(ray).iter().map(bits).eq(all.iter().map(bits)), "{}", at());
                let triangle = query.closest_triangle(ray).unwrap_or(MeshTriangle::MISS);
                assert_eq!(triangle, name, "{}", at());
            }
        }
        lists.items.len()
    }

    /// Checks the crossings of the selected triangles.
    fn check_crossings(&self, mode: Mode, selection: &Selection<'_>) {
        let (rays, query) = (&self.scene.rays[..], selection.query(&self.bvh, mode));
        let mut counts = vec![Crossings { signed: 7, unsigned: 7 }; rays.len()];
        query.count_crossings_batch_into(rays, &mut counts);
        let lists = query.crossings_batch(rays, None).unwrap();
        let few = query.crossings_batch(rays, Some(1)).unwrap();
        for (i, ray) in rays.iter().enumerate() {
            let counting = self.counting(selection, i, ray);
            let mut all = mode.crossings(&self.triangles(&counting), ray);
            let mut want = Crossings::default();
            for crossing in &mut all {
                want.add(crossing.leaves);
                crossing.hit = self.of_counting(&counting, crossing.hit);
            }
            let at = || format!("ray {i}: {ray:?}, {selection:?}");
            assert_eq!(counts[i], want, "{}", at());
            let bits = |all: &[Crossing]| -> Vec<_> {
                all.iter().map(|c| (bits(&c.hit), c.leaves)).collect()
            };
            let (all, first) = (bits(&all), bits(&all[..all.len().min(1)]));
            assert_eq!(bits(lists.of(i)), all, "{}", at());
            assert_eq!(bits(few.of(i)), first, "{}", at());
            let mut query = selection.alone(i).query(&self.bvh, mode);
            assert_eq!(bits(&query.crossings(ray)), all, "{}", at());
            assert_eq!(bits(query.next_crossing(ray).as_slice()), first, "{}", at());
        }
    }
}

/// Returns all fields of a hit as bits, because its weights may be NaN.
fn bits(hit: &Hit) -> [u64; 5] {
    let Hit { t, u, v, triangle, geometry } = *hit;
    [t.to_bits(), u.to_bits(), v.to_bits(), triangle.into(), geometry.into()]
}

/// Returns the sign of the dot product of the direction and the normal, in rational arithmetic.
fn along_normal(ray: &Ray, triangle: &Triangle) -> i32 {
    let exact = |v: [f32; 3]| v.map(|x| RBig::try_from(x).ok());
    let [Some(dx), Some(dy), Some(dz)] = exact(ray.dir) else { return 0 };
    let corners = triangle.0.map(exact);
    let [
        [Some(ax), Some(ay), Some(az)],
        [Some(bx), Some(by), Some(bz)],
        [Some(cx), Some(cy), Some(cz)],
    ] = corners
    else {
        return 0;
    };
    let (ux, uy, uz) = (bx - &ax, by - &ay, bz - &az);
    let (vx, vy, vz) = (cx - ax, cy - ay, cz - az);
    let sum = dx * (&uy * &vz - &uz * &vy) + dy * (uz * &vx - &ux * vz) + dz * (ux * vy - uy * vx);
    match sum.cmp(&RBig::ZERO) {
        std::cmp::Ordering::Less => -1,
        std::cmp::Ordering::Equal => 0,
        std::cmp::Ordering::Greater => 1,
    }
}

/// Checks all kinds of selections. Returns the total number of hits.
fn selections(meshes: &Meshes, level: Level) -> usize {
    let threshold = Threshold::new(meshes.scene.threshold).unwrap();
    let modes = [Mode::certified_with(threshold), Mode::exact(), Mode::once()];
    // Each ray skips its first hit, all its hits, an unrelated triangle, or nothing.
    let all = meshes.bvh.query().at(level).all_batch(&meshes.scene.rays, None).unwrap();
    let other = [Hit { triangle: 1, geometry: 2, ..Hit::MISS }, Hit::MISS];
    let skips: Vec<&[Hit]> = (all.iter().enumerate())
        .map(|(i, hits)| match i % 4 {
            0 => &hits[..hits.len().min(1)],
            1 => hits,
            2 => &other[..],
            _ => &[],
        })
        .collect();
    let mut hits = 0;
    for mask in [u32::MAX, 0b0001, 0b0010, 0b0100, 0b1000, 0] {
        for faces in [Faces::Both, Faces::Front, Faces::Back] {
            for skip in [&[][..], &skips[..]] {
                let selection = Selection { mask, faces, skip };
                for mode in modes {
                    hits += meshes.check(mode.at(level), &selection);
                }
                meshes.check_crossings(Mode::exact().at(level), &selection);
            }
        }
    }
    hits
}

#[test]
fn every_family_in_meshes_by_every_selection() {
    let levels: Vec<Level> = Level::all().collect();
    let hits = common::each_family(|i, family| {
        let mut rng = Rng::new(39 + i as u64);
        let of = |size| {
            let scene = common::scene(family, &mut rng, size, 12);
            let first = scene.triangles.len() / 3;
            selections(&Meshes::new(scene, first), levels[i % levels.len()])
        };
        [1, 30, 200].map(of).iter().sum::<usize>()
    });
    let hits: usize = hits.iter().sum();
    println!("{hits} hits");
    assert!(hits > 10_000);
}

/// Puts the same triangles into both meshes. If two hits have the same t, the lower geometry wins,
/// and within a geometry the lower triangle.
#[test]
fn ties_go_by_the_position_in_the_whole() {
    let mut rng = Rng::new(40);
    for family in FAMILIES {
        let mut scene = common::scene(family, &mut rng, 20, 30);
        let again = scene.triangles.clone();
        scene.triangles.extend(again.iter().rev());
        let meshes = Meshes::new(scene, again.len());
        for level in Level::all() {
            meshes.check(Mode::exact().at(level), &Selection::ALL);
            meshes.check(Mode::certified().at(level), &Selection { mask: 0b100, ..Selection::ALL });
        }
    }
}

/// Tests a bundle of rays from one origin, with and without a mask.
#[test]
fn rays_of_one_origin_go_by_the_selection() {
    let at = |x: i32, y: i32, z: f32| {
        let [x, y] = [x, y].map(|k| k as f32);
        Triangle([[x, y, z], [x + 1.0, y, z], [x, y + 1.0, z]])
    };
    let sheet = |z: f32| (0..400).map(move |i| at(i % 20 - 10, i / 20 - 10, z));
    let triangles: Vec<Triangle> = sheet(20.0).chain(sheet(30.0)).collect();
    let ray = |i: usize| {
        let [x, y] = [i % 32, i / 32].map(|k| k as f32 / 64.0 - 0.25);
        Ray::new([0.0; 3], [x, y, 1.0])
    };
    let scene = Scene { triangles, rays: (0..1024).map(ray).collect(), threshold: 1e-9 };
    let meshes = Meshes::new(scene, 400);
    for level in Level::all() {
        let all = meshes.check(Mode::exact().at(level), &Selection::ALL);
        let one =
            meshes.check(Mode::exact().at(level), &Selection { mask: 0b001, ..Selection::ALL });
        assert!(one > 200 && all > one + 200, "{all} {one}");
    }
}

#[test]
#[should_panic(expected = "pass one list of triangles to skip per ray, or none")]
fn a_batch_has_a_list_a_ray_or_none() {
    let bvh = Bvh::new(&[]).unwrap();
    let rays = [Ray::new([0.0; 3], [0.0, 0.0, 1.0]); 3];
    let _ = bvh.query().skip(&[&[], &[]]).all_batch(&rays, None);
}

#[test]
#[should_panic(expected = "pass at most one list of triangles to skip for a ray")]
fn a_single_ray_has_one_list_or_none() {
    let bvh = Bvh::<f32>::new(&[]).unwrap();
    bvh.query().skip(&[&[], &[]]).closest(&Ray::new([0.0; 3], [0.0, 0.0, 1.0]));
}

/// A geometry whose mask is 0 must be hidden even from queries without a mask.
#[test]
fn a_geometry_without_a_mask_never_counts() {
    let wall = [Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0])];
    let mut bvh = Bvh::from_meshes(&[&wall, &wall]).unwrap();
    let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    let hit = |bvh: &Bvh| bvh.closest(&ray).map(|hit| (hit.geometry, hit.triangle));
    assert_eq!(hit(&bvh), Some((0, 0)));
    bvh.set_mask(0, 0);
    assert_eq!(hit(&bvh), Some((1, 0)));
    let triangle = bvh.query().closest_triangle(&ray);
    assert_eq!(triangle, Some(MeshTriangle { triangle: 0, geometry: 1 }));
    assert_eq!((bvh.geometries(), bvh.len()), (2, 2));
}
