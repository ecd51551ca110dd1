// SPDX-License-Identifier: MIT OR Apache-2.0
//! Two cases that differ in one condition, and what is asked of them.
//!
//! A [`Comparison`] names the condition that the question changes, and those that follow from it. What
//! would answer another question is refused: a pair that differs in a further condition, a time that does
//! not cover what is compared, and process CPU time for a GPU's work. A refusal is an error of the program.
//! A page says so, and a test over the full plans of all studies allows none.

use crate::settling::bench_command;
use terrafill_plot::number::times;
use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{
    Case, Claim, Clock, Estimate, Finding, Kind, Metric, Noise, Outcome, REPEATS, Run, Scope,
    Standing, Timer, ratio,
};

/// Most processes that a command asks for: beyond, a quieter machine decides sooner than more of them.
const MAX_PROCESSES: usize = 30;

/// A condition that changes because the compared one does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Follows<'a> {
    /// The condition.
    pub key: &'a str,
    /// Why it is no second change.
    pub because: &'a str,
}

/// What may differ between two cases, and what is compared of them.
#[derive(Debug, Clone, Copy)]
pub struct Comparison<'a> {
    /// The one condition that differs.
    pub changed: &'a str,
    /// Conditions that may differ with it.
    pub follows: &'a [Follows<'a>],
    /// Why a condition that only one of the two has is no second change, such as a switch of one of two
    /// techniques. `None`: it is one.
    pub one_sided: Option<&'a str>,
    /// What is compared.
    pub metric: &'static Metric,
    /// What a time must cover for the question; nothing for what is no time.
    pub needs: Scope,
}

/// Why two cases cannot be compared so: an error of the program that asks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// More than the question changes, or nothing of it.
    #[error("{first} and {second} are compared in {changed:?}, and {problem}")]
    Pair {
        /// Key of the case.
        first: String,
        /// Key of the other.
        second: String,
        /// What the question changes.
        changed: String,
        /// What differs beside it, with both values, or the value that they share.
        problem: String,
    },
    /// A time of another part of the frame, or by another device's clock.
    #[error("{metric} {problem}")]
    Time {
        /// The time.
        metric: &'static str,
        /// What it is, what is compared, and what would do.
        problem: String,
    },
}

/// What a pair says of a claim.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The first over the second, with its interval; an exact figure has one of no width. `None` where
    /// either was not measured.
    pub figure: Option<Estimate>,
    /// Of the claim.
    pub standing: Standing,
    /// Why it is open, with the command that would settle it; empty for what is decided.
    pub because: String,
}

/// How a page begins what it says of a comparison that was refused; a test looks for it over all chapters.
pub const REFUSED: &str = "Refused, an error of this program:";

impl From<Refused> for Answer {
    /// Said in its place on the page, so that one faulty question does not cost the report of a run.
    fn from(refused: Refused) -> Self {
        Self {
            figure: None,
            standing: Standing::CannotBeTested,
            because: format!("{REFUSED} {refused}."),
        }
    }
}

impl Answer {
    /// Of a question without two cases.
    #[must_use]
    pub fn not_measured(why: &str) -> Self {
        Self {
            figure: None,
            standing: Standing::NotMeasured,
            because: why.to_owned(),
        }
    }
}

