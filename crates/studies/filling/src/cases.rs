// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which cases a view of a scene gives, and what each is measured for.

use crate::keys::*;
use crate::memory::REGION_COUNTS;
use crate::purpose::Purpose;
use crate::request::{STUDY, Wishes};
use crate::subject::Subject;
use crate::textured::{ShownPicture, is_of_2007, is_picture_scene, textured_variants};
use std::collections::BTreeMap;
use std::sync::Arc;
use terrafill_contract::{PlannedStep, Role, Technique};
use terrafill_core::MeshOptions;
use terrafill_gpu::BaselineKind;
use terrafill_plan::{PlanOptions, WallHeights};
use terrafill_results::{CaseId, ConditionKey, PlannedCase};
use terrafill_scene::{Scene, View};
use terrafill_stencil::{matrix_row, needs_ablation};
use terrafill_study::StudyError;
use terrafill_variant::Variant;

/// A case's place in an ablation.
#[derive(Debug, Clone)]
pub(crate) struct AblationPlace {
    /// From 1.
    pub(crate) number: usize,
    pub(crate) step: PlannedStep,
}

/// One case.
#[derive(Debug, Clone)]
pub(crate) struct FillCase {
    /// What draws it.
    pub(crate) subject: Subject,
    /// Mesh options that are not the scene's, and what the variant says of them.
    pub(crate) mesh: Option<(MeshOptions, String)>,
    /// Which picture it shows; plain fills show none.
    pub(crate) shown: ShownPicture,
    /// What it is for.
    pub(crate) purposes: Vec<Purpose>,
    /// Where it stands in its technique's ablation.
    pub(crate) place: Option<AblationPlace>,
    /// Where it stands between everything and what the view needs.
    pub(crate) needs_place: Option<AblationPlace>,
    /// Of bytes by formula: for so many regions.
    pub(crate) regions: Option<usize>,
    /// Timed frames in a process; 0 for a case that is only drawn and compared.
    pub(crate) frames: u32,
}

impl FillCase {
    /// Whether it stands in every view's comparison.
    pub(crate) fn is_compared(&self) -> bool {
        self.is(Purpose::Main) || self.is(Purpose::Layout)
    }

    pub(crate) fn new(subject: Subject, purpose: Purpose, frames: u32) -> Self {
        Self {
            subject,
            mesh: None,
            shown: ShownPicture::Scene,
            purposes: vec![purpose],
            place: None,
            needs_place: None,
            regions: None,
            frames,
        }
    }

    pub(crate) fn is(&self, purpose: Purpose) -> bool {
        self.purposes.contains(&purpose)
    }

    /// Technique and variant: a view has no two cases of one name.
    fn name(&self) -> (&'static str, String) {
        (self.subject.backend(), self.variant_name())
    }

    /// Its variant with what of mesh and picture is its own.
    pub(crate) fn variant_name(&self) -> String {
        let mesh = self.mesh.as_ref().map(|(_, name)| name.as_str());
        let own = [mesh, self.shown.name()].into_iter().flatten();
        own.fold(self.subject.variant_name(), |name, own| {
            format!("{name},{own}")
        })
    }
}

/// All cases of one scene and view: measured together, interleaved.
#[derive(Debug)]
pub(crate) struct ViewGroup {
    /// The scene.
    pub(crate) scene: Arc<Scene>,
    /// Its view.
    pub(crate) view: View,
    /// Image size.
    pub(crate) size: terrafill_scene::ImageSize,
    /// Baselines first.
    pub(crate) cases: Vec<FillCase>,
}

impl ViewGroup {
    /// `planet-134/globe`.
    pub(crate) fn name(&self) -> String {
        format!("{}/{}", self.scene.name, self.view.name)
    }

    /// Why its session cannot go on.
    pub(crate) fn broken(&self, why: &impl ToString) -> StudyError {
        StudyError::Broken {
            place: self.name(),
            message: why.to_string(),
        }
    }

