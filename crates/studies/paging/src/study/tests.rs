use super::*;
use crate::texture::PAGE;
use std::rc::Rc;
use terrafill_contract::{Devices, device_for_test};
use terrafill_results::Status;
use terrafill_study::Group as _;

/// 1,024 texels a side.
const SMALL: u32 = 3;
/// More pixels than a page has texels: else no leaf splits by counted pixels.
const SIDE: u32 = 256;

fn small(source: Source) -> Texture {
    Texture {
        source,
        finest: SMALL,
    }
}

/// What `check` gives on a device, in a folder of its own; `None`, said aloud, where there is none.
fn on_device<R>(check: impl FnOnce(Context<'_>) -> R) -> Option<R> {
    let devices = Rc::new(Devices::default());
    device_for_test(terrafill_gpu::shared_gpu(&devices))?;
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("images")).expect("writable");
    Some(check(Context {
        devices: &devices,
        folder: folder.path(),
    }))
}

fn figure(verdict: &Verdict, metric: &terrafill_results::Metric) -> f64 {
    let found = verdict
        .figures
        .iter()
        .find(|(name, _)| *name == metric.name);
    found
        .unwrap_or_else(|| panic!("{} in {verdict:?}", metric.name))
        .1
}

#[test]
fn flights_show_what_the_page_table_allows_and_a_steady_frame_sends_nothing() {
    on_device(|context| {
        let group = group(small(Source::Addresses), 64, works(true, SIDE), 1);
        let mut session = group.open(context).expect("opens");
        let mut swings = false;
        for (case, work) in group.work.works.iter().enumerate() {
            let name = &group.cases[case].id.name;
            let verdict = session
                .verify(case)
                .map_err(Failure::reason)
                .expect("a verdict");
            eprintln!("{name}: {} {:?}", verdict.reason, verdict.figures);
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            assert!(figure(&verdict, PAGING_READS) > 1.0, "{name}");
            let steady = figure(&verdict, PAGING_STEADY_BYTES);
            if work.flight.hysteresis > 1.0 || work.flight.rule == Rule::Derivative {
                assert_eq!(steady, 0.0, "{name}");
            }
            swings |= steady > 0.0;
            // A budget of one page is kept to, and a jump cannot keep up with it.
            let most = figure(&verdict, PAGING_READS_MAX);
            assert!(most <= work.flight.budget as f64);
            let missing = figure(&verdict, PAGING_MISSING_FRAMES);
            let is_jump = work.flight.path == Path::Jump;
            assert!(
                !(is_jump && work.flight.budget == 1) || missing > 0.0,
                "{name}"
            );
            if case % 7 > 0 {
                continue;
            }
            let again = session.recheck(case, Status::Ok, &notes(&verdict));
            let again = again.map_err(Failure::reason).expect("a verdict");
            assert!(again.figures.is_empty(), "{name}: judged once");
        }
        assert!(swings, "negative control: a hysteresis of 1");
        let last = group.work.works.len() - 1;
        for (case, count) in [(0, 10), (last - 2, 2), (last - 1, 2), (last, 2)] {
            let times = session.time(case).map_err(Failure::reason).expect("times");
            assert_eq!(times.len(), count);
            assert!(times.iter().all(|(_, ms)| *ms >= 0.0), "{times:?}");
        }
    });
}

fn notes(verdict: &Verdict) -> BTreeMap<String, String> {
    let notes = verdict.notes.iter();
    notes
        .map(|(name, text)| ((*name).to_owned(), text.clone()))
        .collect()
}

