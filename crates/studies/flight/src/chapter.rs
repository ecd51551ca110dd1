// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on flights: time against what missing pieces of terrain change, by the way of making pieces.

use crate::metrics::*;
use terrafill_lab::{
    Cases, Column, Drawing, Figure, Names, Panel, Section, SectionedChapter, finding, measured,
};
use terrafill_plot::Upwards;
use terrafill_plot::number::significant;
use terrafill_results::{Answers, Block, Case, Finding};

/// What is drawn against the pixels that missing pieces change.
const PANEL: Panel<'static> = Panel {
    up: ("px changed by missing pieces", Figure::Metric(ERROR)),
    upwards: Upwards::Error,
    curve: Names::Joined(&[PIECES, TECHNIQUE]),
    ..Panel::EMPTY
};

/// What frames cost and show while terrain is being made.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Flights: terrain that is made on the way",
    question: "What do frames cost and show while the terrain's pieces are still being made?",
    text: "The eye flies through the views of a scene, from the highest to the lowest, and rests there. At first no piece \
           of the terrain is there. “anew”: every frame makes all that it draws. “wait”: a frame makes what it wants and \
           is not there yet. “n a frame”: a frame is drawn from what is there; then n pieces are made, those that lack \
           most first. “background”: a thread makes them meanwhile. Pieces that no frame has drawn for longest leave when \
           the memory is full. Pictures on the way are compared with the reference over the very triangles of that frame.",
    terms: crate::metrics::TERMS,
    primary: Figure::ByClock(FRAME_WALL, FRAME_CPU),
    answers,
    sections: &[Section {
        title: "Frames, pieces and errors",
        named_by: Names::Columns(&[("pieces", PIECES), ("technique", TECHNIQUE)]),
        columns: &[
            Column::clocked("frame, ms", FRAME_WALL, FRAME_CPU),
            Column::clocked("worst frame, ms", WORST_WALL, WORST_CPU),
            Column::metric("first frame, wall ms", FIRST),
            Column::metric("px changed", ERROR),
            Column::metric("last frame, px changed", LAST_ERROR),
            Column::metric("late frames", LATE),
            Column::metric("made", MADE),
            Column::metric("let go", EVICTED),
            Column::metric("memory", BYTES),
            Column::metric("budget", BUDGET),
            Column::metric("frames compared", COMPARED),
            Column::metric("wrong", WRONG),
            Column::metric("px outside band", OUTSIDE),
        ],
        per: Some(SCENE),
        is_main: true,
        drawing: Some(Drawing {
            caption: "The worst frame of a flight, and its median, against the pixels that missing pieces of terrain put \
                      into another region in the worst picture compared. Less is better both ways.",
            panels: &[
                Panel {
                    title: "worst frame of a flight",
                    across: ("worst frame, ms", Figure::ByClock(WORST_WALL, WORST_CPU)),
                    ..PANEL
                },
                Panel {
                    title: "median frame",
                    across: ("median frame, ms", Figure::ByClock(FRAME_WALL, FRAME_CPU)),
                    ..PANEL
                },
            ],
        }),
        // Where each flight ends; one of all that end with the same picture.
        pictures: &[(IMAGE, "the last frame, which is compared")],
        ..Section::EMPTY
    }],
    claims: None,
};

fn answers(cases: &Cases<'_>) -> Answers {
    let [compared, wrong] = [COMPARED, WRONG].map(|metric| cases.sum(metric));
    let scope = compared.zip(wrong).map(|(compared, wrong)| {
        format!(
            "{compared} frames of flights were compared, each with the reference over the terrain as it was drawn then; \
             {wrong} are wrong."
        )
    });
    let scenes = cases.by(SCENE);
    let said = scenes.iter().filter_map(|(scene, own)| answer(scene, own));
    Answers {
        scope: scope.into_iter().collect(),
        blocks: said.map(Block::Text).collect(),
        requirements: requirements(cases),
    }
}

/// What waiting costs, and what not waiting shows.
fn answer(scene: &str, cases: &Cases<'_>) -> Option<String> {
    let worst = cases.clock().pick(WORST_WALL, WORST_CPU);
    let wait_ms = cases.with(&[(PIECES, "wait")]).value(worst)?;
    let late = cases.fitting(|case| measured(case, LATE) > Some(0.0));
    let best = late.best(worst)?;
    let figure = |metric| {
        measured(best.case, metric).map_or_else(|| "–".to_owned(), |count| count.to_string())
    };
    let name = |case: &Case| {
        format!(
            "“{}” ({})",
            case.condition(PIECES),
            case.condition(TECHNIQUE)
        )
    };
    Some(format!(
        "Over {scene}, a flight whose frames wait for their terrain has a worst frame of {} ms of {}. By {}{} the worst \
         frame takes {} ms. {} of its frames lack pieces of terrain, which puts up to {} px of a picture into another \
         region; when the eye has rested, {} px.",
        significant(wait_ms),
        cases.clock().pick("wall clock", "process CPU time"),
        name(best.case),
        best.tied_with(name),
        significant(best.value),
        figure(LATE),
        figure(ERROR),
        figure(LAST_ERROR),
    ))
}

/// No frame is wrong, and no memory was exceeded.
fn requirements(cases: &Cases<'_>) -> Vec<Finding> {
    let frames = cases.sum(WRONG).zip(cases.sum(COMPARED));
    let share = |case| Some(measured(case, BYTES)? / measured(case, BUDGET)?);
    let fullest = cases.iter().filter_map(share).max_by(f64::total_cmp);
    vec![
        finding(
            "Fills are right while terrain is being made.",
            frames.map(|(wrong, _)| wrong == 0.0),
            frames.map_or_else(String::new, |(wrong, all)| {
                format!("{wrong} of {all} frames compared")
            }),
        ),
        finding(
            "Pieces stay within their memory.",
            fullest.map(|share| share <= 1.0),
            fullest.map_or_else(String::new, |share| {
                format!("{} % of the budget at most", significant(100.0 * share))
            }),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Chapter as _, PictureFigure, Standing};

    fn blocks(run: &MadeUpRun) -> (Vec<Block>, Answers) {
        let run = run.loaded();
        let blocks = CHAPTER.blocks(&run).expect("a chapter");
        (blocks, CHAPTER.answers(&run).expect("answers"))
    }

    fn made_up(wrong: f64, bytes: f64) -> MadeUpRun {
        let mut run = MadeUpRun {
            metrics: METRICS.to_vec(),
            ..MadeUpRun::default()
        };
        for (pieces, ms, error, late) in [("wait", 40.0, 0.0, 0.0), ("4 a frame", 8.0, 55.0, 30.0)]
        {
            let conditions = [
                ("scene", "hills"),
                ("technique", "vertex"),
                ("pieces", pieces),
            ];
            let case = run.case(case_id(crate::STUDY, pieces, &conditions));
            for metric in [FRAME_WALL, FRAME_CPU, WORST_WALL, WORST_CPU] {
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
        assert_eq!(pictures[0].notes, ["4 a frame, vertex"]);
        let standing = |answers: &Answers| -> Vec<Standing> {
            let all = answers.requirements.iter();
            all.map(|finding| finding.standing).collect()
        };
        assert_eq!(standing(&answers), [Standing::Holds; 2]);
        // Negative controls: a wrong frame, and a memory that was exceeded.
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
