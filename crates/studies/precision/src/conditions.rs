// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases.

terrafill_results::conditions! {
    shared PART;
    ANCHOR = "anchor";
    CONDITION = "condition";
    DEPTH_FORMAT = "depth_format";
    DISTANCE_M = "distance_m";
    EXTENT_DEG = "extent_deg";
    FAMILY = "family";
    HIGHEST_M = "highest_m";
    KNOB = "knob";
    LATITUDE_DEG = "latitude_deg";
    LOWEST_M = "lowest_m";
    OF_PART = "of_part";
    ROUTE = "route";
}
