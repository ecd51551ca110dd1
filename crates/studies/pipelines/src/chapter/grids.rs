// SPDX-License-Identifier: MIT OR Apache-2.0
//! Height grids: every way of every size, and the published ratios beside ours.

use super::cells::{
    WHOLE, byte_cell, count, frame_time, gain, headings, of, paired_finding, time_cell, values,
    what_times_cover, why,
};
use super::published::{CARDS, GRIDS, GridRow};
use crate::keys::{
    API, EXPERIMENT, GRID_CELLS, PIPELINE_BAND_PX, PIPELINE_DRAWS, PIPELINE_EMITTED_VERTICES,
    PIPELINE_HELD_BYTES, PIPELINE_SENT_BYTES, PIPELINE_VERTEX_INVOCATIONS, WAY,
};
use crate::way::GRID_WAYS;
use terrafill_plot::number::{significant, times};
use terrafill_plot::{
    Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, named_aside,
};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Claim, Clock, Estimate, Finding, Heading, Picture,
    PictureFigure, Pictures, Plot, Row, Run, Table, process_medians, sample_spread,
};

/// What the published figures cannot show.
const WHAT_THEY_CANNOT_SHOW: &str = "Published figures are frames per second, one a case. The window, the camera, the vertex formats and how \
     vertices were sent are not stated, so fragments and transfers may be part of any of them. Columns 1 \
     and 3 of that table draw points, 2 and 4 triangles: only 1 with 3 and 2 with 4 draw the same. The \
     text's 14, 32 and 270 frames a second for 1000² fetched points agree with the table on the last card \
     alone.";

/// Sizes from which on the claims are read.
const LEAST_CLAIMED: u32 = 256;

/// A comparison that was published.
struct Comparison {
    claim: &'static str,
    /// Ways whose times are divided: first over second.
    ways: [&'static str; 2],
    apis: &'static [&'static str],
    says: Claim,
    published: fn(&GridRow, usize) -> Option<f64>,
}

const COMPARISONS: [Comparison; 3] = [
    Comparison {
        claim: "Fetched heights beat sent points",
        ways: ["sent-points", "fetched-points"],
        apis: &["wgpu", "vulkan"],
        says: Claim::Faster,
        published: |row, card| Some(row.fps[card][2] / row.fps[card][0]),
    },
    Comparison {
        claim: "Triangles of a geometry shader beat sent strips",
        ways: ["sent-strips", "geometry-shader"],
        apis: &["vulkan"],
        says: Claim::Faster,
        published: |row, card| (card == 2).then(|| row.geometry_fps / row.fps[card][1]),
    },
    Comparison {
        claim: "Triangles of a geometry shader cost more than fetched points, at most 0.8 of their rate",
        ways: ["fetched-points", "geometry-shader"],
        apis: &["vulkan"],
        says: Claim::LessThan(0.8),
        published: |row, card| (card == 2).then(|| row.geometry_fps / row.fps[card][2]),
    },
];

pub(super) fn section(cases: &[&Case], run: &Run) -> Result<Vec<Block>, ChapterError> {
    let clock = run.clock();
    let own = of(cases, &[(EXPERIMENT, "grid")]);
    if own.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = vec![Block::section("Height grids"), what_times_cover(clock)];
    blocks.extend(findings(&own, run).into_iter().map(Block::Finding));
    for api in ["vulkan", "wgpu"] {
        let svg = drawing(&of(&own, &[(API, api)]), clock)?;
        blocks.extend(svg.map(|svg| {
            Block::Plot(Plot {
                caption: format!(
                    "Time of a frame on {api} against the grid's points; whiskers: 5–95 % of the frames. \
                     Left out: what the interface lacks."
                ),
                svg,
            })
        }));
    }
    blocks.extend(pictures(&own));
    blocks.push(Block::Table(table(&own, clock)));
    blocks.push(Block::Table(comparisons(&own, clock)));
    blocks.push(Block::Remark(WHAT_THEY_CANNOT_SHOW.to_owned()));
    Ok(blocks)
}

