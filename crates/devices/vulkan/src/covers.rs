// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles over the screen that bring colours: covers of marked pixels, and the lookup of
//! accumulated numbers. The one place where they are made and bound.

use crate::{
    Fragments, Gpu, Pipeline, PipelineDescriptor, PipelineState, Topology, VertexFormat,
    VertexStage, VolumePass,
};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use terrafill_fill::{DeviceError, FaceSet, Feature, Holding, StencilTest};

/// Pipelines on one device, made when first asked for.
#[derive(Debug, Default)]
pub(crate) struct Covers {
    made: HashMap<PipelineState, Pipeline>,
}

impl Covers {
    /// Makes a cover's pipeline unless it is there.
    pub(crate) fn ensure_cover(
        &mut self,
        gpu: &Arc<Gpu>,
        test: StencilTest,
    ) -> Result<(), DeviceError> {
        self.ensure(gpu, cover(test), "vertex/cover.wgsl")
    }

    /// Makes the lookup's pipeline unless it is there.
    pub(crate) fn ensure_resolve(&mut self, gpu: &Arc<Gpu>) -> Result<(), DeviceError> {
        self.ensure(gpu, PipelineState::Resolve, "vertex/resolve.wgsl")
    }

    fn ensure(
        &mut self,
        gpu: &Arc<Gpu>,
        state: PipelineState,
        path: &'static str,
    ) -> Result<(), DeviceError> {
        if let Entry::Vacant(place) = self.made.entry(state) {
            place.insert(Pipeline::new(gpu, full_screen(path, state))?);
        }
        Ok(())
    }

    /// Its pipelines.
    pub(crate) fn holdings(&self) -> impl Iterator<Item = Holding> {
        Holding::pipelines(std::iter::repeat_n(Feature::Covers, self.made.len()))
    }

    /// Covers marked pixels in the colours of `volumes`, in this order.
    pub(crate) fn draw_covers<'a>(
        &'a self,
        pass: &mut VolumePass<'a, '_, '_>,
        test: StencilTest,
        scissor: bool,
        volumes: &[usize],
    ) {
        let Some(pipeline) = self.made.get(&cover(test)) else {
            return;
        };
        pass.at_sky(test.skips_sky);
        for &volume in volumes {
            pass.cut(volume, scissor);
            pass.draw(pipeline, 3, volume);
        }
    }

    /// Looks up the colours of accumulated numbers.
    pub(crate) fn draw_resolve<'a>(&'a self, pass: &mut VolumePass<'a, '_, '_>) {
        if let Some(pipeline) = self.made.get(&PipelineState::Resolve) {
            pass.at_sky(false);
            pass.cut(0, false);
            pass.draw(pipeline, 3, 0);
        }
    }
}

fn cover(test: StencilTest) -> PipelineState {
    PipelineState::Colour {
        is_before_surface: false,
        test,
        faces: FaceSet::Both,
    }
}

/// The pipeline of one triangle over the screen.
fn full_screen(path: &'static str, state: PipelineState) -> PipelineDescriptor {
    PipelineDescriptor {
        vertex: VertexStage {
            path,
            entry_point: "vertex_main",
            bends_footprints: false,
        },
        geometry: None,
        fragments: Fragments::Shader {
            path,
            entry_point: "fragment_main",
        },
        format: VertexFormat::Number,
        topology: Topology::Triangles,
        state,
        depth_bounds: false,
    }
}
