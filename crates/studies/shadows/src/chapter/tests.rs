// SPDX-License-Identifier: MIT OR Apache-2.0
//! Findings stand and fall by their figures.

use super::*;
use crate::metrics::*;
use terrafill_results::made_up::{MadeUpRun, case_id};
use terrafill_results::{Chapter as _, Standing};

pub(super) fn finding(run: &MadeUpRun, claim: &str) -> Option<Standing> {
    let run = run.loaded();
    let own = Own(Cases::of_study(&run, crate::STUDY));
    let mut found = own.findings().into_iter().chain(own.controls());
    let found = found.find(|finding| finding.claim.contains(claim));
    found.map(|finding| finding.standing)
}

pub(super) fn with(
    question: &str,
    conditions: &[(&str, &str)],
    metric: impl Into<&'static str>,
    value: f64,
    run: &mut MadeUpRun,
) {
    let mut all = vec![("question", question)];
    all.extend(conditions);
    let name: Vec<&str> = all.iter().map(|(_, value)| *value).collect();
    run.case(case_id(crate::STUDY, &name.join("/"), &all))
        .figure(metric, value);
}

fn updates(values: [f64; 4]) -> MadeUpRun {
    let mut run = MadeUpRun::default();
    let ways = [
        ("infinite", "z-pass"),
        ("infinite", "z-fail"),
        ("sea-closed", "z-pass"),
        ("sea-closed", "z-fail"),
    ];
    for ((extent, rule), value) in ways.into_iter().zip(values) {
        let conditions = [("sun", "5° from 0°"), ("extent", extent), ("rule", rule)];
        with("updates", &conditions, UPDATES, value, &mut run);
    }
    run
}

#[test]
fn claims_stand_and_fall_by_their_figures() {
    let cheap = updates([12.0, 41.0, 12.0, 7.5]);
    // Negative control: the other way round.
    let dear = updates([12.0, 41.0, 12.0, 43.0]);
    use Standing::{DoesNotHold, Holds};
    for (claim, standings) in [
        ("z-pass writes less", [DoesNotHold, Holds]),
        ("Closing volumes", [Holds, DoesNotHold]),
        ("at 5° and below", [Holds, DoesNotHold]),
    ] {
        let found = [&cheap, &dear].map(|run| finding(run, claim));
        assert_eq!(found, standings.map(Some), "{claim}");
    }
    assert_eq!(finding(&cheap, "clears"), None, "not measured");
}

#[test]
fn a_way_is_faster_where_it_is_under_every_sun() {
    let times = |low_ms: f64| {
        let way = |sun, faces| [("question", "devices"), ("sun", sun), ("faces", faces)];
        let run = device_run(&[
            (&way("60°", "two-sided"), 1.0),
            (&way("60°", "two-pass"), 2.0),
            (&way("5°", "two-sided"), low_ms),
            (&way("5°", "two-pass"), 2.0),
        ]);
        finding(&run, "Two-sided stencil is faster")
    };
    assert_eq!(times(1.5), Some(Standing::Holds));
    assert_eq!(times(3.0), Some(Standing::DoesNotHold));
}

fn device_run(cases: &[(&[(&'static str, &'static str)], f64)]) -> MadeUpRun {
    let mut run = MadeUpRun::default();
    for (at, (conditions, ms)) in cases.iter().enumerate() {
        let id = case_id(crate::STUDY, &at.to_string(), conditions);
        let case = run.case(id);
        case.figure("shadow_false_lit_px", 0.0);
        case.figure("shadow_false_dark_px", 0.0);
        case.timed(FILL_CPU, &[*ms; 7]);
    }
    run
}

