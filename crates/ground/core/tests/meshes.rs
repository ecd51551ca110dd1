// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes of shapes whose area and boundary are known by arithmetic, beside those of `edge_cases`.

use crate::outlines::{RULES, assert_sound};
use std::f64::consts::{FRAC_PI_2, TAU};
use terrafill_core::{EdgeRule, Ellipsoid, Extent, MeshError, MeshOptions, Region, RegionMesh};
use terrafill_fixtures::region;

fn mesh_on(body: &Ellipsoid, rule: EdgeRule, region: &Region) -> RegionMesh {
    let mesh = RegionMesh::build(region, body, rule, &MeshOptions::default()).expect("meshes");
    assert_sound(&mesh, body);
    mesh
}

fn mesh(rule: EdgeRule, coordinates: &str) -> RegionMesh {
    mesh_on(&Ellipsoid::WGS84, rule, &region(coordinates))
}

/// Exact area between two parallels and two meridians.
fn quadrangle(west: f64, south: f64, east: f64, north: f64) -> f64 {
    Ellipsoid::WGS84.quadrangle_area_m2(
        (east - west).to_radians(),
        south.to_radians(),
        north.to_radians(),
    )
}

fn assert_close(found: f64, exact: f64, tolerance: f64) {
    let error = (found / exact - 1.0).abs();
    assert!(error < tolerance, "{found} is not {exact}: {error:e}");
}

fn rectangle(west: f64, south: f64, east: f64, north: f64) -> String {
    format!(
        "[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]"
    )
}

#[test]
fn a_square_degree_has_the_closed_form_area_either_winding() {
    let exact = quadrangle(10.0, 45.0, 11.0, 46.0);
    let there = mesh(
        EdgeRule::Planar,
        &format!("[{}]", rectangle(10.0, 45.0, 11.0, 46.0)),
    );
    let back = mesh(EdgeRule::Planar, "[[[10,45],[10,46],[11,46],[11,45]]]");
    for mesh in [&there, &back] {
        assert_close(mesh.area_m2, exact, 1e-12);
        assert_eq!(mesh.boundary_loops.len(), 1);
        let extent = Extent {
            west_deg: 10.0,
            south_deg: 45.0,
            east_deg: 11.0,
            north_deg: 46.0,
        };
        assert_eq!(mesh.extent, extent);
        assert_eq!(mesh.holes, 0);
    }
    assert_eq!(there.vertex_count(), back.vertex_count());
    // The rule matters: great ellipses rise north of the parallels, the northern one more.
    let arcs = mesh(
        EdgeRule::GreatEllipse,
        &format!("[{}]", rectangle(10.0, 45.0, 11.0, 46.0)),
    );
    let difference = (arcs.area_m2 / exact - 1.0).abs();
    assert!(difference > 1e-6 && difference < 1e-3, "{difference}");
}

#[test]
fn a_hole_may_touch_its_shell_at_a_vertex_or_on_an_edge() {
    let exact = quadrangle(0.0, 0.0, 4.0, 4.0);
    // At the corner (0, 0); on the southern edge at (2, 0), which is no vertex of the shell.
    for hole in ["[[0,0],[2,1],[1,2]]", "[[2,0],[3,1],[1,1]]"] {
        let rings = format!("[{},{hole}]", rectangle(0.0, 0.0, 4.0, 4.0));
        let with_hole = mesh(EdgeRule::Planar, &rings);
        let hole_alone = mesh(EdgeRule::Planar, &format!("[{hole}]"));
        assert_close(with_hole.area_m2 + hole_alone.area_m2, exact, 1e-12);
        // The corner of the inside on the left is followed, so the touch does not join the loops
        // into one that crosses itself: each loop passes the vertex once.
        for ring in &with_hole.boundary_loops {
            let mut sorted = ring.clone();
            sorted.sort_unstable();
            sorted.dedup();
            assert!(sorted.len() >= ring.len() - 1);
        }
    }
}

