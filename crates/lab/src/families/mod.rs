//! Families of rays and triangles, some ordinary and some designed to break a ray/triangle test.
//!
//! Most rays are *sensitive to rounding*: they are aimed in f64 at a vertex or a point on an edge,
//! rounded to f32, and moved by a few f32 steps. Because the coordinates have full mantissas, the
//! edge values cover every distance from 0 that an error bound could have. Families in which a ray
//! must meet a point exactly use small integers instead, which cannot test rounding.
//!
//! The generators use only integers, `+ - * /`, and square roots, so a seed yields the same bits on
//! every machine. If a family has a parameter, [`Family::param`] contains the parameter's range,
//! from harmless to harmful.
//!
//! ```
//! use intertri_lab::{families::FAMILIES, rng::Rng};
//! let mut rng = Rng::new(1);
//! for family in FAMILIES {
//!     let case = family.case(&mut rng);
//!     let scene = family.scene(&mut rng, 100, 10);
//!     assert_eq!(scene.rays.len(), 10);
//! }
//! ```

mod aim;
mod closed;
mod family;
mod limits;
mod ranges;
mod scene;
mod shapes;
mod table;

pub use family::{Family, Param};
pub use scene::{Case, Scene};
pub use table::{FAMILIES, adversarial, find};

#[cfg(test)]
mod tests;