#[test]
fn a_ablation_compares_each_step_with_the_last_that_was_drawn() {
    let ablation = |two_sided: f64| {
        let step = |step, paper| {
            [
                ("question", "ladder"),
                ("sun", "5°"),
                ("api", "wgpu"),
                ("step", step),
                ("paper", paper),
            ]
        };
        let run = device_run(&[
            (&step("1 each triangle", "not in the paper"), 9.0),
            (&step("2 silhouette", "anticipated: faster"), 3.0),
            (&step("3 two-sided", "anticipated: faster"), two_sided),
            (&step("4 closed", "not in the paper"), 4.0),
        ]);
        finding(&run, "Each step of the ablation")
    };
    assert_eq!(ablation(2.0), Some(Standing::Holds));
    // Negative control: slower than the step before, not than the first.
    assert_eq!(ablation(5.0), Some(Standing::DoesNotHold));
}

#[test]
fn a_curve_of_maps_is_the_other_program_s_or_it_is_not() {
    let curve = |at_a_metre: f64| {
        let mut run = MadeUpRun::default();
        for (texel, wrong) in [("0.25", 1.6), ("1", at_a_metre)] {
            let conditions = [
                ("sun", "10° from -60°"),
                ("texel_m", texel),
                ("bias", "constant, no normals"),
            ];
            let metric = "shadow_map_wrong_in_three";
            with("maps", &conditions, metric, wrong, &mut run);
        }
        finding(&run, "as another program has it")
    };
    assert_eq!(curve(4.1), Some(Standing::Holds));
    assert_eq!(curve(1.9), Some(Standing::DoesNotHold));
}

#[test]
fn rivals_stand_beside_volumes_of_their_interface() {
    let rivals = |rays: f64| {
        let volumes = |api| {
            [
                ("question", "devices"),
                ("sun", "5°"),
                ("api", api),
                ("extent", "sea-closed"),
                ("rule", "z-fail"),
                ("faces", "two-sided"),
                ("scissor", "off"),
                ("depth_bounds", "off"),
                ("silhouette", "adjacency"),
            ]
        };
        let rival = [
            ("question", "rivals"),
            ("sun", "5°"),
            ("api", "vulkan"),
            ("rival", "ray query"),
        ];
        let run = device_run(&[
            (&volumes("wgpu"), 9.0),
            (&volumes("vulkan"), 2.0),
            (&rival, rays),
        ]);
        finding(&run, "Volumes closed at the sea are faster than rivals")
    };
    assert_eq!(rivals(5.0), Some(Standing::Holds));
    assert_eq!(rivals(1.0), Some(Standing::DoesNotHold));
}

#[test]
fn tiles_are_not_compared_by_a_clock_that_leaves_out_their_read_back() {
    let of = |device_type: &str, bounds: &str| {
        let way = |bounds| {
            [
                ("question", "devices"),
                ("api", "wgpu"),
                ("depth_bounds", bounds),
            ]
        };
        let mut run = MadeUpRun {
            metrics: crate::metrics::METRICS.to_vec(),
            ..MadeUpRun::default()
        };
        run.environment.device_type = device_type.to_owned();
        run.environment.gpu_timestamps = true;
        for (bounds, ms) in [("off", 2.0), (bounds, 1.0)] {
            let name = format!("devices/{bounds}");
            let case = run.case(case_id(crate::STUDY, &name, &way(bounds)));
            case.timed(FILL_CPU, &[ms; 5]).timed(FILL_GPU, &[ms; 5]);
        }
        finding(&run, "Depth bounds are faster")
    };
    assert_eq!(of("cpu", "tiles"), Some(Standing::Holds));
    assert_eq!(of("discrete-gpu", "discard"), Some(Standing::Holds));
    // Negative control: what a GPU's clock does not cover has no verdict by it.
    assert_eq!(of("discrete-gpu", "tiles"), None);
}

#[test]
fn a_row_that_wraps_where_it_must_not_is_no_agreement() {
    let rows = |lost_of_257: f64| {
        let mut run = MadeUpRun::default();
        for (count, lost) in [
            ("255", 0.0),
            ("256", 100.0),
            ("257", lost_of_257),
            ("511", 0.0),
            ("512", 100.0),
        ] {
            for (counting, lost) in [("8 bits, wrapping", lost), ("passes of 255", 0.0)] {
                let conditions = [("casters", count), ("counting", counting)];
                with("rows", &conditions, LOST, lost, &mut run);
            }
        }
        finding(&run, "Eight bits")
    };
    assert_eq!(rows(0.0), Some(Standing::Holds));
    assert_eq!(rows(3.0), Some(Standing::DoesNotHold));
}