/// What is found of the last frame of a flight after a fault, and how many pages a still view then lacks.
///
/// - `fault`: done to the device before the frame is drawn once more, with the table as it was
fn faulty(
    context: Context<'_>,
    flight: Flight,
    fault: impl FnOnce(&mut Stage, &PageFile, &mut Vec<u32>, &mut Vec<[u8; 4]>),
) -> (Judged, usize) {
    let texture = small(Source::Addresses);
    let gpu = terrafill_gpu::shared_gpu(context.devices).expect("a device");
    let file = PageFile::make(&texture, context.folder).expect("written");
    let size = ImageSize::new(SIDE, SIDE);
    let mut stage = Stage::new(&gpu, size, &texture, 64).expect("opens");
    let mut paged = Paged {
        texture: &texture,
        file: &file,
        stage: &mut stage,
        slots: 64,
    };
    let mut last = Vec::new();
    let keep = |_: [usize; 2], _: &Eye, table: &[u32], _: &mut Stage| {
        last = table.to_vec();
        Ok(())
    };
    fly(&mut paged, flight, true, keep)
        .map_err(Failure::reason)
        .expect("flown");
    let eye = flight.path.eye(FRAMES, SIDE);
    stage.draw(&eye, flight.look(false)).expect("drawn");
    let mut colours = stage.colours().expect("read");
    fault(&mut stage, &file, &mut last, &mut colours);
    let look = Look {
        addresses: true,
        ..flight.look(true)
    };
    stage.draw(&eye, look).expect("drawn");
    let counts = stage.counts(true).expect("read").expect("counts");
    let said = stage.said().expect("read");
    let held = (0..last.len()).filter(|number| last[*number] & SLOT != 0);
    let pages = held
        .map(Page::numbered)
        .map(|page| (page, texture.page(page)));
    let pages = pages.collect();
    let globe = Globe::new();
    let reference = Reference::new(eye, &globe, &texture, &last, look.by_derivative);
    let judged = reference.judge(&colours, &pages, Some(&said));
    (judged, stage.lacks(&counts))
}

/// The page that the last frame shows below the eye, and its slot.
fn shown(table: &[u32]) -> (Page, usize) {
    let eye = Path::Smooth.eye(FRAMES, SIDE).place;
    let uv = [
        0.5 + eye.longitude_rad / std::f64::consts::TAU,
        0.5 - eye.latitude_rad / std::f64::consts::PI,
    ];
    let pages = (0..=SMALL).rev().map(|level| Page::at(level, uv));
    let found = pages.map(|page| (page, table[page.number()] & SLOT));
    let (page, slot) = found
        .into_iter()
        .find(|(_, slot)| *slot > 0)
        .expect("a page");
    (page, slot as usize - 1)
}

#[test]
fn a_wrong_slot_a_border_left_out_a_stale_entry_and_another_level_are_noticed() {
    on_device(|context| {
        let flight = counted(Path::Smooth, usize::MAX);
        let derivative = Flight {
            rule: Rule::Derivative,
            ..flight
        };
        let mut bytes = vec![0; PAGE_BYTES];
        for flight in [flight, derivative] {
            let of = |fault: &mut dyn FnMut(&mut Stage, &PageFile, &mut Vec<u32>)| {
                let found = faulty(context, flight, |stage, file, table, _| {
                    fault(stage, file, table);
                });
                found.0.mismatched
            };
            let (right, lacks) = faulty(context, flight, |_, _, _, _| ());
            assert_eq!((right.mismatched, lacks), (0, 0), "{right:?}");
            // Colours alone: a picture that is a pixel off, and a table of before the flight.
            let rows = |colours: &mut Vec<[u8; 4]>| {
                let few = 8 * SIDE as usize;
                let middle = colours.len() / 2;
                colours[middle..middle + few].rotate_left(1);
                few as u64
            };
            let mut few = 0;
            let (off, _) = faulty(context, flight, |_, _, _, colours| few = rows(colours));
            assert!(off.mismatched > few / 2, "{off:?}");
            let (_, lacks) = faulty(context, flight, |stage, _, _, _| stage.restart());
            assert!(lacks > 0, "an empty table");
            // Another page's texels in the slot.
            let wrong = of(&mut |stage, file, table| {
                let (page, slot) = shown(table);
                let other = page.parent().expect("not the whole");
                file.read(other, &mut bytes).expect("read");
                stage.write_page(slot, &bytes);
            });
            assert!(wrong > 0);
            // Its own texels, with the first and the last column and row in place of the neighbours'.
            let wrong = of(&mut |stage, _, table| {
                let (page, slot) = shown(table);
                for row in 0..130_u32 {
                    for column in 0..130_u32 {
                        let [x, y] = [(page.x, column), (page.y, row)]
                            .map(|(page, at)| page * PAGE + at.clamp(1, PAGE) - 1);
                        let texel = crate::texture::address(page.level, x, y).to_le_bytes();
                        let at = 4 * (row * 130 + column) as usize;
                        bytes[at..at + 4].copy_from_slice(&texel);
                    }
                }
                stage.write_page(slot, &bytes);
            });
            assert!(wrong > 0, "a border left out");
            // The page has gone, and the device's table still has it.
            let wrong = of(&mut |_, _, table| {
                let (page, _) = shown(table);
                table[page.number()] &= !SLOT;
            });
            assert!(wrong > 0, "a stale entry");
        }
        // Leaves one level off.
        let (wrong, _) = faulty(context, flight, |_, _, table, _| {
            let leaf = crate::residency::LEAF;
            for number in (0..table.len()).rev().filter(|at| *at > 0) {
                if table[number] & leaf != 0 {
                    let parent = Page::numbered(number).parent().expect("not the whole");
                    table[number] &= !leaf;
                    table[parent.number()] |= leaf;
                }
            }
        });
        assert!(wrong.mismatched > 0, "an off-by-one level");
    });
}

