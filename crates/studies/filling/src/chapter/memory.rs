// SPDX-License-Identifier: MIT OR Apache-2.0
//! Memory: bytes of every layout by formula and as allocated.

use super::data::{Data, layout_name};
use super::table::head;
use crate::keys::*;
use crate::purpose::Purpose;
use terrafill_lab::{Cases, Column, Drawing, Figure, Names, Panel, Section, none_differs};
use terrafill_plot::number::digits;
use terrafill_results::{Block, Case, ChapterError, Estimate, Finding, Metric};

/// The layout whose bytes the others' are divided by: every vertex twice, as a vertex shader needs.
const BASE: &str = "vertex/doubled";

/// How names of layouts begin that a geometry shader reads.
const GEOMETRY_SHADER: &str = "native/gs-";

/// What a layout takes of a scene.
const LAYOUTS: Section<'static> = Section {
    named_by: Names::Of("layout", layout_name),
    columns: &[
        Column::of("regions", Figure::Condition(REGIONS)).written(digits),
        recorded("vertices of meshes", MESH_VERTICES),
        recorded("triangles of one cap", MESH_TRIANGLES),
        recorded("boundary edges", BOUNDARY_EDGES),
        recorded("boundary loops", BOUNDARY_LOOPS),
        Column::of("bytes by formula", Figure::Computed(formula_bytes))
            .meaning("formula_vertex_bytes + formula_index_bytes")
            .written(digits),
        Column::of("bytes allocated", Figure::Computed(allocated_bytes))
            .meaning("allocated_vertex_bytes + allocated_index_bytes")
            .written(digits)
            .or("not allocated"),
        Column::of("a region, mean", Figure::Computed(region_bytes)),
        recorded("smallest", REGION_BYTES_SMALLEST),
        recorded("median", REGION_BYTES_MEDIAN),
        recorded("largest", REGION_BYTES_LARGEST),
        Column::beside("÷\u{a0}vertex/doubled", over_base).or("vertex/doubled was not measured"),
    ],
    is_bad: |case| disagreement(case).is_some(),
    ..Section::EMPTY
};

const fn recorded(heading: &'static str, metric: &'static Metric) -> Column {
    Column::metric(heading, metric).written(digits)
}

const GROWTH: Drawing<'static> = Drawing {
    caption: "Bytes by formula, of the scene's regions repeated in turn; those of the scene itself are in the table.",
    panels: &[Panel {
        across: ("regions", Figure::Condition(REGIONS)),
        up: ("bytes", Figure::Computed(repeated_bytes)),
        curve: Names::Of("layout", layout_name),
        knob: Figure::Condition(REGIONS),
        ..Panel::EMPTY
    }],
};

/// `None` for the scene itself: what is made every frame is made for the regions in view only.
fn repeated_bytes(case: &Case) -> Option<f64> {
    allocated_bytes(case)
        .is_none()
        .then(|| formula_bytes(case))?
}

fn formula_bytes(case: &Case) -> Option<f64> {
    Some(case.value(FORMULA_VERTEX_BYTES)? + case.value(FORMULA_INDEX_BYTES)?)
}

/// `None` for a layout that nothing allocated: of a scene's regions repeated in turn.
fn allocated_bytes(case: &Case) -> Option<f64> {
    Some(case.value(ALLOCATED_VERTEX_BYTES)? + case.value(ALLOCATED_INDEX_BYTES)?)
}

fn region_bytes(case: &Case) -> Option<f64> {
    let regions: f64 = case.condition(REGIONS).parse().ok()?;
    Some(formula_bytes(case)? / regions.max(1.0))
}

/// Bytes by formula over those of [`BASE`].
fn over_base(of_scene: &Cases<'_>, case: &Case) -> Option<Estimate> {
    let base = of_scene.iter().find(|case| layout_name(case) == BASE)?;
    let base = formula_bytes(base).filter(|bytes| *bytes > 0.0)?;
    Some(Estimate {
        interval: None,
        ..Estimate::exact(formula_bytes(case)? / base)
    })
}

/// Layouts of scenes, and of their regions repeated in turn.
fn layouts<'a>(data: &Data<'a>) -> Cases<'a> {
    data.study.fitting(|case| Purpose::Memory.is_of(case))
}

/// Those of scenes that some technique allocated.
fn allocated<'a>(layouts: &Cases<'a>) -> Cases<'a> {
    layouts.fitting(|case| allocated_bytes(case).is_some())
}

/// Tables of every scene that some technique allocated, and its growth over regions.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let layouts = layouts(data);
    let allocated = allocated(&layouts);
    if allocated.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = head(
        "Memory",
        "Bytes of positions, flags and indices, by each layout's formula and as its technique allocated \
             them, without constants. The two must agree. Layouts that are made every frame hold, beside \
             what they read, only what the view draws. Walls of vertex/per-triangle are lists, 24 indices a \
             volume; as strips they would have 18.",
    );
    for (scene, own) in allocated.by(SCENE) {
        blocks.push(Block::part(format!("Bytes of {scene}")));
        let of_scene = layouts.with(&[(SCENE, scene)]);
        blocks.extend(GROWTH.block(&format!("{scene}: bytes over regions"), &of_scene)?);
        blocks.push(Block::Table(LAYOUTS.table("", &own)));
    }
    Ok(blocks)
}

/// Formula and allocation agree; `None` for a run that allocated nothing.
pub(super) fn requirement(data: &Data<'_>) -> Option<Finding> {
    let all = allocated(&layouts(data));
    let differing: Vec<String> = all.iter().filter_map(disagreement).collect();
    let claim = "Every layout allocates the bytes of its formula.";
    let what = "layouts of scenes do";
    (!all.is_empty()).then(|| none_differs(claim, all.iter().count(), &differing, what))
}

/// How formula and allocation differ, if they do. Errors that cancel in the sum are two errors.
fn disagreement(case: &Case) -> Option<String> {
    let pairs = [
        (
            "positions and flags",
            FORMULA_VERTEX_BYTES,
            ALLOCATED_VERTEX_BYTES,
        ),
        ("indices", FORMULA_INDEX_BYTES, ALLOCATED_INDEX_BYTES),
    ];
    let differing = pairs.iter().filter_map(|(what, formula, allocated)| {
        let (formula, allocated) = (case.value(formula)?, case.value(allocated)?);
        (formula != allocated)
            .then(|| format!("{what}: {formula} bytes by formula, {allocated} allocated"))
    });
    let differing: Vec<String> = differing.collect();
    let (scene, layout) = (case.condition(SCENE), layout_name(case));
    (!differing.is_empty()).then(|| format!("{scene}/{layout}: {}", differing.join("; ")))
}

/// Layouts that a geometry shader reads, by name, and their bytes over [`BASE`], on the first scene that has
/// both.
pub(super) fn geometry_shader_ratios(data: &Data<'_>) -> Vec<(String, f64)> {
    let mut scenes = allocated(&layouts(data))
        .by(SCENE)
        .into_iter()
        .map(|(_, own)| {
            let of_geometry_shader = own
                .iter()
                .filter(|case| layout_name(case).starts_with(GEOMETRY_SHADER));
            let ratio = |case| Some((layout_name(case), over_base(&own, case)?.middle));
            of_geometry_shader.filter_map(ratio).collect::<Vec<_>>()
        });
    scenes.find(|ratios| !ratios.is_empty()).unwrap_or_default()
}
