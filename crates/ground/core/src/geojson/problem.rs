// SPDX-License-Identifier: MIT OR Apache-2.0
//! What can be wrong with a file of regions, where, and in which words.

use crate::Region;
use std::borrow::Cow;
use std::fmt;

/// Latitudes beyond this are no longitudes either: the file has other units than degrees.
const LARGEST_SWAPPED_LATITUDE_DEG: f64 = 180.0;

/// Everything that is wrong with a file of regions.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionFileError {
    /// As the caller named it.
    pub file: String,
    /// At least one.
    pub problems: Vec<RegionProblem>,
    /// Features without problems: what else is wrong with them can be listed in the same round.
    pub readable: Vec<Region>,
    /// As those of [`crate::RegionFile`].
    pub warnings: Vec<String>,
}

impl fmt::Display for RegionFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            let separator = if i == 0 { "" } else { "\n" };
            write!(f, "{separator}{}: {problem}", self.file)?;
        }
        Ok(())
    }
}

impl std::error::Error for RegionFileError {}

/// One thing wrong with a file, and where. Indices count from 0, in file order.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionProblem {
    /// Line of the file, from 1, where each line or record is a text of its own.
    pub line: Option<usize>,
    /// Feature, unless the file as a whole is meant.
    pub feature: Option<usize>,
    /// Its name, where it was read.
    pub name: Option<String>,
    /// Areal part of the feature.
    pub polygon: Option<usize>,
    /// Ring of the polygon; 0 is the shell.
    pub ring: Option<usize>,
    /// Position in the ring.
    pub vertex: Option<usize>,
    /// What is wrong.
    pub kind: RegionProblemKind,
}

/// Number and name of a feature, the name left out where there is none, in one line.
pub(crate) fn feature_label(feature: usize, name: &str) -> String {
    let number = unnamed(feature);
    if name.is_empty() || name == number {
        number
    } else {
        format!("{number} ({})", printable(name))
    }
}

/// `text` with its control characters written out (`\u{1b}`), so that a name from a file neither
/// breaks a line nor commands the terminal that it is printed on.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(char::is_control) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        if character.is_control() {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    Cow::Owned(shown)
}

pub(super) fn unnamed(feature: usize) -> String {
    format!("feature {feature}")
}

impl fmt::Display for RegionProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        if let Some(feature) = self.feature {
            let name = self.name.as_deref().unwrap_or_default();
            f.write_str(&feature_label(feature, name))?;
            let parts = [
                ("polygon", self.polygon),
                ("ring", self.ring),
                ("vertex", self.vertex),
            ];
            for (word, index) in parts {
                if let Some(index) = index {
                    write!(f, ", {word} {index}")?;
                }
            }
            f.write_str(": ")?;
        }
        // Texts of the file are quoted in some of these.
        f.write_str(&printable(&self.kind.to_string()))
    }
}

