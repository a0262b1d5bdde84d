//! Where to cut a set of boxes in two, by the surface-area heuristic.
//!
//! A cut costs the area of each side's box times the number of triangles in it. Few boxes are
//! sorted along each axis and every cut is tried; many are thrown into bins by their centres
//! (Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies*, 2007):
//!
//! ```text
//!   centres   .  . ..   |  .    .|.   . .   . . .
//!   bins     [0] [1] [2] [3] ... | ... [14] [15]      cuts only between two bins
//! ```

use super::refs::Ref;
use crate::bounds::Bounds;

/// Up to so many boxes are sorted.
pub(super) const FEW: usize = 8;

/// Bins along each axis; a power of two, so that a mask keeps every index inside.
const BINS: usize = 16;

/// From a box to its bin along each axis.
#[derive(Clone, Copy)]
pub(super) struct Binning {
    origin: [f32; 4],
    per_unit: [f32; 4],
    scale: f32,
}

impl Binning {
    pub(super) fn new(centres: &Bounds, scale: f32) -> Self {
        // A little less than all bins, so that the last centre falls into the last. An axis along
        // which all centres are equal has them all in bin 0.
        let per_unit = std::array::from_fn(|k| {
            let side = centres.hi[k] - centres.lo[k];
            if side > 0.0 { BINS as f32 * 0.9999 / side } else { 0.0 }
        });
        Self { origin: centres.lo, per_unit, scale }
    }

    #[inline(always)]
    fn bins(&self, bounds: &Bounds) -> [usize; 3] {
        let c = bounds.centre(self.scale);
        [0, 1, 2].map(|k| integer((c[k] - self.origin[k]) * self.per_unit[k]))
    }

    /// The bin along one axis: the same operations.
    #[inline(always)]
    fn bin(&self, bounds: &Bounds, axis: usize) -> usize {
        let c = bounds.lo[axis] * self.scale + bounds.hi[axis] * self.scale;
        integer((c - self.origin[axis]) * self.per_unit[axis])
    }
}

/// Rounds down, and keeps the result below [`BINS`] whatever it is. Adding this number rounds to an
/// integer in the low bits: the vector form of a conversion.
#[inline(always)]
fn integer(x: f32) -> usize {
    ((x - 0.5) + 12_582_912.0).to_bits() as usize & (BINS - 1)
}

/// How many boxes fell into each bin of each axis, and the box around them.
pub(super) struct Bins {
    bounds: [[Bounds; BINS]; 3],
    count: [[u32; BINS]; 3],
}

impl Bins {
    pub(super) fn of(refs: &[Ref], binning: &Binning) -> Self {
        let mut all = Self { bounds: [[Bounds::EMPTY; BINS]; 3], count: [[0; BINS]; 3] };
        for r in refs {
            for (axis, bin) in binning.bins(&r.0).into_iter().enumerate() {
                all.bounds[axis][bin].join(&r.0);
                all.count[axis][bin] += 1;
            }
        }
        all
    }

    pub(super) fn join(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.bounds[axis][bin].join(&other.bounds[axis][bin]);
                self.count[axis][bin] += other.count[axis][bin];
            }
        }
        self
    }

    /// The cheapest cut: its axis and the first bin of its right side. `None` where all boxes are
    /// in one bin.
    pub(super) fn best(&self, scale: f32) -> Option<(usize, usize)> {
        let (mut least, mut best) = (f32::INFINITY, None);
        for axis in 0..3 {
            let (bounds, count) = (&self.bounds[axis], &self.count[axis]);
            // The right sides, from the right end on.
            let mut right = [0.0; BINS];
            let (mut side, mut n) = (Bounds::EMPTY, 0);
            for bin in (1..BINS).rev() {
                side.join(&bounds[bin]);
                n += count[bin];
                right[bin] = side.half_area(scale) * n as f32;
            }
            // The left sides. A side of no boxes has an infinite area, times 0 is NaN: never less.
            let (mut side, mut n) = (Bounds::EMPTY, 0);
            for bin in 1..BINS {
                side.join(&bounds[bin - 1]);
                n += count[bin - 1];
                let cost = side.half_area(scale) * n as f32 + right[bin];
                if cost < least {
                    (least, best) = (cost, Some((axis, bin)));
                }
            }
        }
        best
    }
}

/// Sorts the boxes in place to the two sides of a cut; returns how many are on the left.
pub(super) fn partition(
    refs: &mut [Ref],
    binning: &Binning,
    (axis, first_right): (usize, usize),
) -> usize {
    let mut left = 0;
    // Without a branch, which would be mispredicted every other time: everything is swapped to
    // the end of the left side, which grows only if it belongs there.
    for i in 0..refs.len() {
        let r = refs[i];
        let is_left = binning.bin(&r.0, axis) < first_right;
        refs[i] = refs[left];
        refs[left] = r;
        left += usize::from(is_left);
    }
    left
}

/// Sorts two to [`FEW`] boxes along the axis of their cheapest cut; returns where to cut.
pub(super) fn sort_few(refs: &mut [Ref], scale: f32) -> usize {
    let n = refs.len();
    if n == 2 {
        return 1;
    }
    let (mut least, mut best) = (f32::INFINITY, None);
    for axis in 0..3 {
        // Insertion sort of the indices by centre.
        let mut key = [0.0; FEW];
        let mut order = [0_u8; FEW];
        for (i, r) in refs.iter().enumerate() {
            let centre = r.0.centre(scale)[axis];
            let mut at = i;
            while at > 0 && key[at - 1] > centre {
                (key[at], order[at]) = (key[at - 1], order[at - 1]);
                at -= 1;
            }
            (key[at], order[at]) = (centre, i as u8);
        }
        // The right sides, then the left ones, as with bins.
        let mut right = [0.0; FEW];
        let mut side = Bounds::EMPTY;
        for at in (1..n).rev() {
            side.join(&refs[order[at] as usize].0);
            right[at] = side.half_area(scale) * (n - at) as f32;
        }
        let mut side = Bounds::EMPTY;
        for at in 1..n {
            side.join(&refs[order[at - 1] as usize].0);
            let cost = side.half_area(scale) * at as f32 + right[at];
            if cost < least {
                (least, best) = (cost, Some((at, order)));
            }
        }
    }
    let Some((cut, order)) = best else { return n / 2 };
    let mut old = [Ref(Bounds::EMPTY); FEW];
    old[..n].copy_from_slice(refs);
    for (r, from) in refs.iter_mut().zip(order) {
        *r = old[from as usize];
    }
    cut
}
