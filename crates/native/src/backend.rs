// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: buffers of a scene, constants of a view, and the passes of a frame.

use crate::Technique;
use crate::layout::{RegionSlice, SceneGeometry};
use crate::pass::{Drawing, pipelines_of};
use crate::textured::{Purpose, Textured, probed};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use terrafill_core::RegionMesh;
use terrafill_frame::{
    Backend, BackendError, Capabilities, Colours, Counters, CpuStopwatch, FillPass, FillProgram,
    FillStep, Frame, FrameInput, FrameTimes, MemoryUse, Picture, PositionFormat, RegionConstants,
    SwitchError, Switches, TimedBackend, VolumeBackend, WorkDone, pick,
};
use terrafill_vulkan::{
    BindGroup, Buffer, BufferUse, FillReport, Gpu, Measured, Pipeline, PipelineDescriptor, Probe,
    SharedStage,
};

/// A variant: how volumes come about, and the switches of the fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct NativeVariant {
    /// How volumes come about.
    pub technique: Technique,
    /// What the fill does.
    pub switches: Switches,
}

impl NativeVariant {
    /// Technique first, then what differs from the default, `key=value`, in alphabetical order.
    #[must_use]
    pub fn name(&self) -> String {
        let mut names = self.switches.names();
        names.insert(0, self.technique.name().to_owned());
        names.join(",")
    }

    /// Every key of its own that [`NativeVariant::set`] takes, with its values.
    pub const KEYS: &str = "technique=vs-control|gs-degenerate|gs-two-edges|gs-line|gs-adjacency|\
        gs-per-triangle, depth-bounds=off|on";

    /// Sets the switch `key` to `value`; with `technique=` the inverse of [`NativeVariant::name`].
    ///
    /// # Errors
    /// [`SwitchError`] when the value is none of the switch's; `Ok(false)` when there is no such
    /// switch.
    pub fn set(&mut self, key: &str, value: &str) -> Result<bool, SwitchError> {
        if key != "technique" {
            return self.switches.set(key, value);
        }
        let techniques = Technique::ALL.map(|technique| (technique.name(), technique));
        self.technique = pick("technique", value, &techniques)?;
        Ok(true)
    }
}

/// Pipelines of one backend, made when first asked for.
pub(crate) type Pipelines = HashMap<PipelineDescriptor, Pipeline>;

/// Shadow volumes extruded in geometry shaders, or by `vs-control` in the vertex shader.
#[derive(Debug)]
pub struct NativeBackend {
    stage: SharedStage,
    variant: NativeVariant,
    capabilities: Capabilities,
    pipelines: Pipelines,
    /// Of a textured fill; its covers stand where the plain ones would.
    textured: Option<Textured>,
    scene: Option<SceneBuffers>,
    view: Option<ViewBuffers>,
    /// Asked of the device for the frame that comes next.
    work: WorkDone,
}

/// Geometry of every mesh of a scene, in view or not.
#[derive(Debug)]
pub(crate) struct SceneBuffers {
    source: Arc<[RegionMesh]>,
    pub(crate) regions: Vec<RegionSlice>,
    pub(crate) vertices: Buffer,
    pub(crate) short_indices: Buffer,
    pub(crate) long_indices: Buffer,
    vertex_bytes: u64,
    index_bytes: u64,
}

/// Constants of the regions of a view, and the order to draw them in.
#[derive(Debug)]
pub(crate) struct ViewBuffers {
    source: Arc<[[f32; 3]]>,
    view_constants: Arc<Buffer>,
    constants: Arc<Buffer>,
    /// What lies in `constants`.
    written: Vec<u8>,
    pub(crate) bindings: BindGroup,
    pub(crate) program: FillProgram,
}

/// Its name in rows and messages.
const BACKEND: &str = "native";

/// In pictures for people.
const OPAQUE: Colours = Colours::Palette { opacity: 1.0 };

/// Vertices whose numbers a 32-bit float tells apart: geometry shaders know corners by number.
const MAX_VERTICES: usize = 1 << 24;

