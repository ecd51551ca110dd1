// SPDX-License-Identifier: MIT OR Apache-2.0
//! The matrix chapter: every backend, layout and switch on every view, each cell held against the
//! reference by its row and against the first volume backend's picture by its hash.
//!
//! The reference alone says what is right. That two pictures are the same says only that two
//! techniques agree, and stands beside its verdict, never instead.

use crate::page::breakable;
use crate::run_data::{Case, Outcome, RunData};

/// Switches that draw another boundary or other positions: their pictures are compared among
/// themselves.
const GEOMETRY_SWITCHES: [&str; 3] = ["boundary-lod-px=", "boundary-tolerance-m=", "positions="];

/// The matrix of one scene.
pub(crate) struct MatrixTable {
    pub(crate) scene: String,
    /// Views, in the order of the marks in a cell.
    pub(crate) views: Vec<String>,
    /// Switches, columns.
    pub(crate) switches: Vec<Vec<String>>,
    pub(crate) rows: Vec<MatrixRow>,
    /// Cells that are not right and equal, by name, with what is wrong.
    pub(crate) red: Vec<String>,
    /// Reasons of skipped cells, with how many they are.
    pub(crate) skipped: Vec<(String, usize)>,
    pub(crate) equal: usize,
    /// Cells that are not skipped.
    pub(crate) asked: usize,
}

/// One layout of one backend.
pub(crate) struct MatrixRow {
    pub(crate) name_parts: Vec<String>,
    /// For each switch the marks of the views; empty where the layout has no such switch.
    pub(crate) cells: Vec<Vec<Mark>>,
}

/// One view in a cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Mark {
    pub(crate) text: &'static str,
    pub(crate) class: &'static str,
    pub(crate) title: String,
}

/// What is said of one case.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Finding {
    /// Right by the reference, and the same picture as the first of its kind.
    Equal,
    /// Cannot be drawn here, for this reason.
    Skipped(String),
    /// Wrong, different, not compared, or missing.
    Red(String),
}

/// The matrix of every scene that has one.
pub(crate) fn tables(data: &RunData) -> Vec<MatrixTable> {
    let cells: Vec<&Case> = data
        .cases
        .iter()
        .filter(|case| is_cell(data, case))
        .collect();
    let mut scenes: Vec<&str> = Vec::new();
    for case in &cells {
        if !scenes.contains(&case.key.scene.as_str()) {
            scenes.push(&case.key.scene);
        }
    }
    scenes
        .into_iter()
        .map(|scene| {
            let own: Vec<&Case> = cells
                .iter()
                .copied()
                .filter(|case| case.key.scene == scene)
                .collect();
            table(scene, &own)
        })
        .collect()
}

fn is_cell(data: &RunData, case: &Case) -> bool {
    match &case.summary {
        Some(row) => row.role.split('+').any(|role| role == "matrix"),
        None => data.plan.drawn_only.contains(&case.key),
    }
}

fn split(variant: &str) -> (&str, Vec<String>) {
    let mut parts = variant.split(',');
    let layout = parts.next().unwrap_or_default();
    (layout, parts.map(str::to_owned).collect())
}

fn table(scene: &str, cells: &[&Case]) -> MatrixTable {
    let mut views: Vec<String> = Vec::new();
    let mut switches: Vec<Vec<String>> = Vec::new();
    let mut layouts: Vec<(&str, &str)> = Vec::new();
    for case in cells {
        let (layout, set) = split(&case.key.variant);
        push_new(&mut views, case.key.view.clone());
        push_new(&mut switches, set);
        push_new(&mut layouts, (case.key.backend.as_str(), layout));
    }
    let mut table = MatrixTable {
        scene: scene.to_owned(),
        rows: Vec::new(),
        red: Vec::new(),
        skipped: Vec::new(),
        equal: 0,
        asked: 0,
        views,
        switches,
    };
    // The layouts of a backend together, in the order of the backends.
    let mut backends: Vec<&str> = Vec::new();
    for (backend, _) in &layouts {
        push_new(&mut backends, *backend);
    }
    layouts.sort_by_key(|(backend, _)| backends.iter().position(|known| known == backend));
    for (backend, layout) in layouts {
        let row_cells = table
            .switches
            .clone()
            .iter()
            .map(|set| {
                let of_cell = cells.iter().filter(|case| {
                    case.key.backend == backend && split(&case.key.variant) == (layout, set.clone())
                });
                of_cell
                    .map(|case| {
                        let finding = examine(case, cells);
                        table.count(case, &finding);
                        mark(&case.key.view, finding)
                    })
                    .collect()
            })
            .collect();
        table.rows.push(MatrixRow {
            name_parts: breakable(&format!("{backend}/{layout}")),
            cells: row_cells,
        });
    }
    table
}

