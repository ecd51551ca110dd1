// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where techniques draw: render targets of one size, one set for each graphics interface.

use crate::devices::TypeMap;
use crate::{DeviceError, Devices, Picture, SurfaceView};
use std::rc::Rc;
use terrafill_scene::ImageSize;

/// A graphics interface. Techniques on the same one share a device and a set of render targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Api {
    /// `wgpu`, `vulkan` …
    pub name: &'static str,
}

/// Targets that a surface alone is drawn into.
pub trait SurfaceTargets {
    /// Uploads a view of a surface, unless they have it already.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when the view's size is not the targets'.
    fn prepare(&mut self, view: SurfaceView<'_>) -> Result<(), DeviceError>;

    /// Draws it, waits, and gives its GPU time, where there is a clock.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] before a view is prepared, [`DeviceError::DeviceLost`].
    fn draw_surface(&mut self) -> Result<Option<f64>, DeviceError>;

    /// Reads colour and depth back.
    ///
    /// # Errors
    /// [`DeviceError::Missing`] before anything is drawn, [`DeviceError::DeviceLost`].
    fn read(&self) -> Result<Picture, DeviceError>;
}

type Opened = Result<Box<dyn SurfaceTargets>, DeviceError>;

/// A graphics interface as a study of surfaces needs it.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceInterface {
    /// Which one.
    pub api: Api,
    /// Makes targets on a run's device.
    pub open: fn(&Devices, ImageSize) -> Opened,
}

/// Render targets of one image size, made by the device crates when a technique first asks.
#[derive(Debug)]
pub struct Targets {
    devices: Rc<Devices>,
    size: ImageSize,
    made: TypeMap,
}

impl Targets {
    /// Targets on `devices`; nothing is made yet.
    #[must_use]
    pub fn new(devices: &Rc<Devices>, size: ImageSize) -> Self {
        Self {
            devices: Rc::clone(devices),
            size,
            made: TypeMap::default(),
        }
    }

    /// Devices that they are made on.
    #[must_use]
    pub fn devices(&self) -> &Rc<Devices> {
        &self.devices
    }

    /// Size of every image.
    #[must_use]
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// The targets of type `T`; `make` is called once, whatever comes of it.
    ///
    /// # Errors
    /// What `make` failed with, again for everyone who asks.
    pub fn get<T: Clone + 'static, E: Clone + 'static>(
        &self,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        self.made.get(make)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_made_once_for_each_size_on_one_device() {
        let devices = Rc::new(Devices::default());
        let of = |width| {
            Targets::new(
                &devices,
                ImageSize {
                    width,
                    height: width,
                },
            )
        };
        let (small, large) = (of(1), of(2));
        let make = |targets: &Targets| {
            targets.get(|| {
                let gpu = targets.devices().get(|_| Ok(Rc::new(())))?;
                Ok::<_, ()>(Rc::new((gpu, targets.size().width)))
            })
        };
        let (first, again, other) = (make(&small), make(&small), make(&large));
        let (Ok(first), Ok(again), Ok(other)) = (first, again, other) else {
            panic!("nothing fails here");
        };
        assert!(Rc::ptr_eq(&first, &again));
        assert!(!Rc::ptr_eq(&first, &other) && other.1 == 2);
        assert!(Rc::ptr_eq(&first.0, &other.0), "one device");
    }
}
