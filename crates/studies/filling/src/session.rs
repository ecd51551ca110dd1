// SPDX-License-Identifier: MIT OR Apache-2.0
//! One scene and view being measured: the reference is drawn once, probes are compared with it, and
//! frames are timed.

use crate::cases::{FillCase, Purpose, ViewGroup};
use crate::driver_fault::{Driver, DriverFault};
use crate::images::{file_stem, write_rgb, zoomed};
use crate::keys::WALL_SHIFT_M;
use crate::memory::LayoutOfScene;
use crate::probe::{Probe, failed, tallest_wall_allowed};
use crate::rounding::{objection, rounding_px};
use crate::scenes::{build_meshes, mesh_error};
use crate::subject::Subject;
use crate::textured::{ShownPicture, TexturedReferences, write_cut_out};
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_conformance::{
    BAND_RADIUS_PX, BORDER_ROUNDING, ErrorFigures, Verdict as Comparison, boundary_band,
    boundary_movement, checks_nothing, compare_closely, difference_rgb, filled_only,
    movement_in_picture, verdict_of_moved, with_movement, worst_pixel,
};
use terrafill_core::{EdgeRule, MeshOptions};
use terrafill_fill::{
    Api, ColourWay, DeviceError, FillBackend, FillInput, Frame, FrameTimes, MemoryUse,
    PositionFormat, PreparedScene, RouteChoice, Targets, ids_hash, mask_hash, paint,
};
use terrafill_gpu::{Baseline, CpuStopwatch, SharedTargets, shared_targets};
use terrafill_reference::ReferenceBackend;
use terrafill_results::{Status, Verdict, median, quantile};
use terrafill_scene::{
    DrawnAs, FramePlan, ImageSize, LazyMesh, LeveledMeshes, PlanOptions, PlannedRegion,
};
use terrafill_study::{Context, Session, StudyError};
use terrafill_surface::open_surface;

enum Drawer {
    Baseline(Baseline),
    Volumes(Box<dyn FillBackend>, Rc<FillInput>),
}

/// Mesh options where they are not the scene's, how frames are planned, and which picture is shown.
type InputKey = (Option<MeshOptions>, PlanOptions, ShownPicture);

/// An input and the median CPU time of planning it.
type PlannedInput = (Rc<FillInput>, Option<f64>);

type Compared = Result<ErrorFigures, String>;

/// Why a row lacks the times of its passes.
const ALTERNATING: &str =
    "stencil and colour alternate region by region: no GPU times of their own";

/// Why texels of a fill that only reads depth and samples once are not compared.
const NOT_MAPPED: &str = "a lower limit: its fragments read their depth and sample the picture \
                          once, nowhere in particular, so that its texels have no error";

/// A wrong pixel is drawn 3 × 3 in a picture of differences, so that it shows in one scaled down.
const MARKER_RADIUS_PX: usize = 1;

/// The reference's picture of the view.
struct Reference {
    frame: Frame,
    /// With all regions as one.
    filled: Frame,
    /// Pixels on which its two inside tests disagree, in all and outside the boundary band.
    disagreements: (u64, u64),
    /// Of the boundary as drawn from the true one: largest and 99th percentile.
    moved_px_true: Option<[f64; 2]>,
    image: String,
}

/// One scene and view being measured.
pub(crate) struct ViewSession<'a> {
    group: &'a ViewGroup,
    folder: &'a Path,
    targets: Targets,
    /// Those of wgpu, which baselines draw on.
    wgpu: SharedTargets,
    /// What the scene's mesh options give; other inputs share its surface.
    input: Rc<FillInput>,
    /// Drawn when the first picture is compared: a process that only measures again needs none. By the
    /// scene's edge rule on its surface, and by what else a rival has.
    references: [OnceCell<Reference>; 4],
    /// The reference with pictures.
    textured_references: TexturedReferences,
    /// Inputs of other mesh or plan options, with how long their plans take.
    inputs: Vec<(InputKey, PlannedInput)>,
    leveled: Option<PreparedScene>,
    /// What the comparison of each picture found: equal pictures get equal figures.
    compared: BTreeMap<(String, u64, bool, usize), Compared>,
    /// What each technique's variants allocated, for the cases about memory; `None` for what could
    /// not be drawn.
    allocated: BTreeMap<(&'static str, String), Option<MemoryUse>>,
    drawers: BTreeMap<usize, Drawer>,
    /// Files of pictures by what they show: equal pictures share one.
    written: RefCell<BTreeMap<u64, String>>,
    /// GPU time of this block's surface pass by interface.
    surfaces: Vec<(Api, Option<f64>)>,
}

/// So many fills a software device draws by turns without forgetting what it compiled for some of them. Of 24 llvmpipe
/// forgot none, of 33 some: a frame that loads shaders again took 7 to 10 ms more than one of 12 ms that does not.
const FILLS_KEPT_COMPILED: usize = 24;

impl<'a> ViewSession<'a> {
    pub(crate) fn new(group: &'a ViewGroup, context: Context<'a>) -> Result<Self, StudyError> {
        let scene = &group.scene;
        let bad = |error: &dyn std::fmt::Display| StudyError::BadInput(error.to_string());
        let surface = open_surface(group.surfaces, scene).map_err(|error| bad(&error))?;
        let meshes = build_meshes(scene, &scene.mesh)?;
        let prepared = PreparedScene::new(scene, meshes, surface);
        Self::of_scene(group, &prepared, context)
    }

