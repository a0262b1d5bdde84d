//! Several meshes, masks, culled faces and skipped triangles against a plain loop over the triangles that count.

use crate::common;
use dashu_ratio::RBig;
use intertri::simd::Level;
use intertri::{Certified, Crossings, Double, Exact, Hit, Mode, Ray, Threshold, Triangle};
use intertri_lab::families::FAMILIES;
use intertri_lab::rng::Rng;
use intertri_tests::Scene;
use intertri_trace::{Bvh, Faces, Select};

/// A scene in three meshes, the second of which is empty.
struct Meshes {
    scene: Scene,
    first: usize,
    bvh: Bvh,
}

/// The masks of the meshes.
const MASKS: [u32; 3] = [0b0011, 0b1111, 0b0110];

impl Meshes {
    fn new(scene: Scene, first: usize) -> Self {
        let (one, other) = scene.triangles.split_at(first);
        let mut bvh = Bvh::of_meshes(&[one, &[], other]).unwrap();
        for (geometry, mask) in MASKS.into_iter().enumerate() {
            bvh.set_mask(geometry, mask);
        }
        Self { scene, first, bvh }
    }

    /// A hit of a triangle by its position in the whole, as it is told.
    fn told(&self, hit: Hit) -> Hit {
        let (geometry, triangle) = match hit.triangle {
            Hit::NO_TRIANGLE => (0, Hit::NO_TRIANGLE),
            i if (i as usize) < self.first => (0, i),
            i => (2, i - self.first as u32),
        };
        Hit { geometry, triangle, ..hit }
    }

    /// The positions of the triangles that count for a ray.
    fn counting(&self, select: &Select<'_>, number: usize, ray: &Ray) -> Vec<u32> {
        let skipped = select.skip.get(number).copied().unwrap_or(&[]);
        let counts = |i: &u32| {
            let told = self.told(Hit { triangle: *i, ..Hit::MISS });
            MASKS[told.geometry as usize] & select.mask != 0
                && !skipped
                    .iter()
                    .any(|h| (h.geometry, h.triangle) == (told.geometry, told.triangle))
                && match select.faces {
                    Faces::Both => true,
                    Faces::Front => along_normal(ray, &self.scene.triangles[*i as usize]) < 0,
                    Faces::Back => along_normal(ray, &self.scene.triangles[*i as usize]) > 0,
                }
        };
        (0..self.scene.triangles.len() as u32).filter(counts).collect()
    }

    /// A hit among the triangles that count, as it is told of all.
    fn of_counting(&self, counting: &[u32], hit: Hit) -> Hit {
        self.told(Hit { triangle: counting[hit.triangle as usize], ..hit })
    }

    /// Every query by every ray.
    fn check<M: Mode>(&self, mode: &M, select: &Select<'_>) -> usize {
        let (rays, only) = (&self.scene.rays[..], self.bvh.only(select));
        let (mut closest, mut any) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        let mut triangles = vec![0; rays.len()];
        only.closest_batch(mode, rays, &mut closest);
        only.any_batch(mode, rays, &mut any);
        only.triangles_batch(mode, rays, &mut triangles);
        let lists = only.all_batch(mode, rays, None).unwrap();
        let few = only.all_batch(mode, rays, Some(2)).unwrap();
        for (i, ray) in rays.iter().enumerate() {
            let counting = self.counting(select, i, ray);
            let some: Vec<Triangle> =
                counting.iter().map(|&i| self.scene.triangles[i as usize]).collect();
            let told = |hit| self.of_counting(&counting, hit);
            let first = mode.closest(&some, ray);
            let want = first.map_or(Hit::MISS, told);
            let at = || format!("{} ray {i}: {ray:?}, {select:?}", mode.level().name());
            assert_eq!(bits(&closest[i]), bits(&want), "{}", at());
            assert_eq!(any[i], first.is_some(), "{}", at());
            let position = first.map_or(Hit::NO_TRIANGLE, |hit| counting[hit.triangle as usize]);
            assert_eq!(triangles[i], position, "{}", at());
            let all: Vec<_> = mode.all(&some, ray).into_iter().map(told).collect();
            assert!(lists.of(i).iter().map(bits).eq(all.iter().map(bits)), "{}", at());
            assert!(few.of(i).iter().map(bits).eq(all.iter().take(2).map(bits)), "{}", at());

            // Asked alone, a ray is the first of the query.
            let skip = select.skip.get(i..i + 1).unwrap_or(&[]);
            let alone = Select { skip, ..*select };
            let only = self.bvh.only(&alone);
            assert_eq!(
                bits(&only.closest(mode, ray).unwrap_or(Hit::MISS)),
                bits(&want),
                "{}",
                at()
            );
            assert_eq!(only.any(mode, ray), first.is_some(), "{}", at());
            assert!(only.all(mode, ray).iter().map(bits).eq(all.iter().map(bits)), "{}", at());
            let mut intersector = only.intersector(mode);
            let hit = intersector.closest(ray).unwrap_or(Hit::MISS);
            assert_eq!(bits(&hit), bits(&want), "{}", at());
            assert_eq!(intersector.triangle(ray).unwrap_or(Hit::NO_TRIANGLE), position, "{}", at());
            assert_eq!(intersector.any(ray), first.is_some(), "{}", at());
        }
        lists.hits.len()
    }

