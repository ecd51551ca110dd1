// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bytes → GeoJSON reader.
//!
//! An input is a file as it stands, or, when its first byte is [`GRAMMAR`], choices of a grammar
//! that writes GeoJSON with whatever people and programs get wrong: numbers, nestings, member order,
//! line endings. Plain mutation of bytes rarely gets past the JSON parser; the grammar always does.

use super::bytes::Bytes;
use super::reached::Reached;
use std::borrow::Cow;
use std::fmt::Write;
use terrafill_core::{Region, RegionFileError, RegionProblemKind, Ring, parse_regions};

/// First byte of an input that is choices rather than text; no text starts with it.
pub const GRAMMAR: u8 = 1;

/// Places that a run must come to.
pub const BRANCHES: &[&str] = &[
    "raw_text",
    "grammar",
    "byte_order_mark",
    "carriage_returns",
    "read",
    "several_regions",
    "several_polygons",
    "holes",
    "ring_round_the_axis",
    "beyond_180",
    "round_trip",
    "warning_open_ring",
    "warning_repeated_position",
    "warning_long_edge",
    "warning_without_area",
    "problems_beside_readable_features",
    "several_problems",
    "empty_file",
    "json",
    "bare_list",
    "missing_type",
    "unknown_type",
    "missing_member",
    "no_features",
    "not_areal",
    "empty_coordinates",
    "wrong_nesting",
    "latitude",
    "longitude",
    "too_few_vertices",
    "many_turns",
];

/// What reading a file gives.
pub type Outcome = Result<Vec<Region>, RegionFileError>;

const FILE: &str = "fuzz.geojson";

/// Reads `input` and judges the outcome.
///
/// # Errors
/// The find, in words.
pub fn check(input: &[u8], reached: &mut Reached) -> Result<(), String> {
    reached.execution();
    reached.hit(match input.first() {
        Some(&GRAMMAR) => "grammar",
        _ => "raw_text",
    });
    let text = text_of(input);
    let outcome = parse_regions(&text, FILE);
    judge(&text, &outcome, reached)
        .map_err(|find| format!("{find}\nthe file: {}", String::from_utf8_lossy(&text)))
}

/// The file that an input stands for.
pub fn text_of(input: &[u8]) -> Cow<'_, [u8]> {
    match input.split_first() {
        Some((&GRAMMAR, choices)) => document(&mut Bytes::new(choices)).into_bytes().into(),
        _ => input.into(),
    }
}

/// Judges what reading `text` gave.
///
/// # Errors
/// The find, in words.
pub fn judge(text: &[u8], outcome: &Outcome, reached: &mut Reached) -> Result<(), String> {
    let regions = match outcome {
        Ok(regions) => {
            reached.hit("read");
            if serde_json::from_slice::<serde::de::IgnoredAny>(without_mark(text)).is_err() {
                return Err("accepted, but not JSON".to_owned());
            }
            if regions.is_empty() {
                return Err("no problem and no region".to_owned());
            }
            regions
        }
        Err(error) => {
            judge_problems(error, reached)?;
            &error.readable
        }
    };
    if regions
        .windows(2)
        .any(|pair| pair[0].index >= pair[1].index)
    {
        return Err("features out of order".to_owned());
    }
    if regions.len() > 1 {
        reached.hit("several_regions");
    }
    for region in regions {
        judge_region(region, reached)
            .map_err(|find| format!("feature {}: {find}", region.index))?;
        round_trip(region, reached).map_err(|find| format!("feature {}: {find}", region.index))?;
    }
    same_with_other_line_ends(text, outcome, reached)
}

fn judge_problems(error: &RegionFileError, reached: &mut Reached) -> Result<(), String> {
    if error.problems.is_empty() {
        return Err("refused without a problem".to_owned());
    }
    if error.problems.len() > 1 {
        reached.hit("several_problems");
    }
    if !error.readable.is_empty() {
        reached.hit("problems_beside_readable_features");
    }
    let told = error.to_string();
    if told.lines().count() < error.problems.len() || !told.starts_with(FILE) {
        return Err(format!("the message does not tell all problems: {told}"));
    }
    for problem in &error.problems {
        let blamed_and_readable = problem
            .feature
            .is_some_and(|feature| error.readable.iter().any(|region| region.index == feature));
        if blamed_and_readable {
            return Err(format!("{problem}: and yet among the readable ones"));
        }
        reached.hit(match problem.kind {
            RegionProblemKind::EmptyFile => "empty_file",
            RegionProblemKind::Json { .. } => "json",
            RegionProblemKind::BareList => "bare_list",
            RegionProblemKind::MissingType { .. } => "missing_type",
            RegionProblemKind::UnknownType { .. } => "unknown_type",
            RegionProblemKind::MissingMember { .. } => "missing_member",
            RegionProblemKind::NoFeatures => "no_features",
            RegionProblemKind::NotAreal { .. } => "not_areal",
            RegionProblemKind::EmptyCoordinates => "empty_coordinates",
            RegionProblemKind::WrongNesting { .. } => "wrong_nesting",
            RegionProblemKind::Latitude { found } if found.abs() > 90.0 => "latitude",
            RegionProblemKind::Longitude { found } if found.abs() > 540.0 => "longitude",
            RegionProblemKind::TooFewVertices { found, required } if found < required => {
                "too_few_vertices"
            }
            RegionProblemKind::ManyTurns { found } if found > 1 => "many_turns",
            ref other => return Err(format!("a value within its limits was refused: {other}")),
        });
    }
    Ok(())
}

