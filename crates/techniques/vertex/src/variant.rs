// SPDX-License-Identifier: MIT OR Apache-2.0
//! A variant of the vertex backend: how geometry lies in buffers, and the switches of the fill.

use terrafill_fill::{ColourWay, DepthRuleChoice, PositionFormat, SwitchError, Switches, pick};
use terrafill_scene::Overlap;

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
    /// Bytes of a vertex.
    pub vertex_size: VertexSize,
    /// Opacity of regions in pictures for people, percent: below 100 they are blended over what
    /// lies under them, in plan order. Frames to be judged or timed are always opaque.
    pub opacity_percent: u8,
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
            vertex_size: VertexSize::default(),
            opacity_percent: 100,
            switches: Switches::default(),
        }
    }
}

impl VertexVariant {
    /// Every key of its own that [`VertexVariant::set`] takes, with its values; the others are
    /// [`Switches::KEYS`].
    pub const KEYS: &str = "layout=doubled|separate|per-triangle|pulled, \
        positions=fixed|local-f32|ecef-f32|two-float, walls=strip|list, index-order=mesh|cache, vertex-bytes=16|20, \
        opacity=1…100";

    /// Layout first, then what differs from the default, `key=value`, in alphabetical order.
    #[must_use]
    pub fn name(&self) -> String {
        let mut names = self.switches.names();
        if self.positions != PositionFormat::default() {
            names.push(format!("positions={}", self.positions.name()));
        }
        if self.walls == Walls::List {
            names.push("walls=list".to_owned());
        }
        if self.index_order == IndexOrder::Cache {
            names.push("index-order=cache".to_owned());
        }
        if self.vertex_size == VertexSize::Bytes20 {
            names.push("vertex-bytes=20".to_owned());
        }
        if self.opacity_percent != 100 {
            names.push(format!("opacity={}", self.opacity_percent));
        }
        names.sort_unstable();
        names.insert(0, self.layout.name().to_owned());
        names.join(",")
    }

    /// Sets the switch `key` to `value`; with `layout=` the inverse of [`VertexVariant::name`].
    ///
    /// # Errors
    /// [`SwitchError`] when the value is none of the switch's; `Ok(false)` when there is no such
    /// switch.
    pub fn set(&mut self, key: &str, value: &str) -> Result<bool, SwitchError> {
        match key {
            "layout" => {
                let layouts = Layout::ALL.map(|layout| (layout.name(), layout));
                self.layout = pick("layout", value, &layouts)?;
            }
            "positions" => {
                let formats = PositionFormat::ALL.map(|format| (format.name(), format));
                self.positions = pick("positions", value, &formats)?;
            }
            "walls" => {
                let walls = [("strip", Walls::Strip), ("list", Walls::List)];
                self.walls = pick("walls", value, &walls)?;
            }
            "index-order" => {
                let orders = [("mesh", IndexOrder::Mesh), ("cache", IndexOrder::Cache)];
                self.index_order = pick("index-order", value, &orders)?;
            }
            "vertex-bytes" => {
                let sizes = [("16", VertexSize::Bytes16), ("20", VertexSize::Bytes20)];
                self.vertex_size = pick("vertex-bytes", value, &sizes)?;
            }
            "opacity" => {
                let percent = value.parse().ok().filter(|p| (1..=100).contains(p));
                self.opacity_percent = percent.ok_or_else(|| SwitchError {
                    switch: "opacity",
                    found: value.to_owned(),
                    allowed: "whole percent, 1 to 100".to_owned(),
                })?;
            }
            _ => return self.switches.set(key, value),
        }
        Ok(true)
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

    /// Whether volumes lie where the plan knows them to be: it allows for a share of a region's
    /// extent, and `ecef-f32` moves them by a share of the body's radius.
    fn check_depth_rule(&self) -> Result<(), SwitchError> {
        let is_known = self.positions != PositionFormat::EcefF32;
        if is_known || self.switches.depth_rule != DepthRuleChoice::Automatic {
            return Ok(());
        }
        Err(SwitchError {
            switch: "depth-rule",
            found:
                "automatic with positions=ecef-f32, whose volumes are not where the plan has them"
                    .to_owned(),
            allowed: "zfail or zpass, or other positions".to_owned(),
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
                self.switches.colour.name()
            ),
            allowed: "100, or colour=rectangle, volume or bit-planes".to_owned(),
        })
    }

