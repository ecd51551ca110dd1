// SPDX-License-Identifier: MIT OR Apache-2.0
//! Frames of the reference: one ray and one classification per pixel.

use crate::locator::Locator;
use crate::point::Point;
use crate::sampling::encoded;
use crate::surface::SurfaceTriangles;
use crate::texture::Texturing;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use terrafill_contract::{DeviceError, FillInput, Frame, NO_REGION, TexturePixel, paint};
use terrafill_core::Geodetic;

/// Judges frames on the CPU, in f64.
#[derive(Debug, Default)]
pub struct ReferenceBackend {
    /// Whether frames are verified with the scene's texture.
    is_textured: bool,
    /// Whether rays meet the body itself and not the surface as drawn.
    is_on_body: bool,
}

/// A verified frame.
#[derive(Debug, Clone)]
pub struct ReferenceFrame {
    /// The picture, by the first inside test; where regions overlap, the last one.
    pub frame: Frame,
    /// Per pixel: whether the two inside tests differ about any region there.
    pub disagreements: Vec<bool>,
    /// The textured fill over the surface in one colour, RGB, row 0 at the top; `None` of a plain
    /// fill. Overlapping regions are blended in their order.
    pub picture: Option<Vec<u8>>,
    /// How far, in pixels, each place that is seen on a boundary lies from where the surface at its full
    /// resolution has the same place; `None` where the surface cannot say, and of the
    /// body itself. What hides what is left aside.
    pub moved_px_true: Option<Vec<f64>>,
}

impl ReferenceFrame {
    /// Pixels about which the two inside tests differ.
    #[must_use]
    pub fn disagreement_px(&self) -> u64 {
        self.disagreements.iter().filter(|&&differ| differ).count() as u64
    }
}

impl ReferenceBackend {
    /// A reference, ready to judge.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A reference whose rays meet the body itself: for what draws a surface of its own, which may lie closer
    /// to the body than the input's triangles.
    #[must_use]
    pub fn on_body() -> Self {
        Self {
            is_on_body: true,
            ..Self::default()
        }
    }

    /// A reference that fills with the scene's texture where it has one: frames say where their
    /// texels come from, and there is a picture.
    #[must_use]
    pub fn textured() -> Self {
        Self {
            is_textured: true,
            ..Self::default()
        }
    }

    /// Judges `input`; the same input gives the same frame whatever the number of threads.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when a region leaves open what is inside it.
    pub fn judge(&self, input: &FillInput) -> Result<ReferenceFrame, DeviceError> {
        Ok(self.judge_in(input, &self.scene(input)?))
    }

    /// The same by what [`ReferenceBackend::scene`] made of `input`.
    #[must_use]
    pub fn judge_in(&self, input: &FillInput, scene: &ReferenceScene) -> ReferenceFrame {
        let texturing = if self.is_textured {
            Texturing::new(input)
        } else {
            None
        };
        let judged = judge_on(input, scene, texturing.as_ref());
        ReferenceFrame {
            moved_px_true: if self.is_on_body {
                None
            } else {
                moved_px_true(input, &scene.surface, &judged.frame.ids)
            },
            ..judged
        }
    }

    /// Rings and rays of `input`, ready to be asked.
    ///
    /// # Errors
    /// [`DeviceError::Unsupported`] when a region leaves open what is inside it.
    pub fn scene(&self, input: &FillInput) -> Result<ReferenceScene, DeviceError> {
        Ok(ReferenceScene {
            locator: self.locator(input)?,
            surface: self.surface(input),
        })
    }

    fn surface(&self, input: &FillInput) -> SurfaceTriangles {
        if self.is_on_body {
            SurfaceTriangles::of_body(&input.scene.body, input.camera.eye_ecef)
        } else {
            SurfaceTriangles::in_picture(&input.surface, &input.camera, input.size)
        }
    }

    fn locator(&self, input: &FillInput) -> Result<Locator, DeviceError> {
        let scene = &input.scene;
        Locator::new(&scene.regions, scene.edge_rule, &scene.body).map_err(|error| {
            DeviceError::Unsupported {
                capability: format!("a reading of its regions: {error}"),
                adapter: format!("the reference of {}", scene.name),
            }
        })
    }
}

/// The rings of an input and the triangles that its rays meet.
#[derive(Debug)]
pub struct ReferenceScene {
    locator: Locator,
    surface: SurfaceTriangles,
}

/// What a view shows at any place of the image, not only where pixels have their centres.
#[derive(Debug)]
pub struct CloseLook<'a> {
    input: &'a FillInput,
    scene: &'a ReferenceScene,
}

impl<'a> CloseLook<'a> {
    /// - `scene`: what [`ReferenceBackend::scene`] made of `input`
    #[must_use]
    pub fn new(input: &'a FillInput, scene: &'a ReferenceScene) -> Self {
        Self { input, scene }
    }