    /// What a case is to the runner.
    pub(crate) fn planned(&self, case: &FillCase) -> PlannedCase {
        let (scene, view) = (&self.scene.name, &self.view.name);
        let technique = case.subject.backend();
        let purposes: Vec<&str> = case.purposes.iter().map(|purpose| purpose.name()).collect();
        let role = purposes.join("+");
        let (name, conditions) = if let Some(regions) = case.regions {
            let layout = case.subject.layout();
            let name = format!("{scene}/memory/{technique}/{layout}/{regions}");
            let conditions = vec![
                (SCENE, scene.clone()),
                (TECHNIQUE, technique.to_owned()),
                (LAYOUT, layout),
                (REGIONS, regions.to_string()),
            ];
            (name, conditions)
        } else {
            let variant = case.variant_name();
            let name = format!("{scene}/{view}/{technique}/{variant}");
            (name, self.conditions(case, &variant))
        };
        let conditions = conditions.into_iter().chain([(ROLE, role)]);
        PlannedCase {
            id: CaseId::new(STUDY, name, conditions),
            samples: case.frames,
            may_be_wrong: case.is(Purpose::Sweep)
                || case.is(Purpose::Rival)
                || case.subject.switches().is_some_and(is_of_2007)
                || has_tall_walls(case)
                || case.subject.may_be_wrong()
                || case.subject.is_approximate(),
        }
    }

    /// One for each thing that tells the case from others; switches with their defaults.
    fn conditions(&self, case: &FillCase, variant: &str) -> Vec<(ConditionKey, String)> {
        let mut conditions = case.subject.settings();
        if let (true, Subject::Fill(rival, _)) = (case.is(Purpose::Rival), &case.subject) {
            // Nothing of our switches, plans and meshes is its own.
            let own = |key: &str| rival.parameters().iter().any(|own| own.key == key);
            conditions.retain(|(key, _)| *key == LAYOUT || own(key.name()));
        }
        conditions.extend([
            (SCENE, self.scene.name.clone()),
            (VIEW, self.view.name.clone()),
            (TECHNIQUE, case.subject.backend().to_owned()),
            (VARIANT, variant.to_owned()),
        ]);
        if !case.is(Purpose::Baseline) && !case.is(Purpose::Rival) {
            let own = case.mesh.as_ref().map(|(mesh, _)| *mesh);
            let mesh = own.unwrap_or(self.scene.mesh);
            let picture = match case.shown {
                ShownPicture::Scene => "scene",
                ShownPicture::Each => "each",
                ShownPicture::Small => "32",
            };
            conditions.extend([
                (TOLERANCE_M, mesh.boundary_tolerance_m.to_string()),
                (CAP_STEP, mesh.cap_step_deg.to_string()),
            ]);
            if case.is(Purpose::Texture) {
                conditions.push((PICTURE, picture.to_owned()));
            }
        }
        if case.subject.is_approximate() {
            conditions.push((APPROXIMATE, "yes".to_owned()));
        }
        if let Some(AblationPlace { number, step }) = &case.needs_place {
            conditions.extend([
                (NEEDS_RUNG, number.to_string()),
                (NEEDS_STEP, step.name.to_owned()),
            ]);
        }
        if let Some(AblationPlace { number, step }) = &case.place {
            conditions.extend([(RUNG, number.to_string()), (STEP, step.name.to_owned())]);
            if step.is_aside {
                conditions.push((ASIDE, "yes".to_owned()));
            }
        }
        conditions
    }
}

/// The cases of `scene` seen by `view`.
///
/// - `memory_regions`: how many regions the scene has, in the view whose cases give the bytes of its layouts
pub(crate) fn view_group(
    scene: &Arc<Scene>,
    view: &View,
    memory_regions: Option<usize>,
    wishes: &Wishes,
) -> ViewGroup {
    let mut builder = Builder {
        scene,
        view,
        wishes,
        cases: Vec::new(),
        places: BTreeMap::new(),
    };
    if is_picture_scene(scene) {
        for technique in &wishes.techniques {
            builder.add_textured(*technique, [0, 0]);
        }
    } else {
        builder.add_all();
        if let Some(regions) = memory_regions {
            builder.add_memory(regions);
        }
    }
    ViewGroup {
        scene: Arc::clone(scene),
        view: view.clone(),
        size: wishes.size,
        cases: builder.cases,
    }
}

