// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a bench run is asked to do, and how it can fail as a whole.

use std::path::PathBuf;
use terrafill_scene::ImageSize;
use terrafill_surface::{SurfaceError, SurfaceKind};

/// Part `index` (from 1) of `count`: every `count`-th scene view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    pub index: usize,
    /// At least `index`.
    pub count: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("shard {text:?}, allowed: m/n with 1 ≤ m ≤ n");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let index: usize = index.parse().map_err(|_| wrong())?;
        let count: usize = count.parse().map_err(|_| wrong())?;
        if index == 0 || index > count {
            return Err(wrong());
        }
        Ok(Self { index, count })
    }
}

/// A run's options.
#[derive(Debug, Clone)]
pub struct BenchOptions {
    /// Surfaces that scenes can name.
    pub surfaces: &'static [&'static dyn SurfaceKind],
    /// Names of shipped scenes or paths of scene files; empty for all shipped ones.
    pub scenes: Vec<String>,
    /// Backends to run; empty for all.
    pub backends: Vec<String>,
    /// Fewer frames, the main variants only.
    pub quick: bool,
    /// Where the run goes.
    pub out: PathBuf,
    /// Go on with the run in `out`.
    pub resume: bool,
    /// Where real data lies.
    pub data_dir: Option<PathBuf>,
    /// Timed frames per case; `None`: 30, or 8 when quick.
    pub frames: Option<u32>,
    /// Image size.
    pub size: ImageSize,
    /// Part of the work to do.
    pub shard: Option<Shard>,
    /// Part of the adapter's name.
    pub adapter: Option<String>,
    /// Scenes of which the ladder is measured, or [`NO_SCENE`]; `None`: [`LADDER_SCENE`], or none
    /// when quick.
    pub ladder: Option<Vec<String>>,
    /// Scenes of which the matrix is drawn, or [`NO_SCENE`]; `None`: [`MATRIX_SCENES`], or none when
    /// quick.
    pub matrix: Option<Vec<String>>,
    /// Whether the numerical suite is measured; `None`: with all scenes, as it is a figure of the
    /// whole program.
    pub precision: Option<bool>,
}

/// Stands for no scene at all.
pub const NO_SCENE: &str = "none";

/// The scene whose ladder is measured unless others are asked for: it needs no data, and its coasts
/// are fine enough for vertices to matter.
pub const LADDER_SCENE: &str = "planet-134";

/// Scenes of which the matrix is drawn unless others are asked for: islands, one region close by,
/// and neighbours that share borders.
pub const MATRIX_SCENES: [&str; 3] = ["planet-134", "california", "countries-110m"];

impl BenchOptions {
    /// Timed frames per case.
    #[must_use]
    pub fn frame_count(&self) -> u32 {
        self.frames.unwrap_or(if self.quick { 8 } else { 30 })
    }

    /// Timed frames of a rung: enough for an interval of the ratio to the rung before, and few, since
    /// the first rungs take seconds where the last take milliseconds.
    #[must_use]
    pub fn ladder_frame_count(&self) -> u32 {
        self.frame_count().min(11)
    }

    /// Whether `backend` is asked for.
    #[must_use]
    pub fn wants_backend(&self, backend: &str) -> bool {
        self.backends.is_empty() || self.backends.iter().any(|name| name == backend)
    }

    /// Whether the ladder of this scene is asked for.
    #[must_use]
    pub fn wants_ladder(&self, scene: &str) -> bool {
        match &self.ladder {
            Some(scenes) => scenes.iter().any(|name| name == scene),
            None => !self.quick && scene == LADDER_SCENE,
        }
    }

    /// Whether the matrix of this scene is asked for.
    #[must_use]
    pub fn wants_matrix(&self, scene: &str) -> bool {
        match &self.matrix {
            Some(scenes) => scenes.iter().any(|name| name == scene),
            None => !self.quick && MATRIX_SCENES.contains(&scene),
        }
    }

    /// Whether the numerical suite is asked for; of several shards the first one measures it.
    #[must_use]
    pub fn wants_precision(&self) -> bool {
        let is_first = self.shard.is_none_or(|shard| shard.index == 1);
        is_first && self.precision.unwrap_or(self.scenes.is_empty())
    }

