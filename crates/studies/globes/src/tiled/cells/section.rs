// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on frames against the number of cells, beside what was published.

use super::PART;
use super::line::{Line, line};
use crate::clock::{DRAW, FRAME, whole};
use crate::metrics::{self, *};
use std::collections::BTreeMap;
use terrafill_lab::{Cases, Column, Figure, Names, Section, Select, draw, measured, overall};
use terrafill_plot::number::{significant, times};
use terrafill_plot::{Curve, Point, PointStanding, Reading, Upwards, WorkPrecision};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Claim, Finding, Heading, Noise, Row, Standing, Table,
    over_processes, process_medians, sample_spread,
};

/// A. Jeromel, StuCoSReC 2018, p. 42: frames per second by N × N rectangles of the screen, N from 1 on.
pub(crate) const PUBLISHED_FPS: [f64; 10] = [
    452.90, 350.62, 397.89, 407.09, 405.80, 364.40, 356.11, 370.66, 382.86, 359.95,
];

/// Of these numbers of cells a frame is the unit of its curve, so that two machines stand in one picture.
const MOST_PUBLISHED: u32 = 10;
const PUBLISHED: &str = "published";
/// How tiles are drawn, and what a panel of it is called.
const WAYS: [(&str, &str); 2] = [
    ("draw-each", "a draw for each tile, as published"),
    ("array", "one draw from an array"),
];
const NO_LINE: &str = "fewer than three numbers of cells were timed";

pub(crate) const SECTION: Section<'static> = Section {
    title: "Frame time against the number of cells",
    text: "The only experiment of StuCoSReC 2018: N × N rectangles of the screen, N from 10 down to 1, and the mean time \
           of a frame. It does not state window, view, tiles or draws. Here a frame makes the grid, sends it and draws \
           it, and the device waits for no other. The tiles of a view are those that the body asks for, the same at \
           every N; triangles across ±180° are split by the CPU at ½. A line is fitted to the frame over 2 N² \
           triangles, ours by the same rule as the ten published times. Its interval is Student's, 95 %, by what the \
           points leave over. Wrong pixels \
           are counted and not judged: with coarse grids the view of the whole globe has some, whose cause is not \
           separated. There few corners also cover less of the body, so that pixels grow with N as triangles do. \
           Times of another machine stand beside ours as shares of the mean frame of N = 1 … 10.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[("view", VIEW), ("tiles", TILES), ("N", CELLS)]),
    columns: &[
        Column::metric("triangles", GLOBE_TRIANGLES),
        Column::metric("draws", GLOBE_TILE_DRAWS),
        Column::metric("tiles", GLOBE_TILE_COUNT),
        Column::metric("wrong px", GLOBE_TILE_WRONG_PX),
        Column::metric("px without a tile", GLOBE_TILE_MISSING_PX),
        FRAME,
        Column::metric("make, CPU ms", GLOBE_MAKE_CPU_MS),
        DRAW,
        Column::of(
            "published, ms",
            Figure::Computed(|case| {
                let n: usize = case.condition(CELLS).parse().ok()?;
                Some(1e3 / PUBLISHED_FPS.get(n.checked_sub(1)?)?)
            }),
        )
        .meaning("of a GeForce GTX 1060 in 2018")
        .or("published up to N = 10"),
    ],
    findings: &[as_published, in_one_draw],
    more: &[plot, lines],
    ..Section::EMPTY
};

/// Triangles and milliseconds of the published frames.
pub(crate) fn published() -> Vec<[f64; 2]> {
    let rates = (1..).zip(PUBLISHED_FPS);
    rates.map(|(n, rate)| [triangles(n), 1e3 / rate]).collect()
}

/// Two a rectangle.
fn triangles(n: u32) -> f64 {
    f64::from(2 * n * n)
}

fn cells(case: &Case) -> Option<u32> {
    case.condition(CELLS).parse().ok()
}