fn judge_region(region: &Region, reached: &mut Reached) -> Result<(), String> {
    if region.polygons.is_empty() {
        return Err("a region without polygons".to_owned());
    }
    if region.polygons.len() > 1 {
        reached.hit("several_polygons");
    }
    if region
        .polygons
        .iter()
        .any(|polygon| !polygon.holes.is_empty())
    {
        reached.hit("holes");
    }
    for warning in &region.warnings {
        let known = [
            ("closed", "warning_open_ring"),
            ("dropped", "warning_repeated_position"),
            ("long way", "warning_long_edge"),
            ("without area", "warning_without_area"),
        ];
        for (words, branch) in known {
            if warning.contains(words) {
                reached.hit(branch);
            }
        }
    }
    region
        .rings()
        .try_for_each(|ring| judge_ring(ring, reached))
}

/// What [`Ring`] promises.
fn judge_ring(ring: &Ring, reached: &mut Reached) -> Result<(), String> {
    let vertices = ring.vertices_deg();
    let winding = ring.winding_deg();
    if winding != 0.0 {
        reached.hit("ring_round_the_axis");
    }
    if vertices.iter().any(|vertex| vertex[0].abs() > 180.0) {
        reached.hit("beyond_180");
    }
    if ![0.0, 360.0, -360.0].contains(&winding) {
        return Err(format!("winding {winding}"));
    }
    // One turn may be added to a ring written with a jump.
    let farthest = 540.0 + winding.abs();
    for [longitude, latitude] in vertices {
        if !(longitude.abs() <= farthest && latitude.abs() <= 90.0) {
            return Err(format!("vertex at {longitude}, {latitude}"));
        }
    }
    if let Some((start, end)) = ring.edges_deg().find(|(start, end)| start == end) {
        return Err(format!("edge from {start:?} to {end:?}"));
    }
    let mut distinct: Vec<[u64; 2]> = vertices
        .iter()
        .map(|vertex| vertex.map(f64::to_bits))
        .collect();
    distinct.sort_unstable();
    distinct.dedup();
    let required = if winding == 0.0 { 3 } else { 2 };
    if distinct.len() < required {
        return Err(format!("{} distinct vertices", distinct.len()));
    }
    Ok(())
}

/// The region written as a file again.
pub fn to_geojson(region: &Region) -> String {
    let mut polygons = Vec::new();
    for polygon in &region.polygons {
        let rings: Vec<String> = polygon.rings().map(ring_text).collect();
        polygons.push(format!("[{}]", rings.join(",")));
    }
    format!(
        r#"{{"type":"Feature","properties":{{"name":{}}},"geometry":{{"type":"MultiPolygon","coordinates":[{}]}}}}"#,
        serde_json::Value::from(region.name.as_str()),
        polygons.join(",")
    )
}

fn ring_text(ring: &Ring) -> String {
    let mut text = String::from("[");
    for [longitude, latitude] in ring.vertices_deg() {
        let _ = write!(text, "[{longitude},{latitude}],");
    }
    let [longitude, latitude] = ring.vertices_deg()[0];
    let _ = write!(text, "[{},{latitude}]]", longitude + ring.winding_deg());
    text
}

/// Region → text → region.
fn round_trip(region: &Region, reached: &mut Reached) -> Result<(), String> {
    let far = |ring: &Ring| {
        ring.edges_deg()
            .any(|(start, end)| start[0].abs().max(end[0].abs()) > 540.0)
    };
    // A ring with a jump that was shifted out of what a file may hold; and one that starts at a pole,
    // where the end one turn on is the start.
    let ambiguous =
        |ring: &Ring| ring.winding_deg() != 0.0 && ring.vertices_deg()[0][1].abs() == 90.0;
    if region.rings().any(|ring| far(ring) || ambiguous(ring)) {
        return Ok(());
    }
    let text = to_geojson(region);
    let again = parse_regions(text.as_bytes(), FILE)
        .map_err(|error| format!("{error}\nwhat it refuses is its own reading: {text}"))?;
    if again.len() != 1 || again[0].polygons != region.polygons || again[0].name != region.name {
        return Err(format!(
            "reads {again:?}\nfrom {text}\nwritten from {region:?}"
        ));
    }
    reached.hit("round_trip");
    Ok(())
}

