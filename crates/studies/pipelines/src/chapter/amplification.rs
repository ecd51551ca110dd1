// SPDX-License-Identifier: MIT OR Apache-2.0
//! Amplification: bytes and time of grids whose cells a geometry shader makes of fewer and fewer points.

use super::cells::{
    WHOLE, byte_cell, count, frame_time, gain, headings, of, paired_finding, time_cell, values,
    what_times_cover, why,
};
use super::published::AMPLIFICATION;
use crate::keys::{
    CELLS_PER_POINT, EXPERIMENT, GRID_CELLS, PIPELINE_EMITTED_VERTICES,
    PIPELINE_GEOMETRY_INVOCATIONS, PIPELINE_PRIMITIVES, PIPELINE_SENT_BYTES, SOURCE, STRIP,
};
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Block, Case, Cell, Claim, Clock, Estimate, Finding, Heading, Row, Run, Standing, Table,
};

/// What the published table says, and what it does not.
const WHAT_THEY_CANNOT_SHOW: &str = "The published table counts k × k generated vertices for a point, which is read here as (k/2)² cells of four \
     vertices: it is the one reading under which all its rows draw the same triangles and none exceeds \
     the driver's 128 vertices. Its text says that generating geometry saves bandwidth; its figures say \
     that 4 and 16 times fewer points took 2.2 and 8.5 to 9.7 times as long. Points are sent as 4-byte \
     numbers here.";

pub(super) fn section(cases: &[&Case], run: &Run) -> Vec<Block> {
    let clock = run.clock();
    let own = of(cases, &[(EXPERIMENT, "amplify")]);
    if own.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![Block::section("Amplification"), what_times_cover(clock)];
    blocks.extend(findings(&own, run).into_iter().map(Block::Finding));
    blocks.push(Block::Table(table(&own, clock)));
    blocks.push(Block::Remark(WHAT_THEY_CANNOT_SHOW.to_owned()));
    blocks
}

/// How many cells a point should make, by the largest grid.
pub(super) fn recommended(cases: &[&Case], clock: Clock) -> Option<String> {
    let own = of(cases, &[(EXPERIMENT, "amplify"), (SOURCE, "stored")]);
    let measured = own
        .into_iter()
        .filter(|case| case.counts() && case.value(frame_time(clock)).is_some());
    let measured: Vec<&Case> = measured.collect();
    let cells = values(&measured, GRID_CELLS).last()?.to_string();
    let of_largest = of(&measured, &[(GRID_CELLS, &cells)]);
    let ms = |case: &&Case| case.value(frame_time(clock)).unwrap_or(f64::INFINITY);
    let best = of_largest
        .iter()
        .copied()
        .min_by(|a, b| ms(a).total_cmp(&ms(b)))?;
    let given = best.value(PIPELINE_EMITTED_VERTICES).map(significant);
    Some(format!(
        "Geometry shaders make {cells}² cells of stored points fastest with {} cells a point in strips of a \
         {}: {} ms for {} vertices given.",
        best.condition(CELLS_PER_POINT),
        best.condition(STRIP),
        significant(ms(&best)),
        given.unwrap_or_else(|| "–".to_owned()),
    ))
}

fn one<'a>(
    cases: &[&'a Case],
    cells: u32,
    per_point: u32,
    strip: &str,
    source: &str,
) -> Option<&'a Case> {
    let (cells, per_point) = (cells.to_string(), per_point.to_string());
    let conditions = [
        (GRID_CELLS, cells.as_str()),
        (CELLS_PER_POINT, per_point.as_str()),
        (STRIP, strip),
        (SOURCE, source),
    ];
    of(cases, &conditions).first().copied()
}

/// That bytes fall as points do.
pub(super) fn bytes_finding(cases: &[&Case]) -> Option<Finding> {
    let own = of(cases, &[(EXPERIMENT, "amplify")]);
    let mut falls = Vec::new();
    for cells in values(&own, GRID_CELLS) {
        for (per_point, expected) in [(4, 4.0), (16, 16.0)] {
            let bytes = |per_point| {
                let case = one(&own, cells, per_point, "cell", "sent")?;
                case.value(PIPELINE_SENT_BYTES)
            };
            let fall: Option<f64> = bytes(1).zip(bytes(per_point)).map(|(all, few)| all / few);
            falls.extend(fall.map(|fall| (fall, expected)));
        }
    }
    if own.is_empty() {
        return None;
    }
    let is_right = |(fall, expected): &(f64, f64)| (fall - expected).abs() < 1e-9;
    Some(Finding {
        claim: "Generating 4 and 16 cells of a point sends a quarter and a sixteenth of the bytes:"
            .to_owned(),
        standing: match falls.is_empty() {
            true => Standing::NotMeasured,
            false => Standing::holds_if(falls.iter().all(is_right)),
        },
        because: falls
            .iter()
            .map(|(fall, _)| format!("÷ {}", significant(*fall)))
            .collect::<Vec<_>>()
            .join(", "),
    })
}

