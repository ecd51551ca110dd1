// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames of a surface whose pieces are still being made, and a thread that makes them.

use crate::HeightRange;
use crate::surface::{Refinement, Refining, Surface, SurfaceError, SurfaceFrame};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use terrafill_core::Extent;
use terrafill_scene::{Camera, ImageSize};

/// Rest of a thread that has no piece to make: far shorter than a frame.
const REST: Duration = Duration::from_micros(200);

/// A refining surface whose frames are those of [`Refining::frame_now`], for scenes to be drawn over it as it is.
#[derive(Debug)]
pub struct AsItIs {
    surface: Arc<dyn Surface>,
    last: Mutex<Refinement>,
}

impl AsItIs {
    /// `None` where the surface has no pieces.
    #[must_use]
    pub fn new(surface: Arc<dyn Surface>) -> Option<Self> {
        surface.refining()?;
        Some(Self {
            surface,
            last: Mutex::default(),
        })
    }

    /// Of the last frame.
    #[must_use]
    pub fn last(&self) -> Refinement {
        *self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Surface for AsItIs {
    fn kind(&self) -> &'static str {
        self.surface.kind()
    }

    fn heights(&self, extent: &Extent) -> HeightRange {
        self.surface.heights(extent)
    }

    fn true_height_m(&self, longitude_deg: f64, latitude_deg: f64) -> Option<f64> {
        self.surface.true_height_m(longitude_deg, latitude_deg)
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        let Some(refining) = self.surface.refining() else {
            return self.surface.frame(camera, size);
        };
        let (frame, refinement) = refining.frame_now(camera, size)?;
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = refinement;
        Ok(frame)
    }

    fn refining(&self) -> Option<&dyn Refining> {
        self.surface.refining()
    }
}

/// A thread that makes the pieces a surface asks for, until this is dropped.
#[derive(Debug)]
pub struct InBackground {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl InBackground {
    /// Begins at once.
    #[must_use]
    pub fn start(surface: Arc<dyn Surface>) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let is_over_there = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || {
            let Some(refining) = surface.refining() else {
                return;
            };
            while !is_over_there.load(Ordering::Relaxed) {
                // One by one, so that a new frame's wishes are heard soon.
                if refining.refine(1) == 0 {
                    std::thread::sleep(REST);
                }
            }
        });
        Self {
            is_over,
            thread: Some(thread),
        }
    }
}

impl Drop for InBackground {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic in it was printed there, and frames go on without new pieces.
            let _ = thread.join();
        }
    }
}
