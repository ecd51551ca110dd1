// SPDX-License-Identifier: MIT OR Apache-2.0
//! The WGSL sources: embedded, composed by `#import`, validated and reflected by naga; and SPIR-V of
//! them and of the geometry shaders for backends on Vulkan itself.
//!
//! Struct layouts that Rust mirrors are read back from the compiled shader with [`struct_layout`],
//! so that a test can hold them against `offset_of!`.

mod invariance;
mod spirv;
mod textured;
mod wgsl;

pub use spirv::{
    CompiledShader, GeometryShader, GlslStage, HandsOn, SpirvStage, compiled_shaders,
    compiled_spirv, composed_to_spirv, geometry_shaders, geometry_spirv, glsl_paths, wgsl_to_spirv,
};
pub use textured::{RouteText, TEXTURED_COVER, TexturedParts, TexturedPlacement};
pub use wgsl::{
    ShaderError, ShaderSource, StructLayout, check_all, compose, modules, shared_text,
    struct_layout, validate, with_footprints,
};

use wgsl::{MODULES, SHARED};

/// Every embedded file, shared ones included: what lies in `shaders/` must be these.
pub fn embedded_paths() -> impl Iterator<Item = &'static str> {
    every_source().map(|source| source.path)
}

fn every_source() -> impl Iterator<Item = &'static ShaderSource> {
    MODULES.iter().chain(SHARED).chain(&textured::PARTS)
}

/// FNV-1a over every embedded file's path and text or SPIR-V: changes when any shader does.
#[must_use]
pub fn source_hash() -> u64 {
    let bytes = every_source()
        .flat_map(|source| source.path.bytes().chain(source.text.bytes()))
        .chain(spirv::geometry_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_embedded_is_what_lies_in_the_folder() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shaders");
        let mut found = Vec::new();
        let mut folders = vec![root.clone()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("readable") {
                let path = entry.expect("readable").path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|extension| {
                    [
                        "wgsl", "glsl", "geom", "tesc", "tese", "task", "mesh", "vert", "frag",
                    ]
                    .iter()
                    .any(|e| extension == *e)
                }) {
                    let relative = path.strip_prefix(&root).expect("below the root");
                    found.push(relative.to_string_lossy().into_owned());
                }
            }
        }
        found.sort();
        let mut embedded: Vec<_> = embedded_paths()
            .chain(glsl_paths())
            .map(str::to_owned)
            .collect();
        embedded.sort();
        assert_eq!(found, embedded);
        let table = std::fs::read_to_string(root.join("README.md")).expect("readable");
        for path in &found {
            assert!(
                table.contains(&format!("| {path} |")),
                "{path} is not in README.md"
            );
        }
    }
}
