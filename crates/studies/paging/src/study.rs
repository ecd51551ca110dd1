// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: flights by every rule, the windows of the paper's Table 2, frames with and without counting, and flights
//! over a picture of the Earth.

use crate::figures::{of_records, times, trace};
use crate::flight::{Flight, FrameRecord, MOST_FRAMES, Paged, Rule, SLOTS, fly, pixels};
use crate::judge::{Judged, Reference};
use crate::metrics::{self, *};
use crate::page_file::PageFile;
use crate::path::{Eye, FRAMES, Globe, Path};
use crate::picture::{of_levels, of_tree, with_balance, with_outline, write};
use crate::residency::SLOT;
use crate::stage::{Look, Said, Stage};
use crate::texture::{PAGE_BYTES, Page, Source, Texture};
use crate::{STUDY, chapter::CHAPTER};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use terrafill_contract::{CpuStopwatch, numbers_hash};
use terrafill_results::{ConditionKey, PlannedCase, RunInput, Skipped, Verdict};
use terrafill_scene::{ImageSize, MipChain, Scene};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, JudgedOnce, Planned, Request, Shows, Study,
    StudyError, files_read, judged, planned_case,
};

/// The level with 8,192 × 8,192 texels.
const FINEST: u32 = 6;
/// Pixels a side of flights of a run that names no size.
const SIDE_PX: u32 = 512;
const QUICK_SIDE_PX: u32 = 256;
/// Below the first no leaf splits by counted pixels where four do not fill the picture; above the second the slots and
/// the texture's levels end.
const SIDES_PX: [u32; 2] = [256, 1024];
/// Flights of a process: ten in the five of a run.
const SAMPLES: u32 = 2;
/// Windows of Table 2.
const WINDOWS_PX: [u32; 3] = [1000, 800, 600];
/// At which a tree comes to rest: a split divides the mean by 4.
const HYSTERESIS_AT_REST: f64 = 4.0;
/// The frame that is judged beside the last: while the eye moves, and four after a jump.
const MOVING: usize = 24;
/// From where the last frame's pages are seen on the whole globe.
const AFAR_M: f64 = 9e6;
/// Timed frames of a view that stands still.
const STILL: usize = 20;
/// Whose picture it is: the scene names file and hash.
const SCENE: &str = "blue-marble";

/// What paging a large texture costs, and what it shows meanwhile.
#[derive(Debug, Clone, Copy)]
pub struct PagingStudy;

impl Study for PagingStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let side_px = match (request.names_size, is_quick) {
            (true, _) => request.size[0].min(request.size[1]),
            (false, true) => QUICK_SIDE_PX,
            (false, false) => SIDE_PX,
        };
        let [least, most] = SIDES_PX;
        if !(least..=most).contains(&side_px) {
            return Ok(Planned {
                skipped: vec![Skipped {
                    what: STUDY.to_owned(),
                    reason: format!("found {side_px} pixels a side, allowed: {least} to {most}"),
                }],
                ..Planned::default()
            });
        }
        let samples = request.samples.unwrap_or(SAMPLES);
        let pattern = Texture {
            source: Source::Addresses,
            finest: FINEST,
        };
        let works = works(is_quick, side_px);
        let mut planned = Planned {
            groups: vec![Box::new(group(pattern, SLOTS, works, samples))],
            ..Planned::default()
        };
        match blue_marble(request) {
            Ok((picture, read)) => {
                planned.inputs.extend(read);
                let texture = Texture {
                    source: Source::Picture(picture),
                    finest: FINEST,
                };
                let works = of_earth(side_px);
                let group = group(texture, SLOTS, works, samples);
                planned.groups.push(Box::new(group));
            }
            Err(reason) => planned.skipped.push(Skipped {
                what: format!("{STUDY}/{OF_EARTH}"),
                reason,
            }),
        }
        Ok(planned)
    }
}

/// The picture of the shipped scene, and the files that it was read from; or what is missing, with how to get it.
fn blue_marble(request: &Request) -> Result<(Arc<MipChain>, Vec<RunInput>), String> {
    let scene = Scene::shipped(SCENE, request.data_dir.as_deref());
    let scene = scene.map_err(|error| error.to_string())?;
    let texture = scene.texture.as_ref();
    let texture = texture.ok_or_else(|| format!("scene {SCENE} has no picture"))?;
    Ok((Arc::new(texture.image.clone()), files_read(&scene)))
}

