// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every way to step balls takes and does.

use crate::drawing::DrawsBalls;
use crate::terrain::State;
use terrafill_contract::DeviceError;
use terrafill_scene::ImageSize;

/// As all shaders have it; those of flat ground need none of the last.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct BallConstants {
    pub(crate) step_s: f32,
    pub(crate) gravity: f32,
    /// k/m, 1/s².
    pub(crate) stiffness: f32,
    pub(crate) count: u32,
    /// Cells along a side of a block of the terrain, and a side of a cell in metres.
    pub(crate) cells: u32,
    pub(crate) cell_m: f32,
    /// Blocks along a side of the terrain.
    pub(crate) blocks: u32,
    /// What a ball does that is below the terrain: its number.
    pub(crate) law: u32,
    /// Share of the speed along the normal that a reflection leaves.
    pub(crate) restitution: f32,
    /// Radius of a crater over the speed of the ball that strikes, seconds, and its depth over its radius.
    pub(crate) crater_s: f32,
    pub(crate) crater_depth: f32,
    pub(crate) padding: u32,
}

/// Balls on a device.
pub(crate) trait Steps {
    /// Takes `count` steps and waits.
    fn step(&mut self, count: u32) -> Result<(), DeviceError>;
    /// GPU time of the last steps, milliseconds, where the device keeps time.
    fn gpu_ms(&self) -> Result<Option<f64>, DeviceError>;
    fn read(&self) -> Result<Vec<State>, DeviceError>;
    /// Bytes that the CPU has written for the device so far.
    fn uploaded(&self) -> u64;
    /// Which of the two states is the last.
    fn current(&self) -> usize;
    /// What draws the balls.
    fn points(&self, size: ImageSize) -> Result<Box<dyn DrawsBalls>, DeviceError>;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::offset_of;
    use terrafill_shaders::struct_layout;

    #[test]
    fn constants_and_balls_lie_as_shaders_read_them() {
        for path in ["balls/fly.wgsl", "balls/craters.wgsl", "balls/step.wgsl"] {
            let layout = struct_layout(path, "BallConstants").expect("a struct");
            let offset = |name: &str| layout.offset(name).expect(name);
            macro_rules! lies {
                ($($field:ident)*) => {
                    [$((offset(stringify!($field)), offset_of!(BallConstants, $field))),*]
                };
            }
            let places = lies![step_s gravity stiffness count cells cell_m blocks law restitution crater_s crater_depth];
            for (there, here) in places {
                assert_eq!(there, here);
            }
            // Negative control: a neighbour.
            assert_ne!(offset("law"), offset_of!(BallConstants, restitution));
            // What is uniform ends on a multiple of 16 bytes.
            let stride = (layout.stride as usize).next_multiple_of(16);
            assert_eq!(stride, size_of::<BallConstants>());
            let ball = struct_layout(path, "Ball").expect("a struct");
            assert_eq!(ball.stride as usize, size_of::<State>());
        }
    }
}
