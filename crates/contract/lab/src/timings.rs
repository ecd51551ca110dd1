// SPDX-License-Identifier: MIT OR Apache-2.0
//! Times that rank cases: by one clock, beside how far identical work differed.

use std::collections::BTreeMap;
use terrafill_plot::RatioRow;
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Case, Cell, Estimate, Metric, Noise, Spread, Timer, over_typical, process_medians, ratio,
    sample_spread, typical,
};

/// What ranks cases. A case that does not count has no typical time and no ratio to another.
#[derive(Debug, Clone, Copy)]
pub struct Timings {
    /// The time by the run's clock.
    pub metric: &'static Metric,
    /// By how much identical work differed; `None` where none was measured twice.
    pub noise: Option<Noise>,
}

impl Timings {
    /// `process CPU ms`, for headings and axes.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        self.metric.timer().map_or("ms", Timer::unit_ms)
    }

    /// Over all samples of a case, be it right or wrong.
    #[must_use]
    pub fn samples(&self, case: &Case) -> Option<Spread> {
        sample_spread(case, self.metric)
    }

    /// One number for each process.
    #[must_use]
    pub fn replicates(&self, case: &Case) -> Vec<f64> {
        process_medians(case, self.metric).into_values().collect()
    }

    /// Typical time over processes: what ranks cases.
    #[must_use]
    pub fn typical(&self, case: &Case) -> Option<Estimate> {
        typical(case, self.metric).filter(|_| case.counts())
    }

    /// The case of least typical time; none of them is less than 1 over it.
    #[must_use]
    pub fn fastest<'a>(&self, cases: impl Iterator<Item = &'a Case>) -> Option<&'a Case> {
        let timed = cases.filter_map(|case| Some((case, self.typical(case)?.middle)));
        let fastest = timed.min_by(|a, b| a.1.total_cmp(&b.1));
        fastest.map(|(case, _)| case)
    }

    /// Typical time over that of the fastest.
    #[must_use]
    pub fn over_fastest(&self, case: &Case, fastest: &Case) -> Option<Estimate> {
        let is_right = case.counts() && fastest.counts();
        over_typical(case, fastest, self.metric).filter(|_| is_right)
    }

    /// Time of `case` over time of `other`, paired by process.
    #[must_use]
    pub fn over(&self, case: &Case, other: &Case) -> Option<Estimate> {
        let is_right = case.counts() && other.counts();
        ratio(case, other, self.metric).filter(|_| is_right)
    }

    /// A row of a plot of typical times over another case's, without label, series and command.
    ///
    /// - `ratio`: or why there is none
    #[must_use]
    pub fn ratio_row(&self, case: &Case, ratio: Result<Estimate, String>) -> RatioRow {
        let typical = self.typical(case);
        // The ratio is of medians, so a process stands as far from it as its time from the median.
        let processes = ratio.as_ref().ok().zip(typical).map(|(ratio, typical)| {
            let times = self.replicates(case).into_iter();
            times
                .map(|time| ratio.middle * time / typical.middle)
                .collect()
        });
        let whisker = |ratio: Estimate| {
            let [p5, p95] = ratio.interval.unwrap_or([ratio.middle; 2]);
            let median = ratio.middle;
            Spread { p5, median, p95 }
        };
        RatioRow {
            label: String::new(),
            series: String::new(),
            ratio: ratio.map(whisker),
            processes: processes.unwrap_or_default(),
            value: typical.map_or_else(String::new, |time| {
                format!(" · {} ms", significant(time.middle))
            }),
            command: String::new(),
        }
    }

    /// Whether two times of this ratio differ by no more than identical work did.
    #[must_use]
    pub fn is_tie(&self, ratio: f64) -> bool {
        self.noise.is_some_and(|noise| noise.is_tie(ratio))
    }

    /// What in a case's times contradicts that they were measured.
    #[must_use]
    pub fn contradiction(&self, case: &Case) -> Option<String> {
        let samples = case.samples(self.metric).into_iter().flatten();
        let times: Vec<f64> = samples.flat_map(|(_, of)| of.values().copied()).collect();
        let usable = times.iter().filter(|ms| ms.is_finite() && **ms > 0.0);
        let (name, all, lost) = (case.id(), times.len(), times.len() - usable.count());
        (lost > 0).then(|| {
            format!("{name}: {lost} of {all} times are 0, negative or not finite; left out")
        })
    }

    /// A ratio with its interval, and whether it is a tie.
    #[must_use]
    pub fn ratio_text(&self, ratio: &Estimate) -> String {
        let tie = if self.is_tie(ratio.middle) {
            " (tie)"
        } else {
            ""
        };
        format!("{}{tie}", times(ratio))
    }

    /// The same as a cell.
    #[must_use]
    pub fn ratio_cell(&self, ratio: Option<&Estimate>, why: impl Into<String>) -> Cell {
        Cell::or_absent(ratio.map(|ratio| self.ratio_text(ratio)), why)
    }
}

