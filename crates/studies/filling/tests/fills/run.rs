// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whole small runs of the study: broken off and resumed; with ablation, matrix, sweeps and bytes.

use crate::drawing::TECHNIQUES;
use crate::runs::{self, OPTIONS, environment, has_device, measure};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use terrafill_compute::ComputeTechnique;
use terrafill_filling::{FillingStudy, STUDY, Surfaces, Techniques};
use terrafill_native::Extrusion;
use terrafill_overlays::{DRAPED_MESH, FLAT_MESH, MASK_TEXTURE};
use terrafill_results::{Case, Outcome, PlannedCase, Run, RunFolder, Status};
use terrafill_scene::Overlap;
use terrafill_study::{Depth, Plan, Request, Study as _, plan};
use terrafill_surface::EllipsoidKind;
use terrafill_vertex::{Layout, VertexTechnique};

const SURFACES: Surfaces = &[&EllipsoidKind];
/// As the command line hands it over.
const FILLING: FillingStudy = FillingStudy {
    techniques: TECHNIQUES,
    rivals: &[],
    surfaces: SURFACES,
};

fn request(scenes: &[&str]) -> Request {
    Request {
        scenes: scenes.iter().map(ToString::to_string).collect(),
        depth: Depth::Quick,
        samples: Some(2),
        size: [64, 64],
        ..Request::default()
    }
}

fn setting(key: &str, scene: &str) -> (String, Vec<String>) {
    (key.to_owned(), vec![scene.to_owned()])
}

fn planned(request: &Request) -> Plan {
    plan(&[&FILLING], request, &OPTIONS).expect("planned")
}

fn measured(out: &Path, request: &Request) -> Run {
    runs::measured(&FILLING, FILLING.metrics(), out, request)
}

/// Rows of a table without its header.
fn rows(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).expect("a table");
    text.lines().skip(1).map(str::to_owned).collect()
}

/// Keeps the header and so many rows, and half of one more, as a kill does.
fn cut(path: &Path, kept: usize) {
    let text = std::fs::read_to_string(path).expect("a table");
    let whole: Vec<&str> = text.lines().take(1 + kept).collect();
    std::fs::write(path, whole.join("\n") + "\nfilling/california/top-d").expect("writable");
}

#[test]
fn rivals_are_planned_beside_the_techniques_and_may_be_wrong() {
    let study = FillingStudy {
        techniques: &[&VertexTechnique],
        rivals: &[&ComputeTechnique],
        surfaces: SURFACES,
    };
    let cases = |techniques: &[&str]| -> Vec<PlannedCase> {
        let wanted = Request {
            techniques: techniques.iter().map(ToString::to_string).collect(),
            ..request(&["california"])
        };
        let planned = study.plan(&wanted).expect("planned");
        assert_eq!(planned.skipped, [], "nothing is missing");
        let groups = planned.groups.iter();
        groups.flat_map(|group| group.cases().to_vec()).collect()
    };
    let is_rival = |case: &&PlannedCase| case.id.condition("technique") == "compute";
    for cases in [cases(&[]), cases(&["vertex", "compute"])] {
        let mut rivals = cases.iter().filter(is_rival).peekable();
        assert!(rivals.peek().is_some());
        for case in rivals {
            assert_eq!(case.id.condition("role"), "rival");
            assert!(case.may_be_wrong && case.samples > 0);
            assert_eq!(
                case.id.condition("colour"),
                "",
                "no switch of ours is its own"
            );
        }
        assert!(
            cases
                .iter()
                .any(|case| !is_rival(&case) && !case.may_be_wrong)
        );
    }
    // Negative control: who names techniques gets those alone.
    assert_eq!(cases(&["vertex"]).iter().filter(is_rival).count(), 0);
}

