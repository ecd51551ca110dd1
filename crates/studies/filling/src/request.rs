// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is wanted of the study: a request's words as it understands them.

use crate::subject::{Surfaces, Techniques};
use terrafill_contract::{PlannedStep, Technique};
use terrafill_results::Skipped;
use terrafill_scene::{ImageSize, Scene, choices};
use terrafill_study::{Depth, Request, StudyError};

/// Name of the study.
pub const STUDY: &str = "filling";

/// Stands for no scene at all.
pub(crate) const NO_SCENE: &str = "none";

/// The scene whose ablation a full run measures unless others are named: it needs no data, and its
/// coasts are fine enough for vertices to matter.
const ABLATION_SCENE: &str = "planet-134";

/// Scenes of which a full run draws the matrix unless others are named: islands, one region close by,
/// and neighbours that share borders.
const MATRIX_SCENES: [&str; 3] = ["planet-134", "california", "countries-110m"];

/// Timed frames of a case in a process. Few: a process is one number, and more processes say more than
/// more frames of one.
const FRAMES: u32 = 2;
/// The same in a full run, whose intervals are to be narrow.
const FULL_FRAMES: u32 = 6;
/// Timed frames of a step in a process: few, since the first steps take seconds where the last take
/// milliseconds.
const ABLATION_FRAMES: u32 = 3;

/// Scene and first step of `SCENE:STEP`; no step where all are wanted.
pub(crate) fn ablation_part(wanted: &str) -> (&str, Option<&str>) {
    match wanted.split_once(':') {
        Some((scene, step)) => (scene, Some(step)),
        None => (wanted, None),
    }
}

/// What is wanted.
#[derive(Debug, Clone)]
pub(crate) struct Wishes {
    pub(crate) request: Request,
    /// All there are; the first is the one whose pictures the others' are laid beside.
    pub(crate) all_techniques: Techniques,
    pub(crate) surfaces: Surfaces,
    pub(crate) techniques: Vec<&'static dyn Technique>,
    /// Rivals to measure beside them.
    pub(crate) rivals: Vec<&'static dyn Technique>,
    /// Rivals that this machine lacks something for.
    pub(crate) missing_rivals: Vec<Skipped>,
    pub(crate) size: ImageSize,
}

impl Wishes {
    /// A rival takes part where it is named, or where no technique is and this machine has it.
    ///
    /// - `all`, `all_rivals`: those that there are
    ///
    /// # Errors
    /// [`StudyError::BadInput`] for a technique that there is not.
    pub(crate) fn new(
        request: &Request,
        [all, all_rivals]: [Techniques; 2],
        surfaces: Surfaces,
    ) -> Result<Self, StudyError> {
        let known = || all.iter().chain(all_rivals).map(|known| known.name());
        let unknown = |name: &&String| known().all(|known| known != *name);
        if let Some(name) = request.techniques.iter().find(unknown) {
            let allowed = choices(name, known());
            return Err(StudyError::BadInput(format!(
                "technique {name:?}, allowed: {allowed}"
            )));
        }
        let named = |list: Techniques| {
            let names = request.techniques.iter();
            let found = names.filter_map(|name| list.iter().find(|known| known.name() == name));
            found.copied().collect::<Vec<_>>()
        };
        let (mut techniques, mut rivals) = (named(all), named(all_rivals));
        let mut missing_rivals = Vec::new();
        if request.techniques.is_empty() {
            techniques = all.to_vec();
            for rival in all_rivals {
                match rival.missing() {
                    None => rivals.push(*rival),
                    Some(what) => missing_rivals.push(Skipped {
                        what: format!("technique {}", rival.name()),
                        reason: format!("this machine lacks {what}"),
                    }),
                }
            }
        }
        let [width, height] = request.size;
        Ok(Self {
            request: request.clone(),
            all_techniques: all,
            surfaces,
            techniques,
            rivals,
            missing_rivals,
            size: ImageSize { width, height },
        })
    }

    /// Whether sweeps are wanted, and all textured fills.
    pub(crate) fn is_full(&self) -> bool {
        self.request.depth == Depth::Full
    }

    /// Timed frames of a case in a process.
    pub(crate) fn frames(&self) -> u32 {
        let default = if self.is_full() { FULL_FRAMES } else { FRAMES };
        self.request.samples.unwrap_or(default)
    }

    /// Timed frames of a step, or of one of many variants of a textured fill.
    pub(crate) fn few_frames(&self) -> u32 {
        self.frames().min(ABLATION_FRAMES)
    }

    /// Whether approximate fills of this scene are wanted. Terrain is what they are off by; over the bare body a
    /// quick run and one over all scenes leave them out.
    pub(crate) fn wants_approximate(&self, scene: &Scene) -> bool {
        let Request {
            scenes,
            techniques,
            depth,
            ..
        } = &self.request;
        let is_asked_for = *depth == Depth::Main && !scenes.is_empty();
        self.is_full() || !techniques.is_empty() || is_asked_for || !scene.surface.is_bare()
    }

    /// Whether the ablation of this scene is wanted.
    pub(crate) fn wants_ablation(&self, scene: &str) -> bool {
        match self.request.settings.get("ablation") {
            Some(wanted) => wanted.iter().any(|wanted| ablation_part(wanted).0 == scene),
            None => self.is_full() && scene == ABLATION_SCENE,
        }
    }

    /// Scenes whose ablations were asked for, each with the step that it begins at.
    pub(crate) fn ablations(&self) -> impl Iterator<Item = (&str, Option<&str>)> {
        let wanted = self.request.settings.get("ablation").into_iter().flatten();
        wanted.map(|wanted| ablation_part(wanted))
    }

    /// The steps of `technique` that are wanted of a scene's ablation: all, or those from a step on.
    pub(crate) fn steps(&self, technique: &dyn Technique, scene: &Scene) -> Vec<PlannedStep> {
        let mut steps = technique.ablation(scene.overlap);
        let mut first = self.ablations().filter(|(name, _)| *name == scene.name);
        if let Some(step) = first.find_map(|(_, step)| step) {
            let place = steps.iter().position(|planned| planned.name == step);
            steps.drain(..place.unwrap_or(0));
        }
        steps
    }

    /// Whether the matrix of this scene is wanted.
    pub(crate) fn wants_matrix(&self, scene: &str) -> bool {
        match self.request.settings.get("matrix") {
            Some(scenes) => scenes.iter().any(|name| name == scene),
            None => self.is_full() && MATRIX_SCENES.contains(&scene),
        }
    }
}
