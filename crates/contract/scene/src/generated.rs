// SPDX-License-Identifier: MIT OR Apache-2.0
//! Regions that one number of a limit each is about: rings within rings, cells that share borders, one
//! region of very many vertices. GeoJSON as text, so that they take the same way as a file.
//!
//! Degrees. Vertices come from the sine of [`crate::procedural`], so that every machine gets the same
//! bytes. The same place is always written with the same digits: neighbours share borders exactly.

use crate::procedural::{Centre, SplitMix64, coast};
use std::fmt::Write as _;

/// Smallest radius of a coast, share of its largest.
const SMALLEST_SHARE: f64 = 0.6;

/// Discs about one centre, each within the one before: as many regions lie over the innermost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nested {
    /// How many.
    pub count: u32,
    /// Vertices of each.
    pub vertices: u32,
    /// Centre, degrees.
    pub longitude_deg: f64,
    /// Centre, degrees.
    pub latitude_deg: f64,
    /// Of the outermost, degrees.
    pub radius_deg: f64,
    /// One region of rings instead: every second disc is a hole in the one around it.
    pub as_one: bool,
}

impl Nested {
    /// The discs, outermost first, as a GeoJSON `FeatureCollection`.
    #[must_use]
    pub fn geojson(&self) -> String {
        let centre = Centre::new(self.longitude_deg, self.latitude_deg);
        let shape = vec![1.0; self.vertices as usize];
        let ring = |index: u32| {
            let share = f64::from(self.count - index) / f64::from(self.count);
            centre.ring(&shape, self.radius_deg * share)
        };
        let mut text = Collection::default();
        if !self.as_one {
            for index in 0..self.count {
                text.feature(&format!("Disc {:04}", index + 1), &[vec![ring(index)]]);
            }
            return text.end();
        }
        let indices: Vec<u32> = (0..self.count).collect();
        let polygons: Vec<Vec<Vec<[f64; 2]>>> = indices
            .chunks(2)
            .map(|pair| {
                let rings = pair.iter().enumerate().map(|(place, &index)| {
                    let mut ring = ring(index);
                    if place == 1 {
                        ring.reverse();
                    }
                    ring
                });
                rings.collect()
            })
            .collect();
        text.feature("Rings", &polygons);
        text.end()
    }
}

/// A rectangle cut into cells, each a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cells {
    /// From west to east.
    pub columns: u32,
    /// From south to north.
    pub rows: u32,
    /// Western edge of the whole, degrees.
    pub west_deg: f64,
    /// Southern edge of the whole, degrees.
    pub south_deg: f64,
    /// Of the whole, degrees.
    pub width_deg: f64,
    /// Of the whole, degrees.
    pub height_deg: f64,
}

impl Cells {
    /// The cells, row by row, as a GeoJSON `FeatureCollection`.
    #[must_use]
    pub fn geojson(&self) -> String {
        let east = |column: u32| {
            self.west_deg + self.width_deg * f64::from(column) / f64::from(self.columns)
        };
        let north =
            |row: u32| self.south_deg + self.height_deg * f64::from(row) / f64::from(self.rows);
        let mut text = Collection::default();
        for row in 0..self.rows {
            for column in 0..self.columns {
                let ring = vec![
                    [east(column), north(row)],
                    [east(column + 1), north(row)],
                    [east(column + 1), north(row + 1)],
                    [east(column), north(row + 1)],
                ];
                text.feature(&format!("Cell {row}-{column}"), &[vec![ring]]);
            }
        }
        text.end()
    }
}

/// One region whose boundary is as fine as it has vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coast {
    /// Same seed, same bytes.
    pub seed: u64,
    /// Of its one ring.
    pub vertices: u32,
    /// Centre, degrees.
    pub longitude_deg: f64,
    /// Centre, degrees.
    pub latitude_deg: f64,
    /// Largest, degrees.
    pub radius_deg: f64,
}

