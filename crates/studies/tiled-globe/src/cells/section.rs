// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on frames against the number of cells, beside what was published.

use super::line::{Line, line};
use super::{MOST_PUBLISHED, PART};
use crate::metrics::{self, *};
use crate::tiles::section::{COUNT, MISSING, WRONG};
use std::collections::BTreeMap;
use terrafill_globe_views::{DRAW, FRAME, MAKE, whole};
use terrafill_lab::{Cases, Column, Figure, Names, Section, Select, draw, measured, overall};
use terrafill_plot::number::{figure, significant, times};
use terrafill_plot::{Curve, Point, PointStanding, Reading, Upwards, WorkPrecision};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Claim, Estimate, Finding, Heading, Noise, Row, Standing,
    Table, over_processes, process_medians, sample_spread,
};

/// A. Jeromel, StuCoSReC 2018, p. 42: frames per second by N × N rectangles of the screen, N from 1 on.
pub const PUBLISHED_FPS: [f64; 10] = [
    452.90, 350.62, 397.89, 407.09, 405.80, 364.40, 356.11, 370.66, 382.86, 359.95,
];

const PUBLISHED: &str = "published";
/// How tiles are drawn, and what a panel of it is called.
const WAYS: [(&str, &str); 2] = [
    ("draw-each", "a draw for each tile, as published"),
    ("array", "one draw from an array"),
];
const NO_LINE: &str = "fewer than three numbers of cells were timed";

/// Frames against the number of cells, whose findings claims rest on.
pub const SECTION: Section<'static> = Section {
    title: "Frame time against the number of cells",
    text: "The only experiment of StuCoSReC 2018: N × N rectangles of the screen, N from 10 down to 1, and the mean time \
           of a frame. It does not state window, view, tiles or draws. Here a frame makes the grid, sends it and draws \
           it, and the device waits for no other. The ground fills every view, so that no pixel comes or goes with N, \
           and one that shows no surface or a wrong texel makes the case wrong. The tiles of a view are those that the \
           body asks for, the same at every N; triangles across ±180° are split by the CPU at ½. In each process a line \
           is fitted to the frame over the triangles drawn. Its slope and the ratio of its ends have their interval \
           over processes, which decides. The table of lines has Student's interval as well, by what points leave over: \
           the ten published times have no other. Times of another machine stand beside ours as shares of the mean \
           frame of N = 1 … 10.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[("view", VIEW), ("tiles", TILES), ("N", CELLS)]),
    columns: &[
        Column::metric("triangles", GLOBE_TRIANGLES),
        Column::metric("draws", GLOBE_TILE_DRAWS),
        COUNT,
        Column::metric("px with a texel", GLOBE_TILE_PX),
        WRONG,
        MISSING,
        FRAME,
        MAKE,
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

/// Triangles, two a rectangle, and milliseconds of the published frames.
pub fn published() -> Vec<[f64; 2]> {
    let rates = (1..).zip(PUBLISHED_FPS);
    rates
        .map(|(n, rate)| [f64::from(2 * n * n), 1e3 / rate])
        .collect()
}

fn cells(case: &Case) -> Option<u32> {
    case.condition(CELLS).parse().ok()
}

/// Cases that count, up to a number of cells, with the triangles that they draw.
fn counted<'a>(cases: &Cases<'a>, most: u32) -> Vec<(f64, &'a Case)> {
    let own = cases
        .iter()
        .filter(|case| case.counts() && cells(case).is_some_and(|n| n <= most));
    own.filter_map(|case| Some((case.value(GLOBE_TRIANGLES)?, case)))
        .collect()
}

/// Triangles and frames.
fn points(cases: &Cases<'_>, most: u32) -> Vec<[f64; 2]> {
    let metric = whole(cases.clock());
    let own = counted(cases, most).into_iter();
    own.filter_map(|(triangles, case)| Some([triangles, measured(case, metric)?]))
        .collect()
}

/// What the lines of processes say.
struct Trend {
    /// Triangles of the fewest cells and of the most.
    ends: [f64; 2],
    /// Microseconds a triangle.
    slope: Estimate,
    /// The frame at the second end over that at the first.
    over: Estimate,
}

