// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured fill: what a picture costs beside the plain fill of the same processes, how far its texels
//! are from where they should be, and what it looks like beside the reference.
//!
//! Cozzi (2007) named the two arctangents of the texture coordinates as what textured fill loses most
//! on: what the run says of that stands in the table of its claims.

use super::data::{Data, Timed, grouped, layout_name, one_change, title};
use super::table::head;
use crate::claims::PAPER;
use crate::keys::*;
use crate::purpose::switches;
use terrafill_lab::{
    Cases, Column, Comparison, Figure, Follows, Names, Section, finding, sentences,
};
use terrafill_results::{Block, Case, Claim, ConditionKey, Estimate, Finding, Outcome, ratio};
use terrafill_variant::Switches;

/// Switches that a plain fill of the same layout has not.
const TEXTURE_KEYS: [ConditionKey; 4] = [NORMALIZE, PICTURE, POSITION, TEXTURE];

/// The picture that a fill shows unless it names another.
const USUAL_PICTURE: &str = "scene";

/// How many times the plain fill a textured one may take.
const MAX_OVER_PLAIN: f64 = 1.3;

/// The view for which that is asked.
const TOP_DOWN: &str = "top-down";

// Names of `cases` in the document's file.
pub(super) const PLAIN: &str = "plain fill";
const CHOSEN: &str = "chosen route";
/// The document's fill as it was.
pub(super) const AS_IN_2007: &str = "as in 2007";

/// Why a row has no ratio to another.
const NO_RATIO: &str = "a plain fill, or one of the two is not right or not timed";

/// Fills of a view. A row that is wrong though it should be right, or that nothing was compared of, is bad news.
const FILLS_OF_VIEW: Section<'static> = Section {
    named_by: Names::Of("fill", |case| {
        format!("{}: {}", layout_name(case), label(case))
    }),
    columns: &[
        Column::clocked("fill, ms", FILL_GPU_MS, FILL_CPU_MS),
        Column::beside("÷\u{a0}plain", over_plain).or(NO_RATIO),
        Column::beside("÷\u{a0}chosen route", over_chosen).or(NO_RATIO),
        Column::metric("texels, RMS", TEXEL_RMS),
        Column::metric("texels, largest", TEXEL_MAX),
        Column::metric("non-finite", TEXEL_NON_FINITE),
        Column::metric("px compared", TEXEL_COMPARED_PX),
        Column::metric("colours off, mean of 255", COLOUR_MEAN),
        Column::metric("at most", COLOUR_MAX),
        Column::metric("texture bytes", TEXTURE_BYTES),
        Column::of("route", Figure::Words(route)).or("by its name"),
    ],
    pictures: &[
        ("reference_image", "reference"),
        ("image", "technique"),
        ("difference_image", "difference × 10"),
    ],
    is_main: true,
    is_bad: |case| {
        let is_uncompared = case.value(TEXEL_COMPARED_PX) == Some(0.0);
        is_uncompared || (case.outcome == Outcome::Wrong && !may_be_compared(case))
    },
    ..Section::EMPTY
};

fn route(case: &Case) -> Option<String> {
    Some(case.note("texture_route").to_owned()).filter(|route| !route.is_empty())
}

fn over_plain(cases: &Cases<'_>, case: &Case) -> Option<Estimate> {
    let plain = plain_of(cases.iter(), case).filter(|_| is_textured(case))?;
    over(cases, case, plain)
}

fn over_chosen(cases: &Cases<'_>, case: &Case) -> Option<Estimate> {
    let is_chosen = |other: &&Case| {
        is_textured(other) && label(other) == CHOSEN && layout_name(other) == layout_name(case)
    };
    let chosen = cases.iter().find(is_chosen);
    over(cases, case, chosen.filter(|_| is_textured(case))?)
}

fn over(cases: &Cases<'_>, case: &Case, other: &Case) -> Option<Estimate> {
    let metric = cases.clock().pick(FILL_GPU_MS, FILL_CPU_MS);
    let are_both = may_be_compared(case) && may_be_compared(other);
    ratio(case, other, metric).filter(|_| are_both)
}

/// Whether the case is a textured fill.
pub(super) fn is_textured(case: &Case) -> bool {
    !["", "none", "plain"].contains(&case.condition(TEXTURE))
}

/// Switches that make the fill a textured one and are not as usual, `key=value`, by name; none of a plain
/// fill. A run records every switch.
fn texture_switches(case: &Case) -> String {
    let usual = Switches::default();
    let is_usual = |key: ConditionKey, value: &str| match key {
        PICTURE => value == USUAL_PICTURE,
        _ => usual.setting(key.name()) == value,
    };
    let own = TEXTURE_KEYS.map(|key| (key, case.condition(key)));
    let own = own
        .into_iter()
        .filter(|(key, value)| is_textured(case) && !value.is_empty() && !is_usual(*key, value));
    let own = own.map(|(key, value)| format!("{}={value}", key.name()));
    own.collect::<Vec<_>>().join(",")
}

/// What a case is, in words where it has some.
pub(super) fn label(case: &Case) -> String {
    let set = texture_switches(case);
    let named = PAPER.cases.iter().find(|(_, own)| **own == set);
    named.map_or(set.clone(), |(name, _)| name.clone())
}

/// The same fill without a picture, among the cases of its view.
fn plain_of<'a>(mut cases: impl Iterator<Item = &'a Case>, case: &Case) -> Option<&'a Case> {
    let others = |case| {
        let mut others = switches(case);
        others.retain(|(key, _)| TEXTURE_KEYS.iter().all(|own| own.name() != *key));
        others
    };
    cases.find(|other| {
        !is_textured(other)
            && layout_name(other) == layout_name(case)
            && others(other) == others(case)
    })
}

