// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every named edge case against areas and points that were computed without this crate, and
//! against the same with a fault put in, which must be noticed in every single case.

#![allow(
    clippy::print_stdout,
    reason = "the largest error is worth reading beside its limit"
)]

use glam::DVec3;
use robust::{Coord3D, orient3d};
use std::collections::BTreeSet;
use terrafill_core::{Geodetic, MeshError, MeshOptions, Region, RegionMesh};
use terrafill_fixtures::expectations::{Case, FilePlace, Refusal, Stage, accepted, all_cases};
use terrafill_fixtures::{check_extruded, region};

/// Of the body's radius, 20 m on the Earth: fine enough that no point of a case is closer to the
/// boundary than the boundary is drawn.
const BOUNDARY_TOLERANCE: f64 = 3e-6;

/// Crossings are compared in degrees; 1e-9° is 0.1 mm on the Earth.
const CROSSING_TOLERANCE_DEG: f64 = 1e-9;

fn build(case: &Case, region: &Region) -> Result<RegionMesh, MeshError> {
    let body = case.body();
    let options = MeshOptions {
        boundary_tolerance_m: BOUNDARY_TOLERANCE * body.equatorial_radius_m(),
        ..MeshOptions::default()
    };
    RegionMesh::build(region, &body, case.rule, &options)
}

fn mesh(case: &Case) -> RegionMesh {
    let mut region = case.region();
    if case.repair {
        region.split_at_crossings(case.rule);
    }
    build(case, &region).unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

/// Relative.
fn area_error(case: &Case, mesh: &RegionMesh) -> f64 {
    (mesh.area_m2 / case.area_m2 - 1.0).abs()
}

/// How many triangles hold a point of the surface, those turned over counted off.
///
/// In central projection, which keeps straight edges straight: a point is in a triangle when it is
/// on the inner side of the three planes through the centre and an edge. Exact signs, so that no
/// point falls between two neighbours.
fn cover(mesh: &RegionMesh, point: DVec3) -> i32 {
    let coordinate = |v: DVec3| Coord3D {
        x: v.x,
        y: v.y,
        z: v.z,
    };
    let (origin, p) = (coordinate(DVec3::ZERO), coordinate(point));
    let side = |a: DVec3, b: DVec3| orient3d(coordinate(a), coordinate(b), p, origin);
    let mut sum = 0;
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|i| mesh.vertices_ecef[i as usize]);
        // The planes also hold the point's antipode between them.
        if (a + b + c).dot(point) <= 0.0 {
            continue;
        }
        let sides = [side(a, b), side(b, c), side(c, a)];
        if sides.iter().all(|&side| side >= 0.0) {
            sum += 1;
        } else if sides.iter().all(|&side| side < 0.0) {
            sum -= 1;
        }
    }
    sum
}

/// Points that the mesh has on the wrong side.
fn misplaced(case: &Case, mesh: &RegionMesh) -> Vec<[f64; 2]> {
    let body = case.body();
    let covered = |point: &[f64; 2]| {
        let surface = Geodetic::from_degrees(point[0], point[1], 0.0);
        cover(mesh, body.geodetic_to_ecef(surface)) > 0
    };
    let inside = case.inside.iter().filter(|point| !covered(point));
    let outside = case.outside.iter().filter(|point| covered(point));
    inside.chain(outside).copied().collect()
}

/// What is wrong with a mesh by its case.
fn faults(case: &Case, mesh: &RegionMesh) -> Vec<String> {
    let mut faults = Vec::new();
    if let Err(violation) = mesh.check_invariants(&case.body()) {
        faults.push(violation.to_string());
    }
    let error = area_error(case, mesh);
    if error.is_nan() || error > case.relative_tolerance {
        let (found, expected) = (mesh.area_m2, case.area_m2);
        faults.push(format!("area {found} is not {expected}: {error:.1e}"));
    }
    for point in misplaced(case, mesh) {
        faults.push(format!("{point:?} is on the wrong side"));
    }
    for expected in &case.warnings {
        if !mesh
            .warnings
            .iter()
            .any(|found| found.text.contains(expected))
        {
            faults.push(format!("no warning “{expected}” in {:?}", mesh.warnings));
        }
    }
    if let Some(expected) = case.boundary_loops {
        let found = mesh.boundary_loops.len();
        if found != expected {
            faults.push(format!("{found} boundary loops, not {expected}"));
        }
    }
    faults
}

