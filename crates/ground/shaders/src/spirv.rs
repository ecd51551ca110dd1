// SPDX-License-Identifier: MIT OR Apache-2.0
//! SPIR-V for backends that talk to Vulkan themselves: naga's from the WGSL sources, and geometry
//! shaders, which WGSL has none of, compiled from GLSL beforehand and checked in.
//!
//! `cargo xtask check-shaders` compiles the GLSL again and compares, so that what is checked in is
//! what the sources say.

use crate::wgsl::{ShaderError, compose, parse_and_validate};
use naga::back::{PipelineConstants, pipeline_constants::process_overrides, spv};
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};

/// SPIR-V of Vulkan 1.1, which any driver with geometry shaders has.
const LANGUAGE_VERSION: (u8, u8) = (1, 3);
/// Of modules that send rays: SPIR-V of Vulkan 1.2, which such a driver has.
const RAY_LANGUAGE_VERSION: (u8, u8) = (1, 4);
/// What such a module begins with.
const RAYS: &str = "enable wgpu_ray_query;";

/// Extension that naga declares where an entry point chooses among resources of an array.
const ARRAYS: &[u8] = b"SPV_EXT_descriptor_indexing";
/// Instruction and number of the capability of arrays whose length the shader does not say, which naga leaves out.
const OF_ANY_LENGTH: [u32; 2] = [2 << 16 | 17, 5302];
/// Words before the first instruction.
const HEADER: usize = 5;

/// A stage that WGSL knows and a pipeline here has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SpirvStage {
    /// Vertex shader.
    Vertex,
    /// Vertex shader of points, which it gives a size of one pixel.
    PointVertex,
    /// Fragment shader.
    Fragment,
    /// Compute shader.
    Compute,
}

/// SPIR-V of one entry point of the WGSL module at `path`, its `override` constants set.
///
/// Clip space stays as WGSL has it, y up: draw with a viewport of negative height, as wgpu does.
/// Storage buffers are read unchecked: the device must be opened with `robustBufferAccess`.
///
/// # Errors
/// [`ShaderError`].
pub fn wgsl_to_spirv(
    path: &str,
    stage: SpirvStage,
    entry_point: &str,
    constants: &[(&str, f64)],
) -> Result<Vec<u32>, ShaderError> {
    composed_to_spirv(path, &compose(path)?, stage, entry_point, constants)
}

/// As [`wgsl_to_spirv`], of WGSL that is put together already; `path` names it in messages.
///
/// # Errors
/// [`ShaderError`].
pub fn composed_to_spirv(
    path: &str,
    composed: &str,
    stage: SpirvStage,
    entry_point: &str,
    constants: &[(&str, f64)],
) -> Result<Vec<u32>, ShaderError> {
    let invalid = |message: String| ShaderError::Invalid {
        path: path.to_owned(),
        message,
    };
    let (module, info) = parse_and_validate(path, composed)?;
    let shader_stage = match stage {
        SpirvStage::Vertex | SpirvStage::PointVertex => naga::ShaderStage::Vertex,
        SpirvStage::Fragment => naga::ShaderStage::Fragment,
        SpirvStage::Compute => naga::ShaderStage::Compute,
    };
    let mut values = PipelineConstants::default();
    for &(name, value) in constants {
        values.insert(name.to_owned(), value);
    }
    let entry = Some((shader_stage, entry_point));
    let (module, info) = process_overrides(&module, &info, entry, &values)
        .map_err(|error| invalid(error.to_string()))?;
    let mut flags = spv::WriterFlags::LABEL_VARYINGS;
    // Vulkan draws points of no size that a shader did not write; WebGPU's have one pixel.
    flags.set(
        spv::WriterFlags::FORCE_POINT_SIZE,
        stage == SpirvStage::PointVertex,
    );
    let options = spv::Options {
        lang_version: if composed.contains(RAYS) {
            RAY_LANGUAGE_VERSION
        } else {
            LANGUAGE_VERSION
        },
        flags,
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: BoundsCheckPolicy::Unchecked,
            ..BoundsCheckPolicies::default()
        },
        ..spv::Options::default()
    };
    let pipeline_options = spv::PipelineOptions {
        shader_stage,
        entry_point: entry_point.to_owned(),
    };
    let mut words = spv::write_vec(&module, &info, &options, Some(&pipeline_options))
        .map_err(|error| invalid(error.to_string()))?;
    let has_it = words.windows(2).any(|pair| pair == OF_ANY_LENGTH);
    if has_arrays(&words) && !has_it {
        words.splice(HEADER..HEADER, OF_ANY_LENGTH);
    }
    Ok(words)
}

