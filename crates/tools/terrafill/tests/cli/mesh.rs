// SPDX-License-Identifier: MIT OR Apache-2.0
//! `mesh`: the keys of its JSON, areas against closed forms, and everything a file may look like.

use crate::harness::{BOW_TIE, Desk, collection, polygon, rectangle, techniques};
use serde_json::Value;
use std::collections::BTreeSet;
use terrafill_fixtures::data;

/// Equatorial and polar radius in metres, written down here once more.
const BODIES: [(&str, f64, f64); 6] = [
    ("wgs84", 6_378_137.0, 6_356_752.314_245),
    ("moon", 1_737_400.0, 1_737_400.0),
    ("mars", 3_396_190.0, 3_376_200.0),
    ("saturn-like", 60_268_000.0, 54_364_000.0),
    ("unit-sphere", 1.0, 1.0),
    ("asteroid-250m", 250.0, 230.0),
];

/// Area between the equator and a latitude per radian of longitude; Snyder (1987), eq. 3-12, with
/// the logarithm written as artanh.
fn zone(a: f64, b: f64, latitude_deg: f64) -> f64 {
    let s = latitude_deg.to_radians().sin();
    let e = (1.0 - (b / a).powi(2)).sqrt();
    let last = if e > 0.0 { (e * s).atanh() / e } else { s };
    b * b / 2.0 * (s / (1.0 - (e * s).powi(2)) + last)
}

fn rectangle_area(body: &str, [west, south, east, north]: [f64; 4]) -> f64 {
    let (_, a, b) = BODIES
        .into_iter()
        .find(|(name, ..)| *name == body)
        .expect("a body");
    (east - west).to_radians() * (zone(a, b, north) - zone(a, b, south))
}

#[track_caller]
fn assert_area(found: &Value, expected: f64) {
    let found = found.as_f64().expect("a number");
    let error = (found / expected - 1.0).abs();
    assert!(error < 1e-9, "{found} instead of {expected}: {error}");
}

fn mesh(desk: &Desk, arguments: &[&str]) -> Value {
    let all = [&["mesh", "--json"][..], arguments].concat();
    serde_json::from_str(&desk.run(&all).succeeded()).expect("JSON")
}

fn keys(value: &Value) -> BTreeSet<&str> {
    let object = value.as_object().expect("an object");
    object.keys().map(String::as_str).collect()
}

/// Keys that scripts rely on.
const TOP_KEYS: [&str; 8] = [
    "file",
    "edges",
    "body",
    "regions",
    "errors",
    "warnings",
    "totals",
    "elapsed_ms",
];
const REGION_KEYS: [&str; 11] = [
    "index",
    "name",
    "vertices",
    "triangles",
    "boundary_edges",
    "holes",
    "area_m2",
    "extent_deg",
    "boundary_deviation_m",
    "bytes",
    "warnings",
];
const TOTAL_KEYS: [&str; 9] = [
    "regions",
    "input_vertices",
    "vertices",
    "triangles",
    "boundary_edges",
    "holes",
    "area_m2",
    "bytes",
    "shared_bytes",
];
/// Layouts that scripts read; another technique may add its own.
const LAYOUTS: [&str; 17] = [
    "vertex/doubled",
    "vertex/separate",
    "vertex/per-triangle",
    "vertex/pulled",
    "compute/input",
    "compute/total",
    "compute/total,transform=compute",
    "instanced/instanced",
    "native/vs-control",
    "native/gs-degenerate",
    "native/gs-degenerate/list",
    "native/gs-two-edges",
    "native/gs-line",
    "native/gs-adjacency",
    "native/gs-adjacency/list",
    "native/gs-per-triangle",
    "flat-mesh/flat",
];

/// Whether every layout that was promised is there, and every other is one of a technique of the program.
fn check_layouts(found: &BTreeSet<&str>) -> Result<(), String> {
    if let Some(missing) = LAYOUTS.iter().find(|layout| !found.contains(**layout)) {
        return Err(format!("no {missing}"));
    }
    let techniques = techniques();
    let is_known = |layout: &str| {
        let technique = layout.split('/').next();
        techniques.iter().any(|own| technique == Some(own))
    };
    match found.iter().find(|layout| !is_known(layout)) {
        Some(unknown) => Err(format!("{unknown} is no technique's")),
        None => Ok(()),
    }
}

/// Whether every layout's total is the sum of the regions' bytes, none of which is 0.
fn check_bytes(json: &Value) -> Result<(), String> {
    for layout in LAYOUTS {
        let regions = json["regions"].as_array().expect("a list");
        let bytes = regions
            .iter()
            .map(|region| region["bytes"][layout].as_u64());
        let bytes: Option<Vec<u64>> = bytes.collect();
        let bytes = bytes.ok_or_else(|| format!("no {layout}"))?;
        if bytes.contains(&0) {
            return Err(format!("{layout}: a region of no bytes"));
        }
        let (total, sum) = (&json["totals"]["bytes"][layout], bytes.iter().sum::<u64>());
        if *total != sum {
            return Err(format!("{layout}: {total} instead of {sum}"));
        }
    }
    Ok(())
}