/// What can be wrong with a file of regions: the value found and the value allowed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegionProblemKind {
    /// No bytes, or only white space.
    #[error("the file is empty; expected GeoJSON")]
    EmptyFile,
    /// Text of two or four bytes a character.
    #[error("the file is {found}; expected UTF-8")]
    Encoding {
        /// Its encoding.
        found: &'static str,
    },
    /// Another format of regions, known by its first bytes.
    #[error(
        "the file is {found}; expected GeoJSON, which `ogr2ogr -lco RFC7946=YES regions.geojson FILE [LAYER]` \
         makes of it"
    )]
    OtherFormat {
        /// Its name.
        found: &'static str,
    },
    /// gzip that cannot be unpacked.
    #[error("the gzip data is damaged: {message}; expected a whole gzip file")]
    Gzip {
        /// The decoder's words.
        message: String,
    },
    /// gzip of too much.
    #[error("the file unpacks to more than {allowed} bytes, which is what is allowed; split it")]
    UnpackedSize {
        /// Bytes.
        allowed: u64,
    },
    /// Not JSON from here on, or JSON of a shape that GeoJSON does not have.
    #[error("line {line}, column {column}: {message}{}", Self::quoted(found.as_ref()))]
    Json {
        /// From 1.
        line: usize,
        /// From 1, in bytes.
        column: usize,
        /// The parser's words.
        message: String,
        /// The text there, where there is a word or number.
        found: Option<String>,
    },
    /// A list where an object should be.
    #[error(
        "the file is a bare list, such as rings in pixel coordinates; expected a GeoJSON object \
         with a \"type\""
    )]
    BareList,
    /// `type` is missing.
    #[error("no \"type\"; expected {allowed}")]
    MissingType {
        /// What may stand here.
        allowed: &'static str,
    },
    /// `type` says something else.
    #[error("type \"{found}\"; expected {allowed}")]
    UnknownType {
        /// As in the file.
        found: String,
        /// What may stand here.
        allowed: &'static str,
    },
    /// A member that the type calls for is missing or null.
    #[error("no \"{member}\" in a {of}")]
    MissingMember {
        /// Its name.
        member: &'static str,
        /// Type of the object.
        of: String,
    },
    /// A collection of nothing, where regions are needed.
    #[error("no features; expected at least one")]
    NoFeatures,
    /// Only points, lines, and features without a geometry.
    #[error("no area: found {found}; expected Polygon or MultiPolygon")]
    NotAreal {
        /// Types found, as in the file, and how often.
        found: String,
    },
    /// `[]` where positions should be.
    #[error("empty coordinates; expected at least 3 distinct positions")]
    EmptyCoordinates,
    /// Coordinates nested too deep, too flat, or not numbers.
    #[error("{found} in the coordinates; expected {allowed}")]
    WrongNesting {
        /// What was found.
        found: String,
        /// What may.
        allowed: &'static str,
    },
    /// A position that holds something else beside numbers.
    #[error("element {element} of the position is {found}; expected a number")]
    NotANumber {
        /// Place in the position, from 0.
        element: usize,
        /// What was found.
        found: String,
    },
    /// Beyond a pole.
    #[error("latitude {found} is outside -90 … 90{}", Self::latitude_hint(*found))]
    Latitude {
        /// Degrees.
        found: f64,
    },
    /// Far round.
    #[error("longitude {found} is outside -540 … 540{}", PROJECTED)]
    Longitude {
        /// Degrees.
        found: f64,
    },
    /// No area.
    #[error("{found} distinct positions in the ring; needs at least {required}")]
    TooFewVertices {
        /// Distinct positions.
        found: usize,
        /// Three.
        required: usize,
    },
    /// Goes round more than once.
    #[error("the ring goes round the axis {found} times; at most 1 is allowed")]
    ManyTurns {
        /// Turns, without their sign.
        found: usize,
    },
}

/// What a number is that no angle can be.
const PROJECTED: &str = "; it looks projected, expected degrees";

impl RegionProblemKind {
    /// What most often puts such a number into the second place.
    fn latitude_hint(found: f64) -> &'static str {
        if found.abs() > LARGEST_SWAPPED_LATITUDE_DEG {
            PROJECTED
        } else {
            "; in GeoJSON longitude comes first"
        }
    }

    fn quoted(found: Option<&String>) -> String {
        found.map_or_else(String::new, |text| format!(", found \"{text}\""))
    }
}

/// `serde_json`'s error, with the word or number that stands at its place.
pub(super) fn json_problem(text: &[u8], error: &serde_json::Error) -> RegionProblemKind {
    let (line, column) = (error.line(), error.column());
    let full = error.to_string();
    let suffix = format!(" at line {line} column {column}");
    RegionProblemKind::Json {
        line,
        column,
        message: full.strip_suffix(&suffix).unwrap_or(&full).to_owned(),
        found: word_at(text, line, column),
    }
}

/// Letters, digits and signs around a place: `NaN`, `-Infinity`, `1e999`.
fn word_at(text: &[u8], line: usize, column: usize) -> Option<String> {
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-.".contains(byte);
    let line = text
        .split(|byte| *byte == b'\n')
        .nth(line.checked_sub(1)?)?;
    let at = column.saturating_sub(1).min(line.len());
    let before = line[..at]
        .iter()
        .rev()
        .take_while(|byte| is_word(byte))
        .count();
    let after = line[at..].iter().take_while(|byte| is_word(byte)).count();
    let word = &line[at - before..at + after];
    // A longer run is a broken file, not a word worth quoting.
    (!word.is_empty() && word.len() <= 40).then(|| String::from_utf8_lossy(word).into_owned())
}