#[test]
fn the_antimeridian_leaves_no_trace() {
    let uncut = "[[[170,10],[190,12],[188,30],[172,28]]]";
    let west = "[[[-190,10],[-170,12],[-172,30],[-188,28]]]";
    // Latitudes where the southern and the northern edge cross: 11 and 29.
    let cut =
        "[[[[170,10],[180,11],[180,29],[172,28]]],[[[-180,11],[-170,12],[-172,30],[-180,29]]]]";
    let meshes = [uncut, west, cut].map(|text| mesh(EdgeRule::Planar, text));
    for mesh in &meshes {
        assert_close(mesh.area_m2, meshes[0].area_m2, 1e-14);
        assert_eq!(mesh.boundary_loops.len(), 1);
        assert_eq!(
            (mesh.extent.west_deg, mesh.extent.east_deg),
            (170.0, -170.0)
        );
    }
    assert_eq!(meshes[0].vertex_count(), meshes[1].vertex_count());
    assert_eq!(meshes[0].area_m2, meshes[1].area_m2);
    // The same ring 20° further west, where nothing is cut.
    let moved = mesh(EdgeRule::Planar, "[[[150,10],[170,12],[168,30],[152,28]]]");
    assert_close(meshes[0].area_m2, moved.area_m2, 1e-13);
    // Great ellipses are cut at another latitude; written 179 → −179 they take the short way.
    let arcs = mesh(EdgeRule::GreatEllipse, uncut);
    let short = mesh(
        EdgeRule::GreatEllipse,
        "[[[170,10],[-170,12],[-172,30],[172,28]]]",
    );
    let away = mesh(
        EdgeRule::GreatEllipse,
        "[[[150,10],[170,12],[168,30],[152,28]]]",
    );
    assert_eq!(arcs.area_m2, short.area_m2);
    assert_close(arcs.area_m2, away.area_m2, 1e-12);
    // Planar, the same numbers go the long way round: another region.
    let long = mesh(
        EdgeRule::Planar,
        "[[[170,10],[-170,12],[-172,30],[172,28]]]",
    );
    assert!(long.area_m2 > 10.0 * meshes[0].area_m2);
}

#[test]
fn a_cap_round_a_pole_has_the_closed_form_area_however_it_is_written() {
    let cap = |body: &Ellipsoid| body.quadrangle_area_m2(TAU, 80_f64.to_radians(), FRAC_PI_2);
    for text in [
        "[[[0,80],[120,80],[240,80],[360,80]]]",
        "[[[-180,80],[-90,80],[0,80],[90,80],[180,80],[-180,80]]]",
        "[[[180,80],[90,80],[0,80],[-90,80],[-180,80],[180,80]]]",
        "[[[-180,80],[0,80],[180,80],[180,90],[-180,90],[-180,80]]]",
    ] {
        for sign in [1.0, -1.0] {
            let text = if sign < 0.0 {
                text.replace("80]", "-80]")
                    .replace("90]", "-90]")
                    .replace(",80", ",-80")
            } else {
                text.to_owned()
            };
            let region = region(&text.replace("--", "-"));
            for body in Ellipsoid::ALL {
                let mesh = mesh_on(&body, EdgeRule::Planar, &region);
                assert_close(mesh.area_m2, cap(&body), 1e-12);
                assert_eq!(mesh.boundary_loops.len(), 1, "{text} {}", body.name());
                let poles = mesh.vertices_deg.iter().filter(|v| v[1] == 90.0 * sign);
                assert_eq!(poles.count(), 1);
                assert_eq!(
                    (mesh.extent.west_deg, mesh.extent.east_deg),
                    (-180.0, 180.0)
                );
            }
        }
    }
}