/// An entry point of the same module that uses no array must not declare the capability: it has no extension.
fn has_arrays(words: &[u32]) -> bool {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.windows(ARRAYS.len()).any(|of| of == ARRAYS)
}

/// A geometry shader: its GLSL source and what became of it.
#[derive(Debug, Clone, Copy)]
pub struct GeometryShader {
    /// GLSL, relative to `shaders/`.
    pub source: &'static str,
    /// SPIR-V by what fragments get, relative to `shaders/`.
    pub spirv: &'static [(HandsOn, &'static str)],
    bytes: &'static [&'static [u8]],
}

/// What a geometry shader hands on to fragments besides the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HandsOn {
    /// Nothing: for passes that only mark.
    Nothing,
    /// The region's colour: for covers by volume.
    Colour,
    /// The region's number: for the accumulation of numbers.
    Number,
}

impl HandsOn {
    /// What is defined when the GLSL is compiled.
    #[must_use]
    pub fn define(self) -> Option<&'static str> {
        match self {
            Self::Nothing => None,
            Self::Colour => Some("COLOURED"),
            Self::Number => Some("NUMBERED"),
        }
    }
}

/// A file below `shaders/`.
macro_rules! shader_bytes {
    ($path:expr) => {
        include_bytes!(concat!("../../../../shaders/", $path))
    };
}

/// Of regions: in three kinds.
macro_rules! region_shader {
    ($name:literal) => {
        GeometryShader {
            source: concat!("native/", $name, ".geom"),
            spirv: &[
                (HandsOn::Nothing, concat!("native/", $name, ".spv")),
                (HandsOn::Colour, concat!("native/", $name, ".coloured.spv")),
                (HandsOn::Number, concat!("native/", $name, ".numbered.spv")),
            ],
            bytes: &[
                shader_bytes!(concat!("native/", $name, ".spv")),
                shader_bytes!(concat!("native/", $name, ".coloured.spv")),
                shader_bytes!(concat!("native/", $name, ".numbered.spv")),
            ],
        }
    };
}

/// Of casters, which are marked and never coloured.
macro_rules! caster_shader {
    ($name:literal) => {
        GeometryShader {
            source: concat!("casters/", $name, ".geom"),
            spirv: &[(HandsOn::Nothing, concat!("casters/", $name, ".spv"))],
            bytes: &[shader_bytes!(concat!("casters/", $name, ".spv"))],
        }
    };
}

const GEOMETRY_SHADERS: &[GeometryShader] = &[
    region_shader!("degenerate"),
    region_shader!("two_edges"),
    region_shader!("caps"),
    region_shader!("walls"),
    region_shader!("adjacency"),
    region_shader!("per_triangle"),
    caster_shader!("triangles"),
    caster_shader!("corners"),
    caster_shader!("lines"),
];

/// GLSL that geometry shaders include.
const GEOMETRY_SHARED: &[&str] = &[
    "native/volume.glsl",
    "native/grid.glsl",
    "native/ground.glsl",
    "native/lights.glsl",
    "native/mesh.glsl",
    "native/bezier.glsl",
    "native/image.glsl",
    "casters/sides.glsl",
];

/// Every geometry shader.
#[must_use]
pub fn geometry_shaders() -> &'static [GeometryShader] {
    GEOMETRY_SHADERS
}

