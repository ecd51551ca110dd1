// SPDX-License-Identifier: MIT OR Apache-2.0
//! A variant of the vertex backend: how geometry lies in buffers, and the switches of the fill.

use terrafill_plan::PartCulling;
use terrafill_scene::Overlap;
use terrafill_stencil::PositionFormat;
use terrafill_variant::{ColourWay, DepthRuleChoice, SwitchError, Switches, Variant};

/// Where a volume's vertices come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum Layout {
    /// Every vertex stored twice, 16 bytes each: position and a flag that sends the copy to the
    /// bottom cap. Both caps and the walls are indexed. (Here and below, positions of two floats
    /// take 12 bytes more.)
    #[default]
    Doubled,
    /// Positions stored twice, 12 bytes each; the flags lie in a buffer of their own that all
    /// regions share, long enough for the largest.
    Separate,
    /// As `doubled`, but every mesh triangle is a closed volume of its own: no silhouette, and
    /// inner walls that cancel each other. The first version of the 2007 document.
    PerTriangle,
    /// Every vertex stored once, 12 bytes; the shader works out the rest from `vertex_index`.
    Pulled,
}

impl Layout {
    /// Every layout.
    pub const ALL: [Self; 4] = [
        Self::Doubled,
        Self::Separate,
        Self::PerTriangle,
        Self::Pulled,
    ];

    /// Name in variants and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Doubled => "doubled",
            Self::Separate => "separate",
            Self::PerTriangle => "per-triangle",
            Self::Pulled => "pulled",
        }
    }

    /// Whether vertices are stored twice and indexed.
    #[must_use]
    pub(crate) fn is_doubled(self) -> bool {
        self != Self::Pulled
    }

    /// Whether walls may be strips or lists; the others have one way only.
    fn has_wall_choice(self) -> bool {
        matches!(self, Self::Doubled | Self::Separate)
    }
}

/// How walls are indexed, where the layout leaves a choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Walls {
    /// Triangle strips with restarts: 2 indices an edge.
    #[default]
    Strip,
    /// Triangle lists: 6 indices an edge.
    List,
}

/// In which order a cap's triangles lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum IndexOrder {
    /// As the mesher left them.
    #[default]
    Mesh,
    /// For a post-transform vertex cache.
    Cache,
}

/// Bytes of a stored vertex of layout `doubled`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum VertexSize {
    /// Position and flag.
    #[default]
    Bytes16,
    /// The same and 4 bytes that nothing reads, to see what size alone costs.
    Bytes20,
}

/// In which order vertices are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum VertexOrder {
    /// As the mesher left them.
    #[default]
    Mesh,
    /// As the indices first use them, for the cache before the vertex shader.
    FirstUse,
}

/// Whether the device keeps geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Buffers {
    /// Uploaded once.
    #[default]
    Kept,
    /// Vertices and indices of the regions drawn are handed over anew in every frame: the nearest to
    /// the vertex arrays of 2007, which today's interfaces do not have.
    Streamed,
}

/// Where the flagged copy of a vertex goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Bottom {
    /// To the height that the frame plan gives the region.
    #[default]
    Planned,
    /// Lower, where the vertex is far: by as many metres as [`BOTTOM_PX`] pixels are at its distance from
    /// the eye. So did the vertex shader of the 2007 document, for planets that are drawn coarser from
    /// afar.
    Pixels,
}

/// Along what a vertex is moved to its cap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Normals {
    /// The geodetic normal, which the vertex shader makes from the position.
    #[default]
    Geodetic,
    /// The same normal, stored: 12 bytes more a stored vertex, as in the meshes of the 2007 document.
    Stored,
    /// The direction from the body's centre, which takes the body for a sphere, as the 2007 document
    /// proposed so that no normals are stored. Walls then leave the geodetic ones by
    /// [`crate::centric_shift_m`].
    Centric,
}

impl Normals {
    /// Words of 4 bytes that each stored vertex has for them.
    pub(crate) fn words(self) -> usize {
        if self == Self::Stored { 3 } else { 0 }
    }
}

/// Pixels of [`Bottom::Pixels`]: the larger of the two that the 2007 document names as usual.
pub const BOTTOM_PX: f64 = 2.0;

