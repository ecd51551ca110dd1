// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rectangles of tiles for covers, in place of one rectangle around a whole region.
//!
//! A volume marks no pixel outside its projection, and it is the union of prisms, one on each facet of its cap: every
//! point of a prism lies between six corners. So the screen bounds of the facets' corners, below and above, hold all
//! that a volume marks. Of a region that is bent or made of islands they are a small part of its rectangle.

use glam::{DMat3, DVec2, DVec3};
use std::ops::Range;
use terrafill_contract::{FillInput, count_u32};
use terrafill_core::{Ellipsoid, VolumeHeights};
use terrafill_plan::{NearRectangle, PixelRect, PlannedRegion};
use terrafill_scene::{Camera, ImageSize};

/// Side of a tile, pixels.
const TILE_PX: u32 = 16;
/// What one rectangle more costs in pixels whose stencil is tested. From figures of a prototype on lavapipe, not measured
/// here: 0.13 µs a vertex, of which it has four, and 1.4 ns a pixel.
const RECTANGLE_PX: u64 = 400;
/// Pixels that a region's rectangle has at least for each facet that is looked at: about as many as a large GPU tests
/// while a CPU looks at one. A software device would gain with fewer.
const FACET_PX: u64 = 512;
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
    fn touch(&mut self, [least, most]: [DVec2; 2]) {
        let margin = DVec2::splat(MARGIN_PX);
        let (least, most) = (least - margin, most + margin);
        let rect = self.rect;
        let columns = tiles_of([least.x, most.x], [rect.left, rect.right]);
        let rows = tiles_of([least.y, most.y], [rect.top, rect.bottom]);
        for row in rows {
            let first = (row * self.columns) as usize;
            let own = first + columns.start as usize..first + columns.end as usize;
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

/// Numbers of the tiles between two places along a side of a rectangle.
#[allow(clippy::cast_possible_truncation, reason = "clamped to the rectangle")]
fn tiles_of([from, to]: [f64; 2], [first, past]: [u32; 2]) -> Range<u32> {
    let is_outside = to < f64::from(first) || from > f64::from(past);
    if is_outside || first >= past {
        return 0..0;
    }
    let tile = |at: f64| (at.clamp(f64::from(first), f64::from(past - 1)) as u32 - first) / TILE_PX;
    tile(from)..tile(to) + 1
}

/// A view's projection, for many points.
struct Projection {
    view_from_ecef: DMat3,
    eye_ecef: DVec3,
    near_m: f64,
    middle_px: DVec2,
    /// Pixels of a step as far as it is ahead, to the right and up.
    scale_px: DVec2,
}

impl Projection {
    fn new(camera: &Camera, size: ImageSize) -> Self {
        let height_px = f64::from(size.height);
        let scale_px = height_px / (2.0 * camera.tan_half_fov());
        Self {
            view_from_ecef: camera.view_from_ecef,
            eye_ecef: camera.eye_ecef,
            near_m: camera.near_m,
            middle_px: 0.5 * DVec2::new(f64::from(size.width), height_px),
            scale_px: DVec2::new(scale_px, -scale_px),
        }
    }

    fn is_in_front(&self, view: DVec3) -> bool {
        -view.z >= self.near_m
    }

    /// Of a point in front of the near plane, metres in axes of the view.
    fn px(&self, view: DVec3) -> DVec2 {
        self.middle_px + self.scale_px * view.truncate() / -view.z
    }

    /// Where the line between two points meets the near plane, if it does.
    fn cut_px(&self, one: DVec3, other: DVec3) -> Option<DVec2> {
        let [from, to] = [one, other].map(|view| -view.z - self.near_m);
        let is_cut = (from < 0.0) != (to < 0.0);
        is_cut.then(|| self.px(one.lerp(other, from / (from - to))))
    }
}

/// A vertex from the bottom of its volume to the top.
#[derive(Debug, Clone, Copy)]
enum Post {
    NotLookedAt,
    /// Its screen bounds.
    InFront([DVec2; 2]),
    /// The near plane cuts it, or it lies behind.
    NotInFront,
}

/// Posts of a mesh's vertices, as facets ask for them.
struct Posts<'a> {
    projection: Projection,
    /// Turns a vertex into a multiple of its geodetic normal.
    per_axis: DVec3,
    heights: VolumeHeights,
    vertices_ecef: &'a [DVec3],
    known: Vec<Post>,
}

impl<'a> Posts<'a> {
    fn new(
        projection: Projection,
        body: &Ellipsoid,
        heights: VolumeHeights,
        vertices_ecef: &'a [DVec3],
    ) -> Self {
        let radii_m = body.radii_m();
        Self {
            projection,
            per_axis: (radii_m * radii_m).recip(),
            heights,
            known: vec![Post::NotLookedAt; vertices_ecef.len()],
            vertices_ecef,
        }
    }

    /// Both ends, metres in axes of the view.
    fn ends(&self, vertex: u32) -> [DVec3; 2] {
        let on_body = self.vertices_ecef[vertex as usize];
        let to_view = self.projection.view_from_ecef;
        let up = to_view * (on_body * self.per_axis).normalize();
        let on_body = to_view * (on_body - self.projection.eye_ecef);
        [self.heights.bottom_m, self.heights.top_m].map(|height_m| on_body + up * height_m)
    }

    fn post(&mut self, vertex: u32) -> Post {
        if matches!(self.known[vertex as usize], Post::NotLookedAt) {
            let ends = self.ends(vertex);
            let post = match ends.map(|end| self.projection.is_in_front(end)) {
                [true, true] => {
                    let [bottom, top] = ends.map(|end| self.projection.px(end));
                    Post::InFront([bottom.min(top), bottom.max(top)])
                }
                _ => Post::NotInFront,
            };
            self.known[vertex as usize] = post;
        }
        self.known[vertex as usize]
    }

    /// Screen bounds of the prism on a facet, as far as it lies in front of the near plane; `None` where nothing does.
    fn bounds(&mut self, facet: [u32; 3]) -> Option<[DVec2; 2]> {
        let posts = facet.map(|vertex| self.post(vertex));
        if let [Post::InFront(a), Post::InFront(b), Post::InFront(c)] = posts {
            return Some([a[0].min(b[0]).min(c[0]), a[1].max(b[1]).max(c[1])]);
        }
        let corners = facet.map(|vertex| self.ends(vertex));
        let corners = corners.as_flattened();
        let projection = &self.projection;
        let in_front = corners.iter().filter(|&&end| projection.is_in_front(end));
        // Lines between all corners: those that are no edges lie in the prism as well.
        let lines = corners.iter().enumerate();
        let lines =
            lines.flat_map(|(at, &one)| corners[..at].iter().map(move |&other| (one, other)));
        let cuts = lines.filter_map(|(one, other)| projection.cut_px(one, other));
        let all = in_front.map(|&end| projection.px(end)).chain(cuts);
        all.map(|px| [px, px])
            .reduce(|[least, most], [low, high]| [least.min(low), most.max(high)])
    }
}

/// Rectangles that hold every pixel of a planned region's volume and no pixel twice. `None` where its one rectangle is
/// about as cheap, or has few pixels for each facet that is drawn. `None` also where the near plane may meet or lie in
/// the volume, which then is around the eye and fills its rectangle, or the vertex stage bends it.
///
/// - cost: O(drawn facets), and the tiles that they touch
pub(crate) fn cover_tiles(input: &FillInput, planned: &PlannedRegion) -> Option<Vec<PixelRect>> {
    let whole_px = planned.screen_rect.area();
    let is_bent = input.scene.footprints.contains_key(&planned.mesh);
    if planned.near_rectangle != NearRectangle::Outside || is_bent || whole_px < 2 * RECTANGLE_PX {
        return None;
    }
    let mesh = &input.scene.meshes[planned.mesh];
    let all = 0..count_u32("facets", mesh.triangles.len()).ok()?;
    let seen = input.plan.seen_parts.get(&planned.mesh);
    let ranges = seen.map_or(std::slice::from_ref(&all), |seen| &seen.caps);
    let drawn: usize = ranges.iter().map(ExactSizeIterator::len).sum();
    if whole_px < FACET_PX * drawn as u64 {
        return None;
    }
    let order = seen.and_then(|_| input.scene.parts_of(planned.mesh));
    let projection = Projection::new(&input.camera, input.size);
    let body = &input.scene.body;
    let mut posts = Posts::new(projection, body, planned.heights, &mesh.vertices_ecef);
    let mut tiles = Tiles::new(planned.screen_rect);
    for place in ranges.iter().cloned().flatten() {
        let facet = order.map_or(place, |parts| parts.triangles()[place as usize]);
        if let Some(bounds) = posts.bounds(mesh.triangles[facet as usize]) {
            tiles.touch(bounds);
        }
    }
    let rects = tiles.rects();
    let covered: u64 = rects.iter().map(|rect| rect.area()).sum();
    let dearer = RECTANGLE_PX * (rects.len() as u64).saturating_sub(1);
    (covered + dearer < whole_px).then_some(rects)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::Geodetic;
    use terrafill_scene::CameraPose;

    const RECT: PixelRect = PixelRect {
        left: 10,
        top: 20,
        right: 110,
        bottom: 130,
    };

    #[test]
    fn every_pixel_of_what_was_touched_is_in_one_rectangle() {
        let mut tiles = Tiles::new(RECT);
        let touched: [[[f64; 2]; 2]; 4] = [
            [[12.0, 25.0], [40.0, 27.0]],
            [[11.0, 30.0], [20.0, 128.0]],
            [[-50.0, 60.0], [400.0, 61.0]],
            // Outside.
            [[-50.0, -60.0], [400.0, 15.0]],
        ];
        for bounds in touched {
            tiles.touch(bounds.map(DVec2::from_array));
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
        // Negative control: one tile less, and what was touched is no longer held.
        let first = tiles.is_touched.iter().position(|touched| *touched);
        tiles.is_touched[first.expect("some")] = false;
        let fewer: u64 = tiles.rects().iter().map(|rect| rect.area()).sum();
        assert!(fewer < covered);
    }

    #[test]
    fn nothing_touched_is_nothing_covered() {
        assert_eq!(Tiles::new(RECT).rects(), []);
        let mut tiles = Tiles::new(RECT);
        tiles.touch([DVec2::ZERO, DVec2::splat(500.0)]);
        assert_eq!(tiles.rects(), [RECT]);
    }

    /// Facets around an eye that looks along the ground, of all sizes, so that the near plane cuts some.
    #[test]
    fn what_is_in_front_of_the_near_plane_lies_within_a_facets_bounds() {
        let body = Ellipsoid::WGS84;
        let size = ImageSize::new(640, 480);
        let pose = CameraPose {
            eye: Geodetic::from_degrees(10.0, 50.0, 2_000.0),
            heading_rad: 0.3,
            pitch_rad: -0.2,
            fov_y_rad: 0.8,
            near_m: 500.0,
        };
        let camera = Camera::new(&body, &pose);
        let heights = VolumeHeights {
            top_m: 900.0,
            bottom_m: -700.0,
        };
        let place = |[longitude, latitude]: [f64; 2], height_m: f64| {
            body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, height_m))
        };
        let mut random = 2007_u64;
        let mut share = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut cut, mut behind, mut missed) = (0, 0, 0);
        for number in 0..400 {
            let reach_deg = 10_f64.powf(-2.0 + f64::from(number % 4));
            let corners: [[f64; 2]; 3] = std::array::from_fn(|_| {
                [10.0, 50.0].map(|at| at + reach_deg * (2.0 * share() - 1.0))
            });
            let vertices = corners.map(|corner| place(corner, 0.0));
            let projection = Projection::new(&camera, size);
            let mut posts = Posts::new(projection, &body, heights, &vertices);
            let bounds = posts.bounds([0, 1, 2]);
            let whole = posts
                .known
                .iter()
                .all(|post| matches!(post, Post::InFront(_)));
            cut += usize::from(!whole && bounds.is_some());
            behind += usize::from(bounds.is_none());
            for _ in 0..100 {
                let mut weights = [share(), share(), share()];
                let sum: f64 = weights.iter().sum();
                weights = weights.map(|weight| weight / sum);
                let up = share();
                let point: DVec3 = (0..3)
                    .map(|corner| {
                        let height_m = heights.bottom_m + up * (heights.top_m - heights.bottom_m);
                        place(corners[corner], height_m) * weights[corner]
                    })
                    .sum();
                let Some(px) = camera.project_px(size, point).map(DVec2::from) else {
                    continue;
                };
                let slack = DVec2::splat(1e-6) * (1.0 + px.abs());
                let [least, most] = bounds.expect("something is in front");
                assert!(
                    (px - least + slack).min_element() >= 0.0
                        && (most - px + slack).min_element() >= 0.0,
                    "{number}: {px} outside {least} {most}"
                );
                // Negative control: the ends in front alone do not hold all.
                let ends = posts.known.iter().filter_map(|post| match post {
                    Post::InFront(ends) => Some(*ends),
                    _ => None,
                });
                let alone = ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
                let holds = |[least, most]: [DVec2; 2]| {
                    (px - least).min_element() >= 0.0 && (most - px).min_element() >= 0.0
                };
                missed += usize::from(!whole && !alone.is_some_and(holds));
            }
        }
        assert!(
            cut > 20 && behind > 5 && missed > 100,
            "{cut} {behind} {missed}"
        );
    }
}
