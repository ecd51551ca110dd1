// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: a model deformed by every way, drawn twice and more often.

use super::super::image::rabbit_mesh;
use super::super::picture::{shaded, size_of};
use super::way::{DeformWay, Deforming};
use crate::STUDY;
use crate::draws::{Draws as _, JudgedFigures as _, count};
use crate::images::{size_px, write};
use crate::metrics::{DRAWINGS, EXPERIMENT, WAY};
use glam::{DVec3, Vec4};
use std::collections::BTreeMap;
use terrafill_contract::ids_of;
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::dents::{Dent, deformed, dents};
use terrafill_shapes::grid::GridCamera;
use terrafill_shapes::mesh::Mesh;
use terrafill_shapes::mesh_rays::MeshRays;
use terrafill_shapes::rays::Judged;
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, Request, Session, judged, planned_case,
    verified,
};

/// Cells a side of the model's geometry image.
const CELLS: u32 = 256;
const QUICK_CELLS: u32 = 64;
/// How often the model is drawn in a frame: twice as published.
const DRAWINGS_OF: [u32; 3] = [2, 4, 8];
const QUICK_DRAWINGS_OF: [u32; 1] = [2];
/// Largest error of a kept vertex: 32-bit floats of a few metres after a dozen sums.
const KEPT_ERROR_M: f64 = 4e-6;

/// A model by every way.
struct Models {
    cases: Vec<(DeformWay, u32)>,
    cells: u32,
    /// Of both views side by side.
    size: ImageSize,
}

pub(crate) fn group(request: &Request, samples: u32) -> impl Group + use<> {
    let (cells, drawings): (_, &[u32]) = if request.depth == Depth::Quick {
        (QUICK_CELLS, &QUICK_DRAWINGS_OF)
    } else {
        (CELLS, &DRAWINGS_OF)
    };
    group_of(cells, drawings, size_of(request), samples)
}

fn group_of(cells: u32, drawings: &[u32], size: ImageSize, samples: u32) -> CaseGroup<Models> {
    let all = drawings
        .iter()
        .flat_map(|&drawings| DeformWay::ALL.map(|way| (way, drawings)));
    let cases: Vec<(DeformWay, u32)> = all.collect();
    // Two squares, of half the width each.
    let size = ImageSize::new(size.width, size.width / 2);
    let case = |(way, drawings): &(DeformWay, u32)| {
        let conditions = vec![
            (EXPERIMENT, "deformed".to_owned()),
            (WAY, way.name().to_owned()),
            (DRAWINGS, drawings.to_string()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/deformed"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: Models { cases, cells, size },
        open: |group, context| {
            let Models { cells, size, .. } = group.work;
            let rest = rabbit_mesh(cells);
            let dents = dents();
            let mesh = bent(&rest, &dents);
            let truths = views().map(|view| MeshRays::new(&mesh, view, size.height).picture());
            Ok(Box::new(ModelSession {
                group,
                context,
                rest,
                dents,
                mesh,
                truths,
                opened: BTreeMap::new(),
            }))
        },
    }
}

/// From either side.
fn views() -> [GridCamera; 2] {
    let view = |y| GridCamera::looking(DVec3::new(2.6, y, 1.4), DVec3::new(-0.05, 0.0, 0.35), 0.3);
    [view(-4.0), view(4.0)]
}

/// A mesh deformed in `f64`.
fn bent(rest: &Mesh, dents: &[Dent]) -> Mesh {
    let vertices = rest.vertices.iter().map(|at| deformed(*at, dents));
    Mesh {
        vertices: vertices.collect(),
        triangles: rest.triangles.clone(),
    }
}

/// One half of a picture of two squares side by side.
fn half(numbers: &[u32], side: u32, is_right: bool) -> Vec<u32> {
    let side = side as usize;
    let rows = numbers.chunks_exact(2 * side);
    let first = if is_right { side } else { 0 };
    let halves = rows.flat_map(|row| row[first..first + side].iter().copied());
    halves.collect()
}

/// Both halves, row by row, as one picture.
fn side_by_side<T: Copy>(halves: &[Vec<T>; 2], side: u32) -> Vec<T> {
    let side = side as usize;
    let [left, right] = halves.each_ref().map(|half| half.chunks_exact(side));
    left.zip(right)
        .flat_map(|(left, right)| left.iter().chain(right).copied())
        .collect()
}

struct ModelSession<'a> {
    group: &'a CaseGroup<Models>,
    context: Context<'a>,
    rest: Mesh,
    dents: Vec<Dent>,
    /// Deformed.
    mesh: Mesh,
    /// Of either view.
    truths: [Vec<u32>; 2],
    /// By case.
    opened: BTreeMap<usize, Deforming>,
}

impl ModelSession<'_> {
    /// What either half shows, and what is wrong with it.
    fn judge(&self, numbers: &[u32]) -> [(Vec<u32>, Judged); 2] {
        let side = self.group.work.size.height;
        let views = views();
        [0, 1].map(|at| {
            let numbers = half(numbers, side, at == 1);
            let judged =
                MeshRays::new(&self.mesh, views[at], side).judge(&numbers, &self.truths[at]);
            (numbers, judged)
        })
    }

    /// Largest distance of kept vertices from where they belong, metres.
    fn kept_error(&self, kept: &[[f32; 4]]) -> f64 {
        let both = kept.iter().zip(&self.mesh.vertices);
        let errors = both.map(|(kept, at)| (Vec4::from(*kept).truncate().as_dvec3() - at).length());
        errors.fold(0.0, f64::max)
    }
}

