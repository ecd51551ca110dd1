// SPDX-License-Identifier: MIT OR Apache-2.0
//! Each question's answers, and controls that must be wrong.

use super::answers::percent;
use super::*;
use crate::device_map::differing;
use crate::maps::{Bias, Frame};
use terrafill_contract::Devices;
use terrafill_results::Status;

/// By name of the case.
type Verdicts = Vec<(String, Verdict)>;

fn request(depth: Depth) -> Request {
    Request {
        depth,
        size: SIZE,
        ..Request::default()
    }
}

/// Verdicts of the cases of a question that `keep` names.
fn verdicts(question: &str, keep: impl Fn(&str) -> bool) -> Verdicts {
    verdicts_of(&request(Depth::Quick), question, keep).0
}

/// The same of what a device can draw.
fn drawn(question: &str, keep: impl Fn(&str) -> bool) -> Verdicts {
    let mut all = verdicts(question, keep);
    all.retain(|(name, verdict)| is_drawn(name, verdict, false));
    all
}

/// The same, and sizes of the pictures by name of the case.
fn verdicts_of(
    request: &Request,
    question: &str,
    keep: impl Fn(&str) -> bool,
) -> (Verdicts, BTreeMap<String, (u32, u32)>) {
    let planned = ShadowsStudy.plan(request).expect("planned");
    let mut groups = planned.groups.iter();
    let name = format!("{STUDY}/{question}");
    let group = groups.find(|group| group.name() == name);
    let group = group.expect("such a group");
    let folder = tempfile::tempdir().expect("a folder");
    // As a run makes it.
    std::fs::create_dir(folder.path().join("images")).expect("a folder");
    let devices = Rc::new(Devices::default());
    let context = Context {
        devices: &devices,
        folder: folder.path(),
    };
    let mut session = group.open(context).expect("opens");
    let cases = group.cases().iter().enumerate();
    let cases = cases.filter(|(_, case)| keep(&case.id.name));
    let all: Verdicts = cases
        .map(|(at, case)| {
            (
                case.id.name.clone(),
                session
                    .verify(at)
                    .or_else(Failure::verdict)
                    .expect("a verdict"),
            )
        })
        .collect();
    let pictures = all.iter().filter_map(|(name, verdict)| {
        let (_, path) = verdict.notes.iter().find(|(key, _)| *key == "image")?;
        let size = image::image_dimensions(folder.path().join(path));
        Some((name.clone(), size.expect("a picture")))
    });
    let pictures = pictures.collect();
    (all, pictures)
}

fn assert_is(is_right: bool, name: &str, verdict: &Verdict) {
    let status = if is_right { Status::Ok } else { Status::Wrong };
    assert_eq!(verdict.status, status, "{name}: {}", verdict.reason);
}

/// Whether eight bits count a multiple of 256 there.
fn is_wrapped(name: &str) -> bool {
    name.contains("wrapping") && ["/256/", "/512/"].iter().any(|of| name.contains(of))
}

fn figure(verdict: &Verdict, metric: &str) -> f64 {
    let mut all = verdict.figures.iter();
    all.find(|(name, _)| *name == metric)
        .map_or(f64::NAN, |(_, value)| *value)
}

#[test]
fn rows_wrap_at_256_and_the_guard_does_not() {
    for (name, verdict) in verdicts("rows", |_| true) {
        assert_is(!is_wrapped(&name), &name, &verdict);
        assert!(figure(&verdict, "shadow_px") > 50.0, "{name}");
        let casters = name.split('/').nth(1).expect("a number");
        let overlap = figure(&verdict, "shadow_max_overlap");
        assert_eq!(overlap.to_string(), casters);
    }
}

#[test]
fn an_open_hull_is_refused_capped_or_doubled_and_leaks_as_it_is() {
    let all = verdicts("casters", |_| true);
    let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "casters/refuse",
            "casters/cap",
            "casters/robust",
            "casters/as-is"
        ]
    );
    assert!(
        all[0].1.reason.contains("border") && all[0].1.figures.is_empty(),
        "{}",
        all[0].1.reason
    );
    for (name, verdict) in &all[1..] {
        assert_is(!name.contains("as-is"), name, verdict);
        let layers = if name.contains("robust") { "2" } else { "1" };
        let overlap = figure(verdict, "shadow_max_overlap");
        assert_eq!(overlap.to_string(), layers, "{name}");
    }
}

