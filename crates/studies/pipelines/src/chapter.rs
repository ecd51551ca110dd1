// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on pipelines: grids, amplification, and what was published beside them.

mod amplification;
mod cache;
mod cells;
mod culling;
mod grids;
mod layered;
mod lights;
mod published;
mod series;

use crate::cache::Keep;
use crate::keys::{
    KEPT_IN, PIPELINE_DIFFERING_PX, PIPELINE_MISMATCHED_PX, PIPELINE_SHOWN_PX, TEST,
};
use cells::time;
use terrafill_results::{
    Answers, Block, Case, Chapter, ChapterError, Clock, Finding, Outcome, Run, Standing,
};

/// What is measured.
const WHAT_IS_COMPARED: &str = "A square of 2 km of analytic ground is drawn as a grid into 256 × 256 pixels, the whole of it in view. \
     Each pixel shows the number of its triangle or point, which is held against rays in double \
     precision that share nothing with what draws. Heights are 32-bit floats, fetched from a texture \
     where they are not sent.";

/// Grids by every stage of the pipeline.
#[derive(Debug, Clone, Copy, Default)]
pub struct PipelinesChapter;

impl Chapter for PipelinesChapter {
    fn study(&self) -> &'static str {
        crate::STUDY
    }

    fn title(&self) -> &'static str {
        "Pipelines: which stage makes a grid"
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        Some(time(clock).name)
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let cases = cases(run);
        Ok(Answers {
            blocks: recommended(&cases, run.clock()).into_iter().collect(),
            requirements: requirements(&cases),
            ..Answers::default()
        })
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let cases = cases(run);
        if cases.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = vec![Block::Text(WHAT_IS_COMPARED.to_owned())];
        blocks.extend(recommended(&cases, run.clock()));
        blocks.extend(requirements(&cases).into_iter().map(Block::Finding));
        blocks.extend(grids::section(&cases, run)?);
        blocks.extend(amplification::section(&cases, run));
        blocks.extend(culling::section(&cases, run)?);
        blocks.extend(cache::section(&cases, run));
        blocks.extend(lights::section(&cases, run));
        blocks.extend(layered::sections(&cases, run)?);
        Ok(blocks)
    }
}

/// Which way of each experiment that was measured.
fn recommended(cases: &[&Case], clock: Clock) -> Option<Block> {
    let mut sentences = grids::recommended(cases, clock);
    sentences.extend(amplification::recommended(cases, clock));
    sentences.extend(culling::recommended(cases, clock));
    sentences.extend(cache::recommended(cases, clock));
    sentences.extend(lights::recommended(cases, clock));
    sentences.extend(layered::recommended(cases, clock));
    (!sentences.is_empty()).then_some(Block::List(sentences))
}

fn cases(run: &Run) -> Vec<&Case> {
    run.of_study(crate::STUDY)
        .filter(|case| !case.is_twin())
        .collect()
}

/// Whether what a case loses is what is asked of it: the published test of patches, and places that are rounded on
/// their way to a texel.
fn is_wrong_by_design(case: &Case) -> bool {
    let rounds = Keep::ALL.into_iter().filter(|keep| keep.rounds());
    let mut rounds = rounds.map(Keep::name);
    case.condition(TEST).starts_with("point") || rounds.any(|name| case.condition(KEPT_IN) == name)
}

