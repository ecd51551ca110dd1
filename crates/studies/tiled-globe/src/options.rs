// SPDX-License-Identifier: MIT OR Apache-2.0
//! How tiles of a map are laid over a grid on the screen.

use crate::metrics::{CELLS, LEVEL, MERCATOR, SEAM, TILES};
use terrafill_results::ConditionKey;
use terrafill_study::Depth;

/// How triangles across ±180° are kept from running back over the whole map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Seam {
    /// They are not.
    None,
    /// Split by the CPU where two corners' U differ by more than this; 0.7 as published.
    Split(f64),
    /// Each fragment takes U or its half-turned twin, whichever changes less (Tarini 2012).
    Derivative,
    /// U is counted from the eye's in `f32`, so that the seam lies behind the body.
    Rotated,
    /// U and V' are counted from the eye's texel, which is whole numbers: nothing is lost to `f32` near the eye.
    Local,
}

impl Seam {
    pub(crate) fn name(self) -> String {
        match self {
            Self::None => "none".to_owned(),
            Self::Split(limit) => format!("split-{limit}"),
            Self::Derivative => "derivative".to_owned(),
            Self::Rotated => "rotated".to_owned(),
            Self::Local => "local".to_owned(),
        }
    }

    /// Whether it is expected to leave texels beside the seam wrong.
    pub(crate) fn may_miss(self) -> bool {
        match self {
            Self::None | Self::Derivative => true,
            // Corners of a triangle that holds no pole are less than half a turn apart.
            Self::Split(limit) => limit > 0.5,
            Self::Rotated | Self::Local => false,
        }
    }
}

terrafill_results::named! {
    /// How fragments come to their tile.
    #[derive(PartialOrd, Ord)]
    pub(crate) enum Drawing {
        /// As published: the whole grid is drawn once for each tile, and fragments of other tiles are discarded.
        DrawEach = "draw-each",
        /// In one draw, from an array of all tiles.
        Array = "array",
        /// In one draw, from one picture with all tiles side by side.
        Atlas = "atlas",
        /// In one draw, from as many textures as there are tiles, chosen by each fragment.
        Bindless = "bindless",
        /// In one draw, from an array of the tiles that are there: for others their nearest ancestor.
        Slots = "slots",
    }
}

impl Drawing {
    /// Timed frames of a process, of as many as others have. A frame that draws the grid for each tile lasts
    /// ten of theirs, so it is timed three times for their five: medians of processes spread no wider.
    pub(crate) fn samples(self, others: u32) -> u32 {
        match self {
            Self::DrawEach => (3 * others).div_ceil(5),
            Self::Array | Self::Atlas | Self::Bindless | Self::Slots => others,
        }
    }
}

/// One way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Options {
    /// Cells along each side of the screen.
    pub(crate) n: u32,
    pub(crate) seam: Seam,
    pub(crate) drawing: Drawing,
    /// Whether Mercator's V' is made by each fragment, and not by each vertex.
    pub(crate) by_fragment: bool,
    /// One level for the whole frame: so many below the finest that a pixel of it asks for. `None`: by pixel.
    pub(crate) one_level: Option<u32>,
}

impl Options {
    /// What others differ from in one thing.
    pub(crate) const BASE: Self = Self {
        n: 10,
        seam: Seam::Split(0.5),
        drawing: Drawing::Array,
        by_fragment: false,
        one_level: None,
    };

    /// What tells a case from others of its view.
    pub(crate) fn conditions(&self) -> [(ConditionKey, String); 5] {
        let mercator = if self.by_fragment {
            "fragment"
        } else {
            "vertex"
        };
        [
            (CELLS, self.n.to_string()),
            (SEAM, self.seam.name()),
            (TILES, self.drawing.name().to_owned()),
            (MERCATOR, mercator.to_owned()),
            (LEVEL, self.level_name()),
        ]
    }

    /// In cases.
    pub(crate) fn level_name(&self) -> String {
        match self.one_level {
            None => "pixel".to_owned(),
            Some(0) => "frame".to_owned(),
            Some(below) => format!("frame-{below}"),
        }
    }

    /// What a view is drawn by.
    pub(crate) fn of_view(depth: Depth) -> Vec<Self> {
        let base = Self::BASE;
        let seams = [
            Seam::Split(0.5),
            Seam::None,
            Seam::Split(0.7),
            Seam::Derivative,
            Seam::Rotated,
            Seam::Local,
        ];
        let mut all: Vec<Self> = seams.map(|seam| Self { seam, ..base }).into();
        all.push(Self {
            by_fragment: true,
            ..base
        });
        all.extend(
            [Drawing::DrawEach, Drawing::Atlas, Drawing::Bindless]
                .map(|drawing| Self { drawing, ..base }),
        );
        all.push(Self {
            one_level: Some(0),
            ..base
        });
        // Other numbers of cells; the part on frames over them has more.
        let cells: &[u32] = match depth {
            Depth::Quick => &[],
            Depth::Main => &[5, 20, 40],
            Depth::Full => &[2, 5, 20, 40, 80],
        };
        all.extend(cells.iter().map(|&n| Self { n, ..base }));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_way_is_planned_twice_and_each_differs_in_what_it_says() {
        let all = Options::of_view(Depth::Full);
        for (at, one) in all.iter().enumerate() {
            assert!(!all[at + 1..].contains(one), "{one:?}");
        }
        assert_eq!(
            [1, 5, 7].map(|all| Drawing::DrawEach.samples(all)),
            [1, 3, 5]
        );
        assert_eq!([1, 5, 7].map(|all| Drawing::Atlas.samples(all)), [1, 5, 7]);
        // Negative controls: half a turn misses nothing, more does.
        assert!(Seam::Split(0.7).may_miss() && !Seam::Split(0.5).may_miss());
    }
}
