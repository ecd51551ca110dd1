// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why bytes are no elevation.

/// Why a file gave no heights.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElevationError {
    /// A value in the file, or of it, that is not allowed.
    #[error("{file}: {place}: found {found}, allowed: {allowed}")]
    Value {
        /// The file.
        file: String,
        /// Which part of the file.
        place: String,
        /// The value.
        found: String,
        /// What it may be.
        allowed: String,
    },
    /// The decoder of the format gave up.
    #[error("{file}: not a readable {format}: {message}")]
    Undecodable {
        /// The file.
        file: String,
        /// Name of the format.
        format: &'static str,
        /// The decoder's words.
        message: String,
    },
}

/// Words complaints about one file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Complaints<'a> {
    pub(crate) file: &'a str,
}

impl Complaints<'_> {
    pub(crate) fn value(
        self,
        place: impl Into<String>,
        found: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> ElevationError {
        ElevationError::Value {
            file: self.file.to_owned(),
            place: place.into(),
            found: found.to_string(),
            allowed: allowed.into(),
        }
    }

    /// The command that writes a file which is read: by GDAL, with these options.
    pub(crate) fn gdal_translate(self, options: &str) -> String {
        let file = self.file;
        format!("`gdal_translate {options} {file} mended.tif` writes one that is read")
    }

    /// The same for a file that lies in another system or askew.
    pub(crate) fn gdalwarp(self) -> String {
        let file = self.file;
        format!("`gdalwarp -t_srs EPSG:4326 -r bilinear {file} mended.tif` writes one that is read")
    }

    pub(crate) fn undecodable(
        self,
        format: &'static str,
        message: impl std::fmt::Display,
    ) -> ElevationError {
        ElevationError::Undecodable {
            file: self.file.to_owned(),
            format,
            message: message.to_string().replace('\n', ", "),
        }
    }
}
