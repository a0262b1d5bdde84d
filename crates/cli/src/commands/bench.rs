//! `intertri bench`: measures rays per second for each engine and kind of ray.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use intertri::fixed::Bits;
use intertri::{Hit, Ray, Threshold, Triangle, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_scene::{Rays, RaysFormat, Rounding, Scene, hit_point};

use crate::commands::options::{CameraOptions, rays_format};
use crate::engine::engines::Engines;
use crate::engine::memory::{filled, room};
use crate::engine::model::{Model, ModelOptions};
use crate::engine::name::EngineName;
use crate::engine::pixels::primary_rays;
use crate::engine::ray_engine::RayEngine;
use crate::engine::tracer::Tracer;
use crate::engine::triangles::triangles;
use crate::error::{Error, Result};
use crate::io::numbers;
use crate::io::progress::Progress;
use crate::report::bench::{BenchReport, Rate};
use crate::report::print::print;
use crate::report::rounding::Rounded;

/// The largest number of rays to measure from a file.
const MAX_RAYS: usize = 1 << 20;

/// The approximate number of ray/triangle tests per turn of the slow reference.
const REFERENCE_TESTS: usize = 20_000_000;

/// Measure how many million rays per second each engine traces, for each kind of ray
///
/// Primary rays come from the camera, tile by tile. Shadow rays run from the light to the points
/// that were hit, and look for any hit. Diffuse rays start at these points and leave the surface in
/// all directions. The engines take turns, on all threads, and the median over the turns is
/// reported. The scalar reference, which tests all triangles, traces fewer rays. All engines get
/// the same numbers: those that are not exact in f32 are rounded first and counted in the report.
/// Run this on a quiet machine.
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or a hierarchy saved by build [default: the built-in scene]
    model: Option<PathBuf>,

    /// The width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    size: (u32, u32),

    /// Also measure the first million rays of this file; see trace for its formats
    #[arg(long, value_name = "FILE")]
    rays: Option<PathBuf>,

    /// The format of that file [default: see trace]
    #[arg(long, value_name = "FORMAT", value_parser = rays_format(), requires = "rays")]
    rays_format: Option<RaysFormat>,

    /// The number of turns for each engine
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    turns: u32,

    #[command(flatten)]
    reading: ModelOptions,

    /// Print the report as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    camera: CameraOptions,
}

/// Rays of one kind.
struct Kind {
    name: &'static str,
    rays: Vec<Ray>,
    /// Whether these rays are for any-hit queries.
    any: bool,
}

/// Measures all engines.
pub(crate) fn run(options: &Options) -> Result<()> {
    let (width, height) = options.size;
    let model = options
        .model
        .as_deref()
        .map(|path| Model::load(path, options.reading)?.in_f32())
        .transpose()?;
    let (rounding, notes) =
        model.as_ref().map(|model| (model.rounding, model.notes.clone())).unwrap_or_default();
    let mut rounded = Rounded::of_model(rounding);
    let bvh = model.as_ref().and_then(|model| model.bvh.clone());
    let scene = options
        .camera
        .scene(model.map(|model| model.mesh), f64::from(width) / f64::from(height))?;
    let triangles = triangles(&scene.mesh)?;
    let mut engines = Engines::new(&triangles, Threshold::default()).with_bvh(bvh.clone());

    // Create the rays.
    let certified = engines.engine(EngineName::Certified)?;
    let mut kinds = kinds(&scene, &triangles, options.size, &certified)?;
    if let Some(path) = &options.rays {
        let rays;
        (rays, rounded.rays) = first_rays(path, options.rays_format)?;
        kinds.push(Kind { name: "file", rays, any: false });
    }
    kinds.retain(|kind| !kind.rays.is_empty());

    // The grid must contain all origins.
    let mut origins = room(kinds.iter().map(|kind| kind.rays.len()).sum(), "rays")?;
    origins.extend(kinds.iter().flat_map(|kind| kind.rays.iter().map(|ray| ray.origin)));
    let mut engines =
        Engines::new(&triangles, Threshold::default()).on_grid(Bits::FINE, origins).with_bvh(bvh);
    let names =
        [EngineName::Exact, EngineName::Certified, EngineName::Fixed, EngineName::Reference];
    let contenders: Vec<RayEngine> =
        names.into_iter().map(|name| engines.engine(name)).collect::<Result<_>>()?;

    let bar = Progress::new("bench", Some(kinds.len() as u64 * u64::from(options.turns + 1)));
    let mut rates = vec![];
    for kind in &kinds {
        rates.extend(measure(kind, &names, &contenders, triangles.len(), options.turns, &bar)?);
    }
    drop(bar);
    let report = BenchReport {
        model: options.model.clone(),
        notes,
        triangles: triangles.len(),
        threads: rayon::current_num_threads(),
        turns: options.turns,
        rounded,
        rates,
    };
    print(&report, options.json)
}

/// Reads at most [`MAX_RAYS`] rays from a file, and counts how many of their numbers were rounded
/// to f32.
fn first_rays(path: &Path, format: Option<RaysFormat>) -> Result<(Vec<Ray>, Rounding)> {
    let mut file = Rays::open(path, format)?;
    let (mut all, mut some): (Vec<Ray>, _) = (vec![], vec![]);
    while all.len() < MAX_RAYS {
        file.read(&mut some, MAX_RAYS - all.len())?;
        if some.is_empty() {
            break;
        }
        all.append(&mut some);
    }
    Ok((all, file.rounding()))
}

