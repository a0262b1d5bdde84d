//! Reinsertion: moves parts of the two-way tree to where they cost less.
//!
//! This follows Bittner, Hapala, and Havran, *Fast Insertion-Based Optimization of Bounding Volume
//! Hierarchies* (2013):
//!
//! ```text
//!        ·                  ·              A long box cannot be cut, so it makes every box around it large,
//!      ╱   ╲              ╱   ╲            from the cut that put it on one side down to its block. Higher
//!     ·     ·     ─►     ·     ·           up, or beside another long box, it costs less.
//!    ╱ ╲   ╱ ╲          ╱ ╲   ╱ ╲
//!   ▯ [══] ▯  ▯        ▯  ▯  ▯   ·
//!                               ╱ ╲
//!                              ▯ [══]
//! ```
//!
//! Only the nodes with the largest boxes are moved, because rays meet them most often. A trial with
//! a few of these nodes determines whether reinsertion is worthwhile, as it is for interiors with
//! long walls but not for scans.

use super::binary::{Binary, MovedNode, Subtree, TRIFLE};
use super::collapse::Costs;
use super::layout::MAX_DEPTH;
use crate::tree::Aabb;
use crate::util::threads::join;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The number of triangles for each node that is moved. At most [`MOST`] nodes are moved.
const SHARE: usize = 32;
/// The maximum number of nodes that are moved.
const MOST: usize = 2048;

/// The trial moves only one in this many nodes.
const FEW: usize = 8;

/// Reinsertion is worthwhile if it lowers the cost by at least this fraction.
const LEAST_GAIN: f64 = 1.0 / 32.0;

/// The number of times each node is moved.
const ROUNDS: usize = 2;

/// With at least this many triangles, the two sides are processed in parallel.
const MANY: usize = 1 << 12;

/// Stands in for the parent of the root, which does not exist.
const NONE: usize = usize::MAX;

/// Moves parts of a tree, keeping the boxes and plans as a new build would compute them.
pub(super) fn reinsert(binary: &mut Binary) {
    // The trial moves an eighth of the nodes once. If that lowers the cost enough, all nodes are
    // moved.
    let most = (binary.refs.len() / SHARE).min(MOST);
    if Top::of(binary, most / FEW).pays(1)
        && let mut top = Top::of(binary, most)
        && top.pays(ROUNDS)
    {
        top.write(binary, MAX_DEPTH);
    }
}

/// The nodes with the largest boxes, from the root (the first) down to parts that stay unchanged.
struct Top(Vec<Node>);

#[derive(Clone)]
struct Node {
    bounds: Aabb,
    area: f64,
    parent: usize,
    below: Children,
}

#[derive(Clone, Copy)]
enum Children {
    Sides([usize; 2]),
    Part(Subtree),
}

impl Node {
    fn new(binary: &Binary, part: Subtree, parent: usize) -> Self {
        let bounds = binary.bounds(part);
        Self { bounds, area: area(&bounds), parent, below: Children::Part(part) }
    }
}

impl Top {
    /// Collects at least `most` nodes, or all if there are fewer.
    fn of(binary: &Binary, most: usize) -> Self {
        let root = binary.root();
        let mut top = vec![Node::new(binary, root, NONE)];
        // Always open the node with the largest box next, because rays meet it most often. Areas
        // are non-negative, so their bits compare like their values.
        let mut largest = BinaryHeap::from([(u64::MAX, 0, root)]);
        while top.len() < most
            && let Some((_, parent, part)) = largest.pop()
        {
            if binary.is_block(part) {
                continue;
            }
            top[parent].below = Children::Sides([top.len(), top.len() + 1]);
            for part in binary.sides(part) {
                let node = Node::new(binary, part, parent);
                largest.push((node.area.to_bits(), top.len(), part));
                top.push(node);
            }
        }
        Self(top)
    }

    /// Moves all nodes `rounds` times, the largest first. Returns whether the cost fell enough.
    fn pays(&mut self, rounds: usize) -> bool {
        let (before, mut waiting) = (self.cost(), Vec::new());
        for _ in 0..rounds {
            let mut order: Vec<usize> = (1..self.0.len()).collect();
            // Order by index if areas are equal, so that the result is the same on every machine.
            order.sort_by_key(|&i| Reverse((self.0[i].area.to_bits(), i)));
            for i in order {
                self.reinsert(i, &mut waiting);
            }
        }
        self.cost() < before * (1.0 - LEAST_GAIN)
    }

    /// Returns the total area of all nodes.
    fn cost(&self) -> f64 {
        self.0.iter().map(|node| node.area).sum()
    }

