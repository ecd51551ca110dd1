// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: numbers of sensors × techniques × ways of keeping up to date.

use crate::STUDY;
use crate::chapter::CHAPTER;
use crate::metrics::*;
use crate::sensors::{FRAMES, Sensors};
use crate::stage::{Stage, StepCost, Upkeep};
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_conformance::{BAND_RADIUS_PX, ErrorFigures, Tally, compare_closely, filled_only};
use terrafill_contract::{CpuStopwatch, FillBackend, FillInput, Frame, Role, Targets, Technique};
use terrafill_reference::{CloseLook, ReferenceBackend, ReferenceScene};
use terrafill_results::{Skipped, Status, Verdict};
use terrafill_scene::{ImageSize, Overlap, Scene, SceneError};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, Planned, Request, Session, Study,
    StudyError, file_stem, files_read, judged, planned_case, verified, write_rgb,
};
use terrafill_surface::SurfaceKind;
use terrafill_variant::Variant;

/// Scenes to move over: the first whose data is there.
const BASES: [&str; 2] = ["countries-110m", "planet-134"];

/// Timed frames of each case in a process, unless the request says otherwise. Odd, so that the median
/// is one of them.
const SAMPLES: u32 = 13;

/// Frames that further processes compare, and a quick run's first one.
const FEW_FRAMES: u32 = 3;

/// What regions cost that change in every frame.
#[derive(Debug, Clone, Copy)]
pub struct MovingStudy {
    /// Techniques that it compares.
    pub techniques: &'static [&'static dyn Technique],
    /// Surfaces that scenes may lie on.
    pub surfaces: &'static [&'static dyn SurfaceKind],
}

impl Study for MovingStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let (scene, skipped) = base(request)?;
        let counts: &[usize] = match request.depth {
            Depth::Quick => &[10],
            Depth::Main => &[50],
            Depth::Full => &[1, 10, 50, 200],
        };
        let scene = Rc::new(scene);
        let groups = counts
            .iter()
            .map(|&count| -> Box<dyn Group> { Box::new(sweep(self, request, &scene, count)) });
        Ok(Planned {
            groups: groups.collect(),
            skipped,
            inputs: files_read(&scene),
        })
    }
}

/// The first of [`BASES`] whose data is there, as something that other regions may cover.
fn base(request: &Request) -> Result<(Scene, Vec<Skipped>), StudyError> {
    let mut skipped = Vec::new();
    for name in BASES {
        match Scene::shipped(name, request.data_dir.as_deref()) {
            Ok(scene) => {
                let overlap = Overlap::Ordered;
                return Ok((Scene { overlap, ..scene }, skipped));
            }
            Err(error @ SceneError::DataMissing { .. }) => skipped.push(Skipped {
                what: format!("{STUDY}/{name}"),
                reason: error.to_string(),
            }),
            Err(error) => return Err(StudyError::BadInput(error.to_string())),
        }
    }
    let message = format!("none of {} can be opened", BASES.join(", "));
    Err(StudyError::BadInput(message))
}

/// A technique that draws the sensors, and how they get to it.
#[derive(Debug, Clone)]
struct MovingCase {
    technique: &'static dyn Technique,
    variant: Variant,
    upkeep: Upkeep,
}

/// What sessions need of all cases of one number of sensors.
struct Sweep {
    scene: Rc<Scene>,
    surfaces: &'static [&'static dyn SurfaceKind],
    size: ImageSize,
    sensors: usize,
    /// Compared with the reference by the first process.
    frames: u32,
    cases: Vec<MovingCase>,
}