#[test]
fn silhouettes_close_their_volumes_unless_a_face_is_turned() {
    let small = |name: &str| !name.contains("port-m");
    for (name, verdict) in verdicts("silhouettes", small) {
        let is_open = name.contains("turned") && !name.contains("adjacency");
        assert_is(!is_open, &name, &verdict);
    }
}

/// Whether there is a verdict to look at: a device that is missing, or cannot do that, has none.
fn is_drawn(name: &str, verdict: &Verdict, may_lack: bool) -> bool {
    if verdict.status == Status::Skipped {
        eprintln!("skipped: {name}: {}", verdict.reason);
        let is_needed = std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_some();
        assert!(may_lack || !is_needed, "{name}: {}", verdict.reason);
        return false;
    }
    true
}

fn mask_hash(verdict: &Verdict) -> String {
    let mut notes = verdict.notes.iter();
    let hash = notes.find(|(key, _)| *key == "mask_hash");
    hash.map_or_else(String::new, |(_, hash)| hash.clone())
}

#[test]
fn devices_draw_the_reference_s_shadows_and_the_same_by_both_interfaces() {
    let all = verdicts("devices", |_| true);
    assert_eq!(all.len(), 2 * 46);
    let mut hashes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut at_rims = 0.0;
    for (name, verdict) in all {
        let has_bounds = name.contains("/native");
        if !is_drawn(&name, &verdict, has_bounds) {
            let lacks =
                ["depth-bounds test", "depthBounds"].map(|lack| verdict.reason.contains(lack));
            assert!(
                !has_bounds || lacks.contains(&true),
                "{name}: {}",
                verdict.reason
            );
            continue;
        }
        assert_is(true, &name, &verdict);
        assert!(figure(&verdict, "shadow_px") > 1_000.0, "{name}");
        assert!(figure(&verdict, "shadow_band_px") < 200.0, "{name}");
        let sees_sky = figure(&verdict, "shadow_receiver_px") < 128.0 * 96.0;
        assert!(!(name.contains("/aerial/") && sees_sky), "{name} is level");
        at_rims += figure(&verdict, "shadow_rim_px");
        let is_cut = name.contains("caster-rect");
        let left_out = figure(&verdict, "shadow_casters_left_out");
        // A view shows all that stands above the sea, or nothing of it.
        let is_of_scene = name.contains("/sea-level/") || name.contains(", one range/");
        let is_as_cut = is_of_scene || (left_out > 0.0) == is_cut;
        assert!(is_as_cut, "{name}: {left_out}");
        let way = name
            .replace("/wgpu/", "/")
            .replace("/vulkan/", "/")
            .replace(", by part/", "/")
            .replace("/native/", "/off/")
            .replace("/discard/", "/off/")
            .replace("/tiles/", "/off/");
        // Sides that a geometry shader makes may begin with another corner, and round otherwise: in the band.
        // Beyond the scene's one range a tile keeps what discarding drops, which wgpu alone does.
        if name.contains("/gs-") || name.contains("/discard, one range/") {
            continue;
        }
        // Whoever finds the silhouettes.
        let (same, _) = way.rsplit_once('/').expect("a silhouette");
        let same = hashes.entry(same.to_owned()).or_default();
        same.push(mask_hash(&verdict));
    }
    assert!(at_rims < 20.0, "{at_rims}");
    for (name, hashes) in hashes {
        assert!(hashes.len() >= 2, "{name}");
        assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{name}");
    }
}

