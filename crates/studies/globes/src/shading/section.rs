// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sections on layers: views of the Earth, the ablation of features, faults, projections, and triangles against
//! pixels.

use super::{PART, is_of, tessellation, textures};
use crate::metrics::{self, *};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_4;
use terrafill_globe_views::{DRAW, compared_in, draw, whole};
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

const NO_PIXEL: &str = "no pixel is there";
/// Of an error, what is a tenth less.
const NEARER: f64 = 0.9;
const BEYOND: Column = Column::metric("px beyond 8 bits", GLOBE_SHADE_BEYOND_PX);
const LOST: Column = Column::metric("not finite", GLOBE_NON_FINITE);

pub(crate) const SECTIONS: [Section<'static>; 7] = [
    Section {
        title: "Five layers of the Earth",
        text: "Colour with water, bumps, clouds and lights of night are NASA's pictures, by longitude and latitude. One \
               preprocessing turns elevation into shares of normal, tangent and binormal, and all into cube maps by a \
               bicubic filter. Beside those stand pictures by angles, as dense along the equator, and bumps as normals \
               of object space. Elevation is exaggerated 20 times, clouds go round in ten days. Each pixel is held to \
               the same texels, filtered and shaded in f64, at the place that its ray meets. It may be off by what 8 \
               bits between texels, rounding to bytes and corners within 1/256 px explain. Wrong layers must be found \
               by that. The difference from the layers as published says what cubes and 8 bits cost.",
        cases: Select::Fitting(|case| {
            ["layers", "clouds", "bumps", "near-pole"]
                .iter()
                .any(|what| is_of(case, what))
        }),
        named_by: Names::Columns(&[
            ("view", VIEW),
            ("pictures", PICTURES),
            ("bumps", BUMPS),
            ("times as steep", BUMP_SCALE),
            ("hours", HOURS),
        ]),
        columns: &[
            BEYOND,
            Column::metric("off the texels, largest", GLOBE_SHADE_TEXELS_MAX),
            Column::metric("px with wrong layers found", GLOBE_SHADE_CONTROL_PX)
                .or("wrong layers were not tried"),
            Column::metric("px", GLOBE_SHADE_PX),
            Column::metric("off the published layers, 99 %", GLOBE_SHADE_P99),
            Column::metric("within 5° of a pole, 99 %", GLOBE_SHADE_POLAR_P99).or(NO_PIXEL),
            Column::metric("largest", GLOBE_SHADE_POLAR_MAX).or(NO_PIXEL),
            DRAW,
        ],
        findings: &[exact, poles, object_space],
        ..Section::EMPTY
    },
    Section {
        title: "Features of the shader",
        text: "Features are removed one after the other. A frame makes the mesh, sends it and draws it.",
        cases: Select::Fitting(|case| is_of(case, "ladder")),
        findings: &[bumps_cost_most],
        more: &[ablation],
        ..Section::EMPTY
    },
    Section {
        title: "Faults of the printed shader",
        cases: Select::Fitting(|case| is_of(case, "faults")),
        named_by: Names::Columns(&[("view", VIEW), ("fault", FAULT)]),
        columns: &[
            BEYOND,
            Column::metric("off the texels, largest", GLOBE_SHADE_TEXELS_MAX),
            LOST,
        ],
        findings: &[
            |cases| fault(cases, "unclamped-power", "the power of a negative number"),
            |cases| fault(cases, "polar-tangent", "a tangent of no length at a pole"),
            |cases| {
                fault(
                    cases,
                    "negated-night",
                    "night by the negated light, as the text has it",
                )
            },
        ],
        ..Section::EMPTY
    },
    Section {
        title: "Projections in the vertex shader",
        text: "A static buffer of sine, cosine and radius is corrected, turned to the focus and projected by the vertex \
               stage: in perspective, or as a flat map, a hyperbolic one, a dome. The same vertices are projected in f64, \
               and each pixel is held to the texels that their triangles show there. What WGSL allows of an arc tangent \
               may move a map by 0.25 px in 1,024. By another projection's triangles pixels must be found wrong. Triangles \
               are flat, and a projection is not: what they are off its formula stands beside it, with the same of \
               triangles half as long. That must be less than two thirds, else the tessellation is not its cause.",
        cases: Select::Fitting(|case| is_of(case, "projections") || is_of(case, "areas")),
        named_by: Names::Columns(&[("projection", PROJECTION), ("view", VIEW)]),
        columns: &[
            BEYOND,
            Column::metric("off the texels, largest", GLOBE_SHADE_TEXELS_MAX),
            Column::metric("px", GLOBE_SHADE_PX),
            Column::metric("px found wrong by another projection", GLOBE_SHADE_OTHER_PX),
            Column::metric("px off the formula, largest", GLOBE_FORMULA_PX_MAX),
            Column::metric("99 %", GLOBE_FORMULA_PX_P99),
            Column::metric("99 %, triangles half as long", GLOBE_FORMULA_FINE_PX_P99),
            Column::metric("sent a frame", GLOBE_UPLOAD_BYTES),
            DRAW,
        ],
        findings: &[projected],
        ..Section::EMPTY
    },
    tessellation::SECTION,
    textures::SECTION,
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
    let of = |key: ConditionKey| case.condition(key);
    let what = match of(WHAT) {
        "projections" => of(PROJECTION).to_owned(),
        "faults" => of(FAULT).to_owned(),
        "layers" => format!("{} pictures, {} bumps", of(PICTURES), of(BUMPS)),
        "bumps" => format!("bumps × {}", of(BUMP_SCALE)),
        "areas" => format!("{}, bumps × {}", of(PROJECTION), of(BUMP_SCALE)),
        "near-pole" => format!("{} pictures", of(PICTURES)),
        "clouds" => format!("clouds after {} hours", of(HOURS)),
        _ => format!("{} removed", of(REMOVED)),
    };
    format!("{what}, {}", of(VIEW))
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
            Heading::metric("off the published layers, 99 %", GLOBE_SHADE_P99),
        ],
        ..Table::default()
    })))
}

