// SPDX-License-Identifier: MIT OR Apache-2.0
//! The reference as a backend: one ray and one classification per pixel.

use crate::locator::{Locator, Point};
use crate::surface::SurfaceTriangles;
use rayon::prelude::*;
use terrafill_frame::{
    Backend, BackendError, Capabilities, Frame, FrameInput, MemoryUse, NO_REGION,
};

/// Judges frames on the CPU, in f64.
#[derive(Debug)]
pub struct ReferenceBackend {
    capabilities: Capabilities,
    /// Scene and view of the last `prepare`.
    prepared: Option<(String, String)>,
}

/// A judged frame.
#[derive(Debug, Clone)]
pub struct ReferenceFrame {
    /// The picture, by the first inside test; where regions overlap, the last one.
    pub frame: Frame,
    /// Per pixel: whether the two inside tests differ about any region there.
    pub disagreements: Vec<bool>,
}

impl ReferenceFrame {
    /// Pixels about which the two inside tests differ.
    #[must_use]
    pub fn disagreement_px(&self) -> u64 {
        self.disagreements.iter().filter(|&&differ| differ).count() as u64
    }
}

impl Default for ReferenceBackend {
    fn default() -> Self {
        Self::new()
    }
}

impl ReferenceBackend {
    /// A reference, ready to judge.
    #[must_use]
    pub fn new() -> Self {
        Self {
            capabilities: Capabilities {
                backend: "reference",
                adapter: "cpu".to_owned(),
                gpu_timestamps: false,
                pipeline_statistics: false,
            },
            prepared: None,
        }
    }

    /// Judges `input`; the same input gives the same frame whatever the number of threads.
    ///
    /// # Errors
    /// [`BackendError::Unsupported`] when a region leaves open what is inside it.
    pub fn judge(&self, input: &FrameInput) -> Result<ReferenceFrame, BackendError> {
        Ok(judge(input, &self.locator(input)?))
    }

    fn locator(&self, input: &FrameInput) -> Result<Locator, BackendError> {
        Locator::new(&input.scene.regions, input.scene.edge_rule).map_err(|error| {
            BackendError::Unsupported {
                capability: format!("a reading of its regions: {error}"),
                adapter: format!("the {} of {}", self.capabilities.backend, input.scene.name),
            }
        })
    }
}

impl Backend for ReferenceBackend {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// Checks that every region can be judged. The reference keeps nothing between frames, so the
    /// memory that it holds is none.
    fn prepare(&mut self, input: &FrameInput) -> Result<MemoryUse, BackendError> {
        self.locator(input)?;
        self.prepared = Some((input.scene.name.clone(), input.view.clone()));
        Ok(MemoryUse::default())
    }

    fn render(&mut self, input: &FrameInput) -> Result<Frame, BackendError> {
        let asked = (input.scene.name.clone(), input.view.clone());
        if self.prepared.as_ref() != Some(&asked) {
            return Err(BackendError::NotPrepared {
                backend: self.capabilities.backend,
                scene: asked.0,
                view: asked.1,
            });
        }
        Ok(self.judge(input)?.frame)
    }
}

/// What one pixel shows.
#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    id: u32,
    is_surface: bool,
    differ: bool,
    is_non_finite: bool,
}

/// [`ReferenceBackend::judge`] by a given locator.
pub(crate) fn judge(input: &FrameInput, locator: &Locator) -> ReferenceFrame {
    let surface = SurfaceTriangles::new(&input.surface_rte, &input.scene.surface.triangles);
    let width = input.size.width as usize;
    let mut pixels = vec![Pixel::default(); input.size.pixel_count()];
    if width > 0 {
        pixels
            .par_chunks_mut(width)
            .zip(0..input.size.height)
            .for_each(|(pixels, row)| {
                for (pixel, column) in pixels.iter_mut().zip(0..) {
                    *pixel = judge_pixel(input, locator, &surface, column, row);
                }
            });
    }
    let non_finite = pixels.iter().filter(|pixel| pixel.is_non_finite).count() as u64;
    ReferenceFrame {
        frame: Frame {
            size: input.size,
            ids: pixels.iter().map(|pixel| pixel.id).collect(),
            surface: pixels.iter().map(|pixel| pixel.is_surface).collect(),
            non_finite: non_finite + surface.non_finite(),
            counters: None,
            texture: None,
        },
        disagreements: pixels.iter().map(|pixel| pixel.differ).collect(),
    }
}

fn judge_pixel(
    input: &FrameInput,
    locator: &Locator,
    surface: &SurfaceTriangles,
    column: u32,
    row: u32,
) -> Pixel {
    let direction = input.camera.pixel_direction_ecef(input.size, column, row);
    let Some(depth) = surface.hit(direction, input.camera.near_m) else {
        return Pixel::default();
    };
    let hit_ecef = input.camera.eye_ecef + direction * depth;
    let geodetic = input.scene.body.ecef_to_geodetic(hit_ecef);
    let mut pixel = Pixel {
        id: NO_REGION,
        is_surface: true,
        ..Pixel::default()
    };
    let longitude_deg = geodetic.longitude_rad.to_degrees();
    let latitude_deg = geodetic.latitude_rad.to_degrees().clamp(-90.0, 90.0);
    let Some(point) = Point::new(longitude_deg, latitude_deg) else {
        pixel.is_non_finite = true;
        return pixel;
    };
    locator.for_each_region(&point, |region, verdicts| {
        if verdicts.first {
            pixel.id = u32::try_from(region + 1).expect("fewer regions than bytes of memory");
        }
        pixel.differ |= verdicts.first != verdicts.second;
    });
    pixel
}
