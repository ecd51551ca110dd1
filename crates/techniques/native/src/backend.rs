// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: buffers of a scene, constants of a view, and the passes of a frame.

use crate::layout::{RegionSlice, SceneGeometry};
use crate::pass::{Drawing, pipelines_of};
use crate::textured::{Purpose, Textured, probed};
use crate::{Indices, Technique};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use terrafill_fill::{
    Backend, Capabilities, Colours, Counters, CpuStopwatch, DeviceError, FillPass, FillProgram,
    FillStep, Frame, FrameInput, FrameTimes, MemoryUse, Picture, PositionFormat, RegionConstants,
    SwitchError, Switches, TimedBackend, ViewId, VolumeBackend, WorkDone, pick,
};
use terrafill_scene::Overlap;
use terrafill_vulkan::{
    BindGroup, Buffer, BufferUse, FillReport, Gpu, Measured, Pipeline, PipelineDescriptor, Probe,
    SharedTargets,
};

/// A variant: how volumes come about, and the switches of the fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct NativeVariant {
    /// How volumes come about.
    pub technique: Technique,
    /// How triangles are indexed; `None`: as [`Technique::default_indices`] says.
    pub indices: Option<Indices>,
    /// What the fill does.
    pub switches: Switches,
}

impl NativeVariant {
    /// Technique first, then what differs from the default, `key=value`, in alphabetical order.
    #[must_use]
    pub fn name(&self) -> String {
        let mut names = self.switches.names();
        if self.indices() != self.technique.default_indices() {
            names.push(format!("indices={}", self.indices().name()));
        }
        names.sort_unstable();
        names.insert(0, self.technique.name().to_owned());
        names.join(",")
    }

    /// Every key of its own that [`NativeVariant::set`] takes, with its values.
    pub const KEYS: &str = "technique=vs-control|gs-degenerate|gs-two-edges|gs-line|gs-adjacency|\
        gs-per-triangle, indices=list|strip, depth-bounds=off|on";

    /// Sets the switch `key` to `value`; with `technique=` the inverse of [`NativeVariant::name`].
    ///
    /// # Errors
    /// [`SwitchError`] when the value is none of the switch's; `Ok(false)` when there is no such
    /// switch.
    pub fn set(&mut self, key: &str, value: &str) -> Result<bool, SwitchError> {
        match key {
            "technique" => {
                let techniques = Technique::ALL.map(|technique| (technique.name(), technique));
                self.technique = pick("technique", value, &techniques)?;
            }
            "indices" => {
                let kinds = Indices::ALL.map(|indices| (indices.name(), indices));
                self.indices = Some(pick("indices", value, &kinds)?);
            }
            _ => return self.switches.set(key, value),
        }
        Ok(true)
    }

    /// Whether technique and switches go together, and with a scene of this kind.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub fn check(&self, overlap: Overlap) -> Result<(), SwitchError> {
        self.check_indices()?;
        self.switches.check(overlap)
    }

    /// How triangles are indexed.
    #[must_use]
    pub fn indices(&self) -> Indices {
        self.indices.unwrap_or(self.technique.default_indices())
    }

    fn check_indices(&self) -> Result<(), SwitchError> {
        if self.indices() == Indices::List || self.technique.has_index_choice() {
            return Ok(());
        }
        Err(SwitchError {
            switch: "indices",
            found: format!(
                "{} with technique={}, whose triangles are never strips",
                self.indices().name(),
                self.technique.name()
            ),
            allowed: "none, or technique=gs-degenerate or gs-adjacency".to_owned(),
        })
    }
}

/// Pipelines of one backend, made when first asked for.
pub(crate) type Pipelines = HashMap<PipelineDescriptor, Pipeline>;

