// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far the walls stand from the edges they are drawn for, measured without the splitter.
//!
//! ECEF metres. A ring edge is followed in small steps, straight in longitude and latitude, or round
//! the centre in ECEF and put back on the surface. The mesher thinks in great circles of the sphere
//! of normals instead. A wall is its boundary edge swept along the geodetic normals of its two ends,
//! as the backends raise it, and what is measured is the distance to the line in which it cuts the
//! surface.

use crate::outlines::RULES;
use glam::DVec3;
use std::collections::HashMap;
use terrafill_core::{EdgeRule, Ellipsoid, Geodetic, MeshOptions, Region, RegionMesh};

const TOLERANCES_M: [f64; 3] = [1.0, 100.0, 10_000.0];

/// Rings by what their edges are like.
const SHAPES: [(&str, &str); 14] = [
    (
        "a thousandth of a degree",
        "[[10,45],[10.001,45.0005],[10,45.001]]",
    ),
    ("a tenth of a degree", "[[10,60],[10.1,60.05],[10,60.1]]"),
    ("a degree", "[[-70,-33],[-69,-33.3],[-69.5,-32]]"),
    ("ten degrees", "[[20,50],[30,56],[18,61]]"),
    ("sixty degrees", "[[0,50],[60,55],[30,10]]"),
    ("a hundred and seventy degrees", "[[-85,5],[85,8],[0,60]]"),
    (
        "a hundred and seventy degrees, west to east at 40",
        "[[-85,40],[85,42],[0,-20]]",
    ),
    ("on the antimeridian", "[[180,10],[180,60],[150,30]]"),
    ("over the antimeridian", "[[170,50],[195,60],[185,20]]"),
    ("parallel at 89.9", "[[0,89.9],[120,89.9],[125,89],[-5,89]]"),
    ("round a pole", "[[-180,70],[-60,75],[60,65],[180,70]]"),
    ("a vertex at a pole", "[[0,60],[80,62],[40,90]]"),
    ("close past a pole", "[[0,80],[179,80],[90,60]]"),
    ("over a pole", "[[0,80],[180,85],[90,60]]"),
];

fn region(ring: &str) -> Region {
    terrafill_fixtures::region(&format!("[{ring}]"))
}

fn on_surface(body: &Ellipsoid, [longitude_deg, latitude_deg]: [f64; 2]) -> DVec3 {
    body.geodetic_to_ecef(Geodetic::from_degrees(longitude_deg, latitude_deg, 0.0))
}

/// `x²/a² + y²/a² + z²/b²`, 1 on the surface.
fn level(body: &Ellipsoid, point: DVec3) -> f64 {
    (point / body.radii_m()).length_squared()
}

/// Place on the edge by its rule.
fn on_edge(
    body: &Ellipsoid,
    rule: EdgeRule,
    start: [f64; 2],
    end: [f64; 2],
    fraction: f64,
) -> DVec3 {
    match rule {
        EdgeRule::Planar => {
            let place = [0, 1].map(|i| start[i] * (1.0 - fraction) + end[i] * fraction);
            on_surface(body, place)
        }
        EdgeRule::GreatEllipse => {
            let [from, to] = [start, end].map(|end| on_surface(body, end).normalize());
            let angle = 2.0 * (0.5 * (to - from).length()).asin();
            let ray = from * ((1.0 - fraction) * angle).sin() + to * (fraction * angle).sin();
            ray / level(body, ray).sqrt()
        }
    }
}

/// One boundary edge, swept along the normals of its ends.
#[derive(Clone, Copy)]
struct Wall {
    ends: [DVec3; 2],
    normals: [DVec3; 2],
}

impl Wall {
    fn new(body: &Ellipsoid, degrees: [[f64; 2]; 2]) -> Self {
        Self {
            ends: degrees.map(|end| on_surface(body, end)),
            normals: degrees
                .map(|end| body.geodetic_surface_normal(end[0].to_radians(), end[1].to_radians())),
        }
    }

    /// Where the wall cuts the surface, at a share of its width: up along the wall by Newton.
    fn cut(&self, body: &Ellipsoid, share: f64) -> DVec3 {
        let mut point = self.ends[0].lerp(self.ends[1], share);
        let up = self.normals[0].lerp(self.normals[1], share);
        for _ in 0..6 {
            let slope = 2.0 * (point / body.radii_m() / body.radii_m()).dot(up);
            let step = (level(body, point) - 1.0) / slope;
            point -= up * step;
            if step.abs() < 1e-15 * body.equatorial_radius_m() {
                break;
            }
        }
        point
    }

