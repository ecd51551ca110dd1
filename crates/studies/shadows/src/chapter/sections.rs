// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the chapter asks, in order.

use super::plots::{
    device_map_plot, elevation_deg, finite_plot, mesh_kind, whole_triangles, writes,
};
use crate::metrics::*;
use terrafill_lab::{Column, Drawing, Figure, Names, Panel, Section, Select, measured};
use terrafill_plot::Upwards;
use terrafill_results::{Case, ConditionKey, Metric};

const fn column(heading: &'static str, metric: &'static Metric) -> Column {
    Column::metric(heading, metric).or("there is none")
}

const MESH_SIZE: Column = column("triangles", SHADOW_MESH_TRIANGLES);
const WRITES: Column = column("writes per pixel", UPDATES);
const TRIANGLES: Column = column("triangles", SHADOW_VOLUME_TRIANGLES);
const MAX_COUNT: Column = column("largest count", SHADOW_MAX_OVERLAP);
const LIT_PX: Column = column("false lit px", SHADOW_FALSE_LIT_PX);
const DARK_PX: Column = column("false dark px", SHADOW_FALSE_DARK_PX);
const BAND_PX: Column = column("in the band", SHADOW_BAND_PX);
const EDGE_ON: Column = column("edge-on px", SHADOW_EDGE_ON_PX);
const UNDECIDED: Column = column("undecided px", SHADOW_UNDECIDED_PX);
const SHADE_PX: Column = column("shadow px", SHADOW_PX);
const LOST_SHARE: Column = column("shadow pixels lost, %", LOST);
const FIND_MS: Column = column("CPU ms", TIME);
const REACHED: Column = column("px in reach", SHADOW_REACHED_PX);
const SIDES: Column = column("sides", SHADOW_SIDES);
const OPEN_EDGES: Column = column("open edges", SHADOW_OPEN_EDGES);
const CPU_MS: Column = column("CPU ms", FILL_CPU);
const GPU_MS: Column = column("GPU ms", FILL_GPU);
const FRAME_MS: Column = column("frame, wall ms", FRAME_WALL);
const FRAME_CPU_MS: Column = column("frame, CPU ms", FRAME_CPU);
const FRAME_GPU_MS: Column = column("frame, GPU ms", FRAME_GPU);
const PLANNED_MS: Column = column("CPU first, CPU ms", SHADOW_PLANNED_CPU_MS);
const WHOLE_CPU_MS: Column = column("whole, CPU ms", WHOLE_CPU);
const WHOLE_WALL_MS: Column = column("whole, wall ms", WHOLE_WALL);
const RIM_PX: Column = column("at rims", SHADOW_RIM_PX);
const DRAWS: Column = column("draws", SHADOW_DRAWS);
const LEFT_OUT: Column = column("casters left out", SHADOW_CASTERS_LEFT_OUT);
const BYTES: Column = column("bytes", SHADOW_BYTES);
const SUN_BYTES: Column = column("bytes of another sun", SHADOW_SUN_BYTES);
const VOLUMES_MS: Column = column("find volumes, CPU ms", SHADOW_VOLUMES_CPU_MS);
const TREE_MS: Column = column("tree, GPU ms", SHADOW_BUILD_GPU_MS);
const SPLIT: Column = column("undecided facings, %", SHADOW_UNDECIDED_FACINGS);
const WRONG: Column = column("wrong, %", MAP_WRONG);
const IN_THREE: Column = column("of three channels, %", SHADOW_MAP_WRONG_IN_THREE);
const UNBIASED: Column = column("wrong without bias, %", SHADOW_MAP_WRONG_UNBIASED);
const BIAS_M: Column = column("best bias, m", SHADOW_MAP_BIAS_M);
const MAP_MS: Column = column("CPU ms", SHADOW_MAP_CPU_MS);
const MAP_GPU_MS: Column = column("map alone, GPU ms", SHADOW_MAP_GPU_MS);
const DIFFERS: Column = column("unlike the CPU's, %", SHADOW_MAP_DIFFERS);
pub(super) const FRAGMENTS: Column = Column::of("fragments per pixel", Figure::Computed(fragments))
    .meaning(SHADOW_FRAGMENTS.meaning)
    .or_of(uncounted);

