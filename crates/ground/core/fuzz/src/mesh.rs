// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rings that are close to degenerate on purpose → region mesh.
//!
//! An input is a program for drawing rings: coarse grids, vertices shared, put on other edges or one
//! last bit beside them, holes that touch, bands round the axis, runs up to the poles. What meshes
//! must be sound and have the area that [`super::area`] finds; what is refused must deserve it.

use super::area::{Degrees, even_odd_area_m2};
use super::bytes::Bytes;
use super::reached::Reached;
use std::fmt::Write;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshError, MeshOptions, Polygon, Region, RegionMesh, VolumeHeights,
    parse_regions,
};

/// Places that a run must come to.
pub const BRANCHES: &[&str] = &[
    "unreadable",
    "meshed",
    "meshed_great_ellipse",
    "crossing_refused",
    "crossing_refused_great_ellipse",
    "overlap_refused",
    "no_area_refused",
    "opposite_ends_refused",
    "option_refused",
    "repair_used",
    "repaired_and_meshed",
    "hole",
    "hole_touches",
    "several_polygons",
    "several_loops",
    "antimeridian_cut",
    "pole_held",
    "whole_body",
    "vertex_at_pole",
    "written_past_180",
    "interior_points",
    "edges_subdivided",
    "planar_area_compared",
    "great_ellipse_area_compared",
    "reversed_compared",
    "turned_compared",
];

/// One input, decoded.
#[derive(Debug, Clone)]
pub struct Case {
    /// GeoJSON polygons: rings of vertices.
    pub polygons: Vec<Vec<Vec<Degrees>>>,
    /// Where.
    pub body: Ellipsoid,
    /// How edges run.
    pub rule: EdgeRule,
    /// How finely.
    pub options: MeshOptions,
    /// Whether crossings are made vertices first.
    pub repair: bool,
}

/// Largest number of vertices of a case: the checks here are quadratic.
const MAX_VERTICES: usize = 60;

/// Draws, meshes and judges.
///
/// # Errors
/// The find, in words.
pub fn check(input: &[u8], reached: &mut Reached) -> Result<(), String> {
    reached.execution();
    let case = decode(&mut Bytes::new(input));
    let Some(mut region) = read(&case.polygons) else {
        reached.hit("unreadable");
        return Ok(());
    };
    if case.repair && region.split_at_crossings(case.rule) > 0 {
        reached.hit("repair_used");
    }
    let outcome = RegionMesh::build(&region, &case.body, case.rule, &case.options);
    judge(&region, &case, &outcome, reached)
        .and_then(|()| compare_with_reversed(&case, &outcome, reached))
        .and_then(|()| compare_with_turned(&case, &outcome, reached))
        .map_err(|find| {
            let text = text_of(&case.polygons);
            let Case {
                body,
                rule,
                options,
                repair,
                ..
            } = &case;
            let body = body.name();
            format!("{find}\nbody {body}, {rule:?}, {options:?}, repair {repair}\n{text}")
        })
}

