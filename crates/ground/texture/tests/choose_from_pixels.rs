// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a pixel and its depth to a texel, all in emulated `f32`: the position route and the chosen
//! coordinate route one after the other, against `f64`.

use glam::DVec3;
use terrafill_core::{Ellipsoid, Geodetic, nearest_f32};
use terrafill_texture::{
    Arithmetic, Chooser, CoordinateRoute, Demand, DepthFormat, MAX_TOLERANCE, MapExtent, MapRegion,
    PerspectiveView, PositionRoute, RMS_TOLERANCE,
};

const SIZE: [u32; 2] = [1920, 1080];
const TEXTURE: [u32; 2] = [4096, 4096];

/// North up, straight down on the anchor from `distance_m`; 60°.
fn view_from_above(region: &MapRegion, distance_m: f64) -> PerspectiveView {
    let (longitude, latitude) = (region.anchor_longitude_rad(), region.anchor_latitude_rad());
    let up = region.body().geodetic_surface_normal(longitude, latitude);
    let right = DVec3::new(-longitude.sin(), longitude.cos(), 0.0);
    let focal_y = 1.0 / 30_f64.to_radians().tan();
    PerspectiveView {
        eye_ecef: region.anchor_ecef() + up * distance_m,
        right,
        up: up.cross(right),
        backward: up,
        focal_x: focal_y * f64::from(SIZE[1]) / f64::from(SIZE[0]),
        focal_y,
        size: SIZE,
        depth: DepthFormat::reversed(0.1).expect("a depth format"),
    }
}

/// The pixel whose centre lies closest to a point, and the point's distance along the view, where
/// the point is on the screen and on this side of the body.
fn pixel_of(
    view: &PerspectiveView,
    body: &Ellipsoid,
    position: Geodetic,
) -> Option<([f32; 2], f64)> {
    let ecef = body.geodetic_to_ecef(position);
    let to_eye = view.eye_ecef - ecef;
    let normal = body.geodetic_surface_normal(position.longitude_rad, position.latitude_rad);
    let distance_m = to_eye.dot(view.backward);
    let x = -to_eye.dot(view.right) / distance_m * view.focal_x;
    let y = -to_eye.dot(view.up) / distance_m * view.focal_y;
    let visible = to_eye.dot(normal) > 0.1 * to_eye.length() && x.abs() < 1.0 && y.abs() < 1.0;
    let place =
        |part: f64, size: u32| -> f32 { nearest_f32((part * f64::from(size)).floor() + 0.5) };
    visible.then(|| {
        let pixel = [
            place(0.5 * (x + 1.0), SIZE[0]),
            place(0.5 * (1.0 - y), SIZE[1]),
        ];
        (pixel, distance_m)
    })
}

/// Root mean square and maximum in texels, and the number of pixels that were looked at.
fn texel_errors(region: &MapRegion, distance_m: f64, position: PositionRoute) -> (f64, f64, u32) {
    let view = view_from_above(region, distance_m);
    let demand = Demand {
        region: *region,
        texture_size: TEXTURE,
        pixel_m: view.pixel_size_m(distance_m),
    };
    let candidates = Chooser::default_candidates();
    let chooser = Chooser::new(&candidates, Vec::new());
    let choice = chooser.choose(&demand);
    let chosen = choice.chosen.expect("a route");
    let texel = demand.texel_rad();
    let to_offset = position.program(&view.depth);
    let offset_constants = position.constants(&view, region);
    let to_angles = chosen.route.program();
    let angle_constants = chosen.route.constants(region);
    let extent = region.extent();
    let [width, height] = extent.size_rad();
    let (mut square, mut max, mut count) = (0.0_f64, 0.0_f64, 0_u32);
    for (i, j) in (1..60_u8).flat_map(|i| (1..60_u8).map(move |j| (i, j))) {
        let place = Geodetic {
            longitude_rad: extent.west_rad + width * f64::from(i) / 60.0,
            latitude_rad: extent.south_rad + height * f64::from(j) / 60.0,
            height_m: 0.0,
        };
        let Some((pixel, distance_m)) = pixel_of(&view, region.body(), place) else {
            continue;
        };
        let exact_offset = view.exact_offset_m(region, pixel.map(f64::from), distance_m);
        let exact = region.exact_angles(exact_offset);
        let inputs = [pixel[0], pixel[1], view.depth.stored(distance_m)];
        let offset = to_offset.emulate_all(&offset_constants, inputs, Arithmetic::Separate);
        let offset = [offset[0], offset[1], offset[2]];
        let got = to_angles.emulate(&angle_constants, offset, Arithmetic::Separate);
        assert!(got.iter().all(|x| x.is_finite()));
        for axis in 0..2 {
            let error = (f64::from(got[axis]) - exact[axis]).abs() / texel[axis];
            max = max.max(error);
            square += error * error;
        }
        count += 1;
    }
    ((square / f64::from(2 * count)).sqrt(), max, count)
}

/// A square over the antimeridian, as wide as high where the body allows it.
fn region(latitude_deg: f64, extent_deg: f64) -> MapRegion {
    let half = 0.5 * extent_deg;
    let south = (latitude_deg - half).max(-90.0);
    let north = (latitude_deg + half).min(90.0);
    let extent = MapExtent::from_degrees(179.9 - half, south, 179.9 + half, north);
    MapRegion::anchored(Ellipsoid::WGS84, extent, (-20.0, 20.0)).expect("a region")
}

/// Extents with the distance from which they fill the screen.
const VIEWS: [(f64, f64); 7] = [
    (1e-4, 50.0),
    (1e-3, 100.0),
    (0.01, 1e3),
    (0.1, 1e4),
    (2.0, 2e5),
    (8.0, 1e6),
    (90.0, 3e7),
];

