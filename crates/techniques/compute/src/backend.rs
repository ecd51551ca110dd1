// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: its volumes, and the fill that every backend on wgpu shares.

use crate::expansion::Capacity;
use crate::volumes::ComputeVolumes;
use crate::{ComputeBytes, ComputeVariant, GpuCulling};
use terrafill_fill::{
    Capabilities, Colours, DeviceError, FillBackend, FillInput, FillProgram, Frame, FrameTimes,
    MemoryUse, Picture, PositionFormat, RegionConstants, Uploaded,
};
use terrafill_gpu::{SharedTargets, VolumeFill};

/// Shadow volumes made by a compute pass.
#[derive(Debug)]
pub struct ComputeBackend {
    variant: ComputeVariant,
    fill: VolumeFill,
    volumes: ComputeVolumes,
}

/// In pictures for people.
const OPAQUE: Colours = Colours::Palette { opacity: 1.0 };

impl ComputeBackend {
    /// A backend on `targets`.
    ///
    /// # Errors
    /// [`DeviceError::Shader`], [`DeviceError::Switch`], [`DeviceError::Unsupported`].
    pub fn new(targets: &SharedTargets, variant: ComputeVariant) -> Result<Self, DeviceError> {
        let capacity = Capacity::of(&targets.borrow().gpu().device.limits());
        Self::with_capacity(targets, variant, capacity)
    }

    /// The same, holding itself to `capacity`, which may be less than the device's.
    ///
    /// # Errors
    /// As [`ComputeBackend::new`].
    pub fn with_capacity(
        targets: &SharedTargets,
        variant: ComputeVariant,
        capacity: Capacity,
    ) -> Result<Self, DeviceError> {
        variant.check()?;
        let fill = VolumeFill::new(targets, "compute", &variant.switches)?;
        let gpu = fill.gpu();
        // A draw finds its region by the instance number, which indirect draws may not have
        // otherwise.
        let first_instance = wgpu::Features::INDIRECT_FIRST_INSTANCE;
        if variant.culling != GpuCulling::Off && !gpu.device.features().contains(first_instance) {
            return Err(DeviceError::unsupported(
                "a first instance in indirect draws",
                &gpu.facts.name,
            ));
        }
        Ok(Self {
            variant,
            volumes: ComputeVolumes::new(&fill, variant, capacity)?,
            fill,
        })
    }

    /// The switches.
    #[must_use]
    pub fn variant(&self) -> ComputeVariant {
        self.variant
    }

    /// Bytes as allocated for the input that was prepared last: of the whole scene what is read,
    /// and of what is written the whole scene when cached, otherwise the regions in the plan.
    #[must_use]
    pub fn bytes(&self) -> ComputeBytes {
        self.volumes.bytes()
    }

    /// Regions of the plan that the device left out of the last frame, as indices into the scene's
    /// meshes. None without culling on the device.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`].
    pub fn regions_left_out(&self) -> Result<Vec<usize>, DeviceError> {
        self.volumes.left_out(&self.fill.gpu())
    }

    /// Makes what the view needs, and brings program and constants up to date. Where that fails,
    /// what was made for the view before is gone too.
    fn upload_view(&mut self, input: &FillInput, colours: Colours) -> Result<(), DeviceError> {
        let made = self.make_view(input, colours);
        if made.is_err() {
            self.fill.forget_view();
        }
        made
    }

    fn make_view(&mut self, input: &FillInput, colours: Colours) -> Result<(), DeviceError> {
        let program = FillProgram::new(&input.plan, &self.variant.switches, input.scene.overlap)?;
        let targets = self.fill.targets().borrow();
        self.volumes.upload_view(&targets, input)?;
        drop(targets);
        let Some(place_of) = self.volumes.places() else {
            return self.fill.check_prepared(input);
        };
        let byte_count = RegionConstants::byte_count(input);
        self.volumes.check_constants(byte_count)?;
        let positions = PositionFormat::Fixed;
        let constants = RegionConstants::bytes_of_all(input, positions, colours, place_of);
        self.fill.upload_view(input, program, constants)
    }

    /// Uploads what is not there yet, and gives how many bytes that took.
    fn bring_up_to_date(&mut self, input: &FillInput) -> Result<u64, DeviceError> {
        let before = self.fill.gpu().work_done();
        if !self.fill.holds_meshes(input) {
            let targets = self.fill.targets().borrow();
            self.volumes.upload_scene(&targets, input)?;
            drop(targets);
            self.fill.hold_meshes(input);
        }
        self.upload_view(input, Colours::Ids)?;
        self.fill
            .ensure_pipelines(&mut self.volumes, input, false)?;
        Ok(self.fill.count_work_since(before))
    }
}

impl FillBackend for ComputeBackend {
    fn capabilities(&self) -> &Capabilities {
        self.fill.capabilities()
    }

    fn tells_regions_apart(&self) -> bool {
        self.variant.switches.colour.tells_regions_apart()
    }

    fn note(&self) -> Option<String> {
        self.fill.note()
    }

