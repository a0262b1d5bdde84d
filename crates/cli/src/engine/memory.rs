//! Fallible allocation of the large tables that a model or an image needs.

use std::slice;

use intertri::{Crossing, Hit, RayOf};
use intertri_trace::{BvhScalar, Query};

use crate::error::{Error, Result};

/// Returns an empty list with capacity for `count` elements. If memory runs out, returns an error
/// that refers to the elements as `what`.
pub(crate) fn room<T>(count: usize, what: &str) -> Result<Vec<T>> {
    let mut list = Vec::new();
    let room = list.try_reserve_exact(count);
    room.map_err(|_| Error::no_memory(format_args!("{count} {what}")))?;
    Ok(list)
}

/// Returns a list with `count` copies of a value. If memory runs out, returns an error that refers
/// to the copies as `what`.
pub(crate) fn filled<T: Clone>(count: usize, value: T, what: &str) -> Result<Vec<T>> {
    let mut list = room(count, what)?;
    list.resize(count, value);
    Ok(list)
}

/// Returns every hit of one ray, or an error if memory runs out.
pub(crate) fn hits<S: BvhScalar>(query: Query<'_, S>, ray: &RayOf<S>) -> Result<Vec<Hit>> {
    Ok(query.on_this_thread().all_batch(slice::from_ref(ray), None)?.items)
}

/// Returns every crossing of one ray, or an error if memory runs out.
pub(crate) fn crossings<S: BvhScalar>(
    query: Query<'_, S>,
    ray: &RayOf<S>,
) -> Result<Vec<Crossing>> {
    Ok(query.on_this_thread().crossings_batch(slice::from_ref(ray), None)?.items)
}
