// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a paper claims, read from its file in `papers/`, and the table of what a run says of it.
//!
//! A claim is quoted to the letter, with its place, what the paper bases it on, its figure, and the test
//! that a study has for it. Which tests there are is the study's; that one that allows for an error says
//! why it allows for so much is checked here.

use crate::comparison::{overall, sentences};
use crate::published::{PublishedRatio, PublishedTable, published, table_problem};
use crate::settling::full_command;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use terrafill_results::{
    Block, Cell, CellClass, ChapterError, Claim, DerivedTable, Heading, Row, RunEnvironment,
    Standing, Table, TableLayout,
};

/// What a paper bases a claim on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// It gives a figure, or says that it timed or counted.
    Measured,
    /// It saw it happen.
    Observed,
    /// It expects it.
    Anticipated,
    /// It names a possibility.
    Considered,
}

impl Basis {
    /// In the order of how much a claim rests on.
    pub const ALL: [Self; 4] = [
        Self::Measured,
        Self::Observed,
        Self::Anticipated,
        Self::Considered,
    ];

    /// In tables and sentences.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Observed => "observed",
            Self::Anticipated => "anticipated",
            Self::Considered => "considered",
        }
    }
}

/// How a study tests a claim.
pub trait Tested {
    /// What is expected of a ratio; `None` for a test of another kind.
    fn expects(&self) -> Option<Claim>;

    /// Why there is no test; `None` where there is one.
    fn cannot(&self) -> Option<&str>;
}

/// A claim, tested by `T`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Claimed<T> {
    /// To the letter.
    pub words: String,
    /// Section and its title.
    pub place: String,
    /// What it is based on.
    pub basis: Basis,
    /// The paper's figure; empty without one in its text.
    #[serde(default)]
    pub figure: String,
    /// What is tried here; empty where nothing is.
    #[serde(default)]
    pub experiment: String,
    /// Why a factor may be off by as much as the test allows.
    #[serde(default)]
    pub tolerance: String,
    /// What explains our figure where no counter of a run does.
    #[serde(default)]
    pub because: String,
    /// Ratios of its tables that the claim rests on.
    #[serde(default)]
    pub published: Vec<PublishedRatio>,
    /// Whose chapter has it, where several studies share a document.
    #[serde(default)]
    pub study: String,
    /// How.
    pub test: T,
}

/// The claims of a paper.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Paper<T> {
    /// As cited: `Cozzi (2007)`.
    pub source: String,
    /// File of the document among the papers, without its ending.
    pub document: String,
    /// What a reader must know of its figures, in sentences.
    pub remark: String,
    /// Every claim, in the paper's order.
    #[serde(rename = "claim")]
    pub claims: Vec<Claimed<T>>,
    /// Steps of the study's ablation that claims speak of, each with the conditions that it changes.
    #[serde(default)]
    pub steps: BTreeMap<String, Vec<String>>,
    /// Cases that claims name, each with its conditions.
    #[serde(default)]
    pub cases: BTreeMap<String, String>,
    /// Figures that it printed.
    #[serde(default, rename = "table")]
    pub tables: Vec<PublishedTable>,
    /// Quotations within experiments: the words, and the place where they stand.
    #[serde(default)]
    pub quoted: Vec<[String; 2]>,
}

/// Why a file of claims cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PaperError {
    /// Not the form that it must have.
    #[error("{file}: {source}")]
    Form {
        /// Which file.
        file: String,
        /// Line, column, and what is wrong there.
        #[source]
        source: toml::de::Error,
    },
    /// A claim that contradicts itself.
    #[error("{file}: the claim {words:?} {problem}")]
    Claim {
        /// Which file.
        file: String,
        /// Which claim.
        words: String,
        /// What is wrong with it.
        problem: &'static str,
    },
}

impl<T: DeserializeOwned + Tested> Paper<T> {
    /// Reads a file of claims.
    ///
    /// - `file`: its name, for errors
    ///
    /// # Errors
    /// [`PaperError`], with the place and what is wrong there.
    pub fn parse(file: &str, text: &str) -> Result<Self, PaperError> {
        let paper: Self = toml::from_str(text).map_err(|source| PaperError::Form {
            file: file.to_owned(),
            source,
        })?;
        for (place, claimed) in paper.claims.iter().enumerate() {
            let earlier = &paper.claims[..place];
            let of_table = || table_problem(&paper.tables, &claimed.published);
            if let Some(problem) = problem(claimed, earlier).or_else(of_table) {
                return Err(PaperError::Claim {
                    file: file.to_owned(),
                    words: claimed.words.clone(),
                    problem,
                });
            }
        }
        Ok(paper)
    }
}

