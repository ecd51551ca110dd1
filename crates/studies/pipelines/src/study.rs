// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: grids by way and size, and amplification by cells a point, strips and source.

use crate::chapter::CHAPTER;
use crate::draws::{Counted, Draws, differing, shown_hash};
use crate::images::{of_numbers, size_of, size_px, write};
use crate::metrics::{self, API, DECLARED, EXPERIMENT, METRICS, SOURCE, STRIP, WAY};
use crate::on_vulkan::OnVulkan;
use crate::on_wgpu::OnWgpu;
use crate::way::{
    AS_EMITTED, DECLARED_VERTICES, GRID_WAYS, Interface, Source, Strips, Submission,
    emitted_by_point,
};
use crate::{STUDY, cache, culling, layered, lights, meshes};
use std::cell::OnceCell;
use std::collections::BTreeMap;
use terrafill_contract::{DeviceError, Devices, ids_of};
use terrafill_results::{ConditionKey, Verdict};
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{Grid, GridCamera};
use terrafill_shapes::rays::{Judged, Rays};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, JudgedOnce, Planned, Request, Shows, Study,
    StudyError, planned_case, verified,
};

/// Cells a side: those published, and few enough to see.
const GRID_CELLS: [u32; 5] = [PICTURED_CELLS, 256, 512, 1_024, 2_048];
const QUICK_GRID_CELLS: [u32; 2] = [64, 256];
/// The size whose pictures are kept.
const PICTURED_CELLS: u32 = 64;
/// Cells a side of amplified grids, those of all published tables; a quick run has the smallest alone.
const AMPLIFIED_CELLS: [u32; 4] = [256, 512, 1_024, 2_048];
const QUICK_AMPLIFIED_CELLS: [u32; 1] = [256];
/// Most cells a side of amplified grids on a device that draws on the CPU, where a run is not of everything: more take
/// minutes of each process.
const SOFTWARE_CELLS: u32 = 1_024;
/// Cells a side of what one point makes.
const CELLS_PER_POINT: [u32; 4] = [1, 2, 4, 8];
/// Timed frames of each case in a process, unless the request says otherwise: few, since a process is one number.
const SAMPLES: u32 = 2;

/// Grids and geometry by every stage of the pipeline.
#[derive(Debug, Clone, Copy)]
pub struct PipelinesStudy;

impl Study for PipelinesStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn needs_device(&self) -> bool {
        false
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let samples = request.samples.unwrap_or(SAMPLES);
        let pictures = (size_of(request), samples);
        let (sizes, amplified): (&[u32], &[u32]) = if is_quick {
            (&QUICK_GRID_CELLS, &QUICK_AMPLIFIED_CELLS)
        } else {
            (&GRID_CELLS, &AMPLIFIED_CELLS)
        };
        let is_full = request.depth == Depth::Full;
        let of_size = |cells: &u32| boxed(grids("grid", *cells, grid_ways(), pictures));
        let amplify = |cells: &u32| {
            let mut group = grids("amplify", *cells, amplified_ways(), pictures);
            group.work.is_for_gpus = *cells > SOFTWARE_CELLS && !is_full;
            boxed(group)
        };
        let mut groups: Vec<Box<dyn Group>> = sizes.iter().map(of_size).collect();
        groups.extend(amplified.iter().map(amplify));
        groups.push(boxed(culling::group(is_quick, pictures)));
        groups.push(boxed(cache::group(is_quick, samples)));
        groups.extend(
            cache::drawn_groups(is_quick, pictures)
                .into_iter()
                .map(boxed),
        );
        groups.extend(lights::groups(is_quick, pictures).into_iter().map(boxed));
        groups.extend(meshes::patches(request, samples).into_iter().map(boxed));
        groups.push(boxed(meshes::image(request, samples)));
        groups.push(boxed(meshes::deformed(request, samples)));
        groups.push(boxed(lights::soft_group(is_quick, pictures)));
        groups.extend(
            lights::cube_groups(is_quick, pictures)
                .into_iter()
                .map(boxed),
        );
        groups.push(boxed(layered::shades(is_quick, samples)));
        groups.extend(layered::blurs(request, samples).into_iter().map(boxed));
        Ok(Planned {
            groups,
            ..Planned::default()
        })
    }
}

fn boxed(group: impl Group + 'static) -> Box<dyn Group> {
    Box::new(group)
}

/// Every way on every interface.
fn grid_ways() -> Vec<(Interface, Submission)> {
    let on = |interface| GRID_WAYS.map(|way| (interface, way));
    Interface::ALL.into_iter().flat_map(on).collect()
}

