// SPDX-License-Identifier: MIT OR Apache-2.0
//! `techniques`: what can fill regions here, with every switch, its values and its default.

use crate::arguments::TechniquesArguments;
use crate::outcome::{Failure, Outcome, print, print_json};
use crate::registry::{RIVALS, TECHNIQUES};
use crate::wrap::wrapped;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use terrafill_contract::Technique;
use terrafill_core::MeshOptions;
use terrafill_report::TermGroup;
use terrafill_results::Term;
use terrafill_scene::{Overlap, choices};
use terrafill_stencil::needs_ablation;
use terrafill_variant::Variant;

/// Switch of the meshes that go into every technique.
pub(crate) const BOUNDARY_TOLERANCE: &str = "boundary-tolerance-m";
/// Every switch of `render` that goes with `variant`'s technique: key, values, and what it decides.
fn switches(variant: &Variant) -> Vec<(&'static str, Vec<&'static str>, &'static str)> {
    let own = variant.keys().into_iter();
    let mut all: Vec<_> = own
        .map(|(key, values, meaning)| (key, values.list(), meaning))
        .collect();
    all.push((
        BOUNDARY_TOLERANCE,
        vec!["METRES"],
        "how far a boundary's chords may lie from its geodesics",
    ));
    all
}

/// What reports call fills, their switches and the steps of their ablations, each with its meaning once.
pub(crate) fn terms() -> Vec<TermGroup> {
    let all = || TECHNIQUES.iter().chain(RIVALS).copied();
    let techniques = all().flat_map(|technique| technique.terms().to_vec());
    let own_switches = all().flat_map(|technique| {
        // A layout stands in names by its value alone.
        let layout = technique.parameters().first().map(|own| own.key);
        let switches = switches(&technique.main(Overlap::Disjoint)).into_iter();
        let switches = switches.filter(move |(key, ..)| Some(*key) != layout);
        switches.map(|(key, _, meaning)| (key, meaning))
    });
    let steps = all().flat_map(|technique| {
        let scenes = [Overlap::Disjoint, Overlap::Ordered].into_iter();
        let steps = scenes.flat_map(move |overlap| {
            let needs = needs_ablation(technique, overlap, true);
            technique.ablation(overlap).into_iter().chain(needs)
        });
        steps.map(|step| (step.name, step.change))
    });
    vec![
        (terrafill_report::TECHNIQUES, distinct(techniques)),
        ("Switches", distinct(own_switches)),
        ("Steps of ablations", distinct(steps)),
    ]
}

fn distinct(terms: impl Iterator<Item = Term>) -> Vec<Term> {
    let terms: BTreeSet<Term> = terms.collect();
    terms.into_iter().collect()
}

/// The keys of the same, in place of one that is none of them.
pub(crate) fn allowed_switches(variant: &Variant, found: &str) -> String {
    let keys = choices(found, switches(variant).into_iter().map(|(key, ..)| key));
    format!("{keys} (all: --list-switches)")
}

/// A switch of `render --set`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Switch {
    key: String,
    /// Its values, or words for them.
    values: Vec<String>,
    /// On scenes whose regions do not overlap.
    default: String,
    /// The same in the technique's full plan, which `render` draws without `--set`; none of a technique without one.
    full_plan: Option<String>,
    /// What it decides, in a line.
    meaning: &'static str,
    /// Whether other techniques lack it.
    own: bool,
}

#[derive(Debug, Serialize)]
struct ListedTechnique {
    name: &'static str,
    api: &'static str,
    /// What it is, in a line.
    meaning: &'static str,
    /// Its pictures differ from the reference by nature.
    approximate: bool,
    switches: Vec<Switch>,
}

impl ListedTechnique {
    fn new(technique: &dyn Technique) -> Self {
        let main = technique.main(Overlap::Disjoint);
        let mut defaults: BTreeMap<&str, String> = main.settings().into_iter().collect();
        let full_plan = technique.full_plans(Overlap::Disjoint).pop();
        let full_plan: BTreeMap<&str, String> =
            full_plan.iter().flat_map(Variant::settings).collect();
        let tolerance_m = MeshOptions::default().boundary_tolerance_m;
        defaults.insert(BOUNDARY_TOLERANCE, tolerance_m.to_string());
        let switches = switches(&main)
            .into_iter()
            .map(|(key, values, meaning)| Switch {
                key: key.to_owned(),
                values: values.into_iter().map(str::to_owned).collect(),
                default: defaults.get(key).cloned().unwrap_or_default(),
                full_plan: full_plan.get(key).cloned(),
                meaning,
                own: technique.parameters().iter().any(|own| own.key == key),
            });
        Self {
            name: technique.name(),
            api: technique.api().name,
            meaning: technique.terms().first().map_or("", |(_, meaning)| meaning),
            approximate: technique.is_approximate(&main),
            switches: switches.collect(),
        }
    }

    fn lines(&self, own: bool) -> String {
        let switches = self.switches.iter().filter(|switch| switch.own == own);
        let lines: Vec<String> = switches.map(Switch::line).collect();
        lines.concat()
    }
}

