// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pixels of shadows that a driver is known to lose: expected failures, typed by driver, case and size.

use crate::drawing::DeviceDrawn;
use crate::job::Job;
use crate::views::Eyes;
use crate::way::DeviceWay;
use terrafill_contract::Devices;
use terrafill_results::Status;
use terrafill_shadow_views::{Interface, Light};
use terrafill_study::{Driver, DriverFault, Failure, LOSES_SLIVERS};
use terrafill_variant::FacePasses;

/// What a driver loses.
#[derive(Debug, Clone, Copy)]
pub(super) struct LostPixels {
    fault: DriverFault,
    sun: [f64; 2],
    eyes: Eyes,
    is_hit: fn(DeviceWay) -> bool,
    /// Of each channel.
    size: [u32; 2],
    /// Channel, column and row, from the upper left corner.
    pixels: &'static [(usize, [u32; 2])],
}

/// Every expectation.
///
/// Channel 3, pixel (77, 280), on open sea: a dark cap has corners in one line, so that two of its triangles
/// are 47 px long and no 1e-6 px wide. The pixel's centre lies 0.001 px beside them, as the test below computes, and in
/// the side that they share an edge with.
const KNOWN: [LostPixels; 1] = [LostPixels {
    fault: LOSES_SLIVERS,
    sun: [60.0, 90.0],
    eyes: Eyes::Bridge,
    is_hit: draws_each_face_alone,
    size: [512, 384],
    pixels: &[(3, [77, 280])],
}];

fn draws_each_face_alone(way: DeviceWay) -> bool {
    let faces = FacePasses::TwoPass;
    way == DeviceWay {
        faces,
        ..DeviceWay::plain(Interface::Wgpu)
    }
}

impl LostPixels {
    /// The expectation of a case, if there is one.
    pub(super) fn of(driver: Driver<'_>, job: Job, size: [u32; 2]) -> Option<&'static Self> {
        let Job::Device(sun, eyes, way) = job else {
            return None;
        };
        KNOWN.iter().find(|own| {
            own.fault.is_of(driver)
                && (own.sun, own.eyes, own.size) == (sun, eyes, size)
                && (own.is_hit)(way)
        })
    }

    /// The same on the devices of a run.
    pub(super) fn on(
        devices: &Devices,
        job: Job,
        size: [u32; 2],
    ) -> Result<Option<&'static Self>, Failure> {
        // None is of another interface.
        if !matches!(job, Job::Device(.., way) if way.interface == Interface::Wgpu) {
            return Ok(None);
        }
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        let driver = Driver {
            name: &gpu.facts.name,
            info: &gpu.facts.driver_info,
        };
        Ok(Self::of(driver, job, size))
    }

