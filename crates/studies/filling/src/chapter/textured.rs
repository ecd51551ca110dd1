// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured fill: what a picture costs beside the plain fill of the same processes, how far its texels
//! are from where they should be, and what it looks like beside the reference.
//!
//! Cozzi (2007) named the two arctangents of the texture coordinates as what textured fill loses most
//! on. Findings are compared with the measured interval; nothing here knows what came out.

use super::comparisons::row_of_ratios;
use super::data::{
    DEPTH_PASS, Data, Timed, counter, grouped, layout_name, name, one_change, switches, title,
};
use super::scenes::picture;
use super::table::Show::{Bytes, Count, Figure, Over, Own, Status};
use super::table::{
    Column, NO_TEXELS, head, main_table, or_dash, part, plain_figures, sentences, table,
};
use crate::keys::*;
use terrafill_lab::{Comparison, Follows, finding};
use terrafill_plot::dotted;
use terrafill_plot::number::{count, significant, spread};
use terrafill_results::{
    Block, Case, Cell, Claim, ConditionKey, Finding, Outcome, PictureFigure, Pictures, Table, ratio,
};

/// Switches that a plain fill of the same layout has not.
const TEXTURE_KEYS: [ConditionKey; 4] = [NORMALIZE, PICTURE, POSITION, TEXTURE];

/// What they are in a textured fill that names none; a run records every switch.
const TEXTURE_DEFAULTS: [(ConditionKey, &str); 3] = [
    (NORMALIZE, "needed"),
    (PICTURE, "scene"),
    (POSITION, "eye-region"),
];

/// How many times the plain fill a textured one may take.
const MAX_OVER_PLAIN: f64 = 1.3;

/// The view for which that is asked.
const TOP_DOWN: &str = "top-down";

/// Texture switches that are not as usual, `key=value`, sorted; empty for the plain fill.
type TextureSwitches = &'static str;

/// What is compared: heading; whose time is divided; by whose; what of the two may differ.
pub(super) type Compared = (
    &'static str,
    TextureSwitches,
    TextureSwitches,
    Comparison<'static>,
);

/// Two pictures.
const PICTURES: Comparison<'static> = one_change(PICTURE);

/// Two routes to a texel.
const ROUTES: Comparison<'static> = one_change(TEXTURE);

/// Two routes of which one starts from another position.
const STARTS: Comparison<'static> = Comparison {
    follows: &[Follows {
        key: POSITION.name(),
        because: "where the route starts is part of it",
    }],
    ..ROUTES
};

/// A textured fill and the plain one of its layout.
const OVER_PLAIN: Comparison<'static> = Comparison {
    follows: &[
        Follows {
            key: POSITION.name(),
            because: "a plain fill looks for none",
        },
        Follows {
            key: NORMALIZE.name(),
            because: "it has none to normalise",
        },
        Follows {
            key: PICTURE.name(),
            because: "it shows none",
        },
    ],
    ..ROUTES
};

const PLAIN: TextureSwitches = "";
const CHOSEN: TextureSwitches = "texture=chosen";
const NATIVE: TextureSwitches = "texture=atan2-native+bowring-1";
/// What any textured fill must pay that looks at depth.
const FLOOR: TextureSwitches = "texture=floor";

/// The document's fill as it was.
const AS_IN_2007: TextureSwitches =
    "normalize=superfluous,position=inverse-ecef,texture=atan2-native+geocentric";
const EACH_2007: TextureSwitches =
    "normalize=superfluous,picture=each,position=inverse-ecef,texture=atan2-native+geocentric";
const SMALL_2007: TextureSwitches =
    "normalize=superfluous,picture=32,position=inverse-ecef,texture=atan2-native+geocentric";
/// The same without the normalisation that nothing needs.
const ATAN: TextureSwitches = "position=inverse-ecef,texture=atan2-native+geocentric";
const TABLE: TextureSwitches = "position=inverse-ecef,texture=lut-256-r16-linear+geocentric";
const SERIES: TextureSwitches = "position=inverse-ecef,texture=odd-7+geocentric";
const CUBE: TextureSwitches = "position=inverse-ecef,texture=cube-512";

