// SPDX-License-Identifier: MIT OR Apache-2.0
//! What each column and plot term means, read from `GLOSSARY.md`, so that the file and the report's
//! tooltips cannot say different things.
//!
//! An entry is a table row whose first cell is a term in backquotes: ``| `term` | meaning |``.

const GLOSSARY: &str = include_str!("../../../../GLOSSARY.md");

/// Every term with its meaning, in the file's order.
pub(crate) fn entries() -> Vec<(&'static str, String)> {
    GLOSSARY.lines().filter_map(entry).collect()
}

/// What `term` means.
pub(crate) fn meaning(term: &str) -> Option<String> {
    entries()
        .into_iter()
        .find_map(|(name, meaning)| (name == term).then_some(meaning))
}

fn entry(line: &'static str) -> Option<(&'static str, String)> {
    let (term, rest) = line.strip_prefix("| `")?.split_once("` | ")?;
    let meaning = rest.trim_end().strip_suffix('|')?.trim_end();
    Some((term, meaning.replace('`', "")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::{COLUMNS, PLOT_TERMS};
    use terrafill_results::legacy::{
        CaseKey, GrowthRow, LadderRung, MemoryRow, PrecisionPart, PrecisionRow, PrecisionTime,
        RunEnvironment, RunFolder, RunPlan, Sample, Status, Summary,
    };

    fn csv_columns() -> Vec<String> {
        let folder = tempfile::tempdir().expect("a folder");
        let run = RunFolder::create(
            folder.path(),
            &RunEnvironment::default(),
            &RunPlan::default(),
        )
        .expect("an empty folder");
        let key = CaseKey {
            scene: "s".to_owned(),
            view: "v".to_owned(),
            backend: "b".to_owned(),
            variant: "x".to_owned(),
        };
        run.append_samples(&[Sample {
            scene: key.scene.clone(),
            view: key.view.clone(),
            backend: key.backend.clone(),
            variant: key.variant.clone(),
            frame: 0,
            surface_gpu_ms: None,
            stencil_gpu_ms: None,
            colour_gpu_ms: None,
            fill_gpu_ms: None,
            fill_cpu_ms: 1.0,
            fill_wall_ms: 1.0,
        }])
        .expect("a sample");
        run.append_summary(&Summary::new(key, Status::Ok))
            .expect("a summary");
        run.append_growth(&GrowthRow {
            shape: "comb".to_owned(),
            outline_vertices: 1_000,
            repetition: 0,
            mesh_cpu_ms: 1.0,
        })
        .expect("a mesh build");
        run.write_ladder(&[LadderRung {
            ladder: "l".to_owned(),
            rung: 1,
            step: "s".to_owned(),
            change: "c".to_owned(),
            scene: "s".to_owned(),
            view: "v".to_owned(),
            backend: "b".to_owned(),
            variant: "x".to_owned(),
        }])
        .expect("a rung");
        run.append_memory(&[MemoryRow {
            scene: "s".to_owned(),
            backend: "b".to_owned(),
            layout: "l".to_owned(),
            regions: 1,
            mesh_vertices: 1,
            mesh_triangles: 1,
            boundary_edges: 1,
            boundary_loops: 1,
            formula_vertex_bytes: 1,
            formula_index_bytes: 1,
            allocated_vertex_bytes: None,
            allocated_index_bytes: None,
            region_bytes_smallest: 1,
            region_bytes_median: 1,
            region_bytes_largest: 1,
        }])
        .expect("bytes");
        run.append_precision(&[PrecisionRow::default()])
            .expect("a row of the numerical suite");
        run.append_precision_times(&[PrecisionTime {
            part: PrecisionPart::Coordinate,
            route: "r".to_owned(),
            round: 0,
            evaluations: 1,
            cpu_ms: 1.0,
            empty_cpu_ms: 0.5,
            gpu_ms: None,
            empty_gpu_ms: None,
        }])
        .expect("a timed pass");
        [
            "samples.csv",
            "summary.csv",
            "ladder.csv",
            "memory.csv",
            "growth.csv",
            "precision.csv",
            "precision_times.csv",
        ]
        .iter()
        .flat_map(|file| {
            let text = std::fs::read_to_string(folder.path().join(file)).expect("the file");
            let header = text.lines().next().expect("a header").to_owned();
            header.split(',').map(str::to_owned).collect::<Vec<_>>()
        })
        .collect()
    }

    fn unexplained<'a>(terms: impl IntoIterator<Item = &'a str>) -> Vec<String> {
        terms
            .into_iter()
            .filter(|term| meaning(term).is_none_or(|text| text.len() < 10))
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn every_csv_column_is_explained() {
        let columns = csv_columns();
        assert!(columns.len() > 130, "all headers were read: {columns:?}");
        assert!(columns.iter().any(|column| column == "mesh_cpu_ms"));
        assert_eq!(
            unexplained(columns.iter().map(String::as_str)),
            [""; 0],
            "columns without an entry in GLOSSARY.md"
        );
    }

    #[test]
    fn every_term_of_the_report_is_explained() {
        let of_ladder = crate::ladder::COLUMNS.iter().map(|(term, _)| *term);
        let terms = COLUMNS.iter().map(|column| column.term).chain(PLOT_TERMS);
        let terms = terms
            .chain(of_ladder)
            .chain(["standing", "matrix", "exponent"]);
        assert_eq!(unexplained(terms), [""; 0]);
    }

    #[test]
    fn a_made_up_column_is_not_explained() {
        assert_eq!(
            unexplained(["fill_gpu_msx", "fill_gpu", ""]),
            ["fill_gpu_msx", "fill_gpu", ""]
        );
    }

    #[test]
    fn no_term_stands_twice() {
        let mut terms: Vec<&str> = entries().iter().map(|(term, _)| *term).collect();
        let all = terms.len();
        terms.sort_unstable();
        terms.dedup();
        assert_eq!(terms.len(), all);
    }
}
