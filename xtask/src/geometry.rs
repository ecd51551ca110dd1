// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shaders that WGSL cannot say, of geometry and mesh stages: the SPIR-V that is checked in against its GLSL.
//!
//! A fresh machine builds without a GLSL compiler, so the SPIR-V lies beside the sources. Where
//! `glslangValidator` is installed the sources are compiled again. The result must be the same byte for byte
//! if it is the version that made the files. Another version must at least accept them, since versions differ
//! in the code that they make. `spirv-val` judges the files as they are. A tool that is not there is named.

use anyhow::{Context as _, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;
use terrafill_shaders::{GlslStage, compiled_shaders, geometry_shaders};

/// Geometry shaders. Written down, so that a list that shrinks by accident fails.
const EXPECTED: usize = 9;
/// First line of the version of the compiler that made the files.
const COMPILER_FILE: &str = "native/compiler.txt";
/// Where the tools are looked for.
#[derive(Debug, Clone, Copy)]
struct Tools<'a> {
    compiler: &'a str,
    validator: &'a str,
}

const TOOLS: Tools<'static> = Tools {
    compiler: "glslangValidator",
    validator: "spirv-val",
};

/// Checks the SPIR-V below `folder`.
pub(crate) fn check(folder: &Path) -> Result<String> {
    check_with(folder, TOOLS)
}

fn check_with(folder: &Path, tools: Tools<'_>) -> Result<String> {
    let shaders = geometry_shaders();
    if shaders.len() != EXPECTED {
        bail!(
            "{} geometry shaders, expected {EXPECTED}: if that is meant, change the number in xtask",
            shaders.len()
        );
    }
    let recorded = crate::source::read(&folder.join(COMPILER_FILE))?;
    let compiled = match version(tools.compiler)? {
        None => format!("{}: not installed, not compared", tools.compiler),
        Some(found) => {
            let is_same = found == recorded.trim();
            compare(folder, tools.compiler, outputs(), is_same)?;
            if is_same {
                "as compiled again".to_owned()
            } else {
                format!(
                    "compiled again, and not compared: {found:?} is here, {:?} made them",
                    recorded.trim()
                )
            }
        }
    };
    let validated = if version(tools.validator)?.is_none() {
        format!("{}: not installed, not run", tools.validator)
    } else {
        for output in outputs() {
            let (_, target) = output.stage.compiled_for();
            run(Command::new(tools.validator)
                .args(["--target-env", target])
                .arg(folder.join(output.spirv)))?;
        }
        format!("{}: clean", tools.validator)
    };
    Ok(format!(
        "{} geometry shaders, {} SPIR-V files: {compiled}; {validated}",
        shaders.len(),
        outputs().count()
    ))
}

/// Compiles every source below `folder` anew, and writes down by which compiler.
pub(crate) fn compile(folder: &Path) -> Result<String> {
    let Some(found) = version(TOOLS.compiler)? else {
        bail!("{} is not installed", TOOLS.compiler);
    };
    let mut count = 0;
    for output in outputs() {
        let bytes = compile_one(folder, TOOLS.compiler, &output)?;
        let path = folder.join(output.spirv);
        std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
        count += 1;
    }
    let record = folder.join(COMPILER_FILE);
    std::fs::write(&record, format!("{found}\n")).with_context(|| record.display().to_string())?;
    Ok(format!("{count} SPIR-V files written by {found}"))
}

/// A SPIR-V file and what it is made of.
struct Output {
    source: &'static str,
    spirv: &'static str,
    stage: GlslStage,
    defines: Vec<&'static str>,
}

fn outputs() -> impl Iterator<Item = Output> {
    let geometry = geometry_shaders().iter().flat_map(|shader| {
        let kinds = shader.spirv.iter();
        kinds.map(|&(hands_on, spirv)| Output {
            source: shader.source,
            spirv,
            stage: GlslStage::Geometry,
            defines: hands_on.define().into_iter().collect(),
        })
    });
    geometry.chain(compiled_shaders().iter().map(|shader| Output {
        source: shader.source,
        spirv: shader.spirv,
        stage: shader.stage,
        defines: shader.defines.to_vec(),
    }))
}

fn compare(
    folder: &Path,
    compiler: &str,
    outputs: impl Iterator<Item = Output>,
    bytes_must_agree: bool,
) -> Result<()> {
    for output in outputs {
        let again = compile_one(folder, compiler, &output)?;
        let Output { source, spirv, .. } = output;
        let path = folder.join(spirv);
        let there = std::fs::read(&path).with_context(|| path.display().to_string())?;
        if bytes_must_agree && there != again {
            bail!(
                "{spirv} is not what {source} gives: {} bytes there, {} bytes compiled again; \
                 cargo xtask compile-shaders writes it anew",
                there.len(),
                again.len()
            );
        }
    }
    Ok(())
}

