// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: five views and a flight, with and without level 2, by every test and place.

use super::culls::{Culls, Kept, Sent, Shown};
use super::ground::{Ground, PATCH_TRIANGLES};
use super::needed::{Missed, missed, needed};
use super::on_vulkan::{OnVulkan, VulkanGround};
use super::on_wgpu::{OnWgpu, WgpuGround};
use super::way::{CullStage, CullWay, FLIGHT_S, Test, VIEWS, ViewKind, flight};
use crate::STUDY;
use crate::images::{of_numbers, size_px, write};
use crate::metrics::{self, API, EXPERIMENT, PLACE, TEST, VIEW};
use crate::way::Interface;
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_contract::{DeviceError, ids_of};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::GridCamera;
use terrafill_shapes::rays::{Judged, Rays};
use terrafill_study::{CaseGroup, Context, Failure, Figures, Session, planned_case, verified};

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
    cases: Vec<CullCase>,
}

/// The five views, the flight, and the five views whose patches are counted, at the published size unless it is
/// quick.
pub(crate) fn groups(is_quick: bool, sizes: (ImageSize, u32)) -> Vec<CaseGroup<Culling>> {
    let (tile_cells, counted, step) = if is_quick {
        (QUICK_TILE_CELLS, QUICK_TILE_CELLS, QUICK_FLIGHT_STEP_S)
    } else {
        (TILE_CELLS, COUNTED_TILE_CELLS, FLIGHT_STEP_S)
    };
    let views = VIEWS.map(|view| (view, 0));
    let flown = (1..=FLIGHT_S).step_by(step);
    let flown: Vec<(ViewKind, u32)> = flown.map(|second| (flight(second), second)).collect();
    let timed = seen(&views, |way| !is_quick || way.is_main());
    let flown = seen(&flown, CullWay::is_of_flight);
    let counted_ways = seen(&views, CullWay::is_counted);
    vec![
        group("culling", tile_cells, timed, sizes),
        group("culling-flight", tile_cells, flown, sizes),
        group("culling-count", counted, counted_ways, (sizes.0, 0)),
    ]
}

/// Every view, each with its second, by the ways that are asked for.
fn seen(views: &[(ViewKind, u32)], is_asked: impl Fn(&CullWay) -> bool) -> Vec<CullCase> {
    let ways: Vec<CullWay> = CullWay::all().into_iter().filter(is_asked).collect();
    let of = |&(view, second): &(ViewKind, u32)| {
        let case = move |way| CullCase { way, view, second };
        ways.iter().copied().map(case)
    };
    views.iter().flat_map(of).collect()
}

fn group(
    experiment: &'static str,
    tile_cells: u32,
    cases: Vec<CullCase>,
    (size, samples): (ImageSize, u32),
) -> CaseGroup<Culling> {
    let case = |case: &CullCase| {
        let place = match experiment {
            "culling-flight" => (metrics::FLIGHT_S, case.second.to_string()),
            _ => (VIEW, case.view.name.to_owned()),
        };
        let conditions = vec![
            (EXPERIMENT, experiment.to_owned()),
            (API, case.way.interface.name().to_owned()),
            (PLACE, case.way.place.name().to_owned()),
            (TEST, case.way.test.name()),
            place,
            (metrics::TILE_CELLS, tile_cells.to_string()),
        ];
        let mut planned = planned_case(STUDY, samples, conditions, Some(size_px(size)));
        // The case measures what the published test loses.
        planned.may_be_wrong = matches!(case.way.test, Test::Point(_));
        planned
    };
    CaseGroup {
        name: format!("{STUDY}/{experiment}/{tile_cells}"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: Culling {
            experiment,
            tile_cells,
            size,
            cases,
        },
        open: |group, context| {
            Ok(Box::new(CullSession {
                group,
                context,
                ground: Rc::new(Ground::new(group.work.tile_cells)),
                vulkan: None,
                wgpu: None,
                views: BTreeMap::new(),
                opened: BTreeMap::new(),
            }))
        },
    }
}

/// What the reference says of a view, and what the first way of each interface showed of it.
struct Truth {
    view: GridCamera,
    needed: Vec<bool>,
    /// Of tiles alone.
    sent: Sent,
    /// Number of a pixel and of the triangle that its ray meets.
    met: Vec<(usize, u32)>,
    first: BTreeMap<Interface, Vec<u32>>,
}

struct CullSession<'a> {
    group: &'a CaseGroup<Culling>,
    context: Context<'a>,
    ground: Rc<Ground>,
    vulkan: Option<Rc<VulkanGround>>,
    wgpu: Option<Rc<WgpuGround>>,
    /// By name and second.
    views: BTreeMap<(&'static str, u32), Truth>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn Culls>>,
}

fn rays<'a>(ground: &'a Ground, view: &GridCamera, size: ImageSize) -> Rays<'a> {
    Rays::new(&ground.grid, *view, size)
}

impl Truth {
    fn new(ground: &Ground, kind: &ViewKind, size: ImageSize) -> Self {
        let view = ground.view(kind);
        Self {
            needed: needed(&ground.grid, &view),
            sent: Sent::new(ground, &view, CullStage::TilesAlone),
            met: rays(ground, &view, size).picture(RAY_EVERY),
            view,
            first: BTreeMap::new(),
        }
    }

    fn needed(&self) -> usize {
        self.needed.iter().filter(|needed| **needed).count()
    }
}

