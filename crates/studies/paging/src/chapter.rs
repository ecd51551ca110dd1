// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on paging: flights by every rule, the paper's Table 2, what counting costs, and the paper's claims.

mod table_2;

use self::table_2::timed;
use crate::metrics::{self, *};
use terrafill_lab::{
    Cases, ClaimedTime, Column, Figure, Names, Section, SectionedChapter, Select, StudyClaims,
    finding,
};
use terrafill_plot::number::{digits, measured_bytes, significant};
use terrafill_plot::{Course, Courses};
use terrafill_results::{Answers, Block, Case, ChapterError, Finding, Scope};

const TITLE: &str = "Paging: a texture larger than memory";

/// What paging a large texture costs, and what it shows meanwhile.
pub(crate) const CHAPTER: SectionedChapter = SectionedChapter {
    study: crate::STUDY,
    title: TITLE,
    question: "Which rule pages a large texture with which spikes, and what is seen meanwhile?",
    text: "A texture of 8,192 × 8,192 texels covers the Earth by longitude and latitude. One preprocessing step cuts \
           all of its levels into pages of 128 × 128 texels with a border of one texel, in a file, which the \
           system’s page cache still holds: no disk is waited for. The device has 256 slots for pages and a page table. A fragment shows the deepest page of its place that is in a slot. \
           A flight begins when its first view has its pages, and ends when its last one has. Each frame decides with what is known, reads pages into the slots that were wanted longest ago, \
           and draws. By counted pixels a quadtree splits and merges; counts are two frames old. By distance it does \
           so with pixels that each page would have if it faced the eye. By derivatives each pixel finds its own level \
           and says which page it wants, which is known two frames later. WebGPU’s queries say no more than zero or \
           not, so fragments count themselves; study `globes` finds that precise queries count the same. Texels of the \
           pattern say their level, column and row: each pixel of the judged frames is held against rays in double \
           precision and the frame’s page table, with the first and the last of the four texels that a filter mixes.",
    terms: crate::metrics::TERMS,
    primary: FRAME,
    answers: |cases| {
        let at_rest = cases.fitting(|case| {
            case.condition(metrics::PART) == FLIGHTS
                && case.condition(TRANSFERS) == "any"
                && case.condition(HYSTERESIS) != "1"
        });
        // A rule that wants more texels lacks fewer: no rule is named without both.
        let sentence = |(path, own): &(&str, Cases<'_>)| {
            let of_rule = |case: &Case| {
                let [missing, texels] = [PAGING_MISSING_PX, PAGING_TEXELS_PER_PX]
                    .map(|metric| case.value(metric).map(significant));
                let rule = case.condition(RULE);
                Some(format!("{rule} {} at {}", missing?, texels?))
            };
            let rules: Vec<String> = own.iter().filter_map(of_rule).collect();
            let rules = rules.join(", ");
            (!rules.is_empty()).then(|| {
                format!("Pixels a frame without the page of their footprint, path {path}, at texels a pixel: {rules}.")
            })
        };
        let sentences: Vec<String> = at_rest.by(PATH).iter().filter_map(sentence).collect();
        Answers {
            blocks: Vec::from_iter((!sentences.is_empty()).then_some(Block::List(sentences))),
            ..Answers::default()
        }
    },
    sections: &[BY_RULE, table_2::SECTION, COUNTED_FRAMES, EARTH],
    claims: Some(&CLAIMS),
};

const FRAME: Figure = Figure::ByClock(PAGING_FRAME_WALL_MS, PAGING_FRAME_CPU_MS);

const NAMES: Names<'static> = Names::Columns(&[
    ("path", PATH),
    ("rule", RULE),
    ("hysteresis", HYSTERESIS),
    ("pages a frame", TRANSFERS),
]);

const PICTURES: &[(&str, &str)] = &[
    ("before", "frame 24"),
    ("picture", "at rest"),
    (
        "afar",
        "the same pages from 9,000 km; the box is what the eye sees",
    ),
    (
        "balance",
        "lines where levels meet; the star is below the eye",
    ),
    ("tree", "the quadtree over the texture, with its levels"),
];