#[test]
fn every_accepted_case_has_its_area_and_its_points() {
    let cases = accepted();
    let mut wrong = Vec::new();
    let mut worst = (0.0, "");
    for case in &cases {
        let mut region = case.region();
        if case.repair {
            region.split_at_crossings(case.rule);
        }
        match build(case, &region) {
            Ok(mesh) => {
                let share = area_error(case, &mesh) / case.relative_tolerance;
                if share > worst.0 {
                    worst = (share, &case.name);
                }
                if let Err(fault) = check_extruded(&mesh, &case.body()) {
                    wrong.push(format!("{}: {fault}", case.name));
                }
                wrong.extend(
                    faults(case, &mesh)
                        .iter()
                        .map(|fault| format!("{}: {fault}", case.name)),
                );
            }
            Err(error) => wrong.push(format!("{}: {error}", case.name)),
        }
    }
    println!(
        "{} accepted; largest area error {:.2} of what is allowed, {}",
        cases.len(),
        worst.0,
        worst.1
    );
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn in_every_case_a_wrong_area_and_a_wrong_point_are_noticed() {
    for case in accepted() {
        let mesh = mesh(&case);
        // A millionth, except where the coordinates themselves say no more than that.
        let change = f64::max(1e-6, 3.0 * case.relative_tolerance);
        for factor in [1.0 + change, 1.0 - change] {
            let mut mutant = case.clone();
            mutant.area_m2 *= factor;
            assert_ne!(
                faults(&mutant, &mesh),
                faults(&case, &mesh),
                "{}",
                case.name
            );
        }
        // Every single point, moved to the other list.
        let before = misplaced(&case, &mesh).len();
        for i in 0..case.inside.len() {
            let mut mutant = case.clone();
            let point = mutant.inside.remove(i);
            mutant.outside.push(point);
            assert_eq!(misplaced(&mutant, &mesh).len(), before + 1, "{}", case.name);
        }
        for i in 0..case.outside.len() {
            let mut mutant = case.clone();
            let point = mutant.outside.remove(i);
            mutant.inside.push(point);
            assert_eq!(misplaced(&mutant, &mesh).len(), before + 1, "{}", case.name);
        }
        let without_points = case.inside.is_empty() && case.outside.is_empty();
        assert!(
            !without_points || !case.exact_inside.is_empty(),
            "{}: checks no point",
            case.name
        );
    }
}

#[test]
fn the_other_edge_rule_is_noticed() {
    // Negative control of the rule: pairs of cases with one text that differ by it.
    let cases = accepted();
    let mut pairs = 0;
    for case in &cases {
        let Some(stem) = case.name.strip_suffix("-great-ellipse") else {
            continue;
        };
        let Some(planar) = cases.iter().find(|c| c.name == format!("{stem}-planar")) else {
            continue;
        };
        // Between two meridians both rules say the same.
        if planar.area_m2 == case.area_m2 {
            continue;
        }
        let apart = (planar.area_m2 / case.area_m2 - 1.0).abs();
        let swapped = area_error(planar, &mesh(case));
        // At 1 m the two are one shape.
        let same = apart < 1e-9;
        assert_eq!(
            swapped < planar.relative_tolerance,
            same,
            "{stem}: {apart:e}"
        );
        pairs += usize::from(!same);
    }
    assert!(pairs >= 4, "{pairs} pairs");
}

/// Message and place of everything that is wrong with a refused case.
fn refusals(case: &Case, stage: Stage) -> Vec<(String, FilePlace, Option<[f64; 2]>)> {
    match (stage, case.read()) {
        (Stage::Read, Ok(_)) => Vec::new(),
        (Stage::Read, Err(error)) => error
            .problems
            .iter()
            .map(|problem| {
                let place = FilePlace {
                    feature: problem.feature,
                    polygon: problem.polygon,
                    ring: problem.ring,
                    vertex: problem.vertex,
                };
                (problem.to_string(), place, None)
            })
            .collect(),
        (Stage::Mesh, Err(error)) => panic!("{}: refused while reading: {error}", case.name),
        (Stage::Mesh, Ok(regions)) => regions
            .iter()
            .filter_map(|region| build(case, region).err())
            .map(|error| {
                let edge = match &error {
                    MeshError::SelfCrossing { first, .. } | MeshError::Overlap { first, .. } => {
                        Some(*first)
                    }
                    MeshError::OppositeEnds { place, .. } => Some(*place),
                    _ => None,
                };
                let place = FilePlace {
                    feature: error.feature(),
                    polygon: edge.map(|place| place.polygon),
                    ring: edge.map(|place| place.ring),
                    vertex: edge.map(|place| place.vertex),
                };
                let at = match &error {
                    MeshError::SelfCrossing {
                        longitude_deg,
                        latitude_deg,
                        ..
                    } => Some([*longitude_deg, *latitude_deg]),
                    _ => None,
                };
                (error.to_string(), place, at)
            })
            .collect(),
    }
}

/// Whether the words stand in the message in this order.
fn says(message: &str, parts: &[String]) -> bool {
    let mut rest = message;
    parts.iter().all(|part| match rest.find(part.as_str()) {
        Some(at) => {
            rest = &rest[at + part.len()..];
            true
        }
        None => false,
    })
}

/// Whether every index that is expected is found.
fn points_at(found: FilePlace, expected: FilePlace) -> bool {
    let fits =
        |found: Option<usize>, expected: Option<usize>| expected.is_none() || found == expected;
    fits(found.feature, expected.feature)
        && fits(found.polygon, expected.polygon)
        && fits(found.ring, expected.ring)
        && fits(found.vertex, expected.vertex)
}

fn is_refused_as_expected(case: &Case, refusal: &Refusal) -> Result<(), String> {
    let found = refusals(case, refusal.stage);
    let Some((message, place, at)) = found.first() else {
        return Err("accepted".to_owned());
    };
    if message.contains('\n') {
        return Err(format!("not one line: {message}"));
    }
    if !says(message, &refusal.parts) {
        return Err(format!("“{message}” lacks one of {:?}", refusal.parts));
    }
    if !points_at(*place, refusal.place) {
        return Err(format!("{place:?}, not {:?}: “{message}”", refusal.place));
    }
    if let Some(expected) = refusal.at {
        let near = at.is_some_and(|found| {
            (0..2).all(|i| (found[i] - expected[i]).abs() <= CROSSING_TOLERANCE_DEG)
        });
        if !near {
            return Err(format!("crossing at {at:?}, not {expected:?}"));
        }
    }
    let expected = refusal.others.len().max(1);
    if found.len() != expected {
        return Err(format!("{} problems, not {expected}", found.len()));
    }
    for (parts, (message, ..)) in refusal.others.iter().zip(&found) {
        if !says(message, parts) {
            return Err(format!("“{message}” lacks one of {parts:?}"));
        }
    }
    Ok(())
}

fn refused() -> Vec<(Case, Refusal)> {
    let cases: Vec<(Case, Refusal)> = all_cases()
        .into_iter()
        .filter_map(|case| {
            let refusal = case.refusal.clone()?;
            Some((case, refusal))
        })
        .collect();
    assert!(cases.len() >= 40, "only {} are refused", cases.len());
    cases
}

#[test]
fn every_refused_case_says_what_and_where() {
    let wrong: Vec<String> = refused()
        .iter()
        .filter_map(|(case, refusal)| {
            let fault = is_refused_as_expected(case, refusal).err()?;
            Some(format!("{}: {fault}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn in_every_refused_case_another_word_or_place_is_noticed() {
    for (case, refusal) in refused() {
        let check = |change: &dyn Fn(&mut Refusal)| {
            let mut mutant = refusal.clone();
            change(&mut mutant);
            let noticed = is_refused_as_expected(&case, &mutant).is_err();
            assert!(noticed, "{}: {mutant:?}", case.name);
        };
        check(&|mutant| mutant.parts[0].push('#'));
        check(&|mutant| mutant.others = vec![Vec::new(); mutant.others.len().max(1) + 1]);
        if refusal.place != FilePlace::default() {
            check(&|mutant| {
                let place = &mut mutant.place;
                let innermost = [
                    &mut place.vertex,
                    &mut place.ring,
                    &mut place.polygon,
                    &mut place.feature,
                ]
                .into_iter()
                .find_map(Option::as_mut);
                *innermost.expect("a place") += 1;
            });
        }
        if refusal.at.is_some() {
            check(&|mutant| mutant.at = mutant.at.map(|[x, y]| [x, y + 1e-6]));
        }
    }
    // An accepted case is not taken for a refused one.
    let (_, refusal) = refused().remove(0);
    assert!(is_refused_as_expected(&accepted()[0], &refusal).is_err());
}

#[test]
fn the_table_lists_every_case_and_no_other() {
    let text = include_str!("EDGE_CASES.md");
    let listed: BTreeSet<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next())
        .collect();
    let cases = all_cases();
    let named: BTreeSet<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(named.len(), cases.len(), "names are unique");
    assert_eq!(listed, named);
    for case in accepted() {
        let start = format!("| `{}` ", case.name);
        let line = text.lines().find(|line| line.starts_with(&start));
        let area: Option<f64> = line
            .and_then(|line| line.split('|').nth(5))
            .and_then(|cell| cell.trim().parse().ok());
        let near = area.is_some_and(|area| (area / case.area_m2 - 1.0).abs() < 1e-8);
        assert!(near, "{}: {area:?} is not {}", case.name, case.area_m2);
    }
}

#[test]
fn a_hole_may_lie_in_the_other_hemisphere_than_the_pole_its_shell_holds() {
    // Six arcs round the axis, from 20° north to 10° south and back: mostly north, so they hold the
    // north pole. South of the equator they still hold the hole.
    let shell = "[[0,20],[60,-10],[120,20],[180,-10],[240,20],[300,-10]]";
    let hole = "[[58,-4],[62,-4],[60,-2]]";
    let outside = "[[58,-20],[62,-20],[60,-15]]";
    for rule in [
        terrafill_core::EdgeRule::GreatEllipse,
        terrafill_core::EdgeRule::Planar,
    ] {
        let body = terrafill_core::Ellipsoid::WGS84;
        // By jumps at ±180 where longitudes are read as they stand.
        let build = |rings: &[&str], repaired: bool| {
            let text = format!("[{}]", rings.join(","));
            let mut region = region(&text.replace("[300,-10]]", "[300,-10],[360,20]]"));
            if repaired {
                assert_eq!(region.split_at_crossings(rule), 0);
            }
            let mesh = RegionMesh::build(&region, &body, rule, &MeshOptions::default())?;
            assert_eq!(mesh.check_invariants(&body), Ok(()));
            Ok(mesh.area_m2)
        };
        let area_m2 = |rings: &[&str]| -> f64 { build(rings, false).expect("meshes") };
        let (whole, small) = (area_m2(&[shell]), area_m2(&[hole]));
        // More than what is north of 20°, less than what is north of 10° south.
        let north_of = |latitude_deg: f64| {
            body.quadrangle_area_m2(
                std::f64::consts::TAU,
                latitude_deg.to_radians(),
                std::f64::consts::FRAC_PI_2,
            )
        };
        assert!((north_of(20.0)..north_of(-10.0)).contains(&whole));
        let holed = area_m2(&[shell, hole]);
        assert!(
            ((whole - holed) / small - 1.0).abs() < 1e-6,
            "{}",
            rule.name()
        );
        // Negative control: south of the shell's edge the same ring is refused; filled by the even-odd rule it
        // adds its area.
        let refused: Result<f64, MeshError> = build(&[shell, outside], false);
        let refused = refused.expect_err("outside").to_string();
        assert!(refused.contains("ring 1 is a hole outside"), "{refused}");
        let added = build(&[shell, outside], true).expect("repaired") - whole;
        assert!((added / area_m2(&[outside]) - 1.0).abs() < 1e-6);
    }
}
