// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on extreme scenes: how many passed, were refused rightly or failed, and a row for each
//! view with its picture and with what its frame plan left out.

use super::keys::{EXPECTED, SCENE, SCENE_REASON, SUITE_CASE_S, VIEW};
use super::plan::{EXTREME, WHOLE};
use super::session::REFUSED;
use crate::keys::*;
use crate::purpose::never_right;
use terrafill_lab::{finding, grouped};
use terrafill_plot::number::significant;
use terrafill_results::{
    Answers, Block, Case, Cell, CellClass, Chapter, ChapterError, Clock, Metric, Outcome, Picture,
    PictureFigure, Pictures, Row, Run, Table, Term, typical,
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
struct SuiteView<'a> {
    scene: &'a str,
    name: &'a str,
    cases: Vec<&'a Case>,
}

impl SuiteView<'_> {
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

    /// What came out wrong.
    fn failed(&self) -> impl Iterator<Item = &Case> {
        let cases = self.cases.iter().copied();
        cases.filter(|case| Came::of(case) == Came::Failed)
    }

    /// The first technique's, small.
    fn picture(&self) -> Cell {
        let first = self.cases.first();
        Cell {
            picture: first.map_or("", |case| case.note("image")).to_owned(),
            ..Cell::default()
        }
    }

    /// The worst of its techniques.
    fn came(&self) -> Came {
        let came = self.cases.iter().map(|case| Came::of(case));
        came.max().unwrap_or(Came::Missing)
    }
}

/// Views in the plan's order.
fn views<'a>(run: &'a Run) -> Vec<SuiteView<'a>> {
    let key = |case: &&'a Case| [SCENE, VIEW].map(|key| case.condition(key));
    let views = grouped(cases(run), key).into_iter();
    let view =
        |([scene, name], cases): ([&'a str; 2], Vec<&'a Case>)| SuiteView { scene, name, cases };
    views.map(view).collect()
}

fn cases(run: &Run) -> impl Iterator<Item = &Case> {
    run.of_study(EXTREME).filter(|case| !case.is_repeat())
}

/// Views of one scene after the other.
fn by_scene<'v, 'a>(views: &'v [SuiteView<'a>]) -> impl Iterator<Item = &'v [SuiteView<'a>]> {
    views.chunk_by(|a, b| a.scene == b.scene)
}

fn count(views: &[SuiteView<'_>], came: Came) -> usize {
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
    let others = [Came::Skipped, Came::Missing].map(|came| (ended(came), came.name()));
    for (number, name) in others.iter().filter(|(number, _)| *number > 0) {
        text.push_str(&format!(", {number} {name}"));
    }
    Some(text + ".")
}

impl Chapter for ExtremeChapter {
    fn study(&self) -> &'static str {
        EXTREME
    }

    fn title(&self) -> &'static str {
        "Extreme scenes"
    }

    fn question(&self) -> &'static str {
        "Does every technique survive what globes usually break at: right, or refused as it should be?"
    }

    fn terms(&self) -> &'static [Term] {
        super::keys::TERMS
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
            requirements: vec![finding(
                "Every scene of the extreme suite is right, or refused as it should be",
                Some(failed == 0),
                sentence,
            )],
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
        let mut blocks = vec![Block::Text(sentence), Block::Remark(KEY.to_owned())];
        let failed: Vec<String> = views.iter().flat_map(failures).collect();
        blocks.extend(Block::alarm(
            format!("{} cases failed", failed.len()),
            failed,
        ));
        blocks.push(Block::Table(summary(&views)));
        for scene in by_scene(&views) {
            blocks.push(Block::section(scene[0].scene));
            blocks.push(Block::Text(format!("{}.", scene[0].scene_reason())));
            blocks.push(Block::Table(table(run.clock(), scene)));
            blocks.extend(pictures(scene));
        }
        Ok(blocks)
    }

    fn contradictions(&self, run: &Run) -> Vec<String> {
        let passed = cases(run).filter(|case| Came::of(case) == Came::Passed);
        passed.filter_map(never_right).collect()
    }
}

const KEY: &str = "Passed: every technique's picture matches the reference outside the 1-pixel boundary \
                   band, no figure is NaN or infinite, and the validation layer said nothing where it \
                   was on. A pixel whose surface lies within 2⁻²⁴ of its distance from a region's wall may \
                   show either side of the wall, or neither. Refused rightly: refused with the words that \
                   the scene expects.";

/// A line for each technique that failed.
fn failures(view: &SuiteView<'_>) -> Vec<String> {
    let failed = view.failed().map(|case| {
        let reason = match case.reason.as_str() {
            "" => "no reason was recorded",
            reason => reason,
        };
        format!("{}: {} ({reason})", case.id(), case.outcome.name())
    });
    failed.collect()
}

