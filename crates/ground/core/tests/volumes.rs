// SPDX-License-Identifier: MIT OR Apache-2.0
//! The closed solid of a mesh: sound for real outlines and hard shapes, and every way of breaking it
//! noticed under its own name.

use crate::outlines::{RULES, outline};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use terrafill_core::{
    EdgeRule, Ellipsoid, MeshOptions, Region, RegionMesh, VolumeHeights, parse_regions,
};
use terrafill_fixtures::{
    RegionVolume, VolumeFault, VolumePart, VolumeReport, check_extruded, check_volume, region,
    terrain_heights as heights,
};

fn mesh_on(body: &Ellipsoid, rule: EdgeRule, coordinates: &str) -> RegionMesh {
    RegionMesh::build(&region(coordinates), body, rule, &MeshOptions::default()).expect("meshes")
}

// ---- real outlines ----------------------------------------------------------------------------

/// Checks the volume of every region of a file that meshes; how many do, and how many do not.
fn sound_and_refused(name: &str, rule: EdgeRule) -> (usize, usize) {
    let body = Ellipsoid::WGS84;
    let regions = parse_regions(&outline(name), name).expect("valid");
    let is_meshed = |region: &&Region| {
        let Ok(mesh) = RegionMesh::build(region, &body, rule, &MeshOptions::default()) else {
            return false;
        };
        let fault = check_extruded(&mesh, &body).err();
        assert!(
            fault.is_none(),
            "{name}, {rule:?}, {}: {fault:?}",
            mesh.name
        );
        true
    };
    let sound = regions.par_iter().filter(is_meshed).count();
    (sound, regions.len() - sound)
}

#[test]
#[ignore = "needs data: natural-earth-110m, natural-earth-50m, natural-earth-10m, us-10m"]
fn every_volume_of_the_countries_and_counties_is_sound() {
    // Regions, and those of them that are refused for edges that cross, by either rule.
    for (name, regions, refused) in [
        ("ne_110m_admin_0_countries.geojson", 177, 1),
        ("ne_50m_admin_0_countries.geojson", 241, 0),
        ("ne_10m_admin_0_countries.geojson", 258, 0),
        ("us_counties_10m.geojson", 3_197, 21),
    ] {
        for rule in RULES {
            let found = sound_and_refused(name, rule);
            assert_eq!(found, (regions - refused, refused), "{name}, {rule:?}");
        }
    }
}

// ---- by arithmetic ----------------------------------------------------------------------------

#[track_caller]
fn sound(mesh: &RegionMesh, body: &Ellipsoid) -> VolumeReport {
    check_extruded(mesh, body).unwrap_or_else(|fault| panic!("{fault}"))
}

/// `V − E + F`.
fn euler(report: &VolumeReport) -> i64 {
    let count = |n: usize| i64::try_from(n).expect("small");
    count(report.rounded.vertices) - count(report.edges) + count(report.triangles)
}

const SQUARE: &str = "[[[10,40],[14,40],[14,44],[10,44]]]";
const HOLE: &str = "[[[10,40],[14,40],[14,44],[10,44]],[[11,41],[13,41],[13,43],[11,43]]]";
const HOLE_TOUCHES: &str = "[[[10,40],[14,40],[14,44],[10,44]],[[10,40],[12,41],[11,42]]]";
const CAP: &str = "[[[0,80],[120,80],[240,80],[360,80]]]";
const LUNE: &str = "[[[10,-90],[10,0],[10,90],[40,90],[40,0],[40,-90]]]";
const WEDGES: &str = "[[[[0,80],[10,80],[10,90],[0,90]]],[[[180,80],[190,80],[190,90],[180,90]]]]";
const OVER_180: &str = "[[[170,10],[190,12],[188,30],[172,28]]]";
const BAND: &str = "[[[-180,-10],[180,-10],[180,10],[-180,10],[-180,-10]]]";
const GLOBE: &str = "[[[-180,-90],[180,-90],[180,90],[-180,90],[-180,-90]]]";

