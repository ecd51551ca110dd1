// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures for people: the body with its meridians and parallels, and over it what was drawn; red where it is wrong.

use crate::STUDY;
use crate::divided::{Divided, TEXELS};
use crate::judge::{self, texels};
use crate::place::Shape;
use glam::DVec2;
use std::path::Path;
use terrafill_shapes::rays::centres;
use terrafill_study::{StudyError, file_stem, write_rgb};

const SKY: [u8; 3] = [205, 225, 240];
const BODY: [u8; 3] = [150, 160, 165];
/// Meridians and parallels, each tenth of degree, 1° or 10°.
const GRATICULE: [u8; 3] = [120, 130, 135];
const WRONG: [u8; 3] = [230, 30, 30];
/// Squares of a decal's picture, texels.
const SQUARE: u32 = 64;

/// Colours of a picture of addresses.
fn colours<'a>(
    divided: &'a Divided,
    numbers: &'a [u32],
    wrong: &'a [bool],
) -> impl Iterator<Item = [u8; 3]> + 'a {
    let eye = &divided.eye;
    let pixels = centres(eye.size()).zip(numbers.iter().zip(wrong));
    pixels.map(move |(at_px, (number, is_wrong))| {
        if *is_wrong {
            return WRONG;
        }
        // The device draws the body where depth is tested.
        let is_body = *number == judge::BODY || !divided.is_tested;
        match (texels(divided.data.shape, *number), eye.shown(at_px)) {
            (Some([x, y]), _) => of_texel(divided.data.shape, x, y),
            (None, Some(at)) if is_body => body(at, eye.height_m),
            (None, _) => SKY,
        }
    })
}

/// A chessboard that goes from blue to orange along a decal's width, and lighter along its height.
fn of_texel(shape: Shape, x: u32, y: u32) -> [u8; 3] {
    #[allow(clippy::cast_possible_truncation, reason = "a share of 255")]
    let share = |at: u32, of: u32| (at * of / TEXELS) as u8;
    if matches!(shape, Shape::Line(_)) {
        return [190, 30 + share(x, 60), 90];
    }
    let is_dark = (x / SQUARE + y / SQUARE).is_multiple_of(2);
    let dark = if is_dark { 40 } else { 0 };
    let colour = [70 + share(x, 150), 120 + share(y, 80), 200 - share(x, 130)];
    colour.map(|of| of - dark)
}

fn body(at: DVec2, height_m: f64) -> [u8; 3] {
    let step: f64 = match height_m {
        height if height > 1e6 => 10.0,
        height if height > 1e5 => 1.0,
        _ => 0.1,
    };
    let is_near = |angle: f64| {
        let off = angle.to_degrees() / step;
        (off - off.round()).abs() < 0.03
    };
    if is_near(at.x) || is_near(at.y) {
        GRATICULE
    } else {
        BODY
    }
}

/// Writes a case's picture and returns it as a note.
pub(crate) fn write(
    folder: &Path,
    name: &str,
    divided: &Divided,
    numbers: &[u32],
    wrong: &[bool],
) -> Result<Vec<(&'static str, String)>, StudyError> {
    let pixels: Vec<u8> = colours(divided, numbers, wrong).flatten().collect();
    let stem = file_stem(&format!("{STUDY}-{name}"));
    let path = write_rgb(folder, &stem, divided.eye.size(), &pixels)?;
    Ok(vec![("picture", path)])
}
