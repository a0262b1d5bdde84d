//! Sorts rays that share an origin or an end by their directions, and parallel rays by the positions of
//! their lines, if their order is not coherent.
//!
//! Such rays are fastest to trace if consecutive ones are close together. The shadow rays of an
//! image are in the order of its pixels, without the pixels that see nothing. As seen from the
//! light, a row of them is a long curve.
//!
//! The order does not affect the results.

use intertri::{Ray, RayOf, Scalar, Threshold};

use crate::walk::beam::ProjectionPlane;
use crate::walk::bundle::{CommonEnd, shares_direction, shares_origin};

/// The number of rays that are sorted together. Twice as many were slower for shadow rays in rows.
pub(super) const WINDOW: usize = 1 << 15;

/// The number of rays that are sorted together if their order is random. The more there are, the
/// closer together they are after sorting. There cannot be more, because indices have 16 bits. It is also
/// the number of rays that are tested for occluders together if they are not sorted.
pub(super) const WIDE_WINDOW: usize = 1 << 16;

/// The minimum number of rays for which sorting can pay off.
const FEWEST: usize = 1 << 11;

/// The minimum number of rays in random order for which sorting can pay off.
const FEWEST_RANDOM: usize = 1 << 15;

/// The order is examined in this many runs of [`RUN`] consecutive rays.
const RUNS: usize = 8;
const RUN: usize = 256;

/// Rays are sorted if the directions of at least half of the runs cover an area that is more than this
/// many times as large as that of the same number of rays in tiles.
const SCATTERED: f32 = 8.0;

/// The number of rays in a packet. If packets are more than [`WIDE`] times as wide as the runs to which
/// they belong, the order is random: in tiles, they are about a quarter as wide.
const PACKET: usize = 16;
const WIDE: f32 = 0.6;

/// What several rays have in common, and what they are sorted by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SortKey {
    /// An origin or an end.
    Point,
    /// A direction.
    Direction([f32; 3]),
}

/// How rays are sorted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sorting {
    pub(super) key: SortKey,
    /// The number of rays that are sorted together.
    pub(super) window: usize,
}

impl SortKey {
    /// Returns what some rays have in common. With `ends`, that may be their end.
    fn of(rays: &[Ray; 3], ends: bool) -> Option<Self> {
        if shares_origin(rays) || ends && CommonEnd::of(rays, Threshold::DEFAULT).is_some() {
            Some(Self::Point)
        } else {
            shares_direction(rays).then_some(Self::Direction(rays[0].dir))
        }
    }

    /// Returns the position of a ray: where its direction meets the cube around 0, or where the line of
    /// one of several parallel rays meets a plane through 0.
    pub(super) fn position(self, ray: &Ray) -> [f32; 3] {
        match self {
            Self::Point => {
                let longest = ray.dir.iter().fold(0.0_f32, |most, d| most.max(d.abs()));
                ray.dir.map(|d| d / longest)
            }
            Self::Direction(dir) => {
                let plane = ProjectionPlane::new(dir.map(f64::from));
                let [a, b] = plane.place(ray.origin.map(f64::from));
                [a as f32, b as f32, 0.0]
            }
        }
    }
}

/// The smallest box around positions of rays.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    least: [f32; 3],
    most: [f32; 3],
}

impl Bounds {
    pub(super) const NONE: Self = Self { least: [f32::INFINITY; 3], most: [f32::NEG_INFINITY; 3] };

    pub(super) fn add(&mut self, position: [f32; 3]) {
        for ((least, most), x) in self.least.iter_mut().zip(&mut self.most).zip(position) {
            (*least, *most) = (least.min(x), most.max(x));
        }
    }

    /// Returns the sum of the sides, and half the area.
    pub(super) fn sizes(&self) -> [f32; 2] {
        let [x, y, z] = [0, 1, 2].map(|k| (self.most[k] - self.least[k]).max(0.0));
        [x + y + z, x * y + y * z + z * x]
    }
}

/// Returns how rays should be sorted, if all rays appear to share an origin, a direction, or, if `ends`
/// is set, an end, and are in an order that is slow to trace. Only some of the rays are examined.
pub(super) fn sorting<S: Scalar>(rays: &[RayOf<S>], ends: bool) -> Option<Sorting> {
    let count = rays.len();
    let rays = &rays[..count.min(WINDOW)];
    let [first, .., last] = rays else { return None };
    let [first, last] = [first, last].map(in_f32);
    if count < FEWEST {
        return None;
    }
    let key = SortKey::of(&[first, first, last], ends)?;
    let (mut all, mut areas) = (Bounds::NONE, [0.0; RUNS]);
    let [mut of_packets, mut of_runs] = [0.0; 2];
    let runs = rays.chunks(rays.len() / RUNS).map(|rays| &rays[..rays.len().min(RUN)]);
    for (run, area) in runs.zip(&mut areas) {
        let mut bounds = Bounds::NONE;
        // All rays of the first packet, and some of the others.
        let (packet, others) = run.split_at(PACKET);
        for (i, ray) in packet.iter().chain(others.iter().step_by(4)).enumerate() {
            let ray = in_f32(ray);
            if SortKey::of(&[first, ray, last], ends) != Some(key) {
                return None;
            }
            let position = key.position(&ray);
            bounds.add(position);
            all.add(position);
            if i == PACKET - 1 {
                of_packets += bounds.sizes()[0];
            }
        }
        let of_run;
        [of_run, *area] = bounds.sizes();
        of_runs += of_run;
    }
    if of_packets > WIDE * of_runs {
        return (count >= FEWEST_RANDOM).then_some(Sorting { key, window: WIDE_WINDOW });
    }
    // In tiles, the areas of all runs of the window would add up to about the whole area.
    areas.sort_unstable_by(f32::total_cmp);
    let area = areas[RUNS / 2] * (rays.len() / RUN) as f32;
    (area > SCATTERED * all.sizes()[1]).then_some(Sorting { key, window: WINDOW })
}

