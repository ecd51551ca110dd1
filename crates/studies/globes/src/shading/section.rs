// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sections on layers: the ablation of features, pictures, faults, projections, and triangles against pixels.

use super::{ALLOWED, FAULTS, PART, is_of, tessellation};
use crate::clock::{compared_in, draw, whole};
use crate::metrics::{self, *};
use std::collections::BTreeMap;
use terrafill_lab::{Answer, Cases, Column, Names, Section, Select, finding, measured};
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Claim, ConditionKey, Estimate, Finding, Heading, Metric,
    Noise, Row, Scope, Standing, Table, over_processes, process_medians,
};

/// Gebbie & Bailey, Table 3: what was removed, each row lacking all above, and GPU ms.
pub(crate) const TABLE_3: [(&str, f64); 8] = [
    ("None (Complete)", 8.326),
    ("Clouds", 8.082),
    ("City Lights", 7.820),
    ("Tangent normalize", 7.457),
    ("Bump mapping", 4.787),
    ("Specular lighting", 3.535),
    ("Diffuse lighting", 2.143),
    ("White", 1.974),
];

const ERRORS: [Column; 5] = [
    Column::metric("largest", GLOBE_SHADE_MAX),
    Column::metric("99 %", GLOBE_SHADE_P99),
    Column::metric("within 5° of a pole, largest", GLOBE_SHADE_POLAR_MAX).or(NO_PIXEL),
    Column::metric("99 %", GLOBE_SHADE_POLAR_P99).or(NO_PIXEL),
    Column::metric("not finite", GLOBE_NON_FINITE),
];
const NO_PIXEL: &str = "no pixel is there";

pub(crate) const SECTIONS: [Section<'static>; 5] = [
    Section {
        title: "Five layers",
        text: "Colour with water, bumps, clouds and lights of night lie over the spiral, each in its own cube map or in \
               a picture by longitude and latitude, as dense along the equator. They are baked from smooth functions of \
               direction, and each pixel is held against these functions in f64, at the place that its ray meets: the \
               largest channel's difference, 1 being white. A frame makes the mesh, sends it and draws it.",
        cases: Select::Fitting(|case| is_of(case, "ladder")),
        findings: &[bumps_cost_most],
        more: &[ablation],
        ..Section::EMPTY
    },
    Section {
        title: "Cube maps against pictures by angles",
        cases: Select::Fitting(|case| is_of(case, "pictures")),
        named_by: Names::Columns(&[("view", VIEW), ("pictures", PICTURES)]),
        columns: &ERRORS,
        findings: &[poles],
        ..Section::EMPTY
    },
    Section {
        title: "Faults of the printed shader",
        cases: Select::Fitting(|case| is_of(case, "faults")),
        named_by: Names::Columns(&[("view", VIEW), ("fault", FAULT)]),
        columns: &ERRORS,
        findings: &[faults],
        ..Section::EMPTY
    },
    tessellation::SECTION,
    Section {
        title: "Layers and projections as drawn; what is not finite is magenta",
        cases: Select::Fitting(|case| {
            case.condition(metrics::PART) == PART && !case.note("picture").is_empty()
        }),
        named_by: Names::Of("shown", shown),
        pictures: &[("picture", "")],
        ..Section::EMPTY
    },
];

/// What a picture shows, and in which view.
fn shown(case: &Case) -> String {
    let key: ConditionKey = match case.condition(WHAT) {
        "projections" => PROJECTION,
        "faults" => FAULT,
        "pictures" => PICTURES,
        _ => {
            return format!(
                "{} removed, {}",
                case.condition(REMOVED),
                case.condition(VIEW)
            );
        }
    };
    format!("{}, {}", case.condition(key), case.condition(VIEW))
}

