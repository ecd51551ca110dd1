// SPDX-License-Identifier: MIT OR Apache-2.0
//! The ladder chapter: what each switch gives on the way from the method of 2007 to the full plan, and
//! whether what was found then is still found.
//!
//! A rung is held against the last one before it whose picture is right. Findings are compared with
//! the measured interval; nothing here knows what came out.

use crate::glossary;
use crate::interval::{Claim, Interval, Standing, gain};
use crate::number::{bytes, count, significant};
use crate::page::breakable;
use crate::run_data::{Case, Outcome, RunData};
use terrafill_results::legacy::{CaseKey, LadderRung, Summary};

/// What Cozzi (2007) found for a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Finding {
    /// The step that repeats the experiment.
    pub(crate) step: &'static str,
    /// In one sentence.
    pub(crate) sentence: &'static str,
    /// The same as a claim about the gain.
    pub(crate) claim: Claim,
}

/// Findings in the document's own order.
pub(crate) const FINDINGS: [Finding; 7] = [
    Finding {
        step: "back-faces",
        sentence: "Culling back faces in the colour pass was kept as a gain.",
        claim: Claim::Faster,
    },
    Finding {
        step: "buffer-layout",
        sentence: "How the flag was laid out in buffers made no difference.",
        claim: Claim::Nothing,
    },
    Finding {
        step: "strips",
        sentence: "Strips instead of lists made no difference.",
        claim: Claim::Nothing,
    },
    Finding {
        step: "cache-order",
        sentence: "Ordering triangles for the vertex cache made no difference.",
        claim: Claim::Nothing,
    },
    Finding {
        step: "vertex-size",
        sentence: "Smaller vertices made no difference.",
        claim: Claim::Nothing,
    },
    Finding {
        step: "bottom-cap",
        sentence: "Leaving the bottom cap out was kept as a gain.",
        claim: Claim::Faster,
    },
    Finding {
        step: "z-pass",
        sentence: "Counting fragments in front of the surface was faster than behind it.",
        claim: Claim::Faster,
    },
];

/// Where the findings come from, as printed.
pub(crate) const SOURCE: &str = "Cozzi (2007)";

/// The view whose limit was fill rate.
const FILL_RATE_VIEW: &str = "horizon";

const FILL_RATE_SENTENCE: &str =
    "Along the horizon fill rate is the limit, not the number of vertices.";

/// Fragments that differ by less than this factor are the same work.
const SAME_FRAGMENTS: f64 = 1.05;

/// Fewest times fewer vertices from which a view can show whether they are the limit.
const FEWER_VERTICES: f64 = 1.2;

/// One table: a ladder on one view.
pub(crate) struct LadderTable {
    pub(crate) title: String,
    pub(crate) scene: String,
    pub(crate) view: String,
    pub(crate) ladder: String,
    pub(crate) headings: Vec<(&'static str, String)>,
    pub(crate) rows: Vec<RungRow>,
    /// First and last right rung over bound, total gain, and the step that gave most.
    pub(crate) overview: [String; 4],
    /// What is said above the table.
    pub(crate) sentences: Vec<String>,
    /// Rungs without a result, and gaps in the numbering, by name.
    pub(crate) missing: Vec<String>,
    pub(crate) plot: Option<String>,
}

/// One rung as printed.
pub(crate) struct RungRow {
    pub(crate) number: u32,
    pub(crate) step: String,
    pub(crate) change: String,
    pub(crate) name_parts: Vec<String>,
    pub(crate) status: &'static str,
    pub(crate) cells: Vec<String>,
    /// Sentence, then class and words of its standing.
    pub(crate) finding: Option<(&'static str, &'static str, String)>,
    /// Why the rung has no time, or a remark.
    pub(crate) remark: String,
}

/// One rung as measured.
pub(crate) struct RungData<'a> {
    pub(crate) rung: &'a LadderRung,
    pub(crate) case: Option<&'a Case>,
    /// Time of the last right rung before over this one's.
    pub(crate) gain: Option<Interval>,
    /// That rung.
    before: Option<&'a Case>,
}

impl RungData<'_> {
    fn counts(&self) -> bool {
        self.case.is_some_and(Case::counts)
    }
}

/// Columns of the table after step and status: term of the glossary, and heading.
pub(crate) const COLUMNS: [(&str, &str); 8] = [
    (
        "time over bound",
        "÷\u{a0}bound [5\u{2060}–\u{2060}95\u{a0}%]",
    ),
    ("gain", "gain over the rung before [95\u{a0}%]"),
    ("geometry_bytes", "geometry bytes"),
    ("draws", "draws"),
    ("vertices", "vertices"),
    ("stencil_fragments", "stencil-tested fragments"),
    ("mismatched_px", "wrong px"),
    ("mismatched_px_outside_band", "outside band"),
];

