// SPDX-License-Identifier: MIT OR Apache-2.0
//! From names to scenes that can be measured.

use crate::cases::{ViewGroup, view_group};
use crate::request::{NO_SCENE, Wishes, ablation_part};
use crate::subject::Surfaces;
use crate::textured::left_out;
use std::cell::{OnceCell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_contract::PreparedScene;
use terrafill_core::{MeshError, MeshOptions, RegionMesh};
use terrafill_lab::distinct;
use terrafill_plan::{LazyMesh, LeveledMeshes, RegionSet};
use terrafill_results::Skipped;
use terrafill_scene::{Overlap, Scene, SceneError, choices, shipped_scene_names};
use terrafill_study::StudyError;
use terrafill_surface::open_surface;

/// Scenes with missing data are skipped with that reason; wrong ones, and those whose regions cannot
/// be meshed, stop the run before it starts; all of them are named.
///
/// - `last`: keeps the last of them, as it was made ready
pub(crate) fn plan_scenes(
    wishes: &Wishes,
    last: &LastReady,
) -> Result<(Vec<ViewGroup>, Vec<Skipped>), StudyError> {
    let request = &wishes.request;
    let names: Vec<String> = if request.scenes.is_empty() {
        let shipped = shipped_scene_names().into_iter();
        shipped.map(str::to_owned).collect()
    } else {
        request.scenes.clone()
    };
    let mut groups: Vec<ViewGroup> = Vec::new();
    let mut skipped = Vec::new();
    let mut errors: Vec<String> = Vec::new();
    for name in &names {
        let is_left_out = !wishes.is_full() && request.scenes.is_empty();
        if let Some(reason) = left_out(name, request.depth).filter(|_| is_left_out) {
            skipped.push(Skipped {
                what: name.clone(),
                reason,
            });
            continue;
        }
        match Scene::open(name, request.data_dir.as_deref()) {
            Ok(scene) if groups.iter().any(|group| group.scene.name == scene.name) => {
                errors.push(format!(
                    "scene {:?} is given twice, allowed: once",
                    scene.name
                ));
            }
            Ok(scene) => {
                let scene = Arc::new(scene);
                match last.get(scene.name.clone(), || ready(&scene, wishes)) {
                    Ok(ready) => {
                        let regions = ready.as_written.meshes.len();
                        let views = scene.views.iter().enumerate();
                        groups.extend(views.map(|(index, view)| {
                            let is_last = index + 1 == scene.views.len();
                            let memory_regions = is_last.then_some(regions);
                            view_group(&scene, view, memory_regions, wishes)
                        }));
                    }
                    Err(error) => errors.push(error.to_string()),
                }
            }
            Err(error @ SceneError::DataMissing { .. }) => skipped.push(Skipped {
                what: name.clone(),
                reason: error.to_string(),
            }),
            Err(error) => errors.push(error.to_string()),
        }
    }
    if !errors.is_empty() {
        return Err(StudyError::BadInput(errors.join("\n")));
    }
    check_wishes(wishes, &groups, &skipped)?;
    Ok((groups, skipped))
}

/// The scene opened last: views of a scene follow each other, and a million vertices are meshed once.
#[derive(Debug)]
pub(crate) struct LastScene<K, T>(RefCell<Option<(K, T)>>);

impl<K, T> Default for LastScene<K, T> {
    fn default() -> Self {
        Self(RefCell::default())
    }
}

impl<K: PartialEq, T: Clone> LastScene<K, T> {
    pub(crate) fn get<E>(&self, key: K, open: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        if let Some((known, opened)) = &*self.0.borrow()
            && *known == key
        {
            return Ok(opened.clone());
        }
        // Freed before the next one is opened.
        *self.0.borrow_mut() = None;
        let opened = open()?;
        *self.0.borrow_mut() = Some((key, opened.clone()));
        Ok(opened)
    }
}

/// The scene of a run that was made ready last, by its name.
pub(crate) type LastReady = LastScene<String, Rc<ReadyScene>>;

/// A scene that is ready to be drawn, in all its views.
#[derive(Debug)]
pub(crate) struct ReadyScene {
    scene: Arc<Scene>,
    /// Its meshes as its file says, and its surface.
    pub(crate) as_written: PreparedScene,
    /// With coarser levels of its boundaries; made when a case first asks for them.
    leveled: OnceCell<PreparedScene>,
}

impl ReadyScene {
    /// Meshes and lays on its surface.
    ///
    /// - `surfaces`: those that it may lie on
    pub(crate) fn new(scene: &Arc<Scene>, surfaces: Surfaces) -> Result<Rc<Self>, StudyError> {
        let meshes = build_meshes(scene, &scene.mesh)?;
        let surface = open_surface(surfaces, scene);
        let surface = surface.map_err(|error| StudyError::BadInput(error.to_string()))?;
        Ok(Rc::new(Self {
            scene: Arc::clone(scene),
            as_written: PreparedScene::new(scene, meshes, surface),
            leveled: OnceCell::new(),
        }))
    }

    /// The scene with coarser levels of its boundaries.
    pub(crate) fn leveled(&self) -> Result<&PreparedScene, StudyError> {
        if let Some(leveled) = self.leveled.get() {
            return Ok(leveled);
        }
        let scene = &*self.scene;
        let meshes = LeveledMeshes::build(scene, &scene.mesh)
            .map_err(|errors| mesh_error(scene, &errors))?;
        // Beforehand, so that no case is the one that makes what others find.
        LazyMesh::make_all(&meshes.meshes);
        let surface = Arc::clone(&self.as_written.surface);
        let leveled = PreparedScene::leveled(scene, meshes, surface);
        Ok(self.leveled.get_or_init(|| leveled))
    }
}

/// A scene whose surface can be drawn in each of its views.
fn ready(scene: &Arc<Scene>, wishes: &Wishes) -> Result<Rc<ReadyScene>, StudyError> {
    let ready = ReadyScene::new(scene, wishes.surfaces)?;
    let surface = &ready.as_written.surface;
    for view in &scene.views {
        let frame = surface.frame(&view.camera(&scene.body), wishes.size);
        frame.map_err(|error| {
            let (file, view) = (&scene.surface.file, &view.name);
            StudyError::BadInput(format!("{file}: view {view}: {error}"))
        })?;
    }
    Ok(ready)
}

/// Ablations and matrices exist of scenes of the run only. Those skipped for want of data are among
/// them: on another machine the same command measures them.
fn check_wishes(
    wishes: &Wishes,
    groups: &[ViewGroup],
    skipped: &[Skipped],
) -> Result<(), StudyError> {
    let measured = groups.iter().map(|group| group.scene.name.as_str());
    let left_out = skipped.iter().map(|skipped| skipped.what.as_str());
    let allowed = distinct(measured.chain(left_out).chain([NO_SCENE]));
    for option in ["ablation", "matrix"] {
        let scenes = wishes.request.settings.get(option);
        let mut wanted = scenes.into_iter().flatten();
        let is_unknown = |wanted: &&String| match option {
            "ablation" => !allowed.contains(&ablation_part(wanted).0),
            _ => !allowed.contains(&wanted.as_str()),
        };
        if let Some(found) = wanted.find(is_unknown) {
            let scene = match option {
                "ablation" => ablation_part(found).0,
                _ => found,
            };
            let allowed = choices(scene, allowed.iter().copied());
            let message = format!("--{option}: found {found:?}, allowed: {allowed}");
            return Err(StudyError::BadInput(message));
        }
    }
    let ablations = wishes
        .techniques
        .iter()
        .flat_map(|t| t.ablation(Overlap::Disjoint));
    let steps = distinct(ablations.map(|step| step.name));
    let mut wanted = wishes.ablations();
    let unknown =
        wanted.find_map(|(scene, step)| Some((scene, step.filter(|s| !steps.contains(s))?)));
    if let Some((scene, step)) = unknown {
        let allowed = choices(step, steps);
        return Err(StudyError::BadInput(format!(
            "--ablation: found step {step:?} of {scene}, allowed: {allowed}"
        )));
    }
    Ok(())
}

/// Meshes of every region, or the first errors.
pub(crate) fn build_meshes(scene: &Scene, options: &MeshOptions) -> Result<RegionSet, StudyError> {
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, options);
    match meshes {
        Ok(meshes) => Ok(meshes.into()),
        Err(errors) => Err(mesh_error(scene, &errors)),
    }
}

/// One line per region that cannot be meshed.
fn mesh_error(scene: &Scene, errors: &[MeshError]) -> StudyError {
    let lines = errors
        .iter()
        .map(|error| format!("{}: {error}", scene.name));
    StudyError::BadInput(lines.collect::<Vec<_>>().join("\n"))
}
