// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blocks as HTML, laid out by `templates/blocks.html`.

use crate::picture::{Picture, Unshown, address, data_uri};
use crate::table::{about_cells, before_range, footnote, same_columns};
use askama::Template;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_results::{
    Block, Cell, CellClass, Finding, Heading, Pictures, Plot, Row, Run, Standing, Table,
    TableLayout, with_figures,
};

/// The first page, within the run's folder.
pub(crate) const INDEX: &str = "index.html";

/// Folder of the pages within the run's folder.
pub(crate) const PAGES: &str = "pages";
/// Folders of small pictures and of figures within it.
const SMALL: &str = "small";
const FIGURES: &str = "figures";

/// Stands for the address of the first picture among several.
const FIRST_PICTURE: &str = "#first";

/// Whether the report is one file or several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// A first page, with others and pictures beside it.
    Pages,
    /// One file that needs no other.
    SingleFile,
}

/// A block with everything that the template needs.
enum BlockView<'a> {
    Heading {
        level: u8,
        text: &'a str,
        id: String,
    },
    Lead(&'a str),
    Text(&'a str),
    Remark(&'a str),
    Alarm(&'a str),
    List(&'a [String]),
    Table(TableView<'a>),
    Plot(PlotView<'a>),
    Pictures(PicturesView<'a>),
    Findings(Vec<FindingView>),
    Folded {
        summary: &'a str,
        is_open: bool,
        html: String,
    },
}

/// Class of cells of words.
const WORDS: &str = "name";

/// Characters of a cell that stays in one line: a median with its range has fewer.
const MAX_LINE: usize = 40;

struct TableView<'a> {
    id: String,
    caption: &'a str,
    class: &'static str,
    has_upright_headings: bool,
    headings: Vec<HeadingView<'a>>,
    rows: Vec<RowView<'a>>,
    footnotes: Vec<&'a str>,
    /// What dots in its cells are, and that they have commands; empty where there is neither.
    dots: String,
    /// Columns that are said once instead, with what every row has; empty for none.
    same: String,
}

struct HeadingView<'a> {
    text: &'a str,
    meaning: String,
    /// Over words, which begin where it begins; figures end where it ends.
    is_over_words: bool,
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
    /// Heading of its column, where a narrow screen shows it before the cell; else empty.
    label: &'a str,
    /// Where a line may break.
    parts: Vec<&'a str>,
    detail: Vec<&'a str>,
    dots: &'a str,
    mark: &'a str,
    is_void: bool,
    marker: &'a str,
    /// Address, width and height of a small picture.
    picture: Option<(String, u32, u32)>,
    /// Address of the section that says more; empty for none.
    href: String,
    command: &'a str,
    /// From 1; 0 for none.
    footnote: usize,
}

struct PlotView<'a> {
    caption: &'a str,
    svg: String,
    /// Addresses of the drawing and of its figures as files; empty where there are none.
    svg_file: String,
    csv_file: String,
    /// What the latter is saved as.
    csv_name: String,
}

struct PicturesView<'a> {
    caption: &'a str,
    /// Address of the picture that others may be laid over; empty for none.
    reference: String,
    figures: Vec<FigureView<'a>>,
    problems: Vec<String>,
}

struct FigureView<'a> {
    images: Vec<ImageView<'a>>,
    caption: String,
    notes: Vec<&'a str>,
}

impl FigureView<'_> {
    /// Pictures side by side; wide ones have a row of their own.
    fn columns(&self) -> usize {
        let beside = self.images.iter().filter(|image| !image.is_wide());
        beside.count().max(1)
    }
}

struct ImageView<'a> {
    src: String,
    width: u32,
    height: u32,
    hash: u64,
    caption: &'a str,
}

impl ImageView<'_> {
    /// Several parts side by side, which would be too small beside others.
    fn is_wide(&self) -> bool {
        self.width > 2 * self.height
    }
}

impl PartialEq for ImageView<'_> {
    fn eq(&self, other: &Self) -> bool {
        (self.hash, self.caption) == (other.hash, other.caption)
    }
}

struct FindingView {
    text: String,
    standing: &'static str,
    class: &'static str,
}

#[derive(Template)]
#[template(path = "blocks.html")]
struct Blocks<'a> {
    blocks: Vec<BlockView<'a>>,
}

/// A file of the report: path within the run's folder, and contents.
pub(crate) type File = (String, Vec<u8>);

