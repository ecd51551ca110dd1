// SPDX-License-Identifier: MIT OR Apache-2.0
//! A study's cases in a run, as its chapter reads them.

use crate::budget::some_of;
use crate::comparison::Comparison;
use std::collections::BTreeMap;
use terrafill_plot::number::{count, significant};
use terrafill_results::{
    Block, Case, Claim, Clock, ConditionKey, Finding, Kind, Metric, Noise, Outcome, Run, Standing,
    ratio,
};

/// What a case has of a metric. A time counts only where all planned samples were taken: those of a case that broke off
/// are no measurement.
#[must_use]
pub fn measured(case: &Case, metric: &Metric) -> Option<f64> {
    let is_whole = matches!(case.outcome, Outcome::Ok | Outcome::Wrong);
    let value = case.value(metric);
    value.filter(|_| is_whole || metric.kind != Kind::Time)
}

/// Cases of a run, without those that repeat another, in the plan's order.
#[derive(Debug, Clone)]
pub struct Cases<'a> {
    run: &'a Run,
    /// With repeats, for the noise.
    all: Vec<&'a Case>,
}

/// The case whose figure is least, and those that may be as good.
#[derive(Debug, Clone)]
pub struct Best<'a> {
    /// It.
    pub case: &'a Case,
    /// Its figure.
    pub value: f64,
    /// Others whose figure differs by no more than identical work did.
    pub ties: Vec<&'a Case>,
}

impl Best<'_> {
    /// What a sentence adds after its name: `, tied with a and b`; empty for no ties.
    #[must_use]
    pub fn tied_with(&self, name: impl Fn(&Case) -> String) -> String {
        let names: Vec<String> = self.ties.iter().map(|case| name(case)).collect();
        match names.split_last() {
            None => String::new(),
            Some((last, [])) => format!(", tied with {last}"),
            Some((last, others)) => format!(", tied with {} and {last}", others.join(", ")),
        }
    }
}

impl<'a> Cases<'a> {
    /// All of a study.
    #[must_use]
    pub fn of_study(run: &'a Run, study: &'a str) -> Self {
        Self {
            run,
            all: run.of_study(study).collect(),
        }
    }

