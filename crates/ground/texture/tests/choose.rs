// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chooser over extents, latitudes and heights: what it takes holds at places it did not look
//! at, nothing cheaper would do, and mutants are noticed.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_texture::{
    Arithmetic, Chooser, CoordinateRoute, Demand, MAX_TOLERANCE, MapExtent, MapRegion, Operations,
    RMS_TOLERANCE, Reason, SAMPLING_SLACK, Step, SuiteCell, SuiteFinding,
};

const EXTENTS_DEG: [f64; 9] = [1e-3, 1e-2, 0.1, 1.0, 5.0, 10.0, 40.0, 90.0, 360.0];
const LATITUDES_DEG: [f64; 5] = [0.0, 45.0, 70.0, 85.0, 90.0];
const HEIGHTS_M: [(f64, f64); 4] = [(0.0, 0.0), (0.0, 1e4), (-1e4, 0.0), (-1e5, 1e5)];

/// As wide as high, as far as the body goes; at a pole all round it, with the pole for anchor.
fn region(extent_deg: f64, latitude_deg: f64, heights_m: (f64, f64)) -> MapRegion {
    let half = 0.5 * extent_deg;
    let south = (latitude_deg - half).max(-90.0);
    let north = (latitude_deg + half).min(90.0);
    let (west, east) = if latitude_deg > 89.0 {
        (-180.0, 180.0)
    } else {
        (20.0 - half, 20.0 + half)
    };
    let extent = MapExtent::from_degrees(west, south, east, north);
    MapRegion::anchored(Ellipsoid::WGS84, extent, heights_m).expect("a region")
}

fn chooser() -> Chooser {
    Chooser::new(&Chooser::default_candidates(), Vec::new())
}

/// A texture of 4096² and a view from so far that only the texture decides.
fn textured(region: MapRegion) -> Demand {
    Demand {
        region,
        texture_size: [4096, 4096],
        pixel_m: 1e9,
    }
}

/// What emulation finds at places the chooser has not looked at.
#[derive(Debug, Default)]
struct Measured {
    rms_texels: f64,
    max_texels: f64,
    max_m: f64,
    non_finite: u32,
}

/// Emulates with `fma` rounded once and twice on a grid that goes over all of the region.
fn measure(route: CoordinateRoute, constants: &[[f32; 4]], demand: &Demand) -> Measured {
    const STEPS: u16 = 15;
    let program = route.program();
    let region = &demand.region;
    let extent = region.extent();
    let [width, height] = extent.size_rad();
    let (low, high) = region.height_range_m();
    let texel = demand.texel_rad();
    let mut measured = Measured::default();
    let mut squares = [0.0_f64; 2];
    let mut counts = [0.0_f64; 2];
    for (i, j, k) in (0..=STEPS)
        .flat_map(|i| (0..=STEPS).map(move |j| (i, j)))
        .flat_map(|(i, j)| (0..3_u16).map(move |k| (i, j, k)))
    {
        let part = |n: u16, of: u16| f64::from(n) / f64::from(of);
        let sample = region.sample(Geodetic {
            longitude_rad: extent.west_rad + width * part(i, STEPS),
            latitude_rad: extent.south_rad + height * part(j, STEPS),
            height_m: low + (high - low) * part(k, 2),
        });
        for arithmetic in [Arithmetic::Fused, Arithmetic::Separate] {
            let got = program.emulate(constants, sample.offset_m, arithmetic);
            if !got.iter().all(|x| x.is_finite()) {
                measured.non_finite += 1;
                continue;
            }
            let mut square_m = 0.0;
            for axis in 0..2 {
                if axis == 0 && sample.on_axis {
                    continue;
                }
                let error = (f64::from(got[axis]) - sample.angles_rad[axis]).abs();
                let error = error.min((TAU - error).abs());
                let texels = error / texel[axis];
                measured.max_texels = measured.max_texels.max(texels);
                squares[axis] += texels * texels;
                counts[axis] += 1.0;
                square_m += (error * sample.metres_per_radian[axis]).powi(2);
            }
            measured.max_m = measured.max_m.max(square_m.sqrt());
        }
    }
    measured.rms_texels = (squares[0] / counts[0]).max(squares[1] / counts[1]).sqrt();
    measured
}

