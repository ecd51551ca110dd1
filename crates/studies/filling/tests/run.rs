// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whole small runs: started, killed, resumed; with ladder, matrix and bytes.

use std::path::Path;
use std::sync::Arc;
use terrafill_compute::ComputeTechnique;
use terrafill_filling::{BenchError, BenchOptions, Techniques, group_cases, open_scene, run};
use terrafill_native::{Extrusion, NativeTechnique};
use terrafill_results::legacy::{CaseKey, RunFolder, Status, Summary};
use terrafill_scene::ImageSize;
use terrafill_vertex::{Layout, VertexTechnique};

/// As the command line hands them over.
const TECHNIQUES: Techniques = &[&VertexTechnique, &ComputeTechnique, &NativeTechnique];

fn options(out: &Path) -> BenchOptions {
    BenchOptions {
        techniques: TECHNIQUES,
        scenes: vec!["california".to_owned()],
        backends: Vec::new(),
        quick: true,
        out: out.to_owned(),
        resume: false,
        data_dir: None,
        frames: Some(3),
        size: ImageSize {
            width: 128,
            height: 128,
        },
        shard: None,
        adapter: None,
        ladder: None,
        matrix: None,
        precision: None,
    }
}

/// Whether a run can be made here; says why not.
fn has_device(result: &Result<terrafill_filling::BenchOutcome, BenchError>) -> bool {
    match result {
        Err(BenchError::NoDevice(why)) => {
            assert!(
                std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_none(),
                "{why}"
            );
            eprintln!("skipped: {why}");
            false
        }
        _ => true,
    }
}

#[test]
fn a_run_is_measured_killed_and_resumed_without_measuring_twice() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let result = run(&options(&out));
    if !has_device(&result) {
        return;
    }
    let outcome = result.expect("runs");
    assert_eq!((outcome.ok, outcome.wrong, outcome.failed), (23, 0, 0));
    let whole = RunFolder::open(&out).expect("a run");
    let (summaries, samples) = (
        whole.summaries().expect("rows"),
        whole.samples().expect("rows"),
    );
    // Three views of two baselines and seven techniques, and two textured fills from above; three
    // frames each.
    assert_eq!((summaries.len(), samples.len()), (29, 87));
    assert!(summaries.iter().all(|row| row.status == Status::Ok));
    assert!(summaries.iter().all(|row| row.samples == 3));
    // The surface is timed on every interface, where the device has a clock.
    let surfaces = summaries.iter().map(|row| row.surface_gpu_ms);
    let has_clock = surfaces.clone().any(|gpu_ms| gpu_ms.is_some());
    assert!(surfaces.clone().all(|gpu_ms| gpu_ms.is_some() == has_clock));

    // As a kill would leave it: one view summed up, the second half measured, a torn last row.
    let path = out.join("samples.csv");
    let text = std::fs::read_to_string(&path).expect("readable");
    let kept: Vec<&str> = text.lines().take(1 + 27 + 12).collect();
    std::fs::write(&path, kept.join("\n") + "\ncalifornia,top-d").expect("writable");
    let path = out.join("summary.csv");
    let text = std::fs::read_to_string(&path).expect("readable");
    let kept: Vec<&str> = text.lines().take(1 + 9).collect();
    std::fs::write(&path, kept.join("\n") + "\n").expect("writable");

    let again = run(&options(&out)).expect_err("the folder holds a run");
    assert!(again.to_string().contains("--resume"), "{again}");
    let mut resumed = options(&out);
    resumed.resume = true;
    let outcome = run(&resumed).expect("resumes");
    assert_eq!(outcome.ok, 23);
    let run_again = RunFolder::open(&out).expect("a run");
    let after = run_again.samples().expect("rows");
    assert_eq!(after.len(), 87);
    assert_eq!(after[..39], samples[..39], "what was measured stays");
    let mut keys: Vec<_> = after.iter().map(|row| (row.key(), row.frame)).collect();
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), 87, "no frame of a case stands twice");
    assert!(run_again.missing().expect("a plan").is_empty());
}

#[test]
fn wrong_requests_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let mut wrong = options(&out);
    wrong.backends = vec!["metal".to_owned()];
    let error = run(&wrong).expect_err("no such backend");
    assert_eq!(
        error.to_string(),
        "backend \"metal\", allowed: vertex, compute, native"
    );
    let mut wrong = options(&out);
    wrong.scenes = ["atlantis", "california", "lemuria"]
        .map(str::to_owned)
        .into();
    let error = run(&wrong).expect_err("no such scenes").to_string();
    let lines: Vec<&str> = error.lines().collect();
    assert_eq!(lines.len(), 2, "every wrong scene is named: {error}");
    assert!(
        lines[0].contains("atlantis") && lines[1].contains("lemuria"),
        "{error}"
    );
    let mut wrong = options(&out);
    wrong.matrix = Some(vec!["planet-134".to_owned()]);
    let error = run(&wrong).expect_err("not in this run").to_string();
    assert_eq!(
        error,
        "--matrix: found \"planet-134\", allowed: california, none"
    );
    assert!(!out.exists(), "nothing was written");
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

