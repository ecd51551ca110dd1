// SPDX-License-Identifier: MIT OR Apache-2.0
//! What was published, and what is measured.

use super::Own;
use crate::metrics::*;
use terrafill_lab::{measured, none_differs, range};
use terrafill_plot::number::{count, significant};
use terrafill_results::{Case, ConditionKey, Finding};

/// Negative controls that must be wrong: name, question, and the condition that tells them.
const CONTROLS: [(&str, &str, ConditionKey, &str); 13] = [
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
    (
        "ends of a lamp's volumes at its range",
        "lights",
        LIMIT,
        "volumes' corners end at it",
    ),
    (
        "a scissor of half a lamp",
        "lights",
        LIMIT,
        "scissor of half of it",
    ),
    ("the eye's test there", "near", RULE, "automatic, eye"),
    ("the same by model", "near", RULE, "automatic, eye-model"),
];

/// Pixels, with every digit.
#[allow(
    clippy::cast_possible_truncation,
    reason = "whole, positive and below 2⁵³"
)]
pub(super) fn number(px: f64) -> String {
    count(px as u64)
}

/// In one text; `None` where there is nothing.
pub(super) fn joined(texts: impl IntoIterator<Item = String>, between: &str) -> Option<String> {
    let texts: Vec<String> = texts.into_iter().collect();
    (!texts.is_empty()).then(|| texts.join(between))
}

pub(super) fn finding(claim: &str, holds: bool, because: String) -> Finding {
    terrafill_lab::finding(claim, Some(holds), because)
}

impl<'a> Own<'a> {
    pub(super) fn findings(&self) -> Vec<Finding> {
        let of_masks = [
            self.masks(),
            self.eye_test(),
            self.eyes_elsewhere(),
            self.pass_is_faster(),
            self.closed_at_the_sea(),
            self.closed_and_low(),
            self.writes_elsewhere(),
            self.bounds(),
            self.bounds_of_parts(),
            self.beyond_the_range(),
            self.above_the_sea(),
            self.below_the_sea_level(),
            self.wrap(),
            self.devices(),
        ];
        let of_pixels = [
            self.near(),
            self.device_rows(),
            self.facings(),
            self.origins(),
            self.maps(),
            self.map_curve(),
            self.volumes_or_maps(),
            self.equal_error(),
            self.limits(),
            self.limited(),
        ];
        let of_times = self.times();
        let of_outlines = terrafill_outlines::findings(&self.question("outlines")).into_iter();
        let all = of_masks.into_iter().chain(of_times).chain(of_pixels);
        all.flatten().chain(of_outlines).collect()
    }

    /// Wrong pixels of a case, outside the band.
    pub(super) fn wrong_px(case: &Case) -> Option<f64> {
        Some(measured(case, SHADOW_FALSE_LIT_PX)? + measured(case, SHADOW_FALSE_DARK_PX)?)
    }

    /// What must be wrong, and by how much it is.
    pub(super) fn controls(&self) -> Option<Finding> {
        let of = |(name, question, key, control): &(&'static str, &str, ConditionKey, &str)| {
            let all = self.of_question(question);
            let own = all.filter(|case| case.condition(*key) == *control);
            let wrong = own.filter_map(|case| {
                let of = |metric| measured(case, metric);
                let other = of(SHADOW_CONTOUR_PX).or_else(|| of(SHADOW_OPEN_EDGES));
                other.or_else(|| Self::wrong_px(case))
            });
            Some((*name, wrong.reduce(f64::max)?))
        };
        let known: Vec<(&str, f64)> = CONTROLS.iter().filter_map(of).collect();
        let (wrong, right): (Vec<_>, Vec<_>) = known.iter().partition(|(_, most)| *most > 0.0);
        let right: Vec<String> = right.iter().map(|(name, _)| (*name).to_owned()).collect();
        let most = wrong.iter();
        let most = most.map(|(name, most)| format!("{name}: {}", number(*most)));
        let what = joined(most, ", ").map_or_else(
            || "are".to_owned(),
            |most| format!("are, at most by so many pixels, contour pixels or open edges: {most}"),
        );
        let claim = "Pictures and hulls that must be wrong are wrong.";
        (!known.is_empty()).then(|| none_differs(claim, known.len(), &right, &what))
    }

    /// Every rule and extent against the reference.
    fn masks(&self) -> Option<Finding> {
        let own = self.of_question("updates");
        let own = own.filter(|case| !case.condition(RULE).contains("printed"));
        let all: Option<Vec<f64>> = own.map(Self::wrong_px).collect();
        let all = all.filter(|all| !all.is_empty())?;
        let total: f64 = all.iter().sum();
        Some(finding(
            "Every rule and extent has the reference's mask outside the band.",
            total == 0.0,
            format!("{} pixels wrong in {} cases", significant(total), all.len()),
        ))
    }

