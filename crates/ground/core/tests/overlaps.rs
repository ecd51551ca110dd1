// SPDX-License-Identifier: MIT OR Apache-2.0
//! Parts of a region that lie over one another: refused with their place, filled when asked for,
//! and never seen where parts only touch, share edges or lie in one another's holes.

use crate::outlines::RULES;
use std::f64::consts::FRAC_PI_2;
use terrafill_core::{EdgeRule, Ellipsoid, MeshError, MeshOptions, Region, RegionMesh, Repair};
use terrafill_fixtures::region;

fn ring([west, south, east, north]: [f64; 4]) -> String {
    format!(
        "[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]"
    )
}

/// Polygons, each a shell and its holes.
fn boxes(polygons: &[&[[f64; 4]]]) -> Region {
    let polygons = polygons.iter().map(|rings| {
        let rings: Vec<String> = rings.iter().map(|sides| ring(*sides)).collect();
        format!("[{}]", rings.join(","))
    });
    region(&format!("[{}]", polygons.collect::<Vec<_>>().join(",")))
}

fn build(region: &Region, rule: EdgeRule) -> Result<RegionMesh, Vec<MeshError>> {
    let body = Ellipsoid::WGS84;
    let regions = std::slice::from_ref(region);
    let mut meshes = RegionMesh::build_all(regions, &body, rule, &MeshOptions::default())?;
    assert_eq!(meshes[0].check_invariants(&body), Ok(()));
    Ok(meshes.remove(0))
}

fn area([west, south, east, north]: [f64; 4]) -> f64 {
    let width = (east - west).to_radians();
    Ellipsoid::WGS84.quadrangle_area_m2(width, south.to_radians(), north.to_radians())
}

const OUTER: [f64; 4] = [0.0, 0.0, 10.0, 10.0];
const INNER: [f64; 4] = [2.0, 2.0, 8.0, 8.0];

#[test]
fn a_part_inside_another_is_refused_with_its_place_or_filled_by_even_odd() {
    for rule in RULES {
        let nested = boxes(&[&[OUTER], &[INNER]]);
        let errors = build(&nested, rule).expect_err("nested");
        let [
            MeshError::Overlap {
                first,
                second,
                longitude_deg,
                latitude_deg,
                ..
            },
        ] = &errors[..]
        else {
            panic!("{errors:?}");
        };
        assert_eq!((first.polygon, first.ring), (0, 0));
        assert_eq!((second.polygon, second.ring), (1, 0));
        assert!((2.0..8.0).contains(longitude_deg) && (2.0..8.0).contains(latitude_deg));
        let said = errors[0].to_string();
        assert!(
            said.contains("polygon 0 and polygon 1 overlap at longitude"),
            "{said}"
        );
        let mut repaired = nested.clone();
        assert_eq!(repaired.split_at_crossings(rule), 0);
        let mesh = build(&repaired, rule).expect("repaired");
        let [listed, areas] = &mesh.warnings[..] else {
            panic!("{:?}", mesh.warnings);
        };
        assert_eq!(*listed, "1 overlap of parts: filled by the even-odd rule");
        assert!(areas.text.starts_with("area as repaired "), "{areas}");
        if rule == EdgeRule::Planar {
            assert!((mesh.area_m2 / (area(OUTER) - area(INNER)) - 1.0).abs() < 1e-12);
        }
        // Negative control: as a hole it is what it looks like, and so is an island in that hole.
        let island = [4.0, 4.0, 6.0, 6.0];
        for valid in [
            boxes(&[&[OUTER, INNER]]),
            boxes(&[&[OUTER, INNER], &[island]]),
        ] {
            assert_eq!(build(&valid, rule).expect("valid").warnings, [""; 0]);
        }
        // The island's own island is in the island.
        let errors = build(
            &boxes(&[&[OUTER, INNER], &[island], &[[4.5, 4.5, 5.0, 5.0]]]),
            rule,
        );
        assert!(matches!(&errors, Err(e) if e.len() == 1), "{errors:?}");
    }
}

