// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textured fill: what a picture costs beside the plain fill of the same processes, how far its texels
//! are from where they should be, and what it looks like beside the reference.
//!
//! Cozzi (2007) named the two arctangents of the texture coordinates as what textured fill loses most
//! on. Findings are compared with the measured interval; nothing here knows what came out.

use super::data::{
    DEPTH_PASS, Data, Pairing, Timed, counter, distinct, is_same, name, switches, title,
};
use crate::keys::{
    COLOUR_MAX, COLOUR_MEAN, LAYOUT, NORMALIZE, PICTURE, POSITION, SCENE, TECHNIQUE,
    TEXEL_COMPARED_PX, TEXEL_MAX, TEXEL_NON_FINITE, TEXEL_RMS, TEXTURE, TEXTURE_BYTES, VIEW,
};
use terrafill_lab::Follows;
use terrafill_plot::dotted;
use terrafill_plot::number::{bytes, count, significant, spread};
use terrafill_results::{
    Block, Case, Cell, Claim, ConditionKey, Estimate, Finding, Heading, Outcome, Picture,
    PictureFigure, Pictures, Row, Standing, Table, ratio,
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

type TextureSwitches = &'static [(ConditionKey, &'static str)];

/// What is compared: time of the one over time of the other, by their texture switches, sorted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Comparison {
    heading: &'static str,
    pub(super) case: TextureSwitches,
    /// Empty: the plain fill.
    pub(super) control: TextureSwitches,
    /// What of the two may differ.
    pairing: Pairing,
}

const fn one_change(changed: ConditionKey) -> Pairing {
    Pairing {
        changed,
        follows: &[],
        one_sided: None,
    }
}

/// Two routes to a texel.
const ROUTES: Pairing = one_change(TEXTURE);

/// Two routes of which one starts from another position.
const STARTS: Pairing = Pairing {
    follows: &[Follows {
        key: POSITION.name(),
        because: "where the route starts is part of it",
    }],
    ..ROUTES
};

/// A textured fill and the plain one of its layout.
const OVER_PLAIN: Pairing = Pairing {
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

const CHOSEN: TextureSwitches = &[(TEXTURE, "chosen")];
const NATIVE: TextureSwitches = &[(TEXTURE, "atan2-native+bowring-1")];
/// What any textured fill must pay that looks at depth.
const FLOOR: TextureSwitches = &[(TEXTURE, "floor")];

/// The document's fill as it was.
const AS_IN_2007: TextureSwitches = &[
    (NORMALIZE, "superfluous"),
    (POSITION, "inverse-ecef"),
    (TEXTURE, "atan2-native+geocentric"),
];
/// The same without the normalisation that nothing needs.
const ATAN_2007: TextureSwitches = &[
    (POSITION, "inverse-ecef"),
    (TEXTURE, "atan2-native+geocentric"),
];

/// Barycentric coordinates in a flat mesh, from the region's own offset.
const BARYCENTRIC: TextureSwitches = &[(TEXTURE, "barycentric")];

/// Of each view with both: its title, and the largest texel error by angles about the body's centre in f32
/// and by barycentric coordinates.
pub(super) fn flat_mesh_errors(data: &Data<'_>) -> Vec<(String, [f64; 2])> {
    let of = |view: &TexturedView<'_>| {
        let worst = |wanted| view.case(wanted)?.value(TEXEL_MAX);
        Some((view.title.clone(), [worst(NATIVE)?, worst(BARYCENTRIC)?]))
    };
    views(data).iter().filter_map(of).collect()
}

/// The document's fill beside the plain one.
pub(super) const AS_IN_2007_OVER_PLAIN: &str = "as in 2007 ÷ plain";

