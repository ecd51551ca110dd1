// SPDX-License-Identifier: MIT OR Apache-2.0
//! The study: each case is divided, drawn, held against `f64`, and timed.

use crate::STUDY;
use crate::cases::{Division, Part, Vantage, Work, groups};
use crate::chapter::CHAPTER;
use crate::divided::{Corner, DecalConstants, Divided, MAX_CELLS, Origin};
use crate::draws::{Draws, sent_bytes, time};
use crate::interface::{Addressed, Interface};
use crate::judge::{Errors, Reference, exact, texels};
use crate::metrics::*;
use crate::on_wgpu;
use crate::pictures;
use glam::DVec2;
use std::collections::BTreeMap;
use terrafill_contract::{CpuStopwatch, DeviceError, ids_of, numbers_hash};
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_study::{
    CaseGroup, Context, Depth, Failure, Figures, Group, JudgedOnce, Planned, Request, Shows, Study,
    StudyError, judged, size_name, verified,
};

/// Pixels a side of a quick run.
const QUICK_PX: u32 = 256;
/// Timed frames of each case in a process.
const SAMPLES: u32 = 4;
/// Setting of a request with which every case keeps its picture.
const PICTURES: &str = "pictures";

/// Decals and lines on a globe, divided by every rule.
#[derive(Debug, Clone, Copy)]
pub struct DecalsStudy;

impl Study for DecalsStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: CHAPTER,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let [width, height] = request.size_or([QUICK_PX; 2]);
        let side = width.min(height);
        let samples = request.samples.unwrap_or(SAMPLES);
        let keeps_all = request.settings.contains_key(PICTURES);
        let is_quick = request.depth == Depth::Quick;
        let groups = groups(is_quick).into_iter();
        let group = |works| Box::new(group(works, side, samples, keeps_all)) as Box<dyn Group>;
        Ok(Planned {
            groups: groups.map(group).collect(),
            ..Planned::default()
        })
    }
}

/// Cases that share what is drawn and from where.
pub(crate) struct Works {
    pub(crate) works: Vec<Work>,
    side: u32,
    keeps_all: bool,
}

pub(crate) fn group(
    works: Vec<Work>,
    side: u32,
    samples: u32,
    keeps_all: bool,
) -> CaseGroup<Works> {
    let case = |work: &Work| {
        let mut conditions = work.conditions();
        conditions.push((SIZE_PX, size_name([side; 2])));
        PlannedCase {
            id: CaseId::new(STUDY, work.name(), conditions),
            samples,
            may_be_wrong: false,
        }
    };
    CaseGroup {
        name: format!("{STUDY}/{}", works[0].name()),
        cases: works.iter().map(case).collect(),
        warm_up: None,
        work: Works {
            works,
            side,
            keeps_all,
        },
        open: |group, context| {
            Ok(Box::new(JudgedOnce::new(DecalSession {
                group,
                context,
                opened: BTreeMap::new(),
                addressed: Addressed::default(),
                exact: Vec::new(),
                drawn: Vec::new(),
            })))
        },
    }
}

/// What counted pixels found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Counted {
    pub(crate) cells: u32,
    pub(crate) frames: u32,
    /// In the frame of these cells.
    pub(crate) px: u64,
}

/// Divides by counted pixels what is opened, leaves it so divided, and says how many bytes of vertices were sent.
fn counted(draws: &mut dyn Draws, work: &Work, side: u32) -> Result<(Counted, usize), DeviceError> {
    let mut bytes = 0;
    let count = |cells| {
        let divided = work.counted(side, cells);
        bytes += sent_bytes(&divided);
        draws.divide(&divided)?;
        draws.count()
    };
    let found = by_counts(count)?;
    let divided = work.divided(side, Some(found.cells));
    bytes += sent_bytes(&divided);
    draws.divide(&divided)?;
    Ok((found, bytes))
}