impl MatrixTable {
    fn count(&mut self, case: &Case, finding: &Finding) {
        if !matches!(finding, Finding::Skipped(_)) {
            self.asked += 1;
        }
        match finding {
            Finding::Equal => self.equal += 1,
            Finding::Red(what) => self.red.push(format!("{}: {what}", case.key)),
            Finding::Skipped(reason) => {
                match self.skipped.iter_mut().find(|(known, _)| known == reason) {
                    Some((_, count)) => *count += 1,
                    None => self.skipped.push((reason.clone(), 1)),
                }
            }
        }
    }
}

fn push_new<T: PartialEq>(items: &mut Vec<T>, item: T) {
    if !items.contains(&item) {
        items.push(item);
    }
}

fn mark(view: &str, finding: Finding) -> Mark {
    let (text, class, what) = match finding {
        Finding::Equal => ("✓", "equal", "right, and the same picture".to_owned()),
        Finding::Skipped(reason) => ("–", "absent", reason),
        Finding::Red(what) => ("✗", "red", what),
    };
    Mark {
        text,
        class,
        title: format!("{view}: {what}"),
    }
}

/// Part of the variant that says which boundary and positions are drawn.
fn geometry(case: &Case) -> Vec<&str> {
    let is_geometry = |part: &&str| {
        GEOMETRY_SWITCHES
            .iter()
            .any(|switch| part.starts_with(switch))
    };
    case.key.variant.split(',').filter(is_geometry).collect()
}

/// The first case of the same view and geometry that has what `hash` asks for.
fn yardstick<'a>(
    case: &Case,
    cells: &[&'a Case],
    hash: fn(&Case) -> Option<&str>,
) -> Option<(&'a Case, &'a str)> {
    cells.iter().find_map(|other| {
        let is_kin = other.key.view == case.key.view && geometry(other) == geometry(case);
        Some((*other, hash(other).filter(|_| is_kin)?))
    })
}

fn mask_hash(case: &Case) -> Option<&str> {
    let hash = &case.summary.as_ref()?.mask_hash;
    Some(hash.as_str()).filter(|hash| !hash.is_empty())
}

fn ids_hash(case: &Case) -> Option<&str> {
    let hash = &case.summary.as_ref()?.ids_hash;
    Some(hash.as_str()).filter(|hash| !hash.is_empty())
}

