//! `intertri crossover`: finds where rays become faster than the z-buffer and shadow volumes.

use std::f64::consts::TAU;
use std::fmt;

use clap::Args;
use intertri::Threshold;
use intertri_lab::draw::{self, Race};
use intertri_scene::{Mesh, Scene};
use serde::Serialize;

use crate::commands::options::ChartOptions;
use crate::engine::engines::Engines;
use crate::engine::frame::{Frame, Shadows};
use crate::engine::name::EngineName;
use crate::engine::raster::Raster;
use crate::error::{Error, Result};
use crate::io::progress::Progress;
use crate::report::charts::{ChartFolder, Written};
use crate::report::check::Difference;
use crate::report::print::print;

/// Time rays against the z-buffer and shadow volumes, by number of triangles and pixels
///
/// The scene is a ring on a floor, with more and more triangles. Its picture is drawn both ways,
/// and every pixel is compared. Writes a chart (SVG and PNG) and its data (CSV). The times exclude
/// what is built once per mesh: the hierarchy and the table of neighbours. Run this on a quiet
/// machine.
#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    charts: ChartOptions,
}

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    written: Written,
    races: Vec<Race>,
}

/// Measures both methods, and draws the chart.
pub(crate) fn run(options: &Options) -> Result<()> {
    let mut charts = ChartFolder::new(&options.charts.output)?;
    let (turns, cells, sizes): (_, &[u32], &[(u32, u32)]) = if options.charts.quick {
        (1, &[4, 16], &[(64, 48), (128, 96)])
    } else {
        (5, &[4, 8, 16, 32, 64, 128, 256, 512], &[(256, 192), (1024, 768), (2048, 1536)])
    };

    let bar = Progress::new("race", Some((cells.len() * sizes.len()) as u64));
    let mut races = Vec::new();
    for &cells in cells {
        let scene = Scene::of(ring(cells), 4.0 / 3.0)?;
        let triangles = scene.mesh.to_triangles();
        let mut engines = Engines::new(&triangles, Threshold::DEFAULT);
        for &size in sizes {
            let raster = Raster::new(&scene, &triangles, size, Threshold::DEFAULT);
            races.extend(race(&scene, &raster, &mut engines, turns)?);
            bar.add(1);
        }
    }
    drop(bar);
    races.sort_by_key(|race| (race.task != Race::TASKS[0], race.width, race.triangles));

    let timed =
        if turns == 1 { "one turn".to_owned() } else { format!("the median of {turns} turns") };
    let what = format!("a ring on a floor; {timed}, all threads");
    let caption = format!("{}\n{what}", charts.machine);
    charts.picture("crossover", &draw::crossover(&races, &caption))?;
    charts.table("crossover", &races, &what)?;
    print(&Report { written: charts.finish(), races }, options.charts.json)
}

/// Times both ways of drawing an image, in alternation. Checks that their pixels are the same,
/// except where the rule of [`Difference::by_rule`] excuses a difference.
fn race(
    scene: &Scene,
    raster: &Raster<'_>,
    engines: &mut Engines<'_>,
    turns: usize,
) -> Result<[Race; 2]> {
    // The first turn is not timed, because it also builds the data that is built once per mesh.
    let mut seconds = [const { Vec::new() }; 4];
    for turn in 0..=turns {
        let rays = Frame::draw(scene, raster, engines, EngineName::Certified, Shadows::Rays)?;
        let other = Frame::draw(scene, raster, engines, EngineName::Raster, Shadows::Volumes)?;
        if turn == 0 {
            let count = Difference::by_rule(raster, &rays, &other)?.count();
            if count.differ > count.excused {
                let (width, height) = raster.size;
                return Err(Error::new(format!(
                    "in the {width}x{height} image, {} pixels differ that should not",
                    count.differ - count.excused
                )));
            }
            continue;
        }
        let taken =
            [rays.trace_seconds, other.trace_seconds, rays.shadow_seconds, other.shadow_seconds];
        seconds.iter_mut().zip(taken).for_each(|(all, seconds)| all.push(seconds));
    }
    let median = |task: usize, way: usize| {
        let mut seconds: Vec<f64> = seconds[2 * task + way].clone();
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    };
    let (width, height) = raster.size;
    let triangles = raster.triangles.len();
    Ok([0, 1].map(|task| Race {
        task: Race::TASKS[task],
        triangles,
        width,
        height,
        rays: median(task, 0),
        raster: median(task, 1),
    }))
}

/// Returns a ring of `2 * cells` × `cells` quads that stands on a floor of two triangles.
fn ring(cells: u32) -> Mesh {
    let point = |i: u32, j: u32| {
        let [along, around] =
            [(i, 2 * cells), (j, cells)].map(|(k, n)| TAU * f64::from(k % n) / f64::from(n));
        let radius = 1.0 + 0.4 * around.cos();
        [radius * along.cos(), 1.4 + radius * along.sin(), 0.4 * around.sin()].map(|x| x as f32)
    };
    let mut mesh = Mesh {
        positions: vec![[-3.0, 0.0, -3.0], [-3.0, 0.0, 3.0], [3.0, 0.0, 3.0], [3.0, 0.0, -3.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    for i in 0..2 * cells {
        mesh.positions.extend((0..cells).map(|j| point(i, j)));
        for j in 0..cells {
            let at = |i: u32, j: u32| 4 + i % (2 * cells) * cells + j % cells;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.written.machine)?;
        for task in Race::TASKS {
            writeln!(
                f,
                "\n{task:5} {:>10}  {:>10}  {:>10}  raster",
                "pixels", "triangles", "rays"
            )?;
            for race in self.races.iter().filter(|race| race.task == task) {
                let Race { triangles, width, height, rays, raster, .. } = race;
                let size = format!("{width}x{height}");
                let (rays, raster) = (rays * 1e3, raster * 1e3);
                writeln!(f, "{size:>16}  {triangles:>10}  {rays:>7.1} ms  {raster:.1} ms")?;
            }
        }
        write!(f, "\n{}", self.written)
    }
}
