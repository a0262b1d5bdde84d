//! Divides the loops of a boundary into small ones, so that those far from a point can be skipped.
//!
//! ```text
//!    ·──▶──·──▶──·            ·──▶──·──▶──·
//!    ▲           ▼            ▲           ▼         ·─────▶─────·
//!    ·           ·     =      ·─────◀─────·    +    ▲           ▼
//!    ▲           ▼                                  ·─────◀─────·
//!    ·──◀──·──◀──·      pieces, each closed by a chord, and the loop of the chords, which is cut again
//! ```

use intertri::Scalar;

use crate::util::memory::{NoMemory, room};

/// Edges of a piece, without its chord.
const PIECE: usize = 8;

/// A margin above the rounding of a radius and of a length.
const ROOM: f64 = 1.0 + 1.0e-9;

/// Balls of other sizes are never skipped.
const SIZES: [f64; 2] = [1e-100, 1e100];

/// A loop, and a ball around its centre that contains it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// The range of its corners.
    pub(super) corners: [usize; 2],
    middle: [f64; 3],
    radius: f64,
    length: f64,
}

/// A boundary as small loops.
#[derive(Clone, Debug)]
pub(super) struct Parts<S> {
    pub(super) corners: Vec<[S; 3]>,
    pub(super) parts: Vec<Part>,
}

impl<S: Scalar> Parts<S> {
    pub(super) const NONE: Self = Self { corners: Vec::new(), parts: Vec::new() };

    /// The parts of loops; each loop repeats its first corner at its end.
    pub(super) fn of<'a>(
        loops: impl Iterator<Item = &'a [[S; 3]]> + Clone,
    ) -> Result<Self, NoMemory> {
        // Each level has an eighth of the pieces of the level below, with ten corners per piece.
        let mut all = Self {
            corners: room(loops.clone().map(|corners| 2 * corners.len() + 8).sum())?,
            parts: room(loops.clone().map(|corners| corners.len() / 7 + 8).sum())?,
        };
        let mut chords = room(loops.clone().map(<[_]>::len).max().unwrap_or(0))?;
        for corners in loops {
            chords.clear();
            chords.extend_from_slice(corners);
            while chords.len() > 2 * PIECE {
                let pieces = (chords.len() - 1).div_ceil(PIECE);
                for i in 0..pieces {
                    let (from, to) = (i * PIECE, (i * PIECE + PIECE).min(chords.len() - 1));
                    // A single edge and its chord cancel.
                    if to > from + 1 {
                        all.add(chords[from..=to].iter().copied().chain([chords[from]]));
                    }
                    chords[i] = chords[from];
                }
                chords[pieces] = chords[0];
                chords.truncate(pieces + 1);
            }
            all.add(chords.iter().copied());
        }
        Ok(all)
    }

    /// Adds a loop.
    fn add(&mut self, corners: impl Iterator<Item = [S; 3]>) {
        let start = self.corners.len();
        self.corners.extend(corners);
        let corners = &self.corners[start..];
        let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for corner in corners {
            for k in 0..3 {
                let x = corner[k].into();
                (lo[k], hi[k]) = (lo[k].min(x), hi[k].max(x));
            }
        }
        let middle = [0, 1, 2].map(|k| 0.5 * lo[k] + 0.5 * hi[k]);
        let apart = |a: [f64; 3], b: [f64; 3]| {
            [0, 1, 2].map(|k| (a[k] - b[k]) * (a[k] - b[k])).iter().sum::<f64>().sqrt()
        };
        let at = |corner: &[S; 3]| corner.map(Into::<f64>::into);
        let (mut radius, mut length) = (0.0_f64, 0.0);
        for pair in corners.windows(2) {
            radius = radius.max(apart(at(&pair[0]), middle));
            length += apart(at(&pair[0]), at(&pair[1]));
        }
        let corners = [start, self.corners.len()];
        self.parts.push(Part { corners, middle, radius: ROOM * radius, length: ROOM * length });
    }
}

impl Part {
    /// A bound on the solid angle of the loop seen from a point, relative to the sphere, if the ray from
    /// there passes its ball; infinite if it may not.
    #[inline(always)]
    pub(super) fn most(&self, point: [f64; 3], dir: [f64; 3]) -> f64 {
        let v = [0, 1, 2].map(|k| self.middle[k] - point[k]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (along, far) = (dot(v, dir), dot(v, v));
        // Rounding is far below a ten-thousandth of the distance.
        let radius = self.radius + 1e-4 * far.sqrt();
        let passes_by = along < 0.0 || far - along * along > radius * radius;
        let gap = far.sqrt() - radius;
        let is_tame = SIZES[0] < self.radius && far < SIZES[1] * SIZES[1];
        if passes_by && gap > 0.0 && is_tame {
            self.radius * self.length / (12.5 * gap * gap)
        } else {
            f64::INFINITY
        }
    }
}