#[test]
fn a_hole_outside_its_shell_is_refused_and_one_inside_a_hole_is_an_island() {
    let words = "polygon 0, ring 1 is a hole outside its shell";
    for rule in RULES {
        let outside = boxes(&[&[OUTER, [20.0, 0.0, 21.0, 1.0]]]);
        let errors = build(&outside, rule).expect_err(words);
        assert!(errors[0].to_string().contains(words), "{}", errors[0]);
        let mut repaired = outside.clone();
        repaired.split_at_crossings(rule);
        // What was filled, and the area before and after.
        assert_eq!(build(&repaired, rule).expect("repaired").warnings.len(), 2);
    }
    // Negative control: inside its shell, and inside a hole of it, where it is an island.
    let island = [4.0, 4.0, 6.0, 6.0];
    let mesh = build(&boxes(&[&[OUTER, INNER, island]]), EdgeRule::Planar).expect("an island");
    let exact = area(OUTER) - area(INNER) + area(island);
    assert!((mesh.area_m2 / exact - 1.0).abs() < 1e-12);
}

#[test]
fn parts_that_overlap_where_no_edges_cross_are_found() {
    // Along edges in common, through vertices, as the same ring twice.
    for polygons in [
        [[0.0, 0.0, 2.0, 1.0], [1.0, 0.0, 3.0, 1.0]],
        [[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 1.0, 1.0]],
        [[0.0, 0.0, 2.0, 2.0], [0.0, 0.0, 2.0, 1.0]],
    ] {
        let region = boxes(&[&[polygons[0]], &[polygons[1]]]);
        let error = build(&region, EdgeRule::Planar).expect_err("overlap");
        assert!(matches!(error[0], MeshError::Overlap { .. }), "{error:?}");
    }
    let through_vertices = region(
        "[[[[0,0],[2,0],[4,0],[4,2],[4,4],[2,4],[0,4],[0,2]]],\
         [[[2,-1],[2,0],[2,4],[2,5],[6,5],[6,-1]]]]",
    );
    assert!(build(&through_vertices, EdgeRule::Planar).is_err());
    let twice = boxes(&[&[OUTER], &[INNER], &[INNER]]);
    assert!(build(&twice, EdgeRule::Planar).is_err());
}

#[test]
fn a_small_part_of_a_large_one_is_found() {
    // 123 m² in 10¹⁴ m².
    let small = [5.0, 5.0, 5.000_1, 5.000_1];
    let region = boxes(&[&[[-60.0, -60.0, 60.0, 60.0]], &[small]]);
    assert!(build(&region, EdgeRule::Planar).is_err());
    // Negative control: beside it.
    let beside = boxes(&[&[[-60.0, -60.0, 4.0, 60.0]], &[small]]);
    assert!(build(&beside, EdgeRule::Planar).is_ok());
}

#[test]
fn parts_that_touch_or_share_edges_do_not_overlap() {
    for rule in RULES {
        let corner = boxes(&[&[[0.0, 0.0, 1.0, 1.0]], &[[1.0, 1.0, 2.0, 2.0]]]);
        assert_eq!(build(&corner, rule).expect("touch").warnings, [""; 0]);
        let wall = boxes(&[&[[0.0, 0.0, 1.0, 1.0]], &[[1.0, 0.0, 2.0, 1.0]]]);
        let mesh = build(&wall, rule).expect("share an edge");
        assert_eq!(mesh.warnings, ["1 edge shared by parts: no boundary there"]);
        // Negative control: a degree apart nothing is shared.
        let apart = boxes(&[&[[0.0, 0.0, 1.0, 1.0]], &[[2.0, 0.0, 3.0, 1.0]]]);
        assert_eq!(build(&apart, rule).expect("apart").warnings, [""; 0]);
    }
}

#[test]
fn parts_and_holes_are_told_apart_across_the_antimeridian_and_at_poles() {
    let across = [170.0, 0.0, 190.0, 20.0];
    let within = [175.0, 5.0, 185.0, 15.0];
    let turned = within.map(|side| if side > 100.0 { side - 360.0 } else { side });
    let cap = "[[-180,60],[180,60],[180,90],[-180,90],[-180,60]]";
    let uncut = "[[0,70],[120,70],[240,70],[360,70]]";
    for inner in [within, turned] {
        assert!(build(&boxes(&[&[across], &[inner]]), EdgeRule::Planar).is_err());
        let hole = build(&boxes(&[&[across, inner]]), EdgeRule::Planar).expect("a hole");
        assert!((hole.area_m2 / (area(across) - area(within)) - 1.0).abs() < 1e-12);
        assert_eq!(hole.warnings, [""; 0]);
    }
    let caps = region(&format!("[[{cap}],[{uncut}]]"));
    assert!(build(&caps, EdgeRule::Planar).is_err());
    let zone = build(&region(&format!("[[{cap},{uncut}]]")), EdgeRule::Planar).expect("a zone");
    let exact = area([0.0, 60.0, 360.0, 70.0]);
    assert!((zone.area_m2 / exact - 1.0).abs() < 1e-12);
    // Negative control: the cap alone is larger.
    let whole = build(&region(&format!("[[{cap}]]")), EdgeRule::Planar).expect("a cap");
    let pole = FRAC_PI_2.to_degrees();
    assert!((whole.area_m2 / area([0.0, 60.0, 360.0, pole]) - 1.0).abs() < 1e-12);
    // A part in the polar zone's hole is an island there; one on the zone is not.
    let island = ring([10.0, 75.0, 20.0, 80.0]);
    let on_zone = ring([10.0, 62.0, 20.0, 65.0]);
    let with = |part: &str| region(&format!("[[{cap},{uncut}],[{part}]]"));
    assert!(build(&with(&island), EdgeRule::Planar).is_ok());
    assert!(build(&with(&on_zone), EdgeRule::Planar).is_err());
}

