// SPDX-License-Identifier: MIT OR Apache-2.0
//! The models that get outlines: a port as it is, and around it copies of its models, turned and stretched.

use glam::{DVec2, DVec3};
use terrafill_casters::{Caster, ConvexPart, Mesh, PortSize, port};
use terrafill_results::SplitMix64;
use terrafill_shadow_views::DeckCamera;

/// Seed of what copies are of, where they lie and how they are stretched.
const SEED: u64 = 255;
/// The eye, 300 m up, and how far it looks down, degrees: no horizon is in view.
const EYE_M: DVec3 = DVec3::new(-260.0, -450.0, 300.0);
const AZIMUTH_DEG: f64 = 60.0;
const DOWN_DEG: f64 = 31.0;
const NEAR_M: f64 = 0.5;
/// Values of a stencil of 8 bits, one of which stands for no model.
pub(crate) const VALUES: usize = 255;
/// How far a copy lies alongside another, along either axis, at most.
const ALONGSIDE_M: f64 = 6.0;

/// Models in the order in which they are drawn, and who sees them.
pub(crate) struct Fleet {
    pub(crate) camera: DeckCamera,
    /// One caster a model. Nothing reaches below the sea.
    pub(crate) mesh: Mesh,
}

/// How a copy of a model stands.
struct Stand {
    origin: DVec3,
    ahead: DVec2,
    /// Along, across, and up.
    stretch: DVec3,
}

impl Fleet {
    /// - `count`: of models; those that the largest port with no more of them leaves are copies
    ///
    /// # Errors
    /// That something crosses the near plane, where an edge has no place in the picture.
    pub(crate) fn of(count: usize, size: [u32; 2]) -> Result<Self, String> {
        let camera = DeckCamera::level(EYE_M, AZIMUTH_DEG, NEAR_M, size).turned_down(DOWN_DEG);
        let ports = ["port-m", "port-s"].into_iter().filter_map(PortSize::named);
        let mut ports = ports.map(port);
        let base = ports.find(|port| port.casters.len() <= count);
        let base = base.ok_or_else(|| format!("found {count} models, allowed: those of a port"))?;
        let mut mesh = Mesh::default();
        let place = Stand {
            origin: DVec3::ZERO,
            ahead: DVec2::X,
            stretch: DVec3::ONE,
        };
        for caster in &base.casters {
            push(&mut mesh, &base, caster, &place);
        }
        let mut random = SplitMix64::new(SEED);
        let of = |name: &str| base.casters.iter().find(|caster| caster.name == name);
        let (Some(crane), Some(ship), Some(shed)) = (of("crane"), of("own ship"), of("shed"))
        else {
            return Err("found a port without crane, ship or shed".to_owned());
        };
        let mut origins: Vec<DVec3> = Vec::new();
        while mesh.casters.len() < count {
            let (model, share) = match random.below(12) {
                0 => (crane, 0.3),
                1 => (ship, 0.15),
                _ => (shed, 0.4),
            };
            // Evenly over the picture, on the sea. One in four lies alongside the one that has its value where values come
            // round.
            let [x, y] = [(); 2].map(|()| 2.0 * random.unit() - 1.0);
            let ray = camera.towards(x, y);
            let moored = origins.len().checked_sub(VALUES);
            let moored = moored
                .filter(|_| random.below(4) == 0)
                .map(|at| origins[at]);
            let origin = match moored {
                Some(moored) => moored + DVec3::new(x, y, 0.0) * ALONGSIDE_M,
                None => camera.eye - ray * (camera.eye.z / ray.z),
            };
            origins.push(origin);
            let stretch = [(); 3].map(|()| share * (0.5 + random.unit()));
            let place = Stand {
                origin,
                ahead: DVec2::from_angle(std::f64::consts::TAU * random.unit()),
                stretch: DVec3::from(stretch),
            };
            push(&mut mesh, &base, model, &place);
        }
        let depth = |at: &DVec3| (*at - camera.eye).dot(camera.forward);
        for part in &mesh.parts {
            let depths = mesh.vertices[part.vertices.clone()].iter().map(depth);
            let before = depths.filter(|depth| *depth > NEAR_M).count();
            if before > 0 && before < part.vertices.len() {
                return Err("a model crosses the near plane".to_owned());
            }
        }
        Ok(Self { camera, mesh })
    }

    /// Parts of a model that are before the eye.
    pub(crate) fn parts_before(&self, model: usize) -> impl Iterator<Item = usize> + '_ {
        let parts = self.mesh.casters[model].parts.clone();
        parts.filter(|part| {
            let first = self.mesh.parts[*part].vertices.start;
            let from_eye = self.mesh.vertices[first] - self.camera.eye;
            from_eye.dot(self.camera.forward) > NEAR_M
        })
    }

    /// A range of a model, by that of each of its parts.
    pub(crate) fn of_model(
        &self,
        model: usize,
        of_part: impl Fn(&ConvexPart) -> std::ops::Range<usize>,
    ) -> std::ops::Range<usize> {
        let parts = &self.mesh.parts[self.mesh.casters[model].parts.clone()];
        let [first, last] = [parts.first(), parts.last()].map(|part| part.map(&of_part));
        first.map_or(0, |range| range.start)..last.map_or(0, |range| range.end)
    }
}

/// Adds a copy of a model.
fn push(mesh: &mut Mesh, base: &Mesh, model: &Caster, stand: &Stand) {
    let first_part = mesh.parts.len();
    let parts = &base.parts[model.parts.clone()];
    // A copy is turned and stretched about the middle of the ground that it stands on.
    let middle = if stand.stretch == DVec3::ONE {
        DVec3::ZERO
    } else {
        let places = parts
            .iter()
            .flat_map(|part| &base.vertices[part.vertices.clone()]);
        let count = places.clone().count();
        let low = places.clone().map(|place| place.z).fold(f64::MAX, f64::min);
        let sum: DVec3 = places.sum();
        (sum / count as f64).with_z(low.max(0.0))
    };
    for part in parts {
        let (vertex, triangle) = (mesh.vertices.len(), mesh.triangles.len());
        let places = base.vertices[part.vertices.clone()].iter().map(|place| {
            let local = (*place - middle) * stand.stretch;
            let turned = stand.ahead.rotate(local.truncate());
            // What is under water is not seen.
            (stand.origin + turned.extend(local.z)).max(DVec3::new(f64::MIN, f64::MIN, 0.0))
        });
        mesh.vertices.extend(places);
        let mut plane_before = None;
        for at in part.triangles.clone() {
            let moved = |corner: u32| corner as usize - part.vertices.start + vertex;
            let corners = base.triangles[at].map(moved);
            let [a, b, c] = corners.map(|corner| mesh.vertices[corner]);
            if plane_before != Some(base.planes[at]) {
                plane_before = Some(base.planes[at]);
                mesh.normals.push((b - a).cross(c - a));
            }
            mesh.planes.push(index(mesh.normals.len() - 1));
            mesh.triangles.push(corners.map(index));
        }
        mesh.parts.push(ConvexPart {
            vertices: vertex..mesh.vertices.len(),
            triangles: triangle..mesh.triangles.len(),
        });
    }
    mesh.casters.push(Caster {
        name: model.name.clone(),
        parts: first_part..mesh.parts.len(),
    });
}

/// Of fewer than 2³²: a mesh has `u32` for indices.
pub(crate) fn index(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}
