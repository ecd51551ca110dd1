// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run reads of its scenes: files with their hashes, and what is remarkable about them.

use crate::outcome::Failure;
use crate::registry::SURFACES;
use std::path::Path;
use terrafill_core::Region;
use terrafill_results::{RunInput, append_inputs, read_inputs};
use terrafill_scene::{Scene, sha256_hex};
use terrafill_shadows::model_warnings;
use terrafill_study::{Request, files_read};
use terrafill_surface::open_surface;

/// Vertices of a scene from which on the first case is a while away.
const LONG_INPUT: usize = 50_000;

/// As many warnings about single regions as a scene has in a report.
const MAX_REGION_WARNINGS: usize = 20;

/// Files and warnings of a run's scenes and models: of those that a user names, what their regions and surfaces
/// warn of too.
pub(crate) struct Read {
    inputs: Vec<RunInput>,
    /// Of surfaces and models: for standard error.
    pub(crate) warnings: Vec<String>,
    /// How much there is, where that takes long.
    pub(crate) long_input: Option<String>,
}

impl Read {
    /// What cannot be opened is left to the plan, which says why.
    pub(crate) fn of(request: &Request) -> Self {
        let mut read = Self {
            inputs: Vec::new(),
            warnings: Vec::new(),
            long_input: None,
        };
        let names = request.scenes.iter();
        let scenes = names.filter_map(|name| Scene::open(name, request.data_dir.as_deref()).ok());
        let mut long = Vec::new();
        for scene in scenes {
            read.add_scene(&scene);
            let vertices: usize = scene.regions.iter().map(Region::vertex_count).sum();
            if vertices >= LONG_INPUT {
                let regions = match scene.regions.len() {
                    1 => "1 region".to_owned(),
                    some => format!("{some} regions"),
                };
                long.push(format!("{}: {vertices} vertices in {regions}", scene.name));
            }
        }
        if !long.is_empty() {
            read.long_input = Some(format!(
                "{}; each view meshes and simplifies them, which takes a while",
                long.join(", ")
            ));
        }
        for setting in request.settings.get("casters").into_iter().flatten() {
            let file = setting.split(',').next().unwrap_or_default();
            if let Ok(bytes) = std::fs::read(file) {
                read.inputs.push(RunInput {
                    scene: terrafill_shadows::STUDY.to_owned(),
                    file: file.to_owned(),
                    sha256: sha256_hex(&bytes),
                    warning: String::new(),
                });
            }
            let warnings = model_warnings(setting);
            read.warn(terrafill_shadows::STUDY, "", warnings.clone());
            read.warnings.extend(warnings);
        }
        read
    }

    fn add_scene(&mut self, scene: &Scene) {
        self.inputs.extend(files_read(scene));
        let of_regions = scene.regions.iter().flat_map(|region| {
            let warnings = region.warnings.iter();
            warnings.map(|warning| match region.name.as_str() {
                "" => format!("feature {}: {warning}", region.index),
                name => format!("feature {} ({name}): {warning}", region.index),
            })
        });
        let mut of_regions: Vec<String> = of_regions.collect();
        let more = of_regions.len().saturating_sub(MAX_REGION_WARNINGS);
        of_regions.truncate(MAX_REGION_WARNINGS);
        if more > 0 {
            of_regions.push(format!("and {more} more of single regions"));
        }
        self.warn(&scene.name, "", of_regions);
        if let Ok(surface) = open_surface(SURFACES, scene) {
            let warnings = surface.warnings().to_vec();
            self.warn(&scene.name, "", warnings.clone());
            self.warnings.extend(warnings);
        }
    }

    /// Adds what planning read: scenes that no user named, of which the studies know.
    pub(crate) fn add_planned(&mut self, inputs: &[RunInput]) {
        for input in inputs {
            if !self.inputs.contains(input) {
                self.inputs.push(input.clone());
            }
        }
    }

    fn warn(&mut self, scene: &str, file: &str, warnings: Vec<String>) {
        let rows = warnings.into_iter().map(|warning| RunInput {
            scene: scene.to_owned(),
            file: file.to_owned(),
            sha256: String::new(),
            warning,
        });
        self.inputs.extend(rows);
    }

    /// Puts it into the run's folder, once.
    ///
    /// # Errors
    /// Where a run goes on and a file has other bytes than when it began.
    pub(crate) fn write(&self, folder: &Path) -> Result<(), Failure> {
        let known = read_inputs(folder).map_err(Failure::bad_input)?;
        if known.is_empty() {
            // Without rows it says that the run read nothing.
            return append_inputs(folder, &self.inputs).map_err(Failure::bad_input);
        }
        let is_file = |input: &&RunInput| !input.sha256.is_empty();
        let changed = self.inputs.iter().filter(is_file).find_map(|now| {
            let mut known = known.iter();
            let then = known.find(|then| {
                (&then.scene, &then.file) == (&now.scene, &now.file) && is_file(then)
            })?;
            (then.sha256 != now.sha256).then_some((then, now))
        });
        match changed {
            None => Ok(()),
            Some((then, now)) => Err(Failure::bad_input(format!(
                "{}: {}: found sha256 {}, allowed: {}, which the run began with; another --out begins a new one",
                now.scene, now.file, now.sha256, then.sha256
            ))),
        }
    }
}
