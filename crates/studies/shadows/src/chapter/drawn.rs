// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured of volumes and maps that devices drew.

use super::findings::{Two, is_same_but, of_all};
use super::{Own, is_plain, number, value};
use crate::keys::{
    API, CASTERS, COUNTING, FILL_CPU, FILL_GPU, LOST, POSITIONS, RULE, SHADOW_BAND_PX,
    SHADOW_FALSE_LIT_PX, SILHOUETTE, SUN, VIEW,
};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Clock, Finding, Outcome, Standing, ratio};

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
        let rule = |case: &Case| case.condition(RULE).to_owned();
        let is_published = |case: &Case| rule(case) == "automatic, eye";
        let [others, published] =
            self.wrong_by("near", |case| rule(case) == "z-pass" || is_published(case));
        let most = published.iter().copied().reduce(f64::max)?;
        let total: f64 = others.iter().sum();
        (!others.is_empty()).then(|| Finding {
            claim: "Where the near plane is partly in shadow, zp-plus, preload, z-fail and tests of the near rectangle \
                    draw no wrong pixel on a device, and z-pass does."
                .to_owned(),
            standing: Standing::holds_if(total == 0.0 && most > 0.0),
            because: format!(
                "{} pixels outside the band are wrong in {} cases; z-pass, which the eye's test chooses, has {}",
                number(total),
                others.len(),
                number(most)
            ),
        })
    }

    pub(super) fn device_rows(&self) -> Option<Finding> {
        let is_wrapping = |case: &Case| case.condition(COUNTING).contains("wrapping");
        let cases = self.of_question("device-rows");
        let cases: Option<Vec<(&str, bool, f64)>> = cases
            .filter(|case| matches!(case.outcome, Outcome::Ok | Outcome::Wrong))
            .map(|case| {
                Some((
                    case.condition(CASTERS),
                    is_wrapping(case),
                    value(case, LOST)?,
                ))
            })
            .collect();
        let cases = cases.filter(|cases| !cases.is_empty())?;
        let is_multiple = |casters: &str| matches!(casters, "256" | "512");
        let as_computed = cases.iter().all(|(casters, is_wrapping, lost)| {
            (*lost > 0.0) == (*is_wrapping && is_multiple(casters))
        });
        let losing = cases.iter().filter(|(.., lost)| *lost > 0.0);
        let losing: Vec<String> = losing
            .map(|(casters, _, lost)| format!("{casters}: {} %", significant(*lost)))
            .collect();
        Some(Finding {
            claim: "On a device, 8 bits lose shadows of exactly 256 and 512 casters, and passes of 255 lose none."
                .to_owned(),
            standing: Standing::holds_if(as_computed),
            because: format!(
                "Of {} cases these lose shadow pixels: {}",
                cases.len(),
                match losing.is_empty() {
                    true => "none".to_owned(),
                    false => losing.join(", "),
                }
            ),
        })
    }

    pub(super) fn facings(&self) -> Option<Finding> {
        let by_corners = |case: &Case| case.condition(SILHOUETTE).contains("by corners");
        let [bits, corners] = self.wrong_by("facings", by_corners);
        let most = corners.iter().copied().reduce(f64::max)?;
        let total: f64 = bits.iter().sum();
        (!bits.is_empty()).then(|| Finding {
            claim: "A facing decided once a triangle never leaks, one that each edge computes in f32 does.".to_owned(),
            standing: Standing::holds_if(total == 0.0 && most > 0.0),
            because: format!(
                "{} wrong pixels outside the band in {} cases with facing bits, up to {} in those without",
                number(total),
                bits.len(),
                number(most)
            ),
        })
    }

    /// Every way of drawing, by each interface.
    pub(super) fn devices(&self) -> Option<Finding> {
        let own: Vec<&Case> = self.of_question("devices").collect();
        let known: Vec<&Case> = own
            .iter()
            .copied()
            .filter(|case| value(case, SHADOW_FALSE_LIT_PX).is_some())
            .collect();
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
        (!known.is_empty()).then(|| Finding {
            claim: "Devices draw the reference's shadows outside the band, and each interface the same mask."
                .to_owned(),
            standing: Standing::holds_if(right == known.len() && equal[0] == pairs[0]),
            because: format!(
                "{right} of {} cases right; masks are equal in {} of {} pairs of interfaces, and in {} of {} pairs of ways to \
                 find silhouettes: geometry shaders' sides begin with another corner, and round otherwise in the band",
                known.len(),
                equal[0],
                pairs[0],
                equal[1],
                pairs[1]
            ),
        })
    }

    /// Whether one way takes less time than another, under each sun and by each interface.
    pub(super) fn faster(
        &self,
        clock: Clock,
        claim: &str,
        (key, fast, slow): Two,
    ) -> Option<Finding> {
        let metric = clock.pick(FILL_GPU, FILL_CPU);
        let noise = self.noise(metric);
        let of = |way: &'static str| {
            let all = self.of_question("devices");
            all.filter(move |case| case.condition(key) == way && case.outcome == Outcome::Ok)
        };
        let mut gains = Vec::new();
        let mut standings = Vec::new();
        for case in of(fast) {
            let twin = of(slow).find(|other| is_same_but(&[key], case, other));
            if let Some(gain) = twin.and_then(|other| ratio(other, case, metric)) {
                gains.push(gain.middle);
                standings.push(Standing::of_times(&gain, noise).0);
            }
        }
        let count = |wanted: Standing| standings.iter().filter(|own| **own == wanted).count();
        let (slower, open) = (count(Standing::DoesNotHold), count(Standing::CannotTell));
        let least = gains.iter().copied().reduce(f64::min)?;
        let most = gains.iter().copied().reduce(f64::max)?;
        Some(Finding {
            claim: format!("{claim} (Yang & Jin, 2006, anticipated)."),
            standing: of_all(&standings),
            because: format!(
                "{} to {} times as fast by {}. Of {} pairs {} are faster, {slower} not, {open} undecided",
                significant(least),
                significant(most),
                clock.name(),
                gains.len(),
                count(Standing::Holds),
            ),
        })
    }

    /// Wrong pixels by what vertices count from.
    pub(super) fn origins(&self) -> Option<Finding> {
        let mut all: Vec<(&str, [f64; 2])> = Vec::new();
        let near = self.of_question("origins");
        // From the bridge a pixel is wider than a step of f32 at 100 km.
        for case in near.filter(|case| case.condition(VIEW) != "bridge") {
            let band = value(case, SHADOW_BAND_PX);
            let Some((outside, band)) = Self::wrong_px(case).zip(band) else {
                continue;
            };
            let name = case.condition(POSITIONS);
            match all.iter_mut().find(|(known, _)| *known == name) {
                Some((_, [most, in_band])) => {
                    (*most, *in_band) = (most.max(outside), in_band.max(band));
                }
                None => all.push((name, [outside, band])),
            }
        }
        let is_right =
            |(name, [outside, _]): &(&str, [f64; 2])| (*outside == 0.0) == name.contains("the eye");
        let text = all.iter().map(|(name, [outside, band])| {
            format!(
                "{name}: {} and {} in the band",
                number(*outside),
                number(*band)
            )
        });
        (all.len() > 1).then(|| Finding {
            claim: "Places in f32 about an origin 100 km away are wrong, and about the eye right."
                .to_owned(),
            standing: Standing::holds_if(all.iter().all(is_right)),
            because: format!(
                "Most wrong pixels of views in which a rail or its shadow is 1 m away, {}",
                text.collect::<Vec<_>>().join("; ")
            ),
        })
    }

    /// Time and wrong pixels of a device's maps beside those of volumes, by sun.
    pub(super) fn volumes_or_maps(&self, clock: Clock) -> Option<Finding> {
        let metric = clock.pick(FILL_GPU, FILL_CPU);
        // Of what was timed.
        let all_wrong = |case: &Case| {
            value(case, metric)?;
            Some(Self::wrong_px(case)? + value(case, SHADOW_BAND_PX)?)
        };
        let noise = self.noise(metric);
        let (mut better, mut open) = (Vec::new(), Vec::new());
        let mut pairs = 0;
        for sun in self.suns("device-maps") {
            let own = |question| {
                let all = self.of_question(question);
                all.filter(move |case: &&Case| case.condition(SUN) == sun)
            };
            let volumes = own("devices");
            let volumes = volumes.filter(|case| case.condition(API) == "wgpu" && is_plain(case));
            let mut volumes = volumes.filter_map(|case| Some((case, all_wrong(case)?)));
            let Some((volumes, px)) = volumes.next() else {
                continue;
            };
            for case in own("device-maps") {
                let Some(map_px) = all_wrong(case) else {
                    continue;
                };
                pairs += 1;
                if map_px >= px {
                    continue;
                }
                let gain = ratio(volumes, case, metric);
                let judged = gain.map(|gain| Standing::of_times(&gain, noise).0);
                match judged {
                    Some(Standing::Holds) => better.push(case.id().name.clone()),
                    Some(Standing::DoesNotHold) => {}
                    _ => open.push(case.id().name.clone()),
                }
            }
        }
        (pairs > 0).then(|| Finding {
            claim: "No shadow map takes less time than volumes and has fewer wrong pixels, those in the band included."
                .to_owned(),
            standing: match (better.as_slice(), open.as_slice()) {
                ([], []) => Standing::Holds,
                ([], _) => Standing::CannotTell,
                _ => Standing::DoesNotHold,
            },
            because: match (better.as_slice(), open.as_slice()) {
                ([], []) => format!("None of {pairs} maps does, by {}", clock.name()),
                ([], open) => format!(
                    "Of {pairs} maps these have fewer wrong pixels, and whether they take less {} cannot be told: {}",
                    clock.name(),
                    open.join(", ")
                ),
                (better, _) => format!("These do, by {}: {}", clock.name(), better.join(", ")),
            },
        })
    }
}
