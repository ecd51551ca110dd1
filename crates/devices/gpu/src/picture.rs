// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures that fragment shaders sample, with all their levels.

use crate::Gpu;
use terrafill_contract::{AddressMode, DeviceError};
use terrafill_scene::{MipChain, MipLevel};

/// A picture with all its levels on the device.
///
/// # Errors
/// [`DeviceError::OverCapacity`] when the device has no textures that large.
pub(crate) fn upload_picture(gpu: &Gpu, image: &MipChain) -> Result<wgpu::Texture, DeviceError> {
    let allowed = gpu.device.limits().max_texture_dimension_2d;
    let [width, height] = image.size_px();
    let what = "texels along a side of the picture";
    DeviceError::check_capacity(what, width.max(height), allowed)?;
    let levels = image.levels();
    let extent = |level: &MipLevel| wgpu::Extent3d {
        width: level.width,
        height: level.height,
        depth_or_array_layers: 1,
    };
    let count = u32::try_from(levels.len()).unwrap_or(1);
    // The sampler filters in linear light, as the levels were made.
    let format = wgpu::TextureFormat::Rgba8UnormSrgb;
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let texture = gpu.texture("picture", [width, height, 1], count, format, usage);
    gpu.work.count_texture(bytes_of(&texture));
    for (mip_level, level) in (0..).zip(levels) {
        gpu.work.count_upload(level.rgba.len() as u64);
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            &level.rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * level.width),
                rows_per_image: None,
            },
            extent(level),
        );
    }
    Ok(texture)
}

/// Of all levels.
pub(crate) fn bytes_of(texture: &wgpu::Texture) -> u64 {
    let level = |i: u32| {
        let side = |size: u32| u64::from((size >> i).max(1));
        4 * side(texture.width()) * side(texture.height())
    };
    (0..texture.mip_level_count()).map(level).sum()
}

/// Of a group that holds a picture at binding 0 and its sampler at 1.
pub(crate) fn picture_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let image = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    gpu.fragment_layout("picture", &[image, sampler])
}

/// A picture, linear in and between its levels.
///
/// - `layout`: [`picture_layout`]
/// - `address`: along u and along v
pub(crate) fn bind_picture(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    image: &wgpu::Texture,
    address: [AddressMode; 2],
) -> wgpu::BindGroup {
    let [address_mode_u, address_mode_v] = address.map(sampled);
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("trilinear"),
        address_mode_u,
        address_mode_v,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    });
    let view = image.create_view(&Default::default());
    let resources = [
        wgpu::BindingResource::TextureView(&view),
        wgpu::BindingResource::Sampler(&sampler),
    ];
    gpu.bind("picture", layout, resources)
}

fn sampled(mode: AddressMode) -> wgpu::AddressMode {
    match mode {
        AddressMode::Repeat => wgpu::AddressMode::Repeat,
        AddressMode::ClampToEdge | AddressMode::Transparent => wgpu::AddressMode::ClampToEdge,
    }
}