/// Whether what was measured is within what the chooser promises.
fn within(measured: &Measured) -> bool {
    measured.non_finite == 0
        // A grid with its corners and edges weighs these more than even samples do.
        && measured.rms_texels <= 1.25 * RMS_TOLERANCE
        && measured.max_texels <= MAX_TOLERANCE
}

#[test]
fn what_is_chosen_holds_for_every_extent_latitude_and_height() {
    let chooser = chooser();
    let mut names = BTreeSet::new();
    for extent_deg in EXTENTS_DEG {
        for latitude_deg in LATITUDES_DEG {
            for heights_m in HEIGHTS_M {
                let demand = textured(region(extent_deg, latitude_deg, heights_m));
                let choice = chooser.choose(&demand);
                let case = format!("{extent_deg} deg at {latitude_deg}, {heights_m:?} m");
                let chosen = choice.chosen.expect(&case);
                let constants = chosen.route.constants(&demand.region);
                let measured = measure(chosen.route, &constants, &demand);
                let name = chosen.route.name();
                assert!(within(&measured), "{case}: {name} {measured:?}");
                let residual = chosen.residual.expect("computed");
                assert!(
                    measured.max_m <= SAMPLING_SLACK * residual.max_m,
                    "{case}: {name} {measured:?}"
                );
                for (other, reason) in &choice.left_out {
                    let why = match reason {
                        Reason::RmsTexels { found, allowed }
                        | Reason::MaxTexels { found, allowed }
                        | Reason::RmsPixels { found, allowed } => found > allowed,
                        Reason::NonFinite { found } => *found > 0,
                        Reason::Dearer { taken } => other.cost >= *taken,
                        _ => false,
                    };
                    assert!(why, "{case}: {} {reason:?}", other.route.name());
                    let dearer = matches!(reason, Reason::Dearer { .. });
                    assert!(dearer || other.cost <= chosen.cost, "{case}");
                    assert_eq!(other.residual.is_none(), dearer, "{case}");
                }
                assert_eq!(
                    choice.left_out.len() + 1,
                    Chooser::default_candidates().len()
                );
                names.insert(name);
            }
        }
    }
    // A chooser that always took the same would be right as well.
    assert!(names.len() >= 12, "{names:?}");
    assert!(names.contains("planes") && names.contains("odd-7+parametric"));
}

#[test]
fn a_looser_bound_is_noticed() {
    // The mutant allows eight times as much: it chooses for a texture of an eighth of the size.
    let chooser = chooser();
    let mut noticed = 0;
    for extent_deg in [0.1, 1.0, 5.0, 40.0, 360.0] {
        let demand = textured(region(extent_deg, 45.0, (-1e4, 1e4)));
        let mutant = Demand {
            texture_size: [512, 512],
            ..demand
        };
        let chosen = chooser.choose(&mutant).chosen.expect("a route");
        let constants = chosen.route.constants(&demand.region);
        noticed += u32::from(!within(&measure(chosen.route, &constants, &demand)));
    }
    assert!(noticed >= 4, "{noticed}");
}

#[test]
fn a_wrong_coefficient_is_noticed() {
    let chooser = chooser();
    for (extent_deg, latitude_deg) in [(1e-3, 0.0), (1.0, 45.0), (5.0, 90.0), (360.0, 0.0)] {
        let demand = textured(region(extent_deg, latitude_deg, (0.0, 1e4)));
        let chosen = chooser.choose(&demand).chosen.expect("a route");
        let right = chosen.route.constants(&demand.region);
        let steps = chosen.route.program();
        let read = steps.steps().iter().filter_map(|step| match step {
            Step::Constant(index) => Some(*index),
            _ => None,
        });
        let mut noticed = 0;
        for lane in read {
            let mut wrong = right.clone();
            wrong[lane / 4][lane % 4] *= 1.02;
            noticed += u32::from(!within(&measure(chosen.route, &wrong, &demand)));
        }
        assert!(noticed >= 2, "{}: {noticed}", chosen.route.name());
        assert!(within(&measure(chosen.route, &right, &demand)));
    }
}

