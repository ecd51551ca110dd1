// SPDX-License-Identifier: MIT OR Apache-2.0
//! Values of a scene file checked, and the complaints worded.

use super::raw::{RawImage, RawLevels, RawMesh, RawRegions, RawSurfaceFile, RawView};
use super::sources::{RegionSource, SurfaceSource};
use crate::scene::{SurfaceFile, View};
use crate::shipped;
use crate::suite::Expectation;
use crate::{CameraPose, DataFile, DataNeed, LevelChoice, SceneError, choices};
use std::ops::RangeInclusive;
use terrafill_core::{Ellipsoid, Geodetic, MeshOptions, Repair};

/// Vertical field of view where a view names none, degrees.
const DEFAULT_FOV_DEG: f64 = 60.0;
/// Distance of the near plane where a view names none, share of the eye's height: far below
/// anything a camera above the surface can see, and reversed depth keeps its precision.
const DEFAULT_NEAR_SHARE: f64 = 1e-3;
/// Largest edge of a cap triangle, degrees: beyond 30° a facet sags by hundreds of kilometres.
const CAP_STEP_LIMIT_DEG: f64 = 30.0;

/// Checks values and words the complaints.
pub(super) struct Check<'a> {
    pub(super) file: &'a str,
}

impl Check<'_> {
    pub(super) fn refuse(
        &self,
        key: impl Into<String>,
        found: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> SceneError {
        SceneError::Value {
            file: self.file.to_owned(),
            key: key.into(),
            found: found.to_string(),
            allowed: allowed.into(),
        }
    }

    /// A name that is none of some.
    pub(super) fn refuse_name<'n>(
        &self,
        key: &str,
        found: &str,
        names: impl IntoIterator<Item = &'n str>,
    ) -> SceneError {
        self.refuse(key, format!("{found:?}"), choices(found, names))
    }

    /// Names become parts of file names and CSV cells.
    pub(super) fn name(&self, key: &str, name: String) -> Result<String, SceneError> {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if !name.is_empty() && name.chars().all(plain) {
            return Ok(name);
        }
        Err(self.refuse(key, format!("{name:?}"), "lower-case letters, digits and -"))
    }

    pub(super) fn body(&self, name: &str) -> Result<Ellipsoid, SceneError> {
        let allowed = Ellipsoid::ALL.map(|body| body.name());
        Ellipsoid::by_name(name).ok_or_else(|| self.refuse_name("body", name, allowed))
    }

    /// One of two values by its name; the first where the key is absent.
    pub(super) fn choice<T: Copy, const COUNT: usize>(
        &self,
        key: &str,
        found: Option<&str>,
        values: [T; COUNT],
        name_of: fn(T) -> &'static str,
    ) -> Result<T, SceneError> {
        let Some(found) = found else {
            return Ok(values[0]);
        };
        values
            .into_iter()
            .find(|value| name_of(*value) == found)
            .ok_or_else(|| self.refuse_name(key, found, values.map(name_of)))
    }

    pub(super) fn within(
        &self,
        key: impl Into<String>,
        value: f64,
        range: RangeInclusive<f64>,
    ) -> Result<f64, SceneError> {
        // NaN and infinities are valid TOML; no range contains a NaN.
        if range.contains(&value) && value.is_finite() {
            return Ok(value);
        }
        let allowed = format!("{} to {}", range.start(), range.end());
        Err(self.refuse(key, value, allowed))
    }

    pub(super) fn positive(&self, key: impl Into<String>, value: f64) -> Result<f64, SceneError> {
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(self.refuse(key, value, "greater than 0"))
    }

    pub(super) fn count(
        &self,
        key: &str,
        value: i64,
        range: RangeInclusive<i64>,
    ) -> Result<u32, SceneError> {
        let allowed = format!("{} to {}", range.start(), range.end());
        u32::try_from(value)
            .ok()
            .filter(|_| range.contains(&value))
            .ok_or_else(|| self.refuse(key, value, allowed))
    }

    /// What is made of rings that cross, if not refused.
    pub(super) fn repair(&self, found: Option<&str>) -> Result<Option<Repair>, SceneError> {
        let key = "regions.repair";
        let repair = found.map(|_| self.choice(key, found, Repair::ALL, Repair::name));
        repair.transpose()
    }

    pub(super) fn region_source(&self, raw: RawRegions) -> Result<RegionSource, SceneError> {
        let given: Vec<&str> = [
            ("file", raw.file.is_some()),
            ("embedded", raw.embedded.is_some()),
            ("inline", raw.inline.is_some()),
            ("procedural", raw.procedural.is_some()),
        ]
        .into_iter()
        .filter_map(|(key, is_given)| is_given.then_some(key))
        .collect();
        if raw.file.is_none() {
            let stray = [
                ("sha256", raw.sha256.is_some()),
                ("source", raw.source.is_some()),
                ("how", raw.how.is_some()),
            ];
            if let Some((key, _)) = stray.into_iter().find(|(_, is_given)| *is_given) {
                return Err(self.refuse(
                    format!("regions.{key}"),
                    "a value",
                    "only together with file",
                ));
            }
        }
        match (raw.file, raw.embedded, raw.inline, raw.procedural) {
            (Some(file), None, None, None) => {
                self.file_source(file, raw.sha256, raw.source.map(DataFile::from), raw.how)
            }
            (None, Some(name), None, None) => match shipped::data_text(&name) {
                Some(text) => Ok(RegionSource::Embedded { name, text }),
                None => Err(self.refuse(
                    "regions.embedded",
                    format!("{name:?}"),
                    shipped::data_names().join(", "),
                )),
            },
            (None, None, Some(text), None) => Ok(RegionSource::Inline(text)),
            (None, None, None, Some(procedural)) => {
                Ok(RegionSource::Generated(self.procedural(procedural)?))
            }
            _ => {
                let found = if given.is_empty() {
                    "none".to_owned()
                } else {
                    given.join(" and ")
                };
                Err(self.refuse(
                    "regions",
                    found,
                    "exactly one of file, embedded, inline, procedural",
                ))
            }
        }
    }

    pub(super) fn file_source(
        &self,
        file: String,
        sha256: Option<String>,
        source: Option<DataFile>,
        how: Option<String>,
    ) -> Result<RegionSource, SceneError> {
        self.data_path("regions.file", &file)?;
        let sha256 = sha256.unwrap_or_default();
        self.hash("regions.sha256", &sha256)?;
        if let Some(source) = &source {
            self.data_path("regions.source.file", &source.path)?;
            if source.sha256.is_empty() {
                let allowed = "64 lower-case hexadecimal digits";
                return Err(self.refuse("regions.source.sha256", "nothing", allowed));
            }
            self.hash("regions.source.sha256", &source.sha256)?;
        }
        let how = how.unwrap_or_else(|| format!("put {file} into the data folder"));
        let file = DataFile { path: file, sha256 };
        let need = DataNeed { file, source };
        Ok(RegionSource::File { need, how })
    }

    pub(super) fn data_path(&self, key: &str, file: &str) -> Result<(), SceneError> {
        if !file.is_empty() {
            return Ok(());
        }
        let allowed = "an absolute path, or one from the scene file or the data folder";
        Err(self.refuse(key, "nothing", allowed))
    }

    pub(super) fn hash(&self, key: &str, sha256: &str) -> Result<(), SceneError> {
        let is_digit = |c: char| matches!(c, '0'..='9' | 'a'..='f');
        if sha256.is_empty() || sha256.len() == 64 && sha256.chars().all(is_digit) {
            return Ok(());
        }
        Err(self.refuse(
            key,
            format!("{sha256:?}"),
            "64 lower-case hexadecimal digits",
        ))
    }

    /// Files with their way to the user, checked.
    pub(super) fn surface_files(
        &self,
        raw: Vec<RawSurfaceFile>,
    ) -> Result<Vec<SurfaceSource>, SceneError> {
        let files = raw.into_iter().enumerate();
        let files = files.map(|(i, file)| self.surface_file(&format!("surface.files[{i}]"), file));
        files.collect()
    }

    pub(super) fn surface_file(
        &self,
        key: &str,
        raw: RawSurfaceFile,
    ) -> Result<SurfaceSource, SceneError> {
        match (raw.path, raw.embedded) {
            (Some(path), None) => {
                let sha256 = raw.sha256.unwrap_or_default();
                self.data_path(&format!("{key}.path"), &path)?;
                self.hash(&format!("{key}.sha256"), &sha256)?;
                Ok(SurfaceSource::Data(RawImage {
                    path,
                    sha256,
                    how: raw.how,
                }))
            }
            (None, Some(name)) => {
                if raw.sha256.is_some() || raw.how.is_some() {
                    let allowed = "sha256 and how only together with path";
                    return Err(self.refuse(key, "embedded with them", allowed));
                }
                match shipped::height_bytes(&name) {
                    Some(bytes) => Ok(SurfaceSource::Shipped(SurfaceFile {
                        path: name,
                        bytes: bytes.into(),
                    })),
                    None => Err(self.refuse(
                        format!("{key}.embedded"),
                        format!("{name:?}"),
                        shipped::height_names().join(", "),
                    )),
                }
            }
            (path, _) => {
                let found = if path.is_some() { "both" } else { "neither" };
                Err(self.refuse(key, found, "exactly one of path, embedded"))
            }
        }
    }

    pub(super) fn mesh(&self, raw: &RawMesh) -> Result<MeshOptions, SceneError> {
        let default = MeshOptions::default();
        let cap_step_deg = raw.cap_step_deg.unwrap_or(default.cap_step_deg);
        let cap_step_deg = self.cap_step("mesh.cap_step_deg", cap_step_deg)?;
        Ok(MeshOptions {
            boundary_tolerance_m: self.positive(
                "mesh.boundary_tolerance_m",
                raw.boundary_tolerance_m
                    .unwrap_or(default.boundary_tolerance_m),
            )?,
            cap_step_deg,
        })
    }

    pub(super) fn cap_step(&self, key: impl Into<String>, degrees: f64) -> Result<f64, SceneError> {
        if degrees > 0.0 && degrees <= CAP_STEP_LIMIT_DEG {
            return Ok(degrees);
        }
        let allowed = format!("greater than 0, at most {CAP_STEP_LIMIT_DEG}");
        Err(self.refuse(key, degrees, allowed))
    }

    /// Automatic where the scene has no `[levels]`; an empty list means level 0 alone.
    pub(super) fn levels(&self, raw: Option<RawLevels>) -> Result<LevelChoice, SceneError> {
        let Some(RawLevels { deviation_m }) = raw else {
            return Ok(LevelChoice::Automatic);
        };
        let mut above = 0.0;
        for (i, &value) in deviation_m.iter().enumerate() {
            if !(value > above && value.is_finite()) {
                let allowed = format!("greater than {above}");
                return Err(self.refuse(format!("levels.deviation_m[{i}]"), value, allowed));
            }
            above = value;
        }
        Ok(LevelChoice::Given(deviation_m))
    }

    pub(super) fn views(&self, raw: &[RawView]) -> Result<Vec<View>, SceneError> {
        if raw.is_empty() {
            return Err(self.refuse("views", "0 views", "at least 1"));
        }
        let mut views: Vec<View> = Vec::with_capacity(raw.len());
        for (i, raw_view) in raw.iter().enumerate() {
            let view = self.view(i, raw_view)?;
            if views.iter().any(|earlier| earlier.name == view.name) {
                return Err(self.refuse(
                    format!("views[{i}].name"),
                    format!("{:?} again", view.name),
                    "a name of its own",
                ));
            }
            views.push(view);
        }
        Ok(views)
    }

    /// What a suite expects of the scene and of its views is what it may expect.
    pub(super) fn expectations(
        &self,
        scene: Option<&str>,
        views: &[RawView],
    ) -> Result<(), SceneError> {
        let views = views.iter().enumerate();
        let views = views.map(|(i, view)| (format!("views[{i}].expect"), view.expect.as_deref()));
        for (key, found) in std::iter::once(("expect".to_owned(), scene)).chain(views) {
            if let Some(found) = found.filter(|found| Expectation::parse(found).is_none()) {
                return Err(self.refuse(key, format!("{found:?}"), Expectation::ALLOWED));
            }
        }
        Ok(())
    }

    pub(super) fn view(&self, index: usize, raw: &RawView) -> Result<View, SceneError> {
        let key = |name: &str| format!("views[{index}].{name}");
        // An image plane without a vanishing point needs other rays, other depths and other culls.
        if let Some(found) = raw
            .projection
            .as_ref()
            .filter(|&found| found != "perspective")
        {
            return Err(self.refuse(key("projection"), format!("{found:?}"), "perspective"));
        }
        let longitude_deg = self.within(key("longitude_deg"), raw.longitude_deg, -180.0..=180.0)?;
        let latitude_deg = self.within(key("latitude_deg"), raw.latitude_deg, -90.0..=90.0)?;
        let height_m = self.positive(key("height_m"), raw.height_m)?;
        let near_m = raw.near_m.unwrap_or(height_m * DEFAULT_NEAR_SHARE);
        // Below 1° and above 170° the image plane of a perspective projection is of no use.
        let fov_deg = raw.fov_deg.unwrap_or(DEFAULT_FOV_DEG);
        let fov_y_rad = self
            .within(key("fov_deg"), fov_deg, 1.0..=170.0)?
            .to_radians();
        Ok(View {
            name: self.name(&key("name"), raw.name.clone())?,
            pose: CameraPose {
                eye: Geodetic::from_degrees(longitude_deg, latitude_deg, height_m),
                heading_rad: self
                    .within(key("heading_deg"), raw.heading_deg, -360.0..=360.0)?
                    .to_radians(),
                pitch_rad: self
                    .within(key("pitch_deg"), raw.pitch_deg, -90.0..=90.0)?
                    .to_radians(),
                fov_y_rad,
                near_m: self.positive(key("near_m"), near_m)?,
            },
            note: raw.note.clone(),
        })
    }

    /// Every value of a knob under `[vary]`, each one allowed.
    pub(super) fn sweep(
        knob: &str,
        values: &[f64],
        allowed: impl Fn(String, f64) -> Result<f64, SceneError>,
    ) -> Result<Vec<f64>, SceneError> {
        let places = values.iter().enumerate();
        places
            .map(|(i, value)| allowed(format!("vary.{knob}[{i}]"), *value))
            .collect()
    }
}
