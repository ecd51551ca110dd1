// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ways in which vertices of a grid may come, and what each costs before anything is drawn.

use std::ops::Range;
use terrafill_shapes::grid::Grid;

/// A side of the patch that `patch.wgsl` draws, cells.
pub(crate) const PATCH_CELLS: u32 = 64;
/// A side of what a workgroup of `grid.mesh` makes, cells.
pub(crate) const MESH_CELLS: u32 = 8;
/// SPIR-V of the mesh shader, and of its fragments.
pub(crate) const MESH_SHADERS: [&str; 2] = ["native/grid.mesh.spv", "native/grid.frag.spv"];
/// Bytes of a sent vertex, of a point's number and of an index.
const VERTEX_BYTES: u64 = 12;
const NUMBER_BYTES: u64 = 4;
const INDEX_BYTES: u64 = 2;
/// Bytes of a fetched height and of a clip position kept by compute.
const HEIGHT_BYTES: u64 = 4;
const CLIP_BYTES: u64 = 16;
/// Bytes of a draw's arguments.
pub(crate) const ARGUMENT_BYTES: u64 = 16;

/// An interface that draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Interface {
    Wgpu,
    Vulkan,
}

impl Interface {
    pub(crate) const ALL: [Self; 2] = [Self::Wgpu, Self::Vulkan];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Wgpu => terrafill_gpu::API.name,
            Self::Vulkan => terrafill_vulkan::API.name,
        }
    }
}

/// How a geometry shader hands on the cells of its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Strips {
    /// Four vertices a cell, as published.
    Cell,
    /// A strip along a row of cells, whose inner vertices two cells share.
    Row,
}

/// Where points come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// From the CPU, each frame.
    Sent,
    /// From a buffer on the device.
    Stored,
}

/// How the grid reaches the rasteriser: what the CPU sends, and which stages make triangles of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Submission {
    /// Points with their heights, from the CPU each frame.
    SentPoints,
    /// Strips of triangles with their heights, from the CPU each frame.
    SentStrips,
    /// Numbers of points in a buffer; the vertex shader fetches heights.
    FetchedPoints,
    /// Points' numbers; a geometry shader makes cells² cells of each.
    Geometry {
        /// A side.
        cells: u32,
        strips: Strips,
        source: Source,
        /// Vertices that the shader declares at most; `None` for as many as it emits.
        declared: Option<u32>,
    },
    /// The vertex shader has vertices' numbers and nothing else.
    NoBuffer,
    /// Instances of one indexed patch.
    IndexedPatch,
    /// Compute places every vertex, and says how many are drawn.
    ComputeIndirect,
    /// A mesh shader.
    Mesh,
}

/// The four published ways and what does the same today.
pub(crate) const GRID_WAYS: [Submission; 8] = [
    Submission::SentPoints,
    Submission::SentStrips,
    Submission::FetchedPoints,
    Submission::Geometry {
        cells: 1,
        strips: Strips::Cell,
        source: Source::Stored,
        declared: None,
    },
    Submission::NoBuffer,
    Submission::IndexedPatch,
    Submission::ComputeIndirect,
    Submission::Mesh,
];

