// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: five views and a flight, with and without level 2, by every test and place.

use super::culls::{Culls, Kept, Shown};
use super::frustum::Frustum;
use super::ground::{Ground, PATCH_TRIANGLES};
use super::needed::{missed, needed};
use super::on_vulkan::{OnVulkan, VulkanGround};
use super::on_wgpu::{OnWgpu, WgpuGround};
use super::way::{CullWay, FLIGHT_S, Place, Test, VIEWS, ViewKind, flight};
use crate::STUDY;
use crate::draws::verdict_of;
use crate::grid::View;
use crate::images::{size_px, write};
use crate::keys;
use crate::keys::{API, EXPERIMENT, PLACE, TEST, VIEW};
use crate::rays::{Cut, Judged, Rays};
use crate::way::Interface;
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_fill::{DeviceError, ids_of};
use terrafill_results::{CaseId, PlannedCase, Status, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{Context, Group, Session, StudyError};

/// Cells a side of a tile: the published 256, whose lists are counted and whose frames are not timed, and a quarter of
/// it for frames; a quick run has small tiles.
const COUNTED_TILE_CELLS: u32 = 256;
const TILE_CELLS: u32 = 64;
const QUICK_TILE_CELLS: u32 = 32;
/// Seconds between places of the flight.
const FLIGHT_STEP_S: usize = 2;
const QUICK_FLIGHT_STEP_S: usize = 12;
/// Every such pixel of a picture is held against a ray; the others are those of the picture without level 2.
const RAY_EVERY: usize = 61;

#[derive(Debug, Clone, Copy)]
struct CullCase {
    way: CullWay,
    view: ViewKind,
    /// Of the flight.
    second: u32,
}

/// Cases on the same ground.
pub(crate) struct Culling {
    experiment: &'static str,
    tile_cells: u32,
    size: ImageSize,
    planned: Vec<PlannedCase>,
    cases: Vec<CullCase>,
}

impl Culling {
    /// The five views, the flight, and the five views whose patches are counted, at the published size unless it is
    /// quick.
    pub(crate) fn all(is_quick: bool, sizes: (ImageSize, u32)) -> Vec<Self> {
        let views = |ways: &[CullWay]| -> Vec<CullCase> {
            let of = |view| {
                ways.iter().map(move |&way| CullCase {
                    way,
                    view,
                    second: 0,
                })
            };
            VIEWS.into_iter().flat_map(of).collect()
        };
        let (tile_cells, step, ways) = match is_quick {
            true => (QUICK_TILE_CELLS, QUICK_FLIGHT_STEP_S, CullWay::few()),
            false => (TILE_CELLS, FLIGHT_STEP_S, CullWay::all()),
        };
        let flown = (1..=FLIGHT_S).step_by(step);
        let flown = flown.flat_map(|second| {
            CullWay::of_flight().into_iter().map(move |way| CullCase {
                way,
                view: flight(second),
                second,
            })
        });
        let counted = if is_quick {
            QUICK_TILE_CELLS
        } else {
            COUNTED_TILE_CELLS
        };
        let counted_ways = views(&CullWay::counted());
        vec![
            Self::new("culling", tile_cells, views(&ways), sizes),
            Self::new("culling-flight", tile_cells, flown.collect(), sizes),
            Self::new("culling-count", counted, counted_ways, (sizes.0, 0)),
        ]
    }

    fn new(
        experiment: &'static str,
        tile_cells: u32,
        cases: Vec<CullCase>,
        (size, samples): (ImageSize, u32),
    ) -> Self {
        let planned = |case: &CullCase| {
            let place = match experiment {
                "culling-flight" => (keys::FLIGHT_S, case.second.to_string()),
                _ => (VIEW, case.view.name.to_owned()),
            };
            let conditions = [
                (EXPERIMENT, experiment.to_owned()),
                (API, case.way.interface.name().to_owned()),
                (PLACE, case.way.place.name().to_owned()),
                (TEST, case.way.test.name()),
                place,
                (keys::TILE_CELLS, tile_cells.to_string()),
            ];
            let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    values.join("/"),
                    [&conditions[..], &[size_px(size)]].concat(),
                ),
                samples,
                // What the published test loses is what is asked of it.
                may_be_wrong: matches!(case.way.test, Test::Point(_)),
            }
        };
        Self {
            experiment,
            tile_cells,
            size,
            planned: cases.iter().map(planned).collect(),
            cases,
        }
    }
}