    /// The picture with the reference's light in the known pixels, and how many of them differed.
    ///
    /// - `light`: of a channel's pixels, by the reference
    pub(super) fn mended<'l>(
        &self,
        light: impl Fn(usize) -> &'l [Light],
        drawn: &DeviceDrawn,
    ) -> (DeviceDrawn, usize) {
        let mut mended = DeviceDrawn {
            masks: drawn.masks.clone(),
            volume: drawn.volume.clone(),
            ..DeviceDrawn::default()
        };
        let mut differing = 0;
        for (channel, [column, row]) in self.pixels {
            let at = *row as usize * self.size[0] as usize + *column as usize;
            let is_dark = light(*channel)[at] == Light::Shadow;
            differing += usize::from(mended.masks[*channel][at] != is_dark);
            mended.masks[*channel][at] = is_dark;
        }
        (mended, differing)
    }

    /// How a case with this expectation ends, and why: as [`DriverFault::settle`].
    pub(super) fn settle(
        &self,
        objections: &str,
        excused: &str,
        differing: usize,
    ) -> (Status, String) {
        let known = self.pixels.len();
        self.fault.settle(objections, excused, differing, known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::views::Place;
    use crate::work::{End, Scene};
    use glam::DVec4;
    use terrafill_fixtures::distance_and_width;
    use terrafill_shadow_views::{DeckCamera, bridge};

    /// Column and row, pixels; `None` before the near plane.
    fn projected(view: &DeckCamera, place: DVec4) -> Option<[f64; 2]> {
        let along = place.truncate() - view.eye * place.w;
        let ahead = along.dot(view.forward);
        (ahead > view.near * place.w).then(|| {
            let [width, height] = view.size.map(f64::from);
            let across = along.dot(view.right) / (ahead * view.tan[0]);
            let up = along.dot(view.up) / (ahead * view.tan[1]);
            [(1.0 + across) / 2.0 * width, (1.0 - up) / 2.0 * height]
        })
    }

    /// Distance from the pixel's centre and width of thin triangles that rounding may take over it, pixels.
    fn slivers([column, row]: [u32; 2]) -> Vec<[f64; 2]> {
        let fault = &KNOWN[0];
        let (channel, _) = fault.pixels[0];
        let view = bridge(fault.size)[channel];
        let scene = Scene::of_port(fault.sun, vec![view]).expect("a port");
        let volume = scene.volume(End::Sea).expect("above");
        let centre = [column, row].map(|at| f64::from(at) + 0.5);
        let all = volume.triangles.iter().filter_map(|triangle| {
            let places = triangle.corners.map(|at| volume.vertices[at as usize]);
            let [a, b, c] = places.map(|place| projected(&view, place));
            Some(distance_and_width(centre, [a?, b?, c?]))
        });
        let thin = all.filter(|[away, width]| *away < 1.0 / 256.0 && *width < 1.0 / 128.0);
        thin.collect()
    }

    #[test]
    fn rounding_takes_two_slivers_over_the_known_pixel() {
        let [column, row] = KNOWN[0].pixels[0].1;
        let found = slivers([column, row]);
        assert_eq!(found.len(), 2, "{found:?}");
        for [away, width] in found {
            assert!(
                away > 0.0 && away < 0.0011 && width < 1e-6,
                "{away} {width}"
            );
        }
        // Negative controls: the pixels beside it.
        assert_eq!(slivers([column + 1, row]), Vec::<[f64; 2]>::new());
        assert_eq!(slivers([column, row + 1]), Vec::<[f64; 2]>::new());
    }

    const THIS: Driver<'_> = Driver {
        name: "llvmpipe (LLVM 15.0.6, 256 bits)",
        info: "Mesa 25.0.7-2 (LLVM 15.0.6)",
    };

    #[test]
    fn an_expectation_is_of_one_way_sun_eye_and_size() {
        let plain = DeviceWay::plain(Interface::Wgpu);
        let faces = FacePasses::TwoPass;
        let own = DeviceWay { faces, ..plain };
        let (sun, size) = (KNOWN[0].sun, KNOWN[0].size);
        let of = |job, size| LostPixels::of(THIS, job, size).is_some();
        assert!(of(Job::Device(sun, Eyes::Bridge, own), size));
        // Negative controls.
        assert!(!of(Job::Device(sun, Eyes::Bridge, plain), size));
        assert!(!of(Job::Device([10.0, 90.0], Eyes::Bridge, own), size));
        assert!(!of(Job::Device(sun, Eyes::At(Place::Aerial), own), size));
        assert!(!of(Job::Device(sun, Eyes::Bridge, own), [128, 96]));
        assert!(!of(Job::Near(sun, own), size));
    }

    #[test]
    fn the_known_pixel_is_mended_and_no_other() {
        let fault = &KNOWN[0];
        let (channel, [column, row]) = fault.pixels[0];
        let at = row as usize * fault.size[0] as usize + column as usize;
        let mut light = vec![Light::Lit; fault.size[0] as usize * fault.size[1] as usize];
        light[at] = Light::Shadow;
        let drawn = |wrong: &[usize]| {
            let mut own: Vec<bool> = light.iter().map(|light| *light == Light::Shadow).collect();
            for at in wrong {
                own[*at] = !own[*at];
            }
            DeviceDrawn {
                masks: vec![own; channel + 1],
                ..DeviceDrawn::default()
            }
        };
        let mended = |wrong: &[usize]| {
            let (mended, differing) = fault.mended(|_| &light, &drawn(wrong));
            let [own, right] = [&mended, &drawn(&[])].map(|own| own.masks[channel].clone());
            let left = own.iter().zip(right).filter(|(own, right)| **own != *right);
            (differing, left.count())
        };
        assert_eq!(mended(&[at]), (1, 0));
        // Negative controls: a second pixel, another one instead, and none at all.
        assert_eq!(mended(&[at, 7]), (1, 1));
        assert_eq!(mended(&[7]), (0, 1));
        assert_eq!(mended(&[]), (0, 0));
    }
}
