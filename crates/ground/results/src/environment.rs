// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where and with what a run was made, and which clock its times are compared by.

use serde::{Deserialize, Serialize};

/// Where and with what a run was made. Free of host names: it is a fingerprint of the kind of
/// machine, not of the machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, Default)]
pub struct RunEnvironment {
    /// Version of these files' schema.
    pub schema: u32,
    /// Commit that the program was built from, with `+dirty` when its sources differed; empty where it
    /// was built outside a repository.
    pub commit: String,
    /// Seconds since 1970 at the start.
    pub started_unix_s: u64,
    /// CPU model.
    pub cpu: String,
    /// Logical cores.
    pub cores: u32,
    /// Memory, bytes.
    pub memory_bytes: u64,
    /// Operating system and kernel.
    pub os: String,
    /// Adapter name.
    pub gpu: String,
    /// `cpu`, `discrete-gpu` …
    pub device_type: String,
    /// PCI vendor id.
    pub vendor_id: u32,
    /// PCI device id.
    pub device_id: u32,
    /// Driver name.
    pub driver: String,
    /// Driver version text, which holds the Mesa version where the driver is Mesa's.
    pub driver_info: String,
    /// UUID of the driver's build, hexadecimal; empty where it is not known.
    #[serde(default)]
    pub driver_uuid: String,
    /// Mesa version cut out of `driver_info`; empty for other drivers.
    pub mesa_version: String,
    /// Graphics API.
    pub api: String,
    /// Whether the device has a clock that passes can be timed by.
    #[serde(default)]
    pub gpu_timestamps: bool,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Hash over all shader sources: changes when any of them does.
    pub shader_hash: String,
    /// Debug or release build.
    pub profile: String,
    /// The run's options as `key=value`.
    pub options: Vec<String>,
}

/// What times are measured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Clock {
    /// Timestamps of the device around its passes.
    Gpu,
    /// CPU time of the whole process. On a software device it contains the driver's threads, and a
    /// busy machine does not move it.
    ProcessCpu,
}

impl Clock {
    /// In plots, tables and sentences.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gpu => "GPU time",
            Self::ProcessCpu => "process CPU time",
        }
    }

    /// Of the two metrics of one span, the one by this clock.
    #[must_use]
    pub fn pick<T>(self, gpu: T, process_cpu: T) -> T {
        match self {
            Self::Gpu => gpu,
            Self::ProcessCpu => process_cpu,
        }
    }
}

impl RunEnvironment {
    /// The clock that ratios, rankings and plots of this run use: the device's own on hardware; on
    /// a software device, whose "GPU" is the CPU, process CPU time. The one place that decides.
    #[must_use]
    pub fn primary_clock(&self) -> Clock {
        if self.device_type == "cpu" || !self.gpu_timestamps {
            Clock::ProcessCpu
        } else {
            Clock::Gpu
        }
    }

    /// The first aspect in which a run made in `now` could not be compared with one made here, with
    /// both values; `None` where its rows may stand beside these.
    #[must_use]
    pub fn difference(&self, now: &Self) -> Option<String> {
        let aspects = |of: &Self| {
            [
                ("options", of.options.join(" ")),
                ("device", of.gpu.clone()),
                ("driver", of.driver_info.clone()),
                ("shader hash", of.shader_hash.clone()),
                ("profile", of.profile.clone()),
                // Whether the tree is clean changes with every edit, also of a text that nothing runs.
                ("commit", of.commit.trim_end_matches("+dirty").to_owned()),
            ]
        };
        let mut pairs = aspects(self).into_iter().zip(aspects(now));
        let ((what, then), (_, now)) = pairs.find(|(then, now)| then != now)?;
        Some(format!("{what} {now:?}, it was begun with {then:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(device_type: &str, gpu_timestamps: bool) -> RunEnvironment {
        RunEnvironment {
            device_type: device_type.to_owned(),
            gpu_timestamps,
            commit: "abc".to_owned(),
            ..RunEnvironment::default()
        }
    }

    #[test]
    fn hardware_is_timed_by_its_own_clock_and_software_by_the_process() {
        assert_eq!(on("discrete-gpu", true).primary_clock(), Clock::Gpu);
        assert_eq!(on("cpu", true).primary_clock(), Clock::ProcessCpu);
        assert_eq!(on("discrete-gpu", false).primary_clock(), Clock::ProcessCpu);
        assert_eq!(Clock::Gpu.pick(1, 2), 1);
        assert_eq!(Clock::ProcessCpu.pick(1, 2), 2);
    }

    #[test]
    fn another_commit_differs_and_an_edited_text_does_not() {
        let then = on("cpu", true);
        let mut now = then.clone();
        now.commit = "abc+dirty".to_owned();
        assert_eq!(then.difference(&now), None);
        now.commit = "def".to_owned();
        let what = then.difference(&now).expect("another commit");
        assert!(
            what.contains("commit \"def\"") && what.contains("\"abc\""),
            "{what}"
        );
    }
}