/// Every form in which a geometry shader makes cells of points.
fn amplified_ways() -> Vec<(Interface, Submission)> {
    let mut ways = Vec::new();
    for cells in CELLS_PER_POINT {
        for strips in [Strips::Cell, Strips::Row] {
            // A row of one cell is a cell.
            if (cells, strips) == (1, Strips::Row) {
                continue;
            }
            let mut add = |source, declared| {
                let way = Submission::Geometry {
                    cells,
                    strips,
                    source,
                    declared,
                };
                ways.push((Interface::Vulkan, way));
            };
            add(Source::Sent, None);
            add(Source::Stored, None);
            if strips == Strips::Cell && emitted_by_point(cells, strips) < DECLARED_VERTICES {
                add(Source::Stored, Some(DECLARED_VERTICES));
            }
        }
    }
    ways
}

/// Conditions of a case, in the order of its name.
fn conditions(
    experiment: &str,
    interface: Interface,
    way: Submission,
    cells: u32,
) -> Vec<(ConditionKey, String)> {
    let mut conditions = vec![
        (EXPERIMENT, experiment.to_owned()),
        (API, interface.name().to_owned()),
        (WAY, way.name().to_owned()),
    ];
    if experiment == "amplify"
        && let Submission::Geometry {
            cells,
            strips,
            source,
            declared,
        } = way
    {
        let strips = match strips {
            Strips::Cell => "cell",
            Strips::Row => "row",
        };
        let source = match source {
            Source::Sent => "sent",
            Source::Stored => "stored",
        };
        conditions.push((metrics::CELLS_PER_POINT, (cells * cells).to_string()));
        conditions.push((STRIP, strips.to_owned()));
        conditions.push((SOURCE, source.to_owned()));
        let declared = declared.map(|vertices| vertices.to_string());
        let declared = declared.unwrap_or_else(|| AS_EMITTED.to_owned());
        conditions.push((DECLARED, declared));
    }
    conditions.push((metrics::GRID_CELLS, cells.to_string()));
    conditions
}

/// Every way of one grid.
struct Grids {
    experiment: &'static str,
    cells: u32,
    size: ImageSize,
    ways: Vec<(Interface, Submission)>,
    /// Whether it is left out on a device that draws on the CPU.
    is_for_gpus: bool,
}

fn grids(
    experiment: &'static str,
    cells: u32,
    ways: Vec<(Interface, Submission)>,
    (size, samples): (ImageSize, u32),
) -> CaseGroup<Grids> {
    let case = |&(interface, way): &(Interface, Submission)| {
        let conditions = conditions(experiment, interface, way, cells);
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/{experiment}/{cells}"),
        cases: ways.iter().map(case).collect(),
        warm_up: None,
        work: Grids {
            experiment,
            cells,
            size,
            ways,
            is_for_gpus: false,
        },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(GridSession {
                group,
                context,
                grid: Grid::new(group.work.cells),
                truth: OnceCell::new(),
                first: BTreeMap::new(),
                opened: BTreeMap::new(),
            })))
        },
    }
}

fn open(
    devices: &Devices,
    interface: Interface,
    way: Submission,
    grid: &Grid,
    size: ImageSize,
) -> Result<Box<dyn Draws>, DeviceError> {
    Ok(match interface {
        Interface::Wgpu => {
            let gpu = terrafill_gpu::shared_gpu(devices)?;
            Box::new(OnWgpu::new(&gpu, way, grid, size)?)
        }
        Interface::Vulkan => {
            let gpu = terrafill_vulkan::shared_gpu(devices)?;
            Box::new(OnVulkan::new(&gpu, way, grid, size)?)
        }
    })
}

/// Of a grid that takes minutes of each process on the CPU.
fn left_out() -> Failure {
    Failure::Unable(format!(
        "a device that draws on the CPU takes minutes for more than {SOFTWARE_CELLS} cells a side, so they are left \
         out at this depth: --full has them"
    ))
}

fn rays(grid: &Grid, size: ImageSize) -> Rays<'_> {
    Rays::new(grid, GridCamera::new(), size)
}

fn judge(way: Submission, rays: &Rays<'_>, numbers: &[u32], truth: &[(usize, u32)]) -> Judged {
    if way.draws_points() {
        rays.judge_points(numbers)
    } else {
        rays.judge_triangles(numbers, truth)
    }
}

struct GridSession<'a> {
    group: &'a CaseGroup<Grids>,
    context: Context<'a>,
    grid: Grid,
    /// Of each pixel, its triangle's number by a ray.
    truth: OnceCell<Vec<(usize, u32)>>,
    /// Of the first way on each interface, by whether it draws points.
    first: BTreeMap<(Interface, bool), Vec<u32>>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn Draws>>,
}

