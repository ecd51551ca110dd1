// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scene files: TOML in degrees and metres in, a checked [`Scene`] in radians out.
//!
//! Everything is checked here, once. A message names the file, the key, the value found and the
//! values allowed. Keys that mean nothing are refused, since a misspelt switch would otherwise
//! measure the default under another name.

use crate::data::{Verified, read_verified};
use crate::error::syntax_error;
use crate::generated::{Cells, Coast, Nested};
use crate::procedural::Islands;
use crate::scene::{Overlap, Scene, SurfaceChoice, SurfaceFile, View};
use crate::shipped;
use crate::suite::Expectation;
use crate::texture::{
    ImageSource, MAX_SIDE_PX, MIN_HATCH_PERIOD, Outside, SceneTexture, TextureAnchor,
    TexturePlacement, TextureShare,
};
use crate::{CameraPose, DataFile, DataNeed, LevelChoice, RegionLoadError, SceneError};
use serde::Deserialize;
use std::ops::RangeInclusive;
use std::path::{Component, Path};
use std::sync::Arc;
use terrafill_core::{
    EdgeRule, Ellipsoid, Geodetic, Inside, MeshOptions, Reading, Region, Unwrap, parse_regions_as,
};

/// Vertical field of view where a view names none, degrees.
const DEFAULT_FOV_DEG: f64 = 60.0;
/// Distance of the near plane where a view names none, share of the eye's height: far below
/// anything a camera above the surface can see, and reversed depth keeps its precision.
const DEFAULT_NEAR_SHARE: f64 = 1e-3;
/// Largest edge of a cap triangle, degrees: beyond 30° a facet sags by hundreds of kilometres.
const CAP_STEP_LIMIT_DEG: f64 = 30.0;

