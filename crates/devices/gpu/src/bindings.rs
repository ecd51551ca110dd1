// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bind groups: of buffers, numbered in the order in which they are given, and of one texture that
//! fragments read.

use crate::Gpu;

impl Gpu {
    /// A layout of buffers.
    #[must_use]
    pub fn buffer_layout(
        &self,
        label: &str,
        visibility: wgpu::ShaderStages,
        types: &[wgpu::BufferBindingType],
    ) -> wgpu::BindGroupLayout {
        let whole = |&ty: &_| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let types: Vec<_> = types.iter().map(whole).collect();
        self.layout(label, visibility, &types)
    }

    /// Whole buffers in a layout of [`Gpu::buffer_layout`].
    #[must_use]
    pub fn bind_buffers(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        buffers: &[&wgpu::Buffer],
    ) -> wgpu::BindGroup {
        let buffers = buffers.iter().map(|buffer| buffer.as_entire_binding());
        self.bind(label, layout, buffers)
    }

    /// Resources in a layout, numbered in this order.
    #[must_use]
    pub fn bind<'a>(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
    ) -> wgpu::BindGroup {
        let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
        let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout,
            entries: &entries,
        })
    }

    /// A layout of one texture, read by fragments.
    #[must_use]
    pub fn texture_layout(
        &self,
        label: &str,
        sample_type: wgpu::TextureSampleType,
    ) -> wgpu::BindGroupLayout {
        let texture = wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        self.fragment_layout(label, &[texture])
    }

    /// A layout of what fragments read, numbered in this order.
    #[must_use]
    pub fn fragment_layout(
        &self,
        label: &str,
        types: &[wgpu::BindingType],
    ) -> wgpu::BindGroupLayout {
        self.layout(label, wgpu::ShaderStages::FRAGMENT, types)
    }

    fn layout(
        &self,
        label: &str,
        visibility: wgpu::ShaderStages,
        types: &[wgpu::BindingType],
    ) -> wgpu::BindGroupLayout {
        self.mixed_layout(label, types.iter().map(|ty| (visibility, *ty)))
    }

    /// A layout of what each of these stages reads, numbered in this order.
    #[must_use]
    pub fn mixed_layout(
        &self,
        label: &str,
        types: impl IntoIterator<Item = (wgpu::ShaderStages, wgpu::BindingType)>,
    ) -> wgpu::BindGroupLayout {
        let entry = |(binding, (visibility, ty))| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty,
            count: None,
        };
        let entries: Vec<_> = (0..).zip(types).map(entry).collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        };
        self.device.create_bind_group_layout(&descriptor)
    }

    /// A texture in a layout of [`Gpu::texture_layout`].
    #[must_use]
    pub fn bind_texture(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        view: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        self.bind(label, layout, [wgpu::BindingResource::TextureView(view)])
    }

    /// A pipeline layout without immediates.
    #[must_use]
    pub fn pipeline_layout(
        &self,
        label: &str,
        groups: &[Option<&wgpu::BindGroupLayout>],
    ) -> wgpu::PipelineLayout {
        let descriptor = wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: groups,
            immediate_size: 0,
        };
        self.device.create_pipeline_layout(&descriptor)
    }
}
