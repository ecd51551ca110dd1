// SPDX-License-Identifier: MIT OR Apache-2.0
//! Numbers of accessors, from the file's own bytes or from data URIs.

use crate::read::model::{Wrong, wrong};
use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::{Source, View};
use gltf::{Accessor, Document};
use std::borrow::Cow;

/// Bytes of the largest item, a matrix of 4 × 4 `f32`.
const ZEROS: [u8; 64] = [0; 64];

/// The bytes of each buffer of a file.
///
/// - `bin`: what follows the JSON
pub(super) fn buffers<'a>(document: &Document, bin: &'a [u8]) -> Result<Vec<Cow<'a, [u8]>>, Wrong> {
    let buffers = document.buffers().map(|buffer| {
        let Source::Uri(uri) = buffer.source() else {
            return Ok(Cow::Borrowed(bin));
        };
        let element = format!("buffers[{}].uri", buffer.index());
        let shown: String = uri.chars().take(40).collect();
        let Some((_, data)) = uri
            .strip_prefix("data:")
            .and_then(|uri| uri.split_once(";base64,"))
        else {
            let allowed = "the file's own bytes, or a data URI in base64; `gltf-pipeline -i IN -o OUT.glb` packs others";
            return Err(wrong(element, format!("{shown:?}"), allowed));
        };
        let bytes = STANDARD.decode(data).or_else(|_| STANDARD_NO_PAD.decode(data));
        let bytes = bytes.map_err(|error| wrong(element, error, "base64"))?;
        Ok(Cow::Owned(bytes))
    });
    buffers.collect()
}

/// Reads accessors within the bytes that there are.
pub(super) struct Accessors<'a> {
    pub(super) buffers: &'a [Cow<'a, [u8]>],
    pub(super) file_bytes: usize,
}

impl Accessors<'_> {
    /// Numbers of every item, those of one after those of another.
    pub(super) fn numbers(
        &self,
        accessor: &Accessor<'_>,
        kinds: &[DataType],
        dimensions: Dimensions,
    ) -> Result<Vec<f64>, Wrong> {
        let kind = accessor.data_type();
        let items = self.items(accessor, kinds, dimensions)?;
        let component = kind.size();
        let numbers = items.iter().flat_map(|item| item.chunks_exact(component));
        let is_share = accessor.normalized();
        Ok(numbers.map(|bytes| number(bytes, kind, is_share)).collect())
    }

    /// Whole numbers of every item.
    pub(super) fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, Wrong> {
        let kinds = [DataType::U8, DataType::U16, DataType::U32];
        let items = self.items(accessor, &kinds, Dimensions::Scalar)?;
        Ok(items.into_iter().map(whole).collect())
    }

    /// Bytes of each item of an accessor.
    fn items(
        &self,
        accessor: &Accessor<'_>,
        kinds: &[DataType],
        dimensions: Dimensions,
    ) -> Result<Vec<&[u8]>, Wrong> {
        let element = format!("accessors[{}]", accessor.index());
        let (kind, found) = (accessor.data_type(), accessor.dimensions());
        if !kinds.contains(&kind) || found != dimensions {
            let kinds: Vec<String> = kinds.iter().map(|kind| format!("{kind:?}")).collect();
            let allowed = format!("{dimensions:?} of {}", kinds.join(", "));
            return Err(wrong(element, format!("{found:?} of {kind:?}"), allowed));
        }
        let (size, count) = (accessor.size(), accessor.count());
        let mut items = match (accessor.view(), accessor.sparse()) {
            (Some(view), _) => self.slices(&element, &view, accessor.offset(), size, count)?,
            // Zeros but for those that are listed.
            (None, Some(_)) if count <= self.file_bytes => vec![&ZEROS[..size]; count],
            (None, Some(_)) => {
                let allowed = format!("{}, the bytes of the file", self.file_bytes);
                return Err(wrong(element, format!("{count} items"), allowed));
            }
            (None, None) => return Err(wrong(element, "no buffer view", "one")),
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let index_size = match indices.index_type() {
                IndexType::U8 => 1,
                IndexType::U16 => 2,
                IndexType::U32 => 4,
            };
            let own = format!("{element}.sparse");
            let listed = sparse.count();
            let places =
                self.slices(&own, &indices.view(), indices.offset(), index_size, listed)?;
            let values = self.slices(&own, &values.view(), values.offset(), size, listed)?;
            for (place, value) in places.into_iter().map(whole).zip(values) {
                let item = items.get_mut(place as usize);
                let item = item.ok_or_else(|| {
                    let found = format!("index {place}");
                    wrong(own.as_str(), found, format!("below {count}, its items"))
                })?;
                *item = value;
            }
        }
        Ok(items)
    }

    /// Items of a view.
    fn slices(
        &self,
        element: &str,
        view: &View<'_>,
        offset: usize,
        size: usize,
        count: usize,
    ) -> Result<Vec<&[u8]>, Wrong> {
        let buffer = view.buffer().index();
        let buffer_bytes = self.buffers.get(buffer).map_or(&[][..], |bytes| bytes);
        let stride = view.stride().unwrap_or(size);
        let bytes = || -> Option<&[u8]> {
            let start = view.offset();
            let view = buffer_bytes.get(start..start.checked_add(view.length())?)?;
            let last = stride.checked_mul(count.checked_sub(1)?)?;
            let past = offset.checked_add(last)?.checked_add(size)?;
            view.get(offset..past)
        };
        let bytes = bytes().filter(|_| stride >= size);
        let bytes = bytes.ok_or_else(|| {
            let found = format!(
                "{count} items of {size} bytes, {stride} apart, from byte {offset} of bufferViews[{}] in \
                 buffers[{buffer}]",
                view.index(),
            );
            let allowed = format!("what lies in its {} bytes", buffer_bytes.len());
            wrong(element, found, allowed)
        })?;
        let items = (0..count).map(|at| &bytes[at * stride..at * stride + size]);
        Ok(items.collect())
    }
}

/// A whole number, least byte first.
fn whole(bytes: &[u8]) -> u32 {
    let bytes = bytes.iter().rev();
    bytes.fold(0, |number, byte| number << 8 | u32::from(*byte))
}

/// - `is_share`: whole numbers stand for −1 … 1 or 0 … 1 (glTF 2.0, §3.6.2.2)
fn number(bytes: &[u8], kind: DataType, is_share: bool) -> f64 {
    let (value, most) = match kind {
        DataType::F32 => return f32::from_bits(whole(bytes)).into(),
        DataType::I8 => (f64::from(bytes[0].cast_signed()), 127.0),
        DataType::U8 => (f64::from(bytes[0]), 255.0),
        DataType::I16 => (i16::from_le_bytes([bytes[0], bytes[1]]).into(), 32_767.0),
        DataType::U16 => (whole(bytes).into(), 65_535.0),
        DataType::U32 => return whole(bytes).into(),
    };
    if is_share {
        (value / most).max(-1.0)
    } else {
        value
    }
}