/// A stage that GLSL is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GlslStage {
    /// Geometry shader.
    Geometry,
    /// Says how often a patch is divided.
    TessControl,
    /// Places what dividing a patch gave.
    TessEvaluation,
    /// Task shader.
    Task,
    /// Mesh shader.
    Mesh,
    /// Fragment shader that WGSL cannot say.
    Fragment,
    /// Fragment shader of what a mesh shader makes.
    MeshFragment,
    /// Vertex shader that WGSL cannot say, or whose arithmetic a geometry shader shares.
    Vertex,
    /// Vertex shader whose outputs transform feedback keeps.
    Capture,
}

impl GlslStage {
    /// Name of the stage and the environment, as `glslangValidator` has them.
    #[must_use]
    pub fn compiled_for(self) -> (&'static str, &'static str) {
        match self {
            Self::Geometry => ("geom", "vulkan1.1"),
            Self::TessControl => ("tesc", "vulkan1.1"),
            Self::TessEvaluation => ("tese", "vulkan1.1"),
            // Task and mesh shaders need SPIR-V 1.4.
            Self::Task => ("task", "vulkan1.2"),
            Self::Mesh => ("mesh", "vulkan1.2"),
            Self::Fragment => ("frag", "vulkan1.1"),
            Self::MeshFragment => ("frag", "vulkan1.2"),
            Self::Vertex | Self::Capture => ("vert", "vulkan1.1"),
        }
    }
}

/// SPIR-V that was made of GLSL beforehand, by what was defined when it was.
#[derive(Debug, Clone, Copy)]
pub struct CompiledShader {
    /// GLSL, relative to `shaders/`.
    pub source: &'static str,
    /// SPIR-V, relative to `shaders/`: its name.
    pub spirv: &'static str,
    /// For which stage.
    pub stage: GlslStage,
    /// What is defined, `NAME` or `NAME=VALUE`.
    pub defines: &'static [&'static str],
    bytes: &'static [u8],
}

macro_rules! compiled_shaders {
    ($($source:literal, $spirv:literal, $stage:ident, [$($define:literal),*];)*) => {
        &[$(CompiledShader {
            source: $source,
            spirv: $spirv,
            stage: GlslStage::$stage,
            defines: &[$($define),*],
            bytes: include_bytes!(concat!("../../../../shaders/", $spirv)),
        }),*]
    };
}

