// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on data on a globe: sections as data, and what its figures say.

use crate::divided::FINE_PX;
use crate::metrics::*;
use terrafill_lab::{
    Cases, ClaimedTime, Column, Drawing, Figure, Names, Panel, Section, SectionedChapter, Select,
    StudyClaims, finding,
};
use terrafill_plot::Upwards;
use terrafill_plot::number::significant;
use terrafill_results::{Answers, Block, Case, Finding, Scope};

/// Times.
const TIME: Figure = Figure::ByClock(DECAL_GPU_MS, DECAL_CPU_MS);

/// What Gebbie and Bailey claim of decals and lines.
pub(crate) const CLAIMS: StudyClaims = StudyClaims {
    study: crate::STUDY,
    title: "The claims of Gebbie and Bailey on decals and lines",
    file: [
        "papers/gebbie-bailey.toml",
        include_str!("../../../../papers/gebbie-bailey.toml"),
    ],
    times: &[ClaimedTime {
        name: "draw",
        by: [DECAL_GPU_MS, DECAL_CPU_MS],
        needs: Scope::DRAW,
    }],
    metrics: &METRICS,
    findings: |cases| MAPS.found(cases),
    page: [""; 2],
};

/// Data on a globe.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: "Decals and lines on a globe",
    question: "How finely must data on a globe be divided, and which error is left?",
    text: "Gebbie and Bailey lay pictures of data over a globe as decals. A decal is a quad at the limits of longitude and \
           latitude. It is divided into cells, since projections bend it, and its vertices are about its lower left corner, \
           since f32 is too coarse from the body's centre. The vertex stage projects; a fragment is one look-up. Lines are \
           divided likewise. The body is a sphere, and data lies about the paper's campus unless a section says so. Texels \
           say their own address, so that each pixel of a device says which place of the data it shows. In f64 every \
           picture is held against its triangles as drawn, which must agree outside of the band of 1/32 pixel. It is also \
           held against the exact projection: a pixel's ray meets the body, and the place there has an address. Depth is \
           not tested, as in the paper, unless a section says so; what lies beyond the horizon is left out. The paper names \
           the rule of counted pixels, and no formula. Ours bounds the error of linear interpolation by the second \
           derivative over a cell's edges.",
    terms: TERMS,
    primary: TIME,
    answers,
    sections: &[DIVIDED, ORIGINS, ORDERS, MAPS, LINES, PLACES, TESTED],
    claims: Some(&CLAIMS),
};

/// Whether data is about the paper's campus.
fn is_usual(case: &Case) -> bool {
    case.condition(PLACE).is_empty()
}

/// Sections on the globe without its depth, of vertices about the corner by the full series.
fn is_plain(case: &Case, part: &str) -> bool {
    is_usual(case)
        && case.condition(PART) == part
        && case.condition(DEPTH).is_empty()
        && case.condition(ORIGIN) == "corner"
        && case.condition(SERIES) == "14"
}

