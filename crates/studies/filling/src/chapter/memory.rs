// SPDX-License-Identifier: MIT OR Apache-2.0
//! Memory: bytes of every layout by formula and as allocated, beside the figures of 2007.

use super::data::{Data, counter, distinct, headings};
use super::rungs::SOURCE;
use crate::keys::{
    ALLOCATED_INDEX_BYTES, ALLOCATED_VERTEX_BYTES, BOUNDARY_EDGES, BOUNDARY_LOOPS,
    FORMULA_INDEX_BYTES, FORMULA_VERTEX_BYTES, LAYOUT, MESH_TRIANGLES, MESH_VERTICES,
    REGION_BYTES_LARGEST, REGION_BYTES_MEDIAN, REGION_BYTES_SMALLEST, REGIONS, SCENE, TECHNIQUE,
};
use terrafill_plot::number::{bytes, count, significant};
use terrafill_plot::{Line, LinePanel, Lines, Palette};
use terrafill_results::{
    Block, Case, Cell, ChapterError, Finding, Heading, Metric, Plot, Row, Standing, Table,
};

/// The layout whose bytes the others' are divided by: every vertex twice, as a vertex shader needs.
pub(super) const BASE: &str = "vertex/doubled";

/// Cozzi (2007): bytes of California as one mesh that a geometry shader reads (1,056 vertices of 24
/// bytes, 3,321 indices of 2), and with one closed volume for each of its triangles.
const CALIFORNIA_2007: (u64, u64) = (31_986, 90_540);

/// The same volumes with the 24 indices that the document gives each of them a page before, 8 times as many
/// as the mesh has and not 6.
const CALIFORNIA_24_INDICES: u64 = 1_056 * 48 + 1_107 * 24 * 2;

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

/// Columns before the bytes of a region.
const COLUMNS: [(&str, &Metric); 4] = [
    ("vertices of meshes", MESH_VERTICES),
    ("triangles of one cap", MESH_TRIANGLES),
    ("boundary edges", BOUNDARY_EDGES),
    ("boundary loops", BOUNDARY_LOOPS),
];

/// Bytes of a region by formula.
const REGION_COLUMNS: [(&str, &Metric); 3] = [
    ("smallest", REGION_BYTES_SMALLEST),
    ("median", REGION_BYTES_MEDIAN),
    ("largest", REGION_BYTES_LARGEST),
];

