// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared API, PART, SIZE_PX, VIEW;
    BUMP_SCALE = "bump_scale", "how many times as steep the bumps are as those that preprocessing makes";
    BUMPS = "bumps", "how bumps are stored: as shares of normal, tangent and binormal, or as normals of object space";
    CELLS = "n", "cells a side, or vertices a turn";
    CONTROLLER = "controller", "what a rule holds: the radius of the spiral's fan, its outer radius, or both";
    COUNTED_BY = "counted_by", "how the device counts the pixels of each node: by a histogram, or by queries";
    DELAY = "delay", "frames until counts are back on the CPU";
    FAULT = "fault", "what is done wrong on purpose";
    HEIGHTS = "heights", "where heights are looked up";
    HOURS = "hours", "for which clouds have moved";
    HYSTERESIS = "hysteresis", "how many times the pixels at which a node merges it splits at; 1: at the same";
    KNOB = "knob", "what makes a surface finer";
    LATENCY_MS = "latency_ms", "wait that is added to reading each tile, as a network might have, milliseconds";
    LAW = "law", "how vertices stand apart along a spiral";
    LEVEL = "level", "how a tile's level is chosen";
    LIMIT = "limit", "error that is allowed, pixels";
    LOADING = "loading", "when tiles are read: beside frames, by frames that wait, or before the first";
    LOOKUP = "lookup", "how a texel is looked up";
    MERCATOR = "mercator", "where latitude becomes a place in a Web Mercator map";
    PATH = "path", "of the camera";
    PICTURES = "pictures", "which pictures the globe is shaded with";
    PROJECTION = "projection", "shape that a level of detail is drawn with";
    REMOVED = "removed", "which feature of shading is left out";
    RULE = "rule", "what decides on a radius of the spiral";
    SEAM = "seam", "how the jump of longitude at ±180° is kept out of the choice of a texel";
    SPIKE_M = "spike_m", "height of the spikes, metres";
    SPLIT_BY = "split_by", "by what triangles are split at the seam";
    STEP = "step", "what a rule changes a radius by in a frame: a share of the radius, or a gain over that from which its loop does not settle";
    SURFACE = "surface", "what draws the globe: a family and its knob";
    TILES = "tiles", "how tiles reach shaders: a draw each, an array of textures, or bindless";
    TRANSFERS = "transfers", "tiles that a frame may send";
    TRIG = "trig", "where sines and cosines are taken";
    VALUE = "value", "of the knob";
    VERTICES = "vertices", "where vertices come from: sent by the CPU, made by compute, from their number, or from one static buffer";
    WANTED = "wanted", "pixels that a triangle should have";
    WHAT = "what", "what is measured";
    "formula" = "a figure computed from parameters alone";
    "ellipsoid" = "triangles of meridians and parallels";
    "grid" = "one grid of heights";
    "screen-grid" = "a grid of the picture, thrown onto the globe";
    "snap" = "vertices outside the body are moved to its edge";
    "ring" = "a ring of vertices lies on the body's edge";
    "spiral" = "triangles along a spiral about the point below the eye";
    "exponential" = "steps of the spiral that grow by a factor";
    "quadratic" = "steps of the spiral that grow by a constant";
    "published" = "as the paper has it";
    "duplicated vertices" = "a vertex for each triangle that has it";
    "shared vertices" = "a vertex for all triangles that have it";
    "ray-cast" = "rays of the fragment shader meet the ellipsoid, without triangles of it";
    "by size" = "tiles by the share of their distance that a cell is wide";
    "U" = "the texture coordinate along longitude";
    "way" = "how the same is drawn";
    "trigonometry" = "where sines and cosines are taken";
    "looked up" = "how a texel is found";
    "spikes" = "thin mountains, which a level of detail may lose";
    "globe" = "the view of the whole globe";
    "zoom" = "a path towards the ground";
    "descent" = "the eye comes down from 3,000 km to 30 km";
    "turn" = "the eye moves along the ground at 40 km and turns by a quarter";
    "background" = "tiles are read by a thread beside frames, which show what has come";
    "foreground" = "tiles are read by the frames that want them, which wait";
    "all-there" = "tiles are read before the first frame";
    "any" = "all that are wanted";
    "latency" = "a wait that is added to reading each tile, as a network might have";
    "given up" = "requests for tiles that no frame wanted any more";
    "frames" = "frames until nothing changes any more";
    "rest" = "an eye that stands still";
    "rising" = "an eye whose height doubles each second of 60 frames";
    "closed form" = "from the view alone, without counts";
    "constant steps" = "the fan grows by a constant where it has too few pixels, and shrinks by it where it has too many";
    "logarithmic" = "the radius changes by a power of the wanted pixels over those counted";
    "trying" = "the outer radius shrinks by a share until pixels are bare, and then grows by it";
    "held" = "which radius the rule decides on; the other one is in closed form";
    "transfer" = "a tile that is sent to the device";
    "triangles" = "triangles of the surface";
    "feature" = "a part of shading, such as clouds or city lights";
    "window" = "pictures of so many pixels a side";
    "removed" = "parts of shading that are left out";
    "saved" = "share of a frame's time that is gone without it";
    "ratio" = "time with it over time without it";
    "tessellation" = "how fine the triangles are that stand for the surface";
    "make" = "work of the CPU that makes triangles";
    "upload" = "sending what changed to the device";
    "draw" = "work of the device for a frame";
    "found" = "as measured, beside what the formula says";
    "ours" = "of this run";
    "shown" = "the view, or the picture that it is shaded with";
    "off the texels" = "difference from the same texels, filtered and shaded in f64";
    "correlation" = "of frame times with numbers of triangles, -1 to 1";
    "µs a triangle" = "how much longer a frame takes for a triangle more, by least squares";
    "Student's 95 % interval" = "of a line's slope, by what its points leave over";
    "by processes" = "by a line in each process, with the interval over them";
    "frame with the most" = "the frame with the most triangles over that with the fewest, both on the line of a process";
}

