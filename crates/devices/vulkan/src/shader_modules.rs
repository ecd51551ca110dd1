// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shader modules, compiled once a device.

use crate::failure::failure;
use ash::prelude::VkResult;
use ash::vk;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use terrafill_contract::DeviceError;
use terrafill_shaders::{
    HandsOn, ShaderError, SpirvStage, compiled_spirv, compose, composed_to_spirv, geometry_spirv,
    wgsl_to_spirv, with_footprints,
};

/// A vertex shader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct VertexStage {
    /// WGSL module, relative to `shaders/`.
    pub path: &'static str,
    /// Its entry point.
    pub entry_point: &'static str,
    /// [`terrafill_shaders::with_footprints`].
    pub bends_footprints: bool,
}

impl VertexStage {
    fn spirv(&self) -> Result<Vec<u32>, ShaderError> {
        let source = compose(self.path)?;
        let source = if self.bends_footprints {
            with_footprints(&source)
        } else {
            source
        };
        let (stage, name) = (SpirvStage::Vertex, self.entry_point);
        composed_to_spirv(self.path, &source, stage, name, &[])
    }
}

/// What a shader module was made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ModuleKey {
    Vertex(VertexStage),
    Geometry(&'static str, HandsOn),
    /// Path and entry point of a WGSL module.
    Wgsl(SpirvStage, &'static str, &'static str),
    /// Name of SPIR-V that was compiled beforehand.
    Compiled(&'static str),
}

/// # Safety
/// The SPIR-V is valid.
pub(crate) unsafe fn new_module(device: &ash::Device, spirv: &[u32]) -> VkResult<vk::ShaderModule> {
    let info = vk::ShaderModuleCreateInfo::default().code(spirv);
    // SAFETY: the caller's promise.
    unsafe { device.create_shader_module(&info, None) }
}

/// Shader modules, made once.
#[derive(Debug, Default)]
pub(crate) struct ShaderModules(Mutex<HashMap<ModuleKey, vk::ShaderModule>>);

impl ShaderModules {
    pub(crate) fn get(
        &self,
        device: &ash::Device,
        key: ModuleKey,
    ) -> Result<vk::ShaderModule, DeviceError> {
        let mut modules = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(module) = modules.get(&key) {
            return Ok(*module);
        }
        let (path, spirv) = match key {
            ModuleKey::Vertex(stage) => (stage.path, stage.spirv()),
            ModuleKey::Geometry(path, hands_on) => (path, geometry_spirv(path, hands_on)),
            ModuleKey::Wgsl(stage, path, entry_point) => {
                (path, wgsl_to_spirv(path, stage, entry_point, &[]))
            }
            ModuleKey::Compiled(name) => (name, compiled_spirv(name)),
        };
        let spirv = spirv.map_err(|error| DeviceError::Shader {
            name: path.to_owned(),
            message: error.to_string(),
        })?;
        // SAFETY: naga validated the source, or spirv-val what was compiled before.
        let module = unsafe { new_module(device, &spirv) }
            .map_err(|error| failure(error, path, size_of_val(&*spirv) as u64))?;
        modules.insert(key, module);
        Ok(module)
    }

    pub(crate) fn destroy(&mut self, device: &ash::Device) {
        let modules = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        #[allow(
            clippy::iter_over_hash_type,
            reason = "the order in which they go changes nothing"
        )]
        for (_, module) in modules.drain() {
            // SAFETY: pipelines keep what they need of a module.
            unsafe { device.destroy_shader_module(module, None) };
        }
    }
}
