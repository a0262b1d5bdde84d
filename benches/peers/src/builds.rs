//! Measures how long the hierarchies take to build and how much memory they need. Each builder runs
//! in its own process, so that memory freed by one is not reused by the next.

use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

use intertri::{Triangle, Triangle64, TriangleOf};
use intertri_scene::Mesh;
use intertri_trace::Bvh;
use obvhs::BvhBuildParams;
use rayon::ThreadPool;

use crate::bvh::TwoWay;
use crate::embree::{Api, Build, Scene};
use crate::instances::resident;
use crate::obvhs::Obvhs;
use crate::parry::Parry;
#[cfg(feature = "tinybvh")]
use crate::tinybvh::TinyBvh;

/// The names of the builders.
pub const BUILDERS: &[&str] = &[
    "intertri",
    "intertri, f64",
    "embree, default",
    "embree, robust",
    "embree, high quality",
    #[cfg(feature = "tinybvh")]
    "tinybvh",
    "obvhs, medium",
    "obvhs, slow",
    "bvh",
    "parry",
];

/// What a builder needs.
pub struct Built {
    /// The time of the fastest build.
    pub milliseconds: f64,
    /// By how much the resident memory grew during the first build.
    pub bytes: usize,
}

/// Runs a builder in its own process. Returns `None` if it is not available.
pub fn in_own_process(builder: &str, scene: &str, args: &[String]) -> Option<Built> {
    let program = std::env::current_exe().ok()?;
    let mut command = Command::new(program);
    command.args(["builds", "--scene", scene, "--only", builder]).args(args);
    let output = command.stderr(Stdio::inherit()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut numbers = text.lines().last()?.split(' ');
    let (milliseconds, bytes) = (numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?);
    Some(Built { milliseconds, bytes })
}

/// Measures a builder, in this process. Returns `None` if it is not available.
pub fn measure(
    builder: &str,
    mesh: &Mesh,
    triangles: &[Triangle],
    api: Option<&Arc<Api>>,
    pool: &ThreadPool,
) -> Option<Built> {
    let repeats = if triangles.len() > 300_000 { 5 } else { 25 };
    let threads = pool.current_num_threads() as u32;
    let embree = |robust, high| {
        let api = api?;
        let ready =
            || Scene::new(api, mesh, Build { robust, high, avx2: false, threads, collect: false });
        let commit = |scene: Result<Scene, String>| {
            let scene = scene.ok()?;
            scene.commit();
            Some(scene)
        };
        Some(fastest(repeats, ready, commit))
    };
    let of = |params| fastest(repeats, || (), |()| Obvhs::new(triangles, true, params));
    pool.install(|| match builder {
        "intertri" => Some(fastest(repeats, || (), |()| Bvh::new(triangles))),
        "intertri, f64" => {
            let widened = |t: &Triangle| TriangleOf(t.0.map(|corner| corner.map(f64::from)));
            let in_f64: Vec<Triangle64> = triangles.iter().map(widened).collect();
            Some(fastest(repeats, || (), |()| Bvh::<f64>::new(&in_f64)))
        }
        "embree, default" => embree(false, false),
        "embree, robust" => embree(true, false),
        "embree, high quality" => embree(false, true),
        #[cfg(feature = "tinybvh")]
        "tinybvh" => Some(fastest(repeats, || (), |()| TinyBvh::new(triangles))),
        "obvhs, medium" => Some(of(BvhBuildParams::medium_build())),
        "obvhs, slow" => Some(of(BvhBuildParams::slow_build())),
        "bvh" => Some(fastest(repeats, || (), |()| TwoWay::new(triangles))),
        "parry" => Some(fastest(repeats, || (), |()| Parry::new(&mesh.positions, &mesh.triangles))),
        _ => None,
    })
}

/// Builds several times. Times exclude preparing the input and dropping the result.
fn fastest<T, R>(repeats: usize, ready: impl Fn() -> T, build: impl Fn(T) -> R) -> Built {
    let before = resident();
    let first = build(ready());
    let bytes = resident().saturating_sub(before);
    drop(first);
    let once = |_| {
        let given = ready();
        let start = Instant::now();
        let _built = build(given);
        start.elapsed().as_secs_f64() * 1e3
    };
    let milliseconds = (0..repeats).map(once).fold(f64::INFINITY, f64::min);
    Built { milliseconds, bytes }
}
