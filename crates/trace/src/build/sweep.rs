//! Splits a row of boxes in two by the surface-area heuristic (SAH). The cost of a split is the
//! area of each side's box times the number of triangles on that side, summed over both sides.
//!
//! ```text
//!   boxes   [0] [1] [2] [3] ... [14] [15]
//!   cut 3   └─ left ──┘ └───── right ───┘
//! ```

use super::simd_aabb::SimdAabb;
use crate::util::lane_ops::smallest;
use intertri::simd::{Lanes, Mask, Simd};

/// The maximum number of boxes in a row.
pub(super) const ROW: usize = 16;

/// The cost of every cut along each axis.
pub(super) struct Cuts([[f32; ROW]; 3]);

impl Cuts {
    pub(super) fn new() -> Self {
        Self([[f32::INFINITY; ROW]; 3])
    }

    /// Computes the cost of cutting before each box along an axis. `counts` holds the number of
    /// triangles in each box. A cut that leaves one side empty costs infinity.
    #[inline(always)]
    pub(super) fn sweep<S: Simd>(
        &mut self,
        axis: usize,
        boxes: &[SimdAabb],
        counts: &[u32],
        scale: f32,
    ) {
        let n = boxes.len().min(ROW).min(counts.len());
        let (boxes, counts) = (&boxes[..n], &counts[..n]);
        let scale = S::F32x4::splat(scale);

        // For each cut, the side lengths of the left and right boxes. The fourth lane holds the
        // number of triangles.
        let (mut left, mut right) = ([[0.0; 4]; ROW], [[0.0; 4]; ROW]);
        // Sweep from the right end to join box i with all boxes after it, then from the left end to
        // join all boxes before it.
        let (mut side, mut number) = (S::F32x8::splat(f32::NEG_INFINITY), 0);
        for i in (1..n).rev() {
            // Lower bounds are stored negated, so a union takes a single `max`.
            side = side.max(S::F32x8::load(&boxes[i].0));
            number += counts[i];
            right[i] = sized::<S>(side, number, scale);
        }
        let (mut side, mut number) = (S::F32x8::splat(f32::NEG_INFINITY), 0);
        for i in 1..n {
            side = side.max(S::F32x8::load(&boxes[i - 1].0));
            number += counts[i - 1];
            left[i] = sized::<S>(side, number, scale);
        }

        // Evaluate four cuts at a time. The cost of an empty side is infinity times 0, which is
        // NaN; the `select` below replaces NaN with infinity.
        for first in (0..n).step_by(4) {
            // After the transpose, each register holds one component for four cuts.
            let rows = |sides: &[[f32; 4]; ROW]| {
                let row = |i: usize| S::F32x4::load(&sides[first + i]);
                S::transpose([row(0), row(1), row(2), row(3)])
            };
            let ([x, y, z, l], [u, v, w, r]) = (rows(&left), rows(&right));
            let cost = (x * (y + z) + y * z) * l + (u * (v + w) + v * w) * r;
            let none = S::F32x4::splat(0.0);
            let cost =
                S::F32x4::select(l.gt(none) & r.gt(none), cost, S::F32x4::splat(f32::INFINITY));
            cost.store(&mut self.0[axis][first..]);
        }
    }

    /// Returns the axis and position of the cheapest cut, or `None` if no cut is possible. If
    /// several cuts tie, the first one wins.
    #[inline(always)]
    pub(super) fn best<S: Simd>(&self) -> Option<(usize, usize)> {
        let [x, y, z] = &self.0;
        let (x, y, z) = (S::F32x16::load(x), S::F32x16::load(y), S::F32x16::load(z));
        let least = smallest::<S>(x.min(y).min(z));
        let least = S::F32x16::splat(least);
        let bits = [x.le(least).bits(), y.le(least).bits(), z.le(least).bits()];
        let axis = (0..3).find(|&axis| bits[axis] != 0)?;
        let cut = bits[axis].trailing_zeros() as usize;
        // The cost is infinite if every cut leaves a side empty, that is, if all centres fall into
        // one bin.
        self.0[axis][cut].is_finite().then_some((axis, cut))
    }
}

/// Returns the side lengths of a box, followed by its triangle count.
#[inline(always)]
fn sized<S: Simd>(side: S::F32x8, number: u32, scale: S::F32x4) -> [f32; 4] {
    let (mut sides, mut size) = (SimdAabb::EMPTY, [0.0; 4]);
    side.store(&mut sides.0);
    sides.size::<S>(scale).store(&mut size);
    size[3] = number as f32;
    size
}

#[cfg(test)]
mod tests {
    use super::{Cuts, ROW, SimdAabb};
    use crate::tree::Aabb;
    use crate::util::test_numbers::random;
    use intertri::simd::{Level, Simd, WithSimd};

    struct Sweep<'a>(&'a [SimdAabb], &'a [u32]);
    impl WithSimd for Sweep<'_> {
        type Output = ([f32; ROW], Option<(usize, usize)>);
        #[inline(always)]
        fn run<S: Simd>(self) -> Self::Output {
            let mut costs = Cuts::new();
            costs.sweep::<S>(1, self.0, self.1, 0.5);
            (costs.0[1], costs.best::<S>())
        }
    }

    /// Checks the costs of rows of every length, some with empty boxes, against costs computed
    /// directly.
    #[test]
    fn costs_are_areas_times_counts() {
        let mut random = random();
        for n in (0..=ROW).chain([ROW; 50]) {
            let (mut boxes, mut counts) = (vec![], vec![]);
            for _ in 0..n {
                let (lo, count) = ([(); 4].map(|()| random()), (random() * 5.0) as u32);
                let around = Aabb { lo, hi: lo.map(|x| x + random()) };
                boxes.push(if count > 0 { SimdAabb::of(&around) } else { SimdAabb::EMPTY });
                counts.push(count);
            }
            let cost = |range: std::ops::Range<usize>| {
                let mut all = Aabb::EMPTY;
                boxes[range.clone()].iter().for_each(|sides| all.join(&sides.bounds()));
                let count = counts[range].iter().sum::<u32>();
                (count > 0).then(|| all.half_area(0.5) * count as f32)
            };
            let both = |cut| Some(cost(0..cut)? + cost(cut..n)?);
            for level in Level::all() {
                let (costs, best) = level.run(Sweep(&boxes, &counts));
                for (cut, &found) in costs.iter().enumerate() {
                    let expected = (cut < n).then(|| both(cut)).flatten().unwrap_or(f32::INFINITY);
                    let same = found == expected || (found / expected - 1.0).abs() < 1e-5;
                    assert!(same, "cut {cut} of {n}: {found}, not {expected}");
                }
                let least = costs.iter().fold(f32::INFINITY, |m, &x| m.min(x));
                match best {
                    Some((1, cut)) => assert_eq!(costs[cut], least),
                    other => assert!(other.is_none() && least == f32::INFINITY, "{other:?}"),
                }
            }
        }
    }
}