#[test]
fn a_globe_has_no_border_and_a_band_that_ends_has_its_extent() {
    let whole = mesh(
        EdgeRule::Planar,
        "[[[-180,-90],[180,-90],[180,90],[-180,90],[-180,-90]]]",
    );
    let euler = whole.vertex_count() as i64 - 3 * whole.triangle_count() as i64 / 2
        + whole.triangle_count() as i64;
    assert_eq!(euler, 2, "a closed surface without handles");
    let almost = mesh(
        EdgeRule::Planar,
        "[[[0.5,-10],[359.5,-10],[359.5,10],[0.5,10]]]",
    );
    assert_eq!(
        (almost.extent.west_deg, almost.extent.east_deg),
        (0.5, -0.5)
    );
}

/// Vertices of the two edges that cross, and where.
fn crossing(text: &str, rule: EdgeRule) -> ([usize; 2], [f64; 2]) {
    let options = MeshOptions::default();
    match RegionMesh::build(&region(text), &Ellipsoid::WGS84, rule, &options) {
        Err(MeshError::SelfCrossing {
            first,
            second,
            longitude_deg,
            latitude_deg,
            ..
        }) => ([first.vertex, second.vertex], [longitude_deg, latitude_deg]),
        other => panic!(
            "{text} by {}: {:?}",
            rule.name(),
            other.map(|mesh| mesh.area_m2)
        ),
    }
}

#[test]
fn a_bow_tie_is_refused_with_its_crossing() {
    let text = "[[[0,0],[2,2],[2,0],[0,2],[0,0]]]";
    for rule in RULES {
        let (vertices, at) = crossing(text, rule);
        assert_eq!(vertices, [0, 2]);
        assert!(at.iter().all(|degrees| (degrees - 1.0).abs() < 1e-3));
    }
    let bow_tie = region(text);
    let all = RegionMesh::build_all(
        &[bow_tie.clone(), region("[[[0,0],[1,0],[0,1]]]"), bow_tie],
        &Ellipsoid::WGS84,
        EdgeRule::Planar,
        &MeshOptions::default(),
    );
    let errors = all.expect_err("two of three");
    assert_eq!(errors.len(), 2);
    assert_eq!(
        errors[0].to_string(),
        "feature 0: the edge from polygon 0, ring 0, vertex 0 crosses the edge from \
         polygon 0, ring 0, vertex 2 at longitude 1.0000000, latitude 1.0000000"
    );
}

#[test]
fn edges_that_cross_where_both_are_split_are_refused() {
    // Halved in their middles, the edges of these bow-ties only meet there.
    for (ring, at) in [
        ("[[[0,0],[10,10],[10,0],[0,10]]]", [5.0, 5.0]),
        ("[[[-20,-8],[20,8],[20,-8],[-20,8]]]", [0.0, 0.0]),
        // Halved on the other, which is a meridian.
        ("[[[5,-1],[5,1.5],[10,10],[0,-10]]]", [5.0, 0.0]),
    ] {
        for rule in RULES {
            let (vertices, found) = crossing(ring, rule);
            assert_eq!(vertices, [0, 2]);
            let slack_deg = if rule == EdgeRule::Planar { 1e-12 } else { 0.1 };
            assert!((0..2).all(|axis| (found[axis] - at[axis]).abs() < slack_deg));
            let mut repaired = region(ring);
            assert!(repaired.split_at_crossings(rule) > 0);
            mesh_on(&Ellipsoid::WGS84, rule, &repaired);
        }
    }
    // Negative control: parts that share an edge split it at the same places, and touch.
    let neighbours = "[[[[0,0],[10,10],[10,0]]],[[[0,0],[10,10],[0,10]]]]";
    for rule in RULES {
        assert_eq!(mesh(rule, neighbours).boundary_loops.len(), 1);
    }
}

