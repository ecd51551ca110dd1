// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on extreme scenes: how many passed, were refused rightly or failed, and a row for each
//! view with its picture and with what its frame plan left out.

use super::keys::{EXPECTED, SCENE, SCENE_REASON, SUITE_CASE_S, VIEW};
use super::plan::{EXTREME, WHOLE};
use super::session::REFUSED;
use crate::keys::{
    FILL_CPU_MS, FILL_GPU_MS, MISMATCHED_PX, MISMATCHED_PX_OUTSIDE_BAND, REGIONS_DRAWN,
};
use terrafill_plot::number::significant;
use terrafill_results::{
    Answers, Block, Case, Cell, CellClass, Chapter, ChapterError, Clock, Finding, Heading, Metric,
    Outcome, Picture, PictureFigure, Pictures, Row, Run, Standing, Table, median, process_medians,
};

/// What came of scenes that globes usually break at.
#[derive(Debug, Clone, Copy, Default)]
pub struct ExtremeChapter;

/// How a view ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Came {
    Passed,
    Refused,
    Skipped,
    Missing,
    Failed,
}

impl Came {
    fn of(case: &Case) -> Self {
        match case.outcome {
            Outcome::Ok if case.note(REFUSED).is_empty() => Self::Passed,
            Outcome::Ok => Self::Refused,
            Outcome::Skipped => Self::Skipped,
            Outcome::Missing => Self::Missing,
            Outcome::Wrong | Outcome::Failed | Outcome::DriverFault => Self::Failed,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Refused => "refused rightly",
            Self::Skipped => "skipped",
            Self::Missing => "missing",
            Self::Failed => "failed",
        }
    }
}

/// One view with what each technique made of it.
struct View<'a> {
    scene: &'a str,
    name: &'a str,
    cases: Vec<&'a Case>,
}

impl View<'_> {
    /// Why its scene is in the suite.
    fn scene_reason(&self) -> &str {
        let first = self.cases.first();
        first.map_or("", |case| case.condition(SCENE_REASON))
    }

    /// Wall clock of all its techniques, seconds.
    fn seconds(&self) -> f64 {
        let cases = self.cases.iter();
        cases.filter_map(|case| case.value(SUITE_CASE_S)).sum()
    }

    /// The worst of its techniques.
    fn came(&self) -> Came {
        let came = self.cases.iter().map(|case| Came::of(case));
        came.max().unwrap_or(Came::Missing)
    }
}

/// Views in the plan's order.
fn views(run: &Run) -> Vec<View<'_>> {
    let mut views: Vec<View<'_>> = Vec::new();
    for case in run.of_study(EXTREME).filter(|case| !case.is_twin()) {
        let (scene, name) = (case.condition(SCENE), case.condition(VIEW));
        match views.last_mut() {
            Some(last) if (last.scene, last.name) == (scene, name) => last.cases.push(case),
            _ => views.push(View {
                scene,
                name,
                cases: vec![case],
            }),
        }
    }
    views
}

/// Views of one scene after the other.
fn by_scene<'v, 'a>(views: &'v [View<'a>]) -> impl Iterator<Item = &'v [View<'a>]> {
    views.chunk_by(|a, b| a.scene == b.scene)
}

