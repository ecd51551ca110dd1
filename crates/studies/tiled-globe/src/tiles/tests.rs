// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles on a device, and the judge without one.

use super::*;
use crate::options::{Drawing, Seam};
use crate::truth::{Texel, Tile, WrappedPoint};
use crate::views::tiled_view;
use std::f64::consts::TAU;
use terrafill_fixtures::on_device::{self, figure, on_device};
use terrafill_maps::max_latitude_rad;
use terrafill_results::Status;
use terrafill_screen_grid::ScreenGridKind;
use terrafill_study::Group as _;
use terrafill_surface::SurfaceKind;

const KINDS: &[&dyn SurfaceKind] = &[&ScreenGridKind];

/// Verdicts of a view's ways; `None` without a device.
fn verdicts(name: &str, side_px: u32, options: Vec<Options>) -> Option<Vec<Verdict>> {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let opened = Rc::new(Opened::new(KINDS));
        let tiled = Tiled::planned(&tiled_view(name), (side_px, 1), options, &opened);
        let mut session = tiled.open(context).expect("opens");
        let options = tiled.work.options.iter().enumerate();
        let verdicts = options.map(|(case, options)| {
            let verdict = on_device::verdict(&mut *session, case, options);
            if verdict.status == Status::Ok {
                assert!(session.time(case).is_ok());
            }
            verdict
        });
        verdicts.collect()
    })
}

#[test]
fn every_pixel_of_a_globe_shows_its_texel_and_the_seam_is_kept() {
    let base = Options::BASE;
    let drawings = [
        Drawing::Array,
        Drawing::DrawEach,
        Drawing::Bindless,
        Drawing::Atlas,
    ];
    let mut options: Vec<Options> = drawings.map(|drawing| Options { drawing, ..base }).into();
    options.extend([Seam::Rotated, Seam::Local].map(|seam| Options { seam, ..base }));
    options.extend([
        Options {
            by_fragment: true,
            ..base
        },
        Options {
            one_level: Some(0),
            ..base
        },
        Options {
            seam: Seam::None,
            ..base
        },
    ]);
    let Some(all) = verdicts("globe-antimeridian", 200, options) else {
        return;
    };
    for (at, verdict) in all[..8].iter().enumerate() {
        // A device without freely indexed arrays of textures says so.
        if at == 2 && verdict.status == Status::Skipped {
            assert!(verdict.reason.contains("arrays of textures"));
            continue;
        }
        assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
        assert!(figure(verdict, "globe_tile_seam_px") > 100.0);
        assert_eq!(figure(verdict, "globe_tile_missing_px"), 0.0);
        // f32 of a map of some thousand texels.
        assert!(figure(verdict, "globe_tile_texels_max") < 0.05);
    }
    // The body's own texels are farther off: the grid is coarse.
    assert!(figure(&all[0], "globe_tile_true_texels_max") > 1.0);
    // Finer texels at the limb, where the grid is farthest off.
    let worst = |at: usize| figure(&all[at], "globe_tile_true_texels_max");
    assert!(worst(7) > 2.0 * worst(0));
    assert_eq!(
        figure(&all[1], "globe_tile_draws"),
        figure(&all[1], "globe_tile_count")
    );
    // Negative control: with nothing done about the seam, pixels beside it are wrong.
    let never = &all[8];
    assert_eq!(never.status, Status::Wrong, "{}", never.reason);
    assert_eq!(
        figure(never, "globe_tile_missed"),
        figure(never, "globe_tile_crossing")
    );
}

#[test]
fn counted_from_the_eye_no_texel_is_lost_to_single_precision() {
    let base = Options::BASE;
    let options = [Seam::Local, base.seam].map(|seam| Options {
        seam,
        n: 40,
        ..base
    });
    let Some(all) = verdicts("ground-1.7m", 100, options.into()) else {
        return;
    };
    let [local, absolute] = [0, 1].map(|at| figure(&all[at], "globe_tile_texels_p99"));
    assert!(local < 0.5, "{local}");
    // Negative control: by an absolute U the ground is a metre off, some steps of f32.
    assert!(absolute > 10.0, "{absolute}");
    let step = figure(&all[1], "globe_tile_step_texels");
    assert!(
        (1.0..20.0).contains(&(absolute / step)),
        "{absolute} {step}"
    );
    assert!(
        all[1].reason.contains("a step of f32 is 64 texels there"),
        "{}",
        all[1].reason
    );
    assert!(
        !all[0]
            .figures
            .iter()
            .any(|(name, _)| *name == "globe_tile_step_texels")
    );
}

/// Whether each case of a view may be wrong, in the order of `seams`.
fn may_be_wrong(name: &str, seams: &[Seam]) -> Vec<bool> {
    let options = seams.iter().map(|&seam| Options {
        seam,
        ..Options::BASE
    });
    let opened = Rc::new(Opened::new(KINDS));
    let sizes = (1024, 1);
    let tiled = Tiled::planned(&tiled_view(name), sizes, options.collect(), &opened);
    tiled.cases.iter().map(|case| case.may_be_wrong).collect()
}