const COMPILED_SHADERS: &[CompiledShader] = compiled_shaders![
    "native/grid.geom", "native/grid.cell1.spv", Geometry, ["CELLS=1"];
    "native/grid.geom", "native/grid.cell2.spv", Geometry, ["CELLS=2"];
    "native/grid.geom", "native/grid.cell4.spv", Geometry, ["CELLS=4"];
    "native/grid.geom", "native/grid.cell8.spv", Geometry, ["CELLS=8"];
    "native/grid.geom", "native/grid.cell1.declared128.spv", Geometry, ["CELLS=1", "DECLARED=128"];
    "native/grid.geom", "native/grid.cell2.declared128.spv", Geometry, ["CELLS=2", "DECLARED=128"];
    "native/grid.geom", "native/grid.cell4.declared128.spv", Geometry, ["CELLS=4", "DECLARED=128"];
    "native/grid.geom", "native/grid.row2.spv", Geometry, ["CELLS=2", "PER_ROW"];
    "native/grid.geom", "native/grid.row4.spv", Geometry, ["CELLS=4", "PER_ROW"];
    "native/grid.geom", "native/grid.row8.spv", Geometry, ["CELLS=8", "PER_ROW"];
    "native/grid.geom", "native/image.cell1.spv", Geometry, ["CELLS=1", "IMAGE"];
    "native/grid.mesh", "native/grid.mesh.spv", Mesh, [];
    "native/grid.mesh", "native/image.mesh.spv", Mesh, ["IMAGE"];
    "native/grid.frag", "native/grid.frag.spv", MeshFragment, [];
    "native/ground.geom", "native/ground.geom.spv", Geometry, [];
    "native/ground.task", "native/ground.task.spv", Task, [];
    "native/ground.mesh", "native/ground.mesh.spv", Mesh, [];
    "native/lights.vert", "native/lights.pass.spv", Vertex, [];
    "native/lights.vert", "native/lights.layer.spv", Vertex, ["LAYER"];
    "native/lights.vert", "native/lights.view.spv", Vertex, ["VIEW"];
    "native/lights.vert", "native/lights.place.spv", Vertex, ["PLACE"];
    "native/lights.vert", "native/listed.pass.spv", Vertex, ["LISTED"];
    "native/lights.vert", "native/listed.layer.spv", Vertex, ["LISTED", "LAYER"];
    "native/lights.vert", "native/listed.view.spv", Vertex, ["LISTED", "VIEW"];
    "native/lights.vert", "native/listed.place.spv", Vertex, ["LISTED", "PLACE"];
    "native/lights.frag", "native/lights.frag.spv", Fragment, [];
    "native/lights.geom", "native/lights.copied1.spv", Geometry, ["LIGHTS=1"];
    "native/lights.geom", "native/lights.copied2.spv", Geometry, ["LIGHTS=2"];
    "native/lights.geom", "native/lights.copied4.spv", Geometry, ["LIGHTS=4"];
    "native/lights.geom", "native/lights.copied6.spv", Geometry, ["LIGHTS=6", "NUMBERED"];
    "native/lights.geom", "native/lights.copied8.spv", Geometry, ["LIGHTS=8"];
    "native/lights.geom", "native/lights.copied16.spv", Geometry, ["LIGHTS=16"];
    "native/lights.geom", "native/lights.invoked1.spv", Geometry, ["LIGHTS=1", "INVOCATIONS=1"];
    "native/lights.geom", "native/lights.invoked2.spv", Geometry, ["LIGHTS=2", "INVOCATIONS=2"];
    "native/lights.geom", "native/lights.invoked4.spv", Geometry, ["LIGHTS=4", "INVOCATIONS=4"];
    "native/lights.geom", "native/lights.invoked6.spv", Geometry, ["LIGHTS=6", "INVOCATIONS=6", "NUMBERED"];
    "native/lights.geom", "native/lights.invoked8.spv", Geometry, ["LIGHTS=8", "INVOCATIONS=8"];
    "native/lights.geom", "native/lights.invoked16.spv", Geometry, ["LIGHTS=16", "INVOCATIONS=16"];
    "native/lights.geom", "native/listed.copied.spv", Geometry, ["LISTED", "COPIES=64"];
    "native/lights.geom", "native/listed.invoked32.spv", Geometry, ["LISTED", "INVOCATIONS=32"];
    "native/bezier.geom", "native/bezier.patch.spv", Geometry, [];
    "native/bezier.geom", "native/bezier.row.spv", Geometry, ["PER_ROW"];
    "native/bezier.tesc", "native/bezier.tesc.spv", TessControl, [];
    "native/bezier.tese", "native/bezier.tese.spv", TessEvaluation, [];
    "native/deform.vert", "native/deform.spv", Capture, [];
    "native/balls.vert", "native/balls.spv", Capture, [];
    "native/balls.vert", "native/balls.terrain.spv", Capture, ["TERRAIN"];
    "globes/seam.geom", "globes/seam.half.spv", Geometry, ["LIMIT=0.5"];
    "globes/seam.geom", "globes/seam.published.spv", Geometry, ["LIMIT=0.7"];
];

/// Every shader that was compiled beforehand, those of [`geometry_shaders`] left out.
#[must_use]
pub fn compiled_shaders() -> &'static [CompiledShader] {
    COMPILED_SHADERS
}

