// SPDX-License-Identifier: MIT OR Apache-2.0
//! Replays the fuzz targets' seeds and regressions, and tests their checks: each target must
//! reach all its branches, and each check must notice a wrong outcome.

use std::path::PathBuf;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshError, MeshOptions, Region, RegionFileError, RegionMesh,
    RegionProblem, RegionProblemKind, parse_regions,
};
use terrafill_fixtures::fuzz::bytes::Bytes;
use terrafill_fixtures::fuzz::mesh::Case;
use terrafill_fixtures::fuzz::reached::Reached;
use terrafill_fixtures::fuzz::replay::{Check, assert_replays, inputs, replay};
use terrafill_fixtures::fuzz::{area, geojson, mesh};

#[test]
fn counts_take_the_place_of_those_before() {
    let folder = std::env::temp_dir().join(format!("terrafill-counts-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("writable");
    let path = folder.join("mesh.counters.0");
    let mut reached = Reached::new(mesh::BRANCHES);
    let mut texts = Vec::new();
    for _ in 0..2 {
        reached.execution();
        reached.write(&path).expect("writable");
        texts.push(std::fs::read_to_string(&path).expect("there"));
        assert_eq!(texts.last(), Some(&reached.to_string()));
    }
    assert_ne!(texts[0], texts[1]);
    // What was on its way is not left for the sum over processes to find.
    let left: Vec<PathBuf> = inputs(&folder);
    std::fs::remove_dir_all(&folder).expect("removable");
    assert_eq!(left, [path]);
}

#[test]
fn geojson_corpus_replays_and_reaches_every_branch() {
    assert_replays("geojson", geojson::check, geojson::BRANCHES);
}

#[test]
fn mesh_corpus_replays_and_reaches_every_branch() {
    assert_replays("mesh", mesh::check, mesh::BRANCHES);
}

#[test]
fn an_empty_corpus_a_find_and_a_branch_not_reached_are_noticed() {
    // Negative control of the two above.
    let root = tempfile::tempdir().expect("a folder");
    let mut reached = Reached::new(mesh::BRANCHES);
    let finds = replay(root.path(), "mesh", mesh::check, &mut reached);
    assert_eq!(finds.len(), 2, "both folders are missing: {finds:?}");

    for kind in ["seeds", "regressions"] {
        let folder = root.path().join(kind).join("mesh");
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("zero"), [0]).expect("a file");
    }
    let always: Check = |_, reached| {
        reached.execution();
        Err("found".to_owned())
    };
    let finds = replay(root.path(), "mesh", always, &mut reached);
    assert_eq!(finds.len(), 2);
    assert_eq!(reached.missing().len(), mesh::BRANCHES.len());
    assert!(reached.found().is_empty());
}

// ---- the checks ---------------------------------------------------------------------------------

fn case(polygons: Vec<Vec<Vec<[f64; 2]>>>) -> Case {
    Case {
        polygons,
        body: Ellipsoid::WGS84,
        rule: EdgeRule::Planar,
        options: MeshOptions::default(),
        repair: false,
    }
}

fn rectangle(west: f64, south: f64, east: f64, north: f64) -> Vec<[f64; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north]]
}

fn region(case: &Case) -> Region {
    let text = mesh::text_of(&case.polygons);
    parse_regions(text.as_bytes(), "test")
        .expect("valid")
        .remove(0)
}

fn find(case: &Case, outcome: &Result<RegionMesh, MeshError>) -> Result<(), String> {
    mesh::check_outcome(
        &region(case),
        case,
        outcome,
        &mut Reached::new(mesh::BRANCHES),
    )
}

type Lie = fn(&mut RegionMesh);

