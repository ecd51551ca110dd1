// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whole pictures against areas known by arithmetic, and the surface's index against brute force.
//!
//! The eye stands on the axis of the body, so outlines are circles: the tangent cone of an
//! ellipsoid of revolution touches it where `z = b² / Z`, and a parallel is a circle anyway. A disc
//! of radius r pixels with its centre at the corner between pixels holds π r² pixel centres but for
//! a few times r^(2/3).

use super::{TestRing, locator, parallel};
use crate::backend::{ReferenceFrame, judge};
use crate::surface::SurfaceTriangles;
use crate::{CloseLook, Locator, ReferenceBackend};
use glam::DVec3;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;
use terrafill_contract::{DeviceError, FillInput, NO_REGION, PreparedScene, ViewId};
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic, Region};
use terrafill_fixtures::region;
use terrafill_plan::{FramePlan, RegionSet, SceneBounds};
use terrafill_scene::{Camera, CameraPose, ImageSize, Overlap};
use terrafill_surface::{EllipsoidKind, SurfaceFrame};

const ROWS: u32 = 360;

fn pose(lon: f64, lat: f64, height_m: f64, pitch_deg: f64) -> CameraPose {
    CameraPose {
        eye: Geodetic::from_degrees(lon, lat, height_m),
        heading_rad: 0.3,
        pitch_rad: pitch_deg.to_radians(),
        fov_y_rad: 40_f64.to_radians(),
        near_m: height_m * 1e-3,
    }
}

/// A view of a bare globe.
pub(super) fn input(body: Ellipsoid, pose: &CameraPose, size: u32, rows: u32) -> FillInput {
    let surface = EllipsoidKind::surface(&body, rows);
    let camera = Camera::new(&body, pose);
    let size = ImageSize::new(size, size);
    FillInput {
        view_id: ViewId::unique(),
        surface: surface.frame(&camera, size).expect("above"),
        scene: PreparedScene {
            name: "validation".to_owned(),
            body,
            edge_rule: EdgeRule::Planar,
            overlap: Overlap::Ordered,
            regions: Arc::from([]),
            meshes: RegionSet::default(),
            levels: Arc::default(),
            footprints: Arc::default(),
            bounds: SceneBounds::default(),
            parts: terrafill_plan::LazyParts::default(),
            surface,
            picture: None,
            texture: None,
        },
        view: "from the axis".to_owned(),
        camera,
        size,
        plan: FramePlan::default(),
    }
}

fn nothing() -> Locator {
    locator(&[], EdgeRule::Planar)
}

fn hits(judged: &ReferenceFrame) -> f64 {
    judged.frame.surface.iter().filter(|&&hit| hit).count() as f64
}

#[test]
fn coarse_triangles_move_a_boundary_by_the_square_of_their_size() {
    let ring = region("[[[-20,30],[25,32],[22,60],[-15,55],[-20,30]]]");
    let regions: Arc<[Region]> = [ring].into();
    let moved = |rows: u32| {
        let pose = pose(3.0, 44.0, 4e6, -90.0);
        let mut input = input(Ellipsoid::WGS84, &pose, 400, rows);
        input.scene.regions = Arc::clone(&regions);
        let judged = ReferenceBackend::new().judge(&input).expect("closed");
        let moved = judged
            .moved_px_true
            .expect("the ellipsoid knows its heights");
        assert!(moved.len() > 300, "{}", moved.len());
        moved.into_iter().fold(0.0, f64::max)
    };
    let (coarse, middle, fine) = (moved(18), moved(36), moved(72));
    // Cells of 10° hang R q² / 8 = 24 km low. At 20° from the vertical that is 9 km aside, and a pixel is 7 km.
    assert!((1.0..12.0).contains(&coarse), "{coarse}");
    for ratio in [coarse / middle, middle / fine] {
        assert!((2.5..6.0).contains(&ratio), "{coarse} {middle} {fine}");
    }
    // Negative controls: nothing is moved of the body itself, since nothing was drawn, nor where no boundary is seen.
    let mut bare = input(Ellipsoid::WGS84, &pose(3.0, 44.0, 4e6, -90.0), 40, 18);
    let judged = ReferenceBackend::new().judge(&bare).expect("nothing");
    assert_eq!(judged.moved_px_true, Some(Vec::new()));
    bare.scene.regions = regions;
    let on_body = ReferenceBackend::on_body().judge(&bare).expect("closed");
    assert_eq!(on_body.moved_px_true, None);
}

