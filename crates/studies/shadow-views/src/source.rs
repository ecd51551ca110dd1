// SPDX-License-Identifier: MIT OR Apache-2.0
//! What devices make shadow volumes of: volumes from the CPU, or meshes whose silhouettes a shader finds.

use std::ops::Range;
use terrafill_contract::DeviceError;

/// Draws vertices as they are.
pub(crate) const SHADER: &str = "casters/volume.wgsl";
/// Of a piece that is a triangle of the light cap.
pub const IS_CAP: u32 = 1 << 31;

/// Volumes as one eye sees them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct EyeVolumes {
    /// Bits of `f32`: x, y, z from the eye, m, and w.
    pub vertices: Vec<[u32; 4]>,
    /// Of triangles, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
    /// Of each volume, by [`terrafill_stencil::Volume::geometry`]: its range of indices.
    pub ranges: Vec<Range<u32>>,
}

/// Casters as one eye sees them, from which a vertex shader pulls their volumes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EyeMesh {
    /// x, y, z from the eye, m, and 1; the last one: the direction away from the light, and 0.
    pub places: Vec<[f32; 4]>,
    /// Triangles and edges, as `casters/pulled.wgsl` reads them.
    pub pieces: Vec<[u32; 4]>,
    /// A bit a triangle; none where every edge computes facings from corners.
    pub lit: Vec<u32>,
    /// Of each caster, by [`terrafill_stencil::Volume::geometry`]: its range of pieces.
    pub ranges: Vec<Range<u32>>,
}

/// Casters as one eye sees them, whose volumes a compute shader puts together from these vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Computed {
    /// As those of [`EyeVolumes`]: places, then their ends, or the one end that all have.
    pub vertices: Vec<[u32; 4]>,
    /// Without places.
    pub mesh: EyeMesh,
    /// From a place to its end; or that of the one end.
    pub far: u32,
    /// Whether each place has an end of its own.
    pub is_closed: bool,
}

/// How a geometry shader is given casters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adjacency {
    /// Triangles with the corners opposite to their edges, and a facing bit of each of the four.
    Triangles,
    /// Edges with the corners opposite to them, and two facing bits.
    Lines,
    /// As triangles, of which it computes the facing itself, in `f32`.
    Corners,
}

/// Casters as one eye sees them, for a geometry shader.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Adjacent {
    /// What it is given.
    pub by: Adjacency,
    /// Of each caster: vertices of its triangles or edges, and of its caps, which are drawn beside.
    pub vertices: Vec<[u32; 2]>,
    /// What `casters/adjacent.wgsl` reads behind the volumes' constants.
    pub words: Vec<u32>,
    /// Where in these the table of volumes, corners, facing bits, places and caps begin.
    pub begins: [u32; 5],
    /// Bytes of the facing bits.
    pub light_bytes: u64,
}

/// What a device makes volumes of.
#[derive(Debug, Clone)]
pub enum VolumeSource {
    /// Of volumes from the CPU.
    Volumes(EyeVolumes),
    /// A vertex shader finds silhouettes.
    Pulled(EyeMesh),
    /// A compute shader does.
    Computed(Computed),
    /// A geometry shader does.
    Adjacent(Adjacent),
}

/// What volumes are drawn from, where they come from the CPU.
pub(crate) trait HandedOver {
    /// Takes these in their place.
    fn hand_over(&mut self, volumes: &EyeVolumes) -> Result<(), DeviceError>;
}

impl VolumeSource {
    /// All that the device holds, and what of it another sun changes.
    pub fn bytes(&self) -> [u64; 2] {
        match self {
            // Sides begin elsewhere: everything.
            Self::Volumes(volumes) => {
                let bytes = size_of_val(&*volumes.vertices) + size_of_val(&*volumes.indices);
                [bytes as u64; 2]
            }
            Self::Pulled(mesh) => {
                let fixed = size_of_val(&*mesh.places) + size_of_val(&*mesh.pieces);
                // The bits and the direction.
                let light = size_of_val(&*mesh.lit);
                [(fixed + light) as u64, (light + 16) as u64]
            }
            Self::Computed(own) => {
                let pieces = own.mesh.pieces.len();
                let light = size_of_val(&*own.mesh.lit);
                let ends = if own.is_closed {
                    size_of_val(&*own.vertices) / 2
                } else {
                    16
                };
                // Pieces with their casters, and room for the indices of each.
                let fixed = pieces * (16 + 4 + 4 * own.indices_of_piece());
                let all = fixed + size_of_val(&*own.vertices) + light;
                [all as u64, (light + ends) as u64]
            }
            // The bits and the direction.
            Self::Adjacent(own) => [size_of_val(&*own.words) as u64, own.light_bytes + 16],
        }
    }
}

impl Adjacent {
    /// The words as they lie behind so many bytes, and where what begins.
    pub fn words_behind(&self, bytes: usize) -> Vec<u32> {
        let before = u32::try_from(bytes / size_of::<u32>()).unwrap_or(u32::MAX);
        let begins = self.begins.map(|own| own + before);
        self.words.iter().copied().chain(begins).collect()
    }
}

impl Computed {
    /// Indices of a triangle or of two.
    pub fn indices_of_piece(&self) -> usize {
        if self.is_closed { 6 } else { 3 }
    }
}
