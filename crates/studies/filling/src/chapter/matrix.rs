// SPDX-License-Identifier: MIT OR Apache-2.0
//! The matrix: every technique, layout and switch on every view, each cell compared with the reference
//! by its figures and with the first picture of its kind by its hash.
//!
//! The reference alone says what is right. That two pictures are the same says only that two
//! techniques agree. It is shown next to the reference's verdict and never replaces it.

use super::data::{Data, counter, distinct, grouped, has_role, layout_name, name, switches};
use super::table::{figures, head, part, row};
use crate::keys::*;
use std::collections::BTreeMap;
use terrafill_results::{Block, Case, Cell, CellClass, ConditionKey, Outcome, Table, TableLayout};

/// Switches that draw another boundary, other positions or other walls: their pictures are compared among
/// themselves.
const GEOMETRY: [ConditionKey; 5] = [VIEW, BOUNDARY_LOD_PX, TOLERANCE_M, NORMALS, POSITIONS];

/// Right by the reference, and the same picture as the first of its kind.
const EQUAL: char = '✓';
/// Cannot be drawn here.
const SKIPPED: char = '–';
/// Wrong, different, not compared, or missing.
const RED: char = '✗';

/// A case with its mark, and what is said of it.
struct Examined<'a> {
    case: &'a Case,
    mark: char,
    what: String,
}

/// The matrix of every scene that has one.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let cells = data.cases.iter().copied();
    let cells = cells.filter(|case| has_role(case, "matrix"));
    let scenes = grouped(cells, |case| case.condition(SCENE));
    if scenes.is_empty() {
        return Vec::new();
    }
    let head = head(
        "Every technique, layout and switch",
        "Each cell is drawn once. ✓: right by the reference, 0 wrong pixels outside the band, and \
             the same picture to the pixel as the first of its kind. ✗: anything else. –: unavailable \
             on this device. One mark for each view. Other boundaries (levels of detail) and other \
             positions are other pictures, and are compared among themselves.",
    );
    let scenes = scenes.iter();
    let scenes = scenes.flat_map(|(scene, cells)| scene_blocks(scene, cells));
    head.into_iter().chain(scenes).collect()
}

fn scene_blocks(scene: &str, cells: &[&Case]) -> Vec<Block> {
    let views = distinct(cells.iter().map(|case| case.condition(VIEW)));
    let firsts = firsts(cells);
    let found = cells.iter().map(|case| examine(case, &firsts));
    let found: Vec<Examined<'_>> = found.collect();
    let marked = |mark: char| found.iter().filter(move |of| of.mark == mark);
    let red = marked(RED).map(|of| format!("{}: {}", name_in_view(of.case), of.what));
    let red: Vec<String> = red.collect();
    let equal = marked(EQUAL).count();
    let drawn = equal + red.len();
    let reasons = grouped(marked(SKIPPED), |of| of.what.as_str()).into_iter();
    let skipped = reasons.map(|(reason, cells)| format!("{reason} ({} cells)", cells.len()));
    let skipped: Vec<String> = skipped.collect();
    let mut blocks = vec![
        part(format!("{scene}: {equal} of {drawn} cells right and equal")),
        Block::Remark(format!("Marks in a cell: {}.", views.join(", "))),
    ];
    blocks.extend(Block::folded_list(
        format!("{} cells are not", red.len()),
        red,
    ));
    blocks.push(Block::Table(marks(&found)));
    if !skipped.is_empty() {
        blocks.push(Block::Remark(format!(
            "Unavailable on this device: {}.",
            skipped.join("; ")
        )));
    }
    blocks
}

