// SPDX-License-Identifier: MIT OR Apache-2.0
//! What thinning shares with whoever asks for levels.

use super::arcs::Arcs;
use super::deviation::Judge;
use crate::{EdgeRule, Ellipsoid, Region};
use std::sync::Arc;

/// The boundaries of a set of regions, each shared border once.
#[derive(Debug)]
pub struct SharedBoundaries {
    pub(super) regions: Arc<[Region]>,
    pub(super) rule: EdgeRule,
    pub(super) body: Ellipsoid,
    pub(super) judge: Judge,
    pub(super) arcs: Arcs,
    /// Of each ring, which poles it holds.
    pub(super) holds_poles: Vec<[bool; 2]>,
    /// Of each ring, its size where it may be left out.
    pub(super) ring_sizes_m: Vec<f64>,
}
