//! Files of rays, raw or CSV, read piece by piece.
//!
//! - **Raw**: little-endian f32, eight a ray: origin x y z, `t_min`, dir x y z, `t_max`.
//! - **CSV**: a first line of column names, in any order: `ox`, `oy`, `oz`, `dx`, `dy`, `dz` and,
//!   where wanted, `t_min` (0) and `t_max` (inf). Numbers are rounded to f32; `inf` and `nan` are
//!   numbers too.
//!
//! A file is CSV if its first line is printable ASCII. The zero bytes of numbers such as 0 and
//! infinity are not, nor is any ray with one of them.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use intertri::Ray;

use crate::LoadError;

type Result<T> = std::result::Result<T, LoadError>;

/// No line of eight numbers is longer, so that a file without line ends sizes nothing.
const MAX_LINE: usize = 4096;

/// Bytes of a raw ray.
const RAW: usize = size_of::<Ray>();

/// Rays for which there is room beyond those that have come.
const PIECE: usize = 1 << 16;

/// The columns' names, in the order of a raw ray.
const COLUMNS: [&str; 8] = ["ox", "oy", "oz", "t_min", "dx", "dy", "dz", "t_max"];

/// A stream of rays, from a file or any reader, in bounded memory.
///
/// ```
/// let mut file = intertri_scene::Rays::new("a.csv", &b"ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n"[..], None)?;
/// let mut rays = Vec::new();
/// file.read(&mut rays, 100)?;
/// assert_eq!(rays, [intertri::Ray::new([0.0; 3], [0.0, 0.0, 1.0])]);
/// # Ok::<_, intertri_scene::LoadError>(())
/// ```
pub struct Rays<'a> {
    name: PathBuf,
    input: Box<dyn BufRead + Send + 'a>,
    format: Format,
    total: Option<u64>,
}

enum Format {
    Raw,
    Csv {
        /// What each column of a line is: an index into [`COLUMNS`].
        columns: Vec<usize>,
        /// The number of the last line read.
        line: u64,
    },
}

impl<'a> Rays<'a> {
    /// Opens a file, or the standard input for `-`.
    ///
    /// # Errors
    /// If it cannot be opened, and as [`Rays::new`].
    pub fn open(path: &Path) -> Result<Self> {
        if path.as_os_str() == "-" {
            return Self::new("<stdin>", io::stdin(), None);
        }
        let wrong = |cause| LoadError { path: path.into(), line: None, cause };
        let unreadable = |cause: io::Error| wrong(format!("cannot read it: {cause}"));
        let metadata = std::fs::metadata(path).map_err(unreadable)?;
        if metadata.is_dir() {
            return Err(wrong("is a folder; give a file of rays".to_owned()));
        }
        let file = File::open(path).map_err(unreadable)?;
        Self::new(path, file, metadata.is_file().then_some(metadata.len()))
    }

    /// Begins to read what has a name for error messages, and so many bytes where that is known.
    ///
    /// # Errors
    /// If it cannot be read, its line of names is wrong, or its size is not that of whole rays.
    pub fn new(
        name: impl Into<PathBuf>,
        mut input: impl Read + Send + 'a,
        size: Option<u64>,
    ) -> Result<Self> {
        // What does its beginning look like?
        let name = name.into();
        let mut start = Vec::new();
        let read = input.by_ref().take(MAX_LINE as u64).read_to_end(&mut start);
        let csv = looks_like_csv(&start);
        let input = Box::new(BufReader::new(Cursor::new(start).chain(input)));

        let mut rays = Self { name, input, format: Format::Raw, total: None };
        read.map_err(|cause| rays.unreadable(&cause))?;
        if csv {
            rays.read_header()?;
        } else if let Some(size) = size {
            if size % RAW as u64 != 0 {
                return Err(rays.ragged(size));
            }
            rays.total = Some(size / RAW as u64);
        }
        Ok(rays)
    }

    /// How many there are, where the file's size says it.
    pub fn total(&self) -> Option<u64> {
        self.total
    }

    /// Up to `count` more rays into `rays`, whose memory is used again but not what is in it; none at the
    /// end of the file.
    ///
    /// # Errors
    /// If the file cannot be read, a line is not of numbers, or the last raw ray is cut off.
    pub fn read(&mut self, rays: &mut Vec<Ray>, count: usize) -> Result<()> {
        match self.format {
            Format::Raw => self.read_raw(rays, count),
            Format::Csv { .. } => self.read_csv(rays, count),
        }
    }

