// SPDX-License-Identifier: MIT OR Apache-2.0
//! Variance and hard shadows, and motion blur, as devices draw them: what of their definitions holds, and what ways
//! to layers cost.

use super::cells::{byte_cell, headings, of, paired_finding, time, time_cell, values, why};
use super::series::{curve, draw, finding, plot, range, series, slope, table};
use crate::blur::MOTION_PX;
use crate::keys::{
    API, BLUR_MAX, BLUR_RMS, DEPTH, EXPERIMENT, FILTER, FLOOR, HARD_AREA_SHARE,
    HARD_DEVIATION_TEXELS, HARD_WRONG_AREA, LAYERED_JUDGED_PX, LAYERED_OPEN_PX, LAYERED_WRONG_PX,
    LAYERED_WRONG_TEXELS, LAYERS, LAYERS_BY, LIGHTS_DEPTHS_DIFFERING, LIGHTS_PASSES, MOMENTS,
    PIPELINE_HELD_BYTES, RESOLVE, SIGMA, TEXELS, VARIANCE_ABSOLUTE_MAX, VARIANCE_ABSOLUTE_RMS,
    VARIANCE_BLACK_PX, VARIANCE_DARK_SHARE, VARIANCE_NON_FINITE, VARIANCE_OUTSIDE_SHARE,
    VARIANCE_RELATIVE_RMS,
};
use terrafill_plot::number::significant;
use terrafill_results::{
    Block, Case, Cell, ChapterError, Claim, Clock, ConditionKey, Finding, Metric, Picture,
    PictureFigure, Pictures, Row, Run, Scope, Table,
};

const SHADOWS: &str = "A level plane is seen from straight above, and looked up in the depth maps of distant lights: 25 depths a light \
     as published, their moments summed in the shader, or one texel. Terraces of 8 × 8 pixels that nothing \
     shadows show what the published formula makes of a lit plane; rough ground shows the noise of its variance; \
     a disc above the plane, under four lights, has edges at all angles. Each pixel is held against the \
     same formula in f64 on the maps that the device drew, whose rounding is bounded; the maps against rays along \
     the lights.";
const WHAT_THE_PRODUCT_DOES: &str = "As published, lights multiply, so that a shadow of one dims what the others give, and rounding makes a lit plane \
     black where its variance comes out as 0 or below.";
const BLUR: &str = "A bar of 20 pixels, which moves by 32 while the shutter is open, is drawn into layers, in a pass each or all in one pass, and a second pass \
     makes the picture of them. Beside it the same bars are added up by blending, without layers, or each pixel \
     looks at moments of its own. 64 rows have 64 places between pixels. Layers of covered shares carry the share as \
     their depth. Each pixel is held against the definition in f64, edges within 1/32 pixel of a middle left open.";
/// What is required of the variance with the receiver subtracted.
const RELATIVE_NOISE: f64 = 2e-6;
/// Of a straight edge at all angles, mean area between it and the texels whose middles it covers.
const EDGE_SHARE: f64 = 0.244;
const EDGE_TOLERANCE: f64 = 0.01;
/// By how much a slope over several doublings may be off.
const SLOPE_TOLERANCE: f64 = 0.15;
/// What the published resolve is beyond, and what the right one falls to, rms.
const OPAQUE: f64 = 0.4;
const FADED: f64 = 0.1;

fn shaded<'a>(cases: &[&'a Case]) -> Vec<&'a Case> {
    let own = [
        "shaded-plane",
        "shaded-variance",
        "shaded-disc",
        "shaded-hard",
    ];
    own.into_iter()
        .flat_map(|experiment| of(cases, &[(EXPERIMENT, experiment)]))
        .collect()
}

fn blurred<'a>(cases: &[&'a Case]) -> Vec<&'a Case> {
    let own = ["blurred", "blurred-resolve"];
    own.into_iter()
        .flat_map(|experiment| of(cases, &[(EXPERIMENT, experiment)]))
        .collect()
}

fn most(cases: &[&Case], metric: &Metric) -> Option<f64> {
    let all = cases.iter().filter_map(|case| case.value(metric));
    all.max_by(f64::total_cmp)
}

fn all(cases: &[&Case], conditions: &[(ConditionKey, &str)], metric: &Metric) -> Vec<f64> {
    let own = of(cases, conditions);
    own.into_iter()
        .filter_map(|case| case.value(metric))
        .collect()
}

