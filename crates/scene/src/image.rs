//! Stores images in memory, reads PNG and JPEG files, and writes PNG files atomically.

use std::io::{self, BufWriter, IntoInnerError};
use std::path::{Path, PathBuf};
use std::{fmt, fs};

use ::image::codecs::png::PngEncoder;
use ::image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageReader};

use crate::PartialFile;

/// The maximum number of pixels in an image (8192×8192). At this size, the visibility buffer alone
/// takes 2 GiB.
pub const MAX_PIXELS: u64 = 1 << 26;

/// An image, stored row by row from the top, with three sRGB bytes per pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    /// Creates a black image.
    ///
    /// # Errors
    /// Returns an error under the same conditions as [`check_size`].
    pub fn new(width: u32, height: u32) -> Result<Self, ImageError> {
        let pixels = check_size(width, height)?;
        Ok(Self { width, height, pixels: vec![[0; 3]; pixels] })
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns all pixels. Pixel `(x, y)` is at index `y * width + x`.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// Returns all pixels, mutably.
    pub fn pixels_mut(&mut self) -> &mut [[u8; 3]] {
        &mut self.pixels
    }

    /// Reads a PNG or JPEG file, recognized by its first bytes. An alpha channel is dropped.
    ///
    /// # Errors
    /// Returns an error if the file does not exist or is in neither format, if a side is 0, or if
    /// there are more than [`MAX_PIXELS`] pixels.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let error = |cause: String| ImageError::Read { path: path.into(), cause };
        let metadata = fs::metadata(path).map_err(|cause| error(cause.to_string()))?;
        if !metadata.is_file() {
            return Err(error("is not a regular file; give a PNG or JPEG file".into()));
        }
        let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
        let reader = reader.map_err(|cause| error(cause.to_string()))?;
        let refused = |cause: ::image::ImageError| {
            // Keep only one line of the decoder's message.
            let cause = cause.to_string();
            error(format!("{}; give a PNG or JPEG file", cause.lines().next().unwrap_or_default()))
        };
        let decoder = reader.into_decoder().map_err(refused)?;
        let (width, height) = decoder.dimensions();
        check_size(width, height).map_err(|cause| error(cause.to_string()))?;
        let decoded = DynamicImage::from_decoder(decoder).map_err(refused)?.into_rgb8();
        let (pixels, _) = decoded.as_raw().as_chunks();
        Ok(Self { width, height, pixels: pixels.to_vec() })
    }

    /// Writes the image to `path` as PNG, either completely or not at all.
    ///
    /// The image is first written as a [`PartialFile`], so a file at `path` is complete even if the
    /// program is killed. After an error, an older image at `path` is unchanged.
    ///
    /// # Errors
    /// Returns an error under the same conditions as [`check_output`], or if the file cannot be
    /// written.
    pub fn write_png(&self, path: &Path) -> Result<(), ImageError> {
        check_output(path)?;
        let written = replace(path, |file| {
            let bytes = self.pixels.as_flattened();
            PngEncoder::new(file)
                .write_image(bytes, self.width, self.height, ExtendedColorType::Rgb8)
                .map_err(|error| match error {
                    ::image::ImageError::IoError(error) => error,
                    other => io::Error::other(other),
                })
        });
        written.map_err(|cause| ImageError::Write { path: path.into(), cause })
    }
}

/// Creates or replaces the file at `path` with the output of `write`, once the whole output is on
/// the disk. If writing fails, `path` is unchanged.
fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<PartialFile>) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = BufWriter::new(PartialFile::create(path)?);
    write(&mut file)?;
    let file = file.into_inner().map_err(IntoInnerError::into_error)?;
    file.sync()?;
    file.finish()
}

