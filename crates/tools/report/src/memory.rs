// SPDX-License-Identifier: MIT OR Apache-2.0
//! The memory chapter: bytes of every layout by formula and as allocated, beside the figures of 2007.

use crate::interval::Standing;
use crate::number::{bytes, count, significant};
use crate::run_data::RunData;
use terrafill_results::legacy::MemoryRow;

/// The layout whose bytes the others' are divided by: every vertex twice, as a vertex shader needs.
pub(crate) const BASE: (&str, &str) = ("vertex", "doubled");

/// Cozzi (2007): bytes of California as one mesh that a geometry shader reads (1,056 vertices of 24
/// bytes, 3,321 indices of 2), and with one closed volume for each of its triangles.
pub(crate) const CALIFORNIA_2007: (u64, u64) = (31_986, 90_540);

/// Cozzi (2007): bytes of the geometry-shader version over the vertex-shader version, about.
pub(crate) const RATIO_2007: f64 = 0.40;

/// How far from [`RATIO_2007`] is still “about”.
const ABOUT: f64 = 0.05;

/// Backend and beginning of the layouts that a geometry shader reads.
const GEOMETRY_SHADER: (&str, &str) = ("native", "gs-");

/// The table of one scene.
pub(crate) struct MemoryTable {
    pub(crate) scene: String,
    pub(crate) rows: Vec<LayoutRow>,
    /// What the figures of 2007 come to here, with class and words of their standing.
    pub(crate) standings: Vec<(String, &'static str, &'static str)>,
}

/// One layout as printed.
pub(crate) struct LayoutRow {
    pub(crate) name: String,
    pub(crate) cells: Vec<String>,
    /// Formula and allocation differ, by this much.
    pub(crate) disagreement: Option<String>,
}

/// The chapter.
pub(crate) struct MemoryChapter {
    pub(crate) tables: Vec<MemoryTable>,
    /// Layouts whose bytes as allocated are not those of the formula, by name.
    pub(crate) red: Vec<String>,
}

/// Bytes of the scene itself: allocated by some backend, not repeated.
fn is_scene(row: &MemoryRow) -> bool {
    row.allocated_bytes().is_some()
}

