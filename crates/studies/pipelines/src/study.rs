// SPDX-License-Identifier: MIT OR Apache-2.0
//! The cases: grids by way and size, and amplification by cells a point, strips and source.

use crate::cache::Caches;
use crate::chapter::PipelinesChapter;
use crate::culling::Culling;
use crate::draws::{Counted, Draws, verdict_of};
use crate::grid::{Grid, View};
use crate::images::{size_of, size_px, write};
use crate::keys;
use crate::keys::{API, EXPERIMENT, SOURCE, STRIP, WAY};
use crate::layered::{Blurs, Shades};
use crate::lights::Lights;
use crate::metrics::METRICS;
use crate::open::open;
use crate::rays::{Cut, Judged, Rays};
use crate::way::{GRID_WAYS, Interface, Source, Strips, Way};
use crate::{STUDY, way};
use std::collections::BTreeMap;
use terrafill_fill::ids_of;
use terrafill_results::{CaseId, Chapter, ConditionKey, Metric, PlannedCase, Status, Verdict};
use terrafill_scene::ImageSize;
use terrafill_study::{Context, Depth, Group, Planned, Request, Session, Study, StudyError};

/// Cells a side; a quick run draws the first two.
const GRID_CELLS: [u32; 6] = [64, 256, 512, 1_024, 2_048, 128];
const QUICK_GRIDS: usize = 2;
/// The size whose pictures are kept.
const PICTURED_CELLS: u32 = 64;
/// Cells a side of amplified grids, those published; a quick run has a smaller one instead.
const AMPLIFIED_CELLS: [u32; 2] = [512, 1_024];
const QUICK_AMPLIFIED_CELLS: [u32; 1] = [256];
/// Cells a side of what one point makes.
const CELLS_PER_POINT: [u32; 4] = [1, 2, 4, 8];
/// Timed frames of each case in a process, unless the request says otherwise: few, since a process is one number.
const SAMPLES: u32 = 2;

/// Grids and geometry by every stage of the pipeline.
#[derive(Debug, Clone, Copy)]
pub struct PipelinesStudy;

impl Study for PipelinesStudy {
    fn name(&self) -> &'static str {
        STUDY
    }

    fn question(&self) -> &'static str {
        "Which stage of the pipeline should make a grid's vertices, at which cost and error?"
    }

    fn metrics(&self) -> &'static [Metric] {
        &METRICS
    }

    fn conditions(&self) -> Vec<ConditionKey> {
        crate::keys::CONDITIONS.to_vec()
    }

    fn least_depth(&self) -> Depth {
        Depth::Full
    }

    fn needs_device(&self) -> bool {
        false
    }

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let is_quick = request.depth == Depth::Quick;
        let samples = request.samples.unwrap_or(SAMPLES);
        let size = size_of(request);
        let mut groups: Vec<Box<dyn Group>> = Vec::new();
        let mut sizes = GRID_CELLS[..if is_quick {
            QUICK_GRIDS
        } else {
            GRID_CELLS.len()
        }]
            .to_vec();
        sizes.sort_unstable();
        for cells in sizes {
            groups.push(Box::new(Grids::new(
                "grid",
                cells,
                grid_ways(),
                (size, samples),
            )));
        }
        let amplified: &[u32] = match is_quick {
            true => &QUICK_AMPLIFIED_CELLS,
            false => &AMPLIFIED_CELLS,
        };
        for &cells in amplified {
            groups.push(Box::new(Grids::new(
                "amplify",
                cells,
                amplified_ways(),
                (size, samples),
            )));
        }
        for culling in Culling::all(is_quick, (size, samples)) {
            groups.push(Box::new(culling));
        }
        groups.push(Box::new(Caches::new(is_quick, samples)));
        for lights in Lights::all(is_quick, (size, samples)) {
            groups.push(Box::new(lights));
        }
        groups.push(Box::new(Shades::new(is_quick, samples)));
        groups.push(Box::new(Blurs::new(is_quick, samples)));
        Ok(Planned {
            groups,
            skipped: Vec::new(),
        })
    }

    fn chapter(&self) -> &dyn Chapter {
        &PipelinesChapter
    }
}