pub(super) fn findings(cases: &[&Case]) -> Vec<Finding> {
    let (shaded, blurred) = (shaded(cases), blurred(cases));
    let mut findings = Vec::new();
    if !shaded.is_empty() {
        findings.extend(shadow_findings(&shaded));
    }
    if !blurred.is_empty() {
        findings.extend(blur_findings(&blurred));
    }
    findings
}

fn shadow_findings(cases: &[&Case]) -> Vec<Finding> {
    let wrong = most(cases, LAYERED_WRONG_PX).zip(most(cases, LAYERED_WRONG_TEXELS));
    let subtracted = [
        (EXPERIMENT, "shaded-variance"),
        (MOMENTS, "receiver subtracted"),
    ];
    let subtracted = all(cases, &subtracted, VARIANCE_RELATIVE_RMS);
    let published = [
        (EXPERIMENT, "shaded-variance"),
        (MOMENTS, "published"),
        (SIGMA, "1e-4"),
    ];
    let noise = all(cases, &published, VARIANCE_ABSOLUTE_RMS);
    let plane = |floor| {
        let conditions = [
            (EXPERIMENT, "shaded-plane"),
            (MOMENTS, "published"),
            (DEPTH, "f32"),
            (FLOOR, floor),
        ];
        all(cases, &conditions, VARIANCE_BLACK_PX)
    };
    let (bare, floored) = (plane("none"), plane("1e-7"));
    let shares = all(cases, &[(EXPERIMENT, "shaded-hard")], HARD_AREA_SHARE);
    let is_edge = |share: &f64| (share - EDGE_SHARE).abs() <= EDGE_TOLERANCE;
    let list = |counts: &[f64]| {
        counts
            .iter()
            .map(f64::to_string)
            .collect::<Vec<_>>()
            .join(" and ")
    };
    vec![
        finding(
            "No pixel of a shadow on devices is outside of what its formula allows, and no texel of what rays along \
             the lights meet",
            wrong.map(|(pixels, texels)| pixels + texels <= 0.0),
            wrong.map_or_else(String::new, |(pixels, texels)| {
                format!(
                    "at most {pixels} pixels and {texels} texels in {} cases",
                    cases.len()
                )
            }),
        ),
        finding(
            "On devices, too, the variance with the receiver subtracted is right to 2·10⁻⁶ of itself",
            (!subtracted.is_empty())
                .then(|| subtracted.iter().all(|error| *error <= RELATIVE_NOISE)),
            range(&subtracted).unwrap_or_default(),
        ),
        finding(
            "On devices the published sums carry noise of about 2·10⁻⁷ of the range squared",
            (!noise.is_empty()).then(|| noise.iter().all(|noise| (1e-7..=4e-7).contains(noise))),
            range(&noise).unwrap_or_default(),
        ),
        finding(
            "A lit plane drawn as published has black pixels, and none with a floor of 10⁻⁷",
            (!bare.is_empty() && !floored.is_empty()).then(|| {
                bare.iter().all(|count| *count > 0.0) && floored.iter().all(|count| *count <= 0.0)
            }),
            format!(
                "{} pixels of 16 384 on the interfaces, with the floor {}",
                list(&bare),
                list(&floored)
            ),
        ),
        finding(
            "On devices a hard shadow's map shows about 0.244 of its perimeter times a texel wrongly",
            (!shares.is_empty()).then(|| shares.iter().all(is_edge)),
            range(&shares).unwrap_or_default(),
        ),
    ]
}

/// Slopes of error over layers, from a layer a pixel of motion on, of every way that has three.
fn slopes(cases: &[&Case], filter: &str) -> Vec<f64> {
    let own = of(
        cases,
        &[
            (EXPERIMENT, "blurred"),
            (FILTER, filter),
            (MOMENTS, "middle"),
        ],
    );
    let mut ways: Vec<(&str, &str)> = own
        .iter()
        .map(|case| (case.condition(API), case.condition(LAYERS_BY)))
        // Those of 8 and 16 bits have errors of their own.
        .filter(|(_, by)| !matches!(*by, "blended-f16" | "blended-8-bit"))
        .collect();
    ways.sort_unstable();
    ways.dedup();
    let of_way = |(api, by): (&str, &str)| {
        let errors = series(&own, &[(API, api), (LAYERS_BY, by)], LAYERS, BLUR_RMS);
        let fine: Vec<(f64, f64)> = errors
            .into_iter()
            .filter(|pair| pair.0 >= MOTION_PX)
            .collect();
        slope(&fine)
    };
    ways.into_iter().filter_map(of_way).collect()
}

