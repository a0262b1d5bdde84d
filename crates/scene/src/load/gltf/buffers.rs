//! The bytes that a glTF's buffers have: within the file, in data URIs, or in files beside it.

use std::borrow::Cow;
use std::io::Read;
use std::path::{Component, PathBuf};

use data_url::DataUrl;
use gltf::json::{Buffer, Root};
use percent_encoding::percent_decode_str;

use crate::load::error::{Fault, fault, quote};
use crate::load::file::{Beside, open};

/// All buffers of a file.
pub(super) struct Buffers<'a>(Vec<Cow<'a, [u8]>>);

impl<'a> Buffers<'a> {
    /// Reads them; `blob` is the binary chunk of a GLB, and other files are beside it.
    pub(super) fn read(
        root: &Root,
        blob: Option<&'a [u8]>,
        mut beside: Option<&mut Beside<'_>>,
    ) -> Result<Self, Fault> {
        let read = |(i, buffer): (usize, &Buffer)| match &buffer.uri {
            Some(uri) if uri.starts_with("data:") => inline(i, uri),
            Some(uri) => external(i, uri, buffer.byte_length.0, beside.as_deref_mut()),
            // Only the first may be the chunk.
            None => match blob.filter(|_| i == 0) {
                Some(blob) => Ok(Cow::Borrowed(blob)),
                None => {
                    fault(format!("buffer {i} has no data: neither a chunk of a GLB nor a uri"))
                }
            },
        };
        root.buffers.iter().enumerate().map(read).collect::<Result<_, _>>().map(Self)
    }

    /// The bytes of a view of a buffer.
    pub(super) fn view(&self, root: &Root, index: usize) -> Result<&[u8], Fault> {
        let Some(view) = root.buffer_views.get(index) else {
            return fault(format!("there is no buffer view {index}"));
        };
        let buffer = view.buffer.value();
        let Some(bytes) = self.0.get(buffer) else {
            return fault(format!("buffer view {index} names buffer {buffer}, which is not there"));
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

    /// How many bytes there are in all.
    pub(super) fn size(&self) -> usize {
        self.0.iter().map(|bytes| bytes.len()).sum()
    }
}

/// The bytes of a data URI.
fn inline<'a>(i: usize, uri: &str) -> Result<Cow<'a, [u8]>, Fault> {
    let bytes = DataUrl::process(uri).ok().and_then(|url| url.decode_to_vec().ok());
    match bytes {
        Some((bytes, _)) => Ok(bytes.into()),
        None => fault(format!("buffer {i} has a data URI that is damaged")),
    }
}

/// The first `length` bytes of a file.
fn external<'a>(
    i: usize,
    uri: &str,
    length: u64,
    beside: Option<&mut Beside<'_>>,
) -> Result<Cow<'a, [u8]>, Fault> {
    let name = percent_decode_str(uri).decode_utf8_lossy();
    let wrong = |cause: &str| format!("buffer {i} is in the file {}: {cause}", quote(&name));
    let Some(beside) = beside else {
        return fault(wrong("give the model as a file, with that beside it, or as GLB"));
    };
    let name = PathBuf::from(&*name);
    let is_beside = name.components().all(|part| matches!(part, Component::Normal(_)));
    if uri.contains(':') || !is_beside {
        return fault(wrong("only files in the model's own folder are read"));
    }
    let (path, mut bytes) = (beside.folder.join(name), Vec::new());
    open(&path)
        .and_then(|file| Ok(file.take(length).read_to_end(&mut bytes)?))
        .map_err(|fault| Fault { cause: wrong(&fault.cause), ..fault })?;
    beside.read.push(path);
    Ok(bytes.into())
}
