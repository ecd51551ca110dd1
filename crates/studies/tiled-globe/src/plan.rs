// SPDX-License-Identifier: MIT OR Apache-2.0
//! What study `globes` plans of tiles.

use crate::loading::Loadings;
use crate::options::Options;
use crate::picture::{self, Pictured, blue_marble};
use crate::stage::Stages;
use crate::tiles::{self, Tiled};
use crate::{cells, views};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_globe_views::{Opened, left_out, no_kind};
use terrafill_scene::MipChain;
use terrafill_study::{Depth, Group, Planned, Request, StudyError};

/// Groups of all parts; without the grid on the screen none, and no picture without data.
///
/// - `sizes`: pixels a side, and timed frames of a case
///
/// # Errors
/// [`StudyError::BadInput`] if the list of views is wrong.
pub fn planned(
    request: &Request,
    sizes: (u32, u32),
    opened: &Rc<Opened>,
) -> Result<Planned, StudyError> {
    let views = views::shipped().map_err(StudyError::BadInput)?;
    let mut all = Planned::default();
    if !opened.has(tiles::KIND) {
        all.skipped.push(no_kind(tiles::PART, tiles::KIND));
        return Ok(all);
    }
    let is_quick = request.depth == Depth::Quick;
    for view in views.iter().filter(|view| view.is_planned(request.depth)) {
        let options = Options::of_view(request.depth);
        let tiled = Tiled::planned(view, sizes, options, opened);
        all.groups.push(Box::new(tiled));
        if view.all_cells {
            all.groups
                .push(Box::new(cells::planned(view, sizes, opened)));
        }
        if view.chosen {
            let chosen = cells::choosing(view, sizes, opened);
            all.groups.push(Box::new(chosen));
        }
        all.groups
            .push(Box::new(Stages::planned(view, sizes, opened)));
    }
    let loaded = |picture| Box::new(Loadings::planned(sizes.0, is_quick, picture, opened));
    all.groups.push(loaded(None));
    match blue_marble(request.data_dir.as_deref()) {
        Ok((of_earth, read)) => {
            all.inputs.extend(read);
            if !is_quick {
                let named = (Arc::clone(&of_earth), picture::SCENE);
                all.groups.push(loaded(Some(named)));
            }
            let pictured = Pictured::planned(&views, sizes, is_quick, of_earth, opened);
            all.groups.push(Box::new(pictured));
        }
        Err(reason) => all.skipped.push(left_out(picture::PART, reason)),
    }
    Ok(all)
}

/// The group under a picture at more than a quick run's depth, which [`planned`] has where there is data.
///
/// - `sizes`: as of [`planned`]
/// - `picture`: of the whole body, equirectangular
///
/// # Errors
/// As of [`planned`].
pub fn pictured(
    sizes: (u32, u32),
    picture: Arc<MipChain>,
    opened: &Rc<Opened>,
) -> Result<Box<dyn Group>, StudyError> {
    let views = views::shipped().map_err(StudyError::BadInput)?;
    let group = Pictured::planned(&views, sizes, false, picture, opened);
    Ok(Box::new(group))
}
