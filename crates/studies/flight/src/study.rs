// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: techniques × ways of making the pieces.

use crate::STUDY;
use crate::chapter::CHAPTER;
use crate::metrics::*;
use crate::pace::{Making, Pace};
use crate::path::path;
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_conformance::{
    BAND_RADIUS_PX, BORDER_ROUNDING, ErrorFigures, Tally, compare_closely,
};
use terrafill_contract::{
    CpuStopwatch, FillBackend, FillInput, Frame, Picture, PreparedScene, Role, Targets, Technique,
};
use terrafill_core::RegionMesh;
use terrafill_plan::PlanOptions;
use terrafill_reference::{CloseLook, ReferenceBackend, ReferenceScene};
use terrafill_results::{Skipped, Status, Verdict, median};
use terrafill_scene::{ImageSize, Scene, View};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Planned, Request, Session, Study, StudyError,
    file_stem, files_read, judged, planned_case, write_rgb,
};
use terrafill_surface::{
    AsItIs, InBackground, PieceMemory, Refinement, Surface, SurfaceKind, open_surface,
};
use terrafill_variant::Variant;

/// The scene that is flown over where none is named: terrain grown from a seed, in tiles.
const HOME: &str = "hills";
const HOME_SURFACE: &str = "tiles";

/// Frames of a flight, and how many of them the eye rests at its end.
const FRAMES: u32 = 60;
const REST: u32 = 12;
/// Of these one is compared.
const COMPARED_OF: u32 = 6;
/// The same of further processes and of quick runs.
const COMPARED_OF_QUICK: u32 = 20;

/// Flights of each case in a process, unless the request says otherwise.
const SAMPLES: u32 = 2;
const QUICK_SAMPLES: u32 = 1;

/// What a flight costs and shows while terrain is being made.
#[derive(Debug, Clone, Copy)]
pub struct FlightStudy {
    /// Techniques that fill.
    pub techniques: &'static [&'static dyn Technique],
    /// Surfaces that scenes may lie on.
    pub surfaces: &'static [&'static dyn SurfaceKind],
}

impl Study for FlightStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let bad = |error: &dyn ToString| StudyError::BadInput(error.to_string());
        let scenes: Result<Vec<Scene>, _> = if request.scenes.is_empty() {
            home().map(|home| vec![home])
        } else {
            let names = request.scenes.iter();
            let opened = names.map(|name| Scene::open(name, request.data_dir.as_deref()));
            opened.collect()
        };
        let scenes = scenes.map_err(|error| bad(&error))?;
        let mut planned = Planned {
            inputs: scenes.iter().flat_map(files_read).collect(),
            ..Planned::default()
        };
        for scene in scenes {
            let surface = open_surface(self.surfaces, &scene).map_err(|error| bad(&error))?;
            if surface.refining().is_none() {
                planned.skipped.push(Skipped {
                    what: format!("{STUDY}/{}", scene.name),
                    reason: format!("its surface, {}, is made in one piece", surface.kind()),
                });
                continue;
            }
            let flights = flights(self, request, scene, surface);
            planned.groups.push(Box::new(flights));
        }
        Ok(planned)
    }
}

/// The terrain of [`HOME`] in tiles.
fn home() -> Result<Scene, terrafill_scene::SceneError> {
    let mut scene = Scene::shipped(HOME, None)?;
    scene.surface.kind = HOME_SURFACE.to_owned();
    let parameters = &mut scene.surface.parameters;
    parameters.remove("rows");
    parameters.insert("base".to_owned(), "relief".into());
    Ok(scene)
}

#[derive(Debug, Clone)]
struct FlightCase {
    technique: &'static dyn Technique,
    variant: Variant,
    pace: Pace,
}

/// What sessions need of all cases over one scene.
struct Flights {
    scene: Scene,
    /// Has all that a view asks for.
    settled: Arc<dyn Surface>,
    surfaces: &'static [&'static dyn SurfaceKind],
    size: ImageSize,
    compared_of: u32,
    cases: Vec<FlightCase>,
}

