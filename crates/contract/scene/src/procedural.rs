// SPDX-License-Identifier: MIT OR Apache-2.0
//! A planet of islands with fractal coasts, grown from a seed, as GeoJSON.
//!
//! Degrees. Text and not [`terrafill_core::Region`] comes out, so that a procedural scene takes the
//! same way through the parser as a file does, and can be saved and given to another program.
//!
//! Centres lie on a Fibonacci lattice (Swinbank & Purser, 2006, "Fibonacci grids"), jittered. Each
//! coast is a star-shaped curve round its centre in longitude × cos(centre's latitude) and latitude.
//! That frame is an affine picture of the plane in which planar edges are straight, so a
//! star-shaped ring can never cross itself. Its radius is a sum of periodic value noises, each
//! octave twice as fine and about half as strong as the one before.
//!
//! Every machine must get the same bytes, and the sine of one C library differs from another's in
//! the last bit. Rounding the result only makes a difference rare (one in a million coordinates,
//! and there are 168,000), so sine and arc sine are computed here from the four operations, which
//! IEEE 754 fixes.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;

/// Share of the lattice's range of z that is used: centres stay within 76° of the equator, so that
/// longitude × cos(latitude) remains a fair picture of an island and no island holds a pole.
const LATTICE_Z_LIMIT: f64 = 0.97;
/// Longitude between neighbours on the lattice, degrees: 360° divided by the golden ratio squared.
const GOLDEN_ANGLE_DEG: f64 = 137.507_764_050_037_85;
/// Largest displacement of a centre, share of the mean distance between centres.
const JITTER: f64 = 0.08;
/// Largest radius, share of the distance to the nearest centre. Below one half, so that two
/// neighbours leave water between them.
const RADIUS_SHARE: f64 = 0.47;
/// Strength of an octave over the one before: a coastline of fractal dimension about 1.2.
const ROUGHNESS: f64 = 0.56;
/// Lattice points of the coarsest octave round the coast.
const COARSEST_OCTAVE: usize = 3;
/// Largest radius of a lake, share of the shell's smallest radius.
const LAKE_SHARE: f64 = 0.6;
/// Share of a region's vertices that its lake gets: one in this many.
const LAKE_VERTEX_DIVISOR: usize = 8;

/// What a planet of islands is grown from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Islands {
    /// Same seed, same bytes.
    pub seed: u64,
    /// How many islands: one region each.
    pub count: u32,
    /// Fewest boundary vertices of an island, its lake's included.
    pub min_vertices: u32,
    /// Most boundary vertices of an island, its lake's included.
    pub max_vertices: u32,
    /// Every so many islands one has a lake; 0 for none.
    pub lake_every: u32,
}

impl Islands {
    /// The islands as a GeoJSON `FeatureCollection`, coordinates rounded to 1e-7 degrees (1 cm).
    ///
    /// Shells wind counter-clockwise, lakes clockwise (RFC 7946 §3.1.6). A ring over the
    /// antimeridian goes on past ±180.
    #[must_use]
    pub fn geojson(&self) -> String {
        let mut random = SplitMix64(self.seed);
        let centres = centres(self.count, &mut random);
        let mut text = String::from("{\"type\":\"FeatureCollection\",\"features\":[");
        for (i, centre) in centres.iter().enumerate() {
            let rings = self.rings(i, centre, largest_radius_deg(i, &centres), &mut random);
            let separator = if i == 0 { "" } else { "," };
            // Writing to a String cannot fail.
            let _ = write!(
                text,
                "{separator}\n{{\"type\":\"Feature\",\"properties\":{{\"name\":\"Island {:03}\"}},\
                 \"geometry\":{{\"type\":\"Polygon\",\"coordinates\":[",
                i + 1
            );
            for (k, ring) in rings.iter().enumerate() {
                text.push_str(if k == 0 { "[" } else { ",[" });
                for (j, [longitude, latitude]) in ring.iter().chain(ring.first()).enumerate() {
                    let separator = if j == 0 { "" } else { "," };
                    let _ = write!(text, "{separator}[{longitude:.7},{latitude:.7}]");
                }
                text.push(']');
            }
            text.push_str("]}}");
        }
        text.push_str("\n]}\n");
        text
    }

    /// Shell and, for some, a lake; first vertex not repeated.
    fn rings(
        &self,
        index: usize,
        centre: &Centre,
        largest_radius_deg: f64,
        random: &mut SplitMix64,
    ) -> Vec<Vec<[f64; 2]>> {
        let choices = u64::from(self.max_vertices.saturating_sub(self.min_vertices)) + 1;
        let vertices = self.min_vertices as usize + random.below(choices);
        let every = self.lake_every as usize;
        let lake_vertices = if every > 0 && index % every == every - 1 {
            (vertices / LAKE_VERTEX_DIVISOR).max(3)
        } else {
            0
        };
        let radius_deg = largest_radius_deg * random.between(0.75, 1.0);
        let smallest = random.between(0.45, 0.7);
        let shell = coast(vertices - lake_vertices, smallest, random);
        let mut rings = vec![centre.ring(&shell, radius_deg)];
        if lake_vertices > 0 {
            let shape = coast(lake_vertices, 0.5, random);
            let mut lake = centre.ring(&shape, radius_deg * smallest * LAKE_SHARE);
            lake.reverse();
            rings.push(lake);
        }
        rings
    }
}

/// Middle of an island.
pub(crate) struct Centre {
    longitude_deg: f64,
    latitude_deg: f64,
    cos_latitude: f64,
    unit: [f64; 3],
}

