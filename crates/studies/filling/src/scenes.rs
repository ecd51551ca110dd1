// SPDX-License-Identifier: MIT OR Apache-2.0
//! From names to scenes that can be measured.

use crate::cases::{ViewGroup, view_group};
use crate::request::{NO_SCENE, Wishes, ladder_part};
use crate::textured::left_out;
use std::sync::Arc;
use terrafill_core::{MeshError, MeshOptions, RegionMesh};
use terrafill_plan::RegionSet;
use terrafill_results::Skipped;
use terrafill_scene::{Overlap, Scene, SceneError, shipped_scene_names};
use terrafill_study::StudyError;
use terrafill_surface::open_surface;

/// Scenes with missing data are skipped with that reason; wrong ones, and those whose regions cannot
/// be meshed, stop the run before it starts; all of them are named.
pub(crate) fn plan_scenes(wishes: &Wishes) -> Result<(Vec<ViewGroup>, Vec<Skipped>), StudyError> {
    let names: Vec<String> = if wishes.scenes.is_empty() {
        let shipped = shipped_scene_names().into_iter();
        shipped.map(str::to_owned).collect()
    } else {
        wishes.scenes.clone()
    };
    let mut groups: Vec<ViewGroup> = Vec::new();
    let mut skipped = Vec::new();
    let mut errors: Vec<String> = Vec::new();
    for name in &names {
        let is_left_out = !wishes.is_full() && wishes.scenes.is_empty();
        if let Some(reason) = left_out(name, wishes.depth).filter(|_| is_left_out) {
            skipped.push(Skipped {
                what: name.clone(),
                reason,
            });
            continue;
        }
        match Scene::open(name, wishes.data_dir.as_deref()) {
            Ok(scene) if groups.iter().any(|group| group.scene.name == scene.name) => {
                errors.push(format!(
                    "scene {:?} is given twice, allowed: once",
                    scene.name
                ));
            }
            Ok(scene) => {
                let scene = Arc::new(scene);
                match ready(&scene, wishes) {
                    Ok(meshes) => {
                        let views = scene.views.iter().enumerate();
                        groups.extend(views.map(|(index, view)| {
                            let is_last = index + 1 == scene.views.len();
                            view_group(&scene, view, is_last, &meshes, wishes)
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

/// Meshes of a scene whose surface can be drawn in each of its views.
fn ready(scene: &Scene, wishes: &Wishes) -> Result<RegionSet, StudyError> {
    let meshes = build_meshes(scene, &scene.mesh)?;
    let bad = |error: &dyn std::fmt::Display| StudyError::BadInput(error.to_string());
    let surface = open_surface(wishes.surfaces, scene).map_err(|error| bad(&error))?;
    for view in &scene.views {
        let frame = surface.frame(&view.camera(&scene.body), wishes.size);
        frame.map_err(|error| {
            let (file, view) = (&scene.surface.file, &view.name);
            StudyError::BadInput(format!("{file}: view {view}: {error}"))
        })?;
    }
    Ok(meshes)
}

/// Ladders and matrices exist of scenes of the run only. Those skipped for want of data are among
/// them: on another machine the same command measures them.
fn check_wishes(
    wishes: &Wishes,
    groups: &[ViewGroup],
    skipped: &[Skipped],
) -> Result<(), StudyError> {
    let mut allowed: Vec<&str> = Vec::new();
    let measured = groups.iter().map(|group| group.scene.name.as_str());
    let left_out = skipped.iter().map(|skipped| skipped.what.as_str());
    for name in measured.chain(left_out).chain([NO_SCENE]) {
        if !allowed.contains(&name) {
            allowed.push(name);
        }
    }
    for (option, scenes) in [("--ladder", &wishes.ladder), ("--matrix", &wishes.matrix)] {
        let mut wanted = scenes.iter().flatten();
        let scene_of = |wanted: &str| match option {
            "--ladder" => ladder_part(wanted).0.to_owned(),
            _ => wanted.to_owned(),
        };
        if let Some(found) = wanted.find(|name| !allowed.contains(&scene_of(name).as_str())) {
            return Err(StudyError::BadInput(format!(
                "{option}: found {found:?}, allowed: {}",
                allowed.join(", ")
            )));
        }
    }
    let ladders = wishes
        .techniques
        .iter()
        .flat_map(|t| t.ladder(Overlap::Disjoint));
    let mut steps: Vec<&str> = Vec::new();
    for rung in ladders {
        if !steps.contains(&rung.step) {
            steps.push(rung.step);
        }
    }
    let mut wanted = wishes
        .ladder
        .iter()
        .flatten()
        .map(|wanted| ladder_part(wanted));
    let unknown =
        wanted.find_map(|(scene, step)| Some((scene, step.filter(|s| !steps.contains(s))?)));
    if let Some((scene, step)) = unknown {
        return Err(StudyError::BadInput(format!(
            "--ladder: found step {step:?} of {scene}, allowed: {}",
            steps.join(", ")
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
pub(crate) fn mesh_error(scene: &Scene, errors: &[MeshError]) -> StudyError {
    let lines = errors
        .iter()
        .map(|error| format!("{}: {error}", scene.name));
    StudyError::BadInput(lines.collect::<Vec<_>>().join("\n"))
}
