//! Reads rays from files and streams, piece by piece.

mod csv;
mod format;

use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use intertri::{Ray, Ray64, RayOf};

use self::csv::{COLUMNS, Columns, quote};
pub use self::format::RaysFormat;
use crate::LoadError;
use crate::coordinate::Coordinate;
use crate::line_end::{LineEnd, read_line};
use crate::rounding::Rounding;

type Result<T> = std::result::Result<T, LoadError>;

/// The maximum length of a line, which holds eight numbers. The limit bounds the memory that a file
/// without line ends can take.
const MAX_LINE: usize = 4096;

/// The number of bytes in a raw ray in f32.
const RAW: usize = size_of::<Ray>();
/// The number of bytes in a raw ray in f64.
const RAW64: usize = size_of::<Ray64>();

/// The number of bytes to read at a time, if available: a whole number of raw rays.
const PIECE: usize = 1 << 19;

/// A stream of rays from a file or any reader, read in bounded memory.
///
/// You choose the scalar in which to read the rays, f32 or f64. The numbers in the file are f32,
/// f64, or decimals, which are read as the nearest f64. Numbers that are not exact in your scalar
/// are rounded and counted ([`Rays::rounding`]).
///
/// ```
/// let mut file = intertri_scene::Rays::new("a.csv", &b"ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n"[..], None, None)?;
/// let mut rays = Vec::new();
/// file.read(&mut rays, 100)?;
/// assert_eq!(rays, [intertri::Ray::new([0.0; 3], [0.0, 0.0, 1.0])]);
/// # Ok::<_, intertri_scene::LoadError>(())
/// ```
pub struct Rays<'a> {
    name: PathBuf,
    input: BufReader<Box<dyn Read + Send + 'a>>,
    format: Format,
    /// In a text file, the number of the last line that was read.
    line: u64,
    /// The end of the last line.
    end: LineEnd,
    /// The number of rays that were read.
    count: u64,
    total: Option<u64>,
    rounding: Rounding,
}

enum Format {
    Csv(Columns),
    Raw,
    Raw64,
}

impl<'a> Rays<'a> {
    /// Opens a file, or standard input if `path` is `-`. The format is chosen as in [`Rays::new`].
    ///
    /// # Errors
    /// Returns an error if the file cannot be opened, or under the same conditions as
    /// [`Rays::new`].
    pub fn open(path: &Path, format: Option<RaysFormat>) -> Result<Self> {
        if path.as_os_str() == "-" {
            return Self::new("<stdin>", io::stdin(), None, format);
        }
        let wrong = |cause| LoadError { path: path.into(), line: None, cause };
        let unreadable = |cause: io::Error| wrong(format!("cannot read it: {cause}"));
        let metadata = std::fs::metadata(path).map_err(unreadable)?;
        if metadata.is_dir() {
            return Err(wrong("is a folder; give a file of rays".to_owned()));
        }
        let file = File::open(path).map_err(unreadable)?;
        Self::new(path, file, metadata.is_file().then_some(metadata.len()), format)
    }

