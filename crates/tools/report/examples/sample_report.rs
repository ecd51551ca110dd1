// SPDX-License-Identifier: MIT OR Apache-2.0
//! Makes up a run of some forty cases and writes its report, to look at the layout without a device.
//!
//! `cargo run -p terrafill-report --example sample_report -- DIR`. Every number in it is invented;
//! the environment says so.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use terrafill_report::write_report;
use terrafill_results::legacy::{
    CaseKey, RunEnvironment, RunFolder, RunPlan, Sample, Status, Summary, spread,
};

const SIDE_PX: u32 = 512;
const FRAMES: u32 = 40;
const BOUND_MS: f64 = 11.4;
const FLOOR_MS: f64 = 3.6;

/// Invented cost of one variant, relative to `doubled`.
struct Variant {
    name: &'static str,
    time: f64,
    vertex_bytes: u64,
    index_bytes: u64,
    wrong_px: u64,
    deviation_m: f64,
}

const fn variant(
    name: &'static str,
    time: f64,
    vertex_bytes: u64,
    index_bytes: u64,
    wrong_px: u64,
    deviation_m: f64,
) -> Variant {
    Variant {
        name,
        time,
        vertex_bytes,
        index_bytes,
        wrong_px,
        deviation_m,
    }
}

const VARIANTS: [Variant; 9] = [
    variant("doubled", 1.0, 3_540_000, 1_860_000, 0, 98.0),
    variant(
        "doubled,boundary-tolerance-m=1000",
        0.62,
        1_300_000,
        690_000,
        6,
        970.0,
    ),
    variant(
        "doubled,boundary-tolerance-m=5000",
        0.41,
        640_000,
        330_000,
        41,
        4_900.0,
    ),
    variant(
        "doubled,boundary-tolerance-m=20000",
        0.33,
        410_000,
        210_000,
        530,
        19_000.0,
    ),
    variant("pulled", 1.04, 1_330_000, 930_000, 0, 98.0),
    variant(
        "pulled,boundary-tolerance-m=1000",
        0.65,
        480_000,
        350_000,
        6,
        970.0,
    ),
    variant(
        "pulled,boundary-tolerance-m=5000",
        0.43,
        240_000,
        160_000,
        44,
        4_900.0,
    ),
    variant(
        "pulled,positions=local-f32",
        1.02,
        1_330_000,
        930_000,
        2,
        98.0,
    ),
    variant(
        "doubled,culling=none,walls=list",
        1.9,
        3_540_000,
        4_100_000,
        0,
        98.0,
    ),
];

const VIEWS: [(&str, &str, f64); 6] = [
    ("planet-134", "globe", 48.0),
    ("planet-134", "top-down", 12.0),
    ("planet-134", "horizon", 9.4),
    ("countries-110m", "globe", 22.0),
    ("countries-110m", "fill", 11.9),
    ("countries-110m", "horizon", 8.8),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args_os()
        .nth(1)
        .map(PathBuf::from)
        .ok_or("usage: sample_report DIR")?;
    let cases: Vec<CaseKey> = VIEWS
        .iter()
        .flat_map(|(scene, view, _)| {
            let passes = ["bound", "floor"].map(|pass| pass_key(scene, view, pass));
            let variants = VARIANTS.iter().map(|v| key(scene, view, v.name));
            passes.into_iter().chain(variants)
        })
        .collect();
    let plan = RunPlan {
        skipped_scenes: vec![(
            "us-states".to_owned(),
            "ne_10m_admin_1_states.geojson is not in the data folder".to_owned(),
        )],
        cases,
        frames: FRAMES,
        warm_up: 5,
        ..RunPlan::default()
    };
    let run = RunFolder::create(&folder, &environment(), &plan)?;
    let mut noise = Noise(1);
    for (scene, view, base_ms) in VIEWS {
        draw_pictures(&folder, scene, view)?;
        for (pass, ms) in [("bound", BOUND_MS), ("floor", FLOOR_MS)] {
            let key = pass_key(scene, view, pass);
            let times: Vec<f64> = (0..FRAMES).map(|_| ms * noise.factor()).collect();
            run.append_samples(&samples(&key, &times))?;
            run.append_summary(&full_screen_pass(key, &times))?;
        }
        for variant in &VARIANTS {
            record(
                &run,
                key(scene, view, variant.name),
                variant,
                base_ms,
                &mut noise,
            )?;
        }
    }
    let report = write_report(&folder)?;
    writeln!(std::io::stdout(), "{}", report.path.display())?;
    Ok(())
}