    /// Crossings of the triangles that count.
    fn check_crossings(&self, mode: Exact, select: &Select<'_>) {
        let (rays, only) = (&self.scene.rays[..], self.bvh.only(select));
        let mut counts = vec![Crossings { signed: 7, unsigned: 7 }; rays.len()];
        only.crossings_batch(&mode, rays, &mut counts);
        for (i, ray) in rays.iter().enumerate() {
            let counting = self.counting(select, i, ray);
            let some: Vec<Triangle> =
                counting.iter().map(|&i| self.scene.triangles[i as usize]).collect();
            let all = mode.crossings(&some, ray);
            let mut want = Crossings::default();
            for crossing in &all {
                want.add(crossing.leaves);
            }
            assert_eq!(counts[i], want, "ray {i}: {ray:?}, {select:?}");
            let skip = select.skip.get(i..i + 1).unwrap_or(&[]);
            let got = self.bvh.only(&Select { skip, ..*select }).crossings(&mode, ray);
            let told =
                |c: &intertri::Crossing| (bits(&self.of_counting(&counting, c.hit)), c.leaves);
            assert!(got.iter().map(|c| (bits(&c.hit), c.leaves)).eq(all.iter().map(told)));
        }
    }
}

/// All of a hit; its weights may be NaN.
fn bits(hit: &Hit) -> [u64; 5] {
    let Hit { t, u, v, triangle, geometry } = *hit;
    [t.to_bits(), u.to_bits(), v.to_bits(), triangle.into(), geometry.into()]
}

/// The sign of the direction along the normal, in rationals.
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

/// All kinds of choices, and how many hits are left by them, in all.
fn choices(meshes: &Meshes, level: Level) -> usize {
    let threshold = Threshold::new(meshes.scene.threshold).unwrap();
    let (certified, double) =
        (Certified::new(threshold).at(level), Double::new(threshold).at(level));
    let exact = Exact::at(level);
    // What each ray skips: its first hits, a hit of another, or nothing.
    let all = meshes.bvh.only(&Select::ALL).all_batch(&exact, &meshes.scene.rays, None).unwrap();
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
                let select = Select { mask, faces, skip };
                hits += meshes.check(&certified, &select);
                hits += meshes.check(&exact, &select);
                hits += meshes.check(&double, &select);
                meshes.check_crossings(exact, &select);
            }
        }
    }
    hits
}

#[test]
fn every_family_in_meshes_by_every_choice() {
    let levels: Vec<Level> = Level::all().collect();
    let hits = common::each_family(|i, family| {
        let mut rng = Rng::new(39 + i as u64);
        let of = |size| {
            let scene = common::scene(family, &mut rng, size, 12);
            let first = scene.triangles.len() / 3;
            choices(&Meshes::new(scene, first), levels[i % levels.len()])
        };
        [1, 30, 200].map(of).iter().sum::<usize>()
    });
    let hits: usize = hits.iter().sum();
    println!("{hits} hits");
    assert!(hits > 10_000);
}

/// The same triangles in both meshes: of equal t the lower geometry is closer, then the lower triangle.
#[test]
fn ties_go_by_the_position_in_the_whole() {
    let mut rng = Rng::new(40);
    for family in FAMILIES {
        let mut scene = common::scene(family, &mut rng, 20, 30);
        let again = scene.triangles.clone();
        scene.triangles.extend(again.iter().rev());
        let meshes = Meshes::new(scene, again.len());
        for level in Level::all() {
            meshes.check(&Exact::at(level), &Select::ALL);
            meshes.check(&Certified::default().at(level), &Select { mask: 0b100, ..Select::ALL });
        }
    }
}

/// A bundle of rays from one origin, and one that a mask keeps from being one.
#[test]
fn rays_of_one_origin_go_by_the_choice() {
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
        let all = meshes.check(&Exact::at(level), &Select::ALL);
        let one = meshes.check(&Exact::at(level), &Select { mask: 0b001, ..Select::ALL });
        assert!(one > 200 && all > one + 200, "{all} {one}");
    }
}

#[test]
#[should_panic(expected = "a list of what to skip")]
fn a_list_a_ray_or_none() {
    let bvh = Bvh::new(&[]).unwrap();
    let rays = [Ray::new([0.0; 3], [0.0, 0.0, 1.0]); 3];
    let select = Select { skip: &[&[], &[]], ..Select::ALL };
    let _ = bvh.only(&select).all_batch(&Exact::default(), &rays, None);
}

/// One that is hidden from every mask is hidden from queries without one.
#[test]
fn a_geometry_without_a_mask_never_counts() {
    let wall = [Triangle::new([0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0])];
    let mut bvh = Bvh::of_meshes(&[&wall, &wall]).unwrap();
    let ray = Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, 1.0]);
    let hit =
        |bvh: &Bvh| bvh.closest(&Exact::default(), &ray).map(|hit| (hit.geometry, hit.triangle));
    assert_eq!(hit(&bvh), Some((0, 0)));
    bvh.set_mask(0, 0);
    assert_eq!(hit(&bvh), Some((1, 0)));
    assert_eq!((bvh.geometries(), bvh.geometry_of(1), bvh.len()), (2, (1, 0), 2));
}
