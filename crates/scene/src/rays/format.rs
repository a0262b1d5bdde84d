//! The format of a file of rays.

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
    /// A line of column names, in any order: `ox`, `oy`, `oz`, `dx`, `dy`, `dz` and, where wanted,
    /// `t_min` (0) and `t_max` (inf); then a line a ray. A number is the f64 nearest to its
    /// decimal; `inf` and `nan` are numbers too.
    Csv,
    /// Eight little-endian f32 a ray: origin x y z, `t_min`, dir x y z, `t_max`.
    Raw,
    /// The same as f64.
    Raw64,
}

impl RaysFormat {
    /// The format that the ending of a name promises: `.csv`, `.f32` or `.f64`.
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