/// Barycentric coordinates in a flat mesh, from the region's own offset.
const BARYCENTRIC: TextureSwitches = "texture=barycentric";

const NAMES: [(TextureSwitches, &str); 12] = [
    (PLAIN, "plain fill"),
    (CHOSEN, "chosen route"),
    (NATIVE, "native atan2"),
    (FLOOR, "least textured fill"),
    (AS_IN_2007, "as in 2007"),
    (EACH_2007, "as in 2007, a picture each"),
    (SMALL_2007, "as in 2007, picture of 32²"),
    (ATAN, "2007, native atan2"),
    (TABLE, "2007, 1D texture"),
    (SERIES, "2007, series"),
    (CUBE, "2007, texture of spherical coordinates"),
    (BARYCENTRIC, "barycentric coordinates"),
];

/// Of each view with both: its title, and the largest texel error by angles about the body's centre in f32
/// and by barycentric coordinates.
pub(super) fn flat_mesh_errors(data: &Data<'_>) -> Vec<(String, [f64; 2])> {
    let of = |view: TexturedView<'_>| {
        let worst = |wanted| view.case(wanted)?.value(TEXEL_MAX);
        let errors = [worst(NATIVE)?, worst(BARYCENTRIC)?];
        Some((view.title, errors))
    };
    views(data).into_iter().filter_map(of).collect()
}

/// The document's fill beside the plain one.
pub(super) const AS_IN_2007_OVER_PLAIN: &str = "as in 2007 ÷ plain";

const OVER_CUBE: &str = "2007, native atan2 ÷ texture of spherical coordinates";
const CHOSEN_OVER_PLAIN: &str = "chosen route ÷ plain";
const LEAST_OVER_PLAIN: &str = "least textured fill ÷ plain";
const CHOSEN_OVER_LEAST: &str = "chosen route ÷ least";

/// The document's comparisons.
pub(super) const COMPARISONS: [Compared; 13] = [
    (AS_IN_2007_OVER_PLAIN, AS_IN_2007, PLAIN, OVER_PLAIN),
    (CHOSEN_OVER_PLAIN, CHOSEN, PLAIN, OVER_PLAIN),
    (LEAST_OVER_PLAIN, FLOOR, PLAIN, OVER_PLAIN),
    (CHOSEN_OVER_LEAST, CHOSEN, FLOOR, ROUTES),
    ("native atan2 ÷ chosen route", NATIVE, CHOSEN, ROUTES),
    (
        "as in 2007, a picture each ÷ one for all",
        EACH_2007,
        AS_IN_2007,
        PICTURES,
    ),
    (
        "as in 2007, picture of the scene ÷ of 32²",
        AS_IN_2007,
        SMALL_2007,
        PICTURES,
    ),
    (
        "as in 2007 ÷ without the superfluous normalize",
        AS_IN_2007,
        ATAN,
        one_change(NORMALIZE),
    ),
    ("2007, native atan2 ÷ 1D texture", ATAN, TABLE, ROUTES),
    ("2007, native atan2 ÷ series", ATAN, SERIES, ROUTES),
    (OVER_CUBE, ATAN, CUBE, ROUTES),
    (
        "2007, native atan2 ÷ the two reads alone",
        ATAN,
        FLOOR,
        STARTS,
    ),
    (
        "2007, native atan2 ÷ barycentric coordinates",
        ATAN,
        BARYCENTRIC,
        STARTS,
    ),
];

