// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on surfaces of a globe: error against time and against triangles, a plot for each view.

use crate::clock::{draw, whole};
use crate::keys::{
    API, GLOBE_DEPTH_M_MAX, GLOBE_EXPECTED_LOWEST_M, GLOBE_EXPECTED_MAP_M_MAX,
    GLOBE_EXPECTED_PX_MAX, GLOBE_EXTRA_PX, GLOBE_LOWEST_M, GLOBE_MAKE_CPU_MS, GLOBE_MAP_M_MAX,
    GLOBE_MAP_PX_MAX, GLOBE_MAP_PX_MEDIAN, GLOBE_MAP_PX_P99, GLOBE_PX_MEDIAN, GLOBE_UNCOVERED_PX,
    GLOBE_UPLOAD_BYTES, GLOBE_UPLOAD_CPU_MS, KNOB, PART, SURFACE, VALUE, VIEW,
};
use crate::metrics::METRICS;
use crate::{
    controllers, counts, forms, grid_facts, made, projection, published, shading, tiled, zones,
};
use terrafill_plot::number::{measured_bytes, significant};
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, dotted,
    panels,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, Heading, Metric, Noise, Plot, Row,
    Run, Table, process_medians, sample_spread,
};

const PX_MAX: &Metric = Metric::of(&METRICS, "globe_px_max");
const PX_P99: &Metric = Metric::of(&METRICS, "globe_px_p99");
const TRIANGLES: &Metric = Metric::of(&METRICS, "globe_triangles");
/// A quarter of a pixel: what no one sees.
const FINE_PX: f64 = 0.25;

/// Why a formula's cell is empty.
const NO_FORMULA: &str = "no formula for it, or none that holds in this view";

/// What is measured.
const WHAT_IS_COMPARED: &str = "Each surface draws the bare body. A pixel's ray meets the true ellipsoid at one place and the \
     triangles as drawn at another. The foot of the second, along the geodetic normal, is what a texture \
     by direction shows there. How far from the pixel's centre that place is seen is the error. A frame is \
     made, uploaded and drawn anew, as for an eye that moves. The ray cast has no triangles; its error is \
     measured from the depth that the device wrote.";

/// Which surface draws the body with which error in which time.
#[derive(Debug, Clone, Copy, Default)]
pub struct GlobesChapter;

impl Chapter for GlobesChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Globes: error of a surface against its time"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(whole(clock).name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let sights = sights(run);
        let noise = noise(run);
        let blocks = sights.iter();
        let blocks = blocks.filter_map(|sight| answer(sight, run.clock(), noise));
        Ok(Answers {
            blocks: blocks.map(Block::Text).collect(),
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        // What documents printed and what follows from formulas alone answers nobody who measured other things.
        if run.of_study(crate::STUDY).next().is_none() {
            return Ok(Vec::new());
        }
        let (sights, clock, noise) = (sights(run), run.clock(), noise(run));
        let mut blocks = Vec::new();
        if !sights.is_empty() {
            blocks.push(Block::Text(WHAT_IS_COMPARED.to_owned()));
        }
        let names = series(&sights);
        let palette = Palette::new(names);
        for sight in &sights {
            blocks.push(Block::section(format!("View {}", sight.view)));
            blocks.extend(answer(sight, clock, noise).map(Block::Text));
            let time = clock.pick(
                "make, upload: CPU ms; draw: GPU ms",
                "make, upload, draw: process CPU ms",
            );
            for (across, by) in [(time, whole(clock)), ("triangles", TRIANGLES)] {
                let svg = drawing(sight, across, by, &palette)?;
                blocks.extend(svg.map(|svg| {
                    Block::Plot(Plot {
                        caption: format!(
                            "{}: error against {}, one curve a surface through its knob, on wgpu.",
                            sight.view,
                            if by == TRIANGLES { "triangles" } else { "time" }
                        ),
                        svg,
                    })
                }));
            }
            blocks.push(Block::Table(table(sight, clock)));
            blocks.push(Block::Table(against_formulas(sight)));
        }
        blocks.extend(tiled::blocks(run, clock));
        blocks.extend(tiled::stage::blocks(run, clock));
        blocks.extend(tiled::picture::blocks(run, clock));
        blocks.extend(grid_facts::blocks(run));
        blocks.extend(forms::blocks(run));
        blocks.extend(made::blocks(run, clock));
        blocks.extend(counts::blocks(run)?);
        blocks.extend(zones::blocks(run)?);
        blocks.extend(shading::blocks(run, clock)?);
        blocks.extend(projection::blocks());
        blocks.extend(published::blocks(&tiled::frame_times_by_cells(run, clock)));
        blocks.extend(controllers::blocks()?);
        Ok(blocks)
    }
}

