// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a device draws volumes: where silhouettes are found, what places count from, which rule counts.

use crate::counted::{Counted, Ranges};
use crate::work::End;
use terrafill_shadow_views::{Adjacency, EyeTest, Interface, Positions, Rule};
use terrafill_variant::{ColourWay, DepthRuleChoice, FacePasses, Switches};

/// Where silhouettes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Silhouettes {
    /// By the CPU from stored adjacency: volumes are handed over.
    Adjacency,
    /// The same anew in each frame, as where light or casters move.
    EachFrame,
    /// By nobody: each lit triangle is a volume.
    EachTriangle,
    /// By the vertex shader: meshes, edges and facing bits are handed over.
    Pulled,
    /// The same without bits.
    Corners,
    /// By a compute shader, which writes indices and draw arguments.
    Computed,
    /// By a geometry shader.
    Geometry(Adjacency),
}

impl Silhouettes {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Adjacency => "adjacency",
            Self::EachFrame => "adjacency, each frame",
            Self::EachTriangle => "none, by triangle",
            Self::Pulled => "pulled",
            Self::Corners => "pulled, f32 by corners",
            Self::Computed => "compute",
            Self::Geometry(Adjacency::Triangles) => "gs-adjacency",
            Self::Geometry(Adjacency::Corners) => "gs-adjacency, f32 by corners",
            Self::Geometry(Adjacency::Lines) => "gs-line-adjacency",
        }
    }

    /// Whether a shader computes the facing in `f32`, each edge for itself.
    pub(crate) fn decides_by_corners(self) -> bool {
        matches!(self, Self::Corners | Self::Geometry(Adjacency::Corners))
    }
}

/// How a device draws volumes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DeviceWay {
    pub(crate) interface: Interface,
    pub(crate) silhouettes: Silhouettes,
    pub(crate) positions: Positions,
    pub(crate) end: End,
    pub(crate) rule: Rule,
    pub(crate) faces: FacePasses,
    pub(crate) cut: Cut,
    pub(crate) counting: Counting,
    pub(crate) bounds: Bounds,
    /// Whose depths these are.
    pub(crate) ranges: Ranges,
}

terrafill_results::named! {
    /// What is made of the rectangle round a caster's shadow, or round all casters.
    pub(crate) enum Cut {
        Off = "off",
        /// A caster is left out where its rectangle is empty.
        Culled = "casters left out",
        /// The same, and the others are cut to theirs.
        Rectangle = "caster-rect",
        /// Cut to the rectangle round all that stands above the sea.
        SeaLevel = "sea-level",
    }
}

terrafill_results::named! {
    /// Where the surface's depth must be for a fragment to count: in a range, who tests it.
    pub(crate) enum Bounds {
        Off = "off",
        /// By the device's own test.
        Native = "native",
        /// By a fragment shader that reads a copy of depth, and discards.
        Discard = "discard",
        /// By tiles of the picture, none of whose depths is in the range: the CPU leaves them out.
        Tiles = "tiles",
    }
}

/// What is counted together, and who chooses the rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Counting {
    /// All casters, by [`DeviceWay::rule`].
    Casters,
    /// All parts, z-fail for those that a test chooses and z-pass for the others.
    Chosen(EyeTest),
    /// All parts alike: by z-fail where a test chooses it for any of them.
    ByView(EyeTest),
    /// All casters by z-pass, the near plane's own count drawn beside them.
    ZpPlus,
    /// Each part for itself by [`DeviceWay::rule`], in passes of 255 or all at once.
    Parts { is_guarded: bool },
}

impl Counting {
    /// What chooses the rule of a view or of its parts.
    pub(crate) fn test(self) -> Option<EyeTest> {
        match self {
            Self::Chosen(test) | Self::ByView(test) => Some(test),
            Self::Casters | Self::ZpPlus | Self::Parts { .. } => None,
        }
    }
}

impl DeviceWay {
    /// Volumes from the CPU, closed at the sea, z-fail, two-sided, whole.
    pub(crate) fn plain(interface: Interface) -> Self {
        Self {
            interface,
            silhouettes: Silhouettes::Adjacency,
            positions: Positions::Eye,
            end: End::Sea,
            rule: Rule::Fail,
            faces: FacePasses::TwoSided,
            cut: Cut::Off,
            counting: Counting::Casters,
            bounds: Bounds::Off,
            ranges: Ranges::OfParts,
        }
    }

    /// As rows have it.
    pub(crate) fn rule_name(self) -> String {
        match self.counting {
            Counting::Chosen(test) => format!("automatic, {}", test.name()),
            Counting::ByView(test) => format!("automatic by view, {}", test.name()),
            Counting::ZpPlus => "zp-plus".to_owned(),
            Counting::Casters | Counting::Parts { .. } => self.rule.name().to_owned(),
        }
    }

    /// Whose shadow counts: the paper's scissor considers what stands above the sea alone, its range of depths what lies
    /// in it.
    pub(crate) fn counted(self) -> Counted {
        match self.cut {
            Cut::SeaLevel => Counted::AboveSea,
            Cut::Off | Cut::Culled | Cut::Rectangle => match (self.bounds, self.ranges) {
                (Bounds::Off, _) | (_, Ranges::OfParts) => Counted::All,
                (_, Ranges::One) => Counted::InRange,
            },
        }
    }

    /// As rows have it.
    pub(crate) fn bounds_name(self) -> String {
        let name = self.bounds.name().to_owned();
        match (self.counting, self.ranges) {
            _ if self.bounds == Bounds::Off => name,
            (_, Ranges::One) => name + ", one range",
            (Counting::Parts { .. }, Ranges::OfParts) => name + ", by part",
            _ => name,
        }
    }

    pub(crate) fn switches(self) -> Switches {
        Switches {
            colour: ColourWay::OneColour,
            faces: self.faces,
            depth_rule: match (self.counting, self.rule) {
                (Counting::Chosen(_) | Counting::ByView(_), _) => DepthRuleChoice::Automatic,
                (Counting::ZpPlus, _) | (_, Rule::Pass | Rule::Preload) => DepthRuleChoice::Pass,
                _ => DepthRuleChoice::Fail,
            },
            copies_depth: self.bounds == Bounds::Discard,
            scissor: matches!(self.cut, Cut::Rectangle | Cut::SeaLevel)
                || self.bounds == Bounds::Tiles,
            ..Switches::default()
        }
    }
}
