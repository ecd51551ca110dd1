// SPDX-License-Identifier: MIT OR Apache-2.0
//! Layouts against their formulas, and what geometry shaders would make of them.

use super::*;
use std::collections::BTreeSet;
use terrafill_fixtures::by_hand::{circle_deg, mesh};
use terrafill_fixtures::check_held_layouts;
use terrafill_scene::Scene;

fn built(technique: Extrusion, indices: Indices, meshes: &[RegionMesh]) -> SceneGeometry {
    let variant = NativeVariant {
        technique,
        indices: Some(indices),
        ..NativeVariant::default()
    };
    SceneGeometry::build(&variant, meshes, |_| true)
}

/// A ring of `count` vertices on each of two circles, and the triangles between them: a disc
/// with a hole, every vertex on the boundary.
pub(crate) fn annulus(count: u32) -> RegionMesh {
    let vertices_deg = [circle_deg(count, 1.0), circle_deg(count, 0.5)].concat();
    let next = |i: u32| (i + 1) % count;
    let between = |i: u32| {
        [
            [i, next(i), count + i],
            [next(i), count + next(i), count + i],
        ]
    };
    let loops = vec![(0..count).collect(), (count..2 * count).rev().collect()];
    mesh(vertices_deg, (0..count).flat_map(between).collect(), loops)
}

/// Triangles and loops of which only the numbers matter.
pub(crate) fn planar(triangles: &[[u32; 3]], loops: &[&[u32]]) -> RegionMesh {
    let corners = triangles.as_flattened().iter();
    let count = corners.max().map_or(3, |largest| largest + 1);
    let mut mesh = annulus(count);
    mesh.triangles = triangles.to_vec();
    mesh.boundary_loops = loops.iter().map(|ring| ring.to_vec()).collect();
    mesh
}

/// Of the scenes that need no data.
pub(crate) fn real_meshes() -> Vec<RegionMesh> {
    let meshes = |name| {
        let scene = Scene::shipped(name, None).expect("it ships");
        RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh)
            .expect("it meshes")
    };
    let names = ["california", "planet-134"].into_iter();
    names.flat_map(meshes).collect()
}

/// Every technique with every kind of indices that it has.
fn storages() -> Vec<(Extrusion, Indices)> {
    let kinds = |technique: Extrusion| {
        let own = Indices::ALL.into_iter();
        own.filter(move |&indices| technique.indices(indices) == indices)
            .map(move |indices| (technique, indices))
    };
    Extrusion::ALL.into_iter().flat_map(kinds).collect()
}

#[test]
fn what_a_view_before_held_is_not_laid_out_again_and_lies_as_if_it_were() {
    let variant = NativeVariant::default();
    check_held_layouts(
        [5, 40_000, 7, 4].map(annulus).to_vec(),
        |meshes, has_bottom| SceneGeometry::build(&variant, meshes, |_| has_bottom),
        |all, part| all.append(variant.technique, part),
        SceneGeometry::build(&variant, &[annulus(9)], |_| true),
    );
}

#[test]
fn the_formula_and_the_buffers_agree() {
    // Around the limits of 16 bits as well: 2·count vertices, and twice that when doubled.
    for count in [3, 4, 101, 16_383, 16_384, 32_767, 32_768, 32_769] {
        let mesh = annulus(count);
        let layouts = native_layouts(&mesh);
        assert_eq!(layouts.len(), storages().len());
        for (technique, indices) in storages() {
            let meshes = std::slice::from_ref(&mesh);
            let built = built(technique, indices, meshes).bytes();
            let name = (technique.name(), indices);
            let formula = native_bytes(technique, indices, &mesh);
            let key = if technique.default_indices() == indices {
                technique.name().to_owned()
            } else {
                format!("{}/{}", technique.name(), indices.name())
            };
            let mut of_key = layouts.iter().filter(|(name, _)| *name == key);
            let (_, listed) = of_key.next().expect("listed");
            assert_eq!((built, built), (formula, *listed), "{name:?} {count}");
        }
    }
}