/// A case.
#[derive(Debug, Clone, Copy)]
struct Work {
    part: &'static str,
    flight: Flight,
    side_px: u32,
    /// Of a still view.
    counted: Option<Counting>,
}

terrafill_results::named! {
    /// When the counts of a still view are read.
    all enum Counting {
        /// Its fragments do not count themselves.
        No = "no",
        /// When they are two frames old.
        Later = "later",
        /// Before the next frame.
        AtOnce = "at-once",
    }
}

impl Work {
    /// As its timed frames are drawn.
    fn look(&self) -> Look {
        Look {
            counts: self.counted != Some(Counting::No) && self.flight.rule != Rule::Distance,
            ..self.flight.look(false)
        }
    }
}

const fn flown(part: &'static str, flight: Flight, side_px: u32) -> Work {
    Work {
        part,
        flight,
        side_px,
        counted: None,
    }
}

const fn counted(path: Path, budget: usize) -> Flight {
    Flight {
        path,
        rule: Rule::Counted,
        hysteresis: HYSTERESIS_AT_REST,
        budget,
    }
}

fn works(is_quick: bool, side_px: u32) -> Vec<Work> {
    let mut works = Vec::new();
    for path in Path::ALL {
        for rule in Rule::ALL {
            // A footprint has no state, hence no hysteresis.
            let all: &[_] = match rule {
                Rule::Derivative => &[(1.0, usize::MAX), (1.0, 1)],
                _ => &[
                    (1.0, usize::MAX),
                    (HYSTERESIS_AT_REST, usize::MAX),
                    (HYSTERESIS_AT_REST, 1),
                ],
            };
            works.extend(all.iter().map(|&(hysteresis, budget)| {
                let flight = Flight {
                    path,
                    rule,
                    hysteresis,
                    budget,
                };
                flown(FLIGHTS, flight, side_px)
            }));
        }
    }
    let windows: &[u32] = if is_quick { &[] } else { &WINDOWS_PX };
    for side_px in windows {
        for path in [Path::Smooth, Path::Zoom] {
            let of = |budget| flown(TABLE_2, counted(path, budget), *side_px);
            works.extend([usize::MAX, 1].map(of));
        }
    }
    works.extend(Counting::ALL.map(|counting| Work {
        counted: Some(counting),
        ..flown(COUNTING, counted(Path::Zoom, usize::MAX), side_px)
    }));
    works
}

/// Flights over a picture of the Earth.
fn of_earth(side_px: u32) -> Vec<Work> {
    let flights = [Path::Smooth, Path::Zoom].map(|path| {
        let derivative = Flight {
            rule: Rule::Derivative,
            hysteresis: 1.0,
            ..counted(path, usize::MAX)
        };
        [counted(path, usize::MAX), derivative]
    });
    let flights = flights.as_flattened().iter();
    flights
        .map(|flight| flown(OF_EARTH, *flight, side_px))
        .collect()
}

/// What sessions need of all cases of one texture.
struct Pages {
    texture: Texture,
    slots: usize,
    works: Vec<Work>,
}

fn case(work: &Work, texture: &Texture, samples: u32) -> PlannedCase {
    let flight = work.flight;
    let picture = match texture.source {
        Source::Addresses => "addresses",
        Source::Picture(_) => SCENE,
    };
    let hysteresis = match flight.rule {
        Rule::Derivative => "none".to_owned(),
        _ => flight.hysteresis.to_string(),
    };
    let transfers = match flight.budget {
        usize::MAX => "any".to_owned(),
        pages => pages.to_string(),
    };
    let mut conditions: Vec<(ConditionKey, String)> = vec![
        (metrics::PART, work.part.to_owned()),
        (PICTURE, picture.to_owned()),
        (PATH, flight.path.name().to_owned()),
        (RULE, flight.rule.name().to_owned()),
        (HYSTERESIS, hysteresis),
        (TRANSFERS, transfers),
        (SIZE_PX, work.side_px.to_string()),
    ];
    let said = work.counted.map(Counting::name);
    conditions.extend(said.map(|said| (COUNTED, said.to_owned())));
    planned_case(STUDY, samples, conditions, None)
}