#[test]
fn a_frame_of_the_harbour_is_right_in_all_its_channels_and_the_same_by_both_interfaces() {
    let small = Request {
        size: [64, 48],
        names_size: true,
        ..request(Depth::Quick)
    };
    let (all, pictures) = verdicts_of(&small, "harbour", |_| true);
    assert_eq!(all.len(), 4);
    let mut hashes: BTreeMap<bool, Vec<String>> = BTreeMap::new();
    for (name, verdict) in all.iter().filter(|(name, all)| is_drawn(name, all, false)) {
        assert_is(true, name, verdict);
        let channels = if name.contains("/bridge/") { 7 } else { 1 };
        assert_eq!(pictures[name], (channels * 64, 48), "{name}");
        assert!(figure(verdict, "shadow_px") > 200.0, "{name}");
        let has_map = verdict.notes.iter().any(|(note, _)| *note == "map");
        assert_eq!(has_map, name.contains("/wgpu"), "{name}");
        hashes
            .entry(channels == 7)
            .or_default()
            .push(mask_hash(verdict));
    }
    assert!(
        hashes
            .values()
            .all(|own| own.iter().all(|hash| *hash == own[0]))
    );
}

#[test]
fn a_frame_of_ten_ports_is_right_by_both_interfaces() {
    let small = Request {
        size: [32, 24],
        names_size: true,
        ..request(Depth::Quick)
    };
    let (all, _) = verdicts_of(&small, "fits", |name| name.contains("port-m10"));
    assert_eq!(all.len(), 2);
    let drawn = all.iter().filter(|(name, all)| is_drawn(name, all, false));
    let mut hashes: Vec<String> = Vec::new();
    for (name, verdict) in drawn {
        assert_is(true, name, verdict);
        assert!(figure(verdict, "shadow_px") > 50.0, "{name}");
        hashes.push(mask_hash(verdict));
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]));
}

#[test]
fn a_frame_is_timed_over_all_its_channels_once_it_was_verified() {
    let small = Request {
        size: [32, 24],
        names_size: true,
        ..request(Depth::Quick)
    };
    let planned = ShadowsStudy.plan(&small).expect("planned");
    let mut groups = planned.groups.iter();
    let group = groups.find(|group| group.name() == "shadows/harbour");
    let group = group.expect("such a group");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("images")).expect("a folder");
    let devices = Rc::new(Devices::default());
    let context = Context {
        devices: &devices,
        folder: folder.path(),
    };
    let mut session = group.open(context).expect("opens");
    let verdict = session.verify(0).or_else(Failure::verdict);
    let verdict = verdict.expect("a verdict");
    if !is_drawn("harbour", &verdict, false) {
        return;
    }
    let figures = session.time(0).expect("verified");
    let of = |metric: &str| figures.iter().find(|(name, _)| *name == metric);
    let [wall, cpu] = ["shadow_frame_wall_ms", "shadow_frame_cpu_ms"].map(of);
    assert!(
        wall.is_some_and(|(_, ms)| *ms > 0.0) && cpu.is_some(),
        "{figures:?}"
    );
    // Negative control: what was not drawn has no time.
    assert!(session.time(1).is_err());
    // Another process draws it once more, and judges it where it shows something else alone.
    let mut notes: BTreeMap<String, String> = BTreeMap::new();
    notes.extend(
        verdict
            .notes
            .iter()
            .map(|(key, note)| ((*key).to_owned(), note.clone())),
    );
    let mut again = group.open(context).expect("opens");
    let same = again.recheck(0, verdict.status, &notes).expect("drawn");
    assert!(same.status == verdict.status && same.figures.is_empty());
    assert!(again.time(0).is_ok());
    notes.insert("shown".to_owned(), "something else".to_owned());
    let other = again.recheck(0, verdict.status, &notes).expect("drawn");
    assert!(!other.figures.is_empty(), "judged");
}

#[test]
fn emulated_depth_bounds_save_what_they_are_for() {
    let fragments = |how: &str| {
        let way = format!("10° from -60°/wgpu/sea-closed/z-fail/two-sided/off/{how}/adjacency");
        let all = verdicts("devices", |name| name.ends_with(&way));
        let (name, verdict) = all.first().expect("a case");
        is_drawn(name, verdict, false).then(|| figure(verdict, "shadow_fragments"))
    };
    if let (Some(whole), Some(tiles)) = (fragments("off"), fragments("tiles, by part")) {
        assert!(tiles < 0.7 * whole, "{tiles} of {whole}");
    }
}

