// SPDX-License-Identifier: MIT OR Apache-2.0
//! Folders of results: one program for all tests that use the crate as others do.

mod folder;
mod glossary;
