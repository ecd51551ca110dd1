// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared API, SIZE_PX, VIEW;
    BIAS = "bias"; BOXES = "boxes"; CASTERS = "casters"; CHECKED_PX = "checked_px";
    COUNTING = "counting"; DEPTH_BOUNDS = "depth_bounds"; EXTENT = "extent"; EYE_TEST = "eye_test";
    FACES = "faces"; LENGTH_M = "length_m"; MESH = "mesh"; MODEL = "model"; MODELS = "models";
    NEAR_M = "near_m"; OUTLINE = "outline"; PAPER = "paper"; POLICY = "policy";
    POSITIONS = "positions"; QUESTION = "question"; RIVAL = "rival"; RULE = "rule";
    SCISSOR = "scissor"; SILHOUETTE = "silhouette"; STEP = "step"; SUN = "sun"; TEXEL_M = "texel_m";
}

pub(crate) const TIME: &Metric = &Metric::time_ms(
    "shadow_silhouette_cpu_ms",
    "Process CPU time of finding the silhouette; facing bits and adjacency are there already.",
)
.covering(Scope::PLAN)
.ranking(Primary::Any);
pub(crate) const FILL_CPU: &Metric = &Metric::time_ms(
    "shadow_fill_cpu_ms",
    "Process CPU time in which a device draws the shadows of the channel that has most, in a picture of `size_px`; surface and volumes are there already.",
)
.covering(Scope::FRAME);
pub(crate) const FILL_GPU: &Metric =
    &Metric::time_ms("shadow_fill_gpu_ms", "GPU time of the same.").covering(Scope::DEVICE);
pub(crate) const SHADOW_VOLUMES_CPU_MS: &Metric = &Metric::time_ms(
    "shadow_volumes_cpu_ms",
    "Process CPU time of finding the volumes of all casters for a frame; none where they are kept.",
)
.covering(Scope::PLAN);
pub(crate) const SHADOW_BUILD_GPU_MS: &Metric = &Metric::time_ms(
    "shadow_build_gpu_ms",
    "GPU time of building the device's tree of triangles, once for casters that rest.",
)
.covering(Scope::DISPATCH);
pub(crate) const SHADOW_FRAGMENTS: &Metric = &Metric::counter(
    "shadow_fragments",
    "Fragments of volumes per pixel over all channels, by the device's query.",
);
pub(crate) const SHADOW_DRAWS: &Metric =
    &Metric::counter("shadow_draws", "Draw calls of a device over all channels.");
pub(crate) const SHADOW_BYTES: &Metric = &Metric::bytes(
    "shadow_bytes",
    "Vertices and indices of the volumes that a device holds for a channel, the largest; texels of a map.",
);
pub(crate) const SHADOW_SUN_BYTES: &Metric = &Metric::bytes(
    "shadow_sun_bytes",
    "What of these a device is handed anew for another sun.",
);
pub(crate) const SHADOW_CASTERS_LEFT_OUT: &Metric = &Metric::quantity(
    "shadow_casters_left_out",
    "Casters whose shadow lands nowhere in view, summed over all channels: they are not drawn.",
);
pub(crate) const SHADOW_MAP_CPU_MS: &Metric = &Metric::time_ms(
    "shadow_map_cpu_ms",
    "Process CPU time of drawing a shadow map on the CPU and asking it for every pixel of all channels.",
)
.covering(Scope::PLAN);
pub(crate) const SHADOW_MAP_GPU_MS: &Metric = &Metric::time_ms(
    "shadow_map_gpu_ms",
    "GPU time of drawing a device's shadow map.",
)
.covering(Scope::DRAW);
pub(crate) const SHADOW_MAP_DIFFERS: &Metric = &percent(
    "shadow_map_differs",
    "Pixels of which a device's map says otherwise than the CPU's, of all that the reference judges.",
);
pub(crate) const MAP_WRONG: &Metric = &percent(
    "shadow_map_wrong",
    "Wrong pixels of all that the reference judges, the band included, at the best step of the bias.",
);
pub(crate) const SHADOW_MAP_WRONG_IN_THREE: &Metric = &percent(
    "shadow_map_wrong_in_three",
    "The same of the three channels that see most pixels of casters, at the step that is best there.",
);
pub(crate) const SHADOW_MAP_WRONG_UNBIASED: &Metric =
    &percent("shadow_map_wrong_unbiased", "The same without a bias.");
