// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions simplified together: borders stay shared, deviations keep their bound, nothing crosses.
//!
//! Deviations are measured here by points laid densely along both boundaries and compared in ECEF,
//! which shares nothing with the bound in `core` but the body.

use crate::outlines::{RULES, repaired};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use terrafill_core::{
    EdgeRule, Ellipsoid, Geodetic, MeshOptions, Region, RegionMesh, Ring, SharedBoundaries,
    SimplifiedRegions, SimplifyError, parse_regions,
};

/// The regions at each tolerance.
fn simplify(
    shared: &SharedBoundaries,
    tolerances_m: &[f64],
) -> Result<Vec<SimplifiedRegions>, SimplifyError> {
    let thinned = shared.thin(tolerances_m)?;
    Ok(thinned.iter().map(|level| shared.finish(level)).collect())
}

fn vertex_count(level: &SimplifiedRegions) -> usize {
    level.regions.iter().map(Region::vertex_count).sum()
}

fn parse(text: &str) -> Vec<Region> {
    parse_regions(text.as_bytes(), "test").expect("valid")
}

/// Coordinates of a polygon.
fn coordinates(rings: &[Vec<[f64; 2]>]) -> String {
    let of_ring = |ring: &Vec<[f64; 2]>| {
        let closed = ring.iter().chain(ring.first());
        let points: Vec<String> = closed.map(|[x, y]| format!("[{x:?},{y:?}]")).collect();
        format!("[{}]", points.join(","))
    };
    let rings: Vec<String> = rings.iter().map(of_ring).collect();
    format!("[{}]", rings.join(","))
}

fn feature(rings: &[Vec<[f64; 2]>]) -> String {
    format!(
        r#"{{"type":"Feature","geometry":{{"type":"Polygon","coordinates":{}}}}}"#,
        coordinates(rings)
    )
}

fn collection(polygons: &[Vec<Vec<[f64; 2]>>]) -> String {
    let features: Vec<String> = polygons.iter().map(|rings| feature(rings)).collect();
    format!(
        r#"{{"type":"FeatureCollection","features":[{}]}}"#,
        features.join(",")
    )
}

/// Uniform in −½ … ½.
fn random(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}

/// A fractal line from `a` to `b`, both included.
fn fractal(a: [f64; 2], b: [f64; 2], halvings: u32, state: &mut u64) -> Vec<[f64; 2]> {
    if halvings == 0 {
        return vec![a, b];
    }
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let off = 0.35 * random(state);
    let middle = [
        0.5 * (a[0] + b[0]) - off * dy,
        0.5 * (a[1] + b[1]) + off * dx,
    ];
    let mut line = fractal(a, middle, halvings - 1, state);
    line.pop();
    line.extend(fractal(middle, b, halvings - 1, state));
    line
}

/// Tiles of `columns` × `rows` over a part of a planet, every border fractal and shared.
fn tiles(west: f64, south: f64, step: f64, columns: usize, rows: usize) -> Vec<Region> {
    let mut state = 11_u64;
    let corners: Vec<Vec<[f64; 2]>> = (0..=rows)
        .map(|row| {
            (0..=columns)
                .map(|column| {
                    [
                        west + step * (column as f64 + 0.2 * random(&mut state)),
                        south + step * (row as f64 + 0.2 * random(&mut state)),
                    ]
                })
                .collect()
        })
        .collect();
    let across: Vec<Vec<Vec<[f64; 2]>>> = (0..=rows)
        .map(|r| {
            (0..columns)
                .map(|c| fractal(corners[r][c], corners[r][c + 1], 6, &mut state))
                .collect()
        })
        .collect();
    let up: Vec<Vec<Vec<[f64; 2]>>> = (0..rows)
        .map(|r| {
            (0..=columns)
                .map(|c| fractal(corners[r][c], corners[r + 1][c], 6, &mut state))
                .collect()
        })
        .collect();
    let mut polygons = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            let mut ring = across[r][c].clone();
            ring.pop();
            ring.extend(&up[r][c + 1]);
            ring.pop();
            ring.extend(across[r + 1][c].iter().rev());
            ring.pop();
            ring.extend(up[r][c].iter().rev());
            ring.pop();
            polygons.push(vec![ring]);
        }
    }
    let mut regions = parse(&collection(&polygons));
    // Fractals that cross one another are repaired as a scene's regions are.
    for region in &mut regions {
        region.split_at_crossings(EdgeRule::Planar);
    }
    regions
}

