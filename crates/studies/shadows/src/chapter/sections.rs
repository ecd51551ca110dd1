// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the chapter asks, in order.

use crate::keys::{
    API, BIAS, BOXES, CASTERS, COUNTING, DEPTH_BOUNDS, EXTENT, EYE_TEST, FACES, FILL_CPU, FILL_GPU,
    LENGTH_M, LOST, MAP_WRONG, MESH, MISSED, MODEL, MODELS, MOSTLY, NEAR_M, OUTLINE, PAPER, POLICY,
    POSITIONS, RIVAL, RULE, SCISSOR, SHADOW_BAND_PX, SHADOW_BUILD_GPU_MS, SHADOW_BYTES,
    SHADOW_CASTERS_LEFT_OUT, SHADOW_CLEARS, SHADOW_CONTOUR_PX, SHADOW_DRAWS, SHADOW_EDGE_ON_PX,
    SHADOW_EYES_MISSED_AT_CORNERS, SHADOW_EYES_NEEDLESS, SHADOW_FAIL_TRIANGLES,
    SHADOW_FALSE_DARK_PX, SHADOW_FALSE_LIT_PX, SHADOW_FRAGMENTS, SHADOW_MAP_BIAS_M,
    SHADOW_MAP_CPU_MS, SHADOW_MAP_DIFFERS, SHADOW_MAP_GPU_MS, SHADOW_MAP_WRONG_IN_THREE,
    SHADOW_MAP_WRONG_UNBIASED, SHADOW_MAX_OVERLAP, SHADOW_MESH_MODELS, SHADOW_MESH_PARTS,
    SHADOW_MESH_TRIANGLES, SHADOW_NEAR_DARK, SHADOW_OPEN_EDGES, SHADOW_PX, SHADOW_RIM_PX,
    SHADOW_SIDES, SHADOW_SUN_BYTES, SHADOW_UNDECIDED_FACINGS, SHADOW_UNDECIDED_PX,
    SHADOW_VOLUME_TRIANGLES, SHADOW_VOLUMES_CPU_MS, SILHOUETTE, STEP, SUN, TEXEL_M, TIME, UPDATES,
    VIEW,
};
use terrafill_results::{Case, ConditionKey, Metric};

/// A column: its heading and its metric.
type Column = (&'static str, &'static Metric);

/// A question's section.
pub(super) struct Section {
    pub(super) question: &'static str,
    pub(super) title: &'static str,
    pub(super) text: &'static str,
    /// Conditions that name a row.
    pub(super) named_by: &'static [ConditionKey],
    pub(super) columns: &'static [Column],
}

/// What tells ways of a device apart.
pub(super) const DEVICE_KEYS: [ConditionKey; 8] = [
    SUN,
    API,
    EXTENT,
    RULE,
    FACES,
    SCISSOR,
    DEPTH_BOUNDS,
    SILHOUETTE,
];

