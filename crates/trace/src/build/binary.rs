//! The two-way tree, from the top down, and on the way back up the plan how to cut it.
//!
//! A subtree over `n` triangles owns `n` consecutive references and `n - 1` consecutive nodes, so
//! that both sides of a cut can be built at once without sharing anything:
//!
//! ```text
//!   refs   [ left: l ............ | right: n - l ........ ]
//!   nodes  [ itself | left: l - 1 ... | right: n - l - 1 ]
//! ```

use super::plan::{Costs, Plan};
use super::refs::Ref;
use super::split::{self, Binning, Bins};
use super::{BLOCK, MAX_DEPTH, join};
use crate::bounds::Bounds;
use std::sync::atomic::{AtomicUsize, Ordering};

/// From so many triangles on, two sides are built side by side, and progress is told.
const MANY: usize = 1 << 12;

/// Boxes binned or measured in one go, by one thread.
const CHUNK: usize = 1 << 15;

/// A node with two sides.
#[derive(Clone, Copy)]
pub(super) struct Inner {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
    /// The triangles of its left side.
    pub left: u32,
    pub plan: Plan,
}

/// The whole: at least one reference, and one node fewer.
pub(super) struct Binary {
    pub refs: Vec<Ref>,
    pub inner: Vec<Inner>,
}

/// A part of the tree: `count` references from `first` on, and the nodes from `node` on.
#[derive(Clone, Copy)]
pub(super) struct Subtree {
    pub node: usize,
    pub first: usize,
    pub count: usize,
}

impl Binary {
    pub(super) fn root(&self) -> Subtree {
        Subtree { node: 0, first: 0, count: self.refs.len() }
    }

    /// The box around a subtree.
    pub(super) fn bounds(&self, part: Subtree) -> Bounds {
        if part.count == 1 {
            return self.refs[part.first].0;
        }
        let Inner { lo, hi, .. } = self.inner[part.node];
        Bounds { lo: [lo[0], lo[1], lo[2], 0.0], hi: [hi[0], hi[1], hi[2], 0.0] }
    }

    /// The two sides of a subtree of at least two triangles.
    pub(super) fn sides(&self, part: Subtree) -> [Subtree; 2] {
        let left = self.inner[part.node].left as usize;
        let Subtree { node, first, count } = part;
        [
            Subtree { node: node + 1, first, count: left },
            Subtree { node: node + left, first: first + left, count: count - left },
        ]
    }

    /// What is planned for a subtree; a single triangle is a block.
    pub(super) fn plan(&self, part: Subtree) -> Option<Plan> {
        (part.count > 1).then(|| self.inner[part.node].plan)
    }
}

/// Builds the tree over at least one triangle.
pub(super) fn build(mut refs: Vec<Ref>, progress: &(dyn Fn(usize, usize) + Sync)) -> Binary {
    let empty = Inner { lo: [0.0; 3], hi: [0.0; 3], left: 0, plan: Plan::default() };
    let mut inner = vec![empty; refs.len() - 1];
    let scale = around(&refs, |all, r| all.join(&r.0)).scale();
    let builder = Builder { scale, total: refs.len(), done: AtomicUsize::new(0), progress };
    builder.large(&mut refs, &mut inner, 0);
    Binary { refs, inner }
}

struct Builder<'a> {
    /// See [`Bounds::scale`].
    scale: f32,
    total: usize,
    done: AtomicUsize,
    progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl Builder<'_> {
    /// A subtree whose sides may be built side by side. Its depth is bounded by [`MAX_DEPTH`].
    fn large(&self, refs: &mut [Ref], inner: &mut [Inner], depth: usize) -> Built {
        let count = refs.len();
        if count < MANY {
            let built = self.small(refs, inner, depth);
            let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
            (self.progress)(done, self.total);
            return built;
        }
        let left = self.cut(refs, depth);
        let (lr, rr) = refs.split_at_mut(left);
        let (here, li, ri) = nodes_of(inner, left);
        let (a, b) = join(|| self.large(lr, li, depth + 1), || self.large(rr, ri, depth + 1));
        self.finish(here, left, count, &a, &b)
    }

    /// A subtree built by one thread.
    fn small(&self, refs: &mut [Ref], inner: &mut [Inner], depth: usize) -> Built {
        let count = refs.len();
        if count == 1 {
            let bounds = refs[0].0;
            return Built { bounds, costs: Costs::of_one(self.area(&bounds)) };
        }
        let left = if count <= split::FEW {
            split::sort_few(refs, self.scale)
        } else {
            self.cut(refs, depth)
        };
        let (lr, rr) = refs.split_at_mut(left);
        let (here, li, ri) = nodes_of(inner, left);
        let a = self.small(lr, li, depth + 1);
        let b = self.small(rr, ri, depth + 1);
        self.finish(here, left, count, &a, &b)
    }

    /// Sorts the references to the two sides of the cheapest cut.
    fn cut(&self, refs: &mut [Ref], depth: usize) -> usize {
        let count = refs.len();
        // Halving from here on would need so many levels: as long as there are more, the cut is
        // free. The last few boxes, cut anyhow, need at most one level each.
        let levels = count.ilog2() as usize + split::FEW;
        if depth + levels < MAX_DEPTH {
            let centres = around(refs, |all, r| all.reach(r.0.centre(self.scale)));
            let binning = Binning::new(&centres, self.scale);
            if let Some(cut) = bins(refs, &binning).best(self.scale) {
                return split::partition(refs, &binning, cut);
            }
        }
        // All centres alike, or too deep: halves, as they come, of full blocks.
        (count / 2).next_multiple_of(BLOCK)
    }
}

