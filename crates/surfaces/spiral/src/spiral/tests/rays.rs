// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rays against the mesh over terrain, and the heights that a view states.

use super::*;

/// Rays of a coarse picture that enter the body below the lowest place drawn, and those of them that meet no
/// triangle.
fn uncovered(spiral: &Spiral, camera: &Camera) -> [usize; 2] {
    let size = ImageSize::new(48, 48);
    let frame = spiral.frame(camera, size).expect("above");
    let body = &spiral.body;
    let (a, b) = (body.equatorial_radius_m(), body.polar_radius_m());
    // Shrunk as for horizon culling.
    let deep = frame.heights.lowest_m.min(0.0) * a / b;
    let radii = body.radii_m() + DVec3::splat(deep);
    let eye = camera.eye_ecef / radii;
    let corner = |index: u32| DVec3::from(frame.vertices_rte[index as usize].map(f64::from));
    let corners: Vec<[DVec3; 3]> = frame.triangles.iter().map(|ids| ids.map(corner)).collect();
    let mut found = [0, 0];
    // Besides the pixels' own rays, those that just touch the lowered body.
    let mut directions: Vec<DVec3> = (0..size.height)
        .flat_map(|row| (0..size.width).map(move |column| (column, row)))
        .map(|(column, row)| camera.pixel_direction_ecef(size, column, row))
        .collect();
    let down = -eye.normalize();
    let across = down.any_orthonormal_vector();
    let touching = eye.length().recip().asin();
    let grazing = (0..400_u32).map(|step| {
        let around = TAU * f64::from(step) / 400.0;
        let side = across * around.cos() + down.cross(across) * around.sin();
        let (sine, cosine) = (touching * (1.0 - 1e-6)).sin_cos();
        (down * cosine + side * sine) * radii
    });
    let is_seen = |direction: &DVec3| {
        let view = camera.view_from_ecef * *direction;
        let tan = camera.tan_half_fov();
        view.z < 0.0 && (view.x / view.z).abs() < tan && (view.y / view.z).abs() < tan
    };
    directions.extend(grazing.filter(is_seen));
    let corners_px = [[0.0, 0.0], [48.0, 0.0], [0.0, 48.0], [48.0, 48.0]];
    directions.extend(corners_px.map(|px| camera.direction_ecef(size, px)));
    for direction in directions {
        let scaled = (direction / radii).normalize();
        let along = -eye.dot(scaled);
        if along <= 0.0 || (eye + scaled * along).length() >= 1.0 {
            continue;
        }
        found[0] += 1;
        let is_met = corners.iter().any(|&[p, q, r]| {
            let sides = [(p, q), (q, r), (r, p)].map(|(from, to)| from.cross(to).dot(direction));
            sides.iter().all(|&side| side <= 0.0)
        });
        found[1] += usize::from(!is_met);
    }
    found
}

#[test]
fn every_ray_that_enters_the_body_below_the_lowest_facet_meets_the_mesh() {
    let body = Ellipsoid::WGS84;
    let views = [
        ([15.0, 20.0, 8e6], -90.0),
        ([0.0, 90.0, 8e6], -90.0),
        ([15.0, 20.0, 2e3], -2.0),
        ([15.0, 20.0, 1e4], -90.0),
        ([15.0, 20.0, 1.7], -2.0),
        ([15.0, 20.0, 1e8], -90.0),
        ([15.0, 70.0, 1e5], -20.0),
    ];
    for law in laws() {
        for n in [12, 36] {
            let spiral = Spiral {
                law,
                ..Spiral::new(&body, n)
            };
            for (place, pitch) in views {
                let [rays, missed] = uncovered(&spiral, &camera(&body, place, pitch));
                assert!(rays > 20, "{place:?}: {rays}");
                assert_eq!(missed, 0, "{law:?} {n} {place:?}");
            }
        }
    }
    // Step 7° leaves an edge of 10°, and terrain makes the body's edge rough.
    let slanted = Spiral {
        steps: Steps::new(7.0),
        ..Spiral::new(&body, 51)
    };
    let hilly = Spiral::new(&body, 36).with_elevation(grown());
    for (place, pitch) in views {
        let above = [place[0], place[1], place[2] + 9e3];
        for (spiral, place) in [(&slanted, place), (&hilly, above)] {
            let [_, missed] = uncovered(spiral, &camera(&body, place, pitch));
            assert_eq!(missed, 0, "{place:?}");
        }
    }
    // Negative control: duplicated vertices with a step that does not divide a turn leave cracks, through
    // which rays fall.
    let of_13 = Spiral {
        steps: Steps::new(13.0),
        ..Spiral::new(&body, 28)
    };
    let cracked = Spiral {
        indices: Indices::Published,
        ..of_13.clone()
    };
    let (place, pitch) = views[0];
    let fallen =
        [&of_13, &cracked].map(|spiral| uncovered(spiral, &camera(&body, place, pitch))[1]);
    eprintln!("rays that fall through a step of 13°, indexed and duplicated: {fallen:?}");
    assert!(fallen[0] == 0 && fallen[1] > 0, "{fallen:?}");
    // Negative control: where the rim runs through the picture's corners, its chords cut them. Towards the
    // horizon the facets hang deeper than chords cut.
    let cut = Spiral {
        rim: Rim::Horizon,
        ..Spiral::new(&body, 12)
    };
    let missed = views.map(|(place, pitch)| uncovered(&cut, &camera(&body, place, pitch))[1]);
    let is_missed = missed.map(|missed| missed > 0);
    assert_eq!(is_missed, views.map(|([.., height_m], _)| height_m == 1e4));
}

