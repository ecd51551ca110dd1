// SPDX-License-Identifier: MIT OR Apache-2.0
//! Coordinate routes at inputs where formulas break: zeros, subnormals, the axis, the octants' seams,
//! the antimeridian, what is not a number.

use crate::coordinate::{of_route, put_operations};
use crate::kernel::{CoordinateKernel, Kernels, ask};
use crate::metrics::{NON_FINITE_DEVICE, NON_FINITE_EMULATED, POINTS};
use crate::place::RegionPicture;
use crate::row::{PrecisionPart, PrecisionRow};
use glam::DVec3;
use terrafill_gpu::Evaluation;
use terrafill_results::Status;
use terrafill_study::StudyError;
use terrafill_texture::{Arithmetic, CoordinateRoute, MapRegion};

/// One input.
#[derive(Debug)]
pub(crate) struct Special {
    name: &'static str,
    /// Of the whole globe, anchored at 20° on the equator; else of 10° at 45°.
    on_globe: bool,
    /// Whether a fragment can be there.
    is_fragment: bool,
    /// Offset from the anchor.
    offset: fn(&MapRegion) -> [f32; 3],
}

impl Special {
    /// Extent and latitude of the region that the input belongs to, degrees.
    fn region_deg(&self) -> (f64, f64) {
        if self.on_globe {
            (360.0, 0.0)
        } else {
            (10.0, 45.0)
        }
    }
}

/// The position, meridian axes, from the body's centre, as an offset.
fn from_centre(region: &MapRegion, position: [f64; 3]) -> [f32; 3] {
    let offset = DVec3::from_array(position) - region.anchor_meridian();
    offset.as_vec3().to_array()
}

fn radius(region: &MapRegion) -> f64 {
    region.body().equatorial_radius_m()
}

/// On the equator at this longitude from the anchor's, on the globe.
fn on_equator(region: &MapRegion, longitude_deg: f64) -> [f32; 3] {
    let (sin, cos) = longitude_deg.to_radians().sin_cos();
    from_centre(region, [radius(region) * cos, radius(region) * sin, 0.0])
}

/// The same with this zero in place of the sine.
fn on_meridian(region: &MapRegion, longitude_deg: f64, zero: f32) -> [f32; 3] {
    let [x, _, z] = on_equator(region, longitude_deg);
    [x, zero, z]
}

fn pole(region: &MapRegion, sign: f64) -> [f32; 3] {
    from_centre(region, [0.0, 0.0, sign * region.body().polar_radius_m()])
}

/// Every input. Those of the globe reach every octant; of a small region's only those inside.
pub(crate) static INPUTS: [Special; 24] = [
    inside("anchor, +0", |_| [0.0; 3]),
    inside("anchor, -0", |_| [-0.0; 3]),
    inside("anchor, mixed zeros", |_| [0.0, -0.0, 0.0]),
    inside("subnormal offset", |_| [1e-40, -1e-40, 1e-40]),
    inside("smallest subnormal offset", |_| [f32::from_bits(1); 3]),
    inside("1 m north", |_| [0.0, 0.0, 1.0]),
    inside("1 m east", |_| [0.0, 1.0, 0.0]),
    globe("meridian, +0", |region| on_meridian(region, 0.0, 0.0)),
    globe("octant seam 45°", |region| on_equator(region, 45.0)),
    globe("octant seam -45°", |region| on_equator(region, -45.0)),
    globe("octant seam 90°", |region| on_equator(region, 90.0)),
    globe("octant seam 135°", |region| on_equator(region, 135.0)),
    globe("octant seam -135°", |region| on_equator(region, -135.0)),
    globe("antimeridian, +0", |region| on_meridian(region, 180.0, 0.0)),
    globe("antimeridian, -0", |region| {
        on_meridian(region, 180.0, -0.0)
    }),
    globe("north pole", |region| pole(region, 1.0)),
    globe("south pole", |region| pole(region, -1.0)),
    globe("1 mm beside the north pole", |region| {
        from_centre(region, [1e-3, 0.0, region.body().polar_radius_m()])
    }),
    beyond("body's centre", |region| from_centre(region, [0.0; 3])),
    beyond("+∞", |_| [f32::INFINITY, 0.0, 0.0]),
    beyond("-∞", |_| [0.0, f32::NEG_INFINITY, 0.0]),
    beyond("∞ on every axis", |_| [f32::INFINITY; 3]),
    beyond("NaN", |_| [f32::NAN; 3]),
    beyond("largest float", |_| [f32::MAX; 3]),
];

