// SPDX-License-Identifier: MIT OR Apache-2.0
//! `devices`: what this machine has, what runs on it, and what the rest lack.

use crate::arguments::DevicesArguments;
use crate::outcome::{Failure, Outcome, print, print_json};
use crate::registry;
use serde::Serialize;

/// What one adapter is to each of the two APIs. Both may know adapters that the other does not.
struct Adapter {
    wgpu: Option<terrafill_gpu::DeviceFacts>,
    vulkan: Option<terrafill_vulkan::DeviceFacts>,
}

pub(crate) fn run(arguments: &DevicesArguments) -> Result<Outcome, Failure> {
    let (vulkan, no_vulkan) = match terrafill_vulkan::list_adapters() {
        Ok(adapters) => (adapters, None),
        Err(error) => (Vec::new(), Some(error)),
    };
    let adapters = paired(terrafill_gpu::list_adapters(), vulkan);
    let devices: Vec<Device> = adapters.iter().filter_map(Device::new).collect();
    if arguments.json {
        print_json(&serde_json::json!({ "devices": devices }))?;
    } else {
        let texts: Vec<String> = devices.iter().map(Device::text).collect();
        let reference = "CPU\n    reference  runs; needs no device\n";
        print(reference.to_owned() + &texts.concat())?;
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

/// A feature that a technique can do without, and what becomes of it then.
type Feature = (bool, &'static str, &'static str);

const TIMESTAMPS: &str = "GPU timestamps";
const STATISTICS: &str = "pipeline statistics";

/// Whether techniques of one interface run on a device.
#[derive(Debug, Clone, Serialize)]
struct Verdict {
    runs: bool,
    /// Why not; `None` where they run.
    reason: Option<String>,
    /// Optional features that are there.
    has: Vec<&'static str>,
    /// Those that are not, with what becomes of it.
    lacks: Vec<Lack>,
}

#[derive(Debug, Clone, Serialize)]
struct Lack {
    feature: &'static str,
    consequence: &'static str,
}

impl Verdict {
    fn new(needs: &[String], features: &[Feature]) -> Self {
        if !needs.is_empty() {
            return Self::none(format!("lacks {}", needs.join(", ")));
        }
        let has = features.iter().filter(|(has, ..)| *has);
        let lacks = features.iter().filter(|(has, ..)| !has);
        Self {
            runs: true,
            reason: None,
            has: has.map(|(_, feature, _)| *feature).collect(),
            lacks: lacks
                .map(|&(_, feature, consequence)| Lack {
                    feature,
                    consequence,
                })
                .collect(),
        }
    }

    fn none(reason: String) -> Self {
        Self {
            runs: false,
            reason: Some(reason),
            has: Vec::new(),
            lacks: Vec::new(),
        }
    }

    /// `runs, with …; lacks …` or `cannot run; lacks …`.
    fn text(&self) -> String {
        if let Some(reason) = &self.reason {
            return format!("cannot run; {reason}");
        }
        let mut text = "runs".to_owned();
        if !self.has.is_empty() {
            text += &format!(", with {}", self.has.join(", "));
        }
        for lack in &self.lacks {
            text += &format!(
                "\n               lacks {}: {}",
                lack.feature, lack.consequence
            );
        }
        text
    }
}

fn wgpu_verdict(facts: &terrafill_gpu::DeviceFacts) -> Verdict {
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
    Verdict::new(&facts.lacks, &features)
}

fn vulkan_verdict(facts: &terrafill_vulkan::DeviceFacts) -> Verdict {
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
        (has.depth_bounds, "depth bounds", "shadows go without"),
        (
            has.blends_float,
            "blending of R32_SFLOAT",
            "no colour=id-accumulation",
        ),
        (has.samples_depth, "depth read in shaders", "no texture="),
    ];
    Verdict::new(&facts.lacks, &features)
}

/// A device as it is listed.
#[derive(Debug, Serialize)]
struct Device {
    name: String,
    #[serde(rename = "type")]
    device_type: &'static str,
    driver: String,
    driver_info: String,
    techniques: Vec<OnDevice>,
}

/// A technique on a device.
#[derive(Debug, Serialize)]
struct OnDevice {
    name: &'static str,
    api: &'static str,
    #[serde(flatten)]
    verdict: Verdict,
}

impl Device {
    fn new(adapter: &Adapter) -> Option<Self> {
        let wgpu = adapter.wgpu.as_ref();
        let by_wgpu = wgpu.map(|f| (&f.name, f.device_type, &f.driver, &f.driver_info));
        let vulkan = adapter.vulkan.as_ref();
        let by_vulkan = vulkan.map(|f| (&f.name, f.device_type, &f.driver, &f.driver_info));
        let (name, device_type, driver, driver_info) = by_wgpu.or(by_vulkan)?;
        let unlisted = |reason: &str| Verdict::none(reason.to_owned());
        let on_wgpu = wgpu.map_or(unlisted("wgpu does not list this device"), wgpu_verdict);
        let on_vulkan = vulkan.map_or(
            unlisted("the Vulkan loader does not list this device"),
            vulkan_verdict,
        );
        let techniques = registry::TECHNIQUES.iter().filter_map(|technique| {
            let verdict = match technique.api() {
                terrafill_gpu::API => on_wgpu.clone(),
                terrafill_vulkan::API => on_vulkan.clone(),
                _ => return None,
            };
            Some(OnDevice {
                name: technique.name(),
                api: technique.api().name,
                verdict,
            })
        });
        Some(Self {
            name: name.clone(),
            device_type,
            driver: driver.clone(),
            driver_info: driver_info.clone(),
            techniques: techniques.collect(),
        })
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{} ({})\n    driver     {} {}\n",
            self.name, self.device_type, self.driver, self.driver_info
        );
        for technique in &self.techniques {
            text += &format!("    {:<10} {}\n", technique.name, technique.verdict.text());
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_vulkan::Features;

    fn wgpu_facts(name: &str) -> terrafill_gpu::DeviceFacts {
        terrafill_gpu::DeviceFacts {
            name: name.to_owned(),
            device_type: "cpu",
            vendor_id: 0,
            device_id: 0,
            driver: "d".to_owned(),
            driver_info: "1".to_owned(),
            driver_uuid: String::new(),
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
            driver_uuid: String::new(),
            features: Features {
                geometry_shader: true,
                tessellation: true,
                pipeline_statistics: true,
                occlusion_query_precise: true,
                depth_bounds: true,
                depth_clamp: true,
                timestamps: true,
                blends_float: true,
                samples_depth: true,
                mesh_shader: true,
                task_shader: false,
                max_views: 0,
                vertex_layer: false,
                transform_feedback: true,
                ray_query: true,
                draws_listed: true,
                image_arrays: true,
            },
            lacks: Vec::new(),
        }
    }

    fn describe(adapter: &Adapter) -> String {
        Device::new(adapter).expect("a device").text()
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
            "lacks depth bounds: shadows go without",
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