const DIVIDED: Section<'static> = Section {
    title: "Decals by how finely they are divided",
    text: "Cells along a side are a fixed number, 1 or the paper's 10; or as many as the formula says. By counted pixels they \
           are twice as many in each frame, until precise occlusion queries of Vulkan count no more; that is the paper's own \
           rule. 320 and 448 are 32 × 32 decals side by side as vertices of one draw, of 10 × 10 cells each and of 14 × 14: \
           twice as many vertices.",
    cases: Select::Fitting(|case| is_plain(case, "decal") && case.condition(PROJECTION) == "globe"),
    named_by: Names::Columns(&[
        ("extent", EXTENT),
        ("view", VIEW),
        ("division", DIVISION),
        ("interface", API),
    ]),
    columns: &[
        Column::metric("cells", DECAL_CELLS),
        Column::metric("triangles", DECAL_TRIANGLES),
        Column::metric("sent once", DECAL_SENT_BYTES),
        Column::metric("sent a frame", DECAL_FRAME_BYTES),
        Column::of("draw, {unit}", TIME),
        Column::metric("px off, largest", DECAL_PX_MAX),
        Column::metric("of the side", DECAL_MAX_MIL),
        Column::metric("99 %", DECAL_PX_P99),
        Column::metric("median", DECAL_PX_MEDIAN),
        Column::metric("extra px", DECAL_EXTRA_PX),
        Column::metric("missing px", DECAL_MISSING_PX),
        Column::metric("px in the band", DECAL_BAND_PX),
        Column::metric("frames", DECAL_FRAMES),
        Column::metric("dividing, CPU ms", DECAL_DIVIDE_CPU_MS),
        Column::metric("counted, px", DECAL_COUNTED_PX),
    ],
    is_main: true,
    drawing: Some(Drawing {
        caption: "Error against triangles: a curve for each extent and view. A point to the left of ten cells whose error is \
                  below a quarter of a pixel says that ten were too many.",
        panels: &[Panel {
            across: ("triangles", Figure::Metric(DECAL_TRIANGLES)),
            up: ("largest error, px", Figure::Metric(DECAL_PX_MAX)),
            upwards: Upwards::Error,
            curve: Names::Joined(&[EXTENT, VIEW]),
            knob: Figure::Metric(DECAL_CELLS),
            label: Some(Names::Joined(&[DIVISION])),
            ..Panel::EMPTY
        }],
    }),
    findings: &[
        formula_is_fine,
        ten_are_enough,
        larger_need_more,
        counts_may_stop_early,
    ],
    pictures: &[("picture", "")],
    ..Section::EMPTY
};

/// The largest error by a rule, with where it is.
fn worst<'a>(cases: &Cases<'a>, division: &str) -> Option<(&'a Case, f64)> {
    let own = cases.with(&[(DIVISION, division)]);
    let all = own
        .iter()
        .filter_map(|case| Some((case, case.value(DECAL_PX_MAX)?)));
    all.max_by(|a, b| a.1.total_cmp(&b.1))
}

fn said((case, px): (&Case, f64)) -> String {
    format!("{} px at most, in {}", significant(px), case.id().name)
}

fn formula_is_fine(cases: &Cases<'_>) -> Finding {
    let found = worst(cases, "formula");
    finding(
        "By the formula no pixel is off by more than a quarter of a pixel:",
        found.map(|(_, px)| px <= FINE_PX),
        found.map_or_else(String::new, said),
    )
}

/// A pixel of the paper's window of 1000 × 1000, ‰ of its side: what is no problem. Claims of its file have the same.
const SEEN_MIL: f64 = 1.0;

fn ten_are_enough(cases: &Cases<'_>) -> Finding {
    let own = cases.fitting(|case| case.condition(EXTENT) != "continent");
    let most = own.with(&[(DIVISION, "10")]).greatest(DECAL_MAX_MIL);
    finding(
        "Gebbie & Bailey: 10 × 10 cells work without problems, up to a country",
        most.map(|most| most <= SEEN_MIL),
        most.map_or_else(String::new, |most| {
            format!("{} ‰ of the picture's side at most.", significant(most))
        }),
    )
}

fn larger_need_more(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(DIVISION, "10"), (EXTENT, "continent")]);
    let least = own.least(DECAL_MAX_MIL);
    finding(
        "Gebbie & Bailey: larger decals need more cells than 10 × 10, as a continent does in each view",
        least.map(|least| least > SEEN_MIL),
        least.map_or_else(String::new, |least| {
            format!(
                "Off by {} ‰ of the picture's side at least.",
                significant(least)
            )
        }),
    )
}

fn counts_may_stop_early(cases: &Cases<'_>) -> Finding {
    let found = worst(cases, "query");
    finding(
        "Gebbie & Bailey: where counted pixels increase no more, it is divided finely enough:",
        found.map(|(_, px)| px <= 1.0),
        found.map_or_else(String::new, said),
    )
}