/// Fragments of volumes per pixel; none where a device says 0 and has pixels in shadow, as older runs of one do.
fn fragments(case: &Case) -> Option<f64> {
    let counted = measured(case, SHADOW_FRAGMENTS)?;
    let is_bare = measured(case, SHADOW_PX) == Some(0.0);
    (counted > 0.0 || is_bare).then_some(counted)
}

fn uncounted(case: &Case) -> &str {
    match case.note(MISCOUNTED) {
        "" if measured(case, SHADOW_FRAGMENTS).is_some() => {
            "the device's query has 0, and every pixel in shadow takes a fragment"
        }
        "" => "not counted by the device",
        why => why,
    }
}

/// What tells ways of a device apart.
pub(super) const DEVICE_KEYS: [ConditionKey; 9] = [
    SUN,
    VIEW,
    API,
    EXTENT,
    RULE,
    FACES,
    SCISSOR,
    DEPTH_BOUNDS,
    SILHOUETTE,
];

/// Notes with paths of pictures, and what each shows.
const PICTURES: [(&str, &str); 3] = [
    ("reference_image", "reference"),
    ("image", "as drawn, wrong pixels red"),
    ("exact_image", "near rectangle tested"),
];

const fn section(
    [question, title]: [&'static str; 2],
    text: &'static str,
    named_by: &'static [ConditionKey],
    columns: &'static [Column],
) -> Section<'static> {
    Section {
        title,
        text,
        cases: Select::With(QUESTION, question),
        named_by: Names::Joined(named_by),
        columns,
        is_main: true,
        shows_what_is_wrong: true,
        pictures: &PICTURES,
        ..Section::EMPTY
    }
}

