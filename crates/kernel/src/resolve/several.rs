//! Settles several undecided pairs side by side: the triangles of a leaf, or the rays of a packet.

use super::Resolver;
use crate::document::Tri;
use crate::exact::{EightPairs, PairDecision, Rule, Side};
use crate::simd::{Lanes, Level, Mask, Simd, WithSimd, lanes_of};
use crate::{LeafSlot, Ray, RayId, Triangle};

/// The number of undecided pairs from which it is faster to decide them side by side.
pub(crate) const SEVERAL: u32 = 3;

/// The ray and the triangle in a lane, and their ids.
type Pair = (Ray, Triangle, (RayId, LeafSlot));

impl Resolver<'_> {
    /// Decides the pairs in up to sixteen lanes like [`Resolver::decide`], but several of them side
    /// by side. The other lanes are misses.
    #[cold]
    #[inline(never)]
    pub fn decide_lanes(self, lanes: u32, pair: impl Fn(usize) -> Pair) -> [PairDecision; 16] {
        let mut decisions = [PairDecision::Miss; 16];
        let rule = match self {
            Self::Document(_) => Rule::Closed,
            Self::Exact(rule) => rule,
            Self::Originals(originals) => originals.rule(),
        };
        self.decide_each(
            (rule, lanes),
            &pair,
            #[inline(always)]
            |lane, decision| {
                // Copy whole decisions: to read one back right after its fields were written is slow.
                if let Some(decision) = decision {
                    decisions[lane] = *decision;
                } else {
                    let (ray, triangle, ids) = pair(lane);
                    decisions[lane] = self.decide(&ray, &triangle, ids);
                }
            },
        );
        decisions
    }

    /// Decides the pairs in up to sixteen lanes under a rule, if there are several, and passes on the
    /// decision about each, or `None` if it must be decided alone. The document has no rule.
    #[inline(always)]
    fn decide_each(
        self,
        (rule, lanes): (Rule, u32),
        pair: &impl Fn(usize) -> Pair,
        mut pass: impl FnMut(usize, Option<&PairDecision>),
    ) {
        if lanes.count_ones() < SEVERAL {
            return lanes_of(lanes).for_each(|lane| pass(lane, None));
        }
        let mut rest = lanes;
        while rest != 0 {
            let (mut eight, mut count) = ([0; 8], 0);
            for lane in lanes_of(rest).take(8) {
                eight[count] = lane;
                count += 1;
                rest &= rest - 1;
            }
            let eight = &eight[..count];
            let decisions = match self {
                Self::Document(threshold) => by_document(threshold, eight, pair),
                // Decisions hardly depend on the level, and answers do not depend on it.
                Self::Exact(_) => eight_pairs(eight, pair).decide(Level::best(), rule),
                Self::Originals(originals) => {
                    let mut ids = [(RayId(0), LeafSlot(0)); 8];
                    for (ids, &lane) in ids.iter_mut().zip(eight) {
                        *ids = pair(lane).2;
                    }
                    originals.decide_eight(rule, &ids[..count])
                }
            };
            for (&lane, decision) in eight.iter().zip(&decisions) {
                pass(lane, decision.as_ref());
            }
        }
    }

    /// Returns the lanes whose rays hit their triangles within the interval.
    #[inline(always)]
    pub fn meeting(self, lanes: u32, pair: impl Fn(usize) -> Pair) -> u32 {
        let decisions = self.decide_lanes(lanes, pair);
        (0..16).map(|lane| u32::from(decisions[lane] != PairDecision::Miss) << lane).sum()
    }

    /// Returns the lanes whose rays cross their triangles under the *once* rule, as in
    /// [`Resolver::crossing`], and among these the lanes in which the ray leaves.
    #[cold]
    #[inline(never)]
    pub fn crossings(self, lanes: u32, pair: impl Fn(usize) -> Pair) -> [u32; 2] {
        let [mut crossed, mut leaving] = [0; 2];
        // The document has no rule for shared edges, so its modes also count crossings by exact signs.
        let exact = if let Self::Document(_) = self { Self::Exact(Rule::Once) } else { self };
        exact.decide_each((Rule::Once, lanes), &pair, |lane, decision| {
            let (ray, triangle, ids) = pair(lane);
            let side = match decision {
                Some(PairDecision::Miss) => None,
                Some(_) => self.facing(&ray, &triangle, ids),
                None => self.crossing(&ray, &triangle, ids),
            };
            crossed |= u32::from(side.is_some()) << lane;
            leaving |= u32::from(side == Some(Side::Leaves)) << lane;
        });
        [crossed, leaving]
    }
}

