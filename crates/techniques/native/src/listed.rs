// SPDX-License-Identifier: MIT OR Apache-2.0
//! The volumes of a step by one call: a command for each volume, in a buffer that the device reads.
//!
//! A command is what a draw of a volume would be told (Vulkan 1.0, `VkDrawIndexedIndirectCommand`): indices,
//! first vertex, and as instance number the volume. So any layout has it, and nothing is stored twice.

use crate::extrusion::VolumePart;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use terrafill_contract::{DeviceError, Feature};
use terrafill_core::index_u32;
use terrafill_stencil::{FillPass, FillProgram, FillStep, Holding, VolumeDraw, VolumeList};
use terrafill_vulkan::{Buffer, BufferUse, DrawCommand, Gpu, IndexWidth};

/// One draw that the commands are for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wanted {
    pub(crate) part: VolumePart,
    pub(crate) width: IndexWidth,
    pub(crate) volume: usize,
    pub(crate) without_bottom: bool,
}

/// Commands of one part and one width of indices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Listed {
    part: VolumePart,
    width: IndexWidth,
    pub(crate) commands: Range<u32>,
    /// Of all of them.
    pub(crate) vertices: u64,
}

/// By the volumes that are drawn together and whether without their bottoms.
type ByVolumes = HashMap<(Vec<usize>, bool), Vec<Listed>>;

/// The commands of a program.
#[derive(Debug, Default)]
pub(crate) struct DrawLists {
    /// What they are of: a program, and the geometry of each of its volumes.
    of: Option<(FillProgram, Vec<usize>)>,
    listed: ByVolumes,
    commands: Vec<DrawCommand>,
    buffer: Option<Buffer>,
}

impl DrawLists {
    /// What it holds is of other geometry than there is now.
    pub(crate) fn forget(&mut self) {
        self.of = None;
    }

    /// Brings the commands up to date.
    ///
    /// - `parts`: of every volume
    /// - `command`: those of a draw; none of one that is not there, such as of indices of another width
    ///
    /// # Errors
    /// [`DeviceError::OverCapacity`], [`DeviceError::OutOfMemory`].
    pub(crate) fn load(
        &mut self,
        gpu: &Arc<Gpu>,
        (list, program): (&VolumeList, &FillProgram),
        parts: &[VolumePart],
        command: impl Fn(Wanted) -> Vec<DrawCommand>,
    ) -> Result<(), DeviceError> {
        let geometries: Vec<usize> = list.volumes.iter().map(|volume| volume.geometry).collect();
        let is_of =
            |(of, meshes): &(FillProgram, Vec<usize>)| of == program && *meshes == geometries;
        if self.of.as_ref().is_some_and(is_of) {
            return Ok(());
        }
        self.of = None;
        let (listed, commands) = commands_of(program, parts, command);
        let bytes: &[u8] = bytemuck::cast_slice(&commands);
        let has_room = |buffer: &Buffer| buffer.size() >= bytes.len() as u64;
        let buffer = match self.buffer.take().filter(has_room) {
            Some(buffer) => {
                buffer.rewrite_changed(bytemuck::cast_slice(&self.commands), bytes)?;
                buffer
            }
            None => Buffer::upload(gpu, "draw commands", bytes, BufferUse::Arguments)?,
        };
        self.buffer = Some(buffer);
        self.listed = listed;
        self.commands = commands;
        self.of = Some((program.clone(), geometries));
        Ok(())
    }

    /// Where the commands of a draw are; `None` of a draw that the program has not, or where it draws nothing.
    pub(crate) fn find(
        &self,
        draw: &VolumeDraw<'_>,
        part: VolumePart,
        width: IndexWidth,
    ) -> Option<(&Buffer, &Listed)> {
        let key = (draw.volumes.to_vec(), draw.without_bottom);
        let mut own = self.listed.get(&key)?.iter();
        let listed = own.find(|listed| listed.part == part && listed.width == width)?;
        Some((self.buffer.as_ref()?, listed))
    }