/// Pixels of some sort, of which neither more nor fewer are better.
const fn pixels(name: &'static str, meaning: &'static str) -> Metric {
    Metric::neither(name, "px", Kind::Counter, meaning)
}

/// What a flight does that reads tiles meanwhile. It flies by the wall clock, so how much depends on how fast frames and
/// files are, as a time does.
const fn loading(name: &'static str, unit: &'static str, meaning: &'static str) -> Metric {
    Metric::less(name, unit, Kind::Time, meaning).covering(Scope::PLAN.and(Scope::FRAME))
}

terrafill_results::metrics! {
    GLOBE_WHOLE_CPU_MS = Metric::time_ms(
        "globe_whole_cpu_ms",
        "Process CPU time of a frame whose eye has moved: making, uploading and drawing the surface.",
    ).covering(Scope::PLAN.and(Scope::FRAME)).ranking(Primary::Cpu);
    GLOBE_WHOLE_GPU_MS = Metric::time_ms(
        "globe_whole_gpu_ms",
        "Process CPU time of making and uploading, and the GPU's time of drawing. The device's copies of what was uploaded are in neither.",
    ).covering(Scope::PLAN.and(Scope::DEVICE)).ranking(Primary::Gpu);
    GLOBE_WHOLE_WALL_MS = Metric::time_ms(
        "globe_whole_wall_ms",
        "Wall clock of making, uploading and drawing.",
    ).covering(Scope::PLAN.and(Scope::FRAME));
    GLOBE_MAKE_CPU_MS = Metric::time_ms(
        "globe_make_cpu_ms",
        "Process CPU time of making the view's triangles.",
    ).covering(Scope::PLAN);
    GLOBE_UPLOAD_CPU_MS = Metric::time_ms(
        "globe_upload_cpu_ms",
        "Process CPU time of handing them to the device, which copies them later.",
    ).covering(Scope::UPLOAD);
    GLOBE_DRAW_CPU_MS = Metric::time_ms(
        "globe_draw_cpu_ms",
        "Process CPU time of drawing them, until the device is done.",
    ).covering(Scope::DEVICE);
    GLOBE_DRAW_GPU_MS = Metric::time_ms(
        "globe_draw_gpu_ms",
        "GPU time of the pass that draws them.",
    ).covering(Scope::DEVICE);
    GLOBE_UPLOAD_BYTES = Metric::bytes(
        "globe_upload_bytes",
        "Bytes of vertices, indices and constants handed to the device for a frame.",
    );
    GLOBE_STORED_BYTES = Metric::bytes(
        "globe_stored_bytes",
        "Bytes of vertices and indices that the device keeps for all views.",
    );
    GLOBE_TRIANGLES = Metric::counter("globe_triangles", "Triangles of the view.");
    GLOBE_VERTICES = Metric::counter("globe_vertices", "Vertices of the view.");
    GLOBE_WIRES = Metric::counter("globe_wires", "Edges of the triangles that face the eye, each once.");
    GLOBE_WIRE_PX = pixels("globe_wire_px", "Pixels that the lines of edges light.");
    GLOBE_WIRE_BEYOND_PX = pixels("globe_wire_beyond_px", "Pixels that lines light and that lie more than a pixel from each of them.");
    GLOBE_WIRE_MISSING = Metric::counter("globe_wire_missing", "Lines of two pixels or more that light no pixel at their middle.");
    GLOBE_WIRE_CONTROL_PX = pixels("globe_wire_control_px", "Lit pixels that lie off every line where the picture is moved by 5 and 3 pixels: a negative control.");
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
    GLOBE_TILE_PX = pixels("globe_tile_px", "Pixels that show a texel and whose triangle holds no pole.");
    GLOBE_TILE_TEXELS_MAX = Metric::error(
        "globe_tile_texels_max",
        "texels",
        "How far outside the texel that a pixel shows its place on the triangle as drawn lies, largest; triangles that hold a pole are left out.",
    );
    GLOBE_TILE_TEXELS_P99 = Metric::error("globe_tile_texels_p99", "texels", "The same, 99 % of the pixels.");
    GLOBE_TILE_TRUE_TEXELS_MAX = Metric::error(
        "globe_tile_true_texels_max",
        "texels",
        "How far outside the texel that a pixel shows its true place on the body lies, largest.",
    );
    GLOBE_TILE_TRUE_TEXELS_P99 = Metric::error("globe_tile_true_texels_p99", "texels", "The same, 99 % of the pixels.");
    GLOBE_TILE_TRUE_TEXELS_MEDIAN =
        Metric::error("globe_tile_true_texels_median", "texels", "The same, median of the pixels.");
    GLOBE_TILE_SEAM_PX = pixels("globe_tile_seam_px", "Pixels within two of ±180°, caps of the poles left out.");
    GLOBE_TILE_SEAM_WRONG_PX = Metric::error_px(
        "globe_tile_seam_wrong_px",
        "Of them, those that show a texel off by more than ½ from their place on the triangle as drawn, or none.",
    );
    GLOBE_TILE_POLE_PX = Metric::less(
        "globe_tile_pole_px",
        "px",
        Kind::Counter,
        "Pixels in triangles that hold a pole, where longitude is no function.",
    );
    GLOBE_TILE_CAP_PX = pixels("globe_tile_cap_px", "Pixels poleward of 85.05°, shown from a stereographic cap.");
    GLOBE_TILE_MISSING_PX = Metric::error_px(
        "globe_tile_missing_px",
        "Pixels of the surface that ask for a tile that is not there.",
    );
    GLOBE_TILE_WRONG_PX = Metric::error_px(
        "globe_tile_wrong_px",
        "Pixels whose tile is at hand and that show none, or a texel too far from their place on the triangle: by more than ½ and what corners within 1/256 px explain. Pixels beside the outline are left out; at most 0.",
    );
    GLOBE_TILE_SPARE = Metric::less(
        "globe_tile_spare",
        "",
        Kind::Counter,
        "Tiles at hand of which no pixel shows a texel.",
    );
    GLOBE_CHOOSE_CPU_MS = Metric::time_ms(
        "globe_choose_cpu_ms",
        "Process CPU time of choosing a frame's tiles by what the grid's corners ask for.",
    ).covering(Scope::PLAN);
    GLOBE_LOAD_WRONG_PX = Metric::error_px(
        "globe_load_wrong_px",
        "Pixels of the judged frames that show another texel than that of the finest tile that is there, by more than rounding explains; at most 0.",
    );
    GLOBE_LOAD_JUDGED_PX = pixels("globe_load_judged_px", "Pixels of the judged frames of a flight.");
    GLOBE_LOAD_MOVING_COARSE_PX = pixels(
        "globe_load_moving_coarse_px",
        "Pixels of the judged frames whose eye moves that show a coarser level than they want.",
    );
    GLOBE_LOAD_COARSE_LAST_PX = Metric::less(
        "globe_load_coarse_last_px",
        "px",
        Kind::Counter,
        "Pixels of a flight's last frame that show a coarser level than they want: what the choice of tiles leaves out.",
    );
    GLOBE_LOAD_STEADY_BYTES = Metric::bytes(
        "globe_load_steady_bytes",
        "Bytes written at the device's queue in a flight's frames whose eye rests and which have the tiles that they choose, by whoever wrote them.",
    );
    GLOBE_LOAD_FILE_BYTES = Metric::neither(
        "globe_load_file_bytes",
        "bytes",
        Kind::Bytes,
        "Bytes of the files of all tiles of a flight.",
    );
    GLOBE_LOAD_COARSE = loading(
        "globe_load_coarse_wall_frames",
        "frames",
        "Share of a frame's pixels that show a coarser level than they want, summed over a flight's frames. Every fourth pixel of every fourth row is asked.",
    );
    GLOBE_LOAD_REST_FRAMES = loading(
        "globe_load_rest_wall_frames",
        "frames",
        "Frames after the eye has come to rest until the last tile is sent.",
    );
    GLOBE_LOAD_CANCELLED = loading(
        "globe_load_cancelled_wall_tiles",
        "tiles",
        "Requests for tiles that frames gave up, before they were read or after.",
    );
    GLOBE_LOAD_SENT_MAX = loading("globe_load_sent_max_wall_tiles", "tiles", "Tiles that a flight's frame sends, most of one.");
    GLOBE_LOAD_BYTES = loading("globe_load_wall_bytes", "bytes", "Bytes that a flight's frames send, tiles and all else.");
    GLOBE_LOAD_BYTES_MAX = loading("globe_load_max_wall_bytes", "bytes", "The same, most of a frame.");
    GLOBE_LOAD_SPIKE = loading("globe_load_spike_wall_ratio", "", "Wall clock of a flight's longest frame over that of its median frame.");
    GLOBE_LOAD_FRAME_WALL_MS = Metric::time_ms(
        "globe_load_frame_wall_ms",
        "Wall clock of a frame of a flight: making the grid, choosing, taking or reading, sending, and drawing until the device is done; median of its frames.",
    ).covering(Scope::PLAN.and(Scope::FRAME));
    GLOBE_LOAD_FRAME_MAX_WALL_MS =
        Metric::time_ms("globe_load_frame_max_wall_ms", "The same, longest.").covering(Scope::PLAN.and(Scope::FRAME));
    GLOBE_LOAD_FRAME_CPU_MS = Metric::time_ms(
        "globe_load_frame_cpu_ms",
        "Process CPU time of the same, mean of a flight's frames; what a thread that reads uses meanwhile is among it.",
    ).covering(Scope::PLAN.and(Scope::FRAME));
    GLOBE_LOAD_THREAD_CPU_MS = Metric::time_ms(
        "globe_load_thread_cpu_ms",
        "CPU time of the thread that reads tiles beside a flight's frames, between them too; none where frames read."
    ).covering(Scope::PLAN);
    GLOBE_TILE_CROSSING = Metric::quantity("globe_tile_crossing", "Triangles across ±180° that hold no pole.");
    GLOBE_TILE_MISSED = Metric::error("globe_tile_missed", "", "Of them, those that the seam's rule leaves whole.");
    GLOBE_TILE_COUNT = Metric::counter("globe_tile_count", "Tiles that a view needs, two caps among them.");
    GLOBE_TILE_DRAWS = Metric::counter("globe_tile_draws", "Draws of a frame.");
    GLOBE_TILE_BYTES = Metric::bytes("globe_tile_bytes", "Bytes of the texels of a view's tiles.");
    GLOBE_TILE_COLOUR_WRONG_PX = Metric::error_px(
        "globe_tile_colour_wrong_px",
        "Pixels that have another colour than the texel that they show.",
    );
    GLOBE_TILE_COLOUR_OFF_MEDIAN = Metric::error(
        "globe_tile_colour_off_median",
        "",
        "Difference of a pixel's colour from the whole picture at its place on the body: the largest channel's, of 255, median.",
    );
    GLOBE_TILE_COLOUR_OFF_P99 = Metric::error("globe_tile_colour_off_p99", "", "The same, 99 % of the pixels.");
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
        "Frames whose counted pixels, of the fan or of all, are others than rays see in f64 where they are no nearer to a rim than a device rounds corners; at most 0.",
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
        "Logarithm of the fan's pixels over the wanted ones, largest in the second half of the frames, over that of the first frame: above 1 the fan is farther off than it began.",
    );
    GLOBE_FAN_GROWTH_LEAST = Metric::less(
        "globe_fan_growth_least",
        "",
        Kind::Error,
        "By what factor that logarithm grows from a frame to the next while the eye rests, least of the first 8 frames, or of those before the fan is cut off: above 1 it grows exponentially.",
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
