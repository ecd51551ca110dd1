// SPDX-License-Identifier: MIT OR Apache-2.0
//! A device's failure as the study's.

use terrafill_gpu::EvaluateError;
use terrafill_study::StudyError;

/// A device's failure as the run's.
pub(crate) fn lost(error: EvaluateError) -> StudyError {
    broken(error)
}

/// The study cannot go on.
pub(crate) fn broken(why: impl ToString) -> StudyError {
    StudyError::Broken {
        place: crate::STUDY.to_owned(),
        message: why.to_string(),
    }
}
