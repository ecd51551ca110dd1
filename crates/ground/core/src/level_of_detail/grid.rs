// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which vertices lie near a triangle: a grid of cells over longitude and latitude, degrees.

use super::arcs::Vertex;
use crate::edge::Degrees;
use terrafill_planar::index_u32;

/// Cells per side at most: 2²² cells are 16 MB.
const MAX_CELLS_A_SIDE: f64 = 2048.0;

/// Vertices by the cell they lie in.
pub(super) struct VertexGrid {
    low: Degrees,
    cells_per_deg: [f64; 2],
    columns: usize,
    rows: usize,
    /// Range of `vertices` that belongs to each cell, row by row.
    first: Vec<u32>,
    /// With their positions, which are read one after the other.
    vertices: Vec<(u32, Degrees)>,
}

impl VertexGrid {
    /// About one cell per vertex.
    #[allow(clippy::cast_possible_truncation, reason = "between 1 and 2,048")]
    pub(super) fn new(all: &[Vertex]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for vertex in all {
            for axis in 0..2 {
                low[axis] = low[axis].min(vertex.position[axis]);
                high[axis] = high[axis].max(vertex.position[axis]);
            }
        }
        let extent = [0, 1].map(|axis| (high[axis] - low[axis]).max(f64::MIN_POSITIVE));
        let wanted = all.len().max(1) as f64;
        let columns = (wanted * extent[0] / extent[1])
            .sqrt()
            .clamp(1.0, MAX_CELLS_A_SIDE)
            .ceil();
        let rows = (wanted / columns).clamp(1.0, MAX_CELLS_A_SIDE).ceil();
        let mut grid = Self {
            low,
            cells_per_deg: [columns / extent[0], rows / extent[1]],
            columns: columns as usize,
            rows: rows as usize,
            first: Vec::new(),
            vertices: vec![(0, [0.0; 2]); all.len()],
        };
        let cell_of = |vertex: &Vertex| {
            let [longitude, latitude] = vertex.position;
            grid.row(latitude) * grid.columns + grid.column(longitude)
        };
        let cells: Vec<usize> = all.iter().map(cell_of).collect();
        let mut past = vec![0_u32; grid.columns * grid.rows + 1];
        for &cell in &cells {
            past[cell + 1] += 1;
        }
        for cell in 1..past.len() {
            past[cell] += past[cell - 1];
        }
        grid.first.clone_from(&past);
        for (number, (vertex, &cell)) in (0..).zip(all.iter().zip(&cells)) {
            grid.vertices[past[cell] as usize] = (number, vertex.position);
            past[cell] += 1;
        }
        grid
    }

    /// Forgets all other vertices.
    pub(super) fn retain(&mut self, is_kept: impl Fn(u32) -> bool) {
        let (mut read, mut written) = (0, 0);
        for past in &mut self.first[1..] {
            for place in std::mem::replace(&mut read, *past as usize)..*past as usize {
                let own = self.vertices[place];
                if is_kept(own.0) {
                    self.vertices[written] = own;
                    written += 1;
                }
            }
            *past = index_u32(written);
        }
        self.vertices.truncate(written);
    }

    fn column(&self, longitude: f64) -> usize {
        cell(
            (longitude - self.low[0]) * self.cells_per_deg[0],
            self.columns,
        )
    }

    fn row(&self, latitude: f64) -> usize {
        cell((latitude - self.low[1]) * self.cells_per_deg[1], self.rows)
    }

    /// Whether `holds` any vertex in the box from `low` to `high`, in whatever turn of longitude.
    /// It is called with the vertex and its longitude in the box's turn.
    pub(super) fn any_in_box(
        &self,
        low: Degrees,
        high: Degrees,
        holds: &mut impl FnMut(u32, Degrees) -> bool,
    ) -> bool {
        // Vertices have longitudes above −180 and up to 180.
        let mut turn = ((low[0] - 180.0) / 360.0).ceil();
        while 360.0 * turn - 180.0 < high[0] {
            let shift = 360.0 * turn;
            let columns = self.column(low[0] - shift)..=self.column(high[0] - shift);
            for row in self.row(low[1])..=self.row(high[1]) {
                let cells =
                    row * self.columns + columns.start()..row * self.columns + columns.end() + 1;
                let range = self.first[cells.start]..self.first[cells.end];
                for &(vertex, [x, y]) in &self.vertices[range.start as usize..range.end as usize] {
                    let x = x + shift;
                    let in_box = low[0] <= x && x <= high[0] && low[1] <= y && y <= high[1];
                    if in_box && holds(vertex, [x, y]) {
                        return true;
                    }
                }
            }
            turn += 1.0;
        }
        false
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "a negative or infinite number becomes the first or last cell, which is what is meant"
)]
fn cell(at: f64, count: usize) -> usize {
    (at as usize).min(count - 1)
}