#[test]
fn the_surface_has_the_handles_that_the_rings_say() {
    let body = Ellipsoid::WGS84;
    for (shape, expected) in [
        (SQUARE, 2),
        (OVER_180, 2),
        (CAP, 2),
        // As a torus, both.
        (HOLE, 0),
        (BAND, 0),
        // Two spheres, one in the other.
        (GLOBE, 4),
        // The two copies of a vertex are one edge where rings touch, and take part in it once.
        (HOLE_TOUCHES, 1),
    ] {
        let report = sound(&mesh_on(&body, EdgeRule::Planar, shape), &body);
        assert_eq!(euler(&report), expected, "{shape}");
        let touches = usize::from(shape == HOLE_TOUCHES);
        assert_eq!(report.shared_edges, touches, "{shape}");
    }
}

#[test]
fn the_volume_of_a_shell_is_the_closed_form() {
    let body = Ellipsoid::UNIT_SPHERE;
    let mesh = mesh_on(&body, EdgeRule::Planar, GLOBE);
    let heights = heights(&mesh, &body);
    let report = sound(&mesh, &body);
    let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let exact = ball(1.0 + heights.top_m) - ball(1.0 + heights.bottom_m);
    let loss = 1.0 - report.volume_m3 / exact;
    // Facets of 3° circumscribed by the sphere: 5/4 of their sagitta at most, less for the others.
    assert!(loss > 0.0 && loss < 4.0 * mesh.cap_sagitta_m, "{loss}");
    assert!(loss > 0.5 * mesh.cap_sagitta_m, "{loss}");
}

#[test]
fn hard_shapes_are_sound_on_every_body_between_any_heights() {
    for shape in [
        SQUARE,
        HOLE,
        HOLE_TOUCHES,
        CAP,
        LUNE,
        WEDGES,
        OVER_180,
        BAND,
        GLOBE,
    ] {
        for body in Ellipsoid::ALL {
            for rule in RULES {
                let region = region(shape);
                let Ok(mesh) = RegionMesh::build(&region, &body, rule, &MeshOptions::default())
                else {
                    assert_eq!(rule, EdgeRule::GreatEllipse, "{shape}");
                    continue;
                };
                let radius_m = body.equatorial_radius_m();
                for (low, high) in [(-0.002, 0.0015), (0.0, 1e-6), (1e-3, 2e-3), (-0.1, 0.3)] {
                    let heights = VolumeHeights {
                        top_m: high * radius_m,
                        bottom_m: low * radius_m,
                    };
                    if let Err(fault) = check_volume(&mesh, &body, heights) {
                        panic!("{shape}, {}, {rule:?}, {heights:?}: {fault}", body.name());
                    }
                }
            }
        }
    }
}

#[test]
fn a_sliver_beside_an_edge_that_bows_unevenly_is_no_fault() {
    // Found by fuzzing: over 45° of latitude an edge's bow is deepest away from its middle, and a
    // vertex there turned its triangle over by more than the bow in the middle.
    let body = Ellipsoid::SATURN_LIKE;
    let coarse = MeshOptions {
        boundary_tolerance_m: 2.7e10,
        cap_step_deg: 14.0625,
    };
    let shape = "[[[[-49.75,-90],[-19.75,59],[-28.79134740587324,14.094641217499246]]],\
                 [[[10.25,-90],[17.75,-31],[25.25,-90],[72.125,-31],[79.625,-90],[126.5,-31],\
                 [134,-90],[203.375,-90]]]]";
    let mesh = RegionMesh::build(&region(shape), &body, EdgeRule::Planar, &coarse).expect("meshes");
    assert_eq!(mesh.check_invariants(&body), Ok(()));
    assert!(sound(&mesh, &body).turned_over > 0);
}

#[test]
fn an_arc_that_passes_close_by_a_pole_has_its_area() {
    // Found by fuzzing, by the volume alone: 3 mm wide at the pole, 90,000 km long. Quadrature
    // missed the turn of the arc, 4e-8° from the pole, and with it a twentieth of the area.
    let body = Ellipsoid::SATURN_LIKE;
    let shape = "[[[-179.70703125116415,0],[-177.45841980096907,90],\
                 [-175.00000000116438,89.99999995809057]]]";
    let mesh = mesh_on(&body, EdgeRule::GreatEllipse, shape);
    sound(&mesh, &body);
    // d ∫ M N sin φ dφ from the equator to the pole, the arc passing it at d = 6.0025e-11 rad.
    assert!(
        (mesh.area_m2 / 2.340e5 - 1.0).abs() < 2e-3,
        "{}",
        mesh.area_m2
    );
}

