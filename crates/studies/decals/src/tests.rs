// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cases on devices, and pictures of what is not asked for, which must be noticed.

use crate::DecalsStudy;
use crate::cases::{Division, Extent, Part, Vantage, Work, groups};
use crate::chapter::CHAPTER;
use crate::divided::{Divided, FINE_PX, Origin, Series};
use crate::interface::{Addressed, Interface};
use crate::judge::{Reference, number, texels};
use crate::place::{Data, Shape};
use crate::study::{by_counts, group};
use glam::DVec2;
use std::path::Path;
use std::rc::Rc;
use terrafill_contract::{Devices, device_for_test, ids_of};
use terrafill_fixtures::studies::measured;
use terrafill_results::{Block, Chapter as _, Standing, Status, Verdict};
use terrafill_study::{Context, Depth, Failure, Group as _, Request};

const SIDE: u32 = 128;
/// A folder in which all pictures are kept, to be looked at.
const KEPT: &str = "TERRAFILL_KEEP_PICTURES";

/// Devices of both interfaces; none, so that a test is skipped, where one is not there.
fn devices() -> Option<Rc<Devices>> {
    let devices = Rc::new(Devices::default());
    device_for_test(terrafill_gpu::shared_gpu(&devices))?;
    device_for_test(terrafill_vulkan::shared_gpu(&devices))?;
    Some(devices)
}

fn figure(verdict: &Verdict, name: &str) -> f64 {
    let figure = verdict.figures.iter().find(|figure| figure.0 == name);
    figure.unwrap_or_else(|| panic!("{name} in {verdict:?}")).1
}

/// Verdicts of cases, of which one is timed.
fn verdicts(devices: &Rc<Devices>, works: Vec<Work>) -> Vec<(Work, Verdict)> {
    let kept = std::env::var_os(KEPT);
    let folder = tempfile::tempdir().expect("a folder");
    let folder = kept.as_ref().map_or(folder.path(), Path::new);
    std::fs::create_dir_all(folder.join("images")).expect("writable");
    let group = group(works, SIDE, 1, kept.is_some());
    let context = Context { devices, folder };
    let mut session = group.open(context).expect("opens");
    let mut all = Vec::new();
    for (at, case) in group.cases().iter().enumerate() {
        let verdict = session
            .verify(at)
            .or_else(Failure::verdict)
            .expect("a verdict");
        eprintln!(
            "{} {:?} {} {:?}",
            case.id.name, verdict.status, verdict.reason, verdict.figures
        );
        all.push((group.work.works[at], verdict));
    }
    let times = session.time(0).expect("a time");
    assert!(times.iter().all(|(_, ms)| *ms > 0.0), "{times:?}");
    all
}

#[test]
fn every_case_is_as_its_triangles_say() {
    let Some(devices) = devices() else {
        return;
    };
    let mut nearer = 0;
    for works in groups(false) {
        for (work, verdict) in verdicts(&devices, works) {
            let name = work.name();
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            if work.division == Division::Formula && !work.is_tested {
                assert!(figure(&verdict, "decal_px_max") <= FINE_PX, "{name}");
            }
            nearer += usize::from(work.origin == Origin::Centre);
        }
    }
    assert!(nearer > 5);
}

/// Pixels that are wrong where this is drawn and that is wanted.
fn mismatched(devices: &Devices, drawn: &Divided, wanted: &Divided) -> usize {
    let mut draws = Interface::Wgpu
        .open(devices, drawn, &mut Addressed::default())
        .expect("opens");
    draws.frame().expect("draws");
    let numbers = ids_of(&draws.read().expect("a picture"));
    let reference = Reference::new(wanted, &wanted.corners());
    reference.judge(&numbers, &reference.picture()).mismatched
}

