// SPDX-License-Identifier: MIT OR Apache-2.0
//! The run: `scenes → meshes → FrameInput → reference and backends → figures → samples → CSV`.

use crate::images::{drop_alpha, file_stem, write_rgb};
use crate::{BenchCase, BenchError, BenchOptions, SceneGroup, Technique, environment, group_cases};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_conformance::{
    Verdict, boundary_band, checks_nothing, compare, difference_rgb, verdict,
};
use terrafill_core::{MeshOptions, RegionMesh};
use terrafill_frame::{
    Backend, BackendError, Frame, FrameInput, FrameTimes, MemoryUse, PreparedScene, TimedBackend,
    paint,
};
use terrafill_gpu::{Baseline, CpuStopwatch, Gpu, GpuOptions, SharedStage, Stage};
use terrafill_reference::ReferenceBackend;
use terrafill_results::{
    Baselines, CaseKey, ErrorFigures, RunEnvironment, RunError, RunFolder, RunPlan, Sample, Status,
    Summary, median, quantile,
};
use terrafill_scene::{PlanOptions, Scene, SceneError, SurfaceMesh, shipped_scene_names};
use terrafill_vertex::{ColourWay, VertexBackend};

/// What a run came to.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BenchOutcome {
    /// Cases whose picture is right, baselines not counted.
    pub ok: usize,
    /// Cases whose picture is wrong, sweeps not counted.
    pub wrong: usize,
    /// Points of a sweep whose picture is wrong: their error is what the sweep shows.
    pub wrong_in_sweep: usize,
    /// Cases that broke off.
    pub failed: usize,
    /// Cases that the device cannot run.
    pub skipped: usize,
    /// Scenes left out, with the reason.
    pub skipped_scenes: Vec<(String, String)>,
}

/// Runs what `options` ask for.
///
/// # Errors
/// [`BenchError`] for wrong input, no device, or a folder that cannot be written. What was measured
/// before stays.
pub fn run(options: &BenchOptions) -> Result<BenchOutcome, BenchError> {
    for backend in &options.backends {
        if backend != "vertex" {
            return Err(BenchError::UnknownBackend {
                found: backend.clone(),
                allowed: "vertex".to_owned(),
            });
        }
    }
    let (groups, skipped_scenes) = plan_groups(options)?;
    let gpu = Gpu::open(&GpuOptions {
        adapter: options.adapter.clone(),
        ..GpuOptions::default()
    })
    .map_err(BenchError::NoDevice)?;
    let plan = RunPlan {
        cases: groups
            .iter()
            .flat_map(|group| group.cases.iter().map(|case| case.key.clone()))
            .collect(),
        skipped_scenes: skipped_scenes.clone(),
        frames: options.frame_count(),
        warm_up: options.warm_up_count(),
    };
    let environment = environment(&gpu.facts, options);
    let folder = if options.resume {
        refuse_other_setup(&RunFolder::open(&options.out)?, &environment)?;
        RunFolder::resume(&options.out, &plan)?
    } else {
        RunFolder::create(&options.out, &environment, &plan)?
    };
    let missing = folder.missing()?;
    let progress = progress_bar(&plan, &missing);
    for group in &groups {
        let is_done = group.cases.iter().all(|case| !missing.contains(&case.key));
        if !is_done {
            GroupRun::new(&gpu, options, &folder, group, &progress)?.run()?;
        }
    }
    progress.finish_and_clear();
    Ok(outcome(&groups, &folder.summaries()?, skipped_scenes))
}