/// GeoJSON of the rings, as they are.
pub fn text_of(polygons: &[Vec<Vec<Degrees>>]) -> String {
    let mut text = String::from(r#"{"type":"MultiPolygon","coordinates":["#);
    for (i, rings) in polygons.iter().enumerate() {
        text.push_str(if i == 0 { "[" } else { ",[" });
        for (j, ring) in rings.iter().enumerate() {
            text.push_str(if j == 0 { "[" } else { ",[" });
            for (k, [longitude, latitude]) in ring.iter().enumerate() {
                let comma = if k == 0 { "" } else { "," };
                let _ = write!(text, "{comma}[{longitude:?},{latitude:?}]");
            }
            text.push(']');
        }
        text.push(']');
    }
    text.push_str("]}");
    text
}

fn read(polygons: &[Vec<Vec<Degrees>>]) -> Option<Region> {
    let regions = parse_regions(text_of(polygons).as_bytes(), "fuzz").ok()?;
    regions.into_iter().next()
}

// ---- judging ----------------------------------------------------------------------------------

/// Judges what meshing `region` gave.
///
/// # Errors
/// The find, in words.
pub fn judge(
    region: &Region,
    case: &Case,
    outcome: &Result<RegionMesh, MeshError>,
    reached: &mut Reached,
) -> Result<(), String> {
    match outcome {
        Ok(mesh) => {
            reached.hit("meshed");
            if case.rule == EdgeRule::GreatEllipse {
                reached.hit("meshed_great_ellipse");
            }
            if case.repair && region.warnings.iter().any(|w| w.contains("even-odd")) {
                reached.hit("repaired_and_meshed");
            }
            mesh.check_invariants(&case.body)
                .map_err(|violation| violation.to_string())?;
            judge_volume(mesh, case)?;
            judge_numbers(mesh, case)?;
            let crossing = match case.rule {
                EdgeRule::Planar => certain_crossing(region),
                // A repair makes vertices where arcs cross, on both to rounding.
                EdgeRule::GreatEllipse if case.repair => None,
                EdgeRule::GreatEllipse => certain_arc_crossing(region),
            };
            if let Some(depth_deg) = crossing {
                return Err(format!("meshed although edges cross by {depth_deg}°"));
            }
            judge_area(region, case, mesh.area_m2, reached)?;
            count_shape(region, case, mesh, reached);
            Ok(())
        }
        Err(error) => judge_refusal(region, case, error, reached),
    }
}

/// The closed solid between heights like the Earth's terrain, on a body of any size.
fn judge_volume(mesh: &RegionMesh, case: &Case) -> Result<(), String> {
    let radius_m = case.body.equatorial_radius_m();
    let heights = mesh.volume_heights(-0.002 * radius_m, 0.0015 * radius_m);
    mesh.check_volume_invariants(&case.body, heights)
        .map(|_| ())
        .map_err(|fault| fault.to_string())
}

fn count_shape(region: &Region, case: &Case, mesh: &RegionMesh, reached: &mut Reached) {
    let mut hit_if = |reached_it: bool, branch: &str| {
        if reached_it {
            reached.hit(branch);
        }
    };
    let positions = || region.rings().flat_map(|ring| ring.vertices_deg());
    let at_pole = |vertex: &&Degrees| vertex[1].abs() == 90.0;
    let on_antimeridian = mesh.vertices_deg.iter().filter(|v| v[0] == 180.0).count();
    let loops = &mesh.boundary_loops;
    hit_if(mesh.holes > 0, "hole");
    hit_if(region.polygons.iter().any(hole_touches), "hole_touches");
    hit_if(region.polygons.len() > 1, "several_polygons");
    hit_if(loops.len() > 1, "several_loops");
    hit_if(
        on_antimeridian > 1 && mesh.extent.west_deg > mesh.extent.east_deg,
        "antimeridian_cut",
    );
    let on_border = |pole: usize| loops.iter().flatten().any(|i| *i as usize == pole);
    hit_if(
        (0..mesh.vertex_count()).any(|i| mesh.vertices_deg[i][1].abs() == 90.0 && !on_border(i)),
        "pole_held",
    );
    hit_if(loops.is_empty(), "whole_body");
    hit_if(positions().any(|vertex| at_pole(&vertex)), "vertex_at_pole");
    hit_if(positions().any(|v| v[0].abs() > 180.0), "written_past_180");
    hit_if(
        mesh.vertex_count() > mesh.boundary_edge_count() && mesh.vertex_count() > 3,
        "interior_points",
    );
    hit_if(
        mesh.boundary_edge_count() > region.vertex_count() && !case.repair,
        "edges_subdivided",
    );
}

fn hole_touches(polygon: &Polygon) -> bool {
    polygon.holes.iter().any(|hole| {
        let shell = polygon.shell.vertices_deg();
        hole.vertices_deg().iter().any(|v| shell.contains(v))
    })
}

/// Largest share of the radius that counts as rounding in a deviation, as the splitter has it.
const ROUNDING: f64 = 2e-14;

/// Vertices are moved this far at most, to ±180 and to the poles.
const SNAP_DEG: f64 = 1.5e-11;

fn judge_numbers(mesh: &RegionMesh, case: &Case) -> Result<(), String> {
    let extent = mesh.extent;
    let numbers = [
        ("area", mesh.area_m2),
        ("deviation", mesh.boundary_deviation_m),
        ("sagitta", mesh.cap_sagitta_m),
        ("west", extent.west_deg),
        ("south", extent.south_deg),
        ("east", extent.east_deg),
        ("north", extent.north_deg),
    ];
    if let Some((name, value)) = numbers.iter().find(|(_, value)| !value.is_finite()) {
        return Err(format!("{name} is {value}"));
    }
    let whole_m2 = whole_area_m2(&case.body);
    if !(0.0..=whole_m2 * (1.0 + 1e-12)).contains(&mesh.area_m2) {
        return Err(format!("area {} m² of {whole_m2} m²", mesh.area_m2));
    }
    let radius_m = case.body.equatorial_radius_m();
    if mesh.boundary_deviation_m > case.options.boundary_tolerance_m.max(ROUNDING * radius_m) {
        let (found, allowed) = (mesh.boundary_deviation_m, case.options.boundary_tolerance_m);
        return Err(format!("deviation {found} m; tolerance {allowed} m"));
    }
    for [longitude, latitude] in &mesh.vertices_deg {
        let (west, east) = (extent.west_deg - SNAP_DEG, extent.east_deg + SNAP_DEG);
        let between =
            extent.south_deg - SNAP_DEG <= *latitude && *latitude <= extent.north_deg + SNAP_DEG;
        let eastward = if extent.west_deg <= extent.east_deg {
            west <= *longitude && *longitude <= east
        } else {
            *longitude >= west || *longitude <= east
        };
        // ±180 is one meridian, and at a pole there is none.
        let anywhere = longitude.abs() == 180.0 || latitude.abs() == 90.0;
        if !(between && (eastward || anywhere)) {
            return Err(format!("{longitude}, {latitude} outside {extent:?}"));
        }
    }
    judge_box(mesh, case)
}

fn judge_box(mesh: &RegionMesh, case: &Case) -> Result<(), String> {
    let radius_m = case.body.equatorial_radius_m();
    let heights = mesh.volume_heights(-0.002 * radius_m, 0.0015 * radius_m);
    let VolumeHeights { top_m, bottom_m } = heights;
    let contains = bottom_m < -0.002 * radius_m && top_m > 0.0015 * radius_m;
    if !(contains && top_m.is_finite() && bottom_m.is_finite()) {
        return Err(format!("heights {heights:?}"));
    }
    let around = mesh.oriented_box(&case.body, heights);
    let into_box = around.axes.transpose();
    for vertex in &mesh.vertices_ecef {
        let local = into_box * (*vertex - around.center_ecef);
        let beyond = (local.abs() - around.half_extents_m).max_element();
        if beyond.is_nan() || beyond > 1e-12 * radius_m {
            return Err(format!("a vertex is {beyond} m outside the box {around:?}"));
        }
    }
    Ok(())
}

fn whole_area_m2(body: &Ellipsoid) -> f64 {
    use std::f64::consts::{FRAC_PI_2, TAU};
    body.quadrangle_area_m2(TAU, -FRAC_PI_2, FRAC_PI_2)
}

fn judge_refusal(
    region: &Region,
    case: &Case,
    error: &MeshError,
    reached: &mut Reached,
) -> Result<(), String> {
    match error {
        MeshError::SelfCrossing { .. } => {
            reached.hit(match case.rule {
                EdgeRule::Planar => "crossing_refused",
                EdgeRule::GreatEllipse => "crossing_refused_great_ellipse",
            });
            judge_crossing(region, case, error)
        }
        MeshError::OppositeEnds { start, end, .. } => {
            reached.hit("opposite_ends_refused");
            let sum = unit(*start) + unit(*end);
            if case.rule == EdgeRule::Planar || sum.length() > 1e-9 {
                return Err(format!("{error}: not opposite"));
            }
            Ok(())
        }
        MeshError::Overlap { .. } => {
            reached.hit("overlap_refused");
            judge_overlap(region, case, error)
        }
        MeshError::NoArea { .. } => {
            reached.hit("no_area_refused");
            judge_no_area(region, case)
        }
        MeshError::Option { .. } => {
            reached.hit("option_refused");
            let MeshOptions {
                boundary_tolerance_m,
                cap_step_deg,
            } = case.options;
            let usable = boundary_tolerance_m > 0.0
                && boundary_tolerance_m.is_finite()
                && (0.01..=30.0).contains(&cap_step_deg);
            if usable {
                return Err(format!("{error}: within its range"));
            }
            Ok(())
        }
        other => Err(format!("a fault of the program: {other}")),
    }
}

/// What the rings enclose one by one, shells less holes, must be another area than what they do
/// together; after a repair nothing is refused for that.
fn judge_overlap(region: &Region, case: &Case, error: &MeshError) -> Result<(), String> {
    if case.repair {
        return Err(format!("{error}: after a repair"));
    }
    if case.rule != EdgeRule::Planar {
        return Ok(());
    }
    let MeshError::Overlap { first, second, .. } = error else {
        return Ok(());
    };
    // Beside a hemisphere the rest would be lost in rounding.
    let mut region = region.clone();
    let mut index = 0..;
    region.polygons.retain(|_| {
        let index = index.next();
        index == Some(first.polygon) || index == Some(second.polygon)
    });
    let area_m2 = |polygons: Vec<Polygon>| {
        let alone = Region {
            polygons,
            ..region.clone()
        };
        even_odd_area_m2(&case.body, &planar_paths(&alone))
    };
    let together = area_m2(region.polygons.clone());
    let mut of_polygons = 0.0;
    let mut holes_overlap = false;
    for polygon in &region.polygons {
        let rings = polygon.rings().enumerate().map(|(index, ring)| {
            let mut only = polygon.clone();
            only.shell = ring.clone();
            only.holes.clear();
            let ring_m2 = area_m2(vec![only]);
            if index == 0 { ring_m2 } else { -ring_m2 }
        });
        let of_rings: f64 = rings.sum();
        let of_polygon = area_m2(vec![polygon.clone()]);
        holes_overlap |= of_rings != of_polygon;
        of_polygons += of_polygon;
    }
    // To the last bit: an overlap may be as small as rounding.
    if of_polygons == together && !holes_overlap {
        return Err(format!("{error}: yet together they enclose {together} m²"));
    }
    Ok(())
}

/// Nothing may be refused as empty that is wider than the tolerance and the rounding of degrees.
fn judge_no_area(region: &Region, case: &Case) -> Result<(), String> {
    if case.rule != EdgeRule::Planar {
        return Ok(());
    }
    let area_m2 = even_odd_area_m2(&case.body, &planar_paths(region));
    let radius_m = case.body.equatorial_radius_m();
    let length_m: f64 = region
        .rings()
        .flat_map(|ring| ring.edges_deg())
        .map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]).to_radians() * radius_m)
        .sum();
    let vertices = region.rings().flat_map(|ring| ring.vertices_deg());
    let rounding = if vertices.copied().any(is_moved) {
        SNAP_DEG.to_radians()
    } else {
        1e-13
    };
    let width_m = case.options.boundary_tolerance_m + rounding * radius_m;
    let allowed_m2 = width_m * length_m;
    if area_m2 > allowed_m2 {
        return Err(format!(
            "refused as empty: {area_m2} m², over {allowed_m2} m²"
        ));
    }
    Ok(())
}

