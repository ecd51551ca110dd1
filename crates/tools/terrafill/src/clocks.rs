// SPDX-License-Identifier: MIT OR Apache-2.0
//! At which clocks a device runs, where the system says so: `nvidia-smi` and files below `/sys`.
//!
//! A clock that is not there is no error. Its row has the reason, since a time without it is as good.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use terrafill_gpu::DeviceFacts;
use terrafill_results::{DeviceClock, Moment};

/// PCI ids of vendors.
const NVIDIA: u32 = 0x10de;
const AMD: u32 = 0x1002;
const INTEL: u32 = 0x8086;

const NVIDIA_SMI: &str = "nvidia-smi";
const NVIDIA_QUERY: [&str; 2] = [
    "--query-gpu=name,clocks.sm,clocks.max.sm,clocks.mem,clocks.max.mem",
    "--format=csv,noheader,nounits",
];

/// Where the system keeps what it says of devices.
const SYS: &str = "/sys";

/// Current and highest frequency of Intel's graphics, by driver, below the card's folder.
const INTEL_FILES: [[&str; 2]; 2] = [
    ["gt_cur_freq_mhz", "gt_RP0_freq_mhz"],
    [
        "device/tile0/gt0/freq0/cur_freq",
        "device/tile0/gt0/freq0/rp0_freq",
    ],
];

/// A clock, its frequency and the highest that it can have, MHz.
#[derive(Debug, Clone, PartialEq)]
struct Reading {
    clock: &'static str,
    mhz: f64,
    max_mhz: Option<f64>,
}

/// Rows of the device's clocks as they are now; one row with the reason where none is known.
pub(crate) fn device_clocks(
    device: Option<&DeviceFacts>,
    process: u32,
    moment: Moment,
) -> Vec<DeviceClock> {
    let row = |clock: &str, mhz, max_mhz, reason| DeviceClock {
        process,
        moment,
        clock: clock.to_owned(),
        mhz,
        max_mhz,
        reason,
    };
    match read(device, Path::new(SYS)) {
        Ok(readings) => readings
            .into_iter()
            .map(|read| row(read.clock, Some(read.mhz), read.max_mhz, String::new()))
            .collect(),
        Err(reason) => vec![row("", None, None, reason)],
    }
}

/// The device's clocks, or why they are not known.
fn read(device: Option<&DeviceFacts>, sys: &Path) -> Result<Vec<Reading>, String> {
    let device = device.ok_or("there is no device")?;
    if device.is_software() {
        return cores(sys);
    }
    match device.vendor_id {
        NVIDIA => by_nvidia_smi(&nvidia_smi()?, &device.name),
        AMD => amd(&card(sys, device)?),
        INTEL => intel(&card(sys, device)?),
        vendor => Err(format!(
            "nothing is known of clocks of vendor {vendor:#06x}"
        )),
    }
}

/// What `nvidia-smi` prints.
fn nvidia_smi() -> Result<String, String> {
    let mut command = Command::new(NVIDIA_SMI);
    let ran = command.args(NVIDIA_QUERY).stdin(Stdio::null()).output();
    let ran = ran.map_err(|error| format!("{NVIDIA_SMI}: {error}"))?;
    if !ran.status.success() {
        return Err(format!("{NVIDIA_SMI}: {}", ran.status));
    }
    Ok(String::from_utf8_lossy(&ran.stdout).into_owned())
}

