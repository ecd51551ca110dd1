// SPDX-License-Identifier: MIT OR Apache-2.0
//! The switches of a fill that every volume technique has, each with its own row in the ablation.

use crate::RouteChoice;
use crate::switch::{self, Switch, SwitchError, Values, one_of};
use terrafill_scene::Overlap;
use terrafill_texture::PositionRoute;

/// How regions get their colours. All but the one-colour ways tell regions apart, and are right to
/// the pixel where [`Switches::check`] allows them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ColourWay {
    /// All stencil work first, with a number per region, then each region's screen rectangle. For
    /// disjoint regions.
    #[default]
    Xor,
    /// One region at a time: count its volume, then cover its screen rectangle. Later regions
    /// cover earlier ones.
    Rectangle,
    /// One region at a time: count its volume, then cover by drawing the volume again.
    Volume,
    /// One stencil bit per region, as many at a time as there are bits, then their rectangles in
    /// order. Later regions cover earlier ones.
    BitPlanes,
    /// All regions counted together, then one colour over the screen wherever the count is not 0:
    /// the fill of the 2007 document. Regions are not told apart.
    OneColour,
    /// As [`ColourWay::OneColour`], the colour brought by drawing all volumes again.
    OneColourVolumes,
    /// Every volume adds its number to a float target, then one pass over the screen looks up the
    /// colours. No stencil. For disjoint regions.
    IdAccumulation,
}

impl ColourWay {
    /// Every way.
    pub const ALL: [Self; 7] = [
        Self::Xor,
        Self::Rectangle,
        Self::Volume,
        Self::BitPlanes,
        Self::OneColour,
        Self::OneColourVolumes,
        Self::IdAccumulation,
    ];

    /// Whether later regions cover earlier ones: regions are covered one by one in their order.
    #[must_use]
    pub fn keeps_order(self) -> bool {
        matches!(self, Self::Rectangle | Self::Volume | Self::BitPlanes)
    }

    /// Whether the picture tells regions apart; otherwise only the filled area is comparable.
    #[must_use]
    pub fn tells_regions_apart(self) -> bool {
        !matches!(self, Self::OneColour | Self::OneColourVolumes)
    }
}

/// Whether one draw handles both faces of a volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FacePasses {
    /// Two-sided stencil: one draw.
    #[default]
    TwoSided,
    /// Front faces in one draw, back faces in another.
    TwoPass,
}

/// Which fragments of a volume count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum DepthRuleChoice {
    /// Those behind the surface (Carmack, 2000): right wherever the eye is.
    #[default]
    Fail,
    /// Those in front of it (Heidmann, 1991): wrong for a region whose volume the near plane cuts.
    Pass,
    /// Per region: in front unless the near plane meets the region's volume.
    Automatic,
    /// Per region: in front unless the near plane cuts the volume. Of a volume around the eye it marks what lies outside.
    Uncut,
}

impl DepthRuleChoice {
    /// Whether it looks at each volume.
    #[must_use]
    pub fn follows_view(self) -> bool {
        matches!(self, Self::Automatic | Self::Uncut)
    }
}

/// When bottom caps are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum BottomCap {
    /// Always.
    #[default]
    Always,
    /// Always to mark. Colouring by drawing volumes again leaves them out, unless the near plane
    /// may meet the volume: whoever looks from outside enters it by its top or a wall.
    FirstPass,
    /// As [`BottomCap::FirstPass`], and marking draws them only where fragments behind the surface
    /// count. The bottom lies below everything drawn, so in front of the surface there is none of it.
    WhereNeeded,
}

/// What fragments of volumes do in the first pass beside marking the stencil: experiments of the 2007
/// document. All but the first cost something and show the same picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub enum FirstPass {
    /// Nothing: there is neither a colour target nor a fragment program.
    #[default]
    Stencil,
    /// They write their colour into a target of its own that nobody reads, so that the picture stays.
    Colour,
    /// A costly program, two arctangents, is bound to them, and writing colours is disabled.
    Program,
    /// The costly program, and writing its colours into the target that nobody reads: the control of
    /// [`FirstPass::Program`].
    ProgramColour,
}

impl FirstPass {
    /// Whether colours are written.
    #[must_use]
    pub fn writes_colour(self) -> bool {
        matches!(self, Self::Colour | Self::ProgramColour)
    }
}

