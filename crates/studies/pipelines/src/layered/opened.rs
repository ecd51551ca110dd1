// SPDX-License-Identifier: MIT OR Apache-2.0
//! Opening layers and their picture on an interface.

use super::listed::Listed;
use super::on_wgpu::{DrawnInto, OnWgpu};
use crate::draws::{LooksUp, count};
use crate::lights::{LayerParts, LightWay, OnVulkan};
use crate::on_vulkan::uniform;
use crate::way::Interface;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Devices};
use terrafill_vulkan::{Buffer, BufferUse, Resource};

impl Listed {
    /// Everything that one interface and way need.
    pub(crate) fn open(
        &self,
        devices: &Devices,
        interface: Interface,
        way: LightWay,
    ) -> Result<Box<dyn LooksUp>, DeviceError> {
        match interface {
            Interface::Vulkan => {
                let gpu = terrafill_vulkan::shared_gpu(devices)?;
                let layers = count(&self.layers);
                let storage = |label, bytes| -> Result<Resource, DeviceError> {
                    let buffer = Buffer::upload(&gpu, label, bytes, BufferUse::Storage)?;
                    Ok(Resource::Storage(Arc::new(buffer)))
                };
                let parts = LayerParts {
                    way,
                    layers,
                    side: self.side,
                    vertex: way.listed_vertex(),
                    geometry: way.listed_geometry(layers),
                    fragment: None,
                    vertices: [count(&self.places), 3],
                    resources: vec![
                        uniform(&gpu, "picture", &self.constants)?,
                        storage("places", bytemuck::cast_slice(&self.places))?,
                        uniform(&gpu, "layers", &self.layer_bytes())?,
                    ],
                    behind: Some(storage("values", bytemuck::cast_slice(&self.values))?),
                    picture: self.picture,
                    size: self.size,
                };
                Ok(Box::new(OnVulkan::with(&gpu, parts)?))
            }
            Interface::Wgpu => self.open_wgpu(devices, DrawnInto::Maps),
        }
    }

    /// On wgpu, layers kept or added up.
    pub(crate) fn open_wgpu(
        &self,
        devices: &Devices,
        into: DrawnInto,
    ) -> Result<Box<dyn LooksUp>, DeviceError> {
        let gpu = terrafill_gpu::shared_gpu(devices)?;
        Ok(Box::new(OnWgpu::new(&gpu, self, into)?))
    }
}