/// The chapter; `None` for a run that recorded no bytes of layouts.
pub(crate) fn chapter(data: &RunData) -> Option<MemoryChapter> {
    let rows: Vec<&MemoryRow> = data.memory.iter().filter(|row| is_scene(row)).collect();
    let mut scenes: Vec<&str> = Vec::new();
    for row in &rows {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    let mut red = Vec::new();
    let tables: Vec<MemoryTable> = scenes
        .into_iter()
        .map(|scene| {
            let mut own: Vec<&MemoryRow> = rows
                .iter()
                .copied()
                .filter(|row| row.scene == scene)
                .collect();
            let backends: Vec<&str> = own.iter().map(|row| row.backend.as_str()).collect();
            own.sort_by_key(|row| backends.iter().position(|backend| *backend == row.backend));
            table(scene, &own, &mut red)
        })
        .collect();
    (!tables.is_empty()).then_some(MemoryChapter { tables, red })
}

fn table(scene: &str, rows: &[&MemoryRow], red: &mut Vec<String>) -> MemoryTable {
    let base = rows
        .iter()
        .find(|row| (row.backend.as_str(), row.layout.as_str()) == BASE)
        .map(|row| row.formula_bytes());
    let printed = rows.iter().map(|row| {
        let disagreement = disagreement(row);
        if let Some(what) = &disagreement {
            red.push(format!("{scene}/{}/{}: {what}", row.backend, row.layout));
        }
        let ratio = ratio(row, base).map_or_else(|| "–".to_owned(), times);
        LayoutRow {
            name: format!("{}/{}", row.backend, row.layout),
            cells: vec![
                count(row.regions),
                count(row.mesh_vertices),
                count(row.mesh_triangles),
                count(row.boundary_edges),
                count(row.formula_bytes()),
                row.allocated_bytes().map_or_else(|| "–".to_owned(), count),
                significant(row.formula_bytes() as f64 / row.regions.max(1) as f64),
                count(row.region_bytes_smallest),
                count(row.region_bytes_median),
                count(row.region_bytes_largest),
                ratio,
            ],
            disagreement,
        }
    });
    MemoryTable {
        scene: scene.to_owned(),
        rows: printed.collect(),
        standings: standings(rows, base),
    }
}

fn times(ratio: f64) -> String {
    format!("{} ×", significant(ratio))
}

fn ratio(row: &MemoryRow, base: Option<u64>) -> Option<f64> {
    let base = base.filter(|base| *base > 0)?;
    Some(row.formula_bytes() as f64 / base as f64)
}

/// How formula and allocation differ, if they do.
fn disagreement(row: &MemoryRow) -> Option<String> {
    let pairs = [
        (
            "positions and flags",
            row.formula_vertex_bytes,
            row.allocated_vertex_bytes?,
        ),
        (
            "indices",
            row.formula_index_bytes,
            row.allocated_index_bytes?,
        ),
    ];
    let differing = pairs
        .into_iter()
        .filter(|(_, formula, allocated)| formula != allocated)
        .map(|(what, formula, allocated)| {
            format!("{what}: {formula} bytes by formula, {allocated} allocated")
        });
    Some(differing.collect::<Vec<_>>().join("; ")).filter(|text| !text.is_empty())
}

/// Each geometry-shader layout beside “about 40 %”.
fn standings(rows: &[&MemoryRow], base: Option<u64>) -> Vec<(String, &'static str, &'static str)> {
    rows.iter()
        .filter(|row| row.backend == GEOMETRY_SHADER.0 && row.layout.starts_with(GEOMETRY_SHADER.1))
        .filter_map(|row| {
            let ratio = ratio(row, base)?;
            let standing = about(ratio);
            let name = format!("{}/{}: {}", row.backend, row.layout, times(ratio));
            Some((name, standing.class(), standing.name()))
        })
        .collect()
}

fn about(ratio: f64) -> Standing {
    if (ratio - RATIO_2007).abs() <= ABOUT {
        Standing::Holds
    } else {
        Standing::DoesNot
    }
}

/// What is said above the tables of the figures of 2007.
pub(crate) fn published() -> String {
    let (mesh, volumes) = CALIFORNIA_2007;
    format!(
        "{}: California took {} bytes as one mesh and {} with a volume for each triangle ({} ×); \
         the geometry-shader version needed about {} % of the bytes of the vertex-shader version.",
        crate::ladder::SOURCE,
        count(mesh),
        count(volumes),
        significant(mesh as f64 / volumes as f64),
        significant(RATIO_2007 * 100.0),
    )
}

/// A layout's bytes over numbers of regions: label and points.
pub(crate) struct Curve {
    pub(crate) name: String,
    /// Regions and bytes by formula, rising.
    pub(crate) points: Vec<[f64; 2]>,
    /// Regions and bytes as allocated.
    pub(crate) allocated: Option<[f64; 2]>,
}

/// Curves of one scene.
pub(crate) fn curves(data: &RunData, scene: &str) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in data.memory.iter().filter(|row| row.scene == scene) {
        let name = format!("{}/{}", row.backend, row.layout);
        let at = |total: u64| [row.regions as f64, total as f64];
        let point = at(row.formula_bytes());
        let allocated = row.allocated_bytes().map(at);
        let known = curves.iter().position(|curve| curve.name == name);
        let index = known.unwrap_or_else(|| {
            curves.push(Curve {
                name,
                points: Vec::new(),
                allocated: None,
            });
            curves.len() - 1
        });
        // The scene itself is a point beside the curve: what is made every frame is made for the
        // regions in view only.
        match allocated {
            Some(allocated) => curves[index].allocated = Some(allocated),
            None => curves[index].points.push(point),
        }
    }
    for curve in &mut curves {
        curve.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    curves
}

/// A short sum for captions.
pub(crate) fn range_text(curves: &[Curve]) -> String {
    let most = curves.iter().filter_map(|curve| curve.points.last());
    let most = most.map(|point| point[1]).fold(0.0, f64::max);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a byte count that came from an integer"
    )]
    let most = most as u64;
    bytes(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(backend: &str, layout: &str, vertex: u64, index: u64) -> MemoryRow {
        MemoryRow {
            scene: "s".to_owned(),
            backend: backend.to_owned(),
            layout: layout.to_owned(),
            regions: 2,
            mesh_vertices: 10,
            mesh_triangles: 8,
            boundary_edges: 10,
            boundary_loops: 1,
            formula_vertex_bytes: vertex,
            formula_index_bytes: index,
            allocated_vertex_bytes: Some(vertex),
            allocated_index_bytes: Some(index),
            region_bytes_smallest: 1,
            region_bytes_median: 2,
            region_bytes_largest: 3,
        }
    }

    #[test]
    fn a_formula_off_by_one_byte_is_red() {
        let right = row("vertex", "doubled", 320, 142);
        let mut red = Vec::new();
        let table_of = |row: &MemoryRow, red: &mut Vec<String>| table("s", &[row], red);
        assert_eq!(table_of(&right, &mut red).rows[0].disagreement, None);
        assert_eq!(red, [""; 0]);
        let mut wrong = right.clone();
        wrong.formula_index_bytes += 1;
        assert!(table_of(&wrong, &mut red).rows[0].disagreement.is_some());
        assert_eq!(
            red,
            ["s/vertex/doubled: indices: 143 bytes by formula, 142 allocated"]
        );
        // Errors that cancel in the sum are two errors.
        let mut swapped = right;
        swapped.formula_index_bytes += 1;
        swapped.formula_vertex_bytes -= 1;
        red.clear();
        table_of(&swapped, &mut red);
        assert!(red[0].contains("positions") && red[0].contains("indices"));
    }

    #[test]
    fn about_forty_per_cent_is_judged_by_the_bytes() {
        let base = row("vertex", "doubled", 800, 200);
        let judge = |bytes: u64| {
            let native = row("native", "gs-line", bytes, 0);
            let table = table("s", &[&base, &native], &mut Vec::new());
            assert_eq!(table.standings.len(), 1);
            table.standings[0].2
        };
        assert_eq!(judge(410), "holds");
        assert_eq!(judge(450), "holds");
        assert_eq!(judge(460), "does not hold");
        assert_eq!(judge(340), "does not hold");
        // A control of the same backend that needs none is no geometry shader.
        let control = row("native", "vs-control", 1_000, 0);
        let table_of_control = table("s", &[&base, &control], &mut Vec::new());
        assert_eq!(table_of_control.standings.len(), 0);
        // Without the layout it is divided by, nothing is said.
        let native = row("native", "gs-line", 410, 0);
        assert_eq!(table("s", &[&native], &mut Vec::new()).standings.len(), 0);
    }

    #[test]
    fn the_published_ratio_is_that_of_its_bytes() {
        let text = published();
        assert!(text.contains("31\u{202f}986") && text.contains("90\u{202f}540"));
        assert!(
            text.contains("0.353 ×") && text.contains("about 40.0 %"),
            "{text}"
        );
    }
}
