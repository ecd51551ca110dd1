// SPDX-License-Identifier: MIT OR Apache-2.0
//! Eyes in the port: metres, ENU, a level camera of the published channel.

use glam::DVec3;
use terrafill_casters::Mesh;
use terrafill_plan::PixelRect;
use terrafill_results::SplitMix64;
use terrafill_scene::ImageSize;

/// Field of view of one of seven channels over 270°, degrees.
const CHANNEL_DEG: f64 = 270.0 / 7.0;
/// Height of an eye over the deck, and of the deck over the sea, m.
const WALKER_M: f64 = 1.7 + 7.2;
/// Seed of the eyes on deck.
const EYES_SEED: u64 = 400;
/// Pixels of what an eye on deck sees.
pub const EYE_SIZE: [u32; 2] = [200, 150];

/// A camera on the bridge, on deck, or made up by a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeckCamera {
    /// m.
    pub eye: DVec3,
    /// Unit vector.
    pub forward: DVec3,
    /// Unit vector.
    pub right: DVec3,
    /// Unit vector.
    pub up: DVec3,
    /// Tangents of half the field of view.
    pub tan: [f64; 2],
    /// Distance of the near plane, m.
    pub near: f64,
    /// Pixels.
    pub size: [u32; 2],
}

impl DeckCamera {
    /// A level camera.
    ///
    /// - `azimuth_deg`: counter-clockwise from x
    pub fn level(eye: DVec3, azimuth_deg: f64, near: f64, size: [u32; 2]) -> Self {
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        let half = (CHANNEL_DEG / 2.0).to_radians().tan();
        // Square pixels, as devices have them: 29.4° high at 4 : 3.
        let rows = f64::from(size[1]) / f64::from(size[0]);
        Self {
            eye,
            forward: DVec3::new(cos, sin, 0.0),
            right: DVec3::new(sin, -cos, 0.0),
            up: DVec3::Z,
            tan: [half, half * rows],
            near,
            size,
        }
    }

    /// The same camera, looking down from the level.
    pub fn turned_down(mut self, degrees: f64) -> Self {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (forward, up) = (self.forward, self.up);
        self.forward = forward * cos - up * sin;
        self.up = up * cos + forward * sin;
        self
    }

    /// The same channel in a picture of another size: as wide, and as high as square pixels make it.
    pub fn sized(mut self, size: [u32; 2]) -> Self {
        self.tan[1] = self.tan[0] * f64::from(size[1]) / f64::from(size[0]);
        self.size = size;
        self
    }

    /// The middle of the same channel at so many pixels across it: they are finer, and as many as before.
    pub fn middle_of(mut self, columns: f64) -> Self {
        let share = f64::from(self.size[0]) / columns;
        self.tan = self.tan.map(|tan| tan * share);
        self
    }

    /// Direction through a place of the image, −1…1 rightwards and upwards; 1 m deep.
    pub fn towards(&self, x: f64, y: f64) -> DVec3 {
        self.forward + self.right * (x * self.tan[0]) + self.up * (y * self.tan[1])
    }

    /// Direction through a pixel's centre; rows downwards.
    pub fn ray(&self, column: u32, row: u32) -> DVec3 {
        self.ray_beside(column, row, [0.0; 2])
    }

    /// The same, so many pixels beside it.
    pub fn ray_beside(&self, column: u32, row: u32, [right, down]: [f64; 2]) -> DVec3 {
        let share = |at: u32, beside: f64, of: u32| {
            (2.0 * (f64::from(at) + beside) + 1.0) / f64::from(of) - 1.0
        };
        let [columns, rows] = self.size;
        self.towards(share(column, right, columns), -share(row, down, rows))
    }

    /// Corners of the near rectangle, in turn.
    pub fn near_corners(&self) -> [DVec3; 4] {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        corners.map(|[x, y]| self.eye + self.towards(x, y) * self.near)
    }

    /// Of its picture.
    pub fn image_size(&self) -> ImageSize {
        let [width, height] = self.size;
        ImageSize { width, height }
    }

    /// All pixels.
    pub fn whole(&self) -> PixelRect {
        PixelRect::full(self.image_size())
    }

    /// Of its picture.
    pub fn pixel_count(&self) -> usize {
        self.image_size().pixel_count()
    }

