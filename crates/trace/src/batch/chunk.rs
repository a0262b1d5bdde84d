//! Traces a chunk of rays on one thread: coherent rays with a common apex in bundles, other
//! coherent rays in packets, and the rest in streams.

use intertri::simd::{Simd, WithSimd};
use intertri::{Counts, Filter, Ray, RayId};

use super::choice::Choice;
use crate::containment::Containment;
use crate::selection::ActiveSelection;
use crate::tree::Tree;
use crate::util::patience::Patience;
use crate::util::stop;
use crate::walk::BatchOutput;
use crate::walk::beam::Beams;
use crate::walk::bundle::{
    Bundle, BundleRays, Common, CommonEnd, Outcome, Projection, RAYS, Results, Scratch,
    endless_direction, shares_origin,
};
use crate::walk::packet::Packets;
use crate::walk::stream::Stream;

/// Rays outside any bundle are traced as a stream once there are this many. More rays would not fit
/// in the cache.
const STREAM: usize = 4096;
/// The corresponding number directly after a bundle. It is larger, because some CPUs lower their
/// clock rate for a while after a bundle.
const STREAM_AFTER_BUNDLE: usize = 4 * STREAM;

/// After a reversed bundle that was not worth its cost, the next bundles are not reversed, and
/// their rays are traced in packets. The first number is the number of bundles to which this
/// applies. It doubles after each further failure, up to the second number. Bundles fail, for
/// example, if the shadow rays of one row of hits form a long, thin curve as seen from the light.
const REVERSAL_PATIENCE: [usize; 2] = [4, 64];

/// The same limits for bundles that are not reversed. For example, rays from one camera in random
/// order share an origin, but each packet of these rays covers the whole image.
const BUNDLE_PATIENCE: [usize; 2] = [2, 64];

/// A bundle was not worth its cost if it took more packet tests per ray than this. Its rays would
/// have been faster to trace one by one.
const EXPENSIVE: usize = 14;

/// The number of rays in the smallest bundle.
const SMALLEST: usize = 16;

/// If a bundle needs more packet tests per ray than this, the next bundles have no more than
/// [`BUSY_RAYS`] rays, so that small triangles are tested against fewer windows that they miss.
const BUSY: usize = 5;
/// The maximum number of rays in the bundles after a bundle that needed many packet tests.
const BUSY_RAYS: usize = 256;

/// The number of parallel rays with which bundles and packets are compared.
const TRIAL: usize = 256;
/// Fewer parallel rays than this are traced in packets.
const FEWEST: usize = 64;

/// Consecutive rays, together with everything needed to trace them.
#[derive(Clone, Copy)]
pub(super) struct Chunk<'a> {
    pub(super) tree: &'a Tree,
    pub(super) filter: Filter<'a>,
    pub(super) selection: ActiveSelection<'a>,
    pub(super) rays: &'a [Ray],
}

impl Chunk<'_> {
    /// Traces the rays. `choice` is what was learned from earlier ones.
    pub(super) fn trace(self, output: BatchOutput<'_>, choice: &mut Choice) -> Counts {
        match output {
            BatchOutput::Containments(containments) => self.trace_beams(containments),
            output => self.filter.level().run(TraceChunk { chunk: self, output, choice }),
        }
    }

    /// Classifies the origins of rays, with beams for parallel rays and with a stream for the rest.
    fn trace_beams(self, containments: &mut [Containment]) -> Counts {
        let Self { tree, filter, rays, .. } = self;
        let mut counts = Counts::default();
        let beams = Beams { tree, filter, rays, containments, counts: &mut counts };
        let left = filter.level().run(beams);
        if !left.is_empty() {
            let output = &mut BatchOutput::Containments(containments);
            trace_stream(&self, &left, output, &mut counts);
        }
        counts
    }
}

/// Traces rays of a chunk as a stream. This function is never inlined, because otherwise each SIMD
/// level's copy of the chunk would contain every level's stream.
#[inline(never)]
fn trace_stream(
    chunk: &Chunk<'_>,
    ids: &[RayId],
    output: &mut BatchOutput<'_>,
    counts: &mut Counts,
) {
    let Chunk { tree, filter, ref selection, rays } = *chunk;
    filter.level().run(Stream { tree, filter, rays, ids, output, selection, counts });
}

/// A chunk and its output.
struct TraceChunk<'a, 'b> {
    chunk: Chunk<'a>,
    output: BatchOutput<'b>,
    choice: &'b mut Choice,
}

impl WithSimd for TraceChunk<'_, '_> {
    type Output = Counts;

