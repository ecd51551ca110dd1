// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rays against projections, and pictures that are wrong on purpose.

use super::*;
use terrafill_scene::ImageSize;

const SIZE: [u32; 2] = [96; 2];

fn rays(grid: &Grid, cut: Cut) -> Rays<'_> {
    Rays {
        cut,
        ..Rays::new(grid, GridCamera::new(), ImageSize::new(SIZE[0], SIZE[1]))
    }
}

fn picture(rays: &Rays<'_>) -> Vec<u32> {
    let pixels = rays.picture(1).into_iter();
    pixels.map(|(_, number)| number).collect()
}

#[test]
fn a_ray_through_a_projected_centre_meets_its_triangle() {
    let grid = Grid::new(16);
    let rays = rays(&grid, Cut::Published);
    let mut met = 0;
    for row in 0..16 {
        for column in 0..16 {
            // Perspective keeps the middle inside.
            let corners = [(0, 0), (1, 0), (0, 1)];
            let corners = corners.map(|(x, y)| rays.project(column + x, row + y));
            let middle = (corners[0].0 + corners[1].0 + corners[2].0) / 3.0;
            let number = 2 * (row * 16 + column) + 1;
            let hit = rays.meet(middle).expect("on the ground");
            // Another one only where it hides this one.
            let away = corners
                .map(|corner| corner.1)
                .into_iter()
                .fold(0.0, f64::max);
            met += usize::from(hit.number == number);
            assert!(hit.number == number || hit.away_m < away, "{column} {row}");
        }
    }
    assert!(met > 150, "{met}");
}

#[test]
fn a_picture_is_right_by_its_own_rays_and_wrong_by_the_other_cut() {
    let grid = Grid::new(32);
    let right = rays(&grid, Cut::Published);
    let truth = right.picture(1);
    let shown = picture(&right);
    let judged = right.judge_triangles(&shown, &truth);
    assert_eq!((judged.mismatched, judged.in_band), (0, 0));
    assert!(judged.shown > 1_500, "{}", judged.shown);
    // Negative controls: cells cut along the other diagonal, a height changed, a column aside.
    let other = picture(&rays(&grid, Cut::Other));
    let judged = right.judge_triangles(&other, &truth);
    assert!(judged.mismatched > 500);
    let wrong = judged.wrong.iter().filter(|is_wrong| **is_wrong).count();
    assert_eq!(wrong, judged.mismatched);
    let mut changed = grid.clone();
    let vertex = changed.index(16, 16);
    changed.heights[vertex] += 60.0;
    let changed = picture(&rays(&changed, Cut::Published));
    assert!(right.judge_triangles(&changed, &truth).mismatched > 3);
    let mut aside = shown.clone();
    aside.rotate_right(1);
    assert!(right.judge_triangles(&aside, &truth).mismatched > 500);
}

#[test]
fn only_a_border_within_the_band_excuses_a_pixel() {
    let grid = Grid::new(32);
    let rays = rays(&grid, Cut::Published);
    let (a, b) = (rays.project(10, 10).0, rays.project(11, 10).0);
    let border = 0.5 * (a + b);
    let number = 2 * (10 * 32 + 10) + 1;
    // Beyond the side towards the row before, in pixels.
    let out = (b - a).perp().normalize();
    let inside = rays.project(10, 11).0 - border;
    let out = if out.dot(inside) > 0.0 { -out } else { out };
    let project = |place| rays.view.project(place, rays.size);
    let may_show = |at, number| rays.may_show(at, number, |at| rays.meet(at), project);
    assert!(may_show(border + out * 0.02, number));
    assert!(!may_show(border + out * 0.2, number));
    assert!(!may_show(border, 2 * 32 * 32 + 1));
}

#[test]
fn points_are_where_they_are_projected() {
    let grid = Grid::new(16);
    let rays = rays(&grid, Cut::Published);
    let mut numbers = vec![0; (SIZE[0] * SIZE[1]) as usize];
    let mut nearest = vec![f64::INFINITY; numbers.len()];
    for row in 0..16 {
        for column in 0..16 {
            let (at, away) = rays.project(column, row);
            let pixel = pixel_of(at, SIZE).expect("on screen");
            if away < nearest[pixel] {
                (nearest[pixel], numbers[pixel]) = (away, row * 16 + column + 1);
            }
        }
    }
    let judged = rays.judge_points(&numbers);
    assert_eq!((judged.mismatched, judged.in_band), (0, 0));
    assert!(judged.shown > 200, "{}", judged.shown);
    // Negative controls: a pixel aside, a point left out.
    numbers.rotate_right(1);
    assert!(rays.judge_points(&numbers).mismatched > 200);
    numbers.rotate_left(1);
    let some = numbers
        .iter()
        .position(|number| *number > 0)
        .expect("a point");
    let mut less = numbers.clone();
    less[some] = 0;
    assert!(rays.judge_points(&less).mismatched <= 1);
    let all = less.iter_mut();
    all.for_each(|number| *number = 0);
    assert!(rays.judge_points(&less).mismatched > 150);
}