/// The two edges that are said to cross must come together at the place that is named, and after a
/// repair there must be none but such as rounding makes again and again.
fn judge_crossing(region: &Region, case: &Case, error: &MeshError) -> Result<(), String> {
    let MeshError::SelfCrossing {
        first,
        second,
        longitude_deg,
        latitude_deg,
        ..
    } = error
    else {
        return Ok(());
    };
    for place in [first, second] {
        let polygon = region.polygons.get(place.polygon);
        let edge = polygon
            .and_then(|polygon| polygon.rings().nth(place.ring))
            .and_then(|ring| {
                let mut edges = ring.edges_deg().enumerate();
                edges.find(|(i, _)| ring.file_vertex(*i) == place.vertex)
            })
            .map(|(_, edge)| edge);
        let Some((start, end)) = edge else {
            return Err(format!("{error}: no such edge"));
        };
        let away_deg = match case.rule {
            EdgeRule::GreatEllipse => {
                let place = [*longitude_deg, *latitude_deg];
                distance_to_arc(place, start, end) - plane_rounding_deg(start, end)
            }
            EdgeRule::Planar => TURNS_DEG
                .map(|turn| distance_to_edge([longitude_deg + turn, *latitude_deg], start, end))
                .into_iter()
                .fold(f64::INFINITY, f64::min),
        };
        if away_deg.is_nan() || away_deg > 1e-9 {
            return Err(format!("{error}: {away_deg}° from the edge at {place}"));
        }
    }
    if case.repair {
        return Err(format!("{error}: after its crossings were made vertices"));
    }
    if region.clone().split_at_crossings(case.rule) == 0 {
        return Err(format!("{error}: and yet no crossing to repair"));
    }
    Ok(())
}

/// Turns that two longitudes within ±540° can be apart.
const TURNS_DEG: [f64; 5] = [-720.0, -360.0, 0.0, 360.0, 720.0];

fn distance_to_edge(point: Degrees, start: Degrees, end: Degrees) -> f64 {
    let (x, y) = (end[0] - start[0], end[1] - start[1]);
    let (px, py) = (point[0] - start[0], point[1] - start[1]);
    let along = ((px * x + py * y) / (x * x + y * y)).clamp(0.0, 1.0);
    (px - along * x).hypot(py - along * y)
}

