// SPDX-License-Identifier: MIT OR Apache-2.0
//! A chosen half of the extreme suite in small pictures, and the suite's own verdicts: each expectation
//! that is turned round must fail.
//!
//! Left to `bench --suite extreme`: what takes a second or more to mesh, to draw or to judge. Skipped
//! without a device; see `vertex_against_reference.rs`.

use crate::runs::{self, OPTIONS, has_device};
use std::collections::BTreeSet;
use std::path::Path;
use terrafill_compute::ComputeTechnique;
use terrafill_filling::{EXTREME, ExtremeStudy, FillingStudy, Techniques, extreme_sentence};
use terrafill_instanced::InstancedTechnique;
use terrafill_native::NativeTechnique;
use terrafill_results::{Block, Outcome, Row, Run};
use terrafill_scene::{Expectation, Scene, SuiteScene, suite_names, suite_scenes};
use terrafill_study::{Depth, Request, Study, plan};
use terrafill_surface::EllipsoidKind;
use terrafill_vertex::VertexTechnique;

const TECHNIQUES: Techniques = &[
    &VertexTechnique,
    &ComputeTechnique,
    &NativeTechnique,
    &InstancedTechnique,
];

const SUITE: ExtremeStudy = ExtremeStudy {
    techniques: TECHNIQUES,
    surfaces: &[&EllipsoidKind],
};

/// Scenes of the bare body that mesh and draw in a moment.
const FAST_HALF: [&str; 17] = [
    "poles",
    "antimeridian",
    "hemisphere",
    "strips-170",
    "world-minus-hole",
    "rings-512",
    "horizon",
    "strips-half-metre",
    "shared-borders",
    "bow-tie",
    "bow-tie-repaired",
    "degenerate",
    "smaller-than-a-pixel",
    "nothing-in-view",
    "below-the-ellipsoid",
    "empty",
    "antipodal-edge",
];

fn request(scenes: &[&str], size: u32) -> Request {
    Request {
        scenes: scenes.iter().map(ToString::to_string).collect(),
        techniques: vec!["vertex".to_owned()],
        size: [size, size],
        ..Request::default()
    }
}

fn measured(out: &Path, request: &Request) -> Run {
    // Most figures are those of the study `filling`.
    let filling = FillingStudy {
        techniques: TECHNIQUES,
        rivals: &[],
        surfaces: &[],
    };
    let metrics = [filling.metrics(), SUITE.metrics()].concat();
    runs::measured(&SUITE, &metrics, out, request)
}

#[test]
fn the_fast_half_is_right_or_refused_as_it_should_be() {
    if !has_device() {
        return;
    }
    // Every scene by vertices and by one of the others, which take turns.
    let [first, others @ ..] = TECHNIQUES else {
        panic!("no technique");
    };
    for (turn, other) in others.iter().enumerate() {
        let place = tempfile::tempdir().expect("a folder");
        let scenes = FAST_HALF.into_iter().skip(turn).step_by(others.len());
        let scenes: Vec<&str> = scenes.collect();
        let run = measured(
            place.path(),
            &Request {
                techniques: [first, other].map(|one| one.name().to_owned()).into(),
                ..request(&scenes, 96)
            },
        );
        assert_all_as_expected(&run, scenes.len());
    }
}

fn assert_all_as_expected(run: &Run, scenes: usize) {
    eprintln!("{}", extreme_sentence(run).expect("cases"));
    let mut faults = Vec::new();
    for case in &run.cases {
        if case.outcome != Outcome::Ok {
            faults.push(format!(
                "{}: {:?}, {}",
                case.id(),
                case.outcome,
                case.reason
            ));
        }
        // Whoever sees no boundary says why, after the remark.
        if let Some((_, "")) = case.reason.split_once("this view checks nothing") {
            faults.push(format!(
                "{}: sees no boundary and does not say why",
                case.id()
            ));
        }
    }
    assert_eq!(faults, Vec::<String>::new());
    let chapter = SUITE.chapter();
    assert_eq!(chapter.contradictions(run), Vec::<String>::new());
    let rows = summary_rows(run);
    assert_eq!(rows.len(), scenes);
    for row in &rows {
        let [views, passed, refused, failed] = ends(row);
        assert_eq!((passed + refused, failed), (views, 0), "{}", row[0]);
    }
}

/// Views of a scene's row, and how many of them passed, were refused rightly, and failed.
fn ends(row: &[String]) -> [u32; 4] {
    [2, 3, 4, 5].map(|column| row[column].parse().expect("a count"))
}

/// Cells of the table with a row for each scene.
fn summary_rows(run: &Run) -> Vec<Vec<String>> {
    let blocks = SUITE.chapter().blocks(run).expect("blocks");
    let tables = blocks.into_iter().filter_map(|block| match block {
        Block::Table(table) => Some(table),
        _ => None,
    });
    let summary = tables.into_iter().next().expect("a table");
    let texts = |row: Row| row.cells.into_iter().map(|cell| cell.text).collect();
    summary.rows.into_iter().map(texts).collect()
}

