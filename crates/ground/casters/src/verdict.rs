// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is wrong with a mesh as a caster: found at load, with a place.
//!
//! A mesh is closed if every directed edge occurs once and its reverse once. Vertices are the same
//! where their places have equal bits: a file often repeats them a triangle. A closed part that holds a
//! negative volume is inside out, unless it lies in another part's box and may be a cavity.

use crate::mesh::index;
use crate::{ConvexPart, Mesh};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};

/// Edges and triangles that keep a mesh from being a closed, oriented 2-manifold.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Verdict {
    /// Edges of one triangle only.
    pub border: usize,
    /// Edges of three triangles and more.
    pub non_manifold: usize,
    /// Edges of two triangles that are wound alike.
    pub flipped: usize,
    /// Triangles without area.
    pub degenerate: usize,
    /// Closed parts whose faces look inwards.
    pub inside_out: usize,
    /// Ends of the first of them, m.
    pub first: Option<[DVec3; 2]>,
}

impl Verdict {
    /// Whether every edge is met once in either direction, every triangle has an area and looks outwards.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.border + self.non_manifold + self.flipped + self.degenerate + self.inside_out == 0
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.is_closed() {
            return f.write_str("closed");
        }
        let counts = [
            ("border", self.border, "edges"),
            ("non-manifold", self.non_manifold, "edges"),
            ("flipped", self.flipped, "edges"),
            ("degenerate", self.degenerate, "triangles"),
            ("inside out", self.inside_out, "parts"),
        ];
        let found = counts.iter().filter(|(_, count, _)| *count > 0);
        let words: Vec<String> = found
            .map(|(what, count, of)| format!("{what} {count} {of}"))
            .collect();
        f.write_str(&words.join(", "))?;
        match self.first {
            Some([a, b]) => write!(f, ", the first from {a} to {b} m"),
            None => Ok(()),
        }
    }
}

/// Each place's first one of equal bits.
pub(crate) fn welded(places: &[DVec3]) -> Vec<u32> {
    let mut first = HashMap::new();
    let places = places.iter().enumerate();
    places
        .map(|(at, place)| {
            // −0 is 0.
            let key = place.to_array().map(|value| (value + 0.0).to_bits());
            *first.entry(key).or_insert_with(|| index(at))
        })
        .collect()
}

/// Of each undirected edge, lower vertex first: how often it is met forwards and backwards.
pub(crate) fn edges(
    triangles: impl IntoIterator<Item = [u32; 3]>,
) -> BTreeMap<[u32; 2], [usize; 2]> {
    let mut edges: BTreeMap<[u32; 2], [usize; 2]> = BTreeMap::new();
    for [a, b, c] in triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let met = edges.entry([from.min(to), from.max(to)]).or_default();
            met[usize::from(from > to)] += 1;
        }
    }
    edges
}

/// Judges each part by itself: parts may touch.
#[must_use]
pub fn verdict(mesh: &Mesh) -> Verdict {
    let mut verdict = Verdict::default();
    let mut inwards: Vec<&ConvexPart> = Vec::new();
    for part in &mesh.parts {
        let found = verdict;
        for triangle in part.triangles.clone() {
            let [a, b, c] = mesh.corners(triangle);
            if (b - a).cross(c - a) == DVec3::ZERO {
                verdict.degenerate += 1;
                verdict.first.get_or_insert([a, b]);
            }
        }
        for ([low, high], met) in part_edges(mesh, part) {
            let count = match met {
                [1, 1] => continue,
                [1, 0] | [0, 1] => &mut verdict.border,
                [2, 0] | [0, 2] => &mut verdict.flipped,
                _ => &mut verdict.non_manifold,
            };
            *count += 1;
            let place = |at: u32| mesh.vertices[at as usize];
            verdict.first.get_or_insert([place(low), place(high)]);
        }
        if verdict == found && volume_m3(mesh, part) < 0.0 {
            inwards.push(part);
        }
    }
    for part in inwards {
        let [low, high] = extent(mesh, part);
        let holds = |other: &ConvexPart| {
            let [lowest, highest] = extent(mesh, other);
            lowest.cmple(low).all() && high.cmple(highest).all() && [low, high] != [lowest, highest]
        };
        if !mesh.parts.iter().any(holds) {
            verdict.inside_out += 1;
            let [a, b, _] = mesh.corners(part.triangles.start);
            verdict.first.get_or_insert([a, b]);
        }
    }
    verdict
}

