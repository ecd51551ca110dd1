// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of a run: as files beside the pages, or as data URIs where one file must hold all.

use base64::Engine as _;
use image::ImageFormat;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io::ErrorKind;
use std::path::{Component, Path};

/// Longer side of a small picture, pixels: twice its size on the page, for screens with fine pixels.
const SMALL_PX: u32 = 144;

/// Why a picture cannot be shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Unshown {
    /// It is not in the run's folder: a run that is passed on may leave pictures out.
    Absent,
    /// One sentence for the report.
    Broken(String),
}

/// A picture of the run's folder that can be shown, PNG or JPEG.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Picture {
    format: ImageFormat,
    /// Its file.
    bytes: Vec<u8>,
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
}

impl Picture {
    /// Reads the picture that a row names, relative to the run's folder.
    ///
    /// It is decoded in full: a run killed while writing leaves a file that starts well.
    ///
    /// # Errors
    /// [`Unshown`]. A path that leaves the folder is refused: a report may be made from
    /// a folder that came from elsewhere, and must not carry other files of this machine along.
    pub(crate) fn read(folder: &Path, relative: &str) -> Result<Self, Unshown> {
        let (format, bytes, decoded) = decoded(folder, relative)?;
        Ok(Self {
            format,
            bytes,
            width: decoded.width(),
            height: decoded.height(),
        })
    }

    /// A small copy for a table.
    ///
    /// # Errors
    /// As [`Picture::read`].
    pub(crate) fn small(folder: &Path, relative: &str) -> Result<Self, Unshown> {
        let (format, _, decoded) = decoded(folder, relative)?;
        let small = decoded.thumbnail(SMALL_PX, SMALL_PX).to_rgb8();
        let mut bytes = std::io::Cursor::new(Vec::new());
        small
            .write_to(&mut bytes, format)
            .map_err(|error| Unshown::Broken(format!("{relative}: {error}")))?;
        Ok(Self {
            format,
            bytes: bytes.into_inner(),
            width: small.width(),
            height: small.height(),
        })
    }

    /// `data:image/png;base64,…`
    pub(crate) fn uri(&self) -> String {
        data_uri(self.format.to_mime_type(), &self.bytes)
    }

    /// Of its file, without the dot.
    pub(crate) fn ending(&self) -> &'static str {
        self.format
            .extensions_str()
            .first()
            .copied()
            .unwrap_or_default()
    }

    /// Its file's bytes.
    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// The same for pictures that are the same to the byte.
    pub(crate) fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.bytes.hash(&mut hasher);
        hasher.finish()
    }
}

/// A file's contents as an address.
pub(crate) fn data_uri(kind: &str, bytes: &[u8]) -> String {
    let encoded = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!("data:{kind};base64,{encoded}")
}

fn decoded(
    folder: &Path,
    relative: &str,
) -> Result<(ImageFormat, Vec<u8>, image::DynamicImage), Unshown> {
    let broken = |why: &dyn std::fmt::Display| Unshown::Broken(format!("{relative}: {why}"));
    let path = Path::new(relative);
    let inside = path
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    if !inside {
        return Err(broken(&"it is outside the run folder"));
    }
    let bytes = std::fs::read(folder.join(path)).map_err(|error| match error.kind() {
        ErrorKind::NotFound => Unshown::Absent,
        _ => broken(&error),
    })?;
    let format = ImageFormat::from_path(path).unwrap_or(ImageFormat::Png);
    let decoded =
        image::load_from_memory_with_format(&bytes, format).map_err(|error| broken(&error))?;
    Ok((format, bytes, decoded))
}

/// A path as an address: what would end or change it is escaped.
pub(crate) fn address(path: &str) -> String {
    let mut address = String::new();
    for c in path.chars() {
        match c {
            '%' | '#' | '?' | ' ' | '"' | '\'' | '<' | '>' | '\\' => {
                address.push_str(&format!("%{:02X}", u32::from(c)));
            }
            _ => address.push(c),
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with_picture() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        image::RgbImage::from_pixel(8, 4, image::Rgb([1, 2, 3]))
            .save(folder.path().join("a.png"))
            .expect("a picture");
        folder
    }

    #[test]
    fn a_picture_is_carried_whole() {
        let folder = folder_with_picture();
        let picture = Picture::read(folder.path(), "a.png").expect("a picture");
        assert_eq!((picture.width, picture.height), (8, 4));
        let uri = picture.uri();
        let encoded = uri.split_once(',').expect("a data URI").1;
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(encoded)
            .expect("base64");
        assert_eq!(
            bytes,
            std::fs::read(folder.path().join("a.png")).expect("the file")
        );
    }

    #[test]
    fn a_small_copy_keeps_the_shape() {
        let folder = tempfile::tempdir().expect("a folder");
        image::RgbImage::from_pixel(1000, 500, image::Rgb([1, 2, 3]))
            .save(folder.path().join("a.png"))
            .expect("a picture");
        let small = Picture::small(folder.path(), "a.png").expect("a picture");
        assert_eq!((small.width, small.height), (SMALL_PX, SMALL_PX / 2));
        assert!(Picture::small(folder.path(), "none.png").is_err());
    }

    #[test]
    fn a_photo_stays_one_and_a_drawing_by_its_name_is_refused() {
        let folder = folder_with_picture();
        let place = |name: &str| folder.path().join(name);
        image::RgbImage::from_pixel(8, 4, image::Rgb([1, 2, 3]))
            .save(place("a.jpg"))
            .expect("a picture");
        for picture in [Picture::read, Picture::small].map(|read| read(folder.path(), "a.jpg")) {
            let picture = picture.expect("a picture");
            assert!(picture.uri().starts_with("data:image/jpeg;"), "{picture:?}");
            assert_eq!(picture.ending(), "jpg");
        }
        // Negative control.
        std::fs::copy(place("a.png"), place("b.jpg")).expect("writable");
        let other = Picture::read(folder.path(), "b.jpg");
        assert!(matches!(other, Err(Unshown::Broken(_))), "{other:?}");
    }

    #[test]
    fn half_a_picture_absence_and_foreign_files_are_refused() {
        let folder = folder_with_picture();
        let bytes = std::fs::read(folder.path().join("a.png")).expect("the file");
        std::fs::write(folder.path().join("torn.png"), &bytes[..bytes.len() - 20])
            .expect("writable");
        let torn = Picture::read(folder.path(), "torn.png");
        assert!(matches!(torn, Err(Unshown::Broken(_))), "{torn:?}");
        let none = Picture::read(folder.path(), "none.png");
        assert_eq!(none, Err(Unshown::Absent));
        let inner = folder.path().join("run");
        std::fs::create_dir(&inner).expect("a folder");
        let outside = Picture::read(&inner, "../a.png");
        let why = "../a.png: it is outside the run folder".to_owned();
        assert_eq!(outside, Err(Unshown::Broken(why)));
        let absolute = folder.path().join("a.png");
        assert!(Picture::read(&inner, &absolute.to_string_lossy()).is_err());
    }

    #[test]
    fn addresses_name_the_file_and_nothing_else() {
        assert_eq!(address("images/a,b=c.png"), "images/a,b=c.png");
        assert_eq!(address("images/50%#\".png"), "images/50%25%23%22.png");
    }
}