fn group(texture: Texture, slots: usize, works: Vec<Work>, samples: u32) -> CaseGroup<Pages> {
    let of = match texture.source {
        Source::Addresses => "addresses",
        Source::Picture(_) => SCENE,
    };
    CaseGroup {
        name: format!("{STUDY}/{of}"),
        cases: works
            .iter()
            .map(|work| case(work, &texture, samples))
            .collect(),
        // The flight that is judged warms it.
        warm_up: Some(0),
        work: Pages {
            texture,
            slots,
            works,
        },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(PagingSession::new(
                group, context,
            ))))
        },
    }
}

/// A frame that is judged.
struct ShownFrame {
    frame: usize,
    eye: Eye,
    table: Vec<u32>,
    said: Vec<Said>,
    /// Its pixels, and those that show a coarser page than they want, as its fragments counted themselves.
    counted: Option<[u64; 2]>,
    colours: Vec<[u8; 4]>,
}

/// What a flight showed.
struct Shown {
    frames: Vec<ShownFrame>,
    /// The last one's pages from afar.
    afar: Option<ShownFrame>,
    records: Vec<FrameRecord>,
}

impl Shown {
    /// Of all that does not depend on how long it took.
    fn hash(&self) -> String {
        let mut numbers = Vec::new();
        for shown in self.frames.iter().chain(&self.afar) {
            for said in &shown.said {
                numbers.extend(said.texels);
                numbers.push(said.wanted.map_or(0, |level| level + 1));
            }
            numbers.extend(shown.colours.iter().map(|rgba| u32::from_le_bytes(*rgba)));
            numbers.extend(&shown.table);
        }
        let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        for record in &self.records {
            let [pixels, missing] = record.pixels.unwrap_or_default();
            let sent = usize::try_from(record.bytes + pixels).unwrap_or(usize::MAX);
            let missing = usize::try_from(missing).unwrap_or(usize::MAX);
            numbers.extend([record.wanted, record.reads, missing, sent].map(count));
        }
        numbers_hash(&numbers)
    }
}

struct PagingSession<'a> {
    group: &'a CaseGroup<Pages>,
    context: Context<'a>,
    globe: Globe,
    /// Made when it is first read from.
    file: Option<PageFile>,
    /// By pixels a side.
    stages: BTreeMap<u32, Stage>,
}

impl<'a> PagingSession<'a> {
    fn new(group: &'a CaseGroup<Pages>, context: Context<'a>) -> Self {
        Self {
            group,
            context,
            globe: Globe::new(),
            file: None,
            stages: BTreeMap::new(),
        }
    }

    fn paged(&mut self, side_px: u32) -> Result<Paged<'_>, Failure> {
        let Pages { texture, slots, .. } = &self.group.work;
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        if self.file.is_none() {
            let made = PageFile::make(texture, self.context.folder);
            self.file = Some(made.map_err(Failure::broken)?);
        }
        let file = self.file.as_ref().ok_or("it has no file".to_owned())?;
        let stage = match self.stages.entry(side_px) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(entry) => {
                let size = ImageSize::new(side_px, side_px);
                entry.insert(Stage::new(&gpu, size, texture, *slots)?)
            }
        };
        Ok(Paged {
            texture,
            file,
            stage,
            slots: *slots,
        })
    }

    fn is_pattern(&self) -> bool {
        matches!(self.group.work.texture.source, Source::Addresses)
    }

    fn file_bytes(&self) -> Result<u64, Failure> {
        let file = self.file.as_ref().ok_or("it has no file".to_owned())?;
        file.bytes().map_err(Failure::broken)
    }

    /// Colours of a frame's pixels, or of the levels that they say.
    fn pixels(&self, frame: &ShownFrame) -> Vec<[u8; 3]> {
        if self.is_pattern() {
            return of_levels(&frame.said);
        }
        frame.colours.iter().map(|[rgb @ .., _]| *rgb).collect()
    }

    fn write(&self, case: usize, stem: &str, pixels: &[[u8; 3]]) -> Result<String, Failure> {
        let stem = format!("{}-{stem}", self.group.cases[case].id.name);
        let size = [self.group.work.works[case].side_px; 2];
        let is_photo = !self.is_pattern();
        Ok(write(self.context.folder, &stem, size, pixels, is_photo)?)
    }

    /// Pictures of a flight's last pages on the whole globe, and of their quadtree.
    ///
    /// - `eye`: that they were chosen by
    fn pictures_afar(
        &self,
        case: usize,
        afar: &ShownFrame,
        eye: &Eye,
    ) -> Result<Vec<(&'static str, String)>, Failure> {
        let ShownFrame {
            eye: far, table, ..
        } = afar;
        let pixels = self.pixels(afar);
        let texture = &self.group.work.texture;
        let levels = Reference::new(*far, &self.globe, texture, table, false).levels();
        let side_px = self.group.work.works[case].side_px;
        let pictures = [
            ("afar", with_outline(&pixels, far, eye)),
            ("balance", with_balance(&pixels, &levels, far, eye)),
            ("tree", of_tree(table, side_px)),
        ];
        let written = pictures.into_iter();
        let written = written.map(|(note, pixels)| Ok((note, self.write(case, note, &pixels)?)));
        written.collect()
    }

    fn judge_frame(&self, work: &Work, shown: &ShownFrame) -> Result<Judged, Failure> {
        let texture = &self.group.work.texture;
        let by_derivative = work.flight.rule == Rule::Derivative;
        let reference =
            Reference::new(shown.eye, &self.globe, texture, &shown.table, by_derivative);
        let file = self.file.as_ref().ok_or("it has no file".to_owned())?;
        let held = (0..shown.table.len()).filter(|number| shown.table[*number] & SLOT != 0);
        let mut pages = HashMap::new();
        let mut bytes = vec![0; PAGE_BYTES];
        for page in held.map(Page::numbered) {
            file.read(page, &mut bytes).map_err(Failure::broken)?;
            pages.insert(page, bytes.clone());
        }
        let said = self.is_pattern().then_some(&shown.said[..]);
        Ok(reference.judge(&shown.colours, &pages, said))
    }
}

