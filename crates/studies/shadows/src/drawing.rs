// SPDX-License-Identifier: MIT OR Apache-2.0
//! The port as devices draw it: sea and casters are a surface, and a stencil program counts the volumes.
//!
//! The origin is laid on the north pole of a sphere, so that ENU axes are the body's. A caster's lit
//! triangles are drawn twice, as surface and as light cap. Both take the same `f32` numbers with the corners
//! in the same order, so that their depths are equal: equal depth fails.

use crate::counted::Counted;
use crate::loading::{Loadable, program};
use crate::tiling::tiled;
use crate::way::{Bounds, Cut, DeviceWay, Silhouettes};
use crate::work::{End, Scene};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use std::cell::LazyCell;
use terrafill_casters::Volume;
use terrafill_contract::{DeviceError, Devices, Frame, FrameTimes, SurfaceView, mask_hash};
use terrafill_scene::ImageSize;
use terrafill_shadow_views::{
    Channel, DeckCamera, Draws, Light, ROUNDING_PX, Reference, Retile, VolumeSource, Wrong,
    constants, count, listed, seen_by, slivers, sum_of,
};
use terrafill_stencil::{StencilWork, VolumeList};
use terrafill_study::Failure;

/// What a device drew, over all channels, before anybody judges it.
#[derive(Default)]
pub(crate) struct DeviceDrawn {
    pub(crate) masks: Vec<Vec<bool>>,
    /// Channels, ready to be timed.
    pub(crate) draws: Vec<Box<dyn Draws>>,
    pub(crate) draw_calls: u64,
    /// Of a channel, the largest: as of [`Channel`].
    pub(crate) bytes: [u64; 2],
    pub(crate) build_ms: Option<f64>,
    /// Casters times channels that were not drawn.
    pub(crate) left_out: usize,
    /// Of which triangles may be too thin for a device; none where no volumes are drawn.
    pub(crate) volume: Option<Volume>,
}

/// What the reference says of it.
#[derive(Debug, Default)]
pub(crate) struct JudgedDrawn {
    pub(crate) wrong: Wrong,
    /// Channel and pixel of the first of these outside the band that no rounding excuses.
    pub(crate) first_wrong: Option<(usize, usize)>,
    /// Shadow pixels of the reference that are lit, in the band too.
    pub(crate) lost: usize,
    /// Of volumes; `None` where the device does not count them.
    pub(crate) fragments: Option<u64>,
    /// Why a device's count of fragments cannot be right; empty where it can.
    pub(crate) miscounted: String,
    /// Of all channels' masks, the sky left out.
    pub(crate) mask_hash: String,
}

impl JudgedDrawn {
    /// Where the first wrong pixel is; empty where there is none.
    pub(crate) fn place(&self, views: &[DeckCamera]) -> String {
        let told = self.first_wrong.map(|(channel, at)| {
            let [column, row] = views[channel].pixel(at);
            format!("; the first in channel {channel}, column {column}, row {row}")
        });
        told.unwrap_or_default()
    }
}

impl DeviceDrawn {
    /// Of all that it shows, sky and all.
    pub(crate) fn hash(&self) -> String {
        mask_hash_of(&self.masks.concat())
    }
}

impl Scene {
    /// Draws every channel by a device.
    pub(crate) fn drawn_by(
        &self,
        devices: &Devices,
        way: DeviceWay,
    ) -> Result<DeviceDrawn, Failure> {
        let volume = match way.silhouettes {
            Silhouettes::EachTriangle => self.volume_of_each_triangle(way.end),
            _ => self.volume(way.end),
        }?;
        // A rectangle holds the volume closed at the sea, wherever the one that is drawn ends.
        let closed = match way.cut {
            Cut::Off | Cut::SeaLevel => None,
            Cut::Culled | Cut::Rectangle => Some(self.volume(End::Sea)?),
        };
        let found = self.found_by(way)?;
        let drawn = self.draw_channels(|view, reference| {
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
        })?;
        Ok(DeviceDrawn {
            volume: Some(volume),
            ..drawn
        })
    }

