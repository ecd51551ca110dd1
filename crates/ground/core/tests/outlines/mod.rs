// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions by their coordinates, or from files of the data folder.

#![allow(dead_code, reason = "each test binary uses its own part of this")]

use terrafill_core::{EdgeRule, Region, parse_regions};
use terrafill_fixtures::data;

/// How an edge may run.
pub(crate) const RULES: [EdgeRule; 2] = [EdgeRule::Planar, EdgeRule::GreatEllipse];

/// A region from the coordinates of a polygon or, with one bracket more, of several.
pub(crate) fn region(coordinates: &str) -> Region {
    let kind = if coordinates.starts_with("[[[[") {
        "MultiPolygon"
    } else {
        "Polygon"
    };
    let text = format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#);
    parse_regions(text.as_bytes(), "test")
        .expect("valid")
        .remove(0)
}

/// Bytes of an outline file of the data folder.
pub(crate) fn outline(name: &str) -> Vec<u8> {
    data::bytes(&format!("vectors/{name}"))
}

/// The file's regions, split where their rings cross themselves.
pub(crate) fn repaired(name: &str, rule: EdgeRule) -> Vec<Region> {
    let mut regions = parse_regions(&outline(name), name).expect("valid");
    for region in &mut regions {
        region.split_at_crossings(rule);
    }
    regions
}
