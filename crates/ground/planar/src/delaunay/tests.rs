// SPDX-License-Identifier: MIT OR Apache-2.0
//! Delaunay triangulations: their neighbours, where places lie in them, and what blocks an edge.

use super::*;
use spade::{DelaunayTriangulation, Point2, Triangulation};
use std::collections::BTreeSet;

/// Random points, the same every time.
fn random_points(count: usize) -> Vec<Point> {
    let mut state = 1_u64;
    let mut unit = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count).map(|_| [unit(), unit()]).collect()
}

fn triangulated(points: &[Point]) -> Delaunay {
    let mut mesh = Delaunay::new([0.0, 0.0, 1.0, 1.0], points.len());
    for point in points {
        mesh.insert(*point).expect("within");
    }
    mesh
}

/// What is wrong with it, if anything.
fn fault(mesh: &Delaunay) -> Option<String> {
    let mut twice_area = 0.0;
    for (index, triangle) in (0..).zip(&mesh.triangles) {
        let [a, b, c] = triangle.corners.map(|corner| mesh.point(corner));
        let side = orient(a, b, c);
        if side <= 0.0 {
            return Some(format!("triangle {index} is turned over"));
        }
        twice_area += side;
        for i in 0..3 {
            let Some([_, opposite]) = mesh.opposite(index, i) else {
                continue;
            };
            let there = &mesh.triangles[triangle.neighbours[i] as usize];
            let j = there.index_of_neighbour(index);
            let [from, to] = mesh.ends(index, i);
            if mesh.ends(triangle.neighbours[i], j) != [to, from]
                || there.marks[j] != triangle.marks[i]
            {
                return Some(format!("triangle {index} and its neighbour {i} differ"));
            }
            if mesh.is_certainly_illegal(index, i) {
                return Some(format!("{opposite} is in the circle of triangle {index}"));
            }
        }
    }
    let [west, south] = mesh.point(0);
    let [east, north] = mesh.point(2);
    let frame = (east - west) * (north - south);
    ((0.5 * twice_area / frame - 1.0).abs() > 1e-12).then(|| "area is lost".to_owned())
}

/// Triangles as their corners' coordinates, the frame's left out.
fn triangles_of(mesh: &Delaunay) -> BTreeSet<[[u64; 2]; 3]> {
    let within = |corners: &[u32; 3]| corners.iter().all(|&i| i as usize >= FRAME_CORNERS);
    let corners = mesh.triangles.iter().map(|triangle| triangle.corners);
    corners
        .filter(within)
        .map(|corners| key(corners.map(|i| mesh.point(i))))
        .collect()
}

fn key(corners: [Point; 3]) -> [[u64; 2]; 3] {
    let mut corners = corners.map(|corner| corner.map(f64::to_bits));
    corners.sort_unstable();
    corners
}

fn triangles_by_spade(points: &[Point]) -> BTreeSet<[[u64; 2]; 3]> {
    let mut spade = DelaunayTriangulation::<Point2<f64>>::new();
    for [x, y] in points {
        spade.insert(Point2::new(*x, *y)).expect("finite");
    }
    let positions = spade.inner_faces().map(|face| face.positions());
    positions
        .map(|corners| key(corners.map(|corner| [corner.x, corner.y])))
        .collect()
}

#[test]
fn random_points_are_triangulated_as_another_library_does() {
    let points = random_points(3_000);
    let mesh = triangulated(&points);
    assert_eq!(fault(&mesh), None);
    let (ours, spades) = (triangles_of(&mesh), triangles_by_spade(&points));
    // The frame takes slivers at the hull, where that library has no frame.
    assert!(ours.is_subset(&spades) && ours.len() + 60 > spades.len());
    // Negative control: one point elsewhere, and they are not the same.
    let mut moved = points;
    moved[7] = [0.5, 0.5];
    assert!(!ours.is_subset(&triangles_by_spade(&moved)));
}

#[test]
fn faults_are_found() {
    let mut mesh = triangulated(&random_points(30));
    assert_eq!(fault(&mesh), None);
    let (triangle, i) = mesh
        .edges()
        .find(|&(triangle, i)| {
            mesh.opposite(triangle, i).is_some_and(|[p, d]| {
                let [b, c] = mesh.ends(triangle, i);
                let [p, b, c, d] = [p, b, c, d].map(|k| mesh.point(k));
                orient(p, b, d) > 0.0 && orient(p, d, c) > 0.0
            })
        })
        .expect("a convex pair");
    mesh.flip(triangle, i);
    assert!(fault(&mesh).is_some_and(|fault| fault.contains("in the circle")));
    mesh.flip(triangle, 0);
    mesh.vertices[9].point = [5.0, 5.0];
    assert!(fault(&mesh).is_some());
}