#[test]
fn the_json_has_the_promised_keys_and_no_others() {
    let desk = Desk::new();
    let squares = [
        ("one", polygon(&rectangle(0.0, 0.0, 1.0, 1.0))),
        ("two", polygon(&rectangle(5.0, 5.0, 7.0, 6.0))),
    ];
    desk.write("r.geojson", collection(&squares));
    let json = mesh(&desk, &["r.geojson"]);
    assert_eq!(keys(&json), BTreeSet::from(TOP_KEYS));
    assert_eq!(keys(&json["totals"]), BTreeSet::from(TOTAL_KEYS));
    assert_eq!(
        (&json["file"], &json["edges"], &json["body"]),
        (&"r.geojson".into(), &"planar".into(), &"wgs84".into())
    );
    assert_eq!(json["errors"], Value::Array(Vec::new()));
    assert_eq!(json["warnings"], Value::Array(Vec::new()));
    assert!(json["elapsed_ms"].as_f64() > Some(0.0));
    let regions = json["regions"].as_array().expect("a list");
    assert_eq!(regions.len(), 2);
    for (index, region) in regions.iter().enumerate() {
        assert_eq!(keys(region), BTreeSet::from(REGION_KEYS));
        assert_eq!(region["index"], index);
        assert_eq!(region["name"], squares[index].0);
        assert_eq!(check_layouts(&keys(&region["bytes"])), Ok(()));
    }
    assert_eq!(
        regions[0]["extent_deg"],
        serde_json::json!([0.0, 0.0, 1.0, 1.0])
    );
    // Totals are sums.
    for key in ["vertices", "triangles", "boundary_edges", "holes"] {
        let sum: u64 = regions
            .iter()
            .filter_map(|region| region[key].as_u64())
            .sum();
        assert_eq!(json["totals"][key], sum, "{key}");
    }
    assert_eq!(check_bytes(&json), Ok(()));
    assert_eq!(
        (
            &json["totals"]["regions"],
            &json["totals"]["input_vertices"]
        ),
        (&2.into(), &8.into())
    );
}

#[test]
fn areas_of_a_rectangle_are_exact_on_every_body() {
    let desk = Desk::new();
    let sides = [10.0, 40.0, 12.0, 41.0];
    let [west, south, east, north] = sides;
    desk.write("r.geojson", polygon(&rectangle(west, south, east, north)));
    for (body, ..) in BODIES {
        let json = mesh(&desk, &["r.geojson", "--body", body]);
        assert_eq!(json["body"], body);
        assert_area(&json["regions"][0]["area_m2"], rectangle_area(body, sides));
        assert_area(&json["totals"]["area_m2"], rectangle_area(body, sides));
    }
    // The tolerance tells the ellipsoid from the sphere of its mean radius.
    let sphere = rectangle_area("unit-sphere", sides) * 6_371_008.8_f64.powi(2);
    let error = (sphere / rectangle_area("wgs84", sides) - 1.0).abs();
    assert!(error > 1e-4, "{error}");
}

#[test]
fn a_file_may_be_written_in_many_ways_and_means_the_same() {
    let desk = Desk::new();
    let plain = polygon(&rectangle(10.0, 40.0, 12.0, 41.0));
    let mut reversed = rectangle(10.0, 40.0, 12.0, 41.0);
    reversed.reverse();
    let multi = plain
        .replace("Polygon", "MultiPolygon")
        .replace("[[[", "[[[[")
        .replace("]]]", "]]]]");
    let ways = [
        ("plain", plain.clone()),
        ("other winding", polygon(&reversed)),
        ("byte order mark", format!("\u{feff}{plain}")),
        ("CRLF", plain.replace(',', ",\r\n")),
        ("feature", collection(&[("one", plain.clone())])),
        (
            "bare feature",
            format!(r#"{{"type":"Feature","properties":null,"geometry":{plain}}}"#),
        ),
        ("multipolygon", multi),
        ("heights", plain.replace("40]", "40,8848.86]")),
        ("unclosed", plain.replace(",[10,40]]]", "]]")),
        ("repeated", plain.replace("[12,41]", "[12,41],[12,41]")),
        (
            "collinear",
            plain.replace("[12,41]", "[12,40.5],[12,41],[11,41]"),
        ),
        (
            "a turn further",
            plain.replace("[10,", "[370,").replace("[12,", "[372,"),
        ),
        (
            "collection",
            format!(
                r#"{{"type":"GeometryCollection","geometries":[
                    {{"type":"Point","coordinates":[0,0]}},{plain}]}}"#
            ),
        ),
    ];
    for (way, text) in ways {
        desk.write("r.geojson", &text);
        let json = mesh(&desk, &["r.geojson"]);
        let region = &json["regions"][0];
        assert_eq!(json["totals"]["regions"], 1, "{way}");
        assert_area(
            &region["area_m2"],
            rectangle_area("wgs84", [10.0, 40.0, 12.0, 41.0]),
        );
        let extent = serde_json::json!([10.0, 40.0, 12.0, 41.0]);
        assert_eq!(region["extent_deg"], extent, "{way}");
        let warnings = region["warnings"].as_array().expect("a list");
        let is_put_right = ["unclosed", "repeated", "collection"].contains(&way);
        assert_eq!(!warnings.is_empty(), is_put_right, "{way}: {warnings:?}");
    }
}

