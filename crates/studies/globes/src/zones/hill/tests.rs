// SPDX-License-Identifier: MIT OR Apache-2.0
use super::*;
use terrafill_fixtures::on_device::{figure, on_device, verdict};
use terrafill_globe_views::around;
use terrafill_results::Status;

#[test]
fn a_hill_hides_zones_and_one_edge_on_appears_at_once() {
    let group = HillPictures::planned((256, 1));
    on_device(terrafill_gpu::shared_gpu, |context| {
        let mut session = (group.open)(&group, context).expect("opens");
        let mut all = Vec::new();
        for (case, planned) in group.cases.iter().enumerate() {
            let verdict = verdict(&mut *session, case, &planned.id.key());
            eprintln!("{}: {verdict:?}", planned.id.key());
            all.push(verdict);
        }
        for verdict in &all {
            assert_eq!(verdict.status, Status::Ok, "{}", verdict.reason);
            assert_eq!(figure(verdict, "globe_count_cycles"), 0.0);
        }
        let [seen, _, plain, before, from_fine, after] = &all[..] else {
            panic!("six pictures");
        };
        assert!(figure(seen, "globe_zone_hidden") >= 2.0);
        assert_eq!(figure(seen, "globe_zone_hidden_level"), 0.0);
        // Negative control: without the hill nothing is hidden.
        assert_eq!(figure(plain, "globe_zone_hidden"), 0.0);
        assert_eq!(figure(before, "globe_zone_level"), 0.0);
        for fine in [from_fine, after] {
            assert!(figure(fine, "globe_zone_level") > 0.0);
            assert!(figure(fine, "globe_zone_px") > 2.0 * figure(before, "globe_zone_px"));
        }
    });
}

#[test]
fn a_pixel_of_another_triangle_is_noticed() {
    let eye = eye(LARGE_EYE_M, LARGE_PITCH_DEG, 64);
    let drawn = triangles(&Shown::Seen.field().drawn(&eye, &[1; ZONES * ZONES]));
    let rays = numbers(&eye, &drawn);
    let rounding = |pixel, met, shown| is_rounding(&eye, &drawn, pixel, [met, shown]);
    let right = judge(64, &rays, &rays, rounding);
    assert_eq!((right.other, right.reason()), (0, String::new()));
    // Negative controls: one pixel of a triangle elsewhere, one of none, and a picture of nothing.
    // Pixels within a triangle, where rounding decides nothing.
    let is_within = |pixel: &usize| {
        let mut beside = around(*pixel, 64, rays.len());
        rays[*pixel] != 0 && beside.all(|at| rays[at] == rays[*pixel])
    };
    let within: Vec<usize> = (0..rays.len()).filter(is_within).collect();
    let [first, .., last] = within[..] else {
        panic!("two pixels or more");
    };
    let mut device = rays.clone();
    device[first] = rays[last];
    assert_eq!(judge(64, &rays, &device, rounding).other, 1);
    device[last] = 0;
    assert_eq!(judge(64, &rays, &device, rounding).other, 2);
    let nothing = vec![0; rays.len()];
    assert!(!judge(64, &rays, &nothing, rounding).reason().is_empty());
}
