// SPDX-License-Identifier: MIT OR Apache-2.0
//! `scenes` and `devices`: what there is.

use crate::arguments::{ScenesArguments, StudiesArguments};
use crate::outcome::{Failure, Outcome, print};
use crate::registry;
use crate::registry::STUDIES;
use terrafill_results::MetricRow;
use terrafill_scene::{Scene, SceneError, data_dir_from_env, shipped_scene_names};

pub(crate) fn scenes(arguments: &ScenesArguments) -> Result<Outcome, Failure> {
    let data = arguments.data.clone().or_else(data_dir_from_env);
    let mut text = String::new();
    for name in shipped_scene_names() {
        match Scene::shipped(name, data.as_deref()) {
            Ok(scene) => {
                let views: Vec<&str> = scene.views.iter().map(|view| view.name.as_str()).collect();
                let vertices: usize = scene.regions.iter().map(|r| r.vertex_count()).sum();
                text += &format!(
                    "{name}\n    {}\n    {} · {} edges · {} regions, {vertices} vertices · views {}\n",
                    scene.description,
                    scene.body.name(),
                    scene.edge_rule.name(),
                    scene.regions.len(),
                    views.join(", ")
                );
            }
            Err(SceneError::DataMissing {
                file,
                sha256,
                why,
                how,
                ..
            }) => {
                text += &format!(
                    "{name}\n    skipped: {why}\n    needs {file}\n    sha256 {sha256}\n    {how}\n"
                );
            }
            Err(error) => text += &format!("{name}\n    not available: {error}\n"),
        }
    }
    print(&text);
    Ok(Outcome::Done)
}

pub(crate) fn studies(arguments: &StudiesArguments) -> Result<Outcome, Failure> {
    if arguments.json {
        let studies: Vec<serde_json::Value> = STUDIES
            .iter()
            .map(|study| {
                let metrics: Vec<MetricRow> = study.metrics().iter().map(MetricRow::from).collect();
                serde_json::json!({
                    "name": study.name(),
                    "question": study.question(),
                    "metrics": metrics,
                })
            })
            .collect();
        let text = serde_json::to_string_pretty(&serde_json::json!({ "studies": studies }));
        print(&(text.map_err(Failure::bad_input)? + "\n"));
        return Ok(Outcome::Done);
    }
    if arguments.markdown {
        print(&metrics_as_markdown());
        return Ok(Outcome::Done);
    }
    for study in STUDIES {
        let metrics = study.metrics().len();
        print(&format!(
            "{}\n    {}\n    {metrics} metrics\n",
            study.name(),
            study.question()
        ));
    }
    Ok(Outcome::Done)
}

/// A table of each study's metrics: the generated part of GLOSSARY.md.
fn metrics_as_markdown() -> String {
    let mut text = String::new();
    for study in STUDIES {
        text += &format!(
            "\n### Study `{}`\n\n{}\n\n| metric | unit | kind | better | meaning |\n|---|---|---|---|---|\n",
            study.name(),
            study.question()
        );
        for metric in study.metrics() {
            let kind = metric.kind.name();
            let better = format!("{:?}", metric.better).to_lowercase();
            text += &format!(
                "| `{}` | {} | {kind} | {better} | {} |\n",
                metric.name, metric.unit, metric.meaning
            );
        }
    }
    text
}

/// What one adapter is to each of the two APIs. Both may know adapters that the other does not.
struct Adapter {
    wgpu: Option<terrafill_gpu::DeviceFacts>,
    vulkan: Option<terrafill_vulkan::DeviceFacts>,
}

pub(crate) fn devices() -> Result<Outcome, Failure> {
    print("CPU\n    reference  runs; needs no device\n");
    let (vulkan, no_vulkan) = match terrafill_vulkan::list_adapters() {
        Ok(adapters) => (adapters, None),
        Err(error) => (Vec::new(), Some(error)),
    };
    let adapters = paired(terrafill_gpu::list_adapters(), vulkan);
    for adapter in &adapters {
        print(&describe(adapter));
    }
    if adapters.is_empty() {
        let why = no_vulkan.map_or(String::new(), |error| format!(" ({error})"));
        return Err(Failure::no_device(format!(
            "no Vulkan device, which {} need{why}; ci/setup.sh installs a software one",
            registry::names().join(", ")
        )));
    }
    Ok(if adapters.iter().any(Adapter::runs_something) {
        Outcome::Done
    } else {
        Outcome::NoDevice
    })
}