#[test]
fn a_crossing_is_placed_as_the_file_counts() {
    let ring = "[[[0,0],[0,0],[2,2],[2,0],[0,3],[0,0]]]";
    let places = |ring| crossing(ring, EdgeRule::Planar).0;
    assert_eq!(places(ring), [1, 3]);
    assert_eq!(
        places("[[[0,0],[2,2],[2,0],[2,0],[2,0],[0,3],[0,0]]]"),
        [0, 4]
    );
    // Negative control: nothing repeated, nothing added.
    assert_eq!(places("[[[0,0],[2,2],[2,0],[0,3],[0,0]]]"), [0, 2]);
    // Round a pole, where the closing edge is a jump.
    assert_eq!(
        places("[[[-180,60],[-180,60],[-90,60],[20,60],[20,70],[0,50],[180,60],[-180,60]]]"),
        [2, 4]
    );
}

#[test]
fn what_cannot_be_meshed_is_refused() {
    let build = |text: &str, rule, options: &MeshOptions| {
        RegionMesh::build(&region(text), &Ellipsoid::WGS84, rule, options)
            .expect_err("refused")
            .to_string()
    };
    let options = MeshOptions::default();
    assert_eq!(
        build("[[[0,0],[1,0],[2,0]]]", EdgeRule::Planar, &options),
        "feature 0: the rings enclose no area"
    );
    assert_eq!(
        build(
            "[[[0,10],[180,-10],[90,0]]]",
            EdgeRule::GreatEllipse,
            &options
        ),
        "feature 0: the great-ellipse edge from polygon 0, ring 0, vertex 0 joins the \
         opposite points [0.0, 10.0] and [180.0, -10.0], allowed: over 1e-9 rad from opposite; put a \
         vertex between them"
    );
    let coarse = MeshOptions {
        cap_step_deg: 31.0,
        ..options
    };
    assert_eq!(
        build("[[[0,0],[1,0],[0,1]]]", EdgeRule::Planar, &coarse),
        "cap_step_deg is 31; allowed is 0.01 … 30"
    );
    let loose = MeshOptions {
        boundary_tolerance_m: f64::NAN,
        ..options
    };
    assert_eq!(
        build("[[[0,0],[1,0],[0,1]]]", EdgeRule::Planar, &loose),
        "boundary_tolerance_m is NaN; allowed is above 0 and finite"
    );
}

#[test]
fn the_boundary_stays_within_its_tolerance() {
    // Independent of the splitter: points of the true edge against the great circle through the two
    // mesh vertices either side.
    let body = Ellipsoid::UNIT_SPHERE;
    let region = region("[[[0,50],[40,60],[20,30]]]");
    for tolerance in [1e-3, 1e-5] {
        let options = MeshOptions {
            boundary_tolerance_m: tolerance,
            cap_step_deg: 10.0,
        };
        let mesh = RegionMesh::build(&region, &body, EdgeRule::Planar, &options).expect("meshes");
        assert_sound(&mesh, &body);
        let mut worst = 0.0_f64;
        for ring in &mesh.boundary_loops {
            for (i, &from) in ring.iter().enumerate() {
                let to = ring[(i + 1) % ring.len()];
                let [a, b] = [from, to].map(|k| mesh.vertices_ecef[k as usize]);
                let [p, q] = [from, to].map(|k| mesh.vertices_deg[k as usize]);
                let wall = a.cross(b).normalize();
                for step in 1..16 {
                    let t = f64::from(step) / 16.0;
                    let [lon, lat] = [0, 1].map(|k| (p[k] + (q[k] - p[k]) * t).to_radians());
                    worst = worst.max(wall.dot(body.geodetic_surface_normal(lon, lat)).abs());
                }
            }
        }
        assert!(worst <= 1.02 * tolerance, "{worst} over {tolerance}");
        assert!(
            worst > 0.2 * tolerance,
            "far finer than asked: {worst} for {tolerance}"
        );
        assert!(mesh.boundary_deviation_m <= tolerance);
        assert!((mesh.boundary_deviation_m / worst - 1.0).abs() < 0.1);
    }
}

