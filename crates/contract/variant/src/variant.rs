// SPDX-License-Identifier: MIT OR Apache-2.0
//! A variant: everything that is chosen of a technique, as keys and values that can be written down.

use crate::switch::{self, Switch, Values, one_of};
use crate::{DepthRuleChoice, SwitchError, Switches, pick};
use std::collections::BTreeMap;
use terrafill_plan::{PartCulling, PlanOptions, WallHeights};
use terrafill_scene::Overlap;

/// A parameter that a technique has beside the switches of every fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameter {
    /// Its name.
    pub key: &'static str,
    /// What it may be.
    pub values: Values,
    /// What it decides, in a line.
    pub meaning: &'static str,
    /// What it is unless it is set.
    pub default: &'static str,
    /// Layouts in which it is something else unless it is set, and what.
    pub default_in: &'static [(&'static str, &'static str)],
}

impl Parameter {
    /// A parameter that is one of `values`, the first of them unless it is set.
    #[must_use]
    pub const fn one_of(
        key: &'static str,
        values: &'static [&'static str],
        meaning: &'static str,
    ) -> Self {
        Self {
            key,
            values: Values::OneOf(values),
            meaning,
            default: values[0],
            default_in: &[],
        }
    }

    fn check(&self, value: &str) -> Result<(), SwitchError> {
        if self.values.allows(value) {
            return Ok(());
        }
        Err(SwitchError {
            switch: self.key,
            found: value.to_owned(),
            allowed: self.values.allowed(value),
        })
    }
}

/// A technique with everything that can be chosen of it. Two variants are equal when all their
/// settings are.
#[derive(Debug, Clone)]
pub struct Variant {
    technique: &'static str,
    parameters: &'static [Parameter],
    /// Parameters that were set.
    own: BTreeMap<&'static str, String>,
    /// What the fill does.
    pub switches: Switches,
    /// What is left out before.
    pub plan: PlanOptions,
}

impl PartialEq for Variant {
    fn eq(&self, other: &Self) -> bool {
        self.technique == other.technique && self.settings() == other.settings()
    }
}

impl Variant {
    /// All defaults, coloured in the way that is right for scenes of this kind.
    ///
    /// - `parameters`: of the technique; the first one is the layout
    #[must_use]
    pub fn new(
        technique: &'static str,
        parameters: &'static [Parameter],
        overlap: Overlap,
    ) -> Self {
        Self {
            technique,
            parameters,
            own: BTreeMap::new(),
            switches: Switches::for_overlap(overlap),
            plan: PlanOptions::default(),
        }
    }

