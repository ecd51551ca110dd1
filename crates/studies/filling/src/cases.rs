// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases a scene gives, and what each is measured for.

use crate::ladder::ladder;
use crate::matrix::matrix_row;
use crate::technique::BACKENDS;
use crate::textured::{ShownPicture, is_picture_scene, textured_settings};
use crate::{BenchOptions, Setting, Technique};
use std::sync::Arc;
use terrafill_compute::{ComputeVariant, Expansion, Transform};
use terrafill_fill::{ColourWay, PositionFormat, Switches};
use terrafill_gpu::BaselineKind;
use terrafill_native::{Indices, NativeVariant, Technique as Native};
use terrafill_results::legacy::{CaseKey, LadderRung};
use terrafill_scene::{PlanOptions, Scene, View};
use terrafill_vertex::{Layout, VertexVariant};

/// What a case is measured for; it may be several things at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Roles {
    /// A full-screen pass that techniques are held against.
    pub baseline: bool,
    /// A technique as it should be used, or one switch beside it.
    pub main: bool,
    /// A point of the sweep through the boundary tolerance: allowed to be wrong, since its error is
    /// what the sweep is about.
    pub sweep: bool,
    /// A point of the sweep through the cap step: right, and asked for its walls and its time.
    pub subdivision: bool,
    /// A rung of a ladder.
    pub ladder: bool,
    /// A cell of the matrix.
    pub matrix: bool,
    /// A textured fill.
    pub texture: bool,
}

impl Roles {
    /// Names joined by `+`, as in the `role` column.
    #[must_use]
    pub fn name(self) -> String {
        let names = [
            (self.baseline, "baseline"),
            (self.main, "main"),
            (self.sweep, "sweep"),
            (self.subdivision, "subdivision"),
            (self.ladder, "ladder"),
            (self.matrix, "matrix"),
            (self.texture, "texture"),
        ];
        let held = names.into_iter().filter(|(held, _)| *held);
        held.map(|(_, name)| name).collect::<Vec<_>>().join("+")
    }

    fn and(self, other: Self) -> Self {
        Self {
            baseline: self.baseline || other.baseline,
            main: self.main || other.main,
            sweep: self.sweep || other.sweep,
            subdivision: self.subdivision || other.subdivision,
            ladder: self.ladder || other.ladder,
            matrix: self.matrix || other.matrix,
            texture: self.texture || other.texture,
        }
    }
}

/// One case: a row to be.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchCase {
    /// Its name.
    pub key: CaseKey,
    /// What draws it.
    pub technique: Technique,
    /// How its frame is planned.
    pub plan: PlanOptions,
    /// Boundary tolerance of its meshes, metres; `None` for baselines.
    pub boundary_tolerance_m: Option<f64>,
    /// Largest edge of a cap triangle, degrees; `None` for baselines.
    pub cap_step_deg: Option<f64>,
    /// Which picture it shows; plain fills show none.
    pub shown: ShownPicture,
    /// What it is for.
    pub roles: Roles,
    /// Timed frames; 0 for a case that is only drawn and compared.
    pub frames: u32,
}

/// All cases of one scene and view: measured together, interleaved.
#[derive(Debug, Clone)]
pub struct SceneGroup {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Its view.
    pub view: View,
    /// Baselines first.
    pub cases: Vec<BenchCase>,
    /// Ladders through `cases`.
    pub ladder: Vec<LadderRung>,
}

/// The cases of `scene` seen by `view`.
#[must_use]
pub fn group_cases(scene: &Arc<Scene>, view: &View, options: &BenchOptions) -> SceneGroup {
    let mut group = Builder {
        scene,
        view,
        cases: Vec::new(),
    };
    let frames = options.frame_count();
    if is_picture_scene(scene) {
        return group.of_pictures(scene, options);
    }
    group.add_baselines(frames);
    let backends = BACKENDS.iter().filter(|name| options.wants_backend(name));
    let mut rungs = Vec::new();
    for backend in backends.clone() {
        for setting in main_settings(backend, scene, options.quick) {
            group.add(
                setting,
                Roles {
                    main: true,
                    ..Roles::default()
                },
                frames,
            );
        }
        let few = options.ladder_frame_count();
        group.add_textured(backend, options.quick, [frames, few]);
        if !options.quick {
            group.add_sweep(backend, frames);
        }
    }
    for backend in backends
        .clone()
        .filter(|_| options.wants_ladder(&scene.name))
    {
        let role = Roles {
            ladder: true,
            ..Roles::default()
        };
        for (rung, number) in ladder(backend, scene.overlap).into_iter().zip(1..) {
            let key = group.add(rung.setting, role, options.ladder_frame_count());
            rungs.push(LadderRung {
                ladder: (*backend).to_owned(),
                rung: number,
                step: rung.step.to_owned(),
                change: rung.change.to_owned(),
                scene: key.scene,
                view: key.view,
                backend: key.backend,
                variant: key.variant,
            });
        }
    }
    for backend in backends.filter(|_| options.wants_matrix(&scene.name)) {
        let role = Roles {
            matrix: true,
            ..Roles::default()
        };
        for base in layouts(backend, scene) {
            for setting in matrix_row(base, scene.overlap) {
                group.add(setting, role, 0);
            }
        }
    }
    SceneGroup {
        scene: Arc::clone(scene),
        view: view.clone(),
        cases: group.cases,
        ladder: rungs,
    }
}

