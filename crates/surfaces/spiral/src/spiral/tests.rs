// SPDX-License-Identifier: MIT OR Apache-2.0
//! The spiral is closed, covers what is in view, keeps its stated heights, and is as exact as computed; and
//! each check fails where it must.

mod error;
mod limits;
mod mesh;
mod rays;
mod rounding;

use super::*;
use crate::layout::{Layout, SpiralVertex};
use std::collections::HashMap;
use terrafill_core::Geodetic;
use terrafill_elevation::Relief;
use terrafill_scene::{CameraPose, Scene};
use terrafill_surface::{EllipsoidKind, open_surface};

/// Of the globe's mean radius, as the figures that are compared with.
const RADIUS_M: f64 = 6_371_008.8;
const SIZE: ImageSize = ImageSize::new(1920, 1080);

fn sphere() -> Ellipsoid {
    Ellipsoid::new("sphere", RADIUS_M, RADIUS_M).expect("a body")
}

fn camera(body: &Ellipsoid, [longitude, latitude, height_m]: [f64; 3], pitch_deg: f64) -> Camera {
    let pose = CameraPose {
        eye: Geodetic::from_degrees(longitude, latitude, height_m),
        heading_rad: 0.7,
        pitch_rad: pitch_deg.to_radians(),
        fov_y_rad: 60_f64.to_radians(),
        near_m: 1e-9,
    };
    Camera::new(body, &pose)
}

/// Pixels that an angle of 1 spans in the middle of the picture.
fn scale() -> f64 {
    f64::from(SIZE.height) / (2.0 * 30_f64.to_radians().tan())
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

fn laws() -> [Law; 5] {
    Law::ALL.map(|(_, law)| law)
}

/// How often each edge is used, forwards less backwards, vertices at one place counting as one.
fn open_edges(layout: &Layout, law: Law) -> usize {
    let limits = Limits {
        inner: 0.001,
        outer: 1.0,
    };
    let name = |vertex: u32| {
        let place = layout.places[vertex as usize];
        flat(place, law, limits).map(|at| at.to_bits())
    };
    let mut edges: HashMap<_, i32> = HashMap::new();
    for triangle in &layout.triangles {
        for k in 0..3 {
            let (a, b) = (name(triangle[k]), name(triangle[(k + 1) % 3]));
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    edges.values().filter(|&&sum| sum != 0).count()
}

/// East and north on a map around the focus.
fn flat(place: SpiralVertex, law: Law, limits: Limits) -> [f64; 2] {
    let radius = place
        .along
        .map_or(0.0, |along| law.radius(along, limits.inner, limits.outer));
    [
        radius * place.angle_rad.sin(),
        radius * place.angle_rad.cos(),
    ]
}

fn grown() -> Elevation {
    let base = Base::Relief {
        relief: Relief { seed: 3 },
        amplitude_m: 9e3,
    };
    Elevation::new(Vec::new(), base, 0.05, 1.0)
}
