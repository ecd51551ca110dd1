// SPDX-License-Identifier: MIT OR Apache-2.0
//! A file of regions as a scene: WGS 84, the bare ellipsoid, one view from straight above that shows
//! all of them.

use crate::arguments::OwnArguments;
use crate::outcome::Failure;
use crate::regions::{Leniency, Meshed, read_and_mesh, report_regions, report_warnings};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;
use terrafill_core::{
    EdgeRule, Ellipsoid, Geodetic, MeshOptions, Region, RegionMesh, WarningSubject,
};
use terrafill_scene::{
    Camera, CameraPose, ImageSize, LevelChoice, Overlap, Scene, SurfaceChoice, TexturedFills, View,
};

/// Name of the fitted view.
const VIEW: &str = "fit";

/// Vertical field of view: that of scenes that name none.
pub(crate) const FOV_RAD: f64 = 60.0 * PI / 180.0;

/// Distance of the near plane, share of the eye's height, as in scenes that name none.
const NEAR_SHARE: f64 = 1e-3;

/// Share of the picture, from its middle to its edge, within which all regions lie.
const FILLED_SHARE: f64 = 0.9;

/// Lowest eye, metres: a region of a few metres still has ground around it.
const MIN_HEIGHT_M: f64 = 10.0;

/// Share of the eye's height by which facets may lie below the body: what is drawn on them looks
/// smaller by as much.
const MAX_SAG_SHARE: f64 = 0.01;

/// Rows of scenes that name none.
const MIN_ROWS: f64 = 180.0;

/// Four million triangles, and facets 16 m below the body: more take seconds on a software device.
const MAX_ROWS: f64 = 1024.0;

/// Area that another direction shows, as a share of the middle's, from which on it is worth it.
const NOTABLY_MORE: f64 = 1.1;

/// Halvings of the range of heights: beyond these the picture moves by less than a pixel.
const BISECTIONS: u32 = 40;

/// A file's regions on WGS 84, crossings filled by the even-odd rule, and the eye that sees them all.
pub(crate) struct Fitted {
    pub(crate) regions: Vec<Region>,
    pub(crate) meshes: Vec<RegionMesh>,
    pub(crate) pose: CameraPose,
}

/// Reads a file's regions and finds that eye; says what is remarkable and what was repaired.
///
/// # Errors
/// As `mesh`, by whose rules the file is read, and where nothing is there to be fitted.
pub(crate) fn fit(path: &Path, own: &OwnArguments, size: ImageSize) -> Result<Fitted, Failure> {
    let body = Ellipsoid::WGS84;
    let (edge_rule, mesh): (EdgeRule, _) = (own.edges.into(), MeshOptions::default());
    let leniency = Leniency {
        repair: Some(own.repair.into()),
        skip_invalid: false,
    };
    let Meshed {
        mut regions,
        meshes,
        warnings,
        ..
    } = read_and_mesh(path, own.reading(), leniency, &body, edge_rule, &mesh)?;
    report_warnings(path, &warnings);
    report_regions(&meshes, &WarningSubject::ALL);
    let Some(pose) = fitted(&body, &meshes, size) else {
        let shown = crate::input::shown(path);
        return Err(Failure::bad_input(format!(
            "{shown}: found no regions, allowed: at least one"
        )));
    };
    for region in &mut regions {
        region.repair(own.repair.into(), edge_rule);
    }
    Ok(Fitted {
        regions,
        meshes,
        pose,
    })
}

/// The scene of a file's regions; whatever lies on the far side of the body is not shown.
///
/// # Errors
/// As [`fit`].
pub(crate) fn scene_of(path: &Path, own: &OwnArguments, size: ImageSize) -> Result<Scene, Failure> {
    let body = Ellipsoid::WGS84;
    let Fitted { regions, pose, .. } = fit(path, own, size)?;
    let rows = surface_rows(&body, pose.eye.height_m);
    Ok(Scene {
        name: path.display().to_string(),
        description: "regions of a file".to_owned(),
        body,
        edge_rule: own.edges.into(),
        regions: regions.into(),
        // Whether a file's regions overlap is not known; this draws both right.
        overlap: Overlap::Ordered,
        mesh: MeshOptions::default(),
        levels: LevelChoice::default(),
        surface: SurfaceChoice {
            file: path.display().to_string(),
            kind: "ellipsoid".to_owned(),
            files: Vec::new(),
            picture: None,
            parameters: toml::Table::from_iter([("rows".to_owned(), rows.into())]),
        },
        views: vec![View {
            name: VIEW.to_owned(),
            pose,
            note: None,
        }],
        sweep_boundary_tolerance_m: Vec::new(),
        texture: None,
        textured: TexturedFills::default(),
        sweep_cap_step_deg: Vec::new(),
        sweep_positions: false,
        files_read: Vec::new(),
    })
}

