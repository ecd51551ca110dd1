// SPDX-License-Identifier: MIT OR Apache-2.0
//! Replays the seeds and regressions of the fuzz target `elevation`; they must reach all its branches.

use terrafill_elevation::{Grid, HeightField, Projection, Registration};
use terrafill_fixtures::fuzz::{elevation, reached::Reached, replay::assert_replays};

#[test]
fn the_corpus_replays_and_reaches_every_branch() {
    assert_replays("elevation", elevation::check, elevation::BRANCHES);
}

#[test]
fn a_corpus_that_misses_a_branch_and_a_field_with_voids_are_noticed() {
    // Negative control: one input reaches one branch, and what a field has is counted.
    let mut reached = Reached::new(elevation::BRANCHES);
    elevation::check(&[0], &mut reached).expect("refused as it should be");
    assert_eq!(reached.found(), ["geotiff_undecodable"]);
    let grid = Grid {
        projection: Projection::Geographic,
        registration: Registration::Point,
        columns: 2,
        rows: 2,
        first: [0.0, 0.0],
        step: [1.0; 2],
    };
    let field = HeightField::new("v", grid, vec![1.0, f32::NAN, -3.0, 2.0]).expect("a field");
    elevation::check_field(&field, &mut reached).expect("right");
    assert_eq!(
        reached.found(),
        ["geotiff_undecodable", "voids", "below_zero"]
    );
}
