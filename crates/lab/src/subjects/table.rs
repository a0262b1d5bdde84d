//! The table of all subjects.

use intertri::lanes::Level;
use intertri::{Certified, Double, Ray, Threshold, Triangle};

use super::badouel::Badouel;
use super::baldwin_weber::BaldwinWeber;
use super::cramer::Cramer;
use super::embree::{EdgeForm, Robust};
use super::forms::{Answer, Bundle, Closest, Layout, Nearest, Pairs, Seconds};
use super::inter_tri::InterTri;
use super::kernel;
use super::moller_trumbore::MollerTrumbore;
use super::one_origin;
use super::pluecker::Pluecker;
use super::signed_volume::SignedVolume;
use super::woop::Woop;
use intertri_reference::THRESHOLD;

/// One method in one precision.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// The name by which it is called in tables and charts.
    pub name: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// The significant bits of what it computes in: 24 or 53.
    pub bits: u32,
    pairs: fn(Level, f64, &[Triangle], &[Ray], &mut [Answer]),
    closest: fn(Level, &[Bundle], Layout, &mut Vec<Nearest>) -> Option<Seconds>,
    counts: fn(Level, &Bundle) -> Vec<u32>,
}

impl Subject {
    /// Tests ray `i` against triangle `i`, eight pairs at a time, on the lanes of a level.
    ///
    /// `threshold` is document A's, finite and at least 0; methods without one ignore it. The
    /// intervals of the rays do not matter.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn pairs(
        &self,
        level: Level,
        threshold: f64,
        triangles: &[Triangle],
        rays: &[Ray],
        to: &mut [Answer],
    ) {
        assert!(triangles.len() == rays.len() && rays.len() == to.len(), "as many of each");
        (self.pairs)(level, threshold, triangles, rays, to);
    }

    /// Finds the closest hit of each ray in its bundle, bundle by bundle, and how many seconds that
    /// took without what is computed once for a triangle. `None`, and `nearest` as it was or empty,
    /// where the subject has no such layout: one lane of the kernel's modes is the reference, rays
    /// that do not share an origin are nothing for the form that wants it, and 16 lanes there are of
    /// f32 alone, where they are one register.
    ///
    /// `t_min` is 0 and `t_max` infinite for every ray.
    pub fn closest(
        &self,
        level: Level,
        bundles: &[Bundle],
        layout: Layout,
        nearest: &mut Vec<Nearest>,
    ) -> Option<Seconds> {
        (self.closest)(level, bundles, layout, nearest)
    }

    /// How many triangles of its bundle each ray hits; the intervals of the rays do not matter.
    pub fn counts(&self, level: Level, bundle: &Bundle) -> Vec<u32> {
        (self.counts)(level, bundle)
    }
}

/// A method in one precision as a row of the table. `$method` makes it from a threshold.
macro_rules! subject {
    ($name:literal, $source:literal, $method:expr, f32) => {
        subject!(@ $name, $source, $method, 24, false)
    };
    ($name:literal, $source:literal, $method:expr, f64) => {
        subject!(@ $name, $source, $method, 53, true)
    };
    (@ $name:literal, $source:literal, $method:expr, $bits:literal, $double:literal) => {
        Subject {
            name: $name,
            source: $source,
            bits: $bits,
            pairs: |level, threshold, triangles, rays, to| {
                let make: fn(f64) -> _ = $method;
                level.run(Pairs::<_, $double> { method: make(threshold), triangles, rays, to });
            },
            closest: |level, bundles, layout, nearest| {
                let make: fn(f64) -> _ = $method;
                let work = Closest { method: make(THRESHOLD), bundles, layout, nearest };
                work.run::<$double>(level)
            },
            counts: |level, bundle| {
                let make: fn(f64) -> _ = $method;
                bundle.counts(|triangles, rays, to| {
                    level.run(Pairs::<_, $double> { method: make(THRESHOLD), triangles, rays, to });
                })
            },
        }
    };
}

/// A mode of the kernel as a row of the table.
macro_rules! mode {
    ($name:literal, $mode:ident) => {
        Subject {
            name: $name,
            source: "the kernel",
            bits: 53,
            pairs: |level, threshold, triangles, rays, to| {
                let threshold = Threshold::new(threshold).unwrap_or_default();
                kernel::pairs($mode::new(threshold).at(level), triangles, rays, to);
            },
            closest: |level, bundles, layout, nearest| {
                kernel::closest($mode::default().at(level), level, bundles, layout, nearest)
            },
            counts: |level, bundle| {
                let mode = $mode::default().at(level);
                bundle.counts(|triangles, rays, to| kernel::pairs(mode, triangles, rays, to))
            },
        }
    };
}

/// Those that promise the scalar f64 reference's answers, bit for bit.
pub const OF_THE_REFERENCE: [&str; 4] =
    ["InterTri f64", "double", "certified", "certified, one origin"];

/// Every subject. Whatever compares methods iterates over this.
///
/// Document D's own test sees one side and leaves one edge open; here it is two-sided and closed, as
/// all the others are.
pub static SUBJECTS: &[Subject] = &[
    subject!("InterTri f64", "document A", |threshold| InterTri { threshold }, f64),
    subject!("InterTri f32", "document A", |threshold| InterTri { threshold }, f32),
    subject!("Cramer f32", "document D, two-sided and closed", |_| Cramer, f32),
    subject!("Cramer f64", "document D, two-sided and closed", |_| Cramer, f64),
    subject!(
        "Möller–Trumbore f32",
        "Möller, Trumbore 1997",
        |_| MollerTrumbore { epsilon: 0.0 },
        f32
    ),
    subject!(
        "Möller–Trumbore f64",
        "Möller, Trumbore 1997",
        |_| MollerTrumbore { epsilon: 0.0 },
        f64
    ),
    subject!(
        "Möller–Trumbore ε f32",
        "Möller, Trumbore 1997",
        |_| MollerTrumbore { epsilon: 1e-6 },
        f32
    ),
    subject!("Badouel f32", "Badouel 1990", |_| Badouel, f32),
    subject!("Baldwin–Weber f32", "Baldwin, Weber 2016", |_| BaldwinWeber, f32),
    subject!("Baldwin–Weber f64", "Baldwin, Weber 2016", |_| BaldwinWeber, f64),
    subject!("Plücker f32", "Jones 2000", |_| Pluecker, f32),
    subject!("signed volume f32", "Segura, Feito 2001", |_| SignedVolume, f32),
    subject!("signed volume f64", "Segura, Feito 2001", |_| SignedVolume, f64),
    subject!("Woop f32", "Woop, Benthin, Wald 2013", |_| Woop { fall_back: true }, f32),
    subject!("Embree fast f32", "Wald et al. 2014", |_| EdgeForm, f32),
    subject!("Embree robust f32", "Wald et al. 2014", |_| Robust, f32),
    mode!("double", Double),
    mode!("certified", Certified),
    Subject {
        name: "certified, one origin",
        source: "the kernel, after document D",
        bits: 53,
        pairs: one_origin::pairs,
        closest: one_origin::closest,
        counts: |level, bundle| {
            bundle.counts(|triangles, rays, to| {
                one_origin::pairs(level, THRESHOLD, triangles, rays, to);
            })
        },
    },
    Subject {
        name: "fixed",
        source: "the kernel",
        bits: 53,
        pairs: |level, _, triangles, rays, to| kernel::fixed_pairs(level, triangles, rays, to),
        closest: kernel::fixed_closest,
        counts: kernel::fixed_counts,
    },
];
