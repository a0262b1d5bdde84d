//! Joins the lists of answers that threads produce into one list in the order of the rays.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use bytemuck::Pod;

use crate::part::Part;

/// The output arrays, which are filled from the front.
pub(crate) struct Joined<'a, A>(Mutex<State<'a, A>>);

struct State<'a, A> {
    /// The unfilled part of the output offsets, where the answers of each ray end.
    offsets: &'a mut [i64],
    /// The unfilled part of the output answers, as 64-bit words.
    words: &'a mut [u64],
    /// The number of parts that already have a position.
    parts: usize,
    /// The number of answers that already have a position.
    answers: usize,
    /// Finished parts that wait for earlier parts, keyed by part number.
    waiting: BTreeMap<usize, Part<A>>,
    /// Parts that did not fit in the output arrays.
    more: Vec<Part<A>>,
    /// Cleared parts whose memory can be reused.
    idle: Vec<Part<A>>,
}

/// The position of a part in the output.
struct PartTarget<'a> {
    /// The number of answers before this part.
    before: i64,
    offsets: &'a mut [i64],
    words: &'a mut [u64],
}

impl<'a, A: Pod> Joined<'a, A> {
    pub(crate) fn new(offsets: &'a mut [i64], words: &'a mut [u64]) -> Self {
        Self(Mutex::new(State {
            offsets,
            words,
            parts: 0,
            answers: 0,
            waiting: BTreeMap::new(),
            more: Vec::new(),
            idle: Vec::new(),
        }))
    }

    fn lock(&self) -> MutexGuard<'_, State<'a, A>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns an empty part to fill.
    pub(crate) fn part(&self) -> Part<A> {
        self.lock().idle.pop().unwrap_or_else(Part::new)
    }

    /// Copies part `number`, and the parts that waited for it, to their positions in the output.
    pub(crate) fn put(&self, number: usize, part: Part<A>) {
        self.lock().waiting.insert(number, part);
        // The thread that determines a part's position also copies the part, in parallel with other
        // threads.
        while let Some((mut part, place)) = self.next() {
            place.words.copy_from_slice(bytemuck::cast_slice(&part.answers));
            put_ends(place.offsets, place.before, &part);
            part.clear();
            self.lock().idle.push(part);
        }
    }

    /// Returns the next finished part that has a position, and releases the lock.
    fn next(&self) -> Option<(Part<A>, PartTarget<'a>)> {
        self.lock().next()
    }

    /// Returns the number of answers in the output array, and the parts that did not fit.
    pub(crate) fn finish(self) -> (usize, Vec<Part<A>>) {
        let state = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        let left: usize = state.more.iter().map(|part| part.answers.len()).sum();
        (state.answers - left, state.more)
    }
}

impl<'a, A: Pod> State<'a, A> {
    /// Returns the next part that has arrived and fits in the output. Parts that do not fit go to
    /// `more`.
    fn next(&mut self) -> Option<(Part<A>, PartTarget<'a>)> {
        loop {
            let part = self.waiting.remove(&self.parts)?;
            self.parts += 1;
            let before = self.answers as i64;
            self.answers += part.answers.len();
            let offsets = self.offsets.split_off_mut(..part.rays())?;
            if self.more.is_empty()
                && let Some(words) = self.words.split_off_mut(..size_of_val(&part.answers[..]) / 8)
            {
                return Some((part, PartTarget { before, offsets, words }));
            }
            put_ends(offsets, before, &part);
            self.more.push(part);
        }
    }
}

/// Writes where the answers of each ray end, after the `before` answers of earlier parts.
fn put_ends<A>(to: &mut [i64], before: i64, part: &Part<A>) {
    to.iter_mut().zip(&part.offsets[1..]).for_each(|(to, end)| *to = before + end);
}