/// Divides twice as finely in each frame until no more pixels are counted, as the paper says it: then the division before
/// was fine enough.
///
/// - `count`: pixels with so many cells along a side
pub(crate) fn by_counts<E>(mut count: impl FnMut(u32) -> Result<u64, E>) -> Result<Counted, E> {
    let mut found = Counted {
        cells: 1,
        frames: 1,
        px: count(1)?,
    };
    while found.cells < MAX_CELLS {
        let px = count(2 * found.cells)?;
        found.frames += 1;
        if px <= found.px {
            break;
        }
        found.cells *= 2;
        found.px = px;
    }
    Ok(found)
}

/// What a case showed.
pub(crate) struct Shown {
    divided: Divided,
    numbers: Vec<u32>,
    corners: Vec<Corner>,
    /// Distance and bound of [`Divided::vertices_off`].
    vertices_off: Option<[f64; 2]>,
    counted: Option<Counted>,
    sent_bytes: usize,
}

struct DecalSession<'a> {
    group: &'a CaseGroup<Works>,
    context: Context<'a>,
    /// By case.
    opened: BTreeMap<usize, Box<dyn Draws>>,
    addressed: Addressed,
    /// Of the data and the view that all cases share, as of [`exact`].
    exact: Vec<Option<DVec2>>,
    /// What triangles show, as of [`Reference::picture`]: of cases on wgpu, which come before the same on Vulkan.
    drawn: Vec<(Work, Vec<Option<DVec2>>)>,
}

impl DecalSession<'_> {
    /// Whether a case's picture is kept in every run.
    fn is_pictured(&self, work: &Work) -> bool {
        let is_fixed = matches!(work.division, Division::Fixed(_));
        let is_large = work.extent.angle() > 0.5 && work.from != Vantage::Limb;
        let is_plain = work.origin == Origin::Corner;
        self.group.work.keeps_all || (is_fixed && is_large && is_plain)
    }
}

impl DecalSession<'_> {
    fn drawn(&mut self, work: Work, reference: &Reference<'_>) -> Vec<Option<DVec2>> {
        let is_same = |(own, _): &&(Work, _)| {
            let interface = work.interface;
            work.interface == Interface::Vulkan && Work { interface, ..*own } == work
        };
        if let Some((_, drawn)) = self.drawn.iter().find(is_same) {
            return drawn.clone();
        }
        let drawn = reference.picture();
        if work.interface == Interface::Wgpu {
            self.drawn.push((work, drawn.clone()));
        }
        drawn
    }
}

