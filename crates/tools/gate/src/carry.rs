// SPDX-License-Identifier: MIT OR Apache-2.0
//! A change that edits a scene is measured over the edited scene on both sides: the new version's scene file is
//! written out and given to both programs by its path. The base would else run the scene as it was, and no case
//! of the two would be the same work.

use crate::program::file_at;
use crate::{GateError, Program};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;

/// Scenes that both programs run.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CarriedScenes {
    /// Names of shipped scenes, and paths of those that were carried.
    pub scenes: Vec<String>,
    /// Names of those that were.
    pub carried: Vec<String>,
}

/// Shipped scenes whose file the base's commit does not have as the new version does, by the path of a copy.
/// Scenes given by path are the same for both as they are, and a base that is a binary has no files to look at.
///
/// - `scenes`: names and paths as given
/// - `own`: text of a shipped scene of a new program that has no commit; `None` where it is not known
/// - `folder`: where copies go
///
/// # Errors
/// [`GateError::Io`].
pub fn carry_scenes(
    [base, new]: [&Program; 2],
    scenes: &[String],
    own: &dyn Fn(&str) -> Option<String>,
    folder: &Path,
) -> Result<CarriedScenes, GateError> {
    let mut found = CarriedScenes {
        scenes: scenes.to_vec(),
        carried: Vec::new(),
    };
    let Some(commit) = &base.commit else {
        return Ok(found);
    };
    for scene in &mut found.scenes {
        let path = format!("bench-scenes/{scene}.toml");
        let text = match &new.commit {
            Some(commit) => file_at(commit, &path),
            None => own(scene),
        };
        let Some(text) = text.filter(|text| file_at(commit, &path).as_ref() != Some(text)) else {
            continue;
        };
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        let copy = folder.join(format!("scenes/{:016x}/{scene}.toml", hasher.finish()));
        // A scene of a folder is in one here as well.
        let copies = copy.parent().unwrap_or(folder);
        std::fs::create_dir_all(copies).map_err(GateError::io(copies))?;
        std::fs::write(&copy, text).map_err(GateError::io(&copy))?;
        let copy = copy.canonicalize().map_err(GateError::io(&copy))?;
        let path = copy.display().to_string();
        found.carried.push(std::mem::replace(scene, path));
    }
    Ok(found)
}

impl CarriedScenes {
    /// What an error of a gate means where scenes were carried: a base that cannot read them is not comparable, which
    /// says nothing for or against the new version.
    #[must_use]
    pub fn explain(&self, error: GateError) -> GateError {
        match error {
            GateError::Program { what, message }
                if !self.carried.is_empty() && what.starts_with("base") =>
            {
                GateError::Inconclusive(format!(
                    "{} was edited, and the base cannot run it as it is now: {message}",
                    self.carried.join(", ")
                ))
            }
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_base_that_cannot_run_a_carried_scene_is_inconclusive() {
        let failed = |what: &str| GateError::Program {
            what: what.to_owned(),
            message: "unknown field".to_owned(),
        };
        let carried = CarriedScenes {
            scenes: Vec::new(),
            carried: vec!["california".to_owned()],
        };
        let error = carried.explain(failed("base program main"));
        assert_eq!(error.exit_code(), 3);
        assert!(
            error.to_string().contains("california was edited"),
            "{error}"
        );
        // Negative controls: the new program's own failure, and nothing carried.
        assert_eq!(carried.explain(failed("new program topic")).exit_code(), 2);
        let none = CarriedScenes::default();
        assert_eq!(none.explain(failed("base program main")).exit_code(), 2);
    }

    #[test]
    fn a_base_without_a_commit_keeps_its_scenes() {
        let program = |commit: Option<&str>| Program {
            path: "p".into(),
            asked: "p".to_owned(),
            commit: commit.map(str::to_owned),
        };
        let scenes = ["california".to_owned()];
        let own = |_: &str| Some("name = \"california\"".to_owned());
        let place = tempfile::tempdir().expect("a folder");
        let [base, new] = [program(None), program(None)];
        let found = carry_scenes([&base, &new], &scenes, &own, place.path()).expect("read");
        assert_eq!((found.scenes, found.carried), (scenes.to_vec(), Vec::new()));
        // A commit that git does not know has no such file: the scene is written out.
        let base = program(Some("0000000"));
        let found = carry_scenes([&base, &new], &scenes, &own, place.path()).expect("written");
        assert_eq!(found.carried, scenes);
        let text = std::fs::read_to_string(&found.scenes[0]).expect("read");
        assert_eq!(text, "name = \"california\"");
    }
}