/// What covers by triangles over the screen are cut to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum CoverArea {
    /// Their region's screen rectangle.
    #[default]
    Rectangle,
    /// Nothing: what a rectangle saves.
    Screen,
    /// Tiles that the facets of the region's cap touch, for regions with many pixels a facet of which they are fewer
    /// pixels than the rectangle. For covers that are one draw.
    Tiles,
}

/// What takes the stencil back to 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum StencilClear {
    /// A clear when the fill starts.
    #[default]
    AtStart,
    /// The colour pass, pixel by pixel; the surface pass left 0.
    ByColour,
}

/// Switches of a fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Switches {
    /// How regions get their colours.
    pub colour: ColourWay,
    /// Two-sided stencil or two draws.
    pub faces: FacePasses,
    /// Which fragments count.
    pub depth_rule: DepthRuleChoice,
    /// When bottom caps are drawn.
    pub bottom_cap: BottomCap,
    /// What fragments of volumes do in the first pass beside marking the stencil.
    pub first_pass: FirstPass,
    /// Volumes are cut to their region's screen rectangle as well, not only covers.
    pub scissor: bool,
    /// What covers by triangles over the screen are cut to.
    pub cover_area: CoverArea,
    /// What one step draws in one state is one draw: covers as instances, volumes by one index list for
    /// the view, where a layout's vertices say whose they are.
    pub merges_draws: bool,
    /// Covers by volume draw one kind of face only.
    pub cover_culls_faces: bool,
    /// On the device are the meshes that views drew, each region's at the level it was last drawn at; otherwise
    /// those of all regions at all levels.
    pub holds_drawn_meshes: bool,
    /// What takes the stencil back to 0.
    pub stencil_clear: StencilClear,
    /// So many high bits of the stencil are neither marked nor tested. A clear takes them all the same.
    pub kept_stencil_bits: u8,
    /// Every frame copies the surface's depth before it fills, as a fill must where depth cannot be read
    /// while it is attached. Nothing reads the copy: what it costs is the question.
    pub copies_depth: bool,
    /// A plain fill makes ready what a textured one holds: picture, constants and pipelines.
    pub loads_texture: bool,
    /// Regions are filled with the scene's picture, found by these routes; plain without.
    pub texture: Option<RouteChoice>,
    /// How a textured fill's fragments find their position; by way of the region's frame without.
    pub position: Option<PositionRoute>,
    /// A textured fill's fragments normalise their position, which no angle needs, as those of 2007 did.
    pub superfluous_normalize: bool,
    /// The vertex stage bends discs into the footprints of sensors' cones, for scenes that have some.
    pub bends_footprints: bool,
}

/// What every stencil buffer of today has.
const STENCIL_BITS: u8 = 8;

