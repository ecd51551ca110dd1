// SPDX-License-Identifier: MIT OR Apache-2.0
//! `locate`: a table with `lon` and `lat` in, the same table with the regions that hold each point out.

use crate::arguments::LocateArguments;
use crate::input::{is_standard, read_standard_input, shown};
use crate::outcome::{Failure, Outcome, complain, print};
use crate::regions::{
    Leniency, Meshed, read_and_mesh, report_regions, report_skipped, report_warnings,
};
use std::io::IsTerminal as _;
use std::path::Path;
use terrafill_core::{EdgeRule, MeshOptions, WarningSubject, printable, wide_encoding};
use terrafill_reference::Locator;

/// As for regions: one turn past the antimeridian is written on purpose, more is another unit.
const LARGEST_LONGITUDE_DEG: f64 = 540.0;

/// Column of the regions' indices.
const REGIONS: &str = "regions";
/// Column of their names.
const NAMES: &str = "names";

pub(crate) fn run(arguments: &LocateArguments) -> Result<Outcome, Failure> {
    if is_standard(&arguments.regions) && is_standard(&arguments.points) {
        return Err(Failure::bad_input(
            "--points: found - for both inputs, allowed: standard input for one of them",
        ));
    }
    for warning in arguments.unused.warnings() {
        complain(warning);
    }
    let edges: EdgeRule = arguments.edges.into();
    // The meshes decide nothing here; making them finds the crossings that `mesh` refuses too. Edges
    // follow geodetic coordinates on every body; the areas on it say which side of a ring round a
    // pole is the smaller one.
    let (path, body, options) = (&arguments.regions, &arguments.body, MeshOptions::default());
    let leniency = Leniency {
        repair: arguments.repair.map(Into::into),
        skip_invalid: arguments.skip_invalid,
    };
    let Meshed {
        regions,
        meshes,
        skipped,
        warnings,
    } = read_and_mesh(
        path,
        arguments.reading.into(),
        leniency,
        body,
        edges,
        &options,
    )?;
    let locator = Locator::new(&regions, edges, body)
        .map_err(|error| Failure::bad_input(format!("{}: {error}", shown(path))))?;
    let added = if arguments.names {
        &[REGIONS, NAMES][..]
    } else {
        &[REGIONS]
    };
    let points = read_points(&arguments.points, added)?;
    report_warnings(path, &warnings);
    report_skipped(&skipped);
    report_regions(&meshes, &[WarningSubject::Repair, WarningSubject::Inside]);
    let mut undecided = 0;
    let mut rows = vec![points.header];
    rows[0].extend(added.iter().map(ToString::to_string));
    for point in points.rows {
        let location = locator.locate(point.longitude_deg, point.latitude_deg);
        undecided += usize::from(!location.disagree.is_empty());
        let found = || location.regions.iter().map(|&position| &regions[position]);
        let mut row = point.cells;
        row.push(joined(found().map(|region| region.index.to_string())));
        if arguments.names {
            row.push(joined(found().map(|region| region.name.clone())));
        }
        rows.push(row);
    }
    if undecided > 0 {
        complain(format!(
            "{undecided} points lie so near a boundary that the two tests differ"
        ));
    }
    print(table(&rows, std::io::stdout().is_terminal())?)?;
    Ok(Outcome::Done)
}

fn joined(texts: impl Iterator<Item = String>) -> String {
    texts.collect::<Vec<String>>().join(";")
}

/// Rows as CSV.
///
/// - `is_terminal`: control characters are written out, which a file keeps as they are
fn table(rows: &[Vec<String>], is_terminal: bool) -> Result<Vec<u8>, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        let written = if is_terminal {
            writer.write_record(row.iter().map(|cell| printable(cell).into_owned()))
        } else {
            writer.write_record(row)
        };
        written.map_err(Failure::bad_input)?;
    }
    writer.into_inner().map_err(Failure::bad_input)
}

/// A table of points as its file has it.
struct Points {
    header: Vec<String>,
    rows: Vec<Point>,
}

struct Point {
    /// Every cell as it stands in the file, so that a script finds its own columns again.
    cells: Vec<String>,
    longitude_deg: f64,
    latitude_deg: f64,
}