impl NativeBackend {
    /// A backend on `stage`.
    ///
    /// # Errors
    /// [`BackendError::Unsupported`] when the device lacks `geometryShader`, `depthBounds` or
    /// depth that shaders can read, and the variant needs it.
    pub fn new(stage: &SharedStage, variant: NativeVariant) -> Result<Self, BackendError> {
        let gpu = Arc::clone(stage.borrow().gpu());
        let features = gpu.facts.features;
        let lacks = |capability: &str| BackendError::unsupported(capability, &gpu.facts.name);
        if variant.technique.needs_geometry_shader() && !features.geometry_shader {
            return Err(lacks("geometryShader"));
        }
        if variant.switches.texture.is_some() && !features.samples_depth {
            return Err(lacks("reading depth in shaders"));
        }
        if variant.switches.depth_bounds && !features.depth_bounds {
            return Err(lacks("depthBounds"));
        }
        Ok(Self {
            stage: SharedStage::clone(stage),
            variant,
            capabilities: Capabilities {
                backend: BACKEND,
                adapter: gpu.facts.title(),
                gpu_timestamps: features.timestamps,
                pipeline_statistics: features.pipeline_statistics,
            },
            pipelines: Pipelines::new(),
            textured: Textured::new(&variant.switches),
            scene: None,
            view: None,
            work: WorkDone::default(),
        })
    }

    /// Technique and switches.
    #[must_use]
    pub fn variant(&self) -> NativeVariant {
        self.variant
    }

    fn gpu(&self) -> Arc<Gpu> {
        Arc::clone(self.stage.borrow().gpu())
    }

    fn draw_and_read(&mut self, input: &FrameInput) -> Result<(Picture, Counters), BackendError> {
        self.check_prepared(input)?;
        let gpu = self.gpu();
        self.stage.borrow_mut().prepare(input)?;
        self.stage.borrow_mut().draw_surface()?;
        let before = gpu.work_done();
        let (report, mut counters) = self.draw(input, Measured::Statistics, None)?;
        let prepared = std::mem::take(&mut self.work);
        WorkDone::write_into(&mut counters, prepared, gpu.work_done() - before);
        if let Some(statistics) = report.statistics {
            counters.vertex_shader_invocations = Some(statistics.vertex_shader_invocations);
            counters.geometry_shader_primitives = statistics.geometry_shader_primitives;
            counters.clipper_invocations = Some(statistics.clipper_invocations);
            counters.clipper_primitives_out = Some(statistics.clipper_primitives_out);
            counters.fragment_shader_invocations = Some(statistics.fragment_shader_invocations);
        }
        let picture = self.stage.borrow().read()?;
        Ok((picture, counters))
    }

    /// Draws the fill over the surface that the stage holds; textured covers into `probe`, if there
    /// is one.
    fn draw(
        &self,
        input: &FrameInput,
        measured: Measured,
        probe: Option<&Probe>,
    ) -> Result<(FillReport, Counters), BackendError> {
        let mut counters = Counters::default();
        let stage = self.stage.borrow();
        let Some(drawing) = self.drawing(input, probe) else {
            return Ok((FillReport::default(), counters));
        };
        let passes = drawing.view.program.passes.len();
        let report = stage.fill(passes, measured, |recorder| {
            drawing.fill(recorder, &mut counters);
        })?;
        Ok((report, counters))
    }