/// A sentence, the heading of the comparison that speaks of it, what it claims, and the one view that it is about;
/// all without.
type TextureClaim = (&'static str, &'static str, Claim, Option<&'static str>);

/// What this project requires of itself.
const GOAL: TextureClaim = (
    "This project's goal: by the chosen route, less than 1.3 times the plain fill.",
    CHOSEN_OVER_PLAIN,
    Claim::LessThan(MAX_OVER_PLAIN),
    Some(TOP_DOWN),
);

const CLAIMS: [TextureClaim; 5] = [
    (
        "Cozzi (2007), observed: “two atan() calls which are very expensive”.",
        OVER_CUBE,
        Claim::Faster,
        None,
    ),
    (
        "Cozzi (2007), anticipated: without them “the performance could double”.",
        OVER_CUBE,
        Claim::AtLeast(2.0),
        None,
    ),
    GOAL,
    (
        "Whether this device can reach it: the least textured fill takes less than 1.3 times the plain one.",
        LEAST_OVER_PLAIN,
        Claim::LessThan(MAX_OVER_PLAIN),
        Some(TOP_DOWN),
    ),
    (
        "By the chosen route, less than 1.3 times the least textured fill.",
        CHOSEN_OVER_LEAST,
        Claim::LessThan(MAX_OVER_PLAIN),
        None,
    ),
];

const COLUMNS: [Column; 10] = [
    ("fill", Own("")),
    ("status", Status),
    ("fill, {unit}", Own("")),
    ("÷\u{a0}depth-pass", Over(DEPTH_PASS)),
    ("÷\u{a0}plain", Own("")),
    ("texels, RMS", Figure(TEXEL_RMS)),
    ("texels, largest", Figure(TEXEL_MAX)),
    ("non-finite", Count(TEXEL_NON_FINITE)),
    ("px compared", Count(TEXEL_COMPARED_PX)),
    ("texture bytes", Bytes(TEXTURE_BYTES)),
];

/// What is required of textured fills; nothing for a run that plans none.
pub(super) fn requirements(data: &Data<'_>) -> Vec<Finding> {
    match views(data).is_empty() {
        true => Vec::new(),
        false => findings(data, &GOAL),
    }
}

/// Whether the case is a textured fill.
pub(super) fn is_textured(case: &Case) -> bool {
    !["", "none", "plain"].contains(&case.condition(TEXTURE))
}

/// A view with textured fills.
struct TexturedView<'a> {
    title: String,
    /// Textured fills and the plain ones that they are compared with.
    cases: Vec<&'a Case>,
}

impl<'a> TexturedView<'a> {
    /// The first technique's case with these texture switches.
    fn case(&self, wanted: TextureSwitches) -> Option<&'a Case> {
        let found = |case: &&&Case| texture_set(case) == wanted;
        self.cases.iter().find(found).copied()
    }

    /// The two cases of a comparison, where both may be compared.
    fn pair(&self, data: &Data<'a>, (_, case, control, _): &Compared) -> Option<[&'a Case; 2]> {
        let case = self.case(case)?;
        // The plain fill of the same technique and layout, not the first one there is.
        let control = match *control {
            PLAIN => plain_of(data, case)?,
            wanted => self.case(wanted)?,
        };
        let both = [case, control];
        both.into_iter().all(may_be_compared).then_some(both)
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
             in particular; its texels have no error.",
            data.run.clock().name()
        ),
    );
    blocks.extend(ratios(data, &views));
    for claim in &CLAIMS {
        blocks.extend(findings(data, claim).into_iter().map(Block::Finding));
    }
    blocks.extend(Block::folded_list(
        "Not measured",
        not_measured(data, &views),
    ));
    for view in &views {
        blocks.push(part(format!("Textured: {}", view.title)));
        blocks.push(Block::Table(fills(data, view)));
    }
    let figures: Vec<PictureFigure> = views.iter().filter_map(figure).collect();
    blocks.extend((!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            caption: "A part of the image round the middle of what is filled, a pixel for a pixel: \
                      reference, technique, and ten times their difference where both fill with the \
                      same region. What is not filled is one colour in the reference and shaded surface \
                      in the technique's."
                .to_owned(),
            figures,
            ..Pictures::default()
        })
    }));
    blocks
}

