// SPDX-License-Identifier: MIT OR Apache-2.0
//! The one group of cases, and what sessions that verify each case by itself and then time it have in common.

use crate::{Context, Failure, Figures, Group, Session, StudyError};
use std::collections::BTreeMap;
use terrafill_results::{CaseId, ConditionKey, PlannedCase, Status, Verdict};

/// Right where there is no reason why not.
#[must_use]
pub fn judged(reason: String, figures: Figures, notes: Vec<(&'static str, String)>) -> Verdict {
    Verdict {
        status: if reason.is_empty() {
            Status::Ok
        } else {
            Status::Wrong
        },
        reason,
        figures,
        notes,
        features: Vec::new(),
    }
}

/// A case that is named by the values of its conditions: `globe/50/vertex`.
///
/// - `unnamed`: a condition that its name leaves out
#[must_use]
pub fn planned_case(
    study: &str,
    samples: u32,
    conditions: impl IntoIterator<Item = (ConditionKey, String)>,
    unnamed: Option<(ConditionKey, String)>,
) -> PlannedCase {
    let mut conditions: Vec<(ConditionKey, String)> = conditions.into_iter().collect();
    let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
    let name = values.join("/");
    conditions.extend(unnamed);
    PlannedCase {
        id: CaseId::new(study, name, conditions),
        samples,
        may_be_wrong: false,
    }
}

/// What verifying a case has left for its timed frames.
///
/// # Errors
/// [`Failure::Broken`] for a case that was not verified.
pub fn verified<T>(opened: &mut BTreeMap<usize, T>, case: usize) -> Result<&mut T, Failure> {
    let opened = opened.get_mut(&case);
    opened.ok_or_else(|| Failure::Broken("it was not verified".to_owned()))
}

/// How the session of a [`CaseGroup`] is opened.
pub type OpenSession<W> =
    for<'a> fn(&'a CaseGroup<W>, Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError>;

/// Cases, what they are made from, and how they are opened.
#[derive(Debug)]
pub struct CaseGroup<W> {
    /// `planet-134/globe`.
    pub name: String,
    /// Its cases.
    pub cases: Vec<PlannedCase>,
    /// Blocks to measure and drop at the start, where they are not the run's.
    pub warm_up: Option<u32>,
    /// What sessions need of the plan.
    pub work: W,
    /// Makes a session of it.
    pub open: OpenSession<W>,
}

impl<W> Group for CaseGroup<W> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn warm_up(&self) -> Option<u32> {
        self.warm_up
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        (self.open)(self, context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;
    use terrafill_contract::{DeviceError, Devices};
    use terrafill_results::condition::{API, SIZE_PX, VIEW};

    /// Fails by the case's number.
    struct Failing<'a>(&'a [Status]);

    impl Session for Failing<'_> {
        fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
            match (case, self.0.get(case)) {
                (_, Some(Status::Ok)) => Ok(judged(String::new(), Vec::new(), Vec::new())),
                (_, Some(Status::Wrong)) => Ok(judged("off".to_owned(), Vec::new(), Vec::new())),
                (_, Some(Status::Skipped)) => {
                    Err(DeviceError::unsupported("what is not there", "a device").into())
                }
                (4, _) => Err(StudyError::NoDevice("it is gone".to_owned()).into()),
                _ => Err("no view".to_owned().into()),
            }
        }

        fn time(&mut self, _case: usize) -> Result<Figures, Failure> {
            Err("it was not verified".to_owned().into())
        }
    }

    #[test]
    fn what_a_device_lacks_is_skipped_and_what_is_wrong_is_not() {
        let group = CaseGroup {
            name: "a group".to_owned(),
            cases: Vec::new(),
            warm_up: Some(0),
            work: vec![Status::Ok, Status::Wrong, Status::Skipped],
            open: |group, _| Ok(Box::new(Failing(&group.work))),
        };
        let context = Context {
            devices: &Rc::new(Devices::default()),
            folder: std::path::Path::new(""),
        };
        let mut session = group.open(context).expect("opens");
        let mut verify = |case| session.verify(case).or_else(Failure::verdict);
        let found = [0, 1, 2, 3].map(|case| verify(case).expect("a verdict").status);
        assert_eq!(
            found,
            [Status::Ok, Status::Wrong, Status::Skipped, Status::Failed]
        );
        // Negative control: what ends a session is no case's verdict.
        assert!(verify(4).is_err());
        assert_eq!(
            (group.name().as_str(), group.warm_up()),
            ("a group", Some(0))
        );
    }

    #[test]
    fn a_case_is_named_by_its_conditions() {
        let case = planned_case(
            "a",
            3,
            [(VIEW, "globe".to_owned()), (SIZE_PX, "64".to_owned())],
            Some((API, "wgpu".to_owned())),
        );
        assert_eq!((case.id.key().as_str(), case.samples), ("a/globe/64", 3));
        assert_eq!(case.id.condition(API), "wgpu");
    }
}
