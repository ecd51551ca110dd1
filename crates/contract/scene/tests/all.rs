// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes as files have them: one program for all tests that use the crate as others do.

mod islands;
mod scene_file;
mod shipped;
mod sweeps;
