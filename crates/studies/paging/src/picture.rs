// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of what a frame shows: a colour for each level, a chessboard of pages, and lighter where a page is missing.

use crate::STUDY;
use crate::stage::Said;
use crate::texture::{PAGE, level_of};
use std::path::Path;
use terrafill_study::{StudyError, file_stem, write_photo, write_rgb};

const SKY: [u8; 3] = [205, 225, 240];
/// From the coarsest level to the finest.
const LEVELS: [[u8; 3]; 8] = [
    [90, 90, 90],
    [120, 80, 150],
    [70, 95, 170],
    [60, 150, 160],
    [85, 155, 80],
    [200, 170, 60],
    [200, 90, 60],
    [160, 60, 100],
];

/// Colours of pixels that say what they show.
pub(crate) fn of_levels(said: &[Said]) -> Vec<[u8; 3]> {
    let colour = |said: &Said| {
        let [texel, _] = said.texels;
        let Some((wanted, shown)) = said.wanted.zip(level_of(texel)) else {
            return SKY;
        };
        let page = (texel & 0x1FFF) / PAGE + (texel >> 13 & 0x1FFF) / PAGE;
        let own = LEVELS[shown.min(7) as usize];
        own.map(|channel| {
            let dark = if page.is_multiple_of(2) { 0 } else { 25 };
            let channel = channel - dark;
            if shown < wanted {
                128 + channel / 2
            } else {
                channel
            }
        })
    };
    said.iter().map(colour).collect()
}

/// Writes a picture under the run's folder and returns its path there.
///
/// - `is_photo`: with the losses of a photograph
pub(crate) fn write(
    folder: &Path,
    name: &str,
    size: [u32; 2],
    pixels: &[[u8; 3]],
    is_photo: bool,
) -> Result<String, StudyError> {
    let stem = file_stem(&format!("{STUDY}-{name}"));
    let write = if is_photo { write_photo } else { write_rgb };
    write(folder, &stem, size, pixels.as_flattened())
}
