// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles of any surface on any API: what is uploaded, kept and drawn.

use crate::{DeviceError, SurfaceLook, SurfaceView, count_u32};
use std::collections::HashMap;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;
use terrafill_scene::MipChain;
use terrafill_surface::SurfaceFrame;

/// What a surface is drawn by on one API.
pub trait SurfaceDevice {
    /// Vertices or indices.
    type Buffer: Debug;
    /// Of one look.
    type Pipeline: Debug;
    /// A picture, ready to be read.
    type Picture: Debug;

    /// Makes the pipeline of a look: `vertex_main` and `fragment_main` of its shader, the nearest depth wins.
    ///
    /// # Errors
    /// [`DeviceError::Shader`], [`DeviceError::OutOfMemory`].
    fn pipeline(&self, look: SurfaceLook) -> Result<Self::Pipeline, DeviceError>;

    /// Uploads a picture, continued as [`SurfaceLook::PICTURE_ADDRESS`] says.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    fn picture(&self, picture: &MipChain) -> Result<Self::Picture, DeviceError>;

    /// Uploads vertices of 12 bytes, or with `are_indices` indices of 4.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    fn upload(&self, bytes: &[u8], are_indices: bool) -> Result<Self::Buffer, DeviceError>;

    /// Writes a buffer of as many bytes anew.
    ///
    /// # Errors
    /// [`DeviceError::DeviceLost`], [`DeviceError::OutOfMemory`].
    fn rewrite(&self, buffer: &Self::Buffer, bytes: &[u8]) -> Result<(), DeviceError>;
}

/// The triangles of the surface that was prepared last.
#[derive(Debug)]
pub struct SurfaceTriangles<D: SurfaceDevice> {
    device: D,
    look: SurfaceLook,
    /// Of the looks so far.
    pipelines: HashMap<SurfaceLook, D::Pipeline>,
    picture: Option<(Arc<MipChain>, D::Picture)>,
    uploaded: Option<Uploaded<D::Buffer>>,
}

#[derive(Debug)]
struct Uploaded<B> {
    vertices: B,
    vertex_bytes: usize,
    indices: B,
    /// Of the indices, what the view may show.
    drawn: Vec<Range<u32>>,
    /// What the indices are of.
    triangles: Arc<[[u32; 3]]>,
}

/// What draws of a surface use.
#[derive(Debug)]
pub struct SurfaceDraw<'a, D: SurfaceDevice> {
    /// Of the look.
    pub pipeline: &'a D::Pipeline,
    /// Where the look has one.
    pub picture: Option<&'a D::Picture>,
    /// Vertices.
    pub vertices: &'a D::Buffer,
    /// Indices.
    pub indices: &'a D::Buffer,
    /// Of the indices, a draw each.
    pub ranges: &'a [Range<u32>],
}

impl<D: SurfaceDevice> SurfaceTriangles<D> {
    /// Without a surface.
    pub fn new(device: D) -> Self {
        Self {
            device,
            look: SurfaceLook::default(),
            pipelines: HashMap::new(),
            picture: None,
            uploaded: None,
        }
    }

    /// Uploads a view's surface in place of the one before, and a picture that is not there yet.
    ///
    /// # Errors
    /// As those of [`SurfaceDevice`].
    pub fn prepare(&mut self, view: &SurfaceView<'_>) -> Result<(), DeviceError> {
        self.look = SurfaceLook {
            has_picture: view.picture.is_some(),
            draws_back_faces: view.draws_back_faces,
        };
        let held = self.picture.take();
        self.picture = match (view.picture, held) {
            (Some(picture), Some(held)) if Arc::ptr_eq(&held.0, picture) => Some(held),
            (Some(picture), _) => Some((Arc::clone(picture), self.device.picture(picture)?)),
            (None, _) => None,
        };
        if !self.pipelines.contains_key(&self.look) {
            let pipeline = self.device.pipeline(self.look)?;
            self.pipelines.insert(self.look, pipeline);
        }
        self.upload(view.surface)
    }

    fn upload(&mut self, frame: &SurfaceFrame) -> Result<(), DeviceError> {
        let vertices: &[u8] = bytemuck::cast_slice(&frame.vertices_rte);
        let drawn = frame.index_ranges(self.look.draws_back_faces);
        // Only places differ, as those of a surface do that another view sees.
        let has_room = |held: &&mut Uploaded<D::Buffer>| {
            Arc::ptr_eq(&held.triangles, &frame.triangles) && held.vertex_bytes == vertices.len()
        };
        if let Some(held) = self.uploaded.as_mut().filter(has_room) {
            held.drawn = drawn;
            return self.device.rewrite(&held.vertices, vertices);
        }
        let indices = frame.triangles.as_flattened();
        count_u32("surface indices", indices.len())?;
        self.uploaded = Some(Uploaded {
            vertices: self.device.upload(vertices, false)?,
            indices: self.device.upload(bytemuck::cast_slice(indices), true)?,
            drawn,
            vertex_bytes: vertices.len(),
            triangles: Arc::clone(&frame.triangles),
        });
        Ok(())
    }

    /// The draws of the surface that was prepared last; `None` before there is one.
    pub fn draws(&self) -> Option<SurfaceDraw<'_, D>> {
        let uploaded = self.uploaded.as_ref()?;
        Some(SurfaceDraw {
            pipeline: self.pipelines.get(&self.look)?,
            picture: self.picture.as_ref().map(|(_, picture)| picture),
            vertices: &uploaded.vertices,
            indices: &uploaded.indices,
            ranges: &uploaded.drawn,
        })
    }
}
