// SPDX-License-Identifier: MIT OR Apache-2.0
//! How the depth maps of all lights are drawn.

use terrafill_vulkan::{GeometryOutput, LayersBy};

/// Most layers into which one invocation copies a triangle of a list where no shader is compiled for their number: 960
/// components of usually 1,024.
const LISTED_COPIES: u32 = 64;

terrafill_results::named! {
    /// A way to all maps.
    all pub(crate) enum LightWay {
        /// A pass each: what the others are held against.
        Passes = "passes",
        /// A geometry shader copies each triangle into all layers, as published.
        Copied = "geometry-copies",
        /// As many invocations of it as lights make a copy each.
        Invoked = "geometry-invocations",
        /// An instance a light, whose vertex shader chooses the layer.
        Instanced = "vertex-layer",
        /// Layers as views of one draw.
        Views = "multiview",
    }
}

impl LightWay {
    pub(crate) fn layers_by(self) -> LayersBy {
        match self {
            Self::Passes => LayersBy::Passes,
            Self::Copied | Self::Invoked | Self::Instanced => LayersBy::Stage,
            Self::Views => LayersBy::Views,
        }
    }

    pub(crate) fn vertex(self) -> &'static str {
        match self {
            Self::Passes => "native/lights.pass.spv",
            Self::Copied | Self::Invoked => "native/lights.place.spv",
            Self::Instanced => "native/lights.layer.spv",
            Self::Views => "native/lights.view.spv",
        }
    }

    /// `None` for as many lights as no shader was compiled for: each is for its number of lights alone.
    pub(crate) fn geometry(self, lights: u32) -> Option<Option<GeometryOutput>> {
        let compiled = match lights {
            1 => Some(["native/lights.copied1.spv", "native/lights.invoked1.spv"]),
            2 => Some(["native/lights.copied2.spv", "native/lights.invoked2.spv"]),
            4 => Some(["native/lights.copied4.spv", "native/lights.invoked4.spv"]),
            // Faces of a cube.
            6 => Some(["native/lights.copied6.spv", "native/lights.invoked6.spv"]),
            8 => Some(["native/lights.copied8.spv", "native/lights.invoked8.spv"]),
            16 => Some(["native/lights.copied16.spv", "native/lights.invoked16.spv"]),
            _ => None,
        };
        // Those of a cube hand the triangle's number on.
        let components = if lights == 6 { 6 } else { 5 };
        match self {
            Self::Copied => compiled.map(|[copied, _]| output(copied, 3 * lights, components)),
            Self::Invoked => compiled.map(|[_, invoked]| output(invoked, 3, components)),
            _ => Some(None),
        }
    }

    /// As [`LightWay::vertex`], of a list's vertices.
    pub(crate) fn listed_vertex(self) -> &'static str {
        match self {
            Self::Passes => "native/listed.pass.spv",
            Self::Copied | Self::Invoked => "native/listed.place.spv",
            Self::Instanced => "native/listed.layer.spv",
            Self::Views => "native/listed.view.spv",
        }
    }

    /// As [`LightWay::geometry`], of a list's triangles.
    pub(crate) fn listed_geometry(self, layers: u32) -> Option<Option<GeometryOutput>> {
        // Those of lights read nothing that a list has otherwise.
        let compiled = self.geometry(layers);
        match self {
            Self::Copied if compiled.is_none() && layers <= LISTED_COPIES => {
                Some(output("native/listed.copied.spv", 3 * LISTED_COPIES, 5))
            }
            Self::Invoked if layers == 32 => Some(output("native/listed.invoked32.spv", 3, 5)),
            _ => compiled,
        }
    }

    pub(crate) fn instances(self, lights: u32) -> u32 {
        if self == Self::Instanced { lights } else { 1 }
    }
}

/// - `components`: that an invocation hands on of a vertex, a position and the layer at least
fn output(name: &'static str, vertices: u32, components: u32) -> Option<GeometryOutput> {
    Some(GeometryOutput {
        name,
        vertices,
        components,
    })
}
