// SPDX-License-Identifier: MIT OR Apache-2.0
//! Claims of a document, tested by cases of a study. Conditions select the cases. A test is a ratio of two cases,
//! figures within a bound, an exponent of growth, a finding of the chapter, or what needs no run: a sum, or a figure of
//! a page that a test computes. What differs between studies is data.

use crate::cases::{Cases, log_slope, measured, range};
use crate::claims::{ClaimAnswer, Paper, PaperError, Tested, claims_blocks, claims_table};
use crate::comparison::{Answer, Comparison, Follows, overall, sentences};
use crate::page_claims::{Bound, ClaimSum, PageFigure};
use crate::settling::bench_command;
use crate::timings::{band_sentence, sums_by_process};
use serde::Deserialize;
use std::collections::BTreeMap;
use terrafill_plot::number::{figure, significant, times};
use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{
    Block, Case, ChapterError, Claim, Clock, DerivedTable, Estimate, Finding, Kind, Metric, Noise,
    Outcome, Scope, Standing, over_processes, process_medians, typical,
};

/// Conditions by name, each with the values that fit.
type Conditions = BTreeMap<String, Vec<String>>;

/// Two cases that differ in one condition.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CaseRatio {
    /// Which figure: a metric by its name, or a time as the study calls it.
    pub figure: String,
    /// The condition that differs.
    pub changes: String,
    /// Its values: the first's figure over the second's.
    pub of: [String; 2],
    /// Which cases.
    pub with: Conditions,
    /// Conditions that name a pair.
    #[serde(default)]
    pub named_by: Vec<String>,
    /// Conditions that follow from the change, each with why.
    #[serde(default)]
    pub follows: BTreeMap<String, String>,
    /// Whether figures are added up over all pairs, so that one ratio is of all of them.
    #[serde(default)]
    pub is_summed: bool,
    /// Of the ratio.
    pub expects: Claim,
}

/// A figure of cases, all of which must be within a bound.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CaseFigures {
    /// As of [`CaseRatio`].
    pub figure: String,
    /// Which cases.
    pub with: Conditions,
    /// Where all must lie.
    pub is: Bound,
}

/// The exponent by which a figure grows with a condition that is a number.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct CaseGrowth {
    /// As of [`CaseRatio`].
    pub figure: String,
    /// The condition that grows.
    pub over: String,
    /// Which cases.
    pub with: Conditions,
    /// Conditions that name a series.
    #[serde(default)]
    pub named_by: Vec<String>,
    /// Where the exponent must lie.
    pub between: [f64; 2],
}

/// How a claim is tested by cases.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum CaseTest {
    /// By the ratio of two cases, in each pair that a run has.
    Ratio(CaseRatio),
    /// By figures.
    Figures(CaseFigures),
    /// By growth.
    Growth(CaseGrowth),
    /// By the finding of the chapter whose claim has these words.
    Finding(String),
    /// By arithmetic alone.
    Sum(ClaimSum),
    /// By a figure of the study's page that tests compute.
    Page(PageFigure),
    /// Not at all, and why or what would.
    No(String),
}

impl Tested for CaseTest {
    fn expects(&self) -> Option<Claim> {
        match self {
            Self::Ratio(ratio) => Some(ratio.expects),
            _ => None,
        }
    }

    fn cannot(&self) -> Option<&str> {
        match self {
            Self::No(why) => Some(why),
            _ => None,
        }
    }
}

