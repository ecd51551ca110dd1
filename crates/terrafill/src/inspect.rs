// SPDX-License-Identifier: MIT OR Apache-2.0
//! `scenes` and `devices`: what there is.

use crate::arguments::ScenesArguments;
use crate::{Failure, Outcome, print};
use terrafill_gpu::{DeviceFacts, list_adapters};
use terrafill_scene::{Scene, SceneError, data_dir_from_env, shipped_scene_names};

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
            Err(SceneError::DataMissing {
                file,
                sha256,
                why,
                how,
                ..
            }) => {
                text += &format!(
                    "{name}\n    skipped: {why}\n    needs {file}\n    sha256 {sha256}\n    {how}\n"
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
    print("CPU\n    reference  runs; needs no device\n");
    for device in &adapters {
        print(&describe(device));
    }
    if adapters.is_empty() {
        return Err(Failure::no_device(
            "no Vulkan device, which vertex needs; ci/setup.sh installs a software one",
        ));
    }
    Ok(if adapters.iter().any(|device| device.lacks.is_empty()) {
        Outcome::Done
    } else {
        Outcome::NoDevice
    })
}

fn describe(device: &DeviceFacts) -> String {
    let vertex = if device.lacks.is_empty() {
        let without = [
            (device.timestamps, "GPU timestamps: GPU times stay empty"),
            (
                device.pipeline_statistics,
                "pipeline statistics: invocation counts stay empty",
            ),
        ];
        let lacking: String = without
            .iter()
            .filter(|(has, _)| !has)
            .map(|(_, what)| format!("; lacks {what}"))
            .collect();
        if lacking.is_empty() {
            "runs, with GPU timestamps and pipeline statistics".to_owned()
        } else {
            format!("runs{lacking}")
        }
    } else {
        format!("cannot run; lacks {}", device.lacks.join(", "))
    };
    format!(
        "{} ({})\n    driver     {} {}\n    vertex     {vertex}\n",
        device.name, device.device_type, device.driver, device.driver_info
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_device_lacks_is_said() {
        let mut device = DeviceFacts {
            name: "D".to_owned(),
            device_type: "cpu",
            vendor_id: 0,
            device_id: 0,
            driver: "d".to_owned(),
            driver_info: "1".to_owned(),
            timestamps: true,
            pipeline_statistics: true,
            lacks: Vec::new(),
        };
        assert!(!describe(&device).contains("lacks"));
        device.timestamps = false;
        assert!(describe(&device).contains("runs; lacks GPU timestamps"));
        device.lacks = vec!["Depth32FloatStencil8".to_owned(), "another".to_owned()];
        let text = describe(&device);
        assert!(
            text.contains("cannot run; lacks Depth32FloatStencil8, another"),
            "{text}"
        );
    }
}
