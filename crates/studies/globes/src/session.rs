// SPDX-License-Identifier: MIT OR Apache-2.0
//! The one session of every part that draws on a device: a part makes a case and judges it, and times it.

use std::collections::BTreeMap;
use terrafill_fill::DeviceError;
use terrafill_results::{Status, Verdict};
use terrafill_study::{Session, StudyError};
use terrafill_surface::SurfaceError;

/// Names of metrics, and values.
pub(crate) type Figures = Vec<(&'static str, f64)>;

/// Why a case has no figures.
pub(crate) enum Failure {
    /// A surface or a device that cannot do it.
    Unable(String),
    /// A defect.
    Broken(String),
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

/// Bad input: a view, a surface or a file.
impl From<String> for Failure {
    fn from(error: String) -> Self {
        Self::Broken(error)
    }
}

impl From<Failure> for Verdict {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Unable(reason) => Self::skipped(reason),
            Failure::Broken(reason) => Self::failed(reason),
        }
    }
}

/// Right where there is no reason why not.
pub(crate) fn judged(
    reason: String,
    figures: Figures,
    notes: Vec<(&'static str, String)>,
) -> Verdict {
    Verdict {
        status: match reason.is_empty() {
            true => Status::Ok,
            false => Status::Wrong,
        },
        reason,
        figures,
        notes,
    }
}

/// Cases that are made and judged once, and then timed.
pub(crate) trait Part {
    /// Makes a case and holds it against `f64`.
    fn make(&mut self, case: usize) -> Result<Verdict, Failure>;

    /// The same of a case that an earlier process has judged.
    fn make_again(
        &mut self,
        case: usize,
        _status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        self.make(case)
    }

    /// A timed frame.
    fn time(&mut self, case: usize) -> Result<Figures, Failure>;
}

/// Whatever fails is its case's, and the others go on.
pub(crate) struct PartSession<P>(pub(crate) P);

impl<P: Part> Session for PartSession<P> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        Ok(self.0.make(case).unwrap_or_else(Verdict::from))
    }

    fn recheck(
        &mut self,
        case: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, StudyError> {
        let verdict = self.0.make_again(case, status, notes);
        Ok(verdict.unwrap_or_else(Verdict::from))
    }

    fn sample(&mut self, case: usize) -> Result<Figures, String> {
        self.0.time(case).map_err(|failure| match failure {
            Failure::Unable(reason) | Failure::Broken(reason) => reason,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fails by the case's number.
    struct Failing;

    impl Part for Failing {
        fn make(&mut self, case: usize) -> Result<Verdict, Failure> {
            match case {
                0 => Ok(judged(String::new(), Vec::new(), Vec::new())),
                1 => Ok(judged("off".to_owned(), Vec::new(), Vec::new())),
                2 => Err(DeviceError::unsupported("what is not there", "a device").into()),
                _ => Err("no view".to_owned().into()),
            }
        }

        fn time(&mut self, _case: usize) -> Result<Figures, Failure> {
            Err("it was not verified".to_owned().into())
        }
    }

    #[test]
    fn what_a_device_lacks_is_skipped_and_what_is_wrong_is_not() {
        let mut session = PartSession(Failing);
        let mut status = |case| session.verify(case).expect("a verdict").status;
        let found = [0, 1, 2, 3].map(&mut status);
        assert_eq!(
            found,
            [Status::Ok, Status::Wrong, Status::Skipped, Status::Failed]
        );
        assert_eq!(session.sample(0), Err("it was not verified".to_owned()));
    }
}
