// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far a frame's texture coordinates are from the reference's, in texels.
//!
//! A pixel's error is `|Δu|` times the picture's columns and `|Δv|` times its rows, modulo the
//! picture where it repeats. Of a pattern it is in texels of the level that the pixel shows. Only
//! pixels count that both frames own by the same region, and none within a pixel of a silhouette:
//! there a ray that rounding moved by a thousandth of a pixel may meet another place altogether.

use crate::boundary::Grid;
use crate::compare::{CompareError, check};
use crate::tolerance::{BAND_RADIUS_PX, DEPTH_JUMP};
use terrafill_contract::{AddressMode, Frame, NO_REGION, TextureCoordinates, TexturePixel};

/// Errors of a textured frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TextureErrors {
    /// Pixels compared: same region in both, no silhouette near, coordinates that are numbers.
    pub compared_px: u64,
    /// Pixels of the same region in both that were left out for a silhouette.
    pub silhouette_px: u64,
    /// Pixels of the same region in both for which the frame has no coordinates.
    pub missing_px: u64,
    /// Pixels of the frame with a coordinate or level that is NaN or infinite, silhouettes included.
    pub non_finite: u64,
    /// Root of the mean square over the pixels compared, of `u` and of `v`, texels.
    pub rms_texels: [f64; 2],
    /// Largest error, of `u` and of `v`, texels.
    pub max_texels: [f64; 2],
    /// Largest difference of the level of detail.
    pub max_level: f64,
}

/// Per pixel of the reference: whether it lies within [`BAND_RADIUS_PX`] of a silhouette, which is
/// where another region or none begins, or where the distance from the eye jumps.
///
/// # Errors
/// [`CompareError::NoTexture`] without coordinates, which the distances come with.
pub fn silhouette_band(reference: &Frame) -> Result<Vec<bool>, CompareError> {
    let grid = Grid::of(reference);
    let mut set = grid.boundary(&reference.ids, None);
    let texture = coordinates("reference", reference)?;
    for index in 0..set.len() {
        let (column, row) = (index % grid.width, index / grid.width);
        // To the right and down; `room` before and `room` after that step.
        for (step, before, after) in [
            (1, column, grid.width - 1 - column),
            (grid.width, row, grid.height - 1 - row),
        ] {
            if after > 0 && jumps(&texture.pixels, index, step, before > 0, after > 1) {
                set[index] = true;
                set[index + step] = true;
            }
        }
    }
    Ok(grid.dilated(&set, BAND_RADIUS_PX as usize))
}

/// Whether the distance jumps from `index` to the pixel a step on.
///
/// The reciprocal of the depth is linear across a plane's image, so each of the two can be foretold
/// from the pixels on its own side. Where both come out wrong there is an edge between them. On a
/// rim with one side only, that side decides.
fn jumps(
    pixels: &[Option<TexturePixel>],
    index: usize,
    step: usize,
    has_before: bool,
    has_after: bool,
) -> bool {
    let near = |at: usize| pixels[at].map(|pixel| pixel.distance_m.recip());
    let (Some(a), Some(b)) = (near(index), near(index + step)) else {
        return false;
    };
    let is_wrong = |outer: Option<f64>, inner: f64, beyond: f64| {
        outer.map(|outer| (2.0 * inner - outer - beyond).abs() > DEPTH_JUMP * inner.max(beyond))
    };
    let forth = has_before.then(|| near(index - step)).flatten();
    let back = has_after.then(|| near(index + 2 * step)).flatten();
    match (is_wrong(forth, a, b), is_wrong(back, b, a)) {
        (None, None) => false,
        (forth, back) => forth.unwrap_or(true) && back.unwrap_or(true),
    }
}

