// SPDX-License-Identifier: MIT OR Apache-2.0
//! Devices' depth bounds with a control that is too tight, and a rim with a control that is culled.

use super::*;
use crate::counted::Ranges;
use crate::work::Scene;
use glam::DVec3;
use terrafill_casters::Mesh;
use terrafill_shadow_views::{Interface, bridge, sun};
use terrafill_stencil::DepthRange;

fn way(bounds: Bounds) -> DeviceWay {
    DeviceWay {
        bounds,
        ..DeviceWay::plain(Interface::Wgpu)
    }
}

/// Wrong pixels outside the band of a channel, all excuses left out; `None` without a device.
fn wrong(
    scene: &Scene,
    channel: usize,
    way: DeviceWay,
    change: fn(DepthRange) -> DepthRange,
    draws_back_faces: bool,
) -> Option<usize> {
    let (view, truth) = (&scene.views[channel], &scene.truths()[channel]);
    let volume = scene.volume(End::Sea).expect("above");
    let reference = Reference::new(scene.mesh(), scene.to_light);
    let mut loadable = scene
        .loadable(way, view, &volume, None, &reference)
        .expect("loadable");
    for volume in &mut loadable.list {
        volume.depth = change(volume.depth);
    }
    let devices = Devices::default();
    let opened = scene.open_with(&devices, way, view, loadable, draws_back_faces);
    let (_, mask) = unless_unable(opened)?.draw().expect("drawn");
    Some(Wrong::of(&mask, truth).outside())
}

/// What a device did; `None` where there is none, unless one is required.
fn unless_unable<T>(done: Result<T, Failure>) -> Option<T> {
    match done {
        Err(Failure::Unable(error)) => {
            let needed = std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_some();
            assert!(!needed, "{error}");
            None
        }
        done => Some(done.expect("drawn")),
    }
}

#[test]
fn emulated_bounds_change_no_pixel_and_bounds_that_are_too_tight_do() {
    let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
    let darkest = scene.darkest_channel().expect("a channel");
    let wrong = |bounds, change| wrong(&scene, darkest, way(bounds), change, true);
    for bounds in [Bounds::Discard, Bounds::Tiles] {
        let Some(own) = wrong(bounds, |range| range) else {
            return;
        };
        assert_eq!(own, 0, "{}", bounds.name());
        let tight = |range: DepthRange| DepthRange {
            low: range.low + 0.7 * (range.high - range.low),
            ..range
        };
        let control = wrong(bounds, tight).expect("as before");
        assert!(control > 5, "{}: {control}", bounds.name());
    }
}

#[test]
fn one_range_of_depths_is_right_within_it_and_drops_shadows_beyond() {
    let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
    let devices = Devices::default();
    for bounds in [Bounds::Discard, Bounds::Tiles] {
        let one = DeviceWay {
            ranges: Ranges::One,
            ..way(bounds)
        };
        let Some(mut drawn) = unless_unable(scene.drawn_by(&devices, one)) else {
            return;
        };
        let mut draws = std::mem::take(&mut drawn.draws);
        let mut outside = |counted| {
            let judged = scene.compared(&drawn, &mut draws, counted);
            judged.expect("judged").wrong.outside()
        };
        assert_eq!(outside(one.counted()), 0, "{}", bounds.name());
        // Negative control: shadows on the sea behind the port.
        assert!(outside(Counted::All) > 0, "{}", bounds.name());
    }
}

/// A box 4 m by 6 m. In channel 1 the eye looks over its lit roof towards the sun, and behind the rim its lit wall
/// begins: both are light caps.
#[test]
fn beside_a_rim_a_lit_back_that_is_drawn_keeps_the_light_and_one_that_is_culled_does_not() {
    let places = [
        [-2.0, -3.0, -1.0],
        [2.0, -3.0, -1.0],
        [2.0, 3.0, -1.0],
        [-2.0, 3.0, -1.0],
        [-2.0, -3.0, 3.0],
        [2.0, -3.0, 3.0],
        [2.0, 3.0, 3.0],
        [-2.0, 3.0, 3.0],
    ];
    let quads: [[u32; 4]; 6] = [
        [3, 2, 1, 0],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
        [4, 5, 6, 7],
    ];
    let triangles = quads.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let mesh = Mesh::from_triangles("box", places.map(DVec3::from).into(), triangles.concat());
    let mesh = mesh.expect("finite");
    let own = crate::brought::Brought::of("box", mesh, terrafill_casters::Policy::Refuse);
    let own = own.expect("closed");
    let views = own.views([128, 96]);
    let scene = Scene::lit_from(own.prepared, sun([10.0, -60.0]), views);
    for interface in Interface::ALL {
        let way = DeviceWay {
            interface,
            ..way(Bounds::Off)
        };
        let of = |draws_back_faces| wrong(&scene, 1, way, |range| range, draws_back_faces);
        let (Some(drawn), Some(culled)) = (of(true), of(false)) else {
            return;
        };
        // Negative control: 1/256 of a pixel beyond the rim the roof is drawn, and a rounding behind it the
        // wall's cap.
        assert_eq!([drawn, culled], [0, 1], "{}", interface.name());
        // In channel 3 the wall is dark, and a side of the volume begins at the rim: no surface is there to be drawn.
        let mut all = scene.drawn_by(&Devices::default(), way).expect("drawn");
        let mut draws = std::mem::take(&mut all.draws);
        let wrong = scene
            .compared(&all, &mut draws, Counted::All)
            .expect("judged")
            .wrong;
        assert_eq!((wrong.outside(), wrong.at_rims), (0, 1));
    }
}

