// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether the gate catches mistakes: each is made in a worktree, built, and gated against the tree as it is.
//! It is caught where the gate fails and names the counter that the mistake moves.

use anyhow::{Context as _, Result, bail};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A mistake that still draws the right pictures.
struct Mutation {
    name: &'static str,
    file: &'static str,
    /// Text that occurs once in the file.
    from: &'static str,
    to: &'static str,
    /// What it moves.
    counter: &'static str,
}

/// Of the plan and of a technique.
const MUTATIONS: [Mutation; 11] = [
    Mutation {
        name: "horizon-cull-dropped",
        file: "crates/contract/plan/src/plan.rs",
        from: "options.horizon_culling && self.horizon",
        to: "options.horizon_culling && false && self.horizon",
        counter: "regions_left_out",
    },
    Mutation {
        name: "level-of-detail-skipped",
        file: "crates/contract/plan/src/plan.rs",
        from: "levels.pick(&drawn, pixels, look)",
        to: "levels.pick(&drawn, 1e-9 * pixels, look)",
        counter: "cap_triangles",
    },
    Mutation {
        name: "rectangle-too-large",
        file: "crates/contract/plan/src/plan.rs",
        from: "                screen_rect,\n                near_rectangle",
        to: "                screen_rect: PixelRect::full(self.size),\n                near_rectangle",
        // Regions whose rectangles overlap share no pass, and each pass has pipelines of its own.
        counter: "pipeline_creations",
    },
    Mutation {
        name: "walls-too-tall",
        file: "crates/contract/plan/src/plan.rs",
        from: "clearance_m: cap_clearance_m(view),",
        to: "clearance_m: 100.0 * cap_clearance_m(view),",
        counter: "wall_height_m",
    },
    Mutation {
        name: "constants-uploaded-every-frame",
        file: "crates/devices/gpu/src/fill.rs",
        from: "let passes = loaded.map_or(0, |loaded| loaded.work.program.passes.len());",
        to: "let passes = loaded.map_or(0, |loaded| loaded.work.program.passes.len());
        if let Some(loaded) = loaded {
            gpu.write_buffer(&loaded.constants, 0, &loaded.work.constants);
        }",
        counter: "steady_uploads",
    },
    Mutation {
        name: "draws-of-nothing",
        file: "crates/techniques/instanced/src/volumes.rs",
        from: "pass.draw_indexed(indices, base_vertex, volume);",
        to: "pass.draw_indexed(first..first, base_vertex, volume);
                pass.draw_indexed(indices, base_vertex, volume);",
        counter: "draws",
    },
    Mutation {
        name: "bottom-caps-drawn-without-need",
        file: "crates/techniques/instanced/src/pipeline.rs",
        from: "all.filter(move |part| !(without_bottom && *part == Self::BottomCap))",
        to: "all.filter(move |part| !(without_bottom && *part == Self::BottomCap && false))",
        counter: "draws",
    },
    Mutation {
        name: "buffer-made-twice",
        file: "crates/techniques/instanced/src/volumes.rs",
        from: "walls: upload(\"walls\", walls, vertex)?,",
        to: "walls: {
                upload(\"walls\", walls, vertex)?;
                upload(\"walls\", walls, vertex)?
            },",
        counter: "buffer_creations",
    },
    Mutation {
        name: "pipelines-made-twice",
        file: "crates/techniques/instanced/src/pipeline.rs",
        from: "let pipeline = self.volume_pipeline(gpu, part, state);",
        to: "self.volume_pipeline(gpu, part, state);
            let pipeline = self.volume_pipeline(gpu, part, state);",
        counter: "pipeline_creations",
    },
    Mutation {
        name: "indices-too-wide",
        file: "crates/volumes/stencil/src/index_lists.rs",
        from: "vertices <= 0x1_0000",
        to: "vertices <= 4",
        counter: "index_bytes",
    },
    Mutation {
        name: "vertices-stored-twice",
        file: "crates/techniques/instanced/src/layout.rs",
        from: "self.vertices.extend(positions);",
        to: "self.vertices.extend(positions.clone());
        self.vertices.extend(positions);",
        counter: "vertex_bytes",
    },
];

/// What is measured: a globe with regions behind the horizon, full plans among the cases.
const BENCH: [&str; 7] = [
    "planet-134",
    "--technique",
    "instanced",
    "--size",
    "64",
    "--main",
    "--no-time",
];

/// Makes the mistakes of these names, or all, and prints a table.
///
/// # Errors
/// A mistake that is not caught or whose text is not in its file any more; a build that fails; a name that
/// is none of them.
pub(crate) fn check(root: &Path, names: &[&str]) -> Result<String> {
    if let Some(unknown) = names
        .iter()
        .find(|name| MUTATIONS.iter().all(|mutation| mutation.name != **name))
    {
        let all: Vec<&str> = MUTATIONS.iter().map(|mutation| mutation.name).collect();
        bail!("found {unknown:?}, allowed: {}", all.join(", "));
    }
    let is_asked = |mutation: &&Mutation| names.is_empty() || names.contains(&mutation.name);
    let place = MutationTree::new(root)?;
    let base = place.base()?;
    let mut table = String::from("| mistake | counter | caught | gate |\n|---|---|---|---|\n");
    let (mut count, mut caught) = (0, 0);
    for mutation in MUTATIONS.iter().filter(is_asked) {
        let row = place.try_out(mutation, &base);
        let row = row.with_context(|| mutation.name)?;
        count += 1;
        caught += usize::from(row.is_caught);
        let is_caught = if row.is_caught { "yes" } else { "no" };
        let Mutation { name, counter, .. } = mutation;
        let _ = writeln!(
            table,
            "| {name} | `{counter}` | {is_caught} | {} |",
            row.words
        );
        eprintln!("{name}: {is_caught}, {}", row.words);
    }
    let summary = format!("{table}\n{caught} of {count} caught by the name of the counter");
    if caught < count {
        bail!("{summary}");
    }
    Ok(summary)
}

/// What the gate said of a mistake.
struct Row {
    is_caught: bool,
    words: String,
}

/// A worktree to make mistakes in, with a target folder that stays, so that third-party crates are built once.
struct MutationTree {
    folder: PathBuf,
    tree: PathBuf,
    commit: String,
}

impl MutationTree {
    fn new(root: &Path) -> Result<Self> {
        let folder = root.join("target/mutations");
        std::fs::create_dir_all(&folder)?;
        let tree = folder.join("tree");
        let mut rev_parse = Command::new("git");
        let output = rev_parse
            .args(["rev-parse", "HEAD"])
            .current_dir(root)
            .output()?;
        let commit = String::from_utf8(output.stdout)?.trim().to_owned();
        let place = Self {
            folder,
            tree,
            commit,
        };
        if !place.tree.exists() {
            let tree = place.tree.display().to_string();
            place.git(root, &["worktree", "prune"])?;
            place.git(root, &["worktree", "add", "--detach", &tree, &place.commit])?;
        }
        place.git(
            &place.tree,
            &["checkout", "--force", "--detach", &place.commit],
        )?;
        Ok(place)
    }

    fn git(&self, place: &Path, arguments: &[&str]) -> Result<()> {
        let mut git = Command::new("git");
        run(git.args(arguments).current_dir(place), "git")
    }

    /// The program without a mistake; built once for a commit.
    fn base(&self) -> Result<PathBuf> {
        let program = self.folder.join(format!("base-{}", self.commit));
        if !program.is_file() {
            self.build(&program)?;
        }
        Ok(program)
    }

    fn build(&self, program: &Path) -> Result<()> {
        let mut cargo = Command::new("cargo");
        cargo.args(["build", "--locked", "--package", "terrafill"]);
        // Not the repository's own: cargo tells the crates of two worktrees apart by no path, so that what is
        // built here would be taken for what is built there.
        let target = self.folder.join("target");
        // Warnings are errors elsewhere; a mistake may leave something unused.
        cargo
            .current_dir(&self.tree)
            .env("CARGO_TARGET_DIR", &target);
        run(&mut cargo, "cargo build")?;
        std::fs::copy(target.join("debug/terrafill"), program)?;
        Ok(())
    }

    fn try_out(&self, mutation: &Mutation, base: &Path) -> Result<Row> {
        let path = self.tree.join(mutation.file);
        let text = std::fs::read_to_string(&path)?;
        std::fs::write(&path, mutated(mutation, &text)?)?;
        let program = self.folder.join("mutated");
        let built = self.build(&program);
        std::fs::write(&path, text)?;
        built?;
        let out = self.folder.join("gate");
        if out.exists() {
            std::fs::remove_dir_all(&out)?;
        }
        let status = Command::new(base)
            .arg("gate")
            .args(BENCH)
            .arg("--base")
            .arg(base)
            .arg("--new")
            .arg(&program)
            .arg("--out")
            .arg(&out)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .status()?;
        let report = std::fs::read_to_string(out.join("gate.json")).context("no verdict")?;
        judge(mutation, status.code(), &serde_json::from_str(&report)?)
    }
}

/// The file with the mistake in it.
fn mutated(mutation: &Mutation, text: &str) -> Result<String> {
    match text.matches(mutation.from).count() {
        1 => Ok(text.replacen(mutation.from, mutation.to, 1)),
        found => bail!(
            "{}: found {:?} {found} times, expected once",
            mutation.file,
            mutation.from
        ),
    }
}

/// Whether a gate caught a mistake by its counter, and what it said first about that.
fn judge(mutation: &Mutation, code: Option<i32>, report: &Value) -> Result<Row> {
    let findings = report["findings"].as_array().context("no findings")?;
    let text = |finding: &Value, key: &str| finding[key].as_str().unwrap_or_default().to_owned();
    let is_counted = |finding: &&Value| {
        finding["severity"] == "worse" && text(finding, "metric") == mutation.counter
    };
    let found: Vec<&Value> = findings.iter().filter(is_counted).collect();
    let words = if let Some(first) = found.first() {
        format!(
            "exit {}, {} cases, {} → {}",
            code.unwrap_or(-1),
            found.len(),
            text(first, "from"),
            text(first, "to")
        )
    } else {
        let mut others: Vec<String> = findings.iter().map(|f| text(f, "metric")).collect();
        others.sort();
        others.dedup();
        format!("exit {}, names {}", code.unwrap_or(-1), others.join(", "))
    };
    Ok(Row {
        is_caught: code == Some(1) && !found.is_empty(),
        words,
    })
}

fn run(command: &mut Command, what: &str) -> Result<()> {
    let status = command.stdin(Stdio::null()).status();
    let status = status.with_context(|| format!("{what} does not start"))?;
    if !status.success() {
        bail!("{what}: {status}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_mistake_can_still_be_made() {
        let root = crate::root();
        for mutation in &MUTATIONS {
            let text = std::fs::read_to_string(root.join(mutation.file)).expect(mutation.file);
            let changed = mutated(mutation, &text).expect(mutation.name);
            assert_ne!(changed, text);
            // Negative control: where the text is gone, nothing is tried out.
            assert!(mutated(mutation, &changed.replace(mutation.from, "")).is_err());
        }
    }

    #[test]
    fn a_mistake_is_caught_by_its_counter_and_by_nothing_else() {
        let mutation = &MUTATIONS[0];
        let report = |metric: &str, severity: &str| {
            json!({"findings": [
                {"metric": metric, "severity": severity, "from": "77", "to": "0"}
            ]})
        };
        let is_caught =
            |code, report: &Value| judge(mutation, code, report).expect("read").is_caught;
        let right = report(mutation.counter, "worse");
        assert!(is_caught(Some(1), &right));
        assert!(!is_caught(Some(0), &right));
        assert!(!is_caught(None, &right));
        assert!(!is_caught(Some(1), &report("status", "worse")));
        assert!(!is_caught(Some(1), &report(mutation.counter, "note")));
        assert!(judge(mutation, Some(1), &json!({})).is_err());
    }

    #[test]
    fn a_name_that_is_no_mistake_is_refused() {
        let error = check(Path::new("/nowhere"), &["none"]).expect_err("refused");
        assert!(error.to_string().contains("rectangle-too-large"), "{error}");
    }
}
