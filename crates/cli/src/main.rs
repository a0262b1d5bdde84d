//! The `intertri` program: draws models, traces files of rays, and runs measurements.
//!
//! The exit code is 0 only if the program did everything that the user requested, 1 if it could
//! not, and 2 if the command line was invalid. An error is one line on standard error.

mod commands;
mod engine;
mod error;
mod io;
mod report;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::commands::{advise, bench, build, chart, crossover, inspect, render, stress, trace};

/// Ray/triangle intersection: trace in f32, answer in f64, or exactly.
///
/// The default engine, exact, is correct for the coordinates as given; oracle computes the same
/// answers with a plain loop in rational arithmetic. The certified and reference engines both
/// return the answers of the scalar f64 reference, bit for bit, and differ only in speed. The fixed
/// engine snaps the scene to a grid, on which it is exact; the raster engine draws without rays.
#[derive(Parser)]
#[command(name = "intertri", version)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(render::Options),
    Trace(trace::Options),
    Build(build::Options),
    Inspect(inspect::Options),
    Chart(chart::Options),
    Stress(stress::Options),
    Advise(advise::Options),
    Bench(bench::Options),
    Crossover(crossover::Options),
}

fn main() -> ExitCode {
    error::report_panics_in_one_line();
    let command = match CommandLine::try_parse() {
        Ok(line) => line.command,
        Err(error) => {
            // If standard output is closed, even the help would be lost silently.
            let closed = if error.use_stderr() { Ok(()) } else { io::standard_output::check() };
            return closed.map_or_else(|e| e.tell(), |()| error::command_line(&error));
        }
    };
    match prepare().and_then(|()| run(command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => error.tell(),
    }
}

/// Sets up what all commands need: standard output, threads, and a thread that waits for signals.
fn prepare() -> error::Result<()> {
    io::standard_output::check()?;
    io::signals::watch()?;
    rayon::ThreadPoolBuilder::new().build_global().map_err(error::Error::no_thread)
}

fn run(command: Command) -> error::Result<()> {
    match command {
        Command::Render(options) => render::run(&options),
        Command::Trace(options) => trace::run(&options),
        Command::Build(options) => build::run(&options),
        Command::Inspect(options) => inspect::run(&options),
        Command::Chart(options) => chart::run(&options),
        Command::Stress(options) => stress::run(&options),
        Command::Advise(options) => advise::run(&options),
        Command::Bench(options) => bench::run(&options),
        Command::Crossover(options) => crossover::run(&options),
    }
}