/// The removal that is said to save most.
const BUMP_MAPPING: &str = "Bump mapping";

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
    let bumps = removals.iter().find(|(name, ..)| *name == BUMP_MAPPING);
    let others = removals.iter().filter(|(name, ..)| *name != BUMP_MAPPING);
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

/// Errors near the pole of one storage and of another.
fn at_pole(cases: &Cases<'_>, storages: [[&str; 2]; 2]) -> Option<(f64, f64)> {
    let polar = |[pictures, bumps]: [&str; 2]| {
        let own = cases.with(&[(VIEW, "pole"), (PICTURES, pictures), (BUMPS, bumps)]);
        own.value(GLOBE_SHADE_POLAR_P99)
    };
    polar(storages[0]).zip(polar(storages[1]))
}

fn exact(cases: &Cases<'_>) -> Finding {
    let beyond = cases.sum(GLOBE_SHADE_BEYOND_PX);
    let pair = beyond.zip(cases.sum(GLOBE_SHADE_PX));
    let controls = cases.least(GLOBE_SHADE_CONTROL_PX);
    finding(
        "Five layers on the device are the same texels, filtered and shaded in f64",
        pair.map(|(beyond, _)| beyond == 0.0),
        pair.map_or_else(String::new, |(beyond, of)| {
            let found = controls.map_or_else(String::new, |least| {
                format!(" Wrong layers are found in at least {least} pixels of a view.")
            });
            format!("{beyond} of {of} pixels are off by more than 8 bits explain.{found}")
        }),
    )
}

/// Texels a radian in the middle of a cube's face over those of a picture by angles, which is four faces round. A face is
/// two tangents of 45° wide, for a quarter turn.
const FACE_DENSITY: f64 = FRAC_PI_4;

/// What errors near a pole say of the two kinds of pictures. Errors between texels grow with the square of their
/// distance: where a cube's are larger by no more than that, its fewer texels may be the cause.
fn mends([cube, angles]: [f64; 2]) -> Standing {
    if cube < NEARER * angles {
        Standing::Holds
    } else if cube * FACE_DENSITY.powi(2) > angles {
        Standing::DoesNotHold
    } else {
        Standing::CannotTell
    }
}

