// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which workgroup makes which part of which volume, and where it puts it.

use crate::layout::MeshSlice;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;
use terrafill_contract::DeviceError;
use terrafill_core::RegionMesh;
use terrafill_stencil::DrawnParts;

/// Invocations of a workgroup of `compute/expand.wgsl`.
pub(crate) const WORKGROUP_SIZE: usize = 64;

/// What a device holds. Counted before anything is created, so that too much is an error with
/// numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Capacity {
    /// Largest buffer that a shader reads or writes.
    pub storage_bytes: u64,
    /// Largest number of workgroups in each of a dispatch's two dimensions.
    pub workgroups_per_dimension: u32,
}

impl Capacity {
    /// What `limits` allow.
    #[must_use]
    pub fn of(limits: &wgpu::Limits) -> Self {
        Self {
            storage_bytes: limits
                .max_storage_buffer_binding_size
                .min(limits.max_buffer_size),
            workgroups_per_dimension: limits.max_compute_workgroups_per_dimension,
        }
    }

    /// Refuses a buffer that is too large.
    pub(crate) fn check_bytes(self, what: &str, found: u64) -> Result<(), DeviceError> {
        DeviceError::check_capacity(&format!("bytes of {what}"), found, self.storage_bytes)
    }

    /// Columns and rows of workgroups that hold `workgroups` of them.
    pub(crate) fn dispatch_size(self, workgroups: usize) -> Result<[u32; 2], DeviceError> {
        let (found, columns) = (workgroups as u64, u64::from(self.workgroups_per_dimension));
        DeviceError::check_capacity("workgroups that expand volumes", found, columns * columns)?;
        let size = [found.min(columns), found.div_ceil(columns.max(1))];
        Ok(size.map(|count| u32::try_from(count).unwrap_or(u32::MAX)))
    }
}

/// Twin of `WorkGroup` in `compute/expand.wgsl`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct WorkGroup {
    pub(crate) region: u32,
    pub(crate) first_input: u32,
    pub(crate) first_output: u32,
    pub(crate) first_bottom_output: u32,
    pub(crate) count: u32,
    pub(crate) kind: u32,
}

const WALLS: u32 = 1;
const SHORT_INDICES: u32 = 2;
const WITHOUT_BOTTOM: u32 = 4;

/// Where a region's volume lies in the list of all, in indices: the bottom cap first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct OutputSlice {
    pub(crate) first_index: u32,
    /// 0 where no bottom is made.
    pub(crate) bottom_count: u32,
    /// Of the top cap alone.
    pub(crate) top_count: u32,
    /// Top cap and walls.
    pub(crate) upper_count: u32,
}

impl OutputSlice {
    /// What a draw of it reads, with its bottom cap or without.
    ///
    /// - `parts`: what is drawn of it, where that is not all
    pub(crate) fn drawn(
        &self,
        parts: Option<&DrawnParts>,
        without_bottom: bool,
    ) -> Vec<Range<u32>> {
        let first_top = self.first_index + self.bottom_count;
        let Some(parts) = parts else {
            let first = if without_bottom {
                first_top
            } else {
                self.first_index
            };
            return std::iter::once(first..first_top + self.upper_count).collect();
        };
        let moved = |ranges: &[Range<u32>], by: u32| -> Vec<Range<u32>> {
            let ranges = ranges.iter();
            ranges
                .map(|range| by + range.start..by + range.end)
                .collect()
        };
        let has_bottom = !without_bottom && self.bottom_count > 0;
        let bottom = has_bottom.then(|| moved(&parts.caps, self.first_index));
        let walls = moved(&parts.walls, first_top + self.top_count);
        let tops = moved(&parts.caps, first_top);
        [bottom.unwrap_or_default(), tops, walls].concat()
    }
}

/// How volumes are made from meshes.
#[derive(Debug, Default)]
pub(crate) struct ExpansionPlan {
    pub(crate) work: Vec<WorkGroup>,
    /// One a mesh, in the order in which they were given.
    pub(crate) outputs: Vec<OutputSlice>,
    pub(crate) index_count: u64,
}

