// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: views and a flight, with and without level 2, by every test and place.

use super::culls::{Culls, Kept, Sent, Shown};
use super::ground::{Ground, PATCH_TRIANGLES};
use super::needed::{Missed, missed, needed};
use super::on_vulkan::{OnVulkan, VulkanGround};
use super::on_wgpu::{OnWgpu, WgpuGround};
use super::way::{CullStage, CullWay, FLIGHT_S, Test, VIEWS, ViewKind, flight};
use crate::STUDY;
use crate::draws::shown_hash;
use crate::images::{of_numbers, size_px, write};
use crate::metrics::{self, API, EXPERIMENT, PLACE, TEST, VIEW};
use crate::way::Interface;
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_contract::{DeviceError, ids_of, numbers_hash};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::GridCamera;
use terrafill_shapes::rays::{Judged, Rays};
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, planned_case, verified,
};

/// Cells a side of a tile: as published, and fewer in a quick run.
const TILE_CELLS: u32 = 256;
const QUICK_TILE_CELLS: u32 = 64;
/// Seconds between places of the flight.
const FLIGHT_STEP_S: usize = 6;
/// Every such pixel of a picture is held against a ray; the others are those of the picture without level 2.
const RAY_EVERY: usize = 61;
/// Rays decide on so many pixels that differ from the picture without level 2. A stage that sends corners in another
/// order may round a border the other way; whole patches that are lost are no such border.
const MAX_ROUNDED_PX: usize = 1_024;

#[derive(Debug, Clone, Copy)]
struct CullCase {
    way: CullWay,
    view: ViewKind,
    /// Of the flight; 0 for a view.
    second: u32,
}

impl CullCase {
    /// Every way from one place.
    fn all(view: ViewKind, second: u32) -> impl Iterator<Item = Self> {
        let ways = CullWay::all().into_iter();
        ways.map(move |way| Self { way, view, second })
    }
}

/// Cases on the same ground.
pub(crate) struct Culling {
    tile_cells: u32,
    size: ImageSize,
    cases: Vec<CullCase>,
}

/// The views and the flight, at the published size unless it is quick.
pub(crate) fn group(is_quick: bool, sizes: (ImageSize, u32)) -> CaseGroup<Culling> {
    let views = VIEWS.into_iter().flat_map(|view| CullCase::all(view, 0));
    let flown = (1..=FLIGHT_S).step_by(FLIGHT_STEP_S);
    let flown = flown.flat_map(|second| CullCase::all(flight(second), second));
    let flown = flown.filter(|case| case.way.is_of_flight());
    let tile_cells = if is_quick {
        QUICK_TILE_CELLS
    } else {
        TILE_CELLS
    };
    of_cases(tile_cells, views.chain(flown).collect(), sizes)
}

fn of_cases(
    tile_cells: u32,
    cases: Vec<CullCase>,
    (size, samples): (ImageSize, u32),
) -> CaseGroup<Culling> {
    let case = |case: &CullCase| {
        let (experiment, place) = match case.second {
            0 => ("culling", (VIEW, case.view.name.to_owned())),
            second => ("culling-flight", (metrics::FLIGHT_S, second.to_string())),
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
        name: format!("{STUDY}/culling/{tile_cells}"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: Culling {
            tile_cells,
            size,
            cases,
        },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(CullSession {
                group,
                context,
                ground: Rc::new(Ground::new(group.work.tile_cells)),
                vulkan: None,
                wgpu: None,
                views: BTreeMap::new(),
                opened: BTreeMap::new(),
            })))
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
    /// Of each list that was made: by which test, how many patches, and what it misses.
    listed: Vec<(Test, u64, Missed)>,
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
            listed: Vec::new(),
        }
    }

    fn needed(&self) -> usize {
        self.needed.iter().filter(|needed| **needed).count()
    }

    /// What a way misses. `None` where its list is none of the ground's, or where it only says how many it kept and no
    /// list of its test has as many. Of a box, counts alone decide nothing: its steps may round otherwise in a stage. Those
    /// of a point's test are fused, so they are the same bits in every stage, and as many patches are the same ones.
    fn missed(&mut self, test: Test, kept: &Kept) -> Option<Missed> {
        let Kept::List(patches) = kept else {
            if test == Test::Box {
                return None;
            }
            let mut listed = self.listed.iter();
            let same = listed.find(|listed| (listed.0, listed.1) == (test, kept.count()));
            return same.map(|listed| listed.2);
        };
        let found = missed(&self.needed, patches)?;
        self.listed.push((test, kept.count(), found));
        Some(found)
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
}