#[test]
fn a_grid_of_points_on_common_circles_and_lines() {
    let grid: Vec<Point> = (0..900)
        .map(|k| [f64::from(k % 30) / 32.0, f64::from(k * 7 % 900 / 30) / 32.0])
        .collect();
    let mesh = triangulated(&grid);
    assert_eq!(fault(&mesh), None);
    let distinct: BTreeSet<_> = grid.iter().map(|point| point.map(f64::to_bits)).collect();
    assert_eq!(mesh.vertex_count(), FRAME_CORNERS + distinct.len());
    assert_eq!(
        mesh.locate([2.0 / 32.0, 7.0 / 32.0]),
        PointLocation::Vertex(mesh_vertex(&mesh, [2.0 / 32.0, 7.0 / 32.0]))
    );
    assert!(matches!(
        mesh.locate([2.5 / 32.0, 0.0]),
        PointLocation::Edge(..)
    ));
    assert_eq!(mesh.locate([9.0, 0.0]), PointLocation::Outside);
}

#[test]
fn an_edge_that_outlives_its_middle_between_neighbours_a_rounding_away_is_flipped() {
    let (pole, middle) = ([-135.0, -90.0], [-56.393382365743946, -74.89702110518246]);
    let [a, b] = [22.213235268512115, 22.213235268512147].map(|x| [x, -59.794042210364935]);
    let mesh_of = |points: [Point; 4]| {
        let mut mesh = Delaunay::new([-180.0, -90.0, 180.0, 0.0], points.len());
        let vertices = points.map(|point| mesh.insert(point).expect("within"));
        (mesh, vertices)
    };
    let (mut mesh, [pole, a, b, middle]) = mesh_of([pole, a, b, middle]);
    // Negative control: the first stage alone leaves it, and half of it besides.
    assert!(mesh.edge_between(a, pole).is_ok() && mesh.edge_between(middle, b).is_err());
    assert!(mesh.legalise_exactly(middle).contains(&middle));
    assert!(mesh.edge_between(a, pole).is_err() && mesh.edge_between(middle, b).is_ok());
    assert_eq!(fault(&mesh), None);
    // Nothing is left to do, and of points on one circle nothing is to be had.
    assert!(mesh.legalise_exactly(middle).is_empty());
    let square = [[0.0, -2.0], [2.0, -2.0], [2.0, 0.0], [0.0, 0.0]];
    let (mut mesh, [.., last]) = mesh_of(square);
    assert!(mesh.legalise_exactly(last).is_empty());
}

fn mesh_vertex(mesh: &Delaunay, point: Point) -> u32 {
    let at = mesh.vertices.iter().position(|known| known.point == point);
    index_u32(at.expect("a vertex"))
}

#[test]
fn constraints_stay_and_are_counted_by_parity_through_vertices() {
    let mut mesh = triangulated(&random_points(500));
    let ends = [[-0.0625, 0.5], [0.25, 0.5], [0.75, 0.5], [1.0625, 0.5]];
    let [west, a, b, east] = ends.map(|point| mesh.insert(point).expect("within"));
    assert_eq!(mesh.constrain(west, east), Ok(()));
    assert_eq!(mesh.constrain(b, a), Ok(()));
    let odd = |mesh: &Delaunay, from, to| {
        let (triangle, i) = mesh.edge_between(from, to).expect("an edge");
        assert!(mesh.is_constraint(triangle, i));
        mesh.is_odd(triangle, i)
    };
    assert_eq!(
        [odd(&mesh, west, a), odd(&mesh, a, b), odd(&mesh, b, east)],
        [true, false, true]
    );
    // A later point splits an edge into two of the same parity.
    let middle = mesh.insert([0.875, 0.5]).expect("within");
    assert!(odd(&mesh, b, middle) && odd(&mesh, middle, east));
    let [south, north] = [[0.5, 0.0], [0.5, 1.0]].map(|end| mesh.insert(end).expect("within"));
    assert_eq!(mesh.constrain(south, north), Err(Blocked::Crossing));
    assert_eq!(fault(&mesh), None);
    // Negative control: beside the line nothing crosses.
    let beside = mesh.insert([0.5, 0.25]).expect("within");
    assert_eq!(mesh.constrain(south, beside), Ok(()));
    assert_eq!(mesh.insert([7.0, 0.0]), Err(Blocked::Outside));
}
