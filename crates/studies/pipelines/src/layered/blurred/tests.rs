// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blur on devices against its definition, and what must be noticed.

use super::*;
use crate::tested::Tested;
use terrafill_results::Status;
use terrafill_shaders::struct_layout;

#[test]
fn constants_lie_as_the_shader_reads_them() {
    use std::mem::offset_of;
    let layout = struct_layout("pipelines/blurred.wgsl", "Blurred").expect("a struct");
    let offset = |name: &str| layout.offset(name).expect(name);
    assert_eq!(offset("resolve"), offset_of!(BlurredConstants, resolve));
    assert_eq!(offset("motion"), offset_of!(BlurredConstants, motion));
    assert_eq!(offset("bar"), offset_of!(BlurredConstants, bar));
    assert_eq!(offset("pixels"), offset_of!(BlurredConstants, pixels));
    assert_ne!(offset("motion"), offset_of!(BlurredConstants, bar));
}

#[test]
fn devices_blur_as_defined_and_another_exposure_is_noticed() {
    let Some(tested) = Tested::open() else {
        return;
    };
    let group = group_of(cases(true), 1);
    let verdicts = tested.verdicts(&group);
    assert!(verdicts.len() >= 60, "{}", verdicts.len());
    let way = BlurWay::Layers(Interface::Vulkan, LightWay::Passes);
    let mut rms: BTreeMap<String, f64> = BTreeMap::new();
    for (at, verdict) in verdicts {
        let (name, case) = (&group.cases[at].id.name, &group.work[at]);
        assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
        if case.way == way {
            rms.insert(case.layers_name(), verdict.figures[0].1);
        }
    }
    let at = |filter, moments, layers| BlurCase {
        way,
        made: LayerUse::Mean { filter, moments },
        layers,
    };
    let slope = |filter| {
        let error = |layers| rms[&at(filter, Moments::Middle, layers).layers_name()];
        (error(128) / error(32)).ln() / 4_f64.ln()
    };
    let (point, boxes) = (slope(Filter::Point), slope(Filter::Box));
    assert!(
        (point + 1.0).abs() < 0.15 && (boxes + 2.0).abs() < 0.15,
        "{point} {boxes}"
    );
    // Negative controls: ends instead of middles, a layer left out, and the published resolve for the right one.
    let drawn = |scene: Listed| {
        let opened = scene.open(&tested.devices, Interface::Vulkan, LightWay::Passes);
        let looked = opened.expect("opens").draw().expect("draws");
        numbers_of(&looked.picture.rgba)
    };
    let middle = at(Filter::Box, Moments::Middle, 16);
    assert_eq!(middle.judge(&drawn(middle.scene())).0, 0);
    let end = at(Filter::Box, Moments::End, 16);
    assert!(middle.judge(&drawn(end.scene())).0 > 100);
    let mut fewer = middle.scene();
    fewer.layers.pop();
    fewer.layers.push(fewer.layers[0]);
    assert!(middle.judge(&drawn(fewer)).0 > 100);
    let resolved = |resolve| BlurCase {
        made: LayerUse::Resolved(resolve),
        ..middle
    };
    let published = drawn(resolved(Resolve::Published).scene());
    assert!(resolved(Resolve::OverBackground).judge(&published).0 > 100);
}