#[test]
fn raised_caps_stay_above_the_terrain() {
    let shapes = [
        "[[[-180,-90],[180,-90],[180,90],[-180,90]]]",
        "[[[0,0],[40,5],[35,50],[-5,40]]]",
    ];
    for body in [
        Ellipsoid::WGS84,
        Ellipsoid::SATURN_LIKE,
        Ellipsoid::ASTEROID_250M,
    ] {
        for cap_step_deg in [3.0, 10.0] {
            for shape in shapes {
                let options = MeshOptions {
                    boundary_tolerance_m: 1000.0,
                    cap_step_deg,
                };
                let mesh = RegionMesh::build(&region(shape), &body, EdgeRule::Planar, &options)
                    .expect("meshes");
                let highest_m = 1.4e-3 * body.equatorial_radius_m();
                let top_m = mesh.volume_heights(-highest_m, highest_m).top_m;
                let raise = |height_m: f64| lowest_of_cap(&body, &mesh, height_m);
                let lowest = raise(top_m);
                assert!(
                    lowest > highest_m,
                    "{} {cap_step_deg} {shape}: {lowest}",
                    body.name()
                );
                // Negative control: without the sagitta the facets do hang through.
                assert!(raise(highest_m) < highest_m);
                // And the bound is no more than three times what is needed.
                assert!(highest_m - raise(highest_m) > mesh.cap_sagitta_m / 3.0);
            }
        }
    }
}

#[test]
fn no_facet_hangs_deeper_than_its_step_allows() {
    let shapes = [
        "[[[-180,-90],[180,-90],[180,90],[-180,90]]]",
        "[[[0,0],[40,5],[35,50],[-5,40]]]",
        "[[[-180,60],[180,60],[180,90],[-180,90]]]",
        "[[[170,-30],[200,-30],[200,20],[170,25]]]",
        // Thin, so that facets have long sides of the boundary.
        "[[[0,45],[90,46],[90,47],[0,47]]]",
    ];
    for body in [Ellipsoid::WGS84, Ellipsoid::SATURN_LIKE] {
        for rule in RULES {
            let mut deepest_share = 0.0_f64;
            for cap_step_deg in [1.0, 3.0, 10.0, 30.0] {
                let options = MeshOptions {
                    boundary_tolerance_m: 1e-3 * body.equatorial_radius_m(),
                    cap_step_deg,
                };
                let bound_m = options.sagitta_bound_m(&body);
                // Negative control: what it would be if the step bounded the edges inside as well.
                let smaller_m = MeshOptions {
                    cap_step_deg: cap_step_deg / 1.5,
                    ..options
                }
                .sagitta_bound_m(&body);
                for shape in shapes {
                    let Ok(mesh) = RegionMesh::build(&region(shape), &body, rule, &options) else {
                        // A great ellipse cannot go round a parallel.
                        assert_eq!(rule, EdgeRule::GreatEllipse, "{shape}");
                        continue;
                    };
                    let found_m = mesh.cap_sagitta_m;
                    assert!(
                        found_m <= bound_m,
                        "{} {cap_step_deg} {shape}: {found_m} over {bound_m}",
                        body.name()
                    );
                    deepest_share = deepest_share.max(found_m / smaller_m);
                }
            }
            let is_round = body.name() == Ellipsoid::WGS84.name();
            assert!(
                deepest_share > 1.0 || !is_round,
                "never deeper: {deepest_share}"
            );
        }
    }
    // On a sphere, as in the usual estimate with 3/2 of the step.
    let options = MeshOptions {
        cap_step_deg: 1.0,
        ..MeshOptions::default()
    };
    let chord = 1.5_f64.to_radians();
    let estimate = 1.0 - (1.0 - chord * chord / 3.0).sqrt();
    let bound = options.sagitta_bound_m(&Ellipsoid::UNIT_SPHERE);
    assert!((bound / estimate - 1.0).abs() < 1e-9, "{bound} {estimate}");
}

