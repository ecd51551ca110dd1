// SPDX-License-Identifier: MIT OR Apache-2.0
//! A device's failure as the study's.

use terrafill_study::StudyError;

/// The study cannot go on.
pub(crate) fn broken(why: impl ToString) -> StudyError {
    StudyError::Broken {
        place: crate::STUDY.to_owned(),
        message: why.to_string(),
    }
}