fn blur_findings(cases: &[&Case]) -> Vec<Finding> {
    let wrong = most(cases, LAYERED_WRONG_PX).zip(most(cases, LIGHTS_DEPTHS_DIFFERING));
    let mut findings = vec![finding(
        "No pixel of blur on devices is outside of what its definition allows, and all ways to layers leave the same \
         bits",
        wrong.map(|(pixels, texels)| pixels + texels <= 0.0),
        wrong.map_or_else(String::new, |(pixels, texels)| {
            format!(
                "at most {pixels} pixels and {texels} texels in {} cases",
                cases.len()
            )
        }),
    )];
    for (filter, expected) in [("point", -1.0), ("box", -2.0)] {
        let slopes = slopes(cases, filter);
        let is_right = |slope: &f64| (slope - expected).abs() <= SLOPE_TOLERANCE;
        findings.push(finding(
            &format!(
                "On devices, from a layer a pixel of motion on, blur of {filter} layers at middles falls with slope \
                 {expected} by every way"
            ),
            (!slopes.is_empty()).then(|| slopes.iter().all(is_right)),
            range(&slopes).map_or_else(String::new, |range| format!("{range}, {} ways", slopes.len())),
        ));
    }
    let resolved = |resolve| {
        let conditions = [
            (EXPERIMENT, "blurred-resolve"),
            (RESOLVE, resolve),
            (LAYERS, "32"),
        ];
        all(cases, &conditions, BLUR_RMS)
    };
    let (published, first) = (resolved("published"), resolved("current pose first"));
    findings.push(finding(
        "On devices the published resolve of 32 layers is far from a trail that fades, and one with the current pose \
         first is near",
        (!published.is_empty() && !first.is_empty()).then(|| {
            published.iter().all(|rms| *rms > OPAQUE) && first.iter().all(|rms| *rms < FADED)
        }),
        range(&published)
            .zip(range(&first))
            .map_or_else(String::new, |(published, first)| format!("rms {published} against {first}")),
    ));
    findings
}

fn blur<'a>(cases: &[&'a Case], api: &str, by: &str, layers: u32) -> Option<&'a Case> {
    let layers = layers.to_string();
    let conditions = [
        (EXPERIMENT, "blurred"),
        (FILTER, "box"),
        (API, api),
        (LAYERS_BY, by),
        (LAYERS, &layers),
    ];
    of(cases, &conditions).first().copied()
}

/// Published in words: blur in two passes beats a pass a layer.
fn claim(cases: &[&Case], run: &Run) -> Finding {
    let several = values(cases, LAYERS)
        .into_iter()
        .filter(|layers| *layers >= 4);
    let pairs = several.filter_map(|layers| {
        let case = |by| blur(cases, "vulkan", by, layers);
        Some([case("passes")?, case("geometry-copies")?])
    });
    let claim = "Blur of layers that a geometry shader copies in one pass is faster than a pass a layer (published in \
                 words):";
    paired_finding(
        run,
        (LAYERS_BY, &[]),
        (time(run.clock()), Scope::DRAW),
        &pairs.collect::<Vec<_>>(),
        (claim.to_owned(), Claim::Faster),
    )
}