/// How the texture coordinates of `frame` differ from those of `reference`.
///
/// - cost: O(pixels)
///
/// # Errors
/// [`CompareError`] when the two cannot be laid over one another, one has no coordinates, or the
/// reference is broken.
pub fn compare_texture(reference: &Frame, frame: &Frame) -> Result<TextureErrors, CompareError> {
    check(reference, frame)?;
    let expected = coordinates("reference", reference)?;
    let found = coordinates("frame", frame)?;
    if expected.texels != found.texels {
        return Err(CompareError::PictureMismatch {
            found: found.texels.into(),
            required: expected.texels.into(),
        });
    }
    let broken = non_finite(expected);
    if broken > 0 {
        return Err(CompareError::ReferenceNotFinite { found: broken });
    }
    let band = silhouette_band(reference)?;
    let mut errors = TextureErrors {
        non_finite: non_finite(found),
        ..TextureErrors::default()
    };
    let mut squares = [0.0; 2];
    for (index, &near_silhouette) in band.iter().enumerate() {
        let id = reference.ids[index];
        if id == NO_REGION || frame.ids[index] != id {
            continue;
        }
        let Some(pixel) = found.pixels[index] else {
            errors.missing_px += 1;
            continue;
        };
        if near_silhouette {
            errors.silhouette_px += 1;
            continue;
        }
        let (Some(expected_pixel), true) = (expected.pixels[index], pixel.is_finite()) else {
            continue;
        };
        let address = expected.address.get(id as usize - 1).copied();
        let difference = texel_error(&expected_pixel, &pixel, expected.texels, address);
        for i in 0..2 {
            squares[i] += difference[i] * difference[i];
            errors.max_texels[i] = errors.max_texels[i].max(difference[i]);
        }
        errors.max_level = errors
            .max_level
            .max((pixel.level - expected_pixel.level).abs());
        errors.compared_px += 1;
    }
    let count = errors.compared_px.max(1) as f64;
    errors.rms_texels = squares.map(|sum| (sum / count).sqrt());
    Ok(errors)
}

/// `|Δu|` and `|Δv|` in texels of the level that `expected_pixel` shows.
fn texel_error(
    expected_pixel: &TexturePixel,
    pixel: &TexturePixel,
    texels: [u32; 2],
    address: Option<[AddressMode; 2]>,
) -> [f64; 2] {
    // Coordinates of a pattern count repeats of its level 0.
    let scale = (-expected_pixel.pattern_level.floor()).exp2();
    std::array::from_fn(|i| {
        let mut difference = (pixel.uv[i] - expected_pixel.uv[i]) * scale;
        if address.is_some_and(|address| address[i] == AddressMode::Repeat) {
            difference -= difference.round();
        }
        difference.abs() * f64::from(texels[i])
    })
}

fn non_finite(texture: &TextureCoordinates) -> u64 {
    let pixels = texture.pixels.iter().flatten();
    pixels.filter(|pixel| !pixel.is_finite()).count() as u64
}

