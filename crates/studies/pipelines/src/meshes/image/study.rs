// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: geometry images of each size by each stage, cut and stored otherwise too.

use super::super::picture::{shaded, size_of};
use super::way::ImageWay;
use crate::STUDY;
use crate::draws::{Counted, Draws as _, JudgedFigures as _, shown_hash};
use crate::images::{of_numbers, size_px, write};
use crate::metrics::{CUT, EXPERIMENT, STORED, TEXELS, WAY};
use crate::on_vulkan::OnVulkan;
use std::cell::OnceCell;
use std::collections::BTreeMap;
use terrafill_contract::ids_of;
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::distance::Distances;
use terrafill_shapes::mesh::Mesh;
use terrafill_shapes::mesh_rays::MeshRays;
use terrafill_shapes::rabbit::rabbit_view;
use terrafill_shapes::rays::Judged;
use terrafill_shapes::sphere::Sphere;
use terrafill_shapes::square::{CellCut, Stored, distances, image, open_texels, sphere};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, JudgedOnce, Request, Shows, judged,
    planned_case, verified,
};

/// Cells a side, one less than texels: the published image has 257.
const CELLS: [u32; 4] = [32, 64, 128, 256];
const QUICK_CELLS: [u32; 2] = [32, 256];
/// The size whose pictures are kept, and whose places are stored in few bits.
const PUBLISHED_CELLS: u32 = 256;
const BITS: [u32; 4] = [8, 10, 12, 16];

/// What an image is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    cells: u32,
    cut: CellCut,
    stored: Stored,
}

/// All cases.
struct Images {
    cases: Vec<(ImageWay, Kind)>,
    size: ImageSize,
}

fn cases(sizes: &[u32], bits: &[u32]) -> Vec<(ImageWay, Kind)> {
    let kind = |cells, cut, stored| Kind { cells, cut, stored };
    let drawn = sizes.iter().flat_map(|&cells| {
        let published = kind(cells, CellCut::Published, Stored::Float);
        let folded = kind(cells, CellCut::Fold, Stored::Float);
        let by_all = ImageWay::ALL.map(|way| (way, published));
        by_all
            .into_iter()
            .chain([(ImageWay::NoBuffer, folded), (ImageWay::Indexed, folded)])
    });
    let stored = bits.iter().map(|&bits| {
        let kind = kind(PUBLISHED_CELLS, CellCut::Fold, Stored::Bits(bits));
        (ImageWay::NoBuffer, kind)
    });
    drawn.chain(stored).collect()
}

pub(crate) fn group(request: &Request, samples: u32) -> impl Group + use<> {
    let cases = if request.depth == Depth::Quick {
        cases(&QUICK_CELLS, &[])
    } else {
        cases(&CELLS, &BITS)
    };
    group_of(cases, size_of(request), samples)
}

fn group_of(cases: Vec<(ImageWay, Kind)>, size: ImageSize, samples: u32) -> CaseGroup<Images> {
    let case = |(way, kind): &(ImageWay, Kind)| {
        let conditions = vec![
            (EXPERIMENT, "image".to_owned()),
            (TEXELS, (kind.cells + 1).to_string()),
            (WAY, way.name().to_owned()),
            (CUT, kind.cut.name().to_owned()),
            (STORED, kind.stored.name()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/image"),
        cases: cases.iter().map(case).collect(),
        warm_up: None,
        work: Images { cases, size },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(ImageSession {
                group,
                context,
                sphere: sphere(),
                models: BTreeMap::new(),
                opened: BTreeMap::new(),
            })))
        },
    }
}

/// An image, and what is known of it.
struct Model {
    mesh: Mesh,
    /// Numbers of triangles by rays.
    truth: OnceCell<Vec<u32>>,
    /// From the sphere.
    distances: OnceCell<Distances>,
    open_texels: usize,
}

impl Model {
    fn new(sphere: &Sphere, Kind { cells, cut, stored }: Kind) -> Self {
        let places = image(sphere, cells, stored);
        Self {
            open_texels: open_texels(&places, cells),
            mesh: Mesh::new(places, cells, |column, row| cut.of(cells, column, row)),
            truth: OnceCell::new(),
            distances: OnceCell::new(),
        }
    }

    fn judge(&self, rays: &MeshRays<'_>, numbers: &[u32]) -> Judged {
        rays.judge(numbers, self.truth.get_or_init(|| rays.picture()))
    }
}

