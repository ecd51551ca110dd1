// SPDX-License-Identifier: MIT OR Apache-2.0
//! Handles of a device, destroyed by whoever holds them.

use crate::Gpu;
use crate::failure::failure;
use crate::handle::Handle;
use ash::prelude::VkResult;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// A handle of a device, destroyed with this.
#[derive(Debug)]
pub(crate) struct Owned<H: Handle> {
    gpu: Arc<Gpu>,
    pub(crate) raw: H,
}

impl<H: Handle> Owned<H> {
    /// Takes over what was made, or gives the error of making `what`.
    ///
    /// # Safety
    /// `made` is this device's, nobody else destroys it, and what uses it is waited for before this is
    /// dropped.
    pub(crate) unsafe fn new(
        gpu: &Arc<Gpu>,
        what: &str,
        made: VkResult<H>,
    ) -> Result<Self, DeviceError> {
        // SAFETY: the caller's promise.
        unsafe { Self::sized(gpu, what, 0, made) }
    }

    /// As [`Owned::new`], of what needs so many bytes.
    ///
    /// # Safety
    /// As [`Owned::new`].
    pub(crate) unsafe fn sized(
        gpu: &Arc<Gpu>,
        what: &str,
        bytes: u64,
        made: VkResult<H>,
    ) -> Result<Self, DeviceError> {
        Ok(Self {
            raw: made.map_err(|error| failure(error, what, bytes))?,
            gpu: Arc::clone(gpu),
        })
    }

    pub(crate) fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }
}

impl<H: Handle> Drop for Owned<H> {
    fn drop(&mut self) {
        // SAFETY: of this device, and done with, as its maker promised.
        unsafe { self.raw.destroy(&self.gpu.device) };
    }
}
