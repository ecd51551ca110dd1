// SPDX-License-Identifier: MIT OR Apache-2.0
//! A browser driven by node: calls as lines of JSON, and the CPU time of its processes.
//!
//! The driver is `driver/driver.mjs`, the page's functions are `driver/page.js`; both are part of the
//! program. Times are milliseconds in steps of the kernel's clock tick (10 ms), so a sample covers
//! several frames.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use sysinfo::{Pid, ProcessRefreshKind, ProcessesToUpdate, System};
use terrafill_contract::DeviceError;
use terrafill_scene::ImageSize;

const DRIVER: &str = include_str!("../driver/driver.mjs");
const PAGE: &str = include_str!("../driver/page.js");

/// What Chromium is started with so that WebGL runs on Mesa's software rasteriser, the one behind
/// lavapipe: ANGLE on EGL, since ANGLE on Vulkan gives no WebGL 2 there.
const SOFTWARE_FLAGS: [&str; 4] = [
    "--use-gl=angle",
    "--use-angle=gl-egl",
    "--ignore-gpu-blocklist",
    "--disable-gpu-sandbox",
];
const SOFTWARE_VARIABLES: [(&str, &str); 3] = [
    ("LIBGL_ALWAYS_SOFTWARE", "1"),
    ("GALLIUM_DRIVER", "llvmpipe"),
    ("EGL_PLATFORM", "surfaceless"),
];

/// A line from the driver.
#[derive(Deserialize)]
struct Answer {
    value: Option<Value>,
    error: Option<String>,
}

/// What the driver says first.
#[derive(Deserialize)]
struct Started {
    pid: u32,
    product: String,
}

/// A browser with the page open. Ends with this value.
#[derive(Debug)]
pub(crate) struct Browser {
    driver: Child,
    calls: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
    root: Pid,
    system: System,
    /// Name and version, as the browser says it.
    pub(crate) product: String,
}

impl Browser {
    /// Starts node, and Chromium by it.
    ///
    /// - `cesium`: the folder of CesiumJS's release build
    /// - `is_software`: whether to draw on the CPU, as the other techniques do
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`] when either does not start or the page does not load.
    pub(crate) fn start(
        cesium: &Path,
        chromium: &Path,
        size: ImageSize,
        is_software: bool,
    ) -> Result<Self, DeviceError> {
        let (flags, variables): (&[&str], &[(&str, &str)]) = if is_software {
            (&SOFTWARE_FLAGS, &SOFTWARE_VARIABLES)
        } else {
            (&["--ignore-gpu-blocklist"], &[])
        };
        let told = json!({
            "cesium": cesium,
            "chromium": chromium,
            "flags": flags,
            "env": variables.iter().copied().collect::<BTreeMap<_, _>>(),
            "size": [size.width, size.height],
            "page": PAGE,
        });
        let mut driver = Command::new("node")
            .args(["--input-type=module", "--eval", DRIVER])
            .env("TERRAFILL_DRIVER", told.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| lost(&format!("node does not start: {error}")))?;
        let (Some(calls), Some(answers)) = (driver.stdin.take(), driver.stdout.take()) else {
            return Err(lost("node has no standard input or output"));
        };
        let mut browser = Self {
            driver,
            calls: Some(calls),
            answers: BufReader::new(answers),
            root: Pid::from_u32(0),
            system: System::new().map_err(|error| lost(&error.to_string()))?,
            product: String::new(),
        };
        let started: Started = browser.answer()?;
        browser.root = Pid::from_u32(started.pid);
        browser.product = started.product;
        Ok(browser)
    }

    /// Calls a function of the page.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`] with what the page or the driver said, or when the answer is another
    /// than `T`.
    pub(crate) fn call<T: DeserializeOwned>(
        &mut self,
        call: &str,
        given: Value,
    ) -> Result<T, DeviceError> {
        let line = json!({ "call": call, "given": given });
        let calls = self.calls.as_mut().ok_or_else(|| lost("it has ended"))?;
        writeln!(calls, "{line}").map_err(|error| lost(&format!("{call}: {error}")))?;
        self.answer()
    }

    fn answer<T: DeserializeOwned>(&mut self) -> Result<T, DeviceError> {
        let mut line = String::new();
        let read = self.answers.read_line(&mut line);
        read.map_err(|error| lost(&error.to_string()))?;
        let answer: Answer = serde_json::from_str(&line)
            .map_err(|error| lost(&format!("no answer of the driver: {error}")))?;
        match (answer.value, answer.error) {
            (_, Some(error)) => Err(lost(&error)),
            (value, None) => serde_json::from_value(value.unwrap_or_default())
                .map_err(|error| lost(&format!("an unexpected answer: {error}"))),
        }
    }

    /// CPU time of the work, over all of the browser's processes, and what the work gave. Work during
    /// which a process ends or starts is done again, since its time is not known.
    ///
    /// - returns: milliseconds
    ///
    /// # Errors
    /// Those of the work; [`DeviceError::DeviceLost`] when processes come and go for ever.
    pub(crate) fn cpu_ms<T>(
        &mut self,
        mut work: impl FnMut(&mut Self) -> Result<T, DeviceError>,
    ) -> Result<(f64, T), DeviceError> {
        const TRIES: u32 = 5;
        for _ in 0..TRIES {
            let before = cpu_times_ms(&mut self.system, self.root);
            let given = work(self)?;
            let after = cpu_times_ms(&mut self.system, self.root);
            if before.keys().eq(after.keys()) && !before.is_empty() {
                let spent = after.values().sum::<u64>() - before.values().sum::<u64>();
                return Ok((spent as f64, given));
            }
        }
        Err(lost("its processes come and go"))
    }
}