fn ecef(body: &Ellipsoid, [longitude, latitude]: [f64; 2]) -> DVec3 {
    body.geodetic_to_ecef(Geodetic::from_degrees(longitude, latitude, 0.0))
}

/// Points along a ring no farther apart than `step_m`, ECEF.
fn sampled(body: &Ellipsoid, rule: EdgeRule, ring: &Ring, step_m: f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    for (start, end) in ring.edges_deg() {
        let (from, to) = (ecef(body, start), ecef(body, end));
        let widest = (end[0] - start[0]).hypot(end[1] - start[1]).to_radians();
        let length_m = from.distance(to).max(match rule {
            EdgeRule::Planar => widest * body.equatorial_radius_m(),
            EdgeRule::GreatEllipse => 0.0,
        });
        let pieces = (length_m / step_m).ceil().clamp(1.0, 1e5);
        let mut k = 0.0;
        while k < pieces {
            let share = k / pieces;
            points.push(match rule {
                EdgeRule::Planar => ecef(
                    body,
                    [0, 1].map(|axis| start[axis] + (end[axis] - start[axis]) * share),
                ),
                // The plane through the centre: any point of the chord, brought to the surface
                // along the line from the centre.
                EdgeRule::GreatEllipse => {
                    let chord = from + (to - from) * share;
                    chord / (chord / body.radii_m()).length()
                }
            });
            k += 1.0;
        }
    }
    points
}

/// Largest distance from a point of `from` to the nearest of `to`; `reach_m` is a guess of it.
fn one_way_m(from: &[DVec3], to: &[DVec3], reach_m: f64) -> f64 {
    let cell = |point: DVec3| (point / reach_m).floor().as_i64vec3().to_array();
    let mut cells: HashMap<[i64; 3], Vec<DVec3>> = HashMap::new();
    for &point in to {
        cells.entry(cell(point)).or_default().push(point);
    }
    let mut worst = 0.0_f64;
    for &point in from {
        let [x, y, z] = cell(point);
        let mut nearest = f64::INFINITY;
        for k in 0..27 {
            let near = [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1];
            for other in cells.get(&near).into_iter().flatten() {
                nearest = nearest.min(point.distance_squared(*other));
            }
        }
        worst = worst.max(nearest);
    }
    worst.sqrt()
}

/// Rings before and after, and those that are no longer there. Both have the same order, and what is
/// left of a ring has none but vertices of it.
fn pairs_of_rings<'a>(
    original: &'a Region,
    simplified: &'a Region,
) -> (Vec<(&'a Ring, &'a Ring)>, Vec<&'a Ring>) {
    let (mut pairs, mut left_out) = (Vec::new(), Vec::new());
    let mut after = simplified.rings().peekable();
    for before in original.rings() {
        let is_of = |ring: &&Ring| {
            let mut vertices = ring.vertices_deg().iter();
            vertices.all(|vertex| before.vertices_deg().contains(vertex))
        };
        match after.next_if(is_of) {
            Some(ring) => pairs.push((before, ring)),
            None => left_out.push(before),
        }
    }
    assert!(after.next().is_none(), "a ring of no original");
    (pairs, left_out)
}

