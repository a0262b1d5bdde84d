//! `intertri bench`: how many rays a second, by engine and kind of ray.

use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use intertri::fixed::Bits;
use intertri::{Hit, Ray, Threshold, Triangle};
use intertri_lab::rng::Rng;
use intertri_scene::{Rays, Scene, hit_point, load};
use serde::Serialize;

use crate::camera;
use crate::engine::{Engine, Engines, Name};
use crate::error::{Error, Result};
use crate::frame::tiled;
use crate::numbers;
use crate::progress::Progress;
use crate::report;

/// Rays of a file, at most.
const MOST: usize = 1 << 20;

/// Ray/triangle tests of the reference a turn, about: it is slow.
const REFERENCE: usize = 20_000_000;

/// Say how many million rays a second each engine answers, of each kind
///
/// Primary rays are the camera's, tile by tile; shadow rays go from the light to what they hit and ask
/// for any hit; diffuse rays leave from there in all directions of the open side. All engines run in
/// turn, on all threads, and what is told is the median of the turns. The scalar reference, which asks
/// all triangles, gets fewer rays. Run it on a quiet machine.
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY or STL file [default: the built-in scene]
    model: Option<PathBuf>,

    /// Pixels in a row, and rows
    #[arg(long, value_name = "WxH", default_value = "1024x768", value_parser = numbers::size)]
    size: (u32, u32),

    /// Measure the first million rays of this file, too, as trace reads it
    #[arg(long, value_name = "FILE")]
    rays: Option<PathBuf>,

    /// How often each engine gets its turn
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    turns: u32,

    /// Print a report for programs, as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    camera: camera::Options,
}

/// Rays of a kind.
struct Kind {
    name: &'static str,
    rays: Vec<Ray>,
    any: bool,
}

/// A median.
#[derive(Serialize)]
struct Rate {
    rays: &'static str,
    engine: Name,
    million_a_second: f64,
    times_the_reference: f64,
    hits: u64,
}

#[derive(Serialize)]
struct Report {
    model: Option<PathBuf>,
    triangles: usize,
    threads: usize,
    turns: u32,
    rates: Vec<Rate>,
}

/// Measures.
pub(crate) fn run(options: &Options) -> Result<()> {
    let (width, height) = options.size;
    let model = options.model.as_deref().map(load).transpose()?;
    let scene = options.camera.scene(model, f64::from(width) / f64::from(height))?;
    let triangles = scene.mesh.to_triangles();
    let mut engines = Engines::new(&triangles, Threshold::default());

    // The rays.
    let certified = engines.engine(Name::Certified)?;
    let mut kinds = kinds(&scene, &triangles, options.size, &certified);
    if let Some(path) = &options.rays {
        let mut rays = vec![];
        Rays::open(path)?.read(&mut rays, MOST)?;
        kinds.push(Kind { name: "file", rays, any: false });
    }
    kinds.retain(|kind| !kind.rays.is_empty());

    // The grid must hold all origins.
    let from = kinds.iter().flat_map(|kind| kind.rays.iter().map(|ray| ray.origin)).collect();
    let mut engines = Engines::new(&triangles, Threshold::default()).on_grid(Bits::FINE, from);
    let names = [Name::Certified, Name::Double, Name::Fixed, Name::Reference];
    let contenders: Vec<Engine> =
        names.into_iter().map(|name| engines.engine(name)).collect::<Result<_>>()?;

    let bar = Progress::new("bench", Some(kinds.len() as u64 * u64::from(options.turns + 1)));
    let mut rates = vec![];
    for kind in &kinds {
        rates.extend(measure(kind, &names, &contenders, triangles.len(), options.turns, &bar)?);
    }
    drop(bar);
    let report = Report {
        model: options.model.clone(),
        triangles: triangles.len(),
        threads: rayon::current_num_threads(),
        turns: options.turns,
        rates,
    };
    report::print(&report, options.json)
}