    #[inline(always)]
    fn run<S: Simd>(self) -> Counts {
        let Self { chunk, mut output, choice } = self;
        let (all, any) = (chunk.rays, output.any());
        let mut projection = Projection::<S>::empty();
        let mut scratch = Scratch::default();
        let memory = (&mut projection, &mut scratch);
        let mut tracer = Tracer::<S>::new(&chunk, &output, choice, memory);
        let (mut counts, mut others, mut at, mut size) = (Counts::default(), vec![], 0, RAYS);
        while at < all.len() {
            stop::check();
            let end = (at + size).min(all.len());
            let rays = BatchRays { rays: &all[at..end], next: &all[end..], at };
            let (is_together, left, work) = match tracer.trace(rays, &mut output, &mut counts) {
                Outcome::Traced { left, work } => (true, left, work),
                // A smaller number of consecutive rays may still be close together.
                Outcome::TooWide if size > SMALLEST => {
                    size /= 4;
                    continue;
                }
                Outcome::InPackets { left } => (true, left, 0),
                Outcome::TooWide | Outcome::NotCoherent => (false, u64::MAX, 0),
            };

            // Leave the other rays for the next stream, except rays whose any-hit query is already
            // answered.
            let Tracer { projection, results, .. } = &tracer;
            if left != 0 || projection.has_outliers {
                let over = |ray: usize| any && results.is_hit(ray);
                let is_outlier = |ray: usize| projection.has_outliers && projection.is_outlier(ray);
                let is_left = |ray: usize| left >> (ray / 16) & 1 != 0 || is_outlier(ray);
                let waits = |ray: &usize| is_left(*ray) && !over(*ray);
                others.extend((0..end - at).filter(waits).map(|ray| RayId((at + ray) as u32)));
            }
            size = next_size(size, end, work > BUSY * (end - at));
            at = end;

            let enough = if is_together { STREAM_AFTER_BUNDLE } else { STREAM };
            if others.len() >= enough || at == all.len() && !others.is_empty() {
                trace_stream(&chunk, &others, &mut output, &mut counts);
                others.clear();
            }
        }
        counts
    }
}

/// Some consecutive rays of a chunk.
#[derive(Clone, Copy)]
struct BatchRays<'a> {
    rays: &'a [Ray],
    /// The rays that follow.
    next: &'a [Ray],
    /// The index of the first ray.
    at: usize,
}

/// Traces rays together, and keeps what is needed for the next rays.
struct Tracer<'a, 'b, S: Simd> {
    chunk: Chunk<'a>,
    any: bool,
    every: bool,
    /// Whether bundles are possible.
    bundles: bool,
    packets: Packets<'a>,
    patience: [Patience; 2],
    /// How parallel rays are traced.
    choice: &'b mut Choice,
    /// References, because these are large and slow to move.
    projection: &'b mut Projection<S>,
    scratch: &'b mut Scratch,
    results: Results,
}

impl<'a, 'b, S: Simd> Tracer<'a, 'b, S> {
    #[inline(always)]
    fn new(
        chunk: &Chunk<'a>,
        output: &BatchOutput<'_>,
        choice: &'b mut Choice,
        (projection, scratch): (&'b mut Projection<S>, &'b mut Scratch),
    ) -> Self {
        let Chunk { tree, filter, selection, .. } = *chunk;
        let (any, every, is_plain) = (output.any(), output.every(), selection.is_none());
        Self {
            chunk: *chunk,
            any,
            every,
            // Bundles do not support selections, and crossings are counted ray by ray.
            bundles: is_plain && (!every || matches!(output, BatchOutput::Pairs(_))),
            packets: Packets::new(tree, filter, is_plain && !every),
            patience: [BUNDLE_PATIENCE, REVERSAL_PATIENCE].map(Patience::new),
            choice,
            projection,
            scratch,
            results: Results::default(),
        }
    }

    /// Traces rays in a bundle, if they form one, or in packets.
    #[inline(always)]
    fn trace(
        &mut self,
        rays: BatchRays<'_>,
        output: &mut BatchOutput<'_>,
        counts: &mut Counts,
    ) -> Outcome {
        // Coherent rays form a bundle. If they diverge too much, try a smaller one.
        self.results.clear();
        let [forward, reversed] = self.patience.each_ref().map(|patience| !patience.is_waiting());
        let allowed = [self.bundles && forward, self.bundles && self.any && reversed];
        self.patience.iter_mut().for_each(Patience::pass);
        let Some(bundle) = self.bundle_of(rays, allowed) else {
            return self.in_packets(rays, u64::MAX, output, counts);
        };
        if matches!(bundle.common, Common::Direction { .. }) && !self.every {
            return self.trace_parallel((bundle, rays), output, counts);
        }
        let outcome = self.in_bundle((&bundle, rays), usize::MAX, output, counts);
        let is_reversed = matches!(bundle.common, Common::End(_));
        if is_reversed || matches!(outcome, Outcome::Traced { .. }) {
            self.patience[usize::from(is_reversed)].tried(pays(&outcome, rays.rays));
        }
        let is_too_wide = matches!(outcome, Outcome::TooWide);
        if is_too_wide && !matches!(bundle.common, Common::Origin) {
            return self.in_packets(rays, u64::MAX, output, counts);
        }
        outcome
    }

