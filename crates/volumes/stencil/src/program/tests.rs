// SPDX-License-Identifier: MIT OR Apache-2.0
//! Programs of fills: which passes they have for which switches, and what is refused.

use super::*;
use crate::DepthRange;
use terrafill_plan::PixelRect;

fn volume(index: usize, left: u32, cut: bool) -> Volume {
    Volume {
        geometry: index,
        depth: DepthRange::ANY,
        screen_rect: PixelRect {
            left,
            top: 0,
            right: left + 10,
            bottom: 10,
        },
        near_rectangle: NearRectangle::by_bounds(cut),
        drawn_as: DrawnAs::Volume,
    }
}

/// Three volumes, the last two over each other, the middle one cut by the near plane.
fn three() -> [Volume; 3] {
    [
        volume(0, 0, false),
        volume(1, 20, true),
        volume(2, 25, false),
    ]
}

/// How often each volume is marked by front and by back faces, and covered.
fn tally(program: &FillProgram, volumes: usize) -> Vec<[usize; 3]> {
    let mut tally = vec![[0; 3]; volumes];
    for command in program.commands() {
        match command {
            FillCommand::Volumes {
                rule: StencilRule { faces, .. },
                volumes,
                ..
            }
            | FillCommand::Accumulate { faces, volumes, .. } => {
                for &volume in volumes {
                    tally[volume][0] += usize::from(*faces != FaceSet::Back);
                    tally[volume][1] += usize::from(*faces != FaceSet::Front);
                }
            }
            FillCommand::Resolve => {
                for volume in &mut tally {
                    volume[2] += 1;
                }
            }
            FillCommand::Cover { volumes, .. } => {
                for &volume in volumes {
                    tally[volume][2] += 1;
                }
            }
        }
    }
    tally
}

/// Of volumes that do not overlap.
fn disjoint(volumes: &[Volume], switches: &Switches) -> FillProgram {
    FillProgram::new(volumes, switches, Overlap::Disjoint).expect("allowed")
}

fn every_combination() -> Vec<Switches> {
    let mut all = Vec::new();
    for colour in ColourWay::ALL {
        for faces in [FacePasses::TwoSided, FacePasses::TwoPass] {
            for depth_rule in [
                DepthRuleChoice::Fail,
                DepthRuleChoice::Pass,
                DepthRuleChoice::Automatic,
            ] {
                for bottom_cap in [
                    BottomCap::Always,
                    BottomCap::FirstPass,
                    BottomCap::WhereNeeded,
                ] {
                    for flags in 0..4 {
                        all.push(Switches {
                            colour,
                            faces,
                            depth_rule,
                            bottom_cap,
                            scissor: flags & 1 != 0,
                            cover_culls_faces: flags & 2 != 0,
                            ..Switches::default()
                        });
                    }
                }
            }
        }
    }
    all
}

#[test]
fn whatever_the_switches_each_face_marks_once_and_each_region_is_covered_once() {
    for switches in every_combination() {
        let program = disjoint(&three(), &switches);
        let tally = tally(&program, 3);
        for (index, [front, back, covers]) in tally.into_iter().enumerate() {
            assert_eq!((front, back), (1, 1), "{switches:?}");
            let expected = usize::from(switches.colour != ColourWay::OneColour || index == 0);
            assert_eq!(covers, expected, "{switches:?}");
        }
        let accumulates = switches.colour == ColourWay::IdAccumulation;
        assert_eq!(program.passes[0].accumulates(), accumulates);
        assert_eq!(program.passes[0].clears_stencil, !accumulates);
        let mut passes = program.passes.iter();
        assert!(passes.all(|pass| pass.touches_stencil() != accumulates));
    }
}

#[test]
fn bits_that_are_kept_are_neither_marked_nor_tested() {
    let many: Vec<Volume> = (0..5).map(|index| volume(index, 0, false)).collect();
    // All five lie over each other: 3 numbers or 2 planes a pass.
    for (colour, passes) in [(ColourWay::Xor, 2), (ColourWay::BitPlanes, 3)] {
        let bits_of = |kept_stencil_bits| {
            let switches = Switches {
                colour,
                kept_stencil_bits,
                ..Switches::default()
            };
            let program = disjoint(&many, &switches);
            let bits = program.commands().map(|command| match command {
                FillCommand::Volumes { rule, .. } => match rule.operation {
                    StencilOperation::Invert { mask } => mask,
                    other @ StencilOperation::Count => panic!("{other:?}"),
                },
                FillCommand::Cover { test, .. } => test.read_mask,
                other => panic!("{other:?}"),
            });
            let used = bits.fold(0, |all, bits| all | bits);
            (used, program.passes.len())
        };
        assert_eq!(bits_of(6), (0b11, 2 * passes), "{colour:?}");
        // Negative control: with all bits one pass of each kind does, by more than two bits.
        let (used, all) = bits_of(0);
        assert!(used > 0b11 && all == 2, "{colour:?}");
    }
}

