//! Byte sources: memory that is read in place, and streams and files that are read through buffers.

#[cfg(unix)]
use std::fs::File;
use std::io::Read;

use super::error::LoadError;
#[cfg(unix)]
use crate::util::threads;

/// The number of bytes to read from a stream per call.
const PIECE: usize = 1 << 20;

/// A source of bytes.
pub trait Input {
    /// Returns the next `count` bytes.
    fn take(&mut self, count: usize) -> Result<&[u8], LoadError>;
    /// Returns the number of bytes that are certain to follow.
    fn known(&self) -> usize;
}

/// A source in memory.
pub(crate) struct Slice<'a> {
    left: &'a [u8],
}

impl<'a> Slice<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { left: bytes }
    }

    /// Returns an error if more bytes follow.
    pub(crate) fn end(self) -> Result<(), LoadError> {
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

/// A source that reads from a stream.
pub(crate) struct Stream<R> {
    from: R,
    buffer: Vec<u8>,
    known: usize,
}

impl<R: Read> Stream<R> {
    /// Creates a source from a stream that has at least `known` more bytes.
    pub(crate) fn new(from: R, known: usize) -> Self {
        Self { from, buffer: Vec::new(), known }
    }

    /// Returns an error if more bytes follow.
    pub(crate) fn end(mut self) -> Result<(), LoadError> {
        if self.from.read(&mut [0])? == 0 { Ok(()) } else { more() }
    }
}

impl<R: Read> Input for Stream<R> {
    fn take(&mut self, count: usize) -> Result<&[u8], LoadError> {
        // A damaged table may request any size, so grow the buffer piece by piece as data arrives.
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

/// A file of known size. All threads copy from it in parallel, out of the system's cache.
#[cfg(unix)]
pub(crate) struct Pieces {
    file: File,
    at: u64,
    size: u64,
    buffer: Vec<u8>,
}

#[cfg(unix)]
impl Pieces {
    /// The number of bytes that a thread copies per call.
    const EACH: usize = 1 << 18;

    pub(crate) fn new(file: File, size: u64) -> Self {
        Self { file, at: 0, size, buffer: Vec::new() }
    }

    /// Returns an error if more bytes follow.
    pub(crate) fn end(self) -> Result<(), LoadError> {
        use std::os::unix::fs::FileExt;
        if self.file.read_at(&mut [0], self.at)? == 0 { Ok(()) } else { more() }
    }
}

#[cfg(unix)]
impl Input for Pieces {
    fn take(&mut self, count: usize) -> Result<&[u8], LoadError> {
        use std::os::unix::fs::FileExt;
        if count > self.known() {
            return Err(LoadError::CutOff);
        }
        // The file size is known, so `count` never exceeds the number of bytes left in the file.
        if self.buffer.len() < count {
            let more = count - self.buffer.len();
            self.buffer.try_reserve(more).map_err(|_| LoadError::OutOfMemory)?;
            self.buffer.resize(count, 0);
        }
        let (file, at, buffer) = (&self.file, self.at, &mut self.buffer[..count]);
        threads::fill(buffer, Self::EACH, |i, to| {
            // Positioned reads share no cursor, so the threads need no lock.
            file.read_exact_at(to, at + (i * Self::EACH) as u64)
        })?;
        self.at += count as u64;
        Ok(buffer)
    }

    fn known(&self) -> usize {
        usize::try_from(self.size - self.at).unwrap_or(usize::MAX)
    }
}

fn more() -> Result<(), LoadError> {
    LoadError::damaged("it is followed by more bytes")
}