/// The lowest eye above the middle of all regions that sees each of their vertices within the
/// picture; one that sees the whole disc of the body where none does.
fn fitted(body: &Ellipsoid, meshes: &[RegionMesh], size: ImageSize) -> Option<CameraPose> {
    let vertices = || {
        meshes
            .iter()
            .flat_map(|mesh| mesh.vertices_ecef.iter().copied())
    };
    let mut bounds: Option<[DVec3; 2]> = None;
    for vertex in vertices() {
        let [low, high] = bounds.unwrap_or([vertex; 2]);
        bounds = Some([low.min(vertex), high.max(vertex)]);
    }
    let [low, high] = bounds?;
    // Regions all round the body have no middle: then any place is as good.
    let direction = (low + high).try_normalize().unwrap_or(DVec3::X);
    let radius_m = body.equatorial_radius_m();
    let ground = body.ecef_to_geodetic(radius_m * direction);
    let pose = |height_m: f64| CameraPose {
        eye: Geodetic { height_m, ..ground },
        heading_rad: 0.0,
        pitch_rad: -FRAC_PI_2,
        fov_y_rad: FOV_RAD,
        near_m: NEAR_SHARE * height_m,
    };
    let fits = |height_m: f64| {
        let camera = Camera::new(body, &pose(height_m));
        vertices().all(|vertex| is_in_picture(&camera, size, vertex))
    };
    let (mut below, mut above) = (MIN_HEIGHT_M.ln(), max_height_m(radius_m, size).ln());
    if fits(below.exp()) {
        return Some(pose(below.exp()));
    }
    if !fits(above.exp()) {
        let height_m = above.exp();
        let cos_horizon = radius_m / (radius_m + height_m);
        let direction = best_direction(meshes, direction, cos_horizon);
        let ground = body.ecef_to_geodetic(radius_m * direction);
        return Some(CameraPose {
            eye: Geodetic { height_m, ..ground },
            ..pose(height_m)
        });
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (below + above);
        if fits(middle.exp()) {
            above = middle;
        } else {
            below = middle;
        }
    }
    Some(pose(above.exp()))
}

/// Of several directions the one from which the regions cover most of the picture; `middle` if none shows a tenth
/// more. From above its pole, a band lies along the limb and covers next to no pixel.
///
/// - `cos_horizon`: of the angle from straight below the eye to the horizon
fn best_direction(meshes: &[RegionMesh], middle: DVec3, cos_horizon: f64) -> DVec3 {
    let facets = meshes.iter().flat_map(|mesh| {
        let corners = mesh.triangles.iter();
        corners.map(|corners| corners.map(|i| mesh.vertices_ecef[i as usize]))
    });
    let facets = facets.map(|[a, b, c]| ((a + b + c).normalize(), (b - a).cross(c - a).length()));
    let facets: Vec<(DVec3, f64)> = facets.collect();
    let in_sight = |direction: DVec3| -> f64 {
        // Of a sphere of radius 1, above which the eye stands: solid angles, none of what lies beyond the horizon.
        let eye = direction / cos_horizon;
        let solid_angle = |(facet, area): &(DVec3, f64)| {
            let to_eye = eye - *facet;
            area * facet.dot(to_eye).max(0.0) / to_eye.length().powi(3)
        };
        facets.iter().map(solid_angle).sum()
    };
    let largest = facets.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let others = axes
        .into_iter()
        .flat_map(|axis| [axis, -axis])
        .chain(largest.map(|(facet, _)| *facet));
    let mut best = (middle, NOTABLY_MORE * in_sight(middle));
    for direction in others {
        let area = in_sight(direction);
        if area > best.1 {
            best = (direction, area);
        }
    }
    best.0
}