#[test]
fn a_small_run_is_right_and_resumes_without_measuring_twice() {
    if !has_device() {
        return;
    }
    let place = tempfile::tempdir().expect("a folder");
    let wanted = request(&["california"]);
    let whole = measured(place.path(), &wanted);
    let own = |case: &&Case| !case.is_repeat();
    let counted = whole.cases.iter().filter(own);
    // Three views of two baselines, seven layouts, six full plans and what the view needs, two textured fills
    // from above, and the bytes of seven layouts for twelve numbers of regions.
    assert_eq!(counted.count(), 3 * 16 + 2 + 7 * 12);
    for case in &whole.cases {
        assert_eq!(case.outcome, Outcome::Ok, "{}: {}", case.id(), case.reason);
        let is_untimed = ["memory", "needs"].contains(&case.condition("role"));
        let samples = if is_untimed { 0 } else { 2 };
        assert_eq!(case.timed_samples(0).len(), samples, "{}", case.id());
    }
    // The surface is timed on every interface, where the device has a clock.
    let timed = whole.cases.iter().filter(|case| case.planned.samples > 0);
    let surfaces: BTreeSet<bool> = timed
        .map(|case| case.samples("surface_gpu_ms").is_some())
        .collect();
    assert_eq!(surfaces.len(), 1);

    // As a kill would leave it: the second view is verified, and a few of its frames are measured.
    let tables = ["measurements.csv", "cases.csv", "notes.csv"].map(|name| place.path().join(name));
    let before = tables.each_ref().map(|path| rows(path));
    let is_timed = |row: &&String| row.contains("/top-down/") && !row.contains(",0,0,");
    let first = before[0].iter().position(|row| is_timed(&row));
    let first = first.expect("frames of the second view");
    let sample_of = |row: &str| row.split(',').next().map(str::to_owned);
    let mut kept = first;
    let mut cases = BTreeSet::new();
    while cases.len() < 4 || cases.contains(&sample_of(&before[0][kept])) {
        cases.insert(sample_of(&before[0][kept]));
        kept += 1;
    }
    let of_first_views = |row: &&String| !row.contains("/horizon/") && !row.contains("/memory/");
    cut(&tables[0], kept);
    let verified = before[1].iter().filter(of_first_views).count();
    cut(&tables[1], verified);
    cut(&tables[2], before[2].iter().filter(of_first_views).count());
    let killed = Run::load(place.path()).expect("a torn row is let pass");
    assert!(killed.count(Outcome::Missing) > 9);

    let plan = planned(&wanted);
    let folder = RunFolder::resume(place.path(), &environment(), plan.run_plan());
    let resumed = measure(&plan, &folder.expect("the same run"));
    assert_eq!(resumed.count(Outcome::Missing), 0);
    let after = rows(&tables[0]);
    assert_eq!(after[..kept], before[0][..kept], "what was measured stays");
    let keys: BTreeSet<&str> = after
        .iter()
        .filter_map(|row| row.rsplit_once(',').map(|(key, _)| key))
        .collect();
    assert_eq!(keys.len(), after.len(), "no value stands twice");
    assert_eq!(after.len(), before[0].len());
    assert_eq!(rows(&tables[1]).len(), before[1].len());
    for (before, after) in whole.cases.iter().zip(&resumed.cases) {
        let mask = |case: &Case| case.note("mask_hash").to_owned();
        assert_eq!(mask(before), mask(after), "{}", before.id());
    }

    // Killed between the fills of the last view and the bytes of their layouts.
    for path in &tables[..2] {
        let is_memory = |row: &String| row.contains("/memory/");
        let kept = rows(path).iter().position(is_memory);
        cut(path, kept.expect("bytes of layouts"));
    }
    let folder = RunFolder::resume(place.path(), &environment(), plan.run_plan());
    let resumed = measure(&plan, &folder.expect("the same run"));
    assert_eq!(resumed.count(Outcome::Missing), 0);
    let allocated = |run: &Run| {
        let bytes = run.cases.iter().map(|case| {
            let bytes =
                ["vertex", "index"].map(|part| case.value(format!("allocated_{part}_bytes")));
            (
                case.id().clone(),
                bytes.map(|bytes| bytes.map(f64::to_bits)),
            )
        });
        bytes.collect::<BTreeMap<_, _>>()
    };
    let known = allocated(&whole);
    assert!(known.values().filter(|bytes| bytes[0].is_some()).count() == 7);
    assert_eq!(allocated(&resumed), known);
}