fn trend(cases: &Cases<'_>, most: u32) -> Option<Trend> {
    let metric = whole(cases.clock());
    let own = counted(cases, most);
    let mut by_process: BTreeMap<u32, Vec<[f64; 2]>> = BTreeMap::new();
    for (triangles, case) in &own {
        for (process, ms) in process_medians(case, metric) {
            by_process
                .entry(process)
                .or_default()
                .push([*triangles, ms]);
        }
    }
    let lines: Vec<Line> = by_process.values().filter_map(|of| line(of)).collect();
    let triangles = || own.iter().map(|(triangles, _)| *triangles);
    let ends = [
        triangles().min_by(f64::total_cmp)?,
        triangles().max_by(f64::total_cmp)?,
    ];
    let slopes: Vec<f64> = lines.iter().map(|line| 1e3 * line.slope).collect();
    let ratios = lines.iter().map(|line| line.at(ends[1]) / line.at(ends[0]));
    Some(Trend {
        ends,
        slope: over_processes(&slopes)?,
        over: over_processes(&ratios.collect::<Vec<f64>>())?,
    })
}

/// Whether times rise with triangles over the published numbers of cells, in every view.
fn rising(cases: &Cases<'_>, way: &str, named: &str) -> Finding {
    let own = cases.with(&[(TILES, way)]);
    let band = Noise::band(own.noise(whole(cases.clock())));
    let views = own.by(VIEW);
    let views = views.iter().filter_map(|(view, cases)| {
        let Trend { ends, slope, over } = trend(cases, MOST_PUBLISHED)?;
        let words = format!(
            "{view}: {} µs a triangle, so {} from {} triangles to {}",
            figure(&slope),
            times(&over),
            ends[0],
            ends[1]
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
                "by them no effect is shown"
            } else {
                "by them an effect is shown"
            }
        )
    })
}

/// Mean frame: of the published numbers of cells, so that two machines stand in one picture.
fn unit(points: &[[f64; 2]]) -> Option<f64> {
    let sum: f64 = points.iter().map(|[_, ms]| *ms).sum();
    (!points.is_empty()).then(|| sum / points.len() as f64)
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
    let unit = unit(&points(cases, MOST_PUBLISHED))?;
    let shown = |(triangles, case): (f64, &Case)| {
        let x = Reading::exact(triangles);
        let spread = sample_spread(case, metric)?.over(unit);
        let replicates = process_medians(case, metric).into_values();
        let replicates: Vec<f64> = replicates.map(|ms| ms / unit).collect();
        Some(point([x, Reading::sampled(spread, &replicates)]))
    };
    let all = counted(cases, u32::MAX).into_iter();
    Some(Curve {
        name: name.to_owned(),
        points: all.filter_map(shown).collect(),
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
            across: "triangles drawn; published: 2 N²",
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
    (points, unit): (&[[f64; 2]], Option<f64>),
    by_process: Result<Trend, &'static str>,
) -> Row {
    let found = line(points);
    let cell = |of: &dyn Fn(&Line, f64) -> String| {
        let text = found.as_ref().zip(unit).map(|(line, unit)| of(line, unit));
        Cell::or_absent(text, NO_LINE)
    };
    let of_processes = |of: &dyn Fn(&Trend) -> String| match &by_process {
        Ok(trend) => Cell::plain(of(trend)),
        Err(why) => Cell::absent(*why),
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
        of_processes(&|trend| figure(&trend.slope)),
        of_processes(&|trend| times(&trend.over)),
    ])
}

/// Lines through all series.
fn lines(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    const RANGES: [(u32, &str); 2] = [(MOST_PUBLISHED, "1 … 10"), (40, "1 … 40")];
    let mut rows = vec![row(
        [PUBLISHED, WAYS[0].0, RANGES[0].1],
        (&published(), unit(&published())),
        Err("one time a number of cells"),
    )];
    for (view, own) in cases.by(VIEW) {
        for (way, own) in own.by(TILES) {
            let unit = unit(&points(&own, MOST_PUBLISHED));
            let last = own.iter().filter_map(cells).max();
            for (most, range) in RANGES.into_iter().filter(|(most, _)| last >= Some(*most)) {
                rows.push(row(
                    [view, way, range],
                    (&points(&own, most), unit),
                    trend(&own, most).ok_or(NO_LINE),
                ));
            }
        }
    }
    let headings = [
        "frames",
        "tiles",
        "N",
        "µs a triangle",
        "Student's 95 % interval",
        "correlation",
        "p",
        "% of the mean frame for 100 triangles",
        "µs a triangle, by processes",
        "frame with the most ÷ with the fewest, by processes",
    ];
    Ok(Some(Block::Table(Table {
        caption: "Lines through frames over triangles; p: how likely a correlation as large is where there is none"
            .to_owned(),
        headings: headings.map(Heading::plain).into(),
        rows,
        ..Table::default()
    })))
}