const ORIGINS: Section<'static> = Section {
    title: "Vertices about the corner and about the centre",
    text: "The same 10 × 10 cells by the same series, their vertices as offsets from the corner, or as longitude and latitude \
           with places from the body's centre, in f32 throughout. A compute shader places the vertices of both by the same \
           functions, and they are read back; the centre's pictures are held against the triangles that it has.",
    cases: Select::Fitting(|case| {
        is_usual(case)
            && case.condition(PART) == "decal"
            && case.condition(DEPTH).is_empty()
            && case.condition(SERIES) == "14"
            && case.condition(DIVISION) == "10"
            && case.condition(PROJECTION) == "globe"
            && case.condition(API) == "wgpu"
    }),
    named_by: Names::Columns(&[("extent", EXTENT), ("view", VIEW), ("origin", ORIGIN)]),
    columns: &[
        Column::metric("vertices off, px", DECAL_VERTEX_PX),
        Column::metric("px off, largest", DECAL_PX_MAX),
        Column::metric("99 %", DECAL_PX_P99),
        Column::metric("median", DECAL_PX_MEDIAN),
        Column::of("draw, {unit}", TIME),
    ],
    findings: &[corner_is_finer],
    ..Section::EMPTY
};

/// What is asked of much more exact: the paper gives no number.
const MUCH: f64 = 10.0;

fn corner_is_finer(cases: &Cases<'_>) -> Finding {
    let near = cases.with(&[(VIEW, "close")]);
    let pairs = near.pairs(ORIGIN, ["centre", "corner"], &[]);
    let ratios = pairs.iter().filter_map(|pair| {
        let [centre, corner] = pair.map(|case| case.value(DECAL_VERTEX_PX));
        Some(centre? / corner?)
    });
    let least = ratios.min_by(f64::total_cmp);
    finding(
        "Where the eye is near, vertices about the corner are ten times as exact, or more",
        least.map(|ratio| ratio >= MUCH),
        least.map_or_else(String::new, |ratio| {
            format!(
                "About the centre they are off by {} × as much, or more.",
                significant(ratio)
            )
        }),
    )
}

const ORDERS: Section<'static> = Section {
    title: "Low orders of sine and cosine",
    text: "About the corner angles are small, so that the paper takes first or second order. Here 10 × 10 cells have sines \
           and cosines of first, second and fourteenth order. A low order puts the vertices themselves elsewhere: no \
           division mends it.",
    cases: Select::Fitting(|case| {
        case.condition(PART) == "decal"
            && case.condition(DEPTH).is_empty()
            && case.condition(ORIGIN) == "corner"
            && case.condition(DIVISION) == "10"
            && ["campus", "city"].contains(&case.condition(EXTENT))
            && case.condition(API) == "wgpu"
    }),
    named_by: Names::Columns(&[("extent", EXTENT), ("view", VIEW), ("order", SERIES)]),
    columns: &[
        Column::metric("px off, largest", DECAL_PX_MAX),
        Column::metric("of the side", DECAL_MAX_MIL),
        Column::metric("99 %", DECAL_PX_P99),
        Column::metric("median", DECAL_PX_MEDIAN),
    ],
    findings: &[second_order_is_enough],
    ..Section::EMPTY
};

fn second_order_is_enough(cases: &Cases<'_>) -> Finding {
    let of = |order| cases.with(&[(SERIES, order)]).greatest(DECAL_MAX_MIL);
    let pair = of("1").zip(of("2"));
    finding(
        "Second order is enough for a campus and a city, and first order is not",
        pair.map(|(first, second)| second <= SEEN_MIL && first > SEEN_MIL),
        pair.map_or_else(String::new, |(first, second)| {
            let [first, second] = [first, second].map(significant);
            format!("{first} ‰ of the picture's side at most by first order, {second} by second.")
        }),
    )
}