/// Asserts that both boundaries are as near to one another as is said; returns how near they are.
fn assert_deviation(
    body: &Ellipsoid,
    rule: EdgeRule,
    original: &Region,
    simplified: &Region,
    said_m: f64,
) -> f64 {
    let step_m = said_m / 5.0;
    let mut worst = 0.0_f64;
    let (pairs, left_out) = pairs_of_rings(original, simplified);
    for ring in left_out {
        // All of it moved to nowhere, which is as far as it is wide.
        let places: Vec<DVec3> = ring
            .vertices_deg()
            .iter()
            .map(|&at| ecef(body, at))
            .collect();
        let first = places[0];
        let reach_m = places.iter().map(|place| place.distance(first));
        worst = worst.max(reach_m.fold(0.0, f64::max));
    }
    for (a, b) in pairs {
        if a == b {
            continue;
        }
        let (a, b) = (
            sampled(body, rule, a, step_m),
            sampled(body, rule, b, step_m),
        );
        let reach_m = said_m * 1.2;
        worst = worst
            .max(one_way_m(&a, &b, reach_m))
            .max(one_way_m(&b, &a, reach_m));
    }
    // Half a step on either side is what sampling misses, and points outside a cell's reach count
    // as infinitely far.
    assert!(
        worst <= said_m + step_m,
        "{}: {worst} m, said {said_m} m",
        original.name
    );
    worst
}

/// Edges by the bits of their ends, with the regions that have them; the lower end first.
fn edges_of(regions: &[Region]) -> BTreeMap<[[u64; 2]; 2], BTreeSet<usize>> {
    let bits = |position: [f64; 2]| position.map(f64::to_bits);
    let mut edges: BTreeMap<[[u64; 2]; 2], BTreeSet<usize>> = BTreeMap::new();
    for (index, region) in regions.iter().enumerate() {
        for (start, end) in region.rings().flat_map(Ring::edges_deg) {
            let mut ends = [bits(start), bits(end)];
            ends.sort_unstable();
            edges.entry(ends).or_default().insert(index);
        }
    }
    edges
}

/// Length of the borders that each two regions share, degrees.
fn shared_lengths(regions: &[Region]) -> BTreeMap<[usize; 2], usize> {
    let mut shared = BTreeMap::new();
    for owners in edges_of(regions).values() {
        let owners: Vec<usize> = owners.iter().copied().collect();
        if let [a, b] = owners[..] {
            *shared.entry([a, b]).or_default() += 1;
        }
    }
    shared
}

/// Ends of shared borders: vertices at which an edge with two owners meets one with another set.
/// They and every pair of neighbours must survive, and every edge between two kept vertices of a
/// border must have the owners it had.
fn assert_borders_shared(original: &[Region], simplified: &[Region]) {
    let (before, after) = (shared_lengths(original), shared_lengths(simplified));
    let pairs = |lengths: &BTreeMap<[usize; 2], usize>| lengths.keys().copied().collect::<Vec<_>>();
    assert_eq!(
        pairs(&before),
        pairs(&after),
        "neighbours were lost or made"
    );
    // Vertices of shared edges, by neighbours: after simplifying, a shared border's vertices are
    // on both sides, so an edge that only one side has must not have both ends inside the border.
    let mut inside: BTreeMap<[u64; 2], BTreeSet<BTreeSet<usize>>> = BTreeMap::new();
    for (ends, owners) in edges_of(original) {
        for end in ends {
            inside.entry(end).or_default().insert(owners.clone());
        }
    }
    for (ends, owners) in edges_of(simplified) {
        for end in ends {
            let of_end = &inside[&end];
            // A vertex in the middle of a border has edges of one set of owners only.
            if of_end.len() == 1 {
                assert!(of_end.contains(&owners), "a border is no longer shared");
            }
        }
    }
}

fn mesh_all(body: &Ellipsoid, rule: EdgeRule, regions: &[Region]) -> Vec<RegionMesh> {
    let options = MeshOptions {
        boundary_tolerance_m: 1e-4 * body.equatorial_radius_m(),
        cap_step_deg: 10.0,
    };
    let meshes = RegionMesh::build_all(regions, body, rule, &options).expect("no crossings");
    for mesh in &meshes {
        assert_eq!(mesh.check_invariants(body), Ok(()), "{}", mesh.name);
    }
    meshes
}

fn perimeter_m(body: &Ellipsoid, region: &Region) -> f64 {
    let edges = region.rings().flat_map(Ring::edges_deg);
    edges
        .map(|(start, end)| {
            let middle = [0, 1].map(|axis| 0.5 * (start[axis] + end[axis]));
            let [a, b, c] = [start, middle, end].map(|at| ecef(body, at));
            1.01 * (a.distance(b) + b.distance(c))
        })
        .sum()
}

