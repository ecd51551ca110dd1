// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

use terrafill_results::{Kind, Metric, Primary, Scope};

terrafill_results::conditions! {
    shared API, PART, SIZE_PX, VIEW;
    DEPTH = "depth", "whether data is drawn behind the depth of the body itself, lifted by a thousandth of the eye's height";
    DIVISION = "division", "cells along a side, or segments: a number, or the rule that finds it";
    EXTENT = "extent", "how large the data is";
    ORIGIN = "origin", "what vertices are about: the data's corner, or the body's centre";
    PATH = "path", "how a line runs";
    PLACE = "location", "where on the globe the data lies: about the paper's campus, unless said";
    PROJECTION = "projection", "how the body is put on the picture";
    SERIES = "series", "order of the series that stand for sine and cosine";
    "data" = "what lies on the globe: a decal, or a line";
    "formula" = "as many cells as keep edges within a quarter of a pixel, by a bound of the second derivative";
    "query" = "twice as many in each frame, until precise occlusion queries count no more pixels";
    "elsewhere" = "as counted pixels find it obliquely, drawn from above";
    "campus" = "0.04° of latitude: some 4.4 km, in texels of 4 m; the paper's picture has a foot or two";
    "city" = "0.5° of latitude";
    "country" = "8° of latitude";
    "continent" = "40° of latitude";
    "pole" = "its upper edge is the north pole";
    "date-line" = "across ±180° of longitude";
    "nadir" = "from straight above its middle";
    "oblique" = "from the south, at an angle";
    "limb" = "so far from the south that it ends beyond the horizon, or near it";
    "close" = "from 150 m above its middle";
    "corner" = "the data's lower left corner, or its start";
    "centre" = "the body's centre: longitude and latitude themselves";
    "tested" = "behind the depth of the body itself";
    "globe" = "in perspective";
    "flat" = "longitude and latitude";
    "hyperbolic" = "longitude and latitude about the place below the eye, drawn in towards a rim";
    "dome" = "by the angle from straight ahead, of half a turn";
    "great-circle" = "the shortest way";
    "parallel" = "along a parallel: a rhumb line, straight in longitude and latitude";
    "decal" = "a picture of data over a part of the body, alone where it is";
    "line" = "a line over the body, two pixels wide";
    "cells" = "quads of two triangles, as many a side; segments of a line";
    "hidden" = "share of its pixels that the body's depth hides";
    "extra" = "pixels that show data where the exact projection has none";
    "missing" = "pixels that show none where the exact projection has data";
    "counted" = "samples that a precise query counts";
}

terrafill_results::metrics! {
    DECAL_CPU_MS = Metric::time_ms(
        "decal_cpu_ms",
        "Process CPU time of a frame: sending constants, recording, drawing, and waiting for the device.",
    ).covering(Scope::FRAME).ranking(Primary::Cpu);
    DECAL_WALL_MS = Metric::time_ms("decal_wall_ms", "Wall clock over the same span.").covering(Scope::FRAME);
    DECAL_GPU_MS = Metric::time_ms("decal_gpu_ms", "GPU time of the pass that draws the data.")
        .covering(Scope::DEVICE)
        .ranking(Primary::Gpu);
    DECAL_DIVIDE_CPU_MS = Metric::time_ms(
        "decal_divide_cpu_ms",
        "Process CPU time of finding the number of cells: of the formula, or of every frame that counts. Such a frame uploads \
         its vertices, draws, waits and reads the count; what was found is uploaded last.",
    )
    .covering(Scope::PLAN.and(Scope::FRAME))
    .or("the number of cells is known before");
    DECAL_DIVIDE_WALL_MS = Metric::time_ms("decal_divide_wall_ms", "Wall clock over the same span.")
        .covering(Scope::PLAN.and(Scope::FRAME))
        .or("the number of cells is known before");
    DECAL_MISMATCHED_PX = Metric::error_px(
        "decal_mismatched_px",
        "Pixels that show another texel, or part of a line, than the triangles as drawn allow in f64, outside of the band \
         of 1/32 pixel.",
    );
    DECAL_BAND_PX = Metric::neither(
        "decal_band_px",
        "px",
        Kind::Error,
        "Pixels that differ from what f64 finds at their centre, and show what lies within 1/32 pixel of it.",
    );
    DECAL_SHOWN_PX = Metric::neither("decal_shown_px", "px", Kind::DriverCounter, "Pixels that show the data.");
    DECAL_PX_MAX = Metric::error_px(
        "decal_px_max",
        "From a pixel's centre to where what it shows belongs by the exact projection: the place of a decal's address, or the \
         edge of a line at the part that it shows. Where depth is not tested, also how far within the exact decal a pixel \
         without it is, a hundredth of the picture at most, or how far beside the shown line. Largest.",
    )
    .or("nothing of it is seen");
    DECAL_MAX_MIL = Metric::error(
        "decal_max_mil",
        "‰",
        "The same as a share of the picture's side, which does not depend on its size. In Table 1 of Gebbie and Bailey, whose \
         window is 1000 × 1000, 1 ‰ is a pixel.",
    )
    .or("nothing of it is seen");
    DECAL_PX_P99 = Metric::error_px("decal_px_p99", "The same, 99 % of the pixels.").or("nothing of it is seen");
    DECAL_PX_MEDIAN = Metric::error_px("decal_px_median", "The same, median of the pixels.").or("nothing of it is seen");
    DECAL_EXTRA_PX = Metric::error_px(
        "decal_extra_px",
        "Pixels that show the data where the exact projection has none of it.",
    );
    DECAL_MISSING_PX = Metric::error_px(
        "decal_missing_px",
        "Pixels that show none of the data where the exact projection has it.",
    );
    DECAL_VERTEX_PX = Metric::error_px(
        "decal_vertex_px",
        "Of vertices that are seen, largest distance of where the device's f32 places them from their exact place, of which \
         nothing is rounded. A compute shader places them by the functions that the vertex stage has.",
    )
    .or("vertices are read back where their origin is compared, and one is seen");
    DECAL_HIDDEN_SHARE = Metric::error(
        "decal_hidden_share",
        "",
        "Share of the data's pixels that the body's depth hides, though data is lifted by a thousandth of the eye's height. \
         Pixels shown are held against those of the same triangles in f64 without the body.",
    )
    .or("depth is not tested");
    DECAL_CELLS = Metric::counter("decal_cells", "Cells along a side of the decal, or segments of the line.");
    DECAL_TRIANGLES = Metric::counter("decal_triangles", "Triangles of the data.");
    DECAL_SENT_BYTES = Metric::bytes("decal_sent_bytes", "Bytes of vertices that are sent before the frame, of all levels that are counted.");
    DECAL_FRAME_BYTES = Metric::bytes("decal_frame_bytes", "Bytes of constants that are sent in each frame.");
    DECAL_FRAMES = Metric::counter("decal_frames", "Frames until counted pixels stop the division.")
        .or("the number of cells is known before");
    DECAL_COUNTED_PX = Metric::neither(
        "decal_counted_px",
        "px",
        Kind::DriverCounter,
        "Samples of the data that a precise occlusion query counts in the last of these frames.",
    )
    .or("nothing is counted");
    DECAL_MISCOUNTED_PX = Metric::error_px(
        "decal_miscounted_px",
        "By how many that number lies outside of the pixels that f64 says: from those that show data all over the band \
         about their centre to those that may.",
    )
    .or("nothing is counted");
}
