// SPDX-License-Identifier: MIT OR Apache-2.0
//! What Yang and Jin (2006) claim, tested by the study's cases.

use crate::metrics::*;
use terrafill_lab::{ClaimedTime, StudyClaims};
use terrafill_results::Scope;

pub(super) const CLAIMS: StudyClaims = StudyClaims {
    study: crate::STUDY,
    title: "The claims of Yang and Jin",
    file: [
        "papers/yang-jin-2006.toml",
        include_str!("../../../../../papers/yang-jin-2006.toml"),
    ],
    times: &[
        ClaimedTime {
            name: "shadows",
            by: [FILL_GPU, FILL_CPU],
            needs: Scope::DISPATCH.and(Scope::DRAW),
        },
        ClaimedTime {
            name: "whole",
            by: [WHOLE_WALL, WHOLE_CPU],
            needs: Scope::PLAN.and(Scope::DISPATCH).and(Scope::DRAW),
        },
        ClaimedTime {
            name: "outlines",
            by: [OUTLINE_GPU_MS, OUTLINE_CPU_MS],
            needs: Scope::DRAW,
        },
    ],
    metrics: &METRICS,
    findings: |_| Vec::new(),
    page: [""; 2],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShadowsStudy;
    use terrafill_fixtures::studies::{misquoted_if, untested_without};
    use terrafill_results::CaseId;

    #[test]
    fn every_claim_is_tested_by_cases_that_are_planned() {
        // Negative control: a plan without the paper's scissor.
        let is_cut = |case: &CaseId| case.condition("scissor") == "sea-level";
        let untested = untested_without(&ShadowsStudy, &CLAIMS, is_cut);
        assert_eq!(untested.len(), 2, "{untested:?}");
    }

    #[test]
    #[ignore = "needs data: papers"]
    fn quotations_are_words_of_the_paper() {
        let wrong = misquoted_if(&CLAIMS, "above sea level", "above the horizon");
        assert_eq!(wrong.len(), 1, "{wrong:?}");
    }
}
