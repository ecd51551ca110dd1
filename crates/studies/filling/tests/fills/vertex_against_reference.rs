// SPDX-License-Identifier: MIT OR Apache-2.0
//! The vertex backend held against the reference, every layout, position format and way of
//! colouring, on extreme regions and views; and the controls that must be noticed.
//!
//! Without a Vulkan device these tests are skipped with the reason printed, unless
//! `TERRAFILL_REQUIRE_DEVICE` is set, as `ci/test.sh` does.

use crate::drawing;

use drawing::pairs::pairwise;
use drawing::sights::{self, square_from};
use drawing::{
    AllTargets, Devices, SIZE, Technique, checks, collection, counters, differing, draw, figures,
    input, judge, layouts, made, polygon, shipped, shown, vertex, with_colour,
};
use std::collections::BTreeSet;
use terrafill_conformance::verdict;
use terrafill_contract::Counters;
use terrafill_core::Ellipsoid;
use terrafill_plan::PlanOptions;
use terrafill_stencil::PositionFormat;
use terrafill_variant::{ColourWay, Switches, Variant};
use terrafill_vertex::{Layout, VertexTechnique, VertexVariant};

fn all_variants() -> Vec<Technique> {
    let mut variants = Vec::new();
    for layout in Layout::ALL {
        for positions in [PositionFormat::Fixed, PositionFormat::LocalF32] {
            for colour in [ColourWay::Xor, ColourWay::Rectangle] {
                variants.push(Technique::Vertex(VertexVariant {
                    layout,
                    positions,
                    switches: with_colour(colour),
                    ..VertexVariant::default()
                }));
            }
        }
    }
    variants
}

#[test]
fn a_hole_an_island_in_it_and_a_neighbour() {
    checks::assert_all_right(&sights::hole_island_and_neighbour(), &all_variants());
}

#[test]
fn across_the_antimeridian_and_over_the_poles() {
    checks::assert_all_right(&sights::seam_and_poles(), &all_variants());
}

#[test]
fn a_ten_metre_square_from_fifty_metres() {
    checks::assert_all_right(&sights::ten_metres(), &all_variants());
}

#[test]
fn other_bodies() {
    checks::assert_all_right(&sights::other_bodies(), &all_variants());
}

#[test]
fn shipped_scenes() {
    checks::assert_scenes_right(&checks::SHIPPED, layouts);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn real_countries() {
    checks::assert_scenes_right(&checks::COUNTRIES, layouts);
}

#[test]
fn counting_in_front_is_wrong_from_inside_and_the_automatic_rule_knows() {
    checks::assert_forced_in_front_is_wrong_from_inside(&layouts(Switches::default()));
}

#[test]
fn broken_volumes_are_noticed() {
    checks::assert_broken_volumes_are_noticed(&layouts(Switches::default()));
}

#[test]
fn culling_changes_no_pixel() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let (prepared, views) = shipped("planet-134");
    for view in &views {
        let culled = shown(&prepared, view, SIZE);
        let everything = culled.remeshed(
            &prepared,
            PlanOptions {
                frustum_culling: false,
                horizon_culling: false,
                too_small_culling: false,
                ..PlanOptions::default()
            },
        );
        assert!(culled.plan.regions.len() < everything.plan.regions.len());
        let technique = vertex(with_colour(ColourWay::Rectangle));
        let [a, b] = [culled, everything].map(|input| draw(&devices, &input, technique));
        assert_eq!(differing(&a, &b), 0, "{}", view.name);
    }
}

/// The technique's own choices.
const OWN: &[&str] = &["layout", "walls", "index-order", "vertex-bytes"];

#[test]
fn pairs_of_switches_are_all_chosen() {
    let variants = pairwise(&VertexTechnique, OWN);
    eprintln!("{} variants", variants.len());
    assert!(variants.len() < 60, "{}", variants.len());
    let names: BTreeSet<String> = variants.iter().map(Variant::name).collect();
    assert_eq!(names.len(), variants.len());
    for name in [
        ["separate", "walls=list"],
        ["per-triangle", "colour=id-accumulation"],
        ["depth-rule=automatic", "bottom-cap=where-needed"],
        ["colour=volume", "cover-faces=culled"],
        ["index-order=cache", "vertex-bytes=20"],
        ["cover-area=tiles", "draws=merged"],
    ] {
        let meet = |found: &String| name.iter().all(|part| found.contains(part));
        assert!(names.iter().any(meet), "{name:?}");
    }
    // Negative control: what does not go together is not among them.
    assert!(
        !names
            .iter()
            .any(|name| name.starts_with("pulled") && name.contains("walls=list"))
    );
}

#[test]
fn no_switch_changes_a_pixel() {
    let techniques: Vec<Technique> = pairwise(&VertexTechnique, OWN)
        .iter()
        .map(|variant| Technique::Vertex(VertexVariant::of(variant).expect("known names")))
        .collect();
    checks::assert_no_switch_changes_a_pixel(&techniques);
}

#[test]
fn numbers_mix_where_regions_overlap_and_one_at_a_time_is_right() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let text = collection(&[
        polygon("under", "[[0,0],[10,0],[10,10],[0,10],[0,0]]"),
        polygon("over", "[[5,5],[15,5],[15,15],[5,15],[5,5]]"),
    ]);
    let input = input(&text, Ellipsoid::WGS84, 180, (7.0, 7.0, 3e6, 0.0, -90.0));
    let judged = judge(&input);
    // The scene is said to be disjoint, so that nothing is refused.
    for (colour, is_right) in [
        (ColourWay::Rectangle, true),
        (ColourWay::Xor, false),
        (ColourWay::IdAccumulation, false),
    ] {
        let technique = vertex(with_colour(colour));
        let found = figures(&judged, &draw(&devices, &input, technique));
        assert_eq!(verdict(&found).is_pass(), is_right, "{colour:?}: {found:?}");
    }
}

#[test]
fn a_frame_needs_preparing_and_an_unchanged_one_uploads_no_geometry() {
    let Some(devices) = Devices::open() else {
        return;
    };
    let pose = (5.0, 5.0, 2e6, 0.0, -90.0);
    let [first, other] = [square_from(pose), square_from(pose)];
    let targets = AllTargets::new(&devices, SIZE);
    let mut backend = targets.open(vertex(Switches::default()));
    let error = backend.render(&first).expect_err("not prepared");
    assert_eq!(
        error.to_string(),
        "backend vertex is not prepared for view test of scene test"
    );
    assert!(backend.time_frame(&first).is_err());
    let memory = backend.prepare(&first).expect("fits");
    assert_eq!(
        memory.upload_bytes,
        memory.geometry_bytes() + memory.constant_bytes
    );
    let again = backend.prepare(&first).expect("fits");
    assert_eq!(again.upload_bytes, 0);
    let frame = backend.render(&first).expect("draws");
    let start = counters(&frame);
    assert_eq!((start.upload_bytes, start.draws), (0, 3));
    assert!(backend.render(&other).is_err(), "another input");
    let twice = backend.render(&first).expect("draws");
    assert_eq!(frame.ids, twice.ids);
    // What `prepare` made belongs to the first frame; all other work is the same.
    let again = counters(&twice);
    assert!(start.buffer_creations > 0 && start.pipeline_creations > 0);
    assert_eq!(made(&twice), [0, 0, 0]);
    let without_making = Counters {
        buffer_creations: 0,
        pipeline_creations: 0,
        uploads: 0,
        ..start
    };
    assert_eq!(without_making, again);
}