pub(super) const SECTIONS: [Section; 20] = [
    Section {
        question: "model",
        title: "The model",
        text: "What the file holds, what keeps it from being closed, and the policy that was applied. Each part hangs \
               together; parts may touch.",
        named_by: &[MODEL],
        columns: &[
            ("triangles", SHADOW_MESH_TRIANGLES),
            ("models", SHADOW_MESH_MODELS),
            ("parts", SHADOW_MESH_PARTS),
        ],
    },
    Section {
        question: "eyes",
        title: "Which rule: the test of the eye",
        text: "400 eyes on deck, 1.7 m over it. Published: z-fail where the segment from the eye to the light \
               meets a caster. z-pass is right where the near rectangle is outside the volumes. An eye in the \
               light whose near rectangle is partly in shadow is missed.",
        named_by: &[SUN, NEAR_M, EYE_TEST],
        columns: &[
            ("missed, %", MISSED),
            ("by five samples, %", SHADOW_EYES_MISSED_AT_CORNERS),
            ("by more than half, %", MOSTLY),
            ("needless, %", SHADOW_EYES_NEEDLESS),
            ("triangles by z-fail, %", SHADOW_FAIL_TRIANGLES),
            ("near rectangle in shadow where missed, %", SHADOW_NEAR_DARK),
        ],
    },
    Section {
        question: "updates",
        title: "Volumes, rules and suns",
        text: "Volumes end at infinity, or in a plane 1 m below the curved sea for waves, or 0.2 m on a calm sea. What \
               reaches below the sea counts under z-fail, so casters are cut there too. \"Whole hulls\" are not: piles go \
               down to 12 m, hulls to 8. Stencil writes per pixel are a cost without noise.",
        named_by: &[SUN, EXTENT, RULE],
        columns: &[
            ("writes per pixel", UPDATES),
            ("triangles", SHADOW_VOLUME_TRIANGLES),
            ("largest count", SHADOW_MAX_OVERLAP),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("edge-on px", SHADOW_EDGE_ON_PX),
            ("undecided px", SHADOW_UNDECIDED_PX),
            ("shadow px", SHADOW_PX),
        ],
    },
    Section {
        question: "views",
        title: "Other eyes",
        text: "Between the legs of a crane; on deck, where a rail's shadow runs through the near rectangle; and from 250 m \
               up. Volumes are closed at the sea, and a rule is chosen for all or by a test.",
        named_by: &[SUN, VIEW, RULE],
        columns: &[
            ("writes per pixel", UPDATES),
            ("largest count", SHADOW_MAX_OVERLAP),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("edge-on px", SHADOW_EDGE_ON_PX),
            ("undecided px", SHADOW_UNDECIDED_PX),
            ("shadow px", SHADOW_PX),
        ],
    },
    Section {
        question: "scissors",
        title: "Scissors",
        text: "Three readings of \"what lies above the sea\". One is rows above the horizon, one a rectangle round each \
               caster's volume, closed at the sea. The third is the same, cut by the rectangle round everything above \
               the sea. The last leaves shadows on the sea out. z-fail, infinite volumes.",
        named_by: &[SUN, SCISSOR],
        columns: &[
            ("shadow pixels lost, %", LOST),
            ("writes per pixel", UPDATES),
            ("false dark px", SHADOW_FALSE_DARK_PX),
        ],
    },
    Section {
        question: "bounds",
        title: "Depth bounds",
        text: "A fragment writes only where the depth of what is seen lies in the range of its part's volume, closed at \
               the sea: exact under either rule. Counted as an eight-bit stencil would; \"Volumes, rules and suns\" has \
               the same without bounds. Devices that have the test are measured with it below.",
        named_by: &[SUN, RULE],
        columns: &[
            ("writes per pixel", UPDATES),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
        ],
    },
    Section {
        question: "finite",
        title: "Finite volumes",
        text: "Volumes that end after so many metres, with a dark cap, by z-fail, beside those of the section above.",
        named_by: &[SUN, LENGTH_M],
        columns: &[
            ("shadow pixels lost, %", LOST),
            ("writes per pixel", UPDATES),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
        ],
    },
    Section {
        question: "rows",
        title: "Eight bits",
        text: "Plates in a row, all of which lie before the same water. A count that is a multiple of 256 wraps to \
               0. The guard draws passes of at most 255 casters.",
        named_by: &[CASTERS, COUNTING],
        columns: &[
            ("largest count", SHADOW_MAX_OVERLAP),
            ("shadow px", SHADOW_PX),
            ("shadow pixels lost, %", LOST),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("writes per pixel", UPDATES),
        ],
    },
    Section {
        question: "casters",
        title: "Casters that are not closed",
        text: "A hull of 1,022 triangles with a tenth of its deck missing, under each policy, against the shadow of \
               the whole hull. What passes the hole meets the bottom. z-fail, volumes closed at the sea.",
        named_by: &[POLICY],
        columns: &[
            ("triangles", SHADOW_MESH_TRIANGLES),
            ("shadow px", SHADOW_PX),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("largest count", SHADOW_MAX_OVERLAP),
            ("writes per pixel", UPDATES),
        ],
    },
    Section {
        question: "outlines",
        title: "Outlines by a stencil value",
        text: "Not a shadow technique: a value S for each model instead of a clear (McGuire & Hughes, 2004). The \
               test is printed as \"stencil == S\"; inner contours are suppressed by ≠.",
        named_by: &[MODELS, OUTLINE],
        columns: &[
            ("clears", SHADOW_CLEARS),
            ("contour pixels wrong", SHADOW_CONTOUR_PX),
        ],
    },
    Section {
        question: "silhouettes",
        title: "Silhouettes on the CPU",
        text: "The published stack of borders, the same toggle by a hash, and stored adjacency with a directed \
               count. All read the same facing bits. With a face turned, two lit triangles have an edge the same \
               way round: the toggles delete it, and the volume is open.",
        named_by: &[MESH, SILHOUETTE],
        columns: &[
            ("CPU ms", TIME),
            ("triangles", SHADOW_MESH_TRIANGLES),
            ("sides", SHADOW_SIDES),
            ("open edges", SHADOW_OPEN_EDGES),
        ],
    },
    Section {
        question: "devices",
        title: "Drawn by devices",
        text: "The same volumes drawn into a stencil by the executors that fill regions. Vertices come from the CPU, sea and \
               casters are a surface, and one colour covers the screen where the count is not 0. Times are those of the \
               channel that has most shadow, all else is over all channels. Rows of one sun differ in one thing \
               from one to the next. In rows with \"pulled\" a vertex shader reads the two facing bits of each edge, \
               and what is no side collapses. With \"compute\" a compute shader writes indices and draw arguments. \
               With \"gs\" a geometry shader makes sides of triangles or of edges with adjacency. Another sun then takes \
               those bits alone, and ends of its own where volumes are closed. Depth bounds are \"native\", the device's own test. \"Discard\" is \
               a fragment shader that reads a copy of depth, whose making is timed. With \"tiles\" of 16 pixels \
               the CPU reads depths back and compares, which is timed too, and draws each caster into those \
               alone that matter to it. A range is that of a caster, or of each of its convex parts, of which more are drawn. Pixels \"at rims\" are outside the band and within a device's rounding. They lie at \
               a caster's rim, in a triangle thinner than 1/32 of a pixel, or on the boundary of one part's shadow inside the \
               shadow of others.",
        named_by: &DEVICE_KEYS,
        columns: &[
            ("CPU ms", FILL_CPU),
            ("GPU ms", FILL_GPU),
            ("fragments per pixel", SHADOW_FRAGMENTS),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("at rims", SHADOW_RIM_PX),
            ("draws", SHADOW_DRAWS),
            ("casters left out", SHADOW_CASTERS_LEFT_OUT),
            ("bytes", SHADOW_BYTES),
            ("bytes of another sun", SHADOW_SUN_BYTES),
        ],
    },
    Section {
        question: "ladder",
        title: "One optimisation after the other",
        text: "Each step is taken on top of those before, as devices draw it, in the channel with most shadow; writes of the \
               stencil and all else are over all channels. A frame finds its volumes and hands them over until they are \
               kept, so that its time is that of finding and that of drawing. What Yang & Jin (2006) say of a step stands \
               beside it: they measured none apart. A rule by part is chosen by the near rectangle, not by the eye.",
        named_by: &[SUN, API, STEP, PAPER],
        columns: &[
            ("draw, CPU ms", FILL_CPU),
            ("draw, GPU ms", FILL_GPU),
            ("find volumes, CPU ms", SHADOW_VOLUMES_CPU_MS),
            ("writes per pixel", UPDATES),
            ("fragments per pixel", SHADOW_FRAGMENTS),
            ("draws", SHADOW_DRAWS),
            ("casters left out", SHADOW_CASTERS_LEFT_OUT),
            ("bytes", SHADOW_BYTES),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("at rims", SHADOW_RIM_PX),
        ],
    },
    Section {
        question: "rivals",
        title: "Rivals that are as exact",
        text: "Tiles: each triangle that faces the sun descends into a hierarchy of tiles (Sintorn et al., 2011), by compute on \
               wgpu. Tiles have 128, 32 and 8 pixels a side, a least and a greatest depth. Rays: one from each pixel to the sun, \
               by ray queries on Vulkan, through a tree of triangles that the driver builds once for casters that rest. Both \
               are handed the depth that the surface left, in the channel with most shadow; times are from there to an \
               answer a pixel. A place 1/256 of a pixel below a triangle counts as on it. They need no closed mesh, no \
               test of the near plane and no count. Volumes stand in \"Drawn by devices\".",
        named_by: &[SUN, API, RIVAL],
        columns: &[
            ("CPU ms", FILL_CPU),
            ("GPU ms", FILL_GPU),
            ("tree, GPU ms", SHADOW_BUILD_GPU_MS),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("at rims", SHADOW_RIM_PX),
            ("shadow px", SHADOW_PX),
            ("bytes", SHADOW_BYTES),
            ("bytes of another sun", SHADOW_SUN_BYTES),
        ],
    },
    Section {
        question: "near",
        title: "A near plane in shadow, by devices",
        text: "Of 400 eyes on deck, 1 m of near plane, the one in the light whose near rectangle has most shadow. The \
               published test chooses z-pass there. zp-plus draws the lit triangles between the near plane and the sun \
               into the near plane, then z-pass; preload draws everything twice. Volumes are closed at the sea.",
        named_by: &[SUN, API, RULE],
        columns: &[
            ("CPU ms", FILL_CPU),
            ("GPU ms", FILL_GPU),
            ("fragments per pixel", SHADOW_FRAGMENTS),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("at rims", SHADOW_RIM_PX),
            ("shadow px", SHADOW_PX),
            ("draws", SHADOW_DRAWS),
        ],
    },
    Section {
        question: "device-rows",
        title: "Eight bits of a device",
        text: "The plates of \"Eight bits\", each a volume, by z-pass: counted in one pass, or in passes of 255 at most \
               that darken one after the other.",
        named_by: &[CASTERS, API, COUNTING],
        columns: &[
            ("CPU ms", FILL_CPU),
            ("GPU ms", FILL_GPU),
            ("shadow px", SHADOW_PX),
            ("shadow pixels lost, %", LOST),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("draws", SHADOW_DRAWS),
        ],
    },
    Section {
        question: "facings",
        title: "Who decides which faces the sun",
        text: "Infinite volumes by z-fail, of 96 boxes, turned so that two faces of each are exactly edge-on to the \
               sun, or at random. A facing bit is decided once a triangle, in f64, and all edges read it. Rows \"f32 by corners\" \
               have none: every edge computes the facing of its two triangles from their corners as it has them. Where \
               edges of one triangle disagree, a side is missing or one too many, and the volume leaks.",
        named_by: &[BOXES, API, SILHOUETTE],
        columns: &[
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("at rims", SHADOW_RIM_PX),
            ("undecided facings, %", SHADOW_UNDECIDED_FACINGS),
            ("bytes", SHADOW_BYTES),
            ("bytes of another sun", SHADOW_SUN_BYTES),
        ],
    },
    Section {
        question: "origins",
        title: "Far from the origin",
        text: "The volumes closed at the sea, by z-fail, with vertices from the eye as above, and as an engine has \
               them that keeps places in f32 about an origin of its own. A step of f32 is 4 mm at 100 km, 6 cm at \
               1,000 km and 25 cm at the earth's centre, here along each axis. The eye's place has the same steps. From the bridge most of \
               the port is 100 m away and more, where a pixel is tens of centimetres wide. At the quay's edge the rail is 1 m \
               away, and under a sun at 3° a step in height is twenty in its shadow. The shadow of a rail on a crane's leg is \
               seen from 70 cm, as the middle of a channel 1,024 px wide has it: a pixel is half a millimetre there.",
        named_by: &[SUN, VIEW, API, POSITIONS],
        columns: &[
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("shadow pixels lost, %", LOST),
            ("shadow px", SHADOW_PX),
        ],
    },
    Section {
        question: "maps",
        title: "Shadow maps",
        text: "One orthographic map along the light, fitted to the casters, drawn and asked on the CPU: the nearest \
               texel, no filter. The bias is the best of 13 constants from 0 to 40 m, or of 7 multiples of texel and \
               slope from 0 to 2. Faces turned away from the sun are dark without asking. With \"no normals\" they ask the map \
               too, so that a bias lights them where their caster is thinner than it. Wrong pixels are of all that the reference judges, the band included.",
        named_by: &[SUN, TEXEL_M, BIAS],
        columns: &[
            ("wrong, %", MAP_WRONG),
            ("of three channels, %", SHADOW_MAP_WRONG_IN_THREE),
            ("wrong without bias, %", SHADOW_MAP_WRONG_UNBIASED),
            ("best bias, m", SHADOW_MAP_BIAS_M),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("CPU ms", SHADOW_MAP_CPU_MS),
            ("bytes", SHADOW_BYTES),
        ],
    },
    Section {
        question: "device-maps",
        title: "Shadow maps of a device",
        text: "The same map and biases on wgpu: a depth pass from the sun, then every fragment of sea and casters in \
               the channel with most shadow asks its texel. Times are of both passes, the second draws what is seen \
               too. Maps wider than the device's textures are left out.",
        named_by: &[SUN, TEXEL_M, BIAS],
        columns: &[
            ("CPU ms", FILL_CPU),
            ("GPU ms", FILL_GPU),
            ("map alone, GPU ms", SHADOW_MAP_GPU_MS),
            ("wrong, %", MAP_WRONG),
            ("unlike the CPU's, %", SHADOW_MAP_DIFFERS),
            ("bias, m", SHADOW_MAP_BIAS_M),
            ("false lit px", SHADOW_FALSE_LIT_PX),
            ("false dark px", SHADOW_FALSE_DARK_PX),
            ("in the band", SHADOW_BAND_PX),
            ("bytes", SHADOW_BYTES),
        ],
    },
];

impl Section {
    /// A case as its row has it.
    pub(super) fn name(&self, case: &Case) -> String {
        let names: Vec<&str> = self
            .named_by
            .iter()
            .map(|key| case.condition(*key))
            // A user's model has no name of a mesh.
            .filter(|name| !name.is_empty())
            .collect();
        names.join(", ")
    }
}
