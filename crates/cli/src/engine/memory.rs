//! Memory that there may not be: for what a model or a picture has many of.

use std::slice;

use intertri::{Crossing, Hit, RayOf};
use intertri_trace::{BvhScalar, Query};

use crate::error::{Error, Result};

/// An empty list with capacity for `count` of `what`; an error if memory runs out.
pub(crate) fn room<T>(count: usize, what: &str) -> Result<Vec<T>> {
    let mut list = Vec::new();
    let room = list.try_reserve_exact(count);
    room.map_err(|_| Error::no_memory(format_args!("{count} {what}")))?;
    Ok(list)
}

/// A list of `count` times a value, of `what` the error speaks.
pub(crate) fn filled<T: Clone>(count: usize, value: T, what: &str) -> Result<Vec<T>> {
    let mut list = room(count, what)?;
    list.resize(count, value);
    Ok(list)
}

/// Every hit of one ray, or an error where there is too little memory for them.
pub(crate) fn hits<S: BvhScalar>(query: Query<'_, S>, ray: &RayOf<S>) -> Result<Vec<Hit>> {
    Ok(query.on_this_thread().all_batch(slice::from_ref(ray), None)?.items)
}

/// Every crossing of one ray, or an error where there is too little memory for them.
pub(crate) fn crossings<S: BvhScalar>(
    query: Query<'_, S>,
    ray: &RayOf<S>,
) -> Result<Vec<Crossing>> {
    Ok(query.on_this_thread().crossings_batch(slice::from_ref(ray), None)?.items)
}