/// The document's comparisons.
pub(super) const COMPARISONS: [Comparison; 13] = [
    Comparison {
        heading: AS_IN_2007_OVER_PLAIN,
        case: AS_IN_2007,
        control: &[],
        pairing: OVER_PLAIN,
    },
    Comparison {
        heading: "chosen route ÷ plain",
        case: CHOSEN,
        control: &[],
        pairing: OVER_PLAIN,
    },
    Comparison {
        heading: "least textured fill ÷ plain",
        case: FLOOR,
        control: &[],
        pairing: OVER_PLAIN,
    },
    Comparison {
        heading: "chosen route ÷ least",
        case: CHOSEN,
        control: FLOOR,
        pairing: ROUTES,
    },
    Comparison {
        heading: "native atan2 ÷ chosen route",
        case: NATIVE,
        control: CHOSEN,
        pairing: ROUTES,
    },
    Comparison {
        heading: "as in 2007, a picture each ÷ one for all",
        case: &[
            (NORMALIZE, "superfluous"),
            (PICTURE, "each"),
            (POSITION, "inverse-ecef"),
            (TEXTURE, "atan2-native+geocentric"),
        ],
        control: AS_IN_2007,
        pairing: one_change(PICTURE),
    },
    Comparison {
        heading: "as in 2007, picture of the scene ÷ of 32²",
        case: AS_IN_2007,
        control: &[
            (NORMALIZE, "superfluous"),
            (PICTURE, "32"),
            (POSITION, "inverse-ecef"),
            (TEXTURE, "atan2-native+geocentric"),
        ],
        pairing: one_change(PICTURE),
    },
    Comparison {
        heading: "as in 2007 ÷ without the superfluous normalize",
        case: AS_IN_2007,
        control: ATAN_2007,
        pairing: one_change(NORMALIZE),
    },
    Comparison {
        heading: "2007, native atan2 ÷ 1D texture",
        case: ATAN_2007,
        control: &[
            (POSITION, "inverse-ecef"),
            (TEXTURE, "lut-256-r16-linear+geocentric"),
        ],
        pairing: ROUTES,
    },
    Comparison {
        heading: "2007, native atan2 ÷ series",
        case: ATAN_2007,
        control: &[(POSITION, "inverse-ecef"), (TEXTURE, "odd-7+geocentric")],
        pairing: ROUTES,
    },
    Comparison {
        heading: "2007, native atan2 ÷ texture of spherical coordinates",
        case: ATAN_2007,
        control: &[(POSITION, "inverse-ecef"), (TEXTURE, "cube-512")],
        pairing: ROUTES,
    },
    Comparison {
        heading: "2007, native atan2 ÷ the two reads alone",
        case: ATAN_2007,
        control: FLOOR,
        pairing: STARTS,
    },
    Comparison {
        heading: "2007, native atan2 ÷ barycentric coordinates",
        case: ATAN_2007,
        control: BARYCENTRIC,
        pairing: STARTS,
    },
];

/// A sentence, the comparison that speaks of it, and what it claims.
struct TextureClaim {
    sentence: &'static str,
    /// By its heading.
    comparison: &'static str,
    claim: Claim,
    /// The one view that it is about; all without.
    view: Option<&'static str>,
}

const CLAIMS: [TextureClaim; 5] = [
    TextureClaim {
        sentence: "Cozzi (2007), observed: “two atan() calls which are very expensive”.",
        comparison: "2007, native atan2 ÷ texture of spherical coordinates",
        claim: Claim::Faster,
        view: None,
    },
    TextureClaim {
        sentence: "Cozzi (2007), anticipated: without them “the performance could double”.",
        comparison: "2007, native atan2 ÷ texture of spherical coordinates",
        claim: Claim::AtLeast(2.0),
        view: None,
    },
    TextureClaim {
        sentence: "This project's goal: by the chosen route, less than 1.3 times the plain fill.",
        comparison: "chosen route ÷ plain",
        claim: Claim::LessThan(MAX_OVER_PLAIN),
        view: Some(TOP_DOWN),
    },
    TextureClaim {
        sentence: "Whether this device can reach it: the least textured fill takes less than 1.3 times \
                   the plain one.",
        comparison: "least textured fill ÷ plain",
        claim: Claim::LessThan(MAX_OVER_PLAIN),
        view: Some(TOP_DOWN),
    },
    TextureClaim {
        sentence: "By the chosen route, less than 1.3 times the least textured fill.",
        comparison: "chosen route ÷ least",
        claim: Claim::LessThan(MAX_OVER_PLAIN),
        view: None,
    },
];

/// The claim among [`CLAIMS`] that this project requires of itself.
const REQUIRED: usize = 2;

/// What is required of textured fills; nothing for a run that plans none.
pub(super) fn requirements(data: &Data<'_>) -> Vec<Finding> {
    match views(data).is_empty() {
        true => Vec::new(),
        false => findings(data, &CLAIMS[REQUIRED]),
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
        let found = |case: &&&Case| texture_switches(case) == wanted;
        self.cases.iter().find(found).copied()
    }
}

