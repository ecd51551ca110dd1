// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on surfaces of a globe: error against time and against triangles, a plot for each view; then what
//! further parts of the study found.

use crate::claims::{self, CLAIMS};
use crate::metrics::*;
use crate::{controllers, counts, filled, made, shading, wires, zones};
use terrafill_globe_views::{DRAW, FRAME, whole};
use terrafill_lab::{Cases, Column, Drawing, Figure, Names, Panel, Section, with_commands};
use terrafill_plot::number::significant;
use terrafill_plot::{PointStanding, Upwards};
use terrafill_results::{
    Answers, Block, Case, Chapter, ChapterError, Clock, DerivedTable, Metric, Run, Term,
};

/// A quarter of a pixel: what no one sees.
const FINE_PX: f64 = 0.25;

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

    fn question(&self) -> &'static str {
        "Which surface draws the body with which error in which time?"
    }

    fn terms(&self) -> &'static [Term] {
        crate::metrics::TERMS
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(whole(clock).name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let views = surfaces(run).by(VIEW);
        let mut blocks = texts(&views);
        // One shows what the others do: the chapter has them.
        if let Some((view, cases)) = views.first() {
            blocks.extend(DRAWINGS[0].block(&title(view), &shown(cases))?);
        }
        Ok(Answers {
            blocks,
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let views = surfaces(run).by(VIEW);
        let mut blocks = texts(&views);
        blocks.extend((!views.is_empty()).then(|| Block::Text(WHAT_IS_COMPARED.to_owned())));
        for (view, cases) in &views {
            blocks.extend(of_view(view, cases)?);
        }
        let parts = [
            wires::SECTION,
            filled::SECTION,
            made::SECTION,
            counts::SECTION,
            zones::SECTION,
            zones::HILL_SECTION,
            controllers::SECTION,
        ];
        let all = Cases::of_study(run, crate::STUDY);
        let tiled = terrafill_tiled_globe::SECTIONS;
        for section in tiled.iter().chain(&parts).chain(&shading::SECTIONS) {
            blocks.extend(section.blocks(&all)?);
        }
        for claims in CLAIMS.iter().filter(|_| !all.is_empty()) {
            blocks.extend(claims.blocks(&all)?);
        }
        Ok(with_commands(blocks, run, crate::STUDY))
    }

    fn tables(&self, run: &Run) -> Result<Vec<DerivedTable>, ChapterError> {
        claims::tables(&Cases::of_study(run, crate::STUDY))
    }
}

/// What to take in each view.
fn texts(views: &[(&str, Cases<'_>)]) -> Vec<Block> {
    let texts = views.iter().filter_map(|(view, cases)| answer(view, cases));
    texts.map(Block::Text).collect()
}

/// Of the surfaces; other parts of the study say which they are.
fn surfaces(run: &Run) -> Cases<'_> {
    Cases::of_study(run, crate::STUDY).with(&[(PART, "")])
}

/// A curve's name: the surface, and the interface where it is not the first one.
fn curve_name(case: &Case) -> String {
    match case.condition(API) {
        "wgpu" => case.condition(SURFACE).to_owned(),
        api => format!("{}, {api}", case.condition(SURFACE)),
    }
}

fn case_name(case: &Case) -> String {
    match case.condition(KNOB) {
        "" => curve_name(case),
        knob => format!("{} {knob}={}", curve_name(case), case.condition(VALUE)),
    }
}

fn title(view: &str) -> String {
    format!("View {view}")
}

/// What plots show. Vulkan itself draws the same triangles: its times stand in tables, since twice as many curves would
/// hide each other.
fn shown<'a>(cases: &Cases<'a>) -> Cases<'a> {
    cases.fitting(|case| case.condition(API) != "vulkan")
}

fn of_view(view: &str, cases: &Cases<'_>) -> Result<Vec<Block>, ChapterError> {
    let title = title(view);
    let mut blocks = vec![Block::section(title.clone())];
    for drawing in &DRAWINGS {
        blocks.extend(drawing.block(&title, &shown(cases))?);
    }
    blocks.push(Block::Table(SURFACES.table(title.clone(), cases)));
    let with = cases.fitting(|case| EXPECTED.iter().any(|metric| case.value(metric).is_some()));
    let caption = format!("{title}: what formulas say, and what was found");
    blocks.push(Block::Table(AGAINST_FORMULAS.table(caption, &with)));
    Ok(blocks)
}

