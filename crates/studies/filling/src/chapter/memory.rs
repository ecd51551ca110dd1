// SPDX-License-Identifier: MIT OR Apache-2.0
//! Memory: bytes of every layout by formula and as allocated, beside the figures of 2007.

use super::data::{Data, counter, grouped, has_role, layout_name};
use super::rungs::SOURCE;
use super::table::Show::{Count, Own};
use super::table::{Column, NOT_RECORDED, alarm, head, none_differs, part, table};
use crate::keys::*;
use crate::request::STUDY;
use terrafill_lab::{Cases, Drawing, Figure, Names, Panel, finding};
use terrafill_plot::PointStanding;
use terrafill_plot::number::{count, significant};
use terrafill_results::{Block, Case, Cell, ChapterError, Finding, Table};

/// The layout whose bytes the others' are divided by: every vertex twice, as a vertex shader needs.
const BASE: &str = "vertex/doubled";

/// Cozzi (2007): bytes of the geometry-shader version over the vertex-shader version, about.
const RATIO_2007: f64 = 0.40;

/// How far from [`RATIO_2007`] still counts as equal to it.
const ABOUT: f64 = 0.05;

/// Bytes of the document's own layouts (4.2, 4.3) on its California. With 1,056 vertices and 1,107
/// triangles a region without holes has 2 · 1,056 − 2 − 1,107 = 1,003 boundary edges. The geometry shader
/// reads vertices of 12 bytes and 3 indices for each boundary edge beside the triangles'; the vertex
/// shader two copies of 16 bytes, two caps, and 2 indices of a strip for each boundary edge.
const BY_LAYOUTS_2007: [u64; 2] = [
    1_056 * 12 + (3_321 + 3 * 1_003) * 2,
    1_056 * 2 * 16 + (2 * 3_321 + 2 * 1_003) * 2,
];

/// The layout that the document describes: triangles, and a degenerate one for each boundary edge, in a
/// list.
const LAYOUT_2007: &str = "native/gs-degenerate/list";

/// Technique and beginning of the layouts that a geometry shader reads.
const GEOMETRY_SHADER: (&str, &str) = ("native", "gs-");

const COLUMNS: [Column; 13] = [
    ("layout", Own("")),
    ("regions", Own("")),
    ("vertices of meshes", Count(MESH_VERTICES)),
    ("triangles of one cap", Count(MESH_TRIANGLES)),
    ("boundary edges", Count(BOUNDARY_EDGES)),
    ("boundary loops", Count(BOUNDARY_LOOPS)),
    (
        "bytes by formula",
        Own("formula_vertex_bytes + formula_index_bytes"),
    ),
    (
        "bytes allocated",
        Own("allocated_vertex_bytes + allocated_index_bytes"),
    ),
    ("a region, mean", Own("")),
    ("smallest", Count(REGION_BYTES_SMALLEST)),
    ("median", Count(REGION_BYTES_MEDIAN)),
    ("largest", Count(REGION_BYTES_LARGEST)),
    ("÷\u{a0}vertex/doubled", Own("")),
];

/// An open mark stands beside the curve where the scene itself holds less: what is made every frame is made for the
/// regions in view only.
const GROWTH: Drawing<'static> = Drawing {
    caption: "Bytes by formula, the regions of the scene repeated in turn; open mark: the scene itself, as allocated.",
    panels: &[Panel {
        across: ("regions", Figure::Condition(REGIONS)),
        up: ("bytes", Figure::Computed(drawn_bytes)),
        curve: Names::Of("layout", layout_name),
        knob: Figure::Condition(REGIONS),
        standing: |case| match allocated_bytes(case) {
            Some(_) => PointStanding::Approximate,
            None => PointStanding::Right,
        },
        ..Panel::EMPTY
    }],
};

fn drawn_bytes(case: &Case) -> Option<f64> {
    let bytes = allocated_bytes(case).or_else(|| formula_bytes(case))?;
    Some(bytes as f64)
}

fn regions(case: &Case) -> u64 {
    case.condition(REGIONS).parse().unwrap_or(0)
}

fn formula_bytes(case: &Case) -> Option<u64> {
    Some(counter(case, FORMULA_VERTEX_BYTES)? + counter(case, FORMULA_INDEX_BYTES)?)
}

/// `None` for a layout that nothing allocated: of a scene's regions repeated in turn.
fn allocated_bytes(case: &Case) -> Option<u64> {
    Some(counter(case, ALLOCATED_VERTEX_BYTES)? + counter(case, ALLOCATED_INDEX_BYTES)?)
}

/// Scenes with the layouts that some technique allocated, those of a technique together.
fn allocated<'a>(data: &Data<'a>) -> Vec<(&'a str, Vec<&'a Case>)> {
    let own = data.memory.iter().copied();
    let own = own.filter(|case| allocated_bytes(case).is_some());
    let scenes = grouped(own, |case| case.condition(SCENE)).into_iter();
    let by_technique = |(scene, cases): (&'a str, Vec<&'a Case>)| {
        let techniques = grouped(cases, |case| case.condition(TECHNIQUE)).into_iter();
        (scene, techniques.flat_map(|(_, cases)| cases).collect())
    };
    scenes.map(by_technique).collect()
}

