// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the two papers on globes claim, tested by the study's cases, its findings and its page of arithmetic.

use crate::metrics::*;
use crate::{controllers, counts, made, shading, zones};
use terrafill_lab::{Cases, ClaimedTime, StudyClaims};
use terrafill_results::{ChapterError, DerivedTable, Finding, Scope};
use terrafill_tiled_globe::FRAMES_BY_CELLS;

/// Times that claims name.
const TIMES: &[ClaimedTime] = &[
    ClaimedTime {
        name: "frame",
        by: [GLOBE_WHOLE_GPU_MS, GLOBE_WHOLE_CPU_MS],
        needs: Scope::PLAN.and(Scope::DRAW),
    },
    ClaimedTime {
        name: "draw",
        by: [GLOBE_DRAW_GPU_MS, GLOBE_DRAW_CPU_MS],
        needs: Scope::DRAW,
    },
];

const PAGE: [&str; 2] = [
    "docs/globe-arithmetic.md",
    include_str!("../../../../docs/globe-arithmetic.md"),
];

/// Of both papers.
pub(crate) const CLAIMS: [StudyClaims; 2] = [
    StudyClaims {
        study: crate::STUDY,
        title: "The claims of Gebbie and Bailey",
        file: [
            "papers/gebbie-bailey.toml",
            include_str!("../../../../papers/gebbie-bailey.toml"),
        ],
        times: TIMES,
        metrics: &METRICS,
        findings,
        page: PAGE,
    },
    StudyClaims {
        study: crate::STUDY,
        title: "The claims of StuCoSReC 2018",
        file: [
            "papers/tiled-globe-2018.toml",
            include_str!("../../../../papers/tiled-globe-2018.toml"),
        ],
        times: TIMES,
        metrics: &METRICS,
        findings,
        page: PAGE,
    },
];

/// Files of the two tables: they are of one study.
const FILES: [&str; 2] = ["claims-globes-spiral.csv", "claims-globes-tiled.csv"];

/// What sections find that claims rest on.
fn findings(cases: &Cases<'_>) -> Vec<Finding> {
    let sections = [
        FRAMES_BY_CELLS,
        made::SECTION,
        counts::SECTION,
        zones::SECTION,
        zones::HILL_SECTION,
        controllers::SECTION,
    ];
    let all = sections.iter().chain(&shading::SECTIONS);
    all.flat_map(|section| section.found(cases)).collect()
}

/// The claims as data, a file a paper; none without a case.
pub(crate) fn tables(cases: &Cases<'_>) -> Result<Vec<DerivedTable>, ChapterError> {
    let claims = CLAIMS.iter().zip(FILES).filter(|_| !cases.is_empty());
    let table = |(claims, file): (&StudyClaims, &str)| {
        let table = claims.table(cases)?;
        let file = file.to_owned();
        Ok(DerivedTable { file, ..table })
    };
    claims.map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GlobesStudy;
    use crate::list::List;
    use crate::shading::Shadings;
    use std::rc::Rc;
    use std::sync::Arc;
    use terrafill_fixtures::data;
    use terrafill_globe_views::Opened;
    use terrafill_lab::REFUSED;
    use terrafill_results::made_up::MadeUpRun;
    use terrafill_scene::MipChain;
    use terrafill_screen_grid::ScreenGridKind;
    use terrafill_spiral::SpiralKind;
    use terrafill_study::{Request, Study as _};
    use terrafill_tiled_globe::pictured;

    #[test]
    fn every_claim_is_tested_by_cases_that_are_planned() {
        let study = GlobesStudy {
            surfaces: &[&ScreenGridKind, &SpiralKind],
        };
        let planned = study.plan(&Request::default()).expect("a plan");
        // Pictures of the Earth are data; of others there are the same cases.
        let picture = Arc::new(MipChain::new(2, 1, vec![9; 8]).expect("a picture"));
        let list = List::shipped().expect("a list");
        let opened = Rc::new(Opened::new(study.surfaces));
        let pictured = pictured((8, 1), picture, &opened).expect("a group");
        let layers = Rc::new(shading::synthetic_layers());
        let shaded = Shadings::planned(&list, (8, 1), false, layers, &opened);
        let of_plan = |is_planned: fn(&str) -> bool| {
            let mut run = MadeUpRun::default();
            let cases = planned.groups.iter().flat_map(|group| group.cases());
            for case in cases
                .chain(pictured.cases())
                .chain(&shaded.cases)
                .filter(|case| is_planned(case.id.condition("part")))
            {
                run.case(case.id.clone());
            }
            let run = run.loaded();
            let cases = Cases::of_study(&run, crate::STUDY);
            let untestable = CLAIMS.each_ref().map(|claims| {
                // No two cases that a claim compares differ in anything beside.
                let page = format!("{:?}", claims.blocks(&cases).expect("a section"));
                assert!(!page.contains(REFUSED), "{page}");
                claims.untestable(&cases).expect("a paper")
            });
            untestable.concat()
        };
        assert_eq!(of_plan(|_| true), [""; 0]);
        // Negative control: a plan without frames over numbers of cells.
        assert_eq!(
            of_plan(|part| part != "cells"),
            [
                "that do not sample from the texture",
                "The average time needed"
            ]
        );
    }

    #[test]
    fn each_paper_has_a_table_of_its_own() {
        let run = MadeUpRun::default();
        assert!(
            tables(&Cases::of_study(&run.loaded(), crate::STUDY)).is_ok_and(|none| none.is_empty())
        );
        let mut run = MadeUpRun::default();
        let case = terrafill_results::made_up::case_id(crate::STUDY, "one", &[("part", "made")]);
        run.case(case);
        let run = run.loaded();
        let tables = tables(&Cases::of_study(&run, crate::STUDY)).expect("tables");
        let files = tables.iter().map(|table| table.file.as_str());
        assert_eq!(files.collect::<Vec<_>>(), FILES);
        assert_ne!(tables[0].text, tables[1].text);
    }

    #[test]
    #[ignore = "needs data: papers"]
    fn quotations_are_words_of_the_papers() {
        for (claims, one, other) in [
            (&CLAIMS[0], "a single triangle fan", "a double triangle fan"),
            (&CLAIMS[1], "9560 terabytes", "9650 terabytes"),
        ] {
            // As plain text, beside the data folder.
            let paper = claims.paper().expect("a paper");
            let path = format!("../papers/{}.txt", paper.document);
            let document = String::from_utf8(data::bytes(&path)).expect("UTF-8");
            assert_eq!(paper.misquoted(&document), [""; 0]);
            // Negative control: one word.
            let wrong = paper.misquoted(&document.replace(one, other));
            assert_eq!(wrong.len(), 1, "{wrong:?}");
        }
    }
}