const MAPS: Section<'static> = Section {
    title: "Decals in other projections",
    text: "A continent's decal on a flat map, a hyperbolic one and a dome, whose vertices the same shader places. The \
           formula takes second derivatives of the map itself. Counted elsewhere, a decal is divided as its counts find it \
           obliquely, and drawn from above.",
    cases: Select::Fitting(|case| {
        is_usual(case) && case.condition(PART) == "decal" && case.condition(PROJECTION) != "globe"
    }),
    named_by: Names::Columns(&[
        ("projection", PROJECTION),
        ("view", VIEW),
        ("division", DIVISION),
        ("interface", API),
    ]),
    columns: &[
        Column::metric("cells", DECAL_CELLS),
        Column::metric("shown, px", DECAL_SHOWN_PX),
        Column::of("draw, {unit}", TIME),
        Column::metric("px off, largest", DECAL_PX_MAX),
        Column::metric("99 %", DECAL_PX_P99),
        Column::metric("missing px", DECAL_MISSING_PX),
        Column::metric("frames", DECAL_FRAMES),
    ],
    findings: &[
        formula_is_fine,
        some_get_smaller,
        counts_may_fail,
        counts_are_of_their_place,
    ],
    pictures: &[("picture", "")],
    ..Section::EMPTY
};

/// Maps and views that a decal may behave otherwise in.
const MAP_VIEWS: [(&str, &str); 6] = [
    ("flat", "nadir"),
    ("flat", "oblique"),
    ("hyperbolic", "nadir"),
    ("hyperbolic", "oblique"),
    ("dome", "nadir"),
    ("dome", "oblique"),
];

/// What some map shows: one case is enough for it, and only a run with every map is against it.
fn in_some_map(cases: &Cases<'_>, is_shown: Option<bool>) -> Option<bool> {
    let is_there = |(map, view)| !cases.with(&[(PROJECTION, map), (VIEW, view)]).is_empty();
    is_shown.filter(|is_shown| *is_shown || MAP_VIEWS.into_iter().all(is_there))
}

/// What is smaller: more than the band along the edges has.
const SMALLER: f64 = 0.01;

fn some_get_smaller(cases: &Cases<'_>) -> Finding {
    let pairs = cases.pairs(DIVISION, ["1", "10"], &[]);
    let ratios = pairs.iter().filter_map(|pair| {
        let [one, ten] = pair.map(|case| case.value(DECAL_SHOWN_PX));
        Some((pair[1], ten? / one?))
    });
    let least = ratios.min_by(|a, b| a.1.total_cmp(&b.1));
    finding(
        "Gebbie & Bailey: in some projection a decal gets smaller as it is divided",
        in_some_map(cases, least.map(|(_, ratio)| ratio <= 1.0 - SMALLER)),
        least.map_or_else(String::new, |(case, ratio)| {
            format!(
                "{} × the pixels of one cell, in {}.",
                significant(ratio),
                case.id().name
            )
        }),
    )
}

fn counts_may_fail(cases: &Cases<'_>) -> Finding {
    let found = worst(cases, "query");
    finding(
        "Gebbie & Bailey: in some projection counted pixels fail to divide enough",
        in_some_map(cases, found.map(|(_, px)| px > 1.0)),
        found.map_or_else(String::new, said),
    )
}

fn counts_are_of_their_place(cases: &Cases<'_>) -> Finding {
    let pairs = cases.pairs(DIVISION, ["elsewhere", "query"], &[]);
    let ratios = pairs.iter().filter_map(|pair| {
        let [there, here] = pair.map(|case| case.value(DECAL_PX_MAX));
        Some(there? / here?)
    });
    let most = ratios.max_by(f64::total_cmp);
    finding(
        "Gebbie & Bailey: in some projection what is counted elsewhere is less appropriate",
        in_some_map(cases, most.map(|ratio| ratio > 1.0)),
        most.map_or_else(String::new, |ratio| {
            format!(
                "{} × the error of what is counted in its own view, at most.",
                significant(ratio)
            )
        }),
    )
}