/// How many times as long a frame takes as with a cell a point.
fn slowdown(
    cases: &[&Case],
    [cells, per_point]: [u32; 2],
    strip: &str,
    source: &str,
    clock: Clock,
) -> Option<Estimate> {
    let case = one(cases, cells, per_point, strip, source);
    gain(
        case,
        one(cases, cells, 1, "cell", source),
        frame_time(clock),
    )
}

fn findings(cases: &[&Case], run: &Run) -> Vec<Finding> {
    let sizes = values(cases, GRID_CELLS);
    // How much faster than a cell a point: below 1 where it is slower.
    let pairs = |per_point: u32| -> Vec<[&Case; 2]> {
        let of_size = |cells: &u32| {
            ["sent", "stored"].map(|source| {
                let [slow, fast] = [1, per_point].map(|of| one(cases, *cells, of, "cell", source));
                Some([slow?, fast?])
            })
        };
        sizes.iter().flat_map(of_size).flatten().collect()
    };
    let of_points = |per_point| {
        let published: Vec<String> = AMPLIFICATION
            .iter()
            .flat_map(|row| {
                ["sent", "stored"].map(|source| published(row.cells, per_point, source))
            })
            .flatten()
            .map(|slower| significant(1.0 / slower))
            .collect();
        let published = published.join("; ");
        let claim = format!(
            "A frame of {per_point} cells a point is faster than one of a cell a point (implied; the published \
             table says slower, {published} times as fast):"
        );
        paired_finding(
            run,
            (CELLS_PER_POINT, &[]),
            (frame_time(run.clock()), WHOLE),
            &pairs(per_point),
            (claim, Claim::Faster),
        )
    };
    [4, 16].into_iter().map(of_points).collect()
}

fn published(cells: u32, per_point: u32, source: &str) -> Option<f64> {
    let row = AMPLIFICATION.iter().find(|row| row.cells == cells)?;
    let fps = match source {
        "sent" => row.sent_fps,
        _ => row.stored_fps,
    };
    let column = [1, 4, 16].iter().position(|known| *known == per_point)?;
    Some(fps[0] / fps[column])
}

fn table(cases: &[&Case], clock: Clock) -> Table {
    let mut rows = Vec::new();
    for cells in values(cases, GRID_CELLS) {
        for source in ["sent", "stored"] {
            for per_point in values(cases, CELLS_PER_POINT) {
                for strip in ["cell", "row"] {
                    let Some(case) = one(cases, cells, per_point, strip, source) else {
                        continue;
                    };
                    let slowdown = slowdown(cases, [cells, per_point], strip, source, clock);
                    let published = match strip {
                        "cell" => published(cells, per_point, source),
                        _ => None,
                    };
                    rows.push(Row {
                        cells: vec![
                            Cell::plain(cells.to_string()),
                            Cell::name(source),
                            Cell::plain(per_point.to_string()),
                            Cell::name(strip),
                            byte_cell(case, PIPELINE_SENT_BYTES),
                            time_cell(case, frame_time(clock)),
                            Cell::or_absent(slowdown.as_ref().map(times), why(case)),
                            Cell::or_absent(published.map(significant), "not published"),
                            count(case, PIPELINE_EMITTED_VERTICES),
                            count(case, PIPELINE_GEOMETRY_INVOCATIONS),
                            count(case, PIPELINE_PRIMITIVES),
                        ],
                        status: case.outcome.name().to_owned(),
                        remark: case.reason.clone(),
                    });
                }
            }
        }
    }
    let mut headings = headings(&[
        ("cells a side", None),
        ("points", None),
        ("cells a point", None),
        ("strip", None),
        ("sent a frame", Some(PIPELINE_SENT_BYTES)),
        ("time, ms", Some(frame_time(clock))),
        ("time ÷ that of a cell a point", None),
        ("the same, published", None),
        ("vertices given", Some(PIPELINE_EMITTED_VERTICES)),
        ("geometry invocations", Some(PIPELINE_GEOMETRY_INVOCATIONS)),
        ("primitives", Some(PIPELINE_PRIMITIVES)),
    ]);
    headings[6] = Heading::explained("time ÷ that of a cell a point", "with its 95 % interval");
    headings[7] = Heading::explained(
        "the same, published",
        "ratio of frames per second, 8800 GTX",
    );
    Table {
        caption: "The same triangles by fewer and fewer points: bytes and time".to_owned(),
        headings,
        rows,
        is_main: true,
        ..Table::default()
    }
}
