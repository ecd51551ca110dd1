// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture for people, by the reference's rays and inside test: what `render --style map` writes and reports show.
//!
//! Each pixel is the mean of [`SAMPLES_A_SIDE`]² rays against the surface as drawn. Where one hits, the surface at
//! its full resolution gives height and slope. Heights are tints from sea level up. The light comes from the north-west
//! at 45°, as on printed maps, in the tangent frame of each place. Colours are sRGB, 0 … 255, and mixed as encoded.

use crate::{Locator, LocatorError, SurfaceTriangles};
use glam::{DVec3, FloatExt};
use rayon::prelude::*;
use terrafill_contract::FillInput;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_scene::ImageSize;

/// Samples of a pixel in each direction: borders have nine steps and more.
const SAMPLES_A_SIDE: usize = 3;
/// Width of a region's outline on its own side of the border, samples.
const OUTLINE_SAMPLES: usize = 2;
/// Rows of pixels that a thread draws at once.
const BAND_ROWS: usize = 16;

/// Tints by height above sea level, metres, after those of Wikipedia's topographic maps, with a deeper sea and a lower
/// snow line.
const TINTS: [(f64, [f64; 3]); 13] = [
    (-7_000.0, [36.0, 84.0, 148.0]),
    (-3_000.0, [62.0, 118.0, 178.0]),
    (-200.0, [108.0, 163.0, 212.0]),
    (0.0, [132.0, 184.0, 224.0]),
    (0.0, [132.0, 178.0, 120.0]),
    (150.0, [168.0, 198.0, 143.0]),
    (500.0, [209.0, 215.0, 171.0]),
    (1_500.0, [239.0, 235.0, 192.0]),
    (2_500.0, [222.0, 214.0, 163.0]),
    (3_500.0, [204.0, 184.0, 136.0]),
    (4_500.0, [190.0, 164.0, 124.0]),
    (5_800.0, [216.0, 208.0, 196.0]),
    (7_000.0, [250.0, 250.0, 250.0]),
];
/// Added to heights of bodies without a sea, so that nothing of them is green or blue.
const DRY_OFFSET_M: f64 = 2_500.0;

const SPACE: DVec3 = DVec3::new(8.0, 10.0, 24.0);
const ZENITH: DVec3 = DVec3::new(66.0, 124.0, 196.0);
const HORIZON: DVec3 = DVec3::new(214.0, 229.0, 242.0);
const MARKER: DVec3 = DVec3::new(222.0, 30.0, 36.0);
const WHITE: DVec3 = DVec3::splat(255.0);

/// How much of a region's colour covers the ground.
const REGION_OPACITY: f64 = 0.5;
/// The same over water, whose blue hides more.
const REGION_OPACITY_OVER_WATER: f64 = 0.65;
/// The same where rock and snow are seen from near, from [`HIGH_GROUND_M`] on.
const REGION_OPACITY_ON_HIGH_GROUND: f64 = 0.14;
/// Above sea level, metres: where opacity begins to fall, and where it has fallen.
const HIGH_GROUND_M: [f64; 2] = [2_500.0, 5_000.0];
/// Size of a pixel on the ground from which on colours alone tell regions apart, metres.
const FAR_PIXEL_M: f64 = 1_000.0;
/// What an outline leaves of it.
const OUTLINE_BRIGHTNESS: f64 = 0.45;
/// Of distant ground by the air in between.
const MAX_HAZE: f64 = 0.5;
/// Heights over which the air thins, share of the body's radius: 25 km on the Earth.
const AIR_SHARE: f64 = 0.004;
/// Distance at which haze has come to 63 %, share of the body's radius: 130 km on the Earth.
const HAZE_SHARE: f64 = 0.02;

/// Unit vector to the light: east, north, up.
const LIGHT: DVec3 = DVec3::new(-0.5, 0.5, std::f64::consts::FRAC_1_SQRT_2);
/// Brightness of what the light does not reach; level ground has 1.
const AMBIENT: f64 = 0.42;
/// Slopes are measured over as much where the surface is drawn in coarser triangles, metres.
const MAX_FACET_M: f64 = 100.0;
/// Over this many metres slopes are shown as they are, over more they are exaggerated: hills would vanish.
const PLAIN_SLOPE_M: f64 = 150.0;