#[test]
fn volumes_that_are_handed_over_in_a_frame_are_those_that_are_drawn() {
    let devices = Devices::default();
    let views = vec![terrafill_shadow_views::bridge([64, 48])[4]];
    let scene = Scene::of_port([10.0, -60.0], views).expect("a port");
    let volume = scene.volume(End::Sea).expect("above");
    for interface in Interface::ALL {
        let way = DeviceWay {
            silhouettes: Silhouettes::EachFrame,
            ..DeviceWay::plain(interface)
        };
        let Some(mut drawn) = unless_unable(scene.drawn_by(&devices, way)) else {
            return;
        };
        let mut volumes = scene.eye_volumes(way, &scene.views[0], &volume);
        let mut mask_of = |volumes: &terrafill_shadow_views::EyeVolumes| {
            drawn.draws[0].hand_over(volumes).expect("handed over");
            drawn.draws[0].draw().expect("drawn").1
        };
        let same = mask_of(&volumes);
        // Negative control: every triangle has no area.
        volumes.indices.fill(0);
        let none = mask_of(&volumes);
        assert_eq!(same, drawn.masks[0], "{}", interface.name());
        assert!(
            same.contains(&true) && !none.contains(&true),
            "{}",
            interface.name()
        );
    }
}

/// A crane's leg stands on the dock at 148 m. The centre of pixel (1001, 609) of the channel lies 0.0001 px above the foot
/// of its lit face, 14 µm over the dock. Rounded to 1/256 of a pixel, the foot runs above the centre: the device sees the
/// dock, and before it the side of the leg's volume, which begins at the foot.
#[test]
fn at_the_foot_of_a_caster_rounding_may_darken_the_pixel_on_its_edge_and_none_beside() {
    let whole = bridge([1024, 768])[5];
    // The same pixels without the uppermost and the lowest rows.
    let view = whole.sized([1024, 454]);
    let at = |column: usize, row: usize| (row - (768 - 454) / 2) * 1024 + column;
    let foot = at(1001, 609);
    let port = crate::work::port_m().expect("a port");
    let scene = Scene::of(port, [60.0, -60.0], vec![view]).expect("a port");
    let (view, truth) = (&scene.views[0], &scene.truths()[0]);
    let reference = Reference::new(scene.mesh(), scene.to_light);
    let is_lit = |at: usize| truth.light[at] == Light::Lit && !truth.band[at];
    let is_excused = |at| scene.is_within_rounding(&reference, view, at, Light::Shadow);
    assert!(is_lit(foot) && is_excused(foot));
    // Negative controls: one column on, the edge runs 0.03 px below the centre. A row below is the dock, lit as well.
    for beside in [at(1002, 609), at(1003, 609), at(1002, 610)] {
        assert!(is_lit(beside) && !is_excused(beside));
    }
    for interface in Interface::ALL {
        let way = DeviceWay {
            interface,
            ..way(Bounds::Off)
        };
        let Some(mut drawn) = unless_unable(scene.drawn_by(&Devices::default(), way)) else {
            return;
        };
        let mut draws = std::mem::take(&mut drawn.draws);
        let compared = scene.compared(&drawn, &mut draws, Counted::All);
        let wrong = compared.expect("compared").wrong;
        assert_eq!(wrong.outside(), 0, "{}", interface.name());
        let mask = &drawn.masks[0];
        let mut control = mask.clone();
        control[at(1002, 609)] = true;
        let outside =
            |mask: &[bool]| Wrong::but_at_rims(mask, truth, |at, _| is_excused(at)).false_dark;
        assert_eq!([outside(mask), outside(&control)], [0, 1]);
        eprintln!("foot drawn dark: {}", mask[foot]);
    }
}

#[test]
fn a_count_of_fewer_fragments_than_pixels_in_shadow_is_absent_with_its_reason() {
    let reason = plausible(Some(0), 1_200).expect_err("too few");
    assert!(
        reason.contains("0 fragments") && reason.contains("1200 pixels"),
        "{reason}"
    );
    assert!(plausible(Some(1_199), 1_200).is_err());
    // Negative controls: as many as there must be, nothing in shadow, and a device that counts nothing.
    assert_eq!(plausible(Some(1_200), 1_200), Ok(Some(1_200)));
    assert_eq!(plausible(Some(0), 0), Ok(Some(0)));
    assert_eq!(plausible(None, 1_200), Ok(None));
}
