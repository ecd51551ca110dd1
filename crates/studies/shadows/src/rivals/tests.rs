// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rivals against the reference, and controls that must be wrong.

use super::*;
use crate::counted::Counted;
use std::mem::offset_of;
use terrafill_casters::{PortSize, port};
use terrafill_shaders::struct_layout;
use terrafill_shadow_views::{Wrong, bridge};

#[test]
fn receivers_lie_as_the_shaders_have_them() {
    for path in ["casters/tiles.wgsl", "casters/rays.wgsl"] {
        let layout = struct_layout(path, "Receivers").expect("a struct");
        let members = layout.members.iter();
        let offsets = members.map(|(name, offset, _)| (name.as_str(), *offset as usize));
        let own = [
            ("right", offset_of!(Receivers, right)),
            ("up", offset_of!(Receivers, up)),
            ("ahead", offset_of!(Receivers, ahead)),
            ("to_light", offset_of!(Receivers, to_light)),
            ("size", offset_of!(Receivers, size)),
            ("triangles", offset_of!(Receivers, triangles)),
            ("near_m", offset_of!(Receivers, near_m)),
            ("margin", offset_of!(Receivers, margin)),
        ];
        assert_eq!(offsets.collect::<Vec<_>>(), own, "{path}");
        assert_eq!(layout.stride as usize, size_of::<Receivers>(), "{path}");
    }
}

/// What is wrong; `None` where the device cannot.
fn asked(scene: &Scene, rival: Rival, margin_px: f64) -> Option<Wrong> {
    let devices = Devices::default();
    match scene.asked_by(&devices, rival, margin_px) {
        Err(Failure::Unable(error)) => {
            eprintln!("skipped: {error}");
            let needed = std::env::var_os("TERRAFILL_REQUIRE_DEVICE").is_some();
            assert!(rival == Rival::Rays || !needed, "{error}");
            None
        }
        asked => {
            let mut asked = asked.expect("answers");
            let mut draws = std::mem::take(&mut asked.draws);
            Some(
                scene
                    .compared(&asked, &mut draws, Counted::All)
                    .expect("judged")
                    .wrong,
            )
        }
    }
}

#[test]
fn rivals_have_the_reference_s_shadows_and_without_a_margin_those_of_themselves() {
    // The channel that sees most of the casters.
    let named = PortSize::named("port-m").expect("named");
    let views = vec![bridge([64, 48])[4]];
    let scene = Scene::of(port(named), [10.0, -60.0], views).expect("a port");
    for rival in Rival::ALL {
        let Some(own) = asked(&scene, rival, MARGIN_PX) else {
            continue;
        };
        eprintln!("{}: {own:?}", rival.name());
        assert_eq!(own.outside(), 0, "{}: {own:?}", rival.name());
        assert!(own.in_band < 100, "{}: {own:?}", rival.name());
        // Negative control: a lit face is in the shadow of itself.
        let control = asked(&scene, rival, 0.0).expect("as before");
        assert!(control.false_dark > 20, "{}: {control:?}", rival.name());
        // Negative control: a margin of many pixels loses shadows at their casters.
        let control = asked(&scene, rival, 64.0).expect("as before");
        assert!(control.false_lit > 20, "{}: {control:?}", rival.name());
    }
}