pub(crate) const SHADOW_MAP_BIAS_M: &Metric = &Metric::neither(
    "shadow_map_bias_m",
    "m",
    Kind::Error,
    "The best step of the bias, along the light, on level ground.",
);
pub(crate) const SHADOW_SIDES: &Metric =
    &Metric::quantity("shadow_sides", "Silhouette edges: sides of the volumes.");
pub(crate) const SHADOW_MESH_TRIANGLES: &Metric =
    &Metric::quantity("shadow_mesh_triangles", "Triangles of the casters.");
pub(crate) const SHADOW_MESH_MODELS: &Metric = &Metric::quantity(
    "shadow_mesh_models",
    "Models in a user's file: its objects, or its nodes with a mesh.",
);
pub(crate) const SHADOW_MESH_PARTS: &Metric =
    &Metric::quantity("shadow_mesh_parts", "Parts of these that hang together.");
pub(crate) const SHADOW_UNDECIDED_FACINGS: &Metric = &percent(
    "shadow_undecided_facings",
    "Triangles whose sign of facing in f32 depends on which corner comes first, in the channel with most.",
);
pub(crate) const SHADOW_OPEN_EDGES: &Metric = &Metric::error(
    "shadow_open_edges",
    "",
    "Directed edges of the volumes that are not met as often either way; 0 where every volume is closed.",
);
pub(crate) const MISSED: &Metric = &percent(
    "shadow_eyes_missed",
    "Eyes for which z-pass is chosen while part of the near rectangle is in shadow, so that pixels miscount.",
);
pub(crate) const SHADOW_EYES_MISSED_AT_CORNERS: &Metric = &percent(
    "shadow_eyes_missed_at_corners",
    "Of these, those of which a corner or the middle of the near rectangle is in shadow; all samples are 17 by 17.",
);
pub(crate) const MOSTLY: &Metric = &percent(
    "shadow_eyes_missed_mostly",
    "Of these, those of which more than half of the near rectangle is in shadow: most of the picture miscounts.",
);
pub(crate) const SHADOW_EYES_NEEDLESS: &Metric = &percent(
    "shadow_eyes_needless",
    "Eyes for which z-fail is chosen while no sample of the near rectangle is in shadow: slower and right.",
);
pub(crate) const SHADOW_FAIL_TRIANGLES: &Metric = &Metric::less(
    "shadow_fail_triangles",
    "%",
    Kind::Counter,
    "Triangles of casters drawn by z-fail, mean over all eyes.",
);
pub(crate) const SHADOW_NEAR_DARK: &Metric = &percent(
    "shadow_near_dark",
    "Share of the near rectangle in shadow, mean over missed eyes: at most so many pixels are wrong.",
);
pub(crate) const SHADOW_RECEIVER_PX: &Metric = &seen(
    "shadow_receiver_px",
    "Pixels of sea and casters in all channels.",
);
pub(crate) const SHADOW_PX: &Metric = &seen(
    "shadow_px",
    "Pixels in shadow by the reference, in all channels.",
);
pub(crate) const SHADOW_EDGE_ON_PX: &Metric = &seen(
    "shadow_edge_on_px",
    "Pixels on faces within 10⁻³ of edge-on to the sun, which are not judged.",
);
pub(crate) const SHADOW_UNDECIDED_PX: &Metric = &Metric::error_px(
    "shadow_undecided_px",
    "Pixels on which the reference's two tests disagree, which are not judged.",
);
pub(crate) const SHADOW_FALSE_LIT_PX: &Metric = &Metric::error_px(
    "shadow_false_lit_px",
    "Pixels lit where the reference has shadow, outside the band of a pixel along its boundary.",
);
pub(crate) const SHADOW_FALSE_DARK_PX: &Metric = &Metric::error_px(
    "shadow_false_dark_px",
    "Pixels in shadow where the reference is lit, outside the band.",
);
pub(crate) const SHADOW_RIM_PX: &Metric = &Metric::error_px(
    "shadow_rim_px",
    "Wrong pixels of a device outside the band, yet within its rounding, 1/32 of a pixel: at a caster's rim, in a triangle that is thinner, or where the boundary of one part's shadow runs within others.",
);
pub(crate) const SHADOW_TIMED_WRONG_PX: &Metric = &Metric::error_px(
    "shadow_timed_wrong_px",
    "Pixels wrong outside the band and beyond rounding in the picture that is timed, where its size is not that of the channels.",
);
pub(crate) const SHADOW_BAND_PX: &Metric = &Metric::error_px(
    "shadow_band_px",
    "Wrong pixels in the band along the shadow's boundary.",
);
pub(crate) const LOST: &Metric = &percent(
    "shadow_lost_share",
    "Shadow pixels that are lost, the band included, of all shadow pixels.",
);
pub(crate) const UPDATES: &Metric = &Metric::counter(
    "shadow_updates",
    "Stencil writes per pixel over all channels, counted along the ray of each pixel: a cost without noise.",
);
pub(crate) const SHADOW_VOLUME_TRIANGLES: &Metric =
    &Metric::quantity("shadow_volume_triangles", "Triangles of all volumes.");