    /// Ids, those of no region among them, within `radius_px` columns and rows of a pixel's centre, as
    /// far as places [`PLACES_PER_PX`] to a pixel show them.
    #[must_use]
    pub fn ids_within(&self, pixel: usize, radius_px: u32) -> BTreeSet<u32> {
        let width = self.input.size.width.max(1) as usize;
        let centre = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
        let places = i32::try_from(radius_px * PLACES_PER_PX).unwrap_or(i32::MAX);
        let along = |centre: f64| {
            (-places..=places)
                .map(move |place| centre + f64::from(place) / f64::from(PLACES_PER_PX))
        };
        let all = along(centre[1]).flat_map(|y| along(centre[0]).map(move |x| [x, y]));
        all.map(|place| self.id_at(place)).collect()
    }

    /// Ids that rounding may give a pixel whose centre shows a border: those around it, and no region's.
    /// Empty where all that is close lies in one region. A facet in the plane of a wall, such as a skirt at
    /// a tile's edge, is on either side of it to anything that rounds.
    ///
    /// - `reach`: what is close, as a share of the distance from the eye
    #[must_use]
    pub fn ids_by_rounding(&self, pixel: usize, reach: f64) -> BTreeSet<u32> {
        let input = self.input;
        let width = input.size.width.max(1) as usize;
        let place = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
        let ray = input.camera.direction_ecef(input.size, place);
        let Some(depth) = self.scene.surface.hit(ray, input.camera.near_m) else {
            return BTreeSet::new();
        };
        let hit_ecef = input.camera.eye_ecef + ray * depth;
        let reach_m = reach * (ray * depth).length();
        let id_beside = |offset: DVec3| {
            judge_place(
                input,
                &self.scene.locator,
                None,
                (ray, depth),
                hit_ecef + offset,
            )
            .id
        };
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * reach_m);
        let steps = axes.into_iter().flat_map(|step| [step, -step]);
        let mut ids: BTreeSet<u32> = steps.chain([DVec3::ZERO]).map(id_beside).collect();
        if ids.len() == 1 {
            return BTreeSet::new();
        }
        ids.insert(NO_REGION);
        ids
    }

    /// The id at a place of the image, pixels from its upper left corner; a pixel's centre is at half
    /// pixels.
    #[must_use]
    pub fn id_at(&self, place: [f64; 2]) -> u32 {
        let direction = self.input.camera.direction_ecef(self.input.size, place);
        judge_direction(self.input, self.scene, None, direction).id
    }
}

/// Places in a row of a pixel at which a [`CloseLook`] asks.
pub const PLACES_PER_PX: u32 = 8;

/// What one pixel shows.
#[derive(Debug, Clone, Copy, Default)]
struct Pixel {
    id: u32,
    is_surface: bool,
    differ: bool,
    is_non_finite: bool,
    texture: Option<TexturePixel>,
    /// What is blended over the surface: sRGB times opacity, and what shows through.
    paint: Blend,
}

/// Layers laid over one another: their colours' sum, and the share of what is below.
#[derive(Debug, Clone, Copy)]
struct Blend {
    rgb: [f64; 3],
    below: f64,
}

impl Default for Blend {
    fn default() -> Self {
        Self {
            rgb: [0.0; 3],
            below: 1.0,
        }
    }
}

impl Blend {
    /// Lays a layer on top, as a blend unit does: on encoded values.
    fn cover(&mut self, [r, g, b, alpha]: [f64; 4]) {
        for (sum, light) in self.rgb.iter_mut().zip([r, g, b]) {
            *sum = *sum * (1.0 - alpha) + encoded(light) * alpha;
        }
        self.below *= 1.0 - alpha;
    }

    #[allow(clippy::cast_possible_truncation, reason = "clamped to 0 … 255")]
    fn over(&self, background: u8, channel: usize) -> u8 {
        let value = self.rgb[channel] * 255.0 + f64::from(background) * self.below;
        value.round().clamp(0.0, 255.0) as u8
    }
}

/// [`ReferenceBackend::judge`] by a given locator.
#[cfg(test)]
pub(crate) fn judge(
    input: &FillInput,
    locator: Locator,
    texturing: Option<&Texturing<'_>>,
) -> ReferenceFrame {
    let surface = SurfaceTriangles::new(&input.surface);
    judge_on(input, &ReferenceScene { locator, surface }, texturing)
}

fn judge_on(
    input: &FillInput,
    scene: &ReferenceScene,
    texturing: Option<&Texturing<'_>>,
) -> ReferenceFrame {
    let width = input.size.width as usize;
    let mut pixels = vec![Pixel::default(); input.size.pixel_count()];
    if width > 0 {
        pixels
            .par_chunks_mut(width)
            .zip(0..input.size.height)
            .for_each(|(pixels, row)| {
                for (pixel, column) in pixels.iter_mut().zip(0..) {
                    *pixel = judge_pixel(input, scene, texturing, column, row);
                }
            });
    }
    let non_finite = pixels.iter().filter(|pixel| pixel.is_non_finite).count() as u64;
    ReferenceFrame {
        frame: Frame {
            size: input.size,
            ids: pixels.iter().map(|pixel| pixel.id).collect(),
            surface: pixels.iter().map(|pixel| pixel.is_surface).collect(),
            non_finite: non_finite + scene.surface.non_finite(),
            counters: None,
            texture: texturing.map(|texturing| {
                texturing.coordinates(pixels.iter().map(|pixel| pixel.texture).collect())
            }),
        },
        picture: texturing.map(|_| picture(input, &pixels)),
        disagreements: pixels.iter().map(|pixel| pixel.differ).collect(),
        moved_px_true: None,
    }
}

