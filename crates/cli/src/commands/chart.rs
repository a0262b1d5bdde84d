//! `intertri chart`: measures the speed and accuracy of every known method.

use std::fmt;
use std::path::PathBuf;

use clap::Args;
use intertri_lab::accuracy::{ErrorCounts, count_errors};
use intertri_lab::draw;
use intertri_lab::families::FAMILIES;
use intertri_lab::metrics::{Row, metrics};
use intertri_lab::pareto::{Baseline, fastest, pareto_front};
use intertri_lab::tables::count;
use intertri_lab::timing::{Time, measure};
use intertri_lab::workloads::{self, Workload};
use serde::Serialize;

use crate::commands::options::ChartOptions;
use crate::engine::model::{Model, ModelNotes, ModelOptions};
use crate::error::{Error, Result};
use crate::io::progress::Progress;
use crate::report::charts::{ChartFolder, Written};
use crate::report::print::print;
use crate::report::rounding::Rounded;

/// Run every known method and draw speed against accuracy
///
/// Writes a chart (SVG and PNG), its data (CSV), and a page with everything (HTML). Coordinates
/// that are not exact in f32 are rounded first and counted in the report. Run this on a quiet
/// machine.
#[derive(Args)]
pub(crate) struct Options {
    /// An OBJ, PLY, STL or glTF file, or a hierarchy saved by build, for the camera and secondary
    /// rays [default: a sphere and a torus]
    model: Option<PathBuf>,

    /// The seed of the random numbers: the same seed yields the same counts
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    #[command(flatten)]
    reading: ModelOptions,

    #[command(flatten)]
    charts: ChartOptions,
}

#[derive(Serialize)]
struct Report {
    #[serde(flatten)]
    written: Written,
    model: Option<PathBuf>,
    rounded: Rounded,
    /// Everything in the model that was omitted, repaired or guessed.
    notes: ModelNotes,
    seed: u64,
    times: Vec<Time>,
    verdicts: Vec<ErrorCounts>,
    families: Vec<Row>,
}

/// Measures speed and accuracy, and draws the chart.
pub(crate) fn run(options: &Options) -> Result<()> {
    let mut charts = ChartFolder::new(&options.charts.output)?;
    let (model, rounded, notes) = model(options)?;
    let seed = options.seed;
    let (turns, rays, cases) =
        if options.charts.quick { (25, 20_000, 2_000) } else { (250, 1_000_000, 60_000) };

    // Measure times first, while nothing else is running.
    let bar = Progress::new("time", Some(Workload::ALL.len() as u64 * (turns as u64 + 1)));
    let time = |workload| measure(workload, &model, turns, || bar.add(1));
    let times: Vec<Time> = Workload::ALL.into_iter().flat_map(time).collect();
    drop(bar);

    let bar = Progress::new("accuracy", Some(Workload::ALL.len() as u64 * rays));
    let step = |n: u64| bar.add(n as usize);
    let verdict = |workload| count_errors(workload, &model, seed, rays, &step);
    let verdicts: Vec<ErrorCounts> = Workload::ALL.into_iter().flat_map(verdict).collect();
    drop(bar);

    let bar = Progress::new("families", Some(FAMILIES.len() as u64 * cases));
    let step = |n: u64| bar.add(n as usize);
    let rows = FAMILIES.iter().flat_map(|family| metrics(family, seed, cases, &step));
    let families: Vec<Row> = rows.collect();
    drop(bar);

    let named = options.model.as_ref().and_then(|path| path.file_name());
    let named = named.map_or("a sphere and a torus".into(), |name| name.to_string_lossy());
    let what = format!(
        "model: {named}, {} triangles; {rays} rays or pairs per panel; {turns} turns; seed {seed}",
        model.len()
    );
    let caption = format!("{}\n{what}", charts.machine);
    let chart = draw::chart(&times, &verdicts, &caption);
    charts.picture("chart", &chart)?;
    charts.table("times", &times, &what)?;
    charts.table("verdicts", &verdicts, &what)?;
    charts.table("families", &families, &what)?;
    let section = draw::Section {
        title: "Speed against accuracy",
        text: "All methods in four workloads: the share of wrong answers, determined by exact \
               arithmetic, against the speed as a multiple of the scalar reference's.",
        picture: &chart,
    };
    charts.page("chart", "Ray/triangle tests: speed against accuracy", &[section])?;

    let report = Report {
        written: charts.finish(),
        model: options.model.clone(),
        rounded,
        notes,
        seed,
        times,
        verdicts,
        families,
    };
    print(&report, options.charts.json)
}

/// Returns the model for the measurements, the number of its coordinates that were rounded, and its
/// notes.
fn model(options: &Options) -> Result<(workloads::Model, Rounded, ModelNotes)> {
    let Some(path) = &options.model else {
        return Ok((workloads::Model::built_in(), Rounded::default(), ModelNotes::default()));
    };
    let model = Model::load(path, options.reading)?.in_f32()?;
    let measured = workloads::Model::new(&model.mesh.to_triangles())
        .ok_or_else(|| Error::at(path.display(), "has no triangle to measure with"))?;
    Ok((measured, Rounded::of_model(model.rounding), model.notes))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.written.machine)?;
        self.rounded.write_line(f)?;
        for workload in Workload::ALL {
            let form = workload.form().label();
            let faster = format!("× ({form} of N)");
            writeln!(f, "\n{:22} {faster:>23}", workload.name())?;
            for verdict in self.verdicts.iter().filter(|v| v.workload == workload.name()) {
                let time = fastest(verdict, &self.times).map_or(String::new(), |time| {
                    let Time {
                        times_faster: at,
                        times_faster_p25: lo,
                        times_faster_p75: hi,
                        lanes,
                        ..
                    } = time;
                    format!("{at:.1} ({lo:.1}–{hi:.1}) of {lanes:<2}")
                });
                // If there are no errors, `count` also gives an upper bound on their share, at 95 %
                // confidence.
                let of = |errors| count(errors, verdict.trials);
                write!(f, "{:22} {time:>23}  ", verdict.method)?;
                if workload == Workload::Edges {
                    write!(
                        f,
                        "leaks {}; counted twice {}",
                        of(verdict.leaks),
                        of(verdict.doubles)
                    )?;
                } else {
                    write!(f, "wrong {}", of(verdict.wrong))?;
                }
                writeln!(f, "; differs from the reference {}", of(verdict.not_reference))?;
            }
            for (baseline, name) in
                [(Baseline::Oracle, "oracle"), (Baseline::Reference, "reference")]
            {
                let front =
                    pareto_front(workload, baseline, &self.verdicts, &self.times).join(", ");
                writeln!(f, "Pareto front by the {name}: {front}")?;
            }
        }
        write!(f, "\n{}", self.written)
    }
}