impl Comparison<'_> {
    /// What two cases say of a claim on the first's figure over the second's.
    ///
    /// - `noise`: by how much identical work differed in this metric, in the group that the pair is of
    ///
    /// # Errors
    /// [`Refused`] where the ratio would answer another question.
    pub fn judge(
        &self,
        run: &Run,
        [first, second]: [&Case; 2],
        claim: Claim,
        noise: Option<Noise>,
    ) -> Result<Answer, Refused> {
        self.check_metric(run.clock())?;
        self.check_pair([first, second])?;
        let open = |standing, why: &str, processes: usize| {
            let scene = first.condition_named("scene");
            let study = &first.id().study;
            let command = bench_command(&run.environment, study, scene, processes);
            Answer {
                figure: None,
                standing,
                because: format!("{why} To settle it: {command}"),
            }
        };
        if let Some(case) = [first, second].into_iter().find(|case| !is_measured(case)) {
            let ended = match case.reason.as_str() {
                "" => case.outcome.name(),
                reason => reason,
            };
            let why = format!("Not measured: {}, {ended}.", case.id());
            return Ok(open(Standing::NotMeasured, &why, MIN_REPLICATES));
        }
        let (figure, band) = if self.metric.kind == Kind::Time {
            (ratio(first, second, self.metric), Noise::band(noise))
        } else {
            (exact(first, second, self.metric), 1.0)
        };
        let Some(figure) = figure else {
            let why = format!("Not measured: {} of both.", self.metric.name);
            return Ok(open(Standing::NotMeasured, &why, MIN_REPLICATES));
        };
        let standing = claim.standing_beyond(&figure, band);
        let (why, processes) = match (standing, figure.interval) {
            (Standing::CannotTell, None) => (
                format!(
                    "Undecided, too few processes: {} of the {MIN_REPLICATES} that an interval takes.",
                    figure.processes
                ),
                MIN_REPLICATES,
            ),
            (Standing::CannotTell, Some(interval)) => {
                let enough = processes_to_decide(&figure, interval, band);
                (too_noisy(interval, band, enough), enough.min(MAX_PROCESSES))
            }
            _ => {
                return Ok(Answer {
                    figure: Some(figure),
                    standing,
                    because: String::new(),
                });
            }
        };
        Ok(Answer {
            figure: Some(figure),
            ..open(standing, &why, processes)
        })
    }

    /// What several pairs say of a claim together, each with its ratio, and what would settle the first that is open.
    ///
    /// - `claim`: in words, and whose it is
    /// - `noise`: as of [`Comparison::judge`]
    #[must_use]
    pub fn finding(
        &self,
        run: &Run,
        pairs: &[[&Case; 2]],
        says: Claim,
        claim: String,
        noise: Option<Noise>,
    ) -> Finding {
        let answers = pairs.iter().map(|pair| {
            let judged = self.judge(run, *pair, says, noise);
            judged.unwrap_or_else(Answer::from)
        });
        let answers: Vec<Answer> = answers.collect();
        let standings: Vec<Standing> = answers.iter().map(|answer| answer.standing).collect();
        let figures = answers.iter().filter_map(|answer| answer.figure.as_ref());
        let figures: Vec<String> = figures.map(times).collect();
        let standing = overall(&standings);
        let said = |standing| {
            let mut of = answers.iter().filter(|answer| answer.standing == standing);
            of.find(|answer| !answer.because.is_empty())
        };
        let because = match standing {
            // One of several pairs that was not measured leaves the whole open.
            Standing::CannotTell => said(standing).or_else(|| said(Standing::NotMeasured)),
            Standing::CannotBeTested | Standing::NotMeasured => said(standing),
            _ => None,
        };
        let because = because.map(|answer| answer.because.clone());
        Finding {
            claim,
            standing,
            because: sentences(std::iter::once(figures.join("; ")).chain(because)),
        }
    }

    fn check_metric(&self, clock: Clock) -> Result<(), Refused> {
        let (metric, needs) = (self.metric, self.needs);
        let refuse = |problem: String| {
            let metric = metric.name;
            Err(Refused::Time { metric, problem })
        };
        if metric.kind == Kind::Time && !metric.scope.covers(needs) {
            let covers = metric.scope;
            return refuse(format!(
                "covers {covers}, and the comparison needs {needs}: use a time that covers it"
            ));
        }
        let is_of_cpu = metric.timer() == Some(Timer::ProcessCpu);
        if is_of_cpu && clock == Clock::Gpu && needs.meets(Scope::DEVICE) {
            return refuse(format!(
                "is CPU time of the process, and {needs} is done by a GPU in this run: use its own clock or the \
                 wall clock"
            ));
        }
        Ok(())
    }

    fn check_pair(&self, [first, second]: [&Case; 2]) -> Result<(), Refused> {
        let refuse = |problem: String| {
            Err(Refused::Pair {
                first: first.id().key(),
                second: second.id().key(),
                changed: self.changed.to_owned(),
                problem,
            })
        };
        let value = first.condition_named(self.changed);
        if value == second.condition_named(self.changed) {
            return refuse(format!("have both {value:?} there"));
        }
        let others = self.beside([first, second]);
        if others.is_empty() {
            return Ok(());
        }
        let described = others.iter().map(|key| {
            let [first, second] = [first, second].map(|case| case.condition_named(key));
            format!("{key:?} ({first:?}, {second:?})")
        });
        let others = described.collect::<Vec<_>>().join(", ");
        refuse(format!(
            "differ in {others} as well: name it among what follows, with the reason, or compare other cases"
        ))
    }

    /// Conditions in which two cases differ beside those that may.
    fn beside<'r>(&self, [first, second]: [&'r Case; 2]) -> Vec<&'r str> {
        let keys = |case: &'r Case| case.id().conditions.keys().map(String::as_str);
        let mut keys: Vec<&str> = keys(first).chain(keys(second)).collect();
        keys.sort_unstable();
        keys.dedup();
        keys.retain(|key| {
            let may_differ = *key == self.changed
                || *key == REPEATS.name()
                || self.follows.iter().any(|follows| follows.key == *key);
            let values = [first, second].map(|case| case.condition_named(key));
            let is_of_one = self.one_sided.is_some() && values.contains(&"");
            !may_differ && !is_of_one && values[0] != values[1]
        });
        keys
    }
}