impl Group for Culling {
    fn name(&self) -> String {
        format!("{STUDY}/{}/{}", self.experiment, self.tile_cells)
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.planned
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        Ok(Box::new(CullSession {
            group: self,
            context,
            ground: Rc::new(Ground::new(self.tile_cells)),
            vulkan: None,
            wgpu: None,
            views: BTreeMap::new(),
            opened: BTreeMap::new(),
        }))
    }
}

/// What the reference says of a view, and what the first way of each interface showed of it.
struct Truth {
    view: View,
    needed: Vec<bool>,
    in_tiles: u32,
    tiles: usize,
    /// Number of a pixel and of the triangle that its ray meets.
    met: Vec<(usize, u32)>,
    first: BTreeMap<Interface, Vec<u32>>,
}

struct CullSession<'a> {
    group: &'a Culling,
    context: Context<'a>,
    ground: Rc<Ground>,
    vulkan: Option<Rc<VulkanGround>>,
    wgpu: Option<Rc<WgpuGround>>,
    /// By name and second.
    views: BTreeMap<(&'static str, u32), Truth>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn Culls>>,
}

fn rays<'a>(ground: &'a Ground, view: &View, size: ImageSize) -> Rays<'a> {
    let size = [size.width, size.height];
    Rays::new(&ground.grid, *view, size, Cut::Published)
}

impl Truth {
    fn new(ground: &Ground, kind: &ViewKind, size: ImageSize) -> Self {
        let view = ground.view(kind.share, kind.above_m, kind.angles_deg);
        let tiles = Frustum::new(&view).tiles(ground).len();
        #[allow(clippy::cast_possible_truncation, reason = "there are 256 tiles")]
        let in_tiles = tiles as u32 * ground.patches_a_tile();
        Self {
            needed: needed(&ground.grid, &view),
            in_tiles,
            tiles,
            met: rays(ground, &view, size).picture_every(RAY_EVERY),
            view,
            first: BTreeMap::new(),
        }
    }

    fn needed(&self) -> usize {
        self.needed.iter().filter(|needed| **needed).count()
    }
}

impl CullSession<'_> {
    fn open(&mut self, way: CullWay, view: &View) -> Result<Box<dyn Culls>, DeviceError> {
        let devices = self.context.devices;
        Ok(match way.interface {
            Interface::Vulkan => {
                if self.vulkan.is_none() {
                    let gpu = terrafill_vulkan::shared_gpu(devices)?;
                    self.vulkan = Some(Rc::new(VulkanGround::new(&gpu, &self.ground)?));
                }
                let shared = self.vulkan.as_ref().ok_or(DeviceError::Missing("ground"))?;
                Box::new(OnVulkan::new(shared, way, view, self.group.size)?)
            }
            Interface::Wgpu => {
                if self.wgpu.is_none() {
                    let gpu = terrafill_gpu::shared_gpu(devices)?;
                    self.wgpu = Some(Rc::new(WgpuGround::new(&gpu, &self.ground)?));
                }
                let shared = self.wgpu.as_ref().ok_or(DeviceError::Missing("ground"))?;
                Box::new(OnWgpu::new(shared, way, view, self.group.size)?)
            }
        })
    }

    /// Path of a case's picture, where it is kept: without level 2, or where it is wrong. What differs from the first
    /// way's picture is red.
    fn picture(
        &self,
        case: usize,
        numbers: &[u32],
        wrong: &[bool],
    ) -> Result<Option<String>, StudyError> {
        let way = self.group.cases[case].way;
        let is_shown = way.place == Place::TilesAlone && way.interface == Interface::Vulkan;
        let is_five = self.group.experiment == "culling";
        let is_kept = (is_five && is_shown) || wrong.contains(&true);
        if !is_kept {
            return Ok(None);
        }
        let name = &self.group.planned[case].id.name;
        let size = [self.group.size.width, self.group.size.height];
        let cells = self.ground.grid.cells;
        let written = write(
            self.context.folder,
            name,
            size,
            numbers,
            false,
            cells,
            wrong,
        );
        written.map(Some).map_err(|message| StudyError::Broken {
            place: name.clone(),
            message,
        })
    }
}

