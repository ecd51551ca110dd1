// SPDX-License-Identifier: MIT OR Apache-2.0
//! What was published, and what is measured.

use super::sections::DEVICE_KEYS;
use super::{Own, number, value};
use crate::keys;
use crate::keys::{
    BIAS, CASTERS, COUNTING, EXTENT, EYE_TEST, LOST, MAP_WRONG, MESH, MISSED, MODELS, OUTLINE,
    POLICY, RULE, SCISSOR, SHADOW_CLEARS, SHADOW_CONTOUR_PX, SHADOW_FALSE_DARK_PX,
    SHADOW_FALSE_LIT_PX, SHADOW_OPEN_EDGES, SILHOUETTE, SUN, TEXEL_M, UPDATES,
};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Clock, ConditionKey, Finding, Standing};

/// Two ways of a device that differ in one condition: its key, the way said to be faster, the other one.
pub(super) type Two = (ConditionKey, &'static str, &'static str);

const RULES: Two = (RULE, "z-pass", "z-fail");
const FACES: Two = (keys::FACES, "two-sided", "two-pass");
const PULLED: Two = (SILHOUETTE, "pulled", "adjacency");
const COMPUTED: Two = (SILHOUETTE, "compute", "adjacency");
const TRIANGLES: Two = (SILHOUETTE, "gs-adjacency", "adjacency");

/// Twins that must be wrong: name, question, and the condition that tells them.
const TWINS: [(&str, &str, ConditionKey, &str); 10] = [
    ("z-pass as printed", "updates", RULE, "z-pass as printed"),
    ("the horizon as a scissor", "scissors", SCISSOR, "horizon"),
    ("8 bits that wrap", "rows", COUNTING, "8 bits, wrapping"),
    ("an open hull as it is", "casters", POLICY, "as-is"),
    (
        "contours where the stencil is S",
        "outlines",
        OUTLINE,
        "value as printed",
    ),
    (
        "values never cleared",
        "outlines",
        OUTLINE,
        "value, never cleared",
    ),
    (
        "a turned face",
        "silhouettes",
        MESH,
        "port-s, one face turned",
    ),
    (
        "facing by corners",
        "facings",
        SILHOUETTE,
        "pulled, f32 by corners",
    ),
    ("z-pass at a dark near plane", "near", RULE, "z-pass"),
    ("the eye's test there", "near", RULE, "automatic, eye"),
];

/// Whether two cases have the same conditions of a device, but for some.
pub(super) fn is_same_but(keys: &[ConditionKey], a: &Case, b: &Case) -> bool {
    let mut others = DEVICE_KEYS.iter().filter(|key| !keys.contains(key));
    others.all(|key| a.condition(*key) == b.condition(*key))
}

/// Holds where all do.
pub(super) fn of_all(standings: &[Standing]) -> Standing {
    let has = |wanted| standings.contains(&wanted);
    match (has(Standing::DoesNotHold), has(Standing::CannotTell)) {
        (true, _) => Standing::DoesNotHold,
        (false, true) => Standing::CannotTell,
        (false, false) => Standing::Holds,
    }
}

/// Least and greatest.
pub(super) fn range(values: &[f64]) -> Option<String> {
    let least = values.iter().copied().reduce(f64::min)?;
    let most = values.iter().copied().reduce(f64::max)?;
    Some(format!("{} to {}", significant(least), significant(most)))
}