#[test]
fn the_default_position_and_the_chosen_route_stay_within_half_a_texel() {
    for latitude_deg in [0.0, 45.0, 70.0, 85.0, -45.0] {
        for (extent_deg, distance_m) in VIEWS {
            let region = region(latitude_deg, extent_deg);
            let (rms, max, count) = texel_errors(&region, distance_m, PositionRoute::default());
            let case = format!("{extent_deg} deg at {latitude_deg} from {distance_m} m");
            assert!(count > 2000, "{case}: {count} pixels");
            assert!(
                rms <= RMS_TOLERANCE && max <= MAX_TOLERANCE,
                "{case}: {rms} {max}"
            );
        }
    }
}

#[test]
fn positions_about_the_bodys_centre_do_not_close_to_the_ground() {
    // The same chosen route, 11 m of ground from 50 m above, by the two routes of the past.
    let close = region(45.0, 1e-4);
    for position in [PositionRoute::InverseEcef, PositionRoute::EyeEcef] {
        let (rms, max, _) = texel_errors(&close, 50.0, position);
        assert!(
            rms > 20.0 && max > 100.0,
            "{}: {rms} {max}",
            position.name()
        );
    }
    // From 1,000 km they are as good.
    let far = region(45.0, 8.0);
    let (rms, _, _) = texel_errors(&far, 1e6, PositionRoute::InverseEcef);
    assert!(rms <= RMS_TOLERANCE, "{rms}");
}

/// Largest error in pixels of a view from 20 m above 45° N that looks along the ground, with the
/// region's anchor `away_deg` to the east of the point below the eye, and what was looked at.
///
/// The region is what can be seen from there, not all that the picture covers: how far a picture
/// goes on beyond the horizon is nothing to the route.
fn pixel_errors_along_the_ground(route: &str, away_deg: f64) -> (f64, u32) {
    let body = Ellipsoid::WGS84;
    let (lon, lat) = (10.0, 45.0);
    let west = lon - 0.2 + away_deg.min(0.0);
    let extent = MapExtent::from_degrees(west, lat - 0.2, lon + 0.2 + away_deg, lat + 0.2);
    let (anchor_lon, anchor_lat) = ((lon + away_deg).to_radians(), lat.to_radians());
    let region = MapRegion::with_anchor(body, anchor_lon, anchor_lat, extent, (-1.0, 1.0));
    let region = region.expect("a region");
    let eye = Geodetic::from_degrees(lon, lat, 20.0);
    let up = body.geodetic_surface_normal(eye.longitude_rad, eye.latitude_rad);
    let right = DVec3::new(-eye.longitude_rad.sin(), eye.longitude_rad.cos(), 0.0);
    let north = up.cross(right);
    // 20° below the horizon, so that the lower edge is 17 m away and the upper one is the sky.
    let backward = up * 20_f64.to_radians().sin() - north * 20_f64.to_radians().cos();
    let mut view = view_from_above(&region, 20.0);
    view.eye_ecef = body.geodetic_to_ecef(eye);
    (view.right, view.up, view.backward) = (right, backward.cross(right), backward);
    let route = CoordinateRoute::parse(route).expect("a route");
    let (position, program) = (PositionRoute::default(), route.program());
    let (to_offset, constants) = (position.program(&view.depth), route.constants(&region));
    let offset_constants = position.constants(&view, &region);
    let (mut worst, mut count) = (0.0_f64, 0);
    for (i, j) in (0..40_u8).flat_map(|i| (0..9_u8).map(move |j| (i, j))) {
        let ahead_m = 20.0 * (f64::from(i) * 0.16).exp();
        let aside_m = ahead_m * (f64::from(j) - 4.0) / 6.0;
        let ground = Geodetic {
            longitude_rad: eye.longitude_rad + aside_m / (6.4e6 * eye.latitude_rad.cos()),
            latitude_rad: eye.latitude_rad + ahead_m / 6.4e6,
            height_m: 0.0,
        };
        let Some((pixel, distance_m)) = pixel_of(&view, &body, ground) else {
            continue;
        };
        let exact_offset = view.exact_offset_m(&region, pixel.map(f64::from), distance_m);
        let exact = region.exact_angles(exact_offset);
        let inputs = [pixel[0], pixel[1], view.depth.stored(distance_m)];
        let offset = to_offset.emulate_all(&offset_constants, inputs, Arithmetic::Separate);
        let offset = [offset[0], offset[1], offset[2]];
        let got = program.emulate(&constants, offset, Arithmetic::Separate);
        let metres = region.sample(ground).metres_per_radian;
        let off = [0, 1].map(|axis: usize| (f64::from(got[axis]) - exact[axis]) * metres[axis]);
        worst = worst.max(off[0].hypot(off[1]) / view.pixel_size_m(distance_m));
        count += 1;
    }
    (worst, count)
}

#[test]
fn an_anchor_below_the_eye_keeps_every_pixel_and_one_a_degree_away_does_not() {
    for (route, allowed_px) in [
        ("gnomonic-3", 0.01),
        ("gnomonic-5", 0.001),
        ("recentred-odd-15", 0.01),
    ] {
        let (below, count) = pixel_errors_along_the_ground(route, 0.0);
        assert!(
            count > 100 && below < allowed_px,
            "{route}: {below} px, {count} pixels"
        );
        let (away, _) = pixel_errors_along_the_ground(route, 1.0);
        assert!(away > RMS_TOLERANCE, "{route}: {away} px");
    }
    // Absolute angles have steps of metres wherever the anchor is.
    let (absolute, _) = pixel_errors_along_the_ground("odd-15", 0.0);
    assert!(absolute > 1.0, "{absolute} px");
}