/// Everything that must hold of a level.
fn assert_level(
    body: &Ellipsoid,
    rule: EdgeRule,
    original: &[Region],
    areas_m2: &[f64],
    level: &SimplifiedRegions,
) {
    assert_borders_shared(original, &level.regions);
    let meshes = mesh_all(body, rule, &level.regions);
    for (k, deviation_m) in level.deviation_m.iter().copied().enumerate() {
        let (before, after) = (&original[k], &level.regions[k]);
        assert!(deviation_m <= level.tolerance_m);
        assert!(after.rings().all(|ring| ring.vertices_deg().len() >= 3));
        let changed_m2 = (meshes[k].area_m2 - areas_m2[k]).abs();
        let allowed_m2 = deviation_m * perimeter_m(body, before) + 1e-6 * areas_m2[k];
        assert!(changed_m2 <= allowed_m2, "{}: {changed_m2}", before.name);
        if deviation_m > 0.0 {
            // Far below the tolerance it would take a million points to see anything.
            let said_m = deviation_m.max(0.2 * level.tolerance_m);
            assert_deviation(body, rule, before, after, said_m);
        }
    }
}

fn areas_m2(body: &Ellipsoid, rule: EdgeRule, regions: &[Region]) -> Vec<f64> {
    let meshes = mesh_all(body, rule, regions);
    meshes.iter().map(|mesh| mesh.area_m2).collect()
}

#[test]
fn tiles_of_a_planet_keep_their_shared_borders_and_bounds() {
    for (body, west, south) in [
        (Ellipsoid::WGS84, -20.0, -12.0),
        (Ellipsoid::WGS84, 165.0, 40.0),
        (Ellipsoid::SATURN_LIKE, 10.0, 45.0),
        (Ellipsoid::UNIT_SPHERE, 10.0, -50.0),
    ] {
        let original = tiles(west, south, 5.0, 6, 4);
        let unit_m = body.equatorial_radius_m() / 6.4e6;
        let tolerances = [5e3, 1.2e4, 3e4].map(|metres| metres * unit_m);
        for rule in RULES {
            let areas = areas_m2(&body, rule, &original);
            let shared = SharedBoundaries::new(&original[..], &body, rule);
            let levels = simplify(&shared, &tolerances).expect("growing");
            let mut fewest = original.iter().map(Region::vertex_count).sum::<usize>();
            for level in &levels {
                assert_level(&body, rule, &original, &areas, level);
                assert!(vertex_count(level) < fewest);
                fewest = vertex_count(level);
            }
            // Corners of tiles and a few vertices between them.
            assert!(fewest < 24 * 16, "{fewest}");
            assert_eq!(shared.neighbours().len(), 3 * 6 + 5 * 4 + 2 * 15);
        }
    }
}

#[test]
#[ignore = "needs data: natural-earth-110m, us-10m"]
fn real_countries_and_states_keep_their_shared_borders_and_bounds() {
    let body = Ellipsoid::WGS84;
    for file in [
        "ne_110m_admin_0_countries.geojson",
        "ne_110m_admin_1_us_states.geojson",
        "us_states_10m.geojson",
    ] {
        let rule = EdgeRule::Planar;
        let original = repaired(file, rule);
        let areas = areas_m2(&body, rule, &original);
        assert!(shared_lengths(&original).len() > 50, "{file}: few borders");
        let shared = SharedBoundaries::new(&original[..], &body, rule);
        let levels = simplify(&shared, &[1e4, 3e4]).expect("growing");
        for level in &levels {
            assert_level(&body, rule, &original, &areas, level);
        }
    }
}

