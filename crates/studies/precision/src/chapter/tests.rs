// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests of the chapter on made-up runs.

use super::data::{DEFAULT_POSITION, DRAWN, Data, MIDDLE, PLAN};
use super::findings::findings;
use super::plots::ulp;
use super::tables::{disagreements, positions, row};
use super::*;
use terrafill_results::made_up::{MadeUpCase, MadeUpRun, case_id};
use terrafill_results::{CellClass, Row, Standing, Status};

/// A coordinate route in the region of 1°.
fn route<'a>(run: &'a mut MadeUpRun, family: &str, knob: &str, error_m: f64) -> &'a mut MadeUpCase {
    let (route, condition) = (format!("{family}-{knob}"), DRAWN[1].0);
    let conditions = [
        ("part", "coordinate"),
        ("route", &route),
        ("family", family),
        ("knob", knob),
        ("condition", condition),
        ("extent_deg", "1"),
        ("latitude_deg", "45"),
        ("highest_m", "9000"),
    ];
    let name = format!("coordinate/{route}/{condition}");
    run.case(case_id(crate::STUDY, &name, &conditions))
        .figure("points", 100.0)
        .figure("device_max_m", error_m)
        .figure("device_rms_m", 0.4 * error_m)
        .figure("max_over_residual", 0.8)
        .figure("measured_over_expected", 0.9)
        .figure("texture_px", 4096.0)
        .figure("rms_texels", 0.02)
        .figure("max_texels", 0.06)
        .figure("operations_cost", 12.0)
}

fn time(run: &mut MadeUpRun, route: &str, ns: f64) {
    let conditions = [
        ("part", "time"),
        ("of_part", "coordinate"),
        ("route", route),
    ];
    let name = format!("time/coordinate/{route}");
    run.case(case_id(crate::STUDY, &name, &conditions))
        .timed("cpu_ns", &[ns, ns, ns]);
}

/// Three routes, the first of which a plan takes.
fn routes() -> MadeUpRun {
    let mut run = MadeUpRun::default();
    route(&mut run, "gnomonic", "3", 0.3).figure("chosen", 1.0);
    route(&mut run, "gnomonic", "2", 4.0);
    route(&mut run, "odd", "7", 500.0);
    time(&mut run, "gnomonic-3", 0.5);
    time(&mut run, "gnomonic-2", -0.1);
    run
}

fn position(run: &mut MadeUpRun, anchor: &str, distance_m: f64, error_m: f64) {
    let (distance, pixel_m) = (distance_m.to_string(), distance_m * 1.07e-3);
    let condition = format!("distance={distance};anchor={anchor};error={error_m}");
    let conditions = [
        ("part", "position"),
        ("route", DEFAULT_POSITION.0),
        ("depth_format", DEFAULT_POSITION.1),
        ("anchor", anchor),
        ("condition", condition.as_str()),
        ("distance_m", distance.as_str()),
    ];
    run.case(case_id(
        crate::STUDY,
        &format!("position/{condition}"),
        &conditions,
    ))
    .figure("device_max_m", error_m)
    .figure("pixel_m", pixel_m)
    .figure("max_px", error_m / pixel_m);
}

fn blocks(run: &MadeUpRun) -> Vec<Block> {
    PrecisionChapter.blocks(&run.loaded()).expect("a chapter")
}

#[test]
fn each_family_is_a_curve_with_its_time_and_its_errors() {
    let blocks = blocks(&routes());
    let plot = blocks.iter().find_map(|block| match block {
        Block::Plot(plot) => Some(plot),
        _ => None,
    });
    let svg = &plot.expect("a plot").svg;
    for word in [
        "gnomonic",
        "odd",
        "¼ texel",
        "Error against operations",
        "process CPU time",
    ] {
        assert!(svg.contains(word), "{word}");
    }
    let run = routes().loaded();
    let is_timed = |route| Data::new(&run).time(route).is_some();
    assert!(is_timed("gnomonic-3") && !is_timed("odd-7"));
    // Below the timer's resolution, and drawn there.
    assert!(is_timed("gnomonic-2"));
    let table = blocks.iter().find_map(|block| match block {
        Block::Table(table) => Some(table),
        _ => None,
    });
    let cells = &table.expect("what a plan takes").rows[0].cells;
    assert_eq!(cells[1].text, "gnomonic-3 · 0.0200");
}

