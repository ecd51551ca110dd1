// SPDX-License-Identifier: MIT OR Apache-2.0
//! Answers to command lines that ask for help or cannot be understood.
//!
//! A wrong value gets the one line that wrong input gets everywhere, with what was found and what is
//! allowed; for the rest clap's own text says best what the verb looks like.

use crate::outcome::{Failure, Outcome, complain_of_error, written};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error as _;
use std::io::Write as _;
use terrafill_scene::choices;

/// Prints help to standard output, problems to standard error.
pub(crate) fn answer(error: &clap::Error) -> Result<Outcome, Failure> {
    if let Some(line) = wrong_value(error) {
        complain_of_error(line);
        return Ok(Outcome::BadInput);
    }
    let printed = error.print();
    if error.use_stderr() {
        return Ok(Outcome::BadInput);
    }
    written(printed.and_then(|()| std::io::stdout().flush()))?;
    Ok(Outcome::Done)
}

/// `--edges: found "x", allowed: planar, great-ellipse`; nothing for other errors.
fn wrong_value(error: &clap::Error) -> Option<String> {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    let found = text(ContextKind::InvalidValue)?;
    let allowed = match (error.kind(), error.get(ContextKind::ValidValue)) {
        (ErrorKind::InvalidValue, Some(ContextValue::Strings(list))) if !list.is_empty() => {
            choices(found, list.iter().map(String::as_str))
        }
        (ErrorKind::ValueValidation, _) => error.source()?.to_string(),
        _ => return None,
    };
    let argument = text(ContextKind::InvalidArg)?.split(' ').next()?;
    Some(format!("{argument}: found {found:?}, allowed: {allowed}"))
}
