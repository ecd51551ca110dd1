// SPDX-License-Identifier: MIT OR Apache-2.0
//! One scene and view being measured: the reference is drawn once, probes are compared with it, and
//! frames are timed.

mod check;
mod drawn;
mod judging;
mod pictures;
mod references;
#[cfg(test)]
mod tests;

pub use check::PictureCheck;

use crate::cases::{FillCase, ViewGroup};
use crate::memory::LayoutOfScene;
use crate::probe::failed;
use crate::purpose::Purpose;
use crate::rounding::{objection, rounding_px};
use crate::scenes::{ReadyScene, build_meshes};
use crate::subject::Subject;
use crate::textured::{ShownPicture, TexturedReferences};
use drawn::ProbePicture;
use pictures::PictureFiles;
use references::References;
use std::collections::BTreeMap;
use std::rc::Rc;
use terrafill_contract::{Api, FillBackend, FillInput, FrameTimes, MemoryUse, Targets};
use terrafill_core::MeshOptions;
use terrafill_gpu::{Baseline, CpuStopwatch, SharedTargets, shared_targets};
use terrafill_plan::{LazyMesh, PlanOptions};
use terrafill_results::{Status, Verdict, median};
use terrafill_stencil::PositionFormat;
use terrafill_study::{Context, Failure, Figures, Session, StudyError};

/// What a probe frame is drawn for.
#[derive(Debug, Clone, Copy)]
enum ProbeFrame {
    /// Its picture and its counts.
    Counted,
    /// Its picture, see [`FillBackend::render_uncounted`].
    PictureOnly,
}

enum Drawer {
    Baseline(Baseline),
    Volumes(Box<dyn FillBackend>, Rc<FillInput>),
}

/// Mesh options where they are not the scene's, how frames are planned, and which picture is shown.
type InputKey = (Option<MeshOptions>, PlanOptions, ShownPicture);

/// An input and the median CPU time of planning it.
type PlannedInput = (Rc<FillInput>, Option<f64>);

/// One scene and view being measured.
pub(crate) struct ViewSession<'a> {
    group: &'a ViewGroup,
    targets: Targets,
    /// Those of wgpu, which baselines draw on.
    wgpu: SharedTargets,
    ready: Rc<ReadyScene>,
    /// What the scene's mesh options give; other inputs share its surface.
    input: Rc<FillInput>,
    references: References<'a>,
    /// The reference with pictures.
    textured_references: TexturedReferences,
    /// Inputs of other mesh or plan options, with how long their plans take.
    inputs: Vec<(InputKey, PlannedInput)>,
    /// What each technique's variants allocated, for the cases about memory; `None` for what could
    /// not be drawn.
    allocated: BTreeMap<(&'static str, String), Option<MemoryUse>>,
    drawers: BTreeMap<usize, Drawer>,
    pictures: PictureFiles<'a>,
    /// GPU time of this block's surface pass by interface.
    surfaces: Vec<(Api, Option<f64>)>,
}

/// So many fills a software device draws by turns without forgetting what it compiled for some of them. Of 24 llvmpipe
/// forgot none, of 33 some: a frame that loads shaders again took 7 to 10 ms more than one of 12 ms that does not.
const FILLS_KEPT_COMPILED: usize = 24;

