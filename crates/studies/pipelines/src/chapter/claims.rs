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
    use terrafill_fixtures::data;
    use terrafill_lab::{Cases, REFUSED};
    use terrafill_results::made_up::MadeUpRun;
    use terrafill_study::{Request, Study as _};

    #[test]
    fn every_claim_is_tested_by_cases_that_are_planned() {
        let planned = PipelinesStudy.plan(&Request::default()).expect("a plan");
        let of_plan = |is_planned: fn(&str) -> bool| {
            let mut run = MadeUpRun::default();
            let cases = planned.groups.iter().flat_map(|group| group.cases());
            for case in cases.filter(|case| is_planned(&case.id.key())) {
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
        // Negative control: a plan without the flight.
        assert_eq!(
            of_plan(|key| !key.contains("flight")),
            ["FPS With/Without 2-Level Culling"]
        );
    }

    #[test]
    #[ignore = "needs data: papers"]
    fn quotations_and_figures_are_those_of_the_paper() {
        // As plain text, beside the data folder.
        let paper = CLAIMS.paper().expect("a paper");
        let path = format!("../papers/{}.txt", paper.document);
        let document = String::from_utf8(data::bytes(&path)).expect("UTF-8");
        assert_eq!(paper.misquoted(&document), [""; 0]);
        // Negative control: one figure of a table.
        let wrong = paper.misquoted(&document.replace("1851", "1815"));
        assert_eq!(wrong.len(), 1, "{wrong:?}");
    }
}
