// SPDX-License-Identifier: MIT OR Apache-2.0
//! Devices' depth bounds with a twin that is too tight, and a rim with a twin that is culled.

use super::*;
use crate::work::Scene;
use glam::DVec3;
use terrafill_casters::Mesh;
use terrafill_shadow_views::{Interface, sun};
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
    let (view, truth) = &scene.channels[channel];
    let volume = scene.volume(End::Sea).expect("above");
    let reference = Reference::new(scene.mesh(), scene.to_light);
    let mut loadable = scene
        .loadable(way, view, &volume, None, &reference)
        .expect("loadable");
    for volume in &mut loadable.list {
        volume.depth = change(volume.depth);
    }
    let devices = Devices::default();
    match scene.open_with(&devices, way, view, loadable, draws_back_faces) {
        Err(Failure::Unable(error)) => {
            let needed = std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_some();
            assert!(!needed, "{error}");
            None
        }
        opened => {
            let (_, mask) = opened.expect("opened").draw().expect("drawn");
            Some(Wrong::of(&mask, truth).outside())
        }
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
        let twin = wrong(bounds, tight).expect("as before");
        assert!(twin > 5, "{}: {twin}", bounds.name());
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
        let all = scene
            .drawn_by(&Devices::default(), way, Kept::Darkest)
            .expect("drawn");
        assert_eq!((all.wrong.outside(), all.wrong.at_rims), (0, 1));
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
