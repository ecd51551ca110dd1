// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why a study or one of its cases cannot be measured.

use terrafill_contract::DeviceError;
use terrafill_results::Verdict;
use terrafill_surface::SurfaceError;

/// Why a study cannot be planned or measured as a whole. What goes wrong with one case is that
/// case's [`Verdict`] instead.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A scene, a name or a value is wrong; one line for each problem.
    #[error("{0}")]
    BadInput(String),
    /// No device can run anything of it.
    #[error("no usable device: {0}")]
    NoDevice(String),
    /// The device or something else broke in the middle.
    #[error("{place}: {message}")]
    Broken {
        /// Group or case in hand.
        place: String,
        /// What happened.
        message: String,
    },
    /// The run's folder.
    #[error(transparent)]
    Run(#[from] terrafill_results::RunError),
}

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

    /// What becomes of its case, unless nothing can go on.
    ///
    /// # Errors
    /// [`Failure::Ends`].
    pub fn verdict(self) -> Result<Verdict, StudyError> {
        match self {
            Self::Unable(reason) => Ok(Verdict::skipped(reason)),
            Self::Broken(reason) => Ok(Verdict::failed(reason)),
            Self::Ends(error) => Err(error),
        }
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