impl<'a> ViewSession<'a> {
    /// - `ready`: the group's scene
    pub(crate) fn new(
        group: &'a ViewGroup,
        ready: &Rc<ReadyScene>,
        context: Context<'a>,
    ) -> Result<Self, StudyError> {
        let prepared = &ready.as_written;
        let bad = |error: &dyn std::fmt::Display| StudyError::BadInput(error.to_string());
        let plan = PlanOptions::default();
        let input = FillInput::new(prepared, &group.view, group.size, plan);
        let input = input.map_err(|error| bad(&error))?;
        let targets = Targets::new(context.devices, group.size);
        let wgpu =
            shared_targets(&targets).map_err(|error| StudyError::NoDevice(error.to_string()))?;
        let input = Rc::new(input);
        Ok(Self {
            group,
            targets,
            wgpu,
            ready: Rc::clone(ready),
            references: References::new(group, context.folder, &input),
            input,
            textured_references: TexturedReferences::default(),
            inputs: Vec::new(),
            allocated: BTreeMap::new(),
            drawers: BTreeMap::new(),
            pictures: PictureFiles::new(group, context.folder),
            surfaces: Vec::new(),
        })
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
                let leveled = self.ready.leveled()?;
                Rc::new(self.input.remeshed(leveled, plan))
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

    /// Opens a case's backend and draws its probe frame. What goes wrong is the case's verdict.
    fn draw(
        &mut self,
        case: &FillCase,
        bound_px: impl Fn(PositionFormat, &FillInput) -> f64,
        probe: ProbeFrame,
    ) -> Result<ProbePicture, Failure> {
        let Subject::Fill(technique, variant) = &case.subject else {
            return Err(Failure::broken("a full-screen pass fills nothing"));
        };
        let (input, plan_cpu_ms) = self.input_for(case)?;
        // A cell of the matrix has to be right; elsewhere its error is the question.
        let has_to_be_right = case.is(Purpose::Matrix) && !case.is_compared();
        let positions = case.subject.positions().filter(|_| has_to_be_right);
        let objection = positions.and_then(|format| objection(format, bound_px(format, &input)));
        if let Some(reason) = objection {
            return Err(Failure::Unable(reason));
        }
        let drawn = technique
            .open(&self.targets, variant)
            .and_then(|mut backend| {
                let watch = CpuStopwatch::start();
                let memory = backend.prepare(&input)?;
                let prepare_cpu_ms = watch.cpu_ms();
                let frame = match probe {
                    ProbeFrame::Counted => backend.render(&input),
                    ProbeFrame::PictureOnly => backend.render_uncounted(&input),
                }?;
                Ok(ProbePicture {
                    backend,
                    memory,
                    frame,
                    input,
                    plan_cpu_ms,
                    prepare_cpu_ms,
                })
            });
        let memory = drawn.as_ref().ok().map(|drawn| drawn.memory);
        self.allocated.insert(allocated_by(case), memory);
        drawn.map_err(failed)
    }

    fn verify_fill(&mut self, index: usize) -> Result<Verdict, Failure> {
        let case = &self.group.cases[index];
        let mut drawn = self.draw(case, rounding_px, ProbeFrame::Counted)?;
        let verdict = self.compare(case, &mut drawn)?;
        // Only what is timed is held on to: a matrix has hundreds of backends.
        if case.frames > 0 {
            self.hold(index, drawn);
        }
        Ok(verdict)
    }

    /// Keeps what draws a case's timed frames.
    fn hold(&mut self, index: usize, drawn: ProbePicture) {
        let drawer = Drawer::Volumes(drawn.backend, drawn.input);
        self.drawers.insert(index, drawer);
    }

    fn verify_baseline(&mut self, index: usize) -> Result<Verdict, Failure> {
        let Subject::Baseline(kind) = self.group.cases[index].subject else {
            return Err(Failure::broken("no full-screen pass"));
        };
        let baseline = Baseline::new(kind, &self.wgpu).map_err(failed)?;
        self.drawers.insert(index, Drawer::Baseline(baseline));
        Ok(right(
            "a full-screen pass: it fills no region, so it has no error",
        ))
    }

    fn verify_memory(&mut self, case: &FillCase, regions: usize) -> Result<Verdict, Failure> {
        // Drawn already, unless a run that was broken off goes on here.
        if !self.allocated.contains_key(&allocated_by(case))
            && let Err(ends @ Failure::Ends(_)) = self.draw(case, rounding_px, ProbeFrame::Counted)
        {
            return Err(ends);
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
        Ok(Verdict {
            figures: layout.figures(regions, allocated),
            ..right(match allocated {
                None => "by formula alone: nothing was drawn in this layout",
                Some(_) => "",
            })
        })
    }
}

impl Session for ViewSession<'_> {
    fn verify(&mut self, index: usize) -> Result<Verdict, Failure> {
        let case = &self.group.cases[index];
        match (&case.subject, case.regions) {
            (_, Some(regions)) => self.verify_memory(case, regions),
            (Subject::Baseline(_), None) => self.verify_baseline(index),
            (Subject::Fill(..), None) => self.verify_fill(index),
        }
    }

    fn recheck(
        &mut self,
        index: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        let case = &self.group.cases[index];
        let hash_of = |name: &str| notes.get(name).map_or("", String::as_str);
        if matches!(case.subject, Subject::Baseline(_)) || hash_of("mask_hash").is_empty() {
            return self.verify(index);
        }
        let drawn = self.draw(case, rounding_px, ProbeFrame::PictureOnly)?;
        let (mask_hash, ids_hash) = drawn.hashes();
        if (hash_of("mask_hash"), hash_of("ids_hash")) != (&mask_hash, &ids_hash) {
            let reason = "its picture is another one than when it was verified";
            return Err(Failure::broken(reason));
        }
        self.hold(index, drawn);
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
        let gpu_ms = drawn.map_err(|error| self.group.broken(&error))?;
        self.surfaces = vec![(terrafill_gpu::API, gpu_ms)];
        for (&index, drawer) in &mut self.drawers {
            let api = self.group.cases[index].subject.api();
            let Drawer::Volumes(backend, input) = drawer else {
                continue;
            };
            if self.surfaces.iter().all(|(drawn, _)| *drawn != api) {
                let drawn = backend.draw_surface(input);
                let gpu_ms = drawn.map_err(|error| self.group.broken(&error))?;
                self.surfaces.push((api, gpu_ms));
            }
        }
        Ok(())
    }

    fn before_sample(&mut self, index: usize) -> Result<(), Failure> {
        let is_software = || self.wgpu.borrow().gpu().facts.is_software();
        if self.drawers.len() > FILLS_KEPT_COMPILED && is_software() {
            self.time(index).map(drop)
        } else {
            Ok(())
        }
    }

    fn time(&mut self, index: usize) -> Result<Figures, Failure> {
        let api = self.group.cases[index].subject.api();
        let drawer = self.drawers.get_mut(&index);
        let drawer = drawer.ok_or_else(|| Failure::broken("it was not made ready"))?;
        let times = match drawer {
            Drawer::Baseline(baseline) => baseline.time_frame(),
            Drawer::Volumes(backend, input) => backend.time_frame(input),
        };
        let times: FrameTimes = times.map_err(failed)?;
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

/// What is drawn for bytes: a technique and its variant.
fn allocated_by(case: &FillCase) -> (&'static str, String) {
    (case.subject.backend(), case.variant_name())
}

/// Right, with a remark.
fn right(remark: &str) -> Verdict {
    Verdict {
        status: Status::Ok,
        reason: remark.to_owned(),
        ..Verdict::default()
    }
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