#[test]
fn wrong_requests_are_refused_when_they_are_planned() {
    let refused = |request: &Request| match plan(&[&FILLING], request, &OPTIONS) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{request:?} was planned"),
    };
    let mut wrong = request(&["california"]);
    wrong.techniques = vec!["metal".to_owned()];
    assert_eq!(
        refused(&wrong),
        "technique \"metal\", allowed: vertex, compute, native"
    );
    let error = refused(&request(&["atlantis", "california", "lemuria"]));
    let lines: Vec<&str> = error.lines().collect();
    assert_eq!(lines.len(), 2, "every wrong scene is named: {error}");
    assert!(
        lines[0].contains("atlantis") && lines[1].contains("lemuria"),
        "{error}"
    );
    let twice = refused(&request(&["california", "california"]));
    assert!(twice.contains("\"california\" is given twice"), "{twice}");
    let mut wrong = request(&["california"]);
    wrong
        .settings
        .extend([setting("ablation", "california:sideways")]);
    let error = refused(&wrong);
    assert!(
        error.starts_with(
            "--ablation: found step \"sideways\" of california, allowed: start, one-volume"
        ),
        "{error}"
    );
    // Negative control: from a step that there is on, there are fewer steps, numbered anew.
    let steps = |wanted: &str| {
        let mut request = request(&["california"]);
        request.settings.extend([setting("ablation", wanted)]);
        let plan = planned(&request);
        let cases = plan.run_plan().cases.iter();
        cases
            .filter(|case| !case.id.condition("rung").is_empty())
            .count()
    };
    let some = steps("california:colours");
    assert!(some > 0 && 2 * some < steps("california"), "{some}");
    for key in ["ablation", "matrix"] {
        let mut wrong = request(&["california"]);
        wrong.settings.extend([setting(key, "planet-134")]);
        assert_eq!(
            refused(&wrong),
            format!("--{key}: found \"planet-134\", allowed: california, none")
        );
        // Negative control: of no scene at all.
        wrong.settings.extend([setting(key, "none")]);
        assert_eq!(
            planned(&wrong).run_plan(),
            planned(&request(&["california"])).run_plan()
        );
    }
}

/// California from above, at a size at which every case is quick.
const SMALL_SCENE: &str = r#"
name = "small"
description = "California from above"
body = "wgs84"
edges = "planar"
overlap = "disjoint"

[regions]
embedded = "california.geojson"

[surface]
kind = "ellipsoid"
rows = 60

[mesh]
boundary_tolerance_m = 500
cap_step_deg = 3

[[views]]
name = "globe"
longitude_deg = -119.5
latitude_deg = 37.2
height_m = 1_500_000
heading_deg = 0
pitch_deg = -90
"#;

/// The scene in a file of its own, and a request for it.
fn small(place: &Path, text: &str) -> Request {
    let scene = place.join("small.toml");
    std::fs::write(&scene, text).expect("writable");
    let mut wanted = request(&[&scene.to_string_lossy()]);
    wanted.size = [128, 128];
    wanted
}

fn roles(case: &Case) -> Vec<&str> {
    case.condition("role").split('+').collect()
}

fn check_ablations(run: &Run) {
    for technique in TECHNIQUES.iter().map(|technique| technique.name()) {
        let of = |case: &&Case| {
            !case.is_repeat()
                && roles(case).contains(&"ladder")
                && case.condition("technique") == technique
        };
        let mut steps: Vec<&Case> = run.cases.iter().filter(of).collect();
        steps.sort_by_key(|case| case.condition("rung").parse::<usize>().expect("a number"));
        assert!(steps.len() >= 13, "{technique}: {}", steps.len());
        for (case, number) in steps.into_iter().zip(1..) {
            assert_eq!(
                case.condition("rung"),
                number.to_string(),
                "{technique}: numbered without a gap"
            );
            let is_timed = case.outcome == Outcome::Ok && case.timed_samples(0).len() == 2;
            assert!(is_timed, "{}: {}", case.id(), case.reason);
            assert!(!case.note("change").is_empty(), "{}", case.id());
        }
    }
}