    fn drawing<'a>(
        &'a self,
        input: &'a FrameInput,
        probe: Option<&'a Probe>,
    ) -> Option<Drawing<'a>> {
        Some(Drawing {
            variant: self.variant,
            pipelines: &self.pipelines,
            textured: self.textured.as_ref(),
            probe,
            scene: self.scene.as_ref()?,
            view: self.view.as_ref()?,
            input,
        })
    }

    /// Fragments of all volumes that mark, drawn once more without any test.
    fn count_fragments(&mut self, input: &FrameInput) -> Result<Option<u64>, BackendError> {
        let steps = |view: &ViewBuffers| {
            let counted = view.program.counted().map(FillStep::Volumes);
            descriptors(self.variant, counted)
        };
        let wanted = self.view.as_ref().map(steps).unwrap_or_default();
        if wanted.is_empty() {
            return Ok(Some(0));
        }
        self.ensure_pipelines(wanted)?;
        let stage = self.stage.borrow();
        let Some(drawing) = self.drawing(input, None) else {
            return Ok(None);
        };
        let report = stage.fill(1, Measured::Samples, |recorder| {
            drawing.count_fragments(recorder);
        })?;
        Ok(report.samples)
    }

    fn check_prepared(&self, input: &FrameInput) -> Result<(), BackendError> {
        let meshes = self.scene.as_ref().map(|scene| &scene.source);
        let surface = self.view.as_ref().map(|view| &view.source);
        input.check_prepared(BACKEND, meshes, surface)
    }

    fn upload_scene(&mut self, input: &FrameInput) -> Result<(), BackendError> {
        let technique = self.variant.technique;
        let geometry = SceneGeometry::build(technique, &input.scene.meshes);
        let vertices = geometry.vertex_count(technique);
        check_numbers(technique, vertices)?;
        let bytes = geometry.bytes();
        let gpu = self.gpu();
        let upload = |label, bytes, use_for| Buffer::upload(&gpu, label, bytes, use_for);
        self.scene = Some(SceneBuffers {
            source: Arc::clone(&input.scene.meshes),
            vertices: upload(
                "volume vertices",
                bytemuck::cast_slice(&geometry.vertices),
                BufferUse::Vertex,
            )?,
            short_indices: upload(
                "16-bit indices",
                bytemuck::cast_slice(&geometry.indices.short),
                BufferUse::Index,
            )?,
            long_indices: upload(
                "32-bit indices",
                bytemuck::cast_slice(&geometry.indices.long),
                BufferUse::Index,
            )?,
            regions: geometry.regions,
            vertex_bytes: bytes.vertex_bytes,
            index_bytes: bytes.index_bytes,
        });
        Ok(())
    }

    /// Brings program and constants up to date; nothing is made or written where they are already.
    fn upload_view(&mut self, input: &FrameInput, colours: Colours) -> Result<(), BackendError> {
        let Some(scene) = &self.scene else {
            return self.check_prepared(input);
        };
        let gpu = self.gpu();
        let program = FillProgram::new(&input.plan, &self.variant.switches, input.scene.overlap)?;
        if program.accumulates() {
            self.stage.borrow_mut().ensure_numbers()?;
        }
        if let Some(textured) = &mut self.textured {
            textured.upload(&self.stage.borrow(), input)?;
        }
        let place = |mesh: usize| scene.regions[mesh].place();
        let positions = PositionFormat::Fixed;
        let written = RegionConstants::bytes_of_all(input, positions, colours, place);
        let stage = self.stage.borrow();
        let Some(view_constants) = stage.view_constants().map(Arc::clone) else {
            drop(stage);
            return self.check_prepared(input);
        };
        drop(stage);
        let constants = match &self.view {
            Some(view) if view.written.len() == written.len() => {
                if view.written != written {
                    view.constants.rewrite(&written)?;
                }
                Arc::clone(&view.constants)
            }
            _ => {
                let label = "region constants";
                Arc::new(Buffer::upload(&gpu, label, &written, BufferUse::Storage)?)
            }
        };
        let bindings = match self.view.take() {
            Some(view)
                if Arc::ptr_eq(&view.constants, &constants)
                    && Arc::ptr_eq(&view.view_constants, &view_constants) =>
            {
                view.bindings
            }
            _ => BindGroup::new(&gpu, &view_constants, Some(&constants))?,
        };
        self.view = Some(ViewBuffers {
            source: Arc::clone(&input.surface_rte),
            view_constants,
            constants,
            written,
            bindings,
            program,
        });
        Ok(())
    }

    fn ensure_program_pipelines(&mut self) -> Result<(), BackendError> {
        let is_textured = self.textured.is_some();
        let steps = |view: &ViewBuffers| {
            let all = view.program.passes.iter().flat_map(FillPass::steps);
            let is_plain =
                |step: &FillStep<'_>| !is_textured || !matches!(step, FillStep::Cover { .. });
            descriptors(self.variant, all.filter(is_plain))
        };
        let wanted = self.view.as_ref().map(steps).unwrap_or_default();
        self.ensure_pipelines(wanted)?;
        self.ensure_textured(Purpose::Colour)
    }

    fn ensure_textured(&mut self, purpose: Purpose) -> Result<(), BackendError> {
        let gpu = self.gpu();
        let (Some(textured), Some(view)) = (&mut self.textured, &self.view) else {
            return Ok(());
        };
        textured.ensure(&gpu, view.program.passes.iter(), purpose)
    }

    /// The frame with ids and places from the textured covers, drawn once more with what they write
    /// for the probe, by the same functions; a plain fill's frame as it is.
    fn probed(&mut self, input: &FrameInput, plain: Frame) -> Result<Frame, BackendError> {
        if self.textured.is_none() {
            return Ok(plain);
        }
        self.ensure_textured(Purpose::Probe)?;
        let probe = self.stage.borrow().probe()?;
        self.draw(input, Measured::Nothing, Some(&probe))?;
        let found = probed(&probe, input.size.pixel_count())?;
        let plan = self.textured.as_ref().and_then(Textured::plan);
        Ok(match plan {
            Some(plan) => plan.frame(input, plain, &found),
            None => plain,
        })
    }

    fn ensure_pipelines(&mut self, wanted: Vec<PipelineDescriptor>) -> Result<(), BackendError> {
        let gpu = self.gpu();
        for descriptor in wanted {
            if let Entry::Vacant(place) = self.pipelines.entry(descriptor) {
                place.insert(Pipeline::new(&gpu, descriptor)?);
            }
        }
        Ok(())
    }

    /// Brings geometry, constants and pipelines up to date, and gives the bytes handed over.
    fn bring_up_to_date(&mut self, input: &FrameInput) -> Result<u64, BackendError> {
        let gpu = self.gpu();
        let before = gpu.work_done();
        let is_uploaded = self
            .scene
            .as_ref()
            .is_some_and(|scene| Arc::ptr_eq(&scene.source, &input.scene.meshes));
        if !is_uploaded {
            self.upload_scene(input)?;
        }
        self.upload_view(input, Colours::Ids)?;
        self.ensure_program_pipelines()?;
        let done = gpu.work_done() - before;
        self.work = self.work + done;
        Ok(done.upload_bytes)
    }
}