impl Session for CullSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let CullCase { way, view, second } = self.group.cases[case];
        let key = (view.name, second);
        if !self.views.contains_key(&key) {
            let truth = Truth::new(&self.ground, &view, self.group.size);
            self.views.insert(key, truth);
        }
        let seen = self.views[&key].view;
        let opened = self.open(way, &seen);
        let drawn = opened.and_then(|mut opened| Ok((opened.draw()?, opened)));
        let (shown, opened) = match drawn {
            Ok(drawn) => drawn,
            Err(error) => return Ok(verdict_of(&error)),
        };
        if self.group.planned[case].samples > 0 {
            self.opened.insert(case, opened);
        }
        let numbers = ids_of(&shown.picture);
        let Some(truth) = self.views.get_mut(&key) else {
            return Ok(Verdict::failed("its view is gone".to_owned()));
        };
        let judged = rays(&self.ground, &seen, self.group.size).judge_some(&numbers, &truth.met);
        let first = truth.first.entry(way.interface);
        let first = first.or_insert_with(|| numbers.clone());
        let differs = numbers.iter().zip(&*first).map(|(a, b)| a != b);
        let wrong: Vec<bool> = differs.collect();
        let found = Found {
            differing: wrong.iter().filter(|differs| **differs).count(),
            judged,
            shown,
        };
        let truth = &self.views[&key];
        let (reason, figures) = found.against(truth);
        let picture = self.picture(case, &numbers, &wrong)?;
        Ok(Verdict {
            status: match reason.is_empty() {
                true => Status::Ok,
                false => Status::Wrong,
            },
            reason,
            figures,
            notes: picture.into_iter().map(|path| ("picture", path)).collect(),
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let opened = self.opened.get_mut(&case).ok_or("it was not verified")?;
        let times = opened.time().map_err(|error| error.to_string())?;
        Ok(times.figures())
    }
}

/// What a case showed beside what it should.
struct Found {
    shown: Shown,
    judged: Judged,
    /// Pixels that differ from the first way's.
    differing: usize,
}