const BY_RULE: Section<'static> = Section {
    title: "Flights by every rule",
    text: "48 frames each, and more until all pages are read; from the 39th on the eye rests. A jump lands in frame 20. In pictures each level has a colour, \
           from grey at level 0 to red at level 6, pages are a chessboard, and what shows a coarser page than wanted is \
           pale. A tree wants what its leaves are: after a jump it wants too little. Missing is measured \
           by the footprints of pixels for every rule alike. Blurred is a pixel whose texel is more than a level larger than its footprint.",
    cases: Select::With(metrics::PART, FLIGHTS),
    named_by: NAMES,
    columns: &[
        Column::metric("wrong px", PAGING_MISMATCHED_PX),
        Column::metric("frames with missing pages", PAGING_MISSING_FRAMES),
        Column::metric("missing, px a frame", PAGING_MISSING_PX),
        Column::metric("most", PAGING_MISSING_MAX_PX),
        Column::metric("frames", PAGING_FRAMES),
        Column::metric("pages read", PAGING_READS),
        Column::metric("most in a frame", PAGING_READS_MAX),
        Column::metric("bytes sent", PAGING_BYTES),
        Column::metric("most in a frame", PAGING_BYTES_MAX),
        Column::metric("at rest", PAGING_STEADY_BYTES),
        Column::metric("texels a pixel", PAGING_TEXELS_PER_PX),
        Column::metric("blurred in frame 24, px", PAGING_BLURRED_MOVING_PX),
        Column::metric("at rest", PAGING_BLURRED_PX),
        Column::metric("levels lost at the edge", PAGING_EDGE_LOSS),
        timed("frame, ms", PAGING_FRAME_WALL_MS, PAGING_FRAME_CPU_MS),
        timed("95 %", PAGING_FRAME_P95_WALL_MS, PAGING_FRAME_P95_CPU_MS),
        timed("longest", PAGING_FRAME_MAX_WALL_MS, PAGING_FRAME_MAX_CPU_MS),
    ],
    is_main: true,
    findings: &[exact, steady, edges, late],
    pictures: PICTURES,
    more: &[missing, bytes],
    ..Section::EMPTY
};

const COUNTED_FRAMES: Section<'static> = Section {
    title: "Frames with and without counting",
    text: "The same still view with the same pages, all that it wants; 20 frames, of which none waits for another but for its \
           counts. Counts are cleared, added to by every fragment and copied; later: read when they are two frames old.",
    cases: Select::With(metrics::PART, COUNTING),
    named_by: Names::Columns(&[("counts are read", COUNTED), ("pixels a side", SIZE_PX)]),
    columns: &[timed("frame, ms", PAGING_DRAW_WALL_MS, PAGING_DRAW_CPU_MS)],
    ..Section::EMPTY
};

const EARTH: Section<'static> = Section {
    title: "Flights over the Earth",
    text: "NASA’s Blue Marble of 4,096 × 2,048 texels, enlarged to 8,192 × 8,192. A pixel must have the colour that a \
           filter may make of the texels of the page that it is to show.",
    cases: Select::With(metrics::PART, OF_EARTH),
    named_by: NAMES,
    columns: &[
        Column::metric("wrong px", PAGING_MISMATCHED_PX),
        Column::metric("of px", PAGING_JUDGED_PX),
        Column::metric("beside their middle alone", PAGING_BAND_PX),
        Column::metric("pages read", PAGING_READS),
        timed("frame, ms", PAGING_FRAME_WALL_MS, PAGING_FRAME_CPU_MS),
        timed("longest", PAGING_FRAME_MAX_WALL_MS, PAGING_FRAME_MAX_CPU_MS),
    ],
    pictures: PICTURES,
    ..Section::EMPTY
};

/// What the paper claims of large textures.
pub(crate) const CLAIMS: StudyClaims = StudyClaims {
    study: crate::STUDY,
    title: "The claims of Gebbie and Bailey on large textures",
    file: [
        "papers/gebbie-bailey.toml",
        include_str!("../../../../papers/gebbie-bailey.toml"),
    ],
    times: &[ClaimedTime {
        name: "frame",
        by: [PAGING_FRAME_WALL_MS, PAGING_FRAME_CPU_MS],
        needs: Scope::PLAN.and(Scope::FRAME),
    }],
    metrics: &METRICS,
    findings: |cases| {
        let sections = [BY_RULE, table_2::SECTION].into_iter();
        sections.flat_map(|section| section.found(cases)).collect()
    },
    page: [""; 2],
};

fn exact(cases: &Cases<'_>) -> Finding {
    let px = |metric| cases.sum(metric).map(digits).unwrap_or_default();
    let said = format!(
        "{} of {} pixels wrong, {} right beside their middle alone.",
        px(PAGING_MISMATCHED_PX),
        px(PAGING_JUDGED_PX),
        px(PAGING_BAND_PX)
    );
    let wrong = cases.sum(PAGING_MISMATCHED_PX);
    let claim = "Each pixel shows the texel of the deepest page in a slot";
    finding(claim, wrong.map(|wrong| wrong == 0.0), said)
}

