// SPDX-License-Identifier: MIT OR Apache-2.0
//! The named edge cases of `core`, put to the locator: the same texts, the same points, and those
//! too close to a boundary for a mesh.

#![allow(clippy::print_stdout, reason = "how much was asked is worth reading")]

use terrafill_core::{EdgeRule, Repair};
use terrafill_fixtures::expectations::{Case, accepted};
use terrafill_reference::{Locator, LocatorError};

/// What a case says of locators that promise no less than meshes do.
const AGREES: &str = "agrees";

fn locator(case: &Case, rule: EdgeRule) -> Result<Locator, LocatorError> {
    // As written: even where a mesh needs crossings made vertices, the even-odd rule decides.
    let mut region = case.region();
    region.repaired = case.repair.then_some(Repair::EvenOdd);
    Locator::new(&[region], rule, &case.body())
}

/// What is wrong with a locator by its case, and the number of points asked.
fn faults(case: &Case, locator: &Locator) -> (Vec<String>, usize) {
    let mut faults = Vec::new();
    let mut asked = 0;
    let lists = [
        (&case.inside, true),
        (&case.exact_inside, true),
        (&case.outside, false),
        (&case.exact_outside, false),
    ];
    for (points, expected) in lists {
        for &[longitude, latitude] in points {
            asked += 1;
            // Whole turns change nothing.
            for turns in [0.0, 360.0, -360.0] {
                let found = locator.locate(longitude + turns, latitude);
                if found.regions.is_empty() == expected {
                    faults.push(format!("{longitude} {latitude} is on the wrong side"));
                    break;
                }
                if !found.disagree.is_empty() {
                    faults.push(format!("the tests differ at {longitude} {latitude}"));
                    break;
                }
            }
        }
    }
    (faults, asked)
}

#[test]
fn every_point_of_every_accepted_case_is_where_it_belongs() {
    let mut wrong = Vec::new();
    let (mut asked, mut refused) = (0, 0);
    for case in accepted() {
        match locator(&case, case.rule) {
            Ok(locator) if case.locator == AGREES => {
                let (faults, points) = faults(&case, &locator);
                asked += points;
                wrong.extend(faults.iter().map(|fault| format!("{}: {fault}", case.name)));
            }
            Ok(_) => wrong.push(format!("{}: not refused", case.name)),
            Err(error) => {
                refused += 1;
                let message = error.to_string();
                if case.locator == AGREES || !message.contains(&case.locator) {
                    wrong.push(format!("{}: {message}", case.name));
                }
            }
        }
    }
    println!("{asked} points asked; {refused} cases refused by the locator, as expected");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(asked > 1000, "only {asked} points");
}

#[test]
fn in_every_case_a_point_on_the_wrong_side_is_noticed() {
    let mut moved = 0;
    for case in accepted() {
        if case.locator != AGREES {
            continue;
        }
        let locator = locator(&case, case.rule).expect("not refused");
        let mutants = [
            {
                let mut mutant = case.clone();
                mutant.outside.append(&mut mutant.inside);
                mutant.exact_outside.append(&mut mutant.exact_inside);
                mutant
            },
            {
                let mut mutant = case.clone();
                mutant.inside.append(&mut mutant.outside);
                mutant.exact_inside.append(&mut mutant.exact_outside);
                mutant
            },
        ];
        let sides = [
            case.inside.len() + case.exact_inside.len(),
            case.outside.len() + case.exact_outside.len(),
        ];
        assert!(sides[0] > 0, "{}: no point inside", case.name);
        for (mutant, expected) in mutants.iter().zip(sides) {
            assert_eq!(faults(mutant, &locator).0.len(), expected, "{}", case.name);
            moved += expected;
        }
    }
    assert!(moved > 1000, "only {moved} points");
}

#[test]
fn the_other_edge_rule_is_noticed() {
    let noticed = accepted()
        .iter()
        .filter(|case| {
            let other = match case.rule {
                EdgeRule::Planar => EdgeRule::GreatEllipse,
                EdgeRule::GreatEllipse => EdgeRule::Planar,
            };
            locator(case, other).is_ok_and(|locator| !faults(case, &locator).0.is_empty())
        })
        .count();
    assert!(noticed >= 10, "only {noticed} cases tell the rules apart");
}
