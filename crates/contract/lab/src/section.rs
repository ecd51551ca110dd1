// SPDX-License-Identifier: MIT OR Apache-2.0
//! A section of a chapter as data: which cases, what names a row, columns, plot and pictures.

use crate::case_claims::StudyClaims;
use crate::cases::{Cases, measured};
use crate::curves::Drawing;
use crate::figure::{Figure, Names};
use crate::lines::Lines;
use crate::settling::{answers_with_commands, with_commands};
use terrafill_plot::dotted;
use terrafill_plot::number::{digits, measured_bytes, significant, spread, times};
use terrafill_results::{
    Answers, Block, Case, Cell, CellClass, Chapter, ChapterError, Clock, ConditionKey,
    DerivedTable, Estimate, Finding, Heading, Kind, Metric, NOT_MEASURED, Outcome, Picture,
    PictureFigure, Pictures, Row, Run, Table, Term, Timer, sample_spread,
};

/// Why a case that ended well has no figure of a column. Others have their own reason.
#[derive(Debug, Clone, Copy)]
pub enum Absent {
    /// As the metric declares.
    Declared,
    /// In all rows.
    Said(&'static str),
    /// By the case.
    Of(fn(&Case) -> &str),
}

/// A column of figures.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Heading, in which `{unit}` is that of the metric's clock.
    pub heading: &'static str,
    /// What it means where it is no metric; empty for what its heading says.
    pub meaning: &'static str,
    /// The figure of its cells.
    pub figure: Figure,
    /// Why a cell is empty.
    pub absent: Absent,
    /// How a figure is written; `None`: bytes with their unit, counts with every digit, all else in three.
    pub format: Option<fn(f64) -> String>,
}

impl Column {
    /// A column of a figure.
    #[must_use]
    pub const fn of(heading: &'static str, figure: Figure) -> Self {
        Self {
            heading,
            meaning: "",
            figure,
            absent: Absent::Declared,
            format: None,
        }
    }

    /// A metric's.
    #[must_use]
    pub const fn metric(heading: &'static str, metric: &'static Metric) -> Self {
        Self::of(heading, Figure::Metric(metric))
    }

    /// A time's, by the run's clock.
    #[must_use]
    pub const fn clocked(
        heading: &'static str,
        gpu: &'static Metric,
        cpu: &'static Metric,
    ) -> Self {
        Self::of(heading, Figure::ByClock(gpu, cpu))
    }

    /// The same with the range of 5 to 95 % of its samples.
    #[must_use]
    pub const fn sampled(
        heading: &'static str,
        gpu: &'static Metric,
        cpu: &'static Metric,
    ) -> Self {
        Self::of(heading, Figure::Samples(gpu, cpu))
    }

