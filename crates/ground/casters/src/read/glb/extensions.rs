// SPDX-License-Identifier: MIT OR Apache-2.0
//! Extensions of glTF: read, without effect on geometry, or refused by name.

use crate::read::model::{Wrong, wrong};
use gltf::json::Root;

const QUANTIZATION: &str = "KHR_mesh_quantization";
/// Beginnings of names of extensions that say nothing of where triangles are: materials, textures, lights, notes.
const NO_GEOMETRY: [&str; 18] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_xmp",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_techniques_webgl",
    "EXT_texture_",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_instance_features",
    "ADOBE_materials_",
    "FB_materials_",
    "MSFT_texture_",
    "MSFT_packing_",
    "CESIUM_primitive_outline",
];
/// Extensions without which triangles are missing even where a file does not require them.
const MORE_TRIANGLES: [&str; 1] = ["EXT_mesh_gpu_instancing"];
/// Extensions behind which a file may have plain triangles as well.
const WITH_FALLBACK: [&str; 4] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "MSFT_lod",
];

/// - returns: whether places may be whole numbers
pub(super) fn check(json: &Root, warnings: &mut Vec<String>) -> Result<bool, Wrong> {
    let is_without_geometry = |name: &str| {
        NO_GEOMETRY
            .iter()
            .any(|beginning| name.starts_with(beginning))
    };
    for (at, name) in json.extensions_required.iter().enumerate() {
        let element = || format!("extensionsRequired[{at}]");
        match name.as_str() {
            QUANTIZATION => {}
            name if is_without_geometry(name) => warnings.push(format!(
                "{}: {name} says nothing of where triangles are, and is not read",
                element()
            )),
            name => return Err(refused(element(), name)),
        }
    }
    for (at, name) in json.extensions_used.iter().enumerate() {
        let name = name.as_str();
        let element = || format!("extensionsUsed[{at}]");
        if MORE_TRIANGLES.contains(&name) {
            return Err(refused(element(), name));
        }
        let is_known = name == QUANTIZATION
            || is_without_geometry(name)
            || WITH_FALLBACK.contains(&name)
            || json.extensions_required.iter().any(|other| other == name);
        if !is_known {
            warnings.push(format!(
                "{}: {name} is not known, and what it says is not read",
                element()
            ));
        }
    }
    let mut all = json.extensions_used.iter().chain(&json.extensions_required);
    Ok(all.any(|name| name == QUANTIZATION))
}

fn refused(element: String, name: &str) -> Wrong {
    let allowed = match name {
        "KHR_draco_mesh_compression" => {
            "plain triangles: `gltf-pipeline -i IN.glb -o OUT.glb` unpacks them"
        }
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "plain triangles: `gltfpack -noq -i IN.glb -o OUT.glb` unpacks them"
        }
        "EXT_mesh_gpu_instancing" => {
            "a node for each copy: `gltf-transform uninstance IN.glb OUT.glb`"
        }
        _ => {
            "KHR_mesh_quantization, or extensions of materials, textures and lights; export without it"
        }
    };
    wrong(element, name, allowed)
}