/// What a camera sees, what the light sees of that, and what is seen from there.
fn kinds(
    scene: &Scene,
    triangles: &[Triangle],
    (width, height): (u32, u32),
    engine: &Engine,
) -> Vec<Kind> {
    let camera = |(x, y)| scene.camera.ray(x, y, width, height);
    let primary: Vec<Ray> = tiled(width, height).map(camera).collect();
    let mut hits = vec![Hit::MISS; primary.len()];
    engine.closest(&primary, &mut hits);

    let mut rng = Rng::new(1);
    let (mut shadow, mut diffuse) = (vec![], vec![]);
    for (ray, hit) in primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let point = hit_point(ray, hit);
        shadow.push(scene.light.shadow_ray(point));
        let way = rng.direction();
        let normal = normal(&triangles[hit.triangle as usize]);
        let dot = |v: [f64; 3]| (0..3).map(|k| normal[k] * v[k]).sum::<f64>();
        // To the side from which it is seen; it starts a little above.
        let side = if dot(way) * dot(ray.dir.map(f64::from)) > 0.0 { -1.0 } else { 1.0 };
        let dir = way.map(|x| (side * x) as f32);
        let near = (hit.t * 1e-4) as f32;
        diffuse.push(Ray::new(point.map(|x| x as f32), dir).between(near, f32::INFINITY));
    }
    vec![
        Kind { name: "primary", rays: primary, any: false },
        Kind { name: "shadow", rays: shadow, any: true },
        Kind { name: "diffuse", rays: diffuse, any: false },
    ]
}

fn normal(&Triangle([a, b, c]): &Triangle) -> [f64; 3] {
    let side = |p: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
    let ([x, y, z], [p, q, r]) = (side(b), side(c));
    [y * r - z * q, z * p - x * r, x * q - y * p]
}

/// All engines in turn. Those that give the reference's answers must give the same.
fn measure(
    kind: &Kind,
    names: &[Name],
    contenders: &[Engine],
    triangles: usize,
    turns: u32,
    bar: &Progress,
) -> Result<Vec<Rate>> {
    let few = (REFERENCE / triangles.max(1)).clamp(1, kind.rays.len());
    let mut seconds = vec![vec![]; names.len()];
    let mut answers = vec![Answers::default(); names.len()];
    // The first turn warms up.
    for turn in 0..=turns {
        for (k, engine) in contenders.iter().enumerate() {
            let rays = if names[k] == Name::Reference { &kind.rays[..few] } else { &kind.rays[..] };
            let start = Instant::now();
            answers[k].ask(engine, rays, kind.any);
            if turn > 0 {
                seconds[k].push(start.elapsed().as_secs_f64() / rays.len() as f64);
            }
        }
        bar.add(1);
    }

    for (k, &name) in names.iter().enumerate() {
        if name != Name::Fixed && !answers[k].start_as(&answers[0]) {
            return Err(Error::new(format!(
                "{} rays: engines {:?} and {name:?} differ; please report that",
                kind.name, names[0]
            )));
        }
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
        million_a_second: 1e-6 / seconds[k],
        times_the_reference: slow / seconds[k],
        hits: answers[k].hits(),
    };
    Ok((0..names.len()).map(rate).collect())
}

/// What an engine said.
#[derive(Clone, Default)]
struct Answers {
    closest: Vec<Hit>,
    any: Vec<bool>,
}

impl Answers {
    fn ask(&mut self, engine: &Engine, rays: &[Ray], any: bool) {
        if any {
            self.any.resize(rays.len(), false);
            engine.any(rays, &mut self.any);
        } else {
            self.closest.resize(rays.len(), Hit::MISS);
            engine.closest(rays, &mut self.closest);
        }
    }

    /// Whether another's answers begin with these.
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

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model = match &self.model {
            Some(path) => path.display().to_string(),
            None => "the built-in scene".to_owned(),
        };
        writeln!(
            f,
            "{model}, {} triangles, {} threads, median of {} turns",
            self.triangles, self.threads, self.turns
        )?;
        write!(
            f,
            "{:10} {:10} {:>20} {:>20}",
            "rays", "engine", "million a second", "times reference"
        )?;
        for rate in &self.rates {
            let engine = format!("{:?}", rate.engine).to_lowercase();
            write!(
                f,
                "\n{:10} {engine:10} {:>20.3} {:>20.0}",
                rate.rays, rate.million_a_second, rate.times_the_reference
            )?;
        }
        Ok(())
    }
}
