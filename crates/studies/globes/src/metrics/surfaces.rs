// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a surface as drawn is from the body, and what formulas say of it.

use terrafill_globe_views::pixels;
use terrafill_results::{Kind, Metric};

terrafill_results::metrics! {
    GLOBE_WIRES = Metric::counter("globe_wires", "Edges of the triangles that face the eye, each once.");
    GLOBE_WIRE_PX = pixels("globe_wire_px", "Pixels that the lines of edges light.");
    GLOBE_WIRE_BEYOND_PX = pixels("globe_wire_beyond_px", "Pixels that lines light and that lie more than a pixel from each of them.");
    GLOBE_WIRE_MISSING = Metric::counter("globe_wire_missing", "Lines of two pixels or more that light no pixel at their middle.");
    GLOBE_WIRE_CONTROL_PX = pixels("globe_wire_control_px", "Lit pixels that lie off every line where the picture is moved by 5 and 3 pixels: a negative control.");
    GLOBE_CRACK_PX = pixels("globe_crack_px", "Pixels of a filled surface that show no triangle though triangles enclose them.");
    GLOBE_FILLED_CONTROL_PX = pixels("globe_filled_control_px", "Pixels that differ from rays where the picture of a filled surface is moved by 3 pixels: a negative control.");
    GLOBE_COMPARED_PX = pixels("globe_compared_px", "Pixels whose ray meets both the body and the surface as drawn.");
    GLOBE_PX_MAX = Metric::error_px(
        "globe_px_max",
        "Where the foot of a pixel's drawn place, along the geodetic normal, is seen on the true body: its distance from the pixel's centre, largest.",
    );
    GLOBE_PX_P99 = Metric::error_px("globe_px_p99", "The same, 99 % of the pixels.");
    GLOBE_PX_MEDIAN = Metric::error_px("globe_px_median", "The same, median of the pixels.");
    GLOBE_M_MAX = Metric::error("globe_m_max", "m", "The same on the ground, largest.");
    GLOBE_MAP_PX_MAX = Metric::error_px(
        "globe_map_px_max",
        "As `globe_px_max` for the place that longitude and Mercator's latitude give, interpolated from the triangle's corners: what a map as a texture shows.",
    );
    GLOBE_MAP_PX_P99 = Metric::error_px("globe_map_px_p99", "The same, 99 % of the pixels.");
    GLOBE_MAP_PX_MEDIAN = Metric::error_px("globe_map_px_median", "The same, median of the pixels.");
    GLOBE_MAP_M_MAX = Metric::error("globe_map_m_max", "m", "The same on the ground, largest.");
    GLOBE_DEPTH_M_MAX = Metric::error(
        "globe_depth_m_max",
        "m",
        "Distance along a pixel's ray from the true place to the drawn one, largest.",
    );
    GLOBE_LOWEST_M = Metric::neither(
        "globe_lowest_m",
        "m",
        Kind::Error,
        "Height above the body of the lowest drawn place at a pixel's centre; the nearer to 0 the better.",
    );
    GLOBE_STATED_LOWEST_M = Metric::neither(
        "globe_stated_lowest_m",
        "m",
        Kind::Counter,
        "Height below which the surface says that none of its triangles in this view lies.",
    );
    GLOBE_UNCOVERED_PX = Metric::error_px(
        "globe_uncovered_px",
        "Pixels more than one pixel within the body's outline that show no surface.",
    );
    GLOBE_EXTRA_PX = Metric::error_px("globe_extra_px", "Pixels that show surface where the body is not.");
    GLOBE_NON_FINITE = Metric::error(
        "globe_non_finite",
        "",
        "Triangles with a corner that is NaN or infinite, and figures that are.",
    );
    GLOBE_DRAWN_OTHERWISE_PX = Metric::error_px(
        "globe_drawn_otherwise_px",
        "Pixels that the device draws and rays against the triangles do not meet, or the other way round, but for those beside the outline of what rays meet; at most 0.",
    );
    GLOBE_EXPECTED_PX_MAX = Metric::neither(
        "globe_expected_px_max",
        "px",
        Kind::Error,
        "What a formula says of `globe_px_max`; the note `expected-by` has it.",
    );
    GLOBE_EXPECTED_MAP_M_MAX = Metric::neither(
        "globe_expected_map_m_max",
        "m",
        Kind::Error,
        "What a formula says of `globe_map_m_max`.",
    );
    GLOBE_EXPECTED_LOWEST_M = Metric::neither(
        "globe_expected_lowest_m",
        "m",
        Kind::Error,
        "What a formula says of `globe_lowest_m`.",
    );
}