#[test]
fn every_point_drawn_lies_within_the_heights_of_its_view_and_of_all_views() {
    let (mut elsewhere, mut points) = (0, 0);
    for (spiral, place, pitch) in [
        (
            Spiral::new(&Ellipsoid::WGS84, 36),
            [178.0, 70.0, 3e6],
            -80.0,
        ),
        (Spiral::new(&Ellipsoid::WGS84, 12), [0.0, 90.0, 8e6], -90.0),
        (
            Spiral::new(&Ellipsoid::SATURN_LIKE, 24),
            [10.0, 45.0, 1e8],
            -80.0,
        ),
        (
            Spiral::new(&Ellipsoid::WGS84, 24).with_elevation(grown()),
            [10.5, 46.5, 1e4],
            -8.0,
        ),
    ] {
        let camera = camera(&spiral.body, place, pitch);
        let frame = spiral.frame(&camera, SIZE).expect("above");
        for triangle in frame.triangles.iter() {
            let corners = triangle.map(|vertex| {
                camera.eye_ecef + DVec3::from(frame.vertices_rte[vertex as usize].map(f64::from))
            });
            for point in [
                corners[0],
                (corners[0] + corners[1]) * 0.5,
                (corners[0] + corners[1] + corners[2]) / 3.0,
            ] {
                let place = spiral.body.ecef_to_geodetic(point);
                let [longitude, latitude] =
                    [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
                let here = Extent {
                    west_deg: longitude,
                    east_deg: longitude,
                    south_deg: latitude,
                    north_deg: latitude,
                };
                // Vertices are rounded to f32 by their distance from the eye.
                let rounding = 1e-3 + 2e-7 * (point - camera.eye_ecef).length();
                let holds = |range: HeightRange| {
                    (range.lowest_m - rounding..=range.highest_m + rounding)
                        .contains(&place.height_m)
                };
                let stated = spiral.heights(&here);
                assert!(holds(stated), "{here:?}: {} {stated:?}", place.height_m);
                let over = |extent: &Extent| {
                    let meets = |part: &&terrafill_surface::SurfacePart| {
                        let one = SurfaceFrame {
                            parts: [**part].into(),
                            heights: HeightRange {
                                lowest_m: -1.0,
                                highest_m: -2.0,
                            },
                            ..frame.clone()
                        };
                        one.heights_over(extent, part.heights) == part.heights
                    };
                    frame.parts.iter().filter(meets).count()
                };
                // The negative control below counts; here the parts must know the place at all.
                if points % 97 == 0 {
                    assert!(over(&here) > 0, "{here:?} lies in no part");
                }
                assert!(holds(frame.heights_over(&here, stated)), "{here:?}");
                // Negative control: the heights of a place farther in do not hold it.
                let focus = spiral.body.ecef_to_geodetic(camera.eye_ecef);
                let toward = |to: f64, at: f64| at + 0.5 * (to - at);
                let [west, south] = [
                    toward(focus.longitude_rad.to_degrees(), longitude),
                    toward(focus.latitude_rad.to_degrees(), latitude),
                ];
                let beside = Extent {
                    west_deg: west,
                    east_deg: west,
                    south_deg: south,
                    north_deg: south,
                };
                elsewhere += usize::from(!holds(frame.heights_over(&beside, stated)));
                points += 1;
            }
        }
    }
    assert!(elsewhere > points / 20, "{elsewhere} of {points}");
}

#[test]
fn near_ground_has_low_walls_and_far_ground_deep_ones() {
    let body = Ellipsoid::WGS84;
    let spiral = Spiral::new(&body, 36);
    let camera = camera(&body, [10.0, 20.0, 2e3], -2.0);
    let frame = spiral.frame(&camera, SIZE).expect("above");
    let over = |aside: f64| {
        let extent = Extent {
            west_deg: 10.0 + aside,
            east_deg: 10.0 + aside + 0.001,
            south_deg: 20.0,
            north_deg: 20.001,
        };
        frame
            .heights_over(&extent, spiral.heights(&extent))
            .lowest_m
    };
    let [near, middle, far] = [0.001, 0.1, 1.0].map(over);
    eprintln!("lowest {near:.4} m nearby, {middle:.2} m 10 km away, {far:.1} m 100 km away");
    assert!(near > -0.1 && middle < -0.1 && middle > -5.0 && far < -5.0);
    assert!(frame.heights.lowest_m > -60.0, "{:?}", frame.heights);
}
