// SPDX-License-Identifier: MIT OR Apache-2.0
//! A flight frame by frame: each chooses its tiles, takes those that have come, sends them and draws.

use super::files::TileFiles;
use crate::choose::chosen;
use crate::device::{MapScene, MapTargets};
use crate::mesh::{MapMesh, map_mesh};
use crate::options::{Drawing, Options};
use crate::tile_set::{SIDE, address};
use crate::truth::{Tile, Truth, tiles_of, truths, truths_of_every};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};
use terrafill_contract::CpuStopwatch;
use terrafill_globe_views::{Eye, ViewRow};
use terrafill_maps::{Loader, Slots};
use terrafill_scene::Camera;
use terrafill_study::Failure;
use terrafill_surface::{Surface, SurfaceFrame};

/// Frames of a flight in which the eye moves; in those that follow it rests.
pub(crate) const MOVING: usize = 16;
/// Frames that lack nothing, after which a flight ends.
pub(crate) const QUIET: usize = 3;
/// A flight that still lacks tiles after so many frames has failed.
const MOST_FRAMES: usize = 600;
/// Frames begin no sooner after each other, as on a screen of 60 Hz: what a thread reads meanwhile would else depend on
/// how fast a device draws.
const PACE: Duration = Duration::from_nanos(16_666_667);
/// Tiles that the device keeps where they come and go: a frame of either path chooses fewer.
pub(crate) const SLOTS: usize = 40;
/// Of so many pixels along each side one says what a frame wants.
pub(crate) const STEP_PX: u32 = 4;
/// One draw over cells by whose corners tiles are chosen.
pub(crate) const OPTIONS: Options = Options {
    n: 20,
    drawing: Drawing::Slots,
    ..Options::BASE
};

terrafill_results::named! {
    /// What the eye does.
    #[derive(PartialOrd, Ord)]
    all pub(crate) enum Path {
        /// It comes down from 3,000 km to 30 km.
        Descent = "descent",
        /// It moves along the ground and turns by a quarter.
        Turn = "turn",
    }
}

terrafill_results::named! {
    /// When tiles are read.
    pub(crate) enum Loading {
        /// By a thread beside frames, which show what has come.
        Background = "background",
        /// By frames, which wait for what they choose.
        Foreground = "foreground",
        /// All before the first frame.
        AllThere = "all-there",
    }
}

/// How tiles are read on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Flight {
    pub(crate) path: Path,
    pub(crate) loading: Loading,
    /// Tiles that a frame sends at most.
    pub(crate) budget: usize,
    /// Added to reading each tile.
    pub(crate) latency_ms: u32,
}

impl Path {
    /// The eye of a frame. The ground fills each picture.
    fn eye(self, frame: usize, side_px: u32) -> Eye {
        let share = frame as f64 / (MOVING - 1) as f64;
        let (row, heading_deg) = match self {
            Self::Descent => {
                let height_m = 3e6 * (3e4_f64 / 3e6).powf(share);
                (view([15.0, 45.0], height_m, -90.0), 0.0)
            }
            Self::Turn => {
                let along = view([15.0 + 1.2 * share, 45.0], 4e4, -50.0);
                (along, 90.0 * share)
            }
        };
        let mut eye = row.eye(side_px);
        eye.pose.heading_rad = f64::to_radians(heading_deg);
        eye.camera = Camera::new(&eye.body, &eye.pose);
        eye
    }
}

fn view([longitude_deg, latitude_deg]: [f64; 2], height_m: f64, pitch_deg: f64) -> ViewRow {
    ViewRow {
        longitude_deg,
        latitude_deg,
        height_m,
        pitch_deg,
        ..ViewRow::default()
    }
}

/// The coarsest level: with it every pixel shows something.
fn coarsest() -> [Tile; 3] {
    let whole = Tile::Map {
        level: 0,
        row: 0,
        column: 0,
    };
    let [north, south] = [false, true].map(|is_south| Tile::Cap { is_south });
    [whole, north, south]
}