fn flights(
    study: &FlightStudy,
    request: &Request,
    scene: Scene,
    settled: Arc<dyn Surface>,
) -> CaseGroup<Flights> {
    let is_quick = request.depth == Depth::Quick;
    let [width, height] = request.size;
    let mut cases: Vec<FlightCase> = Vec::new();
    let techniques = study.techniques.iter();
    for &technique in techniques.filter(|technique| request.wants(technique.name())) {
        let mut variants = technique.variants(&scene, Role::Quick).into_iter();
        let Some(variant) = variants.find(|variant| !technique.is_approximate(variant)) else {
            continue;
        };
        // The ways of making pieces do not depend on who fills: one technique shows them all.
        let paces = if cases.is_empty() {
            &Pace::ALL[..]
        } else if is_quick {
            &[]
        } else {
            &Pace::ALL[2..3]
        };
        cases.extend(paces.iter().map(|&pace| FlightCase {
            technique,
            variant: variant.clone(),
            pace,
        }));
    }
    let (samples, compared_of) = if is_quick {
        (QUICK_SAMPLES, COMPARED_OF_QUICK)
    } else {
        (SAMPLES, COMPARED_OF)
    };
    let samples = request.samples.unwrap_or(samples);
    let planned = cases.iter().map(|case| {
        let conditions = [
            (SCENE, scene.name.clone()),
            (TECHNIQUE, case.technique.name().to_owned()),
            (VARIANT, case.variant.name()),
            (PIECES, case.pace.name()),
        ];
        planned_case(STUDY, samples, conditions, None)
    });
    CaseGroup {
        name: format!("{STUDY}/{}", scene.name),
        cases: planned.collect(),
        // The flight that is compared warms it.
        warm_up: Some(0),
        open: |group, context| Ok(Box::new(FlightsSession::new(group, context)?)),
        work: Flights {
            cases,
            scene,
            settled,
            surfaces: study.surfaces,
            size: ImageSize { width, height },
            compared_of,
        },
    }
}

fn memory(surface: &dyn Surface) -> PieceMemory {
    let memory = surface.refining().map(|refining| refining.memory());
    memory.unwrap_or_default()
}

/// What one frame took and showed.
struct Flown {
    cpu_ms: f64,
    wall_ms: f64,
    refinement: Refinement,
    bytes: u64,
}

/// What the frames of a flight showed.
#[derive(Debug, Default)]
struct Compared {
    tally: Tally,
    /// Pixels that the terrain's missing pieces changed: most of all frames, and of the last.
    changed_px: u64,
    last_changed_px: u64,
    /// The last frame, which is compared, in the regions' colours.
    picture: Option<Picture>,
}

impl Compared {
    fn add(&mut self, frame: u32, compared: Result<(ErrorFigures, u64), String>) {
        if let Ok((_, changed_px)) = compared {
            self.changed_px = self.changed_px.max(changed_px);
            self.last_changed_px = changed_px;
        }
        let figures = compared.as_ref().map(|(figures, _)| figures);
        self.tally.add(frame, figures.map_err(Clone::clone));
    }

    fn verdict(&self) -> Verdict {
        let figures = vec![
            (COMPARED.name, f64::from(self.tally.frames)),
            (WRONG.name, self.tally.wrong.len() as f64),
            (OUTSIDE.name, self.tally.outside_px as f64),
            (ERROR.name, self.changed_px as f64),
            (LAST_ERROR.name, self.last_changed_px as f64),
        ];
        judged(self.tally.reason(), figures, Vec::new())
    }
}

/// The reference's pictures of what it was asked, by camera and triangles: most flights meet the same triangles in
/// most frames, and rays take seconds.
#[derive(Debug, Default)]
struct References(RefCell<BTreeMap<u64, Rc<Frame>>>);

