// SPDX-License-Identifier: MIT OR Apache-2.0
//! Triangles of a list, the matrix of each layer, and the picture that looks the layers up.

use crate::draws::count;
use crate::lights::LightColumns;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::nearest;

/// Most layers, as shaders have room for.
pub(crate) const MOST_LAYERS: usize = 128;

/// What is drawn and looked up.
#[derive(Debug, Clone)]
pub(crate) struct Listed {
    /// Vertices, three a triangle, in the space that the layers' matrices take: the unit square and depth, or metres.
    pub(crate) places: Vec<[f32; 4]>,
    pub(crate) layers: Vec<LightColumns>,
    /// A side of a layer, texels.
    pub(crate) side: u32,
    /// Of the picture.
    pub(crate) size: ImageSize,
    /// Of each pixel, where the picture reads them.
    pub(crate) values: Vec<f32>,
    /// WGSL of the picture, and its constants.
    pub(crate) picture: &'static str,
    pub(crate) constants: Vec<u8>,
}

/// A rectangle of one depth, as two triangles.
///
/// - `from`, `to`: opposite corners
pub(crate) fn rectangle(from: [f64; 2], to: [f64; 2], depth: f32) -> [[f32; 4]; 6] {
    let at = |right: usize, down: usize| {
        let ends = [from, to];
        let (x, y) = (nearest(ends[right][0]), nearest(ends[down][1]));
        [x, y, depth, 0.0]
    };
    [at(0, 0), at(1, 0), at(0, 1), at(1, 0), at(1, 1), at(0, 1)]
}

impl Listed {
    /// Twin of `Layers` in `shared/layers.wgsl`.
    pub(crate) fn layer_bytes(&self) -> Vec<u8> {
        let mut bytes: Vec<u8> = bytemuck::cast_slice(&self.layers).to_vec();
        bytes.resize(MOST_LAYERS * size_of::<LightColumns>(), 0);
        let count = count(&self.layers);
        let weight = 1.0 / count as f32;
        bytes.extend(count.to_ne_bytes());
        bytes.extend(weight.to_ne_bytes());
        bytes.extend([0; 8]);
        bytes
    }
}

/// Numbers whose bits are a picture's pixels.
pub(crate) fn numbers_of(rgba: &[u8]) -> Vec<f32> {
    let (pixels, _) = rgba.as_chunks::<4>();
    pixels
        .iter()
        .map(|bits| f32::from_le_bytes(*bits))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::square;
    use terrafill_shaders::struct_layout;

    #[test]
    fn layers_lie_as_the_shader_reads_them() {
        let listed = Listed {
            places: Vec::new(),
            layers: vec![LightColumns::sheared([0.0; 2], [0.0; 2], 0.0); 3],
            side: 1,
            size: square(1),
            values: Vec::new(),
            picture: "",
            constants: Vec::new(),
        };
        let bytes = listed.layer_bytes();
        let layout = struct_layout("pipelines/listed.wgsl", "Layers").expect("a struct");
        assert_eq!(layout.stride as usize, bytes.len());
        let at =
            |name: &str| [0, 1, 2, 3].map(|byte| bytes[layout.offset(name).expect(name) + byte]);
        assert_eq!(u32::from_ne_bytes(at("count")), 3);
        // Negative control: another member.
        assert_ne!(u32::from_ne_bytes(at("weight")), 3);
        assert_eq!(f32::from_ne_bytes(at("weight")), 1.0 / 3.0);
    }

    #[test]
    fn bits_are_a_number_and_other_bytes_another() {
        assert_eq!(numbers_of(&1.5_f32.to_le_bytes()), [1.5]);
        assert_ne!(numbers_of(&1.5_f32.to_be_bytes()), [1.5]);
    }
}