#[test]
fn a_restart_is_no_vertex() {
    for count in [16_383, 16_384, 32_767, 32_768] {
        let mesh = annulus(count);
        for technique in [Extrusion::VsControl, Extrusion::GsLine] {
            let meshes = std::slice::from_ref(&mesh);
            let geometry = built(technique, Indices::List, meshes);
            let short = geometry.indices.short.iter().filter(|&&i| i == u16::MAX);
            let long = geometry.indices.long.iter().filter(|&&i| i == u32::MAX);
            let found = short.count() + long.count();
            assert_eq!(found, 2, "{} {count}", technique.name());
        }
    }
}

#[test]
fn a_restart_is_no_vertex_of_a_strip_and_follows_each() {
    for count in [3, 16_383, 16_384, 32_767, 32_768] {
        let mesh = annulus(count);
        let strips = strip_counts(&mesh).strips;
        for (technique, loops) in [(Extrusion::GsDegenerate, 2), (Extrusion::GsAdjacency, 0)] {
            let meshes = std::slice::from_ref(&mesh);
            let geometry = built(technique, Indices::Strip, meshes);
            let short = geometry.indices.short.iter().filter(|&&i| i == u16::MAX);
            let long = geometry.indices.long.iter().filter(|&&i| i == u32::MAX);
            let found = short.count() + long.count();
            assert_eq!(found, strips + loops, "{} {count}", technique.name());
            let is_short = geometry.indices.long.is_empty();
            assert_eq!(is_short, 2 * count <= 0xffff, "{count}");
        }
    }
    // Of 65,535 vertices the last is 0xfffe. Negative control: of one more it is 0xffff, a vertex of a list
    // like any other and no vertex of a strip.
    let is_short = |indices, count| has_short_indices(Extrusion::GsAdjacency, indices, count);
    assert!(is_short(Indices::Strip, 0xffff) && is_short(Indices::List, 0x1_0000));
    assert!(!is_short(Indices::Strip, 0x1_0000));
}

/// Strips between restarts.
fn between_restarts(indices: &[u32]) -> impl Iterator<Item = &[u32]> {
    indices.split(|&index| index == u32::MAX)
}

/// Inputs of a geometry shader by Vulkan's "Triangle Strips"; `odd` are the places of the last two
/// corners in every second one.
fn strip_inputs(indices: &[u32], odd: [usize; 2]) -> Vec<[u32; 3]> {
    let of_strip = |strip: &[u32]| -> Vec<[u32; 3]> {
        let windows = strip.windows(3).enumerate();
        let inputs = windows.map(|(i, window)| {
            let [second, third] = if i % 2 == 0 { [1, 2] } else { odd };
            [window[0], window[second], window[third]]
        });
        inputs.collect()
    };
    between_restarts(indices).flat_map(of_strip).collect()
}

/// The same by "Triangle Strips With Adjacency".
fn adjacent_strip_inputs(indices: &[u32]) -> Vec<[u32; 6]> {
    let of_strip = |strip: &[u32]| -> Vec<[u32; 6]> {
        let count = (strip.len().max(4) - 4) / 2;
        let inputs = (0..count).map(|i| {
            let at = 2 * i;
            let before = if i == 0 { 1 } else { at - 2 };
            let ahead = if i + 1 == count { at + 5 } else { at + 6 };
            let places = if i % 2 == 0 {
                [at, before, at + 2, ahead, at + 4, at + 3]
            } else {
                [at + 2, before, at, at + 3, at + 4, ahead]
            };
            places.map(|place| strip[place])
        });
        inputs.collect()
    };
    between_restarts(indices).flat_map(of_strip).collect()
}

/// Triangles, each from its smallest corner on, and boundary edges, all sorted.
#[derive(Debug, PartialEq)]
struct SortedTopology {
    caps: Vec<[u32; 3]>,
    walls: Vec<[u32; 2]>,
}

impl SortedTopology {
    fn of(caps: impl Iterator<Item = [u32; 3]>, walls: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut caps: Vec<_> = caps.map(smallest_first).collect();
        let mut walls: Vec<_> = walls.collect();
        caps.sort_unstable();
        walls.sort_unstable();
        Self { caps, walls }
    }

    fn of_mesh(mesh: &RegionMesh) -> Self {
        Self::of(mesh.triangles.iter().copied(), mesh.boundary_edges())
    }

