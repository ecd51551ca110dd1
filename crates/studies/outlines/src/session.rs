// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws a case, holds it against the reference, and times it.

use crate::fleet::Fleet;
use crate::judge::{Judged, NOTHING, Truth};
use crate::metrics::{
    OUTLINE_CPU_MS, OUTLINE_GPU_MS, SHADOW_CLEARS, SHADOW_CONTOUR_PX, SHADOW_OUTLINE_PX,
    SHADOW_OUTLINE_UNDECIDED_PX, SHADOW_OUTLINE_UNLIKE_PX,
};
use crate::on_wgpu::{Drawn, OnWgpu, Way};
use std::collections::BTreeMap;
use terrafill_contract::{CpuStopwatch, numbers_hash};
use terrafill_results::Verdict;
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, JudgedOnce, Session, Shows, StudyError, file_stem,
    judged, write_rgb,
};

/// Of the background and of a wrong pixel.
const SEA: [u8; 3] = [95, 140, 175];
const WRONG: [u8; 3] = [230, 30, 30];
const STROKE: [u8; 3] = [25, 25, 35];
/// Of models, in turn.
const FACES: [[u8; 3]; 5] = [
    [225, 215, 190],
    [200, 120, 90],
    [235, 235, 235],
    [140, 160, 130],
    [220, 180, 90],
];

/// A number of models, and the ways and widths in which they are outlined.
pub(crate) struct Outlined {
    pub(crate) models: usize,
    pub(crate) ways: Vec<(Way, u32)>,
    /// Pixels.
    pub(crate) size: [u32; 2],
    /// Whether every case keeps its picture.
    pub(crate) keeps_all: bool,
}

pub(crate) fn opened<'a>(
    group: &'a CaseGroup<Outlined>,
    context: Context<'a>,
) -> Result<Box<dyn Session + 'a>, StudyError> {
    Ok(Box::new(JudgedOnce::new(Outlining {
        group,
        context,
        opened: None,
        truths: BTreeMap::new(),
        cleared: BTreeMap::new(),
    })))
}

struct Outlining<'a> {
    group: &'a CaseGroup<Outlined>,
    context: Context<'a>,
    opened: Option<(Fleet, OnWgpu)>,
    /// By width of strokes, pixels.
    truths: BTreeMap<u32, Truth>,
    /// What a clear for each model shows, by the same.
    cleared: BTreeMap<u32, Vec<u32>>,
}

impl Outlining<'_> {
    fn opened(&mut self) -> Result<&(Fleet, OnWgpu), Failure> {
        if self.opened.is_none() {
            let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
            let work = &self.group.work;
            let fleet = Fleet::of(work.models, work.size)?;
            let drawn = OnWgpu::new(&gpu, &fleet)?;
            self.opened = Some((fleet, drawn));
        }
        let opened = self.opened.as_ref();
        opened.ok_or_else(|| Failure::broken("it was not opened"))
    }
}

impl Shows for Outlining<'_> {
    type Shown = (Vec<u32>, Drawn);

    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure> {
        let (way, width) = self.group.work.ways[case];
        let (_, device) = self.opened()?;
        let drawn = device.frame(way, width)?;
        let numbers = device.read()?;
        let hash = format!("{}-{}", numbers_hash(&numbers), drawn.clears);
        Ok((hash, (numbers, drawn)))
    }

    fn judge(&mut self, case: usize, (numbers, drawn): Self::Shown) -> Result<Verdict, Failure> {
        let work = &self.group.work;
        let (way, width) = work.ways[case];
        if !self.truths.contains_key(&width) {
            let (fleet, _) = self.opened()?;
            let truth = Truth::new(fleet, f64::from(width));
            // At 4K one fills half a gigabyte, and a width's cases follow one another.
            self.truths.clear();
            self.truths.insert(width, truth);
        }
        let truth = &self.truths[&width];
        let found = truth.judge(&numbers);
        let [strokes, undecided] = truth.counts();
        let mut figures = vec![
            (SHADOW_CONTOUR_PX.name, found.all() as f64),
            (SHADOW_CLEARS.name, drawn.clears as f64),
            (SHADOW_OUTLINE_PX.name, strokes as f64),
            (SHADOW_OUTLINE_UNDECIDED_PX.name, undecided as f64),
        ];
        if way == Way::Clear {
            self.cleared.insert(width, numbers.clone());
        }
        if let Some(cleared) = self.cleared.get(&width) {
            let pairs = cleared.iter().zip(&numbers);
            let unlike = pairs.filter(|(one, other)| one != other).count();
            figures.push((SHADOW_OUTLINE_UNLIKE_PX.name, unlike as f64));
        }
        let reason = if found.all() > 0 {
            format!(
                "{} pixels show a stroke that the method drops, {} lack one, {} show another model",
                found.inside, found.missing, found.others
            )
        } else if strokes == 0 {
            "no pixel must show a stroke".to_owned()
        } else {
            String::new()
        };
        let mut notes = Vec::new();
        if work.keeps_all || width > 1 {
            let name = file_stem(&self.group.cases[case].id.name);
            let colours = colours(&numbers, &found).concat();
            let path = write_rgb(self.context.folder, &name, work.size, &colours)?;
            notes.push(("image", path));
        }
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let (way, width) = self.group.work.ways[case];
        let (_, device) = self.opened()?;
        let watch = CpuStopwatch::start();
        let drawn = device.frame(way, width)?;
        let mut figures = vec![(OUTLINE_CPU_MS.name, watch.cpu_ms())];
        figures.extend(drawn.gpu_ms.map(|ms| (OUTLINE_GPU_MS.name, ms)));
        Ok(figures)
    }
}

/// A picture for people: models in colours of their own, strokes dark, wrong pixels red.
fn colours(numbers: &[u32], found: &Judged) -> Vec<[u8; 3]> {
    let pixels = numbers.iter().zip(&found.wrong);
    let colour = |(number, is_wrong): (&u32, &bool)| match *number {
        _ if *is_wrong => WRONG,
        NOTHING => SEA,
        face if face % 2 == 1 => FACES[(face / 2) as usize % FACES.len()],
        _ => STROKE,
    };
    pixels.map(colour).collect()
}

#[cfg(test)]
mod tests;