/// What a path shows and chooses, whatever is read when.
pub(crate) struct Course {
    eyes: Vec<Eye>,
    surface: Arc<dyn Surface>,
    /// All that a frame chooses and the coarsest level, sorted; a tile's number is its place in the list.
    pub(crate) tiles: Vec<Tile>,
    /// Of each eye, how many pixels want which tile, of every [`STEP_PX`]th in every [`STEP_PX`]th row.
    wanted: Vec<BTreeMap<Tile, u64>>,
    /// Of the eyes whose pictures were judged, remembered.
    truths: RefCell<BTreeMap<usize, Rc<Vec<Option<Truth>>>>>,
}

impl Course {
    /// # Errors
    /// Of the surface, and of choosing.
    pub(crate) fn new(path: Path, side_px: u32, surface: Arc<dyn Surface>) -> Result<Self, String> {
        let mut course = Self {
            eyes: (0..MOVING).map(|frame| path.eye(frame, side_px)).collect(),
            surface,
            tiles: Vec::new(),
            wanted: Vec::new(),
            truths: RefCell::default(),
        };
        let mut tiles = BTreeSet::from(coarsest());
        for eye in &course.eyes {
            let (frame, mesh) = course.mesh(eye)?;
            tiles.extend(chosen(eye, &mesh)?);
            let mut wanted = BTreeMap::new();
            for truth in truths_of_every(eye, &frame, STEP_PX) {
                *wanted.entry(wanted_tile(&truth)).or_default() += 1;
            }
            course.wanted.push(wanted);
        }
        course.tiles = tiles.into_iter().collect();
        Ok(course)
    }

    /// As a frame makes it.
    fn mesh(&self, eye: &Eye) -> Result<(SurfaceFrame, MapMesh), String> {
        let frame = self.surface.frame(&eye.camera, eye.size);
        let frame = frame.map_err(|error| error.to_string())?;
        let mesh = map_mesh(&eye.body, &eye.camera, &frame, &OPTIONS);
        Ok((frame, mesh))
    }

    pub(crate) fn number(&self, tile: Tile) -> Option<usize> {
        self.tiles.binary_search(&tile).ok()
    }

    /// Of a frame, pixels in rows.
    ///
    /// # Errors
    /// Of the surface.
    pub(crate) fn truths(&self, frame: usize) -> Result<Rc<Vec<Option<Truth>>>, String> {
        let at = frame.min(MOVING - 1);
        if let Some(known) = self.truths.borrow().get(&at) {
            return Ok(Rc::clone(known));
        }
        let (surface, _) = self.mesh(&self.eyes[at])?;
        let truths = Rc::new(truths(&self.eyes[at], &surface));
        self.truths.borrow_mut().insert(at, Rc::clone(&truths));
        Ok(truths)
    }

    /// Of every [`STEP_PX`] pixels, those of a frame that show the surface, and of them those whose tile is not held.
    pub(crate) fn pixels(&self, frame: usize, held: &Slots<Tile>) -> [u64; 2] {
        let wanted = &self.wanted[frame.min(MOVING - 1)];
        let lacking = wanted.iter().filter(|(tile, _)| !held.holds(**tile));
        [
            wanted.values().sum(),
            lacking.map(|(_, pixels)| pixels).sum(),
        ]
    }
}

/// What a pixel's middle wants; of two levels that `f32` may take, the coarser.
pub(crate) fn wanted_tile(truth: &Truth) -> Tile {
    let cap = Tile::Cap {
        is_south: truth.drawn.by_vertex > 0.5,
    };
    let level = truth.levels[0];
    let mut on_map = tiles_of(&truth.drawn, OPTIONS.by_fragment, level..=level);
    match truth.drawn.cap {
        Some(_) => cap,
        None => on_map.next().unwrap_or(cap),
    }
}