struct Builder<'a> {
    scene: &'a Scene,
    view: &'a View,
    cases: Vec<BenchCase>,
}

impl Builder<'_> {
    /// Textured fills only, drawn and compared but not timed.
    fn of_pictures(mut self, scene: &Arc<Scene>, options: &BenchOptions) -> SceneGroup {
        for backend in BACKENDS.iter().filter(|name| options.wants_backend(name)) {
            self.add_textured(backend, options.quick, [0, 0]);
        }
        SceneGroup {
            scene: Arc::clone(scene),
            view: self.view.clone(),
            cases: self.cases,
            ladder: Vec::new(),
        }
    }

    /// - `frames`: of the two routes, which are held against a bound, and of what varies them
    fn add_textured(&mut self, backend: &str, quick: bool, frames: [u32; 2]) {
        let Some(main) = Technique::main(backend, self.scene.overlap) else {
            return;
        };
        let plain = Setting::new(main);
        for (setting, shown) in textured_settings(plain, self.scene, self.view, quick) {
            let switches = setting.technique.switches();
            let is_varied = shown != ShownPicture::Scene
                || !matches!(main, Technique::Vertex(_))
                || switches.is_some_and(|switches| switches.superfluous_normalize);
            self.cases.push(BenchCase {
                key: self.key(
                    &setting,
                    &shown.name().map_or(String::new(), |n| format!(",{n}")),
                ),
                technique: setting.technique,
                plan: setting.plan,
                boundary_tolerance_m: Some(self.scene.mesh.boundary_tolerance_m),
                cap_step_deg: Some(self.scene.mesh.cap_step_deg),
                shown,
                roles: Roles {
                    texture: true,
                    ..Roles::default()
                },
                frames: frames[usize::from(is_varied)],
            });
        }
    }

    fn add_baselines(&mut self, frames: u32) {
        for kind in [BaselineKind::Bound, BaselineKind::Floor] {
            let setting = Setting::new(Technique::Baseline(kind));
            self.cases.push(BenchCase {
                key: self.key(&setting, ""),
                technique: setting.technique,
                plan: setting.plan,
                boundary_tolerance_m: None,
                cap_step_deg: None,
                shown: ShownPicture::Scene,
                roles: Roles {
                    baseline: true,
                    ..Roles::default()
                },
                frames,
            });
        }
    }

    /// `knob`: what of the mesh the variant changes, with the comma before it.
    fn key(&self, setting: &Setting, knob: &str) -> CaseKey {
        let variant = setting.variant_name() + knob;
        CaseKey {
            scene: self.scene.name.clone(),
            view: self.view.name.clone(),
            backend: setting.technique.backend().to_owned(),
            variant,
        }
    }

    /// A case that exists already takes the role on, and the larger number of frames.
    fn add(&mut self, setting: Setting, roles: Roles, frames: u32) -> CaseKey {
        let key = self.key(&setting, "");
        match self.cases.iter_mut().find(|case| case.key == key) {
            Some(case) => {
                case.roles = case.roles.and(roles);
                case.frames = case.frames.max(frames);
            }
            None => self.cases.push(BenchCase {
                key: key.clone(),
                technique: setting.technique,
                plan: setting.plan,
                boundary_tolerance_m: Some(self.scene.mesh.boundary_tolerance_m),
                cap_step_deg: Some(self.scene.mesh.cap_step_deg),
                shown: ShownPicture::Scene,
                roles,
                frames,
            }),
        }
        key
    }

    fn add_sweep(&mut self, backend: &str, frames: u32) {
        let scene = self.scene;
        for setting in sweep_settings(backend, scene) {
            for &tolerance in &scene.sweep_boundary_tolerance_m {
                let role = Roles {
                    sweep: true,
                    ..Roles::default()
                };
                let knob = format!(",boundary-tolerance-m={tolerance}");
                self.add_meshed(
                    setting,
                    &knob,
                    tolerance,
                    scene.mesh.cap_step_deg,
                    role,
                    frames,
                );
            }
        }
        // One layout: what is asked is a question about meshes.
        for setting in sweep_settings(backend, scene).into_iter().take(1) {
            for &step in &scene.sweep_cap_step_deg {
                let role = Roles {
                    subdivision: true,
                    ..Roles::default()
                };
                let tolerance = scene.mesh.boundary_tolerance_m;
                let knob = format!(",cap-step-deg={step}");
                self.add_meshed(setting, &knob, tolerance, step, role, frames);
            }
        }
    }

    /// A case whose meshes are its own.
    fn add_meshed(
        &mut self,
        setting: Setting,
        knob: &str,
        boundary_tolerance_m: f64,
        cap_step_deg: f64,
        roles: Roles,
        frames: u32,
    ) {
        self.cases.push(BenchCase {
            key: self.key(&setting, knob),
            technique: setting.technique,
            plan: setting.plan,
            boundary_tolerance_m: Some(boundary_tolerance_m),
            cap_step_deg: Some(cap_step_deg),
            shown: ShownPicture::Scene,
            roles,
            frames,
        });
    }
}

