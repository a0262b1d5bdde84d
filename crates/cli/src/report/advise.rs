//! The report of `advise`, with its findings and its recommendation.

use std::fmt;
use std::path::PathBuf;

use intertri::Threshold;
use intertri_lab::advise::Needs;
use intertri_lab::tables::grouped;
use serde::Serialize;

use crate::engine::model::ModelNotes;
use crate::report::phrases::{model, significant};
use crate::report::rounding::Rounded;

/// The report of `advise`.
#[derive(Serialize)]
pub(crate) struct AdviseReport {
    pub(crate) model: Option<PathBuf>,
    /// Everything in the model that was omitted, repaired or guessed.
    pub(crate) notes: ModelNotes,
    pub(crate) rounded: Rounded,
    pub(crate) size: [u32; 2],
    /// The number of pixels that may be wrong.
    pub(crate) tolerance: u64,
    pub(crate) needs: Needs,
    /// The number of rays in the sample.
    pub(crate) sample: usize,
    /// The number of primary rays of the image, all of which were used to measure speeds.
    pub(crate) rays: usize,
    pub(crate) choices: Vec<Choice>,
    /// The name of the recommended choice, if any is within the tolerance.
    pub(crate) take: Option<String>,
    /// The recommended `Threshold`.
    pub(crate) threshold: f64,
    pub(crate) seconds: f64,
}

/// A choice and its effects.
#[derive(Clone, Serialize)]
pub(crate) struct Choice {
    pub(crate) name: String,
    /// The total number of bits of a vertex's three coordinates.
    pub(crate) bits_a_vertex: u32,
    /// The largest distance by which the visible surface moves, in pixels.
    pub(crate) pixels: f64,
    /// An upper bound on the number of wrong pixels in the frame.
    pub(crate) wrong_at_most: u64,
    /// An upper bound on the number of wrong pixels in the sample.
    pub(crate) wrong_in_sample_at_most: u64,
    /// The number of wrong pixels in the sample.
    pub(crate) wrong_in_sample: u64,
    /// Millions of primary rays per second, as measured by `bench`; null if no engine offers this
    /// choice.
    pub(crate) speed: Option<f64>,
    /// Whether the bound is within the tolerance.
    pub(crate) enough: bool,
}

impl fmt::Display for AdviseReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write_needs(f)?;
        self.write_choices(f)?;
        self.write_advice(f)
    }
}

impl AdviseReport {
    /// Writes the properties of the model and the image.
    fn write_needs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { needs, size: [width, height], .. } = self;
        writeln!(f, "{}, {width}x{height} pixels", model(self.model.as_deref()))?;
        self.rounded.write_line(f)?;
        let lines = [
            ("triangles", format!("{}, {} with zero area", needs.triangles, needs.degenerate)),
            ("extent", format!("{:.2e}, farthest coordinate {:.2e}", needs.extent, needs.offset)),
            (
                "smallest",
                format!(
                    "edge {:.1e}, altitude {:.1e}",
                    needs.shortest_edge, needs.smallest_altitude
                ),
            ),
            (
                "seen",
                format!(
                    "from {:.2e} to {:.2e} away, in {} pixels; a pixel is {:.1e} wide there",
                    needs.nearest, needs.farthest, needs.hits, needs.pixel
                ),
            ),
            (
                "grazing",
                format!("{:.2} % of hits, at angles below six degrees", needs.grazing * 100.0),
            ),
        ];
        for (what, text) in lines {
            writeln!(f, "{what:>10}  {text}")?;
        }
        Ok(())
    }

    /// Writes the table of choices, with the recommended one marked.
    fn write_choices(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sample = format!("of {} sampled", self.sample);
        writeln!(
            f,
            "\n{:16} {:>8} {:>9} {:>21} {:>27} {:>8}",
            "", "bits a", "moves by", "wrong pixels", sample, "million"
        )?;
        writeln!(
            f,
            "{:16} {:>8} {:>9} {:>21} {:>13} {:>13} {:>8}",
            "", "vertex", "pixels", "at most", "at most", "were wrong", "rays/s"
        )?;
        for choice in &self.choices {
            let speed = choice.speed.map_or(String::new(), significant);
            let mark = if Some(&choice.name) == self.take.as_ref() { "  <" } else { "" };
            writeln!(
                f,
                "{:16} {:>8} {:>9.1e} {:>21} {:>13} {:>13} {:>8}{mark}",
                choice.name,
                choice.bits_a_vertex,
                choice.pixels,
                choice.wrong_at_most,
                choice.wrong_in_sample_at_most,
                choice.wrong_in_sample,
                speed
            )?;
        }
        let rays = grouped(self.rays as u64);
        writeln!(
            f,
            "speeds: all {rays} primary rays tile by tile, on all threads, as bench measures them"
        )
    }

    /// Writes the recommended choice and threshold.
    fn write_advice(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let taken = self.choices.iter().find(|choice| Some(&choice.name) == self.take.as_ref());
        match (taken, self.tolerance) {
            (Some(Choice { name, wrong_at_most, .. }), tolerance) => {
                let bound = match wrong_at_most {
                    0 => "no pixel can be wrong".to_owned(),
                    1 => "at most 1 pixel can be wrong".to_owned(),
                    pixels => format!("at most {pixels} pixels can be wrong"),
                };
                let sure = match tolerance {
                    0 => "that".to_owned(),
                    pixels => format!("at most {pixels}"),
                };
                writeln!(f, "\ntake {name}: {bound}; nothing with fewer bits guarantees {sure}")?;
            }
            (None, 0) => writeln!(f, "\nno choice guarantees that no pixel is wrong")?,
            (None, pixels) => {
                writeln!(f, "\nno choice guarantees at most {pixels} wrong pixels")?;
            }
        }
        let needs = &self.needs;
        let default = Threshold::DEFAULT.get();
        write!(
            f,
            "threshold {:e}: no hit has |normal . direction| below {:.1e} or t below {:.1e}",
            self.threshold, needs.smallest_slope, needs.smallest_t
        )?;
        if needs.lost > 0 {
            write!(f, "; the default, {default:e}, would lose {} of them", needs.lost)?;
        }
        Ok(())
    }
}
