// SPDX-License-Identifier: MIT OR Apache-2.0
//! Figures beside those of another program: a ray caster in Python, `f64`, over a port of its own.
//!
//! That port has the same kinds and counts of parts as ours. Where its cranes, ships and eyes stand is not recorded.

use super::Own;
use super::findings::{finding, joined};
use crate::metrics::*;
use crate::work::EYES;
use terrafill_plot::number::significant;
use terrafill_results::Finding;

/// Texels, m, and wrong pixels, %, of 7,178 samples.
const OTHER_CURVE: [(&str, f64); 3] = [("0.05", 0.59), ("0.25", 2.0), ("1", 3.8)];
/// Stencil writes per pixel by sun: z-pass, z-fail of infinite volumes, z-fail of those closed at the sea.
const OTHER_WRITES: [(&str, [f64; 3]); 4] = [
    ("60° from 90°", [1.2, 6.6, 2.5]),
    ("10° from -60°", [1.7, 21.7, 4.3]),
    ("5° from 0°", [12.4, 41.1, 7.5]),
    ("1° from 0°", [22.9, 39.3, 9.5]),
];
/// Eyes missed by the segment to the light, % of 400, by sun and near plane, m.
const OTHER_EYES: [(&str, [f64; 3]); 2] = [
    ("30° from -60°", [0.5, 2.0, 3.5]),
    ("5° from 0°", [1.0, 4.5, 5.5]),
];
const NEARS: [&str; 3] = ["0.1", "0.5", "1"];
/// Ports, eyes and samples differ: half as much again is the same.
const SAME: f64 = 1.5;

/// Two counts of eyes are alike if so many standard deviations apart: that of their difference is the root of their sum.
const COUNT_DEVIATIONS: f64 = 2.0;

fn is_same(own: f64, other: f64) -> bool {
    (1.0 / SAME..SAME).contains(&(own / other))
}

fn three(values: &[f64]) -> String {
    joined(values.iter().copied().map(significant), ", ").unwrap_or_default()
}

fn or_none(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), significant)
}

