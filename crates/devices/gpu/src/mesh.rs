// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipelines of mesh shaders, which wgpu has as an experiment, where the device offers them.
//!
//! Their SPIR-V is our own and passed through unchanged: wgpu 30 says that lavapipe does not run naga's.

use crate::Gpu;
use crate::adapter::MESH_SHADERS;
use crate::attachments::COLOUR_FORMAT;
use crate::render_pipeline::nearest;
use std::borrow::Cow;
use terrafill_contract::DeviceError;

impl Gpu {
    /// Makes a pipeline whose mesh shader draws into [`RenderTargets`](crate::RenderTargets), nearest depth first.
    ///
    /// - `mesh`, `fragment`: SPIR-V relative to `shaders/`, both with the entry point `main`
    /// - `layout`: of group 0
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`], or [`DeviceError::Shader`] for SPIR-V that is not there.
    pub fn mesh_pipeline(
        &self,
        [mesh, fragment]: [&str; 2],
        layout: &wgpu::BindGroupLayout,
    ) -> Result<wgpu::RenderPipeline, DeviceError> {
        self.require(MESH_SHADERS, "mesh shaders")?;
        let [mesh_module, fragment_module] =
            [self.handed_through(mesh)?, self.handed_through(fragment)?];
        let layout = self.pipeline_layout(mesh, &[Some(layout)]);
        Ok(self.create_mesh_pipeline(&wgpu::MeshPipelineDescriptor {
            label: Some(mesh),
            layout: Some(&layout),
            task: None,
            mesh: wgpu::MeshState {
                module: &mesh_module,
                entry_point: Some("main"),
                compilation_options: Default::default(),
            },
            primitive: Default::default(),
            depth_stencil: Some(nearest()),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &fragment_module,
                entry_point: Some("main"),
                compilation_options: Default::default(),
                targets: &[Some(COLOUR_FORMAT.into())],
            }),
            multiview: None,
            cache: None,
        }))
    }

    /// A module of SPIR-V that wgpu does not look into.
    fn handed_through(&self, name: &str) -> Result<wgpu::ShaderModule, DeviceError> {
        let words =
            terrafill_shaders::compiled_spirv(name).map_err(|error| DeviceError::Shader {
                name: name.to_owned(),
                message: error.to_string(),
            })?;
        let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
            label: Some(name),
            entry_points: Cow::Owned(vec![wgpu::PassthroughShaderEntryPoint {
                name: Cow::Borrowed("main"),
                workgroup_size: (0, 0, 0),
            }]),
            spirv: Some(Cow::Owned(words)),
            ..Default::default()
        };
        #[allow(
            unsafe_code,
            reason = "wgpu does not check what is handed through to the driver"
        )]
        // SAFETY: the SPIR-V is ours, and the shader check of this repository validates every file of it.
        let module = unsafe { self.device.create_shader_module_passthrough(descriptor) };
        Ok(module)
    }
}