/// A time by a name that claims use, which the clock of a run picks.
#[derive(Debug, Clone, Copy)]
pub struct ClaimedTime {
    /// In files.
    pub name: &'static str,
    /// Where a GPU does the work, and where the CPU does.
    pub by: [&'static Metric; 2],
    /// What it must cover.
    pub needs: Scope,
}

/// A document's claims that a study tests.
#[derive(Debug, Clone, Copy)]
pub struct StudyClaims {
    /// The study, by whose name the claims are its own.
    pub study: &'static str,
    /// Heading of the section.
    pub title: &'static str,
    /// The file's name, for errors, and its text.
    pub file: [&'static str; 2],
    /// Times that are compared; the first one says what is no difference.
    pub times: &'static [ClaimedTime],
    /// What the study measures.
    pub metrics: &'static [Metric],
    /// What its chapter finds, for claims that rest on it.
    pub findings: fn(&Cases<'_>) -> Vec<Finding>,
    /// The page's name, and its text with tables of figures that a test of the study computes; empty for none.
    pub page: [&'static str; 2],
}

/// Each pair, series or figure of a claim, and what it says.
type Views = Vec<(String, Standing)>;

/// A claim's cases.
struct Evidence<'c, 'a> {
    claims: &'c StudyClaims,
    cases: &'c Cases<'a>,
}

impl StudyClaims {
    /// The study's own claims.
    ///
    /// # Errors
    /// [`PaperError`] for a file that cannot be used.
    pub fn paper(&self) -> Result<Paper<CaseTest>, PaperError> {
        let [file, text] = self.file;
        let mut paper: Paper<CaseTest> = Paper::parse(file, text)?;
        paper.claims.retain(|claimed| claimed.study == self.study);
        Ok(paper)
    }

    fn read(&self) -> Result<Paper<CaseTest>, ChapterError> {
        self.paper().map_err(|error| ChapterError::Block {
            what: self.title.to_owned(),
            message: error.to_string(),
        })
    }

    fn answered(
        &self,
        cases: &Cases<'_>,
    ) -> Result<(Paper<CaseTest>, Vec<ClaimAnswer>), ChapterError> {
        let paper = self.read()?;
        let evidence = Evidence {
            claims: self,
            cases,
        };
        let environment = &cases.run().environment;
        let answers = paper.answers(environment, self.study, |test| evidence.answer(test));
        Ok((paper, answers))
    }

    /// The section.
    ///
    /// # Errors
    /// [`ChapterError`] for a file that cannot be used.
    pub fn blocks(&self, cases: &Cases<'_>) -> Result<Vec<Block>, ChapterError> {
        let (paper, answers) = self.answered(cases)?;
        let noise = self
            .times
            .first()
            .and_then(|time| cases.noise(time.of(cases.clock())));
        Ok(claims_blocks(
            self.title,
            &paper,
            &answers,
            &band_sentence(noise),
        ))
    }

    /// The same as data, `claims-STUDY.csv`.
    ///
    /// # Errors
    /// [`ChapterError`] for a file that cannot be used or a table that cannot be written.
    pub fn table(&self, cases: &Cases<'_>) -> Result<DerivedTable, ChapterError> {
        let (paper, answers) = self.answered(cases)?;
        claims_table(&format!("claims-{}.csv", self.study), &paper, &answers)
    }

    /// Claims whose test names a figure that the study does not measure, or selects none of these cases.
    ///
    /// # Errors
    /// [`PaperError`] for a file that cannot be used.
    pub fn untestable(&self, cases: &Cases<'_>) -> Result<Vec<String>, PaperError> {
        let evidence = Evidence {
            claims: self,
            cases,
        };
        let claims = self.paper()?.claims.into_iter();
        let wrong = claims.filter(|claimed| !evidence.is_testable(&claimed.test));
        Ok(wrong.map(|claimed| claimed.words).collect())
    }
}

impl ClaimedTime {
    fn of(&self, clock: Clock) -> &'static Metric {
        let [gpu, cpu] = self.by;
        clock.pick(gpu, cpu)
    }
}

fn fits(case: &Case, with: &Conditions) -> bool {
    let mut with = with.iter();
    with.all(|(key, values)| {
        values
            .iter()
            .any(|value| case.condition_named(key) == value)
    })
}

/// Values of some conditions, those that a case has.
fn title(case: &Case, named_by: &[String]) -> String {
    let values = named_by.iter().map(|key| case.condition_named(key));
    let values: Vec<&str> = values.filter(|value| !value.is_empty()).collect();
    values.join(" ")
}

/// A figure after what it is of.
fn named(of: &str, figure: String) -> String {
    match of {
        "" => figure,
        of => format!("{of}: {figure}"),
    }
}

impl<'a> Evidence<'_, 'a> {
    fn metric(&self, name: &str) -> Option<(&'static Metric, Scope)> {
        let time = self.claims.times.iter().find(|time| time.name == name);
        let time = time.map(|time| (time.of(self.cases.clock()), time.needs));
        let metric = || {
            self.claims
                .metrics
                .iter()
                .find(|metric| metric.name == name)
        };
        time.or_else(|| metric().map(|metric| (metric, Scope::default())))
    }

    fn selected(&self, with: &Conditions) -> Vec<&'a Case> {
        self.cases.iter().filter(|case| fits(case, with)).collect()
    }

