// SPDX-License-Identifier: MIT OR Apache-2.0
//! The procedural planet: how many islands, that none crosses itself or touches another, and that
//! its bytes never change.
//!
//! Coordinates are whole multiples of 1e-7 degrees, so everything geometric is decided here in
//! integers, exactly, and by brute force.

use sha2::{Digest, Sha256};
use terrafill_core::{Region, parse_regions};
use terrafill_scene::{Islands, Scene};

const PLANET_134: Islands = Islands {
    seed: 2007,
    count: 134,
    min_vertices: 300,
    max_vertices: 915,
    lake_every: 9,
};

/// Of the text, pinned: another hash is another planet, and its figures are not comparable.
const PLANET_134_SHA256: &str = "0fb5fb02a6bd1dc78ea0958ad834cc7741753feae498c5ea03b5bd63603516d6";

type Point = [i64; 2];

/// One turn in units of 1e-7 degrees.
const TURN: i64 = 3_600_000_000;

#[allow(
    clippy::cast_possible_truncation,
    reason = "degrees × 1e7 of a planet fit by a wide margin"
)]
fn rings_of(region: &Region) -> Vec<Vec<Point>> {
    region
        .rings()
        .map(|ring| {
            ring.vertices_deg()
                .iter()
                .map(|vertex| vertex.map(|degrees| (degrees * 1e7).round() as i64))
                .collect()
        })
        .collect()
}

fn edges(ring: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]))
}

/// Sign of the turn a → b → c.
fn orientation(a: Point, b: Point, c: Point) -> i128 {
    let d = |p: Point, i: usize| i128::from(p[i] - a[i]);
    (d(b, 0) * d(c, 1) - d(b, 1) * d(c, 0)).signum()
}

/// Whether two segments share a point, ends included.
fn touch((a, b): (Point, Point), (c, d): (Point, Point)) -> bool {
    let apart = (0..2).any(|i| a[i].max(b[i]) < c[i].min(d[i]) || c[i].max(d[i]) < a[i].min(b[i]));
    !apart
        && orientation(a, b, c) * orientation(a, b, d) <= 0
        && orientation(c, d, a) * orientation(c, d, b) <= 0
}

/// Whether any two edges that are not neighbours share a point, or neighbours fold back.
fn crosses_itself(ring: &[Point]) -> bool {
    let edges: Vec<_> = edges(ring).collect();
    let count = edges.len();
    (0..count).any(|i| {
        let next = edges[(i + 1) % count];
        let folds = orientation(edges[i].0, edges[i].1, next.1) == 0
            && (edges[i].1[0] - edges[i].0[0]) * (next.1[0] - next.0[0])
                + (edges[i].1[1] - edges[i].0[1]) * (next.1[1] - next.0[1])
                < 0;
        folds
            || (i + 2..count)
                .filter(|&j| !(i == 0 && j == count - 1))
                .any(|j| touch(edges[i], edges[j]))
    })
}

fn contains(ring: &[Point], p: Point) -> bool {
    let crossings = edges(ring)
        .filter(|&(a, b)| {
            let (low, high) = if a[1] < b[1] { (a, b) } else { (b, a) };
            low[1] <= p[1] && p[1] < high[1] && orientation(low, high, p) > 0
        })
        .count();
    crossings % 2 == 1
}

fn bounds(ring: &[Point]) -> [[i64; 2]; 2] {
    [0, 1].map(|axis| {
        let values = ring.iter().map(|p| p[axis]);
        [values.clone().min().unwrap_or(0), values.max().unwrap_or(0)]
    })
}

/// Whether two shells share a point, also one turn apart.
fn overlap(first: &[Point], second: &[Point]) -> bool {
    [-TURN, 0, TURN].iter().any(|turn| {
        let second: Vec<Point> = second.iter().map(|p| [p[0] + turn, p[1]]).collect();
        let (a, b) = (bounds(first), bounds(&second));
        if (0..2).any(|i| a[i][1] < b[i][0] || b[i][1] < a[i][0]) {
            return false;
        }
        contains(first, second[0])
            || contains(&second, first[0])
            || edges(first).any(|e| edges(&second).any(|f| touch(e, f)))
    })
}

