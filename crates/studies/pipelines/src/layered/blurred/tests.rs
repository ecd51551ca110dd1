// SPDX-License-Identifier: MIT OR Apache-2.0
//! Blur on devices against rays, and what must be noticed.

use super::*;
use crate::tested::Tested;
use terrafill_results::Status;
use terrafill_shaders::struct_layout;

/// Of tests' pictures, pixels.
const SIDE: u32 = 128;

#[test]
fn constants_lie_as_the_shader_reads_them() {
    use std::mem::offset_of;
    let layout = struct_layout("pipelines/blurred.wgsl", "Blurred").expect("a struct");
    let offset = |name: &str| layout.offset(name).expect(name);
    assert_eq!(offset("count"), offset_of!(BlurredConstants, count));
    assert_eq!(offset("resolve"), offset_of!(BlurredConstants, resolve));
    assert_eq!(offset("tile"), offset_of!(BlurredConstants, tile));
    assert_ne!(offset("tile"), offset_of!(BlurredConstants, resolve));
}

#[test]
fn what_a_resolve_allows_follows_its_weights() {
    let close = |found: [f64; 2], expected: [f64; 2]| {
        found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12)
    };
    let covered = [[0.5; 2], [0.0; 2], [0.8; 2]];
    let resolved = |resolve, ranges: &[[f64; 2]]| LayerUse::Resolved(resolve).allowed(ranges);
    let mean = LayerUse::Mean.allowed(&covered);
    assert!(close(mean, [1.3 / 3.0; 2]));
    // Weights 1, 2, 1; the second has no alpha.
    let published = resolved(Resolve::Published, &covered);
    assert!(close(published, [1.3 / 2.0; 2]));
    assert!(close(
        resolved(Resolve::OverBackground, &covered),
        [1.3 / 4.0; 2]
    ));
    assert!(close(
        resolved(Resolve::CurrentFirst, &covered),
        [2.3 / 6.0; 2]
    ));
    assert_eq!(resolved(Resolve::Published, &[[0.0; 2]; 3]), [0.0; 2]);
    let bordered = resolved(Resolve::Published, &[[0.0, 0.5], [0.6, 0.7]]);
    assert!(close(bordered, [0.3, 0.7]));
    // Negative control: a border leaves the mean less room.
    assert!(LayerUse::Mean.allowed(&[[0.0, 0.5], [0.6, 0.7]])[0] > 0.2);
}

#[test]
fn devices_blur_as_rays_do_and_another_exposure_is_noticed() {
    let Some(tested) = Tested::open() else {
        return;
    };
    let shared = Shared::default();
    let mut rms: BTreeMap<(u32, &str), f64> = BTreeMap::new();
    for layers in [2, 8, 32] {
        let group = group(layers, Rc::clone(&shared), QUICK_LEVEL, SIDE, 1);
        let verdicts = tested.verdicts(&group);
        assert!(verdicts.len() >= 6, "{}", verdicts.len());
        for (at, verdict) in verdicts {
            let (name, case) = (&group.cases[at].id.name, &group.work.cases[at]);
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            if matches!(case.way.name(), "passes" | "vertex-layer") {
                rms.insert((layers, case.made.name()), verdict.figures[0].1);
            }
        }
    }
    for made in ["middle", "jittered"] {
        let [few, many] = [2, 32].map(|layers| rms[&(layers, made)]);
        assert!(many < 0.2 * few, "{made}: {few} {many}");
    }
    // A side that cuts the last tiles, and whose viewport is scaled with rounding.
    let cut = group(2, Shared::default(), QUICK_LEVEL, 75, 1);
    for (_, verdict) in tested.verdicts(&cut) {
        assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
    }
    // Negative controls: other moments, a layer left out, the published resolve for the right one, and exchanged
    // pixels of a tile.
    let turning = shared.get().expect("opened");
    let drawn = |scene: Listed| {
        let opened = scene.open(&tested.devices, Interface::Vulkan, LightWay::Passes);
        let looked = opened.expect("opens").draw().expect("draws");
        numbers_of(&looked.picture.rgba)
    };
    let case = |made| BlurCase {
        way: BlurWay::Layers(Interface::Vulkan, LightWay::Passes),
        made,
        layers: 8,
    };
    let wrong = |made: LayerUse, scene: Listed| {
        let ranges = turning.ranges(&made.layers(8), made.tile());
        case(made).judge(turning, &ranges, &drawn(scene), SIDE).0
    };
    let scene = |made| case(made).scene(turning, SIDE);
    let (mean, jittered) = (LayerUse::Mean, LayerUse::Jittered);
    let [published, over] = [Resolve::Published, Resolve::OverBackground].map(LayerUse::Resolved);
    assert_eq!(wrong(mean, scene(mean)), 0);
    assert!(wrong(mean, scene(over)) > 20);
    let mut fewer = scene(mean);
    fewer.layers.pop();
    fewer.layers.push(fewer.layers[0]);
    assert!(wrong(mean, fewer) > 20);
    assert!(wrong(over, scene(published)) > 20);
    // A layer left out of a sum is more than its roundings.
    for (accumulator, layers) in [
        (Accumulator::F32, 32),
        (Accumulator::F16, 32),
        (Accumulator::Eight, 8),
    ] {
        let of = BlurCase {
            way: BlurWay::Added(accumulator),
            layers,
            ..case(mean)
        };
        let ranges = turning.ranges(&mean.layers(layers), mean.tile());
        let wrong = |scene: &Listed| {
            let opened = of.way.open(&tested.devices, scene);
            let looked = opened.expect("opens").draw().expect("draws");
            let numbers = numbers_of(&looked.picture.rgba);
            of.judge(turning, &ranges, &numbers, SIDE).0
        };
        let mut fewer = of.scene(turning, SIDE);
        assert_eq!(wrong(&fewer), 0, "{accumulator:?}");
        fewer.layers.pop();
        fewer.layers.push(fewer.layers[0]);
        assert!(wrong(&fewer) > 20, "{accumulator:?}");
    }
    let mut exchanged = scene(jittered);
    exchanged.layers.rotate_left(8);
    assert!(wrong(jittered, exchanged) > 20);
}