/// The cheapest of those whose error no one sees, and which of them tie with it.
fn answer(view: &str, cases: &Cases<'_>) -> Option<String> {
    let time = whole(cases.clock());
    let figures = |case: &Case| {
        let [px, ms] = [case.value(GLOBE_PX_MAX), case.value(time)].map(Option::unwrap_or_default);
        let clock = cases.clock();
        let unit = clock.pick("ms, GPU and CPU", "ms of process CPU time");
        format!("{} px, {} {unit}", significant(px), significant(ms))
    };
    let timed = cases.fitting(|case| case.counts() && case.value(time).is_some());
    let fine = timed.fitting(|case| {
        case.value(GLOBE_PX_MAX).is_some_and(|px| px <= FINE_PX)
            && case.value(GLOBE_UNCOVERED_PX) == Some(0.0)
    });
    let Some(best) = fine.best(time) else {
        let least = timed.best(GLOBE_PX_MAX)?.case;
        return Some(format!(
            "View {view}: none has at most ¼ px of error and no hole; the least error is that of {}: {}.",
            case_name(least),
            figures(least)
        ));
    };
    let ties = match (fine.noise(time), best.ties.is_empty()) {
        (None, _) => " No identical work was measured twice, so ties are not known.",
        (_, true) => " None ties with it.",
        (_, false) => "",
    };
    Some(format!(
        "View {view}: the cheapest with at most ¼ px of error and no hole is {}{}: {}.{ties}",
        case_name(best.case),
        best.tied_with(case_name),
        figures(best.case)
    ))
}

/// Errors against something.
const fn errors(
    title: &'static str,
    across: (&'static str, Figure),
    error: &'static Metric,
) -> Panel<'static> {
    Panel {
        title,
        across,
        up: ("error, px", Figure::Metric(error)),
        upwards: Upwards::Error,
        curve: Names::Of("", curve_name),
        knob: Figure::Condition(VALUE),
        label: Some(Names::Joined(&[VALUE])),
        standing: |case| {
            if case.counts() {
                PointStanding::Right
            } else {
                PointStanding::Failed
            }
        },
        ..Panel::EMPTY
    }
}

const BY_TIME: (&str, Figure) = (
    "make, upload and draw, ms",
    Figure::ByClock(GLOBE_WHOLE_GPU_MS, GLOBE_WHOLE_CPU_MS),
);
const BY_TRIANGLES: (&str, Figure) = ("triangles", Figure::Metric(GLOBE_TRIANGLES));

const DRAWINGS: [Drawing<'static>; 2] = [
    Drawing {
        caption: "Error against time, one curve a surface through its knob, on wgpu.",
        panels: &[
            errors("largest", BY_TIME, GLOBE_PX_MAX),
            errors("99 % of the pixels", BY_TIME, GLOBE_PX_P99),
        ],
    },
    Drawing {
        caption: "Error against triangles, one curve a surface through its knob, on wgpu.",
        panels: &[
            errors("largest", BY_TRIANGLES, GLOBE_PX_MAX),
            errors("99 % of the pixels", BY_TRIANGLES, GLOBE_PX_P99),
        ],
    },
];

const SURFACES: Section<'static> = Section {
    named_by: Names::Of("surface", case_name),
    columns: &[
        Column::metric("upload", GLOBE_UPLOAD_BYTES),
        Column::metric("triangles", GLOBE_TRIANGLES).or("there are no triangles"),
        FRAME,
        Column::metric("make, ms", GLOBE_MAKE_CPU_MS),
        Column::metric("upload, ms", GLOBE_UPLOAD_CPU_MS),
        DRAW,
        Column::metric("px, largest", GLOBE_PX_MAX),
        Column::metric("px, 99 %", GLOBE_PX_P99),
        Column::metric("px, median", GLOBE_PX_MEDIAN),
        Column::metric("map px, largest", GLOBE_MAP_PX_MAX).or("there are no triangles"),
        Column::metric("map px, 99 %", GLOBE_MAP_PX_P99).or("there are no triangles"),
        Column::metric("map px, median", GLOBE_MAP_PX_MEDIAN).or("there are no triangles"),
        Column::metric("depth, m", GLOBE_DEPTH_M_MAX),
        Column::metric("uncovered px", GLOBE_UNCOVERED_PX),
        Column::metric("extra px", GLOBE_EXTRA_PX),
    ],
    is_main: true,
    ..Section::EMPTY
};