/// Side of the inset, share of the picture's shorter side.
const INSET_SHARE: f64 = 0.3;
/// Its distance from the picture's edges.
const INSET_MARGIN_SHARE: f64 = 0.02;

/// A view as a map shows it. No fill is compared with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapPicture {
    /// Columns and rows.
    pub size: ImageSize,
    /// Three bytes a pixel, sRGB, row 0 at the top.
    pub rgb: Vec<u8>,
    /// What the inset shows, in words.
    pub inset: String,
}

impl MapPicture {
    /// Draws a view, with a plan of its surroundings in the upper right corner.
    ///
    /// # Errors
    /// [`LocatorError`] when a region leaves open what is inside it.
    pub fn of(input: &FillInput) -> Result<Self, LocatorError> {
        let scene = &input.scene;
        let map = MapView {
            input,
            surface: SurfaceTriangles::in_picture(&input.surface, &input.camera, input.size),
            locator: Locator::new(&scene.regions, scene.edge_rule, &scene.body)?,
            eye: scene.body.ecef_to_geodetic(input.camera.eye_ecef),
        };
        let width = input.size.width as usize;
        let mut rgb = vec![0; 3 * input.size.pixel_count()];
        rgb.par_chunks_mut((3 * width * BAND_ROWS).max(1))
            .enumerate()
            .for_each(|(band, rgb)| map.draw_band(band * BAND_ROWS, rgb));
        let half_width_m = map.inset_half_width_m();
        map.draw_inset(half_width_m, &mut rgb);
        let eye = map.eye;
        let inset = format!(
            "inset: north up, {:.1} km wide; its dot: the eye, longitude {:.4}, latitude {:.4}",
            half_width_m / 500.0,
            eye.longitude_rad.to_degrees(),
            eye.latitude_rad.to_degrees(),
        );
        Ok(Self {
            size: input.size,
            rgb,
            inset,
        })
    }

    /// The same at `longest_px` along its longer side at most.
    ///
    /// # Errors
    /// As [`MapPicture::of`].
    pub fn small(input: &FillInput, longest_px: u32) -> Result<Self, LocatorError> {
        let ImageSize { width, height } = input.size;
        let longest = width.max(height).max(longest_px);
        let shrunk = |px: u32| (px * longest_px / longest).max(1);
        Self::of(&FillInput {
            size: ImageSize::new(shrunk(width), shrunk(height)),
            ..input.clone()
        })
    }
}

struct MapView<'a> {
    input: &'a FillInput,
    surface: SurfaceTriangles,
    locator: Locator,
    eye: Geodetic,
}

/// What one ray shows.
#[derive(Clone, Copy)]
struct Sample {
    colour: DVec3,
    is_sky: bool,
    /// Where several overlap, the last one.
    region: Option<usize>,
}