/// Texels of a tile that hold their own address.
pub(crate) fn addresses(number: usize) -> Vec<u8> {
    let number = u32::try_from(number).unwrap_or(u32::MAX);
    let texels = (0..SIDE * SIDE).flat_map(|texel| address(number, texel).to_le_bytes());
    texels.collect()
}

/// Targets and slots of what is drawn. Where that is colours and is judged, slots of addresses stand beside.
pub(crate) struct Stage<'a> {
    pub(crate) targets: &'a MapTargets,
    pub(crate) scene: &'a mut MapScene,
    pub(crate) beside: Option<(&'a MapTargets, &'a mut MapScene)>,
}

impl Stage<'_> {
    /// Bytes that were sent of what is drawn.
    fn send_tile(&self, number: usize, slot: usize, texels: &[u8]) -> u64 {
        if let Some((targets, scene)) = &self.beside {
            targets.send_texels(scene, slot, &addresses(number));
        }
        self.targets.send_texels(self.scene, slot, texels)
    }

    fn send_slots(&self, held: &Slots<Tile>) -> u64 {
        if let Some((targets, scene)) = &self.beside {
            targets.send_slots(scene, held.held());
        }
        self.targets.send_slots(self.scene, held.held())
    }

    fn send_view(&mut self, eye: &Eye, mesh: &MapMesh) -> u64 {
        if let Some((targets, scene)) = &mut self.beside {
            targets.send(scene, eye, &OPTIONS, mesh);
        }
        self.targets.send(self.scene, eye, &OPTIONS, mesh)
    }
}

/// What a frame did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FrameRecord {
    /// Tiles that it sent.
    pub(crate) sent: usize,
    /// Bytes that it sent, tiles and all else.
    pub(crate) bytes: u64,
    /// Bytes written at the device's queue since the frame before, by whoever wrote them.
    pub(crate) queue_bytes: u64,
    /// Whether its eye is that of the frame before, and it has the tiles that it chooses.
    pub(crate) rests: bool,
    /// Tiles for which no slot was free.
    pub(crate) without_slot: usize,
    /// Pixels that say what they want, and those of them that show a coarser level.
    pub(crate) pixels: [u64; 2],
    /// Wall clock of making, choosing, sending and drawing.
    pub(crate) wall_ms: f64,
    /// Process CPU time of the same, with that of a thread that reads meanwhile.
    pub(crate) cpu_ms: f64,
}

impl FrameRecord {
    /// Share of its pixels that show a coarser level than they want.
    pub(crate) fn coarse_share(&self) -> f64 {
        let [all, coarse] = self.pixels.map(|pixels| pixels as f64);
        coarse / all.max(1.0)
    }
}

/// What a flight did.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct FlightRecord {
    pub(crate) frames: Vec<FrameRecord>,
    /// Where a thread reads beside frames.
    pub(crate) beside: Option<Beside>,
}

/// What a thread did that reads beside frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beside {
    /// Requests that frames gave up.
    pub(crate) cancelled: usize,
    /// CPU time of the thread.
    pub(crate) cpu_ms: f64,
}

/// Called after a frame with its number, and what is held in which slot.
pub(crate) type LookAt<'a> =
    &'a mut dyn FnMut(usize, bool, &Slots<Tile>, &mut Stage<'_>) -> Result<(), Failure>;