impl Switch {
    /// What it decides, and below it values and default, in lines of a screen's width.
    fn line(&self) -> String {
        /// Narrower than the 100 columns of help, as values stand behind the key.
        const WIDTH: usize = 70;
        let full_plan = self.full_plan.as_ref();
        let full_plan = full_plan.filter(|value| **value != self.default);
        let full_plan = full_plan.map_or_else(String::new, |value| format!("; full plan {value}"));
        let values = self.values.join("|");
        let values = format!("{values}; default {}{full_plan}", self.default);
        let mut lines = [wrapped(self.meaning, WIDTH), wrapped(&values, WIDTH)].concat();
        lines
            .iter_mut()
            .skip(1)
            .for_each(|line| line.insert_str(0, &format!("\n{:27}", "")));
        format!("    {:<22} {}\n", self.key, lines.concat())
    }
}

fn listed() -> Vec<ListedTechnique> {
    let all = TECHNIQUES.iter();
    all.map(|technique| ListedTechnique::new(*technique))
        .collect()
}

/// Each technique with the switches that it alone has, and those that all have.
pub(crate) fn text() -> String {
    let listed = listed();
    let mut text =
        "default: of a variant that --set names; full plan: of a picture without --set\n"
            .to_owned();
    for technique in &listed {
        text += &format!(
            "{} ({}{})\n    {}\n{}",
            technique.name,
            technique.api,
            if technique.approximate {
                ", approximate"
            } else {
                ""
            },
            wrapped(technique.meaning, 90).join("\n    "),
            technique.lines(true)
        );
    }
    if let Some(first) = listed.first() {
        text += &format!("every technique with volumes\n{}", first.lines(false));
    }
    text += "reference (CPU)\n    texture                on|off, of scenes with a texture; default off\n";
    text
}

pub(crate) fn run(arguments: &TechniquesArguments) -> Result<Outcome, Failure> {
    if arguments.json {
        print_json(&serde_json::json!({ "techniques": listed() }))?;
    } else {
        print(text())?;
    }
    Ok(Outcome::Done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_contract::layouts;

    #[test]
    fn every_switch_is_listed_and_its_default_is_a_value_that_is_read() {
        for (technique, listed) in TECHNIQUES.iter().zip(listed()) {
            let main = technique.main(Overlap::Disjoint);
            let keys: Vec<&str> = listed.switches.iter().map(|s| s.key.as_str()).collect();
            for (key, value) in main.settings() {
                assert!(keys.contains(&key), "{key}");
                assert_eq!(main.clone().set(key, &value), Ok(true), "{key}={value}");
            }
            assert_eq!(keys.len(), main.settings().len() + 1);
            for switch in &listed.switches {
                assert!(!switch.values.is_empty() && !switch.default.is_empty());
                let is_own = technique
                    .parameters()
                    .iter()
                    .any(|own| own.key == switch.key);
                assert_eq!(switch.own, is_own);
            }
        }
        // Negative control: a key that nothing has.
        assert!(!text().contains("    speed "));
    }

    #[test]
    fn what_is_said_of_all_full_plans_is_so_in_each() {
        let shared = |listed: &ListedTechnique| -> Vec<(String, Option<String>)> {
            let switches = listed.switches.iter().filter(|switch| !switch.own);
            let planned = switches.filter(|switch| switch.full_plan.is_some());
            planned
                .map(|switch| (switch.key.clone(), switch.full_plan.clone()))
                .collect()
        };
        let listed = listed();
        let first = shared(&listed[0]);
        let with_plans = listed.iter().map(shared).filter(|own| !own.is_empty());
        assert!(with_plans.clone().count() > 1);
        for own in with_plans {
            assert_eq!(own, first);
        }
        // Negative control: by default they are other ones.
        let switches = listed[0].switches.iter().filter(|switch| !switch.own);
        let planned = switches.filter(|switch| switch.full_plan.as_ref() != Some(&switch.default));
        assert!(planned.count() > 5);
    }

    #[test]
    fn every_technique_and_layout_has_a_line_that_reports_show() {
        let terms = terms();
        let explained = |word: &str| {
            let mut all = terms.iter().flat_map(|(_, terms)| terms);
            all.any(|(own, meaning)| *own == word && !meaning.is_empty())
        };
        for technique in TECHNIQUES.iter().chain(RIVALS) {
            let layouts = layouts(*technique, Overlap::Disjoint);
            let layouts = layouts.iter().map(|variant| variant.layout().to_owned());
            for word in layouts.chain([technique.name().to_owned()]) {
                assert!(explained(&word), "{}: {word}", technique.name());
            }
        }
        assert!(explained("depth-rule") && explained("horizon"));
        // Negative control: a layout that no technique has.
        assert!(!explained("gs-made-up"));
    }

    #[test]
    fn lines_fit_a_screen() {
        for line in text().lines() {
            assert!(line.chars().count() <= 100, "{line}");
        }
    }
}