#[test]
fn a_hole_outside_a_shell_that_goes_round_the_axis_is_refused() {
    let words = "polygon 0, ring 1 is a hole outside its shell at longitude 1";
    let cap = "[[0,60],[120,62],[240,60],[360,60]]";
    let by_jump = "[[-180,60],[-60,62],[60,60],[180,60]]";
    let zone = "[[0,80],[120,80],[240,80],[360,80]]";
    for rule in RULES {
        for shell in [cap, by_jump] {
            let with = |holes: &str| region(&format!("[[{shell},{holes}]]"));
            for outside in [[10.0, 20.0, 20.0, 40.0], [10.0, -70.0, 20.0, -60.0]] {
                let hole = with(&ring(outside));
                let errors = build(&hole, rule).map(|mesh| mesh.area_m2);
                let errors = errors.expect_err(words);
                assert!(errors[0].to_string().contains(words), "{}", errors[0]);
                let mut repaired = hole.clone();
                repaired.split_at_crossings(rule);
                assert_eq!(build(&repaired, rule).expect("repaired").warnings.len(), 2);
            }
            // Negative controls: inside; a hole round the pole, alone and with an island in it.
            let inside = ring([10.0, 84.0, 20.0, 86.0]);
            for holes in [&inside, zone, &format!("{zone},{inside}")] {
                assert_eq!(build(&with(holes), rule).expect(holes).warnings, [""; 0]);
            }
        }
    }
    // A hole up to a pole and along a part of it goes no more round than any other.
    for (rule, shell) in RULES
        .into_iter()
        .flat_map(|rule| [(rule, cap), (rule, by_jump)])
    {
        let with = |hole: &str| build(&region(&format!("[[{shell},{hole}]]")), rule);
        let errors = with(&ring([10.0, -90.0, 20.0, -84.0])).map(|mesh| mesh.area_m2);
        let errors = errors.expect_err(words);
        assert!(errors[0].to_string().contains(words), "{}", errors[0]);
        // Negative control: at the pole that the shell holds.
        let inside = ring([10.0, 84.0, 20.0, 90.0]);
        assert_eq!(with(&inside).expect("meshes").warnings, [""; 0]);
    }
    // Of a shell round the axis either side can be meant, so a hole round it lies on neither.
    let other_side =
        region("[[[[0,80],[120,80],[240,80],[360,80]],[[0,60],[120,60],[240,60],[360,60]]]]");
    build(&other_side, EdgeRule::Planar).expect("a zone");
}