fn problem<T: Tested>(claimed: &Claimed<T>, earlier: &[Claimed<T>]) -> Option<&'static str> {
    let is_factor = matches!(claimed.test.expects(), Some(Claim::Factor { .. }));
    let is_repeated = || {
        let is_same =
            |other: &Claimed<T>| (&other.words, &other.place) == (&claimed.words, &claimed.place);
        earlier.iter().any(is_same)
    };
    match claimed.test.cannot() {
        _ if claimed.words.is_empty() => Some("has no words"),
        _ if is_repeated() => Some("stands here twice"),
        Some("") => Some("cannot be tested and does not say why"),
        Some(_) if !claimed.experiment.is_empty() => Some("cannot be tested and has an experiment"),
        None if claimed.experiment.is_empty() => {
            Some("is tested by an experiment that is not described")
        }
        None if is_factor && claimed.tolerance.is_empty() => {
            Some("is of a factor and does not say why its tolerance is as wide as it is")
        }
        _ => None,
    }
}

/// What a run says of a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClaimAnswer {
    /// With intervals; empty where nothing was measured.
    pub ours: String,
    /// Of the claim.
    pub standing: Standing,
    /// From counters where there are any, else why there is no verdict and what would give one.
    pub reason: String,
}

impl ClaimAnswer {
    /// All views of a claim together, each with its figure and what it says.
    ///
    /// - `reason`: from counters where there are any
    #[must_use]
    pub fn of_views(views: Vec<(String, Standing)>, reason: String) -> Self {
        let (ours, standings): (Vec<String>, Vec<Standing>) = views.into_iter().unzip();
        let standing = overall(&standings);
        Self {
            ours: ours.join("; "),
            standing,
            reason: match standing {
                Standing::NotMeasured => "its rows are not in this run".to_owned(),
                _ => reason,
            },
        }
    }

    /// Why there is no answer.
    #[must_use]
    pub fn unanswered(standing: Standing, why: &str) -> Self {
        Self {
            ours: String::new(),
            standing,
            reason: why.to_owned(),
        }
    }
}

impl<T> Paper<T> {
    /// Its figure in words, and what its tables say.
    fn figure(&self, claimed: &Claimed<T>) -> String {
        let tables = published(&self.tables, &claimed.published);
        sentences(std::iter::once(claimed.figure.clone()).chain(tables))
    }

    /// What a run says of each claim, in order, with what explains it or the command that would measure it.
    ///
    /// - `study`: that tests the claims
    pub fn answers(
        &self,
        environment: &RunEnvironment,
        study: &str,
        answer: impl Fn(&T) -> ClaimAnswer,
    ) -> Vec<ClaimAnswer> {
        let command = full_command(environment, study);
        let all = self.claims.iter().map(|claimed| {
            let answer = answer(&claimed.test);
            let reason = match answer.standing {
                Standing::NotMeasured => {
                    sentences([answer.reason.as_str(), &format!("To measure it: {command}")])
                }
                _ => sentences([&claimed.because, &answer.reason]),
            };
            ClaimAnswer { reason, ..answer }
        });
        all.collect()
    }
}

/// A section with the table of claims, and how many of them ended how; nothing for a run that measured none.
///
/// - `answers`: one for each claim of the paper
/// - `bound`: what is taken as no difference, in a sentence
#[must_use]
pub fn claims_blocks<T: Tested>(
    title: &str,
    paper: &Paper<T>,
    answers: &[ClaimAnswer],
    bound: &str,
) -> Vec<Block> {
    let rows = || paper.claims.iter().zip(answers);
    vec![
        Block::section(title),
        Block::Text(format!(
            "Every claim of {}, quoted to the letter, in the document's order. {} {bound} {}",
            paper.source,
            paper.remark,
            tally(paper, answers)
        )),
        Block::Table(Table {
            headings: [
                "claim",
                "basis",
                "its figure",
                "experiment here",
                "our figure",
                "verdict",
                "reason",
            ]
            .map(Heading::plain)
            .into(),
            rows: rows()
                .map(|(claimed, answer)| row(paper, claimed, answer))
                .collect(),
            layout: TableLayout::Cards,
            ..Table::default()
        }),
    ]
}