    /// Column and row of the pixel of this index.
    pub fn pixel(&self, at: usize) -> [u32; 2] {
        let width = self.size[0] as usize;
        [at % width, at / width].map(|at| u32::try_from(at).unwrap_or(0))
    }
}

/// A place in a picture or a grid without its fraction. Whoever calls makes sure that it lies there.
#[allow(clippy::cast_possible_truncation, reason = "from 0 to below 2³²")]
pub fn whole(place: f64) -> u32 {
    place as u32
}

/// Least and greatest coordinates of places.
pub fn box_of<'a>(places: impl IntoIterator<Item = &'a DVec3>) -> [DVec3; 2] {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let places = places.into_iter();
    places.fold(none, |[low, high], place| {
        [low.min(*place), high.max(*place)]
    })
}

/// A unit vector towards the sun.
pub fn sun([elevation_deg, azimuth_deg]: [f64; 2]) -> DVec3 {
    let (sin, cos) = elevation_deg.to_radians().sin_cos();
    let (y, x) = azimuth_deg.to_radians().sin_cos();
    DVec3::new(cos * x, cos * y, sin)
}

/// Seven channels over 270°, 30 m up on own ship.
pub fn bridge(size: [u32; 2]) -> Vec<DeckCamera> {
    let (sin, cos) = 25_f64.to_radians().sin_cos();
    let eye = DVec3::new(-60.0 - 55.0 * cos, -140.0 - 55.0 * sin, 30.0);
    let channel = |at: i32| DeckCamera::level(eye, 25.0 + CHANNEL_DEG * f64::from(at), 0.5, size);
    (-3..=3).map(channel).collect()
}

/// Seeded eyes on the dock, outside every part of it.
pub fn deck_eyes(mesh: &Mesh, count: usize, near: f64) -> Vec<DeckCamera> {
    let dock = [-1.0, 1.0].map(|side| DVec3::new(150.0 * side, 9.5 * side, WALKER_M));
    eyes_within(mesh, dock, count, near)
}

/// Seeded eyes in a box, outside every part of the port.
///
/// - `corners`: the lowest and the highest place, m
pub fn eyes_within(
    mesh: &Mesh,
    [low, high]: [DVec3; 2],
    count: usize,
    near: f64,
) -> Vec<DeckCamera> {
    let mut random = SplitMix64::new(EYES_SEED);
    let mut eyes = Vec::with_capacity(count);
    while eyes.len() < count {
        let mut along = |axis: fn(DVec3) -> f64| {
            let extent = axis(high) - axis(low);
            // A plane takes no number.
            let share = if extent > 0.0 { random.unit() } else { 0.0 };
            extent * share + axis(low)
        };
        let eye = DVec3::new(along(|at| at.x), along(|at| at.y), along(|at| at.z));
        let azimuth = 360.0 * random.unit();
        if !mesh.parts.iter().any(|part| {
            let [low, high] = box_of(&mesh.vertices[part.vertices.clone()]);
            // A metre of air: a near plane inside a wall sees nothing that anyone would.
            (low - 1.0).cmple(eye).all() && eye.cmple(high + 1.0).all()
        }) {
            eyes.push(DeckCamera::level(eye, azimuth, near, EYE_SIZE));
        }
    }
    eyes
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_casters::{PortSize, port};

    #[test]
    fn a_near_corner_lies_where_the_published_angle_puts_it() {
        let view = DeckCamera::level(DVec3::ZERO, 30.0, 1.0, [4, 3]);
        let corner = view.near_corners()[0].length();
        assert!((corner - 1.091).abs() < 5e-4, "{corner}");
        assert!(view.right.cross(view.forward).distance(DVec3::Z) < 1e-12);
        assert_eq!(view.ray(0, 0).dot(view.up).signum(), 1.0, "rows go down");
    }

    #[test]
    fn eyes_on_deck_are_the_same_each_time() {
        let mesh = port(PortSize::NAMED[1].1);
        let eyes = deck_eyes(&mesh, 20, 0.5);
        assert_eq!(eyes, deck_eyes(&mesh, 20, 0.5));
        assert!(
            eyes.iter()
                .all(|view| view.eye.z > 8.0 && view.eye.y.abs() < 9.6)
        );
    }
}
