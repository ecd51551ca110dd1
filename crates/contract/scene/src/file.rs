// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scene files: TOML in degrees and metres in, a checked [`Scene`] in radians out.
//!
//! Everything is checked here, once. A message names the file, the key, the value found and the
//! values allowed. Keys that mean nothing are refused, since a misspelt switch would otherwise
//! measure the default under another name.

mod check;
mod generators;
mod picture;
mod raw;
mod sources;

use crate::data::Folders;
use crate::error::parsed;
use crate::scene::{Overlap, Scene, SurfaceChoice};
use crate::shipped;
use crate::{DataFile, DataNeed, SceneError, choices};
use check::Check;
use raw::RawScene;
use sources::load_surface_file;
use std::path::Path;
use std::sync::Arc;
use terrafill_core::{EdgeRule, Inside, Reading, Unwrap};

impl Scene {
    /// Reads a scene file.
    ///
    /// - `data_dir`: where files named by the scene are that are not beside the scene file
    ///
    /// # Errors
    /// [`SceneError`]; [`SceneError::DataMissing`] if only the data is missing.
    pub fn load(path: &Path, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path).map_err(|source| SceneError::Unreadable {
            path: path.to_path_buf(),
            source,
        })?;
        let folders = Folders {
            scene: path.parent(),
            data: data_dir,
        };
        Self::read(&text, &path.display().to_string(), folders)
    }

    /// A scene that ships with the program, by name.
    ///
    /// # Errors
    /// As [`Scene::load`], and [`SceneError::Unknown`].
    pub fn shipped(name: &str, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        let text = shipped::shipped_scene_text(name).ok_or_else(|| SceneError::Unknown {
            name: name.to_owned(),
            allowed: choices(
                name,
                [
                    shipped::shipped_scene_names(),
                    shipped::scene_names_in_folders(),
                ]
                .concat(),
            ),
        })?;
        Self::from_toml(text, &format!("bench-scenes/{name}.toml"), data_dir)
    }

    /// A scene by the name of one that ships, or by the path of a scene file: one that ends with `.toml`, or has a
    /// `/` and is there.
    ///
    /// # Errors
    /// As [`Scene::shipped`].
    pub fn open(name: &str, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        if name.ends_with(".geojson") || name.ends_with(".json") {
            return Err(SceneError::RegionFile {
                path: name.to_owned(),
            });
        }
        let is_path = name.ends_with(".toml") || (name.contains('/') && Path::new(name).exists());
        if is_path && shipped::shipped_scene_text(name).is_none() {
            Self::load(Path::new(name), data_dir)
        } else {
            Self::shipped(name, data_dir)
        }
    }

    /// A scene from the text of a scene file; `file` is for messages.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_toml(text: &str, file: &str, data_dir: Option<&Path>) -> Result<Self, SceneError> {
        let folders = Folders {
            scene: None,
            data: data_dir,
        };
        Self::read(text, file, folders)
    }

    fn read(text: &str, file: &str, folders: Folders<'_>) -> Result<Self, SceneError> {
        let raw: RawScene = parsed(text, file)?;
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
                [Unwrap::Auto, Unwrap::Shortest, Unwrap::Literal],
                Unwrap::name,
            )?,
            inside: check.choice(
                "regions.inside",
                raw.regions.inside.as_deref(),
                [Inside::Smaller, Inside::Left],
                Inside::name,
            )?,
        }
        .of_edges(edge_rule);
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
        let textured = check.textured_fills(raw.texture.as_ref(), &views)?;
        let texture = raw.texture.map(|raw| check.texture(raw)).transpose()?;
        let surface_files = check.surface_files(raw.surface.files)?;
        let picture = raw.surface.picture;
        let picture = picture.map(|raw| check.image_source("surface.picture", raw));
        let picture = picture.transpose()?;
        // Last, so that a wrong scene is reported as wrong even where its data is missing.
        let (mut regions, region_file) = source.regions(&name, folders, reading)?;
        if let Some(repair) = repair {
            for region in &mut regions {
                region.repair(repair, edge_rule);
            }
        }
        let texture = texture.map(|(source, with_picture)| {
            let (picture, file) = source.load(&name, folders)?;
            Ok::<_, SceneError>((with_picture(picture), file))
        });
        let (texture, texture_file) = texture.transpose()?.unzip();
        let surface_files = surface_files.into_iter();
        let surface_files = surface_files
            .map(|file| load_surface_file(file, &name, folders))
            .collect::<Result<Vec<_>, _>>()?;
        let (surface_files, height_files): (Vec<_>, Vec<_>) = surface_files.into_iter().unzip();
        let picture = picture.map(|source| source.load(&name, folders));
        let (picture, picture_file) = picture.transpose()?.unzip();
        let pictures = [texture_file, picture_file].into_iter().flatten().flatten();
        let files_read = region_file.into_iter().chain(height_files).chain(pictures);
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
                picture: picture.map(Arc::new),
                parameters: raw.surface.parameters,
            },
            views,
            sweep_boundary_tolerance_m,
            texture: texture.map(Arc::new),
            textured,
            sweep_cap_step_deg,
            sweep_positions,
            files_read: files_read.collect(),
        })
    }
}

/// The files of the data folder that the text of a scene file names; `file` is for messages.
///
/// # Errors
/// [`SceneError::Syntax`]. Values are not checked: [`Scene::from_toml`] does that.
pub fn scene_needs(text: &str, file: &str) -> Result<Vec<DataNeed>, SceneError> {
    let raw: RawScene = parsed(text, file)?;
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

/// Whether the text of a scene file names any file, be it of the data folder or one that ships with the program;
/// `file` is for messages.
///
/// # Errors
/// As [`scene_needs`].
pub fn names_files(text: &str, file: &str) -> Result<bool, SceneError> {
    let raw: RawScene = parsed(text, file)?;
    let ships = raw.regions.embedded.is_some() || !raw.surface.files.is_empty();
    Ok(ships || !scene_needs(text, file)?.is_empty())
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