/// Pipelines that `steps` are drawn with.
fn descriptors<'a>(
    variant: NativeVariant,
    steps: impl Iterator<Item = FillStep<'a>>,
) -> Vec<PipelineDescriptor> {
    steps
        .flat_map(|step| pipelines_of(variant, &step))
        .collect()
}

/// Whether every vertex has a number of its own in the geometry shader.
fn check_numbers(technique: Technique, vertices: usize) -> Result<(), BackendError> {
    if vertices <= MAX_VERTICES || !technique.needs_geometry_shader() {
        return Ok(());
    }
    Err(BackendError::OverCapacity {
        what: "vertices that geometry shaders tell apart".to_owned(),
        found: vertices as u64,
        allowed: MAX_VERTICES as u64,
    })
}

impl Backend for NativeBackend {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn prepare(&mut self, input: &FrameInput) -> Result<MemoryUse, BackendError> {
        input.check_region_count()?;
        self.stage.borrow_mut().prepare(input)?;
        let upload_bytes = self.bring_up_to_date(input)?;
        let (Some(scene), Some(view)) = (&self.scene, &self.view) else {
            return Ok(MemoryUse::default());
        };
        let used = [
            &scene.vertices,
            &scene.short_indices,
            &scene.long_indices,
            &view.constants,
        ];
        let textured = self.textured.as_ref();
        Ok(MemoryUse {
            vertex_bytes: scene.vertex_bytes,
            index_bytes: scene.index_bytes,
            constant_bytes: RegionConstants::byte_count(input)
                + textured.map_or(0, Textured::constant_bytes),
            target_bytes: self.stage.borrow().number_bytes(&view.program),
            texture_bytes: textured.map_or(0, Textured::texture_bytes),
            buffers: used.len() as u64 + u64::from(textured.is_some()),
            upload_bytes,
        })
    }

