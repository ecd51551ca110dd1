// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows of several lights: depth maps in one pass or in many, with the counters behind their times.

use super::cells::{
    byte_cell, count, gain, headings, of, paired_finding, time, time_cell, values, why,
};
use crate::keys::{
    EXPERIMENT, LAYERS_BY, LIGHTS, LIGHTS_DEPTHS_DIFFERING, LIGHTS_MAP_ERROR, LIGHTS_PASSES,
    PIPELINE_GEOMETRY_INVOCATIONS, PIPELINE_HELD_BYTES, PIPELINE_MISMATCHED_PX,
    PIPELINE_PRIMITIVES, PIPELINE_VERTEX_INVOCATIONS,
};
use crate::lights::LightWay;
use crate::metrics::METRICS;
use terrafill_plot::number::{significant, times};
use terrafill_results::{
    Block, Case, Cell, Claim, Clock, Finding, Metric, Picture, PictureFigure, Pictures, Row, Run,
    Scope, Standing, Table,
};

const MAPS_CPU: &Metric = Metric::of(&METRICS, "lights_maps_cpu_ms");
const MAPS_GPU: &Metric = Metric::of(&METRICS, "lights_maps_gpu_ms");

const WHAT_IS_COMPARED: &str = "Distant lights stand all round the ground. Their depth maps are the layers of one image; the picture's pixels \
     say which lights reach them, by one lookup each. The published way draws all maps in one pass, in which \
     a geometry shader copies each triangle into every layer; a pass a light is what it is held \
     against. All ways leave the same depths bit for bit. The reference follows the ray of each map's texel, and \
     beside it the ray of the place itself, whose difference is the map's error.";
const WHAT_WAS_PUBLISHED: &str = "Published are \"2 passes\" in words, without number of lights, sizes or times. A geometry shader was given 32 \
     matrices, so at most 10 lights of three, or 15 that share one. Multiview has a limit of views a \
     pass; more lights take several passes, all with as many views.";

fn one<'a>(cases: &[&'a Case], way: LightWay, lights: u32) -> Option<&'a Case> {
    let lights = lights.to_string();
    let conditions = [(LAYERS_BY, way.name()), (LIGHTS, lights.as_str())];
    of(cases, &conditions).first().copied()
}

fn own<'a>(cases: &[&'a Case]) -> Vec<&'a Case> {
    of(cases, &[(EXPERIMENT, "lights")])
}

pub(super) fn section(cases: &[&Case], run: &Run) -> Vec<Block> {
    let clock = run.clock();
    let own = own(cases);
    if own.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        Block::section("Shadows of several lights"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
    ];
    blocks.push(Block::Finding(claim(&own, run)));
    blocks.extend(pictures(&own));
    blocks.push(Block::Table(table(&own, clock)));
    blocks.push(Block::Remark(WHAT_WAS_PUBLISHED.to_owned()));
    blocks
}

/// What is required: the same depths everywhere.
pub(super) fn findings(cases: &[&Case]) -> Vec<Finding> {
    let own = own(cases);
    if own.is_empty() {
        return Vec::new();
    }
    let differing = own
        .iter()
        .filter_map(|case| case.value(LIGHTS_DEPTHS_DIFFERING));
    let differing: Vec<f64> = differing.collect();
    let most = differing.iter().copied().max_by(f64::total_cmp);
    vec![Finding {
        claim: "Every way to the maps of several lights leaves the same depths, bit for bit:"
            .to_owned(),
        standing: most.map_or(Standing::NotMeasured, |most| {
            Standing::holds_if(most <= 0.0)
        }),
        because: most.map_or_else(String::new, |most| {
            format!("at most {most} texels differ in {} cases", differing.len())
        }),
    }]
}

fn claim(cases: &[&Case], run: &Run) -> Finding {
    let several = values(cases, LIGHTS)
        .into_iter()
        .filter(|lights| *lights >= 4);
    let pairs = several.filter_map(|lights| {
        let case = |way| one(cases, way, lights);
        Some([case(LightWay::Passes)?, case(LightWay::Copied)?])
    });
    let claim = "Maps of four lights and more are faster copied by a geometry shader in one pass than in a pass each \
                 (published in words):";
    paired_finding(
        run,
        (LAYERS_BY, &[]),
        (run.clock().pick(MAPS_GPU, MAPS_CPU), Scope::DRAW),
        &pairs.collect::<Vec<_>>(),
        (claim.to_owned(), Claim::Faster),
    )
}