fn sweep(
    study: &MovingStudy,
    request: &Request,
    scene: &Rc<Scene>,
    sensors: usize,
) -> CaseGroup<Sweep> {
    let is_quick = request.depth == Depth::Quick;
    let [width, height] = request.size;
    let mut cases: Vec<MovingCase> = Vec::new();
    let techniques = study.techniques.iter();
    for &technique in techniques.filter(|technique| request.wants(technique.name())) {
        let variants = technique.variants(scene, Role::Quick).into_iter();
        // Every frame has to be right here.
        for variant in variants.filter(|variant| !technique.is_approximate(variant)) {
            let mut known = cases.iter();
            let is_first = known.all(|case| case.technique.name() != technique.name());
            // The last two ways are the same for all layouts: one of each technique shows them.
            let ways = if is_first && !is_quick { 4 } else { 2 };
            cases.extend(Upkeep::ALL[..ways].iter().map(|&upkeep| {
                MovingCase {
                    technique,
                    variant: variant
                        .clone()
                        .with_switches(|s| s.bends_footprints = upkeep == Upkeep::Bend),
                    upkeep,
                }
            }));
        }
    }
    let samples = request.samples.unwrap_or(SAMPLES);
    let planned = cases.iter().map(|case| {
        let conditions = [
            (SCENE, scene.name.clone()),
            (SENSORS, sensors.to_string()),
            (TECHNIQUE, case.technique.name().to_owned()),
            (VARIANT, case.variant.name()),
            (UPKEEP, case.upkeep.name().to_owned()),
        ];
        planned_case(STUDY, samples, conditions, None)
    });
    CaseGroup {
        name: format!("{STUDY}/{}/{sensors}", scene.name),
        cases: planned.collect(),
        warm_up: None,
        open: |group, context| Ok(Box::new(SweepSession::new(group, context)?)),
        work: Sweep {
            cases,
            scene: Rc::clone(scene),
            surfaces: study.surfaces,
            size: ImageSize { width, height },
            sensors,
            frames: if is_quick { FEW_FRAMES } else { FRAMES },
        },
    }
}

/// A technique that holds a frame.
struct Flight {
    backend: Box<dyn FillBackend>,
    input: FillInput,
    frame: u32,
}

struct SweepSession<'a> {
    group: &'a CaseGroup<Sweep>,
    context: Context<'a>,
    stage: Stage,
    targets: Targets,
    /// By frame; drawn when it is first compared.
    references: RefCell<BTreeMap<u32, Rc<Frame>>>,
    /// By case.
    flights: BTreeMap<usize, Flight>,
}

/// What the frames of a case showed.
#[derive(Debug, Default)]
struct Compared {
    tally: Tally,
    upload_bytes: u64,
    regions: usize,
    /// Of vertices that the device computes, metres and pixels.
    bound: Option<[f64; 2]>,
}

impl Compared {
    fn add(&mut self, frame: u32, figures: Result<ErrorFigures, String>, cost: StepCost) {
        self.upload_bytes = self.upload_bytes.max(cost.upload_bytes);
        self.regions = self.regions.max(cost.regions);
        self.tally
            .add(frame, figures.as_ref().map_err(Clone::clone));
    }

    fn verdict(&self, image: String) -> Verdict {
        let mut figures = vec![
            (BYTES.name, self.upload_bytes as f64),
            (REGIONS.name, self.regions as f64),
            (COMPARED.name, f64::from(self.tally.frames)),
            (WRONG.name, self.tally.wrong.len() as f64),
            (OUTSIDE.name, self.tally.outside_px as f64),
        ];
        if let Some([metres, pixels]) = self.bound {
            figures.extend([(BOUND_M.name, metres), (BOUND_PX.name, pixels)]);
        }
        judged(self.tally.reason(), figures, vec![("image", image)])
    }
}

impl<'a> SweepSession<'a> {
    fn new(group: &'a CaseGroup<Sweep>, context: Context<'a>) -> Result<Self, StudyError> {
        let sweep = &group.work;
        let scene = &sweep.scene;
        let bad = |failure: Failure| StudyError::BadInput(failure.reason());
        let view = scene.views.iter().find(|view| view.name == "globe");
        let view = view.ok_or_else(|| StudyError::Broken {
            place: group.name.clone(),
            message: "its scene has no view named globe".to_owned(),
        })?;
        let sensors = Sensors::new(scene.body, sweep.sensors).map_err(bad)?;
        let stage = Stage::new(scene, sweep.surfaces, view, sweep.size, sensors);
        Ok(Self {
            group,
            context,
            stage: stage.map_err(bad)?,
            targets: Targets::new(context.devices, sweep.size),
            references: RefCell::default(),
            flights: BTreeMap::new(),
        })
    }