    /// Name of the technique.
    #[must_use]
    pub fn technique(&self) -> &'static str {
        self.technique
    }

    /// How geometry is stored or made: the value of the first parameter.
    #[must_use]
    pub fn layout(&self) -> &str {
        let layout = self.parameters.first();
        layout.map_or("", |layout| {
            self.set_value(layout).unwrap_or(layout.default)
        })
    }

    /// The value of one of the technique's own parameters; `None` when it has no such one.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<&str> {
        let parameter = self
            .parameters
            .iter()
            .find(|parameter| parameter.key == key)?;
        Some(
            self.set_value(parameter)
                .unwrap_or_else(|| self.default_of(parameter)),
        )
    }

    /// The choice that the value of `key` names, for a technique that reads its own parameters.
    ///
    /// # Errors
    /// [`SwitchError`] when `choices` and the technique's parameters name different values.
    pub fn choice<T: Copy>(
        &self,
        key: &'static str,
        choices: &[(&'static str, T)],
    ) -> Result<T, SwitchError> {
        pick(key, self.value(key).unwrap_or_default(), choices)
    }

    fn set_value(&self, parameter: &Parameter) -> Option<&str> {
        self.own.get(parameter.key).map(String::as_str)
    }

    fn default_of(&self, parameter: &Parameter) -> &'static str {
        let layout = self.layout();
        let special = parameter
            .default_in
            .iter()
            .find(|(name, _)| *name == layout);
        special.map_or(parameter.default, |(_, value)| value)
    }

    /// Layout first, then what differs from the default, `key=value`, in alphabetical order.
    #[must_use]
    pub fn name(&self) -> String {
        let own = self.parameters.iter().skip(1).filter_map(|parameter| {
            let value = self.set_value(parameter)?;
            let differs = value != self.default_of(parameter);
            differs.then(|| format!("{}={value}", parameter.key))
        });
        let fill = self.switches.names().into_iter();
        let plan = switch::names(PLAN_TABLE, &self.plan);
        let mut names: Vec<String> = own.chain(fill).chain(plan).collect();
        names.sort_unstable();
        names.insert(0, self.layout().to_owned());
        names.join(",")
    }

    /// Every parameter, every switch of the fill and every option of the plan with its value,
    /// defaults included.
    #[must_use]
    pub fn settings(&self) -> Vec<(&'static str, String)> {
        let own = self.parameters.iter().map(|parameter| {
            let value = self.value(parameter.key).unwrap_or_default();
            (parameter.key, value.to_owned())
        });
        own.chain(self.switches.settings())
            .chain(switch::settings(PLAN_TABLE, &self.plan))
            .collect()
    }

    /// Sets `key` to `value`; with the layout's key the inverse of [`Variant::name`]. `Ok(false)`
    /// when there is no such key.
    ///
    /// # Errors
    /// [`SwitchError`] when the value is none of the key's.
    pub fn set(&mut self, key: &str, value: &str) -> Result<bool, SwitchError> {
        if let Some(parameter) = self.parameters.iter().find(|own| own.key == key) {
            parameter.check(value)?;
            self.own.insert(parameter.key, value.to_owned());
            return Ok(true);
        }
        if let Some(switch) = GONE.into_iter().find(|gone| *gone == key) {
            return Err(SwitchError {
                switch,
                found: value.to_owned(),
                allowed: LEAVE_OUT.to_owned(),
            });
        }
        Ok(self.switches.set(key, value)? || switch::set(PLAN_TABLE, &mut self.plan, key, value)?)
    }

    /// The same with `key` at `value`, both written in the code that calls this.
    ///
    /// # Panics
    /// When there is no such key or value: a mistake in that code.
    #[must_use]
    pub fn with(mut self, key: &str, value: &str) -> Self {
        let set = self.set(key, value);
        assert_eq!(set, Ok(true), "{}: {key}={value}", self.technique);
        self
    }

    /// The same with other switches.
    #[must_use]
    pub fn with_switches(mut self, change: impl FnOnce(&mut Switches)) -> Self {
        change(&mut self.switches);
        self
    }

    /// Whether it is one of a technique's own.
    ///
    /// # Errors
    /// [`SwitchError`] of another technique's.
    pub fn check_technique(&self, name: &str) -> Result<(), SwitchError> {
        if self.technique == name {
            return Ok(());
        }
        Err(SwitchError {
            switch: "technique",
            found: self.technique.to_owned(),
            allowed: name.to_owned(),
        })
    }

    /// Whether it is one of a technique that has no stencil, so that no switch of stencil fills means anything, and
    /// that draws regions whole.
    ///
    /// # Errors
    /// [`SwitchError`].
    pub fn check_without_stencil(&self, overlap: Overlap) -> Result<(), SwitchError> {
        self.check_parts(false)?;
        if self.switches == Switches::for_overlap(overlap) {
            return Ok(());
        }
        Err(SwitchError {
            switch: "technique",
            found: format!("{} with a switch of stencil fills", self.name()),
            allowed: format!("none of them: {} has no stencil", self.technique),
        })
    }

    /// Whether parts of regions may be left out: only of a technique that draws parts, and those that the body
    /// hides only where fragments in front of the surface count.
    ///
    /// - `draws_parts`: whether the technique does, as it is set
    ///
    /// # Errors
    /// [`SwitchError`].
    pub fn check_parts(&self, draws_parts: bool) -> Result<(), SwitchError> {
        let refuse = |value: &str, why: &str, allowed: &str| {
            Err(SwitchError {
                switch: "part-culling",
                found: format!("{value} {why}"),
                allowed: allowed.to_owned(),
            })
        };
        let depth_rule = self.switches.depth_rule;
        match self.plan.part_culling {
            PartCulling::Off => Ok(()),
            PartCulling::Frustum | PartCulling::All if !draws_parts => {
                let value = match self.plan.part_culling {
                    PartCulling::All => "all",
                    _ => "frustum",
                };
                let layout = format!("of {} {}", self.technique, self.layout());
                refuse(
                    value,
                    &format!("{layout}, which draws regions whole"),
                    "off",
                )
            }
            PartCulling::All if depth_rule == DepthRuleChoice::Fail => refuse(
                "all",
                "with depth-rule=zfail, to which hidden fragments count",
                "off, frustum, or depth-rule=automatic",
            ),
            PartCulling::Frustum | PartCulling::All => Ok(()),
        }
    }

    /// Everything that [`Variant::set`] takes: key, values, and what it decides.
    #[must_use]
    pub fn keys(&self) -> Vec<(&'static str, Values, &'static str)> {
        let own = self
            .parameters
            .iter()
            .map(|own| (own.key, own.values, own.meaning));
        let fill = Switches::TABLE
            .iter()
            .map(|of| (of.key, of.values, of.meaning));
        let plan = PLAN_TABLE.iter().map(|of| (of.key, of.values, of.meaning));
        own.chain(fill).chain(plan).collect()
    }
}

