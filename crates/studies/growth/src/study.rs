// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: families of shapes × sizes.

use crate::keys::{OUTLINE_VERTICES, SHAPE};
use crate::measure::{GrowthProgram, measure_here};
use crate::metrics::METRICS;
use crate::{STUDY, chapter::CHAPTER};
use std::collections::BTreeMap;
use tempfile::NamedTempFile;
use terrafill_results::{Status, Verdict};
use terrafill_scene::ShapeFamily;
use terrafill_study::{
    CaseGroup, CaseSession, Depth, Failure, Figures, Measures, Planned, Request, Study, StudyError,
    judged, planned_case,
};

/// Vertices of the shapes; a quick run measures the first three sizes.
const SIZES: [u32; 5] = [1_000, 10_000, 100_000, 300_000, 1_000_000];
const QUICK_SIZES: usize = 3;

/// Builds of each shape and size in a process, unless the request says otherwise.
const SAMPLES: u32 = 2;

/// How the cost of a mesh grows with its vertices.
#[derive(Debug, Clone, Copy)]
pub struct GrowthStudy {
    /// Verb by which this program measures one build in a fresh process; `None`: in this process.
    pub verb: Option<&'static str>,
}

impl Study for GrowthStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        question: "How does the cost of a mesh grow with its vertices?",
        metrics: METRICS,
        conditions: crate::keys::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn needs_device(&self) -> bool {
        false
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let program = match self.verb {
            None => None,
            Some(verb) => Some(GrowthProgram {
                path: std::env::current_exe()
                    .map_err(|error| StudyError::BadInput(format!("this program: {error}")))?,
                verb,
            }),
        };
        let is_quick = request.depth == Depth::Quick;
        let sizes = &SIZES[..if is_quick { QUICK_SIZES } else { SIZES.len() }];
        let samples = request.samples.unwrap_or(SAMPLES);
        Ok(Planned {
            groups: vec![Box::new(shapes(sizes, samples, program))],
            skipped: Vec::new(),
        })
    }
}

/// What sessions need: every shape and size, and the program that builds in a fresh process.
type Shapes = (Vec<(ShapeFamily, u32)>, Option<GrowthProgram>);

fn shapes(sizes: &[u32], samples: u32, program: Option<GrowthProgram>) -> CaseGroup<Shapes> {
    let families = |size| ShapeFamily::ALL.map(|family| (family, size));
    let shapes: Vec<(ShapeFamily, u32)> = sizes.iter().copied().flat_map(families).collect();
    let case = |&(family, size): &(ShapeFamily, u32)| {
        let conditions = [
            (SHAPE, family.name().to_owned()),
            (OUTLINE_VERTICES, size.to_string()),
        ];
        planned_case(STUDY, samples, conditions, None)
    };
    CaseGroup {
        name: STUDY.to_owned(),
        cases: shapes.iter().map(case).collect(),
        // Every build is a process of its own, which nothing before it warms.
        warm_up: Some(0),
        work: (shapes, program),
        open: |group, _context| {
            let (shapes, program) = &group.work;
            let file = |&(family, size): &(ShapeFamily, u32)| {
                let file = NamedTempFile::new()?;
                std::fs::write(&file, family.geojson(size))?;
                Ok(file)
            };
            let files: Result<Vec<NamedTempFile>, std::io::Error> =
                shapes.iter().map(file).collect();
            let files = files.map_err(|error| StudyError::Broken {
                place: std::env::temp_dir().display().to_string(),
                message: error.to_string(),
            })?;
            Ok(Box::new(CaseSession(Builds {
                files,
                program: program.as_ref(),
            })))
        },
    }
}

struct Builds<'a> {
    files: Vec<NamedTempFile>,
    program: Option<&'a GrowthProgram>,
}

impl Builds<'_> {
    fn build(&self, case: usize) -> Result<(u64, f64), String> {
        let file = self.files[case].path();
        match self.program {
            Some(program) => program.measure(file),
            None => measure_here(file),
        }
    }
}

impl Measures for Builds<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let (vertices, _) = self.build(case)?;
        let figures = vec![("vertices_of_outline", vertices as f64)];
        Ok(judged(String::new(), figures, Vec::new()))
    }

    fn recheck(
        &mut self,
        _case: usize,
        _status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        // Every build is checked when it is measured.
        Ok(judged(String::new(), Vec::new(), Vec::new()))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(vec![("mesh_cpu_ms", self.build(case)?.1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quick_plan_stops_at_a_hundred_thousand_vertices() {
        let study = GrowthStudy { verb: None };
        let largest = |depth| {
            let request = Request {
                depth,
                ..Request::default()
            };
            let planned = study.plan(&request).expect("planned");
            let sizes = planned.groups[0].cases().iter();
            let sizes = sizes.map(|case| case.id.condition(OUTLINE_VERTICES).parse::<u32>());
            sizes.map(|size| size.expect("a number")).max()
        };
        assert_eq!(largest(Depth::Quick), Some(100_000));
        assert_eq!(largest(Depth::Full), Some(1_000_000));
    }
}
