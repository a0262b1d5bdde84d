//! Reads giant and hostile files one by one, and measures the processor time and memory that each
//! takes.
//!
//! ```sh
//! cargo run --release -p intertri-scene --example hostile -- FOLDER   # writes some 8 GB, one file at a time
//! ```
//!
//! The output is a table for `docs/fuzzing.md`. Each file is read by a separate process, whose peak
//! memory Linux reports in `/proc`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::process::Command;

type Writer<'a> = &'a mut dyn Write;

const V: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const MILLION: u64 = 1_000_000;

/// A file name, a description, and the function that writes the file.
type Case = (&'static str, &'static str, fn(Writer<'_>) -> io::Result<()>);

const CASES: &[Case] = &[
    ("faces-1.obj", "1,250,000 tiny faces", |out| faces(out, 1_250_000)),
    ("faces-2.obj", "2,500,000 tiny faces", |out| faces(out, 2_500_000)),
    ("faces-4.obj", "5,000,000 tiny faces", |out| faces(out, 5 * MILLION)),
    ("faces-8.obj", "10,000,000 tiny faces", |out| faces(out, 10 * MILLION)),
    ("faces.ply", "10,000,000 tiny faces, ascii", |out| {
        ply(out, "ascii", 3, 10 * MILLION)?;
        out.write_all(b"0 0 0\n1 0 0\n0 1 0\n")?;
        repeat(out, b"3 0 1 2\n", 10 * MILLION)
    }),
    ("faces-b.ply", "10,000,000 tiny faces, binary", |out| {
        ply(out, "binary_little_endian", 3, 10 * MILLION)?;
        out.write_all(&[0; 36])?;
        repeat(out, &[3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0], 10 * MILLION)
    }),
    ("faces.stl", "10,000,000 tiny facets, binary", |out| {
        out.write_all(&[0; 80])?;
        out.write_all(&(10 * MILLION as u32).to_le_bytes())?;
        repeat(out, &[0; 50], 10 * MILLION)
    }),
    ("facets.stl", "10,000,000 tiny facets, ascii", |out| {
        out.write_all(b"solid\n")?;
        let facet = b"facet\nouter\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
        repeat(out, facet, 10 * MILLION)?;
        out.write_all(b"endsolid\n")
    }),
    ("polygon.obj", "one face of 100,000 corners", |out| {
        out.write_all(V)?;
        out.write_all(b"f")?;
        repeat(out, b" 1 2 3 1", 25_000)
    }),
    ("line.obj", "a gigabyte in one line: a face", |out| {
        out.write_all(V)?;
        out.write_all(b"f")?;
        repeat(out, b" 1 2 3 1", 128 * MILLION)
    }),
    ("comment.obj", "a gigabyte in one line: a comment", |out| {
        out.write_all(V)?;
        out.write_all(b"f 1 2 3\n#")?;
        repeat(out, b"########", 128 * MILLION)
    }),
    ("joined.obj", "a gigabyte in one line, joined by backslashes", |out| {
        out.write_all(V)?;
        out.write_all(b"f")?;
        repeat(out, b" 1 2 3\\\n", 128 * MILLION)
    }),
    ("line.ply", "a gigabyte in one line: a vertex", |out| {
        ply(out, "ascii", 3, 1)?;
        repeat(out, b"0.5 0.5 ", 128 * MILLION)
    }),
    ("header.ply", "a gigabyte in one line: a comment of the header", |out| {
        out.write_all(b"ply\ncomment ")?;
        repeat(out, b"comment ", 128 * MILLION)
    }),
    ("line.stl", "a gigabyte in one line: a name", |out| {
        out.write_all(b"solid ")?;
        repeat(out, b"namename", 128 * MILLION)
    }),
    ("lines.stl", "500,000,000 lines of one letter", |out| {
        out.write_all(b"solid\n")?;
        repeat(out, b"a\n", 500 * MILLION)
    }),
    ("blank.obj", "112,000,000 blank lines", |out| repeat(out, b"\n\r\n\n\n\n\n\n", 16 * MILLION)),
    ("index.obj", "an index of 2^63", |out| {
        out.write_all(V)?;
        out.write_all(b"f 1 2 9223372036854775808\n")
    }),
    ("count.ply", "2^64 - 1 vertices promised", |out| ply(out, "binary_big_endian", u64::MAX, 1)),
    ("list.ply", "a list of 2^32 - 1 corners promised", |out| {
        out.write_all(
            b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty \
              float y\nproperty float z\nelement face 1\nproperty list uint int vertex_indices\n\
              end_header\n",
        )?;
        out.write_all(&[0; 12])?;
        out.write_all(&[255; 4])
    }),
    ("count.stl", "2^32 - 1 facets promised", |out| out.write_all(&[255; 134])),
];

fn repeat(out: Writer<'_>, bytes: &[u8], times: u64) -> io::Result<()> {
    (0..times).try_for_each(|_| out.write_all(bytes))
}

fn faces(out: Writer<'_>, count: u64) -> io::Result<()> {
    out.write_all(V)?;
    repeat(out, b"f 1 2 3\n", count)
}

fn ply(out: Writer<'_>, format: &str, vertices: u64, faces: u64) -> io::Result<()> {
    write!(
        out,
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float \
         y\nproperty float z\nelement face {faces}\nproperty list uint int vertex_indices\n\
         end_header\n"
    )
}

/// Reads a file and prints the result as a table row.
fn read(path: &Path) {
    let said = match intertri_scene::load(path) {
        Ok(mesh) => format!("{} triangles", mesh.triangles.len()),
        Err(error) => error.to_string().replace(&format!("{}:", path.display()), ""),
    };
    // Processor time does not depend on the load on the machine.
    let schedule = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    let on_cpu = schedule.split(' ').next().and_then(|ns| ns.parse::<f64>().ok());
    let seconds = on_cpu.unwrap_or(f64::NAN) / 1e9;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.strip_suffix("kB"));
    let peak = peak.and_then(|kb| kb.trim().parse::<f64>().ok()).unwrap_or(f64::NAN) / 1000.0;
    println!("{seconds:.2} s | {peak:.0} MB | {} |", said.trim());
}

fn main() -> io::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = match &arguments[..] {
        [word, file] if word == "read" => {
            read(Path::new(file));
            return Ok(());
        }
        [folder] => Path::new(folder),
        _ => return Err(io::Error::other("give a folder for the files, about 1 GB each")),
    };
    println!(
        "| file | size | processor time | peak memory | result |\n| --- | --- | --- | --- | --- |"
    );
    for (name, what, write) in CASES {
        let path = folder.join(name);
        let mut out = BufWriter::with_capacity(1 << 20, File::create(&path)?);
        write(&mut out)?;
        out.flush()?;
        let size = path.metadata()?.len() as f64 / 1e6;
        let format = name.rsplit('.').next().unwrap_or_default().to_uppercase();
        print!("| {format}: {what} | {size:.1} MB | ");
        io::stdout().flush()?;
        Command::new(std::env::current_exe()?).arg("read").arg(&path).status()?;
        std::fs::remove_file(&path)?;
    }
    Ok(())
}
