// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces whose pieces are made while frames are drawn from those that are there.

use crate::{Surface, SurfaceError, SurfaceFrame};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use terrafill_core::Extent;
use terrafill_scene::{Camera, HeightRange, ImageSize};

/// Rest of a thread that has no piece to make: far shorter than a frame.
const REST: Duration = Duration::from_micros(200);

/// A surface that need not wait for all pieces of a view. [`Surface::frame`] waits for them.
pub trait Refining: Send + Sync {
    /// What can be drawn of a view with the pieces that are there, and how far that is from what is wanted.
    /// The missing ones are asked for, in place of those asked for before.
    ///
    /// # Errors
    /// As [`Surface::frame`].
    fn frame_now(
        &self,
        camera: &Camera,
        size: ImageSize,
    ) -> Result<(SurfaceFrame, Refinement), SurfaceError>;

    /// Makes up to `most` of the pieces that the last frame asked for, those that lack most first, and says how
    /// many it made. Pieces of earlier frames leave where the memory would exceed its budget; where all are in
    /// use nothing is made.
    fn refine(&self, most: usize) -> usize;

    /// Lets go of every piece.
    fn forget(&self);

    /// What is kept now.
    fn memory(&self) -> PieceMemory;
}

/// How far a frame is from what its view wants.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Refinement {
    /// Pieces that were asked for. 0: the frame is what [`Surface::frame`] gives.
    pub waiting: usize,
    /// Pieces that are drawn.
    pub drawn: usize,
    /// How far from the full resolution what is drawn may be on the screen, pixels: a bound.
    pub error_px: f64,
}

/// Pieces in memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PieceMemory {
    /// Of all pieces.
    pub bytes: u64,
    /// What they may take.
    pub budget_bytes: u64,
    /// How many there are.
    pub pieces: usize,
    /// Made since the surface was opened.
    pub made: u64,
    /// Of these, let go to make room.
    pub evicted: u64,
}

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
        let told = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || {
            let Some(refining) = surface.refining() else {
                return;
            };
            while !told.load(Ordering::Relaxed) {
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
