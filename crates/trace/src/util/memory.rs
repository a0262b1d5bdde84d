//! Fallible allocation: functions that return an error if memory runs out.

use std::collections::TryReserveError;
use std::fmt;

/// The error returned if memory runs out.
#[derive(Debug)]
pub(crate) struct NoMemory;

impl From<TryReserveError> for NoMemory {
    fn from(_: TryReserveError) -> Self {
        Self
    }
}

/// The error returned if there is not enough memory for the hits found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfMemory;

impl fmt::Display for OutOfMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "too little memory for the hits: trace fewer rays at a time, or limit the hits of each",
        )
    }
}

impl std::error::Error for OutOfMemory {}

impl From<NoMemory> for OutOfMemory {
    fn from(NoMemory: NoMemory) -> Self {
        Self
    }
}

/// Returns an empty vector with the given capacity.
pub(crate) fn room<T>(count: usize) -> Result<Vec<T>, NoMemory> {
    let mut vector = Vec::new();
    vector.try_reserve_exact(count)?;
    Ok(vector)
}

/// Returns a vector of `count` copies of a value.
pub(crate) fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>, NoMemory> {
    let mut vector = room(count)?;
    vector.resize(count, value);
    Ok(vector)
}

/// Copies a slice to a vector.
pub(crate) fn copied<T: Clone>(all: &[T]) -> Result<Vec<T>, NoMemory> {
    let mut vector = room(all.len())?;
    vector.extend_from_slice(all);
    Ok(vector)
}

/// Returns a slice of zeros whose pages the system zeroes only when they are first touched.
pub(crate) fn zeros<T: bytemuck::Zeroable>(count: usize) -> Result<Box<[T]>, NoMemory> {
    // `vec![0; n]` would abort if memory ran out.
    bytemuck::allocation::try_zeroed_slice_box(count).map_err(|()| NoMemory)
}