struct Builder<'a> {
    scene: &'a Scene,
    view: &'a View,
    wishes: &'a Wishes,
    cases: Vec<FillCase>,
    /// Of the first case of each technique and variant.
    places: BTreeMap<(&'static str, String), usize>,
}

impl Builder<'_> {
    fn add_all(&mut self) {
        let (scene, wishes) = (self.scene, self.wishes);
        let frames = wishes.frames();
        for kind in BaselineKind::ALL {
            self.add(Subject::Baseline(kind), Purpose::Baseline, frames);
        }
        let role = if wishes.is_full() {
            Role::Main
        } else {
            Role::Quick
        };
        for technique in &wishes.techniques {
            let full_plans = technique.full_plans(scene.overlap);
            // A technique without an ablation is used as it is.
            let purpose = if full_plans.is_empty() {
                Purpose::Main
            } else {
                Purpose::Layout
            };
            for variant in technique.variants(scene, role) {
                let subject = Subject::Fill(*technique, variant);
                if !subject.is_approximate() || wishes.wants_approximate(scene) {
                    self.add(subject, purpose, frames);
                }
            }
            for variant in full_plans {
                let subject = Subject::Fill(*technique, variant);
                self.add(subject.clone(), Purpose::Main, frames);
                self.add(subject, Purpose::FullPlan, frames);
            }
            self.add_textured(*technique, [frames, wishes.few_frames()]);
            if wishes.is_full() {
                self.add_sweeps(*technique, frames);
            }
        }
        for rival in &wishes.rivals {
            for variant in rival.variants(scene, role) {
                let subject = Subject::Fill(*rival, variant);
                self.add(subject, Purpose::Rival, wishes.few_frames());
            }
        }
        if wishes.wants_ablation(&scene.name) {
            for technique in &wishes.techniques {
                for (step, number) in wishes.steps(*technique, scene).into_iter().zip(1..) {
                    let subject = Subject::Fill(*technique, step.variant.clone());
                    let case = self.add(subject, Purpose::Ablation, wishes.few_frames());
                    case.place = Some(AblationPlace { number, step });
                }
            }
        }
        self.add_needs();
        if wishes.wants_matrix(&scene.name) {
            for technique in &wishes.techniques {
                for base in technique.variants(scene, Role::Layouts) {
                    for variant in matrix_row(*technique, &base, scene.overlap) {
                        self.add(Subject::Fill(*technique, variant), Purpose::Matrix, 0);
                    }
                }
            }
        }
    }

    /// What the view needs, drawn and not timed; with the scene's ablation, the way there from everything too.
    fn add_needs(&mut self) {
        let (scene, wishes) = (self.scene, self.wishes);
        let techniques = wishes.techniques.iter();
        // One technique says what a view needs; a full run says it of all.
        let count = if wishes.is_full() { usize::MAX } else { 1 };
        let ablations = techniques.map(|technique| {
            let has_picture = scene.texture.is_some();
            (
                *technique,
                needs_ablation(*technique, scene.overlap, has_picture),
            )
        });
        let ablations = ablations.filter(|(_, steps)| !steps.is_empty());
        for (technique, mut steps) in ablations.take(count) {
            let has_ablation = wishes.wants_ablation(&scene.name);
            let frames = if has_ablation { wishes.few_frames() } else { 0 };
            if !has_ablation {
                steps.drain(..steps.len() - 1);
            }
            for (step, number) in steps.into_iter().zip(1..) {
                let subject = Subject::Fill(technique, step.variant.clone());
                let case = self.add(subject, Purpose::Needs, frames);
                case.needs_place = has_ablation.then_some(AblationPlace { number, step });
            }
        }
    }

    /// A case that exists already takes the purpose on, and the larger number of frames.
    fn add(&mut self, subject: Subject, purpose: Purpose, frames: u32) -> &mut FillCase {
        let new = FillCase::new(subject, purpose, frames);
        let known = self.places.get(&new.name()).copied();
        let index = match known {
            Some(index) => {
                let case = &mut self.cases[index];
                if !case.is(purpose) {
                    case.purposes.push(purpose);
                }
                case.frames = case.frames.max(frames);
                index
            }
            None => self.push(new),
        };
        &mut self.cases[index]
    }

    fn push(&mut self, case: FillCase) -> usize {
        let index = self.cases.len();
        self.places.entry(case.name()).or_insert(index);
        self.cases.push(case);
        index
    }

    /// - `frames`: of the two routes, which are held against a limit, and of what varies them
    fn add_textured(&mut self, technique: &'static dyn Technique, frames: [u32; 2]) {
        if !technique.has_stencil_switches() {
            return;
        }
        let plain = technique.main(self.scene.overlap);
        let first = self.wishes.all_techniques.first();
        let is_first = first.is_some_and(|first| first.name() == technique.name());
        let is_full = self.wishes.is_full();
        let variants = textured_variants(&plain, is_first, self.scene, self.view, !is_full);
        for (variant, shown) in variants {
            let is_varied =
                shown != ShownPicture::Scene || !is_first || is_of_2007(&variant.switches);
            let subject = Subject::Fill(technique, variant);
            let frames = frames[usize::from(is_varied)];
            self.push(FillCase {
                shown,
                ..FillCase::new(subject, Purpose::Texture, frames)
            });
        }
    }

    fn add_sweeps(&mut self, technique: &'static dyn Technique, frames: u32) {
        let scene = self.scene;
        let variants = technique.variants(scene, Role::Sweep);
        let mut add = |variant: &Variant, mesh: MeshOptions, name: String, purpose: Purpose| {
            let subject = Subject::Fill(technique, variant.clone());
            self.push(FillCase {
                mesh: Some((mesh, name)),
                ..FillCase::new(subject, purpose, frames)
            });
        };
        for variant in &variants {
            for &tolerance in &scene.sweep_boundary_tolerance_m {
                let mesh = MeshOptions {
                    boundary_tolerance_m: tolerance,
                    ..scene.mesh
                };
                let name = format!("boundary-tolerance-m={tolerance}");
                add(variant, mesh, name, Purpose::Sweep);
            }
        }
        // One layout: the question is one about meshes.
        for variant in variants.iter().take(1) {
            for &step in &scene.sweep_cap_step_deg {
                let mesh = MeshOptions {
                    cap_step_deg: step,
                    ..scene.mesh
                };
                let name = format!("cap-step-deg={step}");
                add(variant, mesh, name, Purpose::Subdivision);
            }
        }
    }

    /// Bytes of every layout that is drawn here, for the scene's regions and for other numbers of them.
    ///
    /// - `own`: how many regions the scene has
    fn add_memory(&mut self, own: usize) {
        let mut layouts: Vec<(&str, String)> = Vec::new();
        let mut cases = Vec::new();
        for case in &self.cases {
            // What an approximate fill holds follows from the view, or is no geometry.
            let is_plain = case.mesh.is_none()
                && !case.is(Purpose::Texture)
                && !case.subject.is_approximate()
                && !case.is(Purpose::Rival)
                && case.subject.plan() == PlanOptions::default();
            let layout = (case.subject.backend(), case.subject.layout());
            if !is_plain || layout.1.is_empty() || layouts.contains(&layout) {
                continue;
            }
            layouts.push(layout);
            let others = REGION_COUNTS.into_iter().filter(|count| *count != own);
            cases.extend(std::iter::once(own).chain(others).map(|regions| FillCase {
                regions: Some(regions),
                ..FillCase::new(case.subject.clone(), Purpose::Memory, 0)
            }));
        }
        self.cases.extend(cases);
    }
}

/// Whether walls reach farther than they need. A wall that is seen edge on is a triangle of large slope in
/// depth, whose corners rasterisers snap to 1/256 pixel; the taller the wall, the farther that may move
/// where it meets the surface. On `planet-134` from afar 3 pixels within the boundary band differ, one of
/// them 2 pixels from where it should be. How exact tall walls are is part of the question.
fn has_tall_walls(case: &FillCase) -> bool {
    case.subject.plan().wall_heights == WallHeights::Global
}
