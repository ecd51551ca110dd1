// SPDX-License-Identifier: MIT OR Apache-2.0
//! Index lists of two widths, as every layout of meshes in GPU buffers has them.

use terrafill_core::{RegionMesh, index_u32};

/// Indices of a scene: of 16 bits for regions whose vertices fit, of 32 for the others.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct IndexLists {
    /// Of 16 bits.
    pub short: Vec<u16>,
    /// Of 32 bits.
    pub long: Vec<u32>,
}

impl IndexLists {
    /// Whether 16 bits tell so many vertices apart where no value has another meaning: in lists of triangles, which
    /// have no restart.
    #[must_use]
    pub fn are_short(vertices: usize) -> bool {
        vertices <= 0x1_0000
    }

    /// Appends `index` to the list of its region's width. `u32::MAX` is the largest value of either,
    /// which restarts strips and separates loops.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "short indices are below 2^16 by choice of width, or the restart value"
    )]
    pub fn push(&mut self, is_short: bool, index: u32) {
        if is_short {
            self.short.push(index as u16);
        } else {
            self.long.push(index);
        }
    }

    /// Appends `indices` to the list of their region's width.
    pub fn extend(&mut self, is_short: bool, indices: impl IntoIterator<Item = u32>) {
        for index in indices {
            self.push(is_short, index);
        }
    }

    /// Caps of vertices that are stored twice: all of the top, then all of the bottom, so that the bottom may be left
    /// out of a draw.
    pub fn push_doubled_caps(&mut self, is_short: bool, triangles: &[[u32; 3]], has_bottom: bool) {
        let top = triangles.as_flattened().iter();
        self.extend(is_short, top.map(|corner| 2 * corner));
        let bottom = triangles.iter().filter(|_| has_bottom);
        let turned = bottom.flat_map(|&[a, b, c]| [a, c, b]);
        self.extend(is_short, turned.map(|corner| 2 * corner + 1));
    }

    /// Walls of vertices that are stored twice: a strip for each loop, closed and followed by a restart.
    pub fn push_doubled_strips(&mut self, is_short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            let closed = ring.iter().chain(ring.first());
            let ends = closed.flat_map(|vertex| [2 * vertex, 2 * vertex + 1]);
            self.extend(is_short, ends.chain([u32::MAX]));
        }
    }

    /// Loops, closed and each followed by a restart.
    pub fn push_loops(&mut self, is_short: bool, mesh: &RegionMesh) {
        for ring in &mesh.boundary_loops {
            let closed = ring.iter().chain(ring.first()).copied();
            self.extend(is_short, closed.chain([u32::MAX]));
        }
    }

    /// Indices of one width so far.
    #[must_use]
    pub fn count(&self, is_short: bool) -> u32 {
        index_u32(if is_short {
            self.short.len()
        } else {
            self.long.len()
        })
    }

    /// Puts others behind them.
    pub fn append(&mut self, others: &Self) {
        self.short.extend(&others.short);
        self.long.extend(&others.long);
    }

    /// Bytes of both.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.short.len() as u64 * 2 + self.long.len() as u64 * 4
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_lies_in_the_list_of_its_width() {
        let mut lists = IndexLists::default();
        for (is_short, index) in [
            (true, 7),
            (false, 70_000),
            (true, u32::MAX),
            (false, u32::MAX),
        ] {
            lists.push(is_short, index);
        }
        assert_eq!(lists.short, [7, 0xffff]);
        assert_eq!(lists.long, [70_000, u32::MAX]);
        lists.append(&IndexLists {
            short: vec![8],
            long: Vec::new(),
        });
        assert_eq!((lists.count(true), lists.count(false)), (3, 2));
        assert_eq!(lists.bytes(), 3 * 2 + 2 * 4);
        let control = IndexLists {
            short: lists.short.clone(),
            ..IndexLists::default()
        };
        assert_ne!(control.bytes(), lists.bytes());
    }
}
