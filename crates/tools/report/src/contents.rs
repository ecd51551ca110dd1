// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a report is made of.

use crate::glossary::Glossary;
use crate::verdict::{Sentences, Verdict};
use crate::view::Form;
use terrafill_results::{Answers, Block, Chapter, Run, RunInput};

/// A chapter with what it says.
pub(crate) type Part<'a> = (&'a dyn Chapter, Vec<Block>, Answers);

/// What a report is made of.
pub(crate) struct Report<'a> {
    pub(crate) run: &'a Run,
    pub(crate) form: Form,
    pub(crate) verdict: Verdict,
    pub(crate) said: Sentences,
    pub(crate) environment: Vec<(&'static str, String)>,
    pub(crate) inputs: &'a [RunInput],
    pub(crate) missing: &'a [String],
    pub(crate) wrong: Vec<String>,
    pub(crate) skipped_cases: Vec<(&'a str, Vec<String>)>,
    pub(crate) contradictions: Vec<String>,
    pub(crate) parts: &'a [Part<'a>],
    pub(crate) glossary: Glossary,
}