    pub(crate) fn holding(&self) -> Option<Holding> {
        let written = size_of_val(self.commands.as_slice()) as u64;
        let size = self.buffer.as_ref()?.size();
        Some(Holding::constants(Feature::RegionConstants, written, size))
    }
}

fn commands_of(
    program: &FillProgram,
    parts: &[VolumePart],
    command: impl Fn(Wanted) -> Vec<DrawCommand>,
) -> (ByVolumes, Vec<DrawCommand>) {
    let (mut listed, mut commands) = (ByVolumes::new(), Vec::new());
    for step in program.passes.iter().flat_map(FillPass::steps) {
        let FillStep::Volumes(draw) = step else {
            continue;
        };
        let key = (draw.volumes.to_vec(), draw.without_bottom);
        if listed.contains_key(&key) {
            continue;
        }
        let mut own = Vec::new();
        for width in [IndexWidth::Short, IndexWidth::Long] {
            for &part in parts {
                let first = commands.len();
                commands.extend(draw.volumes.iter().flat_map(|&volume| {
                    command(Wanted {
                        part,
                        width,
                        volume,
                        without_bottom: draw.without_bottom,
                    })
                }));
                let new: &[DrawCommand] = &commands[first..];
                if !new.is_empty() {
                    own.push(Listed {
                        part,
                        width,
                        vertices: new.iter().map(|c| u64::from(c.index_count)).sum(),
                        commands: index_u32(first)..index_u32(commands.len()),
                    });
                }
            }
        }
        listed.insert(key, own);
    }
    (listed, commands)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_plan::{DrawnAs, NearRectangle, PixelRect};
    use terrafill_scene::Overlap;
    use terrafill_stencil::{DepthRange, Volume};
    use terrafill_variant::Switches;

    #[test]
    fn every_volume_of_a_step_has_its_command_and_no_other_has_one() {
        let volume = |geometry: usize, left: u32| Volume {
            screen_rect: PixelRect {
                left,
                top: 0,
                right: left + 10,
                bottom: 10,
            },
            depth: DepthRange::ANY,
            near_rectangle: NearRectangle::Outside,
            drawn_as: DrawnAs::Volume,
            geometry,
        };
        // The first and the last beside each other, the second across both.
        let volumes = [volume(7, 0), volume(8, 5), volume(9, 20)];
        let program = FillProgram::new(&volumes, &Switches::default(), Overlap::Disjoint);
        let program = program.expect("allowed");
        let command = |wanted: Wanted| {
            // The last one has long indices.
            let is_long = wanted.volume == 2;
            let own = (is_long == (wanted.width == IndexWidth::Long)).then_some(DrawCommand {
                index_count: 3,
                first_instance: u32::try_from(wanted.volume).expect("small"),
                ..DrawCommand::ONE
            });
            own.into_iter().collect()
        };
        let (listed, commands) =
            commands_of(&program, &[VolumePart::Caps, VolumePart::Walls], command);
        let of = |volumes: &[usize]| &listed[&(volumes.to_vec(), false)];
        let drawn = |volumes: &[usize]| -> Vec<(VolumePart, u32)> {
            let both = of(volumes).iter().flat_map(|listed| {
                let range = listed.commands.start as usize..listed.commands.end as usize;
                assert_eq!(listed.vertices, 3 * range.len() as u64);
                let instances = commands[range].iter().map(|command| command.first_instance);
                instances.map(|volume| (listed.part, volume))
            });
            both.collect()
        };
        let (caps, walls) = (VolumePart::Caps, VolumePart::Walls);
        assert_eq!(
            drawn(&[0, 2]),
            [(caps, 0), (walls, 0), (caps, 2), (walls, 2)]
        );
        assert_eq!(drawn(&[1]), [(caps, 1), (walls, 1)]);
        assert_eq!(commands.len(), 6);
        // Negative control: volumes that no step draws together have none.
        assert!(!listed.contains_key(&(vec![0, 1], false)));
    }
}