/// Rows of a run are compared with one another, so the rest of it is measured in the same way. The
/// plan does not hold all of that: size, device, driver, shaders and code are in the environment.
fn refuse_other_setup(folder: &RunFolder, now: &RunEnvironment) -> Result<(), RunError> {
    let then = folder.environment()?;
    // Whether the tree is clean changes with every edit, also of a text that nothing runs.
    let commit = |of: &RunEnvironment| of.commit.trim_end_matches("+dirty").to_owned();
    let aspects: [(&str, String, String); 6] = [
        ("options", then.options.join(" "), now.options.join(" ")),
        ("device", then.gpu.clone(), now.gpu.clone()),
        ("driver", then.driver_info.clone(), now.driver_info.clone()),
        (
            "shader hash",
            then.shader_hash.clone(),
            now.shader_hash.clone(),
        ),
        ("profile", then.profile.clone(), now.profile.clone()),
        ("commit", commit(&then), commit(now)),
    ];
    match aspects.into_iter().find(|(_, then, now)| then != now) {
        None => Ok(()),
        Some((what, then, now)) => Err(RunError::Occupied {
            path: folder.path().to_owned(),
            message: format!("cannot resume with {what} {now:?}, it was begun with {then:?}"),
        }),
    }
}

type SkippedScenes = Vec<(String, String)>;

/// Scenes with missing data are skipped with that reason; wrong ones, and those whose regions cannot
/// be meshed, stop the run before it starts.
fn plan_groups(options: &BenchOptions) -> Result<(Vec<SceneGroup>, SkippedScenes), BenchError> {
    let names: Vec<String> = if options.scenes.is_empty() {
        shipped_scene_names()
            .into_iter()
            .map(str::to_owned)
            .collect()
    } else {
        options.scenes.clone()
    };
    let mut groups = Vec::new();
    let mut skipped = Vec::new();
    for name in &names {
        match open_scene(name, options.data_dir.as_deref()) {
            Ok(scene) => {
                build_meshes(&scene, scene.mesh.boundary_tolerance_m)?;
                if groups
                    .iter()
                    .any(|group: &SceneGroup| group.scene.name == scene.name)
                {
                    return Err(BenchError::SceneTwice { name: scene.name });
                }
                let scene = Arc::new(scene);
                for view in &scene.views {
                    groups.push(group_cases(&scene, view, options));
                }
            }
            Err(error @ SceneError::DataMissing { .. }) => {
                skipped.push((name.clone(), error.to_string()));
            }
            Err(error) => return Err(error.into()),
        }
    }
    if let Some(shard) = options.shard {
        let mut index = 0;
        groups.retain(|_| {
            index += 1;
            (index - 1) % shard.count == shard.index - 1
        });
    }
    Ok((groups, skipped))
}

/// A scene by the name of a shipped one, or by the path of a scene file (with `/` or `.toml` in it).
///
/// # Errors
/// [`SceneError`].
pub fn open_scene(name: &str, data_dir: Option<&Path>) -> Result<Scene, SceneError> {
    if name.contains('/') || name.ends_with(".toml") {
        Scene::load(Path::new(name), data_dir)
    } else {
        Scene::shipped(name, data_dir)
    }
}

fn progress_bar(plan: &RunPlan, missing: &[CaseKey]) -> ProgressBar {
    let bar = ProgressBar::new(plan.cases.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} cases · {eta} · {msg}")
    {
        bar.set_style(style);
    }
    bar.set_position((plan.cases.len() - missing.len()) as u64);
    bar
}

fn outcome(
    groups: &[SceneGroup],
    summaries: &[Summary],
    skipped_scenes: SkippedScenes,
) -> BenchOutcome {
    let cases: BTreeMap<&CaseKey, &BenchCase> = groups
        .iter()
        .flat_map(|group| group.cases.iter().map(|case| (&case.key, case)))
        .collect();
    let mut outcome = BenchOutcome {
        skipped_scenes,
        ..BenchOutcome::default()
    };
    for summary in summaries {
        let Some(case) = cases.get(&summary.key()) else {
            continue;
        };
        match (summary.status, case.technique) {
            (_, Technique::Baseline(_)) => {}
            (Status::Ok, _) => outcome.ok += 1,
            (Status::Wrong, _) if case.is_sweep => outcome.wrong_in_sweep += 1,
            (Status::Wrong, _) => outcome.wrong += 1,
            (Status::Failed, _) => outcome.failed += 1,
            (Status::Skipped, _) => outcome.skipped += 1,
        }
    }
    outcome
}

