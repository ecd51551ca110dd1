// SPDX-License-Identifier: MIT OR Apache-2.0
//! Flights on a device, and the judge without one.

use super::flight::{Beside, FrameRecord, QUIET, addresses, wanted_tile};
use super::*;
use crate::metrics::*;
use crate::truth::{Texel, WrappedPoint};
use terrafill_fixtures::on_device::{self, figure, on_device};
use terrafill_lab::Cases;
use terrafill_maps::Slots;
use terrafill_results::made_up::MadeUpRun;
use terrafill_results::{Block, Metric, Standing};
use terrafill_screen_grid::ScreenGridKind;
use terrafill_study::Group as _;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&ScreenGridKind];
const SIDE_PX: u32 = 128;

fn of(figures: &Figures, metric: &Metric) -> f64 {
    let mut figures = figures.iter();
    let found = figures.find(|(name, _)| *name == metric.name);
    found.map_or(f64::NAN, |(_, value)| *value)
}

fn opened() -> Rc<Opened> {
    Rc::new(Opened::new(KINDS))
}

#[test]
fn each_pixel_shows_the_finest_tile_that_is_there_whoever_reads_it() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let group = Loadings::planned(SIDE_PX, false, None, &opened());
        let mut session = group.open(context).expect("opens");
        let mut found = Vec::new();
        let flights = group.work.flights.iter().enumerate();
        for (case, flight) in flights.filter(|(_, flight)| flight.latency_ms == 0) {
            let verdict = on_device::verdict(&mut *session, case, flight);
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
            assert_eq!(figure(&verdict, GLOBE_LOAD_STEADY_BYTES.name), 0.0);
            assert_eq!(figure(&verdict, GLOBE_LOAD_COARSE_LAST_PX.name), 0.0);
            if flight.loading == Loading::Background && flight.budget == 1 {
                let coarse = figure(&verdict, GLOBE_LOAD_MOVING_COARSE_PX.name);
                assert!(coarse > 0.0, "{flight:?}");
            }
            found.push((flight, session.time(case).expect("timed")));
        }
        for (flight, figures) in &found {
            let coarse = of(figures, GLOBE_LOAD_COARSE);
            let is_late = flight.loading == Loading::Background;
            // The first frame has the coarsest level alone.
            assert!(
                if is_late {
                    coarse >= 1.0
                } else {
                    coarse == 0.0
                },
                "{flight:?}: {coarse}"
            );
            if flight.budget == 1 {
                assert_eq!(of(figures, GLOBE_LOAD_SENT_MAX), 1.0);
            }
            // Where frames read there is no thread, and nothing to say of one.
            for metric in [GLOBE_LOAD_THREAD_CPU_MS, GLOBE_LOAD_CANCELLED] {
                assert_eq!(of(figures, metric).is_nan(), !is_late, "{flight:?}");
            }
            assert!(of(figures, GLOBE_LOAD_FRAME_CPU_MS) > 0.0);
        }
        // Negative control: a last picture that is another.
        let notes = BTreeMap::from([(LAST.to_owned(), "0".to_owned())]);
        let recheck = session.recheck(0, Status::Ok, &notes).expect("a verdict");
        assert_eq!(recheck.status, Status::Ok);
        let why = session.time(0).map_err(Failure::reason);
        assert!(why.is_err_and(|why| why.contains("last picture")));
    });
}

#[test]
fn colours_are_those_of_the_texels_that_are_there() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let texels = (0..64_u8).flat_map(|row| (0..128_u8).map(move |at| [at, row, at ^ row, 255]));
        let picture = MipChain::new(128, 64, texels.flatten().collect()).expect("a picture");
        let named = Some((Arc::new(picture), "made-up"));
        let group = Loadings::planned(SIDE_PX, false, named, &opened());
        assert_eq!(group.cases.len(), 1);
        let mut session = group.open(context).expect("opens");
        let verdict = on_device::verdict(&mut *session, 0, &"colours");
        assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
        assert!(session.time(0).is_ok());
        // Negative control: a pixel of another colour.
        let folder = tempfile::tempdir().expect("a folder");
        let files = TileFiles::write(folder.path(), 3, addresses).expect("written");
        let course = Course::new(Path::Descent, 8, grid(&opened(), 1).expect("a grid"));
        let course = course.expect("a course");
        let tile = course.tiles[0];
        let of = |colour| ShownFrame {
            frame: 0,
            shown: vec![Shown::Texel(Texel { tile, x: 3, y: 0 })],
            colours: vec![colour],
            held: BTreeSet::new(),
            coarse: 0,
        };
        let others = |colour| other_colours(&of(colour), &course, &files);
        assert_eq!(others([3, 0, 1, 0]), Ok(0));
        assert_eq!(others([3, 0, 1, 1]), Ok(1));
    });
}