#[test]
fn of_arcs_between_the_same_places_one_becomes_the_edge() {
    let (west, east) = ([0.0, 0.0], [20.0, 0.0]);
    let ring = |north: [f64; 2], south: [f64; 2]| vec![vec![west, south, east, north]];
    let (north, border, south) = ([10.0, 0.03], [10.0, 0.01], [10.0, -0.02]);
    let regions = parse(&collection(&[ring(north, border), ring(border, south)]));
    let body = Ellipsoid::WGS84;
    let shared = SharedBoundaries::new(&regions[..], &body, EdgeRule::Planar);
    let mut levels = simplify(&shared, &[2e3, 1e4]).expect("growing");
    // What costs least goes; then neither ring can spare another, nor may two edges be the same.
    for level in levels.drain(..) {
        assert_eq!(vertex_count(&level), 6, "{:?}", level.regions);
        let vertices = level.regions.iter().flat_map(Region::rings);
        assert!(
            vertices
                .flat_map(Ring::vertices_deg)
                .all(|at| *at != border)
        );
    }
    // Negative control: with more between them, the arcs beside it can be thinned as well, but not to edges.
    let longer = vec![vec![west, border, east, [12.0, 0.03], [8.0, 0.031]]];
    let regions = parse(&collection(&[longer, ring(border, south)]));
    let shared = SharedBoundaries::new(&regions[..], &body, EdgeRule::Planar);
    let level = simplify(&shared, &[1e4]).expect("growing").remove(0);
    assert_eq!(vertex_count(&level), 6, "{:?}", level.regions);
}

#[test]
fn a_level_is_known_before_it_is_finished() {
    let tolerances_m = [5e3, 1.2e4, 3e4];
    for (west, rule) in [(-20.0, EdgeRule::Planar), (165.0, EdgeRule::GreatEllipse)] {
        let body = Ellipsoid::WGS84;
        let original = tiles(west, -12.0, 5.0, 6, 4);
        let shared = SharedBoundaries::new(&original[..], &body, rule);
        let whole = simplify(&shared, &tolerances_m).expect("growing");
        let thinned = shared.thin(&tolerances_m).expect("growing");
        for (whole, thinned) in whole.iter().zip(&thinned) {
            let level = shared.finish(thinned);
            assert_eq!(level.regions, whole.regions);
            assert_eq!(level.left_out, thinned.left_out);
            for (deviation_m, bound_m) in level.deviation_m.iter().zip(&thinned.deviation_m) {
                assert!(deviation_m <= bound_m && *bound_m <= thinned.tolerance_m);
                assert!(*deviation_m > 0.5 * bound_m, "{bound_m}");
            }
        }
        // Negative control: a level is not the next one.
        assert_ne!(shared.finish(&thinned[0]).regions, whole[1].regions);
    }
}