/// As an angle at the centre of a sphere with the body's normals.
fn distance_to_arc(point: Degrees, start: Degrees, end: Degrees) -> f64 {
    let [point, from, to] = [point, start, end].map(unit);
    let to_ends = [from, to].map(|end| point.distance(end));
    let nearest = to_ends[0].min(to_ends[1]);
    let is_beside = to_ends.iter().all(|away| *away < from.distance(to));
    let plane = from.cross(to - from).try_normalize();
    let away = match plane {
        Some(plane) if is_beside => plane.dot(point - from).abs().min(nearest),
        _ => nearest,
    };
    away.to_degrees()
}

/// How well the plane of an arc is known between ends that are nearly opposite, degrees: their
/// normals have the rounding of degrees turned into radians and of sines, here and in the program.
fn plane_rounding_deg(start: Degrees, end: Degrees) -> f64 {
    let [from, to] = [start, end].map(unit);
    if from.dot(to) < 0.0 {
        (1e-14 / from.cross(to).length()).to_degrees()
    } else {
        0.0
    }
}

/// Depth of a crossing of two file edges that no rounding explains away, planar rule.
///
/// `None` as well where edges lie on one another: what cancels modulo 2 can be crossed freely.
fn certain_crossing(region: &Region) -> Option<f64> {
    let edges: Vec<[Degrees; 2]> = region
        .rings()
        .flat_map(|ring| ring.edges_deg())
        .map(|(start, end)| [start, end])
        .collect();
    let mut deepest: Option<f64> = None;
    for (i, a) in edges.iter().enumerate() {
        for b in &edges[i + 1..] {
            for turn in TURNS_DEG {
                let b = b.map(|[x, y]| [x + turn, y]);
                let close = |edge: [Degrees; 2], point| offset(edge, point).abs() < CERTAIN_DEG;
                let touches = [
                    close(b, a[0]),
                    close(b, a[1]),
                    close(*a, b[0]),
                    close(*a, b[1]),
                ];
                let on_one_line = touches.into_iter().filter(|touch| *touch).count() > 2;
                if on_one_line && near(*a, b) {
                    return None;
                }
                let depth = crossing_depth(*a, b).filter(|depth| *depth > CERTAIN_DEG);
                if depth.is_some_and(|depth| deepest.is_none_or(|other| depth > other)) {
                    deepest = depth;
                }
            }
        }
    }
    deepest
}

/// Depth of a crossing of two arcs, degrees; `None` as for [`certain_crossing`].
fn certain_arc_crossing(region: &Region) -> Option<f64> {
    let edges = region.rings().flat_map(|ring| ring.edges_deg());
    let arcs = edges.map(|(start, end)| [unit(start), unit(end)]);
    // The plane of a shorter arc is not known well enough, nor of one from a side to the other.
    let has_plane = |[a, b]: &[glam::DVec3; 2]| a.distance(*b) > 1e-4 && (*a + *b).length() > 1e-4;
    let arcs: Vec<[glam::DVec3; 2]> = arcs.filter(has_plane).collect();
    let offset_deg = |[from, to]: [glam::DVec3; 2], point: glam::DVec3| {
        let plane = from.cross(to - from).normalize();
        plane.dot(point - from).asin().to_degrees()
    };
    let mut deepest: Option<f64> = None;
    for (i, a) in arcs.iter().enumerate() {
        for b in &arcs[i + 1..] {
            let off_b = a.map(|end| offset_deg(*b, end));
            let off_a = b.map(|end| offset_deg(*a, end));
            let sides = [off_b[0], off_b[1], off_a[0], off_a[1]].map(f64::abs);
            if sides.into_iter().filter(|off| *off < CERTAIN_DEG).count() > 2 {
                return None;
            }
            let place = a[0] * off_b[1].abs() + a[1] * off_b[0].abs();
            let cross = off_b[0] * off_b[1] < 0.0 && off_a[0] * off_a[1] < 0.0;
            // Or on the far side of the body.
            if cross && place.dot(b[0] + b[1]) > 0.0 {
                let depth = sides.into_iter().fold(f64::INFINITY, f64::min);
                let is_deeper = deepest.is_none_or(|other| depth > other);
                deepest = if depth > CERTAIN_DEG && is_deeper {
                    Some(depth)
                } else {
                    deepest
                };
            }
        }
    }
    deepest
}

/// What no rounding of degrees explains.
const CERTAIN_DEG: f64 = 1e-9;

/// How far the ends of two edges that cross stick out beyond one another's lines, at least.
fn crossing_depth(a: [Degrees; 2], b: [Degrees; 2]) -> Option<f64> {
    let sides = [
        offset(b, a[0]),
        offset(b, a[1]),
        offset(a, b[0]),
        offset(a, b[1]),
    ];
    let cross = sides[0] * sides[1] < 0.0 && sides[2] * sides[3] < 0.0;
    let depth = sides
        .map(f64::abs)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    cross.then_some(depth)
}

/// Whether the edges' boxes come together.
fn near(a: [Degrees; 2], b: [Degrees; 2]) -> bool {
    [0, 1].iter().all(|&k| {
        let low = |edge: [Degrees; 2]| edge[0][k].min(edge[1][k]);
        let high = |edge: [Degrees; 2]| edge[0][k].max(edge[1][k]);
        low(a) <= high(b) + 1e-9 && low(b) <= high(a) + 1e-9
    })
}

/// Signed distance of a point from the line through an edge.
fn offset([from, to]: [Degrees; 2], point: Degrees) -> f64 {
    let (x, y) = (to[0] - from[0], to[1] - from[1]);
    (x * (point[1] - from[1]) - y * (point[0] - from[0])) / x.hypot(y)
}

