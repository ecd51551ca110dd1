// SPDX-License-Identifier: MIT OR Apache-2.0
//! What Patidar, Bhattacharjee, Singh and Narayanan (2007) claim of balls, tested by the study's cases.

use crate::metrics::*;
use terrafill_lab::{ClaimedTime, StudyClaims};
use terrafill_results::Scope;

pub(super) const CLAIMS: StudyClaims = StudyClaims {
    study: crate::STUDY,
    title: "The claims of 2007",
    file: [
        "papers/patidar-2007.toml",
        include_str!("../../../../../papers/patidar-2007.toml"),
    ],
    times: &[
        ClaimedTime {
            name: "frame",
            by: [BALL_FRAME_WALL_US, BALL_FRAME_CPU_US],
            needs: Scope::DISPATCH.and(Scope::DRAW),
        },
        ClaimedTime {
            name: "step",
            by: [BALL_STEP_GPU_US, BALL_STEP_CPU_US],
            needs: Scope::DISPATCH,
        },
    ],
    metrics: &METRICS,
    findings: |_| Vec::new(),
    page: [""; 2],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BallsStudy;
    use terrafill_fixtures::data;
    use terrafill_lab::{Cases, REFUSED};
    use terrafill_results::made_up::MadeUpRun;
    use terrafill_study::{Request, Study as _};

    #[test]
    fn every_claim_is_tested_by_cases_that_are_planned() {
        let planned = BallsStudy.plan(&Request::default()).expect("a plan");
        let of_plan = |is_planned: fn(&str) -> bool| {
            let mut run = MadeUpRun::default();
            let cases = planned.groups.iter().flat_map(|group| group.cases());
            for case in cases.filter(|case| is_planned(case.id.condition("drawn"))) {
                run.case(case.id.clone());
            }
            let run = run.loaded();
            let cases = Cases::of_study(&run, crate::STUDY);
            // No two cases that a claim compares differ in anything beside.
            let page = format!("{:?}", CLAIMS.blocks(&cases).expect("a section"));
            assert!(!page.contains(REFUSED), "{page}");
            CLAIMS.untestable(&cases).expect("a paper")
        };
        assert_eq!(of_plan(|_| true), [""; 0]);
        // Negative control: a plan in which no ball has a draw of its own.
        assert_eq!(of_plan(|drawn| drawn != "draw-each").len(), 3);
    }

    #[test]
    #[ignore = "needs data: papers"]
    fn quotations_are_words_of_the_paper() {
        // As plain text, beside the data folder.
        let paper = CLAIMS.paper().expect("a paper");
        let path = format!("../papers/{}.txt", paper.document);
        let document = String::from_utf8(data::bytes(&path)).expect("UTF-8");
        assert_eq!(paper.misquoted(&document), [""; 0]);
        // Negative control: one word.
        let wrong = paper.misquoted(&document.replace("GPU is that its", "GPU is that it"));
        assert_eq!(wrong.len(), 1, "{wrong:?}");
    }
}