fn key(scene: &str, view: &str, variant: &str) -> CaseKey {
    CaseKey {
        scene: scene.to_owned(),
        view: view.to_owned(),
        backend: "vertex".to_owned(),
        variant: variant.to_owned(),
    }
}

fn pass_key(scene: &str, view: &str, pass: &str) -> CaseKey {
    CaseKey {
        backend: pass.to_owned(),
        ..key(scene, view, "full-screen")
    }
}

fn full_screen_pass(key: CaseKey, times: &[f64]) -> Summary {
    Summary {
        reason: "a full-screen pass: it fills no region, so it has no error".to_owned(),
        fill_cpu_ms: spread(times).map(|fill| fill.median),
        samples: FRAMES,
        ..Summary::new(key, Status::Ok)
    }
}

fn environment() -> RunEnvironment {
    RunEnvironment {
        schema: 1,
        commit: "0000000 (made-up figures)".to_owned(),
        started_unix_s: 1_760_000_000,
        cpu: "Invented CPU".to_owned(),
        cores: 2,
        memory_bytes: 8_000_000_000,
        os: "Linux".to_owned(),
        gpu: "llvmpipe (made-up figures)".to_owned(),
        device_type: "cpu".to_owned(),
        driver: "llvmpipe".to_owned(),
        driver_info: "made-up figures".to_owned(),
        api: "Vulkan".to_owned(),
        width: 1024,
        height: 1024,
        profile: "release".to_owned(),
        options: vec!["frames=40".to_owned(), "edges=planar".to_owned()],
        ..RunEnvironment::default()
    }
}

fn record(
    run: &RunFolder,
    key: CaseKey,
    variant: &Variant,
    base_ms: f64,
    noise: &mut Noise,
) -> Result<(), Box<dyn std::error::Error>> {
    let is = |view: &str, name: &str| key.view == view && key.variant == name;
    if key.scene == "countries-110m" && is("horizon", "doubled,culling=none,walls=list") {
        return Ok(()); // missing, as after a kill
    }
    let planet = key.scene == "planet-134";
    let (status, reason) = if planet && is("horizon", "pulled,positions=local-f32") {
        (
            Status::Skipped,
            "the adapter lacks shader storage buffers in the vertex stage",
        )
    } else if planet && is("globe", "doubled,culling=none,walls=list") {
        (
            Status::Failed,
            "out of memory: index buffer needs 4100000 bytes",
        )
    } else if planet && is("globe", "doubled,boundary-tolerance-m=20000") {
        (
            Status::Wrong,
            "530 pixels wrong, 88 of them outside the boundary band",
        )
    } else if is("fill", "doubled") {
        (Status::Ok, "the view is filled to the last pixel")
    } else {
        (Status::Ok, "")
    };
    let mut row = Summary::new(key.clone(), status);
    row.reason = reason.to_owned();
    if matches!(status, Status::Ok | Status::Wrong) {
        let median = base_ms * variant.time;
        let times: Vec<f64> = (0..FRAMES).map(|_| median * noise.factor()).collect();
        run.append_samples(&samples(&key, &times))?;
        measured(&mut row, variant, &times);
    }
    run.append_summary(&row)?;
    Ok(())
}

fn samples(key: &CaseKey, times: &[f64]) -> Vec<Sample> {
    times
        .iter()
        .zip(0..)
        .map(|(&time, frame)| Sample {
            scene: key.scene.clone(),
            view: key.view.clone(),
            backend: key.backend.clone(),
            variant: key.variant.clone(),
            frame,
            surface_gpu_ms: Some(2.1),
            stencil_gpu_ms: Some(time * 0.4),
            colour_gpu_ms: Some(time * 0.1),
            fill_gpu_ms: Some(time * 0.5),
            fill_cpu_ms: time,
            fill_wall_ms: time * 0.6,
        })
        .collect()
}

