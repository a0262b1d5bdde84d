//! Helpers that the tests share: comparing pairs with rational arithmetic, generating scenes from
//! the families of `intertri-lab`, and checking the families on all threads.

pub(crate) mod compare;

use std::sync::atomic::{AtomicUsize, Ordering};

use intertri::simd::Level;
use intertri_lab::families::{FAMILIES, Family};
use intertri_lab::rng::Rng;
use intertri_tests::{Scene, as_source, check_hierarchy};

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

/// Checks the queries of a hierarchy in `each` scenes per family, from one triangle to a few hundred,
/// after `change` has replaced their rays. Scenes take turns among the SIMD levels.
pub(crate) fn check_scenes(
    each: usize,
    seed: u64,
    change: impl Fn(usize, &mut Scene, &mut Rng) + Sync,
) {
    let levels: Vec<Level> = Level::all().collect();
    each_family(|_, family| {
        let mut rng = Rng::new(seed);
        for i in 0..each {
            let size = [1, 3, 8, 20, 60, 150, 400][i % 7];
            let mut scene = scene(family, &mut rng, size, 8);
            change(i, &mut scene, &mut rng);
            let level = &levels[i % levels.len()..][..1];
            if let Err(difference) = check_hierarchy(&scene, level) {
                let small =
                    if scene.triangles.len() < 20 { as_source(&scene) } else { String::new() };
                panic!("{} (seed {seed}, scene {i}): {difference}\n{small}", family.name);
            }
        }
    });
}