impl Coast {
    /// The region as a GeoJSON `FeatureCollection`.
    #[must_use]
    pub fn geojson(&self) -> String {
        let mut random = SplitMix64(self.seed);
        let shape = coast(self.vertices as usize, SMALLEST_SHARE, &mut random);
        let ring = Centre::new(self.longitude_deg, self.latitude_deg).ring(&shape, self.radius_deg);
        let mut text = Collection::default();
        text.feature("Coast", &[vec![ring]]);
        text.end()
    }
}

/// A GeoJSON `FeatureCollection` being written.
#[derive(Default)]
struct Collection {
    features: String,
}

impl Collection {
    /// - `polygons`: each a shell and its holes, first vertices not repeated, degrees
    fn feature(&mut self, name: &str, polygons: &[Vec<Vec<[f64; 2]>>]) {
        let position = |[longitude, latitude]: &[f64; 2]| {
            // Twelve digits are a tenth of a micrometre.
            format!("[{longitude:.12},{latitude:.12}]")
        };
        let ring = |ring: &Vec<[f64; 2]>| {
            let closed = ring.iter().chain(ring.first()).map(position);
            format!("[{}]", closed.collect::<Vec<_>>().join(","))
        };
        let polygon = |rings: &Vec<Vec<[f64; 2]>>| {
            let rings = rings.iter().map(ring);
            format!("[{}]", rings.collect::<Vec<_>>().join(","))
        };
        let polygons: Vec<String> = polygons.iter().map(polygon).collect();
        if !self.features.is_empty() {
            self.features.push(',');
        }
        // Writing to a String cannot fail.
        let _ = write!(
            self.features,
            "\n{{\"type\":\"Feature\",\"properties\":{{\"name\":\"{name}\"}},\"geometry\":{{\
             \"type\":\"MultiPolygon\",\"coordinates\":[{}]}}}}",
            polygons.join(",")
        );
    }

    fn end(self) -> String {
        format!(
            "{{\"type\":\"FeatureCollection\",\"features\":[{}\n]}}\n",
            self.features
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_core::parse_regions;

    fn vertices(text: &str) -> Vec<usize> {
        let regions = parse_regions(text.as_bytes(), "test").expect("valid");
        let count = |region: &terrafill_core::Region| {
            region.rings().map(|ring| ring.vertices_deg().len()).sum()
        };
        regions.iter().map(count).collect()
    }

    #[test]
    fn discs_are_as_many_as_asked_for_and_as_one_region_as_many_rings() {
        let nested = Nested {
            count: 5,
            vertices: 8,
            longitude_deg: 10.0,
            latitude_deg: 20.0,
            radius_deg: 2.0,
            as_one: false,
        };
        assert_eq!(vertices(&nested.geojson()), [8; 5]);
        let as_one = Nested {
            as_one: true,
            ..nested
        };
        assert_eq!(vertices(&as_one.geojson()), [40]);
    }

    #[test]
    fn neighbouring_cells_write_the_same_place_with_the_same_digits() {
        let cells = Cells {
            columns: 7,
            rows: 3,
            west_deg: 0.1,
            south_deg: -0.3,
            width_deg: 0.7,
            height_deg: 0.9,
        };
        let regions = parse_regions(cells.geojson().as_bytes(), "test").expect("valid");
        assert_eq!(regions.len(), 21);
        let mut places: Vec<[u64; 2]> = regions
            .iter()
            .flat_map(|region| region.rings().flat_map(|ring| ring.vertices_deg().to_vec()))
            .map(|place| place.map(f64::to_bits))
            .collect();
        places.sort_unstable();
        places.dedup();
        // Negative control: were any written in two ways, there would be more than the corners of the grid.
        assert_eq!(places.len(), 8 * 4);
    }

    #[test]
    fn a_coast_has_its_vertices_and_its_seed() {
        let coast = Coast {
            seed: 1,
            vertices: 1_000,
            longitude_deg: 0.0,
            latitude_deg: 10.0,
            radius_deg: 30.0,
        };
        assert_eq!(vertices(&coast.geojson()), [1_000]);
        let other = Coast { seed: 2, ..coast };
        assert_eq!(coast.geojson(), coast.geojson());
        assert_ne!(coast.geojson(), other.geojson());
    }
}