fn check_matrix(run: &Run) {
    let of = |case: &&Case| !case.is_repeat() && roles(case).contains(&"matrix");
    let cells: Vec<&Case> = run.cases.iter().filter(of).collect();
    assert!(cells.len() > 150, "{}", cells.len());
    let defaults = [
        ("boundary-lod-px", "off"),
        ("normals", "geodetic"),
        ("positions", "fixed"),
    ];
    let asks_the_same = |case: &&&Case| {
        let is_default = |(key, value)| ["", value].contains(&case.condition(key));
        case.outcome == Outcome::Ok && defaults.into_iter().all(is_default)
    };
    let same: Vec<&&Case> = cells.iter().filter(asks_the_same).collect();
    assert!(same.len() > 120, "{}", same.len());
    let ids = same.iter().map(|cell| cell.note("ids_hash"));
    let ids: BTreeSet<&str> = ids.filter(|hash| !hash.is_empty()).collect();
    assert_eq!(ids.len(), 1, "one picture of ids");
    for cell in &same {
        let mask = same[0].note("mask_hash");
        assert!(!mask.is_empty());
        assert_eq!(cell.note("mask_hash"), mask, "{}", cell.id());
    }
    let drawn_only = cells.iter().filter(|case| roles(case) == ["matrix"]);
    assert!(drawn_only.clone().count() > 100);
    assert!(drawn_only.clone().all(|case| case.planned.samples == 0));
    for cell in cells.iter().filter(|case| case.outcome == Outcome::Skipped) {
        assert!(
            cell.reason.contains("lacks") || cell.reason.contains("rounds by up to"),
            "{}: {}",
            cell.id(),
            cell.reason
        );
    }
}

fn check_bytes(run: &Run) {
    let memory = run
        .cases
        .iter()
        .filter(|case| case.condition("role") == "memory");
    let held: Vec<&Case> = memory
        .clone()
        .filter(|case| case.value("allocated_vertex_bytes").is_some())
        .collect();
    let in_strips = Extrusion::ALL
        .into_iter()
        .filter(|technique| technique.has_index_choice());
    let layouts = Layout::ALL.len() + 2 + Extrusion::ALL.len() + in_strips.count();
    assert_eq!(held.len(), layouts, "every layout of every technique");
    for case in held {
        assert_eq!(case.condition("regions"), "1", "as the scene has");
        for part in ["vertex", "index"] {
            let formula = case.value(format!("formula_{part}_bytes"));
            let allocated = case.value(format!("allocated_{part}_bytes"));
            assert!(formula.is_some(), "{}", case.id());
            assert_eq!(formula, allocated, "{}: {part}", case.id());
        }
    }
    assert!(
        memory
            .clone()
            .any(|case| case.condition("regions") == "5000")
    );
}

#[test]
fn ablation_matrix_and_bytes_of_every_technique() {
    if !has_device() {
        return;
    }
    let place = tempfile::tempdir().expect("a folder");
    let mut wanted = small(place.path(), SMALL_SCENE);
    wanted
        .settings
        .extend([setting("ablation", "small"), setting("matrix", "small")]);
    let out = place.path().join("run");
    let run = measured(&out, &wanted);
    for outcome in [Outcome::Wrong, Outcome::Failed, Outcome::Missing] {
        assert_eq!(run.count(outcome), 0, "{}", outcome.name());
    }
    check_ablations(&run);
    check_matrix(&run);
    check_bytes(&run);
    // Going on with a whole run draws nothing again.
    let tables = || ["cases.csv", "measurements.csv"].map(|name| rows(&out.join(name)));
    let before = tables();
    let plan = planned(&wanted);
    let folder = RunFolder::resume(&out, &environment(), plan.run_plan()).expect("the same run");
    measure(&plan, &folder);
    assert_eq!(tables(), before);
}

/// Cases of California's first view that a technique draws.
fn drawn_cases(depth: Depth) -> Vec<PlannedCase> {
    let mut wanted = request(&["california"]);
    wanted.depth = depth;
    let plan = planned(&wanted);
    let cases = plan.run_plan().cases.iter().filter(|case| {
        let of = |key| case.id.condition(key);
        of("view") == "globe" && !["baseline", "memory"].contains(&of("role"))
    });
    cases.cloned().collect()
}

