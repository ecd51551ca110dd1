// SPDX-License-Identifier: MIT OR Apache-2.0
//! One scene and view being measured: the reference judges, probes are compared, rounds are timed.

use crate::fingerprint::fingerprint;
use crate::images::{drop_alpha, file_stem, write_rgb};
use crate::memory::LayoutOfScene;
use crate::rounding::{objection, rounding_px};
use crate::scenes::{build_meshes, mesh_error};
use crate::summary::baselines;
use crate::technique::{AllTargets, SharedNativeGpu};
use crate::textured::{ShownPicture, TexturedReferences, write_cut_out};
use crate::{BenchCase, BenchError, BenchOptions, SceneGroup, Setting, Technique};
use indicatif::ProgressBar;
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_conformance::{
    BAND_RADIUS_PX, TextureErrors, Verdict, boundary_band, boundary_movement, compare_closely,
    difference_rgb, filled_only, verdict_of_moved, with_movement,
};
use terrafill_core::{MeshOptions, RegionMesh};
use terrafill_fill::{
    ColourWay, DeviceError, Frame, FrameInput, FrameTimes, MemoryUse, PositionFormat,
    PreparedScene, RouteChoice, VolumeBackend, paint,
};
use terrafill_gpu::{Baseline, CpuStopwatch, Gpu, RenderTargets};
use terrafill_reference::ReferenceBackend;
use terrafill_results::legacy::{
    Baselines, CaseKey, ErrorFigures, RunFolder, Sample, Status, median,
};
use terrafill_scene::{LeveledMeshes, PlanOptions};
use terrafill_surface::open_surface;

/// A case with what draws it and what the probe frame showed.
pub(crate) struct RunningCase<'a> {
    pub(crate) case: &'a BenchCase,
    pub(crate) drawer: Drawer,
    pub(crate) probe: Probe,
    /// Frames measured by an earlier, killed process.
    pub(crate) first_frame: u32,
}

pub(crate) enum Drawer {
    Baseline(Baseline),
    Volumes(Box<dyn VolumeBackend>, Rc<FrameInput>),
    /// Cannot be timed; the probe says why.
    None,
}

/// The probe frame and what it says about the case.
#[derive(Default)]
pub(crate) struct Probe {
    pub(crate) status: Option<Status>,
    pub(crate) reason: String,
    pub(crate) memory: Option<MemoryUse>,
    pub(crate) figures: Option<ErrorFigures>,
    pub(crate) frame: Option<Frame>,
    pub(crate) regions_drawn: Option<u64>,
    pub(crate) regions_left_out: Option<u64>,
    pub(crate) left_out: String,
    pub(crate) boundary_deviation_m: Option<f64>,
    pub(crate) wall_height_m: Option<f64>,
    pub(crate) cap_triangles: Option<u64>,
    pub(crate) plan_cpu_ms: Option<f64>,
    pub(crate) image: String,
    pub(crate) difference_image: String,
    pub(crate) mask_hash: String,
    pub(crate) ids_hash: String,
    /// Reference beside it where it is the textured one.
    pub(crate) reference_image: Option<String>,
    pub(crate) texture_route: String,
    pub(crate) texture_errors: Option<TextureErrors>,
    pub(crate) colour_max: Option<u64>,
    pub(crate) colour_mean: Option<f64>,
}

/// Mesh options where they are not the scene's, how frames are planned, and which picture is shown.
type InputKey = (Option<MeshOptions>, PlanOptions, ShownPicture);

/// An input and the median CPU time of planning it.
type PlannedInput = (Rc<FrameInput>, Option<f64>);

type Judgement = Result<ErrorFigures, String>;

/// Why two cells of such a row are empty.
const ALTERNATING: &str =
    "stencil and colour alternate region by region: no GPU times of their own";

/// Why the texels of a floor are not judged.
const NOT_MAPPED: &str = "a floor: its fragments read their depth and sample the picture once, \
                          nowhere in particular, so that its texels have no error";

