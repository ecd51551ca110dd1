// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on pipelines: sections as data, what is required of their figures, and what they recommend.

mod amplification;
mod blocks;
mod cache;
mod claims;
mod culling;
mod grids;
mod kit;
mod layered;
mod lights;
mod meshes;

use crate::cache::Keep;
use crate::metrics::*;
use kit::none_of;
use terrafill_lab::{Cases, SectionedChapter};
use terrafill_results::{Answers, Block, Case, Finding};

/// Grids by every stage of the pipeline.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Pipelines: which stage makes a grid",
    question: "Which stage of the pipeline should make a grid's vertices, at which cost and error?",
    text: "Experiments of Patidar, Bhattacharjee, Singh and Narayanan (2007) with the pipeline of shader model 4, beside \
           what does the same work today; their claims are the last section. A square of 2 km of analytic ground is \
           drawn as a grid, the whole of it in view. Each pixel shows the number of its triangle or point, which is held against rays in double precision that \
           share nothing with what draws. Heights are 32-bit floats, fetched from a texture where they are not sent.",
    terms: crate::metrics::TERMS,
    primary: kit::TIME,
    answers,
    sections: &[
        grids::SECTION,
        amplification::SECTION,
        culling::SECTION,
        culling::FLIGHT,
        cache::SECTION,
        blocks::SECTION,
        lights::SECTION,
        meshes::PATCHES,
        meshes::IMAGES,
        meshes::DEFORMED,
        lights::SOFT,
        lights::CUBE,
        layered::JUDGED,
        layered::TERRACES,
        layered::ROUGH,
        layered::HARD,
        layered::BLUR,
    ],
    claims: Some(&claims::CLAIMS),
};

fn answers(cases: &Cases<'_>) -> Answers {
    let mut sentences = grids::recommended(cases);
    sentences.extend(amplification::recommended(cases));
    sentences.extend(culling::recommended(cases));
    sentences.extend(cache::recommended(cases));
    sentences.extend(blocks::recommended(cases));
    sentences.extend(lights::recommended(cases));
    sentences.extend(meshes::recommended(cases));
    sentences.extend(layered::recommended(cases));
    let blocks = (!sentences.is_empty()).then_some(Block::List(sentences));
    Answers {
        blocks: blocks.into_iter().collect(),
        requirements: requirements(cases),
        ..Answers::default()
    }
}

/// Whether what a case loses is what is asked of it: the published test of patches, and places that are rounded on
/// their way to a texel.
fn is_wrong_by_design(case: &Case) -> bool {
    let rounds = Keep::LOOKED_UP.into_iter().filter(|keep| keep.rounds());
    let mut rounds = rounds.map(Keep::name);
    case.condition(TEST).starts_with("point") || rounds.any(|name| case.condition(KEPT_IN) == name)
}

/// What is required of every picture.
fn requirements(cases: &Cases<'_>) -> Vec<Finding> {
    let drawn =
        cases.fitting(|case| case.value(PIPELINE_SHOWN_PX).is_some() && !is_wrong_by_design(case));
    let mut findings = vec![
        none_of(
            "Every way of a grid shows the same picture on one interface",
            "pixels",
            &drawn.values(PIPELINE_DIFFERING_PX),
        ),
        none_of(
            "No pixel outside of the band differs from the rays",
            "pixels",
            &drawn.values(PIPELINE_MISMATCHED_PX),
        ),
    ];
    findings.extend(amplification::bytes_finding(cases));
    findings.extend(culling::requirements(cases));
    findings.extend(cache::requirement(cases));
    findings.extend(lights::requirement(cases));
    findings.extend(meshes::requirements(cases));
    findings.extend(layered::requirements(cases));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PipelinesStudy;
    use terrafill_fixtures::studies::measured;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Chapter as _, Outcome, Standing};
    use terrafill_study::{Depth, Request};

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
        let run = measured(&PipelinesStudy, &request);
        for case in run.cases.iter().filter(|case| !is_wrong_by_design(case)) {
            let is_good = !matches!(case.outcome, Outcome::Wrong | Outcome::Failed);
            assert!(is_good, "{}: {}", case.id(), case.reason);
        }
        let blocks = CHAPTER.blocks(&run).expect("a chapter");
        let answers = CHAPTER.answers(&run).expect("answers");
        for finding in &answers.requirements {
            eprintln!("{finding:?}");
            assert_ne!(finding.standing, Standing::DoesNotHold);
        }
        let count = |is: fn(&Block) -> bool| blocks.iter().filter(|block| is(block)).count();
        assert!(count(|block| matches!(block, Block::Heading { .. })) >= 3);
        assert!(count(|block| matches!(block, Block::Plot(_))) >= 3);
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
            requirements(&Cases::of_study(&made.loaded(), crate::STUDY))
        };
        let right = made(0.0, 400.0);
        for words in [
            "same picture",
            "outside of the band",
            "a quarter and a sixteenth",
        ] {
            assert_eq!(finding(&right, words).standing, Standing::Holds, "{words}");
        }
        // Negative controls.
        let wrong = made(3.0, 800.0);
        let standing = |words| finding(&wrong, words).standing;
        assert_eq!(standing("same picture"), Standing::DoesNotHold);
        assert_eq!(standing("a quarter and a sixteenth"), Standing::DoesNotHold);
        assert_eq!(standing("outside of the band"), Standing::Holds);
    }
}
