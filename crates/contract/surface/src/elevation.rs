// SPDX-License-Identifier: MIT OR Apache-2.0
//! Elevation as scenes name it, the same for every kind of surface that has any.

use crate::{Parameters, SurfaceError};
use std::ops::RangeInclusive;
use terrafill_core::Ellipsoid;
use terrafill_elevation::{Base, Elevation, Relief, read};

/// Highest or deepest that terrain may be, metres: the Mariana Trench.
const MAX_AMPLITUDE_M: f64 = 11_000.0;
/// The same on small bodies, share of the smallest curvature radius: beyond it hills overhang.
const MAX_AMPLITUDE_SHARE: f64 = 0.1;
/// Highest or deepest where a scene says nothing, metres: the Himalayas.
const DEFAULT_AMPLITUDE_M: f64 = 8_000.0;
/// Share of a file's shorter side over which it goes over into what lies below it: 1.5 km of a survey
/// of 0.3°.
const DEFAULT_FEATHER: f64 = 0.05;
/// Ten times is what globes offer; a hundred shows a plain's relief.
const MAX_EXAGGERATION: f64 = 100.0;

/// Heights of the Earth, metres: the Mariana Trench and Mount Everest with room for the geoid and the survey.
const EARTH_M: RangeInclusive<f64> = -12_000.0..=9_000.0;

/// Elevation from the keys of a scene's `[surface]`:
///
/// - `files`: height files, the first on top; each a `path`, a `sha256` and `how` to get it
/// - `base`: what lies under them, `flat` or `relief`; `relief` where there are no files
/// - `seed` and `amplitude_m`: of the relief; the second is the highest or deepest that it may be
/// - `feather`: share of a file's shorter side over which it goes over into what lies below it
/// - `vertical_exaggeration`: every height times this
///
/// # Errors
/// [`SurfaceError::Value`], and [`SurfaceError::Data`] for a file that is no elevation.
pub fn read_elevation(
    body: &Ellipsoid,
    parameters: &mut Parameters<'_>,
) -> Result<Elevation, SurfaceError> {
    let files = parameters.files();
    let most = 1.0..=MAX_EXAGGERATION;
    let exaggeration = parameters.number("vertical_exaggeration", 1.0, most)?;
    let feather = parameters.number("feather", DEFAULT_FEATHER, 0.0..=0.5)?;
    let default = if files.is_empty() { "relief" } else { "flat" };
    let base = match parameters.word("base", default, &["flat", "relief"])? {
        "relief" => relief(body, parameters)?,
        _ => Base::Flat,
    };
    let earth_m = Ellipsoid::WGS84.equatorial_radius_m();
    let is_earth = (body.equatorial_radius_m() / earth_m - 1.0).abs() < 1e-3;
    let fields = files.iter().map(|file| {
        let field = read(&file.path, &file.bytes).map_err(|error| SurfaceError::Data {
            file: parameters.scene_file().to_owned(),
            message: error.to_string(),
        })?;
        Ok(if is_earth {
            field.expected_within(EARTH_M)
        } else {
            field
        })
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    Ok(Elevation::new(fields, base, feather, exaggeration))
}

fn relief(body: &Ellipsoid, parameters: &mut Parameters<'_>) -> Result<Base, SurfaceError> {
    let seed = parameters.count("seed", 1, 0..=u32::MAX)?;
    let most_m = MAX_AMPLITUDE_SHARE * body.smallest_curvature_radius_m();
    let most_m = most_m.min(MAX_AMPLITUDE_M);
    let default_m = most_m.min(DEFAULT_AMPLITUDE_M);
    let amplitude_m = parameters.number("amplitude_m", default_m, 0.0..=most_m)?;
    Ok(Base::Relief {
        relief: Relief { seed },
        amplitude_m,
    })
}
