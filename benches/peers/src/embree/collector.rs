//! Collects every hit of a ray, using a filter that rejects each hit.

use super::{Context, Ptr};
use crate::lists::ListedHit;

/// The hits that the filter collects, separately for each ray.
#[derive(Default)]
pub struct Collector([Vec<ListedHit>; 16]);

impl Collector {
    /// Returns the hits of the first `rays` rays.
    pub fn taken(&mut self, rays: usize) -> &mut [Vec<ListedHit>] {
        &mut self.0[..rays]
    }
}

/// `RTCFilterFunctionNArguments`.
#[repr(C)]
pub(super) struct FilterArguments {
    valid: *mut i32,
    user: Ptr,
    context: *mut Context,
    ray: *const u32,
    hit: *const u32,
    count: u32,
}

/// Collects hits and rejects them, so that traversal continues.
pub(super) unsafe extern "C" fn collect(arguments: *const FilterArguments) {
    // SAFETY: the structures have the layout that Embree's manual specifies, with rows of `count`
    // elements each; the context is the one that the caller passed, and its collector outlives the
    // call.
    unsafe {
        let FilterArguments { valid, context, ray, hit, count, .. } = *arguments;
        let collector = &mut *(*context).collector.cast::<Collector>();
        let count = count as usize;
        for lane in 0..count {
            if *valid.add(lane) != -1 {
                continue;
            }
            let (ray, hit) = (ray.add(lane), hit.add(lane));
            let [t, id] = [8, 10].map(|row| *ray.add(row * count));
            let [u, v, triangle] = [3, 4, 5].map(|row| *hit.add(row * count));
            let [t, u, v] = [t, u, v].map(f32::from_bits);
            collector.0[id as usize % 16].push(ListedHit { t, triangle, u, v });
            *valid.add(lane) = 0;
        }
    }
}