#[test]
fn cap_steps_are_swept_in_cases_of_their_own() {
    let is_swept = |case: &&PlannedCase| {
        let is_repeat = case.id.conditions.contains_key("repeats");
        case.id.condition("role") == "subdivision" && !is_repeat
    };
    let all = drawn_cases(Depth::Full);
    let swept: Vec<&PlannedCase> = all.iter().filter(is_swept).collect();
    let steps: Vec<&str> = swept
        .iter()
        .map(|case| case.id.condition("cap-step-deg"))
        .collect();
    assert_eq!(steps, ["0.1", "0.3", "1", "3"]);
    let scene = terrafill_scene::Scene::open("california", None).expect("it ships");
    for case in swept {
        let own = format!(",cap-step-deg={}", case.id.condition("cap-step-deg"));
        assert!(case.id.name.ends_with(&own), "{}", case.id);
        assert_eq!(
            case.id.condition("boundary-tolerance-m"),
            scene.mesh.boundary_tolerance_m.to_string()
        );
        assert!(!case.may_be_wrong, "{}", case.id);
    }
    let others = all
        .iter()
        .filter(|case| case.id.condition("role") != "subdivision");
    for case in others {
        assert_eq!(
            case.id.condition("cap-step-deg"),
            scene.mesh.cap_step_deg.to_string(),
            "{}",
            case.id
        );
    }
    let is_error_swept = |case: &PlannedCase| case.id.condition("role") == "sweep";
    let mut errors = all.iter().filter(|case| is_error_swept(case)).peekable();
    assert!(errors.peek().is_some());
    assert!(
        errors.all(|case| case.may_be_wrong),
        "its error is the question"
    );
    // Negative control: a quick run sweeps nothing.
    let quick = drawn_cases(Depth::Quick);
    assert!(!quick.is_empty());
    assert!(
        !quick
            .iter()
            .any(|case| is_swept(&case) || is_error_swept(case))
    );
}

/// Keys of everything that can be chosen of a technique, as columns.
fn columns(technique: &str) -> Vec<String> {
    let found = TECHNIQUES.iter().find(|known| known.name() == technique);
    let found = found.expect("a technique");
    let settings = found.main(Overlap::Disjoint).settings();
    let keys = settings.into_iter().map(|(key, _)| key.to_owned());
    // The first is its layout, whatever it is called there.
    std::iter::once("layout".to_owned())
        .chain(keys.skip(1))
        .collect()
}

/// Cases that are told apart by nothing but the conditions `ignored`.
fn confused(cases: &[&PlannedCase], ignored: &[&str]) -> Vec<String> {
    let mut seen: BTreeMap<BTreeMap<&str, &str>, &PlannedCase> = BTreeMap::new();
    let mut confused = Vec::new();
    for case in cases {
        let conditions = case.id.conditions.iter();
        let others = conditions
            .map(|(key, value)| (key.as_str(), value.as_str()))
            .filter(|(key, _)| !ignored.contains(key));
        if let Some(other) = seen.insert(others.collect(), case) {
            confused.push(format!("{} and {}", other.id, case.id));
        }
    }
    confused
}

#[test]
fn every_switch_is_a_column_and_tells_cases_apart_without_their_variant() {
    let mut wanted = request(&["california"]);
    wanted.depth = Depth::Full;
    wanted.settings.extend([
        setting("ablation", "california"),
        setting("matrix", "california"),
    ]);
    let plan = planned(&wanted);
    let cases: Vec<&PlannedCase> = plan.run_plan().cases.iter().collect();
    let keys: BTreeMap<&str, Vec<String>> = TECHNIQUES
        .iter()
        .map(|technique| (technique.name(), columns(technique.name())))
        .collect();
    let mut checked = 0;
    for case in &cases {
        let technique = keys.get(case.id.condition("technique"));
        let Some(keys) = technique.filter(|_| case.id.condition("role") != "memory") else {
            continue;
        };
        checked += 1;
        for key in keys {
            assert!(!case.id.condition(key).is_empty(), "{}: {key}", case.id);
        }
        let changed = case.id.condition("variant").split(',').skip(1);
        for (key, value) in changed.filter_map(|part| part.split_once('=')) {
            assert_eq!(case.id.condition(key), value, "{}", case.id);
        }
    }
    assert!(checked > 500, "{checked}");
    // A step's number and name are no switches.
    let ignored = ["variant", "rung", "step", "needs-rung", "needs-step"];
    assert_eq!(confused(&cases, &ignored), [""; 0]);
    // Negative control: without a switch's column two cases are one.
    for switch in ["depth-rule", "walls", "positions", "horizon-culling"] {
        let without = [&ignored[..], &[switch]].concat();
        assert!(!confused(&cases, &without).is_empty(), "{switch}");
    }
}