/// Area in pixels of a disc that is seen under `radius` (tangent of half its angle).
fn disc_px(input: &FillInput, radius: f64) -> f64 {
    let pixels = radius / input.camera.tan_half_fov() * f64::from(input.size.height) / 2.0;
    PI * pixels * pixels
}

/// Tangent of half the angle under which the body is seen from its axis.
fn outline(body: &Ellipsoid, input: &FillInput) -> f64 {
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    let eye = input.camera.eye_ecef.z.abs();
    let touch_z = b * b / eye;
    let touch_rho = a * (1.0 - touch_z * touch_z / (b * b)).sqrt();
    touch_rho / (eye - touch_z)
}

/// Tangent of half the angle under which a parallel is seen from the axis.
fn parallel_seen(body: &Ellipsoid, input: &FillInput, latitude_deg: f64) -> f64 {
    let rim = body.geodetic_to_ecef(Geodetic::from_degrees(0.0, latitude_deg, 0.0));
    rim.x / (input.camera.eye_ecef.z - rim.z)
}

/// Largest relative error of a disc's pixel count. Facets of half a degree sag by 1e-5 of the radius, and the
/// count of pixel centres in a disc of 350 pixels radius is off by 1e-4 at most.
const DISC_TOLERANCE: f64 = 2e-4;

#[test]
fn the_globe_is_as_large_as_its_tangent_cone() {
    for body in [
        Ellipsoid::WGS84,
        Ellipsoid::SATURN_LIKE,
        Ellipsoid::UNIT_SPHERE,
    ] {
        let height = 2.5 * body.equatorial_radius_m();
        let input = input(body, &pose(0.0, 90.0, height, -90.0), 1024, ROWS);
        let expected = disc_px(&input, outline(&body, &input));
        let found = hits(&judge(&input, nothing(), None));
        assert!(
            (found / expected - 1.0).abs() < DISC_TOLERANCE,
            "{found} {expected}"
        );
        // Negative control: the outline of another body must not pass.
        let wrong = Ellipsoid::new(
            "mutant",
            body.equatorial_radius_m() * 1.0005,
            body.polar_radius_m() * 1.0005,
        );
        let wrong = disc_px(&input, wrong.map_or(0.0, |wrong| outline(&wrong, &input)));
        assert!(
            (found / wrong - 1.0).abs() > DISC_TOLERANCE,
            "{found} {wrong}"
        );
    }
}

/// Relative error of the pixel count of the cap north of 60°, seen from above the pole.
fn cap_error(input: &FillInput, rings: &[TestRing], is_filled: &dyn Fn(u32) -> bool) -> f64 {
    let expected = disc_px(input, parallel_seen(&Ellipsoid::WGS84, input, 60.0));
    let judged = judge(input, locator(rings, EdgeRule::Planar), None);
    assert_eq!(judged.disagreement_px(), 0);
    let filled = judged.frame.ids.iter().zip(&judged.frame.surface);
    let found = filled.filter(|(id, hit)| **hit && is_filled(**id)).count() as f64;
    (found / expected - 1.0).abs()
}

#[test]
fn a_filled_cap_is_as_large_as_its_parallel_and_mutants_are_not() {
    let real = input(Ellipsoid::WGS84, &pose(0.0, 90.0, 8e6, -90.0), 1024, ROWS);
    let cap = vec![(0, parallel(60.0), 360.0)];
    let is_filled = |id: u32| id == 1;
    let error = cap_error(&real, &cap, &is_filled);
    assert!(error < DISC_TOLERANCE, "{error}");

    // Longitude and latitude swapped in the ring.
    let swapped = vec![(
        0,
        parallel(60.0)
            .iter()
            .map(|v| [v[1], v[0].clamp(-90.0, 90.0)])
            .collect(),
        0.0,
    )];
    assert!(cap_error(&real, &swapped, &is_filled) > DISC_TOLERANCE);

    // e² dropped where hits are turned into latitudes; the surface stays as it was.
    let mut sphere = real.clone();
    sphere.scene.body = Ellipsoid::new("mutant", 6_378_137.0, 6_378_137.0).expect("a sphere");
    assert!(cap_error(&sphere, &cap, &is_filled) > DISC_TOLERANCE);

    // Winding flipped: the other side of the ring.
    assert!(cap_error(&real, &cap, &|id| id == 0) > DISC_TOLERANCE);
}

