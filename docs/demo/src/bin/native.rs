//! Computes the demo page's results natively, so that a test can compare them with the page's own.
//!
//!     native fan NUMBERS...          pixel counts, one line per method
//!     native model FILE NUMBERS...   pixel counts for a model; - means the built-in scene
//!     native golden                  the golden report
//!     native rate FILE NUMBERS...    the best speed of exact, in millions of rays per second

use std::process::ExitCode;
use std::time::Instant;

use intertri_demo::METHODS;
use intertri_demo::fan::Fan;
use intertri_demo::model::Model;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("native: {e}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: &[String]) -> Result<(), String> {
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args[..] {
        ["golden"] => {
            let (text, same) = intertri_golden::report();
            print!("{text}");
            if same { Ok(()) } else { Err("the results differ from the committed ones".into()) }
        }
        ["fan", ref rest @ ..] => {
            let fan = Fan::new(&numbers(rest)?).ok_or("invalid fan")?;
            print_counts(|method| fan.picture(method).0);
            Ok(())
        }
        ["model", file, ref rest @ ..] => {
            let (mut model, height) = looked_at(file, rest)?;
            model.trace(0..height);
            print_counts(|method| model.compare(method, 0..height.div_ceil(8)).0);
            Ok(())
        }
        ["rate", file, ref rest @ ..] => {
            let (mut model, height) = looked_at(file, rest)?;
            let rays = model.trace(0..height).len() as f64;
            let seconds = (0..20).map(|_| {
                let start = Instant::now();
                model.trace(0..height);
                start.elapsed().as_secs_f64()
            });
            println!("{:.3}", rays / seconds.fold(f64::INFINITY, f64::min) / 1e6);
            Ok(())
        }
        _ => Err("usage: native fan|model|golden|rate ...".into()),
    }
}

/// Loads a model and sets its view. Returns the model and the image's height in pixels.
fn looked_at(file: &str, view: &[&str]) -> Result<(Model, usize), String> {
    let mut model = if file == "-" {
        Model::built_in()?
    } else {
        Model::from_file(file, &std::fs::read(file).map_err(|e| format!("{file}: {e}"))?)?
    };
    let view = numbers(view)?;
    if !model.look(&view) {
        return Err("invalid view".into());
    }
    Ok((model, view[1] as usize))
}

fn numbers(args: &[&str]) -> Result<Vec<f64>, String> {
    args.iter().map(|arg| arg.parse().map_err(|e| format!("{arg}: {e}"))).collect()
}

fn print_counts(mut counts: impl FnMut(usize) -> [u32; 5]) {
    for (i, method) in METHODS.iter().enumerate() {
        println!("{}\t{}", counts(i).map(|n| n.to_string()).join("\t"), method.name);
    }
}
