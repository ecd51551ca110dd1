// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a pixel's texels come from, and its colour, by the words of the scene.
//!
//! Longitude and latitude of the exact hit, texture coordinates by the formula of the placement, and
//! the level of detail from derivatives in closed form, so that nothing depends on what the
//! neighbouring pixels show. ECEF metres, radians, `f64`. Shares neither the affine map of angles
//! nor any approximation with the backends.
//!
//! The footprint is that of the tangent plane of the body's normal at the hit: a step to the next
//! column or row moves the point where the pixel's ray meets that plane.

use crate::extent::RegionExtent;
use crate::sampling::{Rgba, Sampler, mix};
use glam::DVec3;
use std::f64::consts::TAU;
use terrafill_contract::{AddressMode, FillInput, TextureCoordinates, TexturePixel};
use terrafill_core::Ellipsoid;
use terrafill_scene::{Camera, ImageSize, Outside, SceneTexture, TextureAnchor, TexturePlacement};

/// Cosine between ray and normal below which a footprint grows no longer: at this one it is longer
/// than any body is wide in pixels, and at 0 it would be no number.
const GRAZING_COSINE: f64 = 1e-9;
/// Cosine of the latitude below which a step of longitude grows no longer, for the same reason.
const POLAR_COSINE: f64 = 1e-12;

/// A scene's texture, ready for hits.
pub(crate) struct Texturing<'a> {
    texture: &'a SceneTexture,
    sampler: Sampler<'a>,
    body: Ellipsoid,
    camera: Camera,
    size: ImageSize,
    extents: Vec<RegionExtent>,
}

/// Longitude, latitude and what one metre east or north changes them by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePoint {
    pub(crate) longitude: f64,
    pub(crate) latitude: f64,
    pub(crate) radians_per_m_east: f64,
    pub(crate) radians_per_m_north: f64,
    east: DVec3,
    north: DVec3,
    normal: DVec3,
}

/// Radii of curvature in the prime vertical and in the meridian, metres.
fn curvature_radii_m(body: &Ellipsoid, latitude: f64) -> [f64; 2] {
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    let (sin, cos) = latitude.sin_cos();
    // a² cos² + b² sin²: both radii of an ellipse written without its eccentricity.
    let squared = (a * cos).powi(2) + (b * sin).powi(2);
    let root = squared.sqrt();
    [a * a / root, (a * b).powi(2) / (squared * root)]
}

impl SurfacePoint {
    /// By the fixed point of `tan φ = (z + e² N sin φ) / ρ`: every step divides the error by at
    /// least 1/e², 5 for Saturn and 149 for the Earth.
    pub(crate) fn new(body: &Ellipsoid, ecef: DVec3) -> Self {
        let ratio = body.polar_radius_m() / body.equatorial_radius_m();
        let e2 = (1.0 - ratio) * (1.0 + ratio);
        let rho = ecef.x.hypot(ecef.y);
        let mut latitude = ecef.z.atan2(rho * ratio * ratio);
        let mut height_m = 0.0;
        for _ in 0..64 {
            let [prime_vertical_m, _] = curvature_radii_m(body, latitude);
            let above_foot_m = ecef.z + e2 * prime_vertical_m * latitude.sin();
            let next = above_foot_m.atan2(rho);
            height_m = above_foot_m.hypot(rho) - prime_vertical_m;
            let moved = (next - latitude).abs();
            latitude = next;
            if moved < 1e-16 {
                break;
            }
        }
        let longitude = if rho > 0.0 { ecef.y.atan2(ecef.x) } else { 0.0 };
        let (sin_lon, cos_lon) = longitude.sin_cos();
        let (sin_lat, cos_lat) = latitude.sin_cos();
        let [prime_vertical_m, meridian_m] = curvature_radii_m(body, latitude);
        Self {
            longitude,
            latitude,
            radians_per_m_east: 1.0 / ((prime_vertical_m + height_m) * cos_lat.max(POLAR_COSINE)),
            radians_per_m_north: 1.0 / (meridian_m + height_m),
            east: DVec3::new(-sin_lon, cos_lon, 0.0),
            north: DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
            normal: DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
        }
    }
}

