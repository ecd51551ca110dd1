// SPDX-License-Identifier: MIT OR Apache-2.0
//! Groups of cases run by tests, on devices of both interfaces.

use std::rc::Rc;
use terrafill_contract::{Devices, device_for_test};
use terrafill_results::{Status, Verdict};
use terrafill_study::{Context, Failure, Group};

/// Devices and the folder of a run.
pub(crate) struct Tested {
    pub(crate) devices: Rc<Devices>,
    folder: tempfile::TempDir,
}

impl Tested {
    /// `None`, so that a test is skipped, where an interface has no device.
    pub(crate) fn open() -> Option<Self> {
        let devices = Rc::new(Devices::default());
        device_for_test(terrafill_gpu::shared_gpu(&devices))?;
        device_for_test(terrafill_vulkan::shared_gpu(&devices))?;
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("images")).expect("writable");
        Some(Self { devices, folder })
    }

    /// Verdicts of all cases of a group that a device has, by their number. The last right one that is timed in runs
    /// is timed once.
    pub(crate) fn verdicts(&self, group: &impl Group) -> Vec<(usize, Verdict)> {
        let context = Context {
            devices: &self.devices,
            folder: self.folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        let mut verdicts = Vec::new();
        for (at, case) in group.cases().iter().enumerate() {
            let verdict = session
                .verify(at)
                .or_else(Failure::verdict)
                .expect("a verdict");
            let (name, status) = (&case.id.name, verdict.status);
            eprintln!(
                "{name}: {status:?} {} {:?}",
                verdict.reason, verdict.figures
            );
            if status == Status::Skipped {
                assert!(!verdict.reason.is_empty(), "{name}");
            } else {
                verdicts.push((at, verdict));
            }
        }
        let is_timed = |at: usize| group.cases()[at].samples > 0;
        let right = verdicts.iter().filter(|(_, of)| of.status == Status::Ok);
        if let Some((last, _)) = right.rev().find(|(at, _)| is_timed(*at)) {
            let times = session.time(*last).expect("a time");
            assert!(times.iter().all(|(_, ms)| *ms > 0.0), "{times:?}");
        }
        verdicts
    }
}

/// A figure of a verdict.
pub(crate) fn figure(verdict: &Verdict, name: &str) -> f64 {
    let figure = verdict.figures.iter().find(|figure| figure.0 == name);
    figure.unwrap_or_else(|| panic!("{name} in {verdict:?}")).1
}
