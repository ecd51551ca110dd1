// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cap steps that shipped scenes sweep through give meshes that differ.

use terrafill_core::{MeshOptions, RegionMesh};
use terrafill_fixtures::data;
use terrafill_scene::{Scene, shipped_scene_names};

/// Triangles of all regions with this cap step.
fn triangles(scene: &Scene, cap_step_deg: f64) -> usize {
    let options = MeshOptions {
        cap_step_deg,
        ..scene.mesh
    };
    let meshes = RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &options);
    let meshes = meshes.expect("meshes");
    meshes.iter().map(RegionMesh::triangle_count).sum()
}

#[test]
fn every_cap_step_that_is_swept_gives_a_mesh_of_its_own() {
    assert_steps_are_coarser(false);
    // Negative control: beyond the widest of California's steps there is nothing left to cut.
    let california = Scene::shipped("california", None).expect("it ships");
    assert_eq!(triangles(&california, 3.0), triangles(&california, 10.0));
}

#[test]
#[ignore = "needs data: all scenes"]
fn every_cap_step_that_is_swept_over_data_gives_a_mesh_of_its_own() {
    assert_steps_are_coarser(true);
}

fn assert_steps_are_coarser(needs_data: bool) {
    let needs = |name: &&str| Scene::shipped(name, None).is_err() == needs_data;
    let mut swept = 0;
    for name in shipped_scene_names().into_iter().filter(needs) {
        let scene = data::scene(name);
        let steps = &scene.sweep_cap_step_deg;
        assert!(steps.is_sorted(), "{name}: {steps:?}");
        let counts: Vec<usize> = steps.iter().map(|&step| triangles(&scene, step)).collect();
        let is_coarser = counts.windows(2).all(|pair| pair[1] < pair[0]);
        assert!(
            is_coarser,
            "{name}: {steps:?} degrees give {counts:?} triangles"
        );
        swept += usize::from(!steps.is_empty());
    }
    assert!(swept > 0);
}
