// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shadows on devices against their formulas, and what must be noticed.

use super::*;
use crate::draws::Looked;
use crate::images::run_folder;
use std::rc::Rc;
use terrafill_contract::Devices;
use terrafill_results::Status;

fn figure(verdict: &Verdict, name: &str) -> f64 {
    let figure = verdict.figures.iter().find(|figure| figure.0 == name);
    figure.unwrap_or_else(|| panic!("{name} in {verdict:?}")).1
}

fn has_devices(devices: &Devices) -> bool {
    let wgpu = terrafill_gpu::shared_gpu(devices).map(drop);
    let vulkan = terrafill_vulkan::shared_gpu(devices).map(drop);
    terrafill_contract::device_for_test(wgpu).is_some()
        && terrafill_contract::device_for_test(vulkan).is_some()
}

#[test]
fn devices_show_what_the_formulas_allow() {
    let devices = Rc::new(Devices::default());
    if !has_devices(&devices) {
        return;
    }
    let group = group_of(cases(true), 1);
    let folder = run_folder();
    let context = Context {
        devices: &devices,
        folder: folder.path(),
    };
    let mut session = group.open(context).expect("opens");
    let mut right = 0;
    for (at, (planned, case)) in group.cases.iter().zip(&group.work).enumerate() {
        let verdict = session.verify(at).expect("a verdict");
        let name = &planned.id.name;
        eprintln!("{name}: {} {:?}", verdict.reason, verdict.figures);
        if verdict.status == Status::Skipped {
            continue;
        }
        assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
        right += 1;
        match case.shade {
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
    assert!(right >= 30, "{right}");
}

#[test]
fn other_moments_other_maps_and_a_light_that_is_aside_are_noticed() {
    let devices = Devices::default();
    if !has_devices(&devices) {
        return;
    }
    let draw = |scene: &super::super::listed::Listed| -> Looked {
        let opened = scene.open(&devices, Interface::Vulkan, LightWay::Passes);
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