/// Several answers to one question. One that is refused refuses it; one that does not hold is enough; one that is
/// open leaves it open.
#[must_use]
pub fn overall(standings: &[Standing]) -> Standing {
    let has = |wanted| standings.contains(&wanted);
    let is_measured = standings
        .iter()
        .any(|found| *found != Standing::NotMeasured);
    if has(Standing::CannotBeTested) {
        Standing::CannotBeTested
    } else if !is_measured {
        Standing::NotMeasured
    } else if has(Standing::DoesNotHold) {
        Standing::DoesNotHold
    } else if has(Standing::CannotTell) || has(Standing::NotMeasured) {
        Standing::CannotTell
    } else if has(Standing::NoDifference) {
        Standing::NoDifference
    } else {
        Standing::Holds
    }
}

/// Sentences after each other, without the empty ones.
pub fn sentences<T: AsRef<str>>(texts: impl IntoIterator<Item = T>) -> String {
    let texts = texts.into_iter().map(|text| text.as_ref().to_owned());
    let texts: Vec<String> = texts.filter(|text| !text.is_empty()).collect();
    texts.join(". ")
}

/// Whether one figure is more than another, by their intervals.
#[must_use]
pub fn is_more(one: &Estimate, other: &Estimate) -> Standing {
    match (one.interval, other.interval) {
        (Some([low, _]), Some([_, high])) if low > high => Standing::Holds,
        (Some([_, high]), Some([low, _])) if high < low => Standing::DoesNotHold,
        _ => Standing::CannotTell,
    }
}

/// Whether its cost may be compared. A case that is wrong by its nature has its error beside its cost.
fn is_measured(case: &Case) -> bool {
    case.counts() || (case.outcome == Outcome::Wrong && case.planned.may_be_wrong)
}

fn exact(first: &Case, second: &Case, metric: &Metric) -> Option<Estimate> {
    let figure = first.value(metric)? / second.value(metric)?;
    figure.is_finite().then_some(Estimate::exact(figure))
}

/// How many processes would decide it, if the interval shrinks as the root of their number. A ratio on the end
/// of the band takes more than a run can have.
#[allow(clippy::cast_possible_truncation, reason = "a small whole number")]
fn processes_to_decide(figure: &Estimate, [low, high]: [f64; 2], band: f64) -> usize {
    let half_width = 0.5 * (high / low).ln();
    let from_band = (figure.middle.ln().abs() - band.ln()).abs();
    let times = (half_width / from_band).powi(2).max(1.0);
    let enough = (figure.processes as f64 * times).ceil();
    (enough.min(1e6) as usize).max(figure.processes + 1)
}

