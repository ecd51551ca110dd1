// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured: views, and surfaces through their knobs, read from `plan.toml`.

use glam::DVec3;
use rayon::prelude::*;
use serde::Deserialize;
use terrafill_contract::{SurfaceView, ViewId};
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_scene::{Camera, CameraPose, ImageSize};
use terrafill_study::Depth;
use terrafill_surface::SurfaceFrame;
use toml::{Table, Value};

/// The study's own list.
const PLAN: &str = include_str!("../plan.toml");

/// Of every view, degrees: that of the facts that the figures are held against.
const FOV_DEG: f64 = 60.0;
/// Near plane over the eye's height: the ground that a view shows is farther than that.
const NEAR_SHARE: f64 = 0.1;

/// Views and surfaces.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct List {
    pub(crate) view: Vec<ViewRow>,
    pub(crate) surface: Vec<SurfaceRow>,
    /// Under tiles of a map.
    pub(crate) tiled_view: Vec<ViewRow>,
    /// Of the globe of five layers.
    pub(crate) shaded_view: Vec<ShadedRow>,
}

/// Where the eye is.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ViewRow {
    pub(crate) name: String,
    pub(crate) longitude_deg: f64,
    pub(crate) latitude_deg: f64,
    pub(crate) height_m: f64,
    pub(crate) pitch_deg: f64,
    /// Whether a quick run has it.
    #[serde(default)]
    pub(crate) quick: bool,
    /// Whether only a full run has it.
    #[serde(default)]
    pub(crate) full: bool,
    /// Whether frames over every published number of cells are timed there: the ground must fill it.
    #[serde(default)]
    pub(crate) all_cells: bool,
    /// Whether frames choose their tiles there.
    #[serde(default)]
    pub(crate) chosen: bool,
}

/// Where the eye is, over which place the sun stands, and how long clouds have moved.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShadedRow {
    pub(crate) name: String,
    longitude_deg: f64,
    latitude_deg: f64,
    height_m: f64,
    pitch_deg: f64,
    sun_longitude_deg: f64,
    sun_latitude_deg: f64,
    pub(crate) hours: u32,
}

impl ShadedRow {
    /// The eye over the Earth, in a square image.
    pub(crate) fn eye(&self, side_px: u32) -> Eye {
        let view = ViewRow {
            longitude_deg: self.longitude_deg,
            latitude_deg: self.latitude_deg,
            height_m: self.height_m,
            pitch_deg: self.pitch_deg,
            ..ViewRow::default()
        };
        view.eye(side_px)
    }

    /// Towards the sun, of length 1.
    pub(crate) fn sun(&self) -> DVec3 {
        let [longitude, latitude] =
            [self.sun_longitude_deg, self.sun_latitude_deg].map(f64::to_radians);
        let level = DVec3::new(longitude.cos(), longitude.sin(), 0.0);
        level * latitude.cos() + DVec3::Z * latitude.sin()
    }
}

/// A surface through its knob.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SurfaceRow {
    pub(crate) name: String,
    pub(crate) kind: String,
    pub(crate) knob: String,
    values: Vec<Value>,
    quick: Vec<Value>,
    /// Those that only a full run has.
    #[serde(default)]
    full: Vec<Value>,
    #[serde(default)]
    pub(crate) expected: Formula,
    /// Whether it has cracks, in which device and rays may differ.
    #[serde(default)]
    pub(crate) cracks: bool,
    /// Further parameters.
    #[serde(default)]
    pub(crate) with: Table,
}

/// What a surface's error is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Formula {
    #[default]
    None,
    Uniform,
    Spiral,
    ScreenGrid,
    ScreenError,
    CellShare,
}

impl SurfaceRow {
    /// The knob's values of a run.
    pub(crate) fn values(&self, depth: Depth) -> Vec<Value> {
        let values = self.values.iter();
        let planned = values.filter(|value| match depth {
            Depth::Quick => self.quick.contains(value),
            Depth::Main => !self.full.contains(value),
            Depth::Full => true,
        });
        planned.cloned().collect()
    }
}