impl Scene {
    /// Reads a scene file.
    ///
    /// - `data_dir`: where files named by the scene are; without it they count as missing
    ///
    /// # Errors
    /// [`SceneError`]; [`SceneError::DataMissing`] if only the data is missing.
    pub fn load(path: &Path, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path).map_err(|source| SceneError::Unreadable {
            path: path.to_path_buf(),
            source,
        })?;
        Self::from_toml(&text, &path.display().to_string(), data_dir)
    }

    /// A scene that ships with the program, by name.
    ///
    /// # Errors
    /// As [`Scene::load`], and [`SceneError::Unknown`].
    pub fn shipped(name: &str, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        let text = shipped::shipped_scene_text(name).ok_or_else(|| SceneError::Unknown {
            name: name.to_owned(),
            allowed: shipped::shipped_scene_names().join(", "),
        })?;
        Self::from_toml(text, &format!("bench-scenes/{name}.toml"), data_dir)
    }

    /// A scene by the name of one that ships, or by the path of a scene file (with `/` or `.toml` in it).
    ///
    /// # Errors
    /// As [`Scene::shipped`].
    pub fn open(name: &str, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        match name.contains('/') || name.ends_with(".toml") {
            true => Self::load(Path::new(name), data_dir),
            false => Self::shipped(name, data_dir),
        }
    }

    /// A scene from the text of a scene file; `file` is for messages.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_toml(text: &str, file: &str, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        let raw: RawScene =
            toml::from_str(text).map_err(|error| syntax_error(text, file, &error))?;
        let check = Check { file };
        let name = check.name("name", raw.name)?;
        check.expectations(raw.expect.as_deref(), &raw.views)?;
        let body = check.body(&raw.body)?;
        let edge_rule = check.choice(
            "edges",
            raw.edges.as_deref(),
            [EdgeRule::Planar, EdgeRule::GreatEllipse],
            EdgeRule::name,
        )?;
        let overlap = check.choice(
            "overlap",
            raw.overlap.as_deref(),
            [Overlap::Disjoint, Overlap::Ordered],
            Overlap::name,
        )?;
        let repair = check.repair(raw.regions.repair.as_deref())?;
        let reading = Reading {
            unwrap: check.choice(
                "regions.unwrap",
                raw.regions.unwrap.as_deref(),
                [Unwrap::Literal, Unwrap::Shortest],
                Unwrap::name,
            )?,
            inside: check.choice(
                "regions.inside",
                raw.regions.inside.as_deref(),
                [Inside::Smaller, Inside::Left],
                Inside::name,
            )?,
        };
        let source = check.region_source(raw.regions)?;
        let mesh = check.mesh(&raw.mesh)?;
        let levels = check.levels(raw.levels)?;
        let views = check.views(&raw.views)?;
        let vary = raw.vary.unwrap_or_default();
        let sweep_boundary_tolerance_m = Check::sweep(
            "boundary_tolerance_m",
            &vary.boundary_tolerance_m,
            |key, value| check.positive(key, value),
        )?;
        let sweep_cap_step_deg = Check::sweep("cap_step_deg", &vary.cap_step_deg, |key, value| {
            check.cap_step(key, value)
        })?;
        let sweep_positions = vary.positions;
        if sweep_positions && sweep_boundary_tolerance_m.is_empty() {
            let allowed = "false, or a list vary.boundary_tolerance_m that is not empty";
            return Err(check.refuse("vary.positions", true, allowed));
        }
        let texture = raw.texture.map(|raw| check.texture(raw)).transpose()?;
        let surface_files = check.surface_files(raw.surface.files)?;
        let picture = raw.surface.picture;
        let picture = picture.map(|raw| check.image_source("surface.picture", raw));
        let picture = picture.transpose()?;
        // Last, so that a wrong scene is reported as wrong even where its data is missing.
        let mut regions = source.regions(&name, data_dir, reading)?;
        if repair {
            for region in &mut regions {
                region.split_at_crossings(edge_rule);
            }
        }
        let texture = match texture {
            Some(texture) => Some(Arc::new(texture.load(&name, data_dir)?)),
            None => None,
        };
        let surface_files = surface_files.into_iter();
        let surface_files = surface_files
            .map(|file| load_surface_file(file, &name, data_dir))
            .collect::<Result<Vec<_>, _>>()?;
        let picture = match picture {
            Some(source) => Some(Arc::new(source.load(&name, data_dir)?)),
            None => None,
        };
        Ok(Self {
            name,
            description: raw.description,
            body,
            edge_rule,
            regions: regions.into(),
            overlap,
            mesh,
            levels,
            surface: SurfaceChoice {
                file: file.to_owned(),
                kind: raw
                    .surface
                    .kind
                    .unwrap_or_else(|| SurfaceChoice::BARE.to_owned()),
                files: surface_files,
                picture,
                parameters: raw.surface.parameters,
            },
            views,
            sweep_boundary_tolerance_m,
            texture,
            sweep_cap_step_deg,
            sweep_positions,
        })
    }
}

/// The files of the data folder that the text of a scene file names; `file` is for messages.
///
/// # Errors
/// [`SceneError::Syntax`]. Values are not checked: [`Scene::from_toml`] does that.
pub fn scene_needs(text: &str, file: &str) -> Result<Vec<DataNeed>, SceneError> {
    let raw: RawScene = toml::from_str(text).map_err(|error| syntax_error(text, file, &error))?;
    let regions = raw.regions.file.map(|path| DataNeed {
        file: DataFile {
            path,
            sha256: raw.regions.sha256.unwrap_or_default(),
        },
        source: raw.regions.source.map(DataFile::from),
    });
    let images = [
        raw.texture.and_then(|texture| texture.image),
        raw.surface.picture.and_then(|picture| picture.image),
    ];
    let images = images.into_iter().flatten();
    let images = images.map(|image| (image.path, image.sha256));
    // What ships with the program is needed from nowhere.
    let heights = raw.surface.files.into_iter();
    let heights = heights.filter_map(|file| Some((file.path?, file.sha256.unwrap_or_default())));
    let others = heights.chain(images).map(|(path, sha256)| DataNeed {
        file: DataFile { path, sha256 },
        source: None,
    });
    Ok(regions.into_iter().chain(others).collect())
}