/// The same with a picture over it.
fn textured_scene(texture: &str) -> String {
    SMALL_SCENE.replace("[[views]]", &format!("[texture]\n{texture}\n\n[[views]]"))
}

#[test]
fn textured_fills_are_verified_by_their_coordinates_beside_the_plain_one() {
    if !has_device() {
        return;
    }
    let place = tempfile::tempdir().expect("a folder");
    let checker = "checker = { size = 512, cells = 16 }\nplacement = \"extents\"";
    let mut wanted = small(place.path(), &textured_scene(checker));
    wanted.techniques = vec!["vertex".to_owned(), "compute".to_owned()];
    wanted.depth = Depth::Full;
    let out = place.path().join("run");
    let run = measured(&out, &wanted);
    assert_eq!(run.count(Outcome::Failed), 0);
    let fills = run.cases.iter().filter(|case| {
        let is_other = ["baseline", "memory"].contains(&case.condition("role"));
        !case.is_repeat() && !is_other
    });
    let (textured, plain): (Vec<&Case>, Vec<&Case>) =
        fills.partition(|case| case.condition("texture") != "plain");
    let (floors, textured): (Vec<&Case>, Vec<&Case>) = textured
        .into_iter()
        .partition(|case| case.condition("texture") == "floor");
    let (published, textured): (Vec<&Case>, Vec<&Case>) = textured.into_iter().partition(|case| {
        let is_flat_mesh = case.condition("texture") == "barycentric";
        is_flat_mesh || case.condition("position") == "inverse-ecef"
    });
    assert_eq!(textured.len(), 3, "two by vertex shader, one by compute");
    // Angles at the body's centre are not those by which the picture lies: timed though wrong.
    assert_eq!(published.len(), 8);
    for case in &published {
        assert!(case.planned.may_be_wrong, "{}", case.id());
        assert_eq!(case.timed_samples(0).len(), 2, "{}", case.id());
    }
    let mut centric = published.iter();
    let centric = centric.find(|case| case.condition("normalize") == "superfluous");
    assert_eq!(centric.map(|case| case.outcome), Some(Outcome::Wrong));
    let mut wrong = run
        .cases
        .iter()
        .filter(|case| case.outcome == Outcome::Wrong);
    assert!(wrong.all(|case| case.planned.may_be_wrong));
    let [floor] = floors[..] else {
        panic!("{} floors", floors.len());
    };
    assert_eq!(floor.status(), Some(Status::Ok));
    assert_eq!(floor.timed_samples(0).len(), 2);
    for metric in ["texel_rms", "texel_compared_px"] {
        assert_eq!(floor.value(metric), None);
    }
    assert!(
        floor.reason.contains("its texels have no error"),
        "{}",
        floor.reason
    );
    assert_eq!(floor.value("mismatched_px_outside_band"), Some(0.0));
    for case in &textured {
        let (name, value) = (case.id(), |metric| case.value(metric).expect("compared"));
        assert_eq!(case.condition("role"), "texture", "{name}");
        assert_eq!(case.timed_samples(0).len(), 2, "{name}");
        assert!(value("texel_rms") <= 0.25, "{name}");
        assert!(value("texel_max") <= 0.5, "{name}");
        assert!(value("texel_non_finite") < 1.0, "{name}");
        assert!(value("texel_compared_px") > 100.0, "{name}");
        let is_chosen = case.condition("texture") == "chosen";
        let route = case.note("texture_route");
        assert_eq!(route.contains(" texels"), is_chosen, "{name}: {route}");
        // Only the fill as it should be used is shown.
        let is_shown = is_chosen && case.condition("picture") == "scene";
        assert_eq!(case.value("colour_max").is_some(), is_shown, "{name}");
        if is_shown {
            for note in ["image", "reference_image", "difference_image"] {
                assert!(out.join(case.note(note)).is_file(), "{name}: {note}");
            }
            assert!(value("colour_mean") < 2.0, "{name}");
        }
    }
    let bytes = |picture: &str| {
        let mut cases = published.iter();
        let of = |case: &&&Case| {
            case.condition("normalize") == "superfluous" && case.condition("picture") == picture
        };
        let case = cases.find(of).expect("a case");
        case.value("texture_bytes").expect("counted")
    };
    assert!(bytes("32") < bytes("scene"));
    assert!(!plain.is_empty());
    for case in plain {
        for metric in ["texel_rms", "texture_bytes", "colour_max"] {
            assert_eq!(case.value(metric), None, "{}: {metric}", case.id());
        }
        assert!(case.note("texture_route").is_empty());
    }
}

