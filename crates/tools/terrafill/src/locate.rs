// SPDX-License-Identifier: MIT OR Apache-2.0
//! `locate`: `lon,lat` in, `lon,lat,regions` out.

use crate::arguments::LocateArguments;
use crate::outcome::{Failure, Outcome, print};
use crate::regions::{Leniency, Meshed, read_and_mesh, report_skipped};
use std::path::Path;
use terrafill_core::{EdgeRule, MeshOptions, RegionMesh};
use terrafill_reference::Locator;

/// As for regions: one turn past the antimeridian is written on purpose, more is another unit.
const LARGEST_LONGITUDE_DEG: f64 = 540.0;

pub(crate) fn run(arguments: &LocateArguments) -> Result<Outcome, Failure> {
    let edges: EdgeRule = arguments.edges.into();
    // The meshes decide nothing here; making them finds the crossings that `mesh` refuses too. Edges
    // follow geodetic coordinates on every body; the areas on it say which side of a ring round a
    // pole is the smaller one.
    let (path, body, options) = (&arguments.regions, &arguments.body, MeshOptions::default());
    let leniency = Leniency {
        repair: arguments.repair,
        skip_invalid: arguments.skip_invalid,
    };
    let Meshed {
        regions,
        meshes,
        skipped,
    } = read_and_mesh(
        path,
        arguments.reading.into(),
        leniency,
        body,
        edges,
        &options,
    )?;
    let locator = Locator::new(&regions, edges, body)
        .map_err(|error| Failure::bad_input(format!("{}: {error}", path.display())))?;
    let points = read_points(&arguments.points)?;
    report_skipped(&skipped);
    report_repairs(&meshes);
    let mut text = "lon,lat,regions\n".to_owned();
    let mut undecided = 0;
    for point in points {
        let location = locator.locate(point.longitude_deg, point.latitude_deg);
        undecided += usize::from(!location.disagree.is_empty());
        let found: Vec<String> = location
            .regions
            .iter()
            .map(|&position| regions[position].index.to_string())
            .collect();
        text += &format!("{},{}\n", point.as_written, found.join(";"));
    }
    if undecided > 0 {
        eprintln!("{undecided} points lie so near a boundary that the two tests differ");
    }
    print(&text);
    Ok(Outcome::Done)
}

/// Says on standard error what a repair filled and which sides of rings round a pole were taken, a
/// line each; standard output is a table.
fn report_repairs(meshes: &[RegionMesh]) {
    for mesh in meshes {
        let number = format!("feature {}", mesh.region_index);
        let label = if mesh.name.is_empty() || mesh.name == number {
            number
        } else {
            format!("{number} ({})", mesh.name)
        };
        let is_repair = |text: &&String| text.ends_with("filled by the even-odd rule");
        for repair in mesh.warnings.iter().filter(is_repair) {
            eprintln!("repaired: {label}: {repair}");
        }
        // It names its feature and ring itself.
        let is_side = |text: &&String| text.contains("goes round a pole");
        for side in mesh.warnings.iter().filter(is_side) {
            eprintln!("warning: {side}");
        }
    }
}

struct NamedPoint {
    /// The two cells of the file, so that a script finds its own numbers again.
    as_written: String,
    longitude_deg: f64,
    latitude_deg: f64,
}

/// The points of a file, or every problem of it, a line each.
fn read_points(path: &Path) -> Result<Vec<NamedPoint>, Failure> {
    let shown = path.display();
    let fail = |what: String| Failure::bad_input(format!("{shown}: {what}"));
    if path.is_dir() {
        return Err(fail(
            "is a directory, allowed: a CSV file with columns lon and lat".to_owned(),
        ));
    }
    let bytes = std::fs::read(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => fail("no such file".to_owned()),
        _ => fail(format!("cannot be read: {error}")),
    })?;
    parse_points(&bytes).map_err(|problems| {
        let lines: Vec<String> = problems
            .iter()
            .map(|what| format!("{shown}: {what}"))
            .collect();
        Failure::bad_input(lines.join("\n"))
    })
}

fn parse_points(bytes: &[u8]) -> Result<Vec<NamedPoint>, Vec<String>> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let before = &bytes[..error.valid_up_to()];
        let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
        vec![format!("line {line}: not UTF-8")]
    })?;
    if text.trim().is_empty() {
        return Err(vec![
            "the file is empty; expected columns lon and lat".to_owned(),
        ]);
    }
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        // A short row is reported by its missing cell, like any other wrong cell.
        .flexible(true)
        .from_reader(text.as_bytes());
    let header = reader
        .headers()
        .map_err(|error| vec![error.to_string()])?
        .clone();
    let column = |name: &str| {
        let position = header.iter().position(|found| found == name);
        position.ok_or_else(|| {
            let found: Vec<&str> = header.iter().collect();
            format!("line 1: no column {name}; found: {}", found.join(", "))
        })
    };
    let columns = match (column("lon"), column("lat")) {
        (Ok(longitude), Ok(latitude)) => [longitude, latitude],
        (longitude, latitude) => {
            return Err([longitude, latitude]
                .into_iter()
                .filter_map(Result::err)
                .collect());
        }
    };
    let (mut points, mut problems) = (Vec::new(), Vec::new());
    for row in reader.records() {
        match row {
            Ok(row) => match parse_point(&row, line_of(&row, text), columns) {
                Ok(point) => points.push(point),
                Err(wrong) => problems.extend(wrong),
            },
            Err(error) => problems.push(error.to_string()),
        }
    }
    if problems.is_empty() {
        Ok(points)
    } else {
        Err(problems)
    }
}

/// Line of `text` that a row starts at, from 1. The reader's own position lies before the blank
/// lines that it skipped on the way.
fn line_of(row: &csv::StringRecord, text: &str) -> u64 {
    let Some(position) = row.position() else {
        return 0;
    };
    let before = usize::try_from(position.byte()).unwrap_or(usize::MAX);
    let ahead = text.bytes().skip(before);
    let skipped = ahead.take_while(|byte| matches!(byte, b'\n' | b'\r'));
    position.line() + skipped.filter(|byte| *byte == b'\n').count() as u64
}

/// One row, or what is wrong with its cells.
fn parse_point(
    row: &csv::StringRecord,
    line: u64,
    columns: [usize; 2],
) -> Result<NamedPoint, Vec<String>> {
    let cell = |column: usize, name: &str, limit: f64| {
        let allowed = format!("allowed: a number from -{limit} to {limit}");
        let Some(text) = row.get(column) else {
            return Err(format!("line {line}, {name}: found no cell, {allowed}"));
        };
        match text.parse::<f64>() {
            Ok(number) if number.abs() <= limit => Ok((text, number)),
            _ => Err(format!("line {line}, {name}: found {text:?}, {allowed}")),
        }
    };
    let longitude = cell(columns[0], "lon", LARGEST_LONGITUDE_DEG);
    let latitude = cell(columns[1], "lat", 90.0);
    match (longitude, latitude) {
        (Ok((longitude, longitude_deg)), Ok((latitude, latitude_deg))) => Ok(NamedPoint {
            as_written: format!("{longitude},{latitude}"),
            longitude_deg,
            latitude_deg,
        }),
        (longitude, latitude) => {
            let problems = [longitude.err(), latitude.err()];
            Err(problems.into_iter().flatten().collect())
        }
    }
}
