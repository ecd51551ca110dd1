// SPDX-License-Identifier: MIT OR Apache-2.0
//! What was published, and what is measured.

use super::sections::DEVICE_KEYS;
use super::{Own, is_plain, number, value};
use crate::metrics::{FILL_CPU, FILL_GPU, LOST, MAP_WRONG, MISSED, UPDATES};
use terrafill_plot::number::significant;
use terrafill_results::{Case, Claim, Clock, Finding, Outcome, Standing, ratio};

/// Two ways of a device that differ in one condition: its key, the way said to be faster, the other one.
type Two = (&'static str, &'static str, &'static str);

const RULES: Two = ("rule", "z-pass", "z-fail");
const FACES: Two = ("faces", "two-sided", "two-pass");
const PULLED: Two = ("silhouette", "pulled", "adjacency");
const COMPUTED: Two = ("silhouette", "compute", "adjacency");
const TRIANGLES: Two = ("silhouette", "gs-adjacency", "adjacency");

/// Whether two cases have the same conditions of a device, but for some.
pub(super) fn is_same_but(keys: &[&str], a: &Case, b: &Case) -> bool {
    let mut others = DEVICE_KEYS.iter().filter(|key| !keys.contains(key));
    others.all(|key| a.condition(key) == b.condition(key))
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
            self.eye_test(),
            self.pass_is_faster(),
            self.closed_at_the_sea(),
            self.closed_and_low(),
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
        let px = ["shadow_false_lit_px", "shadow_false_dark_px"].map(|metric| value(case, metric));
        px.into_iter().try_fold(0.0, |sum, px| Some(sum + px?))
    }

    /// Cases of a question that a device drew, by whether `is_own`, and their wrong pixels.
    fn wrong_by(&self, question: &str, is_own: impl Fn(&Case) -> bool) -> [Vec<f64>; 2] {
        let mut wrong = [Vec::new(), Vec::new()];
        for case in self.of_question(question) {
            let own = &mut wrong[usize::from(is_own(case))];
            own.extend(Self::wrong_px(case));
        }
        wrong
    }

    fn near(&self) -> Option<Finding> {
        let rule = |case: &Case| case.condition("rule").to_owned();
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

    fn device_rows(&self) -> Option<Finding> {
        let is_wrapping = |case: &Case| case.condition("counting").contains("wrapping");
        let cases = self.of_question("device-rows");
        let cases: Option<Vec<(&str, bool, f64)>> = cases
            .filter(|case| matches!(case.outcome, Outcome::Ok | Outcome::Wrong))
            .map(|case| {
                Some((
                    case.condition("casters"),
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

    fn facings(&self) -> Option<Finding> {
        let by_corners = |case: &Case| case.condition("silhouette").contains("by corners");
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

    /// Every rule and extent against the reference.
    fn masks(&self) -> Option<Finding> {
        let own: Vec<&Case> = self
            .of_question("updates")
            .filter(|case| !case.condition("rule").contains("printed"))
            .collect();
        let wrong = |case: &&Case| {
            let px =
                ["shadow_false_lit_px", "shadow_false_dark_px"].map(|metric| value(case, metric));
            px.into_iter().try_fold(0.0, |sum, px| Some(sum + px?))
        };
        let all: Option<Vec<f64>> = own.iter().map(wrong).collect();
        let total: f64 = all?.iter().sum();
        (!own.is_empty()).then(|| Finding {
            claim: "Every rule and extent has the reference's mask outside the band.".to_owned(),
            standing: Standing::holds_if(total == 0.0),
            because: format!("{} pixels wrong in {} cases", significant(total), own.len()),
        })
    }

    /// Every way of drawing, by each interface.
    fn devices(&self) -> Option<Finding> {
        let own: Vec<&Case> = self.of_question("devices").collect();
        let known: Vec<&Case> = own
            .iter()
            .copied()
            .filter(|case| value(case, "shadow_false_lit_px").is_some())
            .collect();
        let right = known.iter().filter(|case| case.outcome == Outcome::Ok);
        let right = right.count();
        // By who finds the silhouettes: alike, and not.
        let (mut pairs, mut equal) = ([0; 2], [0; 2]);
        for (at, case) in known.iter().enumerate() {
            for other in &known[at + 1..] {
                if is_same_but(&["api", "silhouette"], case, other) {
                    let is_other = case.condition("silhouette") != other.condition("silhouette");
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
    fn faster(&self, clock: Clock, claim: &str, (key, fast, slow): Two) -> Option<Finding> {
        let metric = clock.pick(FILL_GPU, FILL_CPU);
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
                standings.push(Claim::Faster.standing(&gain));
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
    fn origins(&self) -> Option<Finding> {
        let mut all: Vec<(&str, [f64; 2])> = Vec::new();
        let near = self.of_question("origins");
        // From far away a pixel is wider than a step of f32, and the boundary's band has pixels of its own.
        for case in near.filter(|case| case.condition("view") != "bridge") {
            let band = value(case, "shadow_band_px");
            let Some(wrong) = Self::wrong_px(case).zip(band) else {
                continue;
            };
            let (wrong, name) = ([wrong.0, wrong.0 + wrong.1], case.condition("positions"));
            match all.iter_mut().find(|(known, _)| *known == name) {
                Some((_, most)) => *most = [0, 1].map(|at| most[at].max(wrong[at])),
                None => all.push((name, wrong)),
            }
        }
        let is_local = |name: &str| name.contains("the eye");
        let local = all.iter().find(|(name, _)| is_local(name));
        let local = local.map_or(0.0, |(_, [_, all])| *all);
        // In the band the frame of the eye has a pixel or two as well.
        let is_right = |(name, [outside, all]): &(&str, [f64; 2])| match is_local(name) {
            true => *outside == 0.0,
            false => *all > 4.0 * local.max(1.0),
        };
        let text = all.iter().map(|(name, [outside, all])| {
            format!(
                "{name}: {} and {} in the band",
                number(*outside),
                number(all - outside)
            )
        });
        (all.len() > 1).then(|| Finding {
            claim: "Places in f32 about an origin 100 km away are wrong, and about the eye right."
                .to_owned(),
            standing: Standing::holds_if(all.iter().all(is_right)),
            because: format!(
                "Wrong pixels where a rail is 1 m away, {}",
                text.collect::<Vec<_>>().join("; ")
            ),
        })
    }

    /// Under each sun and bias, by texels.
    fn maps(&self) -> Option<Finding> {
        let of_sun = |sun: &&str| {
            let mut texels: Vec<(f64, f64)> = self
                .of_question("maps")
                .filter(|case| {
                    case.condition("sun") == *sun && case.condition("bias") == "constant"
                })
                .filter_map(|case| {
                    Some((
                        case.condition("texel_m").parse().ok()?,
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

    /// Time and wrong pixels of a device's maps beside those of volumes, by sun.
    fn volumes_or_maps(&self, clock: Clock) -> Option<Finding> {
        let metric = clock.pick(FILL_GPU, FILL_CPU);
        let all_wrong = |case: &Case| {
            let px = Self::wrong_px(case)? + value(case, "shadow_band_px")?;
            Some((value(case, metric)?, px))
        };
        let mut better = Vec::new();
        let mut pairs = 0;
        for sun in self.suns("device-maps") {
            let own = |question| {
                let all = self.of_question(question);
                all.filter(move |case: &&Case| case.condition("sun") == sun)
            };
            let volumes = own("devices");
            let volumes = volumes.filter(|case| case.condition("api") == "wgpu" && is_plain(case));
            let volumes = volumes.filter_map(all_wrong).next();
            let Some((time, px)) = volumes else { continue };
            for case in own("device-maps") {
                let Some((map_time, map_px)) = all_wrong(case) else {
                    continue;
                };
                pairs += 1;
                if map_time <= time && map_px < px {
                    better.push(case.id().name.clone());
                }
            }
        }
        (pairs > 0).then(|| Finding {
            claim: "No shadow map takes less time than volumes and has fewer wrong pixels, those in the band included."
                .to_owned(),
            standing: Standing::holds_if(better.is_empty()),
            because: match better.is_empty() {
                true => format!("None of {pairs} maps does, by {}", clock.name()),
                false => format!("These do, by {}: {}", clock.name(), better.join(", ")),
            },
        })
    }

    fn eye_test(&self) -> Option<Finding> {
        let published = self.values("eyes", &[("eye_test", "eye")], MISSED);
        let exact = self.values("eyes", &[("eye_test", "near-exact")], MISSED);
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
            &[("sun", sun), ("extent", extent), ("rule", rule)],
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
                "Writes of infinite volumes over closed ones: {}",
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
            let (sun, rule) = (case.condition("sun"), case.condition("rule"));
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
        let lost = |scissor: &str| self.value("scissors", &[("scissor", scissor)], LOST);
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
            .filter(|case| case.condition("outline") == "value");
        let pairs: Option<Vec<(f64, f64)>> = all
            .map(|case| {
                Some((
                    case.condition("models").parse().ok()?,
                    value(case, "shadow_clears")?,
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
            self.value(
                "rows",
                &[("casters", casters), ("counting", counting)],
                LOST,
            )
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
