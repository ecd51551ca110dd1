// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tests of the eye and of the near rectangle, over eyes on deck.

use crate::views::Chooser;
use crate::work::{EYES, NEARS, Scene, port_m};
use terrafill_casters::Facing;
use terrafill_shadow_views::{
    Boxes, DeckCamera, EyeTest, Reference, Truth, chosen, deck_eyes, is_shadowed_at_corners,
    shadowed_share, sun,
};

/// What a test of the eye came to over all eyes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct EyeResult {
    pub(crate) near: f64,
    pub(crate) eyes: usize,
    /// Eyes for which z-pass was chosen and part of the near rectangle is in shadow.
    pub(crate) missed: usize,
    /// Of these, those of which a corner or the middle of the rectangle is.
    pub(crate) missed_at_corners: usize,
    /// Of these, those of which more than half of the rectangle is.
    pub(crate) missed_mostly: usize,
    /// Eyes for which z-fail was chosen and no sample of the rectangle is in shadow.
    pub(crate) needless: usize,
    /// Sum of the shares of the rectangle in shadow over missed eyes.
    pub(crate) missed_share: f64,
    /// Sum of the shares of casters' triangles drawn by z-fail.
    pub(crate) fail_share: f64,
}

/// What is seen, and masks by the published test and by the exact one.
pub(crate) type Missed = (Truth, [Vec<bool>; 2]);

/// Every test for every near plane under a sun, and the eye that the published one misses worst.
pub(crate) struct EyeTable {
    pub(crate) at: [f64; 2],
    results: Vec<(EyeTest, EyeResult)>,
    worst: Option<DeckCamera>,
}

impl EyeTable {
    pub(crate) fn new(at: [f64; 2]) -> Result<Self, String> {
        let mesh = port_m()?;
        let to_light = sun(at);
        let (facing, boxes) = (Facing::of(&mesh, to_light), Boxes::of(&mesh));
        let reference = Reference::new(&mesh, to_light);
        let mut table = Self {
            at,
            results: Vec::new(),
            worst: None,
        };
        let mut worst_share = 0.0;
        for near in NEARS {
            let none = EyeResult {
                near,
                ..EyeResult::default()
            };
            let mut results = EyeTest::ALL.map(|test| (test, none));
            for view in deck_eyes(&mesh, EYES, near) {
                let share = shadowed_share(&view, &reference);
                let at_corners = is_shadowed_at_corners(&view, &reference);
                for (test, result) in &mut results {
                    let fail = chosen(*test, &view, to_light, &mesh, &facing, &boxes, &reference);
                    let triangles: usize = mesh
                        .parts
                        .iter()
                        .zip(&fail)
                        .map(|(part, fail)| usize::from(*fail) * part.triangles.len())
                        .sum();
                    let any = triangles > 0;
                    result.eyes += 1;
                    result.fail_share += triangles as f64 / mesh.triangles.len() as f64;
                    result.needless += usize::from(any && share == 0.0);
                    if share > 0.0 && !any {
                        result.missed += 1;
                        result.missed_at_corners += usize::from(at_corners);
                        result.missed_mostly += usize::from(share > 0.5);
                        result.missed_share += share;
                        if *test == EyeTest::Eye && share > worst_share {
                            (worst_share, table.worst) = (share, Some(view));
                        }
                    }
                }
            }
            table.results.extend(results);
        }
        Ok(table)
    }

    pub(crate) fn result(&self, test: EyeTest, near: f64) -> Option<EyeResult> {
        let mut all = self.results.iter();
        let is_it = |result: &EyeResult| result.near.to_bits() == near.to_bits();
        let found = all.find(|(own, result)| *own == test && is_it(result));
        found.map(|(_, result)| *result)
    }

    /// The view that the published test misses worst.
    pub(crate) fn missed(&self) -> Result<Option<Missed>, String> {
        let Some(view) = self.worst else {
            return Ok(None);
        };
        let scene = Scene::of_port(self.at, vec![view])?;
        let mask = |test| {
            let drawn = scene.drawn_chosen(Chooser::Test(test))?;
            Ok::<_, String>(drawn.masks.concat())
        };
        let masks = [mask(EyeTest::Eye)?, mask(EyeTest::Exact)?];
        Ok(Some((scene.truths()[0].clone(), masks)))
    }
}
