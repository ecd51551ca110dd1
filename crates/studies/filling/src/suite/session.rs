// SPDX-License-Identifier: MIT OR Apache-2.0
//! One view of a suite being verified: what came of it is held against what must.

use crate::cases::ViewGroup;
use crate::scenes::ReadyScene;
use crate::session::ViewSession;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Instant;
use terrafill_contract::ValidationLog;
use terrafill_results::{PlannedCase, RunError, Status, Verdict};
use terrafill_scene::Expectation;
use terrafill_study::{Context, Failure, Figures, Session, StudyError};

/// Why a scene has nothing to draw.
#[derive(Debug, Clone)]
pub(super) enum Closed {
    /// Its data is not here.
    Missing(String),
    /// Scene, regions or surface are refused with this message.
    Refused(String),
    /// Opening it panicked.
    Crashed(String),
}

/// File of a run's folder that holds the key of the case in hand: what a process leaves that crashes.
pub const IN_HAND: &str = "in-hand.txt";

/// Messages of the validation layer that are known to be false: how the id begins, what the text holds, why.
const FALSE_MESSAGES: &str = include_str!("../../../../../ci/false-validation-messages.csv");

/// Id of the message that there is no layer.
const NO_LAYER: &str = "validation-layer-missing";

/// What a refusal that is right is told by, in the case's notes.
pub(super) const REFUSED: &str = "refused";

/// What is drawn, or why nothing is; `None` for a scene that must be refused whole and was not.
pub(super) type State<'a> = Result<Option<Box<ViewSession<'a>>>, Closed>;

pub(super) struct SuiteSession<'a> {
    expect: &'a Expectation,
    planned: &'a [PlannedCase],
    in_hand: PathBuf,
    pub(super) state: State<'a>,
    /// Since opening began, until the first case has it.
    since: Instant,
    /// Why no frame can be timed.
    broken: Option<String>,
}

impl<'a> SuiteSession<'a> {
    /// Before the scene is opened: opening is part of the first case.
    pub(super) fn begin(
        expect: &'a Expectation,
        planned: &'a [PlannedCase],
        folder: &Path,
    ) -> Result<Self, StudyError> {
        let session = Self {
            expect,
            planned,
            in_hand: folder.join(IN_HAND),
            state: Ok(None),
            since: Instant::now(),
            broken: None,
        };
        session.take_in_hand(0)?;
        Ok(session)
    }

    /// Writes down which case is in hand, for whoever finds this process dead.
    fn take_in_hand(&self, case: usize) -> Result<(), StudyError> {
        let key = self.planned[case].id.key();
        std::fs::write(&self.in_hand, key).map_err(|source| {
            StudyError::Run(RunError::Io {
                path: self.in_hand.clone(),
                source,
            })
        })
    }

    fn drawn(
        &mut self,
        draw: impl FnOnce(&mut ViewSession<'a>) -> Result<Verdict, Failure>,
    ) -> Result<Verdict, Closed> {
        match &mut self.state {
            Err(closed) => Err(closed.clone()),
            Ok(None) => Ok(Verdict {
                status: Status::Ok,
                ..Verdict::default()
            }),
            Ok(Some(session)) => {
                unpanicked(|| draw(session).or_else(Failure::verdict)).map_err(Closed::Crashed)
            }
        }
    }
}

/// Opens a view of a scene that is ready.
pub(super) fn drawing<'a>(
    group: &'a ViewGroup,
    ready: &Rc<ReadyScene>,
    context: Context<'a>,
) -> Result<State<'a>, StudyError> {
    let opened = catch_unwind(AssertUnwindSafe(|| ViewSession::new(group, ready, context)));
    Ok(match opened {
        Ok(Ok(session)) => Ok(Some(Box::new(session))),
        // Without a device nothing of the suite can go on.
        Ok(Err(error @ StudyError::NoDevice(_))) => return Err(error),
        Ok(Err(error)) => Err(Closed::Refused(error.to_string())),
        Err(panic) => Err(Closed::Crashed(words_of(&*panic))),
    })
}

/// Holds what came of a case against what must.
pub(super) fn settle(expect: &Expectation, came: Result<Verdict, Closed>) -> Verdict {
    // A technique that cannot draw something says so as its case breaks off or is skipped.
    let came = match came {
        Ok(verdict)
            if matches!(expect, Expectation::Refused(_))
                && matches!(verdict.status, Status::Failed | Status::Skipped) =>
        {
            Err(Closed::Refused(verdict.reason))
        }
        other => other,
    };
    match (expect, came) {
        (_, Err(Closed::Missing(message))) => Verdict::skipped(message),
        (_, Err(Closed::Crashed(message))) => Verdict::failed(message),
        (Expectation::Fills, Ok(verdict)) => verdict,
        (Expectation::Fills, Err(Closed::Refused(message))) => {
            Verdict::failed(format!("refused, expected to be filled: {message}"))
        }
        (Expectation::Refused(words), Err(Closed::Refused(message))) if message.contains(words) => {
            Verdict {
                status: Status::Ok,
                notes: vec![(REFUSED, message)],
                ..Verdict::default()
            }
        }
        (Expectation::Refused(words), Err(Closed::Refused(message))) => Verdict::failed(format!(
            "refused with other words than {words:?}: {message}"
        )),
        (Expectation::Refused(words), Ok(verdict)) => Verdict {
            status: Status::Failed,
            reason: format!("accepted, expected to be refused with {words:?}"),
            ..verdict
        },
    }
}

