// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions by their coordinates, or from the files of `TERRAFILL_DATA`.

#![allow(dead_code, reason = "each test binary uses its own part of this")]

use std::path::PathBuf;
use terrafill_core::{EdgeRule, Region, parse_regions};

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

/// The file's bytes; `None`, said aloud, when there is no data here.
pub(crate) fn data(name: &str) -> Option<Vec<u8>> {
    let Some(root) = std::env::var_os("TERRAFILL_DATA").map(PathBuf::from) else {
        eprintln!("skipped: TERRAFILL_DATA is not set");
        return None;
    };
    // Tests run in the crate's folder; a relative path is meant from the workspace.
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let path = workspace.join(root).join("vectors").join(name);
    match std::fs::read(&path) {
        Ok(bytes) => Some(bytes),
        Err(error) => {
            eprintln!("skipped: {}: {error}", path.display());
            None
        }
    }
}

/// The file's regions, split where their rings cross themselves.
pub(crate) fn repaired(name: &str, rule: EdgeRule) -> Option<Vec<Region>> {
    let mut regions = parse_regions(&data(name)?, name).expect("valid");
    for region in &mut regions {
        region.split_at_crossings(rule);
    }
    Some(regions)
}