/// Of the GPU named `name`: its line has the columns of [`NVIDIA_QUERY`].
fn by_nvidia_smi(printed: &str, name: &str) -> Result<Vec<Reading>, String> {
    let rows = printed
        .lines()
        .map(|line| line.split(',').map(str::trim).collect());
    let mut of_name: Vec<Vec<&str>> = rows.filter(|row: &Vec<&str>| row[0] == name).collect();
    let row = match of_name.len() {
        1 => of_name.remove(0),
        found => return Err(format!("{NVIDIA_SMI}: {found} GPUs are named {name:?}")),
    };
    let frequency = |column: usize| row.get(column).and_then(|text| text.parse::<f64>().ok());
    let readings = [("graphics", 1), ("memory", 3)].map(|(clock, column)| {
        Some(Reading {
            clock,
            mhz: frequency(column)?,
            max_mhz: frequency(column + 1),
        })
    });
    let readings: Vec<Reading> = readings.into_iter().flatten().collect();
    if !readings.is_empty() {
        Ok(readings)
    } else {
        Err(format!("{NVIDIA_SMI}: found {:?}", row.join(", ")))
    }
}

/// The folder of the one graphics card with the device's ids.
fn card(sys: &Path, device: &DeviceFacts) -> Result<PathBuf, String> {
    let folder = sys.join("class/drm");
    let is_it = |card: &PathBuf| {
        let id = |file: &str| {
            let text = text_of(&card.join("device").join(file)).ok()?;
            u32::from_str_radix(text.strip_prefix("0x")?, 16).ok()
        };
        is_numbered(card, "card")
            && (id("vendor"), id("device")) == (Some(device.vendor_id), Some(device.device_id))
    };
    let mut cards: Vec<PathBuf> = entries(&folder)?.into_iter().filter(is_it).collect();
    match cards.len() {
        1 => Ok(cards.remove(0)),
        found => Err(format!(
            "{}: {found} cards are {:#06x}:{:#06x}",
            folder.display(),
            device.vendor_id,
            device.device_id
        )),
    }
}

/// Of AMD's driver: tables of levels, the one in use with a star.
fn amd(card: &Path) -> Result<Vec<Reading>, String> {
    let files = [("graphics", "pp_dpm_sclk"), ("memory", "pp_dpm_mclk")];
    let readings: Result<Vec<Reading>, String> = files
        .iter()
        .map(|&(clock, file)| {
            let path = card.join("device").join(file);
            let levels = text_of(&path)?;
            let found = in_use(&levels).ok_or_else(|| format!("{}: {levels:?}", path.display()));
            found.map(|[mhz, max_mhz]| Reading {
                clock,
                mhz,
                max_mhz: Some(max_mhz),
            })
        })
        .collect();
    readings
}

/// The level in use and the highest one of lines such as `1: 2744Mhz *`.
fn in_use(levels: &str) -> Option<[f64; 2]> {
    let frequency = |line: &str| -> Option<f64> {
        let (_, level) = line.split_once(':')?;
        level.split_once("Mhz")?.0.trim().parse().ok()
    };
    let used = levels.lines().find(|line| line.trim_end().ends_with('*'))?;
    let highest = levels
        .lines()
        .filter_map(frequency)
        .max_by(f64::total_cmp)?;
    Some([frequency(used)?, highest])
}

/// Of one of Intel's drivers: a file with a number.
fn intel(card: &Path) -> Result<Vec<Reading>, String> {
    let read = |[now, highest]: &[&str; 2]| -> Result<Reading, String> {
        Ok(Reading {
            clock: "graphics",
            mhz: number(&card.join(now))?,
            max_mhz: number(&card.join(highest)).ok(),
        })
    };
    let mut found = INTEL_FILES.iter().map(read);
    let first = found.find_map(Result::ok);
    first.map(|reading| vec![reading]).ok_or_else(|| {
        let files = INTEL_FILES.map(|[now, _]| now);
        format!("{}: no {}", card.display(), files.join(" and no "))
    })
}

