// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prints `crates/ground/texture/src/coefficients.rs` as the generator makes it.
//!
//! `cargo run -p terrafill-texture --example coefficients > crates/ground/texture/src/coefficients.rs`

#[allow(
    clippy::print_stdout,
    reason = "a command-line tool reports on standard output"
)]
fn main() -> Result<(), terrafill_texture::RemezError> {
    print!("{}", terrafill_texture::coefficients_source()?);
    Ok(())
}