#[test]
fn a_stale_slot_and_the_coordinates_of_another_ancestor_are_found() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let group = Loadings::planned(SIDE_PX, true, None, &opened());
        let mut part = LoadingPart {
            group: &group,
            context,
            targets: None,
            paths: BTreeMap::new(),
            last: BTreeMap::new(),
        };
        let flight = group.work.flights[0];
        let flown = part.flown(flight.path).expect("a path");
        let (course, files) = &*flown;
        let mut scenes = part.scenes(flight, course).expect("slots");
        let targets = &part.targets.as_ref().expect("targets")[0];
        let mut stage = Stage {
            targets,
            scene: &mut scenes.addresses,
            beside: None,
        };
        let mut wrong = Vec::new();
        fly(
            course,
            flight,
            files,
            &mut stage,
            &mut |frame, is_last, held, stage| {
                if !is_last {
                    return Ok(());
                }
                let tiles: BTreeSet<Tile> = held.held().map(|(tile, _)| tile).collect();
                let mut look = |stage: &Stage<'_>| {
                    targets.draw(stage.scene)?;
                    let pixels = targets.addresses()?;
                    let pixels = pixels.iter().map(|value| shown(&course.tiles, *value));
                    let pixels: Vec<Shown> = pixels.collect();
                    let truths = course.truths(frame)?;
                    wrong.push(judge(&truths, &pixels, &tiles).wrong);
                    Ok::<(), Failure>(())
                };
                look(stage)?;
                let (tile, slot) = seen(course, held);
                let number = course.number(tile).expect("a tile");
                // What was in the slot before.
                targets.send_texels(stage.scene, slot, &addresses(number - 1));
                look(stage)?;
                targets.send_texels(stage.scene, slot, &addresses(number));
                look(stage)?;
                // The tile is gone from the list, and its parent's place is that of its parent's neighbour.
                let parent = tile.parent().expect("a parent");
                let Tile::Map { level, row, column } = parent else {
                    panic!("{parent:?}");
                };
                let column = column ^ 1;
                let other = Tile::Map { level, row, column };
                let mut list = held.clone();
                let (_, before) = list
                    .held()
                    .find(|(known, _)| *known == parent)
                    .unwrap_or((parent, slot));
                let list: BTreeMap<Tile, usize> = list_without(&mut list, tile, other, before);
                targets.send_slots(stage.scene, list.into_iter());
                look(stage)
            },
        )
        .map_err(Failure::reason)
        .expect("flown");
        assert_eq!([wrong[0], wrong[2]], [0, 0]);
        assert!(wrong[1] > 10 && wrong[3] > 10, "{wrong:?}");
    });
}

/// A tile of which pixels of the last frame show most.
fn seen(course: &Course, held: &Slots<Tile>) -> (Tile, usize) {
    let truths = course.truths(MOVING).expect("a picture");
    let mut counts: BTreeMap<Tile, usize> = BTreeMap::new();
    for truth in truths.iter().flatten() {
        *counts.entry(wanted_tile(truth)).or_default() += 1;
    }
    let most = counts.into_iter().max_by_key(|(_, count)| *count);
    let (tile, _) = most.expect("a pixel");
    held.held().find(|(known, _)| *known == tile).expect("held")
}

/// A list in which one tile is gone, and another has a slot.
fn list_without(
    held: &mut Slots<Tile>,
    gone: Tile,
    other: Tile,
    slot: usize,
) -> BTreeMap<Tile, usize> {
    let mut list: BTreeMap<Tile, usize> = held.held().collect();
    list.remove(&gone);
    list.insert(other, slot);
    list
}

fn tile(level: u32, row: u32, column: u32) -> Tile {
    Tile::Map { level, row, column }
}

