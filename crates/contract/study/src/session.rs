// SPDX-License-Identifier: MIT OR Apache-2.0
//! The one group and the one session of studies that verify each case by itself, and then time it.

use crate::{Context, Group, Session, StudyError};
use std::collections::BTreeMap;
use terrafill_contract::DeviceError;
use terrafill_results::{CaseId, ConditionKey, PlannedCase, Status, Verdict};
use terrafill_surface::SurfaceError;

/// Names of metrics, and values.
pub type Figures = Vec<(&'static str, f64)>;

/// Why a case has no figures.
#[derive(Debug)]
pub enum Failure {
    /// A surface or a device that cannot do it: the case is skipped.
    Unable(String),
    /// A defect: the case fails, and the others go on.
    Broken(String),
    /// The session cannot go on, such as where the run's folder cannot be written.
    Ends(StudyError),
}

impl From<DeviceError> for Failure {
    fn from(error: DeviceError) -> Self {
        match error {
            DeviceError::Unsupported { .. } | DeviceError::OverCapacity { .. } => {
                Self::Unable(error.to_string())
            }
            _ => Self::Broken(error.to_string()),
        }
    }
}

impl From<SurfaceError> for Failure {
    fn from(error: SurfaceError) -> Self {
        match error {
            SurfaceError::EyeBelow { .. } => Self::Unable(error.to_string()),
            _ => Self::Broken(error.to_string()),
        }
    }
}

impl Failure {
    /// A defect, by its error.
    #[must_use]
    pub fn broken(error: impl ToString) -> Self {
        Self::Broken(error.to_string())
    }

    /// In words.
    #[must_use]
    pub fn reason(self) -> String {
        match self {
            Self::Unable(reason) | Self::Broken(reason) => reason,
            Self::Ends(error) => error.to_string(),
        }
    }
}

/// Bad input: a view, a surface or a file.
impl From<String> for Failure {
    fn from(error: String) -> Self {
        Self::Broken(error)
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        Self::Ends(error)
    }
}

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

/// What a study does with each case of a group; [`CaseSession`] does the rest.
pub trait Measures {
    /// Prepares a case and compares its result with the reference.
    ///
    /// # Errors
    /// [`Failure`], which becomes the case's verdict.
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure>;

    /// The same of a case that an earlier process has verified.
    ///
    /// # Errors
    /// As [`Measures::verify`].
    fn recheck(
        &mut self,
        case: usize,
        _status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        self.verify(case)
    }

    /// Called before each block, such as to draw what is under the fill.
    ///
    /// # Errors
    /// [`StudyError::Broken`].
    fn begin_block(&mut self) -> Result<(), StudyError> {
        Ok(())
    }

    /// Called before each sample that counts: what this draws is not measured.
    ///
    /// # Errors
    /// As [`Measures::time`].
    fn before_sample(&mut self, _case: usize) -> Result<(), Failure> {
        Ok(())
    }

    /// A timed frame of a verified case.
    ///
    /// # Errors
    /// [`Failure`], with which the case fails.
    fn time(&mut self, case: usize) -> Result<Figures, Failure>;
}

/// Whatever fails is its case's, and the others go on.
#[derive(Debug)]
pub struct CaseSession<M>(pub M);

fn verdict(found: Result<Verdict, Failure>) -> Result<Verdict, StudyError> {
    match found {
        Ok(verdict) => Ok(verdict),
        Err(Failure::Unable(reason)) => Ok(Verdict::skipped(reason)),
        Err(Failure::Broken(reason)) => Ok(Verdict::failed(reason)),
        Err(Failure::Ends(error)) => Err(error),
    }
}

impl<M: Measures> Session for CaseSession<M> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        verdict(self.0.verify(case))
    }

    fn recheck(
        &mut self,
        case: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, StudyError> {
        verdict(self.0.recheck(case, status, notes))
    }

    fn begin_block(&mut self) -> Result<(), StudyError> {
        self.0.begin_block()
    }

    fn before_sample(&mut self, case: usize) -> Result<(), String> {
        self.0.before_sample(case).map_err(Failure::reason)
    }

    fn sample(&mut self, case: usize) -> Result<Figures, String> {
        self.0.time(case).map_err(Failure::reason)
    }
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
    use terrafill_contract::Devices;
    use terrafill_results::condition::{API, SIZE_PX, VIEW};

    /// Fails by the case's number.
    struct Failing<'a>(&'a [Status]);

    impl Measures for Failing<'_> {
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
            open: |group, _| Ok(Box::new(CaseSession(Failing(&group.work)))),
        };
        let context = Context {
            devices: &Rc::new(Devices::default()),
            folder: std::path::Path::new(""),
        };
        let mut session = group.open(context).expect("opens");
        let found = [0, 1, 2, 3].map(|case| session.verify(case).expect("a verdict").status);
        assert_eq!(
            found,
            [Status::Ok, Status::Wrong, Status::Skipped, Status::Failed]
        );
        assert_eq!(session.sample(0), Err("it was not verified".to_owned()));
        // Negative control: what ends a session is no case's verdict.
        assert!(session.verify(4).is_err());
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
