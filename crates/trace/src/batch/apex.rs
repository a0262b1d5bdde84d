//! Sorts rays that share an origin or an end by their directions, if their order is not coherent.
//!
//! Such rays are fastest to trace if consecutive ones form a narrow cone. The shadow rays of an
//! image are in the order of its pixels, without the pixels that see nothing. As seen from the
//! light, a row of them is a long curve:
//!
//! ```text
//!      order of the rays            cells of a grid, in Z-order
//!      ─╮    ╭──────╮                 0  1 │ 4  5
//!    ───╰────╯──────╯───►     ──►     2  3 │ 6  7        rays of the same cell keep their order
//!      ─╮ ╭─────────╮                ──────┼──────
//!    ───╰─╯─────────╯───►             8  9 │ 12 13
//! ```
//!
//! The order does not affect the results.

use intertri::simd::{Lanes, Level, Simd, Vec3, WithSimd};
use intertri::{Ray, RayOf, Scalar, Threshold};

use crate::walk::bundle::{CommonEnd, shares_origin};

/// The number of rays that are sorted together. Twice as many were slower for shadow rays in rows.
const WINDOW: usize = 1 << 15;

/// The number of rays that are sorted together if their order is random. The more there are, the
/// closer together they are after sorting. There cannot be more, because indices have 16 bits.
const WIDE_WINDOW: usize = 1 << 16;

/// The minimum number of rays for which sorting can pay off.
const FEWEST: usize = 1 << 11;

/// The minimum number of rays in random order for which sorting can pay off.
const FEWEST_RANDOM: usize = 1 << 15;

/// The number of cells along each axis of a side of the cube: a power of two.
const CELLS: usize = 1 << BITS;
const BITS: usize = 6;

/// The number of sides of the cube, rounded up to a power of two.
const SIDES: usize = 8;

/// The number of rays that are projected at a time.
const LANES: usize = 16;

/// Adding this number, 1.5 * 2^23, rounds a number to an integer, which is then in the lowest bits.
const ROUND: f32 = 12_582_912.0;

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

/// The smallest box around directions that are projected onto the cube around the origin.
#[derive(Clone, Copy)]
struct Bounds {
    least: [f32; 3],
    most: [f32; 3],
}

impl Bounds {
    const NONE: Self = Self { least: [f32::INFINITY; 3], most: [f32::NEG_INFINITY; 3] };

    fn add(&mut self, dir: [f32; 3]) {
        let longest = dir.iter().fold(0.0_f32, |most, d| most.max(d.abs()));
        let scale = 1.0 / longest;
        for ((least, most), d) in self.least.iter_mut().zip(&mut self.most).zip(dir) {
            (*least, *most) = (least.min(d * scale), most.max(d * scale));
        }
    }

    /// Returns the sum of the sides, and half the area.
    fn sizes(&self) -> [f32; 2] {
        let [x, y, z] = [0, 1, 2].map(|k| (self.most[k] - self.least[k]).max(0.0));
        [x + y + z, x * y + y * z + z * x]
    }
}

/// Returns how many rays should be sorted at a time, if all rays appear to share an origin or, if
/// `ends` is set, an end, and are in an order that is slow to trace. Only some of the rays are
/// examined.
pub(super) fn window<S: Scalar>(rays: &[RayOf<S>], ends: bool) -> Option<usize> {
    let count = rays.len();
    let rays = &rays[..count.min(WINDOW)];
    let [first, .., last] = rays else { return None };
    let [first, last] = [first, last].map(in_f32);
    let shares = |ray: &Ray| {
        let three = [first, *ray, last];
        shares_origin(&three) || ends && CommonEnd::of(&three, Threshold::DEFAULT).is_some()
    };
    if count < FEWEST || !shares(&first) {
        return None;
    }
    let (mut all, mut areas) = (Bounds::NONE, [0.0; RUNS]);
    let [mut of_packets, mut of_runs] = [0.0; 2];
    let runs = rays.chunks(rays.len() / RUNS).map(|rays| &rays[..rays.len().min(RUN)]);
    for (run, area) in runs.zip(&mut areas) {
        let mut bounds = Bounds::NONE;
        // All rays of the first packet, and some of the others.
        let (packet, others) = run.split_at(PACKET);
        for (i, ray) in packet.iter().chain(others.iter().step_by(4)).enumerate() {
            let ray = in_f32(ray);
            if !shares(&ray) {
                return None;
            }
            bounds.add(ray.dir);
            all.add(ray.dir);
            if i == PACKET - 1 {
                of_packets += bounds.sizes()[0];
            }
        }
        let of_run;
        [of_run, *area] = bounds.sizes();
        of_runs += of_run;
    }
    if of_packets > WIDE * of_runs {
        return (count >= FEWEST_RANDOM).then_some(WIDE_WINDOW);
    }
    // In tiles, the areas of all runs of the window would add up to about the whole area.
    areas.sort_unstable_by(f32::total_cmp);
    let area = areas[RUNS / 2] * (rays.len() / RUN) as f32;
    (area > SCATTERED * all.sizes()[1]).then_some(WINDOW)
}

