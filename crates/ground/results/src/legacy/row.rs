// SPDX-License-Identifier: MIT OR Apache-2.0
//! The rows.

use serde::{Deserialize, Serialize};

/// What a row is about: scene × view × backend × variant.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct CaseKey {
    /// Scene name.
    pub scene: String,
    /// View name.
    pub view: String,
    /// Backend name; `bound` and `floor` are full-screen passes, not techniques.
    pub backend: String,
    /// `doubled`, `pulled,positions=local-f32` …: layout first, then switches that differ from the
    /// default, `key=value`, joined by commas, sorted.
    pub variant: String,
}

impl std::fmt::Display for CaseKey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}/{}/{}/{}",
            self.scene, self.view, self.backend, self.variant
        )
    }
}

use crate::Status;

/// One timed frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Scene name.
    pub scene: String,
    /// View name.
    pub view: String,
    /// Backend name.
    pub backend: String,
    /// Variant.
    pub variant: String,
    /// Counts frames of this case from 0, warm-up not counted.
    pub frame: u32,
    /// Surface pass, GPU clock, milliseconds.
    pub surface_gpu_ms: Option<f64>,
    /// Stencil pass, GPU clock.
    pub stencil_gpu_ms: Option<f64>,
    /// Colour pass, GPU clock.
    pub colour_gpu_ms: Option<f64>,
    /// Whole fill, GPU clock.
    pub fill_gpu_ms: Option<f64>,
    /// Whole fill, CPU time of the process.
    pub fill_cpu_ms: f64,
    /// Whole fill, wall clock.
    pub fill_wall_ms: f64,
}

