// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of a run as data URIs, so that the report needs no file beside it.

use base64::Engine as _;
use std::path::{Component, Path};

/// A picture ready for an `img` element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Picture {
    /// `data:image/png;base64,…`
    pub(crate) uri: String,
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
}

/// Reads the picture that a row names, relative to the run's folder.
///
/// It is decoded in full: a run killed while writing leaves a file that starts well.
///
/// # Errors
/// One sentence for the report. A path that leaves the folder is refused: a report may be made from
/// a folder that came from elsewhere, and must not carry other files of this machine along.
pub(crate) fn embed(folder: &Path, relative: &str) -> Result<Picture, String> {
    let path = Path::new(relative);
    let inside = path
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    if !inside {
        return Err(format!("{relative} is outside the run folder"));
    }
    let bytes = std::fs::read(folder.join(path)).map_err(|error| format!("{relative}: {error}"))?;
    let decoded = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png)
        .map_err(|error| format!("{relative}: {error}"))?;
    Ok(Picture {
        uri: format!(
            "data:image/png;base64,{}",
            base64::engine::general_purpose::STANDARD.encode(&bytes)
        ),
        width: decoded.width(),
        height: decoded.height(),
    })
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
        let picture = embed(folder.path(), "a.png").expect("a picture");
        assert_eq!((picture.width, picture.height), (8, 4));
        let encoded = picture.uri.split_once(',').expect("a data URI").1;
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(encoded)
            .expect("base64");
        assert_eq!(
            bytes,
            std::fs::read(folder.path().join("a.png")).expect("the file")
        );
    }

    #[test]
    fn half_a_picture_absence_and_foreign_files_are_refused() {
        let folder = folder_with_picture();
        let bytes = std::fs::read(folder.path().join("a.png")).expect("the file");
        std::fs::write(folder.path().join("torn.png"), &bytes[..bytes.len() - 20])
            .expect("writable");
        assert!(embed(folder.path(), "torn.png").is_err());
        assert!(embed(folder.path(), "none.png").is_err());
        let inner = folder.path().join("run");
        std::fs::create_dir(&inner).expect("a folder");
        let outside = embed(&inner, "../a.png").expect_err("outside");
        assert!(outside.contains("outside the run folder"), "{outside}");
        let absolute = folder.path().join("a.png");
        assert!(embed(&inner, &absolute.to_string_lossy()).is_err());
    }
}