#[test]
fn rings_past_the_antimeridian_and_round_a_pole_are_whole() {
    let desk = Desk::new();
    for (west, east, turned) in [
        (178.0, 182.0, [178.0, -178.0]),
        (-182.0, -178.0, [178.0, -178.0]),
        (530.0, 535.0, [170.0, 175.0]),
    ] {
        let area = rectangle_area("wgs84", [west, -10.0, east, 10.0]);
        desk.write("r.geojson", polygon(&rectangle(west, -10.0, east, 10.0)));
        let region = &mesh(&desk, &["r.geojson"])["regions"][0];
        assert_area(&region["area_m2"], area);
        let extent = serde_json::json!([turned[0], -10.0, turned[1], 10.0]);
        assert_eq!(region["extent_deg"], extent);
    }
    let ring: Vec<[f64; 2]> = (0..8)
        .map(|i| [f64::from(i) * 45.0 - 180.0, 80.0])
        .collect();
    let cap = rectangle_area("wgs84", [-180.0, 80.0, 180.0, 90.0]);
    let cut = [&ring[..], &[[180.0, 80.0], [180.0, 90.0], [-180.0, 90.0]]].concat();
    // Cut along the antimeridian as RFC 7946 asks, and left uncut.
    let closed = polygon(&ring).replace(",[-180,80]]]", ",[180,80]]]");
    for text in [polygon(&cut), closed] {
        desk.write("r.geojson", &text);
        assert_area(&mesh(&desk, &["r.geojson"])["regions"][0]["area_m2"], cap);
    }
}

#[test]
fn holes_are_counted_and_cut_out() {
    let desk = Desk::new();
    let shell = polygon(&rectangle(0.0, 0.0, 6.0, 6.0));
    let with_hole = shell.replace("]]}", "],[[2,2],[4,2],[4,3],[2,3],[2,2]]]}");
    desk.write("r.geojson", with_hole);
    let region = &mesh(&desk, &["r.geojson"])["regions"][0];
    assert_eq!(region["holes"], 1);
    let area = rectangle_area("wgs84", [0.0, 0.0, 6.0, 6.0])
        - rectangle_area("wgs84", [2.0, 2.0, 4.0, 3.0]);
    assert_area(&region["area_m2"], area);
}

#[test]
fn great_ellipse_edges_bulge_towards_the_pole_by_the_closed_form() {
    let desk = Desk::new();
    let (south, north) = (40.0_f64, 50.0_f64);
    desk.write("r.geojson", polygon(&rectangle(0.0, south, 10.0, north)));
    let area = |edges: &str| {
        let arguments = ["r.geojson", "--body", "unit-sphere", "--edges", edges];
        let json = mesh(
            &desk,
            &[&arguments[..], &["--boundary-tolerance-m", "1e-6"]].concat(),
        );
        assert_eq!(json["edges"], edges);
        json["regions"][0]["area_m2"].clone()
    };
    assert_area(
        &area("planar"),
        rectangle_area("unit-sphere", [0.0, south, 10.0, north]),
    );
    // A great circle between two points of one latitude and the equator: spherical excess
    // 2 atan(tan(Δλ/2) sin φ).
    let half = 5.0_f64.to_radians().tan();
    let under = |latitude: f64| 2.0 * (half * latitude.to_radians().sin()).atan();
    assert_area(&area("great-ellipse"), under(north) - under(south));
    // On the Earth the rules differ by hundredths, not by rounding.
    let earth =
        |edges: &str| mesh(&desk, &["r.geojson", "--edges", edges])["totals"]["area_m2"].as_f64();
    let ratio = earth("great-ellipse").expect("an area") / earth("planar").expect("an area");
    assert!((1e-4..1e-2).contains(&(ratio - 1.0).abs()), "{ratio}");
}

#[test]
fn a_finer_tolerance_gives_more_edges_and_is_kept() {
    let desk = Desk::new();
    desk.write("r.geojson", polygon(&rectangle(0.0, 50.0, 40.0, 60.0)));
    let mut edges_before = 0;
    for tolerance in ["1000", "10", "0.1"] {
        let json = mesh(&desk, &["r.geojson", "--boundary-tolerance-m", tolerance]);
        let region = &json["regions"][0];
        let deviation = region["boundary_deviation_m"].as_f64();
        let limit = tolerance.parse::<f64>().ok();
        assert!(deviation > Some(0.0) && deviation <= limit, "{deviation:?}");
        let edges = region["boundary_edges"].as_u64().expect("a count");
        assert!(edges > edges_before, "{edges} at {tolerance} m");
        edges_before = edges;
    }
    let triangles = |step: &str| {
        mesh(&desk, &["r.geojson", "--cap-step-deg", step])["totals"]["triangles"].as_u64()
    };
    assert!(triangles("1") > triangles("10"));
}