    fn share_of(&self, point: DVec3) -> f64 {
        let along = self.ends[1] - self.ends[0];
        ((point - self.ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0)
    }

    /// From the bare chord.
    fn distance_from_chord_m(&self, point: DVec3) -> f64 {
        let share = self.share_of(point);
        point.distance(self.ends[0].lerp(self.ends[1], share))
    }

    fn distance_m(&self, body: &Ellipsoid, point: DVec3) -> f64 {
        let along = self.ends[1] - self.ends[0];
        let mut share = self.share_of(point);
        let mut cut = self.cut(body, share);
        for _ in 0..20 {
            let step = (point - cut).dot(along) / along.length_squared();
            let next = (share + step).clamp(0.0, 1.0);
            if (next - share).abs() < 1e-13 {
                break;
            }
            share = next;
            cut = self.cut(body, share);
        }
        point.distance(cut)
    }
}

/// Walls by the cells of a grid that they pass through.
struct Walls {
    walls: Vec<Wall>,
    cell_m: f64,
    by_cell: HashMap<[i64; 3], Vec<usize>>,
}

impl Walls {
    fn new(walls: Vec<Wall>) -> Self {
        let longest_m = walls
            .iter()
            .map(|wall| wall.ends[0].distance(wall.ends[1]))
            .fold(0.0, f64::max);
        let mut found = Self {
            cell_m: longest_m,
            by_cell: HashMap::new(),
            walls,
        };
        for (index, wall) in found.walls.iter().enumerate() {
            let middle = 0.5 * (wall.ends[0] + wall.ends[1]);
            let cell = cell(middle, found.cell_m);
            found.by_cell.entry(cell).or_default().push(index);
        }
        found
    }

    /// Of a mesh's boundary.
    fn of_mesh(body: &Ellipsoid, mesh: &RegionMesh) -> Self {
        let mut walls = Vec::new();
        for ring in &mesh.boundary_loops {
            for (from, to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                walls.push(Wall::new(
                    body,
                    [*from, *to].map(|i| mesh.vertices_deg[i as usize]),
                ));
            }
        }
        Self::new(walls)
    }

