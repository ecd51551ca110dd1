// SPDX-License-Identifier: MIT OR Apache-2.0
//! The answer: for each view the fastest, the smallest, the most exact and the recommended fill, what
//! follows from them in words, and which requirements are met.
//!
//! Everything is computed from the rows. A fill is a technique with its switches; it competes where its
//! picture is right and its time was measured.

use super::contest::{Contest, ranked, tied};
use super::data::{Data, grouped, is_baseline, label};
use super::table::or_dash;
use super::{error_time, memory, needs, take, textured};
use crate::keys::*;
use crate::purpose::{Purpose, is_approximate, is_control};
use terrafill_conformance::MAX_ROUNDED_PX;
use terrafill_lab::{none_differs, some_of};
use terrafill_plot::dotted;
use terrafill_plot::number::{count, digits, elided, figure, measured_bytes, significant};
use terrafill_results::{
    Answers, Block, Case, Cell, ChapterError, Finding, Outcome, Row, Run, Table, TableLayout,
};

/// Characters of a fill's name on a terminal, so that its figures fit beside it.
const MAX_NAME: usize = 48;

/// A kind of view, and whether a view is one.
type Kind = (&'static str, fn(&Contest<'_, '_>) -> bool);

const KINDS: [Kind; 4] = [
    ("Many regions in view (from 50 on)", |contest| {
        contest.counted(REGIONS_DRAWN) >= Some(50.0)
    }),
    // A volume that covers the view from near has thousands.
    (
        "Eye near, fill rate is the limit (from 1,000 stencil-tested fragments a vertex on)",
        |contest| contest.fragments_a_vertex() >= Some(1_000.0),
    ),
    // A triangle of so many is smaller than a block of 4 × 4 pixels.
    (
        "Eye far, vertices are the limit (at most 16 fragments a vertex)",
        |contest| {
            contest
                .fragments_a_vertex()
                .is_some_and(|each| each <= 16.0)
        },
    ),
    ("Over all views", |_| true),
];

/// Stands for the recommended fill in other columns.
const SAME: &str = "the same";

/// What the chapter offers for the first page.
pub(super) fn answers(data: &Data<'_>) -> Result<Answers, ChapterError> {
    let contests = data.views.iter().map(|view| Contest::new(data, view));
    let contests: Vec<Contest<'_, '_>> = contests.collect();
    let rows = contests.iter().filter_map(|contest| row(data, contest));
    let mut rows: Vec<Row> = rows.collect();
    let mut blocks = Vec::new();
    if !rows.is_empty() {
        let mut headings = vec![
            "scene, view",
            "recommended",
            "fastest",
            "ties",
            "smallest",
            "most exact",
        ];
        for column in (1..headings.len()).rev() {
            if rows.iter().all(|row| row.cells[column].text == SAME) {
                headings.remove(column);
                for row in &mut rows {
                    drop(row.cells.remove(column));
                }
            }
        }
        let caption = format!(
            "Every view with its best fills. Recommended: of the fastest fill and its ties, which differ from it by no \
             more than the same work measured twice, the one with the fewest bytes of geometry. A column that says nothing \
             else is left out. In a cell: {} with its 95 % interval where processes suffice, bytes of geometry, by how \
             many pixels the boundary is off the reference's, of these on purpose by levels of detail, and how many \
             pixels differ.",
            data.timings.unit(),
        );
        blocks.extend(take::blocks(data, &contests)?);
        blocks.push(Block::Table(Table {
            caption,
            is_main: true,
            layout: TableLayout::Cards,
            ..Table::of(headings, rows)
        }));
        blocks.push(error_time::of_run(data)?);
        blocks.extend(guide(data, &contests));
    }
    Ok(Answers {
        scope: scope(data).into_iter().collect(),
        blocks,
        requirements: requirements(data),
    })
}

/// The winners of a view.
fn row(data: &Data<'_>, contest: &Contest<'_, '_>) -> Option<Row> {
    let (view, fills) = (contest.view, &contest.fills);
    let fastest = *fills.first()?;
    let is_tie = |fill: &&Case| {
        let over = contest.over_fastest(data, fill);
        over.is_some_and(|over| data.timings.is_tie(over))
    };
    let ties: Vec<&Case> = fills[1..].iter().copied().filter(is_tie).collect();
    let bytes = |case: &Case| case.value(GEOMETRY_BYTES);
    let recommended = least(std::iter::once(&fastest).chain(&ties), bytes).unwrap_or(fastest);
    let cell = |fill: Option<&Case>| match fill {
        Some(fill) if std::ptr::eq(fill, recommended) => Cell::name(SAME),
        Some(fill) => winner(data, fill),
        None => Cell::absent("no fill of this view has such a figure"),
    };
    let all = view.cases.iter();
    let all = all.filter(|case| !Purpose::Sweep.is_of(case) && !is_approximate(case));
    // A run of an older program has no maps.
    let mut notes = ["map_image", "reference_image"].into_iter();
    let picture = notes.find_map(|note| {
        let files = view.cases.iter().map(|case| case.note(note));
        files.max().filter(|file| !file.is_empty())
    });
    let regions = contest.counted(REGIONS_DRAWN);
    let regions = regions.map_or_else(String::new, |drawn| {
        format!(
            ", {} {}",
            digits(drawn),
            if drawn == 1.0 { "region" } else { "regions" }
        )
    });
    let name = Cell {
        detail: format!("{} of {} fills right{regions}", fills.len(), all.count()),
        picture: picture.unwrap_or_default().to_owned(),
        section: view.scene.to_owned(),
        ..Cell::name(view.title())
    };
    let names: Vec<String> = ties.iter().map(|fill| label(fill)).collect();
    let ties = match (data.timings.noise, names.as_slice()) {
        (None, _) => Cell::absent("no identical work was measured twice"),
        (_, []) => Cell::name("none"),
        (_, names) => Cell {
            title: names.join("; "),
            ..Cell::name(some_of(names))
        },
    };
    // Of equal figures the recommended fill is named: it comes first.
    let cells = [
        winner(data, recommended),
        cell(Some(fastest)),
        ties,
        cell(least(std::iter::once(&recommended).chain(fills), bytes)),
        cell(least(std::iter::once(&recommended).chain(fills), error)),
    ];
    Some(Row::named(name, cells))
}

/// The answer for a terminal: of each view the fastest fill of each technique, the best first. Then the same of the
/// variants that full plans are compared with. Empty where none was timed.
#[must_use]
pub fn answer_text(run: &Run) -> String {
    let data = Data::new(run);
    let headings = ["fill", data.timings.unit(), "bytes", "wrong px", "÷ best"];
    let mut rows = vec![headings.map(str::to_owned)];
    for view in &data.views {
        let contest = Contest::new(&data, view);
        let fills = contest.fills.iter().copied();
        let (controls, fills): (Vec<&Case>, Vec<&Case>) = fills.partition(|case| is_control(case));
        for (fills, kind) in [(fills, ""), (controls, ", controls")] {
            let techniques = grouped(fills, |case| case.condition(TECHNIQUE));
            let fastest = techniques.iter().filter_map(|(_, fills)| fills.first());
            for (place, fill) in fastest.enumerate() {
                if place == 0 {
                    let mut title: [String; 5] = Default::default();
                    title[0] = view.title() + kind;
                    rows.push(title);
                }
                rows.push(terminal_row(&data, &contest, fill));
            }
        }
    }
    if rows.len() == 1 {
        return String::new();
    }
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths = [0, 1, 2, 3, 4].map(|column| width(column).unwrap_or(0));
    let line = |row: &[String; 5]| {
        let [fill, figures @ ..] = row;
        let mut line = format!("{fill:<0$}", widths[0]);
        for (figure, &width) in figures.iter().zip(&widths[1..]) {
            line += &format!("  {figure:>width$}");
        }
        line.trim_end().to_owned() + "\n"
    };
    rows.iter().map(line).collect()
}

/// Name, time with half its interval, bytes of geometry, wrong pixels, and time over the view's best.
fn terminal_row(data: &Data<'_>, contest: &Contest<'_, '_>, fill: &Case) -> [String; 5] {
    let time = data.timings.typical(fill).map(|time| {
        let half = time.interval.map(|[low, high]| 0.5 * (high - low));
        let half = half.map_or_else(String::new, |half| format!(" ± {}", significant(half)));
        format!("{}{half}", significant(time.middle))
    });
    [
        format!("  {}", elided(&label(fill), MAX_NAME)),
        or_dash(time),
        or_dash(fill.value(GEOMETRY_BYTES).map(measured_bytes)),
        or_dash(fill.value(MISMATCHED_PX).map(digits)),
        or_dash(contest.over_fastest(data, fill).map(significant)),
    ]
}

/// The fill with the least figure, of several the first.
fn least<'f, 'a: 'f, T: PartialOrd>(
    fills: impl IntoIterator<Item = &'f &'a Case>,
    of: impl Fn(&Case) -> Option<T>,
) -> Option<&'a Case> {
    let fills = fills.into_iter();
    let rated = fills.filter_map(|fill| Some((*fill, of(fill)?)));
    let least = rated.reduce(|least, next| if next.1 < least.1 { next } else { least });
    least.map(|(fill, _)| fill)
}

