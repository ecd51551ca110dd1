// SPDX-License-Identifier: MIT OR Apache-2.0
//! What cases compute.

use crate::ablation::StencilStep;
use crate::counted::{Counted, Ranges};
use crate::lamps::{LampEye, LampName, Limit};
use crate::maps::Bias;
use crate::rivals::Rival;
use crate::views::{Chooser, Eyes, Place};
use crate::way::DeviceWay;
use crate::work::{End, Scissor};
use terrafill_casters::Policy;
use terrafill_shadow_views::{EYE_SIZE, EyeTest, Interface, Rule};

terrafill_results::named! {
    /// How a silhouette is found.
    all pub(crate) enum Method {
        Stack = "stack",
        Hash = "hash",
        Adjacency = "adjacency",
    }
}

/// Casters of a frame: the paper's scale, and ten times it.
pub(crate) const PORT: &str = "port-m";
pub(crate) const TEN_PORTS: &str = "port-m10";

/// A frame with every optimisation but depth bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HarbourFrame {
    pub(crate) sun: [f64; 2],
    pub(crate) eyes: Eyes,
    pub(crate) interface: Interface,
    /// Name of the casters.
    pub(crate) port: &'static str,
    /// Of each channel, pixels; `None` for what the run draws frames in.
    pub(crate) size: Option<[u32; 2]>,
}

impl HarbourFrame {
    /// Of the port, as large as the run draws frames.
    pub(crate) fn plain(sun: [f64; 2], eyes: Eyes, interface: Interface) -> Self {
        Self {
            sun,
            eyes,
            interface,
            port: PORT,
            size: None,
        }
    }
}

/// What a case computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Job {
    Eye([f64; 2], f64, EyeTest),
    Updates([f64; 2], End, Rule),
    Scissor([f64; 2], Scissor, Counted),
    /// By depth bounds, volumes closed at the sea.
    Bounds([f64; 2], Rule, Ranges, Counted),
    Finite([f64; 2], f64),
    Row(u32, bool),
    Casters(Policy),
    Silhouette(&'static str, Method),
    /// What a user's file holds.
    Model,
    Device([f64; 2], Eyes, DeviceWay),
    Origin([f64; 2], Eyes, DeviceWay),
    /// Of boxes, turned so that faces are edge-on or at random.
    Facing([f64; 2], bool, DeviceWay),
    Near([f64; 2], DeviceWay),
    DeviceRow(u32, DeviceWay),
    Map([f64; 2], f64, Bias),
    DeviceMap([f64; 2], f64, Bias),
    Rival([f64; 2], Eyes, Rival),
    View([f64; 2], Place, Chooser),
    /// A frame of all channels.
    Harbour(HarbourFrame),
    StencilStep([f64; 2], StencilStep),
    /// From the bridge, counted along rays.
    Lamp(LampName, Rule, Limit),
    DeviceLamp(LampName, LampEye, Interface, Rule, Limit),
    /// From the bridge under the moon, counted along rays.
    Moon(Rule),
    DeviceMoon(Eyes, Interface, Rule),
}

impl Job {
    /// Pixels of each of its channels.
    ///
    /// - `computed`: of each channel in which the CPU answers
    /// - `frame`: of each channel that a device draws
    pub(crate) fn size(self, computed: [u32; 2], frame: [u32; 2]) -> Option<[u32; 2]> {
        match self {
            Self::Harbour(own) => Some(own.size.unwrap_or(frame)),
            // Thousands of their pixels are to be wrong, and the reference asks for each of them.
            Self::Near(..)
            | Self::DeviceRow(..)
            | Self::DeviceLamp(_, LampEye::InShadow, _, Rule::Pass, _) => Some(computed),
            Self::DeviceLamp(..) | Self::DeviceMoon(..) => Some(frame),
            Self::Model | Self::Silhouette(..) => None,
            Self::Eye(..) => Some(EYE_SIZE),
            job if job.is_of_device() => Some(frame),
            _ => Some(computed),
        }
    }

    /// Whether a device draws it.
    pub(crate) fn is_drawn(self) -> bool {
        self.is_of_device() || matches!(self, Self::Origin(..) | Self::Facing(..))
    }

    /// Whether a device is timed at it.
    pub(crate) fn is_of_device(self) -> bool {
        matches!(
            self,
            Self::Device(..)
                | Self::Near(..)
                | Self::DeviceRow(..)
                | Self::DeviceMap(..)
                | Self::Rival(..)
                | Self::StencilStep(..)
        )
    }
}

/// As rows have it.
pub(crate) fn sun_name([elevation, azimuth]: [f64; 2]) -> String {
    format!("{elevation}° from {azimuth}°")
}
