// SPDX-License-Identifier: MIT OR Apache-2.0
//! Figures beside those of another program: a ray caster in Python, `f64`, over a port of its own.
//!
//! That port has the same kinds and counts of parts as ours. Where its cranes, ships and eyes stand is not recorded.

use super::Own;
use crate::keys::{
    BIAS, EXTENT, EYE_TEST, MAP_WRONG, MISSED, MOSTLY, NEAR_M, RULE, SHADOW_MAP_WRONG_IN_THREE,
    SUN, TEXEL_M, UPDATES,
};
use crate::work::EYES;
use terrafill_plot::number::significant;
use terrafill_results::{Finding, Standing};

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
const OTHER_EYES: [(&str, [(&str, f64); 3]); 2] = [
    ("30° from -60°", [("0.1", 0.5), ("0.5", 2.0), ("1", 3.5)]),
    ("5° from 0°", [("0.1", 1.0), ("0.5", 4.5), ("1", 5.5)]),
];
/// Ports, eyes and samples differ: half as much again is the same.
const SAME: f64 = 1.5;

/// Two counts of eyes are alike if so many standard deviations apart: that of their difference is the root of their sum.
const COUNT_DEVIATIONS: f64 = 2.0;

fn is_same(own: f64, other: f64) -> bool {
    (1.0 / SAME..SAME).contains(&(own / other))
}

fn three(values: [f64; 3]) -> String {
    values.map(significant).join(", ")
}

impl Own<'_> {
    /// Wrong pixels of maps by texel.
    pub(super) fn map_curve(&self) -> Option<Finding> {
        let of = |bias, texel: &str, metric| {
            let conditions = [(SUN, "10° from -60°"), (BIAS, bias), (TEXEL_M, texel)];
            self.value("maps", &conditions, metric)
        };
        let known = OTHER_CURVE.iter().filter_map(|(texel, other)| {
            let own = of("constant, no normals", texel, SHADOW_MAP_WRONG_IN_THREE)?;
            let strict = of("constant", texel, MAP_WRONG);
            Some((*texel, own, strict, *other))
        });
        let known: Vec<(&str, f64, Option<f64>, f64)> = known.collect();
        let text = known.iter().map(|(texel, own, strict, other)| {
            let strict = strict.map_or_else(|| "–".to_owned(), significant);
            format!(
                "{} % at {texel} m, there {other} % (all seven channels, with normals: {strict} %)",
                significant(*own)
            )
        });
        (!known.is_empty()).then(|| Finding {
            claim: "Wrong pixels of shadow maps grow with texels as another program has it, under a sun at 10°."
                .to_owned(),
            standing: Standing::holds_if(known.iter().all(|(_, own, _, other)| is_same(*own, *other))),
            because: format!(
                "Sea and casters in the three channels that see most of casters, best constant bias there, faces turned away \
                 from the sun ask the map: {}",
                text.collect::<Vec<_>>().join("; ")
            ),
        })
    }

    /// Stencil writes by rule and extent.
    pub(super) fn writes_elsewhere(&self) -> Option<Finding> {
        let known = OTHER_WRITES.iter().filter_map(|(sun, other)| {
            let of = |extent, rule| {
                let conditions = [(SUN, *sun), (EXTENT, extent), (RULE, rule)];
                self.value("updates", &conditions, UPDATES)
            };
            let own = [
                of("infinite", "z-pass")?,
                of("infinite", "z-fail")?,
                of("sea-closed", "z-fail")?,
            ];
            Some((*sun, own, *other, of("sea-closed, whole hulls", "z-fail")))
        });
        let known: Vec<_> = known.collect();
        let is_near = |(_, own, other, _): &(&str, [f64; 3], [f64; 3], _)| {
            own.iter()
                .zip(other)
                .all(|(own, other)| is_same(*own, *other))
        };
        let text = known.iter().map(|(sun, own, other, whole)| {
            let whole = whole.map_or_else(|| "–".to_owned(), significant);
            let own = three(*own);
            format!(
                "sun {sun}: {own}, there {}; closed with what lies under the sea {whole}",
                three(*other)
            )
        });
        (!known.is_empty()).then(|| Finding {
            claim: "Stencil writes are what another program computed over a port of its own."
                .to_owned(),
            standing: Standing::holds_if(known.iter().all(is_near)),
            because: format!(
                "Per pixel, z-pass, z-fail, z-fail of volumes closed at the sea, {}",
                text.collect::<Vec<_>>().join("; ")
            ),
        })
    }

    /// Eyes that the published test misses, by near plane.
    pub(super) fn eyes_elsewhere(&self) -> Option<Finding> {
        let of = |sun, near, metric| {
            let conditions = [(SUN, sun), (NEAR_M, near), (EYE_TEST, "eye")];
            self.value("eyes", &conditions, metric)
        };
        let known = OTHER_EYES.iter().filter_map(|(sun, others)| {
            let own = |metric| others.map(|(near, _)| of(*sun, near, metric));
            let [Some(a), Some(b), Some(c)] = own(MISSED) else {
                return None;
            };
            let [Some(d), Some(e), Some(f)] = own(MOSTLY) else {
                return None;
            };
            Some((*sun, [a, b, c], [d, e, f], others.map(|(_, other)| other)))
        });
        let known: Vec<_> = known.collect();
        let is_near = |(_, _, mostly, other): &(&str, [f64; 3], [f64; 3], [f64; 3])| {
            mostly.iter().zip(other).all(|(own, other)| {
                let [own, other] = [own, other].map(|share| share / 100.0 * EYES as f64);
                (own - other).abs() <= COUNT_DEVIATIONS * (own + other).sqrt()
            })
        };
        let text = known.iter().map(|(sun, any, mostly, other)| {
            let [any, mostly, other] = [any, mostly, other].map(|values| three(*values));
            format!("sun {sun}: {any}; {mostly}; there {other}")
        });
        (!known.is_empty()).then(|| Finding {
            claim: "The segment to the light leaves as many eyes on deck with most of their picture miscounted as another \
                    program has it."
                .to_owned(),
            standing: Standing::holds_if(known.iter().all(is_near)),
            because: format!(
                "In % of {EYES} eyes at 0.1, 0.5 and 1 m of near plane, where any part of the near rectangle is in shadow, and \
                 where more than half is. {}. Equal within {COUNT_DEVIATIONS} standard deviations of a count, or not",
                text.collect::<Vec<_>>().join(". ")
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chapter::tests::{finding, with};
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
        // Twin: 50 eyes of 400, there 22.
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
        // Twin: hulls that go on under the sea.
        assert_eq!(standing(22.6), Some(Standing::DoesNotHold));
    }
}
