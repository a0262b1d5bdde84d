//! The table of all methods.

use intertri::simd::Level;
use intertri::{Filter, Mode, Rule, Threshold};
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

/// Creates a row of the table for a method in one precision. `$method` creates the method from a
/// threshold.
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

/// Creates a row of the table for a kernel mode. `$mode` creates the mode from a threshold and a
/// level.
macro_rules! mode {
    ($name:literal, $mode:expr) => {
        mode!($name, $mode, |level, batch| {
            let make: fn(Threshold, Level) -> _ = $mode;
            let mode = make(Threshold::DEFAULT, level);
            batch.counts(|triangles, rays, to| kernel::pairs(mode, triangles, rays, to))
        })
    };
    ($name:literal, $mode:expr, $counts:expr) => {
        Method {
            name: $name,
            source: "the kernel",
            bits: 53,
            pairs: |level, threshold, triangles, rays, to| {
                let make: fn(Threshold, Level) -> _ = $mode;
                let mode = make(Threshold::new(threshold).unwrap_or_default(), level);
                kernel::pairs(mode, triangles, rays, to);
            },
            closest: |level, batches, layout, nearest| {
                let make: fn(Threshold, Level) -> _ = $mode;
                let mode = make(Threshold::DEFAULT, level);
                kernel::closest(mode, level, batches, layout, nearest)
            },
            counts: $counts,
        }
    };
}

/// Creates a row of the table for a kernel mode that requires rays from one origin. `$filter`
/// creates the mode's filter from a threshold and a level.
macro_rules! one_origin {
    ($name:literal, $filter:expr) => {
        Method {
            name: $name,
            source: "the kernel, after document D",
            bits: 53,
            pairs: |level, threshold, triangles, rays, to| {
                let make: fn(Threshold, Level) -> _ = $filter;
                let filter = make(Threshold::new(threshold).unwrap_or_default(), level);
                one_origin::pairs(filter, triangles, rays, to);
            },
            closest: |level, batches, layout, nearest| {
                let make: fn(Threshold, Level) -> _ = $filter;
                one_origin::closest(make(Threshold::DEFAULT, level), batches, layout, nearest)
            },
            counts: |level, batch| {
                let make: fn(Threshold, Level) -> _ = $filter;
                let filter = make(Threshold::DEFAULT, level);
                batch.counts(|triangles, rays, to| one_origin::pairs(filter, triangles, rays, to))
            },
        }
    };
}

/// The methods that are guaranteed to match the scalar f64 reference bit for bit.
pub const OF_THE_REFERENCE: [&str; 3] = ["InterTri f64", "certified", "certified, one origin"];

/// The methods whose answers are exact for the coordinates as given.
pub const EXACT: [&str; 3] = ["exact", "exact, one origin", "exact, once"];

/// The `fixed` mode.
pub(crate) const FIXED: Method = Method {
    name: "fixed",
    source: "the kernel",
    bits: 53,
    pairs: |level, _, triangles, rays, to| fixed::pairs(level, triangles, rays, to),
    closest: fixed::closest,
    counts: fixed::counts,
};

/// Every method. All comparisons iterate over this table.
///
/// Document D's own test is one-sided and leaves one edge open; here it is two-sided and closed,
/// like all other methods.
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
    mode!("certified", |threshold, level| Mode::certified_with(threshold).at(level)),
    one_origin!("certified, one origin", Filter::certified),
    mode!("exact", |_, level| Mode::exact().at(level)),
    one_origin!("exact, one origin", |_, level| Filter::exact(Rule::Closed, level)),
    mode!("exact, once", |_, level| Mode::exact().at(level), |level, batch| {
        let crossings = |ray| Mode::once().at(level).all(&batch.triangles, ray).len() as u32;
        batch.rays.iter().map(crossings).collect()
    }),
    FIXED,
];