impl MapView<'_> {
    fn body(&self) -> &Ellipsoid {
        &self.input.scene.body
    }

    fn radius_m(&self) -> f64 {
        self.body().equatorial_radius_m()
    }

    /// Share of the air at sea level that is left at a height.
    fn air(&self, height_m: f64) -> f64 {
        (-height_m.max(0.0) / (AIR_SHARE * self.radius_m())).exp()
    }

    /// - `rgb`: whole rows from `first_row` on
    fn draw_band(&self, first_row: usize, rgb: &mut [u8]) {
        let width = self.input.size.width as usize;
        let rows = rgb.len() / (3 * width);
        // A rim on each side, in which outlines look for other regions.
        let columns = width * SAMPLES_A_SIDE + 2 * OUTLINE_SAMPLES;
        let lines = rows * SAMPLES_A_SIDE + 2 * OUTLINE_SAMPLES;
        let place = |at: usize| (at as f64 + 0.5 - OUTLINE_SAMPLES as f64) / SAMPLES_A_SIDE as f64;
        let samples: Vec<Sample> = (0..lines * columns)
            .map(|at| self.sample([place(at % columns), place(at / columns) + first_row as f64]))
            .collect();
        let colour = |column: usize, line: usize| {
            let at = (line + OUTLINE_SAMPLES) * columns + column + OUTLINE_SAMPLES;
            let Sample { colour, region, .. } = samples[at];
            if region.is_none() {
                return colour;
            }
            let reach = [0, OUTLINE_SAMPLES, 2 * OUTLINE_SAMPLES];
            let is_border = reach.iter().any(|down| {
                reach.iter().any(|right| {
                    let other = samples[(line + down) * columns + column + right];
                    !other.is_sky && other.region != region
                })
            });
            colour * if is_border { OUTLINE_BRIGHTNESS } else { 1.0 }
        };
        for (index, pixel) in rgb.chunks_exact_mut(3).enumerate() {
            let (left, top) = (
                index % width * SAMPLES_A_SIDE,
                index / width * SAMPLES_A_SIDE,
            );
            write(pixel, mean(|x, y| colour(left + x, top + y)));
        }
    }

    /// What a place of the image shows, pixels from its upper left corner.
    fn sample(&self, place_px: [f64; 2]) -> Sample {
        let camera = &self.input.camera;
        let direction = camera.direction_ecef(self.input.size, place_px);
        let Some((depth, facet)) = self.surface.hit_facet(direction, camera.near_m) else {
            return Sample {
                colour: self.sky(direction),
                is_sky: true,
                region: None,
            };
        };
        let place = self
            .body()
            .ecef_to_geodetic(camera.eye_ecef + direction * depth);
        let facet_m = (facet[1] - facet[0]).length().min(MAX_FACET_M);
        let step_m = camera.pixel_size_m(self.input.size, depth).max(facet_m);
        let (ground, region) = self.ground(place, step_m);
        let distance_m = direction.length() * depth;
        let haze = 1.0 - (-distance_m / (HAZE_SHARE * self.radius_m())).exp();
        Sample {
            colour: ground.lerp(HORIZON, MAX_HAZE * haze * self.air(self.eye.height_m)),
            is_sky: false,
            region,
        }
    }

    fn height_m(&self, place: Geodetic) -> f64 {
        let longitude_deg = place.longitude_rad.to_degrees();
        let latitude_deg = place.latitude_rad.to_degrees().clamp(-90.0, 90.0);
        let surface = &self.input.scene.surface;
        surface
            .true_height_m(longitude_deg, latitude_deg)
            .unwrap_or_default()
    }

    /// Tint, region and light of a place, and its last region.
    ///
    /// - `step_m`: over how much slopes are measured
    fn ground(&self, place: Geodetic, step_m: f64) -> (DVec3, Option<usize>) {
        let [across_m, along_m] = self.body().curvature_radii_m(place.latitude_rad);
        let circle_m = (across_m * place.latitude_rad.cos()).max(step_m);
        let beside = |east: f64, north: f64| {
            self.height_m(Geodetic {
                longitude_rad: place.longitude_rad + east * step_m / circle_m,
                latitude_rad: place.latitude_rad + north * step_m / along_m,
                height_m: 0.0,
            })
        };
        let east = (beside(0.5, 0.0) - beside(-0.5, 0.0)) / step_m;
        let north = (beside(0.0, 0.5) - beside(0.0, -0.5)) / step_m;
        let height_m = self.height_m(place);
        let has_sea = *self.body() == Ellipsoid::WGS84;
        let is_water = has_sea && height_m <= 0.0;
        let tinted_m = if has_sea {
            height_m
        } else {
            height_m.max(0.0) + DRY_OFFSET_M
        };
        let mut colour = tint(tinted_m);
        let [longitude_deg, latitude_deg] =
            [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
        let region = self
            .locator
            .locate(longitude_deg, latitude_deg)
            .regions
            .pop();
        if let Some(region) = region {
            let opacity = if is_water {
                REGION_OPACITY_OVER_WATER
            } else if step_m > FAR_PIXEL_M {
                REGION_OPACITY
            } else {
                let [low, high] = HIGH_GROUND_M;
                let share = ((tinted_m - low) / (high - low)).clamp(0.0, 1.0);
                REGION_OPACITY.lerp(REGION_OPACITY_ON_HIGH_GROUND, share)
            };
            colour = colour.lerp(map_colour(region), opacity);
        }
        // Water is level; what lies below it shines through.
        let relief = if is_water { 0.35 } else { 1.0 };
        let exaggeration = relief * (step_m / PLAIN_SLOPE_M).max(1.0).powf(0.4);
        (
            colour * brightness(exaggeration * east, exaggeration * north),
            region,
        )
    }

    /// Pale at the horizon and blue above it, by as much air as the ray passes through; the rest is space.
    fn sky(&self, direction: DVec3) -> DVec3 {
        let eye = self.input.camera.eye_ecef;
        let along = direction.normalize();
        let closest = eye + along * (-eye.dot(along)).max(0.0);
        let air = self.air(self.body().ecef_to_geodetic(closest).height_m);
        let above = along.dot(eye.normalize()).max(0.0);
        SPACE.lerp(HORIZON.lerp(ZENITH, (2.0 * above).min(1.0).sqrt()), air)
    }

    /// East, north and up below the eye.
    fn axes(&self) -> [DVec3; 3] {
        let up = self
            .body()
            .geodetic_surface_normal(self.eye.longitude_rad, self.eye.latitude_rad);
        let (sin, cos) = self.eye.longitude_rad.sin_cos();
        let east = DVec3::new(-sin, cos, 0.0);
        [east, up.cross(east), up]
    }

    /// A little further than most of the ground in view is away, or the whole body.
    fn inset_half_width_m(&self) -> f64 {
        const RAYS: usize = 24;
        let (camera, size, up) = (&self.input.camera, self.input.size, self.axes()[2]);
        let mut distances_m: Vec<f64> = (0..RAYS * RAYS)
            .filter_map(|ray| {
                let [x, y] = [ray % RAYS, ray / RAYS].map(|at| (at as f64 + 0.5) / RAYS as f64);
                let place_px = [x * f64::from(size.width), y * f64::from(size.height)];
                let direction = camera.direction_ecef(size, place_px);
                let hit = direction * self.surface.hit(direction, camera.near_m)?;
                Some(hit.reject_from_normalized(up).length())
            })
            .collect();
        distances_m.sort_by(f64::total_cmp);
        let whole_m = 1.1 * self.radius_m();
        let far_m = distances_m.get(distances_m.len() * 4 / 5);
        far_m.map_or(whole_m, |far_m| (1.2 * far_m).min(whole_m))
    }

    /// A plan of what lies below the eye, north up: what is in view is bright, and a dot marks the eye.
    fn draw_inset(&self, half_width_m: f64, rgb: &mut [u8]) {
        let size = self.input.size;
        let (width, height) = (size.width as usize, size.height as usize);
        let shorter = width.min(height);
        let side = share_of(shorter, INSET_SHARE);
        let margin = share_of(shorter, INSET_MARGIN_SHARE);
        let axes = self.axes();
        // The eye is moved out of the middle, away from where it looks.
        let ahead = -0.5 * self.input.camera.view_from_ecef.row(2);
        let frame = 2.0 / side.max(1) as f64;
        let colour = |x: f64, y: f64| {
            let rim = x.abs().max(y.abs());
            let [x, y] = [x + ahead.dot(axes[0]), y + ahead.dot(axes[1])];
            let from_eye = x.hypot(y);
            if rim > 1.0 - 2.0 * frame || (0.06..0.09).contains(&from_eye) {
                WHITE
            } else if from_eye < 0.06 {
                MARKER
            } else {
                self.plan(
                    axes,
                    [x, y].map(|at| at * half_width_m),
                    frame * half_width_m,
                )
            }
        };
        let rows: Vec<Vec<DVec3>> = (0..side)
            .into_par_iter()
            .map(|row| {
                let at = |pixel: usize, sample: usize| {
                    let place = pixel as f64 + (sample as f64 + 0.5) / SAMPLES_A_SIDE as f64;
                    2.0 * place / side as f64 - 1.0
                };
                (0..side)
                    .map(|column| mean(|x, y| colour(at(column, x), -at(row, y))))
                    .collect()
            })
            .collect();
        for (row, colours) in rows.into_iter().enumerate() {
            let first = 3 * ((row + margin) * width + width - margin - side);
            for (pixel, colour) in rgb[first..].chunks_exact_mut(3).zip(colours) {
                write(pixel, colour);
            }
        }
    }

    /// What the plan shows: the body seen from infinitely far above.
    ///
    /// - `offset_m`: to the east and to the north
    fn plan(&self, [east, north, up]: [DVec3; 3], offset_m: [f64; 2], step_m: f64) -> DVec3 {
        let aside = east * offset_m[0] + north * offset_m[1];
        let radius_m = self.radius_m();
        let below_m2 = radius_m * radius_m - aside.length_squared();
        if below_m2 <= 0.0 {
            return SPACE;
        }
        let normal = (aside + up * below_m2.sqrt()) / radius_m;
        let place = Geodetic {
            longitude_rad: normal.y.atan2(normal.x),
            latitude_rad: normal.z.clamp(-1.0, 1.0).asin(),
            height_m: 0.0,
        };
        let (colour, _) = self.ground(place, step_m);
        let foot = self.body().geodetic_to_ecef(place);
        let camera = &self.input.camera;
        let seen = camera.project_px(self.input.size, foot + normal * self.height_m(place));
        let is_inside = |[x, y]: [f64; 2]| {
            let size = self.input.size;
            (0.0..f64::from(size.width)).contains(&x) && (0.0..f64::from(size.height)).contains(&y)
        };
        let is_beyond_the_limb = normal.dot(camera.eye_ecef - foot) <= 0.0;
        if seen.is_some_and(is_inside) && !is_beyond_the_limb {
            colour
        } else {
            0.45 * colour
        }
    }
}