fn coordinates<'a>(
    which: &'static str,
    frame: &'a Frame,
) -> Result<&'a TextureCoordinates, CompareError> {
    let texture = frame
        .texture
        .as_ref()
        .ok_or(CompareError::NoTexture { which })?;
    if texture.pixels.len() == frame.size.pixel_count() {
        return Ok(texture);
    }
    Err(CompareError::MalformedTexture {
        which,
        found: texture.pixels.len(),
        required: frame.size.pixel_count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::tests::picture;
    use crate::verdict::{Verdict, texture_verdict};

    const TEXELS: [u32; 2] = [512, 256];
    const WIDTH: usize = 24;
    const HEIGHT: usize = 20;
    /// First eccentricity squared of WGS 84.
    const E2: f64 = 0.006_694_379_990_14;

    /// Longitude and latitude in degrees that a pixel shows: 5 … 17 and 40 … 50.
    fn place(column: usize, row: usize) -> [f64; 2] {
        [5.0 + 0.5 * column as f64, 50.0 - 0.5 * row as f64]
    }

    /// Coordinates over an extent from 5° to 17° and from 40° to 50°.
    fn over_extent([longitude, latitude]: [f64; 2]) -> [f64; 2] {
        [(longitude - 5.0) / 12.0, (50.0 - latitude) / 10.0]
    }

    fn pixel(uv: [f64; 2]) -> TexturePixel {
        TexturePixel {
            uv,
            pattern_level: 0.0,
            footprint_texels: 2.0,
            level: 1.0,
            distance_m: 1000.0,
        }
    }

    /// One region over the whole image, with coordinates by column and row.
    fn frame_of(uv: impl Fn(usize, usize) -> [f64; 2]) -> Frame {
        let row = "1".repeat(WIDTH);
        let pixels = (0..WIDTH * HEIGHT)
            .map(|index| Some(pixel(uv(index % WIDTH, index / WIDTH))))
            .collect();
        picture(&[row.as_str(); HEIGHT]).textured(TextureCoordinates {
            texels: TEXELS,
            address: vec![[AddressMode::ClampToEdge; 2]],
            pixels,
        })
    }

    fn good() -> Frame {
        changed(|uv| uv)
    }

    /// The right coordinates, each as it is changed.
    fn changed(change: impl Fn([f64; 2]) -> [f64; 2]) -> Frame {
        frame_of(|column, row| change(over_extent(place(column, row))))
    }

    fn errors_of(reference: &Frame, frame: &Frame) -> TextureErrors {
        compare_texture(reference, frame).expect("comparable")
    }

    fn pixels(frame: &mut Frame) -> &mut Vec<Option<TexturePixel>> {
        &mut frame.texture.as_mut().expect("textured").pixels
    }

    fn is_right(errors: &TextureErrors) -> bool {
        texture_verdict(errors).is_pass()
    }

    #[test]
    fn a_frame_equal_to_the_reference_has_no_error() {
        let errors = errors_of(&good(), &good());
        assert_eq!(errors.compared_px, (WIDTH * HEIGHT) as u64);
        assert_eq!((errors.rms_texels, errors.max_texels), ([0.0; 2], [0.0; 2]));
        assert!(is_right(&errors));
    }

    #[test]
    fn every_mutant_is_noticed() {
        let geocentric = |latitude: f64| {
            let tangent = (1.0 - E2) * latitude.to_radians().tan();
            tangent.atan().to_degrees()
        };
        let mut one_is_nan = good();
        if let Some(pixel) = &mut pixels(&mut one_is_nan)[7 * WIDTH + 11] {
            pixel.uv[1] = f64::NAN;
        }
        let mutants: [(&str, Frame); 5] = [
            (
                "longitude and latitude swapped",
                frame_of(|column, row| {
                    let [longitude, latitude] = place(column, row);
                    over_extent([latitude, longitude])
                }),
            ),
            ("v upwards", changed(|[u, v]| [u, 1.0 - v])),
            (
                "geocentric latitude",
                frame_of(|column, row| {
                    let [longitude, latitude] = place(column, row);
                    over_extent([longitude, geocentric(latitude)])
                }),
            ),
            ("shifted by a texel", changed(|[u, v]| [u + 1.0 / 512.0, v])),
            ("one pixel is no number", one_is_nan),
        ];
        for (name, mutant) in mutants {
            let errors = errors_of(&good(), &mutant);
            assert!(!is_right(&errors), "{name}: {errors:?}");
        }
    }

    #[test]
    fn a_shift_is_measured_in_texels_of_its_own_axis() {
        let shifted = |du: f64, dv: f64| errors_of(&good(), &changed(|[u, v]| [u + du, v + dv]));
        let close = |a: [f64; 2], b: [f64; 2]| (0..2).all(|i| (a[i] - b[i]).abs() < 1e-9);
        let errors = shifted(1.0 / 512.0, 0.0);
        assert!(close(errors.rms_texels, [1.0, 0.0]) && close(errors.max_texels, [1.0, 0.0]));
        let errors = shifted(0.0, -0.25 / 256.0);
        assert!(close(errors.rms_texels, [0.0, 0.25]), "{errors:?}");
        // An eighth of a texel is well inside what may be, three tenths are not.
        assert!(is_right(&shifted(0.125 / 512.0, 0.125 / 256.0)));
        assert!(!is_right(&shifted(0.3 / 512.0, 0.0)));
        // One pixel off by 0.6 texels: the mean hides it, the maximum does not.
        let mut frame = good();
        if let Some(pixel) = &mut pixels(&mut frame)[100] {
            pixel.uv[0] += 0.6 / 512.0;
        }
        let errors = errors_of(&good(), &frame);
        assert!(
            errors.rms_texels[0] < 0.05 && !is_right(&errors),
            "{errors:?}"
        );
    }

    #[test]
    fn a_whole_picture_counts_unless_it_repeats() {
        let turn = changed(|[u, v]| [u + 3.0, v]);
        assert!(!is_right(&errors_of(&good(), &turn)));
        let mut repeating = good();
        if let Some(texture) = &mut repeating.texture {
            texture.address = vec![[AddressMode::Repeat, AddressMode::ClampToEdge]];
        }
        assert!(is_right(&errors_of(&repeating, &turn)));
    }

    #[test]
    fn a_patterns_error_is_in_texels_of_its_level() {
        let at_level = |frame: &mut Frame| {
            for pixel in pixels(frame).iter_mut().flatten() {
                pixel.pattern_level = 3.7;
            }
        };
        let mut reference = good();
        at_level(&mut reference);
        let mut frame = changed(|[u, v]| [u + 8.0 / 512.0, v]);
        at_level(&mut frame);
        let errors = errors_of(&reference, &frame);
        assert!((errors.max_texels[0] - 1.0).abs() < 1e-9, "{errors:?}");
    }

    #[test]
    fn silhouettes_are_left_out_and_nothing_else() {
        // The right half is ten times as far, and wrong all over in two columns at the jump.
        let far = |frame: &mut Frame| {
            for (index, pixel) in pixels(frame).iter_mut().enumerate() {
                if let (Some(pixel), true) = (pixel, index % WIDTH >= 12) {
                    pixel.distance_m = 10_000.0;
                }
            }
        };
        let mut reference = good();
        far(&mut reference);
        let wrong_in = |wrong: &[usize]| {
            frame_of(|column, row| {
                let [u, v] = over_extent(place(column, row));
                [if wrong.contains(&column) { u + 0.5 } else { u }, v]
            })
        };
        let wrong_at = |wrong: [usize; 2]| {
            let mut frame = wrong_in(&wrong);
            far(&mut frame);
            errors_of(&reference, &frame)
        };
        let errors = wrong_at([11, 12]);
        assert!(is_right(&errors), "{errors:?}");
        assert_eq!(errors.silhouette_px, 4 * HEIGHT as u64);
        // Negative control: two pixels further on it is an error, and without the jump it is one everywhere.
        assert!(!is_right(&wrong_at([14, 14])));
        assert!(!is_right(&wrong_at([9, 9])));
        assert!(!is_right(&errors_of(&good(), &wrong_in(&[11]))));
    }

    #[test]
    fn a_slope_is_no_silhouette() {
        // A plane towards the horizon: the reciprocal of the distance falls by rows.
        let mut slope = good();
        for (index, pixel) in pixels(&mut slope).iter_mut().enumerate() {
            if let Some(pixel) = pixel {
                pixel.distance_m = 1e5 / (1.0 + (index / WIDTH) as f64);
            }
        }
        let band = silhouette_band(&slope).expect("textured");
        assert!(!band.contains(&true));
    }

    #[test]
    fn other_regions_and_edges_of_regions_are_left_out() {
        let mut frame = good();
        let mut reference = good();
        for (index, id) in reference.ids.iter_mut().enumerate() {
            *id = u32::from(index % WIDTH < 12);
        }
        frame.ids[3] = 2;
        for index in (0..WIDTH * HEIGHT).filter(|index| index % WIDTH >= 10) {
            if let Some(pixel) = &mut pixels(&mut frame)[index] {
                pixel.uv = [7.0, 7.0];
            }
        }
        let errors = errors_of(&reference, &frame);
        assert!(is_right(&errors), "{errors:?}");
        assert_eq!(errors.compared_px, 10 * HEIGHT as u64 - 1);
        assert_eq!(errors.silhouette_px, 2 * HEIGHT as u64);
    }

    #[test]
    fn what_is_missing_or_compares_nothing_fails() {
        let mut frame = good();
        pixels(&mut frame)[50] = None;
        let errors = errors_of(&good(), &frame);
        assert_eq!(errors.missing_px, 1);
        assert!(!is_right(&errors));
        let mut nothing = good();
        nothing.ids.fill(NO_REGION);
        let errors = errors_of(&nothing, &nothing);
        assert_eq!(errors.compared_px, 0);
        assert!(matches!(texture_verdict(&errors), Verdict::Fail(why) if why.len() == 1));
    }

    #[test]
    fn frames_that_cannot_be_compared_are_refused() {
        let plain = Frame {
            texture: None,
            ..good()
        };
        assert_eq!(
            compare_texture(&good(), &plain),
            Err(CompareError::NoTexture { which: "frame" })
        );
        let mut other = good();
        if let Some(texture) = &mut other.texture {
            texture.texels = [256, 512];
        }
        assert_eq!(
            compare_texture(&good(), &other)
                .expect_err("another picture")
                .to_string(),
            "the frame's picture has 256×512 texels, the reference's 512×256"
        );
        let mut short = good();
        pixels(&mut short).pop();
        assert!(matches!(
            compare_texture(&good(), &short),
            Err(CompareError::MalformedTexture {
                found: 479,
                required: 480,
                ..
            })
        ));
        let broken = frame_of(|_, _| [f64::NAN, 0.0]);
        assert_eq!(
            compare_texture(&broken, &good()),
            Err(CompareError::ReferenceNotFinite { found: 480 })
        );
    }

    #[test]
    fn each_texture_figure_beyond_its_limit_fails_alone() {
        let at_limit = TextureErrors {
            compared_px: 10,
            silhouette_px: 100,
            rms_texels: [0.25; 2],
            max_texels: [0.5; 2],
            ..TextureErrors::default()
        };
        assert!(is_right(&at_limit));
        let beyond: [fn(&mut TextureErrors); 6] = [
            |errors| errors.compared_px = 0,
            |errors| errors.missing_px = 1,
            |errors| errors.non_finite = 1,
            |errors| errors.rms_texels[1] = 0.2501,
            |errors| errors.max_texels[0] = 0.5001,
            |errors| errors.max_texels[1] = f64::NAN,
        ];
        for change in beyond {
            let mut errors = at_limit;
            change(&mut errors);
            match texture_verdict(&errors) {
                Verdict::Fail(reasons) => assert_eq!(reasons.len(), 1, "{reasons:?}"),
                Verdict::Pass => panic!("{errors:?} passed"),
            }
        }
    }
}