    /// Of ratios to another case of the section.
    #[must_use]
    pub const fn beside(
        heading: &'static str,
        of: fn(&Cases<'_>, &Case) -> Option<Estimate>,
    ) -> Self {
        Self::of(heading, Figure::Beside(of))
    }

    /// With what its heading means.
    #[must_use]
    pub const fn meaning(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }

    /// With this reason in empty cells.
    #[must_use]
    pub const fn or(self, why: &'static str) -> Self {
        let absent = Absent::Said(why);
        Self { absent, ..self }
    }

    /// With a reason by the case in empty cells.
    #[must_use]
    pub const fn or_of(self, why: fn(&Case) -> &str) -> Self {
        let absent = Absent::Of(why);
        Self { absent, ..self }
    }

    /// With figures written so.
    #[must_use]
    pub const fn written(self, format: fn(f64) -> String) -> Self {
        let format = Some(format);
        Self { format, ..self }
    }

    fn heading(&self, clock: Clock) -> Heading {
        let Some(metric) = self.figure.metric(clock) else {
            return Heading::explained(self.heading, self.meaning);
        };
        let unit = metric.timer().map_or(metric.unit, Timer::unit_ms);
        Heading {
            meaning: metric.meaning.to_owned(),
            ..Heading::metric(self.heading.replace("{unit}", unit), metric)
        }
    }

    /// A case's cell: its figure with a dot for each process, or the reason why there is none. A time of what is wrong
    /// counts for nothing, unless its error is the question.
    #[must_use]
    pub fn cell(&self, cases: &Cases<'_>, case: &Case) -> Cell {
        let clock = cases.clock();
        let metric = self.figure.metric(clock);
        let usual = |value| written(metric, value);
        let text = match self.figure {
            Figure::Words(of) => of(case),
            Figure::Beside(of) => of(cases, case).as_ref().map(times),
            Figure::Samples(..) => metric.and_then(|metric| {
                let times = sample_spread(case, metric)?;
                measured(case, metric).map(|_| spread(times))
            }),
            figure => {
                let value = figure.of(case, clock);
                value.map(|value| {
                    self.format
                        .map_or_else(|| usual(value), |format| format(value))
                })
            }
        };
        let is_wrong_by_nature = case.outcome == Outcome::Wrong && case.planned.may_be_wrong;
        let has_ended_well = case.counts() || is_wrong_by_nature;
        let Some(text) = text else {
            return Cell::absent(match (self.absent, case.reason.as_str()) {
                (_, "") if !has_ended_well => case.outcome.name(),
                (_, reason) if !has_ended_well => reason,
                (Absent::Declared, _) => metric.map_or(NOT_MEASURED, |metric| metric.absent),
                (Absent::Said(why), _) => why,
                (Absent::Of(why), _) => why(case),
            });
        };
        let cell = Cell::plain(text);
        match metric {
            Some(metric) if metric.kind == Kind::Time && !has_ended_well => Cell {
                title: "it is wrong: this time counts for nothing".to_owned(),
                class: CellClass::Void,
                ..cell
            },
            Some(metric) => dotted(cell, case, metric),
            None => cell,
        }
    }
}

/// Figures of cases below headings: in each row what the caller says of its case, then a cell for each column.
///
/// - `said`: headings of what the caller says
#[must_use]
pub fn case_table<'c>(
    cases: &Cases<'_>,
    mut said: Vec<Heading>,
    columns: &[Column],
    rows: impl IntoIterator<Item = (&'c Case, Vec<Cell>)>,
) -> Table {
    said.extend(columns.iter().map(|column| column.heading(cases.clock())));
    let row = |(case, mut cells): (&Case, Vec<Cell>)| {
        cells.extend(columns.iter().map(|column| column.cell(cases, case)));
        Row {
            cells,
            status: case.outcome.name().to_owned(),
            remark: case.reason.clone(),
        }
    };
    Table::of(said, rows.into_iter().map(row).collect())
}

/// Bytes with their unit, counts with every digit, all else in three.
fn written(metric: Option<&Metric>, value: f64) -> String {
    let is_count = value.fract() == 0.0 && (0.0..1e15).contains(&value);
    match metric.map(|metric| metric.kind) {
        Some(Kind::Bytes) => measured_bytes(value),
        Some(Kind::Counter | Kind::Error) if is_count => digits(value),
        _ => significant(value),
    }
}

/// Which cases a section is about.
#[derive(Debug, Clone, Copy)]
pub enum Select {
    /// Every one.
    All,
    /// Of this value of a condition.
    With(ConditionKey, &'static str),
    /// Those that fit.
    Fitting(fn(&Case) -> bool),
}

/// A further block of a section, such as a second plot.
pub(crate) type MoreOf = fn(&Cases<'_>) -> Result<Option<Block>, ChapterError>;

/// A section. What it lacks is taken from [`Section::EMPTY`].
#[derive(Debug, Clone, Copy)]
pub struct Section<'a> {
    /// Heading.
    pub title: &'a str,
    /// Caption of the table; empty for the title.
    pub caption: &'a str,
    /// What is asked and how it is measured, in a few sentences.
    pub text: &'a str,
    /// Which cases it is about; without one it is left out.
    pub cases: Select,
    /// What names a row.
    pub named_by: Names<'a>,
    /// Figures; without columns there is no table.
    pub columns: &'a [Column],
    /// A table, a plot and pictures for each value of this condition, which their captions end with.
    pub per: Option<ConditionKey>,
    /// Whether `summary.md` repeats its table.
    pub is_main: bool,
    /// Whether every figure of a case's row is bad news.
    pub is_bad: fn(&Case) -> bool,
    /// Whether figures of a row say what is wrong with it, so that no remark does.
    pub shows_what_is_wrong: bool,
    /// What the measurements say of claims.
    pub findings: &'a [fn(&Cases<'_>) -> Finding],
    /// Plot.
    pub drawing: Option<Drawing<'a>>,
    /// Names of notes with paths of pictures, and what each shows.
    pub pictures: &'a [(&'a str, &'a str)],
    /// A table of lines through its cases.
    pub lines: Option<Lines<'a>>,
    /// Further blocks, such as other plots.
    pub more: &'a [MoreOf],
}

