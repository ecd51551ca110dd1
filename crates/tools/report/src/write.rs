// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a run folder's tables to the files of its report.

use crate::verdict::{Counts, StudyNoise, Verdict, is_defect, named, noise, plural, sentences};
use crate::view::Renderer;
use crate::{ReportError, markdown};
use askama::Template;
use serde::Serialize;
use std::path::{Path, PathBuf};
use terrafill_plot::number::{bytes, count, utc};
use terrafill_results::{Block, Chapter, ChapterError, MetricRow, Outcome, Run, RunError, Skipped};

/// The page, within the run's folder.
const PAGE: &str = "index.html";
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

#[derive(Template)]
#[template(path = "page.html")]
struct Page<'a> {
    verdict: Verdict,
    sentences: &'a [String],
    missing: &'a [String],
    wrong: Vec<String>,
    skipped: &'a [Skipped],
    skipped_cases: Vec<(&'a str, Vec<String>)>,
    contradictions: Vec<String>,
    chapters: Vec<ChapterView>,
    environment: Vec<(&'static str, String)>,
    metrics: &'a [MetricRow],
    dark_rules: String,
}

struct ChapterView {
    id: String,
    title: &'static str,
    /// Ids and texts.
    sections: Vec<(String, String)>,
    html: String,
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

/// Writes the report of the run in `folder`: `index.html`, which needs no file beside it, `summary.md`,
/// `result.json`, and the tables that the chapters derive. Each replaces an older one in one step, so a
/// reader never meets half a file.
///
/// # Errors
/// [`ReportError::Chapter`] when the folder holds no run, or a file in it does not fit the schema;
/// [`ReportError::Io`] when a file cannot be written.
pub fn write(folder: &Path, chapters: &[&dyn Chapter]) -> Result<WrittenReport, ReportError> {
    let run = Run::load(folder)?;
    let counts = Counts::of(&run);
    let (verdict, noise) = (counts.verdict(), noise(&run, chapters));
    let sentences = sentences(&run, &counts, &noise);
    let missing = named(&run, |case| case.outcome == Outcome::Missing);
    let defects = named(&run, is_defect);

    let mut all: Vec<(&dyn Chapter, Vec<Block>)> = Vec::new();
    let mut files: Vec<(String, String)> = Vec::new();
    for chapter in chapters {
        let blocks = chapter.blocks(&run)?;
        if !blocks.is_empty() {
            all.push((*chapter, blocks));
        }
        let tables = chapter.tables(&run)?.into_iter();
        files.extend(tables.map(|table| (table.file, table.text)));
    }
    let facts = environment(&run);
    let mut summary = markdown::head(&sentences, &facts);
    markdown::names(&mut summary, "Missing cases", &missing);
    markdown::names(&mut summary, "Wrong and failed cases", &with_reasons(&run));
    for (chapter, blocks) in &all {
        markdown::chapter(&mut summary, chapter.title(), blocks);
    }
    let page = Page {
        verdict,
        sentences: &sentences,
        missing: &missing,
        wrong: with_reasons(&run),
        skipped: &run.plan.skipped,
        skipped_cases: skipped_cases(&run),
        contradictions: chapters
            .iter()
            .flat_map(|c| c.contradictions(&run))
            .collect(),
        chapters: chapter_views(&run, &all)?,
        environment: facts,
        metrics: &run.metrics,
        dark_rules: terrafill_plot::dark_rules(),
    };
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
    files.push((SUMMARY.to_owned(), summary));
    let result = serde_json::to_string_pretty(&result).map_err(ReportError::Result)?;
    files.push((RESULT.to_owned(), result + "\n"));
    files.push((PAGE.to_owned(), page.render()?));
    for (file, text) in &files {
        replace(&folder.join(file), text)?;
    }
    Ok(WrittenReport {
        path: folder.join(PAGE),
        verdict,
        counts,
        missing,
        defects,
    })
}

fn chapter_views(
    run: &Run,
    chapters: &[(&dyn Chapter, Vec<Block>)],
) -> Result<Vec<ChapterView>, ReportError> {
    let mut renderer = Renderer::new(run);
    let views = chapters.iter().map(|(chapter, blocks)| {
        let id = renderer.id(chapter.study());
        let html = renderer.html(blocks)?;
        Ok(ChapterView {
            id,
            title: chapter.title(),
            sections: renderer.take_sections(),
            html,
        })
    });
    views.collect()
}

fn with_reasons(run: &Run) -> Vec<String> {
    let cases = run
        .cases
        .iter()
        .filter(|case| !case.is_twin() && is_defect(case));
    cases
        .map(|case| format!("{}: {}: {}", case.id(), case.outcome.name(), case.reason))
        .collect()
}

/// Names of skipped cases by reason, in order of appearance.
fn skipped_cases(run: &Run) -> Vec<(&str, Vec<String>)> {
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    let skipped = |case: &&terrafill_results::Case| case.outcome == Outcome::Skipped;
    for case in run
        .cases
        .iter()
        .filter(skipped)
        .filter(|case| !case.is_twin())
    {
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

fn environment(run: &Run) -> Vec<(&'static str, String)> {
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
    vec![
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
            plural(run.plan.processes as usize, "replicate"),
        ),
        ("warm-up blocks", run.plan.warm_up.to_string()),
        ("shard", shard.unwrap_or_else(|| "all".to_owned())),
        ("options", e.options.join("  ")),
        ("shader hash", e.shader_hash.clone()),
    ]
}

/// Writes beside the file and renames, so that a kill in between leaves the old file whole.
fn replace(path: &Path, text: &str) -> Result<(), ReportError> {
    let mut unfinished = path.as_os_str().to_owned();
    unfinished.push(".new");
    let unfinished = PathBuf::from(unfinished);
    std::fs::write(&unfinished, text)
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
