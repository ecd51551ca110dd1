// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a run folder's tables to the files of its report.

use crate::contents::Report;
use crate::glossary::{Glossary, TermGroup};
use crate::pages::{alone, pages};
use crate::verdict::{Counts, StudyNoise, Verdict, is_defect, named, noise, sentences, that_are};
use crate::view::{File, Form, INDEX, PAGES};
use crate::{ReportError, clocks, markdown};
use serde::Serialize;
use std::path::{Path, PathBuf};
use terrafill_plot::number::{bytes, count, utc};
use terrafill_results::{
    Block, Case, Chapter, ChapterError, DeviceClock, MetricRow, Outcome, Run, RunError, Skipped,
    read_clocks, read_inputs,
};

/// The verdict and the main tables.
const SUMMARY: &str = "summary.md";
/// The verdict for programs.
const RESULT: &str = "result.json";

/// What a report says in numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenReport {
    /// The page.
    pub path: PathBuf,
    /// How the run ended as a whole, with its exit code.
    pub verdict: Verdict,
    /// How many cases ended how.
    pub counts: Counts,
    /// Names of planned cases without a result.
    pub missing: Vec<String>,
    /// Names of cases that are wrong where they must not be, or broke off.
    pub defects: Vec<String>,
}

/// `result.json`.
#[derive(Serialize)]
struct ResultFile<'a> {
    schema: u32,
    verdict: Verdict,
    exit_code: u8,
    counts: Counts,
    missing: &'a [String],
    wrong_or_failed: &'a [String],
    skipped: &'a [Skipped],
    primary_clock: &'static str,
    processes: u32,
    noise: Vec<NoiseFile>,
}

#[derive(Serialize)]
struct NoiseFile {
    study: &'static str,
    metric: &'static str,
    pairs: usize,
    /// Largest and median factor by which identical work differed; absent without a pair.
    max_factor: Option<f64>,
    median_factor: Option<f64>,
}

/// Writes the report of the run in `folder`: `index.html` with its pages and figures in `pages/`,
/// `summary.md`, `result.json`, and the tables that the chapters derive. Each replaces an older one in
/// one step, so a reader never meets half a file; `pages/` keeps nothing of an older report.
///
/// - `terms`: words that chapters have in common, such as names of techniques and switches
///
/// # Errors
/// [`ReportError::Chapter`] when the folder holds no run, or a file in it does not fit the schema;
/// [`ReportError::Io`] when a file cannot be written.
pub fn write(
    folder: &Path,
    chapters: &[&dyn Chapter],
    terms: Vec<TermGroup>,
) -> Result<WrittenReport, ReportError> {
    write_as(folder, chapters, terms, Form::Pages)
}

/// Writes the same report with all its pages and pictures in `index.html`, which needs no file beside
/// it and can be mailed.
///
/// # Errors
/// As [`write()`].
pub fn write_single_file(
    folder: &Path,
    chapters: &[&dyn Chapter],
    terms: Vec<TermGroup>,
) -> Result<WrittenReport, ReportError> {
    write_as(folder, chapters, terms, Form::SingleFile)
}

/// Writes one page of blocks into `folder`, which is made where there is none: `index.html`, which
/// needs no file beside it. Pictures of a run are not among the blocks.
///
/// - `metrics`: declarations that headings refer to
///
/// # Errors
/// [`ReportError::Io`] when the file cannot be written.
pub fn write_page(
    folder: &Path,
    title: &str,
    blocks: &[Block],
    metrics: Vec<MetricRow>,
) -> Result<PathBuf, ReportError> {
    let path = folder.join(INDEX);
    replace(&path, alone(title, blocks, metrics)?.as_bytes())?;
    Ok(path)
}