/// Lowest height of the cap raised to `height_m`, sampled over every facet.
fn lowest_of_cap(body: &Ellipsoid, mesh: &RegionMesh, height_m: f64) -> f64 {
    let mut lowest = f64::INFINITY;
    for triangle in &mesh.triangles {
        let corners = triangle.map(|i| {
            let [lon, lat] = mesh.vertices_deg[i as usize].map(f64::to_radians);
            mesh.vertices_ecef[i as usize] + body.geodetic_surface_normal(lon, lat) * height_m
        });
        for i in 0..=6 {
            for j in 0..=6 - i {
                let (u, v) = (f64::from(i) / 6.0, f64::from(j) / 6.0);
                let point = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                lowest = lowest.min(body.ecef_to_geodetic(point).height_m);
            }
        }
    }
    lowest
}

#[test]
fn broken_meshes_are_caught() {
    let body = Ellipsoid::WGS84;
    let sound = mesh(
        EdgeRule::Planar,
        "[[[0,40],[20,40],[20,60],[0,60]],[[5,45],[15,45],[15,55],[5,55]]]",
    );
    type Break<'a> = &'a dyn Fn(&mut RegionMesh);
    let broken: [(&str, Break); 9] = [
        ("OpenEdge", &|mesh| mesh.triangles[7].swap(1, 2)),
        ("Inverted", &|mesh| {
            mesh.triangles
                .iter_mut()
                .for_each(|triangle| triangle.swap(1, 2));
            mesh.boundary_loops
                .iter_mut()
                .for_each(|ring| ring.reverse());
        }),
        ("OpenEdge", &|mesh| {
            mesh.triangles.pop();
        }),
        ("OpenEdge", &|mesh| mesh.boundary_loops.truncate(1)),
        ("OffSurface", &|mesh| mesh.vertices_ecef[3].x += 1e-3),
        // A boundary vertex moved along the surface, consistently: only the area tells.
        ("Area", &|mesh| {
            let vertex = mesh.boundary_loops[0][1] as usize;
            // Both ways, since a vertex on a meridian may slide along it.
            mesh.vertices_deg[vertex][0] += 1e-4;
            mesh.vertices_deg[vertex][1] += 1e-4;
            let [lon, lat] = mesh.vertices_deg[vertex];
            mesh.vertices_ecef[vertex] =
                body.geodetic_to_ecef(terrafill_core::Geodetic::from_degrees(lon, lat, 0.0));
        }),
        ("Area", &|mesh| mesh.area_m2 *= 1.0 + 1e-7),
        ("Degenerate", &|mesh| {
            mesh.triangles[0][1] = mesh.triangles[0][0];
        }),
        ("Index", &|mesh| mesh.triangles[0][1] = 1 << 20),
    ];
    for (kind, change) in broken {
        let mut mesh = sound.clone();
        change(&mut mesh);
        let violation = mesh.check_invariants(&body).expect_err(kind);
        let said = format!("{violation:?}");
        assert!(said.starts_with(kind), "{said} is not {kind}");
    }
}

#[test]
fn very_many_rings_at_one_vertex_are_followed() {
    // Triangles like petals round one vertex. Were the work the square of their number, this would run
    // into the limit on the time of a test.
    let petals = 50_000_u32;
    let parts: Vec<String> = (0..petals)
        .map(|k| {
            let at = |k: f64| {
                let angle = std::f64::consts::TAU * k / f64::from(petals);
                format!("[{},{}]", 0.3 * angle.cos(), 0.3 * angle.sin())
            };
            let (from, to) = (at(f64::from(k)), at(f64::from(k) + 0.5));
            format!("[[[0,0],{from},{to},[0,0]]]")
        })
        .collect();
    let body = Ellipsoid::WGS84;
    let region = region(&format!("[{}]", parts.join(",")));
    let mesh = RegionMesh::build(&region, &body, EdgeRule::Planar, &MeshOptions::default());
    let mesh = mesh.expect("meshes");
    assert_eq!(mesh.check_invariants(&body), Ok(()));
    assert_eq!(mesh.boundary_edge_count(), 3 * petals as usize);
}
