//! Saves and loads the hierarchy.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use super::Bvh;
#[cfg(unix)]
use crate::save::Pieces;
use crate::save::{Input, LoadError, Slice, Stream};
use crate::scalar::BvhScalar;

impl<S: BvhScalar> Bvh<S> {
    /// The hierarchy as bytes, for [`Bvh::from_bytes`]: the same bytes on every CPU and for any number of
    /// threads.
    ///
    /// They contain the finite triangles, their numbers, and the tree: 60 to 90 bytes per triangle in f32.
    ///
    /// ```
    /// use intertri_trace::Bvh;
    /// use intertri_trace::intertri::{Ray, Triangle};
    /// let floor = Triangle::new([-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [-1.0, 0.0, 3.0]);
    /// let saved = Bvh::new(&[floor])?.to_bytes();
    /// let bvh: Bvh = Bvh::from_bytes(&saved)?;
    /// let hit = bvh.closest(&Ray::new([0.0, 2.0, 0.0], [0.0, -1.0, 0.0]));
    /// assert_eq!(hit.map(|hit| (hit.triangle, hit.t)), Some((0, 2.0)));
    /// assert!(Bvh::<f32>::from_bytes(&saved[..99]).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Panics
    /// Panics if memory runs out; [`Bvh::write_to`] returns an error instead.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.try_to_bytes().expect("memory for a saved hierarchy")
    }

    /// [`Bvh::to_bytes`], or an error if there is too little memory.
    #[doc(hidden)]
    pub fn try_to_bytes(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Bytes(Vec::new());
        self.write_to(&mut bytes)?;
        Ok(bytes.0)
    }

    /// Writes [`Bvh::to_bytes`] in pieces.
    ///
    /// # Errors
    /// Fails if they cannot be written.
    pub fn write_to(&self, mut output: impl Write) -> io::Result<()> {
        S::write(&self.tree, &self.originals, &mut output)
    }

    /// Loads a saved hierarchy.
    ///
    /// Any bytes yield an error or a sound hierarchy: every child, number and box is checked against its
    /// contents. An attacker who fixes up the checksums can remove or replace triangles, but cannot make a
    /// query miss a stored one. The checksums detect damage; they are not a signature.
    ///
    /// # Errors
    /// Fails if the bytes are not a saved hierarchy, are damaged, truncated or followed by more bytes, were
    /// written by a later version, need more memory than is available, or have coordinates of the other
    /// scalar ([`LoadError::Scalar`]).
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, LoadError> {
        let mut input = Slice::new(bytes);
        let bvh = Self::read(&mut input)?;
        input.end()?;
        Ok(bvh)
    }

    /// Reads a hierarchy, and nothing after it.
    pub(crate) fn read(input: &mut dyn Input) -> Result<Self, LoadError> {
        let (tree, originals) = S::read(input)?;
        Ok(Self::of_parts(tree, originals))
    }

    /// [`Bvh::from_bytes`] from a stream. Bytes after the hierarchy are not read. Memory grows with the bytes
    /// that arrive, whatever the header claims. It reads large pieces, so a buffered reader does not help.
    ///
    /// # Errors
    /// As for [`Bvh::from_bytes`]; also fails if the stream cannot be read.
    pub fn read_from(input: impl Read) -> Result<Self, LoadError> {
        let (tree, originals) = S::read(&mut Stream::new(input, 0))?;
        Ok(Self::of_parts(tree, originals))
    }

    /// [`Bvh::from_bytes`] from a file.
    ///
    /// # Errors
    /// As for [`Bvh::from_bytes`]; also fails if the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let file = File::open(path)?;
        let metadata = file.metadata()?;
        #[cfg(unix)]
        if metadata.is_file() {
            let mut input = Pieces::new(file, metadata.len());
            let (tree, originals) = S::read(&mut input)?;
            input.end()?;
            return Ok(Self::of_parts(tree, originals));
        }
        // A pipe or a device, or a system without positioned reads: read it as a stream.
        let size = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
        let mut input = Stream::new(file, size);
        let (tree, originals) = S::read(&mut input)?;
        input.end()?;
        Ok(Self::of_parts(tree, originals))
    }
}

/// Bytes that return an error if they cannot grow.
struct Bytes(Vec<u8>);

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.try_reserve(bytes.len()).map_err(|_| io::ErrorKind::OutOfMemory)?;
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