/// Every way on every interface.
fn grid_ways() -> Vec<(Interface, Way)> {
    let on = |interface| GRID_WAYS.map(|way| (interface, way));
    Interface::ALL.into_iter().flat_map(on).collect()
}

/// Every form in which a geometry shader makes cells of points.
fn amplified_ways() -> Vec<(Interface, Way)> {
    let mut ways = Vec::new();
    for cells in CELLS_PER_POINT {
        for strips in [Strips::Cell, Strips::Row] {
            // A row of one cell is a cell.
            if (cells, strips) == (1, Strips::Row) {
                continue;
            }
            for source in [Source::Sent, Source::Stored] {
                let way = Way::Geometry {
                    cells,
                    strips,
                    source,
                };
                ways.push((Interface::Vulkan, way));
            }
        }
    }
    ways
}

/// Conditions of a case, in the order of its name.
fn conditions(
    experiment: &str,
    interface: Interface,
    way: Way,
    cells: u32,
) -> Vec<(ConditionKey, String)> {
    let mut conditions = vec![
        (EXPERIMENT, experiment.to_owned()),
        (API, interface.name().to_owned()),
        (WAY, way.name()),
    ];
    if let (
        "amplify",
        Way::Geometry {
            cells,
            strips,
            source,
        },
    ) = (experiment, way)
    {
        let strips = match strips {
            Strips::Cell => "cell",
            Strips::Row => "row",
        };
        let source = match source {
            Source::Sent => "sent",
            Source::Stored => "stored",
        };
        conditions.push((keys::CELLS_PER_POINT, (cells * cells).to_string()));
        conditions.push((STRIP, strips.to_owned()));
        conditions.push((SOURCE, source.to_owned()));
    }
    conditions.push((keys::GRID_CELLS, cells.to_string()));
    conditions
}

/// Every way of one grid.
struct Grids {
    experiment: &'static str,
    cells: u32,
    size: ImageSize,
    cases: Vec<PlannedCase>,
    ways: Vec<(Interface, Way)>,
}

impl Grids {
    fn new(
        experiment: &'static str,
        cells: u32,
        ways: Vec<(Interface, Way)>,
        (size, samples): (ImageSize, u32),
    ) -> Self {
        let case = |&(interface, way): &(Interface, Way)| {
            let conditions = conditions(experiment, interface, way, cells);
            let values: Vec<&str> = conditions.iter().map(|(_, value)| value.as_str()).collect();
            PlannedCase {
                id: CaseId::new(
                    STUDY,
                    values.join("/"),
                    [&conditions[..], &[size_px(size)]].concat(),
                ),
                samples,
                may_be_wrong: false,
            }
        };
        Self {
            experiment,
            cells,
            size,
            cases: ways.iter().map(case).collect(),
            ways,
        }
    }
}

impl Group for Grids {
    fn name(&self) -> String {
        format!("{STUDY}/{}/{}", self.experiment, self.cells)
    }

    fn cases(&self) -> &[PlannedCase] {
        &self.cases
    }

    fn open<'a>(&'a self, context: Context<'a>) -> Result<Box<dyn Session + 'a>, StudyError> {
        let grid = Grid::new(self.cells);
        let truth = rays(&grid, self.size).picture();
        Ok(Box::new(GridSession {
            group: self,
            context,
            grid,
            truth,
            first: BTreeMap::new(),
            opened: BTreeMap::new(),
        }))
    }
}

fn rays(grid: &Grid, size: ImageSize) -> Rays<'_> {
    let size = [size.width, size.height];
    Rays::new(grid, View::new(), size, Cut::Published)
}

struct GridSession<'a> {
    group: &'a Grids,
    context: Context<'a>,
    grid: Grid,
    /// Triangles' numbers by rays.
    truth: Vec<u32>,
    /// Of the first way on each interface, by whether it draws points.
    first: BTreeMap<(Interface, bool), Vec<u32>>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn Draws>>,
}

