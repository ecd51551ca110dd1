// SPDX-License-Identifier: MIT OR Apache-2.0
//! The port as devices draw it: sea and casters are a surface, and a stencil program counts the volumes.
//!
//! The origin is laid on the north pole of a sphere, so that ENU axes are the body's. A caster's lit
//! triangles are drawn twice, as surface and as light cap. Both take the same `f32` numbers with the corners
//! in the same order, so that their depths are equal: equal depth fails.

use crate::loading::{Loadable, program};
use crate::tiling::tiled;
use crate::way::{Bounds, Cut, DeviceWay, Silhouettes};
use crate::work::{End, Scene};
use std::cell::LazyCell;
use terrafill_casters::Volume;
use terrafill_contract::{DeviceError, Devices, Frame, SurfaceView, mask_hash};
use terrafill_scene::ImageSize;
use terrafill_shadow_views::{
    Channel, DeckCamera, Draws, Light, ROUNDING_PX, Reference, Retile, VolumeSource, Wrong,
    constants, count, listed, seen_by, slivers,
};
use terrafill_stencil::{StencilWork, VolumeList};
use terrafill_study::Failure;

/// What a device drew, over all channels.
#[derive(Default)]
pub(crate) struct DeviceDrawn {
    pub(crate) wrong: Wrong,
    /// Shadow pixels of the reference that are lit, in the band too.
    pub(crate) lost: usize,
    pub(crate) draws: u64,
    /// Of volumes; `None` where the device does not count them.
    pub(crate) fragments: Option<u64>,
    /// Why a device's count of fragments cannot be right; empty where it can.
    pub(crate) miscounted: String,
    /// Of a channel, the largest: as of [`Channel`].
    pub(crate) bytes: [u64; 2],
    pub(crate) build_ms: Option<f64>,
    /// Casters times channels that were not drawn.
    pub(crate) left_out: usize,
    pub(crate) volume_triangles: usize,
    /// Of all channels' masks.
    pub(crate) mask_hash: String,
    /// Channels that are kept, ready to be timed, and their masks.
    pub(crate) kept: Vec<(Box<dyn Draws>, Vec<bool>)>,
}

/// Which channels stay open: each holds render targets of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kept {
    /// The one with the most shadow.
    Darkest,
    All,
}

