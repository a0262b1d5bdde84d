//! Computes the hit bounds of a leaf's triangles, eight triangles at once.
//!
//! Nearly all triangles are plain: finite, and far from being needles. Their hit bounds are the
//! bounding boxes of their corners, which f32 lanes can compute. [`hit_bounds`] handles the
//! remaining triangles one by one.

use bytemuck::Zeroable;
use intertri::simd::{Lanes, Mask, Simd, Vec3, WithSimd};
use intertri::{Triangle, TriangleBlock};

use super::aabb::Aabb;
use super::hit_bounds::{HitBounds, hit_bounds};
use crate::util::lane_ops::{lanes_of, smallest_of_eight};
use crate::util::memory::{NoMemory, room};

/// A triangle is plain if the length of its normal certainly exceeds this fraction (2^-8) of the
/// squared length of its longest edge, in 1-norms. Its thinness is then below `2^12`, and because
/// the error of f32 is at most `2^-19`, its box needs no padding.
const PLAIN: f32 = 1.0 / 256.0;

/// The distance outside a plain triangle's box at which the reference implementation may report a
/// hit, divided by the longest edge and the thinness, both in 1-norms: 2^-43, which is 16 times the
/// value in [`hit_bounds`].
const LEAN: f32 = 1.0 / (1_u64 << 43) as f32;

/// f32 lanes handle only squared edge lengths in `2^-90..2^100`.
const SQUARES: [f32; 2] = [f32::from_bits((127 - 90) << 23), f32::from_bits((127 + 100) << 23)];

/// The combined hit bounds of up to eight triangles.
#[derive(Clone, Copy, Debug, Zeroable)]
pub(crate) struct LeafBounds {
    /// The union of the boxes of all triangles that have one, whether degenerate or not.
    pub bounds: Aabb,
    /// The maximum distance outside its box at which the reference implementation may report a hit
    /// on a triangle in `boxed`.
    pub lean: f32,
    /// A mask of the triangles that are hit in or near their boxes.
    pub boxed: u32,
    /// A mask of the triangles with zero area.
    pub degenerate: u32,
    /// A mask of the thin triangles, on which the reference implementation may report hits
    /// arbitrarily far outside their boxes.
    pub thin: u32,
}

/// Computes the [`LeafBounds`] of a subset of eight lanes.
pub(crate) struct LaneBounds<'a> {
    pub corners: &'a [[[f32; 8]; 3]; 3],
    pub lanes: u32,
}

impl LaneBounds<'_> {
    /// Selects the live triangles of a block.
    pub(crate) fn of(block: &TriangleBlock<8>) -> LaneBounds<'_> {
        LaneBounds { corners: block.corners(), lanes: block.live() }
    }
}

impl WithSimd for LaneBounds<'_> {
    type Output = LeafBounds;

    #[inline(always)]
    fn run<S: Simd>(self) -> LeafBounds {
        let [c1, c2, c3] = self.corners;
        let [a, b, c] = [Vec3::<S::F32x8>::load(c1), Vec3::load(c2), Vec3::load(c3)];

        // A finite sum of magnitudes rules out NaN and infinity.
        let finite = (a.norm1() + b.norm1() + c.norm1()).lt(S::F32x8::splat(f32::INFINITY));
        // Use 1-norms instead of lengths: they need no square root and differ from lengths by at
        // most a small constant factor.
        let (h4, h5) = (b - a, c - a);
        let longest = h4.norm1().max(h5.norm1());
        let square = longest * longest;
        let known = square.gt(S::F32x8::splat(SQUARES[0])) & square.lt(S::F32x8::splat(SQUARES[1]));
        let normal = h4.cross_fused(h5).norm1();
        let plain = finite & known & normal.gt(square * S::F32x8::splat(PLAIN));
        let boxed = plain.bits() & self.lanes;

        // Join the boxes of all plain lanes.
        let taken = <S::F32x8 as Lanes>::Mask::from_bits(boxed);
        let mut bounds = Aabb::EMPTY;
        let axes = [(a.x, b.x, c.x), (a.y, b.y, c.y), (a.z, b.z, c.z)];
        for (axis, (a, b, c)) in axes.into_iter().enumerate() {
            let outside = S::F32x8::splat(f32::INFINITY);
            let lo = Lanes::select(taken, a.min(b).min(c), outside);
            // Negate the upper side, so that the same minimum reduction serves both sides.
            let hi = Lanes::select(taken, -a.max(b).max(c), outside);
            bounds.lo[axis] = smallest_of_eight::<S>(lo);
            bounds.hi[axis] = -smallest_of_eight::<S>(hi);
        }
        // Compute the thinness times the longest edge, as in `hit_bounds`, but with 1-norms and a
        // constant that accounts for the difference.
        let lean = (square / normal) * longest * S::F32x8::splat(LEAN);
        let lean = -smallest_of_eight::<S>(Lanes::select(taken, -lean, S::F32x8::splat(0.0)));
        let mut leaf = LeafBounds { bounds, lean, boxed, ..LeafBounds::NONE };
        let others = self.lanes & !boxed;
        if others != 0 {
            leaf.add(self.corners, others);
        }
        leaf
    }
}

/// Returns the largest lean of the given leaves.
pub(crate) fn lean_of(leaves: &[LeafBounds]) -> f32 {
    leaves.iter().fold(0.0, |lean, leaf| lean.max(leaf.lean))
}