    /// Of a scene that is ready to be drawn already.
    pub(crate) fn of_scene(
        group: &'a ViewGroup,
        prepared: &PreparedScene,
        context: Context<'a>,
    ) -> Result<Self, StudyError> {
        let bad = |error: &dyn std::fmt::Display| StudyError::BadInput(error.to_string());
        let plan = PlanOptions::default();
        let input = FillInput::new(prepared, &group.view, group.size, plan);
        let input = input.map_err(|error| bad(&error))?;
        let targets = Targets::new(context.devices, group.size);
        let wgpu =
            shared_targets(&targets).map_err(|error| StudyError::NoDevice(error.to_string()))?;
        Ok(Self {
            group,
            folder: context.folder,
            targets,
            wgpu,
            input: Rc::new(input),
            references: Default::default(),
            textured_references: TexturedReferences::default(),
            inputs: Vec::new(),
            leveled: None,
            compared: BTreeMap::new(),
            allocated: BTreeMap::new(),
            drawers: BTreeMap::new(),
            written: RefCell::default(),
            surfaces: Vec::new(),
        })
    }

    fn broken(&self, why: &impl ToString) -> StudyError {
        StudyError::Broken {
            place: format!("{}/{}", self.group.scene.name, self.group.view.name),
            message: why.to_string(),
        }
    }

    /// What a case's picture is compared with.
    fn against(&self, case: &FillCase) -> Against {
        let scene = self.group.scene.edge_rule;
        match &case.subject {
            Subject::Baseline(_) => Against::scene(scene),
            Subject::Fill(technique, variant) => Against {
                edges: technique.edge_rule(variant, scene),
                is_on_body: technique.draws_own_surface(),
            },
        }
    }

    /// The scene's input with edges of this rule, for the reference.
    fn input_of(&self, edges: EdgeRule) -> FillInput {
        let mut input = FillInput::clone(&self.input);
        input.scene.edge_rule = edges;
        input
    }

    /// Its place among the references.
    fn place(&self, against: Against) -> usize {
        let is_others = against.edges != self.group.scene.edge_rule;
        2 * usize::from(against.is_on_body) + usize::from(is_others)
    }

    fn reference(&self, against: Against) -> Result<&Reference, StudyError> {
        let place = self.place(against);
        let cell = &self.references[place];
        if let Some(reference) = cell.get() {
            return Ok(reference);
        }
        let drawn = against.reference().judge(&self.input_of(against.edges));
        let drawn = drawn.map_err(|error| self.broken(&error))?;
        let band = boundary_band(&drawn.frame);
        let disagree = drawn.disagreements.iter().zip(&band);
        let outside = disagree.filter(|&(&differ, &near)| differ && !near).count() as u64;
        let (scene, view) = (&self.group.scene.name, &self.group.view.name);
        let mut name = format!("{scene}_{view}_reference");
        if place > 0 {
            name.push_str(&format!("_{place}"));
        }
        let image = write_rgb(self.folder, &name, self.group.size, &paint(&drawn.frame))?;
        Ok(cell.get_or_init(|| Reference {
            disagreements: (drawn.disagreement_px(), outside),
            moved_px_true: drawn.moved_px_true.as_deref().and_then(largest_and_p99),
            filled: filled_only(&drawn.frame),
            frame: drawn.frame,
            image,
        }))
    }

    fn input_for(&mut self, case: &FillCase) -> Result<PlannedInput, StudyError> {
        let mesh = case.mesh.as_ref().map(|(mesh, _)| *mesh);
        let plan = case.subject.plan();
        let key: InputKey = (mesh, plan, case.shown);
        if let Some((_, input)) = self.inputs.iter().find(|(known, _)| *known == key) {
            return Ok(input.clone());
        }
        let input = match &mesh {
            Some(options) => {
                let meshes = build_meshes(&self.group.scene, options)?;
                let prepared = self.input.scene.with_meshes(meshes);
                Rc::new(self.input.remeshed(&prepared, plan))
            }
            None if plan == PlanOptions::default() => Rc::clone(&self.input),
            None if plan.boundary_lod_px.is_some() => {
                let leveled = self.leveled()?;
                Rc::new(self.input.remeshed(&leveled, plan))
            }
            None => Rc::new(self.input.remeshed(&self.input.scene, plan)),
        };
        // Where there is no picture to show, the technique says so.
        let input = match case.shown {
            ShownPicture::Scene => input,
            other => other.input(&input).map_or(input, Rc::new),
        };
        let plan_cpu_ms = plan_cpu_ms(&input, plan);
        let planned = (input, plan_cpu_ms);
        self.inputs.push((key, planned.clone()));
        Ok(planned)
    }

    /// The scene with coarser levels of its boundaries.
    fn leveled(&mut self) -> Result<PreparedScene, StudyError> {
        if let Some(scene) = &self.leveled {
            return Ok(scene.clone());
        }
        let scene = &self.group.scene;
        let meshes = LeveledMeshes::build(scene, &scene.mesh)
            .map_err(|errors| mesh_error(scene, &errors))?;
        // Beforehand, so that no case is the one that makes what others find.
        LazyMesh::make_all(&meshes.meshes);
        let surface = Arc::clone(&self.input.scene.surface);
        let leveled = PreparedScene::leveled(scene, meshes, surface);
        Ok(self.leveled.insert(leveled).clone())
    }