fn ablation(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let [whole, draw] = [whole(cases.clock()), draw(cases.clock())];
    let first = cases.first().and_then(|case| measured(case, draw));
    let mut before = first;
    let rows = cases
        .iter()
        .zip(TABLE_3)
        .map(|(case, (removed, published))| {
            let ms = measured(case, draw);
            let of_whole = |ms: Option<f64>| Some(ms? / first?);
            let step = ms.zip(before).map(|(ms, before)| before - ms);
            before = ms;
            let figures = [
                of_whole(ms).map(significant),
                of_whole(step).map(|step| format!("{:.1} %", 100.0 * step)),
                ms.map(significant),
                measured(case, whole).map(significant),
                measured(case, GLOBE_SHADE_P99).map(significant),
            ];
            let why = match case.reason.as_str() {
                "" => "not measured",
                reason => reason,
            };
            let mut cells = vec![
                Cell::name(removed),
                Cell::plain(significant(published / TABLE_3[0].1)),
            ];
            cells.extend(figures.map(|figure| Cell::or_absent(figure, why)));
            Row::new(cells)
        });
    Ok(Some(Block::Table(Table {
        caption: "Features removed one after the other, each row lacking all above: ours beside Gebbie & Bailey's Table \
                  3, as ratios to the first row"
            .to_owned(),
        rows: rows.collect(),
        headings: vec![
            Heading::plain("feature removed"),
            Heading::plain("published, ratio"),
            Heading::plain("ours, ratio"),
            Heading::plain("saved of the whole"),
            Heading::metric("draw, ms", draw),
            Heading::metric("frame, ms", whole),
            Heading::metric("off the functions, 99 %", GLOBE_SHADE_P99),
        ],
        ..Table::default()
    })))
}

/// The removal that is said to save most.
const BUMPS: &str = "Bump mapping";

/// The whole frame with what one removal saves over the frame with what another saves, by process: so that a difference
/// of savings is measured by what identical frames differ by.
fn saving_over(whole: &Case, removals: [&[&Case]; 2], metric: &Metric) -> Option<Estimate> {
    let removals =
        removals.map(|pair| [pair[0], pair[1]].map(|case| process_medians(case, metric)));
    let saved = |[before, after]: &[BTreeMap<u32, f64>; 2], process| {
        Some(before.get(process)? - after.get(process)?)
    };
    let whole = process_medians(whole, metric);
    let ratios = whole.iter().filter_map(|(process, ms)| {
        let [one, other] = removals.each_ref().map(|pair| saved(pair, process));
        Some((ms + one?) / (ms + other?))
    });
    over_processes(&ratios.collect::<Vec<f64>>())
}

fn bumps_cost_most(cases: &Cases<'_>) -> Finding {
    let metric = draw(cases.clock());
    let all: Vec<&Case> = cases.iter().collect();
    let saved = |pair: &[&Case]| Some(measured(pair[0], metric)? - measured(pair[1], metric)?);
    let removals = TABLE_3[1..].iter().zip(all.windows(2));
    let removals: Vec<(&str, &[&Case], f64)> = removals
        .filter_map(|((name, _), pair)| Some((*name, pair, saved(pair)?)))
        .collect();
    let bumps = removals.iter().find(|(name, ..)| *name == BUMPS);
    let others = removals.iter().filter(|(name, ..)| *name != BUMPS);
    let most = others.max_by(|a, b| a.2.total_cmp(&b.2));
    let claim = "Gebbie & Bailey: bump mapping costs most of the layers";
    let Some(((_, pair, ms), (other, other_pair, other_ms))) = bumps.zip(most) else {
        return finding(claim, None, "The ablation was not timed.");
    };
    let comparison = compared_in(REMOVED, metric, Scope::DRAW);
    let noise = cases.noise(metric);
    let judged = comparison.judge(cases.run(), [pair[0], pair[1]], Claim::Faster, noise);
    let answer = judged.unwrap_or_else(Answer::from);
    let over = saving_over(all[0], [pair, other_pair], metric);
    let standing = match (answer.standing, &over) {
        (refused @ Standing::CannotBeTested, _) => refused,
        (_, Some(over)) => Claim::Faster.standing_beyond(over, Noise::band(noise)),
        (_, None) => Standing::CannotTell,
    };
    let over = over.as_ref().map(times).unwrap_or_default();
    Finding {
        claim: claim.to_owned(),
        standing,
        because: format!(
            "Removing bumps saves {} ms here, and of the others “{other}” most: {} ms. A frame with the one saving over a \
             frame with the other: {over}. {}",
            significant(*ms),
            significant(*other_ms),
            answer.because
        ),
    }
}

