//! Builds the two-way tree from the top down and, on the way back up, plans how to cut it into wide
//! nodes.
//!
//! A subtree over `n` triangles owns `n` consecutive references and `n - 1` consecutive nodes, so
//! both sides of a cut can be built in parallel without sharing anything:
//!
//! ```text
//!   refs   [ left: l ............ | right: n - l ........ ]
//!   nodes  [ itself | left: l - 1 ... | right: n - l - 1 ]
//! ```

use super::collapse::{Costs, Plan};
use super::layout::MAX_DEPTH;
use super::prim_refs::PrimRef;
use super::simd_aabb::{Centres, SimdAabb};
use super::split::{self, Binning, Bins};
use crate::tree::{Aabb, BLOCK};
use crate::util::memory::{NoMemory, zeros};
use crate::util::threads::join;
use intertri::simd::{Lanes, Level, Simd, WithSimd};
use std::sync::atomic::{AtomicUsize, Ordering};

/// With at least this many triangles, the two sides are built in parallel, and progress is
/// reported.
const MANY: usize = 1 << 12;

/// The number of boxes that one thread bins or measures at a time.
const CHUNK: usize = 1 << 15;

/// A small value that is added to the area of every box, so that the tree with fewer nodes wins if
/// the areas are zero.
pub(super) const TRIFLE: f32 = 1e-20;

/// The whole tree. It has at least one reference, and one node fewer than references.
pub(super) struct Binary {
    pub refs: Vec<PrimRef>,
    /// Each node's box. The two words of an inner node are the number of triangles on its left side
    /// and its plan. The entries are plain numbers, so that the memory can be allocated as zeros
    /// and is not touched before it is used.
    inner: Box<[[f32; 8]]>,
    /// Nodes that replace the nodes at the top if parts were moved. The last one is the root.
    pub moved: Vec<MovedNode>,
}

/// A node whose sides may be at any position.
pub(super) struct MovedNode {
    pub bounds: Aabb,
    pub sides: [Subtree; 2],
    pub plan: Plan,
}

/// A part of the tree: `count` references starting at `first`, and nodes starting at `node`. If
/// `node` is past the end of the nodes, it refers to an entry of [`Binary::moved`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Subtree {
    pub node: usize,
    pub first: usize,
    pub count: usize,
}

impl Binary {
    pub(super) fn root(&self) -> Subtree {
        let node = self.moved.len().checked_sub(1).map_or(0, |last| self.inner.len() + last);
        Subtree { node, first: 0, count: self.refs.len() }
    }

    /// Adds a node whose sides may be at any position.
    pub(super) fn put(&mut self, moved: MovedNode) -> Subtree {
        let [Subtree { first, count, .. }, right] = moved.sides;
        let node = self.inner.len() + self.moved.len();
        self.moved.push(moved);
        Subtree { node, first, count: count + right.count }
    }

    fn moved(&self, part: Subtree) -> Option<&MovedNode> {
        // A single triangle has no node, and moved nodes are numbered after those of the build.
        let number = part.node.checked_sub(self.inner.len()).filter(|_| part.count > 1)?;
        self.moved.get(number)
    }

    /// Returns whether a subtree has few enough triangles to be a block, which is not divided.
    pub(super) fn is_block(&self, part: Subtree) -> bool {
        part.count <= BLOCK && self.moved(part).is_none()
    }

    /// Returns the box around a subtree.
    pub(super) fn bounds(&self, part: Subtree) -> Aabb {
        match (part.count, self.moved(part)) {
            (1, _) => self.refs[part.first].0.bounds(),
            (_, Some(moved)) => moved.bounds,
            (_, None) => SimdAabb(self.inner[part.node]).bounds(),
        }
    }

    /// Returns the two sides of a subtree that is not a block.
    pub(super) fn sides(&self, part: Subtree) -> [Subtree; 2] {
        if let Some(moved) = self.moved(part) {
            return moved.sides;
        }
        // The left side has `left` references and `left - 1` nodes, which directly follow the
        // parent.
        let left = SimdAabb(self.inner[part.node]).word(0) as usize;
        let Subtree { node, first, count } = part;
        [
            Subtree { node: node + 1, first, count: left },
            Subtree { node: node + left, first: first + left, count: count - left },
        ]
    }

    /// Returns the plan for a subtree, or `None` for a block.
    pub(super) fn plan(&self, part: Subtree) -> Option<Plan> {
        if let Some(moved) = self.moved(part) {
            return Some(moved.plan);
        }
        (!self.is_block(part)).then(|| Plan(SimdAabb(self.inner[part.node]).word(1)))
    }
}