fn in_f32<S: Scalar>(ray: &RayOf<S>) -> Ray {
    let narrow = |x: S| Into::<f64>::into(x) as f32;
    let [origin, dir] = [ray.origin, ray.dir].map(|v| v.map(narrow));
    Ray::new(origin, dir).between(narrow(ray.t_min), narrow(ray.t_max))
}

#[cfg(test)]
pub(super) mod tests {
    use intertri::Ray;

    use super::{FEWEST_RANDOM, WIDE_WINDOW, WINDOW, sorting};
    use crate::util::test_numbers::random;

    /// The width of the image of [`rays`].
    pub(in super::super) const WIDTH: usize = 256;

    /// Returns rays from a light to what an orthographic camera sees of a wavy surface.
    pub(in super::super) fn rays(count: usize, pixel: impl Fn(usize) -> [usize; 2]) -> Vec<Ray> {
        let ray = |i| {
            let [x, y] = pixel(i).map(|k| k as f32 / WIDTH as f32 - 0.5);
            let depth = 0.3 * (11.0 * x).sin() * (7.0 * y).cos();
            Ray::new([0.4, 2.0, -1.0], [x - 0.4, depth - 2.0, y + 1.0]).between(0.0, 1.0)
        };
        (0..count).map(ray).collect()
    }

    /// Returns the same segments from their other ends.
    fn reversed(rays: &[Ray]) -> Vec<Ray> {
        let turn = |ray: &Ray| {
            let origin = [0, 1, 2].map(|k| ray.origin[k] + ray.dir[k]);
            Ray::new(origin, ray.dir.map(|d| -d)).between(0.0, 1.0)
        };
        rays.iter().map(turn).collect()
    }

    /// Returns rays from what the camera sees toward the sun.
    pub(in super::super) fn to_sun(rays: &[Ray]) -> Vec<Ray> {
        reversed(rays).iter().map(|ray| Ray::new(ray.origin, [0.5, 2.0, -1.5])).collect()
    }

    /// Returns how many rays are sorted together.
    fn window(rays: &[Ray], ends: bool) -> Option<usize> {
        sorting(rays, ends).map(|sorting| sorting.window)
    }

    fn in_tiles(i: usize) -> [usize; 2] {
        let even = |n: usize| (0..8).map(|bit| (n >> (2 * bit) & 1) << bit).sum();
        [even(i), even(i >> 1)]
    }

    #[test]
    fn rows_and_random_orders_are_sorted_and_tiles_are_not() {
        let count = WIDTH * WIDTH;
        let rows = rays(count, |i| [i % WIDTH, i / WIDTH]);
        let tiles = rays(count, in_tiles);
        let mut mixed = tiles.clone();
        let mut random = random();
        for i in (1..count).rev() {
            mixed.swap(i, ((random() * i as f32) as usize).min(i));
        }
        assert_eq!(window(&rows, false), Some(WINDOW));
        assert_eq!(window(&tiles, false), None);
        assert_eq!(window(&mixed, false), Some(WIDE_WINDOW));
        assert_eq!(window(&mixed[..FEWEST_RANDOM - 1], false), None);
        assert_eq!(window(&rows[..1000], false), None);

        // Parallel rays, for closest hits and for any hit.
        let parallel = [&rows, &tiles, &mixed].map(|rays| to_sun(rays));
        for ends in [false, true] {
            let windows = parallel.each_ref().map(|rays| window(rays, ends));
            assert_eq!(windows, [Some(WINDOW), None, Some(WIDE_WINDOW)]);
        }

        let [rows, tiles] = [reversed(&rows), reversed(&tiles)];
        assert_eq!([window(&rows, true), window(&tiles, true)], [Some(WINDOW), None]);
        // Directions of any length, which end at a t below 1.
        let long = |ray: &Ray| Ray::new(ray.origin, ray.dir.map(|d| 4.0 * d)).between(0.0, 0.25);
        let long: Vec<Ray> = rows.iter().map(long).collect();
        assert_eq!(window(&long, true), Some(WINDOW));
        // For closest hits, a common end is of no use.
        assert_eq!(window(&rows, false), None);
    }
}