    /// Opens a case's backend and draws its probe frame. What goes wrong is the case's verdict.
    fn draw(
        &mut self,
        case: &FillCase,
        bound_px: impl Fn(PositionFormat, &FillInput) -> f64,
    ) -> Result<Result<Drawn, Verdict>, StudyError> {
        let Subject::Fill(technique, variant) = &case.subject else {
            return Ok(Err(Verdict::failed("a full-screen pass fills nothing")));
        };
        let (input, plan_cpu_ms) = self.input_for(case)?;
        // A cell of the matrix has to be right; elsewhere its error is the question.
        let has_to_be_right = case.is(Purpose::Matrix) && !is_compared(case);
        let positions = case.subject.positions().filter(|_| has_to_be_right);
        let objection = positions.and_then(|format| objection(format, bound_px(format, &input)));
        if let Some(reason) = objection {
            return Ok(Err(Verdict::skipped(reason)));
        }
        let drawn = technique
            .open(&self.targets, variant)
            .and_then(|mut backend| {
                let watch = CpuStopwatch::start();
                let memory = backend.prepare(&input)?;
                let prepare_cpu_ms = watch.cpu_ms();
                let frame = backend.render(&input)?;
                Ok((backend, memory, frame, prepare_cpu_ms))
            });
        let memory = drawn.as_ref().ok().map(|(_, memory, ..)| *memory);
        self.allocated.insert(allocated_by(case), memory);
        Ok(match drawn {
            Ok((backend, memory, frame, prepare_cpu_ms)) => Ok(Drawn {
                backend,
                memory,
                frame,
                input,
                plan_cpu_ms,
                prepare_cpu_ms,
            }),
            Err(error) => Err(failed(&error)),
        })
    }

    fn verify_fill(&mut self, index: usize) -> Result<Verdict, StudyError> {
        let group = self.group;
        let case = &group.cases[index];
        let mut drawn = match self.draw(case, rounding_px)? {
            Ok(drawn) => drawn,
            Err(verdict) => return Ok(verdict),
        };
        let verdict = self.compare(case, &mut drawn)?;
        // Only what is timed is held on to: a matrix has hundreds of backends.
        if case.frames > 0 {
            let drawer = Drawer::Volumes(drawn.backend, drawn.input);
            self.drawers.insert(index, drawer);
        }
        Ok(verdict)
    }

    /// Holds a probe frame against the reference.
    fn compare(&mut self, case: &FillCase, drawn: &mut Drawn) -> Result<Verdict, StudyError> {
        let against = self.against(case);
        self.reference(against)?;
        let is_rival = case.is(Purpose::Rival);
        let mut probe = Probe::new(case, drawn.memory, &drawn.frame);
        // A rival makes no use of our plans and meshes.
        if !is_rival {
            probe.add_input(&drawn.input);
            probe.add("plan_cpu_ms", drawn.plan_cpu_ms);
            probe.add("prepare_cpu_ms", Some(drawn.prepare_cpu_ms));
        }
        let mesh = case.mesh.as_ref().map(|(mesh, _)| *mesh);
        let mesh = mesh.unwrap_or(self.group.scene.mesh);
        if case.is(Purpose::Subdivision) {
            probe.add("wall_bound_m", tallest_wall_allowed(&drawn.input, &mesh));
        }
        let shift_m = case.subject.figure(WALL_SHIFT_M.name, &drawn.input);
        probe.add("wall_shift_m", shift_m);
        if tells_needs(case) {
            match drawn.backend.needs(&drawn.input) {
                Ok(Some(needs)) => probe.add_needs(&needs),
                Ok(None) => {}
                Err(error) => return Ok(failed(&error)),
            }
        }
        // What is timed is a frame like the one before it.
        if case.frames > 0 {
            match drawn.backend.render(&drawn.input) {
                Ok(again) => {
                    if let Some(counters) = &again.counters {
                        probe.add_steady(counters);
                    }
                }
                Err(error) => return Ok(failed(&error)),
            }
        }
        let (mask_hash, ids_hash) = hashes(&*drawn.backend, &drawn.frame);
        let texture_route = drawn.backend.note().unwrap_or_default();
        let is_approximate = case.subject.is_approximate();
        let moved_px = moved_px(&drawn.input.plan);
        let hash = (mask_hash.as_str(), ids_hash.as_str());
        let options = case.subject.plan();
        let may_move = options.boundary_lod_px.is_some() || options.far_level_px.is_some();
        let is_moved = may_move && !is_approximate;
        match self.figures(hash, &drawn.frame, is_moved, against) {
            Ok(figures) if is_approximate => {
                let reasons = reasons_of(verdict_of_moved(&figures, 0.0));
                let reference = &self.reference(against)?.frame;
                let moved = movement_in_picture(reference, &drawn.frame);
                probe.add_errors(&ErrorFigures {
                    boundary_moved_px: moved.ok().flatten(),
                    ..figures
                });
                probe.set_approximate(&reasons);
            }
            Ok(figures) => {
                let mut reasons = reasons_of(verdict_of_moved(&figures, moved_px));
                let is_mask_right = reasons.is_empty();
                probe.add_errors(&figures);
                if is_mapped(&case.subject) {
                    let compared = self.textured_references.compare(&drawn.input, &drawn.frame);
                    probe.texture_errors = compared.0;
                    reasons.extend(compared.1);
                }
                probe.set_status(&reasons);
                if let Some(fault) = self.driver_fault(case) {
                    let settled = self.settle(fault, &reasons, (hash.1, moved_px), &drawn.frame)?;
                    (probe.status, probe.reason) = settled;
                }
                probe.let_off_if_all_silhouette(is_mask_right);
            }
            Err(error) => {
                probe.status = Status::Failed;
                probe.reason = error;
            }
        }
        if route(&case.subject).is_some() && !is_mapped(&case.subject) {
            probe.remark(NOT_MAPPED);
        }
        if case.frames > 0 && one_at_a_time(&case.subject) {
            probe.remark(ALTERNATING);
        }
        let is_shown = is_compared(case) || case.is(Purpose::Rival);
        let is_plain_main = is_shown && !case.variant_name().contains('=');
        let is_plain_main = is_plain_main || case.is(Purpose::Suite);
        // Of an approximate fill one picture a view shows what it is like.
        let is_wrong = probe.status == Status::Wrong && !is_approximate;
        if is_plain_main || is_wrong {
            self.write_pictures(case, drawn, ids_hash.is_empty(), &mut probe)?;
        }
        if route(&case.subject).is_some() && (is_wrong || shows_chosen(case)) {
            self.write_textured_pictures(case, drawn, &mut probe)?;
        }
        let reference = self.reference(against)?;
        let (all, outside) = reference.disagreements;
        probe.add_counts([
            ("reference_disagreements", Some(all)),
            ("reference_disagreements_outside_band", Some(outside)),
        ]);
        if let Some([largest, p99]) = reference.moved_px_true {
            probe.add("moved_px_true", Some(largest));
            probe.add("moved_px_true_p99", Some(p99));
        }
        if !probe.has_note("reference_image") {
            probe.note("reference_image", reference.image.clone());
        }
        if checks_nothing(&reference.frame) {
            probe.remark("no region boundary in sight: this view checks nothing");
        }
        if let Some(note) = &self.group.view.note {
            probe.remark(note);
        }
        probe.note("mask_hash", mask_hash);
        probe.note("ids_hash", ids_hash);
        probe.note("texture_route", texture_route);
        Ok(probe.verdict())
    }

