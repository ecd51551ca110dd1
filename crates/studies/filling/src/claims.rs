// SPDX-License-Identifier: MIT OR Apache-2.0
//! How this study tests what Cozzi (2007) claims: the claims are `papers/cozzi-2007.toml`.

use serde::Deserialize;
use std::sync::LazyLock;
use terrafill_lab::{Paper, Tested};
use terrafill_results::Claim;

/// The document's claims.
///
/// A file that cannot be read is an error of the program, which every test of the chapter meets.
pub(crate) static PAPER: LazyLock<Paper<Test>> = LazyLock::new(|| {
    let text = include_str!("../../../../papers/cozzi-2007.toml");
    Paper::parse("papers/cozzi-2007.toml", text).unwrap_or_else(|error| panic!("{error}"))
});

/// The document's three views: all regions small, one from above (as scenes call it, by two names), along
/// the horizon.
const EVERY_VIEW: [&str; 4] = ["globe", "top-down", "fill", "horizon"];

fn every_view() -> Vec<String> {
    EVERY_VIEW.map(str::to_owned).into()
}

/// What draws instead of volumes, of the techniques of this run.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Rival {
    pub(crate) technique: String,
    /// Its knob.
    pub(crate) key: String,
    /// The knob's value.
    pub(crate) value: String,
}

/// Which of a step's views say something of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Only {
    #[default]
    Any,
    /// Those in which the frustum holds every region.
    AllInSight,
    /// Those in which the step changes how many vertices are drawn: an eye inside every volume needs its
    /// caps, and says nothing of leaving them out.
    WhereItActs,
}

/// A step of the vertex shader's ablation in these views.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) struct Step {
    pub(crate) step: String,
    #[serde(default = "every_view")]
    pub(crate) views: Vec<String>,
}

/// What is expected of the gain of a step, in these views.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) struct Gain {
    pub(crate) name: String,
    pub(crate) expects: Claim,
    #[serde(default = "every_view")]
    pub(crate) views: Vec<String>,
    #[serde(default)]
    pub(crate) only: Only,
}

/// How a claim is tested.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Test {
    /// By the gain of a step: time without it over time with it.
    Step(Gain),
    /// By a counter of a step: its value without the step over that with it.
    Counter {
        step: String,
        metric: String,
        expects: Claim,
        #[serde(default = "every_view")]
        views: Vec<String>,
    },
    /// The step gains more than any other of the document's own steps.
    LargestGain(Step),
    /// The step's picture is right.
    RightPicture(Step),
    /// By the share of the second pass in the GPU time of a step's fill.
    SecondPass(Step),
    /// By the exponents of time over vertices and over fragments.
    FillRate,
    /// By the ratio of two textured fills, named by the heading of its column.
    Textured { ratio: String, expects: Claim },
    /// Largest texel error by angles about the body's centre beside that by barycentric coordinates.
    FlatMesh,
    /// Textured over plain is more along the horizon than elsewhere.
    TexturedWorstAtHorizon,
    /// By a formula alone.
    Sum {
        /// With its figures, in words.
        formula: String,
        /// Products that are added up.
        terms: Vec<Vec<u64>>,
        /// What the document says that it gives.
        says: u64,
    },
    /// By the bytes of a geometry shader's layout over those of the vertex shader's.
    GeometryShaderBytes(Claim),
    /// Centric normals give right pictures on terrain.
    CentricNormals,
    /// Every plain picture is right on surfaces of more than one kind.
    SurfaceIndependence,
    /// By the fills of the coarsest and the finest mesh.
    Subdivision,
    /// By figures of a rival over those of volumes, all of them more than 1.
    CostsMore { rival: Rival, metrics: Vec<String> },
    /// By the time of a rival over that of volumes.
    TimeOverVolumes { rival: Rival, expects: Claim },
    /// By pixels of a rival that are wrong farther than a pixel from a boundary: there are some.
    WrongPixels { rival: Rival },
    /// Not at all, and why.
    No(String),
}

impl Tested for Test {
    fn expects(&self) -> Option<Claim> {
        match self {
            Self::Step(Gain { expects, .. })
            | Self::Counter { expects, .. }
            | Self::Textured { expects, .. }
            | Self::TimeOverVolumes { expects, .. }
            | Self::GeometryShaderBytes(expects) => Some(*expects),
            _ => None,
        }
    }

    fn cannot(&self) -> Option<&str> {
        match self {
            Self::No(why) => Some(why),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::Subject;
    use std::collections::{BTreeMap, BTreeSet};
    use terrafill_contract::Technique;
    use terrafill_scene::Overlap;

    /// What each step of the vertex shader's ladder sets, by the last step that is kept before it.
    fn set_by_steps(overlap: Overlap) -> BTreeMap<&'static str, BTreeSet<String>> {
        let technique: &'static dyn Technique = &terrafill_vertex::VertexTechnique;
        let mut kept: BTreeSet<(String, String)> = BTreeSet::new();
        let mut steps = BTreeMap::new();
        for rung in technique.ladder(overlap) {
            let settings = Subject::Fill(technique, rung.variant)
                .settings()
                .into_iter();
            let own: BTreeSet<(String, String)> = settings
                .map(|(key, value)| (key.name().to_owned(), value))
                .collect();
            let different = own.symmetric_difference(&kept);
            steps.insert(rung.step, different.map(|(key, _)| key.clone()).collect());
            if !rung.is_aside {
                kept = own;
            }
        }
        steps
    }

    #[test]
    fn what_a_step_changes_is_what_the_ladder_sets_there() {
        let told = PAPER.steps.iter();
        let told: BTreeMap<&str, BTreeSet<String>> = told
            .map(|(step, keys)| (step.as_str(), keys.iter().cloned().collect()))
            .collect();
        let mut of_ladders = BTreeMap::new();
        for overlap in [Overlap::Disjoint, Overlap::Ordered] {
            of_ladders.extend(set_by_steps(overlap));
            // Of ordered regions the ladder has fewer steps, each of which sets the same.
            let set = set_by_steps(overlap)
                .into_iter()
                .filter(|(step, _)| *step != "start");
            for (step, keys) in set {
                assert_eq!(told.get(step), Some(&keys), "{overlap:?}, {step}");
            }
        }
        // The first one sets everything.
        of_ladders.remove("start");
        assert_eq!(told, of_ladders);
    }

    #[test]
    fn claims_name_steps_that_there_are() {
        for claimed in &PAPER.claims {
            let (Test::Step(Gain { name: step, .. })
            | Test::Counter { step, .. }
            | Test::LargestGain(Step { step, .. })
            | Test::RightPicture(Step { step, .. })
            | Test::SecondPass(Step { step, .. })) = &claimed.test
            else {
                continue;
            };
            assert!(PAPER.steps.contains_key(step), "{}: {step}", claimed.words);
        }
    }
}
