//! Measures scenes in f64, both in place and moved far away, and compares them with the same scenes
//! in f32 and with other f64 tracers.

mod input;
pub mod own;

use std::path::PathBuf;
use std::sync::Arc;

use intertri::{Mode, Ray64, Triangle64};
use intertri_scene::Scene;
use intertri_trace::Bvh;
use rayon::ThreadPool;

use crate::clock::Clock;
use crate::engine::{Answer, Question};
use crate::measure::{self, Named, Row};
use crate::ours::{Batch, Single, Triangles};
use crate::rays::{self, Kind, Order, widened};
use crate::truth::Truth;
use crate::{report, scenes};

use input::Input;

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to trace; see the `rays` command.
    #[arg(long, value_delimiter = ',', default_value = "bunny,kitchen,sphere")]
    scene: Vec<String>,
    /// Kinds of rays to trace.
    #[arg(long, value_delimiter = ',', default_value = "primary,shadow,light,diffuse,edges")]
    kind: Vec<Kind>,
    /// Names of the engines to measure; all by default.
    #[arg(long, value_delimiter = ',')]
    engine: Vec<String>,
    /// Distance by which the scenes are moved.
    #[arg(long, default_value_t = 1e6)]
    moved: f64,
    /// Distance to an additional small triangle, in multiples of the scene's size.
    #[arg(long, default_value_t = 1e3)]
    far: f64,
    /// Seconds per engine, scene and kind of ray.
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
    /// Width and height of the image in pixels; a power of two.
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// Order of the pixels.
    #[arg(long, value_enum, default_value_t = Order::Tiles)]
    order: Order,
    /// File to write the figures to as JSON.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Path to Embree's shared library; see the `rays` command.
    #[arg(long, env = "EMBREE")]
    embree: Option<PathBuf>,
}

/// The versions of a scene: in f32, in f64, in f64 and moved, and in f64 with a distant triangle.
struct Scenes {
    given: Scene,
    in_f32: Arc<Bvh>,
    still: Input,
    moved: Input,
    vast: Input,
}

pub fn run(options: &Options) -> Result<(), String> {
    if !options.size.is_power_of_two() || options.size > 1 << 14 {
        return Err("--size must be a power of two, at most 16384".into());
    }
    let (api, pool) = (crate::embree(options.embree.clone()), crate::pool(1)?);
    report::header(pool.install(Clock::fastest), 1, options.size);
    let mut rows: Vec<Row> = Vec::new();
    for name in &options.scene {
        let given = scenes::scene(name)?;
        let triangles = given.mesh.to_triangles();
        let in_f32 = Arc::new(Bvh::new(&triangles).map_err(|e| e.to_string())?);
        let by = [1.0, 0.7, -0.3].map(|x| x * options.moved);
        let still = Input::new(&given.mesh, [0.0; 3], 0.0, api.as_ref())?;
        let moved = Input::new(&given.mesh, by, 0.0, api.as_ref())?;
        let vast = Input::new(&given.mesh, [0.0; 3], options.far, None)?;
        let scene = Scenes { given, in_f32, still, moved, vast };
        for &kind in &options.kind {
            let measured = cell(options, &scene, kind, &pool)?;
            let described = |row: Row| row.of(name, scene.in_f32.len(), kind.name(), options.order);
            let measured: Vec<Row> = measured.into_iter().map(described).collect();
            report::table(&measured);
            rows.extend(measured);
        }
    }
    options.json.as_ref().map_or(Ok(()), |path| crate::write_rows(path, &rows))
}

/// The triangles and rays of one input, and the true answers.
struct Traced<'a> {
    name: &'static str,
    triangles: &'a [Triangle64],
    rays: Arc<[Ray64]>,
    answers: Vec<Answer>,
}

impl<'a> Traced<'a> {
    fn new(name: &'static str, input: &'a Input, rays: &Arc<[Ray64]>, question: Question) -> Self {
        let answers = input.truth(rays, question);
        Self { name, triangles: input.triangles(), rays: rays.clone(), answers }
    }
}

/// Measures one kind of ray in one scene.
fn cell(
    options: &Options,
    scene: &Scenes,
    kind: Kind,
    pool: &ThreadPool,
) -> Result<Vec<Row>, String> {
    let Options { size, order, seconds, .. } = *options;
    let question = kind.question();
    let rays = rays::rays(kind, &scene.given, &scene.in_f32, size, order);
    let casts: Vec<Ray64> = rays.iter().map(widened).collect();
    let moved: Arc<[Ray64]> = casts.iter().map(|ray| scene.moved.ray(ray)).collect();
    let (exact, mode) = (&scene.in_f32, Mode::exact());
    let mut engines: Vec<Named> = vec![
        ("exact".into(), Box::new(Batch::new(exact.clone(), mode))),
        ("exact-triangles".into(), Box::new(Triangles::new(exact.clone(), mode))),
        ("exact-single".into(), Box::new(Single::new(exact.clone(), mode))),
    ];
    let casts: Arc<[Ray64]> = casts.into();
    let wanted =
        |name: &str| options.engine.is_empty() || options.engine.iter().any(|only| only == name);
    engines.extend(scene.still.ours("f64", &casts));
    engines.extend(scene.moved.ours("f64-moved", &moved));
    engines.extend(scene.vast.ours("f64-vast", &casts));
    for (name, [tests, undecided]) in [
        ("exact", input::counts(exact, &rays, question)),
        ("f64", scene.still.counts(&casts, question)),
        ("f64-moved", scene.moved.counts(&moved, question)),
        ("f64-vast", scene.vast.counts(&casts, question)),
    ] {
        println!("{name:10} {tests:8.2} tests per ray, {undecided:.5} settled by the resolver");
    }
    let mut inputs = vec![
        Traced::new("moved", &scene.moved, &moved, question),
        Traced::new("", &scene.still, &casts, question),
    ];
    if matches!(kind, Kind::Edges | Kind::Vertices) {
        let aimed: Arc<[Ray64]> =
            rays::lines(kind, &scene.given, &scene.in_f32, size, order).into();
        engines.extend(scene.still.ours("f64-aimed", &aimed));
        inputs.insert(0, Traced::new("aimed", &scene.still, &aimed, question));
    }
    engines.retain(|(name, _)| wanted(name));
    engines.extend(scene.still.others("f64", &casts, &wanted)?);
    engines.extend(scene.moved.others("f64-moved", &moved, &wanted)?);
    let truth = &|name: &str| truth_of(&inputs, name);
    Ok(measure::measure(&mut engines, &rays, question, truth, seconds, pool, in_f32))
}

/// Returns the true answers for an engine. The engine's name contains the name of its input.
fn truth_of<'a>(inputs: &'a [Traced<'_>], engine: &str) -> Truth<'a> {
    let of_it = |input: &&Traced<'_>| engine.contains(input.name);
    let input =
        inputs.iter().find(of_it).expect("every engine's name contains the name of an input");
    Truth::new(engine, &input.answers, input.triangles, &input.rays)
}

/// Returns the index of the row in which `exact` in f32 makes the same kind of call.
fn in_f32(rows: &[Row], engine: usize) -> Option<usize> {
    let name = &rows[engine].engine;
    let form = ["-triangles", "-single"].into_iter().find(|form| name.ends_with(form));
    let exact = format!("exact{}", form.unwrap_or_default());
    rows.iter().position(|row| row.engine == exact)
}
