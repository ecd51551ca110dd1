// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured covers on Vulkan: what the device holds of them.
//!
//! They stand where plain ones would. Plan, constants and WGSL are those of the wgpu backends; a plain
//! fill has nothing of this, neither buffers nor pipelines nor a picture.

use crate::{
    BindGroup, Buffer, BufferUse, CoverState, DepthBindings, Gpu, ImageBindings, Probe,
    RenderTargets, SampledImage, TexturedDescriptor, TexturedParts, TexturedPipeline, VolumePass,
};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use terrafill_contract::{AddressMode, DeviceError};
use terrafill_scene::MipChain;
use terrafill_stencil::{
    CoverDraw, CoverLook, CoverPurpose, Holding, Probed, StencilTest, TexturedCover, TexturedPlan,
    textured_holdings,
};

/// A copy of the picture, and what is seen beyond it.
type ImageKey = (usize, [AddressMode; 2]);

/// Shader, stencil test, and what is drawn.
type PipelineKey = (usize, StencilTest, CoverLook);

/// Textured covers of one scene and view.
#[derive(Debug, Default)]
pub(crate) struct TexturedFill {
    shaders: Vec<Shader>,
    pipelines: HashMap<PipelineKey, TexturedPipeline>,
    images: Vec<Arc<SampledImage>>,
    /// Whether something shows of what lies under the pictures.
    images_are_translucent: bool,
    image_bindings: HashMap<ImageKey, ImageBindings>,
    view: Option<CoverView>,
}

/// A composed shader, and the table that its route reads.
#[derive(Debug)]
struct Shader {
    parts: TexturedParts,
    table: Option<Table>,
}

#[derive(Debug)]
struct Table {
    image: Arc<SampledImage>,
    bindings: ImageBindings,
}

/// The covers of a view, and their constants.
#[derive(Debug)]
struct CoverView {
    /// By volume, with the place of its shader in `TexturedFill::shaders`.
    covers: Vec<(TexturedCover, usize)>,
    constants: Arc<Buffer>,
    written: Vec<[f32; 4]>,
    stride: usize,
    bindings: DepthBindings,
}

impl TexturedFill {
    /// Pictures, constants, pipelines with their routes' tables, by what they are held for.
    pub(crate) fn holdings(&self) -> Vec<Holding> {
        let tables = self.shaders.iter().filter_map(|made| made.table.as_ref());
        textured_holdings(
            self.images.iter().map(|image| image.bytes()).sum(),
            tables.map(|table| table.image.bytes()).sum(),
            self.pipelines.keys().map(|(_, _, look)| *look),
            self.view
                .as_ref()
                .map(|view| [size_of_val(&*view.written) as u64, view.constants.size()]),
        )
    }

    /// Takes over a view: constants are written where they changed, tables and bindings made where
    /// they are missing.
    pub(crate) fn set_view(
        &mut self,
        targets: &RenderTargets,
        plan: &TexturedPlan,
    ) -> Result<(), DeviceError> {
        let gpu = targets.gpu();
        let mut covers = Vec::with_capacity(plan.covers.len());
        for cover in &plan.covers {
            covers.push((cover.clone(), self.shader(gpu, plan, cover)?));
            self.ensure_image_bindings((cover.texture.image, cover.texture.address))?;
        }
        let (written, stride) = plan.aligned_constants(DepthBindings::alignment(gpu));
        let bytes = bytemuck::cast_slice(&written);
        let (constants, bindings) = match self.view.take() {
            Some(view) if (view.written.len(), view.stride) == (written.len(), stride) => {
                if view.written != written {
                    view.constants.rewrite(0, bytes)?;
                }
                (view.constants, view.bindings)
            }
            _ => {
                let label = "textured covers";
                let constants = Arc::new(Buffer::upload(gpu, label, bytes, BufferUse::Constants)?);
                let bindings = targets.bind_depth(&constants, stride)?;
                (constants, bindings)
            }
        };
        self.view = Some(CoverView {
            covers,
            constants,
            written,
            stride,
            bindings,
        });
        Ok(())
    }

    /// Uploads `copies` of a picture with all its levels in place of those there were.
    pub(crate) fn upload_image(
        &mut self,
        gpu: &Arc<Gpu>,
        image: &MipChain,
        copies: usize,
    ) -> Result<(), DeviceError> {
        let mut texels = image.levels()[0].rgba.chunks_exact(4);
        self.images_are_translucent = texels.any(|texel| texel[3] != u8::MAX);
        self.image_bindings.clear();
        self.images = (0..copies)
            .map(|_| SampledImage::picture(gpu, image).map(Arc::new))
            .collect::<Result<_, _>>()?;
        Ok(())
    }