#[test]
fn covers_look_at_no_more_bits_than_numbers_have() {
    let switches = Switches::default();
    let many: Vec<Volume> = (0..5).map(|index| volume(index, 0, false)).collect();
    for (volumes, numbers, bits) in [(&many[..1], 1, 1), (&many[..3], 3, 3), (&many[..], 5, 7)] {
        let program = disjoint(volumes, &switches);
        let tests = program.commands().filter_map(|command| match command {
            FillCommand::Cover { test, .. } => Some((test.reference, test.read_mask)),
            _ => None,
        });
        let expected = (1..=numbers).map(|number| (number, bits));
        assert!(tests.eq(expected), "{numbers}");
        // Negative control: one bit less would take the largest number for another one.
        assert_ne!(numbers & (bits >> 1), numbers);
    }
}

#[test]
fn a_flat_volume_is_covered_once_and_marks_nothing() {
    for switches in every_combination() {
        let mut volumes = three();
        volumes[0].drawn_as = DrawnAs::FlatMesh;
        let program = disjoint(&volumes, &switches);
        let own: Vec<_> = program
            .commands()
            .filter(|command| {
                matches!(
                    command,
                    FillCommand::Cover {
                        shape: CoverShape::Flat,
                        ..
                    }
                )
            })
            .collect();
        let [
            FillCommand::Cover {
                test,
                volumes: flat,
                ..
            },
        ] = own[..]
        else {
            panic!("{switches:?}: {own:?}");
        };
        assert_eq!((test, flat.as_slice()), (&StencilTest::ANYWHERE, &[0][..]));
        let resolved = usize::from(switches.colour == ColourWay::IdAccumulation);
        let tally = tally(&program, 3);
        assert_eq!(tally[0], [0, 0, 1 + resolved], "{switches:?}");
        // Negative control: the others are drawn as without it.
        for [front, back, _] in &tally[1..] {
            assert_eq!((*front, *back), (1, 1), "{switches:?}");
        }
        let is_last = program.passes.last().is_some_and(|pass| pass.has_colour);
        assert!(is_last, "{switches:?}");
        // Where all are flat, nothing clears or marks.
        for volume in &mut volumes {
            volume.drawn_as = DrawnAs::FlatMesh;
        }
        let program = disjoint(&volumes, &switches);
        assert_eq!(program.passes.len(), 1, "{switches:?}");
        assert_eq!(program.counted().count(), 0, "{switches:?}");
        assert!(!program.passes[0].touches_stencil(), "{switches:?}");
    }
}

#[test]
fn flat_volumes_need_regions_that_do_not_overlap() {
    let mut volumes = three();
    let switches = Switches::for_overlap(Overlap::Ordered);
    assert!(FillProgram::new(&volumes, &switches, Overlap::Ordered).is_ok());
    volumes[2].drawn_as = DrawnAs::FlatMesh;
    let refused = FillProgram::new(&volumes, &switches, Overlap::Ordered).expect_err("order");
    assert!(refused.to_string().contains("overlap=ordered"), "{refused}");
}

#[test]
fn what_marks_is_counted_once_more_and_nothing_else() {
    for switches in every_combination() {
        let program = disjoint(&three(), &switches);
        let mut counted = Vec::new();
        for command in program.commands() {
            let (faces, without_bottom, scissor, volumes) = match command {
                FillCommand::Volumes {
                    rule,
                    without_bottom,
                    scissor,
                    volumes,
                } => (rule.faces, without_bottom, scissor, volumes),
                FillCommand::Accumulate {
                    faces,
                    without_bottom,
                    scissor,
                    volumes,
                    ..
                } => (*faces, without_bottom, scissor, volumes),
                FillCommand::Cover { .. } | FillCommand::Resolve => continue,
            };
            counted.push(crate::VolumeDraw {
                state: crate::VolumeState::Count { faces },
                without_bottom: *without_bottom,
                scissor: *scissor,
                volumes,
            });
        }
        assert_eq!(program.counted().collect::<Vec<_>>(), counted);
        let commands = program.commands().count();
        let covers = commands - counted.len();
        assert!(covers > 0 && !counted.is_empty(), "{switches:?}");
        let steps: usize = program.passes.iter().map(|pass| pass.steps().count()).sum();
        assert_eq!(steps, commands);
    }
}