fn measured(row: &mut Summary, variant: &Variant, times: &[f64]) {
    let fill = spread(times);
    let median = fill.map(|fill| fill.median);
    row.surface_gpu_ms = Some(2.1);
    row.fill_gpu_ms = median.map(|ms| ms * 0.5);
    if !row.variant.contains("pulled") {
        row.stencil_gpu_ms = median.map(|ms| ms * 0.4);
        row.colour_gpu_ms = median.map(|ms| ms * 0.1);
    }
    row.fill_cpu_ms = median;
    row.fill_cpu_ms_p5 = fill.map(|fill| fill.p5);
    row.fill_cpu_ms_p95 = fill.map(|fill| fill.p95);
    row.bound_cpu_ms = Some(BOUND_MS);
    row.floor_cpu_ms = Some(FLOOR_MS);
    row.fill_over_bound_cpu = median.map(|ms| ms / BOUND_MS);
    row.geometry_bytes = Some(variant.vertex_bytes + variant.index_bytes);
    row.vertex_bytes = Some(variant.vertex_bytes);
    row.index_bytes = Some(variant.index_bytes);
    row.constant_bytes = Some(34_304);
    row.upload_bytes = Some(34_304);
    row.draws = Some(268);
    row.vertices = Some(variant.index_bytes / 4);
    row.filled_px = Some(301_214);
    row.mismatched_px = Some(variant.wrong_px);
    row.mismatched_px_outside_band = Some(if row.status == Status::Wrong { 88 } else { 0 });
    row.hausdorff_px = Some(if variant.wrong_px == 0 { 0.0 } else { 1.0 });
    row.boundary_deviation_m = Some(variant.deviation_m);
    row.boundary_tolerance_m = Some(100.0);
    row.regions_left_out = Some(61);
    row.left_out = (0..61)
        .map(|region| format!("region {region}: beyond the horizon"))
        .collect::<Vec<_>>()
        .join("; ");
    row.samples = FRAMES;
    let picture = |kind: &str| format!("images/{}-{}-{kind}.png", row.scene, row.view);
    row.reference_image = picture("reference");
    let exact = variant.wrong_px == 0;
    row.image = picture(if exact { "reference" } else { "coarse" });
    row.difference_image = picture(if exact { "same" } else { "difference" });
}

/// A disc with bands, the same a little shifted, and where the two differ.
fn draw_pictures(folder: &Path, scene: &str, view: &str) -> Result<(), image::ImageError> {
    let seed = f64::from(u32::try_from(view.len() * scene.len()).unwrap_or(7));
    let save = |kind: &str, pixel: &dyn Fn(f64, f64) -> [u8; 3]| {
        image::RgbImage::from_fn(SIDE_PX, SIDE_PX, |x, y| {
            let unit = |v: u32| f64::from(v) / f64::from(SIDE_PX) * 2.0 - 1.0;
            image::Rgb(pixel(unit(x), unit(y)))
        })
        .save(
            folder
                .join("images")
                .join(format!("{scene}-{view}-{kind}.png")),
        )
    };
    let shade = move |x: f64, y: f64| {
        if x.hypot(y) > 0.9 {
            return [8, 10, 22];
        }
        let wave = (x * 9.0 + (y * 5.0 + seed).sin() * 2.0).sin() + (y * 8.0 - x * seed).cos();
        match wave {
            w if w > 0.9 => [214, 106, 60],
            w if w > 0.2 => [96, 170, 110],
            w if w > -0.3 => [70, 140, 200],
            _ => [44, 52, 70],
        }
    };
    save("reference", &shade)?;
    save("coarse", &|x, y| shade(x + 0.004, y))?;
    save("same", &|_, _| [0, 0, 0])?;
    save("difference", &|x, y| {
        if shade(x, y) == shade(x + 0.004, y) {
            [0, 0, 0]
        } else {
            [255, 80, 80]
        }
    })
}

/// Multiplicative noise with an occasional slow frame, from a fixed seed.
struct Noise(u64);

impl Noise {
    fn factor(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let uniform = (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        0.97 + 0.06 * uniform + if uniform > 0.93 { 0.1 } else { 0.0 }
    }
}
