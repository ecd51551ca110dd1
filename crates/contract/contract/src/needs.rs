// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a fill of one view holds and what it leaves out, each with its reason. A backend says it, a study writes it
//! down.

use crate::WorkDone;

/// Something that a fill may hold or do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Feature {
    /// Positions and flags of the volumes' vertices.
    Positions,
    /// Triangles of the volumes' tops.
    TopCaps,
    /// Triangles of their bottoms, stored.
    BottomCaps,
    /// Triangles or edges of their walls.
    Walls,
    /// What shaders read of each region.
    RegionConstants,
    /// What a device reads to make volumes and to decide what is drawn.
    Expansion,
    /// Pipelines that count fragments behind the surface.
    CountBehind,
    /// Pipelines that count fragments in front of it.
    CountBefore,
    /// Bits of the stencil that are written.
    StencilBits,
    /// What brings the plain colours.
    Covers,
    /// Top caps and walls in place of low volumes.
    FlatMeshes,
    /// A target that regions' numbers add up in.
    NumberTarget,
    /// A target for colours of the first pass.
    FirstPassColours,
    /// Later regions cover earlier ones.
    Order,
    /// Draws are cut to regions' rectangles.
    Rectangles,
    /// The scene's picture with its levels.
    Picture,
    /// Pipelines of textured covers.
    TextureCode,
    /// What textured covers read of each region.
    TextureConstants,
    /// Depth that shaders read.
    ReadableDepth,
    /// A copy of the surface's depth.
    DepthCopy,
    /// Pipelines that only measuring needs.
    Measuring,
    /// A test of each volume against the near plane.
    NearPlaneTest,
    /// Regions outside the view frustum are left out.
    FrustumCulling,
    /// Regions that the body hides are left out.
    HorizonCulling,
    /// Regions that no pixel's centre can show are left out.
    TooSmallCulling,
    /// Coarser boundaries.
    BoundaryLevels,
}

impl Feature {
    /// Every feature, with its name in `notes.csv`.
    pub const ALL: [(Self, &'static str); 26] = [
        (Self::Positions, "need_positions"),
        (Self::TopCaps, "need_top_caps"),
        (Self::BottomCaps, "need_bottom_caps"),
        (Self::Walls, "need_walls"),
        (Self::RegionConstants, "need_region_constants"),
        (Self::Expansion, "need_expansion"),
        (Self::CountBehind, "need_count_behind"),
        (Self::CountBefore, "need_count_before"),
        (Self::StencilBits, "need_stencil_bits"),
        (Self::Covers, "need_covers"),
        (Self::FlatMeshes, "need_flat_meshes"),
        (Self::NumberTarget, "need_number_target"),
        (Self::FirstPassColours, "need_first_pass_colours"),
        (Self::Order, "need_order"),
        (Self::Rectangles, "need_rectangles"),
        (Self::Picture, "need_picture"),
        (Self::TextureCode, "need_texture_code"),
        (Self::TextureConstants, "need_texture_constants"),
        (Self::ReadableDepth, "need_readable_depth"),
        (Self::DepthCopy, "need_depth_copy"),
        (Self::Measuring, "need_measuring"),
        (Self::NearPlaneTest, "need_near_plane_test"),
        (Self::FrustumCulling, "need_frustum_culling"),
        (Self::HorizonCulling, "need_horizon_culling"),
        (Self::TooSmallCulling, "need_too_small_culling"),
        (Self::BoundaryLevels, "need_boundary_levels"),
    ];

    /// Its name in `notes.csv`.
    #[must_use]
    pub fn note(self) -> &'static str {
        let named = Self::ALL.iter().find(|(feature, _)| *feature == self);
        named.map_or("", |(_, note)| note)
    }
}

/// One feature of one view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Need {
    /// Which.
    pub feature: Feature,
    /// It is built in.
    pub is_held: bool,
    /// Bytes of its buffers and textures.
    pub bytes: u64,
    /// Bytes that it would take beside these.
    pub spared_bytes: u64,
    /// Pipelines made for it.
    pub pipelines: u64,
    /// Why, with the value that decided it.
    pub reason: String,
}

impl Need {
    /// As one line of text: the inverse of [`Need::read`].
    #[must_use]
    pub fn line(&self) -> String {
        format!(
            "{}; bytes {}; spared bytes {}; pipelines {}; {}",
            if self.is_held { "held" } else { "left out" },
            self.bytes,
            self.spared_bytes,
            self.pipelines,
            self.reason
        )
    }