fn write_as(
    folder: &Path,
    chapters: &[&dyn Chapter],
    mut terms: Vec<TermGroup>,
    form: Form,
) -> Result<WrittenReport, ReportError> {
    let run = Run::load(folder)?;
    let counts = Counts::of(&run);
    let (verdict, noise) = (counts.verdict(), noise(&run, chapters));
    let missing = named(&run, |case| case.outcome == Outcome::Missing);
    let defects = named(&run, is_defect);

    let mut parts = Vec::new();
    let mut files: Vec<File> = Vec::new();
    for chapter in chapters {
        let (blocks, answers) = (chapter.blocks(&run)?, chapter.answers(&run)?);
        if !blocks.is_empty() {
            terms.push((chapter.title(), chapter.terms().to_vec()));
            parts.push((*chapter, blocks, answers));
        }
        let tables = chapter.tables(&run)?.into_iter();
        files.extend(tables.map(|table| (table.file, table.text.into_bytes())));
    }
    let facts = environment(&run, &read_clocks(&run.path)?);
    let inputs = read_inputs(&run.path)?;
    let said = sentences(&run, &counts, &noise);
    let mut summary = markdown::head(&said.all(), &facts);
    markdown::names(&mut summary, "Missing cases", &missing);
    markdown::names(
        &mut summary,
        "Wrong and failed cases",
        &with_reasons(&run, is_defect),
    );
    let warned = inputs.iter().filter(|input| !input.warning.is_empty());
    let warned: Vec<String> = warned
        .map(|input| format!("{}: {}", input.scene, input.warning))
        .collect();
    markdown::names(&mut summary, "Warnings of what was read", &warned);
    let is_expected = |case: &Case| case.outcome == Outcome::DriverFault;
    markdown::names(
        &mut summary,
        "Cases that differ by a known driver fault",
        &with_reasons(&run, is_expected),
    );
    for (chapter, blocks, answers) in &parts {
        markdown::chapter(&mut summary, *chapter, blocks, answers);
    }
    let result = ResultFile {
        schema: terrafill_results::SCHEMA,
        verdict,
        exit_code: verdict.exit_code(),
        counts,
        missing: &missing,
        wrong_or_failed: &defects,
        skipped: &run.plan.skipped,
        primary_clock: run.clock().name(),
        processes: run.plan.processes,
        noise: noise.iter().map(noise_file).collect(),
    };
    files.push((SUMMARY.to_owned(), summary.into_bytes()));
    let result = serde_json::to_string_pretty(&result).map_err(ReportError::Result)?;
    files.push((RESULT.to_owned(), (result + "\n").into_bytes()));
    let report = Report {
        run: &run,
        form,
        verdict,
        said,
        environment: facts,
        inputs: &inputs,
        missing: &missing,
        wrong: with_reasons(&run, is_defect),
        skipped_cases: skipped_cases(&run),
        contradictions: chapters
            .iter()
            .flat_map(|c| c.contradictions(&run))
            .collect(),
        parts: &parts,
        glossary: Glossary::new(terms, &run.metrics),
    };
    // The first page last: what it refers to is there.
    files.extend(pages(&report)?);
    for (file, contents) in &files {
        replace(&folder.join(file), contents)?;
    }
    remove_others(folder, PAGES, &files)?;
    Ok(WrittenReport {
        path: folder.join(INDEX),
        verdict,
        counts,
        missing,
        defects,
    })
}

/// Removes what an older report left in its own folder.
fn remove_others(folder: &Path, below: &str, files: &[File]) -> Result<(), ReportError> {
    let path = folder.join(below);
    let failed = |source| ReportError::Io {
        path: path.clone(),
        source,
    };
    if !path.is_dir() {
        return Ok(());
    }
    for entry in std::fs::read_dir(&path).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = format!("{below}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            remove_others(folder, &name, files)?;
        } else if !files.iter().any(|(file, _)| *file == name) {
            std::fs::remove_file(entry.path()).map_err(failed)?;
        }
    }
    // Only an empty one can be removed.
    drop(std::fs::remove_dir(&path));
    Ok(())
}

