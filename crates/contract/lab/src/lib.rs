// SPDX-License-Identifier: MIT OR Apache-2.0
//! How chapters reach their verdicts. A [`Comparison`] holds two cases side by side, and refuses what
//! cannot be compared. A [`Paper`] has the claims of one document, as read from its file.

mod claims;
mod comparison;
mod settling;

pub use claims::{Basis, Claimed, Paper, PaperError, Tested, Told, claims_blocks, claims_table};
pub use comparison::{Answer, Comparison, Follows, REFUSED, Refused, overall};
pub use settling::bench_command;