/// A case with what draws it and what the probe frame showed.
struct RunningCase<'a> {
    case: &'a BenchCase,
    drawer: Drawer,
    probe: Probe,
    /// Frames measured by an earlier, killed process.
    first_frame: u32,
}

enum Drawer {
    Baseline(Baseline),
    Vertex(Box<VertexBackend>, Rc<FrameInput>),
    /// Cannot be timed; the probe says why.
    None,
}

/// The probe frame and what it says about the case.
#[derive(Default)]
struct Probe {
    status: Option<Status>,
    reason: String,
    memory: Option<MemoryUse>,
    figures: Option<ErrorFigures>,
    frame: Option<Frame>,
    regions_drawn: Option<u64>,
    regions_left_out: Option<u64>,
    left_out: String,
    boundary_deviation_m: Option<f64>,
    plan_cpu_ms: Option<f64>,
    image: String,
    difference_image: String,
}

/// Why two cells of such a row are empty.
const ALTERNATING: &str =
    "stencil and colour alternate region by region: no GPU times of their own";

impl Probe {
    fn remark(&mut self, remark: &str) {
        if !self.reason.is_empty() {
            self.reason.push_str("; ");
        }
        self.reason.push_str(remark);
    }
}

/// One scene and view being measured.
struct GroupRun<'a> {
    options: &'a BenchOptions,
    folder: &'a RunFolder,
    group: &'a SceneGroup,
    progress: &'a ProgressBar,
    stage: SharedStage,
    /// What the default mesh options give; views of other options share its surface.
    input: Rc<FrameInput>,
    reference: Frame,
    disagreements: (u64, u64),
    reference_image: String,
}

impl<'a> GroupRun<'a> {
    fn new(
        gpu: &Arc<Gpu>,
        options: &'a BenchOptions,
        folder: &'a RunFolder,
        group: &'a SceneGroup,
        progress: &'a ProgressBar,
    ) -> Result<Self, BenchError> {
        let (scene, view) = (&group.scene, &group.view);
        progress.set_message(format!("{}/{}: reference", scene.name, view.name));
        let device = |source| BenchError::Device {
            scene: scene.name.clone(),
            view: view.name.clone(),
            source,
        };
        let surface = Arc::new(SurfaceMesh::ellipsoid(&scene.body, scene.surface_rows));
        let meshes = build_meshes(scene, scene.mesh.boundary_tolerance_m)?;
        let prepared = PreparedScene::new(scene, meshes, surface);
        let input = FrameInput::new(&prepared, view, options.size, PlanOptions::default());
        let stage = Stage::shared(gpu, options.size).map_err(device)?;
        let judged = ReferenceBackend::new().judge(&input).map_err(device)?;
        let band = boundary_band(&judged.frame);
        let disagree = judged.disagreements.iter().zip(&band);
        let outside = disagree.filter(|&(&differ, &near)| differ && !near).count() as u64;
        let reference_image = write_rgb(
            folder.path(),
            &format!("{}_{}_reference", scene.name, view.name),
            options.size,
            &paint(&judged.frame),
        )?;
        Ok(Self {
            options,
            folder,
            group,
            progress,
            stage,
            input: Rc::new(input),
            disagreements: (judged.disagreement_px(), outside),
            reference: judged.frame,
            reference_image,
        })
    }