/// A byte order mark and carriage returns change nothing but the columns in messages.
fn same_with_other_line_ends(
    text: &[u8],
    outcome: &Outcome,
    reached: &mut Reached,
) -> Result<(), String> {
    let Ok(regions) = outcome else {
        return Ok(());
    };
    if without_mark(text).len() < text.len() {
        reached.hit("byte_order_mark");
    }
    if text.windows(2).any(|pair| pair == b"\r\n") {
        reached.hit("carriage_returns");
    }
    let mut other = b"\xef\xbb\xbf".to_vec();
    for byte in without_mark(text) {
        // JSON strings hold no raw line ends, so none of these is in one.
        if *byte == b'\n' {
            other.push(b'\r');
        }
        other.push(*byte);
    }
    match parse_regions(&other, FILE) {
        Ok(again) if again == *regions => Ok(()),
        different => Err(format!("with a mark and carriage returns: {different:?}")),
    }
}

fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text)
}

/// A file by the grammar.
fn document(bytes: &mut Bytes<'_>) -> String {
    let mut text = String::new();
    if bytes.below(8) == 1 {
        text.push('\u{feff}');
    }
    let line_end = bytes.choose(&["", "\n", "\r\n", " ", "\t"]);
    let body = match bytes.below(8) {
        0..=3 => {
            let count = bytes.below(4);
            let features: Vec<String> = (0..count).map(|_| feature(bytes)).collect();
            let list = format!("[{}]", features.join(","));
            let kind = kind(bytes, "FeatureCollection");
            object(bytes, vec![kind, member(bytes_name("features"), &list)])
        }
        4 => feature(bytes),
        5 | 6 => geometry(bytes, 0),
        _ => coordinates(bytes, 0),
    };
    text.push_str(&body.replace(",\"", &format!(",{line_end}\"")));
    if bytes.below(16) == 1 {
        // Cut off in the middle of something.
        let mut end = text.len() * bytes.below(256) / 256;
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        text.truncate(end);
    }
    text.push_str(line_end);
    text
}

fn bytes_name(name: &str) -> String {
    format!("\"{name}\"")
}

fn member(name: String, value: &str) -> String {
    format!("{name}:{value}")
}

/// `"type": …`, right most of the time.
fn kind(bytes: &mut Bytes<'_>, right: &str) -> String {
    let odd = [
        "\"polygon\"",
        "null",
        "\"\"",
        "7",
        "\"Polygon\"",
        "\"Feature\"",
        "\"Point\"",
    ];
    let choice = bytes.byte();
    let value = if choice < 240 {
        bytes_name(right)
    } else {
        odd[usize::from(choice) % odd.len()].to_owned()
    };
    member(bytes_name("type"), &value)
}