/// Lays the lists side by side, in the first one's order. Of several adapters of one kind the first
/// of one list is the first of the other: both keep the loader's order.
fn paired(
    wgpu: Vec<terrafill_gpu::DeviceFacts>,
    mut vulkan: Vec<terrafill_vulkan::DeviceFacts>,
) -> Vec<Adapter> {
    let mut adapters = Vec::new();
    for facts in wgpu {
        let is_same = |other: &terrafill_vulkan::DeviceFacts| {
            (&facts.name, facts.vendor_id, facts.device_id)
                == (&other.name, other.vendor_id, other.device_id)
        };
        let place = vulkan.iter().position(is_same);
        adapters.push(Adapter {
            vulkan: place.map(|place| vulkan.remove(place)),
            wgpu: Some(facts),
        });
    }
    adapters.extend(vulkan.into_iter().map(|facts| Adapter {
        wgpu: None,
        vulkan: Some(facts),
    }));
    adapters
}

impl Adapter {
    fn runs_something(&self) -> bool {
        let by_wgpu = self.wgpu.as_ref().map(|facts| &facts.lacks);
        let by_vulkan = self.vulkan.as_ref().map(|facts| &facts.lacks);
        let mut lacks = by_wgpu.into_iter().chain(by_vulkan);
        lacks.any(Vec::is_empty)
    }
}

/// A feature that a backend can do without, and what becomes of it then.
type Feature = (bool, &'static str, &'static str);

const TIMESTAMPS: &str = "GPU timestamps";
const STATISTICS: &str = "pipeline statistics";

/// `runs, with …; lacks …` or `cannot run; lacks …`.
fn verdict(lacks: &[String], features: &[Feature]) -> String {
    if !lacks.is_empty() {
        return format!("cannot run; lacks {}", lacks.join(", "));
    }
    let has = features.iter().filter(|(has, ..)| *has);
    let has: Vec<&str> = has.map(|(_, what, _)| *what).collect();
    let mut text = "runs".to_owned();
    if !has.is_empty() {
        text += &format!(", with {}", has.join(", "));
    }
    for (_, what, then) in features.iter().filter(|(has, ..)| !has) {
        text += &format!("\n               lacks {what}: {then}");
    }
    text
}

fn wgpu_verdict(facts: &terrafill_gpu::DeviceFacts) -> String {
    let features = [
        (
            facts.features.timestamps,
            TIMESTAMPS,
            "GPU times stay empty",
        ),
        (
            facts.features.pipeline_statistics,
            STATISTICS,
            "invocation counts stay empty",
        ),
    ];
    verdict(&facts.lacks, &features)
}

fn vulkan_verdict(facts: &terrafill_vulkan::DeviceFacts) -> String {
    let has = facts.features;
    let features = [
        (
            has.geometry_shader,
            "geometry shaders",
            "only technique=vs-control runs",
        ),
        (has.timestamps, TIMESTAMPS, "GPU times stay empty"),
        (
            has.pipeline_statistics,
            STATISTICS,
            "invocation counts stay empty",
        ),
        (has.depth_bounds, "depth bounds", "no depth-bounds=on"),
        (
            has.blends_float,
            "blending of R32_SFLOAT",
            "no colour=id-accumulation",
        ),
        (has.samples_depth, "depth read in shaders", "no texture="),
    ];
    verdict(&facts.lacks, &features)
}