/// Returns the boxes of the given leaves.
pub(crate) fn boxes_of(leaves: &[LeafBounds]) -> Result<Vec<Aabb>, NoMemory> {
    let mut boxes = room(leaves.len())?;
    boxes.extend(leaves.iter().map(|leaf| leaf.bounds));
    Ok(boxes)
}

impl LeafBounds {
    /// The bounds if there are no triangles.
    pub(crate) const NONE: Self =
        Self { bounds: Aabb::EMPTY, lean: 0.0, boxed: 0, degenerate: 0, thin: 0 };

    /// Returns a mask of the triangles that can be hit in or near their boxes or that have zero
    /// area.
    pub(crate) fn present(&self) -> u32 {
        self.boxed | self.degenerate
    }

    /// Adds the given lanes whose triangles have zero area.
    pub(crate) fn add_degenerate(&mut self, corners: &[[[f32; 8]; 3]; 3], lanes: u32) {
        for lane in lanes_of(lanes) {
            if let HitBounds::Degenerate(bounds) = hit_bounds(&in_lane(corners, lane)) {
                self.bounds.join(&bounds);
                self.degenerate |= 1 << lane;
            }
        }
    }

    /// Adds lanes whose triangles are not plain.
    #[inline(never)]
    fn add(&mut self, corners: &[[[f32; 8]; 3]; 3], lanes: u32) {
        for lane in lanes_of(lanes) {
            match hit_bounds(&in_lane(corners, lane)) {
                HitBounds::Nowhere => {}
                HitBounds::Degenerate(bounds) => {
                    self.bounds.join(&bounds);
                    self.degenerate |= 1 << lane;
                }
                HitBounds::Box { bounds, lean } => {
                    self.bounds.join(&bounds);
                    self.lean = self.lean.max(lean);
                    self.boxed |= 1 << lane;
                }
                HitBounds::Thin(bounds) => {
                    self.bounds.join(&bounds);
                    self.thin |= 1 << lane;
                }
            }
        }
    }
}

/// Returns the triangle in a lane.
fn in_lane(corners: &[[[f32; 8]; 3]; 3], lane: usize) -> Triangle {
    let corner = |k: usize| [0, 1, 2].map(|axis| corners[k][axis][lane]);
    Triangle([corner(0), corner(1), corner(2)])
}

#[cfg(test)]
mod tests {
    use intertri::simd::Level;

    use super::*;

    /// Puts values of every kind into every coordinate and compares the bounds with those that are
    /// computed one triangle at a time.
    #[test]
    fn lanes_have_the_bounds_of_their_triangles() {
        let (m, tiny) = (f32::MAX, f32::MIN_POSITIVE);
        let wild = [f32::NAN, f32::INFINITY, m, -m, 0.0, -0.0, 1e-45, -tiny, 1e-20, -1e15, 1.0];
        // Use these widths for needles. For the thinnest needles, no box bounds the hits.
        let thin = [1e-3, 1e-7, 1e-9, 3e-13, 1e-14, 1e-18];
        let plain = Triangle([[0.0, 0.1, 0.2], [1.0, 0.3, 0.1], [0.4, 2.0, 0.7]]);
        let (mut seen, mut needles) = ([0; 4], 0);
        for i in 0..9 * wild.len() * thin.len() {
            let mut triangles = [plain; 8];
            triangles[i % 8].0.as_flattened_mut()[i % 9] = wild[i / 9 % wild.len()];
            let y = thin[i % thin.len()];
            triangles[(i + 3) % 8] = Triangle([[0.0; 3], [1.0, y, 0.0], [2.0, y * 3.0, 0.0]]);
            triangles[(i + 5) % 8].0[2] = triangles[(i + 5) % 8].0[1];
            let block = TriangleBlock::<8>::new(&triangles);
            let mut expected = LeafBounds::NONE;
            let lanes = 0xff >> (i % 3);
            expected.add(block.corners(), lanes);
            for level in Level::all() {
                let found = level.run(LaneBounds { corners: block.corners(), lanes });
                let same = (0..3).all(|k| {
                    found.bounds.lo[k] == expected.bounds.lo[k]
                        && found.bounds.hi[k] == expected.bounds.hi[k]
                });
                assert!(same, "{triangles:?}: {found:?}, not {expected:?}");
                let masks = |of: &LeafBounds| (of.boxed, of.degenerate, of.thin);
                assert_eq!(masks(&found), masks(&expected), "{triangles:?}");
                assert!(found.lean >= expected.lean, "{triangles:?}: {}", found.lean);
                assert!(found.lean <= 100.0 * expected.lean, "{triangles:?}: {}", found.lean);
            }
            seen[0] += expected.boxed.count_ones();
            seen[1] += expected.thin.count_ones();
            seen[2] += (lanes & !expected.present() & !expected.thin).count_ones();
            seen[3] += expected.degenerate.count_ones();
            let padded = |t: &Triangle| matches!(hit_bounds(t), HitBounds::Box { bounds, .. } if Aabb::of(t) != Some(bounds));
            needles += triangles.iter().filter(|t| padded(t)).count();
        }
        assert!(seen.iter().all(|&n| n > 50) && needles > 50, "{seen:?}, {needles}");
    }
}
