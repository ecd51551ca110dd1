// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rectangles of pixels: of a volume, of a caster's shadow, of what is above the horizon.

use crate::view::{DeckCamera, whole};
use glam::DVec3;
use terrafill_casters::Volume;
use terrafill_plan::PixelRect;

/// No pixel.
pub const NONE: PixelRect = PixelRect {
    left: 0,
    top: 0,
    right: 0,
    bottom: 0,
};

/// The smallest rectangle that holds both; [`NONE`] adds nothing.
pub fn joined(one: PixelRect, other: PixelRect) -> PixelRect {
    match (one, other) {
        (NONE, only) | (only, NONE) => only,
        _ => one.around(other),
    }
}

/// Pixels in which a triangle can be seen, and one more on every side.
///
/// - `corners`: relative to the eye; directions where they are at infinity
pub fn around(view: &DeckCamera, corners: &[DVec3; 3]) -> PixelRect {
    // Right, up and depth; the cone over the triangle is cut by the four sides of the view.
    let mut cone: Vec<DVec3> = corners
        .iter()
        .map(|corner| {
            let flat = [view.right, view.up].map(|axis| corner.dot(axis));
            DVec3::new(
                flat[0] / view.tan[0],
                flat[1] / view.tan[1],
                corner.dot(view.forward),
            )
        })
        .collect();
    let sides = [
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::new(-1.0, 0.0, 1.0),
        DVec3::new(0.0, 1.0, 1.0),
        DVec3::new(0.0, -1.0, 1.0),
    ];
    for side in sides {
        cone = cut(&cone, |place| side.dot(place));
    }
    let mut found: Option<[f64; 4]> = None;
    for place in cone.iter().filter(|place| place.z > 0.0) {
        let (x, y) = (place.x / place.z, place.y / place.z);
        let [left, right, bottom, top] = found.unwrap_or([x, x, y, y]);
        found = Some([left.min(x), right.max(x), bottom.min(y), top.max(y)]);
    }
    let Some([left, right, bottom, top]) = found else {
        return NONE;
    };
    let [left, right] = pixels(left, right, view.size[0]);
    let [top, bottom] = pixels(-top, -bottom, view.size[1]);
    PixelRect {
        left,
        top,
        right,
        bottom,
    }
}

/// Pixels of −1…1 that a range touches, one more on either side.
fn pixels(low: f64, high: f64, size: u32) -> [u32; 2] {
    let at = |share: f64| (share + 1.0) / 2.0 * f64::from(size);
    let end = |place: f64| whole(place.clamp(0.0, f64::from(size)));
    [end(at(low).floor() - 1.0), end(at(high).ceil() + 1.0)]
}

/// The part of a convex polygon on whose places `side` is not negative.
pub fn cut(ring: &[DVec3], side: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(ring.len() + 1);
    for (at, &place) in ring.iter().enumerate() {
        let next = ring[(at + 1) % ring.len()];
        let (here, there) = (side(place), side(next));
        if here >= 0.0 {
            kept.push(place);
        }
        if (here < 0.0) != (there < 0.0) {
            kept.push(place + (next - place) * (here / (here - there)));
        }
    }
    kept
}

/// Of each part, the depths between which its closed volume lies, m, wider by a share on either side.
pub fn depths_of_parts(
    view: &DeckCamera,
    volume: &Volume,
    parts: usize,
    share: f64,
) -> Vec<[f64; 2]> {
    let mut depths = vec![[f64::INFINITY, f64::NEG_INFINITY]; parts];
    for triangle in &volume.triangles {
        let [near, far] = &mut depths[triangle.part as usize];
        for corner in triangle.corners {
            let place = volume.vertices[corner as usize];
            let depth = view.forward.dot(place.truncate() - view.eye * place.w);
            *near = near.min(depth);
            *far = far.max(depth);
        }
    }
    let widened = |[near, far]: [f64; 2]| [near - share * near.abs(), far + share * far.abs()];
    depths.into_iter().map(widened).collect()
}

/// Of each part, the rectangle of its volume.
pub fn of_parts(view: &DeckCamera, volume: &Volume, parts: usize) -> Vec<PixelRect> {
    let mut rectangles = vec![NONE; parts];
    for triangle in &volume.triangles {
        let corners = triangle.corners.map(|corner| {
            let place = volume.vertices[corner as usize];
            place.truncate() - view.eye * place.w
        });
        let own = &mut rectangles[triangle.part as usize];
        *own = joined(*own, around(view, &corners));
    }
    rectangles
}

/// The pixels that lie whole above the horizon of the tangent plane: "above the sea" as a rectangle.
pub fn above_horizon(view: &DeckCamera) -> PixelRect {
    PixelRect {
        bottom: view.size[1] / 2,
        ..view.whole()
    }
}

/// The least rectangle that holds some pixels.
pub fn around_pixels(view: &DeckCamera, is_in: impl Fn(usize) -> bool) -> PixelRect {
    let pixels = (0..view.pixel_count()).filter(|at| is_in(*at));
    let rectangles = pixels.map(|at| {
        let [left, top] = view.pixel(at);
        let (right, bottom) = (left + 1, top + 1);
        PixelRect {
            left,
            top,
            right,
            bottom,
        }
    });
    rectangles.fold(NONE, joined)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(own: PixelRect, column: u32, row: u32) -> bool {
        (own.left..own.right).contains(&column) && (own.top..own.bottom).contains(&row)
    }

    #[test]
    fn a_rectangle_holds_the_pixels_of_its_triangle_behind_the_eye_too() {
        let view = DeckCamera::level(DVec3::ZERO, 0.0, 0.5, [40, 30]);
        let whole = [
            view.towards(-3.0, -3.0),
            view.towards(9.0, -3.0),
            view.towards(-3.0, 9.0),
        ];
        assert_eq!(around(&view, &whole), view.whole());
        let behind = whole.map(|corner| -corner);
        assert_eq!(around(&view, &behind), NONE);
        // From before the eye to behind it: everything right of the middle and above may be met.
        let through = [
            view.towards(0.0, 0.0),
            view.right - view.forward,
            view.up - view.forward,
        ];
        let found = around(&view, &through);
        assert!(
            holds(found, 39, 0) && holds(found, 20, 14) && !holds(found, 0, 29),
            "{found:?}"
        );
        let small = [
            view.towards(0.5, 0.5),
            view.towards(0.51, 0.5),
            view.towards(0.5, 0.51),
        ];
        let found = around(&view, &small);
        assert!(found.width() <= 4 && holds(found, 30, 7), "{found:?}");
    }

    #[test]
    fn pixels_are_held_and_nothing_holds_none() {
        let view = DeckCamera::level(DVec3::ZERO, 0.0, 0.5, [4, 3]);
        let found = around_pixels(&view, |at| at == 5 || at == 10);
        let sides = [found.left, found.top, found.right, found.bottom];
        assert_eq!(sides, [1, 1, 3, 3]);
        assert_eq!(around_pixels(&view, |_| false), NONE);
        assert!(!holds(above_horizon(&view), 0, 1));
    }
}
