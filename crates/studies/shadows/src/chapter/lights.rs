// SPDX-License-Identifier: MIT OR Apache-2.0
//! What limiting a lamp's shadows to its reach saves.

use super::Own;
use super::findings::{finding, joined};
use crate::lamps::Limit;
use crate::metrics::*;
use terrafill_lab::measured;
use terrafill_plot::number::significant;
use terrafill_results::{Case, Finding};

impl Own<'_> {
    /// Writes of each limit against none, and pixels that it gets wrong.
    pub(super) fn limits(&self) -> Option<Finding> {
        let all: Vec<&Case> = self.of_question("lights").collect();
        let off = |case: &Case| {
            let is_it = |own: &&&Case| {
                own.condition(LIMIT) == Limit::Off.name()
                    && [LIGHT, RULE]
                        .iter()
                        .all(|key| own.condition(*key) == case.condition(*key))
            };
            measured(all.iter().find(is_it)?, UPDATES)
        };
        let right = Limit::ALL.into_iter().filter(|limit| !limit.may_be_wrong());
        let limits = right.filter(|limit| *limit != Limit::Off);
        let mut wrong = 0.0;
        let told = limits.filter_map(|limit| {
            let own = all
                .iter()
                .filter(|case| case.condition(LIMIT) == limit.name());
            let shares = own.filter_map(|case| {
                wrong += Self::wrong_px(case)?;
                Some(measured(case, UPDATES)? / off(case)?)
            });
            let shares: Vec<f64> = shares.collect();
            let least = shares.iter().copied().reduce(f64::min)?;
            let most = shares.iter().copied().reduce(f64::max)?;
            let [least, most] = [least, most].map(|share| significant(100.0 * share));
            Some(format!(
                "{}: {least} to {most} % of the writes",
                limit.name()
            ))
        });
        let told = joined(told.collect::<Vec<_>>(), "; ")?;
        let claim = "Limits of reach change no pixel of a lamp's shadows.";
        Some(finding(claim, wrong == 0.0, told))
    }
}

#[cfg(test)]
mod tests {
    use crate::chapter::tests::finding;
    use crate::metrics::*;
    use terrafill_results::Standing;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn limits_stand_by_their_pixels_and_a_twin_that_loses_some_is_not_asked() {
        let found = |limit: &str, wrong: f64| {
            let mut run = MadeUpRun::default();
            for (limit, writes) in [("off", 20.0), (limit, 5.0)] {
                let conditions = [
                    ("question", "lights"),
                    ("light", "deck light"),
                    ("rule", "z-fail"),
                    ("limit", limit),
                ];
                run.case(case_id(crate::STUDY, limit, &conditions))
                    .figure(UPDATES, writes)
                    .figure(SHADOW_FALSE_LIT_PX, wrong)
                    .figure(SHADOW_FALSE_DARK_PX, 0.0);
            }
            finding(&run, "change no pixel of a lamp")
        };
        assert_eq!(found("scissor", 0.0), Some(Standing::Holds));
        assert_eq!(found("scissor", 1.0), Some(Standing::DoesNotHold));
        assert_eq!(found("scissor of half of it", 1.0), None);
    }

    #[test]
    fn a_limit_is_faster_by_its_own_time_and_a_scissor_that_is_too_small_is_not_asked() {
        let found = |limit: &str, ms: f64| {
            let mut run = MadeUpRun::default();
            for (limit, ms) in [("off", 8.0), (limit, ms)] {
                let conditions = [
                    ("question", "device-lights"),
                    ("light", "deck light"),
                    ("limit", limit),
                ];
                let case = run.case(case_id(crate::STUDY, limit, &conditions));
                case.timed(FILL_CPU, &[ms; 7]);
            }
            finding(&run, "Limits of reach make")
        };
        assert_eq!(found("scissor", 2.0), Some(Standing::Holds));
        assert_eq!(found("scissor", 20.0), Some(Standing::DoesNotHold));
        assert_eq!(found("scissor of half of it", 2.0), None);
    }
}