/// Gathers the pairs in up to eight lanes.
#[inline(always)]
fn eight_pairs(lanes: &[usize], pair: &impl Fn(usize) -> Pair) -> EightPairs<f32> {
    let mut pairs = EightPairs::new();
    for (i, &lane) in lanes.iter().enumerate() {
        let (ray, triangle, _) = pair(lane);
        pairs.set(i, &ray, &triangle);
    }
    pairs
}

/// Tests the pairs in up to eight lanes with the operations of document A.
#[inline(always)]
fn by_document(
    threshold: f64,
    lanes: &[usize],
    pair: &impl Fn(usize) -> Pair,
) -> [Option<PairDecision>; 8] {
    Level::best().run(ByDocument { pairs: &eight_pairs(lanes, pair), threshold })
}

/// Eight pairs to be tested with the operations of document A.
struct ByDocument<'a> {
    pairs: &'a EightPairs<f32>,
    threshold: f64,
}

impl WithSimd for ByDocument<'_> {
    type Output = [Option<PairDecision>; 8];

    #[inline(always)]
    fn run<S: Simd>(self) -> [Option<PairDecision>; 8] {
        let (corners, rays) = self.pairs.lanes_in::<S>();
        let (hit, t) = Tri::new(corners).hit(&rays, self.threshold);
        let (hit, mut lanes) = (hit.bits(), [0.0; 8]);
        t.store(&mut lanes);
        let mut decisions = [Some(PairDecision::Miss); 8];
        for (lane, decision) in decisions.iter_mut().enumerate() {
            if hit >> lane & 1 != 0 {
                *decision = Some(PairDecision::HitAt(lanes[lane]));
            }
        }
        decisions
    }
}

#[cfg(test)]
mod tests {
    use super::ByDocument;
    use crate::exact::test_numbers::random;
    use crate::exact::{EightPairs, PairDecision};
    use crate::simd::Level;
    use crate::{Ray, Triangle, document};

    /// Tests pairs on a small grid, so that many rays meet edges, start or end on a triangle, run
    /// parallel to it, or have no direction, and pairs with numbers that are not finite.
    #[test]
    fn lanes_say_what_the_scalar_document_says() {
        let (mut random, mut hits) = (random(), 0);
        for i in 0..20_000 {
            let threshold = [0.0, 1e-6, 0.5][i % 3];
            let (mut pairs, mut each) = (EightPairs::new(), Vec::new());
            for lane in 0..8 {
                let mut vec3 = || [0; 3].map(|_| (4.0 * random()).round() as f32);
                let mut triangle = Triangle([vec3(), vec3(), vec3()]);
                let mut ray = Ray::new(vec3(), vec3());
                match (i + lane) % 8 {
                    0 => ray = ray.between(1.0, 2.0),
                    1 => ray = ray.between(0.0, 1.0),
                    2 => ray.dir[lane % 3] = [f32::NAN, f32::INFINITY][i % 2],
                    3 => triangle.0[i % 3][lane % 3] = [f32::NAN, f32::INFINITY][i % 2],
                    _ => {}
                }
                pairs.set(lane, &ray, &triangle);
                each.push((ray, triangle));
            }
            for level in Level::all() {
                let decisions = level.run(ByDocument { pairs: &pairs, threshold });
                for ((ray, triangle), decision) in each.iter().zip(decisions) {
                    let hit = document::hit(ray, triangle, threshold);
                    let expected = hit.map_or(PairDecision::Miss, PairDecision::HitAt);
                    assert_eq!(decision, Some(expected), "{threshold} {ray:?} {triangle:?}");
                    hits += usize::from(hit.is_some());
                }
            }
        }
        assert!(hits > 2000, "{hits}");
    }
}