impl List {
    /// # Errors
    /// What is wrong with the text, with its line.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|error| error.to_string())
    }

    /// # Errors
    /// As [`List::parse`].
    pub(crate) fn shipped() -> Result<Self, String> {
        Self::parse(PLAN)
    }

    /// # Errors
    /// That there is no view of this name.
    pub(crate) fn view(&self, name: &str) -> Result<&ViewRow, String> {
        let mut views = self.view.iter();
        let view = views.find(|view| view.name == name);
        view.ok_or_else(|| format!("no view is called {name:?}"))
    }

    /// # Errors
    /// As [`List::view`].
    pub(crate) fn shaded(&self, name: &str) -> Result<&ShadedRow, String> {
        let mut views = self.shaded_view.iter();
        let view = views.find(|view| view.name == name);
        view.ok_or_else(|| format!("no shaded view is called {name:?}"))
    }
}

/// An eye over a body, and an image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Eye {
    pub(crate) body: Ellipsoid,
    pub(crate) pose: CameraPose,
    pub(crate) camera: Camera,
    pub(crate) size: ImageSize,
}

impl Eye {
    /// Pixels per radian in the image's middle.
    pub(crate) fn focal_px(&self) -> f64 {
        0.5 * f64::from(self.size.height) / self.camera.tan_half_fov()
    }

    /// The place on the body below another one, along the geodetic normal.
    pub(crate) fn below(&self, place: Geodetic) -> DVec3 {
        self.body.geodetic_to_ecef(Geodetic {
            height_m: 0.0,
            ..place
        })
    }

    /// The place on the body below it, where the body is the unit sphere.
    pub(crate) fn foot(&self) -> DVec3 {
        self.below(self.pose.eye) / self.body.radii_m()
    }

    /// It over a surface as drawn.
    pub(crate) fn view<'a>(&'a self, surface: &'a SurfaceFrame) -> SurfaceView<'a> {
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
    pub(crate) fn by_pixel<T: Send>(
        &self,
        of: impl Fn(usize, [f64; 2], DVec3) -> T + Sync,
    ) -> Vec<T> {
        self.by_pixel_with(|(), pixel, centre, direction| of(pixel, centre, direction))
    }

    /// The same with what one pixel leaves to the next of its row, mostly.
    pub(crate) fn by_pixel_with<S: Default, T: Send>(
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
    pub(crate) fn is_planned(&self, depth: Depth) -> bool {
        match depth {
            Depth::Quick => self.quick,
            Depth::Main => !self.full,
            Depth::Full => true,
        }
    }

    /// The eye over the Earth, in a square image.
    pub(crate) fn eye(&self, side_px: u32) -> Eye {
        self.eye_above(0.0, side_px)
    }

    /// The same over ground of that height.
    pub(crate) fn eye_above(&self, ground_m: f64, side_px: u32) -> Eye {
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

/// A knob's value as a number.
pub(crate) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(whole) => Some(*whole as f64),
        Value::Float(number) => Some(*number),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_list_has_numbers_for_knobs_and_no_name_twice() {
        let list = List::shipped().expect("a list");
        let mut names: Vec<&str> = list.surface.iter().map(|row| row.name.as_str()).collect();
        names.extend(list.view.iter().map(|row| row.name.as_str()));
        names.extend(list.shaded_view.iter().map(|row| row.name.as_str()));
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        for row in &list.surface {
            assert!(row.values.iter().all(|value| number(value).is_some()));
            let [quick, main, full] =
                [Depth::Quick, Depth::Main, Depth::Full].map(|at| row.values(at));
            assert_eq!((quick.len(), &full), (row.quick.len(), &row.values));
            // What is quick is at the default depth too, and what is named for a full run is a value.
            assert!(
                quick.iter().all(|value| main.contains(value)),
                "{}",
                row.name
            );
            assert_eq!(main.len() + row.full.len(), full.len(), "{}", row.name);
        }
        assert!(list.view.iter().any(|view| view.quick));
        let views = list.view.iter().chain(&list.tiled_view);
        assert!(views.clone().all(|view| !(view.quick && view.full)));
        assert!(views.clone().any(|view| view.full));
        // Negative control: a key that there is not, and a formula that there is not.
        let wrong = PLAN.replacen("pitch_deg", "pitch", 1);
        assert!(List::parse(&wrong).is_err_and(|error| error.contains("pitch")));
        let wrong = PLAN.replacen("\"uniform\"", "\"uniformly\"", 2);
        assert!(List::parse(&wrong).is_err());
    }
}