impl Session for SuiteSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        self.take_in_hand(case)?;
        let before = Heard::so_far();
        let came = self.drawn(|session| session.verify(case));
        let mut verdict = settle(self.expect, came);
        if let Some(heard) = before.since() {
            verdict
                .figures
                .push(("validation_messages", heard.len() as f64));
            if let Some(first) = heard.first() {
                let words = format!("{} validation messages, the first: {first}", heard.len());
                verdict.reason = match verdict.reason.as_str() {
                    "" => words,
                    reason => format!("{reason}; {words}"),
                };
                verdict.status = Status::Failed;
            }
        }
        let seconds = self.since.elapsed().as_secs_f64();
        self.since = Instant::now();
        verdict.figures.push(("suite_case_s", seconds));
        Ok(verdict)
    }

    fn recheck(
        &mut self,
        case: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        self.take_in_hand(case)?;
        let came = self.drawn(|session| session.recheck(case, status, notes));
        Ok(settle(self.expect, came))
    }

    fn begin_block(&mut self) -> Result<(), StudyError> {
        if let Ok(Some(session)) = &mut self.state {
            self.broken = unpanicked(|| session.begin_block()).err();
        }
        Ok(())
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        self.take_in_hand(case)?;
        if let Some(message) = &self.broken {
            return Err(message.clone().into());
        }
        let Ok(Some(session)) = &mut self.state else {
            return Err(Failure::broken("there is nothing to time"));
        };
        Ok(unpanicked(|| session.time(case).map_err(Failure::reason))?)
    }
}

/// How many messages of the validation layer there were at a moment, through wgpu and through Vulkan itself.
struct Heard([usize; 2]);

impl Heard {
    fn logs() -> [&'static ValidationLog; 2] {
        [
            terrafill_gpu::validation_log(),
            terrafill_vulkan::validation_log(),
        ]
    }

    fn so_far() -> Self {
        Self(Self::logs().map(ValidationLog::count))
    }

    /// What was said since then, but for what is known to be false; `None` where nobody asked for it, or there is no
    /// layer.
    fn since(&self) -> Option<Vec<String>> {
        let logs = Self::logs();
        if !ValidationLog::is_requested() || logs.iter().any(|log| log.has(NO_LAYER)) {
            return None;
        }
        let new = logs.into_iter().zip(self.0);
        let new = new.flat_map(|(log, known)| log.after(known));
        let new = new.filter(|message| !is_known(&message.id, &message.text));
        Some(
            new.map(|message| format!("{}: {}", message.id, message.text))
                .collect(),
        )
    }
}

/// Whether a message is made on purpose or known to be false.
fn is_known(id: &str, text: &str) -> bool {
    let is_row = |row: &str| {
        let mut cells = row.split(',');
        let (start, part) = cells.next().zip(cells.next())?;
        Some(id.starts_with(start) && text.contains(part))
    };
    let mut rows = FALSE_MESSAGES.lines().skip(1).filter_map(is_row);
    id == terrafill_gpu::POSITIVE_CONTROL || rows.any(|is| is)
}

/// What the work gives, or what it says where it fails or panics.
fn unpanicked<T, E: ToString>(work: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => done.map_err(|error| error.to_string()),
        Err(panic) => Err(words_of(&*panic)),
    }
}

/// What a panic said.
pub(super) fn words_of(panic: &(dyn std::any::Any + Send)) -> String {
    let words = panic.downcast_ref::<String>().map(String::as_str);
    let words = words.or_else(|| panic.downcast_ref::<&str>().copied());
    format!("panicked: {}", words.unwrap_or("without words"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn right() -> Verdict {
        Verdict {
            status: Status::Ok,
            ..Verdict::default()
        }
    }

    #[test]
    fn what_came_is_held_against_what_must() {
        let fills = Expectation::Fills;
        let refused = Expectation::Refused("allowed 255".to_owned());
        let message = "volumes: found 256, allowed 255".to_owned();
        let status = |expect, came| settle(expect, came).status;
        assert_eq!(status(&fills, Ok(right())), Status::Ok);
        assert_eq!(
            status(&refused, Err(Closed::Refused(message.clone()))),
            Status::Ok
        );
        let by_technique = Verdict::failed(message.clone());
        assert_eq!(status(&refused, Ok(by_technique.clone())), Status::Ok);
        // Negative controls: turned round, each is a failure; so are other words and a crash.
        assert_eq!(status(&refused, Ok(right())), Status::Failed);
        assert_eq!(
            status(&fills, Err(Closed::Refused(message))),
            Status::Failed
        );
        assert_eq!(status(&fills, Ok(by_technique)), Status::Failed);
        let other = Err(Closed::Refused("no such file".to_owned()));
        assert_eq!(status(&refused, other), Status::Failed);
        for expect in [&fills, &refused] {
            let crashed = Err(Closed::Crashed("panicked: allowed 255".to_owned()));
            assert_eq!(status(expect, crashed), Status::Failed);
            let missing = Err(Closed::Missing("no data".to_owned()));
            assert_eq!(status(expect, missing), Status::Skipped);
        }
        // A wrong picture stays wrong.
        let wrong = Verdict {
            status: Status::Wrong,
            ..Verdict::default()
        };
        assert_eq!(status(&fills, Ok(wrong)), Status::Wrong);
    }
}