    /// Whether walls are drawn as strips.
    pub(crate) fn has_strips(&self) -> bool {
        self.layout.has_wall_choice() && self.walls == Walls::Strip
    }

    /// Words of 4 bytes of a stored vertex.
    pub(crate) fn vertex_words(&self) -> usize {
        let flag_and_padding = match (self.layout, self.vertex_size) {
            (Layout::Doubled, VertexSize::Bytes20) => 2,
            (Layout::Doubled | Layout::PerTriangle, _) => 1,
            (Layout::Separate | Layout::Pulled, _) => 0,
        };
        self.positions.words() + flag_and_padding
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_can_be_set_again() {
        let variant = VertexVariant {
            layout: Layout::Doubled,
            positions: PositionFormat::LocalF32,
            walls: Walls::List,
            index_order: IndexOrder::Cache,
            vertex_size: VertexSize::Bytes20,
            opacity_percent: 40,
            switches: Switches::for_overlap(Overlap::Ordered),
        };
        let name = variant.name();
        let mut read = VertexVariant::default();
        let mut parts = name.split(',');
        assert_eq!(read.set("layout", parts.next().expect("layout")), Ok(true));
        let keys: Vec<&str> = parts.collect();
        assert!(keys.is_sorted() && keys.len() == 6, "{keys:?}");
        for key in keys {
            let (key, value) = key.split_once('=').expect("key=value");
            assert_eq!(read.set(key, value), Ok(true), "{key}");
            let key = format!("{key}=");
            let is_known = |keys: &str| keys.contains(&key);
            assert!(
                is_known(VertexVariant::KEYS) != is_known(Switches::KEYS),
                "{key}"
            );
        }
        assert_eq!(read, variant);
        assert!(variant.check(Overlap::Ordered).is_ok());
    }

    #[test]
    fn every_position_format_has_a_name_that_can_be_set_again() {
        for positions in PositionFormat::ALL {
            let variant = VertexVariant {
                positions,
                ..VertexVariant::default()
            };
            let name = variant.name();
            assert!(VertexVariant::KEYS.contains(positions.name()));
            let mut read = VertexVariant::default();
            assert_eq!(read.set("positions", positions.name()), Ok(true));
            assert_eq!(read, variant);
            let said = name == format!("doubled,positions={}", positions.name());
            assert_eq!(said, positions != PositionFormat::Fixed, "{name}");
            assert_eq!(variant.vertex_words(), positions.words() + 1);
        }
    }

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
    fn unknown_keys_and_values_are_told_apart() {
        let mut variant = VertexVariant::default();
        assert_eq!(variant.set("wall", "list"), Ok(false));
        for (key, value) in [
            ("walls", "fan"),
            ("index-order", "random"),
            ("vertex-bytes", "12"),
            ("opacity", "0"),
            ("opacity", "101"),
            ("layout", "tripled"),
            ("colour", "red"),
        ] {
            let error = variant.set(key, value).expect_err("no such value");
            assert!(error.to_string().contains(value), "{error}");
        }
        assert_eq!(variant, VertexVariant::default());
    }

    #[test]
    fn what_does_not_go_together_is_refused() {
        let check = |key: &str, layout: Layout, colour: ColourWay| {
            let mut variant = VertexVariant {
                layout,
                ..VertexVariant::default()
            };
            variant.switches.colour = colour;
            let (key, value) = key.split_once('=').expect("key=value");
            assert_eq!(variant.set(key, value), Ok(true));
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
