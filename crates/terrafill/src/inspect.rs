// SPDX-License-Identifier: MIT OR Apache-2.0
//! `scenes` and `devices`: what there is.

use crate::arguments::ScenesArguments;
use crate::{Failure, Outcome, print};
use terrafill_gpu::list_adapters;
use terrafill_scene::{Scene, data_dir_from_env, shipped_scene_names};

pub(crate) fn scenes(arguments: &ScenesArguments) -> Result<Outcome, Failure> {
    let data = arguments.data.clone().or_else(data_dir_from_env);
    let mut text = String::new();
    for name in shipped_scene_names() {
        match Scene::shipped(name, data.as_deref()) {
            Ok(scene) => {
                let views: Vec<&str> = scene.views.iter().map(|view| view.name.as_str()).collect();
                let vertices: usize = scene.regions.iter().map(|r| r.vertex_count()).sum();
                text += &format!(
                    "{name}\n    {}\n    {} · {} edges · {} regions, {vertices} vertices · views {}\n",
                    scene.description,
                    scene.body.name(),
                    scene.edge_rule.name(),
                    scene.regions.len(),
                    views.join(", ")
                );
            }
            Err(error) => text += &format!("{name}\n    not available: {error}\n"),
        }
    }
    print(&text);
    Ok(Outcome::Done)
}

pub(crate) fn devices() -> Result<Outcome, Failure> {
    let adapters = list_adapters();
    if adapters.is_empty() {
        return Err(Failure::no_device(
            "no Vulkan device; ci/setup.sh installs a software one",
        ));
    }
    let yes_no = |yes| if yes { "yes" } else { "no" };
    let mut text = String::new();
    for device in &adapters {
        text += &format!(
            "{} ({})\n    driver {} {}\n    GPU timestamps {}, pipeline statistics {}\n",
            device.name,
            device.device_type,
            device.driver,
            device.driver_info,
            yes_no(device.timestamps),
            yes_no(device.pipeline_statistics)
        );
        let verdict = if device.lacks.is_empty() {
            "can run: vertex, reference".to_owned()
        } else {
            format!(
                "can run: reference; vertex needs {}",
                device.lacks.join(", ")
            )
        };
        text += &format!("    {verdict}\n");
    }
    print(&text);
    Ok(if adapters.iter().any(|device| device.lacks.is_empty()) {
        Outcome::Done
    } else {
        Outcome::NoDevice
    })
}
