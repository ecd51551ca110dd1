// SPDX-License-Identifier: MIT OR Apache-2.0
//! Programs to be compared: a binary as it is, or a git revision that is built in a worktree of its own.

use crate::GateError;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A program, ready to run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Program {
    /// The binary.
    pub path: PathBuf,
    /// As it was asked for.
    pub asked: String,
    /// Its commit, where it was built from one.
    pub commit: Option<String>,
}

impl Program {
    /// The binary of this path, or that of a git revision of the repository around the working folder.
    ///
    /// - `cache`: keeps built binaries by commit
    ///
    /// # Errors
    /// [`GateError::BadInput`] for what is neither; [`GateError::Program`] where the build fails.
    pub fn find(asked: &str, cache: &Path) -> Result<Self, GateError> {
        let path = Path::new(asked);
        if path.is_file() {
            let path = path.canonicalize().map_err(GateError::io(path))?;
            return Ok(Self {
                path,
                asked: asked.to_owned(),
                commit: None,
            });
        }
        let revision = format!("{asked}^{{commit}}");
        let options = ["rev-parse", "--verify", "--quiet", "--end-of-options"];
        let commit = git(&[&options[..], &[&revision]].concat()).ok_or_else(|| {
            let is_shallow = git(&["rev-parse", "--is-shallow-repository"]);
            let hint = match is_shallow.as_deref().map(str::trim) {
                Some("true") => {
                    ", which is a shallow clone: fetch its whole history (fetch-depth: 0)"
                }
                _ => "",
            };
            GateError::BadInput(format!(
                "{asked:?}: found neither a program nor a git revision of this repository{hint}"
            ))
        })?;
        let commit = commit.trim().to_owned();
        Ok(Self {
            path: build(&commit, cache)?,
            asked: asked.to_owned(),
            commit: Some(commit),
        })
    }

    /// Whether its verb `bench` has this option.
    #[must_use]
    pub(crate) fn knows(&self, option: &str) -> bool {
        // The help comes only where everything before it is understood.
        let mut command = Command::new(&self.path);
        let help = command
            .args(["bench", option, "--help"])
            .stdin(Stdio::null());
        let output = help.stdout(Stdio::null()).stderr(Stdio::null()).status();
        output.is_ok_and(|status| status.success())
    }

    /// What it is called in a report: `main (4e23c86)`, or its path.
    #[must_use]
    pub fn label(&self) -> String {
        match &self.commit {
            Some(commit) => {
                let short = &commit[..commit.len().min(7)];
                if self.asked.starts_with(short) {
                    short.to_owned()
                } else {
                    format!("{} ({short})", self.asked)
                }
            }
            None => self.asked.clone(),
        }
    }
}

/// Refuses two programs of which nothing can be learnt: one file, one commit, equal bytes, or a new one
/// that is an ancestor of the base.
///
/// # Errors
/// [`GateError::BadInput`]; [`GateError::NothingMeasured`] for equal bytes under two names.
pub fn refuse_equal_programs(base: &Program, new: &Program) -> Result<(), GateError> {
    let bad = |message: String| Err(GateError::BadInput(message));
    if base.path == new.path || (base.commit.is_some() && base.commit == new.commit) {
        return bad(format!(
            "base and new are one program: {}",
            base.path.display()
        ));
    }
    let read = |of: &Program| std::fs::read(&of.path).map_err(GateError::io(&of.path));
    if read(base)? == read(new)? {
        return Err(GateError::NothingMeasured(format!(
            "{} and {} are equal to the last byte",
            base.label(),
            new.label()
        )));
    }
    if let (Some(old), Some(late)) = (&base.commit, &new.commit) {
        let is_reversed = Command::new("git")
            .args(["merge-base", "--is-ancestor", late, old])
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|status| status.success());
        if is_reversed {
            return bad(format!(
                "base {} is a descendant of new {}: are they the wrong way round?",
                base.label(),
                new.label()
            ));
        }
    }
    Ok(())
}

/// What git prints; `None` where it fails or there is none.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then_some(text)
}

/// Text of a file of this repository as a commit has it; `None` where it has none.
pub(crate) fn file_at(commit: &str, path: &str) -> Option<String> {
    git(&["show", &format!("{commit}:{path}")])
}