/// The fastest ways to blur, with what explains them.
pub(super) fn recommended(cases: &[&Case], clock: Clock) -> Vec<String> {
    let mut sentences = Vec::new();
    let plane = [
        (EXPERIMENT, "shaded-plane"),
        (MOMENTS, "receiver subtracted"),
        (DEPTH, "f32"),
        (FLOOR, "1e-7"),
    ];
    let own = shaded(cases);
    let variance = [
        (EXPERIMENT, "shaded-variance"),
        (MOMENTS, "receiver subtracted"),
    ];
    let noise = most(&of(&own, &variance), VARIANCE_RELATIVE_RMS);
    if let Some((dark, noise)) = most(&of(&own, &plane), VARIANCE_DARK_SHARE).zip(noise) {
        sentences.push(format!(
            "Variance shadows are best summed from depths less the receiver's, over a floor of 1e-7: the variance \
             errs by {} of itself, and {} % of a lit plane's pixels are dark.",
            significant(noise),
            significant(100.0 * dark)
        ));
    }
    let own = of(cases, &[(EXPERIMENT, "blurred"), (FILTER, "box")]);
    for api in ["vulkan", "wgpu"] {
        let timed = of(&own, &[(API, api)]).into_iter();
        let timed = timed.filter(|case| case.counts() && case.value(time(clock)).is_some());
        let timed: Vec<&Case> = timed.collect();
        let Some(layers) = values(&timed, LAYERS).last().copied() else {
            continue;
        };
        let of_most = of(&timed, &[(LAYERS, &layers.to_string())]);
        let ms = |case: &&Case| case.value(time(clock)).unwrap_or(f64::INFINITY);
        let Some(best) = of_most.into_iter().min_by(|a, b| ms(a).total_cmp(&ms(b))) else {
            continue;
        };
        let figure = |metric| best.value(metric).map(significant).unwrap_or_default();
        sentences.push(format!(
            "On {api} blur by {layers} moments is fastest by {}: {} ms in {} passes, {} bytes of layers, rms {}.",
            best.condition(LAYERS_BY),
            significant(ms(&best)),
            figure(LIGHTS_PASSES),
            figure(PIPELINE_HELD_BYTES),
            figure(BLUR_RMS),
        ));
    }
    sentences
}

pub(super) fn sections(cases: &[&Case], run: &Run) -> Result<Vec<Block>, ChapterError> {
    let clock = run.clock();
    let mut blocks = Vec::new();
    let own = shaded(cases);
    if !own.is_empty() {
        blocks.push(Block::section("Variance and hard shadows on devices"));
        blocks.push(Block::Text(SHADOWS.to_owned()));
        blocks.extend(pictures(&own));
        blocks.extend(shadow_tables(&own).map(Block::Table));
        blocks.push(Block::Remark(WHAT_THE_PRODUCT_DOES.to_owned()));
    }
    let own = blurred(cases);
    if !own.is_empty() {
        blocks.push(Block::section("Motion blur on devices"));
        blocks.push(Block::Text(BLUR.to_owned()));
        blocks.push(Block::Finding(claim(&own, run)));
        blocks.extend(blur_plot(&own)?);
        blocks.push(Block::Table(blur_table(&own, clock)));
    }
    Ok(blocks)
}

fn pictures(cases: &[&Case]) -> Option<Block> {
    let with_pictures = cases.iter().filter(|case| !case.note("picture").is_empty());
    let figures: Vec<PictureFigure> = with_pictures
        .map(|case| PictureFigure {
            pictures: vec![Picture {
                path: case.note("picture").to_owned(),
                caption: match case.condition(EXPERIMENT) {
                    "shaded-hard" => format!("hard, {} texels", case.condition(TEXELS)),
                    _ => format!(
                        "{}, floor {}",
                        case.condition(MOMENTS),
                        case.condition(FLOOR)
                    ),
                },
            }],
            notes: Vec::new(),
        })
        .collect();
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            caption: "The plane under the disc and four lights: the published product of variance shadows, and how \
                      many lights a texel each lets through."
                .to_owned(),
            reference: String::new(),
            figures,
        })
    })
}

