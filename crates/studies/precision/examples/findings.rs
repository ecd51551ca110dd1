// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prints where the numerical suite contradicts a coordinate route:
//! `crates/ground/texture/src/suite_findings.csv`.
//!
//! `cargo run --release -p terrafill-precision --example findings > crates/ground/texture/src/suite_findings.csv`
//! measures the whole suite on the device there is, some minutes.

use terrafill_precision::{measure_suite, suite_findings};
use terrafill_texture::SuiteFinding;

#[allow(
    clippy::print_stdout,
    reason = "a command-line tool reports on standard output"
)]
fn main() -> anyhow::Result<()> {
    let rows = measure_suite()?;
    anyhow::ensure!(!rows.is_empty(), "no rows of the suite");
    print!("{}", SuiteFinding::table(&suite_findings(&rows)));
    Ok(())
}
