// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a loop of level of detail by counted pixels did, frame by frame.

use super::scene::{ByRays, NodeVertices};
use std::collections::BTreeMap;
use terrafill_globe_views::{Eye, fingerprint};
use terrafill_lab::Cases;
use terrafill_maps::Node;
use terrafill_plot::Courses;
use terrafill_results::{Block, Case, ChapterError};
use terrafill_study::Figures;

/// What a loop did.
#[derive(Debug, Clone, Default)]
pub(crate) struct Course {
    /// Leaves of a tree or triangles of zones, frame by frame.
    pub(crate) sizes: Vec<f64>,
    /// The last frame in which anything changed.
    pub(crate) last_change: Option<usize>,
    /// The first frame and the last one.
    pub(crate) ends: Vec<CountedFrame>,
}

/// What was drawn in a frame, and its counts.
#[derive(Debug, Clone)]
pub(crate) struct CountedFrame {
    pub(crate) eye: Eye,
    pub(crate) drawn: NodeVertices,
    pub(crate) counts: BTreeMap<Node, u64>,
}

impl Course {
    /// Largest difference of counts from rays, nodes off by more than their edges, and nodes compared.
    pub(crate) fn against_rays(&self) -> (u64, usize, usize) {
        let frames = self.ends.iter();
        frames.fold((0, 0, 0), |(so_far, so_wrong, compared), frame| {
            let rays = ByRays::new(&frame.eye, &frame.drawn);
            let (largest, wrong) = rays.against(&frame.counts);
            let nodes = compared + frame.drawn.nodes.len();
            (so_far.max(largest), so_wrong + wrong, nodes)
        })
    }

    /// Of all that is judged.
    pub(crate) fn hash(&self) -> String {
        let counts = self.ends.iter().flat_map(|frame| frame.counts.values());
        let counts: Vec<u64> = counts.copied().collect();
        let places = self.ends.iter().flat_map(|frame| &frame.drawn.vertices_rte);
        let places: Vec<[f32; 3]> = places.copied().collect();
        let sizes = bytemuck::cast_slice(&self.sizes);
        fingerprint(&[
            sizes,
            bytemuck::cast_slice(&counts),
            bytemuck::cast_slice(&places),
        ])
    }

    /// Frames after which nothing changes; `None` where changes go on to the end.
    ///
    /// - `delay`: frames from drawing to using a count
    pub(crate) fn settled(&self, delay: usize) -> Option<usize> {
        let last = self.last_change.map_or(0, |frame| frame + 1);
        // A change may still come from a count that is on its way.
        (last + 2 * delay + 2 <= self.sizes.len()).then_some(last)
    }

    /// Whether a loop whose eye stands still cycles, and when it settles.
    pub(crate) fn rest(&self, delay: usize) -> Figures {
        let settled = self.settled(delay);
        let mut figures = vec![("globe_count_cycles", f64::from(u8::from(settled.is_none())))];
        figures.extend(settled.map(|frames| ("globe_count_settle_frames", frames as f64)));
        figures
    }

    /// Counts against rays, and why they are wrong; empty where they are not.
    pub(crate) fn exactness(&self) -> (Figures, String) {
        let (largest, wrong, compared) = self.against_rays();
        let figures = vec![
            ("globe_count_off_px", largest as f64),
            ("globe_count_wrong_nodes", wrong as f64),
            ("globe_count_nodes", compared as f64),
        ];
        let reason = match wrong {
            0 => String::new(),
            wrong => format!(
                "{wrong} of {compared} nodes are off by more pixels than they have at their edges, allowed 0"
            ),
        };
        (figures, reason)
    }

    /// Sizes as a case's note keeps them.
    pub(crate) fn note(&self) -> String {
        let sizes: Vec<String> = self.sizes.iter().map(f64::to_string).collect();
        sizes.join(" ")
    }
}

/// Sizes frame by frame, a panel a case; `None` where there is none.
///
/// - `note`: the case's note with its sizes
pub(crate) fn drawing(
    cases: &Cases<'_>,
    caption: &str,
    note: &str,
    name: impl Fn(&Case) -> String,
) -> Result<Option<Block>, ChapterError> {
    let panels = cases.iter().map(|case| terrafill_plot::Course {
        name: name(case),
        values: case
            .note(note)
            .split(' ')
            .filter_map(|value| value.parse().ok())
            .collect(),
        wanted: None,
    });
    let courses = Courses {
        title: caption.to_owned(),
        across: "frames",
        panels: panels.collect(),
    };
    Ok(Block::plot(caption, courses.draw()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_that_changes_to_the_end_has_not_settled() {
        let course = |last_change| Course {
            sizes: vec![4.0; 48],
            last_change,
            ..Course::default()
        };
        assert_eq!(course(None).settled(1), Some(0));
        assert_eq!(course(Some(9)).settled(1), Some(10));
        // Negative controls: at the end, and just before it.
        assert_eq!(course(Some(47)).settled(1), None);
        assert_eq!(course(Some(44)).settled(3), None);
    }
}
