// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles that are files, read by a thread beside frames, by frames that wait, or all before the first frame. Meanwhile a
//! tile that is not there is drawn by the nearest that it is a part of.

mod figures;
mod files;
mod flight;
mod judge;
mod section;

pub(crate) use section::SECTION;

use super::device::{MapScene, MapTargets};
use super::picture::{colour_of, cut};
use super::tile_set::{ADDRESSES, COLOURS, Content, Shown, shown};
use super::tiles::grid;
use super::truth::{Tile, Truth};
use crate::metrics::{self, LATENCY_MS, LOADING, PATH, PICTURES, SIZE_PX, TRANSFERS};
use figures::{of_flight, of_frames, steady, trace};
use files::TileFiles;
use flight::{
    Course, Flight, FlightRecord, Loading, MOVING, OPTIONS, Path, SLOTS, STEP_PX, Stage, fly,
};
use judge::{Judged, is_coarse, judge};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_globe_views::{Opened, STUDY, fingerprint, write_png};
use terrafill_results::{ConditionKey, PlannedCase, Status, Verdict};
use terrafill_scene::{ImageSize, MipChain};
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Session, judged, planned_case, verified,
};

/// Name of this part in cases.
pub(crate) const PART: &str = "loading";
/// Pixels a side at most: every one of each eye is asked in `f64` what it wants.
const MAX_SIDE_PX: u32 = 256;
/// Pixels that may be right beside their middle alone: `f32` keeps a place of level 11 to some 1/32 of a texel.
const MAX_BAND_PERCENT: usize = 3;
/// Flights of a process. Those over a picture send the same bytes as others, and are judged alone.
const SAMPLES: [u32; 2] = [1, 0];
/// The frame of which the report has a picture beside the last.
const PICTURED: usize = 3;
/// Note of the hash of the last picture.
const LAST: &str = "last";

/// Frames whose pictures are judged, and the last.
fn is_judged(frame: usize) -> bool {
    frame % 5 == 3
}

/// Flights over one kind of tiles.
pub(crate) struct Loadings {
    flights: Vec<Flight>,
    side_px: u32,
    /// `None`: texels hold their own address.
    picture: Option<Arc<MipChain>>,
    opened: Rc<Opened>,
}

fn flights(is_quick: bool, of_picture: bool) -> Vec<Flight> {
    const ANY: usize = usize::MAX;
    use Loading::{AllThere, Background, Foreground};
    let ways: &[(Loading, usize, u32)] = if of_picture {
        &[(Background, ANY, 0)]
    } else if is_quick {
        &[
            (Background, ANY, 0),
            (Background, 1, 0),
            (Foreground, ANY, 0),
        ]
    } else {
        &[
            (Background, ANY, 0),
            (Background, 4, 0),
            (Background, 1, 0),
            (Foreground, ANY, 0),
            (AllThere, ANY, 0),
            (Background, ANY, 20),
            (Foreground, ANY, 20),
        ]
    };
    let paths = if is_quick || of_picture {
        &Path::ALL[..1]
    } else {
        &Path::ALL[..]
    };
    let of = |path: &Path| {
        let path = *path;
        // On one path tiles alone that come at once, as many as may: each flight takes its time.
        let is_planned = move |(_, budget, ms): &&(Loading, usize, u32)| {
            path == Path::Descent || *budget == ANY && *ms == 0
        };
        ways.iter()
            .filter(is_planned)
            .map(move |&(loading, budget, latency_ms)| Flight {
                path,
                loading,
                budget,
                latency_ms,
            })
    };
    paths.iter().flat_map(of).collect()
}

fn case(flight: &Flight, side_px: u32, pictures: Option<&str>) -> PlannedCase {
    let transfers = match flight.budget {
        usize::MAX => "any".to_owned(),
        tiles => tiles.to_string(),
    };
    let conditions: [(ConditionKey, String); 7] = [
        (metrics::PART, PART.to_owned()),
        (PICTURES, pictures.unwrap_or("addresses").to_owned()),
        (PATH, flight.path.name().to_owned()),
        (LOADING, flight.loading.name().to_owned()),
        (TRANSFERS, transfers),
        (LATENCY_MS, flight.latency_ms.to_string()),
        (SIZE_PX, side_px.to_string()),
    ];
    planned_case(
        STUDY,
        SAMPLES[usize::from(pictures.is_some())],
        conditions,
        None,
    )
}

