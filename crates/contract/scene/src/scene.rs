// SPDX-License-Identifier: MIT OR Apache-2.0
//! A scene: a body, its regions, the rule for their edges, the surface, the views, the texture, and
//! what to vary.

use crate::{Camera, CameraPose, FileRead, MipChain, SceneTexture};
use std::sync::Arc;
use terrafill_core::{EdgeRule, Ellipsoid, MeshOptions, Region};

/// Whether regions may lie over one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overlap {
    /// Interiors are disjoint; borders may be shared.
    Disjoint,
    /// They may overlap; a later region covers an earlier one.
    Ordered,
}

/// One camera of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// `globe`, `top-down`, `horizon` …
    pub name: String,
    /// Where the camera is.
    pub pose: CameraPose,
    /// What a reader of the row must know, such as that the view is filled to the last pixel.
    pub note: Option<String>,
}

impl View {
    /// The camera on `body`.
    #[must_use]
    pub fn camera(&self, body: &Ellipsoid) -> Camera {
        Camera::new(body, &self.pose)
    }
}

/// The `[surface]` of a scene file. What a kind and its parameters mean is known to the surface alone.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceChoice {
    /// The scene file, for messages.
    pub file: String,
    /// Which surface.
    pub kind: String,
    /// Files that it is made from, in their order; their hashes are right.
    pub files: Vec<SurfaceFile>,
    /// What colours it: a picture of the whole body, columns by longitude from −180° on, rows by geodetic
    /// latitude from 90° down. `None` for one colour. No fill looks at it.
    pub picture: Option<Arc<MipChain>>,
    /// All other keys.
    pub parameters: toml::Table,
}

impl SurfaceChoice {
    /// What a scene has that names no surface: the bare body.
    pub(crate) const BARE: &str = "ellipsoid";

    /// Whether nothing rises above the body.
    #[must_use]
    pub fn is_bare(&self) -> bool {
        self.kind == Self::BARE
    }
}

/// A file that a scene's surface is made from. What is in it is known to the surface alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SurfaceFile {
    /// Path in the data folder.
    pub path: String,
    /// All of it.
    pub bytes: Arc<[u8]>,
}

/// Which levels a scene has.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum LevelChoice {
    /// Deviations from the boundary tolerance of the meshes on, each a fixed factor larger than the one
    /// before, without those that leave out few vertices; none for scenes of few vertices.
    #[default]
    Automatic,
    /// These deviations, metres, growing; none for level 0 alone.
    Given(Vec<f64>),
}

/// Which textured fills of a scene with a texture are drawn.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TexturedFills {
    /// The scene is about its picture: no fill without it is drawn.
    pub alone: bool,
    /// The view in which quick runs draw some too.
    pub quick_view: Option<String>,
}

/// A scene, checked but for its surface.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Name in reports and on the command line.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// What the regions lie on.
    pub body: Ellipsoid,
    /// What a ring edge is.
    pub edge_rule: EdgeRule,
    /// In file order.
    pub regions: Arc<[Region]>,
    /// Whether they may overlap.
    pub overlap: Overlap,
    /// How they are meshed unless a variant says otherwise.
    pub mesh: MeshOptions,
    /// Coarser versions of their boundaries.
    pub levels: LevelChoice,
    /// What lies under the fill.
    pub surface: SurfaceChoice,
    /// Cameras.
    pub views: Vec<View>,
    /// Boundary tolerances to sweep for error against run time, metres; may be empty.
    pub sweep_boundary_tolerance_m: Vec<f64>,
    /// What a textured fill shows; `None` where the scene is filled in plain colours only.
    pub texture: Option<Arc<SceneTexture>>,
    /// Which fills show it.
    pub textured: TexturedFills,
    /// Cap steps to sweep for subdivision against wall height, degrees; may be empty.
    pub sweep_cap_step_deg: Vec<f64>,
    /// Whether every way to store positions is tried through the boundary tolerances, right or wrong.
    pub sweep_positions: bool,
    /// Files that its regions, heights and pictures are from, those among them that ship with the program.
    pub files_read: Vec<FileRead>,
}
