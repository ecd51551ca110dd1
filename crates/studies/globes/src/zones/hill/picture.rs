// SPDX-License-Identifier: MIT OR Apache-2.0
//! What pictures of zones show, and how they are held to rays.

use super::super::field::{CELL_M, EYE_CELLS, Field, Levels, SIDE_CELLS, number};
use crate::counts::scene::NodeVertices;
use crate::metrics::{GLOBE_ZONE_CONTROL_PX, GLOBE_ZONE_OTHER_PX};
use crate::wires::Edges;
use glam::{DVec2, DVec3};
use std::collections::{BTreeSet, HashMap};
use terrafill_core::Geodetic;
use terrafill_globe_views::{Eye, ViewRow, around};
use terrafill_study::Figures;

/// Corners lie on a grid of 1/256 px at least; twice its diagonal, and what 32 bits of a place in the picture leave.
const ROUNDING_PX: f64 = 1.0 / 64.0;
/// By what the negative control moves a picture.
const MOVED_PX: usize = 3;
/// Share of the pixels with a triangle that must then be found wrong.
const CONTROL_SHARE: f64 = 0.01;
/// Cells from the southernmost to the northernmost thing that is seen from above, with a margin.
const ABOVE_CELLS: f64 = SIDE_CELLS as f64 - EYE_CELLS[1] + 4.0;
/// Length of the two lines that mark the eye and what it sees, cells.
const MARK_CELLS: f64 = 9.0;
/// By level, the coarsest first.
const COLOURS: [[f64; 3]; 4] = [
    [90.0, 130.0, 210.0],
    [90.0, 190.0, 180.0],
    [170.0, 205.0, 100.0],
    [245.0, 225.0, 130.0],
];
const SKY: [u8; 3] = [226, 234, 242];
const OUTLINE: [u8; 3] = [210, 20, 20];

/// Over the middle of the field and of the place of the eye.
pub(super) fn above(side_px: u32) -> Eye {
    let [longitude_deg, latitude_deg] =
        Field::degrees([EYE_CELLS[0], 0.5 * (f64::from(SIDE_CELLS) + EYE_CELLS[1])]);
    let at = |height_m: f64| {
        let row = ViewRow {
            longitude_deg,
            latitude_deg,
            height_m,
            pitch_deg: -90.0,
            ..ViewRow::default()
        };
        row.eye(side_px)
    };
    let half_m = 0.5 * ABOVE_CELLS * CELL_M;
    at(half_m / at(1.0).camera.tan_half_fov())
}

/// Triangles as nodes of their own, so that pixels show their numbers.
pub(super) fn triangles(drawn: &NodeVertices) -> NodeVertices {
    NodeVertices {
        per_node: 3,
        ..drawn.clone()
    }
}

/// Each edge once, and two lines from the place of the eye whose pixels are counted to the left and right of what it sees.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a number of corners is below 2³²"
)]
pub(super) fn edges(eye: &Eye, drawn: &NodeVertices) -> Edges {
    let mut corners: Vec<[f32; 3]> = Vec::new();
    let mut known = HashMap::new();
    let numbers: Vec<u32> = drawn
        .vertices_rte
        .iter()
        .map(|vertex| {
            *known.entry(vertex.map(f32::to_bits)).or_insert_with(|| {
                corners.push(*vertex);
                corners.len() as u32 - 1
            })
        })
        .collect();
    let mut lines = BTreeSet::new();
    let mut count = 0;
    for [a, b, c] in numbers.as_chunks().0 {
        // Triangles without area fill zones up.
        if a == b || b == c || c == a {
            continue;
        }
        count += 1;
        lines.extend([[a, b], [b, c], [c, a]].map(|[from, to]| [*from.min(to), *from.max(to)]));
    }
    let mut lines: Vec<[u32; 2]> = lines.into_iter().collect();
    let mut place = |cells: [f64; 2]| {
        let [longitude, latitude] = Field::degrees(cells);
        let place = Geodetic::from_degrees(longitude, latitude, 0.0);
        let ecef = eye.body.geodetic_to_ecef(place);
        corners.push((ecef - eye.camera.eye_ecef).as_vec3().to_array());
        corners.len() as u32 - 1
    };
    let [east, north] = EYE_CELLS;
    let from = place(EYE_CELLS);
    let aside = MARK_CELLS * eye.camera.tan_half_fov();
    for to in [east - aside, east + aside] {
        lines.push([from, place([to, north + MARK_CELLS])]);
    }
    Edges {
        corners,
        lines,
        triangles: count,
    }
}

/// How a picture of triangles differs from rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct ZoneErrors {
    pub(super) shown: usize,
    pub(super) other: usize,
    /// The same of a picture that is moved.
    pub(super) control: usize,
}

impl ZoneErrors {
    pub(super) fn reason(&self) -> String {
        let Self {
            shown,
            other,
            control,
        } = *self;
        if shown == 0 {
            "it shows nothing".to_owned()
        } else if other > 0 {
            format!(
                "{other} pixels show a triangle that neither their ray meets nor rounding explains, allowed 0"
            )
        } else if (control as f64) < CONTROL_SHARE * shown as f64 {
            "a picture that is moved is found in less than 1 % of its pixels: the comparison sees nothing".to_owned()
        } else {
            String::new()
        }
    }