/// Flies, from the coarsest level alone or all tiles on until the resting eye lacks none.
///
/// - `look_at`: also whether the frame is the last
///
/// # Errors
/// Of the device, of files, and of `look_at`.
pub(crate) fn fly(
    course: &Course,
    flight: Flight,
    files: &Arc<TileFiles>,
    stage: &mut Stage<'_>,
    look_at: LookAt<'_>,
) -> Result<FlightRecord, Failure> {
    let latency = Duration::from_millis(flight.latency_ms.into());
    let own = Arc::clone(files);
    let read = move |number: usize| {
        if !latency.is_zero() {
            std::thread::sleep(latency);
        }
        own.read(number)
    };
    let (first, slots) = match flight.loading {
        Loading::AllThere => (course.tiles.clone(), course.tiles.len()),
        Loading::Background | Loading::Foreground => (coarsest().to_vec(), SLOTS),
    };
    let mut held = Slots::new(slots);
    for tile in first {
        let placed = held.place(tile, 0).zip(course.number(tile));
        let (placed, number) = placed.ok_or("there are too few slots".to_owned())?;
        stage.send_tile(number, placed.slot, &files.read(number)?);
    }
    stage.send_slots(&held);
    // Once before the clock: what was sent so far is copied with it.
    let (_, mesh) = course.mesh(&course.eyes[0])?;
    stage.send_view(&course.eyes[0], &mesh);
    stage.targets.draw(stage.scene)?;
    let loader = (flight.loading == Loading::Background).then(|| Loader::start(read.clone()));
    let mut record = FlightRecord::default();
    let (mut shown, mut quiet) = (None, 0);
    let mut written = stage.targets.written_bytes();
    let start = Instant::now();
    for frame in 0..MOST_FRAMES {
        let due = PACE.saturating_mul(u32::try_from(frame).unwrap_or(u32::MAX));
        std::thread::sleep(due.saturating_sub(start.elapsed()));
        let watch = CpuStopwatch::start();
        let at = frame.min(MOVING - 1);
        let eye = &course.eyes[at];
        let (_, mesh) = course.mesh(eye)?;
        let wanted = chosen(eye, &mesh)?;
        // Frames count from 1: what was there before is older.
        let now = frame + 1;
        for tile in wanted.iter().copied().chain(coarsest()) {
            if let Some(shown) = held.shown(tile, Tile::parent) {
                held.uses(shown, now);
            }
        }
        let lacking = wanted.iter().filter(|tile| !held.holds(**tile));
        let lacking: Vec<usize> = lacking.filter_map(|tile| course.number(*tile)).collect();
        let come = if let Some(loader) = &loader {
            loader.exchange(frame, &lacking, flight.budget)?
        } else {
            let numbers = lacking.iter().copied().take(flight.budget);
            let read = |number| Ok((number, read(number)?));
            numbers.map(read).collect::<Result<_, String>>()?
        };
        let mut of_frame = FrameRecord::default();
        for (number, texels) in come {
            match held.place(course.tiles[number], now) {
                Some(placed) => {
                    of_frame.bytes += stage.send_tile(number, placed.slot, &texels);
                    of_frame.sent += 1;
                }
                None => of_frame.without_slot += 1,
            }
        }
        if of_frame.sent > 0 {
            of_frame.bytes += stage.send_slots(&held);
        }
        if shown != Some(at) {
            of_frame.bytes += stage.send_view(eye, &mesh);
            shown = Some(at);
        }
        stage.targets.draw(stage.scene)?;
        of_frame.wall_ms = watch.wall_ms();
        of_frame.cpu_ms = watch.cpu_ms();
        of_frame.pixels = course.pixels(frame, &held);
        let before = std::mem::replace(&mut written, stage.targets.written_bytes());
        of_frame.queue_bytes = written - before;
        // A frame that rests may send nothing, so rest must not be defined by what is sent.
        of_frame.rests = lacking.is_empty() && frame > 0 && at == (frame - 1).min(MOVING - 1);
        record.frames.push(of_frame);
        quiet = if of_frame.rests { quiet + 1 } else { 0 };
        let is_last = quiet == QUIET;
        look_at(frame, is_last, &held, stage)?;
        if is_last {
            record.beside = loader.as_ref().map(|loader| Beside {
                cancelled: loader.cancelled(),
                cpu_ms: loader.cpu_ms(),
            });
            return Ok(record);
        }
    }
    let why = format!("it still lacks tiles after {MOST_FRAMES} frames");
    Err(Failure::broken(why))
}
