// SPDX-License-Identifier: MIT OR Apache-2.0
//! The surface: triangles of a longitude/latitude grid, the same in every view, and their heights by
//! extent.

use std::sync::Arc;
use terrafill_core::{Ellipsoid, Extent};
use terrafill_elevation::Elevation;
use terrafill_scene::{Camera, ImageSize};
use terrafill_surface::{
    HeightRange, Parameters, Surface, SurfaceError, SurfaceFrame, SurfaceKind, SurfaceMesh,
    read_elevation,
};

/// Name in scene files.
const KIND: &str = "grid";

/// Rows where a scene names none: 1°, 128,000 triangles.
const DEFAULT_ROWS: u32 = 180;
/// Scenes over one uniform grid: `kind = "grid"`, `rows` from pole to pole, and the elevation as
/// [`read_elevation`] knows it.
#[derive(Debug, Clone, Copy)]
pub struct GridKind;

impl SurfaceKind for GridKind {
    fn name(&self) -> &'static str {
        KIND
    }

    fn open(
        &self,
        body: &Ellipsoid,
        parameters: &mut Parameters<'_>,
    ) -> Result<Arc<dyn Surface>, SurfaceError> {
        let rows = parameters.count("rows", DEFAULT_ROWS, 4..=2048)?;
        let elevation = read_elevation(body, parameters)?;
        Ok(Arc::new(GridSurface::new(body, rows, elevation)))
    }
}

#[derive(Debug)]
struct GridSurface {
    rows: u32,
    elevation: Elevation,
    mesh: SurfaceMesh,
    /// Of the triangles of each cell, row by row from the south pole and 180° west.
    cells: Vec<HeightRange>,
}

impl GridSurface {
    fn new(body: &Ellipsoid, rows: u32, elevation: Elevation) -> Self {
        let half_turn = f64::from(rows);
        let mesh = SurfaceMesh::grid(body, rows, |row, column| {
            let east = f64::from(column) / half_turn;
            elevation.height_at_half_turns(east, f64::from(row) / half_turn)
        });
        let mut cells = vec![None; 2 * (rows * rows) as usize];
        for triangle in mesh.triangles.iter() {
            let facet = mesh.facet_heights(triangle);
            // A triangle begins with the south-western vertex of its cell.
            let cell: &mut Option<HeightRange> = &mut cells[triangle[0] as usize];
            *cell = Some(cell.map_or(facet, |cell| cell.union(facet)));
        }
        Self {
            rows,
            elevation,
            // Every cell has a triangle.
            cells: cells.into_iter().flatten().collect(),
            mesh,
        }
    }

    /// Columns or rows that hold `from` … `to`, both counted in cells from the first, and one more on
    /// either side. A triangle's edges are straight in space, so that they leave its cell by up to a
    /// sixteenth of one.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "degrees by rows, a few thousand"
    )]
    fn span(from: f64, to: f64) -> (i64, i64) {
        (from.floor() as i64 - 1, to.floor() as i64 + 1)
    }
}

impl Surface for GridSurface {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn warnings(&self) -> &[String] {
        self.elevation.warnings()
    }

    fn heights(&self, extent: &Extent) -> HeightRange {
        let per_degree = f64::from(self.rows) / 180.0;
        let (rows, columns) = (i64::from(self.rows), 2 * i64::from(self.rows));
        let (west, south) = (extent.west_deg + 180.0, extent.south_deg + 90.0);
        let mut east = extent.east_deg + 180.0;
        if east < west {
            east += 360.0;
        }
        let (first, last) = Self::span(west * per_degree, east * per_degree);
        let (bottom, top) = Self::span(south * per_degree, (extent.north_deg + 90.0) * per_degree);
        let is_whole = last - first + 1 >= columns && bottom < 0 && top >= rows;
        if is_whole {
            return self.mesh.heights;
        }
        let last = last.min(first + columns - 1);
        let cells = (bottom.max(0)..=top.min(rows - 1)).flat_map(|row| {
            (first..=last).filter_map(move |column| {
                usize::try_from(row * columns + column.rem_euclid(columns)).ok()
            })
        });
        let ranges = cells.filter_map(|cell| self.cells.get(cell).copied());
        ranges
            .reduce(HeightRange::union)
            .unwrap_or(self.mesh.heights)
    }