/// What is taken as no difference, in a sentence. A band narrower than the intervals of identical work reach could not
/// call identical work no difference.
#[must_use]
pub fn band_sentence(noise: Option<Noise>) -> String {
    let percent = significant(100.0 * (Noise::band(noise) - 1.0));
    let because = noise.map_or_else(
        || "this run measured no identical work twice".to_owned(),
        |noise| {
            format!(
                "so far the intervals of identical work reached in this run, measured twice under {} names",
                noise.pairs
            )
        },
    );
    format!("Less than {percent} % either way is no difference: {because}.")
}

/// Sums over cases by process, of the processes that measured all of them.
#[must_use]
pub(crate) fn sums_by_process(cases: &[&Case], metric: &Metric) -> BTreeMap<u32, f64> {
    let medians = cases.iter().map(|case| process_medians(case, metric));
    let medians: Vec<BTreeMap<u32, f64>> = medians.collect();
    let processes = medians.first().into_iter().flat_map(BTreeMap::keys);
    let sums = processes.filter_map(|process| {
        let of_cases = medians.iter().map(|own| own.get(process));
        Some((*process, of_cases.sum::<Option<f64>>()?))
    });
    sums.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{TIME, empty};
    use terrafill_results::Status;
    use terrafill_results::made_up::case_id;

    #[test]
    fn what_is_not_right_ranks_nowhere_and_a_gap_within_the_noise_is_a_tie() {
        let mut made = empty();
        for (name, ms) in [("slow", 2.0), ("fast", 1.0), ("wrong", 0.1)] {
            made.case(case_id("study", name, &[("way", name)]))
                .timed(TIME, &[ms; 5]);
        }
        made.cases[2].ended(Status::Wrong, "9 px");
        let again = made.cases[1].id.repeat();
        made.case(again).timed(TIME, &[1.1; 5]);
        let run = made.loaded();
        let timings = Timings {
            metric: TIME,
            noise: Noise::of(run.of_study("study"), TIME),
        };
        let [slow, fast, wrong] = [0, 1, 2].map(|place: usize| &run.cases[place]);
        let fastest = timings.fastest(run.of_study("study"));
        assert!(fastest.is_some_and(|case| case.id() == fast.id()));
        let over = timings.over(slow, fast).expect("both right");
        assert_eq!(timings.ratio_text(&over), "2.00 × [2.00–2.00]");
        assert!(timings.is_tie(1.05));
        // Negative controls: a wrong case has no ratio either way round, and a wide gap is no tie.
        let of_wrong = [timings.over(wrong, fast), timings.over(fast, wrong)];
        assert_eq!(of_wrong, [None, None]);
        assert_eq!(timings.over_fastest(wrong, fast), None);
        let row = |case| {
            let over = timings.over_fastest(case, fast);
            timings.ratio_row(case, over.ok_or_else(|| "wrong".to_owned()))
        };
        assert_eq!(
            (row(slow).processes, row(slow).value),
            (vec![2.0; 5], " · 2.00 ms".to_owned())
        );
        assert_eq!(
            (row(wrong).ratio, row(wrong).value),
            (Err("wrong".to_owned()), String::new())
        );
        assert!(!timings.is_tie(2.0));
        assert_eq!(timings.contradiction(slow), None);
        made.cases[0].timed(TIME, &[2.0, 0.0]);
        let run = made.loaded();
        let found = timings.contradiction(&run.cases[0]).expect("a time of 0");
        assert!(found.contains("1 of 2 times are 0"), "{found}");
        assert!(band_sentence(None).ends_with("measured no identical work twice."));
        assert!(band_sentence(timings.noise).contains("measured twice under 1 names"));
    }

    #[test]
    fn a_process_counts_where_it_measured_every_case() {
        let mut made = empty();
        for (name, times) in [("both", &[1.0, 2.0][..]), ("first", &[4.0])] {
            made.case(case_id("study", name, &[("way", name)]))
                .timed(TIME, times);
        }
        let run = made.loaded();
        let sums = |cases: &[&Case]| sums_by_process(cases, TIME).into_values().collect();
        let [both, first] = [0, 1].map(|place: usize| &run.cases[place]);
        let found: Vec<f64> = sums(&[both, first]);
        assert_eq!(found, [5.0]);
        // Negative control: without the case that one process lacks, both have a sum.
        let found: Vec<f64> = sums(&[both]);
        assert_eq!(found, [1.0, 2.0]);
    }
}
