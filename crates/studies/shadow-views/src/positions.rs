// SPDX-License-Identifier: MIT OR Apache-2.0
//! Vertices as an eye has them, in `f32`.

use crate::view::DeckCamera;
use glam::{DVec3, Vec3};
use terrafill_casters::Volume;

/// What the numbers of vertices count from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Positions {
    /// The eye: subtracted in `f64`, then rounded.
    Eye,
    /// An origin so many metres from the port: rounded to `f32`, then the eye subtracted, as rounded.
    World(f64),
}

impl Positions {
    /// As rows have it.
    pub fn name(self) -> String {
        match self {
            Self::Eye => "from the eye".to_owned(),
            Self::World(m) => format!("f32, origin {} km away", m / 1e3),
        }
    }

    /// A place from the eye, m, as these numbers have it.
    pub fn relative(self, place: DVec3, eye: DVec3) -> Vec3 {
        match self {
            Self::Eye => (place - eye).as_vec3(),
            Self::World(m) => {
                // Along no axis, as places on a planet lie.
                let port = DVec3::ONE.normalize() * m;
                (port + place).as_vec3() - (port + eye).as_vec3()
            }
        }
    }
}

/// Vertices of volumes as this eye has them: bits of `f32`.
pub fn eye_vertices(positions: Positions, view: &DeckCamera, volume: &Volume) -> Vec<[u32; 4]> {
    let places = volume.vertices.iter().map(|place| {
        let is_place = place.w > 0.0;
        let along = if is_place {
            positions.relative(place.truncate(), view.eye)
        } else {
            place.truncate().as_vec3()
        };
        let w = f32::from(u8::from(is_place));
        along.extend(w).to_array().map(f32::to_bits)
    });
    places.collect()
}

/// A length as devices count.
pub fn count(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}
