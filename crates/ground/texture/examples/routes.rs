// SPDX-License-Identifier: MIT OR Apache-2.0
//! Prints what every route costs and leaves over a region of WGS 84, as CSV.
//!
//! `cargo run --release -p terrafill-texture --example routes -- LATITUDE_DEG SIZE_DEG`; heights from
//! −11 km to 9 km.

use terrafill_core::Ellipsoid;
use terrafill_texture::{CoordinateRoute, MapExtent, MapRegion};

#[allow(
    clippy::print_stdout,
    reason = "a command-line tool reports on standard output"
)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [latitude, size] = &arguments[..] else {
        return Err("usage: routes LATITUDE_DEG SIZE_DEG".into());
    };
    let (latitude, size): (f64, f64) = (latitude.parse()?, size.parse()?);
    let south = (latitude - size / 2.0).max(-90.0);
    let north = (latitude + size / 2.0).min(90.0);
    let extent = MapExtent::from_degrees(-size / 2.0, south, size / 2.0, north);
    let region = MapRegion::anchored(Ellipsoid::WGS84, extent, (-11e3, 9e3))?;
    println!(
        "route,add_mul_fma,divisions,compares_selects,sqrt,transcendental,texture_fetches,\
         sign_changes,max_m,max_rad,expected_max_rad,rms_rad,non_finite"
    );
    for route in CoordinateRoute::all() {
        let (o, r) = (route.operations(), route.residual(&region));
        println!(
            "{},{},{},{},{},{},{},{},{:e},{:e},{:e},{:e},{}",
            route.name(),
            o.add_mul_fma,
            o.divisions,
            o.compares_selects,
            o.sqrt,
            o.transcendental,
            o.texture_fetches,
            o.sign_changes,
            r.max_m,
            r.max_rad,
            r.expected_max_rad,
            r.rms_rad,
            r.non_finite
        );
    }
    Ok(())
}
