//! Given in f64: the walk goes over copies in f32, and the resolver asks the originals.
//!
//! All of it is `inline`, so that only who asks for f64 compiles it.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::io::{self, Write};
use std::ops::Range;
use std::slice::from_ref;

use bytemuck::Zeroable;
use intertri::internal::exact::{self, HitCoefficients, SeenPlane, Side};
use intertri::internal::{Filter, LocalFrame, Originals, Room, Which, prefetch};
use intertri::simd::{Level, Simd, WithSimd};
use intertri::{Hit, Ray, Ray64, Triangle64, TriangleBlock};

use super::mesh64::InF64;
use super::{Ask, Given, Progress};
use crate::across::lanes_of;
use crate::build::{BuildError, Triangles};
use crate::memory::{NoMemory, OutOfMemory, copied, zeros};
use crate::nearest::{ClosestPoint, closest_points};
use crate::refit::{Refit, RefitError};
use crate::save::{EightTriangles, Input, LoadError, read64, write64};
use crate::threads;
use crate::tree::{Aabb, BLOCK, HitBounds, LeafBounds, NONE, Tree};

/// The triangles as given, leaf by leaf as their copies are, and where those are.
#[derive(Clone, Debug)]
pub struct Originals64 {
    frame: LocalFrame,
    leaves: Vec<EightTriangles>,
}

impl Originals64 {
    /// The triangle in a place of the leaves.
    #[inline]
    fn triangle(&self, place: u32) -> &Triangle64 {
        &self.leaves.as_flattened()[place as usize]
    }
}

/// Keeps the triangles of each leaf.
#[inline]
fn keep(
    tree: &Tree,
    triangles: &[Triangle64],
    kept: &mut Vec<EightTriangles>,
) -> Result<(), NoMemory> {
    kept.truncate(tree.leaves.len());
    if kept.is_empty() {
        *kept = zeros(tree.leaves.len())?.into_vec();
    }
    kept.try_reserve(tree.leaves.len() - kept.len())?;
    kept.resize(tree.leaves.len(), Zeroable::zeroed());
    // Where a lane has no triangle, any will do.
    let some = |i: u32| triangles.get(i as usize).copied().unwrap_or(Zeroable::zeroed());
    threads::write(kept, 1 << 7, |i| tree.leaves[i].indices.map(some));
    Ok(())
}

impl Given for f64 {
    type Originals = Originals64;
    const PIECE: usize = 1 << 12;

    #[inline]
    fn build(
        triangles: &[Triangle64],
        progress: Progress<'_>,
    ) -> Result<(Tree, Originals64), BuildError> {
        let copies = Copies::new(triangles);
        let (tree, frame) = (Tree::over(&copies, progress)?, copies.frame);
        let mut leaves = Vec::new();
        keep(&tree, triangles, &mut leaves)
            .map_err(|NoMemory| BuildError::OutOfMemory { count: triangles.len() })?;
        Ok((tree, Originals64 { frame, leaves }))
    }

    fn try_clone(originals: &Originals64) -> Result<Originals64, OutOfMemory> {
        let Originals64 { frame, leaves } = originals;
        Ok(Originals64 { frame: *frame, leaves: copied(leaves)? })
    }

