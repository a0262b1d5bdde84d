//! Measures how long the hierarchies take to build.

use std::sync::Arc;
use std::time::Instant;

use intertri::{Triangle, Triangle64, TriangleOf};
use intertri_scene::Mesh;
use intertri_trace::Bvh;
use obvhs::BvhBuildParams;
use rayon::ThreadPool;

use crate::bvh::TwoWay;
use crate::embree::{Api, Build, Scene};
use crate::obvhs::Obvhs;
use crate::parry::Parry;

/// Returns the name of each builder with its median time in milliseconds.
pub fn builds(
    mesh: &Mesh,
    triangles: &[Triangle],
    api: Option<&Arc<Api>>,
    pool: &ThreadPool,
) -> Vec<(&'static str, f64)> {
    let repeats = if triangles.len() > 300_000 { 3 } else { 9 };
    // The times exclude preparing the input and dropping the result.
    fn middle<T, R>(repeats: usize, ready: impl Fn() -> T, build: impl Fn(&T) -> R) -> f64 {
        let once = |_| {
            let given = ready();
            let start = Instant::now();
            let _built = build(&given);
            start.elapsed().as_secs_f64() * 1e3
        };
        let mut times: Vec<f64> = (0..repeats).map(once).collect();
        times.sort_by(f64::total_cmp);
        times[repeats / 2]
    }

    let in_f64: Vec<Triangle64> =
        triangles.iter().map(|t| TriangleOf(t.0.map(|corner| corner.map(f64::from)))).collect();
    let mut all = pool.install(|| {
        vec![
            ("intertri", middle(repeats, || (), |()| Bvh::new(triangles))),
            ("intertri, f64", middle(repeats, || (), |()| Bvh::<f64>::new(&in_f64))),
        ]
    });
    if let Some(api) = api {
        let threads = pool.current_num_threads() as u32;
        for (name, robust, high) in [
            ("embree, default", false, false),
            ("embree, robust", true, false),
            ("embree, high quality", false, true),
        ] {
            let ready = || {
                Scene::new(api, mesh, Build { robust, high, avx2: false, threads, collect: false })
            };
            let build = |scene: &Result<Scene, String>| scene.as_ref().map(Scene::commit).is_ok();
            all.push((name, middle(repeats, ready, build)));
        }
    }
    pool.install(|| {
        let obvhs = |params| middle(repeats, || (), |()| Obvhs::new(triangles, true, params));
        all.push(("obvhs, medium", obvhs(BvhBuildParams::medium_build())));
        all.push(("obvhs, slow", obvhs(BvhBuildParams::slow_build())));
        all.push(("bvh", middle(repeats, || (), |()| TwoWay::new(triangles))));
        all.push((
            "parry",
            middle(repeats, || (), |()| Parry::new(&mesh.positions, &mesh.triangles)),
        ));
    });
    all
}