impl ExpansionPlan {
    /// Lays the volumes of `meshes` one after the other, each with its bottom cap or without.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when an index would have no 32-bit number.
    pub(crate) fn new<'a>(
        meshes: impl Iterator<Item = (&'a RegionMesh, &'a MeshSlice, bool)>,
    ) -> Result<Self, DeviceError> {
        let mut plan = Self::default();
        for (mesh, slice, has_bottom) in meshes {
            plan.push(mesh, slice, has_bottom)?;
        }
        Ok(plan)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "the sum is checked against 2^32 before any part of it is cast"
    )]
    fn push(
        &mut self,
        mesh: &RegionMesh,
        slice: &MeshSlice,
        has_bottom: bool,
    ) -> Result<(), DeviceError> {
        let end = self.index_count + slice.output_indices(has_bottom);
        DeviceError::check_capacity("indices of expanded volumes", end, u64::from(u32::MAX))?;
        let region = self.outputs.len() as u32;
        let first_index = self.index_count as u32;
        let top_count = 3 * slice.place.triangle_count;
        let bottom_count = if has_bottom { top_count } else { 0 };
        let first_top = first_index + bottom_count;
        let short = if slice.place.has_short_indices {
            SHORT_INDICES
        } else {
            0
        };
        let bottom = if has_bottom { 0 } else { WITHOUT_BOTTOM };
        for first in (0..slice.place.triangle_count).step_by(WORKGROUP_SIZE) {
            self.work.push(WorkGroup {
                region,
                first_input: slice.place.first_triangle_index + 3 * first,
                first_output: first_top + 3 * first,
                first_bottom_output: first_index + 3 * first,
                count: (slice.place.triangle_count - first).min(WORKGROUP_SIZE as u32),
                kind: short | bottom,
            });
        }
        let mut first_input = slice.place.first_loop_index;
        let mut first_output = first_top + top_count;
        for ring in &mesh.boundary_loops {
            let edges = ring.len() as u32;
            for first in (0..edges).step_by(WORKGROUP_SIZE) {
                self.work.push(WorkGroup {
                    region,
                    first_input: first_input + first,
                    first_output: first_output + 6 * first,
                    first_bottom_output: 0,
                    count: (edges - first).min(WORKGROUP_SIZE as u32),
                    kind: WALLS | short,
                });
            }
            // Stored closed.
            first_input += edges + 1;
            first_output += 6 * edges;
        }
        self.outputs.push(OutputSlice {
            first_index,
            bottom_count,
            top_count,
            upper_count: top_count + 6 * slice.edge_count,
        });
        self.index_count = end;
        Ok(())
    }

    /// Bytes of the list.
    pub(crate) fn output_bytes(&self) -> u64 {
        4 * self.index_count
    }
}

/// How corners are put into clip space.
#[derive(Debug, Default)]
pub(crate) struct PlacingPlan {
    pub(crate) work: Vec<WorkGroup>,
    /// First corner of each mesh, in the order in which they were given.
    pub(crate) first_corners: Vec<u32>,
    corner_count: u64,
}