/// Builds a commit in a worktree that is removed afterwards. The cache's target folder stays, so that
/// the second revision builds the workspace's own crates alone.
fn build(commit: &str, cache: &Path) -> Result<PathBuf, GateError> {
    std::fs::create_dir_all(cache).map_err(GateError::io(cache))?;
    let cache = cache.canonicalize().map_err(GateError::io(cache))?;
    let folder = cache.join("bin").join(commit);
    let binary = folder.join("terrafill");
    if binary.is_file() {
        return Ok(binary);
    }
    let tree = cache.join("tree");
    let target = cache.join("target");
    remove_worktree(&tree);
    let steps = || -> Result<(), GateError> {
        let mut checkout = Command::new("git");
        checkout.args(["worktree", "add", "--force", "--detach"]);
        run(checkout.arg(&tree).arg(commit), "git worktree add")?;
        let mut cargo = Command::new("cargo");
        cargo.args(["build", "--release", "--locked", "--package", "terrafill"]);
        cargo.current_dir(&tree).env("CARGO_TARGET_DIR", &target);
        run(&mut cargo, "cargo build")
    };
    let built = steps();
    remove_worktree(&tree);
    built?;
    std::fs::create_dir_all(&folder).map_err(GateError::io(&folder))?;
    // Renamed into place, so that a copy that broke off is never taken for a program.
    let part = folder.join("terrafill.new");
    std::fs::copy(target.join("release/terrafill"), &part).map_err(GateError::io(&part))?;
    std::fs::rename(&part, &binary).map_err(GateError::io(&binary))?;
    Ok(binary)
}

/// What a build that was killed left as well.
fn remove_worktree(tree: &Path) {
    if tree.exists() {
        let path = tree.display().to_string();
        drop(git(&["worktree", "remove", "--force", &path]));
    }
    drop(git(&["worktree", "prune"]));
}

/// Runs to the end; what it says goes to standard error.
fn run(command: &mut Command, what: &str) -> Result<(), GateError> {
    let program = |message: String| GateError::Program {
        what: what.to_owned(),
        message,
    };
    let output = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::inherit())
        .status()
        .map_err(|error| program(error.to_string()))?;
    if output.success() {
        Ok(())
    } else {
        Err(program(output.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(path: &Path, commit: Option<&str>) -> Program {
        Program {
            path: path.to_owned(),
            asked: path.display().to_string(),
            commit: commit.map(str::to_owned),
        }
    }

    #[test]
    fn one_program_and_equal_programs_are_refused() {
        let place = tempfile::tempdir().expect("a folder");
        let write = |name: &str, bytes: &[u8]| {
            let path = place.path().join(name);
            std::fs::write(&path, bytes).expect("written");
            path
        };
        let (a, b, c) = (write("a", b"1"), write("b", b"1"), write("c", b"2"));
        let code = |base: &Program, new: &Program| {
            refuse_equal_programs(base, new).map_err(|error| error.exit_code())
        };
        assert_eq!(code(&program(&a, None), &program(&a, None)), Err(2));
        assert_eq!(code(&program(&a, None), &program(&b, None)), Err(4));
        assert_eq!(code(&program(&a, None), &program(&c, None)), Ok(()));
        let (x, y) = (program(&a, Some("f00")), program(&c, Some("f00")));
        assert_eq!(code(&x, &y), Err(2));
    }

    #[test]
    fn what_is_neither_a_program_nor_a_revision_is_refused() {
        let place = tempfile::tempdir().expect("a folder");
        for asked in ["/nowhere/terrafill", "no-such-revision", "--all", ""] {
            let error = Program::find(asked, place.path()).expect_err(asked);
            assert_eq!(error.exit_code(), 2, "{error}");
        }
    }

    #[test]
    fn labels_are_short() {
        let of = |asked: &str, commit: Option<&str>| {
            Program {
                path: PathBuf::new(),
                asked: asked.to_owned(),
                commit: commit.map(str::to_owned),
            }
            .label()
        };
        assert_eq!(of("main", Some("4e23c864e23c86")), "main (4e23c86)");
        assert_eq!(of("4e23c864e2", Some("4e23c864e23c86")), "4e23c86");
        assert_eq!(of("out/terrafill", None), "out/terrafill");
    }
}
