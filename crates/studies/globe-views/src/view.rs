// SPDX-License-Identifier: MIT OR Apache-2.0
//! Views of a globe: where the eye is, as lists of views say it, and the rays of its pixels.

use glam::DVec3;
use rayon::prelude::*;
use serde::Deserialize;
use terrafill_contract::{SurfaceView, ViewId};
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_scene::{Camera, CameraPose, ImageSize};
use terrafill_study::Depth;
use terrafill_surface::SurfaceFrame;

/// Of every view, degrees: that of the facts that the figures are held against.
const FOV_DEG: f64 = 60.0;
/// Near plane over the eye's height: the ground that a view shows is farther than that.
const NEAR_SHARE: f64 = 0.1;

/// Where the eye is.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewRow {
    /// As cases have it.
    pub name: String,
    /// East of Greenwich.
    pub longitude_deg: f64,
    /// Geodetic.
    pub latitude_deg: f64,
    /// Above the ellipsoid, or above ground of a height.
    pub height_m: f64,
    /// Above the horizontal plane; −90 looks straight down.
    pub pitch_deg: f64,
    /// Whether a quick run has it.
    #[serde(default)]
    pub quick: bool,
    /// Whether only a full run has it.
    #[serde(default)]
    pub full: bool,
    /// Whether frames over every published number of cells are timed there: the ground must fill it.
    #[serde(default)]
    pub all_cells: bool,
    /// Whether frames choose their tiles there.
    #[serde(default)]
    pub chosen: bool,
}

/// An eye over a body, and an image.
#[derive(Debug, Clone, Copy)]
pub struct Eye {
    /// What is looked at.
    pub body: Ellipsoid,
    /// Where the eye is, by longitude, latitude and height.
    pub pose: CameraPose,
    /// The same in ECEF axes, metres.
    pub camera: Camera,
    /// Of the image, pixels.
    pub size: ImageSize,
}

impl Eye {
    /// Pixels per radian in the image's middle.
    pub fn focal_px(&self) -> f64 {
        0.5 * f64::from(self.size.height) / self.camera.tan_half_fov()
    }

    /// The place on the body below another one, along the geodetic normal: ECEF, metres.
    pub fn below(&self, place: Geodetic) -> DVec3 {
        self.body.geodetic_to_ecef(Geodetic {
            height_m: 0.0,
            ..place
        })
    }

    /// The place on the body below it, where the body is the unit sphere.
    pub fn foot(&self) -> DVec3 {
        self.below(self.pose.eye) / self.body.radii_m()
    }

    /// What a device is given to draw a surface with.
    pub fn view<'a>(&'a self, surface: &'a SurfaceFrame) -> SurfaceView<'a> {
        SurfaceView {
            id: ViewId::unique(),
            body: &self.body,
            camera: &self.camera,
            size: self.size,
            surface,
            picture: None,
            draws_back_faces: false,
        }
    }

    /// What each pixel gives, row by row.
    ///
    /// - `of`: from a pixel's number, its centre in pixels, and its ray's direction of unit view depth
    pub fn by_pixel<T: Send>(&self, of: impl Fn(usize, [f64; 2], DVec3) -> T + Sync) -> Vec<T> {
        self.by_pixel_with(|(), pixel, centre, direction| of(pixel, centre, direction))
    }

    /// The same with what one pixel leaves to the next of its row, mostly.
    pub fn by_pixel_with<S: Default, T: Send>(
        &self,
        of: impl Fn(&mut S, usize, [f64; 2], DVec3) -> T + Sync,
    ) -> Vec<T> {
        let width = self.size.width as usize;
        let one = |known: &mut S, pixel: usize| {
            let centre = [pixel % width, pixel / width].map(|at| at as f64 + 0.5);
            let direction = self.camera.direction_ecef(self.size, centre);
            of(known, pixel, centre, direction)
        };
        let pixels = (0..self.size.pixel_count()).into_par_iter();
        pixels.map_init(S::default, one).collect()
    }
}

impl ViewRow {
    /// Whether a run has it.
    pub fn is_planned(&self, depth: Depth) -> bool {
        match depth {
            Depth::Quick => self.quick,
            Depth::Main => !self.full,
            Depth::Full => true,
        }
    }

    /// The eye over the Earth, in a square image.
    pub fn eye(&self, side_px: u32) -> Eye {
        self.eye_above(0.0, side_px)
    }

    /// The same over ground of that height.
    pub fn eye_above(&self, ground_m: f64, side_px: u32) -> Eye {
        let body = Ellipsoid::WGS84;
        let height_m = ground_m + self.height_m;
        let pose = CameraPose {
            eye: Geodetic::from_degrees(self.longitude_deg, self.latitude_deg, height_m),
            heading_rad: 0.0,
            pitch_rad: self.pitch_deg.to_radians(),
            fov_y_rad: FOV_DEG.to_radians(),
            near_m: NEAR_SHARE * self.height_m,
        };
        Eye {
            body,
            pose,
            camera: Camera::new(&body, &pose),
            size: ImageSize::new(side_px, side_px),
        }
    }
}
