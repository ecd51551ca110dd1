// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a radius of the spiral follows counted pixels, frame by frame.
//!
//! The fan's radius is held at a wanted number of pixels. The outer one is tried: what lies outside the screen has no
//! pixels, so it shrinks until some are bare, and grows again.

use crate::made::spiral::{number_of, per_octave, stored_radius};
use terrafill_results::named;

/// Vertices of a turn: a vertex more is 0.27 % of the radius.
pub(super) const PER_TURN: u32 = 48;
/// Pixels that the fan is to have: a disc of 20 pixels.
pub(super) const WANTED_PX: u64 = 1257;
/// First radii over those in closed form: the fan begins with half its pixels and no whole number of steps off, the
/// outer radius with corners covered.
const FAN_START: f64 = 0.71;
const OUTER_START: f64 = 1.2;

/// Pixels of the fan, and of all that is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Counted {
    pub(super) fan: u64,
    pub(super) all: u64,
}

named! {
    /// What decides on a radius.
    pub(super) enum Rule {
        /// The view alone; both radii.
        Closed = "closed form",
        /// The fan's grows by a constant where it has too few pixels, and shrinks where it has too many: the paper's.
        Steps = "constant steps",
        /// The logarithm of the fan's changes by half of that of the wanted pixels over those counted, times a gain.
        Logarithmic = "logarithmic",
        /// The outer one shrinks by a share where no pixel is bare, and grows where one is: the paper's.
        Trying = "trying",
    }
}

impl Rule {
    pub(super) fn of(self) -> &'static str {
        match self {
            Self::Closed => "both radii",
            Self::Steps | Self::Logarithmic => "fan",
            Self::Trying => "outer radius",
        }
    }
}

/// The gain below which the logarithmic rule settles where vertices are dense, and counts of frame k are used for frame
/// k + `delay`; `docs/globe-arithmetic.md` has it, counted from the frame after.
pub(super) fn stable_gain(delay: usize) -> f64 {
    2.0 * (std::f64::consts::PI / (4.0 * delay as f64 - 2.0)).sin()
}

/// A range of stored vertices: the first of the fan's rim, and the first of the outer one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Drawn {
    pub(super) first: u32,
    pub(super) last: u32,
}

/// Radii in closed form, radians.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) fan: f64,
    pub(super) outer: f64,
}

impl Limits {
    pub(super) fn drawn(&self) -> Drawn {
        // The nearest vertex of the fan, and the next one beyond the corners.
        let nearer = (0.5 / per_octave(PER_TURN)).exp2();
        Drawn {
            first: number_of(nearer * self.fan, PER_TURN),
            last: number_of(self.outer, PER_TURN) + 1,
        }
    }
}

/// A rule with its state.
#[derive(Debug, Clone)]
pub(super) struct Controller {
    rule: Rule,
    /// Share of the wanted radius, share of the radius, or gain.
    step: f64,
    /// A radius in closed form of the first frame, radians.
    first: f64,
    /// Steps made, or a vertex.
    at: i32,
}

impl Controller {
    /// - `step`: of the radius that the first view wants, of the radius, or a gain
    pub(super) fn new(rule: Rule, step: f64, limits: &Limits) -> Self {
        let (first, at) = match rule {
            Rule::Closed => (0.0, 0),
            Rule::Steps => (limits.fan, 0),
            Rule::Logarithmic => (limits.fan, vertex(FAN_START * limits.fan)),
            Rule::Trying => (limits.outer, 0),
        };
        Self {
            rule,
            step,
            first,
            at,
        }
    }

    /// What a frame draws.
    pub(super) fn drawn(&self, limits: &Limits) -> Drawn {
        let Drawn { first, last } = limits.drawn();
        let steps = f64::from(self.at);
        let held = match self.rule {
            Rule::Closed => 0,
            Rule::Steps => vertex(self.first * (FAN_START + self.step * steps).max(self.step)),
            Rule::Logarithmic => self.at,
            Rule::Trying => vertex(self.first * OUTER_START * (1.0 - self.step).powf(-steps)),
        };
        let held = u32::try_from(held).unwrap_or(0);
        match self.rule {
            Rule::Closed => Drawn { first, last },
            // A fan has its rim within the outer one.
            Rule::Steps | Rule::Logarithmic => Drawn {
                first: held.clamp(PER_TURN, last - PER_TURN),
                last,
            },
            Rule::Trying => Drawn {
                first,
                last: held.max(first + PER_TURN),
            },
        }
    }

    /// - `of`: all pixels of the picture
    pub(super) fn next(&mut self, counted: Counted, of: u64) {
        let fan = counted.fan;
        self.at += match self.rule {
            Rule::Closed => 0,
            Rule::Steps => i32::from(fan < WANTED_PX) - i32::from(fan > WANTED_PX),
            Rule::Logarithmic => {
                let over = WANTED_PX as f64 / fan.max(1) as f64;
                let octaves = 0.5 * self.step * over.log2();
                nearest(octaves * per_octave(PER_TURN))
            }
            Rule::Trying => 1 - 2 * i32::from(counted.all >= of),
        };
    }
}

/// The radius of a stored vertex over that of another one.
pub(super) fn radii(one: u32, other: u32) -> f64 {
    ((f64::from(one) - f64::from(other)) / per_octave(PER_TURN)).exp2()
}

/// The stored vertex nearest to a radius.
fn vertex(radius: f64) -> i32 {
    nearest(per_octave(PER_TURN) * (radius / stored_radius(0, PER_TURN)).log2())
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "some thousands of vertices at most"
)]
fn nearest(vertices: f64) -> i32 {
    vertices.round() as i32
}