    /// Draws every channel.
    pub(crate) fn draw_channels(
        &self,
        open: impl Fn(&DeckCamera, &Reference<'_>) -> Result<Channel, Failure>,
    ) -> Result<DeviceDrawn, Failure> {
        let reference = Reference::new(self.mesh(), self.to_light);
        let mut drawn = DeviceDrawn::default();
        for view in &self.views {
            let mut channel = open(view, &reference)?;
            let (counters, mask) = channel.draws.draw()?;
            drawn.bytes = [0, 1].map(|at| drawn.bytes[at].max(channel.bytes[at]));
            drawn.left_out += channel.left_out;
            drawn.draw_calls += counters.draws;
            // The same tree for every channel.
            drawn.build_ms = channel.build_ms;
            drawn.draws.push(channel.draws);
            drawn.masks.push(mask);
        }
        Ok(drawn)
    }

    /// Compares what was drawn with the reference.
    ///
    /// - `channels`: that drew it, which count fragments
    /// - `counted`: where pixels are judged
    pub(crate) fn compared(
        &self,
        drawn: &DeviceDrawn,
        channels: &mut [Box<dyn Draws>],
        counted: Counted,
    ) -> Result<JudgedDrawn, Failure> {
        let reference = Reference::new(self.mesh(), self.to_light);
        let mut judged = JudgedDrawn {
            fragments: Some(0),
            ..JudgedDrawn::default()
        };
        let mut all = Vec::new();
        let channels = self.channels().zip(drawn.masks.iter().zip(channels));
        for (channel, ((view, truth), (mask, draws))) in channels.enumerate() {
            let slivers = LazyCell::new(|| {
                let volume = drawn.volume.as_ref();
                volume.map(|own| slivers(view, own, ROUNDING_PX))
            });
            let own = counted.taken(mask, truth);
            let asked = Wrong::outside_band(&own, truth);
            let is_rounding = |&(at, light): &(usize, Light)| {
                self.is_within_rounding(&reference, view, at, light)
            };
            let excused: Vec<bool> = asked.par_iter().map(is_rounding).collect();
            let mut excused = excused.into_iter();
            let is_rim = |at: usize, _| {
                // Every triangle of the volume is looked at for slivers, so last.
                let is_rim = excused.next() == Some(true)
                    || slivers.as_ref().is_some_and(|slivers| slivers[at]);
                if !is_rim {
                    judged.first_wrong.get_or_insert((channel, at));
                }
                is_rim
            };
            let wrong = Wrong::but_at_rims(&own, truth, is_rim);
            judged.wrong = judged.wrong.plus(wrong);
            judged.lost += truth.lost(&own);
            let dark = mask.iter().filter(|dark| **dark).count();
            let counted = plausible(draws.fragments()?, dark).unwrap_or_else(|miscounted| {
                judged.miscounted = miscounted;
                None
            });
            judged.fragments = judged
                .fragments
                .zip(counted)
                .map(|(before, own)| before + own);
            // What is sky has no shadow, whatever the count there.
            let pixels = mask.iter().zip(&truth.light);
            all.extend(pixels.map(|(dark, light)| *dark && *light != Light::Sky));
        }
        judged.mask_hash = mask_hash_of(&all);
        Ok(judged)
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

/// Times of all channels, one after the other.
pub(crate) fn times_of(channels: &mut [Box<dyn Draws>]) -> Result<FrameTimes, Failure> {
    let mut sum: Option<FrameTimes> = None;
    for draws in channels {
        let times = draws.time()?;
        sum = Some(sum.map_or(times, |sum| sum_of(&sum, &times)));
    }
    sum.ok_or_else(|| "no channel".to_owned().into())
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

/// Of pixels in shadow, row by row.
pub(crate) fn mask_hash_of(mask: &[bool]) -> String {
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
