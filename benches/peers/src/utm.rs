//! Measures scenes at map coordinates, in f64. The scenes are a kilometre across, and are moved
//! half a million metres to the east and four and a half million to the north. Tracers in f32 trace
//! the scene rounded to f32.

use std::path::PathBuf;
use std::sync::Arc;

use intertri::{Mode, Ray, Ray64, Triangle64, TriangleOf};
use intertri_scene::{Mesh, Scene};
use intertri_trace::Bvh;

use crate::clock::Clock;
use crate::engine::{Answer, Engine};
use crate::in_f64::own::Own;
use crate::measure::{self, Named, Row};
use crate::ours::{Batch, Kept, Returned};
use crate::rays::{Order, primary, rounded};
use crate::truth::Truth;
use crate::{doubles, engines, report, scenes};

/// The size of the scenes in metres.
const EXTENT: f64 = 1000.0;
/// The distances by which the scenes are moved east and north, in metres.
const MOVED: [f64; 2] = [5e5, 4.5e6];

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to trace; see the `rays` command.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Engines to measure; see the `rays` command. `exact` and `exact-query` use f64.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "exact,exact-query,embree-fast,embree-robust,tinybvh,obvhs,bvh,parry,parry-f64"
    )]
    engine: Vec<String>,
    /// Seconds per engine and scene.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Width and height of the image in pixels; a power of two.
    #[arg(long, default_value_t = 512)]
    size: u32,
    /// File to write the figures to as JSON.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

/// A scene at map coordinates, in f64 and rounded to f32.
struct Town {
    triangles: Vec<Triangle64>,
    bvh: Arc<Bvh<f64>>,
    rays: Arc<[Ray64]>,
    /// The scene rounded to f32.
    rounded: Scene,
}

impl Town {
    fn new(name: &str, options: &Options) -> Result<Self, String> {
        let scene = scenes::scene(name)?;
        let bounds = scene.mesh.bounds().ok_or_else(|| format!("{name}: no triangles"))?;
        let size = (0..3).map(|k| f64::from(bounds.max[k] - bounds.min[k])).fold(0.0, f64::max);
        let scale = EXTENT / size;
        // The models have y up, but maps have z up.
        let turned = |[x, y, z]: [f64; 3]| [x, -z, y].map(|x| x * scale);
        let moved = |[x, y, z]: [f64; 3]| [x + MOVED[0], y + MOVED[1], z];
        let at = |p: [f32; 3]| moved(turned(p.map(f64::from)));
        let triangle = |&[a, b, c]: &[u32; 3]| {
            TriangleOf([a, b, c].map(|i| at(scene.mesh.positions[i as usize])))
        };
        let triangles: Vec<_> = scene.mesh.triangles.iter().map(triangle).collect();
        let bvh = Arc::new(Bvh::<f64>::new(&triangles).map_err(|e| e.to_string())?);
        let ray = |ray: &Ray| Ray64::new(at(ray.origin), turned(ray.dir.map(f64::from)));
        let rays = primary(&scene.camera, options.size, Order::Rows).iter().map(ray).collect();
        let positions = scene.mesh.positions.iter().map(|&p| at(p).map(|x| x as f32)).collect();
        let mesh = Mesh { positions, ..scene.mesh.clone() };
        Ok(Self { triangles, bvh, rays, rounded: Scene { mesh, ..scene } })
    }

    /// Builds the engines, each with the rays in its own precision.
    fn engines(
        &self,
        options: &Options,
        api: Option<&Arc<crate::embree::Api>>,
    ) -> Result<Vec<Named>, String> {
        let wanted = |name: &str| engines::wanted(name, &options.engine);
        let bvh = &self.bvh;
        let mut all: Vec<Named> = Vec::new();
        let mut add = |name: &str, engine: Box<dyn Engine<Ray64>>| {
            all.push((name.to_owned(), Box::new(Own::new(engine, &self.rays))));
        };
        for (name, _) in engines::ENGINES.iter().filter(|(name, _)| wanted(name)) {
            match *name {
                "exact" => add(name, Box::new(Batch::new(bvh.clone(), Mode::exact()))),
                "exact-query" => {
                    add(name, Box::new(Kept::new(bvh.clone(), Mode::exact(), Returned::Hit)))
                }
                name if doubles::is(name) => {
                    if let Some(engine) = doubles::engine(name, &self.triangles) {
                        add(name, engine);
                    }
                }
                _ => {}
            }
        }
        let rays: Arc<[Ray]> = self.rays.iter().map(rounded).collect();
        let triangles = self.rounded.mesh.to_triangles();
        let bvh = Arc::new(Bvh::new(&triangles).map_err(|e| e.to_string())?);
        let in_f32: Vec<String> = (engines::ENGINES.iter().map(|(name, _)| (*name).to_owned()))
            .filter(|name| wanted(name) && !name.starts_with("exact") && !doubles::is(name))
            .collect();
        if !in_f32.is_empty() {
            let engines = engines::engines(&in_f32, &self.rounded, &triangles, &bvh, api);
            all.extend(
                engines
                    .into_iter()
                    .map(|(name, engine)| -> Named { (name, Box::new(Own::new(engine, &rays))) }),
            );
        }
        Ok(all)
    }

    /// Returns the true answers for the scene in f64.
    fn truth(&self) -> Vec<Answer> {
        let answer = |ray| {
            let hit = self.bvh.closest(ray);
            hit.map_or(Answer::MISS, |hit| Answer { triangle: hit.triangle, t: hit.t })
        };
        self.rays.iter().map(answer).collect()
    }
}

pub fn run(options: &Options) -> Result<(), String> {
    if !options.size.is_power_of_two() || options.size > 1 << 14 {
        return Err("--size must be a power of two, at most 16384".into());
    }
    let (api, pool) = (crate::embree(options.embree.clone()), crate::pool(1)?);
    report::header(pool.install(Clock::fastest), 1, options.size);
    let mut rows: Vec<Row> = Vec::new();
    for name in &options.scene {
        let town = Town::new(name, options)?;
        let answers = town.truth();
        let mut engines = town.engines(options, api.as_ref())?;
        // Each engine traces its own rays and ignores these, so only their number matters.
        let rays: Vec<Ray> = town.rays.iter().map(rounded).collect();
        let question = crate::rays::Kind::Primary.question();
        // Tracers in f32 trace the rounded scene, but the f64 scene defines what is right.
        let truth = |name: &str| Truth::new(name, &answers, &town.triangles, &town.rays);
        let (seconds, beside) = (options.seconds, measure::embree);
        let measured =
            measure::measure(&mut engines, &rays, question, &truth, seconds, &pool, beside);
        let described = |row: Row| row.of(name, town.triangles.len(), "utm", Order::Rows);
        let measured: Vec<Row> = measured.into_iter().map(described).collect();
        report::table(&measured);
        rows.extend(measured);
    }
    options.json.as_ref().map_or(Ok(()), |path| crate::write_rows(path, &rows))
}