impl Submission {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::SentPoints => "sent-points",
            Self::SentStrips => "sent-strips",
            Self::FetchedPoints => "fetched-points",
            Self::Geometry { .. } => "geometry-shader",
            Self::NoBuffer => "no-vertex-buffer",
            Self::IndexedPatch => "indexed-patch",
            Self::ComputeIndirect => "compute-indirect",
            Self::Mesh => "mesh-shader",
        }
    }

    /// Draws points; triangles otherwise.
    pub(crate) fn draws_points(self) -> bool {
        matches!(self, Self::SentPoints | Self::FetchedPoints)
    }

    /// Draw calls of a frame.
    pub(crate) fn draws(self, grid: &Grid) -> u64 {
        match self {
            // A strip a row.
            Self::SentStrips => u64::from(grid.cells),
            _ => 1,
        }
    }

    /// Whether the CPU sends vertices or points each frame.
    pub(crate) fn is_sent(self) -> bool {
        match self {
            Self::SentPoints | Self::SentStrips => true,
            Self::Geometry { source, .. } => source == Source::Sent,
            _ => false,
        }
    }

    /// Vertices or points that the CPU sends each frame, bytes.
    pub(crate) fn sent_bytes(self, grid: &Grid) -> u64 {
        if self.is_sent() {
            self.source_bytes(grid)
        } else {
            0
        }
    }

    /// What a buffer holds of its vertices: places and heights, or numbers of points. Nothing where it needs none.
    pub(crate) fn vertices(self, grid: &Grid) -> Vec<u8> {
        match self {
            Self::SentPoints => bytemuck::cast_slice(&points(grid)).to_vec(),
            Self::SentStrips => bytemuck::cast_slice(&strips(grid)).to_vec(),
            Self::FetchedPoints | Self::Geometry { .. } => {
                let numbers = self.ranges(grid).into_iter().flatten();
                bytemuck::cast_slice(&numbers.collect::<Vec<u32>>()).to_vec()
            }
            _ => Vec::new(),
        }
    }

    /// First and last vertex of each draw, where there are neither indices nor arguments.
    pub(crate) fn ranges(self, grid: &Grid) -> Vec<Range<u32>> {
        let cells = grid.cells * grid.cells;
        let vertices = match self {
            Self::SentStrips => return strip_ranges(grid),
            Self::NoBuffer => 6 * cells,
            Self::Geometry {
                cells: per_point, ..
            } => cells / (per_point * per_point),
            _ => cells,
        };
        std::iter::once(0..vertices).collect()
    }

    /// Of what the first stage reads: vertices, points or indices.
    fn source_bytes(self, grid: &Grid) -> u64 {
        let cells = u64::from(grid.cells);
        match self {
            Self::SentPoints => cells * cells * VERTEX_BYTES,
            Self::SentStrips => 2 * (cells + 1) * cells * VERTEX_BYTES,
            Self::FetchedPoints => cells * cells * NUMBER_BYTES,
            Self::Geometry {
                cells: per_point, ..
            } => (cells / u64::from(per_point)).pow(2) * NUMBER_BYTES,
            Self::IndexedPatch => 6 * u64::from(PATCH_CELLS).pow(2) * INDEX_BYTES,
            Self::NoBuffer | Self::Mesh => 0,
            Self::ComputeIndirect => (cells + 1).pow(2) * CLIP_BYTES + ARGUMENT_BYTES,
        }
    }

    /// Everything that the device holds for it, bytes: heights where they are fetched, and buffers, those
    /// that the CPU writes among them.
    pub(crate) fn held_bytes(self, grid: &Grid) -> u64 {
        let heights = match self {
            Self::SentPoints | Self::SentStrips => 0,
            _ => grid.heights.len() as u64 * HEIGHT_BYTES,
        };
        heights + self.source_bytes(grid)
    }

    /// Primitives of a frame.
    pub(crate) fn primitives(self, grid: &Grid) -> u64 {
        let cells = u64::from(grid.cells).pow(2);
        if self.draws_points() {
            cells
        } else {
            2 * cells
        }
    }

    /// Vertices that the last stage before rasterisation gives, by the way's definition.
    pub(crate) fn emitted_vertices(self, grid: &Grid) -> u64 {
        let cells = u64::from(grid.cells);
        match self {
            Self::SentPoints | Self::FetchedPoints => cells * cells,
            Self::SentStrips => 2 * (cells + 1) * cells,
            Self::Geometry {
                cells: per_point,
                strips,
                ..
            } => {
                let points = (cells / u64::from(per_point)).pow(2);
                points * u64::from(emitted_by_point(per_point, strips))
            }
            Self::NoBuffer | Self::ComputeIndirect => 6 * cells * cells,
            Self::IndexedPatch => {
                let patches = (cells / u64::from(PATCH_CELLS)).pow(2);
                patches * u64::from(PATCH_CELLS + 1).pow(2)
            }
            Self::Mesh => {
                let groups = (cells / u64::from(MESH_CELLS)).pow(2);
                groups * u64::from(MESH_CELLS + 1).pow(2)
            }
        }
    }
}

/// Vertices that one invocation of the geometry shader emits.
pub(crate) fn emitted_by_point(cells: u32, strips: Strips) -> u32 {
    match strips {
        Strips::Cell => 4 * cells * cells,
        Strips::Row => 2 * cells * (cells + 1),
    }
}

/// Most vertices of an invocation of a geometry shader as published: what may be declared whatever is emitted.
pub(crate) const DECLARED_VERTICES: u32 = 128;

/// Of a case, that a geometry shader declares no more vertices than it emits.
pub(crate) const AS_EMITTED: &str = "as emitted";

