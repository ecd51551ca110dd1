// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions by formula, held against arithmetic and against geodesics found another way.
//!
//! Distances here come from integrating the equation of motion of a point that slides on the
//! ellipsoid without force, in Cartesian coordinates: no auxiliary sphere, no series, no latitude.

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use terrafill_core::{
    AnalyticError, AnalyticRegion, Ellipsoid, GeodesicSector, Geodetic, MeshOptions, Region,
    RegionMesh, SensorCone, SurfaceEllipse,
};

// --- Independent geodesics ---------------------------------------------------------------------

/// Where a geodesic has come to.
#[derive(Clone, Copy)]
struct Moving {
    at: DVec3,
    direction: DVec3,
    /// Distance to the neighbour that left the start at an angle, per radian, and its change.
    reduced_m: f64,
    reduced_slope: f64,
    /// Area swept per radian.
    area_m2: f64,
}

impl Moving {
    fn start(body: &Ellipsoid, center: Geodetic, azimuth_rad: f64) -> Self {
        let up = body.geodetic_surface_normal(center.longitude_rad, center.latitude_rad);
        let east = DVec3::new(-center.longitude_rad.sin(), center.longitude_rad.cos(), 0.0);
        Self {
            at: body.geodetic_to_ecef(Geodetic {
                height_m: 0.0,
                ..center
            }),
            direction: east * azimuth_rad.sin() + up.cross(east) * azimuth_rad.cos(),
            reduced_m: 0.0,
            reduced_slope: 1.0,
            area_m2: 0.0,
        }
    }

    /// Time derivative; `Σ x²/r² = 1` differentiated twice gives the pull along the gradient.
    fn change(&self, body: &Ellipsoid) -> Self {
        let squares = body.radii_m() * body.radii_m();
        let gradient = self.at / squares;
        let pull = (self.direction / squares).dot(self.direction) / gradient.length_squared();
        let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
        let curvature = 1.0 / (a * a * b * gradient.length_squared()).powi(2);
        Self {
            at: self.direction,
            direction: -gradient * pull,
            reduced_m: self.reduced_slope,
            reduced_slope: -curvature * self.reduced_m,
            area_m2: self.reduced_m,
        }
    }

    fn plus(&self, change: &Self, time: f64) -> Self {
        Self {
            at: self.at + change.at * time,
            direction: self.direction + change.direction * time,
            reduced_m: self.reduced_m + change.reduced_m * time,
            reduced_slope: self.reduced_slope + change.reduced_slope * time,
            area_m2: self.area_m2 + change.area_m2 * time,
        }
    }

    /// Runge and Kutta's classical step.
    fn step(&self, body: &Ellipsoid, length: f64) -> Self {
        let k1 = self.change(body);
        let k2 = self.plus(&k1, 0.5 * length).change(body);
        let k3 = self.plus(&k2, 0.5 * length).change(body);
        let k4 = self.plus(&k3, length).change(body);
        self.plus(&k1, length / 6.0)
            .plus(&k2, length / 3.0)
            .plus(&k3, length / 3.0)
            .plus(&k4, length / 6.0)
    }

    /// After `distance_m`, in steps of a hundredth of a radian: good to 1e-10 of the radius.
    fn travelled(mut self, body: &Ellipsoid, distance_m: f64) -> Self {
        let mut steps = 8.0;
        while distance_m / steps > 0.01 * body.polar_radius_m() {
            steps += 1.0;
        }
        let length = distance_m / steps;
        while steps > 0.0 {
            self = self.step(body, length);
            steps -= 1.0;
        }
        self
    }
}

fn shoot(body: &Ellipsoid, center: Geodetic, azimuth_rad: f64, distance_m: f64) -> Moving {
    Moving::start(body, center, azimuth_rad).travelled(body, distance_m)
}

/// Azimuth and distance from `center` to a point of the surface, by correcting shots.
fn aim(body: &Ellipsoid, center: Geodetic, point: DVec3) -> (f64, f64) {
    let start = Moving::start(body, center, 0.0);
    let up = body.geodetic_surface_normal(center.longitude_rad, center.latitude_rad);
    let (north, east) = (start.direction, start.direction.cross(up));
    // From the unit ball that the body becomes divided by its radii.
    let (from, to) = (start.at / body.radii_m(), point / body.radii_m());
    let angle = from.cross(to).length().atan2(from.dot(to));
    let towards = (to - from * from.dot(to)) * body.radii_m();
    let mut azimuth_rad = towards.dot(east).atan2(towards.dot(north));
    let mut distance_m = angle * body.polar_radius_m();
    for _ in 0..12 {
        let end = shoot(body, center, azimuth_rad, distance_m);
        let miss = point - end.at;
        if miss.length() < 2e-10 * body.polar_radius_m() {
            break;
        }
        let left = (end.at / (body.radii_m() * body.radii_m()))
            .normalize()
            .cross(end.direction);
        azimuth_rad -= miss.dot(left) / end.reduced_m;
        distance_m += miss.dot(end.direction);
    }
    (azimuth_rad, distance_m)
}