impl Loadings {
    /// - `picture`: of the whole body and its name; without one texels hold their own address
    pub(crate) fn planned(
        side_px: u32,
        is_quick: bool,
        picture: Option<(Arc<MipChain>, &str)>,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let side_px = side_px.min(MAX_SIDE_PX);
        let flights = flights(is_quick, picture.is_some());
        let name = picture.as_ref().map(|(_, name)| *name);
        let cases = flights.iter().map(|flight| case(flight, side_px, name));
        CaseGroup {
            name: format!("{STUDY}/{PART}/{}", name.unwrap_or("addresses")),
            cases: cases.collect(),
            // The flight that is judged warms it.
            warm_up: Some(0),
            work: Self {
                flights,
                side_px,
                picture: picture.map(|(picture, _)| picture),
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(LoadingPart {
                    group,
                    context,
                    targets: None,
                    paths: BTreeMap::new(),
                    last: BTreeMap::new(),
                }))
            },
        }
    }
}

/// A path, and its tiles on disk.
type Flown = Rc<(Course, Arc<TileFiles>)>;

struct LoadingPart<'a> {
    group: &'a CaseGroup<Loadings>,
    context: Context<'a>,
    /// Of addresses, and of colours.
    targets: Option<[MapTargets; 2]>,
    paths: BTreeMap<Path, Flown>,
    /// By case, the hash of its last picture.
    last: BTreeMap<usize, String>,
}

/// A picture of a frame that is judged.
struct ShownFrame {
    frame: usize,
    shown: Vec<Shown>,
    /// Where tiles hold colours.
    colours: Vec<[u8; 4]>,
    held: BTreeSet<Tile>,
    /// Of every [`STEP_PX`] pixels those that show a coarser level than they want, by the tiles that are held.
    coarse: u64,
}

/// Slots of addresses and of colours.
struct Scenes {
    addresses: MapScene,
    colours: Option<MapScene>,
}

impl LoadingPart<'_> {
    fn flown(&mut self, path: Path) -> Result<Flown, Failure> {
        if let Some(known) = self.paths.get(&path) {
            return Ok(Rc::clone(known));
        }
        let work = &self.group.work;
        let surface = grid(&work.opened, OPTIONS.n)?;
        let course = Course::new(path, work.side_px, surface)?;
        let tiles = &course.tiles;
        let picture = &work.picture;
        let texels = |number: usize| match picture {
            Some(picture) => cut(picture, tiles[number]),
            None => flight::addresses(number),
        };
        let files = TileFiles::write(self.context.folder, tiles.len(), texels)?;
        let flown = Rc::new((course, Arc::new(files)));
        self.paths.insert(path, Rc::clone(&flown));
        Ok(flown)
    }

    /// Slots for a flight.
    fn scenes(&mut self, flight: Flight, course: &Course) -> Result<Scenes, Failure> {
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let size = ImageSize::new(self.group.work.side_px, self.group.work.side_px);
        let [addresses, colours] = self.targets.get_or_insert_with(|| {
            [ADDRESSES, COLOURS].map(|format| MapTargets::new(&gpu, size, format))
        });
        let slots = match flight.loading {
            Loading::AllThere => course.tiles.len(),
            Loading::Background | Loading::Foreground => SLOTS,
        };
        let slots = u32::try_from(slots).unwrap_or(u32::MAX);
        let mut of_colours = || colours.slots(&OPTIONS, slots, &Content::Colours(Vec::new()));
        let is_picture = self.group.work.picture.is_some();
        Ok(Scenes {
            addresses: addresses.slots(&OPTIONS, slots, &Content::Addresses)?,
            colours: is_picture.then(&mut of_colours).transpose()?,
        })
    }

    /// What a case's flight shows, and its record.
    ///
    /// - `judges`: whether pictures on the way are taken, and addresses beside colours
    fn fly(
        &mut self,
        case: usize,
        judges: bool,
    ) -> Result<(FlightRecord, Vec<ShownFrame>, String), Failure> {
        let flight = self.group.work.flights[case];
        let flown = self.flown(flight.path)?;
        let (course, files) = &*flown;
        let mut scenes = self.scenes(flight, course)?;
        let targets = self.targets.as_ref();
        let [of_addresses, of_colours] = targets.ok_or("it has no targets".to_owned())?;
        let mut stage = match &mut scenes.colours {
            None => Stage {
                targets: of_addresses,
                scene: &mut scenes.addresses,
                beside: None,
            },
            Some(colours) => Stage {
                targets: of_colours,
                scene: colours,
                beside: judges.then_some((of_addresses, &mut scenes.addresses)),
            },
        };
        let is_picture = self.group.work.picture.is_some();
        let (mut frames, mut last) = (Vec::new(), String::new());
        let record = fly(
            course,
            flight,
            files,
            &mut stage,
            &mut |frame, is_last, held, stage| {
                if is_last {
                    last = fingerprint(&[stage.targets.colours()?.as_flattened()]);
                }
                let is_moving = frame < MOVING && is_judged(frame);
                if !judges || !(is_last || is_moving) {
                    return Ok(());
                }
                let colours = is_picture.then(|| stage.targets.colours());
                let colours = colours.transpose()?.unwrap_or_default();
                if let Some((targets, scene)) = &stage.beside {
                    targets.draw(scene)?;
                }
                let pixels = of_addresses.addresses()?;
                let pixels = pixels.iter().map(|value| shown(&course.tiles, *value));
                frames.push(ShownFrame {
                    frame,
                    shown: pixels.collect(),
                    colours,
                    held: held.held().map(|(tile, _)| tile).collect(),
                    coarse: course.pixels(frame, held)[1],
                });
                Ok(())
            },
        )?;
        Ok((record, frames, last))
    }
}