/// What is required of every picture.
fn requirements(cases: &[&Case]) -> Vec<Finding> {
    let drawn: Vec<&Case> = cases
        .iter()
        .copied()
        .filter(|case| case.value(PIPELINE_SHOWN_PX).is_some() && !is_wrong_by_design(case))
        .collect();
    let most = |metric| {
        let values = drawn.iter().filter_map(|case| case.value(metric));
        values.max_by(f64::total_cmp)
    };
    let of_pictures = |claim: &str, metric| {
        let most = most(metric);
        let bad = drawn
            .iter()
            .filter(|case| case.outcome != Outcome::Ok)
            .count();
        Finding {
            claim: format!("{claim}:"),
            standing: most.map_or(Standing::NotMeasured, |most| {
                Standing::holds_if(most <= 0.0)
            }),
            because: most.map_or_else(String::new, |most| {
                let all = drawn.len();
                format!("at most {most} pixels in {all} pictures, {bad} of them not right")
            }),
        }
    };
    let mut findings = vec![
        of_pictures(
            "Every way of a grid shows the same picture on one interface",
            PIPELINE_DIFFERING_PX,
        ),
        of_pictures(
            "No pixel outside of the band differs from the rays",
            PIPELINE_MISMATCHED_PX,
        ),
    ];
    findings.extend(amplification::bytes_finding(cases));
    findings.extend(culling::findings(cases));
    findings.extend(cache::findings(cases));
    findings.extend(lights::findings(cases));
    findings.extend(layered::findings(cases));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PipelinesStudy;
    use crate::metrics::METRICS;
    use std::rc::Rc;
    use terrafill_fill::Devices;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{RunEnvironment, RunFolder, SCHEMA};
    use terrafill_study::{Depth, Request, RunOptions, Silent, plan, run};

    fn finding<'a>(findings: &'a [Finding], words: &str) -> &'a Finding {
        let found = findings
            .iter()
            .find(|finding| finding.claim.contains(words));
        found.unwrap_or_else(|| panic!("{words:?} in {findings:?}"))
    }

    #[test]
    fn a_quick_run_has_a_chapter_and_its_exact_claims_hold() {
        let request = Request {
            depth: Depth::Quick,
            samples: Some(1),
            ..Request::default()
        };
        let options = RunOptions {
            processes: 1,
            process: 0,
            warm_up: 0,
            seed: 1,
            shard: None,
        };
        let plan = plan(&[&PipelinesStudy], &request, &options).expect("planned");
        let environment = RunEnvironment {
            schema: SCHEMA,
            ..RunEnvironment::default()
        };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run");
        let run_folder = RunFolder::create(&path, environment, plan.run_plan().clone(), &METRICS);
        let run_folder = run_folder.expect("a folder");
        let devices = Rc::new(Devices::default());
        run(&plan, &run_folder, &devices, &options, &mut Silent).expect("measured");
        let run = Run::load(&path).expect("a run");
        for case in run.cases.iter().filter(|case| !is_wrong_by_design(case)) {
            assert_ne!(
                case.outcome,
                Outcome::Wrong,
                "{}: {}",
                case.id(),
                case.reason
            );
            assert_ne!(
                case.outcome,
                Outcome::Failed,
                "{}: {}",
                case.id(),
                case.reason
            );
        }
        let blocks = PipelinesChapter.blocks(&run).expect("a chapter");
        let answers = PipelinesChapter.answers(&run).expect("answers");
        for finding in &answers.requirements {
            let Finding {
                claim,
                standing,
                because,
            } = finding;
            eprintln!("{standing:?}: {claim} {because}");
        }
        let does_not_hold = answers
            .requirements
            .iter()
            .filter(|finding| finding.standing == Standing::DoesNotHold);
        assert_eq!(does_not_hold.collect::<Vec<_>>(), Vec::<&Finding>::new());
        let sections = blocks
            .iter()
            .filter(|block| matches!(block, Block::Heading { .. }));
        let plots = blocks
            .iter()
            .filter(|block| matches!(block, Block::Plot(_)));
        assert!(sections.count() >= 3 && plots.count() >= 3);
        let holds = |words| finding(&answers.requirements, words).standing == Standing::Holds;
        assert!(holds("receiver subtracted"));
    }

    #[test]
    fn pictures_that_differ_and_bytes_that_do_not_fall_are_said() {
        let grid = |way: &str| {
            let conditions = [
                ("experiment", "grid"),
                ("api", "vulkan"),
                ("way", way),
                ("grid_cells", "64"),
            ];
            case_id(crate::STUDY, way, &conditions)
        };
        let amplified = |cells: &str| {
            let conditions = [
                ("experiment", "amplify"),
                ("grid_cells", "64"),
                ("cells_per_point", cells),
                ("strip", "cell"),
                ("source", "sent"),
            ];
            case_id(crate::STUDY, cells, &conditions)
        };
        let made = |differing: f64, bytes: f64| {
            let mut made = MadeUpRun::default();
            for way in ["sent-strips", "mesh-shader"] {
                let case = made.case(grid(way));
                case.figure("pipeline_shown_px", 900.0);
                case.figure("pipeline_mismatched_px", 0.0);
                case.figure("pipeline_differing_px", differing);
            }
            for (cells, bytes) in [("1", 1600.0), ("4", bytes), ("16", 100.0)] {
                made.case(amplified(cells))
                    .figure("pipeline_sent_bytes", bytes);
            }
            let folder = tempfile::tempdir().expect("a folder");
            let run = made.write(folder.path()).expect("a run");
            requirements(&cases(&run))
        };
        let right = made(0.0, 400.0);
        for words in [
            "same picture",
            "outside of the band",
            "a quarter and a sixteenth",
        ] {
            assert_eq!(finding(&right, words).standing, Standing::Holds, "{words}");
        }
        // Twins.
        let wrong = made(3.0, 800.0);
        let standing = |words| finding(&wrong, words).standing;
        assert_eq!(standing("same picture"), Standing::DoesNotHold);
        assert_eq!(standing("a quarter and a sixteenth"), Standing::DoesNotHold);
        assert_eq!(standing("outside of the band"), Standing::Holds);
    }
}
