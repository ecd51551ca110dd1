// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured: views, and surfaces through their knobs, read from `plan.toml`.

use glam::DVec3;
use serde::Deserialize;
use terrafill_globe_views::{Eye, ViewRow};
use terrafill_study::Depth;
use toml::{Table, Value};

/// The study's own list.
const PLAN: &str = include_str!("../plan.toml");

/// Views and surfaces.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct List {
    pub(crate) view: Vec<ViewRow>,
    pub(crate) surface: Vec<SurfaceRow>,
    /// Of the globe of five layers.
    pub(crate) shaded_view: Vec<ShadedRow>,
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
    /// The knob's value at which its triangles are drawn as lines, and filled as well, so that cracks are wide; without one,
    /// lines are of the first value, and nothing is filled.
    #[serde(default)]
    pub(crate) pictured: Option<Value>,
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
            let mut values = row.values.iter().chain(&row.pictured);
            assert!(values.all(|value| number(value).is_some()));
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
        assert!(list.view.iter().all(|view| !(view.quick && view.full)));
        assert!(list.view.iter().any(|view| view.full));
        // Negative control: a key that there is not, and a formula that there is not.
        let wrong = PLAN.replacen("pitch_deg", "pitch", 1);
        assert!(List::parse(&wrong).is_err_and(|error| error.contains("pitch")));
        let wrong = PLAN.replacen("\"uniform\"", "\"uniformly\"", 2);
        assert!(List::parse(&wrong).is_err());
    }
}