/// Pixels that have another colour than the texel that they show.
fn other_colours(frame: &ShownFrame, course: &Course, files: &TileFiles) -> Result<usize, String> {
    let mut known: BTreeMap<Tile, Vec<u8>> = BTreeMap::new();
    let mut others = 0;
    for (colour, shown) in frame.colours.iter().zip(&frame.shown) {
        let Shown::Texel(texel) = shown else { continue };
        if let Entry::Vacant(new) = known.entry(texel.tile) {
            let number = course.number(texel.tile);
            let number = number.ok_or("it shows no tile of the flight".to_owned())?;
            new.insert(files.read(number)?);
        }
        others += usize::from(colour_of(&known, *texel) != Some(*colour));
    }
    Ok(others)
}

/// Of every [`STEP_PX`] pixels those that show a coarser level than they want.
fn of_every(frame: &ShownFrame, truths: &[Option<Truth>], side_px: u32) -> u64 {
    let on_lattice =
        |at: &u32| (at % side_px).is_multiple_of(STEP_PX) && (at / side_px).is_multiple_of(STEP_PX);
    let pixels = (0..).zip(frame.shown.iter().zip(truths));
    let pixels = pixels.filter(|(at, _)| on_lattice(at));
    let is_coarse = |(shown, truth): (&Shown, &Option<Truth>)| {
        truth.as_ref().is_some_and(|truth| is_coarse(truth, shown))
    };
    pixels.filter(|(_, pixel)| is_coarse(*pixel)).count() as u64
}

/// A colour for each level, darker in every other texel, and pale where it is coarser than wanted.
fn of_levels(frame: &ShownFrame, truths: &[Option<Truth>]) -> Vec<[u8; 3]> {
    let pixels = frame.shown.iter().zip(truths);
    let colour = |(shown, truth): (&Shown, &Option<Truth>)| {
        let (Shown::Texel(texel), Some(truth)) = (shown, truth) else {
            return [255, 0, 255];
        };
        let [level, ..] = texel.tile.key();
        let is_odd = (texel.x / 16 + texel.y / 16) % 2 == 1;
        let strength = if is_odd { 0.8 } else { 1.0 };
        let pale = if is_coarse(truth, shown) { 0.6 } else { 0.0 };
        let turn = f64::from(level) * 0.19;
        [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|phase| {
            let hue = 0.5 + 0.5 * (std::f64::consts::TAU * (turn + phase)).cos();
            byte(strength * (hue * (1.0 - pale) + pale))
        })
    };
    pixels.map(colour).collect()
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "of a share between 0 and 1"
)]
fn byte(share: f64) -> u8 {
    (255.0 * share).round() as u8
}

