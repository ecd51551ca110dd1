// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chapter on textured fill: what a picture costs beside the plain fill of the same rounds, how
//! far its texels are from where they should be, and what it looks like beside the reference.
//!
//! Cozzi (2007) named the two arctangents of the texture coordinates as what textured fill loses
//! most on. Findings are held against the measured interval; nothing here knows what came out.

use crate::interval::{Claim, Interval, Standing, gain};
use crate::ladder::interval_text;
use crate::number::{bytes, count, significant};
use crate::page::breakable;
use crate::picture::{Picture, embed};
use crate::run_data::{Case, Outcome, RunData};
use terrafill_results::legacy::CaseKey;

/// Switches that a plain fill of the same layout has not.
const TEXTURE_KEYS: [&str; 4] = ["texture", "normalize", "picture", "position"];

/// How many times the plain fill a textured one may take.
const MOST_OVER_PLAIN: f64 = 1.3;

/// The view for which that is asked.
const TOP_DOWN: &str = "top-down";

/// What is compared: time of the one over time of the other. Cases by their texture switches.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Comparison {
    pub(crate) heading: &'static str,
    case: &'static [&'static str],
    control: &'static [&'static str],
}

const CHOSEN: &[&str] = &["texture=chosen"];
const NATIVE: &[&str] = &["texture=atan2-native+bowring-1"];
/// What any textured fill must pay that looks at depth.
const FLOOR: &[&str] = &["texture=floor"];

/// The document's comparisons.
pub(crate) const COMPARISONS: [Comparison; 8] = [
    Comparison {
        heading: "native atan2 ÷ plain",
        case: NATIVE,
        control: &[],
    },
    Comparison {
        heading: "chosen route ÷ plain",
        case: CHOSEN,
        control: &[],
    },
    Comparison {
        heading: "floor ÷ plain",
        case: FLOOR,
        control: &[],
    },
    Comparison {
        heading: "chosen route ÷ floor",
        case: CHOSEN,
        control: FLOOR,
    },
    Comparison {
        heading: "native atan2 ÷ chosen route",
        case: NATIVE,
        control: CHOSEN,
    },
    Comparison {
        heading: "a picture each ÷ one for all",
        case: &["picture=each", "texture=chosen"],
        control: CHOSEN,
    },
    Comparison {
        heading: "picture of the scene ÷ of 32²",
        case: CHOSEN,
        control: &["picture=32", "texture=chosen"],
    },
    Comparison {
        heading: "normalised twice ÷ once",
        case: &["normalize=superfluous", "texture=atan2-native+bowring-1"],
        control: NATIVE,
    },
];

/// A sentence, the comparison that speaks of it, and what it claims.
struct Finding {
    sentence: &'static str,
    comparison: usize,
    claim: Claim,
    /// The one view it is asked of; all without.
    view: Option<&'static str>,
}

const FINDINGS: [Finding; 5] = [
    Finding {
        sentence: "Cozzi (2007): a textured fill pays for “two costly atan calls”.",
        comparison: 4,
        claim: Claim::Faster,
        view: None,
    },
    Finding {
        sentence: "Cozzi (2007): without them “the performance could double”.",
        comparison: 4,
        claim: Claim::AtLeast(2.0),
        view: None,
    },
    Finding {
        sentence: "Asked of this project: by the chosen route, less than 1.3 times the plain fill.",
        comparison: 1,
        claim: Claim::LessThan(MOST_OVER_PLAIN),
        view: Some(TOP_DOWN),
    },
    Finding {
        sentence: "Whether this device can do so at all: the floor, less than 1.3 times the plain fill.",
        comparison: 2,
        claim: Claim::LessThan(MOST_OVER_PLAIN),
        view: Some(TOP_DOWN),
    },
    Finding {
        sentence: "By the chosen route, less than 1.3 times that floor.",
        comparison: 3,
        claim: Claim::LessThan(MOST_OVER_PLAIN),
        view: None,
    },
];

/// The chapter.
pub(crate) struct TexturedChapter {
    pub(crate) comparisons: Vec<&'static str>,
    /// View by view, a cell for each comparison.
    pub(crate) ratios: Vec<(String, Vec<String>)>,
    pub(crate) findings: Vec<FindingRow>,
    pub(crate) tables: Vec<TexturedTable>,
    /// What has no result, by name, with the reason.
    pub(crate) not_measured: Vec<String>,
    pub(crate) pictures: Vec<PictureRow>,
    pub(crate) picture_problems: Vec<String>,
}