/// Which frames of a case are judged: large pictures take long.
fn is_judged(work: &Work, frame: usize, is_last: bool) -> bool {
    is_last || (matches!(work.part, FLIGHTS | OF_EARTH) && frame == MOVING)
}

/// Whether the last frame's pages are drawn from afar as well: of a tree, whose leaves no footprint of the far eye moves.
fn is_seen_from_afar(work: &Work) -> bool {
    let Flight {
        rule,
        hysteresis,
        budget,
        ..
    } = work.flight;
    matches!(work.part, FLIGHTS | OF_EARTH)
        && rule == Rule::Counted
        && hysteresis > 1.0
        && budget == usize::MAX
}

impl Shows for PagingSession<'_> {
    type Shown = Shown;

    fn show(&mut self, case: usize) -> Result<(String, Shown), Failure> {
        let work = self.group.work.works[case];
        let is_pattern = self.is_pattern();
        let addresses = Look {
            by_derivative: work.flight.rule == Rule::Derivative,
            counts: true,
            measures: true,
            addresses: true,
        };
        let mut paged = self.paged(work.side_px)?;
        let (mut frames, mut afar) = (Vec::new(), None);
        let records = fly(
            &mut paged,
            work.flight,
            true,
            |[frame, last], eye, table, stage| {
                if !is_judged(&work, frame, last == 1) {
                    return Ok(());
                }
                let (mut said, mut counted) = (Vec::new(), None);
                // As timed frames are drawn, which count nothing that is for the judge alone.
                stage.draw(eye, work.look())?;
                if work.look().counts {
                    stage.counts(true)?;
                }
                let colours = stage.colours()?;
                if is_pattern {
                    stage.draw(eye, addresses)?;
                    said = stage.said()?;
                    counted = stage.counts(true)?.as_deref().and_then(pixels);
                }
                frames.push(ShownFrame {
                    frame,
                    eye: *eye,
                    table: table.to_vec(),
                    said,
                    colours,
                    counted,
                });
                if last == 1 && is_seen_from_afar(&work) {
                    let eye = eye.above(AFAR_M);
                    let look = Look {
                        by_derivative: false,
                        counts: false,
                        measures: false,
                        addresses: false,
                    };
                    stage.draw(&eye, look)?;
                    let colours = stage.colours()?;
                    let mut said = Vec::new();
                    if is_pattern {
                        let look = Look {
                            addresses: true,
                            ..look
                        };
                        stage.draw(&eye, look)?;
                        said = stage.said()?;
                    }
                    afar = Some(ShownFrame {
                        frame,
                        eye,
                        table: table.to_vec(),
                        said,
                        colours,
                        counted: None,
                    });
                }
                Ok(())
            },
        )?;
        let shown = Shown {
            frames,
            afar,
            records,
        };
        Ok((shown.hash(), shown))
    }

    fn judge(&mut self, case: usize, shown: Shown) -> Result<Verdict, Failure> {
        let work = self.group.work.works[case];
        let Shown {
            frames,
            afar,
            records,
        } = &shown;
        let mut all = Judged::default();
        let mut last = Judged::default();
        let mut moving = None;
        let mut reason = String::new();
        let mut notes = vec![
            (
                "missing",
                trace(records, |of| {
                    of.pixels.map_or(f64::NAN, |[_, px]| px as f64)
                }),
            ),
            ("bytes", trace(records, |of| of.bytes as f64)),
        ];
        for (number, frame) in frames.iter().enumerate() {
            last = self.judge_frame(&work, frame)?;
            all.mismatched += last.mismatched;
            all.in_band += last.in_band;
            all.covered += last.covered;
            if frame.frame == MOVING {
                moving = Some(last.blurred as f64);
            }
            let said = Some([last.covered, last.missing]);
            let counted = frame.counted;
            if self.is_pattern() && counted != said && reason.is_empty() {
                let frame = frame.frame;
                reason = format!(
                    "frame {frame} counts {counted:?} pixels and missing ones, its picture has {said:?}"
                );
            }
            let is_last = number + 1 == frames.len();
            if is_last || frame.frame == MOVING {
                let stem = frame.frame.to_string();
                let note = if is_last { "picture" } else { "before" };
                notes.push((note, self.write(case, &stem, &self.pixels(frame))?));
            }
        }
        if let Some((afar, last)) = afar.as_ref().zip(frames.last()) {
            let found = self.judge_frame(&work, afar)?;
            all.mismatched += found.mismatched;
            all.in_band += found.in_band;
            all.covered += found.covered;
            notes.extend(self.pictures_afar(case, afar, &last.eye)?);
        }
        if records.len() == MOST_FRAMES {
            reason = format!("it still reads after {MOST_FRAMES} frames");
        } else if all.covered == 0 {
            reason = "it shows nothing".to_owned();
        } else if all.mismatched > 0 {
            let pixels = all.mismatched;
            reason = format!("{pixels} pixels show what the reference does not allow");
        } else if 100 * all.in_band > all.covered {
            let pixels = all.in_band;
            reason = format!("{pixels} pixels, more than 1 %, are right beside their middle alone");
        }
        let mut figures = vec![
            (PAGING_MISMATCHED_PX.name, all.mismatched as f64),
            (PAGING_BAND_PX.name, all.in_band as f64),
            (PAGING_JUDGED_PX.name, all.covered as f64),
            (PAGING_FILE_BYTES.name, self.file_bytes()? as f64),
        ];
        if self.is_pattern() {
            figures.push((PAGING_BLURRED_PX.name, last.blurred as f64));
            let lost = last.edge_loss();
            figures.extend(lost.map(|lost| (PAGING_EDGE_LOSS.name, lost)));
            figures.extend(moving.map(|px| (PAGING_BLURRED_MOVING_PX.name, px)));
        }
        figures.extend(of_records(records));
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let work = self.group.work.works[case];
        let mut paged = self.paged(work.side_px)?;
        let records = fly(&mut paged, work.flight, false, |_, _, _, _| Ok(()))?;
        let Some(counted) = work.counted else {
            return Ok(times(&records));
        };
        // The view, the table and the pages are those of the flight's last frame.
        let eye = work.flight.path.eye(FRAMES, work.side_px);
        let stage = paged.stage;
        stage.draw(&eye, work.flight.look(true))?;
        let counts = stage.counts(true)?.unwrap_or_default();
        let lacks = stage.lacks(&counts);
        if lacks > 0 {
            return Err(Failure::broken(format!(
                "the still view lacks {lacks} pages"
            )));
        }
        stage.draw(&eye, work.look())?;
        if counted != Counting::No {
            stage.counts(true)?;
        }
        let watch = CpuStopwatch::start();
        for _ in 0..STILL {
            if counted == Counting::Later {
                stage.counts(false)?;
            }
            stage.submit(&eye, work.look());
            if counted == Counting::AtOnce {
                stage.counts(true)?;
            }
        }
        stage.flush()?;
        let frames = STILL as f64;
        Ok(vec![
            (PAGING_DRAW_CPU_MS.name, watch.cpu_ms() / frames),
            (PAGING_DRAW_WALL_MS.name, watch.wall_ms() / frames),
        ])
    }
}

#[cfg(test)]
mod tests;