impl Builder<'_> {
    fn area(&self, bounds: &Bounds) -> f32 {
        // A trifle more, so that among boxes without area the fewer nodes win.
        bounds.half_area(self.scale) + 1e-20
    }

    /// Writes a node whose two sides are built.
    #[inline(always)]
    fn finish(&self, here: &mut Inner, left: usize, count: usize, a: &Built, b: &Built) -> Built {
        let mut bounds = a.bounds;
        bounds.join(&b.bounds);
        let (costs, plan) = Costs::join(self.area(&bounds), count, &a.costs, &b.costs);
        let ([lx, ly, lz, _], [hx, hy, hz, _]) = (bounds.lo, bounds.hi);
        *here = Inner { lo: [lx, ly, lz], hi: [hx, hy, hz], left: left as u32, plan };
        Built { bounds, costs }
    }
}

/// What a subtree tells the node above.
struct Built {
    bounds: Bounds,
    costs: Costs,
}

/// The node itself, those of its left side, and those of its right.
fn nodes_of(inner: &mut [Inner], left: usize) -> (&mut Inner, &mut [Inner], &mut [Inner]) {
    let (here, below) = inner.split_at_mut(1);
    let (a, b) = below.split_at_mut(left - 1);
    (&mut here[0], a, b)
}

/// The box around all that `add` adds for each reference.
fn around(refs: &[Ref], add: impl Fn(&mut Bounds, &Ref) + Sync) -> Bounds {
    let one = |refs: &[Ref]| {
        let mut all = Bounds::EMPTY;
        for r in refs {
            add(&mut all, r);
        }
        all
    };
    gather(refs, &one, &|mut a, b| {
        a.join(&b);
        a
    })
}

/// All references in their bins.
fn bins(refs: &[Ref], binning: &Binning) -> Bins {
    gather(refs, &|refs| Bins::of(refs, binning), &|a, b| a.join(&b))
}

/// Does chunks side by side and joins their results, always in the same order.
fn gather<T: Send>(
    refs: &[Ref],
    one: &(impl Fn(&[Ref]) -> T + Sync),
    both: &(impl Fn(T, T) -> T + Sync),
) -> T {
    if refs.len() <= CHUNK {
        return one(refs);
    }
    let (a, b) = refs.split_at(refs.len() / 2);
    let (a, b) = join(|| gather(a, one, both), || gather(b, one, both));
    both(a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::refs;
    use intertri::Triangle;

    fn depth(binary: &Binary, part: Subtree) -> usize {
        let below = |part| 1 + depth(binary, part);
        if part.count == 1 {
            0
        } else {
            binary.sides(part).map(below).into_iter().max().unwrap_or(0)
        }
    }

    #[test]
    fn depth_is_bounded() {
        // Each half as far as the one before: the heuristic peels off a few at a time.
        let at = |i: i32| {
            let x = (i as f32).exp2();
            Triangle([[x, 0.0, 0.0], [x * 1.5, 0.0, 0.0], [x, 0.0, x]])
        };
        let triangles: Vec<_> = (-120..120).flat_map(|i| [at(i); 40]).collect();
        let depth_from = |start| {
            let mut refs = refs::collect(&triangles);
            let empty = Inner { lo: [0.0; 3], hi: [0.0; 3], left: 0, plan: Plan::default() };
            let mut inner = vec![empty; refs.len() - 1];
            let scale = around(&refs, |all, r| all.join(&r.0)).scale();
            let (total, done, progress) = (refs.len(), AtomicUsize::new(0), &|_, _| ());
            Builder { scale, total, done, progress }.large(&mut refs, &mut inner, start);
            let binary = Binary { refs, inner };
            start + depth(&binary, binary.root())
        };
        let needed = triangles.len().ilog2() as usize + split::FEW;
        let free = depth_from(0);
        assert!(free > needed, "{free} levels are no test");
        for start in 0..=MAX_DEPTH - needed {
            assert!(depth_from(start) <= MAX_DEPTH, "from {start} to {}", depth_from(start));
        }
    }
}