/// Nothing for a run that plans no textured fill.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let views = views(data);
    if views.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        Block::section("Textured fill"),
        Block::Text(format!(
            "Every fragment of a textured fill finds its longitude and latitude and from them its place \
             in a picture. Times are {}, beside the plain fill of the same layout in the same \
             processes; an interval is that of 95 %. The error of a fill is how far its texels lie from \
             the reference's, in texels, outside silhouettes: at most ¼ RMS and ½ anywhere, or the row \
             is wrong. The least textured fill is what every such fill must pay: the same stencil and \
             the same pixels, but a fragment only reads its depth and samples the picture once, nowhere \
             in particular; its texels have no error.",
            data.run.clock().name()
        )),
    ];
    blocks.splice(1..1, recommended(data, &views));
    blocks.extend(ratios(data, &views));
    for claim in &CLAIMS {
        blocks.extend(findings(data, claim).into_iter().map(Block::Finding));
    }
    blocks.extend(Block::folded_list(
        "Not measured",
        not_measured(data, &views),
    ));
    for view in &views {
        blocks.push(Block::Heading {
            level: 4,
            text: format!("Textured: {}", view.title),
        });
        blocks.push(Block::Table(table(data, view)));
    }
    let figures: Vec<PictureFigure> = views.iter().filter_map(figure).collect();
    if !figures.is_empty() {
        blocks.push(Block::Pictures(Pictures {
            caption: "A part of the image round the middle of what is filled, a pixel for a pixel: \
                      reference, technique, and ten times their difference where both fill with the \
                      same region. What is not filled is one colour in the reference and shaded surface \
                      in the technique's."
                .to_owned(),
            figures,
            ..Pictures::default()
        }));
    }
    blocks
}

/// What the recommended route costs and how exact it is, view by view.
fn recommended(data: &Data<'_>, views: &[TexturedView<'_>]) -> Option<Block> {
    let lines = views.iter().filter_map(|view| {
        let case = view.case(CHOSEN).filter(|case| case.counts())?;
        let over_plain = plain_of(data, case).and_then(|plain| data.over(case, plain));
        let cost = match (data.right_time(case), over_plain) {
            (Some(time), Some(ratio)) => format!(
                "{} ms, {} the plain fill",
                significant(time.median),
                data.ratio_text(&ratio)
            ),
            _ => "not timed".to_owned(),
        };
        let texels = |metric| {
            let value = case.value(metric).map(significant);
            value.unwrap_or_else(|| "–".to_owned())
        };
        let route = case.note("texture_route").split(';').next();
        Some(format!(
            "{}, by the recommended route ({}): {cost}; texels off by {} RMS and {} at most.",
            view.title,
            route.unwrap_or_default(),
            texels(TEXEL_RMS),
            texels(TEXEL_MAX),
        ))
    });
    let lines: Vec<String> = lines.collect();
    (!lines.is_empty()).then_some(Block::List(lines))
}

fn views<'a>(data: &Data<'a>) -> Vec<TexturedView<'a>> {
    let textured = || data.cases.iter().copied().filter(|case| is_textured(case));
    let titles = distinct(textured().map(title));
    let view = |of: String| {
        let own = textured().filter(|case| title(case) == of);
        let mut cases: Vec<&Case> = Vec::new();
        for case in own {
            for case in plain_of(data, case).into_iter().chain([case]) {
                if !cases.iter().any(|known| known.id() == case.id()) {
                    cases.push(case);
                }
            }
        }
        TexturedView { title: of, cases }
    };
    titles.into_iter().map(view).collect()
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

/// The same fill without a picture.
fn plain_of<'a>(data: &Data<'a>, case: &Case) -> Option<&'a Case> {
    let others = |of: &Case| -> Vec<(String, String)> {
        let own = switches(of).into_iter();
        let own = own.filter(|(key, _)| TEXTURE_KEYS.iter().all(|own| own.name() != *key));
        own.map(|(key, value)| (key.to_owned(), value.to_owned()))
            .collect()
    };
    let wanted = others(case);
    let same = [SCENE, VIEW, TECHNIQUE, LAYOUT];
    let is_plain = |other: &&&Case| {
        !is_textured(other) && is_same(other, case, &same) && others(other) == wanted
    };
    data.cases.iter().find(is_plain).copied()
}

fn compare(data: &Data<'_>, view: &TexturedView<'_>, comparison: &Comparison) -> Option<Estimate> {
    let [case, control] = both(data, view, comparison)?;
    ratio(case, control, data.metric)
}

