//! Memory that there may not be.

use std::collections::TryReserveError;

/// There is too little memory.
#[derive(Debug)]
pub(crate) struct NoMemory;

impl From<TryReserveError> for NoMemory {
    fn from(_: TryReserveError) -> Self {
        Self
    }
}

/// A vector with room for so many.
pub(crate) fn room<T>(count: usize) -> Result<Vec<T>, NoMemory> {
    let mut vector = Vec::new();
    vector.try_reserve_exact(count)?;
    Ok(vector)
}

/// Zeros, which the system gives without touching them.
pub(crate) fn zeros<T: bytemuck::Zeroable>(count: usize) -> Result<Box<[T]>, NoMemory> {
    bytemuck::allocation::try_zeroed_slice_box(count).map_err(|()| NoMemory)
}