fn hash(islands: &Islands) -> String {
    Sha256::digest(islands.geojson().as_bytes())
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

#[test]
fn the_planet_is_the_pinned_one_and_another_seed_gives_another() {
    assert_eq!(hash(&PLANET_134), PLANET_134_SHA256);
    let other = Islands {
        seed: 2008,
        ..PLANET_134
    };
    assert_ne!(hash(&other), PLANET_134_SHA256);
}

#[test]
fn the_scene_is_this_planet() {
    let scene = Scene::shipped("planet-134", None).expect("embedded");
    let regions = parse_regions(PLANET_134.geojson().as_bytes(), "planet").expect("valid");
    assert_eq!(&*scene.regions, regions.as_slice());
}

#[test]
fn it_has_134_islands_of_300_to_1000_vertices_and_14_lakes() {
    let scene = Scene::shipped("planet-134", None).expect("embedded");
    let counts: Vec<usize> = scene.regions.iter().map(Region::vertex_count).collect();
    assert_eq!(counts.len(), 134);
    assert!(
        counts.iter().all(|count| (300..=1000).contains(count)),
        "{counts:?}"
    );
    assert_eq!(counts.iter().sum::<usize>(), 82_502);
    let lakes: usize = scene
        .regions
        .iter()
        .map(|region| region.rings().count() - 1)
        .sum();
    assert_eq!(lakes, 14);
    assert!(
        scene
            .regions
            .iter()
            .all(|region| region.warnings.is_empty())
    );
}

#[test]
fn no_coast_crosses_itself_and_every_lake_lies_inside() {
    let scene = Scene::shipped("planet-134", None).expect("embedded");
    for region in scene.regions.iter() {
        let rings = rings_of(region);
        for ring in &rings {
            assert!(!crosses_itself(ring), "{} crosses itself", region.name);
        }
        for lake in &rings[1..] {
            let inside = lake.iter().all(|&p| contains(&rings[0], p))
                && !edges(lake).any(|e| edges(&rings[0]).any(|f| touch(e, f)));
            assert!(inside, "the lake of {} leaves it", region.name);
        }
    }
}

#[test]
fn no_island_touches_another() {
    let scene = Scene::shipped("planet-134", None).expect("embedded");
    let shells: Vec<Vec<Point>> = scene
        .regions
        .iter()
        .map(|region| rings_of(region).swap_remove(0))
        .collect();
    for (i, first) in shells.iter().enumerate() {
        for (j, second) in shells.iter().enumerate().skip(i + 1) {
            assert!(!overlap(first, second), "islands {i} and {j} overlap");
        }
    }
}

#[test]
fn crossings_and_overlaps_are_noticed() {
    // Negative controls of the two tests above.
    let square = |x: i64, y: i64, side: i64| {
        vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
    };
    let (big, far) = (square(0, 0, 10), square(20, 0, 10));
    assert!(!overlap(&big, &far) && !crosses_itself(&big));
    assert!(overlap(&big, &square(2, 2, 3)), "one within the other");
    assert!(overlap(&big, &square(5, 5, 10)), "crossing");
    assert!(overlap(&big, &square(10, 3, 2)), "touching");
    assert!(
        overlap(&big, &square(TURN + 5, 5, 10)),
        "crossing, one turn away"
    );
    let bow_tie = vec![[0, 0], [10, 10], [10, 0], [0, 10]];
    assert!(crosses_itself(&bow_tie), "bow tie");
    let spike = vec![[0, 0], [10, 0], [5, 0], [5, 5]];
    assert!(crosses_itself(&spike), "spike");
    assert!(contains(&big, [5, 5]) && !contains(&big, [15, 5]));
}