    /// Removes a subtree and makes it the sibling of the node next to which it costs least. The
    /// subtree's parent moves with it.
    fn reinsert(&mut self, i: usize, waiting: &mut Vec<(f64, usize)>) {
        let parent = self.0[i].parent;
        let above = self.0[parent].parent;
        let Children::Sides([a, b]) = self.0[parent].below else { return };
        // A child of the root has no grandparent to take its sibling, so it stays.
        if above == NONE {
            return;
        }
        let sibling = if a == i { b } else { a };
        // Take the subtree out with its parent; the sibling moves up. The area of the parent, plus
        // the shrinkage of all boxes above, is the cost that any new position has to beat.
        //         above              above            above
        //           │                  │                │
        //         parent     ─►     sibling     ─►      ···
        //         ╱    ╲                                 │
        //        i    sibling                          parent
        //                                              ╱    ╲
        //                                             i     place
        self.replace(above, parent, sibling);
        let saved = self.0[parent].area + self.find_bounds(above);

        let place = self.cheapest_place(&self.0[i].bounds, sibling, saved, waiting);
        self.replace(self.0[place].parent, place, parent);
        self.0[parent].below = Children::Sides([place, i]);
        self.0[place].parent = parent;
        self.find_bounds(parent);
    }

    /// Replaces a child of a node.
    fn replace(&mut self, parent: usize, old: usize, new: usize) {
        self.0[new].parent = parent;
        if let Children::Sides(sides) = &mut self.0[parent].below {
            sides.iter_mut().filter(|side| **side == old).for_each(|side| *side = new);
        }
    }

    /// Recomputes the boxes of a node and of all its ancestors. Returns how much their areas
    /// shrink.
    fn find_bounds(&mut self, mut i: usize) -> f64 {
        let mut less = 0.0;
        while i != NONE
            && let Children::Sides([a, b]) = self.0[i].below
        {
            let bounds = around(self.0[a].bounds, &self.0[b].bounds);
            let node = &mut self.0[i];
            less += node.area;
            (node.bounds, node.area) = (bounds, area(&bounds));
            less -= node.area;
            i = self.0[i].parent;
        }
        less
    }

    /// Finds the node next to which a box costs least, by branch and bound, starting from a
    /// position of known cost.
    fn cheapest_place(
        &self,
        bounds: &Aabb,
        mut place: usize,
        mut cost: f64,
        waiting: &mut Vec<(f64, usize)>,
    ) -> usize {
        let own = area(bounds);
        // Nodes whose children may be better siblings, each with the growth of itself and its
        // ancestors.
        waiting.clear();
        waiting.push((self.with(0, bounds) - self.0[0].area, 0));
        while let Some((grown, i)) = waiting.pop() {
            // Below this node, the new parent's area is at least the box's own, which gives a lower
            // bound that prunes the search.
            if grown + own >= cost {
                continue;
            }
            let Children::Sides(sides) = self.0[i].below else { continue };
            let both = sides.map(|side| self.with(side, bounds));
            let grows = [0, 1].map(|k| both[k] - self.0[sides[k]].area);

            // Visit the side that grows less first: it lowers the bound soonest.
            let near = usize::from(grows[1] < grows[0]);
            // Push both, the nearer last, so that it is popped first.
            for k in [1 - near, near] {
                if grown + both[k] < cost {
                    // Next to `sides[k]`, the new parent's box surrounds both boxes, and the
                    // ancestors grow by `grown`.
                    (cost, place) = (grown + both[k], sides[k]);
                }
                waiting.push((grown + grows[k], sides[k]));
            }
        }
        place
    }

    /// Returns the area of the box around a node and another box.
    fn with(&self, i: usize, bounds: &Aabb) -> f64 {
        area(&around(self.0[i].bounds, bounds))
    }

    /// Writes the inner nodes into the tree, unless some path would have more than `deepest` nodes.
    fn write(&self, binary: &mut Binary, deepest: usize) {
        // A path that is too long would overflow the traversal's stacks, so the whole change is
        // discarded.
        if self.write_node(0, binary, (self.0[0].bounds.scale(), deepest)).is_none() {
            binary.moved.clear();
        }
    }

    /// Writes a node and everything below it.
    fn write_node(
        &self,
        i: usize,
        binary: &mut Binary,
        (scale, deepest): (f32, usize),
    ) -> Option<Written> {
        let Node { bounds, below, .. } = &self.0[i];
        let written = match below {
            Children::Part(part) => Written::of(binary, *part, scale),
            Children::Sides([a, b]) => {
                let rest = (scale, deepest.checked_sub(1)?);
                let a = self.write_node(*a, binary, rest)?;
                let b = self.write_node(*b, binary, rest)?;
                let (costs, plan) = Costs::join(cost_area(bounds, scale), &a.costs, &b.costs);
                let (sides, height) = ([a.part, b.part], 1 + a.height.max(b.height));
                let part = binary.put(MovedNode { bounds: *bounds, sides, plan });
                Written { part, costs, height }
            }
        };
        (written.height <= deepest).then_some(written)
    }
}