/// A vertex layout with the colouring that is right for the scene: XOR holds for disjoint regions
/// only.
fn vertex(layout: Layout, scene: &Scene) -> Setting {
    Setting::new(Technique::Vertex(VertexVariant {
        layout,
        switches: Switches::for_overlap(scene.overlap),
        ..VertexVariant::default()
    }))
}

/// A native technique with the colouring that is right for the scene.
fn native(technique: Native, scene: &Scene) -> Setting {
    Setting::new(Technique::Native(NativeVariant {
        technique,
        switches: Switches::for_overlap(scene.overlap),
        ..NativeVariant::default()
    }))
}

fn in_lists(mut setting: Setting) -> Setting {
    if let Technique::Native(variant) = &mut setting.technique {
        variant.indices = Some(Indices::List);
    }
    setting
}

/// Every layout of a backend, as it should be used.
fn layouts(backend: &str, scene: &Scene) -> Vec<Setting> {
    match backend {
        "vertex" => Layout::ALL.map(|layout| vertex(layout, scene)).into(),
        "compute" => [Expansion::PerFrame, Expansion::Cached]
            .map(|expansion| {
                Setting::new(Technique::Compute(ComputeVariant {
                    expansion,
                    switches: Switches::for_overlap(scene.overlap),
                    ..ComputeVariant::default()
                }))
            })
            .into(),
        "native" => Native::ALL.map(|technique| native(technique, scene)).into(),
        _ => Vec::new(),
    }
}

/// Layouts, and position formats where the scene asks for them, whose error is drawn against their
/// time.
fn sweep_settings(backend: &str, scene: &Scene) -> Vec<Setting> {
    match backend {
        "vertex" => {
            let layouts = [Layout::Doubled, Layout::Pulled].map(|layout| vertex(layout, scene));
            layouts.into_iter().chain(position_formats(scene)).collect()
        }
        _ => Vec::new(),
    }
}

/// Where a scene asks for it, every other way to store positions; all but the default may be wrong.
fn position_formats(scene: &Scene) -> Vec<Setting> {
    let formats = PositionFormat::ALL.into_iter();
    formats
        .filter(|format| scene.sweep_positions && *format != PositionFormat::default())
        .map(|format| with_positions(vertex(Layout::Doubled, scene), format))
        .collect()
}

fn with_positions(mut setting: Setting, positions: PositionFormat) -> Setting {
    if let Technique::Vertex(variant) = &mut setting.technique {
        variant.positions = positions;
    }
    setting
}

/// Layouts as they should be used; beside them, one switch at a time, what is compared everywhere.
fn main_settings(backend: &str, scene: &Scene, quick: bool) -> Vec<Setting> {
    match backend {
        "vertex" => {}
        "compute" => return compute_settings(scene, quick),
        "native" => {
            let techniques = [Native::VsControl, Native::GsDegenerate, Native::GsLine];
            let mut settings = techniques
                .map(|technique| native(technique, scene))
                .to_vec();
            if !quick {
                settings.push(in_lists(native(Native::GsDegenerate, scene)));
            }
            return settings;
        }
        _ => return layouts(backend, scene),
    }
    let mut settings: Vec<Setting> = [Layout::Doubled, Layout::Pulled]
        .map(|layout| vertex(layout, scene))
        .into();
    if !quick {
        let main = vertex(Layout::Doubled, scene);
        if Switches::for_overlap(scene.overlap).colour != ColourWay::Rectangle {
            settings.push(main.with(|switches| switches.colour = ColourWay::Rectangle));
        }
        // A scene that sweeps through the formats has it there, where it may be wrong.
        if !scene.sweep_positions {
            settings.push(with_positions(main, PositionFormat::LocalF32));
        }
    }
    settings
}

/// Both expansions and, beside the first, corners that the compute stage puts where they are seen.
fn compute_settings(scene: &Scene, quick: bool) -> Vec<Setting> {
    let mut settings = layouts("compute", scene);
    if !quick && let Technique::Compute(variant) = settings[0].technique {
        settings.push(Setting::new(Technique::Compute(ComputeVariant {
            transform: Transform::ComputeStage,
            ..variant
        })));
    }
    settings
}