const LINES: Section<'static> = Section {
    title: "Lines",
    text: "Two pixels wide, along a great circle or a parallel, as one segment, ten, or by the rules. The error of a pixel is \
           its distance from the edge of the exact line at the part that it shows.",
    cases: Select::Fitting(|case| is_plain(case, "line")),
    named_by: Names::Columns(&[
        ("path", PATH),
        ("extent", EXTENT),
        ("view", VIEW),
        ("projection", PROJECTION),
        ("division", DIVISION),
        ("interface", API),
    ]),
    columns: &[
        Column::metric("segments", DECAL_CELLS),
        Column::metric("sent once", DECAL_SENT_BYTES),
        Column::of("draw, {unit}", TIME),
        Column::metric("px off, largest", DECAL_PX_MAX),
        Column::metric("99 %", DECAL_PX_P99),
        Column::metric("median", DECAL_PX_MEDIAN),
        Column::metric("frames", DECAL_FRAMES),
    ],
    findings: &[formula_is_fine, counts_may_stop_early],
    pictures: &[("picture", "")],
    ..Section::EMPTY
};

const PLACES: Section<'static> = Section {
    title: "At a pole and across ±180°",
    text: "The upper edge of a country's decal is the north pole, a point: there its cells end in triangles of no area. Its \
           sides are 115° of longitude apart, which is as wide in its middle as it is high. Other decals and lines cross \
           ±180°, where longitude jumps: rays find longitudes from −180° to 180°, and the data goes on beyond.",
    cases: Select::Fitting(|case| !is_usual(case)),
    named_by: Names::Columns(&[
        ("place", PLACE),
        ("data", PART),
        ("projection", PROJECTION),
        ("view", VIEW),
        ("origin", ORIGIN),
        ("division", DIVISION),
        ("interface", API),
    ]),
    columns: &[
        Column::metric("cells", DECAL_CELLS),
        Column::of("draw, {unit}", TIME),
        Column::metric("px off, largest", DECAL_PX_MAX),
        Column::metric("of the side", DECAL_MAX_MIL),
        Column::metric("99 %", DECAL_PX_P99),
        Column::metric("extra px", DECAL_EXTRA_PX),
        Column::metric("missing px", DECAL_MISSING_PX),
        Column::metric("px in the band", DECAL_BAND_PX),
        Column::metric("vertices off, px", DECAL_VERTEX_PX),
    ],
    findings: &[formula_is_fine, ten_are_enough_elsewhere],
    pictures: &[("picture", "")],
    ..Section::EMPTY
};

fn ten_are_enough_elsewhere(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(PART, "decal"), (PROJECTION, "globe"), (ORIGIN, "corner")]);
    let most = own.with(&[(DIVISION, "10")]).greatest(DECAL_MAX_MIL);
    finding(
        "10 × 10 cells work for a country at a pole and across ±180° too",
        most.map(|most| most <= SEEN_MIL),
        most.map_or_else(String::new, |most| {
            format!("{} ‰ of the picture's side at most.", significant(most))
        }),
    )
}

const TESTED: Section<'static> = Section {
    title: "What the body's depth hides",
    text: "The same over the body itself, which the same pass draws before it, and behind its depth, which fragments compute by \
           rays. Data is lifted by a thousandth of \
           the eye's height, whatever its division and the picture's size; the paper names no lift. What is hidden all the \
           same cuts through the body. Of a line seen obliquely, the half nearer to the eye may be hidden: it is two pixels \
           wide in the picture, and not on the ground.",
    cases: Select::With(DEPTH, "tested"),
    named_by: Names::Columns(&[
        ("data", PART),
        ("path", PATH),
        ("extent", EXTENT),
        ("view", VIEW),
        ("division", DIVISION),
        ("interface", API),
    ]),
    columns: &[
        Column::metric("cells", DECAL_CELLS),
        Column::metric("hidden", DECAL_HIDDEN_SHARE),
        Column::metric("px off, largest", DECAL_PX_MAX),
        Column::of("draw, {unit}", TIME),
        Column::metric("frames", DECAL_FRAMES),
        Column::metric("counted, px", DECAL_COUNTED_PX),
    ],
    findings: &[ten_are_seen, one_is_hidden],
    pictures: &[("picture", "")],
    ..Section::EMPTY
};

/// Of what is seen at all, what its own edges may hide of themselves. The claim that a quad cuts through has the same.
const HIDDEN_SHARE: f64 = 0.01;
/// What is asked of almost all: the paper gives no number, and its claim's test has the same.
const ALMOST_ALL: f64 = 0.9;

