// SPDX-License-Identifier: MIT OR Apache-2.0
//! Choosing an adapter and refusing what it cannot: the same on every API, so that both open the
//! same one and say the same of it.

use crate::DeviceError;
use terrafill_scene::ImageSize;

/// Kind of adapter, in order of preference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceType {
    /// With memory of its own.
    DiscreteGpu,
    /// Sharing the host's memory.
    IntegratedGpu,
    /// Lent to a virtual machine.
    VirtualGpu,
    /// Not known.
    Other,
    /// A software driver.
    Cpu,
}

impl DeviceType {
    /// Name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DiscreteGpu => "discrete-gpu",
            Self::IntegratedGpu => "integrated-gpu",
            Self::VirtualGpu => "virtual-gpu",
            Self::Other => "other",
            Self::Cpu => "cpu",
        }
    }
}

/// What an adapter is, for reports; `F`: what it can do beyond what is needed, as its API says it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceFacts<F> {
    /// Adapter name.
    pub name: String,
    /// [`DeviceType::name`].
    pub device_type: &'static str,
    /// PCI vendor id.
    pub vendor_id: u32,
    /// PCI device id.
    pub device_id: u32,
    /// Driver name.
    pub driver: String,
    /// Driver version text.
    pub driver_info: String,
    /// UUID of the driver's build, hexadecimal; empty where the API does not say it.
    pub driver_uuid: String,
    /// What it can do beyond what is needed.
    pub features: F,
    /// What this project needs and the adapter lacks; empty when it can run.
    pub lacks: Vec<String>,
}

impl<F> DeviceFacts<F> {
    /// Whether it is a CPU.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.device_type == DeviceType::Cpu.name()
    }

    /// Adapter and driver.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{} ({})", self.name, self.driver_info)
    }

    /// Whether it can run.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] with all that it lacks.
    pub fn check(&self) -> Result<(), DeviceError> {
        if self.lacks.is_empty() {
            return Ok(());
        }
        Err(DeviceError::unsupported(&self.lacks.join(", "), &self.name))
    }
}

/// Where something is missing that no adapter of its own could have.
pub const THIS_MACHINE: &str = "this machine";

/// Index of the first adapter, in order of preference, whose name contains `wanted`, case ignored.
///
/// # Errors
/// [`DeviceError::Unsupported`] when there is none, or none by that name.
pub fn choose_adapter(names: &[&str], wanted: Option<&str>) -> Result<usize, DeviceError> {
    if names.is_empty() {
        let what = "a Vulkan device (ci/setup.sh installs a software one)";
        return Err(DeviceError::unsupported(what, THIS_MACHINE));
    }
    let wanted = wanted.unwrap_or("").to_lowercase();
    let is_wanted = |name: &&str| name.to_lowercase().contains(&wanted);
    names.iter().position(is_wanted).ok_or_else(|| {
        let what = format!("an adapter called {wanted:?}; it has {}", names.join(", "));
        DeviceError::unsupported(&what, THIS_MACHINE)
    })
}

/// A device for a test. Where there is none, prints why and gives `None`, so that everything but
/// device tests passes on a machine without a GPU.
///
/// # Panics
/// When there is none and `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does: there a skipped
/// device test would be a check that does not check.
#[must_use]
pub fn device_for_test<T>(opened: Result<T, DeviceError>) -> Option<T> {
    let require = std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_some();
    opened
        .inspect_err(|error| {
            assert!(!require, "TERRAFILL_REQUIRE_DEVICE is set: {error}");
            eprintln!("skipped: {error}");
        })
        .ok()
}

/// What the surface pass leaves where there is no surface: almost black, alpha 0 like the surface.
pub const SKY: [f32; 4] = [0.02, 0.02, 0.04, 0.0];

/// Whether an adapter has targets of this size.
///
/// - `limit`: pixels a side
///
/// # Errors
/// [`DeviceError::Unsupported`].
pub fn check_target_size(size: ImageSize, limit: u32, adapter: &str) -> Result<(), DeviceError> {
    if size.width.max(size.height) <= limit && size.width.min(size.height) > 0 {
        return Ok(());
    }
    let what = format!(
        "images of {} × {} pixels (1 … {limit} a side)",
        size.width, size.height
    );
    Err(DeviceError::unsupported(&what, adapter))
}

/// `count` as the 32 bits that draw calls take.
///
/// # Errors
/// [`DeviceError::OverCapacity`].
pub fn count_u32(what: &str, count: usize) -> Result<u32, DeviceError> {
    u32::try_from(count).map_err(|_| DeviceError::OverCapacity {
        what: what.to_owned(),
        found: count as u64,
        allowed: u64::from(u32::MAX),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_by_that_name_is_chosen_and_an_unknown_name_refused() {
        let names = ["Alpha 2", "Beta", "alpha 1"];
        assert_eq!(choose_adapter(&names, None).expect("one"), 0);
        assert_eq!(choose_adapter(&names, Some("ALPHA")).expect("one"), 0);
        assert_eq!(choose_adapter(&names, Some("a 1")).expect("one"), 2);
        let error = choose_adapter(&names, Some("gamma")).expect_err("none");
        assert!(error.to_string().contains("it has Alpha 2, Beta, alpha 1"));
        let error = choose_adapter(&[], None).expect_err("none");
        assert!(error.to_string().contains("a Vulkan device"), "{error}");
    }

    #[test]
    fn an_adapter_that_lacks_something_is_refused_with_all_of_it() {
        let mut facts = DeviceFacts {
            name: "A".to_owned(),
            device_type: DeviceType::Cpu.name(),
            vendor_id: 1,
            device_id: 2,
            driver: "d".to_owned(),
            driver_info: "1.2".to_owned(),
            driver_uuid: String::new(),
            features: (),
            lacks: Vec::new(),
        };
        assert_eq!(facts.title(), "A (1.2)");
        assert!(facts.check().is_ok());
        facts.lacks = vec!["one".to_owned(), "another".to_owned()];
        let error = facts.check().expect_err("it lacks two things");
        assert_eq!(error.to_string(), "A lacks one, another");
    }

    #[test]
    fn a_software_driver_comes_last() {
        let mut types = [DeviceType::Cpu, DeviceType::Other, DeviceType::DiscreteGpu];
        types.sort_unstable();
        assert_eq!(
            types.map(DeviceType::name),
            ["discrete-gpu", "other", "cpu"]
        );
    }

    #[test]
    fn targets_are_neither_empty_nor_larger_than_the_limit() {
        let check = |width, height| check_target_size(ImageSize { width, height }, 64, "A").is_ok();
        assert!(check(1, 64) && check(64, 1));
        assert!(!check(65, 1) && !check(1, 65) && !check(0, 64) && !check(64, 0));
    }

    #[test]
    fn counts_of_more_than_32_bits_are_refused() {
        let largest = u32::MAX as usize;
        assert_eq!(count_u32("x", largest).expect("fits"), u32::MAX);
        assert!(count_u32("x", largest + 1).is_err());
    }
}