/// The fastest way to the maps of the most lights, with its counters.
pub(super) fn recommended(cases: &[&Case], clock: Clock) -> Option<String> {
    let own = own(cases);
    let maps = clock.pick(MAPS_GPU, MAPS_CPU);
    let timed = own
        .into_iter()
        .filter(|case| case.counts() && case.value(maps).is_some());
    let timed: Vec<&Case> = timed.collect();
    let lights = *values(&timed, LIGHTS).last()?;
    let of_most = of(&timed, &[(LIGHTS, &lights.to_string())]);
    let ms = |case: &&Case| case.value(maps).unwrap_or(f64::INFINITY);
    let best = of_most
        .iter()
        .copied()
        .min_by(|a, b| ms(a).total_cmp(&ms(b)))?;
    let figure = |case: &Case, metric| {
        let value = case.value(metric).map(significant);
        value.unwrap_or_else(|| "–".to_owned())
    };
    let against = one(&of_most, LightWay::Copied, lights)
        .filter(|copied| copied.id() != best.id())
        .map(|copied| {
            format!(
                "; the published copies take {} ms with {} vertex shader invocations",
                significant(ms(&copied)),
                figure(copied, PIPELINE_VERTEX_INVOCATIONS),
            )
        });
    Some(format!(
        "Maps of {lights} lights are drawn fastest by {}: {} ms in {} passes with the picture, {} vertex shader \
         invocations{}.",
        best.condition(LAYERS_BY),
        significant(ms(&best)),
        figure(best, LIGHTS_PASSES),
        figure(best, PIPELINE_VERTEX_INVOCATIONS),
        against.unwrap_or_default(),
    ))
}

fn pictures(cases: &[&Case]) -> Option<Block> {
    let with_pictures = cases.iter().filter(|case| !case.note("picture").is_empty());
    let figures: Vec<PictureFigure> = with_pictures
        .map(|case| PictureFigure {
            pictures: vec![Picture {
                path: case.note("picture").to_owned(),
                caption: format!("{} lights", case.condition(LIGHTS)),
            }],
            notes: vec![case.condition(LAYERS_BY).to_owned()],
        })
        .collect();
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            caption:
                "What the lights reach: the lighter, the more of them. All ways draw the same."
                    .to_owned(),
            reference: String::new(),
            figures,
        })
    })
}

fn table(cases: &[&Case], clock: Clock) -> Table {
    let maps = clock.pick(MAPS_GPU, MAPS_CPU);
    let mut rows = Vec::new();
    for lights in values(cases, LIGHTS) {
        for way in LightWay::ALL {
            let Some(case) = one(cases, way, lights) else {
                continue;
            };
            let figure = |metric| Cell::or_absent(case.value(metric).map(significant), why(case));
            let ratio = gain(Some(case), one(cases, LightWay::Passes, lights), maps);
            let error = case
                .value(LIGHTS_MAP_ERROR)
                .map(|share| significant(100.0 * share));
            rows.push(Row {
                cells: vec![
                    Cell::plain(lights.to_string()),
                    Cell::name(way.name()),
                    time_cell(case, maps),
                    Cell::or_absent(ratio.as_ref().map(times), why(case)),
                    time_cell(case, time(clock)),
                    figure(LIGHTS_PASSES),
                    count(case, PIPELINE_VERTEX_INVOCATIONS),
                    count(case, PIPELINE_GEOMETRY_INVOCATIONS),
                    count(case, PIPELINE_PRIMITIVES),
                    byte_cell(case, PIPELINE_HELD_BYTES),
                    figure(LIGHTS_DEPTHS_DIFFERING),
                    figure(PIPELINE_MISMATCHED_PX),
                    Cell::or_absent(error, why(case)),
                ],
                status: case.outcome.name().to_owned(),
                remark: case.reason.clone(),
            });
        }
    }
    Table {
        caption: "Depth maps of several lights, by every way on Vulkan".to_owned(),
        headings: headings(&[
            ("lights", None),
            ("layers by", None),
            ("maps, ms", Some(maps)),
            ("time ÷ that of passes", None),
            ("maps and picture, ms", Some(time(clock))),
            ("passes", Some(LIGHTS_PASSES)),
            ("vertices shaded", Some(PIPELINE_VERTEX_INVOCATIONS)),
            ("geometry invocations", Some(PIPELINE_GEOMETRY_INVOCATIONS)),
            ("primitives", Some(PIPELINE_PRIMITIVES)),
            ("maps", Some(PIPELINE_HELD_BYTES)),
            ("depths that differ", Some(LIGHTS_DEPTHS_DIFFERING)),
            ("wrong pixels", Some(PIPELINE_MISMATCHED_PX)),
            ("map's error, %", Some(LIGHTS_MAP_ERROR)),
        ]),
        rows,
        is_main: true,
        ..Table::default()
    }
}
