//! Implements bytemuck's traits for types that are generic over their scalar type, which bytemuck's
//! derives do not support.

use bytemuck::{Pod, Zeroable};

use crate::{RayOf, Scalar};

const _: () = assert!(size_of::<RayOf<f32>>() == 8 * size_of::<f32>());
const _: () = assert!(size_of::<RayOf<f64>>() == 8 * size_of::<f64>());

// SAFETY: all fields are scalars, for which zeros are valid.
#[allow(unsafe_code)]
unsafe impl<S: Scalar> Zeroable for RayOf<S> {}

// SAFETY: eight consecutive scalars of one type (`repr(C)`), so there is no padding; scalars are
// only f32 and f64, which are both `Pod`.
#[allow(unsafe_code)]
unsafe impl<S: Scalar> Pod for RayOf<S> {}
