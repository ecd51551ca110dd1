// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a command ended, and what it prints.

use crate::colour::error_mark;
use crate::wrap::wrapped;
use std::io::{self, Write as _};

/// How a command ended; the numbers are the exit codes of `terrafill --help`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done = 0,
    Regression = 1,
    BadInput = 2,
    Inconclusive = 3,
    NothingMeasured = 4,
    NoDevice = 5,
    /// The machine failed: a full disk, a base that does not build.
    Infrastructure = 6,
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
            6 => Self::Infrastructure,
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

/// Writes to standard output and flushes it.
///
/// # Errors
/// [`Outcome::BadInput`] when not everything was written, such as to a full disk. A reader that closed
/// the pipe has seen enough, which is no error.
pub(crate) fn print(text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    written(out.write_all(text.as_ref()).and_then(|()| out.flush()))
}

/// Prints a JSON value in lines, its control characters written out: serde leaves DEL and what
/// follows it as they are, and some terminals obey those.
pub(crate) fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::bad_input)?;
    let mut shown = String::with_capacity(text.len() + 1);
    for character in text.chars() {
        if character.is_control() && character != '\n' {
            shown += &format!("\\u{:04x}", u32::from(character));
        } else {
            shown.push(character);
        }
    }
    shown.push('\n');
    print(shown)
}

/// What became of a write to standard output.
pub(crate) fn written(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::bad_input(
            format!("standard output: cannot be written: {error}"),
        )),
        _ => Ok(()),
    }
}

/// Characters of a line on standard error at most: of longer ones the rest stands below, behind [`INDENT`].
const WIDTH: usize = 200;
/// Begins what is the rest of the line above.
const INDENT: &str = "    ";

/// Writes an error to standard error, as [`complain`] does.
pub(crate) fn complain_of_error(problem: impl std::fmt::Display) {
    complain(format!("{} {problem}", error_mark()));
}

/// Writes a line to standard error. Where that cannot be written there is no place left to say so:
/// the exit code still does.
pub(crate) fn complain(line: impl std::fmt::Display) {
    let lines = wrapped(&line.to_string(), WIDTH - INDENT.len());
    drop(writeln!(
        io::stderr(),
        "{}",
        lines.join(&format!("\n{INDENT}"))
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_closed_pipe_is_a_write_that_may_fail() {
        let failed = |kind: io::ErrorKind| written(Err(kind.into()));
        assert!(failed(io::ErrorKind::BrokenPipe).is_ok());
        assert!(written(Ok(())).is_ok());
        let failure = failed(io::ErrorKind::StorageFull).expect_err("a full disk");
        assert_eq!(failure.outcome, Outcome::BadInput);
        assert!(
            failure
                .message
                .starts_with("standard output: cannot be written: ")
        );
    }
}
