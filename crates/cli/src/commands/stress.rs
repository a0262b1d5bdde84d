//! `intertri stress`: shows where each method begins to fail on adversarial inputs.

use std::fmt;

use clap::Args;
use intertri::{Ray64, Triangle64};
use intertri_lab::draw;
use intertri_lab::methods::METHODS;
use intertri_lab::stress::{OffsetErrors, Onset, SWEEPS, first, sweep_all, sweep_offsets};
use intertri_trace::Bvh;
use serde::Serialize;

use crate::commands::options::ChartOptions;
use crate::error::Result;
use crate::io::progress::Progress;
use crate::report::charts::{ChartFolder, Written};
use crate::report::print::print;

/// Run the adversarial families and draw where each method begins to fail
///
/// Writes onset curves, a table of onsets, walls far from zero and edge maps (SVG and PNG), the
/// curves as CSV, and a page with everything (HTML).
#[derive(Args)]
pub(crate) struct Options {
    /// The seed of the random numbers: the same seed yields the same counts
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    #[command(flatten)]
    charts: ChartOptions,
}

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    written: Written,
    seed: u64,
    onsets: Vec<Onset>,
    offsets: Vec<OffsetErrors>,
}

/// Runs the sweeps, and draws the results.
pub(crate) fn run(options: &Options) -> Result<()> {
    let mut charts = ChartFolder::new(&options.charts.output)?;
    let (points, cases) = if options.charts.quick { (13, 2_000) } else { (37, 20_000) };

    let bar = Progress::new("sweep", Some((SWEEPS.len() * points) as u64));
    let onsets = sweep_all(options.seed, points, cases, &|| bar.add(1));
    let rays = cases / 5;
    let offsets = sweep_offsets(options.seed, points, rays, &in_f64);
    drop(bar);

    let what = format!("up to {cases} cases per value; seed {}", options.seed);
    let caption = format!("{}; {what}", charts.machine);
    let (curves, heat) = (draw::onsets(&onsets, &caption), draw::heat(&onsets, &caption));
    let rays = format!("{}; {rays} rays per distance; seed {}", charts.machine, options.seed);
    let walls = draw::offsets(&offsets, &rays);
    let maps = draw::edge_maps(&charts.machine.to_string());
    charts.picture("onsets", &curves)?;
    charts.picture("heat", &heat)?;
    charts.picture("offsets", &walls)?;
    charts.picture("edge-maps", &maps)?;
    charts.table("onsets", &onsets, &what)?;
    charts.table("offsets", &offsets, &what)?;
    let sections = [
        draw::Section {
            title: "Where failures begin",
            text: "For each family of inputs, from harmless on the left to adversarial on the right: \
                   the share of each method's answers that exact arithmetic proves wrong.",
            picture: &curves,
        },
        draw::Section {
            title: "All methods, all families",
            text: "For each method, the value of each family's parameter at which one answer in a \
                   thousand is first wrong.",
            picture: &heat,
        },
        draw::Section {
            title: "Far from zero",
            text: "Walls in f64 at growing distances, as in maps and plans, and rays that leave or \
                   approach them: a method that rounds to f32 is soon no better than a coin toss.",
            picture: &walls,
        },
        draw::Section {
            title: "Around an edge",
            text: "Two triangles that share an edge, seen by rays a few steps of f32 apart: where a \
                   method sees neither, it leaks; where it sees both, it counts twice.",
            picture: &maps,
        },
    ];
    charts.page("stress", "Ray/triangle tests: where they break", &sections)?;

    let report = Report { written: charts.finish(), seed: options.seed, onsets, offsets };
    print(&report, options.charts.json)
}

/// Determines which rays hit triangles, with `exact` over an f64 hierarchy.
fn in_f64(triangles: &[Triangle64], rays: &[Ray64]) -> Vec<bool> {
    let mut hits = vec![false; rays.len()];
    if let Ok(bvh) = Bvh::new(triangles) {
        bvh.query().any_batch_into(rays, &mut hits);
    }
    hits
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n\nwhere one answer in 1,000 is first wrong:", self.written.machine)?;
        for sweep in SWEEPS {
            writeln!(f, "\n{}, from {:e} to {:e}", sweep.name, sweep.from, sweep.to)?;
            for method in METHODS {
                let value = first(&self.onsets, sweep.name, method.name);
                let value = value.map_or("not reached".to_owned(), |x| format!("{x:.1e}"));
                writeln!(f, "  {:24} {value}", method.name)?;
            }
        }
        write!(f, "\n{}", self.written)
    }
}
