//! Tests the `fixed` mode by comparing it with its scalar i128 reference and with rational
//! arithmetic, by tracing rays through closed meshes, and by a golden hash.

use intertri::fixed::{Ray, Triangle};
use intertri::simd::Level;
use intertri::{Crossing, Crossings, Hit, Ray as Line};
use intertri_trace::{Bvh, Query};

mod bundles;
mod golden;
mod hierarchy;
mod meshes;
mod rationals;
mod scalar;
mod solids;

/// A hierarchy over grid triangles that were converted to f32. Its queries follow the once rule and
/// report t in the same unit as [`Fixed`].
///
/// [`Fixed`]: intertri::fixed::Fixed
struct GridBvh(Bvh);

impl GridBvh {
    fn new(triangles: &[Triangle]) -> Self {
        let in_f32: Vec<_> = triangles.iter().map(Triangle::to_f32).collect();
        Self(Bvh::new(&in_f32).unwrap())
    }

    fn query(&self, level: Level) -> GridQuery<'_> {
        GridQuery(self.0.query().once().at(level))
    }
}

/// A query over a [`GridBvh`].
struct GridQuery<'a>(Query<'a>);

impl GridQuery<'_> {
    fn closest(&mut self, ray: &Ray) -> Option<Hit> {
        self.0.closest(ray.to_f32()).map(|hit| for_caller(ray, hit))
    }

    fn any(&mut self, ray: &Ray) -> bool {
        self.0.any(ray.to_f32())
    }

    fn all(&mut self, ray: &Ray) -> Vec<Hit> {
        self.0.all(ray.to_f32()).into_iter().map(|hit| for_caller(ray, hit)).collect()
    }

    fn crossings(&mut self, ray: &Ray) -> Vec<Crossing> {
        let crossings = self.0.crossings(ray.to_f32()).into_iter();
        crossings
            .map(|crossing| Crossing { hit: for_caller(ray, crossing.hit), ..crossing })
            .collect()
    }

    fn closest_batch(&self, rays: &[Ray]) -> Vec<Hit> {
        let hits = self.0.closest_batch(&lines(rays));
        rays.iter().zip(hits).map(|(ray, hit)| for_caller(ray, hit)).collect()
    }

    fn any_batch(&self, rays: &[Ray]) -> Vec<bool> {
        self.0.any_batch(&lines(rays))
    }

    fn count_crossings_batch(&self, rays: &[Ray]) -> Vec<Crossings> {
        self.0.count_crossings_batch(&lines(rays))
    }
}

/// Converts grid rays to f32.
fn lines(rays: &[Ray]) -> Vec<Line> {
    rays.iter().map(|ray| *ray.to_f32()).collect()
}

/// Converts the t of a hit to a multiple of the direction that the ray had before snapping.
fn for_caller(ray: &Ray, hit: Hit) -> Hit {
    if hit.is_hit() { Hit { t: ray.t_of_caller(hit.t), ..hit } } else { hit }
}

/// A pseudorandom generator that produces the same numbers on every machine.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    /// Generates a number in `0..n`.
    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// Generates a number in `-limit..=limit`.
    fn within(&mut self, limit: i32) -> i32 {
        (self.below(2 * limit as u64 + 1) as i64 - i64::from(limit)) as i32
    }

    fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len() as u64) as usize]
    }

    fn vector(&mut self, limit: i32) -> [i32; 3] {
        [(); 3].map(|()| self.within(limit))
    }
}

fn sub(a: [i32; 3], b: [i32; 3]) -> [i32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn add(a: [i32; 3], b: [i32; 3]) -> [i32; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