impl References {
    fn frame(&self, input: &FillInput) -> Result<Rc<Frame>, String> {
        let key = Self::key(input);
        if let Some(known) = self.0.borrow().get(&key) {
            return Ok(Rc::clone(known));
        }
        let judged = ReferenceBackend::new().judge(input);
        let frame = Rc::new(judged.map_err(|error| error.to_string())?.frame);
        self.0.borrow_mut().insert(key, Rc::clone(&frame));
        Ok(frame)
    }

    /// Of all that differs between the frames of a scene's flights.
    fn key(input: &FillInput) -> u64 {
        let mut hasher = DefaultHasher::new();
        format!("{:?}", input.camera).hash(&mut hasher);
        for vertex in input.surface.vertices_rte.iter() {
            vertex.map(f32::to_bits).hash(&mut hasher);
        }
        input.surface.triangles.hash(&mut hasher);
        hasher.finish()
    }
}

/// How a picture differs from the reference over the triangles of that very frame, and in how many pixels
/// that reference differs from one over all that the view asks for.
fn figures(
    references: &References,
    input: &FillInput,
    asked_for: &FillInput,
    drawn: &Frame,
) -> Result<(ErrorFigures, u64), String> {
    let judge = ReferenceBackend::new();
    let (reference, settled) = (references.frame(input)?, references.frame(asked_for)?);
    let ids = reference.ids.iter().zip(&settled.ids);
    let changed_px = ids.filter(|(now, then)| now != then).count();
    // Hardly any frame is asked about closely, and to get ready for it takes longer than to draw.
    let scene: OnceCell<Option<ReferenceScene>> = OnceCell::new();
    let closely = || {
        let scene = scene.get_or_init(|| judge.scene(input).ok());
        Some(CloseLook::new(input, scene.as_ref()?))
    };
    let by_rounding = |pixel: usize, id: u32| {
        closely().is_some_and(|look| look.ids_by_rounding(pixel, BORDER_ROUNDING).contains(&id))
    };
    let shows = |pixel: usize, id: u32| {
        closely().is_some_and(|look| look.ids_within(pixel, BAND_RADIUS_PX).contains(&id))
    };
    let figures = compare_closely(&reference, drawn, by_rounding, shows);
    let figures = figures.map_err(|error| error.to_string())?;
    Ok((figures, changed_px as u64))
}

struct FlightsSession<'a> {
    group: &'a CaseGroup<Flights>,
    context: Context<'a>,
    views: Vec<View>,
    references: References,
    targets: Targets,
    /// By case, from its first flight on.
    backends: BTreeMap<usize, Box<dyn FillBackend>>,
    /// One for all cases: a flight begins with nothing made.
    surface: Arc<dyn Surface>,
    as_it_is: Arc<AsItIs>,
    /// With frames that wait, and with frames of what is there.
    whole: PreparedScene,
    now: PreparedScene,
    /// Of the scene.
    budget_bytes: u64,
}