fn surface(body: &Ellipsoid, [longitude, latitude]: [f64; 2]) -> DVec3 {
    body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, 0.0))
}

/// Area within a curve given by radius over azimuth: the rule of equal steps, exact for periods.
fn area_by_quadrature(body: &Ellipsoid, center: Geodetic, radius_m: impl Fn(f64) -> f64) -> f64 {
    let count = 64;
    let step = TAU / f64::from(count);
    (0..count)
        .map(|k| {
            let azimuth = step * f64::from(k);
            step * shoot(body, center, azimuth, radius_m(azimuth)).area_m2
        })
        .sum()
}

// --- Meshes --------------------------------------------------------------------------------------

fn mesh(body: &Ellipsoid, made: &AnalyticRegion) -> RegionMesh {
    let options = MeshOptions {
        boundary_tolerance_m: 1e-4 * body.equatorial_radius_m(),
        cap_step_deg: 5.0,
    };
    let mesh = RegionMesh::build(&made.region, body, AnalyticRegion::EDGE_RULE, &options)
        .unwrap_or_else(|error| panic!("{}: {error}", made.region.name));
    mesh.check_invariants(body)
        .unwrap_or_else(|error| panic!("{}: {error}", made.region.name));
    mesh
}

/// Whether the ray from the centre of the body through `point` meets a triangle.
fn holds(mesh: &RegionMesh, point: DVec3) -> bool {
    mesh.triangles.iter().any(|corners| {
        let [a, b, c] = corners.map(|i| mesh.vertices_ecef[i as usize]);
        let side = |a: DVec3, b: DVec3| a.cross(b).dot(point) >= 0.0;
        side(a, b) && side(b, c) && side(c, a)
    })
}

fn perimeter_m(body: &Ellipsoid, made: &AnalyticRegion) -> f64 {
    made.region
        .rings()
        .flat_map(|ring| ring.edges_deg())
        .map(|(from, to)| surface(body, from).distance(surface(body, to)))
        .sum()
}

/// Area of the mesh against `exact_m2`; a boundary off by d covers at most perimeter · d more.
fn assert_area(body: &Ellipsoid, made: &AnalyticRegion, exact_m2: f64) {
    let found = mesh(body, made).area_m2;
    let allowed = made.deviation_m * perimeter_m(body, made) + 1e-9 * exact_m2;
    assert!(
        (found - exact_m2).abs() < allowed,
        "{} on {}: {found} is not {exact_m2} within {allowed}",
        made.region.name,
        body.name()
    );
    // That must mean something.
    assert!(allowed < 0.05 * exact_m2, "{allowed} of {exact_m2}");
}

fn deg(longitude: f64, latitude: f64) -> Geodetic {
    Geodetic::from_degrees(longitude, latitude, 0.0)
}

/// Centres that make trouble, and one that does not.
const CENTERS: [[f64; 2]; 7] = [
    [10.0, 40.0],
    [179.9, -20.0],
    [-180.0, 0.0],
    [30.0, 85.0],
    [-60.0, -89.999],
    [0.0, 90.0],
    [123.0, -90.0],
];

/// Largest distance of points on the edges from a circle; `per_edge` points of every edge.
fn worst_of_circle(
    body: &Ellipsoid,
    made: &AnalyticRegion,
    center: Geodetic,
    radius_m: f64,
    per_edge: u32,
) -> f64 {
    let mut worst: f64 = 0.0;
    for (from, to) in made.region.rings().flat_map(|ring| ring.edges_deg()) {
        // The whole body's outline, where there is one, is not the circle.
        if from[0].abs() == 180.0 && from[1].abs() == 90.0 {
            continue;
        }
        for k in 0..per_edge {
            let f = f64::from(k) / f64::from(per_edge);
            let point = surface(body, [0, 1].map(|i| from[i] + (to[i] - from[i]) * f));
            let (_, distance_m) = aim(body, center, point);
            worst = worst.max((distance_m - radius_m).abs());
        }
    }
    worst
}

// --- Circles -------------------------------------------------------------------------------------

#[test]
fn circles_on_spheres_have_the_area_of_caps() {
    for body in [Ellipsoid::UNIT_SPHERE, Ellipsoid::MOON] {
        let r = body.equatorial_radius_m();
        for [longitude, latitude] in CENTERS {
            for angle in [1e-5, 0.01, 0.3, 1.2, FRAC_PI_2, 2.0, 3.0] {
                let name = format!("{angle} rad about {longitude} {latitude}");
                let center = deg(longitude, latitude);
                let made = Region::circle(name, &body, center, angle * r, 2e-5 * angle * r)
                    .expect("a circle");
                assert!(made.deviation_m <= 2e-5 * angle * r);
                assert_area(
                    &body,
                    &made,
                    TAU * r * r * 2.0 * (0.5 * angle).sin().powi(2),
                );
            }
        }
    }
}