/// Creates camera rays, shadow rays to the points that the camera rays hit, and diffuse rays from
/// these points.
fn kinds(
    scene: &Scene,
    triangles: &[Triangle],
    size: (u32, u32),
    engine: &RayEngine,
) -> Result<Vec<Kind>> {
    let primary = primary_rays(&scene.camera, size)?;
    let mut hits = filled(primary.len(), Hit::MISS, "hits")?;
    engine.closest(&primary, &mut hits);

    let mut rng = Rng::new(1);
    let seen = hits.iter().filter(|hit| hit.is_hit()).count();
    let (mut shadow, mut diffuse) = (room(seen, "rays")?, room(seen, "rays")?);
    for (ray, hit) in primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let point = hit_point(ray, hit);
        shadow.push(scene.light.shadow_ray(point));
        let way = rng.direction();
        let normal = normal(&triangles[hit.triangle as usize]);
        let dot = |v: [f64; 3]| (0..3).map(|k| normal[k] * v[k]).sum::<f64>();
        // Leave the surface on the side that the camera sees, and start slightly above it.
        let side = if dot(way) * dot(ray.dir.map(f64::from)) > 0.0 { -1.0 } else { 1.0 };
        let dir = way.map(|x| (side * x) as f32);
        let near = (hit.t * 1e-4) as f32;
        diffuse.push(Ray::new(point.map(|x| x as f32), dir).between(near, f32::INFINITY));
    }
    Ok(vec![
        Kind { name: "primary", rays: primary, any: false },
        Kind { name: "shadow", rays: shadow, any: true },
        Kind { name: "diffuse", rays: diffuse, any: false },
    ])
}

/// Returns the normal of a triangle, not normalized.
fn normal(&TriangleOf([a, b, c]): &Triangle) -> [f64; 3] {
    let side = |p: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
    let ([x, y, z], [p, q, r]) = (side(b), side(c));
    [y * r - z * q, z * p - x * r, x * q - y * p]
}

/// Times all engines round-robin. Checks that the engines that follow document A return equal
/// answers.
fn measure(
    kind: &Kind,
    names: &[EngineName],
    contenders: &[RayEngine],
    triangles: usize,
    turns: u32,
    bar: &Progress,
) -> Result<Vec<Rate>> {
    let few = (REFERENCE_TESTS / triangles.max(1)).clamp(1, kind.rays.len());
    let rays_of = |name| match name {
        EngineName::Reference => &kind.rays[..few],
        _ => &kind.rays[..],
    };
    let mut seconds = vec![vec![]; names.len()];
    let mut answers = Vec::with_capacity(names.len());
    for &name in names {
        answers.push(Answers::of(rays_of(name).len(), kind.any)?);
    }
    // The first turn is only a warm-up.
    for turn in 0..=turns {
        for (k, engine) in contenders.iter().enumerate() {
            let rays = rays_of(names[k]);
            let start = Instant::now();
            answers[k].ask(engine, rays, kind.any);
            if turn > 0 {
                seconds[k].push(start.elapsed().as_secs_f64() / rays.len() as f64);
            }
        }
        bar.add(1);
    }

    let follows = |&k: &usize| !matches!(names[k], EngineName::Exact | EngineName::Fixed);
    let mut alike = (0..names.len()).filter(follows);
    if let Some(first) = alike.next()
        && let Some(other) = alike.find(|&k| !answers[k].start_as(&answers[first]))
    {
        return Err(Error::new(format!(
            "{} rays: engines {} and {} differ; please report that",
            kind.name, names[first], names[other]
        )));
    }
    let median = |seconds: &mut Vec<f64>| {
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    };
    let seconds: Vec<f64> = seconds.iter_mut().map(median).collect();
    let slow = seconds[names.len() - 1];
    let rate = |k: usize| Rate {
        rays: kind.name,
        engine: names[k],
        count: rays_of(names[k]).len(),
        million_a_second: 1e-6 / seconds[k],
        times_the_reference: slow / seconds[k],
        hits: answers[k].hits(),
    };
    Ok((0..names.len()).map(rate).collect())
}

/// The answers of an engine.
struct Answers {
    closest: Vec<Hit>,
    any: Vec<bool>,
}

impl Answers {
    /// Allocates memory for the answers to `rays` any-hit or closest-hit queries.
    fn of(rays: usize, any: bool) -> Result<Self> {
        let (closest, any) = if any { (0, rays) } else { (rays, 0) };
        let closest = filled(closest, Hit::MISS, "hits")?;
        Ok(Self { closest, any: filled(any, false, "answers")? })
    }

    fn ask(&mut self, engine: &RayEngine, rays: &[Ray], any: bool) {
        if any {
            engine.any(rays, &mut self.any);
        } else {
            engine.closest(rays, &mut self.closest);
        }
    }

    /// Returns whether the other engine's answers begin with these answers.
    fn start_as(&self, other: &Self) -> bool {
        let same = |(a, b): (&Hit, &Hit)| (a.triangle, a.t) == (b.triangle, b.t);
        self.any.iter().zip(&other.any).all(|(a, b)| a == b)
            && self.closest.iter().zip(&other.closest).all(same)
    }

    fn hits(&self) -> u64 {
        let closest = self.closest.iter().filter(|hit| hit.is_hit()).count();
        (closest + self.any.iter().filter(|&&hit| hit).count()) as u64
    }
}
