// SPDX-License-Identifier: MIT OR Apache-2.0
//! Table 2 of the paper: windows and paths, with any number of pages a frame and with one.

use super::{smooths, timed};
use crate::metrics::{self, *};
use crate::study::TABLE_2;
use terrafill_lab::{Cases, Column, Figure, Names, Section, Select, finding, measured};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Finding, Metric};

/// As printed: window and path; frames of the GPU, mean update, longest update without the cap and with it, ms.
const PUBLISHED: [(&str, &str, [f64; 4]); 6] = [
    ("1000", "smooth", [3.2, 0.665, 84.1, 56.0]),
    ("800", "smooth", [2.56, 0.45, 28.1, 16.6]),
    ("600", "smooth", [2.04, 0.381, 19.7, 15.1]),
    ("1000", "zoom", [2.86, 0.56, 76.6, 29.3]),
    ("800", "zoom", [2.18, 0.37, 93.5, 18.4]),
    ("600", "zoom", [1.686, 0.28, 11.8, 14.5]),
];

const SIZED: Names<'static> = Names::Columns(&[
    ("pixels a side", SIZE_PX),
    ("path", PATH),
    ("pages a frame", TRANSFERS),
]);

pub(super) const SECTION: Section<'static> = Section {
    title: "Table 2: an 8,192 × 8,192 texture in three windows",
    text: "Rule: counted pixels, hysteresis 4. An update takes counts over, decides, reads pages and sends them until the \
           device has them. The paper's column of longest updates has two numbers: without a cap, and with one transfer \
           an update. Its times are of another machine, so ratios within its rows stand beside ours: the longest update \
           over the mean one without a cap, and a mean update over a frame's drawing.",
    cases: Select::With(metrics::PART, TABLE_2),
    named_by: SIZED,
    columns: &[
        timed("draw, ms", PAGING_DRAW_WALL_MS, PAGING_DRAW_CPU_MS),
        timed(
            "mean update, ms",
            PAGING_UPDATE_WALL_MS,
            PAGING_UPDATE_CPU_MS,
        ),
        timed(
            "longest update, ms",
            PAGING_UPDATE_MAX_WALL_MS,
            PAGING_UPDATE_MAX_CPU_MS,
        ),
        Column::of(
            "longest ÷ mean",
            Figure::Computed(|case| {
                of_ours(case, [PAGING_UPDATE_MAX_CPU_MS, PAGING_UPDATE_CPU_MS])
            }),
        )
        .meaning("by process CPU time"),
        Column::of(
            "published longest ÷ mean",
            Figure::Words(|case| published(case, |of, longest| longest / of[1])),
        )
        .meaning("the longest update of the same cap over the mean one without"),
        Column::of(
            "update ÷ draw",
            Figure::Computed(|case| of_ours(case, [PAGING_UPDATE_CPU_MS, PAGING_DRAW_CPU_MS])),
        )
        .meaning("by process CPU time"),
        Column::of(
            "published update ÷ draw",
            Figure::Words(|case| published(case, |of, _| of[1] / of[0])),
        )
        .meaning("its mean update over its GPU time"),
        Column::metric("pages read", PAGING_READS),
        Column::metric("most in a frame", PAGING_READS_MAX),
        Column::metric("missing, px a frame", PAGING_MISSING_PX),
        Column::metric("texels a pixel", PAGING_TEXELS_PER_PX),
        Column::metric("wrong px", PAGING_MISMATCHED_PX),
    ],
    is_main: true,
    findings: &[smooths, spikes],
    pictures: &[("picture", "at rest")],
    ..Section::EMPTY
};

fn of_ours(case: &Case, [above, below]: [&Metric; 2]) -> Option<f64> {
    let [above, below] = [measured(case, above)?, measured(case, below)?];
    (below > 0.0).then(|| above / below)
}

/// A figure of the row of the paper that a case repeats.
///
/// - `of`: from its four figures, and the longest update of the case's cap
fn published(case: &Case, of: fn(&[f64; 4], f64) -> f64) -> Option<String> {
    let [side, path, pages] = [SIZE_PX, PATH, TRANSFERS].map(|key| case.condition(key));
    let mut rows = PUBLISHED.iter();
    let (_, _, figures) = rows.find(|row| row.0 == side && row.1 == path)?;
    let longest = figures[if pages == "1" { 3 } else { 2 }];
    Some(significant(of(figures, longest)))
}

/// By what is counted: most pages of a frame over their mean.
fn spikes(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(TRANSFERS, "any")]);
    let frames = crate::path::FRAMES as f64;
    let mut words = Vec::new();
    let mut ratios = Vec::new();
    for case in own.iter() {
        let reads = case.value(PAGING_READS).zip(case.value(PAGING_READS_MAX));
        if let Some((reads, most)) = reads.filter(|(reads, _)| *reads > 0.0) {
            let ratio = most / (reads / frames);
            words.push(format!("{}: {}", SIZED.text(case), significant(ratio)));
            ratios.push(ratio);
        }
    }
    let least = ratios.into_iter().min_by(f64::total_cmp);
    finding(
        "Gebbie & Bailey: updates have spikes when many nodes change at the same time, four times the mean and more",
        least.map(|least| least >= 4.0),
        format!(
            "Most pages of a frame over their mean, {}.",
            words.join("; ")
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn rows_of_the_paper_stand_beside_the_cases_that_repeat_them() {
        let mut run = MadeUpRun::default();
        for (side, pages) in [("1000", "any"), ("1000", "1"), ("700", "1")] {
            let conditions = [("size_px", side), ("path", "smooth"), ("transfers", pages)];
            run.case(case_id(
                crate::STUDY,
                &format!("{side}{pages}"),
                &conditions,
            ));
        }
        let run = run.loaded();
        let cases = Cases::of_study(&run, crate::STUDY);
        let longest = |_: &[f64; 4], longest: f64| longest;
        let found: Vec<_> = cases.iter().map(|case| published(case, longest)).collect();
        // The last one is no window of the paper's.
        assert_eq!(
            found,
            [Some("84.1".to_owned()), Some("56.0".to_owned()), None]
        );
    }
}