/// A sentence, and what each view's interval says of it.
pub(crate) struct FindingRow {
    pub(crate) sentence: &'static str,
    /// View and interval, then class and words of the standing.
    pub(crate) views: Vec<(String, &'static str, &'static str)>,
}

/// Textured fills of one view beside its plain ones.
pub(crate) struct TexturedTable {
    pub(crate) title: String,
    pub(crate) rows: Vec<TexturedRow>,
}

/// One fill.
pub(crate) struct TexturedRow {
    pub(crate) label: String,
    pub(crate) name_parts: Vec<String>,
    pub(crate) status: &'static str,
    pub(crate) cells: Vec<String>,
    /// The route with what was left out for it, and the row's own reason.
    pub(crate) remark: String,
}

/// Pictures of one view.
pub(crate) struct PictureRow {
    pub(crate) title: String,
    pub(crate) caption: String,
    pub(crate) reference: Picture,
    pub(crate) found: Picture,
    pub(crate) difference: Picture,
    pub(crate) is_wrong: bool,
}

/// Whether the case is a textured fill.
pub(crate) fn is_textured(key: &CaseKey) -> bool {
    key.variant
        .split(',')
        .any(|switch| switch.starts_with("texture="))
}

/// `None` of a run that plans no textured fill.
pub(crate) fn chapter(data: &RunData) -> Option<TexturedChapter> {
    let views = views(data);
    if views.is_empty() {
        return None;
    }
    let (pictures, picture_problems) = pictures(data, &views);
    Some(TexturedChapter {
        comparisons: COMPARISONS.map(|comparison| comparison.heading).into(),
        ratios: views.iter().filter_map(|view| ratios(data, view)).collect(),
        findings: FINDINGS.iter().map(|f| finding(data, &views, f)).collect(),
        tables: views.iter().map(|view| table(data, view)).collect(),
        not_measured: not_measured(data, &views),
        pictures,
        picture_problems,
    })
}

/// A view with textured fills.
struct TexturedView<'a> {
    title: String,
    scene: &'a str,
    view: &'a str,
    /// Textured fills and the plain ones that they are held against.
    cases: Vec<&'a Case>,
}

impl<'a> TexturedView<'a> {
    /// The first backend's case with these texture switches.
    fn case(&self, switches: &[&str]) -> Option<&'a Case> {
        let found = |case: &&&Case| texture_switches(&case.key) == switches;
        self.cases.iter().find(found).copied()
    }
}

fn views(data: &RunData) -> Vec<TexturedView<'_>> {
    let mut views: Vec<TexturedView<'_>> = Vec::new();
    for case in data.cases.iter().filter(|case| is_textured(&case.key)) {
        let of = (case.key.scene.as_str(), case.key.view.as_str());
        let at = views.iter().position(|view| (view.scene, view.view) == of);
        let at = at.unwrap_or_else(|| {
            views.push(TexturedView {
                title: format!("{}, {}", of.0, of.1),
                scene: of.0,
                view: of.1,
                cases: Vec::new(),
            });
            views.len() - 1
        });
        let held = &mut views[at].cases;
        if let Some(plain) = plain_of(data, case)
            && !held.iter().any(|known| known.key == plain.key)
        {
            held.push(plain);
        }
        held.push(case);
    }
    views
}

/// Switches that make the fill a textured one, in the variant's order.
fn texture_switches(key: &CaseKey) -> Vec<&str> {
    let is_of_texture = |switch: &&str| {
        let key = switch.split('=').next().unwrap_or_default();
        TEXTURE_KEYS.contains(&key)
    };
    let mut switches: Vec<&str> = key.variant.split(',').filter(is_of_texture).collect();
    switches.sort_unstable();
    switches
}

/// The same fill without a picture.
fn plain_of<'a>(data: &'a RunData, case: &Case) -> Option<&'a Case> {
    let of_texture = texture_switches(&case.key);
    let plain = case.key.variant.split(',');
    let plain: Vec<&str> = plain.filter(|s| !of_texture.contains(s)).collect();
    data.case(&CaseKey {
        variant: plain.join(","),
        ..case.key.clone()
    })
}

