// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the chapter asks, in order.

use crate::metrics::{LOST, MAP_WRONG, MISSED, MOSTLY, TIME, UPDATES};
use terrafill_results::Case;

/// A column: its heading and its metric.
type Column = (&'static str, &'static str);

/// A question's section.
pub(super) struct Section {
    pub(super) question: &'static str,
    pub(super) title: &'static str,
    pub(super) text: &'static str,
    /// Conditions that name a row.
    pub(super) named_by: &'static [&'static str],
    pub(super) columns: &'static [Column],
}

/// What tells ways of a device apart.
pub(super) const DEVICE_KEYS: [&str; 8] = [
    "sun",
    "api",
    "extent",
    "rule",
    "faces",
    "scissor",
    "depth_bounds",
    "silhouette",
];

pub(super) const SECTIONS: [Section; 20] = [
    Section {
        question: "model",
        title: "The model",
        text: "What the file holds, what keeps it from being closed, and the policy that was applied. Each part hangs \
               together; parts may touch.",
        named_by: &["model"],
        columns: &[
            ("triangles", "shadow_mesh_triangles"),
            ("models", "shadow_mesh_models"),
            ("parts", "shadow_mesh_parts"),
        ],
    },
    Section {
        question: "eyes",
        title: "Which rule: the test of the eye",
        text: "400 eyes on deck, 1.7 m over it. Published: z-fail where the segment from the eye to the light \
               meets a caster. z-pass is right where the near rectangle is outside the volumes. An eye in the \
               light whose near rectangle is partly in shadow is missed.",
        named_by: &["sun", "near_m", "eye_test"],
        columns: &[
            ("missed, %", MISSED),
            ("by five samples, %", "shadow_eyes_missed_at_corners"),
            ("by more than half, %", MOSTLY),
            ("needless, %", "shadow_eyes_needless"),
            ("triangles by z-fail, %", "shadow_fail_triangles"),
            (
                "near rectangle in shadow where missed, %",
                "shadow_near_dark",
            ),
        ],
    },
    Section {
        question: "updates",
        title: "Volumes, rules and suns",
        text: "Volumes end at infinity, or in a plane 1 m below the curved sea for waves, or 0.2 m on a calm sea. What \
               reaches below the sea counts under z-fail, so casters are cut there too. \"Whole hulls\" are not: piles go \
               down to 12 m, hulls to 8. Stencil writes per pixel are a cost without noise.",
        named_by: &["sun", "extent", "rule"],
        columns: &[
            ("writes per pixel", UPDATES),
            ("triangles", "shadow_volume_triangles"),
            ("largest count", "shadow_max_overlap"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("edge-on px", "shadow_edge_on_px"),
            ("undecided px", "shadow_undecided_px"),
            ("shadow px", "shadow_px"),
        ],
    },
    Section {
        question: "views",
        title: "Other eyes",
        text: "Between the legs of a crane; on deck, where a rail's shadow runs through the near rectangle; and from 250 m \
               up. Volumes are closed at the sea, and a rule is chosen for all or by a test.",
        named_by: &["sun", "view", "rule"],
        columns: &[
            ("writes per pixel", UPDATES),
            ("largest count", "shadow_max_overlap"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("edge-on px", "shadow_edge_on_px"),
            ("undecided px", "shadow_undecided_px"),
            ("shadow px", "shadow_px"),
        ],
    },
    Section {
        question: "scissors",
        title: "Scissors",
        text: "Three readings of \"what lies above the sea\". One is rows above the horizon, one a rectangle round each \
               caster's volume, closed at the sea. The third is the same, cut by the rectangle round everything above \
               the sea. The last leaves shadows on the sea out. z-fail, infinite volumes.",
        named_by: &["sun", "scissor"],
        columns: &[
            ("shadow pixels lost, %", LOST),
            ("writes per pixel", UPDATES),
            ("false dark px", "shadow_false_dark_px"),
        ],
    },
    Section {
        question: "bounds",
        title: "Depth bounds",
        text: "A fragment writes only where the depth of what is seen lies in the range of its part's volume, closed at \
               the sea: exact under either rule. Counted as an eight-bit stencil would; \"Volumes, rules and suns\" has \
               the same without bounds. Devices that have the test are measured with it below.",
        named_by: &["sun", "rule"],
        columns: &[
            ("writes per pixel", UPDATES),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
        ],
    },
    Section {
        question: "finite",
        title: "Finite volumes",
        text: "Volumes that end after so many metres, with a dark cap, by z-fail, beside those of the section above.",
        named_by: &["sun", "length_m"],
        columns: &[
            ("shadow pixels lost, %", LOST),
            ("writes per pixel", UPDATES),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
        ],
    },
    Section {
        question: "rows",
        title: "Eight bits",
        text: "Plates in a row, all of which lie before the same water. A count that is a multiple of 256 wraps to \
               0. The guard draws passes of at most 255 casters.",
        named_by: &["casters", "counting"],
        columns: &[
            ("largest count", "shadow_max_overlap"),
            ("shadow px", "shadow_px"),
            ("shadow pixels lost, %", LOST),
            ("false lit px", "shadow_false_lit_px"),
            ("writes per pixel", UPDATES),
        ],
    },
    Section {
        question: "casters",
        title: "Casters that are not closed",
        text: "A hull of 1,022 triangles with a tenth of its deck missing, under each policy, against the shadow of \
               the whole hull. What passes the hole meets the bottom. z-fail, volumes closed at the sea.",
        named_by: &["policy"],
        columns: &[
            ("triangles", "shadow_mesh_triangles"),
            ("shadow px", "shadow_px"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("largest count", "shadow_max_overlap"),
            ("writes per pixel", UPDATES),
        ],
    },
    Section {
        question: "outlines",
        title: "Outlines by a stencil value",
        text: "Not a shadow technique: a value S for each model instead of a clear (McGuire & Hughes, 2004). The \
               test is printed as \"stencil == S\"; inner contours are suppressed by ≠.",
        named_by: &["models", "outline"],
        columns: &[
            ("clears", "shadow_clears"),
            ("contour pixels wrong", "shadow_contour_px"),
        ],
    },
    Section {
        question: "silhouettes",
        title: "Silhouettes on the CPU",
        text: "The published stack of borders, the same toggle by a hash, and stored adjacency with a directed \
               count. All read the same facing bits. With a face turned, two lit triangles have an edge the same \
               way round: the toggles delete it, and the volume is open.",
        named_by: &["mesh", "silhouette"],
        columns: &[
            ("CPU ms", TIME),
            ("triangles", "shadow_mesh_triangles"),
            ("sides", "shadow_sides"),
            ("open edges", "shadow_open_edges"),
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
            ("CPU ms", "shadow_fill_cpu_ms"),
            ("GPU ms", "shadow_fill_gpu_ms"),
            ("fragments per pixel", "shadow_fragments"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("at rims", "shadow_rim_px"),
            ("draws", "shadow_draws"),
            ("casters left out", "shadow_casters_left_out"),
            ("bytes", "shadow_bytes"),
            ("bytes of another sun", "shadow_sun_bytes"),
        ],
    },
    Section {
        question: "ladder",
        title: "One optimisation after the other",
        text: "Each step is taken on top of those before, as devices draw it, in the channel with most shadow; writes of the \
               stencil and all else are over all channels. A frame finds its volumes and hands them over until they are \
               kept, so that its time is that of finding and that of drawing. What Yang & Jin (2006) say of a step stands \
               beside it: they measured none apart. A rule by part is chosen by the near rectangle, not by the eye.",
        named_by: &["sun", "api", "step", "paper"],
        columns: &[
            ("draw, CPU ms", "shadow_fill_cpu_ms"),
            ("draw, GPU ms", "shadow_fill_gpu_ms"),
            ("find volumes, CPU ms", "shadow_volumes_cpu_ms"),
            ("writes per pixel", UPDATES),
            ("fragments per pixel", "shadow_fragments"),
            ("draws", "shadow_draws"),
            ("casters left out", "shadow_casters_left_out"),
            ("bytes", "shadow_bytes"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("at rims", "shadow_rim_px"),
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
        named_by: &["sun", "api", "rival"],
        columns: &[
            ("CPU ms", "shadow_fill_cpu_ms"),
            ("GPU ms", "shadow_fill_gpu_ms"),
            ("tree, GPU ms", "shadow_build_gpu_ms"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("at rims", "shadow_rim_px"),
            ("shadow px", "shadow_px"),
            ("bytes", "shadow_bytes"),
            ("bytes of another sun", "shadow_sun_bytes"),
        ],
    },
    Section {
        question: "near",
        title: "A near plane in shadow, by devices",
        text: "Of 400 eyes on deck, 1 m of near plane, the one in the light whose near rectangle has most shadow. The \
               published test chooses z-pass there. zp-plus draws the lit triangles between the near plane and the sun \
               into the near plane, then z-pass; preload draws everything twice. Volumes are closed at the sea.",
        named_by: &["sun", "api", "rule"],
        columns: &[
            ("CPU ms", "shadow_fill_cpu_ms"),
            ("GPU ms", "shadow_fill_gpu_ms"),
            ("fragments per pixel", "shadow_fragments"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("at rims", "shadow_rim_px"),
            ("shadow px", "shadow_px"),
            ("draws", "shadow_draws"),
        ],
    },
    Section {
        question: "device-rows",
        title: "Eight bits of a device",
        text: "The plates of \"Eight bits\", each a volume, by z-pass: counted in one pass, or in passes of 255 at most \
               that darken one after the other.",
        named_by: &["casters", "api", "counting"],
        columns: &[
            ("CPU ms", "shadow_fill_cpu_ms"),
            ("GPU ms", "shadow_fill_gpu_ms"),
            ("shadow px", "shadow_px"),
            ("shadow pixels lost, %", LOST),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("draws", "shadow_draws"),
        ],
    },
    Section {
        question: "facings",
        title: "Who decides which faces the sun",
        text: "Infinite volumes by z-fail, of 96 boxes, turned so that two faces of each are exactly edge-on to the \
               sun, or at random. A facing bit is decided once a triangle, in f64, and all edges read it. Rows \"f32 by corners\" \
               have none: every edge computes the facing of its two triangles from their corners as it has them. Where \
               edges of one triangle disagree, a side is missing or one too many, and the volume leaks.",
        named_by: &["boxes", "api", "silhouette"],
        columns: &[
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("at rims", "shadow_rim_px"),
            ("undecided facings, %", "shadow_undecided_facings"),
            ("bytes", "shadow_bytes"),
            ("bytes of another sun", "shadow_sun_bytes"),
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
        named_by: &["sun", "view", "api", "positions"],
        columns: &[
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("shadow pixels lost, %", LOST),
            ("shadow px", "shadow_px"),
        ],
    },
    Section {
        question: "maps",
        title: "Shadow maps",
        text: "One orthographic map along the light, fitted to the casters, drawn and asked on the CPU: the nearest \
               texel, no filter. The bias is the best of 13 constants from 0 to 40 m, or of 7 multiples of texel and \
               slope from 0 to 2. Faces turned away from the sun are dark without asking. With \"no normals\" they ask the map \
               too, so that a bias lights them where their caster is thinner than it. Wrong pixels are of all that the reference judges, the band included.",
        named_by: &["sun", "texel_m", "bias"],
        columns: &[
            ("wrong, %", MAP_WRONG),
            ("of three channels, %", "shadow_map_wrong_in_three"),
            ("wrong without bias, %", "shadow_map_wrong_unbiased"),
            ("best bias, m", "shadow_map_bias_m"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("CPU ms", "shadow_map_cpu_ms"),
            ("bytes", "shadow_bytes"),
        ],
    },
    Section {
        question: "device-maps",
        title: "Shadow maps of a device",
        text: "The same map and biases on wgpu: a depth pass from the sun, then every fragment of sea and casters in \
               the channel with most shadow asks its texel. Times are of both passes, the second draws what is seen \
               too. Maps wider than the device's textures are left out.",
        named_by: &["sun", "texel_m", "bias"],
        columns: &[
            ("CPU ms", "shadow_fill_cpu_ms"),
            ("GPU ms", "shadow_fill_gpu_ms"),
            ("map alone, GPU ms", "shadow_map_gpu_ms"),
            ("wrong, %", MAP_WRONG),
            ("unlike the CPU's, %", "shadow_map_differs"),
            ("bias, m", "shadow_map_bias_m"),
            ("false lit px", "shadow_false_lit_px"),
            ("false dark px", "shadow_false_dark_px"),
            ("in the band", "shadow_band_px"),
            ("bytes", "shadow_bytes"),
        ],
    },
];

impl Section {
    /// A case as its row has it.
    pub(super) fn name(&self, case: &Case) -> String {
        let names: Vec<&str> = self
            .named_by
            .iter()
            .map(|key| case.condition(key))
            // A user's model has no name of a mesh.
            .filter(|name| !name.is_empty())
            .collect();
        names.join(", ")
    }
}
