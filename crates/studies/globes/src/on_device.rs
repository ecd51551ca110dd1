// SPDX-License-Identifier: MIT OR Apache-2.0
//! What tests of the study's parts have in common: a run's folder beside a device, and verdicts said aloud.

use crate::list::{List, ViewRow};
use std::fmt::Debug;
use std::rc::Rc;
use terrafill_contract::{DeviceError, Devices, device_for_test};
use terrafill_results::Verdict;
use terrafill_study::{Context, Failure, Session};

/// What `check` gives in a new folder; `None`, said aloud, where no device opens.
pub(crate) fn on_device<T, R>(
    open: fn(&Devices) -> Result<T, DeviceError>,
    check: impl FnOnce(Context<'_>) -> R,
) -> Option<R> {
    let devices = Rc::new(Devices::default());
    device_for_test(open(&devices))?;
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("images")).expect("writable");
    Some(check(Context {
        devices: &devices,
        folder: folder.path(),
    }))
}

/// The verdict on a case, printed with its figures.
pub(crate) fn verdict(session: &mut dyn Session, case: usize, name: &dyn Debug) -> Verdict {
    let verdict = session
        .verify(case)
        .or_else(Failure::verdict)
        .expect("a verdict");
    let Verdict {
        status,
        reason,
        figures,
        ..
    } = &verdict;
    eprintln!("{name:?}: {status:?} {reason} {figures:.6?}");
    verdict
}

/// A verdict's figure; NaN where it has none of that name.
pub(crate) fn figure(verdict: &Verdict, name: &str) -> f64 {
    let mut figures = verdict.figures.iter();
    let found = figures.find(|(known, _)| *known == name);
    found.map_or(f64::NAN, |(_, value)| *value)
}

/// A view under tiles of a map.
pub(crate) fn tiled_view(name: &str) -> ViewRow {
    let list = List::shipped().expect("a list");
    let mut views = list.tiled_view.into_iter();
    views.find(|view| view.name == name).expect("the view")
}
