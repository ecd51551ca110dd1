// SPDX-License-Identifier: MIT OR Apache-2.0
//! The techniques: what is drawn, and by which shaders.

use terrafill_stencil::VolumeState;
use terrafill_vulkan::{GeometryStage, HandsOn, PipelineDescriptor, Topology, VertexFormat};

/// How volumes come about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum Extrusion {
    /// In the vertex shader: every vertex stored twice, 16 bytes each; walls are strips. The same
    /// bytes and the same shader as `vertex/doubled`.
    VsControl,
    /// In the geometry shader, one draw: triangles, then boundary edges as degenerate triangles
    /// (a, b, b). Each input makes two triangles.
    #[default]
    GsDegenerate,
    /// As [`Extrusion::GsDegenerate`], but where it can a triangle of boundary vertices stands for
    /// two edges in a row, a → b → c: written (b, c, a), with the smallest number not first, while
    /// triangles of the mesh are turned to begin with theirs. Half the indices of the boundary.
    GsTwoEdges,
    /// In geometry shaders, two draws: triangles, and line strips along the boundary.
    GsLine,
    /// In the geometry shader, one draw: triangles with their neighbours. Each makes 2 to 8
    /// triangles.
    GsAdjacency,
    /// In the geometry shader, two draws: each triangle makes a closed volume of 8 triangles, those
    /// inside a region as well. The second draw makes the walls that cancel others of the first.
    GsPerTriangle,
}

/// How triangles are indexed, where the technique leaves a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Indices {
    /// Lists: every triangle says all of its corners. `gs-degenerate` takes 3 indices a triangle and
    /// 3 an edge of the boundary, `gs-adjacency` 6 a triangle: with one of each for a vertex, and
    /// indices of 2 bytes, 24 bytes a vertex.
    List,
    /// Strips with restarts. `gs-degenerate` takes 1 index a triangle, 2 an edge and 3 more a strip,
    /// `gs-adjacency` 2 a triangle and 5 more a strip; and 1 or 2 where a strip turns the same way
    /// twice. With 6 triangles a strip that is 19 and 18 bytes a vertex.
    Strip,
}

impl Indices {
    /// Every way.
    pub const ALL: [Self; 2] = [Self::List, Self::Strip];

    /// Name in variants and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::List => "list",
            Self::Strip => "strip",
        }
    }
}

/// What one draw of a region holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum VolumePart {
    Caps,
    Walls,
    /// Both.
    Whole,
    /// Beside them: walls with front and back exchanged.
    Turned,
}

impl Extrusion {
    /// Every technique.
    pub const ALL: [Self; 6] = [
        Self::VsControl,
        Self::GsDegenerate,
        Self::GsTwoEdges,
        Self::GsLine,
        Self::GsAdjacency,
        Self::GsPerTriangle,
    ];

    /// Name in variants and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::VsControl => "vs-control",
            Self::GsDegenerate => "gs-degenerate",
            Self::GsTwoEdges => "gs-two-edges",
            Self::GsLine => "gs-line",
            Self::GsAdjacency => "gs-adjacency",
            Self::GsPerTriangle => "gs-per-triangle",
        }
    }

    /// Whether it needs geometry shaders.
    #[must_use]
    pub fn needs_geometry_shader(self) -> bool {
        self != Self::VsControl
    }

    /// Whether triangles may be lists or strips; the others have one way only.
    #[must_use]
    pub fn has_index_choice(self) -> bool {
        matches!(self, Self::GsDegenerate | Self::GsAdjacency)
    }

    /// What is stored where nothing else is asked for: the fewest bytes, which geometry shaders are
    /// chosen for (Cozzi, 2007).
    #[must_use]
    pub fn default_indices(self) -> Indices {
        self.indices(Indices::Strip)
    }

    /// What is stored where `wanted` is asked for.
    pub(crate) fn indices(self, wanted: Indices) -> Indices {
        if self.has_index_choice() {
            wanted
        } else {
            Indices::List
        }
    }

    pub(crate) fn parts(self) -> &'static [VolumePart] {
        match self {
            Self::VsControl | Self::GsLine => &[VolumePart::Caps, VolumePart::Walls],
            Self::GsDegenerate | Self::GsTwoEdges | Self::GsAdjacency => &[VolumePart::Whole],
            Self::GsPerTriangle => &[VolumePart::Whole, VolumePart::Turned],
        }
    }

    fn topology(self, part: VolumePart, indices: Indices) -> Topology {
        match (self, part, indices) {
            (Self::VsControl, VolumePart::Walls, _) => Topology::Strips,
            (Self::GsLine, VolumePart::Walls, _) => Topology::LineStrips,
            (Self::GsAdjacency, _, Indices::Strip) => Topology::StripsWithAdjacency,
            (Self::GsAdjacency, ..) => Topology::TrianglesWithAdjacency,
            (_, _, Indices::Strip) => Topology::Strips,
            _ => Topology::Triangles,
        }
    }

    fn geometry_path(self, part: VolumePart) -> Option<&'static str> {
        match (self, part) {
            (Self::VsControl, _) => None,
            (Self::GsDegenerate, _) => Some("native/degenerate.geom"),
            (Self::GsTwoEdges, _) => Some("native/two_edges.geom"),
            (Self::GsLine, VolumePart::Walls) => Some("native/walls.geom"),
            (Self::GsLine, _) => Some("native/caps.geom"),
            (Self::GsAdjacency, _) => Some("native/adjacency.geom"),
            (Self::GsPerTriangle, _) => Some("native/per_triangle.geom"),
        }
    }

    /// The pipeline that draws `part` of volumes.
    pub(crate) fn volume_pipeline(
        self,
        part: VolumePart,
        indices: Indices,
        state: VolumeState,
        without_bottom: bool,
    ) -> PipelineDescriptor {
        let hands_on = match state {
            VolumeState::Colour { .. } => HandsOn::Colour,
            VolumeState::Accumulate { .. } => HandsOn::Number,
            _ => HandsOn::Nothing,
        };
        let (path, format) = match self {
            Self::VsControl => ("vertex/doubled.wgsl", VertexFormat::FixedAndFlag),
            _ => ("native/volume.wgsl", VertexFormat::Fixed),
        };
        PipelineDescriptor {
            geometry: self.geometry_path(part).map(|path| GeometryStage {
                path,
                hands_on,
                // Walls have none anyway; one pipeline does for both.
                draws_bottom: !without_bottom
                    || matches!(part, VolumePart::Walls | VolumePart::Turned),
                is_turned: part == VolumePart::Turned,
            }),
            topology: self.topology(part, indices),
            ..PipelineDescriptor::of_volumes(path, format, state)
        }
    }
}
