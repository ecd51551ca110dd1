// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of a run, as files in its folder: what is judged as PNG, what is only looked at as JPEG.

use crate::StudyError;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _, ImageResult};
use std::io::Cursor;
use std::path::Path;
use terrafill_results::RunError;

/// Quality of pictures that are only looked at, of 100.
const JPEG_QUALITY: u8 = 85;

/// Writes RGB pixels without loss under `folder/images/` and returns the path relative to `folder`.
///
/// - `name`: of the file, without its ending
/// - `size`: columns and rows
/// - `rgb`: three bytes a pixel, row by row from the top
///
/// # Errors
/// [`StudyError::Broken`] for pixels of another number, [`StudyError::Run`] where the file cannot be written.
pub fn write_rgb(
    folder: &Path,
    name: &str,
    size: [u32; 2],
    rgb: &[u8],
) -> Result<String, StudyError> {
    write(folder, format!("images/{name}.png"), size, rgb, |file| {
        // Regions are flat: at the fastest level their pictures take several times as many bytes.
        let (compression, filter) = (CompressionType::Default, FilterType::Adaptive);
        let encoder = PngEncoder::new_with_quality(file, compression, filter);
        encoder.write_image(rgb, size[0], size[1], ExtendedColorType::Rgb8)
    })
}

/// As [`write_rgb`], with the losses of a photograph: for pictures that nothing is compared with.
///
/// # Errors
/// As [`write_rgb`].
pub fn write_photo(
    folder: &Path,
    name: &str,
    size: [u32; 2],
    rgb: &[u8],
) -> Result<String, StudyError> {
    write(folder, format!("images/{name}.jpg"), size, rgb, |file| {
        let encoder = JpegEncoder::new_with_quality(file, JPEG_QUALITY);
        encoder.write_image(rgb, size[0], size[1], ExtendedColorType::Rgb8)
    })
}

fn write(
    folder: &Path,
    relative: String,
    [width, height]: [u32; 2],
    rgb: &[u8],
    encode: impl FnOnce(&mut Cursor<Vec<u8>>) -> ImageResult<()>,
) -> Result<String, StudyError> {
    let path = folder.join(&relative);
    let broken = |message: String| StudyError::Broken {
        place: path.display().to_string(),
        message,
    };
    // The encoder would end the program.
    let (found, wanted) = (rgb.len(), 3 * width as usize * height as usize);
    if found != wanted {
        let message = format!("{found} bytes, {width} × {height} pixels have {wanted}");
        return Err(broken(message));
    }
    // In memory first: a buffered file hides that its last bytes were not written.
    let mut encoded = Cursor::new(Vec::new());
    encode(&mut encoded).map_err(|error| broken(error.to_string()))?;
    std::fs::write(&path, encoded.into_inner()).map_err(|source| RunError::Io { path, source })?;
    Ok(relative)
}

/// A case's name as that of a file: letters and digits, and hyphens for the rest.
#[must_use]
pub fn file_stem(name: &str) -> String {
    name.chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = || write_rgb(folder.path(), "a", [1, 1], &[1, 2, 3]);
        let error = write().expect_err("no folder for pictures");
        assert!(
            matches!(&error, StudyError::Run(RunError::Io { path, .. }) if path.ends_with("images/a.png")),
            "{error}"
        );
        // Negative control.
        std::fs::create_dir(folder.path().join("images")).expect("writable");
        assert_eq!(write().expect("written"), "images/a.png");
        assert!(folder.path().join("images/a.png").is_file());
        let error = write_rgb(folder.path(), "b", [2, 1], &[1, 2, 3]).expect_err("a pixel lacks");
        let message = error.to_string();
        assert!(
            message.ends_with("3 bytes, 2 × 1 pixels have 6"),
            "{message}"
        );
        assert_eq!(file_stem("a/b=4 c"), "a-b-4-c");
    }
}
