// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks as HTML, laid out by `templates/blocks.html`.

use crate::picture::{Picture, embed};
use askama::Template;
use std::collections::BTreeMap;
use std::path::Path;
use terrafill_results::{
    Block, Cell, CellClass, Finding, Heading, Pictures, Plot, Row, Run, Standing, Table,
};

/// A block with everything that the template needs.
enum View<'a> {
    Heading {
        level: u8,
        text: &'a str,
        id: String,
    },
    Text(&'a str),
    Remark(&'a str),
    Alarm(&'a str),
    List(&'a [String]),
    Table(TableView<'a>),
    Plot(&'a Plot),
    Pictures(PicturesView<'a>),
    Findings(Vec<FindingView<'a>>),
    Folded {
        summary: &'a str,
        is_open: bool,
        html: String,
    },
}

struct TableView<'a> {
    caption: &'a str,
    has_upright_headings: bool,
    /// Text and meaning.
    headings: Vec<(&'a str, String)>,
    rows: Vec<RowView<'a>>,
    footnotes: Vec<&'a str>,
}

struct RowView<'a> {
    status: &'a str,
    remark: &'a str,
    cells: Vec<CellView<'a>>,
}

struct CellView<'a> {
    tag: &'static str,
    class: &'static str,
    title: &'a str,
    /// Where a line may break.
    parts: Vec<&'a str>,
    detail: Vec<&'a str>,
    is_void: bool,
    /// From 1; 0 for none.
    footnote: usize,
}

struct PicturesView<'a> {
    caption: &'a str,
    figures: Vec<FigureView<'a>>,
    problems: Vec<String>,
}

struct FigureView<'a> {
    images: Vec<ImageView<'a>>,
    caption: String,
    notes: Vec<&'a str>,
}

#[derive(PartialEq)]
struct ImageView<'a> {
    picture: Picture,
    caption: &'a str,
}

struct FindingView<'a> {
    claim: &'a str,
    because: &'a str,
    standing: &'static str,
    class: &'static str,
}

#[derive(Template)]
#[template(path = "blocks.html")]
struct Blocks<'a> {
    blocks: Vec<View<'a>>,
}

/// Renders blocks and hands out the ids of their headings.
pub(crate) struct Renderer<'a> {
    run: &'a Run,
    /// How often each id was asked for.
    ids: BTreeMap<String, usize>,
    /// Ids and texts of the sections so far.
    sections: Vec<(String, String)>,
}

impl<'a> Renderer<'a> {
    pub(crate) fn new(run: &'a Run) -> Self {
        Self {
            run,
            ids: BTreeMap::new(),
            sections: Vec::new(),
        }
    }

    /// An id that no other element has.
    pub(crate) fn id(&mut self, text: &str) -> String {
        let id: String = text
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .collect();
        let known = self.ids.entry(id.clone()).or_default();
        *known += 1;
        match *known {
            1 => id,
            number => format!("{id}--{number}"),
        }
    }

    /// Sections since they were last taken.
    pub(crate) fn take_sections(&mut self) -> Vec<(String, String)> {
        std::mem::take(&mut self.sections)
    }

    /// The blocks of one chapter, or of a folded part of it.
    ///
    /// # Errors
    /// When a template cannot be rendered.
    pub(crate) fn html(&mut self, blocks: &[Block]) -> Result<String, askama::Error> {
        let mut views: Vec<View<'_>> = Vec::new();
        for block in blocks {
            if let (Block::Finding(finding), Some(View::Findings(findings))) =
                (block, views.last_mut())
            {
                findings.push(finding_view(finding));
                continue;
            }
            views.push(self.view(block)?);
        }
        Blocks { blocks: views }.render()
    }

    fn view<'b>(&mut self, block: &'b Block) -> Result<View<'b>, askama::Error> {
        Ok(match block {
            Block::Heading { level, text } => {
                let id = self.id(text);
                if *level == 3 {
                    self.sections.push((id.clone(), text.clone()));
                }
                View::Heading {
                    level: *level,
                    text,
                    id,
                }
            }
            Block::Text(text) => View::Text(text),
            Block::Remark(text) => View::Remark(text),
            Block::Alarm(text) => View::Alarm(text),
            Block::List(items) => View::List(items),
            Block::Table(table) => View::Table(self.table(table)),
            Block::Plot(plot) => View::Plot(plot),
            Block::Pictures(pictures) => View::Pictures(pictures_view(&self.run.path, pictures)),
            Block::Finding(finding) => View::Findings(vec![finding_view(finding)]),
            Block::Folded {
                summary,
                is_open,
                blocks,
            } => View::Folded {
                summary,
                is_open: *is_open,
                html: self.html(blocks)?,
            },
        })
    }

    fn table<'b>(&self, table: &'b Table) -> TableView<'b> {
        let mut footnotes = Vec::new();
        let rows = table.rows.iter().map(|row| row_view(row, &mut footnotes));
        TableView {
            caption: &table.caption,
            has_upright_headings: table.has_upright_headings,
            rows: rows.collect(),
            headings: table
                .headings
                .iter()
                .map(|heading| (heading.text.as_str(), meaning(self.run, heading)))
                .collect(),
            footnotes,
        }
    }
}