    /// The run that they are of.
    #[must_use]
    pub fn run(&self) -> &'a Run {
        self.run
    }

    /// By which times are compared.
    #[must_use]
    pub fn clock(&self) -> Clock {
        self.run.clock()
    }

    /// Each of them.
    pub fn iter(&self) -> impl Iterator<Item = &'a Case> + Clone + '_ {
        self.all.iter().copied().filter(|case| !case.is_repeat())
    }

    /// The first one.
    #[must_use]
    pub fn first(&self) -> Option<&'a Case> {
        self.iter().next()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.first().is_none()
    }

    /// Those that fit.
    #[must_use]
    pub fn fitting(&self, fits: impl Fn(&Case) -> bool) -> Self {
        let all = self.all.iter().copied();
        Self {
            run: self.run,
            all: all.filter(|case| fits(case)).collect(),
        }
    }

    /// Those of which all these conditions hold.
    #[must_use]
    pub fn with(&self, conditions: &[(ConditionKey, &str)]) -> Self {
        self.fitting(|case| {
            let mut conditions = conditions.iter();
            conditions.all(|(key, value)| case.condition(*key) == *value)
        })
    }

    /// Values of a condition, in order of appearance.
    #[must_use]
    pub fn distinct(&self, key: ConditionKey) -> Vec<&'a str> {
        distinct(self.iter().map(|case| case.condition(key)))
    }

    /// Cases of each value of a condition, in order of appearance.
    #[must_use]
    pub fn by(&self, key: ConditionKey) -> Vec<(&'a str, Self)> {
        let values = self.distinct(key).into_iter();
        values
            .map(|value| (value, self.with(&[(key, value)])))
            .collect()
    }

    /// A metric's values, one a case that has it.
    #[must_use]
    pub fn values(&self, metric: &Metric) -> Vec<f64> {
        let values = self.iter().filter_map(|case| measured(case, metric));
        values.collect()
    }

    /// The first of them.
    #[must_use]
    pub fn value(&self, metric: &Metric) -> Option<f64> {
        self.values(metric).first().copied()
    }

    /// The least of them.
    #[must_use]
    pub fn least(&self, metric: &Metric) -> Option<f64> {
        self.values(metric).into_iter().min_by(f64::total_cmp)
    }

    /// The greatest of them.
    #[must_use]
    pub fn greatest(&self, metric: &Metric) -> Option<f64> {
        self.values(metric).into_iter().max_by(f64::total_cmp)
    }

    /// The case that counts whose figure, made of several metrics, is least.
    #[must_use]
    pub fn least_of(&self, of: impl Fn(&Case) -> Option<f64>) -> Option<(&'a Case, f64)> {
        let counted = self.iter().filter(|case| case.counts());
        let figures = counted.filter_map(|case| Some((case, of(case)?)));
        figures.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Their sum; `None` where nothing was measured, which is not 0.
    #[must_use]
    pub fn sum(&self, metric: &Metric) -> Option<f64> {
        let values = self.values(metric);
        (!values.is_empty()).then(|| values.iter().sum())
    }

    /// Their median.
    #[must_use]
    pub fn median(&self, metric: &Metric) -> Option<f64> {
        terrafill_results::median(&self.values(metric))
    }

    /// Values by a condition that is a number, in its rising order.
    #[must_use]
    pub fn series(&self, key: ConditionKey, metric: &Metric) -> Vec<(f64, f64)> {
        let pair = |case: &Case| Some((case.condition(key).parse().ok()?, measured(case, metric)?));
        let mut pairs: Vec<(f64, f64)> = self.iter().filter_map(pair).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        pairs
    }

    /// By how much identical work differed among them; where none of them was measured twice, in the whole study.
    #[must_use]
    pub fn noise(&self, metric: &Metric) -> Option<Noise> {
        let study = self.all.first().map_or("", |case| case.id().study.as_str());
        let all: Vec<&Case> = self.run.of_study(study).collect();
        let own = Noise::of(self.all.iter().copied(), metric);
        own.or_else(|| Noise::of(all.into_iter(), metric))
    }

    /// The case that counts whose figure is least, and which others tie with it.
    ///
    /// Two times tie unless the one is longer by more than identical work differed, by the interval of their ratio
    /// where there are processes enough for one, else by the ratio itself.
    #[must_use]
    pub fn best(&self, metric: &Metric) -> Option<Best<'a>> {
        let (best, value) = self.least_of(|case| case.value(metric))?;
        let noise = self.noise(metric);
        let ties_with = |case: &Case| match metric.kind {
            Kind::Time => ratio(case, best, metric).is_some_and(|gain| match gain.interval {
                Some(_) => {
                    Claim::Faster.standing_beyond(&gain, Noise::band(noise)) != Standing::Holds
                }
                None => gain.middle <= Noise::band(noise),
            }),
            _ => case.value(metric) == Some(value),
        };
        let others = self.iter().filter(|case| case.counts());
        let others = others.filter(|case| !std::ptr::eq(*case, best));
        Some(Best {
            case: best,
            value,
            ties: others.filter(|case| ties_with(case)).collect(),
        })
    }

    /// Which value of a condition takes least for each value of another, in a list of sentences; nothing where
    /// nothing was measured.
    ///
    /// - `least`: the condition, and what is least
    /// - `says`: how the sentence on a value of `each` begins
    #[must_use]
    pub fn least_of_each(
        &self,
        each: ConditionKey,
        (of, metric): (ConditionKey, &Metric),
        says: impl Fn(&str) -> String,
    ) -> Option<Block> {
        let sentence = |(value, own): &(&str, Self)| {
            let best = own.best(metric)?;
            let [says, least] = [says(value), significant(best.value)];
            let ties = best.tied_with(|case| case.condition(of).to_owned());
            let name = best.case.condition(of);
            Some(format!("{says} {name}, {least} {}{ties}.", metric.unit))
        };
        let sentences: Vec<String> = self.by(each).iter().filter_map(sentence).collect();
        (!sentences.is_empty()).then_some(Block::List(sentences))
    }

    /// Pairs that differ in `key`, the first with the first value and the second with the other, and in nothing else
    /// but `follows`.
    #[must_use]
    pub fn pairs(
        &self,
        key: ConditionKey,
        values: [&str; 2],
        follows: &[ConditionKey],
    ) -> Vec<[&'a Case; 2]> {
        let rest = |case: &'a Case| {
            let conditions = case.id().conditions.iter();
            let rest = conditions.filter(move |(name, _)| {
                let is_of = |key: &ConditionKey| key.name() == name.as_str();
                !is_of(&key) && !follows.iter().any(is_of)
            });
            rest.collect::<Vec<_>>()
        };
        let [first, second] = values.map(|value| self.with(&[(key, value)]));
        let pair = |case: &'a Case| {
            let other = second.iter().find(|other| rest(case) == rest(other));
            other.map(|other| [case, other])
        };
        first.iter().filter_map(pair).collect()
    }

    /// What pairs say of a claim on a time, by the noise of these cases.
    #[must_use]
    pub fn compared(
        &self,
        comparison: &Comparison<'_>,
        pairs: &[[&Case; 2]],
        says: Claim,
        claim: impl Into<String>,
    ) -> Finding {
        let noise = self.noise(comparison.metric);
        comparison.finding(self.run, pairs, says, claim.into(), noise)
    }
}

