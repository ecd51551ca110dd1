// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a fragment finds its texture coordinate.
//!
//! A **coordinate route** is one way to get from a fragment's position relative to its region's
//! anchor (metres, `f32`, meridian axes) to longitude and latitude relative to the anchor's
//! (radians, `f32`). Every route is a [`Program`], one list of steps. From it its WGSL is printed,
//! its `f32` emulation is run, its operations are counted and its rounding is bounded. So none of
//! the four can contradict the others. What a route costs in accuracy over a [`MapRegion`] is its
//! [`Residual`], computed against the exact map of [`ExactGeodetic`].
//!
//! **Meridian axes**: body axes turned about the polar axis so that the anchor's longitude becomes
//! 0: x outward through the anchor's meridian in the equator's plane, y east, z to the north pole.
//! Angles are radians, lengths metres.

mod angle;
mod angle_core;
mod charts;
mod choose;
mod coefficients;
mod cube;
mod depth;
mod findings;
mod geodetic;
mod latitude;
mod lookup;
mod operations;
mod position;
mod region;
mod residual;
mod rounding;
mod route;
mod seen;

pub use angle_core::{AngleCore, Weight};
pub use charts::{Chart, ChartDegree, CubeSize};
pub use choose::{Choice, Chooser, Considered, Demand, MAX_TOLERANCE, RMS_TOLERANCE, Reason};
pub use cube::CubeTexture;
pub use depth::{DepthFormat, DepthFormatError, DepthMapping, DepthStorage};
pub use findings::{SUITE_EXTENTS_DEG, SUITE_LATITUDES_DEG, SuiteCell, SuiteFinding};
pub use geodetic::ExactGeodetic;
pub use latitude::LatitudeForm;
pub use lookup::{Filter, LookupTable, Sampler, TexelFormat};
pub use operations::{Arithmetic, Operations, Program, ProgramBuilder, Step, Value};
pub use position::{PerspectiveView, PositionResidual, PositionRoute, VertexFormat};
pub use region::{MapExtent, MapRegion, MapRegionError, Sample};
pub use residual::{Residual, ResidualSum, SAMPLING_SLACK};
pub use rounding::Bounded;
pub use route::{AngleForm, CoordinateRoute};
