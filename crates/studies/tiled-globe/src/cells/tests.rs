// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames against the number of cells: on a device, and of made-up times.

use super::*;
use crate::metrics::GLOBE_TRIANGLES;
use crate::views::tiled_view;
use terrafill_fixtures::on_device::{self, figure, on_device};
use terrafill_globe_views::{STUDY, whole};
use terrafill_lab::Cases;
use terrafill_results::made_up::MadeUpRun;
use terrafill_results::{Block, Clock, Finding, Standing, Status};
use terrafill_screen_grid::ScreenGridKind;
use terrafill_study::Group as _;

#[test]
fn every_number_of_cells_draws_from_the_same_tiles_and_shows_what_it_should() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let opened = Rc::new(Opened::new(&[&ScreenGridKind]));
        let group = planned(&tiled_view("tilted-100km"), (120, 1), &opened);
        let mut session = group.open(context).expect("opens");
        let (mut counts, mut shown) = (Vec::new(), Vec::new());
        for (case, options) in group.work.options.iter().enumerate() {
            if ![1, 2, 10].contains(&options.n) {
                continue;
            }
            let verdict = on_device::verdict(&mut *session, case, options);
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
            assert!(session.time(case).is_ok());
            counts.push(figure(&verdict, "globe_tile_count"));
            shown.push(figure(&verdict, "globe_tile_px"));
        }
        assert!(counts.len() == 6 && counts.iter().all(|count| *count == counts[0]));
        assert!(shown.iter().all(|px| *px == 120.0 * 120.0), "{shown:?}");
        // Negative control: a limb moves with N.
        let group = planned(&tiled_view("globe"), (120, 1), &opened);
        let mut session = group.open(context).expect("opens");
        let verdict = on_device::verdict(&mut *session, 0, &group.work.options[0]);
        assert_eq!(verdict.status, Status::Wrong);
        assert!(verdict.reason.contains("no surface"), "{}", verdict.reason);
    });
}

#[test]
fn chosen_tiles_are_drawn_and_a_frame_chooses_the_same_again() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let opened = Rc::new(Opened::new(&[&ScreenGridKind]));
        let group = choosing(&tiled_view("globe-antimeridian"), (160, 1), &opened);
        let mut session = group.open(context).expect("opens");
        for (case, options) in group.work.options.iter().enumerate() {
            let verdict = on_device::verdict(&mut *session, case, options);
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
            assert_eq!(figure(&verdict, "globe_tile_wrong_px"), 0.0);
            // With enough corners hardly a pixel is nearer than all of its own.
            let share =
                figure(&verdict, "globe_tile_missing_px") / figure(&verdict, "globe_tile_px");
            assert!(options.n < 20 || share < 0.01, "{share}");
            let times = session.time(case).expect("times");
            assert!(times.iter().any(|(name, _)| *name == "globe_choose_cpu_ms"));
        }
    });
}

/// Findings and blocks on frames of 10 ms that grow by `us` a triangle, in `processes`.
fn section(us: f64, processes: usize) -> (Vec<Finding>, Vec<Block>) {
    let opened = Rc::new(Opened::new(&[&ScreenGridKind]));
    let group = planned(&tiled_view("tilted-100km"), (8, 1), &opened);
    let mut run = MadeUpRun::default();
    for case in &group.cases {
        let n: f64 = case.id.condition("n").parse().expect("a number");
        // A ripple, so that a line leaves something over.
        // Some triangles are split.
        let triangles = 2.0 * n * n + 4.0;
        let ms = 10.0 + 1e-3 * us * triangles + 0.001 * (n % 2.0);
        let metric = whole(Clock::ProcessCpu);
        if n == 1.0 {
            run.case(case.id.repeat())
                .timed(metric, &vec![1.001 * ms; processes]);
        }
        let case = run.case(case.id.clone());
        case.timed(metric, &vec![ms; processes]);
        case.figure(GLOBE_TRIANGLES, triangles);
    }
    let run = run.loaded();
    let blocks = SECTION
        .blocks(&Cases::of_study(&run, STUDY))
        .expect("blocks");
    let findings = blocks.iter().filter_map(|block| match block {
        Block::Finding(found) => Some(found.clone()),
        _ => None,
    });
    (findings.collect(), blocks)
}

#[test]
fn a_trend_is_told_from_none_and_the_published_times_stand_beside() {
    let standing = |us, processes| {
        let (findings, _) = section(us, processes);
        assert_eq!(findings.len(), 2);
        findings[0].standing
    };
    assert_eq!(standing(10.0, 5), Standing::Holds);
    assert_eq!(standing(0.0, 5), Standing::NoDifference);
    // Controls: times that fall, and too few processes for any verdict.
    assert_eq!(standing(-10.0, 5), Standing::DoesNotHold);
    assert_eq!(standing(10.0, 1), Standing::CannotTell);
    let (findings, blocks) = section(10.0, 5);
    let words = &findings[0].because;
    // Slope and ratio have the same processes, and the ends are what was drawn.
    assert!(
        words.contains("tilted-100km: 10.0 [10.0–10.0] µs a triangle, so 1.20 × [1.20–1.20] from 6 triangles to 204"),
        "{words}"
    );
    assert!(
        words.contains("1.40 µs a triangle (-0.725 … 3.52), p = 0.167"),
        "{words}"
    );
    let plot = blocks.iter().find_map(|block| match block {
        Block::Plot(plot) => Some(&plot.svg),
        _ => None,
    });
    assert!(plot.is_some_and(|svg| svg.contains("published") && svg.contains("tilted-100km")));
}
