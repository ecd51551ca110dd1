// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured together: surfaces through their knobs in each view, and further parts.

use crate::controllers::Controllers;
use crate::counts::Counts;
use crate::filled::{self, FilledSurfaces};
use crate::list::List;
use crate::made::{MadeGlobes, height_fields};
use crate::metrics::METRICS;
use crate::shading::{self, Shadings, Textures};
use crate::sight::{SurfacesView, works};
use crate::wires::Wires;
use crate::zones::{HillPictures, Zones};
use crate::{STUDY, chapter::GlobesChapter};
use std::rc::Rc;
use terrafill_globe_views::{Opened, ViewRow, left_out, no_kind};
use terrafill_results::Skipped;
use terrafill_study::{Depth, Group, Planned, Request, Study, StudyError};
use terrafill_surface::SurfaceKind;

/// Timed frames of each case in a process, unless the request says otherwise. Odd, so that the median
/// is one of them.
const SAMPLES: u32 = 5;
const FULL_SAMPLES: u32 = 7;

/// Pixels a side of a quick run that names no size.
const QUICK_SIDE_PX: u32 = 400;

/// Which surface draws the body with which error in which time.
#[derive(Debug, Clone, Copy)]
pub struct GlobesStudy {
    /// Surfaces that it may compare.
    pub surfaces: &'static [&'static dyn SurfaceKind],
}

impl Study for GlobesStudy {
    terrafill_study::study_facts!(
        name: STUDY,
        metrics: METRICS,
        conditions: crate::metrics::CONDITIONS,
        least_depth: Full,
        chapter: GlobesChapter,
    );

    fn plan(&self, request: &Request) -> Result<Planned, StudyError> {
        let list = List::shipped().map_err(StudyError::BadInput)?;
        let is_quick = request.depth == Depth::Quick;
        let is_planned = |view: &&ViewRow| view.is_planned(request.depth);
        let opened = Rc::new(Opened::new(self.surfaces));
        let rows = list.surface.iter().cloned();
        let (rows, without): (Vec<_>, Vec<_>) = rows.partition(|row| opened.has(&row.kind));
        let without = without.iter().map(|row| no_kind(&row.name, &row.kind));
        let mut skipped: Vec<Skipped> = without.collect();
        let works = works(&rows, request.depth);
        let sizes = sizes(request);
        let mut groups: Vec<Box<dyn Group>> = Vec::new();
        let mut inputs = Vec::new();
        for view in list.view.iter().filter(is_planned) {
            let surfaces = SurfacesView::planned(view, &works, &opened, sizes);
            groups.push(Box::new(surfaces));
        }
        groups.push(Box::new(Wires::planned(&list.view, &rows, sizes, &opened)));
        let view = list
            .view(filled::VIEW_OF_ALL)
            .map_err(StudyError::BadInput)?;
        let filled = FilledSurfaces::planned(view, &rows, sizes, &opened);
        groups.push(Box::new(filled));
        let tiled = terrafill_tiled_globe::planned(request, sizes, &opened)?;
        groups.extend(tiled.groups);
        skipped.extend(tiled.skipped);
        inputs.extend(tiled.inputs);
        match shading::layers(&opened, request.data_dir.as_deref()) {
            Ok((layers, read)) => {
                inputs.extend(read);
                let layers = Rc::new(layers);
                if !is_quick {
                    let textures = Textures::planned(sizes, Rc::clone(&layers));
                    groups.push(Box::new(textures));
                }
                let shaded = Shadings::planned(&list, sizes, is_quick, layers, &opened);
                groups.push(Box::new(shaded));
            }
            Err(reason) => skipped.push(left_out(shading::PART, reason)),
        }
        let (fields, without, of_heights) = height_fields(&opened, request.data_dir.as_deref());
        skipped.extend(without);
        inputs.extend(of_heights);
        groups.push(Box::new(MadeGlobes::planned(&list, sizes, fields)));
        groups.push(Box::new(Counts::planned(&list, is_quick, sizes.1)));
        groups.push(Box::new(Zones::planned(request.depth, sizes.1)));
        groups.push(Box::new(HillPictures::planned(sizes)));
        groups.push(Box::new(Controllers::planned(request.depth, sizes.1)));
        Ok(Planned {
            groups,
            skipped,
            inputs,
        })
    }
}

/// Pixels a side, and timed frames of a case. Pictures are square: of another size, the smaller side.
fn sizes(request: &Request) -> (u32, u32) {
    let [width, height] = request.size_or([QUICK_SIDE_PX; 2]);
    let samples = match request.depth {
        Depth::Quick | Depth::Main => SAMPLES,
        Depth::Full => FULL_SAMPLES,
    };
    (width.min(height), request.samples.unwrap_or(samples))
}

#[cfg(test)]
mod tests;