    fn run(&self) -> Result<(), BenchError> {
        let done: Vec<Sample> = self.folder.samples()?;
        let mut running = Vec::new();
        for case in &self.group.cases {
            self.progress.set_message(format!("{}: probe", case.key));
            let first_frame = done
                .iter()
                .filter(|sample| sample.key() == case.key)
                .count();
            running.push(RunningCase {
                first_frame: u32::try_from(first_frame).unwrap_or(u32::MAX),
                ..self.probe(case)?
            });
        }
        self.measure(&mut running)?;
        let samples = self.folder.samples()?;
        let baselines = baselines(&self.group.cases, &samples);
        for case in &running {
            self.folder
                .append_summary(&self.summary(case, &samples, baselines))?;
            self.progress.inc(1);
        }
        Ok(())
    }

    /// Prepares a case and draws its probe frame. What goes wrong becomes the case's status.
    fn probe(&self, case: &'a BenchCase) -> Result<RunningCase<'a>, BenchError> {
        let (drawer, probe) = match case.technique {
            Technique::Baseline(kind) => match Baseline::new(kind, &self.stage) {
                Ok(baseline) => (Drawer::Baseline(baseline), Probe::default()),
                Err(error) => (Drawer::None, failed_probe(&error)),
            },
            Technique::Vertex(variant) => {
                let input = self.input_for(case)?;
                let drawn = VertexBackend::new(&self.stage, variant).and_then(|mut backend| {
                    let memory = backend.prepare(&input)?;
                    let frame = backend.render(&input)?;
                    Ok((backend, memory, frame))
                });
                match drawn {
                    Ok((mut backend, memory, frame)) => {
                        let probe = self.judge(case, &mut backend, &input, memory, frame)?;
                        (Drawer::Vertex(Box::new(backend), input), probe)
                    }
                    Err(error) => (Drawer::None, failed_probe(&error)),
                }
            }
        };
        Ok(RunningCase {
            case,
            drawer,
            probe,
            first_frame: 0,
        })
    }

    fn input_for(&self, case: &BenchCase) -> Result<Rc<FrameInput>, BenchError> {
        let scene = &self.group.scene;
        match case.boundary_tolerance_m {
            Some(tolerance) if case.is_sweep => {
                let meshes = build_meshes(scene, tolerance)?;
                let prepared = self.input.scene.with_meshes(meshes);
                let input = self.input.remeshed(&prepared, PlanOptions::default());
                Ok(Rc::new(input))
            }
            _ => Ok(Rc::clone(&self.input)),
        }
    }

    fn judge(
        &self,
        case: &BenchCase,
        backend: &mut VertexBackend,
        input: &FrameInput,
        memory: MemoryUse,
        frame: Frame,
    ) -> Result<Probe, BenchError> {
        let mut probe = Probe {
            memory: Some(memory),
            regions_drawn: Some(input.plan.regions.len() as u64),
            regions_left_out: Some(input.plan.left_out.len() as u64),
            left_out: input.plan.left_out_summary(&input.scene.meshes),
            boundary_deviation_m: largest_deviation(&input.scene.meshes),
            plan_cpu_ms: plan_cpu_ms(input),
            ..Probe::default()
        };
        match compare(&self.reference, &frame) {
            Ok(figures) => {
                let (status, reasons) = match verdict(&figures) {
                    Verdict::Pass => (Status::Ok, Vec::new()),
                    Verdict::Fail(reasons) => (Status::Wrong, reasons),
                };
                probe.status = Some(status);
                probe.reason = reasons.join("; ");
                probe.figures = Some(figures);
            }
            Err(error) => {
                probe.status = Some(Status::Failed);
                probe.reason = error.to_string();
            }
        }
        if backend.variant().colour == ColourWay::Rectangle {
            probe.remark(ALTERNATING);
        }
        let is_main =
            backend.variant().name() == case.key.variant && !case.key.variant.contains('=');
        let is_wrong = probe.status == Some(Status::Wrong) && !case.is_sweep;
        if is_main || is_wrong {
            self.write_pictures(case, backend, input, &frame, &mut probe)?;
        }
        probe.frame = Some(frame);
        Ok(probe)
    }

    fn write_pictures(
        &self,
        case: &BenchCase,
        backend: &mut VertexBackend,
        input: &FrameInput,
        frame: &Frame,
        probe: &mut Probe,
    ) -> Result<(), BenchError> {
        let (folder, stem, size) = (self.folder.path(), file_stem(&case.key), self.options.size);
        if let Ok(picture) = backend.picture(input) {
            probe.image = write_rgb(folder, &stem, size, &drop_alpha(&picture.rgba))?;
        }
        if let Ok(rgb) = difference_rgb(&self.reference, frame) {
            probe.difference_image = write_rgb(folder, &format!("{stem}_difference"), size, &rgb)?;
        }
        Ok(())
    }

    /// Rounds: the surface once, then every case once, forwards and backwards in turn, starting one
    /// case later each time, so that no case always follows the same one.
    fn measure(&self, running: &mut [RunningCase<'_>]) -> Result<(), BenchError> {
        let device = |source| BenchError::Device {
            scene: self.group.scene.name.clone(),
            view: self.group.view.name.clone(),
            source,
        };
        let frames = self.options.frame_count();
        let needs_frames = |case: &RunningCase<'_>| {
            case.first_frame < frames && !matches!(case.drawer, Drawer::None)
        };
        if !running.iter().any(needs_frames) {
            return Ok(());
        }
        let warm_up = self.options.warm_up_count();
        let rounds = frames
            - running
                .iter()
                .map(|case| case.first_frame)
                .min()
                .unwrap_or(0);
        for round in 0..warm_up + rounds {
            self.progress.set_message(format!(
                "{}/{}: frame {round}",
                self.group.scene.name, self.group.view.name
            ));
            let mut stage = self.stage.borrow_mut();
            stage.prepare(&self.input).map_err(device)?;
            let surface_gpu_ms = stage.draw_surface().map_err(device)?;
            drop(stage);
            let mut rows = Vec::new();
            for index in round_order(running.len(), round) {
                let case = &mut running[index];
                let frame = (round.saturating_sub(warm_up)) + case.first_frame;
                if frame >= frames {
                    continue;
                }
                let times = match time(&mut case.drawer) {
                    None => continue,
                    Some(Ok(times)) => times,
                    Some(Err(error)) => {
                        case.probe = failed_probe(&error);
                        case.drawer = Drawer::None;
                        continue;
                    }
                };
                if round >= warm_up {
                    rows.push(sample(&case.case.key, frame, surface_gpu_ms, &times));
                }
            }
            self.folder.append_samples(&rows)?;
        }
        Ok(())
    }

    fn summary(
        &self,
        running: &RunningCase<'_>,
        samples: &[Sample],
        baselines: Baselines,
    ) -> Summary {
        let (case, probe) = (running.case, &running.probe);
        let own: Vec<&Sample> = samples.iter().filter(|s| s.key() == case.key).collect();
        let collect = |value: fn(&Sample) -> Option<f64>| -> Vec<f64> {
            own.iter().filter_map(|sample| value(sample)).collect()
        };
        let middle = |value: fn(&Sample) -> Option<f64>| median(&collect(value));
        let fill_cpu_ms = middle(|s| Some(s.fill_cpu_ms));
        let cpu = collect(|s| Some(s.fill_cpu_ms));
        let status = probe.status.unwrap_or(if own.is_empty() {
            Status::Failed
        } else {
            Status::Ok
        });
        // A wrong frame is never fast: its times stand in the row, but no ratio is formed.
        let fill_over_bound_cpu = (status == Status::Ok)
            .then(|| Some(fill_cpu_ms? / baselines.bound_cpu_ms?))
            .flatten();
        let figures = probe.figures;
        let counters = probe.frame.as_ref().and_then(|frame| frame.counters);
        let is_baseline = matches!(case.technique, Technique::Baseline(_));
        Summary {
            scene: case.key.scene.clone(),
            view: case.key.view.clone(),
            backend: case.key.backend.clone(),
            variant: case.key.variant.clone(),
            status,
            reason: self.reason(probe, is_baseline),
            surface_gpu_ms: middle(|s| s.surface_gpu_ms),
            fill_gpu_ms: middle(|s| s.fill_gpu_ms),
            fill_cpu_ms,
            bound_gpu_ms: baselines.bound_gpu_ms,
            bound_cpu_ms: baselines.bound_cpu_ms,
            floor_cpu_ms: baselines.floor_cpu_ms,
            fill_over_bound_cpu,
            geometry_bytes: probe.memory.map(|memory| memory.geometry_bytes()),
            upload_bytes: counters.map(|counters| counters.upload_bytes),
            draws: counters.map(|counters| counters.draws),
            vertices: counters.map(|counters| counters.vertices),
            filled_px: figures.map(|figures| figures.filled_px),
            mismatched_px: figures.map(|figures| figures.mismatched_px),
            mismatched_px_outside_band: figures.map(|f| f.mismatched_px_outside_band),
            hausdorff_px: figures.and_then(|figures| figures.hausdorff_px),
            left_out: probe.left_out.clone(),
            stencil_gpu_ms: middle(|s| s.stencil_gpu_ms),
            colour_gpu_ms: middle(|s| s.colour_gpu_ms),
            fill_wall_ms: middle(|s| Some(s.fill_wall_ms)),
            fill_cpu_ms_p5: quantile(&cpu, 0.05),
            fill_cpu_ms_p95: quantile(&cpu, 0.95),
            samples: u32::try_from(own.len()).unwrap_or(u32::MAX),
            regions_drawn: probe.regions_drawn,
            regions_left_out: probe.regions_left_out,
            non_finite: figures.map(|figures| figures.non_finite),
            reference_disagreements: (!is_baseline).then_some(self.disagreements.0),
            reference_disagreements_outside_band: (!is_baseline).then_some(self.disagreements.1),
            boundary_tolerance_m: case.boundary_tolerance_m,
            boundary_deviation_m: probe.boundary_deviation_m,
            area_error: figures.and_then(|figures| figures.area_error),
            tiny_regions: figures.map(|figures| figures.tiny_regions),
            buffers: probe.memory.map(|memory| memory.buffers),
            vertex_bytes: probe.memory.map(|memory| memory.vertex_bytes),
            index_bytes: probe.memory.map(|memory| memory.index_bytes),
            constant_bytes: probe.memory.map(|memory| memory.constant_bytes),
            vertex_shader_invocations: counters.and_then(|c| c.vertex_shader_invocations),
            clipper_invocations: counters.and_then(|c| c.clipper_invocations),
            clipper_primitives_out: counters.and_then(|c| c.clipper_primitives_out),
            fragment_shader_invocations: counters.and_then(|c| c.fragment_shader_invocations),
            image: probe.image.clone(),
            difference_image: probe.difference_image.clone(),
            reference_image: self.reference_image.clone(),
            plan_cpu_ms: probe.plan_cpu_ms,
        }
    }

    /// Why the status is what it is, why cells are empty, and what the view cannot show.
    fn reason(&self, probe: &Probe, is_baseline: bool) -> String {
        let mut reasons = Vec::new();
        if !probe.reason.is_empty() {
            reasons.push(probe.reason.clone());
        }
        if is_baseline {
            reasons.push("a full-screen pass: it fills no region, so it has no error".to_owned());
        } else {
            if checks_nothing(&self.reference) {
                reasons.push("no region boundary in sight: this view checks nothing".to_owned());
            }
            if let Some(note) = &self.group.view.note {
                reasons.push(note.clone());
            }
        }
        reasons.join("; ")
    }
}

/// Meshes of every region, or the first errors.
fn build_meshes(scene: &Scene, boundary_tolerance_m: f64) -> Result<Arc<[RegionMesh]>, BenchError> {
    let options = MeshOptions {
        boundary_tolerance_m,
        ..scene.mesh
    };
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &options);
    match meshes {
        Ok(meshes) => Ok(meshes.into()),
        Err(errors) => Err(BenchError::Mesh {
            lines: errors
                .iter()
                .map(|error| format!("{}: {error}", scene.name))
                .collect::<Vec<_>>()
                .join("\n"),
        }),
    }
}