/// Builds the tree over at least one triangle. The result does not depend on the SIMD level.
pub(super) fn build(
    mut refs: Vec<PrimRef>,
    level: Level,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Binary, NoMemory> {
    let mut inner = zeros(refs.len() - 1)?;
    let builder = Builder::new(&refs, level, progress);
    // Cuts are placed between the centres of boxes, so each part passes on the box around its
    // centres.
    let centres = builder.centres(&refs);
    builder.large(&mut refs, &mut inner, &centres, 0);
    Ok(Binary { refs, inner, moved: Vec::new() })
}

struct Builder<'a> {
    level: Level,
    /// See [`Aabb::scale`].
    scale: f32,
    total: usize,
    done: AtomicUsize,
    progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl<'a> Builder<'a> {
    fn new(refs: &[PrimRef], level: Level, progress: &'a (dyn Fn(usize, usize) + Sync)) -> Self {
        let around = |refs: &[PrimRef]| {
            let mut all = SimdAabb::EMPTY;
            for r in refs {
                all.join(&r.0);
            }
            all
        };
        let both = |mut a: SimdAabb, b| {
            a.join(&b);
            a
        };
        let all = gather(refs, &around, &both);
        // Scale coordinates by the size of the scene, so that areas are in the range of f32 for any
        // scene.
        let (total, done) = (refs.len(), AtomicUsize::new(0));
        Self { level, scale: all.bounds().scale(), total, done, progress }
    }

    fn centres(&self, refs: &[PrimRef]) -> Centres {
        let one = |refs: &[PrimRef]| self.level.run(CentresOf { refs, scale: self.scale });
        gather(refs, &one, &Centres::join)
    }

    /// Builds a subtree whose sides may be built in parallel. Its depth is bounded by
    /// [`MAX_DEPTH`].
    fn large(
        &self,
        refs: &mut [PrimRef],
        inner: &mut [[f32; 8]],
        centres: &Centres,
        depth: usize,
    ) -> Built {
        let (builder, count) = (self, refs.len());
        if count < MANY {
            let built = self.level.run(Small { builder, refs, inner, centres, depth });
            let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
            (self.progress)(done, self.total);
            return built;
        }
        // The two sides own disjoint parts of the references and the nodes, so threads share
        // nothing.
        let (left, [ca, cb]) = self.level.run(Cut { builder, refs, centres, depth });
        let (lr, rr) = refs.split_at_mut(left);
        let (here, li, ri) = nodes_of(inner, left);
        let (a, b) =
            join(|| self.large(lr, li, &ca, depth + 1), || self.large(rr, ri, &cb, depth + 1));
        self.level.run(FinishNode { builder, here, left, a, b })
    }

    /// Returns the area of a subtree's box, from which its cost is computed.
    #[inline(always)]
    fn area<S: Simd>(&self, sides: &SimdAabb) -> f32 {
        let mut size = [0.0; 4];
        sides.size::<S>(Lanes::splat(self.scale)).store(&mut size);
        // Half of the surface area: the factor 2 is the same for all boxes, so it does not change
        // comparisons.
        let [x, y, z, _] = size;
        x * (y + z) + y * z + TRIFLE
    }
}

/// A subtree built by one thread.
struct Small<'a> {
    builder: &'a Builder<'a>,
    refs: &'a mut [PrimRef],
    inner: &'a mut [[f32; 8]],
    centres: &'a Centres,
    depth: usize,
}

impl WithSimd for Small<'_> {
    type Output = Built;

    #[inline(always)]
    fn run<S: Simd>(self) -> Built {
        let Self { builder, refs, inner, centres, depth } = self;
        let count = refs.len();
        if count <= BLOCK {
            let mut sides = refs[0].0;
            for r in &refs[1..] {
                sides.join(&r.0);
            }
            // A block does not need inner nodes, but its first node stores the box. A single
            // triangle has no node.
            if let Some(here) = inner.first_mut() {
                *here = sides.0;
            }
            return Built { sides, costs: Costs::of_block(builder.area::<S>(&sides)) };
        }
        let (left, [ca, cb]) = Cut { builder, refs, centres, depth }.run::<S>();
        let (lr, rr) = refs.split_at_mut(left);
        let (here, li, ri) = nodes_of(inner, left);

        // A recursive function is not inlined, so each call enters its SIMD level anew.
        let (level, depth) = (builder.level, depth + 1);
        let a = level.run(Small { builder, refs: lr, inner: li, centres: &ca, depth });
        let b = level.run(Small { builder, refs: rr, inner: ri, centres: &cb, depth });
        FinishNode { builder, here, left, a, b }.run::<S>()
    }
}

/// Partitions the references by the cheapest cut. Returns how many references are on the left, and
/// the boxes around the centres of both sides.
struct Cut<'a> {
    builder: &'a Builder<'a>,
    refs: &'a mut [PrimRef],
    centres: &'a Centres,
    depth: usize,
}

impl WithSimd for Cut<'_> {
    type Output = (usize, [Centres; 2]);

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        let Self { builder, refs, centres, depth } = self;
        let (count, scale) = (refs.len(), builder.scale);
        // Repeated halving would need this many more levels. As long as more levels are left, any
        // cut is allowed.
        let levels = count.ilog2() as usize;
        if depth + levels < MAX_DEPTH {
            let binning = Binning::new(count, centres, scale);
            let bins = match count {
                ..=CHUNK => Bins::of::<S>(refs, &binning),
                _ => bins(builder.level, refs, &binning),
            };
            if let Some(cut) = bins.best::<S>(&binning) {
                return split::partition::<S>(refs, &binning, cut);
            }
        }
        // All centres are equal, or the tree is too deep: cut the references in half, in order. The
        // left side consists of full blocks, so that at most one block of the subtree is not full.
        ((count / 2).next_multiple_of(BLOCK), [*centres; 2])
    }
}