    /// The pixels that the driver is known to lose of a case.
    fn driver_fault(&self, case: &FillCase) -> Option<&'static DriverFault> {
        if case.subject.api() != terrafill_gpu::API {
            return None;
        }
        let targets = self.wgpu.borrow();
        let facts = &targets.gpu().facts;
        let driver = Driver {
            name: &facts.name,
            info: &facts.driver_info,
        };
        let group = self.group;
        DriverFault::of(
            driver,
            &group.scene.name,
            &group.view.name,
            group.size,
            case,
        )
    }

    /// How a case ends of which the driver is known to lose pixels: as the picture without them.
    ///
    /// - `reasons`: against the picture as drawn
    fn settle(
        &self,
        fault: &DriverFault,
        reasons: &[String],
        (ids_hash, moved_px): (&str, f64),
        frame: &Frame,
    ) -> Result<(Status, String), StudyError> {
        let as_mask = ids_hash.is_empty();
        let against = Against::scene(self.group.scene.edge_rule);
        let (excused, differing) = fault.excused(frame, &self.reference(against)?.frame, as_mask);
        let figures = self.compare_pixels(&excused, as_mask, moved_px > 0.0, against);
        let against = figures.map(|figures| reasons_of(verdict_of_moved(&figures, moved_px)));
        let against = against.unwrap_or_else(|error| vec![error]);
        Ok(fault.settle(reasons, &against, differing))
    }

    /// How the frame differs from the reference; a fill in one colour is compared as a mask.
    ///
    /// - `hashes`: of its mask and of its ids, the latter empty for a fill in one colour
    /// - `is_moved`: boundaries are simplified on purpose, and how far they moved is measured
    /// - `against`: which reference
    fn figures(
        &mut self,
        (mask_hash, ids_hash): (&str, &str),
        frame: &Frame,
        is_moved: bool,
        against: Against,
    ) -> Compared {
        let as_mask = ids_hash.is_empty();
        let hash = if as_mask {
            format!("mask {mask_hash}")
        } else {
            format!("ids {ids_hash}")
        };
        let key = (hash, frame.non_finite, is_moved, self.place(against));
        if let Some(known) = self.compared.get(&key) {
            return known.clone();
        }
        let compared = self.compare_pixels(frame, as_mask, is_moved, against);
        self.compared.insert(key, compared.clone());
        compared
    }

    fn compare_pixels(
        &self,
        frame: &Frame,
        as_mask: bool,
        is_moved: bool,
        against: Against,
    ) -> Compared {
        let reference = self.reference(against);
        let reference = reference.map_err(|error| error.to_string())?;
        let input = self.input_of(against.edges);
        // Needed for hardly any picture, so made only then.
        let look = OnceCell::new();
        let look = || {
            let made = || against.reference().look_closely(&input).ok();
            look.get_or_init(made).as_ref()
        };
        let as_compared = |id: u32| if as_mask { id.min(1) } else { id };
        let shows = |pixel: usize, id: u32| {
            look().is_some_and(|look| {
                let mut ids = look.ids_within(pixel, BAND_RADIUS_PX).into_iter();
                ids.any(|shown| as_compared(shown) == id)
            })
        };
        let filled;
        let (expected, frame) = if as_mask {
            filled = filled_only(frame);
            (&reference.filled, &filled)
        } else {
            (&reference.frame, frame)
        };
        let may_round_to = |pixel: usize, id: u32| {
            look().is_some_and(|look| {
                let mut ids = look.ids_by_rounding(pixel, BORDER_ROUNDING).into_iter();
                ids.any(|shown| as_compared(shown) == id)
            })
        };
        let figures = compare_closely(expected, frame, may_round_to, shows).and_then(|figures| {
            let Some(look) = is_moved.then(look).flatten() else {
                return Ok(figures);
            };
            let shown_at = |place| as_compared(look.id_at(place));
            let movement = boundary_movement(expected, frame, shown_at)?;
            Ok(with_movement(figures, movement))
        });
        figures.map_err(|error| error.to_string())
    }

    fn stem(&self, case: &FillCase) -> String {
        file_stem(&[
            &self.group.scene.name,
            &self.group.view.name,
            case.subject.backend(),
            &case.variant_name(),
        ])
    }

    /// The technique's picture, its difference from the reference, and where that is worst.
    ///
    /// - `as_mask`: a fill in one colour, which is compared as a mask
    fn write_pictures(
        &self,
        case: &FillCase,
        drawn: &mut Drawn,
        as_mask: bool,
        probe: &mut Probe,
    ) -> Result<(), StudyError> {
        let (stem, size) = (self.stem(case), self.group.size);
        if let Ok(picture) = drawn.backend.picture(&drawn.input) {
            probe.note("image", self.write_once(&stem, size, &picture.rgb())?);
        }
        let reference = self.reference(self.against(case))?;
        let filled;
        let (expected, frame) = match as_mask {
            true => {
                filled = filled_only(&drawn.frame);
                (&reference.filled, &filled)
            }
            false => (&reference.frame, &drawn.frame),
        };
        if let Ok(rgb) = difference_rgb(expected, frame, MARKER_RADIUS_PX) {
            let name = format!("{stem}_difference");
            probe.note("difference_image", self.write_once(&name, size, &rgb)?);
        }
        if let (Ok(Some(worst)), Ok(exact)) = (
            worst_pixel(expected, frame),
            difference_rgb(expected, frame, 0),
        ) {
            // On the reference's surface: only ids are compared.
            let shown = Frame {
                ids: frame.ids.clone(),
                ..expected.clone()
            };
            let parts: [&[u8]; 3] = [&paint(expected), &paint(&shown), &exact];
            let (size, rgb) = zoomed(size, worst, &parts);
            let name = format!("{stem}_worst");
            probe.note("worst_image", self.write_once(&name, size, &rgb)?);
            probe.note("worst_px", format!("{}, {}", worst[0], worst[1]));
        }
        Ok(())
    }

    /// The file of these pixels, written unless an equal picture of this view was.
    fn write_once(&self, name: &str, size: ImageSize, rgb: &[u8]) -> Result<String, StudyError> {
        let mut hasher = DefaultHasher::new();
        (size.width, rgb).hash(&mut hasher);
        let shown = hasher.finish();
        let known = self.written.borrow().get(&shown).cloned();
        if let Some(path) = known {
            return Ok(path);
        }
        let path = write_rgb(self.folder, name, size, rgb)?;
        self.written.borrow_mut().insert(shown, path.clone());
        Ok(path)
    }

    /// Cut-outs of the reference's picture, the technique's, and their difference ten times.
    fn write_textured_pictures(
        &self,
        case: &FillCase,
        drawn: &mut Drawn,
        probe: &mut Probe,
    ) -> Result<(), StudyError> {
        let (stem, size) = (self.stem(case), self.group.size);
        let picture = match drawn.backend.picture(&drawn.input) {
            Ok(picture) => picture,
            Err(error) => {
                probe.remark(&error.to_string());
                return Ok(());
            }
        };
        let references = &self.textured_references;
        match references.pictures(&drawn.input, &drawn.frame, &picture) {
            Ok(pictures) => {
                for (note, end, rgb) in [
                    ("image", "cut", &pictures.found),
                    ("difference_image", "cut_x10", &pictures.difference),
                    ("reference_image", "cut_reference", &pictures.reference),
                ] {
                    let name = format!("{stem}_{end}");
                    let path = write_cut_out(self.folder, &name, size, pictures.centre, rgb)?;
                    probe.note(note, path);
                }
                probe.add_counts([("colour_max", pictures.largest)]);
                probe.add("colour_mean", pictures.mean);
            }
            Err(why) => probe.remark(&why),
        }
        Ok(())
    }

    fn verify_baseline(&mut self, index: usize) -> Verdict {
        let Subject::Baseline(kind) = self.group.cases[index].subject else {
            return Verdict::failed("no full-screen pass");
        };
        match Baseline::new(kind, &self.wgpu) {
            Ok(baseline) => {
                self.drawers.insert(index, Drawer::Baseline(baseline));
                Verdict {
                    status: Status::Ok,
                    reason: "a full-screen pass: it fills no region, so it has no error".to_owned(),
                    ..Verdict::default()
                }
            }
            Err(error) => failed(&error),
        }
    }

    fn verify_memory(&mut self, case: &FillCase, regions: usize) -> Result<Verdict, StudyError> {
        // Drawn already, unless a run that was broken off goes on here.
        if !self.allocated.contains_key(&allocated_by(case)) {
            drop(self.draw(case, rounding_px)?);
        }
        let allocated = self.allocated.get(&allocated_by(case)).copied().flatten();
        let mut is_drawn = vec![false; self.input.scene.meshes.len()];
        for planned in &self.input.plan.regions {
            is_drawn[planned.mesh] = true;
        }
        let meshes: &[LazyMesh] = &self.input.scene.meshes;
        let layout = LayoutOfScene {
            subject: &case.subject,
            meshes,
            is_drawn: &is_drawn,
        };
        let figures = layout.figures(regions, allocated);
        Ok(Verdict {
            status: Status::Ok,
            reason: match allocated {
                None => "by formula alone: nothing was drawn in this layout".to_owned(),
                Some(_) => String::new(),
            },
            figures,
            ..Verdict::default()
        })
    }
}