fn largest_deviation(meshes: &[RegionMesh]) -> Option<f64> {
    let deviations = meshes.iter().map(|mesh| mesh.boundary_deviation_m);
    deviations.reduce(f64::max)
}

/// Median over a few plans of the same frame.
fn plan_cpu_ms(input: &FrameInput) -> Option<f64> {
    let plans = (0..9).map(|_| {
        let watch = CpuStopwatch::start();
        std::hint::black_box(input.remeshed(&input.scene, PlanOptions::default()));
        watch.cpu_ms()
    });
    median(&plans.collect::<Vec<_>>())
}

/// What the adapter lacks is skipped; everything else that breaks has failed.
fn failed_probe(error: &BackendError) -> Probe {
    Probe {
        status: Some(match error {
            BackendError::Unsupported { .. } => Status::Skipped,
            _ => Status::Failed,
        }),
        reason: error.to_string(),
        ..Probe::default()
    }
}

fn time(drawer: &mut Drawer) -> Option<Result<FrameTimes, BackendError>> {
    match drawer {
        Drawer::Baseline(baseline) => Some(baseline.time_frame()),
        Drawer::Vertex(backend, input) => Some(backend.time_frame(input)),
        Drawer::None => None,
    }
}

fn round_order(count: usize, round: u32) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    if count > 0 {
        order.rotate_left(round as usize % count);
    }
    if round % 2 == 1 {
        order.reverse();
    }
    order
}

