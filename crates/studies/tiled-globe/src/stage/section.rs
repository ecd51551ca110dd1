// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on who splits triangles across ±180°.

use super::PART;
use crate::metrics::{self, *};
use crate::tiles::section::{AT_SEAM, COUNT, LARGEST, MISSING, OFF_AT_SEAM, STEP};
use terrafill_globe_views::{DRAW, FRAME, MAKE};
use terrafill_lab::{Cases, Column, Names, Section, Select, finding};
use terrafill_results::Finding;

pub(crate) const SECTION: Section<'static> = Section {
    title: "The seam split by a geometry shader and by the CPU",
    text: "On Vulkan, 10 × 10 cells under tiles whose texels hold their own address in 24 bits. The geometry shader is the \
           published one: to each inserted vertex it gives its place, U and V'. The CPU splits by the same rule before \
           vertices are sent.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("view", VIEW),
        ("split by", SPLIT_BY),
        ("where U differs by", LIMIT),
    ]),
    columns: &[
        Column::metric("triangles sent", GLOBE_TRIANGLES),
        Column::metric("crossing", GLOBE_TILE_CROSSING),
        Column::metric("missed", GLOBE_TILE_MISSED).or("only the shader knows"),
        AT_SEAM,
        OFF_AT_SEAM,
        STEP,
        LARGEST,
        MISSING,
        COUNT,
        FRAME,
        MAKE,
        DRAW,
    ],
    findings: &[same_pixels],
    ..Section::EMPTY
};

fn same_pixels(cases: &Cases<'_>) -> Finding {
    let wrong = |by: &str, limit: &str| {
        let own = cases.with(&[(SPLIT_BY, by), (LIMIT, limit)]);
        own.sum(GLOBE_TILE_SEAM_WRONG_PX)
    };
    let by = ["geometry-shader", "cpu"];
    let all = by.map(|by| ["0.7", "0.5"].map(|limit| (by, limit, wrong(by, limit))));
    let words = all
        .as_flattened()
        .iter()
        .filter_map(|(by, limit, wrong)| Some(format!("{by} at {limit}: {} px wrong", (*wrong)?)));
    let [shader, cpu] = all.map(|of| of.map(|(.., wrong)| wrong));
    let pairs = shader.into_iter().zip(cpu);
    let same: Option<Vec<bool>> = pairs.map(|(a, b)| Some(a? == b?)).collect();
    finding(
        "The CPU's split is the geometry shader's: the same pixels are right",
        same.map(|same| same.into_iter().all(|same| same)),
        format!("{}.", words.collect::<Vec<_>>().join("; ")),
    )
}