/// Renders the blocks of one page, hands out the ids of their headings, and collects the files beside
/// the page.
pub(crate) struct Renderer<'a> {
    run: &'a Run,
    form: Form,
    /// The page's name, which its figures' files begin with.
    page: &'a str,
    /// From the page to the run's folder.
    root: &'static str,
    /// Addresses of sections by title, from the run's folder.
    links: &'a BTreeMap<String, String>,
    /// How often each id was asked for.
    ids: BTreeMap<String, usize>,
    files: Vec<File>,
    /// Pictures that are not in the run's folder.
    absent: BTreeSet<String>,
}

impl<'a> Renderer<'a> {
    pub(crate) fn new(
        run: &'a Run,
        form: Form,
        page: &'a str,
        root: &'static str,
        links: &'a BTreeMap<String, String>,
    ) -> Self {
        Self {
            run,
            form,
            page,
            root,
            links,
            ids: BTreeMap::new(),
            files: Vec::new(),
            absent: BTreeSet::new(),
        }
    }

    /// An id that no other element of the page has.
    pub(crate) fn id(&mut self, text: &str) -> String {
        let id = slug(text);
        let known = self.ids.entry(id.clone()).or_default();
        *known += 1;
        match *known {
            1 => id,
            number => format!("{id}--{number}"),
        }
    }

    /// Pictures that were not in the run's folder since this was last asked.
    pub(crate) fn take_absent(&mut self) -> BTreeSet<String> {
        std::mem::take(&mut self.absent)
    }

    /// The files beside the page.
    pub(crate) fn into_files(self) -> Vec<File> {
        self.files
    }

    /// The blocks of one page, or of a part of it.
    ///
    /// # Errors
    /// When a template cannot be rendered.
    pub(crate) fn html(&mut self, blocks: &[Block]) -> Result<String, askama::Error> {
        let mut views: Vec<BlockView<'_>> = Vec::new();
        for block in blocks {
            if let (Block::Finding(finding), Some(BlockView::Findings(findings))) =
                (block, views.last_mut())
            {
                findings.push(finding_view(finding));
                continue;
            }
            views.push(self.view(block)?);
        }
        Blocks { blocks: views }.render()
    }