const fn inside(name: &'static str, offset: fn(&MapRegion) -> [f32; 3]) -> Special {
    Special {
        on_globe: false,
        ..globe(name, offset)
    }
}

const fn globe(name: &'static str, offset: fn(&MapRegion) -> [f32; 3]) -> Special {
    Special {
        name,
        on_globe: true,
        is_fragment: true,
        offset,
    }
}

/// Where no fragment is: what cleared depth or a broken position would give.
const fn beyond(name: &'static str, offset: fn(&MapRegion) -> [f32; 3]) -> Special {
    Special {
        is_fragment: false,
        ..globe(name, offset)
    }
}

/// A route's row at an input before anything is measured.
pub(crate) fn identity(input: &Special, route: &CoordinateRoute) -> PrecisionRow {
    let (extent_deg, latitude_deg) = input.region_deg();
    PrecisionRow {
        extent_deg: Some(extent_deg),
        latitude_deg: Some(latitude_deg),
        ..of_route(PrecisionPart::Special, route, input.name.to_owned())
    }
}

/// Rows of every route at an input.
pub(crate) fn rows(input: &Special, kernels: &Kernels) -> Result<Vec<PrecisionRow>, StudyError> {
    let (extent_deg, latitude_deg) = input.region_deg();
    let Some(place) = RegionPicture::new(extent_deg, latitude_deg, ("0", 0.0, 0.0)) else {
        return Ok(Vec::new());
    };
    let kernels = kernels.coordinate.iter();
    kernels.map(|kernel| row(input, &place, kernel)).collect()
}

fn row(
    special: &Special,
    place: &RegionPicture,
    kernel: &CoordinateKernel,
) -> Result<PrecisionRow, StudyError> {
    let mut row = identity(special, &kernel.route);
    put_operations(&mut row, &kernel.program.operations());
    let offset = (special.offset)(&place.region);
    let constants = kernel.route.constants(&place.region);
    let program = &kernel.program;
    let emulated = program.emulate(&constants, offset, Arithmetic::Fused);
    let [x, y, z] = offset;
    let device = ask(&kernel.device, &constants, &[[x, y, z, 0.0]])?;
    let text = |[longitude, latitude]: [f32; 2]| format!("{longitude:?} {latitude:?}");
    put_answers(&mut row, emulated, device, text);
    if row.non_finite() > 0 && special.is_fragment {
        (row.status, row.reason) = (Status::Wrong, "not finite".to_owned());
    } else if !special.is_fragment && row.reason.is_empty() {
        row.reason = "no fragment is there".to_owned();
    }
    Ok(row)
}

/// What the emulation and the device answer to one input, or why the device does not.
pub(crate) fn put_answers<const N: usize>(
    row: &mut PrecisionRow,
    emulated: [f32; N],
    device: Result<Evaluation, String>,
    text: fn([f32; N]) -> String,
) {
    let is_lost = |answer: [f32; N]| answer.iter().any(|value| !value.is_finite());
    row.put(POINTS, 1.0);
    row.emulated_answer = text(emulated);
    row.put(NON_FINITE_EMULATED, f64::from(is_lost(emulated)));
    row.status = Status::Ok;
    match device {
        Ok(answers) => {
            let answer = std::array::from_fn(|at| answers.values[0][at]);
            row.device_answer = text(answer);
            row.put(NON_FINITE_DEVICE, f64::from(is_lost(answer)));
        }
        Err(why) => (row.status, row.reason) = (Status::Skipped, why),
    }
}