/// The SPIR-V of a geometry shader.
pub(crate) fn geometry_shader(
    cells: u32,
    strips: Strips,
    declared: Option<u32>,
) -> Option<&'static str> {
    if declared.is_some() {
        return match (cells, strips, declared) {
            (1, Strips::Cell, Some(DECLARED_VERTICES)) => Some("native/grid.cell1.declared128.spv"),
            (2, Strips::Cell, Some(DECLARED_VERTICES)) => Some("native/grid.cell2.declared128.spv"),
            (4, Strips::Cell, Some(DECLARED_VERTICES)) => Some("native/grid.cell4.declared128.spv"),
            _ => None,
        };
    }
    match (cells, strips) {
        // A row of one cell is a cell.
        (1, _) => Some("native/grid.cell1.spv"),
        (2, Strips::Cell) => Some("native/grid.cell2.spv"),
        (4, Strips::Cell) => Some("native/grid.cell4.spv"),
        (8, Strips::Cell) => Some("native/grid.cell8.spv"),
        (2, Strips::Row) => Some("native/grid.row2.spv"),
        (4, Strips::Row) => Some("native/grid.row4.spv"),
        (8, Strips::Row) => Some("native/grid.row8.spv"),
        _ => None,
    }
}

/// Points of a grid, as the CPU sends them.
fn points(grid: &Grid) -> Vec<[f32; 3]> {
    let rows = 0..grid.cells;
    rows.flat_map(|row| (0..grid.cells).map(move |column| grid.vertex(column, row)))
        .collect()
}

/// Strips of a grid, one a row of cells, as the CPU sends them.
fn strips(grid: &Grid) -> Vec<[f32; 3]> {
    let rows = 0..grid.cells;
    rows.flat_map(|row| {
        (0..=grid.cells).flat_map(move |column| [row, row + 1].map(|row| grid.vertex(column, row)))
    })
    .collect()
}

/// First and last vertex of each strip.
fn strip_ranges(grid: &Grid) -> Vec<Range<u32>> {
    let length = 2 * (grid.cells + 1);
    let rows = 0..grid.cells;
    rows.map(|row| row * length..(row + 1) * length).collect()
}

/// Indices of a patch's triangles over its (64 + 1)² vertices, cell by cell.
#[allow(
    clippy::cast_possible_truncation,
    reason = "a patch has 65² vertices, below 2^16"
)]
pub(crate) fn patch_indices() -> Vec<u16> {
    let side = PATCH_CELLS + 1;
    let cells = (0..PATCH_CELLS).flat_map(|y| (0..PATCH_CELLS).map(move |x| y * side + x));
    cells
        .flat_map(|corner| {
            let (right, below) = (corner + 1, corner + side);
            [corner, right, below, below + 1, below, right]
        })
        .map(|index| index as u16)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_and_vertices_are_those_of_the_published_set_up() {
        let grid = Grid::new(64);
        let of = |way: Submission| [way.sent_bytes(&grid), way.emitted_vertices(&grid)];
        assert_eq!(of(Submission::SentPoints), [12 * 64 * 64, 64 * 64]);
        assert_eq!(of(Submission::SentStrips), [12 * 2 * 65 * 64, 2 * 65 * 64]);
        assert_eq!(of(Submission::FetchedPoints), [0, 64 * 64]);
        let geometry = |cells, strips| {
            of(Submission::Geometry {
                cells,
                strips,
                source: Source::Sent,
                declared: None,
            })
        };
        assert_eq!(geometry(1, Strips::Cell), [4 * 64 * 64, 4 * 64 * 64]);
        // A quarter and a sixteenth of the bytes; as many vertices, or fewer by rows.
        assert_eq!(geometry(2, Strips::Cell), [4 * 32 * 32, 4 * 64 * 64]);
        assert_eq!(geometry(4, Strips::Cell), [4 * 16 * 16, 4 * 64 * 64]);
        assert_eq!(geometry(2, Strips::Row)[1], 12 * 32 * 32);
        assert_eq!(geometry(4, Strips::Row)[1], 40 * 16 * 16);
        assert_eq!(geometry(8, Strips::Row)[1], 144 * 8 * 8);
    }

    #[test]
    fn lists_are_as_long_as_their_bytes_say() {
        let grid = Grid::new(64);
        assert_eq!(
            size_of_val(&*points(&grid)) as u64,
            Submission::SentPoints.sent_bytes(&grid)
        );
        assert_eq!(
            size_of_val(&*strips(&grid)) as u64,
            Submission::SentStrips.sent_bytes(&grid)
        );
        assert_eq!(strip_ranges(&grid).last(), Some(&(63 * 130..64 * 130)));
        let indices = patch_indices();
        assert_eq!(indices.len(), 6 * 64 * 64);
        assert_eq!(indices.iter().max(), Some(&(65 * 65 - 1)));
    }
}
