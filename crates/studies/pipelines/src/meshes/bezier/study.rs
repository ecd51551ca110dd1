// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: patches divided at each level by each stage.

use super::super::picture::{shaded, size_of};
use super::division::Division;
use crate::STUDY;
use crate::draws::{Draws as _, JudgedFigures as _, count};
use crate::images::{size_px, write};
use crate::metrics::{EXPERIMENT, LEVEL, WAY};
use crate::on_vulkan::OnVulkan;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use terrafill_contract::ids_of;
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::distance::{Distances, PLACES};
use terrafill_shapes::mesh::{Cut, Mesh};
use terrafill_shapes::mesh_rays::{MeshRays, judge_cells};
use terrafill_shapes::patch::Patch;
use terrafill_shapes::pot::{pot, pot_view};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, Request, Session, judged, planned_case,
    verified,
};

/// How often a side of a patch is divided.
const LEVELS: [u32; 9] = [2, 3, 4, 5, 6, 7, 8, 9, 10];
const QUICK_LEVELS: [u32; 2] = [2, 8];
/// Levels whose pictures are kept.
const PICTURED: [u32; 2] = [2, 8];

pub(crate) fn groups(request: &Request, samples: u32) -> Vec<impl Group + use<>> {
    let levels: &[u32] = if request.depth == Depth::Quick {
        &QUICK_LEVELS
    } else {
        &LEVELS
    };
    let size = size_of(request);
    let of = |level: &u32| group(*level, size, samples);
    levels.iter().map(of).collect()
}

/// The pot at a level, by every way.
struct Divided {
    level: u32,
    size: ImageSize,
}