pub(crate) const SHADOW_MAX_OVERLAP: &Metric =
    &Metric::quantity("shadow_max_overlap", "Largest count of a pixel.");
pub(crate) const SHADOW_CONTOUR_PX: &Metric = &Metric::error_px(
    "shadow_contour_px",
    "Contour pixels of outlines that are drawn inside their model or left out beside it.",
);
pub(crate) const SHADOW_CLEARS: &Metric = &Metric::counter(
    "shadow_clears",
    "Clears of the stencil for outlines, the first included.",
);

/// Everything that the study measures.
#[rustfmt::skip]
pub(crate) const METRICS: [Metric; 44] = [
    *TIME, *FILL_CPU, *FILL_GPU, *SHADOW_VOLUMES_CPU_MS, *SHADOW_BUILD_GPU_MS, *SHADOW_FRAGMENTS,
    *SHADOW_DRAWS, *SHADOW_BYTES, *SHADOW_SUN_BYTES, *SHADOW_CASTERS_LEFT_OUT, *SHADOW_MAP_CPU_MS,
    *SHADOW_MAP_GPU_MS, *SHADOW_MAP_DIFFERS, *MAP_WRONG, *SHADOW_MAP_WRONG_IN_THREE,
    *SHADOW_MAP_WRONG_UNBIASED, *SHADOW_MAP_BIAS_M, *SHADOW_SIDES, *SHADOW_MESH_TRIANGLES,
    *SHADOW_MESH_MODELS, *SHADOW_MESH_PARTS, *SHADOW_UNDECIDED_FACINGS, *SHADOW_OPEN_EDGES, *MISSED,
    *SHADOW_EYES_MISSED_AT_CORNERS, *MOSTLY, *SHADOW_EYES_NEEDLESS, *SHADOW_FAIL_TRIANGLES,
    *SHADOW_NEAR_DARK, *SHADOW_RECEIVER_PX, *SHADOW_PX, *SHADOW_EDGE_ON_PX, *SHADOW_UNDECIDED_PX,
    *SHADOW_FALSE_LIT_PX, *SHADOW_FALSE_DARK_PX, *SHADOW_RIM_PX, *SHADOW_TIMED_WRONG_PX,
    *SHADOW_BAND_PX, *LOST, *UPDATES, *SHADOW_VOLUME_TRIANGLES, *SHADOW_MAX_OVERLAP,
    *SHADOW_CONTOUR_PX, *SHADOW_CLEARS,
];

/// A share that is wrong.
const fn percent(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "%", Kind::Error, meaning)
}

/// Pixels of a view.
const fn seen(name: &'static str, meaning: &'static str) -> Metric {
    Metric::neither(name, "px", Kind::Counter, meaning)
}