    fn shader(
        &mut self,
        gpu: &Arc<Gpu>,
        plan: &TexturedPlan,
        cover: &TexturedCover,
    ) -> Result<usize, DeviceError> {
        let parts = parts(plan, cover);
        let there = self.shaders.iter().position(|made| made.parts == parts);
        if let Some(there) = there {
            return Ok(there);
        }
        let table = match cover.route_texels() {
            None => None,
            Some(texels) => {
                let image = Arc::new(SampledImage::route(gpu, &texels)?);
                let bindings = ImageBindings::route(&image, texels.is_filtered)?;
                Some(Table { image, bindings })
            }
        };
        self.shaders.push(Shader { parts, table });
        Ok(self.shaders.len() - 1)
    }

    fn ensure_image_bindings(&mut self, key: ImageKey) -> Result<(), DeviceError> {
        let Some(image) = self.images.get(key.0) else {
            return Ok(());
        };
        if let Entry::Vacant(place) = self.image_bindings.entry(key) {
            place.insert(ImageBindings::picture(image, key.1)?);
        }
        Ok(())
    }

    /// Makes the pipelines of the covers of `volumes` where they are missing.
    pub(crate) fn ensure(
        &mut self,
        gpu: &Arc<Gpu>,
        test: StencilTest,
        purpose: CoverPurpose,
        volumes: &[usize],
    ) -> Result<(), DeviceError> {
        for &volume in volumes {
            let Some((key, _)) = self.key(test, purpose, volume) else {
                continue;
            };
            let Shader { parts, table } = &self.shaders[key.0];
            if let Entry::Vacant(place) = self.pipelines.entry(key) {
                let descriptor = TexturedDescriptor {
                    parts,
                    table_is_sampled: table.as_ref().map(|table| table.bindings.is_sampled()),
                    test,
                    look: key.2,
                };
                place.insert(TexturedPipeline::new(gpu, &descriptor)?);
            }
        }
        Ok(())
    }

    /// Covers marked pixels with the pictures of volumes, in this order.
    pub(crate) fn draw_covers<'a>(
        &'a self,
        pass: &mut VolumePass<'a, '_, '_>,
        draw: CoverDraw<'_>,
        purpose: CoverPurpose,
    ) {
        for &volume in draw.volumes {
            if let Some(state) = self.cover(pass.bindings(), draw.test, purpose, volume) {
                pass.cut(volume, draw.scissor);
                pass.cover(&state, volume);
            }
        }
    }

    fn key(
        &self,
        test: StencilTest,
        purpose: CoverPurpose,
        volume: usize,
    ) -> Option<(PipelineKey, &TexturedCover)> {
        let view = self.view.as_ref()?;
        let (cover, shader) = view.covers.get(volume)?;
        let look = cover.look(purpose, !self.images_are_translucent);
        Some(((*shader, test, look), cover))
    }

    /// What covers one volume; `None` where [`TexturedFill::ensure`] was not called for it.
    fn cover<'a>(
        &'a self,
        bindings: &'a BindGroup,
        test: StencilTest,
        purpose: CoverPurpose,
        volume: usize,
    ) -> Option<CoverState<'a>> {
        let (key, cover) = self.key(test, purpose, volume)?;
        let image = (cover.texture.image, cover.texture.address);
        let table = self.shaders[key.0].table.as_ref();
        Some(CoverState {
            pipeline: self.pipelines.get(&key)?,
            bindings,
            depth: &self.view.as_ref()?.bindings,
            picture: self.image_bindings.get(&image)?,
            table: table.map(|table| &table.bindings),
        })
    }
}

/// What the covers left in `probe`; nothing where none was drawn.
pub(crate) fn probed(probe: &Probe, pixels: usize) -> Result<Vec<Option<Probed>>, DeviceError> {
    Ok(match probe.read()? {
        Some([places, sizes]) => Probed::of_targets(&places, &sizes),
        None => vec![None; pixels],
    })
}

/// The shader of one cover.
fn parts(plan: &TexturedPlan, cover: &TexturedCover) -> TexturedParts {
    TexturedParts::new(
        (plan.position_wgsl(), cover.position_constants.len()),
        (cover.route_wgsl(), cover.route_constants.len()),
        cover.texture.pattern.is_some(),
    )
}