impl Session for ViewSession<'_> {
    fn verify(&mut self, index: usize) -> Result<Verdict, StudyError> {
        let group = self.group;
        let case = &group.cases[index];
        match (&case.subject, case.regions) {
            (_, Some(regions)) => self.verify_memory(case, regions),
            (Subject::Baseline(_), None) => Ok(self.verify_baseline(index)),
            (Subject::Fill(..), None) => self.verify_fill(index),
        }
    }

    fn recheck(
        &mut self,
        index: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, StudyError> {
        let group = self.group;
        let case = &group.cases[index];
        let hash_of = |name: &str| notes.get(name).map_or("", String::as_str);
        if matches!(case.subject, Subject::Baseline(_)) || hash_of("mask_hash").is_empty() {
            return self.verify(index);
        }
        let drawn = match self.draw(case, rounding_px)? {
            Ok(drawn) => drawn,
            Err(verdict) => return Ok(verdict),
        };
        let (mask_hash, ids_hash) = hashes(&*drawn.backend, &drawn.frame);
        if (hash_of("mask_hash"), hash_of("ids_hash")) != (&mask_hash, &ids_hash) {
            let reason = "its picture is another one than when it was verified";
            return Ok(Verdict {
                status: Status::Failed,
                reason: reason.to_owned(),
                ..Verdict::default()
            });
        }
        let drawer = Drawer::Volumes(drawn.backend, drawn.input);
        self.drawers.insert(index, drawer);
        Ok(Verdict {
            status,
            ..Verdict::default()
        })
    }

    /// Draws the surface once for each interface: fills leave its depth untouched.
    fn begin_block(&mut self) -> Result<(), StudyError> {
        let drawn = {
            let mut targets = self.wgpu.borrow_mut();
            let prepared = targets.prepare(&*self.input);
            prepared.and_then(|()| targets.draw_surface())
        };
        let gpu_ms = drawn.map_err(|error| self.broken(&error))?;
        self.surfaces = vec![(terrafill_gpu::API, gpu_ms)];
        let mut failure = None;
        for (&index, drawer) in &mut self.drawers {
            let api = self.group.cases[index].subject.api();
            let Drawer::Volumes(backend, input) = drawer else {
                continue;
            };
            if self.surfaces.iter().all(|(drawn, _)| *drawn != api) {
                match backend.draw_surface(input) {
                    Ok(gpu_ms) => self.surfaces.push((api, gpu_ms)),
                    Err(error) => failure = Some(error),
                }
            }
        }
        match failure {
            Some(error) => Err(self.broken(&error)),
            None => Ok(()),
        }
    }

    fn before_sample(&mut self, index: usize) -> Result<(), String> {
        let is_software = || self.wgpu.borrow().gpu().facts.is_software();
        match self.drawers.len() > FILLS_KEPT_COMPILED && is_software() {
            true => self.sample(index).map(drop),
            false => Ok(()),
        }
    }

    fn sample(&mut self, index: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let api = self.group.cases[index].subject.api();
        let drawer = self
            .drawers
            .get_mut(&index)
            .ok_or("it was not made ready")?;
        let times = match drawer {
            Drawer::Baseline(baseline) => baseline.time_frame(),
            Drawer::Volumes(backend, input) => backend.time_frame(input),
        };
        let times: FrameTimes = times.map_err(|error: DeviceError| error.to_string())?;
        let surface = self.surfaces.iter().find(|(drawn, _)| *drawn == api);
        let surface_gpu_ms = surface.and_then(|(_, gpu_ms)| *gpu_ms);
        let gpu = [
            ("surface_gpu_ms", times.surface_gpu_ms.or(surface_gpu_ms)),
            ("stencil_gpu_ms", times.stencil_gpu_ms),
            ("colour_gpu_ms", times.colour_gpu_ms),
            ("fill_gpu_ms", times.fill_gpu_ms),
        ];
        let gpu = gpu.into_iter().filter_map(|(name, ms)| Some((name, ms?)));
        let cpu = [
            ("fill_cpu_ms", times.fill_cpu_ms),
            ("fill_wall_ms", times.fill_wall_ms),
        ];
        Ok(cpu.into_iter().chain(gpu).collect())
    }
}