/// Tables of every scene that some technique allocated, and its growth over regions.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let scenes = allocated(data);
    if scenes.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = head(
        "Memory",
        "Bytes of positions, flags and indices, by each layout's formula and as its technique allocated \
             them, without constants. The two must agree. Layouts that are made every frame hold, beside \
             what they read, only what the view draws. Walls of vertex/per-triangle are lists, 24 indices a \
             volume; as strips they would have 18.",
    );
    let rows = scenes.iter().flat_map(|(_, own)| own);
    let red = rows.filter_map(|case| {
        let what = disagreement(case)?;
        Some(format!(
            "{}/{}: {what}",
            case.condition(SCENE),
            layout_name(case)
        ))
    });
    blocks.extend(alarm("Formula and allocation differ:", red.collect()));
    for (scene, own) in &scenes {
        blocks.push(part(format!("Bytes of {scene}")));
        let of_scene = |case: &Case| case.condition(SCENE) == *scene && has_role(case, "memory");
        let drawn = Cases::of_study(data.run, STUDY).fitting(of_scene);
        blocks.extend(GROWTH.block(&format!("{scene}: bytes over regions"), &drawn)?);
        blocks.push(Block::Table(layouts(data, own)));
        blocks.extend(findings(own).into_iter().map(Block::Finding));
    }
    Ok(blocks)
}

/// Formula and allocation agree; `None` for a run that allocated nothing.
pub(super) fn requirement(data: &Data<'_>) -> Option<Finding> {
    let scenes = allocated(data).into_iter();
    let all: Vec<&Case> = scenes.flat_map(|(_, own)| own).collect();
    let differing = all.iter().filter(|case| disagreement(case).is_some());
    let claim = "Every layout allocates the bytes of its formula.";
    (!all.is_empty())
        .then(|| none_differs(claim, all.len(), differing.count(), "layouts of scenes do"))
}

fn base(rows: &[&Case]) -> Option<u64> {
    let base = rows.iter().find(|case| layout_name(case) == BASE)?;
    formula_bytes(base).filter(|bytes| *bytes > 0)
}

fn layouts(data: &Data<'_>, own: &[&Case]) -> Table {
    let base = base(own);
    let rows = own.iter().map(|case| {
        let formula = formula_bytes(case);
        let mean = formula.map(|bytes| significant(bytes as f64 / regions(case).max(1) as f64));
        let ratio = formula.zip(base);
        let ratio = ratio.map(|(own, base)| times(own as f64 / base as f64));
        let cells = vec![
            Cell::name(layout_name(case)),
            Cell::plain(count(regions(case))),
            Cell::or_absent(formula.map(count), NOT_RECORDED),
            Cell::or_absent(allocated_bytes(case).map(count), "not allocated"),
            Cell::or_absent(mean, NOT_RECORDED),
            Cell::or_absent(ratio, "vertex/doubled was not measured"),
        ];
        (*case, cells)
    });
    let mut table = table(data, &COLUMNS, rows);
    let rows = table.rows.into_iter().zip(own);
    table.rows = rows
        .map(|(row, case)| row.bad_if(disagreement(case).is_some()))
        .collect();
    table
}

fn times(ratio: f64) -> String {
    format!("{} ×", significant(ratio))
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
        let (formula, allocated) = (counter(case, formula)?, counter(case, allocated)?);
        (formula != allocated)
            .then(|| format!("{what}: {formula} bytes by formula, {allocated} allocated"))
    });
    Some(differing.collect::<Vec<_>>().join("; ")).filter(|text| !text.is_empty())
}

/// Each geometry-shader layout beside the document's 40 %.
fn findings(rows: &[&Case]) -> Vec<Finding> {
    let ratios = ratios_to_base(rows).into_iter();
    let claim = format!(
        "{SOURCE}, measured: “only about 40% of the memory”; {} by the document's layouts.",
        times(ratio_by_layouts())
    );
    let found = ratios.map(|(name, ratio)| {
        let because = format!("{name} takes {} {BASE}", times(ratio));
        finding(&claim, Some((ratio - RATIO_2007).abs() <= ABOUT), because)
    });
    found.collect()
}

/// Layouts that a geometry shader reads, by name, and their bytes over [`BASE`].
fn ratios_to_base(rows: &[&Case]) -> Vec<(String, f64)> {
    let base = base(rows);
    let (technique, beginning) = GEOMETRY_SHADER;
    let of_geometry_shader = rows.iter().filter(|case| {
        case.condition(TECHNIQUE) == technique && case.condition(LAYOUT).starts_with(beginning)
    });
    of_geometry_shader
        .filter_map(|case| {
            Some((
                layout_name(case),
                formula_bytes(case)? as f64 / base? as f64,
            ))
        })
        .collect()
}

/// Geometry shader over vertex shader by the document's own layouts.
fn ratio_by_layouts() -> f64 {
    let [geometry_shader, vertex_shader] = BY_LAYOUTS_2007;
    geometry_shader as f64 / vertex_shader as f64
}

/// Why layouts in strips come nearer to the document's figure than its own layout does.
pub(super) fn why_strips_are_smaller() -> String {
    format!(
        "In a list every triangle and every boundary edge takes 3 indices, which gives {} × on the \
         document's California; in strips a triangle takes little more than 1 and a boundary edge 2, and \
         indices are half of the bytes",
        significant(ratio_by_layouts())
    )
}

/// Whether the document describes a layout.
pub(super) fn is_documents_layout(name: &str) -> bool {
    name == LAYOUT_2007
}

/// Bytes of each geometry shader's layout over [`BASE`], on the first scene that has both.
pub(super) fn geometry_shader_ratios(data: &Data<'_>) -> Vec<(String, f64)> {
    let scenes = allocated(data).into_iter();
    let mut ratios = scenes.map(|(_, own)| ratios_to_base(&own));
    ratios.find(|ratios| !ratios.is_empty()).unwrap_or_default()
}
