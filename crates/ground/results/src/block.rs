// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a chapter of a report is made of. A study says what; `report` says how it looks.

use crate::folder::{encode, malformed};
use crate::{Case, Clock, Run, RunError, Term};
use std::path::Path;

/// One study's part of a report, made from a run's tables alone.
pub trait Chapter: Sync {
    /// Name of the study whose cases it reads.
    fn study(&self) -> &'static str;

    /// Heading of the chapter.
    fn title(&self) -> &'static str;

    /// The study's question, in a line; the chapter begins with it and with its answer.
    fn question(&self) -> &'static str;

    /// The metric that ratios and rankings of this study compare, by the run's clock; `None` for a
    /// study that times nothing. A/A noise is that of this metric.
    fn primary_metric(&self, clock: Clock) -> Option<&'static str>;

    /// The chapter, empty when the run has nothing of its study.
    ///
    /// # Errors
    /// [`ChapterError`] when the run's figures cannot be what the study measures.
    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError>;

    /// What it offers for the report's first page: the answer to the study's question.
    ///
    /// # Errors
    /// As [`Chapter::blocks`].
    fn answers(&self, _run: &Run) -> Result<Answers, ChapterError> {
        Ok(Answers::default())
    }

    /// Words of its own: conditions, their values, what its plots and columns name.
    fn terms(&self) -> &'static [Term] {
        &[]
    }

    /// Whether each section of it fills a page of its own.
    fn has_long_sections(&self) -> bool {
        false
    }

    /// What in the run's figures contradicts itself, a sentence each.
    fn contradictions(&self, _run: &Run) -> Vec<String> {
        Vec::new()
    }

    /// Keys of cases that further processes may decide something of, where more are worth their time.
    fn undecided(&self, _run: &Run) -> Vec<String> {
        Vec::new()
    }

    /// Tables derived from the run for people's own tools, such as `summary.csv`.
    ///
    /// # Errors
    /// As [`Chapter::blocks`].
    fn tables(&self, _run: &Run) -> Result<Vec<DerivedTable>, ChapterError> {
        Ok(Vec::new())
    }
}

/// A chapter's part of the report's first page.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Answers {
    /// What was compared with what, in exact numbers: a sentence each.
    pub scope: Vec<String>,
    /// The answers: a table of them, a plot, what follows from them in words.
    pub blocks: Vec<Block>,
    /// What the study requires, and whether the figures meet it.
    pub requirements: Vec<Finding>,
}

/// Why a chapter cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChapterError {
    /// The run's folder.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A plot cannot be drawn or a table not be written.
    #[error("{what}: {message}")]
    Block {
        /// Which plot or table.
        what: String,
        /// Why.
        message: String,
    },
}

/// A file beside the report, made anew whenever the report is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DerivedTable {
    /// File name within the run's folder.
    pub file: String,
    /// Its contents, CSV with a header.
    pub text: String,
}

impl DerivedTable {
    /// A file of these rows under this header.
    ///
    /// # Errors
    /// [`RunError::Malformed`] when a row has more or fewer cells than the header.
    pub fn new(
        file: &str,
        header: &[&str],
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Result<Self, ChapterError> {
        let path = Path::new(file);
        let bytes = encode(path, |writer| {
            writer.write_record(header)?;
            rows.into_iter()
                .try_for_each(|row| writer.write_record(row))
        })?;
        Ok(Self {
            file: file.to_owned(),
            text: String::from_utf8(bytes).map_err(|error| malformed(path, error))?,
        })
    }
}

/// A piece of a chapter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Block {
    /// A heading within the chapter.
    Heading {
        /// 3 for a section, 4 for a part of one: the report's title is 1 and a chapter's 2.
        level: u8,
        /// Its words.
        text: String,
    },
    /// The answer, before anything else.
    Lead(String),
    /// A paragraph.
    Text(String),
    /// A remark in small print, such as what a figure leaves out.
    Remark(String),
    /// Something wrong that must be seen.
    Alarm(String),
    /// Names or sentences, one below the other.
    List(Vec<String>),
    /// Figures in rows and columns.
    Table(Table),
    /// Figures as a drawing.
    Plot(Plot),
    /// Pictures with their captions.
    Pictures(Pictures),
    /// What the measurements say of a claim.
    Finding(Finding),
    /// Blocks that a reader may open and close.
    Folded {
        /// What is in it.
        summary: String,
        /// Whether it is open at first.
        is_open: bool,
        /// The blocks.
        blocks: Vec<Self>,
    },
}

impl Block {
    /// A section's heading.
    #[must_use]
    pub fn section(text: impl Into<String>) -> Self {
        Self::Heading {
            level: 3,
            text: text.into(),
        }
    }

    /// The heading of a part of a section.
    #[must_use]
    pub fn part(text: impl Into<String>) -> Self {
        Self::Heading {
            level: 4,
            text: text.into(),
        }
    }