fn with_reasons(run: &Run, so: impl Fn(&Case) -> bool) -> Vec<String> {
    that_are(run, so)
        .map(|case| format!("{}: {}: {}", case.id(), case.outcome.name(), case.reason))
        .collect()
}

/// Names of skipped cases by reason, in order of appearance.
fn skipped_cases(run: &Run) -> Vec<(&str, Vec<String>)> {
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for case in that_are(run, |case| case.outcome == Outcome::Skipped) {
        let name = case.id().key();
        match groups.iter_mut().find(|(reason, _)| *reason == case.reason) {
            Some((_, names)) => names.push(name),
            None => groups.push((&case.reason, vec![name])),
        }
    }
    groups
}

fn noise_file(of: &StudyNoise) -> NoiseFile {
    NoiseFile {
        study: of.study,
        metric: of.metric,
        pairs: of.noise.map_or(0, |noise| noise.pairs),
        max_factor: of.noise.map(|noise| noise.max_factor()),
        median_factor: of.noise.map(|noise| noise.median_factor()),
    }
}

fn environment(run: &Run, read: &[DeviceClock]) -> Vec<(&'static str, String)> {
    let e = &run.environment;
    let number = |value: u64| match value {
        0 => String::new(),
        value => count(value),
    };
    let image = match (e.width, e.height) {
        (0, _) | (_, 0) => String::new(),
        (width, height) => format!("{width} × {height} px"),
    };
    let ids = match (e.vendor_id, e.device_id) {
        (0, 0) => String::new(),
        (vendor, device) => format!("{vendor:#06x} : {device:#06x}"),
    };
    let shard = run
        .plan
        .shard
        .map(|s| format!("{} of {}", s.index, s.count));
    let mut facts = vec![
        ("started", utc(e.started_unix_s)),
        ("commit", e.commit.clone()),
        ("build", e.profile.clone()),
        ("graphics API", e.api.clone()),
        ("adapter", e.gpu.clone()),
        ("device type", e.device_type.clone()),
        ("vendor : device", ids),
        (
            "driver",
            format!("{} {}", e.driver, e.driver_info).trim().to_owned(),
        ),
        ("Mesa", e.mesa_version.clone()),
        ("primary clock", run.clock().name().to_owned()),
        (
            "GPU timestamps",
            if e.gpu_timestamps { "yes" } else { "no" }.to_owned(),
        ),
        ("CPU", e.cpu.clone()),
        ("logical cores", number(u64::from(e.cores))),
        (
            "memory",
            Some(e.memory_bytes)
                .filter(|memory| *memory > 0)
                .map_or_else(String::new, bytes),
        ),
        ("system", e.os.clone()),
        ("image", image),
        (
            "processes",
            match run.plan.processes {
                1 => "1 process".to_owned(),
                several => format!("{several} processes"),
            },
        ),
        ("warm-up blocks", run.plan.warm_up.to_string()),
        ("shard", shard.unwrap_or_else(|| "all".to_owned())),
        ("options", e.options.join("  ")),
        ("shader hash", e.shader_hash.clone()),
    ];
    // A run of a version that did not read them has nothing to say.
    facts.extend(clocks::sentence(read).map(|said| ("device clocks", said)));
    facts
}

/// Writes beside the file and renames, so that a kill in between leaves the old file whole.
fn replace(path: &Path, contents: &[u8]) -> Result<(), ReportError> {
    let unfinished = path.with_added_extension("new");
    let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    folder
        .and_then(|()| std::fs::write(&unfinished, contents))
        .and_then(|()| std::fs::rename(&unfinished, path))
        .map_err(|source| ReportError::Io {
            path: path.to_owned(),
            source,
        })
}

impl From<RunError> for ReportError {
    fn from(error: RunError) -> Self {
        Self::Chapter(ChapterError::Run(error))
    }
}