fn group(level: u32, size: ImageSize, samples: u32) -> CaseGroup<Divided> {
    let case = |way: Division| {
        let conditions = vec![
            (EXPERIMENT, "patches".to_owned()),
            (WAY, way.name().to_owned()),
            (LEVEL, level.to_string()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/patches/{level}"),
        cases: Division::ALL.map(case).into(),
        warm_up: None,
        work: Divided { level, size },
        open: |group, context| {
            let patches = pot();
            let level = group.work.level;
            let meshes = [Cut::Published, Cut::Other].map(|cut| divided(&patches, level, cut));
            let view = pot_view();
            let side = group.work.size.height;
            let truths = meshes
                .each_ref()
                .map(|mesh| MeshRays::new(mesh, view, side).picture());
            Ok(Box::new(PatchSession {
                distances: [
                    distances(&patches, level, &meshes[..1]),
                    distances(&patches, level, &meshes),
                ],
                group,
                context,
                patches,
                meshes,
                truths,
                opened: BTreeMap::new(),
            }))
        },
    }
}

/// Triangles of the pot divided so often.
pub(crate) fn pot_mesh(level: u32) -> Mesh {
    divided(&pot(), level, Cut::Published)
}

/// Triangles of patches divided so often, of places exactly on them.
fn divided(patches: &[Patch], level: u32, cut: Cut) -> Mesh {
    let places = |patch: &Patch| {
        let all = (0..=level).flat_map(|row| (0..=level).map(move |column| (column, row)));
        let at = |(column, row)| DVec2::new(f64::from(column), f64::from(row)) / f64::from(level);
        all.map(|vertex| patch.place(at(vertex)))
            .collect::<Vec<_>>()
    };
    let vertices = patches.iter().flat_map(places).collect();
    Mesh::new(vertices, level, move |_, _| cut)
}

/// Of the triangles from the patches.
fn distances(patches: &[Patch], level: u32, meshes: &[Mesh]) -> Distances {
    let view = pot_view();
    let mut distances = Distances::default();
    let of_patch = 2 * (level * level) as usize;
    let vertices_a_side = level + 1;
    let all = meshes
        .iter()
        .flat_map(|mesh| (0..mesh.triangles.len()).map(move |at| (mesh, at)));
    for (mesh, index) in all {
        let corners = mesh.triangles[index];
        let patch = &patches[index / of_patch];
        let at = corners.map(|corner| {
            let vertex = corner % (vertices_a_side * vertices_a_side);
            let [column, row] = [vertex % vertices_a_side, vertex / vertices_a_side];
            DVec2::new(f64::from(column), f64::from(row)) / f64::from(level)
        });
        let places = mesh.corners(index);
        for weights in PLACES {
            let place: DVec3 = places.iter().zip(weights).map(|(p, w)| *p * w).sum();
            let at: DVec2 = at.iter().zip(weights).map(|(p, w)| *p * w).sum();
            distances.add(place, patch.distance(place, at), &view);
        }
    }
    distances
}

struct PatchSession<'a> {
    group: &'a CaseGroup<Divided>,
    context: Context<'a>,
    patches: Vec<Patch>,
    /// Cut as published, and the other way.
    meshes: [Mesh; 2],
    truths: [Vec<u32>; 2],
    /// Of the first cut, and of both.
    distances: [Distances; 2],
    /// By case.
    opened: BTreeMap<usize, OnVulkan>,
}

impl Session for PatchSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let Divided { level, size } = self.group.work;
        let gpu = terrafill_vulkan::shared_gpu(self.context.devices)?;
        let way = Division::ALL[case];
        let mut opened = way.open(&gpu, &self.patches, level, size)?;
        let (picture, counted) = opened.draw()?;
        let numbers = ids_of(&picture);
        let [first, second] = self
            .meshes
            .each_ref()
            .map(|mesh| MeshRays::new(mesh, pot_view(), size.height));
        let found = if way.shows_cells() {
            let truths = self.truths.each_ref().map(Vec::as_slice);
            judge_cells([&first, &second], &numbers, truths)
        } else {
            first.judge(&numbers, &self.truths[0])
        };
        let patches = count(&self.patches);
        let expected = self.meshes[0].triangles.len() as u64;
        let reason = found.reason(&counted, expected);
        let mut figures = found.figures();
        // Which cut tessellation stages make is not known.
        let distances = &self.distances[usize::from(way.shows_cells())];
        figures.extend(distances.figures(size.height));
        figures.extend([
            ("pipeline_held_bytes", way.held_bytes(patches, level) as f64),
            (
                "pipeline_emitted_vertices",
                way.emitted_vertices(patches, level) as f64,
            ),
        ]);
        figures.extend(counted.figures());
        self.opened.insert(case, opened);
        let is_shown = way == Division::Row && PICTURED.contains(&level);
        let notes = if is_shown || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            let pixels = shaded(&self.meshes[0], pot_view(), &numbers, &found.wrong);
            write(self.context.folder, name, size, pixels)?
        } else {
            Vec::new()
        };
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(verified(&mut self.opened, case)?.time()?.figures())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::PICTURE;
    use crate::tested::{Tested, figure};
    use terrafill_results::Status;

    #[test]
    fn every_stage_divides_the_pot_as_rays_see_it_and_a_moved_point_is_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        for (level, expected) in [(3, 4), (10, 3)] {
            let group = group(level, PICTURE, 1);
            let verdicts = tested.verdicts(&group);
            for (at, verdict) in &verdicts {
                let name = &group.cases[*at].id.name;
                assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
                assert!(figure(verdict, "pipeline_shown_px") > 15_000.0, "{name}");
                let is_patch = Division::ALL[*at] == Division::Patch;
                assert!(!is_patch || level == 3, "10 cells do not fit");
            }
            assert!(verdicts.len() >= expected, "{}", verdicts.len());
        }
        // Negative control: what shows a pot with a moved control point is not this pot.
        let gpu = terrafill_vulkan::shared_gpu(&tested.devices).expect("a device");
        let patches = pot();
        let mesh = divided(&patches, 4, Cut::Published);
        let rays = MeshRays::new(&mesh, pot_view(), PICTURE.height);
        let truth = rays.picture();
        let judge = |drawn: &[Patch]| {
            let opened = Division::Row.open(&gpu, drawn, 4, PICTURE);
            let (picture, _) = opened.expect("opens").draw().expect("draws");
            rays.judge(&ids_of(&picture), &truth).mismatched
        };
        assert_eq!(judge(&patches), 0);
        let mut moved = patches.clone();
        moved[7].0[1][2] *= 1.02;
        assert!(judge(&moved) > 0);
    }

    #[test]
    fn triangles_come_nearer_by_the_square_of_the_level() {
        let patches = pot();
        let error = |level| {
            let mesh = divided(&patches, level, Cut::Published);
            distances(&patches, level, &[mesh]).figures(1)[0].1
        };
        let [coarse, fine] = [10, 20].map(error);
        assert!((3.5..4.5).contains(&(coarse / fine)), "{coarse} {fine}");
        // Negative control: another shape is not as near.
        let mut moved = patches.clone();
        moved[7].0[1][2] *= 1.2;
        let mesh = divided(&moved, 10, Cut::Published);
        let wrong = distances(&patches, 10, &[mesh]).figures(1)[0].1;
        assert!(wrong > 2.0 * coarse, "{wrong} {coarse}");
    }
}