fn row<T>(paper: &Paper<T>, claimed: &Claimed<T>, answer: &ClaimAnswer) -> Row {
    let or_absent = |text: &str, why: &str| match text {
        "" => Cell::absent(why),
        text => Cell::name(text),
    };
    let cannot = match answer.standing {
        Standing::CannotBeTested | Standing::NotMeasured => answer.reason.as_str(),
        _ => "none",
    };
    let figure = or_absent(&paper.figure(claimed), "the document's text has none");
    Row::new(vec![
        Cell {
            detail: claimed.place.clone(),
            ..Cell::name(format!("“{}”", claimed.words))
        },
        Cell::plain(claimed.basis.name()),
        Cell {
            detail: claimed.tolerance.clone(),
            ..figure
        },
        or_absent(&claimed.experiment, cannot),
        or_absent(&answer.ours, cannot),
        Cell {
            class: match answer.standing {
                Standing::Holds => CellClass::Good,
                Standing::DoesNotHold => CellClass::Bad,
                _ => CellClass::Plain,
            },
            ..Cell::plain(answer.standing.name())
        },
        Cell::name(&answer.reason),
    ])
}

fn tally<T>(paper: &Paper<T>, answers: &[ClaimAnswer]) -> String {
    let bases = Basis::ALL.map(|basis| {
        let of_basis = paper.claims.iter().filter(|claimed| claimed.basis == basis);
        format!("{} {}", of_basis.count(), basis.name())
    });
    let verdicts = Standing::ALL.map(|standing| {
        let ended = answers.iter().filter(|answer| answer.standing == standing);
        format!("{}: {}", standing.name(), ended.count())
    });
    format!(
        "{} claims: {}. Verdicts: {}.",
        paper.claims.len(),
        bases.join(", "),
        verdicts.join(", ")
    )
}