    #[inline]
    fn walk_one<A>(
        tree: &Tree,
        originals: &Originals64,
        which: &Which<'_>,
        ray: &Ray64,
        ask: impl FnOnce(&Which<'_>, &Ray) -> A,
    ) -> A {
        let asked = Asked::new(tree, originals, which, (from_ref(ray), 0..1));
        ask(&asked.test(), &originals.frame.ray(ray))
    }

    #[inline]
    fn walk(
        tree: &Tree,
        originals: &Originals64,
        which: &Which<'_>,
        rays: (&[Ray64], Range<usize>),
        ask: Ask<'_>,
    ) {
        let asked = Asked::new(tree, originals, which, rays);
        let mut copies = COPIES.take();
        originals.frame.rays(asked.level, asked.rays, &mut copies);
        ask(&asked.test(), &copies);
        COPIES.set(copies);
    }

    #[inline]
    fn triangle(_: &Tree, originals: &Originals64, place: u32) -> Triangle64 {
        *originals.triangle(place)
    }

    #[inline]
    fn point(originals: &Originals64, point: [f64; 3]) -> [f32; 3] {
        originals.frame.point(point)
    }

    #[inline]
    fn closest_points(
        tree: &Tree,
        originals: &Originals64,
        points: &[[f64; 3]],
        radius: f64,
        closest: &mut [ClosestPoint],
    ) {
        let Originals64 { frame, leaves } = originals;
        closest_points(InF64 { tree, frame, leaves }, points, radius, closest);
    }

    #[inline]
    fn refit_tree(
        tree: &mut Tree,
        originals: &mut Originals64,
        triangles: &[Triangle64],
    ) -> Result<Refit, RefitError> {
        // The frame of a new build.
        let copies = Copies::new(triangles);
        let (refit, frame) = (tree.refit(&copies)?, copies.frame);
        originals.frame = frame;
        if let Err(NoMemory) = keep(tree, triangles, &mut originals.leaves) {
            tree.clear();
            return Err(RefitError::OutOfMemory);
        }
        Ok(refit)
    }

    #[inline]
    fn write_tree(tree: &Tree, originals: &Originals64, output: &mut dyn Write) -> io::Result<()> {
        write64(tree, &originals.frame, &originals.leaves, output)
    }

    #[inline]
    fn read_tree(input: &mut dyn Input) -> Result<(Tree, Originals64), LoadError> {
        let (tree, frame, leaves) = read64(input)?;
        Ok((tree, Originals64 { frame, leaves }))
    }
}

/// So many triangles tell where most are.
const SAMPLE: usize = 1000;

/// The frame of all triangles that are finite.
#[inline]
fn frame_around(triangles: &[Triangle64]) -> LocalFrame {
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for triangle in triangles {
        let corners = triangle.0.as_flattened();
        // Times zero, a NaN or an infinity is NaN and stays so in the sum.
        if corners.iter().map(|x| x * 0.0).sum::<f64>() == 0.0 {
            for (i, &x) in corners.iter().enumerate() {
                (lo[i % 3], hi[i % 3]) = (lo[i % 3].min(x), hi[i % 3].max(x));
            }
        }
    }
    LocalFrame::around([lo, hi], crowd(triangles))
}

/// Between which coordinates most triangles are, by the first corners of some.
#[inline]
fn crowd(triangles: &[Triangle64]) -> [[f64; 3]; 2] {
    let step = triangles.len().div_ceil(SAMPLE).max(1);
    let some = triangles.iter().step_by(step).map(|triangle| triangle.0[0]);
    let some: Vec<[f64; 3]> = some.filter(|corner| corner.iter().all(|x| x.is_finite())).collect();
    let mut crowd = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
    for k in 0..3 {
        let mut along: Vec<f64> = some.iter().map(|corner| corner[k]).collect();
        along.sort_unstable_by(f64::total_cmp);
        // Without a tenth at each end.
        if let Some(last) = along.len().checked_sub(1) {
            crowd[0][k] = along[last / 10];
            crowd[1][k] = along[last - last / 10];
        }
    }
    crowd
}

/// Triangles to be copied.
struct Copies<'a> {
    frame: LocalFrame,
    triangles: &'a [Triangle64],
    level: Level,
}

impl<'a> Copies<'a> {
    /// About the middle of them.
    #[inline]
    fn new(triangles: &'a [Triangle64]) -> Self {
        Self { frame: frame_around(triangles), triangles, level: Level::best() }
    }
}

