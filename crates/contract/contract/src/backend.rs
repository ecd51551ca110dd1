// SPDX-License-Identifier: MIT OR Apache-2.0
//! What an opened backend promises.

use crate::{DeviceError, FillInput, Frame, FrameTimes, MemoryUse, Needs, Picture};

/// What an update handed to the device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Uploaded {
    /// Bytes, those of the view's constants included.
    pub bytes: u64,
    /// Meshes whose geometry was uploaded: those that changed, or all of the scene where one of them
    /// does not fit into its old place.
    pub regions: Vec<usize>,
}

/// One variant of a technique, opened on render targets.
///
/// The order is `prepare`, then any number of frames with the same input. A second `prepare`
/// replaces the first.
pub trait FillBackend {
    /// Whether the picture tells regions apart; otherwise only the filled area is comparable.
    fn tells_regions_apart(&self) -> bool;

    /// What was settled for the input prepared last that its row should say, such as the routes of
    /// a textured fill.
    fn note(&self) -> Option<String> {
        None
    }

    /// What `input`, which was prepared last, holds and leaves out; `None` of a backend that keeps no such
    /// record.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`].
    fn needs(&self, _input: &FillInput) -> Result<Option<Needs>, DeviceError> {
        Ok(None)
    }

    /// Builds and uploads everything the frame needs; nothing is uploaded later unless the input
    /// changes.
    ///
    /// # Errors
    /// [`DeviceError`] when the adapter cannot hold or run it.
    fn prepare(&mut self, input: &FillInput) -> Result<MemoryUse, DeviceError>;

    /// Uploads what differs from the input prepared or updated last, whose meshes those of `input`
    /// were made from by [`terrafill_plan::RegionSet::with_changed`]. A region with as many vertices and
    /// indices as before is rewritten where it lies; otherwise everything is uploaded.
    ///
    /// - `changed`: indices into the scene's meshes
    ///
    /// # Errors
    /// As [`FillBackend::prepare`]; [`DeviceError::NotPrepared`] when something else was prepared,
    /// [`DeviceError::ChangedRegions`] when other regions changed. Both leave what is prepared.
    fn update(&mut self, input: &FillInput, changed: &[usize]) -> Result<Uploaded, DeviceError>;

    /// Draws the surface, fills every planned region of `input` and reads the picture back; same
    /// bytes out for the same adapter and driver.
    ///
    /// # Errors
    /// [`DeviceError::NotPrepared`], or whatever the device reports.
    fn render(&mut self, input: &FillInput) -> Result<Frame, DeviceError>;

    /// The frame of [`FillBackend::render`] for who looks at its picture and at what a frame hands over. It
    /// may lack the counts that take draws of their own, such as of fragments.
    ///
    /// # Errors
    /// As [`FillBackend::render`].
    fn render_uncounted(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        self.render(input)
    }

    /// Draws the frame in the regions' own colours, or a textured fill in its picture's, over the
    /// shaded surface.
    ///
    /// # Errors
    /// As [`FillBackend::render`].
    fn picture(&mut self, input: &FillInput) -> Result<Picture, DeviceError>;

    /// Draws the surface into the render targets and gives its GPU time, where there is a clock.
    /// Once a round is enough for all backends that share the targets.
    ///
    /// # Errors
    /// As [`FillBackend::render`].
    fn draw_surface(&mut self, input: &FillInput) -> Result<Option<f64>, DeviceError>;

    /// Fills exactly as [`FillBackend::render`] does, on top of the surface that the targets hold
    /// already, and waits for it. A fill leaves depth untouched, so one surface serves many fills.
    ///
    /// # Errors
    /// As [`FillBackend::render`].
    fn time_frame(&mut self, input: &FillInput) -> Result<FrameTimes, DeviceError>;
}