fn examine(case: &Case, cells: &[&Case]) -> Finding {
    match case.outcome {
        // What follows the first remark is about the view.
        Outcome::Skipped => {
            let reason = case.reason().split("; ").next();
            return Finding::Skipped(reason.unwrap_or_default().to_owned());
        }
        Outcome::Wrong | Outcome::Failed | Outcome::Missing => {
            return Finding::Red(format!("{}: {}", case.outcome.name(), case.reason()));
        }
        Outcome::Ok => {}
    }
    match case.value(|row| row.mismatched_px_outside_band) {
        Some(0) => {}
        Some(px) => return Finding::Red(format!("{px} wrong pixels outside the band")),
        None => return Finding::Red("never compared with the reference".to_owned()),
    }
    let Some(mask) = mask_hash(case) else {
        return Finding::Red("no hash of its mask was recorded".to_owned());
    };
    let differs = |own: &str, hash: fn(&Case) -> Option<&str>, what: &str| {
        yardstick(case, cells, hash)
            .filter(|(_, theirs)| *theirs != own)
            .map(|(other, _)| Finding::Red(format!("{what} differs from that of {}", other.name())))
    };
    differs(mask, mask_hash, "its mask")
        .or_else(|| differs(ids_hash(case)?, ids_hash, "its regions' picture"))
        .unwrap_or(Finding::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::legacy::{CaseKey, Status, Summary};

    fn case(variant: &str, mask: &str, ids: &str) -> Case {
        let key = CaseKey {
            scene: "s".to_owned(),
            view: "v".to_owned(),
            backend: "vertex".to_owned(),
            variant: variant.to_owned(),
        };
        Case {
            summary: Some(Summary {
                role: "matrix".to_owned(),
                mask_hash: mask.to_owned(),
                ids_hash: ids.to_owned(),
                mismatched_px_outside_band: Some(0),
                ..Summary::new(key.clone(), Status::Ok)
            }),
            key,
            outcome: Outcome::Ok,
            fill_cpu_ms: Vec::new(),
            fill_cpu: None,
        }
    }

    fn of(cases: &[Case]) -> MatrixTable {
        table("s", &cases.iter().collect::<Vec<_>>())
    }

    #[test]
    fn equal_pictures_are_green_and_one_wrong_hash_is_red_and_named() {
        let mut cases = vec![
            case("doubled", "m", "i"),
            case("doubled,faces=two-pass", "m", "i"),
            case("pulled", "m", "i"),
            case("doubled,colour=one-colour", "m", ""),
        ];
        let table = of(&cases);
        assert_eq!((table.equal, table.asked, table.red.len()), (4, 4, 0));
        assert_eq!(table.rows.len(), 2);
        assert_eq!(table.rows[1].cells[1], [], "not in the run");
        // Twins: another mask, another picture of regions under the same mask.
        cases[2] = case("pulled", "x", "i");
        assert_eq!(
            of(&cases).red,
            ["s/v/vertex/pulled: its mask differs from that of vertex/doubled"]
        );
        cases[2] = case("pulled", "m", "x");
        assert_eq!(
            of(&cases).red,
            ["s/v/vertex/pulled: its regions' picture differs from that of vertex/doubled"]
        );
        assert_eq!(of(&cases).rows[1].cells[0][0].class, "red");
    }

    #[test]
    fn the_same_picture_is_not_enough_where_the_reference_differs() {
        let mut cases = vec![case("doubled", "m", "i"), case("pulled", "m", "i")];
        cases[1].outcome = Outcome::Wrong;
        assert!(of(&cases).red[0].contains("wrong"));
        cases[1] = case("pulled", "m", "i");
        if let Some(row) = &mut cases[1].summary {
            row.mismatched_px_outside_band = Some(3);
        }
        assert!(of(&cases).red[0].contains("3 wrong pixels"));
    }

    #[test]
    fn other_boundaries_are_compared_among_themselves() {
        let mut cases = vec![
            case("doubled", "m", "i"),
            case("doubled,boundary-lod-px=0.5", "l", "j"),
            case("pulled,boundary-lod-px=0.5", "l", "j"),
            case("doubled,positions=local-f32", "p", "q"),
        ];
        assert_eq!(of(&cases).red, [""; 0]);
        cases[2] = case("pulled,boundary-lod-px=0.5", "m", "i");
        assert!(of(&cases).red[0].contains("vertex/doubled,boundary-lod-px=0.5"));
    }

    #[test]
    fn what_was_not_drawn_is_never_green() {
        let mut cases = vec![case("doubled", "m", "i"), case("pulled", "", "")];
        assert!(of(&cases).red[0].contains("no hash"));
        cases[1].outcome = Outcome::Missing;
        cases[1].summary = None;
        assert!(of(&cases).red[0].contains("missing"));
        cases[1] = case("pulled", "m", "i");
        cases[1].outcome = Outcome::Skipped;
        if let Some(row) = &mut cases[1].summary {
            row.reason = "the adapter lacks it; a remark on the view".to_owned();
        }
        let table = of(&cases);
        assert_eq!(table.skipped, [("the adapter lacks it".to_owned(), 1)]);
        assert_eq!((table.equal, table.asked, table.red.len()), (1, 1, 0));
    }
}
