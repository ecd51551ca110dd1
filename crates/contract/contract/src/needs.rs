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
    /// Every feature, with its name in `features.csv`.
    pub const ALL: [(Self, &'static str); 26] = [
        (Self::Positions, "positions"),
        (Self::TopCaps, "top caps"),
        (Self::BottomCaps, "bottom caps"),
        (Self::Walls, "walls"),
        (Self::RegionConstants, "region constants"),
        (Self::Expansion, "expansion"),
        (Self::CountBehind, "count behind"),
        (Self::CountBefore, "count before"),
        (Self::StencilBits, "stencil bits"),
        (Self::Covers, "covers"),
        (Self::FlatMeshes, "flat meshes"),
        (Self::NumberTarget, "number target"),
        (Self::FirstPassColours, "first pass colours"),
        (Self::Order, "order"),
        (Self::Rectangles, "rectangles"),
        (Self::Picture, "picture"),
        (Self::TextureCode, "texture code"),
        (Self::TextureConstants, "texture constants"),
        (Self::ReadableDepth, "readable depth"),
        (Self::DepthCopy, "depth copy"),
        (Self::Measuring, "measuring"),
        (Self::NearPlaneTest, "near plane test"),
        (Self::FrustumCulling, "frustum culling"),
        (Self::HorizonCulling, "horizon culling"),
        (Self::TooSmallCulling, "too small culling"),
        (Self::BoundaryLevels, "boundary levels"),
    ];

    /// Its name in `features.csv`.
    #[must_use]
    pub fn name(self) -> &'static str {
        let named = Self::ALL.iter().find(|(feature, _)| *feature == self);
        named.map_or("", |(_, name)| name)
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
        let messages: Vec<String> = differing
            .map(|(what, held, made)| format!("{held} {what} are declared, {made} were made"))
            .collect();
        (!messages.is_empty()).then(|| messages.join("; "))
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
    fn every_feature_has_a_name_of_its_own() {
        let names: std::collections::BTreeSet<_> = Feature::ALL
            .iter()
            .map(|(feature, _)| feature.name())
            .collect();
        assert_eq!(names.len(), Feature::ALL.len());
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
