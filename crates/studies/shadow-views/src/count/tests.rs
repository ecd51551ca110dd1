// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every rule against the reference, and controls that must be wrong.

use super::*;
use crate::reference::Reference;
use crate::view::{bridge, sun};
use terrafill_casters::{
    EdgeTable, Extent, Face, Facing, Policy, PortSize, Prepared, Side, VolumeTriangle, hull, port,
    sea_level_below,
};

fn is_cap(face: Face) -> bool {
    face != Face::Side
}

/// Casters under a sun, seen in a channel of the bridge.
struct Setting {
    prepared: Prepared,
    facing: Facing,
    sides: Vec<Side>,
    to_light: DVec3,
    view: DeckCamera,
    truth: Truth,
}

impl Setting {
    fn new(mesh: Mesh, at: [f64; 2]) -> Self {
        let to_light = sun(at);
        let prepared = Policy::Refuse.prepare(mesh).expect("closed");
        let facing = Facing::of(&prepared.mesh, to_light);
        let view = bridge([64, 48])[4];
        let truth = Reference::new(&prepared.mesh, to_light).picture(&view);
        Self {
            sides: EdgeTable::of(&prepared.mesh).silhouette(&facing),
            truth,
            prepared,
            facing,
            to_light,
            view,
        }
    }

    fn volume(&self, extent: &Extent) -> Volume {
        let (prepared, facing) = (&self.prepared, &self.facing);
        Volume::of(prepared, facing, &self.sides, self.to_light, extent).expect("from above")
    }

    fn closed(&self) -> Extent {
        Extent::ClosedAt(sea_level_below(&self.prepared.mesh, self.to_light, 1.0).expect("above"))
    }

    fn stencil(&self, volume: &Volume, rule: Rule) -> Stencil {
        let mesh = &self.prepared.mesh;
        let pass = Pass {
            parts: vec![Some((rule, self.view.whole())); mesh.parts.len()],
            bounds: Vec::new(),
        };
        Stencil::of(&self.view, mesh, volume, &self.truth, &pass)
    }

    fn wrong(&self, volume: &Volume, rule: Rule) -> Wrong {
        Wrong::of(&self.stencil(volume, rule).mask(), &self.truth)
    }
}

#[test]
fn every_rule_and_extent_has_the_mask_of_the_reference() {
    for mesh in [port(PortSize::NAMED[1].1), hull(600)] {
        for at in [[60.0, 90.0], [10.0, -60.0], [1.0, 0.0]] {
            let setting = Setting::new(mesh.clone(), at);
            for extent in [Extent::Infinite, setting.closed()] {
                let volume = setting.volume(&extent);
                let mut counts = Vec::new();
                for rule in [Rule::Pass, Rule::Fail, Rule::Preload] {
                    let wrong = setting.wrong(&volume, rule);
                    assert_eq!(wrong, Wrong::default(), "{at:?}, {rule:?}, {extent:?}");
                    counts.push(setting.stencil(&volume, rule));
                }
                assert_eq!(
                    counts[0].counts, counts[1].counts,
                    "rules agree in every count"
                );
                assert_eq!(counts[1].counts, counts[2].counts);
                assert!(counts[2].updates > counts[1].updates);
            }
        }
    }
}

#[test]
fn twins_are_seen_misprint_dropped_side_and_clipped_cap() {
    let setting = Setting::new(port(PortSize::NAMED[1].1), [30.0, -60.0]);
    let volume = setting.volume(&setting.closed());
    let wrong = |volume: &Volume, rule| setting.wrong(volume, rule).outside();
    assert_eq!(wrong(&volume, Rule::Fail), 0);
    let printed = wrong(&volume, Rule::PassAsPrinted);
    assert!(printed > 100, "{printed}");
    let mut capless = volume.clone();
    capless.triangles.retain(|triangle| !is_cap(triangle.face));
    assert_eq!(wrong(&capless, Rule::Pass), 0, "z-pass needs no caps");
    assert!(wrong(&capless, Rule::Fail) > 100, "and z-fail does");
    // The side that writes the most is dropped: a streak over all that it wrote.
    let alone = |triangle: &VolumeTriangle| {
        let mut alone = volume.clone();
        alone.triangles = vec![*triangle];
        setting.stencil(&alone, Rule::Fail).updates
    };
    let sides = volume
        .triangles
        .iter()
        .filter(|triangle| !is_cap(triangle.face));
    let largest = sides.max_by_key(|triangle| alone(triangle)).expect("some");
    let mut streak = volume.clone();
    streak.triangles.retain(|triangle| triangle != largest);
    let stencil = setting.stencil(&streak, Rule::Fail);
    let whole = setting.stencil(&volume, Rule::Fail);
    let counts = stencil.counts.iter().zip(&whole.counts);
    let differing = counts.filter(|(a, b)| a != b).count() as u64;
    assert!(differing > 20 && differing == alone(largest), "{differing}");
    assert!(wrong(&streak, Rule::Fail) > 0);
}

#[test]
fn a_sliver_is_one_where_it_is_thin() {
    let view = DeckCamera::level(DVec3::ZERO, 0.0, 0.5, [64, 48]);
    let at = 24 * 64 + 32;
    let volume = |px: f64| {
        let places = [[-4.0, -px], [4.0, -px], [0.0, 2.0 * px]].map(|[right, down]| {
            let ray = view.ray_beside(32, 24, [right, down]);
            (view.eye + ray * 10.0).extend(1.0)
        });
        Volume {
            vertices: places.to_vec(),
            triangles: vec![VolumeTriangle {
                corners: [0, 1, 2],
                part: 0,
                face: Face::Side,
            }],
        }
    };
    let holds = |px, at: usize| slivers(&view, &volume(px), 1.0 / 32.0)[at];
    assert!(holds(0.01, at));
    assert!(!holds(0.3, at), "thick");
    assert!(!holds(0.01, at + 64), "beside");
}

#[test]
fn a_finite_volume_loses_what_lies_beyond_it() {
    let setting = Setting::new(port(PortSize::NAMED[1].1), [5.0, -60.0]);
    let wrong = |length: f64| {
        let volume = setting.volume(&Extent::Finite(length));
        setting.wrong(&volume, Rule::Fail).outside()
    };
    assert_eq!(wrong(10_000.0), 0);
    assert!(wrong(10.0) > 20, "{}", wrong(10.0));
}