/// Tables of every ladder and view, in the order in which they were planned.
pub(crate) fn tables(data: &RunData) -> Vec<LadderTable> {
    let mut names: Vec<(&str, &str, &str)> = Vec::new();
    for rung in &data.ladder {
        let name = (
            rung.scene.as_str(),
            rung.view.as_str(),
            rung.ladder.as_str(),
        );
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
        .into_iter()
        .map(|(scene, view, ladder)| {
            let rungs = rungs(data, scene, view, ladder);
            LadderTable {
                title: format!("{scene}, {view}: {ladder}"),
                scene: scene.to_owned(),
                view: view.to_owned(),
                ladder: ladder.to_owned(),
                headings: COLUMNS
                    .iter()
                    .map(|(term, heading)| (*heading, glossary::meaning(term).unwrap_or_default()))
                    .collect(),
                rows: rungs.iter().map(rung_row).collect(),
                overview: overview(data, &rungs),
                sentences: sentences(view, &rungs),
                missing: missing(&rungs),
                plot: None,
            }
        })
        .collect()
}

/// The rungs of one ladder on one view, by number.
pub(crate) fn rungs<'a>(
    data: &'a RunData,
    scene: &str,
    view: &str,
    ladder: &str,
) -> Vec<RungData<'a>> {
    let mut own: Vec<&LadderRung> = data
        .ladder
        .iter()
        .filter(|rung| rung.scene == scene && rung.view == view && rung.ladder == ladder)
        .collect();
    own.sort_by_key(|rung| rung.rung);
    let mut before: Option<&Case> = None;
    let mut rungs = Vec::new();
    for rung in own {
        let case = data.case(&rung.key());
        let right = case.filter(|case| case.counts());
        let gain = before
            .zip(right)
            .and_then(|(before, case)| gain_of(data, &before.key, &case.key));
        rungs.push(RungData {
            rung,
            case,
            gain,
            before,
        });
        before = right.or(before);
    }
    rungs
}

fn gain_of(data: &RunData, before: &CaseKey, after: &CaseKey) -> Option<Interval> {
    gain(data.frames.get(before)?, data.frames.get(after)?)
}

/// A factor with its interval.
pub(crate) fn interval_text(gain: Interval) -> String {
    format!(
        "{} × [{}–{}]",
        significant(gain.middle),
        significant(gain.low),
        significant(gain.high)
    )
}

fn rung_row(rung: &RungData<'_>) -> RungRow {
    let absent = || "–".to_owned();
    let number = |value: Option<u64>| value.map_or_else(absent, count);
    let of = |cell: fn(&Summary) -> Option<u64>| rung.case.and_then(|case| case.value(cell));
    let ratio = rung.case.and_then(crate::plot::ratio).map(|spread| {
        format!(
            "{} [{}–{}]",
            significant(spread.median),
            significant(spread.p5),
            significant(spread.p95)
        )
    });
    let outcome = rung.case.map_or(Outcome::Missing, |case| case.outcome);
    RungRow {
        number: rung.rung.rung,
        step: rung.rung.step.clone(),
        change: rung.rung.change.clone(),
        name_parts: breakable(&format!("{}/{}", rung.rung.backend, rung.rung.variant)),
        status: outcome.name(),
        cells: vec![
            ratio.unwrap_or_else(absent),
            rung.gain.map_or_else(absent, interval_text),
            of(|row| row.geometry_bytes).map_or_else(absent, bytes),
            number(of(|row| row.draws)),
            number(of(|row| row.vertices)),
            number(of(|row| row.stencil_fragments)),
            number(of(|row| row.mismatched_px)),
            number(of(|row| row.mismatched_px_outside_band)),
        ],
        finding: finding_of(rung),
        remark: match (rung.case, outcome) {
            (_, Outcome::Ok) => String::new(),
            (None, _) => "this rung is not in the run".to_owned(),
            (Some(case), _) => case.reason().to_owned(),
        },
    }
}

fn finding_of(rung: &RungData<'_>) -> Option<(&'static str, &'static str, String)> {
    let finding = FINDINGS
        .iter()
        .find(|finding| finding.step == rung.rung.step)?;
    let standing = match rung.gain {
        Some(gain) => finding.claim.standing(gain),
        None => Standing::CannotTell,
    };
    Some((
        finding.sentence,
        standing.class(),
        standing.name().to_owned(),
    ))
}