/// [`ReferenceFrame::moved_px_true`]: the place in the centre of each pixel whose right or lower neighbour
/// shows another id, raised to its true height and seen again.
fn moved_px_true(input: &FillInput, surface: &SurfaceTriangles, ids: &[u32]) -> Option<Vec<f64>> {
    let (camera, size, body) = (&input.camera, input.size, &input.scene.body);
    let truth = &input.scene.surface;
    // A surface knows its heights everywhere or nowhere.
    truth.true_height_m(0.0, 0.0)?;
    let width = size.width as usize;
    let is_boundary = |index: &usize| {
        let differs = |other: usize| ids.get(other).is_some_and(|id| *id != ids[*index]);
        let has_right = !(index + 1).is_multiple_of(width.max(1));
        (has_right && differs(index + 1)) || differs(index + width)
    };
    let moved = |index: usize| {
        let centre = [index % width, index / width].map(|at| at as f64 + 0.5);
        let direction = camera.direction_ecef(size, centre);
        let depth = surface.hit(direction, camera.near_m)?;
        let drawn = body.ecef_to_geodetic(camera.eye_ecef + direction * depth);
        let degrees = [drawn.longitude_rad, drawn.latitude_rad].map(f64::to_degrees);
        let height_m = truth.true_height_m(degrees[0], degrees[1])?;
        let seen =
            camera.project_px(size, body.geodetic_to_ecef(Geodetic { height_m, ..drawn }))?;
        Some((seen[0] - centre[0]).hypot(seen[1] - centre[1]))
    };
    let boundary: Vec<usize> = (0..ids.len()).filter(is_boundary).collect();
    Some(boundary.into_par_iter().filter_map(moved).collect())
}

/// The pixels' paint over the surface and the sky, both in one colour.
fn picture(input: &FillInput, pixels: &[Pixel]) -> Vec<u8> {
    let background = paint(&Frame {
        size: input.size,
        ids: vec![NO_REGION; pixels.len()],
        surface: pixels.iter().map(|pixel| pixel.is_surface).collect(),
        non_finite: 0,
        counters: None,
        texture: None,
    });
    let channels = background
        .chunks_exact(3)
        .zip(pixels)
        .flat_map(|(rgb, pixel)| (0..3).map(|channel| pixel.paint.over(rgb[channel], channel)));
    channels.collect()
}

fn judge_pixel(
    input: &FillInput,
    scene: &ReferenceScene,
    texturing: Option<&Texturing<'_>>,
    column: u32,
    row: u32,
) -> Pixel {
    let direction = input.camera.pixel_direction_ecef(input.size, column, row);
    judge_direction(input, scene, texturing, direction)
}

fn judge_direction(
    input: &FillInput,
    scene: &ReferenceScene,
    texturing: Option<&Texturing<'_>>,
    direction: DVec3,
) -> Pixel {
    let Some(depth) = scene.surface.hit(direction, input.camera.near_m) else {
        return Pixel::default();
    };
    let hit_ecef = input.camera.eye_ecef + direction * depth;
    judge_place(
        input,
        &scene.locator,
        texturing,
        (direction, depth),
        hit_ecef,
    )
}

/// What lies at a place of the surface.
fn judge_place(
    input: &FillInput,
    locator: &Locator,
    texturing: Option<&Texturing<'_>>,
    (direction, depth): (DVec3, f64),
    hit_ecef: DVec3,
) -> Pixel {
    let geodetic = input.scene.body.ecef_to_geodetic(hit_ecef);
    let mut pixel = Pixel {
        id: NO_REGION,
        is_surface: true,
        ..Pixel::default()
    };
    let longitude_deg = geodetic.longitude_rad.to_degrees();
    let latitude_deg = geodetic.latitude_rad.to_degrees().clamp(-90.0, 90.0);
    let Some(point) = Point::new(longitude_deg, latitude_deg) else {
        pixel.is_non_finite = true;
        return pixel;
    };
    locator.for_each_region(&point, |region, verdicts| {
        if verdicts.first {
            pixel.id = u32::try_from(region + 1).expect("fewer regions than bytes of memory");
            if let Some(texturing) = texturing {
                let texture = texturing.pixel(region, direction, depth);
                pixel.paint.cover(texturing.colour(region, &texture));
                pixel.is_non_finite |= !texture.is_finite();
                pixel.texture = Some(texture);
            }
        }
        pixel.differ |= verdicts.first != verdicts.second;
    });
    pixel
}