    /// A drawing; nothing where there was nothing to draw.
    #[must_use]
    pub fn plot(caption: impl Into<String>, svg: Option<String>) -> Option<Self> {
        let caption = caption.into();
        svg.map(|svg| Self::Plot(Plot { caption, svg }))
    }

    /// What is wrong, seen at once, with a line for each; nothing where nothing is.
    #[must_use]
    pub fn alarm(text: impl Into<String>, wrong: Vec<String>) -> Vec<Self> {
        if wrong.is_empty() {
            Vec::new()
        } else {
            vec![Self::Alarm(text.into()), Self::List(wrong)]
        }
    }

    /// Names under a heading, open where they are few; nothing where there are none.
    #[must_use]
    pub fn folded_list(summary: impl Into<String>, items: Vec<String>) -> Option<Self> {
        /// As many lines as fit on a screen.
        const MAX_OPEN: usize = 24;
        (!items.is_empty()).then(|| Self::Folded {
            summary: summary.into(),
            is_open: items.len() <= MAX_OPEN,
            blocks: vec![Self::List(items)],
        })
    }
}

/// A table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// What it shows; empty where the text above says it.
    pub caption: String,
    /// Columns.
    pub headings: Vec<Heading>,
    /// Rows, each with a cell for every heading.
    pub rows: Vec<Row>,
    /// Whether it is one of the few that `summary.md` repeats.
    pub is_main: bool,
    /// How it is laid out.
    pub layout: TableLayout,
}

impl Table {
    /// Rows below headings: texts that say what they mean, or each with its meaning.
    #[must_use]
    pub fn of(headings: impl IntoIterator<Item = impl Into<Heading>>, rows: Vec<Row>) -> Self {
        Self {
            headings: headings.into_iter().map(Into::into).collect(),
            rows,
            ..Self::default()
        }
    }
}

/// How a table is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TableLayout {
    /// Figures below headings.
    #[default]
    Figures,
    /// Headings are written upwards, for many narrow columns.
    UprightHeadings,
    /// Few rows of cells that say several things each; on a narrow screen each row is a card.
    Cards,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Heading {
    /// As shown.
    pub text: String,
    /// Name of the metric that the column shows, whose meaning a reader who points at the heading
    /// sees; empty for a column that is no metric.
    pub metric: String,
    /// What it means where it is no metric, or none that the run knows: an older program may have measured it.
    pub meaning: String,
}

impl Heading {
    /// A column that needs no explanation.
    #[must_use]
    pub fn plain(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    /// A column that is explained here.
    #[must_use]
    pub fn explained(text: impl Into<String>, meaning: impl Into<String>) -> Self {
        Self {
            meaning: meaning.into(),
            ..Self::plain(text)
        }
    }

    /// A metric's column.
    #[must_use]
    pub fn metric(text: impl Into<String>, metric: impl Into<String>) -> Self {
        Self {
            metric: metric.into(),
            ..Self::plain(text)
        }
    }
}

impl From<&str> for Heading {
    fn from(text: &str) -> Self {
        Self::plain(text)
    }
}

/// A text with its meaning.
impl From<(&str, &str)> for Heading {
    fn from((text, meaning): (&str, &str)) -> Self {
        Self::explained(text, meaning)
    }
}

/// A row of a table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Row {
    /// Its cells.
    pub cells: Vec<Cell>,
    /// How the case ended, for the row's look: `ok`, `wrong`, … or empty.
    pub status: String,
    /// Stands below the row, over its whole width; empty for nothing.
    pub remark: String,
}

impl Row {
    /// A row without a status.
    #[must_use]
    pub fn new(cells: Vec<Cell>) -> Self {
        Self {
            cells,
            ..Self::default()
        }
    }

    /// A row that begins with a name.
    #[must_use]
    pub fn named(name: Cell, cells: impl IntoIterator<Item = Cell>) -> Self {
        Self::new(std::iter::once(name).chain(cells).collect())
    }

    /// Every figure of the row is bad news.
    #[must_use]
    pub fn bad_if(mut self, is_bad: bool) -> Self {
        if is_bad {
            let cells = self.cells.iter_mut();
            for cell in cells.filter(|cell| cell.class == CellClass::Plain) {
                cell.class = CellClass::Bad;
            }
        }
        self
    }
}

/// A cell.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    /// As shown.
    pub text: String,
    /// In small print below; empty for nothing.
    pub detail: String,
    /// A dot for each process of a time, as SVG that `terrafill-plot` makes; empty for none.
    pub dots: String,
    /// What a reader must know of the figure, in a word or two below it; empty for nothing.
    pub mark: String,
    /// Why it is empty, or why it does not count; becomes a footnote for those two.
    pub title: String,
    /// How it looks.
    pub class: CellClass,
    /// Marker of the series that it names, as SVG that `terrafill-plot` makes; empty for none.
    pub marker: String,
    /// Path of a picture within the run's folder that is shown small; empty for none.
    pub picture: String,
    /// Title of the section that says more; empty for none.
    pub section: String,
    /// What a reader types to see the case; empty for none.
    pub command: String,
    /// Address elsewhere that says more, such as a commit's; empty for none.
    pub link: String,
}