    /// Cases of both values, alike but for what may differ.
    fn pairs(&self, ratio: &CaseRatio) -> Vec<[&'a Case; 2]> {
        let rest = |case: &'a Case| {
            let all = case.id().conditions.iter();
            let rest = all
                .filter(|(key, _)| **key != *ratio.changes && !ratio.follows.contains_key(&**key));
            rest.collect::<Vec<_>>()
        };
        let own = self.selected(&ratio.with);
        let of = |value: &str| {
            let of = own
                .iter()
                .filter(|case| case.condition_named(&ratio.changes) == value);
            of.copied().collect::<Vec<_>>()
        };
        let [firsts, seconds] = [of(&ratio.of[0]), of(&ratio.of[1])];
        let pair = |first: &'a Case| {
            let second = seconds.iter().find(|second| rest(second) == rest(first))?;
            Some([first, *second])
        };
        firsts.into_iter().filter_map(pair).collect()
    }

    /// Cases of each series.
    fn series(&self, growth: &CaseGrowth) -> Vec<(String, Vec<&'a Case>)> {
        let own = self.selected(&growth.with);
        crate::cases::grouped(own, |case| title(case, &growth.named_by))
    }

    fn is_testable(&self, test: &CaseTest) -> bool {
        let is_known = |figure: &str| self.metric(figure).is_some();
        match test {
            CaseTest::Ratio(ratio) => is_known(&ratio.figure) && !self.pairs(ratio).is_empty(),
            CaseTest::Figures(of) => is_known(&of.figure) && !self.selected(&of.with).is_empty(),
            CaseTest::Growth(growth) => {
                let series = self.series(growth);
                let is_long = |(_, cases): &(String, Vec<&Case>)| cases.len() >= 3;
                is_known(&growth.figure) && !series.is_empty() && series.iter().all(is_long)
            }
            CaseTest::Finding(words) => self.finding(words).is_ok(),
            CaseTest::Sum(_) | CaseTest::No(_) => true,
            CaseTest::Page(of) => of.figure(self.claims.page[1]).is_ok(),
        }
    }

    /// The one finding whose claim has these words.
    ///
    /// # Errors
    /// How many have them.
    fn finding(&self, words: &str) -> Result<Finding, usize> {
        let found = (self.claims.findings)(self.cases).into_iter();
        let found = found.filter(|finding| finding.claim.contains(words));
        let found: Vec<Finding> = found.collect();
        let [one] = <[Finding; 1]>::try_from(found).map_err(|found| found.len())?;
        Ok(one)
    }

    fn answer(&self, test: &CaseTest) -> ClaimAnswer {
        let unknown = |name: &str| {
            let why = format!("no figure is called {name:?}");
            ClaimAnswer::unanswered(Standing::CannotBeTested, &why)
        };
        match test {
            CaseTest::Ratio(of) => match self.metric(&of.figure) {
                Some(metric) => self.ratio(of, metric),
                None => unknown(&of.figure),
            },
            CaseTest::Figures(of) => match self.metric(&of.figure) {
                Some((metric, _)) => self.figures(of, metric),
                None => unknown(&of.figure),
            },
            CaseTest::Growth(of) => match self.metric(&of.figure) {
                Some((metric, _)) => self.growth(of, metric),
                None => unknown(&of.figure),
            },
            CaseTest::Finding(words) => match self.finding(words) {
                Ok(found) if found.standing == Standing::NotMeasured => {
                    ClaimAnswer::unanswered(Standing::NotMeasured, "its rows are not in this run")
                }
                Ok(found) => ClaimAnswer {
                    ours: found.because,
                    standing: found.standing,
                    reason: self.open(found.standing),
                },
                Err(0) => {
                    let why = "no case of the finding is in this run";
                    ClaimAnswer::unanswered(Standing::NotMeasured, why)
                }
                Err(count) => {
                    let why = format!("{count} findings have the words {words:?}, allowed 1");
                    ClaimAnswer::unanswered(Standing::CannotBeTested, &why)
                }
            },
            CaseTest::Sum(sum) => sum.answer(),
            CaseTest::Page(of) => of.answer(self.claims.page),
            CaseTest::No(why) => ClaimAnswer::unanswered(Standing::CannotBeTested, why),
        }
    }

    fn ratio(&self, of: &CaseRatio, (metric, needs): (&'static Metric, Scope)) -> ClaimAnswer {
        let follows = of.follows.iter();
        let follows: Vec<Follows<'_>> = follows
            .map(|(key, because)| Follows { key, because })
            .collect();
        let comparison = Comparison {
            changed: &of.changes,
            follows: &follows,
            one_sided: None,
            metric,
            needs,
        };
        let all = self.pairs(of);
        // What a device cannot do says nothing of a claim, unless there is nothing else.
        let is_skipped =
            |pair: &&[&Case; 2]| pair.iter().any(|case| case.outcome == Outcome::Skipped);
        let able: Vec<[&Case; 2]> = all
            .iter()
            .filter(|pair| !is_skipped(pair))
            .copied()
            .collect();
        let skipped = all.len() - able.len();
        let (pairs, left_out) = match (able.is_empty(), skipped) {
            (false, 1..) => (
                able,
                format!("{skipped} pairs left out, which the device or this depth does not have"),
            ),
            _ => (all, String::new()),
        };
        let own = self.cases.fitting(|case| fits(case, &of.with));
        let noise = own.noise(metric);
        let judged = pairs.iter().map(|pair| {
            let judged = comparison.judge(self.cases.run(), *pair, of.expects, noise);
            judged.unwrap_or_else(Answer::from)
        });
        let answers: Vec<Answer> = judged.collect();
        let is_time = metric.kind == Kind::Time;
        let text = |figure: &Estimate| {
            if is_time {
                times(figure)
            } else {
                format!("{} ×", significant(figure.middle))
            }
        };
        if of.is_summed {
            let standings: Vec<Standing> = answers.iter().map(|answer| answer.standing).collect();
            let is_open = matches!(
                overall(&standings),
                Standing::NotMeasured | Standing::CannotBeTested
            );
            if let Some(sum) = summed(&pairs, metric).filter(|_| !is_open) {
                let band = if is_time { Noise::band(noise) } else { 1.0 };
                let standing = of.expects.standing_beyond(&sum, band);
                let said = format!("{} over {} pairs", text(&sum), pairs.len());
                let reason = sentences([left_out, self.open(standing)]);
                return ClaimAnswer::of_views(vec![(said, standing)], reason);
            }
        }
        let views = pairs.iter().zip(&answers).map(|([first, _], answer)| {
            let ours = answer
                .figure
                .as_ref()
                .map_or_else(|| answer.standing.name().to_owned(), text);
            let title = title(first, &of.named_by);
            (named(&title, ours), answer.standing)
        });
        let open = answers.iter().find(|answer| !answer.because.is_empty());
        let because = open
            .map(|answer| answer.because.clone())
            .unwrap_or_default();
        let compared = format!("{} ÷ {}", of.of[0], of.of[1]);
        ClaimAnswer::of_views(views.collect(), sentences([compared, left_out, because]))
    }

    fn figures(&self, of: &CaseFigures, metric: &'static Metric) -> ClaimAnswer {
        let own = self.selected(&of.with);
        let mut views: Views = Vec::new();
        if metric.kind == Kind::Time {
            let counted = own.iter().filter(|case| case.counts());
            let typical = counted.filter_map(|case| typical(case, metric));
            let said = typical.map(|of_case| {
                let text = format!("{} {}", figure(&of_case), metric.unit);
                (text, of.is.standing(of_case.interval))
            });
            views.extend(said);
        } else {
            let values: Vec<f64> = own
                .iter()
                .filter_map(|case| measured(case, metric))
                .collect();
            let are_all = values.iter().all(|value| of.is.holds(*value));
            let said = range(&values).map(|range| {
                let text = format!("{range} {} in {} cases", metric.unit, values.len());
                (text.replace("  ", " "), Standing::holds_if(are_all))
            });
            views.extend(said);
        }
        if !views.is_empty() {
            views.extend(open_view("", &own, metric));
        }
        let standings: Vec<Standing> = views.iter().map(|(_, standing)| *standing).collect();
        ClaimAnswer::of_views(views, self.open(overall(&standings)))
    }

    fn growth(&self, of: &CaseGrowth, metric: &'static Metric) -> ClaimAnswer {
        let views = self.series(of).into_iter().flat_map(|(name, cases)| {
            let Some(exponent) = exponent(&cases, &of.over, metric) else {
                return Vec::new();
            };
            let standing = Bound::Between(of.between).standing(exponent.interval);
            let text = format!("exponent {}", figure(&exponent));
            let open = open_view(&name, &cases, metric);
            std::iter::once((named(&name, text), standing))
                .chain(open)
                .collect()
        });
        let views: Views = views.collect();
        let standings: Vec<Standing> = views.iter().map(|(_, standing)| *standing).collect();
        ClaimAnswer::of_views(views, self.open(overall(&standings)))
    }

    /// What would settle an open answer.
    fn open(&self, standing: Standing) -> String {
        if standing != Standing::CannotTell {
            return String::new();
        }
        let environment = &self.cases.run().environment;
        let command = bench_command(environment, self.claims.study, "", 2 * MIN_REPLICATES);
        format!(
            "Undecided: the interval reaches beyond the bound, or there is none. To settle it: {command}"
        )
    }
}

