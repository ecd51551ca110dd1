// SPDX-License-Identifier: MIT OR Apache-2.0
//! How chapters reach their verdicts: two cases are compared by one [`Comparison`], which refuses what
//! cannot be compared, and what a paper claims is read from its file by [`Paper`].

mod claims;
mod comparison;
mod settling;

pub use claims::{Basis, Claimed, Paper, PaperError, Tested, Told, claims_blocks, claims_table};
pub use comparison::{Answer, Comparison, Follows, REFUSED, Refused, band, overall};
pub use settling::bench_command;
