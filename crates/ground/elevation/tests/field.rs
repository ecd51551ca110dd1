// SPDX-License-Identifier: MIT OR Apache-2.0
//! Fields and layers: bounds of parts hold every value, neighbours join, edges are smooth.

use terrafill_core::Extent;
use terrafill_elevation::{
    Base, Elevation, Grid, HeightField, Heights, Projection, Registration, Relief,
};

fn grid(first: [f64; 2], step: f64, columns: u32, rows: u32) -> Grid {
    Grid {
        projection: Projection::Geographic,
        registration: Registration::Area,
        columns,
        rows,
        first,
        step: [step; 2],
    }
}

/// Rough, the same in each run.
fn rough(index: u32) -> f32 {
    let mut mixed = index.wrapping_mul(0x9E37_79B1);
    mixed ^= mixed >> 15;
    mixed = mixed.wrapping_mul(0x85EB_CA6B);
    mixed ^= mixed >> 13;
    f32::from(u16::try_from(mixed % 4000).expect("below 4000")) - 1000.0
}

fn field(grid: Grid) -> HeightField {
    let samples = (0..grid.columns * grid.rows).map(rough).collect();
    HeightField::new("rough", grid, samples).expect("a field")
}

fn extent(west_deg: f64, south_deg: f64, east_deg: f64, north_deg: f64) -> Extent {
    Extent {
        west_deg,
        south_deg,
        east_deg,
        north_deg,
    }
}

#[test]
fn a_range_holds_every_value_over_its_extent_and_is_no_wider_than_its_samples() {
    let globe = field(grid([-179.0, 89.0], 2.0, 180, 90));
    let part = field(grid([170.0, 20.0], 0.25, 80, 60));
    let points = HeightField::new(
        "points",
        Grid {
            registration: Registration::Point,
            ..*part.grid()
        },
        (0..4800).map(rough).collect(),
    )
    .expect("points");
    let of_part = [
        extent(175.0, 7.0, 176.0, 9.0),
        extent(179.0, 6.0, -175.0, 18.0),
        extent(171.01, 10.01, 171.02, 10.02),
    ];
    let (mut outside, mut checked) = (0, 0);
    for (field, extents) in [
        (
            &globe,
            [
                extent(-10.0, -5.0, 30.0, 9.0),
                extent(170.0, -80.0, -170.0, 90.0),
                extent(3.1, 4.1, 3.2, 4.2),
            ],
        ),
        (&part, of_part),
        (&points, of_part),
    ] {
        for extent in extents {
            let Heights {
                lowest_m,
                highest_m,
            } = field.range(&extent).expect("inside");
            let width = (extent.east_deg - extent.west_deg).rem_euclid(360.0);
            for i in 0..=60 {
                for j in 0..=60 {
                    let longitude = extent.west_deg + width * f64::from(i) / 60.0;
                    let latitude = extent.south_deg
                        + (extent.north_deg - extent.south_deg) * f64::from(j) / 60.0;
                    let Some(height) = field.height_m(longitude, latitude) else {
                        continue;
                    };
                    assert!(
                        (lowest_m..=highest_m).contains(&height),
                        "{extent:?}: {height}"
                    );
                    // Negative control: the range of a place elsewhere does not hold them all.
                    let elsewhere = field.height_m(longitude + 0.13 * f64::from(i), latitude);
                    checked += 1;
                    outside += usize::from(
                        elsewhere.is_some_and(|h| !(lowest_m..=highest_m).contains(&h)),
                    );
                }
            }
        }
    }
    assert!(outside > 500, "{outside} of {checked}");
    assert_eq!(part.range(&extent(10.0, 10.0, 11.0, 11.0)), None);
    assert_eq!(part.range(&extent(175.0, 40.0, 176.0, 41.0)), None);
    let tight = globe.range(&extent(3.1, 4.1, 3.2, 4.2)).expect("inside");
    let own = [
        globe.height_m(3.0, 3.0),
        globe.height_m(3.0, 5.0),
        globe.height_m(5.0, 3.0),
        globe.height_m(5.0, 5.0),
    ];
    let own = own.map(|height| height.expect("inside"));
    assert_eq!(tight.highest_m, own.into_iter().fold(f64::MIN, f64::max));
}