/// One case. The first columns are the stable ones of the design; the rest may grow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Scene name.
    pub scene: String,
    /// View name.
    pub view: String,
    /// Backend name.
    pub backend: String,
    /// Variant.
    pub variant: String,
    /// How it ended.
    pub status: Status,
    /// Why, unless `ok`; also remarks on the view, such as that it is filled to the last pixel.
    pub reason: String,
    /// Median, milliseconds.
    pub surface_gpu_ms: Option<f64>,
    /// Median.
    pub fill_gpu_ms: Option<f64>,
    /// Median.
    pub fill_cpu_ms: Option<f64>,
    /// Median of the bound pass of the same scene and view in the same run.
    pub bound_gpu_ms: Option<f64>,
    /// As above, CPU time of the process.
    pub bound_cpu_ms: Option<f64>,
    /// Median of the floor pass, CPU time of the process.
    pub floor_cpu_ms: Option<f64>,
    /// `fill_cpu_ms / bound_cpu_ms`.
    pub fill_over_bound_cpu: Option<f64>,
    /// Positions, flags and indices.
    pub geometry_bytes: Option<u64>,
    /// Bytes uploaded per frame once prepared.
    pub upload_bytes: Option<u64>,
    /// Draw calls of the fill.
    pub draws: Option<u64>,
    /// Vertices asked for by those draws.
    pub vertices: Option<u64>,
    /// Pixels filled.
    pub filled_px: Option<u64>,
    /// Pixels whose id differs from the reference's.
    pub mismatched_px: Option<u64>,
    /// Those farther than one pixel from every boundary in the reference's picture.
    pub mismatched_px_outside_band: Option<u64>,
    /// Largest distance between the two pictures' boundaries, pixels.
    pub hausdorff_px: Option<f64>,
    /// What the frame plan left out, by reason.
    pub left_out: String,
    // Columns below may grow.
    /// Median, milliseconds.
    pub stencil_gpu_ms: Option<f64>,
    /// Median.
    pub colour_gpu_ms: Option<f64>,
    /// Median.
    pub fill_wall_ms: Option<f64>,
    /// 5th percentile of `fill_cpu_ms`.
    pub fill_cpu_ms_p5: Option<f64>,
    /// 95th percentile of `fill_cpu_ms`.
    pub fill_cpu_ms_p95: Option<f64>,
    /// Frames behind the medians.
    pub samples: u32,
    /// Regions drawn.
    pub regions_drawn: Option<u64>,
    /// Regions left out.
    pub regions_left_out: Option<u64>,
    /// NaN or infinite results.
    pub non_finite: Option<u64>,
    /// Pixels on which the reference's two inside tests disagree, in all and outside the band.
    pub reference_disagreements: Option<u64>,
    /// As above, outside the 1-pixel band.
    pub reference_disagreements_outside_band: Option<u64>,
    /// Boundary tolerance of the mesh, metres.
    pub boundary_tolerance_m: Option<f64>,
    /// Largest deviation of a drawn boundary edge from its rule, metres.
    pub boundary_deviation_m: Option<f64>,
    /// Filled area by the backend over that by the reference, minus 1.
    pub area_error: Option<f64>,
    /// Regions of fewer than 4 pixels in the reference, left out of `hausdorff_px`.
    pub tiny_regions: Option<u64>,
    /// Buffers the backend holds.
    pub buffers: Option<u64>,
    /// Positions and flags, bytes.
    pub vertex_bytes: Option<u64>,
    /// Indices, bytes.
    pub index_bytes: Option<u64>,
    /// Per-view constants, bytes.
    pub constant_bytes: Option<u64>,
    /// Pipeline statistics: vertex shader invocations of the stencil pass.
    pub vertex_shader_invocations: Option<u64>,
    /// Primitives that reached clipping in the stencil pass.
    pub clipper_invocations: Option<u64>,
    /// Primitives that left clipping.
    pub clipper_primitives_out: Option<u64>,
    /// Fragment shader invocations of the colour pass.
    pub fragment_shader_invocations: Option<u64>,
    /// Picture of this case, relative to the run folder; empty when none was kept.
    pub image: String,
    /// Its difference from the reference, relative to the run folder.
    pub difference_image: String,
    /// The reference's picture, relative to the run folder.
    pub reference_image: String,
    /// CPU time of planning one frame (culling, heights, screen rectangles), milliseconds; not part
    /// of the fill's times, since an unchanged view is not planned again.
    pub plan_cpu_ms: Option<f64>,
    /// What the case is measured for: `main`, `sweep`, `ladder`, `matrix`, `texture`, `baseline`,
    /// joined by `+`. A case of the matrix alone draws its probe frame and is not timed.
    #[serde(default)]
    pub role: String,
    /// Hash of which pixels are filled: equal for equal masks.
    #[serde(default)]
    pub mask_hash: String,
    /// Hash of which region each pixel shows; empty when the fill does not tell regions apart.
    #[serde(default)]
    pub ids_hash: String,
    /// Fragments of volumes that met the depth and stencil tests of the stencil pass.
    #[serde(default)]
    pub stencil_fragments: Option<u64>,
    /// Buffers made for the frame after `prepare`.
    #[serde(default)]
    pub buffer_creations: Option<u64>,
    /// Pipelines made for the frame after `prepare`.
    #[serde(default)]
    pub pipeline_creations: Option<u64>,
    /// Largest edge of a cap triangle, degrees.
    #[serde(default)]
    pub cap_step_deg: Option<f64>,
    /// Tallest wall of a region drawn: from its bottom cap to its top cap, metres.
    #[serde(default)]
    pub wall_height_m: Option<f64>,
    /// Triangles of one cap of the regions drawn.
    #[serde(default)]
    pub cap_triangles: Option<u64>,
    /// Routes that a textured fill's fragments take to their texture coordinates, each with the
    /// regions that take it and its computed residual, and what was left out for them.
    #[serde(default)]
    pub texture_route: String,
    /// Root mean square error of the texture coordinates, texels, of the worse axis.
    #[serde(default)]
    pub texel_rms: Option<f64>,
    /// Largest error of the texture coordinates, texels, of the worse axis.
    #[serde(default)]
    pub texel_max: Option<f64>,
    /// Pixels with a texture coordinate or level that is NaN or infinite.
    #[serde(default)]
    pub texel_non_finite: Option<u64>,
    /// Pixels whose texture coordinates were compared with the reference's.
    #[serde(default)]
    pub texel_compared_px: Option<u64>,
    /// Pictures and tables on the device, bytes.
    #[serde(default)]
    pub texture_bytes: Option<u64>,
    /// Largest difference of a colour channel from the reference's picture over filled pixels, of 255.
    #[serde(default)]
    pub colour_max: Option<u64>,
    /// Mean of those differences.
    #[serde(default)]
    pub colour_mean: Option<f64>,
    /// How far boundaries moved that were drawn aside on purpose, pixels: the farthest that a
    /// mismatched pixel's centre is from where the reference shows the id that the frame shows there.
    #[serde(default)]
    pub boundary_moved_px: Option<f64>,
    /// Of such boundaries, the mismatched pixels that show an id which the reference shows nowhere near
    /// them: a pixel of a border that both sides own, or none.
    #[serde(default)]
    pub foreign_px: Option<u64>,
}