#[test]
fn the_last_of_overlapping_regions_wins_and_ids_start_at_one() {
    let input = input(Ellipsoid::WGS84, &pose(0.0, 90.0, 8e6, -90.0), 64, 60);
    let rings: Vec<TestRing> = vec![
        (0, parallel(50.0), 360.0),
        (1, parallel(70.0), 360.0),
        (2, parallel(-50.0), 360.0),
    ];
    let judged = judge(&input, locator(&rings, EdgeRule::Planar), None);
    let at = |column: usize, row: usize| judged.frame.ids[row * 64 + column];
    assert_eq!(at(32, 32), 2);
    let seen: std::collections::BTreeSet<u32> = judged.frame.ids.iter().copied().collect();
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 1, 2]);
    // In the other order the small one is covered.
    let judged = judge(
        &input,
        locator(
            &[(0, parallel(70.0), 360.0), (1, parallel(50.0), 360.0)],
            EdgeRule::Planar,
        ),
        None,
    );
    assert!(!judged.frame.ids.contains(&1));
}

#[test]
fn the_tree_of_boxes_gives_what_brute_force_gives() {
    let poses = [
        pose(12.0, 34.0, 1e7, -90.0),
        pose(-170.0, 80.0, 3e5, -10.0),
        pose(0.0, -90.0, 2e4, -3.0),
        pose(45.0, 0.0, 100.0, -30.0),
    ];
    for pose in poses {
        let input = input(Ellipsoid::WGS84, &pose, 48, 40);
        let surface = SurfaceTriangles::new(&input.surface);
        let mut found = 0;
        for row in 0..48 {
            for column in 0..48 {
                let direction = input.camera.pixel_direction_ecef(input.size, column, row);
                for near in [input.camera.near_m, 1.2e7] {
                    let hit = surface.hit(direction, near);
                    assert_eq!(hit, surface.hit_brute(direction, near));
                    found += usize::from(hit.is_some());
                }
            }
        }
        assert!(found > 100, "{found}");
    }
}

#[test]
fn triangles_beside_the_picture_are_left_out_and_none_in_it_is() {
    let mut lost = 0;
    for (pose, left) in [
        (pose(12.0, 34.0, 1e7, -90.0), 1.0),
        (pose(-170.0, 80.0, 3e5, -10.0), 0.5),
        (pose(45.0, 0.0, 100.0, -30.0), 0.2),
    ] {
        let input = input(Ellipsoid::WGS84, &pose, 48, 40);
        let all = SurfaceTriangles::new(&input.surface);
        let seen = SurfaceTriangles::in_picture(&input.surface, &input.camera, input.size);
        let [kept, of] = [&seen, &all].map(|triangles| triangles.len() as f64);
        assert!(kept < left * of, "{kept} of {of}");
        // A pixel beyond the picture on every side, and what a narrower picture loses as a control.
        let narrow = ImageSize::new(24, input.size.height);
        let narrow = SurfaceTriangles::in_picture(&input.surface, &input.camera, narrow);
        let mut found = 0;
        for row in -1..=48 {
            for column in -1..=48 {
                let place = [column, row].map(|at| f64::from(at) + 0.5);
                let ray = input.camera.direction_ecef(input.size, place);
                let hit = all.hit(ray, input.camera.near_m);
                assert_eq!(seen.hit(ray, input.camera.near_m), hit, "{place:?}");
                found += usize::from(hit.is_some());
                lost += usize::from(narrow.hit(ray, input.camera.near_m) != hit);
            }
        }
        assert!(found > 100, "{found}");
    }
    assert!(lost > 100, "{lost}");
}

/// Rays through corners, and through points of edges as near as doubles get, that meet nothing.
fn leaks(input: &FillInput) -> usize {
    let surface = SurfaceTriangles::new(&input.surface);
    let corner = |i: u32| DVec3::from(input.surface.vertices_rte[i as usize].map(f64::from));
    let mut leaks = 0;
    for triangle in input.surface.triangles.iter() {
        let [a, b, c] = triangle.map(corner);
        // Only what faces the eye well away from the rim.
        let normal = (b - a).cross(c - a);
        if normal.dot(a) > -0.2 * normal.length() * a.length() {
            continue;
        }
        for target in [
            a,
            b,
            c,
            a.lerp(b, 0.5),
            b.lerp(c, 0.3),
            c.lerp(a, 1.0 / 3.0),
        ] {
            let direction = target / target.dot(-input.camera.view_from_ecef.row(2));
            leaks += usize::from(
                surface
                    .hit(direction, 0.0)
                    .is_none_or(|t| (t * direction - target).length() > 1e-5 * target.length()),
            );
        }
    }
    leaks
}