/// Compares the stated area with the one by slabs.
fn judge_area(
    region: &Region,
    case: &Case,
    found_m2: f64,
    reached: &mut Reached,
) -> Result<(), String> {
    let (paths, bulge_m2) = match case.rule {
        EdgeRule::Planar => (planar_paths(region), 0.0),
        EdgeRule::GreatEllipse => match great_ellipse_paths(region, &case.body) {
            Some(paths) => paths,
            _ => return Ok(()),
        },
    };
    reached.hit(match case.rule {
        EdgeRule::Planar => "planar_area_compared",
        EdgeRule::GreatEllipse => "great_ellipse_area_compared",
    });
    let expected_m2 = even_odd_area_m2(&case.body, &paths);
    let allowed_m2 = 1e-9 * expected_m2 + 0.02 * bulge_m2 + rounding_m2(case, &paths);
    if (found_m2 - expected_m2).abs() > allowed_m2 {
        return Err(format!(
            "area {found_m2} m²; by slabs {expected_m2} m², give or take {allowed_m2}"
        ));
    }
    Ok(())
}

/// Places in degrees are rounded when edges are split and turns taken off, and those a micrometre
/// (1e-11°) off ±180 or a pole are moved there; each edge's area may move by that times its length.
fn rounding_m2(case: &Case, paths: &[Vec<Degrees>]) -> f64 {
    let radius_m = case.body.equatorial_radius_m();
    let mut sum = 0.0;
    for path in paths {
        for (a, b) in path.iter().zip(path.iter().cycle().skip(1)) {
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let width = if is_moved(*a) || is_moved(*b) {
                SNAP_DEG
            } else {
                3e-13
            };
            sum += width * length;
        }
    }
    sum.to_radians() * radius_m * radius_m * 1_f64.to_radians() * 1.3
}

/// Whether the mesher moves a vertex to ±180 or to a pole.
fn is_moved([longitude, latitude]: Degrees) -> bool {
    let off_antimeridian_deg = (longitude.abs().rem_euclid(360.0) - 180.0).abs();
    let off_deg = [off_antimeridian_deg, 90.0 - latitude.abs()];
    off_deg.iter().any(|off| (1e-300..SNAP_DEG).contains(off))
}

/// Closed paths of the rings in degrees; those round the axis run on up to the pole they hold.
fn planar_paths(region: &Region) -> Vec<Vec<Degrees>> {
    let mut paths = Vec::new();
    for polygon in &region.polygons {
        let shell_goes_round = polygon.shell.winding_deg() != 0.0;
        for (index, ring) in polygon.rings().enumerate() {
            let mut path = ring.vertices_deg().to_vec();
            if ring.winding_deg() != 0.0 {
                let pole = polygon.pole_held(index, shell_goes_round).latitude_deg();
                close_over(pole, ring.winding_deg(), &mut path);
            }
            paths.push(path);
        }
    }
    paths
}

fn close_over(pole_deg: f64, winding_deg: f64, path: &mut Vec<Degrees>) {
    let first = path[0];
    let last = [first[0] + winding_deg, first[1]];
    path.extend([last, [last[0], pole_deg], [first[0], pole_deg]]);
}

/// Steps in which an arc is followed.
const ARC_STEPS: u32 = 12;

/// Paths along the arcs, straight between steps, and a bound on the area between arcs and steps.
///
/// `None` where longitudes turn too fast to be followed: arcs at, over or close to a pole.
fn great_ellipse_paths(region: &Region, body: &Ellipsoid) -> Option<(Vec<Vec<Degrees>>, f64)> {
    let mut paths = Vec::new();
    let mut bulge_m2 = 0.0;
    for polygon in &region.polygons {
        let mut shell_goes_round = false;
        for (index, ring) in polygon.rings().enumerate() {
            let vertices = ring.vertices_deg();
            let mut path = vec![vertices[0]];
            for (k, start) in vertices.iter().enumerate() {
                let end = vertices[(k + 1) % vertices.len()];
                bulge_m2 += follow_arc(body, *start, end, &mut path)?;
            }
            let first = path[0];
            let last = path.pop()?;
            let turns = ((last[0] - first[0]) / 360.0).round();
            if turns.abs() > 1.0 {
                return None;
            }
            if turns != 0.0 {
                shell_goes_round |= index == 0;
                let pole = polygon.pole_held(index, shell_goes_round).latitude_deg();
                close_over(pole, 360.0 * turns, &mut path);
            }
            paths.push(path);
        }
    }
    Some((paths, bulge_m2))
}

/// Appends the steps of one arc; returns a bound on the area between it and the straight lines of
/// its steps: the lens between chord and arc, of which n steps leave 1/n².
fn follow_arc(
    body: &Ellipsoid,
    start: Degrees,
    end: Degrees,
    path: &mut Vec<Degrees>,
) -> Option<f64> {
    let (a, b) = (unit(start), unit(end));
    let angle = 2.0 * (0.5 * (b - a).length()).min(1.0).asin();
    if angle > 3.1 {
        return None;
    }
    let from = *path.last()?;
    let mut previous = from;
    for step in 1..=ARC_STEPS {
        let share = f64::from(step) / f64::from(ARC_STEPS);
        let place = if step == ARC_STEPS {
            end
        } else if angle < 1e-7 {
            let around = nearest_turn(start[0], end[0]);
            [
                start[0] + (around - start[0]) * share,
                start[1] + (end[1] - start[1]) * share,
            ]
        } else {
            let point = a * ((1.0 - share) * angle).sin() + b * (share * angle).sin();
            let latitude = point.z.atan2(point.x.hypot(point.y)).to_degrees();
            [point.y.atan2(point.x).to_degrees(), latitude]
        };
        let longitude = nearest_turn(previous[0], place[0]);
        if place[1].abs() > 88.0 || (longitude - previous[0]).abs() > 60.0 {
            return None;
        }
        previous = [longitude, place[1]];
        path.push(previous);
    }
    let steps = &path[path.len() - 1 - ARC_STEPS as usize..];
    let (first, last) = (steps[0], steps[steps.len() - 1]);
    let radius_m = body.equatorial_radius_m();
    let bow_deg = steps
        .iter()
        .map(|step| distance_to_edge(*step, first, last))
        .fold(0.0, f64::max);
    let length_deg = (last[0] - first[0]).hypot(last[1] - first[1]);
    Some(bow_deg.to_radians() * length_deg.to_radians() * radius_m * radius_m)
}

