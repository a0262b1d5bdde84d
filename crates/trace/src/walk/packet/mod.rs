//! Packets: sixteen coherent rays traced together, whatever their origins. Examples are parallel
//! rays, shadow rays toward the sun or a light, and the rays of a moving scanner.
//!
//! ```text
//!   sixteen rays ──► each box of a node, for all rays ──► each triangle of a leaf, for rays that reach it
//!                                                     └──► or each ray, for all eight triangles
//! ```
//!
//! Each lane does what a single ray would do, so no ray loses a hit. Rays that share an origin are
//! traced in bundles instead, which also use a common projection.

mod leaf_tests;
mod traverse;

use intertri::simd::{Lanes, Mask, Simd};
use intertri::{Counts, Filter, Ray, RayId, RayPacket, TriangleId};

use crate::tree::{Margin, Tree};
use crate::util::patience::Patience;
use crate::util::stop;
use crate::walk::BatchOutput;
use crate::walk::bundle::Outcome;
use crate::walk::single::SlabLanes;
use crate::walk::stream::Retired;
use leaf_tests::LeafTests;
pub(crate) use traverse::{Boxes, PacketStack, RAYS, VisitTogether};

/// The maximum difference between a ray's direction and the first ray's direction along each axis,
/// as a fraction of the first direction's largest component. Rays that differ more diverge too
/// soon.
const SPREAD: f32 = 0.25;

/// If, on average, fewer rays than this visit a node or leaf together, tracing them as a stream is
/// faster.
const TOGETHER: usize = 6;

/// After the rays of a packet diverge, this many packets are skipped. The count starts at the first
/// value and doubles with each further failure, up to the second value.
const PATIENCE: [usize; 2] = [4, 1024];

/// Traces packets to find closest hits, or to find out whether rays hit anything.
pub(crate) struct Packets<'a> {
    tree: &'a Tree,
    filter: Filter<'a>,
    margin: Margin,
    is_used: bool,
    stack: PacketStack,
    patience: Patience,
    /// The number of nodes and leaves visited so far.
    pub(crate) visits: usize,
}

impl<'a> Packets<'a> {
    /// Prepares to trace packets in a tree. If `is_used` is false, none are traced.
    pub(crate) fn new(tree: &'a Tree, filter: Filter<'a>, is_used: bool) -> Self {
        // Leaves without a box would have to be tested against every packet.
        let is_used = is_used && tree.first_unboxed(filter.resolver()) == tree.leaves.len();
        let (margin, stack) = (tree.margin(filter.resolver()), PacketStack::default());
        let patience = Patience::new(PATIENCE);
        Self { tree, filter, margin, is_used, stack, patience, visits: 0 }
    }

    /// Traces the packets in a mask, out of up to 1024 rays, except those that are not coherent.
    /// `first` is the index of the first ray in its chunk.
    #[inline(always)]
    pub(crate) fn trace<S: Simd>(
        &mut self,
        (rays, first): (&[Ray], usize),
        packets: u64,
        output: &mut BatchOutput<'_>,
        counts: &mut Counts,
    ) -> Outcome {
        if !self.is_used {
            return Outcome::NotCoherent;
        }
        let mut retired = Retired::new(self.filter.resolver(), RayId(0));
        let mut left = 0;
        for (i, rays) in rays.chunks(RAYS).enumerate() {
            if packets >> i & 1 == 0 {
                continue;
            }
            stop::heed();
            let rays = (rays, RayId((first + RAYS * i) as u32));
            let is_traced = !self.patience.is_waiting()
                && if output.any() {
                    self.packet::<S, true>(rays, output, &mut retired, counts)
                } else {
                    self.packet::<S, false>(rays, output, &mut retired, counts)
                };
            if !is_traced {
                left |= 1 << i;
                self.patience.pass();
            }
        }
        retired.flush::<S>(output);
        let all = packets & u64::MAX >> (64 - rays.len().div_ceil(RAYS));
        if left == all { Outcome::NotCoherent } else { Outcome::InPackets { left } }
    }