impl Drop for Browser {
    /// The driver ends when it has nothing more to read, and ends the browser.
    fn drop(&mut self) {
        self.calls = None;
        drop(self.driver.wait());
    }
}

fn lost(why: &str) -> DeviceError {
    DeviceError::DeviceLost(format!("CesiumJS in Chromium: {why}"))
}

/// CPU time that a process and all its descendants have used so far, milliseconds.
fn cpu_times_ms(system: &mut System, root: Pid) -> BTreeMap<Pid, u64> {
    let kind = ProcessRefreshKind::nothing().with_cpu().without_tasks();
    system.refresh_processes_specifics(ProcessesToUpdate::All, true, kind);
    let processes = system.processes();
    let mut tree = BTreeSet::from([root]);
    loop {
        let children = processes.iter().filter(|(pid, process)| {
            !tree.contains(*pid) && process.parent().is_some_and(|pid| tree.contains(&pid))
        });
        let children: Vec<Pid> = children.map(|(pid, _)| *pid).collect();
        if children.is_empty() {
            break;
        }
        tree.extend(children);
    }
    let times = tree.iter().filter_map(|pid| {
        let process = processes.get(pid)?;
        Some((*pid, process.accumulated_cpu_time()))
    });
    times.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CPU time that a shell with a busy child has after a while, milliseconds.
    fn spent_ms(script: &str, count_from_child: bool) -> u64 {
        let mut shell = Command::new("sh")
            .args(["-c", script])
            .spawn()
            .expect("a shell");
        std::thread::sleep(std::time::Duration::from_millis(600));
        let root = Pid::from_u32(shell.id());
        let mut times = cpu_times_ms(&mut System::new().expect("processes"), root);
        if count_from_child {
            times.remove(&root);
        }
        // The child ends by itself.
        drop(shell.wait());
        times.values().sum()
    }

    #[test]
    fn time_of_descendants_counts_and_sleep_does_not() {
        let busy = "timeout 1 sh -c 'while :; do :; done'; true";
        assert!(spent_ms(busy, true) >= 100);
        // Negative control: processes that sleep.
        assert!(spent_ms("sleep 1; true", false) < 100);
    }

    #[test]
    fn a_browser_that_is_not_there_is_an_error() {
        let nowhere = Path::new("/nonexistent");
        let size = ImageSize::new(8, 8);
        let error = Browser::start(nowhere, nowhere, size, true).expect_err("no browser");
        assert!(error.to_string().contains("does not start"), "{error}");
    }
}