/// Items without repetitions, in order of appearance.
pub fn distinct<T: Ord + Clone>(items: impl IntoIterator<Item = T>) -> Vec<T> {
    let groups = grouped(items, T::clone).into_iter();
    groups.map(|(item, _)| item).collect()
}

/// Items of the same key together, in order of appearance.
pub fn grouped<T, K: Ord + Clone>(
    items: impl IntoIterator<Item = T>,
    key: impl Fn(&T) -> K,
) -> Vec<(K, Vec<T>)> {
    let mut places: BTreeMap<K, usize> = BTreeMap::new();
    let mut groups: Vec<(K, Vec<T>)> = Vec::new();
    for item in items {
        let key = key(&item);
        let place = *places.entry(key.clone()).or_insert(groups.len());
        if place == groups.len() {
            groups.push((key, Vec::new()));
        }
        groups[place].1.push(item);
    }
    groups
}

/// What each of these groups has, by its name in order of appearance, with a case of every group.
pub fn in_every_group<'a>(
    groups: &[Vec<&'a Case>],
    name: impl Fn(&Case) -> String,
) -> Vec<(String, Vec<&'a Case>)> {
    let names = distinct(groups.iter().flatten().map(|case| name(case))).into_iter();
    let found = names.filter_map(|wanted| {
        let of_group = |own: &Vec<&'a Case>| own.iter().copied().find(|case| name(case) == wanted);
        let of_groups: Option<Vec<&Case>> = groups.iter().map(of_group).collect();
        Some((wanted, of_groups?))
    });
    found.collect()
}

/// That nothing differs, with how many of all do not, and the first of those that do; not measured where there are
/// none.
///
/// - `differing`: each with what is wrong with it
/// - `what`: the others are and do, in words
#[must_use]
pub fn none_differs(claim: &str, all: usize, differing: &[String], what: &str) -> Finding {
    let [same, of] = [all - differing.len(), all].map(|number| count(number as u64));
    let because = match differing {
        [] => format!("{same} of {of} {what}"),
        some => format!("{same} of {of} {what}. Not: {}", some_of(some)),
    };
    finding(claim, (all > 0).then_some(differing.is_empty()), because)
}

/// What exact figures say of a claim; `None` where they were not measured. [`Cases::compared`] compares times.
#[must_use]
pub fn finding(
    claim: impl Into<String>,
    holds: Option<bool>,
    because: impl Into<String>,
) -> Finding {
    Finding {
        claim: claim.into(),
        standing: holds.map_or(Standing::NotMeasured, Standing::holds_if),
        because: because.into(),
    }
}

