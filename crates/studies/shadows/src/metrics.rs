// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_outlines as outlines;
use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared API, SIZE_PX, VIEW;
    BIAS = "bias", "what keeps a lit receiver out of its own shadow in a map";
    BOXES = "boxes", "how boxes are turned: edge-on to the sun, or at random";
    CASTERS = "casters", "how many models cast shadows";
    COUNTED = "counted", "which pixels are judged, where not all are: above the sea, or in the range of depths";
    COUNTING = "counting", "how many shadows of one pixel a stencil of 8 bits tells apart";
    DEPTH_BOUNDS = "depth_bounds", "where the surface must lie for a fragment of a volume to count: in its range of depth, tested by the device, a shader, or for tiles";
    EXTENT = "extent", "where volumes end: nowhere, below the sea, or at a length";
    EYE_TEST = "eye_test", "how the rule is chosen: by the eye, or by what lies between near plane and sun";
    FACES = "faces", "both faces of a volume in one draw, or in one each";
    LENGTH_M = "length_m", "length of volumes, metres";
    LIGHT = "light", "which light shines, other than the sun: one at a place, or the moon";
    LIMIT = "limit", "what keeps the shadows of a lamp to its reach";
    MESH = "mesh", "which model is cast";
    MODEL = "model", "which model casts";
    MODELS = outlines::MODELS.name(), "how many models are outlined";
    NEAR_M = "near_m", "distance of the near plane, metres";
    OUTLINE = outlines::OUTLINE.name(), "how contours within a model are left out";
    PAPER = "paper", "what the paper says of the step";
    POLICY = "policy", "what becomes of a mesh with open edges: refused, closed by caps, counted by its own edges, or taken as it is";
    POSITIONS = "positions", "where coordinates begin: at the eye, or at an origin so far away";
    QUESTION = "question", "what the case is measured for";
    RIVAL = "rival", "shadows without volumes, what a user would pick instead";
    RULE = "rule", "which fragments of volumes count";
    SCISSOR = "scissor", "what the stencil is restricted to";
    SILHOUETTE = "silhouette", "how the edges are found from which volumes are made";
    STEP = "step", "of the ablation: what is changed against the step before";
    STROKE_PX = outlines::STROKE_PX.name(), "width of strokes along contours, pixels";
    SUN = "sun", "elevation of the sun, and its azimuth";
    TEXEL_M = "texel_m", "side of a texel of the map, metres";
    "value" = "each model has a stencil value of its own; strokes are kept where the stencil differs from it";
    "value as printed" = "strokes are kept where the stencil is equal";
    "value, never cleared" = "values come round without a clear: a negative control";
    "z-pass" = "front faces in front of the surface count +1, back faces there −1";
    "z-fail" = "back faces behind the surface count +1, front faces there −1";
    "preload" = "all volumes are counted without the surface first, then those in front of it the other way";
    "as printed" = "by the formula as the paper prints it";
    "zp-plus" = "z-pass, with the near plane covered by what lies between it and the sun";
    "infinite" = "volumes that end nowhere";
    "finite" = "volumes of a stated length";
    "sea-closed" = "volumes that end below the sea";
    "whole hulls" = "casters that go on under the sea";
    "calm" = "a sea without waves: volumes end 0.2 m below it";
    "eye" = "for the frame, by whether something stands between the eye and the sun, as published";
    "near-box-model" = "by the box of each model";
    "near-box-part" = "by the box of each convex part";
    "near-exact" = "by the lit triangles of each convex part";
    "eye-model" = "for each model, by whether it stands between the eye and the sun";
    "by view" = "one rule for all casters of a view";
    "each frame" = "the CPU finds silhouettes anew and hands volumes over in every frame";
    "port-m10" = "ten ports, each of other cranes, ships and containers";
    "stack" = "edges in a stack, as published";
    "hash" = "edges in a hash table";
    "adjacency" = "each triangle knows its neighbours";
    "hull" = "a convex hull";
    "port" = "the models of a port";
    "constant" = "a bias of so many metres";
    "slope" = "a bias of so many texels times the slope of the receiver against the light";
    "no normals" = "faces turned away from the sun ask the map too";
    "map" = "shadow map: depths seen from the sun";
    "volumes" = "shadow volumes";
    "horizon" = "of a scissor: rows above the horizon, which the paper does not say";
    "sea-level" = "of a scissor: the rectangle round all that is drawn above the sea, as the paper has it";
    "above the sea" = "pixels of casters alone are judged: the paper considers no other shadow";
    "in the range" = "pixels whose depth is in the range of interest alone are judged";
    "one range" = "of depth bounds: between the nearest and the farthest that a channel shows above the sea";
    "bridge" = "from 30 m up on own ship: seven channels over 270°";
    "aerial" = "from 300 m up, looking down by 31°";
    "shore light" = "a lamp 33 m up at a crane, with a range of 100 m";
    "deck light" = "a lamp on the foremast of the moored ship, with a range of 60 m";
    "searchlight" = "a beam of 28° from own ship's foremast onto the moored ship, with a range of 200 m";
    "eye in shadow" = "from the dock, where something stands between the eye and the lamp";
    "volumes end beyond it" = "no place of a volume's end is nearer to the lamp than its range";
    "volumes' corners end at it" = "corners of a volume's end lie at the range, and between them it is too short";
    "scissor of half of it" = "a scissor round half the range and half the beam, which is too small";
    "depth bounds" = "of a lamp: the depths of what is seen must lie in its reach";
    "casters in reach" = "parts of casters that a lamp cannot reach are left out";
    "reach" = "of a lamp: its range and its beam";
    "near plane" = "the nearest depth that is drawn";
    "shadow pixels lost" = "pixels in shadow that a finite volume does not reach";
    "stencil writes" = "changes of the stencil by fragments of volumes";
}

