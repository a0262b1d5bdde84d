//! Lists the engines by name, and builds them for a scene.

use std::collections::HashMap;
use std::sync::Arc;

use intertri::simd::Level;
use intertri::{Mode, Threshold, Triangle, Triangle64, TriangleOf};
use intertri_trace::Bvh;
use obvhs::BvhBuildParams;

use crate::bvh::TwoWay;
use crate::doubles::{self, Widened};
use crate::embree::{Api, Build, Embree, Scene};
use crate::engine::Engine;
use crate::fixed::Fixed;
use crate::measure::Named;
use crate::obvhs::Obvhs;
use crate::ours::{Batch, InF32, Kept, Returned, Single, Triangles};
use crate::parry::Parry;

/// All engines, each with a short description.
pub const ENGINES: [(&str, &str); 47] = [
    ("certified", "batch calls, with the CPU's best instructions"),
    ("certified-f32", "batch calls with t, u, v in f32"),
    ("certified-f32-avx2", ""),
    ("certified-triangles", "batch calls for the triangle alone"),
    ("certified-avx2", "batch calls, limited to AVX2"),
    ("certified-triangles-avx2", ""),
    ("certified-single", "one ray per call"),
    ("certified-query", "one ray per call, through a reused query"),
    ("certified-query-avx2", ""),
    ("certified-zero", "batch calls with a Threshold of 0, so answers may differ"),
    ("certified-zero-triangles", ""),
    ("exact", "batch calls"),
    ("exact-f32", "batch calls with t, u, v in f32"),
    ("exact-f32-avx2", ""),
    ("exact-triangles", "batch calls for the triangle alone"),
    ("exact-avx2", "batch calls, limited to AVX2"),
    ("exact-triangles-avx2", ""),
    ("exact-single", "one ray per call"),
    ("exact-query", "one ray per call, through a reused query"),
    ("exact-query-avx2", ""),
    ("exact-query-f32", "one ray per call, through a reused query, with t, u, v in f32"),
    ("exact-query-triangles", "one ray per call, through a reused query, for the triangle alone"),
    ("exact-query-triangles-avx2", ""),
    ("fixed", "batch calls, including the time to snap to the grid, which changes answers"),
    ("embree-fast-1", "one ray per call; default build"),
    ("embree-fast-8", "8 rays per call"),
    ("embree-fast-16", "16 rays per call"),
    ("embree-robust-1", "the scene's robust flag"),
    ("embree-robust-8", ""),
    ("embree-robust-16", ""),
    ("embree-high-1", "fast; high-quality build"),
    ("embree-high-8", ""),
    ("embree-high-16", ""),
    ("embree-avx2-1", "fast; limited to AVX2"),
    ("embree-avx2-8", ""),
    ("embree-avx2-robust-8", "robust; limited to AVX2"),
    ("obvhs-2", "two-way hierarchy, slow build"),
    ("obvhs-8", "compressed eight-way hierarchy, slow build"),
    ("tinybvh", "BVH8_CPU, one ray per call; only with the `tinybvh` feature"),
    ("bvh", "two-way hierarchy"),
    ("bvh-f64", "two-way hierarchy in f64, with the scene and the rays widened"),
    ("parry", "triangle mesh"),
    ("parry-f64", "triangle mesh in f64"),
    ("tinybvh-f64", "BVH_Double; this and the engines below are built by `programs/build`"),
    ("libigl", "its tree in f64, through Python, one call for all rays"),
    ("cgal", "its tree, with exact constructions"),
    ("cgal-inexact", "its tree, with exact predicates and rounded constructions"),
];

/// Returns whether one of the filters selects a name. A filter is either a whole name, or the start
/// of a name up to a dash. If there are no filters, all names are selected.
pub fn wanted(name: &str, filters: &[String]) -> bool {
    wanted_of(name, filters, ENGINES.iter().map(|(name, _)| *name))
}

/// Like [`wanted`], but for another list of names.
pub fn wanted_of<'a>(
    name: &str,
    filters: &[String],
    names: impl Iterator<Item = &'a str> + Clone,
) -> bool {
    let meant = |filter: &String| match name.strip_prefix(filter.as_str()) {
        Some(rest) => rest.is_empty() || rest.starts_with('-'),
        None => false,
    };
    // A name that is also a prefix of others selects only itself.
    let whole = |filter: &String| names.clone().any(|name| name == filter) && filter != name;
    filters.is_empty() || filters.iter().any(|filter| meant(filter) && !whole(filter))
}

