// SPDX-License-Identifier: MIT OR Apache-2.0
//! Depth bounds by tiles, after the clamping of CC shadow volumes (Lloyd et al., 2004).
//!
//! A caster is drawn only in those tiles of the picture in which some depth lies in the range of its volume.
//!
//! Exact for closed volumes: in a tile that is left out each pixel sees what lies outside of the volume, whose
//! faces cancel there.

use terrafill_plan::PixelRect;
use terrafill_scene::ImageSize;
use terrafill_stencil::{DepthRange, Volume};

/// Pixels along a tile, as where a GPU keeps a least and a greatest depth.
const TILE: u32 = 16;

/// Depths of the surface in a tile; sky left out.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tile {
    rect: PixelRect,
    low: f32,
    high: f32,
}

/// Rows of tiles, from above.
fn tiles(size: ImageSize, depth: &[f32]) -> Vec<Vec<Tile>> {
    let starts = |extent: u32| (0..extent).step_by(TILE as usize);
    let tile = |left: u32, top: u32| {
        let rect = PixelRect {
            left,
            top,
            right: size.width.min(left + TILE),
            bottom: size.height.min(top + TILE),
        };
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for row in rect.top..rect.bottom {
            let first = row as usize * size.width as usize;
            let own = &depth[first + rect.left as usize..first + rect.right as usize];
            for depth in own.iter().filter(|depth| **depth > 0.0) {
                (low, high) = (low.min(*depth), high.max(*depth));
            }
        }
        Tile { rect, low, high }
    };
    let row = |top| starts(size.width).map(|left| tile(left, top)).collect();
    starts(size.height).map(row).collect()
}

/// Volumes cut to the tiles whose depths meet their ranges; tiles that lie beside or over each other are one
/// rectangle.
///
/// - `depth`: of what is seen, reversed, row by row; 0 for the sky
pub(crate) fn tiled(volumes: &[Volume], size: ImageSize, depth: &[f32]) -> Vec<Volume> {
    let tiles = tiles(size, depth);
    let mut all = Vec::new();
    for volume in volumes {
        let mut rects: Vec<PixelRect> = Vec::new();
        for row in &tiles {
            let mut runs: Vec<PixelRect> = Vec::new();
            // A depth between the least and the greatest of a tile may be in the range.
            let DepthRange { low, high } = volume.depth;
            for tile in row.iter().filter(|own| own.low <= high && low <= own.high) {
                match runs.last_mut().filter(|last| last.right == tile.rect.left) {
                    Some(last) => last.right = tile.rect.right,
                    None => runs.push(tile.rect),
                }
            }
            for run in runs {
                let above = rects.iter_mut().find(|own| {
                    own.bottom == run.top && [own.left, own.right] == [run.left, run.right]
                });
                match above {
                    Some(above) => above.bottom = run.bottom,
                    None => rects.push(run),
                }
            }
        }
        let cut = rects
            .into_iter()
            .map(|rect| rect.within(volume.screen_rect));
        let seen = cut.filter(|rect| rect.area() > 0);
        all.extend(seen.map(|screen_rect| Volume {
            screen_rect,
            ..*volume
        }));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_shadow_views::listed;

    #[test]
    fn a_volume_is_drawn_where_depths_are_in_its_range_and_nowhere_else() {
        let size = ImageSize::new(40, 40);
        // The upper half far away, a spot in the lower one near, the rest sky.
        let mut depth = vec![0.0; 1600];
        depth[..800].fill(0.01);
        depth[35 * 40 + 20] = 0.5;
        let volume = |low, high| Volume {
            depth: DepthRange { low, high },
            ..listed(PixelRect::full(size), 7)
        };
        let rects = |low, high| {
            let found = tiled(&[volume(low, high)], size, &depth);
            assert!(found.iter().all(|own| own.geometry == 7));
            let sides = |rect: PixelRect| [rect.left, rect.top, rect.right, rect.bottom];
            let rects = found.iter().map(|own| sides(own.screen_rect));
            rects.collect::<Vec<_>>()
        };
        // Rows 0 to 19 reach into the second row of tiles, which joins the first.
        assert_eq!(rects(0.005, 0.02), [[0, 0, 40, 32]]);
        assert_eq!(rects(0.4, 0.6), [[16, 32, 32, 40]]);
        assert_eq!(rects(0.6, 0.7), [] as [[u32; 4]; 0]);
        // In between, where no pixel is: no tile holds both.
        assert_eq!(rects(0.1, 0.2), [] as [[u32; 4]; 0]);
        assert_eq!(rects(0.0, 1.0).len(), 2);
    }
}