#[test]
fn ladder_matrix_and_bytes_of_every_backend() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("small.toml");
    std::fs::write(&scene, SMALL_SCENE).expect("writable");
    let out = folder.path().join("run");
    let mut asked = options(&out);
    asked.scenes = vec![scene.to_string_lossy().into_owned()];
    asked.ladder = Some(vec!["small".to_owned()]);
    asked.matrix = Some(vec!["small".to_owned()]);
    let result = run(&asked);
    if !has_device(&result) {
        return;
    }
    let outcome = result.expect("runs");
    assert_eq!((outcome.wrong, outcome.failed), (0, 0));
    let folder = RunFolder::open(&out).expect("a run");
    let rows = folder.summaries().expect("rows");
    let row = |key: &CaseKey| rows.iter().find(|row| row.key() == *key);

    let ladder = folder.ladder().expect("rungs");
    for backend in TECHNIQUES.iter().map(|technique| technique.name()) {
        let own: Vec<_> = ladder
            .iter()
            .filter(|rung| rung.ladder == backend)
            .collect();
        assert!(own.len() >= 13, "{backend}: {}", own.len());
        for (rung, number) in own.iter().zip(1..) {
            assert_eq!(rung.rung, number, "{backend}");
            let row = row(&rung.key()).expect("each rung has its row");
            assert!(row.role.contains("ladder"), "{}", row.role);
            // A device may lack depth bounds; everything else is timed.
            let is_timed = row.status == Status::Ok && row.samples == 3;
            let lacks = row.status == Status::Skipped && row.reason.contains("depth");
            assert!(
                is_timed || (lacks && rung.step == "depth-bounds"),
                "{row:?}"
            );
        }
    }

    let cells: Vec<_> = rows
        .iter()
        .filter(|row| row.role.contains("matrix"))
        .collect();
    assert!(cells.len() > 150, "{}", cells.len());
    let asks_the_same = |row: &&&Summary| {
        let other = ["boundary-lod-px=", "positions="];
        row.status == Status::Ok && !other.iter().any(|key| row.variant.contains(key))
    };
    let same: Vec<_> = cells.iter().filter(asks_the_same).collect();
    assert!(same.len() > 120, "{}", same.len());
    for cell in &same {
        assert_eq!(cell.mask_hash, same[0].mask_hash, "{}", cell.key());
        assert!(cell.ids_hash.is_empty() || cell.ids_hash == same[0].ids_hash);
    }
    let drawn_only = cells.iter().filter(|row| row.role == "matrix");
    assert!(drawn_only.clone().count() > 100);
    assert!(drawn_only.clone().all(|row| row.samples == 0));
    for cell in cells.iter().filter(|row| row.status == Status::Skipped) {
        assert!(
            cell.reason.contains("lacks") || cell.reason.contains("rounds by up to"),
            "{}: {}",
            cell.key(),
            cell.reason
        );
    }

    let memory = folder.memory().expect("bytes");
    let held: Vec<_> = memory
        .iter()
        .filter(|row| row.allocated_bytes().is_some())
        .collect();
    let techniques = Extrusion::ALL.into_iter();
    let in_strips = techniques.filter(|technique| technique.has_index_choice());
    let layouts = Layout::ALL.len() + 2 + Extrusion::ALL.len() + in_strips.count();
    assert_eq!(held.len(), layouts, "every layout of every backend");
    for row in held {
        let name = format!("{}/{}", row.backend, row.layout);
        assert_eq!(
            Some(row.formula_vertex_bytes),
            row.allocated_vertex_bytes,
            "{name}"
        );
        assert_eq!(
            Some(row.formula_index_bytes),
            row.allocated_index_bytes,
            "{name}"
        );
    }
    assert!(memory.iter().any(|row| row.regions == 5_000));

    // Going on with a whole run draws nothing again.
    let before = std::fs::read(out.join("summary.csv")).expect("rows");
    asked.resume = true;
    run(&asked).expect("nothing to do");
    assert_eq!(
        std::fs::read(out.join("summary.csv")).expect("rows"),
        before
    );
}

#[test]
fn cap_steps_are_swept_in_cases_of_their_own() {
    let scene = Arc::new(open_scene("california", None).expect("shipped"));
    let whole = BenchOptions {
        quick: false,
        ..options(Path::new("nowhere"))
    };
    let cases = |options: &BenchOptions| group_cases(&scene, &scene.views[0], options).cases;
    let all = cases(&whole);
    let (swept, others): (Vec<_>, Vec<_>) = all.iter().partition(|case| case.roles.subdivision);
    let steps: Vec<Option<f64>> = swept.iter().map(|case| case.cap_step_deg).collect();
    assert_eq!(steps, [0.3, 1.0, 3.0, 10.0].map(Some));
    for case in swept {
        let knob = format!(",cap-step-deg={}", case.cap_step_deg.unwrap_or_default());
        assert!(case.key.variant.ends_with(&knob), "{}", case.key);
        assert_eq!(
            case.boundary_tolerance_m,
            Some(scene.mesh.boundary_tolerance_m)
        );
        assert_eq!(case.roles.name(), "subdivision");
    }
    for case in others.iter().filter(|case| !case.roles.baseline) {
        assert_eq!(
            case.cap_step_deg,
            Some(scene.mesh.cap_step_deg),
            "{}",
            case.key
        );
    }
    // Twin: a quick run sweeps nothing.
    let quick = cases(&options(Path::new("nowhere")));
    assert!(
        quick
            .iter()
            .all(|case| !case.roles.subdivision && !case.roles.sweep)
    );
}

