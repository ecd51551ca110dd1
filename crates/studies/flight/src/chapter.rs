// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on flights: time against what missing pieces of terrain change, by the way of making pieces.

use crate::keys::{
    FLIGHT_FRAME_CPU_MS, FLIGHT_FRAME_WALL_MS, FLIGHT_WORST_FRAME_CPU_MS,
    FLIGHT_WORST_FRAME_WALL_MS, IMAGE, PIECES, SCENE, TECHNIQUE,
};
use crate::metrics::METRICS;
use terrafill_plot::number::{measured_bytes, significant};
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, Upwards, WorkPrecision, dotted,
    panels,
};
use terrafill_results::{
    Answers, Block, Case, Cell, Chapter, ChapterError, Clock, Finding, Heading, Metric, Picture,
    PictureFigure, Pictures, Plot, Row, Run, Standing, Table, process_medians, sample_spread,
};

const FRAME: [&Metric; 2] = [FLIGHT_FRAME_WALL_MS, FLIGHT_FRAME_CPU_MS];
const WORST: [&Metric; 2] = [FLIGHT_WORST_FRAME_WALL_MS, FLIGHT_WORST_FRAME_CPU_MS];
const FIRST: &Metric = Metric::of(&METRICS, "flight_first_frame_wall_ms");
const ERROR: &Metric = Metric::of(&METRICS, "flight_changed_px");
const LAST_ERROR: &Metric = Metric::of(&METRICS, "flight_last_changed_px");
const LATE: &Metric = Metric::of(&METRICS, "flight_late_frames");
const MADE: &Metric = Metric::of(&METRICS, "flight_pieces_made");
const EVICTED: &Metric = Metric::of(&METRICS, "flight_pieces_evicted");
const BYTES: &Metric = Metric::of(&METRICS, "flight_piece_bytes");
const BUDGET: &Metric = Metric::of(&METRICS, "flight_budget_bytes");
const COMPARED: &Metric = Metric::of(&METRICS, "flight_frames_compared");
const WRONG: &Metric = Metric::of(&METRICS, "flight_frames_wrong");
const OUTSIDE: &Metric = Metric::of(&METRICS, "flight_outside_px");

const WHAT_IS_COMPARED: &str = "The eye flies through the views of a scene, from the highest to the lowest, and rests there. At \
     first no piece of the terrain is there. “anew”: every frame makes all that it draws. “wait”: a frame \
     makes what it wants and is not there yet. “n a frame”: a frame is drawn from what is there; then n \
     pieces are made, those that lack most first. “background”: a thread makes them meanwhile. Pieces that \
     no frame has drawn for longest leave when the memory is full. Pictures on the way are compared with \
     the reference over the very triangles of that frame.";

/// What frames cost and show while terrain is being made.
#[derive(Debug, Clone, Copy, Default)]
pub struct FlightChapter;

impl Chapter for FlightChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Flights: terrain that is made on the way"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(pick(clock, FRAME).name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let all = || cases(run);
        let sum = |metric| -> f64 { all().filter_map(|case| case.value(metric)).sum() };
        let compared = sum(COMPARED);
        let scope = (compared > 0.0).then(|| {
            format!(
                "{compared} frames of flights were compared, each with the reference over the terrain \
                 as it was drawn then; {} are wrong.",
                sum(WRONG)
            )
        });
        let scenes = scenes(run).into_iter();
        Ok(Answers {
            scope: scope.into_iter().collect(),
            blocks: scenes
                .filter_map(|scene| answer(run, scene))
                .map(Block::Text)
                .collect(),
            requirements: requirements(run),
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let scenes = scenes(run);
        if scenes.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = vec![Block::Text(WHAT_IS_COMPARED.to_owned())];
        for scene in scenes {
            blocks.extend(answer(run, scene).map(Block::Text));
            if let Some(svg) = plot(run, scene)? {
                blocks.push(Block::Plot(Plot {
                    caption: format!(
                        "The worst frame of a flight over {scene}, and its median, against the pixels \
                         that missing pieces of terrain put into another region in the worst picture \
                         compared. Less is better both ways."
                    ),
                    svg,
                }));
            }
            blocks.push(Block::Table(table(run, scene)));
            blocks.extend(pictures(run, scene).map(Block::Pictures));
        }
        blocks.push(Block::section("Findings"));
        blocks.extend(requirements(run).into_iter().map(Block::Finding));
        Ok(blocks)
    }
}

