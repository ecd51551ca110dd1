// SPDX-License-Identifier: MIT OR Apache-2.0
//! The command line: parses arguments, calls the crates, prints, and turns errors into exit codes.
//! No logic of its own.
#![allow(
    clippy::print_stdout,
    reason = "printing to standard output is what a command line is for"
)]

mod arguments;
mod backfill;
mod bench;
mod clocks;
mod colour;
mod data;
mod devices;
mod draft;
mod environment;
mod fit;
mod gate;
mod history;
mod input;
mod inspect;
mod locate;
mod manual;
mod mesh;
mod outcome;
mod output;
mod progress;
mod read;
mod regions;
mod registry;
mod render;
mod report;
mod stop;
mod suite;
mod techniques;
mod usage;
mod version;
mod wrap;

use arguments::{Arguments, Verb};
use clap::{CommandFactory as _, FromArgMatches as _};
use outcome::{Failure, Outcome, complain_of_error};
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let colour = colour::asked(&words);
    let command = Arguments::command().color(colour);
    let parsed = command
        .try_get_matches()
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    let result = match parsed {
        Ok(arguments) => run(&arguments.verb),
        Err(error) => usage::answer(&error),
    };
    stop::wait_if_stopping();
    let outcome = result.unwrap_or_else(|failure| {
        for problem in failure.message.lines() {
            complain_of_error(problem);
        }
        failure.outcome
    });
    ExitCode::from(outcome as u8)
}

fn run(verb: &Verb) -> Result<Outcome, Failure> {
    match verb {
        Verb::Bench(arguments) => bench::run(arguments),
        Verb::Report(arguments) => bench::report(arguments),
        Verb::Merge(arguments) => bench::merge(arguments),
        Verb::Gate(arguments) => gate::run(arguments),
        Verb::Bless(arguments) => gate::bless(arguments),
        Verb::Compare(arguments) => history::compare(arguments),
        Verb::History(arguments) => history::run(arguments),
        Verb::Render(arguments) => render::run(arguments),
        Verb::Mesh(arguments) => mesh::run(arguments),
        Verb::Locate(arguments) => locate::run(arguments),
        Verb::Data(arguments) => data::run(arguments),
        Verb::Scene(arguments) => draft::run(arguments),
        Verb::Scenes(arguments) => inspect::scenes(arguments),
        Verb::Studies(arguments) => inspect::studies(arguments),
        Verb::Techniques(arguments) => techniques::run(arguments),
        Verb::Devices(arguments) => devices::run(arguments),
        Verb::Completions { shell } => manual::completions(*shell),
        Verb::Man { folder } => manual::man(folder),
        Verb::GrowthSample(arguments) => bench::growth_sample(arguments),
    }
}