/// What formulas say.
const EXPECTED: [&Metric; 3] = [
    GLOBE_EXPECTED_PX_MAX,
    GLOBE_EXPECTED_MAP_M_MAX,
    GLOBE_EXPECTED_LOWEST_M,
];

/// Why a formula's cell is empty.
const NO_FORMULA: &str = "no formula for it, or none that holds in this view";

/// Found over what a formula says.
const fn over(of: fn(&Case) -> Option<f64>) -> Column {
    Column::of("found / formula", Figure::Computed(of)).or("no formula says more than 0")
}

fn ratio(case: &Case, [found, expected]: [&Metric; 2]) -> Option<f64> {
    let expected = case.value(expected).filter(|expected| *expected != 0.0);
    Some(case.value(found)? / expected?)
}

const AGAINST_FORMULAS: Section<'static> = Section {
    named_by: Names::Of("surface", case_name),
    columns: &[
        Column::metric("px, largest: formula", GLOBE_EXPECTED_PX_MAX).or(NO_FORMULA),
        Column::metric("px, largest: found", GLOBE_PX_MAX),
        over(|case| ratio(case, [GLOBE_PX_MAX, GLOBE_EXPECTED_PX_MAX])),
        Column::metric("map, m: formula", GLOBE_EXPECTED_MAP_M_MAX).or(NO_FORMULA),
        Column::metric("map, m: found", GLOBE_MAP_M_MAX),
        over(|case| ratio(case, [GLOBE_MAP_M_MAX, GLOBE_EXPECTED_MAP_M_MAX])),
        Column::metric("lowest, m: formula", GLOBE_EXPECTED_LOWEST_M).or(NO_FORMULA),
        Column::metric("lowest, m: found", GLOBE_LOWEST_M),
        over(|case| ratio(case, [GLOBE_LOWEST_M, GLOBE_EXPECTED_LOWEST_M])),
        Column::of(
            "formula",
            Figure::Words(|case| Some(case.note("expected-by").to_owned())),
        ),
    ],
    ..Section::EMPTY
};

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Plot, Status};

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
            case.figure(GLOBE_PX_MAX, px);
            case.figure(GLOBE_PX_P99, 0.5 * px);
            case.figure(GLOBE_TRIANGLES, triangles);
            case.figure("globe_uncovered_px", holes_px);
            case.timed(whole(Clock::ProcessCpu), &[ms, ms]);
        }
        let skipped = run.case(id("absent", "1"));
        skipped.ended(Status::Skipped, "no such surface");
        let run = run.loaded();
        let answers = GlobesChapter.answers(&run).expect("answers");
        (answers, GlobesChapter.blocks(&run).expect("a chapter"))
    }

    #[test]
    fn each_view_has_an_answer_two_plots_and_two_tables() {
        let (answers, blocks) = blocks(0.0);
        let [Block::Text(text), Block::Plot(first)] = &answers.blocks[..] else {
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
        assert_eq!(
            first, plots[0],
            "the first page has the plot of the first view"
        );
        assert!(plots[0].svg.contains("mesh") && !plots[0].svg.contains("absent"));
        let table = blocks.iter().find_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        let rows = &table.expect("a table").rows;
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[2].remark, "no such surface");
        // Negative control: with holes nothing is fine enough to be named.
        let (answers, _) = self::blocks(7.0);
        let [Block::Text(text), Block::Plot(_)] = &answers.blocks[..] else {
            panic!("{answers:?}");
        };
        assert!(
            text.contains("none has at most ¼ px of error and no hole"),
            "{text}"
        );
    }
}