/// Negative control: the same scenes with what they expect turned round.
#[test]
fn an_expectation_turned_round_fails_whichever_way() {
    if !has_device() {
        return;
    }
    let place = tempfile::tempdir().expect("a folder");
    let text = |name: &str| {
        let scenes = suite_scenes(EXTREME).expect("a suite");
        let file = format!("extreme/{name}.toml");
        let found = scenes.iter().find(|(known, _)| *known == file);
        found.expect("in the suite").1
    };
    let mut scenes = Vec::new();
    for (name, from, to) in [
        (
            "bow-tie-repaired",
            "expect = \"fills\"",
            "expect = \"refused: cross\"",
        ),
        (
            "bow-tie",
            "expect = \"refused: cross\"",
            "expect = \"fills\"",
        ),
        ("empty", "refused: no features", "refused: no such words"),
        // One pixel of a view is enough: the region is elsewhere in the picture than in the reference's.
        (
            "nothing-in-view",
            "name = \"low\"",
            "name = \"low\"\nset = [\"colour=no-way\"]",
        ),
    ] {
        let turned = text(name).replacen(from, to, 1);
        assert_ne!(turned, text(name), "{name}");
        let path = place.path().join(format!("{name}.toml"));
        std::fs::write(&path, turned).expect("writable");
        scenes.push(path.to_string_lossy().into_owned());
    }
    let names: Vec<&str> = scenes.iter().map(String::as_str).collect();
    let run = measured(&place.path().join("run"), &request(&names, 32));
    let ended = |scene: &str, view: &str| {
        let case = run.cases.iter().find(|case| {
            case.condition("scene") == scene && (view.is_empty() || case.condition("view") == view)
        });
        let case = case.expect("planned");
        (case.outcome, case.reason.clone())
    };
    let (outcome, reason) = ended("bow-tie-repaired", "");
    assert_eq!(outcome, Outcome::Failed);
    assert_eq!(reason, "accepted, expected to be refused with \"cross\"");
    let (outcome, reason) = ended("bow-tie", "");
    assert_eq!(outcome, Outcome::Failed);
    assert!(
        reason.starts_with("refused, expected to be filled: "),
        "{reason}"
    );
    let (outcome, reason) = ended("empty", "");
    assert_eq!(outcome, Outcome::Failed);
    assert!(
        reason.starts_with("refused with other words than "),
        "{reason}"
    );
    let (outcome, reason) = ended("nothing-in-view", "low");
    assert_eq!(outcome, Outcome::Failed);
    assert!(reason.contains("colour: found no-way"), "{reason}");
    // One scene loses nothing of another, and one view nothing of its neighbour.
    assert_eq!(ended("nothing-in-view", "other-side").0, Outcome::Ok);
    let sentence = extreme_sentence(&run).expect("cases");
    assert!(
        sentence.contains("1 passed, 0 refused rightly"),
        "{sentence}"
    );
    let rows = summary_rows(&run);
    let all = rows.iter().map(|row| ends(row));
    let [passed, failed] = all.fold([0, 0], |sum, [_, passed, _, failed]| {
        [sum[0] + passed, sum[1] + failed]
    });
    assert!(passed == 1 && failed > 1, "{rows:?}");
}

/// Every scene says why it is there and what must come of it, and those that must fill load as far as
/// scenes go.
#[test]
fn every_scene_of_the_suite_is_read() {
    assert_eq!(suite_names(), [EXTREME]);
    let scenes = suite_scenes(EXTREME).expect("a suite");
    let mut refused = 0;
    for (file, text) in scenes {
        let header = SuiteScene::from_toml(text, file).expect("a header");
        assert_eq!(*file, format!("extreme/{}.toml", header.name));
        if matches!(header.expect, Expectation::Refused(_)) {
            refused += 1;
            continue;
        }
        // A million vertices take a second, and have a test of their own.
        if header.name == "million-vertices" {
            continue;
        }
        let scene = Scene::from_toml(text, file, None).expect("loads");
        let views: Vec<&str> = scene.views.iter().map(|view| view.name.as_str()).collect();
        let known: Vec<&str> = header.views.iter().map(|view| view.name.as_str()).collect();
        assert_eq!(views, known);
    }
    assert!(
        refused >= 7 && scenes.len() > 30,
        "{refused} of {}",
        scenes.len()
    );
    assert!(suite_scenes("gentle").is_none());
}

#[test]
fn names_that_are_none_of_the_suite_are_refused() {
    for (scenes, technique, expected) in [
        (
            "polls",
            "vertex",
            "scene \"polls\" of extreme, allowed: poles, ",
        ),
        (
            "poles",
            "vortex",
            "technique \"vortex\" of extreme, allowed: vertex, ",
        ),
    ] {
        let wanted = Request {
            techniques: vec![technique.to_owned()],
            ..request(&[scenes], 64)
        };
        let Err(error) = SUITE.plan(&wanted) else {
            panic!("accepted {scenes} {technique}");
        };
        assert!(error.to_string().starts_with(expected), "{error}");
    }
}

#[test]
fn a_quick_run_draws_by_one_technique_and_says_which_it_leaves_out() {
    let techniques_of = |depth, named: &[&str]| {
        let wanted = Request {
            techniques: named.iter().map(ToString::to_string).collect(),
            depth,
            ..request(&["poles"], 64)
        };
        let planned = plan(&[&SUITE], &wanted, &OPTIONS).expect("planned");
        let drawn = planned.run_plan().cases.iter();
        let drawn: BTreeSet<&str> = drawn.map(|case| case.id.condition("technique")).collect();
        let left_out = planned.run_plan().skipped.iter();
        let left_out: Vec<String> = left_out.map(|skipped| skipped.what.clone()).collect();
        let drawn: Vec<String> = drawn.into_iter().map(ToOwned::to_owned).collect();
        (drawn, left_out)
    };
    let (drawn, left_out) = techniques_of(Depth::Quick, &[]);
    assert_eq!(drawn, ["vertex"]);
    let others = ["extreme/compute", "extreme/native", "extreme/instanced"];
    assert_eq!(left_out, others);
    // Negative controls: a longer run and one that names its techniques leave none out.
    let (drawn, left_out) = techniques_of(Depth::Main, &[]);
    assert_eq!((drawn.len(), left_out.len()), (4, 0));
    let (drawn, left_out) = techniques_of(Depth::Quick, &["native", "compute"]);
    assert_eq!((drawn.len(), left_out.len()), (2, 0));
}
