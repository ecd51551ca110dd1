// SPDX-License-Identifier: MIT OR Apache-2.0
//! Top caps that bring the colour, and volumes that are counted where walls are only: the same picture to the pixel.

use crate::{drawing, merged_draws};

use crate::front_caps::cap_faces;
use drawing::{AllTargets, Devices, Technique, differing, draw_with, shipped, with_switches};
use merged_draws::{SIZE, differing_when, seen, switches, techniques};
use terrafill_fill::{CoverShape, FillCommand, FillProgram, StencilOperation, Switches};
use terrafill_vertex::Layout;

fn banded(merges_draws: bool) -> Switches {
    Switches {
        counts_in_band: true,
        ..switches(merges_draws)
    }
}

#[test]
fn shipped_scenes_look_the_same_by_caps_and_a_band() {
    assert_a_band_shows_the_same(&["california", "planet-134"]);
}

#[test]
#[ignore = "needs data: natural-earth-110m"]
fn countries_look_the_same_by_caps_and_a_band() {
    assert_a_band_shows_the_same(&["countries-110m"]);
}

fn assert_a_band_shows_the_same(names: &[&str]) {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let targets = AllTargets::new(&devices, SIZE);
    for &name in names {
        let (scene, views) = shipped(name);
        for view in &views {
            let input = seen(&scene, view);
            for technique in techniques() {
                // With facets left out once more, by the technique whose caps are draws of their own.
                let leaves_out: &[bool] = match technique {
                    Technique::Vertex(variant) if variant.layout == Layout::Doubled => {
                        &[false, true]
                    }
                    _ => &[false],
                };
                for &front_caps in leaves_out {
                    let what = format!("{name}/{}: {technique:?}, {front_caps}", view.name);
                    let [plain, band] = [switches(true), banded(true)].map(|switches| {
                        let switches = Switches {
                            cap_faces: cap_faces(front_caps),
                            ..switches
                        };
                        let mut backend = targets.open(with_switches(technique, switches));
                        let frame = draw_with(&mut *backend, &input);
                        if let Some(needs) = backend.needs(&input).expect("prepared") {
                            assert_eq!(needs.undeclared(), None, "{what}");
                        }
                        frame
                    });
                    assert_eq!(differing(&plain, &band), 0, "{what}");
                }
            }
        }
    }
}

fn commands(program: &mut FillProgram) -> impl Iterator<Item = &mut Vec<FillCommand>> {
    program.passes.iter_mut().map(|pass| &mut pass.commands)
}

#[test]
fn a_step_less_is_seen() {
    let Some(devices) = Devices::open_both() else {
        return;
    };
    let (scene, views) = shipped("planet-134");
    let targets = AllTargets::new(&devices, SIZE);
    let input = seen(&scene, &views[0]);
    for merges in [false, true] {
        let wrong = |change: &dyn Fn(&mut FillProgram)| {
            differing_when(&targets, &input, banded(merges), |program, _| {
                change(program)
            })
        };
        assert_eq!(wrong(&|_| ()), 0);
        let without = |drops: fn(&FillCommand) -> bool| {
            wrong(&move |program| {
                commands(program).for_each(|commands| commands.retain(|command| !drops(command)));
            })
        };
        // No band: caps are coloured wherever they are seen, beside their walls too, and nothing is counted.
        let bandless = without(
            |command| matches!(command, FillCommand::Volumes { rule, .. } if rule.operation == StencilOperation::SetBand),
        );
        let capless = without(
            |command| matches!(command, FillCommand::Cover { shape, .. } if *shape == CoverShape::Cap),
        );
        let uncounted = without(
            |command| matches!(command, FillCommand::Volumes { rule, .. } if rule.required_bits() != 0),
        );
        assert!(
            bandless > 20 && capless > 200 && uncounted > 20,
            "{bandless} {capless} {uncounted}"
        );
    }
}
