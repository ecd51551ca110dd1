// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases a scene gives, and what each is measured for.

use crate::textured::{ShownPicture, is_picture_scene, textured_variants};
use crate::{BenchOptions, Subject};
use std::sync::Arc;
use terrafill_fill::{Role, Technique, matrix_row};
use terrafill_gpu::BaselineKind;
use terrafill_results::legacy::{CaseKey, LadderRung};
use terrafill_scene::{Scene, View};

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
#[derive(Debug, Clone)]
pub struct BenchCase {
    /// Its name.
    pub key: CaseKey,
    /// What draws it.
    pub subject: Subject,
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
    let techniques = options.wanted_techniques();
    let mut rungs = Vec::new();
    let role = if options.quick {
        Role::Quick
    } else {
        Role::Main
    };
    for technique in techniques.clone() {
        for variant in technique.variants(scene, role) {
            group.add(
                Subject::Fill(technique, variant),
                Roles {
                    main: true,
                    ..Roles::default()
                },
                frames,
            );
        }
        let few = options.ladder_frame_count();
        group.add_textured(technique, options, [frames, few]);
        if !options.quick {
            group.add_sweep(technique, frames);
        }
    }
    for technique in techniques
        .clone()
        .filter(|_| options.wants_ladder(&scene.name))
    {
        let role = Roles {
            ladder: true,
            ..Roles::default()
        };
        for (rung, number) in technique.ladder(scene.overlap).into_iter().zip(1..) {
            let subject = Subject::Fill(technique, rung.variant);
            let key = group.add(subject, role, options.ladder_frame_count());
            rungs.push(LadderRung {
                ladder: technique.name().to_owned(),
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
    for technique in techniques.filter(|_| options.wants_matrix(&scene.name)) {
        let role = Roles {
            matrix: true,
            ..Roles::default()
        };
        for base in technique.variants(scene, Role::Layouts) {
            for variant in matrix_row(technique, &base, scene.overlap) {
                group.add(Subject::Fill(technique, variant), role, 0);
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
        for technique in options.wanted_techniques() {
            self.add_textured(technique, options, [0, 0]);
        }
        SceneGroup {
            scene: Arc::clone(scene),
            view: self.view.clone(),
            cases: self.cases,
            ladder: Vec::new(),
        }
    }

    /// - `frames`: of the two routes, which are held against a bound, and of what varies them
    fn add_textured(
        &mut self,
        technique: &'static dyn Technique,
        options: &BenchOptions,
        frames: [u32; 2],
    ) {
        let plain = technique.main(self.scene.overlap);
        let first = options.techniques.first();
        let is_first = first.is_some_and(|first| first.name() == technique.name());
        let textured = textured_variants(&plain, is_first, self.scene, self.view, options.quick);
        for (variant, shown) in textured {
            let is_varied =
                shown != ShownPicture::Scene || !is_first || variant.switches.superfluous_normalize;
            let subject = Subject::Fill(technique, variant);
            let knob = shown
                .name()
                .map_or(String::new(), |name| format!(",{name}"));
            let roles = Roles {
                texture: true,
                ..Roles::default()
            };
            let frames = frames[usize::from(is_varied)];
            let case = self.case(subject, &knob, roles, frames);
            self.cases.push(BenchCase { shown, ..case });
        }
    }

    fn add_baselines(&mut self, frames: u32) {
        for kind in [BaselineKind::Bound, BaselineKind::Floor] {
            let roles = Roles {
                baseline: true,
                ..Roles::default()
            };
            let case = self.case(Subject::Baseline(kind), "", roles, frames);
            self.cases.push(BenchCase {
                boundary_tolerance_m: None,
                cap_step_deg: None,
                ..case
            });
        }
    }

    /// A case with the scene's meshes and picture.
    ///
    /// - `knob`: what of the input its name says, with the comma before it
    fn case(&self, subject: Subject, knob: &str, roles: Roles, frames: u32) -> BenchCase {
        BenchCase {
            key: self.key(&subject, knob),
            subject,
            boundary_tolerance_m: Some(self.scene.mesh.boundary_tolerance_m),
            cap_step_deg: Some(self.scene.mesh.cap_step_deg),
            shown: ShownPicture::Scene,
            roles,
            frames,
        }
    }

    fn key(&self, subject: &Subject, knob: &str) -> CaseKey {
        CaseKey {
            scene: self.scene.name.clone(),
            view: self.view.name.clone(),
            backend: subject.backend().to_owned(),
            variant: subject.variant_name() + knob,
        }
    }

    /// A case that exists already takes the role on, and the larger number of frames.
    fn add(&mut self, subject: Subject, roles: Roles, frames: u32) -> CaseKey {
        let key = self.key(&subject, "");
        match self.cases.iter_mut().find(|case| case.key == key) {
            Some(case) => {
                case.roles = case.roles.and(roles);
                case.frames = case.frames.max(frames);
            }
            None => self.cases.push(self.case(subject, "", roles, frames)),
        }
        key
    }

    fn add_sweep(&mut self, technique: &'static dyn Technique, frames: u32) {
        let scene = self.scene;
        let variants = technique.variants(scene, Role::Sweep);
        for variant in &variants {
            for &tolerance in &scene.sweep_boundary_tolerance_m {
                let roles = Roles {
                    sweep: true,
                    ..Roles::default()
                };
                let knob = format!(",boundary-tolerance-m={tolerance}");
                let subject = Subject::Fill(technique, variant.clone());
                let case = self.case(subject, &knob, roles, frames);
                self.cases.push(BenchCase {
                    boundary_tolerance_m: Some(tolerance),
                    ..case
                });
            }
        }
        // One layout: what is asked is a question about meshes.
        for variant in variants.iter().take(1) {
            for &step in &scene.sweep_cap_step_deg {
                let roles = Roles {
                    subdivision: true,
                    ..Roles::default()
                };
                let knob = format!(",cap-step-deg={step}");
                let subject = Subject::Fill(technique, variant.clone());
                let case = self.case(subject, &knob, roles, frames);
                self.cases.push(BenchCase {
                    cap_step_deg: Some(step),
                    ..case
                });
            }
        }
    }
}