#[test]
fn a_shifted_corner_a_wrong_level_swapped_axes_and_a_moved_line_are_noticed() {
    let Some(devices) = devices() else {
        return;
    };
    let all = groups(false).concat();
    let find = |part: fn(Part) -> bool, extent, is_tested| {
        let mut own = all
            .iter()
            .filter(|work| part(work.part) && work.extent == extent);
        let fits = |work: &&Work| {
            work.from == Vantage::Oblique
                && work.division == Division::Fixed(10)
                && work.is_tested == is_tested
        };
        own.find(fits).expect("a case").divided(SIDE, None)
    };
    let decal = find(|part| part == Part::Decal, Extent::Country, false);
    let tested = find(|part| part == Part::Decal, Extent::Country, true);
    let line = find(|part| part != Part::Decal, Extent::Country, false);
    for wanted in [decal, tested, line] {
        assert_eq!(mismatched(&devices, &wanted, &wanted), 0);
    }
    // By a pixel to the north, which at this distance is some hundredth of the extent.
    let pixel = Extent::Country.angle() / 100.0;
    let moved = |of: Divided| Divided {
        data: Data {
            corner: of.data.corner + DVec2::Y * pixel,
            ..of.data
        },
        ..of
    };
    let level = Divided { cells: 2, ..decal };
    let Shape::Decal(size) = decal.data.shape else {
        panic!("a decal");
    };
    let size = Shape::Decal(DVec2::new(size.y, size.x));
    let swapped = Divided {
        data: Data {
            shape: size,
            ..decal.data
        },
        ..decal
    };
    let low = Divided {
        series: Series::First,
        ..decal
    };
    let untested = Divided {
        is_tested: false,
        ..tested
    };
    for (what, drawn, wanted) in [
        ("corner", moved(decal), decal),
        ("level", level, decal),
        ("axes", swapped, decal),
        ("order", low, decal),
        ("lift", untested, tested),
        ("line", moved(line), line),
    ] {
        let wrong = mismatched(&devices, &drawn, &wanted);
        assert!(wrong > 10, "{what}: {wrong}");
    }
    // Swapped axes of the texture, and a single pixel of another texel.
    let mut draws = Interface::Wgpu
        .open(&devices, &decal, &mut Addressed::default())
        .expect("opens");
    draws.frame().expect("draws");
    let right = ids_of(&draws.read().expect("a picture"));
    let reference = Reference::new(&decal, &decal.corners());
    let truth = reference.picture();
    let turned = right
        .iter()
        .map(|shown| match texels(decal.data.shape, *shown) {
            Some([x, y]) => number(decal.data.shape, [y, x]),
            None => 0,
        });
    let turned: Vec<u32> = turned.collect();
    assert!(reference.judge(&turned, &truth).mismatched > 1_000);
    let shown = right
        .iter()
        .position(|shown| *shown > 0)
        .expect("it is seen");
    for other in [0, 1, right[shown] + 40] {
        let mut wrong = right.clone();
        wrong[shown + 3] = other;
        assert_eq!(reference.judge(&wrong, &truth).mismatched, 1, "{other}");
    }
}

#[test]
fn counting_stops_where_no_more_is_counted() {
    let of = |counts: &[u64]| {
        let mut counts = counts.iter();
        by_counts(|_| counts.next().copied().ok_or("asked too often"))
            .map(|found| (found.cells, found.frames))
    };
    assert_eq!(of(&[100, 110, 112, 112]), Ok((4, 4)));
    // What shrinks when it is divided stops at once, and so does what is hidden.
    assert_eq!(of(&[100, 90]), Ok((1, 2)));
    assert_eq!(of(&[0, 0]), Ok((1, 2)));
    assert!(of(&[100, 101]).is_err());
}

#[test]
fn a_quick_run_has_a_chapter_and_its_requirements_hold() {
    let request = Request {
        depth: Depth::Quick,
        samples: Some(1),
        size: [SIDE; 2],
        names_size: true,
        ..Request::default()
    };
    let run = measured(&DecalsStudy, &request);
    let blocks = CHAPTER.blocks(&run).expect("a chapter");
    let headings = blocks
        .iter()
        .filter(|block| matches!(block, Block::Heading { .. }));
    assert!(headings.count() >= 5);
    assert!(
        blocks
            .iter()
            .any(|block| matches!(block, Block::Pictures(_)))
    );
    for finding in CHAPTER.answers(&run).expect("answers").requirements {
        eprintln!("{finding:?}");
        assert_ne!(finding.standing, Standing::DoesNotHold);
    }
}
