// SPDX-License-Identifier: MIT OR Apache-2.0
//! A view of a scene on CesiumJS's globe, as the contract wants it.

use crate::browser::Browser;
use crate::pose::{MAX_APART_PX, Matrices, Pose, apart_px};
use crate::way::{CesiumFill, NAME};
use serde::Deserialize;
use serde_json::{Value, json};
use terrafill_contract::{
    Counters, DeviceError, FillBackend, FillInput, Frame, FrameTimes, MemoryUse, NO_REGION,
    Picture, Uploaded, ViewId, paint,
};
use terrafill_core::Region;
use terrafill_scene::ImageSize;

/// CPU time that the frames of a sample take at least, milliseconds: fifty of the clock's steps.
const SAMPLE_CPU_MS: f64 = 500.0;

/// Frames of a sample at most.
const MAX_FRAMES: u32 = 40;

/// Regions whose ids fit into two channels of a colour; the third tells the bare surface from the sky.
const REGIONS: usize = 0xFFFF;

/// What the page says of itself.
#[derive(Deserialize)]
struct Opened {
    cesium: String,
    renderer: String,
    size: [u32; 2],
}

/// Bytes that the page holds for the regions, by kind.
#[derive(Deserialize)]
struct Held {
    vertex: u64,
    index: u64,
    texture: u64,
    buffers: u64,
}

/// What a frame asks of WebGL because of the regions.
#[derive(Deserialize)]
struct Work {
    draws: u64,
    vertices: u64,
    uploads: u64,
    uploaded: u64,
    buffers: u64,
    programs: u64,
}

/// What was prepared.
#[derive(Debug, Clone, Copy)]
struct Prepared {
    view_id: ViewId,
    revision: u64,
    /// Frames of a sample.
    frames: u32,
    /// Whether the next sample begins with the regions shown.
    shown_first: bool,
}

/// One way to fill, in a browser of its own.
#[derive(Debug)]
pub(crate) struct CesiumBackend {
    browser: Browser,
    way: CesiumFill,
    /// What the browser draws on.
    renderer: String,
    note: String,
    prepared: Option<Prepared>,
}

impl CesiumBackend {
    /// Opens the globe in `browser`.
    ///
    /// - `tiles_px`: error that the globe's tiles may show
    ///
    /// # Errors
    /// Those of the browser; [`DeviceError::Unsupported`] for images of this size.
    pub(crate) fn new(
        mut browser: Browser,
        way: CesiumFill,
        tiles_px: f64,
        size: ImageSize,
    ) -> Result<Self, DeviceError> {
        let opened: Opened = browser.call("open", json!([tiles_px]))?;
        if opened.size != [size.width, size.height] {
            let what = format!("images of {} × {} pixels", size.width, size.height);
            return Err(DeviceError::unsupported(&what, &opened.renderer));
        }
        let note = format!(
            "CesiumJS {} in {} on {}",
            opened.cesium, browser.product, opened.renderer
        );
        Ok(Self {
            browser,
            way,
            renderer: opened.renderer,
            note,
            prepared: None,
        })
    }

    fn check(&self, input: &FillInput) -> Result<Prepared, DeviceError> {
        let prepared = self.prepared;
        let revision = prepared.map(|prepared| prepared.revision);
        let view_id = prepared.map(|prepared| prepared.view_id);
        input.check_prepared(NAME, revision, view_id)?;
        prepared.ok_or_else(|| input.not_prepared(NAME))
    }

    /// CPU time and wall clock of a frame with the regions shown or hidden, milliseconds.
    fn frame_ms(&mut self, is_shown: bool, frames: u32) -> Result<[f64; 2], DeviceError> {
        let _: Value = self.browser.call("show", json!([is_shown]))?;
        let time = |browser: &mut Browser| browser.call::<f64>("time", json!([frames]));
        let (cpu_ms, wall_ms) = self.browser.cpu_ms(time)?;
        Ok([cpu_ms, wall_ms].map(|ms| ms / f64::from(frames)))
    }

    fn ids(&mut self, input: &FillInput) -> Result<(Vec<u32>, Vec<bool>), DeviceError> {
        let runs: Vec<i64> = self.browser.call("picture", json!([]))?;
        pixels_of(&runs, input.size, input.scene.regions.len()).ok_or_else(|| {
            DeviceError::DeviceLost("CesiumJS: a picture of another size".to_owned())
        })
    }
}

impl FillBackend for CesiumBackend {
    fn tells_regions_apart(&self) -> bool {
        true
    }

    /// Versions of library and browser, and what they draw on.
    fn note(&self) -> Option<String> {
        Some(self.note.clone())
    }

    fn prepare(&mut self, input: &FillInput) -> Result<MemoryUse, DeviceError> {
        let found = input.scene.regions.len();
        DeviceError::check_capacity("regions", found as u64, REGIONS as u64)?;
        let pose = Pose::new(&input.camera, input.size);
        let matrices: Matrices = self.browser.call("view", json!([pose]))?;
        let apart = apart_px(&input.camera, input.size, &matrices);
        if apart > MAX_APART_PX {
            return Err(DeviceError::DeviceLost(format!(
                "CesiumJS: its camera shows points {apart} px aside, allowed {MAX_APART_PX}"
            )));
        }
        let polygons = polygons(&input.scene.regions);
        let held: Held = self
            .browser
            .call("add", json!([self.way.name(), polygons]))?;
        let [cpu_ms, _] = self.frame_ms(true, 2)?;
        self.prepared = Some(Prepared {
            view_id: input.view_id,
            revision: input.scene.meshes.revision(),
            frames: frames_of_sample(cpu_ms),
            shown_first: false,
        });
        // Textures of the lookup hold its edges, those of the volumes what is constant for each polygon.
        let (edges, constants) = match self.way {
            CesiumFill::Volumes => (0, held.texture),
            CesiumFill::Lookup => (held.texture, 0),
        };
        Ok(MemoryUse {
            vertex_bytes: held.vertex + edges,
            index_bytes: held.index,
            constant_bytes: constants,
            buffers: held.buffers,
            upload_bytes: held.vertex + held.index + held.texture,
            ..MemoryUse::default()
        })
    }

