// SPDX-License-Identifier: MIT OR Apache-2.0
//! Devices of a run, each opened once, by whoever asks first.
//!
//! The contract names no graphics interface: a device crate keeps its device here under its own
//! type, and everyone who draws through that crate finds the same one.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// One value of each type.
#[derive(Debug, Default)]
pub(crate) struct TypeMap(RefCell<HashMap<TypeId, Box<dyn Any>>>);

impl TypeMap {
    /// The value of type `T`, made unless it is there. `make` may ask this map for other types.
    pub(crate) fn get<T: Clone + 'static>(&self, make: impl FnOnce() -> T) -> T {
        let there = |map: &HashMap<TypeId, Box<dyn Any>>| {
            let value = map.get(&TypeId::of::<T>());
            value.and_then(|value| value.downcast_ref::<T>()).cloned()
        };
        if let Some(value) = there(&self.0.borrow()) {
            return value;
        }
        let made = make();
        let mut map = self.0.borrow_mut();
        map.insert(TypeId::of::<T>(), Box::new(made.clone()));
        made
    }
}

/// Whether a device is gone. Clones say the same, from any thread: drivers tell it by a callback.
#[derive(Debug, Clone, Default)]
pub struct DeviceLoss(Arc<OnceLock<String>>);

impl DeviceLoss {
    /// The device is gone; only the first message is kept, since others follow from it.
    pub fn report(&self, message: &str) {
        self.0.get_or_init(|| message.to_owned());
    }

    /// What the driver said when it lost the device; `None` while there is no loss.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }
}

/// How to choose a device.
#[derive(Debug, Clone, Default)]
pub struct DeviceOptions {
    /// Part of the adapter's name, case ignored; the first that fits is taken. `None`: a discrete
    /// GPU before an integrated one before a software one.
    pub adapter: Option<String>,
    /// Turn validation layers on; also on with `TERRAFILL_VALIDATION=1`.
    pub validation: bool,
    /// Where a loss of the device is reported.
    pub loss: DeviceLoss,
}

/// Devices on one adapter.
#[derive(Debug, Default)]
pub struct Devices {
    adapter: Option<String>,
    opened: TypeMap,
    loss: DeviceLoss,
}

impl Devices {
    /// Nothing is opened yet.
    ///
    /// - `adapter`: part of the adapter's name; `None` for each device crate's first choice
    #[must_use]
    pub fn new(adapter: Option<String>) -> Self {
        Self {
            adapter,
            ..Self::default()
        }
    }

    /// Whether one of them is gone. A device crate hands it to the device that it opens.
    #[must_use]
    pub fn loss(&self) -> &DeviceLoss {
        &self.loss
    }

    /// Part of the adapter's name.
    #[must_use]
    pub fn adapter(&self) -> Option<&str> {
        self.adapter.as_deref()
    }

    /// As [`Devices::get`]; `open` gets what to open.
    ///
    /// # Errors
    /// As [`Devices::get`].
    pub fn open<T: Clone + 'static, E: Clone + 'static>(
        &self,
        open: impl FnOnce(&DeviceOptions) -> Result<T, E>,
    ) -> Result<T, E> {
        self.get(|adapter| {
            open(&DeviceOptions {
                adapter: adapter.map(str::to_owned),
                loss: self.loss.clone(),
                ..DeviceOptions::default()
            })
        })
    }

    /// The device of type `T`; `open` gets the adapter's name and is called once, whatever comes of
    /// it.
    ///
    /// # Errors
    /// What `open` failed with, again for everyone who asks.
    pub fn get<T: Clone + 'static, E: Clone + 'static>(
        &self,
        open: impl FnOnce(Option<&str>) -> Result<T, E>,
    ) -> Result<T, E> {
        self.opened.get(|| open(self.adapter()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_device_is_opened_once_and_a_failure_repeated() {
        let devices = Devices::new(Some("A".to_owned()));
        let opened = Cell::new(0);
        let open = |adapter: Option<&str>| -> Result<String, u8> {
            opened.set(opened.get() + 1);
            Ok(adapter.unwrap_or_default().to_owned())
        };
        assert_eq!(devices.get(open), Ok("A".to_owned()));
        assert_eq!(devices.get(open), Ok("A".to_owned()));
        assert_eq!(opened.get(), 1);
        let fail = |_: Option<&str>| -> Result<u32, String> {
            opened.set(opened.get() + 1);
            Err("none".to_owned())
        };
        assert_eq!(devices.get(fail), Err("none".to_owned()));
        assert_eq!(devices.get(fail), Err("none".to_owned()));
        assert_eq!(opened.get(), 2);
        // Negative control: other devices open their own.
        assert_eq!(Devices::default().get(open), Ok(String::new()));
        assert_eq!(opened.get(), 3);
    }

    #[test]
    fn a_loss_is_known_to_all_clones_by_its_first_message() {
        let devices = Devices::default();
        let device = devices.loss().clone();
        assert_eq!(devices.loss().message(), None);
        device.report("timed out");
        device.report("a later call failed");
        assert_eq!(devices.loss().message(), Some("timed out"));
        // Negative control: other devices are not lost.
        assert_eq!(Devices::default().loss().message(), None);
    }

    #[test]
    fn what_opens_may_need_another() {
        let devices = Devices::default();
        let inner = || devices.get(|_| Ok::<u8, ()>(1));
        let outer = devices.get(|_| inner().map(u16::from));
        assert_eq!((outer, inner()), (Ok(1_u16), Ok(1)));
    }
}