/// How a cell looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CellClass {
    /// A figure.
    #[default]
    Plain,
    /// Words, such as a case's name; may break after commas and slashes.
    Name,
    /// Nothing was measured; `title` says why.
    Absent,
    /// Measured, and counts for nothing; `title` says why.
    Void,
    /// Good news.
    Good,
    /// Bad news.
    Bad,
}

impl Cell {
    /// A figure.
    #[must_use]
    pub fn plain(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    /// Words.
    #[must_use]
    pub fn name(text: impl Into<String>) -> Self {
        Self {
            class: CellClass::Name,
            ..Self::plain(text)
        }
    }

    /// An empty cell with its reason.
    #[must_use]
    pub fn absent(why: impl Into<String>) -> Self {
        Self {
            title: why.into(),
            class: CellClass::Absent,
            ..Self::plain("–")
        }
    }

    /// A figure, or an empty cell with its reason.
    #[must_use]
    pub fn or_absent(text: Option<String>, why: impl Into<String>) -> Self {
        text.map_or_else(|| Self::absent(why), Self::plain)
    }
}

/// A drawing as inline SVG that takes text colour and background from the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plot {
    /// What it shows.
    pub caption: String,
    /// The drawing, as `terrafill-plot` makes it: its `metadata` element holds the drawn figures as CSV.
    pub svg: String,
}

/// Pictures laid side by side.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pictures {
    /// What they show.
    pub caption: String,
    /// Path of the picture that each figure's first picture may be laid over; empty for none.
    pub reference: String,
    /// In rows as the page has room for. Figures whose pictures are the same to the byte are shown
    /// once, with the notes of all.
    pub figures: Vec<PictureFigure>,
}

/// Pictures that belong together: a picture beside its difference from the reference.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PictureFigure {
    /// Left to right.
    pub pictures: Vec<Picture>,
    /// A line for each case that it shows.
    pub notes: Vec<String>,
}

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Path within the run's folder.
    pub path: String,
    /// What it shows, in a word or two.
    pub caption: String,
}

impl Picture {
    /// The one whose path a note of the case is, if it has it.
    #[must_use]
    pub fn of(case: &Case, note: &str, caption: impl Into<String>) -> Option<Self> {
        let path = case.note(note);
        (!path.is_empty()).then(|| Self {
            path: path.to_owned(),
            caption: caption.into(),
        })
    }
}

/// What the measurements say of a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The claim, and whose it is.
    pub claim: String,
    /// What is said of it.
    pub standing: Standing,
    /// By which figures; empty where the claim has them.
    pub because: String,
}

/// A claim and its figures, set apart: figures that begin a sentence after a full stop, others after a colon. The last
/// sentence is left open.
#[must_use]
pub fn with_figures(claim: &str, because: &str) -> String {
    let [claim, because] = [claim, because].map(str::trim);
    let ended = because.strip_suffix('.').unwrap_or(because);
    let between = match because.chars().next() {
        None => "",
        _ if claim.ends_with([':', '.', ';', '?', '!']) => " ",
        Some(first) if first.is_uppercase() => ". ",
        Some(_) => ": ",
    };
    let claim = if between.is_empty() {
        claim.trim_end_matches([':', '.'])
    } else {
        claim
    };
    format!("{claim}{between}{ended}")
}

/// What an interval says of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The whole interval agrees.
    Holds,
    /// The whole interval disagrees.
    DoesNotHold,
    /// The whole interval lies within what identical work differs by, and the claim is of a difference.
    NoDifference,
    /// The interval has both, or there is none.
    CannotTell,
    /// No case of it was measured.
    NotMeasured,
    /// Nothing that can be measured here says anything of it.
    CannotBeTested,
}

impl Standing {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Holds,
        Self::DoesNotHold,
        Self::NoDifference,
        Self::CannotTell,
        Self::NotMeasured,
        Self::CannotBeTested,
    ];

    /// Of something that is exact.
    #[must_use]
    pub fn holds_if(holds: bool) -> Self {
        if holds {
            Self::Holds
        } else {
            Self::DoesNotHold
        }
    }

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold",
            Self::NoDifference => "no difference",
            Self::CannotTell => "undecided",
            Self::NotMeasured => "not measured",
            Self::CannotBeTested => "cannot be tested",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_never_run_on_from_a_claim() {
        for (claim, because, text) in [
            (
                "It is there",
                "0 pixels differ.",
                "It is there: 0 pixels differ",
            ),
            (
                "It is longer",
                "By window: 2 ×.",
                "It is longer. By window: 2 ×",
            ),
            ("Which is it?", "2 ×", "Which is it? 2 ×"),
            ("It is so.", "", "It is so"),
        ] {
            assert_eq!(with_figures(claim, because), text);
        }
    }
}