impl Found {
    /// Why it is wrong, if it is, and its figures.
    fn against(&self, truth: &Truth) -> (String, Vec<(&'static str, f64)>) {
        let (needed, kept) = (truth.needed(), self.shown.kept.count());
        let mut figures = vec![
            ("cull_tiles", truth.tiles as f64),
            ("cull_in_tiles", f64::from(truth.in_tiles)),
            ("cull_needed", needed as f64),
            ("cull_kept", kept as f64),
            ("pipeline_mismatched_px", self.judged.mismatched as f64),
            ("pipeline_band_px", self.judged.in_band as f64),
            ("pipeline_differing_px", self.differing as f64),
            ("pipeline_shown_px", self.judged.shown as f64),
            ("pipeline_sent_bytes", self.shown.sent_bytes as f64),
        ];
        let counted = &self.shown.counted;
        figures.extend(counted.figures());
        let mut reasons = Vec::new();
        if let Kept::List(patches) = &self.shown.kept {
            match missed(&truth.needed, patches) {
                Some(missed) => {
                    figures.push(("cull_lost", missed.lost as f64));
                    figures.push((
                        "cull_extra_share",
                        missed.extra as f64 / needed.max(1) as f64,
                    ));
                    if missed.lost > 0 {
                        let lost = missed.lost;
                        reasons.push(format!("{lost} of {needed} patches in view are lost"));
                    }
                }
                None => {
                    reasons.push("its list has a patch twice or none of the ground's".to_owned())
                }
            }
        } else if kept < needed as u64 {
            reasons.push(format!("{kept} patches are kept, {needed} are needed"));
        }
        if self.judged.mismatched > 0 {
            let pixels = self.judged.mismatched;
            reasons.push(format!(
                "{pixels} pixels show what the reference does not allow"
            ));
        }
        if self.differing > 0 {
            let pixels = self.differing;
            reasons.push(format!("{pixels} pixels differ from those without level 2"));
        }
        if self.judged.shown == 0 {
            reasons.push("it shows nothing".to_owned());
        }
        let expected = kept * u64::from(PATCH_TRIANGLES);
        if let Some(found) = counted.primitives.filter(|found| *found != expected) {
            reasons.push(format!(
                "{found} primitives reached clipping, expected {expected}"
            ));
        }
        (reasons.join("; "), figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draws::Counted;
    use crate::images::PICTURE;
    use terrafill_fill::{Devices, Picture};

    #[test]
    fn every_exact_way_shows_the_same_and_the_point_test_is_wrong() {
        let devices = Rc::new(Devices::default());
        let has = |opened: Result<(), DeviceError>| terrafill_fill::device_for_test(opened);
        if has(terrafill_gpu::shared_gpu(&devices).map(drop)).is_none()
            || has(terrafill_vulkan::shared_gpu(&devices).map(drop)).is_none()
        {
            return;
        }
        let all = CullWay::all();
        // One in which little, and one in which much is behind the eye.
        let seen = [VIEWS[0], VIEWS[3]];
        let cases = seen.into_iter().flat_map(|view| {
            all.iter().map(move |&way| CullCase {
                way,
                view,
                second: 0,
            })
        });
        let group = Culling::new("culling", 32, cases.collect(), (PICTURE, 1));
        let folder = tempfile::tempdir().expect("a folder");
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        let (mut right, mut wrong) = (0, 0);
        for (at, (planned, case)) in group.planned.iter().zip(&group.cases).enumerate() {
            let verdict = session.verify(at).expect("a verdict");
            let name = &planned.id.name;
            eprintln!(
                "{name}: {:?} {} {:?}",
                verdict.status, verdict.reason, verdict.figures
            );
            match verdict.status {
                Status::Ok => right += 1,
                Status::Wrong => {
                    assert!(
                        matches!(case.way.test, Test::Point(_)),
                        "{name}: {}",
                        verdict.reason
                    );
                    wrong += 1;
                }
                status => assert_eq!(status, Status::Skipped, "{name}: {}", verdict.reason),
            }
        }
        // wgpu has 3 exact ways, Vulkan 4 without task shaders.
        assert!(right >= 2 * 7, "{right}");
        // Twin: at a range of 1 a point outside of the view loses its patch in every view.
        assert!(wrong >= 4, "{wrong}");
        let times = session.sample(1).expect("a time");
        assert!(times.iter().all(|(_, ms)| *ms > 0.0), "{times:?}");
    }

    #[test]
    fn a_lost_patch_and_another_pixel_are_said() {
        let ground = Ground::new(16);
        let mut truth = Truth::new(&ground, &VIEWS[0], PICTURE);
        let kept: Vec<u32> = (0..)
            .zip(&truth.needed)
            .filter(|(_, is)| **is)
            .map(|(at, _)| at)
            .collect();
        let found = |kept: &[u32], differing| Found {
            shown: Shown {
                picture: Picture {
                    size: PICTURE,
                    rgba: Vec::new(),
                    depth: Vec::new(),
                },
                kept: Kept::List(kept.to_vec()),
                counted: Counted::default(),
                sent_bytes: 0,
            },
            judged: Judged {
                shown: 1,
                ..Judged::default()
            },
            differing,
        };
        assert_eq!(found(&kept, 0).against(&truth).0, "");
        assert!(found(&kept[1..], 0).against(&truth).0.contains("1 of "));
        assert!(
            found(&kept, 2)
                .against(&truth)
                .0
                .contains("2 pixels differ")
        );
        truth.needed.fill(true);
        assert!(found(&kept, 0).against(&truth).0.contains("lost"));
    }
}