#[test]
fn a_closed_volume_counts_one_inside_and_none_outside() {
    // One ray through a convex volume: a front face at 1, a back face at 3.
    let count = |depth: DepthRule, surface: i32| {
        let rule = StencilRule {
            depth,
            operation: StencilOperation::Count,
            faces: FaceSet::Both,
        };
        let (front, back, _) = rule.effects();
        let mut stencil = 0_u8;
        for (distance, effect) in [(1, front), (3, back)] {
            let is_behind = distance > surface;
            if is_behind != (depth == DepthRule::Fail) {
                continue;
            }
            stencil = match effect {
                FaceEffect::Add => stencil.wrapping_add(1),
                FaceEffect::Take => stencil.wrapping_sub(1),
                FaceEffect::Invert => !stencil,
            };
        }
        stencil
    };
    for depth in [DepthRule::Fail, DepthRule::Pass] {
        assert_eq!([0, 2, 4].map(|surface| count(depth, surface)), [0, 1, 0]);
    }
    let number = StencilRule {
        depth: DepthRule::Fail,
        operation: StencilOperation::Invert { mask: 6 },
        faces: FaceSet::Both,
    };
    assert_eq!(
        number.effects(),
        (FaceEffect::Invert, FaceEffect::Invert, 6)
    );
}

#[test]
fn the_depth_rule_is_chosen_per_region() {
    let rules = |choice| {
        let switches = Switches {
            depth_rule: choice,
            bottom_cap: BottomCap::WhereNeeded,
            colour: ColourWay::OneColour,
            ..Switches::default()
        };
        let program = disjoint(&three(), &switches);
        let mut rules = Vec::new();
        for command in program.commands() {
            if let FillCommand::Volumes {
                rule,
                without_bottom,
                volumes,
                ..
            } = command
            {
                // A bottom cap may be missing only where fragments in front count.
                assert_eq!(*without_bottom, rule.depth == DepthRule::Pass);
                rules.extend(volumes.iter().map(|&volume| (volume, rule.depth)));
            }
        }
        rules.sort_unstable();
        rules
    };
    let [fail, pass] = [DepthRule::Fail, DepthRule::Pass];
    assert_eq!(
        rules(DepthRuleChoice::Automatic),
        [(0, pass), (1, fail), (2, pass)]
    );
    assert_eq!(
        rules(DepthRuleChoice::Pass),
        [(0, pass), (1, pass), (2, pass)]
    );
}

#[test]
fn a_volume_around_the_eye_is_counted_in_front_and_marks_what_lies_outside() {
    let mut volumes = three();
    volumes[1].near_rectangle = NearRectangle::Within;
    let program = |depth_rule, volumes: &[Volume]| {
        let switches = Switches {
            depth_rule,
            bottom_cap: BottomCap::WhereNeeded,
            scissor: true,
            ..Switches::default()
        };
        disjoint(volumes, &switches)
    };
    // Of each volume: whether it counts in front, is cut to its rectangle and has a bottom; its number and test.
    let told = |program: &FillProgram| {
        let mut told = [(false, false, false, 0, 0); 3];
        for command in program.commands() {
            match command {
                FillCommand::Volumes {
                    rule,
                    without_bottom,
                    scissor,
                    volumes,
                } => {
                    let (_, _, number) = rule.effects();
                    for &volume in volumes {
                        let is_in_front = rule.depth == DepthRule::Pass;
                        told[volume] = (is_in_front, *scissor, !without_bottom, number, 0);
                    }
                }
                FillCommand::Cover { test, volumes, .. } => {
                    for &volume in volumes {
                        told[volume].4 = test.reference;
                    }
                }
                other => panic!("{other:?}"),
            }
        }
        told
    };
    let uncut = told(&program(DepthRuleChoice::Uncut, &volumes));
    // It flips what is not inside: 1 where nothing is, 0 inside the first and inside itself, 3 inside the last.
    assert_eq!(
        uncut,
        [
            (true, true, false, 1, 0),
            (true, false, false, 1, 0),
            (true, true, false, 2, 3)
        ]
    );
    // Negative controls: counted behind the surface it marks what is inside, as does one that the near
    // plane cuts.
    let behind = [
        (true, true, false, 1, 1),
        (false, true, true, 1, 1),
        (true, true, false, 2, 2),
    ];
    assert_eq!(told(&program(DepthRuleChoice::Automatic, &volumes)), behind);
    assert_eq!(told(&program(DepthRuleChoice::Uncut, &three())), behind);
    // A count cannot tell what was marked from outside.
    let counted = Switches {
        depth_rule: DepthRuleChoice::Uncut,
        colour: ColourWay::Rectangle,
        ..Switches::default()
    };
    let refused = FillProgram::new(&volumes, &counted, Overlap::Disjoint).expect_err("counts");
    assert!(refused.to_string().contains("colour=xor"), "{refused}");
}

