// SPDX-License-Identifier: MIT OR Apache-2.0
//! The suite as a study: a group of all formulas that are timed together, and one for each condition.

use crate::STUDY;
use crate::conditions::{CONDITION, OF_PART, PART, ROUTE};
use crate::kernel::{Kernels, TimedFormula};
use crate::row::{METRICS, PrecisionRow};
use crate::suite::{Condition, Suite};
use crate::timing::LoopTime;
use std::cell::RefCell;
use std::rc::Rc;
use terrafill_gpu::shared_gpu;
use terrafill_results::{CaseId, Chapter, ConditionKey, Metric, PlannedCase, Status, Verdict};
use terrafill_study::{Context, Depth, Group, Planned, Request, Session, Study, StudyError};

/// Timed passes of each formula in a process, unless the request says otherwise.
const SAMPLES: u32 = 5;

/// Errors and costs of the formulas from a fragment to its texture coordinate.
#[derive(Debug, Clone, Copy)]
pub struct PrecisionStudy;

impl Study for PrecisionStudy {
    fn name(&self) -> &'static str {
        STUDY
    }

    fn question(&self) -> &'static str {
        "Which formula finds a texture coordinate with which error, at which cost?"
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn conditions(&self) -> Vec<ConditionKey> {
        crate::conditions::CONDITIONS.to_vec()
    }

    fn least_depth(&self) -> Depth {
        Depth::Full
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let suite = Rc::new(Suite::new(request.depth == Depth::Quick));
        let samples = request.samples.unwrap_or(SAMPLES);
        let mut groups: Vec<Box<dyn Group>> = vec![Box::new(Timing::new(&suite, samples))];
        for condition in suite.conditions() {
            groups.push(Box::new(Errors::new(&suite, condition)));
        }
        Ok(Planned {
            groups,
            skipped: Vec::new(),
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        &crate::chapter::PrecisionChapter
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
struct Timing {
    suite: Rc<Suite>,
    formulas: Vec<TimedFormula>,
    cases: Vec<PlannedCase>,
}

impl Timing {
    fn new(suite: &Rc<Suite>, samples: u32) -> Self {
        let formulas = suite.timed();
        let case = |formula: &TimedFormula| {
            let (part, route) = (formula.part().name(), formula.name());
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    format!("time/{part}/{route}"),
                    [
                        (PART, "time".to_owned()),
                        (OF_PART, part.to_owned()),
                        (ROUTE, route),
                    ],
                ),
                samples,
                may_be_wrong: false,
            }
        };
        Self {
            suite: Rc::clone(suite),
            cases: formulas.iter().map(case).collect(),
            formulas,
        }
    }
}

impl Group for Timing {
    fn name(&self) -> String {
        format!("{STUDY}/times")
    }

    fn warm_up(&self) -> Option<u32> {
        Some(1)
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        let kernels = kernels(&self.suite, context)?;
        kernels.borrow_mut().prepare_timing()?;
        Ok(Box::new(TimingSession {
            formulas: &self.formulas,
            kernels,
            empty: None,
        }))
    }
}

struct TimingSession<'a> {
    formulas: &'a [TimedFormula],
    kernels: SharedKernels,
    /// What the loop alone takes in this block.
    empty: Option<LoopTime>,
}

impl Session for TimingSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        Ok(match self.kernels.borrow().timed(&self.formulas[case]) {
            Ok(_) => Verdict {
                status: Status::Ok,
                ..Verdict::default()
            },
            Err(why) => Verdict::skipped(format!("not on this device: {why}")),
        })
    }

    fn begin_block(&mut self) -> Result<(), StudyError> {
        self.empty = Some(self.kernels.borrow().time_empty()?);
        Ok(())
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let time = self.kernels.borrow().time(&self.formulas[case])?;
        let empty = self.empty.as_ref().ok_or("no block was begun")?;
        let per_evaluation =
            |ms: f64, empty_ms: f64| (ms - empty_ms) * 1e6 / time.evaluations as f64;
        let gpu = time.gpu_ms.zip(empty.gpu_ms);
        let cpu_ns = per_evaluation(time.cpu_ms, empty.cpu_ms);
        let gpu_ns = gpu.map(|(ms, empty_ms)| ("gpu_ns", per_evaluation(ms, empty_ms)));
        Ok([("cpu_ns", cpu_ns)].into_iter().chain(gpu_ns).collect())
    }
}

/// Formulas under one condition.
struct Errors {
    suite: Rc<Suite>,
    condition: Condition,
    cases: Vec<PlannedCase>,
}

impl Errors {
    fn new(suite: &Rc<Suite>, condition: Condition) -> Self {
        let identities = suite.identities(&condition);
        Self {
            cases: identities
                .iter()
                .map(|row| PlannedCase {
                    id: row.id(),
                    samples: 0,
                    // Its error is the question: a formula without an answer is a result.
                    may_be_wrong: true,
                })
                .collect(),
            suite: Rc::clone(suite),
            condition,
        }
    }
}

impl Group for Errors {
    fn name(&self) -> String {
        let part = self
            .cases
            .first()
            .map_or("", |case| case.id.condition(PART));
        let condition = self
            .cases
            .first()
            .map_or("", |case| case.id.condition(CONDITION));
        format!("{STUDY}/{part}/{condition}")
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        let kernels = kernels(&self.suite, context)?;
        let rows = self.suite.rows(&self.condition, &kernels.borrow())?;
        Ok(Box::new(ErrorsSession {
            cases: &self.cases,
            rows,
        }))
    }
}

struct ErrorsSession<'a> {
    cases: &'a [PlannedCase],
    rows: Vec<PrecisionRow>,
}

impl Session for ErrorsSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let id = &self.cases[case].id;
        let row = self.rows.iter().find(|row| row.id() == *id);
        Ok(row.map_or_else(
            || Verdict::failed("no row was measured under this condition"),
            PrecisionRow::verdict,
        ))
    }

    fn sample(&mut self, _case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        Err("errors are measured once and not timed".to_owned())
    }
}
