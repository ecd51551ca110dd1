// SPDX-License-Identifier: MIT OR Apache-2.0
//! `locate`: `lon,lat` in, `lon,lat,regions` out.

use crate::arguments::LocateArguments;
use crate::{Failure, Outcome, print};
use std::path::Path;
use terrafill_reference::Locator;
use terrafill_scene::load_regions;

pub(crate) fn run(arguments: &LocateArguments) -> Result<Outcome, Failure> {
    let regions = load_regions(&arguments.regions).map_err(Failure::bad_input)?;
    let locator = Locator::new(&regions, arguments.edges.into()).map_err(Failure::bad_input)?;
    let points = read_points(&arguments.points)?;
    let mut text = "lon,lat,regions\n".to_owned();
    let mut undecided = 0;
    for (longitude, latitude) in points {
        let parse = |value: &str| value.parse::<f64>().unwrap_or(f64::NAN);
        let location = locator.locate(parse(&longitude), parse(&latitude));
        undecided += usize::from(!location.disagree.is_empty());
        let found: Vec<String> = location
            .regions
            .iter()
            .map(|&position| regions[position].index.to_string())
            .collect();
        text += &format!("{longitude},{latitude},{}\n", found.join(";"));
    }
    if undecided > 0 {
        eprintln!("{undecided} points lie so near a boundary that the two tests differ");
    }
    print(&text);
    Ok(Outcome::Done)
}

/// The two columns as written, each checked; nothing is printed unless all are right.
fn read_points(path: &Path) -> Result<Vec<(String, String)>, Failure> {
    let shown = path.display();
    let fail = |message: String| Failure::bad_input(format!("{shown}: {message}"));
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| fail(error.to_string()))?;
    let header = reader
        .headers()
        .map_err(|error| fail(error.to_string()))?
        .clone();
    let column = |name: &str| {
        let position = header
            .iter()
            .position(|found| found.trim_start_matches('\u{feff}') == name);
        position.ok_or_else(|| {
            let found: Vec<&str> = header.iter().collect();
            fail(format!("no column {name}, found: {}", found.join(",")))
        })
    };
    let (longitude, latitude) = (column("lon")?, column("lat")?);
    let mut points = Vec::new();
    for (index, row) in reader.records().enumerate() {
        let line = index + 2;
        let row = row.map_err(|error| fail(error.to_string()))?;
        let value = |column: usize, name: &str, limit: f64| {
            let text = row.get(column).unwrap_or_default();
            match text.parse::<f64>() {
                Ok(number) if number.abs() <= limit => Ok(text.to_owned()),
                _ => Err(fail(format!(
                    "line {line}, {name}: found {text:?}, allowed: a number within ±{limit}"
                ))),
            }
        };
        points.push((
            value(longitude, "lon", 540.0)?,
            value(latitude, "lat", 90.0)?,
        ));
    }
    Ok(points)
}