impl Own<'_> {
    /// Wrong pixels of maps by texel.
    pub(super) fn map_curve(&self) -> Option<Finding> {
        let of = |bias, texel: &str, metric| {
            let conditions = [(SUN, "10° from -60°"), (BIAS, bias), (TEXEL_M, texel)];
            self.value("maps", &conditions, metric)
        };
        let mut texts = Vec::new();
        let mut is_alike = true;
        for (texel, other) in OTHER_CURVE {
            let Some(own) = of("constant, no normals", texel, SHADOW_MAP_WRONG_IN_THREE) else {
                continue;
            };
            is_alike &= is_same(own, other);
            texts.push(format!(
                "{} % at {texel} m, there {other} % (all seven channels, with normals: {} %)",
                significant(own),
                or_none(of("constant", texel, MAP_WRONG))
            ));
        }
        let texts = joined(texts, "; ")?;
        Some(finding(
            "Wrong pixels of shadow maps grow with texels as another program has it, under a sun at 10°.",
            is_alike,
            format!(
                "Sea and casters in the three channels that see most of casters, best constant bias there, faces turned \
                 away from the sun ask the map: {texts}"
            ),
        ))
    }

    /// Stencil writes by rule and extent.
    pub(super) fn writes_elsewhere(&self) -> Option<Finding> {
        let mut texts = Vec::new();
        let mut is_alike = true;
        for (sun, other) in OTHER_WRITES {
            let of = |extent, rule| self.writes(sun, extent, rule);
            let infinite = of("infinite", "z-pass").zip(of("infinite", "z-fail"));
            let Some(((pass, fail), closed)) = infinite.zip(of("sea-closed", "z-fail")) else {
                continue;
            };
            let own = [pass, fail, closed];
            let mut pairs = own.iter().zip(other);
            is_alike &= pairs.all(|(own, other)| is_same(*own, other));
            texts.push(format!(
                "sun {sun}: {}, there {}; closed with what lies under the sea {}",
                three(&own),
                three(&other),
                or_none(of("sea-closed, whole hulls", "z-fail"))
            ));
        }
        let texts = joined(texts, "; ")?;
        Some(finding(
            "Stencil writes are what another program computed over a port of its own.",
            is_alike,
            format!("Per pixel, z-pass, z-fail, z-fail of volumes closed at the sea, {texts}"),
        ))
    }

    /// Eyes that the published test misses, by near plane.
    pub(super) fn eyes_elsewhere(&self) -> Option<Finding> {
        let mut texts = Vec::new();
        let mut is_alike = true;
        for (sun, other) in OTHER_EYES {
            let of = |metric| {
                let of_near = |near| {
                    let conditions = [(SUN, sun), (NEAR_M, near), (EYE_TEST, "eye")];
                    self.value("eyes", &conditions, metric)
                };
                NEARS.map(of_near).into_iter().collect::<Option<Vec<f64>>>()
            };
            let Some((any, mostly)) = of(MISSED).zip(of(MOSTLY)) else {
                continue;
            };
            is_alike &= mostly.iter().zip(other).all(|(own, other)| {
                let [own, other] = [*own, other].map(|share| share / 100.0 * EYES as f64);
                (own - other).abs() <= COUNT_DEVIATIONS * (own + other).sqrt()
            });
            let [any, mostly, other] = [&any[..], &mostly, &other].map(three);
            texts.push(format!("sun {sun}: {any}; {mostly}; there {other}"));
        }
        let texts = joined(texts, ". ")?;
        Some(finding(
            "The segment to the light leaves as many eyes on deck with most of their picture miscounted as another \
             program has it.",
            is_alike,
            format!(
                "In % of {EYES} eyes at 0.1, 0.5 and 1 m of near plane, where any part of the near rectangle is in shadow, \
                 and where more than half is. {texts}. Equal within {COUNT_DEVIATIONS} standard deviations of a count, or not"
            ),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chapter::tests::{finding, with};
    use crate::metrics::UPDATES;
    use terrafill_results::Standing;
    use terrafill_results::made_up::MadeUpRun;

    #[test]
    fn counts_of_eyes_are_alike_within_their_scatter() {
        let claim = "The segment to the light leaves";
        let standing = |at_one_metre: f64| {
            let mut run = MadeUpRun::default();
            let shares = [("0.1", 1.0), ("0.5", 4.25), ("1", at_one_metre)];
            for (near, share) in shares {
                let conditions = [("sun", "5° from 0°"), ("near_m", near), ("eye_test", "eye")];
                with("eyes", &conditions, MOSTLY, share, &mut run);
                let all = [&conditions[..], &[("copy", "any")]].concat();
                with("eyes", &all, MISSED, 1.5 * share, &mut run);
            }
            finding(&run, claim)
        };
        assert_eq!(standing(7.75), Some(Standing::Holds));
        // Negative control: 50 eyes of 400, there 22.
        assert_eq!(standing(12.5), Some(Standing::DoesNotHold));
    }

    #[test]
    fn writes_are_alike_within_half_as_much_again() {
        let standing = |closed: f64| {
            let mut run = MadeUpRun::default();
            let ways = [
                ("infinite", "z-pass", 25.0),
                ("infinite", "z-fail", 40.0),
                ("sea-closed", "z-fail", closed),
            ];
            for (extent, rule, writes) in ways {
                let conditions = [("sun", "1° from 0°"), ("extent", extent), ("rule", rule)];
                with("updates", &conditions, UPDATES, writes, &mut run);
            }
            finding(&run, "Stencil writes are what another")
        };
        assert_eq!(standing(11.0), Some(Standing::Holds));
        // Negative control: hulls that go on under the sea.
        assert_eq!(standing(22.6), Some(Standing::DoesNotHold));
    }
}