#[test]
fn edges_are_counted_as_meshes_have_them() {
    let body = Ellipsoid::WGS84;
    for rule in RULES {
        // Large enough that what is left of their sides is split.
        let original = tiles(-20.0, -30.0, 20.0, 3, 3);
        let shared = SharedBoundaries::new(&original[..], &body, rule);
        let counted = [1e2, 1e4].map(|boundary_tolerance_m| {
            let options = MeshOptions {
                boundary_tolerance_m,
                ..MeshOptions::default()
            };
            let drawn = |regions: &[Region]| -> usize {
                let meshes = RegionMesh::build_all(regions, &body, rule, &options);
                let meshes = meshes.expect("meshes");
                meshes.iter().map(RegionMesh::boundary_edge_count).sum()
            };
            assert_eq!(shared.edge_count(&options), drawn(&original));
            let level = &shared.thin(&[1e5]).expect("growing")[0];
            let regions = shared.finish(level).regions;
            let counted = shared.edge_count_of(level, &options);
            assert_eq!(counted, drawn(&regions));
            // Negative control: they are not the rings' edges.
            assert!(counted > regions.iter().map(Region::vertex_count).sum());
            counted
        });
        assert!(counted[0] > counted[1], "{counted:?}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let original = tiles(-20.0, -12.0, 5.0, 6, 4);
    let thinned = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let run = || {
            let shared = SharedBoundaries::new(&original[..], &Ellipsoid::WGS84, EdgeRule::Planar);
            simplify(&shared, &[5e3, 1.2e4, 3e4]).expect("growing")
        };
        let levels = pool.build().expect("threads").install(run);
        let regions = levels.into_iter().map(|level| level.regions);
        regions.collect::<Vec<_>>()
    };
    assert_eq!(thinned(1), thinned(3));
}

#[test]
fn a_border_simplified_differently_on_each_side_is_noticed() {
    let body = Ellipsoid::WGS84;
    let original = tiles(0.0, 40.0, 5.0, 2, 1);
    let rule = EdgeRule::Planar;
    let together = SharedBoundaries::new(&original[..], &body, rule);
    let level = simplify(&together, &[8e3]).expect("growing").remove(0);
    assert_borders_shared(&original, &level.regions);
    // Each tile for itself: the border's ends are no nodes then, and it is thinned twice.
    let apart: Vec<Region> = [(0, 8e3), (1, 2e3)]
        .map(|(k, tolerance_m)| {
            let alone = SharedBoundaries::new(&original[k..=k], &body, rule);
            let level = simplify(&alone, &[tolerance_m]).expect("positive");
            level[0].regions[0].clone()
        })
        .into();
    let noticed = std::panic::catch_unwind(|| assert_borders_shared(&original, &apart));
    assert!(noticed.is_err(), "the two sides differ");
}

#[test]
fn an_understated_deviation_is_noticed() {
    let body = Ellipsoid::WGS84;
    let original = tiles(0.0, 40.0, 5.0, 1, 1);
    for rule in RULES {
        let shared = SharedBoundaries::new(&original[..], &body, rule);
        let level = simplify(&shared, &[8e3]).expect("growing").remove(0);
        let said_m = level.deviation_m[0];
        let found_m = assert_deviation(&body, rule, &original[0], &level.regions[0], said_m);
        // The bound is tight.
        assert!(found_m > 0.8 * said_m, "{found_m} of {said_m}");
        let noticed = std::panic::catch_unwind(|| {
            assert_deviation(&body, rule, &original[0], &level.regions[0], 0.6 * said_m)
        });
        assert!(noticed.is_err(), "{rule:?}");
    }
}

#[test]
fn an_island_in_a_bay_is_not_jumped_over() {
    // A narrow bay in a square's southern side, with an island in it: a hole of nothing, so without
    // the island the bay would close.
    let land = vec![
        [0.0, 0.0],
        [4.9, 0.0],
        [5.0, 0.2],
        [5.1, 0.0],
        [10.0, 0.0],
        [10.0, 10.0],
        [0.0, 10.0],
    ];
    let island = vec![[4.99, 0.05], [5.01, 0.05], [5.0, 0.1]];
    let body = Ellipsoid::WGS84;
    let is_kept = |polygons: &[Vec<Vec<[f64; 2]>>], rule| {
        let regions = parse(&collection(polygons));
        let shared = SharedBoundaries::new(&regions[..], &body, rule);
        let level = simplify(&shared, &[5e4]).expect("positive").remove(0);
        let ring = &level.regions[0].polygons[0].shell;
        ring.vertices_deg().contains(&[5.0, 0.2])
    };
    for rule in RULES {
        assert!(is_kept(&[vec![land.clone()], vec![island.clone()]], rule));
        // Negative control: alone, the bay closes.
        assert!(!is_kept(&[vec![land.clone()]], rule));
    }
}

/// A shore that winds northwards, and another beside it, so many degrees to the east.
fn shores(width_deg: f64) -> Vec<[f64; 2]> {
    let shore = |east_deg: f64| {
        let place = move |k: i32| {
            let latitude = 14.0 + 0.04 * f64::from(k);
            let winding = 0.5 * (0.9 * latitude).sin() + 0.035 * (30.0 * latitude).sin();
            [winding + east_deg, latitude]
        };
        (0..=300).map(place)
    };
    let mut ring: Vec<[f64; 2]> = shore(width_deg).collect();
    ring.extend(shore(0.0).rev());
    ring
}

/// Shores may come to lie much closer than twice the tolerance without crossing, or changing places.
#[test]
fn a_lagoon_much_narrower_than_the_tolerance_keeps_its_shores_apart() {
    let body = Ellipsoid::WGS84;
    // From a hundredth of the finest tolerance on.
    for width_deg in [1e-4, 1e-3, 1e-2] {
        let original = parse(&feature(&[shores(width_deg)]));
        for rule in RULES {
            let shared = SharedBoundaries::new(&original[..], &body, rule);
            let levels = simplify(&shared, &[1e3, 4e3, 16e3]).expect("growing");
            let written_m2 = areas_m2(&body, rule, &original);
            for level in &levels {
                assert_eq!(level.restored_vertices, 0, "{rule:?}, {width_deg}°");
                // Meshing refuses shores that cross.
                assert_level(&body, rule, &original, &written_m2, level);
            }
            let counts: Vec<usize> = levels.iter().map(vertex_count).collect();
            eprintln!(
                "{rule:?}, {width_deg}°: {} vertices, then {counts:?}",
                original[0].vertex_count()
            );
            assert!(counts[2] < original[0].vertex_count(), "{counts:?}");
            // Negative control: with one shore straightened by itself they cross.
            let mut straightened = shores(width_deg);
            straightened.drain(302..601);
            let crossing = parse(&feature(&[straightened]));
            let refused = RegionMesh::build(&crossing[0], &body, rule, &MeshOptions::default());
            assert!(refused.is_err());
        }
    }
}

#[test]
fn small_islands_stay_as_they_are_and_larger_ones_keep_three_vertices() {
    let body = Ellipsoid::WGS84;
    let circle: Vec<[f64; 2]> = (0..40)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 40.0;
            [10.0 + 0.1 * angle.cos(), 20.0 + 0.1 * angle.sin()]
        })
        .collect();
    // Flat enough that a tolerance of an eighth of its length takes all it can.
    let needle: Vec<[f64; 2]> = circle
        .iter()
        .map(|[x, y]| [10.0 * (x - 10.0), 0.05 * (y - 20.0)])
        .collect();
    let regions = parse(&collection(&[vec![circle], vec![needle]]));
    for rule in RULES {
        let shared = SharedBoundaries::new(&regions[..], &body, rule);
        let vertices = |tolerance_m| {
            let level = simplify(&shared, &[tolerance_m])
                .expect("positive")
                .remove(0);
            mesh_all(&body, rule, &level.regions);
            [0, 1].map(|region: usize| level.regions[region].vertex_count())
        };
        // The box around the circle measures 31 km.
        assert_eq!(vertices(4_500.0)[0], 40);
        assert!(vertices(3_000.0)[0] < 15);
        assert_eq!(vertices(10_000.0), [40, 3]);
        // The last ring of a region stays, however small.
        assert_eq!(vertices(1e6), [40, 40]);
    }
}