/// Time of `case` over time of `control`, in the same rounds and both right.
fn over(data: &RunData, case: &Case, control: &Case) -> Option<Interval> {
    let frames = |case: &Case| data.frames.get(&case.key).filter(|_| case.counts());
    gain(frames(case)?, frames(control)?)
}

fn compare(data: &RunData, view: &TexturedView<'_>, comparison: &Comparison) -> Option<Interval> {
    let case = view.case(comparison.case)?;
    // The plain fill of the same backend and layout, not the first one there is.
    let control = match comparison.control {
        [] => plain_of(data, case)?,
        switches => view.case(switches)?,
    };
    over(data, case, control)
}

fn ratios(data: &RunData, view: &TexturedView<'_>) -> Option<(String, Vec<String>)> {
    let ratios = COMPARISONS.map(|comparison| compare(data, view, &comparison));
    ratios.iter().any(Option::is_some).then(|| {
        let cells = ratios.map(|ratio| ratio.map_or_else(|| "–".to_owned(), interval_text));
        (view.title.clone(), cells.into())
    })
}

fn finding(data: &RunData, views: &[TexturedView<'_>], finding: &Finding) -> FindingRow {
    let asked = |view: &&TexturedView<'_>| finding.view.is_none_or(|name| name == view.view);
    let views = views.iter().filter(asked).filter_map(|view| {
        let ratio = compare(data, view, &COMPARISONS[finding.comparison])?;
        let standing: Standing = finding.claim.standing(ratio);
        Some((
            format!("{}: {}", view.title, interval_text(ratio)),
            standing.class(),
            standing.name(),
        ))
    });
    FindingRow {
        sentence: finding.sentence,
        views: views.collect(),
    }
}

fn table(data: &RunData, view: &TexturedView<'_>) -> TexturedTable {
    TexturedTable {
        title: view.title.clone(),
        rows: view.cases.iter().map(|case| row(data, case)).collect(),
    }
}

fn row(data: &RunData, case: &Case) -> TexturedRow {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    let time = case.fill_cpu.filter(|_| case.counts()).map(|ms| {
        let [median, p5, p95] = [ms.median, ms.p5, ms.p95].map(significant);
        format!("{median} [{p5}–{p95}]")
    });
    let over_plain = plain_of(data, case)
        .filter(|plain| plain.key != case.key)
        .and_then(|plain| over(data, case, plain));
    let route = case.value(|row| Some(row.texture_route.clone()));
    let remark = [route.unwrap_or_default(), case.reason().to_owned()];
    let remark: Vec<String> = remark.into_iter().filter(|text| !text.is_empty()).collect();
    TexturedRow {
        label: label(&case.key),
        name_parts: breakable(&case.name()),
        status: case.outcome.name(),
        cells: vec![
            or_dash(time),
            or_dash(case.value(|row| row.fill_over_bound_cpu).map(significant)),
            or_dash(over_plain.map(interval_text)),
            or_dash(case.value(|row| row.texel_rms).map(significant)),
            or_dash(case.value(|row| row.texel_max).map(significant)),
            or_dash(case.value(|row| row.texel_non_finite).map(count)),
            or_dash(case.value(|row| row.texel_compared_px).map(count)),
            or_dash(case.value(|row| row.texture_bytes).map(bytes)),
        ],
        remark: match is_textured(&case.key) {
            true => remark.join(". "),
            false => String::new(),
        },
    }
}

/// What a case is, in words.
fn label(key: &CaseKey) -> String {
    let mut words = Vec::new();
    for switch in texture_switches(key) {
        match switch.split_once('=') {
            Some(("texture", "chosen")) => words.insert(0, "chosen route".to_owned()),
            Some(("texture", "floor")) => words.insert(0, "floor".to_owned()),
            Some(("texture", route)) if route.starts_with("atan2-native") => {
                words.insert(0, "native atan2".to_owned());
            }
            Some(("picture", "each")) => words.push("a picture for each region".to_owned()),
            Some(("picture", size)) => words.push(format!("a picture of {size}²")),
            Some(("normalize", _)) => words.push("normalised twice".to_owned()),
            Some(("texture", route)) => words.insert(0, route.to_owned()),
            _ => words.push(switch.to_owned()),
        }
    }
    if words.is_empty() {
        return "plain fill".to_owned();
    }
    words.join(", ")
}

/// Cases without a result, timed cases whose comparison cannot be formed, scenes left out.
fn not_measured(data: &RunData, views: &[TexturedView<'_>]) -> Vec<String> {
    let mut lines = Vec::new();
    for view in views {
        let textured = view.cases.iter().filter(|case| is_textured(&case.key));
        for case in textured {
            if case.outcome != Outcome::Ok {
                let (name, why) = (case.outcome.name(), case.reason());
                lines.push(format!("{}: {name}: {why}", case.key));
            } else if texture_switches(&case.key) != FLOOR
                && case.value(|row| row.texel_compared_px).unwrap_or(0) == 0
            {
                let key = &case.key;
                lines.push(format!("{key}: its texture coordinates were not compared"));
            }
        }
        let is_timed = view.cases.iter().any(|case| case.fill_cpu.is_some());
        let absent = COMPARISONS
            .iter()
            .filter(|comparison| compare(data, view, comparison).is_none());
        let absent: Vec<&str> = absent.map(|comparison| comparison.heading).collect();
        if !is_timed {
            lines.push(format!("{}: drawn and compared, not timed", view.title));
        } else if !absent.is_empty() {
            lines.push(format!(
                "{}: no case, or too few right frames in the same rounds, for {}",
                view.title,
                absent.join("; ")
            ));
        }
    }
    let scenes = data.plan.skipped_scenes.iter();
    lines.extend(scenes.map(|(scene, why)| format!("{scene}: {why}")));
    lines
}

/// The pictures of each view's first case that has them.
fn pictures(data: &RunData, views: &[TexturedView<'_>]) -> (Vec<PictureRow>, Vec<String>) {
    let (mut rows, mut problems) = (Vec::new(), Vec::new());
    for view in views {
        let textured = view.cases.iter().filter(|case| is_textured(&case.key));
        let mut shown = textured.filter(|case| case.value(|row| row.colour_max).is_some());
        let Some(case) = shown.next() else {
            continue;
        };
        match picture_row(data, view, case) {
            Ok(row) => rows.push(row),
            Err(problem) => problems.push(format!("{}: {problem}", view.title)),
        }
    }
    (rows, problems)
}

fn picture_row(data: &RunData, view: &TexturedView<'_>, case: &Case) -> Result<PictureRow, String> {
    let load = |path: Option<String>| embed(&data.folder, &path.unwrap_or_default());
    let figure = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), significant);
    let largest = case.value(|row| row.colour_max);
    Ok(PictureRow {
        title: view.title.clone(),
        caption: format!(
            "{}: {} texels RMS, {} at most; colours differ by {} of 255 on average, {} at most",
            case.name(),
            figure(case.value(|row| row.texel_rms)),
            figure(case.value(|row| row.texel_max)),
            figure(case.value(|row| row.colour_mean)),
            largest.map_or_else(|| "–".to_owned(), count),
        ),
        reference: load(case.value(|row| Some(row.reference_image.clone())))?,
        found: load(case.value(|row| Some(row.image.clone())))?,
        difference: load(case.value(|row| Some(row.difference_image.clone())))?,
        is_wrong: case.outcome != Outcome::Ok,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(variant: &str) -> CaseKey {
        CaseKey {
            scene: "s".to_owned(),
            view: "v".to_owned(),
            backend: "vertex".to_owned(),
            variant: variant.to_owned(),
        }
    }

    #[test]
    fn textured_fills_are_told_from_plain_ones() {
        assert!(is_textured(&key("doubled,texture=chosen")));
        assert!(!is_textured(&key("doubled")));
        assert!(!is_textured(&key("doubled,textures=chosen")));
    }

    #[test]
    fn labels_say_what_differs() {
        let labels = [
            ("doubled", "plain fill"),
            ("doubled,texture=chosen", "chosen route"),
            ("doubled,texture=floor", "floor"),
            (
                "doubled,texture=chosen,picture=32",
                "chosen route, a picture of 32²",
            ),
            (
                "doubled,normalize=superfluous,texture=atan2-native+bowring-1",
                "native atan2, normalised twice",
            ),
            ("doubled,texture=gnomonic-3", "gnomonic-3"),
        ];
        for (variant, expected) in labels {
            assert_eq!(label(&key(variant)), expected);
        }
    }

    #[test]
    fn every_comparison_is_of_sorted_switches() {
        for comparison in COMPARISONS {
            assert!(comparison.case.is_sorted() && comparison.control.is_sorted());
            assert_ne!(comparison.case, comparison.control);
        }
    }
}
