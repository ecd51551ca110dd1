// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference: one program for all tests that use the crate as others do.

mod beyond_a_hemisphere;
mod edge_cases;
mod locate_random;
mod public_reports;
mod sides;
