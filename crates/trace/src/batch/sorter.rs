//! Sorts rays by the cell that they pass through, with a counting sort.
//!
//! ```text
//!      order of the rays            cells of a grid, in Z-order
//!      ─╮    ╭──────╮                 0  1 │ 4  5
//!    ───╰────╯──────╯───►     ──►     2  3 │ 6  7        rays of the same cell keep their order
//!      ─╮ ╭─────────╮                ──────┼──────
//!    ───╰─╯─────────╯───►             8  9 │ 12 13
//! ```

use intertri::simd::{Lanes, Level, Simd, Vec3, WithSimd};
use intertri::{Ray, RayOf, Scalar};

use super::apex::SortKey;
use crate::walk::beam::ProjectionPlane;
use crate::walk::bundle::half;

/// The number of cells along each axis of a side of the cube: a power of two.
const CELLS: usize = 1 << BITS;
const BITS: usize = 6;

/// The number of sides of the cube, rounded up to a power of two.
const SIDES: usize = 8;

/// The number of rays that are projected at a time.
const LANES: usize = 16;

/// Adding this number, 1.5 * 2^23, rounds a number to an integer, which is then in the lowest bits.
const ROUND: f32 = 12_582_912.0;

/// Sorts windows of rays. The memory is used again for each window.
#[derive(Default)]
pub(super) struct Sorter {
    /// The sides of the cube that the rays pass through, and the positions on these sides.
    sides: Vec<f32>,
    at: [Vec<f32>; 2],
    /// The cell of each ray.
    cells: Vec<u16>,
    /// For each cell, the number of rays in it, from the first and the second half of the window,
    /// and then where they begin.
    begins: Vec<[u16; 2]>,
    /// For each place in the sorted order, the index of its ray.
    order: Vec<u16>,
}

impl Sorter {
    /// Finds the order in which up to 2^16 rays are traced.
    pub(super) fn sort<X: Scalar>(
        &mut self,
        level: Level,
        (key, rays): (SortKey, &[RayOf<X>]),
    ) -> &[u16] {
        debug_assert!(rays.len() <= 1 << 16);
        level.run(FindCells { key, rays, sorter: self });
        let Self { cells, begins, order, .. } = self;
        begins.clear();
        begins.resize(SIDES * CELLS * CELLS, [0; 2]);
        cells.truncate(rays.len());
        order.resize(rays.len(), 0);
        // Count two halves side by side: neighbours are often in the same cell, and each would have
        // to wait for the count of the one before it.
        let half = cells.len().div_ceil(2);
        let (first, last) = cells.split_at(half);
        let middle = first.get(last.len());
        // Returns a cell's number for a half, and increments it.
        let next = |begins: &mut [[u16; 2]], cell: u16, half: usize| {
            let number = &mut begins[usize::from(cell)][half];
            let before = *number;
            *number = before.wrapping_add(1);
            usize::from(before)
        };
        for (&a, &b) in first.iter().zip(last) {
            next(begins, a, 0);
            next(begins, b, 1);
        }
        if let Some(&cell) = middle {
            next(begins, cell, 0);
        }
        // Each cell begins where the one before it ends, with the rays of the first half. With 2^16
        // rays, the cells after the last ray begin at 0, but they are empty.
        let mut begin = 0_u16;
        for halves in &mut *begins {
            let [a, b] = *halves;
            *halves = [begin, begin.wrapping_add(a)];
            begin = begin.wrapping_add(a).wrapping_add(b);
        }
        for ((&a, &b), i) in first.iter().zip(last).zip(0..) {
            order[next(begins, a, 0)] = i;
            order[next(begins, b, 1)] = half as u16 + i;
        }
        if let Some(&cell) = middle {
            order[next(begins, cell, 0)] = last.len() as u16;
        }
        order
    }
}

/// Finds the cell of each ray.
struct FindCells<'a, X> {
    key: SortKey,
    rays: &'a [RayOf<X>],
    sorter: &'a mut Sorter,
}

impl<X: Scalar> WithSimd for FindCells<'_, X> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { key, rays, sorter: Sorter { sides, at: [across, along], cells, .. } } = self;
        let padded = rays.len().next_multiple_of(LANES);
        for row in [&mut *sides, &mut *across, &mut *along] {
            row.resize(padded, 0.0);
        }
        cells.resize(padded, 0);

        // Project the directions onto the cube, or the origins along the direction, and find the
        // rectangle around all positions.
        let splat = S::F32x16::splat;
        let (mut least, mut most) = ([splat(f32::INFINITY); 2], [splat(f32::NEG_INFINITY); 2]);
        for (i, rays) in rays.chunks(LANES).enumerate() {
            let row = columns::<S, X>(rays, key);
            let (side, at) = match key {
                SortKey::Point => on_cube(row),
                SortKey::Direction(dir) => on_plane(dir, row),
            };
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
            let load = |row: &[f32]| S::F32x16::load(&row[LANES * i..]);
            // Both integers together are the index of a cell, row by row.
            let cell =
                x.cells(load(across)) + splat(CELLS as f32) * (y.cells(load(along)) - splat(ROUND));
            let mut at = [0.0; LANES];
            cell.store(&mut at);
            for ((cell, at), side) in cells.iter_mut().zip(at).zip(&sides[LANES * i..]) {
                let (at, side) =
                    (at.to_bits() as usize % (CELLS * CELLS), side.to_bits() as usize % SIDES);
                *cell = (side * CELLS * CELLS) as u16 | Z_ORDER[at];
            }
        }
    }
}

