// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a scene's `[surface]` to a surface: kinds by name, and parameters checked one by one.

use crate::{Surface, SurfaceError};
use std::fmt::{Debug, Display};
use std::ops::RangeInclusive;
use std::sync::Arc;
use terrafill_core::Ellipsoid;
use terrafill_scene::{Scene, SurfaceChoice, SurfaceFile, choices};
use toml::Value;

/// A kind of surface that scenes can name.
pub trait SurfaceKind: Debug + Sync {
    /// Name in scene files.
    fn name(&self) -> &'static str;

    /// Opens a surface of this kind on `body`. Keys that are not read are refused afterwards.
    ///
    /// # Errors
    /// [`SurfaceError::Value`], [`SurfaceError::Data`].
    fn open(
        &self,
        body: &Ellipsoid,
        parameters: &mut Parameters<'_>,
    ) -> Result<Arc<dyn Surface>, SurfaceError>;
}

/// Opens the surface that `scene` names.
///
/// - `kinds`: those that there are
///
/// # Errors
/// [`SurfaceError::Value`] for a kind that there is not, a value that is not allowed, or a key that
/// the kind does not know.
pub fn open_surface(
    kinds: &[&dyn SurfaceKind],
    scene: &Scene,
) -> Result<Arc<dyn Surface>, SurfaceError> {
    let choice = &scene.surface;
    let mut parameters = Parameters {
        choice,
        read: Vec::new(),
        are_files_read: false,
    };
    let Some(kind) = kinds.iter().find(|kind| kind.name() == choice.kind) else {
        let allowed = choices(&choice.kind, kinds.iter().map(|kind| kind.name()));
        let found = format!("{:?}", choice.kind);
        return Err(parameters.refuse("kind", found, allowed));
    };
    let surface = kind.open(&scene.body, &mut parameters)?;
    parameters.refuse_unread()?;
    Ok(surface)
}

/// Keys of a scene's `[surface]` besides the kind.
#[derive(Debug)]
pub struct Parameters<'a> {
    choice: &'a SurfaceChoice,
    /// Keys that the kind knows.
    read: Vec<&'static str>,
    /// Whether the kind takes files.
    are_files_read: bool,
}

impl Parameters<'_> {
    /// A whole number.
    ///
    /// # Errors
    /// [`SurfaceError::Value`] when it is no whole number in `range`.
    pub fn count(
        &mut self,
        key: &'static str,
        default: u32,
        range: RangeInclusive<u32>,
    ) -> Result<u32, SurfaceError> {
        let Some(value) = self.value(key) else {
            return Ok(default);
        };
        let count = value
            .as_integer()
            .and_then(|found| u32::try_from(found).ok());
        count
            .filter(|count| range.contains(count))
            .ok_or_else(|| self.refuse(key, value, format!("{} to {}", range.start(), range.end())))
    }

    /// A number; a whole one may be written without a point.
    ///
    /// # Errors
    /// [`SurfaceError::Value`] when it is no number in `range`.
    pub fn number(
        &mut self,
        key: &'static str,
        default: f64,
        range: RangeInclusive<f64>,
    ) -> Result<f64, SurfaceError> {
        let Some(value) = self.value(key) else {
            return Ok(default);
        };
        let number = match value {
            Value::Float(number) => Some(*number),
            Value::Integer(whole) => Some(*whole as f64),
            _ => None,
        };
        number
            .filter(|number| range.contains(number))
            .ok_or_else(|| self.refuse(key, value, format!("{} to {}", range.start(), range.end())))
    }

    /// One of a few words.
    ///
    /// # Errors
    /// [`SurfaceError::Value`] when it is none of `allowed`.
    pub fn word(
        &mut self,
        key: &'static str,
        default: &'static str,
        allowed: &[&'static str],
    ) -> Result<&'static str, SurfaceError> {
        let Some(value) = self.value(key) else {
            return Ok(default);
        };
        let known = allowed.iter().find(|word| Some(**word) == value.as_str());
        known.copied().ok_or_else(|| {
            let found = value.as_str().unwrap_or_default();
            self.refuse(key, value, choices(found, allowed.iter().copied()))
        })
    }

    /// One of a few things by name; the first where the scene names none.
    ///
    /// # Errors
    /// [`SurfaceError::Value`] when it is none of them.
    pub fn one_of<T: Copy, const N: usize>(
        &mut self,
        key: &'static str,
        all: [(&'static str, T); N],
    ) -> Result<T, SurfaceError> {
        const { assert!(N > 0, "there is a first one") };
        let found = self.word(key, all[0].0, &all.map(|(name, _)| name))?;
        let known = all.into_iter().find(|(name, _)| *name == found);
        Ok(known.map_or(all[0].1, |(_, thing)| thing))
    }

    /// Yes or no.
    ///
    /// # Errors
    /// [`SurfaceError::Value`] when it is neither.
    pub fn flag(&mut self, key: &'static str, default: bool) -> Result<bool, SurfaceError> {
        let Some(value) = self.value(key) else {
            return Ok(default);
        };
        let flag = value.as_bool();
        flag.ok_or_else(|| self.refuse(key, value, "true, false"))
    }

    /// `key` has a value that is not allowed.
    #[must_use]
    pub fn refuse(
        &self,
        key: &str,
        found: impl Display,
        allowed: impl Into<String>,
    ) -> SurfaceError {
        SurfaceError::Value {
            file: self.choice.file.clone(),
            key: key.to_owned(),
            found: found.to_string(),
            allowed: allowed.into(),
        }
    }
}

impl<'a> Parameters<'a> {
    fn value(&mut self, key: &'static str) -> Option<&'a Value> {
        self.read.push(key);
        self.choice.parameters.get(key)
    }

    /// Files that the scene's surface is made from, in the scene's order. A kind that never asks is
    /// given none: a scene that names any is refused.
    pub fn files(&mut self) -> &'a [SurfaceFile] {
        self.are_files_read = true;
        &self.choice.files
    }

    /// The scene file, for messages.
    #[must_use]
    pub fn scene_file(&self) -> &'a str {
        &self.choice.file
    }

    fn refuse_unread(&self) -> Result<(), SurfaceError> {
        if !(self.are_files_read || self.choice.files.is_empty()) {
            let (found, kind) = (self.choice.files.len(), &self.choice.kind);
            let allowed = format!("none, since surfaces of the kind {kind} are made from no file");
            return Err(self.refuse("files", found, allowed));
        }
        let mut stray = self.choice.parameters.iter();
        match stray.find(|(key, _)| !self.read.contains(&key.as_str())) {
            None => Ok(()),
            Some((key, value)) => {
                let known = choices(key, [&["kind"], self.read.as_slice()].concat());
                Err(self.refuse(key, value, format!("only the keys {known}")))
            }
        }
    }
}