fn meaning(run: &Run, heading: &Heading) -> String {
    match run.metric(&heading.metric) {
        Some(metric) => metric.meaning.clone(),
        None => heading.meaning.clone(),
    }
}

fn row_view<'a>(row: &'a Row, footnotes: &mut Vec<&'a str>) -> RowView<'a> {
    let cells = row.cells.iter().enumerate().map(|(index, cell)| {
        let is_status = !row.status.is_empty() && cell.text == row.status;
        cell_view(cell, index == 0, is_status, footnotes)
    });
    RowView {
        cells: cells.collect(),
        status: &row.status,
        remark: &row.remark,
    }
}

fn cell_view<'a>(
    cell: &'a Cell,
    is_first: bool,
    is_status: bool,
    footnotes: &mut Vec<&'a str>,
) -> CellView<'a> {
    let class = match cell.class {
        _ if is_status => "status",
        CellClass::Plain => "",
        CellClass::Name if is_first => "",
        CellClass::Name => "name",
        CellClass::Absent => "absent",
        CellClass::Void => "void",
        CellClass::Good => "good",
        CellClass::Bad => "bad",
    };
    let has_footnote =
        matches!(cell.class, CellClass::Absent | CellClass::Void) && !cell.title.is_empty();
    CellView {
        tag: if is_first { "th" } else { "td" },
        class,
        title: &cell.title,
        parts: match cell.class {
            CellClass::Name => breakable(&cell.text),
            _ => vec![&cell.text],
        },
        detail: breakable(&cell.detail),
        is_void: cell.class == CellClass::Void,
        footnote: if has_footnote {
            footnote(&cell.title, footnotes)
        } else {
            0
        },
    }
}

/// A name in the pieces between which a line may break: after commas and slashes.
fn breakable(name: &str) -> Vec<&str> {
    name.split_inclusive([',', '/']).collect()
}

/// Number of the footnote with this text, from 1.
fn footnote<'a>(text: &'a str, footnotes: &mut Vec<&'a str>) -> usize {
    match footnotes.iter().position(|known| *known == text) {
        Some(index) => index + 1,
        None => {
            footnotes.push(text);
            footnotes.len()
        }
    }
}

fn finding_view(finding: &Finding) -> FindingView<'_> {
    FindingView {
        claim: &finding.claim,
        because: &finding.because,
        standing: finding.standing.name(),
        class: match finding.standing {
            Standing::Holds => "holds",
            Standing::DoesNotHold => "does-not",
            Standing::CannotTell | Standing::NotMeasured => "cannot-tell",
        },
    }
}

/// Pictures of the run's folder; the same ones are shown once.
fn pictures_view<'a>(folder: &Path, pictures: &'a Pictures) -> PicturesView<'a> {
    let mut view = PicturesView {
        caption: &pictures.caption,
        figures: Vec::new(),
        problems: Vec::new(),
    };
    for figure in &pictures.figures {
        let mut images = Vec::new();
        for picture in &figure.pictures {
            match embed(folder, &picture.path) {
                Ok(embedded) => images.push(ImageView {
                    picture: embedded,
                    caption: &picture.caption,
                }),
                Err(problem) if view.problems.contains(&problem) => {}
                Err(problem) => view.problems.push(problem),
            }
        }
        if images.is_empty() {
            continue;
        }
        let notes = figure.notes.iter().map(String::as_str);
        match view.figures.iter_mut().find(|known| known.images == images) {
            Some(known) => known.notes.extend(notes),
            None => view.figures.push(FigureView {
                caption: captions(&images),
                images,
                notes: notes.collect(),
            }),
        }
    }
    view
}

fn captions(images: &[ImageView<'_>]) -> String {
    let captions: Vec<&str> = images.iter().map(|image| image.caption).collect();
    captions.join(" | ")
}
