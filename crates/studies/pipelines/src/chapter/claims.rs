// SPDX-License-Identifier: MIT OR Apache-2.0
//! What Patidar, Bhattacharjee, Singh and Narayanan (2007) claim of pipelines, tested by the study's cases.

use super::kit::WHOLE;
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
            by: [PIPELINE_WALL_MS, PIPELINE_CPU_MS],
            needs: WHOLE,
        },
        ClaimedTime {
            name: "draw",
            by: [PIPELINE_GPU_MS, PIPELINE_CPU_MS],
            needs: Scope::DRAW,
        },
        ClaimedTime {
            name: "maps",
            by: [LIGHTS_MAPS_GPU_MS, LIGHTS_MAPS_CPU_MS],
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
    use crate::PipelinesStudy;
    use terrafill_fixtures::studies::{misquoted_if, untested_without};
    use terrafill_results::CaseId;

    #[test]
    fn every_claim_is_tested_by_cases_that_are_planned() {
        // Negative control: a plan without the flight.
        let is_flight = |case: &CaseId| case.key().contains("flight");
        assert_eq!(
            untested_without(&PipelinesStudy, &CLAIMS, is_flight),
            ["FPS With/Without 2-Level Culling"]
        );
    }

    #[test]
    #[ignore = "needs data: papers"]
    fn quotations_and_figures_are_those_of_the_paper() {
        // One figure of a table.
        let wrong = misquoted_if(&CLAIMS, "1851", "1815");
        assert_eq!(wrong.len(), 1, "{wrong:?}");
    }
}