#[test]
fn a_scene_whose_picture_is_missing_is_skipped_for_it() {
    let place = tempfile::tempdir().expect("a folder");
    let lost = format!(
        "image = {{ path = \"textures/lost.png\", sha256 = \"{}\", how = \"paint it\" }}\n\
         placement = \"extents\"",
        "0".repeat(64)
    );
    let mut wanted = small(place.path(), &textured_scene(&lost));
    wanted.scenes.push("california".to_owned());
    wanted.data_dir = Some(place.path().to_owned());
    let plan = planned(&wanted);
    let [skipped] = &plan.run_plan().skipped[..] else {
        panic!("{:?}", plan.run_plan().skipped);
    };
    assert!(skipped.what.ends_with("small.toml"), "{}", skipped.what);
    for phrase in ["textures/lost.png", "paint it"] {
        assert!(skipped.reason.contains(phrase), "{}", skipped.reason);
    }
    // The other scene is measured all the same.
    let mut cases = plan.run_plan().cases.iter();
    assert!(cases.all(|case| case.id.study == STUDY && case.id.condition("scene") == "california"));
    assert!(!plan.run_plan().cases.is_empty());
}

#[test]
fn an_approximate_fill_is_timed_never_right_and_no_failure() {
    static WITH_APPROXIMATE: Techniques =
        &[&VertexTechnique, &FLAT_MESH, &DRAPED_MESH, &MASK_TEXTURE];
    if !has_device() {
        return;
    }
    let study = FillingStudy {
        techniques: WITH_APPROXIMATE,
        rivals: &[],
        surfaces: SURFACES,
    };
    let named = ["vertex", "flat-mesh", "draped-mesh", "mask-texture"];
    let request = Request {
        techniques: named.map(str::to_owned).to_vec(),
        ..request(&["california"])
    };
    let place = tempfile::tempdir().expect("a folder");
    let out = place.path().join("run");
    let run = runs::measured(&study, study.metrics(), &out, &request);
    let of = |technique: &'static str| {
        let own = run.cases.iter();
        own.filter(move |case| case.condition("technique") == technique)
    };
    for technique in &named[1..] {
        assert!(of(technique).count() >= 3, "{technique}");
        for case in of(technique) {
            let id = case.id();
            assert_eq!(case.outcome, Outcome::Wrong, "{id}");
            assert!(case.reason.starts_with("approximate: "), "{}", case.reason);
            assert!(case.planned.may_be_wrong && !case.counts(), "{id}");
            assert_eq!(case.condition("approximate"), "yes", "{id}");
            assert_eq!(case.condition("colour"), "", "no stencil, no switch of one");
            for metric in ["fill_cpu_ms", "prepare_cpu_ms", "mismatched_px"] {
                assert!(case.value(metric).is_some(), "{id}: {metric}");
            }
        }
    }
    let ended = terrafill_study::RunOutcome::of(&out).expect("a run");
    assert_eq!((ended.wrong, ended.failed), (0, 0));
    assert!(ended.wrong_on_purpose >= 15, "{ended:?}");
    // Negative control: volumes have to be right, and a wrong picture of theirs would end the run so.
    for case in of("vertex") {
        let swept = case.condition("role").contains("sweep");
        assert!(swept || !case.planned.may_be_wrong, "{}", case.id());
        assert_eq!(case.condition("approximate"), "", "{}", case.id());
    }
    // Negative control: unless they are named, a quick run over the bare body leaves them out.
    let unnamed = Request {
        techniques: Vec::new(),
        ..request
    };
    let plan = plan(&[&study], &unnamed, &OPTIONS).expect("planned");
    let mut cases = plan.run_plan().cases.iter();
    assert!(cases.all(|case| case.id.condition("approximate").is_empty()));
}
