// SPDX-License-Identifier: MIT OR Apache-2.0
//! The fingerprint of the machine and build that a run was made with.

use std::time::{SystemTime, UNIX_EPOCH};
use sysinfo::System;
use terrafill_gpu::DeviceFacts;
use terrafill_results::{RunEnvironment, SCHEMA};

/// Facts about this machine, device and build.
///
/// - `device`: `None` where there is none; a study that needs none is measured all the same
/// - `size`: of pictures, pixels
/// - `options`: the run's, as `key=value`
pub(crate) fn environment(
    device: Option<&DeviceFacts>,
    size: [u32; 2],
    options: Vec<String>,
) -> RunEnvironment {
    // Unknown facts stay empty or 0: a report shows them as not known.
    let system = System::new().ok().map(|mut system| {
        system.refresh_memory();
        system.refresh_cpu_all();
        system
    });
    let cpus = system.as_ref().map_or(&[][..], |system| system.cpus());
    let cpu = cpus.first().map(|cpu| cpu.brand().trim().to_owned());
    let started = SystemTime::now().duration_since(UNIX_EPOCH);
    let text = |fact: fn(&DeviceFacts) -> &str| device.map_or("", fact).to_owned();
    RunEnvironment {
        schema: SCHEMA,
        // Of the build, see build.rs: the working directory may be another repository.
        commit: env!("TERRAFILL_COMMIT").to_owned(),
        started_unix_s: started.map_or(0, |time| time.as_secs()),
        cpu: cpu.unwrap_or_default(),
        cores: u32::try_from(cpus.len()).unwrap_or(u32::MAX),
        memory_bytes: system.as_ref().map_or(0, System::total_memory),
        os: format!(
            "{}, kernel {}",
            System::long_os_version().unwrap_or_default(),
            kernel_release(&System::kernel_version().unwrap_or_default())
        ),
        gpu: text(|device| &device.name),
        device_type: text(|device| device.device_type),
        vendor_id: device.map_or(0, |device| device.vendor_id),
        device_id: device.map_or(0, |device| device.device_id),
        driver: text(|device| &device.driver),
        driver_info: text(|device| &device.driver_info),
        driver_uuid: device.map_or_else(String::new, driver_uuid),
        mesa_version: mesa_version(device.map_or("", |device| &device.driver_info)),
        api: concat!(
            "Vulkan through wgpu ",
            env!("TERRAFILL_wgpu"),
            " and ash ",
            env!("TERRAFILL_ash")
        )
        .to_owned(),
        gpu_timestamps: device.is_some_and(|device| device.features.timestamps),
        width: size[0],
        height: size[1],
        shader_hash: format!("{:016x}", terrafill_gpu::shader_source_hash()),
        profile: if cfg!(debug_assertions) {
            "debug"
        } else {
            "release"
        }
        .to_owned(),
        options,
    }
}

/// UUID of the driver's build, which Vulkan itself says and wgpu does not; empty where neither does.
fn driver_uuid(device: &DeviceFacts) -> String {
    let adapters = terrafill_vulkan::list_adapters().unwrap_or_default();
    let mut same = adapters.into_iter().filter(|other| {
        (&other.name, other.vendor_id, other.device_id)
            == (&device.name, device.vendor_id, device.device_id)
    });
    same.next()
        .map_or_else(String::new, |adapter| adapter.driver_uuid)
}

/// `6.18.44-build-x` → `6.18.44`: builds differ between machines of one kind.
fn kernel_release(version: &str) -> &str {
    let is_release = |c: char| c.is_ascii_digit() || c == '.';
    let end = version.find(|c| !is_release(c)).unwrap_or(version.len());
    &version[..end]
}

/// `Mesa 25.0.7-2…` → `25.0.7-2…`.
fn mesa_version(driver_info: &str) -> String {
    let mut words = driver_info.split_whitespace();
    words
        .find(|&word| word == "Mesa")
        .and_then(|_| words.next())
        .unwrap_or_default()
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_is_named_by_its_release() {
        assert_eq!(kernel_release("6.1.0-18-amd64"), "6.1.0");
        assert_eq!(kernel_release("6.18.44"), "6.18.44");
        assert_eq!(kernel_release(""), "");
    }

    #[test]
    fn the_mesa_version_is_cut_out_and_other_drivers_have_none() {
        assert_eq!(
            mesa_version("Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)"),
            "25.0.7-2~bpo12+1"
        );
        assert_eq!(mesa_version("570.86.15"), "");
    }
}