fn describe(adapter: &Adapter) -> String {
    let wgpu = adapter.wgpu.as_ref();
    let by_wgpu = wgpu.map(|f| (&f.name, f.device_type, &f.driver, &f.driver_info));
    let vulkan = adapter.vulkan.as_ref();
    let by_vulkan = vulkan.map(|f| (&f.name, f.device_type, &f.driver, &f.driver_info));
    let Some((name, device_type, driver, driver_info)) = by_wgpu.or(by_vulkan) else {
        return String::new();
    };
    let on_wgpu = wgpu.map_or(
        "cannot run; wgpu does not list this device".to_owned(),
        wgpu_verdict,
    );
    let on_vulkan = vulkan.map_or(
        "cannot run; the Vulkan loader does not list this device".to_owned(),
        vulkan_verdict,
    );
    let mut text = format!("{name} ({device_type})\n    driver     {driver} {driver_info}\n");
    for technique in registry::TECHNIQUES {
        let verdict = match technique.api() {
            terrafill_gpu::API => &on_wgpu,
            terrafill_vulkan::API => &on_vulkan,
            _ => continue,
        };
        text += &format!("    {:<10} {verdict}\n", technique.name());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines around the generated part of GLOSSARY.md.
    const GENERATED: [&str; 2] = [
        "<!-- generated: terrafill studies --markdown -->\n",
        "<!-- end of the generated part -->\n",
    ];

    /// The generated part of a glossary.
    fn generated(glossary: &str) -> Option<&str> {
        let (_, rest) = glossary.split_once(GENERATED[0])?;
        rest.split_once(GENERATED[1]).map(|(part, _)| part)
    }

    #[test]
    fn the_glossary_has_every_metric_as_it_is_declared() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../GLOSSARY.md");
        let glossary = std::fs::read_to_string(path).expect("GLOSSARY.md");
        let expected = metrics_as_markdown();
        assert!(
            generated(&glossary) == Some(&expected),
            "GLOSSARY.md is not what `terrafill studies --markdown` prints: paste it there"
        );
        // Twins: a word that was changed by hand, and a glossary without the part.
        let edited = glossary.replacen("| counter |", "| number |", 1);
        assert!(generated(&edited) != Some(&expected));
        assert_eq!(generated("# Glossary\n"), None);
    }
    use terrafill_vulkan::Features;

    fn wgpu_facts(name: &str) -> terrafill_gpu::DeviceFacts {
        terrafill_gpu::DeviceFacts {
            name: name.to_owned(),
            device_type: "cpu",
            vendor_id: 0,
            device_id: 0,
            driver: "d".to_owned(),
            driver_info: "1".to_owned(),
            features: terrafill_gpu::Features {
                timestamps: true,
                pipeline_statistics: true,
            },
            lacks: Vec::new(),
        }
    }

    fn vulkan_facts(name: &str) -> terrafill_vulkan::DeviceFacts {
        terrafill_vulkan::DeviceFacts {
            name: name.to_owned(),
            device_type: "cpu",
            vendor_id: 0,
            device_id: 0,
            driver: "d".to_owned(),
            driver_info: "1".to_owned(),
            features: Features {
                geometry_shader: true,
                pipeline_statistics: true,
                occlusion_query_precise: true,
                depth_bounds: true,
                depth_clamp: true,
                timestamps: true,
                blends_float: true,
                samples_depth: true,
            },
            lacks: Vec::new(),
        }
    }

    fn adapter() -> Adapter {
        Adapter {
            wgpu: Some(wgpu_facts("D")),
            vulkan: Some(vulkan_facts("D")),
        }
    }

    #[test]
    fn what_a_device_lacks_is_said() {
        let text = describe(&adapter());
        assert!(
            !text.contains("lacks") && !text.contains("cannot"),
            "{text}"
        );
        for backend in ["vertex ", "compute", "native "] {
            assert!(
                text.contains(&format!("    {backend}    runs, with ")),
                "{text}"
            );
        }
        let mut without = adapter();
        if let Some(facts) = &mut without.wgpu {
            facts.features.timestamps = false;
        }
        if let Some(facts) = &mut without.vulkan {
            facts.features.geometry_shader = false;
            facts.features.depth_bounds = false;
        }
        let text = describe(&without);
        for phrase in [
            "lacks GPU timestamps: GPU times stay empty",
            "lacks geometry shaders: only technique=vs-control runs",
            "lacks depth bounds: no depth-bounds=on",
        ] {
            assert!(text.contains(phrase), "{phrase:?} is not in {text}");
        }
        assert!(without.runs_something());
    }

    #[test]
    fn each_backend_runs_or_not_by_its_own_api() {
        let mut adapter = adapter();
        let lacks = || vec!["Depth32FloatStencil8".to_owned(), "another".to_owned()];
        if let Some(facts) = &mut adapter.wgpu {
            facts.lacks = lacks();
        }
        let text = describe(&adapter);
        for line in [
            "    vertex     cannot run; lacks Depth32FloatStencil8, another\n",
            "    compute    cannot run; lacks Depth32FloatStencil8, another\n",
            "    native     runs, with geometry shaders, ",
        ] {
            assert!(text.contains(line), "{line:?} is not in {text}");
        }
        assert!(adapter.runs_something());
        if let Some(facts) = &mut adapter.vulkan {
            facts.lacks = lacks();
        }
        assert!(describe(&adapter).contains("native     cannot run; lacks Depth32"));
        assert!(!adapter.runs_something());
    }

    #[test]
    fn adapters_of_both_apis_are_paired_by_what_they_are() {
        let wgpu = ["A", "B", "A"].map(wgpu_facts).into();
        let mut second = vulkan_facts("A");
        second.features.depth_bounds = false;
        let mut other_vendor = vulkan_facts("B");
        other_vendor.vendor_id = 1;
        let vulkan = vec![other_vendor, vulkan_facts("A"), second];
        let adapters = paired(wgpu, vulkan);
        let has_bounds =
            |adapter: &Adapter| adapter.vulkan.as_ref().map(|f| f.features.depth_bounds);
        let found: Vec<_> = adapters.iter().map(has_bounds).collect();
        assert_eq!(found, [Some(true), None, Some(false), Some(true)]);
        assert!(describe(&adapters[1]).contains("native     cannot run; the Vulkan loader"));
        assert!(adapters[3].wgpu.is_none());
        assert!(describe(&adapters[3]).contains("vertex     cannot run; wgpu does not list"));
    }
}