/// Shadow volumes extruded in geometry shaders, or by `vs-control` in the vertex shader.
#[derive(Debug)]
pub struct NativeBackend {
    targets: SharedTargets,
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
    revision: u64,
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
    id: ViewId,
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
    /// A backend on `targets`.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when the device lacks `geometryShader`, `depthBounds` or
    /// depth that shaders can read, and the variant needs it.
    pub fn new(targets: &SharedTargets, variant: NativeVariant) -> Result<Self, DeviceError> {
        let gpu = Arc::clone(targets.borrow().gpu());
        let features = gpu.facts.features;
        let lacks = |capability: &str| DeviceError::unsupported(capability, &gpu.facts.name);
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
            targets: SharedTargets::clone(targets),
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
        Arc::clone(self.targets.borrow().gpu())
    }

    fn draw_and_read(&mut self, input: &FrameInput) -> Result<(Picture, Counters), DeviceError> {
        self.check_prepared(input)?;
        let gpu = self.gpu();
        self.targets.borrow_mut().prepare(input)?;
        self.targets.borrow_mut().draw_surface()?;
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
        let picture = self.targets.borrow().read()?;
        Ok((picture, counters))
    }

    /// Draws the fill over the surface that the targets hold; textured covers into `probe`, if there
    /// is one.
    fn draw(
        &self,
        input: &FrameInput,
        measured: Measured,
        probe: Option<&Probe>,
    ) -> Result<(FillReport, Counters), DeviceError> {
        let mut counters = Counters::default();
        let targets = self.targets.borrow();
        let Some(drawing) = self.drawing(input, probe) else {
            return Ok((FillReport::default(), counters));
        };
        let passes = drawing.view.program.passes.len();
        let report = targets.fill(passes, measured, |recorder| {
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
    fn count_fragments(&mut self, input: &FrameInput) -> Result<Option<u64>, DeviceError> {
        let steps = |view: &ViewBuffers| {
            let counted = view.program.counted().map(FillStep::Volumes);
            descriptors(self.variant, counted)
        };
        let wanted = self.view.as_ref().map(steps).unwrap_or_default();
        if wanted.is_empty() {
            return Ok(Some(0));
        }
        self.ensure_pipelines(wanted)?;
        let targets = self.targets.borrow();
        let Some(drawing) = self.drawing(input, None) else {
            return Ok(None);
        };
        let report = targets.fill(1, Measured::Samples, |recorder| {
            drawing.count_fragments(recorder);
        })?;
        Ok(report.samples)
    }

    fn check_prepared(&self, input: &FrameInput) -> Result<(), DeviceError> {
        let revision = self.scene.as_ref().map(|scene| scene.revision);
        let view_id = self.view.as_ref().map(|view| view.id);
        input.check_prepared(BACKEND, revision, view_id)
    }

    fn upload_scene(&mut self, input: &FrameInput) -> Result<(), DeviceError> {
        let (technique, indices) = (self.variant.technique, self.variant.indices());
        let geometry = SceneGeometry::build(technique, indices, &input.scene.meshes);
        self.upload_geometry(input, geometry)
    }

    fn upload_geometry(
        &mut self,
        input: &FrameInput,
        geometry: SceneGeometry,
    ) -> Result<(), DeviceError> {
        let technique = self.variant.technique;
        let vertices = geometry.vertex_count(technique);
        check_numbers(technique, vertices)?;
        let bytes = geometry.bytes();
        let gpu = self.gpu();
        let upload = |label, bytes, use_for| Buffer::upload(&gpu, label, bytes, use_for);
        self.scene = Some(SceneBuffers {
            revision: input.scene.meshes.revision(),
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
    fn upload_view(&mut self, input: &FrameInput, colours: Colours) -> Result<(), DeviceError> {
        let Some(scene) = &self.scene else {
            return self.check_prepared(input);
        };
        let gpu = self.gpu();
        let program = FillProgram::new(&input.plan, &self.variant.switches, input.scene.overlap)?;
        if program.accumulates() {
            self.targets.borrow_mut().ensure_numbers()?;
        }
        if let Some(textured) = &mut self.textured {
            textured.upload(&self.targets.borrow(), input)?;
        }
        let place = |mesh: usize| scene.regions[mesh].place();
        let positions = PositionFormat::Fixed;
        let written = RegionConstants::bytes_of_all(input, positions, colours, place);
        let targets = self.targets.borrow();
        let Some(view_constants) = targets.view_constants().map(Arc::clone) else {
            drop(targets);
            return self.check_prepared(input);
        };
        drop(targets);
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
            id: input.view_id,
            view_constants,
            constants,
            written,
            bindings,
            program,
        });
        Ok(())
    }

    fn ensure_program_pipelines(&mut self) -> Result<(), DeviceError> {
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

    fn ensure_textured(&mut self, purpose: Purpose) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        let (Some(textured), Some(view)) = (&mut self.textured, &self.view) else {
            return Ok(());
        };
        textured.ensure(&gpu, view.program.passes.iter(), purpose)
    }

    /// The frame with ids and places from the textured covers, drawn once more with what they write
    /// for the probe, by the same functions; a plain fill's frame as it is.
    fn probed(&mut self, input: &FrameInput, plain: Frame) -> Result<Frame, DeviceError> {
        if self.textured.is_none() {
            return Ok(plain);
        }
        self.ensure_textured(Purpose::Probe)?;
        let probe = self.targets.borrow().probe()?;
        self.draw(input, Measured::Nothing, Some(&probe))?;
        let found = probed(&probe, input.size.pixel_count())?;
        let plan = self.textured.as_ref().and_then(Textured::plan);
        Ok(match plan {
            Some(plan) => plan.frame(input, plain, &found),
            None => plain,
        })
    }

    fn ensure_pipelines(&mut self, wanted: Vec<PipelineDescriptor>) -> Result<(), DeviceError> {
        let gpu = self.gpu();
        for descriptor in wanted {
            if let Entry::Vacant(place) = self.pipelines.entry(descriptor) {
                place.insert(Pipeline::new(&gpu, descriptor)?);
            }
        }
        Ok(())
    }

    /// Brings geometry, constants and pipelines up to date, and gives the bytes handed over.
    fn bring_up_to_date(&mut self, input: &FrameInput) -> Result<u64, DeviceError> {
        let gpu = self.gpu();
        let before = gpu.work_done();
        let is_uploaded = self
            .scene
            .as_ref()
            .is_some_and(|scene| scene.revision == input.scene.meshes.revision());
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
fn check_numbers(technique: Technique, vertices: usize) -> Result<(), DeviceError> {
    if vertices <= MAX_VERTICES || !technique.needs_geometry_shader() {
        return Ok(());
    }
    Err(DeviceError::OverCapacity {
        what: "vertices that geometry shaders tell apart".to_owned(),
        found: vertices as u64,
        allowed: MAX_VERTICES as u64,
    })
}

impl Backend for NativeBackend {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn prepare(&mut self, input: &FrameInput) -> Result<MemoryUse, DeviceError> {
        input.check_region_count()?;
        self.targets.borrow_mut().prepare(input)?;
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
            target_bytes: self.targets.borrow().number_bytes(&view.program),
            texture_bytes: textured.map_or(0, Textured::texture_bytes),
            buffers: used.len() as u64 + u64::from(textured.is_some()),
            upload_bytes,
        })
    }

    fn render(&mut self, input: &FrameInput) -> Result<Frame, DeviceError> {
        let (picture, mut counters) = self.draw_and_read(input)?;
        counters.stencil_fragments = self.count_fragments(input)?;
        self.probed(input, Frame::from_picture(&picture, counters))
    }
}

impl TimedBackend for NativeBackend {
    fn time_frame(&mut self, input: &FrameInput) -> Result<FrameTimes, DeviceError> {
        self.check_prepared(input)?;
        // Another backend of the targets may have drawn another view since.
        if !self.targets.borrow().holds(input) {
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

    fn picture(&mut self, input: &FrameInput) -> Result<Picture, DeviceError> {
        self.upload_view(input, OPAQUE)?;
        let picture = self.draw_and_read(input).map(|(picture, _)| picture);
        self.upload_view(input, Colours::Ids)?;
        picture
    }

    fn draw_own_surface(&mut self, input: &FrameInput) -> Result<(), DeviceError> {
        let mut targets = self.targets.borrow_mut();
        targets.prepare(input)?;
        targets.draw_surface().map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strip_counts;
    use terrafill_core::RegionMesh;
    use terrafill_fill::{ColourWay, PreparedScene};
    use terrafill_scene::{ImageSize, PlanOptions, Scene};
    use terrafill_surface::{EllipsoidKind, open_surface};

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

    /// California from the side: from above, walls turned against caps are hardly seen.
    fn california() -> FrameInput {
        let scene = Scene::shipped("california", None).expect("it ships");
        let meshes =
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh);
        let surface = open_surface(&[&EllipsoidKind], &scene).expect("a surface");
        let prepared = PreparedScene::new(&scene, meshes.expect("meshes").into(), surface);
        let mut views = scene.views.iter();
        let view = views.find(|view| view.name == "horizon").expect("a view");
        let size = ImageSize {
            width: 256,
            height: 256,
        };
        FrameInput::new(&prepared, view, size, PlanOptions::default()).expect("a surface")
    }

    /// Takes the strips of the only region apart and puts them together again, changed.
    fn change_strips(geometry: &mut SceneGeometry, change: impl FnOnce(&mut Vec<Vec<u16>>)) {
        let indices = std::mem::take(&mut geometry.indices.short);
        let strips = indices.split(|&index| index == u16::MAX);
        let mut strips: Vec<Vec<u16>> = strips.map(<[u16]>::to_vec).collect();
        change(&mut strips);
        geometry.indices.short = strips.join(&u16::MAX);
        let region = geometry.regions.first_mut().expect("one region");
        region.index_count = geometry.indices.count(true);
    }

    /// Of whole strips a device makes what it makes of lists, and of broken ones it does not.
    #[test]
    fn broken_strips_are_seen() {
        let Some(gpu) = terrafill_vulkan::open_for_test(&Default::default()) else {
            return;
        };
        // Regions that are counted: to bits that flip, all faces are alike.
        let switches = Switches {
            colour: ColourWay::Rectangle,
            ..Switches::default()
        };
        let input = california();
        let targets =
            terrafill_vulkan::RenderTargets::shared(&gpu, input.size).expect("small targets");
        // How many indices stand for a corner.
        for (technique, step) in [(Technique::GsDegenerate, 1), (Technique::GsAdjacency, 2)] {
            let drawn = |indices, change: &dyn Fn(&mut SceneGeometry)| {
                let variant = NativeVariant {
                    technique,
                    indices: Some(indices),
                    switches,
                };
                let mut backend = NativeBackend::new(&targets, variant).expect("has the features");
                backend.prepare(&input).expect("fits");
                let mut geometry = SceneGeometry::build(technique, indices, &input.scene.meshes);
                change(&mut geometry);
                backend.upload_geometry(&input, geometry).expect("fits");
                backend.render(&input).expect("draws").ids
            };
            let list = drawn(Indices::List, &|_| {});
            let filled = list.iter().filter(|id| **id > 0).count();
            assert!(filled > 1000, "{filled}");
            let differing = |change: &dyn Fn(&mut Vec<Vec<u16>>)| {
                let ids = drawn(Indices::Strip, &|geometry| change_strips(geometry, change));
                let both = ids.iter().zip(&list);
                both.filter(|(found, expected)| found != expected).count()
            };
            let name = technique.name();
            assert_eq!(differing(&|_| {}), 0, "{name}");
            let turned_over = differing(&|strips| {
                for strip in strips.iter_mut().filter(|strip| !strip.is_empty()) {
                    strip.splice(0..0, strip[..step].to_vec());
                }
            });
            assert!(turned_over > 100, "{name}, parity: {turned_over}");
            let joined = differing(&|strips| *strips = vec![strips.concat()]);
            assert!(joined > 100, "{name}, restarts missing: {joined}");
            if technique == Technique::GsAdjacency {
                let swapped = differing(&|strips| {
                    for strip in strips.iter_mut().filter(|strip| !strip.is_empty()) {
                        strip.swap(1, 3);
                    }
                });
                assert!(swapped > 100, "neighbours swapped: {swapped}");
            }
        }
    }

    /// A device that took a restart for a vertex, or turned a strip otherwise, would be given more.
    #[test]
    fn geometry_shaders_are_given_what_the_strips_hold() {
        let Some(gpu) = terrafill_vulkan::open_for_test(&Default::default()) else {
            return;
        };
        if !gpu.facts.features.pipeline_statistics {
            eprintln!("skipped: no pipeline statistics");
            return;
        }
        let input = california();
        let mesh = &input.scene.meshes[0];
        let (triangles, edges) = (mesh.triangle_count(), mesh.boundary_edge_count());
        let in_strips = triangles + strip_counts(mesh).repeated;
        let between = edges - mesh.boundary_loops.len();
        let targets =
            terrafill_vulkan::RenderTargets::shared(&gpu, input.size).expect("small targets");
        let (list, strip) = (Indices::List, Indices::Strip);
        for (technique, indices, expected) in [
            (Technique::GsDegenerate, list, triangles + edges),
            (Technique::GsDegenerate, strip, in_strips + edges + between),
            (Technique::GsAdjacency, list, triangles),
            (Technique::GsAdjacency, strip, in_strips),
        ] {
            let variant = NativeVariant {
                technique,
                indices: Some(indices),
                ..NativeVariant::default()
            };
            let mut backend = NativeBackend::new(&targets, variant).expect("has the features");
            backend.prepare(&input).expect("fits");
            backend.render(&input).expect("draws");
            let (report, _) = backend
                .draw(&input, Measured::Statistics, None)
                .expect("draws");
            let given = report.statistics.expect("has the feature");
            let what = (technique.name(), indices.name());
            let found = given.geometry_shader_invocations;
            assert_eq!(found, Some(expected as u64), "{what:?}");
            let made = 2 * (triangles + edges) as u64;
            assert_eq!(given.geometry_shader_primitives, Some(made), "{what:?}");
        }
        // Twin: some corners are said again, and some edges are not the first of their loop.
        assert!(in_strips > triangles && between > 0);
    }

    #[test]
    fn what_is_named_can_be_set_again() {
        for technique in Technique::ALL {
            let variant = NativeVariant {
                technique,
                indices: technique.has_index_choice().then_some(Indices::List),
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
        for technique in Technique::ALL {
            let mut variant = NativeVariant {
                technique,
                ..NativeVariant::default()
            };
            assert_eq!(variant.set("indices", "strip"), Ok(true));
            let allowed = variant.check(Overlap::Disjoint).is_ok();
            assert_eq!(allowed, technique.has_index_choice(), "{}", variant.name());
            assert_eq!(variant.set("indices", "list"), Ok(true));
            assert_eq!(variant.check(Overlap::Disjoint), Ok(()));
        }
        let mut variant = NativeVariant::default();
        let error = variant.set("indices", "fan").expect_err("no such one");
        assert!(error.to_string().contains("list, strip"), "{error}");
        let error = variant.set("technique", "gs").expect_err("no such one");
        assert!(
            error.to_string().contains("gs-degenerate, gs-two-edges"),
            "{error}"
        );
        assert_eq!(variant.set("techniques", "gs-line"), Ok(false));
        assert_eq!(variant, NativeVariant::default());
    }
}