fn shadow_tables(cases: &[&Case]) -> [Table; 4] {
    let judged = [
        ("wrong texels", LAYERED_WRONG_TEXELS),
        ("wrong pixels", LAYERED_WRONG_PX),
        ("left open", LAYERED_OPEN_PX),
        ("of", LAYERED_JUDGED_PX),
        ("not finite", VARIANCE_NON_FINITE),
    ];
    let way = [("interface", API), ("layers by", LAYERS_BY)];
    let make = |caption,
                experiment,
                keys: &[(&'static str, ConditionKey)],
                metrics: &[(&'static str, &'static Metric)]| {
        let keys = [keys, &way[..]].concat();
        let metrics = [metrics, &judged[..]].concat();
        table(cases, caption, experiment, &keys, &metrics)
    };
    [
        make(
            "Terraces that nothing shadows, on devices",
            "shaded-plane",
            &[("moments", MOMENTS), ("depth", DEPTH), ("floor", FLOOR)],
            &[
                ("below 0.99 of the light", VARIANCE_DARK_SHARE),
                ("black pixels", VARIANCE_BLACK_PX),
                ("outside of 0 to 1", VARIANCE_OUTSIDE_SHARE),
            ],
        ),
        make(
            "Variance of rough ground near depth 1, on devices",
            "shaded-variance",
            &[("moments", MOMENTS), ("spread of depths", SIGMA)],
            &[
                ("relative, rms", VARIANCE_RELATIVE_RMS),
                ("absolute, rms", VARIANCE_ABSOLUTE_RMS),
                ("absolute, largest", VARIANCE_ABSOLUTE_MAX),
            ],
        ),
        make(
            "A plane under a disc and four lights: the product of their variance shadows",
            "shaded-disc",
            &[("moments", MOMENTS), ("floor", FLOOR)],
            &[("passes", LIGHTS_PASSES)],
        ),
        make(
            "The same by one texel a light",
            "shaded-hard",
            &[("texels", TEXELS)],
            &[
                ("wrong area", HARD_WRONG_AREA),
                ("over perimeter · texel", HARD_AREA_SHARE),
                ("largest deviation, texels", HARD_DEVIATION_TEXELS),
            ],
        ),
    ]
}

fn blur_plot(cases: &[&Case]) -> Result<Option<Block>, ChapterError> {
    let shown = [
        ("layers on vulkan", "vulkan", "passes", "middle"),
        ("layers on wgpu", "wgpu", "passes", "middle"),
        ("blended in f32", "wgpu", "blended-f32", "middle"),
        ("blended in f16", "wgpu", "blended-f16", "middle"),
        ("blended in 8 bits", "wgpu", "blended-8-bit", "middle"),
        ("ends of parts", "vulkan", "passes", "end"),
        ("stochastic", "vulkan", "stochastic", "random"),
    ];
    let of_filter = |filter| {
        let of_way = |(name, api, by, moments)| {
            let conditions = [
                (EXPERIMENT, "blurred"),
                (FILTER, filter),
                (API, api),
                (LAYERS_BY, by),
                (MOMENTS, moments),
            ];
            curve(name, &series(cases, &conditions, LAYERS, BLUR_RMS))
        };
        shown.map(of_way).into()
    };
    let (across, up) = ("layers", "rms error of the trail");
    draw(
        "error of motion blur on devices",
        "Error against the integral over time of what devices drew, by the way to layers or without them.",
        &[
            plot("a pixel's middle", across, up, of_filter("point")),
            plot("a pixel's covered share", across, up, of_filter("box")),
        ],
    )
}

fn blur_table(cases: &[&Case], clock: Clock) -> Table {
    let rows = cases.iter().map(|case| {
        let figure = |metric| Cell::or_absent(case.value(metric).map(significant), why(case));
        let made = match case.condition(RESOLVE) {
            "" => format!("{} at {}", case.condition(FILTER), case.condition(MOMENTS)),
            resolve => format!("resolve: {resolve}"),
        };
        Row {
            cells: vec![
                Cell::name(made),
                Cell::name(case.condition(API)),
                Cell::name(case.condition(LAYERS_BY)),
                Cell::name(case.condition(LAYERS)),
                figure(BLUR_RMS),
                figure(BLUR_MAX),
                time_cell(case, time(clock)),
                figure(LIGHTS_PASSES),
                byte_cell(case, PIPELINE_HELD_BYTES),
                figure(LIGHTS_DEPTHS_DIFFERING),
                figure(LAYERED_WRONG_PX),
            ],
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    });
    Table {
        caption: "Motion blur on devices, by way and number of layers".to_owned(),
        headings: headings(&[
            ("made of", None),
            ("interface", None),
            ("layers by", None),
            ("layers", None),
            ("rms", Some(BLUR_RMS)),
            ("largest", Some(BLUR_MAX)),
            ("time, ms", Some(time(clock))),
            ("passes", Some(LIGHTS_PASSES)),
            ("layers hold", Some(PIPELINE_HELD_BYTES)),
            ("texels that differ", Some(LIGHTS_DEPTHS_DIFFERING)),
            ("wrong pixels", Some(LAYERED_WRONG_PX)),
        ]),
        rows: rows.collect(),
        ..Table::default()
    }
}
