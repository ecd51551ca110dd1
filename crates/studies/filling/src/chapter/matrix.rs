// SPDX-License-Identifier: MIT OR Apache-2.0
//! The matrix: every technique, layout and switch on every view, each cell compared with the reference
//! by its figures and with the first picture of its kind by its hash.
//!
//! The reference alone says what is right. That two pictures are the same says only that two
//! techniques agree. It is shown next to the reference's verdict and never replaces it.

use super::data::{Data, distinct, grouped, layout_name, name};
use super::table::head;
use crate::keys::*;
use crate::purpose::{Purpose, switches};
use std::collections::BTreeMap;
use terrafill_results::{
    Block, Case, Cell, CellClass, ConditionKey, Outcome, Row, Table, TableLayout,
};

/// Cases that agree in these show the same picture: the others draw another boundary, other positions or other
/// walls.
const PICTURE_KEYS: [ConditionKey; 6] = [
    SCENE,
    VIEW,
    BOUNDARY_LOD_PX,
    TOLERANCE_M,
    NORMALS,
    POSITIONS,
];

/// Hashes of a picture, and what each is of.
const HASHES: [(&str, &str); 2] = [
    ("mask_hash", "its mask"),
    ("ids_hash", "its regions' picture"),
];

/// Right by the reference, and the same picture as the first of its kind.
const EQUAL: char = '✓';
/// Cannot be drawn here.
const SKIPPED: char = '–';
/// Wrong, different, not compared, or missing.
const RED: char = '✗';

/// The first case of each picture that has such a hash.
type Firsts<'a> = BTreeMap<(&'static str, [&'a str; 6]), &'a Case>;

/// A case with its mark, and what is said of it.
struct Examined<'a> {
    case: &'a Case,
    mark: char,
    what: String,
}

/// One matrix of all scenes that have one.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let cells = data.cases.iter().copied();
    let cells = cells.filter(|case| Purpose::Matrix.is_of(case));
    // Backwards, so that the first one stays.
    let hashed = cells.clone().rev().flat_map(|case| {
        let own = HASHES.iter().map(|(hash, _)| *hash);
        let own = own.filter(|hash| !case.note(hash).is_empty());
        own.map(move |hash| ((hash, PICTURE_KEYS.map(|key| case.condition(key))), case))
    });
    let firsts: Firsts<'_> = hashed.collect();
    let found: Vec<Examined<'_>> = cells.map(|case| examine(case, &firsts)).collect();
    if found.is_empty() {
        return Vec::new();
    }
    let scenes = grouped(&found, |of| of.case.condition(SCENE)).into_iter();
    let tallies = scenes.map(|(scene, own)| {
        let marked = |mark: char| own.iter().filter(|of| of.mark == mark).count();
        let (equal, red) = (marked(EQUAL), marked(RED));
        format!("{scene}: {equal} of {} cells right and equal.", equal + red)
    });
    let marked = |mark: char| found.iter().filter(move |of| of.mark == mark);
    let red = marked(RED).map(|of| {
        let [scene, view] = [SCENE, VIEW].map(|key| of.case.condition(key));
        format!("{scene}/{view}/{}: {}", name(of.case), of.what)
    });
    let red: Vec<String> = red.collect();
    let reasons = grouped(marked(SKIPPED), |of| of.what.as_str()).into_iter();
    let skipped = reasons.map(|(reason, cells)| format!("{reason} ({} cells)", cells.len()));
    let mut blocks = head(
        "Every technique, layout and switch",
        "Each cell is drawn once. ✓: right by the reference, 0 wrong pixels outside the band, and \
             the same picture to the pixel as the first of its kind. ✗: anything else. –: unavailable \
             on this device. One mark for each view. Other boundaries (levels of detail) and other \
             positions are other pictures, and are compared among themselves.",
    );
    blocks.push(Block::List(tallies.collect()));
    blocks.extend(Block::folded_list(
        format!("{} cells are not", red.len()),
        red,
    ));
    blocks.push(Block::Table(marks(&found)));
    blocks.extend(Block::folded_list(
        "Unavailable on this device",
        skipped.collect(),
    ));
    blocks
}

/// A row for each layout of a scene, and a column for each set of switches: what a case changes against the plainest
/// one of its row, which has the shortest variant.
fn marks(found: &[Examined<'_>]) -> Table {
    let title = |of: &&Examined<'_>| {
        let scene = of.case.condition(SCENE);
        format!("{scene}: {}", layout_name(of.case))
    };
    // Layouts of a technique follow each other.
    let techniques = grouped(found, |of| {
        [SCENE, TECHNIQUE].map(|key| of.case.condition(key))
    });
    let rows = techniques
        .into_iter()
        .flat_map(|(_, own)| grouped(own, title));
    let rows = rows.map(|(title, own)| {
        let variants = own.iter().map(|of| of.case);
        let plainest = variants.min_by_key(|case| case.condition(VARIANT).len());
        let plain = plainest.map_or_else(Vec::new, switches);
        let set = |of: &&Examined<'_>| {
            let own = switches(of.case).into_iter();
            let own = own.filter(|switch| !plain.contains(switch));
            let own = own.map(|(key, value)| format!("{key}={value}"));
            own.collect::<Vec<_>>().join(", ")
        };
        let by_set: BTreeMap<String, Vec<&Examined<'_>>> = grouped(own, set).into_iter().collect();
        (title, by_set)
    });
    let rows: Vec<_> = rows.collect();
    let sets = distinct(rows.iter().flat_map(|(_, by_set)| by_set.keys().cloned()));
    let headings = sets.iter().map(|set| match set.as_str() {
        "" => "as it should be used",
        set => set,
    });
    let headings = std::iter::once("layout").chain(headings);
    let rows = rows.iter().map(|(title, by_set)| {
        let marked = |set| cell(by_set.get(set).map_or(&[], Vec::as_slice));
        Row::named(Cell::name(title), sets.iter().map(marked))
    });
    Table {
        layout: TableLayout::UprightHeadings,
        ..Table::of(headings, rows.collect())
    }
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
    match case.value(MISMATCHED_PX_OUTSIDE_BAND) {
        Some(0.0) => {}
        Some(px) => return Some(format!("{px} wrong pixels outside the band")),
        None => return Some("never compared with the reference".to_owned()),
    }
    if case.note("mask_hash").is_empty() {
        return Some("no hash of its mask was recorded".to_owned());
    }
    HASHES.into_iter().find_map(|(hash, what)| {
        let own = case.note(hash);
        let first = firsts.get(&(hash, PICTURE_KEYS.map(|key| case.condition(key))))?;
        let differs = !own.is_empty() && first.note(hash) != own;
        differs.then(|| format!("{what} differs from that of {}", name(first)))
    })
}
