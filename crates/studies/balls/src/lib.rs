// SPDX-License-Identifier: MIT OR Apache-2.0
//! Study `balls`: balls that fall on flat ground and bounce, their error against time step and time.
//!
//! Metres and seconds; heights upwards. A stiff spring pushes a ball out of the ground, or the ball is
//! reflected. The reference is the closed form of both in `f64`, which shares nothing with the
//! integrators. Over terrain balls fly freely and are reflected about its normal, beside exact events. Set-up as
//! published for balls on terrain by transform feedback (2007), whose text gives neither time step nor integrator.

mod arithmetic;
mod by_cpu;
mod chapter;
mod closed_form;
mod craters;
mod drawing;
mod drawn;
mod drop;
mod flight;
#[cfg(test)]
mod formulas;
mod integrator;
mod metrics;
mod on_devices;
mod scene;
mod stepping;
mod steps;
mod study;
mod terrain;
mod walk;

pub use study::BallsStudy;

/// Name of the study.
pub const STUDY: &str = "balls";
