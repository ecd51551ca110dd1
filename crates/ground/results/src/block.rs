// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a chapter of a report is made of. A study says what; `report` says how it looks.

use crate::{Run, RunError};

/// One study's part of a report, made from a run's tables alone.
pub trait Chapter: Sync {
    /// Name of the study whose cases it reads.
    fn study(&self) -> &'static str;

    /// Heading of the chapter.
    fn title(&self) -> &'static str;

    /// The chapter, empty when the run has nothing of its study.
    ///
    /// # Errors
    /// [`ChapterError`] when the run's figures cannot be what the study measures.
    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError>;

    /// Tables derived from the run for people's own tools, such as `summary.csv`.
    ///
    /// # Errors
    /// As [`Chapter::blocks`].
    fn tables(&self, _run: &Run) -> Result<Vec<DerivedTable>, ChapterError> {
        Ok(Vec::new())
    }
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

/// A piece of a chapter.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A heading within the chapter.
    Heading {
        /// 2 for a section, 3 for a part of one.
        level: u8,
        /// Its words.
        text: String,
    },
    /// A paragraph.
    Text(String),
    /// A remark in small print, such as what a figure leaves out.
    Remark(String),
    /// Figures in rows and columns.
    Table(Table),
    /// Figures as a drawing.
    Plot(Plot),
    /// Pictures with their captions.
    Pictures(Pictures),
    /// What the measurements say of a claim.
    Finding(Finding),
    /// Blocks that a reader opens when asked to.
    Folded {
        /// What is in it.
        summary: String,
        /// The blocks.
        blocks: Vec<Block>,
    },
}

/// A table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Columns.
    pub headings: Vec<Heading>,
    /// Rows, each with a cell for every heading.
    pub rows: Vec<Row>,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Heading {
    /// As shown.
    pub text: String,
    /// What it means, for a reader who points at it: a metric's meaning.
    pub meaning: String,
}

/// A row of a table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Row {
    /// Its cells.
    pub cells: Vec<Cell>,
    /// How the case ended, for the row's look: `ok`, `wrong`, … or empty.
    pub status: String,
}

/// A cell.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    /// As shown.
    pub text: String,
    /// Why it is empty, or why it does not count; becomes a footnote for those two.
    pub title: String,
    /// How it looks.
    pub class: CellClass,
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
            text: "–".to_owned(),
            title: why.into(),
            class: CellClass::Absent,
        }
    }
}

/// A drawing as inline SVG that takes text colour and background from the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plot {
    /// What it shows.
    pub caption: String,
    /// The drawing.
    pub svg: String,
}

/// Pictures laid side by side.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pictures {
    /// What they show.
    pub caption: String,
    /// In rows as the page has room for.
    pub pictures: Vec<Picture>,
}

/// A picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Path within the run's folder.
    pub path: String,
    /// What it shows.
    pub caption: String,
}

/// What the measurements say of a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The claim, and whose it is.
    pub claim: String,
    /// What is said of it.
    pub standing: Standing,
    /// By which figures.
    pub because: String,
}

/// What an interval says of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The whole interval agrees.
    Holds,
    /// The whole interval disagrees.
    DoesNotHold,
    /// The interval has both, or there is none.
    CannotTell,
}

impl Standing {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold",
            Self::CannotTell => "cannot tell",
        }
    }
}