impl Own<'_> {
    pub(super) fn findings(&self, clock: Clock) -> Vec<Finding> {
        let findings = [
            self.masks(),
            self.twins(),
            self.eye_test(),
            self.eyes_elsewhere(),
            self.pass_is_faster(),
            self.closed_at_the_sea(),
            self.closed_and_low(),
            self.writes_elsewhere(),
            self.bounds(),
            self.horizon(),
            self.clears(),
            self.wrap(),
            self.devices(),
            self.faster(clock, "z-pass is faster than z-fail on a device", RULES),
            self.faster(clock, "Two-sided stencil is faster than two passes", FACES),
            self.faster(
                clock,
                "Frames are faster where a vertex shader finds silhouettes",
                PULLED,
            ),
            self.faster(
                clock,
                "Frames are faster where a compute shader finds silhouettes",
                COMPUTED,
            ),
            self.faster(
                clock,
                "Frames are faster where a geometry shader finds silhouettes of triangles",
                TRIANGLES,
            ),
            self.emulated(clock),
            self.ladder(clock),
            self.rivals(clock),
            self.near(),
            self.device_rows(),
            self.facings(),
            self.origins(),
            self.maps(),
            self.map_curve(),
            self.volumes_or_maps(clock),
        ];
        findings.into_iter().flatten().collect()
    }

    /// Wrong pixels of a case, outside the band.
    pub(super) fn wrong_px(case: &Case) -> Option<f64> {
        let px = [SHADOW_FALSE_LIT_PX, SHADOW_FALSE_DARK_PX].map(|metric| value(case, metric));
        px.into_iter().try_fold(0.0, |sum, px| Some(sum + px?))
    }

    /// What must be wrong, and by how much it is.
    fn twins(&self) -> Option<Finding> {
        let of = |(name, question, key, twin): &(&'static str, &str, ConditionKey, &str)| {
            let all = self.of_question(question);
            let own = all.filter(|case| case.condition(*key) == *twin);
            let wrong = own.filter_map(|case| {
                let of = |metric| value(case, metric);
                let other = of(SHADOW_CONTOUR_PX).or_else(|| of(SHADOW_OPEN_EDGES));
                other.or_else(|| Self::wrong_px(case))
            });
            let most = wrong.reduce(f64::max)?;
            Some((*name, most))
        };
        let known: Vec<(&str, f64)> = TWINS.iter().filter_map(of).collect();
        let text = known
            .iter()
            .map(|(name, most)| format!("{name}: {}", number(*most)));
        (!known.is_empty()).then(|| Finding {
            claim: "Twins that must be wrong are.".to_owned(),
            standing: Standing::holds_if(known.iter().all(|(_, most)| *most > 0.0)),
            because: format!(
                "So many pixels, contour pixels or open edges are wrong at most: {}",
                text.collect::<Vec<_>>().join(", ")
            ),
        })
    }

    /// Every rule and extent against the reference.
    fn masks(&self) -> Option<Finding> {
        let own: Vec<&Case> = self
            .of_question("updates")
            .filter(|case| !case.condition(RULE).contains("printed"))
            .collect();
        let all: Option<Vec<f64>> = own.iter().map(|case| Self::wrong_px(case)).collect();
        let total: f64 = all?.iter().sum();
        (!own.is_empty()).then(|| Finding {
            claim: "Every rule and extent has the reference's mask outside the band.".to_owned(),
            standing: Standing::holds_if(total == 0.0),
            because: format!("{} pixels wrong in {} cases", significant(total), own.len()),
        })
    }

    /// Under each sun and bias, by texels.
    fn maps(&self) -> Option<Finding> {
        let of_sun = |sun: &&str| {
            let mut texels: Vec<(f64, f64)> = self
                .of_question("maps")
                .filter(|case| case.condition(SUN) == *sun && case.condition(BIAS) == "constant")
                .filter_map(|case| {
                    Some((
                        case.condition(TEXEL_M).parse().ok()?,
                        value(case, MAP_WRONG)?,
                    ))
                })
                .collect();
            texels.sort_by(|a, b| a.0.total_cmp(&b.0));
            texels
        };
        let suns = self.suns("maps");
        let all: Vec<(&str, Vec<(f64, f64)>)> =
            suns.iter().map(|sun| (*sun, of_sun(sun))).collect();
        let is_known = all.iter().any(|(_, texels)| texels.len() > 1);
        let falls = |texels: &Vec<(f64, f64)>| texels.is_sorted_by(|a, b| a.1 <= b.1);
        let text = all.iter().map(|(sun, texels)| {
            let texels = texels
                .iter()
                .map(|(texel, wrong)| format!("{} % at {texel} m", significant(*wrong)));
            format!("sun {sun}: {}", texels.collect::<Vec<_>>().join(", "))
        });
        is_known.then(|| Finding {
            claim: "Smaller texels leave fewer wrong pixels of a shadow map, and none of them leaves none."
                .to_owned(),
            standing: Standing::holds_if(all.iter().all(|(_, texels)| {
                falls(texels) && texels.iter().all(|(_, wrong)| *wrong > 0.0)
            })),
            because: format!("Best constant bias, {}", text.collect::<Vec<_>>().join("; ")),
        })
    }

    fn eye_test(&self) -> Option<Finding> {
        let published = self.values("eyes", &[(EYE_TEST, "eye")], MISSED);
        let exact = self.values("eyes", &[(EYE_TEST, "near-exact")], MISSED);
        let most = published.iter().copied().reduce(f64::max)?;
        let least = published.iter().copied().reduce(f64::min)?;
        let missed = exact.iter().copied().reduce(f64::max)?;
        Some(Finding {
            claim: "The segment from the eye to the light says where z-pass is right (Yang & Jin, 2006, anticipated)."
                .to_owned(),
            standing: Standing::holds_if(most == 0.0),
            because: format!(
                "It misses {} to {} % of the eyes on deck; the near rectangle tested exactly misses {} %",
                significant(least),
                significant(most),
                significant(missed)
            ),
        })
    }

    /// Writes of a rule and extent under a sun.
    fn writes(&self, sun: &str, extent: &str, rule: &str) -> Option<f64> {
        self.value(
            "updates",
            &[(SUN, sun), (EXTENT, extent), (RULE, rule)],
            UPDATES,
        )
    }

    fn pass_is_faster(&self) -> Option<Finding> {
        let suns = self.suns("updates");
        let ratios = |extent: &str| -> Option<[f64; 2]> {
            let of = |sun: &&str| {
                Some(self.writes(sun, extent, "z-fail")? / self.writes(sun, extent, "z-pass")?)
            };
            let all: Option<Vec<f64>> = suns.iter().map(of).collect();
            let all = all?;
            Some([
                all.iter().copied().reduce(f64::min)?,
                all.iter().copied().reduce(f64::max)?,
            ])
        };
        let (infinite, closed) = (ratios("infinite")?, ratios("sea-closed")?);
        let range = |of: [f64; 2]| format!("{} to {}", significant(of[0]), significant(of[1]));
        Some(Finding {
            claim: "z-pass writes less than z-fail (Yang & Jin, 2006, anticipated).".to_owned(),
            standing: Standing::holds_if(infinite[0] > 1.0 && closed[0] > 1.0),
            because: format!(
                "z-fail over z-pass: {} for infinite volumes, {} for those closed at the sea",
                range(infinite),
                range(closed)
            ),
        })
    }

    fn closed_at_the_sea(&self) -> Option<Finding> {
        let suns = self.suns("updates");
        let ratio = |sun: &&str| {
            let infinite = self.writes(sun, "infinite", "z-fail")?;
            let ratio = infinite / self.writes(sun, "sea-closed", "z-fail")?;
            let calm = self.writes(sun, "sea-closed, calm", "z-fail");
            let calm = calm.map_or(String::new(), |calm| {
                format!(" (calm sea: {})", significant(infinite / calm))
            });
            Some(format!("{}{calm} at {sun}", significant(ratio)))
        };
        let ratios: Option<Vec<String>> = suns.iter().map(ratio).collect();
        let always = suns.iter().all(|sun| {
            let closed = self.writes(sun, "sea-closed", "z-fail");
            self.writes(sun, "infinite", "z-fail")
                .zip(closed)
                .is_some_and(|(open, closed)| closed < open)
        });
        Some(Finding {
            claim: "Closing volumes at the sea saves stencil writes of z-fail.".to_owned(),
            standing: Standing::holds_if(always),
            because: format!(
                "Writes of infinite volumes over those of volumes closed at the sea, whose casters are cut there too: {}",
                ratios?.join(", ")
            ),
        })
    }

    /// z-fail of closed volumes beside z-pass, where the sun is low along the dock.
    fn closed_and_low(&self) -> Option<Finding> {
        let mut texts = Vec::new();
        let mut is_less = true;
        for sun in self.suns("updates") {
            let (elevation, azimuth) = sun.split_once("° from ")?;
            let is_low = elevation.parse::<f64>().is_ok_and(|degrees| degrees <= 5.0);
            if !is_low || azimuth != "0°" {
                continue;
            }
            let of = |extent, rule| self.writes(sun, extent, rule);
            let (fail, pass) = (of("sea-closed", "z-fail")?, of("infinite", "z-pass")?);
            is_less &= fail < pass;
            let [fail, pass] = [fail, pass].map(significant);
            texts.push(format!("{fail} against {pass} at {sun}"));
        }
        (!texts.is_empty()).then(|| Finding {
            claim: "Under suns at 5° and below along the dock, z-fail of volumes closed at the sea writes less than z-pass.".to_owned(),
            standing: Standing::holds_if(is_less),
            because: format!("Writes per pixel: {}", texts.join(", ")),
        })
    }

    fn bounds(&self) -> Option<Finding> {
        let mut texts = Vec::new();
        let (mut is_less, mut lost) = (true, 0.0);
        for case in self.of_question("bounds") {
            let (sun, rule) = (case.condition(SUN), case.condition(RULE));
            let (whole, within) = (self.writes(sun, "sea-closed", rule)?, value(case, UPDATES)?);
            is_less &= within < whole;
            lost += Self::wrong_px(case)?;
            let [whole, within] = [whole, within].map(significant);
            texts.push(format!("{rule} at {sun}: {whole} to {within}"));
        }
        (!texts.is_empty()).then(|| Finding {
            claim: "Depth bounds save stencil writes and change no pixel (Yang & Jin, 2006, anticipated).".to_owned(),
            standing: Standing::holds_if(is_less && lost == 0.0),
            because: format!(
                "{} pixels outside the band are wrong; writes per pixel, {}",
                number(lost),
                texts.join(", ")
            ),
        })
    }

    fn horizon(&self) -> Option<Finding> {
        let lost = |scissor: &str| self.value("scissors", &[(SCISSOR, scissor)], LOST);
        let (horizon, caster) = (lost("horizon")?, lost("caster-rect")?);
        Some(Finding {
            claim: "There is no shadow below the horizon, so a scissor there loses none (Yang & Jin, 2006, considered)."
                .to_owned(),
            standing: Standing::holds_if(horizon == 0.0),
            because: format!(
                "It loses {} % of the shadow pixels; rectangles of casters lose {} %",
                significant(horizon),
                significant(caster)
            ),
        })
    }

    fn clears(&self) -> Option<Finding> {
        let all = self
            .of_question("outlines")
            .filter(|case| case.condition(OUTLINE) == "value");
        let pairs: Option<Vec<(f64, f64)>> = all
            .map(|case| {
                Some((
                    case.condition(MODELS).parse().ok()?,
                    value(case, SHADOW_CLEARS)?,
                ))
            })
            .collect();
        let pairs = pairs.filter(|pairs| !pairs.is_empty())?;
        let text = pairs
            .iter()
            .map(|(models, clears)| format!("{models}: {clears}"));
        Some(Finding {
            claim: "A stencil value for each model takes 1 + ⌊N/255⌋ clears.".to_owned(),
            standing: Standing::holds_if(
                pairs
                    .iter()
                    .all(|(models, clears)| *clears == 1.0 + (models / 255.0).floor()),
            ),
            because: format!("Clears by models: {}", text.collect::<Vec<_>>().join(", ")),
        })
    }

    fn wrap(&self) -> Option<Finding> {
        let lost = |casters: &str, counting: &str| {
            self.value("rows", &[(CASTERS, casters), (COUNTING, counting)], LOST)
        };
        let wrapping = "8 bits, wrapping";
        let counts = ["255", "256", "257", "511", "512"];
        let wraps: Option<Vec<f64>> = counts.iter().map(|count| lost(count, wrapping)).collect();
        let guarded: Option<Vec<f64>> = counts
            .iter()
            .map(|count| lost(count, "passes of 255"))
            .collect();
        let (wraps, guarded) = (wraps?, guarded?);
        let text = counts
            .iter()
            .zip(&wraps)
            .map(|(count, lost)| format!("{count}: {} %", significant(*lost)));
        Some(Finding {
            claim: "Eight bits that wrap lose shadows of exactly 256 and 512 casters, and passes of 255 lose none."
                .to_owned(),
            standing: Standing::holds_if(
                wraps.iter().zip(counts).all(|(lost, count)| (*lost > 0.0) == matches!(count, "256" | "512"))
                    && guarded.iter().all(|lost| *lost == 0.0),
            ),
            because: format!("Shadow pixels lost by casters: {}", text.collect::<Vec<_>>().join(", ")),
        })
    }
}