impl Shows for DecalSession<'_> {
    type Shown = Shown;

    fn show(&mut self, case: usize) -> Result<(String, Shown), Failure> {
        let work = self.group.work.works[case];
        let side = self.group.work.side;
        let mut divided = work.divided(side, None);
        let mut draws = work
            .interface
            .open(self.context.devices, &divided, &mut self.addressed)?;
        let (mut found, mut sent_bytes) = (None, sent_bytes(&divided));
        if work.division.is_counted() {
            let (own, bytes) = counted(draws.as_mut(), &work, side)?;
            divided = work.divided(side, Some(own.cells));
            (found, sent_bytes) = (Some(own), bytes);
        }
        draws.frame()?;
        let numbers = ids_of(&draws.read()?);
        self.opened.insert(case, draws);
        let mut corners = divided.corners();
        let mut vertices_off = None;
        if work.is_read_back() {
            let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
            let clips = on_wgpu::clips(&gpu, &divided)?;
            vertices_off = divided.vertices_off(&clips);
            // About the centre they are off by more than the band: then pictures are held against the device's own.
            if work.origin == Origin::Centre {
                for (corner, clip) in corners.iter_mut().zip(clips) {
                    corner.clip = clip;
                }
            }
        }
        let counts = found.map(|of| format!("-{}-{}", of.cells, of.px));
        let hash = numbers_hash(&numbers) + &counts.unwrap_or_default();
        Ok((
            hash,
            Shown {
                divided,
                numbers,
                corners,
                vertices_off,
                counted: found,
                sent_bytes,
            },
        ))
    }

    fn judge(&mut self, case: usize, shown: Shown) -> Result<Verdict, Failure> {
        let Shown {
            divided,
            numbers,
            corners,
            vertices_off,
            counted,
            sent_bytes,
        } = shown;
        let work = self.group.work.works[case];
        let reference = Reference::new(&divided, &corners);
        let drawn = self.drawn(work, &reference);
        let found = reference.judge(&numbers, &drawn);
        let is_data = |number: &&u32| texels(divided.data.shape, **number).is_some();
        let shown = numbers.iter().filter(is_data).count();
        let is_decal = work.part == Part::Decal;
        let errors = if is_decal {
            if self.exact.is_empty() {
                self.exact = exact(&divided);
            }
            Errors::of_decal(&divided, &numbers, &drawn, &self.exact)
        } else {
            Errors::of_line(&divided, &numbers)
        };
        let mut figures: Figures = vec![
            (DECAL_MISMATCHED_PX.name, found.mismatched as f64),
            (DECAL_BAND_PX.name, found.in_band as f64),
            (DECAL_SHOWN_PX.name, shown as f64),
            (DECAL_CELLS.name, f64::from(divided.cells)),
            (DECAL_TRIANGLES.name, divided.triangles() as f64),
            (DECAL_SENT_BYTES.name, sent_bytes as f64),
            (DECAL_FRAME_BYTES.name, size_of::<DecalConstants>() as f64),
        ];
        figures.push((DECAL_EXTRA_PX.name, errors.extra as f64));
        figures.push((DECAL_MISSING_PX.name, errors.missing as f64));
        let names = [DECAL_PX_MAX, DECAL_PX_P99, DECAL_PX_MEDIAN].map(|metric| metric.name);
        figures.extend(names.into_iter().zip(errors.spread().into_iter().flatten()));
        let of_side = errors
            .spread()
            .map(|[most, ..]| most * 1e3 / f64::from(divided.eye.side));
        figures.extend(of_side.map(|share| (DECAL_MAX_MIL.name, share)));
        figures.extend(vertices_off.map(|[px, _]| (DECAL_VERTEX_PX.name, px)));
        if divided.is_tested {
            let all = reference.with_body(false).picture();
            let all = all.iter().flatten().count();
            let hidden = 1.0 - shown as f64 / all.max(1) as f64;
            figures.push((DECAL_HIDDEN_SHARE.name, hidden));
        }
        let mut reason = match found.mismatched {
            0 if shown == 0 && !divided.is_tested => "it shows nothing".to_owned(),
            0 => String::new(),
            mismatched => format!("{mismatched} pixels show what the reference does not allow"),
        };
        if let Some([px, bound]) = vertices_off
            && px > bound
        {
            reason = format!("vertices are {px} px off, and rounding explains {bound}");
        }
        if let Some(counted) = counted {
            // Counted where it is divided, against f64 there: from what is sure to what may be.
            let there = work.counted(self.group.work.side, counted.cells);
            let [sure, most] = Reference::new(&there, &there.corners()).counts();
            let off = sure.saturating_sub(counted.px) + counted.px.saturating_sub(most);
            figures.push((DECAL_FRAMES.name, f64::from(counted.frames)));
            figures.push((DECAL_COUNTED_PX.name, counted.px as f64));
            figures.push((DECAL_MISCOUNTED_PX.name, off as f64));
            // A pixel that two triangles cover is counted twice: only lines, at their bends, and what folds over the
            // horizon have some.
            let may_overlap = !is_decal || work.from == Vantage::Limb;
            if reason.is_empty() && off > 0 && !may_overlap {
                reason = format!("{} samples are counted, of {sure} to {most}", counted.px);
            }
        }
        let notes = if self.is_pictured(&work) || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            pictures::write(self.context.folder, name, &divided, &numbers, &found.wrong)?
        } else {
            Vec::new()
        };
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let work = &self.group.work.works[case];
        let side = self.group.work.side;
        let draws = verified(&mut self.opened, case)?.as_mut();
        let mut figures = time(draws)?;
        let watch = CpuStopwatch::start();
        match work.division {
            Division::Fixed(_) => return Ok(figures),
            Division::Formula => {
                std::hint::black_box(work.divided(side, None));
            }
            Division::Query | Division::Elsewhere => {
                counted(draws, work, side)?;
            }
        }
        figures.push((DECAL_DIVIDE_CPU_MS.name, watch.cpu_ms()));
        figures.push((DECAL_DIVIDE_WALL_MS.name, watch.wall_ms()));
        Ok(figures)
    }
}