#[test]
fn pixels_bind_where_texels_do_not() {
    let chooser = chooser();
    let near = Demand {
        region: region(0.01, 45.0, (0.0, 100.0)),
        texture_size: [4, 4],
        pixel_m: 0.01,
    };
    let far = Demand {
        pixel_m: 100.0,
        ..near
    };
    let [near_choice, far_choice] = [near, far].map(|demand| chooser.choose(&demand));
    let [a, b] = [&near_choice, &far_choice].map(|c| c.chosen.as_ref().expect("a route"));
    assert!(a.cost > b.cost, "{} {}", a.route.name(), b.route.name());
    let constants = a.route.constants(&near.region);
    assert!(measure(a.route, &constants, &near).max_m < 0.01);
    let by_pixels = |(_, reason): &(_, Reason)| matches!(reason, Reason::RmsPixels { .. });
    assert!(near_choice.left_out.iter().any(by_pixels));
    // A quarter of a centimetre on the whole globe is beyond an f32 angle.
    let globe = Demand {
        region: region(360.0, 0.0, (0.0, 0.0)),
        ..near
    };
    let choice = chooser.choose(&globe);
    assert_eq!(choice.chosen, None);
    let best = choice.best_effort().expect("one of them");
    assert!(best.residual.expect("computed").max_m < 50.0, "{best:?}");
}

#[test]
fn what_the_suite_contradicts_is_not_taken() {
    let demand = textured(region(1.0, 45.0, (0.0, 1e4)));
    let candidates = Chooser::default_candidates();
    let first = chooser().choose(&demand).chosen.expect("a route");
    let with = |extent_deg, worst_over_bound, non_finite| {
        let finding = SuiteFinding {
            route: first.route,
            cell: SuiteCell {
                extent_deg,
                latitude_deg: 45.0,
            },
            worst_over_bound,
            non_finite,
        };
        Chooser::new(&candidates, vec![finding]).choose(&demand)
    };
    for (ratio, non_finite) in [(1.03, 0), (f64::NAN, 0), (f64::INFINITY, 0), (0.5, 1)] {
        let choice = with(1.0, ratio, non_finite);
        let second = choice.chosen.as_ref().expect("another route");
        assert_ne!(second.route, first.route);
        assert!(second.cost >= first.cost);
        let listed = choice.left_out.iter().find(|(c, _)| c.route == first.route);
        let (_, reason) = listed.expect("named");
        assert!(matches!(reason, Reason::Suite { .. }), "{reason:?}");
        assert!(
            reason.to_string().contains("extent 1°, latitude 45°"),
            "{reason}"
        );
    }
    let kept = with(1.0, 1.0, 0).chosen.expect("a route");
    assert_eq!(kept.route, first.route);
    // What was found of other regions is nothing to this one.
    let elsewhere = with(90.0, 1.5, 9).chosen.expect("a route");
    assert_eq!(elsewhere.route, first.route);
}

#[test]
fn texture_fetches_are_dearest_and_changes_of_sign_free() {
    let one = |change: fn(&mut Operations)| {
        let mut operations = Operations::default();
        change(&mut operations);
        operations.cost()
    };
    let fetch = one(|o| o.texture_fetches = 1);
    for other in [
        one(|o| o.add_mul_fma = 1),
        one(|o| o.divisions = 1),
        one(|o| o.compares_selects = 1),
        one(|o| o.sqrt = 1),
        one(|o| o.transcendental = 1),
    ] {
        assert!(other > 0.0 && other < fetch);
    }
    assert!(one(|o| o.sign_changes = 9).abs() < 1e-12);
    assert!((one(|o| o.add_mul_fma = 7) - 7.0).abs() < 1e-12);
}

#[test]
fn reasons_are_written_with_what_was_found_and_what_is_allowed() {
    for (reason, text) in [
        (
            Reason::RmsTexels {
                found: 1.23456,
                allowed: 0.25,
            },
            "RMS 1.235 texels, allowed 0.25",
        ),
        (
            Reason::MaxTexels {
                found: 0.6,
                allowed: 0.5,
            },
            "maximum 0.600 texels, allowed 0.5",
        ),
        (
            Reason::RmsPixels {
                found: f64::INFINITY,
                allowed: 0.25,
            },
            "RMS inf pixels, allowed 0.25",
        ),
        (Reason::NonFinite { found: 7 }, "not finite at 7 places"),
        (
            Reason::Suite {
                worst_over_bound: 1.5,
                non_finite: 2,
                cell: SuiteCell {
                    extent_deg: 0.01,
                    latitude_deg: 85.0,
                },
            },
            "the suite measured 1.500 of its bound, 2 results not finite (extent 0.01°, latitude 85°)",
        ),
        (Reason::Dearer { taken: 22.0 }, "costs no less than 22"),
    ] {
        assert_eq!(reason.to_string(), text);
    }
}