#[test]
fn a_twin_that_is_right_is_noticed() {
    let standing = |wrong: f64| {
        let mut run = MadeUpRun::default();
        let conditions = [("question", "rows"), ("counting", "8 bits, wrapping")];
        let case = run.case(case_id(crate::STUDY, "rows/256", &conditions));
        case.figure("shadow_false_lit_px", wrong);
        case.figure("shadow_false_dark_px", 0.0);
        finding(&run, "that must be wrong are wrong")
    };
    assert_eq!(standing(40.0), Some(Standing::Holds));
    assert_eq!(standing(0.0), Some(Standing::DoesNotHold));
}

#[test]
fn a_question_that_was_measured_has_a_table_and_others_have_none() {
    let run = updates([12.0, 41.0, 12.0, 7.5]);
    let folder = tempfile::tempdir().expect("a folder");
    let run = run.write(folder.path()).expect("a run");
    let blocks = CHAPTER.blocks(&run).expect("a chapter");
    let count = |is_it: fn(&Block) -> bool| blocks.iter().filter(|block| is_it(block)).count();
    // Its own, and that of the claims.
    assert_eq!(count(|block| matches!(block, Block::Table(_))), 2);
    assert_eq!(count(|block| matches!(block, Block::Plot(_))), 1);
    let mut other = MadeUpRun::default();
    other.case(case_id("filling", "a", &[]));
    let other = other.write(&folder.path().join("other")).expect("a run");
    assert_eq!(CHAPTER.blocks(&other).expect("a chapter"), []);
}

#[test]
fn the_paper_s_scissor_stands_by_shadows_above_the_sea_and_falls_by_those_on_it() {
    use Standing::{DoesNotHold, Holds};
    let claims = |[above, horizon, all, caster]: [f64; 4]| {
        let mut run = MadeUpRun::default();
        for (scissor, counted, lost) in [
            ("sea-level", "above the sea", above),
            ("horizon", "above the sea", horizon),
            ("sea-level", "", all),
            ("caster-rect", "", caster),
        ] {
            let conditions = [("scissor", scissor), ("counted", counted)];
            let named = &conditions[..if counted.is_empty() { 1 } else { 2 }];
            with("scissors", named, LOST, lost, &mut run);
        }
        ["loses no shadow above sea level", "there is no shadow"].map(|of| finding(&run, of))
    };
    assert_eq!(
        claims([0.0, 60.0, 40.0, 0.0]),
        [Some(Holds), Some(DoesNotHold)]
    );
    // Negative control: the other way round.
    assert_eq!(
        claims([60.0, 0.0, 0.0, 40.0]),
        [Some(DoesNotHold), Some(Holds)]
    );
}

#[test]
fn one_range_of_depths_drops_what_is_beyond_it_and_that_alone() {
    use Standing::{DoesNotHold, Holds};
    let claim = |lost: f64, inside: f64| {
        let mut run = MadeUpRun::default();
        for (counted, metric, value) in [
            ("", "shadow_lost_share", lost),
            ("in the range", "shadow_false_lit_px", inside),
        ] {
            let conditions = [
                ("question", "bounds"),
                ("depth_bounds", "on, one range"),
                ("counted", counted),
            ];
            let named = &conditions[..if counted.is_empty() { 2 } else { 3 }];
            let case = run.case(case_id(crate::STUDY, &named.len().to_string(), named));
            case.figure(metric, value);
            case.figure("shadow_false_dark_px", 0.0);
        }
        finding(&run, "drops shadowed points beyond it")
    };
    assert_eq!(claim(12.0, 0.0), Some(Holds));
    // Negative controls: it drops nothing, and something within.
    assert_eq!(claim(0.0, 0.0), Some(DoesNotHold));
    assert_eq!(claim(12.0, 1.0), Some(DoesNotHold));
}

