// SPDX-License-Identifier: MIT OR Apache-2.0
//! Table 2 of the paper: windows and paths, with any number of pages a frame and with one.

use crate::metrics::{self, *};
use terrafill_lab::{Cases, Column, Comparison, Figure, Names, Section, Select, finding, measured};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Claim, ConditionKey, Finding, Metric, Scope};

/// As printed: window and path; frames of the GPU, mean update, longest update without the cap and with it, ms.
const PUBLISHED: [(&str, &str, [f64; 4]); 6] = [
    ("1000", "smooth", [3.2, 0.665, 84.1, 56.0]),
    ("800", "smooth", [2.56, 0.45, 28.1, 16.6]),
    ("600", "smooth", [2.04, 0.381, 19.7, 15.1]),
    ("1000", "zoom", [2.86, 0.56, 76.6, 29.3]),
    ("800", "zoom", [2.18, 0.37, 93.5, 18.4]),
    ("600", "zoom", [1.686, 0.28, 11.8, 14.5]),
];

/// A column of times, by the clock of the device.
pub(super) const fn timed(
    heading: &'static str,
    wall: &'static Metric,
    cpu: &'static Metric,
) -> Column {
    Column::of(heading, Figure::ByClock(wall, cpu))
}

const SIZED: Names<'static> = Names::Columns(&[
    ("pixels a side", SIZE_PX),
    ("path", PATH),
    ("pages a frame", TRANSFERS),
]);

pub(super) const SECTION: Section<'static> = Section {
    title: "Table 2: an 8,192 × 8,192 texture in three windows",
    text: "Rule: counted pixels, hysteresis 4. An update takes counts over, decides, reads pages and sends them until the \
           device has them, by the wall clock. Means are of the 38 frames in which the eye moves, so that no update can \
           be more than 38 times the mean. The paper’s column of longest updates has two numbers: without a cap, and \
           with one transfer an update. Its times are of another machine and stand as printed; its mean update has no \
           word on the cap.",
    cases: Select::With(metrics::PART, TABLE_2),
    named_by: SIZED,
    columns: &[
        timed("draw, ms", PAGING_DRAW_WALL_MS, PAGING_DRAW_CPU_MS),
        Column::of(
            "published GPU, ms",
            Figure::Words(|case| published(case, |of, _| of[0])),
        ),
        Column::metric("mean update, ms", PAGING_UPDATE_MS),
        Column::of(
            "published mean",
            Figure::Words(|case| published(case, |of, _| of[1])),
        ),
        Column::metric("longest update, ms", PAGING_UPDATE_MAX_MS),
        Column::of(
            "published longest",
            Figure::Words(|case| published(case, |_, longest| longest)),
        ),
        Column::of(
            "longest ÷ mean",
            Figure::Computed(|case| {
                let is_any = case.condition(TRANSFERS) == "any";
                is_any.then(|| of_ours(case, [PAGING_UPDATE_MAX_MS, PAGING_UPDATE_MS]))?
            }),
        )
        .meaning("without a cap"),
        Column::of(
            "published longest ÷ mean",
            Figure::Words(|case| {
                let is_any = case.condition(TRANSFERS) == "any";
                is_any.then(|| published(case, |of, longest| longest / of[1]))?
            }),
        )
        .meaning("without a cap"),
        Column::of("update ÷ draw", Figure::Computed(of_draw))
            .meaning("mean update over mean drawing"),
        Column::of(
            "published update ÷ draw",
            Figure::Words(|case| published(case, |of, _| of[1] / of[0])),
        )
        .meaning("its mean update over its GPU time"),
        Column::metric("frames", PAGING_FRAMES),
        Column::metric("pages wanted", PAGING_WANTED),
        Column::metric("pages read", PAGING_READS),
        Column::metric("most in a frame", PAGING_READS_MAX),
        Column::metric("missing, px a frame", PAGING_MISSING_PX),
        Column::metric("texels a pixel", PAGING_TEXELS_PER_PX),
        Column::metric("wrong px", PAGING_MISMATCHED_PX),
    ],
    is_main: true,
    findings: &[smooths, small, scales],
    pictures: &[("picture", "at rest")],
    ..Section::EMPTY
};