#[test]
fn a_pixel_may_show_one_texel_alone() {
    // In the middle of the tenth texel of the tile of row 5 and column 6.
    let at = |number: f64| (number + 10.5 / 256.0) / 8.0;
    let truth = Truth {
        drawn: WrappedPoint {
            u: at(6.0),
            by_vertex: at(5.0),
            v: None,
            cap: None,
        },
        body: None,
        levels: [3, 3],
        is_at_seam: false,
        holds_pole: false,
        snapped: 0.0,
        is_at_outline: false,
    };
    let found = |held: &[Tile], tile, x, y| {
        let held = held.iter().copied().collect();
        judge(&[Some(truth)], &[Shown::Texel(Texel { tile, x, y })], &held)
    };
    let (own, parent, root) = (tile(3, 5, 6), tile(2, 2, 3), tile(0, 0, 0));
    let right = Judged {
        pixels: 1,
        ..Judged::default()
    };
    let coarse = Judged { coarse: 1, ..right };
    assert_eq!(found(&[root, parent, own], own, 10, 10), right);
    // The eastern half of its parent's columns would be another one's; rows are the lower half.
    assert_eq!(found(&[root, parent], parent, 5, 133), coarse);
    // Negative controls: the parent where the tile is there, another quarter of the parent, the tile's own coordinates in
    // it, a neighbour, and nothing.
    let wrong = |held: &[Tile], tile, x, y| found(held, tile, x, y).wrong;
    assert_eq!(wrong(&[root, parent, own], parent, 5, 133), 1);
    assert_eq!(wrong(&[root, parent], parent, 133, 133), 1);
    assert_eq!(wrong(&[root, parent], parent, 10, 10), 1);
    assert_eq!(wrong(&[root, parent, own], tile(3, 5, 7), 10, 10), 1);
    assert_eq!(
        judge(&[Some(truth)], &[Shown::Missing], &BTreeSet::new()).wrong,
        1
    );
    // Half a texel beside it is within rounding, more is not.
    let beside = Judged {
        in_band: 1,
        ..right
    };
    assert_eq!(found(&[root, own], own, 11, 10), beside);
    assert_eq!(wrong(&[root, own], own, 12, 10), 1);
}

#[test]
fn a_frame_over_its_budget_and_bytes_at_rest_are_found() {
    let calm = FrameRecord {
        pixels: [200, 0],
        wall_ms: 2.0,
        cpu_ms: 2.0,
        ..FrameRecord::default()
    };
    let thread = Beside {
        cancelled: 3,
        cpu_ms: 9.0,
    };
    let mut record = FlightRecord {
        frames: vec![calm; MOVING + 1 + QUIET],
        beside: Some(thread),
    };
    // Without a frame that rests nothing is said of one.
    assert!(of(&steady(&record), GLOBE_LOAD_STEADY_BYTES).is_nan());
    for frame in &mut record.frames[MOVING + 1..] {
        frame.rests = true;
    }
    record.frames[MOVING] = FrameRecord {
        sent: 4,
        bytes: 400,
        pixels: [200, 50],
        wall_ms: 12.0,
        ..calm
    };
    assert_eq!(of_frames(&record, 4), "");
    let figures = of_flight(&record);
    for (metric, value) in [
        (GLOBE_LOAD_COARSE, 0.25),
        (GLOBE_LOAD_REST_FRAMES, 2.0),
        (GLOBE_LOAD_SPIKE, 6.0),
        (GLOBE_LOAD_BYTES_MAX, 400.0),
        (GLOBE_LOAD_FRAME_CPU_MS, 2.0),
        (GLOBE_LOAD_CANCELLED, 3.0),
    ] {
        assert_eq!(of(&figures, metric), value, "{}", metric.name);
    }
    assert_eq!(of(&steady(&record), GLOBE_LOAD_STEADY_BYTES), 0.0);
    // Negative controls: one tile too many, no slot, and bytes that a resting frame sends.
    let over = format!("frame {MOVING} sends 4 tiles, allowed 3");
    assert_eq!(of_frames(&record, 3), over);
    record.frames[2].without_slot = 1;
    assert!(of_frames(&record, 4).contains("frame 2 has no slot"));
    record.frames[MOVING].queue_bytes = 400;
    assert_eq!(of(&steady(&record), GLOBE_LOAD_STEADY_BYTES), 0.0);
    record.frames[MOVING + QUIET].queue_bytes = 64;
    assert_eq!(of(&steady(&record), GLOBE_LOAD_STEADY_BYTES), 64.0);
    record.beside = None;
    assert!(of(&of_flight(&record), GLOBE_LOAD_CANCELLED).is_nan());
}

