// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures in the run's folder.

use std::path::Path;

/// Writes a picture under `folder/images/` and returns its path relative to `folder`.
///
/// - `pixels`: red, green and blue in sRGB bytes, row by row from the top
///
/// # Errors
/// The path, and what the system says.
pub fn write_png(
    folder: &Path,
    name: &str,
    [width, height]: [u32; 2],
    pixels: impl Iterator<Item = [u8; 3]>,
) -> Result<String, String> {
    let relative = format!("images/{name}.png");
    let path = folder.join(&relative);
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let image = image::RgbImage::from_raw(width, height, pixels.flatten().collect());
    let image = image.ok_or_else(|| failed(&"wrong size"))?;
    std::fs::create_dir_all(folder.join("images")).map_err(|error| failed(&error))?;
    let saved = image.save_with_format(&path, image::ImageFormat::Png);
    saved.map_err(|error| failed(&error))?;
    Ok(relative)
}
