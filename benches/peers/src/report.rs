//! Prints tables to the terminal.

use intertri::simd::Level;

use crate::builds::Built;
use crate::engines::ENGINES;
use crate::leaks::Row as Leaks;
use crate::measure::Row;
use crate::scenes::{CLOSED, SCENES};

/// Returns the name of the CPU and the instruction level that intertri uses.
pub fn cpu() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let named = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let name = named.map_or(std::env::consts::ARCH, |(_, name)| name.trim());
    format!("{name}, {}", Level::best().name())
}

/// Formats a number in groups of three digits.
pub fn grouped(number: usize) -> String {
    let digits = number.to_string().into_bytes();
    let groups: Vec<_> = digits.rchunks(3).rev().map(String::from_utf8_lossy).collect();
    groups.join(",")
}

/// Prints the machine and the settings.
pub fn header(fastest: f64, threads: usize, size: u32) {
    let native = if cfg!(target_feature = "avx2") { ", all compiled for AVX2 or more" } else { "" };
    println!(
        "{}; up to {:.2} GHz; {threads} thread{}; {size} x {size} pixels{native}",
        cpu(),
        fastest,
        if threads == 1 { "" } else { "s" },
    );
}

/// Prints one cell of the table: the results of all engines for one scene and one kind of ray.
pub fn table(rows: &[Row]) {
    let Some(first) = rows.first() else { return };
    println!(
        "\n{} ({} triangles), {}: {} rays; {} compared with the reference, {} differ",
        first.scene,
        grouped(first.triangles),
        first.kind,
        grouped(first.rays),
        grouped(first.reference),
        first.reference_wrong,
    );
    println!(
        "{:22} {:>8} {:>15} {:>7} {:>13} {:>9} {:>9} {:>8}",
        "", "M rays/s", "(p10 - p90)", "ratio", "(p10 - p90)", "hit/miss", "triangle", "times",
    );
    for row in rows {
        let [low, middle, high] = row.speed;
        let ratio = row.ratio.map_or_else(String::new, |[low, middle, high]| {
            format!("{middle:7.2} {:>13}", format!("({low:.2} - {high:.2})"))
        });
        println!(
            "{:22} {middle:8.2} {:>15} {ratio:21} {:9} {:9} {:>8}",
            row.engine,
            format!("({low:.2} - {high:.2})"),
            row.wrong_hits,
            row.wrong_triangles,
            format!("{}/{}", row.repeats, row.repeats + row.dips),
        );
    }
    let mut bases: Vec<&str> = Vec::new();
    for row in rows {
        if !row.base.is_empty() && !bases.contains(&row.base.as_str()) {
            bases.push(&row.base);
        }
    }
    if !bases.is_empty() {
        println!("ratio: times as fast as {}", bases.join(", "));
    }
}

/// Prints the heading of a scene's builds.
pub fn builds(scene: &str, triangles: usize, threads: usize) {
    let threads = if threads == 0 { "all".into() } else { threads.to_string() };
    let s = if threads == "1" { "" } else { "s" };
    println!("\n{scene} ({} triangles), built by {threads} thread{s}", grouped(triangles));
}

/// Prints the time and the memory of a build.
pub fn build(builder: &str, built: &Built) {
    let megabytes = built.bytes as f64 / 1e6;
    println!("{builder:22} {:9.1} ms {megabytes:9.1} MB", built.milliseconds);
}

/// Prints the leaks at vertices or edges as a Markdown table, with a row per engine and a column
/// per mesh.
pub fn leaks(rows: &[&Leaks]) {
    let Some(first) = rows.first() else { return };
    let mut meshes: Vec<&Leaks> = Vec::new();
    let mut engines: Vec<&str> = Vec::new();
    for row in rows {
        if meshes.iter().all(|seen| seen.mesh != row.mesh) {
            meshes.push(row);
        }
        if !engines.contains(&row.engine.as_str()) {
            engines.push(&row.engine);
        }
    }
    println!("\nLeaks of {} rays aimed at {}:\n", grouped(first.rays), first.target);
    let line = |head: &str, cell: &dyn Fn(&Leaks) -> String| {
        let cells: Vec<_> = meshes.iter().map(|mesh| format!("{:>11}", cell(mesh))).collect();
        println!("| {head:22} | {} |", cells.join(" | "));
    };
    line("", &|mesh| mesh.mesh.clone());
    line("---", &|_| "---".into());
    line("triangles", &|mesh| grouped(mesh.triangles));
    line("aimed exactly", &|mesh| grouped(mesh.exact));
    for engine in engines {
        let of = |mesh: &str| rows.iter().find(|row| row.mesh == mesh && row.engine == engine);
        line(engine, &|mesh| of(&mesh.mesh).map_or_else(String::new, |row| grouped(row.leaks)));
    }
}

/// Prints the names that the options accept.
pub fn list() {
    println!("scenes: {}, sphere-N, growth, or a path", SCENES.join(", "));
    println!("closed meshes: {}", CLOSED.join(", "));
    println!("engines:");
    for (name, about) in ENGINES {
        println!("  {name:22} {about}");
    }
}

/// Prints one hostile case for all engines, with the ratio of each time to the plain case's time.
pub fn cliff(what: &str, rows: &[Row], plain: &[Row]) {
    println!("\n{what}");
    println!(
        "{:22} {:>9} {:>14} {:>9} {:>9}",
        "", "ns/ray", "times as long", "hit/miss", "triangle"
    );
    for row in rows {
        let nanoseconds = |row: &Row| 1e3 / row.speed[1];
        let beside = plain.iter().find(|plain| plain.engine == row.engine);
        let ratio = beside.map_or_else(String::new, |plain| {
            format!("{:.2}", nanoseconds(row) / nanoseconds(plain))
        });
        println!(
            "{:22} {:9.1} {ratio:>14} {:9} {:9}",
            row.engine,
            nanoseconds(row),
            row.wrong_hits,
            row.wrong_triangles,
        );
    }
}