/// Gain from the first right rung to the last.
fn total(data: &RunData, rungs: &[RungData<'_>]) -> Option<Interval> {
    let right: Vec<&RungData<'_>> = rungs.iter().filter(|rung| rung.counts()).collect();
    gain_of(data, &right.first()?.rung.key(), &right.last()?.rung.key())
}

/// Steps by what they gave, most first.
fn by_gain<'a>(rungs: &'a [RungData<'_>]) -> Vec<(&'a str, Interval)> {
    let mut gains: Vec<(&str, Interval)> = rungs
        .iter()
        .filter_map(|rung| Some((rung.rung.step.as_str(), rung.gain?)))
        .collect();
    gains.sort_by(|a, b| b.1.middle.total_cmp(&a.1.middle));
    gains
}

/// A ladder in four cells.
fn overview(data: &RunData, rungs: &[RungData<'_>]) -> [String; 4] {
    let absent = || "–".to_owned();
    let right = || rungs.iter().filter(|rung| rung.counts());
    let over_bound = |rung: Option<&RungData<'_>>| {
        rung.and_then(|rung| crate::plot::ratio(rung.case?))
            .map_or_else(absent, |spread| significant(spread.median))
    };
    [
        over_bound(right().next()),
        over_bound(right().next_back()),
        total(data, rungs).map_or_else(absent, interval_text),
        by_gain(rungs).first().map_or_else(absent, |(step, gain)| {
            format!("{step}: {}", interval_text(*gain))
        }),
    ]
}

/// What gave most, where the ladder ends, and what the view says of fill rate.
fn sentences(view: &str, rungs: &[RungData<'_>]) -> Vec<String> {
    let mut sentences = Vec::new();
    let gains = by_gain(rungs);
    if let Some((step, most)) = gains.first() {
        sentences.push(format!(
            "“{step}” gave most: {}{}.",
            interval_text(*most),
            match gains.get(1) {
                Some((second, interval)) if interval.high > most.low =>
                    format!(", not clearly more than “{second}”"),
                _ => String::new(),
            }
        ));
    }
    let last_right = rungs.iter().rev().find(|rung| rung.counts());
    if let (Some(right), Some(last)) = (last_right, rungs.last())
        && right.rung.rung != last.rung.rung
    {
        sentences.push(format!(
            "The last rung that is right is {}, “{}”.",
            right.rung.rung, right.rung.step
        ));
    }
    if view == FILL_RATE_VIEW {
        sentences.push(fill_rate_sentence(rungs));
    }
    sentences
}

/// If vertices were the limit, time would fall as they do; if fill rate is, it hardly falls. The
/// line is drawn in the middle, and the step asked that leaves out most vertices and no fragments.
fn fill_rate_sentence(rungs: &[RungData<'_>]) -> String {
    let most = rungs
        .iter()
        .filter_map(|rung| Some((rung, fewer_vertices(rung)?, rung.gain?)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let (standing, why) = match most {
        Some((rung, fewer, gain)) if fewer >= FEWER_VERTICES => (
            Claim::LessThan(f64::midpoint(1.0, fewer)).standing(gain),
            format!(
                "at “{}” {} × fewer vertices for the same fragments give {}",
                rung.rung.step,
                significant(fewer),
                interval_text(gain)
            ),
        ),
        _ => (
            Standing::CannotTell,
            "no step leaves out vertices alone".to_owned(),
        ),
    };
    format!(
        "{SOURCE}: {FILL_RATE_SENTENCE} Today: {}; {why}.",
        standing.name()
    )
}

/// How many times fewer vertices a rung draws for the same fragments as the one before; `None` where
/// the fragments differ or were not counted.
fn fewer_vertices(rung: &RungData<'_>) -> Option<f64> {
    let (before, after) = (rung.before?, rung.case?);
    let ratio = |cell: fn(&Summary) -> Option<u64>| {
        let (before, after) = (before.value(cell)?, after.value(cell)?);
        (before > 0 && after > 0).then(|| before as f64 / after as f64)
    };
    let is_same = |ratio: f64| (1.0 / SAME_FRAGMENTS..=SAME_FRAGMENTS).contains(&ratio);
    let same_stencil = ratio(|row| row.stencil_fragments).is_some_and(is_same);
    let same_colour = ratio(|row| row.fragment_shader_invocations).is_some_and(is_same);
    ratio(|row| row.vertices).filter(|_| same_stencil && same_colour)
}

/// Names of rungs that are not there.
fn missing(rungs: &[RungData<'_>]) -> Vec<String> {
    let mut missing = Vec::new();
    for (rung, number) in rungs.iter().zip(1_u32..) {
        if rung.rung.rung != number {
            missing.push(format!(
                "rung {number} (the ladder goes on with {}, “{}”)",
                rung.rung.rung, rung.rung.step
            ));
            break;
        }
    }
    missing.extend(
        rungs
            .iter()
            .filter(|rung| {
                rung.case
                    .is_none_or(|case| case.outcome == Outcome::Missing)
            })
            .map(|rung| {
                format!(
                    "rung {}, “{}”: {}",
                    rung.rung.rung,
                    rung.rung.step,
                    rung.rung.key()
                )
            }),
    );
    missing
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_finding_belongs_to_one_step_and_is_one_sentence() {
        let steps: BTreeSet<&str> = FINDINGS.iter().map(|finding| finding.step).collect();
        assert_eq!(steps.len(), FINDINGS.len());
        for finding in FINDINGS {
            assert_eq!(finding.sentence.matches('.').count(), 1, "{finding:?}");
            assert!(finding.sentence.ends_with('.'));
        }
    }
}