/// `angle` less whole turns, as near to 0 as it gets.
fn unwound(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Texture coordinates and their derivatives by longitude and latitude.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coordinates {
    pub(crate) uv: [f64; 2],
    /// Of `u`, then of `v`: by longitude and by latitude.
    pub(crate) by_angle: [[f64; 2]; 2],
}

impl<'a> Texturing<'a> {
    /// `None` where the scene has no texture.
    pub(crate) fn new(input: &'a FillInput) -> Option<Self> {
        let texture = input.scene.texture.as_deref()?;
        let rule = input.scene.edge_rule;
        let extents = input.scene.regions.iter();
        Some(Self {
            texture,
            sampler: Sampler::new(&texture.image),
            body: input.scene.body,
            camera: input.camera,
            size: input.size,
            extents: extents
                .map(|region| RegionExtent::new(region, rule, &input.scene.body))
                .collect(),
        })
    }

    #[cfg(test)]
    pub(crate) fn extent(&self, region: usize) -> &RegionExtent {
        &self.extents[region]
    }

    pub(crate) fn address(&self, region: usize) -> [AddressMode; 2] {
        match self.texture.placement {
            TexturePlacement::Extents if self.extents[region].is_round() => {
                [AddressMode::Repeat, AddressMode::ClampToEdge]
            }
            TexturePlacement::Extents => [AddressMode::ClampToEdge; 2],
            TexturePlacement::Anchor {
                outside: Outside::Transparent,
                ..
            } => [AddressMode::Transparent; 2],
            TexturePlacement::Anchor { .. } | TexturePlacement::Pattern { .. } => {
                [AddressMode::Repeat; 2]
            }
        }
    }

    /// With the pixels' coordinates.
    pub(crate) fn coordinates(&self, pixels: Vec<Option<TexturePixel>>) -> TextureCoordinates {
        TextureCoordinates {
            texels: self.texture.image.size_px(),
            address: (0..self.extents.len())
                .map(|region| self.address(region))
                .collect(),
            pixels,
        }
    }

    /// Texture coordinates of a point of `region`.
    ///
    /// Its longitude is taken within half a turn of the middle of the region's extent. Inside the
    /// region that is the same as from its western end on. A pixel that rounding put an inch beyond
    /// the border does not see the far end of the picture.
    pub(crate) fn at(&self, region: usize, point: &SurfacePoint) -> Coordinates {
        let extent = &self.extents[region];
        let middle = extent.middle_longitude();
        let longitude = middle + unwound(point.longitude - middle);
        match self.texture.placement {
            TexturePlacement::Extents => {
                let width = extent.east - extent.west;
                let height = extent.north - extent.south;
                Coordinates {
                    uv: [
                        (longitude - extent.west) / width,
                        (extent.north - point.latitude) / height,
                    ],
                    by_angle: [[1.0 / width, 0.0], [0.0, -1.0 / height]],
                }
            }
            TexturePlacement::Anchor {
                anchor,
                width_m,
                height_m,
                ..
            } => {
                let turns = middle + unwound(anchor.longitude_rad - middle);
                self.anchored(&anchor, [width_m, height_m], longitude - turns, point)
            }
            TexturePlacement::Pattern { anchor, .. } => {
                let turns = middle + unwound(anchor.longitude_rad - middle);
                let size_m = self.texture.image.size_px().map(f64::from);
                self.anchored(&anchor, size_m, longitude - turns, point)
            }
        }
    }

    /// For a picture of a size in metres, `dlon` east of its anchor.
    fn anchored(
        &self,
        anchor: &TextureAnchor,
        [width_m, height_m]: [f64; 2],
        dlon: f64,
        point: &SurfacePoint,
    ) -> Coordinates {
        let [prime_vertical_m, meridian_m] = curvature_radii_m(&self.body, anchor.latitude_rad);
        let m_per_lon = prime_vertical_m * anchor.latitude_rad.cos();
        let x = dlon * m_per_lon;
        let y = (point.latitude - anchor.latitude_rad) * meridian_m;
        let (sin, cos) = anchor.rotation_rad.sin_cos();
        Coordinates {
            uv: [
                0.5 + (x * cos - y * sin) / width_m,
                0.5 - (x * sin + y * cos) / height_m,
            ],
            by_angle: [
                [m_per_lon * cos / width_m, -meridian_m * sin / width_m],
                [-m_per_lon * sin / height_m, -meridian_m * cos / height_m],
            ],
        }
    }

    /// Where the texels of a pixel of `region` come from.
    ///
    /// - `direction`: the pixel's ray, 1 along the viewing axis
    /// - `depth`: of the hit along it
    pub(crate) fn pixel(&self, region: usize, direction: DVec3, depth: f64) -> TexturePixel {
        let from_eye = direction * depth;
        let point = SurfacePoint::new(&self.body, self.camera.eye_ecef + from_eye);
        let coordinates = self.at(region, &point);
        let distance_m = from_eye.length();
        let footprint_texels = self
            .footprints(&point, &coordinates, direction, depth)
            .map(|[u, v]| u.hypot(v))
            .into_iter()
            .fold(0.0, f64::max);
        let pattern_level = self.pattern_level(distance_m);
        TexturePixel {
            uv: coordinates.uv,
            pattern_level,
            footprint_texels,
            level: self
                .sampler
                .level(footprint_texels * (-pattern_level.floor()).exp2()),
            distance_m,
        }
    }

    /// How far a step to the next column and to the next row moves, in texels of `u` and `v`.
    pub(crate) fn footprints(
        &self,
        point: &SurfacePoint,
        coordinates: &Coordinates,
        direction: DVec3,
        depth: f64,
    ) -> [[f64; 2]; 2] {
        let steps = pixel_steps(&self.camera, self.size);
        let texels = self.texture.image.size_px().map(f64::from);
        steps.map(|step| {
            let along = point.normal.dot(direction);
            let least = GRAZING_COSINE * direction.length();
            let along = along.abs().max(least).copysign(along);
            // The ray of the next pixel meets the plane where its component along the normal is
            // the same: depth · (step − direction · (n · step) / (n · direction)).
            let moved = (step - direction * (point.normal.dot(step) / along)) * depth;
            let dlon = moved.dot(point.east) * point.radians_per_m_east;
            let dlat = moved.dot(point.north) * point.radians_per_m_north;
            let [u, v] = coordinates.by_angle;
            [
                (u[0] * dlon + u[1] * dlat) * texels[0],
                (v[0] * dlon + v[1] * dlat) * texels[1],
            ]
        })
    }

    /// The `k` at which a pixel at a distance spans as many texels as the pattern says.
    pub(crate) fn pattern_level(&self, distance_m: f64) -> f64 {
        let TexturePlacement::Pattern { texels_per_px, .. } = self.texture.placement else {
            return 0.0;
        };
        let m_per_px = distance_m * 2.0 * (self.camera.fov_y_rad / 2.0).tan();
        (m_per_px / f64::from(self.size.height) / texels_per_px).log2()
    }

    /// Colour in linear light and opacity of a pixel: the picture's at its coordinates, times the
    /// scene's opacity, less what the distance takes.
    pub(crate) fn colour(&self, region: usize, pixel: &TexturePixel) -> Rgba {
        let address = self.address(region);
        let [r, g, b, alpha] = match self.texture.placement {
            TexturePlacement::Pattern { .. } => {
                let finer = pixel.pattern_level.floor();
                let at = |whole: f64| {
                    let scale = (-whole).exp2();
                    let level = self.sampler.level(pixel.footprint_texels * scale);
                    let uv = pixel.uv.map(|coordinate| coordinate * scale);
                    self.sampler.sample(uv, level, address)
                };
                mix(at(finer), at(finer + 1.0), pixel.pattern_level - finer)
            }
            _ => self.sampler.sample(pixel.uv, pixel.level, address),
        };
        let fade = self.texture.fade_m.map_or(1.0, |[begin, end]| {
            ((end - pixel.distance_m) / (end - begin)).clamp(0.0, 1.0)
        });
        [r, g, b, alpha * self.texture.alpha * fade]
    }
}

/// What a step to the next column and to the next row adds to a pixel's direction.
fn pixel_steps(camera: &Camera, size: ImageSize) -> [DVec3; 2] {
    let axes = camera.view_from_ecef.transpose();
    let image_height = 2.0 * (camera.fov_y_rad / 2.0).tan();
    let pixel = image_height / f64::from(size.height);
    let stretch = size.aspect() * f64::from(size.height) / f64::from(size.width);
    [axes.x_axis * (pixel * stretch), axes.y_axis * -pixel]
}