    fn reference(&self, frame: u32) -> Result<Rc<Frame>, Failure> {
        if let Some(known) = self.references.borrow().get(&frame) {
            return Ok(Rc::clone(known));
        }
        let drawn = ReferenceBackend::new().judge(&self.stage.as_rings(frame)?)?;
        let drawn = Rc::new(drawn.frame);
        let mut references = self.references.borrow_mut();
        references.insert(frame, Rc::clone(&drawn));
        Ok(drawn)
    }

    /// How a picture of `frame` differs from the reference of it.
    fn figures(
        &self,
        backend: &dyn FillBackend,
        drawn: &Frame,
        frame: u32,
    ) -> Result<ErrorFigures, String> {
        let as_mask = !backend.tells_regions_apart();
        let reference = self.reference(frame).map_err(Failure::reason)?;
        // Hardly any frame is asked about closely, and to get ready for it takes longer than to draw.
        let ready: OnceCell<Option<(FillInput, ReferenceScene)>> = OnceCell::new();
        let make = || {
            let rings = self.stage.as_rings(frame).ok()?;
            let scene = ReferenceBackend::new().scene(&rings).ok()?;
            Some((rings, scene))
        };
        let closely = || {
            let (rings, scene) = ready.get_or_init(make).as_ref()?;
            Some(CloseLook::new(rings, scene))
        };
        let as_compared = |id: u32| if as_mask { id.min(1) } else { id };
        let shows = |pixel: usize, id: u32| {
            closely().is_some_and(|look| {
                let mut ids = look.ids_within(pixel, BAND_RADIUS_PX).into_iter();
                ids.any(|shown| as_compared(shown) == id)
            })
        };
        // The bare ellipsoid has no facet in the plane of a wall.
        let by_rounding = |_, _| false;
        let compared = if as_mask {
            let (reference, drawn) = (filled_only(&reference), filled_only(drawn));
            compare_closely(&reference, &drawn, by_rounding, shows)
        } else {
            compare_closely(&reference, drawn, by_rounding, shows)
        };
        compared.map_err(|error| error.to_string())
    }

    /// Opens the case at frame 0 and compares its first `frames` frames.
    fn fly(&self, case: &MovingCase, frames: u32) -> Result<(Flight, Compared), Failure> {
        let mut backend = case.technique.open(&self.targets, &case.variant)?;
        let mut input = self.stage.start(case.upkeep)?;
        backend.prepare(&input)?;
        let mut compared = Compared::default();
        for frame in 0..frames {
            let mut cost = StepCost::default();
            if frame > 0 {
                (input, cost) = self.stage.step(&mut *backend, &input, frame, case.upkeep)?;
            }
            if case.upkeep == Upkeep::Bend {
                let [metres, pixels] = self.stage.bound(frame)?;
                let [most_m, most_px] = compared.bound.unwrap_or_default();
                compared.bound = Some([most_m.max(metres), most_px.max(pixels)]);
            }
            let drawn = backend.render(&input)?;
            compared.add(frame, self.figures(&*backend, &drawn, frame), cost);
        }
        let flight = Flight {
            backend,
            input,
            frame: frames.saturating_sub(1),
        };
        Ok((flight, compared))
    }

    fn verify_frames(&mut self, index: usize, frames: u32) -> Result<Verdict, Failure> {
        let case = &self.group.work.cases[index];
        let (mut flight, compared) = self.fly(case, frames)?;
        let image = match case.upkeep {
            Upkeep::Rewrite | Upkeep::Bend => self.write_picture(index, &mut flight)?,
            Upkeep::Reload | Upkeep::Remesh => String::new(),
        };
        self.flights.insert(index, flight);
        Ok(compared.verdict(image))
    }