/// `longitude` in the turn in which it is closest to `from`.
fn nearest_turn(from: f64, longitude: f64) -> f64 {
    longitude + 360.0 * ((from - longitude) / 360.0).round()
}

fn unit([longitude_deg, latitude_deg]: Degrees) -> glam::DVec3 {
    Ellipsoid::UNIT_SPHERE
        .geodetic_surface_normal(longitude_deg.to_radians(), latitude_deg.to_radians())
}

/// Either winding means the same.
///
/// # Errors
/// The find, in words.
pub fn compare_with_reversed(
    case: &Case,
    outcome: &Result<RegionMesh, MeshError>,
    reached: &mut Reached,
) -> Result<(), String> {
    let mut reversed = case.clone();
    for ring in reversed.polygons.iter_mut().flatten() {
        ring.reverse();
    }
    if case.repair {
        // Where two edges cross is rounded differently from either side.
        return Ok(());
    }
    reached.hit("reversed_compared");
    compare("reversed", &reversed, outcome)
}

/// One turn further east is the same place, as long as no bit is lost on the way.
fn compare_with_turned(
    case: &Case,
    outcome: &Result<RegionMesh, MeshError>,
    reached: &mut Reached,
) -> Result<(), String> {
    let mut turned = case.clone();
    for vertex in turned.polygons.iter_mut().flatten().flatten() {
        let east = vertex[0] + 360.0;
        let exact = east - 360.0 == vertex[0] && vertex[0] * 1_048_576.0 % 1.0 == 0.0;
        if !exact || east > 540.0 {
            return Ok(());
        }
        vertex[0] = east;
    }
    if case.repair {
        return Ok(());
    }
    reached.hit("turned_compared");
    compare("one turn further east", &turned, outcome)
}

fn compare(
    what: &str,
    other: &Case,
    outcome: &Result<RegionMesh, MeshError>,
) -> Result<(), String> {
    let Some(region) = read(&other.polygons) else {
        return Err(format!("{what} it cannot be read"));
    };
    let again = RegionMesh::build(&region, &other.body, other.rule, &other.options);
    let slack_m2 = rounding_m2(other, &planar_paths(&region));
    match (outcome, &again) {
        (Ok(mesh), Ok(again)) => {
            let difference = (mesh.area_m2 - again.area_m2).abs();
            if difference > 1e-12 * mesh.area_m2 + slack_m2 {
                return Err(format!(
                    "{what} the area is {} m² instead of {} m²",
                    again.area_m2, mesh.area_m2
                ));
            }
            Ok(())
        }
        (Err(error), Err(again))
            if std::mem::discriminant(error) == std::mem::discriminant(again) =>
        {
            Ok(())
        }
        // Of what is a rounding wide nothing may be left in either direction.
        (Ok(mesh), Err(MeshError::NoArea { .. })) | (Err(MeshError::NoArea { .. }), Ok(mesh))
            if other.rule == EdgeRule::GreatEllipse && mesh.area_m2 <= slack_m2 =>
        {
            Ok(())
        }
        // Whether arcs a rounding apart cross or overlap is not decided exactly.
        (Err(MeshError::SelfCrossing { .. } | MeshError::Overlap { .. }), _)
        | (_, Err(MeshError::SelfCrossing { .. } | MeshError::Overlap { .. }))
            if other.rule == EdgeRule::GreatEllipse =>
        {
            Ok(())
        }
        _ => {
            let told = |outcome: &Result<RegionMesh, MeshError>| match outcome {
                Ok(mesh) => format!("{} m²", mesh.area_m2),
                Err(error) => error.to_string(),
            };
            Err(format!(
                "{what}: {}; as it is: {}",
                told(&again),
                told(outcome)
            ))
        }
    }
}

// ---- drawing ----------------------------------------------------------------------------------

/// Degrees between grid lines.
const GRIDS_DEG: [f64; 12] = [
    10.0, 1.0, 30.0, 0.1, 45.0, 0.125, 1e-3, 1e-5, 1e-7, 1e-9, 5.0, 0.3,
];
const LONGITUDES_DEG: [f64; 12] = [
    0.0,
    10.25,
    180.0,
    -180.0,
    179.9,
    -179.95,
    90.0,
    200.0,
    -77.041_235_015,
    359.5,
    -530.0,
    0.1,
];
const LATITUDES_DEG: [f64; 12] = [
    0.0,
    45.0,
    90.0,
    -90.0,
    89.0,
    -89.999,
    60.1,
    -33.0,
    38.789_544_853,
    85.0,
    -1e-9,
    0.1,
];

struct Drawing<'a, 'b> {
    bytes: &'a mut Bytes<'b>,
    grid_deg: f64,
    anchor: Degrees,
    polygons: Vec<Vec<Vec<Degrees>>>,
    vertices: usize,
}

/// Bytes → case.
pub fn decode(bytes: &mut Bytes<'_>) -> Case {
    let body = bytes.choose(&Ellipsoid::ALL);
    let rule = bytes.choose(&[EdgeRule::Planar, EdgeRule::Planar, EdgeRule::GreatEllipse]);
    let flags = bytes.byte();
    let (tolerance_choice, step_choice) = (bytes.below(10), bytes.below(9));
    let mut drawing = Drawing {
        grid_deg: bytes.choose(&GRIDS_DEG),
        anchor: [bytes.choose(&LONGITUDES_DEG), bytes.choose(&LATITUDES_DEG)],
        bytes,
        polygons: Vec::new(),
        vertices: 0,
    };
    drawing.draw();
    let polygons = drawing.polygons;
    let options = options(&body, &polygons, tolerance_choice, step_choice);
    Case {
        polygons,
        body,
        rule,
        options,
        repair: flags & 1 == 1,
    }
}