impl CullSession<'_> {
    fn open(&mut self, way: CullWay, view: &GridCamera) -> Result<Box<dyn Culls>, DeviceError> {
        let devices = self.context.devices;
        Ok(match way.interface {
            Interface::Vulkan => {
                if self.vulkan.is_none() {
                    let gpu = terrafill_vulkan::shared_gpu(devices)?;
                    self.vulkan = Some(Rc::new(VulkanGround::new(&gpu, &self.ground)?));
                }
                let shared = self.vulkan.as_ref().ok_or(DeviceError::Missing("ground"))?;
                Box::new(OnVulkan::new(shared, way, view, self.group.work.size)?)
            }
            Interface::Wgpu => {
                if self.wgpu.is_none() {
                    let gpu = terrafill_gpu::shared_gpu(devices)?;
                    self.wgpu = Some(Rc::new(WgpuGround::new(&gpu, &self.ground)?));
                }
                let shared = self.wgpu.as_ref().ok_or(DeviceError::Missing("ground"))?;
                Box::new(OnWgpu::new(shared, way, view, self.group.work.size)?)
            }
        })
    }

    /// Whether a case's picture is kept: without level 2, or where it is wrong.
    fn is_kept(&self, way: CullWay, wrong: &[bool]) -> bool {
        let is_shown = way.place == CullStage::TilesAlone && way.interface == Interface::Vulkan;
        let is_five = self.group.work.experiment == "culling";
        (is_five && is_shown) || wrong.contains(&true)
    }
}

impl Session for CullSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let CullCase { way, view, second } = self.group.work.cases[case];
        let size = self.group.work.size;
        let key = (view.name, second);
        let ground = Rc::clone(&self.ground);
        let truth = self.views.entry(key);
        let seen = truth
            .or_insert_with(|| Truth::new(&ground, &view, size))
            .view;
        let mut opened = self.open(way, &seen)?;
        let shown = opened.draw()?;
        let planned = &self.group.cases[case];
        if planned.samples > 0 {
            self.opened.insert(case, opened);
        }
        let numbers = ids_of(&shown.picture);
        let Some(truth) = self.views.get_mut(&key) else {
            return Err(Failure::Broken("its view is gone".to_owned()));
        };
        let judged = rays(&ground, &seen, size).judge_triangles(&numbers, &truth.met);
        let first = truth.first.entry(way.interface);
        let first = first.or_insert_with(|| numbers.clone());
        let differs = numbers.iter().zip(&*first).map(|(a, b)| a != b);
        let wrong: Vec<bool> = differs.collect();
        let found = CullOutcome {
            differing: wrong.iter().filter(|differs| **differs).count(),
            judged,
            shown,
        };
        let (reason, figures) = found.against(truth);
        // What differs from the first way's picture is red.
        let notes = if self.is_kept(way, &wrong) {
            let pixels = of_numbers(&numbers, Some(ground.grid.cells), &wrong);
            write(self.context.folder, &planned.id.name, size, pixels)?
        } else {
            Vec::new()
        };
        Ok(terrafill_study::judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(verified(&mut self.opened, case)?.time()?.figures())
    }
}

/// What a case showed beside what it should.
struct CullOutcome {
    shown: Shown,
    judged: Judged,
    /// Pixels that differ from the first way's.
    differing: usize,
}

impl CullOutcome {
    /// Why it is wrong, if it is, and its figures.
    fn against(&self, truth: &Truth) -> (String, Figures) {
        let (needed, kept) = (truth.needed(), self.shown.kept.count());
        let mut figures = vec![
            ("cull_tiles", truth.sent.tiles.len() as f64),
            ("cull_in_tiles", f64::from(truth.sent.in_tiles)),
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
                Some(Missed { lost, extra }) => {
                    let extra_share = extra as f64 / needed.max(1) as f64;
                    figures.extend([
                        ("cull_lost", lost as f64),
                        ("cull_extra_share", extra_share),
                    ]);
                    if lost > 0 {
                        reasons.push(format!("{lost} of {needed} patches in view are lost"));
                    }
                }
                None => {
                    reasons.push("its list has a patch twice or none of the ground's".to_owned());
                }
            }
        } else if kept < needed as u64 {
            reasons.push(format!("{kept} patches are kept, {needed} are needed"));
        }
        for (pixels, wrong) in [
            (
                self.judged.mismatched,
                "show what the reference does not allow",
            ),
            (self.differing, "differ from those without level 2"),
        ] {
            reasons.extend((pixels > 0).then(|| format!("{pixels} pixels {wrong}")));
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
    use crate::tested::Tested;
    use terrafill_contract::Picture;
    use terrafill_results::Status;

    #[test]
    fn every_exact_way_shows_the_same_and_the_point_test_is_wrong() {
        let Some(tested) = Tested::open() else {
            return;
        };
        // One in which little, and one in which much is behind the eye.
        let cases = seen(&[(VIEWS[0], 0), (VIEWS[3], 0)], |_| true);
        let group = group("culling", 32, cases, (PICTURE, 1));
        let (mut right, mut wrong) = (0, 0);
        for (at, verdict) in tested.verdicts(&group) {
            let (name, case) = (&group.cases[at].id.name, &group.work.cases[at]);
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
                status => panic!("{name}: {status:?} {}", verdict.reason),
            }
        }
        // wgpu has 3 exact ways, Vulkan 4 without task shaders.
        assert!(right >= 2 * 7, "{right}");
        // Negative control: at a range of 1 a point outside of the view loses its patch in every view.
        assert!(wrong >= 4, "{wrong}");
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
        let found = |kept: &[u32], differing| CullOutcome {
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
