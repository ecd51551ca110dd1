// SPDX-License-Identifier: MIT OR Apache-2.0
//! Formats of vertex positions: what is left of a vertex relative to the eye. By emulation: on the
//! device they are drawn by the backends' own variants.

use crate::error::{AGREEMENT, LengthErrors};
use crate::place::{Place, radical_inverse};
use crate::row::{PrecisionPart, PrecisionRow};
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

/// Rows and field of view of the pixels that errors are counted in.
const VIEW_ROWS: f64 = 1080.0;
const FIELD_OF_VIEW_DEG: f64 = 60.0;

/// Distance × extent.
fn conditions() -> impl Iterator<Item = (f64, f64)> {
    let distances = DISTANCES_M.into_iter();
    distances.flat_map(|distance| EXTENTS_DEG.map(|extent| (distance, extent)))
}

fn name((distance_m, extent_deg): (f64, f64)) -> String {
    format!("distance={distance_m};extent={extent_deg}")
}

pub(crate) fn condition_names() -> Vec<String> {
    conditions().map(name).collect()
}

/// A format's row before anything is measured.
pub(crate) fn identity(format: VertexFormat, condition: &str) -> PrecisionRow {
    let found = conditions().find(|at| name(*at) == condition);
    PrecisionRow {
        part: PrecisionPart::Vertex,
        route: format.name().to_owned(),
        family: format.name().to_owned(),
        condition: condition.to_owned(),
        extent_deg: found.map(|(_, extent_deg)| extent_deg),
        latitude_deg: found.map(|_| LATITUDE_DEG),
        distance_m: found.map(|(distance_m, _)| distance_m),
        ..PrecisionRow::default()
    }
}

/// Rows of every format under the condition called so.
pub(crate) fn rows(condition: &str) -> Vec<PrecisionRow> {
    let found = conditions().find(|at| name(*at) == condition);
    let place = found.and_then(|(_, extent)| Place::new(extent, LATITUDE_DEG, ("0", 0.0, 0.0)));
    let (Some((distance_m, _)), Some(place)) = (found, place) else {
        return Vec::new();
    };
    let row = |format: &VertexFormat| row(*format, condition, distance_m, &place);
    VertexFormat::ALL.iter().map(row).collect()
}

fn row(format: VertexFormat, condition: &str, distance_m: f64, place: &Place) -> PrecisionRow {
    let body = place.region.body();
    let extent = place.region.extent();
    let [width, height] = extent.size_rad();
    let origin = place.region.anchor_ecef();
    let extent_m = 0.75 * width.max(height) * body.equatorial_radius_m();
    let mut errors = LengthErrors::default();
    for i in 1..=VERTICES {
        let at = |base| radical_inverse(i, base);
        let place_of = |height_m| {
            body.geodetic_to_ecef(Geodetic {
                longitude_rad: extent.west_rad + at(2) * width,
                latitude_rad: extent.south_rad + at(3) * height,
                height_m,
            })
        };
        // The eye stands above the vertex; both move, so that every rounding is met.
        let (vertex, eye) = (place_of(0.0), place_of(distance_m * (1.0 - 0.01 * at(5))));
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
        points: VERTICES,
        non_finite_emulated: Some(errors.non_finite),
        emulated_max_m: figures.map(|[max, _]| max),
        emulated_rms_m: figures.map(|[_, rms]| rms),
        pixel_m: Some(pixel_m),
        max_px: figures.map(|[max, _]| max / pixel_m),
        rms_px: figures.map(|[_, rms]| rms / pixel_m),
        residual_max_m: Some(bound),
        residual_rms_m: Some(expected_rms),
        max_over_residual: ratio,
        rms_over_residual: rms_ratio,
        measured_over_expected: rms_ratio,
        status: Status::Ok,
        reason: "by emulation alone: no device evaluates a vertex format by itself".to_owned(),
        ..identity(format, condition)
    };
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
