//! Saves and loads the hierarchy.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use super::Bvh;
#[cfg(unix)]
use crate::save::Pieces;
use crate::save::{Bytes, Input, LoadError, Slice, Stream};
use crate::scalar::BvhScalar;

impl<S: BvhScalar> Bvh<S> {
    /// Serializes the hierarchy for [`Bvh::from_bytes`]. The bytes are the same on every CPU and
    /// with any number of threads.
    ///
    /// The bytes contain the finite triangles, their indices, and the tree: 60 to 90 bytes per
    /// triangle in f32.
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
        self.try_to_bytes().expect("not enough memory to save the hierarchy")
    }

    /// Like [`Bvh::to_bytes`], but returns an error if memory runs out.
    #[doc(hidden)]
    pub fn try_to_bytes(&self) -> io::Result<Vec<u8>> {
        let mut bytes = Bytes(Vec::new());
        self.write_to(&mut bytes)?;
        Ok(bytes.0)
    }

    /// Writes the bytes of [`Bvh::to_bytes`] piece by piece.
    ///
    /// # Errors
    /// Returns an error if writing fails.
    pub fn write_to(&self, mut output: impl Write) -> io::Result<()> {
        S::write(&self.tree, &self.originals, &mut output)
    }

    /// Loads a saved hierarchy.
    ///
    /// Any input yields either an error or a sound hierarchy: all children, indices, and boxes are
    /// checked. An attacker who fixes up the checksums can remove or replace triangles, but cannot
    /// make a query miss a stored one. The checksums detect damage; they are not a signature.
    ///
    /// # Errors
    /// Returns an error if the bytes are not a saved hierarchy; are damaged, truncated, or followed
    /// by more bytes; were written by a later version or in version 1 of the format
    /// ([`LoadError::Older`]); need more memory than is available; or store coordinates of the
    /// other scalar type ([`LoadError::Scalar`]).
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, LoadError> {
        let mut input = Slice::new(bytes);
        let bvh = Self::read(&mut input)?;
        input.end()?;
        Ok(bvh)
    }

    /// Reads a hierarchy, leaving any bytes after it unread.
    pub(crate) fn read(input: &mut dyn Input) -> Result<Self, LoadError> {
        let (tree, originals) = S::read(input)?;
        Ok(Self::of_parts(tree, originals))
    }

    /// Like [`Bvh::from_bytes`], but reads from a stream. Bytes after the hierarchy are not read.
    /// Memory use grows with the bytes that arrive, whatever the header claims. The function
    /// already reads in large pieces, so a buffered reader does not help.
    ///
    /// # Errors
    /// Returns the same errors as [`Bvh::from_bytes`], and an error if the stream cannot be read.
    /// Bytes after the hierarchy are not an error.
    pub fn read_from(input: impl Read) -> Result<Self, LoadError> {
        let (tree, originals) = S::read(&mut Stream::new(input, 0))?;
        Ok(Self::of_parts(tree, originals))
    }

    /// Like [`Bvh::from_bytes`], but reads from a file.
    ///
    /// # Errors
    /// Returns the same errors as [`Bvh::from_bytes`], and an error if the file cannot be read.
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
        // Read the file as a stream if it is a pipe or device, or if the system lacks positioned
        // reads.
        let size = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
        let mut input = Stream::new(file, size);
        let (tree, originals) = S::read(&mut input)?;
        input.end()?;
        Ok(Self::of_parts(tree, originals))
    }
}