/// The fastest way to draw the triangles of the largest grid on each interface, with the counters behind
/// it, and by how much each published way of triangles is slower.
pub(super) fn recommended(cases: &[&Case], clock: Clock) -> Vec<String> {
    let own = of(cases, &[(EXPERIMENT, "grid")]);
    let mut sentences = Vec::new();
    for api in ["vulkan", "wgpu"] {
        let of_triangles = of(&own, &[(API, api)]).into_iter().filter(|case| {
            let is_triangles = !case.condition(WAY).ends_with("-points");
            is_triangles && case.counts() && case.value(frame_time(clock)).is_some()
        });
        let of_triangles: Vec<&Case> = of_triangles.collect();
        let Some(&cells) = values(&of_triangles, GRID_CELLS).last() else {
            continue;
        };
        let of_largest = of(&of_triangles, &[(GRID_CELLS, &cells.to_string())]);
        let ms = |case: &&Case| case.value(frame_time(clock)).unwrap_or(f64::INFINITY);
        let Some(best) = of_largest
            .iter()
            .copied()
            .min_by(|a, b| ms(a).total_cmp(&ms(b)))
        else {
            continue;
        };
        let given = best.value(PIPELINE_EMITTED_VERTICES).map(significant);
        let mut sentence = format!(
            "On {api} the fastest way to triangles of {cells}² cells is {}: {} ms for {} vertices given",
            best.condition(WAY),
            significant(ms(&best)),
            given.unwrap_or_else(|| "–".to_owned()),
        );
        if let Some(shaded) = best.value(PIPELINE_VERTEX_INVOCATIONS) {
            let shaded = significant(shaded);
            sentence.push_str(&format!(" and {shaded} vertex shader invocations"));
        }
        for way in ["sent-strips", "geometry-shader"] {
            let other = of_largest
                .iter()
                .copied()
                .find(|case| case.condition(WAY) == way);
            let slower = other.filter(|other| other.id() != best.id());
            if let Some(slower) = gain(slower, Some(best), frame_time(clock)) {
                sentence.push_str(&format!("; {way} takes {} times as long", times(&slower)));
            }
        }
        sentence.push('.');
        sentences.push(sentence);
    }
    sentences
}

fn one<'a>(cases: &[&'a Case], api: &str, way: &str, cells: u32) -> Option<&'a Case> {
    let cells = cells.to_string();
    let conditions = [(API, api), (WAY, way), (GRID_CELLS, cells.as_str())];
    of(cases, &conditions).first().copied()
}

fn gains(
    cases: &[&Case],
    comparison: &Comparison,
    api: &str,
    clock: Clock,
) -> Vec<(u32, Estimate)> {
    let [slow, fast] = comparison.ways;
    let sizes = values(cases, GRID_CELLS);
    let of_size = |cells| {
        let [slow, fast] = [slow, fast].map(|way| one(cases, api, way, cells));
        Some((cells, gain(slow, fast, frame_time(clock))?))
    };
    sizes.into_iter().filter_map(of_size).collect()
}

fn findings(cases: &[&Case], run: &Run) -> Vec<Finding> {
    let mut findings = Vec::new();
    for comparison in &COMPARISONS {
        for api in comparison.apis {
            let sizes = values(cases, GRID_CELLS).into_iter();
            let pair = |cells| {
                let [slow, fast] = comparison.ways.map(|way| one(cases, api, way, cells));
                Some([slow?, fast?])
            };
            let claimed = sizes.filter(|cells| *cells >= LEAST_CLAIMED);
            let pairs: Vec<[&Case; 2]> = claimed.filter_map(pair).collect();
            let claim = format!("{}, on {api} (published, measured):", comparison.claim);
            findings.push(paired_finding(
                run,
                (WAY, &[]),
                (frame_time(run.clock()), WHOLE),
                &pairs,
                (claim, comparison.says),
            ));
        }
    }
    findings
}

/// Pictures of one size, those that are the same shown once with all their names.
fn pictures(cases: &[&Case]) -> Option<Block> {
    let mut figures: Vec<PictureFigure> = Vec::new();
    for case in cases.iter().filter(|case| !case.note("picture").is_empty()) {
        let kind = match case.condition(WAY).ends_with("-points") {
            true => "points",
            false => "triangles",
        };
        figures.push(PictureFigure {
            pictures: vec![Picture {
                path: case.note("picture").to_owned(),
                caption: kind.to_owned(),
            }],
            notes: vec![format!(
                "{} on {}",
                case.condition(WAY),
                case.condition(API)
            )],
        });
    }
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            caption: "What is drawn: numbers of triangles or points, cells as a chessboard, both halves of a \
                      cell in a shade of their own; wrong pixels would be red."
                .to_owned(),
            reference: String::new(),
            figures,
        })
    })
}

