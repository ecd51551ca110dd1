// SPDX-License-Identifier: MIT OR Apache-2.0
//! Footprints of sensors, held against arithmetic on spheres and against what a cone sees on ellipsoids.
//!
//! What is seen is decided by the angle at the apex and by which way the surface faces: no
//! intersection, no discriminant.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use terrafill_core::{
    EdgeRule, Ellipsoid, FootprintError, FootprintMesher, Geodetic, RegionMesh, SensorCone,
};

const VERTICES: u32 = 512;

fn cone(apex: [f64; 3], azimuth_deg: f64, elevation_deg: f64, half_angle_deg: f64) -> SensorCone {
    SensorCone {
        apex: Geodetic::from_degrees(apex[0], apex[1], apex[2]),
        azimuth_rad: azimuth_deg.to_radians(),
        elevation_rad: elevation_deg.to_radians(),
        half_angle_rad: half_angle_deg.to_radians(),
    }
}

fn mesh(body: &Ellipsoid, cone: &SensorCone) -> Result<RegionMesh, FootprintError> {
    let mesher = FootprintMesher::new(*body, VERTICES)?;
    let footprint = mesher.footprint(cone)?;
    mesher.mesh("footprint", 0, footprint, EdgeRule::GreatEllipse)
}

/// Whether a cone sees a point of the surface: by the angle at the apex, and by whether the surface
/// there faces it.
fn sees(body: &Ellipsoid, cone: &SensorCone, point: DVec3) -> bool {
    let apex = body.geodetic_to_ecef(cone.apex);
    let (lon, lat) = (cone.apex.longitude_rad, cone.apex.latitude_rad);
    let up = body.geodetic_surface_normal(lon, lat);
    let east = DVec3::new(-lon.sin(), lon.cos(), 0.0);
    let ahead = up.cross(east) * cone.azimuth_rad.cos() + east * cone.azimuth_rad.sin();
    let axis = ahead * cone.elevation_rad.cos() + up * cone.elevation_rad.sin();
    let sight = point - apex;
    let normal = point / (body.radii_m() * body.radii_m());
    sight.angle_between(axis) < cone.half_angle_rad && sight.dot(normal) < 0.0
}

/// Number of places beside vertices, `off_m` to the left and right of the boundary, that are not seen or are.
fn wrong_beside_vertices(
    body: &Ellipsoid,
    cone: &SensorCone,
    vertices_ecef: &[DVec3],
    off_m: f64,
) -> usize {
    let after = |step: usize| vertices_ecef.iter().cycle().skip(step);
    let mut wrong = 0;
    for ((before, at), next) in vertices_ecef.iter().zip(after(1)).zip(after(2)) {
        let normal = (*at / (body.radii_m() * body.radii_m())).normalize();
        let left = normal.cross(*next - *before).normalize();
        for side_m in [off_m, -off_m] {
            let beside = body.ecef_to_geodetic(*at + left * side_m);
            let beside = body.geodetic_to_ecef(Geodetic {
                height_m: 0.0,
                ..beside
            });
            wrong += usize::from(sees(body, cone, beside) != (side_m > 0.0));
        }
    }
    wrong
}

#[test]
fn a_sensor_over_a_sphere_sees_a_cap() {
    for body in [Ellipsoid::UNIT_SPHERE, Ellipsoid::MOON] {
        let r = body.equatorial_radius_m();
        for [longitude, latitude] in [[10.0, 40.0], [179.9, -20.0], [-180.0, 0.0], [30.0, 85.0]] {
            for height in [1e-3_f64, 0.1, 1.0, 60.0] {
                let widest = FRAC_PI_2 - (1.0 / (1.0 + height)).acos();
                for half_angle in [0.01 * widest, 0.5 * widest, 0.99 * widest] {
                    let apex = [longitude, latitude, height * r];
                    let cone = cone(apex, 77.0, -90.0, half_angle.to_degrees());
                    let angle = ((1.0 + height) * half_angle.sin()).asin() - half_angle;
                    let holds_pole = latitude.abs() + angle.to_degrees() > 90.0;
                    let mesh = match mesh(&body, &cone) {
                        Ok(mesh) => mesh,
                        Err(FootprintError::NotAllRound { why, .. }) if holds_pole => {
                            assert!(why.contains("pole"), "{why}");
                            continue;
                        }
                        Err(error) => panic!("{cone:?}: {error}"),
                    };
                    assert!(!holds_pole, "{cone:?}");
                    let cap = TAU * r * r * 2.0 * (0.5 * angle).sin().powi(2);
                    let missing = 1.0 - mesh.area_m2 / cap;
                    // A plane regular polygon lacks (2π / n)² / 6 of its circle's area; a wide cap of a
                    // sphere less.
                    let chords = (TAU / f64::from(VERTICES)).powi(2) / 6.0;
                    assert!(
                        (0.0..1.01 * chords).contains(&missing),
                        "{cone:?}: {missing}"
                    );
                }
            }
        }
    }
}

