// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which pixels count: the paper considers shadows above the sea alone, and drops those beyond a range of depths.

use crate::work::{BOUNDS_SHARE, ChannelTotals, End, Scene};
use std::borrow::Cow;
use terrafill_shadow_views::{Light, Pass, Rule, Seen, Truth, Wrong};

terrafill_results::named! {
    /// Pixels whose shadow counts.
    pub(crate) enum Counted {
        All = "all",
        /// Those of casters: sea level is where they end.
        AboveSea = "above the sea",
        /// Those whose depth is in the channel's one range.
        InRange = "in the range",
    }
}

terrafill_results::named! {
    /// Depths between which what is seen must lie.
    pub(crate) enum Ranges {
        /// Of each part those of its volume: no shadow of it lies elsewhere.
        OfParts = "on",
        /// Of the channel those of what stands above the sea: a range of interest, as the paper has it.
        One = "on, one range",
    }
}

impl Counted {
    fn holds(self, truth: &Truth, range: [f64; 2], at: usize) -> bool {
        match self {
            Self::All => true,
            Self::AboveSea => is_above_sea(truth.seen[at]),
            Self::InRange => truth.seen[at]
                .depth()
                .is_some_and(|depth| (range[0]..=range[1]).contains(&depth)),
        }
    }
}

impl Counted {
    /// A mask that is as it should be where pixels do not count.
    pub(crate) fn taken<'m>(self, mask: &'m [bool], truth: &Truth) -> Cow<'m, [bool]> {
        if self == Self::All {
            return Cow::Borrowed(mask);
        }
        let range = range_above_sea(truth);
        let own = (0..mask.len()).map(|at| match truth.light[at] {
            light if !self.holds(truth, range, at) => light == Light::Shadow,
            _ => mask[at],
        });
        Cow::Owned(own.collect())
    }
}

fn is_above_sea(seen: Seen) -> bool {
    matches!(seen, Seen::Triangle(..))
}

/// Depths between which a channel shows something above the sea, m; none where it shows nothing.
fn range_above_sea(truth: &Truth) -> [f64; 2] {
    let own = truth.seen.iter().filter(|seen| is_above_sea(**seen));
    let depths = own.filter_map(|seen| seen.depth());
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let [near, far] = depths.fold(none, |[near, far], depth| [near.min(depth), far.max(depth)]);
    // As wide as those of parts are.
    [near * (1.0 - BOUNDS_SHARE), far * (1.0 + BOUNDS_SHARE)]
}

impl Scene {
    /// Draws volumes closed at the sea, of which fragments count where what is seen lies in the channel's one range.
    pub(crate) fn drawn_in_one_range(&self, rule: Rule) -> Result<ChannelTotals, String> {
        let volume = self.volume(End::Sea)?;
        let parts = self.mesh().parts.len();
        Ok(self.draw_by(&volume, |view, truth| {
            vec![Pass {
                bounds: vec![range_above_sea(truth); parts],
                ..self.whole(view, rule)
            }]
        }))
    }

    /// What is wrong and lost where pixels count, and how many of these are in shadow.
    pub(crate) fn counting(
        &self,
        drawn: &ChannelTotals,
        counted: Counted,
    ) -> (Wrong, usize, usize) {
        let channels = drawn.masks.iter().zip(self.truths());
        let none = (Wrong::default(), 0, 0);
        channels.fold(none, |(wrong, lost, shadow), (mask, truth)| {
            let range = range_above_sea(truth);
            let counts = |at: &usize| counted.holds(truth, range, *at);
            let own = counted.taken(mask, truth);
            let is_dark = |at: &usize| truth.light[*at] == Light::Shadow && counts(at);
            let dark = (0..mask.len()).filter(is_dark);
            let is_lost = dark.clone().filter(|at| !mask[*at]).count();
            (
                wrong.plus(Wrong::of(&own, truth)),
                lost + is_lost,
                shadow + dark.count(),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::Scissor;

    #[test]
    fn the_paper_s_scissor_and_range_lose_shadows_alone_that_do_not_count() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        let by = |scissor| scene.drawn(End::Sea, Rule::Fail, scissor).expect("above");
        let outside = |drawn: &ChannelTotals, counted| {
            let (wrong, lost, shadow) = scene.counting(drawn, counted);
            assert!(shadow > 100, "{shadow}");
            (wrong.outside(), lost > 0)
        };
        let above = by(Scissor::SeaLevel);
        assert_eq!(outside(&above, Counted::AboveSea), (0, false));
        assert!(outside(&above, Counted::All).0 > 0, "shadows on the sea");
        // Negative control: the horizon cuts the dock.
        assert!(outside(&by(Scissor::Horizon), Counted::AboveSea).0 > 0);
        for rule in [Rule::Pass, Rule::Fail] {
            let one = scene.drawn_in_one_range(rule).expect("above");
            assert_eq!(outside(&one, Counted::InRange).0, 0, "{}", rule.name());
            // Figure 6 of the paper: a shadowed point beyond the range.
            let (wrong, is_lost) = outside(&one, Counted::All);
            assert!(wrong > 0 && is_lost, "{}", rule.name());
        }
    }
}