#[test]
fn a_square_below_the_rounding_falls_together_and_stays_closed() {
    let body = Ellipsoid::WGS84;
    // 0.1 mm between caps 22 km apart: f32 steps are up to 1 mm there.
    let mesh = mesh_on(
        &body,
        EdgeRule::Planar,
        "[[[10,45],[10.000000001,45],[10.000000001,45.000000001],[10,45.000000001]]]",
    );
    let rounded = sound(&mesh, &body).rounded;
    assert_eq!(rounded.vertices, 8);
    assert!(rounded.positions < 8, "{rounded:?}");
    assert!(rounded.collapsed_triangles > 0, "{rounded:?}");
    assert_eq!(rounded.collapsed_columns, 0);
    // A slab thinner than a step of the numbers loses its walls' height: caps on one another.
    let wide = mesh_on(&body, EdgeRule::Planar, SQUARE);
    let thin = VolumeHeights {
        top_m: 1e-3,
        bottom_m: 0.0,
    };
    let volume = RegionVolume::new(&wide, &body, thin).expect("in range");
    let rounded = volume
        .check_rounded(|_, corner| corner.as_vec3())
        .expect("closed");
    assert!(rounded.collapsed_columns > 0, "{rounded:?}");
}

// ---- what must be noticed ---------------------------------------------------------------------