impl Triangles for Copies<'_> {
    #[inline]
    fn count(&self) -> usize {
        self.triangles.len()
    }

    #[inline]
    fn hit_bounds(&self, i: usize) -> HitBounds {
        let triangle = &self.triangles[i];
        let Some(bounds) = self.frame.bounds(triangle) else { return HitBounds::Nowhere };
        let [lo, hi] = bounds.map(|[x, y, z]| [x, y, z, 0.0]);
        let bounds = Aabb { lo, hi };
        // What f64 sees no area of may have one.
        if triangle.normal() == [0.0; 3] && !exact::has_area(triangle) {
            return HitBounds::Degenerate(bounds);
        }
        HitBounds::Box { bounds, lean: 0.0 }
    }

    #[inline]
    fn block(&self, indices: &[u32; BLOCK]) -> TriangleBlock<8> {
        let count = indices.iter().take_while(|&&i| i != NONE).count();
        let all = ((1_u64 << count) - 1) as u32;
        self.copied(indices, all, all)
    }

    #[inline]
    fn moved(&self, indices: &[u32; BLOCK]) -> (TriangleBlock<8>, LeafBounds) {
        let mut leaf = LeafBounds::NONE;
        for (lane, &i) in indices.iter().enumerate().take_while(|(_, i)| **i != NONE) {
            let (bounds, lanes) = match self.hit_bounds(i as usize) {
                HitBounds::Nowhere | HitBounds::Thin(_) => continue,
                HitBounds::Box { bounds, .. } => (bounds, &mut leaf.boxed),
                HitBounds::Degenerate(bounds) => (bounds, &mut leaf.degenerate),
            };
            leaf.bounds.join(&bounds);
            *lanes |= 1 << lane;
        }
        (self.copied(indices, leaf.present(), leaf.boxed), leaf)
    }
}

impl Copies<'_> {
    /// The copies of the triangles in some lanes, some of which are live; other lanes repeat one of them.
    #[inline]
    fn copied(&self, indices: &[u32; BLOCK], present: u32, live: u32) -> TriangleBlock<8> {
        let Some(first) = lanes_of(present).next() else { return TriangleBlock::of_copies(&[]) };
        let mut corners = [[[0.0; BLOCK]; 3]; 3];
        for lane in 0..BLOCK {
            let some = if present >> lane & 1 != 0 { lane } else { first };
            let triangle = &self.triangles[indices[some] as usize];
            for (rows, corner) in corners.iter_mut().zip(&triangle.0) {
                for (row, x) in rows.iter_mut().zip(corner) {
                    row[lane] = *x;
                }
            }
        }
        self.level.run(CopyBlock { frame: &self.frame, corners: &corners, live })
    }
}

/// Copies eight triangles that are side by side.
struct CopyBlock<'a> {
    frame: &'a LocalFrame,
    corners: &'a [[[f64; BLOCK]; 3]; 3],
    live: u32,
}

impl WithSimd for CopyBlock<'_> {
    type Output = TriangleBlock<8>;

    #[inline(always)]
    fn run<S: Simd>(self) -> TriangleBlock<8> {
        self.frame.block_in::<S>(self.corners, self.live)
    }
}

thread_local! {
    /// The copies of rays, some after the other.
    static COPIES: RefCell<Vec<Ray>> = const { RefCell::new(Vec::new()) };
    /// What is computed of triangles for one bundle after the other.
    static SCRATCH: RefCell<Vec<[HitCoefficients; 8]>> = const { RefCell::new(Vec::new()) };
}

/// Rays on their way through a tree, as given.
#[derive(Debug)]
struct Asked<'a> {
    tree: &'a Tree,
    originals: &'a Originals64,
    rays: &'a [Ray64],
    /// Those that come later.
    later: &'a [Ray64],
    room: Room,
    level: Level,
}

impl<'a> Asked<'a> {
    #[inline]
    fn new(
        tree: &'a Tree,
        originals: &'a Originals64,
        which: &Which<'_>,
        (all, some): (&'a [Ray64], Range<usize>),
    ) -> Self {
        let room = Room::of_copies(originals.frame.reach());
        let (rays, later) = (&all[some.clone()], &all[some.end..]);
        Self { tree, originals, rays, later, room, level: which.level() }
    }

    /// The filter over copies, with these behind it.
    #[inline]
    fn test(&self) -> Which<'_> {
        Filter::on_copies(self, &self.room, self.level).into()
    }

    #[inline]
    fn pair(&self, ray: u32, place: u32) -> (&Ray64, &Triangle64) {
        (&self.rays[ray as usize], self.originals.triangle(place))
    }
}

