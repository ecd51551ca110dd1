// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a backend promises, and how it fails.

use crate::{Frame, FrameInput, FrameTimes, MemoryUse};
use terrafill_scene::ImageSize;

/// What a backend runs on and what it can do there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Capabilities {
    /// `vertex`, `native`, `reference` …
    pub backend: &'static str,
    /// Adapter and driver, or `cpu`.
    pub adapter: String,
    /// Whether [`TimedBackend::time_frame`] can give GPU times.
    pub gpu_timestamps: bool,
    /// Whether vertex and fragment counts come with the counters.
    pub pipeline_statistics: bool,
}

/// What can go wrong between a frame's input and its picture.
#[derive(Debug, thiserror::Error)]
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
    Switch(#[from] crate::SwitchError),
    /// [`Backend::render`] was called before [`Backend::prepare`], or with another input.
    #[error("{backend} was not prepared for {scene}/{view}")]
    NotPrepared {
        /// Which backend.
        backend: &'static str,
        /// Scene asked for.
        scene: String,
        /// View asked for.
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

    /// A surface was asked for before there is one.
    #[must_use]
    pub fn no_surface() -> Self {
        Self::NotPrepared {
            backend: "surface",
            scene: String::new(),
            view: String::new(),
        }
    }
}

/// One way to fill regions: a technique on an API, with its switches set.
///
/// The order is `prepare`, then any number of `render`s with the same input. A second `prepare`
/// replaces the first.
pub trait Backend {
    /// What this runs on.
    fn capabilities(&self) -> &Capabilities;

    /// Builds and uploads everything the frame needs; nothing is uploaded later unless the input
    /// changes.
    ///
    /// # Errors
    /// [`DeviceError`] when the adapter cannot hold or run it.
    fn prepare(&mut self, input: &FrameInput) -> Result<MemoryUse, DeviceError>;

    /// Fills every planned region of `input` and reads the picture back; same bytes out for the
    /// same adapter and driver.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`], or whatever the device reports.
    fn render(&mut self, input: &FrameInput) -> Result<Frame, DeviceError>;
}

/// A picture read back.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Size of the others.
    pub size: ImageSize,
    /// Four bytes a pixel, row 0 at the top; alpha 0 where nothing was filled.
    pub rgba: Vec<u8>,
    /// Reversed depth, 0 where there is no surface.
    pub depth: Vec<f32>,
}

/// A backend of the bench: it can be timed, shown, and names its switches.
pub trait VolumeBackend: TimedBackend {
    /// Layout or technique first, then the switches that differ from the default, `key=value`, in
    /// alphabetical order: the `variant` of its rows.
    fn variant_name(&self) -> String;

    /// Whether the picture tells regions apart; otherwise only the filled area is comparable.
    fn tells_regions_apart(&self) -> bool;

    /// What was settled for the input prepared last that its row should say, such as the routes of
    /// a textured fill.
    fn note(&self) -> Option<String> {
        None
    }

    /// Draws the frame in the regions' own colours, or a textured fill in its picture's, over the
    /// shaded surface.
    ///
    /// # Errors
    /// As [`Backend::render`].
    fn picture(&mut self, input: &FrameInput) -> Result<Picture, DeviceError>;

    /// Draws the surface into the backend's own targets, if it has any: once a round, untimed, so
    /// that every timed fill finds the same surface. Backends that share targets leave it to those.
    ///
    /// # Errors
    /// As [`Backend::render`].
    fn draw_own_surface(&mut self, _input: &FrameInput) -> Result<(), DeviceError> {
        Ok(())
    }
}

/// A backend whose frames can be timed without reading anything back.
pub trait TimedBackend: Backend {
    /// Fills exactly as [`Backend::render`] does, on top of the surface that the targets hold
    /// already, and waits for it. A fill leaves depth untouched, so one surface serves many fills.
    ///
    /// # Errors
    /// As [`Backend::render`].
    fn time_frame(&mut self, input: &FrameInput) -> Result<FrameTimes, DeviceError>;
}