fn compile_one(folder: &Path, compiler: &str, output: &Output) -> Result<Vec<u8>> {
    let scratch = Scratch::new()?;
    let (stage, target) = output.stage.compiled_for();
    let mut command = Command::new(compiler);
    command.args(["--target-env", target, "-S", stage]);
    let defines = output.defines.iter().map(|define| format!("-D{define}"));
    command.args(defines).arg("-o").arg(&scratch.0);
    run(command.arg(folder.join(output.source)))?;
    std::fs::read(&scratch.0).with_context(|| scratch.0.display().to_string())
}

/// A file that goes again.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self> {
        use std::sync::atomic::{AtomicU32, Ordering};
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("terrafill-xtask-{}-{number}.spv", std::process::id());
        Ok(Self(std::env::temp_dir().join(name)))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // If it is not there, all is well.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// First line of what a tool says of itself; `None` where it is not installed.
fn version(tool: &str) -> Result<Option<String>> {
    match Command::new(tool).arg("--version").output() {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout);
            Ok(Some(text.lines().next().unwrap_or("").trim().to_owned()))
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error).context(tool.to_owned()),
    }
}

fn run(command: &mut Command) -> Result<()> {
    let output = command
        .output()
        .with_context(|| format!("{command:?} does not start"))?;
    if output.status.success() {
        return Ok(());
    }
    bail!(
        "{command:?}: {}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A copy of the shaders that may be broken.
    fn copy() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("temporary folder");
        for own in ["native", "casters", "globes"] {
            let from = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../shaders")
                .join(own);
            let to = folder.path().join(own);
            std::fs::create_dir(&to).expect("writable");
            for entry in std::fs::read_dir(from).expect("readable") {
                let path = entry.expect("readable").path();
                let name = path.file_name().expect("a file");
                std::fs::copy(&path, to.join(name)).expect("writable");
            }
        }
        folder
    }

    fn is_installed(tool: &str) -> bool {
        let there = version(tool).expect("starts or is not there").is_some();
        if !there {
            eprintln!("skipped: {tool} is not installed");
        }
        there
    }

    #[test]
    fn a_source_that_changed_is_noticed_where_the_compiler_is_there() {
        if !is_installed(TOOLS.compiler) {
            return;
        }
        let folder = copy();
        // One source of several files: each of them takes a moment to compile.
        let of_walls = || outputs().filter(|output| output.source == "native/walls.geom");
        let compared = |is_exact| compare(folder.path(), TOOLS.compiler, of_walls(), is_exact);
        for output in of_walls() {
            // Whatever version of the compiler is here.
            let bytes = compile_one(folder.path(), TOOLS.compiler, &output).expect("compiles");
            std::fs::write(folder.path().join(output.spirv), bytes).expect("writable");
        }
        compared(true).expect("compiled just now");
        let walls = folder.path().join("native/walls.geom");
        let text = std::fs::read_to_string(&walls).expect("readable");
        let turned = text.replace("wall(0, 1)", "wall(1, 0)");
        assert_ne!(text, turned);
        std::fs::write(&walls, turned).expect("writable");
        let error = compared(true).expect_err("differs");
        assert!(error.to_string().contains("native/walls.spv"), "{error}");
        compared(false).expect("it compiles");
        std::fs::write(&walls, "#version 450\nvoid main() { nothing(); }").expect("writable");
        assert!(compared(false).is_err());
    }

    #[test]
    fn broken_spirv_is_noticed_where_the_validator_is_there() {
        let tools = Tools {
            compiler: "no-such-compiler",
            ..TOOLS
        };
        if !is_installed(tools.validator) {
            return;
        }
        let folder = copy();
        let summary = check_with(folder.path(), tools).expect("clean");
        assert!(summary.contains("spirv-val: clean"), "{summary}");
        let caps = folder.path().join("native/caps.spv");
        let bytes = std::fs::read(&caps).expect("readable");
        std::fs::write(&caps, &bytes[..bytes.len() - 4]).expect("writable");
        let error = check_with(folder.path(), tools).expect_err("cut off");
        assert!(error.to_string().contains("caps.spv"), "{error}");
    }

    #[test]
    fn tools_that_are_not_there_are_named() {
        let tools = Tools {
            compiler: "no-such-compiler",
            validator: "no-such-validator",
        };
        let summary = check_with(copy().path(), tools).expect("nothing to run");
        for words in [
            "no-such-compiler: not installed",
            "no-such-validator: not installed",
        ] {
            assert!(summary.contains(words), "{summary}");
        }
    }

    #[test]
    fn another_version_compiles_and_compares_nothing() {
        if !is_installed(TOOLS.compiler) {
            return;
        }
        let folder = copy();
        let record = folder.path().join(COMPILER_FILE);
        std::fs::write(record, "another\n").expect("writable");
        let summary = check_with(folder.path(), TOOLS).expect("compiles");
        assert!(summary.contains("not compared"), "{summary}");
    }
}