/// Colours between violet and rose, which neither land nor water nor rock has, light and dark by turns.
fn map_colour(index: usize) -> DVec3 {
    let share = (index as f64 * 0.618_033_988_749_895).fract();
    let hue = DVec3::new(112.0, 40.0, 214.0).lerp(DVec3::new(232.0, 24.0, 108.0), share);
    hue.lerp(WHITE, [0.0, 0.42, 0.2][index % 3])
}

fn tint(height_m: f64) -> DVec3 {
    let above = TINTS.partition_point(|(from_m, _)| *from_m < height_m);
    let [low, high] = [above.saturating_sub(1), above].map(|at| TINTS[at.min(TINTS.len() - 1)]);
    let share = (height_m - low.0) / (high.0 - low.0).max(1.0);
    DVec3::from(low.1).lerp(DVec3::from(high.1), share.clamp(0.0, 1.0))
}

/// Of ground that rises so steeply to the east and to the north; 1 where it is level.
fn brightness(east: f64, north: f64) -> f64 {
    let normal = DVec3::new(-east, -north, 1.0).normalize();
    AMBIENT + (1.0 - AMBIENT) * normal.dot(LIGHT).max(0.0) / LIGHT.z
}

/// Of the samples of a pixel.
fn mean(sample: impl Fn(usize, usize) -> DVec3) -> DVec3 {
    let side = 0..SAMPLES_A_SIDE;
    let all = side.clone().flat_map(|y| side.clone().map(move |x| (x, y)));
    let sum: DVec3 = all.map(|(x, y)| sample(x, y).min(WHITE)).sum();
    sum / (SAMPLES_A_SIDE * SAMPLES_A_SIDE) as f64
}