/// Of each pixel whether it differs from the picture without level 2, and rays do not allow both.
fn differing(rays: &Rays<'_>, numbers: &[u32], first: &[u32]) -> Vec<bool> {
    let mut differs: Vec<bool> = numbers.iter().zip(first).map(|(a, b)| a != b).collect();
    let pixels: Vec<usize> = (0..differs.len()).filter(|at| differs[*at]).collect();
    if pixels.len() <= MAX_ROUNDED_PX {
        for pixel in pixels {
            let met = [(pixel, rays.number(pixel))];
            let is_wrong = |shown| rays.judge_triangles(shown, &met).mismatched > 0;
            differs[pixel] = is_wrong(numbers) || is_wrong(first);
        }
    }
    differs
}

/// Whether a case's picture is kept: a view's without level 2, or where it is wrong.
fn is_kept(case: &CullCase, wrong: &[bool]) -> bool {
    let (place, interface) = (case.way.place, case.way.interface);
    let is_shown = place == CullStage::TilesAlone && interface == Interface::Vulkan;
    (case.second == 0 && is_shown) || wrong.contains(&true)
}

impl Shows for CullSession<'_> {
    type Shown = (Vec<u32>, Shown);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let CullCase { way, view, .. } = self.group.work.cases[case];
        let mut opened = self.open(way, &self.ground.view(&view))?;
        let shown = opened.draw()?;
        self.opened.insert(case, opened);
        let numbers = ids_of(&shown.picture);
        let hash = match &shown.kept {
            // Compute appends to its list in whatever order.
            Kept::List(patches) => {
                let mut patches = patches.clone();
                patches.sort_unstable();
                numbers_hash(&patches)
            }
            Kept::Count(count) => count.to_string(),
        };
        let hash = format!("{}-{hash}", shown_hash(&numbers, &shown.counted));
        Ok((hash, (numbers, shown)))
    }

    fn judge(&mut self, case: usize, (numbers, shown): Self::Shown) -> Result<Verdict, Failure> {
        let CullCase { way, view, second } = self.group.work.cases[case];
        let size = self.group.work.size;
        let ground = Rc::clone(&self.ground);
        let truth = self.views.entry((view.name, second));
        let truth = truth.or_insert_with(|| Truth::new(&ground, &view, size));
        let rays = rays(&ground, &truth.view, size);
        let judged = rays.judge_triangles(&numbers, &truth.met);
        let first = truth.first.entry(way.interface);
        let first = first.or_insert_with(|| numbers.clone());
        let wrong = differing(&rays, &numbers, first);
        let found = CullOutcome {
            missed: truth.missed(way.test, &shown.kept),
            differing: wrong.iter().filter(|differs| **differs).count(),
            judged,
            shown,
        };
        let (reason, figures) = found.against(truth);
        // What differs from the first way's picture, and rays do not allow, is red.
        let notes = if is_kept(&self.group.work.cases[case], &wrong) {
            let pixels = of_numbers(&numbers, Some(ground.grid.cells), &wrong);
            write(
                self.context.folder,
                &self.group.cases[case].id.name,
                size,
                pixels,
            )?
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
    missed: Option<Missed>,
    judged: Judged,
    /// Pixels that differ from the first way's, and of which rays do not allow both.
    differing: usize,
}

impl CullOutcome {
    /// Why it is wrong, if it is, and its figures.
    fn against(&self, truth: &Truth) -> (String, Figures) {
        let (needed, kept) = (truth.needed(), self.shown.kept.count());
        let mut figures = vec![
            ("cull_tiles", truth.sent.tiles.len() as f64),
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
        match (self.missed, &self.shown.kept) {
            (Some(Missed { lost, extra }), _) => {
                let extra_share = extra as f64 / needed.max(1) as f64;
                figures.extend([
                    ("cull_lost", lost as f64),
                    ("cull_extra_share", extra_share),
                ]);
                if lost > 0 {
                    reasons.push(format!("{lost} of {needed} patches in view are lost"));
                }
            }
            (None, Kept::List(_)) => {
                reasons.push("its list has a patch twice or none of the ground's".to_owned());
            }
            (None, Kept::Count(_)) if kept < needed as u64 => {
                reasons.push(format!("{kept} patches are kept, {needed} are needed"));
            }
            (None, Kept::Count(_)) => {}
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
        // Where the device counts what is kept by these primitives, only a part of a patch is noticed.
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
    use crate::tested::{Tested, figure};
    use terrafill_contract::Picture;
    use terrafill_results::Status;

    #[test]
    fn every_exact_way_shows_the_same_and_the_point_test_is_wrong() {
        let Some(tested) = Tested::open() else {
            return;
        };
        // One in which little, and one in which much is behind the eye.
        let views = [VIEWS[0], VIEWS[2]].into_iter();
        let cases = views.flat_map(|view| CullCase::all(view, 0)).collect();
        let group = of_cases(64, cases, (PICTURE, 1));
        let (mut right, mut wrong) = (0, 0);
        for (at, verdict) in tested.verdicts(&group) {
            let (name, case) = (&group.cases[at].id.name, &group.work.cases[at]);
            let is_of_point = matches!(case.way.test, Test::Point(_));
            match verdict.status {
                Status::Ok => right += 1,
                Status::Wrong if is_of_point => wrong += 1,
                status => panic!("{name}: {status:?} {}", verdict.reason),
            }
            // Every stage says what a point loses, or the panic says that it does not.
            assert!(!is_of_point || figure(&verdict, "cull_lost") >= 0.0);
        }
        // wgpu has 3 exact ways, Vulkan 5 without task shaders.
        assert!(right >= 2 * 8, "{right}");
        // Negative control: at a range of 1 a point outside of the view loses its patch in every view.
        assert!(wrong >= 2 * 2, "{wrong}");
    }

    #[test]
    fn another_pixel_is_wrong_unless_rays_allow_both() {
        let ground = Ground::new(32);
        let view = ground.view(&VIEWS[0]);
        let rays = rays(&ground, &view, PICTURE);
        let first: Vec<u32> = rays.picture(1).into_iter().map(|(_, met)| met).collect();
        let wrong = |numbers: &[u32]| {
            let differs = differing(&rays, numbers, &first);
            differs.into_iter().filter(|is| *is).count()
        };
        let mut numbers = first.clone();
        assert_eq!(wrong(&numbers), 0);
        // Negative control: a corner of the ground that is behind the eye.
        numbers[0] = 1;
        assert_eq!(wrong(&numbers), 1);
        // Some border passes so near a pixel's middle that either side may show.
        let may_show_its_neighbour = |pixel: &usize| {
            let mut numbers = first.clone();
            numbers[*pixel] = first[pixel - 1];
            numbers != first && wrong(&numbers) == 0
        };
        assert!((1..first.len()).any(|pixel| may_show_its_neighbour(&pixel)));
    }

    #[test]
    fn a_lost_patch_and_another_pixel_are_said() {
        let ground = Ground::new(32);
        let mut truth = Truth::new(&ground, &VIEWS[0], PICTURE);
        let numbers = (0..).zip(&truth.needed).filter(|(_, is)| **is);
        let needed: Vec<u32> = numbers.map(|(at, _)| at).collect();
        let mut said = |kept: Kept, differing| {
            let outcome = CullOutcome {
                missed: truth.missed(Test::Point(1.0), &kept),
                shown: Shown {
                    picture: Picture {
                        size: PICTURE,
                        rgba: Vec::new(),
                        depth: Vec::new(),
                    },
                    kept,
                    counted: Counted::default(),
                    sent_bytes: 0,
                },
                judged: Judged {
                    shown: 1,
                    ..Judged::default()
                },
                differing,
            };
            outcome.against(&truth).0
        };
        let all = needed.len() as u64;
        assert_eq!(said(Kept::Count(all), 0), "");
        assert!(said(Kept::Count(all - 1), 0).contains("are needed"));
        assert_eq!(said(Kept::List(needed.clone()), 0), "");
        assert!(said(Kept::List(needed[1..].to_vec()), 0).contains("1 of "));
        // As many as the list that lost one.
        assert!(said(Kept::Count(all - 1), 0).contains("1 of "));
        assert!(said(Kept::List(vec![0, 0]), 0).contains("twice"));
        assert!(said(Kept::List(needed.clone()), 2).contains("2 pixels differ"));
        // Of boxes as many may be others.
        assert!(truth.missed(Test::Box, &Kept::List(needed)).is_some());
        assert!(truth.missed(Test::Box, &Kept::Count(all)).is_none());
    }
}
