// SPDX-License-Identifier: MIT OR Apache-2.0
//! The matrix: every technique, layout and switch on every view, each cell compared with the reference
//! by its figures and with the first picture of its kind by its hash.
//!
//! The reference alone says what is right. That two pictures are the same says only that two
//! techniques agree, and stands beside the reference's verdict, never instead.

use super::data::{Data, counter, distinct, has_role, is_same, name, switches};
use crate::keys::{
    BOUNDARY_LOD_PX, LAYOUT, MISMATCHED_PX_OUTSIDE_BAND, NORMALS, POSITIONS, SCENE, TECHNIQUE,
    TOLERANCE_M, VARIANT, VIEW,
};
use terrafill_results::{
    Block, Case, Cell, CellClass, ConditionKey, Heading, Outcome, Row, Table, TableLayout,
};

/// Switches that draw another boundary, other positions or other walls: their pictures are compared among
/// themselves.
const GEOMETRY: [ConditionKey; 5] = [VIEW, BOUNDARY_LOD_PX, TOLERANCE_M, NORMALS, POSITIONS];

/// What is said of one case.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Found {
    /// Right by the reference, and the same picture as the first of its kind.
    Equal,
    /// Cannot be drawn here, for this reason.
    Skipped(String),
    /// Wrong, different, not compared, or missing.
    Red(String),
}

/// The matrix of every scene that has one.
pub(super) fn blocks(data: &Data<'_>) -> Vec<Block> {
    let cells = data
        .cases
        .iter()
        .copied()
        .filter(|case| has_role(case, "matrix"));
    let cells: Vec<&Case> = cells.collect();
    if cells.is_empty() {
        return Vec::new();
    }
    let mut blocks = vec![
        Block::section("Every technique, layout and switch"),
        Block::Text(
            "Each cell is drawn once. ✓: right by the reference, 0 wrong pixels outside the band, and \
             the same picture to the pixel as the first of its kind. ✗: anything else. –: unavailable \
             on this device. One mark for each view. Other boundaries (levels of detail) and other \
             positions are other pictures, and are compared among themselves."
                .to_owned(),
        ),
    ];
    for scene in distinct(cells.iter().map(|case| case.condition(SCENE))) {
        let own = cells
            .iter()
            .copied()
            .filter(|case| case.condition(SCENE) == scene);
        blocks.extend(scene_blocks(scene, &own.collect::<Vec<_>>()));
    }
    blocks
}

fn scene_blocks(scene: &str, cells: &[&Case]) -> Vec<Block> {
    let views = distinct(cells.iter().map(|case| case.condition(VIEW)));
    let sets = distinct(cells.iter().map(|case| set_switches(case, cells)));
    let found: Vec<(&Case, Found)> = cells
        .iter()
        .map(|case| (*case, examine(case, cells)))
        .collect();
    let red: Vec<String> = found
        .iter()
        .filter_map(|(case, found)| match found {
            Found::Red(what) => Some(format!("{}: {what}", name_in_view(case))),
            _ => None,
        })
        .collect();
    let equal = found
        .iter()
        .filter(|(_, found)| *found == Found::Equal)
        .count();
    let skipped = skipped(&found);
    let drawn = equal + red.len();
    let mut blocks = vec![
        Block::Heading {
            level: 4,
            text: format!("{scene}: {equal} of {drawn} cells right and equal"),
        },
        Block::Remark(format!("Marks in a cell: {}.", views.join(", "))),
    ];
    blocks.extend(Block::folded_list(
        format!("{} cells are not", red.len()),
        red,
    ));
    let layouts = distinct(found.iter().map(|(case, _)| layout(case)));
    // The layouts of a technique together, in the order of the techniques.
    let techniques = distinct(layouts.iter().map(|(technique, _)| *technique));
    let rows = techniques.iter().flat_map(|technique| {
        let own = layouts.iter().filter(move |(of, _)| of == technique);
        own.map(|layout_of| row(*layout_of, &sets, &found, cells))
    });
    let heading = |set: &Vec<String>| match set.is_empty() {
        true => Heading::plain("as it should be used"),
        false => Heading::plain(set.join(", ")),
    };
    blocks.push(Block::Table(Table {
        headings: std::iter::once(Heading::plain("layout"))
            .chain(sets.iter().map(heading))
            .collect(),
        rows: rows.collect(),
        layout: TableLayout::UprightHeadings,
        ..Table::default()
    }));
    if !skipped.is_empty() {
        blocks.push(Block::Remark(format!(
            "Unavailable on this device: {}.",
            skipped.join("; ")
        )));
    }
    blocks
}