#[test]
fn a_mesh_that_lies_is_found_out() {
    let case = case(vec![vec![
        rectangle(0.0, 0.0, 10.0, 10.0),
        rectangle(2.0, 2.0, 3.0, 4.0),
    ]]);
    let right =
        RegionMesh::build(&region(&case), &case.body, case.rule, &case.options).expect("meshes");
    assert_eq!(find(&case, &Ok(right.clone())), Ok(()));
    let lies: [(&str, Lie); 8] = [
        ("area a millionth too large", |mesh| {
            mesh.area_m2 *= 1.000_001;
        }),
        ("area not a number", |mesh| mesh.area_m2 = f64::NAN),
        ("a triangle missing", |mesh| {
            mesh.triangles.pop();
        }),
        ("a triangle turned over", |mesh| {
            mesh.triangles[0].swap(0, 1);
        }),
        ("no hole in the boundary", |mesh| {
            mesh.boundary_loops.pop();
        }),
        ("deviation over the tolerance", |mesh| {
            mesh.boundary_deviation_m = 101.0;
        }),
        ("extent too small", |mesh| mesh.extent.east_deg = 9.0),
        ("a vertex not finite", |mesh| {
            mesh.vertices_ecef[3].x = f64::NAN;
        }),
    ];
    for (what, lie) in lies {
        let mut mesh = right.clone();
        lie(&mut mesh);
        assert!(find(&case, &Ok(mesh)).is_err(), "{what}");
    }
    // The same mesh for other rings: one hole more, and rings that cross.
    let mut other = case.clone();
    other.polygons[0].push(rectangle(5.0, 5.0, 6.0, 6.0));
    assert!(find(&other, &Ok(right.clone())).is_err(), "hole forgotten");
    let mut crossing = case.clone();
    crossing.polygons[0][1] = rectangle(2.0, 2.0, 12.0, 2.2);
    assert!(find(&crossing, &Ok(right)).is_err(), "crossing overlooked");
    // Arcs that cross where their chords do not: the southern one rises to 50.43° in the middle.
    for (latitude, crosses) in [(50.2, true), (50.5, false)] {
        let notch = vec![
            [0.0, 50.0],
            [20.0, 50.0],
            [20.0, 51.0],
            [10.0, latitude],
            [0.0, 51.0],
        ];
        let straight = self::case(vec![vec![notch]]);
        let chords = RegionMesh::build(
            &region(&straight),
            &straight.body,
            straight.rule,
            &straight.options,
        );
        let arcs = Case {
            rule: EdgeRule::GreatEllipse,
            ..straight
        };
        let found = find(&arcs, &chords).expect_err("of another rule");
        assert_eq!(found.contains("edges cross by"), crosses, "{found}");
    }
}

#[test]
fn a_refusal_without_a_reason_is_found_out() {
    let sound = case(vec![vec![rectangle(0.0, 0.0, 10.0, 10.0)]]);
    let bow_tie = case(vec![vec![vec![
        [0.0, 0.0],
        [2.0, 2.0],
        [2.0, 0.0],
        [0.0, 2.0],
    ]]]);
    let refused = |case: &Case| {
        RegionMesh::build(&region(case), &case.body, case.rule, &case.options)
            .expect_err("crosses itself")
    };
    let crossing = refused(&bow_tie);
    assert_eq!(find(&bow_tie, &Err(crossing.clone())), Ok(()));
    let name = || "x".to_owned();
    let opposite = MeshError::OppositeEnds {
        feature: 0,
        name: name(),
        place: terrafill_core::EdgePlace::default(),
        start: [0.0, 0.0],
        end: [10.0, 0.0],
    };
    let option = MeshError::Option {
        option: "cap_step_deg",
        found: 3.0,
        allowed: "0.01 … 30",
    };
    let fault = MeshError::Triangulation {
        feature: 0,
        name: name(),
        message: name(),
    };
    let no_area = MeshError::NoArea {
        feature: 0,
        name: name(),
        long_edges: 0,
    };
    let overlap = MeshError::Overlap {
        feature: 0,
        name: name(),
        first: terrafill_core::EdgePlace::default(),
        second: terrafill_core::EdgePlace::default(),
        longitude_deg: 0.0,
        latitude_deg: 0.0,
    };
    let mut nested = sound.clone();
    nested.polygons.push(vec![rectangle(2.0, 2.0, 4.0, 4.0)]);
    assert_eq!(find(&nested, &Err(refused(&nested))), Ok(()));
    nested.repair = true;
    assert!(find(&nested, &Err(overlap.clone())).is_err(), "repaired");
    for error in [crossing, opposite, option, fault, no_area, overlap] {
        assert!(find(&sound, &Err(error.clone())).is_err(), "{error}");
    }
    // Edges that come together where the refusal says, but at a vertex of both.
    let touching = case(vec![vec![vec![
        [0.0, 0.0],
        [1.0, 1.0],
        [2.0, 2.0],
        [2.0, 0.0],
        [1.0, 1.0],
        [0.0, 2.0],
    ]]]);
    let vertex = |vertex| terrafill_core::EdgePlace {
        vertex,
        ..terrafill_core::EdgePlace::default()
    };
    let feigned = MeshError::SelfCrossing {
        feature: 0,
        name: name(),
        first: vertex(0),
        second: vertex(3),
        longitude_deg: 1.0,
        latitude_deg: 1.0,
    };
    for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
        let touching = Case {
            rule,
            ..touching.clone()
        };
        let said = find(&touching, &Err(feigned.clone())).expect_err("crosses nowhere");
        assert!(said.ends_with("no crossing to repair"), "{said}");
    }
    // A place beside one of the edges.
    for rule in [EdgeRule::Planar, EdgeRule::GreatEllipse] {
        let bow_tie = Case {
            rule,
            ..bow_tie.clone()
        };
        let mut error = refused(&bow_tie);
        assert_eq!(find(&bow_tie, &Err(error.clone())), Ok(()));
        if let MeshError::SelfCrossing { latitude_deg, .. } = &mut error {
            *latitude_deg += 1e-8;
        }
        let said = find(&bow_tie, &Err(error)).expect_err("is not there");
        assert!(said.contains("° from the edge"), "{said}");
    }
    let mut repaired = bow_tie.clone();
    repaired.repair = true;
    let crossing = refused(&bow_tie);
    assert!(
        find(&repaired, &Err(crossing)).is_err(),
        "crosses after repair"
    );
}