#[test]
fn no_ray_falls_through_between_triangles() {
    for pose in [pose(7.0, 40.0, 1e7, -90.0), pose(7.0, 40.0, 1e5, -90.0)] {
        let input = input(Ellipsoid::WGS84, &pose, 8, 90);
        let triangles = &input.surface.triangles;
        assert_eq!(leaks(&input), 0);
        // Negative control: without one triangle in sight, rays through its edges' neighbours still hit, but
        // those inside it do not.
        let corner = |i: u32| DVec3::from(input.surface.vertices_rte[i as usize].map(f64::from));
        let nearest = (0..triangles.len()).min_by(|&i, &j| {
            let middle = |k: usize| {
                let sum: DVec3 = triangles[k].map(corner).into_iter().sum();
                sum.length()
            };
            middle(i).total_cmp(&middle(j))
        });
        let mut holed = triangles.to_vec();
        let lost = holed.remove(nearest.expect("triangles"));
        let surface = SurfaceTriangles::new(&SurfaceFrame {
            triangles: holed.into(),
            ..input.surface.clone()
        });
        let inside = lost.map(corner).iter().copied().sum::<DVec3>() / 3.0;
        let hit = surface.hit(inside, 0.0);
        assert!(hit.is_none_or(|t| t > 1.001), "{hit:?}");
    }
}

#[test]
fn hits_before_the_near_plane_do_not_count() {
    let mut input = input(Ellipsoid::WGS84, &pose(0.0, 0.0, 1e6, -90.0), 16, 60);
    assert!(
        judge(&input, nothing(), None)
            .frame
            .surface
            .iter()
            .all(|&hit| hit)
    );
    // Past the near side of the globe its far side is seen, 2 a farther on.
    input.camera.near_m = 2e6;
    let surface = SurfaceTriangles::new(&input.surface);
    let ahead = input.camera.pixel_direction_ecef(input.size, 8, 8);
    let depth = surface
        .hit(ahead, input.camera.near_m)
        .expect("the far side");
    assert!(
        (depth / (1e6 + 2.0 * 6_378_137.0) - 1.0).abs() < 0.02,
        "{depth}"
    );
    input.camera.near_m = 2e7;
    assert!(
        !judge(&input, nothing(), None)
            .frame
            .surface
            .iter()
            .any(|&hit| hit)
    );
}

#[test]
fn non_finite_vertices_are_counted() {
    let mut input = input(Ellipsoid::WGS84, &pose(0.0, 0.0, 1e6, -90.0), 16, 60);
    assert_eq!(judge(&input, nothing(), None).frame.non_finite, 0);
    let mut vertices = input.surface.vertices_rte.to_vec();
    vertices[(30 * 120 + 60) as usize] = [f32::NAN, 0.0, 0.0];
    input.surface.vertices_rte = vertices.into();
    // Six triangles meet in a vertex of the grid.
    assert_eq!(judge(&input, nothing(), None).frame.non_finite, 6);
    // A camera that is nowhere makes every hit's position NaN.
    input.camera.eye_ecef = DVec3::new(f64::NAN, 0.0, FRAC_PI_2);
    assert!(judge(&input, nothing(), None).frame.non_finite > 200);
}

#[test]
fn what_lies_between_the_centres_of_pixels_is_seen_by_a_close_look() {
    let mut input = input(Ellipsoid::WGS84, &pose(10.0, 5.0, 1e6, -90.0), 64, 60);
    // A tenth of a degree is a pixel; the foot of the eye is where four pixels meet.
    let square = |[longitude, latitude]: [f64; 2], half: f64| -> Arc<[Region]> {
        let [w, s, e, n] = [
            longitude - half,
            latitude - half,
            longitude + half,
            latitude + half,
        ];
        let rings = [[[w, s], [e, s], [e, n], [w, n], [w, s]]];
        [region(&format!("{rings:?}"))].into()
    };
    input.scene.regions = square([10.0, 5.0], 0.02);
    let reference = ReferenceBackend::new();
    let judged = reference.judge(&input).expect("a square");
    assert_eq!(judged.frame.filled_px(), 0, "no centre is in it");
    let scene = reference.scene(&input).expect("a square");
    let look = CloseLook::new(&input, &scene);
    let near = |column: usize, row: usize| look.ids_within(row * 64 + column, 1);
    for (column, row) in [(31, 31), (32, 31), (31, 32), (32, 32)] {
        assert_eq!(Vec::from_iter(near(column, row)), [0, 1], "{column} {row}");
    }
    // Negative controls: two pixels on, and at a rim, there is nothing of it.
    for (column, row) in [(34, 32), (32, 29), (0, 0), (63, 63)] {
        assert_eq!(Vec::from_iter(near(column, row)), [0], "{column} {row}");
    }
    // Where the region is all there is, it is all that is seen.
    input.scene.regions = square([10.0, 5.0], 20.0);
    let scene = reference.scene(&input).expect("a square");
    let look = CloseLook::new(&input, &scene);
    assert_eq!(Vec::from_iter(look.ids_within(32 * 64 + 32, 1)), [1]);
}