/// A variant: how geometry is stored, and the switches of the fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct VertexVariant {
    /// Where vertices come from.
    pub layout: Layout,
    /// How positions are stored.
    pub positions: PositionFormat,
    /// How walls are indexed.
    pub walls: Walls,
    /// In which order cap triangles lie.
    pub index_order: IndexOrder,
    /// In which order vertices are stored.
    pub vertex_order: VertexOrder,
    /// Whether the device keeps them.
    pub buffers: Buffers,
    /// Where flagged vertices go.
    pub bottom: Bottom,
    /// Along what vertices are moved.
    pub normals: Normals,
    /// Bytes of a vertex.
    pub vertex_size: VertexSize,
    /// Opacity of regions in pictures for people, percent: below 100 they are blended over what
    /// lies under them, in plan order. Frames to be judged or timed are always opaque.
    pub opacity_percent: u8,
    /// Triangles of large meshes lie part by part, so that plans may leave parts out.
    pub parts: bool,
    /// What the fill does.
    pub switches: Switches,
}

impl Default for VertexVariant {
    fn default() -> Self {
        Self {
            layout: Layout::default(),
            positions: PositionFormat::default(),
            walls: Walls::default(),
            index_order: IndexOrder::default(),
            vertex_order: VertexOrder::default(),
            buffers: Buffers::default(),
            bottom: Bottom::default(),
            normals: Normals::default(),
            vertex_size: VertexSize::default(),
            opacity_percent: 100,
            parts: false,
            switches: Switches::default(),
        }
    }
}

impl VertexVariant {
    /// What `variant` says.
    ///
    /// # Errors
    /// [`SwitchError`] when it is one of another technique.
    pub fn of(variant: &Variant) -> Result<Self, SwitchError> {
        let percent = variant
            .value("opacity")
            .and_then(|value| value.parse().ok());
        Ok(Self {
            layout: variant.choice("layout", &Layout::ALL.map(|layout| (layout.name(), layout)))?,
            positions: variant.choice(
                "positions",
                &PositionFormat::ALL.map(|format| (format.name(), format)),
            )?,
            walls: variant.choice("walls", &[("strip", Walls::Strip), ("list", Walls::List)])?,
            index_order: variant.choice(
                "index-order",
                &[("mesh", IndexOrder::Mesh), ("cache", IndexOrder::Cache)],
            )?,
            vertex_order: variant.choice(
                "vertex-order",
                &[
                    ("mesh", VertexOrder::Mesh),
                    ("first-use", VertexOrder::FirstUse),
                ],
            )?,
            buffers: variant.choice(
                "buffers",
                &[("kept", Buffers::Kept), ("streamed", Buffers::Streamed)],
            )?,
            bottom: variant.choice(
                "bottom",
                &[("planned", Bottom::Planned), ("pixels", Bottom::Pixels)],
            )?,
            normals: variant.choice(
                "normals",
                &[
                    ("geodetic", Normals::Geodetic),
                    ("stored", Normals::Stored),
                    ("centric", Normals::Centric),
                ],
            )?,
            vertex_size: variant.choice(
                "vertex-bytes",
                &[("16", VertexSize::Bytes16), ("20", VertexSize::Bytes20)],
            )?,
            opacity_percent: percent.unwrap_or(100),
            parts: variant.plan.part_culling != PartCulling::Off,
            switches: variant.switches,
        })
    }

