// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases that share nothing but their devices: each is opened when it is verified, and what it opened is timed.

use crate::{CaseGroup, Context, Failure, Figures, Session, planned_case, verified};
use std::collections::BTreeMap;
use terrafill_results::{ConditionKey, Status, Verdict};

/// A case by itself, and what it is made from.
pub trait Trial {
    /// What its timed frames need.
    type Opened;

    /// Its conditions, whose values name it.
    fn conditions(&self) -> Vec<(ConditionKey, String)>;

    /// Opens it and compares its result with the reference.
    ///
    /// # Errors
    /// [`Failure`], which becomes the case's verdict.
    fn verify(&self, context: Context<'_>) -> Result<(Self::Opened, Verdict), Failure>;

    /// Opens a case that an earlier process has verified. Verifies it once more by default.
    ///
    /// # Errors
    /// As [`Trial::verify`].
    fn recheck(&self, context: Context<'_>) -> Result<(Self::Opened, Verdict), Failure> {
        self.verify(context)
    }

    /// A timed frame.
    ///
    /// # Errors
    /// [`Failure`], with which the case fails.
    fn time(&self, opened: &mut Self::Opened) -> Result<Figures, Failure>;
}

/// A group with a case for each trial.
#[must_use]
pub fn trials<T: Trial + 'static>(
    study: &str,
    name: String,
    samples: u32,
    trials: Vec<T>,
) -> CaseGroup<Vec<T>> {
    let case = |trial: &T| planned_case(study, samples, trial.conditions(), None);
    CaseGroup {
        name,
        cases: trials.iter().map(case).collect(),
        warm_up: None,
        work: trials,
        open: |group, context| {
            Ok(Box::new(Trials {
                trials: &group.work,
                context,
                opened: BTreeMap::new(),
            }))
        },
    }
}

struct Trials<'a, T: Trial> {
    trials: &'a [T],
    context: Context<'a>,
    /// By case.
    opened: BTreeMap<usize, T::Opened>,
}

impl<T: Trial> Session for Trials<'_, T> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let (opened, verdict) = self.trials[case].verify(self.context)?;
        self.opened.insert(case, opened);
        Ok(verdict)
    }

    fn recheck(
        &mut self,
        case: usize,
        _status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        let (opened, verdict) = self.trials[case].recheck(self.context)?;
        self.opened.insert(case, opened);
        Ok(verdict)
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let opened = verified(&mut self.opened, case)?;
        self.trials[case].time(opened)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Group as _, judged};
    use std::rc::Rc;
    use terrafill_contract::Devices;
    use terrafill_results::condition::VIEW;

    /// Adds itself in each frame; 2 opens nothing.
    struct Counting(u32);

    impl Trial for Counting {
        type Opened = f64;

        fn conditions(&self) -> Vec<(ConditionKey, String)> {
            vec![(VIEW, self.0.to_string())]
        }

        fn verify(&self, _: Context<'_>) -> Result<(f64, Verdict), Failure> {
            match self.0 {
                2 => Err(Failure::Unable("no such device".to_owned())),
                _ => Ok((0.0, judged(String::new(), Vec::new(), Vec::new()))),
            }
        }

        fn time(&self, frames: &mut f64) -> Result<Figures, Failure> {
            *frames += f64::from(self.0);
            Ok(vec![("frames", *frames)])
        }
    }

    #[test]
    fn each_case_is_timed_by_what_it_opened_and_one_that_opened_nothing_is_not() {
        let group = trials("a", "a/b".to_owned(), 3, [1, 2, 3].map(Counting).into());
        let names: Vec<&str> = group
            .cases
            .iter()
            .map(|case| case.id.name.as_str())
            .collect();
        assert_eq!((group.name().as_str(), names), ("a/b", vec!["1", "2", "3"]));
        let context = Context {
            devices: &Rc::new(Devices::default()),
            folder: std::path::Path::new(""),
        };
        let mut session = group.open(context).expect("opens");
        let verify = |case| session.verify(case).or_else(Failure::verdict);
        let found = [0, 1]
            .map(verify)
            .map(|found| found.expect("a verdict").status);
        assert_eq!(found, [Status::Ok, Status::Skipped]);
        let again = session.recheck(2, Status::Ok, &BTreeMap::new());
        assert_eq!(again.expect("a verdict").status, Status::Ok);
        let mut frames = |case| session.time(case).map_err(Failure::reason);
        assert_eq!(frames(2), Ok(vec![("frames", 3.0)]));
        assert_eq!(frames(0), Ok(vec![("frames", 1.0)]));
        assert_eq!(frames(2), Ok(vec![("frames", 6.0)]));
        // Negative control: nothing of it was opened.
        assert_eq!(frames(1), Err("it was not verified".to_owned()));
    }
}