#[test]
fn steps_of_the_ablation_have_the_same_mask_and_fewer_writes() {
    let is_kept = |name: &str| {
        name.contains("10° from -60°/wgpu/")
            && ["/2 ", "/4 ", "/7 ", "/9 "]
                .iter()
                .any(|step| name.contains(step))
    };
    let mut before: Option<(String, f64)> = None;
    let all = verdicts("ladder", is_kept);
    assert_eq!(all.len(), 4);
    for (name, verdict) in all {
        // wgpu has no depth bounds.
        let may_lack = name.contains("/9 ");
        if !is_drawn(&name, &verdict, may_lack) {
            continue;
        }
        assert!(!may_lack, "{name}");
        assert_is(true, &name, &verdict);
        let own = (mask_hash(&verdict), figure(&verdict, "shadow_updates"));
        if let Some((hash, writes)) = &before {
            // z-pass writes nothing below the sea.
            let is_less = own.1 < *writes || name.contains("/7 ") && own.1 <= *writes;
            assert!(is_less, "{name}: {} after {writes}", own.1);
            // Infinite volumes have other vertices than closed ones: in the band.
            assert!(own.0 == *hash || name.contains("/7 "), "{name}");
        }
        before = Some(own);
    }
}

#[test]
fn rivals_have_the_reference_s_shadows() {
    for (name, verdict) in verdicts("rivals", |name| name.contains("10°")) {
        // Not every driver has ray queries.
        if is_drawn(&name, &verdict, name.contains("ray query")) {
            assert_is(true, &name, &verdict);
            assert!(figure(&verdict, "shadow_px") > 1_000.0, "{name}");
        }
    }
}

#[test]
fn a_facing_that_each_edge_decides_for_itself_leaks_where_walls_are_edge_on() {
    let mut hashes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut leaks = 0;
    for (name, verdict) in drawn("facings", |_| true) {
        let boxes = name.split('/').nth(2).expect("boxes").to_owned();
        if !name.contains("by corners") {
            assert_is(true, &name, &verdict);
            // As above.
            if !name.contains("/gs-") {
                hashes.entry(boxes).or_default().push(mask_hash(&verdict));
            }
        } else if boxes == "edge-on" {
            assert_eq!(verdict.status, Status::Wrong, "{name}: no leak");
            assert!(figure(&verdict, "shadow_undecided_facings") > 0.0, "{name}");
            leaks += 1;
        }
    }
    for (boxes, hashes) in hashes {
        assert_eq!(hashes.len(), 3, "{boxes}");
        assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{boxes}");
        assert_eq!(leaks, 2, "a vertex and a geometry shader");
    }
}

#[test]
fn a_near_plane_in_shadow_is_missed_by_the_eye_s_test_and_by_no_other_rule() {
    let mut right: Vec<String> = Vec::new();
    for (name, verdict) in drawn("near", |_| true) {
        assert!(figure(&verdict, "shadow_px") > 100.0, "{name}");
        let is_missed = name.ends_with("/z-pass") || name.contains("automatic, eye");
        assert_is(!is_missed, &name, &verdict);
        if !is_missed {
            right.push(mask_hash(&verdict));
        }
    }
    assert!(right.iter().all(|hash| *hash == right[0]), "{right:?}");
}

#[test]
fn a_device_s_rows_wrap_at_256_and_512_and_the_guard_s_do_not() {
    for (name, verdict) in drawn("device-rows", |_| true) {
        assert_is(!is_wrapped(&name), &name, &verdict);
        let lost = figure(&verdict, "shadow_lost_share");
        assert_eq!(lost > 50.0, is_wrapped(&name), "{name}: {lost} %");
    }
}

#[test]
fn a_device_s_map_says_what_the_cpu_s_says() {
    let of_cpu = verdicts("maps", |_| true);
    for (name, verdict) in drawn("device-maps", |_| true) {
        assert_ne!(verdict.status, Status::Failed, "{name}: {}", verdict.reason);
        let same = name.replace("device-maps", "maps");
        let of_cpu = of_cpu.iter().find(|(own, _)| *own == same);
        let (_, of_cpu) = of_cpu.expect("the CPU's");
        let [own, cpu] = [&verdict, of_cpu].map(|verdict| figure(verdict, "shadow_map_wrong"));
        assert!((own - cpu).abs() < 0.1 * cpu, "{name}: {own} and {cpu} %");
        let differs = figure(&verdict, "shadow_map_differs");
        assert!(differs < MAX_DIFFERS, "{name}: {differs} %");
    }
}

