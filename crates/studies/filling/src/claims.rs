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

/// Conditions by name that a case has, each with its value.
pub(crate) type Conditions = Vec<[String; 2]>;

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
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) struct Step {
    pub(crate) name: String,
    #[serde(default = "every_view")]
    pub(crate) views: Vec<String>,
    #[serde(default)]
    pub(crate) only: Only,
}

/// Two cases of each view that has both.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Pair {
    /// The last kept step before a step, and the step.
    Step(Step),
    /// Two textured fills, by their names.
    Fills([String; 2]),
    /// What draws instead of volumes, and volumes.
    Rival(Conditions),
    /// The coarsest mesh and the finest.
    CapSteps,
}

/// A figure of the first case over that of the second, in each view.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) struct Ratio {
    pub(crate) of: Pair,
    /// Figures by name; without any, the time of the fill.
    #[serde(default)]
    pub(crate) metrics: Vec<String>,
    pub(crate) expects: Claim,
}

/// Cases whose pictures are looked at.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Pictured {
    /// A step's.
    Step(Step),
    /// Those of every view's comparison that are so.
    With(Conditions),
}

/// How a claim is tested.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Test {
    /// By the ratio of two cases.
    Ratio(Ratio),
    /// The pictures are right.
    RightPictures(Pictured),
    /// Some view has pixels that are wrong farther than a pixel from a boundary.
    WrongPictures(Pictured),
    /// The step gains more than any other of the document's own steps.
    LargestGain(Step),
    /// By the share of the second pass in the GPU time of a step's fill.
    SecondPass(Step),
    /// By the exponents of time over vertices and over fragments.
    FillRate,
    /// Textured over plain is more along the horizon than elsewhere.
    TexturedWorstAtHorizon,
    /// By a formula alone.
    Sum {
        /// Products that are added up.
        terms: Vec<Vec<u64>>,
        /// What the document says that it gives.
        says: u64,
    },
    /// By the bytes of a geometry shader's layout over those of the vertex shader's.
    GeometryShaderBytes(Claim),
    /// Every plain picture is right on surfaces of more than one kind.
    SurfaceIndependence,
    /// Not at all, and why.
    No(String),
}

impl Tested for Test {
    fn expects(&self) -> Option<Claim> {
        match self {
            Self::Ratio(Ratio { expects, .. }) | Self::GeometryShaderBytes(expects) => {
                Some(*expects)
            }
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

    /// What each step of the vertex shader's ablation sets, by the last step that is kept before it.
    fn set_by_steps(overlap: Overlap) -> BTreeMap<&'static str, BTreeSet<String>> {
        let technique: &'static dyn Technique = &terrafill_vertex::VertexTechnique;
        let mut kept: BTreeSet<(String, String)> = BTreeSet::new();
        let mut steps = BTreeMap::new();
        for step in technique.ablation(overlap) {
            let settings = Subject::Fill(technique, step.variant)
                .settings()
                .into_iter();
            let own: BTreeSet<(String, String)> = settings
                .map(|(key, value)| (key.name().to_owned(), value))
                .collect();
            let different = own.symmetric_difference(&kept);
            steps.insert(step.name, different.map(|(key, _)| key.clone()).collect());
            if !step.is_aside {
                kept = own;
            }
        }
        steps
    }

    #[test]
    fn what_a_step_changes_is_what_the_ablation_sets_there() {
        // Steps of which no claim speaks need not be told.
        let told = PAPER.steps.iter();
        let told: BTreeMap<&str, BTreeSet<String>> = told
            .map(|(step, keys)| (step.as_str(), keys.iter().cloned().collect()))
            .collect();
        let mut of_ablations = BTreeMap::new();
        for overlap in [Overlap::Disjoint, Overlap::Ordered] {
            of_ablations.extend(set_by_steps(overlap));
            // Of ordered regions the ablation has fewer steps, each of which sets the same.
            let set = set_by_steps(overlap)
                .into_iter()
                .filter(|(step, _)| *step != "start");
            for (step, keys) in set {
                let told = told.get(step);
                assert!(
                    told.is_none_or(|told| *told == keys),
                    "{overlap:?}, {step}: {told:?}"
                );
            }
        }
        let unknown: Vec<_> = told
            .keys()
            .filter(|step| !of_ablations.contains_key(**step))
            .collect();
        assert_eq!(unknown, [&""; 0]);
    }

    #[test]
    fn claims_name_steps_and_fills_that_there_are() {
        for claimed in &PAPER.claims {
            if let Test::Ratio(Ratio {
                of: Pair::Fills(names),
                ..
            }) = &claimed.test
            {
                let mut names = names.iter();
                let are_known = names.all(|name| PAPER.cases.contains_key(name));
                assert!(are_known, "{}: {:?}", claimed.words, claimed.test);
            }
            let (Test::Ratio(Ratio {
                of: Pair::Step(step),
                ..
            })
            | Test::RightPictures(Pictured::Step(step))
            | Test::LargestGain(step)
            | Test::SecondPass(step)) = &claimed.test
            else {
                continue;
            };
            let (name, words) = (&step.name, &claimed.words);
            assert!(PAPER.steps.contains_key(name), "{words}: {name}");
        }
    }
}