fn views<'a>(data: &Data<'a>) -> Vec<TexturedView<'a>> {
    let textured = data.cases.iter().copied().filter(|case| is_textured(case));
    let view = |(title, own): (String, Vec<&'a Case>)| {
        let mut cases: Vec<&Case> = Vec::new();
        for case in own {
            for case in plain_of(data, case).into_iter().chain([case]) {
                if !cases.iter().any(|known| known.id() == case.id()) {
                    cases.push(case);
                }
            }
        }
        TexturedView { title, cases }
    };
    let views = grouped(textured, |case| title(case)).into_iter();
    views.map(view).collect()
}

/// Switches that make the fill a textured one and are not as usual, by name; none of a plain fill.
fn texture_switches(case: &Case) -> Vec<(ConditionKey, &str)> {
    if !is_textured(case) {
        return Vec::new();
    }
    let own = TEXTURE_KEYS.map(|key| (key, case.condition(key)));
    let own = own.into_iter().filter(|(_, value)| !value.is_empty());
    own.filter(|switch| !TEXTURE_DEFAULTS.contains(switch))
        .collect()
}

/// The same in one text.
fn texture_set(case: &Case) -> String {
    let set = texture_switches(case).into_iter();
    let set = set.map(|(key, value)| format!("{}={value}", key.name()));
    set.collect::<Vec<_>>().join(",")
}

/// The same fill without a picture.
fn plain_of<'a>(data: &Data<'a>, case: &Case) -> Option<&'a Case> {
    let is_other = |(key, _): &(&str, &str)| TEXTURE_KEYS.iter().all(|own| own.name() != *key);
    let others = switches(case).into_iter().filter(is_other);
    let others: Vec<(&str, &str)> = others.collect();
    let mut cases = data.beside(case).iter().copied();
    cases.find(|other| {
        !is_textured(other)
            && layout_name(other) == layout_name(case)
            && switches(other)
                .into_iter()
                .filter(is_other)
                .eq(others.iter().copied())
    })
}

/// Right, or a fill of the document, whose error is part of the answer.
fn may_be_compared(case: &Case) -> bool {
    case.counts() || case.planned.may_be_wrong && case.outcome == Outcome::Wrong
}

/// The comparison with this heading in every view that has it.
///
/// # Panics
/// Where there is none of that name.
pub(super) fn compared<'a>(data: &Data<'a>, heading: &str) -> Vec<Timed<'a>> {
    let mut comparisons = COMPARISONS.iter();
    let Some(comparison) = comparisons.find(|comparison| comparison.0 == heading) else {
        panic!("no comparison of textured fills is called {heading:?}");
    };
    let of = |view: TexturedView<'a>| {
        Some(Timed {
            cases: view.pair(data, comparison)?,
            title: view.title,
            pairing: comparison.3,
        })
    };
    views(data).into_iter().filter_map(of).collect()
}

/// Keys of the cases of a comparison without an interval: too few processes have measured it.
pub(super) fn undecided(data: &Data<'_>) -> Vec<String> {
    let views = views(data);
    let pairs = views
        .iter()
        .flat_map(|view| COMPARISONS.iter().filter_map(move |of| view.pair(data, of)));
    let is_open = |[case, control]: &[&Case; 2]| {
        ratio(case, control, data.metric).is_some_and(|ratio| ratio.interval.is_none())
    };
    let open = pairs.filter(is_open).flatten();
    open.map(|case| case.id().key()).collect()
}

/// View by view, a cell for each comparison.
fn ratios(data: &Data<'_>, views: &[TexturedView<'_>]) -> Option<Block> {
    let rows = views.iter().filter_map(|view| {
        let ratios = COMPARISONS.map(|of| {
            let [case, control] = view.pair(data, &of)?;
            ratio(case, control, data.metric)
        });
        row_of_ratios(data, view.title.clone(), &ratios)
    });
    let headings = [&["view"][..], &COMPARISONS.map(|of| of.0)[..]].concat();
    main_table(plain_figures(&headings, rows.collect()))
}

