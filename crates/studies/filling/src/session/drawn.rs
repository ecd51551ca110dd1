// SPDX-License-Identifier: MIT OR Apache-2.0
//! A probe frame with what drew it.

use std::rc::Rc;
use terrafill_contract::{FillBackend, FillInput, Frame, MemoryUse, ids_hash, mask_hash};

/// A probe frame with what drew it.
pub(super) struct ProbePicture {
    pub(super) backend: Box<dyn FillBackend>,
    pub(super) memory: MemoryUse,
    pub(super) frame: Frame,
    pub(super) input: Rc<FillInput>,
    pub(super) plan_cpu_ms: Option<f64>,
    pub(super) prepare_cpu_ms: f64,
}

impl ProbePicture {
    /// Hashes of the mask and of the ids; the latter is empty where regions are not told apart.
    pub(super) fn hashes(&self) -> (String, String) {
        let ids = if self.backend.tells_regions_apart() {
            ids_hash(&self.frame)
        } else {
            String::new()
        };
        (mask_hash(&self.frame), ids)
    }
}