terrafill_results::metrics! {
    TIME = Metric::time_ms(
        "shadow_silhouette_cpu_ms",
        "Process CPU time of finding the silhouette; facing bits and adjacency are there already.",
    )
    .covering(Scope::PLAN)
    .ranking(Primary::Any);
    FILL_CPU = Metric::time_ms(
        "shadow_fill_cpu_ms",
        "Process CPU time in which a device draws the shadows of all channels, one after the other; surface and volumes are there already.",
    )
    .covering(Scope::FRAME);
    FILL_GPU = Metric::time_ms("shadow_fill_gpu_ms", "GPU time of the same.").covering(Scope::DEVICE);
    WHOLE_CPU = Metric::time_ms(
        "shadow_whole_cpu_ms",
        "Process CPU time of a frame's shadows in all channels: what the CPU does for them first, and what the device draws. The CPU chooses rules, or finds volumes and hands them over, where that is done each frame.",
    )
    .covering(Scope::FRAME.and(Scope::PLAN));
    WHOLE_WALL = Metric::time_ms(
        "shadow_whole_wall_ms",
        "Wall clock of the same.",
    )
    .covering(Scope::FRAME.and(Scope::PLAN));
    SHADOW_PLANNED_CPU_MS = Metric::time_ms(
        "shadow_planned_cpu_ms",
        "Process CPU time of what the CPU does of it first.",
    )
    .covering(Scope::PLAN);
    FRAME_WALL = Metric::time_ms(
        "shadow_frame_wall_ms",
        "Wall clock of a frame of all channels: surface, volumes and cover of each, one after the other, each waited for. Volumes are there already. 1,000 over it is frames a second.",
    )
    .covering(Scope::FRAME);
    FRAME_CPU = Metric::time_ms(
        "shadow_frame_cpu_ms",
        "Process CPU time of the same.",
    )
    .covering(Scope::FRAME);
    FRAME_GPU = Metric::time_ms(
        "shadow_frame_gpu_ms",
        "GPU time of the same: passes of surface and shadows, summed over all channels.",
    )
    .covering(Scope::DEVICE);
    SHADOW_VOLUMES_CPU_MS = Metric::time_ms(
        "shadow_volumes_cpu_ms",
        "Process CPU time of finding the volumes of all casters for a frame; none where they are kept.",
    )
    .covering(Scope::PLAN);
    SHADOW_BUILD_GPU_MS = Metric::time_ms(
        "shadow_build_gpu_ms",
        "GPU time of building the device's tree of triangles, once for casters that rest.",
    )
    .covering(Scope::DISPATCH);
    SHADOW_FRAGMENTS = Metric::counter(
        "shadow_fragments",
        "Fragments of volumes per pixel over all channels, by the device's query.",
    );
    SHADOW_DRAWS = Metric::counter("shadow_draws", "Draw calls of a device over all channels.");
    SHADOW_BYTES = Metric::bytes(
        "shadow_bytes",
        "Vertices and indices of the volumes that a device holds for a channel, the largest; texels of a map.",
    );
    SHADOW_SUN_BYTES = Metric::bytes(
        "shadow_sun_bytes",
        "What of these a device is handed anew for another sun.",
    );
    SHADOW_CASTERS_LEFT_OUT = Metric::quantity(
        "shadow_casters_left_out",
        "Casters whose shadow lands nowhere in view, summed over all channels: they are not drawn.",
    );
    SHADOW_MAP_CPU_MS = Metric::time_ms(
        "shadow_map_cpu_ms",
        "Process CPU time of drawing a shadow map on the CPU and asking it for every pixel of all channels.",
    )
    .covering(Scope::PLAN);
    SHADOW_MAP_GPU_MS = Metric::time_ms(
        "shadow_map_gpu_ms",
        "GPU time of drawing a device's shadow map.",
    )
    .covering(Scope::DRAW);
    SHADOW_MAP_DIFFERS = percent(
        "shadow_map_differs",
        "Pixels of which a device's map says otherwise than the CPU's, of all that the reference judges.",
    );
    MAP_WRONG = percent(
        "shadow_map_wrong",
        "Wrong pixels of all that the reference judges, the band included, at the best step of the bias.",
    );
    SHADOW_MAP_WRONG_IN_THREE = percent(
        "shadow_map_wrong_in_three",
        "The same of the three channels that see most pixels of casters, at the step that is best there.",
    );
    SHADOW_MAP_WRONG_UNBIASED = percent("shadow_map_wrong_unbiased", "The same without a bias.");
    SHADOW_MAP_BIAS_M = Metric::neither(
        "shadow_map_bias_m",
        "m",
        Kind::Error,
        "The best step of the bias, along the light, on level ground.",
    );
    SHADOW_SIDES = Metric::quantity("shadow_sides", "Silhouette edges: sides of the volumes.");
    SHADOW_MESH_TRIANGLES = Metric::quantity("shadow_mesh_triangles", "Triangles of the casters.");
    SHADOW_MESH_MODELS = Metric::quantity(
        "shadow_mesh_models",
        "Models in a user's file: its objects, or its nodes with a mesh.",
    );
    SHADOW_MESH_PARTS = Metric::quantity("shadow_mesh_parts", "Parts of these that hang together.");
    SHADOW_UNDECIDED_FACINGS = percent(
        "shadow_undecided_facings",
        "Triangles whose sign of facing in f32 depends on which corner comes first, in the channel with most.",
    );
    SHADOW_OPEN_EDGES = Metric::error(
        "shadow_open_edges",
        "",
        "Directed edges of the volumes that are not met as often either way; 0 where every volume is closed.",
    );
    MISSED = percent(
        "shadow_eyes_missed",
        "Eyes for which z-pass is chosen while part of the near rectangle is in shadow, so that pixels miscount.",
    );
    SHADOW_EYES_MISSED_AT_CORNERS = percent(
        "shadow_eyes_missed_at_corners",
        "Of these, those of which a corner or the middle of the near rectangle is in shadow; all samples are 17 by 17.",
    );
    MOSTLY = percent(
        "shadow_eyes_missed_mostly",
        "Of these, those of which more than half of the near rectangle is in shadow: most of the picture miscounts.",
    );
    SHADOW_EYES_NEEDLESS = percent(
        "shadow_eyes_needless",
        "Eyes for which z-fail is chosen while no sample of the near rectangle is in shadow: slower and right.",
    );
    SHADOW_FAIL_TRIANGLES = Metric::less(
        "shadow_fail_triangles",
        "%",
        Kind::Counter,
        "Triangles of casters drawn by z-fail, mean over all eyes.",
    );
    SHADOW_NEAR_DARK = percent(
        "shadow_near_dark",
        "Share of the near rectangle in shadow, mean over missed eyes: at most so many pixels are wrong.",
    );
    SHADOW_RECEIVER_PX = seen(
        "shadow_receiver_px",
        "Pixels of sea and casters in all channels.",
    );
    SHADOW_PX = seen(
        "shadow_px",
        "Pixels in shadow by the reference, in all channels.",
    );
    SHADOW_REACHED_PX = seen(
        "shadow_reached_px",
        "Pixels of sea and casters within the range and the beam of a lamp.",
    );
    SHADOW_EDGE_ON_PX = seen(
        "shadow_edge_on_px",
        "Pixels on faces within 10⁻³ of edge-on to the sun, which are not judged.",
    );
    SHADOW_UNDECIDED_PX = Metric::error_px(
        "shadow_undecided_px",
        "Pixels on which the reference's two tests disagree, which are not judged.",
    );
    SHADOW_FALSE_LIT_PX = Metric::error_px(
        "shadow_false_lit_px",
        "Pixels lit where the reference has shadow, outside the band of a pixel along its boundary.",
    );
    SHADOW_FALSE_DARK_PX = Metric::error_px(
        "shadow_false_dark_px",
        "Pixels in shadow where the reference is lit, outside the band.",
    );
    SHADOW_RIM_PX = Metric::error_px(
        "shadow_rim_px",
        "Wrong pixels of a device outside the band, yet within its rounding, 1/32 of a pixel: at a caster's rim, in a triangle that is thinner, or where the boundary of one part's shadow runs within others.",
    );
    SHADOW_BAND_PX = Metric::error_px(
        "shadow_band_px",
        "Wrong pixels in the band along the shadow's boundary.",
    );
    LOST = percent(
        "shadow_lost_share",
        "Shadow pixels that are lost, the band included, of all shadow pixels.",
    );
    UPDATES = Metric::counter(
        "shadow_updates",
        "Stencil writes per pixel over all channels, counted along the ray of each pixel: a cost without noise.",
    );
    SHADOW_VOLUME_TRIANGLES = Metric::quantity("shadow_volume_triangles", "Triangles of all volumes.");
    SHADOW_MAX_OVERLAP = Metric::quantity("shadow_max_overlap", "Largest count of a pixel.");
    OUTLINE_CPU_MS = *outlines::OUTLINE_CPU_MS;
    OUTLINE_GPU_MS = *outlines::OUTLINE_GPU_MS;
    SHADOW_CONTOUR_PX = *outlines::SHADOW_CONTOUR_PX;
    SHADOW_CLEARS = *outlines::SHADOW_CLEARS;
    SHADOW_OUTLINE_UNLIKE_PX = *outlines::SHADOW_OUTLINE_UNLIKE_PX;
    SHADOW_OUTLINE_PX = *outlines::SHADOW_OUTLINE_PX;
    SHADOW_OUTLINE_UNDECIDED_PX = *outlines::SHADOW_OUTLINE_UNDECIDED_PX;
}

/// Note of why a device's count of fragments is left out.
pub(crate) const MISCOUNTED: &str = "miscounted";

/// A share that is wrong.
const fn percent(name: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, "%", Kind::Error, meaning)
}

/// Pixels of a view.
const fn seen(name: &'static str, meaning: &'static str) -> Metric {
    Metric::neither(name, "px", Kind::Counter, meaning)
}