fn in_f32<S: Scalar>(ray: &RayOf<S>) -> Ray {
    let narrow = |x: S| Into::<f64>::into(x) as f32;
    let [origin, dir] = [ray.origin, ray.dir].map(|v| v.map(narrow));
    Ray::new(origin, dir).between(narrow(ray.t_min), narrow(ray.t_max))
}

/// Sorts windows of rays. The memory is used again for each window.
#[derive(Default)]
pub(super) struct Sorter {
    /// The sides of the cube that the rays pass through, and the positions on these sides.
    sides: Vec<f32>,
    at: [Vec<f32>; 2],
    /// The cell of each ray.
    cells: Vec<u16>,
    /// For each cell, the number of rays in it, and then where they begin.
    begins: Vec<u16>,
    /// For each place in the sorted order, the index of its ray.
    order: Vec<u16>,
}

impl Sorter {
    /// Finds the order in which up to 2^16 rays are traced.
    pub(super) fn sort<X: Scalar>(&mut self, level: Level, rays: &[RayOf<X>]) -> &[u16] {
        level.run(FindCells { rays, sorter: self });
        let Self { cells, begins, order, .. } = self;
        begins.clear();
        begins.resize(SIDES * CELLS * CELLS, 0);
        cells.truncate(rays.len());
        // A single cell with 2^16 rays counts 0, but it begins at 0 in any case.
        for &cell in &*cells {
            let count = &mut begins[usize::from(cell)];
            *count = count.wrapping_add(1);
        }
        // Each cell begins where the one before it ends.
        let mut begin = 0;
        for cell in &mut *begins {
            let count = *cell;
            *cell = begin;
            begin = begin.wrapping_add(count);
        }
        order.resize(rays.len(), 0);
        for (&cell, i) in cells.iter().zip(0..=u16::MAX) {
            let place = &mut begins[usize::from(cell)];
            order[usize::from(*place)] = i;
            *place = place.wrapping_add(1);
        }
        order
    }
}

/// Finds the cell of each ray.
struct FindCells<'a, X> {
    rays: &'a [RayOf<X>],
    sorter: &'a mut Sorter,
}

impl<X: Scalar> WithSimd for FindCells<'_, X> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { rays, sorter: Sorter { sides, at: [across, along], cells, .. } } = self;
        let padded = rays.len().next_multiple_of(LANES);
        for row in [&mut *sides, &mut *across, &mut *along] {
            row.resize(padded, 0.0);
        }
        cells.resize(padded, 0);

        // Project the directions onto the cube, and find the rectangle around all positions.
        let splat = S::F32x16::splat;
        let (mut least, mut most) = ([splat(f32::INFINITY); 2], [splat(f32::NEG_INFINITY); 2]);
        for (i, rays) in rays.chunks(LANES).enumerate() {
            let mut dir = [[0.0; LANES]; 3];
            for lane in 0..LANES {
                let ray = &rays[lane.min(rays.len() - 1)];
                for (to, d) in dir.iter_mut().zip(ray.dir) {
                    to[lane] = Into::<f64>::into(d) as f32;
                }
            }
            let (side, at) = on_cube(Vec3::<S::F32x16>::load(&dir));
            for k in 0..2 {
                (least[k], most[k]) = (at[k].min(least[k]), at[k].max(most[k]));
            }
            side.store(&mut sides[LANES * i..]);
            at[0].store(&mut across[LANES * i..]);
            at[1].store(&mut along[LANES * i..]);
        }
        let [x, y] = [0, 1].map(
            #[inline(always)]
            |k: usize| Axis::<S::F32x16>::new(least[k], most[k]),
        );

        for (i, cells) in cells.chunks_mut(LANES).enumerate() {
            let (mut column, mut row) = ([0.0; LANES], [0.0; LANES]);
            x.cells(S::F32x16::load(&across[LANES * i..])).store(&mut column);
            y.cells(S::F32x16::load(&along[LANES * i..])).store(&mut row);
            for (lane, cell) in cells.iter_mut().enumerate() {
                // The lowest bits of the numbers are the integers.
                let at = |x: f32| SPREAD[x.to_bits() as usize % CELLS];
                let side = sides[LANES * i + lane].to_bits() as usize % SIDES;
                *cell = (side * CELLS * CELLS) as u16 | at(column[lane]) | at(row[lane]) << 1;
            }
        }
    }
}

