//! Where bytes come from: from memory, as they lie there, or from a stream, through one buffer.

use std::io::Read;

use super::error::LoadError;

/// So much of a stream is read at a time.
const PIECE: usize = 1 << 20;

/// Bytes, one piece after the other.
pub(super) trait Input {
    /// The next so many.
    fn take(&mut self, count: usize) -> Result<&[u8], LoadError>;
    /// So many are surely still to come.
    fn known(&self) -> usize;
}

/// Bytes in memory.
pub(super) struct Slice<'a> {
    left: &'a [u8],
}

impl<'a> Slice<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes }
    }

    /// Nothing may follow.
    pub(super) fn end(self) -> Result<(), LoadError> {
        if self.left.is_empty() { Ok(()) } else { more() }
    }
}

impl Input for Slice<'_> {
    fn take(&mut self, count: usize) -> Result<&[u8], LoadError> {
        let (next, left) = self.left.split_at_checked(count).ok_or(LoadError::CutOff)?;
        self.left = left;
        Ok(next)
    }

    fn known(&self) -> usize {
        self.left.len()
    }
}

/// Bytes of a stream.
pub(super) struct Stream<R> {
    from: R,
    buffer: Vec<u8>,
    known: usize,
}

impl<R: Read> Stream<R> {
    /// `known` of them are surely to come.
    pub(super) fn new(from: R, known: usize) -> Self {
        Self { from, buffer: Vec::new(), known }
    }

    /// Nothing may follow.
    pub(super) fn end(mut self) -> Result<(), LoadError> {
        if self.from.read(&mut [0])? == 0 { Ok(()) } else { more() }
    }
}

impl<R: Read> Input for Stream<R> {
    fn take(&mut self, count: usize) -> Result<&[u8], LoadError> {
        // The buffer grows with what arrives.
        let mut filled = 0;
        while filled < count {
            let end = count.min(filled + PIECE);
            if self.buffer.len() < end {
                let more = end - self.buffer.len();
                self.buffer.try_reserve(more).map_err(|_| LoadError::OutOfMemory)?;
                self.buffer.resize(end, 0);
            }
            self.from.read_exact(&mut self.buffer[filled..end])?;
            filled = end;
        }
        self.known = self.known.saturating_sub(count);
        Ok(&self.buffer[..count])
    }

    fn known(&self) -> usize {
        self.known
    }
}

fn more() -> Result<(), LoadError> {
    LoadError::damaged("something follows it")
}
