// SPDX-License-Identifier: MIT OR Apache-2.0
//! The suite as a study: a group of all formulas that are timed together, and one for each condition.

use crate::STUDY;
use crate::kernel::{Kernels, LoopTime, TimedFormula};
use crate::metrics::{METRICS, OF_PART, PART, ROUTE};
use crate::row::PrecisionRow;
use crate::suite::{Condition, Suite};
use std::cell::RefCell;
use std::rc::Rc;
use terrafill_gpu::shared_gpu;
use terrafill_results::{PlannedCase, Verdict};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, Planned, Request, Session, Study,
    StudyError, judged, planned_case,
};

/// Timed passes of each formula in a process, unless the request says otherwise.
const SAMPLES: u32 = 5;

/// Errors and costs of the formulas from a fragment to its texture coordinate.
#[derive(Debug, Clone, Copy)]
pub struct PrecisionStudy;

impl Study for PrecisionStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: crate::chapter::PrecisionChapter,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let suite = Rc::new(Suite::new(request.depth == Depth::Quick));
        let samples = request.samples.unwrap_or(SAMPLES);
        let mut groups: Vec<Box<dyn Group>> = vec![Box::new(times(&suite, samples))];
        for condition in suite.conditions() {
            groups.push(Box::new(errors(&suite, condition)));
        }
        Ok(Planned {
            groups,
            ..Planned::default()
        })
    }
}

/// Every formula of the suite on the run's device, compiled once.
type SharedKernels = Rc<RefCell<Kernels>>;

fn kernels(suite: &Suite, context: Context<'_>) -> Result<SharedKernels, StudyError> {
    let gpu =
        shared_gpu(context.devices).map_err(|error| StudyError::NoDevice(error.to_string()))?;
    let compile = |_: Option<&str>| {
        let kernels = Kernels::new(&gpu, &suite.routes);
        Ok::<_, String>(Rc::new(RefCell::new(kernels)))
    };
    context.devices.get(compile).map_err(StudyError::NoDevice)
}

/// Formulas that are timed together.
fn times(suite: &Rc<Suite>, samples: u32) -> CaseGroup<(Rc<Suite>, Vec<TimedFormula>)> {
    let formulas = TimedFormula::all(&suite.routes);
    let case = |formula: &TimedFormula| {
        let conditions = [
            (PART, "time".to_owned()),
            (OF_PART, formula.part().name().to_owned()),
            (ROUTE, formula.name()),
        ];
        planned_case(STUDY, samples, conditions, None)
    };
    CaseGroup {
        name: format!("{STUDY}/times"),
        cases: formulas.iter().map(case).collect(),
        warm_up: Some(1),
        work: (Rc::clone(suite), formulas),
        open: |group, context| {
            let (suite, formulas) = &group.work;
            let kernels = kernels(suite, context)?;
            kernels.borrow_mut().prepare_timing()?;
            Ok(Box::new(TimingSession {
                formulas,
                kernels,
                empty: None,
            }))
        },
    }
}

struct TimingSession<'a> {
    formulas: &'a [TimedFormula],
    kernels: SharedKernels,
    /// What the loop alone takes in this block.
    empty: Option<LoopTime>,
}

impl Session for TimingSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        match self.kernels.borrow().timed(&self.formulas[case]) {
            Ok(_) => Ok(judged(String::new(), Vec::new(), Vec::new())),
            Err(why) => Err(Failure::Unable(format!("not on this device: {why}"))),
        }
    }

    fn begin_block(&mut self) -> Result<(), StudyError> {
        self.empty = Some(self.kernels.borrow().time_empty()?);
        Ok(())
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let time = self.kernels.borrow().time(&self.formulas[case])?;
        let empty = self.empty.as_ref();
        let empty = empty.ok_or_else(|| Failure::broken("no block was begun"))?;
        let per_evaluation =
            |ms: f64, empty_ms: f64| (ms - empty_ms) * 1e6 / time.evaluations as f64;
        let gpu = time.gpu_ms.zip(empty.gpu_ms);
        let cpu_ns = per_evaluation(time.cpu_ms, empty.cpu_ms);
        let gpu_ns = gpu.map(|(ms, empty_ms)| ("gpu_ns", per_evaluation(ms, empty_ms)));
        Ok(std::iter::once(("cpu_ns", cpu_ns)).chain(gpu_ns).collect())
    }
}

/// Formulas under one condition.
fn errors(suite: &Rc<Suite>, condition: Condition) -> CaseGroup<(Rc<Suite>, Condition)> {
    let case = |row: &PrecisionRow| PlannedCase {
        id: row.id(),
        samples: 0,
        // Its error is the question: a formula without an answer is a result.
        may_be_wrong: true,
    };
    let rows = suite.identities(&condition);
    let name = rows.first().map_or_else(String::new, |row| {
        format!("{}/{}", row.part.name(), row.condition)
    });
    CaseGroup {
        name: format!("{STUDY}/{name}"),
        cases: rows.iter().map(case).collect(),
        warm_up: None,
        work: (Rc::clone(suite), condition),
        open: |group, context| {
            let (suite, condition) = &group.work;
            let kernels = kernels(suite, context)?;
            let rows = suite.rows(condition, &kernels.borrow())?;
            let cases = &group.cases;
            Ok(Box::new(Errors { cases, rows }))
        },
    }
}

struct Errors<'a> {
    cases: &'a [PlannedCase],
    rows: Vec<PrecisionRow>,
}

impl Session for Errors<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let mut rows = self.rows.iter();
        let row = rows.find(|row| row.id() == self.cases[case].id);
        let verdict = row.map(PrecisionRow::verdict);
        verdict.ok_or_else(|| "no row was measured under this condition".to_owned().into())
    }

    fn time(&mut self, _case: usize) -> Result<Figures, Failure> {
        Err("errors are measured once and not timed".to_owned().into())
    }
}