#[test]
fn a_plan_that_takes_too_coarse_a_route_is_called_out() {
    let standing = |change: &dyn Fn(&mut MadeUpCase)| {
        let mut run = routes();
        change(&mut run.cases[0]);
        findings(&Data::new(&run.loaded())).remove(0).standing
    };
    assert_eq!(standing(&|_| ()), Standing::Holds);
    let coarse = |case: &mut MadeUpCase| {
        case.figure("rms_texels", 0.3);
    };
    let above_its_bound = |case: &mut MadeUpCase| {
        case.ended(Status::Wrong, "above its bound");
    };
    let not_finite = |case: &mut MadeUpCase| {
        case.figure("non_finite_device", 1.0);
    };
    let changes: [&dyn Fn(&mut MadeUpCase); 3] = [&coarse, &above_its_bound, &not_finite];
    for change in changes {
        assert_eq!(standing(change), Standing::DoesNotHold);
    }
}

#[test]
fn positions_count_where_a_plan_puts_the_anchor_and_the_middle_stands_beside() {
    let found = |largest_at_20_m: f64| {
        let mut run = MadeUpRun::default();
        position(&mut run, PLAN, 20.0, 4e-6);
        position(&mut run, PLAN, 20.0, largest_at_20_m);
        position(&mut run, PLAN, 1e3, 2e-4);
        position(&mut run, MIDDLE, 20.0, 3.8e-3);
        position(&mut run, MIDDLE, 10.0, 4.2e-3);
        let run = run.loaded();
        let data = Data::new(&run);
        (findings(&data), positions(&data))
    };
    let (good, table) = found(5e-6);
    assert_eq!([good[0].standing, good[1].standing], [Standing::Holds; 2]);
    assert!(
        good[0]
            .claim
            .contains("in the middle of the region: 0.00380 m")
    );
    assert!(
        good[1].claim.contains("0.393 of a pixel"),
        "{}",
        good[1].claim
    );
    assert_eq!(table.len(), 2);
    assert!(table[1].cells[0].text.ends_with("anchor=middle"));
    assert!(
        table[0].cells[1].text.starts_with("5.00e-6 m"),
        "the worst region"
    );
    // Negative control: one region that is worse than the limit is enough.
    let bad = found(2e-4).0;
    assert_eq!(
        [bad[0].standing, bad[1].standing],
        [Standing::DoesNotHold, Standing::Holds]
    );
    assert_eq!(found(8e-3).0[1].standing, Standing::DoesNotHold);
}

#[test]
fn reasons_are_counted_and_a_row_without_one_is_called_out() {
    let mut run = routes();
    route(&mut run, "odd", "9", 300.0);
    for (case, ratio, reason) in [
        (1, 0.3, "few places"),
        (2, 0.2, "few places"),
        (5, 4.0, "the device's own"),
    ] {
        run.cases[case]
            .figure("measured_over_expected", ratio)
            .note("residual_reason", reason);
    }
    let found = |run: &MadeUpRun| {
        let run = run.loaded();
        let data = Data::new(&run);
        (disagreements(&data), findings(&data).pop().expect("some"))
    };
    let (rows, last) = found(&run);
    let texts = |row: &Row| [0, 1, 2, 5].map(|at| row.cells[at].text.clone());
    // The more frequent reason is first.
    assert_eq!(
        texts(&rows[0]),
        ["gnomonic", "1", "0.300 … 0.300", "few places"]
    );
    assert_eq!(
        texts(&rows[2]),
        ["odd", "1", "4.00 … 4.00", "the device's own"]
    );
    assert!(last.claim.contains("in 1 of 4 rows") && last.standing == Standing::Holds);
    run.cases[5].note("residual_reason", "no reason known");
    let (rows, last) = found(&run);
    assert_eq!(last.standing, Standing::DoesNotHold);
    assert_eq!(rows[0].cells[1].class, CellClass::Bad);
}

#[test]
fn what_is_bad_is_red_and_a_run_without_the_study_has_no_chapter() {
    let classes = |is_bad| {
        let row = row("a", ["1".to_owned(), "–".to_owned()], is_bad);
        row.cells.into_iter().map(|cell| cell.class)
    };
    assert!(classes(true).eq([CellClass::Name, CellClass::Bad, CellClass::Absent]));
    assert!(classes(false).eq([CellClass::Name, CellClass::Plain, CellClass::Absent]));
    assert_eq!(blocks(&MadeUpRun::default()), []);
}

#[test]
fn units_in_the_last_place() {
    assert!((ulp(std::f64::consts::PI) - 2.384e-7).abs() < 1e-10);
    assert!((ulp(1.0) - f64::from(f32::EPSILON)).abs() < 1e-15);
}
