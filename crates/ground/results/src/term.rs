// SPDX-License-Identifier: MIT OR Apache-2.0
//! A word of a report and what it means.

/// A word of reports with its meaning in a line, written where the thing is declared that it names.
pub type Term = (&'static str, &'static str);