/// A part of the tree, its cost, and the number of nodes on its longest path.
struct Written {
    part: Subtree,
    costs: Costs,
    height: usize,
}

impl Written {
    fn of(binary: &Binary, part: Subtree, scale: f32) -> Self {
        let area = cost_area(&binary.bounds(part), scale);
        if binary.is_block(part) {
            return Self { part, costs: Costs::of_block(area), height: 0 };
        }
        let [a, b] = binary.sides(part);
        let of = |part| Self::of(binary, part, scale);
        let (a, b) = if part.count < MANY { (of(a), of(b)) } else { join(|| of(a), || of(b)) };
        let (costs, _) = Costs::join(area, &a.costs, &b.costs);
        Self { part, costs, height: 1 + a.height.max(b.height) }
    }
}

/// Returns the area from which a build computes costs.
fn cost_area(bounds: &Aabb, scale: f32) -> f32 {
    bounds.half_area(scale) + TRIFLE
}

/// Returns half of a box's surface area.
fn area(bounds: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(bounds.hi[k]) - f64::from(bounds.lo[k]));
    // Use f64, because the costs are sums of many areas, and small differences decide.
    x * (y + z) + y * z
}

fn around(mut a: Aabb, b: &Aabb) -> Aabb {
    a.join(b);
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::binary;
    use crate::build::prim_refs;
    use crate::util::test_numbers::random;
    use intertri::Triangle;
    use intertri::simd::Level;

    /// Builds a tree over small triangles and a few that are long along one axis.
    fn room(count: usize) -> Binary {
        let mut random = random();
        let triangle = |i: usize| {
            let at = [random(), random(), random()];
            let mut size = [0.01; 3];
            if i.is_multiple_of(8) {
                size[i / 8 % 3] = 1.0;
            }
            Triangle([(); 3].map(|()| [0, 1, 2].map(|k| at[k] + size[k] * random())))
        };
        let triangles: Vec<_> = (0..count).map(triangle).collect();
        let refs = prim_refs::collect(&triangles[..]).unwrap().refs;
        binary::build(refs, Level::best(), &|_, _| ()).unwrap()
    }

    /// Compares the position found for a node with every possible position, by the cost of the
    /// whole tree.
    #[test]
    fn a_node_goes_where_it_costs_least() {
        let mut top = Top::of(&room(2000), 120);
        let mut moved = 0;
        for i in 1..top.0.len() {
            let parent = top.0[i].parent;
            let (above, Children::Sides(sides)) = (top.0[parent].parent, top.0[parent].below)
            else {
                panic!("a parent has sides");
            };
            if above == NONE {
                continue;
            }
            let before = top.cost();
            let sibling = sides[usize::from(sides[0] == i)];
            top.replace(above, parent, sibling);
            top.find_bounds(above);
            let costs = |place: usize| {
                let mut top = Top(top.0.clone());
                top.replace(top.0[place].parent, place, parent);
                top.0[parent].below = Children::Sides([place, i]);
                top.0[place].parent = parent;
                top.find_bounds(parent);
                top.cost()
            };
            let is_inside = |mut place: usize| {
                while place != NONE && place != i {
                    place = top.0[place].parent;
                }
                place == i
            };
            let places = (1..top.0.len()).filter(|&p| p != parent && !is_inside(p));
            let least = places.map(costs).fold(before, f64::min);

            // Undo the move.
            top.replace(above, sibling, parent);
            top.0[parent].below = Children::Sides([sibling, i]);
            top.0[sibling].parent = parent;
            top.find_bounds(parent);
            assert!((top.cost() / before - 1.0).abs() < 1e-12);

            top.reinsert(i, &mut Vec::new());
            let after = top.cost();
            assert!((after / least - 1.0).abs() < 1e-12, "{i}: {after}, not {least}");
            moved += usize::from(after < before * (1.0 - 1e-12));
        }
        assert!(moved > 10, "{moved}");
    }

    #[test]
    fn a_tree_that_would_be_too_deep_stays_as_it_was() {
        let mut tree = room(5000);
        let mut top = Top::of(&tree, 150);
        assert!(top.pays(ROUNDS));
        let depth = |tree: &Binary| Written::of(tree, tree.root(), 1.0).height;
        let before = depth(&tree);
        top.write(&mut tree, 10);
        assert!(tree.moved.is_empty() && depth(&tree) == before, "{}", depth(&tree));
        top.write(&mut tree, MAX_DEPTH);
        let after = depth(&tree);
        assert!(tree.moved.len() > 70 && after > 10 && after != before, "{before}, {after}");
        tree.moved.clear();
        top.write(&mut tree, after - 1);
        assert!(tree.moved.is_empty());
    }
}