/// With a hysteresis at which trees rest, and without a tree, where frames may read all that they want.
fn steady(cases: &Cases<'_>) -> Finding {
    let cases = cases.with(&[(TRANSFERS, "any")]);
    let own = cases.fitting(|case| case.condition(HYSTERESIS) != "1");
    let of = |cases: &Cases<'_>| cases.greatest(PAGING_STEADY_BYTES);
    let others = of(&cases.with(&[(HYSTERESIS, "1")]));
    let most = of(&own);
    let said = format!(
        "At most {} with a hysteresis of 4 or no tree, {} with a hysteresis of 1.",
        most.map(measured_bytes).unwrap_or_default(),
        others.map(measured_bytes).unwrap_or_default()
    );
    let claim = "A frame whose eye rests, and that has its pages, sends nothing to the device, but with a hysteresis of 1";
    let both = most.zip(others);
    finding(
        claim,
        both.map(|(most, others)| most == 0.0 && others > 0.0),
        said,
    )
}

/// Levels that count as lost.
const LOST: f64 = 0.1;

/// Levels that counting loses in pages that the picture's edge cuts. Footprints have foreshortening in them.
fn edges(cases: &Cases<'_>) -> Finding {
    let own = cases.with(&[(HYSTERESIS, "4"), (TRANSFERS, "any")]);
    let own = own.with(&[(RULE, "counted")]);
    let lost = own.iter().filter_map(|case| {
        let lost = case.value(PAGING_EDGE_LOSS)?;
        Some((case.condition(PATH), lost))
    });
    let lost: Vec<(&str, f64)> = lost.collect();
    let words = lost
        .iter()
        .map(|(path, lost)| format!("{path}: {}", significant(*lost)));
    let words: Vec<String> = words.collect();
    finding(
        "Gebbie & Bailey: counted pixels leave less texture depth, a tenth of a level and more, in pages that the edge of the screen cuts",
        (!lost.is_empty()).then_some(lost.iter().all(|(_, lost)| *lost >= LOST)),
        format!(
            "Levels lost in cut pages beyond those within: {}.",
            words.join("; ")
        ),
    )
}

/// What a budget of one page costs in what is seen.
fn late(cases: &Cases<'_>) -> Finding {
    let pairs = cases.pairs(TRANSFERS, ["any", "1"], &[]);
    let both = pairs.iter().filter_map(|[any, one]| {
        let px = |case: &Case| case.value(PAGING_MISSING_PX);
        Some((px(any)?, px(one)?))
    });
    let both: Vec<(f64, f64)> = both.collect();
    let sum = |of: fn(&(f64, f64)) -> f64| both.iter().map(of).sum::<f64>();
    let [any, one] = [sum(|of| of.0), sum(|of| of.1)];
    let [said_any, said_one] = [any, one].map(|px| significant(px / both.len().max(1) as f64));
    finding(
        "One page a frame leaves more pixels with a coarser page than they want",
        (!both.is_empty()).then_some(one > any),
        format!("{said_one} pixels a frame with one page, {said_any} with any number."),
    )
}

fn course(cases: &Cases<'_>, caption: &str, note: &str) -> Result<Option<Block>, ChapterError> {
    let panels = cases.iter().map(|case| {
        let conditions = [PATH, RULE, HYSTERESIS, TRANSFERS].map(|key| case.condition(key));
        let [path, rule, hysteresis, pages] = conditions;
        let values = case.note(note).split(' ');
        Course {
            name: format!("{path}, {rule}, hysteresis {hysteresis}, {pages} a frame"),
            values: values.filter_map(|value| value.parse().ok()).collect(),
            wanted: None,
        }
    });
    let courses = Courses {
        title: caption.to_owned(),
        across: "frames",
        panels: panels.collect(),
    };
    Ok(Block::plot(caption, courses.draw()?))
}

fn jumps<'a>(cases: &Cases<'a>) -> Cases<'a> {
    let own = cases.with(&[(PATH, "jump")]);
    own.fitting(|case| case.condition(HYSTERESIS) != "1")
}

fn missing(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let caption = "Pixels that show a coarser page than they want, frame by frame of a jump.";
    course(&jumps(cases), caption, "missing")
}

fn bytes(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let caption = "Bytes that are sent, frame by frame of a jump.";
    course(&jumps(cases), caption, "bytes")
}

#[cfg(test)]
mod tests;