/// A row for each scene: why it is here and how its views ended.
fn summary(views: &[SuiteView<'_>]) -> Table {
    let ends = [Came::Passed, Came::Refused, Came::Failed];
    let of = |scene: &[SuiteView<'_>]| {
        let name = Cell {
            section: scene[0].scene.to_owned(),
            ..Cell::name(scene[0].scene)
        };
        let seconds: f64 = scene.iter().map(SuiteView::seconds).sum();
        let counts = ends.map(|came| Cell::plain(count(scene, came).to_string()));
        let before = [
            Cell::name(scene[0].scene_reason()),
            Cell::plain(scene.len().to_string()),
        ];
        let after = [Cell::plain(significant(seconds)), scene[0].picture()];
        let worst = scene.iter().map(SuiteView::came).max();
        Row {
            status: worst.unwrap_or(Came::Missing).name().to_owned(),
            ..Row::named(name, before.into_iter().chain(counts).chain(after))
        }
    };
    let [passed, refused, failed] = ends.map(Came::name);
    let headings = [
        ("scene", ""),
        ("why it is here", ""),
        ("views", ""),
        (passed, ""),
        (refused, ""),
        (failed, ""),
        ("all, s", "wall clock of all its views"),
        ("first view", ""),
    ];
    Table {
        is_main: true,
        ..Table::of(headings, by_scene(views).map(of).collect())
    }
}

/// A row for each view of a scene.
fn table(clock: Clock, scene: &[SuiteView<'_>]) -> Table {
    let time = format!("fill, {}", clock.pick("GPU ms", "process CPU ms"));
    let headings = [
        ("view", ""),
        ("expected", ""),
        ("result", "the worst of the techniques"),
        (
            "mismatches",
            "pixels that differ from the reference, most of the techniques",
        ),
        (
            "outside the band",
            "farther than one pixel from a boundary; 0 allowed",
        ),
        (&time, "one frame of the first technique"),
        (
            "all, s",
            "wall clock of the whole view: reading, meshing, reference, every technique",
        ),
        ("drawn", "regions in the frame plan"),
        ("left out and why", "what the frame plan leaves out"),
        ("picture", ""),
    ];
    let metric = clock.pick(FILL_GPU_MS, FILL_CPU_MS);
    let rows = scene.iter().map(|view| row_of(view, metric));
    Table::of(headings, rows.collect())
}

fn row_of(view: &SuiteView<'_>, metric: &Metric) -> Row {
    let came = view.came();
    let first = view.cases.first().copied();
    let text = |of: fn(&Case) -> &str| first.map_or("", of);
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
    let time = first.and_then(|case| typical(case, metric));
    let drawn = first.and_then(|case| case.value(REGIONS_DRAWN));
    let name = match view.name {
        WHOLE => "the whole scene",
        name => name,
    };
    let (class, remark) = match came {
        Came::Failed => (CellClass::Bad, ""),
        _ => (CellClass::Name, text(|case| &case.reason)),
    };
    let name = Cell {
        detail: remark.to_owned(),
        ..Cell::name(name)
    };
    let result = Cell {
        class,
        detail: text(|case| case.note(REFUSED)).to_owned(),
        ..Cell::name(came.name())
    };
    let cells = [
        Cell::name(text(|case| case.condition(EXPECTED))),
        result,
        figure(most(MISMATCHED_PX)),
        figure(most(MISMATCHED_PX_OUTSIDE_BAND)),
        Cell::or_absent(
            time.map(|time| significant(time.middle)),
            "no frame was timed",
        ),
        Cell::plain(significant(view.seconds())),
        figure(drawn),
        match (text(|case| case.note("left_out")), drawn) {
            ("", Some(_)) => Cell::name("nothing"),
            ("", None) => Cell::absent("no frame was planned"),
            (text, _) => Cell::name(text),
        },
        view.picture(),
    ];
    Row {
        status: came.name().to_owned(),
        remark: failures(view).join("; "),
        ..Row::named(name, cells)
    }
}

/// Each view's picture, and where a technique failed what differs.
fn pictures(scene: &[SuiteView<'_>]) -> Option<Block> {
    let figure = |view: &SuiteView<'_>| {
        let first = view.cases.first();
        let first = first.and_then(|case| Picture::of(case, "image", "picture"));
        let failed = view.failed().flat_map(|case| {
            [
                Picture::of(case, "reference_image", "reference"),
                Picture::of(case, "difference_image", "difference"),
                Picture::of(case, "worst_image", "worst pixel"),
            ]
        });
        let pictures: Vec<Picture> = first.into_iter().chain(failed.flatten()).collect();
        (!pictures.is_empty()).then(|| PictureFigure {
            pictures,
            notes: vec![format!("{}: {}", view.name, view.came().name())],
        })
    };
    let figures: Vec<PictureFigure> = scene.iter().filter_map(figure).collect();
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            figures,
            ..Pictures::default()
        })
    })
}
