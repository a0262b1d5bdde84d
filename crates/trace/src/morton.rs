//! Sorts points along a Morton curve, which keeps spatial neighbours close together.

use crate::tree::Aabb;
use crate::util::memory::{NoMemory, room};

/// Inputs with at most this many points are not sorted.
const FEW: usize = 16;

/// The number of bits per coordinate.
const BITS: u32 = 10;

/// Returns the indices of points sorted along a Morton curve through a box and its surroundings.
pub(crate) fn along_curve(
    around: &Aabb,
    count: usize,
    at: impl Fn(usize) -> [f32; 3],
) -> Result<Vec<u32>, NoMemory> {
    let mut numbers = room(count)?;
    if count <= FEW {
        numbers.extend(0..count as u32);
        return Ok(numbers);
    }
    let cells = (1 << BITS) as f32;
    let places = [0, 1, 2].map(|axis| {
        let (lo, hi) = (around.lo[axis], around.hi[axis]);
        // Double the box about its centre, so that points just outside the original box get their
        // own cells.
        let size = 2.0 * (hi - lo);
        (lo - 0.25 * size, if size > 0.0 { cells / size } else { 0.0 })
    });
    let cell = |point: [f32; 3]| {
        let along = |axis: usize| {
            let (from, per_unit) = places[axis];
            // Points that are outside the enlarged box or not finite go to the first or last cell.
            let cell = ((point[axis] - from) * per_unit).clamp(0.0, cells - 1.0) as u32;
            spread(cell) << axis
        };
        along(0) | along(1) | along(2)
    };
    let mut order: Vec<u64> = room(count)?;
    // The index in the low half breaks ties, so the order is deterministic.
    order.extend((0..count).map(|i| u64::from(cell(at(i))) << 32 | i as u64));
    order.sort_unstable();
    numbers.extend(order.into_iter().map(|place| place as u32));
    Ok(numbers)
}

/// Spreads the ten lowest bits, inserting two zero bits between adjacent ones.
fn spread(x: u32) -> u32 {
    // Each of the four steps splits each group of bits into smaller ones.
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}