impl Probe {
    fn remark(&mut self, remark: &str) {
        if !self.reason.is_empty() {
            self.reason.push_str("; ");
        }
        self.reason.push_str(remark);
    }
}

/// One scene and view being measured.
pub(crate) struct GroupRun<'a> {
    pub(crate) options: &'a BenchOptions,
    pub(crate) folder: &'a RunFolder,
    pub(crate) group: &'a SceneGroup,
    pub(crate) progress: &'a ProgressBar,
    pub(crate) targets: AllTargets,
    /// What the default mesh options give; views of other options share its surface.
    pub(crate) input: Rc<FrameInput>,
    pub(crate) reference: Frame,
    /// The reference with all regions as one.
    filled_reference: Frame,
    /// The reference with pictures.
    textured_references: TexturedReferences,
    /// Inputs of other mesh or plan options, with how long their plans take.
    inputs: RefCell<Vec<(InputKey, PlannedInput)>>,
    leveled: RefCell<Option<PreparedScene>>,
    /// What was said of each picture: equal pictures get equal figures.
    judgements: RefCell<BTreeMap<(String, u64, bool), Judgement>>,
    pub(crate) disagreements: (u64, u64),
    pub(crate) reference_image: String,
}

impl<'a> GroupRun<'a> {
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        native_gpu: SharedNativeGpu,
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
        let surface = open_surface(options.surfaces, scene)?;
        let meshes = build_meshes(scene, &scene.mesh)?;
        let prepared = PreparedScene::new(scene, meshes, surface);
        let input = FrameInput::new(&prepared, view, options.size, PlanOptions::default())?;
        let targets = RenderTargets::shared(gpu, options.size).map_err(device)?;
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
            targets: AllTargets::new(targets, native_gpu, options.size),
            input: Rc::new(input),
            inputs: RefCell::default(),
            leveled: RefCell::default(),
            judgements: RefCell::default(),
            disagreements: (judged.disagreement_px(), outside),
            filled_reference: filled_only(&judged.frame),
            textured_references: TexturedReferences::default(),
            reference: judged.frame,
            reference_image,
        })
    }

    /// `missing`: cases without a row; those that are only drawn are drawn only if they are missing.
    pub(crate) fn run(&self, missing: &[CaseKey]) -> Result<(), BenchError> {
        let done: Vec<Sample> = self.folder.samples()?;
        let mut running = Vec::new();
        let mut layouts: Vec<(&str, String)> = Vec::new();
        for case in &self.group.cases {
            if case.frames == 0 && !missing.contains(&case.key) {
                continue;
            }
            self.progress.set_message(format!("{}: probe", case.key));
            let probed = self.probe(case)?;
            self.record_memory(case, &probed.probe, &mut layouts)?;
            if case.frames == 0 {
                let row = self.summary(&probed, &[], Baselines::default());
                self.folder.append_summary(&row)?;
                self.progress.inc(1);
                continue;
            }
            let first_frame = done
                .iter()
                .filter(|sample| sample.key() == case.key)
                .count();
            running.push(RunningCase {
                first_frame: u32::try_from(first_frame).unwrap_or(u32::MAX),
                ..probed
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

    /// Bytes of each layout, from the first case that stores the scene so.
    fn record_memory(
        &self,
        case: &BenchCase,
        probe: &Probe,
        layouts: &mut Vec<(&'a str, String)>,
    ) -> Result<(), BenchError> {
        let plain = own_mesh_options(case).is_none() && case.plan == PlanOptions::default();
        let of = (
            case.technique.backend(),
            Setting::new(case.technique).layout(),
        );
        if !plain || probe.memory.is_none() || layouts.contains(&of) {
            return Ok(());
        }
        let mut is_drawn = vec![false; self.input.scene.meshes.len()];
        for planned in &self.input.plan.regions {
            is_drawn[planned.mesh] = true;
        }
        let rows = LayoutOfScene {
            scene: &self.group.scene.name,
            layout: of.1.clone(),
            technique: &case.technique,
            meshes: &self.input.scene.meshes,
            is_drawn: &is_drawn,
            allocated: probe.memory,
        }
        .rows();
        layouts.push(of);
        Ok(self.folder.append_memory(&rows)?)
    }

    /// Prepares a case and draws its probe frame. What goes wrong becomes the case's status.
    fn probe(&self, case: &'a BenchCase) -> Result<RunningCase<'a>, BenchError> {
        self.probe_unless_rounded(case, rounding_px)
    }

    /// - `bound_px`: how far a format's roundings may move a boundary in a view
    fn probe_unless_rounded(
        &self,
        case: &'a BenchCase,
        bound_px: impl Fn(PositionFormat, &FrameInput) -> f64,
    ) -> Result<RunningCase<'a>, BenchError> {
        let (drawer, probe) = match case.technique {
            Technique::Baseline(kind) => match Baseline::new(kind, &self.targets.wgpu) {
                Ok(baseline) => (Drawer::Baseline(baseline), Probe::default()),
                Err(error) => (Drawer::None, failed_probe(&error)),
            },
            _ => {
                let (input, plan_cpu_ms) = self.input_for(case)?;
                // A cell of the matrix has to be right; elsewhere its error is what is asked for.
                let asked = case.roles.matrix && !case.roles.main;
                let positions = case.technique.positions().filter(|_| asked);
                let objection =
                    positions.and_then(|format| objection(format, bound_px(format, &input)));
                let drawn = case
                    .technique
                    .open(&self.targets)
                    .filter(|_| objection.is_none())
                    .map(|backend| backend.and_then(|backend| draw_probe(backend, &input)));
                match drawn {
                    None if let Some(reason) = objection => {
                        let probe = Probe {
                            status: Some(Status::Skipped),
                            reason,
                            ..Probe::default()
                        };
                        (Drawer::None, probe)
                    }
                    Some(Ok((mut backend, memory, frame))) => {
                        let probe = self.judge(case, &mut *backend, &input, memory, frame)?;
                        let probe = Probe {
                            plan_cpu_ms,
                            ..probe
                        };
                        (Drawer::Volumes(backend, input), probe)
                    }
                    Some(Err(error)) => (Drawer::None, failed_probe(&error)),
                    None => (Drawer::None, Probe::default()),
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

    fn input_for(&self, case: &BenchCase) -> Result<PlannedInput, BenchError> {
        let options = own_mesh_options(case);
        let key: InputKey = (options, case.plan, case.shown);
        let known = self.inputs.borrow();
        if let Some((_, input)) = known.iter().find(|(known, _)| *known == key) {
            return Ok(input.clone());
        }
        drop(known);
        let input = match &options {
            Some(options) => {
                let meshes = build_meshes(&self.group.scene, options)?;
                let prepared = self.input.scene.with_meshes(meshes);
                Rc::new(self.input.remeshed(&prepared, case.plan))
            }
            None if case.plan == PlanOptions::default() => Rc::clone(&self.input),
            None if case.plan.boundary_lod_px.is_some() => {
                Rc::new(self.input.remeshed(&self.leveled()?, case.plan))
            }
            None => Rc::new(self.input.remeshed(&self.input.scene, case.plan)),
        };
        // Where there is no picture to show, the backend says so.
        let input = match case.shown {
            ShownPicture::Scene => input,
            other => other.input(&input).map_or(input, Rc::new),
        };
        let plan_cpu_ms = plan_cpu_ms(&input, case.plan);
        let planned = (input, plan_cpu_ms);
        self.inputs.borrow_mut().push((key, planned.clone()));
        Ok(planned)
    }

    /// The scene with coarser levels of its boundaries.
    fn leveled(&self) -> Result<PreparedScene, BenchError> {
        let mut known = self.leveled.borrow_mut();
        if let Some(scene) = &*known {
            return Ok(scene.clone());
        }
        let scene = &self.group.scene;
        let meshes = LeveledMeshes::build(scene, &scene.mesh)
            .map_err(|errors| mesh_error(scene, &errors))?;
        let surface = Arc::clone(&self.input.scene.surface);
        Ok(known
            .insert(PreparedScene::leveled(scene, meshes, surface))
            .clone())
    }

    fn judge(
        &self,
        case: &BenchCase,
        backend: &mut dyn VolumeBackend,
        input: &FrameInput,
        memory: MemoryUse,
        frame: Frame,
    ) -> Result<Probe, BenchError> {
        let tells_apart = backend.tells_regions_apart();
        let mut probe = Probe {
            memory: Some(memory),
            regions_drawn: Some(input.plan.regions.len() as u64),
            regions_left_out: Some(input.plan.left_out.len() as u64),
            left_out: input.plan.left_out_summary(&input.scene.meshes),
            texture_route: backend.note().unwrap_or_default(),
            boundary_deviation_m: largest_deviation(&input.scene.meshes),
            wall_height_m: tallest_wall(input),
            cap_triangles: Some(cap_triangles(input)),
            mask_hash: fingerprint(frame.ids.iter().map(|&id| id.min(1))),
            ids_hash: match tells_apart {
                true => fingerprint(frame.ids.iter().copied()),
                false => String::new(),
            },
            ..Probe::default()
        };
        let moved_px = case.plan.boundary_lod_px.unwrap_or(0.0);
        match self.figures(&probe, &frame, moved_px > 0.0) {
            Ok(figures) => {
                let mut reasons = match verdict_of_moved(&figures, moved_px) {
                    Verdict::Pass => Vec::new(),
                    Verdict::Fail(reasons) => reasons,
                };
                let is_mask_right = reasons.is_empty();
                if is_mapped(&case.technique) {
                    let (errors, objections) = self.textured_references.judge(input, &frame);
                    probe.texture_errors = errors;
                    reasons.extend(objections);
                }
                probe.status = Some(match reasons.is_empty() {
                    true => Status::Ok,
                    false => Status::Wrong,
                });
                probe.reason = reasons.join("; ");
                if let Some(errors) = probe.texture_errors
                    && is_mask_right
                    && is_all_silhouette(&errors)
                {
                    // Nothing speaks against the texels, and nothing for them: not a pass.
                    probe.status = Some(Status::Skipped);
                    probe.reason = format!(
                        "all {} filled pixels lie at a silhouette: no texel to judge at this size",
                        errors.silhouette_px
                    );
                    probe.texture_errors = None;
                }
                probe.figures = Some(figures);
            }
            Err(error) => {
                probe.status = Some(Status::Failed);
                probe.reason = error;
            }
        }
        if is_textured(&case.technique) && !is_mapped(&case.technique) {
            probe.remark(NOT_MAPPED);
        }
        if case.frames > 0 && one_at_a_time(&case.technique) {
            probe.remark(ALTERNATING);
        }
        let is_main = case.roles.main && !case.key.variant.contains('=');
        let is_wrong = probe.status == Some(Status::Wrong) && !case.roles.sweep;
        if is_main || is_wrong {
            self.write_pictures(case, backend, input, &frame, &mut probe)?;
        }
        if is_textured(&case.technique) && (is_wrong || shows_chosen(case)) {
            self.write_textured_pictures(case, backend, input, &frame, &mut probe)?;
        }
        probe.frame = Some(frame);
        Ok(probe)
    }

    /// How the frame differs from the reference; a fill in one colour is judged as a mask.
    ///
    /// - `is_moved`: boundaries are drawn aside on purpose, and how far is asked
    fn figures(&self, probe: &Probe, frame: &Frame, is_moved: bool) -> Judgement {
        let as_mask = probe.ids_hash.is_empty();
        let hash = if as_mask {
            format!("mask {}", probe.mask_hash)
        } else {
            format!("ids {}", probe.ids_hash)
        };
        let key = (hash, frame.non_finite, is_moved);
        if let Some(known) = self.judgements.borrow().get(&key) {
            return known.clone();
        }
        // Asked for hardly any picture, so made only then.
        let look = OnceCell::new();
        let look = || {
            let made = || ReferenceBackend::new().look_closely(&self.input).ok();
            look.get_or_init(made).as_ref()
        };
        let as_judged = |id: u32| if as_mask { id.min(1) } else { id };
        let shows = |pixel: usize, id: u32| {
            look().is_some_and(|look| {
                let mut ids = look.ids_within(pixel, BAND_RADIUS_PX).into_iter();
                ids.any(|shown| as_judged(shown) == id)
            })
        };
        let filled;
        let (reference, frame) = if as_mask {
            filled = filled_only(frame);
            (&self.filled_reference, &filled)
        } else {
            (&self.reference, frame)
        };
        let figures = compare_closely(reference, frame, shows).and_then(|figures| {
            let Some(look) = is_moved.then(look).flatten() else {
                return Ok(figures);
            };
            let shown_at = |place| as_judged(look.id_at(place));
            let movement = boundary_movement(reference, frame, shown_at)?;
            Ok(with_movement(figures, movement))
        });
        let judgement = figures.map_err(|error| error.to_string());
        self.judgements.borrow_mut().insert(key, judgement.clone());
        judgement
    }

    fn write_pictures(
        &self,
        case: &BenchCase,
        backend: &mut dyn VolumeBackend,
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

    /// Cut-outs of the reference's picture, the backend's, and their difference ten times.
    fn write_textured_pictures(
        &self,
        case: &BenchCase,
        backend: &mut dyn VolumeBackend,
        input: &FrameInput,
        frame: &Frame,
        probe: &mut Probe,
    ) -> Result<(), BenchError> {
        let (folder, stem, size) = (self.folder.path(), file_stem(&case.key), self.options.size);
        let picture = match backend.picture(input) {
            Ok(picture) => picture,
            Err(error) => {
                probe.remark(&error.to_string());
                return Ok(());
            }
        };
        match self.textured_references.pictures(input, frame, &picture) {
            Ok(pictures) => {
                let write = |name: &str, rgb: &[u8]| {
                    write_cut_out(folder, name, size, pictures.centre, rgb)
                };
                probe.image = write(&format!("{stem}_cut"), &pictures.found)?;
                probe.difference_image = write(&format!("{stem}_cut_x10"), &pictures.difference)?;
                let reference = format!("{stem}_cut_reference");
                probe.reference_image = Some(write(&reference, &pictures.reference)?);
                probe.colour_max = pictures.largest;
                probe.colour_mean = pictures.mean;
            }
            Err(why) => probe.remark(&why),
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
        let frames_left = |case: &RunningCase<'_>| match case.drawer {
            Drawer::None => 0,
            _ => case.case.frames.saturating_sub(case.first_frame),
        };
        let rounds = running.iter().map(frames_left).max().unwrap_or(0);
        if rounds == 0 {
            return Ok(());
        }
        let warm_up = self.options.warm_up_count();
        for round in 0..warm_up + rounds {
            self.progress.set_message(format!(
                "{}/{}: frame {round}",
                self.group.scene.name, self.group.view.name
            ));
            let mut targets = self.targets.wgpu.borrow_mut();
            targets.prepare(&self.input).map_err(device)?;
            let surface_gpu_ms = targets.draw_surface().map_err(device)?;
            drop(targets);
            // Those that do not draw into those targets share others by the name of their backend.
            let mut drawn: Vec<&str> = Vec::new();
            for case in running.iter_mut() {
                let name = case.case.technique.backend();
                if let Drawer::Volumes(backend, input) = &mut case.drawer
                    && !drawn.contains(&name)
                {
                    backend.draw_own_surface(input).map_err(device)?;
                    drawn.push(name);
                }
            }
            let mut rows = Vec::new();
            for index in round_order(running.len(), round) {
                let case = &mut running[index];
                let frame = (round.saturating_sub(warm_up)) + case.first_frame;
                if frame >= case.case.frames {
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
                    // Who draws a surface of its own was not timed by that of the shared targets.
                    let surface = surface_gpu_ms.filter(|_| case.case.technique.shares_stage());
                    rows.push(sample(&case.case.key, frame, surface, &times));
                }
            }
            self.folder.append_samples(&rows)?;
        }
        Ok(())
    }
}

/// Prepares a backend and draws its probe frame.
type Drawn = (Box<dyn VolumeBackend>, MemoryUse, Frame);

fn draw_probe(
    mut backend: Box<dyn VolumeBackend>,
    input: &FrameInput,
) -> Result<Drawn, DeviceError> {
    let memory = backend.prepare(input)?;
    let frame = backend.render(input)?;
    Ok((backend, memory, frame))
}

/// Whether regions are filled with a picture.
fn is_textured(technique: &Technique) -> bool {
    technique.switches().is_some_and(|s| s.texture.is_some())
}

/// Whether what they are filled with has its place on the ground.
fn is_mapped(technique: &Technique) -> bool {
    let route = technique.switches().and_then(|switches| switches.texture);
    route.is_some_and(|route| route != RouteChoice::Floor)
}

/// Whether the case is a textured fill as it should be used.
fn shows_chosen(case: &BenchCase) -> bool {
    let route = case.technique.switches().and_then(|s| s.texture);
    route == Some(RouteChoice::Chosen) && case.shown == ShownPicture::Scene
}

/// Whether stencil and colour share a pass.
fn one_at_a_time(technique: &Technique) -> bool {
    let colour = technique.switches().map(|switches| switches.colour);
    matches!(colour, Some(ColourWay::Rectangle | ColourWay::Volume))
}

/// Mesh options of a case that sweeps through them.
fn own_mesh_options(case: &BenchCase) -> Option<MeshOptions> {
    let is_own = case.roles.sweep || case.roles.subdivision;
    Some(MeshOptions {
        boundary_tolerance_m: case.boundary_tolerance_m?,
        cap_step_deg: case.cap_step_deg?,
    })
    .filter(|_| is_own)
}

/// From the bottom cap to the top cap of the region drawn where they are farthest apart.
fn tallest_wall(input: &FrameInput) -> Option<f64> {
    let regions = input.plan.regions.iter();
    let walls = regions.map(|region| region.heights.top_m - region.heights.bottom_m);
    walls.reduce(f64::max)
}

/// Triangles of one cap of every region drawn.
fn cap_triangles(input: &FrameInput) -> u64 {
    let meshes = input.plan.regions.iter().map(|region| region.mesh);
    meshes
        .map(|mesh| input.scene.meshes[mesh].triangle_count() as u64)
        .sum()
}

fn largest_deviation(meshes: &[RegionMesh]) -> Option<f64> {
    let deviations = meshes.iter().map(|mesh| mesh.boundary_deviation_m);
    deviations.reduce(f64::max)
}

/// Median over a few plans of the same frame.
fn plan_cpu_ms(input: &FrameInput, options: PlanOptions) -> Option<f64> {
    let plans = (0..9).map(|_| {
        let watch = CpuStopwatch::start();
        std::hint::black_box(input.remeshed(&input.scene, options));
        watch.cpu_ms()
    });
    median(&plans.collect::<Vec<_>>())
}

/// What the adapter lacks, and switches that do not go together, are skipped; everything else that
/// breaks has failed.
fn failed_probe(error: &DeviceError) -> Probe {
    Probe {
        status: Some(match error {
            DeviceError::Unsupported { .. } | DeviceError::Switch(_) => Status::Skipped,
            _ => Status::Failed,
        }),
        reason: error.to_string(),
        ..Probe::default()
    }
}

fn time(drawer: &mut Drawer) -> Option<Result<FrameTimes, DeviceError>> {
    match drawer {
        Drawer::Baseline(baseline) => Some(baseline.time_frame()),
        Drawer::Volumes(backend, input) => Some(backend.time_frame(input)),
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

/// Whether every texel of a picture was left out of the comparison because a silhouette is near, as in
/// a very small image.
fn is_all_silhouette(errors: &TextureErrors) -> bool {
    let TextureErrors {
        compared_px,
        silhouette_px,
        missing_px,
        non_finite,
        ..
    } = *errors;
    (compared_px, missing_px, non_finite) == (0, 0, 0) && silhouette_px > 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_surface::EllipsoidKind;

    /// `None`, with the reason printed, where there is none and none is required.
    fn device() -> Option<Arc<Gpu>> {
        match Gpu::open(&terrafill_gpu::GpuOptions::default()) {
            Ok(gpu) => Some(gpu),
            Err(why) => {
                let required = std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_some();
                assert!(!required, "{why}");
                eprintln!("skipped: {why}");
                None
            }
        }
    }

    #[test]
    fn texels_that_are_all_at_silhouettes_are_no_verdict() {
        let all = TextureErrors {
            silhouette_px: 12,
            ..TextureErrors::default()
        };
        assert!(is_all_silhouette(&all));
        // Twins: no pixel at all, one without coordinates, one that is not finite, one compared.
        for other in [
            TextureErrors::default(),
            TextureErrors {
                missing_px: 1,
                ..all
            },
            TextureErrors {
                non_finite: 1,
                ..all
            },
            TextureErrors {
                compared_px: 1,
                ..all
            },
        ] {
            assert!(!is_all_silhouette(&other), "{other:?}");
        }
    }

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

    #[test]
    fn what_has_no_picture_is_skipped_with_that_reason() {
        let error = DeviceError::Switch(terrafill_fill::SwitchError {
            switch: "texture",
            found: "chosen for a scene without a picture".to_owned(),
            allowed: "plain".to_owned(),
        });
        let probe = failed_probe(&error);
        assert_eq!(probe.status, Some(Status::Skipped));
        assert!(probe.reason.contains("without a picture"));
        assert!(probe.texture_errors.is_none() && probe.image.is_empty());
        // Twin: what breaks has failed.
        let lost = failed_probe(&DeviceError::DeviceLost("gone".to_owned()));
        assert_eq!(lost.status, Some(Status::Failed));
    }

    #[test]
    fn coordinates_that_are_shifted_make_the_row_wrong() {
        let Some(gpu) = device() else { return };
        let place = tempfile::tempdir().expect("a folder");
        let options = BenchOptions {
            surfaces: &[&EllipsoidKind],
            scenes: vec!["california".to_owned()],
            backends: vec!["vertex".to_owned()],
            quick: true,
            out: place.path().join("run"),
            resume: false,
            data_dir: None,
            frames: Some(1),
            size: terrafill_scene::ImageSize {
                width: 96,
                height: 96,
            },
            shard: None,
            adapter: None,
            ladder: None,
            matrix: None,
            precision: Some(false),
        };
        let scene = Arc::new(terrafill_scene::Scene::shipped("california", None).expect("a scene"));
        let view = &scene.views[1];
        let group = crate::group_cases(&scene, view, &options);
        let folder =
            RunFolder::create(&options.out, &Default::default(), &Default::default()).expect("new");
        let native = crate::technique::NativeGpu::new(None);
        let progress = ProgressBar::hidden();
        let run = GroupRun::new(&gpu, native, &options, &folder, &group, &progress).expect("a run");
        let case = group
            .cases
            .iter()
            .find(|case| shows_chosen(case))
            .expect("textured");
        let judged = |shift_texels: f64| {
            let (input, _) = run.input_for(case).expect("an input");
            let backend = case
                .technique
                .open(&run.targets)
                .expect("no full-screen pass");
            let drawn = draw_probe(backend.expect("opens"), &input).expect("draws");
            let (mut backend, memory, mut frame) = drawn;
            let texture = frame.texture.as_mut().expect("textured");
            let columns = f64::from(texture.texels[0]);
            for pixel in texture.pixels.iter_mut().flatten() {
                pixel.uv[0] += shift_texels / columns;
            }
            run.judge(case, &mut *backend, &input, memory, frame)
                .expect("judged")
        };
        let right = judged(0.0);
        assert_eq!(
            (right.status, right.reason.as_str()),
            (Some(Status::Ok), "")
        );
        let wrong = judged(1.0);
        assert_eq!(wrong.status, Some(Status::Wrong));
        assert!(
            wrong.reason.contains("texels, allowed 0.25"),
            "{}",
            wrong.reason
        );
        let errors = wrong.texture_errors.expect("compared");
        assert!((errors.rms_texels[0] - 1.0).abs() < 0.1, "{errors:?}");
    }

    #[test]
    fn what_rounds_too_much_to_be_right_is_left_out_of_the_matrix_by_its_bound_alone() {
        let Some(gpu) = device() else { return };
        let place = tempfile::tempdir().expect("a folder");
        let options = BenchOptions {
            surfaces: &[&EllipsoidKind],
            scenes: vec!["square-200km".to_owned()],
            backends: vec!["vertex".to_owned()],
            quick: false,
            out: place.path().join("run"),
            resume: false,
            data_dir: None,
            frames: Some(1),
            size: terrafill_scene::ImageSize {
                width: 512,
                height: 512,
            },
            shard: None,
            adapter: None,
            ladder: None,
            matrix: Some(vec!["square-200km".to_owned()]),
            precision: Some(false),
        };
        let scene = Arc::new(terrafill_scene::Scene::shipped("square-200km", None).expect("ships"));
        let view = scene.views.iter().find(|view| view.name == "edge-1m5");
        let group = crate::group_cases(&scene, view.expect("a view"), &options);
        let folder =
            RunFolder::create(&options.out, &Default::default(), &Default::default()).expect("new");
        let native = crate::technique::NativeGpu::new(None);
        let progress = ProgressBar::hidden();
        let run = GroupRun::new(&gpu, native, &options, &folder, &group, &progress).expect("a run");
        let cell = |name: &str| {
            let mut cases = group.cases.iter();
            let case = cases.find(|case| case.key.variant == name);
            case.expect("a cell of the matrix")
        };
        let naive = cell("doubled,positions=ecef-f32");
        let found = run.probe(naive).expect("probed").probe;
        assert_eq!(found.status, Some(Status::Skipped));
        assert!(
            found.reason.starts_with("ecef-f32 rounds by up to ")
                && found.reason.ends_with(" px here, allowed 0.25"),
            "{}",
            found.reason
        );
        assert!(found.figures.is_none());
        // Twin: were its bound nothing, it would be drawn, and red.
        let unbounded = run.probe_unless_rounded(naive, |_, _| 0.0);
        let found = unbounded.expect("probed").probe;
        assert_eq!(found.status, Some(Status::Wrong), "{}", found.reason);
        assert!(
            found
                .figures
                .is_some_and(|figures| figures.mismatched_px > 100)
        );
        // What is right by its bound is asked, and so is everything that is not about positions.
        for name in [
            "doubled,positions=two-float",
            "doubled",
            "doubled,walls=list",
        ] {
            let found = run.probe(cell(name)).expect("probed").probe;
            assert_eq!(found.status, Some(Status::Ok), "{name}: {}", found.reason);
        }
    }
}