/// Distance of the drawn boundary from the reference's and mismatched pixels: less is more exact.
fn error(case: &Case) -> Option<[f64; 2]> {
    let px = case.value(MISMATCHED_PX)?;
    // Without a boundary in the picture there is no distance.
    Some([case.value(HAUSDORFF_PX).unwrap_or(0.0), px])
}

fn winner(data: &Data<'_>, case: &Case) -> Cell {
    let time = data.timings.typical(case).map(|time| figure(&time));
    let size = case.value(GEOMETRY_BYTES).map(measured_bytes);
    let moved = case.value(BOUNDARY_MOVED_PX);
    let moved = moved.filter(|px| *px > MAX_ROUNDED_PX);
    let moved = moved.map_or_else(String::new, |px| {
        format!(" ({} on purpose)", significant(px))
    });
    let off = case.value(HAUSDORFF_PX).map(significant);
    let off = off.map_or_else(
        || "no boundary in sight".to_owned(),
        |px| match px.as_str() {
            "0" => "boundary exact".to_owned(),
            px => format!("boundary off ≤ {px} px"),
        },
    );
    let cell = Cell {
        detail: format!(
            "{} ms · {} · {off}{moved}, {} pixels differ",
            or_dash(time),
            size.unwrap_or_else(|| "bytes unknown".to_owned()),
            or_dash(case.value(MISMATCHED_PX).map(digits)),
        ),
        ..data.name_cell(case, label(case))
    };
    dotted(cell, case, data.timings.metric)
}

