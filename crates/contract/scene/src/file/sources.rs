// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files and generators that a scene's regions and its surface come from.

use super::raw::RawImage;
use crate::data::{Folders, Verified};
use crate::scene::SurfaceFile;
use crate::{DataNeed, RegionLoadError, SceneError};
use terrafill_core::{Reading, Region, parse_regions_as};

/// A file that a surface is made from, checked.
pub(super) enum SurfaceSource {
    Data(RawImage),
    Shipped(SurfaceFile),
}

/// Where a scene's regions come from.
pub(super) enum RegionSource {
    File {
        need: DataNeed,
        how: String,
    },
    Embedded {
        name: String,
        text: &'static str,
    },
    Inline(String),
    /// GeoJSON that the program makes.
    Generated(Box<dyn Fn() -> String>),
}

impl RegionSource {
    pub(super) fn regions(
        self,
        scene: &str,
        folders: Folders<'_>,
        reading: Reading,
    ) -> Result<Vec<Region>, SceneError> {
        let parse = |bytes: &[u8], file: &str| {
            parse_regions_as(bytes, file, reading)
                .map_err(|error| SceneError::Regions(RegionLoadError::Invalid(error)))
        };
        match self {
            Self::Embedded { name, text } => {
                parse(text.as_bytes(), &format!("bench-scenes/{name}"))
            }
            Self::Inline(text) => parse(text.as_bytes(), &format!("{scene} (inline)")),
            Self::Generated(geojson) => {
                parse(geojson().as_bytes(), &format!("{scene} (procedural)"))
            }
            Self::File { need, how } => {
                let mut reasons = Vec::new();
                for candidate in std::iter::once(&need.file).chain(&need.source) {
                    match folders.read(&candidate.path, &candidate.sha256)? {
                        Verified::Bytes(bytes) => return parse(&bytes, &candidate.path),
                        Verified::Absent(why) => reasons.push(why),
                    }
                }
                // That there is no folder is said once.
                reasons.dedup();
                Err(SceneError::DataMissing {
                    scene: scene.to_owned(),
                    file: need.file.path,
                    sha256: need.file.sha256,
                    why: reasons.join(", and "),
                    how,
                })
            }
        }
    }
}

/// The bytes of a file that a surface is made from.
pub(super) fn load_surface_file(
    source: SurfaceSource,
    scene: &str,
    folders: Folders<'_>,
) -> Result<SurfaceFile, SceneError> {
    let raw = match source {
        SurfaceSource::Shipped(file) => return Ok(file),
        SurfaceSource::Data(raw) => raw,
    };
    match folders.read(&raw.path, &raw.sha256)? {
        Verified::Bytes(bytes) => Ok(SurfaceFile {
            path: raw.path,
            bytes: bytes.into(),
        }),
        Verified::Absent(why) => Err(SceneError::DataMissing {
            scene: scene.to_owned(),
            how: (raw.how).unwrap_or_else(|| format!("put {} into the data folder", raw.path)),
            file: raw.path,
            sha256: raw.sha256,
            why,
        }),
    }
}
