// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of numbers: cells as a chessboard of two shades each, the sky, and in red what is wrong.

use crate::STUDY;
use crate::metrics::SIZE_PX;
use std::path::Path;
use terrafill_results::ConditionKey;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::Grid;
use terrafill_study::{Request, StudyError, file_stem, size_name, write_rgb};

/// Of a quick run that names no size: the published one is not known.
pub(crate) const PICTURE: ImageSize = square(256);

pub(crate) const fn square(side: u32) -> ImageSize {
    ImageSize::new(side, side)
}

/// Size of the request's pictures: square, of its smaller side.
pub(crate) fn size_of(request: &Request) -> ImageSize {
    let [width, height] = request.size_or([PICTURE.width, PICTURE.height]);
    square(width.min(height))
}

/// The size as a condition.
pub(crate) fn size_px(size: ImageSize) -> (ConditionKey, String) {
    (SIZE_PX, size_name([size.width, size.height]))
}

/// Red of a pixel that shows what it may not.
pub(crate) const WRONG: [u8; 3] = [230, 30, 30];
pub(crate) const SKY: [u8; 3] = [205, 225, 240];

/// Colour of a triangle of a grid with so many cells a side.
fn of_triangle(number: u32, cells: u32) -> [u8; 3] {
    let Some(index) = number.checked_sub(1) else {
        return SKY;
    };
    let cell = index / 2;
    let is_even = (cell % cells + cell / cells).is_multiple_of(2);
    match (is_even, index.is_multiple_of(2)) {
        (true, true) => [95, 130, 85],
        (true, false) => [115, 155, 100],
        (false, true) => [190, 175, 130],
        (false, false) => [215, 200, 155],
    }
}

/// Colour of a point, dark before the sky.
fn of_point(number: u32) -> [u8; 3] {
    if number == 0 { SKY } else { [60, 80, 60] }
}

/// Colours of triangles' or points' numbers, red where they are wrong.
///
/// - `cells`: a side of the grid; `None` for points
/// - `wrong`: of each pixel, whether it may not show what it shows
pub(crate) fn of_numbers<'a>(
    numbers: &'a [u32],
    cells: Option<u32>,
    wrong: &'a [bool],
) -> impl Iterator<Item = [u8; 3]> + 'a {
    let pixels = numbers.iter().zip(wrong);
    pixels.map(move |(number, is_wrong)| match (is_wrong, cells) {
        (true, _) => WRONG,
        (false, None) => of_point(*number),
        (false, Some(cells)) => of_triangle(*number, cells),
    })
}

/// Colours of a grid's triangles as light from the upper left shows their slopes.
pub(crate) fn of_relief<'a>(
    numbers: &'a [u32],
    grid: &'a Grid,
) -> impl Iterator<Item = [u8; 3]> + 'a {
    let light = glam::DVec3::new(-0.5, 0.4, 0.77).normalize();
    numbers.iter().map(move |number| {
        let Some(index) = number.checked_sub(1) else {
            return SKY;
        };
        let (column, row) = (index / 2 % grid.cells, index / 2 / grid.cells);
        let half = index % 2;
        let height = |x: u32, y: u32| {
            let [x, y] = [column + x, row + y].map(|at| at.min(grid.cells));
            f64::from(grid.heights[grid.index(x, y)])
        };
        let x = height(1, half) - height(0, half);
        let y = height(half, 1) - height(half, 0);
        let normal = glam::DVec3::new(-x, -y, grid.step_m()).normalize();
        #[allow(clippy::cast_possible_truncation, reason = "held between 0 and 255")]
        let shade = |of: f64| (of * (0.15 + 0.95 * normal.dot(light).max(0.0))).min(255.0) as u8;
        [shade(170.0), shade(185.0), shade(140.0)]
    })
}

/// Colours of which lights reach a pixel: the lighter, the more of them.
///
/// - `numbers`: 0 for the sky, else 1 plus a bit for each light
pub(crate) fn of_lights(numbers: &[u32], lights: usize) -> impl Iterator<Item = [u8; 3]> {
    let most = u32::try_from(lights.max(1)).unwrap_or(1);
    numbers.iter().map(move |number| {
        let Some(mask) = number.checked_sub(1) else {
            return SKY;
        };
        // Never black, never as light as the sky.
        let grey = u8::try_from(40 + 180 * mask.count_ones().min(most) / most).unwrap_or(u8::MAX);
        [grey, grey, grey - 20]
    })
}

/// Colours of shares of light, below 0 the sky; what is no number is red.
pub(crate) fn of_shares(shares: &[f32]) -> impl Iterator<Item = [u8; 3]> {
    shares.iter().map(|share| {
        if *share < 0.0 {
            SKY
        } else if share.is_finite() {
            #[allow(clippy::cast_possible_truncation, reason = "held between 0 and 255")]
            let grey = (255.0 * share.clamp(0.0, 1.0)) as u8;
            [grey; 3]
        } else {
            WRONG
        }
    })
}

/// Writes a case's picture and returns it as a note.
pub(crate) fn write(
    folder: &Path,
    name: &str,
    size: ImageSize,
    pixels: impl Iterator<Item = [u8; 3]>,
) -> Result<Vec<(&'static str, String)>, StudyError> {
    let pixels: Vec<u8> = pixels.flatten().collect();
    let stem = file_stem(&format!("{STUDY}-{name}"));
    let path = write_rgb(folder, &stem, [size.width, size.height], &pixels)?;
    Ok(vec![("picture", path)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_towards_the_light_are_lighter_than_those_away_from_it() {
        let mut grid = Grid::new(2);
        grid.heights = (0..9).map(|vertex| [0.0, 500.0, 0.0][vertex % 3]).collect();
        let colours: Vec<_> = of_relief(&[0, 1, 3], &grid).collect();
        // The first cell falls to the left, from where the light comes.
        assert!(
            colours[0] == SKY && colours[1][0] > colours[2][0],
            "{colours:?}"
        );
    }

    #[test]
    fn halves_cells_and_sky_look_different() {
        let colours = [0, 1, 2, 3, 4].map(|number| of_triangle(number, 8));
        for (index, colour) in colours.iter().enumerate() {
            assert!(
                !colours[..index].contains(colour) && *colour != WRONG,
                "{index}"
            );
        }
        assert_ne!(of_point(0), of_point(1));
    }
}
