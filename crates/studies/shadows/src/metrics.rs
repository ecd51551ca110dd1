// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the study measures.

use terrafill_results::{Kind, Metric, Primary, Scope};

type Text = &'static str;

const fn time(name: Text, meaning: Text) -> Metric {
    Metric::less(name, "ms", Kind::Time, meaning)
}

/// Pixels that are wrong.
const fn px(name: Text, meaning: Text) -> Metric {
    Metric::less(name, "px", Kind::Error, meaning)
}

/// A share that is wrong.
const fn percent(name: Text, meaning: Text) -> Metric {
    Metric::less(name, "%", Kind::Error, meaning)
}

const fn cost(name: Text, meaning: Text) -> Metric {
    Metric::less(name, "", Kind::Counter, meaning)
}

const fn fact(name: Text, meaning: Text) -> Metric {
    Metric::neither(name, "", Kind::Counter, meaning)
}

/// Pixels of a view.
const fn seen(name: Text, meaning: Text) -> Metric {
    Metric::neither(name, "px", Kind::Counter, meaning)
}

pub(crate) const METRICS: [Metric; 44] = [
    time(
        "shadow_silhouette_cpu_ms",
        "Process CPU time of finding the silhouette; facing bits and adjacency are there already.",
    )
    .covering(Scope::PLAN)
    .ranking(Primary::Any),
    time(
        "shadow_fill_cpu_ms",
        "Process CPU time in which a device draws the shadows of the channel that has most, in a picture of `size_px`; surface and volumes are there already.",
    )
    .covering(Scope::FRAME),
    time(
        "shadow_fill_gpu_ms",
        "GPU time of the same.",
    )
    .covering(Scope::DEVICE),
    time(
        "shadow_volumes_cpu_ms",
        "Process CPU time of finding the volumes of all casters for a frame; none where they are kept.",
    )
    .covering(Scope::PLAN),
    time(
        "shadow_build_gpu_ms",
        "GPU time of building the device's tree of triangles, once for casters that rest.",
    )
    .covering(Scope::DISPATCH),
    cost(
        "shadow_fragments",
        "Fragments of volumes per pixel over all channels, by the device's query.",
    ),
    cost("shadow_draws", "Draw calls of a device over all channels."),
    Metric::bytes(
"shadow_bytes",
        "Vertices and indices of the volumes that a device holds for a channel, the largest; texels of a map.",
    ),
    Metric::bytes(
"shadow_sun_bytes",
        "What of these a device is handed anew for another sun.",
    ),
    fact(
        "shadow_casters_left_out",
        "Casters whose shadow lands nowhere in view, summed over all channels: they are not drawn.",
    ),
    time(
        "shadow_map_cpu_ms",
        "Process CPU time of drawing a shadow map on the CPU and asking it for every pixel of all channels.",
    )
    .covering(Scope::PLAN),
    time(
        "shadow_map_gpu_ms",
        "GPU time of drawing a device's shadow map.",
    )
    .covering(Scope::DRAW),
    percent(
        "shadow_map_differs",
        "Pixels of which a device's map says otherwise than the CPU's, of all that the reference judges.",
    ),
    percent(
        "shadow_map_wrong",
        "Wrong pixels of all that the reference judges, the band included, at the best step of the bias.",
    ),
    percent(
        "shadow_map_wrong_in_three",
        "The same of the three channels that see most pixels of casters, at the step that is best there.",
    ),
    percent("shadow_map_wrong_unbiased", "The same without a bias."),
    Metric::neither(
        "shadow_map_bias_m",
        "m",
        Kind::Error,
        "The best step of the bias, along the light, on level ground.",
    ),
    fact("shadow_sides", "Silhouette edges: sides of the volumes."),
    fact("shadow_mesh_triangles", "Triangles of the casters."),
    fact(
        "shadow_mesh_models",
        "Models in a user's file: its objects, or its nodes with a mesh.",
    ),
    fact("shadow_mesh_parts", "Parts of these that hang together."),
    percent(
        "shadow_undecided_facings",
        "Triangles whose sign of facing in f32 depends on which corner comes first, in the channel with most.",
    ),
    Metric::error(
"shadow_open_edges",
"",
        "Directed edges of the volumes that are not met as often either way; 0 where every volume is closed.",
    ),
    percent(
        "shadow_eyes_missed",
        "Eyes for which z-pass is chosen while part of the near rectangle is in shadow, so that pixels miscount.",
    ),
    percent(
        "shadow_eyes_missed_at_corners",
        "Of these, those of which a corner or the middle of the near rectangle is in shadow; all samples are 17 by 17.",
    ),
    percent(
        "shadow_eyes_missed_mostly",
        "Of these, those of which more than half of the near rectangle is in shadow: most of the picture miscounts.",
    ),
    percent(
        "shadow_eyes_needless",
        "Eyes for which z-fail is chosen while no sample of the near rectangle is in shadow: slower and right.",
    ),
    Metric::less(
        "shadow_fail_triangles",
        "%",
        Kind::Counter,
        "Triangles of casters drawn by z-fail, mean over all eyes.",
    ),
    percent(
        "shadow_near_dark",
        "Share of the near rectangle in shadow, mean over missed eyes: at most so many pixels are wrong.",
    ),
    seen(
        "shadow_receiver_px",
        "Pixels of sea and casters in all channels.",
    ),
    seen(
        "shadow_px",
        "Pixels in shadow by the reference, in all channels.",
    ),
    seen(
        "shadow_edge_on_px",
        "Pixels on faces within 10⁻³ of edge-on to the sun, which are not judged.",
    ),
    px(
        "shadow_undecided_px",
        "Pixels on which the reference's two tests disagree, which are not judged.",
    ),
    px(
        "shadow_false_lit_px",
        "Pixels lit where the reference has shadow, outside the band of a pixel along its boundary.",
    ),
    px(
        "shadow_false_dark_px",
        "Pixels in shadow where the reference is lit, outside the band.",
    ),
    px(
        "shadow_rim_px",
        "Wrong pixels of a device outside the band, yet within its rounding, 1/32 of a pixel: at a caster's rim, in a triangle that is thinner, or where the boundary of one part's shadow runs within others.",
    ),
    px(
        "shadow_timed_wrong_px",
        "Pixels wrong outside the band and beyond rounding in the picture that is timed, where its size is not that of the channels.",
    ),
    px(
        "shadow_band_px",
        "Wrong pixels in the band along the shadow's boundary.",
    ),
    percent(
        "shadow_lost_share",
        "Shadow pixels that are lost, the band included, of all shadow pixels.",
    ),
    cost(
        "shadow_updates",
        "Stencil writes per pixel over all channels, counted along the ray of each pixel: a cost without noise.",
    ),
    fact("shadow_volume_triangles", "Triangles of all volumes."),
    fact("shadow_max_overlap", "Largest count of a pixel."),
    px(
        "shadow_contour_px",
        "Contour pixels of outlines that are drawn inside their model or left out beside it.",
    ),
    cost(
        "shadow_clears",
        "Clears of the stencil for outlines, the first included.",
    ),
];
