use super::*;
use crate::judge::filtered;
use crate::residency::LEAF;
use crate::texture::{PAGE, STORED, byte};
use std::f64::consts::TAU;
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

/// A flight that is at rest, whose last view is drawn once more after each fault.
struct Rested {
    texture: Texture,
    flight: Flight,
    stage: Stage,
    table: Vec<u32>,
    /// Of all slots that are taken.
    pages: HashMap<Page, Vec<u8>>,
}

impl Rested {
    fn new(context: Context<'_>, texture: Texture, flight: Flight) -> Self {
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
        let mut table = Vec::new();
        let keep = |_: [usize; 2], _: &Eye, last: &[u32], _: &mut Stage| {
            table = last.to_vec();
            Ok(())
        };
        let flown = fly(&mut paged, flight, true, keep);
        flown.map_err(Failure::reason).expect("flown");
        let held = (0..table.len()).filter(|number| table[*number] & SLOT != 0);
        let pages = held.map(Page::numbered);
        let pages = pages.map(|page| (page, texture.page(page))).collect();
        Self {
            texture,
            flight,
            stage,
            table,
            pages,
        }
    }

    /// What is found of the view, and how many pages it lacks.
    ///
    /// - `table`: that the judge has
    /// - `change`: of the picture
    fn judged(&mut self, table: &[u32], change: impl FnOnce(&mut [[u8; 4]])) -> (Judged, usize) {
        let eye = self.flight.path.eye(FRAMES, SIDE);
        let stage = &mut self.stage;
        stage.draw(&eye, self.flight.look(false)).expect("drawn");
        let mut colours = stage.colours().expect("read");
        change(&mut colours);
        let look = Look {
            addresses: true,
            ..self.flight.look(true)
        };
        stage.draw(&eye, look).expect("drawn");
        let counts = stage.counts(true).expect("read").expect("counts");
        let said = stage.said().expect("read");
        let said = matches!(self.texture.source, Source::Addresses).then_some(&said[..]);
        let globe = Globe::new();
        let by_derivative = self.flight.rule == Rule::Derivative;
        let reference = Reference::new(eye, &globe, &self.texture, table, by_derivative);
        let judged = reference.judge(&colours, &self.pages, said);
        (judged, stage.lacks(&counts))
    }

    /// Pixels that are wrong with other texels in the slots of some pages, which are then as they were.
    fn with_texels(&mut self, of: impl Fn(Page, &Texture) -> Option<Vec<u8>>) -> u64 {
        let slot = |page: Page| (self.table[page.number()] & SLOT) as usize - 1;
        let others = self.pages.keys().copied();
        let others = others.filter_map(|page| Some((page, of(page, &self.texture)?)));
        let others: Vec<(Page, Vec<u8>)> = others.collect();
        for (page, texels) in &others {
            self.stage.write_page(slot(*page), texels);
        }
        let (judged, _) = self.judged(&self.table.clone(), |_| ());
        for (page, _) in others {
            let slot = (self.table[page.number()] & SLOT) as usize - 1;
            self.stage.write_page(slot, &self.pages[&page]);
        }
        judged.mismatched
    }
}

/// A page's own texels, with its first and last columns and rows in place of its neighbours'.
fn without_border(texels: &[u8]) -> Vec<u8> {
    let side = STORED as usize;
    let inner = |at: usize| at.clamp(1, side - 2);
    let texel = |at: usize| {
        let own = 4 * (inner(at / side) * side + inner(at % side));
        [0, 1, 2, 3].map(|channel| texels[own + channel])
    };
    (0..side * side).flat_map(texel).collect()
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
        for rule in [Rule::Counted, Rule::Derivative] {
            let flight = Flight {
                rule,
                ..counted(Path::Smooth, usize::MAX)
            };
            let mut rested = Rested::new(context, small(Source::Addresses), flight);
            let table = rested.table.clone();
            let (right, lacks) = rested.judged(&table, |_| ());
            assert_eq!((right.mismatched, lacks), (0, 0), "{right:?}");
            // Colours alone: a picture that is a pixel off.
            let few = 8 * SIDE as usize;
            let (off, _) = rested.judged(&table, |colours| {
                let middle = colours.len() / 2;
                colours[middle..middle + few].rotate_left(1);
            });
            assert!(off.mismatched > few as u64 / 2, "{off:?}");
            // Another page's texels in the slot, and no neighbours' texels.
            let (page, _) = shown(&table);
            let other = page.parent().expect("not the whole");
            let wrong = rested.with_texels(|one, of| (one == page).then(|| of.page(other)));
            assert!(wrong > 0, "a wrong slot");
            let border = |one, of: &Texture| (one == page).then(|| without_border(&of.page(one)));
            assert!(rested.with_texels(border) > 0, "a border left out");
            // The page has gone, and the device's table still has it.
            let mut stale = table.clone();
            stale[page.number()] &= !SLOT;
            let (wrong, _) = rested.judged(&stale, |_| ());
            assert!(wrong.mismatched > 0, "a stale entry");
            // Leaves one level off.
            let mut coarser = table.clone();
            for number in (1..table.len()).rev().filter(|at| table[*at] & LEAF != 0) {
                let parent = Page::numbered(number).parent().expect("not the whole");
                coarser[number] &= !LEAF;
                coarser[parent.number()] |= LEAF;
            }
            let (wrong, _) = rested.judged(&coarser, |_| ());
            let has_leaves = rule == Rule::Counted;
            assert_eq!(wrong.mismatched > 0, has_leaves, "an off-by-one level");
            // Faults were mended, and a table of before the flight lacks pages.
            let (again, _) = rested.judged(&table, |_| ());
            assert_eq!(again, right);
            rested.stage.restart();
            let (_, lacks) = rested.judged(&table, |_| ());
            assert!(lacks > 0, "an empty table");
        }
    });
}