#[test]
fn islands_and_lakes_of_less_than_half_a_tolerance_are_left_out_and_counted() {
    let body = Ellipsoid::WGS84;
    let ring = |longitude: f64, radius: f64| -> Vec<[f64; 2]> {
        (0..40)
            .map(|k| {
                let angle = f64::from(k) * std::f64::consts::TAU / 40.0;
                [
                    longitude + radius * angle.cos(),
                    20.0 + radius * angle.sin(),
                ]
            })
            .collect()
    };
    // Land with a lake, and an island of the same region; the lake of the second land is a region.
    let (land, lake, island) = (ring(10.0, 3.0), ring(10.0, 0.1), ring(15.0, 0.1));
    let (other, enclave) = (ring(25.0, 3.0), ring(25.0, 0.1));
    let features = [
        format!(
            r#"{{"type":"Feature","geometry":{{"type":"MultiPolygon","coordinates":[{},{}]}}}}"#,
            coordinates(&[land, lake]),
            coordinates(&[island])
        ),
        feature(&[other, enclave.clone()]),
        feature(&[enclave]),
    ];
    let joined = features.join(",");
    let regions = parse(&format!(
        r#"{{"type":"FeatureCollection","features":[{joined}]}}"#
    ));
    for rule in RULES {
        let shared = SharedBoundaries::new(&regions[..], &body, rule);
        let level = |tolerance_m| {
            simplify(&shared, &[tolerance_m])
                .expect("positive")
                .remove(0)
        };
        let rings = |level: &SimplifiedRegions| -> Vec<usize> {
            let of_region = level.regions.iter();
            of_region.map(|region| region.rings().count()).collect()
        };
        // The box around a small ring measures 31 km.
        let kept = level(60_000.0);
        assert_eq!(rings(&kept), [3, 2, 1]);
        assert!(kept.left_out.iter().all(|left_out| left_out.rings == 0));
        let left = level(66_000.0);
        assert_eq!(rings(&left), [1, 2, 1], "{rule:?}");
        let counted: Vec<usize> = left
            .left_out
            .iter()
            .map(|left_out| left_out.rings)
            .collect();
        assert_eq!(counted, [2, 0, 0]);
        // Both are circles of 11 km.
        let area_m2 = 2.0 * std::f64::consts::PI * 11_000.0_f64.powi(2);
        let said = left.left_out[0];
        assert!(
            said.area_m2 > area_m2 && said.area_m2 < 1.5 * area_m2,
            "{said:?}"
        );
        assert!(said.size_m <= left.deviation_m[0]);
        assert!(left.deviation_m[0] <= left.tolerance_m);
        let areas = areas_m2(&body, rule, &regions);
        assert_level(&body, rule, &regions, &areas, &left);
    }
}