    /// As `degenerate.geom` does.
    fn by_degenerate(inputs: &[[u32; 3]]) -> Self {
        let is_wall = |&&[_, b, c]: &&[u32; 3]| b == c;
        let is_cap = |&&[a, b, c]: &&[u32; 3]| b != c && a != b && a != c;
        let walls = inputs.iter().filter(is_wall).map(|&[a, b, _]| [a, b]);
        Self::of(inputs.iter().filter(is_cap).copied(), walls)
    }

    /// As `adjacency.geom` does.
    fn by_adjacency(inputs: &[[u32; 6]]) -> Self {
        let drawn = || {
            inputs
                .iter()
                .filter(|i| i[0] != i[2] && i[2] != i[4] && i[4] != i[0])
        };
        let caps = drawn().map(|input| [input[0], input[2], input[4]]);
        let walls = drawn().flat_map(|input| {
            let sides = [(0, 1, 2, 4), (2, 3, 4, 0), (4, 5, 0, 2)].into_iter();
            let stands = sides.filter(|&(_, across, _, opposite)| input[across] == input[opposite]);
            stands.map(|(from, _, to, _)| [input[from], input[to]])
        });
        Self::of(caps, walls)
    }
}

/// A fan, a zigzag, a hole, branches, and triangles that touch in a corner only.
fn meshes_for_strips() -> Vec<RegionMesh> {
    let fan: Vec<[u32; 3]> = (1..7).map(|i| [0, i, i + 1]).collect();
    let star = [
        [0, 1, 2],
        [0, 2, 3],
        [2, 1, 4],
        [1, 0, 5],
        [4, 1, 6],
        [0, 3, 7],
    ];
    let mut meshes = [3, 4, 5, 10, 11, 64].map(annulus).to_vec();
    meshes.push(planar(&fan, &[&[0, 1, 2, 3, 4, 5, 6, 7]]));
    meshes.push(planar(&star, &[&[0, 5, 1, 6, 4, 2, 3, 7]]));
    meshes.push(planar(&[[0, 1, 2], [2, 3, 4]], &[&[0, 1, 2, 3, 4, 2]]));
    // Without a loop, as at a cut that is no boundary.
    meshes.push(planar(&star, &[]));
    meshes
}

fn strip_indices(technique: Extrusion, mesh: &RegionMesh) -> Vec<u32> {
    let geometry = built(technique, Indices::Strip, std::slice::from_ref(mesh));
    let short = geometry.indices.short.iter();
    short
        .map(|&index| {
            if index == u16::MAX {
                u32::MAX
            } else {
                index.into()
            }
        })
        .collect()
}

#[test]
fn strips_make_what_lists_make() {
    for mesh in meshes_for_strips().into_iter().chain(real_meshes()) {
        let expected = SortedTopology::of_mesh(&mesh);
        let list: Vec<[u32; 6]> = with_neighbours(&mesh)
            .chunks_exact(6)
            .map(|input| input.try_into().expect("six"))
            .collect();
        assert_eq!(
            SortedTopology::by_adjacency(&list),
            expected,
            "{:?}",
            mesh.triangles
        );
        let indices = strip_indices(Extrusion::GsDegenerate, &mesh);
        let made = SortedTopology::by_degenerate(&strip_inputs(&indices, [2, 1]));
        assert_eq!(made, expected, "{indices:?}");
        let indices = strip_indices(Extrusion::GsAdjacency, &mesh);
        let mut inputs = adjacent_strip_inputs(&indices);
        assert_eq!(
            SortedTopology::by_adjacency(&inputs),
            expected,
            "{indices:?}"
        );
        // Whichever corner a driver begins every second one with.
        for input in inputs.iter_mut().skip(1).step_by(2) {
            input.rotate_left(2);
        }
        assert_eq!(
            SortedTopology::by_adjacency(&inputs),
            expected,
            "{indices:?}"
        );
    }
}

