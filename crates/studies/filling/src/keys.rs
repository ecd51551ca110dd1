// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and metrics: constants by which results are written and read.

pub(crate) use crate::metrics::*;

terrafill_results::conditions! {
    shared SCENE, VIEW, TECHNIQUE, VARIANT;
    APPROXIMATE = "approximate";
    ASIDE = "aside";
    BOUNDARY_LOD_PX = "boundary-lod-px";
    CAP_STEP = "cap-step-deg";
    LAYOUT = "layout";
    NEEDS_RUNG = "needs-rung";
    NEEDS_STEP = "needs-step";
    NORMALIZE = "normalize";
    NORMALS = "normals";
    PICTURE = "picture";
    POSITION = "position";
    POSITIONS = "positions";
    REGIONS = "regions";
    ROLE = "role";
    RUNG = "rung";
    STEP = "step";
    TEXTURE = "texture";
    TOLERANCE_M = "boundary-tolerance-m";
}
