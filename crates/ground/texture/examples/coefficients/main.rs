// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prints `crates/ground/texture/src/coefficients.csv`, fitted anew.
//!
//! Print into another file and move it: the example embeds the table.
//! `cargo run -p terrafill-texture --example coefficients > coefficients.csv`

mod double_double;
mod remez;
#[cfg(test)]
mod tests;

#[allow(
    clippy::print_stdout,
    reason = "a command-line tool reports on standard output"
)]
fn main() -> Result<(), remez::RemezError> {
    print!("{}", remez::coefficients_table()?);
    Ok(())
}
