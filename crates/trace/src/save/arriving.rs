//! Memory for the records of a section while they are being read.

use bytemuck::Zeroable;

use super::format::Entry;
use super::input::Input;
use crate::util::memory::{NoMemory, zeros};

/// Storage for the records of a section. If all records are certain to follow, memory for them is
/// allocated at once, so that each thread is the first to touch its own pages. Otherwise, the
/// memory grows as records arrive.
pub(super) struct ArrivingRecords<T> {
    all: Vec<T>,
    done: usize,
}

impl<T: Zeroable + Clone> ArrivingRecords<T> {
    pub(super) fn of(input: &dyn Input, entry: &Entry) -> Result<Self, NoMemory> {
        let there = input.known() as u64 >= entry.size;
        // Allocate all memory at once if the input is known to be long enough. Otherwise, let it
        // grow as data arrives.
        let count = if there { entry.count() } else { 0 };
        Ok(Self { all: zeros(count)?.into_vec(), done: 0 })
    }

    /// Returns the slots for the next `count` records.
    pub(super) fn next(&mut self, count: usize) -> Result<&mut [T], NoMemory> {
        let end = self.done + count;
        if let Some(more) = end.checked_sub(self.all.len()) {
            self.all.try_reserve(more)?;
            self.all.resize(end, T::zeroed());
        }
        let next = &mut self.all[self.done..end];
        self.done = end;
        Ok(next)
    }

    /// Returns all records that have arrived.
    pub(super) fn all(self) -> Vec<T> {
        self.all
    }
}