/// Of the slowest and of the fastest core: where the device is the CPU.
fn cores(sys: &Path) -> Result<Vec<Reading>, String> {
    let folder = sys.join("devices/system/cpu");
    let cores = entries(&folder)?;
    let of = |file: &str| -> Vec<f64> {
        let cores = cores.iter().filter(|core| is_numbered(core, "cpu"));
        // In kHz.
        let read = cores.filter_map(|core| number(&core.join("cpufreq").join(file)).ok());
        read.map(|khz| khz / 1_000.0).collect()
    };
    let (now, highest) = (of("scaling_cur_freq"), of("cpuinfo_max_freq"));
    let max_mhz = highest.into_iter().max_by(f64::total_cmp);
    let [slowest, fastest] = [
        now.iter().copied().min_by(f64::total_cmp),
        now.iter().copied().max_by(f64::total_cmp),
    ];
    let (Some(slowest), Some(fastest)) = (slowest, fastest) else {
        return Err(format!("{}: no core has cpufreq", folder.display()));
    };
    let reading = |clock, mhz| Reading {
        clock,
        mhz,
        max_mhz,
    };
    Ok(vec![
        reading("slowest core", slowest),
        reading("fastest core", fastest),
    ])
}

/// Whether a file's name is this and a number.
fn is_numbered(path: &Path, name: &str) -> bool {
    let file = path.file_name().map(|file| file.to_string_lossy());
    file.is_some_and(|file| {
        let number = file.strip_prefix(name).unwrap_or_default();
        !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())
    })
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    entries
        .map(|entry| entry.map(|entry| entry.path()).map_err(failed))
        .collect()
}

fn text_of(path: &Path) -> Result<String, String> {
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(text.trim().to_owned())
}

