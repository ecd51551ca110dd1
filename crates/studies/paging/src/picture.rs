// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of what a frame shows: a colour for each level, a chessboard of pages, and lighter where a page is missing.
//! From afar: what of the globe the eye sees, and where levels meet. The quadtree itself, with its levels.

use crate::STUDY;
use crate::path::Eye;
use crate::residency::LEAF;
use crate::stage::Said;
use crate::texture::{PAGE, Page, level_of};
use std::path::Path;
use terrafill_core::Ellipsoid;
use terrafill_reference::SurfaceTriangles;
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

const WHITE: [u8; 3] = [255; 3];
const BLACK: [u8; 3] = [0; 3];
/// Of the star at the eye's place.
const STAR: [u8; 3] = [255, 40, 40];
/// A picture's side over the length of its rays.
const STAR_SHARE: i64 = 30;
/// A picture's side over the width of its lines.
const LINE_SHARE: i64 = 300;
/// Digits of levels, three columns by five rows from the top left; a bit a pixel.
const DIGITS: [u16; 8] = [
    0b111_101_101_101_111,
    0b010_110_010_010_111,
    0b111_001_111_100_111,
    0b111_001_111_001_111,
    0b101_101_111_001_001,
    0b111_100_111_001_111,
    0b111_100_111_101_111,
    0b111_001_010_010_010,
];

/// A picture that is drawn over.
struct Sheet {
    pixels: Vec<[u8; 3]>,
    size: [i64; 2],
}

impl Sheet {
    /// Sets pixels as wide as a line, from this one on.
    fn dot(&mut self, [x, y]: [i64; 2], colour: [u8; 3]) {
        let width = (self.size[0] / LINE_SHARE).max(1);
        for down in 0..width {
            for right in 0..width {
                self.set([x + right, y + down], colour);
            }
        }
    }

    /// Sets a pixel, where there is one.
    fn set(&mut self, [x, y]: [i64; 2], colour: [u8; 3]) {
        let [width, height] = self.size;
        if (0..width).contains(&x)
            && (0..height).contains(&y)
            && let Ok(at) = usize::try_from(y * width + x)
        {
            self.pixels[at] = colour;
        }
    }
}

#[allow(clippy::cast_possible_truncation, reason = "places in a picture")]
fn pixel([x, y]: [f64; 2]) -> [i64; 2] {
    [x.floor() as i64, y.floor() as i64]
}

fn sheet(pixels: &[[u8; 3]], eye: &Eye) -> Sheet {
    Sheet {
        pixels: pixels.to_vec(),
        size: [eye.size.width, eye.size.height].map(i64::from),
    }
}

/// A picture with the outline of what another eye sees, in white.
///
/// - `pixels`: as `eye` sees the globe
pub(crate) fn with_outline(pixels: &[[u8; 3]], eye: &Eye, other: &Eye) -> Vec<[u8; 3]> {
    let mut sheet = sheet(pixels, eye);
    let body = SurfaceTriangles::of_body(&Ellipsoid::WGS84, other.camera.eye_ecef);
    let [width, height] = [other.size.width, other.size.height].map(f64::from);
    // So many that neighbours are less than a pixel apart.
    let steps = 4 * other.size.width.max(other.size.height);
    for step in 0..=steps {
        let share = f64::from(step) / f64::from(steps);
        let (x, y) = (share * width, share * height);
        for place in [[x, 0.0], [x, height], [0.0, y], [width, y]] {
            let direction = other.camera.direction_ecef(other.size, place);
            let Some(depth) = body.hit(direction, other.camera.near_m) else {
                continue;
            };
            let at = other.camera.eye_ecef + direction * depth;
            let Some(at) = eye.camera.project_px(eye.size, at) else {
                continue;
            };
            sheet.dot(pixel(at), WHITE);
        }
    }
    sheet.pixels
}

/// A picture with white lines where levels meet, and a star below another eye.
///
/// - `levels`: of what each pixel shows
pub(crate) fn with_balance(
    pixels: &[[u8; 3]],
    levels: &[Option<u32>],
    eye: &Eye,
    other: &Eye,
) -> Vec<[u8; 3]> {
    let mut sheet = sheet(pixels, eye);
    let [width, height] = [eye.size.width, eye.size.height].map(|of| of as usize);
    for (at, own) in levels.iter().enumerate() {
        let [x, y] = [at % width, at / width];
        let right = (x + 1 < width).then(|| levels[at + 1]);
        let below = (y + 1 < height).then(|| levels[at + width]);
        let differs = |beside: Option<Option<u32>>| {
            beside.is_some_and(|beside| own.is_some() && beside.is_some() && beside != *own)
        };
        if differs(right) || differs(below) {
            sheet.dot(pixel([x as f64, y as f64]), WHITE);
        }
    }
    let foot = Ellipsoid::WGS84.geodetic_to_ecef(terrafill_core::Geodetic {
        height_m: 0.0,
        ..other.place
    });
    if let Some(at) = eye.camera.project_px(eye.size, foot) {
        let [x, y] = pixel(at);
        let reach = sheet.size[0] / STAR_SHARE;
        for along in -reach..=reach {
            for [right, down] in [[along, 0], [0, along], [along, along], [along, -along]] {
                sheet.dot([x + right, y + down], STAR);
            }
        }
    }
    sheet.pixels
}