/// Projects directions onto the cube around the origin. Returns the side, as an integer in the lowest
/// bits of a number, and the position on that side.
#[inline(always)]
fn on_cube<F: Lanes<Scalar = f32>>(dir: Vec3<F>) -> (F, [F; 2]) {
    let (x, y, z) = (dir.x.abs(), dir.y.abs(), dir.z.abs());
    let most = x.max(y).max(z);
    let (on_x, on_y) = (most.le(x), most.le(y));
    let of = |x: F, y: F, z: F| F::select(on_x, x, F::select(on_y, y, z));
    let (longest, a, b) =
        (of(dir.x, dir.y, dir.z), of(dir.y, dir.z, dir.x), of(dir.z, dir.x, dir.y));
    let number = |side: u32| F::splat(f32::from_bits(ROUND.to_bits() + side));
    let side = F::select(
        longest.lt(F::splat(0.0)),
        of(number(4), number(5), number(6)),
        of(number(0), number(1), number(2)),
    );
    let inverse = F::splat(1.0) / most;
    (side, [a * inverse, b * inverse])
}

/// An axis of the grid of cells.
#[derive(Clone, Copy)]
struct Axis<F> {
    scale: F,
    offset: F,
}

impl<F: Lanes<Scalar = f32>> Axis<F> {
    /// Divides the interval between two positions, each the extreme of all lanes.
    #[inline(always)]
    fn new(least: F, most: F) -> Self {
        let (mut lo, mut hi) = ([0.0; LANES], [0.0; LANES]);
        least.store(&mut lo);
        most.store(&mut hi);
        let lo = lo.iter().fold(f32::INFINITY, |a, b| a.min(*b));
        let hi = hi.iter().fold(f32::NEG_INFINITY, |a, b| a.max(*b));
        let scale = (CELLS - 2) as f32 / (hi - lo).max(f32::MIN_POSITIVE);
        Self { scale: F::splat(scale), offset: F::splat(ROUND - lo * scale) }
    }

    /// Returns the cell of each position, as an integer in the lowest bits of a number.
    #[inline(always)]
    fn cells(&self, at: F) -> F {
        at.mul_add(self.scale, self.offset)
    }
}

/// The bits of each number, moved to every other position.
const SPREAD: [u16; CELLS] = {
    let (mut spread, mut i) = ([0; CELLS], 0);
    while i < CELLS {
        let mut bit = 0;
        while bit < BITS {
            spread[i] |= ((i >> bit & 1) << (2 * bit)) as u16;
            bit += 1;
        }
        i += 1;
    }
    spread
};

#[cfg(test)]
mod tests {
    use intertri::Ray;
    use intertri::simd::Level;

    use super::{FEWEST_RANDOM, Sorter, WIDE_WINDOW, WINDOW, window};
    use crate::util::test_numbers::random;

    /// The width of the image of [`rays`].
    const WIDTH: usize = 256;

    /// Returns rays from a light to what an orthographic camera sees of a wavy surface.
    fn rays(count: usize, pixel: impl Fn(usize) -> [usize; 2]) -> Vec<Ray> {
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

        let [rows, tiles] = [reversed(&rows), reversed(&tiles)];
        assert_eq!([window(&rows, true), window(&tiles, true)], [Some(WINDOW), None]);
        // Directions of any length, which end at a t below 1.
        let long = |ray: &Ray| Ray::new(ray.origin, ray.dir.map(|d| 4.0 * d)).between(0.0, 0.25);
        let long: Vec<Ray> = rows.iter().map(long).collect();
        assert_eq!(window(&long, true), Some(WINDOW));
        // For closest hits, a common end is of no use.
        assert_eq!(window(&rows, false), None);
    }

    #[test]
    fn each_ray_has_a_place_and_neighbours_are_close() {
        let mut rays = rays(WIDTH * WIDTH, |i| [i % WIDTH, i / WIDTH]);
        for (i, x) in [f32::NAN, f32::INFINITY, 0.0, f32::MAX, 1e-45].into_iter().enumerate() {
            rays[1000 * i].dir = [x; 3];
            rays[999 + 1000 * i].dir[i % 3] = x;
        }
        for count in [0, 1, 15, 16, 17, 5000, WINDOW, WIDE_WINDOW] {
            let rays = &rays[..count];
            for level in Level::all() {
                let mut sorter = Sorter::default();
                let order = sorter.sort(level, rays);
                let mut places = order.to_vec();
                places.sort_unstable();
                assert!(places.iter().map(|&i| usize::from(i)).eq(0..count), "{level:?} {count}");
            }
        }

        // Without the odd directions, packets are much narrower than before.
        rays.retain(|ray| ray.dir.iter().all(|d| d.abs() < 10.0) && ray.dir[1] < -1.0);
        let rays = &rays[..WINDOW];
        let mut sorter = Sorter::default();
        let order = sorter.sort(Level::best(), rays);
        let sorted: Vec<Ray> = order.iter().map(|&i| rays[usize::from(i)]).collect();
        let area = |rays: &[Ray]| -> f32 {
            let of = |rays: &[Ray]| {
                let mut bounds = super::Bounds::NONE;
                for ray in rays {
                    bounds.add(ray.dir);
                }
                bounds.sizes()[1]
            };
            rays.chunks(256).map(of).sum()
        };
        assert!(area(&sorted) < 0.2 * area(rays), "{} {}", area(&sorted), area(rays));
    }
}
