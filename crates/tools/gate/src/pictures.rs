// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures of what is wrong, beside the reference: copied from the run folder into `pictures/`, so that a
//! page and what it shows can be uploaded together and the run folders can go.

use crate::{Finding, Gate, Severity};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::Path;
use terrafill_results::{Case, Run};

/// Folder of the pictures, in the gate's.
pub const PICTURES: &str = "pictures";

/// Cases that are shown.
const MAX_SHOWN: usize = 3;

/// Notes of a case that name a picture of it, with what they show.
const NOTES: [(&str, &str); 3] = [
    ("reference_image", "reference"),
    ("difference_image", "difference"),
    ("worst_image", "worst pixel"),
];

/// The pictures of a case.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ShownCase {
    /// [`terrafill_results::CaseId::key`].
    pub case: String,
    /// What each shows, and its path relative to the gate's folder; an empty path where it could not be copied.
    pub pictures: Vec<(String, String)>,
}

/// Copies the pictures of the first cases whose pictures or errors changed, from the new run. A case without
/// a difference picture, such as one that draws what it should, is not shown: there is nothing to see. A picture that
/// cannot be copied is named as such, and costs no verdict.
///
/// - `out`: the gate's folder
pub(crate) fn copy_pictures(findings: &[Finding], new: &Run, out: &Path) -> Vec<ShownCase> {
    let mut seen = BTreeSet::new();
    let of_pictures = findings.iter().filter(|finding| {
        let is_of_pictures = matches!(finding.gate, Gate::Status | Gate::Errors);
        is_of_pictures && finding.severity != Severity::Note
    });
    let cases = of_pictures.filter_map(|finding| new.case(&finding.case));
    let differing = cases.filter(|case| !case.note("difference_image").is_empty());
    let first = differing.filter(|case| seen.insert(case.id().key()));
    (1..=MAX_SHOWN)
        .zip(first)
        .map(|(number, case)| copy_case(case, &new.path, out, number))
        .collect()
}

fn copy_case(case: &Case, run: &Path, out: &Path, number: usize) -> ShownCase {
    let copy = |from: &str, name: &str| {
        std::fs::create_dir_all(out.join(PICTURES))?;
        std::fs::copy(run.join(from), out.join(name))
    };
    let notes = NOTES.iter().filter(|(note, _)| !case.note(note).is_empty());
    let pictures = notes.map(|(note, what)| {
        let name = format!("{PICTURES}/{number}-{}.png", what.replace(' ', "-"));
        match copy(case.note(note), &name) {
            Ok(_) => ((*what).to_owned(), name),
            Err(error) => (format!("{what}: {error}"), String::new()),
        }
    });
    ShownCase {
        case: case.id().key(),
        pictures: pictures.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up_report::finding;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    #[test]
    fn a_wrong_picture_stands_beside_its_reference_and_a_right_one_is_not_shown() {
        let place = tempfile::tempdir().expect("a folder");
        let mut made = MadeUpRun::default();
        for name in ["a", "b"] {
            let case = made.case(case_id("filling", name, &[]));
            if name == "a" {
                case.note("reference_image", "images/r.png");
                case.note("difference_image", "images/d.png");
            }
        }
        let run = made.write(&place.path().join("new")).expect("a run");
        std::fs::create_dir_all(run.path.join("images")).expect("a folder");
        std::fs::write(run.path.join("images/r.png"), b"r").expect("written");
        let findings = [
            finding("filling/a", Severity::Worse, Gate::Status),
            finding("filling/a", Severity::Worse, Gate::Errors),
            finding("filling/b", Severity::Worse, Gate::Status),
        ];
        // Negative control: a picture that the run names and lacks.
        let missing = copy_pictures(&findings, &run, place.path());
        let (what, path) = &missing[0].pictures[1];
        assert!(
            what.starts_with("difference: ") && path.is_empty(),
            "{what}"
        );
        std::fs::write(run.path.join("images/d.png"), b"d").expect("written");
        let shown = copy_pictures(&findings, &run, place.path());
        let paths: Vec<&str> = shown[0]
            .pictures
            .iter()
            .map(|(_, path)| path.as_str())
            .collect();
        assert_eq!((shown.len(), shown[0].case.as_str()), (1, "filling/a"));
        assert_eq!(
            paths,
            ["pictures/1-reference.png", "pictures/1-difference.png"]
        );
        let read = |path: &str| std::fs::read(place.path().join(path)).expect("read");
        assert_eq!(
            [read(paths[0]), read(paths[1])],
            [b"r".to_vec(), b"d".to_vec()]
        );
        // Times and counters have no picture.
        let counted = [finding("filling/a", Severity::Worse, Gate::Counters)];
        let none = copy_pictures(&counted, &run, place.path());
        assert_eq!(none, []);
    }
}