fn poles(cases: &Cases<'_>) -> Finding {
    let pair = at_pole(cases, [["cube", "tangent"], ["angles", "tangent"]]);
    Finding {
        claim: "Gebbie & Bailey: cube maps mend what pictures by angles do at the poles, by a tenth or more"
            .to_owned(),
        standing: pair.map_or(Standing::NotMeasured, |(cube, angles)| mends([cube, angles])),
        because: pair.map_or_else(String::new, |(cube, angles)| {
            format!(
                "Within 5° of the pole 99 % of the pixels are off the published layers by at most {} with cube maps and \
                 {} with pictures by angles. In its middle a face has {:.0} % fewer texels a radian than a picture by \
                 angles has along a meridian, which explains up to {} times the error.",
                significant(cube),
                significant(angles),
                100.0 * (1.0 - FACE_DENSITY),
                significant(FACE_DENSITY.powi(-2))
            )
        }),
    }
}

fn object_space(cases: &Cases<'_>) -> Finding {
    let pair = at_pole(cases, [["cube", "object"], ["cube", "tangent"]]);
    finding(
        "Bumps as normals of object space are nearer to the elevation at a pole than shares of tangents, by a tenth or more",
        pair.map(|(object, tangent)| object < NEARER * tangent),
        pair.map_or_else(String::new, |(object, tangent)| {
            format!(
                "Within 5° of the pole 99 % of the pixels are off the published layers by at most {} with normals of \
                 object space and {} with shares of tangents. A tangent turns once round the pole between texels.",
                significant(object),
                significant(tangent)
            )
        }),
    )
}

fn projected(cases: &Cases<'_>) -> Finding {
    let beyond = cases.sum(GLOBE_SHADE_BEYOND_PX);
    let [off, most, fine] = [
        GLOBE_FORMULA_PX_MAX,
        GLOBE_FORMULA_PX_P99,
        GLOBE_FORMULA_FINE_PX_P99,
    ]
    .map(|metric| cases.greatest(metric));
    let figures = || {
        let controls = cases.least(GLOBE_SHADE_OTHER_PX)?;
        Some(format!(
            "{} pixels show other texels than the triangles projected in f64; by another projection's triangles at least \
             {controls} of a view do. The triangles are off the formula by at most {} px, 99 % of their pixels by {} px, \
             and by {} px with triangles half as long: that is tessellation.",
            beyond?,
            significant(off?),
            significant(most?),
            significant(fine?)
        ))
    };
    finding(
        "The triangles of each projection are those of its formula in f64, to what 8 bits explain",
        beyond.map(|beyond| beyond == 0.0),
        figures().unwrap_or_default(),
    )
}

/// Whether a fault of the printed shader is seen.
fn fault(cases: &Cases<'_>, name: &str, words: &str) -> Finding {
    let own = cases.with(&[(FAULT, name)]);
    let pair = own
        .sum(GLOBE_NON_FINITE)
        .zip(own.sum(GLOBE_SHADE_BEYOND_PX));
    finding(
        format!("The shader as printed is wrong here by {words}"),
        pair.map(|(lost, beyond)| lost + beyond > 0.0),
        pair.map_or_else(String::new, |(lost, beyond)| {
            format!("{lost} pixels are not finite, {beyond} are off by more than 8 bits explain.")
        }),
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
                BUMP_MAPPING => 0.1 + more,
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
    fn a_cube_s_fewer_texels_may_be_what_its_errors_are_of() {
        assert_eq!(mends([0.8, 1.0]), Standing::Holds);
        // Negative controls: nearly the same, what fewer texels explain, and more than that.
        for (cube, standing) in [
            (0.95, Standing::CannotTell),
            (1.6, Standing::CannotTell),
            (1.7, Standing::DoesNotHold),
        ] {
            assert_eq!(mends([cube, 1.0]), standing, "{cube}");
        }
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