/// The two cases of a comparison, where both may be compared.
fn both<'a>(
    data: &Data<'a>,
    view: &TexturedView<'a>,
    comparison: &Comparison,
) -> Option<[&'a Case; 2]> {
    let case = view.case(comparison.case)?;
    // The plain fill of the same technique and layout, not the first one there is.
    let control = match comparison.control {
        [] => plain_of(data, case)?,
        wanted => view.case(wanted)?,
    };
    let both = [case, control];
    both.into_iter().all(may_be_compared).then_some(both)
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
    let comparison = comparisons.find(|comparison| comparison.heading == heading);
    let Some(comparison) = comparison else {
        panic!("no comparison of textured fills is called {heading:?}");
    };
    let of = |view: TexturedView<'a>| {
        let cases = both(data, &view, comparison)?;
        Some(Timed {
            title: view.title,
            pairing: comparison.pairing,
            cases,
        })
    };
    views(data).into_iter().filter_map(of).collect()
}

/// Keys of the cases of a comparison without an interval: too few processes have measured it.
pub(super) fn undecided(data: &Data<'_>) -> Vec<String> {
    let views = views(data);
    let open = views.iter().flat_map(|view| {
        COMPARISONS.iter().filter_map(move |comparison| {
            let [case, control] = both(data, view, comparison)?;
            let ratio = ratio(case, control, data.metric)?;
            ratio.interval.is_none().then_some([case, control])
        })
    });
    open.flatten().map(|case| case.id().key()).collect()
}

/// View by view, a cell for each comparison.
fn ratios(data: &Data<'_>, views: &[TexturedView<'_>]) -> Option<Block> {
    let rows: Vec<Row> = views
        .iter()
        .filter_map(|view| {
            let ratios = COMPARISONS.map(|comparison| compare(data, view, &comparison));
            ratios.iter().any(Option::is_some).then(|| {
                let mut cells = vec![Cell::name(&view.title)];
                let why = "no case of one of the two, or it is not right";
                cells.extend(
                    ratios
                        .iter()
                        .map(|ratio| data.ratio_cell(ratio.as_ref(), why)),
                );
                Row::new(cells)
            })
        })
        .collect();
    let headings = COMPARISONS
        .iter()
        .map(|comparison| Heading::plain(comparison.heading));
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            headings: std::iter::once(Heading::plain("view"))
                .chain(headings)
                .collect(),
            rows,
            is_main: true,
            ..Table::default()
        })
    })
}

/// One for each view with such times.
fn findings(data: &Data<'_>, claim: &TextureClaim) -> Vec<Finding> {
    let mut findings = Vec::new();
    for timed in compared(data, claim.comparison) {
        let view = timed.cases[0].condition(VIEW);
        if claim.view.is_some_and(|wanted| wanted != view) {
            continue;
        }
        let answer = timed.answer(data, claim.claim);
        let Some(ratio) = &answer.figure else {
            continue;
        };
        let ours = format!("{}: {}", timed.title, data.ratio_text(ratio));
        findings.push(Finding {
            claim: claim.sentence.to_owned(),
            standing: answer.standing,
            because: match answer.because.as_str() {
                "" => ours,
                because => format!("{ours}. {because}"),
            },
        });
    }
    if findings.is_empty() {
        findings.push(Finding {
            claim: claim.sentence.to_owned(),
            standing: Standing::NotMeasured,
            because: String::new(),
        });
    }
    findings
}

fn table(data: &Data<'_>, view: &TexturedView<'_>) -> Table {
    Table {
        headings: vec![
            Heading::plain("fill"),
            Heading::plain("status"),
            Heading::metric(format!("fill, {}", data.unit()), data.metric),
            Heading::plain("÷\u{a0}depth-pass"),
            Heading::plain("÷\u{a0}plain"),
            Heading::metric("texels, RMS", TEXEL_RMS),
            Heading::metric("texels, largest", TEXEL_MAX),
            Heading::metric("non-finite", TEXEL_NON_FINITE),
            Heading::metric("px compared", TEXEL_COMPARED_PX),
            Heading::metric("texture bytes", TEXTURE_BYTES),
        ],
        rows: view.cases.iter().map(|case| row(data, case)).collect(),
        ..Table::default()
    }
}

