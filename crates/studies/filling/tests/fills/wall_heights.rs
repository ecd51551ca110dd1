// SPDX-License-Identifier: MIT OR Apache-2.0
//! Volumes are as low as the surface's triangles allow, and no lower. A flat triangle hangs between its
//! corners by its sagitta; walls that end at the corners' heights miss what hangs.

use crate::drawing;

use drawing::{
    Devices, draw, figures, judge, look, polygon, scene, square, vertex, with_colour,
    without_sagitta,
};
use terrafill_conformance::{filled_only, verdict};
use terrafill_contract::FillInput;
use terrafill_core::Ellipsoid;
use terrafill_plan::{PlanOptions, WallHeights};
use terrafill_scene::{ImageSize, Overlap};
use terrafill_variant::ColourWay;

const SIZE: ImageSize = square(128);

/// A square in the middle of a cell of 1°, from above and obliquely. The cell hangs 311 m to 485 m below its
/// corners there, the square's own bottom cap at most 173 m.
fn views(wraps: bool) -> [FillInput; 2] {
    let square = "[[10.2,0.2],[10.8,0.2],[10.8,0.8],[10.2,0.8],[10.2,0.2]]";
    let text = polygon("square", square);
    let mut scene = scene(&text, Ellipsoid::WGS84, 180, Overlap::Disjoint);
    if wraps {
        scene = without_sagitta(&scene);
    }
    let poses = [(10.5, 0.5, 1e5, 0.0, -90.0), (10.5, -0.5, 5e4, 0.0, -25.0)];
    poses.map(|pose| look(&scene, pose, 100.0, SIZE))
}

#[test]
fn walls_that_leave_out_what_facets_hang_by_are_too_high_and_the_picture_is_wrong() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let technique = vertex(with_colour(ColourWay::OneColourVolumes));
    for (right, hanging) in views(false).into_iter().zip(views(true)) {
        let judged = filled_only(&judge(&right));
        let found = |input: &FillInput| {
            let frame = filled_only(&draw(&devices, input, technique));
            figures(&judged, &frame)
        };
        let heights = right.plan.regions[0].heights;
        assert!(heights.bottom_m < -485.0, "{heights:?}");
        assert!(verdict(&found(&right)).is_pass(), "{:?}", found(&right));
        // Global walls show the same, and reach farther than is needed.
        let plan = PlanOptions {
            wall_heights: WallHeights::Global,
            ..PlanOptions::default()
        };
        let global = right.remeshed(&right.scene, plan);
        let taller = global.plan.regions[0].heights;
        assert!(verdict(&found(&global)).is_pass());
        assert!(taller.bottom_m < 10.0 * heights.bottom_m, "{taller:?}");
        // Negative control.
        let bottom_m = hanging.plan.regions[0].heights.bottom_m;
        assert!(bottom_m > -311.0, "{bottom_m}");
        let wrong = found(&hanging);
        assert!(!verdict(&wrong).is_pass(), "{wrong:?}");
    }
}