#[test]
fn circles_on_ellipsoids_have_the_area_of_their_quadrature() {
    for body in [
        Ellipsoid::WGS84,
        Ellipsoid::MARS,
        Ellipsoid::SATURN_LIKE,
        Ellipsoid::ASTEROID_250M,
    ] {
        for (index, [longitude, latitude]) in CENTERS.into_iter().enumerate() {
            let radius_m = [0.02, 0.5, 1.5, 2.5][index % 4] * body.polar_radius_m();
            let center = deg(longitude, latitude);
            let name = format!("{radius_m} m about {longitude} {latitude}");
            let made =
                Region::circle(name, &body, center, radius_m, 1e-5 * radius_m).expect("a circle");
            let exact = area_by_quadrature(&body, center, |_| radius_m);
            assert_area(&body, &made, exact);
            // Twin: the sphere of the same area; small circles are the same on every body.
            let r2 = body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2) / (4.0 * PI);
            let sphere = TAU * r2 * 2.0 * (0.5 * radius_m / r2.sqrt()).sin().powi(2);
            let limit = made.deviation_m * perimeter_m(&body, &made);
            let small = radius_m < 0.1 * body.polar_radius_m();
            assert!(
                small || (sphere - exact).abs() > 2.0 * limit,
                "{sphere} {exact} {limit}"
            );
        }
    }
}

#[test]
fn no_edge_is_further_from_its_circle_than_stated() {
    for body in Ellipsoid::ALL {
        for ([longitude, latitude], share) in
            CENTERS.into_iter().zip([0.9, 0.2, 2.2, 0.1, 0.5, 0.3, 1.7])
        {
            let (center, radius_m) = (deg(longitude, latitude), share * body.polar_radius_m());
            let made =
                Region::circle("c", &body, center, radius_m, 2e-3 * radius_m).expect("a circle");
            let worst = worst_of_circle(&body, &made, center, radius_m, 7);
            let slack = 1e-9 * body.equatorial_radius_m();
            assert!(
                worst <= made.deviation_m + slack,
                "{} {longitude} {latitude}: {worst} > {}",
                body.name(),
                made.deviation_m
            );
            // Twin: a statement of less than four fifths is noticed. Round a pole the edges are
            // parallels, and the circle is met exactly.
            if latitude.abs() < 90.0 {
                assert!(
                    worst > 0.8 * made.deviation_m,
                    "{} {longitude} {latitude}: {worst} of {}",
                    body.name(),
                    made.deviation_m
                );
            } else {
                assert!(made.deviation_m < slack);
            }
        }
    }
}

#[test]
fn a_circle_of_the_sphere_is_not_one_of_the_ellipsoid() {
    // Mutant: the right code for the wrong body must be noticed by the same check.
    let (body, center) = (Ellipsoid::WGS84, deg(10.0, 40.0));
    let sphere = Ellipsoid::new("mutant", 6_371_008.8, 6_371_008.8).expect("a sphere");
    let made = Region::circle("c", &sphere, center, 1_000e3, 100.0).expect("a circle");
    assert!(worst_of_circle(&body, &made, center, 1_000e3, 3) > 10.0 * made.deviation_m);
    // Longitude and latitude exchanged likewise.
    let made = Region::circle("c", &body, deg(40.0, 10.0), 1_000e3, 100.0).expect("a circle");
    assert!(worst_of_circle(&body, &made, center, 1_000e3, 3) > 1e5);
}