/// Apex in degrees and equatorial radii, azimuth, elevation, half angle: all within the horizon of every body.
const CONES: [([f64; 3], [f64; 3]); 5] = [
    ([10.0, 40.0, 0.1], [30.0, -90.0, 20.0]),
    ([10.0, 40.0, 0.1], [30.0, -70.0, 10.0]),
    ([179.0, 10.0, 0.5], [80.0, -75.0, 10.0]),
    ([0.0, 75.0, 0.1], [180.0, -70.0, 12.0]),
    ([75.0, -20.0, 5.6], [300.0, -87.0, 3.0]),
];

#[test]
fn footprints_are_what_the_cone_sees() {
    for body in Ellipsoid::ALL {
        let a = body.equatorial_radius_m();
        for ([longitude, latitude, height], [azimuth, elevation, half_angle]) in CONES {
            let apex = [longitude, latitude, height * a];
            let cone = cone(apex, azimuth, elevation, half_angle);
            let mesh = mesh(&body, &cone).unwrap_or_else(|error| panic!("{cone:?}: {error}"));
            let wrong = wrong_beside_vertices(&body, &cone, &mesh.vertices_ecef, 1e-7 * a);
            assert_eq!(wrong, 0, "{} {cone:?}", body.name());
            // Negative control: a slightly wider cone sees more.
            let wider = SensorCone {
                half_angle_rad: cone.half_angle_rad + 1e-5,
                ..cone
            };
            let wrong = wrong_beside_vertices(&body, &wider, &mesh.vertices_ecef, 1e-7 * a);
            assert!(wrong > 0, "{} {cone:?}", body.name());
        }
    }
}

#[test]
fn a_cone_of_the_sphere_is_noticed() {
    // Mutant: hits of a sphere, judged on the ellipsoid.
    let sphere = Ellipsoid::new("mutant", 6_371_008.8, 6_371_008.8).expect("a sphere");
    let cone = cone([10.0, 40.0, 800e3], 30.0, -70.0, 20.0);
    let mesh = mesh(&sphere, &cone).expect("all round");
    let of_wgs84 = &Ellipsoid::WGS84;
    assert!(wrong_beside_vertices(of_wgs84, &cone, &mesh.vertices_ecef, 100.0) > 100);
}

#[test]
fn footprints_turn_with_the_apex() {
    let area = |longitude: f64, latitude: f64, azimuth: f64| {
        let cone = cone([longitude, latitude, 500e3], azimuth, -70.0, 25.0);
        mesh(&Ellipsoid::WGS84, &cone).expect("all round").area_m2
    };
    let straight = area(0.0, 35.0, 20.0);
    for (longitude, latitude, azimuth) in [
        (90.0, 35.0, 20.0),
        (180.0, 35.0, 20.0),
        (0.0, 35.0, -20.0),
        (0.0, -35.0, 160.0),
    ] {
        assert!((area(longitude, latitude, azimuth) / straight - 1.0).abs() < 1e-5);
    }
    assert!((area(0.0, 35.0, 70.0) / straight - 1.0).abs() > 1e-5);
}

#[test]
fn what_cannot_be_is_refused_with_what_was_found_and_allowed() {
    let body = Ellipsoid::WGS84;
    let refused = |cone: SensorCone| mesh(&body, &cone).expect_err("refused").to_string();
    let at = |height_m: f64, elevation: f64, half_angle: f64| {
        cone([10.0, 40.0, height_m], 0.0, elevation, half_angle)
    };
    let degrees_for_radians = SensorCone {
        apex: Geodetic {
            longitude_rad: 10.0,
            latitude_rad: 40.0,
            height_m: 500e3,
        },
        ..at(500e3, -90.0, 10.0)
    };
    for (cone, says) in [
        (degrees_for_radians, "latitude is 40 rad"),
        (at(0.0, -90.0, 10.0), "height of 0 m"),
        (at(-100.0, -90.0, 10.0), "height of -100 m"),
        (at(f64::NAN, -90.0, 10.0), "height of NaN m"),
        (at(500e3, 10.0, 10.0), "misses wgs84"),
        (at(500e3, 90.0, 80.0), "misses wgs84"),
        (at(500e3, -90.0, 80.0), "the horizon cuts it off"),
        (at(500e3, -90.0, 90.0), "half angle is 1.57"),
        (at(500e3, -90.0, 0.0), "half angle is 0 rad"),
        (at(500e3, -95.0, 10.0), "elevation is -1.65"),
    ] {
        let message = refused(cone);
        assert!(message.contains(says), "{message:?} does not say {says:?}");
    }
    // Negative control.
    assert!(mesh(&body, &at(500e3, -90.0, 10.0)).is_ok());
}