    fn render(&mut self, input: &FrameInput) -> Result<Frame, BackendError> {
        let (picture, mut counters) = self.draw_and_read(input)?;
        counters.stencil_fragments = self.count_fragments(input)?;
        self.probed(input, Frame::from_picture(&picture, counters))
    }
}

impl TimedBackend for NativeBackend {
    fn time_frame(&mut self, input: &FrameInput) -> Result<FrameTimes, BackendError> {
        self.check_prepared(input)?;
        // Another backend of the stage may have drawn another view since.
        if !self.stage.borrow().holds(input) {
            return Err(input.not_prepared(BACKEND));
        }
        let watch = CpuStopwatch::start();
        let (report, _) = self.draw(input, Measured::Times, None)?;
        Ok(FrameTimes {
            surface_gpu_ms: None,
            stencil_gpu_ms: report.times.stencil_ms,
            colour_gpu_ms: report.times.colour_ms,
            fill_gpu_ms: report.times.fill_ms,
            fill_cpu_ms: watch.cpu_ms(),
            fill_wall_ms: watch.wall_ms(),
        })
    }
}

impl VolumeBackend for NativeBackend {
    fn variant_name(&self) -> String {
        self.variant.name()
    }

    fn tells_regions_apart(&self) -> bool {
        self.variant.switches.colour.tells_regions_apart()
    }

    fn note(&self) -> Option<String> {
        let plan = self.textured.as_ref().and_then(Textured::plan);
        plan.map(|plan| plan.note())
    }

    fn picture(&mut self, input: &FrameInput) -> Result<Picture, BackendError> {
        self.upload_view(input, OPAQUE)?;
        let picture = self.draw_and_read(input).map(|(picture, _)| picture);
        self.upload_view(input, Colours::Ids)?;
        picture
    }

    fn draw_own_surface(&mut self, input: &FrameInput) -> Result<(), BackendError> {
        let mut stage = self.stage.borrow_mut();
        stage.prepare(input)?;
        stage.draw_surface().map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_whose_numbers_a_float_would_round_are_refused() {
        let all = Technique::ALL.into_iter();
        for technique in all.filter(|technique| technique.needs_geometry_shader()) {
            assert!(check_numbers(technique, MAX_VERTICES).is_ok());
            let error = check_numbers(technique, MAX_VERTICES + 1).expect_err("one more");
            assert!(error.to_string().contains("16777217"), "{error}");
        }
        assert!(check_numbers(Technique::VsControl, MAX_VERTICES + 1).is_ok());
        // The largest number is one less than the count, and the next float up from it is the next.
        let largest = (MAX_VERTICES - 1) as f32;
        assert_eq!(largest.next_up(), MAX_VERTICES as f32);
    }

    #[test]
    fn what_is_named_can_be_set_again() {
        for technique in Technique::ALL {
            let variant = NativeVariant {
                technique,
                switches: Switches {
                    depth_bounds: true,
                    scissor: true,
                    ..Switches::default()
                },
            };
            let name = variant.name();
            let mut parts = name.split(',');
            let mut read = NativeVariant::default();
            let first = parts.next().expect("a technique");
            assert_eq!(read.set("technique", first), Ok(true));
            for part in parts {
                let (key, value) = part.split_once('=').expect("key=value");
                assert_eq!(read.set(key, value), Ok(true), "{name}");
            }
            assert_eq!(read, variant);
            assert!(NativeVariant::KEYS.contains(technique.name()));
        }
        let mut variant = NativeVariant::default();
        let error = variant.set("technique", "gs").expect_err("no such one");
        assert!(
            error.to_string().contains("gs-degenerate, gs-two-edges"),
            "{error}"
        );
        assert_eq!(variant.set("techniques", "gs-line"), Ok(false));
        assert_eq!(variant, NativeVariant::default());
    }
}