impl Session for ModelSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let Models {
            ref cases, size, ..
        } = self.group.work;
        let (way, drawings) = cases[case];
        let gpu = terrafill_vulkan::shared_gpu(self.context.devices)?;
        let model = (&self.rest, self.dents.as_slice());
        let mut opened = Deforming::new(&gpu, way, model, views(), drawings, size)?;
        let (picture, counted) = opened.draw()?;
        let halves = self.judge(&ids_of(&picture));
        let kept = opened.kept()?.map(|kept| self.kept_error(&kept));
        let triangles = u64::from(count(&self.mesh.triangles));
        let mut found = Judged::default();
        for (_, judged) in &halves {
            found.mismatched += judged.mismatched;
            found.in_band += judged.in_band;
            found.shown += judged.shown;
        }
        let reason = match kept {
            Some(error) if error > KEPT_ERROR_M => {
                format!("a kept vertex is {error:e} m off, allowed {KEPT_ERROR_M:e}")
            }
            _ => found.reason(&counted, triangles * u64::from(drawings)),
        };
        let vertices = u64::from(count(&self.mesh.vertices));
        let mut figures = found.figures();
        figures.extend(kept.map(|error| ("kept_error_m", error)));
        figures.extend([
            (
                "pipeline_held_bytes",
                way.held_bytes(vertices, triangles) as f64,
            ),
            ("deformed_vertices", way.deformed(vertices, drawings) as f64),
        ]);
        figures.extend(counted.figures());
        self.opened.insert(case, opened);
        let is_shown = way == DeformWay::Streamed && drawings == DRAWINGS_OF[0];
        let notes = if is_shown || !reason.is_empty() {
            let [left, right] = views();
            let colours = [(&halves[0], left), (&halves[1], right)];
            let colours = colours.map(|((numbers, judged), view)| {
                shaded(&self.mesh, view, numbers, &judged.wrong).collect()
            });
            let pixels = side_by_side(&colours, size.height).into_iter();
            let name = &self.group.cases[case].id.name;
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
    fn halves_are_those_of_the_picture() {
        let numbers = [1, 2, 3, 4, 5, 6, 7, 8];
        let halves = [false, true].map(|is_right| half(&numbers, 2, is_right));
        assert_eq!(halves, [vec![1, 2, 5, 6], vec![3, 4, 7, 8]]);
        assert_eq!(side_by_side(&halves, 2), numbers);
        // Negative control: exchanged halves are another picture.
        let [left, right] = halves;
        assert_ne!(side_by_side(&[right, left], 2), numbers);
    }

    #[test]
    fn every_way_deforms_the_model_as_rays_see_it_and_a_lacking_dent_is_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group_of(32, &[2, 3], PICTURE, 1);
        let verdicts = tested.verdicts(&group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            assert!(figure(verdict, "pipeline_shown_px") > 1_000.0, "{name}");
        }
        assert!(verdicts.len() >= 4, "{}", verdicts.len());
        // Negative controls: a model with a dent less, in the picture and in what is kept.
        let gpu = terrafill_vulkan::shared_gpu(&tested.devices).expect("a device");
        let rest = rabbit_mesh(32);
        let dents = dents();
        let mesh = bent(&rest, &dents);
        let truths = views().map(|view| MeshRays::new(&mesh, view, 128).picture());
        let session = ModelSession {
            group: &group,
            context: Context {
                devices: &tested.devices,
                folder: std::path::Path::new(""),
            },
            rest,
            dents,
            mesh,
            truths,
            opened: BTreeMap::new(),
        };
        let judge = |dents: &[Dent]| {
            let model = (&session.rest, dents);
            let size = group.work.size;
            let opened = Deforming::new(&gpu, DeformWay::Computed, model, views(), 2, size);
            let mut opened = opened.expect("opens");
            let (picture, _) = opened.draw().expect("draws");
            let wrong = session
                .judge(&ids_of(&picture))
                .map(|(_, found)| found.mismatched);
            let kept = opened.kept().expect("readable").expect("kept");
            (wrong, session.kept_error(&kept))
        };
        let (wrong, error) = judge(&session.dents);
        assert_eq!(wrong, [0, 0]);
        assert!(error <= KEPT_ERROR_M, "{error}");
        let (wrong, error) = judge(&session.dents[1..]);
        assert!(wrong[0] > 0 && error > 0.01, "{wrong:?} {error}");
    }
}