/// A view.
struct Sight<'a> {
    view: &'a str,
    cases: Vec<&'a Case>,
}

/// By how much identical work differed.
fn noise(run: &Run) -> Option<Noise> {
    let own: Vec<&Case> = run.of_study(crate::STUDY).collect();
    Noise::of(own.iter().copied(), whole(run.clock()))
}

/// In the order in which they first appear.
fn sights(run: &Run) -> Vec<Sight<'_>> {
    let mut sights: Vec<Sight<'_>> = Vec::new();
    let own = run.of_study(crate::STUDY);
    // Other parts of the study say which they are.
    let own = own.filter(|case| !case.is_twin() && case.condition(PART).is_empty());
    for case in own {
        let view = case.condition(VIEW);
        match sights.iter_mut().find(|sight| sight.view == view) {
            Some(sight) => sight.cases.push(case),
            None => sights.push(Sight {
                view,
                cases: vec![case],
            }),
        }
    }
    sights
}

/// A curve's name: the surface, and the interface where it is not the first one.
fn curve_name(case: &Case) -> String {
    match case.condition(API) {
        "wgpu" => case.condition(SURFACE).to_owned(),
        api => format!("{}, {api}", case.condition(SURFACE)),
    }
}

/// Vulkan itself draws the same triangles: its times stand in tables, since twice as many curves would hide each other.
fn is_drawn(case: &Case) -> bool {
    case.condition(API) != "vulkan"
}

fn series(sights: &[Sight<'_>]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let cases = sights.iter().flat_map(|sight| &sight.cases);
    for case in cases.filter(|case| is_drawn(case)) {
        let name = curve_name(case);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

fn case_name(case: &Case) -> String {
    match case.condition(KNOB) {
        "" => curve_name(case),
        knob => format!("{} {knob}={}", curve_name(case), case.condition(VALUE)),
    }
}

fn value(case: &Case, metric: &Metric) -> Option<f64> {
    case.value(metric).filter(|_| case.counts())
}

/// The cheapest of those whose error no one sees, and which of them tie with it.
fn answer(sight: &Sight<'_>, clock: Clock, noise: Option<Noise>) -> Option<String> {
    let timed = |case: &&Case| Some((value(case, whole(clock))?, value(case, PX_MAX)?));
    let all = sight.cases.iter().copied();
    let with = all.filter_map(|case| timed(&case).map(|(ms, px)| (case, ms, px)));
    let with: Vec<(&Case, f64, f64)> = with.collect();
    let fine = with
        .iter()
        .filter(|(case, _, px)| *px <= FINE_PX && value(case, GLOBE_UNCOVERED_PX) == Some(0.0));
    let best = fine.clone().min_by(|a, b| a.1.total_cmp(&b.1));
    let unit = clock.pick("ms, GPU and CPU", "ms of process CPU time");
    Some(match best {
        Some((case, ms, px)) => {
            let ties = |noise: Noise| -> Vec<String> {
                fine.filter(|(other, time, _)| other.id() != case.id() && noise.is_tie(time / ms))
                    .map(|(other, ..)| case_name(other))
                    .collect()
            };
            let ties = match noise.map(ties) {
                None => "No identical work was measured twice, so ties are not known.".to_owned(),
                Some(none) if none.is_empty() => "None ties with it.".to_owned(),
                Some(names) => format!(
                    "Within what identical work differed by tie: {}.",
                    names.join("; ")
                ),
            };
            format!(
                "View {}: the cheapest with at most ¼ px of error and no hole is {}: {} px, {} {unit}. \
                 {ties}",
                sight.view,
                case_name(case),
                significant(*px),
                significant(*ms)
            )
        }
        None => {
            let (case, ms, px) = with.iter().min_by(|a, b| a.2.total_cmp(&b.2))?;
            format!(
                "View {}: none has at most ¼ px of error and no hole; the least error is that of {}: {} \
                 px, {} {unit}.",
                sight.view,
                case_name(case),
                significant(*px),
                significant(*ms)
            )
        }
    })
}

fn drawing(
    sight: &Sight<'_>,
    across: &str,
    by: &'static Metric,
    palette: &Palette,
) -> Result<Option<String>, ChapterError> {
    let plots = [("largest", PX_MAX), ("99 % of the pixels", PX_P99)];
    let plots = plots.map(|(title, error)| WorkPrecision {
        title,
        across,
        up: "error, px",
        upwards: Upwards::Error,
        curves: curves(sight, by, error),
        lines: Vec::new(),
    });
    let title = format!("error of surfaces in view {}", sight.view);
    Ok(panels(&title, &plots, Arrangement::SideBySide, palette)?)
}

fn curves(sight: &Sight<'_>, by: &Metric, error: &Metric) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for case in sight.cases.iter().filter(|case| is_drawn(case)) {
        let spread = sample_spread(case, by).filter(|_| case.counts());
        let x = match by == TRIANGLES {
            true => value(case, by).map(Reading::exact),
            false => spread.map(|spread| {
                let replicates: Vec<f64> = process_medians(case, by).into_values().collect();
                Reading::sampled(spread, &replicates)
            }),
        };
        let Some(x) = x else { continue };
        let point = Point {
            knob: case.condition(VALUE).parse().unwrap_or(0.0),
            label: case.condition(VALUE).to_owned(),
            x: Some(x),
            y: value(case, error).map(Reading::exact),
            y_rms: None,
            standing: PointStanding::Right,
            command: String::new(),
        };
        let name = curve_name(case);
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve {
                name,
                points: vec![point],
            }),
        }
    }
    curves
}