/// What to take when, in words.
fn guide(data: &Data<'_>, contests: &[Contest<'_, '_>]) -> Vec<Block> {
    let by_kind = KINDS.iter().filter_map(|(kind, is_one)| {
        let own: Vec<&Contest<'_, '_>> = contests.iter().filter(|own| is_one(own)).collect();
        advised(data, kind, &own)
    });
    let lines: Vec<String> = by_kind.collect();
    if lines.is_empty() {
        Vec::new()
    } else {
        vec![Block::section("What to take"), Block::List(lines)]
    }
}

/// `kind → fill`, with what it costs beside the best and what ties with it.
fn advised(data: &Data<'_>, kind: &str, contests: &[&Contest<'_, '_>]) -> Option<String> {
    let ranked = ranked(data, contests);
    let best = ranked.first()?;
    let ties = tied(data, &ranked)[1..].iter();
    let ties: Vec<&str> = ties.map(|fill| fill.name.as_str()).collect();
    let ties = match ties.as_slice() {
        [] => String::new(),
        names => format!("; ties: {}", some_of(names)),
    };
    let views = match contests {
        [only] => only.view.title(),
        several => format!("{} views", several.len()),
    };
    Some(format!(
        "{kind} → {}: {views}, {} × the best of each on average, {} × at most{ties}.",
        best.name,
        significant(best.mean),
        significant(best.most),
    ))
}

/// Why a wrong picture of the case is no defect; empty where it is one.
fn excuse(case: &Case) -> &'static str {
    match case.outcome {
        _ if is_approximate(case) => "approximate by nature",
        _ if case.planned.may_be_wrong => "of sweeps, whose error is the question",
        Outcome::DriverFault => "with a known driver fault",
        _ => "",
    }
}

/// Which pictures were compared; `None` for a run that drew none.
fn scope(data: &Data<'_>) -> Option<String> {
    let drawn = data.cases.iter().filter(|case| !is_baseline(case));
    let excused = drawn.clone().filter(|case| !excuse(case).is_empty());
    let excused = grouped(excused, |case| excuse(case)).into_iter();
    let excused = excused.map(|(excuse, cases)| format!("{} {excuse}", count(cases.len() as u64)));
    let excused = match excused.collect::<Vec<_>>().join(", ").as_str() {
        "" => String::new(),
        some => format!(" ({some})"),
    };
    let compared = drawn.clone();
    let compared = compared.filter(|case| case.value(MISMATCHED_PX_OUTSIDE_BAND).is_some());
    let [all, compared] = [drawn.count(), compared.count()].map(|number| count(number as u64));
    (all != "0")
        .then(|| format!("{compared} of {all} pictures compared with the reference{excused}."))
}

fn requirements(data: &Data<'_>) -> Vec<Finding> {
    if data.cases.is_empty() {
        return Vec::new();
    }
    let mut requirements = vec![pictures(data)];
    requirements.extend(memory::requirement(data));
    requirements.extend(needs::requirement(data));
    requirements.extend(textured::requirements(data));
    requirements
}

/// No picture has a wrong pixel outside the band, those aside whose error is the question.
fn pictures(data: &Data<'_>) -> Finding {
    let own = data.cases.iter();
    let own = own.filter(|case| !case.planned.may_be_wrong && !is_baseline(case));
    let outside = own.filter_map(|case| Some((case, case.value(MISMATCHED_PX_OUTSIDE_BAND)?)));
    let wrong = outside.clone().filter(|(_, px)| *px > 0.0);
    let wrong: Vec<String> = wrong
        .map(|(case, px)| format!("{}: {px}", case.id()))
        .collect();
    let claim = "No picture has a wrong pixel outside the 1-pixel boundary band.";
    none_differs(claim, outside.count(), &wrong, "pictures have none")
}