    /// Rounds drawn and dropped before.
    #[must_use]
    pub fn warm_up_count(&self) -> u32 {
        if self.quick { 2 } else { 3 }
    }

    /// As `key=value`, for the environment file.
    #[must_use]
    pub fn describe(&self) -> Vec<String> {
        let mut lines = vec![
            format!("frames={}", self.frame_count()),
            format!("quick={}", self.quick),
            format!("size={}x{}", self.size.width, self.size.height),
        ];
        if !self.scenes.is_empty() {
            lines.push(format!("scenes={}", self.scenes.join("+")));
        }
        for (name, scenes) in [("ladder", &self.ladder), ("matrix", &self.matrix)] {
            if let Some(scenes) = scenes {
                lines.push(format!("{name}={}", scenes.join("+")));
            }
        }
        if let Some(wanted) = self.precision {
            lines.push(format!("precision={wanted}"));
        }
        if let Some(shard) = self.shard {
            lines.push(format!("shard={}/{}", shard.index, shard.count));
        }
        lines
    }
}

/// Why a run could not start or go on. Cases that fail one by one become rows instead.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A scene's file or a name is wrong.
    #[error(transparent)]
    Scene(#[from] terrafill_scene::SceneError),
    /// A scene's surface cannot be opened.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A scene's surface cannot be drawn in a view.
    #[error("{place}: {source}")]
    View {
        /// Scene file and view.
        place: String,
        /// Why.
        source: Box<SurfaceError>,
    },
    /// A backend that does not exist was asked for.
    #[error("backend {found:?}, allowed: {allowed}")]
    UnknownBackend {
        /// As given.
        found: String,
        /// Those there are.
        allowed: String,
    },
    /// No device can run anything.
    #[error("no usable device: {0}")]
    NoDevice(terrafill_fill::DeviceError),
    /// The run's folder.
    #[error(transparent)]
    Run(#[from] terrafill_results::legacy::RunError),
    /// A picture could not be written.
    #[error("{path}: {message}")]
    Image {
        /// Which file.
        path: PathBuf,
        /// Why.
        message: String,
    },
    /// Regions of a scene cannot be meshed.
    #[error("{lines}")]
    Mesh {
        /// Scene and problem, one line per region.
        lines: String,
    },
    /// A made-up shape cannot be meshed: a fault of this program.
    #[error("growth, {shape}: {message}")]
    Growth {
        /// Its family, or the file that it was read from.
        shape: String,
        /// Why.
        message: String,
    },
    /// The numerical suite broke off: the device is lost, or its own figures do not fit it.
    #[error("numerical suite: {message}")]
    Precision {
        /// Why.
        message: String,
    },
    /// A ladder or matrix was asked for of a scene that is not measured.
    #[error("{option}: found {found:?}, allowed: {allowed}")]
    NotInRun {
        /// Which option.
        option: &'static str,
        /// As given.
        found: String,
        /// Scenes of the run, and that for none.
        allowed: String,
    },
    /// Several scenes are wrong.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Several(Vec<BenchError>),
    /// Two scenes of the run have one name, so their rows could not be told apart.
    #[error("scene {name:?} is given twice, allowed: once")]
    SceneTwice {
        /// The name.
        name: String,
    },
    /// The device broke while baselines were measured, without which no row has a meaning.
    #[error("{scene}/{view}: {source}")]
    Device {
        /// Scene in hand.
        scene: String,
        /// View in hand.
        view: String,
        /// What happened.
        source: terrafill_fill::DeviceError,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_read_and_refused() {
        assert_eq!("2/3".parse(), Ok(Shard { index: 2, count: 3 }));
        for wrong in ["0/3", "4/3", "1", "a/b", "1/0", "-1/2"] {
            let error = wrong.parse::<Shard>().expect_err(wrong);
            assert!(
                error.contains(wrong) && error.contains("1 ≤ m ≤ n"),
                "{error}"
            );
        }
    }
}