/// One for each view with such times.
fn findings(data: &Data<'_>, (sentence, comparison, claim, view): &TextureClaim) -> Vec<Finding> {
    let of_view = |timed: &Timed<'_>| {
        let own = timed.cases[0].condition(VIEW);
        view.is_none_or(|wanted| wanted == own)
    };
    let found = compared(data, comparison).into_iter().filter(of_view);
    let found = found.filter_map(|timed| {
        let answer = timed.answer(data, *claim);
        let ratio = data.ratio_text(answer.figure.as_ref()?);
        Some(Finding {
            claim: (*sentence).to_owned(),
            standing: answer.standing,
            because: sentences([format!("{}: {ratio}", timed.title), answer.because]),
        })
    });
    let found: Vec<Finding> = found.collect();
    match found.is_empty() {
        true => vec![finding(*sentence, None, "")],
        false => found,
    }
}

fn fills(data: &Data<'_>, view: &TexturedView<'_>) -> Table {
    let rows = view.cases.iter().map(|case| {
        let case = *case;
        let plain = plain_of(data, case).filter(|_| is_textured(case) && may_be_compared(case));
        let over_plain = plain.and_then(|plain| ratio(case, plain, data.metric));
        let why = match case.reason.as_str() {
            "" if is_textured(case) => "not measured",
            "" => NO_TEXELS,
            reason => reason,
        };
        let time = data.time(case).filter(|_| may_be_compared(case));
        let time = Cell::or_absent(time.map(spread), why);
        let label = Cell {
            detail: name(case),
            ..Cell::name(label(case))
        };
        let own = vec![
            label,
            dotted(time, case, data.metric),
            data.ratio_cell(over_plain.as_ref(), why),
        ];
        (case, own)
    });
    let mut table = table(data, &COLUMNS, rows);
    for (row, case) in table.rows.iter_mut().zip(&view.cases) {
        row.remark = match is_textured(case) {
            true => sentences([case.note("texture_route"), case.reason.as_str()]),
            false => String::new(),
        };
    }
    table
}

/// What a case is, in words where it has some.
pub(super) fn label(case: &Case) -> String {
    let set = texture_set(case);
    let named = NAMES.iter().find(|(own, _)| *own == set);
    named.map_or(set.clone(), |(_, words)| (*words).to_owned())
}

/// What no row tells: right fills whose texels were not compared, and views without a time.
fn not_measured(data: &Data<'_>, views: &[TexturedView<'_>]) -> Vec<String> {
    let mut lines = Vec::new();
    for view in views {
        let right = view.cases.iter().filter(|case| case.outcome == Outcome::Ok);
        let uncompared = right.filter(|case| {
            let has_place = is_textured(case) && texture_set(case) != FLOOR;
            has_place && counter(case, TEXEL_COMPARED_PX).unwrap_or(0) == 0
        });
        lines.extend(
            uncompared
                .map(|case| format!("{}: its texture coordinates were not compared", case.id())),
        );
        if view.cases.iter().all(|case| data.time(case).is_none()) {
            lines.push(format!("{}: drawn and compared, not timed", view.title));
        }
    }
    lines
}

/// The pictures of the view's first case that has them.
fn figure(view: &TexturedView<'_>) -> Option<PictureFigure> {
    let mut textured = view.cases.iter().filter(|case| is_textured(case));
    let case = textured.find(|case| case.value(COLOUR_MAX).is_some())?;
    let figure = |metric| or_dash(case.value(metric).map(significant));
    let pictures = [
        picture(case, "reference_image", "reference"),
        picture(case, "image", "technique"),
        picture(case, "difference_image", "difference × 10"),
    ];
    let wrong = match case.outcome {
        Outcome::Ok => "",
        _ => " (wrong)",
    };
    Some(PictureFigure {
        pictures: pictures.into_iter().flatten().collect(),
        notes: vec![format!(
            "{}, {}{wrong}: {} texels RMS, {} at most; colours differ by {} of 255 on average, {} at most",
            view.title,
            name(case),
            figure(TEXEL_RMS),
            figure(TEXEL_MAX),
            figure(COLOUR_MEAN),
            or_dash(counter(case, COLOUR_MAX).map(count)),
        )],
    })
}