/// Options in proportion to the shape: fine enough to subdivide it, never so fine that one input
/// takes seconds; and some that cannot be meshed with.
fn options(
    body: &Ellipsoid,
    polygons: &[Vec<Vec<Degrees>>],
    tolerance_choice: usize,
    step_choice: usize,
) -> MeshOptions {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for vertex in polygons.iter().flatten().flatten() {
        for k in 0..2 {
            low[k] = low[k].min(vertex[k]);
            high[k] = high[k].max(vertex[k]);
        }
    }
    let size_deg = (high[0] - low[0]).max(high[1] - low[1]).clamp(1e-12, 360.0);
    let length_deg: f64 = polygons
        .iter()
        .flatten()
        .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)))
        .map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]))
        .sum();
    let size_m = size_deg.to_radians() * body.equatorial_radius_m();
    let boundary_tolerance_m = match tolerance_choice {
        0 => 1e-3 * size_m,
        1 => 1e-4 * size_m,
        2 => 0.1 * size_m,
        3 => 100.0 * size_m,
        4 => 1e9,
        5 => 1e-2 * size_m,
        6 => 1e-5 * size_m,
        7 => 1e-6 * body.equatorial_radius_m(),
        8 => 1.0,
        _ => 0.0,
    };
    let boundary_tolerance_m = if boundary_tolerance_m == 0.0 {
        0.0
    } else {
        // A chord of L deviates by L² / 8R: this leaves some thousand of them altogether.
        let chord_rad = length_deg.to_radians() / 2500.0;
        let smallest_m = 0.125 * body.equatorial_radius_m() * chord_rad * chord_rad;
        boundary_tolerance_m.max(smallest_m)
    };
    let cap_step_deg = match step_choice {
        0 => 30.0,
        1 => 3.0,
        2 => size_deg / 4.0,
        3 => size_deg / 12.0,
        4 => size_deg * 0.7,
        5 => 7.0,
        6 => size_deg / 9.1,
        7 => 0.01_f64.max(size_deg / 18.0),
        _ => f64::NAN,
    };
    MeshOptions {
        boundary_tolerance_m,
        cap_step_deg: if cap_step_deg.is_nan() {
            0.001
        } else {
            cap_step_deg.clamp(0.01, 30.0)
        },
    }
}

impl Drawing<'_, '_> {
    fn draw(&mut self) {
        for _ in 0..6 {
            let as_hole = self.bytes.below(3) > 0;
            let ring = match self.bytes.below(10) {
                0 | 1 => self.free(),
                2 => self.star(),
                3 => self.rectangle(),
                4 => self.moved_copy(),
                5 => self.inscribed(),
                6 => self.band(),
                7 => self.comb(),
                8 => self.up_to_pole(),
                _ => self.needle(),
            };
            self.vertices += ring.len();
            match self.polygons.last_mut() {
                Some(polygon) if as_hole => polygon.push(ring),
                _ => self.polygons.push(vec![ring]),
            }
            if self.bytes.is_exhausted() || self.vertices > MAX_VERTICES {
                break;
            }
        }
    }

    fn place(&self, x: f64, y: f64) -> Degrees {
        within([
            self.anchor[0] + x * self.grid_deg,
            self.anchor[1] + y * self.grid_deg,
        ])
    }

    /// −8 … 7 in both directions, one byte.
    fn steps(&mut self) -> [f64; 2] {
        let byte = self.bytes.byte();
        [f64::from(byte >> 4) - 8.0, f64::from(byte & 15) - 8.0]
    }

    fn free(&mut self) -> Vec<Degrees> {
        let count = 3 + self.bytes.below(12);
        let mut ring: Vec<Degrees> = Vec::with_capacity(count);
        for _ in 0..count {
            let vertex = self.vertex(&ring);
            ring.push(vertex);
        }
        ring
    }

    fn vertex(&mut self, ring: &[Degrees]) -> Degrees {
        match self.bytes.below(8) {
            0..=3 => {
                let [x, y] = self.steps();
                self.place(x, y)
            }
            4 => self.existing(ring).0,
            5 => {
                let (a, b) = self.existing(ring);
                let share = f64::from(self.bytes.byte()) / 16.0;
                within([0, 1].map(|k| a[k] + (b[k] - a[k]) * share))
            }
            6 => {
                let (a, _) = self.existing(ring);
                let [x, y] = self.steps();
                within([beside(a[0], x), beside(a[1], y)])
            }
            _ => {
                let longitude = match self.bytes.below(4) {
                    0 => self.bytes.choose(&LONGITUDES_DEG),
                    1 => 360.0 * self.bytes.unit() - 180.0,
                    _ => self.anchor[0] + self.grid_deg * self.bytes.unit(),
                };
                let latitude = match self.bytes.below(4) {
                    0 => self.bytes.choose(&LATITUDES_DEG),
                    1 => 180.0 * self.bytes.unit() - 90.0,
                    _ => self.anchor[1] + self.grid_deg * self.bytes.unit(),
                };
                within([longitude, latitude])
            }
        }
    }

    /// A vertex drawn before, and the next one of its ring.
    fn existing(&mut self, ring: &[Degrees]) -> (Degrees, Degrees) {
        let rings: Vec<&[Degrees]> = self
            .polygons
            .iter()
            .flatten()
            .map(Vec::as_slice)
            .chain([ring])
            .filter(|ring| !ring.is_empty())
            .collect();
        if rings.is_empty() {
            return (self.anchor, self.anchor);
        }
        let from_last = self.bytes.below(rings.len());
        let ring = rings[rings.len() - 1 - from_last];
        let index = self.bytes.below(ring.len());
        (ring[index], ring[(index + 1) % ring.len()])
    }