#[allow(clippy::cast_possible_truncation, reason = "clamped to 0 … 255")]
fn write(pixel: &mut [u8], colour: DVec3) {
    for (channel, value) in pixel.iter_mut().zip(colour.to_array()) {
        *channel = value.round().clamp(0.0, 255.0) as u8;
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "a share of a count of pixels"
)]
fn share_of(pixels: usize, share: f64) -> usize {
    (pixels as f64 * share) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_to_the_north_west_are_bright_and_those_to_the_south_east_dark() {
        assert!((brightness(0.0, 0.0) - 1.0).abs() < 1e-12);
        // Ground that falls to the north-west rises to the east and to the south.
        assert!(brightness(0.5, -0.5) > 1.1);
        assert!(brightness(-0.5, 0.5) < 0.7);
        // Neither: the light comes from the side.
        assert!((brightness(0.5, 0.5) - brightness(-0.5, -0.5)).abs() < 1e-12);
    }

    #[test]
    fn the_sea_is_blue_low_land_green_and_summits_white() {
        let [sea, coast, summit] = [-0.1, 0.1, 8_849.0].map(tint);
        assert!(sea.z > sea.x + 50.0, "{sea}");
        assert!(coast.y > coast.x && coast.y > coast.z, "{coast}");
        assert!(summit.min_element() > 240.0, "{summit}");
        // In between nothing jumps but the coast.
        let jumps = (-7_100..8_000).filter(|height| {
            (tint(f64::from(*height)) - tint(f64::from(height + 1))).length() > 5.0
        });
        assert_eq!(jumps.collect::<Vec<_>>(), [0]);
    }
}