    /// Makes a bundle from the rays if bundles are allowed and the rays share an origin or a direction.
    /// If reversed bundles are also allowed, as for any-hit queries, a common end is enough, because
    /// such rays can be traced backward.
    #[inline(always)]
    fn bundle_of<'c>(
        &self,
        BatchRays { rays, next, at }: BatchRays<'c>,
        [bundles, reversible]: [bool; 2],
    ) -> Option<BundleRays<'c>> {
        let filter = &self.chunk.filter;
        let bundle = |common| Some(BundleRays { rays, first: RayId(at as u32), next, common });
        if bundles && shares_origin(rays) {
            return bundle(Common::Origin);
        }
        // The document's modes would need other bounds for parallel rays.
        if bundles
            && filter.resolver().hits_lie_on_triangles()
            && let Some(is_endless) = endless_direction(rays)
        {
            return bundle(Common::Direction { reversed: self.any && is_endless });
        }
        if !reversible {
            return None;
        }
        CommonEnd::of(rays, filter.threshold()).and_then(|end| bundle(Common::End(end)))
    }

    /// Traces parallel rays in a bundle or in packets.
    #[inline(always)]
    fn trace_parallel(
        &mut self,
        (bundle, rays): (BundleRays<'_>, BatchRays<'_>),
        output: &mut BatchOutput<'_>,
        counts: &mut Counts,
    ) -> Outcome {
        let count = rays.rays.len();
        if self.choice.is_trial() && count > TRIAL {
            return Outcome::TooWide;
        }
        // A few rays tell little about the others.
        if count < FEWEST {
            return self.in_packets(rays, u64::MAX, output, counts);
        }
        let Some(limit) = self.choice.limit(count) else {
            let before = self.packets.visits;
            let outcome = self.in_packets(rays, u64::MAX, output, counts);
            self.choice.took_packets(self.packets.visits - before, &outcome, count);
            return outcome;
        };
        let (left, work) = match self.in_bundle((&bundle, rays), limit, output, counts) {
            Outcome::Traced { left, work } => (left, work),
            _ => (u64::MAX, limit),
        };
        self.choice.took_bundle(work, left, count);
        if left == 0 {
            return Outcome::Traced { left, work };
        }
        // What the bundle leaves is traced in packets.
        match self.in_packets(rays, left, output, counts) {
            Outcome::InPackets { left } => Outcome::Traced { left, work },
            _ => Outcome::Traced { left, work },
        }
    }

    /// Traces rays in a bundle, and writes its results. If the work exceeds a limit, some packets are
    /// left.
    #[inline(always)]
    fn in_bundle(
        &mut self,
        (bundle, rays): (&BundleRays<'_>, BatchRays<'_>),
        limit: usize,
        output: &mut BatchOutput<'_>,
        counts: &mut Counts,
    ) -> Outcome {
        let Self { chunk, any, every, projection, scratch, results, .. } = self;
        let outcome = S::vectorize(
            #[inline(always)]
            || {
                let (Chunk { tree, filter, .. }, any, every) = (*chunk, *any, *every);
                let scratch = (&mut **projection, &mut **scratch, &mut *results);
                Bundle { tree, filter, any, every, limit }.trace::<S>(bundle, scratch, counts)
            },
        );
        if let Outcome::Traced { left, .. } = outcome {
            let (at, rays) = (rays.at, rays.rays);
            let output = output.part(at, at + rays.len());
            write_bundle::<S>(chunk, (rays, RayId(at as u32), left), results, output);
        }
        outcome
    }

    /// Traces the packets in a mask, unless they are not coherent. If the mask has all packets, nothing
    /// is left of an earlier bundle.
    #[inline(always)]
    fn in_packets(
        &mut self,
        rays: BatchRays<'_>,
        packets: u64,
        output: &mut BatchOutput<'_>,
        counts: &mut Counts,
    ) -> Outcome {
        if packets == u64::MAX {
            self.projection.has_outliers = false;
        }
        let all = &mut self.packets;
        S::vectorize(
            #[inline(always)]
            || all.trace::<S>((rays.rays, rays.at), packets, output, counts),
        )
    }
}

/// Writes the results of a bundle. The packets in `left` have not been traced yet.
#[inline(always)]
fn write_bundle<S: Simd>(
    chunk: &Chunk<'_>,
    (rays, first, left): (&[Ray], RayId, u64),
    results: &mut Results,
    output: BatchOutput<'_>,
) {
    let (tree, resolver) = (chunk.tree, chunk.filter.resolver());
    S::vectorize(
        #[inline(always)]
        || match output {
            BatchOutput::Pairs(pairs) => {
                results.list::<S>(tree, resolver, (rays, first, left), pairs);
            }
            output => results.write::<S>(tree, resolver, (rays, first), output),
        },
    );
}

/// Returns whether a bundle was worth its cost: at least half of its rays were traced, and tracing
/// them did not take too much work.
#[inline(always)]
fn pays(outcome: &Outcome, rays: &[Ray]) -> bool {
    matches!(*outcome, Outcome::Traced { left, work }
        if 32 * left.count_ones() as usize <= rays.len() && work <= EXPENSIVE * rays.len())
}

/// Returns the size of the next bundle. It grows again at positions where a larger bundle would
/// begin.
fn next_size(mut size: usize, at: usize, is_busy: bool) -> usize {
    let most = if is_busy { BUSY_RAYS } else { RAYS };
    while size < most && at.is_multiple_of(4 * size) {
        size *= 4;
    }
    size.min(most)
}