/// Volume inside a closed part, m³; negative where its faces look inwards.
fn volume_m3(mesh: &Mesh, part: &ConvexPart) -> f64 {
    let from = mesh.vertices[part.vertices.start];
    let triangles = part.triangles.clone().map(|triangle| {
        let [a, b, c] = mesh.corners(triangle).map(|place| place - from);
        a.dot(b.cross(c)) / 6.0
    });
    triangles.sum()
}

fn extent(mesh: &Mesh, part: &ConvexPart) -> [DVec3; 2] {
    let places = mesh.vertices[part.vertices.clone()].iter().copied();
    [
        places.clone().fold(DVec3::INFINITY, DVec3::min),
        places.fold(DVec3::NEG_INFINITY, DVec3::max),
    ]
}

/// Edges of a part, whose vertices of equal bits are one.
pub(crate) fn part_edges(mesh: &Mesh, part: &ConvexPart) -> BTreeMap<[u32; 2], [usize; 2]> {
    let start = index(part.vertices.start);
    let equals = welded(&mesh.vertices[part.vertices.clone()]);
    let triangles = mesh.triangles[part.triangles.clone()].iter();
    edges(triangles.map(|corners| corners.map(|corner| equals[(corner - start) as usize] + start)))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn tetrahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        (vertices, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    }

    fn judged(change: impl FnOnce(&mut Vec<DVec3>, &mut Vec<[u32; 3]>)) -> Verdict {
        let (mut vertices, mut triangles) = tetrahedron();
        change(&mut vertices, &mut triangles);
        verdict(&Mesh::from_triangles("a", vertices, triangles).expect("finite"))
    }

    #[test]
    fn each_fault_is_named_and_a_closed_mesh_has_none() {
        assert_eq!(judged(|_, _| ()).to_string(), "closed");
        let open = judged(|_, triangles| triangles.truncate(3));
        assert_eq!((open.border, open.flipped, open.non_manifold), (3, 0, 0));
        assert!(
            open.to_string()
                .starts_with("border 3 edges, the first from")
        );
        let flipped = judged(|_, triangles| triangles[0].swap(1, 2));
        assert_eq!((flipped.border, flipped.flipped), (0, 3));
        let twice = judged(|_, triangles| triangles.push([0, 2, 1]));
        assert_eq!((twice.non_manifold, twice.border), (3, 0));
        let sliver = judged(|vertices, _| vertices[3] = DVec3::new(0.5, 0.0, 0.0));
        assert_eq!(sliver.degenerate, 1);
    }

    #[test]
    fn a_body_inside_out_is_named_and_a_cavity_is_not() {
        let (vertices, triangles) = tetrahedron();
        let turned = |own: &[u32; 3]| [own[0], own[2], own[1]];
        let inwards: Vec<[u32; 3]> = triangles.iter().map(turned).collect();
        let mesh = Mesh::from_triangles("in", vertices.clone(), inwards).expect("finite");
        let found = verdict(&mesh);
        assert_eq!((found.inside_out, found.is_closed()), (1, false));
        assert!(
            found.to_string().starts_with("inside out 1 parts"),
            "{found}"
        );
        // The same around it, four times as large, the right way out.
        let outer = vertices.iter().map(|place| *place * 4.0 - 0.5);
        let outer = Mesh::from_triangles("out", outer.collect(), triangles).expect("finite");
        let mut tank = mesh;
        tank.append(&outer, DVec3::ZERO);
        assert_eq!(verdict(&tank).to_string(), "closed");
    }

    #[test]
    fn corners_of_equal_bits_are_one_and_others_leave_a_border() {
        let soup = |shift: f64| {
            judged(|vertices, triangles| {
                let places = triangles.iter().flatten().map(|at| vertices[*at as usize]);
                let mut places: Vec<DVec3> = places.collect();
                places[0].x = shift;
                *vertices = places;
                *triangles = (0..4).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
            })
        };
        assert!(soup(-0.0).is_closed());
        assert_eq!(soup(1e-300).border, 4);
    }

    #[test]
    fn a_moebius_band_is_refused_whichever_way_it_is_wound() {
        // Five triangles: the least that a Möbius band takes.
        let vertices: Vec<DVec3> = (0..5)
            .map(|at| {
                let at = f64::from(at);
                DVec3::new(at.cos(), at.sin(), at * at)
            })
            .collect();
        for turned in 0..32_u32 {
            let triangles = (0..5_u32).map(|at| {
                let [a, b, c] = [at, (at + 1) % 5, (at + 2) % 5];
                if turned >> at & 1 == 0 {
                    [a, b, c]
                } else {
                    [a, c, b]
                }
            });
            let band = Mesh::from_triangles("band", vertices.clone(), triangles.collect());
            let found = verdict(&band.expect("finite"));
            assert!(found.border == 5 && found.flipped > 0, "{found}");
        }
    }
}