fn sample(key: &CaseKey, frame: u32, surface_gpu_ms: Option<f64>, times: &FrameTimes) -> Sample {
    Sample {
        scene: key.scene.clone(),
        view: key.view.clone(),
        backend: key.backend.clone(),
        variant: key.variant.clone(),
        frame,
        surface_gpu_ms: times.surface_gpu_ms.or(surface_gpu_ms),
        stencil_gpu_ms: times.stencil_gpu_ms,
        colour_gpu_ms: times.colour_gpu_ms,
        fill_gpu_ms: times.fill_gpu_ms,
        fill_cpu_ms: times.fill_cpu_ms,
        fill_wall_ms: times.fill_wall_ms,
    }
}

/// Medians of the two full-screen passes of this scene and view.
fn baselines(cases: &[BenchCase], samples: &[Sample]) -> Baselines {
    let of = |backend: &str, value: fn(&Sample) -> Option<f64>| {
        let case = cases.iter().find(|case| case.key.backend == backend)?;
        let own = samples.iter().filter(|sample| sample.key() == case.key);
        median(&own.filter_map(value).collect::<Vec<_>>())
    };
    Baselines {
        bound_gpu_ms: of("bound", |sample| sample.fill_gpu_ms),
        bound_cpu_ms: of("bound", |sample| Some(sample.fill_cpu_ms)),
        floor_cpu_ms: of("floor", |sample| Some(sample.fill_cpu_ms)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_round_measures_every_case_once_and_the_order_changes() {
        for count in [1, 2, 5] {
            for round in 0..12 {
                let mut order = round_order(count, round);
                order.sort_unstable();
                assert_eq!(order, (0..count).collect::<Vec<_>>());
            }
        }
        let firsts: std::collections::BTreeSet<_> =
            (0..10).map(|round| round_order(5, round)[0]).collect();
        assert_eq!(firsts.len(), 5, "every case comes first at some time");
        assert_eq!(round_order(0, 3), Vec::<usize>::new());
    }
}