/// Name of the encoding of a text that is not UTF-8 but two or four bytes a character; `None` for any
/// other.
///
/// By its byte order mark; without one, by the NUL bytes around its first character, which GeoJSON
/// and CSV begin with in ASCII.
#[must_use]
pub fn wide_encoding(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        [0, 0, 0, 1..=255, ..] | [1..=255, 0, 0, 0, ..] => Some("UTF-32"),
        [0, 1..=255, ..] | [1..=255, 0, ..] => Some("UTF-16"),
        _ => None,
    }
}

/// First bytes of other formats that hold regions. GDAL reads them all.
const OTHER_FORMATS: [(&[u8], &str); 6] = [
    (b"fgb\x03", "FlatGeobuf"),
    (b"SQLite format 3\0", "SQLite, as GeoPackage is"),
    (b"\0\0\x27\x0a", "a Shapefile"),
    (b"PAR1", "Parquet"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"<", "XML, as KML and GML are"),
];

/// What a file is that is of another format.
pub(super) fn other_format(bytes: &[u8]) -> Option<&'static str> {
    let mut formats = OTHER_FORMATS.iter();
    let known = formats.find(|(first, _)| bytes.starts_with(first));
    known.map(|(_, name)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_written_out() {
        assert_eq!(printable("a\u{1b}[2J\n\u{9b}b"), "a\\u{1b}[2J\\n\\u{9b}b");
        assert_eq!(feature_label(3, "a\tb"), "feature 3 (a\\tb)");
        // Negative controls: what is no control character stays as it is.
        for name in ["São Tomé", "\"quoted\"", "back\\slash", ""] {
            assert_eq!(printable(name), name);
        }
    }

    #[test]
    fn other_formats_are_named_with_what_makes_geojson_of_them() {
        for (first, name) in OTHER_FORMATS {
            let found = other_format(&[first, b" and more"].concat());
            assert_eq!(found, Some(name));
        }
        let message = RegionProblemKind::OtherFormat { found: "Parquet" }.to_string();
        assert!(message.starts_with("the file is Parquet; expected GeoJSON, which `ogr2ogr"));
        // Negative control: half of the first bytes, and what GeoJSON begins with.
        for other in [&b"fgb"[..], b"SQLite format 4\0", b"{", b"[", b""] {
            assert_eq!(other_format(other), None);
        }
    }

    #[test]
    fn encodings_are_known_with_and_without_a_mark() {
        let utf16 = |text: &str| -> Vec<u8> {
            let units = text.encode_utf16();
            units.flat_map(u16::to_le_bytes).collect()
        };
        let swapped = |bytes: &[u8]| -> Vec<u8> {
            let pairs = bytes.chunks_exact(2);
            pairs.flat_map(|pair| [pair[1], pair[0]]).collect()
        };
        for text in ["{\"type\":", "\u{feff}{\"type\":"] {
            let bytes = utf16(text);
            assert_eq!(wide_encoding(&bytes), Some("UTF-16"));
            assert_eq!(wide_encoding(&swapped(&bytes)), Some("UTF-16"));
            let wide: Vec<u8> = text
                .chars()
                .flat_map(|c| u32::from(c).to_le_bytes())
                .collect();
            assert_eq!(wide_encoding(&wide), Some("UTF-32"));
            let big: Vec<u8> = text
                .chars()
                .flat_map(|c| u32::from(c).to_be_bytes())
                .collect();
            assert_eq!(wide_encoding(&big), Some("UTF-32"));
            // Negative control.
            assert_eq!(wide_encoding(text.as_bytes()), None);
        }
        for other in [&b""[..], b"{", b"\xff", b"\0", b"\0\0"] {
            assert_eq!(wide_encoding(other), None);
        }
    }
}
