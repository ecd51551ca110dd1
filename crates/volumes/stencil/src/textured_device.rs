// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a device is handed for a textured fill, and what its probe hands back: the same on every API.

use crate::{CoverLook, CoverPurpose, Holding, TexturedCover, TexturedPlan, TexturedRegion};
use terrafill_contract::{Feature, FillInput, Frame, NO_REGION, TexturePixel};
use terrafill_texture::{Filter, LookupTable, PositionRoute, Program, TexelFormat};
use terrafill_variant::{RouteChoice, SwitchError, Switches};

/// Group that a route's table is bound in, its texture at binding 0 and its sampler at 1.
const TABLE_GROUP: u32 = 3;

/// Texels of what some coordinate routes read besides constants: a table of the arctangent in one
/// row, or a cube of longitudes and latitudes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RouteTexels {
    /// How a texel is stored.
    pub format: RouteTexelFormat,
    /// A sampler filters it; otherwise texels are loaded by their number.
    pub is_filtered: bool,
    /// Of each face.
    pub size: [u32; 2],
    /// Six faces, or one flat table.
    pub is_cube: bool,
    /// Rows from the top, one face after the other.
    pub bytes: Vec<u8>,
}

/// How a texel of a route's table is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RouteTexelFormat {
    /// A fraction of 8 bits.
    R8Unorm,
    /// A fraction of 16 bits.
    R16Unorm,
    /// A 16-bit float.
    R16Float,
    /// A 32-bit float.
    R32Float,
    /// Two 32-bit floats.
    Rg32Float,
    /// Four 32-bit floats.
    Rgba32Float,
}

impl RouteTexelFormat {
    /// Of a texel.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::R8Unorm => 1,
            Self::R16Unorm | Self::R16Float => 2,
            Self::R32Float => 4,
            Self::Rg32Float => 8,
            Self::Rgba32Float => 16,
        }
    }
}

impl RouteTexels {
    /// The table that a route's program reads; `None` if it reads none.
    #[must_use]
    pub fn of(program: &Program) -> Option<Self> {
        if let Some(table) = program.table() {
            return Some(Self::of_table(table));
        }
        let cube = program.cube()?;
        let faces: Vec<[f32; 2]> = (0..6).flat_map(|face| cube.face(face)).collect();
        Some(Self {
            format: RouteTexelFormat::Rg32Float,
            is_filtered: true,
            size: [cube.size(); 2],
            is_cube: true,
            bytes: bytemuck::cast_slice(&faces).to_vec(),
        })
    }

    /// A table in one row.
    #[must_use]
    pub fn of_table(table: &LookupTable) -> Self {
        Self {
            format: match table.format() {
                TexelFormat::R8Unorm => RouteTexelFormat::R8Unorm,
                TexelFormat::R16Unorm => RouteTexelFormat::R16Unorm,
                TexelFormat::R16Float => RouteTexelFormat::R16Float,
                TexelFormat::R32Float => RouteTexelFormat::R32Float,
            },
            is_filtered: table.filter() == Filter::Linear,
            size: [u32::try_from(table.texels()).unwrap_or(u32::MAX), 1],
            is_cube: false,
            bytes: table.bytes(),
        }
    }

    /// WGSL that declares it in a group, its texture at binding 0 and its sampler at 1; empty for a program
    /// that reads none.
    #[must_use]
    pub fn declarations(program: &Program, group: u32) -> String {
        let table = program.table().map(|t| t.declarations(group, 0));
        let cube = program.cube().map(|c| c.declarations(group, 0));
        table.or(cube).unwrap_or_default()
    }

    /// Bytes of so many texels as its size says.
    #[must_use]
    pub fn byte_count(&self) -> usize {
        let [width, height] = self.size.map(|side| side as usize);
        let faces = if self.is_cube { 6 } else { 1 };
        width * height * faces * self.format.bytes()
    }
}

impl TexturedCover {
    /// WGSL of its coordinate route, tables declared.
    #[must_use]
    pub fn route_wgsl(&self) -> String {
        let program = self.route.program();
        RouteTexels::declarations(&program, TABLE_GROUP) + &program.wgsl()
    }

    /// The table that its route reads; `None` if it reads none.
    #[must_use]
    pub fn route_texels(&self) -> Option<RouteTexels> {
        RouteTexels::of(&self.route.program())
    }
}

impl TexturedPlan {
    /// The textured fill that `switches` ask for; `None` for a plain one, unless it is to hold what a
    /// textured one holds.
    ///
    /// # Errors
    /// As [`TexturedPlan::new`].
    pub fn of_switches(
        input: &FillInput,
        switches: &Switches,
    ) -> Result<Option<Self>, SwitchError> {
        let position = switches.position.unwrap_or(PositionRoute::EyeRegion);
        let loaded = switches.loads_texture.then_some(RouteChoice::Chosen);
        let Some(choice) = switches.texture.or(loaded) else {
            return Ok(None);
        };
        let mut plan = Self::new(input, choice, position)?;
        for cover in &mut plan.covers {
            cover.normalizes_position = switches.superfluous_normalize;
        }
        Ok(Some(plan))
    }

