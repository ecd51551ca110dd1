// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a view holds and leaves out, worked out: sums of what the backend's parts hold, and reasons.
//!
//! Bytes and pipelines are those that the backend's parts hold ([`Holding`]); nothing here assumes them. So
//! their sums can be held against what the device was asked to make ([`Needs::undeclared`]).

use crate::uses::{Uses, length};
use crate::{DepthRule, HeldMeshes, NUMBER_BYTES, VolumeState};
use terrafill_contract::{Feature, FillInput, MemoryUse, Need, Needs, WorkDone};
use terrafill_plan::LeftOutReason;
use terrafill_scene::{Overlap, TextureShare};
use terrafill_variant::{DepthRuleChoice, Switches};

/// Bytes of a pixel of depth and stencil: 32 bits and 8.
pub const DEPTH_STENCIL_BYTES: u64 = 5;
/// Bytes of a pixel of the colour target.
pub const COLOUR_BYTES: u64 = 4;
/// Bits of a pixel's stencil.
const STENCIL_BITS: u32 = 8;

/// What one part of a backend holds for one feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Holding {
    /// What for.
    pub feature: Feature,
    /// Buffers and textures.
    pub memory: MemoryUse,
    /// Pipelines.
    pub pipelines: u64,
    /// Bytes that the feature would take beside these.
    pub spared_bytes: u64,
}

impl Holding {
    /// Nothing yet.
    #[must_use]
    pub fn of(feature: Feature) -> Self {
        Self {
            feature,
            memory: MemoryUse::default(),
            pipelines: 0,
            spared_bytes: 0,
        }
    }

    /// Buffers and textures.
    #[must_use]
    pub fn memory(feature: Feature, memory: MemoryUse) -> Self {
        Self {
            memory,
            ..Self::of(feature)
        }
    }

    /// One buffer of constants.
    ///
    /// - `written_bytes`: what of the buffer's bytes holds constants
    #[must_use]
    pub fn constants(feature: Feature, written_bytes: u64, buffer_bytes: u64) -> Self {
        let memory = MemoryUse {
            constant_bytes: written_bytes,
            ..in_buffers(written_bytes, &[buffer_bytes])
        };
        Self::memory(feature, memory)
    }

    /// Buffers of vertices.
    ///
    /// - `buffers`: bytes of each
    #[must_use]
    pub fn vertices(feature: Feature, vertex_bytes: u64, buffers: &[u64]) -> Self {
        let memory = MemoryUse {
            vertex_bytes,
            ..in_buffers(vertex_bytes, buffers)
        };
        Self::memory(feature, memory)
    }

    /// Buffers of indices.
    ///
    /// - `buffers`: bytes of each
    #[must_use]
    pub fn indices(feature: Feature, index_bytes: u64, buffers: &[u64]) -> Self {
        let memory = MemoryUse {
            index_bytes,
            ..in_buffers(index_bytes, buffers)
        };
        Self::memory(feature, memory)
    }

    /// Textures that are read.
    #[must_use]
    pub fn textures(feature: Feature, texture_bytes: u64) -> Self {
        let memory = MemoryUse {
            texture_bytes,
            ..MemoryUse::default()
        };
        Self::memory(feature, memory)
    }

    /// A target that is drawn or copied into.
    #[must_use]
    pub fn target(feature: Feature, target_bytes: u64) -> Self {
        let memory = MemoryUse {
            target_bytes,
            ..MemoryUse::default()
        };
        Self::memory(feature, memory)
    }

    /// A pipeline each; those of one feature are added up.
    pub fn pipelines(features: impl IntoIterator<Item = Feature>) -> impl Iterator<Item = Self> {
        let one = |feature| Self {
            pipelines: 1,
            ..Self::of(feature)
        };
        features.into_iter().map(one)
    }
}

/// Buffers, and what they have beyond what is written into them.
fn in_buffers(written_bytes: u64, buffers: &[u64]) -> MemoryUse {
    MemoryUse {
        padding_bytes: buffers.iter().sum::<u64>().saturating_sub(written_bytes),
        buffers: buffers.len() as u64,
        ..MemoryUse::default()
    }
}

/// Bytes of indices by what they are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct IndexBytes {
    /// Top caps.
    pub top_caps: u64,
    /// Bottom caps.
    pub bottom_caps: u64,
    /// Walls.
    pub walls: u64,
    /// Bottom caps that are not stored.
    pub spared: u64,
}