    /// What a line says of `feature`; `None` of any other text.
    #[must_use]
    pub fn read(feature: Feature, line: &str) -> Option<Self> {
        let mut parts = line.splitn(5, "; ");
        let is_held = match parts.next()? {
            "held" => true,
            "left out" => false,
            _ => return None,
        };
        let mut number = |name: &str| {
            let value = parts.next()?.strip_prefix(name)?.strip_prefix(' ')?;
            value.parse::<u64>().ok()
        };
        Some(Self {
            feature,
            is_held,
            bytes: number("bytes")?,
            spared_bytes: number("spared bytes")?,
            pipelines: number("pipelines")?,
            reason: parts.next()?.to_owned(),
        })
    }
}

/// Everything that a view holds and leaves out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Needs {
    /// In the order of [`Feature::ALL`].
    pub list: Vec<Need>,
    /// What the device was asked to make since the backend was opened. Of a backend that was prepared
    /// once, all of that is held.
    pub made: WorkDone,
}

impl Needs {
    /// What is said of a feature.
    #[must_use]
    pub fn of(&self, feature: Feature) -> Option<&Need> {
        self.list.iter().find(|need| need.feature == feature)
    }

    /// Bytes of all buffers and textures that are held.
    #[must_use]
    pub fn held_bytes(&self) -> u64 {
        self.list.iter().map(|need| need.bytes).sum()
    }

    /// Pipelines that are held.
    #[must_use]
    pub fn pipelines(&self) -> u64 {
        self.list.iter().map(|need| need.pipelines).sum()
    }

    /// What the device made for a backend that was prepared once, and no feature accounts for; `None` where
    /// the sums agree.
    #[must_use]
    pub fn undeclared(&self) -> Option<String> {
        let sums = [
            ("bytes", self.held_bytes(), self.made.made_bytes),
            ("pipelines", self.pipelines(), self.made.pipeline_creations),
        ];
        let differing = sums.iter().filter(|(_, held, made)| held != made);
        let told: Vec<String> = differing
            .map(|(what, held, made)| format!("{held} {what} are declared, {made} were made"))
            .collect();
        (!told.is_empty()).then(|| told.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(feature: Feature, bytes: u64, pipelines: u64) -> Need {
        Need {
            feature,
            is_held: bytes + pipelines > 0,
            bytes,
            spared_bytes: 7,
            pipelines,
            reason: "because of this; and of that".to_owned(),
        }
    }

    #[test]
    fn a_line_says_it_all() {
        for found in [need(Feature::Walls, 12, 0), need(Feature::Picture, 0, 0)] {
            let line = found.line();
            assert_eq!(Need::read(found.feature, &line), Some(found), "{line}");
        }
        for wrong in [
            "",
            "held",
            "here; bytes 1; spared bytes 0; pipelines 0; why",
            "held; bytes x; spared bytes 0; pipelines 0; why",
            "held; spared bytes 0; bytes 1; pipelines 0; why",
        ] {
            assert_eq!(Need::read(Feature::Walls, wrong), None, "{wrong}");
        }
    }

    #[test]
    fn every_feature_has_a_name_of_its_own() {
        let names: std::collections::BTreeSet<_> = Feature::ALL
            .iter()
            .map(|(feature, _)| feature.note())
            .collect();
        assert_eq!(names.len(), Feature::ALL.len());
        assert!(names.iter().all(|name| name.starts_with("need_")));
        let mut sorted = Feature::ALL.map(|(feature, _)| feature);
        sorted.sort_unstable();
        assert_eq!(sorted, Feature::ALL.map(|(feature, _)| feature));
    }

    #[test]
    fn what_is_held_and_not_declared_is_noticed() {
        let made = WorkDone {
            made_bytes: 30,
            pipeline_creations: 3,
            ..WorkDone::default()
        };
        let honest = Needs {
            list: vec![need(Feature::Walls, 20, 1), need(Feature::TopCaps, 10, 2)],
            made,
        };
        assert_eq!(honest.undeclared(), None);
        assert_eq!((honest.held_bytes(), honest.pipelines()), (30, 3));
        // Negative controls: a buffer, or a pipeline, that no feature accounts for.
        let mut forged = honest.clone();
        forged.list[1].bytes = 0;
        let said = forged.undeclared().expect("10 bytes are missing");
        assert_eq!(said, "20 bytes are declared, 30 were made");
        let mut forged = honest;
        forged.list.pop();
        let said = forged.undeclared().expect("both are missing");
        assert!(
            said.contains("1 pipelines are declared, 3 were made"),
            "{said}"
        );
    }
}
