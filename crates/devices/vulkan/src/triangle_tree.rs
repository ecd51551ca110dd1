// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles in a tree of boxes that the driver builds: shaders ask it what a ray meets
//! (`VK_KHR_acceleration_structure`, `VK_KHR_ray_query`).
//!
//! There are two trees. The lower holds the triangles. The upper holds one instance of the lower, and is what
//! shaders are handed. No triangle is opaque: a shader sees each as a candidate and confirms it or not.

use crate::failure::failure;
use crate::memory::barrier;
use crate::queries::{Queries, QueryKind, Span};
use crate::{Buffer, Gpu};
use ash::vk;
use std::sync::Arc;
use terrafill_contract::DeviceError;

/// Triangles that rays may meet.
#[derive(Debug)]
pub struct TriangleTree {
    top: Level,
    /// The top points at it.
    _bottom: Level,
    bytes: u64,
    build_ms: Option<f64>,
}

/// A tree and the memory that it lies in.
#[derive(Debug)]
struct Level {
    gpu: Arc<Gpu>,
    raw: vk::AccelerationStructureKHR,
    buffer: Buffer,
    /// Until it is built.
    scratch: Option<Buffer>,
}

/// Bytes of an instance.
const INSTANCE_BYTES: usize = 64;
/// Words of it: three rows of the identity, which mask and number it has, flags.
const INSTANCE: [u32; 14] = {
    let one = 1.0_f32.to_bits();
    [one, 0, 0, 0, 0, one, 0, 0, 0, 0, one, 0, 0xff00_0000, 0]
};

impl TriangleTree {
    /// Builds a tree.
    ///
    /// - `places`: x, y, z
    /// - `triangles`: indices of these; a shader is told a triangle's place in this list
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] without rays in shaders, [`DeviceError::Missing`] without triangles,
    /// [`DeviceError::OverCapacity`] for an index that names no place, [`DeviceError::OutOfMemory`].
    pub fn new(
        gpu: &Arc<Gpu>,
        places: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Self, DeviceError> {
        gpu.require(gpu.trees.is_some(), "rays in shaders (VK_KHR_ray_query)")?;
        let corners = triangles.as_flattened();
        let last = corners.iter().copied().max();
        let last = last.ok_or(DeviceError::Missing("triangles for rays"))?;
        let what = "index of a place of a triangle for rays";
        let largest = (places.len() as u64).checked_sub(1);
        let largest = largest.ok_or(DeviceError::Missing("places for rays"))?;
        DeviceError::check_capacity(what, last, largest)?;
        let read = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
        let hand_over = |label, bytes: &[u8]| {
            gpu.work.count_upload(bytes.len() as u64);
            Buffer::addressed(gpu, label, bytes.len() as u64, read, Some(bytes))
        };
        let vertices = hand_over("places for rays", bytemuck::cast_slice(places))?;
        let indices = hand_over("triangles for rays", bytemuck::cast_slice(corners))?;
        let data = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(at(&vertices))
            .vertex_stride(size_of::<[f32; 3]>() as u64)
            .max_vertex(last)
            .index_type(vk::IndexType::UINT32)
            .index_data(at(&indices));
        let triangle_geometry = [vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles: data })];
        let count = u32::try_from(triangles.len()).unwrap_or(u32::MAX);
        let kind = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
        let mut bottom = Level::new(gpu, kind, &triangle_geometry, count)?;
        let mut instance: Vec<u8> = bytemuck::cast_slice(&INSTANCE).to_vec();
        instance.extend(bottom.address()?.to_ne_bytes());
        debug_assert_eq!(instance.len(), INSTANCE_BYTES);
        let instances = hand_over("instance for rays", &instance)?;
        let data =
            vk::AccelerationStructureGeometryInstancesDataKHR::default().data(at(&instances));
        let instance_geometry = [vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data })];
        let kind = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
        let mut top = Level::new(gpu, kind, &instance_geometry, 1)?;
        let levels = [
            (&bottom, &triangle_geometry[..], count),
            (&top, &instance_geometry[..], 1),
        ];
        // Both read what lies in the buffers above, which live until the build is done.
        let build_ms = build(gpu, &levels)?;
        (bottom.scratch, top.scratch) = (None, None);
        Ok(Self {
            bytes: bottom.buffer.size() + top.buffer.size(),
            build_ms,
            top,
            _bottom: bottom,
        })
    }

    /// Bytes of both trees.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// GPU time of the build, milliseconds; absent where the device keeps no time.
    #[must_use]
    pub fn build_ms(&self) -> Option<f64> {
        self.build_ms
    }

    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.top.gpu, gpu)
    }

    pub(crate) fn raw(&self) -> vk::AccelerationStructureKHR {
        self.top.raw
    }
}

fn at(buffer: &Buffer) -> vk::DeviceOrHostAddressConstKHR {
    vk::DeviceOrHostAddressConstKHR {
        device_address: buffer.address(),
    }
}

fn info<'a>(
    kind: vk::AccelerationStructureTypeKHR,
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'a>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(kind)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}