    pub(super) fn figures(&self) -> Figures {
        vec![
            (GLOBE_ZONE_OTHER_PX.name, self.other as f64),
            (GLOBE_ZONE_CONTROL_PX.name, self.control as f64),
        ]
    }
}

/// Compares numbers of triangles with those that rays meet.
///
/// - `is_rounding`: whether a pixel may show the second of two numbers in place of the first
pub(super) fn judge(
    width: usize,
    rays: &[u32],
    device: &[u32],
    is_rounding: impl Fn(usize, u32, u32) -> bool,
) -> ZoneErrors {
    let other = |moved: usize| {
        let is_other = |pixel: &usize| {
            let is_inside = pixel % width + moved < width;
            let shown = device.get(pixel + moved).filter(|_| is_inside);
            let met = rays[*pixel];
            shown.is_some_and(|shown| *shown != met && !is_rounding(*pixel, met, *shown))
        };
        (0..rays.len()).filter(is_other).count()
    };
    ZoneErrors {
        shown: device.iter().filter(|number| **number != 0).count(),
        other: other(0),
        control: other(MOVED_PX),
    }
}

/// Whether rounding of corners to the device's grid decides that a pixel shows triangle `shown` where its ray meets `met`.
/// Either `shown` has its border at the pixel's centre, or `met` has and `shown` covers the centre.
pub(super) fn is_rounding(
    eye: &Eye,
    drawn: &NodeVertices,
    pixel: usize,
    [met, shown]: [u32; 2],
) -> bool {
    let width = eye.size.width as usize;
    let centre = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
    // Whether a triangle covers the centre, and how far its border is from it, pixels.
    let about = |number: u32| -> Option<(bool, f64)> {
        let first = 3 * (number.checked_sub(1)? as usize);
        let corner = |i: usize| {
            let relative = DVec3::from(drawn.vertices_rte.get(first + i)?.map(f64::from));
            let ecef = eye.camera.eye_ecef + relative;
            Some(DVec2::from(eye.camera.project_px(eye.size, ecef)?))
        };
        let [a, b, c] = [corner(0)?, corner(1)?, corner(2)?];
        let sides = [[a, b], [b, c], [c, a]];
        let turns = sides.map(|[from, to]| (to - from).perp_dot(centre - from));
        let is_inside =
            turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0);
        let distances = sides.map(|[from, to]| {
            let along = to - from;
            let share = (centre - from).dot(along) / along.length_squared();
            let share = if share.is_finite() {
                share.clamp(0.0, 1.0)
            } else {
                0.0
            };
            centre.distance(from + share * along)
        });
        Some((
            is_inside,
            distances.into_iter().fold(f64::INFINITY, f64::min),
        ))
    };
    let at_border = |(_, border): (bool, f64)| border <= ROUNDING_PX;
    match (about(met), about(shown)) {
        (_, Some(shown)) if at_border(shown) => true,
        (Some(met), Some((is_inside, _))) => is_inside && at_border(met),
        (Some(met), None) => at_border(met),
        (None, _) => false,
    }
}

/// What a picture of triangles is painted by.
pub(super) struct Painted<'a> {
    pub(super) eye: &'a Eye,
    pub(super) drawn: &'a NodeVertices,
    pub(super) levels: &'a Levels,
    /// The zone whose edge is bold.
    pub(super) outlined: Option<usize>,
}

/// A colour a level, darker where the triangle leans away from the light and at its edges.
///
/// - `device`: numbers of triangles from 1; 0 for none
pub(super) fn colours(painted: &Painted<'_>, device: &[u32]) -> Vec<[u8; 3]> {
    let Painted {
        eye,
        drawn,
        levels,
        outlined,
    } = painted;
    let width = eye.size.width as usize;
    let zone = |triangle: u32| {
        let node = (triangle.checked_sub(1)? * 3 / drawn.per_node) as usize;
        drawn.nodes.get(node).map(|node| number(*node))
    };
    let up = eye.camera.eye_ecef.normalize();
    let east = DVec3::Z.cross(up).normalize();
    let sun = (up - 1.2 * east).normalize();
    (0..device.len())
        .map(|pixel| {
            let own = device[pixel];
            let mut beside = around(pixel, width, device.len()).map(|at| device[at]);
            let of = zone(own);
            if outlined.is_some() && of == *outlined && beside.any(|other| zone(other) != of) {
                return OUTLINE;
            }
            let Some(of) = of else {
                return SKY;
            };
            let first = 3 * (own - 1) as usize;
            let [a, b, c] =
                [0, 1, 2].map(|i| DVec3::from(drawn.vertices_rte[first + i].map(f64::from)));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let before = [pixel.checked_sub(width), pixel.checked_sub(1)];
            let mut before = before.into_iter().flatten();
            let is_edge = before.any(|at| device[at] != own);
            let light = (0.35 + 0.65 * normal.dot(sun).max(0.0)) * if is_edge { 0.55 } else { 1.0 };
            let colour = COLOURS[(levels[of] as usize).min(COLOURS.len() - 1)];
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of a byte"
            )]
            colour.map(|channel| (channel * light) as u8)
        })
        .collect()
}