impl PlacingPlan {
    /// Lays the corners of `meshes` one after the other.
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`] when a draw could not begin at one of them: it says so in 31
    /// bits.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the sum is checked against 2^31 before any part of it is cast"
    )]
    pub(crate) fn new<'a>(
        meshes: impl Iterator<Item = &'a RegionMesh>,
    ) -> Result<Self, DeviceError> {
        let mut plan = Self::default();
        for (region, mesh) in meshes.enumerate() {
            let end = plan.corner_count + 2 * mesh.vertices_ecef.len() as u64;
            DeviceError::check_capacity("corners in clip space", end, i32::MAX as u64)?;
            let (first_corner, vertices) = (plan.corner_count as u32, mesh.vertices_ecef.len());
            for first in (0..vertices as u32).step_by(WORKGROUP_SIZE) {
                plan.work.push(WorkGroup {
                    region: region as u32,
                    first_input: first,
                    first_output: first_corner + 2 * first,
                    first_bottom_output: 0,
                    count: (vertices as u32 - first).min(WORKGROUP_SIZE as u32),
                    kind: 0,
                });
            }
            plan.first_corners.push(first_corner);
            plan.corner_count = end;
        }
        Ok(plan)
    }

    /// Bytes of the corners.
    pub(crate) fn output_bytes(&self) -> u64 {
        16 * self.corner_count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::SceneGeometry;
    use std::mem::{offset_of, size_of};
    use terrafill_fixtures::by_hand::disc;
    use terrafill_shaders::struct_layout;

    fn plan(meshes: &[RegionMesh]) -> ExpansionPlan {
        plan_with(meshes, true)
    }

    fn plan_with(meshes: &[RegionMesh], has_bottom: bool) -> ExpansionPlan {
        let geometry = SceneGeometry::build(meshes);
        let slices = meshes.iter().zip(&geometry.meshes);
        let meshes = slices.map(|(mesh, slice)| (mesh, slice, has_bottom));
        ExpansionPlan::new(meshes).expect("fits")
    }

    /// How often each index of the list is written.
    fn writes(plan: &ExpansionPlan) -> Vec<u32> {
        let mut writes = vec![0; usize::try_from(plan.index_count).expect("small")];
        let mut write = |first: u32, count: u32| {
            for place in &mut writes[first as usize..(first + count) as usize] {
                *place += 1;
            }
        };
        for group in &plan.work {
            assert!(group.count as usize <= WORKGROUP_SIZE && group.count > 0);
            if group.kind & WALLS != 0 {
                write(group.first_output, 6 * group.count);
            } else {
                write(group.first_output, 3 * group.count);
                if group.kind & WITHOUT_BOTTOM == 0 {
                    write(group.first_bottom_output, 3 * group.count);
                }
            }
        }
        writes
    }

    #[test]
    fn every_index_is_written_once() {
        let mut islands = disc(64);
        islands.boundary_loops = vec![(0..3).collect(), (3..64).collect(), (0..64).collect()];
        let meshes = [disc(3), disc(65), islands, disc(70_000)];
        let mut plan = plan(&meshes);
        assert!(writes(&plan).iter().all(|&count| count == 1));
        let bytes: u64 = meshes
            .iter()
            .map(|mesh| crate::compute_bytes(mesh).output_index_bytes)
            .sum();
        assert_eq!(plan.output_bytes(), bytes);
        let whole = plan.output_bytes();
        let mut without = plan_with(&meshes, false);
        assert!(writes(&without).iter().all(|&count| count == 1));
        let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        assert_eq!(whole - without.output_bytes(), 12 * triangles as u64);
        // Negative control: a bottom that nothing made room for is noticed.
        without.work[0].kind &= !WITHOUT_BOTTOM;
        assert!(writes(&without).iter().any(|&count| count > 1));
        // Negative control: a workgroup less is noticed.
        plan.work.pop();
        assert!(writes(&plan).contains(&0));
    }

    #[test]
    fn the_bottom_comes_first_and_regions_do_not_mix() {
        let plan = plan(&[disc(5), disc(100)]);
        let [first, second] = plan.outputs[..] else {
            panic!("two regions")
        };
        assert_eq!((first.first_index, first.bottom_count), (0, 15));
        assert_eq!(first.upper_count, 15 + 30);
        assert_eq!(second.first_index, 60);
        for group in plan.work.iter().filter(|group| group.kind & WALLS == 0) {
            let output = plan.outputs[group.region as usize];
            let upper = output.first_index + output.bottom_count;
            assert!(group.first_bottom_output < upper && group.first_output >= upper);
        }
    }

    #[test]
    fn every_corner_is_placed_once() {
        let meshes = [disc(3), disc(63), disc(64), disc(1000)];
        let plan = PlacingPlan::new(meshes.iter()).expect("fits");
        let mut placed = vec![0; usize::try_from(plan.corner_count).expect("small")];
        for group in &plan.work {
            let first = group.first_output as usize;
            for place in &mut placed[first..first + 2 * group.count as usize] {
                *place += 1;
            }
        }
        assert!(placed.iter().all(|&count| count == 1));
        let bytes: u64 = meshes.iter().map(crate::placed_bytes).sum();
        assert_eq!(plan.output_bytes(), bytes);
        assert_eq!(plan.first_corners, [0, 8, 8 + 128, 8 + 128 + 130]);
    }

    #[test]
    fn work_lies_as_the_shader_reads_it() {
        let layout = struct_layout("compute/expand.wgsl", "WorkGroup").expect("is in the shader");
        let shader: Vec<(String, usize)> = layout
            .members
            .into_iter()
            .map(|(name, offset, _)| (name, offset as usize))
            .collect();
        let rust = [
            ("region", offset_of!(WorkGroup, region)),
            ("first_input", offset_of!(WorkGroup, first_input)),
            ("first_output", offset_of!(WorkGroup, first_output)),
            (
                "first_bottom_output",
                offset_of!(WorkGroup, first_bottom_output),
            ),
            ("count", offset_of!(WorkGroup, count)),
            ("kind", offset_of!(WorkGroup, kind)),
        ];
        assert_eq!(shader, rust.map(|(name, offset)| (name.to_owned(), offset)));
        assert_eq!(size_of::<WorkGroup>(), layout.stride as usize);
    }

    #[test]
    fn dispatches_hold_all_workgroups_or_are_refused() {
        let capacity = Capacity {
            storage_bytes: 1000,
            workgroups_per_dimension: 7,
        };
        for workgroups in [1, 6, 7, 8, 48, 49] {
            let [columns, rows] = capacity.dispatch_size(workgroups).expect("fits");
            assert!(columns <= 7 && rows <= 7 && (columns * rows) as usize >= workgroups);
        }
        let error = capacity.dispatch_size(50).expect_err("too many");
        assert_eq!(
            error.to_string(),
            "workgroups that expand volumes: found 50, allowed 49"
        );
        assert!(capacity.check_bytes("x", 1000).is_ok());
        assert!(capacity.check_bytes("x", 1001).is_err());
    }
}