/// What a picture is compared with.
#[derive(Debug, Clone, Copy)]
struct Against {
    /// What a ring edge is.
    edges: EdgeRule,
    /// The body itself, and not the scene's surface as drawn.
    is_on_body: bool,
}

impl Against {
    /// What the scene says.
    fn scene(edges: EdgeRule) -> Self {
        Self {
            edges,
            is_on_body: false,
        }
    }

    fn reference(self) -> ReferenceBackend {
        match self.is_on_body {
            true => ReferenceBackend::on_body(),
            false => ReferenceBackend::new(),
        }
    }
}

/// A probe frame with what drew it.
struct Drawn {
    backend: Box<dyn FillBackend>,
    memory: MemoryUse,
    frame: Frame,
    input: Rc<FillInput>,
    plan_cpu_ms: Option<f64>,
    prepare_cpu_ms: f64,
}

/// What is drawn for bytes: a technique and its variant.
fn allocated_by(case: &FillCase) -> (&'static str, String) {
    (case.subject.backend(), case.variant_name())
}

/// `None` of no numbers.
fn largest_and_p99(values: &[f64]) -> Option<[f64; 2]> {
    Some([quantile(values, 1.0)?, quantile(values, 0.99)?])
}

/// Hashes of the mask and of the ids; the latter is empty where regions are not told apart.
fn hashes(backend: &dyn FillBackend, frame: &Frame) -> (String, String) {
    let ids = match backend.tells_regions_apart() {
        true => ids_hash(frame),
        false => String::new(),
    };
    (mask_hash(frame), ids)
}