/// A row for each way, interface and size.
fn table(cases: &[&Case], clock: Clock) -> Table {
    let mut rows = Vec::new();
    for cells in values(cases, GRID_CELLS) {
        for way in GRID_WAYS {
            for api in ["vulkan", "wgpu"] {
                let Some(case) = one(cases, api, &way.name(), cells) else {
                    continue;
                };
                let ms = case.value(frame_time(clock)).filter(|_| case.counts());
                let points = f64::from(cells).powi(2);
                let rate = ms.map(|ms| significant(points / ms * 1e-3));
                rows.push(Row {
                    cells: vec![
                        Cell::plain(cells.to_string()),
                        Cell::name(way.name()),
                        Cell::name(api),
                        time_cell(case, frame_time(clock)),
                        Cell::or_absent(rate, why(case)),
                        byte_cell(case, PIPELINE_SENT_BYTES),
                        byte_cell(case, PIPELINE_HELD_BYTES),
                        count(case, PIPELINE_EMITTED_VERTICES),
                        count(case, PIPELINE_VERTEX_INVOCATIONS),
                        count(case, PIPELINE_DRAWS),
                        count(case, PIPELINE_BAND_PX),
                    ],
                    status: case.outcome.name().to_owned(),
                    remark: case.reason.clone(),
                });
            }
        }
    }
    Table {
        caption:
            "Every way of every grid. Points of sent and fetched points are no triangles: compare \
                  them with each other alone."
                .to_owned(),
        headings: headings(&[
            ("cells a side", None),
            ("way", None),
            ("interface", None),
            ("time, ms", Some(frame_time(clock))),
            ("million points a second", None),
            ("sent a frame", Some(PIPELINE_SENT_BYTES)),
            ("held", Some(PIPELINE_HELD_BYTES)),
            ("vertices given", Some(PIPELINE_EMITTED_VERTICES)),
            ("vertices shaded", Some(PIPELINE_VERTEX_INVOCATIONS)),
            ("draws", Some(PIPELINE_DRAWS)),
            ("pixels in the band", Some(PIPELINE_BAND_PX)),
        ]),
        rows,
        is_main: true,
        ..Table::default()
    }
}

/// The published ratios beside ours.
fn comparisons(cases: &[&Case], clock: Clock) -> Table {
    let mut rows = Vec::new();
    for comparison in &COMPARISONS {
        for cells in values(cases, GRID_CELLS) {
            let row = GRIDS.iter().find(|row| row.cells == cells);
            let published = |card| {
                let ratio = row.and_then(|row| (comparison.published)(row, card));
                let absent = match row {
                    None => "not a published size",
                    Some(_) => "this card has no geometry shaders",
                };
                Cell::or_absent(ratio.map(significant), absent)
            };
            let measured = |api: &str| {
                if !comparison.apis.contains(&api) {
                    return Cell::absent("WebGPU has no geometry shaders");
                }
                let gains = gains(cases, comparison, api, clock);
                let gain = gains.into_iter().find(|gain| gain.0 == cells);
                Cell::or_absent(gain.map(|gain| times(&gain.1)), "not measured")
            };
            let [slow, fast] = comparison.ways;
            let mut cells = vec![
                Cell::name(format!("{slow} ÷ {fast}")),
                Cell::plain(cells.to_string()),
            ];
            cells.extend((0..CARDS.len()).map(published));
            cells.extend(["vulkan", "wgpu"].map(measured));
            rows.push(Row::new(cells));
        }
    }
    let cards = CARDS.map(|card| Heading::explained(card, "published: ratio of frames per second"));
    let ours = ["vulkan", "wgpu"].map(|api| {
        Heading::explained(
            format!("here, {api}"),
            "ratio of times, with its 95 % interval",
        )
    });
    Table {
        caption: "How many times as fast the second way is as the first".to_owned(),
        headings: [
            Heading::plain("time of … ÷ time of …"),
            Heading::plain("cells a side"),
        ]
        .into_iter()
        .chain(cards)
        .chain(ours)
        .collect(),
        rows,
        ..Table::default()
    }
}

