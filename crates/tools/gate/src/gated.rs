// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which times of a study are compared, by what they cover of a frame's work.
//!
//! The frame's own time alone would miss work that is moved before it, and a program that waits. So preparation,
//! planning and the frame by the wall clock are compared too. They are noisier, or measured less often, and have
//! floors of their own. Parts of a frame's work decide nothing; they say where a difference lies.

use crate::threshold::{
    FLOOR_PERCENT, PLANNING_FLOOR_MS, PREPARATION_FLOOR_MS, SETUP_FLOOR_PERCENT, WALL_FLOOR_MS,
    WALL_FLOOR_PERCENT, floor_ms,
};
use serde::{Deserialize, Serialize};
use terrafill_results::{Clock, Direction, Kind, Metric, Scope};

/// What a compared time is of.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Span {
    /// The frame, by the clock that its study is ranked by.
    #[default]
    Frame,
    /// The frame, by the wall clock: it sees what waits and does nothing.
    Wall,
    /// What is done once before the first frame, uploads included.
    Preparation,
    /// What the CPU works out for a new view.
    Planning,
    /// A part of the frame's work: compared with nothing by itself.
    Stage,
}

impl Span {
    /// In reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Frame => "frame",
            Self::Wall => "frame by the wall clock",
            Self::Preparation => "preparation",
            Self::Planning => "planning",
            Self::Stage => "stage",
        }
    }
}

/// A time of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GatedTime {
    /// Its metric.
    pub metric: &'static str,
    /// What it is of.
    pub span: Span,
}

impl GatedTime {
    /// The times of a study, told apart by the scopes that it declares. Where it is ranked by no time, none.
    ///
    /// - `metrics`: its declarations
    /// - `primary`: the one that it is ranked by
    #[must_use]
    pub fn of(metrics: &[Metric], primary: Option<&str>) -> Vec<Self> {
        let times = || metrics.iter().filter(|metric| metric.kind == Kind::Time);
        let Some(primary) = times().find(|metric| Some(metric.name) == primary) else {
            return Vec::new();
        };
        let span = |metric: &Metric| {
            let by_wall = metric.name.contains("_wall_");
            let whole = Scope::FRAME;
            match metric.scope {
                _ if metric.name == primary.name => Some(Span::Frame),
                scope if by_wall => scope.covers(primary.scope).then_some(Span::Wall),
                scope if scope == Scope::PLAN => Some(Span::Planning),
                scope if scope == Scope::PLAN.and(Scope::UPLOAD) => Some(Span::Preparation),
                scope if whole.covers(scope) && !scope.covers(Scope::DEVICE) => Some(Span::Stage),
                _ => None,
            }
        };
        // What describes a case, and is no part of its cost, is not compared.
        let costs = times().filter(|metric| metric.better == Direction::Less);
        costs
            .filter_map(|metric| {
                let span = span(metric)?;
                Some(Self {
                    metric: metric.name,
                    span,
                })
            })
            .collect()
    }
}

/// Smallest change that fails: both have to be reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// Percent.
    pub percent: f64,
    /// Milliseconds.
    pub ms: f64,
}

impl Floor {
    /// The relative floor as a difference of logarithms.
    pub(crate) fn log(&self) -> f64 {
        (0.01 * self.percent).ln_1p()
    }
}

/// Floors of all that is compared.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Floors {
    /// Of the frame.
    pub frame: Floor,
    /// Of the frame by the wall clock.
    pub wall: Floor,
    /// Of preparation.
    pub preparation: Floor,
    /// Of planning.
    pub planning: Floor,
}

impl Floors {
    /// The usual ones by this clock.
    #[must_use]
    pub fn new(clock: Clock) -> Self {
        let floor = |percent, ms| Floor { percent, ms };
        Self {
            frame: floor(FLOOR_PERCENT, floor_ms(clock)),
            wall: floor(WALL_FLOOR_PERCENT, WALL_FLOOR_MS),
            preparation: floor(SETUP_FLOOR_PERCENT, PREPARATION_FLOOR_MS),
            planning: floor(SETUP_FLOOR_PERCENT, PLANNING_FLOOR_MS),
        }
    }

    /// The floor of what this is of.
    #[must_use]
    pub fn of(&self, span: Span) -> Floor {
        match span {
            Span::Frame | Span::Stage => self.frame,
            Span::Wall => self.wall,
            Span::Preparation => self.preparation,
            Span::Planning => self.planning,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn time(name: &'static str, scope: Scope) -> Metric {
        Metric::less(name, "ms", Kind::Time, "Time.").covering(scope)
    }

    const METRICS: [Metric; 9] = [
        time("fill_cpu_ms", Scope::FRAME),
        time("fill_gpu_ms", Scope::DEVICE),
        time("fill_wall_ms", Scope::FRAME),
        Metric::neither("surface_gpu_ms", "ms", Kind::Time, "Not the fill's.")
            .covering(Scope::DRAW),
        time("stencil_gpu_ms", Scope::DISPATCH.and(Scope::DRAW)),
        time("plan_cpu_ms", Scope::PLAN),
        time("prepare_cpu_ms", Scope::PLAN.and(Scope::UPLOAD)),
        time("draw_wall_ms", Scope::DRAW),
        Metric::less("draws", "", Kind::Counter, "Draws."),
    ];

    #[test]
    fn scopes_tell_what_a_time_is_of() {
        let of = |primary| -> Vec<(&str, Span)> {
            let gated = GatedTime::of(&METRICS, primary);
            gated.iter().map(|time| (time.metric, time.span)).collect()
        };
        let others = [
            ("fill_wall_ms", Span::Wall),
            ("stencil_gpu_ms", Span::Stage),
            ("plan_cpu_ms", Span::Planning),
            ("prepare_cpu_ms", Span::Preparation),
        ];
        let with = |primary| [&[(primary, Span::Frame)], &others[..]].concat();
        assert_eq!(of(Some("fill_cpu_ms")), with("fill_cpu_ms"));
        assert_eq!(of(Some("fill_gpu_ms")), with("fill_gpu_ms"));
        // A study that is ranked by no time is not timed, nor is one by a counter.
        assert_eq!(of(None), []);
        assert_eq!(of(Some("draws")), []);
    }
}
