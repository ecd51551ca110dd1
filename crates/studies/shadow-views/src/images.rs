// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of a mask: sky, sea and casters, lit or dark, and in red what a variant has wrong.

use crate::reference::{Light, Seen, Truth};
use image::{ImageFormat, RgbImage};
use std::path::Path;

/// Red of a wrong pixel.
const WRONG: [u8; 3] = [230, 30, 30];

/// A pixel's colour.
///
/// - `is_dark`: what the variant says; `None`: the reference alone
fn colour(truth: &Truth, at: usize, is_dark: Option<bool>) -> [u8; 3] {
    let (light, seen) = (truth.light[at], truth.seen[at]);
    if light == Light::EdgeOn || light == Light::Undecided {
        return [170, 130, 200];
    }
    if light == Light::OutOfReach {
        return [20, 24, 34];
    }
    let truly_dark = light == Light::Shadow;
    if light != Light::Sky && is_dark.is_some_and(|is_dark| is_dark != truly_dark) {
        return WRONG;
    }
    match (seen, truly_dark) {
        (Seen::Sky, _) => [205, 225, 240],
        (Seen::Sea(_), false) => [95, 140, 175],
        (Seen::Sea(_), true) => [35, 55, 75],
        (Seen::Triangle(..), false) => [225, 215, 190],
        (Seen::Triangle(..), true) => [80, 75, 70],
    }
}

/// Every pixel's colour, row by row from the top.
pub fn picture(truth: &Truth, mask: Option<&[bool]>) -> Vec<[u8; 3]> {
    let pixels = 0..truth.seen.len();
    pixels
        .map(|at| colour(truth, at, mask.map(|mask| mask[at])))
        .collect()
}

/// Writes a picture under `folder/images/` and returns its path relative to `folder`.
pub fn write(
    folder: &Path,
    name: &str,
    truth: &Truth,
    mask: Option<&[bool]>,
) -> Result<String, String> {
    let relative = format!("images/shadows-{name}.png");
    let path = folder.join(&relative);
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let pixels = picture(truth, mask).concat();
    let picture = RgbImage::from_raw(truth.size[0], truth.size[1], pixels);
    let picture = picture.ok_or_else(|| failed(&"wrong size"))?;
    std::fs::create_dir_all(folder.join("images")).map_err(|error| failed(&error))?;
    let saved = picture.save_with_format(&path, ImageFormat::Png);
    saved.map_err(|error| failed(&error))?;
    Ok(relative)
}