    /// Whether layout and switches go together, and with a scene of this kind.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub fn check(&self, overlap: Overlap) -> Result<(), SwitchError> {
        self.check_layout()?;
        self.check_depth_rule()?;
        self.check_opacity()?;
        self.switches.check(overlap)
    }

    /// Whether the layout has what was chosen for it.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub(crate) fn check_layout(&self) -> Result<(), SwitchError> {
        let layout = self.layout.name();
        if self.walls == Walls::List && !self.layout.has_wall_choice() {
            return Err(SwitchError {
                switch: "walls",
                found: format!("list with layout={layout}, whose walls are never strips"),
                allowed: "none, or layout=doubled or separate".to_owned(),
            });
        }
        let has_stored_flags = self.layout.is_doubled() && self.positions.words() == 3;
        if self.bottom == Bottom::Pixels && !has_stored_flags {
            return Err(SwitchError {
                switch: "bottom",
                found: format!(
                    "pixels with layout={layout} and positions={}",
                    self.positions.name()
                ),
                allowed: "planned, or a layout that stores flags and positions of 12 bytes"
                    .to_owned(),
            });
        }
        self.check_normals()?;
        self.check_draws()?;
        if self.buffers == Buffers::Streamed && self.layout == Layout::Separate {
            return Err(SwitchError {
                switch: "buffers",
                found: "streamed with layout=separate, whose flags belong to no region".to_owned(),
                allowed: "kept, or another layout".to_owned(),
            });
        }
        if self.vertex_size == VertexSize::Bytes20 && self.layout != Layout::Doubled {
            return Err(SwitchError {
                switch: "vertex-bytes",
                found: format!("20 with layout={layout}"),
                allowed: "none, or layout=doubled".to_owned(),
            });
        }
        if self.vertex_size == VertexSize::Bytes20 && self.positions.words() > 3 {
            return Err(SwitchError {
                switch: "vertex-bytes",
                found: format!("20 with positions={}", self.positions.name()),
                allowed: "none, or positions of 12 bytes".to_owned(),
            });
        }
        Ok(())
    }

    /// Whether a vertex has room for a normal.
    fn check_normals(&self) -> Result<(), SwitchError> {
        let what_else = if self.positions.words() > 3 {
            format!("positions={}", self.positions.name())
        } else if self.vertex_size == VertexSize::Bytes20 {
            "vertex-bytes=20".to_owned()
        } else {
            return Ok(());
        };
        if self.normals != Normals::Stored {
            return Ok(());
        }
        Err(SwitchError {
            switch: "normals",
            found: format!("stored with {what_else}"),
            allowed: "geodetic or centric, or positions of 12 bytes without padding".to_owned(),
        })
    }

    /// Whether volumes lie where the plan knows them to be: it allows for a share of a region's
    /// extent, and `ecef-f32` moves them by a share of the body's radius, centric normals by one of
    /// their heights.
    fn check_depth_rule(&self) -> Result<(), SwitchError> {
        let what_moves = if self.positions == PositionFormat::EcefF32 {
            "positions=ecef-f32"
        } else if self.normals == Normals::Centric {
            "normals=centric"
        } else {
            return Ok(());
        };
        if self.switches.depth_rule != DepthRuleChoice::Automatic {
            return Ok(());
        }
        Err(SwitchError {
            switch: "depth-rule",
            found: format!(
                "automatic with {what_moves}, whose volumes are not where the plan has them"
            ),
            allowed: "zfail or zpass, or other positions and normals".to_owned(),
        })
    }

    /// Whether regions may be translucent with this way of colouring.
    fn check_opacity(&self) -> Result<(), SwitchError> {
        let in_order = matches!(
            self.switches.colour,
            ColourWay::Rectangle | ColourWay::Volume | ColourWay::BitPlanes
        );
        if self.opacity_percent != 100 && self.switches.texture.is_some() {
            return Err(SwitchError {
                switch: "opacity",
                found: format!("{} for a textured fill", self.opacity_percent),
                allowed: "100: the scene says how opaque its picture is".to_owned(),
            });
        }
        if self.opacity_percent == 100 || in_order {
            return Ok(());
        }
        Err(SwitchError {
            switch: "opacity",
            found: format!(
                "{} with colour={}, which keeps no order of regions over one pixel",
                self.opacity_percent,
                self.switches.setting("colour")
            ),
            allowed: "100, or colour=rectangle, volume or bit-planes".to_owned(),
        })
    }

    /// Whether parts of regions may be drawn alone: they are ranges of the indices, and vertices are where the
    /// plan has them.
    pub(crate) fn can_draw_parts(&self) -> bool {
        self.layout != Layout::PerTriangle
            && self.vertex_order == VertexOrder::Mesh
            && self.buffers == Buffers::Kept
            && self.bottom == Bottom::Planned
            && self.normals != Normals::Centric
            && self.positions != PositionFormat::EcefF32
    }

    /// Whether the volumes of one step are one draw: those of a layout with room for the number of a mesh
    /// beside each flag. The others merge covers only.
    pub(crate) fn merges_volumes(&self) -> bool {
        self.switches.merges_draws && self.layout == Layout::Doubled
    }

    /// Whether merged draws have a shader.
    fn check_draws(&self) -> Result<(), SwitchError> {
        let found = if !self.merges_volumes() {
            return Ok(());
        } else if self.positions.words() > 3 {
            format!("positions={}", self.positions.name())
        } else if self.normals == Normals::Stored {
            "normals=stored".to_owned()
        } else if self.bottom == Bottom::Pixels {
            "bottom=pixels".to_owned()
        } else if self.buffers == Buffers::Streamed {
            "buffers=streamed".to_owned()
        } else {
            return Ok(());
        };
        Err(SwitchError {
            switch: "draws",
            found: format!("merged with {found}"),
            allowed: "each, or positions of 12 bytes, normals that are not stored, bottom=planned \
                      and buffers=kept"
                .to_owned(),
        })
    }

    /// Whether walls are drawn as strips.
    pub(crate) fn has_strips(&self) -> bool {
        self.layout.has_wall_choice() && self.walls == Walls::Strip
    }

    /// Words of 4 bytes of a stored vertex: its position, its normal where that is stored, its flag.
    pub(crate) fn vertex_words(&self) -> usize {
        let flag_and_padding = match (self.layout, self.vertex_size) {
            (Layout::Doubled, VertexSize::Bytes20) => 2,
            (Layout::Doubled | Layout::PerTriangle, _) => 1,
            (Layout::Separate | Layout::Pulled, _) => 0,
        };
        self.positions.words() + self.normals.words() + flag_and_padding
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VertexTechnique;
    use terrafill_contract::Technique as _;

    #[test]
    fn positions_refuse_what_they_cannot_have() {
        for positions in PositionFormat::ALL {
            let mut variant = VertexVariant {
                positions,
                ..VertexVariant::default()
            };
            assert!(variant.check(Overlap::Disjoint).is_ok());
            variant.switches.depth_rule = DepthRuleChoice::Automatic;
            let is_placed = variant.check(Overlap::Disjoint).is_ok();
            assert_eq!(is_placed, positions != PositionFormat::EcefF32);
            variant.switches.depth_rule = DepthRuleChoice::Fail;
            variant.vertex_size = VertexSize::Bytes20;
            let has_room = variant.check(Overlap::Disjoint).is_ok();
            assert_eq!(has_room, positions != PositionFormat::TwoFloat);
        }
    }

    #[test]
    fn normals_refuse_what_they_cannot_have() {
        for normals in [Normals::Geodetic, Normals::Stored, Normals::Centric] {
            let plain = VertexVariant {
                normals,
                ..VertexVariant::default()
            };
            let is_allowed = |change: fn(&mut VertexVariant)| {
                let mut variant = plain;
                change(&mut variant);
                variant.check(Overlap::Disjoint).is_ok()
            };
            assert!(is_allowed(|_| ()));
            assert!(is_allowed(|v| v.positions = PositionFormat::EcefF32));
            let has_room = normals != Normals::Stored;
            assert_eq!(
                is_allowed(|v| v.positions = PositionFormat::TwoFloat),
                has_room
            );
            assert_eq!(
                is_allowed(|v| v.vertex_size = VertexSize::Bytes20),
                has_room
            );
            let is_placed = normals != Normals::Centric;
            let automatic =
                |v: &mut VertexVariant| v.switches.depth_rule = DepthRuleChoice::Automatic;
            assert_eq!(is_allowed(automatic), is_placed);
        }
    }

    #[test]
    fn merged_draws_refuse_vertices_that_they_have_no_shader_for() {
        let merged = VertexTechnique.main(Overlap::Disjoint);
        let merged = merged.with_switches(|switches| switches.merges_draws = true);
        let check = |variant: &Variant| {
            let read = VertexVariant::of(variant).expect("known names");
            read.check(Overlap::Disjoint)
        };
        assert_eq!(check(&merged), Ok(()));
        for (key, value) in [
            ("positions", "two-float"),
            ("normals", "stored"),
            ("bottom", "pixels"),
            ("buffers", "streamed"),
        ] {
            let wrong = merged.clone().with(key, value);
            let error = check(&wrong).expect_err(value);
            assert_eq!(error.switch, "draws");
            assert!(
                error.to_string().contains(&format!("{key}={value}")),
                "{error}"
            );
            // Negative control: drawn one by one it is allowed.
            let each = wrong.with_switches(|switches| switches.merges_draws = false);
            assert_eq!(check(&each), Ok(()));
        }
        for layout in Layout::ALL {
            assert_eq!(check(&merged.clone().with("layout", layout.name())), Ok(()));
        }
    }

    #[test]
    fn what_does_not_go_together_is_refused() {
        let check = |key: &str, layout: Layout, colour: ColourWay| {
            let (key, value) = key.split_once('=').expect("key=value");
            let variant = VertexTechnique.main(Overlap::Disjoint);
            let variant = variant.with("layout", layout.name()).with(key, value);
            let variant = variant.with_switches(|switches| switches.colour = colour);
            let variant = VertexVariant::of(&variant).expect("known names");
            variant.check(Overlap::Disjoint).is_ok()
        };
        for layout in Layout::ALL {
            let choice = matches!(layout, Layout::Doubled | Layout::Separate);
            assert_eq!(check("walls=list", layout, ColourWay::Xor), choice);
            let padded = layout == Layout::Doubled;
            assert_eq!(check("vertex-bytes=20", layout, ColourWay::Xor), padded);
        }
        for colour in ColourWay::ALL {
            let in_order = [
                ColourWay::Rectangle,
                ColourWay::Volume,
                ColourWay::BitPlanes,
            ];
            let expected = in_order.contains(&colour);
            assert_eq!(check("opacity=50", Layout::Doubled, colour), expected);
            assert!(check("opacity=100", Layout::Doubled, colour));
        }
    }
}
