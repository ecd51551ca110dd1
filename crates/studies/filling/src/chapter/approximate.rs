// SPDX-License-Identifier: MIT OR Apache-2.0
//! What one would take instead of volumes and is approximate by nature: where it is within the tolerances all the
//! same. Its times and errors are rows and open marks of each view.

use super::data::{Data, grouped, name};
use crate::keys::{HAUSDORFF_PX, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND};
use crate::purpose::is_approximate;
use terrafill_conformance::MAX_HAUSDORFF_PX;
use terrafill_results::{Block, Case};

const TEXT: &str = "What one would take instead of volumes: the region's triangles at one height (flat-mesh; the \
    “original fill” of 2007), the region cut on the CPU along the surface's triangles as drawn (draped-mesh), all \
    regions drawn into a texture over longitude and latitude, by its size (mask-texture), and every pixel tested \
    against the edges of the regions around it (edge-scan). Their pictures differ from \
    the reference by nature: they never count as right, and compete with none. Time and error of each are in the \
    tables and plots of its views.";

/// The section; nothing where no approximate fill was drawn.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let cases = data.cases.iter().copied();
    let drawn = cases.filter(|case| is_approximate(case) && case.value(MISMATCHED_PX).is_some());
    let is_within = |case: &&&Case| {
        let distance = case.value(HAUSDORFF_PX).unwrap_or(0.0);
        case.value(MISMATCHED_PX_OUTSIDE_BAND) == Some(0.0) && distance <= MAX_HAUSDORFF_PX
    };
    let fills = grouped(drawn, |case| name(case)).into_iter();
    let within = fills.map(|(fill, own)| {
        let (within, all) = (own.iter().filter(is_within).count(), own.len());
        format!(
            "{fill}: within the tolerances in {within} of {all} views, which it does not promise."
        )
    });
    let within: Vec<String> = within.collect();
    if within.is_empty() {
        Vec::new()
    } else {
        vec![
            Block::section("Volumes against approximate fills"),
            Block::Text(TEXT.to_owned()),
            Block::List(within),
        ]
    }
}