    /// Traces a packet. Returns whether it was traced.
    #[inline(always)]
    fn packet<S: Simd, const ANY: bool>(
        &mut self,
        (rays, first): (&[Ray], RayId),
        output: &mut BatchOutput<'_>,
        retired: &mut Retired<'_>,
        counts: &mut Counts,
    ) -> bool {
        let (tree, filter) = (self.tree, self.filter);
        let packet = RayPacket::loaded_in::<S>(rays);
        // Rays with an empty interval hit nothing. If a ray has extreme values, the packet is not
        // traced.
        let t_min = S::F32x16::load(&packet.t_min);
        let live = packet.live() & t_min.lt(S::F32x16::load(&packet.t_max)).bits();
        if !is_coherent::<S>(&packet.dir, live) {
            return false;
        }
        let prepared = filter.prepare_packet_in::<S, RAYS>(&packet);
        let closest = filter.no_hits(&packet);
        let mut tests =
            LeafTests::<S, ANY>::new((tree, filter), (rays, first), prepared, closest, counts);
        let (mut visits, mut visitors) = (0, 0);
        for (octant, same) in octants(negative::<S>(&packet.dir), live) {
            let (lanes, is_plain) =
                SlabLanes::<S::F32x16>::of_packet(&packet, octant, &self.margin);
            if same & !is_plain.bits() != 0 {
                return false;
            }
            tests.begin(same);
            let work =
                self.stack.traverse::<S>(Boxes::of(tree), (&lanes, octant), t_min, &mut tests);
            (visits, visitors) = (visits + work[0], visitors + work[1]);
        }

        if let BatchOutput::Any(any) = output {
            let any = &mut any[first.0 as usize..][..rays.len()];
            any.iter_mut().enumerate().for_each(|(lane, any)| *any = tests.hit >> lane & 1 != 0);
        } else {
            let (triangles, slots) = tests.closest.triangles();
            let hits = triangles.iter().zip(&slots);
            for (lane, (ray, (&triangle, &slot))) in rays.iter().zip(hits).enumerate() {
                let id = RayId(first.0 + lane as u32);
                let hit = (triangle != TriangleId::NONE).then_some((triangle, slot));
                retired.retire::<S>(tree, ray, id, hit, output);
            }
        }

        self.visits += visits;
        self.patience.tried(visitors >= TOGETHER * visits);
        true
    }
}

/// Returns, for each axis, a mask of the rays whose directions are negative. -0 counts as negative,
/// as in the slab test.
#[inline(always)]
pub(crate) fn negative<S: Simd>(dir: &[[f32; RAYS]; 3]) -> [u32; 3] {
    let mut negative = [0; 3];
    for (bits, axis) in negative.iter_mut().zip(dir) {
        // For zeros, `negative` is arbitrary, so transfer the component's sign to 1 instead.
        let sign = S::F32x16::splat(1.0).flip(Lanes::load(axis));
        *bits = sign.negative().bits();
    }
    negative
}

/// Groups rays by octant. All rays in an octant enter every box through the same three sides.
/// `negative` holds, for each axis, a mask of the rays whose directions are negative.
#[inline(always)]
pub(crate) fn octants(negative: [u32; 3], mut rays: u32) -> impl Iterator<Item = (usize, u32)> {
    std::iter::from_fn(move || {
        if rays == 0 {
            return None;
        }
        let lane = rays.trailing_zeros();
        let (mut octant, mut same) = (0, rays);
        for (axis, negative) in negative.iter().enumerate() {
            let is_negative = negative >> lane & 1 != 0;
            octant |= usize::from(is_negative) << axis;
            same &= if is_negative { *negative } else { !negative };
        }
        rays &= !same;
        Some((octant, same))
    })
}

/// Returns whether at least two rays are live and all live rays have similar directions.
#[inline(always)]
pub(crate) fn is_coherent<S: Simd>(dir: &[[f32; RAYS]; 3], live: u32) -> bool {
    if live.count_ones() < 2 {
        return false;
    }
    let first = live.trailing_zeros() as usize % RAYS;
    let [x, y, z] = [dir[0][first], dir[1][first], dir[2][first]];
    let most = SPREAD * x.abs().max(y.abs()).max(z.abs());
    let off = |axis: &[f32; RAYS], first| (S::F32x16::load(axis) - Lanes::splat(first)).abs();
    let apart = off(&dir[0], x).max(off(&dir[1], y)).max(off(&dir[2], z));
    most < f32::INFINITY && live & !apart.le(Lanes::splat(most)).bits() == 0
}

#[cfg(test)]
mod tests;