    /// The last frame that was compared, in the regions' colours.
    fn write_picture(&self, index: usize, flight: &mut Flight) -> Result<String, Failure> {
        let picture = flight.backend.picture(&flight.input)?;
        let name = file_stem(&self.group.cases[index].id.name);
        let size = [picture.size.width, picture.size.height];
        let name = format!("{STUDY}-{name}");
        Ok(write_rgb(self.context.folder, &name, size, &picture.rgb())?)
    }
}

impl Session for SweepSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        self.verify_frames(case, self.group.work.frames)
    }

    fn recheck(
        &mut self,
        case: usize,
        _status: Status,
        _notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        self.verify_frames(case, FEW_FRAMES)
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let upkeep = self.group.work.cases[case].upkeep;
        let flight = verified(&mut self.flights, case)?;
        let (backend, input) = (&mut *flight.backend, &mut flight.input);
        // Another case may have drawn over it.
        backend.draw_surface(input)?;
        let next = (flight.frame + 1) % FRAMES;
        let watch = CpuStopwatch::start();
        let (moved, cost) = self.stage.step(backend, input, next, upkeep)?;
        let times = backend.time_frame(&moved);
        let (frame_cpu_ms, frame_wall_ms) = (watch.cpu_ms(), watch.wall_ms());
        let times = times?;
        (*input, flight.frame) = (moved, next);
        let mut values = vec![
            (MESH.name, cost.mesh_cpu_ms),
            (PLAN.name, cost.plan_cpu_ms),
            (UPDATE.name, cost.update_cpu_ms),
            (MESH_AND_UPDATE.name, cost.mesh_cpu_ms + cost.update_cpu_ms),
            (FILL_CPU.name, times.fill_cpu_ms),
            (FRAME_CPU.name, frame_cpu_ms),
            (FRAME_WALL.name, frame_wall_ms),
        ];
        values.extend(times.fill_gpu_ms.map(|ms| (FILL_GPU.name, ms)));
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_contract::{Devices, device_for_test};
    use terrafill_native::NativeTechnique;
    use terrafill_surface::EllipsoidKind;
    use terrafill_vertex::VertexTechnique;

    static STUDY_OF_TWO: MovingStudy = MovingStudy {
        techniques: &[&VertexTechnique, &NativeTechnique],
        surfaces: &[&EllipsoidKind],
    };

    fn request(depth: Depth) -> Request {
        Request {
            depth,
            size: [160, 120],
            ..Request::default()
        }
    }

    fn sweep_of(depth: Depth, sensors: usize) -> CaseGroup<Sweep> {
        let request = request(depth);
        let (scene, skipped) = base(&request).expect("planet-134 ships");
        assert_eq!(skipped.len(), 1, "countries need data");
        sweep(&STUDY_OF_TWO, &request, &Rc::new(scene), sensors)
    }

    fn with_session(group: &CaseGroup<Sweep>, check: impl FnOnce(&mut SweepSession<'_>)) {
        let sweep = &group.work;
        let devices = Rc::new(Devices::default());
        let targets = Targets::new(&devices, sweep.size);
        for case in &sweep.cases {
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
        check(&mut SweepSession::new(group, context).expect("opens"));
    }

    #[test]
    fn depths_have_their_numbers_of_sensors_and_one_layout_shows_every_way() {
        let sensors = |depth| -> Vec<String> {
            let planned = STUDY_OF_TWO.plan(&request(depth)).expect("planned");
            let groups = planned.groups.iter();
            groups
                .map(|group| group.cases()[0].id.condition(SENSORS).to_owned())
                .collect()
        };
        assert_eq!(sensors(Depth::Quick), ["10"]);
        assert_eq!(sensors(Depth::Main), ["50"]);
        assert_eq!(sensors(Depth::Full), ["1", "10", "50", "200"]);
        let ways = |depth, upkeep| {
            let group = sweep_of(depth, 1);
            let cases = group.work.cases.iter();
            cases.filter(|case| case.upkeep == upkeep).count()
        };
        assert_eq!(ways(Depth::Main, Upkeep::Remesh), 2);
        assert_eq!(ways(Depth::Quick, Upkeep::Remesh), 0);
        for of_every_layout in [Upkeep::Rewrite, Upkeep::Bend] {
            let expected = ways(Depth::Quick, Upkeep::Rewrite);
            assert_eq!(ways(Depth::Main, of_every_layout), expected);
            assert_eq!(ways(Depth::Quick, of_every_layout), expected);
        }
    }

    #[test]
    fn frames_are_right_by_every_way_and_only_rewriting_uploads_the_moved_alone() {
        let mut group = sweep_of(Depth::Main, 4);
        group.work.frames = 3;
        let sweep = &group.work;
        with_session(&group, |session| {
            let mut bytes = BTreeMap::new();
            for index in 0..sweep.cases.len() {
                let name = &group.cases[index].id.name;
                let verdict = session.verify(index).expect("goes on");
                assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
                let figure = |name| {
                    let found = verdict.figures.iter().find(|(known, _)| *known == name);
                    found.map(|(_, value)| *value)
                };
                assert_eq!(figure("moving_frames_compared"), Some(3.0));
                let case = &sweep.cases[index];
                let regions = figure("moving_uploaded_regions");
                match case.upkeep {
                    Upkeep::Rewrite => assert_eq!(regions, Some(4.0), "{name}"),
                    Upkeep::Reload => assert!(regions > Some(100.0), "{name}"),
                    Upkeep::Bend => {
                        assert_eq!(regions, Some(0.0), "{name}");
                        // Constants of volumes and footprints of the four, and of nothing else.
                        let bytes = figure("moving_upload_bytes").expect("counted");
                        assert!((600.0..=4.0 * 160.0).contains(&bytes), "{name}: {bytes}");
                        let [metres, pixels] = ["moving_bound_m", "moving_bound_px"].map(figure);
                        assert!(metres.is_some_and(|metres| 0.1 < metres && metres < 10.0));
                        assert!(pixels.is_some_and(|pixels| pixels < 0.01), "{pixels:?}");
                    }
                    Upkeep::Remesh => {}
                }
                let key = (case.technique.name(), case.upkeep.name());
                bytes.entry(key).or_insert(figure("moving_upload_bytes"));
                let measured = session.time(index).expect("measured");
                let [mesh, frame] = ["moving_mesh_cpu_ms", "moving_frame_cpu_ms"].map(|name| {
                    let found = measured.iter().find(|(known, _)| *known == name);
                    found.expect("measured").1
                });
                assert!(0.0 < mesh && mesh <= frame, "{name}: {mesh} {frame}");
            }
            for technique in ["vertex", "native"] {
                let [rewrite, reload] =
                    ["rewrite", "reload"].map(|way| bytes[&(technique, way)].expect("counted"));
                let is_less = rewrite > 0.0 && 5.0 * rewrite < reload;
                assert!(is_less, "{rewrite} {reload}");
            }
        });
    }

    #[test]
    fn a_frame_that_was_not_updated_is_wrong() {
        let group = sweep_of(Depth::Quick, 4);
        with_session(&group, |session| {
            let case = &group.work.cases[0];
            let (mut flight, right) = session.fly(case, 1).expect("flies");
            assert_eq!(right.tally.wrong, []);
            let drawn = flight.backend.render(&flight.input).expect("draws");
            let mut stale = Compared::default();
            let figures = session.figures(&*flight.backend, &drawn, 20);
            stale.add(20, figures, StepCost::default());
            let verdict = stale.verdict(String::new());
            assert_eq!(verdict.status, Status::Wrong);
            let reason = verdict.reason;
            assert!(reason.starts_with("1 of 1 frames; frame 20: "), "{reason}");
            assert!(stale.tally.outside_px > 0);
        });
    }
}