impl Summary {
    /// A row in which nothing is measured yet.
    #[must_use]
    pub fn new(case: CaseKey, status: Status) -> Self {
        Self {
            scene: case.scene,
            view: case.view,
            backend: case.backend,
            variant: case.variant,
            status,
            reason: String::new(),
            surface_gpu_ms: None,
            fill_gpu_ms: None,
            fill_cpu_ms: None,
            bound_gpu_ms: None,
            bound_cpu_ms: None,
            floor_cpu_ms: None,
            fill_over_bound_cpu: None,
            geometry_bytes: None,
            upload_bytes: None,
            draws: None,
            vertices: None,
            filled_px: None,
            mismatched_px: None,
            mismatched_px_outside_band: None,
            hausdorff_px: None,
            left_out: String::new(),
            stencil_gpu_ms: None,
            colour_gpu_ms: None,
            fill_wall_ms: None,
            fill_cpu_ms_p5: None,
            fill_cpu_ms_p95: None,
            samples: 0,
            regions_drawn: None,
            regions_left_out: None,
            non_finite: None,
            reference_disagreements: None,
            reference_disagreements_outside_band: None,
            boundary_tolerance_m: None,
            boundary_deviation_m: None,
            area_error: None,
            tiny_regions: None,
            buffers: None,
            vertex_bytes: None,
            index_bytes: None,
            constant_bytes: None,
            vertex_shader_invocations: None,
            clipper_invocations: None,
            clipper_primitives_out: None,
            fragment_shader_invocations: None,
            image: String::new(),
            difference_image: String::new(),
            reference_image: String::new(),
            plan_cpu_ms: None,
            role: String::new(),
            mask_hash: String::new(),
            ids_hash: String::new(),
            stencil_fragments: None,
            buffer_creations: None,
            pipeline_creations: None,
            cap_step_deg: None,
            wall_height_m: None,
            cap_triangles: None,
            texture_route: String::new(),
            texel_rms: None,
            texel_max: None,
            texel_non_finite: None,
            texel_compared_px: None,
            texture_bytes: None,
            colour_max: None,
            colour_mean: None,
            boundary_moved_px: None,
            foreign_px: None,
        }
    }
}

/// One measured build of a mesh of a made-up shape: how its cost grows with its size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GrowthRow {
    /// Family of the shape.
    pub shape: String,
    /// Vertices of its outline.
    pub outline_vertices: u64,
    /// Counts the builds of this shape and size from 0.
    pub repetition: u32,
    /// CPU time of the process, milliseconds.
    pub mesh_cpu_ms: f64,
}

/// One rung of a ladder: a case, and what it changes against the rung before.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LadderRung {
    /// Name of the ladder: whose rungs follow one another.
    pub ladder: String,
    /// Counts the ladder's rungs from 1.
    pub rung: u32,
    /// What is changed, in one word: `memory`, `culling`, `strips` …
    pub step: String,
    /// What is changed, in a sentence.
    pub change: String,
    /// Scene of the case.
    pub scene: String,
    /// View of the case.
    pub view: String,
    /// Backend of the case.
    pub backend: String,
    /// Variant of the case.
    pub variant: String,
}

impl LadderRung {
    /// The case that measures the rung.
    #[must_use]
    pub fn key(&self) -> CaseKey {
        CaseKey {
            scene: self.scene.clone(),
            view: self.view.clone(),
            backend: self.backend.clone(),
            variant: self.variant.clone(),
        }
    }
}