impl IndexBytes {
    /// Caps and walls that share buffers; what these have beyond them is the top caps'.
    ///
    /// - `buffers`: bytes of each
    #[must_use]
    pub fn holdings(self, buffers: &[u64]) -> [Holding; 3] {
        let written_bytes = self.top_caps + self.bottom_caps + self.walls;
        let tops = MemoryUse {
            index_bytes: self.top_caps,
            ..in_buffers(written_bytes, buffers)
        };
        [
            Holding::memory(Feature::TopCaps, tops),
            Holding {
                spared_bytes: self.spared,
                ..Holding::indices(Feature::BottomCaps, self.bottom_caps, &[])
            },
            Holding::indices(Feature::Walls, self.walls, &[]),
        ]
    }
}

impl VolumeState {
    /// What pipelines of this state are for.
    #[must_use]
    pub fn feature(self) -> Feature {
        let counts = |depth| match depth {
            DepthRule::Fail | DepthRule::Always => Feature::CountBehind,
            DepthRule::Pass => Feature::CountBefore,
        };
        match self {
            Self::Mark { rule, .. } => counts(rule.depth),
            Self::Accumulate { depth, .. } => counts(depth),
            Self::Colour {
                is_before_surface: true,
                ..
            } => Feature::FlatMeshes,
            Self::Colour { .. } => Feature::Covers,
            Self::Count { .. } => Feature::Measuring,
        }
    }
}

/// What of `input` a backend holds.
///
/// - `meshes`: which are held, and of which bottom caps
/// - `holdings`: of all parts of the backend
pub(crate) fn needs_of(
    input: &FillInput,
    switches: &Switches,
    uses: &Uses,
    (meshes, bottoms): (&HeldMeshes, &HeldMeshes),
    (holdings, made): (&[Holding], WorkDone),
) -> Needs {
    let reasons = NeedReasons {
        input,
        switches,
        uses,
        meshes,
        bottoms,
    };
    let need = |&(feature, _): &(Feature, &str)| {
        let own = holdings.iter().filter(|held| held.feature == feature);
        let mut need = Need {
            feature,
            is_held: false,
            bytes: 0,
            spared_bytes: 0,
            pipelines: 0,
            reason: String::new(),
        };
        for held in own {
            need.bytes += held.memory.held_bytes();
            need.pipelines += held.pipelines;
            need.spared_bytes += held.spared_bytes;
        }
        reasons.explain(need)
    };
    Needs {
        list: Feature::ALL.iter().map(need).collect(),
        made,
    }
}

/// What the reasons of features are made from.
struct NeedReasons<'a> {
    input: &'a FillInput,
    switches: &'a Switches,
    uses: &'a Uses,
    meshes: &'a HeldMeshes,
    bottoms: &'a HeldMeshes,
}

