// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows on devices against their formulas, and what must be noticed.

use super::*;
use crate::draws::Looked;
use crate::tested::{Tested, figure};
use terrafill_results::Status;

#[test]
fn devices_show_what_the_formulas_allow() {
    let Some(tested) = Tested::open() else {
        return;
    };
    let group = group_of(cases(true), 1);
    let verdicts = tested.verdicts(&group);
    assert!(verdicts.len() >= 30, "{}", verdicts.len());
    for (at, verdict) in verdicts {
        let name = &group.cases[at].id.name;
        assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
        match group.work[at].shade {
            Shade::Rough {
                moments: Moments::FromReceiver,
                ..
            } => assert!(figure(&verdict, "variance_relative_rms") <= 2e-6, "{name}"),
            Shade::Terraces {
                moments: Moments::Published,
                least,
                ..
            } => {
                let dark = figure(&verdict, "variance_dark_share");
                assert_eq!(dark > 0.0, least.is_none(), "{name}: {dark}");
            }
            Shade::Hard { .. } => {
                let share = figure(&verdict, "hard_area_share");
                assert!((share - 0.244).abs() < 0.01, "{name}: {share}");
            }
            _ => {}
        }
    }
}

#[test]
fn other_moments_other_maps_and_a_light_that_is_aside_are_noticed() {
    let Some(tested) = Tested::open() else {
        return;
    };
    let draw = |scene: &super::super::listed::Listed| -> Looked {
        let opened = scene.open(&tested.devices, Interface::Vulkan, LightWay::Passes);
        opened.expect("opens").draw().expect("draws")
    };
    let rough = |moments| Shade::Rough {
        moments,
        sigma: 1e-4,
    };
    // The published noise is beyond what depths less the receiver's allow.
    let published = draw(&rough(Moments::Published).scene());
    assert_eq!(rough(Moments::Published).judge(&published).wrong, 0);
    assert!(rough(Moments::FromReceiver).judge(&published).wrong > 1_000);
    let disc = Shade::Disc {
        moments: Moments::FromReceiver,
        texels: 128,
        least: Some(LEAST),
    };
    let mut looked = draw(&disc.scene());
    assert_eq!(
        disc.judge(&looked).wrong + disc.judge(&looked).wrong_texels,
        0
    );
    // A light that is two texels aside, whose picture agrees with its own maps.
    let mut aside = disc.scene();
    for layer in &mut aside.layers {
        *layer = crate::lights::LightColumns::sheared([2.0 / 128.0; 2], [0.2; 2], 0.2);
    }
    assert!(disc.judge(&draw(&aside)).wrong_texels > 100);
    // Maps that are five texels aside.
    looked.depths.rotate_left(5);
    assert!(disc.judge(&looked).wrong > 100);
    let hard = Shade::Hard { texels: 64 };
    let mut looked = draw(&hard.scene());
    assert_eq!(hard.judge(&looked).wrong, 0);
    looked.picture.rgba.rotate_right(4 * 40);
    assert!(hard.judge(&looked).wrong > 100);
}