#[test]
fn broken_strips_are_noticed() {
    let mesh = annulus(10);
    let expected = SortedTopology::of_mesh(&mesh);
    let indices = strip_indices(Extrusion::GsDegenerate, &mesh);
    let made = |indices: &[u32]| SortedTopology::by_degenerate(&strip_inputs(indices, [2, 1]));
    assert_eq!(made(&indices), expected);
    // Every second triangle turned over.
    assert_ne!(
        SortedTopology::by_degenerate(&strip_inputs(&indices, [1, 2])),
        expected
    );
    // No restart after the caps, and none after the first loop.
    for place in (0..indices.len() - 1).filter(|&place| indices[place] == u32::MAX) {
        let mut joined = indices.clone();
        joined.remove(place);
        assert_ne!(made(&joined), expected, "{place}");
    }
    let indices = strip_indices(Extrusion::GsAdjacency, &mesh);
    let made = |indices: &[u32]| SortedTopology::by_adjacency(&adjacent_strip_inputs(indices));
    assert_eq!(made(&indices), expected);
    // A corner's neighbour in the place of the next one's.
    let mut noticed = 0;
    for place in (1..indices.len() - 2).step_by(2) {
        let mut swapped = indices.clone();
        swapped.swap(place, place + 2);
        noticed += usize::from(made(&swapped) != expected);
    }
    assert!(
        noticed > indices.len() / 4,
        "{noticed} of {}",
        indices.len()
    );
}

/// What `two_edges.geom` makes of an input: triangles, and edges.
fn decode([x, y, z]: [u32; 3]) -> (Option<[u32; 3]>, Vec<[u32; 2]>) {
    if y == z {
        (None, vec![[x, y]])
    } else if x > y || x > z {
        (None, vec![[z, x], [x, y]])
    } else {
        (Some([x, y, z]), Vec::new())
    }
}

#[test]
fn two_edges_in_a_row_are_told_from_triangles_whatever_the_numbers() {
    for count in [3, 4, 5, 10, 11] {
        let mut mesh = annulus(count);
        for turn in 0..count as usize {
            for ring in &mut mesh.boundary_loops {
                ring.rotate_left(turn);
            }
            let inputs: Vec<[u32; 3]> = edges_in_pairs(&mesh).collect();
            let found: Vec<[u32; 2]> = inputs.iter().flat_map(|&i| decode(i).1).collect();
            assert!(inputs.iter().all(|&input| decode(input).0.is_none()));
            let edges: Vec<[u32; 2]> = mesh.boundary_edges().collect();
            assert_eq!(found, edges, "each once, in order");
            // An odd edge of each ring, and one more where the smallest number is in the way.
            assert!(inputs.len() <= count as usize + 4, "{}", inputs.len());
        }
        for &triangle in &mesh.triangles {
            let turned = smallest_first(triangle);
            let (kept, edges) = decode(turned);
            assert_eq!((kept, edges.len()), (Some(turned), 0));
            let sides = |[a, b, c]: [u32; 3]| BTreeSet::from([[a, b], [b, c], [c, a]]);
            assert_eq!(sides(turned), sides(triangle), "winding kept");
        }
    }
    // Negative control: a pair that begins with its smallest number would pass for a triangle.
    assert!(decode([1, 2, 3]).0.is_some());
}

#[test]
fn walls_stand_where_no_neighbour_is_and_nowhere_else() {
    let walls_of = |mesh: &RegionMesh| {
        let indices = with_neighbours(mesh);
        let mut walls = BTreeSet::new();
        for input in indices.chunks_exact(6) {
            for (from, across, to, opposite) in [(0, 1, 2, 4), (2, 3, 4, 0), (4, 5, 0, 2)] {
                if input[across] == input[opposite] {
                    walls.insert([input[from], input[to]]);
                }
            }
        }
        walls
    };
    let mut mesh = annulus(9);
    assert_eq!(walls_of(&mesh), mesh.boundary_edges().collect());
    // A cut that is no boundary, such as the antimeridian's, gets no wall.
    let without = mesh.triangles.remove(0);
    assert_eq!(walls_of(&mesh).len(), 17);
    mesh.triangles.push(without);
    mesh.boundary_loops.pop();
    assert_eq!(walls_of(&mesh).len(), 9);
}

#[test]
fn a_doubled_vertex_is_stored_twice_and_flagged_once() {
    let meshes = [annulus(3)];
    let geometry = built(Extrusion::VsControl, Indices::List, &meshes);
    for pair in geometry.vertices.chunks(8) {
        assert_eq!(pair[..3], pair[4..7]);
        assert_eq!((pair[3], pair[7]), (0, 1));
    }
}