#[test]
fn points_by_shots_are_inside_and_outside() {
    for body in [
        Ellipsoid::WGS84,
        Ellipsoid::SATURN_LIKE,
        Ellipsoid::UNIT_SPHERE,
    ] {
        for [longitude, latitude] in CENTERS {
            for share in [1e-3, 0.4, 1.4, 2.0, 2.9] {
                let (center, radius_m) = (deg(longitude, latitude), share * body.polar_radius_m());
                let made = Region::circle("c", &body, center, radius_m, 1e-3 * radius_m)
                    .expect("a circle");
                let mesh = mesh(&body, &made);
                for k in 0..12 {
                    let azimuth = f64::from(k) * 0.55;
                    for (factor, inside) in [(0.3, true), (0.98, true), (1.02, false)] {
                        let end = shoot(&body, center, azimuth, factor * radius_m).at;
                        assert_eq!(
                            holds(&mesh, end),
                            inside,
                            "{} {longitude} {latitude} {share}: {azimuth} {factor}",
                            body.name()
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn both_poles_one_or_none_are_held() {
    let body = Ellipsoid::WGS84;
    let (north, south) = (DVec3::Z, -DVec3::Z);
    for (latitude, radius_deg, poles) in [
        (40.0, 30.0, [false, false]),
        (40.0, 60.0, [true, false]),
        // The ring lies mostly south of the equator and still holds the north.
        (70.0, 108.0, [true, false]),
        (-70.0, 108.0, [false, true]),
        (20.0, 120.0, [true, true]),
        (0.0, 170.0, [true, true]),
        (0.0, 80.0, [false, false]),
    ] {
        for longitude in [0.0, 77.7, 180.0] {
            let radius_m = radius_deg * 111_195.0;
            let made = Region::circle("c", &body, deg(longitude, latitude), radius_m, 1_000.0)
                .expect("a circle");
            let mesh = mesh(&body, &made);
            assert_eq!([holds(&mesh, north), holds(&mesh, south)], poles);
        }
    }
}

#[test]
fn a_circle_through_a_pole_is_whole() {
    for body in [Ellipsoid::WGS84, Ellipsoid::UNIT_SPHERE] {
        let center = deg(15.0, 60.0);
        let to_pole_m = aim(&body, center, DVec3::new(0.0, 0.0, body.polar_radius_m())).1;
        for off in [0.0, 1e-9, -1e-9, 1e-7, -1e-7, 1e-4, -1e-4] {
            let radius_m = to_pole_m * (1.0 + off);
            let made =
                Region::circle("c", &body, center, radius_m, 1e-4 * radius_m).expect("a circle");
            assert_area(
                &body,
                &made,
                area_by_quadrature(&body, center, |_| radius_m),
            );
        }
    }
}

#[test]
fn turning_and_mirroring_a_circle_changes_nothing_else() {
    let body = Ellipsoid::WGS84;
    let area = |longitude: f64, latitude: f64| {
        let made =
            Region::circle("c", &body, deg(longitude, latitude), 900e3, 10.0).expect("a circle");
        let ring = &made.region.polygons[0].shell;
        (mesh(&body, &made).area_m2, ring.vertices_deg().len())
    };
    let (straight, vertices) = area(0.0, 55.0);
    for (longitude, latitude) in [(77.0, 55.0), (180.0, 55.0), (-179.0, -55.0), (540.0, 55.0)] {
        let (found, count) = area(longitude, latitude);
        assert!(
            (found / straight - 1.0).abs() < 1e-12,
            "{longitude} {latitude}"
        );
        assert_eq!(count, vertices);
    }
    // Twin: another latitude is another circle.
    assert!((area(0.0, 54.0).0 / straight - 1.0).abs() > 1e-7);
}

#[test]
fn a_tighter_tolerance_is_kept_with_as_many_vertices_as_it_takes() {
    let body = Ellipsoid::WGS84;
    let count = |tolerance_m: f64| {
        let made =
            Region::circle("c", &body, deg(5.0, 45.0), 500e3, tolerance_m).expect("a circle");
        assert!(made.deviation_m <= tolerance_m && made.deviation_m > 0.1 * tolerance_m);
        f64::from(u32::try_from(made.region.vertex_count()).expect("few"))
    };
    let (coarse, fine) = (count(100.0), count(0.01));
    // Chords deviate with the square of their length: 10⁴ times finer is 100 times as many, within
    // the factor 2 that halving leaves open.
    assert!(
        fine / coarse > 50.0 && fine / coarse < 200.0,
        "{coarse} {fine}"
    );
}

#[test]
fn radii_end_where_geodesics_meet() {
    let body = Ellipsoid::WGS84;
    let largest_m = PI * body.polar_radius_m();
    let circle = |radius_m: f64| Region::circle("c", &body, deg(0.0, 0.0), radius_m, 1.0);
    for share in [0.999, 0.99999] {
        let made = circle(largest_m * share).expect("just short of it");
        let whole = body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2);
        let area = mesh(&body, &made).area_m2;
        assert!(area < whole && area > 0.999 * whole);
        assert!(!holds(&mesh(&body, &made), -DVec3::X));
    }
    let error = circle(largest_m * 1.000_001).expect_err("beyond");
    assert!(matches!(error, AnalyticError::BeyondCut { .. }), "{error}");
    assert!(error.to_string().contains("19970326.37"), "{error}");
}

// --- Ellipses ------------------------------------------------------------------------------------

#[test]
fn ellipses_hold_what_their_radius_says() {
    for body in [
        Ellipsoid::WGS84,
        Ellipsoid::SATURN_LIKE,
        Ellipsoid::ASTEROID_250M,
    ] {
        for [longitude, latitude] in CENTERS {
            for (major, minor) in [(0.4, 0.2), (1.9, 0.1), (0.01, 0.01)] {
                let (a, b) = (major * body.polar_radius_m(), minor * body.polar_radius_m());
                let ellipse = SurfaceEllipse {
                    center: deg(longitude, latitude),
                    semi_major_m: a,
                    semi_minor_m: b,
                    bearing_rad: 0.7,
                };
                let radius_m = |azimuth: f64| {
                    let (sin, cos) = (azimuth - 0.7).sin_cos();
                    a * b / (b * cos).hypot(a * sin)
                };
                let made = Region::ellipse("e", &body, &ellipse, 1e-3 * b).expect("an ellipse");
                assert!(made.deviation_m <= 1e-3 * b);
                let mesh = mesh(&body, &made);
                for k in 0..16 {
                    let azimuth = f64::from(k) * 0.4 + 0.01;
                    for (factor, inside) in [(0.97, true), (1.03, false)] {
                        let reach_m = factor * radius_m(azimuth);
                        let end = shoot(&body, ellipse.center, azimuth, reach_m).at;
                        assert_eq!(
                            holds(&mesh, end),
                            inside,
                            "{longitude} {latitude} {azimuth}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn area_of_an_ellipse_is_that_of_its_quadrature_and_depends_on_its_bearing() {
    let body = Ellipsoid::SATURN_LIKE;
    let ellipse = |bearing_rad: f64| SurfaceEllipse {
        center: deg(20.0, 30.0),
        semi_major_m: 20_000e3,
        semi_minor_m: 6_000e3,
        bearing_rad,
    };
    let area = |bearing_rad: f64| {
        let made = Region::ellipse("e", &body, &ellipse(bearing_rad), 100.0).expect("an ellipse");
        let exact = area_by_quadrature(&body, deg(20.0, 30.0), |azimuth| {
            let (sin, cos) = (azimuth - bearing_rad).sin_cos();
            120_000e9 / (6_000e3 * cos).hypot(20_000e3 * sin)
        });
        assert_area(&body, &made, exact);
        mesh(&body, &made).area_m2
    };
    assert!((area(0.3) / area(0.3 + PI) - 1.0).abs() < 1e-7);
    assert!((area(0.3) / area(0.3 + FRAC_PI_2) - 1.0).abs() > 1e-5);
}

#[test]
fn an_ellipse_with_equal_axes_is_a_circle() {
    let body = Ellipsoid::MARS;
    let ellipse = SurfaceEllipse {
        center: deg(-170.0, -66.0),
        semi_major_m: 2_000e3,
        semi_minor_m: 2_000e3,
        bearing_rad: 1.0,
    };
    let made = Region::ellipse("e", &body, &ellipse, 5.0).expect("an ellipse");
    assert!(worst_of_circle(&body, &made, ellipse.center, 2_000e3, 4) <= made.deviation_m + 1e-3);
}

// --- Sectors -------------------------------------------------------------------------------------

fn sector(center: Geodetic, radii_m: [f64; 2], bearings_deg: [f64; 2]) -> GeodesicSector {
    GeodesicSector {
        center,
        inner_radius_m: radii_m[0],
        outer_radius_m: radii_m[1],
        start_bearing_rad: bearings_deg[0].to_radians(),
        end_bearing_rad: bearings_deg[1].to_radians(),
    }
}

#[test]
fn sectors_of_spheres_are_their_share_of_the_zone() {
    let body = Ellipsoid::UNIT_SPHERE;
    for [longitude, latitude] in CENTERS {
        for radii in [[0.0, 0.3], [0.2, 0.9], [0.5, 2.4], [1.9, 2.0], [0.0, 3.0]] {
            for (bearings, sweep_deg) in [
                ([350.0, 10.0], 20.0),
                ([10.0, 350.0], 340.0),
                ([-90.0, 0.0], 90.0),
                ([0.0, 180.0], 180.0),
                ([123.0, -123.0], 114.0),
                ([0.0, 360.0], 360.0),
                ([-90.0, 270.0], 360.0),
                ([90.0, -270.0], 360.0),
                ([30.0, 30.5], 0.5),
            ] {
                let sector = sector(deg(longitude, latitude), radii, bearings);
                let mut made =
                    Region::geodesic_sector("s", &body, &sector, 1e-5).expect("a sector");
                made.region.name = format!("{longitude} {latitude} {radii:?} {bearings:?}");
                let exact = f64::to_radians(sweep_deg) * (radii[0].cos() - radii[1].cos());
                assert_area(&body, &made, exact);
            }
        }
    }
}

#[test]
fn points_by_shots_are_inside_and_outside_of_sectors() {
    for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
        for [longitude, latitude] in CENTERS {
            let center = deg(longitude, latitude);
            let b = body.polar_radius_m();
            for radii in [[0.0, 0.6], [0.3, 0.8], [0.1, 2.3], [1.8, 2.6]] {
                for (bearings, sweep) in [
                    ([300.0, 60.0], 120.0),
                    ([60.0, 300.0], 240.0),
                    ([5.0, 360.0], 355.0),
                    ([0.0, 360.0], 360.0),
                ] {
                    let sector = sector(center, radii.map(|r| r * b), bearings);
                    let made =
                        Region::geodesic_sector("s", &body, &sector, 1e-4 * b).expect("a sector");
                    let mesh = mesh(&body, &made);
                    for step in 0..12 {
                        let from_start = f64::from(step) * 30.0 + 1.0;
                        let azimuth = f64::to_radians(bearings[0] + from_start);
                        for radius in [
                            0.5 * radii[0],
                            radii[0] + 0.02,
                            radii[1] - 0.02,
                            radii[1] + 0.02,
                        ] {
                            if radius == 0.0 {
                                continue;
                            }
                            let inside =
                                from_start < sweep && radius > radii[0] && radius < radii[1];
                            let point = shoot(&body, center, azimuth, radius * b).at;
                            assert_eq!(
                                holds(&mesh, point),
                                inside,
                                "{} {longitude} {latitude} {radii:?} {bearings:?}: {from_start} {radius}",
                                body.name()
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn sectors_side_by_side_make_the_circle() {
    let body = Ellipsoid::WGS84;
    let center = deg(179.0, 80.0);
    let area = |made: &AnalyticRegion| mesh(&body, made).area_m2;
    let part = |from: f64, to: f64| {
        let sector = sector(center, [0.0, 2_000e3], [from, to]);
        area(&Region::geodesic_sector("s", &body, &sector, 1.0).expect("a sector"))
    };
    let whole = area(&Region::circle("c", &body, center, 2_000e3, 1.0).expect("a circle"));
    let sum = part(0.0, 75.0) + part(75.0, 200.0) + part(200.0, 0.0);
    assert!((sum / whole - 1.0).abs() < 1e-5, "{sum} {whole}");
    // Twin: the ends exchanged are the rest of the circle.
    assert!((part(75.0, 0.0) / (whole - part(0.0, 75.0)) - 1.0).abs() < 1e-5);
}

#[test]
fn a_sector_narrower_than_the_tolerance_keeps_its_sides_apart() {
    let body = Ellipsoid::WGS84;
    for [longitude, latitude] in CENTERS {
        for (radii, bearings) in [
            ([0.0, 5_000e3], [10.0, 10.001]),
            ([3_000e3, 3_000.01e3], [0.0, 270.0]),
            ([3_000e3, 3_000.01e3], [0.0, 360.0]),
        ] {
            let sector = sector(deg(longitude, latitude), radii, bearings);
            let made = Region::geodesic_sector("s", &body, &sector, 1_000.0).expect("a sector");
            assert!(made.deviation_m < 10.0);
            let options = MeshOptions {
                boundary_tolerance_m: 1e3,
                cap_step_deg: 5.0,
            };
            let mesh = RegionMesh::build(&made.region, &body, AnalyticRegion::EDGE_RULE, &options)
                .expect("meshes");
            mesh.check_invariants(&body).expect("sound");
        }
    }
}

// --- Footprints ----------------------------------------------------------------------------------

fn cone(apex: [f64; 3], azimuth_deg: f64, elevation_deg: f64, half_angle_deg: f64) -> SensorCone {
    SensorCone {
        apex: Geodetic::from_degrees(apex[0], apex[1], apex[2]),
        azimuth_rad: azimuth_deg.to_radians(),
        elevation_rad: elevation_deg.to_radians(),
        half_angle_rad: half_angle_deg.to_radians(),
    }
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

/// Number of places next to the boundary, `off_m` to its left and right, that are not seen or are.
fn wrong_beside_boundary(
    body: &Ellipsoid,
    cone: &SensorCone,
    made: &AnalyticRegion,
    off_m: f64,
) -> usize {
    let mut wrong = 0;
    for (from, to) in made.region.rings().flat_map(|ring| ring.edges_deg()) {
        for k in 0..11 {
            let f = (f64::from(k) + 0.5) / 11.0;
            let at = |f: f64| surface(body, [0, 1].map(|i| from[i] + (to[i] - from[i]) * f));
            let point = at(f);
            let normal = (point / (body.radii_m() * body.radii_m())).normalize();
            let left = normal.cross(at(f + 1e-3) - at(f - 1e-3)).normalize();
            for side in [off_m, -off_m] {
                let beside = body.ecef_to_geodetic(point + left * side);
                let beside = body.geodetic_to_ecef(Geodetic {
                    height_m: 0.0,
                    ..beside
                });
                if sees(body, cone, beside) != (side > 0.0) {
                    wrong += 1;
                }
            }
        }
    }
    wrong
}

#[test]
fn a_sensor_over_a_sphere_sees_a_cap() {
    for body in [Ellipsoid::UNIT_SPHERE, Ellipsoid::MOON] {
        let r = body.equatorial_radius_m();
        for [longitude, latitude] in CENTERS {
            for height in [1e-6_f64, 0.01, 1.0, 60.0] {
                let horizon = (1.0 / (1.0 + height)).acos();
                let widest = FRAC_PI_2 - horizon;
                for half_angle in [
                    0.01 * widest,
                    0.5 * widest,
                    0.999 * widest,
                    0.5 * (widest + FRAC_PI_2),
                ] {
                    let cone = cone(
                        [longitude, latitude, height * r],
                        77.0,
                        -90.0,
                        half_angle.to_degrees(),
                    );
                    let angle: f64 = if half_angle < widest {
                        ((1.0 + height) * half_angle.sin()).asin() - half_angle
                    } else {
                        horizon
                    };
                    let mut made =
                        Region::cone_footprint("f", &body, &cone, (1e-4 * angle).max(2e-11) * r)
                            .expect("a footprint");
                    made.region.name = format!("{longitude} {latitude} {height} {half_angle}");
                    let exact = TAU * r * r * 2.0 * (0.5 * angle).sin().powi(2);
                    assert_area(&body, &made, exact);
                }
            }
        }
    }
}

/// Apex in degrees and equatorial radii, azimuth, elevation, half angle.
const CONES: [([f64; 3], [f64; 3]); 12] = [
    ([10.0, 40.0, 0.1], [30.0, -90.0, 20.0]),
    ([10.0, 40.0, 0.1], [30.0, -60.0, 10.0]),
    ([179.0, 10.0, 0.5], [80.0, -70.0, 10.0]),
    ([0.0, 80.0, 0.2], [0.0, -60.0, 12.0]),
    ([0.0, 90.0, 0.3], [10.0, -75.0, 20.0]),
    ([0.0, -90.0, 0.3], [10.0, -90.0, 89.0]),
    // Over the horizon, from near and far.
    ([10.0, 40.0, 0.1], [30.0, -30.0, 20.0]),
    ([-100.0, 30.0, 1e-4], [200.0, -5.0, 10.0]),
    ([75.0, 0.0, 5.6], [300.0, -83.0, 5.0]),
    ([170.0, 75.0, 1.0], [10.0, -70.0, 30.0]),
    // Looking up, with only the lower edge on the body.
    ([20.0, 50.0, 0.01], [45.0, 5.0, 30.0]),
    // Nearly all of what can be seen.
    ([20.0, -50.0, 2.0], [45.0, -88.0, 19.0]),
];

#[test]
fn footprints_are_what_the_cone_sees() {
    for body in Ellipsoid::ALL {
        let a = body.equatorial_radius_m();
        for ([longitude, latitude, height], [azimuth, elevation, half_angle]) in CONES {
            let cone = cone(
                [longitude, latitude, height * a],
                azimuth,
                elevation,
                half_angle,
            );
            let tolerance_m = 1e-4 * a * height.min(1.0);
            let made = Region::cone_footprint(
                format!("{longitude} {latitude} {azimuth} {elevation}"),
                &body,
                &cone,
                tolerance_m,
            )
            .expect("a footprint");
            assert!(made.deviation_m <= tolerance_m);
            mesh(&body, &made);
            let off_m = made.deviation_m + 1e-9 * a;
            let wrong = wrong_beside_boundary(&body, &cone, &made, off_m);
            assert_eq!(wrong, 0, "{} {}", body.name(), made.region.name);
            // Twin: a third of it is not enough somewhere, except straight over a pole, where the
            // edges are exact.
            let exact = made.deviation_m < 1e-9 * a;
            assert_eq!(exact, latitude == -90.0);
            assert!(
                exact || wrong_beside_boundary(&body, &cone, &made, off_m / 3.0) > 0,
                "{} {}",
                body.name(),
                made.region.name
            );
        }
    }
}

#[test]
fn a_cone_about_as_wide_as_the_earth_is_cut_four_times() {
    let body = Ellipsoid::WGS84;
    let widest = (6_378_137.0_f64 / 42_164_137.0).asin().to_degrees();
    for half_angle in [
        widest - 0.1,
        widest - 0.02,
        widest - 0.01,
        widest - 1e-4,
        widest + 1e-4,
    ] {
        let cone = cone([45.0, 0.0, 35_786e3], 0.0, -90.0, half_angle);
        let made = Region::cone_footprint("f", &body, &cone, 100.0).expect("a footprint");
        mesh(&body, &made);
        assert_eq!(
            wrong_beside_boundary(&body, &cone, &made, made.deviation_m + 0.01),
            0
        );
    }
}

#[test]
fn a_cone_of_the_sphere_is_noticed() {
    // Mutant: horizon and hits of a sphere, judged on the ellipsoid.
    let sphere = Ellipsoid::new("mutant", 6_371_008.8, 6_371_008.8).expect("a sphere");
    let cone = cone([10.0, 40.0, 800e3], 30.0, -50.0, 20.0);
    let made = Region::cone_footprint("f", &sphere, &cone, 10.0).expect("a footprint");
    assert!(wrong_beside_boundary(&Ellipsoid::WGS84, &cone, &made, 100.0) > 100);
}

#[test]
fn footprints_turn_with_the_apex() {
    let body = Ellipsoid::WGS84;
    let area = |longitude: f64, latitude: f64, azimuth: f64| {
        let cone = cone([longitude, latitude, 500e3], azimuth, -40.0, 25.0);
        mesh(
            &body,
            &Region::cone_footprint("f", &body, &cone, 10.0).expect("a footprint"),
        )
        .area_m2
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
    assert!((area(0.0, 35.0, 21.0) / straight - 1.0).abs() > 1e-5);
}

// --- Refusals ------------------------------------------------------------------------------------

#[test]
fn what_cannot_be_is_refused_with_what_was_found_and_allowed() {
    let body = Ellipsoid::WGS84;
    let at = deg(10.0, 40.0);
    let degrees_for_radians = Geodetic {
        longitude_rad: 10.0,
        latitude_rad: 40.0,
        height_m: 0.0,
    };
    let circle = |center, radius_m, tolerance_m| {
        Region::circle("c", &body, center, radius_m, tolerance_m)
            .expect_err("refused")
            .to_string()
    };
    let sector = |radii: [f64; 2], bearings: [f64; 2]| {
        Region::geodesic_sector("s", &body, &sector(at, radii, bearings), 1.0)
            .expect_err("refused")
            .to_string()
    };
    let footprint = |height_m: f64, elevation: f64, half_angle: f64| {
        let cone = cone([10.0, 40.0, height_m], 0.0, elevation, half_angle);
        Region::cone_footprint("f", &body, &cone, 1.0)
            .expect_err("refused")
            .to_string()
    };
    let ellipse = SurfaceEllipse {
        center: at,
        semi_major_m: 1_000.0,
        semi_minor_m: 2_000.0,
        bearing_rad: 0.0,
    };
    let ellipse = Region::ellipse("e", &body, &ellipse, 1.0)
        .expect_err("refused")
        .to_string();
    for (message, says) in [
        (circle(degrees_for_radians, 1e3, 1.0), "latitude is 40 rad"),
        (
            circle(at, 0.0, 1.0),
            "radius is 0 m; allowed on wgs84 is 0.006",
        ),
        (circle(at, f64::NAN, 1.0), "radius is NaN m"),
        (circle(at, -5.0, 1.0), "radius is -5 m"),
        (circle(at, 1e9, 1.0), "meet again"),
        (circle(at, 1e3, 0.0), "tolerance is 0 m"),
        (circle(at, 1e3, f64::INFINITY), "tolerance is inf m"),
        (
            ellipse,
            "semi-minor axis is 2000 m; allowed on wgs84 is 0.0063",
        ),
        (sector([2e3, 1e3], [0.0, 90.0]), "inner radius is 2000 m"),
        (
            sector([1e3, 1e3], [0.0, 90.0]),
            "m wide; allowed on wgs84 is 6.378e-3",
        ),
        (
            sector([0.0, 1e3], [30.0, 30.0]),
            "m wide; allowed on wgs84 is 6.378e-3",
        ),
        (sector([0.0, 1e3], [0.0, 5_000.0]), "end bearing is 87.2"),
        (footprint(0.0, -90.0, 10.0), "height of 0 m"),
        (footprint(-100.0, -90.0, 10.0), "height of -100 m"),
        (footprint(f64::NAN, -90.0, 10.0), "height of NaN m"),
        (footprint(500e3, 10.0, 10.0), "misses wgs84"),
        (footprint(500e3, 90.0, 80.0), "misses wgs84"),
        (footprint(500e3, -90.0, 90.0), "half angle is 1.57"),
        (footprint(500e3, -90.0, 0.0), "half angle is 0 rad"),
        (footprint(500e3, -95.0, 10.0), "elevation is -1.65"),
        (footprint(1.0, -90.0, 1e-7), "wide"),
    ] {
        assert!(message.contains(says), "{message:?} does not say {says:?}");
    }
}

#[test]
fn a_near_miss_is_told_by_how_much() {
    let body = Ellipsoid::UNIT_SPHERE;
    // From one radius up the horizon is 60° below the horizontal.
    let footprint = |half_angle: f64| {
        let cone = cone([0.0, 0.0, 1.0], 0.0, -50.0, half_angle);
        Region::cone_footprint("f", &body, &cone, 1e-3)
    };
    let error = footprint(9.99).expect_err("misses").to_string();
    assert!(error.contains("10.0000° from the horizon"), "{error}");
    assert!(footprint(10.01).is_ok());
}