    /// Distance to the nearest.
    fn distance_m(&self, body: &Ellipsoid, point: DVec3) -> f64 {
        let [x, y, z] = cell(point, self.cell_m);
        let mut near: Vec<(f64, usize)> = Vec::new();
        for offset in 0..27 {
            let beside = [
                x + offset % 3 - 1,
                y + offset / 3 % 3 - 1,
                z + offset / 9 - 1,
            ];
            let indices = self.by_cell.get(&beside).map_or(&[][..], Vec::as_slice);
            near.extend(
                indices
                    .iter()
                    .map(|&i| (self.walls[i].distance_from_chord_m(point), i)),
            );
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.iter()
            .take(3)
            .map(|&(_, index)| self.walls[index].distance_m(body, point))
            .fold(f64::INFINITY, f64::min)
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "cells of at least a metre, bodies of less than 1e9 m"
)]
fn cell(point: DVec3, size_m: f64) -> [i64; 3] {
    (point / size_m)
        .floor()
        .to_array()
        .map(|value| value as i64)
}

/// Largest distance from the edges by their rule to the walls.
fn largest_m(body: &Ellipsoid, rule: EdgeRule, region: &Region, walls: &Walls) -> f64 {
    let mut largest = 0.0_f64;
    follow(body, rule, region, walls.walls.len(), &mut |point| {
        largest = largest.max(walls.distance_m(body, point));
    });
    largest
}

/// Calls `visit` with places on each edge, several for each wall.
fn follow(
    body: &Ellipsoid,
    rule: EdgeRule,
    region: &Region,
    walls: usize,
    visit: &mut impl FnMut(DVec3),
) {
    let steps = u32::try_from(5 * walls / region.vertex_count() + 63).expect("few");
    for (start, end) in region.rings().flat_map(|ring| ring.edges_deg()) {
        for step in 0..=steps {
            let fraction = f64::from(step) / f64::from(steps);
            visit(on_edge(body, rule, start, end, fraction));
        }
    }
}

fn build(body: &Ellipsoid, rule: EdgeRule, region: &Region, tolerance_m: f64) -> RegionMesh {
    let options = MeshOptions {
        boundary_tolerance_m: tolerance_m,
        // The tolerance alone shall decide.
        cap_step_deg: 30.0,
    };
    let mesh = RegionMesh::build(region, body, rule, &options).expect("meshes");
    assert_eq!(mesh.check_invariants(body), Ok(()));
    mesh
}

fn assert_as_reported(body: &Ellipsoid) {
    for rule in RULES {
        let mut closest_to_tolerance = 0.0_f64;
        for (name, ring) in SHAPES {
            let region = region(ring);
            for tolerance_m in TOLERANCES_M {
                let mesh = build(body, rule, &region, tolerance_m);
                let walls = Walls::of_mesh(body, &mesh);
                let measured_m = largest_m(body, rule, &region, &walls);
                let reported_m = mesh.boundary_deviation_m;
                let message = format!(
                    "{}, {}, {name}, {tolerance_m} m: measured {measured_m} m, reported \
                     {reported_m} m",
                    body.name(),
                    rule.name()
                );
                // Of ECEF coordinates, and what the search for the foot leaves.
                let rounding_m = 2e-13 * body.equatorial_radius_m();
                assert!(measured_m <= tolerance_m, "{message}");
                assert!(
                    reported_m >= measured_m * (1.0 - 1e-3) - rounding_m,
                    "{message}"
                );
                assert!(reported_m <= measured_m * 1.05 + rounding_m, "{message}");
                assert_same_length(body, rule, &region, &walls);
                closest_to_tolerance = closest_to_tolerance.max(measured_m / tolerance_m);
            }
        }
        // Great ellipses are split where their chords in longitude and latitude bow, which is
        // much more than their walls do.
        if rule == EdgeRule::Planar {
            assert!(closest_to_tolerance > 0.99, "finer than asked");
        }
    }
}

/// No walls but along the edges: chords of at most 30° are shorter than their arcs by 1.2 %.
fn assert_same_length(body: &Ellipsoid, rule: EdgeRule, region: &Region, walls: &Walls) {
    let ends = walls.walls.iter().map(|wall| wall.ends);
    let drawn_m: f64 = ends.map(|[from, to]| from.distance(to)).sum();
    let (mut true_m, mut previous) = (0.0, None::<DVec3>);
    follow(body, rule, region, walls.walls.len(), &mut |point| {
        true_m += previous.map_or(0.0, |previous| previous.distance(point));
        previous = Some(point);
    });
    let share = drawn_m / true_m;
    assert!((0.98..1.0005).contains(&share), "{drawn_m} m of {true_m} m");
}

#[test]
fn walls_on_wgs84_stand_as_close_to_their_edges_as_reported() {
    assert_as_reported(&Ellipsoid::WGS84);
}

#[test]
fn walls_on_a_sphere_stand_as_close_to_their_edges_as_reported() {
    assert_as_reported(&Ellipsoid::MOON);
}

#[test]
fn walls_on_a_flat_body_stand_as_close_to_their_edges_as_reported() {
    assert_as_reported(&Ellipsoid::SATURN_LIKE);
}

#[test]
fn a_split_left_out_is_noticed() {
    // Negative control: the same measure on walls that must not pass.
    let body = Ellipsoid::WGS84;
    for (ring, tolerance_m) in [(SHAPES[4].1, 1.0), (SHAPES[8].1, 100.0)] {
        let region = region(ring);
        let mesh = build(&body, EdgeRule::Planar, &region, tolerance_m);
        let whole = Walls::of_mesh(&body, &mesh);
        let measured_m = largest_m(&body, EdgeRule::Planar, &region, &whole);
        // Each wall joined with the next in turn: one of them bows by nearly four times as much.
        let mut worst_m = 0.0_f64;
        for index in (1..whole.walls.len()).step_by(whole.walls.len() / 8) {
            let mut walls = whole.walls.clone();
            let next = walls.remove(index);
            walls[index - 1].ends[1] = next.ends[1];
            walls[index - 1].normals[1] = next.normals[1];
            let walls = Walls::new(walls);
            worst_m = worst_m.max(largest_m(&body, EdgeRule::Planar, &region, &walls));
        }
        assert!(worst_m > tolerance_m, "{worst_m} m");
        assert!(worst_m > 2.0 * measured_m, "{worst_m} m, {measured_m} m");
        // No edge split at all.
        let edges = region.rings().flat_map(|ring| ring.edges_deg());
        let walls = edges.map(|(start, end)| Wall::new(&body, [start, end]));
        let walls = Walls::new(walls.collect());
        let unsplit_m = largest_m(&body, EdgeRule::Planar, &region, &walls);
        assert!(unsplit_m > 100.0 * tolerance_m, "{unsplit_m} m");
    }
}

#[test]
fn what_is_measured_is_the_curve_of_the_rule() {
    // Negative control: from the walls' own chords, from the other rule's curve, and to the chords instead of
    // where the walls cut the surface, the numbers are others.
    let body = Ellipsoid::WGS84;
    let region = region(SHAPES[3].1);
    let mesh = build(&body, EdgeRule::Planar, &region, 100.0);
    let walls = Walls::of_mesh(&body, &mesh);
    let measured_m = largest_m(&body, EdgeRule::Planar, &region, &walls);
    let from_chords_m = walls
        .walls
        .iter()
        .flat_map(|wall| [0.25, 0.5, 0.75].map(|share| wall.cut(&body, share)))
        .map(|point| walls.distance_m(&body, point))
        .fold(0.0, f64::max);
    assert!(from_chords_m < 1e-6 && measured_m > 50.0);
    let other_m = largest_m(&body, EdgeRule::GreatEllipse, &region, &walls);
    assert!(other_m > 1_000.0, "{other_m} m");
    let mut to_chords_m = 0.0_f64;
    follow(
        &body,
        EdgeRule::Planar,
        &region,
        walls.walls.len(),
        &mut |point| {
            let all = walls.walls.iter();
            let nearest = all.map(|wall| wall.distance_from_chord_m(point));
            to_chords_m = to_chords_m.max(nearest.fold(f64::INFINITY, f64::min));
        },
    );
    assert!(to_chords_m > 1.05 * measured_m, "{to_chords_m} m");
}