    /// Under each sun and bias, by texels.
    fn maps(&self) -> Option<Finding> {
        let of_sun = |sun: &&str| {
            let own = self
                .question("maps")
                .with(&[(SUN, *sun), (BIAS, "constant")]);
            own.series(TEXEL_M, MAP_WRONG)
        };
        let suns = self.suns("maps");
        let all: Vec<Vec<(f64, f64)>> = suns.iter().map(of_sun).collect();
        let falls = |texels: &Vec<(f64, f64)>| {
            let is_wrong = texels.iter().all(|(_, wrong)| *wrong > 0.0);
            is_wrong && texels.is_sorted_by(|a, b| a.1 <= b.1)
        };
        let text = suns.iter().zip(&all).map(|(sun, texels)| {
            let point =
                |(texel, wrong): &(f64, f64)| format!("{} % at {texel} m", significant(*wrong));
            let points: Vec<String> = texels.iter().map(point).collect();
            format!("sun {sun}: {}", points.join(", "))
        });
        let text: Vec<String> = text.collect();
        all.iter().any(|texels| texels.len() > 1).then(|| {
            finding(
                "Smaller texels leave fewer wrong pixels of a shadow map, and none of them leaves none.",
                all.iter().all(falls),
                format!("Best constant bias, {}", text.join("; ")),
            )
        })
    }

    fn eye_test(&self) -> Option<Finding> {
        let by = |test| self.question("eyes").with(&[(EYE_TEST, test)]);
        let published = by("eye").values(MISSED);
        let most = by("eye").greatest(MISSED)?;
        let missed = by("near-exact").greatest(MISSED)?;
        Some(finding(
            "The segment from the eye to the light says where z-pass is right (Yang & Jin, 2006, anticipated).",
            most == 0.0,
            format!(
                "It misses {} % of the eyes on deck; the near rectangle tested exactly misses {} %",
                range(&published)?,
                significant(missed)
            ),
        ))
    }

    /// Writes of a rule and extent under a sun.
    pub(super) fn writes(&self, sun: &str, extent: &str, rule: &str) -> Option<f64> {
        let conditions = [(SUN, sun), (EXTENT, extent), (RULE, rule)];
        self.value("updates", &conditions, UPDATES)
    }

    fn pass_is_faster(&self) -> Option<Finding> {
        let suns = self.suns("updates");
        let ratios = |extent: &str| -> Option<Vec<f64>> {
            let of = |sun: &&str| {
                Some(self.writes(sun, extent, "z-fail")? / self.writes(sun, extent, "z-pass")?)
            };
            suns.iter().map(of).collect()
        };
        let (infinite, closed) = (ratios("infinite")?, ratios("sea-closed")?);
        Some(finding(
            "z-pass writes less than z-fail (Yang & Jin, 2006, anticipated).",
            infinite.iter().chain(&closed).all(|ratio| *ratio > 1.0),
            format!(
                "z-fail over z-pass: {} for infinite volumes, {} for those closed at the sea",
                range(&infinite)?,
                range(&closed)?
            ),
        ))
    }

    fn closed_at_the_sea(&self) -> Option<Finding> {
        let mut texts = Vec::new();
        let mut is_less = true;
        for sun in self.suns("updates") {
            let of = |extent| self.writes(sun, extent, "z-fail");
            let (infinite, closed) = (of("infinite")?, of("sea-closed")?);
            is_less &= closed < infinite;
            let calm = of("sea-closed, calm").map_or_else(String::new, |calm| {
                format!(" (calm sea: {})", significant(infinite / calm))
            });
            texts.push(format!("{}{calm} at {sun}", significant(infinite / closed)));
        }
        Some(finding(
            "Closing volumes at the sea saves stencil writes of z-fail.",
            is_less,
            format!(
                "Writes of infinite volumes over those of volumes closed at the sea, whose casters are cut there too: {}",
                texts.join(", ")
            ),
        ))
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
        let texts = joined(texts, ", ")?;
        Some(finding(
            "Under suns at 5° and below along the dock, z-fail of volumes closed at the sea writes less than z-pass.",
            is_less,
            format!("Writes per pixel: {texts}"),
        ))
    }

    fn bounds(&self) -> Option<Finding> {
        let mut texts = Vec::new();
        let mut is_less = true;
        for case in self.with_bounds(&["on", "on, one range"], "") {
            let (sun, rule) = (case.condition(SUN), case.condition(RULE));
            let whole = self.writes(sun, "sea-closed", rule)?;
            let within = measured(case, UPDATES)?;
            is_less &= within < whole;
            let of = match case.condition(DEPTH_BOUNDS) {
                "on" => "",
                _ => ", one range",
            };
            let [whole, within] = [whole, within].map(significant);
            texts.push(format!("{rule} at {sun}{of}: {whole} to {within}"));
        }
        let texts = joined(texts, ", ")?;
        Some(finding(
            "Depth bounds save stencil writes (Yang & Jin, 2006, anticipated).",
            is_less,
            format!("Writes per pixel, {texts}"),
        ))
    }