/// Why a figure is not there.
fn why(case: &Case) -> &str {
    match case.reason.as_str() {
        "" => "not measured",
        reason => reason,
    }
}

/// A row for each case, those that were not measured too.
fn table(sight: &Sight<'_>, clock: Clock) -> Table {
    let columns = [
        ("triangles", TRIANGLES),
        ("frame, ms", whole(clock)),
        ("make, ms", GLOBE_MAKE_CPU_MS),
        ("upload, ms", GLOBE_UPLOAD_CPU_MS),
        ("draw, ms", draw(clock)),
        ("px, largest", PX_MAX),
        ("px, 99 %", PX_P99),
        ("px, median", GLOBE_PX_MEDIAN),
        ("map px, largest", GLOBE_MAP_PX_MAX),
        ("map px, 99 %", GLOBE_MAP_PX_P99),
        ("map px, median", GLOBE_MAP_PX_MEDIAN),
        ("depth, m", GLOBE_DEPTH_M_MAX),
        ("uncovered px", GLOBE_UNCOVERED_PX),
        ("extra px", GLOBE_EXTRA_PX),
    ];
    let rows = sight.cases.iter().map(|case| {
        let mut cells = vec![Cell::name(case_name(case))];
        let upload = value(case, GLOBE_UPLOAD_BYTES).map(measured_bytes);
        cells.push(Cell::or_absent(upload, why(case)));
        cells.extend(columns.iter().map(|(_, metric)| {
            let reason = match case.condition(KNOB) {
                "" if case.counts() => "there are no triangles",
                _ => why(case),
            };
            let figure = Cell::or_absent(value(case, metric).map(significant), reason);
            dotted(figure, case, metric)
        }));
        Row {
            cells,
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    let mut headings = vec![
        Heading::plain("surface"),
        Heading::metric("upload", GLOBE_UPLOAD_BYTES),
    ];
    let metrics = columns.iter();
    headings.extend(metrics.map(|(text, metric)| Heading::metric(*text, *metric)));
    Table {
        caption: format!("View {}", sight.view),
        headings,
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

/// What was measured beside what formulas say.
fn against_formulas(sight: &Sight<'_>) -> Table {
    let figures = [
        ("px, largest", PX_MAX, GLOBE_EXPECTED_PX_MAX),
        ("map, m", GLOBE_MAP_M_MAX, GLOBE_EXPECTED_MAP_M_MAX),
        ("lowest, m", GLOBE_LOWEST_M, GLOBE_EXPECTED_LOWEST_M),
    ];
    let with = sight.cases.iter().filter(|case| {
        let mut expected = figures.iter().map(|(_, _, expected)| value(case, expected));
        expected.any(|value| value.is_some())
    });
    let rows = with.map(|case| {
        let by = match case.note("expected-by") {
            "" => "no formula",
            by => by,
        };
        let mut cells = vec![Cell::name(case_name(case))];
        for (_, found, expected) in figures {
            let (found, expected) = (value(case, found), value(case, expected));
            let ratio = found.zip(expected).filter(|(_, expected)| *expected != 0.0);
            cells.push(Cell::or_absent(expected.map(significant), NO_FORMULA));
            cells.push(Cell::or_absent(found.map(significant), why(case)));
            let ratio = ratio.map(|(found, expected)| significant(found / expected));
            cells.push(Cell::or_absent(ratio, "no formula says more than 0"));
        }
        cells.push(Cell::name(by));
        Row::new(cells)
    });
    let mut headings = vec![Heading::plain("surface")];
    for (text, found, expected) in figures {
        headings.push(Heading::metric(format!("{text}: formula"), expected));
        headings.push(Heading::metric(format!("{text}: found"), found));
        headings.push(Heading::plain("found / formula"));
    }
    headings.push(Heading::plain("formula"));
    Table {
        caption: format!("View {}: what formulas say, and what was found", sight.view),
        headings,
        rows: rows.collect(),
        ..Table::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Status;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    /// A surface at two values of its knob, and one that could not be opened.
    fn blocks(holes_px: f64) -> (Answers, Vec<Block>) {
        let mut run = MadeUpRun::default();
        let id = |surface: &str, value: &str| {
            let conditions = [
                ("view", "globe"),
                ("surface", surface),
                ("knob", "n"),
                ("value", value),
                ("api", "wgpu"),
            ];
            case_id(
                crate::STUDY,
                &format!("globe/{surface}/n={value}/wgpu"),
                &conditions,
            )
        };
        for (value, ms, px, triangles) in [("10", 1.0, 2.0, 200.0), ("40", 3.0, 0.2, 3200.0)] {
            let case = run.case(id("mesh", value));
            case.figure(PX_MAX, px);
            case.figure(PX_P99, 0.5 * px);
            case.figure(TRIANGLES, triangles);
            case.figure("globe_uncovered_px", holes_px);
            case.timed(whole(Clock::ProcessCpu), &[ms, ms]);
        }
        let skipped = run.case(id("absent", "1"));
        skipped.ended(Status::Skipped, "no such surface");
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        let answers = GlobesChapter.answers(&run).expect("answers");
        (answers, GlobesChapter.blocks(&run).expect("a chapter"))
    }

    #[test]
    fn each_view_has_an_answer_two_plots_and_two_tables() {
        let (answers, blocks) = blocks(0.0);
        let [Block::Text(text)] = &answers.blocks[..] else {
            panic!("{answers:?}");
        };
        assert!(
            text.contains("with at most ¼ px of error and no hole is mesh n=40: 0.200 px, 3.00 ms"),
            "{text}"
        );
        assert!(text.ends_with("so ties are not known."), "{text}");
        let plots: Vec<&Plot> = blocks
            .iter()
            .filter_map(|block| match block {
                Block::Plot(plot) => Some(plot),
                _ => None,
            })
            .collect();
        assert!(plots.len() >= 2 && plots[1].caption.contains("triangles"));
        assert!(plots[0].svg.contains("mesh") && !plots[0].svg.contains("absent"));
        let table = blocks.iter().find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        let rows = &table.expect("a table").rows;
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[2].remark, "no such surface");
        // Twin: with holes nothing is fine enough to be named.
        let (answers, _) = self::blocks(7.0);
        let [Block::Text(text)] = &answers.blocks[..] else {
            panic!("{answers:?}");
        };
        assert!(
            text.contains("none has at most ¼ px of error and no hole"),
            "{text}"
        );
    }
}