#[test]
fn a_count_of_no_fragments_where_pixels_are_in_shadow_is_an_empty_cell_with_its_reason() {
    let cell = |counted: f64, shadow: f64, note: &str| {
        let mut run = MadeUpRun::default();
        let conditions = [("question", "devices"), ("api", "wgpu")];
        let case = run.case(case_id(crate::STUDY, "a", &conditions));
        case.figure("shadow_px", shadow).note("miscounted", note);
        if counted >= 0.0 {
            case.figure("shadow_fragments", counted);
        }
        let run = run.loaded();
        let cases = Cases::of_study(&run, crate::STUDY);
        let case = cases.first().expect("a case");
        let cell = sections::FRAGMENTS.cell(&cases, case);
        (cell.text, cell.title)
    };
    let (text, why) = cell(0.0, 3_000.0, "");
    assert!(
        !text.contains('0') && why.contains("takes a fragment"),
        "{text} {why}"
    );
    let (_, why) = cell(-1.0, 3_000.0, "0 of 3000");
    assert_eq!(why, "0 of 3000");
    // Negative controls: a count, and no shadow to count.
    assert_eq!(cell(22.0, 3_000.0, "").0, "22.0");
    assert!(cell(0.0, 0.0, "").0.contains('0'));
}

#[test]
fn a_frame_is_within_a_budget_where_its_interval_is() {
    let standings = |ms: f64, processes: usize| {
        let mut run = MadeUpRun::default();
        let conditions = [
            ("question", "harbour"),
            ("view", "bridge"),
            ("sun", "10°"),
            ("api", "wgpu"),
        ];
        let case = run.case(case_id(crate::STUDY, "a", &conditions));
        case.timed(crate::metrics::FRAME_WALL, &vec![ms; processes]);
        ["28.6 ms", "41.7 ms"].map(|of| finding(&run, of))
    };
    use Standing::{CannotTell, DoesNotHold, Holds};
    assert_eq!(standings(20.0, 7), [Some(Holds); 2]);
    assert_eq!(standings(30.0, 7), [Some(DoesNotHold), Some(Holds)]);
    // Negative controls: over both, and one process, which has no interval.
    assert_eq!(standings(50.0, 7), [Some(DoesNotHold); 2]);
    assert_eq!(standings(20.0, 1), [Some(CannotTell); 2]);
}

#[test]
fn a_value_for_each_model_stands_by_its_clears_its_picture_and_its_time() {
    let of = |clears: f64, unlike: f64, ms: f64| {
        let mut run = MadeUpRun {
            metrics: crate::metrics::METRICS.to_vec(),
            ..MadeUpRun::default()
        };
        for (way, clears, unlike, ms) in [("clear", 255.0, 0.0, 2.0), ("value", clears, unlike, ms)]
        {
            let conditions = [
                ("question", "outlines"),
                ("stroke_px", "3"),
                ("models", "255"),
                ("outline", way),
            ];
            let name = format!("outlines/{way}");
            run.case(case_id(crate::STUDY, &name, &conditions))
                .figure(SHADOW_CLEARS, clears)
                .figure(SHADOW_CONTOUR_PX, 0.0)
                .figure(SHADOW_OUTLINE_UNLIKE_PX, unlike)
                .timed(OUTLINE_CPU_MS, &[ms; 5]);
        }
        let claims = [
            "takes 1 + ⌊N/255⌋ clears",
            "leaves out the same",
            "is faster than a clear",
        ];
        claims.map(|claim| finding(&run, claim))
    };
    use Standing::{DoesNotHold, Holds};
    assert_eq!(of(2.0, 0.0, 1.0), [Some(Holds); 3]);
    // Negative controls: a clear too many, a pixel that differs, and no time gained.
    assert_eq!(of(3.0, 1.0, 3.0), [Some(DoesNotHold); 3]);
}