#[test]
fn colours_of_a_picture_lie_between_the_texels_of_pages_and_another_picture_is_noticed() {
    on_device(|context| {
        let grey = |at: u32| [(at * 7 % 251) as u8, (at / 64 * 5 % 241) as u8, 90, 255];
        let rgba: Vec<u8> = (0..64 * 32).flat_map(grey).collect();
        let chain = Arc::new(MipChain::new(64, 32, rgba).expect("a picture"));
        let group = group(small(Source::Picture(chain)), 64, of_earth(SIDE), 1);
        let mut session = PagingSession::new(&group, context);
        for case in 0..group.work.works.len() {
            let (_, mut shown) = session.show(case).map_err(Failure::reason).expect("flown");
            let work = group.work.works[case];
            let frame = shown.frames.last_mut().expect("a frame");
            let judge = |frame: &ShownFrame| {
                let judged = session.judge_frame(&work, frame);
                judged.map_err(Failure::reason).expect("judged")
            };
            let right = judge(frame);
            eprintln!("{right:?}");
            assert!(right.mismatched == 0 && right.covered > 1000, "{right:?}");
            // Negative controls: one channel of one pixel, and rows from below.
            let middle = frame.colours.len() / 2 + SIDE as usize / 2;
            frame.colours[middle][2] ^= 64;
            assert_eq!(judge(frame).mismatched, 1);
            // Each wrong pixel is tried all over its band.
            if case == 0 {
                frame.colours.reverse();
                assert!(judge(frame).mismatched > 100);
            }
        }
    });
}

#[test]
fn pages_that_make_room_for_others_are_shown_no_more() {
    on_device(|context| {
        const FEW: usize = 8;
        let works = [Path::Smooth, Path::Zoom].map(|path| counted(path, usize::MAX));
        let works = works.map(|flight| flown(FLIGHTS, flight, SIDE)).into();
        let group = group(small(Source::Addresses), FEW, works, 1);
        let mut session = PagingSession::new(&group, context);
        let mut reads = Vec::new();
        for case in 0..group.work.works.len() {
            let (_, shown) = session.show(case).map_err(Failure::reason).expect("flown");
            let moves = shown.frames.iter().any(|frame| frame.frame == MOVING);
            assert!(moves, "a frame in which the eye moves is judged");
            let verdict = session.judge(case, shown).map_err(Failure::reason);
            let verdict = verdict.expect("a verdict");
            eprintln!("{}: {:?}", verdict.reason, verdict.figures);
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
            reads.push(figure(&verdict, PAGING_READS));
        }
        // As many as there are slots, beside those of the first view: some made room.
        assert!(reads.iter().all(|of| *of >= FEW as f64), "{reads:?}");
    });
}