impl Originals for Asked<'_> {
    #[inline]
    fn hit(&self, ray: u32, place: u32) -> Option<f64> {
        let (original, triangle) = self.pair(ray, place);
        exact::hit(original, triangle).then(|| self.t(ray, place))
    }

    #[inline]
    fn t(&self, ray: u32, place: u32) -> f64 {
        let (ray, triangle) = self.pair(ray, place);
        exact::t_times(ray, triangle, self.originals.frame.exponent(ray))
    }

    #[inline]
    fn order(&self, ray: u32, one: u32, other: u32) -> Ordering {
        let ((ray, one), (_, other)) = (self.pair(ray, one), self.pair(ray, other));
        exact::order(ray, one, other)
    }

    #[inline]
    fn ray(&self, ray: u32) -> &Ray64 {
        &self.rays[ray as usize]
    }

    #[inline]
    fn plane(&self, ray: u32, place: u32) -> SeenPlane<f64> {
        let (ray, triangle) = self.pair(ray, place);
        SeenPlane::new(triangle, ray.origin)
    }

    #[inline]
    fn touch(&self, ray: u32, one: u32, other: u32) -> bool {
        let ((ray, one), (_, other)) = (self.pair(ray, one), self.pair(ray, other));
        exact::touch(ray, one, other)
    }

    #[inline]
    fn starts_on(&self, ray: u32, place: u32) -> bool {
        let (ray, triangle) = self.pair(ray, place);
        exact::is_on(triangle, ray.origin)
    }

    #[inline]
    fn facing(&self, ray: u32, place: u32) -> Option<Side> {
        let (ray, triangle) = self.pair(ray, place);
        exact::facing(ray, triangle)
    }

    #[inline]
    fn crossing(&self, ray: u32, place: u32) -> Option<Side> {
        let (ray, triangle) = self.pair(ray, place);
        exact::crossing(ray, triangle)
    }

    #[inline]
    fn later(&self, ray: u32, count: usize) -> &[u8] {
        let later = self.later.get(ray as usize..).unwrap_or(&[]);
        bytemuck::cast_slice(&later[..later.len().min(count)])
    }

    #[inline]
    fn prefetch(&self, ray: u32, place: u32) {
        let (ray, triangle) = self.pair(ray, place);
        prefetch(from_ref(ray));
        prefetch(from_ref(triangle));
    }

    #[inline]
    fn shared_origin_hits(
        &self,
        rays: Range<u32>,
        places: &[u32],
        pairs: &[(u32, u32)],
        hits: &mut [Hit],
    ) {
        let first = rays.start;
        let rays = &self.rays[first as usize..rays.end as usize];
        let origin = |ray: &Ray64| ray.origin.map(f64::to_bits);
        if rays.iter().any(|ray| origin(ray) != origin(&rays[0])) {
            // Only their copies start at one.
            for (&(ray, number), hit) in pairs.iter().zip(hits) {
                let place = places.get(number as usize);
                *hit = place.map_or(Hit::MISS, |&place| self.hit_attributes(first + ray, place));
            }
            return;
        }
        let triangle = |&place: &u32| (self.originals.triangle(place), self.tree.index_of(place));
        let triangles: Vec<_> = places.iter().map(triangle).collect();
        SCRATCH.with_borrow_mut(|scratch| {
            exact::hits_of_origin64(self.level, rays, &triangles, pairs, scratch, hits);
        });
    }

    #[inline]
    fn hits(&self, pairs: &[(u32, u32)], hits: &mut [Hit]) {
        for (pairs, hits) in pairs.chunks(8).zip(hits.chunks_mut(8)) {
            let of = |i: usize| {
                let (number, place) = pairs[i.min(pairs.len() - 1)];
                let (ray, triangle) = self.pair(number, place);
                (ray, triangle, self.tree.index_of(place))
            };
            let eight: [_; 8] = std::array::from_fn(of);
            exact::hits64(self.level, &eight[..pairs.len()], hits);
        }
    }
}
