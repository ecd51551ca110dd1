// SPDX-License-Identifier: MIT OR Apache-2.0
//! A stencil program as it is held on the device: its constants, covers, and the textures its passes need.

use crate::RenderTargets;
use crate::attachments::{COLOUR_FORMAT, DEPTH_STENCIL_FORMAT, target};
use crate::covers::{CoverList, Covers, Numbers};
use terrafill_contract::{DeviceError, Feature};
use terrafill_stencil::{
    COLOUR_BYTES, DEPTH_STENCIL_BYTES, FillPass, FillStep, Holding, StencilWork,
};
use terrafill_variant::FirstPass;

/// A program, and what the device holds for it.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) work: StencilWork,
    pub(crate) constants: wgpu::Buffer,
    /// Group 0, view and volumes' constants.
    pub(crate) bind_group: wgpu::BindGroup,
    /// Plain covers, if they are merged.
    pub(crate) covers: Option<CoverList>,
    /// Where the program accumulates numbers, if it does.
    pub(crate) numbers: Option<Numbers>,
    /// Where colours of the first pass go, which nobody reads, if it has fragments.
    pub(crate) unread: Option<wgpu::TextureView>,
    /// Where depth is copied to, if it is; volumes may read it.
    pub(crate) depth_copy: Option<wgpu::Texture>,
}

/// What a program finds on the device.
#[derive(Debug)]
pub(crate) struct Held<'a> {
    pub(crate) targets: &'a RenderTargets,
    pub(crate) frame_layout: &'a wgpu::BindGroupLayout,
    pub(crate) covers: &'a Covers,
    /// Plain covers of one step are one draw.
    pub(crate) merges_covers: bool,
    /// Every frame copies depth.
    pub(crate) copies_depth: bool,
}

impl Loaded {
    /// Keeps what `before` held and this program needs as well: all is of the targets' size.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`].
    pub(crate) fn new(
        on: &Held<'_>,
        work: StencilWork,
        before: Option<Self>,
    ) -> Result<Self, DeviceError> {
        let targets = on.targets;
        let (gpu, size) = (targets.gpu(), targets.size());
        let (held, numbers, depth_copy, covers) = match before {
            Some(loaded) => {
                let written = loaded.work.constants;
                let held = (loaded.constants, written, loaded.bind_group);
                (Some(held), loaded.numbers, loaded.depth_copy, loaded.covers)
            }
            None => (None, None, None, None),
        };
        let instances = on
            .merges_covers
            .then(|| work.program.cover_instances(&work.list));
        let covers = match instances.filter(|instances| !instances.is_empty()) {
            Some(instances) => Some(CoverList::new(gpu, &instances, covers)?),
            None => None,
        };
        let new_numbers = || Numbers::new(gpu, on.covers, size);
        let accumulates = work.program.accumulates();
        let numbers = accumulates.then(|| numbers.unwrap_or_else(new_numbers));
        let has_room = |buffer: &wgpu::Buffer| buffer.size() >= work.constants.len() as u64;
        let (constants, bind_group) = if let Some((buffer, written, bind_group)) =
            held.filter(|(buffer, ..)| has_room(buffer))
        {
            gpu.write_changed(&buffer, &written, &work.constants);
            (buffer, bind_group)
        } else {
            let usage = wgpu::BufferUsages::STORAGE;
            let buffer = gpu.upload("volume constants", &work.constants, usage)?;
            // Footprints lie behind the volumes' constants.
            let buffers = [targets.view_constants(), &buffer, &buffer];
            let label = "view and volumes";
            let bind_group = gpu.bind_buffers(label, on.frame_layout, &buffers);
            (buffer, bind_group)
        };
        let texture = |label, format, texel_bytes, usage| {
            gpu.work
                .count_texture(texel_bytes * size.pixel_count() as u64);
            target(gpu, size, label, format, usage)
        };
        let mut passes = work.program.passes.iter();
        let has_fragments = passes.any(|pass| pass.first_pass != FirstPass::Stencil);
        let unread = has_fragments.then(|| {
            let (label, unused) = ("colours of the first pass", wgpu::TextureUsages::empty());
            let unread = texture(label, COLOUR_FORMAT, COLOUR_BYTES, unused);
            unread.create_view(&Default::default())
        });
        let copied = wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
        let (format, bytes) = (DEPTH_STENCIL_FORMAT, DEPTH_STENCIL_BYTES);
        let new_copy = || texture("copy of depth", format, bytes, copied);
        let depth_copy = on.copies_depth.then(|| depth_copy.unwrap_or_else(new_copy));
        Ok(Self {
            work,
            constants,
            bind_group,
            covers,
            numbers,
            unread,
            depth_copy,
        })
    }

    pub(crate) fn steps(&self) -> impl Iterator<Item = FillStep<'_>> {
        self.work.program.passes.iter().flat_map(FillPass::steps)
    }

    pub(crate) fn holdings(&self) -> impl Iterator<Item = Holding> {
        let pixels = self.work.list.size.pixel_count() as u64;
        let numbers = self.numbers.as_ref().map_or(0, Numbers::bytes);
        let unread = self.unread.as_ref().map_or(0, |_| COLOUR_BYTES * pixels);
        // Depth's copy takes the stencil with it.
        let copy = self.depth_copy.as_ref();
        let copy = copy.map_or(0, |_| DEPTH_STENCIL_BYTES * pixels);
        let targets = [
            Holding::target(Feature::NumberTarget, numbers),
            Holding::target(Feature::FirstPassColours, unread),
            Holding::target(Feature::DepthCopy, copy),
        ];
        std::iter::once(self.work.constants_held(self.constants.size()))
            .chain(self.covers.iter().map(CoverList::holding))
            .chain(targets)
    }
}