#[test]
fn order_and_direction_of_rings_change_nothing() {
    let body = Ellipsoid::WGS84;
    let original = tiles(0.0, -12.0, 5.0, 3, 3);
    let mut polygons: Vec<Vec<Vec<[f64; 2]>>> = original
        .iter()
        .map(|region| {
            let rings = region.rings();
            rings.map(|ring| ring.vertices_deg().to_vec()).collect()
        })
        .collect();
    polygons.reverse();
    for ring in polygons.iter_mut().flatten() {
        ring.reverse();
        ring.rotate_left(17);
    }
    let reversed = parse(&collection(&polygons));
    for rule in RULES {
        let vertices = |regions: &[Region]| -> BTreeSet<[u64; 2]> {
            let shared = SharedBoundaries::new(regions, &body, rule);
            let level = simplify(&shared, &[1e4]).expect("positive").remove(0);
            let rings = level.regions.iter().flat_map(Region::rings);
            rings
                .flat_map(|ring| ring.vertices_deg().to_vec())
                .map(|position| position.map(f64::to_bits))
                .collect()
        };
        assert_eq!(vertices(&original), vertices(&reversed));
    }
}

#[test]
fn rings_round_a_pole_and_over_the_antimeridian_survive() {
    let mut state = 3_u64;
    let cap: Vec<[f64; 2]> = (0..=360)
        .map(|k| [f64::from(k) - 180.0, 70.0 + 0.5 * random(&mut state)])
        .collect();
    let mut uncut = cap.clone();
    uncut[360] = [180.0, uncut[0][1]];
    let mut closed = uncut.clone();
    closed.extend([[180.0, 90.0], [-180.0, 90.0]]);
    let strip: Vec<[f64; 2]> = (0..200)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 200.0;
            let radius = 5.0 + 0.4 * random(&mut state);
            [180.0 + radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let body = Ellipsoid::WGS84;
    for ring in [uncut, closed, strip] {
        let original = parse(&collection(&[vec![ring]]));
        for rule in RULES {
            let areas = areas_m2(&body, rule, &original);
            let shared = SharedBoundaries::new(&original[..], &body, rule);
            let level = simplify(&shared, &[2e4]).expect("positive").remove(0);
            let share = vertex_count(&level) as f64 / original[0].vertex_count() as f64;
            assert!(share < 0.75, "{share}");
            assert_level(&body, rule, &original, &areas, &level);
        }
    }
}

#[test]
fn tolerances_that_do_not_grow_are_refused() {
    let regions = tiles(0.0, 0.0, 5.0, 1, 1);
    let shared = SharedBoundaries::new(&regions[..], &Ellipsoid::WGS84, EdgeRule::Planar);
    for (tolerances, index) in [
        (&[0.0][..], 0),
        (&[10.0, 10.0], 1),
        (&[10.0, f64::NAN], 1),
        (&[f64::INFINITY], 0),
    ] {
        let refused = simplify(&shared, tolerances).expect_err("refused");
        let SimplifyError::Tolerance { index: found, .. } = refused else {
            panic!("{refused}");
        };
        assert_eq!(found, index);
    }
    assert!(simplify(&shared, &[]).expect("nothing to do").is_empty());
}