/// Boxes an engine. If it could not be built, prints the reason and returns `None`.
fn made<E: Engine + 'static>(name: &str, engine: Result<E, String>) -> Option<Box<dyn Engine>> {
    let engine = engine.inspect_err(|error| eprintln!("{name}: {error}")).ok()?;
    Some(Box::new(engine))
}

#[cfg(feature = "tinybvh")]
fn tinybvh(name: &str, triangles: &[Triangle]) -> Option<Box<dyn Engine>> {
    made(name, crate::tinybvh::TinyBvh::new(triangles))
}

#[cfg(not(feature = "tinybvh"))]
fn tinybvh(_: &str, _: &[Triangle]) -> Option<Box<dyn Engine>> {
    None
}

/// Returns an engine for a mode of intertri that uses the calls that `name` specifies.
fn ours(name: &str, bvh: &Arc<Bvh>, mode: Mode) -> Box<dyn Engine> {
    let bvh = bvh.clone();
    let has = |word| name.split('-').any(|part| part == word);
    match () {
        () if has("single") => Box::new(Single::new(bvh, mode)),
        () if has("query") => {
            let returned = match () {
                () if has("triangles") => Returned::Triangle,
                () if has("f32") => Returned::Hit32,
                () => Returned::Hit,
            };
            Box::new(Kept::new(bvh, mode, returned))
        }
        () if has("triangles") => Box::new(Triangles::new(bvh, mode)),
        () if has("f32") => Box::new(InF32::new(bvh, mode)),
        () => Box::new(Batch::new(bvh, mode)),
    }
}

/// Widens a triangle to f64.
pub fn in_f64(triangle: &Triangle) -> Triangle64 {
    TriangleOf(triangle.0.map(|corner| corner.map(f64::from)))
}

/// Returns the instruction level that `name` specifies, if this CPU supports it.
fn level(name: &str) -> Option<Level> {
    if name.ends_with("avx2") { Level::avx2() } else { Some(Level::best()) }
}

/// Builds the engines for a scene. Engines that cannot be built are reported and skipped.
pub fn engines(
    filters: &[String],
    scene: &intertri_scene::Scene,
    triangles: &[Triangle],
    bvh: &Arc<Bvh>,
    api: Option<&Arc<Api>>,
) -> Vec<Named> {
    let mesh = &scene.mesh;
    let mut scenes = HashMap::new();
    let mut engines: Vec<Named> = Vec::new();
    for (name, _) in ENGINES {
        if !wanted(name, filters) {
            continue;
        }
        let has = |word| name.split('-').any(|part| part == word);
        let engine: Option<Box<dyn Engine>> = match name {
            name if has("zero") => {
                let threshold = Threshold::new(0.0).expect("0 is a valid threshold");
                Some(ours(name, bvh, Mode::certified_with(threshold)))
            }
            name if has("certified") => {
                level(name).map(|level| ours(name, bvh, Mode::certified().at(level)))
            }
            name if has("exact") => {
                level(name).map(|level| ours(name, bvh, Mode::exact().at(level)))
            }
            "obvhs-2" | "obvhs-8" => {
                let wide = name == "obvhs-8";
                Some(Box::new(Obvhs::new(triangles, wide, BvhBuildParams::slow_build())))
            }
            "tinybvh" => tinybvh(name, triangles),
            "bvh" => Some(Box::new(TwoWay::new(triangles))),
            "parry" => made(name, Parry::new(&mesh.positions, &mesh.triangles)),
            "fixed" => made(name, Fixed::new(scene)),
            name if doubles::is(name) => {
                let triangles: Vec<Triangle64> = triangles.iter().map(in_f64).collect();
                doubles::engine(name, &triangles).map(|engine| Box::new(Widened(engine)) as _)
            }
            _ => api.and_then(|api| {
                let build = Build {
                    robust: has("robust"),
                    high: has("high"),
                    avx2: has("avx2"),
                    threads: 0,
                    collect: false,
                };
                let scene = scenes.entry(build).or_insert_with(|| {
                    let scene = Scene::new(api, mesh, build).inspect_err(|e| eprintln!("{e}"));
                    scene.ok().map(|scene| {
                        scene.commit();
                        Arc::new(scene)
                    })
                });
                let scene = scene.clone()?;
                Some(match name.rsplit('-').next() {
                    Some("1") => Box::new(Embree::<1>::new(scene)) as Box<dyn Engine>,
                    Some("8") => Box::new(Embree::<8>::new(scene)),
                    _ => Box::new(Embree::<16>::new(scene)),
                })
            }),
        };
        engines.extend(engine.map(|engine| (name.to_owned(), engine)));
    }
    engines
}
