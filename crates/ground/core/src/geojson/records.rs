// SPDX-License-Identifier: MIT OR Apache-2.0
//! One file → its GeoJSON texts: unpacked where it is gzip, cut where each line or record is a text.
//!
//! Known by their bytes, not by the file's name: gzip (RFC 1952), text sequences (RFC 8142, each
//! record begins with 0x1E), and newline-delimited GeoJSON (a whole object a line).

use super::problem::RegionProblemKind;
use flate2::read::MultiGzDecoder;
use serde::de::IgnoredAny;
use std::borrow::Cow;
use std::io::Read as _;

/// Bytes that a file may unpack to: a thousand times a large map, and a fraction of what a few packed
/// megabytes can become.
pub(super) const MAX_UNPACKED_BYTES: u64 = 1 << 30;

/// Begins each record of a text sequence.
const RECORD_SEPARATOR: u8 = 0x1e;

/// A text of its own, and the line of the file that it begins in, from 1.
#[derive(Debug, PartialEq)]
pub(super) struct Record<'a> {
    pub(super) line: usize,
    pub(super) text: &'a [u8],
}

/// The bytes of a file, unpacked if they are gzip.
///
/// # Errors
/// A damaged packing, and one of more than `allowed` bytes.
pub(super) fn unpacked(bytes: &[u8], allowed: u64) -> Result<Cow<'_, [u8]>, RegionProblemKind> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut unpacked = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes).take(allowed + 1);
    if let Err(error) = decoder.read_to_end(&mut unpacked) {
        let message = error.to_string();
        return Err(RegionProblemKind::Gzip { message });
    }
    if unpacked.len() as u64 > allowed {
        return Err(RegionProblemKind::UnpackedSize { allowed });
    }
    Ok(Cow::Owned(unpacked))
}

/// The records of a text sequence or the lines of newline-delimited GeoJSON; `None` for a file that is
/// one text.
///
/// By its first line: a whole object with more after it cannot begin a single text.
pub(super) fn records(text: &[u8]) -> Option<Vec<Record<'_>>> {
    let blank = text.iter().take_while(|byte| byte.is_ascii_whitespace());
    let first = &text[blank.count()..];
    let separator = if first.first() == Some(&RECORD_SEPARATOR) {
        RECORD_SEPARATOR
    } else {
        let end = first.iter().position(|byte| *byte == b'\n')?;
        let is_whole = |line: &[u8]| serde_json::from_slice::<IgnoredAny>(line).is_ok();
        let has_more = !is_blank(&first[end..]);
        if !(first.starts_with(b"{") && has_more && is_whole(&first[..end])) {
            return None;
        }
        b'\n'
    };
    let mut line = 1;
    let mut records = Vec::new();
    for part in text.split(|byte| *byte == separator) {
        if !is_blank(part) {
            records.push(Record { line, text: part });
        }
        line += part.iter().filter(|byte| **byte == b'\n').count();
        line += usize::from(separator == b'\n');
    }
    Some(records)
}

fn is_blank(text: &[u8]) -> bool {
    text.iter().all(u8::is_ascii_whitespace)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write as _;

    fn packed(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).expect("to memory");
        encoder.finish().expect("to memory")
    }

    #[test]
    fn gzip_is_unpacked_up_to_a_bound() {
        let gzip = packed(&[b' '; 1000]);
        assert_eq!(unpacked(&gzip, 1000).expect("whole").len(), 1000);
        let two = [packed(b"{"), packed(b"}")].concat();
        assert_eq!(&*unpacked(&two, 1000).expect("two members"), b"{}");
        // Negative controls: a byte too much, the end missing, and what is not packed.
        assert_eq!(
            unpacked(&gzip, 999),
            Err(RegionProblemKind::UnpackedSize { allowed: 999 })
        );
        let damaged = unpacked(&gzip[..gzip.len() - 4], 1000);
        assert!(matches!(damaged, Err(RegionProblemKind::Gzip { .. })));
        assert!(matches!(unpacked(b"{}", 1), Ok(Cow::Borrowed(b"{}"))));
    }

    #[test]
    fn lines_and_records_are_cut_and_single_texts_are_not() {
        let lines = |text: &str| -> Option<Vec<usize>> {
            let records = records(text.as_bytes())?;
            Some(records.iter().map(|record| record.line).collect())
        };
        assert_eq!(lines("{}\n\n{}\r\n{}"), Some(vec![1, 3, 4]));
        assert_eq!(lines("\n{}\n{\n"), Some(vec![2, 3]));
        assert_eq!(lines("\u{1e}{\n}\n\u{1e}{}\n"), Some(vec![1, 3]));
        // Negative controls: one text, on one line or several; a list.
        for one in ["{}", "{}\n \n", "{\n}\n", "[]\n[]", ""] {
            assert_eq!(lines(one), None, "{one:?}");
        }
    }
}
