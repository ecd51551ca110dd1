// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Kind, Metric, Scope};

// Those that the chapter reads in several places.
pub(crate) const TIME: &str = "shadow_silhouette_cpu_ms";
pub(crate) const UPDATES: &str = "shadow_updates";
pub(crate) const MISSED: &str = "shadow_eyes_missed";
pub(crate) const MOSTLY: &str = "shadow_eyes_missed_mostly";
pub(crate) const LOST: &str = "shadow_lost_share";
pub(crate) const MAP_WRONG: &str = "shadow_map_wrong";
pub(crate) const FILL_CPU: &str = "shadow_fill_cpu_ms";
pub(crate) const FILL_GPU: &str = "shadow_fill_gpu_ms";

pub(crate) const METRICS: [Metric; 44] = [
    Metric::less(
        "shadow_silhouette_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of finding the silhouette; facing bits and adjacency are there already.",
    ).covering(Scope::PLAN),
    Metric::less(
        "shadow_fill_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time in which a device draws the shadows of the channel that has most, in a picture of `size_px`; surface and volumes are there already.",
    ).covering(Scope::FRAME),
    Metric::less(
        "shadow_fill_gpu_ms",
        "ms",
        Kind::Time,
        "GPU time of the same.",
    ).covering(Scope::DEVICE),
    Metric::less(
        "shadow_volumes_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of finding the volumes of all casters for a frame; none where they are kept.",
    ).covering(Scope::PLAN),
    Metric::less(
        "shadow_build_gpu_ms",
        "ms",
        Kind::Time,
        "GPU time of building the device's tree of triangles, once for casters that rest.",
    ).covering(Scope::DISPATCH),
    Metric::less(
        "shadow_fragments",
        "",
        Kind::Counter,
        "Fragments of volumes per pixel over all channels, by the device's query.",
    ),
    Metric::less(
        "shadow_draws",
        "",
        Kind::Counter,
        "Draw calls of a device over all channels.",
    ),
    Metric::less(
        "shadow_bytes",
        "bytes",
        Kind::Bytes,
        "Vertices and indices of the volumes that a device holds for a channel, the largest; texels of a map.",
    ),
    Metric::less(
        "shadow_sun_bytes",
        "bytes",
        Kind::Bytes,
        "What of these a device is handed anew for another sun.",
    ),
    Metric::neither(
        "shadow_casters_left_out",
        "",
        Kind::Counter,
        "Casters whose shadow lands nowhere in view, summed over all channels: they are not drawn.",
    ),
    Metric::less(
        "shadow_map_cpu_ms",
        "ms",
        Kind::Time,
        "Process CPU time of drawing a shadow map on the CPU and asking it for every pixel of all channels.",
    ).covering(Scope::PLAN),
    Metric::less(
        "shadow_map_gpu_ms",
        "ms",
        Kind::Time,
        "GPU time of drawing a device's shadow map.",
    ).covering(Scope::DRAW),
    Metric::less(
        "shadow_map_differs",
        "%",
        Kind::Error,
        "Pixels of which a device's map says otherwise than the CPU's, of all that the reference judges.",
    ),
    Metric::less(
        "shadow_map_wrong",
        "%",
        Kind::Error,
        "Wrong pixels of all that the reference judges, the band included, at the best step of the bias.",
    ),
    Metric::less(
        "shadow_map_wrong_in_three",
        "%",
        Kind::Error,
        "The same of the three channels that see most pixels of casters, at the step that is best there.",
    ),
    Metric::less(
        "shadow_map_wrong_unbiased",
        "%",
        Kind::Error,
        "The same without a bias.",
    ),
    Metric::neither(
        "shadow_map_bias_m",
        "m",
        Kind::Error,
        "The best step of the bias, along the light, on level ground.",
    ),
    Metric::neither(
        "shadow_sides",
        "",
        Kind::Counter,
        "Silhouette edges: sides of the volumes.",
    ),
    Metric::neither(
        "shadow_mesh_triangles",
        "",
        Kind::Counter,
        "Triangles of the casters.",
    ),
    Metric::neither(
        "shadow_mesh_models",
        "",
        Kind::Counter,
        "Models in a user's file: its objects, or its nodes with a mesh.",
    ),
    Metric::neither(
        "shadow_mesh_parts",
        "",
        Kind::Counter,
        "Parts of these that hang together.",
    ),
    Metric::less(
        "shadow_undecided_facings",
        "%",
        Kind::Error,
        "Triangles whose sign of facing in f32 depends on which corner comes first, in the channel with most.",
    ),
    Metric::less(
        "shadow_open_edges",
        "",
        Kind::Error,
        "Directed edges of the volumes that are not met as often either way; 0 where every volume is closed.",
    ),
    Metric::less(
        "shadow_eyes_missed",
        "%",
        Kind::Error,
        "Eyes for which z-pass is chosen while part of the near rectangle is in shadow, so that pixels miscount.",
    ),
    Metric::less(
        "shadow_eyes_missed_at_corners",
        "%",
        Kind::Error,
        "Of these, those of which a corner or the middle of the near rectangle is in shadow; all samples are 17 by 17.",
    ),
    Metric::less(
        "shadow_eyes_missed_mostly",
        "%",
        Kind::Error,
        "Of these, those of which more than half of the near rectangle is in shadow: most of the picture miscounts.",
    ),
    Metric::less(
        "shadow_eyes_needless",
        "%",
        Kind::Error,
        "Eyes for which z-fail is chosen while no sample of the near rectangle is in shadow: slower and right.",
    ),
    Metric::less(
        "shadow_fail_triangles",
        "%",
        Kind::Counter,
        "Triangles of casters drawn by z-fail, mean over all eyes.",
    ),
    Metric::less(
        "shadow_near_dark",
        "%",
        Kind::Error,
        "Share of the near rectangle in shadow, mean over missed eyes: at most so many pixels are wrong.",
    ),
    Metric::neither(
        "shadow_receiver_px",
        "px",
        Kind::Counter,
        "Pixels of sea and casters in all channels.",
    ),
    Metric::neither(
        "shadow_px",
        "px",
        Kind::Counter,
        "Pixels in shadow by the reference, in all channels.",
    ),
    Metric::neither(
        "shadow_edge_on_px",
        "px",
        Kind::Counter,
        "Pixels on faces within 10⁻³ of edge-on to the sun, which are not judged.",
    ),
    Metric::less(
        "shadow_undecided_px",
        "px",
        Kind::Error,
        "Pixels on which the reference's two tests disagree, which are not judged.",
    ),
    Metric::less(
        "shadow_false_lit_px",
        "px",
        Kind::Error,
        "Pixels lit where the reference has shadow, outside the band of a pixel along its boundary.",
    ),
    Metric::less(
        "shadow_false_dark_px",
        "px",
        Kind::Error,
        "Pixels in shadow where the reference is lit, outside the band.",
    ),
    Metric::less(
        "shadow_rim_px",
        "px",
        Kind::Error,
        "Wrong pixels of a device outside the band, yet within its rounding, 1/32 of a pixel: at a caster's rim, in a triangle that is thinner, or where the boundary of one part's shadow runs within others.",
    ),
    Metric::less(
        "shadow_timed_wrong_px",
        "px",
        Kind::Error,
        "Pixels wrong outside the band and beyond rounding in the picture that is timed, where its size is not that of the channels.",
    ),
    Metric::less(
        "shadow_band_px",
        "px",
        Kind::Error,
        "Wrong pixels in the band along the shadow's boundary.",
    ),
    Metric::less(
        "shadow_lost_share",
        "%",
        Kind::Error,
        "Shadow pixels that are lost, the band included, of all shadow pixels.",
    ),
    Metric::less(
        "shadow_updates",
        "",
        Kind::Counter,
        "Stencil writes per pixel over all channels, counted along the ray of each pixel: a cost without noise.",
    ),
    Metric::neither(
        "shadow_volume_triangles",
        "",
        Kind::Counter,
        "Triangles of all volumes.",
    ),
    Metric::neither(
        "shadow_max_overlap",
        "",
        Kind::Counter,
        "Largest count of a pixel.",
    ),
    Metric::less(
        "shadow_contour_px",
        "px",
        Kind::Error,
        "Contour pixels of outlines that are drawn inside their model or left out beside it.",
    ),
    Metric::less(
        "shadow_clears",
        "",
        Kind::Counter,
        "Clears of the stencil for outlines, the first included.",
    ),
];