impl Scene {
    /// Draws every channel by a device.
    pub(crate) fn drawn_by(
        &self,
        devices: &Devices,
        way: DeviceWay,
        kept: Kept,
    ) -> Result<DeviceDrawn, Failure> {
        let volume = match way.silhouettes {
            Silhouettes::EachTriangle => self.volume_of_each_triangle(way.end),
            _ => self.volume(way.end),
        }?;
        // A rectangle holds the volume closed at the sea, wherever the one that is drawn ends.
        let closed = match way.cut {
            Cut::Off => None,
            _ => Some(self.volume(End::Sea)?),
        };
        let found = self.found_by(way)?;
        let open = |view: &DeckCamera, reference: &Reference<'_>| -> Result<Channel, Failure> {
            let loadable = match &found {
                None => self.loadable(way, view, &volume, closed.as_ref(), reference)?,
                Some(found) => {
                    let casters = 0..self.mesh().casters.len();
                    Loadable {
                        list: casters.map(|caster| listed(view.whole(), caster)).collect(),
                        source: self.seen_from(view, found, way.positions, &volume),
                        left_out: 0,
                    }
                }
            };
            Ok(Channel {
                bytes: loadable.source.bytes(),
                left_out: loadable.left_out,
                build_ms: None,
                draws: self.open_with(devices, way, view, loadable, true)?,
            })
        };
        let drawn = self.draw_channels(Some(&volume), kept, open)?;
        Ok(DeviceDrawn {
            volume_triangles: volume.triangles.len(),
            ..drawn
        })
    }

    /// Draws every channel and compares it with the reference.
    ///
    /// - `volume`: of which triangles may be too thin for a device
    pub(crate) fn draw_channels(
        &self,
        volume: Option<&Volume>,
        kept: Kept,
        open: impl Fn(&DeckCamera, &Reference<'_>) -> Result<Channel, Failure>,
    ) -> Result<DeviceDrawn, Failure> {
        let darkest = self.darkest_channel()?;
        let reference = Reference::new(self.mesh(), self.to_light);
        let mut drawn = DeviceDrawn {
            fragments: Some(0),
            ..DeviceDrawn::default()
        };
        let mut all = Vec::new();
        for (at, (view, truth)) in self.channels.iter().enumerate() {
            let mut channel = open(view, &reference)?;
            let (counters, mask) = channel.draws.draw()?;
            let slivers = LazyCell::new(|| volume.map(|own| slivers(view, own, ROUNDING_PX)));
            let is_rim = |at: usize, light| {
                let is_sliver = slivers.as_ref().is_some_and(|slivers| slivers[at]);
                is_sliver || self.is_within_rounding(&reference, view, at, light)
            };
            let wrong = Wrong::but_at_rims(&mask, truth, is_rim);
            drawn.wrong = drawn.wrong.plus(wrong);
            drawn.lost += truth.lost(&mask);
            drawn.bytes = [0, 1].map(|at| drawn.bytes[at].max(channel.bytes[at]));
            drawn.left_out += channel.left_out;
            drawn.draws += counters.draws;
            let dark = mask.iter().filter(|dark| **dark).count();
            let counted = plausible(counters.stencil_fragments, dark);
            let counted = counted.unwrap_or_else(|miscounted| {
                drawn.miscounted = miscounted;
                None
            });
            drawn.fragments = drawn
                .fragments
                .zip(counted)
                .map(|(before, own)| before + own);
            // What is sky has no shadow, whatever the count there.
            let pixels = mask.iter().zip(&truth.light);
            all.extend(pixels.map(|(dark, light)| *dark && *light != Light::Sky));
            if at == darkest {
                drawn.build_ms = channel.build_ms;
            }
            if at == darkest || kept == Kept::All {
                drawn.kept.push((channel.draws, mask));
            }
        }
        drawn.mask_hash = hash(&all);
        Ok(drawn)
    }

    /// - `draws_back_faces`: as [`SurfaceView`] has it
    fn open_with(
        &self,
        devices: &Devices,
        way: DeviceWay,
        view: &DeckCamera,
        loadable: Loadable,
        draws_back_faces: bool,
    ) -> Result<Box<dyn Draws>, Failure> {
        let switches = way.switches();
        let Loadable { source, list, .. } = loadable;
        seen_by(way.positions, view, self.mesh(), |seen| {
            let (id, size, camera) = (seen.id, seen.size, *seen.camera);
            let words = match &source {
                VolumeSource::Adjacent(own) => Some(own.clone()),
                _ => None,
            };
            let work = move |list: Vec<terrafill_stencil::Volume>| {
                let constants = constants(&camera, list.len());
                let mut constants = bytemuck::cast_slice(&constants).to_vec();
                if let Some(own) = &words {
                    let words = own.words_behind(constants.len());
                    constants.extend_from_slice(bytemuck::cast_slice(&words));
                }
                Ok::<_, DeviceError>(StencilWork {
                    program: program(way, &switches, &list)?,
                    list: VolumeList::new(id, size, list),
                    constants,
                    blends: false,
                })
            };
            let whole = work(list.clone())?;
            let retile = (way.bounds == Bounds::Tiles).then(|| -> Retile {
                Box::new(move |picture| work(tiled(&list, size, &picture.depth)))
            });
            let seen = SurfaceView {
                draws_back_faces,
                ..seen
            };
            let has_bounds = way.bounds == Bounds::Native;
            let open = (&switches, has_bounds);
            Ok(way
                .interface
                .open(devices, open, seen, source, (whole, retile))?)
        })
    }
}

/// A device's count of the volumes' fragments, unless it is too small to be one: a pixel in shadow takes a fragment.
pub(crate) fn plausible(fragments: Option<u64>, dark: usize) -> Result<Option<u64>, String> {
    match fragments {
        Some(count) if count < dark as u64 => Err(format!(
            "the device's query has {count} fragments of volumes, and {dark} pixels are in shadow, each of which takes one"
        )),
        counted => Ok(counted),
    }
}

fn hash(mask: &[bool]) -> String {
    mask_hash(&Frame {
        size: ImageSize::new(count(mask.len()), 1),
        ids: mask.iter().map(|is_dark| u32::from(*is_dark)).collect(),
        surface: vec![true; mask.len()],
        non_finite: 0,
        counters: None,
        texture: None,
    })
}

#[cfg(test)]
mod tests;
