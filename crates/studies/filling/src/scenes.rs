// SPDX-License-Identifier: MIT OR Apache-2.0
//! From names to scenes that can be measured.

use crate::textured::left_out_of_quick_runs;
use crate::{BenchError, BenchOptions, NO_SCENE, SceneGroup, group_cases};
use std::path::Path;
use std::sync::Arc;
use terrafill_core::{MeshError, MeshOptions, RegionMesh};
use terrafill_fill::RegionSet;
use terrafill_scene::{Scene, SceneError, shipped_scene_names};
use terrafill_surface::open_surface;

pub(crate) type SkippedScenes = Vec<(String, String)>;

/// Scenes with missing data are skipped with that reason; wrong ones, and those whose regions cannot
/// be meshed, stop the run before it starts; all of them are named.
pub(crate) fn plan_groups(
    options: &BenchOptions,
) -> Result<(Vec<SceneGroup>, SkippedScenes), BenchError> {
    let names: Vec<String> = if options.scenes.is_empty() {
        shipped_scene_names()
            .into_iter()
            .map(str::to_owned)
            .collect()
    } else {
        options.scenes.clone()
    };
    let mut groups: Vec<SceneGroup> = Vec::new();
    let mut skipped = Vec::new();
    let mut errors = Vec::new();
    let is_quick_run = options.quick && options.scenes.is_empty();
    for name in &names {
        if let Some(why) = left_out_of_quick_runs(name).filter(|_| is_quick_run) {
            skipped.push((name.clone(), why));
            continue;
        }
        match checked_scene(name, options, &groups) {
            Ok(scene) => {
                let scene = Arc::new(scene);
                for view in &scene.views {
                    groups.push(group_cases(&scene, view, options));
                }
            }
            Err(BenchError::Scene(error @ SceneError::DataMissing { .. })) => {
                skipped.push((name.clone(), error.to_string()));
            }
            Err(error) => errors.push(error),
        }
    }
    match errors.len() {
        0 => {}
        1 => return Err(errors.remove(0)),
        _ => return Err(BenchError::Several(errors)),
    }
    check_asked_for(options, &groups, &skipped)?;
    if let Some(shard) = options.shard {
        let mut index = 0;
        groups.retain(|_| {
            index += 1;
            (index - 1) % shard.count == shard.index - 1
        });
    }
    Ok((groups, skipped))
}

/// Ladders and matrices can be had of scenes of the run only. Those skipped for want of data are
/// among them: on another machine the same command measures them.
fn check_asked_for(
    options: &BenchOptions,
    groups: &[SceneGroup],
    skipped: &SkippedScenes,
) -> Result<(), BenchError> {
    let mut allowed: Vec<&str> = Vec::new();
    let measured = groups.iter().map(|group| group.scene.name.as_str());
    let left_out = skipped.iter().map(|(name, _)| name.as_str());
    for name in measured.chain(left_out).chain([NO_SCENE]) {
        if !allowed.contains(&name) {
            allowed.push(name);
        }
    }
    for (option, scenes) in [("--ladder", &options.ladder), ("--matrix", &options.matrix)] {
        let mut asked = scenes.iter().flatten();
        if let Some(found) = asked.find(|name| !allowed.contains(&name.as_str())) {
            return Err(BenchError::NotInRun {
                option,
                found: found.clone(),
                allowed: allowed.join(", "),
            });
        }
    }
    Ok(())
}

/// A scene that can be measured beside those of `groups`.
fn checked_scene(
    name: &str,
    options: &BenchOptions,
    groups: &[SceneGroup],
) -> Result<Scene, BenchError> {
    let scene = open_scene(name, options.data_dir.as_deref())?;
    build_meshes(&scene, &scene.mesh)?;
    let surface = open_surface(options.surfaces, &scene)?;
    for view in &scene.views {
        let frame = surface.frame(&view.camera(&scene.body), options.size);
        frame.map_err(|source| BenchError::View {
            place: format!("{}: view {}", scene.surface.file, view.name),
            source: Box::new(source),
        })?;
    }
    if groups.iter().any(|group| group.scene.name == scene.name) {
        return Err(BenchError::SceneTwice { name: scene.name });
    }
    Ok(scene)
}

/// A scene by the name of a shipped one, or by the path of a scene file (with `/` or `.toml` in it).
///
/// # Errors
/// [`SceneError`].
pub fn open_scene(name: &str, data_dir: Option<&Path>) -> Result<Scene, SceneError> {
    if name.contains('/') || name.ends_with(".toml") {
        Scene::load(Path::new(name), data_dir)
    } else {
        Scene::shipped(name, data_dir)
    }
}

/// Meshes of every region, or the first errors.
pub(crate) fn build_meshes(scene: &Scene, options: &MeshOptions) -> Result<RegionSet, BenchError> {
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, options);
    match meshes {
        Ok(meshes) => Ok(meshes.into()),
        Err(errors) => Err(mesh_error(scene, &errors)),
    }
}

/// One line per region that cannot be meshed.
pub(crate) fn mesh_error(scene: &Scene, errors: &[MeshError]) -> BenchError {
    let lines = errors
        .iter()
        .map(|error| format!("{}: {error}", scene.name));
    BenchError::Mesh {
        lines: lines.collect::<Vec<_>>().join("\n"),
    }
}