fn number(path: &Path) -> Result<f64, String> {
    let text = text_of(path)?;
    let number: Result<f64, _> = text.parse();
    number.map_err(|_| format!("{}: found {text:?}, allowed: a number", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(clock: &'static str, mhz: f64, max_mhz: Option<f64>) -> Reading {
        Reading {
            clock,
            mhz,
            max_mhz,
        }
    }

    /// Files below a folder that stands for `/sys`.
    fn sys(files: &[(&str, &str)]) -> tempfile::TempDir {
        let sys = tempfile::tempdir().expect("a folder");
        for (file, text) in files {
            let path = sys.path().join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
            std::fs::write(path, text).expect("writable");
        }
        sys
    }

    fn device(device_type: &'static str, vendor_id: u32, device_id: u32) -> DeviceFacts {
        DeviceFacts {
            name: "a device".to_owned(),
            device_type,
            vendor_id,
            device_id,
            driver: String::new(),
            driver_info: String::new(),
            driver_uuid: String::new(),
            features: terrafill_gpu::Features::default(),
            lacks: Vec::new(),
        }
    }

    #[test]
    fn nvidia_smi_is_read_by_the_name_of_the_gpu() {
        let printed = "NVIDIA A2, 210, 1770, 405, 6251\nNVIDIA H200, 1980, 1980, 3201, [N/A]\n";
        assert_eq!(
            by_nvidia_smi(printed, "NVIDIA H200"),
            Ok(vec![
                reading("graphics", 1_980.0, Some(1_980.0)),
                reading("memory", 3_201.0, None),
            ])
        );
        // Negative controls: another GPU, two of one name, and clocks that it does not say.
        let twice = format!("{printed}{printed}");
        let silent = "NVIDIA H200, [N/A], [N/A], [N/A], [N/A]\n";
        for (printed, name, why) in [
            (printed, "NVIDIA H100", "0 GPUs are named \"NVIDIA H100\""),
            (&twice, "NVIDIA H200", "2 GPUs are named"),
            (silent, "NVIDIA H200", "[N/A]"),
            ("", "NVIDIA H200", "0 GPUs"),
            ("NVIDIA H200\n", "NVIDIA H200", "found \"NVIDIA H200\""),
        ] {
            let reason = by_nvidia_smi(printed, name).expect_err(why);
            assert!(reason.contains(why), "{reason}");
        }
    }

    #[test]
    fn cards_are_read_by_their_ids_and_amd_marks_the_level_in_use() {
        let amd_card = [
            ("class/drm/card1/device/vendor", "0x1002\n"),
            ("class/drm/card1/device/device", "0x744c\n"),
            (
                "class/drm/card1/device/pp_dpm_sclk",
                "0: 500Mhz\n1: 1400Mhz *\n2: 2304Mhz\n",
            ),
            (
                "class/drm/card1/device/pp_dpm_mclk",
                "S: 19Mhz *\n0: 96Mhz\n",
            ),
            // An output of the card is none.
            ("class/drm/card1-DP-1/device/vendor", "0x1002\n"),
            ("class/drm/card1-DP-1/device/device", "0x744c\n"),
        ];
        let desk = sys(&amd_card);
        let wanted = device("discrete-gpu", AMD, 0x744c);
        assert_eq!(
            read(Some(&wanted), desk.path()),
            Ok(vec![
                reading("graphics", 1_400.0, Some(2_304.0)),
                reading("memory", 19.0, Some(96.0)),
            ])
        );
        // Negative controls: another card, and a table without a star.
        let other = device("discrete-gpu", AMD, 0x73bf);
        let reason = read(Some(&other), desk.path()).expect_err("another card");
        assert!(reason.ends_with("0 cards are 0x1002:0x73bf"), "{reason}");
        assert_eq!(in_use("0: 500Mhz\n1: 1400Mhz\n"), None);
    }

    #[test]
    fn both_of_intels_drivers_are_read() {
        for [now, highest] in INTEL_FILES {
            let card = "class/drm/card0";
            let [now, highest] = [now, highest].map(|file| format!("{card}/{file}"));
            let desk = sys(&[
                ("class/drm/card0/device/vendor", "0x8086\n"),
                ("class/drm/card0/device/device", "0x56a0\n"),
                (&now, "600\n"),
                (&highest, "2400\n"),
            ]);
            let wanted = device("integrated-gpu", INTEL, 0x56a0);
            assert_eq!(
                read(Some(&wanted), desk.path()),
                Ok(vec![reading("graphics", 600.0, Some(2_400.0))])
            );
            // Negative control: no number is no clock.
            std::fs::write(desk.path().join(&now), "fast").expect("writable");
            let reason = read(Some(&wanted), desk.path()).expect_err("no number");
            assert!(reason.contains("no gt_cur_freq_mhz"), "{reason}");
        }
    }

    #[test]
    fn a_software_device_has_the_clocks_of_its_cores() {
        let desk = sys(&[
            (
                "devices/system/cpu/cpu0/cpufreq/scaling_cur_freq",
                "3400000\n",
            ),
            (
                "devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq",
                "4900000\n",
            ),
            (
                "devices/system/cpu/cpu11/cpufreq/scaling_cur_freq",
                "800000\n",
            ),
            ("devices/system/cpu/cpufreq/scaling_cur_freq", "1\n"),
        ]);
        let wanted = device("cpu", AMD, 0);
        assert_eq!(
            read(Some(&wanted), desk.path()),
            Ok(vec![
                reading("slowest core", 800.0, Some(4_900.0)),
                reading("fastest core", 3_400.0, Some(4_900.0)),
            ])
        );
        // Negative controls: no cpufreq, no folder, no device, another vendor.
        let none = sys(&[("devices/system/cpu/cpu0/topology/core_id", "0\n")]);
        let empty = sys(&[]);
        let unknown = device("discrete-gpu", 0x1414, 0);
        for (device, sys, why) in [
            (Some(&wanted), &none, "no core has cpufreq"),
            (Some(&wanted), &empty, "No such file"),
            (None, &none, "there is no device"),
            (Some(&unknown), &none, "vendor 0x1414"),
        ] {
            let reason = read(device, sys.path()).expect_err(why);
            assert!(reason.contains(why), "{reason}");
        }
        let rows = device_clocks(None, 3, Moment::End);
        assert_eq!((rows[0].process, rows[0].mhz), (3, None));
        assert_eq!(rows[0].reason, "there is no device");
    }
}
