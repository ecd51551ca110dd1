// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of a run, as PNG files in its folder.

use image::{ExtendedColorType, ImageFormat};
use std::path::Path;
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
    image::save_buffer_with_format(
        &path,
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