impl LoadingPart<'_> {
    fn write(
        &self,
        case: usize,
        frame: &ShownFrame,
        truths: &[Option<Truth>],
    ) -> Result<String, String> {
        let is_last = frame.frame >= MOVING;
        let stem = self.group.cases[case].id.name.replace('/', "-");
        let name = format!("{stem}-{}", if is_last { "last" } else { "before" });
        let size = [self.group.work.side_px; 2];
        let pixels = if frame.colours.is_empty() {
            of_levels(frame, truths)
        } else {
            frame.colours.iter().map(|[rgb @ .., _]| *rgb).collect()
        };
        write_png(self.context.folder, &name, size, pixels.into_iter())
    }
}

impl Session for LoadingPart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let flight = self.group.work.flights[case];
        let (record, frames, last) = self.fly(case, true)?;
        let flown = self.flown(flight.path)?;
        let (course, files) = &*flown;
        let (mut all, mut reason) = (Judged::default(), of_frames(&record, flight.budget));
        let mut notes = Vec::new();
        if self.group.work.picture.is_none() {
            // While a judged picture is read back the thread reads on, so that tiles come earlier than in timed flights.
            let (as_timed, ..) = self.fly(case, false)?;
            notes.push(("coarse", trace(&as_timed, |of| of.coarse_share())));
            notes.push(("bytes", trace(&as_timed, |of| of.bytes as f64)));
        }
        let mut moving_coarse = 0;
        for frame in &frames {
            let truths = course.truths(frame.frame)?;
            let found = judge(&truths, &frame.shown, &frame.held);
            let shows = of_every(frame, &truths, self.group.work.side_px);
            if shows.abs_diff(frame.coarse) > found.in_band as u64 {
                let tiles = frame.coarse;
                reason = format!(
                    "{shows} pixels show a coarser level than they want, by the tiles that are there {tiles}"
                );
            }
            let others = other_colours(frame, course, files)?;
            if others > 0 {
                reason =
                    format!("{others} pixels have another colour than the texel that they show");
            }
            all = all.and(found);
            if frame.frame < MOVING {
                moving_coarse += found.coarse;
            }
            let is_last = frame.frame >= MOVING;
            if is_last || frame.frame == PICTURED {
                let note = if is_last { "picture" } else { "before" };
                notes.push((note, self.write(case, frame, &truths)?));
            }
        }
        if all.wrong > 0 {
            let (wrong, of) = (all.wrong, all.pixels);
            reason = format!(
                "{wrong} of {of} pixels show another texel than that of the finest tile that is there, allowed 0"
            );
        } else if 100 * all.in_band > MAX_BAND_PERCENT * all.pixels {
            reason = format!(
                "{} pixels, more than {MAX_BAND_PERCENT} %, are right beside their middle alone",
                all.in_band
            );
        }
        notes.push(("band", all.in_band.to_string()));
        notes.push((LAST, last.clone()));
        self.last.insert(case, last);
        let mut figures = vec![
            (metrics::GLOBE_LOAD_WRONG_PX.name, all.wrong as f64),
            (metrics::GLOBE_LOAD_JUDGED_PX.name, all.pixels as f64),
            (
                metrics::GLOBE_LOAD_MOVING_COARSE_PX.name,
                moving_coarse as f64,
            ),
            (metrics::GLOBE_TILE_COUNT.name, course.tiles.len() as f64),
            (metrics::GLOBE_LOAD_FILE_BYTES.name, files.bytes as f64),
        ];
        figures.extend(steady(&record));
        Ok(judged(reason, figures, notes))
    }

    /// Another flight shows other tiles on its way, but the same at its end: each timed flight is held to that picture.
    fn recheck(
        &mut self,
        case: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        let Some(last) = notes.get(LAST) else {
            return self.verify(case);
        };
        self.last.insert(case, last.clone());
        Ok(Verdict {
            status,
            ..Verdict::default()
        })
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let verified = verified(&mut self.last, case)?.clone();
        let (record, _, last) = self.fly(case, false)?;
        if last != verified {
            return Err(Failure::broken(
                "its last picture is not the one that was verified",
            ));
        }
        let over = of_frames(&record, self.group.work.flights[case].budget);
        if !over.is_empty() {
            return Err(Failure::broken(over));
        }
        Ok(of_flight(&record))
    }
}

#[cfg(test)]
mod tests;