/// SPIR-V of a compiled shader by its name.
///
/// # Errors
/// [`ShaderError::Unknown`], or [`ShaderError::Invalid`] when the file is no SPIR-V.
pub fn compiled_spirv(name: &str) -> Result<Vec<u32>, ShaderError> {
    let shader = COMPILED_SHADERS.iter().find(|shader| shader.spirv == name);
    let shader = shader.ok_or_else(|| ShaderError::Unknown(name.to_owned()))?;
    words(name, shader.bytes)
}

/// Every GLSL file: what lies in `shaders/` must be these.
pub fn glsl_paths() -> impl Iterator<Item = &'static str> {
    let mut compiled: Vec<&str> = COMPILED_SHADERS
        .iter()
        .map(|shader| shader.source)
        .collect();
    // Variants of a source follow each other.
    compiled.dedup();
    let sources = GEOMETRY_SHADERS.iter().map(|shader| shader.source);
    sources
        .chain(GEOMETRY_SHARED.iter().copied())
        .chain(compiled)
}

/// Checked-in bytes of every shader compiled beforehand, for [`crate::source_hash`].
pub(crate) fn geometry_bytes() -> impl Iterator<Item = u8> {
    let others = COMPILED_SHADERS
        .iter()
        .flat_map(|shader| shader.spirv.bytes().chain(shader.bytes.iter().copied()));
    let geometry = GEOMETRY_SHADERS.iter().flat_map(|shader| {
        let path = shader.source.bytes();
        path.chain(shader.bytes.iter().copied().flatten().copied())
    });
    geometry.chain(others)
}

/// SPIR-V of the geometry shader whose GLSL is at `path`.
///
/// # Errors
/// [`ShaderError::Unknown`], or [`ShaderError::Invalid`] when the file is no SPIR-V.
pub fn geometry_spirv(path: &str, hands_on: HandsOn) -> Result<Vec<u32>, ShaderError> {
    let shader = GEOMETRY_SHADERS
        .iter()
        .find(|shader| shader.source == path)
        .ok_or_else(|| ShaderError::Unknown(path.to_owned()))?;
    let kinds = shader.spirv.iter().zip(shader.bytes);
    let found = kinds.into_iter().find(|((kind, _), _)| *kind == hands_on);
    words(path, found.map_or(&[], |(_, bytes)| bytes))
}

/// First word of every SPIR-V module.
const MAGIC: u32 = 0x0723_0203;