/// Returns the number of pixels in an image of the given size. Call this before allocating
/// anything.
///
/// # Errors
/// Returns an error if a side is 0 or there are more than [`MAX_PIXELS`] pixels.
pub fn check_size(width: u32, height: u32) -> Result<usize, ImageError> {
    let pixels = u64::from(width) * u64::from(height);
    match usize::try_from(pixels) {
        Ok(count) if pixels > 0 && pixels <= MAX_PIXELS => Ok(count),
        _ => Err(ImageError::Size { width, height }),
    }
}

/// Checks whether an image can probably be written to `path`. Call this before rendering.
///
/// # Errors
/// Returns an error if `path` does not end in `.png`, is a folder, or is in a folder that does not
/// exist.
pub fn check_output(path: &Path) -> Result<(), ImageError> {
    let error = |why| Err(ImageError::Output { path: path.into(), why });
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return error("a picture is written as PNG; give a name that ends in .png");
    }
    if path.is_dir() {
        return error("is a folder; give the name of a file");
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            error("its folder does not exist; create it or choose another")
        }
        _ => Ok(()),
    }
}

/// Returns an image that shows where two engines disagree: a darkened copy of `image` in which each
/// marked pixel has the colour in `marks` and a frame around it, so that even a single pixel is
/// easy to see.
///
/// # Panics
/// Panics if `marks` does not have one entry per pixel.
pub fn difference(image: &Image, marks: &[Option<[u8; 3]>]) -> Image {
    const FRAME: i64 = 4;
    assert_eq!(marks.len(), image.pixels.len(), "there must be one entry per pixel");
    let mut marked = image.clone();
    for pixel in &mut marked.pixels {
        *pixel = pixel.map(|x| x / 4);
    }
    let (width, height) = (i64::from(image.width), i64::from(image.height));
    let found = || marks.iter().enumerate().filter_map(|(i, mark)| Some((i, (*mark)?)));
    for (i, mark) in found() {
        let (x, y) = (i as i64 % width, i as i64 / width);
        for along in -FRAME..=FRAME {
            for (dx, dy) in [(along, -FRAME), (along, FRAME), (-FRAME, along), (FRAME, along)] {
                let (x, y) = (x + dx, y + dy);
                if (0..width).contains(&x) && (0..height).contains(&y) {
                    marked.pixels[(y * width + x) as usize] = mark.map(|x| x / 2);
                }
            }
        }
    }
    for (i, mark) in found() {
        marked.pixels[i] = mark;
    }
    marked
}

/// The reason that an image cannot be read or written.
#[derive(Debug)]
pub enum ImageError {
    /// A side is 0, or there are more than [`MAX_PIXELS`] pixels.
    Size {
        /// The width in pixels.
        width: u32,
        /// The height in pixels.
        height: u32,
    },
    /// The output file cannot have this name.
    Output {
        /// The name.
        path: PathBuf,
        /// The problem, and how to solve it.
        why: &'static str,
    },
    /// A file is not a readable image.
    Read {
        /// The name of the file.
        path: PathBuf,
        /// The problem.
        cause: String,
    },
    /// An image cannot be written.
    Write {
        /// The name of the image file.
        path: PathBuf,
        /// The error from the file system.
        cause: io::Error,
    },
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { width, height } => write!(
                f,
                "a picture of {width}x{height}: give at least 1x1 and at most {MAX_PIXELS} pixels \
                 (8192x8192)"
            ),
            Self::Read { path, cause } => write!(f, "{}: {cause}", path.display()),
            Self::Output { path, why } => write!(f, "{}: {why}", path.display()),
            Self::Write { path, cause } => {
                write!(f, "{}: cannot write the picture: {cause}", path.display())
            }
        }
    }
}

impl std::error::Error for ImageError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Write { cause, .. } => Some(cause),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn a_write_that_fails_halfway_leaves_the_old_file_and_nothing_beside_it() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        let failed = replace(&path, |file| {
            file.write_all(&vec![7; 100_000])?;
            Err(io::Error::other("the disk is full"))
        });
        assert_eq!(failed.unwrap_err().to_string(), "the disk is full");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
