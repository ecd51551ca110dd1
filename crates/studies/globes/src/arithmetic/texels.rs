// SPDX-License-Identifier: MIT OR Apache-2.0
//! How evenly pictures of the globe spread their texels, and where the printed tangent has a length.

use super::table;
use glam::DVec3;
use std::f64::consts::PI;
use terrafill_plot::number::significant;

/// Rows of a picture by angles, twice as wide, and texels along a face of a cube map that has as many in all.
const ROWS: u32 = 1024;
const FACE: u32 = 591;

/// Solid angle of a part of a cube's face from its middle to a corner, −1 … 1 both ways.
fn from_the_middle([s, t]: [f64; 2]) -> f64 {
    (s * t).atan2((s * s + t * t + 1.0).sqrt())
}

/// Solid angle of a texel of a face.
fn cube_texel([column, row]: [u32; 2]) -> f64 {
    let [s, t] =
        [column, row].map(|at| [at, at + 1].map(|at| 2.0 * f64::from(at) / f64::from(FACE) - 1.0));
    let corner = |i: usize, j: usize| from_the_middle([s[i], t[j]]);
    corner(1, 1) - corner(0, 1) - corner(1, 0) + corner(0, 0)
}

/// Solid angle of a texel of a row, from the pole.
fn angles_texel(row: u32) -> f64 {
    let cosine = |row: u32| (PI * f64::from(row) / f64::from(ROWS)).cos();
    PI / f64::from(ROWS) * (cosine(row) - cosine(row + 1))
}

/// The smallest over the largest.
fn evenness(texels: impl Iterator<Item = f64>) -> f64 {
    let [least, most] = texels.fold([f64::INFINITY, 0.0], |[least, most], texel| {
        [f64::min(least, texel), f64::max(most, texel)]
    });
    least / most
}

fn of_angles() -> f64 {
    evenness((0..ROWS).map(angles_texel))
}

fn of_cube() -> f64 {
    evenness((0..FACE).flat_map(|row| (0..FACE).map(move |column| cube_texel([column, row]))))
}

/// As printed, of a normal at a latitude.
fn tangent(normal: DVec3) -> DVec3 {
    DVec3::new(-normal.y, normal.x, 0.0)
}

fn normal(latitude_deg: f64) -> DVec3 {
    let (sine, cosine) = latitude_deg.to_radians().sin_cos();
    DVec3::new(cosine, 0.0, sine)
}

const TANGENTS: [(&str, f64); 2] = [("equator", 0.0), ("89.9°", 89.9)];

pub(super) fn page() -> String {
    let [angles, cube] = [of_angles(), of_cube()];
    let texels = [
        ("picture by angles", angles),
        ("cube map", cube),
        ("cube map ÷ picture by angles", cube / angles),
    ];
    let row = |(name, figure): (&str, f64)| vec![name.to_owned(), significant(figure)];
    let texels = table(&["", "smallest ÷ largest"], texels.map(row));
    let lengths =
        TANGENTS.map(|(name, latitude_deg)| row((name, tangent(normal(latitude_deg)).length())));
    let pole = row(("pole", tangent(DVec3::Z).length()));
    let lengths = table(&["", "length"], lengths.into_iter().chain([pole]));
    format!(
        "## Texels and tangents

Texels of pictures of the globe, by their solid angles: 2,048 × 1,024 by angles, and six faces of 591 × 591, which are as
many.
{texels}
The tangent (−y, x, 0) of a normal (x, y, z), before it is normalised. What has no length has no direction either.
{lengths}"
    )
}

#[test]
fn texels_cover_the_sphere_and_a_cube_spreads_them_more_evenly() {
    let by_angles: f64 = (0..ROWS)
        .map(|row| 2.0 * f64::from(ROWS) * angles_texel(row))
        .sum();
    let face: f64 = (0..FACE)
        .flat_map(|row| (0..FACE).map(move |column| cube_texel([column, row])))
        .sum();
    assert!((by_angles - 4.0 * PI).abs() < 1e-9 && (6.0 * face - 4.0 * PI).abs() < 1e-9);
    // A corner has 3^-1.5 of the middle, but for half a texel; a row at the pole half the sine of its height.
    assert!(
        (of_cube() / 3.0_f64.powf(-1.5) - 1.0).abs() < 0.01,
        "{}",
        of_cube()
    );
    assert!((of_angles() / (0.5 * PI / f64::from(ROWS)) - 1.0).abs() < 0.01);
    assert!(6 * FACE * FACE <= 2 * ROWS * ROWS && 6 * (FACE + 1).pow(2) > 2 * ROWS * ROWS);
    // Negative control: rows about the equator are as even as any.
    assert!(evenness((ROWS / 2 - 8..ROWS / 2 + 8).map(angles_texel)) > 0.99);
    assert_eq!(tangent(DVec3::Z), DVec3::ZERO);
    assert!((tangent(normal(0.0)).length() - 1.0).abs() < 1e-15);
}