    /// Sorted round the middle: crosses itself only by touching.
    fn star(&mut self) -> Vec<Degrees> {
        let count = 3 + self.bytes.below(14);
        let mut vertices: Vec<[f64; 2]> = (0..count).map(|_| self.steps()).collect();
        vertices.sort_by(|a, b| {
            let angle = |v: &[f64; 2]| (v[1] + 0.5).atan2(v[0] + 0.5);
            angle(a).total_cmp(&angle(b))
        });
        let scale = self.bytes.choose(&[1.0, 0.1, 0.5, 2.0]);
        let star = vertices
            .iter()
            .map(|[x, y]| self.place(x * scale, y * scale));
        star.collect()
    }

    fn rectangle(&mut self) -> Vec<Degrees> {
        let ([west, south], [east, north]) = (self.steps(), self.steps());
        [[west, south], [east, south], [east, north], [west, north]]
            .map(|[x, y]| self.place(x, y))
            .to_vec()
    }

    /// An earlier ring again, moved by grid steps, in a half or in place.
    fn moved_copy(&mut self) -> Vec<Degrees> {
        let source = self.earlier();
        let [x, y] = self.steps().map(|step| step * self.grid_deg);
        let scale = self.bytes.choose(&[1.0, 0.5, 0.25]);
        let Some(origin) = source.first().copied() else {
            return self.rectangle();
        };
        source
            .iter()
            .map(|v| {
                within([
                    origin[0] + (v[0] - origin[0]) * scale + x,
                    origin[1] + (v[1] - origin[1]) * scale + y,
                ])
            })
            .collect()
    }

    /// A hole or island that touches an earlier ring in the middle of its edges, at its vertices,
    /// or almost.
    fn inscribed(&mut self) -> Vec<Degrees> {
        let source = self.earlier();
        if source.len() < 3 {
            return self.star();
        }
        let share = self.bytes.choose(&[0.5, 0.0, 0.25, 1.0 / 3.0]);
        let every = 1 + self.bytes.below(2);
        let bits = self.steps();
        source
            .iter()
            .zip(source.iter().cycle().skip(1))
            .step_by(every)
            .map(|(a, b)| {
                let [x, y] = [0, 1].map(|k| a[k] + (b[k] - a[k]) * share);
                within([beside(x, bits[0] / 4.0), beside(y, bits[1] / 4.0)])
            })
            .collect()
    }

    fn earlier(&mut self) -> Vec<Degrees> {
        let rings: Vec<&Vec<Degrees>> = self.polygons.iter().flatten().collect();
        if rings.is_empty() {
            return Vec::new();
        }
        let from_last = self.bytes.below(rings.len());
        rings[rings.len() - 1 - from_last].clone()
    }

    /// Round the axis: uncut, as a jump between ±180, or as a zone with two edges there.
    fn band(&mut self) -> Vec<Degrees> {
        let count = 2 + self.bytes.below(5);
        let start = self.bytes.choose(&[-180.0, 0.0, -540.0, 10.25, 180.0]);
        let latitudes: Vec<f64> = (0..count).map(|_| self.steps()[1]).collect();
        let mut ring: Vec<Degrees> = latitudes
            .iter()
            .enumerate()
            .map(|(k, y)| {
                let [_, latitude] = self.place(0.0, *y);
                [start + 360.0 * k as f64 / count as f64, latitude]
            })
            .collect();
        let first = ring[0];
        match self.bytes.below(3) {
            0 => ring.push([first[0] + 360.0, first[1]]),
            1 => {
                let [_, other] = self.place(0.0, latitudes[0] + 3.0);
                ring.push([first[0] + 360.0, first[1]]);
                ring.push([first[0] + 360.0, other]);
                ring.push([first[0], other]);
            }
            _ => {
                // To a pole and back along it.
                let pole = 90_f64.copysign(self.anchor[1]);
                ring.push([first[0] + 360.0, first[1]]);
                ring.push([first[0] + 360.0, pole]);
                ring.push([first[0], pole]);
            }
        }
        ring
    }

    fn comb(&mut self) -> Vec<Degrees> {
        let teeth = 2 + self.bytes.below(7);
        let [depth, gap] = self.steps();
        let mut ring = vec![self.place(0.0, -8.0)];
        for tooth in 0..teeth {
            let x = tooth as f64 * (gap + 8.5) / 8.0;
            ring.push(self.place(x + 0.25, depth));
            ring.push(self.place(x + 0.5, -7.0));
        }
        ring.push(self.place(teeth as f64 * (gap + 8.5) / 8.0 + 1.0, -8.0));
        ring
    }

    /// Two sides that end at a pole.
    fn up_to_pole(&mut self) -> Vec<Degrees> {
        let pole = 90_f64.copysign(self.anchor[1]);
        let ([west, south], [east, _]) = (self.steps(), self.steps());
        let (a, b) = (self.place(west, south), self.place(east, south));
        match self.bytes.below(3) {
            0 => vec![a, b, [b[0], pole], [a[0], pole]],
            1 => vec![a, b, [0.5 * (a[0] + b[0]), pole]],
            _ => vec![a, b, [a[0], pole]],
        }
    }

    /// Almost no width.
    fn needle(&mut self) -> Vec<Degrees> {
        let (from, to) = (self.steps(), self.steps());
        let (a, b) = (self.place(from[0], from[1]), self.place(to[0], to[1]));
        let share = self.bytes.unit();
        let tip = [0, 1].map(|k| a[k] + (b[k] - a[k]) * share);
        let width = self.bytes.choose(&[0.0, 1e-13, 1e-10, 1e-6]) * self.grid_deg;
        vec![a, b, within([tip[0], tip[1] + width])]
    }
}

/// A few last bits away.
fn beside(value: f64, bits: f64) -> f64 {
    let mut moved = value;
    let mut left = bits.abs();
    while left >= 1.0 {
        moved = if bits > 0.0 {
            moved.next_up()
        } else {
            moved.next_down()
        };
        left -= 1.0;
    }
    moved
}

fn within([longitude, latitude]: Degrees) -> Degrees {
    [longitude.clamp(-540.0, 540.0), latitude.clamp(-90.0, 90.0)]
}