impl Overlap {
    /// Name in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Disjoint => "disjoint",
            Self::Ordered => "ordered",
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScene {
    name: String,
    description: String,
    body: String,
    edges: Option<String>,
    overlap: Option<String>,
    regions: RawRegions,
    #[serde(default)]
    surface: RawSurface,
    #[serde(default)]
    mesh: RawMesh,
    levels: Option<RawLevels>,
    views: Vec<RawView>,
    vary: Option<RawVary>,
    texture: Option<RawTexture>,
    /// Read by [`crate::SuiteScene`].
    #[serde(rename = "reason")]
    _reason: Option<String>,
    expect: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRegions {
    file: Option<String>,
    sha256: Option<String>,
    source: Option<RawDataFile>,
    how: Option<String>,
    embedded: Option<String>,
    inline: Option<String>,
    procedural: Option<RawProcedural>,
    repair: Option<String>,
    unwrap: Option<String>,
    inside: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawDataFile {
    file: String,
    sha256: String,
}

impl From<RawDataFile> for DataFile {
    fn from(raw: RawDataFile) -> Self {
        Self {
            path: raw.file,
            sha256: raw.sha256,
        }
    }
}

/// Each kind has keys of its own.
#[derive(Deserialize)]
struct RawProcedural {
    kind: String,
    #[serde(flatten)]
    keys: toml::Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawNested {
    count: i64,
    vertices: i64,
    longitude_deg: f64,
    latitude_deg: f64,
    radius_deg: f64,
    #[serde(default)]
    as_one: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCells {
    columns: i64,
    rows: i64,
    west_deg: f64,
    south_deg: f64,
    width_deg: f64,
    height_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCoast {
    seed: i64,
    vertices: i64,
    longitude_deg: f64,
    latitude_deg: f64,
    radius_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawIslands {
    seed: i64,
    count: i64,
    min_vertices: i64,
    max_vertices: i64,
    #[serde(default)]
    lake_every: i64,
}

#[derive(Deserialize, Default)]
struct RawSurface {
    kind: Option<String>,
    #[serde(default)]
    files: Vec<RawSurfaceFile>,
    picture: Option<RawPicture>,
    #[serde(flatten)]
    parameters: toml::Table,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawMesh {
    boundary_tolerance_m: Option<f64>,
    cap_step_deg: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLevels {
    deviation_m: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawView {
    name: String,
    longitude_deg: f64,
    latitude_deg: f64,
    height_m: f64,
    heading_deg: f64,
    pitch_deg: f64,
    fov_deg: Option<f64>,
    near_m: Option<f64>,
    note: Option<String>,
    projection: Option<String>,
    expect: Option<String>,
    /// Read by [`crate::SuiteScene`].
    #[serde(rename = "size")]
    _size: Option<toml::Value>,
    #[serde(rename = "set")]
    _set: Option<toml::Value>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawVary {
    #[serde(default)]
    boundary_tolerance_m: Vec<f64>,
    #[serde(default)]
    cap_step_deg: Vec<f64>,
    #[serde(default)]
    positions: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTexture {
    image: Option<RawImage>,
    checker: Option<RawChecker>,
    hatch: Option<RawHatch>,
    share: Option<String>,
    alpha: Option<f64>,
    placement: RawPlacement,
    fade: Option<RawFade>,
}

/// One of three.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPicture {
    image: Option<RawImage>,
    checker: Option<RawChecker>,
    hatch: Option<RawHatch>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawImage {
    path: String,
    sha256: String,
    how: Option<String>,
}

/// Either what [`RawImage`] has, or a file that ships.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSurfaceFile {
    path: Option<String>,
    sha256: Option<String>,
    how: Option<String>,
    embedded: Option<String>,
}

/// A file that a surface is made from, checked.
enum SurfaceSource {
    Data(RawImage),
    Shipped(SurfaceFile),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawHatch {
    size: i64,
    lines: i64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawChecker {
    size: i64,
    cells: i64,
}

/// `placement = "extents"`, or a table with one entry.
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawPlacement {
    Extents,
    Anchor(RawAnchor),
    Pattern(RawPattern),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawAnchor {
    longitude_deg: f64,
    latitude_deg: f64,
    #[serde(default)]
    rotation_deg: f64,
    width_m: f64,
    height_m: f64,
    outside: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPattern {
    longitude_deg: f64,
    latitude_deg: f64,
    #[serde(default)]
    rotation_deg: f64,
    texels_per_px: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFade {
    begin_m: f64,
    end_m: f64,
}

/// A texture whose values are checked and whose picture is not yet read.
struct UnreadTexture {
    image: ImageSource,
    share: TextureShare,
    alpha: f64,
    placement: TexturePlacement,
    fade_m: Option<[f64; 2]>,
}

impl UnreadTexture {
    fn load(self, scene: &str, data_dir: Option<&Path>) -> Result<SceneTexture, SceneError> {
        Ok(SceneTexture {
            source: self.image.name(),
            image: self.image.load(scene, data_dir)?,
            share: self.share,
            alpha: self.alpha,
            placement: self.placement,
            fade_m: self.fade_m,
        })
    }
}

/// Where a scene's regions come from.
enum RegionSource {
    File {
        need: DataNeed,
        how: String,
    },
    Embedded {
        name: String,
        text: &'static str,
    },
    Inline(String),
    /// GeoJSON that the program makes.
    Generated(Box<dyn Fn() -> String>),
}

impl RegionSource {
    fn regions(
        self,
        scene: &str,
        data_dir: Option<&Path>,
        reading: Reading,
    ) -> Result<Vec<Region>, SceneError> {
        let parse = |bytes: &[u8], file: &str| {
            parse_regions_as(bytes, file, reading)
                .map_err(|error| SceneError::Regions(RegionLoadError::Invalid(error)))
        };
        match self {
            Self::Embedded { name, text } => {
                parse(text.as_bytes(), &format!("bench-scenes/{name}"))
            }
            Self::Inline(text) => parse(text.as_bytes(), &format!("{scene} (inline)")),
            Self::Generated(geojson) => {
                parse(geojson().as_bytes(), &format!("{scene} (procedural)"))
            }
            Self::File { need, how } => {
                let mut reasons = Vec::new();
                for candidate in std::iter::once(&need.file).chain(&need.source) {
                    match read_verified(data_dir, &candidate.path, &candidate.sha256)? {
                        Verified::Bytes(bytes) => return parse(&bytes, &candidate.path),
                        Verified::Absent(why) => reasons.push(why),
                    }
                }
                // That there is no folder is said once.
                reasons.dedup();
                Err(SceneError::DataMissing {
                    scene: scene.to_owned(),
                    file: need.file.path,
                    sha256: need.file.sha256,
                    why: reasons.join(", and "),
                    how,
                })
            }
        }
    }
}

/// Checks values and words the complaints.
struct Check<'a> {
    file: &'a str,
}

impl Check<'_> {
    fn refuse(
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

    /// Names become parts of file names and CSV cells.
    fn name(&self, key: &str, name: String) -> Result<String, SceneError> {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if !name.is_empty() && name.chars().all(plain) {
            return Ok(name);
        }
        Err(self.refuse(key, format!("{name:?}"), "lower-case letters, digits and -"))
    }

    fn body(&self, name: &str) -> Result<Ellipsoid, SceneError> {
        Ellipsoid::by_name(name).ok_or_else(|| {
            let names = Ellipsoid::ALL.map(|body| body.name());
            self.refuse("body", format!("{name:?}"), names.join(", "))
        })
    }

    /// One of two values by its name; the first where the key is absent.
    fn choice<T: Copy>(
        &self,
        key: &str,
        found: Option<&str>,
        values: [T; 2],
        name_of: fn(T) -> &'static str,
    ) -> Result<T, SceneError> {
        let Some(found) = found else {
            return Ok(values[0]);
        };
        values
            .into_iter()
            .find(|value| name_of(*value) == found)
            .ok_or_else(|| self.refuse(key, format!("{found:?}"), values.map(name_of).join(", ")))
    }

    fn within(
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

    fn positive(&self, key: impl Into<String>, value: f64) -> Result<f64, SceneError> {
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(self.refuse(key, value, "greater than 0"))
    }

    fn count(&self, key: &str, value: i64, range: RangeInclusive<i64>) -> Result<u32, SceneError> {
        let allowed = format!("{} to {}", range.start(), range.end());
        u32::try_from(value)
            .ok()
            .filter(|_| range.contains(&value))
            .ok_or_else(|| self.refuse(key, value, allowed))
    }

    /// Whether rings that cross are split there; the only repair there is.
    fn repair(&self, found: Option<&str>) -> Result<bool, SceneError> {
        match found {
            None => Ok(false),
            Some("even-odd") => Ok(true),
            Some(other) => Err(self.refuse("regions.repair", format!("{other:?}"), "even-odd")),
        }
    }

    fn region_source(&self, raw: RawRegions) -> Result<RegionSource, SceneError> {
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

    fn file_source(
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
            self.hash("regions.source.sha256", &source.sha256)?;
        }
        let how = how.unwrap_or_default();
        if how.trim().is_empty() {
            return Err(self.refuse("regions.how", "nothing", "how to get the file"));
        }
        let file = DataFile { path: file, sha256 };
        let need = DataNeed { file, source };
        Ok(RegionSource::File { need, how })
    }

    fn data_path(&self, key: &str, file: &str) -> Result<(), SceneError> {
        let inside = |part: Component<'_>| matches!(part, Component::Normal(_));
        if !file.is_empty() && Path::new(file).components().all(inside) {
            return Ok(());
        }
        Err(self.refuse(key, format!("{file:?}"), "a path inside the data folder"))
    }

    fn hash(&self, key: &str, sha256: &str) -> Result<(), SceneError> {
        let is_digit = |c: char| matches!(c, '0'..='9' | 'a'..='f');
        if sha256.len() == 64 && sha256.chars().all(is_digit) {
            return Ok(());
        }
        Err(self.refuse(
            key,
            format!("{sha256:?}"),
            "64 lower-case hexadecimal digits",
        ))
    }

    /// Files with their way to the user, checked.
    fn surface_files(&self, raw: Vec<RawSurfaceFile>) -> Result<Vec<SurfaceSource>, SceneError> {
        let files = raw.into_iter().enumerate();
        let files = files.map(|(i, file)| self.surface_file(&format!("surface.files[{i}]"), file));
        files.collect()
    }

    fn surface_file(&self, key: &str, raw: RawSurfaceFile) -> Result<SurfaceSource, SceneError> {
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

    fn texture(&self, raw: RawTexture) -> Result<UnreadTexture, SceneError> {
        Ok(UnreadTexture {
            image: self.image_source(
                "texture",
                RawPicture {
                    image: raw.image,
                    checker: raw.checker,
                    hatch: raw.hatch,
                },
            )?,
            share: self.choice(
                "texture.share",
                raw.share.as_deref(),
                [TextureShare::One, TextureShare::Each],
                TextureShare::name,
            )?,
            alpha: self.within("texture.alpha", raw.alpha.unwrap_or(1.0), 0.0..=1.0)?,
            placement: self.placement(&raw.placement)?,
            fade_m: raw.fade.map(|fade| self.fade(&fade)).transpose()?,
        })
    }

    /// - `key`: what holds the three keys
    fn image_source(&self, key: &str, raw: RawPicture) -> Result<ImageSource, SceneError> {
        match (raw.image, raw.checker, raw.hatch) {
            (Some(image), None, None) => {
                self.data_path(&format!("{key}.image.path"), &image.path)?;
                self.hash(&format!("{key}.image.sha256"), &image.sha256)?;
                Ok(ImageSource::File {
                    how: image
                        .how
                        .unwrap_or_else(|| format!("put {} into the data folder", image.path)),
                    path: image.path,
                    sha256: image.sha256,
                })
            }
            (None, Some(checker), None) => {
                // A cell has a colour of its own in steps of 8 bits: 64 are three apart.
                let cells = self.count(&format!("{key}.checker.cells"), checker.cells, 2..=64)?;
                let key = format!("{key}.checker.size");
                let size = self.count(&key, checker.size, 2..=i64::from(MAX_SIDE_PX))?;
                if !size.is_multiple_of(cells) {
                    return Err(self.refuse(key, size, format!("a multiple of {cells} cells")));
                }
                Ok(ImageSource::Checker { size, cells })
            }
            (None, None, Some(hatch)) => {
                let size_key = format!("{key}.hatch.size");
                let size = self.count(&size_key, hatch.size, 4..=i64::from(MAX_SIDE_PX))?;
                let most = i64::from(size / MIN_HATCH_PERIOD);
                let lines = self.count(&format!("{key}.hatch.lines"), hatch.lines, 1..=most)?;
                if !size.is_multiple_of(lines) {
                    let allowed = format!("a multiple of {lines} lines");
                    return Err(self.refuse(size_key, size, allowed));
                }
                Ok(ImageSource::Hatch { size, lines })
            }
            (image, checker, hatch) => {
                let given = [image.is_some(), checker.is_some(), hatch.is_some()];
                let found = if given.contains(&true) {
                    "several"
                } else {
                    "none"
                };
                Err(self.refuse(key, found, "exactly one of image, checker, hatch"))
            }
        }
    }

    fn placement(&self, raw: &RawPlacement) -> Result<TexturePlacement, SceneError> {
        match raw {
            RawPlacement::Extents => Ok(TexturePlacement::Extents),
            RawPlacement::Anchor(raw) => {
                let key = |name: &str| format!("texture.placement.anchor.{name}");
                let place = [raw.longitude_deg, raw.latitude_deg, raw.rotation_deg];
                Ok(TexturePlacement::Anchor {
                    anchor: self.texture_anchor(&key, place)?,
                    width_m: self.positive(key("width_m"), raw.width_m)?,
                    height_m: self.positive(key("height_m"), raw.height_m)?,
                    outside: self.choice(
                        &key("outside"),
                        raw.outside.as_deref(),
                        [Outside::Repeat, Outside::Transparent],
                        Outside::name,
                    )?,
                })
            }
            RawPlacement::Pattern(raw) => {
                let key = |name: &str| format!("texture.placement.pattern.{name}");
                let place = [raw.longitude_deg, raw.latitude_deg, raw.rotation_deg];
                // Beyond a thousand texels a pixel, or pixels a texel, nothing can be made out.
                let texels_per_px =
                    self.within(key("texels_per_px"), raw.texels_per_px, 1e-3..=1e3)?;
                Ok(TexturePlacement::Pattern {
                    anchor: self.texture_anchor(&key, place)?,
                    texels_per_px,
                })
            }
        }
    }

    /// An anchor's longitude, latitude and rotation, degrees.
    fn texture_anchor(
        &self,
        key: &dyn Fn(&str) -> String,
        [longitude, latitude, rotation]: [f64; 3],
    ) -> Result<TextureAnchor, SceneError> {
        // At a pole a metre east is no longitude, so the picture's middle must keep clear of it.
        let latitude = self.within(key("latitude_deg"), latitude, -89.9..=89.9)?;
        Ok(TextureAnchor {
            longitude_rad: self
                .within(key("longitude_deg"), longitude, -180.0..=180.0)?
                .to_radians(),
            latitude_rad: latitude.to_radians(),
            rotation_rad: self
                .within(key("rotation_deg"), rotation, -360.0..=360.0)?
                .to_radians(),
        })
    }

    fn fade(&self, raw: &RawFade) -> Result<[f64; 2], SceneError> {
        let begin_m = raw.begin_m;
        if !(begin_m >= 0.0 && begin_m.is_finite()) {
            return Err(self.refuse("texture.fade.begin_m", begin_m, "0 or more"));
        }
        if !(raw.end_m > begin_m && raw.end_m.is_finite()) {
            let allowed = format!("greater than {begin_m}");
            return Err(self.refuse("texture.fade.end_m", raw.end_m, allowed));
        }
        Ok([begin_m, raw.end_m])
    }

    /// What a generator makes of its keys.
    fn procedural(&self, raw: RawProcedural) -> Result<Box<dyn Fn() -> String>, SceneError> {
        match raw.kind.as_str() {
            "islands" => {
                let islands = self.islands(&self.keys(raw.keys)?)?;
                Ok(Box::new(move || islands.geojson()))
            }
            "nested" => {
                let nested = self.nested(&self.keys(raw.keys)?)?;
                Ok(Box::new(move || nested.geojson()))
            }
            "cells" => {
                let cells = self.cells(&self.keys(raw.keys)?)?;
                Ok(Box::new(move || cells.geojson()))
            }
            "coast" => {
                let coast = self.coast(&self.keys(raw.keys)?)?;
                Ok(Box::new(move || coast.geojson()))
            }
            other => Err(self.refuse(
                "regions.procedural.kind",
                format!("{other:?}"),
                "islands, nested, cells, coast",
            )),
        }
    }

    /// The keys of a generator of one kind.
    fn keys<T: serde::de::DeserializeOwned>(&self, keys: toml::Table) -> Result<T, SceneError> {
        let found = keys.keys().cloned().collect::<Vec<_>>().join(", ");
        keys.try_into().map_err(|error: toml::de::Error| {
            self.refuse("regions.procedural", found, error.message().to_owned())
        })
    }

    fn seed(&self, seed: i64) -> Result<u64, SceneError> {
        u64::try_from(seed).map_err(|_| self.refuse("regions.procedural.seed", seed, "0 or more"))
    }

    /// Longitude, latitude and radius, degrees, of what keeps clear of the poles and of half the
    /// body's girth.
    fn disc(&self, [longitude, latitude, radius]: [f64; 3]) -> Result<[f64; 3], SceneError> {
        let key = |name: &str| format!("regions.procedural.{name}");
        let latitude = self.within(key("latitude_deg"), latitude, -80.0..=80.0)?;
        let room = 85.0 - latitude.abs();
        Ok([
            self.within(key("longitude_deg"), longitude, -180.0..=180.0)?,
            latitude,
            self.within(key("radius_deg"), radius, 1e-6..=room)?,
        ])
    }

    fn nested(&self, raw: &RawNested) -> Result<Nested, SceneError> {
        let [longitude_deg, latitude_deg, radius_deg] =
            self.disc([raw.longitude_deg, raw.latitude_deg, raw.radius_deg])?;
        Ok(Nested {
            count: self.count("regions.procedural.count", raw.count, 1..=4_096)?,
            vertices: self.count("regions.procedural.vertices", raw.vertices, 3..=1_000)?,
            longitude_deg,
            latitude_deg,
            radius_deg,
            as_one: raw.as_one,
        })
    }

    fn cells(&self, raw: &RawCells) -> Result<Cells, SceneError> {
        let key = |name: &str| format!("regions.procedural.{name}");
        let south_deg = self.within(key("south_deg"), raw.south_deg, -89.0..=89.0)?;
        Ok(Cells {
            columns: self.count(&key("columns"), raw.columns, 1..=1_000)?,
            rows: self.count(&key("rows"), raw.rows, 1..=1_000)?,
            west_deg: self.within(key("west_deg"), raw.west_deg, -180.0..=180.0)?,
            south_deg,
            width_deg: self.within(key("width_deg"), raw.width_deg, 1e-9..=180.0)?,
            height_deg: self.within(key("height_deg"), raw.height_deg, 1e-9..=89.0 - south_deg)?,
        })
    }

    fn coast(&self, raw: &RawCoast) -> Result<Coast, SceneError> {
        let [longitude_deg, latitude_deg, radius_deg] =
            self.disc([raw.longitude_deg, raw.latitude_deg, raw.radius_deg])?;
        Ok(Coast {
            seed: self.seed(raw.seed)?,
            vertices: self.count("regions.procedural.vertices", raw.vertices, 32..=4_000_000)?,
            longitude_deg,
            latitude_deg,
            radius_deg,
        })
    }

    fn islands(&self, raw: &RawIslands) -> Result<Islands, SceneError> {
        let seed = self.seed(raw.seed)?;
        let key = |name: &str| format!("regions.procedural.{name}");
        let min_vertices = self.count(&key("min_vertices"), raw.min_vertices, 32..=100_000)?;
        Ok(Islands {
            seed,
            // From two on there is a neighbour to keep clear of; at ten thousand islands are 2°.
            count: self.count(&key("count"), raw.count, 2..=10_000)?,
            min_vertices,
            max_vertices: self.count(
                &key("max_vertices"),
                raw.max_vertices,
                i64::from(min_vertices)..=100_000,
            )?,
            lake_every: self.count(&key("lake_every"), raw.lake_every, 0..=10_000)?,
        })
    }

    fn mesh(&self, raw: &RawMesh) -> Result<MeshOptions, SceneError> {
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

    fn cap_step(&self, key: impl Into<String>, degrees: f64) -> Result<f64, SceneError> {
        if degrees > 0.0 && degrees <= CAP_STEP_LIMIT_DEG {
            return Ok(degrees);
        }
        let allowed = format!("greater than 0, at most {CAP_STEP_LIMIT_DEG}");
        Err(self.refuse(key, degrees, allowed))
    }

    /// Automatic where the scene has no `[levels]`; an empty list means level 0 alone.
    fn levels(&self, raw: Option<RawLevels>) -> Result<LevelChoice, SceneError> {
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

    fn views(&self, raw: &[RawView]) -> Result<Vec<View>, SceneError> {
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
    fn expectations(&self, scene: Option<&str>, views: &[RawView]) -> Result<(), SceneError> {
        let views = views.iter().enumerate();
        let views = views.map(|(i, view)| (format!("views[{i}].expect"), view.expect.as_deref()));
        for (key, found) in std::iter::once(("expect".to_owned(), scene)).chain(views) {
            if let Some(found) = found.filter(|found| Expectation::parse(found).is_none()) {
                return Err(self.refuse(key, format!("{found:?}"), Expectation::ALLOWED));
            }
        }
        Ok(())
    }

    fn view(&self, index: usize, raw: &RawView) -> Result<View, SceneError> {
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
    fn sweep(
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

/// The bytes of a file that a surface is made from.
fn load_surface_file(
    source: SurfaceSource,
    scene: &str,
    data_dir: Option<&Path>,
) -> Result<SurfaceFile, SceneError> {
    let raw = match source {
        SurfaceSource::Shipped(file) => return Ok(file),
        SurfaceSource::Data(raw) => raw,
    };
    match read_verified(data_dir, &raw.path, &raw.sha256)? {
        Verified::Bytes(bytes) => Ok(SurfaceFile {
            path: raw.path,
            bytes: bytes.into(),
        }),
        Verified::Absent(why) => Err(SceneError::DataMissing {
            scene: scene.to_owned(),
            how: (raw.how).unwrap_or_else(|| format!("put {} into the data folder", raw.path)),
            file: raw.path,
            sha256: raw.sha256,
            why,
        }),
    }
}
