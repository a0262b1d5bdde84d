//! Reads the buffers of a glTF file, which may be inside the file, in data URIs, or in other files.

use std::collections::HashMap;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use data_url::DataUrl;
use gltf::json::{Buffer, Root};
use percent_encoding::percent_decode_str;

use crate::load::error::{Fault, fault, quote};
use crate::load::file::{SiblingFiles, open};

/// All buffers of a glTF file.
pub(super) struct Buffers<'a> {
    all: Vec<Bytes<'a>>,
    /// The external files. Each is read once, even if several buffers use it.
    files: HashMap<PathBuf, Vec<u8>>,
}

/// The location of a buffer's bytes.
enum Bytes<'a> {
    Chunk(&'a [u8]),
    Inline(Vec<u8>),
    /// The given number of bytes at the start of a file.
    File(PathBuf, u64),
}

impl<'a> Buffers<'a> {
    /// Reads all buffers. `blob` is the binary chunk of a GLB.
    pub(super) fn read(
        root: &Root,
        blob: Option<&'a [u8]>,
        mut beside: Option<&mut SiblingFiles<'_>>,
    ) -> Result<Self, Fault> {
        let find = |(i, buffer): (usize, &Buffer)| match &buffer.uri {
            Some(uri) if is_data(uri) => inline(i, uri),
            Some(uri) => {
                let path = external(i, uri, beside.as_deref())?;
                Ok(Bytes::File(path, buffer.byte_length.0))
            }
            // Only the first buffer may refer to the GLB's binary chunk.
            None => match blob.filter(|_| i == 0) {
                Some(blob) => Ok(Bytes::Chunk(blob)),
                None => {
                    fault(format!("buffer {i} has no data: neither a chunk of a GLB nor a uri"))
                }
            },
        };
        let all: Vec<_> = root.buffers.iter().enumerate().map(find).collect::<Result<_, _>>()?;

        // Read as much of each file as its longest buffer needs.
        let mut longest = HashMap::<&Path, (usize, u64)>::new();
        for (i, bytes) in all.iter().enumerate() {
            if let Bytes::File(path, length) = bytes {
                let (_, longest) = longest.entry(path).or_insert((i, 0));
                *longest = (*longest).max(*length);
            }
        }
        let mut longest: Vec<_> = longest.into_iter().collect();
        longest.sort_unstable_by_key(|&(_, (first, _))| first);
        let mut files = HashMap::new();
        for (path, (first, length)) in longest {
            let Some(beside) = &mut beside else { continue };
            let bytes = start_of(path, length).map_err(|fault| {
                let name = path.strip_prefix(beside.folder).unwrap_or(path).to_string_lossy();
                Fault { cause: wrong(first, &name, &fault.cause), ..fault }
            })?;
            files.insert(path.to_owned(), bytes);
            beside.read.push(path.to_owned());
        }
        Ok(Self { all, files })
    }

    /// Returns the bytes of a buffer.
    fn bytes(&self, index: usize) -> Option<&[u8]> {
        Some(match self.all.get(index)? {
            Bytes::Chunk(bytes) => bytes,
            Bytes::Inline(bytes) => bytes,
            Bytes::File(path, length) => {
                let bytes = &self.files[path];
                let length = usize::try_from(*length).unwrap_or(usize::MAX);
                &bytes[..bytes.len().min(length)]
            }
        })
    }

    /// Returns the bytes of a buffer view.
    pub(super) fn view(&self, root: &Root, index: usize) -> Result<&[u8], Fault> {
        let Some(view) = root.buffer_views.get(index) else {
            return fault(format!("there is no buffer view {index}"));
        };
        let buffer = view.buffer.value();
        let Some(bytes) = self.bytes(buffer) else {
            return fault(format!(
                "buffer view {index} refers to buffer {buffer}, which does not exist"
            ));
        };
        let from = view.byte_offset.map_or(0, |offset| offset.0);
        let to = from.checked_add(view.byte_length.0);
        let range = usize::try_from(from).ok().zip(to.and_then(|to| usize::try_from(to).ok()));
        range.and_then(|(from, to)| bytes.get(from..to)).map_or_else(
            || {
                fault(format!(
                    "buffer view {index} reaches beyond buffer {buffer}, which has {} bytes; is a \
                     file cut off?",
                    bytes.len()
                ))
            },
            Ok,
        )
    }

    /// Returns the total number of bytes.
    pub(super) fn size(&self) -> usize {
        let own = self.all.iter().map(|bytes| match bytes {
            Bytes::Chunk(bytes) => bytes.len(),
            Bytes::Inline(bytes) => bytes.len(),
            Bytes::File(..) => 0,
        });
        own.sum::<usize>() + self.files.values().map(Vec::len).sum::<usize>()
    }
}

/// Decodes the bytes of a data URI.
fn inline<'a>(i: usize, uri: &str) -> Result<Bytes<'a>, Fault> {
    let bytes = DataUrl::process(uri).ok().and_then(|url| url.decode_to_vec().ok());
    match bytes {
        Some((bytes, _)) => Ok(Bytes::Inline(bytes)),
        None => fault(format!("buffer {i} has a data URI that is damaged")),
    }
}

/// Returns whether a URI is a data URI. The scheme may be in upper or lower case.
fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// Returns the file that a buffer refers to, which must be in the model's folder or below it.
fn external(i: usize, uri: &str, beside: Option<&SiblingFiles<'_>>) -> Result<PathBuf, Fault> {
    let name = percent_decode_str(uri).decode_utf8_lossy();
    let Some(beside) = beside else {
        let cause = "give the model as a file next to that one, or as GLB";
        return fault(wrong(i, &name, cause));
    };
    let within = if uri.contains(':') { None } else { within(Path::new(&*name)) };
    let path =
        within.map(|path| beside.folder.join(path)).filter(|path| !leaves(beside.folder, path));
    path.map_or_else(|| fault(wrong(i, &name, "only files in the model's own folder are read")), Ok)
}

/// Returns the path without `.` and `..`, or `None` if it leaves the folder in which it starts.
fn within(path: &Path) -> Option<PathBuf> {
    let mut within = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(name) => within.push(name),
            Component::CurDir => {}
            Component::ParentDir if within.pop() => {}
            _ => return None,
        }
    }
    Some(within).filter(|path| !path.as_os_str().is_empty())
}

/// Returns whether a path leads out of the folder through a symbolic link. Returns false for a
/// missing file, because opening the file will fail anyway.
fn leaves(folder: &Path, path: &Path) -> bool {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    match (folder.canonicalize(), path.canonicalize()) {
        (Ok(folder), Ok(path)) => !path.starts_with(folder),
        _ => false,
    }
}

fn wrong(i: usize, name: &str, cause: &str) -> String {
    format!("buffer {i} is in the file {}: {cause}", quote(name))
}

/// Reads the first `length` bytes of a file.
fn start_of(path: &Path, length: u64) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    open(path)?.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}