    /// WGSL of the position route.
    #[must_use]
    pub fn position_wgsl(&self) -> String {
        self.position.wgsl(&self.depth)
    }

    /// Every region's constants, each at a multiple of the stride in bytes that comes with them: as
    /// long as the longest, and a multiple of `alignment`. Never empty, since no binding may be.
    #[must_use]
    pub fn aligned_constants(&self, alignment: usize) -> (Vec<[f32; 4]>, usize) {
        let constants = self.covers.iter().map(|cover| {
            let mut all = bytemuck::cast_slice(&[cover.region]).to_vec();
            for part in [&cover.position_constants, &cover.route_constants] {
                all.extend_from_slice(part);
                // A shader's array has at least one element.
                all.resize(all.len() + usize::from(part.is_empty()), [0.0; 4]);
            }
            all
        });
        let constants: Vec<Vec<[f32; 4]>> = constants.collect();
        let longest = constants.iter().map(Vec::len).max();
        let vectors = longest.unwrap_or(TexturedRegion::VECTORS + 2);
        let stride = (16 * vectors).next_multiple_of(alignment.max(16));
        let padded = constants.into_iter().flat_map(|mut region| {
            region.resize(stride / 16, [0.0; 4]);
            region
        });
        let mut written: Vec<[f32; 4]> = padded.collect();
        written.resize(written.len().max(stride / 16), [0.0; 4]);
        (written, stride)
    }

    /// The plain frame with the ids and places that the probe found in place of its own.
    #[must_use]
    pub fn frame(&self, input: &FillInput, plain: Frame, probed: &[Option<Probed>]) -> Frame {
        let places: Vec<_> = probed.iter().map(|at| at.map(|at| at.place)).collect();
        let wrong = places.iter().flatten().filter(|place| !place.is_finite());
        Frame {
            ids: probed
                .iter()
                .map(|at| at.map_or(NO_REGION, |at| at.id))
                .collect(),
            non_finite: plain.non_finite + wrong.count() as u64,
            texture: Some(self.coordinates(input, places)),
            ..plain
        }
    }
}

/// What the covers' probe found at a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probed {
    /// Index of the region, and 1.
    pub id: u32,
    /// Where its texels come from.
    pub place: TexturePixel,
}

impl Probed {
    /// From the probe's two targets, pixel by pixel; `None` where nothing was covered.
    #[must_use]
    pub fn of_targets(places: &[[f32; 4]], sizes: &[[f32; 4]]) -> Vec<Option<Self>> {
        let probed = |(place, size): (&[f32; 4], &[f32; 4])| {
            // Cleared to 0, which is no region's id.
            let id = region_id(place[3])?;
            let place = TexturePixel {
                uv: [place[0], place[1]].map(f64::from),
                pattern_level: f64::from(size[0]),
                footprint_texels: f64::from(size[1]),
                level: f64::from(place[2]),
                distance_m: f64::from(size[2]),
            };
            Some(Self { id, place })
        };
        places.iter().zip(sizes).map(probed).collect()
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "ids are whole and below 2²⁴"
)]
fn region_id(stored: f32) -> Option<u32> {
    (stored > 0.0).then_some(stored as u32)
}

/// What devices hold of textured covers: pictures, tables of routes, pipelines and the constants of a view.
///
/// - `constants`: bytes that are written and bytes of the buffer, where there is a view
pub fn textured_holdings(
    picture_bytes: u64,
    table_bytes: u64,
    pipelines: impl Iterator<Item = CoverLook>,
    constants: Option<[u64; 2]>,
) -> Vec<Holding> {
    let textures = [
        Holding::textures(Feature::Picture, picture_bytes),
        Holding::textures(Feature::TextureCode, table_bytes),
    ];
    let constants = constants
        .map(|[written, buffer]| Holding::constants(Feature::TextureConstants, written, buffer));
    let held = textures.into_iter().chain(constants);
    let features = pipelines.map(|look| match look.purpose {
        CoverPurpose::Colour => Feature::TextureCode,
        CoverPurpose::Probe => Feature::Measuring,
    });
    held.chain(Holding::pipelines(features)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_that_nothing_covers_have_no_place() {
        let places = [[0.25, 0.5, 2.0, 7.0], [0.0; 4], [f32::NAN, 0.5, 0.0, 1.0]];
        let sizes = [[3.0, 1.5, 900.0, 0.0], [0.0; 4], [0.0; 4]];
        let probed = Probed::of_targets(&places, &sizes);
        let place = TexturePixel {
            uv: [0.25, 0.5],
            pattern_level: 3.0,
            footprint_texels: 1.5,
            level: 2.0,
            distance_m: 900.0,
        };
        assert_eq!(probed[0], Some(Probed { id: 7, place }));
        assert_eq!(probed[1], None);
        // Negative control: what is not finite is kept, to be counted.
        assert!(probed[2].is_some_and(|at| at.id == 1 && !at.place.is_finite()));
    }
}
