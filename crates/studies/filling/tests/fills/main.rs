// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fills on devices, held against the reference; studies of them, run to the end.
//!
//! One program: each one more would be linked with both device crates, which takes longer than most tests.

mod camera_path;
mod compute_against_reference;
mod cover_tiles;
mod depth_rule;
mod drawing;
mod extreme_suite;
mod extreme_views;
mod far_level;
mod held_meshes;
mod interior;
mod level_of_detail;
mod merged_draws;
mod native_against_reference;
mod needs;
mod over_a_spiral;
mod over_terrain;
mod overlaps;
mod parts;
mod run;
mod runs;
mod screen_grid;
mod steady_state;
mod surface_picture;
mod switches_of_2007;
mod textured_against_reference;
mod update;
mod vertex_against_reference;
mod wall_heights;
