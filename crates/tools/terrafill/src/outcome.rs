// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a command ended, and what it prints.

/// How a command ended; the numbers are the exit codes of `terrafill --help`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done = 0,
    Regression = 1,
    BadInput = 2,
    Inconclusive = 3,
    NothingMeasured = 4,
    NoDevice = 5,
}

impl Outcome {
    /// The outcome with this exit code.
    pub(crate) fn from_code(code: u8) -> Self {
        match code {
            0 => Self::Done,
            1 => Self::Regression,
            3 => Self::Inconclusive,
            4 => Self::NothingMeasured,
            5 => Self::NoDevice,
            _ => Self::BadInput,
        }
    }
}

/// A message for standard error, one problem per line, and the exit code that goes with it.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) outcome: Outcome,
    pub(crate) message: String,
}

impl Failure {
    /// The input or the usage is wrong.
    pub(crate) fn bad_input(error: impl std::fmt::Display) -> Self {
        Self {
            outcome: Outcome::BadInput,
            message: error.to_string(),
        }
    }

    /// No device can do it.
    pub(crate) fn no_device(error: impl std::fmt::Display) -> Self {
        Self {
            outcome: Outcome::NoDevice,
            message: error.to_string(),
        }
    }
}

/// Writes to standard output; a reader that closed the pipe has seen enough, which is no error.
pub(crate) fn print(text: &str) {
    use std::io::Write as _;
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}
