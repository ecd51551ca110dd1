// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which rule a frame or a part needs: the published test of the eye, and tests of the near rectangle.
//!
//! z-pass is right for a caster exactly where the near rectangle is outside its volume: where the caster
//! is disjoint from the prism that the rectangle sweeps towards the sun.

use crate::reference::{CONTACT_M, Reference};
use crate::scissor::cut;
use crate::view::{DeckCamera, box_of};
use glam::DVec3;
use std::ops::Range;
use terrafill_casters::{Facing, Mesh};
use terrafill_study::Failure;

/// The prism is this much wider than the rectangle, m: its planes are rounded by 10⁻¹² of coordinates of
/// kilometres.
const MARGIN_M: f64 = 1e-6;
/// Samples of the near rectangle along each axis, its corners included.
const SAMPLES: u32 = 17;

terrafill_results::named! {
    /// How the rule is chosen.
    all pub enum EyeTest {
        /// As published: the segment from the eye to the sun, for the frame.
        Eye = "eye",
        /// Box of each model.
        ModelBox = "near-box-model",
        /// Box of each convex part.
        PartBox = "near-box-part",
        /// Lit triangles of each convex part.
        Exact = "near-exact",
        /// The published segment, for each model that it crosses.
        EyeModel = "eye-model",
    }
}

/// Boxes of parts and models.
pub struct Boxes {
    parts: Vec<[DVec3; 2]>,
    models: Vec<([DVec3; 2], Range<usize>)>,
}

impl Boxes {
    /// Of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let parts = mesh.parts.iter();
        let parts: Vec<[DVec3; 2]> = parts
            .map(|part| box_of(&mesh.vertices[part.vertices.clone()]))
            .collect();
        let models = mesh.casters.iter().map(|model| {
            let corners = parts[model.parts.clone()].iter().flatten();
            (box_of(corners), model.parts.clone())
        });
        Self {
            models: models.collect(),
            parts,
        }
    }
}

/// The near rectangle swept towards the sun.
pub(crate) struct Prism {
    /// Points are inside where `normal · place ≥ offset` for all.
    planes: Vec<(DVec3, f64)>,
    low: DVec3,
    high: DVec3,
}

impl Prism {
    pub(crate) fn of(view: &DeckCamera, to_light: DVec3) -> Self {
        let corners = view.near_corners();
        let middle = view.eye + view.forward * view.near;
        let slope = view.forward.dot(to_light);
        let base = view.forward * slope.signum();
        let mut planes = vec![(base, base.dot(middle) - MARGIN_M)];
        for at in 0..4 {
            let normal = (corners[(at + 1) % 4] - corners[at])
                .cross(to_light)
                .normalize_or_zero();
            let inward = normal * normal.dot(middle - corners[at]).signum();
            planes.push((inward, inward.dot(corners[at]) - MARGIN_M));
        }
        let [low, high] = box_of(&corners);
        let endless = |way: f64| if way > 0.0 { f64::INFINITY } else { 0.0 };
        let up = DVec3::from(to_light.to_array().map(endless));
        let down = DVec3::from(to_light.to_array().map(|way| endless(-way)));
        Self {
            planes,
            low: low - down - MARGIN_M,
            high: high + up + MARGIN_M,
        }
    }

    /// Whether it may meet a box: no plane and no axis tells them apart.
    fn may_meet(&self, [low, high]: [DVec3; 2]) -> bool {
        let farthest = |(normal, offset): &(DVec3, f64)| {
            let corner = DVec3::select(normal.cmpge(DVec3::ZERO), high, low);
            normal.dot(corner) >= *offset
        };
        low.cmple(self.high).all() && self.low.cmple(high).all() && self.planes.iter().all(farthest)
    }

    /// Whether it meets a triangle.
    fn meets(&self, corners: [DVec3; 3]) -> bool {
        let mut ring = corners.to_vec();
        for (normal, offset) in &self.planes {
            ring = cut(&ring, |place| normal.dot(place) - offset);
        }
        !ring.is_empty()
    }
}

/// What a test chooses for a view: of each part, whether it is drawn by z-fail.
pub fn chosen(
    test: EyeTest,
    view: &DeckCamera,
    to_light: DVec3,
    mesh: &Mesh,
    facing: &Facing,
    boxes: &Boxes,
    reference: &Reference<'_>,
) -> Vec<bool> {
    let count = mesh.parts.len();
    let prism = Prism::of(view, to_light);
    match test {
        EyeTest::Eye => vec![reference.is_shadowed(view.eye, None); count],
        EyeTest::EyeModel => {
            let mut chosen = vec![false; count];
            reference.walk(view.eye, to_light, |triangle, distance| {
                let mut met = mesh.parts.iter();
                let met = met.position(|part| part.triangles.contains(&(triangle as usize)));
                let mut models = boxes.models.iter();
                let model = met.and_then(|met| models.find(|(_, parts)| parts.contains(&met)));
                if let Some((_, parts)) = model.filter(|_| distance > CONTACT_M) {
                    chosen[parts.clone()].fill(true);
                }
                f64::INFINITY
            });
            chosen
        }
        EyeTest::ModelBox => {
            let mut chosen = vec![false; count];
            for (extent, parts) in &boxes.models {
                chosen[parts.clone()].fill(prism.may_meet(*extent));
            }
            chosen
        }
        EyeTest::PartBox => boxes
            .parts
            .iter()
            .map(|extent| prism.may_meet(*extent))
            .collect(),
        EyeTest::Exact => {
            let parts = mesh.parts.iter().zip(&boxes.parts);
            let meets = parts.map(|(part, extent)| {
                let mut lit = part.triangles.clone().filter(|at| facing.is_lit[*at]);
                prism.may_meet(*extent) && lit.any(|at| prism.meets(mesh.corners(at)))
            });
            meets.collect()
        }
    }
}

