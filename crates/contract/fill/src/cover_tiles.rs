// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rectangles of tiles for covers, in place of one rectangle around a whole region.
//!
//! A volume marks no pixel outside its projection, and it is the union of prisms, one on each facet of its cap: every
//! point of a prism lies between six corners. So the screen bounds of the facets' corners, below and above, hold all
//! that a volume marks. Of a region that is bent or made of islands they are a small part of its rectangle.

use crate::FillInput;
use glam::DVec3;
use terrafill_scene::{PixelRect, PlannedRegion};

/// Side of a tile, pixels.
const TILE_PX: u32 = 16;
/// What one rectangle more costs in pixels whose stencil is tested. From figures of a prototype on lavapipe, not measured
/// here: 0.13 µs a vertex, of which it has four, and 1.4 ns a pixel.
const RECTANGLE_PX: u64 = 400;
/// Pixels around a facet: what rounding may move a corner by, and more.
const MARGIN_PX: f64 = 1.0;

/// Tiles of a rectangle, row by row.
struct Tiles {
    rect: PixelRect,
    columns: u32,
    is_touched: Vec<bool>,
}

impl Tiles {
    fn new(rect: PixelRect) -> Self {
        let columns = rect.width().div_ceil(TILE_PX);
        let rows = rect.height().div_ceil(TILE_PX);
        Self {
            rect,
            columns,
            is_touched: vec![false; columns as usize * rows as usize],
        }
    }

    /// Everything between two corners in pixels.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the rectangle"
    )]
    fn touch(&mut self, [left, top]: [f64; 2], [right, bottom]: [f64; 2]) {
        let tile = |at: f64, first: u32, past: u32| {
            let at = at.clamp(f64::from(first), f64::from(past - 1));
            (at as u32 - first) / TILE_PX
        };
        let PixelRect {
            left: west,
            top: north,
            right: east,
            bottom: south,
        } = self.rect;
        let is_outside = right + MARGIN_PX < f64::from(west)
            || left - MARGIN_PX > f64::from(east)
            || bottom + MARGIN_PX < f64::from(north)
            || top - MARGIN_PX > f64::from(south);
        if is_outside {
            return;
        }
        let columns = tile(left - MARGIN_PX, west, east)..=tile(right + MARGIN_PX, west, east);
        for row in tile(top - MARGIN_PX, north, south)..=tile(bottom + MARGIN_PX, north, south) {
            let first = (row * self.columns) as usize;
            let own = first + *columns.start() as usize..=first + *columns.end() as usize;
            self.is_touched[own].fill(true);
        }
    }

    /// Runs of touched tiles in a row, joined with the same runs of rows above.
    fn rects(&self) -> Vec<PixelRect> {
        let mut done: Vec<PixelRect> = Vec::new();
        let mut above: Vec<PixelRect> = Vec::new();
        let rows = self.is_touched.chunks_exact(self.columns.max(1) as usize);
        for (row, tiles) in (0..).zip(rows) {
            let top = self.rect.top + row * TILE_PX;
            let bottom = (top + TILE_PX).min(self.rect.bottom);
            let mut now = Vec::new();
            let mut first = None;
            for (column, &is_touched) in (0..).zip(tiles.iter().chain([&false])) {
                match (is_touched, first) {
                    (true, None) => first = Some(column),
                    (false, Some(start)) => {
                        now.push(PixelRect {
                            left: self.rect.left + start * TILE_PX,
                            top,
                            right: (self.rect.left + column * TILE_PX).min(self.rect.right),
                            bottom,
                        });
                        first = None;
                    }
                    _ => {}
                }
            }
            let is_same = |a: &PixelRect, b: &PixelRect| (a.left, a.right) == (b.left, b.right);
            for rect in &mut now {
                if let Some(upper) = above.iter().position(|upper| is_same(upper, rect)) {
                    rect.top = above.swap_remove(upper).top;
                }
            }
            done.append(&mut above);
            above = now;
        }
        done.append(&mut above);
        done.sort_unstable_by_key(|rect| (rect.top, rect.left));
        done
    }
}