impl Section<'_> {
    /// Nothing.
    pub const EMPTY: Section<'static> = Section {
        title: "",
        caption: "",
        text: "",
        cases: Select::All,
        named_by: Names::Joined(&[]),
        columns: &[],
        per: None,
        is_main: false,
        is_bad: |_| false,
        shows_what_is_wrong: false,
        findings: &[],
        drawing: None,
        pictures: &[],
        lines: None,
        more: &[],
    };

    /// Its cases of a study.
    #[must_use]
    pub fn select<'c>(&self, cases: &Cases<'c>) -> Cases<'c> {
        match self.cases {
            Select::All => cases.clone(),
            Select::With(key, value) => cases.with(&[(key, value)]),
            Select::Fitting(fits) => cases.fitting(fits),
        }
    }

    /// What its own findings say; nothing where no case of it was planned.
    #[must_use]
    pub fn found(&self, cases: &Cases<'_>) -> Vec<Finding> {
        let own = self.select(cases);
        if own.is_empty() {
            return Vec::new();
        }
        self.findings.iter().map(|of| of(&own)).collect()
    }

    /// Its heading and its blocks; nothing where no case of it was planned.
    ///
    /// # Errors
    /// [`ChapterError`] when a plot cannot be drawn.
    pub fn blocks(&self, cases: &Cases<'_>) -> Result<Vec<Block>, ChapterError> {
        let own = self.select(cases);
        if own.is_empty() {
            return Ok(Vec::new());
        }
        let mut blocks = Vec::new();
        blocks.extend((!self.title.is_empty()).then(|| Block::section(self.title)));
        blocks.extend((!self.text.is_empty()).then(|| Block::Text(self.text.to_owned())));
        let findings = self.findings.iter().map(|of| Block::Finding(of(&own)));
        blocks.extend(findings);
        let parts = match self.per {
            Some(key) => own.by(key),
            None => vec![("", own.clone())],
        };
        for (part, cases) in parts {
            let caption = match (self.title, part) {
                (title, "") => title.to_owned(),
                ("", part) => part.to_owned(),
                (title, part) => format!("{title}, {part}"),
            };
            if let Some(drawing) = &self.drawing {
                blocks.extend(drawing.block(&caption, &cases)?);
            }
            if !self.columns.is_empty() {
                let caption = match self.caption {
                    "" => &caption,
                    own => own,
                };
                blocks.push(Block::Table(self.table(caption, &cases)));
            }
            blocks.extend(self.pictures(caption, &cases).map(Block::Pictures));
        }
        blocks.extend(self.lines.map(|lines| lines.block(&own)));
        for more in self.more {
            blocks.extend(more(&own)?);
        }
        Ok(blocks)
    }

    /// A table with a row for each of these cases, those that were not measured too.
    #[must_use]
    pub fn table(&self, caption: impl Into<String>, cases: &Cases<'_>) -> Table {
        let rows = cases.iter().map(|case| (case, self.named_by.cells(case)));
        let mut table = case_table(cases, self.named_by.headings(), self.columns, rows);
        let rows = table.rows.into_iter().zip(cases.iter());
        let rows = rows.map(|(mut row, case)| {
            if row.status == Outcome::Wrong.name() && self.shows_what_is_wrong {
                row.remark.clear();
            }
            row.bad_if((self.is_bad)(case))
        });
        table.rows = rows.collect();
        Table {
            caption: caption.into(),
            is_main: self.is_main,
            ..table
        }
    }

    /// Pictures of these cases; `None` where none has any.
    #[must_use]
    pub fn pictures(&self, caption: impl Into<String>, cases: &Cases<'_>) -> Option<Pictures> {
        let figure = |case: &Case| {
            let pictures = self.pictures.iter();
            let drawn = pictures.filter_map(|(note, caption)| Picture::of(case, note, *caption));
            let pictures: Vec<Picture> = drawn.collect();
            (!pictures.is_empty()).then(|| PictureFigure {
                pictures,
                notes: vec![self.named_by.text(case)],
            })
        };
        let figures: Vec<PictureFigure> = cases.iter().filter_map(figure).collect();
        (!figures.is_empty()).then(|| Pictures {
            caption: caption.into(),
            figures,
            ..Pictures::default()
        })
    }
}

