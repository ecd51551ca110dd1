// SPDX-License-Identifier: MIT OR Apache-2.0
//! The screen grid: one program for all tests that use the crate as others do.

mod geometry;
mod seam;
mod view;
