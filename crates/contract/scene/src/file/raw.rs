// SPDX-License-Identifier: MIT OR Apache-2.0
//! A scene file as it is written, before anything is checked.

use crate::DataFile;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScene {
    pub(super) name: String,
    pub(super) description: String,
    pub(super) body: String,
    pub(super) edges: Option<String>,
    pub(super) overlap: Option<String>,
    pub(super) regions: RawRegions,
    #[serde(default)]
    pub(super) surface: RawSurface,
    #[serde(default)]
    pub(super) mesh: RawMesh,
    pub(super) levels: Option<RawLevels>,
    pub(super) views: Vec<RawView>,
    pub(super) vary: Option<RawVary>,
    pub(super) texture: Option<RawTexture>,
    /// Read by [`crate::SuiteScene`].
    #[serde(rename = "reason")]
    pub(super) _reason: Option<String>,
    pub(super) expect: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRegions {
    pub(super) file: Option<String>,
    pub(super) sha256: Option<String>,
    pub(super) source: Option<RawDataFile>,
    pub(super) how: Option<String>,
    pub(super) embedded: Option<String>,
    pub(super) inline: Option<String>,
    pub(super) procedural: Option<RawProcedural>,
    pub(super) repair: Option<String>,
    pub(super) unwrap: Option<String>,
    pub(super) inside: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDataFile {
    pub(super) file: String,
    pub(super) sha256: String,
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
pub(super) struct RawProcedural {
    pub(super) kind: String,
    #[serde(flatten)]
    pub(super) keys: toml::Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNested {
    pub(super) count: i64,
    pub(super) vertices: i64,
    pub(super) longitude_deg: f64,
    pub(super) latitude_deg: f64,
    pub(super) radius_deg: f64,
    #[serde(default)]
    pub(super) as_one: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCells {
    pub(super) columns: i64,
    pub(super) rows: i64,
    pub(super) west_deg: f64,
    pub(super) south_deg: f64,
    pub(super) width_deg: f64,
    pub(super) height_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCoast {
    pub(super) seed: i64,
    pub(super) vertices: i64,
    pub(super) longitude_deg: f64,
    pub(super) latitude_deg: f64,
    pub(super) radius_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawIslands {
    pub(super) seed: i64,
    pub(super) count: i64,
    pub(super) min_vertices: i64,
    pub(super) max_vertices: i64,
    #[serde(default)]
    pub(super) lake_every: i64,
}

#[derive(Deserialize, Default)]
pub(super) struct RawSurface {
    pub(super) kind: Option<String>,
    #[serde(default)]
    pub(super) files: Vec<RawSurfaceFile>,
    pub(super) picture: Option<RawPicture>,
    #[serde(flatten)]
    pub(super) parameters: toml::Table,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMesh {
    pub(super) boundary_tolerance_m: Option<f64>,
    pub(super) cap_step_deg: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLevels {
    pub(super) deviation_m: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawView {
    pub(super) name: String,
    pub(super) longitude_deg: f64,
    pub(super) latitude_deg: f64,
    pub(super) height_m: f64,
    #[serde(default)]
    pub(super) heading_deg: f64,
    pub(super) pitch_deg: f64,
    pub(super) fov_deg: Option<f64>,
    pub(super) near_m: Option<f64>,
    pub(super) note: Option<String>,
    pub(super) projection: Option<String>,
    pub(super) expect: Option<String>,
    /// Read by [`crate::SuiteScene`].
    #[serde(rename = "size")]
    pub(super) _size: Option<toml::Value>,
    #[serde(rename = "set")]
    pub(super) _set: Option<toml::Value>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawVary {
    #[serde(default)]
    pub(super) boundary_tolerance_m: Vec<f64>,
    #[serde(default)]
    pub(super) cap_step_deg: Vec<f64>,
    #[serde(default)]
    pub(super) positions: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTexture {
    pub(super) image: Option<RawImage>,
    pub(super) checker: Option<RawChecker>,
    pub(super) hatch: Option<RawHatch>,
    pub(super) share: Option<String>,
    pub(super) alpha: Option<f64>,
    pub(super) placement: RawPlacement,
    pub(super) fade: Option<RawFade>,
    #[serde(default)]
    pub(super) alone: bool,
    pub(super) quick_view: Option<String>,
}

/// One of three.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPicture {
    pub(super) image: Option<RawImage>,
    pub(super) checker: Option<RawChecker>,
    pub(super) hatch: Option<RawHatch>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawImage {
    pub(super) path: String,
    #[serde(default)]
    pub(super) sha256: String,
    pub(super) how: Option<String>,
}

/// Either what [`RawImage`] has, or a file that ships.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSurfaceFile {
    pub(super) path: Option<String>,
    pub(super) sha256: Option<String>,
    pub(super) how: Option<String>,
    pub(super) embedded: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawHatch {
    pub(super) size: i64,
    pub(super) lines: i64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawChecker {
    pub(super) size: i64,
    pub(super) cells: i64,
}

/// `placement = "extents"`, or a table with one entry.
#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawPlacement {
    Extents,
    Anchor(RawAnchor),
    Pattern(RawPattern),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAnchor {
    pub(super) longitude_deg: f64,
    pub(super) latitude_deg: f64,
    #[serde(default)]
    pub(super) rotation_deg: f64,
    pub(super) width_m: f64,
    pub(super) height_m: f64,
    pub(super) outside: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPattern {
    pub(super) longitude_deg: f64,
    pub(super) latitude_deg: f64,
    #[serde(default)]
    pub(super) rotation_deg: f64,
    pub(super) texels_per_px: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFade {
    pub(super) begin_m: f64,
    pub(super) end_m: f64,
}
