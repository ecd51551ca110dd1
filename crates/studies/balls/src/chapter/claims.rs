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
    use terrafill_fixtures::studies::{misquoted_if, untested_without};
    use terrafill_results::CaseId;

    #[test]
    fn every_claim_is_tested_by_cases_that_are_planned() {
        // Negative control: a plan in which no ball has a draw of its own.
        let is_each = |case: &CaseId| case.condition("drawn") == "draw-each";
        let untested = untested_without(&BallsStudy, &CLAIMS, is_each);
        assert_eq!(untested.len(), 3, "{untested:?}");
    }

    #[test]
    #[ignore = "needs data: papers"]
    fn quotations_are_words_of_the_paper() {
        let wrong = misquoted_if(&CLAIMS, "GPU is that its", "GPU is that it");
        assert_eq!(wrong.len(), 1, "{wrong:?}");
    }
}