#[test]
fn spikes_and_what_is_seen_meanwhile_are_found_of_pairs() {
    let found = |longest_ms: f64, [wrong, coarse, rest]: [f64; 3], processes: usize| {
        let mut run = MadeUpRun::default();
        for flight in flights(false, false) {
            let is_late = flight.loading == Loading::Background;
            let case = run.case(case(&flight, 64, None).id);
            case.figure(GLOBE_LOAD_WRONG_PX, wrong);
            case.figure(GLOBE_LOAD_JUDGED_PX, 100.0);
            case.figure(GLOBE_LOAD_STEADY_BYTES, rest);
            let coarse = if is_late { coarse } else { 0.0 };
            case.figure(GLOBE_LOAD_MOVING_COARSE_PX, coarse);
            case.note("coarse", "0.5 0.25 0");
            let seen = if is_late { 5.0 } else { 0.0 };
            case.timed(GLOBE_LOAD_COARSE, &vec![seen; processes]);
            let longest_ms = if is_late { longest_ms } else { 20.0 };
            case.timed(GLOBE_LOAD_FRAME_MAX_WALL_MS, &vec![longest_ms; processes]);
        }
        let run = run.loaded();
        let cases = Cases::of_study(&run, STUDY);
        let blocks = SECTION.blocks(&cases).expect("a section");
        assert!(blocks.iter().any(|block| matches!(block, Block::Plot(_))));
        let findings = SECTION.found(&cases);
        let said = findings.iter().map(|finding| format!("{finding:?}"));
        (
            findings
                .iter()
                .map(|finding| finding.standing)
                .collect::<Vec<_>>(),
            said.collect::<String>(),
        )
    };
    let right = [0.0, 40.0, 0.0];
    let (standing, said) = found(2.0, right, 9);
    assert_eq!(standing, [Standing::Holds; 3], "{said}");
    assert!(
        said.contains("descent, latency 20 ms: 2.00 in the background, 20.0 in the foreground"),
        "{said}"
    );
    // Negative controls: a longer frame in the background, a wrong pixel, and bytes at rest.
    let (standing, _) = found(30.0, [1.0, 40.0, 8.0], 9);
    assert_eq!(standing, [Standing::DoesNotHold; 3]);
    // One process says nothing of a longest frame, and flights that lacked nothing say nothing of tiles that come and go.
    let (standing, _) = found(2.0, [0.0; 3], 1);
    let open = [Standing::NotMeasured, Standing::Holds, Standing::CannotTell];
    assert_eq!(standing, open);
    // What is wrong is wrong nevertheless.
    let (standing, _) = found(2.0, [1.0, 0.0, 0.0], 9);
    assert_eq!(standing[0], Standing::DoesNotHold);
}

#[test]
fn bytes_that_a_resting_frame_writes_are_found_at_the_queue() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let group = Loadings::planned(SIDE_PX, true, None, &opened());
        let mut part = LoadingPart {
            group: &group,
            context,
            targets: None,
            paths: BTreeMap::new(),
            last: BTreeMap::new(),
        };
        let mut flown_with = |sends: bool| {
            let flight = group.work.flights[0];
            let flown = part.flown(flight.path).expect("a path");
            let (course, files) = &*flown;
            let mut scenes = part.scenes(flight, course).expect("slots");
            let mut stage = Stage {
                targets: &part.targets.as_ref().expect("targets")[0],
                scene: &mut scenes.addresses,
                beside: None,
            };
            let mut calm = 0;
            let record = fly(
                course,
                flight,
                files,
                &mut stage,
                &mut |frame, is_last, held, stage| {
                    let [_, coarse] = course.pixels(frame, held);
                    calm += usize::from(frame >= MOVING && coarse == 0);
                    // A tile that it has, sent once more where no frame says so.
                    if sends && calm > 1 && !is_last {
                        let (tile, slot) = held.held().next().expect("a tile");
                        let number = course.number(tile).expect("a tile");
                        let texels = addresses(number);
                        stage.targets.send_texels(stage.scene, slot, &texels);
                    }
                    Ok(())
                },
            );
            record.map_err(Failure::reason).expect("flown")
        };
        let record = flown_with(false);
        assert_eq!(of(&steady(&record), GLOBE_LOAD_STEADY_BYTES), 0.0);
        // Alone at its queue, a flight has the bytes that its frames say.
        let bytes = |of: fn(&FrameRecord) -> u64| record.frames.iter().map(of).sum::<u64>();
        assert_eq!(bytes(|frame| frame.bytes), bytes(|frame| frame.queue_bytes));
        // Negative control.
        let record = flown_with(true);
        assert!(of(&steady(&record), GLOBE_LOAD_STEADY_BYTES) >= 4.0 * 256.0 * 256.0);
    });
}

#[test]
fn tiles_are_read_as_they_were_written_and_no_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = TileFiles::write(folder.path(), 3, addresses).expect("written");
    assert_eq!(files.read(2), Ok(addresses(2)));
    assert!(files.bytes > 1000);
    // Negative controls: another tile, and one that there is not.
    assert_ne!(files.read(1), Ok(addresses(2)));
    assert!(files.read(3).is_err_and(|why| why.contains("3.png")));
    drop(files);
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("readable").count(),
        0
    );
}