impl GridSession<'_> {
    fn judge(&self, way: Way, numbers: &[u32]) -> Judged {
        let rays = rays(&self.grid, self.group.size);
        match way.draws_points() {
            true => rays.judge_points(numbers),
            false => rays.judge_triangles(numbers, &self.truth),
        }
    }
}

impl GridSession<'_> {
    /// Path of a case's picture, where it is kept: of the one size whose cells can be seen, or where it
    /// is wrong.
    fn picture(
        &self,
        case: usize,
        numbers: &[u32],
        judged: &Judged,
    ) -> Result<Option<String>, StudyError> {
        let is_shown = self.group.experiment == "grid" && self.grid.cells == PICTURED_CELLS;
        if !is_shown && judged.mismatched == 0 {
            return Ok(None);
        }
        let name = &self.group.cases[case].id.name;
        let draws_points = self.group.ways[case].1.draws_points();
        let size = [self.group.size.width, self.group.size.height];
        let cells = self.grid.cells;
        let folder = self.context.folder;
        let written = write(
            folder,
            name,
            size,
            numbers,
            draws_points,
            cells,
            &judged.wrong,
        );
        written.map(Some).map_err(|message| StudyError::Broken {
            place: name.clone(),
            message,
        })
    }
}

impl Session for GridSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, StudyError> {
        let (interface, way) = self.group.ways[case];
        let opened = open(
            self.context.devices,
            interface,
            way,
            &self.grid,
            &View::new(),
            self.group.size,
        );
        let drawn = opened.and_then(|mut opened| Ok((opened.draw()?, opened)));
        let ((picture, counted), opened) = match drawn {
            Ok(drawn) => drawn,
            Err(error) => return Ok(verdict_of(&error)),
        };
        let numbers = ids_of(&picture);
        let judged = self.judge(way, &numbers);
        let first = self.first.entry((interface, way.draws_points()));
        let first = first.or_insert_with(|| numbers.clone());
        let differing = numbers.iter().zip(&*first).filter(|(a, b)| a != b).count();
        self.opened.insert(case, opened);
        let picture = self.picture(case, &numbers, &judged)?;
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
        Ok(Verdict {
            status: match reason.is_empty() {
                true => Status::Ok,
                false => Status::Wrong,
            },
            reason,
            figures: figures(way, &self.grid, &judged, differing, counted),
            notes: picture.into_iter().map(|path| ("picture", path)).collect(),
        })
    }

    fn sample(&mut self, case: usize) -> Result<Vec<(&'static str, f64)>, String> {
        let opened = self.opened.get_mut(&case).ok_or("it was not verified")?;
        let times = opened.time().map_err(|error| error.to_string())?;
        Ok(times.figures())
    }
}