/// The exponent of a power law: the slope of log *y* over log *x* by least squares; `None` below three points.
///
/// - `points`: *x* and *y*, positive
#[must_use]
pub fn log_slope(points: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let logs = points.into_iter().map(|(x, y)| (x.ln(), y.ln()));
    let logs: Vec<(f64, f64)> = logs.collect();
    if logs.len() < 3 {
        return None;
    }
    let count = logs.len() as f64;
    let mean_x = logs.iter().map(|log| log.0).sum::<f64>() / count;
    let mean_y = logs.iter().map(|log| log.1).sum::<f64>() / count;
    let products = logs.iter().map(|log| (log.0 - mean_x) * (log.1 - mean_y));
    let squares = logs.iter().map(|log| (log.0 - mean_x).powi(2));
    Some(products.sum::<f64>() / squares.sum::<f64>())
}

/// `3.95 to 4.02`, or one number where both read alike; `None` of nothing.
#[must_use]
pub fn range(values: &[f64]) -> Option<String> {
    let least = values.iter().copied().min_by(f64::total_cmp)?;
    let most = values.iter().copied().max_by(f64::total_cmp)?;
    let [least, most] = [least, most].map(significant);
    Some(if least == most {
        least
    } else {
        format!("{least} to {most}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{TIME, empty};
    use terrafill_results::condition::{API, VIEW};
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Scope, Status};

    /// Two interfaces on two views; identical work differs by 2 %.
    fn run(processes: usize, vulkan_ms: f64) -> MadeUpRun {
        let mut run = empty();
        for view in ["globe", "horizon"] {
            for (api, ms) in [("wgpu", 1.0), ("vulkan", vulkan_ms)] {
                let name = format!("{view}/{api}");
                let id = case_id("study", &name, &[("view", view), ("api", api)]);
                run.case(id.repeat())
                    .timed(TIME, &vec![1.02 * ms; processes]);
                run.case(id).timed(TIME, &vec![ms; processes]);
            }
        }
        run
    }

    fn with<R>(made: &MadeUpRun, look: impl Fn(&Cases<'_>) -> R) -> R {
        look(&Cases::of_study(&made.loaded(), "study"))
    }

    #[test]
    fn cases_are_found_by_conditions_and_paired_by_one() {
        with(&run(5, 2.0), |cases| {
            assert_eq!(cases.iter().count(), 4, "no repeats");
            assert_eq!(cases.distinct(VIEW), ["globe", "horizon"]);
            assert_eq!(cases.with(&[(API, "vulkan")]).values(TIME), [2.0, 2.0]);
            let pairs = cases.pairs(API, ["vulkan", "wgpu"], &[]);
            assert_eq!(pairs.len(), 2);
            assert!(
                pairs
                    .iter()
                    .all(|[a, b]| a.condition(VIEW) == b.condition(VIEW))
            );
            let views = cases.by(VIEW).into_iter();
            let views = views.map(|(_, own)| own.iter().collect());
            let mut views: Vec<Vec<&Case>> = views.collect();
            let names = |views: &[Vec<&Case>]| {
                let found = in_every_group(views, |case| case.condition(API).to_owned());
                found
                    .into_iter()
                    .map(|(name, own)| format!("{name} {}", own.len()))
                    .collect()
            };
            let both: Vec<String> = names(&views);
            assert_eq!(both, ["wgpu 2", "vulkan 2"]);
            // Negative control: what one group lacks is left out.
            views[1].pop();
            let one: Vec<String> = names(&views);
            assert_eq!(one, ["wgpu 2"]);
            let comparison = Comparison {
                changed: API.name(),
                follows: &[],
                one_sided: None,
                metric: TIME,
                needs: Scope::DRAW,
            };
            let of = |says| {
                cases
                    .compared(&comparison, &pairs, says, "wgpu takes less")
                    .standing
            };
            assert_eq!(of(Claim::Faster), Standing::Holds);
            assert_eq!(of(Claim::NoDifference), Standing::DoesNotHold);
        });
    }

    #[test]
    fn the_least_is_alone_beyond_the_noise_and_ties_within_it() {
        let ties = |processes, ms| {
            with(&run(processes, ms), |cases| {
                let best = cases.with(&[(VIEW, "globe")]).best(TIME).expect("a best");
                let tied = best.tied_with(|case| case.condition(API).to_owned());
                (best.case.condition(API).to_owned(), tied)
            })
        };
        for processes in [1, 5] {
            assert_eq!(
                ties(processes, 1.01),
                ("wgpu".to_owned(), ", tied with vulkan".to_owned())
            );
            assert_eq!(ties(processes, 1.5), ("wgpu".to_owned(), String::new()));
        }
        // Negative control: what failed is not the best.
        let mut failed = run(5, 0.5);
        failed.cases[3].ended(Status::Failed, "lost");
        let best = with(&failed, |cases| {
            let best = cases.with(&[(VIEW, "globe")]).best(TIME).expect("a best");
            best.case.condition(API).to_owned()
        });
        assert_eq!(best, "wgpu");
    }

    #[test]
    fn a_sentence_names_the_least_of_each_and_nothing_is_said_of_nothing() {
        let said = |made: &MadeUpRun| {
            let says = |view: &str| format!("From {view}, least by");
            with(made, |cases| cases.least_of_each(VIEW, (API, TIME), says))
        };
        let sentences =
            ["globe", "horizon"].map(|view| format!("From {view}, least by wgpu, 1.00 ms."));
        assert_eq!(said(&run(5, 2.0)), Some(Block::List(sentences.into())));
        // Negative control: no time, no sentence.
        let mut none = run(5, 2.0);
        for case in &mut none.cases {
            case.ended(Status::Skipped, "no such device");
        }
        assert_eq!(said(&none), None);
    }

    #[test]
    fn items_are_grouped_in_order_of_appearance_and_one_that_differs_is_seen() {
        let groups = grouped(["b1", "a1", "b2"], |item| item.chars().next());
        assert_eq!(
            groups,
            [(Some('b'), vec!["b1", "b2"]), (Some('a'), vec!["a1"])]
        );
        assert_eq!(distinct([2, 1, 2]), [2, 1]);
        let of = |all, differing: &[&str]| {
            let differing: Vec<String> = differing.iter().map(ToString::to_string).collect();
            none_differs("All agree", all, &differing, "cases do")
        };
        assert_eq!(of(3, &[]).standing, Standing::Holds);
        assert_eq!(of(3, &[]).because, "3 of 3 cases do");
        // Negative controls: one that differs, and nothing that was compared.
        assert_eq!(of(3, &["a: 1"]).standing, Standing::DoesNotHold);
        assert_eq!(of(3, &["a: 1"]).because, "2 of 3 cases do. Not: a: 1");
        assert_eq!(of(0, &[]).standing, Standing::NotMeasured);
    }

    #[test]
    fn exact_figures_that_were_not_measured_decide_nothing() {
        let of = |holds| finding("It is exact", holds, "").standing;
        assert_eq!(of(Some(true)), Standing::Holds);
        assert_eq!(of(Some(false)), Standing::DoesNotHold);
        assert_eq!(of(None), Standing::NotMeasured);
        let squares = [1.0, 2.0, 4.0].map(|x: f64| (x, 5.0 * x * x));
        let slope = log_slope(squares).expect("three points");
        assert!((slope - 2.0).abs() < 1e-12, "{slope}");
        assert_eq!(log_slope(squares[..2].iter().copied()), None);
        assert_eq!(range(&[2.0, 1.0]).as_deref(), Some("1.00 to 2.00"));
        assert_eq!(range(&[2.0]).as_deref(), Some("2.00"));
        assert_eq!(range(&[]), None);
    }
}