impl Centre {
    pub(crate) fn new(longitude_deg: f64, latitude_deg: f64) -> Self {
        let (longitude, latitude) = (longitude_deg * PI / 180.0, latitude_deg * PI / 180.0);
        let cos_latitude = cosine(latitude);
        Self {
            longitude_deg,
            latitude_deg,
            cos_latitude,
            unit: [
                cos_latitude * cosine(longitude),
                cos_latitude * sine(longitude),
                sine(latitude),
            ],
        }
    }

    /// Length of the chord between two centres, degrees of a unit circle's arc. Shorter than the
    /// arc, so it errs towards water.
    fn distance_deg(&self, other: &Self) -> f64 {
        let squared: f64 = self
            .unit
            .iter()
            .zip(&other.unit)
            .map(|(a, b)| (a - b) * (a - b))
            .sum();
        squared.sqrt() * 180.0 / PI
    }

    /// The coast with radii `shape` × `radius_deg`, degrees.
    pub(crate) fn ring(&self, shape: &[f64], radius_deg: f64) -> Vec<[f64; 2]> {
        let step = TAU / shape.len() as f64;
        shape
            .iter()
            .enumerate()
            .map(|(i, radius)| {
                let angle = i as f64 * step;
                let (x, y) = (cosine(angle), sine(angle));
                [
                    self.longitude_deg + radius * radius_deg * x / self.cos_latitude,
                    self.latitude_deg + radius * radius_deg * y,
                ]
            })
            .collect()
    }
}

/// Points spread evenly over the planet.
fn centres(count: u32, random: &mut SplitMix64) -> Vec<Centre> {
    // Mean distance between neighbours, were each to own a square.
    let spacing_deg = (2.0 * TAU / f64::from(count)).sqrt() * 180.0 / PI;
    (0..count)
        .map(|i| {
            let z = LATTICE_Z_LIMIT * (1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count));
            let latitude = arc_sine(z) * 180.0 / PI;
            let reach = spacing_deg * JITTER;
            let latitude = latitude + random.between(-reach, reach);
            let along = random.between(-reach, reach) / cosine(latitude * PI / 180.0);
            let longitude = f64::from(i) * GOLDEN_ANGLE_DEG + along;
            Centre::new(longitude - 360.0 * (longitude / 360.0).round(), latitude)
        })
        .collect()
}

/// Radius, degrees, within which an island stays clear of its neighbours.
///
/// Towards the equator a degree of longitude is longer than at the island's centre, which
/// stretches the picture on the sphere by up to `sqrt(cos(nearest latitude) / cos(centre))`
/// (haversine formula). The radius shrinks by that.
fn largest_radius_deg(index: usize, centres: &[Centre]) -> f64 {
    let centre = &centres[index];
    let nearest = centres
        .iter()
        .enumerate()
        .filter(|(i, _)| *i != index)
        .map(|(_, other)| centre.distance_deg(other))
        .fold(120.0, f64::min);
    let radius = nearest * RADIUS_SHARE;
    let towards_equator = (centre.latitude_deg.abs() - radius).max(0.0);
    let stretch = cosine(towards_equator * PI / 180.0) / centre.cos_latitude;
    radius / stretch.sqrt()
}

/// `count` radii round a coast, between `smallest` and 1, both reached.
pub(crate) fn coast(count: usize, smallest: f64, random: &mut SplitMix64) -> Vec<f64> {
    let mut radii = vec![0.0; count];
    let mut points = COARSEST_OCTAVE;
    let mut strength = 1.0;
    while points <= count {
        let values: Vec<f64> = (0..points).map(|_| random.between(-1.0, 1.0)).collect();
        for (i, radius) in radii.iter_mut().enumerate() {
            let scaled = i * points;
            let (cell, within) = (scaled / count, (scaled % count) as f64 / count as f64);
            // Smoothstep: no kink where octaves meet.
            let weight = within * within * (3.0 - 2.0 * within);
            let (left, right) = (values[cell], values[(cell + 1) % points]);
            *radius += strength * (left + (right - left) * weight);
        }
        points *= 2;
        strength *= ROUGHNESS;
    }
    let low = radii.iter().copied().fold(f64::INFINITY, f64::min);
    let high = radii.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let scale = (1.0 - smallest) / (high - low).max(f64::MIN_POSITIVE);
    for radius in &mut radii {
        *radius = smallest + (*radius - low) * scale;
    }
    radii
}

/// Random numbers after Steele, Lea & Flood (2014), "Fast splittable pseudorandom number
/// generators": 64 bits of state, integer arithmetic only.
pub(crate) struct SplitMix64(pub(crate) u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in `low .. high`, from the 53 bits that an f64 holds.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.next() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Uniform in `0 .. limit`; the bias of the remainder is below 2⁻⁵⁰ for the limits used here.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "less than `limit`, which came from a u32"
    )]
    fn below(&mut self, limit: u64) -> usize {
        (self.next() % limit) as usize
    }
}

/// Sine by its Taylor series after reduction to `[-π, π]`: the first term left out is below
/// 3e-17 there.
fn sine(angle_rad: f64) -> f64 {
    let x = angle_rad - TAU * (angle_rad / TAU).round();
    let square = x * x;
    let mut sum = 0.0;
    for k in (1..=14).rev() {
        let n = f64::from(2 * k);
        sum = (1.0 + sum) * -square / (n * (n + 1.0));
    }
    x * (1.0 + sum)
}

fn cosine(angle_rad: f64) -> f64 {
    sine(angle_rad + FRAC_PI_2)
}

/// Arc sine of `|z| ≤ 0.97` by Newton's method, which approaches the root from one side here since
/// the sine is concave between 0 and π/2.
fn arc_sine(z: f64) -> f64 {
    let mut x = z;
    for _ in 0..32 {
        x += (z - sine(x)) / cosine(x);
    }
    x
}
