//! The table of all methods.

use intertri::{Certified, Double, Threshold};
use intertri_reference::THRESHOLD;

use super::badouel::Badouel;
use super::baldwin_weber::BaldwinWeber;
use super::closest::Closest;
use super::cramer::Cramer;
use super::embree::{EdgeForm, Robust};
use super::fixed;
use super::inter_tri::InterTri;
use super::kernel;
use super::method::Method;
use super::moller_trumbore::MollerTrumbore;
use super::one_origin;
use super::pairs::Pairs;
use super::pluecker::Pluecker;
use super::signed_volume::SignedVolume;
use super::woop::Woop;

/// A method in one precision as a row of the table. `$method` makes it from a threshold.
macro_rules! method {
    ($name:literal, $source:literal, $method:expr, f32) => {
        method!(@ $name, $source, $method, 24, false)
    };
    ($name:literal, $source:literal, $method:expr, f64) => {
        method!(@ $name, $source, $method, 53, true)
    };
    (@ $name:literal, $source:literal, $method:expr, $bits:literal, $double:literal) => {
        Method {
            name: $name,
            source: $source,
            bits: $bits,
            pairs: |level, threshold, triangles, rays, to| {
                let make: fn(f64) -> _ = $method;
                level.run(Pairs::<_, $double> { intersector: make(threshold), triangles, rays, to });
            },
            closest: |level, batches, layout, nearest| {
                let make: fn(f64) -> _ = $method;
                let work = Closest { intersector: make(THRESHOLD), batches, layout, nearest };
                work.run::<$double>(level)
            },
            counts: |level, batch| {
                let make: fn(f64) -> _ = $method;
                batch.counts(|triangles, rays, to| {
                    level.run(Pairs::<_, $double> { intersector: make(THRESHOLD), triangles, rays, to });
                })
            },
        }
    };
}

/// A mode of the kernel as a row of the table.
macro_rules! mode {
    ($name:literal, $mode:ident) => {
        Method {
            name: $name,
            source: "the kernel",
            bits: 53,
            pairs: |level, threshold, triangles, rays, to| {
                let threshold = Threshold::new(threshold).unwrap_or_default();
                kernel::pairs($mode::new(threshold).at(level), triangles, rays, to);
            },
            closest: |level, batches, layout, nearest| {
                kernel::closest($mode::default().at(level), level, batches, layout, nearest)
            },
            counts: |level, batch| {
                let mode = $mode::default().at(level);
                batch.counts(|triangles, rays, to| kernel::pairs(mode, triangles, rays, to))
            },
        }
    };
}

/// Those that promise the scalar f64 reference's answers, bit for bit.
pub const OF_THE_REFERENCE: [&str; 4] =
    ["InterTri f64", "double", "certified", "certified, one origin"];

/// Every method. Whatever compares methods iterates over this.
///
/// Document D's own test sees one side and leaves one edge open; here it is two-sided and closed, as
/// all the others are.
pub static METHODS: &[Method] = &[
    method!("InterTri f64", "document A", |threshold| InterTri { threshold }, f64),
    method!("InterTri f32", "document A", |threshold| InterTri { threshold }, f32),
    method!("Cramer f32", "document D, two-sided and closed", |_| Cramer, f32),
    method!("Cramer f64", "document D, two-sided and closed", |_| Cramer, f64),
    method!(
        "Möller–Trumbore f32",
        "Möller, Trumbore 1997",
        |_| MollerTrumbore { epsilon: 0.0 },
        f32
    ),
    method!(
        "Möller–Trumbore f64",
        "Möller, Trumbore 1997",
        |_| MollerTrumbore { epsilon: 0.0 },
        f64
    ),
    method!(
        "Möller–Trumbore ε f32",
        "Möller, Trumbore 1997",
        |_| MollerTrumbore { epsilon: 1e-6 },
        f32
    ),
    method!("Badouel f32", "Badouel 1990", |_| Badouel, f32),
    method!("Baldwin–Weber f32", "Baldwin, Weber 2016", |_| BaldwinWeber, f32),
    method!("Baldwin–Weber f64", "Baldwin, Weber 2016", |_| BaldwinWeber, f64),
    method!("Plücker f32", "Jones 2000", |_| Pluecker, f32),
    method!("signed volume f32", "Segura, Feito 2001", |_| SignedVolume, f32),
    method!("signed volume f64", "Segura, Feito 2001", |_| SignedVolume, f64),
    method!("Woop f32", "Woop, Benthin, Wald 2013", |_| Woop { fall_back: true }, f32),
    method!("Embree fast f32", "Wald et al. 2014", |_| EdgeForm, f32),
    method!("Embree robust f32", "Wald et al. 2014", |_| Robust, f32),
    mode!("double", Double),
    mode!("certified", Certified),
    Method {
        name: "certified, one origin",
        source: "the kernel, after document D",
        bits: 53,
        pairs: one_origin::pairs,
        closest: one_origin::closest,
        counts: |level, batch| {
            batch.counts(|triangles, rays, to| {
                one_origin::pairs(level, THRESHOLD, triangles, rays, to);
            })
        },
    },
    Method {
        name: "fixed",
        source: "the kernel",
        bits: 53,
        pairs: |level, _, triangles, rays, to| fixed::pairs(level, triangles, rays, to),
        closest: fixed::closest,
        counts: fixed::counts,
    },
];