/// Right, or a fill of the document, whose error is part of the answer.
fn may_be_compared(case: &Case) -> bool {
    case.counts() || case.planned.may_be_wrong && case.outcome == Outcome::Wrong
}

/// Each view's textured fills and the plain ones that they are compared with, by its title.
fn views<'a>(data: &Data<'a>) -> Vec<(String, Cases<'a>)> {
    let all = &data.study;
    let textured = all.fitting(is_textured);
    let views = grouped(textured.iter(), |case| title(case)).into_iter();
    let views = views.map(|(view, mut own)| {
        let plain = own
            .iter()
            .filter_map(|case| plain_of(data.beside(case).iter().copied(), case));
        let plain: Vec<&Case> = plain.collect();
        own.extend(plain);
        let cases = all.fitting(|case| own.iter().any(|own| own.id() == case.id()));
        (view, cases)
    });
    views.collect()
}

/// Two fills of a view by their names, where both may be compared. The plain one is that of the same technique
/// and layout, not the first one there is.
fn pair<'a>(cases: &Cases<'a>, [first, second]: [&str; 2]) -> Option<[&'a Case; 2]> {
    let named = |name: &str| {
        let is_named = |case: &&Case| is_textured(case) && label(case) == name;
        cases.iter().find(is_named)
    };
    let first = named(first)?;
    let second = match second {
        PLAIN => plain_of(cases.iter(), first)?,
        _ => named(second)?,
    };
    let both = [first, second];
    both.into_iter().all(may_be_compared).then_some(both)
}

/// What two fills differ in: one switch, or the route with what belongs to it.
fn pairing([first, second]: [&Case; 2]) -> Comparison<'static> {
    const fn part(key: ConditionKey) -> Follows<'static> {
        Follows {
            key: key.name(),
            because: "where a route starts, what it normalises and shows is part of it",
        }
    }
    let differs = |key: &&ConditionKey| first.condition(**key) != second.condition(**key);
    match TEXTURE_KEYS.iter().rfind(differs) {
        Some(key) if *key != TEXTURE => one_change(*key),
        _ => Comparison {
            follows: const { &[part(NORMALIZE), part(PICTURE), part(POSITION)] },
            ..one_change(TEXTURE)
        },
    }
}

/// Two fills by their names, in every view that has both.
pub(super) fn compared<'a>(data: &Data<'a>, names: [&str; 2]) -> Vec<Timed<'a>> {
    let of = |(title, cases): (String, Cases<'a>)| {
        let cases = pair(&cases, names)?;
        let pairing = pairing(cases);
        Some(Timed {
            title,
            pairing,
            cases,
        })
    };
    views(data).into_iter().filter_map(of).collect()
}

/// What is required of textured fills, in each view from above that has the times; nothing for a run that
/// plans none.
pub(super) fn requirements(data: &Data<'_>) -> Vec<Finding> {
    let claim = "This project's goal: filling with a picture takes less than 1.3 times as long as with a colour.";
    let from_above = compared(data, [CHOSEN, PLAIN]).into_iter();
    let from_above = from_above.filter(|timed| timed.cases[0].condition(VIEW) == TOP_DOWN);
    let found = from_above.filter_map(|timed| {
        let comparison = Comparison {
            metric: data.time_covering(timed.pairing.needs),
            ..timed.pairing
        };
        let answer = data.judge(comparison, timed.cases, Claim::LessThan(MAX_OVER_PLAIN));
        let ratio = data.timings.ratio_text(answer.figure.as_ref()?);
        Some(Finding {
            claim: claim.to_owned(),
            standing: answer.standing,
            because: sentences([format!("{}: {ratio}", timed.title), answer.because]),
        })
    });
    let found: Vec<Finding> = found.collect();
    if found.is_empty() && !views(data).is_empty() {
        vec![finding(claim, None, "")]
    } else {
        found
    }
}

/// Nothing for a run that plans no textured fill.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let views = views(data);
    if views.is_empty() {
        return Vec::new();
    }
    let mut blocks = head(
        "Textured fill",
        format!(
            "Every fragment of a textured fill finds its longitude and latitude and from them its place \
             in a picture. Times are {}, beside the plain fill of the same layout in the same \
             processes; an interval is that of 95 %. The error of a fill is how far its texels lie from \
             the reference's, in texels, outside silhouettes: at most ¼ RMS and ½ anywhere, or the row \
             is wrong. The least textured fill is what every such fill must pay: the same stencil and \
             the same pixels, but a fragment only reads its depth and samples the picture once, nowhere \
             in particular; its texels have no error. Pictures are a part of the image round the middle of \
             what is filled, a pixel for a pixel: reference, technique, and ten times their difference where \
             both fill with the same region. What is not filled is one colour in the reference and shaded \
             surface in the technique's.",
            data.run.clock().name()
        ),
    );
    for (title, cases) in &views {
        blocks.push(Block::part(format!("Textured: {title}")));
        blocks.push(Block::Table(FILLS_OF_VIEW.table("", cases)));
        // Those of the first that has some.
        let first = cases.iter().find(|case| case.value(COLOUR_MAX).is_some());
        let first = cases.fitting(|case| first.is_some_and(|first| first.id() == case.id()));
        blocks.extend(FILLS_OF_VIEW.pictures("", &first).map(Block::Pictures));
    }
    blocks
}