/// Two cases that differ in one condition.
const fn compared(
    changed: ConditionKey,
    metric: &'static Metric,
    needs: Scope,
) -> Comparison<'static> {
    Comparison {
        changed: changed.name(),
        follows: &[],
        one_sided: None,
        metric,
        needs,
    }
}

pub(super) fn smooths(cases: &Cases<'_>) -> Finding {
    let pairs = cases.pairs(TRANSFERS, ["any", "1"], &[]);
    cases.compared(
        &compared(TRANSFERS, PAGING_UPDATE_MAX_MS, Scope::UPLOAD),
        &pairs,
        Claim::Faster,
        "Gebbie & Bailey: one transfer an update smooths its spikes, the longest update of a flight",
    )
}

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

fn of_draw(case: &Case) -> Option<f64> {
    of_ours(case, [PAGING_UPDATE_MS, PAGING_DRAW_WALL_MS])
}

/// The greatest of the paper's own means over its GPU time is 0.208.
const SMALL: f64 = 0.25;

/// Mean updates over drawing.
pub(super) fn small(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(TRANSFERS, "any")]);
    let ratios = own.iter().filter_map(of_draw).collect::<Vec<f64>>();
    let most = ratios.into_iter().max_by(f64::total_cmp);
    finding(
        "Gebbie & Bailey: the average update is quite small, a quarter of a frame’s drawing or less, as in Table 2",
        most.map(|most| most <= SMALL),
        format!("At most {}.", most.map(significant).unwrap_or_default()),
    )
}

/// By how much pages may grow more or less than pixels: a level more or less is a factor of 4.
const GROWTH: f64 = 4.0 / 3.0;

/// Pages that are wanted in the largest window over those in the smallest, against their pixels.
pub(super) fn scales(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(TRANSFERS, "any")]);
    let pixels = (1000.0_f64 / 600.0).powi(2);
    let pairs = own.pairs(SIZE_PX, ["1000", "600"], &[]);
    let growths = pairs.iter().filter_map(|[large, small]| {
        let growth = of_both([large, small], PAGING_WANTED)?;
        Some((large.condition(PATH), growth))
    });
    let growths: Vec<(&str, f64)> = growths.collect();
    let is_scaled = |growth: f64| (1.0 / GROWTH..=GROWTH).contains(&(growth / pixels));
    let words = growths
        .iter()
        .map(|(path, growth)| format!("{path}: {}", significant(*growth)));
    let words: Vec<String> = words.collect();
    finding(
        "Gebbie & Bailey: pages scale with the resolution, as pixels do by a third at most more or less",
        (!growths.is_empty()).then_some(growths.iter().all(|(_, growth)| is_scaled(*growth))),
        format!(
            "Pages wanted at 1,000 pixels a side over those at 600, which has {} times fewer pixels: {}.",
            significant(pixels),
            words.join("; ")
        ),
    )
}

fn of_both(cases: [&Case; 2], metric: &Metric) -> Option<f64> {
    let [above, below] = cases.map(|case| measured(case, metric));
    below
        .filter(|below| *below > 0.0)
        .and_then(|below| Some(above? / below))
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Standing;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn updates_that_are_small_and_pages_that_scale_are_told_from_others() {
        let standings = |update: f64, [large, small_one]: [f64; 2]| {
            let mut run = MadeUpRun::default();
            for (side, wanted) in [("1000", large), ("600", small_one)] {
                let conditions = [("size_px", side), ("path", "zoom"), ("transfers", "any")];
                let case = run.case(case_id(crate::STUDY, side, &conditions));
                case.timed(PAGING_UPDATE_MS, &[update; 5]);
                case.timed(PAGING_DRAW_WALL_MS, &[10.0; 5]);
                case.figure(PAGING_WANTED, wanted);
            }
            let run = run.loaded();
            let cases = Cases::of_study(&run, crate::STUDY);
            [small, scales].map(|of| of(&cases).standing)
        };
        assert_eq!(standings(2.0, [80.0, 30.0]), [Standing::Holds; 2]);
        // Controls: a long update, and a rule that ignores the resolution.
        assert_eq!(standings(3.0, [80.0, 80.0]), [Standing::DoesNotHold; 2]);
        assert_eq!(standings(3.0, [120.0, 30.0]), [Standing::DoesNotHold; 2]);
    }

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