/// How regions find their places in a picture; `None` of a plain fill.
fn route(subject: &Subject) -> Option<RouteChoice> {
    subject.switches()?.texture
}

/// Whether what regions are filled with has its place on the ground.
fn is_mapped(subject: &Subject) -> bool {
    route(subject).is_some_and(|route| route != RouteChoice::Floor)
}

/// Whether the case is a textured fill as it should be used.
fn shows_chosen(case: &FillCase) -> bool {
    route(&case.subject) == Some(RouteChoice::Chosen) && case.shown == ShownPicture::Scene
}

/// Whether it stands in every view's comparison.
fn is_compared(case: &FillCase) -> bool {
    case.is(Purpose::Main) || case.is(Purpose::Layout)
}

/// Whether what it holds and leaves out is told: of techniques as they should be used, and of what a view
/// needs.
fn tells_needs(case: &FillCase) -> bool {
    let is_plain_main = is_compared(case) && !case.variant_name().contains('=');
    case.is(Purpose::Needs) || is_plain_main || shows_chosen(case)
}

/// Whether stencil and colour share a pass.
fn one_at_a_time(subject: &Subject) -> bool {
    let colour = subject.switches().map(|switches| switches.colour);
    matches!(colour, Some(ColourWay::Rectangle | ColourWay::Volume))
}

/// What speaks against a picture.
fn reasons_of(verdict: Comparison) -> Vec<String> {
    match verdict {
        Comparison::Pass => Vec::new(),
        Comparison::Fail(reasons) => reasons,
    }
}

/// By how many pixels a plan may have moved boundaries on purpose. Where all that is drawn is as it was written,
/// boundaries are off by rounding alone, which the band around them allows for.
fn moved_px(plan: &FramePlan) -> f64 {
    let has_coarser = plan.regions.iter().any(|of| of.mesh != of.region);
    let is_flat = |of: &PlannedRegion| of.drawn_as == DrawnAs::FlatMesh;
    let has_flat = plan.regions.iter().any(is_flat);
    let options = &plan.options;
    let by_level = options.boundary_lod_px.filter(|_| has_coarser);
    let by_height = options.far_level_px.filter(|_| has_flat);
    by_level.unwrap_or(0.0) + by_height.unwrap_or(0.0)
}