fn layout(case: &Case) -> (&str, &str) {
    (case.condition(TECHNIQUE), case.condition(LAYOUT))
}

/// Switches in which a case differs from the plainest one of its technique and layout, which is the
/// one with the shortest variant.
fn set_switches(case: &Case, cells: &[&Case]) -> Vec<String> {
    let kin = cells.iter().filter(|other| layout(other) == layout(case));
    let plainest = kin.min_by_key(|other| other.condition(VARIANT).len());
    let plain = plainest.map_or_else(Vec::new, |case| switches(case));
    let own = switches(case);
    let set = own.iter().filter(|switch| !plain.contains(switch));
    set.map(|(key, value)| format!("{key}={value}")).collect()
}

fn row(
    layout_of: (&str, &str),
    sets: &[Vec<String>],
    found: &[(&Case, Found)],
    cells: &[&Case],
) -> Row {
    let mut row = vec![Cell::name(format!("{}/{}", layout_of.0, layout_of.1))];
    row.extend(sets.iter().map(|set| {
        let own = found
            .iter()
            .filter(|(case, _)| layout(case) == layout_of && set_switches(case, cells) == *set);
        cell(&own.collect::<Vec<_>>())
    }));
    Row::new(row)
}

/// A mark for each view; empty where the layout has no such switch.
fn cell(found: &[&(&Case, Found)]) -> Cell {
    let mark = |found: &Found| match found {
        Found::Equal => "✓",
        Found::Skipped(_) => "–",
        Found::Red(_) => "✗",
    };
    let title = found.iter().map(|(case, found)| {
        let what = match found {
            Found::Equal => "right, and the same picture",
            Found::Skipped(why) | Found::Red(why) => why,
        };
        format!("{}: {what}", case.condition(VIEW))
    });
    let has = |of: fn(&Found) -> bool| found.iter().any(|(_, found)| of(found));
    Cell {
        text: found.iter().map(|(_, found)| mark(found)).collect(),
        title: title.collect::<Vec<_>>().join("; "),
        class: match () {
            () if has(|found| matches!(found, Found::Red(_))) => CellClass::Bad,
            () if has(|found| *found == Found::Equal) => CellClass::Good,
            () => CellClass::Plain,
        },
        ..Cell::default()
    }
}

/// Reasons of skipped cells, with how many they are.
fn skipped(found: &[(&Case, Found)]) -> Vec<String> {
    let reasons = || {
        found.iter().filter_map(|(_, found)| match found {
            Found::Skipped(reason) => Some(reason.as_str()),
            _ => None,
        })
    };
    let counted = distinct(reasons()).into_iter().map(|reason| {
        let cells = reasons().filter(|other| *other == reason).count();
        format!("{reason} ({cells} cells)")
    });
    counted.collect()
}

fn name_in_view(case: &Case) -> String {
    format!(
        "{}/{}/{}",
        case.condition(SCENE),
        case.condition(VIEW),
        name(case)
    )
}

/// The first case of the same view and geometry that has such a hash.
fn first_of_kind<'a>(case: &Case, cells: &[&'a Case], hash: &str) -> Option<&'a Case> {
    let is_kin = |other: &&&Case| is_same(other, case, &GEOMETRY) && !other.note(hash).is_empty();
    cells.iter().find(is_kin).copied()
}

fn examine(case: &Case, cells: &[&Case]) -> Found {
    match case.outcome {
        // What follows the first remark is about the view.
        Outcome::Skipped | Outcome::DriverFault => {
            let reason = case.reason.split("; ").next();
            return Found::Skipped(reason.unwrap_or_default().to_owned());
        }
        Outcome::Wrong | Outcome::Failed | Outcome::Missing => {
            return Found::Red(format!("{}: {}", case.outcome.name(), case.reason));
        }
        Outcome::Ok => {}
    }
    match counter(case, MISMATCHED_PX_OUTSIDE_BAND) {
        Some(0) => {}
        Some(px) => return Found::Red(format!("{px} wrong pixels outside the band")),
        None => return Found::Red("never compared with the reference".to_owned()),
    }
    if case.note("mask_hash").is_empty() {
        return Found::Red("no hash of its mask was recorded".to_owned());
    }
    for (hash, what) in [
        ("mask_hash", "its mask"),
        ("ids_hash", "its regions' picture"),
    ] {
        let own = case.note(hash);
        let first = first_of_kind(case, cells, hash).filter(|_| !own.is_empty());
        if let Some(first) = first.filter(|first| first.note(hash) != own) {
            return Found::Red(format!("{what} differs from that of {}", name(first)));
        }
    }
    Found::Equal
}