    /// A ray in memory is a raw ray: bytes are read to where they stay.
    fn read_raw(&mut self, rays: &mut Vec<Ray>, count: usize) -> Result<()> {
        let mut filled = 0;
        loop {
            // Memory grows with what comes, not with what was asked for.
            let room = count.min(filled / RAW + PIECE);
            if rays.len() < room {
                rays.resize(room, Ray::new([0.0; 3], [0.0; 3]));
            }
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut rays[..room]);
            match self.input.read(&mut bytes[filled..]) {
                Ok(0) => break,
                Ok(read) => filled += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(cause) => return Err(self.unreadable(&cause)),
            }
        }
        if !filled.is_multiple_of(RAW) {
            return Err(self.ragged(filled as u64));
        }
        rays.truncate(filled / RAW);
        for number in bytemuck::cast_slice_mut::<_, u32>(rays) {
            *number = u32::from_le(*number);
        }
        Ok(())
    }

    fn ragged(&self, size: u64) -> LoadError {
        let over = size % RAW as u64;
        self.wrong(format!(
            "{over} bytes follow the last whole ray; a raw ray is {RAW} bytes, eight little-endian \
             f32 (and CSV begins with a line of names)"
        ))
    }

    fn unreadable(&self, cause: &io::Error) -> LoadError {
        self.wrong(format!("cannot read it: {cause}"))
    }

    /// What is wrong here: in the line last read, if it has lines.
    fn wrong(&self, cause: String) -> LoadError {
        let line = match self.format {
            Format::Raw => None,
            Format::Csv { line, .. } => Some(line),
        };
        LoadError { path: self.name.clone(), line, cause }
    }

    fn read_csv(&mut self, rays: &mut Vec<Ray>, count: usize) -> Result<()> {
        rays.clear();
        let mut line = String::new();
        while rays.len() < count && self.next_line(&mut line)? {
            let Format::Csv { columns, .. } = &self.format else { unreachable!() };
            let cells: Vec<&str> = line.split(',').collect();
            if cells.len() != columns.len() {
                let (found, named) = (cells.len(), columns.len());
                return Err(
                    self.wrong(format!("{found} cells, but the first line names {named} columns"))
                );
            }
            let mut numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::INFINITY];
            for (&column, cell) in columns.iter().zip(cells) {
                numbers[column] = match number_of(cell) {
                    Ok(number) => number,
                    Err(why) => {
                        let cause = format!("{}: {} {why}", COLUMNS[column], quote(cell));
                        return Err(self.wrong(cause));
                    }
                };
            }
            rays.push(ray(numbers));
        }
        Ok(())
    }

    /// Reads the line of names.
    fn read_header(&mut self) -> Result<()> {
        self.format = Format::Csv { columns: Vec::new(), line: 0 };
        let mut line = String::new();
        self.next_line(&mut line)?;
        let at = |cause: String| self.wrong(cause);
        let mut columns = Vec::new();
        for name in line.split(',').map(|name| unquoted(name).to_ascii_lowercase()) {
            let known = COLUMNS.iter().position(|&column| column == name).ok_or_else(|| {
                at(format!(
                    "{} is no column of rays; name them {}",
                    quote(&name),
                    COLUMNS.join(",")
                ))
            })?;
            if columns.contains(&known) {
                return Err(at(format!("two columns are named {name}")));
            }
            columns.push(known);
        }
        let optional = |name: &str| name == "t_min" || name == "t_max";
        if let Some(missing) = (0..8).find(|&i| !columns.contains(&i) && !optional(COLUMNS[i])) {
            return Err(at(format!("no column is named {}", COLUMNS[missing])));
        }
        let Format::Csv { line, .. } = self.format else { unreachable!() };
        self.format = Format::Csv { columns, line };
        Ok(())
    }

    /// The next line that is not blank; false at the end of the file.
    fn next_line(&mut self, text: &mut String) -> Result<bool> {
        loop {
            text.clear();
            let read = self.input.by_ref().take(MAX_LINE as u64 + 1).read_line(text);
            if let Format::Csv { line, .. } = &mut self.format {
                *line += 1;
            }
            let at = |cause| Err(self.wrong(cause));
            match read {
                Ok(0) => return Ok(false),
                Ok(length) if length > MAX_LINE => {
                    return at(format!("a line of more than {MAX_LINE} bytes; is it CSV?"));
                }
                Ok(_) if text.trim().is_empty() => {}
                Ok(_) => return Ok(true),
                Err(error) if error.kind() == io::ErrorKind::InvalidData => {
                    return at("is not text, though the file begins as CSV".to_owned());
                }
                Err(cause) => return at(format!("cannot read it: {cause}")),
            }
        }
    }
}

/// Whether the first line is printable ASCII, and there is something in it.
fn looks_like_csv(start: &[u8]) -> bool {
    let line = start.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let printable = |&byte: &u8| matches!(byte, b' '..=b'~' | b'\t' | b'\r');
    !line.is_empty() && line.iter().all(printable)
}

/// A ray from the numbers in the order of [`COLUMNS`].
fn ray([ox, oy, oz, t_min, dx, dy, dz, t_max]: [f32; 8]) -> Ray {
    Ray::new([ox, oy, oz], [dx, dy, dz]).between(t_min, t_max)
}

/// A cell as a number.
fn number_of(cell: &str) -> std::result::Result<f32, &'static str> {
    let cell = unquoted(cell);
    let number: f32 = cell.parse().map_err(|_| "is not a number")?;
    // Infinity is welcome where it is meant.
    if number.is_infinite() && cell.contains(|c: char| c.is_ascii_digit()) {
        return Err("is beyond the range of f32");
    }
    Ok(number)
}

/// A cell without the blanks and quotes around it.
fn unquoted(cell: &str) -> &str {
    cell.trim().trim_matches('"').trim()
}

/// A cell for an error message, not too long.
fn quote(cell: &str) -> String {
    let cell = unquoted(cell);
    let short: String = cell.chars().take(32).collect();
    format!("{short:?}{}", if short.len() < cell.len() { "..." } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_f32_and_infinity_must_be_meant() {
        assert_eq!(number_of(" 1e-3 "), Ok(1e-3));
        assert_eq!(number_of("\"-inf\""), Ok(f32::NEG_INFINITY));
        assert!(number_of("NaN").unwrap().is_nan());
        assert_eq!(number_of("0.1").unwrap().to_bits(), 0.1f32.to_bits());
        assert!(number_of("1e39").is_err());
        assert!(number_of("").is_err() && number_of("1;2").is_err());
    }

    #[test]
    fn rays_are_not_taken_for_text() {
        assert!(looks_like_csv(b"ox,oy,oz,dx,dy,dz\n1"));
        assert!(looks_like_csv(b"hello"));
        assert!(!looks_like_csv(b""));
        let raw = [40.1_f32, 12.5, 7.0, 0.0, 0.3, 0.4, 0.5, f32::INFINITY].map(f32::to_le_bytes);
        assert!(!looks_like_csv(raw.as_flattened()));
    }
}