#[test]
fn a_device_s_map_half_a_texel_aside_is_noticed() {
    let devices = Rc::new(Devices::default());
    let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
    let mapped = scene.mapped(1.0, Bias::Constant).expect("small");
    let share = |texels: f64| {
        let frame = Frame::of(scene.mesh(), scene.to_light, 1.0);
        let frame = frame.expect("small").moved(texels);
        let map = match scene.device_map(&devices, &frame) {
            Err(Failure::Unable(_)) => return None,
            map => map.expect("a map"),
        };
        let masks = map.masks(Bias::Constant, mapped.step, 1.0).expect("masks");
        let differing = differing(&scene, &masks, &mapped.masks);
        Some(percent(differing as f64, scene.judged()))
    };
    if let (Some(own), Some(aside)) = (share(0.0), share(0.5)) {
        assert!(own < MAX_DIFFERS && aside > MAX_DIFFERS, "{own} {aside} %");
    }
}

#[test]
fn in_larger_pictures_a_device_differs_at_rims_of_casters_alone() {
    let way = "wgpu/sea-closed/z-fail/two-sided/off/off/adjacency";
    let keep =
        |name: &str| name.contains(way) && !name.contains("aerial") && !name.contains("each frame");
    let larger = Request {
        names_size: true,
        ..request(Depth::Full)
    };
    let (all, pictures) = verdicts_of(&larger, "devices", keep);
    assert_eq!(all.len(), 4);
    let mut at_rims = 0.0;
    for (name, verdict) in all.iter().filter(|(name, all)| is_drawn(name, all, false)) {
        assert_is(true, name, verdict);
        assert_eq!(pictures[name], (SIZE[0], SIZE[1]), "{name}");
        at_rims += figure(verdict, "shadow_rim_px");
    }
    assert!(at_rims < 10.0, "{at_rims}");
}

#[test]
fn what_the_cpu_does_first_in_a_frame_is_in_its_whole_time_and_what_is_kept_has_none() {
    let small = Request {
        size: [32, 24],
        names_size: true,
        ..request(Depth::Quick)
    };
    let planned = ShadowsStudy.plan(&small).expect("planned");
    let group = planned
        .groups
        .iter()
        .find(|group| group.name() == "shadows/devices");
    let group = group.expect("such a group");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("images")).expect("a folder");
    let devices = Rc::new(Devices::default());
    let context = Context {
        devices: &devices,
        folder: folder.path(),
    };
    let mut session = group.open(context).expect("opens");
    let first = ["each frame", "automatic, near-exact", "by view, eye"];
    let mut seen = 0;
    for (at, case) in group.cases().iter().enumerate() {
        let name = &case.id.name;
        let is_first = first.iter().any(|first| name.contains(first));
        let is_kept = name.ends_with("/z-fail/two-sided/off/off/adjacency");
        if case.samples == 0 || !(is_first || is_kept) {
            continue;
        }
        let verdict = session.verify(at).or_else(Failure::verdict);
        if !is_drawn(name, &verdict.expect("a verdict"), false) {
            return;
        }
        let figures = session.time(at).expect("verified");
        let of = |metric: &str| figures.iter().find(|(name, _)| *name == metric);
        let of = |metric: &str| of(metric).map(|(_, ms)| *ms);
        assert_eq!(of("shadow_planned_cpu_ms").is_some(), is_first, "{name}");
        let sum = of("shadow_planned_cpu_ms").unwrap_or(0.0)
            + of("shadow_fill_cpu_ms").unwrap_or(f64::NAN);
        assert_eq!(of("shadow_whole_cpu_ms"), Some(sum), "{name}");
        seen += 1;
    }
    // By Vulkan what geometry shaders are compared with.
    assert_eq!(seen, (3 + 2) + (1 + 2));
}

