// SPDX-License-Identifier: MIT OR Apache-2.0
//! The backend: its volumes, and the fill that every backend on wgpu shares.

use crate::layout::SceneGeometry;
use crate::volumes::InstancedVolumes;
use terrafill_fill::{
    Capabilities, Colours, DeviceError, FillBackend, FillInput, FillProgram, Frame, FrameTimes,
    MemoryUse, Picture, PositionFormat, RegionConstants, Switches, Uploaded,
};
use terrafill_gpu::{SharedTargets, VolumeFill};

/// Shadow volumes whose walls are instances.
#[derive(Debug)]
pub struct InstancedBackend {
    switches: Switches,
    pub(crate) fill: VolumeFill,
    pub(crate) volumes: InstancedVolumes,
}

impl InstancedBackend {
    /// A backend on `targets`.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] for what wgpu has no way to ask for; [`DeviceError::Shader`].
    pub fn new(targets: &SharedTargets, switches: Switches) -> Result<Self, DeviceError> {
        let fill = VolumeFill::new(targets, "instanced", &switches)?;
        Ok(Self {
            switches,
            volumes: InstancedVolumes::new(&fill)?,
            fill,
        })
    }

    /// Brings program and constants up to date; nothing is made or written where they are already.
    fn upload_view(&mut self, input: &FillInput, colours: Colours) -> Result<(), DeviceError> {
        let Some(place_of) = self.volumes.places() else {
            return self.fill.check_prepared(input);
        };
        let program = FillProgram::new(&input.plan, &self.switches, input.scene.overlap)?;
        let positions = PositionFormat::Fixed;
        let constants = RegionConstants::bytes_of_all(input, positions, colours, place_of);
        self.fill.upload_view(input, program, constants)
    }

    /// Brings geometry, constants and pipelines up to date, and gives the bytes handed over.
    fn bring_up_to_date(&mut self, input: &FillInput) -> Result<u64, DeviceError> {
        let before = self.fill.gpu().work_done();
        if !self.fill.holds_meshes(input) {
            let geometry = SceneGeometry::build(&input.scene.meshes);
            let targets = self.fill.targets().borrow();
            self.volumes.upload(&targets, geometry)?;
            drop(targets);
            self.fill.hold_meshes(input);
        }
        self.upload_view(input, Colours::Ids)?;
        self.fill
            .ensure_pipelines(&mut self.volumes, input, false)?;
        Ok(self.fill.count_work_since(before))
    }
}

impl FillBackend for InstancedBackend {
    fn capabilities(&self) -> &Capabilities {
        self.fill.capabilities()
    }

    fn tells_regions_apart(&self) -> bool {
        self.switches.colour.tells_regions_apart()
    }

    fn note(&self) -> Option<String> {
        self.fill.note()
    }

    fn prepare(&mut self, input: &FillInput) -> Result<MemoryUse, DeviceError> {
        input.check_region_count()?;
        self.fill.targets().borrow_mut().prepare(input)?;
        let upload_bytes = self.bring_up_to_date(input)?;
        let (bytes, buffers) = self.volumes.memory();
        Ok(MemoryUse {
            vertex_bytes: bytes.vertex_bytes,
            index_bytes: bytes.index_bytes,
            constant_bytes: RegionConstants::byte_count(input) + self.fill.textured_bytes(),
            target_bytes: self.fill.target_bytes(),
            texture_bytes: self.fill.texture_bytes(),
            // And the constants'.
            buffers: buffers + self.fill.constant_buffers(),
            upload_bytes,
        })
    }

    /// Re-uploads every region: walls and caps of one region lie in four buffers, and none of them is
    /// rewritten in part yet.
    fn update(&mut self, input: &FillInput, changed: &[usize]) -> Result<Uploaded, DeviceError> {
        input.check_region_count()?;
        self.fill.check_update(input, changed)?;
        self.fill.targets().borrow_mut().prepare(input)?;
        self.fill.forget_meshes();
        Ok(Uploaded {
            bytes: self.bring_up_to_date(input)?,
            regions: (0..input.scene.meshes.len()).collect(),
        })
    }

    fn render(&mut self, input: &FillInput) -> Result<Frame, DeviceError> {
        let (picture, mut counters) = self.fill.draw_and_read(&mut self.volumes, input, false)?;
        counters.stencil_fragments = self.fill.count_fragments(&mut self.volumes, input)?;
        self.fill
            .frame(&mut self.volumes, input, &picture, counters)
    }

    fn picture(&mut self, input: &FillInput) -> Result<Picture, DeviceError> {
        self.upload_view(input, Colours::Palette { opacity: 1.0 })?;
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
