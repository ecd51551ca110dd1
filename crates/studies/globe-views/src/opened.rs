// SPDX-License-Identifier: MIT OR Apache-2.0
//! Surfaces, opened once for all views.

use crate::STUDY;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;
use terrafill_results::Skipped;
use terrafill_scene::{Scene, SurfaceChoice};
use terrafill_surface::{Surface, SurfaceKind, open_surface};
use toml::{Table, Value};

/// A scene that needs no data, whose surface is replaced.
const ANY_SCENE: &str = "square-10m";

/// What the study leaves out of its plan, and why.
#[must_use]
pub fn left_out(what: &str, reason: String) -> Skipped {
    Skipped {
        what: format!("{STUDY}/{what}"),
        reason,
    }
}

/// The same for want of a surface.
#[must_use]
pub fn no_kind(what: &str, kind: &str) -> Skipped {
    left_out(what, format!("there is no surface of the kind {kind:?}"))
}

/// What surfaces the study was handed, and those that were opened.
pub struct Opened {
    kinds: &'static [&'static dyn SurfaceKind],
    surfaces: RefCell<BTreeMap<String, Arc<dyn Surface>>>,
}

impl Opened {
    /// - `kinds`: surfaces that may be opened
    #[must_use]
    pub fn new(kinds: &'static [&'static dyn SurfaceKind]) -> Self {
        Self {
            kinds,
            surfaces: RefCell::default(),
        }
    }

    /// Whether there are surfaces of that kind.
    pub fn has(&self, kind: &str) -> bool {
        self.kinds.iter().any(|known| known.name() == kind)
    }

    /// A surface over the Earth.
    ///
    /// # Errors
    /// What is wrong with its parameters, with what is allowed.
    pub fn get<K: Into<String>, V: Into<Value>>(
        &self,
        kind: &str,
        parameters: impl IntoIterator<Item = (K, V)>,
    ) -> Result<Arc<dyn Surface>, String> {
        let parameters = parameters.into_iter();
        let parameters = parameters.map(|(key, value)| (key.into(), value.into()));
        let parameters = parameters.collect::<Table>();
        let key = format!("{kind} {parameters}");
        if let Some(surface) = self.surfaces.borrow().get(&key) {
            return Ok(Arc::clone(surface));
        }
        let mut scene = Scene::shipped(ANY_SCENE, None).map_err(|error| error.to_string())?;
        scene.surface = SurfaceChoice {
            file: "plan.toml of study globes".to_owned(),
            kind: kind.to_owned(),
            files: Vec::new(),
            picture: None,
            parameters,
        };
        let surface = self.of_scene(&scene)?;
        let mut surfaces = self.surfaces.borrow_mut();
        surfaces.insert(key, Arc::clone(&surface));
        Ok(surface)
    }

    /// The surface of a scene, opened anew.
    ///
    /// # Errors
    /// As [`Opened::get`].
    pub fn of_scene(&self, scene: &Scene) -> Result<Arc<dyn Surface>, String> {
        open_surface(self.kinds, scene).map_err(|error| error.to_string())
    }
}