/// Height from which the disc of the body takes the share of the picture that is to be filled: from
/// farther off nothing more is seen.
fn max_height_m(radius_m: f64, size: ImageSize) -> f64 {
    let tan_disc = FILLED_SHARE * (0.5 * FOV_RAD).tan() * size.aspect().min(1.0);
    radius_m / tan_disc.atan().sin() - radius_m
}

/// Rows of the drawn ellipsoid: as few as keep its facets from hanging too far below the eye.
pub(crate) fn surface_rows(body: &Ellipsoid, eye_height_m: f64) -> i64 {
    let sag_m = MAX_SAG_SHARE * eye_height_m;
    // A cell of 2 φ sags by R φ² / 2 along a row, and as much again along its diagonal.
    let half_cell_rad = (sag_m / body.equatorial_radius_m()).sqrt();
    let enough = (0.5 * PI / half_cell_rad).ceil();
    // The bounds are far within i64, and NaN is no height that a fit gives.
    #[allow(clippy::cast_possible_truncation, reason = "clamped to a few thousand")]
    let rows = enough.clamp(MIN_ROWS, MAX_ROWS) as i64;
    rows
}

/// Whether a place lies on the near side and well within the picture.
fn is_in_picture(camera: &Camera, size: ImageSize, vertex: DVec3) -> bool {
    let Some([x, y]) = camera.project_px(size, vertex) else {
        return false;
    };
    let half = [size.width, size.height].map(|pixels| 0.5 * f64::from(pixels));
    let is_near = (camera.eye_ecef - vertex).dot(vertex) > 0.0;
    let within = |at: f64, half: f64| (at - half).abs() <= FILLED_SHARE * half;
    is_near && within(x, half[0]) && within(y, half[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_hang_no_farther_below_a_low_eye_than_allowed() {
        let body = Ellipsoid::WGS84;
        for height_m in [2e3, 1e4, 1e5] {
            let rows = surface_rows(&body, height_m);
            let half_cell_rad = 0.5 * PI / rows as f64;
            let sag_m = body.equatorial_radius_m() * half_cell_rad.powi(2);
            assert!(sag_m <= MAX_SAG_SHARE * height_m, "{height_m} m: {rows}");
        }
        // Negative controls: neither more rows than needed from far nor more than can be drawn from near.
        assert_eq!(surface_rows(&body, 1e7), 180);
        assert_eq!(surface_rows(&body, 10.0), 1024);
    }

    #[test]
    fn a_band_round_the_body_is_seen_from_its_side_and_a_cap_from_above() {
        let fitted_latitude_deg = |rings: &[String]| {
            let polygons: Vec<String> = rings.iter().map(|ring| format!("[{ring}]")).collect();
            let polygons = polygons.join(",");
            let text = format!(r#"{{"type": "MultiPolygon", "coordinates": [{polygons}]}}"#);
            let regions = terrafill_core::parse_regions(text.as_bytes(), "test").expect("a region");
            let body = Ellipsoid::WGS84;
            let meshes =
                RegionMesh::build_all(&regions, &body, EdgeRule::Planar, &MeshOptions::default());
            let meshes = meshes.expect("meshes");
            let pose = fitted(&body, &meshes, ImageSize::new(256, 256)).expect("a pose");
            pose.eye.latitude_rad.to_degrees()
        };
        let band = |[south, north]: [f64; 2]| {
            format!(
                "[[-180, {south}], [180, {south}], [180, {north}], [-180, {north}], [-180, {south}]]"
            )
        };
        let island = "[[171, -20], [188, -20], [188, -6], [171, -6], [171, -20]]".to_owned();
        for rings in [
            vec![band([14.0, 15.0])],
            vec![band([-5.0, 5.0])],
            vec![band([30.0, 38.0]), island],
        ] {
            let found = fitted_latitude_deg(&rings);
            assert!(found.abs() < 50.0, "{rings:?}: {found}");
        }
        // Negative controls: a cap, and a band that all is in sight from above its pole.
        for latitudes in [[40.0, 90.0], [30.0, 38.0]] {
            assert!(fitted_latitude_deg(&[band(latitudes)]) > 80.0);
        }
    }
}