/// Switches of older programs, whose figures are kept.
const GONE: [&str; 3] = ["cap-faces", "counted", "depth-bounds"];

/// What is allowed in place of one of them.
const LEAVE_OUT: &str =
    "to leave it out: it did not pay on hardware and is gone, docs/volume-cost.md has its figures";

/// Whether a switch is one of older programs, which no technique has any more.
#[must_use]
pub fn is_gone(key: &str) -> bool {
    GONE.contains(&key)
}

/// Every option of a plan, in alphabetical order.
const PLAN_TABLE: &[Switch<PlanOptions>] = &[
    one_of!("boundary-lod-px", boundary_lod_px: PIXELS,
        "draw boundaries at the coarsest level that moves none by more"),
    one_of!("far-level-px", far_level_px: PIXELS,
        "draw regions whose volumes are lower as flat meshes, without stencil"),
    one_of!("frustum-culling", frustum_culling: ["on" => true, "off" => false],
        "leave out regions outside the view"),
    one_of!("horizon-culling", horizon_culling: ["on" => true, "off" => false],
        "leave out regions that the body hides"),
    one_of!("interior", interior: ["on" => true, "off" => false],
        "cover without a volume where all ground in view is one region's"),
    one_of!("part-culling", part_culling: [
        "off" => PartCulling::Off,
        "frustum" => PartCulling::Frustum,
        "all" => PartCulling::All,
    ], "leave out parts of large regions: none, outside the view, and those that the body hides"),
    one_of!("sky-culling", sky_culling: ["on" => true, "off" => false],
        "end volumes and rectangles where the image shows sky only"),
    one_of!("too-small-culling", too_small_culling: ["on" => true, "off" => false],
        "leave out regions that reach the centre of no pixel"),
    one_of!("wall-heights", wall_heights: ["region" => WallHeights::Region, "global" => WallHeights::Global],
        "how high walls are: as the ground of their region, or 12 km above and below the ellipsoid"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FacePasses;

    const PARAMETERS: &[Parameter] = &[
        Parameter::one_of("layout", &["flat", "tall"], "which"),
        Parameter {
            default_in: &[("tall", "strip")],
            ..Parameter::one_of("indices", &["list", "strip"], "how")
        },
        Parameter {
            key: "opacity",
            values: Values::Percent,
            meaning: "how much",
            default: "100",
            default_in: &[],
        },
    ];

    fn plain() -> Variant {
        Variant::new("test", PARAMETERS, Overlap::Disjoint)
    }

    #[test]
    fn own_settings_switches_and_plan_share_one_sorted_name() {
        assert_eq!(plain().name(), "flat");
        let mut changed = plain().with("opacity", "40").with_switches(|switches| {
            switches.faces = FacePasses::TwoPass;
            switches.scissor = true;
        });
        changed.plan.horizon_culling = false;
        changed.plan.boundary_lod_px = Some(0.5);
        changed.plan.far_level_px = Some(0.25);
        let name = "flat,boundary-lod-px=0.5,faces=two-pass,far-level-px=0.25,horizon-culling=off,opacity=40,scissor=volumes";
        assert_eq!(changed.name(), name);
        let mut read = plain();
        for part in name.split(',').skip(1) {
            let (key, value) = part.split_once('=').expect("key=value");
            assert_eq!(read.set(key, value), Ok(true), "{part}");
        }
        assert_eq!(read, changed);
        assert_ne!(read, plain());
    }

    #[test]
    fn a_default_may_depend_on_the_layout() {
        let tall = plain().with("layout", "tall");
        assert_eq!(tall.value("indices"), Some("strip"));
        assert_eq!(tall.name(), "tall");
        // What is said and what is so anyway are one variant.
        assert_eq!(tall.clone().with("indices", "strip"), tall);
        assert_eq!(
            tall.clone().with("indices", "list").name(),
            "tall,indices=list"
        );
        assert_eq!(
            plain().with("indices", "strip").name(),
            "flat,indices=strip"
        );
        assert_eq!(plain().with("indices", "list").name(), "flat");
    }

    #[test]
    fn every_setting_has_a_value_and_can_be_set_to_it() {
        let changed = plain().with("indices", "strip").with("colour", "volume");
        let settings = changed.settings();
        assert_eq!(settings.len(), 3 + Switches::TABLE.len() + PLAN_TABLE.len());
        let mut read = plain().with("opacity", "7");
        for (key, value) in &settings {
            assert_eq!(read.set(key, value), Ok(true), "{key}={value}");
            assert!(changed.keys().iter().any(|(own, ..)| own == key), "{key}");
        }
        assert_eq!(read, changed);
        let distinct: std::collections::BTreeSet<_> = settings.iter().map(|s| &s.0).collect();
        assert_eq!(distinct.len(), settings.len());
    }

    #[test]
    fn unknown_keys_and_values_are_refused() {
        let mut variant = plain();
        assert_eq!(variant.set("layouts", "flat"), Ok(false));
        for (key, value, allowed) in [
            ("layout", "wide", "flat, tall"),
            ("indices", "", "list, strip"),
            ("opacity", "0", "whole percent, 1 to 100"),
            ("opacity", "101", "whole percent, 1 to 100"),
            ("faces", "three", "two-sided, two-pass"),
            ("horizon-culling", "maybe", "on, off"),
            ("boundary-lod-px", "-1", "PIXELS, a number above 0, or off"),
            ("boundary-lod-px", "NaN", "PIXELS, a number above 0, or off"),
            ("far-level-px", "0", "PIXELS, a number above 0, or off"),
            ("part-culling", "on", "off, frustum, all"),
            ("counted", "wall-band", LEAVE_OUT),
        ] {
            let error = variant.set(key, value).expect_err("no such value");
            assert_eq!((error.switch, error.allowed.as_str()), (key, allowed));
        }
        assert_eq!(variant, plain());
        assert_eq!(variant.value("faces"), None, "none of its own");
        assert!(variant.choice("layout", &[("round", ())]).is_err());
        assert_eq!(variant.choice("layout", &[("flat", 1), ("tall", 2)]), Ok(1));
    }

    #[test]
    fn each_value_that_is_listed_is_taken_and_shown_and_no_other() {
        for (key, values, _) in plain().keys() {
            let examples = match values {
                Values::OneOf(values) => values.to_vec(),
                Values::Percent => vec!["1", "100"],
                Values::Pixels => vec!["0.5", "off"],
                Values::RouteOr(values) => [values, &["gnomonic-3"]].concat(),
            };
            for value in examples {
                assert!(values.allows(value), "{key}={value}");
                let set = plain().with(key, value);
                let shown = set.settings().into_iter().find(|(own, _)| *own == key);
                assert_eq!(
                    shown.map(|(_, shown)| shown).as_deref(),
                    Some(value),
                    "{key}"
                );
            }
            // Negative control.
            assert!(!values.allows("no such value"), "{key}");
            assert!(plain().set(key, "no such value").is_err(), "{key}");
        }
    }

    #[test]
    fn parts_are_left_out_only_where_that_changes_nothing() {
        let all = plain().with("part-culling", "all");
        let behind = all.check_parts(true).expect_err("counts behind");
        assert!(behind.to_string().contains("zfail"), "{behind}");
        let whole = all.check_parts(false).expect_err("drawn whole");
        assert!(whole.to_string().contains("test flat"), "{whole}");
        // Negative controls: what is outside the view is so for all, and what is hidden for those that count
        // in front.
        let frustum = plain().with("part-culling", "frustum");
        assert_eq!(frustum.check_parts(true), Ok(()));
        let in_front = all.with("depth-rule", "automatic");
        assert_eq!(in_front.check_parts(true), Ok(()));
        assert_eq!(plain().check_parts(false), Ok(()));
    }

    #[test]
    #[should_panic(expected = "test: indices=fan")]
    fn a_wrong_value_in_code_is_noticed() {
        let _ = plain().with("indices", "fan");
    }
}