fn row(data: &Data<'_>, case: &Case) -> Row {
    let why = match case.reason.as_str() {
        "" if is_textured(case) => "not measured",
        "" => "a plain fill has no texels",
        reason => reason,
    };
    let cell = |text: Option<String>| Cell::or_absent(text, why);
    let over_plain = Some(case)
        .filter(|case| is_textured(case))
        .filter(|case| may_be_compared(case))
        .and_then(|case| ratio(case, plain_of(data, case)?, data.metric));
    let over_depth_pass = data.over_baseline(case, DEPTH_PASS);
    let time = data.time(case).filter(|_| may_be_compared(case));
    let remark = [case.note("texture_route"), case.reason.as_str()];
    let remark = remark.iter().filter(|text| !text.is_empty());
    Row {
        cells: vec![
            Cell {
                detail: name(case),
                ..Cell::name(label(case))
            },
            Cell::plain(case.outcome.name()),
            dotted(cell(time.map(spread)), case, data.metric),
            cell(over_depth_pass.map(|ratio| significant(ratio.middle))),
            cell(over_plain.map(|ratio| data.ratio_text(&ratio))),
            cell(case.value(TEXEL_RMS).map(significant)),
            cell(case.value(TEXEL_MAX).map(significant)),
            cell(counter(case, TEXEL_NON_FINITE).map(count)),
            cell(counter(case, TEXEL_COMPARED_PX).map(count)),
            cell(counter(case, TEXTURE_BYTES).map(bytes)),
        ],
        status: case.outcome.name().to_owned(),
        remark: match is_textured(case) {
            true => remark.copied().collect::<Vec<_>>().join(". "),
            false => String::new(),
        },
    }
}

/// What a case is, in words.
pub(super) fn label(case: &Case) -> String {
    let mut words = Vec::new();
    for (key, value) in texture_switches(case) {
        match (key, value) {
            (TEXTURE, "chosen") => words.insert(0, "chosen route".to_owned()),
            (TEXTURE, "floor") => words.insert(0, "least textured fill".to_owned()),
            (TEXTURE, route) if route.starts_with("atan2-native") => {
                words.insert(0, "native atan2".to_owned());
            }
            (PICTURE, "each") => words.push("a picture for each region".to_owned()),
            (PICTURE, size) => words.push(format!("a picture of {size}²")),
            (NORMALIZE, _) => words.push("normalised in vain".to_owned()),
            (POSITION, "inverse-ecef") => words.push("position as in 2007".to_owned()),
            (TEXTURE, route) => words.insert(0, route.to_owned()),
            (key, value) => words.push(format!("{key}={value}")),
        }
    }
    if words.is_empty() {
        return "plain fill".to_owned();
    }
    words.join(", ")
}

/// Cases without a result, timed cases whose comparison cannot be formed.
fn not_measured(data: &Data<'_>, views: &[TexturedView<'_>]) -> Vec<String> {
    let mut lines = Vec::new();
    for view in views {
        for case in view.cases.iter().filter(|case| is_textured(case)) {
            let key = case.id();
            if case.outcome != Outcome::Ok {
                lines.push(format!("{key}: {}: {}", case.outcome.name(), case.reason));
            } else if texture_switches(case) != FLOOR
                && counter(case, TEXEL_COMPARED_PX).unwrap_or(0) == 0
            {
                lines.push(format!("{key}: its texture coordinates were not compared"));
            }
        }
        let absent = COMPARISONS
            .iter()
            .filter(|comparison| compare(data, view, comparison).is_none());
        let absent: Vec<&str> = absent.map(|comparison| comparison.heading).collect();
        if view.cases.iter().all(|case| data.time(case).is_none()) {
            lines.push(format!("{}: drawn and compared, not timed", view.title));
        } else if !absent.is_empty() {
            lines.push(format!(
                "{}: no right case with times for {}",
                view.title,
                absent.join("; ")
            ));
        }
    }
    lines
}

/// The pictures of the view's first case that has them.
fn figure(view: &TexturedView<'_>) -> Option<PictureFigure> {
    let mut textured = view.cases.iter().filter(|case| is_textured(case));
    let case = textured.find(|case| case.value(COLOUR_MAX).is_some())?;
    let figure = |metric| {
        case.value(metric)
            .map_or_else(|| "–".to_owned(), significant)
    };
    let picture = |note: &str, caption: &str| Picture {
        path: case.note(note).to_owned(),
        caption: caption.to_owned(),
    };
    Some(PictureFigure {
        pictures: vec![
            picture("reference_image", "reference"),
            picture("image", "technique"),
            picture("difference_image", "difference × 10"),
        ],
        notes: vec![format!(
            "{}, {}{}: {} texels RMS, {} at most; colours differ by {} of 255 on average, {} at most",
            view.title,
            name(case),
            match case.outcome {
                Outcome::Ok => "",
                _ => " (wrong)",
            },
            figure(TEXEL_RMS),
            figure(TEXEL_MAX),
            figure(COLOUR_MEAN),
            counter(case, COLOUR_MAX).map_or_else(|| "–".to_owned(), count),
        )],
    })
}