/// The points of a file, or every problem of it, a line each.
///
/// - `added`: columns that the file may not have, since they are going to be added
fn read_points(path: &Path, added: &[&str]) -> Result<Points, Failure> {
    let shown = shown(path);
    let fail = |what: String| Failure::bad_input(format!("{shown}: {what}"));
    if path.is_dir() {
        return Err(fail(
            "is a directory, allowed: a CSV file with columns lon and lat".to_owned(),
        ));
    }
    let bytes = if is_standard(path) {
        read_standard_input()?
    } else {
        std::fs::read(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => fail("no such file".to_owned()),
            _ => fail(format!("cannot be read: {error}")),
        })?
    };
    parse_points(&bytes, added).map_err(|problems| {
        let lines: Vec<String> = problems
            .iter()
            .map(|what| format!("{shown}: {what}"))
            .collect();
        Failure::bad_input(lines.join("\n"))
    })
}

fn parse_points(bytes: &[u8], added: &[&str]) -> Result<Points, Vec<String>> {
    if let Some(found) = wide_encoding(bytes) {
        return Err(vec![format!("the file is {found}; expected UTF-8")]);
    }
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
        .trim(csv::Trim::Headers)
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
    let taken = added
        .iter()
        .filter(|name| header.iter().any(|found| found == **name));
    let mut problems: Vec<String> = taken
        .map(|name| format!("line 1: found a column {name}, allowed: any other name"))
        .collect();
    let columns = match (column("lon"), column("lat")) {
        (Ok(longitude), Ok(latitude)) if problems.is_empty() => [longitude, latitude],
        (longitude, latitude) => {
            problems.extend([longitude, latitude].into_iter().filter_map(Result::err));
            return Err(problems);
        }
    };
    let mut rows = Vec::new();
    for row in reader.records() {
        match row {
            Ok(row) => match parse_point(&row, line_of(&row, text), columns, header.len()) {
                Ok(point) => rows.push(point),
                Err(wrong) => problems.extend(wrong),
            },
            Err(error) => problems.push(error.to_string()),
        }
    }
    if problems.is_empty() {
        let header = header.iter().map(str::to_owned).collect();
        Ok(Points { header, rows })
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

/// One row, or what is wrong with its cells. Columns that it lacks at its end are empty.
fn parse_point(
    row: &csv::StringRecord,
    line: u64,
    columns: [usize; 2],
    width: usize,
) -> Result<Point, Vec<String>> {
    if row.len() > width {
        let found = row.len();
        return Err(vec![format!(
            "line {line}: found {found} cells, allowed: {width} as in line 1"
        )]);
    }
    let cell = |column: usize, name: &str, limit: f64| {
        let allowed = format!("allowed: a number from -{limit} to {limit}");
        let Some(text) = row.get(column).map(str::trim) else {
            return Err(format!("line {line}, {name}: found no cell, {allowed}"));
        };
        match text.parse::<f64>() {
            Ok(number) if number.abs() <= limit => Ok(number),
            _ => Err(format!("line {line}, {name}: found {text:?}, {allowed}")),
        }
    };
    let longitude = cell(columns[0], "lon", LARGEST_LONGITUDE_DEG);
    let latitude = cell(columns[1], "lat", 90.0);
    match (longitude, latitude) {
        (Ok(longitude_deg), Ok(latitude_deg)) => {
            let mut cells: Vec<String> = row.iter().map(str::to_owned).collect();
            cells.resize(width, String::new());
            Ok(Point {
                cells,
                longitude_deg,
                latitude_deg,
            })
        }
        (longitude, latitude) => {
            let problems = [longitude.err(), latitude.err()];
            Err(problems.into_iter().flatten().collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_written_out_on_a_terminal_only() {
        let rows = vec![vec!["a\u{1b}[2J".to_owned(), "b, c".to_owned()]];
        let table = |is_terminal| {
            let bytes = table(&rows, is_terminal).unwrap_or_default();
            String::from_utf8(bytes).expect("UTF-8")
        };
        assert_eq!(table(true), "a\\u{1b}[2J,\"b, c\"\n");
        assert_eq!(table(false), "a\u{1b}[2J,\"b, c\"\n");
    }
}