fn name(case: &Case) -> String {
    format!("{}/{}", case.condition(TECHNIQUE), case.condition(LAYOUT))
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

/// Tables of every scene that some technique allocated, and its growth over regions.
pub(super) fn blocks(data: &Data<'_>) -> Result<Vec<Block>, ChapterError> {
    let allocated = data
        .memory
        .iter()
        .copied()
        .filter(|case| allocated_bytes(case).is_some());
    let rows: Vec<&Case> = allocated.collect();
    if rows.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = vec![
        Block::section("Memory"),
        Block::Text(format!(
            "{} Here: bytes of positions, flags and indices, by each layout's formula and as its \
             technique allocated them, without constants. The two must agree. Layouts that are made \
             every frame hold, beside what they read, only what the view draws.",
            published()
        )),
    ];
    let red: Vec<String> = rows
        .iter()
        .filter_map(|case| {
            let what = disagreement(case)?;
            Some(format!("{}/{}: {what}", case.condition(SCENE), name(case)))
        })
        .collect();
    if !red.is_empty() {
        blocks.push(Block::Alarm("Formula and allocation differ:".to_owned()));
        blocks.push(Block::List(red));
    }
    let scenes = distinct(rows.iter().map(|case| case.condition(SCENE)));
    blocks.extend(plot(data, &scenes)?);
    for scene in scenes {
        let own = rows
            .iter()
            .copied()
            .filter(|case| case.condition(SCENE) == scene);
        let mut own: Vec<&Case> = own.collect();
        let techniques = distinct(own.iter().map(|case| case.condition(TECHNIQUE)));
        own.sort_by_key(|case| {
            techniques
                .iter()
                .position(|known| *known == case.condition(TECHNIQUE))
        });
        blocks.push(Block::Heading {
            level: 4,
            text: format!("Bytes of {scene}"),
        });
        blocks.push(Block::Table(table(&own)));
        blocks.extend(findings(&own).into_iter().map(Block::Finding));
    }
    Ok(blocks)
}

/// Formula and allocation agree; `None` for a run that allocated nothing.
pub(super) fn requirement(data: &Data<'_>) -> Option<Finding> {
    let allocated = data
        .memory
        .iter()
        .filter(|case| allocated_bytes(case).is_some());
    let allocated: Vec<_> = allocated.collect();
    let differing = allocated.iter().filter(|case| disagreement(case).is_some());
    let differing = differing.count();
    (!allocated.is_empty()).then(|| Finding {
        claim: "Every layout allocates the bytes of its formula.".to_owned(),
        standing: Standing::holds_if(differing == 0),
        because: format!(
            "{} of {} layouts of scenes do",
            allocated.len() - differing,
            allocated.len()
        ),
    })
}

fn base(rows: &[&Case]) -> Option<u64> {
    let base = rows.iter().find(|case| name(case) == BASE)?;
    formula_bytes(base).filter(|bytes| *bytes > 0)
}

fn table(rows: &[&Case]) -> Table {
    let base = base(rows);
    let mut columns = headings("layout", &[]);
    columns.push(Heading::plain("regions"));
    columns.extend(COLUMNS.map(|(text, metric)| Heading::metric(text, metric)));
    columns.push(Heading::explained(
        "bytes by formula",
        "formula_vertex_bytes + formula_index_bytes",
    ));
    columns.push(Heading::explained(
        "bytes allocated",
        "allocated_vertex_bytes + allocated_index_bytes",
    ));
    columns.push(Heading::plain("a region, mean"));
    columns.extend(REGION_COLUMNS.map(|(text, metric)| Heading::metric(text, metric)));
    columns.push(Heading::plain("÷\u{a0}vertex/doubled"));
    let row = |case: &&Case| {
        let counted =
            |metric: &Metric| Cell::or_absent(counter(case, metric).map(count), "not recorded");
        let formula = formula_bytes(case);
        let mean = formula.map(|bytes| significant(bytes as f64 / regions(case).max(1) as f64));
        let ratio = formula
            .zip(base)
            .map(|(own, base)| times(own as f64 / base as f64));
        let mut cells = vec![Cell::name(name(case)), Cell::plain(count(regions(case)))];
        cells.extend(COLUMNS.map(|(_, metric)| counted(metric)));
        cells.push(Cell::or_absent(formula.map(count), "not recorded"));
        cells.push(Cell::or_absent(
            allocated_bytes(case).map(count),
            "not allocated",
        ));
        cells.push(Cell::or_absent(mean, "not recorded"));
        cells.extend(REGION_COLUMNS.map(|(_, metric)| counted(metric)));
        cells.push(Cell::or_absent(ratio, "vertex/doubled was not measured"));
        Row::new(cells).bad_if(disagreement(case).is_some())
    };
    Table {
        headings: columns,
        rows: rows.iter().map(row).collect(),
        ..Table::default()
    }
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
    ratios
        .map(|(name, ratio)| Finding {
            claim: format!(
                "{SOURCE}, measured: “only about 40% of the memory”; {} by the document's layouts.",
                times(ratio_by_layouts())
            ),
            standing: Standing::holds_if((ratio - RATIO_2007).abs() <= ABOUT),
            because: format!("{name} takes {} {BASE}", times(ratio)),
        })
        .collect()
}

/// Layouts that a geometry shader reads, by name, and their bytes over [`BASE`].
fn ratios_to_base(rows: &[&Case]) -> Vec<(String, f64)> {
    let base = base(rows);
    let (technique, beginning) = GEOMETRY_SHADER;
    let of_geometry_shader = rows.iter().filter(|case| {
        case.condition(TECHNIQUE) == technique && case.condition(LAYOUT).starts_with(beginning)
    });
    of_geometry_shader
        .filter_map(|case| Some((name(case), formula_bytes(case)? as f64 / base? as f64)))
        .collect()
}

/// Geometry shader over vertex shader by the document's own layouts.
fn ratio_by_layouts() -> f64 {
    let [geometry_shader, vertex_shader] = BY_LAYOUTS_2007;
    geometry_shader as f64 / vertex_shader as f64
}

/// What is said above the tables of the figures of 2007.
fn published() -> String {
    let (mesh, volumes) = CALIFORNIA_2007;
    let over_mesh = |bytes: u64| significant(bytes as f64 / mesh as f64);
    format!(
        "{SOURCE}, 2.1.5: California took {} bytes as one mesh and {} with a volume for each triangle \
         ({} ×), which counts vertices twice and indices six times, 18 a volume. The same section gives a \
         volume 24 indices; then it is {} bytes ({} ×). The layout vertex/per-triangle here has 24; \
         walls as strips would have 18. 4.5: the geometry-shader version needed about {} % of the bytes \
         of the vertex-shader version. By the document's own layouts it is {} on its California. {}",
        count(mesh),
        count(volumes),
        over_mesh(volumes),
        count(CALIFORNIA_24_INDICES),
        over_mesh(CALIFORNIA_24_INDICES),
        significant(RATIO_2007 * 100.0),
        significant(ratio_by_layouts()),
        why_strips_are_smaller(),
    )
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
    let allocated = data.memory.iter().copied();
    let allocated = allocated.filter(|case| allocated_bytes(case).is_some());
    let rows: Vec<&Case> = allocated.collect();
    let ratios = distinct(rows.iter().map(|case| case.condition(SCENE)))
        .into_iter()
        .map(|scene| {
            let own = rows
                .iter()
                .copied()
                .filter(|case| case.condition(SCENE) == scene);
            ratios_to_base(&own.collect::<Vec<_>>())
        });
    let mut with_any = ratios.filter(|ratios| !ratios.is_empty());
    with_any.next().unwrap_or_default()
}

/// Bytes over numbers of regions, a panel a scene; ringed: the scene itself, as allocated. It stands
/// beside the line: what is made every frame is made for the regions in view only.
fn plot(data: &Data<'_>, scenes: &[&str]) -> Result<Option<Block>, ChapterError> {
    let panel = |scene: &&str| LinePanel {
        name: (*scene).to_owned(),
        lines: lines(data, scene),
    };
    let drawn = Lines {
        title: "bytes over regions".to_owned(),
        across: "regions",
        across_tick: count,
        up: "bytes",
        up_tick: bytes,
        panels: scenes.iter().map(panel).collect(),
    };
    let svg = drawn.draw(&Palette::new(data.all_series()))?;
    Ok(svg.map(|svg| {
        Block::Plot(Plot {
            caption:
                "Bytes by formula, the regions of each scene repeated in turn; ringed: the scene \
                      itself, as allocated."
                    .to_owned(),
            svg,
        })
    }))
}

fn lines(data: &Data<'_>, scene: &str) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for &case in data
        .memory
        .iter()
        .filter(|case| case.condition(SCENE) == scene)
    {
        let known = lines.iter().position(|line| line.name == name(case));
        let index = known.unwrap_or_else(|| {
            lines.push(Line {
                name: name(case),
                points: Vec::new(),
                ringed: None,
            });
            lines.len() - 1
        });
        let at = |total: u64| [regions(case) as f64, total as f64];
        match (allocated_bytes(case), formula_bytes(case)) {
            (Some(allocated), _) => lines[index].ringed = Some(at(allocated)),
            (None, Some(formula)) => lines[index].points.push(at(formula)),
            (None, None) => {}
        }
    }
    for line in &mut lines {
        line.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    lines
}