fn poles(cases: &Cases<'_>) -> Finding {
    let polar = |pictures: &str| {
        let own = cases.with(&[(VIEW, "globe-pole"), (PICTURES, pictures)]);
        own.value(GLOBE_SHADE_POLAR_P99)
    };
    let pair = polar("cube").zip(polar("angles"));
    finding(
        "Gebbie & Bailey: cube maps mend what pictures by angles do at the poles",
        pair.map(|(cube, angles)| cube < angles),
        pair.map_or_else(String::new, |(cube, angles)| {
            format!(
                "Within 5° of the pole 99 % of the pixels are off by at most {} with cube maps and {} with pictures by \
                 angles. Bumps are stored along parallels, whose direction turns once round the pole in either.",
                significant(cube),
                significant(angles)
            )
        }),
    )
}

fn faults(cases: &Cases<'_>) -> Finding {
    let words = FAULTS.map(|(_, name)| {
        let own = cases.with(&[(FAULT, name)]);
        let lost = own.sum(GLOBE_NON_FINITE).unwrap_or(0.0);
        let worst = own.greatest(GLOBE_SHADE_MAX);
        let worst = worst.map(|worst| format!(", off by up to {}", significant(worst)));
        format!(
            "{name}: {lost} pixels not finite{}",
            worst.unwrap_or_default()
        )
    });
    let is_beyond = |metric, allowed| cases.greatest(metric).is_some_and(|found| found > allowed);
    finding(
        "The shader as printed is wrong here: an undeclared variable, a power of what is negative, a tangent of no \
         length, night by the negated light",
        Some(is_beyond(GLOBE_NON_FINITE, 0.0) || is_beyond(GLOBE_SHADE_MAX, ALLOWED)),
        format!("The first does not compile. {}.", words.join("; ")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::Clock;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    /// The finding on an ablation whose frame lasts 10 ms, with a repeat that lasts 2 % longer. Clouds save 0.1 ms,
    /// bumps as much and `more`.
    fn found(more: f64, processes: usize) -> Finding {
        let metric = draw(Clock::ProcessCpu);
        let mut ms = 10.0;
        let mut run = MadeUpRun::default();
        for (place, (name, _)) in TABLE_3.iter().enumerate() {
            ms -= match *name {
                "Clouds" => 0.1,
                BUMPS => 0.1 + more,
                _ => 0.0,
            };
            let place_ = place.to_string();
            let conditions = [("part", PART), ("what", "ladder"), ("removed", &place_)];
            let id = case_id(crate::STUDY, &place_, &conditions);
            if place == 0 {
                let longer = vec![1.02 * ms; processes];
                run.case(id.repeat()).timed(metric, &longer);
            }
            run.case(id).timed(metric, &vec![ms; processes]);
        }
        bumps_cost_most(&Cases::of_study(&run.loaded(), crate::STUDY))
    }

    #[test]
    fn savings_within_the_noise_decide_nothing() {
        // By 0.00019 ms, where identical frames differ by 0.2 ms.
        for more in [0.000_19, -0.000_19, 0.15] {
            let found = found(more, 5);
            assert_eq!(found.standing, Standing::NoDifference, "{found:?}");
        }
        // Controls: beyond it either way, and too few processes for any.
        assert_eq!(found(1.0, 5).standing, Standing::Holds);
        assert_eq!(found(-1.0, 5).standing, Standing::DoesNotHold);
        assert_eq!(found(1.0, 3).standing, Standing::CannotTell);
    }
}
