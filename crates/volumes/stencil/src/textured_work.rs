// SPDX-License-Identifier: MIT OR Apache-2.0
//! The textured side of a fill by regions: what was planned last, and which picture the device holds.

use crate::{StencilExecutor, TexturedPlan};
use std::sync::Arc;
use terrafill_contract::{DeviceError, FillInput, ViewId};
use terrafill_plan::PlannedRegion;
use terrafill_scene::{SceneTexture, TextureShare};
use terrafill_variant::Switches;

/// Plans textured covers for one executor.
#[derive(Debug, Default)]
pub(crate) struct TexturedWork {
    /// The picture that the executor holds.
    picture: Option<Arc<SceneTexture>>,
    planned: Option<Planned>,
}

/// A plan, and what it was made from.
#[derive(Debug)]
struct Planned {
    view_id: ViewId,
    regions: Vec<PlannedRegion>,
    plan: TexturedPlan,
    /// Covers are drawn by it; otherwise it is only held.
    is_drawn: bool,
}

impl TexturedWork {
    /// The plan of the view that was uploaded last; `None` of a plain fill, whatever is loaded for it.
    pub(crate) fn plan(&self) -> Option<&TexturedPlan> {
        let planned = self.planned.as_ref().filter(|planned| planned.is_drawn);
        planned.map(|planned| &planned.plan)
    }

    /// Plans and uploads the view of `input`, if `switches` ask for texture; the same view again
    /// costs nothing.
    pub(crate) fn upload<V>(
        &mut self,
        executor: &mut impl StencilExecutor<V>,
        input: &FillInput,
        switches: &Switches,
    ) -> Result<(), DeviceError> {
        let texture = input.scene.texture.as_ref();
        let held = self.picture.as_ref().zip(texture);
        let holds_picture = held.is_some_and(|(held, wanted)| Arc::ptr_eq(held, wanted));
        let is_same = |planned: &Planned| {
            planned.view_id == input.view_id && planned.regions == input.plan.regions
        };
        if holds_picture && self.planned.as_ref().is_some_and(is_same) {
            return Ok(());
        }
        let Some(plan) = TexturedPlan::of_switches(input, switches)? else {
            return Ok(());
        };
        self.planned = None;
        // With no region in view nothing shows the picture.
        let is_seen = !plan.covers.is_empty();
        if let Some(texture) = texture.filter(|_| is_seen && !holds_picture) {
            let copies = match texture.share {
                TextureShare::One => 1,
                TextureShare::Each => input.scene.regions.len(),
            };
            executor.set_picture(&texture.image, copies)?;
            self.picture = Some(Arc::clone(texture));
        }
        if is_seen {
            executor.set_covers(&plan)?;
        }
        self.planned = Some(Planned {
            view_id: input.view_id,
            regions: input.plan.regions.clone(),
            plan,
            is_drawn: switches.texture.is_some(),
        });
        Ok(())
    }
}