/// Bytes of a scene's geometry in one layout of one backend.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryRow {
    /// Scene.
    pub scene: String,
    /// Backend.
    pub backend: String,
    /// First part of the variants that store geometry so.
    pub layout: String,
    /// Regions: all of the scene, or as many as come of repeating them in turn.
    pub regions: u64,
    /// Vertices of their meshes.
    pub mesh_vertices: u64,
    /// Triangles of their meshes, one cap.
    pub mesh_triangles: u64,
    /// Edges of their boundaries.
    pub boundary_edges: u64,
    /// Loops of their boundaries.
    pub boundary_loops: u64,
    /// Bytes of positions and flags by the layout's formula.
    pub formula_vertex_bytes: u64,
    /// Bytes of indices by the layout's formula.
    pub formula_index_bytes: u64,
    /// Bytes of positions and flags as the backend allocated them; empty where nothing was.
    pub allocated_vertex_bytes: Option<u64>,
    /// Bytes of indices as allocated.
    pub allocated_index_bytes: Option<u64>,
    /// Bytes of the smallest region by formula.
    pub region_bytes_smallest: u64,
    /// Bytes of the median region by formula.
    pub region_bytes_median: u64,
    /// Bytes of the largest region by formula.
    pub region_bytes_largest: u64,
}

impl MemoryRow {
    /// Positions, flags and indices by formula.
    #[must_use]
    pub fn formula_bytes(&self) -> u64 {
        self.formula_vertex_bytes + self.formula_index_bytes
    }

    /// The same as allocated.
    #[must_use]
    pub fn allocated_bytes(&self) -> Option<u64> {
        Some(self.allocated_vertex_bytes? + self.allocated_index_bytes?)
    }
}

/// Medians of the full-screen passes measured beside a case.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Baselines {
    /// Bound, GPU clock, milliseconds.
    pub bound_gpu_ms: Option<f64>,
    /// Bound, CPU time of the process.
    pub bound_cpu_ms: Option<f64>,
    /// Floor, CPU time of the process.
    pub floor_cpu_ms: Option<f64>,
}

/// Where and with what a run was made. Free of host names: it is a fingerprint of the kind of
/// machine, not of the machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, Default)]
pub struct RunEnvironment {
    /// Version of these files' schema.
    pub schema: u32,
    /// `git rev-parse HEAD`, with `+dirty` when the tree differed; empty outside a repository.
    pub commit: String,
    /// Seconds since 1970 at the start.
    pub started_unix_s: u64,
    /// CPU model.
    pub cpu: String,
    /// Logical cores.
    pub cores: u32,
    /// Memory, bytes.
    pub memory_bytes: u64,
    /// Operating system and kernel.
    pub os: String,
    /// Adapter name.
    pub gpu: String,
    /// `cpu`, `discrete-gpu` …
    pub device_type: String,
    /// PCI vendor id.
    pub vendor_id: u32,
    /// PCI device id.
    pub device_id: u32,
    /// Driver name.
    pub driver: String,
    /// Driver version text, which holds the Mesa version where the driver is Mesa's.
    pub driver_info: String,
    /// Mesa version cut out of `driver_info`; empty for other drivers.
    pub mesa_version: String,
    /// Graphics API.
    pub api: String,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Hash over all shader sources: changes when any of them does.
    pub shader_hash: String,
    /// Debug or release build.
    pub profile: String,
    /// The run's options as `key=value`.
    pub options: Vec<String>,
}

/// What a run set out to measure, written before the first measurement.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, Default)]
pub struct RunPlan {
    /// Every case, in order.
    pub cases: Vec<CaseKey>,
    /// Scenes left out of this run, with the reason.
    pub skipped_scenes: Vec<(String, String)>,
    /// Timed frames per case.
    pub frames: u32,
    /// Frames drawn and dropped before.
    pub warm_up: u32,
    /// Those of `cases` that are drawn and compared, but not timed.
    #[serde(default)]
    pub drawn_only: Vec<CaseKey>,
}
