// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of meshes: each triangle in the light that falls on it, every other cell a little darker, red what is
//! wrong.

use crate::images::{PICTURE, SKY, WRONG, square};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::GridCamera;
use terrafill_shapes::mesh::Mesh;
use terrafill_study::{Depth, Request};

/// Pixels a side, unless the request says otherwise or is quick.
const SIDE: u32 = 1_024;
const CLAY: [f64; 3] = [222.0, 178.0, 140.0];
/// Light where none falls, and what odd cells have less.
const LEAST_LIGHT: f64 = 0.3;
const ODD: f64 = 0.93;

/// Size of the request's pictures of meshes: square, of its smaller side.
pub(crate) fn size_of(request: &Request) -> ImageSize {
    let usual = if request.depth == Depth::Quick {
        PICTURE.width
    } else {
        SIDE
    };
    let [width, height] = request.size_or([usual; 2]);
    square(width.min(height))
}

/// Colours of triangles' numbers.
///
/// - `wrong`: of each pixel, whether it may not show what it shows
pub(crate) fn shaded<'a>(
    mesh: &'a Mesh,
    view: GridCamera,
    numbers: &'a [u32],
    wrong: &'a [bool],
) -> impl Iterator<Item = [u8; 3]> + 'a {
    numbers.iter().zip(wrong).map(move |(number, is_wrong)| {
        let index = number.checked_sub(1).map(|index| index as usize);
        let index = index.filter(|index| *index < mesh.triangles.len());
        match (is_wrong, index) {
            (true, _) => WRONG,
            (false, None) => SKY,
            (false, Some(index)) => {
                let light = LEAST_LIGHT + (1.0 - LEAST_LIGHT) * mesh.light(index, &view);
                let odd = if (index / 2).is_multiple_of(2) {
                    1.0
                } else {
                    ODD
                };
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "between 0 and 255"
                )]
                let colour = CLAY.map(|part| (part * light * odd) as u8);
                colour
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use terrafill_shapes::mesh::Cut;

    #[test]
    fn sky_surface_and_what_is_wrong_look_different() {
        let vertices = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let vertices = vertices.map(|[x, z]| DVec3::new(x, 0.0, z));
        let mesh = Mesh::new(vertices.into(), 1, |_, _| Cut::Published);
        let view = GridCamera::looking(DVec3::new(0.5, -3.0, 1.0), DVec3::ZERO, 0.5);
        let wrong = [false, false, true];
        let colours: Vec<_> = shaded(&mesh, view, &[0, 1, 1], &wrong).collect();
        assert_eq!((colours[0], colours[2]), (SKY, WRONG));
        assert!(colours[1] != SKY && colours[1] != WRONG);
        assert!(colours[1][0] > 66, "it is lit: {:?}", colours[1]);
    }
}