struct ImageSession<'a> {
    group: &'a CaseGroup<Images>,
    context: Context<'a>,
    sphere: Sphere,
    models: BTreeMap<Kind, Model>,
    /// By case.
    opened: BTreeMap<usize, OnVulkan>,
}

impl Shows for ImageSession<'_> {
    type Shown = (Vec<u32>, Counted);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let size = self.group.work.size;
        let (way, kind) = self.group.work.cases[case];
        let gpu = terrafill_vulkan::shared_gpu(self.context.devices)?;
        let model = self.models.entry(kind);
        let model = model.or_insert_with(|| Model::new(&self.sphere, kind));
        let mut opened = way.open(&gpu, &model.mesh, (kind.cells, kind.cut), size)?;
        let (picture, counted) = opened.draw()?;
        let numbers = ids_of(&picture);
        self.opened.insert(case, opened);
        Ok((shown_hash(&numbers, &counted), (numbers, counted)))
    }

    fn judge(&mut self, case: usize, (numbers, counted): Self::Shown) -> Result<Verdict, Failure> {
        let size = self.group.work.size;
        let (way, kind) = self.group.work.cases[case];
        let (model, cells) = (&self.models[&kind], kind.cells);
        let rays = MeshRays::new(&model.mesh, rabbit_view(), size.height);
        let is_of_points = way == ImageWay::Points;
        let found = if is_of_points {
            rays.judge_points(&numbers)
        } else {
            model.judge(&rays, &numbers)
        };
        let expected = way.primitives(cells);
        let reason = if self.sphere.turned() > 0 {
            format!("{} triangles lie the wrong way round", self.sphere.turned())
        } else if model.open_texels > 0 {
            format!("{} texels of the sides lie apart", model.open_texels)
        } else {
            found.reason(&counted, expected)
        };
        let mut figures = found.figures();
        let measured = || distances(&model.mesh, cells, &self.sphere);
        figures.extend(model.distances.get_or_init(measured).figures(size.height));
        figures.extend([
            ("pipeline_held_bytes", way.held_bytes(cells) as f64),
            (
                "pipeline_emitted_vertices",
                way.emitted_vertices(cells) as f64,
            ),
        ]);
        figures.extend(counted.figures());
        let is_pictured = matches!(way, ImageWay::Points | ImageWay::Geometry);
        let is_shown = is_pictured && cells == PUBLISHED_CELLS;
        let notes = if is_shown || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            if is_of_points {
                let pixels = of_numbers(&numbers, None, &found.wrong);
                write(self.context.folder, name, size, pixels)?
            } else {
                let pixels = shaded(&model.mesh, rabbit_view(), &numbers, &found.wrong);
                write(self.context.folder, name, size, pixels)?
            }
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
    use glam::DVec3;
    use terrafill_results::Status;

    #[test]
    fn every_stage_draws_the_image_as_rays_see_it_and_a_moved_texel_is_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group_of(cases(&[64], &[]), PICTURE, 1);
        let verdicts = tested.verdicts(&group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            assert!(figure(verdict, "pipeline_shown_px") > 1_000.0, "{name}");
        }
        assert!(verdicts.len() >= 5, "{}", verdicts.len());
        // Negative control: a texel that was moved.
        let gpu = terrafill_vulkan::shared_gpu(&tested.devices).expect("a device");
        let kind = Kind {
            cells: 64,
            cut: CellCut::Published,
            stored: Stored::Float,
        };
        let model = Model::new(&sphere(), kind);
        let rays = MeshRays::new(&model.mesh, rabbit_view(), PICTURE.height);
        let judge = |mesh: &Mesh| {
            let opened = ImageWay::Geometry.open(&gpu, mesh, (64, CellCut::Published), PICTURE);
            let (picture, _) = opened.expect("opens").draw().expect("draws");
            model.judge(&rays, &ids_of(&picture)).mismatched
        };
        assert_eq!(judge(&model.mesh), 0);
        // One that the picture shows.
        let truth = model.truth.get().expect("judged");
        let shown = truth.iter().find(|number| **number > 0).expect("one");
        let corner = model.mesh.triangles[*shown as usize - 1][0];
        let mut moved = model.mesh.clone();
        moved.vertices[corner as usize] += DVec3::Z * 0.2;
        assert!(judge(&moved) > 0);
    }
}
