// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured of volumes and maps that devices drew.

use super::Own;
use super::findings::{finding, is_multiple, joined, number};
use super::times::is_same_but;
use crate::metrics::*;
use terrafill_lab::{grouped, measured};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Finding, Outcome};

impl Own<'_> {
    /// Cases of a question that a device drew, by whether `is_own`, and their wrong pixels.
    fn wrong_by(&self, question: &str, is_own: impl Fn(&Case) -> bool) -> [Vec<f64>; 2] {
        let mut wrong = [Vec::new(), Vec::new()];
        for case in self.of_question(question) {
            let own = &mut wrong[usize::from(is_own(case))];
            own.extend(Self::wrong_px(case));
        }
        wrong
    }

    pub(super) fn near(&self) -> Option<Finding> {
        let is_published = |case: &Case| {
            matches!(
                case.condition(RULE),
                "z-pass" | "automatic, eye" | "automatic, eye-model"
            )
        };
        let [others, published] = self.wrong_by("near", is_published);
        let most = published.into_iter().reduce(f64::max)?;
        let total: f64 = others.iter().sum();
        (!others.is_empty()).then(|| {
            finding(
                "Where the near plane is partly in shadow, zp-plus, preload, z-fail and tests of the near rectangle \
                 draw no wrong pixel on a device, and z-pass does.",
                total == 0.0 && most > 0.0,
                format!(
                    "{} pixels outside the band are wrong in {} cases; z-pass, which the eye's test chooses, has {}",
                    number(total),
                    others.len(),
                    number(most)
                ),
            )
        })
    }

    pub(super) fn device_rows(&self) -> Option<Finding> {
        let cases = self.of_question("device-rows");
        let known = cases.filter_map(|case| Some((case, measured(case, LOST)?)));
        let known: Vec<(&Case, f64)> = known.collect();
        let is_as_computed = |(case, lost): &(&Case, f64)| {
            let wraps = case.condition(COUNTING).contains("wrapping");
            (*lost > 0.0) == (wraps && is_multiple(case.condition(CASTERS)))
        };
        let losing = known.iter().filter(|(_, lost)| *lost > 0.0);
        let losing = losing
            .map(|(case, lost)| format!("{}: {} %", case.condition(CASTERS), significant(*lost)));
        let losing = joined(losing, ", ").unwrap_or_else(|| "none".to_owned());
        (!known.is_empty()).then(|| {
            finding(
                "On a device, 8 bits lose shadows of exactly 256 and 512 casters, and passes of 255 lose none.",
                known.iter().all(is_as_computed),
                format!("Of {} cases these lose shadow pixels: {losing}", known.len()),
            )
        })
    }

    pub(super) fn facings(&self) -> Option<Finding> {
        let by_corners = |case: &Case| case.condition(SILHOUETTE).contains("by corners");
        let [bits, corners] = self.wrong_by("facings", by_corners);
        let most = corners.into_iter().reduce(f64::max)?;
        let total: f64 = bits.iter().sum();
        (!bits.is_empty()).then(|| {
            finding(
                "A facing decided once a triangle never leaks, one that each edge computes in f32 does.",
                total == 0.0 && most > 0.0,
                format!(
                    "{} wrong pixels outside the band in {} cases with facing bits, up to {} in those without",
                    number(total),
                    bits.len(),
                    number(most)
                ),
            )
        })
    }

    /// Every way of drawing, by each interface.
    pub(super) fn devices(&self) -> Option<Finding> {
        let own = self.of_question("devices");
        let own = own.filter(|case| measured(case, SHADOW_FALSE_LIT_PX).is_some());
        let known: Vec<&Case> = own.collect();
        let right = known.iter().filter(|case| case.outcome == Outcome::Ok);
        let right = right.count();
        // By who finds the silhouettes: alike, and not.
        let (mut pairs, mut equal) = ([0; 2], [0; 2]);
        for (at, case) in known.iter().enumerate() {
            for other in &known[at + 1..] {
                if is_same_but(&[API, SILHOUETTE], case, other) {
                    let is_other = case.condition(SILHOUETTE) != other.condition(SILHOUETTE);
                    let kind = usize::from(is_other);
                    pairs[kind] += 1;
                    equal[kind] += u32::from(case.note("mask_hash") == other.note("mask_hash"));
                }
            }
        }
        (!known.is_empty()).then(|| {
            finding(
                "Devices draw the reference's shadows outside the band, and each interface the same mask.",
                right == known.len() && equal[0] == pairs[0],
                format!(
                    "{right} of {} cases right; masks are equal in {} of {} pairs of interfaces, and in {} of {} pairs of ways to \
                     find silhouettes: geometry shaders' sides begin with another corner, and round otherwise in the band",
                    known.len(),
                    equal[0],
                    pairs[0],
                    equal[1],
                    pairs[1]
                ),
            )
        })
    }

    /// Wrong pixels by what vertices count from.
    pub(super) fn origins(&self) -> Option<Finding> {
        // From the bridge a pixel is wider than a step of f32 at 100 km.
        let near = self.of_question("origins");
        let near = near.filter(|case| case.condition(VIEW) != "bridge");
        let wrong = near.filter_map(|case| {
            let band = measured(case, SHADOW_BAND_PX)?;
            Some((case.condition(POSITIONS), [Self::wrong_px(case)?, band]))
        });
        let all = grouped(wrong, |(name, _)| *name).into_iter();
        let most = |(name, own): (_, Vec<(&str, [f64; 2])>)| {
            let most = |at: usize| own.iter().map(|(_, px)| px[at]).fold(0.0, f64::max);
            (name, [most(0), most(1)])
        };
        let all: Vec<(&str, [f64; 2])> = all.map(most).collect();
        let is_right =
            |(name, [outside, _]): &(&str, [f64; 2])| (*outside == 0.0) == name.contains("the eye");
        let text = all.iter().map(|(name, most)| {
            let [outside, band] = most.map(number);
            format!("{name}: {outside} and {band} in the band")
        });
        let text = joined(text, "; ").filter(|_| all.len() > 1)?;
        Some(finding(
            "Places in f32 about an origin 100 km away are wrong, and about the eye right.",
            all.iter().all(is_right),
            format!("Most wrong pixels of views in which a rail or its shadow is 1 m away, {text}"),
        ))
    }
}
