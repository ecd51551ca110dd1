// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every figure of the study.

use terrafill_results::{Kind, Metric, Primary, Scope};

/// Pixels of some sort, of which neither more nor fewer are better.
const fn pixels(name: &'static str, meaning: &'static str) -> Metric {
    Metric::neither(name, "px", Kind::Counter, meaning)
}

pub(crate) const METRICS: [Metric; 69] = [
    Metric::time_ms(
        "globe_whole_cpu_ms",
        "Process CPU time of a frame whose eye has moved: making, uploading and drawing the surface.",
    ).covering(Scope::PLAN.and(Scope::FRAME)).ranking(Primary::Cpu),
    Metric::time_ms(
        "globe_whole_gpu_ms",
        "Process CPU time of making and uploading, and the GPU's time of drawing. The device's copies of what was uploaded are in neither.",
    ).covering(Scope::PLAN.and(Scope::DEVICE)).ranking(Primary::Gpu),
    Metric::time_ms(
        "globe_whole_wall_ms",
        "Wall clock of making, uploading and drawing.",
    ).covering(Scope::PLAN.and(Scope::FRAME)),
    Metric::time_ms(
        "globe_make_cpu_ms",
        "Process CPU time of making the view's triangles.",
    ).covering(Scope::PLAN),
    Metric::time_ms(
        "globe_upload_cpu_ms",
        "Process CPU time of handing them to the device, which copies them later.",
    ).covering(Scope::UPLOAD),
    Metric::time_ms(
        "globe_draw_cpu_ms",
        "Process CPU time of drawing them, until the device is done.",
    ).covering(Scope::DEVICE),
    Metric::time_ms(
        "globe_draw_gpu_ms",
        "GPU time of the pass that draws them.",
    ).covering(Scope::DEVICE),
    Metric::bytes(
        "globe_upload_bytes",
        "Bytes of vertices, indices and constants handed to the device for a frame.",
    ),
    Metric::counter("globe_triangles", "Triangles of the view."),
    Metric::counter("globe_vertices", "Vertices of the view."),
    pixels("globe_compared_px", "Pixels whose ray meets both the body and the surface as drawn."),
    Metric::error_px(
        "globe_px_max",
        "Where the foot of a pixel's drawn place, along the geodetic normal, is seen on the true body: its distance from the pixel's centre, largest.",
    ),
    Metric::error_px("globe_px_p99", "The same, 99 % of the pixels."),
    Metric::error_px("globe_px_median", "The same, median of the pixels."),
    Metric::error("globe_m_max", "m", "The same on the ground, largest."),
    Metric::error_px(
        "globe_map_px_max",
        "As `globe_px_max` for the place that longitude and Mercator's latitude give, interpolated from the triangle's corners: what a map as a texture shows.",
    ),
    Metric::error_px("globe_map_px_p99", "The same, 99 % of the pixels."),
    Metric::error_px("globe_map_px_median", "The same, median of the pixels."),
    Metric::error("globe_map_m_max", "m", "The same on the ground, largest."),
    Metric::error(
        "globe_depth_m_max",
        "m",
        "Distance along a pixel's ray from the true place to the drawn one, largest.",
    ),
    Metric::neither(
        "globe_lowest_m",
        "m",
        Kind::Error,
        "Height above the body of the lowest drawn place at a pixel's centre; the nearer to 0 the better.",
    ),
    Metric::neither(
        "globe_stated_lowest_m",
        "m",
        Kind::Counter,
        "Height below which the surface says that none of its triangles in this view lies.",
    ),
    Metric::error_px(
        "globe_uncovered_px",
        "Pixels more than one pixel within the body's outline that show no surface.",
    ),
    Metric::error_px("globe_extra_px", "Pixels that show surface where the body is not."),
    Metric::error(
        "globe_non_finite",
        "",
        "Triangles with a corner that is NaN or infinite, and figures that are.",
    ),
    Metric::error_px(
        "globe_drawn_otherwise_px",
        "Pixels that the device draws and rays against the triangles do not meet, or the other way round, but for those beside the outline of what rays meet; at most 0.",
    ),
    Metric::neither(
        "globe_expected_px_max",
        "px",
        Kind::Error,
        "What a formula says of `globe_px_max`; the note `expected-by` has it.",
    ),
    Metric::neither(
        "globe_expected_map_m_max",
        "m",
        Kind::Error,
        "What a formula says of `globe_map_m_max`.",
    ),
    Metric::neither(
        "globe_expected_lowest_m",
        "m",
        Kind::Error,
        "What a formula says of `globe_lowest_m`.",
    ),
    pixels("globe_tile_px", "Pixels that show a texel and whose triangle holds no pole."),
    Metric::error(
        "globe_tile_texels_max",
        "texels",
        "How far outside the texel that a pixel shows its place on the triangle as drawn lies, largest; triangles that hold a pole are left out.",
    ),
    Metric::error("globe_tile_texels_p99", "texels", "The same, 99 % of the pixels."),
    Metric::error(
        "globe_tile_true_texels_max",
        "texels",
        "How far outside the texel that a pixel shows its true place on the body lies, largest.",
    ),
    Metric::error("globe_tile_true_texels_p99", "texels", "The same, 99 % of the pixels."),
    Metric::error("globe_tile_true_texels_median", "texels", "The same, median of the pixels."),
    pixels("globe_tile_seam_px", "Pixels within two of ±180°, caps of the poles left out."),
    Metric::error_px(
        "globe_tile_seam_wrong_px",
        "Of them, those that show a texel off by more than ½ from their place on the triangle as drawn, or none.",
    ),
    Metric::less(
        "globe_tile_pole_px",
        "px",
        Kind::Counter,
        "Pixels in triangles that hold a pole, where longitude is no function.",
    ),
    pixels("globe_tile_cap_px", "Pixels poleward of 85.05°, shown from a stereographic cap."),
    Metric::error_px(
        "globe_tile_missing_px",
        "Pixels of the surface that ask for a tile that is not there.",
    ),
    Metric::quantity("globe_tile_crossing", "Triangles across ±180° that hold no pole."),
    Metric::error("globe_tile_missed", "", "Of them, those that the seam's rule leaves whole."),
    Metric::counter("globe_tile_count", "Tiles that a view needs, two caps among them."),
    Metric::counter("globe_tile_draws", "Draws of a frame."),
    Metric::bytes("globe_tile_bytes", "Bytes of the texels of a view's tiles."),
    Metric::error_px(
        "globe_tile_colour_wrong_px",
        "Pixels that have another colour than the texel that they show.",
    ),
    Metric::error(
        "globe_tile_colour_off_median",
        "",
        "Difference of a pixel's colour from the whole picture at its place on the body: the largest channel's, of 255, median.",
    ),
    Metric::error("globe_tile_colour_off_p99", "", "The same, 99 % of the pixels."),
    Metric::error_px(
        "globe_count_off_px",
        "Largest difference of a node's counted pixels from those that rays see.",
    ),
    Metric::error(
        "globe_count_wrong_nodes",
        "",
        "Nodes whose counts are off by more than the pixels at their edges; at most 0.",
    ),
    Metric::quantity("globe_count_nodes", "Nodes whose counts were compared."),
    Metric::counter("globe_count_leaves", "Leaves of the quadtree in the last frame."),
    Metric::counter(
        "globe_count_settle_frames",
        "Frames after which a quadtree no longer changes in a view that stands still.",
    ),
    Metric::counter(
        "globe_count_cycles",
        "1 where a quadtree changes to the end in a view that stands still, else 0.",
    ),
    Metric::quantity(
        "globe_count_texels_per_px",
        "Texels of all leaves over their pixels in the last frame.",
    ),
    Metric::time_ms(
        "globe_count_page_cpu_ms",
        "Process CPU time of handing a frame's new pictures to the device, which copies them later; mean of the frames.",
    ).covering(Scope::UPLOAD),
    Metric::time_ms("globe_count_page_max_cpu_ms", "The same, largest.").covering(Scope::UPLOAD),
    Metric::counter(
        "globe_zone_hides",
        "Pixels of a zone a level below the finest over those that it has at the finest, largest of all zones: what spikes hide.",
    ),
    Metric::time_ms(
        "globe_counted_cpu_ms",
        "Process CPU time of a frame whose pixels are counted by node and read back at once.",
    ).covering(Scope::FRAME.and(Scope::READ_BACK)),
    Metric::time_ms(
        "globe_uncounted_cpu_ms",
        "Process CPU time of the same frame without counts.",
    ).covering(Scope::FRAME),
    pixels("globe_shade_px", "Pixels that show a shaded surface."),
    Metric::error(
        "globe_shade_max",
        "",
        "A pixel's colour against the layers' functions in f64: the largest channel's difference, 1 being white, largest.",
    ),
    Metric::error("globe_shade_p99", "", "The same, 99 % of the pixels."),
    Metric::error("globe_shade_polar_max", "", "The same within 5° of a pole, largest."),
    Metric::error("globe_shade_polar_p99", "", "The same within 5° of a pole, 99 % of the pixels."),
    Metric::error_px(
        "globe_made_px_max",
        "How far a vertex made on the device is from the same in f64, seen by the eye, largest.",
    ),
    Metric::error("globe_made_m_max", "m", "The same in metres."),
    Metric::error_px(
        "globe_made_differs_px",
        "Pixels whose distance differs in any bit from the picture of the vertices that a compute shader made.",
    ),
    Metric::bytes("globe_height_bytes", "Bytes of the heights that vertices are moved up by."),
];
