use core::cmp::Ordering;

use super::{ClosestHit, LanePairs};
use crate::exact::PairDecision;
use crate::resolve::Resolver;
use crate::{LeafSlot, Ray, RayId, Triangle, TriangleId};

fn names(i: u32) -> (TriangleId, LeafSlot) {
    (TriangleId(i), LeafSlot(i))
}

/// The far end of a ray, and the t of each of its hits. The slot of a hit is its index.
struct FixedHits(f32, Vec<f64>);

impl LanePairs for FixedHits {
    fn resolver(&self) -> Resolver<'_> {
        Resolver::Document(0.0)
    }
    fn ray(&self, _: usize) -> Ray {
        Ray::new([0.0; 3], [0.0; 3])
    }
    fn triangle(&self, _: usize) -> Triangle {
        Triangle([[0.0; 3]; 3])
    }
    fn ids(&self, _: usize) -> (RayId, LeafSlot) {
        (RayId(0), LeafSlot(0))
    }
    fn find(&self, _: LeafSlot) -> Triangle {
        Triangle([[0.0; 3]; 3])
    }
    fn decide(&self, lane: usize) -> PairDecision {
        let t = Some(self.1[lane]).filter(|&t| t < f64::from(self.0));
        t.map_or(PairDecision::Miss, PairDecision::HitAt)
    }
    fn t(&self, lane: usize) -> f64 {
        self.1[lane]
    }
    fn t_in(&self, _: usize, slot: LeafSlot) -> f64 {
        self.1[slot.0 as usize]
    }
    fn order(&self, _: usize, _: LeafSlot) -> Ordering {
        Ordering::Equal
    }
    fn order_by_coordinates(&self, _: usize, _: LeafSlot) -> Option<Ordering> {
        None
    }
    fn known_order(&self, _: usize, _: LeafSlot) -> Option<Ordering> {
        None
    }
    fn shares_feature(&self, _: usize, _: (LeafSlot, u8), _: LeafSlot) -> bool {
        false
    }
}

#[test]
fn the_lower_index_wins_a_tie_in_any_order() {
    let t = [2.0, 1.0, 1.0, 1.0 + 1e-12];
    let pairs = FixedHits(f32::INFINITY, t.to_vec());
    for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1], [1, 3, 0, 2]] {
        let mut closest = ClosestHit::new(f32::INFINITY);
        for i in order {
            let wide = (t[i as usize] as f32 - 0.1, t[i as usize] as f32 + 0.1);
            closest.offer_near(wide, names(i), i as usize, &pairs);
        }
        assert_eq!(closest.triangle(), Some(names(1)), "{order:?}");
    }
}

/// Pairs about which this is decided. All meet at a corner that they share.
struct Decided(PairDecision, FixedHits);

impl LanePairs for Decided {
    fn resolver(&self) -> Resolver<'_> {
        self.1.resolver()
    }
    fn ray(&self, lane: usize) -> Ray {
        self.1.ray(lane)
    }
    fn triangle(&self, lane: usize) -> Triangle {
        self.1.triangle(lane)
    }
    fn ids(&self, lane: usize) -> (RayId, LeafSlot) {
        self.1.ids(lane)
    }
    fn find(&self, slot: LeafSlot) -> Triangle {
        self.1.find(slot)
    }
    fn decide(&self, _: usize) -> PairDecision {
        self.0
    }
    fn shares_feature(&self, _: usize, _: (LeafSlot, u8), _: LeafSlot) -> bool {
        true
    }
    fn t(&self, lane: usize) -> f64 {
        self.1.t(lane)
    }
}

/// The traversal leaves out boxes beyond `t_hi`, so the first hit must always bound it.
#[test]
fn the_first_hit_bounds_t() {
    let mut closest = ClosestHit::new(f32::INFINITY);
    let hits = FixedHits(f32::INFINITY, vec![2.0]);
    let pairs = Decided(PairDecision::HIT_ANYWHERE, hits);
    closest.offer_undecided(names(0), 0, &pairs);
    assert_eq!((closest.triangle(), closest.t_hi()), (Some(names(0)), 2.0));
}

/// Three triangles that share the corner at which the ray meets them. Their t is not known.
#[test]
fn at_a_shared_corner_the_lower_index_wins_without_t() {
    let hit = PairDecision::Hit { t_lo: 0.9, t_hi: 1.1, edges: 0b011 };
    let (pairs, mut closest) = (Decided(hit, FixedHits(9.0, vec![])), ClosestHit::new(9.0));
    for i in [2, 1, 4] {
        closest.offer_decided(hit, names(i), i as usize, &pairs);
    }
    assert_eq!((closest.triangle(), closest.t_hi()), (Some(names(1)), 1.1));
}

/// Also triangles so thin that f64 cannot bound t.
#[test]
fn at_a_shared_corner_the_lower_index_wins_without_bounds() {
    let near = PairDecision::Hit { t_lo: 0.9, t_hi: 1.1, edges: 0b011 };
    let anywhere = PairDecision::Hit { t_lo: 0.0, t_hi: f32::INFINITY, edges: 0b011 };
    for (first, then) in [(near, anywhere), (anywhere, near), (anywhere, anywhere)] {
        let pairs = Decided(then, FixedHits(9.0, vec![1.0; 3]));
        let mut closest = ClosestHit::new(9.0);
        closest.offer_decided(first, names(1), 1, &pairs);
        for i in [2, 0] {
            closest.offer_decided(then, names(i), i as usize, &pairs);
        }
        assert_eq!(closest.triangle(), Some(names(0)));
        assert!(closest.t_hi() >= 1.0 && closest.t_hi() <= 1.1);
    }
}

#[test]
fn the_far_end_is_open() {
    let mut closest = ClosestHit::new(1.0);
    closest.offer_near((0.9, 1.1), names(0), 0, &FixedHits(1.0, vec![1.0]));
    assert_eq!(closest.triangle(), None);
    closest.offer_near((0.9, 1.1), names(0), 0, &FixedHits(1.0, vec![1.0 - 1e-12]));
    assert_eq!(closest.triangle(), Some(names(0)));
}