#[test]
fn a_reader_that_lies_is_found_out() {
    let text = br#"{"type":"Polygon","coordinates":[[[0,0],[4,0],[4,4],[0,0]]]}"#;
    let checked = |text: &[u8], outcome: &geojson::Outcome| {
        geojson::check_outcome(text, outcome, &mut Reached::new(geojson::BRANCHES))
    };
    let right = parse_regions(text, "fuzz.geojson").expect("valid");
    assert_eq!(checked(text, &Ok(right.clone())), Ok(()));
    assert!(checked(b"{", &Ok(right.clone())).is_err(), "not JSON");
    assert!(checked(text, &Ok(Vec::new())).is_err(), "nothing read");
    let mut twice = right.clone();
    twice.extend(right.clone());
    assert!(checked(text, &Ok(twice)).is_err(), "the same index twice");
    let other = br#"{"type":"Polygon","coordinates":[[[0,0],[4,0],[4,5],[0,0]]]}"#;
    assert!(
        checked(other, &Ok(right.clone())).is_err(),
        "another file's"
    );

    let refused = |kind: RegionProblemKind, readable: Vec<Region>| {
        let problem = RegionProblem {
            line: None,
            feature: Some(0),
            name: None,
            polygon: None,
            ring: None,
            vertex: None,
            kind,
        };
        checked(
            text,
            &Err(RegionFileError {
                file: "fuzz.geojson".to_owned(),
                problems: vec![problem],
                readable,
                warnings: Vec::new(),
            }),
        )
    };
    let beyond = RegionProblemKind::Latitude { found: 91.0 };
    assert_eq!(refused(beyond.clone(), Vec::new()), Ok(()));
    assert!(refused(beyond, right).is_err(), "blamed and readable");
    let within = RegionProblemKind::Latitude { found: 89.0 };
    assert!(refused(within, Vec::new()).is_err(), "within its limits");
}

