//! Helpers that the tests share: comparing pairs with rational arithmetic, generating scenes from
//! the families of `intertri-lab`, and checking the families on all threads.

pub(crate) mod compare;

use std::sync::atomic::{AtomicUsize, Ordering};

use intertri_lab::families::{FAMILIES, Family};
use intertri_lab::rng::Rng;
use intertri_tests::Scene;

/// Generates a scene from a family, with at most `triangles` triangles and `rays` rays.
pub(crate) fn scene(family: &Family, rng: &mut Rng, triangles: usize, rays: usize) -> Scene {
    let scene = family.scene(rng, triangles, rays);
    Scene { triangles: scene.triangles, rays: scene.rays, threshold: scene.threshold }
}

/// Calls a function with each family and its index, on all threads. Each thread takes the next
/// remaining family. Returns the results in arbitrary order.
pub(crate) fn each_family<T: Send>(ask: impl Fn(usize, &Family) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let work = || {
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        numbers.map_while(|i| Some(ask(i, FAMILIES.get(i)?))).collect::<Vec<_>>()
    };
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|w| w.join().expect("no worker panics")).collect()
    })
}