#[test]
fn a_cut_volume_is_covered_by_its_back_faces() {
    let switches = Switches {
        colour: ColourWay::Volume,
        cover_culls_faces: true,
        ..Switches::default()
    };
    let program = FillProgram::new(&three(), &switches, Overlap::Ordered).expect("allowed");
    let shapes: Vec<CoverShape> = program
        .commands()
        .filter_map(|command| match command {
            FillCommand::Cover { shape, .. } => Some(*shape),
            _ => None,
        })
        .collect();
    let by = |faces| CoverShape::Volume {
        faces,
        without_bottom: false,
    };
    assert_eq!(
        shapes,
        [by(FaceSet::Front), by(FaceSet::Back), by(FaceSet::Front)]
    );
}

#[test]
fn only_a_volume_that_the_near_plane_cuts_is_coloured_with_its_bottom() {
    for colour in [ColourWay::Volume, ColourWay::OneColourVolumes] {
        for bottom_cap in [
            BottomCap::Always,
            BottomCap::FirstPass,
            BottomCap::WhereNeeded,
        ] {
            let switches = Switches {
                colour,
                bottom_cap,
                ..Switches::default()
            };
            let program = disjoint(&three(), &switches);
            for command in program.commands() {
                match command {
                    FillCommand::Cover {
                        shape: CoverShape::Volume { without_bottom, .. },
                        volumes,
                        ..
                    } => {
                        let left_out = bottom_cap != BottomCap::Always && *volumes != [1];
                        assert_eq!(*without_bottom, left_out, "{volumes:?}: {switches:?}");
                    }
                    // Behind the surface every cap counts.
                    FillCommand::Volumes { without_bottom, .. } => assert!(!without_bottom),
                    other => panic!("{other:?}"),
                }
            }
        }
    }
}

#[test]
fn later_regions_cover_earlier_ones_whatever_the_way() {
    let many: Vec<Volume> = (0..40).map(|i| volume(i, 0, false)).collect();
    for colour in [
        ColourWay::Rectangle,
        ColourWay::Volume,
        ColourWay::BitPlanes,
    ] {
        let switches = Switches {
            colour,
            ..Switches::default()
        };
        let program = FillProgram::new(&many, &switches, Overlap::Ordered).expect("allowed");
        let covers: Vec<usize> = program
            .commands()
            .filter_map(|command| match command {
                FillCommand::Cover { volumes, .. } => Some(volumes.clone()),
                _ => None,
            })
            .flatten()
            .collect();
        assert_eq!(covers, (0..40).collect::<Vec<_>>(), "{colour:?}");
    }
}

#[test]
fn a_count_that_could_wrap_to_nothing_is_refused() {
    let one_colour = Switches {
        colour: ColourWay::OneColour,
        ..Switches::default()
    };
    let nested = |count| -> Vec<Volume> { (0..count).map(|i| volume(i, 0, false)).collect() };
    let program = |count, overlap| FillProgram::new(&nested(count), &one_colour, overlap);
    assert!(program(255, Overlap::Ordered).is_ok());
    let error = program(256, Overlap::Ordered).expect_err("wraps");
    assert!(
        error.to_string().contains("found 256, allowed 255"),
        "{error}"
    );
    // Side by side, or promised to be disjoint, any number is countable.
    let apart: Vec<Volume> = (0..600)
        .map(|i| volume(i as usize, 20 * i, false))
        .collect();
    assert!(FillProgram::new(&apart, &one_colour, Overlap::Ordered).is_ok());
    assert!(program(600, Overlap::Disjoint).is_ok());
}

#[test]
fn numbers_that_a_float_would_round_are_refused() {
    let accumulate = Switches {
        colour: ColourWay::IdAccumulation,
        ..Switches::default()
    };
    let apart = |count| -> Vec<Volume> { (0..count).map(|i| volume(i, 0, false)).collect() };
    let program = |count| FillProgram::new(&apart(count), &accumulate, Overlap::Disjoint);
    assert!(program(ACCUMULABLE).is_ok());
    assert!(program(ACCUMULABLE + 1).is_err());
    let sum: usize = (1..=ACCUMULABLE).sum();
    assert!(2 * sum <= 1 << 24);
    assert!(2 * (sum + ACCUMULABLE + 1) > 1 << 24);
    let error = FillProgram::new(&apart(2), &accumulate, Overlap::Ordered);
    assert!(error.is_err(), "two numbers over one pixel make a third");
}

#[test]
fn nothing_planned_is_nothing_to_do() {
    let program = FillProgram::new(&[], &Switches::default(), Overlap::Disjoint);
    assert_eq!(program.expect("allowed").passes, Vec::new());
}