/// The quadtree over the texture, north up: each leaf in its level's colour, outlined, with its level where there is room.
///
/// - `table`: entries of all pages
pub(crate) fn of_tree(table: &[u32], side_px: u32) -> Vec<[u8; 3]> {
    let side = i64::from(side_px);
    let count = usize::try_from(side * side).unwrap_or(0);
    let mut sheet = Sheet {
        pixels: vec![BLACK; count],
        size: [side; 2],
    };
    let leaves = (0..table.len()).filter(|number| table[*number] & LEAF != 0);
    for Page { level, x, y } in leaves.map(Page::numbered) {
        let edge = |at: u32| (i64::from(at) * side) >> level;
        let ([left, top], [right, bottom]) = ([x, y].map(edge), [x + 1, y + 1].map(edge));
        for row in top..bottom {
            for column in left..right {
                sheet.set([column, row], LEVELS[level.min(7) as usize]);
            }
        }
        for row in top..bottom {
            sheet.dot([left, row], WHITE);
        }
        for column in left..right {
            sheet.dot([column, top], WHITE);
        }
        // Five rows of digits and a row around them.
        let scale = ((right - left) / 9).min(side / 80);
        if scale > 0 {
            let corner = [
                (left + right - 3 * scale) / 2,
                (top + bottom - 5 * scale) / 2,
            ];
            digit(&mut sheet, level, corner, scale);
        }
    }
    sheet.pixels
}

/// A digit in white, `scale` pixels for each of its own.
fn digit(sheet: &mut Sheet, digit: u32, [left, top]: [i64; 2], scale: i64) {
    let bits = DIGITS[digit.min(7) as usize];
    for row in 0..5 * scale {
        for column in 0..3 * scale {
            let bit = 14 - (3 * (row / scale) + column / scale);
            if bits >> bit & 1 == 1 {
                sheet.set([left + column, top + row], WHITE);
            }
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::pages_above;

    /// The whole split once, and its first quarter again.
    fn table() -> Vec<u32> {
        let mut table = vec![0; pages_above(4) as usize];
        let [first, rest @ ..] = Page::ROOT.children();
        for page in first.children().into_iter().chain(rest) {
            table[page.number()] = LEAF;
        }
        table
    }

    #[test]
    fn a_tree_s_leaves_cover_its_picture_and_say_their_levels() {
        let table = table();
        let picture = of_tree(&table, 160);
        let at = |picture: &[[u8; 3]], x: usize, y: usize| picture[160 * y + x];
        assert!(picture.iter().all(|colour| *colour != BLACK));
        assert_eq!(
            [at(&picture, 5, 5), at(&picture, 100, 10)],
            [LEVELS[2], LEVELS[1]]
        );
        assert_eq!(at(&picture, 80, 30), WHITE, "an edge");
        // The digit 1 has its stem in the middle of a leaf of 80 pixels.
        assert_eq!(at(&picture, 120, 40), WHITE);
        assert_eq!(at(&picture, 117, 40), LEVELS[1]);
        // Negative control: a leaf that is lost leaves a hole.
        let mut lost = table;
        lost[Page::ROOT.children()[3].number()] = 0;
        assert_eq!(at(&of_tree(&lost, 160), 120, 120), BLACK);
    }

    #[test]
    fn what_an_eye_sees_is_outlined_from_afar_and_a_star_is_below_it() {
        let (near, far) = (
            Eye::over(15.0, 40.0, 2e6, 64),
            Eye::over(15.0, 40.0, 9e6, 64),
        );
        let pixels = vec![BLACK; 64 * 64];
        let outlined = with_outline(&pixels, &far, &near);
        let rows = |x: usize| (0..64).filter(|y| outlined[64 * y + x] == WHITE).count();
        assert!((2..8).contains(&rows(32)), "two edges: {}", rows(32));
        assert_eq!([rows(2), rows(61)], [0, 0]);
        assert_eq!(outlined[64 * 32 + 32], BLACK);
        // Negative control: the eye itself sees all of its picture.
        let own = with_outline(&pixels, &far, &far);
        assert!(own.iter().filter(|colour| **colour == WHITE).count() < 40);
        let levels: Vec<Option<u32>> = (0..64 * 64)
            .map(|at| (at % 64 > 2).then_some(u32::from(at % 64 < 20)))
            .collect();
        let balance = with_balance(&pixels, &levels, &far, &near);
        let white = balance.iter().filter(|colour| **colour == WHITE).count();
        assert_eq!(white, 64, "one line, and none beside the globe");
        assert_eq!(balance[64 * 5 + 19], WHITE);
        assert_eq!(balance[64 * 32 + 32], STAR);
    }
}