fn words(path: &str, bytes: &[u8]) -> Result<Vec<u32>, ShaderError> {
    let (words, rest) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    if words.first() != Some(&MAGIC) || !rest.is_empty() {
        return Err(ShaderError::Invalid {
            path: path.to_owned(),
            message: format!(
                "{} bytes that begin with {:08x?}, allowed: whole words that begin with {MAGIC:08x}",
                bytes.len(),
                words.first()
            ),
        });
    }
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_point_becomes_spirv() {
        for (path, stage, entry) in [
            ("surface/surface.wgsl", SpirvStage::Vertex, "vertex_main"),
            (
                "surface/surface.wgsl",
                SpirvStage::Fragment,
                "fragment_main",
            ),
            ("native/volume.wgsl", SpirvStage::Vertex, "vertex_main"),
            ("native/volume.wgsl", SpirvStage::Vertex, "coloured_main"),
            ("native/volume.wgsl", SpirvStage::Fragment, "region_colour"),
        ] {
            let spirv = wgsl_to_spirv(path, stage, entry, &[]).expect(entry);
            assert_eq!(spirv[0], MAGIC);
            // Word 1 is the version: 0x00MMmm00.
            assert_eq!(spirv[1], 0x0001_0300);
        }
        let control = wgsl_to_spirv("native/volume.wgsl", SpirvStage::Vertex, "no_such", &[]);
        assert!(control.is_err());
    }

    #[test]
    fn an_override_changes_the_code() {
        let with = |value| {
            let constants = [("POSITIONS", value)];
            let path = "vertex/doubled.wgsl";
            wgsl_to_spirv(path, SpirvStage::Vertex, "vertex_main", &constants).expect("valid")
        };
        assert_ne!(with(0.0), with(1.0));
    }

    #[test]
    fn geometry_shaders_are_spirv_and_come_in_three_kinds() {
        assert_eq!(geometry_shaders().len(), 9);
        for shader in geometry_shaders() {
            let kinds = shader.spirv.iter();
            let kinds =
                kinds.map(|(kind, _)| geometry_spirv(shader.source, *kind).expect("SPIR-V"));
            let mut kinds: Vec<Vec<u32>> = kinds.collect();
            let count = if shader.source.starts_with("casters/") {
                1
            } else {
                3
            };
            assert_eq!(kinds.len(), count, "{}", shader.source);
            kinds.sort_unstable();
            kinds.dedup();
            assert_eq!(kinds.len(), count, "{}: two are the same", shader.source);
        }
        assert!(geometry_spirv("casters/lines.geom", HandsOn::Colour).is_err());
        assert!(geometry_spirv("native/nothing.geom", HandsOn::Nothing).is_err());
    }

    #[test]
    fn compiled_shaders_are_spirv_and_each_is_another() {
        let all: Vec<Vec<u32>> = compiled_shaders()
            .iter()
            .map(|shader| compiled_spirv(shader.spirv).expect("SPIR-V"))
            .collect();
        assert_eq!(all.len(), 49);
        for (index, one) in all.iter().enumerate() {
            assert!(all[..index].iter().all(|other| other != one), "{index}");
        }
        assert!(compiled_spirv("native/grid.geom").is_err());
    }

    #[test]
    fn points_have_a_size_where_they_are_asked_for() {
        let of = |stage| wgsl_to_spirv("pipelines/grid.wgsl", stage, "fetched_point", &[]);
        let (points, plain) = (of(SpirvStage::PointVertex), of(SpirvStage::Vertex));
        assert_ne!(points.expect("valid"), plain.expect("valid"));
        let compute = wgsl_to_spirv(
            "pipelines/expand.wgsl",
            SpirvStage::Compute,
            "compute_main",
            &[],
        );
        assert_eq!(compute.expect("valid")[0], MAGIC);
    }

    #[test]
    fn arrays_of_any_length_are_declared_where_there_are_any() {
        // The load is marked as one whose index differs within a draw.
        let non_uniform = [3 << 16 | 71, 5300];
        let of = |path, stage, entry| {
            let words = wgsl_to_spirv(path, stage, entry, &[]).expect("valid");
            let declared = words.windows(2).filter(|pair| *pair == OF_ANY_LENGTH);
            let mut decorations = words.windows(3);
            let is_marked = decorations.any(|of| [of[0], of[2]] == non_uniform);
            (declared.count(), has_arrays(&words), is_marked)
        };
        let (compute, vertex) = (SpirvStage::Compute, SpirvStage::Vertex);
        let found = of("pipelines/cache_bindless.wgsl", compute, "loaded");
        assert_eq!(found, (1, true, true));
        let found = of("pipelines/blocks_bindless.wgsl", vertex, "vertex_main");
        assert_eq!(found, (1, true, true));
        // Negative controls: no array in the module, and none in the entry point.
        let found = of("pipelines/cache_array.wgsl", compute, "loaded");
        assert_eq!(found, (0, false, false));
        let found = of(
            "pipelines/blocks_bindless.wgsl",
            SpirvStage::Fragment,
            "fragment_main",
        );
        assert_eq!(found, (0, false, false));
    }

    #[test]
    fn what_is_no_spirv_is_refused() {
        assert!(words("x", b"").is_err());
        assert!(words("x", &[3, 2, 0x23, 7, 0]).is_err(), "half a word more");
        assert!(words("x", &[7, 0x23, 2, 3]).is_err(), "the other way round");
        assert_eq!(words("x", &[3, 2, 0x23, 7]).expect("magic"), [MAGIC]);
    }
}