fn cases(run: &Run) -> impl Iterator<Item = &Case> {
    run.of_study(crate::STUDY).filter(|case| !case.is_twin())
}

/// In the order in which they first appear.
fn scenes(run: &Run) -> Vec<&str> {
    let mut scenes = Vec::new();
    for case in cases(run) {
        let scene = case.condition(SCENE);
        if !scenes.contains(&scene) {
            scenes.push(scene);
        }
    }
    scenes
}

fn of<'a>(run: &'a Run, scene: &str) -> Vec<&'a Case> {
    let cases = cases(run).filter(|case| case.condition(SCENE) == scene);
    cases.collect()
}

fn value(case: &Case, metric: &Metric) -> Option<f64> {
    case.value(metric).filter(|_| case.counts())
}

fn pick(clock: Clock, metrics: [&'static Metric; 2]) -> &'static Metric {
    clock.pick(metrics[0], metrics[1])
}

/// What waiting costs, and what not waiting shows.
fn answer(run: &Run, scene: &str) -> Option<String> {
    let cases = of(run, scene);
    let clock = run.clock();
    let by = |pieces: &str| {
        let mut cases = cases.iter();
        cases.find(|case| case.condition(PIECES) == pieces)
    };
    let worst = pick(clock, WORST);
    let wait_ms = by("wait").and_then(|case| value(case, worst))?;
    let late = cases.iter().filter(|case| value(case, LATE) > Some(0.0));
    let late = late.filter_map(|case| Some((case, value(case, worst)?)));
    let (least, least_ms) = late.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let figure = |case, metric| {
        value(case, metric).map_or_else(|| "–".to_owned(), |count| count.to_string())
    };
    Some(format!(
        "Over {scene}, a flight whose frames wait for their terrain has a worst frame of {} ms of {}. By “{}” \
         the worst frame takes {} ms. {} of its frames lack pieces of terrain, which puts up to {} px of a \
         picture into another region; when the eye has rested, {} px.",
        significant(wait_ms),
        clock.pick("wall clock", "process CPU time"),
        least.condition(PIECES),
        significant(least_ms),
        figure(least, LATE),
        figure(least, ERROR),
        figure(least, LAST_ERROR),
    ))
}

/// No frame is wrong, and no memory was exceeded.
fn requirements(run: &Run) -> Vec<Finding> {
    let sum = |metric| -> Option<f64> {
        let values: Vec<f64> = cases(run).filter_map(|case| case.value(metric)).collect();
        (!values.is_empty()).then(|| values.iter().sum())
    };
    let finding = |claim: &str, found: Option<(bool, String)>| Finding {
        claim: claim.to_owned(),
        standing: found.as_ref().map_or(Standing::NotMeasured, |(holds, _)| {
            Standing::holds_if(*holds)
        }),
        because: found.map_or_else(String::new, |(_, because)| because),
    };
    let wrong = sum(WRONG).zip(sum(COMPARED));
    let wrong =
        wrong.map(|(wrong, all)| (wrong == 0.0, format!("{wrong} of {all} frames compared")));
    let fullest = cases(run).filter_map(|case| Some(value(case, BYTES)? / value(case, BUDGET)?));
    let fullest = fullest.max_by(f64::total_cmp);
    let fullest = fullest.map(|share| {
        let because = format!("{} % of the budget at most", significant(100.0 * share));
        (share <= 1.0, because)
    });
    vec![
        finding("Fills are right while terrain is being made.", wrong),
        finding("Pieces stay within their memory.", fullest),
    ]
}

fn table(run: &Run, scene: &str) -> Table {
    let clock = run.clock();
    let rows = of(run, scene).into_iter().map(|case| {
        let why = match case.reason.as_str() {
            "" => "not measured",
            reason => reason,
        };
        let cell = |metric| {
            let time = Cell::or_absent(value(case, metric).map(significant), why);
            dotted(time, case, metric)
        };
        let count = |metric| {
            let count = value(case, metric).map(|count| count.to_string());
            Cell::or_absent(count, why)
        };
        let size = |metric| Cell::or_absent(value(case, metric).map(measured_bytes), why);
        Row {
            cells: vec![
                Cell::name(case.condition(PIECES)),
                Cell::plain(case.condition(TECHNIQUE)),
                cell(pick(clock, FRAME)),
                cell(pick(clock, WORST)),
                cell(FIRST),
                count(ERROR),
                count(LAST_ERROR),
                count(LATE),
                count(MADE),
                count(EVICTED),
                size(BYTES),
                size(BUDGET),
                count(COMPARED),
                count(WRONG),
                count(OUTSIDE),
            ],
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    Table {
        caption: format!("flights over {scene}"),
        headings: vec![
            Heading::explained("pieces", "how the terrain's pieces are made"),
            Heading::plain("technique"),
            Heading::metric("frame, ms", pick(clock, FRAME)),
            Heading::metric("worst frame, ms", pick(clock, WORST)),
            Heading::metric("first frame, wall ms", FIRST),
            Heading::metric("px changed", ERROR),
            Heading::metric("last frame, px changed", LAST_ERROR),
            Heading::metric("late frames", LATE),
            Heading::metric("made", MADE),
            Heading::metric("let go", EVICTED),
            Heading::metric("memory", BYTES),
            Heading::metric("budget", BUDGET),
            Heading::metric("frames compared", COMPARED),
            Heading::metric("wrong", WRONG),
            Heading::metric("px outside band", OUTSIDE),
        ],
        rows: rows.collect(),
        is_main: true,
        ..Table::default()
    }
}

/// Where each flight ends; one of all that end with the same picture.
fn pictures(run: &Run, scene: &str) -> Option<Pictures> {
    let cases = of(run, scene).into_iter();
    let figures = cases.filter(|case| !case.note(IMAGE).is_empty());
    let figures: Vec<PictureFigure> = figures
        .map(|case| PictureFigure {
            pictures: vec![Picture {
                path: case.note(IMAGE).to_owned(),
                caption: "the last frame, which is compared".to_owned(),
            }],
            notes: vec![format!(
                "{} / {}",
                case.condition(PIECES),
                case.condition(TECHNIQUE)
            )],
        })
        .collect();
    (!figures.is_empty()).then(|| Pictures {
        caption: format!("where flights over {scene} end"),
        figures,
        ..Pictures::default()
    })
}

fn plot(run: &Run, scene: &str) -> Result<Option<String>, ChapterError> {
    let clock = run.clock();
    let cases = of(run, scene);
    // One technique shows every way.
    let technique = cases.first().map(|case| case.condition(TECHNIQUE));
    let cases = cases.into_iter();
    let cases: Vec<&Case> = cases
        .filter(|case| case.counts() && Some(case.condition(TECHNIQUE)) == technique)
        .collect();
    let across = format!(
        "worst frame, ms of {}",
        clock.pick("wall clock", "process CPU time")
    );
    let plots = [
        ("worst frame of a flight", pick(clock, WORST)),
        ("median frame", pick(clock, FRAME)),
    ];
    let plots = plots.map(|(title, time)| WorkPrecision {
        title,
        across: if time == pick(clock, WORST) {
            across.as_str()
        } else {
            "median frame, ms"
        },
        up: "px changed by missing pieces",
        upwards: Upwards::Error,
        curves: cases.iter().filter_map(|case| curve(case, time)).collect(),
        lines: Vec::new(),
    });
    let names = cases.iter().map(|case| case.condition(PIECES).to_owned());
    let palette = Palette::new(names.collect());
    let title = format!("time and error of flights over {scene}");
    Ok(panels(&title, &plots, Arrangement::SideBySide, &palette)?)
}

fn curve(case: &Case, time: &Metric) -> Option<Curve> {
    let replicates: Vec<f64> = process_medians(case, time).into_values().collect();
    Some(Curve {
        name: case.condition(PIECES).to_owned(),
        points: vec![Point {
            knob: 0.0,
            label: String::new(),
            x: Some(Reading::sampled(sample_spread(case, time)?, &replicates)),
            y: value(case, ERROR).map(Reading::exact),
            y_rms: None,
            standing: PointStanding::Right,
            command: String::new(),
        }],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    fn blocks(run: &MadeUpRun) -> (Vec<Block>, Answers) {
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        let blocks = FlightChapter.blocks(&run).expect("a chapter");
        (blocks, FlightChapter.answers(&run).expect("answers"))
    }

    fn made_up(wrong: f64, bytes: f64) -> MadeUpRun {
        let mut run = MadeUpRun::default();
        for (pieces, ms, error, late) in [("wait", 40.0, 0.0, 0.0), ("4 a frame", 8.0, 55.0, 30.0)]
        {
            let conditions = [
                ("scene", "hills"),
                ("technique", "vertex"),
                ("pieces", pieces),
            ];
            let case = run.case(case_id(crate::STUDY, pieces, &conditions));
            for metric in FRAME.into_iter().chain(WORST) {
                case.sampled(metric, &[&[ms, 1.01 * ms, 0.99 * ms]]);
            }
            for (metric, value) in [
                (ERROR, error),
                (LAST_ERROR, 2.0),
                (LATE, late),
                (BYTES, bytes),
                (BUDGET, 64e6),
                (COMPARED, 11.0),
                (WRONG, wrong),
            ] {
                case.figure(metric, value);
            }
            if late > 0.0 {
                case.note(IMAGE, "images/late.png");
            }
        }
        run
    }

    #[test]
    fn what_waiting_costs_and_not_waiting_shows_is_said_first() {
        let (found, answers) = blocks(&made_up(0.0, 9e6));
        let Some(Block::Text(answer)) = answers.blocks.first() else {
            panic!("an answer: {answers:?}");
        };
        for words in [
            "worst frame of 40",
            "“4 a frame”",
            "takes 8",
            "up to 55 px",
            "30 of its frames",
            "rested, 2 px",
        ] {
            assert!(answer.contains(words), "{words}: {answer}");
        }
        assert_eq!(
            answers.scope,
            [
                "22 frames of flights were compared, each with the reference over the terrain as it was \
              drawn then; 0 are wrong."
            ]
        );
        assert!(found.iter().any(|block| matches!(block, Block::Plot(_))));
        // Only what was drawn is shown.
        let pictures = found.iter().filter_map(|block| match block {
            Block::Pictures(pictures) => Some(&pictures.figures[..]),
            _ => None,
        });
        let pictures: Vec<&PictureFigure> = pictures.flatten().collect();
        assert_eq!(pictures.len(), 1);
        assert_eq!(pictures[0].notes, ["4 a frame / vertex"]);
        let standing = |answers: &Answers| -> Vec<Standing> {
            let all = answers.requirements.iter();
            all.map(|finding| finding.standing).collect()
        };
        assert_eq!(standing(&answers), [Standing::Holds; 2]);
        // Twins: a wrong frame, and a memory that was exceeded.
        let (_, wrong) = blocks(&made_up(1.0, 9e6));
        assert_eq!(standing(&wrong)[0], Standing::DoesNotHold);
        let (_, full) = blocks(&made_up(0.0, 65e6));
        assert_eq!(standing(&full)[1], Standing::DoesNotHold);
    }

    #[test]
    fn a_run_without_flights_has_no_chapter() {
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[]));
        let (found, answers) = blocks(&run);
        assert_eq!(found, []);
        assert_eq!(answers.requirements[0].standing, Standing::NotMeasured);
    }
}