    fn true_height_m(&self, longitude_deg: f64, latitude_deg: f64) -> Option<f64> {
        Some(self.elevation.height_m(longitude_deg, latitude_deg))
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        self.mesh.frame_by_blocks(KIND, camera, size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_elevation::{Base, Relief};
    use terrafill_scene::Scene;
    use terrafill_surface::{EllipsoidKind, open_surface};

    fn grown(rows: u32) -> GridSurface {
        let base = Base::Relief {
            relief: Relief { seed: 3 },
            amplitude_m: 11e3,
        };
        let elevation = Elevation::new(Vec::new(), base, 0.05, 1.0);
        GridSurface::new(&Ellipsoid::WGS84, rows, elevation)
    }

    fn opened(body: &str, surface: &str) -> Result<Arc<dyn Surface>, String> {
        let text = format!(
            "name = \"t\"\ndescription = \"d\"\nbody = \"{body}\"\n\
             [regions]\nembedded = \"california.geojson\"\n[surface]\nkind = \"grid\"\n{surface}\n\
             [[views]]\nname = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\n\
             heading_deg = 0\npitch_deg = 0\n"
        );
        let scene = Scene::from_toml(&text, "t.toml", None).expect("a scene");
        open_surface(&[&EllipsoidKind, &GridKind], &scene).map_err(|error| error.to_string())
    }

    #[test]
    fn a_scene_chooses_rows_seed_and_amplitude() {
        let all = "rows = 30\nseed = 5\namplitude_m = 11_000";
        let heights = |text| opened("wgs84", text).expect(text).heights(&Extent::WHOLE);
        let (high, low) = (
            heights(all),
            heights("rows = 30\nseed = 5\namplitude_m = 2e3"),
        );
        assert!((high.highest_m / low.highest_m - 5.5).abs() < 1e-12);
        assert_ne!(high, heights("rows = 30\namplitude_m = 11_000"));
        assert_eq!(opened("wgs84", "").expect("defaults").kind(), "grid");
    }

    #[test]
    fn what_is_wrong_is_named_with_file_key_value_and_what_is_allowed() {
        for (body, text, expected) in [
            (
                "wgs84",
                "amplitude_m = 11_001",
                "t.toml: surface.amplitude_m: found 11001, allowed: 0 to 11000",
            ),
            (
                "unit-sphere",
                "amplitude_m = 0.2",
                "t.toml: surface.amplitude_m: found 0.2, allowed: 0 to 0.1",
            ),
            (
                "wgs84",
                "amplitude_m = nan",
                "t.toml: surface.amplitude_m: found nan, allowed: 0 to 11000",
            ),
            (
                "wgs84",
                "seed = -1",
                "t.toml: surface.seed: found -1, allowed: 0 to 4294967295",
            ),
            (
                "wgs84",
                "rows = 2049",
                "t.toml: surface.rows: found 2049, allowed: 4 to 2048",
            ),
            (
                "wgs84",
                "height_m = 3",
                "t.toml: surface.height_m: found 3, allowed: only the keys kind, rows, vertical_exaggeration, feather, base, seed, amplitude_m",
            ),
        ] {
            assert_eq!(opened(body, text).expect_err(text), expected);
        }
    }

    /// Points of every triangle, at finer steps than cells, with their heights.
    fn points(grid: &GridSurface) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        let mesh = &grid.mesh;
        mesh.triangles.iter().flat_map(move |triangle| {
            let [a, b, c] = triangle.map(|vertex| mesh.vertices_ecef[vertex as usize]);
            (0..=5)
                .flat_map(move |i| (0..=5 - i).map(move |j| (i, j)))
                .map(move |(i, j)| {
                    let [u, v] = [i, j].map(|k| f64::from(k) / 5.0);
                    let place = mesh
                        .body
                        .ecef_to_geodetic(a * (1.0 - u - v) + b * u + c * v);
                    let degrees = [place.longitude_rad, place.latitude_rad].map(f64::to_degrees);
                    (degrees, place.height_m)
                })
        })
    }

    #[test]
    fn every_point_over_an_extent_lies_between_its_heights() {
        let grid = grown(24);
        let extents = [
            (170.0, -170.0, -20.0, 10.0),
            (-180.0, 180.0, 70.0, 90.0),
            (-180.0, 180.0, -90.0, -89.0),
            (10.0, 10.1, 20.0, 20.1),
            (0.0, 7.5, 0.0, 7.5),
            (-30.0, 80.0, -50.0, 60.0),
        ];
        let mut missed = 0;
        for (west_deg, east_deg, south_deg, north_deg) in extents {
            let extent = Extent {
                west_deg,
                south_deg,
                east_deg,
                north_deg,
            };
            let stated = grid.heights(&extent);
            let mut found = 0;
            for ([longitude, latitude], height) in points(&grid) {
                let is_between = if west_deg <= east_deg {
                    (west_deg..=east_deg).contains(&longitude)
                } else {
                    longitude >= west_deg || longitude <= east_deg
                };
                let is_within =
                    (stated.lowest_m - 1e-6..=stated.highest_m + 1e-6).contains(&height);
                if is_between && (south_deg..=north_deg).contains(&latitude) {
                    assert!(is_within, "{extent:?}: {height} not in {stated:?}");
                    found += 1;
                } else {
                    // Negative control: elsewhere it is higher or lower.
                    missed += usize::from(!is_within);
                }
            }
            assert!(found > 0 || east_deg - west_deg < 1.0, "{extent:?}");
        }
        assert!(missed > 1000, "{missed}");
        assert_eq!(grid.heights(&Extent::WHOLE), grid.mesh.heights);
    }

    #[test]
    fn ranges_of_small_extents_are_narrow() {
        let grid = grown(180);
        let span = |range: HeightRange| range.highest_m - range.lowest_m;
        let small = grid.heights(&Extent {
            west_deg: 40.2,
            south_deg: 10.2,
            east_deg: 40.4,
            north_deg: 10.4,
        });
        let whole = span(grid.mesh.heights);
        assert!(span(small) < 0.5 * whole, "{small:?} of {whole}");
        assert!(whole > 15e3, "{whole}");
    }
}