    /// Cases by whose the bounds are and which pixels count.
    fn with_bounds(&self, bounds: &[&str], counted: &str) -> Vec<&'a Case> {
        let all = self.of_question("bounds");
        let own = all.filter(|case| {
            bounds.contains(&case.condition(DEPTH_BOUNDS)) && case.condition(COUNTED) == counted
        });
        own.collect()
    }

    fn bounds_of_parts(&self) -> Option<Finding> {
        let own = self.with_bounds(&["on"], "");
        let wrong: Option<Vec<f64>> = own.into_iter().map(Self::wrong_px).collect();
        let wrong = wrong.filter(|wrong| !wrong.is_empty())?;
        let total: f64 = wrong.iter().sum();
        Some(finding(
            "Depth bounds that are those of each part's own volume change no pixel.",
            total == 0.0,
            format!(
                "{} pixels outside the band are wrong in {} cases",
                number(total),
                wrong.len()
            ),
        ))
    }

    /// Figure 6: a shadowed point beyond the range loses its fragment.
    fn beyond_the_range(&self) -> Option<Finding> {
        let figures = |counted, metric| -> Option<Vec<f64>> {
            let own = self.with_bounds(&["on, one range"], counted).into_iter();
            let all: Option<Vec<f64>> = own.map(|case| measured(case, metric)).collect();
            all.filter(|all| !all.is_empty())
        };
        let lost = figures("", LOST)?;
        let inside = self.with_bounds(&["on, one range"], "in the range");
        let inside: Option<Vec<f64>> = inside.into_iter().map(Self::wrong_px).collect();
        let inside: f64 = inside?.iter().sum();
        let is_any = lost.iter().any(|share| *share > 0.0);
        Some(finding(
            "One range of depths drops shadowed points beyond it, and leaves those within as they are (Yang & Jin, 2006, observed).",
            is_any && inside == 0.0,
            format!(
                "From the nearest to the farthest that a channel shows above the sea: {} % of the shadow pixels are lost, and {} \
                 pixels within the range are wrong outside the band",
                range(&lost)?,
                number(inside)
            ),
        ))
    }

    /// Shadow pixels lost by a scissor, of those that count, %.
    fn scissored(&self, scissor: &str, counted: &str) -> Option<f64> {
        let conditions = [(SCISSOR, scissor), (COUNTED, counted)];
        self.value("scissors", &conditions, LOST)
    }

    fn above_the_sea(&self) -> Option<Finding> {
        let lost = |scissor| self.scissored(scissor, "above the sea");
        let (own, horizon) = (lost("sea-level")?, lost("horizon")?);
        Some(finding(
            "A scissor to the range drawn above sea level loses no shadow above sea level (Yang & Jin, 2006, considered).",
            own == 0.0,
            format!(
                "It loses {} % of the shadow pixels above the sea. Rows above the horizon, which the paper does not say, lose {} %",
                significant(own),
                significant(horizon)
            ),
        ))
    }

    fn below_the_sea_level(&self) -> Option<Finding> {
        let lost = |scissor| self.scissored(scissor, "");
        let (own, caster) = (lost("sea-level")?, lost("caster-rect")?);
        Some(finding(
            "Beyond the range drawn above sea level there is no shadow (Yang & Jin, 2006, considered).",
            own == 0.0,
            format!(
                "{} % of all shadow pixels lie beyond it, on the sea; rectangles of casters lose {} %",
                significant(own),
                significant(caster)
            ),
        ))
    }

    fn wrap(&self) -> Option<Finding> {
        let counts = ["255", "256", "257", "511", "512"];
        let lost = |counting: &str| -> Option<Vec<f64>> {
            let of = |casters: &&str| {
                let conditions = [(CASTERS, *casters), (COUNTING, counting)];
                self.value("rows", &conditions, LOST)
            };
            counts.iter().map(of).collect()
        };
        let (wraps, guarded) = (lost("8 bits, wrapping")?, lost("passes of 255")?);
        let all = || counts.iter().zip(&wraps);
        let text = all().map(|(count, lost)| format!("{count}: {} %", significant(*lost)));
        let text: Vec<String> = text.collect();
        let wraps = all().all(|(count, lost)| (*lost > 0.0) == is_multiple(count));
        Some(finding(
            "Eight bits that wrap lose shadows of exactly 256 and 512 casters, and passes of 255 lose none.",
            wraps && guarded.iter().all(|lost| *lost == 0.0),
            format!("Shadow pixels lost by casters: {}", text.join(", ")),
        ))
    }
}

/// Of what 8 bits count.
pub(super) fn is_multiple(casters: &str) -> bool {
    matches!(casters, "256" | "512")
}