fn too_noisy([low, high]: [f64; 2], band: f64, enough: usize) -> String {
    let percent = 100.0 * (band - 1.0);
    let quieter = if enough > MAX_PROCESSES {
        " No number of processes that a run can take would do on a machine as noisy as this: use a quieter one."
    } else {
        ""
    };
    format!(
        "Undecided, too noisy: the interval of the ratio, {low:.4} to {high:.4}, and the {percent:.2} % by which \
         identical work differed leave it open.{quieter}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::RunEnvironment;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    const METRICS: [Metric; 4] = [
        Metric::less("cost_cpu_ms", "ms", Kind::Time, "Cost.").covering(Scope::FRAME),
        Metric::less("cost_gpu_ms", "ms", Kind::Time, "Cost.").covering(Scope::DEVICE),
        Metric::less("cost_wall_ms", "ms", Kind::Time, "Cost.").covering(Scope::FRAME),
        Metric::less("bytes", "bytes", Kind::Bytes, "Bytes."),
    ];
    const CPU: &Metric = Metric::of(&METRICS, "cost_cpu_ms");
    const GPU: &Metric = Metric::of(&METRICS, "cost_gpu_ms");
    const WALL: &Metric = Metric::of(&METRICS, "cost_wall_ms");
    const BYTES: &Metric = Metric::of(&METRICS, "bytes");

    const DRAWS: Comparison<'static> = Comparison {
        changed: "rule",
        follows: &[],
        one_sided: None,
        metric: CPU,
        needs: Scope::DRAW,
    };

    /// Two ways on two views; the second one's times are `after`, and its side is `side`.
    fn run(before: &[f64], after: &[f64], side: &str) -> MadeUpRun {
        let mut run = MadeUpRun {
            metrics: METRICS.to_vec(),
            ..MadeUpRun::default()
        };
        for view in ["globe", "horizon"] {
            for (rule, times, side) in [("fail", before, "left"), ("pass", after, side)] {
                let conditions = [("view", view), ("rule", rule), ("side", side)];
                let id = case_id("study", &format!("{view}/{rule}"), &conditions);
                let case = run.case(id);
                for metric in [CPU, GPU, WALL] {
                    case.timed(metric, times);
                }
                case.figure(BYTES, times[0]);
            }
        }
        run
    }

    fn judge(
        made: &MadeUpRun,
        comparison: &Comparison<'_>,
        claim: Claim,
    ) -> Result<Answer, Refused> {
        let run = made.loaded();
        comparison.judge(&run, [&run.cases[0], &run.cases[1]], claim, None)
    }

    #[test]
    fn a_pair_that_differs_in_two_conditions_is_refused() {
        let two = run(&[2.0; 5], &[1.0; 5], "right");
        let refused = judge(&two, &DRAWS, Claim::Faster).expect_err("two changes");
        let said = refused.to_string();
        assert!(said.contains("\"side\" (\"left\", \"right\")"), "{said}");
        // Control: one that follows, and one change.
        let follows = [Follows {
            key: "side",
            because: "a rule has its side",
        }];
        let comparison = Comparison {
            follows: &follows,
            ..DRAWS
        };
        let answer = judge(&two, &comparison, Claim::Faster).expect("one change");
        assert_eq!(answer.standing, Standing::Holds);
        let one = run(&[2.0; 5], &[1.0; 5], "left");
        assert!(judge(&one, &DRAWS, Claim::Faster).is_ok());
        // A condition that only one of the two has may be one of a technique's own.
        let missing = run(&[2.0; 5], &[1.0; 5], "");
        assert!(judge(&missing, &DRAWS, Claim::Faster).is_err());
        let comparison = Comparison {
            one_sided: Some("only one of them has sides"),
            ..DRAWS
        };
        assert!(judge(&missing, &comparison, Claim::Faster).is_ok());
        assert!(judge(&two, &comparison, Claim::Faster).is_err());
        // On a page it stands where its answer would.
        let loaded = two.loaded();
        let pairs = [[&loaded.cases[0], &loaded.cases[1]]];
        let finding = DRAWS.finding(&loaded, &pairs, Claim::Faster, String::new(), None);
        assert_eq!(finding.standing, Standing::CannotBeTested);
        assert!(finding.because.starts_with(REFUSED), "{}", finding.because);
        // What is not changed is not compared.
        let comparison = Comparison {
            changed: "view",
            ..DRAWS
        };
        let refused = judge(&one, &comparison, Claim::Faster).expect_err("the same view");
        let said = refused.to_string();
        assert!(said.ends_with("have both \"globe\" there"), "{said}");
    }

    #[test]
    fn a_time_without_what_is_compared_and_the_clock_of_another_device_are_refused() {
        let mut made = run(&[2.0; 5], &[1.0; 5], "left");
        let with = |metric, needs| Comparison {
            metric,
            needs,
            ..DRAWS
        };
        let uploads = Scope::UPLOAD.and(Scope::DRAW);
        let refused = judge(&made, &with(GPU, uploads), Claim::Faster).expect_err("no upload");
        let said = refused.to_string();
        assert!(said.contains("use a time that covers it"), "{said}");
        assert!(judge(&made, &with(WALL, uploads), Claim::Faster).is_ok());
        assert!(judge(&made, &with(CPU, uploads), Claim::Faster).is_ok());
        made.environment = RunEnvironment {
            device_type: "discrete-gpu".to_owned(),
            gpu_timestamps: true,
            ..RunEnvironment::default()
        };
        let refused = judge(&made, &with(CPU, Scope::DRAW), Claim::Faster).expect_err("a GPU");
        let said = refused.to_string();
        assert!(said.contains("done by a GPU"), "{said}");
        assert!(judge(&made, &with(GPU, Scope::DRAW), Claim::Faster).is_ok());
        // Figures that are no times have no clock.
        assert!(judge(&made, &with(BYTES, Scope::NOTHING), Claim::Faster).is_ok());
    }

    #[test]
    fn an_open_answer_says_what_would_settle_it() {
        let judged = |before: &[f64], after: &[f64], claim| {
            judge(&run(before, after, "left"), &DRAWS, claim).expect("one change")
        };
        let few = judged(&[2.0; 3], &[1.0; 3], Claim::Faster);
        assert_eq!(few.standing, Standing::CannotTell);
        assert!(few.because.contains("3 of the 5"), "{}", few.because);
        let command = "terrafill bench --study study --processes 5";
        assert!(few.because.ends_with(command), "{}", few.because);
        let noisy = judged(&[1.3, 0.9, 1.2, 0.95, 1.1], &[1.0; 5], Claim::Faster);
        assert_eq!(noisy.standing, Standing::CannotTell);
        assert!(noisy.because.contains("too noisy"), "{}", noisy.because);
        let none = judged(&[1.001; 5], &[1.0; 5], Claim::Faster);
        assert_eq!(none.standing, Standing::NoDifference);
        // Controls: decided ones say nothing more, either way round.
        for (before, standing) in [
            ([2.0; 5], Standing::Holds),
            ([0.5; 5], Standing::DoesNotHold),
        ] {
            let decided = judged(&before, &[1.0; 5], Claim::Faster);
            assert_eq!((decided.standing, decided.because.as_str()), (standing, ""));
        }
        let same = judged(&[1.001; 5], &[1.0; 5], Claim::NoDifference);
        assert_eq!(same.standing, Standing::Holds);
    }

    #[test]
    fn what_was_not_measured_has_no_figure() {
        let mut made = run(&[2.0; 5], &[1.0; 5], "left");
        made.cases[1].ended(terrafill_results::Status::Wrong, "4 px differ");
        // Control: what may be wrong is compared, its error beside it.
        let mut approximate = made.clone();
        approximate.cases[1].may_be_wrong = true;
        let answer = judge(&approximate, &DRAWS, Claim::Faster).expect("one change");
        assert_eq!(answer.standing, Standing::Holds);
        let answer = judge(&made, &DRAWS, Claim::Faster).expect("one change");
        assert_eq!(
            (answer.figure, answer.standing),
            (None, Standing::NotMeasured)
        );
        assert!(answer.because.contains("4 px differ"), "{}", answer.because);
        assert!(
            answer.because.contains("terrafill bench"),
            "{}",
            answer.because
        );
    }

    #[test]
    fn a_figure_is_more_where_the_intervals_are_apart() {
        let of = |low, high| Estimate {
            interval: Some([low, high]),
            ..Estimate::exact(f64::midpoint(low, high))
        };
        assert_eq!(is_more(&of(2.0, 3.0), &of(0.5, 1.9)), Standing::Holds);
        // Negative controls: swapped operands, and intervals that meet.
        assert_eq!(is_more(&of(0.5, 1.9), &of(2.0, 3.0)), Standing::DoesNotHold);
        assert_eq!(is_more(&of(1.5, 3.0), &of(0.5, 1.9)), Standing::CannotTell);
    }

    #[test]
    fn one_answer_that_does_not_hold_is_enough_and_an_open_one_leaves_it_open() {
        use Standing::{CannotBeTested, CannotTell, DoesNotHold, Holds, NoDifference, NotMeasured};
        for (parts, whole) in [
            (&[Holds, Holds][..], Holds),
            (&[Holds, NoDifference], NoDifference),
            (&[Holds, NotMeasured], CannotTell),
            (&[NoDifference, CannotTell], CannotTell),
            (&[Holds, CannotTell, DoesNotHold], DoesNotHold),
            (&[Holds, CannotBeTested], CannotBeTested),
            (&[NotMeasured], NotMeasured),
            (&[], NotMeasured),
        ] {
            assert_eq!(overall(parts), whole, "{parts:?}");
        }
    }
}
