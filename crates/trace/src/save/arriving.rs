//! Records as they arrive.

use bytemuck::Zeroable;

use super::format::Entry;
use super::input::Input;
use crate::util::memory::{NoMemory, zeros};

/// Room for the records of a section: for all at once where they are surely there, for each thread touches its own
/// pages of it then; else room that grows with what arrives.
pub(super) struct Arriving<T> {
    all: Vec<T>,
    done: usize,
}

impl<T: Zeroable + Clone> Arriving<T> {
    pub(super) fn of(input: &dyn Input, entry: &Entry) -> Result<Self, NoMemory> {
        let there = input.known() as u64 >= entry.size;
        let count = if there { entry.count() } else { 0 };
        Ok(Self { all: zeros(count)?.into_vec(), done: 0 })
    }

    /// The places of the next so many.
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

    /// All that came.
    pub(super) fn all(self) -> Vec<T> {
        self.all
    }
}
