// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes that are set up for one question each.

use super::{ChannelTotals, EYES, End, NEARS, Scene, port_m};
use glam::{DVec2, DVec3};
use terrafill_casters::{Mesh, MeshError, Policy, hull, row};
use terrafill_results::SplitMix64;
use terrafill_shadow_views::{DeckCamera, Reference, Rule, deck_eyes, shadowed_share, sun};

/// Boxes along either axis, their size, m, and their seed.
const BOXES: [u32; 2] = [8, 12];
const BOX_M: f64 = 6.0;
const BOXES_SEED: u64 = 38;

impl Scene {
    /// Plates in a row, seen from the side where all of their shadows lie over one another.
    pub(crate) fn of_row(count: u32, size: [u32; 2]) -> Result<Self, String> {
        let eye = DVec3::new(450.0, -250.0, 40.0);
        let view = DeckCamera::level(eye, 90.0, 0.5, size);
        Self::of(row(count), [2.0, 180.0], vec![view])
    }

    /// The eye on deck that stands in the light while most of its near rectangle is in shadow.
    pub(crate) fn of_missed_eye(at: [f64; 2], size: [u32; 2]) -> Result<Self, String> {
        let mesh = port_m()?;
        let to_light = sun(at);
        let reference = Reference::new(&mesh, to_light);
        let near = NEARS[NEARS.len() - 1];
        let eyes = deck_eyes(&mesh, EYES, near).into_iter();
        let lit = eyes.filter(|view| !reference.is_shadowed(view.eye, None));
        let dark = lit.map(|view| (shadowed_share(&view, &reference), view));
        let worst = dark.max_by(|(one, _), (other, _)| one.total_cmp(other));
        let (share, view) = worst.ok_or("no eye in the light")?;
        if share == 0.0 {
            return Err("no eye is missed".to_owned());
        }
        Self::of_port(at, vec![DeckCamera { size, ..view }])
    }

    /// Boxes over the sea, two faces of each of which are edge-on to the sun, or all turned at random.
    pub(crate) fn of_boxes(at: [f64; 2], is_edge_on: bool, size: [u32; 2]) -> Result<Self, String> {
        let to_light = sun(at);
        let mut random = SplitMix64::new(BOXES_SEED);
        let mut share = || random.unit() - 0.5;
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for column in 0..BOXES[0] {
            for row in 0..BOXES[1] {
                let mut direction = || DVec3::new(share(), share(), share());
                let (first, second) = (direction(), direction());
                let normal = if is_edge_on {
                    first.cross(to_light)
                } else {
                    first
                };
                let normal = normal.normalize_or(DVec3::X);
                let along = normal
                    .cross(second)
                    .normalize_or(normal.any_orthonormal_vector());
                let axes = [normal, along, normal.cross(along)].map(|axis| axis * BOX_M / 2.0);
                let [x, y] = [column, row].map(|place| 2.5 * BOX_M * f64::from(place));
                let middle = DVec3::new(x, y, 1.5 * BOX_M);
                let start = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
                vertices.extend((0..8).map(|corner| {
                    let way = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    middle + axes[0] * way(0) + axes[1] * way(1) + axes[2] * way(2)
                }));
                let quads = [
                    [0, 4, 6, 2],
                    [1, 3, 7, 5],
                    [0, 1, 5, 4],
                    [2, 6, 7, 3],
                    [0, 2, 3, 1],
                    [4, 5, 7, 6],
                ];
                for [a, b, c, d] in quads.map(|quad| quad.map(|corner: u32| start + corner)) {
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        let mesh = Mesh::from_triangles("boxes", vertices, triangles);
        let mesh = mesh.map_err(|error| error.to_string())?;
        let eye = DVec3::new(45.0, -120.0, 45.0);
        Self::of(mesh, at, vec![DeckCamera::level(eye, 90.0, 0.5, size)])
    }

    /// A hull whose shadow falls towards the eye, seen from below its deck.
    pub(crate) fn of_hull(size: [u32; 2]) -> Result<Self, String> {
        let eye = DVec3::new(0.0, -150.0, 9.0);
        let view = DeckCamera::level(eye, 90.0, 0.5, size);
        Self::of(hull(1_000), [30.0, 90.0], vec![view])
    }

    /// The same caster with a tenth of its deck missing, by a policy: what it comes to against the whole
    /// one, and its triangles.
    pub(crate) fn drawn_open(&self, policy: Policy) -> Result<(ChannelTotals, usize), MeshError> {
        let mut open = self.prepared.mesh.clone();
        // The deck is the last part of a hull's triangles.
        let is_deck =
            |at: &usize| open.normals[open.planes[*at] as usize].truncate() == DVec2::ZERO;
        let deck: Vec<usize> = (0..open.triangles.len()).filter(is_deck).collect();
        let missing = deck.len() * 45 / 100..deck.len() * 55 / 100;
        for at in deck[missing].iter().rev() {
            open.triangles.remove(*at);
            open.planes.remove(*at);
            open.parts[0].triangles.end -= 1;
        }
        let prepared = policy.prepare(open)?;
        let caster = Self::lit_from(prepared, self.to_light, Vec::new());
        let volume = caster.volume(End::Sea).unwrap_or_default();
        let drawn = self.draw_by(&volume, |view, _| vec![self.whole(view, Rule::Fail)]);
        Ok((drawn, caster.prepared.mesh.triangles.len()))
    }
}
