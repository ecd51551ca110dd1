// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes and volumes of regions: one program for all tests that use the crate as others do.

mod as_people_have_them;
mod deviation;
mod edge_cases;
mod footprints;
mod fuzz_corpus;
mod fuzz_regressions;
mod level_of_detail;
mod meshes;
mod outlines;
mod overlaps;
mod pole_wedges;
mod properties;
mod random_shapes;
mod reading;
mod real_data;
mod self_crossings_at_cuts;
mod shape_family;
mod volumes;