/// Members in an order of their own, sometimes one missing, doubled or foreign.
fn object(bytes: &mut Bytes<'_>, mut members: Vec<String>) -> String {
    let choice = bytes.byte();
    let count = members.len();
    members.rotate_left(usize::from(choice) % count);
    match choice / 8 {
        27 => {
            members.pop();
        }
        28 => members.push(members[0].clone()),
        29 => members
            .push(r#""crs":{"type":"name","properties":{"name":"x\u00e9\ud83c"}}"#.to_owned()),
        30 => members.push(r#""bbox":[1,2,[3,{"a":null}]]"#.to_owned()),
        _ => {}
    }
    format!("{{{}}}", members.join(","))
}

fn feature(bytes: &mut Bytes<'_>) -> String {
    let geometry = match bytes.below(16) {
        1 => "null".to_owned(),
        2 => "[]".to_owned(),
        _ => geometry(bytes, 0),
    };
    let properties = bytes.choose(&[
        "{}",
        "null",
        r#"{"name":"A\n\"B\""}"#,
        r#"{"id":7,"NAME":"","name":null}"#,
        r#"{"ADMIN":{"deep":[1]},"id":1e5}"#,
        "3",
    ]);
    let kind = kind(bytes, "Feature");
    object(
        bytes,
        vec![
            kind,
            member(bytes_name("properties"), properties),
            member(bytes_name("geometry"), &geometry),
        ],
    )
}

fn geometry(bytes: &mut Bytes<'_>, depth: usize) -> String {
    match bytes.below(8) {
        0..=2 => areal(bytes, "Polygon", polygon),
        3 | 4 => areal(bytes, "MultiPolygon", |bytes| {
            let count = bytes.below(4);
            let polygons: Vec<String> = (0..count).map(|_| polygon(bytes)).collect();
            format!("[{}]", polygons.join(","))
        }),
        5 if depth < 3 => {
            let count = bytes.below(4);
            let members: Vec<String> = (0..count).map(|_| geometry(bytes, depth + 1)).collect();
            let kind = kind(bytes, "GeometryCollection");
            let list = format!("[{}]", members.join(","));
            object(bytes, vec![kind, member(bytes_name("geometries"), &list)])
        }
        6 => areal(bytes, "LineString", ring),
        _ => areal(bytes, "Point", position),
    }
}

fn areal(
    bytes: &mut Bytes<'_>,
    right: &str,
    inner: impl FnOnce(&mut Bytes<'_>) -> String,
) -> String {
    let kind = kind(bytes, right);
    let value = if bytes.below(16) == 1 {
        coordinates(bytes, 0)
    } else {
        inner(bytes)
    };
    object(bytes, vec![kind, member(bytes_name("coordinates"), &value)])
}

/// Lists of any depth.
fn coordinates(bytes: &mut Bytes<'_>, depth: usize) -> String {
    if depth == 6 || bytes.below(3) == 0 {
        return number(bytes);
    }
    let count = bytes.below(5);
    let items: Vec<String> = (0..count).map(|_| coordinates(bytes, depth + 1)).collect();
    format!("[{}]", items.join(","))
}

fn polygon(bytes: &mut Bytes<'_>) -> String {
    let count = bytes.choose(&[1, 2, 1, 3, 0]);
    let rings: Vec<String> = (0..count).map(|_| ring(bytes)).collect();
    format!("[{}]", rings.join(","))
}

fn ring(bytes: &mut Bytes<'_>) -> String {
    let (west, south) = (
        bytes.choose(&[0, 10, -180, 170, 180, -190, 350]),
        bytes.choose(&[0, 45, -90, 80, -10]),
    );
    let (east, north) = (
        west + bytes.choose(&[1, 20, 190, 360]),
        south + bytes.choose(&[1, 10]),
    );
    let mut positions: Vec<String> = match bytes.below(6) {
        0 | 1 => [[west, south], [east, south], [east, north], [west, north]]
            .map(|[x, y]| format!("[{x},{y}]"))
            .to_vec(),
        // Round the axis, uncut or with one jump or two.
        2 => [[-180, south], [-60, north], [60, south], [180, south]]
            .map(|[x, y]| format!("[{x},{y}]"))
            .to_vec(),
        3 => {
            let turns = 1 + bytes.below(3);
            let once = [[-180, south], [0, north], [180, south]];
            let all = once.repeat(turns);
            all.iter().map(|[x, y]| format!("[{x},{y}]")).collect()
        }
        _ => {
            let count = bytes.below(8);
            (0..count).map(|_| position(bytes)).collect()
        }
    };
    match bytes.below(8) {
        0..=3 => positions.extend(positions.first().cloned()),
        4 if !positions.is_empty() => {
            let repeated = bytes.below(positions.len());
            positions.insert(repeated, positions[repeated].clone());
            positions.extend(positions.first().cloned());
        }
        5 if !positions.is_empty() => {
            let replaced = bytes.below(positions.len());
            positions[replaced] = position(bytes);
        }
        _ => {}
    }
    format!("[{}]", positions.join(","))
}

fn position(bytes: &mut Bytes<'_>) -> String {
    let count = bytes.choose(&[2, 2, 2, 3, 2, 1, 4, 0]);
    let numbers: Vec<String> = (0..count).map(|_| number(bytes)).collect();
    format!("[{}]", numbers.join(","))
}

fn number(bytes: &mut Bytes<'_>) -> String {
    const ODD: [&str; 36] = [
        "-0",
        "-0.0",
        "0.0",
        "1e2",
        "-1E-3",
        "180",
        "-180",
        "180.00000000000003",
        "-179.99999999999997",
        "540",
        "540.0000000000001",
        "-540",
        "90",
        "-90",
        "90.00000000000001",
        "1e308",
        "1e999",
        "4.9e-324",
        "1e-400",
        "0.1",
        "NaN",
        "-Infinity",
        "\"7\"",
        "null",
        "true",
        "{}",
        "[]",
        "179.9999999999999999999",
        "360",
        "123456789012345678901234567890",
        "01",
        ".5",
        "1.",
        "--1",
        "-",
        "89.99999999999999",
    ];
    let choice = bytes.byte();
    if choice >= 220 {
        ODD[usize::from(choice - 220)].to_owned()
    } else if choice >= 160 {
        format!("{}", 720.0 * bytes.unit() - 360.0)
    } else {
        (i32::from(choice) - 80).to_string()
    }
}
