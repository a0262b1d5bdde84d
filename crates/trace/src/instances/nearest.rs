//! Closest-point search in a scene: descends the tree of instances and then the trees of their
//! meshes, visiting the nearest boxes first. The boxes of a mesh are transformed to world space.
//!
//! Boxes are ordered by lower bounds on their distances. Triangles are compared by their f64
//! distances and, where those are too close to decide, exactly.

use std::ops::ControlFlow;

use intertri::internal::exact::{Tier, closer, closest};
use intertri::{LeafSlot, Triangle64};

use super::collect::Candidate;
use super::committed::{Committed, MeshEntry};
use super::matrix::{Matrix, placed_triangle, sizes, world_box};
use super::mesh::SceneMesh;
use super::snapshot::SceneSnapshot;
use super::world_walk::nearest_last;
use crate::bvh::Bvh;
use crate::scalar::BvhScalar;
use crate::tree::{EMPTY, LEAF, Node};
use crate::util::lane_ops::lanes_of;

/// Distances that differ by at most this fraction may be equal, because each is accurate to within
/// an ulp.
const DOUBT: f64 = 4.0 * f64::EPSILON;

/// The absolute counterpart of [`DOUBT`], for subnormal distances.
const STEPS: f64 = f64::from_bits(4);

/// Lengths between this (2^-400) and its inverse have squares that neither overflow nor underflow.
const SMALL: f64 = f64::from_bits((1023 - 400) << 52);

/// A callback for each triangle of an instance that a search visits.
type Visit<'v> = dyn FnMut(&mut Search<'_>, Candidate) -> ControlFlow<()> + 'v;

/// A search around a point.
pub(super) struct Search<'a> {
    scene: &'a Committed,
    mask: u32,
    point: [f64; 3],
    /// Triangles farther than this do not count.
    far: f64,
    /// The triangles that may be the closest, with their distances.
    found: Vec<(f64, Candidate)>,
}

impl<'a> Search<'a> {
    pub(super) fn new(snapshot: &'a SceneSnapshot, point: [f64; 3], radius: f64) -> Self {
        let (scene, mask) = (&*snapshot.committed, snapshot.mask);
        Self { scene, mask, point, far: doubtful(radius), found: Vec::new() }
    }

    /// Finds the closest triangle.
    pub(super) fn run(&mut self) -> Option<Candidate> {
        let point = self.point;
        let _ = self.walk(&mut |search, candidate| {
            let distance = closest(Tier::Float, point, &candidate.triangle).distance;
            if distance <= search.far {
                search.far = search.far.min(doubtful(distance));
                search.found.push((distance, candidate));
            }
            ControlFlow::Continue(())
        });
        let far = self.far;
        self.found.retain(|(distance, _)| *distance <= far);
        // Go in index order: a later triangle replaces the best only if it is strictly closer.
        self.found.sort_unstable_by_key(|(_, candidate)| candidate.key());
        let candidates = self.found.iter().map(|(_, candidate)| *candidate);
        candidates.reduce(|best, other| {
            if closer(point, &other.triangle, &best.triangle).is_lt() { other } else { best }
        })
    }

