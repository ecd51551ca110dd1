// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on growth: what a mesh costs by the vertices of its outline, one curve per shape.

use crate::metrics::{OUTLINE_VERTICES, SHAPE, TIME, VERTICES};
use terrafill_lab::{
    Cases, Column, Comparison, Drawing, Figure, Names, Panel, Section, SectionedChapter, measured,
    slope_one,
};
use terrafill_results::{Answers, Claim, Finding, Scope};

/// Sizes of the ratio, as in the condition `outline_vertices`.
const RATIO_SIZES: [&str; 2] = ["1000000", "100000"];
/// Ratios must be below this: n log n comes to 12 between the two sizes, and a third more is left for memory
/// beyond the caches.
const MAX_RATIO: f64 = 16.0;

/// What a mesh costs by the size of its outline.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Growth: time to mesh against vertices",
    question: "How does the cost of a mesh grow with its vertices?",
    text: "Made-up shapes are meshed from GeoJSON text on, each in a process of its own.",
    terms: crate::metrics::TERMS,
    primary: Figure::Metric(TIME),
    answers: |cases| Answers {
        requirements: growth(cases),
        ..Answers::default()
    },
    sections: &[Section {
        named_by: Names::Columns(&[("shape", SHAPE), ("vertices asked for", OUTLINE_VERTICES)]),
        columns: &[
            Column::metric("vertices", VERTICES),
            Column::metric("CPU ms", TIME),
            Column::of(
                "ns a vertex",
                Figure::Computed(|case| Some(1e6 * measured(case, TIME)? / case.value(VERTICES)?)),
            ),
        ],
        is_main: true,
        drawing: Some(Drawing {
            caption: "Process CPU time from GeoJSON text to mesh; whiskers: 5–95 % of the builds. Along the dashed line \
                      time grows as the vertices do.",
            panels: &[Panel {
                title: "Time to mesh against vertices",
                across: ("vertices of the outline", Figure::Metric(VERTICES)),
                up: ("process CPU ms: median, 5–95 %", Figure::Metric(TIME)),
                curve: Names::Joined(&[SHAPE]),
                knob: Figure::Metric(VERTICES),
                lines: slope_one,
                ..Panel::EMPTY
            }],
        }),
        ..Section::EMPTY
    }],
    claims: None,
};

/// How many times as long ten times the vertices take, for each shape that was planned in both sizes.
fn growth(cases: &Cases<'_>) -> Vec<Finding> {
    let comparison = Comparison {
        changed: OUTLINE_VERTICES.name(),
        follows: &[],
        one_sided: None,
        metric: TIME,
        needs: Scope::PLAN,
    };
    let shapes = cases.by(SHAPE).into_iter();
    let found = shapes.filter_map(|(shape, own)| {
        let pairs = own.pairs(OUTLINE_VERTICES, RATIO_SIZES, &[]);
        let claim = format!(
            "{shape}: a mesh of 1 000 000 vertices takes less than {MAX_RATIO} times as long as one of 100 000"
        );
        (!pairs.is_empty())
            .then(|| own.compared(&comparison, &pairs, Claim::LessThan(MAX_RATIO), claim))
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::METRICS;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Block, CaseId, CellClass, Chapter as _, Standing, Status};

    fn id(shape: &str, asked: u64) -> CaseId {
        let asked = asked.to_string();
        let conditions = [("shape", shape), ("outline_vertices", &asked)];
        case_id(crate::STUDY, &format!("{shape}/{asked}"), &conditions)
    }

    fn grow(run: &mut MadeUpRun, shape: &str, times: &[(u64, f64)]) {
        run.metrics = METRICS.to_vec();
        for &(asked, ms) in times {
            let case = run.case(id(shape, asked));
            // Shapes have about as many vertices as were asked for.
            case.figure(VERTICES, asked as f64 + 4.0);
            let process: &[f64] = &[0.95 * ms, ms, 1.1 * ms];
            case.sampled(TIME, &[process; 5]);
        }
    }

    fn blocks(run: &MadeUpRun) -> Vec<Block> {
        CHAPTER.blocks(&run.loaded()).expect("a chapter")
    }

    #[test]
    fn growth_is_drawn_and_compared_with_its_bound() {
        let sizes = [1_000, 10_000, 100_000, 1_000_000];
        let timed = |ms: [f64; 4]| sizes.into_iter().zip(ms).collect::<Vec<_>>();
        let mut run = MadeUpRun::default();
        grow(&mut run, "comb", &timed([1.0, 10.0, 100.0, 1_110.0]));
        grow(&mut run, "spiral", &timed([1.0, 10.0, 100.0, 1_700.0]));
        grow(&mut run, "needle", &[(1_000, 1.0)]);
        let blocks = blocks(&run);
        let [
            Block::Finding(comb),
            Block::Finding(spiral),
            Block::Text(_),
            Block::Plot(plot),
            Block::Table(table),
        ] = &blocks[..]
        else {
            panic!("two findings, a text, a plot and a table: {blocks:?}");
        };
        for word in ["slope 1", "comb", "spiral", "vertices of the outline"] {
            assert!(plot.svg.contains(word), "{word}");
        }
        assert_eq!(comb.standing, Standing::Holds);
        assert!(comb.because.starts_with("11.1 ×"), "{}", comb.because);
        // Negative control: one beyond the bound. The needle has no ratio of something else.
        assert_eq!(spiral.standing, Standing::DoesNotHold);
        assert!(spiral.because.starts_with("17.0 ×"), "{}", spiral.because);
        assert_eq!(table.rows.len(), 9);
        assert_eq!(table.rows[2].cells[3].text, "100");
    }

    #[test]
    fn a_build_that_broke_off_has_no_time_and_no_ratio() {
        let mut run = MadeUpRun::default();
        grow(&mut run, "comb", &[(100_000, 100.0), (1_000_000, 1_110.0)]);
        run.cases[1].ended(Status::Failed, "out of memory");
        let blocks = blocks(&run);
        let Some(Block::Table(table)) = blocks.last() else {
            panic!("a table: {blocks:?}");
        };
        assert_eq!(table.rows[1].cells[3].class, CellClass::Absent);
        assert_eq!(table.rows[1].cells[4].class, CellClass::Absent);
        let standing = blocks.iter().find_map(|block| match block {
            Block::Finding(found) => Some(found.standing),
            _ => None,
        });
        assert_eq!(standing, Some(Standing::NotMeasured));
    }

    #[test]
    fn a_run_without_growth_has_no_chapter() {
        let mut run = MadeUpRun::default();
        run.case(case_id("filling", "a", &[]));
        assert_eq!(blocks(&run), []);
    }
}