    fn prepare(&mut self, input: &FillInput) -> Result<MemoryUse, DeviceError> {
        input.check_region_count()?;
        self.fill.targets().borrow_mut().prepare(input)?;
        let upload_bytes = self.bring_up_to_date(input)?;
        let (bytes, held) = (self.volumes.bytes(), self.volumes.held());
        Ok(MemoryUse {
            vertex_bytes: bytes.input_vertex_bytes + bytes.output_vertex_bytes,
            index_bytes: bytes.input_index_bytes + bytes.output_index_bytes,
            constant_bytes: RegionConstants::byte_count(input)
                + held.work_bytes
                + self.fill.textured_bytes(),
            target_bytes: self.fill.target_bytes(),
            texture_bytes: self.fill.texture_bytes(),
            // And the constants'.
            buffers: held.buffers + self.fill.constant_buffers(),
            upload_bytes,
        })
    }

    fn update(&mut self, input: &FillInput, changed: &[usize]) -> Result<Uploaded, DeviceError> {
        input.check_region_count()?;
        let changed = self.fill.check_update(input, changed)?;
        self.fill.targets().borrow_mut().prepare(input)?;
        let before = self.fill.gpu().work_done();
        self.fill.forget_meshes();
        let targets = self.fill.targets().borrow();
        let is_rewritten = self.volumes.rewrite(&targets, input, changed)?;
        drop(targets);
        if is_rewritten {
            self.fill.hold_meshes(input);
        }
        let rewritten_bytes = self.fill.count_work_since(before);
        let regions = if is_rewritten {
            changed.to_vec()
        } else {
            (0..input.scene.meshes.len()).collect()
        };
        Ok(Uploaded {
            bytes: rewritten_bytes + self.bring_up_to_date(input)?,
            regions,
        })
    }

    fn render(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        let (picture, mut counters) = self.fill.draw_and_read(&mut self.volumes, input, false)?;
        counters.vertices += self.volumes.drawn_by_device(&self.fill.gpu())?;
        counters.stencil_fragments = self.fill.count_fragments(&mut self.volumes, input)?;
        self.fill
            .frame(&mut self.volumes, input, &picture, counters)
    }

    fn picture(&mut self, input: &FillInput) -> Result<Picture, DeviceError> {
        self.upload_view(input, OPAQUE)?;
        let drawn = self.fill.draw_and_read(&mut self.volumes, input, false);
        self.upload_view(input, Colours::Ids)?;
        drawn.map(|(picture, _)| picture)
    }

    fn draw_surface(&mut self, input: &FillInput) -> Result<Option<f64>, DeviceError> {
        self.fill.draw_surface(input)
    }

    fn time_frame(&mut self, input: &FillInput) -> Result<FrameTimes, DeviceError> {
        self.fill.time_frame(&mut self.volumes, input)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute_bytes;
    use terrafill_core::RegionMesh;
    use terrafill_fill::PreparedScene;
    use terrafill_fill::RegionSet;
    use terrafill_gpu::{GpuOptions, RenderTargets, open_for_test};
    use terrafill_scene::{ImageSize, PlanOptions, Scene};
    use terrafill_surface::{EllipsoidKind, open_surface};

    #[test]
    fn a_view_that_does_not_fit_leaves_none_prepared() {
        let Some(gpu) = open_for_test(&GpuOptions::default()) else {
            return;
        };
        let scene = Scene::shipped("california", None).expect("it ships");
        let (body, rule) = (&scene.body, scene.edge_rule);
        let meshes = RegionMesh::build_all(&scene.regions, body, rule, &scene.mesh);
        let meshes: RegionSet = meshes.expect("it meshes").into();
        let surface = open_surface(&[&EllipsoidKind], &scene).expect("a surface");
        let prepared = PreparedScene::new(&scene, meshes.clone(), surface);
        let size = ImageSize {
            width: 16,
            height: 16,
        };
        let full = FillInput::new(&prepared, &scene.views[0], size, PlanOptions::default())
            .expect("a surface");
        let mut empty = full.clone();
        empty.plan.regions.clear();
        // The meshes fit, and their volumes do not.
        let bytes = compute_bytes(&meshes[0]);
        let limits = gpu.device.limits();
        let capacity = Capacity {
            storage_bytes: bytes.input_vertex_bytes.max(bytes.input_index_bytes),
            ..Capacity::of(&limits)
        };
        assert!(bytes.output_index_bytes > capacity.storage_bytes);
        let targets = RenderTargets::shared(&gpu, size).expect("a size every device has");
        let variant = ComputeVariant::default();
        let mut backend =
            ComputeBackend::with_capacity(&targets, variant, capacity).expect("valid shaders");
        backend.prepare(&empty).expect("nothing to expand");
        backend.render(&empty).expect("prepared");
        let error = backend.prepare(&full).expect_err("too large");
        assert!(error.to_string().contains("expanded volumes"), "{error}");
        let error = backend.render(&empty).expect_err("no longer prepared");
        assert!(matches!(error, DeviceError::NotPrepared { .. }), "{error}");
        // Twin: what fits can be prepared again.
        backend.prepare(&empty).expect("as before");
        backend.render(&empty).expect("prepared");
    }
}
