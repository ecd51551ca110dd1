// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a study promises the runner.

use crate::{Failure, StudyError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use terrafill_contract::Devices;
use terrafill_results::{
    Chapter, ConditionKey, Metric, PlannedCase, RunInput, Skipped, Status, Verdict,
};

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Depth {
    /// Enough to see that it works, in minutes.
    Quick,
    /// What answers each study's main question.
    #[default]
    Main,
    /// Everything there is.
    Full,
}

/// What a run is to measure. Options that only one study knows are in `settings`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Request {
    /// Names of shipped scenes or paths of scene files; empty for all shipped ones.
    pub scenes: Vec<String>,
    /// Techniques to run; empty for all.
    pub techniques: Vec<String>,
    /// How much is measured.
    pub depth: Depth,
    /// Timed samples per case and process; `None`: each study's own number.
    pub samples: Option<u32>,
    /// Width and height of pictures, pixels.
    pub size: [u32; 2],
    /// Whether whoever measures named that size, see [`Request::size_or`].
    pub names_size: bool,
    /// Where real data lies.
    pub data_dir: Option<PathBuf>,
    /// Values of `--set`-like options of single studies, `ablation` → `planet-134`.
    pub settings: BTreeMap<String, Vec<String>>,
}

impl Request {
    /// Size of pictures whose reference takes long: a quick run that names no size has smaller ones, and
    /// their cases have that size as a condition ([`size_name`]).
    #[must_use]
    pub fn size_or(&self, quick: [u32; 2]) -> [u32; 2] {
        match self.depth {
            Depth::Quick if !self.names_size => quick,
            _ => self.size,
        }
    }

    /// Whether a technique is among those to run.
    #[must_use]
    pub fn wants(&self, technique: &str) -> bool {
        self.techniques.is_empty() || self.techniques.iter().any(|name| name == technique)
    }
}

/// A size as conditions have it: `256`, or `200x150` where its sides differ.
#[must_use]
pub fn size_name([width, height]: [u32; 2]) -> String {
    if width == height {
        width.to_string()
    } else {
        format!("{width}x{height}")
    }
}

/// A study's cases.
#[derive(Default)]
pub struct Planned {
    /// Cases in groups, each measured together.
    pub groups: Vec<Box<dyn Group>>,
    /// What was left out.
    pub skipped: Vec<Skipped>,
    /// Files that planning read, and what is remarkable about them ([`crate::files_read`]).
    pub inputs: Vec<RunInput>,
}

/// What a session may use.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// Devices of the run.
    pub devices: &'a Rc<Devices>,
    /// The run's folder; pictures go to `images/` in it.
    pub folder: &'a Path,
}

/// One question with its cases, its figures, its way of checking and its chapter.
pub trait Study: Sync {
    /// In rows and on the command line.
    fn name(&self) -> &'static str;

    /// Everything that it measures.
    fn metrics(&self) -> &'static [Metric];

    /// Every condition that a case of it may have; the runner refuses a plan with others.
    fn conditions(&self) -> Vec<ConditionKey>;

    /// From which depth on it is part of a run that names no study.
    fn least_depth(&self) -> Depth {
        Depth::Quick
    }

    /// Whether nothing of it can be measured without a device.
    fn needs_device(&self) -> bool {
        true
    }

    /// Its cases.
    ///
    /// # Errors
    /// [`StudyError::BadInput`].
    fn plan(&self, request: &Request) -> Result<Planned, StudyError>;

    /// Its part of the report.
    fn chapter(&self) -> &dyn Chapter;
}

/// What a [`Study`] says of itself: its name, what it measures, its conditions, from which depth on it is
/// part of a run that names none, and its chapter.
#[macro_export]
macro_rules! study_facts {
    (
        name: $name:expr,
        metrics: $metrics:expr,
        conditions: $conditions:expr,
        least_depth: $depth:ident,
        chapter: $chapter:expr $(,)?
    ) => {
        fn name(&self) -> &'static str {
            $name
        }

        fn metrics(&self) -> &'static [::terrafill_results::Metric] {
            &$metrics
        }

        fn conditions(&self) -> Vec<::terrafill_results::ConditionKey> {
            $conditions.to_vec()
        }

        fn least_depth(&self) -> $crate::Depth {
            $crate::Depth::$depth
        }

        fn chapter(&self) -> &dyn ::terrafill_results::Chapter {
            &$chapter
        }
    };
}

/// Cases that share a device and a picture: measured together, interleaved.
pub trait Group {
    /// `planet-134/globe`.
    fn name(&self) -> String;

    /// Its cases.
    fn cases(&self) -> &[PlannedCase];

    /// Blocks to measure and drop at the start, where they are not the run's.
    fn warm_up(&self) -> Option<u32> {
        None
    }

    /// Gets ready to verify and measure them.
    ///
    /// # Errors
    /// [`StudyError`] when no case of the group can be measured.
    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError>;
}

/// Names of metrics, and values.
pub type Figures = Vec<(&'static str, f64)>;

/// A group being measured. Cases are known by their place in [`Group::cases`].
pub trait Session {
    /// Prepares a case and compares its result with the reference. Called once, before anything is timed.
    ///
    /// # Errors
    /// [`Failure`], which becomes the case's verdict.
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure>;

    /// Prepares a case that an earlier process has verified, and makes sure that it still does the same work.
    /// Verifies it once more by default.
    ///
    /// - `status`, `notes`: of the earlier verdict
    ///
    /// # Errors
    /// As [`Session::verify`].
    fn recheck(
        &mut self,
        case: usize,
        _status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        self.verify(case)
    }

    /// Called before each block, such as to draw what is under the fill.
    ///
    /// # Errors
    /// [`StudyError::Broken`].
    fn begin_block(&mut self) -> Result<(), StudyError> {
        Ok(())
    }

    /// Called before each sample that counts: what this draws is not measured.
    ///
    /// # Errors
    /// As [`Session::time`].
    fn before_sample(&mut self, _case: usize) -> Result<(), Failure> {
        Ok(())
    }

    /// A timed frame of a verified case: metric names and values.
    ///
    /// # Errors
    /// [`Failure`], with which the case fails.
    fn time(&mut self, case: usize) -> Result<Figures, Failure>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_named_size_is_kept_and_only_a_quick_run_without_one_draws_smaller() {
        let request = |depth, names_size| Request {
            size: [1024, 512],
            depth,
            names_size,
            ..Request::default()
        };
        for depth in [Depth::Quick, Depth::Main, Depth::Full] {
            assert_eq!(request(depth, true).size_or([64; 2]), [1024, 512]);
        }
        assert_eq!(request(Depth::Main, false).size_or([64; 2]), [1024, 512]);
        // Negative control: the one that may.
        assert_eq!(request(Depth::Quick, false).size_or([64; 2]), [64; 2]);
    }

    #[test]
    fn sizes_have_one_number_where_their_sides_are_equal() {
        assert_eq!(size_name([256; 2]), "256");
        assert_eq!(size_name([200, 150]), "200x150");
    }
}