/// Triangles and frames of the cases that count, up to a number of cells.
fn points(cases: &Cases<'_>, most: u32) -> Vec<[f64; 2]> {
    let metric = whole(cases.clock());
    let counted = cases.iter().filter(|case| case.counts());
    let point = |case: &Case| Some((cells(case)?, measured(case, metric)?));
    let all = counted.filter_map(point).filter(|(n, _)| *n <= most);
    all.map(|(n, ms)| [triangles(n), ms]).collect()
}

/// The frame of the most cells over that of one, by the line of each process.
fn rises(cases: &Cases<'_>, most: u32) -> Option<terrafill_results::Estimate> {
    let metric = whole(cases.clock());
    let mut by_process: BTreeMap<u32, Vec<[f64; 2]>> = BTreeMap::new();
    for case in cases.iter().filter(|case| case.counts()) {
        let Some(n) = cells(case).filter(|n| *n <= most) else {
            continue;
        };
        for (process, ms) in process_medians(case, metric) {
            by_process
                .entry(process)
                .or_default()
                .push([triangles(n), ms]);
        }
    }
    let ratios = by_process.values().filter_map(|points| {
        let line = line(points)?;
        Some(line.at(triangles(most)) / line.at(triangles(1)))
    });
    over_processes(&ratios.collect::<Vec<f64>>())
}

/// Whether times rise with triangles over the published numbers of cells, in every view.
fn rising(cases: &Cases<'_>, way: &str, named: &str) -> Finding {
    let own = cases.with(&[(TILES, way)]);
    let band = Noise::band(own.noise(whole(cases.clock())));
    let views = own.by(VIEW);
    let views = views.iter().filter_map(|(view, cases)| {
        let over = rises(cases, MOST_PUBLISHED)?;
        let line = line(&points(cases, MOST_PUBLISHED))?;
        let [low, high] = line.interval.map(|slope| significant(1e3 * slope));
        let words = format!(
            "{view}: {} µs a triangle ({low} … {high}), so {} from 2 triangles to 200",
            significant(1e3 * line.slope),
            times(&over)
        );
        Some((words, Claim::Faster.standing_beyond(&over, band)))
    });
    let (words, standings): (Vec<String>, Vec<Standing>) = views.unzip();
    Finding {
        claim: format!(
            "StuCoSReC 2018: a frame takes longer with more triangles, N = 1 to 10, {named}"
        ),
        standing: overall(&standings),
        because: format!("{}. {}", words.join("; "), said_of_published()),
    }
}

fn as_published(cases: &Cases<'_>) -> Finding {
    rising(cases, WAYS[0].0, WAYS[0].1)
}

fn in_one_draw(cases: &Cases<'_>) -> Finding {
    rising(cases, WAYS[1].0, WAYS[1].1)
}

/// What the ten published times show by themselves.
fn said_of_published() -> String {
    line(&published()).map_or_else(String::new, |line| {
        let [low, high] = line.interval.map(|slope| significant(1e3 * slope));
        format!(
            "The ten published times have {} µs a triangle ({low} … {high}), p = {}; {}.",
            significant(1e3 * line.slope),
            significant(line.p),
            if line.interval[0] <= 0.0 && line.interval[1] >= 0.0 {
                "they show no effect"
            } else {
                "they show one"
            }
        )
    })
}

/// Mean frame of the published numbers of cells.
fn unit(points: &[[f64; 2]]) -> Option<f64> {
    let own = points
        .iter()
        .filter(|[x, _]| *x <= triangles(MOST_PUBLISHED));
    let own: Vec<f64> = own.map(|[_, ms]| *ms).collect();
    (!own.is_empty()).then(|| own.iter().sum::<f64>() / own.len() as f64)
}

fn point([x, y]: [Reading; 2]) -> Point {
    Point {
        knob: x.middle(),
        label: String::new(),
        x: Some(x),
        y: Some(y),
        y_rms: None,
        standing: PointStanding::Right,
        command: String::new(),
    }
}

fn published_curve() -> Curve {
    let all = published();
    let unit = unit(&all).unwrap_or(f64::NAN);
    let points = all
        .iter()
        .map(|[x, ms]| point([Reading::exact(*x), Reading::exact(ms / unit)]));
    Curve {
        name: PUBLISHED.to_owned(),
        points: points.collect(),
    }
}