fn drawing(cases: &[&Case], clock: Clock) -> Result<Option<String>, ChapterError> {
    let metric = frame_time(clock);
    let point = |case: &&Case| {
        let cells: f64 = case.condition(GRID_CELLS).parse().ok()?;
        let spread = sample_spread(case, metric).filter(|_| case.counts())?;
        let replicates: Vec<f64> = process_medians(case, metric).into_values().collect();
        Some(Point {
            knob: cells,
            label: String::new(),
            x: Some(Reading::exact(cells * cells)),
            y: Some(Reading::sampled(spread, &replicates)),
            y_rms: None,
            standing: PointStanding::Right,
            command: String::new(),
        })
    };
    let mut curves = Vec::new();
    for way in GRID_WAYS {
        let own = of(cases, &[(WAY, &way.name())]);
        let mut points: Vec<Point> = own.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.knob.total_cmp(&b.knob));
        if !points.is_empty() {
            curves.push(Curve {
                name: way.name(),
                points,
            });
        }
    }
    let names: Vec<String> = curves.iter().map(|curve| curve.name.clone()).collect();
    let palette = Palette::new(names.clone());
    let plot = WorkPrecision {
        title: "Time of a frame against points",
        across: "points of the grid",
        up: clock.pick(
            "wall clock, ms: median, 5–95 %",
            "process CPU, ms: median, 5–95 %",
        ),
        upwards: Upwards::Amount,
        curves,
        lines: Vec::new(),
    };
    Ok(named_aside(
        "time of a frame against points",
        &plot,
        &names,
        &palette,
    )?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Run, RunEnvironment};

    /// Milliseconds by GPU, wall and process CPU.
    fn run_of(device_type: &str, figures: &[(&str, [f64; 3])]) -> Run {
        let mut made = MadeUpRun {
            environment: RunEnvironment {
                device_type: device_type.to_owned(),
                gpu_timestamps: true,
                ..RunEnvironment::default()
            },
            ..MadeUpRun::default()
        };
        for (way, [gpu, wall, cpu]) in figures {
            let conditions = [
                ("experiment", "grid"),
                ("api", "wgpu"),
                ("way", *way),
                ("grid_cells", "256"),
            ];
            let case = made.case(case_id(crate::STUDY, way, &conditions));
            case.timed("pipeline_gpu_ms", &[*gpu]);
            case.timed("pipeline_wall_ms", &[*wall]);
            case.timed("pipeline_cpu_ms", &[*cpu]);
        }
        let folder = tempfile::tempdir().expect("a folder");
        made.write(folder.path()).expect("a run")
    }

    #[test]
    fn what_is_sent_each_frame_is_ranked_by_a_clock_that_covers_it() {
        let figures = |sent_wall, sent_cpu| {
            [
                ("sent-strips", [0.1, sent_wall, sent_cpu]),
                ("no-vertex-buffer", [0.2, 0.4, 0.5]),
            ]
        };
        let fastest = |device_type, sent_wall, sent_cpu| {
            let run = run_of(device_type, &figures(sent_wall, sent_cpu));
            let cases: Vec<&Case> = run.cases.iter().collect();
            let said = recommended(&cases, run.clock()).join(" ");
            let page = section(&cases, &run).expect("a section");
            let by = run.clock().pick("wall clock", "process CPU time");
            let says = |block: &Block| matches!(block, Block::Remark(text) if text.contains(by));
            assert!(page.iter().any(says), "{by}");
            said.contains("256² cells is sent-strips")
        };
        // Its GPU time is the least: the upload is outside of it.
        assert!(!fastest("discrete-gpu", 0.6, 0.3));
        // Negative controls: where the whole frame is faster it is named, by each device's own clock.
        assert!(fastest("discrete-gpu", 0.3, 0.6));
        assert!(!fastest("cpu", 0.3, 0.6));
        assert!(fastest("cpu", 0.6, 0.3));
    }
}