impl<'a> FlightsSession<'a> {
    fn new(group: &'a CaseGroup<Flights>, context: Context<'a>) -> Result<Self, StudyError> {
        let flights = &group.work;
        let scene = &flights.scene;
        let bad = |error: &dyn std::error::Error| {
            StudyError::BadInput(format!("{}: {error}", group.name))
        };
        let meshes =
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh);
        let meshes = meshes.map_err(|errors| bad(&errors[0]))?;
        // Another one than the settled: a flight begins with nothing made.
        let surface = open_surface(flights.surfaces, scene);
        let surface = surface.map_err(|error| bad(&error))?;
        let broken = || StudyError::Broken {
            place: group.name.clone(),
            message: "its surface has no pieces any more".to_owned(),
        };
        let as_it_is = AsItIs::new(Arc::clone(&surface)).map(Arc::new);
        let as_it_is = as_it_is.ok_or_else(broken)?;
        let whole = PreparedScene::new(scene, meshes.into(), Arc::clone(&surface));
        let now = PreparedScene {
            surface: Arc::<AsItIs>::clone(&as_it_is),
            ..whole.clone()
        };
        let budget_bytes = memory(&*surface).budget_bytes;
        Ok(Self {
            group,
            context,
            views: path(&scene.views, FRAMES, REST),
            references: References::default(),
            targets: Targets::new(context.devices, flights.size),
            backends: BTreeMap::new(),
            surface,
            as_it_is,
            whole,
            now,
            budget_bytes,
        })
    }

    /// Flies a case from the first frame on, with nothing made yet.
    ///
    /// - `compared_of`: of so many frames one is compared; `None`: nothing is, and each frame is timed
    fn fly(
        &mut self,
        index: usize,
        compared_of: Option<u32>,
    ) -> Result<(Vec<Flown>, Compared), Failure> {
        let flights = &self.group.work;
        let (case, size) = (&flights.cases[index], flights.size);
        let mut backend = match self.backends.remove(&index) {
            Some(backend) => backend,
            None => case.technique.open(&self.targets, &case.variant)?,
        };
        let Some(refining) = self.surface.refining() else {
            return Ok((Vec::new(), Compared::default()));
        };
        refining.set_budget(case.pace.budget_bytes.unwrap_or(self.budget_bytes));
        let waits = matches!(case.pace.making, Making::Anew | Making::Wait);
        let scene = if waits { &self.whole } else { &self.now };
        let background = (case.pace.making == Making::Background)
            .then(|| InBackground::start(Arc::clone(&self.surface)));
        let mut flown = Vec::new();
        let mut compared = Compared::default();
        for (at, view) in (0_u32..).zip(&self.views) {
            let is_last = at as usize + 1 == self.views.len();
            let is_compared = compared_of.is_some_and(|of| at % of == of - 1 || at == 0 || is_last);
            // It keeps nothing for the next frame, so none is flown between those compared: a frame makes
            // hundreds of pieces, which takes longer than all else.
            if case.pace.making == Making::Anew && compared_of.is_some() && !is_compared {
                continue;
            }
            let watch = CpuStopwatch::start();
            if case.pace.making == Making::Anew {
                refining.forget();
            }
            let options = PlanOptions::default();
            let input = FillInput::new(scene, view, size, options)?;
            backend.prepare(&input)?;
            if compared_of.is_none() {
                backend.draw_surface(&input)?;
                backend.time_frame(&input)?;
            }
            if let Making::AFrame(pieces) = case.pace.making {
                refining.refine(pieces);
            }
            let (cpu_ms, wall_ms) = (watch.cpu_ms(), watch.wall_ms());
            let refinement = if waits {
                Refinement::default()
            } else {
                self.as_it_is.last()
            };
            if is_compared {
                let drawn = backend.render(&input)?;
                let asked_for = FillInput {
                    surface: flights.settled.frame(&input.camera, size)?,
                    ..input.clone()
                };
                let figures = figures(&self.references, &input, &asked_for, &drawn);
                compared.add(at, figures);
                if is_last {
                    compared.picture = Some(backend.picture(&input)?);
                }
            }
            flown.push(Flown {
                cpu_ms,
                wall_ms,
                refinement,
                bytes: refining.memory().bytes,
            });
        }
        drop(background);
        self.backends.insert(index, backend);
        Ok((flown, compared))
    }
}