/// Shadows about origins far away and about the eye, in the views of that name.
fn check_origins_seen_from(view: &str) {
    let mut judged = 0_u32;
    for (name, verdict) in verdicts("origins", |name| name.contains(view)) {
        if verdict.status == Status::Skipped {
            continue;
        }
        judged += 1;
        let is_right = verdict.status == Status::Ok;
        let is_local = name.contains("the eye");
        let band_px = figure(&verdict, "shadow_band_px");
        eprintln!("{name}: {} {band_px} px in the band", verdict.reason);
        assert!(!is_local || is_right, "{name}");
        let dark_px = figure(&verdict, "shadow_false_dark_px");
        match view {
            "rail-shadow" => {
                let wrong_px = dark_px + figure(&verdict, "shadow_false_lit_px");
                assert_eq!(wrong_px > 100.0, !is_local, "{name}: {wrong_px}");
            }
            "quay-edge" => {
                let wrong_px = band_px + dark_px;
                assert_eq!(wrong_px < 4.0, is_local, "{name}: {wrong_px}");
            }
            _ => {}
        }
        // At the earth's centre a step is a quarter of a metre.
        assert!(!name.contains("6371") || !is_right, "{name}");
    }
    assert!(judged.is_multiple_of(4), "{judged}");
}

// A test each, so that none takes as long as a driver that hangs.

#[test]
fn an_origin_far_away_is_wrong_in_f32_from_the_bridge_and_from_the_eye_right() {
    check_origins_seen_from("bridge");
}

#[test]
fn an_origin_far_away_is_wrong_in_f32_in_a_rails_shadow_and_from_the_eye_right() {
    check_origins_seen_from("rail-shadow");
}

#[test]
fn an_origin_far_away_is_wrong_in_f32_at_the_quays_edge_and_from_the_eye_right() {
    check_origins_seen_from("quay-edge");
}

#[test]
fn a_quick_plan_is_a_part_of_the_whole() {
    let count = |depth| {
        let planned = ShadowsStudy.plan(&request(depth)).expect("planned");
        let cases = planned.groups.iter().map(|group| group.cases().len());
        cases.sum::<usize>()
    };
    assert!(count(Depth::Quick) < count(Depth::Full));
}

#[test]
fn the_moon_s_shadows_are_right_by_every_rule_and_interface_and_painted_by_night() {
    let small = Request {
        size: [64, 48],
        names_size: true,
        ..request(Depth::Quick)
    };
    let (all, pictures) = verdicts_of(&small, "device-lights", |name| name.contains("moon"));
    assert_eq!(all.len(), 4);
    let mut hashes = Vec::new();
    for (name, verdict) in all.iter().filter(|(name, all)| is_drawn(name, all, false)) {
        assert_is(true, name, verdict);
        assert_eq!(pictures[name], (7 * 64, 48), "{name}");
        assert!(figure(verdict, "shadow_px") > 200.0, "{name}");
        let is_painted = verdict.notes.iter().any(|(key, _)| *key == "map");
        let is_asked = name.contains("wgpu") && name.contains("z-fail");
        assert_eq!(is_painted, is_asked, "{name}");
        hashes.push(mask_hash(verdict));
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    for (name, verdict) in verdicts("lights", |name| name.contains("moon")) {
        assert_is(true, &name, &verdict);
    }
}

#[test]
fn lamps_are_right_by_every_device_and_their_pictures_by_night_have_light_and_dark() {
    let small = Request {
        size: [96, 72],
        names_size: true,
        ..request(Depth::Quick)
    };
    let is_it = |name: &str| name.contains("shore light") && !name.contains("aerial");
    let (all, pictures) = verdicts_of(&small, "device-lights", is_it);
    assert_eq!(all.len(), 18);
    for (name, verdict) in &all {
        let may_lack = name.contains("depth bounds");
        if !is_drawn(name, verdict, may_lack) {
            continue;
        }
        let is_outside = name.contains("eye in shadow") && name.contains("z-pass");
        assert_is(!is_outside, name, verdict);
        let size = if is_outside { (128, 96) } else { (96, 72) };
        assert_eq!(pictures[name], size, "{name}");
        let is_painted = verdict.notes.iter().any(|(key, _)| *key == "map");
        assert_eq!(
            is_painted,
            name.contains("wgpu") && name.contains("z-fail") && name.contains("off"),
            "{name}"
        );
    }
}