fn functions(gpu: &Gpu) -> Result<&ash::khr::acceleration_structure::Device, DeviceError> {
    let missing = DeviceError::Missing("functions of trees of triangles");
    gpu.trees.as_ref().ok_or(missing)
}

impl Level {
    /// Room for a tree, not built yet.
    ///
    /// - `count`: primitives
    fn new(
        gpu: &Arc<Gpu>,
        kind: vk::AccelerationStructureTypeKHR,
        geometries: &[vk::AccelerationStructureGeometryKHR<'_>],
        count: u32,
    ) -> Result<Self, DeviceError> {
        let functions = functions(gpu)?;
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        // SAFETY: one geometry and one count; the structures live through the call.
        unsafe {
            functions.get_acceleration_structure_build_sizes(
                vk::AccelerationStructureBuildTypeKHR::DEVICE,
                &info(kind, geometries),
                &[count],
                &mut sizes,
            );
        }
        let bytes = sizes.acceleration_structure_size;
        let stored = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        let buffer = Buffer::addressed(gpu, "tree of triangles", bytes, stored, None)?;
        // Room to begin where the device wants.
        let room = sizes.build_scratch_size + gpu.scratch_alignment;
        let worked_in = vk::BufferUsageFlags::STORAGE_BUFFER;
        let scratch = Buffer::addressed(gpu, "scratch of a tree", room, worked_in, None)?;
        let create = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(buffer.raw)
            .size(bytes)
            .ty(kind);
        // SAFETY: the buffer has that size and was made for it.
        let raw = unsafe { functions.create_acceleration_structure(&create, None) }
            .map_err(|error| failure(error, "tree of triangles", bytes))?;
        Ok(Self {
            gpu: Arc::clone(gpu),
            raw,
            buffer,
            scratch: Some(scratch),
        })
    }

    fn address(&self) -> Result<vk::DeviceAddress, DeviceError> {
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default()
            .acceleration_structure(self.raw);
        // SAFETY: the tree is the device's.
        Ok(unsafe { functions(&self.gpu)?.get_acceleration_structure_device_address(&info) })
    }
}

impl Drop for Level {
    fn drop(&mut self) {
        if let Ok(functions) = functions(&self.gpu) {
            // SAFETY: every submission that used it has been waited for; its memory goes after it.
            unsafe { functions.destroy_acceleration_structure(self.raw, None) };
        }
    }
}

/// Builds trees one after the other, each of which may point at those before, waits, and gives the time.
fn build(
    gpu: &Arc<Gpu>,
    levels: &[(&Level, &[vk::AccelerationStructureGeometryKHR<'_>], u32)],
) -> Result<Option<f64>, DeviceError> {
    let functions = functions(gpu)?;
    let stamps = Queries::new(gpu, QueryKind::Timestamps, 2)?;
    let span = Span::new(stamps.as_ref(), 0);
    let kinds = [
        vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL,
        vk::AccelerationStructureTypeKHR::TOP_LEVEL,
    ];
    let built = vk::PipelineStageFlags::ACCELERATION_STRUCTURE_BUILD_KHR;
    let written = (built, vk::AccessFlags::ACCELERATION_STRUCTURE_WRITE_KHR);
    let read = (
        built | vk::PipelineStageFlags::COMPUTE_SHADER,
        vk::AccessFlags::ACCELERATION_STRUCTURE_READ_KHR,
    );
    // SAFETY: trees, scratch memory and what is read are of this device, large enough, and live until the
    // submission is done; scratch begins where the device wants it to.
    unsafe {
        gpu.submit(|device, commands| {
            span.begin(commands);
            for ((level, geometries, count), kind) in levels.iter().zip(kinds) {
                let scratch = level.scratch.as_ref().map_or(0, Buffer::address);
                let scratch = scratch.next_multiple_of(gpu.scratch_alignment);
                let own = info(kind, geometries)
                    .dst_acceleration_structure(level.raw)
                    .scratch_data(vk::DeviceOrHostAddressKHR {
                        device_address: scratch,
                    });
                let range =
                    vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(*count);
                functions.cmd_build_acceleration_structures(commands, &[own], &[&[range]]);
                barrier(device, commands, written, read);
            }
            span.end(commands);
        })?;
    }
    span.ms()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GpuOptions, open_for_test};

    #[test]
    fn what_names_no_place_or_nothing_is_refused() {
        let Some(gpu) = open_for_test(&GpuOptions::default()) else {
            return;
        };
        let places = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let made = |triangles: &[[u32; 3]]| TriangleTree::new(&gpu, &places, triangles);
        if !gpu.facts.features.ray_query {
            let refused = made(&[[0, 1, 2]]);
            assert!(matches!(refused, Err(DeviceError::Unsupported { .. })));
            return;
        }
        assert!(made(&[[0, 1, 2]]).expect("a triangle").bytes() > 0);
        assert!(matches!(made(&[]), Err(DeviceError::Missing(_))));
        let past = made(&[[0, 1, 3]]).expect_err("no such place");
        assert_eq!(
            past.to_string(),
            "index of a place of a triangle for rays: found 3, allowed 2"
        );
    }
}