pub(super) const SECTIONS: [Section<'static>; 24] = [
    Section {
        pictures: &[("map", "by day"), ("image", "as drawn, wrong pixels red")],
        ..section(
            ["harbour", "One frame of all seven channels, by day"],
            "The port in pictures for people, with the shadows that a device drew with every optimisation but depth bounds. \
                 \"Bridge\" is one strip of all seven channels over 270°, \"aerial\" looks down. A frame is surface, \
                 volumes and cover of every channel, one after the other, the port as it is and its volumes kept. The paper has \
                 35 frames a second, 28.6 ms, and needs 24, 41.7 ms; it names no size, so that \"size px\" is a condition: of \
                 each channel, 512 × 384 unless a run names another. Every pixel of every channel \
                 is held against rays at that size. In shadow a face keeps 60 % of its light; the paper does not say how much.",
            &[SUN, VIEW, API, SIZE_PX],
            &[
                FRAME_MS,
                FRAME_CPU_MS,
                FRAME_GPU_MS,
                LIT_PX,
                DARK_PX,
                BAND_PX,
                RIM_PX,
                SHADE_PX,
            ],
        )
    },
    section(
        ["fits", "What fits a frame"],
        "The same frame of seven channels from the bridge in several sizes, each held against rays. Rows \"port-m10\" have ten \
             times the casters, each port with cranes, ships and containers of its own. Which of them are drawn within 28.6 ms \
             and 41.7 ms a frame is said on the first page.",
        &[API, MESH, SIZE_PX],
        &[
            FRAME_MS,
            FRAME_CPU_MS,
            FRAME_GPU_MS,
            LIT_PX,
            DARK_PX,
            BAND_PX,
            RIM_PX,
        ],
    ),
    section(
        ["model", "The model"],
        "A model from a file over the sea, its middle at the origin, seen from four sides, above its top. What the file holds, what keeps it from being closed, and the policy that was applied. Each part hangs \
             together; parts may touch.",
        &[MODEL],
        &[
            column("triangles", SHADOW_MESH_TRIANGLES),
            column("models", SHADOW_MESH_MODELS),
            column("parts", SHADOW_MESH_PARTS),
        ],
    ),
    Section {
        drawing: Some(Drawing {
            caption: "Eyes missed against the near plane; tests of the near rectangle miss none.",
            panels: &[Panel {
                across: ("near plane, m", Figure::Condition(NEAR_M)),
                up: ("eyes missed, %", Figure::Metric(MISSED)),
                upwards: Upwards::Error,
                curve: Names::Joined(&[EYE_TEST, SUN]),
                knob: Figure::Condition(NEAR_M),
                ..Panel::EMPTY
            }],
        }),
        ..section(
            ["eyes", "Which rule: the test of the eye"],
            "400 eyes on deck, 1.7 m over it. Published: z-fail where the segment from the eye to the light \
                 meets a caster. z-pass is right where the near rectangle is outside the volumes. An eye in the \
                 light whose near rectangle is partly in shadow is missed.",
            &[SUN, NEAR_M, EYE_TEST],
            &[
                column("missed, %", MISSED),
                column("by five samples, %", SHADOW_EYES_MISSED_AT_CORNERS),
                column("by more than half, %", MOSTLY),
                column("needless, %", SHADOW_EYES_NEEDLESS),
                column("triangles by z-fail, %", SHADOW_FAIL_TRIANGLES),
                column("near rectangle in shadow where missed, %", SHADOW_NEAR_DARK),
            ],
        )
    },
    Section {
        drawing: Some(Drawing {
            caption: "Writes per pixel against the sun's elevation; suns differ in azimuth, see the table.",
            panels: &[Panel {
                across: ("sun's elevation, degrees", Figure::Computed(elevation_deg)),
                up: ("stencil writes per pixel", Figure::Computed(writes)),
                curve: Names::Joined(&[RULE, EXTENT]),
                knob: Figure::Computed(elevation_deg),
                ..Panel::EMPTY
            }],
        }),
        ..section(
            ["updates", "Volumes, rules and suns"],
            "Volumes end at infinity, or in a plane 1 m below the curved sea for waves, or 0.2 m on a calm sea. What \
                 reaches below the sea counts under z-fail, so casters are cut there too. \"Whole hulls\" are not: piles go \
                 down to 12 m, hulls to 8. Stencil writes per pixel are a cost without noise.",
            &[SUN, EXTENT, RULE],
            &[
                WRITES, TRIANGLES, MAX_COUNT, LIT_PX, DARK_PX, BAND_PX, EDGE_ON, UNDECIDED,
                SHADE_PX,
            ],
        )
    },
    section(
        ["views", "Other eyes"],
        "Between the legs of a crane; on deck, where a rail's shadow runs through the near rectangle; and from 300 m \
             up, looking down by 31°, without a horizon. Volumes are closed at the sea, and a rule is chosen for all or by a test.",
        &[SUN, VIEW, RULE],
        &[
            WRITES, MAX_COUNT, LIT_PX, DARK_PX, BAND_PX, EDGE_ON, UNDECIDED, SHADE_PX,
        ],
    ),
    Section {
        shows_what_is_wrong: false,
        ..section(
            ["scissors", "Scissors"],
            "The paper considers shadows above sea level alone, and cuts to the range that is drawn there. \"sea-level\" is \
                 that rectangle, round all that stands above the sea; \"caster-rect\" is one round each caster's volume, closed \
                 at the sea, and \"receiver-rect\" what both have. Rows above the horizon are not what the paper says, and cut \
                 the dock. Each is judged by all pixels, and by those above the sea alone. z-fail, infinite volumes.",
            &[SUN, SCISSOR, COUNTED],
            &[LOST_SHARE, WRITES, LIT_PX, DARK_PX, SHADE_PX],
        )
    },
    section(
        ["bounds", "Depth bounds"],
        "A fragment writes only where the depth of what is seen lies in a range. \"On\" is that of its part's volume, closed at \
             the sea: exact under either rule. The paper names a range of interest, and its figure 6 drops a shadowed point \
             beyond it. \"One range\" is such a one: from the nearest to the farthest that the channel shows above the sea, \
             judged by all pixels, and by those in the range alone. Counted as an eight-bit stencil would; \"Volumes, rules and suns\" has \
             the same without bounds. Devices that have the test are measured with it below.",
        &[SUN, RULE, DEPTH_BOUNDS, COUNTED],
        &[WRITES, LOST_SHARE, LIT_PX, DARK_PX, BAND_PX],
    ),
    Section {
        more: &[finite_plot],
        ..section(
            ["finite", "Finite volumes"],
            "Volumes that end after so many metres, with a dark cap, by z-fail, beside those of the section above.",
            &[SUN, LENGTH_M],
            &[LOST_SHARE, WRITES, LIT_PX, DARK_PX],
        )
    },
    section(
        ["rows", "Eight bits"],
        "Plates in a row, all of which lie before the same water. A count that is a multiple of 256 wraps to \
             0. The guard draws passes of at most 255 casters.",
        &[CASTERS, COUNTING],
        &[MAX_COUNT, SHADE_PX, LOST_SHARE, LIT_PX, WRITES],
    ),
    section(
        ["casters", "Casters that are not closed"],
        "A hull of 1,022 triangles with a tenth of its deck missing, under each policy, against the shadow of \
             the whole hull. What passes the hole meets the bottom. z-fail, volumes closed at the sea.",
        &[POLICY],
        &[MESH_SIZE, SHADE_PX, LIT_PX, DARK_PX, MAX_COUNT, WRITES],
    ),
    terrafill_outlines::SECTION,
    Section {
        drawing: Some(Drawing {
            caption: "Time of a silhouette against triangles. Ports are boxes; hulls are smooth and have fewer sides.",
            panels: &[Panel {
                across: (
                    "triangles of the casters",
                    Figure::Computed(whole_triangles),
                ),
                up: ("process CPU ms: median, 5–95 %", Figure::Metric(TIME)),
                curve: Names::Of("", mesh_kind),
                knob: Figure::Metric(SHADOW_MESH_TRIANGLES),
                ..Panel::EMPTY
            }],
        }),
        ..section(
            ["silhouettes", "Silhouettes on the CPU"],
            "The published stack of borders, the same toggle by a hash, and stored adjacency with a directed \
                 count. All read the same facing bits. With a face turned, two lit triangles have an edge the same \
                 way round: the toggles delete it, and the volume is open.",
            &[MESH, SILHOUETTE],
            &[FIND_MS, MESH_SIZE, SIDES, OPEN_EDGES],
        )
    },
    section(
        ["devices", "Drawn by devices"],
        "The same volumes drawn into a stencil by the executors that fill regions. Vertices come from the CPU, sea and \
             casters are a surface, and one colour covers the screen where the count is not 0. Times are those of a \
             frame of all channels, as all else; rows \"aerial\" look down from 300 m instead. \"Whole\" times have in them what \
             the CPU does first in each frame: choose rules, or with \"each frame\" find all volumes and hand them over, once for \
             all channels. \"Automatic\" rules are chosen for each caster or part, or \"by view\", by the published segment or by \
             what lies between near plane and sun. \"sea-level\" cuts to the rectangle round all that stands above the sea, and \
             is judged there. Rows of one sun differ in one thing \
             from one to the next. In rows with \"pulled\" a vertex shader reads the two facing bits of each edge, \
             and what is no side collapses. With \"compute\" a compute shader writes indices and draw arguments. \
             With \"gs\" a geometry shader makes sides of triangles or of edges with adjacency. Another sun then takes \
             those bits alone, and ends of its own where volumes are closed. Depth bounds are \"native\", the device's own test. \"Discard\" is \
             a fragment shader that reads a copy of depth, whose making is timed. With \"tiles\" of 16 pixels \
             the CPU reads depths back and compares, which is timed too, and draws each caster into those \
             alone that matter to it. A range is that of a caster, or of each of its convex parts, of which more are drawn. \
             \"One range\" is the paper's, of all that stands in a channel above the sea, and judged within it. Pixels \"at rims\" are outside the band and within a device's rounding. They lie at \
             a caster's rim, in a triangle thinner than 1/32 of a pixel, or on the boundary of one part's shadow inside the \
             shadow of others.",
        &DEVICE_KEYS,
        &[
            CPU_MS,
            GPU_MS,
            PLANNED_MS,
            WHOLE_CPU_MS,
            WHOLE_WALL_MS,
            FRAGMENTS,
            LIT_PX,
            DARK_PX,
            BAND_PX,
            RIM_PX,
            DRAWS,
            LEFT_OUT,
            BYTES,
            SUN_BYTES,
        ],
    ),
    section(
        ["ladder", "One optimisation after the other"],
        "Each step is taken on top of those before, as devices draw it, in all channels. A frame finds its volumes and hands them over until they are \
             kept, so that its time is that of finding and that of drawing. What Yang & Jin (2006) say of a step stands \
             beside it: they measured none apart. A rule by part is chosen by the near rectangle, not by the eye.",
        &[SUN, API, STEP, PAPER],
        &[
            CPU_MS, GPU_MS, VOLUMES_MS, WRITES, FRAGMENTS, DRAWS, LEFT_OUT, BYTES, LIT_PX, DARK_PX,
            BAND_PX, RIM_PX,
        ],
    ),
    section(
        ["rivals", "Rivals that are as exact"],
        "Tiles: each triangle that faces the sun descends into a hierarchy of tiles (Sintorn et al., 2011), by compute on \
             wgpu. Tiles have 128, 32 and 8 pixels a side, a least and a greatest depth. Rays: one from each pixel to the sun, \
             by ray queries on Vulkan, through a tree of triangles that the driver builds once for casters that rest. Both \
             are handed the depth that the surface left, channel by channel; times are from there to an \
             answer a pixel. A place 1/256 of a pixel below a triangle counts as on it. They need no closed mesh, no \
             test of the near plane and no count. Volumes stand in \"Drawn by devices\".",
        &[SUN, VIEW, API, RIVAL],
        &[
            CPU_MS, GPU_MS, TREE_MS, LIT_PX, DARK_PX, BAND_PX, RIM_PX, SHADE_PX, BYTES, SUN_BYTES,
        ],
    ),
    section(
        ["near", "A near plane in shadow, by devices"],
        "Of 400 eyes on deck, 1 m of near plane, the one in the light whose near rectangle has most shadow. The \
             published test chooses z-pass there. zp-plus draws the lit triangles between the near plane and the sun \
             into the near plane, then z-pass; preload draws everything twice. Volumes are closed at the sea.",
        &[SUN, API, RULE],
        &[
            CPU_MS, GPU_MS, FRAGMENTS, LIT_PX, DARK_PX, BAND_PX, RIM_PX, SHADE_PX, DRAWS,
        ],
    ),
    section(
        ["device-rows", "Eight bits of a device"],
        "The plates of \"Eight bits\", each a volume, by z-pass: counted in one pass, or in passes of 255 at most \
             that darken one after the other.",
        &[CASTERS, API, COUNTING],
        &[CPU_MS, GPU_MS, SHADE_PX, LOST_SHARE, LIT_PX, DARK_PX, DRAWS],
    ),
    section(
        ["facings", "Who decides which faces the sun"],
        "Infinite volumes by z-fail, of 96 boxes, turned so that two faces of each are exactly edge-on to the \
             sun, or at random. A facing bit is decided once a triangle, in f64, and all edges read it. Rows \"f32 by corners\" \
             have none: every edge computes the facing of its two triangles from their corners as it has them. Where \
             edges of one triangle disagree, a side is missing or one too many, and the volume leaks.",
        &[BOXES, API, SILHOUETTE],
        &[LIT_PX, DARK_PX, BAND_PX, RIM_PX, SPLIT, BYTES, SUN_BYTES],
    ),
    section(
        ["origins", "Far from the origin"],
        "The volumes closed at the sea, by z-fail, with vertices from the eye as above, and as an engine has \
             them that keeps places in f32 about an origin of its own. A step of f32 is 4 mm at 100 km, 6 cm at \
             1,000 km and 25 cm at the earth's centre, here along each axis. The eye's place has the same steps. From the bridge most of \
             the port is 100 m away and more, where a pixel is tens of centimetres wide. At the quay's edge the rail is 1 m \
             away, and under a sun at 3° a step in height is twenty in its shadow. The shadow of a rail on a crane's leg is \
             seen from 70 cm, as the middle of a channel 1,024 px wide has it: a pixel is half a millimetre there.",
        &[SUN, VIEW, API, POSITIONS],
        &[LIT_PX, DARK_PX, BAND_PX, LOST_SHARE, SHADE_PX],
    ),
    Section {
        drawing: Some(Drawing {
            caption: "Wrong pixels against bytes, texel in m beside the points; volumes have none outside the band.",
            panels: &[Panel {
                across: ("bytes of the map", Figure::Metric(SHADOW_BYTES)),
                up: ("wrong pixels, %", Figure::Metric(MAP_WRONG)),
                upwards: Upwards::Error,
                curve: Names::Joined(&[SUN, BIAS]),
                knob: Figure::Condition(TEXEL_M),
                label: Some(Names::Joined(&[TEXEL_M])),
                ..Panel::EMPTY
            }],
        }),
        ..section(
            ["maps", "Shadow maps"],
            "One orthographic map along the light, fitted to the casters, drawn and asked on the CPU: the nearest \
                 texel, no filter. The bias is the best of 13 constants from 0 to 40 m, or of 7 multiples of texel and \
                 slope from 0 to 2. Faces turned away from the sun are dark without asking. With \"no normals\" they ask the map \
                 too, so that a bias lights them where their caster is thinner than it. Wrong pixels are of all that the reference judges, the band included.",
            &[SUN, TEXEL_M, BIAS],
            &[
                WRONG, IN_THREE, UNBIASED, BIAS_M, LIT_PX, DARK_PX, BAND_PX, MAP_MS, BYTES,
            ],
        )
    },
    Section {
        more: &[device_map_plot],
        ..section(
            ["device-maps", "Shadow maps of a device"],
            "The same map and biases on wgpu: a depth pass from the sun, once a frame, then every fragment of sea and casters in \
                 all channels asks its texel. Times are of all of it; what asks draws what is seen \
                 too. A bias is one comparison: one of them is timed. Maps wider than the device's textures are left out.",
            &[SUN, TEXEL_M, BIAS],
            &[
                CPU_MS, GPU_MS, MAP_GPU_MS, WRONG, DIFFERS, BIAS_M, LIT_PX, DARK_PX, BAND_PX, BYTES,
            ],
        )
    },
    Section {
        shows_what_is_wrong: false,
        ..section(
            ["lights", "Lights other than the sun"],
            "The port by night. The moon is a light like the sun: judged in all channels of the bridge, its volumes end below the sea. \
                 A lamp is judged in the channel of the bridge that has it in view. A volume's sides run away from \
                 the lamp, and its dark cap lies at infinity or beyond the lamp's range. Rays end at the lamp; what lies beyond its range \
                 or beside its beam is unlit by itself, and not judged. The paper names deck light, searchlight and lights on \
                 shore, and limits the range of illumination by the sea level alone. Here the limit is the lamp's own reach, \
                 one way at a time, against volumes without end. Ends with corners at the range cut through its sphere; \
                 they and a scissor of half the reach must lose pixels.",
            &[LIGHT, RULE, LIMIT],
            &[
                WRITES, TRIANGLES, LOST_SHARE, LIT_PX, DARK_PX, BAND_PX, REACHED, SHADE_PX,
                UNDECIDED,
            ],
        )
    },
    Section {
        pictures: &[("map", "by night"), ("image", "as drawn, wrong pixels red")],
        ..section(
            ["device-lights", "The same by devices"],
            "Volumes from the CPU, drawn into a stencil. From the bridge every limit is drawn and timed against volumes without one. z-pass is wrong where the eye is in shadow, as under the sun. \
                 Under the moon they end below the sea, and from the bridge all seven channels are drawn. Pictures by night show it far \
                 brighter than it is.",
            &[LIGHT, VIEW, API, RULE, LIMIT],
            &[
                CPU_MS, GPU_MS, LIT_PX, DARK_PX, BAND_PX, RIM_PX, REACHED, SHADE_PX, TRIANGLES,
                DRAWS, FRAGMENTS,
            ],
        )
    },
];