    fn update(&mut self, _: &FillInput, _: &[usize]) -> Result<Uploaded, DeviceError> {
        let what = "regions that change one by one";
        Err(DeviceError::unsupported(what, &self.renderer))
    }

    fn render(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        self.check(input)?;
        let (ids, surface) = self.ids(input)?;
        let work: Work = self.browser.call("work", json!([]))?;
        Ok(Frame {
            size: input.size,
            ids,
            surface,
            non_finite: 0,
            counters: Some(Counters {
                draws: work.draws,
                vertices: work.vertices,
                upload_bytes: work.uploaded,
                uploads: work.uploads,
                buffer_creations: work.buffers,
                pipeline_creations: work.programs,
                ..Counters::default()
            }),
            texture: None,
        })
    }

    /// Its pixels in the colours of our pictures, so that the two can be laid side by side.
    fn picture(&mut self, input: &FillInput) -> Result<Picture, DeviceError> {
        let frame = self.render(input)?;
        let rgb = paint(&frame);
        let rgba = rgb
            .chunks_exact(3)
            .flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]);
        Ok(Picture {
            size: input.size,
            rgba: rgba.collect(),
            depth: Vec::new(),
        })
    }

    /// Its own surface is part of every frame, and subtracted.
    fn draw_surface(&mut self, _: &FillInput) -> Result<Option<f64>, DeviceError> {
        Ok(None)
    }

    /// Frames with the regions shown less frames with them hidden, which of them first by turns.
    fn time_frame(&mut self, input: &FillInput) -> Result<FrameTimes, DeviceError> {
        let prepared = self.check(input)?;
        let first = prepared.shown_first;
        let one = self.frame_ms(first, prepared.frames)?;
        let other = self.frame_ms(!first, prepared.frames)?;
        self.prepared = Some(Prepared {
            shown_first: !first,
            ..prepared
        });
        let (shown, hidden) = if first { (one, other) } else { (other, one) };
        Ok(FrameTimes {
            fill_cpu_ms: shown[0] - hidden[0],
            fill_wall_ms: shown[1] - hidden[1],
            ..FrameTimes::default()
        })
    }
}

/// Frames of a sample, by what one takes.
#[allow(clippy::cast_possible_truncation, reason = "clamped to a few")]
fn frames_of_sample(cpu_ms: f64) -> u32 {
    (SAMPLE_CPU_MS / cpu_ms)
        .ceil()
        .clamp(1.0, f64::from(MAX_FRAMES)) as u32
}

/// Polygons with the ids of their regions, rings of degrees.
fn polygons(regions: &[Region]) -> Vec<Value> {
    let all = regions.iter().enumerate().flat_map(|(index, region)| {
        region.polygons.iter().map(move |polygon| {
            let rings: Vec<&[[f64; 2]]> = polygon.rings().map(|ring| ring.vertices_deg()).collect();
            json!({ "id": index + 1, "rings": rings })
        })
    });
    all.collect()
}

/// Ids and where the surface is, from the page's runs; `None` when these are not as many as pixels. A
/// colour that is nobody's gets an id that no region has, so that it is seen.
fn pixels_of(runs: &[i64], size: ImageSize, regions: usize) -> Option<(Vec<u32>, Vec<bool>)> {
    let nobody = u32::try_from(regions + 1).ok()?;
    let (mut ids, mut surface) = (Vec::new(), Vec::new());
    for run in runs.chunks_exact(2) {
        let count = usize::try_from(run[1]).ok()?;
        if ids.len() + count > size.pixel_count() {
            return None;
        }
        let id = match run[0] {
            -2 | -1 => NO_REGION,
            id => u32::try_from(id).unwrap_or(nobody).min(nobody),
        };
        ids.resize(ids.len() + count, id);
        surface.resize(ids.len(), run[0] != -2);
    }
    (ids.len() == size.pixel_count()).then_some((ids, surface))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: ImageSize = ImageSize::new(3, 2);

    #[test]
    fn runs_become_pixels_and_strange_colours_nobodys() {
        let (ids, surface) = pixels_of(&[-2, 1, 2, 2, -1, 1, -3, 1, 700, 1], SIZE, 2).expect("six");
        assert_eq!(ids, [0, 2, 2, 0, 3, 3]);
        assert_eq!(surface, [false, true, true, true, true, true]);
        // Negative controls: too few, too many, and a count that is none.
        assert_eq!(pixels_of(&[-1, 5], SIZE, 2), None);
        assert_eq!(pixels_of(&[-1, 7], SIZE, 2), None);
        assert_eq!(pixels_of(&[-1, -1, 1, 7], SIZE, 2), None);
    }

    #[test]
    fn a_sample_has_more_frames_the_shorter_they_are() {
        assert_eq!(frames_of_sample(100.0), 5);
        assert_eq!(frames_of_sample(2_000.0), 1);
        assert_eq!(frames_of_sample(0.0), MAX_FRAMES);
    }
}