/// Rectangles that hold every pixel of a planned region's volume and no pixel twice. `None` where its one rectangle is
/// about as cheap. `None` also where the near plane may meet the volume, or the vertex stage bends it.
///
/// - cost: O(vertices and triangles of the mesh), and the tiles that they touch
pub(crate) fn cover_tiles(input: &FillInput, planned: &PlannedRegion) -> Option<Vec<PixelRect>> {
    let whole = planned.screen_rect.area();
    let is_bent = input.scene.footprints.contains_key(&planned.mesh);
    if planned.near_plane_meets_volume || is_bent || whole < 2 * RECTANGLE_PX {
        return None;
    }
    let body = &input.scene.body;
    let per_axis = body.radii_m().map(|radius| (radius * radius).recip());
    let mesh = &input.scene.meshes[planned.mesh];
    let bounds = |&vertex: &DVec3| {
        let normal = (vertex * per_axis).normalize();
        let at = |height_m: f64| {
            input
                .camera
                .project_px(input.size, vertex + normal * height_m)
        };
        let (low, high) = (at(planned.heights.bottom_m)?, at(planned.heights.top_m)?);
        Some([
            [low[0].min(high[0]), low[1].min(high[1])],
            [low[0].max(high[0]), low[1].max(high[1])],
        ])
    };
    let bounds: Option<Vec<[[f64; 2]; 2]>> = mesh.vertices_ecef.iter().map(bounds).collect();
    let bounds = bounds?;
    let mut tiles = Tiles::new(planned.screen_rect);
    for facet in &mesh.triangles {
        let corners = facet.map(|vertex| bounds[vertex as usize]);
        let least = |axis: usize| {
            corners
                .iter()
                .fold(f64::INFINITY, |least, corner| least.min(corner[0][axis]))
        };
        let most = |axis: usize| {
            corners
                .iter()
                .fold(f64::NEG_INFINITY, |most, corner| most.max(corner[1][axis]))
        };
        tiles.touch([least(0), least(1)], [most(0), most(1)]);
    }
    let rects = tiles.rects();
    let covered: u64 = rects.iter().map(|rect| rect.area()).sum();
    let dearer = RECTANGLE_PX * (rects.len() as u64).saturating_sub(1);
    (covered + dearer < whole).then_some(rects)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECT: PixelRect = PixelRect {
        left: 10,
        top: 20,
        right: 110,
        bottom: 130,
    };

    #[test]
    fn every_pixel_of_what_was_touched_is_in_one_rectangle() {
        let mut tiles = Tiles::new(RECT);
        let touched = [
            [[12.0, 25.0], [40.0, 27.0]],
            [[11.0, 30.0], [20.0, 128.0]],
            [[-50.0, 60.0], [400.0, 61.0]],
            // Outside.
            [[-50.0, -60.0], [400.0, 15.0]],
        ];
        for [least, most] in touched {
            tiles.touch(least, most);
        }
        let rects = tiles.rects();
        for y in 0..200 {
            for x in 0..200 {
                let holds = |rect: &&PixelRect| {
                    (rect.left..rect.right).contains(&x) && (rect.top..rect.bottom).contains(&y)
                };
                let count = rects.iter().filter(holds).count();
                let is_in = (RECT.left..RECT.right).contains(&x)
                    && (RECT.top..RECT.bottom).contains(&y)
                    && touched[..3].iter().any(|[least, most]| {
                        let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                        x >= least[0] && x <= most[0] && y >= least[1] && y <= most[1]
                    });
                assert!(count <= 1 && (count == 1 || !is_in), "{x} {y}: {count}");
            }
        }
        let covered: u64 = rects.iter().map(|rect| rect.area()).sum();
        assert!(covered < RECT.area() / 2, "{covered} of {}", RECT.area());
        assert!(rects.len() < 8, "{rects:?}");
        // Twin: one tile less, and what was touched is no longer held.
        let first = tiles.is_touched.iter().position(|touched| *touched);
        tiles.is_touched[first.expect("some")] = false;
        let fewer: u64 = tiles.rects().iter().map(|rect| rect.area()).sum();
        assert!(fewer < covered);
    }

    #[test]
    fn nothing_touched_is_nothing_covered() {
        assert_eq!(Tiles::new(RECT).rects(), []);
        let mut tiles = Tiles::new(RECT);
        tiles.touch([0.0; 2], [500.0; 2]);
        assert_eq!(tiles.rects(), [RECT]);
    }
}