#[test]
fn only_where_single_precision_loses_texels_may_a_split_view_be_wrong() {
    let seams = [Seam::Split(0.5), Seam::Rotated, Seam::Local, Seam::None];
    for near in ["nadir-10km", "ground-1.7m"] {
        assert_eq!(may_be_wrong(near, &seams), [true, true, false, true]);
    }
    // Negative control: farther away only what leaves the seam as it is may be wrong.
    for far in ["globe-antimeridian", "oblique-100km", "tilted-100km"] {
        assert_eq!(may_be_wrong(far, &seams), [false, false, false, true]);
    }
}

#[test]
fn a_picture_one_texel_off_is_refuted() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let views = [
            ("globe-antimeridian", Seam::Split(0.5)),
            ("nadir-10km", Seam::Local),
            ("ground-1.7m", Seam::Local),
        ];
        for (name, seam) in views {
            let opened = Rc::new(Opened::new(KINDS));
            // Of an odd number of cells one is on both sides of ±180°.
            let options = Options {
                seam,
                n: 5,
                ..Options::BASE
            };
            let tiled = Tiled::planned(&tiled_view(name), (100, 1), vec![options], &opened);
            let mut part = TiledPart::new(&tiled.work, context);
            let mut judged = |by: u32| {
                let (_, mut shown) = part.show(0).map_err(Failure::reason).expect("drawn");
                for address in &mut shown.addresses {
                    *address += if *address & 255 < 255 { by } else { 0 };
                }
                let verdict = part.judge(0, shown).map_err(Failure::reason);
                verdict.expect("a verdict").status
            };
            assert_eq!(judged(0), Status::Ok, "{name}");
            assert_eq!(judged(1), Status::Wrong, "{name}");
        }
    });
}

#[test]
fn a_texel_beside_the_right_one_is_found_wrong() {
    // V of the row that a fragment makes of it.
    let latitude_rad = (TAU * (0.5 - 20.5 / 256.0)).sinh().atan();
    let place = WrappedPoint {
        u: 1.0 + 0.25 / 256.0,
        by_vertex: 10.5 / 256.0,
        v: Some(0.5 + 0.5 * latitude_rad / max_latitude_rad()),
        cap: None,
    };
    let texel = |x, y| Texel {
        tile: Tile::Map {
            level: 0,
            row: 0,
            column: 0,
        },
        x,
        y,
    };
    // Round the map, and by the vertex or by the fragment.
    assert_eq!(off_texels(texel(0, 10), &place, false), 0.0);
    assert_eq!(off_texels(texel(0, 20), &place, true), 0.0);
    assert!((off_texels(texel(255, 10), &place, false) - 0.25).abs() < 1e-9);
    assert!((off_texels(texel(2, 10), &place, false) - 1.75).abs() < 1e-9);
    assert!((off_texels(texel(0, 20), &place, false) - 9.5).abs() < 1e-9);
    // A pixel without a texel counts as wrong beside the seam.
    let truth = Truth {
        drawn: place,
        body: None,
        levels: [0; 2],
        is_at_seam: true,
        holds_pole: false,
        snapped: 0.0,
        is_at_outline: false,
    };
    let all = BTreeSet::from([texel(0, 10).tile]);
    let found = |shown| judge(&[Some(truth)], &[shown], &Options::BASE, &all);
    assert_eq!(found(Shown::Missing).wrong_px, 1);
    assert_eq!(found(Shown::Texel(texel(0, 10))).wrong_px, 0);
    // Seen along its plane, a triangle shows what its corners' rounding moves there.
    let steep = Truth {
        snapped: 2.0 / 256.0,
        ..truth
    };
    let beside = |truth, x| {
        let shown = [Shown::Texel(texel(x, 10))];
        judge(&[Some(truth)], &shown, &Options::BASE, &all).wrong_px
    };
    assert_eq!(
        (beside(truth, 2), beside(steep, 2), beside(steep, 4)),
        (1, 0, 1)
    );
    let outer = Truth {
        is_at_outline: true,
        ..truth
    };
    assert_eq!(beside(outer, 2), 0);
    // A pixel whose tile is not at hand cannot show it.
    let without = judge(
        &[Some(truth)],
        &[Shown::Missing],
        &Options::BASE,
        &BTreeSet::new(),
    );
    assert_eq!((without.wrong_px, without.missing_px), (0, 1));
    assert_eq!(found(Shown::Missing).seam_wrong_px, 1);
    assert_eq!(found(Shown::Texel(texel(0, 10))).seam_wrong_px, 0);
    assert_eq!(found(Shown::Texel(texel(2, 10))).seam_wrong_px, 1);
}

#[test]
fn coarse_grids_over_the_whole_globe_show_no_wrong_texel() {
    on_device(terrafill_gpu::shared_gpu, |context| {
        let opened = Rc::new(Opened::new(KINDS));
        let options = [2, 5].map(|n| Options { n, ..Options::BASE });
        let part = ("cells", TilesOf::Body);
        let view = tiled_view("globe");
        let tiled = Tiled::of_part(part, &view, (640, 1), options.into(), &opened);
        let mut session = tiled.open(context).expect("opens");
        for (case, options) in tiled.work.options.iter().enumerate() {
            let verdict = on_device::verdict(&mut *session, case, options);
            assert!(figure(&verdict, "globe_tile_px") > 10_000.0);
            assert_eq!(figure(&verdict, "globe_tile_wrong_px"), 0.0);
        }
    });
}