/// The table as data.
///
/// - `file`: its name, `claims.csv`
///
/// # Errors
/// [`ChapterError`] when it cannot be written.
pub fn claims_table<T>(
    file: &str,
    paper: &Paper<T>,
    answers: &[ClaimAnswer],
) -> Result<DerivedTable, ChapterError> {
    let header = [
        "words",
        "place",
        "basis",
        "figure",
        "experiment",
        "ours",
        "verdict",
        "reason",
    ];
    let rows = paper.claims.iter().zip(answers).map(|(claimed, answer)| {
        vec![
            claimed.words.clone(),
            claimed.place.clone(),
            claimed.basis.name().to_owned(),
            paper.figure(claimed),
            claimed.experiment.clone(),
            answer.ours.clone(),
            answer.standing.name().to_owned(),
            answer.reason.clone(),
        ]
    });
    DerivedTable::new(file, &header, rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone, PartialEq, Deserialize)]
    #[serde(rename_all = "kebab-case", deny_unknown_fields)]
    enum Test {
        Ratio(Claim),
        No(String),
    }

    impl Tested for Test {
        fn expects(&self) -> Option<Claim> {
            match self {
                Self::Ratio(claim) => Some(*claim),
                Self::No(_) => None,
            }
        }

        fn cannot(&self) -> Option<&str> {
            match self {
                Self::No(why) => Some(why),
                Self::Ratio(_) => None,
            }
        }
    }

    const HEAD: &str = "source = 'A (2007)'\ndocument = 'a'\nremark = 'On one machine.'\n";
    const FASTER: &str = "[[claim]]\nwords = 'faster'\nplace = '1'\nbasis = 'measured'\nfigure = '2 ×'\n\
                          experiment = 'time'\ntest = { ratio = 'faster' }\n";
    const UNTESTED: &str = "[[claim]]\nwords = 'nice'\nplace = '2'\nbasis = 'observed'\n\
                            test = { no = 'no figure says so' }\n";

    fn parsed(claims: &[&str]) -> Result<Paper<Test>, String> {
        let text = format!("{HEAD}{}", claims.concat());
        Paper::parse("a.toml", &text).map_err(|error| error.to_string())
    }

    #[test]
    fn claims_are_read_and_what_contradicts_itself_is_refused() {
        let paper = parsed(&[FASTER, UNTESTED]).expect("two claims");
        let tests = paper.claims.iter().map(|claimed| claimed.test.clone());
        let no = Test::No("no figure says so".to_owned());
        assert_eq!(tests.collect::<Vec<_>>(), [Test::Ratio(Claim::Faster), no]);
        let factor = FASTER.replace("'faster' }", "{ factor = { of = 2.0, within = 1.1 } } }");
        let reasoned = format!("{factor}tolerance = 'whole frames a second'\n");
        assert!(parsed(&[&reasoned]).is_ok());
        // Negative controls.
        for (claims, said) in [
            (&[factor.as_str()][..], "does not say why its tolerance"),
            (&[FASTER, FASTER], "stands here twice"),
            (
                &[&FASTER.replace("experiment = 'time'\n", "")],
                "is not described",
            ),
            (
                &[&UNTESTED.replace("no figure says so", "")],
                "does not say why",
            ),
            (&[&FASTER.replace("measured", "guessed")], "guessed"),
            (&[&FASTER.replace("ratio", "ration")], "ration"),
            (&[&FASTER.replace("figure", "figures")], "figures"),
        ] {
            let error = parsed(claims).expect_err(said);
            assert!(
                error.contains(said) && error.starts_with("a.toml"),
                "{error}"
            );
        }
    }

    #[test]
    fn an_answer_is_of_all_views_and_what_was_not_measured_says_how() {
        let paper = parsed(&[FASTER, UNTESTED]).expect("two claims");
        let answers_of = |views: &[(&str, Standing)]| {
            let answer = |test: &Test| match test {
                Test::No(why) => ClaimAnswer::unanswered(Standing::CannotBeTested, why),
                Test::Ratio(_) => {
                    let views = views.iter().map(|(text, of)| ((*text).to_owned(), *of));
                    ClaimAnswer::of_views(views.collect(), "fewer draws".to_owned())
                }
            };
            paper.answers(&RunEnvironment::default(), "study", answer)
        };
        let answers = answers_of(&[
            ("globe 2 ×", Standing::Holds),
            ("horizon 3 ×", Standing::Holds),
        ]);
        let [faster, nice] = &answers[..] else {
            panic!("one for each claim: {answers:?}");
        };
        assert_eq!(faster.ours, "globe 2 ×; horizon 3 ×");
        assert_eq!(
            (faster.standing, faster.reason.as_str()),
            (Standing::Holds, "fewer draws")
        );
        assert_eq!(nice.reason, "no figure says so");
        // Negative controls: one view that does not hold, and none at all.
        let answers = answers_of(&[("a", Standing::Holds), ("b", Standing::DoesNotHold)]);
        assert_eq!(answers[0].standing, Standing::DoesNotHold);
        let answers = answers_of(&[]);
        assert_eq!(answers[0].standing, Standing::NotMeasured);
        let how = "its rows are not in this run. To measure it: terrafill bench --study study";
        assert!(answers[0].reason.starts_with(how), "{}", answers[0].reason);
    }

    #[test]
    fn every_claim_has_its_row_and_every_verdict_is_counted() {
        let paper = parsed(&[FASTER, UNTESTED]).expect("two claims");
        let answers = [
            ClaimAnswer {
                ours: "1.01 ×".to_owned(),
                standing: Standing::NoDifference,
                reason: String::new(),
            },
            ClaimAnswer {
                ours: String::new(),
                standing: Standing::CannotBeTested,
                reason: "no figure says so".to_owned(),
            },
        ];
        let blocks = claims_blocks("Claims", &paper, &answers, "Less than 1 % is none.");
        let [_, Block::Text(text), Block::Table(table)] = &blocks[..] else {
            panic!("a heading, a text and a table: {blocks:?}");
        };
        assert!(text.contains("2 claims: 1 measured, 1 observed"), "{text}");
        assert!(
            text.contains("holds: 0, does not hold: 0, no difference: 1"),
            "{text}"
        );
        assert!(text.contains("cannot be tested: 1"), "{text}");
        let absent = &table.rows[1].cells[4];
        assert_eq!(
            (absent.class, absent.title.as_str()),
            (CellClass::Absent, "no figure says so")
        );
        let table = claims_table("claims.csv", &paper, &answers).expect("a table");
        assert!(
            table
                .text
                .contains("faster,1,measured,2 ×,time,1.01 ×,no difference,"),
            "{}",
            table.text
        );
    }
}
