// SPDX-License-Identifier: MIT OR Apache-2.0
//! Formats of vertex positions: what is left of a vertex relative to the eye. By emulation: on the
//! device they are drawn by the backends' own variants.

use crate::error::{AGREEMENT, ErrorSum};
use crate::metrics::*;
use crate::place::{RegionPicture, VIEW_ROWS, halton};
use crate::row::{PrecisionPart, PrecisionRow};
use crate::sight::FIELD_OF_VIEW_DEG;
use terrafill_core::Geodetic;
use terrafill_results::Status;
use terrafill_texture::VertexFormat;

/// From the eye to the vertex, metres.
const DISTANCES_M: [f64; 5] = [10.0, 20.0, 1e3, 1e6, 3e7];

/// Extents of the region, degrees: its vertices' distances from its origin.
const EXTENTS_DEG: [f64; 3] = [1e-3, 1.0, 10.0];

/// Latitude of the region, degrees.
const LATITUDE_DEG: f64 = 45.0;

/// Vertices of a condition.
const VERTICES: u32 = 2000;

/// From where vertices of which region are seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    distance_m: f64,
    extent_deg: f64,
}

pub(crate) fn conditions() -> impl Iterator<Item = Seen> {
    let of = |distance_m| {
        EXTENTS_DEG.map(|extent_deg| Seen {
            distance_m,
            extent_deg,
        })
    };
    DISTANCES_M.into_iter().flat_map(of)
}

/// A format's row before anything is measured.
pub(crate) fn identity(format: VertexFormat, seen: Seen) -> PrecisionRow {
    let (distance_m, extent_deg) = (seen.distance_m, seen.extent_deg);
    let condition = format!("distance={distance_m};extent={extent_deg}");
    PrecisionRow {
        extent_deg: Some(extent_deg),
        latitude_deg: Some(LATITUDE_DEG),
        distance_m: Some(distance_m),
        ..PrecisionRow::new(PrecisionPart::Vertex, format.name(), condition)
    }
}

/// Rows of every format.
pub(crate) fn rows(seen: Seen) -> Vec<PrecisionRow> {
    let place = RegionPicture::new(seen.extent_deg, LATITUDE_DEG, ("0", 0.0, 0.0));
    place.map_or_else(Vec::new, |place| {
        VertexFormat::ALL
            .map(|format| row(format, seen, &place))
            .into()
    })
}

fn row(format: VertexFormat, seen: Seen, place: &RegionPicture) -> PrecisionRow {
    let distance_m = seen.distance_m;
    let body = place.region.body();
    let extent = place.region.extent();
    let [width, height] = extent.size_rad();
    let origin = place.region.anchor_ecef();
    let extent_m = 0.75 * width.max(height) * body.equatorial_radius_m();
    let mut errors = ErrorSum::default();
    for i in 1..=VERTICES {
        let at = halton(i);
        let place_of = |height_m| {
            body.geodetic_to_ecef(Geodetic {
                longitude_rad: extent.west_rad + at.x * width,
                latitude_rad: extent.south_rad + at.y * height,
                height_m,
            })
        };
        // The eye stands above the vertex; both move, so that every rounding is met.
        let (vertex, eye) = (place_of(0.0), place_of(distance_m * (1.0 - 0.01 * at.z)));
        let found = format.emulate(vertex, eye, origin, extent_m);
        let exact = (vertex - eye).to_array();
        for axis in 0..3 {
            errors.add((f64::from(found[axis]) - exact[axis]).abs());
        }
    }
    let figures = errors.figures();
    let radius_m = body.equatorial_radius_m() + distance_m;
    let bound = format.residual_m(radius_m, extent_m, distance_m);
    let expected_rms = format.residual_rms_m(radius_m, extent_m, distance_m);
    let pixel_m = 2.0 * distance_m * (0.5 * FIELD_OF_VIEW_DEG.to_radians()).tan() / VIEW_ROWS;
    let ratio = figures.map(|[max, _]| max / bound);
    let rms_ratio = figures.map(|[_, rms]| rms / expected_rms);
    let mut row = PrecisionRow {
        status: Status::Ok,
        reason: "by emulation alone: no device evaluates a vertex format by itself".to_owned(),
        ..identity(format, seen)
    };
    row.put(POINTS, f64::from(VERTICES));
    let emulated = [EMULATED_MAX_M, EMULATED_RMS_M];
    errors.put(&mut row, NON_FINITE_EMULATED, emulated);
    row.put_pixels(pixel_m, emulated);
    row.put(RESIDUAL_MAX_M, bound);
    row.put(RESIDUAL_RMS_M, expected_rms);
    row.put(MAX_OVER_RESIDUAL, ratio);
    row.put(RMS_OVER_RESIDUAL, rms_ratio);
    row.put(MEASURED_OVER_EXPECTED, rms_ratio);
    if row.non_finite() > 0 || ratio.is_some_and(|ratio| ratio > 1.0) {
        (row.status, row.reason) = (Status::Wrong, "above its bound".to_owned());
    }
    if rms_ratio.is_some_and(|ratio| ratio < 1.0 / AGREEMENT) {
        row.residual_reason =
            "the formula takes every number for as large as the largest there may be".to_owned();
    } else if rms_ratio.is_some_and(|ratio| ratio > AGREEMENT) {
        row.residual_reason = "no reason known".to_owned();
    }
    row
}
