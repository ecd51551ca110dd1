// SPDX-License-Identifier: MIT OR Apache-2.0
//! What counted pixels, controllers, shading and vertices made on the device are measured by.

use terrafill_globe_views::pixels;
use terrafill_results::{Kind, Metric, Scope};

terrafill_results::metrics! {
    GLOBE_COUNT_OFF_PX = Metric::error_px(
        "globe_count_off_px",
        "Largest difference of a node's counted pixels from those that rays see.",
    );
    GLOBE_COUNT_WRONG_NODES = Metric::error(
        "globe_count_wrong_nodes",
        "",
        "Nodes whose counts are off by more than the pixels at their edges; at most 0.",
    );
    GLOBE_COUNT_NODES = Metric::quantity("globe_count_nodes", "Nodes whose counts were compared.");
    GLOBE_COUNT_LEAVES = Metric::counter("globe_count_leaves", "Leaves of the quadtree in the last frame.");
    GLOBE_COUNT_SETTLE_FRAMES = Metric::counter(
        "globe_count_settle_frames",
        "Frames after which a quadtree no longer changes in a view that stands still.",
    );
    GLOBE_COUNT_CYCLES = Metric::counter(
        "globe_count_cycles",
        "1 where a quadtree changes to the end in a view that stands still, else 0.",
    );
    GLOBE_COUNT_TEXELS_PER_PX = Metric::quantity(
        "globe_count_texels_per_px",
        "Texels of all leaves over their pixels in the last frame.",
    );
    GLOBE_ZONE_HIDES = Metric::counter(
        "globe_zone_hides",
        "Pixels of a zone a level below the finest over those that it has at the finest, largest of all zones: what spikes hide.",
    );
    GLOBE_ZONE_HIDDEN = Metric::counter(
        "globe_zone_hidden",
        "Zones at rest without a counted pixel that have some where there is no hill.",
    );
    GLOBE_ZONE_HIDDEN_LEVEL = Metric::counter(
        "globe_zone_hidden_level",
        "Level of the finest of these zones; 0 is the coarsest.",
    );
    GLOBE_ZONE_PX = Metric::counter("globe_zone_px", "Counted pixels of the zone seen edge-on, at rest.");
    GLOBE_ZONE_LEVEL = Metric::counter("globe_zone_level", "Its level, 0 the coarsest.");
    GLOBE_ZONE_OTHER_PX = Metric::error_px(
        "globe_zone_other_px",
        "Pixels whose triangle of a height field is not their ray's in f64, but for those whose centre lies within 1/64 px of its border; at most 0.",
    );
    GLOBE_ZONE_CONTROL_PX = pixels(
        "globe_zone_control_px",
        "The same of a picture that is moved by 3 pixels: a negative control.",
    );
    GLOBE_COUNTED_CPU_MS = Metric::time_ms(
        "globe_counted_cpu_ms",
        "Process CPU time of a frame whose pixels are counted by node and read back at once.",
    ).covering(Scope::FRAME.and(Scope::READ_BACK));
    GLOBE_UNCOUNTED_CPU_MS = Metric::time_ms(
        "globe_uncounted_cpu_ms",
        "Process CPU time of the same frame without counts.",
    ).covering(Scope::FRAME);
    GLOBE_CONTROLLED_CPU_MS = Metric::time_ms(
        "globe_controlled_cpu_ms",
        "Process CPU time of a frame whose radii its rule decides on: the decision, constants where the eye has moved, drawing, and the counts read at once.",
    ).covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK));
    GLOBE_CONTROLLER_WRONG_FRAMES = Metric::error(
        "globe_controller_wrong_frames",
        "",
        "Frames whose counted pixels, of the fan or of all, are not those that rays see in f64. Pixels so near to a rim that rounding of corners decides are left out; at most 0.",
    );
    GLOBE_CONTROLLER_FRAMES = Metric::quantity(
        "globe_controller_frames",
        "Frames that were compared with rays; equal ones of an eye at rest count once in each half.",
    );
    GLOBE_CONTROLLER_BAND_PX = pixels(
        "globe_controller_band_px",
        "Pixels so near to a rim that rounding of corners decides, largest of the frames.",
    );
    GLOBE_CONTROLLER_PERIOD = Metric::counter(
        "globe_controller_period",
        "Frames after which what is drawn repeats in a view that stands still; 1: it is at rest.",
    );
    GLOBE_CONTROLLER_REST_FRAMES = Metric::counter(
        "globe_controller_rest_frames",
        "Frames after which nothing changes in a view that stands still.",
    );
    GLOBE_CONTROLLER_SWING = Metric::error(
        "globe_controller_swing",
        "%",
        "By how much the largest radius is over the smallest one in a view that stands still, second half of the frames.",
    );
    GLOBE_CONTROLLER_OFF = Metric::error(
        "globe_controller_off",
        "%",
        "By how much a radius is off the one in closed form, largest in the second half of the frames.",
    );
    GLOBE_FAN_OFF = Metric::error(
        "globe_fan_off",
        "%",
        "By how many of the wanted pixels the fan's are off, largest in the second half of the frames.",
    );
    GLOBE_FAN_GROWTH = Metric::less(
        "globe_fan_growth",
        "",
        Kind::Error,
        "Logarithm of the fan's pixels over the wanted ones, largest in the second half of the frames, over that of the first frame. Above 1 the fan is farther off than it began.",
    );
    GLOBE_FAN_GROWTH_LEAST = Metric::less(
        "globe_fan_growth_least",
        "",
        Kind::Error,
        "By what factor that logarithm grows from a frame to the next while the eye rests, least of the first 8 frames or of those before the fan is cut off. Above 1 it grows exponentially.",
    );
    GLOBE_FAN_CUT_FRAME = Metric::neither(
        "globe_fan_cut_frame",
        "frames",
        Kind::Counter,
        "The first frame whose fan has half of the picture or more, or is the smallest that is stored: the picture or the store ends its growth.",
    );
    GLOBE_BARE_SHARE = Metric::less(
        "globe_bare_share",
        "",
        Kind::Error,
        "Share of frames with bare pixels, of the second half: between 0 and 1 they come and go.",
    );
    GLOBE_BARE_GROWTH = Metric::less(
        "globe_bare_growth",
        "",
        Kind::Error,
        "Bare pixels in the last third of a rise's frames over those in the middle third: 1 where they neither grow nor shrink.",
    );
    GLOBE_BARE_PX = Metric::error_px(
        "globe_bare_px",
        "Pixels that show no spiral though they show the body, largest in the second half of the frames.",
    );
    GLOBE_BARE_DIAGONAL_PX = Metric::error_px(
        "globe_bare_diagonal_px",
        "How far from the corner's distance towards the middle a bare pixel lies, by rays, largest in the second half of the frames.",
    );
    GLOBE_SHADE_PX = pixels("globe_shade_px", "Pixels that show a shaded surface.");
    GLOBE_SHADE_TEXELS_MAX = Metric::error(
        "globe_shade_texels_max",
        "",
        "A pixel's colour against the same texels, filtered alike and shaded in f64: the largest channel's difference, 1 being white, largest.",
    );
    GLOBE_SHADE_BEYOND_PX = Metric::error_px(
        "globe_shade_beyond_px",
        "Pixels whose colour differs from that by more than 8 bits between texels, rounding to bytes and corners within 1/256 px explain; at most 0.",
    );
    GLOBE_FORMULA_PX_MAX = Metric::error_px(
        "globe_formula_px_max",
        "How far from a pixel's centre the projection's formula, in f64, puts the place that its triangle shows, largest.",
    );
    GLOBE_FORMULA_PX_P99 = Metric::error_px("globe_formula_px_p99", "The same, 99 % of the pixels.");
    GLOBE_FORMULA_FINE_PX_P99 = Metric::error_px(
        "globe_formula_fine_px_p99",
        "The same of triangles half as long, which are not drawn: below two thirds of it where tessellation is the cause.",
    );
    GLOBE_SHADE_OTHER_PX = pixels(
        "globe_shade_other_px",
        "Pixels in which the triangles of another projection are found.",
    );
    GLOBE_SHADE_CONTROL_PX = pixels(
        "globe_shade_control_px",
        "Pixels in which wrong layers are found: clouds and lights of night exchanged, clouds not moved, the sun on the other side; the least of the three.",
    );
    GLOBE_MIRRORED_PX = pixels(
        "globe_mirrored_px",
        "Pixels in which a layer mirrored east to west is found: a negative control.",
    );
    GLOBE_SHADE_MAX = Metric::error(
        "globe_shade_max",
        "",
        "A pixel's colour against the layers as published, bicubic and shaded in f64: the largest channel's difference, 1 being white, largest.",
    );
    GLOBE_SHADE_P99 = Metric::error("globe_shade_p99", "", "The same, 99 % of the pixels.");
    GLOBE_SHADE_POLAR_MAX = Metric::error("globe_shade_polar_max", "", "The same within 5° of a pole, largest.");
    GLOBE_SHADE_POLAR_P99 =
        Metric::error("globe_shade_polar_p99", "", "The same within 5° of a pole, 99 % of the pixels.");
    GLOBE_MADE_PX_MAX = Metric::error_px(
        "globe_made_px_max",
        "How far a vertex made on the device is from the same in f64, seen by the eye, largest.",
    );
    GLOBE_MADE_M_MAX = Metric::error("globe_made_m_max", "m", "The same in metres.");
    GLOBE_MADE_DIFFERS_PX = Metric::error_px(
        "globe_made_differs_px",
        "Pixels whose distance differs in any bit from the picture of the vertices that a compute shader made.",
    );
    GLOBE_HEIGHT_BYTES = Metric::bytes("globe_height_bytes", "Bytes of the heights that vertices are moved up by.");
}