fn count(views: &[View<'_>], came: Came) -> usize {
    views.iter().filter(|view| view.came() == came).count()
}

/// How many scenes and views there are and how they ended; `None` for a run without the suite.
#[must_use]
pub fn extreme_sentence(run: &Run) -> Option<String> {
    let views = views(run);
    if views.is_empty() {
        return None;
    }
    let ended = |came: Came| count(&views, came);
    let mut text = format!(
        "Extreme suite: {} scenes, {} views: {} passed, {} refused rightly, {} failed",
        by_scene(&views).count(),
        views.len(),
        ended(Came::Passed),
        ended(Came::Refused),
        ended(Came::Failed),
    );
    for came in [Came::Skipped, Came::Missing] {
        if ended(came) > 0 {
            text.push_str(&format!(", {} {}", ended(came), came.name()));
        }
    }
    text.push('.');
    Some(text)
}

impl Chapter for ExtremeChapter {
    fn study(&self) -> &'static str {
        EXTREME
    }

    fn title(&self) -> &'static str {
        "Extreme scenes"
    }

    fn primary_metric(&self, _clock: Clock) -> Option<&'static str> {
        None
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let Some(sentence) = extreme_sentence(run) else {
            return Ok(Answers::default());
        };
        let failed = count(&views(run), Came::Failed);
        Ok(Answers {
            blocks: vec![Block::Text(sentence.clone())],
            requirements: vec![Finding {
                claim: "Every scene of the extreme suite is right, or refused as it should be"
                    .to_owned(),
                standing: Standing::holds_if(failed == 0),
                because: sentence,
            }],
            ..Answers::default()
        })
    }

    fn has_long_sections(&self) -> bool {
        true
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let Some(sentence) = extreme_sentence(run) else {
            return Ok(Vec::new());
        };
        let views = views(run);
        let metric = run.clock().pick(FILL_GPU_MS, FILL_CPU_MS);
        let unit = run.clock().pick("GPU ms", "process CPU ms");
        let mut blocks = vec![Block::Text(sentence), Block::Remark(KEY.to_owned())];
        let failed: Vec<String> = views.iter().flat_map(failures).collect();
        if !failed.is_empty() {
            let summary = format!("{} cases failed", failed.len());
            blocks.push(Block::Alarm(summary));
            blocks.push(Block::List(failed));
        }
        blocks.push(Block::Table(summary(&views)));
        let headings = || {
            vec![
                Heading::plain("view"),
                Heading::plain("expected"),
                Heading::explained("result", "the worst of the techniques"),
                Heading::explained(
                    "mismatches",
                    "pixels that differ from the reference, most of the techniques",
                ),
                Heading::explained(
                    "outside the band",
                    "farther than one pixel from a boundary; 0 allowed",
                ),
                Heading::explained(format!("fill, {unit}"), "one frame of the first technique"),
                Heading::explained(
                    "all, s",
                    "wall clock of the whole view: reading, meshing, reference, every technique",
                ),
                Heading::explained("drawn", "regions in the frame plan"),
                Heading::explained("left out and why", "what the frame plan leaves out"),
                Heading::plain("picture"),
            ]
        };
        for scene in by_scene(&views) {
            let Some(first) = scene.first() else {
                continue;
            };
            blocks.push(Block::section(first.scene));
            blocks.push(Block::Text(format!("{}.", first.scene_reason())));
            blocks.push(Block::Table(Table {
                headings: headings(),
                rows: scene.iter().map(|view| row(view, metric)).collect(),
                ..Table::default()
            }));
            blocks.extend(pictures(scene));
        }
        Ok(blocks)
    }

    fn contradictions(&self, run: &Run) -> Vec<String> {
        let cases = run.of_study(EXTREME).filter(|case| !case.is_twin());
        let passed = cases.filter(|case| Came::of(case) == Came::Passed);
        let found = passed.filter_map(|case| {
            let name = case.id();
            match case.value(MISMATCHED_PX_OUTSIDE_BAND) {
                None => Some(format!("{name}: ok, but never compared with the reference")),
                Some(px) if px > 0.0 => Some(format!(
                    "{name}: ok, though {px} pixels outside the boundary band are wrong"
                )),
                Some(_) => None,
            }
        });
        found.collect()
    }
}

const KEY: &str = "Passed: every technique's picture matches the reference outside the 1-pixel boundary \
                   band, no figure is NaN or infinite, and the validation layer said nothing where it \
                   was on. A pixel whose surface lies within 2⁻²⁴ of its distance from a region's wall may \
                   show either side of the wall, or neither. Refused rightly: refused with the words that \
                   the scene expects.";

/// A line for each technique that failed.
fn failures(view: &View<'_>) -> Vec<String> {
    let failed = view
        .cases
        .iter()
        .filter(|case| Came::of(case) == Came::Failed);
    failed
        .map(|case| {
            let reason = match case.reason.as_str() {
                "" => "no reason was recorded",
                reason => reason,
            };
            format!("{}: {} ({reason})", case.id(), case.outcome.name())
        })
        .collect()
}

