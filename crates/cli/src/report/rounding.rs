//! Counts of numbers that were rounded to a scalar.

use std::fmt;

use intertri_lab::tables::grouped;
use intertri_scene::Rounding;
use serde::{Serialize, Serializer};

/// The numbers of a model and of rays that were rounded to f32. Converting a decimal to the nearest
/// f64 does not count.
#[derive(Clone, Copy, Default, Serialize)]
pub(crate) struct Rounded {
    #[serde(serialize_with = "serialize")]
    pub(crate) model: Rounding,
    #[serde(serialize_with = "serialize")]
    pub(crate) rays: Rounding,
}

fn serialize<S: Serializer>(rounding: &Rounding, serializer: S) -> Result<S::Ok, S::Error> {
    use serde::ser::SerializeStruct;
    let mut both = serializer.serialize_struct("Rounding", 2)?;
    both.serialize_field("numbers", &rounding.numbers)?;
    both.serialize_field("by_up_to", &rounding.by_up_to)?;
    both.end()
}

impl Rounded {
    /// Returns the counts for a model without rays.
    pub(crate) fn of_model(model: Rounding) -> Self {
        Self { model, ..Self::default() }
    }

    pub(crate) fn is_nothing(self) -> bool {
        self.model.numbers == 0 && self.rays.numbers == 0
    }

    /// Writes a line of a report, unless nothing was rounded.
    pub(crate) fn write_line(self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [(self.model, "coordinates of the model"), (self.rays, "numbers of the rays")];
        for (rounding, what) in parts.into_iter().filter(|(rounding, _)| rounding.numbers > 0) {
            let (numbers, moved) = (grouped(rounding.numbers), rounding.by_up_to);
            writeln!(f, "{numbers:>12} {what} were rounded to f32, by up to {moved:.1e}")?;
        }
        Ok(())
    }
}

/// Writes all counts in one sentence.
impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, rays } = self;
        write!(
            f,
            "{} coordinates of the model and {} numbers of the rays were rounded to f32, by up to {:.1e}",
            model.numbers,
            rays.numbers,
            model.by_up_to.max(rays.by_up_to)
        )
    }
}
