//! Finds where to cut a set of boxes in two.
//!
//! Boxes are sorted into bins by their centres (Wald, *On fast Construction of SAH-based Bounding
//! Volume Hierarchies*, 2007):
//!
//! ```text
//!   centres   .  . ..   |  .    .|.   . .   . . .
//!   bins     [0] [1] [2] [3] ... | ... [14] [15]      Cuts lie between two bins.
//! ```

use super::prim_refs::PrimRef;
use super::simd_aabb::{CentreLanes, Centres, SimdAabb};
use super::sweep::{Cuts, ROW};
use intertri::simd::{Lanes, Mask, Simd};

/// Sets of up to this many boxes use only half of the bins: evaluating all bins would take longer
/// than filling them.
const SOME: usize = 32;

/// The number of bins along each axis. It is a power of two, so that a mask keeps every index in
/// bounds.
const BINS: usize = ROW;

/// A second set of bins is worthwhile for more boxes than this.
const MANY: usize = 200;

/// Adding this number rounds a value to an integer in the low bits of the float. This replaces a
/// conversion and works on whole vectors.
const ROUND: f32 = 12_582_912.0;

/// Maps a box to its bin along each axis.
#[derive(Clone, Copy)]
pub(super) struct Binning {
    origin: [f32; 4],
    per_unit: [f32; 4],
    scale: f32,
    bins: usize,
}

impl Binning {
    /// Creates a mapping for `count` boxes with these centres.
    pub(super) fn new(count: usize, centres: &Centres, scale: f32) -> Self {
        // Scale centres to slightly less than the number of bins, so that the last centre falls
        // into the last bin. If all centres are equal along an axis, all are in bin 0.
        let bins = if count <= SOME { BINS / 2 } else { BINS };
        let sides = centres.lo.iter().zip(&centres.hi);
        let mut per_unit = [0.0; 4];
        for (per_unit, (lo, hi)) in per_unit.iter_mut().zip(sides).take(3) {
            let side = hi - lo;
            *per_unit = if side > 0.0 { bins as f32 * 0.9999 / side } else { 0.0 };
        }
        Self { origin: centres.lo, per_unit, scale, bins }
    }

    /// Returns the bins of a centre along all axes, with [`ROUND`] added to the bin numbers.
    #[inline(always)]
    fn bins<S: Simd>(&self, centre: S::F32x4) -> [f32; 4] {
        let at = (centre - S::F32x4::load(&self.origin)) * S::F32x4::load(&self.per_unit);
        let mut bins = [0.0; 4];
        // Adding 1.5 · 2^23 rounds to the nearest integer. Subtracting a half first makes it round
        // down.
        ((at - S::F32x4::splat(0.5)) + S::F32x4::splat(ROUND)).store(&mut bins);
        bins
    }

    /// Returns the bin of a box along one axis, with [`ROUND`] added.
    #[inline(always)]
    fn bin(&self, sides: &SimdAabb, axis: usize) -> f32 {
        // Use the same operations as for all axes at once, so that a box always falls into the same
        // bin.
        let at = sides.centre_along(axis, self.scale) - self.origin[axis % 4];
        (at * self.per_unit[axis % 4] - 0.5) + ROUND
    }
}

/// For each bin of each axis, the number of boxes and the bounding box of these boxes.
pub(super) struct Bins {
    sides: [[SimdAabb; BINS]; 3],
    count: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self { sides: [[SimdAabb::EMPTY; BINS]; 3], count: [[0; BINS]; 3] };

    #[inline(always)]
    pub(super) fn of<S: Simd>(refs: &[PrimRef], binning: &Binning) -> Self {
        // Neighbours often go to the same bin, and each update would have to wait for the previous
        // one. If there are many boxes, two sets of bins therefore alternate.
        let mut all = Self::EMPTY;
        let (pairs, last) = if refs.len() > MANY { refs.as_chunks::<2>() } else { (&[][..], refs) };
        for r in last {
            all.add::<S>(r, binning);
        }
        if !pairs.is_empty() {
            let mut odd = Self::EMPTY;
            for [a, b] in pairs {
                all.add::<S>(a, binning);
                odd.add::<S>(b, binning);
            }
            all = all.join(&odd);
        }
        all
    }

    #[inline(always)]
    fn add<S: Simd>(&mut self, PrimRef(sides): &PrimRef, binning: &Binning) {
        let scale = S::F32x4::splat(binning.scale);
        let at = binning.bins::<S>(sides.centre::<S>(scale));
        let row = S::F32x8::load(&sides.0);
        for ((sides, count), at) in self.sides.iter_mut().zip(&mut self.count).zip(at) {
            // With ROUND added, the low bits of the float are the bin number.
            let bin = at.to_bits() as usize % BINS;
            let around = &mut sides[bin].0;
            S::F32x8::load(around).max(row).store(around);
            count[bin] += 1;
        }
    }

    pub(super) fn join(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                // Maxima and integer sums do not depend on the order in which bins are joined.
                self.sides[axis][bin].join(&other.sides[axis][bin]);
                self.count[axis][bin] += other.count[axis][bin];
            }
        }
        self
    }

    /// Returns the axis of the cheapest cut and the first bin on its right side, or `None` if all
    /// boxes are in one bin.
    #[inline(always)]
    pub(super) fn best<S: Simd>(&self, binning: &Binning) -> Option<(usize, usize)> {
        let mut cuts = Cuts::new();
        for axis in 0..3 {
            let (sides, count) = (&self.sides[axis], &self.count[axis]);
            cuts.sweep::<S>(axis, &sides[..binning.bins], count, binning.scale);
        }
        cuts.best::<S>()
    }
}

/// Returns the box around the centres of the given boxes.
#[inline(always)]
pub(super) fn centres<S: Simd>(refs: &[PrimRef], scale: f32) -> Centres {
    let (mut centres, scale) = (CentreLanes::none(), S::F32x4::splat(scale));
    let all = <S::F32x4 as Lanes>::Mask::from_bits(0b1111);
    for PrimRef(sides) in refs {
        // Use the box around the centres, not around the boxes: one large triangle would otherwise
        // leave most bins empty.
        centres.reach(sides.centre::<S>(scale), all);
    }
    centres.store()
}

/// Partitions the boxes in place at a cut. Returns how many boxes are on the left, and the boxes
/// around the centres of both sides.
#[inline(always)]
pub(super) fn partition<S: Simd>(
    refs: &mut [PrimRef],
    binning: &Binning,
    (axis, first_right): (usize, usize),
) -> (usize, [Centres; 2]) {
    let mut left = 0;
    let (mut a, mut b) = (CentreLanes::none(), CentreLanes::none());
    let (cut, scale) = (ROUND + first_right as f32, S::F32x4::splat(binning.scale));
    // Avoid a branch, which would be mispredicted every other time: swap every reference to the end
    // of the left side, which grows only if the reference belongs there.
    for i in 0..refs.len() {
        let r = refs[i];
        let (centre, bin) = (r.0.centre::<S>(scale), binning.bin(&r.0, axis));
        let is_left = S::F32x4::splat(bin).lt(S::F32x4::splat(cut));
        a.reach(centre, is_left);
        b.reach(centre, !is_left);
        refs[i] = refs[left];
        refs[left] = r;
        left += usize::from(bin < cut);
    }
    (left, [a.store(), b.store()])
}