/// Breaks the volume of each shape in turn at each of its triangles; the fault found must be one of
/// those that `expected` accepts. `change` says whether it applies to the triangle.
fn each_broken(
    shapes: &[&str],
    change: &dyn Fn(&mut RegionVolume<'_>, usize) -> bool,
    expected: &dyn Fn(&VolumeFault) -> bool,
) {
    let body = Ellipsoid::WGS84;
    let mut broken = 0;
    for shape in shapes {
        let mesh = mesh_on(&body, EdgeRule::Planar, shape);
        let whole = RegionVolume::new(&mesh, &body, heights(&mesh, &body)).expect("in range");
        whole.check().unwrap_or_else(|fault| panic!("{fault}"));
        // Every one of small shapes, some of large ones.
        let step = whole.triangles.len().div_ceil(300);
        for index in (0..whole.triangles.len()).step_by(step) {
            let mut mutant = whole.clone();
            if change(&mut mutant, index) {
                let fault = mutant.check().expect_err("must be noticed");
                assert!(expected(&fault), "{shape}, {index}: {fault}");
                broken += 1;
            }
        }
    }
    assert!(broken >= 4, "{broken} broken");
}

const SHAPES: [&str; 5] = [HOLE, HOLE_TOUCHES, CAP, WEDGES, OVER_180];

fn part(volume: &RegionVolume<'_>, index: usize) -> VolumePart {
    volume.triangles[index].part
}

/// Takes a triangle away; whether it is of such a part.
fn missing(is_meant: impl Fn(VolumePart) -> bool) -> impl Fn(&mut RegionVolume<'_>, usize) -> bool {
    move |volume, index| is_meant(volume.triangles.remove(index).part)
}

#[test]
fn a_missing_triangle_is_noticed() {
    // On the boundary the ring misses it first.
    each_broken(
        &SHAPES,
        &missing(|part| part != VolumePart::Wall),
        &|fault| {
            matches!(
                fault,
                VolumeFault::OpenEdge { .. } | VolumeFault::ConstraintMissing { .. }
            )
        },
    );
    // The bottom cap has no ring to miss it.
    each_broken(
        &SHAPES,
        &missing(|part| part == VolumePart::BottomCap),
        &|fault| matches!(fault, VolumeFault::OpenEdge { .. }),
    );
    each_broken(
        &SHAPES,
        &missing(|part| part == VolumePart::Wall),
        &|fault| matches!(fault, VolumeFault::WallCount { .. }),
    );
}

#[test]
fn a_flipped_triangle_is_noticed() {
    each_broken(
        &SHAPES,
        &|volume, index| {
            let triangle = &mut volume.triangles[index];
            triangle.vertices.swap(1, 2);
            triangle.corners_ecef.swap(1, 2);
            triangle.part != VolumePart::TopCap
        },
        &|fault| matches!(fault, VolumeFault::TwistedEdge { .. }),
    );
    each_broken(
        &SHAPES,
        &|volume, index| {
            let triangle = &mut volume.triangles[index];
            triangle.vertices.swap(1, 2);
            triangle.corners_ecef.swap(1, 2);
            triangle.part == VolumePart::TopCap
        },
        &|fault| {
            matches!(
                fault,
                VolumeFault::TwistedEdge { .. } | VolumeFault::ConstraintMissing { .. }
            )
        },
    );
}

#[test]
fn a_wall_that_stands_elsewhere_is_noticed() {
    // One index moved on to the next wall's.
    each_broken(
        &SHAPES,
        &|volume, index| {
            let next = volume.triangles[(index + 2) % volume.triangles.len()];
            let triangle = &mut volume.triangles[index];
            let is_wall = triangle.part == VolumePart::Wall && next.part == VolumePart::Wall;
            triangle.vertices[2] = next.vertices[2];
            triangle.corners_ecef[2] = next.corners_ecef[2];
            is_wall
        },
        &|fault| {
            matches!(
                fault,
                VolumeFault::WallOffBoundary { .. } | VolumeFault::Degenerate { .. }
            )
        },
    );
    // All walls as they should be, but for two that have changed places.
    each_broken(
        &[HOLE],
        &|volume, index| {
            let last = volume.triangles.len() - 1;
            let is_wall = part(volume, index) == VolumePart::Wall && index < last - 1;
            volume.triangles.swap(index, last);
            is_wall
        },
        &|fault| matches!(fault, VolumeFault::WallOffBoundary { .. }),
    );
}

#[test]
fn the_last_bit_of_a_walls_corner_is_noticed() {
    for axis in 0..3 {
        each_broken(
            &SHAPES,
            &|volume, index| {
                let triangle = &mut volume.triangles[index];
                let corner = &mut triangle.corners_ecef[index % 3];
                corner[axis] = corner[axis].next_up();
                triangle.part == VolumePart::Wall
            },
            &|fault| matches!(fault, VolumeFault::Seam { .. }),
        );
    }
}

/// Applies `change` to vertex `vertex` wherever it is.
fn move_everywhere(volume: &mut RegionVolume<'_>, vertex: u32, change: &dyn Fn(&mut DVec3)) {
    for triangle in &mut volume.triangles {
        for (k, corner) in triangle.corners_ecef.iter_mut().enumerate() {
            if triangle.vertices[k] == vertex {
                change(corner);
            }
        }
    }
}

#[test]
fn swapped_heights_and_vertices_out_of_place_are_noticed() {
    let body = Ellipsoid::WGS84;
    let mesh = mesh_on(&body, EdgeRule::Planar, HOLE);
    let VolumeHeights { top_m, bottom_m } = heights(&mesh, &body);
    for (top_m, bottom_m) in [
        (bottom_m, top_m),
        (top_m, top_m),
        (top_m, f64::NAN),
        (f64::INFINITY, bottom_m),
        (top_m, -6.34e6),
    ] {
        let heights = VolumeHeights { top_m, bottom_m };
        let fault = check_volume(&mesh, &body, heights).expect_err("no solid");
        assert!(matches!(fault, VolumeFault::Heights { .. }), "{fault}");
    }
    // The two copies of one vertex exchanged, in every triangle.
    each_broken(
        &[HOLE, OVER_180],
        &|volume, index| {
            let vertex = volume.triangles[index].vertices[0];
            let position = |of: u32| {
                let corner = volume.triangles.iter().find_map(|triangle| {
                    let k = triangle.vertices.iter().position(|v| *v == of)?;
                    Some(triangle.corners_ecef[k])
                });
                corner.expect("used")
            };
            let (here, other) = (position(vertex), position(vertex ^ 1));
            move_everywhere(volume, vertex, &|corner| *corner = other);
            move_everywhere(volume, vertex ^ 1, &|corner| *corner = here);
            true
        },
        &|fault| matches!(fault, VolumeFault::OutOfPlace { .. }),
    );
    // A micrometre, up or aside, in every triangle alike.
    each_broken(
        &[HOLE, CAP],
        &|volume, index| {
            let vertex = volume.triangles[index].vertices[0];
            let axis = index % 3;
            move_everywhere(volume, vertex, &|corner| corner[axis] += 1e-6);
            true
        },
        &|fault| matches!(fault, VolumeFault::OutOfPlace { .. }),
    );
}

#[test]
fn a_triangle_too_many_is_noticed() {
    each_broken(
        &SHAPES,
        &|volume, index| {
            volume.triangles.push(volume.triangles[index]);
            true
        },
        &|fault| matches!(fault, VolumeFault::DuplicateTriangle { .. }),
    );
    // Two back to back: every edge still cancels.
    each_broken(
        &[HOLE, OVER_180],
        &|volume, index| {
            let fin = volume.triangles[index];
            let far = volume
                .triangles
                .iter()
                .find(|other| {
                    let apart = |v: &u32| fin.vertices.iter().all(|w| v / 2 != w / 2);
                    other.part == VolumePart::TopCap && other.vertices.iter().all(apart)
                })
                .copied();
            let Some(far) = far.filter(|_| fin.part == VolumePart::BottomCap) else {
                return false;
            };
            let mut front = fin;
            front.vertices[2] = far.vertices[0];
            front.corners_ecef[2] = far.corners_ecef[0];
            let mut back = front;
            back.vertices.swap(0, 1);
            back.corners_ecef.swap(0, 1);
            volume.triangles.extend([front, back]);
            true
        },
        &|fault| {
            matches!(
                fault,
                VolumeFault::CrowdedEdge { .. } | VolumeFault::Degenerate { .. }
            )
        },
    );
    each_broken(
        &[HOLE],
        &|volume, index| {
            volume.triangles[index].vertices[1] = volume.triangles[index].vertices[0];
            true
        },
        &|fault| matches!(fault, VolumeFault::Degenerate { .. }),
    );
    each_broken(
        &[HOLE],
        &|volume, index| {
            volume.triangles[index].vertices[1] = 1 << 20;
            true
        },
        &|fault| matches!(fault, VolumeFault::Index { .. }),
    );
}

#[test]
fn a_ring_edge_that_triangles_cross_is_noticed() {
    let body = Ellipsoid::WGS84;
    for shape in [HOLE, HOLE_TOUCHES, OVER_180, CAP] {
        let sound = mesh_on(&body, EdgeRule::Planar, shape);
        for (i, ring) in sound.boundary_loops.iter().enumerate() {
            // A ring that leaves a vertex out cuts through the triangles there, or passes by them.
            for k in 0..ring.len() {
                let mut mesh = sound.clone();
                mesh.boundary_loops[i].remove(k);
                let fault = check_extruded(&mesh, &body).expect_err("must be noticed");
                let named = matches!(fault, VolumeFault::ConstraintMissing { .. });
                assert!(named, "{shape}: {fault}");
            }
            // One that is not there at all leaves the caps open.
            let mut mesh = sound.clone();
            mesh.boundary_loops.remove(i);
            let fault = check_extruded(&mesh, &body).expect_err("must be noticed");
            assert!(matches!(fault, VolumeFault::OpenEdge { .. }), "{fault}");
            // And the other way round it has the inside on its right.
            let mut mesh = sound.clone();
            mesh.boundary_loops[i].reverse();
            let fault = check_extruded(&mesh, &body).expect_err("must be noticed");
            let named = matches!(fault, VolumeFault::ConstraintMissing { .. });
            assert!(named, "{shape}: {fault}");
        }
    }
}

#[test]
fn a_volume_turned_inside_out_or_of_another_size_is_noticed() {
    let body = Ellipsoid::WGS84;
    let sound = mesh_on(&body, EdgeRule::Planar, HOLE);
    let fault_of = |mesh: &RegionMesh| check_extruded(mesh, &body).expect_err("must be noticed");
    let mut mesh = sound.clone();
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    for ring in &mut mesh.boundary_loops {
        ring.reverse();
    }
    let fault = fault_of(&mesh);
    assert!(matches!(fault, VolumeFault::Inverted { .. }), "{fault}");
    for factor in [0.98, 1.02] {
        let mut mesh = sound.clone();
        mesh.area_m2 *= factor;
        let fault = fault_of(&mesh);
        let named = matches!(fault, VolumeFault::AreaTimesThickness { .. });
        assert!(named, "{fault}");
    }
    // Two triangles of the bottom cap with their common edge exchanged for the other diagonal: the
    // surface is closed, and every corner where it should be, but the bottom is not the mesh's.
    each_broken(
        &[OVER_180],
        &|volume, index| part(volume, index) == VolumePart::BottomCap && flip_edge(volume, index),
        &|fault| {
            matches!(
                fault,
                VolumeFault::Volume { .. }
                    | VolumeFault::Inverted { .. }
                    | VolumeFault::Degenerate { .. }
            )
        },
    );
    let mesh = mesh_on(&body, EdgeRule::Planar, OVER_180);
    let whole = RegionVolume::new(&mesh, &body, heights(&mesh, &body)).expect("in range");
    let by_volume = (0..whole.triangles.len()).filter(|&index| {
        let mut mutant = whole.clone();
        part(&mutant, index) == VolumePart::BottomCap
            && flip_edge(&mut mutant, index)
            && matches!(mutant.check(), Err(VolumeFault::Volume { .. }))
    });
    assert!(by_volume.count() > 20);
}

/// Exchanges the first edge of a triangle for the other diagonal of it and its neighbour there, if
/// there is one of the same cap.
fn flip_edge(volume: &mut RegionVolume<'_>, index: usize) -> bool {
    let this = volume.triangles[index];
    let [a, b, _] = this.vertices;
    let neighbour = volume.triangles.iter().position(|other| {
        (0..3).any(|k| other.vertices[k] == b && other.vertices[(k + 1) % 3] == a)
    });
    let Some(other) = neighbour.filter(|&i| part(volume, i) == this.part) else {
        return false;
    };
    let across = volume.triangles[other];
    let far = across.vertices.iter().position(|v| *v != a && *v != b);
    let Some(far) = far else { return false };
    // (a, b, c) and (b, a, d) become (a, d, c) and (b, c, d).
    let (d, d_ecef) = (across.vertices[far], across.corners_ecef[far]);
    let mut first = this;
    first.vertices[1] = d;
    first.corners_ecef[1] = d_ecef;
    let mut second = this;
    second.vertices = [b, this.vertices[2], d];
    second.corners_ecef = [this.corners_ecef[1], this.corners_ecef[2], d_ecef];
    volume.triangles[index] = first;
    volume.triangles[other] = second;
    true
}

#[test]
fn walls_rounded_otherwise_than_caps_are_noticed() {
    let body = Ellipsoid::WGS84;
    for shape in SHAPES {
        let mesh = mesh_on(&body, EdgeRule::Planar, shape);
        let volume = RegionVolume::new(&mesh, &body, heights(&mesh, &body)).expect("in range");
        let center = volume.center_ecef();
        let local = |corner: DVec3| (corner - center).as_vec3();
        assert!(volume.check_rounded(|_, corner| local(corner)).is_ok());
        // From another origin; cut off where caps are rounded; one step beside.
        let other_origin = |corner: DVec3| {
            let away = DVec3::splat(12_345.678);
            (corner - center - away).as_vec3() + away.as_vec3()
        };
        let cut_off = |corner: DVec3| {
            let cut = |value: f32| f32::from_bits(value.to_bits() & !1);
            Vec3::from_array(local(corner).to_array().map(cut))
        };
        let beside = |corner: DVec3| Vec3::from_array(local(corner).to_array().map(f32::next_up));
        let mutants: [&dyn Fn(DVec3) -> Vec3; 3] = [&other_origin, &cut_off, &beside];
        for mutant in mutants {
            let fault = volume
                .check_rounded(|part, corner| match part {
                    VolumePart::Wall => mutant(corner),
                    _ => local(corner),
                })
                .expect_err("must be noticed");
            let named = matches!(fault, VolumeFault::OpenAfterRounding { .. });
            assert!(named, "{shape}: {fault}");
        }
        // A triangle that is gone is missed after rounding as well.
        let mut mutant = volume.clone();
        mutant.triangles.pop();
        let fault = mutant
            .check_rounded(|_, corner| local(corner))
            .expect_err("must be noticed");
        let named = matches!(fault, VolumeFault::OpenAfterRounding { .. });
        assert!(named, "{shape}: {fault}");
    }
}

#[test]
fn a_fault_says_where() {
    let body = Ellipsoid::WGS84;
    let mesh = mesh_on(&body, EdgeRule::Planar, SQUARE);
    let mut volume = RegionVolume::new(&mesh, &body, heights(&mesh, &body)).expect("in range");
    let is_bottom = |triangle: &&_| {
        let triangle: &terrafill_fixtures::VolumeTriangle = triangle;
        triangle.part == VolumePart::BottomCap
    };
    let count = volume.triangles.iter().filter(is_bottom).count();
    volume.triangles.remove(count);
    let message = volume.check().expect_err("open").to_string();
    assert!(
        message.contains("Cap") || message.contains("Wall"),
        "{message}"
    );
    assert!(message.contains("from [1"), "{message}");
    assert!(
        message.contains("is used 1 times, its reverse 0 times"),
        "{message}"
    );
}
