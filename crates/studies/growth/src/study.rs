// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: families of shapes × sizes.

use crate::keys::{OUTLINE_VERTICES, SHAPE};
use crate::measure::{GrowthProgram, measure_here};
use crate::metrics::METRICS;
use crate::{STUDY, chapter::GrowthChapter};
use tempfile::NamedTempFile;
use terrafill_results::{CaseId, Chapter, ConditionKey, Metric, PlannedCase, Status, Verdict};
use terrafill_scene::ShapeFamily;
use terrafill_study::{Context, Depth, Group, Planned, Request, Session, Study, StudyError};

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
    fn name(&self) -> &'static str {
        STUDY
    }

    fn question(&self) -> &'static str {
        "How does the cost of a mesh grow with its vertices?"
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn conditions(&self) -> Vec<ConditionKey> {
        crate::keys::CONDITIONS.to_vec()
    }

    fn least_depth(&self) -> Depth {
        Depth::Full
    }

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
            groups: vec![Box::new(Shapes::new(sizes, samples, program))],
            skipped: Vec::new(),
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        &GrowthChapter
    }
}

/// Every shape and size.
struct Shapes {
    shapes: Vec<(ShapeFamily, u32)>,
    cases: Vec<PlannedCase>,
    program: Option<GrowthProgram>,
}

impl Shapes {
    fn new(sizes: &[u32], samples: u32, program: Option<GrowthProgram>) -> Self {
        let families = |size| ShapeFamily::ALL.map(|family| (family, size));
        let shapes: Vec<(ShapeFamily, u32)> = sizes.iter().copied().flat_map(families).collect();
        let case = |&(family, size): &(ShapeFamily, u32)| PlannedCase {
            id: CaseId::new(
                STUDY,
                format!("{}/{size}", family.name()),
                [
                    (SHAPE, family.name().to_owned()),
                    (OUTLINE_VERTICES, size.to_string()),
                ],
            ),
            samples,
            may_be_wrong: false,
        };
        Self {
            cases: shapes.iter().map(case).collect(),
            shapes,
            program,
        }
    }
}

impl Group for Shapes {
    fn name(&self) -> String {
        STUDY.to_owned()
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn warm_up(&self) -> Option<u32> {
        // Every build is a process of its own, which nothing before it warms.
        Some(0)
    }

    fn open<'a>(&'a self, _context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        let file = |&(family, size): &(ShapeFamily, u32)| {
            let file = NamedTempFile::new()?;
            std::fs::write(&file, family.geojson(size))?;
            Ok(file)
        };
        let files = self.shapes.iter().map(file).collect();
        let files: Result<Vec<NamedTempFile>, std::io::Error> = files;
        let files = files.map_err(|error| StudyError::Broken {
            place: std::env::temp_dir().display().to_string(),
            message: error.to_string(),
        })?;
        Ok(Box::new(ShapesSession {
            files,
            program: self.program.as_ref(),
        }))
    }
}

struct ShapesSession<'a> {
    files: Vec<NamedTempFile>,
    program: Option<&'a GrowthProgram>,
}

impl ShapesSession<'_> {
    fn build(&self, case: usize) -> Result<(u64, f64), String> {
        let file = self.files[case].path();
        match self.program {
            Some(program) => program.measure(file),
            None => measure_here(file),
        }
    }
}

impl Session for ShapesSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        Ok(match self.build(case) {
            Ok((vertices, _)) => Verdict {
                status: Status::Ok,
                figures: vec![("vertices_of_outline", vertices as f64)],
                ..Verdict::default()
            },
            Err(message) => Verdict::failed(message),
        })
    }

    fn recheck(
        &mut self,
        _case: usize,
        _status: Status,
        _notes: &std::collections::BTreeMap<String, String>,
    ) -> Result<Verdict, StudyError> {
        // Every build is checked when it is measured.
        Ok(Verdict {
            status: Status::Ok,
            ..Verdict::default()
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
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