/// Median over a few plans of the same frame.
fn plan_cpu_ms(input: &FillInput, options: PlanOptions) -> Option<f64> {
    let plans = (0..9).map(|_| {
        let watch = CpuStopwatch::start();
        std::hint::black_box(input.remeshed(&input.scene, options));
        watch.cpu_ms()
    });
    median(&plans.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::view_group;
    use crate::request::Wishes;
    use crate::tests::TECHNIQUES;
    use terrafill_core::VolumeHeights;
    use terrafill_fill::Devices;
    use terrafill_scene::{NearRectangle, PixelRect, Scene};
    use terrafill_study::Request;
    use terrafill_surface::EllipsoidKind;

    #[test]
    fn only_what_is_drawn_coarser_or_flat_may_be_moved() {
        let drawn = |region, mesh, drawn_as| PlannedRegion {
            region,
            mesh,
            heights: VolumeHeights {
                top_m: 1.0,
                bottom_m: -1.0,
            },
            screen_rect: PixelRect::full(ImageSize {
                width: 8,
                height: 8,
            }),
            near_rectangle: NearRectangle::Outside,
            drawn_as,
        };
        let plan = |regions: Vec<PlannedRegion>| FramePlan {
            regions,
            options: PlanOptions {
                boundary_lod_px: Some(0.5),
                far_level_px: Some(0.25),
                ..PlanOptions::default()
            },
            ..FramePlan::default()
        };
        let as_written = drawn(3, 3, DrawnAs::Volume);
        assert_eq!(moved_px(&plan(vec![as_written])), 0.0);
        let coarser = drawn(4, 20, DrawnAs::Volume);
        assert_eq!(moved_px(&plan(vec![as_written, coarser])), 0.5);
        let flat = drawn(5, 5, DrawnAs::FlatMesh);
        assert_eq!(moved_px(&plan(vec![as_written, flat])), 0.25);
        assert_eq!(moved_px(&plan(vec![coarser, flat])), 0.75);
    }

    /// The first technique's cases of a view, matrix included.
    fn group(scene: &str, view: &str, size: u32) -> ViewGroup {
        let request = Request {
            techniques: vec!["vertex".to_owned()],
            samples: Some(1),
            size: [size, size],
            settings: BTreeMap::from([("matrix".to_owned(), vec![scene.to_owned()])]),
            ..Request::default()
        };
        let wishes = Wishes::new(&request, [TECHNIQUES, &[]], &[&EllipsoidKind]).expect("wishes");
        let scene = Arc::new(Scene::shipped(scene, None).expect("it ships"));
        let meshes = build_meshes(&scene, &scene.mesh).expect("it meshes");
        let view = scene.views.iter().find(|known| known.name == view);
        view_group(&scene, view.expect("a view"), false, &meshes, &wishes)
    }

    /// Calls `check` with a session of the group; skipped, said aloud, where there is no device.
    fn with_session(group: &ViewGroup, check: impl FnOnce(&mut ViewSession<'_>)) {
        if terrafill_gpu::open_for_test(&Default::default()).is_none() {
            return;
        }
        let place = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(place.path().join("images")).expect("a folder");
        let devices = Rc::new(Devices::default());
        let context = Context {
            devices: &devices,
            folder: place.path(),
        };
        check(&mut ViewSession::new(group, context).expect("a session"));
    }

    fn figure(verdict: &Verdict, metric: &str) -> Option<f64> {
        let mut figures = verdict.figures.iter();
        figures
            .find(|(name, _)| *name == metric)
            .map(|(_, value)| *value)
    }

    #[test]
    fn coordinates_that_are_shifted_make_the_row_wrong() {
        let mut group = group("california", "top-down", 96);
        // In full depth, or in the view that quick runs show textured.
        let plain = TECHNIQUES[0].main(group.scene.overlap);
        let (textured, shown) =
            crate::textured::textured_variants(&plain, true, &group.scene, &group.view, true)
                .remove(0);
        group.cases[0].subject = Subject::Fill(TECHNIQUES[0], textured);
        group.cases[0].shown = shown;
        group.cases[0].purposes = vec![Purpose::Texture];
        let case = &group.cases[0];
        assert!(shows_chosen(case), "{}", case.variant_name());
        with_session(&group, |session| {
            let mut compared = |shift_texels: f64| {
                let drawn = session.draw(case, rounding_px).expect("goes on");
                let Ok(mut drawn) = drawn else {
                    panic!("{}: not drawn", case.variant_name());
                };
                let texture = drawn.frame.texture.as_mut().expect("textured");
                let columns = f64::from(texture.texels[0]);
                for pixel in texture.pixels.iter_mut().flatten() {
                    pixel.uv[0] += shift_texels / columns;
                }
                session.compare(case, &mut drawn).expect("compared")
            };
            let right = compared(0.0);
            assert_eq!((right.status, right.reason.as_str()), (Status::Ok, ""));
            let wrong = compared(1.0);
            assert_eq!(wrong.status, Status::Wrong);
            assert!(
                wrong.reason.contains("texels, allowed 0.25"),
                "{}",
                wrong.reason
            );
            let rms = figure(&wrong, "texel_rms").expect("compared");
            assert!((rms - 1.0).abs() < 0.1, "{rms}");
        });
    }

    #[test]
    fn what_rounds_too_much_to_be_right_is_left_out_of_the_matrix_by_its_bound_alone() {
        let group = group("square-200km", "edge-1m5", 512);
        let cell = |name: &str| {
            let mut cases = group.cases.iter();
            let place = cases.position(|case| case.variant_name() == name);
            place.expect("a cell of the matrix")
        };
        with_session(&group, |session| {
            let naive = &group.cases[cell("doubled,positions=ecef-f32")];
            let found = session.draw(naive, rounding_px).expect("goes on");
            let skipped = found.err().expect("not drawn");
            assert_eq!(skipped.status, Status::Skipped);
            assert!(
                skipped.reason.starts_with("ecef-f32 rounds by up to ")
                    && skipped.reason.ends_with(" px here, allowed 0.25"),
                "{}",
                skipped.reason
            );
            assert!(skipped.figures.is_empty());
            // Twin: were its bound nothing, it would be drawn, and wrong.
            let unbounded = session.draw(naive, |_, _| 0.0).expect("goes on");
            let Ok(mut drawn) = unbounded else {
                panic!("not drawn");
            };
            let found = session.compare(naive, &mut drawn).expect("compared");
            assert_eq!(found.status, Status::Wrong, "{}", found.reason);
            assert!(figure(&found, "mismatched_px") > Some(100.0));
            // What is right by its bound is drawn, and so is everything that is not about positions.
            for name in [
                "doubled,positions=two-float",
                "doubled",
                "doubled,walls=list",
            ] {
                let found = session.verify(cell(name)).expect("verified");
                assert_eq!(found.status, Status::Ok, "{name}: {}", found.reason);
            }
        });
    }
}
