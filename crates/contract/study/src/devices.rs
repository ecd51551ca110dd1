// SPDX-License-Identifier: MIT OR Apache-2.0
//! Devices that the studies of a run share, each opened when it is first asked for.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Opened devices by their type. It knows no API: who opens a device says how.
#[derive(Default)]
pub struct Devices {
    adapter: Option<String>,
    opened: RefCell<BTreeMap<TypeId, Box<dyn Any>>>,
}

impl std::fmt::Debug for Devices {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Devices")
            .field("adapter", &self.adapter)
            .field("opened", &self.opened.borrow().len())
            .finish()
    }
}

impl Devices {
    /// None opened yet.
    ///
    /// - `adapter`: part of the adapter's name; `None`: the first that will do
    #[must_use]
    pub fn new(adapter: Option<String>) -> Self {
        Self {
            adapter,
            opened: RefCell::default(),
        }
    }

    /// Part of the adapter's name that was asked for.
    #[must_use]
    pub fn adapter(&self) -> Option<&str> {
        self.adapter.as_deref()
    }

    /// The device of type `T`, opened by `open` the first time. A failure is kept too, so that it is
    /// met once and said alike for every case.
    ///
    /// - `open`: gets [`Devices::adapter`]
    ///
    /// # Errors
    /// What `open` answered.
    pub fn get<T, E>(&self, open: impl FnOnce(Option<&str>) -> Result<T, E>) -> Result<T, E>
    where
        T: Clone + 'static,
        E: Clone + 'static,
    {
        let key = TypeId::of::<T>();
        if let Some(known) = self.opened.borrow().get(&key)
            && let Some(known) = known.downcast_ref::<Result<T, E>>()
        {
            return known.clone();
        }
        let opened = open(self.adapter());
        let kept: Box<dyn Any> = Box::new(opened.clone());
        self.opened.borrow_mut().insert(key, kept);
        opened
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_opened_once_and_a_failure_is_met_once() {
        let devices = Devices::new(Some("llvm".to_owned()));
        let mut opened = 0;
        for _ in 0..2 {
            let name = devices.get(|adapter| {
                opened += 1;
                Ok::<_, String>(adapter.unwrap_or_default().to_owned())
            });
            assert_eq!(name.as_deref(), Ok("llvm"));
        }
        assert_eq!(opened, 1);
        let mut failed = 0;
        for _ in 0..2 {
            let number = devices.get(|_| {
                failed += 1;
                Err::<u32, _>("no such device".to_owned())
            });
            assert_eq!(number, Err("no such device".to_owned()));
        }
        assert_eq!(failed, 1, "another type is another device");
    }
}
