// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a case is measured for, how its technique is set, and what contradicts its outcome. The plan writes it;
//! the chapters of fills and of extreme scenes read it.

use crate::keys::*;
use terrafill_results::{Case, ConditionKey, REPEATS};

/// Conditions that say what a case is for, or name the switches that it has anyway.
pub(crate) const BOOKKEEPING: [ConditionKey; 7] =
    [ASIDE, NEEDS_RUNG, NEEDS_STEP, ROLE, RUNG, STEP, VARIANT];

/// Conditions besides those that say which case it is and not how its technique is set.
const NO_SWITCHES: [ConditionKey; 6] = [APPROXIMATE, SCENE, VIEW, TECHNIQUE, LAYOUT, REPEATS];

/// Purposes that have a section of their own.
const UNLISTED: [Purpose; 5] = [
    Purpose::Ablation,
    Purpose::Matrix,
    Purpose::Needs,
    Purpose::Subdivision,
    Purpose::Texture,
];

/// What a case is measured for; it may be several things at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// A full-screen pass that techniques are held against.
    Baseline,
    /// A technique as it should be used.
    Main,
    /// The same where that is every step of its ablation.
    FullPlan,
    /// A layout without these steps, or one switch beside it: what the full plan is compared with.
    Layout,
    /// A point of the sweep through the boundary tolerance: it may be wrong, since its error is what
    /// the sweep is about.
    Sweep,
    /// A point of the sweep through the cap step: right, for its walls and its time.
    Subdivision,
    /// A step of an ablation.
    Ablation,
    /// A cell of the matrix.
    Matrix,
    /// A textured fill.
    Texture,
    /// Bytes of a layout, by formula and as allocated.
    Memory,
    /// What a user would pick instead: its error is part of the answer.
    Rival,
    /// What a view needs, or a step on the way there from everything.
    Needs,
    /// A view of a suite.
    Suite,
}

impl Purpose {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Baseline => "baseline",
            Self::Main => "main",
            Self::FullPlan => "full-plan",
            Self::Layout => "layout",
            Self::Sweep => "sweep",
            Self::Subdivision => "subdivision",
            Self::Ablation => "ladder",
            Self::Matrix => "matrix",
            Self::Texture => "texture",
            Self::Memory => "memory",
            Self::Rival => "rival",
            Self::Needs => "needs",
            Self::Suite => "suite",
        }
    }

    /// Whether a case is measured for this.
    pub(crate) fn is_of(self, case: &Case) -> bool {
        case.condition(ROLE)
            .split('+')
            .any(|own| own == self.name())
    }
}

/// Whether a case stands in every view's comparison: as it should be used, or a layout without its plan.
pub(crate) fn is_compared(case: &Case) -> bool {
    Purpose::Main.is_of(case) || Purpose::Layout.is_of(case)
}

/// Whether a case is there for full plans to be compared with: a variant without their steps.
pub(crate) fn is_control(case: &Case) -> bool {
    Purpose::Layout.is_of(case) && !Purpose::Main.is_of(case) && !Purpose::FullPlan.is_of(case)
}

/// Whether a case stands on the curve of a sweep alone.
pub(crate) fn is_point(case: &Case) -> bool {
    Purpose::Sweep.is_of(case) && !is_compared(case)
}

/// Whether a case has a place in its scene's tables: all that is for more than a section of its own.
pub(crate) fn is_listed(case: &Case) -> bool {
    let mut roles = case.condition(ROLE).split('+');
    roles.any(|role| UNLISTED.iter().all(|own| own.name() != role))
}

/// Whether a case's picture differs from the reference by the nature of its technique.
pub(crate) fn is_approximate(case: &Case) -> bool {
    case.condition(APPROXIMATE) == "yes"
}

/// Switches of technique and plan, each with its value, by name.
pub(crate) fn switches(case: &Case) -> Vec<(&str, &str)> {
    let conditions = case.id().conditions.iter();
    let conditions = conditions.map(|(key, value)| (key.as_str(), value.as_str()));
    let is_switch = |(key, value): &(&str, &str)| {
        let mut others = NO_SWITCHES.iter().chain(&BOOKKEEPING);
        others.all(|own| own.name() != *key) && !value.is_empty()
    };
    conditions.filter(is_switch).collect()
}

/// What contradicts that a case is right.
pub(crate) fn never_right(case: &Case) -> Option<String> {
    let name = case.id();
    match case.value(MISMATCHED_PX_OUTSIDE_BAND) {
        None => Some(format!("{name}: ok, but never compared with the reference")),
        Some(px) if px > 0.0 => Some(format!(
            "{name}: ok, though {px} pixels outside the boundary band are wrong"
        )),
        Some(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn a_case_of_several_purposes_is_of_each_and_listed_by_any() {
        let mut made = MadeUpRun::default();
        for role in [
            "sweep+main",
            "sweep",
            "ladder",
            "ladder+full-plan",
            "ladders",
        ] {
            made.case(case_id("filling", role, &[("role", role)]));
        }
        let run = made.loaded();
        let of = |is_one: &dyn Fn(&Case) -> bool| -> Vec<bool> {
            run.cases.iter().map(is_one).collect()
        };
        assert_eq!(of(&is_point), [false, true, false, false, false]);
        assert_eq!(of(&is_listed), [true, true, false, true, true]);
        // Negative control: another word that begins alike is another purpose.
        let is_step = |case: &Case| Purpose::Ablation.is_of(case);
        assert_eq!(of(&is_step), [false, false, true, true, false]);
    }
}
