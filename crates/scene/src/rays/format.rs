//! The formats of ray files, and the file extensions that determine them.

use std::path::Path;

/// The format of a file of rays.
///
/// ```
/// use intertri_scene::RaysFormat;
/// assert_eq!(RaysFormat::of_name("a.f32".as_ref()), Some(RaysFormat::Raw));
/// assert_eq!(RaysFormat::of_name("a.CSV".as_ref()), Some(RaysFormat::Csv));
/// assert_eq!(RaysFormat::of_name("rays.bin".as_ref()), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RaysFormat {
    /// A line of column names, followed by one ray per line. The columns, in any order, are `ox`,
    /// `oy`, `oz`, `dx`, `dy`, `dz` and, optionally, `t_min` (default 0) and `t_max` (default inf).
    /// Decimals are read as the nearest f64; `inf` and `nan` are also allowed.
    Csv,
    /// Eight little-endian f32 values per ray: origin x y z, `t_min`, dir x y z, `t_max`.
    Raw,
    /// The layout of [`RaysFormat::Raw`], but with f64 values.
    Raw64,
}

impl RaysFormat {
    /// Returns the format for a file name with the extension `.csv`, `.f32`, or `.f64`.
    pub fn of_name(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_ascii_lowercase();
        match ending.to_str()? {
            "csv" => Some(Self::Csv),
            "f32" => Some(Self::Raw),
            "f64" => Some(Self::Raw64),
            _ => None,
        }
    }
}
