//! One ray through the hierarchy, front to back.

use intertri::lanes::{Lanes, Simd};
use intertri::{Best, Counts, Mode, PreparedRay, Ray};

use crate::bvh::Bvh;
use crate::node::LEAF;
use crate::slab::{SlabLanes, Slabs};

/// Children that are still to be visited, the nearest on top, each with the t of its box.
pub(crate) type Stack = Vec<(u32, f32)>;

/// Visits the packs of triangles that a ray may hit before `far()`, roughly front to back, until
/// `visit` says stop. `visit` gets the pack's index and gives the new far end, or `None` to stop.
#[inline(always)]
fn walk<S: Simd>(
    bvh: &Bvh,
    ray: &Ray,
    stack: &mut Stack,
    mut far: f32,
    mut visit: impl FnMut(usize) -> Option<f32>,
) {
    // What no box can hold is asked of every ray, and a ray that no box can be held against asks
    // everything. A ray that is not finite hits nothing.
    let slabs = Slabs::new(ray, bvh.reach);
    let unboxed = if slabs.is_some() { bvh.boxed..bvh.packs.len() } else { 0..bvh.packs.len() };
    let finite = ray.origin.iter().chain(&ray.dir).all(|x| x.is_finite());
    if !finite {
        return;
    }
    for pack in unboxed {
        match visit(pack) {
            Some(nearer) => far = nearer,
            None => return,
        }
    }
    let Some(slabs) = slabs else { return };

    let lanes = SlabLanes::<S::F32x8>::splat(&slabs);
    let octant = usize::from(slabs.octant);
    stack.clear();
    let mut child = 0;
    loop {
        if child & LEAF == 0 {
            // A node: its boxes that the ray meets go onto the stack, the nearest last.
            let node = &bvh.nodes[child as usize];
            let (met, near) = lanes.meet(node, ray.t_min, far);
            if met != 0 {
                let mut t = [0.0; 8];
                near.store(&mut t);
                let mut order = mirror(met, octant);
                while order != 0 {
                    let last = 31 - order.leading_zeros();
                    order ^= 1 << last;
                    let slot = last as usize ^ octant;
                    stack.push((node.child[slot], t[slot]));
                }
            }
        } else {
            match visit((child ^ LEAF) as usize) {
                Some(nearer) => far = nearer,
                None => return,
            }
        }

        // The next one that still begins before the best hit.
        child = loop {
            match stack.pop() {
                None => return,
                Some((child, t)) if t <= far => break child,
                Some(_) => {}
            }
        };
    }
}

/// Bit i of the result is bit `i ^ octant` of an eight-bit mask.
#[inline(always)]
fn mirror(mask: u32, octant: usize) -> u32 {
    let swap = |m: u32, keep: u32, by: u32| (m & keep) << by | m >> by & keep;
    let m = if octant & 1 != 0 { swap(mask, 0x55, 1) } else { mask };
    let m = if octant & 2 != 0 { swap(m, 0x33, 2) } else { m };
    if octant & 4 != 0 { swap(m, 0x0f, 4) } else { m }
}

/// The closest hit of a ray.
#[inline(always)]
pub(crate) fn closest<M: Mode, S: Simd>(
    bvh: &Bvh,
    mode: &M,
    ray: &Ray,
    stack: &mut Stack,
    counts: &mut Counts,
) -> Best {
    let prepared: PreparedRay<M, S> = mode.prepare_ray_in(ray);
    let mut best = Best::new(ray.t_max);
    walk::<S>(bvh, ray, stack, ray.t_max, |pack| {
        let find = |place| bvh.triangle_in(place);
        let (triangles, indices) = (&bvh.packs[pack], &bvh.indices[pack]);
        let place = 8 * pack as u32;
        mode.closest_in(&prepared, triangles, indices, place, find, &mut best, counts);
        Some(best.t_hi())
    });
    best
}

/// Whether a ray hits anything.
#[inline(always)]
pub(crate) fn any<M: Mode, S: Simd>(
    bvh: &Bvh,
    mode: &M,
    ray: &Ray,
    stack: &mut Stack,
    counts: &mut Counts,
) -> bool {
    let prepared: PreparedRay<M, S> = mode.prepare_ray_in(ray);
    let mut found = false;
    walk::<S>(bvh, ray, stack, ray.t_max, |pack| {
        found = mode.any_in(&prepared, &bvh.packs[pack], counts);
        (!found).then_some(ray.t_max)
    });
    found
}

/// The places of all hits of a ray with their t, in the order in which the walk finds them.
#[inline(always)]
pub(crate) fn all<M: Mode, S: Simd>(
    bvh: &Bvh,
    mode: &M,
    ray: &Ray,
    stack: &mut Stack,
    mut each: impl FnMut(u32, f64),
) {
    walk::<S>(bvh, ray, stack, ray.t_max, |pack| {
        let hits = mode.pack_in::<S, 8>(ray, &bvh.packs[pack], &mut Counts::default());
        for lane in (0..8).filter(|lane| hits.bits >> lane & 1 != 0) {
            each(8 * pack as u32 + lane, hits.t[lane as usize]);
        }
        Some(ray.t_max)
    });
}

#[cfg(test)]
mod tests {
    use super::mirror;

    #[test]
    fn a_mirrored_mask_lists_the_slots_of_an_octant() {
        for octant in 0..8 {
            for mask in 0..256 {
                let want = (0..8).fold(0, |m, i| m | (mask >> (i ^ octant) & 1) << i);
                assert_eq!(mirror(mask, octant as usize), want);
            }
        }
    }
}
