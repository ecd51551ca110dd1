// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on shadows: a section a question, what was published beside what is measured.

mod claims;
mod drawn;
mod elsewhere;
mod findings;
mod lights;
mod plots;
mod sections;
mod times;

use crate::metrics::{QUESTION, SUN, TIME};
use sections::SECTIONS;
use terrafill_lab::{Cases, Figure, SectionedChapter};
use terrafill_results::{Answers, Block, Case, ConditionKey, Metric};

/// What each optimisation of shadow volumes saves and gets wrong.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Shadows: what each optimisation of shadow volumes saves, and its error",
    question: "What does each optimisation of shadow volumes save in a port, and what does it get wrong?",
    text: "The casters are a procedural port: a trestle dock, cranes, ships, containers, in seven channels over 270° from \
           a bridge 30 m up, or the model of the first section. The reference sends rays in f64 from each visible point to the sun, and a second test looks \
           from the sun down. A volume's mask is what a stencil would hold: its triangles, counted along the ray of each \
           pixel. Devices draw the same volumes in a section of their own. Wrong pixels are counted outside the band of \
           one pixel along the shadow's boundary. Pixels on faces within 10⁻³ of edge-on to the sun are not judged. \
           Shadows are hard: the sun's disc of 0.53° and refraction are left out. In pictures the sea is blue, casters are \
           sand, shadow is dark; purple is not judged. Published: \"about 35 fps\" for part of a trestle dock on a GeForce \
           6800, all optimisations on (Yang & Jin, 2006); no resolution, triangle count, sun or baseline.",
    terms: crate::metrics::TERMS,
    primary: Figure::Metric(TIME),
    answers,
    sections: &SECTIONS,
    claims: Some(&claims::CLAIMS),
};

fn answers(cases: &Cases<'_>) -> Answers {
    let own = Own(cases.clone());
    let findings = own.findings().into_iter();
    Answers {
        blocks: findings.map(Block::Finding).collect(),
        requirements: own.controls().into_iter().collect(),
        ..Answers::default()
    }
}

/// The study's cases of a run, by question.
struct Own<'a>(Cases<'a>);

impl<'a> Own<'a> {
    fn question(&self, question: &str) -> Cases<'a> {
        self.0.with(&[(QUESTION, question)])
    }

    fn of_question<'s>(&'s self, question: &'s str) -> impl Iterator<Item = &'a Case> + 's {
        let all = self.0.iter();
        all.filter(move |case| case.condition(QUESTION) == question)
    }

    /// The first value of a metric where all conditions hold.
    fn value(
        &self,
        question: &str,
        conditions: &[(ConditionKey, &str)],
        metric: &Metric,
    ) -> Option<f64> {
        self.question(question).with(conditions).value(metric)
    }

    /// Suns of a question, in order.
    fn suns(&self, question: &str) -> Vec<&'a str> {
        self.question(question).distinct(SUN)
    }
}

#[cfg(test)]
mod tests;