/// A row for each scene: why it is here and how its views ended.
fn summary(views: &[View<'_>]) -> Table {
    let ends = [Came::Passed, Came::Refused, Came::Failed];
    let mut headings = ["scene", "why it is here", "views"]
        .map(Heading::plain)
        .to_vec();
    headings.extend(ends.map(|came| Heading::plain(came.name())));
    headings.push(Heading::explained("all, s", "wall clock of all its views"));
    headings.push(Heading::plain("first view"));
    let row = |scene: &[View<'_>]| {
        let first = scene.first();
        let mut name = Cell::name(first.map_or("", |view| view.scene));
        name.section.clone_from(&name.text);
        let reason = first.map_or("", View::scene_reason);
        let mut cells = vec![
            name,
            Cell::name(reason),
            Cell::plain(scene.len().to_string()),
        ];
        cells.extend(ends.map(|came| Cell::plain(count(scene, came).to_string())));
        cells.push(Cell::plain(significant(
            scene.iter().map(View::seconds).sum(),
        )));
        let picture = first.and_then(|view| view.cases.first());
        cells.push(Cell {
            picture: picture.map_or("", |case| case.note("image")).to_owned(),
            ..Cell::default()
        });
        let worst = scene.iter().map(View::came).max();
        Row {
            cells,
            status: worst.unwrap_or(Came::Missing).name().to_owned(),
            ..Row::default()
        }
    };
    Table {
        headings,
        rows: by_scene(views).map(row).collect(),
        is_main: true,
        ..Table::default()
    }
}

fn row(view: &View<'_>, metric: &Metric) -> Row {
    let came = view.came();
    let first = view.cases.first().copied();
    let most = |name: &Metric| {
        let values = view.cases.iter().filter_map(|case| case.value(name));
        values.reduce(f64::max)
    };
    let figure = |value: Option<f64>| match value {
        Some(value) => Cell::plain(format!("{value:.0}")),
        None => Cell::absent(match came {
            Came::Refused => "refused: nothing was drawn",
            _ => "nothing was compared",
        }),
    };
    let time = first.and_then(|case| {
        let replicates: Vec<f64> = process_medians(case, metric).into_values().collect();
        median(&replicates)
    });
    let expected = first.map_or("", |case| case.condition(EXPECTED));
    let left_out = first.map_or("", |case| case.note("left_out"));
    let drawn = first.and_then(|case| case.value(REGIONS_DRAWN));
    let mut result = Cell::name(came.name());
    result.class = match came {
        Came::Failed => CellClass::Bad,
        _ => CellClass::Name,
    };
    result.detail = first.map_or("", |case| case.note(REFUSED)).to_owned();
    let picture = first.map_or("", |case| case.note("image"));
    let whole = if view.name == WHOLE {
        "the whole scene"
    } else {
        view.name
    };
    let remarks = first.map_or("", |case| case.reason.as_str());
    Row {
        cells: vec![
            Cell {
                detail: match came {
                    Came::Failed => String::new(),
                    _ => remarks.to_owned(),
                },
                ..Cell::name(whole)
            },
            Cell::name(expected),
            result,
            figure(most(MISMATCHED_PX)),
            figure(most(MISMATCHED_PX_OUTSIDE_BAND)),
            Cell::or_absent(time.map(significant), "no frame was timed"),
            Cell::plain(significant(view.seconds())),
            figure(drawn),
            match (left_out, drawn) {
                ("", Some(_)) => Cell::name("nothing"),
                ("", None) => Cell::absent("no frame was planned"),
                (text, _) => Cell::name(text),
            },
            Cell {
                picture: picture.to_owned(),
                ..Cell::default()
            },
        ],
        status: came.name().to_owned(),
        remark: failures(view).join("; "),
    }
}

/// Each view's picture, and where a technique failed what differs.
fn pictures(scene: &[View<'_>]) -> Option<Block> {
    let mut figures = Vec::new();
    for view in scene {
        let shown = |case: &Case, note: &str, caption: &str| {
            let path = case.note(note);
            (!path.is_empty()).then(|| Picture {
                path: path.to_owned(),
                caption: caption.to_owned(),
            })
        };
        let mut pictures = Vec::new();
        if let Some(first) = view.cases.first() {
            pictures.extend(shown(first, "image", "picture"));
        }
        for case in view
            .cases
            .iter()
            .filter(|case| Came::of(case) == Came::Failed)
        {
            pictures.extend(shown(case, "reference_image", "reference"));
            pictures.extend(shown(case, "difference_image", "difference"));
            pictures.extend(shown(case, "worst_image", "worst pixel"));
        }
        if !pictures.is_empty() {
            figures.push(PictureFigure {
                pictures,
                notes: vec![format!("{}: {}", view.name, view.came().name())],
            });
        }
    }
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            figures,
            ..Pictures::default()
        })
    })
}
