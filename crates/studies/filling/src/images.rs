// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of a run, as PNG files in its folder.

use image::{ExtendedColorType, ImageFormat};
use std::io::Cursor;
use std::path::Path;
use terrafill_results::RunError;
use terrafill_scene::ImageSize;
use terrafill_study::StudyError;

/// Writes RGB pixels under `folder/images/` and returns the path relative to `folder`.
pub(crate) fn write_rgb(
    folder: &Path,
    name: &str,
    size: ImageSize,
    rgb: &[u8],
) -> Result<String, StudyError> {
    let relative = format!("images/{name}.png");
    let path = folder.join(&relative);
    // In memory first: a buffered file hides that its last bytes were not written.
    let mut encoded = Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut encoded,
        rgb,
        size.width,
        size.height,
        ExtendedColorType::Rgb8,
        ImageFormat::Png,
    )
    .map_err(|error| StudyError::Broken {
        place: path.display().to_string(),
        message: error.to_string(),
    })?;
    std::fs::write(&path, encoded.into_inner()).map_err(|source| RunError::Io { path, source })?;
    Ok(relative)
}

/// RGBA to RGB.
pub(crate) fn drop_alpha(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks_exact(4)
        .flat_map(|pixel| &pixel[..3])
        .copied()
        .collect()
}

/// Parts of a case's name as a file name.
pub(crate) fn file_stem(parts: &[&str]) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    let text = parts.join("_");
    text.chars()
        .map(|c| if is_plain(c) { c } else { '-' })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let size = ImageSize {
            width: 1,
            height: 1,
        };
        let write = || write_rgb(folder.path(), "a", size, &[1, 2, 3]);
        let error = write().expect_err("no folder for pictures");
        assert!(
            matches!(&error, StudyError::Run(RunError::Io { path, .. }) if path.ends_with("images/a.png")),
            "{error}"
        );
        // Twin.
        std::fs::create_dir(folder.path().join("images")).expect("writable");
        assert_eq!(write().expect("written"), "images/a.png");
        assert!(folder.path().join("images/a.png").is_file());
    }
}
