//! Checks whether this machine computes the committed golden answers.
//!
//!     cargo run --release -p intertri-golden             every section at every level of this CPU
//!     cargo run --release -p intertri-golden -- write    rewrites the committed files

use std::process::ExitCode;

use intertri::simd::Level;
use intertri_golden::{SECTIONS, report};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => {
            let (text, same) = report();
            print!("{text}");
            ExitCode::from(u8::from(!same))
        }
        ["write"] => write(),
        _ => {
            eprintln!("golden: give nothing, or `write`");
            ExitCode::from(2)
        }
    }
}

/// Writes the answers at the narrowest level to the files.
fn write() -> ExitCode {
    for section in SECTIONS {
        let lines = section.answers(Level::PORTABLE);
        let text = lines.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n") + "\n";
        let path = format!("{}/{}", env!("CARGO_MANIFEST_DIR"), section.file);
        if let Err(e) = std::fs::write(&path, text) {
            eprintln!("golden: {path}: {e}");
            return ExitCode::FAILURE;
        }
        println!("{path}: {} lines", lines.len());
    }
    ExitCode::SUCCESS
}
