// SPDX-License-Identifier: MIT OR Apache-2.0
//! What cases compute.

use crate::ablation::StencilStep;
use crate::counted::{Counted, Ranges};
use crate::lamps::{LampEye, LampName, Limit};
use crate::maps::Bias;
use crate::metrics::{CHECKED_PX, SIZE_PX};
use crate::rivals::Rival;
use crate::views::{Chooser, Eyes, Place};
use crate::way::DeviceWay;
use crate::work::{End, Scissor};
use terrafill_casters::Policy;
use terrafill_results::ConditionKey;
use terrafill_shadow_views::{EYE_SIZE, EyeTest, Interface, Rule};

terrafill_results::named! {
    /// How a silhouette is found.
    all pub(crate) enum Method {
        Stack = "stack",
        Hash = "hash",
        Adjacency = "adjacency",
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
    Harbour([f64; 2], Eyes, Interface),
    StencilStep([f64; 2], StencilStep),
    /// From the bridge, counted along rays.
    Lamp(LampName, Rule, Limit),
    DeviceLamp(LampName, LampEye, Interface, Rule, Limit),
    /// From the bridge under the moon, counted along rays.
    Moon(Rule),
    DeviceMoon(Eyes, Interface, Rule),
}

impl Job {
    /// Sizes of its pictures as conditions.
    ///
    /// - `checked`: of all channels
    /// - `timed`: of the one that is timed and kept as a picture
    /// - `frame`: of each channel of a frame
    pub(crate) fn sizes(
        self,
        checked: [u32; 2],
        timed: [u32; 2],
        frame: [u32; 2],
    ) -> Vec<(ConditionKey, [u32; 2])> {
        match self {
            Self::Harbour(..) | Self::DeviceLamp(..) | Self::DeviceMoon(..) => {
                vec![(SIZE_PX, frame)]
            }
            Self::Model | Self::Silhouette(..) => Vec::new(),
            Self::Eye(..) => vec![(SIZE_PX, EYE_SIZE)],
            job if job.is_of_device() => vec![(SIZE_PX, timed), (CHECKED_PX, checked)],
            _ => vec![(SIZE_PX, checked)],
        }
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
