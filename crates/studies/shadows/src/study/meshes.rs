// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes whose silhouettes are found.

use crate::brought::Brought;
use crate::job::Method;
use terrafill_casters::{
    EdgeTable, Facing, Mesh, Policy, PortSize, Prepared, Side, by_hash, by_stack, hull, port,
};
use terrafill_shadow_views::sun;

/// Sun of silhouettes: every mesh has faces to and from it.
pub(super) const SILHOUETTE_SUN: [f64; 2] = [30.0, -60.0];

/// A mesh ready for silhouettes.
pub(super) struct Ready {
    pub(super) name: &'static str,
    pub(super) prepared: Prepared,
    pub(super) facing: Facing,
    pub(super) table: EdgeTable,
}

pub(super) fn ready(name: &'static str, brought: Option<&Brought>) -> Result<Ready, String> {
    if let Some(own) = brought {
        return Ok(Ready::of(name, own.prepared.clone()));
    }
    let mut mesh = mesh_named(name)?;
    let policy = if name.contains("turned") {
        turn_a_lit_face(&mut mesh);
        Policy::AsIs
    } else {
        Policy::Refuse
    };
    let prepared = policy.prepare(mesh).map_err(|error| error.to_string())?;
    Ok(Ready::of(name, prepared))
}

fn mesh_named(name: &str) -> Result<Mesh, String> {
    let plain = name.split(',').next().unwrap_or(name);
    let found = match plain.strip_prefix("hull-") {
        Some(triangles) => triangles.parse().ok().map(hull),
        None => PortSize::named(plain).map(port),
    };
    found.ok_or_else(|| format!("{name}: no mesh"))
}

/// Turns the first triangle that faces away from the sun and has a lit neighbour, so that it faces the
/// sun and two lit triangles have an edge the same way round.
fn turn_a_lit_face(mesh: &mut Mesh) {
    let to_light = sun(SILHOUETTE_SUN);
    let facing = Facing::of(mesh, to_light);
    let is_lit = |at: usize| facing.is_lit[at];
    let has_lit_neighbour = |at: usize| {
        let own = mesh.triangles[at];
        let shared = |other: &[u32; 3]| other.iter().filter(|corner| own.contains(corner)).count();
        let mut all = mesh.triangles.iter().enumerate();
        all.any(|(other, corners)| is_lit(other) && shared(corners) == 2)
    };
    let found = (0..mesh.triangles.len()).find(|at| !is_lit(*at) && has_lit_neighbour(*at));
    if let Some(at) = found {
        mesh.triangles[at].swap(1, 2);
        let plane = u32::try_from(mesh.normals.len()).unwrap_or(0);
        let turned = -mesh.normals[mesh.planes[at] as usize];
        mesh.normals.push(turned);
        mesh.planes[at] = plane;
    }
}

impl Ready {
    fn of(name: &'static str, prepared: Prepared) -> Self {
        Self {
            name,
            facing: Facing::of(&prepared.mesh, sun(SILHOUETTE_SUN)),
            table: EdgeTable::of(&prepared.mesh),
            prepared,
        }
    }

    pub(super) fn sides(&self, method: Method) -> Vec<Side> {
        match method {
            Method::Stack => by_stack(&self.prepared.mesh, &self.facing),
            Method::Hash => by_hash(&self.prepared.mesh, &self.facing),
            Method::Adjacency => self.table.sides(&self.prepared, &self.facing),
        }
    }
}