/// A view's frames over their own unit.
fn curve(name: &str, cases: &Cases<'_>) -> Option<Curve> {
    let metric = whole(cases.clock());
    let unit = unit(&points(cases, u32::MAX))?;
    let shown = |case: &Case| {
        let x = Reading::exact(triangles(cells(case)?));
        let spread = sample_spread(case, metric)?.over(unit);
        let replicates = process_medians(case, metric).into_values();
        let replicates: Vec<f64> = replicates.map(|ms| ms / unit).collect();
        Some(point([x, Reading::sampled(spread, &replicates)]))
    };
    let counted = cases.iter().filter(|case| case.counts());
    Some(Curve {
        name: name.to_owned(),
        points: counted.filter_map(shown).collect(),
    })
}

/// A panel a way, each with the published times.
fn plot(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let panel = |(way, title): (&str, &'static str)| {
        let own = cases.with(&[(TILES, way)]);
        let views = own.by(VIEW);
        let mut curves: Vec<Curve> = views
            .iter()
            .filter_map(|(view, cases)| curve(view, cases))
            .collect();
        if curves.is_empty() {
            return None;
        }
        curves.push(published_curve());
        Some(WorkPrecision {
            title,
            across: "triangles, 2 N²",
            up: "frame over the mean of N = 1 … 10",
            upwards: Upwards::Amount,
            curves,
            lines: Vec::new(),
        })
    };
    let panels: Vec<WorkPrecision<'_>> = WAYS.into_iter().filter_map(panel).collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let caption = "A frame against its triangles, ours by view and the published one, each over its own mean of N = 1 … \
                   10; whiskers: 5–95 % of the frames.";
    draw("Frame time against the number of cells", caption, &panels)
}

/// A row of a line, of what was published or of ours.
fn row(
    [series, way, cells]: [&str; 3],
    points: &[[f64; 2]],
    over: Result<String, &'static str>,
) -> Row {
    let found = line(points);
    let unit = unit(points);
    let cell = |of: &dyn Fn(&Line, f64) -> String| {
        let text = found.as_ref().zip(unit).map(|(line, unit)| of(line, unit));
        Cell::or_absent(text, NO_LINE)
    };
    // Of the mean frame, per cent for a hundred triangles.
    let share = |slope: f64, unit: f64| significant(1e4 * slope / unit);
    Row::new(vec![
        Cell::name(series),
        Cell::name(way),
        Cell::plain(cells),
        cell(&|line, _| significant(1e3 * line.slope)),
        cell(&|line, _| {
            let [low, high] = line.interval.map(|slope| significant(1e3 * slope));
            format!("{low} … {high}")
        }),
        cell(&|line, _| significant(line.correlation)),
        cell(&|line, _| significant(line.p)),
        cell(&|line, unit| share(line.slope, unit)),
        match over {
            Ok(text) => Cell::plain(text),
            Err(why) => Cell::absent(why),
        },
    ])
}

/// Lines through all series.
fn lines(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    const RANGES: [(u32, &str); 2] = [(MOST_PUBLISHED, "1 … 10"), (40, "1 … 40")];
    let mut rows = vec![row(
        [PUBLISHED, WAYS[0].0, RANGES[0].1],
        &published(),
        Err("one time a number of cells"),
    )];
    for (view, own) in cases.by(VIEW) {
        for (way, own) in own.by(TILES) {
            for (most, range) in RANGES {
                let over = rises(&own, most).map(|over| times(&over));
                rows.push(row(
                    [view, way, range],
                    &points(&own, most),
                    over.ok_or(NO_LINE),
                ));
            }
        }
    }
    let headings = [
        "frames",
        "tiles",
        "N",
        "µs a triangle",
        "95 % interval",
        "correlation",
        "p",
        "% of the mean frame for 100 triangles",
        "most cells ÷ one, by the lines of processes",
    ];
    Ok(Some(Block::Table(Table {
        caption: "Lines through frames over triangles; p: how likely a correlation as large is where there is none"
            .to_owned(),
        headings: headings.map(Heading::plain).into(),
        rows,
        ..Table::default()
    })))
}