fn figures(
    way: way::Way,
    grid: &Grid,
    judged: &Judged,
    differing: usize,
    counted: Counted,
) -> Vec<(&'static str, f64)> {
    let mut figures = vec![
        ("pipeline_mismatched_px", judged.mismatched as f64),
        ("pipeline_band_px", judged.in_band as f64),
        ("pipeline_differing_px", differing as f64),
        ("pipeline_shown_px", judged.shown as f64),
        ("pipeline_sent_bytes", way.sent_bytes(grid) as f64),
        ("pipeline_held_bytes", way.held_bytes(grid) as f64),
        (
            "pipeline_emitted_vertices",
            way.emitted_vertices(grid) as f64,
        ),
        ("pipeline_draws", way.draws(grid) as f64),
    ];
    figures.extend(counted.figures());
    figures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::PICTURE;
    use std::rc::Rc;
    use terrafill_fill::{DeviceError, Devices};

    fn verdicts(group: &Grids, session: &mut dyn Session) -> Vec<Verdict> {
        let cases = 0..group.cases().len();
        let verdicts = cases.map(|case| session.verify(case).expect("a verdict"));
        verdicts.collect()
    }

    fn figure(verdict: &Verdict, name: &str) -> f64 {
        let figure = verdict.figures.iter().find(|figure| figure.0 == name);
        figure.unwrap_or_else(|| panic!("{name} in {verdict:?}")).1
    }

    fn has_device(interface: Interface) -> bool {
        let devices = Devices::default();
        let opened = match interface {
            Interface::Wgpu => terrafill_gpu::shared_gpu(&devices).map(drop),
            Interface::Vulkan => terrafill_vulkan::shared_gpu(&devices).map(drop),
        };
        terrafill_fill::device_for_test(opened).is_some()
    }

    fn check(group: &Grids, expected: usize) {
        if !Interface::ALL.into_iter().all(has_device) {
            return;
        }
        let devices = Rc::new(Devices::default());
        let folder = tempfile::tempdir().expect("a folder");
        let context = Context {
            devices: &devices,
            folder: folder.path(),
        };
        let mut session = group.open(context).expect("opens");
        let mut right = Vec::new();
        for (at, (case, verdict)) in group
            .cases()
            .iter()
            .zip(verdicts(group, &mut *session))
            .enumerate()
        {
            let name = &case.id.name;
            if verdict.status == Status::Skipped {
                eprintln!("{name}: {}", verdict.reason);
                assert!(!verdict.reason.is_empty(), "{name}");
                continue;
            }
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            assert!(figure(&verdict, "pipeline_shown_px") > 2_500.0, "{name}");
            eprintln!("{name}: {:?}", verdict.figures);
            right.push(at);
        }
        assert!(right.len() >= expected, "{right:?}");
        let times = session.sample(right[right.len() - 1]).expect("a time");
        assert!(times.iter().all(|(_, ms)| *ms > 0.0), "{times:?}");
    }

    #[test]
    fn every_way_draws_the_same_grid_and_the_reference_agrees() {
        // wgpu has 6 ways, Vulkan 8, without mesh shaders 7.
        check(&Grids::new("grid", 64, grid_ways(), (PICTURE, 1)), 13);
    }

    #[test]
    fn every_amplification_draws_the_same_grid() {
        // Eight cells a side are 2,048 components in strips of cells and 1,152 in strips of rows: above the usual
        // limit of 1,024.
        check(
            &Grids::new("amplify", 64, amplified_ways(), (PICTURE, 1)),
            10,
        );
    }

    #[test]
    fn a_changed_height_is_noticed_on_the_device() {
        let devices = Devices::default();
        let grid = Grid::new(64);
        let truth = rays(&grid, PICTURE).picture();
        for interface in Interface::ALL
            .into_iter()
            .filter(|interface| has_device(*interface))
        {
            for way in [Way::SentStrips, Way::NoBuffer, Way::SentPoints] {
                let judge = |drawn: &Grid| {
                    let view = View::new();
                    let opened = open(&devices, interface, way, drawn, &view, PICTURE);
                    let (picture, _) = opened.expect("opens").draw().expect("draws");
                    let numbers = ids_of(&picture);
                    match way.draws_points() {
                        true => rays(&grid, PICTURE).judge_points(&numbers),
                        false => rays(&grid, PICTURE).judge_triangles(&numbers, &truth),
                    }
                };
                assert_eq!(judge(&grid).mismatched, 0, "{interface:?} {way:?}");
                let mut changed = grid.clone();
                let vertex = changed.index(20, 20);
                changed.heights[vertex] += 60.0;
                assert!(judge(&changed).mismatched > 0, "{interface:?} {way:?}");
            }
        }
    }

    #[test]
    fn what_a_device_lacks_is_skipped_and_what_breaks_fails() {
        let skipped = verdict_of(&DeviceError::unsupported("geometry shaders", "WebGPU"));
        assert_eq!(skipped.status, Status::Skipped);
        assert!(skipped.reason.contains("geometry shaders"));
        let lost = verdict_of(&DeviceError::DeviceLost("gone".to_owned()));
        assert_eq!(lost.status, Status::Failed);
    }
}