#[test]
fn area_by_slabs_is_right_by_arithmetic() {
    use std::f64::consts::{PI, TAU};
    let close = |found: f64, exact: f64| {
        assert!(
            (found / exact - 1.0).abs() < 1e-11,
            "{found} is not {exact}"
        );
    };
    for body in Ellipsoid::ALL {
        let zone = |south: f64, north: f64, width: f64| {
            body.quadrangle_area_m2(width.to_radians(), south.to_radians(), north.to_radians())
        };
        let slabs = |paths: &[Vec<[f64; 2]>]| area::even_odd_area_m2(&body, paths);
        // A hole in a square; the same over the antimeridian; the same in two turns.
        for west in [0.0, 175.0, -185.0, 355.0] {
            let shell = rectangle(west, 40.0, west + 10.0, 50.0);
            let hole = rectangle(west + 2.0, 42.0, west + 7.0, 43.0);
            let exact = zone(40.0, 50.0, 10.0) - zone(42.0, 43.0, 5.0);
            close(slabs(&[shell.clone(), hole.clone()]), exact);
            let turned = hole.iter().map(|[x, y]| [x - 360.0, *y]).collect();
            close(slabs(&[shell.clone(), turned]), exact);
            // Negative control: without the hole.
            assert!((slabs(&[shell]) / exact - 1.0).abs() > 1e-3);
        }
        close(
            slabs(&[rectangle(-180.0, -90.0, 180.0, 90.0)]),
            zone(-90.0, 90.0, 360.0),
        );
        close(
            slabs(&[rectangle(10.0, 80.0, 370.0, 90.0)]),
            zone(80.0, 90.0, 360.0),
        );
        // Two finds: an edge across the cut of a ring round the pole, which is as far in the west as in
        // the east. The check took it for an end of the cut, and then for one of its two sides where
        // those were not the same to the last bit.
        for (south, north, to_deg) in [(2.0, 8.0, 180.0), (3.930772794662713, 13.0125, -45.0)] {
            let ring = rectangle(0.0, 1.2, 360.0, 90.0);
            let wedge = vec![[-180.0, south], [180.0, north], [to_deg, south]];
            let alone = slabs(std::slice::from_ref(&wedge));
            close(slabs(&[ring, wedge]), zone(1.2, 90.0, 360.0) - alone);
        }
    }
    // A find: a wedge at the pole in one slab of 2°, and cut into slabs of a sixteenth of that, which
    // leaves 16⁻¹⁰ of what quadrature leaves out.
    let wedge = |slabs: u32| {
        let side = |from: [f64; 2], to: [f64; 2]| {
            (0..slabs).map(move |k| {
                let share = f64::from(k) / f64::from(slabs);
                [0, 1].map(|i| from[i] + (to[i] - from[i]) * share)
            })
        };
        let (tip, east, west) = ([176.9, -88.0], [178.9, -90.0], [171.9, -90.0]);
        let path = side(tip, east).chain(std::iter::once(east));
        let path = path.chain(side(west, tip)).collect();
        area::even_odd_area_m2(&Ellipsoid::SATURN_LIKE, &[path])
    };
    assert!((wedge(1) / wedge(16) - 1.0).abs() < 1e-12);
    // Negative control: a wedge a little narrower.
    let narrower = vec![[176.9, -88.0], [178.9, -90.0], [171.900_000_01, -90.0]];
    let narrower = area::even_odd_area_m2(&Ellipsoid::SATURN_LIKE, &[narrower]);
    assert!((narrower / wedge(16) - 1.0).abs() > 1e-9);
    // A triangle with straight edges on the unit sphere: ∫ (1 − φ/φ₁) Δλ cos φ dφ.
    let found = area::even_odd_area_m2(
        &Ellipsoid::UNIT_SPHERE,
        &[vec![[0.0, 0.0], [90.0, 0.0], [0.0, 90.0]]],
    );
    close(found, PI / 2.0 * (1.0 - (1.0 - 2.0 / PI)));
    assert!(found < TAU);
}

#[test]
fn an_exhausted_input_is_a_complete_one() {
    let case = mesh::decode(&mut Bytes::new(&[]));
    assert_eq!(case.polygons.len(), 1);
    assert_eq!(
        geojson::check(&[geojson::GRAMMAR], &mut Reached::new(geojson::BRANCHES)),
        Ok(())
    );
}

