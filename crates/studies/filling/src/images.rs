// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of a run, as PNG files in its folder.

use terrafill_scene::ImageSize;

/// Parts of a case's name as a file name.
pub(crate) fn file_stem(parts: &[&str]) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    let text = parts.join("_");
    text.chars()
        .map(|c| if is_plain(c) { c } else { '-' })
        .collect()
}

/// Part of an RGB picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct CutOut {
    pub(crate) size: ImageSize,
    /// Column and row of its first pixel in the whole.
    pub(crate) start: [usize; 2],
    pub(crate) rgb: Vec<u8>,
}

/// Part of an RGB picture round `centre`, at most `side` pixels a side; at a rim it stays inside.
pub(crate) fn cut_out(size: ImageSize, centre: [usize; 2], side: u32, rgb: &[u8]) -> CutOut {
    let smaller = ImageSize::new(size.width.min(side), size.height.min(side));
    let start = |centre: usize, whole: u32, part: u32| {
        let furthest = (whole - part) as usize;
        centre.saturating_sub(part as usize / 2).min(furthest)
    };
    let left = start(centre[0], size.width, smaller.width);
    let top = start(centre[1], size.height, smaller.height);
    let rows = rgb.chunks_exact(3 * size.width as usize);
    let cut = rows
        .skip(top)
        .take(smaller.height as usize)
        .flat_map(|row| &row[3 * left..3 * (left + smaller.width as usize)]);
    CutOut {
        size: smaller,
        start: [left, top],
        rgb: cut.copied().collect(),
    }
}

/// Side of the part that [`zoomed`] shows, pixels: the band of 1 px and what is round it.
pub(crate) const ZOOMED_PX: u32 = 24;
/// How large it draws a pixel.
const ZOOM: usize = 10;
/// Between two parts, pixels.
const GAP_PX: usize = 10;
/// The frame round the pixel in the middle.
const FRAME: [u8; 3] = [255, 255, 255];

/// The same part of several RGB pictures side by side, enlarged, with a frame round the pixel `at`.
pub(crate) fn zoomed(size: ImageSize, at: [usize; 2], pictures: &[&[u8]]) -> (ImageSize, Vec<u8>) {
    let cuts = pictures
        .iter()
        .map(|rgb| cut_out(size, at, ZOOMED_PX, rgb))
        .collect::<Vec<_>>();
    let part = cuts.first().map_or(size, |cut| cut.size);
    let (columns, rows) = (part.width as usize, part.height as usize);
    let step = columns * ZOOM + GAP_PX;
    let width = (step * cuts.len()).saturating_sub(GAP_PX);
    let mut rgb = vec![0; 3 * width * rows * ZOOM];
    for (index, cut) in cuts.iter().enumerate() {
        for (y, row) in rgb.chunks_exact_mut(3 * width).enumerate() {
            for x in 0..columns * ZOOM {
                let (pixel, place) = ([x / ZOOM, y / ZOOM], [x % ZOOM, y % ZOOM]);
                let is_rim = place.into_iter().any(|at| at == 0 || at + 1 == ZOOM);
                let is_it = [0, 1].map(|axis| cut.start[axis] + pixel[axis]) == at;
                let from = 3 * (pixel[1] * columns + pixel[0]);
                let colour = if is_rim && is_it {
                    &FRAME
                } else {
                    &cut.rgb[from..from + 3]
                };
                let to = 3 * (index * step + x);
                row[to..to + 3].copy_from_slice(colour);
            }
        }
    }
    let whole = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
    let size = ImageSize::new(whole(width), whole(rows * ZOOM));
    (size, rgb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_out_lies_round_its_centre() {
        const SIDE: u32 = 480;
        let size = ImageSize::new(SIDE + 2, 3);
        let mut rgb = vec![0; 3 * size.pixel_count()];
        rgb[..3].fill(1);
        rgb[3..6].fill(2);
        let cut = cut_out(size, [SIDE as usize / 2 + 1, 1], SIDE, &rgb);
        assert_eq!((cut.size.width, cut.size.height), (SIDE, 3));
        assert_eq!(cut.rgb.len(), 3 * cut.size.pixel_count());
        assert_eq!(cut.rgb[..3], [2; 3], "a column is cut off on the left");
        assert_eq!(cut.start, [1, 0]);
        // At a rim it stays inside.
        let cut = cut_out(size, [0, 2], SIDE, &rgb);
        assert_eq!((cut.size.width, &cut.rgb[..3]), (SIDE, &[1_u8; 3][..]));
        // One that is small enough stays whole.
        let small = ImageSize::new(2, 1);
        let cut = cut_out(small, [1, 0], SIDE, &[7; 6]);
        assert_eq!((cut.size, cut.rgb), (small, vec![7; 6]));
    }

    #[test]
    fn a_pixel_is_enlarged_and_framed_where_it_is() {
        let size = ImageSize::new(30, 26);
        let mut rgb = vec![0; 3 * size.pixel_count()];
        let at = [29, 1];
        rgb[3 * (30 + 29)..][..3].copy_from_slice(&[255, 30, 40]);
        let blank = vec![9; rgb.len()];
        let (zoomed_size, pixels) = zoomed(size, at, &[&rgb, &blank]);
        assert_eq!((zoomed_size.width, zoomed_size.height), (490, 240));
        assert_eq!(pixels.len(), 3 * zoomed_size.pixel_count());
        let colours = |wanted: [u8; 3]| pixels.chunks(3).filter(|c| **c == wanted).count();
        assert_eq!(colours([255, 30, 40]), 8 * 8);
        assert_eq!(colours(FRAME), 2 * (100 - 64));
        // The last column of the first part, one row down.
        let middle = 3 * (15 * 490 + 235);
        assert_eq!(pixels[middle..middle + 3], [255, 30, 40]);
        // Negative control: without the pixel there is no such colour.
        let (_, none) = zoomed(size, at, &[&blank]);
        assert!(!none.chunks(3).any(|colour| colour == [255, 30, 40]));
    }
}