/// What cases that broke off, or whose times count for nothing, leave open: others alone decide no claim. What a device
/// cannot do says nothing of it.
fn open_view(of: &str, cases: &[&Case], metric: &'static Metric) -> Option<(String, Standing)> {
    let is_open = |case: &&&Case| {
        let is_told = match metric.kind {
            Kind::Time => case.counts(),
            _ => measured(case, metric).is_some(),
        };
        !is_told && case.outcome != Outcome::Skipped
    };
    let open = cases.iter().filter(is_open).count();
    (open > 0).then(|| {
        let text = format!("{open} of {} cases told nothing", cases.len());
        (named(of, text), Standing::CannotTell)
    })
}

/// Figures of the first cases over those of the second, each added up.
fn summed(pairs: &[[&Case; 2]], metric: &'static Metric) -> Option<Estimate> {
    let [first, second] =
        [0, 1].map(|at| pairs.iter().map(|pair| pair[at]).collect::<Vec<&Case>>());
    if metric.kind == Kind::Time {
        let [first, second] = [first, second].map(|cases| sums_by_process(&cases, metric));
        let ratios = first
            .iter()
            .filter_map(|(process, sum)| Some(sum / second.get(process)?));
        return over_processes(&ratios.collect::<Vec<f64>>());
    }
    let sum = |cases: &[&Case]| {
        cases
            .iter()
            .map(|case| measured(case, metric))
            .sum::<Option<f64>>()
    };
    let ratio = sum(&first)? / sum(&second)?;
    ratio.is_finite().then_some(Estimate::exact(ratio))
}

/// The exponent over a condition: of a time in each process, else of the figures; `None` below three cases.
fn exponent(cases: &[&Case], over: &str, metric: &'static Metric) -> Option<Estimate> {
    let number = |case: &Case| case.condition_named(over).parse::<f64>().ok();
    if metric.kind != Kind::Time {
        let points = cases
            .iter()
            .filter_map(|case| Some((number(case)?, measured(case, metric)?)));
        return log_slope(points).map(Estimate::exact);
    }
    let counted = cases.iter().filter(|case| case.counts());
    let medians: Vec<(f64, BTreeMap<u32, f64>)> = counted
        .filter_map(|case| Some((number(case)?, process_medians(case, metric))))
        .collect();
    let processes = medians.first()?.1.keys();
    let slopes = processes.filter_map(|process| {
        let points = medians
            .iter()
            .map(|(x, own)| Some((*x, *own.get(process)?)));
        log_slope(points.collect::<Option<Vec<_>>>()?)
    });
    over_processes(&slopes.collect::<Vec<f64>>())
}

#[cfg(test)]
mod tests;