/// Every switch of a fill, in the order of names such as `texture-code=loaded,texture=chosen`.
const TABLE: &[Switch<Switches>] = &[
    one_of!("bottom-cap", bottom_cap: [
        "always" => BottomCap::Always,
        "first-pass" => BottomCap::FirstPass,
        "where-needed" => BottomCap::WhereNeeded,
    ], "when bottom caps are drawn; first-pass: not to colour, where-needed: nor to count in front of the surface"),
    one_of!("colour", colour: [
        "xor" => ColourWay::Xor,
        "rectangle" => ColourWay::Rectangle,
        "volume" => ColourWay::Volume,
        "bit-planes" => ColourWay::BitPlanes,
        "one-colour" => ColourWay::OneColour,
        "one-colour-volumes" => ColourWay::OneColourVolumes,
        "id-accumulation" => ColourWay::IdAccumulation,
    ], "how regions get their colours: by numbers in the stencil, one at a time, a bit each, all in one, by a float target"),
    one_of!("cover-area", cover_area: [
        "rectangle" => CoverArea::Rectangle,
        "screen" => CoverArea::Screen,
        "tiles" => CoverArea::Tiles,
    ], "what covers are cut to"),
    one_of!("cover-faces", cover_culls_faces: ["both" => false, "culled" => true],
        "which faces cover, where volumes do"),
    one_of!("depth-copy", copies_depth: ["none" => false, "made" => true],
        "copy the surface's depth in every frame, which nothing reads: what that costs"),
    one_of!("depth-rule", depth_rule: [
        "zfail" => DepthRuleChoice::Fail,
        "zpass" => DepthRuleChoice::Pass,
        "automatic" => DepthRuleChoice::Automatic,
        "uncut" => DepthRuleChoice::Uncut,
    ], "count behind the surface, in front of it, or in front for each volume that the near plane does not meet or cut"),
    one_of!("draws", merges_draws: ["each" => false, "merged" => true],
        "a draw for each region, or one for all of a state"),
    one_of!("faces", faces: ["two-sided" => FacePasses::TwoSided, "two-pass" => FacePasses::TwoPass],
        "one draw with two-sided stencil, or one for each face"),
    one_of!("first-pass", first_pass: [
        "stencil" => FirstPass::Stencil,
        "colour" => FirstPass::Colour,
        "program" => FirstPass::Program,
        "program-colour" => FirstPass::ProgramColour,
    ], "what fragments of volumes do beside marking, for nothing: experiments of 2007"),
    one_of!("held-meshes", holds_drawn_meshes: ["all" => false, "drawn" => true],
        "which meshes are on the device: all levels of all regions, or what views drew"),
    one_of!("normalize", superfluous_normalize: ["needed" => false, "superfluous" => true],
        "normalise the position of a textured fill's fragments, which no angle needs"),
    Switch {
        key: "position",
        values: Values::OneOf(&["eye-region", "eye-ecef", "inverse-ecef"]),
        meaning: "how a textured fill's fragments find their position",
        get: |of| {
            of.position
                .unwrap_or(PositionRoute::EyeRegion)
                .name()
                .to_owned()
        },
        set: |of, value| {
            let route = PositionRoute::parse(value)?;
            of.position = (route != PositionRoute::EyeRegion).then_some(route);
            Some(())
        },
    },
    one_of!("scissor", scissor: ["covers" => false, "volumes" => true],
        "what is cut to regions' screen rectangles: covers, or volumes too"),
    one_of!("stencil-bits", kept_stencil_bits: [
        "1" => 7,
        "2" => 6,
        "3" => 5,
        "4" => 4,
        "5" => 3,
        "6" => 2,
        "7" => 1,
        "8" => 0,
    ], "how many bits of the stencil are marked and tested; with fewer there are more passes, and clears take all bits"),
    one_of!("stencil-clear", stencil_clear: [
        "at-start" => StencilClear::AtStart,
        "by-colour" => StencilClear::ByColour,
    ], "what takes the stencil back to 0"),
    one_of!("texture-code", loads_texture: ["needed" => false, "loaded" => true],
        "make a textured fill's picture and pipelines ready for a plain one: what that costs"),
    Switch {
        key: "texture",
        values: Values::RouteOr(&["plain", "chosen", "floor"]),
        meaning: "fill with the scene's picture: by the route chosen for each region, by none, or by this one",
        get: |of| {
            let texture = of.texture.as_ref();
            texture.map_or_else(|| "plain".to_owned(), RouteChoice::name)
        },
        set: |of, value| {
            of.texture = match value {
                "plain" => None,
                route => Some(RouteChoice::parse(route)?),
            };
            Some(())
        },
    },
    one_of!("vertices", bends_footprints: ["stored" => false, "bent" => true],
        "bend discs into footprints of sensors in the vertex stage"),
];

impl Switches {
    /// Every switch, in alphabetical order.
    pub const TABLE: &[Switch<Self>] = TABLE;

    /// What is right and usually cheapest for a scene of this kind.
    #[must_use]
    pub fn for_overlap(overlap: Overlap) -> Self {
        Self {
            colour: match overlap {
                Overlap::Disjoint => ColourWay::Xor,
                Overlap::Ordered => ColourWay::Rectangle,
            },
            ..Self::default()
        }
    }

    /// Bits that marks may use, from the lowest on: 1 to 8.
    #[must_use]
    pub fn stencil_bits(&self) -> u8 {
        STENCIL_BITS.saturating_sub(self.kept_stencil_bits).max(1)
    }

    /// Every switch with its value, in alphabetical order.
    #[must_use]
    pub fn settings(&self) -> Vec<(&'static str, String)> {
        switch::settings(TABLE, self)
    }

    /// The value of one switch; empty of no switch.
    #[must_use]
    pub fn setting(&self, key: &str) -> String {
        let settings = self.settings().into_iter();
        let mut own = settings.filter(|(known, _)| *known == key);
        own.next().map(|(_, value)| value).unwrap_or_default()
    }

