// SPDX-License-Identifier: MIT OR Apache-2.0
//! The command line: parses arguments, calls the crates, prints, and turns errors into exit codes.
//! No logic of its own.
#![allow(
    clippy::print_stdout,
    reason = "printing to standard output is what a command line is for"
)]

mod arguments;
mod bench;
mod environment;
mod inspect;
mod locate;
mod mesh;
mod output;
mod progress;
mod regions;
mod registry;
mod render;
mod usage;

use arguments::{Arguments, Verb};
use clap::Parser as _;
use std::process::ExitCode;

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
    outcome: Outcome,
    message: String,
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

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return usage::answer(&error),
    };
    let result = match arguments.verb {
        Verb::Bench(arguments) => bench::run(&arguments),
        Verb::Report(arguments) => bench::report(&arguments),
        Verb::Merge(arguments) => bench::merge(&arguments),
        Verb::Render(arguments) => render::run(&arguments),
        Verb::Mesh(arguments) => mesh::run(&arguments),
        Verb::Locate(arguments) => locate::run(&arguments),
        Verb::Scenes(arguments) => inspect::scenes(&arguments),
        Verb::Studies(arguments) => inspect::studies(&arguments),
        Verb::Devices => inspect::devices(),
        Verb::GrowthSample(arguments) => bench::growth_sample(&arguments),
    };
    let outcome = result.unwrap_or_else(|failure| {
        for problem in failure.message.lines() {
            eprintln!("error: {problem}");
        }
        failure.outcome
    });
    ExitCode::from(outcome as u8)
}

/// Writes to standard output; a reader that closed the pipe has seen enough, which is no error.
pub(crate) fn print(text: &str) {
    use std::io::Write as _;
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}