/// The same with a picture over it.
fn textured_scene(texture: &str) -> String {
    SMALL_SCENE.replace("[[views]]", &format!("[texture]\n{texture}\n\n[[views]]"))
}

#[test]
fn textured_fills_are_judged_by_their_coordinates_beside_the_plain_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("small.toml");
    let checker = "checker = { size = 512, cells = 16 }\nplacement = \"extents\"";
    std::fs::write(&scene, textured_scene(checker)).expect("writable");
    let out = folder.path().join("run");
    let mut asked = options(&out);
    asked.scenes = vec![scene.to_string_lossy().into_owned()];
    asked.backends = vec!["vertex".to_owned(), "compute".to_owned()];
    asked.quick = false;
    asked.precision = Some(false);
    let result = run(&asked);
    if !has_device(&result) {
        return;
    }
    let outcome = result.expect("runs");
    assert_eq!((outcome.wrong, outcome.failed), (0, 0));
    let rows = RunFolder::open(&out)
        .expect("a run")
        .summaries()
        .expect("rows");
    let (textured, plain): (Vec<_>, Vec<_>) = rows
        .iter()
        .partition(|row| row.variant.contains("texture="));
    let (floors, textured): (Vec<_>, Vec<_>) = textured
        .into_iter()
        .partition(|row| row.variant.contains("texture=floor"));
    assert_eq!(textured.len(), 6, "five by vertex shader, one by compute");
    let [floor] = floors[..] else {
        panic!("{} floors", floors.len());
    };
    assert_eq!((floor.status, floor.samples), (Status::Ok, 3));
    assert_eq!((floor.texel_rms, floor.texel_compared_px), (None, None));
    assert!(
        floor.reason.contains("its texels have no error"),
        "{}",
        floor.reason
    );
    assert_eq!(floor.mismatched_px_outside_band, Some(0));
    for row in &textured {
        let name = row.key();
        assert_eq!((row.role.as_str(), row.samples), ("texture", 3), "{name}");
        assert!(row.texel_rms.expect("compared") <= 0.25, "{name}");
        assert!(row.texel_max.expect("compared") <= 0.5, "{name}");
        assert_eq!(row.texel_non_finite, Some(0), "{name}");
        assert!(row.texel_compared_px.expect("compared") > 100, "{name}");
        let is_chosen = row.variant.contains("texture=chosen");
        assert_eq!(row.texture_route.contains(" texels"), is_chosen, "{name}");
        // Only the fill as it should be used is shown.
        let is_shown = is_chosen && !row.variant.contains("picture=");
        assert_eq!(row.colour_max.is_some(), is_shown, "{name}");
        if is_shown {
            for image in [&row.image, &row.reference_image, &row.difference_image] {
                assert!(out.join(image).is_file(), "{name}: {image}");
            }
            assert!(row.colour_mean.expect("compared") < 2.0, "{name}");
        }
    }
    let bytes = |variant: &str| {
        let row = textured.iter().find(|row| row.variant == variant);
        row.and_then(|row| row.texture_bytes).expect("counted")
    };
    assert!(bytes("doubled,texture=chosen,picture=32") < bytes("doubled,texture=chosen"));
    for row in plain {
        let cells = (row.texel_rms, row.texture_bytes, row.colour_max);
        assert_eq!(cells, (None, None, None), "{}", row.key());
        assert!(row.texture_route.is_empty());
    }
}

#[test]
fn a_scene_whose_picture_is_missing_is_skipped_for_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("small.toml");
    let lost = format!(
        "image = {{ path = \"textures/lost.png\", sha256 = \"{}\", how = \"paint it\" }}\n\
         placement = \"extents\"",
        "0".repeat(64)
    );
    std::fs::write(&scene, textured_scene(&lost)).expect("writable");
    let mut asked = options(&folder.path().join("run"));
    asked.scenes = vec![
        "california".to_owned(),
        scene.to_string_lossy().into_owned(),
    ];
    asked.data_dir = Some(folder.path().to_owned());
    asked.backends = vec!["vertex".to_owned()];
    asked.size = ImageSize {
        width: 32,
        height: 32,
    };
    let result = run(&asked);
    if !has_device(&result) {
        return;
    }
    let skipped = result.expect("runs").skipped_scenes;
    assert_eq!(skipped.len(), 1);
    assert!(
        skipped[0].1.contains("textures/lost.png") && skipped[0].1.contains("paint it"),
        "{skipped:?}"
    );
}