#[test]
fn a_part_inside_another_is_refused_until_even_odd_is_asked_for() {
    let desk = Desk::new();
    let outer = "[[0,0],[10,0],[10,10],[0,10],[0,0]]";
    let inner = "[[2,2],[8,2],[8,8],[2,8],[2,2]]";
    let write = |name: &str, coordinates: String| {
        let text = format!(r#"{{"type":"MultiPolygon","coordinates":{coordinates}}}"#);
        desk.write(name, text);
    };
    write("nested.geojson", format!("[[{outer}],[{inner}]]"));
    let words = [
        "polygon 0 and polygon 1 overlap",
        "--repair even-odd makes it",
        "--repair union makes it",
    ];
    desk.run(&["mesh", "nested.geojson"]).refused(&[&words]);
    let json = mesh(&desk, &["nested.geojson", "--repair", "even-odd"]);
    let area = |sides| rectangle_area("wgs84", sides);
    let frame = area([0.0, 0.0, 10.0, 10.0]) - area([2.0, 2.0, 8.0, 8.0]);
    assert_area(&json["totals"]["area_m2"], frame);
    let listed = "1 overlap of parts: filled by the even-odd rule";
    assert_eq!(json["regions"][0]["warnings"][0], listed);
    // What it was, and what it has become.
    let areas = json["regions"][0]["warnings"][1].as_str().expect("areas");
    assert!(areas.starts_with("area as repaired "), "{areas}");
    for repair in ["union", "keep-shells"] {
        let json = mesh(&desk, &["nested.geojson", "--repair", repair]);
        assert_area(&json["totals"]["area_m2"], area([0.0, 0.0, 10.0, 10.0]));
    }
    // Negative control: as a hole it is right as it is.
    write("hole.geojson", format!("[[{outer},{inner}]]"));
    let json = mesh(&desk, &["hole.geojson"]);
    assert_area(&json["totals"]["area_m2"], frame);
    assert_eq!(json["regions"][0]["warnings"], serde_json::json!([]));
}

#[test]
fn crossings_are_filled_by_the_even_odd_rule_when_asked_for() {
    let desk = Desk::new();
    let right = polygon(&rectangle(8.0, 0.0, 9.0, 1.0));
    desk.write(
        "tie.geojson",
        collection(&[("tie", polygon(&BOW_TIE)), ("right", right.clone())]),
    );
    let json = mesh(&desk, &["tie.geojson", "--repair", "even-odd"]);
    let [tie, other] = [&json["regions"][0], &json["regions"][1]];
    let warning = "1 crossing of edges: filled by the even-odd rule";
    assert_eq!(tie["warnings"][0], warning);
    assert_eq!(other["warnings"], serde_json::json!([]));
    // Two triangles between the diagonals, west and east of their crossing, added up in strips of
    // longitude (midpoint rule, whose error is below 1e-9 of the area at this width).
    let (_, a, b) = BODIES[0];
    let strips = 20_000;
    let width = 1.0 / f64::from(strips);
    let sum: f64 = (0..strips)
        .map(|strip| (f64::from(strip) + 0.5) * width)
        .map(|x| (zone(a, b, x.max(1.0 - x)) - zone(a, b, x.min(1.0 - x))) * width.to_radians())
        .sum();
    let found = tie["area_m2"].as_f64().expect("an area");
    assert!((found / sum - 1.0).abs() < 1e-7, "{found} instead of {sum}");

    // Two squares of one feature that overlap: where both are, nothing is filled.
    let squares = "[[[[0,0],[2,0],[2,2],[0,2],[0,0]]],[[[1,1],[3,1],[3,3],[1,3],[1,1]]]]";
    let text = format!(r#"{{"type":"MultiPolygon","coordinates":{squares}}}"#);
    desk.write("two.geojson", text);
    let json = mesh(&desk, &["two.geojson", "--repair", "even-odd"]);
    let area = |sides| rectangle_area("wgs84", sides);
    let even_odd =
        area([0.0, 0.0, 2.0, 2.0]) + area([1.0, 1.0, 3.0, 3.0]) - 2.0 * area([1.0, 1.0, 2.0, 2.0]);
    assert_area(&json["totals"]["area_m2"], even_odd);
    // Both places where the squares cross are named.
    let crossing = |longitude| ["polygon 0", "polygon 1", longitude, "--repair even-odd"];
    let (east, west) = (
        crossing("longitude 2.0000000"),
        crossing("longitude 1.0000000"),
    );
    desk.run(&["mesh", "two.geojson"]).refused(&[&east, &west]);

    // Where nothing crosses, nothing is changed.
    desk.write("right.geojson", &right);
    let (mut with, mut without) = (
        mesh(&desk, &["right.geojson", "--repair", "even-odd"]),
        mesh(&desk, &["right.geojson"]),
    );
    for json in [&mut with, &mut without] {
        json["elapsed_ms"] = Value::Null;
    }
    assert_eq!(with, without);
}

#[test]
fn the_table_is_readable() {
    let desk = Desk::new();
    let long = "a name that goes on and on for ever and ever";
    desk.write(
        "r.geojson",
        collection(&[
            (long, polygon(&rectangle(0.0, 0.0, 1.0, 1.0))),
            ("São Tomé", polygon(&rectangle(5.0, 5.0, 7.0, 6.0))),
        ]),
    );
    let text = desk.run(&["mesh", "r.geojson"]).succeeded();
    let widths: Vec<usize> = text.lines().map(|line| line.chars().count()).collect();
    assert!(widths.iter().all(|width| *width <= 100), "{text}");
    // The heading, both rows and the sums end in one column.
    let columns: BTreeSet<usize> = widths[2..6].iter().copied().collect();
    assert_eq!(columns.len(), 1, "{text}");
    let area = rectangle_area("wgs84", [0.0, 0.0, 1.0, 1.0]) * 1e-6;
    for phrase in [
        "r.geojson · planar edges · wgs84",
        "a name that goes on and on fo… ",
        "São Tomé",
        "area km²",
        &format!("{area:.3}"),
        "2 regions",
        "8 vertices read",
        "vertex/pulled: ",
    ] {
        assert!(text.contains(phrase), "{phrase:?} is not in {text}");
    }
    let small = desk
        .run(&["mesh", "r.geojson", "--body", "unit-sphere"])
        .succeeded();
    assert!(small.contains("area m²"), "{small}");
    let area = rectangle_area("unit-sphere", [0.0, 0.0, 1.0, 1.0]);
    assert!(small.contains(&format!("{area:.6}")), "{small}");
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-10m"]
fn countries_are_all_reported_and_the_one_that_crosses_itself_is_named() {
    let [fine, coarse] = ["10m", "110m"].map(|scale| {
        let file = data::file(&format!("vectors/ne_{scale}_admin_0_countries.geojson"));
        file.display().to_string()
    });
    let desk = Desk::new();
    let json = mesh(&desk, &[&fine]);
    assert_eq!(json["totals"]["regions"], 258);
    // 148.9 million km² of land, less what the file's generalisation leaves out.
    let area = json["totals"]["area_m2"].as_f64().expect("an area");
    assert!((area / 1.48e14 - 1.0).abs() < 0.02, "{area}");
    desk.run(&["mesh", &coarse])
        .refused(&[&["(Sudan)", "longitude 33.9", "latitude 9.4"]]);
    let json = mesh(&desk, &[&coarse, "--repair", "even-odd"]);
    let changed: Vec<&Value> = json["regions"]
        .as_array()
        .expect("a list")
        .iter()
        .filter(|region| region["warnings"].to_string().contains("even-odd"))
        .map(|region| &region["name"])
        .collect();
    assert_eq!(changed, ["Sudan"]);
}

#[test]
fn invalid_features_are_skipped_only_when_asked_and_listed_then() {
    let desk = Desk::new();
    let good = polygon(&rectangle(0.0, 0.0, 1.0, 1.0));
    let crossing = polygon(&BOW_TIE);
    let beyond = polygon(&rectangle(10.0, 0.0, 11.0, 91.0));
    let features = [("bow", crossing), ("good", good), ("high", beyond)];
    desk.write("mixed.geojson", collection(&features));
    desk.write("bad.geojson", collection(&features[..1]));
    let strict = desk.run(&["mesh", "mixed.geojson", "--json"]);
    assert_eq!((strict.code, strict.stdout.as_str()), (2, ""));

    let lenient = desk.run(&["mesh", "mixed.geojson", "--json", "--skip-invalid"]);
    assert_eq!(lenient.code, 0, "{}", lenient.stderr);
    let json: Value = serde_json::from_str(&lenient.stdout).expect("JSON");
    let regions = json["regions"].as_array().expect("an array");
    let indices: Vec<_> = regions.iter().map(|region| &region["index"]).collect();
    assert_eq!(indices, [1]);
    assert_area(
        &regions[0]["area_m2"],
        rectangle_area("wgs84", [0.0, 0.0, 1.0, 1.0]),
    );
    let errors = json["errors"].as_array().expect("an array");
    let mut wrong: Vec<_> = errors
        .iter()
        .map(|error| error["feature"].as_u64())
        .collect();
    wrong.sort();
    wrong.dedup();
    assert_eq!(wrong, [Some(0), Some(2)]);
    let listed = lenient
        .stderr
        .lines()
        .filter(|line| line.starts_with("skipped: "));
    assert_eq!(listed.count(), errors.len());

    desk.write("points.csv", "lon,lat\n0.5,0.5\n10.5,0.5\n");
    let located = desk.run(&[
        "locate",
        "mixed.geojson",
        "--points",
        "points.csv",
        "--skip-invalid",
    ]);
    assert_eq!(located.stdout, "lon,lat,regions\n0.5,0.5,1\n10.5,0.5,\n");
    let nothing_left = desk.run(&["mesh", "bad.geojson", "--skip-invalid"]);
    assert_eq!((nothing_left.code, nothing_left.stdout.as_str()), (2, ""));
}

#[test]
fn a_total_that_is_no_sum_and_a_layout_that_is_missing_are_noticed() {
    let desk = Desk::new();
    desk.write("r.geojson", polygon(&rectangle(0.0, 0.0, 1.0, 1.0)));
    let json = mesh(&desk, &["r.geojson"]);
    assert_eq!(check_bytes(&json), Ok(()));
    for layout in LAYOUTS {
        let total = json["totals"]["bytes"][layout].as_u64().expect("bytes");
        let mut wrong = json.clone();
        wrong["totals"]["bytes"][layout] = (total + 1).into();
        assert!(check_bytes(&wrong).is_err(), "{layout}");
        let mut missing = json.clone();
        missing["regions"][0]["bytes"][layout] = Value::Null;
        assert!(check_bytes(&missing).is_err(), "{layout}");
        let mut found = keys(&json["regions"][0]["bytes"]);
        assert!(found.remove(layout));
        assert!(check_layouts(&found).is_err(), "{layout}");
    }
    let mut found = keys(&json["regions"][0]["bytes"]);
    found.insert("vertexes/doubled");
    assert!(check_layouts(&found).is_err(), "no technique is called so");
}

#[test]
fn bytes_follow_from_vertices_triangles_and_boundary() {
    let desk = Desk::new();
    desk.write(
        "r.geojson",
        collection(&[
            ("small", polygon(&rectangle(0.0, 0.0, 1.0, 1.0))),
            ("large", polygon(&rectangle(20.0, 0.0, 50.0, 40.0))),
        ]),
    );
    let json = mesh(&desk, &["r.geojson"]);
    let count = |region: &Value, key: &str| region[key].as_u64().expect("a count");
    let regions = json["regions"].as_array().expect("a list");
    for region in regions {
        let [v, t, e] = ["vertices", "triangles", "boundary_edges"].map(|key| count(region, key));
        assert!(2 * v < 0xffff, "16-bit indices, one loop");
        let read = 12 * v + 4 * (3 * t + e + 1).div_ceil(2);
        for (layout, expected) in [
            ("vertex/doubled", 32 * v + 2 * (6 * t + 2 * (e + 1) + 1)),
            ("vertex/separate", 24 * v + 2 * (6 * t + 2 * (e + 1) + 1)),
            ("vertex/per-triangle", 32 * v + 2 * 24 * t),
            ("compute/input", read),
            ("compute/total", read + 24 * (t + e)),
            (
                "compute/total,transform=compute",
                read + 24 * (t + e) + 32 * v,
            ),
            ("native/vs-control", 32 * v + 2 * (6 * t + 2 * (e + 1) + 1)),
            ("native/gs-degenerate/list", 12 * v + 2 * (3 * t + 3 * e)),
            ("native/gs-line", 12 * v + 2 * (3 * t + e + 2)),
            ("native/gs-adjacency/list", 12 * v + 2 * 6 * t),
            ("native/gs-per-triangle", 12 * v + 2 * 3 * t),
        ] {
            assert_eq!(count(&region["bytes"], layout), expected, "{layout}");
        }
        // Of s strips with w corners said again: t + 3s + w indices and the walls', or 2t + 5s + 2w.
        let indices = |layout| (count(&region["bytes"], layout) - 12 * v) / 2;
        let caps = indices("native/gs-degenerate") - 2 * (e + 1);
        let strips = 2 * caps - indices("native/gs-adjacency");
        assert!(
            (1..=t).contains(&strips),
            "{strips} strips of {t} triangles"
        );
        assert!(caps >= t + 3 * strips, "{caps} indices in {strips} strips");
        for technique in ["gs-degenerate", "gs-adjacency"] {
            let strip = format!("native/{technique}");
            let list = format!("{strip}/list");
            assert!(count(&region["bytes"], &strip) < count(&region["bytes"], &list));
        }
    }
    // The flags are as many as the largest region needs, whatever the others.
    let largest = regions.iter().map(|region| count(region, "vertices")).max();
    assert_eq!(
        json["totals"]["shared_bytes"],
        serde_json::json!({ "vertex/separate": 8 * largest.expect("regions") })
    );
    assert!(count(&regions[0], "vertices") < count(&regions[1], "vertices"));
}

/// Points, lines and nothing among two squares, as GIS programs write them.
fn mixed() -> String {
    collection(&[
        (
            "spring",
            r#"{"type":"Point","coordinates":[1,2]}"#.to_owned(),
        ),
        ("one", polygon(&rectangle(0.0, 0.0, 1.0, 1.0))),
        (
            "way",
            r#"{"type":"LineString","coordinates":[[0,0],[1,1]]}"#.to_owned(),
        ),
        ("unknown", "null".to_owned()),
        (
            "gathered",
            format!(
                r#"{{"type":"GeometryCollection","geometries":[{},{{"type":"Point","coordinates":[5,5]}}]}}"#,
                polygon(&rectangle(5.0, 5.0, 7.0, 6.0))
            ),
        ),
    ])
}

const LEFT_OUT: &str = "3 features without area were left out: 1 LineString, 1 Point, 1 null";

#[test]
fn what_has_no_area_is_left_out_of_a_mixed_file_and_counted() {
    let desk = Desk::new();
    desk.write("r.geojson", mixed());
    let json = mesh(&desk, &["r.geojson"]);
    assert_eq!(json["warnings"], serde_json::json!([LEFT_OUT]));
    let regions = json["regions"].as_array().expect("a list");
    let found = regions
        .iter()
        .map(|region| (&region["index"], &region["name"]));
    let expected = [(1, "one"), (4, "gathered")].map(|(index, name)| (index.into(), name.into()));
    let expected: [(Value, Value); 2] = expected;
    assert!(
        found.eq(expected.iter().map(|(index, name)| (index, name))),
        "{json}"
    );
    assert_eq!(
        regions[1]["warnings"],
        serde_json::json!(["1 geometry without area was left out"])
    );
    let table = desk.run(&["mesh", "r.geojson"]).succeeded();
    assert!(table.contains(&format!("\n{LEFT_OUT}\n")), "{table}");
    desk.write("p.csv", "lon,lat\n0.5,0.5\n6,5.5\n1,2\n");
    let ran = desk.run(&["locate", "r.geojson", "--points", "p.csv"]);
    let warning = format!("warning: r.geojson: {LEFT_OUT}\n");
    assert_eq!((ran.code, ran.stderr), (0, warning));
    assert_eq!(ran.stdout, "lon,lat,regions\n0.5,0.5,1\n6,5.5,4\n1,2,\n");
    // Another reference system is no reason to refuse, and is said.
    desk.write("crs.geojson", mixed().replacen(
        r#""features""#,
        r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::3857"}},"features""#,
        1,
    ));
    let json = mesh(&desk, &["crs.geojson"]);
    let warnings = json["warnings"].as_array().expect("a list");
    let said = warnings[1].as_str().expect("a text");
    assert!(said.starts_with("crs is \"urn:ogc:def:crs:EPSG::3857\"; coordinates are read as"));
    // Negative control: a file in which nothing has an area is refused.
    let points = mixed().replace("Polygon", "LineString");
    desk.write("points.geojson", points);
    desk.run(&["mesh", "points.geojson"]).refused(&[&[
        "points.geojson: no area: found 1 GeometryCollection of LineString, Point, 2 LineString, \
         1 Point, 1 null",
    ]]);
}

#[test]
fn a_collection_of_nothing_is_no_error() {
    let desk = Desk::new();
    desk.write("r.geojson", r#"{"type":"FeatureCollection","features":[]}"#);
    let json = mesh(&desk, &["r.geojson"]);
    assert_eq!(json["regions"], serde_json::json!([]));
    assert_eq!(
        json["warnings"],
        serde_json::json!(["the file has no features"])
    );
    assert_eq!(json["totals"]["regions"], 0);
    let table = desk.run(&["mesh", "r.geojson"]).succeeded();
    assert!(table.contains("0 regions") && table.contains("the file has no features"));
    desk.write("p.csv", "lon,lat\n0,0\n");
    let ran = desk.run(&["locate", "r.geojson", "--points", "p.csv"]);
    assert_eq!(
        (ran.code, ran.stdout.as_str()),
        (0, "lon,lat,regions\n0,0,\n")
    );
    // Negative control: a list that is missing is not one of nothing.
    desk.write("r.geojson", r#"{"type":"FeatureCollection"}"#);
    desk.run(&["mesh", "r.geojson"])
        .refused(&[&["no \"features\" in a FeatureCollection"]]);
}

#[test]
fn a_name_commands_no_terminal() {
    let desk = Desk::new();
    // ESC [2J clears a terminal's screen, as does the one character U+009B with 2J.
    let text = collection(&[
        (r"a\u001b[2J", polygon(&rectangle(0.0, 0.0, 1.0, 1.0))),
        ("b\u{9b}2J\u{7f}", polygon(&rectangle(2.0, 0.0, 3.0, 1.0))),
    ]);
    desk.write("r.geojson", &text);
    // Each run is checked for control characters by itself.
    let table = desk.run(&["mesh", "r.geojson"]).succeeded();
    assert!(table.contains(r"a\u{1b}[2J"), "{table}");
    assert!(table.contains(r"b\u{9b}2J\u{7f}"), "{table}");
    let json = mesh(&desk, &["r.geojson"]);
    assert_eq!(json["regions"][0]["name"], "a\u{1b}[2J");
    assert_eq!(json["regions"][1]["name"], "b\u{9b}2J\u{7f}");
    desk.write("wrong.geojson", text.replace("[1,1]", "[1,91]"));
    desk.run(&["mesh", "wrong.geojson"])
        .refused(&[&[r"feature 0 (a\u{1b}[2J)"]]);
}

#[test]
fn regions_are_read_from_standard_input() {
    let desk = Desk::new();
    let text = polygon(&rectangle(0.0, 0.0, 1.0, 1.0));
    desk.write("r.geojson", &text);
    let ran = desk.run_with_input(&["mesh", "-", "--json"], &text);
    let mut piped: Value = serde_json::from_str(&ran.succeeded()).expect("JSON");
    assert_eq!(piped["file"], "-");
    let mut read = mesh(&desk, &["r.geojson"]);
    for json in [&mut piped, &mut read] {
        json["elapsed_ms"] = Value::Null;
        json["file"] = Value::Null;
    }
    assert_eq!(piped, read);
    desk.run_with_input(&["mesh", "-"], "")
        .refused(&[&["standard input: the file is empty"]]);
}

#[test]
fn the_side_of_a_pole_ring_and_the_way_of_long_edges_can_be_chosen() {
    let desk = Desk::new();
    let ring = |eastward: bool, latitude: f64| {
        let mut ring = [-180.0, -60.0, 60.0, 180.0].map(|longitude| [longitude, latitude]);
        if !eastward {
            ring.reverse();
        }
        polygon(&ring)
    };
    let area = |south: f64, north: f64| rectangle_area("wgs84", [-180.0, south, 180.0, north]);
    let warnings = |region: &Value| region["warnings"].as_array().expect("a list").len();
    desk.write("east.geojson", ring(true, 60.0));
    desk.write("west.geojson", ring(false, 60.0));
    for (file, inside, [south, north], said) in [
        ("east.geojson", "smaller", [60.0, 90.0], 0),
        ("east.geojson", "left", [60.0, 90.0], 0),
        ("west.geojson", "smaller", [60.0, 90.0], 1),
        ("west.geojson", "left", [-90.0, 60.0], 1),
    ] {
        let region = &mesh(&desk, &[file, "--inside", inside])["regions"][0];
        assert_area(&region["area_m2"], area(south, north));
        assert_eq!(warnings(region), said, "{file} {inside}: {region}");
    }
    // The default is the smaller side, and `locate` says the same.
    let default = &mesh(&desk, &["west.geojson"])["regions"][0];
    assert_area(&default["area_m2"], area(60.0, 90.0));
    desk.write("points.csv", "lon,lat\n0,70\n0,-70\n");
    for (inside, expected) in [
        ("smaller", "0,70,0\n0,-70,\n"),
        ("left", "0,70,\n0,-70,0\n"),
    ] {
        let arguments = ["locate", "west.geojson", "--points", "points.csv"];
        let ran = desk.run(&[&arguments[..], &["--inside", inside]].concat());
        assert_eq!(ran.stdout, format!("lon,lat,regions\n{expected}"));
        assert!(
            ran.stderr.contains("feature 0: polygon 0, ring 0"),
            "{}",
            ran.stderr
        );
    }

    let habit = [[170.0, -5.0], [-170.0, -5.0], [-170.0, 5.0], [170.0, 5.0]];
    desk.write("habit.geojson", polygon(&habit));
    for (unwrap, width, said) in [
        ("literal", 340.0, 1),
        ("shortest", 20.0, 0),
        ("auto", 20.0, 1),
    ] {
        let region = &mesh(&desk, &["habit.geojson", "--unwrap", unwrap])["regions"][0];
        let expected = rectangle_area("wgs84", [0.0, -5.0, width, 5.0]);
        assert_area(&region["area_m2"], expected);
        assert_eq!(warnings(region), said, "{unwrap}: {region}");
    }
    // A ring round the pole that was never cut goes there and back.
    let uncut = polygon(&[[0.0, 60.0], [90.0, 60.0], [180.0, 60.0], [-90.0, 60.0]]);
    desk.write("uncut.geojson", uncut);
    desk.run(&["mesh", "uncut.geojson", "--unwrap", "literal"])
        .refused(&[&["the rings enclose no area", "--unwrap shortest takes"]]);
    for unwrap in ["shortest", "auto"] {
        let region = &mesh(&desk, &["uncut.geojson", "--unwrap", unwrap])["regions"][0];
        assert_area(&region["area_m2"], area(60.0, 90.0));
    }
}
