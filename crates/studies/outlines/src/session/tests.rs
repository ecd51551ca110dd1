// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures by every way against the reference, the reference against rays, and pictures that must be refused.

use super::*;
use crate::contour::strokes;
use crate::judge::number;
use glam::DVec3;
use terrafill_contract::DeviceOptions;
use terrafill_shadow_views::{Reference, Seen};

const SIZE: [u32; 2] = [192, 144];

fn fleet(models: usize) -> Fleet {
    Fleet::of(models, SIZE).expect("models before the eye")
}

/// A way's picture and its clears.
fn picture(device: &OnWgpu, way: Way, width_px: u32) -> (Vec<u32>, usize) {
    let drawn = device.frame(way, width_px).expect("a frame");
    (device.read().expect("a picture"), drawn.clears)
}

#[test]
fn values_leave_out_what_clears_do_and_both_twins_are_wrong() {
    let Some(gpu) = terrafill_gpu::open_for_test(&DeviceOptions::default()) else {
        return;
    };
    // Strokes of several widths; values that come round once and twice.
    for (models, width_px, is_round) in [
        (17, 1, false),
        (17, 5, false),
        (254, 3, false),
        (600, 3, true),
    ] {
        let fleet = fleet(models);
        let device = OnWgpu::new(&gpu, &fleet).expect("a device");
        let truth = Truth::new(&fleet, f64::from(width_px));
        let shown = |way| {
            let (numbers, clears) = picture(&device, way, width_px);
            (truth.judge(&numbers), numbers, clears)
        };
        let (found, cleared, clears) = shown(Way::Clear);
        let [strokes, undecided] = truth.counts();
        assert_eq!((found.all(), clears), (0, models));
        assert!(
            strokes > 500 && undecided * 10 < cleared.len(),
            "{strokes} {undecided}"
        );
        let (found, numbers, clears) = shown(Way::Value);
        assert_eq!((found.all(), clears), (0, 1 + models / 255));
        assert!(numbers == cleared, "another picture than by clears");
        let (wider, _) = picture(&device, Way::Value, width_px + 2);
        assert!(truth.judge(&wider).all() > 100, "strokes of another width");
        let (found, _, clears) = shown(Way::ValueAsPrinted);
        assert!(found.inside > 100 && found.missing > 100);
        assert_eq!(clears, 1 + models / 255);
        let (found, _, clears) = shown(Way::ValueNeverCleared);
        assert_eq!((found.missing > 0, clears), (is_round, 1), "{models}");
    }
}

#[test]
fn without_strokes_the_reference_shows_the_model_that_a_ray_meets() {
    let fleet = fleet(254);
    let truth = Truth::new(&fleet, 0.0);
    let mesh = &fleet.mesh;
    let rays = Reference::new(mesh, DVec3::Z);
    let parts = mesh.part_of_triangles();
    let model = |triangle: u32| {
        let part = parts[triangle as usize] as usize;
        mesh.casters
            .partition_point(|model| model.parts.end <= part)
    };
    let (mut decided, mut shown) = (0, 0);
    for (at, outcomes) in truth.pixels.iter().enumerate() {
        let [column, row] = fleet.camera.pixel(at);
        let ray = fleet.camera.ray(column, row);
        let met = match rays.seen(fleet.camera.eye, ray, fleet.camera.near) {
            Seen::Triangle(triangle, _) => {
                number(u32::try_from(model(triangle)).expect("few"), false)
            }
            _ => NOTHING,
        };
        assert!(outcomes.iter().any(|own| own.shown == met), "{at}");
        decided += usize::from(outcomes.len() == 1);
        shown += usize::from(met != NOTHING);
    }
    assert!(
        decided * 10 > 9 * truth.pixels.len() && shown > 2_000,
        "{decided} {shown}"
    );
}

#[test]
fn a_wrong_pixel_is_refused() {
    let truth = Truth::new(&fleet(17), 3.0);
    let shown = |outcomes: &Vec<crate::judge::Outcome>| outcomes[0].shown;
    let right: Vec<u32> = truth.pixels.iter().map(shown).collect();
    assert_eq!(truth.judge(&right).all(), 0);
    let decided = |is_it: fn(u32) -> bool| {
        let mut all = truth.pixels.iter();
        let found = all.position(|own| own.len() == 1 && is_it(own[0].shown));
        found.expect("such a pixel")
    };
    let [stroke, face, sea] = [
        decided(|shown| shown != NOTHING && shown % 2 == 0),
        decided(|shown| shown % 2 == 1),
        decided(|shown| shown == NOTHING),
    ];
    let with = |pixel: usize, shown: u32| {
        let mut numbers = right.clone();
        numbers[pixel] = shown;
        let found = truth.judge(&numbers);
        assert_eq!(
            found.wrong.iter().position(|is_wrong| *is_wrong),
            Some(pixel)
        );
        [found.missing, found.inside, found.others]
    };
    assert_eq!(with(stroke, NOTHING), [1, 0, 0]);
    assert_eq!(
        with(stroke, right[stroke] + 2),
        [1, 0, 0],
        "of another model"
    );
    assert_eq!(with(face, right[face] + 1), [0, 1, 0]);
    assert_eq!(with(sea, right[face]), [0, 0, 1]);
    // A stroke's width away from the picture of another width.
    let wide = Truth::new(&fleet(17), 5.0);
    assert!(wide.judge(&right).missing > 100);
}

#[test]
fn a_device_is_handed_the_contours_of_the_eye() {
    let fleet = fleet(300);
    let (all, ranges) = strokes(&fleet);
    assert_eq!((ranges.len(), ranges[299].end as usize), (300, all.len()));
    let mut own = ranges.iter().enumerate();
    assert!(own.all(|(model, range)| {
        let strokes = &all[range.start as usize..range.end as usize];
        // A box has six.
        strokes.len() >= 6 && strokes.iter().all(|stroke| stroke.model as usize == model)
    }));
    // A box of twelve triangles seen from above has exactly six.
    let shed = fleet
        .mesh
        .casters
        .iter()
        .position(|model| model.name == "shed");
    assert_eq!(ranges[shed.expect("a shed")].len(), 6);
    assert!(Fleet::of(11, SIZE).is_err(), "fewer than a port has");
}

#[test]
fn constants_lie_where_the_shader_reads_them() {
    use crate::on_wgpu::OutlineConstants;
    use std::mem::offset_of;
    let layout = terrafill_shaders::struct_layout("casters/outlines.wgsl", "OutlineConstants");
    let layout = layout.expect("in the shader");
    for (name, offset) in [
        ("right", offset_of!(OutlineConstants, right)),
        ("up", offset_of!(OutlineConstants, up)),
        ("forward", offset_of!(OutlineConstants, forward)),
        ("size_px", offset_of!(OutlineConstants, size_px)),
    ] {
        assert_eq!(layout.offset(name), Some(offset), "{name}");
    }
    assert_eq!(layout.stride as usize, size_of::<OutlineConstants>());
}