#[test]
fn four_tiles_are_one_field_and_a_missing_one_leaves_them_apart() {
    let whole = field(grid([10.0, 50.0], 0.5, 8, 6));
    let part = |column: usize, row: usize| {
        let samples = (0..12).map(|i| {
            let index = (row * 3 + i / 4) * 8 + column * 4 + i % 4;
            rough(u32::try_from(index).expect("small"))
        });
        let first = [10.0 + 2.0 * column as f64, 50.0 - 1.5 * row as f64];
        HeightField::new("part", grid(first, 0.5, 4, 3), samples.collect()).expect("a part")
    };
    let parts = [part(0, 1), part(1, 1), part(0, 0), part(1, 0)];
    let joined = HeightField::joined(&parts).expect("a rectangle");
    assert_eq!(joined.bounds(), whole.bounds());
    for (longitude, latitude) in [(10.1, 49.0), (11.9, 48.6), (13.0, 47.8)] {
        assert_eq!(
            joined.height_m(longitude, latitude),
            whole.height_m(longitude, latitude)
        );
    }
    assert!(HeightField::joined(&parts[..3]).is_none());
    let coarser = field(grid([10.0, 50.0], 1.0, 8, 6));
    assert!(HeightField::joined(&[parts[0].clone(), coarser]).is_none());
    let seam = |fields: &[HeightField]| {
        let elevation = Elevation::new(fields.to_vec(), Base::Flat, 0.1, 1.0);
        (elevation.fields().len(), elevation.height_m(11.75, 48.75))
    };
    assert_eq!(
        seam(&parts),
        (1, whole.height_m(11.75, 48.75).expect("inside"))
    );
    // Negative control: apart, each sinks to the base at the seam.
    let (count, height) = seam(&[parts[3].clone(), parts[0].clone()]);
    assert_eq!(count, 2);
    assert!(height.abs() < 0.5 * whole.height_m(11.75, 48.75).expect("inside").abs() + 1.0);
}

#[test]
fn a_field_goes_over_smoothly_into_what_lies_below_it() {
    let top = HeightField::new("top", grid([10.05, 50.95], 0.1, 10, 10), vec![3000.0; 100])
        .expect("level");
    let cliff = |feather: f64| {
        let elevation = Elevation::new(vec![top.clone()], Base::Flat, feather, 2.0);
        let heights = (0..=400).map(|i| elevation.height_m(9.9 + 0.003 * f64::from(i), 50.5));
        let heights: Vec<f64> = heights.collect();
        assert!(
            heights.iter().any(|&h| (h - 6000.0).abs() < 1e-9),
            "exaggerated twice"
        );
        heights
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f64::max)
    };
    assert!(cliff(0.1) < 400.0, "{}", cliff(0.1));
    assert!(cliff(0.0) > 5999.0, "{}", cliff(0.0));
    let elevation = Elevation::new(vec![top], Base::Flat, 0.1, 2.0);
    let range = |extent| elevation.range(&extent);
    let inner = range(extent(10.4, 50.4, 10.6, 50.6));
    assert_eq!((inner.lowest_m, inner.highest_m), (6000.0, 6000.0));
    assert_eq!(range(extent(9.9, 50.4, 10.6, 50.6)).lowest_m, 0.0);
    assert_eq!(range(extent(20.0, 50.4, 20.6, 50.6)).highest_m, 0.0);
    assert_eq!(elevation.spacing_deg(&extent(20.0, 50.4, 20.6, 50.6)), None);
}

#[test]
fn a_relief_keeps_its_bits_and_lies_within_its_range() {
    let relief = Relief { seed: 7 };
    let base = Base::Relief {
        relief,
        amplitude_m: 9000.0,
    };
    let elevation = Elevation::new(Vec::new(), base, 0.05, 1.0);
    for (east, north) in [(0.3, 0.7), (1.9, 0.01), (0.0, 1.0)] {
        let height_m = elevation.height_at_half_turns(east, north);
        assert_eq!(
            height_m.to_bits(),
            (9000.0 * relief.share(east, north)).to_bits()
        );
    }
    let range = elevation.range(&extent(0.0, 0.0, 1.0, 1.0));
    assert!((range.lowest_m..=range.highest_m).contains(&elevation.height_m(0.5, 0.5)));
}

#[test]
fn a_field_that_lies_nowhere_or_has_other_samples_is_refused() {
    let wrong = |grid: Grid, samples: usize| {
        HeightField::new("w", grid, vec![0.0; samples])
            .expect_err("wrong")
            .to_string()
    };
    let good = grid([10.0, 50.0], 0.5, 4, 3);
    for (grid, samples, expected) in [
        (
            good,
            11,
            "w: samples: found 11, allowed: 12, 4 columns of 3 rows",
        ),
        (Grid { columns: 1, ..good }, 3, "w: size: found 1 × 3"),
        (
            Grid {
                step: [-1.0, 1.0],
                ..good
            },
            12,
            "w: step to the east: found -1",
        ),
        (
            Grid {
                step: [1.0, 4e-8],
                ..good
            },
            12,
            "w: step to the south: found 0.00000004, allowed: 4.2e-8 or more",
        ),
        (
            Grid {
                step: [200.0, 1.0],
                ..good
            },
            12,
            "w: eastern edge: found 710",
        ),
        (
            Grid {
                columns: 6,
                step: [100.0, 1.0],
                first: [-300.0, 50.0],
                ..good
            },
            18,
            "w: width: found 600, allowed: at most 360",
        ),
        (
            Grid {
                first: [f64::NAN, 50.0],
                ..good
            },
            12,
            "w: western edge: found NaN",
        ),
    ] {
        let found = wrong(grid, samples);
        assert!(found.starts_with(expected), "{found}");
    }
}