/// Deeper than the near plane by this share, m a metre: rounding must not clip what is drawn there.
const NEAR_SHARE: f64 = 1e-4;
/// Least slope of the view against the sun at which places are moved along it to the near plane. Below, an
/// error of 10⁻⁷ of a place becomes a pixel and more.
const MIN_SLOPE: f64 = 1e-3;

/// Lit triangles between the near plane and the sun, moved along the light into the near plane.
///
/// There they face the eye. z-pass counts them, and thereby the volumes that the near plane is in (Hornus et al., 2005).
pub fn near_caps(
    view: &DeckCamera,
    to_light: DVec3,
    mesh: &Mesh,
    facing: &Facing,
) -> Result<Vec<[DVec3; 3]>, Failure> {
    let slope = view.forward.dot(to_light);
    if slope.abs() < MIN_SLOPE {
        return Err(Failure::Unable(format!(
            "zp-plus: found {slope} between view and sun, a cosine, allowed: {MIN_SLOPE} and more, either way"
        )));
    }
    let near = view.near * (1.0 + NEAR_SHARE);
    let deep = |place: DVec3| view.forward.dot(place - view.eye) - near;
    let mut caps = Vec::new();
    for triangle in (0..mesh.triangles.len()).filter(|at| facing.is_lit[*at]) {
        let ring = cut(&mesh.corners(triangle), |place| {
            slope.signum() * deep(place)
        });
        let moved = ring
            .iter()
            .map(|place| *place - to_light * (deep(*place) / slope));
        let moved: Vec<DVec3> = moved.collect();
        for at in 1..moved.len().saturating_sub(1) {
            let [a, b, c] = [moved[0], moved[at], moved[at + 1]];
            let faces_eye = (b - a).cross(c - a).dot(view.forward) < 0.0;
            caps.push(if faces_eye { [a, b, c] } else { [a, c, b] });
        }
    }
    Ok(caps)
}

/// Parts that hold a sample of the near rectangle in their shadow, and the share of samples in any.
///
/// By rays from the samples to each part's triangles, not by the prism.
pub fn shadowed_share(view: &DeckCamera, reference: &Reference<'_>) -> f64 {
    let share = |at: u32| 2.0 * f64::from(at) / f64::from(SAMPLES - 1) - 1.0;
    let all = (0..SAMPLES).flat_map(|row| (0..SAMPLES).map(move |column| (column, row)));
    let places =
        all.map(|(column, row)| view.eye + view.towards(share(column), share(row)) * view.near);
    let dark = places
        .filter(|place| reference.is_shadowed(*place, None))
        .count();
    dark as f64 / f64::from(SAMPLES * SAMPLES)
}

/// Whether a corner or the middle of the near rectangle is in shadow: what five samples find.
pub fn is_shadowed_at_corners(view: &DeckCamera, reference: &Reference<'_>) -> bool {
    let middle = view.eye + view.forward * view.near;
    let mut places = view.near_corners().into_iter().chain([middle]);
    places.any(|place| reference.is_shadowed(place, None))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{deck_eyes, sun};
    use terrafill_casters::{PortSize, port};

    #[test]
    fn a_test_of_the_rectangle_never_misses_and_the_test_of_the_eye_does() {
        let mesh = port(PortSize::NAMED[1].1);
        let to_light = sun([5.0, 0.0]);
        let facing = Facing::of(&mesh, to_light);
        let (boxes, reference) = (Boxes::of(&mesh), Reference::new(&mesh, to_light));
        let mut missed = [0; EyeTest::ALL.len()];
        let mut slower = [0; EyeTest::ALL.len()];
        for mut view in deck_eyes(&mesh, 300, 1.0) {
            // The small port's dock is 60 m long.
            view.eye.x = view.eye.x / 5.0 - 120.0;
            let is_dark = shadowed_share(&view, &reference) > 0.0;
            let at_corners = is_shadowed_at_corners(&view, &reference);
            assert!(is_dark || !at_corners, "a sample");
            for (at, test) in EyeTest::ALL.into_iter().enumerate() {
                let choice = chosen(test, &view, to_light, &mesh, &facing, &boxes, &reference);
                let any = choice.contains(&true);
                missed[at] += usize::from(is_dark && !any);
                slower[at] += usize::from(any && !is_dark);
            }
        }
        assert_eq!(missed[1..4], [0, 0, 0]);
        // Some model is drawn by z-fail exactly where all are.
        assert!(missed[0] > 0 && missed[4] == missed[0], "{missed:?}");
        assert!(
            slower[1] >= slower[2] && slower[2] >= slower[3],
            "{slower:?}"
        );
        assert!(slower[1] > slower[3], "{slower:?}");
    }
}