/// Oceans, coasts, land and ice, as many texels as half of a texture's finest level has: so much is the Blue Marble
/// enlarged, twice along each side.
fn earth_like() -> Source {
    let [width, height] = [512_u32, 256];
    let texel = |at: u32| {
        let [u, v] = [at % width, at / width].map(f64::from);
        let [u, v] = [u / f64::from(width), v / f64::from(height)];
        // Waves that meet themselves round the Earth, each twice as fine as the one before.
        let waves = (0..6).map(|octave| {
            let turns = TAU * f64::from(2_u32 << octave);
            let phase = f64::from(octave);
            ((turns * u + 3.0 * phase).sin() * (turns * v + phase).cos()) * 0.7_f64.powi(octave)
        });
        let height: f64 = waves.sum();
        let colour = match height {
            _ if (v - 0.5).abs() > 0.42 => [235.0, 240.0, 245.0],
            ..0.2 => [10.0, 30.0 + 15.0 * height, 80.0 + 20.0 * height],
            _ => [
                40.0 + 60.0 * height,
                90.0 + 20.0 * height,
                40.0 + 30.0 * height,
            ],
        };
        let [r, g, b] = colour.map(|of: f64| byte(of.clamp(0.0, 255.0)));
        [r, g, b, 255]
    };
    let rgba = (0..width * height).flat_map(texel).collect();
    Source::Picture(Arc::new(
        MipChain::new(width, height, rgba).expect("a picture"),
    ))
}

/// Stored texels as a page has them at other places.
///
/// - `place`: of a column and a row, from the middle of the first stored texel
fn resampled(texels: &[u8], place: impl Fn([f64; 2]) -> [f64; 2]) -> Vec<u8> {
    let side = STORED as usize;
    let texel = |at: usize| {
        let at = place([at % side, at / side].map(|at| at as f64));
        let at = at.map(|at| at.clamp(0.0, f64::from(STORED) - 1.001));
        [0, 1, 2, 3].map(|channel| byte(filtered(texels, channel, at)[0]))
    };
    (0..side * side).flat_map(texel).collect()
}

#[test]
fn colours_of_an_earth_show_half_a_texel_a_coarser_level_and_a_border_left_out() {
    on_device(|context| {
        for rule in [Rule::Counted, Rule::Derivative] {
            let flight = Flight {
                rule,
                ..counted(Path::Smooth, usize::MAX)
            };
            let mut rested = Rested::new(context, small(earth_like()), flight);
            let table = rested.table.clone();
            let (right, _) = rested.judged(&table, |_| ());
            assert!(right.mismatched == 0 && right.covered > 1000, "{right:?}");
            let half = rested.with_texels(|page, of| {
                let place = |at: [f64; 2]| at.map(|at| at + 0.5);
                Some(resampled(&of.page(page), place))
            });
            // The part of the coarser page that a page is a quarter of, twice as large.
            let coarser = rested.with_texels(|page, of| {
                let parent = of.page(page.parent()?);
                let [x, y] = [page.x, page.y].map(|at| f64::from(at % 2 * PAGE / 2) + 0.25);
                let place = |at: [f64; 2]| [x + 0.5 * at[0], y + 0.5 * at[1]];
                Some(resampled(&parent, place))
            });
            let border = rested.with_texels(|page, of| Some(without_border(&of.page(page))));
            eprintln!("{rule:?}: {half} {coarser} {border} of {right:?}");
            assert!(half > right.covered / 10, "half a texel off: {half}");
            // Both levels enlarge the picture: only its bends differ.
            assert!(coarser > right.covered / 50, "a coarser level: {coarser}");
            assert!(border > 10, "a border left out: {border}");
            assert_eq!(rested.judged(&table, |_| ()).0, right, "all is mended");
        }
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
