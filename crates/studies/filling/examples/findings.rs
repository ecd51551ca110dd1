// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prints what the numerical suite has against coordinate routes: `crates/ground/texture/src/suite_findings.csv`.
//!
//! `cargo run --release -p terrafill-filling --example findings > crates/ground/texture/src/suite_findings.csv`
//! measures the whole suite on the device there is, some minutes. With the folder of a run that holds
//! the suite's rows, it reads those: `… --example findings -- RUN`.

use terrafill_filling::{measure_suite, suite_findings};
use terrafill_results::legacy::{RunEnvironment, RunFolder, RunPlan};
use terrafill_texture::SuiteFinding;

#[allow(
    clippy::print_stdout,
    reason = "a command-line tool reports on standard output"
)]
fn main() -> anyhow::Result<()> {
    let temporary = tempfile::tempdir()?;
    let run = match std::env::args().nth(1) {
        Some(folder) => RunFolder::open(folder.as_ref())?,
        None => {
            let path = temporary.path().join("suite");
            let run = RunFolder::create(&path, &RunEnvironment::default(), &RunPlan::default())?;
            measure_suite(None, &run)?;
            run
        }
    };
    anyhow::ensure!(
        run.precision_missing()?.is_empty(),
        "rows of the suite are missing: what they would have found is not known"
    );
    let rows = run.precision()?;
    anyhow::ensure!(!rows.is_empty(), "no rows of the suite");
    print!("{}", SuiteFinding::table(&suite_findings(&rows)));
    Ok(())
}