/// Writes a node whose two sides have been built.
struct FinishNode<'a> {
    builder: &'a Builder<'a>,
    here: &'a mut [f32; 8],
    left: usize,
    a: Built,
    b: Built,
}

impl WithSimd for FinishNode<'_> {
    type Output = Built;

    #[inline(always)]
    fn run<S: Simd>(self) -> Built {
        let Self { builder, here, left, a, b } = self;
        let mut sides = a.sides;
        sides.join(&b.sides);
        let (costs, plan) = Costs::join(builder.area::<S>(&sides), &a.costs, &b.costs);
        *here = node(&sides, left, plan);
        Built { sides, costs }
    }
}

/// The result of building a subtree, for the node above.
struct Built {
    sides: SimdAabb,
    costs: Costs,
}

/// Creates a node with two sides.
#[inline(always)]
fn node(sides: &SimdAabb, left: usize, plan: Plan) -> [f32; 8] {
    let mut node = *sides;
    node.set_word(0, left as u32);
    node.set_word(1, plan.0);
    node.0
}

/// Splits the nodes of a subtree into its root, the nodes of its left side, and those of its right
/// side.
#[inline(always)]
fn nodes_of(
    inner: &mut [[f32; 8]],
    left: usize,
) -> (&mut [f32; 8], &mut [[f32; 8]], &mut [[f32; 8]]) {
    let (here, below) = inner.split_at_mut(1);
    // `l` triangles on the left have `l - 1` nodes; the rest belong to the right side.
    let (a, b) = below.split_at_mut(left - 1);
    (&mut here[0], a, b)
}

/// Computes the box around the centres of references.
struct CentresOf<'a> {
    refs: &'a [PrimRef],
    scale: f32,
}

impl WithSimd for CentresOf<'_> {
    type Output = Centres;
    #[inline(always)]
    fn run<S: Simd>(self) -> Centres {
        split::centres::<S>(self.refs, self.scale)
    }
}

/// Sorts references into bins.
struct BinsOf<'a> {
    refs: &'a [PrimRef],
    binning: &'a Binning,
}

impl WithSimd for BinsOf<'_> {
    type Output = Bins;
    #[inline(always)]
    fn run<S: Simd>(self) -> Bins {
        Bins::of::<S>(self.refs, self.binning)
    }
}

/// Sorts many references into bins, on all threads.
#[inline(never)]
fn bins(level: Level, refs: &[PrimRef], binning: &Binning) -> Bins {
    let one = |refs: &[PrimRef]| level.run(BinsOf { refs, binning });
    gather(refs, &one, &|a, b| a.join(&b))
}

/// Processes chunks in parallel and joins their results, always in the same order.
fn gather<T: Send>(
    refs: &[PrimRef],
    one: &(impl Fn(&[PrimRef]) -> T + Sync),
    both: &(impl Fn(T, T) -> T + Sync),
) -> T {
    if refs.len() <= CHUNK {
        return one(refs);
    }
    // Always split in the middle, regardless of the number of threads.
    let (a, b) = refs.split_at(refs.len() / 2);
    let (a, b) = join(|| gather(a, one, both), || gather(b, one, both));
    both(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::prim_refs;
    use intertri::Triangle;

    fn depth(binary: &Binary, part: Subtree) -> usize {
        let below = |part| 1 + depth(binary, part);
        if binary.is_block(part) {
            0
        } else {
            binary.sides(part).map(below).into_iter().max().unwrap_or(0)
        }
    }

    #[test]
    fn depth_is_bounded() {
        // Each group is twice as far out as the previous one, so each cut separates only a few
        // triangles.
        let at = |i: i32| {
            let x = (i as f32).exp2();
            Triangle([[x, 0.0, 0.0], [x * 1.5, 0.0, 0.0], [x, 0.0, x]])
        };
        let triangles: Vec<_> = (-120..120).flat_map(|i| [at(i); 40]).collect();
        let depth_from = |start| {
            let mut refs = prim_refs::collect(&triangles[..]).unwrap().refs;
            let mut inner = zeros(refs.len() - 1).unwrap();
            let builder = Builder::new(&refs, Level::best(), &|_, _| ());
            let centres = builder.centres(&refs);
            builder.large(&mut refs, &mut inner, &centres, start);
            let binary = Binary { refs, inner, moved: Vec::new() };
            start + depth(&binary, binary.root())
        };
        let needed = triangles.len().ilog2() as usize;
        let free = depth_from(0);
        assert!(free > needed, "only {free} levels to test with");
        for start in 0..=MAX_DEPTH - needed {
            assert!(depth_from(start) <= MAX_DEPTH, "from {start} to {}", depth_from(start));
        }
    }
}
