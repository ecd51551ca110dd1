// SPDX-License-Identifier: MIT OR Apache-2.0
//! How devices fail between a frame's input and its picture.

use terrafill_variant::SwitchError;

/// What can go wrong between a frame's input and its picture.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// The adapter lacks something; becomes a *skipped* row with this reason.
    #[error("{adapter} lacks {capability}")]
    Unsupported {
        /// What is missing.
        capability: String,
        /// Where it is missing.
        adapter: String,
    },
    /// A buffer or texture could not be had.
    #[error("out of memory: {what} needs {bytes} bytes")]
    OutOfMemory {
        /// Which resource.
        what: String,
        /// How large.
        bytes: u64,
    },
    /// The input is larger than the technique can hold; becomes a *failed* row.
    #[error("{what}: found {found}, allowed {allowed}")]
    OverCapacity {
        /// Which quantity.
        what: String,
        /// Its value.
        found: u64,
        /// The limit.
        allowed: u64,
    },
    /// The device is gone.
    #[error("the device was lost: {0}")]
    DeviceLost(String),
    /// A shader did not compile.
    #[error("shader {name}: {message}")]
    Shader {
        /// File.
        name: String,
        /// Compiler's words.
        message: String,
    },
    /// Switches that do not go together, or not with the scene.
    #[error(transparent)]
    Switch(#[from] SwitchError),
    /// [`crate::FillBackend::update`] was called for other regions than those that changed.
    #[error("changed regions: found {found:?}, allowed {allowed:?}")]
    ChangedRegions {
        /// Regions claimed to have changed.
        found: Vec<usize>,
        /// Regions that did.
        allowed: Vec<usize>,
    },
    /// Something was to be drawn before what it needs was made.
    #[error("there is no {0} yet")]
    Missing(&'static str),
    /// [`crate::FillBackend::render`] was called before [`crate::FillBackend::prepare`], or with
    /// another input.
    #[error("backend {backend} is not prepared for view {view} of scene {scene}")]
    NotPrepared {
        /// Which backend.
        backend: &'static str,
        /// Scene to be drawn.
        scene: String,
        /// View to be drawn.
        view: String,
    },
}

impl DeviceError {
    /// `adapter` lacks `capability`.
    #[must_use]
    pub fn unsupported(capability: &str, adapter: &str) -> Self {
        Self::Unsupported {
            capability: capability.to_owned(),
            adapter: adapter.to_owned(),
        }
    }

    /// Refuses more of `what` than is allowed.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub fn check_capacity(
        what: &str,
        found: impl Into<u64>,
        allowed: impl Into<u64>,
    ) -> Result<(), Self> {
        let (found, allowed) = (found.into(), allowed.into());
        if found <= allowed {
            return Ok(());
        }
        Err(Self::OverCapacity {
            what: what.to_owned(),
            found,
            allowed,
        })
    }
}