    fn view<'b>(&mut self, block: &'b Block) -> Result<BlockView<'b>, askama::Error> {
        Ok(match block {
            Block::Heading { level, text } => BlockView::Heading {
                level: *level,
                text,
                id: self.id(text),
            },
            Block::Lead(text) => BlockView::Lead(text),
            Block::Text(text) => BlockView::Text(text),
            Block::Remark(text) => BlockView::Remark(text),
            Block::Alarm(text) => BlockView::Alarm(text),
            Block::List(items) => BlockView::List(items),
            Block::Table(table) => BlockView::Table(self.table(table)),
            Block::Plot(plot) => BlockView::Plot(self.plot(plot)),
            Block::Pictures(pictures) => BlockView::Pictures(self.pictures(pictures)),
            Block::Finding(finding) => BlockView::Findings(vec![finding_view(finding)]),
            Block::Folded {
                summary,
                is_open,
                blocks,
            } => BlockView::Folded {
                summary,
                is_open: *is_open,
                html: self.html(blocks)?,
            },
        })
    }

    fn table<'b>(&mut self, table: &'b Table) -> TableView<'b> {
        let mut footnotes = Vec::new();
        let (varying, same) = same_columns(table);
        let is_cards = table.layout == TableLayout::Cards;
        let rows = table.rows.iter().map(|row| {
            let mut view = self.row(row, &varying, &mut footnotes);
            if is_cards {
                for (cell, heading) in view.cells.iter_mut().zip(&table.headings) {
                    cell.label = &heading.text;
                }
            }
            view
        });
        let rows: Vec<RowView<'b>> = rows.collect();
        let is_words = |row: &RowView<'_>, column: usize| {
            let cell = row.cells.get(column);
            cell.is_some_and(|cell| cell.class == WORDS)
        };
        let headings = varying.iter().map(|&column| &table.headings[column]);
        let headings = headings.enumerate().map(|(column, heading)| HeadingView {
            text: &heading.text,
            meaning: meaning(self.run, heading),
            is_over_words: !rows.is_empty() && rows.iter().all(|row| is_words(row, column)),
        });
        TableView {
            id: self.id("table"),
            caption: &table.caption,
            class: match table.layout {
                TableLayout::Figures => "",
                TableLayout::UprightHeadings => "upright",
                TableLayout::Cards => "cards",
            },
            has_upright_headings: table.layout == TableLayout::UprightHeadings,
            headings: headings.collect(),
            dots: about_cells(table),
            same,
            rows,
            footnotes,
        }
    }

    fn row<'b>(
        &mut self,
        row: &'b Row,
        columns: &[usize],
        footnotes: &mut Vec<&'b str>,
    ) -> RowView<'b> {
        let cells = columns.iter().map(|&index| {
            let cell = &row.cells[index];
            let is_status = !row.status.is_empty() && cell.text == row.status;
            self.cell(cell, index == 0, is_status, footnotes)
        });
        RowView {
            cells: cells.collect(),
            status: &row.status,
            remark: &row.remark,
        }
    }

    fn cell<'b>(
        &mut self,
        cell: &'b Cell,
        is_first: bool,
        is_status: bool,
        footnotes: &mut Vec<&'b str>,
    ) -> CellView<'b> {
        let class = match cell.class {
            _ if is_status => "status",
            CellClass::Plain if cell.text.chars().count() > MAX_LINE => WORDS,
            CellClass::Plain if before_range(&cell.text).len() > 1 => "range",
            CellClass::Plain => "",
            CellClass::Name if is_first => "",
            CellClass::Name => WORDS,
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
            label: "",
            parts: match cell.class {
                CellClass::Name => breakable(&cell.text),
                CellClass::Plain => before_range(&cell.text),
                _ => vec![&cell.text],
            },
            detail: breakable(&cell.detail),
            dots: &cell.dots,
            mark: &cell.mark,
            is_void: cell.class == CellClass::Void,
            marker: &cell.marker,
            picture: self.small(&cell.picture),
            href: match self.links.get(&cell.section) {
                Some(link) if link.starts_with('#') => link.clone(),
                Some(link) => format!("{}{link}", self.root),
                None => cell.link.clone(),
            },
            command: &cell.command,
            footnote: if has_footnote {
                footnote(&cell.title, footnotes)
            } else {
                0
            },
        }
    }

    /// A small copy of a picture; nothing where it cannot be read, which its own section says.
    fn small(&mut self, path: &str) -> Option<(String, u32, u32)> {
        if path.is_empty() {
            return None;
        }
        let small = Picture::small(&self.run.path, path).ok()?;
        let (width, height) = (small.width, small.height);
        if self.form == Form::SingleFile {
            return Some((small.uri(), width, height));
        }
        let file = format!("{PAGES}/{SMALL}/{}.{}", slug(path), small.ending());
        if !self.files.iter().any(|(known, _)| *known == file) {
            self.files.push((file.clone(), small.into_bytes()));
        }
        Some((format!("{}{file}", self.root), width, height))
    }

    /// The drawing without its figures, which become a file.
    fn plot<'b>(&mut self, plot: &'b Plot) -> PlotView<'b> {
        let (svg, csv) = without_metadata(&plot.svg);
        let mut view = PlotView {
            caption: &plot.caption,
            svg,
            svg_file: String::new(),
            csv_file: String::new(),
            csv_name: String::new(),
        };
        let stem = self.id(&format!("{}-figure", self.page));
        view.csv_name = format!("{stem}.csv");
        if self.form == Form::SingleFile {
            let uri = |csv: String| data_uri("text/csv", csv.as_bytes());
            view.csv_file = csv.map_or_else(String::new, uri);
        } else {
            let mut file = |ending: &str, text: String| {
                let file = format!("{PAGES}/{FIGURES}/{stem}.{ending}");
                let href = format!("{}{file}", self.root);
                self.files.push((file, text.into_bytes()));
                href
            };
            view.svg_file = file("svg", alone(&plot.svg));
            if let Some(csv) = csv {
                view.csv_file = file("csv", csv);
            }
        }
        view
    }

    /// Address of a picture and its size.
    fn image<'b>(&self, path: &str, caption: &'b str) -> Result<ImageView<'b>, Unshown> {
        let picture = Picture::read(&self.run.path, path)?;
        Ok(ImageView {
            src: match self.form {
                Form::Pages => format!("{}{}", self.root, address(path)),
                Form::SingleFile => picture.uri(),
            },
            width: picture.width,
            height: picture.height,
            hash: picture.hash(),
            caption,
        })
    }

    /// Pictures of the run's folder; the same ones are shown once.
    fn pictures<'b>(&mut self, pictures: &'b Pictures) -> PicturesView<'b> {
        let mut view = PicturesView {
            caption: &pictures.caption,
            reference: String::new(),
            figures: Vec::new(),
            problems: Vec::new(),
        };
        if !pictures.reference.is_empty() {
            // In a single file its data stand once: the script takes them from the first picture.
            view.reference = match self.form {
                Form::Pages => {
                    let reference = self.image(&pictures.reference, "");
                    reference.map_or_else(|_| String::new(), |image| image.src)
                }
                Form::SingleFile => FIRST_PICTURE.to_owned(),
            };
        }
        for figure in &pictures.figures {
            let mut images = Vec::new();
            for picture in &figure.pictures {
                match self.image(&picture.path, &picture.caption) {
                    Ok(image) => images.push(image),
                    Err(Unshown::Absent) => drop(self.absent.insert(picture.path.clone())),
                    Err(Unshown::Broken(problem)) if view.problems.contains(&problem) => {}
                    Err(Unshown::Broken(problem)) => view.problems.push(problem),
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
        // Without it the first picture is another one.
        if self.absent.contains(&pictures.reference) {
            view.reference.clear();
        }
        view
    }
}

/// Letters and digits of a text, the rest as hyphens: for ids and file names.
pub(crate) fn slug(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
        .collect()
}

/// A drawing and its table of figures apart.
fn without_metadata(svg: &str) -> (String, Option<String>) {
    const ENDS: [&str; 2] = ["<metadata>", "</metadata>"];
    let parts = svg.split_once(ENDS[0]);
    let parts = parts.and_then(|(before, rest)| Some((before, rest.split_once(ENDS[1])?)));
    match parts {
        Some((before, (csv, after))) => {
            let csv = csv.replace("&lt;", "<").replace("&quot;", "\"");
            (format!("{before}{after}"), Some(csv.replace("&amp;", "&")))
        }
        None => (svg.to_owned(), None),
    }
}

/// A drawing as a file: it takes nothing from a page, and its text is black on white.
fn alone(svg: &str) -> String {
    let svg = svg.replace("var(--paper)", "#ffffff");
    let svg = svg.replace("currentColor", "#1b1f24");
    if svg.contains("xmlns=") {
        svg
    } else {
        svg.replacen("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ", 1)
    }
}

fn meaning(run: &Run, heading: &Heading) -> String {
    match run.metric(&heading.metric) {
        Some(metric) => metric.meaning.clone(),
        None => heading.meaning.clone(),
    }
}

/// A name in the pieces between which a line may break: after commas and slashes.
fn breakable(name: &str) -> Vec<&str> {
    name.split_inclusive([',', '/']).collect()
}

fn finding_view(finding: &Finding) -> FindingView {
    FindingView {
        text: with_figures(&finding.claim, &finding.because),
        standing: finding.standing.name(),
        class: match finding.standing {
            Standing::Holds => "holds",
            Standing::DoesNotHold => "does-not",
            Standing::NoDifference
            | Standing::CannotTell
            | Standing::NotMeasured
            | Standing::CannotBeTested => "cannot-tell",
        },
    }
}

fn captions(images: &[ImageView<'_>]) -> String {
    let captions: Vec<&str> = images.iter().map(|image| image.caption).collect();
    captions.join(" | ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_leave_the_drawing_and_come_out_as_they_went_in() {
        let svg = "<svg a><g/><metadata>name\n&lt;a> &amp;amp; &quot;b&quot;\n</metadata></svg>";
        let (drawing, csv) = without_metadata(svg);
        assert_eq!(drawing, "<svg a><g/></svg>");
        assert_eq!(csv.as_deref(), Some("name\n<a> &amp; \"b\"\n"));
        // Negative control: a drawing without figures stays.
        assert_eq!(without_metadata("<svg/>"), ("<svg/>".to_owned(), None));
    }

    #[test]
    fn a_drawing_of_its_own_takes_nothing_from_a_page() {
        let svg = alone("<svg w><text fill=\"currentColor\" b=\"var(--paper)\"/></svg>");
        assert!(
            svg.starts_with("<svg xmlns=") && !svg.contains("var(") && !svg.contains("current")
        );
    }
}
