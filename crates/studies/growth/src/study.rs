// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: families of shapes × sizes.

use crate::measure::{GrowthProgram, measure_here};
use crate::metrics::{METRICS, OUTLINE_VERTICES, SHAPE, TIME, VERTICES};
use crate::{STUDY, chapter::CHAPTER};
use tempfile::NamedTempFile;
use terrafill_core::ShapeFamily;
use terrafill_results::{ConditionKey, Verdict};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Planned, Request, Study, StudyError, Trial,
    judged, trials,
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
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
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
        let shapes = sizes.iter().flat_map(|&size| {
            ShapeFamily::ALL.map(|family| Shape {
                family,
                size,
                program: program.clone(),
            })
        });
        let samples = request.samples.unwrap_or(SAMPLES);
        let group = CaseGroup {
            // Every build is a process of its own, which nothing before it warms.
            warm_up: Some(0),
            ..trials(STUDY, STUDY.to_owned(), samples, shapes.collect())
        };
        Ok(Planned {
            groups: vec![Box::new(group)],
            ..Planned::default()
        })
    }
}

/// A shape of about so many vertices, and the program that builds it in a fresh process.
struct Shape {
    family: ShapeFamily,
    size: u32,
    program: Option<GrowthProgram>,
}

impl Shape {
    /// Its outline, which every build reads.
    fn file(&self) -> Result<NamedTempFile, Failure> {
        let written = NamedTempFile::new().and_then(|file| {
            std::fs::write(&file, self.family.geojson(self.size))?;
            Ok(file)
        });
        written.map_err(|error| {
            Failure::Ends(StudyError::Broken {
                place: std::env::temp_dir().display().to_string(),
                message: error.to_string(),
            })
        })
    }

    fn build(&self, file: &NamedTempFile) -> Result<(u64, f64), String> {
        match &self.program {
            Some(program) => program.measure(file.path()),
            None => measure_here(file.path()),
        }
    }
}

impl Trial for Shape {
    type Opened = NamedTempFile;

    fn conditions(&self) -> Vec<(ConditionKey, String)> {
        let shape = self.family.name().to_owned();
        vec![(SHAPE, shape), (OUTLINE_VERTICES, self.size.to_string())]
    }

    fn verify(&self, _: Context<'_>) -> Result<(NamedTempFile, Verdict), Failure> {
        let file = self.file()?;
        let (vertices, _) = self.build(&file)?;
        let figures = vec![(VERTICES.name, vertices as f64)];
        Ok((file, judged(String::new(), figures, Vec::new())))
    }

    fn recheck(&self, _: Context<'_>) -> Result<(NamedTempFile, Verdict), Failure> {
        // Every build is checked when it is measured.
        Ok((self.file()?, judged(String::new(), Vec::new(), Vec::new())))
    }

    fn time(&self, file: &mut NamedTempFile) -> Result<Figures, Failure> {
        Ok(vec![(TIME.name, self.build(file)?.1)])
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
