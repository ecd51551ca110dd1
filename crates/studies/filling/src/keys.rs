// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics: constants by which results are written and read.

pub(crate) use crate::metrics::*;

terrafill_results::conditions! {
    shared SCENE, VIEW, TECHNIQUE, VARIANT;
    APPROXIMATE = "approximate";
    ASIDE = "aside";
    BOUNDARY_LOD_PX = "boundary-lod-px";
    CAP_STEP = "cap-step-deg", "how far apart inner vertices of a cap may lie, degrees";
    LAYOUT = "layout";
    NEEDS_RUNG = "needs-rung", "number of a step towards what a view needs";
    NEEDS_STEP = "needs-step", "name of a step towards what a view needs";
    NORMALIZE = "normalize";
    NORMALS = "normals";
    PICTURE = "picture", "what a textured fill shows: the picture of the scene, or one that tells texels apart";
    POSITION = "position";
    POSITIONS = "positions";
    REGIONS = "regions", "how many regions of the scene are drawn";
    ROLE = "role";
    RUNG = "rung";
    STEP = "step";
    TEXTURE = "texture";
    TOLERANCE_M = "boundary-tolerance-m";
    "full-screen" = "of passes: every pixel of the picture is touched once";
    "recommended" = "of the fastest fill and its ties, the one with the fewest bytes of geometry";
    "fastest" = "of the fills that are right and timed, the one with the least time";
    "smallest" = "of the fills that are right, the one with the fewest bytes of geometry";
    "most exact" = "the fill with the least boundary distance, then the fewest mismatched pixels";
    "moved" = "of a name: levels of detail move no boundary by more pixels than it says; rounding to pixels comes on top";
    "plain" = "a fill in colours, not with a picture";
    "chosen" = "the route that the scene's bounds of error allow at the least cost";
    "route" = "formulas from a pixel's position to its place in the picture";
    "feature" = "something that a frame may hold, set or draw, and that a view may do without";
    "built in" = "the frame or the program that makes it";
    "region, mean" = "bytes of one region, on average";
    "needs" = "what is left once everything goes that changes no pixel of the view";
    "boundary deviation" = "how far the drawn boundary lies from the true one, metres";
    "geometry shader" = "the stage that makes primitives of primitives, here walls of edges";
    "degenerate triangles" = "triangles with two equal corners, each of which is an edge of a boundary";
    "lines" = "edges of boundaries as line strips";
    "stencil-tested fragments" = "fragments that are tested against the stencil";
    "to prepare" = "what happens once, before the first frame";
}