#[test]
fn a_frame_is_judged_from_its_parsed_regions() {
    let mut input = input(Ellipsoid::WGS84, &pose(10.0, 5.0, 1e6, -90.0), 64, 60);
    let parsed = |rings: &str| -> Arc<[Region]> { [region(&format!("[{rings}]"))].into() };
    // Everything in sight, then everything but a hole around the foot of the eye.
    input.scene.regions = parsed("[[-40,-40],[60,-40],[60,40],[-40,40],[-40,-40]]");
    let full = ReferenceBackend::new().judge(&input).expect("a rectangle");
    assert_eq!(full.frame.filled_px(), 64 * 64);
    input.scene.regions =
        parsed("[[-40,-40],[60,-40],[60,40],[-40,40],[-40,-40]],[[9,4],[11,4],[11,6],[9,6],[9,4]]");
    let holed = ReferenceBackend::new()
        .judge(&input)
        .expect("a rectangle with a hole");
    assert_eq!(holed.frame.ids[32 * 64 + 32], 0);
    assert_eq!(holed.frame.ids[0], 1);
    // The hole is 2° × 2°, 221 km × 222 km, seen from 1,000 km under 40°: 19.5 pixels a side.
    let hole_px = 64 * 64 - holed.frame.filled_px();
    assert!((361..=400).contains(&hole_px), "{hole_px}");

    // What cannot be compared is refused, not guessed.
    input.scene.regions = parsed("[[0,0],[90,0],[-90,0],[270,10],[0,0]]");
    input.scene.edge_rule = EdgeRule::GreatEllipse;
    let refused = ReferenceBackend::new().judge(&input).map(|_| ());
    assert!(
        matches!(refused, Err(DeviceError::Unsupported { .. })),
        "{refused:?}"
    );
}

#[test]
fn rounding_decides_on_a_facet_in_the_plane_of_a_wall_and_nowhere_else() {
    let mut input = input(Ellipsoid::WGS84, &pose(0.0, 0.0, 1e6, -90.0), 16, 60);
    input.scene.regions = [region("[[[-20,0],[20,0],[20,20],[-20,20],[-20,0]]]")].into();
    // Seen from 200 km north of it, a facet in the equator's plane, which is the region's southern wall.
    input.camera.eye_ecef.z += 2e5;
    input.surface.triangles = vec![[0, 1, 2]].into();
    let reach = 4.0 / f64::from(1 << 24);
    let mut seen = |north_m: f32| {
        let z = north_m - 2e5;
        let (low, high) = (-1.1e6, -5e5);
        input.surface.vertices_rte = vec![[low, -1e6, z], [low, 1e6, z], [high, 0.0, z]].into();
        let reference = ReferenceBackend::new();
        let scene = reference.scene(&input).expect("a square");
        let look = CloseLook::new(&input, &scene);
        let judged = reference.judge_in(&input, &scene);
        let facet = judged.frame.surface.iter().filter(|&&met| met).count();
        let found: BTreeSet<BTreeSet<u32>> = (0..16 * 16)
            .map(|pixel| look.ids_by_rounding(pixel, reach))
            .filter(|ids| !ids.is_empty())
            .collect();
        let border = (0..16 * 16).filter(|&pixel| !look.ids_by_rounding(pixel, reach).is_empty());
        (facet, border.count(), found)
    };
    // No other region than those at the border.
    let expected = BTreeSet::from([BTreeSet::from([NO_REGION, 1])]);
    // An eighth of a metre from 1,100 km is rounding.
    for north_m in [0.0, 0.125] {
        let (facet, border, found) = seen(north_m);
        assert!(facet > 4 && border == facet, "{north_m}: {facet} {border}");
        assert_eq!(found, expected, "{north_m}");
    }
    // Negative controls: a metre to either side is not.
    for north_m in [-1.0, 1.0] {
        let (facet, border, _) = seen(north_m);
        assert!(facet > 4 && border == 0, "{north_m}: {facet} {border}");
    }
}