impl NeedReasons<'_> {
    /// Completes a feature whose bytes and pipelines are known.
    fn explain(&self, mut need: Need) -> Need {
        let exists = need.bytes > 0 || need.pipelines > 0;
        let (is_used, reason) = self.used(&need, exists);
        need.is_held = exists || is_used;
        need.reason = match (exists, is_used) {
            (true, false) => format!("{reason}; what is held was made for another view"),
            _ => reason,
        };
        if !need.is_held && need.spared_bytes == 0 {
            need.spared_bytes = self.spared_bytes(need.feature);
        }
        need
    }

    /// Whether the view uses a feature, and why or why not.
    fn used(&self, need: &Need, exists: bool) -> (bool, String) {
        let feature = need.feature;
        let (uses, switches) = (self.uses, self.switches);
        let regions = self.input.scene.meshes.len();
        let drawn = uses.volumes;
        let held = (0..regions).filter(|mesh| self.meshes.has(*mesh)).count();
        let of_scene = match self.meshes {
            HeldMeshes::All => {
                format!("of all {regions} meshes of the scene; the view draws {drawn}")
            }
            HeldMeshes::Drawn(_) => format!(
                "held-meshes=drawn: of {held} of {regions} meshes of the scene; the view draws {drawn}"
            ),
        };
        match feature {
            Feature::Positions | Feature::TopCaps | Feature::Walls => (drawn > 0, of_scene),
            Feature::BottomCaps => self.bottom_caps(need),
            Feature::RegionConstants => (true, format!("of the {drawn} regions drawn")),
            Feature::Expansion => {
                let reason = if exists {
                    "volumes are made on the device from these"
                } else {
                    "volumes are stored, none is made on the device"
                };
                (exists, reason.to_owned())
            }
            Feature::CountBehind => (uses.behind > 0, self.count_behind()),
            Feature::CountBefore => (uses.before > 0, self.count_before()),
            Feature::StencilBits => self.stencil_bits(),
            Feature::Covers => (
                uses.covers > 0,
                match uses.covers {
                    0 => "nothing is coloured plainly".to_owned(),
                    some => format!(
                        "colour={}: {some} covers{}",
                        switches.setting("colour"),
                        uses.tiled_covers
                            .map_or(String::new(), |[covers, rects, px, whole]| {
                                format!(
                                    ", {covers} of them {rects} tiles of {px} px instead of {whole}"
                                )
                            })
                    ),
                },
            ),
            Feature::FlatMeshes => (
                uses.flat > 0,
                match self.input.plan.options.far_level_px {
                    None => "far-level-px=off".to_owned(),
                    Some(px) => format!("{} of {drawn} volumes are lower than {px} px", uses.flat),
                },
            ),
            Feature::NumberTarget => by_switch(uses.accumulates, "colour", switches),
            Feature::FirstPassColours => {
                by_switch(switches.first_pass.writes_colour(), "first-pass", switches)
            }
            Feature::Order => {
                let overlap = match self.input.scene.overlap {
                    Overlap::Disjoint => "disjoint",
                    Overlap::Ordered => "ordered",
                };
                let way = switches.setting("colour");
                let reason = format!("colour={way}; the scene says overlap={overlap}");
                (switches.colour.keeps_order(), reason)
            }
            Feature::Rectangles => self.rectangles(),
            Feature::Picture | Feature::TextureCode | Feature::TextureConstants => self.texture(),
            Feature::ReadableDepth => (
                switches.texture.is_some(),
                match switches.texture {
                    Some(_) => {
                        "textured covers read the depth that the surface left, where it lies"
                    }
                    None => "no shader of a plain fill reads depth",
                }
                .to_owned(),
            ),
            Feature::DepthCopy => match switches.copies_depth {
                true => (true, "depth-copy=made: nothing reads it".to_owned()),
                false if switches.texture.is_some() => (
                    false,
                    "depth is read where it lies, by a pass that writes neither depth nor stencil"
                        .to_owned(),
                ),
                false => (false, "nothing reads depth".to_owned()),
            },
            Feature::Measuring => {
                let reason = if exists {
                    "fragments were counted or texels probed"
                } else {
                    "neither fragments were counted nor texels probed"
                };
                (exists, reason.to_owned())
            }
            Feature::NearPlaneTest => self.near_plane_test(),
            Feature::FrustumCulling
            | Feature::HorizonCulling
            | Feature::TooSmallCulling
            | Feature::BoundaryLevels => self.planned(feature),
        }
    }

    fn bottom_caps(&self, need: &Need) -> (bool, String) {
        let uses = self.uses;
        let is_drawn = uses.bottoms > 0;
        let drawn = uses.volumes;
        let reason = match (self.bottoms, is_drawn) {
            (HeldMeshes::All, _) => format!(
                "bottom-cap={} with depth-rule={}: of all meshes, whatever the view; {} of {drawn} volumes \
                 are drawn with theirs",
                self.switches.setting("bottom-cap"),
                self.switches.setting("depth-rule"),
                uses.bottoms
            ),
            (HeldMeshes::Drawn(_), true) => format!(
                "{} of {drawn} volumes count behind the surface, where bottoms lie",
                uses.bottoms
            ),
            (HeldMeshes::Drawn(_), false) => {
                format!("no volume is drawn with its bottom: {}", self.near_plane())
            }
        };
        let is_held = is_drawn || *self.bottoms == HeldMeshes::All;
        let reason = if is_held && need.bytes == 0 {
            format!("{reason}; they are made of the tops' triangles and take no bytes")
        } else {
            reason
        };
        (is_held, reason)
    }

    fn count_behind(&self) -> String {
        match self.switches.depth_rule {
            DepthRuleChoice::Fail => "depth-rule=zfail, whatever the view".to_owned(),
            DepthRuleChoice::Pass => "depth-rule=zpass, whatever the view".to_owned(),
            DepthRuleChoice::Automatic | DepthRuleChoice::Uncut => self.near_plane(),
        }
    }

    fn count_before(&self) -> String {
        match self.switches.depth_rule {
            DepthRuleChoice::Automatic | DepthRuleChoice::Uncut => format!(
                "{} of {} volumes: {}",
                self.uses.before,
                self.uses.volumes,
                self.near_plane()
            ),
            _ => self.count_behind(),
        }
    }

    /// Where the near plane is.
    fn near_plane(&self) -> String {
        let (volumes, nearest) = (self.uses.volumes, self.uses.nearest_m);
        let [cut, around] = [self.uses.cut_by_near_plane, self.uses.around_near_plane];
        let none_or = |some: usize| match some {
            0 => "none".to_owned(),
            some => some.to_string(),
        };
        let met = match self.switches.depth_rule {
            DepthRuleChoice::Uncut => format!(
                "cuts {} of {volumes} volumes and is inside {}",
                none_or(cut),
                none_or(around)
            ),
            _ => format!("meets {} of {volumes} volumes", none_or(cut + around)),
        };
        let eye = match nearest {
            None => "nothing is in view".to_owned(),
            Some(nearest_m) if nearest_m > 0.0 => {
                format!(
                    "the eye is {} from the nearest one's box",
                    length(nearest_m)
                )
            }
            Some(_) => "the eye is inside one's box".to_owned(),
        };
        format!("the near plane {met}, {eye}")
    }

    fn stencil_bits(&self) -> (bool, String) {
        let uses = self.uses;
        let bits = uses.stencil_bits.count_ones();
        let why = match (bits, uses.counts_in_stencil) {
            (0, _) => "no step writes the stencil".to_owned(),
            (_, true) => "volumes are counted modulo 256".to_owned(),
            (_, false) => format!("numbers up to {}", uses.stencil_bits),
        };
        (
            bits > 0,
            format!("{bits} of the {STENCIL_BITS} bits that the shared target has: {why}"),
        )
    }

    fn rectangles(&self) -> (bool, String) {
        let uses = self.uses;
        let reason = format!(
            "{} covers and {} volumes are cut to their region's rectangle",
            uses.cut_covers, uses.cut_volumes
        );
        (uses.cut_covers + uses.cut_volumes > 0, reason)
    }

    fn texture(&self) -> (bool, String) {
        let switches = self.switches;
        let reason = match (&self.input.scene.texture, switches.texture) {
            (None, _) => "a plain fill of a scene without a picture".to_owned(),
            (Some(_), None) if switches.loads_texture => {
                "texture-code=loaded: nothing draws with it".to_owned()
            }
            (Some(_), None) => "texture=plain: the scene's picture is not shown".to_owned(),
            (Some(_), Some(route)) => format!(
                "texture={} over {} regions",
                route.name(),
                self.uses.volumes
            ),
        };
        let is_used = switches.texture.is_some() || switches.loads_texture;
        (is_used && self.uses.volumes > 0, reason)
    }

    fn near_plane_test(&self) -> (bool, String) {
        match self.switches.depth_rule {
            DepthRuleChoice::Automatic | DepthRuleChoice::Uncut => (true, self.near_plane()),
            _ if self.switches.cover_culls_faces => (true, self.near_plane()),
            _ => (
                false,
                format!(
                    "depth-rule={} is the same for all volumes",
                    self.switches.setting("depth-rule")
                ),
            ),
        }
    }

    fn planned(&self, feature: Feature) -> (bool, String) {
        let plan = &self.input.plan;
        let options = plan.options;
        let (is_on, switch, why) = match feature {
            Feature::FrustumCulling => (
                options.frustum_culling,
                "frustum-culling",
                LeftOutReason::OutsideFrustum,
            ),
            Feature::HorizonCulling => (
                options.horizon_culling,
                "horizon-culling",
                LeftOutReason::BeyondHorizon,
            ),
            Feature::TooSmallCulling => (
                options.too_small_culling,
                "too-small-culling",
                LeftOutReason::TooSmall,
            ),
            _ => return self.boundary_levels(),
        };
        if !is_on {
            return (false, format!("{switch}=off"));
        }
        let left_out = plan.left_out.iter().filter(|region| region.reason == why);
        let all = plan.left_out.len() + plan.regions.len();
        let reason = format!("{} of {all} regions are {}", left_out.count(), why.name());
        (true, reason)
    }

    fn boundary_levels(&self) -> (bool, String) {
        let Some(px) = self.input.plan.options.boundary_lod_px else {
            return (false, "boundary-lod-px=off".to_owned());
        };
        let (left_out, all) = self.input.plan.boundary_left_out(&self.input.scene.meshes);
        (
            true,
            format!("{left_out} of {all} boundary vertices move it by less than {px} px"),
        )
    }

    /// Bytes that something would take that is not there at all.
    fn spared_bytes(&self, feature: Feature) -> u64 {
        let pixels = self.input.size.pixel_count() as u64;
        match feature {
            Feature::NumberTarget => NUMBER_BYTES * pixels,
            Feature::FirstPassColours => COLOUR_BYTES * pixels,
            Feature::DepthCopy => DEPTH_STENCIL_BYTES * pixels,
            Feature::Picture => {
                let texture = self.input.scene.texture.as_ref();
                texture.map_or(0, |texture| {
                    let copies = match texture.share {
                        TextureShare::One => 1,
                        TextureShare::Each => self.input.scene.regions.len() as u64,
                    };
                    copies * texture.image.bytes()
                })
            }
            _ => 0,
        }
    }
}

/// Whether a switch asks for something, and its value.
fn by_switch(is_on: bool, switch: &str, switches: &Switches) -> (bool, String) {
    (is_on, format!("{switch}={}", switches.setting(switch)))
}