    /// `key=value` of every switch that differs from the default, in alphabetical order.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        switch::names(TABLE, self)
    }

    /// Sets the switch `key` to `value`; the inverse of [`Switches::names`], defaults included.
    ///
    /// # Errors
    /// [`SwitchError`] when the value is none of the switch's; `Ok(false)` when there is no such
    /// switch.
    pub fn set(&mut self, key: &str, value: &str) -> Result<bool, SwitchError> {
        switch::set(TABLE, self, key, value)
    }

    /// Whether the switches go together and are right for a scene of this kind.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub fn check(&self, overlap: Overlap) -> Result<(), SwitchError> {
        let refuse = |switch: &'static str, found: &str, allowed: &str| {
            Err(SwitchError {
                switch,
                found: found.to_owned(),
                allowed: allowed.to_owned(),
            })
        };
        let colour = self.setting("colour");
        let mixes = matches!(self.colour, ColourWay::Xor | ColourWay::IdAccumulation);
        if mixes && overlap == Overlap::Ordered {
            let found = format!("{colour} on a scene whose regions may overlap, where numbers mix");
            let allowed = "rectangle, volume, bit-planes, one-colour, one-colour-volumes";
            return refuse("colour", &found, allowed);
        }
        let covers_apart = matches!(self.colour, ColourWay::Xor | ColourWay::BitPlanes);
        let is_textured = self.texture.is_some();
        if is_textured && !covers_apart {
            let found = format!(
                "a picture with colour={colour}, whose covers write the stencil or hold no region"
            );
            return refuse("texture", &found, "plain, or colour=xor or bit-planes");
        }
        let shares_numbers = covers_apart || self.colour == ColourWay::IdAccumulation;
        if self.cover_area == CoverArea::Screen && shares_numbers {
            let found = format!(
                "screen with colour={colour}, whose regions share numbers or have no covers"
            );
            let allowed = "rectangle, or colour=rectangle, volume or one colour";
            return refuse("cover-area", &found, allowed);
        }
        if self.depth_rule == DepthRuleChoice::Uncut && self.colour != ColourWay::Xor {
            let found = format!(
                "uncut with colour={colour}, which cannot tell what is marked from outside"
            );
            let allowed = "zfail, zpass, automatic, or colour=xor";
            return refuse("depth-rule", &found, allowed);
        }
        let has_merged_covers = self.merges_draws && covers_apart && !is_textured;
        if self.cover_area == CoverArea::Tiles && !has_merged_covers {
            let [draws, texture] = ["draws", "texture"].map(|key| self.setting(key));
            let found = format!("tiles with colour={colour}, draws={draws}, texture={texture}");
            let allowed = "rectangle, or colour=xor or bit-planes, draws=merged and texture=plain";
            return refuse("cover-area", &found, allowed);
        }
        // Nothing may be set anew between the volumes of one draw.
        if self.merges_draws && self.scissor {
            let found = "merged with scissor=volumes, which differs from volume to volume";
            return refuse("draws", found, "each, or scissor=covers");
        }
        if self.loads_texture && is_textured {
            let found = "loaded for a textured fill, which needs it";
            return refuse("texture-code", found, "needed, or texture=plain");
        }
        if self.bends_footprints && is_textured {
            let found = "bent with a picture, whose place is that of stored vertices";
            return refuse("vertices", found, "stored, or texture=plain");
        }
        if let Some(position) = self.position.filter(|_| !is_textured) {
            let found = format!("{} for a plain fill, which looks for none", position.name());
            return refuse("position", &found, "none, or texture=chosen or a route");
        }
        if self.superfluous_normalize && !is_textured {
            let found = "superfluous for a plain fill, which looks for no position";
            return refuse("normalize", found, "needed, or texture=chosen or a route");
        }
        if self.first_pass != FirstPass::Stencil && self.colour.tells_regions_apart() {
            let found = format!(
                "{} with colour={colour}, which marks more than once or in the pass that colours",
                self.setting("first-pass")
            );
            let allowed = "stencil, or colour=one-colour or one-colour-volumes";
            return refuse("first-pass", &found, allowed);
        }
        if self.kept_stencil_bits > 0 && !covers_apart {
            let found = format!(
                "{} with colour={colour}, which counts in all bits or in none",
                self.stencil_bits()
            );
            return refuse("stencil-bits", &found, "8, or colour=xor or bit-planes");
        }
        let covers_clear = matches!(
            self.colour,
            ColourWay::OneColour | ColourWay::Rectangle | ColourWay::Volume
        );
        if self.stencil_clear == StencilClear::ByColour && !covers_clear {
            let found = format!(
                "by-colour with colour={colour}, whose covers leave pixels that no region owns"
            );
            let allowed = "at-start, or colour=one-colour, rectangle or volume";
            return refuse("stencil-clear", &found, allowed);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
