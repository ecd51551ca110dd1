// SPDX-License-Identifier: MIT OR Apache-2.0
use super::*;
use crate::list::List;
use terrafill_fixtures::on_device::{on_device, verdict};
use terrafill_results::Status;
use terrafill_screen_grid::ScreenGridKind;
use terrafill_spiral::SpiralKind;
use terrafill_surface::{EllipsoidKind, SurfaceKind};

const KINDS: &[&dyn SurfaceKind] = &[&EllipsoidKind, &ScreenGridKind, &SpiralKind];

const SIDE: u32 = 64;

/// A picture of a line along its major axis.
#[allow(clippy::cast_possible_truncation, reason = "places in a small picture")]
fn lit(from: DVec2, to: DVec2) -> Vec<bool> {
    let mut lit = vec![false; (SIDE * SIDE) as usize];
    let steps = (to - from).abs().max_element().ceil();
    for step in 0..=steps as usize {
        let at = from.lerp(to, step as f64 / steps).floor();
        lit[(at.y * f64::from(SIDE) + at.x) as usize] = true;
    }
    lit
}

#[test]
fn a_line_less_and_a_pixel_more_are_noticed() {
    let lines = [
        [DVec2::new(5.3, 7.2), DVec2::new(50.1, 31.9)],
        [DVec2::new(50.1, 31.9), DVec2::new(20.5, 60.5)],
    ];
    let [first, second] = lines.map(|[from, to]| lit(from, to));
    let both: Vec<bool> = first.iter().zip(&second).map(|(a, b)| *a || *b).collect();
    let size = [SIDE; 2];
    let right = judge(size, &lines, &both);
    assert_eq!((right.beyond, right.missing), (0, 0), "{right:?}");
    assert!(right.control > right.lit / 4, "{right:?}");
    assert_eq!(judge(size, &lines, &first).missing, 1);
    assert!(judge(size, &lines[..1], &both).beyond > 20);
    let mut one_more = both;
    one_more[10] = true;
    assert_eq!(judge(size, &lines, &one_more).beyond, 1);
}

#[test]
fn every_surface_shows_its_edges_and_no_others() {
    let list = List::shipped().expect("a list");
    let opened = Rc::new(Opened::new(KINDS));
    let rows: Vec<SurfaceRow> = list
        .surface
        .iter()
        .filter(|row| opened.has(&row.kind))
        .cloned()
        .collect();
    let group = Wires::planned(&list.view, &rows, (200, 1), &opened);
    assert_eq!(group.cases.len(), 2 * rows.len());
    on_device(terrafill_gpu::shared_gpu, |context| {
        let mut session = (group.open)(&group, context).expect("opens");
        for (case, planned) in group.cases.iter().enumerate() {
            let verdict = verdict(&mut *session, case, &planned.id.key());
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
        }
    });
}