    /// Returns whether any nearby triangle satisfies a predicate.
    pub(super) fn any(&mut self, is: impl Fn(&Triangle64) -> bool) -> bool {
        let found = self.walk(&mut |_, Candidate { triangle, .. }| {
            if is(&triangle) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        found.is_break()
    }

    /// Visits the triangles that may be within `far`.
    fn walk(&mut self, visit: &mut Visit<'_>) -> ControlFlow<()> {
        let Committed { top, .. } = self.scene;
        for &instance in &top.everywhere {
            self.instance(instance as usize, visit)?;
        }
        let mut stack = vec![(0.0, 0)];
        while let Some((near, child)) = stack.pop() {
            if near > self.far || child == EMPTY {
                continue;
            }
            if child & LEAF != 0 {
                self.instance((child ^ LEAF) as usize, visit)?;
            } else if let Some(node) = top.nodes.get(child as usize) {
                self.push(&mut stack, node, |slot| top.child_box(node, slot));
            }
        }
        ControlFlow::Continue(())
    }

    fn instance(&mut self, instance: usize, visit: &mut Visit<'_>) -> ControlFlow<()> {
        if self.scene.placed[instance].mask & self.mask == 0 {
            return ControlFlow::Continue(());
        }
        match self.scene.mesh(instance) {
            Some(entry @ MeshEntry { mesh: SceneMesh::F32(bvh), .. }) => {
                self.mesh(bvh, entry, instance, visit)
            }
            Some(entry @ MeshEntry { mesh: SceneMesh::F64(bvh), .. }) => {
                self.mesh(bvh, entry, instance, visit)
            }
            None => ControlFlow::Continue(()),
        }
    }

    fn mesh<X: BvhScalar>(
        &mut self,
        bvh: &Bvh<X>,
        MeshEntry { extent, .. }: &MeshEntry,
        instance: usize,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()> {
        let (tree, matrix) = (&bvh.tree, &self.scene.placed[instance].matrix);
        let sizes = sizes(matrix, extent);
        // Few leaves are outside the main tree, so visit them all.
        for leaf in tree.boxed..tree.leaves.len() {
            self.leaf(bvh, matrix, leaf, instance, visit)?;
        }
        let mut stack = vec![(0.0, if tree.boxed > 0 { 0 } else { EMPTY })];
        while let Some((near, child)) = stack.pop() {
            if near > self.far || child == EMPTY {
                continue;
            }
            if child & LEAF != 0 {
                self.leaf(bvh, matrix, (child ^ LEAF) as usize, instance, visit)?;
            } else {
                let node = &tree.nodes[child as usize];
                self.push(&mut stack, node, |slot| {
                    world_box(matrix, extent.child_box(node, slot), &sizes)
                });
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits the triangles of a leaf.
    fn leaf<X: BvhScalar>(
        &mut self,
        bvh: &Bvh<X>,
        matrix: &Matrix,
        leaf: usize,
        instance: usize,
        visit: &mut Visit<'_>,
    ) -> ControlFlow<()> {
        for lane in lanes_of(bvh.tree.present(leaf)) {
            let slot = LeafSlot((8 * leaf + lane) as u32);
            let corners = bvh.triangle_in(slot).0;
            let triangle = placed_triangle(matrix, corners.map(|corner| corner.map(Into::into)));
            let is_finite = triangle.0.as_flattened().iter().all(|x| x.is_finite());
            if is_finite && lower_bound(self.point, &around(&triangle)) <= self.far {
                let (instance, position) = (instance as u32, bvh.tree.index_of(slot).0);
                visit(self, Candidate { instance, position, triangle })?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Pushes the children of a node that may be within `far`, nearest last.
    #[inline(always)]
    fn push(
        &self,
        stack: &mut Vec<(f64, u32)>,
        node: &Node,
        bounds: impl Fn(usize) -> [[f64; 3]; 2],
    ) {
        let start = stack.len();
        for (slot, &child) in node.children().iter().enumerate().filter(|(_, c)| **c != EMPTY) {
            let near = lower_bound(self.point, &bounds(slot));
            if near <= self.far {
                stack.push((near, child));
            }
        }
        nearest_last(&mut stack[start..]);
    }
}

/// Returns the largest distance that may be equal to the given one after rounding.
fn doubtful(distance: f64) -> f64 {
    distance * (1.0 + DOUBT) + STEPS
}

/// Returns the box around a triangle.
fn around(Triangle64([a, b, c]): &Triangle64) -> [[f64; 3]; 2] {
    [[0, 1, 2].map(|k| a[k].min(b[k]).min(c[k])), [0, 1, 2].map(|k| a[k].max(b[k]).max(c[k]))]
}

/// Returns a lower bound on the distance from a point to a box, ignoring NaN coordinates.
#[inline(always)]
fn lower_bound(point: [f64; 3], [lo, hi]: &[[f64; 3]; 2]) -> f64 {
    // Compute the gap along each axis; `max` ignores NaN.
    let gap = [0, 1, 2].map(|k| (lo[k] - point[k]).max(point[k] - hi[k]).max(0.0));
    let most = gap[0].max(gap[1]).max(gap[2]);
    // The largest gap is itself a lower bound.
    let near = if most > SMALL && most < 1.0 / SMALL {
        (gap[0] * gap[0] + gap[1] * gap[1] + gap[2] * gap[2]).sqrt()
    } else {
        most
    };
    near * (1.0 - DOUBT)
}
