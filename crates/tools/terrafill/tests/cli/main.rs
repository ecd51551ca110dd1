// SPDX-License-Identifier: MIT OR Apache-2.0
//! The built program, driven as a user drives it: arguments and files in; exit code, standard
//! output, standard error and files out.

mod bad_input;
mod bench;
mod committed;
mod data;
mod failed_writes;
mod folders;
mod gate;
mod harness;
mod history;
mod inputs;
mod killed;
mod lagoon;
mod locate;
mod manual;
mod mesh;
mod own;
mod pictures;
mod readme;
mod render;
mod sizes;
mod surfaces;
mod usage;
mod words;
