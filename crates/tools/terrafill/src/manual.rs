// SPDX-License-Identifier: MIT OR Apache-2.0
//! `completions` and `man`: the command line for a shell and for `man`.

use crate::arguments::Arguments;
use crate::outcome::{Failure, Outcome, print};
use clap::CommandFactory as _;
use clap_complete::aot::Shell;
use std::path::Path;

pub(crate) fn completions(shell: Shell) -> Result<Outcome, Failure> {
    let mut text = Vec::new();
    clap_complete::aot::generate(shell, &mut Arguments::command(), "terrafill", &mut text);
    print(text)?;
    Ok(Outcome::Done)
}

pub(crate) fn man(folder: &Path) -> Result<Outcome, Failure> {
    let written = std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), folder));
    let shown = folder.display();
    written.map_err(|error| Failure::bad_input(format!("{shown}: cannot be written: {error}")))?;
    print(format!(
        "wrote {shown}/terrafill.1 and a page for each command\n"
    ))?;
    Ok(Outcome::Done)
}
