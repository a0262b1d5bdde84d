//! The casts of types that are generic over their scalar, which no derive can vouch for.

use bytemuck::{Pod, Zeroable};

use crate::{RayOf, Scalar};

const _: () = assert!(size_of::<RayOf<f32>>() == 8 * size_of::<f32>());
const _: () = assert!(size_of::<RayOf<f64>>() == 8 * size_of::<f64>());

// SAFETY: all fields are scalars, for which zeros are valid.
#[allow(unsafe_code)]
unsafe impl<S: Scalar> Zeroable for RayOf<S> {}

// SAFETY: eight scalars of one type in a row (`repr(C)`), so there is no padding; scalars are f32 and f64 alone,
// and each is `Pod`.
#[allow(unsafe_code)]
unsafe impl<S: Scalar> Pod for RayOf<S> {}