    /// Starts reading an input. `name` is used in error messages, and `size` is the size in bytes
    /// if it is known.
    ///
    /// If `format` is `None`, the extension of `name` determines the format, as in
    /// [`RaysFormat::of_name`]. With any other extension, the input is CSV if its first non-blank
    /// line consists of column names. Anything else is an error, because any bytes could be raw
    /// rays.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read, its format is unknown, its line of column
    /// names is invalid, or its size is not a whole number of rays.
    pub fn new(
        name: impl Into<PathBuf>,
        input: impl Read + Send + 'a,
        size: Option<u64>,
        format: Option<RaysFormat>,
    ) -> Result<Self> {
        let name = name.into();
        let format = format.or_else(|| RaysFormat::of_name(&name));
        let input = BufReader::with_capacity(PIECE, Box::new(input) as Box<dyn Read + Send + 'a>);
        let mut rays = Self {
            name,
            input,
            format: Format::Raw,
            line: 0,
            end: LineEnd::default(),
            count: 0,
            total: None,
            rounding: Rounding::default(),
        };
        match format {
            Some(RaysFormat::Raw) => rays.expect(size, RAW)?,
            Some(RaysFormat::Raw64) => {
                rays.format = Format::Raw64;
                rays.expect(size, RAW64)?;
            }
            Some(RaysFormat::Csv) => rays.read_names(true)?,
            None => rays.read_names(false)?,
        }
        Ok(rays)
    }

    /// Returns the total number of rays, if it is known from the file's size.
    pub fn total(&self) -> Option<u64> {
        self.total
    }

    /// Returns whether the rays are stored in f32.
    pub fn are_f32(&self) -> bool {
        matches!(self.format, Format::Raw)
    }

    /// Returns how many numbers in the rays read so far were rounded, and by how much.
    pub fn rounding(&self) -> Rounding {
        self.rounding
    }

    /// Replaces the contents of `rays` with the next rays: at least one and at most `count`, or
    /// none at the end. Waits for the first ray, but not for the rays after it.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, a line contains something other than numbers, a
    /// number is beyond the range of the scalar, or the last raw ray is cut off.
    pub fn read<S: Coordinate>(&mut self, rays: &mut Vec<RayOf<S>>, count: usize) -> Result<()> {
        rays.clear();
        match self.format {
            Format::Raw => self.read_raw::<RAW, S>(rays, count, |bytes| {
                let numbers: [u32; 8] = bytemuck::pod_read_unaligned(bytes);
                ray_of(numbers.map(|bits| S::from(f32::from_bits(u32::from_le(bits)))))
            }),
            Format::Raw64 => self.read_raw64(rays, count),
            Format::Csv(_) => self.read_csv(rays, count),
        }?;
        self.count += rays.len() as u64;
        Ok(())
    }

    fn read_raw64<S: Coordinate>(&mut self, rays: &mut Vec<RayOf<S>>, count: usize) -> Result<()> {
        let (mut rounding, mut number, mut first) = (self.rounding, self.count, None);
        let read = self.read_raw::<RAW64, S>(rays, count, |bytes| {
            let bits: [u64; 8] = bytemuck::pod_read_unaligned(bytes);
            let numbers = bits.map(|bits| f64::from_bits(u64::from_le(bits)));
            let ray = rounded(numbers, &mut rounding).unwrap_or_else(|cause| {
                first.get_or_insert(format!("ray {number}: {cause}"));
                RayOf::new([S::ZERO; 3], [S::ZERO; 3])
            });
            number += 1;
            ray
        });
        self.rounding = rounding;
        // Report the first error, regardless of how many rays are read at a time.
        first.map_or(read, |cause| Err(self.wrong(cause)))
    }

    /// Computes the number of rays in a file of the given size. The result must be a whole number.
    fn expect(&mut self, size: Option<u64>, record: usize) -> Result<()> {
        if let Some(size) = size {
            if !size.is_multiple_of(record as u64) {
                return Err(self.ragged(size, record));
            }
            self.total = Some(size / record as u64);
        }
        Ok(())
    }

    /// Reads raw rays, each of which is a record of N bytes.
    fn read_raw<const N: usize, S: Coordinate>(
        &mut self,
        rays: &mut Vec<RayOf<S>>,
        count: usize,
        mut ray: impl FnMut(&[u8; N]) -> RayOf<S>,
    ) -> Result<()> {
        while rays.len() < count && (rays.is_empty() || self.input.buffer().len() >= N) {
            let there = match self.input.fill_buf() {
                Ok([]) => break,
                Ok(bytes) => bytes,
                Err(cause) if cause.kind() == ErrorKind::Interrupted => continue,
                Err(cause) => return Err(self.unreadable(&cause)),
            };
            let (records, _) = there.as_chunks::<N>();
            if records.is_empty() {
                // Only the beginning of a ray has arrived.
                let mut record = Vec::new();
                let read = self.input.by_ref().take(N as u64).read_to_end(&mut record);
                read.map_err(|cause| self.unreadable(&cause))?;
                let whole = record.as_slice().try_into();
                let whole = whole.map_err(|_| self.ragged(record.len() as u64, N))?;
                rays.push(ray(whole));
                continue;
            }
            let records = &records[..records.len().min(count - rays.len())];
            // Memory use grows with the number of rays that have arrived, not with the number
            // requested.
            if rays.try_reserve(records.len()).is_err() {
                return Err(self.no_memory());
            }
            rays.extend(records.iter().map(&mut ray));
            let read = records.len() * N;
            self.input.consume(read);
        }
        Ok(())
    }

    fn read_csv<S: Coordinate>(&mut self, rays: &mut Vec<RayOf<S>>, count: usize) -> Result<()> {
        let mut line = String::new();
        while rays.len() < count && (rays.is_empty() || self.end.has_line(self.input.buffer())) {
            if !self.next_line(&mut line)? {
                break;
            }
            if line.trim().is_empty() {
                continue;
            }
            let Format::Csv(columns) = &self.format else { unreachable!() };
            let numbers = columns.numbers(&line).map_err(|cause| self.wrong(cause))?;
            if rays.try_reserve(1).is_err() {
                return Err(self.no_memory());
            }
            let ray = rounded(numbers, &mut self.rounding).map_err(|cause| self.wrong(cause))?;
            rays.push(ray);
        }
        Ok(())
    }

    /// Reads the line of column names. If the format is not `certain`, only this line shows that
    /// the input is CSV.
    fn read_names(&mut self, certain: bool) -> Result<()> {
        let unknown = |rays: &Self, why: &str| LoadError {
            path: rays.name.clone(),
            line: None,
            cause: format!(
                "{why}; give the format with --rays-format csv, raw or raw64, or with a name that ends in .csv, \
                 .f32 or .f64"
            ),
        };
        let mut line = String::new();
        while line.trim().is_empty() {
            match self.next_line(&mut line) {
                Ok(true) => {}
                Ok(false) if certain => {
                    return Err(self.wrong("has no line of names; is it CSV?".to_owned()));
                }
                Ok(false) => return Err(unknown(self, "is empty")),
                Err(wrong) if certain => return Err(wrong),
                Err(_) => {
                    return Err(unknown(self, "does not begin with a line of names, as CSV does"));
                }
            }
        }
        if !certain && !Columns::are_named_by(&line) {
            let why = format!("{} does not name columns of rays, as CSV does", quote(&line));
            return Err(unknown(self, &why));
        }
        self.format = Format::Csv(Columns::of(&line).map_err(|cause| self.wrong(cause))?);
        Ok(())
    }

    /// Reads the next line. Returns false at the end of the file.
    fn next_line(&mut self, text: &mut String) -> Result<bool> {
        let mut line = std::mem::take(text).into_bytes();
        line.clear();
        let read = read_line(&mut self.input, &mut line, &mut self.end, MAX_LINE);
        self.line += 1;
        match read {
            Ok(false) => return Ok(false),
            Ok(true) if line.len() > MAX_LINE => {
                let cause = format!("a line of more than {MAX_LINE} bytes; is it CSV?");
                return Err(self.wrong(cause));
            }
            Ok(true) => {}
            Err(cause) => return Err(self.unreadable(&cause)),
        }
        *text = String::from_utf8(line)
            .map_err(|_| self.wrong("is not text; is it CSV?".to_owned()))?;
        // Some editors put a byte order mark at the beginning.
        if self.line == 1 && text.starts_with('\u{feff}') {
            text.remove(0);
        }
        Ok(true)
    }

    /// Returns the error for a final record that is cut off. A record consists of eight numbers.
    fn ragged(&self, size: u64, record: usize) -> LoadError {
        let over = size % record as u64;
        let bits = 8 * (record / 8);
        self.wrong(format!(
            "{over} bytes follow the last whole ray; a raw ray is {record} bytes, eight little-endian f{bits}"
        ))
    }

    fn unreadable(&self, cause: &io::Error) -> LoadError {
        self.wrong(format!("cannot read it: {cause}"))
    }

    fn no_memory(&self) -> LoadError {
        self.wrong("its rays need more memory than is available".to_owned())
    }

    /// Returns an error with this cause and, in a text file, the number of the last line.
    fn wrong(&self, cause: String) -> LoadError {
        LoadError { path: self.name.clone(), line: (self.line > 0).then_some(self.line), cause }
    }
}

/// Returns the ray with these eight numbers, in the order of a raw ray, or an error message if a
/// finite number is beyond the range of the scalar.
fn rounded<S: Coordinate>(
    numbers: [f64; 8],
    rounding: &mut Rounding,
) -> std::result::Result<RayOf<S>, String> {
    let rounded = numbers.map(|x| rounding.round(x));
    let beyond = |&i: &usize| numbers[i].is_finite() && !S::is_finite(rounded[i]);
    match (0..8).find(beyond) {
        None => Ok(ray_of(rounded)),
        Some(i) => {
            let (name, number) = (COLUMNS[i], numbers[i]);
            Err(format!("{name}: {number:e} is beyond the range of {}; trace it in f64", S::NAME))
        }
    }
}

/// Returns the ray with these eight numbers, in the order of a raw ray.
fn ray_of<S: Coordinate>([x, y, z, t_min, dx, dy, dz, t_max]: [S; 8]) -> RayOf<S> {
    RayOf::new([x, y, z], [dx, dy, dz]).between(t_min, t_max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reader that returns its pieces one at a time, like a slow pipe.
    struct Pieces<'a>(&'a [&'a [u8]]);

    impl Read for Pieces<'_> {
        fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
            let Some((piece, rest)) = self.0.split_first() else { return Ok(0) };
            to[..piece.len()].copy_from_slice(piece);
            self.0 = rest;
            Ok(piece.len())
        }
    }

    /// Returns the number of rays that each call reads.
    fn calls(pieces: &[&[u8]], format: RaysFormat) -> Vec<usize> {
        let mut file = Rays::new("pipe", Pieces(pieces), None, Some(format)).unwrap();
        let (mut rays, mut calls) = (Vec::<Ray>::new(), vec![]);
        loop {
            file.read(&mut rays, 100).unwrap();
            if rays.is_empty() {
                return calls;
            }
            calls.push(rays.len());
        }
    }

    #[test]
    fn what_has_come_is_not_held_back() {
        let bytes = [0; 6 * 64];
        let pieces = [&bytes[..64], &bytes[64..74], &bytes[74..130], &bytes[130..]];
        assert_eq!(calls(&pieces, RaysFormat::Raw64), [1, 1, 4]);
        assert_eq!(calls(&pieces, RaysFormat::Raw), [2, 2, 8]);
        let pieces =
            [&b"ox,oy,oz,dx"[..], b",dy,dz\n\n0,0,0,0,0,1\n0,0", b",0,0,0,1\n\n0,0,0,0,0,1"];
        assert_eq!(calls(&pieces, RaysFormat::Csv), [1, 1, 1]);
    }
}