#[test]
fn a_union_covers_what_any_part_covers_and_cuts_what_any_hole_of_it_cuts() {
    let joined_as = |region: &Region, repair: Repair, rule: EdgeRule| {
        let mut repaired = region.clone();
        repaired.repair(repair, rule);
        build(&repaired, rule).expect("repaired")
    };
    let assert_area = |mesh: &RegionMesh, exact: f64| {
        let error = (mesh.area_m2 / exact - 1.0).abs();
        assert!(error < 1e-12, "{error:e}: {:?}", mesh.warnings);
    };
    let planar = EdgeRule::Planar;
    let union = |region: &Region| joined_as(region, Repair::Union, planar);
    // Side by side along edges in common, crossing, one in the other, the same twice and three times.
    let [a, b] = [[0.0, 0.0, 2.0, 1.0], [1.0, 0.0, 3.0, 1.0]];
    assert_area(&union(&boxes(&[&[a], &[b]])), area([0.0, 0.0, 3.0, 1.0]));
    let [a, b] = [[0.0, 0.0, 2.0, 2.0], [1.0, 0.5, 3.0, 1.0]];
    let exact = area(a) + area([2.0, 0.5, 3.0, 1.0]);
    assert_area(&union(&boxes(&[&[a], &[b]])), exact);
    assert_area(&union(&boxes(&[&[OUTER], &[INNER]])), area(OUTER));
    assert_area(&union(&boxes(&[&[INNER], &[INNER], &[INNER]])), area(INNER));
    // Holes: the same twice, one in the other, and one that another part covers.
    let cut = area(OUTER) - area(INNER);
    let island = [4.0, 4.0, 6.0, 6.0];
    assert_area(&union(&boxes(&[&[OUTER, INNER, INNER]])), cut);
    assert_area(&union(&boxes(&[&[OUTER, INNER, island]])), cut);
    assert_area(
        &union(&boxes(&[&[OUTER, INNER], &[island], &[island]])),
        cut + area(island),
    );
    // Over the antimeridian, in two turns, where the same rings cancel by parity.
    let [across, turned] = [[170.0, 0.0, 190.0, 20.0], [-190.0, 0.0, -170.0, 20.0]];
    assert_area(&union(&boxes(&[&[across], &[turned]])), area(across));
    let higher = [175.0, 10.0, 185.0, 30.0];
    let exact = area(across) + area([175.0, 20.0, 185.0, 30.0]);
    assert_area(&union(&boxes(&[&[across], &[higher]])), exact);
    assert_area(&union(&boxes(&[&[across], &[higher], &[turned]])), exact);
    // Round a pole.
    let cap = "[[-180,60],[180,60],[180,90],[-180,90],[-180,60]]";
    let caps = region(&format!(
        "[[{cap}],[{cap}],[[[0,70],[120,70],[240,70],[360,70]]]]"
    ));
    let pole = FRAC_PI_2.to_degrees();
    assert_area(&union(&caps), area([0.0, 60.0, 360.0, pole]));
    // Arcs: what is covered twice is covered.
    let arcs = EdgeRule::GreatEllipse;
    let once = build(&boxes(&[&[OUTER]]), arcs).expect("valid");
    let twice = joined_as(&boxes(&[&[OUTER], &[OUTER], &[INNER]]), Repair::Union, arcs);
    assert_area(&twice, once.area_m2);
    // Shells alone.
    let shells = joined_as(
        &boxes(&[&[OUTER, INNER], &[island]]),
        Repair::KeepShells,
        planar,
    );
    assert_area(&shells, area(OUTER));
    // Negative controls: even-odd empties what is covered twice; what is valid stays as it is.
    let even_odd = joined_as(
        &boxes(&[&[INNER], &[INNER], &[OUTER]]),
        Repair::EvenOdd,
        planar,
    );
    assert_area(&even_odd, area(OUTER));
    let valid = boxes(&[&[OUTER, INNER], &[island]]);
    assert_eq!(
        union(&valid).area_m2,
        build(&valid, planar).expect("valid").area_m2
    );
}

#[test]
fn equal_holes_are_refused_and_a_hole_in_a_hole_is_warned_of() {
    let island = [4.0, 4.0, 6.0, 6.0];
    for rule in RULES {
        let error = build(&boxes(&[&[OUTER, INNER, INNER]]), rule).expect_err("equal holes");
        let words = "polygon 0, rings 1 and 2 are holes over one another at longitude";
        assert!(error[0].to_string().contains(words), "{}", error[0]);
        let nested = build(&boxes(&[&[OUTER, INNER, island]]), rule).expect("an island");
        let words = "polygon 0, ring 2 is a hole in the hole of ring 1: filled as an island";
        assert!(
            nested.warnings[0].text.starts_with(words),
            "{:?}",
            nested.warnings
        );
        // Along an edge in common.
        let half = [2.0, 2.0, 5.0, 8.0];
        let beside = [4.0, 2.0, 7.0, 8.0];
        assert!(build(&boxes(&[&[OUTER, half, beside]]), EdgeRule::Planar).is_err());
        // Negative control: holes apart.
        let apart = build(&boxes(&[&[OUTER, [1.0, 1.0, 2.0, 2.0], island]]), rule);
        assert_eq!(apart.expect("valid").warnings, [""; 0]);
    }
}