/// A chapter of sections.
#[derive(Debug, Clone, Copy)]
pub struct SectionedChapter {
    /// Name of its study.
    pub study: &'static str,
    /// Heading.
    pub title: &'static str,
    /// The study's question, in a line.
    pub question: &'static str,
    /// What is compared, in a few sentences.
    pub text: &'static str,
    /// Words of its own.
    pub terms: &'static [Term],
    /// What ratios and rankings compare.
    pub primary: Figure,
    /// What it offers for the report's first page; its blocks are shown above the sections as well.
    pub answers: fn(&Cases<'_>) -> Answers,
    /// In their order.
    pub sections: &'static [Section<'static>],
    /// Claims of a document, which its last section tests.
    pub claims: Option<&'static StudyClaims>,
}

impl Chapter for SectionedChapter {
    fn study(&self) -> &'static str {
        self.study
    }

    fn title(&self) -> &'static str {
        self.title
    }

    fn question(&self) -> &'static str {
        self.question
    }

    fn primary_metric(&self, clock: Clock) -> Option<&'static str> {
        self.primary.metric(clock).map(|metric| metric.name)
    }

    fn terms(&self) -> &'static [Term] {
        self.terms
    }

    fn answers(&self, run: &Run) -> Result<Answers, ChapterError> {
        let answers = (self.answers)(&Cases::of_study(run, self.study));
        Ok(answers_with_commands(answers, run, self.study))
    }

    fn blocks(&self, run: &Run) -> Result<Vec<Block>, ChapterError> {
        let cases = Cases::of_study(run, self.study);
        if cases.is_empty() {
            return Ok(Vec::new());
        }
        let answers = self.answers(run)?;
        let mut blocks = answers.blocks;
        blocks.extend(answers.requirements.into_iter().map(Block::Finding));
        blocks.push(Block::Text(self.text.to_owned()));
        for section in self.sections {
            blocks.extend(section.blocks(&cases)?);
        }
        if let Some(claims) = self.claims {
            blocks.extend(claims.blocks(&cases)?);
        }
        Ok(with_commands(blocks, run, self.study))
    }

    fn tables(&self, run: &Run) -> Result<Vec<DerivedTable>, ChapterError> {
        let cases = Cases::of_study(run, self.study);
        let claims = self.claims.filter(|_| !cases.is_empty());
        claims
            .map(|claims| claims.table(&cases))
            .into_iter()
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::finding;
    use crate::curves::Panel;
    use crate::figure::{Figure, Names};
    use terrafill_plot::Upwards;
    use terrafill_results::condition::{SCENE, SIZE_PX, VIEW};
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Metric, Scope, Standing, Status, ratio};

    const METRICS: [Metric; 2] = [
        Metric::less("draw_cpu_ms", "ms", Kind::Time, "Time.").covering(Scope::FRAME),
        Metric::bytes("draw_bytes", "Bytes.").or("the layout has no formula"),
    ];
    const TIME: &Metric = Metric::of(&METRICS, "draw_cpu_ms");
    const BYTES: &Metric = Metric::of(&METRICS, "draw_bytes");
    const SECTION: Section<'static> = Section {
        title: "Sizes",
        text: "What a size costs.",
        cases: Select::With(SCENE, "hills"),
        named_by: Names::Joined(&[VIEW, SIZE_PX]),
        columns: &[
            Column::metric("ms", TIME).or("no clock"),
            Column::metric("bytes", BYTES),
            Column::of(
                "by",
                Figure::Words(|case| Some(case.condition(VIEW).to_owned())),
            ),
        ],
        per: Some(VIEW),
        findings: &[|cases| finding("It is small", Some(cases.sum(BYTES) < Some(1e6)), "")],
        drawing: Some(Drawing {
            caption: "Time by size.",
            panels: &[Panel {
                across: ("pixels a side", Figure::Condition(SIZE_PX)),
                up: ("ms", Figure::Metric(TIME)),
                upwards: Upwards::Amount,
                curve: Names::Joined(&[VIEW]),
                knob: Figure::Condition(SIZE_PX),
                ..Panel::EMPTY
            }],
        }),
        pictures: &[("image", "as drawn")],
        ..Section::EMPTY
    };

    fn made_up() -> MadeUpRun {
        let mut run = MadeUpRun {
            metrics: METRICS.to_vec(),
            ..MadeUpRun::default()
        };
        for (scene, view, side, ms) in [
            ("hills", "globe", "64", 1.0),
            ("hills", "globe", "128", 4.0),
            ("hills", "horizon", "64", 2.0),
            ("sea", "globe", "64", 3.0),
        ] {
            let conditions = [("scene", scene), ("view", view), ("size_px", side)];
            let id = case_id("study", &format!("{scene}/{view}/{side}"), &conditions);
            for id in [id.clone(), id.repeat()] {
                let case = run.case(id);
                case.timed(TIME, &[ms, 1.1 * ms, ms, ms, ms]);
                case.figure(BYTES, 1e3 * ms).note("image", "images/a.png");
            }
        }
        run
    }

    fn tables(blocks: &[Block]) -> Vec<&Table> {
        let tables = blocks.iter().filter_map(|block| match block {
            Block::Table(table) => Some(table),
            _ => None,
        });
        tables.collect()
    }

    #[test]
    fn a_section_has_a_row_for_each_of_its_cases_and_none_for_a_repeat() {
        let run = made_up().loaded();
        let cases = Cases::of_study(&run, "study");
        let blocks = SECTION.blocks(&cases).expect("blocks");
        let tables = tables(&blocks);
        assert_eq!(tables.len(), 2, "one a view");
        assert_eq!(tables[0].caption, "Sizes, globe");
        let texts = |row: &Row| {
            row.cells
                .iter()
                .map(|cell| cell.text.clone())
                .collect::<Vec<_>>()
        };
        assert_eq!(tables[0].rows.len(), 2, "no repeats");
        assert_eq!(
            texts(&tables[0].rows[1]),
            ["globe, 128", "4.00", "4.00 kB", "globe"]
        );
        assert!(tables[0].rows[1].cells[1].dots.contains("processes:"));
        assert_eq!(tables[0].headings[0].text, "view, size px");
        let count = |is_of: fn(&Block) -> bool| blocks.iter().filter(|block| is_of(block)).count();
        assert_eq!(count(|block| matches!(block, Block::Plot(_))), 2);
        assert_eq!(count(|block| matches!(block, Block::Pictures(_))), 2);
        assert!(matches!(&blocks[2], Block::Finding(found) if found.standing == Standing::Holds));
        // Negative control: a section of other cases is left out.
        let other = Section {
            cases: Select::With(SCENE, "port"),
            ..SECTION
        };
        assert_eq!(other.blocks(&cases).expect("blocks"), []);
        // A row is bad news where the section says so, and no other.
        let bad = Section {
            is_bad: |case| case.condition(SIZE_PX) == "128",
            ..SECTION
        };
        let hills = cases.with(&[(SCENE, "hills"), (VIEW, "globe")]);
        let classes = bad
            .table("", &hills)
            .rows
            .into_iter()
            .map(|row| row.cells[1].class);
        let are_bad: Vec<bool> = classes.map(|class| class == CellClass::Bad).collect();
        assert_eq!(are_bad, [false, true]);
    }

    #[test]
    fn a_case_stands_beside_another_and_a_table_may_have_a_caption_of_its_own() {
        let section = Section {
            caption: "Every size",
            columns: &[Column::beside("÷ 64 px", |cases, case| {
                let view = case.condition(VIEW);
                let small = cases.with(&[(SIZE_PX, "64"), (VIEW, view)]).first()?;
                ratio(case, small, TIME)
            })
            .meaning("paired by process")],
            per: None,
            ..SECTION
        };
        let mut made = made_up();
        made.cases[4].figures.clear();
        let run = made.loaded();
        let blocks = section.blocks(&Cases::of_study(&run, "study"));
        let blocks = blocks.expect("blocks");
        let table = tables(&blocks)[0];
        assert_eq!(table.caption, "Every size");
        assert_eq!(table.headings[1].meaning, "paired by process");
        let cell = |row: usize| &table.rows[row].cells[1];
        assert!(cell(1).text.starts_with("4.00 ×"), "{}", cell(1).text);
        // Negative control: what was not timed has no ratio.
        assert_eq!(
            (cell(2).text.as_str(), cell(2).title.as_str()),
            ("–", "not measured")
        );
    }

    #[test]
    fn a_time_is_shown_with_its_range_and_clock_and_counts_for_nothing_where_it_is_wrong() {
        const COLUMNS: [Column; 2] = [
            Column::sampled("draw, {unit} (5–95 %)", TIME, TIME),
            Column::metric("bytes", BYTES),
        ];
        let table = |outcome, may_be_wrong| {
            let mut made = made_up();
            made.cases[0].ended(outcome, "9 px").may_be_wrong = may_be_wrong;
            let run = made.loaded();
            let cases = Cases::of_study(&run, "study");
            let first = cases.first().map(|case| (case, vec![Cell::name("said")]));
            case_table(&cases, vec!["case".into()], &COLUMNS, first)
        };
        let right = table(Status::Ok, false);
        let headings: Vec<&str> = right.headings.iter().map(|h| h.text.as_str()).collect();
        assert_eq!(headings, ["case", "draw, process CPU ms (5–95 %)", "bytes"]);
        let cell = |table: &Table| table.rows[0].cells[1].clone();
        assert_eq!(cell(&right).text, "1.00 (1.00–1.08)");
        assert_eq!(cell(&right).class, CellClass::Plain);
        let wrong = table(Status::Wrong, false);
        assert_eq!(cell(&wrong).class, CellClass::Void);
        assert_eq!(
            (wrong.rows[0].status.as_str(), wrong.rows[0].remark.as_str()),
            ("wrong", "9 px")
        );
        // Negative control: where the error is the question, the time stands beside it.
        assert_eq!(cell(&table(Status::Wrong, true)).class, CellClass::Plain);
    }

    #[test]
    fn what_was_not_measured_is_an_empty_cell_with_its_reason_and_never_0() {
        let mut made = made_up();
        made.cases[0].figures.clear();
        made.cases[2].ended(Status::Failed, "out of memory");
        let run = made.loaded();
        let cases = Cases::of_study(&run, "study").with(&[(SCENE, "hills")]);
        let columns = Section {
            named_by: Names::Columns(&[("seen from", VIEW), ("size", SIZE_PX)]),
            ..SECTION
        };
        let table = columns.table("", &cases);
        assert_eq!(table.headings[1].text, "size");
        let cell = |row: usize, column: usize| &table.rows[row].cells[column];
        assert_eq!(
            (cell(0, 2).class, cell(0, 2).title.as_str()),
            (CellClass::Absent, "no clock")
        );
        assert_eq!(cell(0, 3).title, "the layout has no formula", "as declared");
        // Times of a case that broke off are no measurement.
        assert_eq!(cell(1, 2).title, "out of memory");
        assert_eq!(table.rows[1].remark, "out of memory");
        assert_eq!(cell(2, 2).text, "2.00");
        assert_eq!(cases.values(TIME), [2.0]);
        let none = cases.with(&[(VIEW, "none")]);
        assert_eq!((none.sum(TIME), none.least(BYTES)), (None, None));
    }
}
