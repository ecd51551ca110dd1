// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files and generators that a scene's regions and its surface come from.

use super::raw::RawImage;
use crate::data::{Folders, Verified};
use crate::file_read::FileRead;
use crate::scene::SurfaceFile;
use crate::{DataNeed, RegionLoadError, SceneError};
use terrafill_core::{Reading, Region, RegionFile, read_regions_as};

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
    ) -> Result<(Vec<Region>, Option<FileRead>), SceneError> {
        let read = |bytes: &[u8], file: &str| {
            read_regions_as(bytes, file, reading)
                .map_err(|error| SceneError::Regions(RegionLoadError::Invalid(error)))
        };
        let parse = |bytes: &[u8], file: &str| Ok((read(bytes, file)?.regions, None));
        match self {
            Self::Embedded { name, text } => {
                let file = FileRead::shipped(&name, text.as_bytes());
                Ok((read(text.as_bytes(), &file.path)?.regions, Some(file)))
            }
            Self::Inline(text) => parse(text.as_bytes(), &format!("{scene} (inline)")),
            Self::Generated(geojson) => {
                parse(geojson().as_bytes(), &format!("{scene} (procedural)"))
            }
            Self::File { need, how } => {
                let mut reasons = Vec::new();
                for candidate in std::iter::once(&need.file).chain(&need.source) {
                    match folders.read(&candidate.path, &candidate.sha256)? {
                        Verified::Bytes(bytes, sha256) => {
                            let RegionFile { regions, warnings } = read(&bytes, &candidate.path)?;
                            let path = candidate.path.clone();
                            let file = FileRead {
                                path,
                                sha256,
                                warnings,
                            };
                            return Ok((regions, Some(file)));
                        }
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

/// The bytes of a file that a surface is made from, and what was read.
pub(super) fn load_surface_file(
    source: SurfaceSource,
    scene: &str,
    folders: Folders<'_>,
) -> Result<(SurfaceFile, FileRead), SceneError> {
    let raw = match source {
        SurfaceSource::Shipped(file) => {
            let read = FileRead::shipped(&file.path, &file.bytes);
            return Ok((file, read));
        }
        SurfaceSource::Data(raw) => raw,
    };
    match folders.read(&raw.path, &raw.sha256)? {
        Verified::Bytes(bytes, sha256) => {
            let read = FileRead {
                path: raw.path.clone(),
                sha256,
                warnings: Vec::new(),
            };
            let file = SurfaceFile {
                path: raw.path,
                bytes: bytes.into(),
            };
            Ok((file, read))
        }
        Verified::Absent(why) => Err(SceneError::DataMissing {
            scene: scene.to_owned(),
            how: (raw.how).unwrap_or_else(|| format!("put {} into the data folder", raw.path)),
            file: raw.path,
            sha256: raw.sha256,
            why,
        }),
    }
}
