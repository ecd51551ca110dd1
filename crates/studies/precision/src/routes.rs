// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which coordinate routes are measured, and which of them are one curve.

use crate::place::RegionPicture;
use rayon::prelude::*;
use terrafill_texture::{
    AngleCore, AngleForm, Chart, Chooser, CoordinateRoute, Filter, LatitudeForm, TexelFormat,
    Weight,
};

/// Largest cube texture: the next one, 192 MiB, takes longer to compute than all else to measure.
const LARGEST_CUBE: u32 = 1024;

/// Entries of the tables: each four times the one before, from the smallest to the largest there is.
const TABLE_TEXELS: [u16; 5] = [16, 64, 256, 1024, 4096];

/// The polynomial on which forms of latitude are compared: its own error is at the floor of `f32`.
const FINEST: AngleCore = AngleCore::Odd {
    degree: 15,
    weight: Weight::Absolute,
};

/// The routes of the suite: of absolute angles every family, of recentred ones the two that span the
/// others, forms of latitude on one core.
pub(crate) fn coordinate_routes(quick: bool) -> Vec<CoordinateRoute> {
    let mut routes = CoordinateRoute::all();
    routes.retain(if quick { is_quick } else { is_main });
    routes
}

/// What a frame plan takes in each region.
pub(crate) fn chosen(places: &[RegionPicture]) -> Vec<Option<CoordinateRoute>> {
    let chooser = Chooser::of_plan();
    places
        .par_iter()
        .map(|place| {
            let choice = chooser.choose(&place.demand());
            choice.chosen.map(|considered| considered.route)
        })
        .collect()
}

fn is_main(route: &CoordinateRoute) -> bool {
    match route {
        CoordinateRoute::Chart(Chart::Cube(size)) => size.get() <= LARGEST_CUBE,
        CoordinateRoute::Chart(_) => true,
        CoordinateRoute::Angles {
            form,
            core,
            latitude,
        } => match (form, latitude) {
            (AngleForm::Recentred, latitude) if *latitude != LatitudeForm::Bowring1 => {
                *core == FINEST
            }
            // As the web globe has it: the geocentric latitude for the geodetic one.
            (AngleForm::Absolute, LatitudeForm::Geocentric) => *core == AngleCore::CesiumCubic,
            (_, LatitudeForm::Bowring1) => match form {
                AngleForm::Absolute => is_measured_table(core),
                _ => is_leading(core),
            },
            _ => false,
        },
        _ => false,
    }
}

fn is_quick(route: &CoordinateRoute) -> bool {
    let lean = match route {
        CoordinateRoute::Angles { form, core, .. } => *form != AngleForm::Near && is_leading(core),
        CoordinateRoute::Chart(Chart::Cube(size)) => size.get() <= 256,
        _ => true,
    };
    lean && is_main(route)
}

/// Tables: every way of reading of the exact format, and the linear sampler of the others.
fn is_measured_table(core: &AngleCore) -> bool {
    match core {
        AngleCore::Lookup {
            texels,
            format,
            filter,
        } => {
            let is_way = *format == TexelFormat::R32Float || *filter == Filter::Linear;
            is_way && TABLE_TEXELS.contains(texels)
        }
        _ => true,
    }
}

fn is_leading(core: &AngleCore) -> bool {
    matches!(
        core,
        AngleCore::Native
            | AngleCore::Odd {
                weight: Weight::Absolute,
                ..
            }
            | AngleCore::Rational {
                weight: Weight::Absolute,
                ..
            }
    )
}

/// What is one curve, and where on it the route stands: degree, texels, steps.
pub(crate) fn family(route: &CoordinateRoute) -> (String, Option<f64>) {
    match route {
        CoordinateRoute::Chart(chart) => match chart {
            Chart::Planes => ("planes".to_owned(), None),
            Chart::Barycentric => ("barycentric".to_owned(), None),
            Chart::Gnomonic(degree) => ("gnomonic".to_owned(), Some(f64::from(degree.get()))),
            Chart::Azimuthal(terms) => ("azimuthal".to_owned(), Some(f64::from(terms.get()))),
            Chart::Cube(size) => ("cube".to_owned(), Some(f64::from(size.get()))),
        },
        CoordinateRoute::Angles {
            form,
            core,
            latitude,
        } => {
            let prefix = form.prefix();
            let (name, knob) = core_family(core);
            if *latitude == LatitudeForm::Bowring1 {
                (format!("{prefix}{name}"), knob)
            } else if *core == FINEST {
                // One core through the forms of latitude; of others, those that a plan takes.
                let place = LatitudeForm::ALL.iter().position(|form| form == latitude);
                let name = format!("{prefix}{}, forms of latitude", core.name());
                (name, place.map(|place| place as f64))
            } else {
                (format!("{prefix}{name}+{}", latitude.name()), knob)
            }
        }
        _ => (route.name(), None),
    }
}

fn core_family(core: &AngleCore) -> (String, Option<f64>) {
    let weight_name = |weight: &Weight| match weight {
        Weight::Absolute => "",
        Weight::Relative => "-rel",
        Weight::Pinned => "-pin",
    };
    match core {
        AngleCore::Native => (core.name(), None),
        AngleCore::Lookup {
            texels,
            format,
            filter,
        } => {
            let name = format!("lut-{}-{}", format.name(), filter.name());
            (name, Some(f64::from(*texels)))
        }
        AngleCore::Odd { degree, weight } => {
            let name = format!("odd{}", weight_name(weight));
            (name, Some(f64::from(*degree)))
        }
        AngleCore::Dense { degree } => ("dense".to_owned(), Some(f64::from(*degree))),
        AngleCore::CesiumCubic => (core.name(), None),
        AngleCore::Rational {
            numerator,
            denominator,
            weight,
        } => {
            let name = format!("rat{}", weight_name(weight));
            (name, Some(f64::from(numerator + denominator)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_family_is_in_the_suite_and_no_two_routes_share_a_place_on_a_curve() {
        let routes = coordinate_routes(false);
        let places: BTreeSet<String> = routes
            .iter()
            .map(|route| format!("{:?}", family(route)))
            .collect();
        assert_eq!(places.len(), routes.len());
        let families: BTreeSet<String> = routes.iter().map(|route| family(route).0).collect();
        for name in [
            "atan2-native",
            "recentred-atan2-native",
            "odd",
            "odd-rel",
            "odd-pin",
            "dense",
            "cubic-cesium",
            "cubic-cesium+geocentric",
            "rat",
            "rat-rel",
            "near-odd",
            "recentred-odd",
            "recentred-odd-15, forms of latitude",
            "lut-r32f-nearest",
            "lut-r32f-linear",
            "lut-r32f-linear-exact",
            "lut-r8-linear",
            "lut-r16-linear",
            "lut-r16f-linear",
            "planes",
            "gnomonic",
            "azimuthal",
            "cube",
        ] {
            assert!(families.contains(name), "{name}: {families:?}");
        }
        let quick = coordinate_routes(true);
        assert!(quick.len() * 2 < routes.len() && quick.iter().all(|r| routes.contains(r)));
    }
}