fn ten_are_seen(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(PART, "decal"), (DIVISION, "10")]);
    let most = own.greatest(DECAL_HIDDEN_SHARE);
    finding(
        "Decals of 10 × 10 cells stay before the body, lifted by a thousandth of the eye's height",
        most.map(|most| most <= HIDDEN_SHARE),
        most.map_or_else(String::new, |most| {
            format!(
                "{} % of the pixels are hidden at most.",
                significant(100.0 * most)
            )
        }),
    )
}

fn one_is_hidden(cases: &Cases<'_>) -> Finding {
    // Seen obliquely, half of a line's width stands before ground that is farther: as many pixels at any size.
    let own = cases.with(&[(PART, "line"), (DIVISION, "1"), (VIEW, "nadir")]);
    let least = own.least(DECAL_HIDDEN_SHARE);
    finding(
        "Gebbie & Bailey: undivided lines seen from above almost entirely disappear in the body",
        least.map(|least| least >= ALMOST_ALL),
        least.map_or_else(String::new, |least| {
            format!(
                "{} % of the pixels are hidden at least.",
                significant(100.0 * least)
            )
        }),
    )
}

/// Rules of division, as an answer names them.
const RULES: [(&str, &str); 4] = [
    ("1", "One cell"),
    ("10", "10 × 10"),
    ("formula", "by the formula"),
    ("query", "by counted pixels"),
];

/// Which error is left by each rule, and with how many cells.
///
/// - `cases`: of one extent
fn answer(extent: &str, cases: &Cases<'_>) -> Option<String> {
    let rules = RULES.iter().filter_map(|(division, rule)| {
        let own = cases.with(&[(DIVISION, division)]);
        let [px, cells] = [DECAL_PX_MAX, DECAL_CELLS].map(|metric| own.greatest(metric));
        let cells = cells.filter(|_| ["formula", "query"].contains(division));
        let cells = cells.map_or_else(String::new, |cells| {
            format!(", at most {cells} cells a side")
        });
        Some(format!("{rule}{cells}: {} px", significant(px?)))
    });
    let rules: Vec<String> = rules.collect();
    let first = cases.iter().next()?;
    (!rules.is_empty()).then(|| {
        format!(
            "A decal of a {extent} is off by at most, in {} views of {} px. {}.",
            cases.by(VIEW).len(),
            first.condition(SIZE_PX),
            rules.join("; ")
        )
    })
}

fn answers(cases: &Cases<'_>) -> Answers {
    let decals = cases.fitting(|case| is_plain(case, "decal"));
    let decals = decals.with(&[(PROJECTION, "globe")]).by(EXTENT);
    let sentences = decals
        .iter()
        .filter_map(|(extent, own)| answer(extent, own));
    let sentences: Vec<String> = sentences.collect();
    let wrong: Vec<f64> = cases.values(DECAL_MISMATCHED_PX);
    let miscounted = cases.fitting(|case| case.condition(PART) == "decal");
    let miscounted = miscounted.fitting(|case| case.condition(VIEW) != "limb");
    let miscounted = miscounted.values(DECAL_MISCOUNTED_PX);
    let none = |claim: &str, of: &[f64], what: &str| {
        let most = of.iter().copied().max_by(f64::total_cmp);
        let because = most.map(|most| format!("at most {most} {what} in {} pictures", of.len()));
        finding(
            claim,
            most.map(|most| most <= 0.0),
            because.unwrap_or_default(),
        )
    };
    Answers {
        requirements: vec![
            none(
                "No pixel shows another texel than the triangles as drawn allow:",
                &wrong,
                "pixels",
            ),
            none(
                "Counted pixels of decals are those of the picture:",
                &miscounted,
                "pixels",
            ),
            formula_is_fine(&cases.fitting(|case| {
                is_plain(case, "decal") || is_plain(case, "line") || !is_usual(case)
            })),
        ],
        blocks: Vec::from_iter((!sentences.is_empty()).then_some(Block::List(sentences))),
        ..Answers::default()
    }
}

#[cfg(test)]
mod tests;