impl Session for FlightsSession<'_> {
    /// A flight whose last frame is kept as a picture.
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let (_, compared) = self.fly(case, Some(self.group.work.compared_of))?;
        let mut verdict = compared.verdict();
        if let Some(picture) = compared.picture {
            let name = file_stem(&self.group.cases[case].id.key());
            let size = [picture.size.width, picture.size.height];
            let path = write_rgb(self.context.folder, &name, size, &picture.rgb())?;
            verdict.notes.push((IMAGE, path));
        }
        Ok(verdict)
    }

    fn recheck(
        &mut self,
        case: usize,
        _status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        Ok(self.fly(case, Some(COMPARED_OF_QUICK))?.1.verdict())
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let before = memory(&*self.surface);
        let (flown, _) = self.fly(case, None)?;
        let after = memory(&*self.surface);
        let first = flown.first().ok_or("it has no frames".to_owned())?;
        let of = |value: fn(&Flown) -> f64| -> Vec<f64> { flown[1..].iter().map(value).collect() };
        let largest = |value| of(value).into_iter().fold(0.0, f64::max);
        let middle = |value| median(&of(value)).ok_or("it has one frame".to_owned());
        let late = flown.iter().filter(|frame| frame.refinement.waiting > 0);
        let evicted = after.evicted - before.evicted;
        Ok(vec![
            (FRAME_CPU.name, middle(|frame| frame.cpu_ms)?),
            (WORST_CPU.name, largest(|frame| frame.cpu_ms)),
            (FRAME_WALL.name, middle(|frame| frame.wall_ms)?),
            (WORST_WALL.name, largest(|frame| frame.wall_ms)),
            (FIRST.name, first.wall_ms),
            (LATE.name, late.count() as f64),
            (MADE.name, (after.made - before.made) as f64),
            (EVICTED.name, evicted as f64),
            (BYTES.name, largest(|frame| frame.bytes as f64)),
            (BUDGET.name, after.budget_bytes as f64),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_contract::{Devices, device_for_test};
    use terrafill_native::NativeTechnique;
    use terrafill_surface::EllipsoidKind;
    use terrafill_tiles::TilesKind;
    use terrafill_vertex::VertexTechnique;

    const MAX_TRIANGLES: i64 = 60_000;

    static STUDY_OF_TWO: FlightStudy = FlightStudy {
        techniques: &[&VertexTechnique, &NativeTechnique],
        surfaces: &[&EllipsoidKind, &TilesKind],
    };

    fn hills(depth: Depth) -> CaseGroup<Flights> {
        let request = Request {
            depth,
            size: [120, 90],
            ..Request::default()
        };
        let mut scene = home().expect("hills ship");
        // As many tiles as leave a test its time.
        let parameters = &mut scene.surface.parameters;
        parameters.insert("max_triangles".to_owned(), MAX_TRIANGLES.into());
        let surface = open_surface(STUDY_OF_TWO.surfaces, &scene).expect("opens");
        flights(&STUDY_OF_TWO, &request, scene, surface)
    }

    fn with_session(group: &CaseGroup<Flights>, check: impl FnOnce(&mut FlightsSession<'_>)) {
        let flights = &group.work;
        let devices = Rc::new(Devices::default());
        let targets = Targets::new(&devices, flights.size);
        for case in &flights.cases {
            let opened = case.technique.open(&targets, &case.variant);
            if device_for_test(opened).is_none() {
                return;
            }
        }
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("images")).expect("writable");
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        check(&mut FlightsSession::new(group, context).expect("opens"));
    }

    #[test]
    fn one_technique_shows_every_way_and_surfaces_of_one_piece_are_left_out() {
        let ways = |depth, technique: &str| {
            let group = hills(depth);
            let cases = group.work.cases.iter();
            cases
                .filter(|case| case.technique.name() == technique)
                .count()
        };
        assert_eq!(ways(Depth::Quick, "vertex"), Pace::ALL.len());
        assert_eq!(ways(Depth::Quick, "native"), 0);
        assert_eq!(ways(Depth::Main, "native"), 1);
        let request = Request {
            scenes: vec!["california".to_owned()],
            ..Request::default()
        };
        let planned = STUDY_OF_TWO.plan(&request).expect("planned");
        assert!(planned.groups.is_empty());
        assert_eq!(planned.skipped[0].what, "flight/california");
        let home = STUDY_OF_TWO.plan(&Request::default()).expect("planned");
        assert!(home.skipped.is_empty() && home.groups.len() == 1);
    }

    #[test]
    fn fills_are_right_in_every_frame_whatever_tiles_are_there() {
        let mut group = hills(Depth::Main);
        for case in &mut group.work.cases {
            // Fewer tiles need less memory.
            case.pace.budget_bytes = case.pace.budget_bytes.and(Some(400_000));
        }
        let flights = &group.work;
        with_session(&group, |session| {
            // So many frames as leave a test its time.
            session.views = path(&flights.scene.views, 12, 3);
            let mut made_anew = 0.0;
            for index in 0..flights.cases.len() {
                let name = &group.cases[index].id.name;
                let verdict = session.verify(index).expect("goes on");
                assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
                let [(note, path)] = &verdict.notes[..] else {
                    panic!("{name}: a picture: {:?}", verdict.notes);
                };
                let picture = session.context.folder.join(path);
                assert!(*note == IMAGE && picture.is_file(), "{name}: {path}");
                let mut figures = verdict.figures.iter();
                let changed = figures.find(|(known, _)| *known == "flight_changed_px");
                let changed_px = changed.expect("counted").1;
                let pace = flights.cases[index].pace;
                let measured = session.time(index).expect("measured");
                let value = |wanted: &str| {
                    let found = measured.iter().find(|(known, _)| *known == wanted);
                    found.unwrap_or_else(|| panic!("{name}: {wanted}")).1
                };
                let [bytes, budget] = ["flight_piece_bytes", "flight_budget_bytes"].map(value);
                assert!(0.0 < bytes && bytes <= budget, "{name}: {bytes} {budget}");
                let late = value("flight_late_frames");
                match pace.making {
                    Making::Anew | Making::Wait => {
                        assert_eq!(late, 0.0, "{name}");
                        assert_eq!(changed_px, 0.0, "{name}");
                    }
                    // Negative control: what does not wait is late, and shows it.
                    Making::AFrame(_) => {
                        let shows_it = late > 3.0 && changed_px > 0.0;
                        assert!(shows_it, "{name}: {late} {changed_px}");
                    }
                    Making::Background => assert!(late > 0.0, "{name}"),
                }
                let evicted = value("flight_pieces_evicted");
                let is_tight = pace.budget_bytes.is_some();
                assert_eq!(evicted > 0.0, is_tight, "{name}: {evicted}");
                let made = value("flight_pieces_made");
                match pace.making {
                    Making::Anew => made_anew = made,
                    Making::Wait => assert!(made < 0.7 * made_anew, "{made} {made_anew}"),
                    _ => {}
                }
            }
        });
    }

    #[test]
    fn a_picture_of_another_moment_is_wrong() {
        let group = hills(Depth::Quick);
        let flights = &group.work;
        with_session(&group, |session| {
            session.views = path(&flights.scene.views, 8, 2);
            session.fly(2, None).expect("flies");
            let options = PlanOptions::default();
            let input = |at: usize| {
                let view = &session.views[at];
                FillInput::new(&session.now, view, flights.size, options).expect("above")
            };
            let (now, before) = (input(7), input(2));
            let backend = session.backends.get_mut(&2).expect("opened");
            backend.prepare(&now).expect("fits");
            let drawn = backend.render(&now).expect("draws");
            let mut compared = Compared::default();
            let references = References::default();
            compared.add(7, figures(&references, &now, &now, &drawn));
            assert_eq!(compared.tally.wrong, []);
            assert_eq!(references.0.borrow().len(), 1, "drawn once");
            compared.add(7, figures(&references, &before, &now, &drawn));
            assert_eq!(references.0.borrow().len(), 2, "another moment");
            let verdict = compared.verdict();
            assert_eq!(verdict.status, Status::Wrong);
            let reason = verdict.reason;
            assert!(reason.starts_with("1 of 2 frames; frame 7: "), "{reason}");
        });
    }
}