#[test]
fn areas_of_great_ellipses_are_compared_beside_chords_too() {
    // A hole whose tip lies between the side's chord and its arc, 17 m north of it.
    let with_tip = |longitude: f64, latitude: f64| {
        let mut case = case(vec![vec![rectangle(0.0, 0.0, 2.0, 1.0)]]);
        case.polygons[0].push(vec![[longitude, latitude], [0.5, 0.25], [1.5, 0.25]]);
        case.rule = EdgeRule::GreatEllipse;
        case.options.boundary_tolerance_m = 100.0;
        case
    };
    let build =
        |case: &Case| RegionMesh::build(&region(case), &case.body, case.rule, &case.options);
    let checked = |case: &Case, mesh: &Case| {
        let mut reached = Reached::new(mesh::BRANCHES);
        let checked = mesh::check_outcome(&region(case), case, &build(mesh), &mut reached);
        (
            checked,
            reached.found().contains(&"great_ellipse_area_compared"),
        )
    };
    let touching = with_tip(1.0, 1.000_1);
    assert_eq!(checked(&touching, &touching), (Ok(()), true));
    // Negative control: the mesh of another hole, 20 m shorter.
    let (found, _) = checked(&touching, &with_tip(1.0, 0.999_9));
    assert!(found.is_err_and(|find| find.contains("by slabs")));
    // On the chord itself it touches only, and is led past it all the same.
    let on_the_chord = with_tip(1.0, 1.0);
    assert_eq!(checked(&on_the_chord, &on_the_chord), (Ok(()), true));
    let over_the_arc = with_tip(1.0, 1.001);
    assert!(matches!(
        build(&over_the_arc),
        Err(MeshError::SelfCrossing { .. })
    ));
}

#[test]
fn what_is_a_rounding_wide_may_be_nothing_in_one_direction_only() {
    // Slivers of 10⁻¹⁴ degrees between arcs of 6° on the Moon: 4·10⁻⁵ m² one way round, nothing the other.
    let mut slivers = case(vec![
        vec![
            vec![
                [0.0, -33.0],
                [2.561_785_858_124_494_6, -27.087_035_160_046_07],
                [-2.5e-323, -32.999_999_999_999_96],
                [-5e-323, -32.999_999_999_999_915],
                [-3.5e-323, -32.999_999_999_999_98],
                [2.561_785_858_124_493_7, -27.087_035_160_046_085],
            ],
            vec![
                [0.853_928_619_374_831_6, -31.029_011_720_015_355],
                [-3e-323, -32.999_999_999_999_936],
                [0.853_928_619_374_831_3, -31.029_011_720_015_344],
                [-1e-323, -32.999_999_999_999_964],
            ],
        ],
        vec![vec![
            [0.640_446_464_531_123_6, -31.521_758_790_011_52],
            [-3e-323, -32.999_999_999_999_95],
            [0.640_446_464_531_123_4, -31.521_758_790_011_507],
            [-2e-323, -32.999_999_999_999_98],
        ]],
    ]);
    slivers.rule = EdgeRule::GreatEllipse;
    slivers.body = Ellipsoid::MOON;
    slivers.options.boundary_tolerance_m = 179.300_904_887_597_97;
    slivers.options.cap_step_deg = 30.0;
    let outcome = RegionMesh::build(
        &region(&slivers),
        &slivers.body,
        slivers.rule,
        &slivers.options,
    );
    let mut reached = Reached::new(mesh::BRANCHES);
    assert_eq!(
        mesh::compare_with_reversed(&slivers, &outcome, &mut reached),
        Ok(())
    );
    // Negative controls: nothing where there is a square of a metre, and where straight lines are exact.
    let nothing = Err(MeshError::NoArea {
        feature: 0,
        name: String::new(),
        long_edges: 0,
    });
    let mut square = case(vec![vec![rectangle(0.0, 0.0, 3e-5, 3e-5)]]);
    for rule in [EdgeRule::GreatEllipse, EdgeRule::Planar] {
        square.rule = rule;
        assert!(mesh::compare_with_reversed(&square, &nothing, &mut reached).is_err());
    }
    let mut thin = case(vec![vec![rectangle(0.0, 0.0, 1e-14, 1e-14)]]);
    thin.rule = EdgeRule::Planar;
    assert!(mesh::compare_with_reversed(&thin, &nothing, &mut reached).is_err());
}