/// Projects directions onto the cube around the origin. Returns the side, as an integer in the
/// lowest bits of a number, and the position on that side.
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

/// Projects origins along a direction onto a plane. Returns the side of a cube, which is the same
/// for all, and the position on the plane.
#[inline(always)]
fn on_plane<F: Lanes<Scalar = f32>>(dir: [f32; 3], origin: Vec3<F>) -> (F, [F; 2]) {
    let ProjectionPlane { axes, slope } = ProjectionPlane::new(dir.map(f64::from));
    let [along, a, b] = match axes[0] {
        0 => [origin.x, origin.y, origin.z],
        1 => [origin.y, origin.z, origin.x],
        _ => [origin.z, origin.x, origin.y],
    };
    let [to_a, to_b] = slope.map(|slope| F::splat(-slope as f32));
    let at = [along.mul_add(to_a, a), along.mul_add(to_b, b)];
    (F::splat(ROUND), at)
}

/// Loads the directions of up to sixteen rays into lanes or, if the rays share a direction, their
/// origins. The last ray fills the remaining lanes.
#[inline(always)]
fn columns<S: Simd, X: Scalar>(rays: &[RayOf<X>], key: SortKey) -> Vec3<S::F32x16> {
    let (last, part) = (rays.len() - 1, usize::from(key == SortKey::Point));
    if const { size_of::<X>() == size_of::<f32>() } {
        let rays: &[Ray] = bytemuck::cast_slice(rays);
        let [x, y, z, _] = S::columns(
            #[inline(always)]
            |i| half(&rays[i.min(last)], part),
        );
        return Vec3 { x, y, z };
    }
    let mut row = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let ray = &rays[lane.min(last)];
        for (to, x) in row.iter_mut().zip([ray.origin, ray.dir][part]) {
            to[lane] = Into::<f64>::into(x) as f32;
        }
    }
    Vec3::load(&row)
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

/// For each cell of a side, row by row, its place in Z-order: the bits of the column and of the row
/// alternate.
static Z_ORDER: [u16; CELLS * CELLS] = {
    let (mut order, mut i) = ([0; CELLS * CELLS], 0);
    while i < CELLS * CELLS {
        let mut bit = 0;
        while bit < BITS {
            let (column, row) = (i >> bit & 1, i >> BITS >> bit & 1);
            order[i] |= ((column | row << 1) << (2 * bit)) as u16;
            bit += 1;
        }
        i += 1;
    }
    order
};

#[cfg(test)]
mod tests {
    use intertri::Ray;
    use intertri::simd::Level;

    use super::Sorter;
    use crate::batch::apex::tests::{WIDTH, rays, to_sun};
    use crate::batch::apex::{Bounds, SortKey, WIDE_WINDOW, WINDOW};

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
                let mut places = sorter.sort(level, (SortKey::Point, rays)).to_vec();
                // Rays of the same cell keep their order.
                let cell = |i: u16| sorter.cells[usize::from(i)];
                assert!(places.is_sorted_by_key(|&i| (cell(i), i)), "{level:?} {count}");
                places.sort_unstable();
                assert!(places.iter().map(|&i| usize::from(i)).eq(0..count), "{level:?} {count}");
            }
        }

        // Without the odd directions, packets are much narrower than before.
        rays.retain(|ray| ray.dir.iter().all(|d| d.abs() < 10.0) && ray.dir[1] < -1.0);
        let rays = &rays[..WINDOW];
        let (mut sorter, sun) = (Sorter::default(), to_sun(rays));
        for (key, rays) in [(SortKey::Point, rays), (SortKey::Direction(sun[0].dir), &sun)] {
            let order = sorter.sort(Level::best(), (key, rays));
            let sorted: Vec<Ray> = order.iter().map(|&i| rays[usize::from(i)]).collect();
            let area = |rays: &[Ray]| -> f32 {
                let of = |rays: &[Ray]| {
                    let mut bounds = Bounds::NONE;
                    for ray in rays {
                        bounds.add(key.position(ray));
                    }
                    bounds.sizes()[1]
                };
                rays.chunks(256).map(of).sum()
            };
            assert!(area(&sorted) < 0.2 * area(rays), "{} {}", area(&sorted), area(rays));
        }
    }
}