impl Shows for GridSession<'_> {
    type Shown = (Vec<u32>, Counted);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let Grids {
            size,
            ref ways,
            is_for_gpus,
            ..
        } = self.group.work;
        let (interface, way) = ways[case];
        if is_for_gpus
            && terrafill_vulkan::shared_gpu(self.context.devices)?
                .facts
                .is_software()
        {
            return Err(left_out());
        }
        let mut opened = open(self.context.devices, interface, way, &self.grid, size)?;
        let (picture, counted) = opened.draw()?;
        let numbers = ids_of(&picture);
        self.opened.insert(case, opened);
        Ok((shown_hash(&numbers, &counted), (numbers, counted)))
    }

    fn judge(&mut self, case: usize, (numbers, counted): Self::Shown) -> Result<Verdict, Failure> {
        let Grids {
            experiment,
            size,
            ref ways,
            ..
        } = self.group.work;
        let (interface, way) = ways[case];
        let rays = rays(&self.grid, size);
        let truth = self.truth.get_or_init(|| rays.picture(1));
        let judged = judge(way, &rays, &numbers, truth);
        let first = self.first.entry((interface, way.draws_points()));
        let differing = differing(&numbers, first.or_insert_with(|| numbers.clone()));
        // Kept are those of the one size whose cells can be seen, and what is wrong.
        let is_shown = experiment == "grid" && self.grid.cells == PICTURED_CELLS;
        let notes = if is_shown || judged.mismatched > 0 {
            let cells = (!way.draws_points()).then_some(self.grid.cells);
            let pixels = of_numbers(&numbers, cells, &judged.wrong);
            let name = &self.group.cases[case].id.name;
            write(self.context.folder, name, size, pixels)?
        } else {
            Vec::new()
        };
        let expected = way.primitives(&self.grid);
        let counts_fit = counted.primitives.is_none_or(|found| found == expected);
        let reason = match (judged.mismatched, differing) {
            (0, 0) if judged.shown == 0 => "it shows nothing".to_owned(),
            (0, 0) if !counts_fit => {
                let found = counted.primitives.unwrap_or_default();
                format!("{found} primitives reached clipping, expected {expected}")
            }
            (0, 0) => String::new(),
            (0, _) => format!("{differing} pixels differ from the first way's"),
            (mismatched, _) => {
                format!("{mismatched} pixels show what the reference does not allow")
            }
        };
        let mut figures = vec![
            ("pipeline_mismatched_px", judged.mismatched as f64),
            ("pipeline_band_px", judged.in_band as f64),
            ("pipeline_differing_px", differing as f64),
            ("pipeline_shown_px", judged.shown as f64),
            ("pipeline_sent_bytes", way.sent_bytes(&self.grid) as f64),
            ("pipeline_held_bytes", way.held_bytes(&self.grid) as f64),
            (
                "pipeline_emitted_vertices",
                way.emitted_vertices(&self.grid) as f64,
            ),
            ("pipeline_draws", way.draws(&self.grid) as f64),
        ];
        figures.extend(counted.figures());
        Ok(terrafill_study::judged(reason, figures, notes))
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

    fn check(group: &CaseGroup<Grids>, expected: usize) {
        let Some(tested) = Tested::open() else {
            return;
        };
        let verdicts = tested.verdicts(group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            assert!(figure(verdict, "pipeline_shown_px") > 2_500.0, "{name}");
        }
        assert!(verdicts.len() >= expected, "{}", verdicts.len());
    }

    #[test]
    fn every_way_draws_the_same_grid_and_the_reference_agrees() {
        // wgpu has 6 ways, Vulkan 7; each has one more with mesh shaders.
        check(&grids("grid", 64, grid_ways(), (PICTURE, 1)), 13);
    }

    #[test]
    fn every_amplification_draws_the_same_grid() {
        // Eight cells a side are 2,048 components in strips of cells and 1,152 in strips of rows: above the usual
        // limit of 1,024.
        check(&grids("amplify", 64, amplified_ways(), (PICTURE, 1)), 13);
    }

    #[test]
    fn grids_that_take_minutes_on_the_cpu_are_left_out_there_with_the_reason() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let gpu = terrafill_vulkan::shared_gpu(&tested.devices).expect("a device");
        let drawn = |is_for_gpus| {
            let way = amplified_ways()[0];
            let mut group = grids("amplify", 64, vec![way], (PICTURE, 1));
            group.work.is_for_gpus = is_for_gpus;
            tested.verdicts(&group).len()
        };
        assert_eq!(drawn(true), usize::from(!gpu.facts.is_software()));
        // Negative control.
        assert_eq!(drawn(false), 1);
    }

    #[test]
    fn a_changed_height_is_noticed_on_the_device() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let grid = Grid::new(64);
        let truth = rays(&grid, PICTURE).picture(1);
        for interface in Interface::ALL {
            for way in [
                Submission::SentStrips,
                Submission::NoBuffer,
                Submission::SentPoints,
            ] {
                let judge = |drawn: &Grid| {
                    let opened = open(&tested.devices, interface, way, drawn, PICTURE);
                    let (picture, _) = opened.expect("opens").draw().expect("draws");
                    super::judge(way, &rays(&grid, PICTURE), &ids_of(&picture), &truth)
                };
                assert_eq!(judge(&grid).mismatched, 0, "{interface:?} {way:?}");
                let mut changed = grid.clone();
                let vertex = changed.index(20, 20);
                changed.heights[vertex] += 60.0;
                assert!(judge(&changed).mismatched > 0, "{interface:?} {way:?}");
            }
        }
    }
}