/// A row for each layout, those of a technique together, and a column for each set of switches. A set is what a case
/// changes against the plainest one of its layout, which has the shortest variant.
fn marks(found: &[Examined<'_>]) -> Table {
    let techniques = grouped(found, |of| of.case.condition(TECHNIQUE)).into_iter();
    let layouts = techniques.flat_map(|(_, own)| grouped(own, |of| layout_name(of.case)));
    let layouts: Vec<(String, Vec<&Examined<'_>>)> = layouts.collect();
    let plain: BTreeMap<&str, BTreeMap<&str, &str>> = layouts
        .iter()
        .map(|(layout, own)| (layout.as_str(), plainest(own)))
        .collect();
    let set = |case: &Case| {
        let plain = &plain[layout_name(case).as_str()];
        let own = switches(case).into_iter();
        let own = own.filter(|(key, value)| plain.get(key) != Some(value));
        let own = own.map(|(key, value)| format!("{key}={value}"));
        own.collect::<Vec<_>>().join(", ")
    };
    let sets = distinct(found.iter().map(|of| set(of.case)));
    let rows = layouts.iter().map(|(layout, own)| {
        let by_set: BTreeMap<_, _> = grouped(own.iter().copied(), |of| set(of.case))
            .into_iter()
            .collect();
        let cells = sets.iter();
        let cells = cells.map(|set| cell(by_set.get(set).map_or(&[], Vec::as_slice)));
        row(Cell::name(layout), cells)
    });
    let headings = sets.iter().map(|set| match set.as_str() {
        "" => ("as it should be used", ""),
        set => (set, ""),
    });
    let headings: Vec<_> = [("layout", "")].into_iter().chain(headings).collect();
    Table {
        layout: TableLayout::UprightHeadings,
        ..figures(&headings, rows.collect())
    }
}

/// Switches of the case with the shortest variant.
fn plainest<'c>(own: &[&Examined<'c>]) -> BTreeMap<&'c str, &'c str> {
    let cases = own.iter().map(|of| of.case);
    let plainest = cases.min_by_key(|case| case.condition(VARIANT).len());
    plainest.map_or_else(BTreeMap::new, |case| switches(case).into_iter().collect())
}

/// A mark for each view; empty where the layout has no such switch.
fn cell(found: &[&Examined<'_>]) -> Cell {
    let title = found
        .iter()
        .map(|of| format!("{}: {}", of.case.condition(VIEW), of.what));
    let has = |mark| found.iter().any(|of| of.mark == mark);
    Cell {
        text: found.iter().map(|of| of.mark).collect(),
        title: title.collect::<Vec<_>>().join("; "),
        class: match [RED, EQUAL].map(has) {
            [true, _] => CellClass::Bad,
            [false, true] => CellClass::Good,
            [false, false] => CellClass::Plain,
        },
        ..Cell::default()
    }
}

fn name_in_view(case: &Case) -> String {
    format!(
        "{}/{}/{}",
        case.condition(SCENE),
        case.condition(VIEW),
        name(case)
    )
}

/// Hashes of a picture, and what each is of.
const HASHES: [(&str, &str); 2] = [
    ("mask_hash", "its mask"),
    ("ids_hash", "its regions' picture"),
];

/// The first case of each view and geometry that has such a hash.
type Firsts<'a> = BTreeMap<(&'static str, [&'a str; 5]), &'a Case>;

fn geometry(case: &Case) -> [&str; 5] {
    GEOMETRY.map(|key| case.condition(key))
}

fn firsts<'a>(cells: &[&'a Case]) -> Firsts<'a> {
    // Backwards, so that the first one stays.
    let all = cells.iter().rev().flat_map(|case| {
        let own = HASHES.into_iter();
        let own = own.filter(|(hash, _)| !case.note(hash).is_empty());
        own.map(|(hash, _)| ((hash, geometry(case)), *case))
    });
    all.collect()
}

fn examine<'a>(case: &'a Case, firsts: &Firsts<'_>) -> Examined<'a> {
    let (mark, what) = match case.outcome {
        // What follows the first remark is about the view.
        Outcome::Skipped | Outcome::DriverFault => {
            let reason = case.reason.split("; ").next();
            (SKIPPED, reason.unwrap_or_default().to_owned())
        }
        Outcome::Wrong | Outcome::Failed | Outcome::Missing => {
            (RED, format!("{}: {}", case.outcome.name(), case.reason))
        }
        Outcome::Ok => match objection(case, firsts) {
            Some(what) => (RED, what),
            None => (EQUAL, "right, and the same picture".to_owned()),
        },
    };
    Examined { case, mark, what }
}

/// What speaks against a case that ended well.
fn objection(case: &Case, firsts: &Firsts<'_>) -> Option<String> {
    match counter(case, MISMATCHED_PX_OUTSIDE_BAND) {
        Some(0) => {}
        Some(px) => return Some(format!("{px} wrong pixels outside the band")),
        None => return Some("never compared with the reference".to_owned()),
    }
    if case.note("mask_hash").is_empty() {
        return Some("no hash of its mask was recorded".to_owned());
    }
    HASHES.into_iter().find_map(|(hash, what)| {
        let own = case.note(hash);
        let first = firsts.get(&(hash, geometry(case)))?;
        let differs = !own.is_empty() && first.note(hash) != own;
        differs.then(|| format!("{what} differs from that of {}", name(first)))
    })
}
