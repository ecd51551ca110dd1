// SPDX-License-Identifier: MIT OR Apache-2.0
//! One optimisation after the other, each on top of those before, and what each costs.
//!
//! Writes of the stencil are counted along the rays of pixels, as a device with this step would make them.

use crate::count::Rule;
use crate::device::Interface;
use crate::near::EyeTest;
use crate::reference::Reference;
use crate::scissor::{Rectangle, depths_of_parts, of_parts};
use crate::way::{Bounds, Counting, Cut, DeviceWay, Positions, Silhouettes};
use crate::work::{BOUNDS_SHARE, End, Pass, Scene};
use terrafill_casters::{EdgeTable, Side, Volume};
use terrafill_contract::CpuStopwatch;
use terrafill_variant::FacePasses;

/// A step: what it adds, and what the paper says of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StencilStep {
    pub(crate) number: usize,
    pub(crate) name: &'static str,
    /// Of Yang & Jin (2006).
    pub(crate) paper: &'static str,
    pub(crate) way: DeviceWay,
    /// Volumes are found once for a sun instead of each frame.
    pub(crate) is_kept: bool,
}

const NOT_SAID: &str = "not in the paper";
const ANTICIPATED: &str = "anticipated: faster";

/// From the bottom.
pub(crate) fn steps(interface: Interface) -> Vec<StencilStep> {
    let mut way = DeviceWay {
        interface,
        silhouettes: Silhouettes::EachTriangle,
        positions: Positions::Eye,
        end: End::Infinite,
        rule: Rule::Fail,
        faces: FacePasses::TwoPass,
        cut: Cut::Off,
        counting: Counting::Casters,
        bounds: Bounds::Off,
    };
    let mut steps = Vec::new();
    let mut add = |name, paper, way: DeviceWay, is_kept| {
        steps.push(StencilStep {
            number: steps.len() + 1,
            name,
            paper,
            way,
            is_kept,
        });
    };
    add("each triangle", NOT_SAID, way, false);
    way.silhouettes = Silhouettes::Adjacency;
    add("silhouette", ANTICIPATED, way, false);
    way.faces = FacePasses::TwoSided;
    add("two-sided", ANTICIPATED, way, false);
    way.counting = Counting::Chosen(EyeTest::Exact);
    add(
        "rule by part",
        "anticipated: faster, by the frame",
        way,
        false,
    );
    way.cut = Cut::Culled;
    add("casters left out", "named, no method given", way, false);
    way.cut = Cut::Rectangle;
    add(
        "rectangles",
        "anticipated: faster, one at the horizon",
        way,
        false,
    );
    way.end = End::Sea;
    add("closed at the sea", NOT_SAID, way, false);
    add("volumes kept", NOT_SAID, way, true);
    way.bounds = Bounds::Native;
    add("depth bounds", ANTICIPATED, way, true);
    steps
}

impl Scene {
    /// Every triangle that casts a volume of its own.
    pub(crate) fn volume_of_each_triangle(&self, end: End) -> Result<Volume, String> {
        let mut sides: Vec<Side> = Vec::new();
        for (at, &[a, b, c]) in self.mesh().triangles.iter().enumerate() {
            if self.is_lit(at) {
                sides.extend([[a, b], [b, c], [c, a]]);
            } else if self.is_robust() {
                // Turned to the light, as its cap is.
                sides.extend([[a, c], [c, b], [b, a]]);
            }
        }
        self.volume_of(&sides, end)
    }

    fn found(&self, way: DeviceWay, table: &EdgeTable) -> Result<Volume, String> {
        match way.silhouettes {
            Silhouettes::EachTriangle => self.volume_of_each_triangle(way.end),
            _ => self.volume_of(&self.sides_by(table), way.end),
        }
    }

    /// Process CPU time of finding the volumes of a way; adjacency is there already.
    pub(crate) fn time_volumes(&self, way: DeviceWay, table: &EdgeTable) -> Result<f64, String> {
        let watch = CpuStopwatch::start();
        let volume = self.found(way, table)?;
        let cpu_ms = watch.cpu_ms();
        // A volume that nobody looks at might never be made.
        Ok(if volume.triangles.is_empty() {
            0.0
        } else {
            cpu_ms
        })
    }

    /// Stencil writes over all channels.
    pub(crate) fn writes_of(&self, way: DeviceWay) -> Result<u64, String> {
        let mesh = self.mesh();
        let volume = self.found(way, &EdgeTable::of(mesh))?;
        let closed = match way.cut {
            Cut::Off => None,
            _ => Some(self.volume(End::Sea)?),
        };
        let reference = Reference::new(mesh, self.to_light);
        let mut caster_of = vec![0; mesh.parts.len()];
        for (at, caster) in mesh.casters.iter().enumerate() {
            caster_of[caster.parts.clone()].fill(at);
        }
        let drawn = self.draw_by(&volume, |view, _| {
            let fails = match way.counting {
                Counting::Chosen(test) => self.fails(test, view, &reference),
                _ => vec![way.rule == Rule::Fail; mesh.parts.len()],
            };
            // What is drawn together has a rectangle and a range of depth together: parts of a caster by rule.
            let group = |part: usize| 2 * caster_of[part] + usize::from(fails[part]);
            let mut rectangles = vec![Rectangle::NONE; 2 * mesh.casters.len()];
            if let Some(closed) = &closed {
                let parts = of_parts(view, closed, mesh.parts.len());
                for (part, own) in parts.into_iter().enumerate() {
                    rectangles[group(part)] = rectangles[group(part)].or(own);
                }
            }
            let whole = Rectangle::whole(view);
            let rectangle = |part: usize| match way.cut {
                Cut::Off => Some(whole),
                Cut::Culled => (!rectangles[group(part)].is_empty()).then_some(whole),
                Cut::Rectangle => Some(rectangles[group(part)]),
            };
            let bounds = match way.bounds {
                Bounds::Off => Vec::new(),
                _ => {
                    let parts = depths_of_parts(view, &volume, mesh.parts.len(), BOUNDS_SHARE);
                    let none = [f64::INFINITY, f64::NEG_INFINITY];
                    let mut groups = vec![none; 2 * mesh.casters.len()];
                    for (part, [low, high]) in parts.iter().enumerate() {
                        let own = &mut groups[group(part)];
                        *own = [own[0].min(*low), own[1].max(*high)];
                    }
                    (0..parts.len()).map(|part| groups[group(part)]).collect()
                }
            };
            let part = |part: usize| {
                let rule = if fails[part] { Rule::Fail } else { Rule::Pass };
                rectangle(part).map(|own| (rule, own))
            };
            let parts = (0..fails.len()).map(part).collect();
            vec![Pass { parts, bounds }]
        });
        Ok(drawn.updates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Truth;
    use crate::view::DeckCamera;

    #[test]
    fn silhouettes_rules_and_depth_bounds_write_less_and_the_other_steps_as_much() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        let steps = steps(Interface::Wgpu);
        let writes: Vec<u64> = steps
            .iter()
            .map(|step| scene.writes_of(step.way).expect("above"))
            .collect();
        let of = |name: &str| {
            let at = steps.iter().position(|step| step.name == name);
            writes[at.expect("a step")]
        };
        // Shared edges of lit triangles are sides twice.
        assert!(of("each triangle") > of("silhouette"), "{writes:?}");
        assert_eq!(of("two-sided"), of("silhouette"), "saves no fill");
        assert!(of("rule by part") < of("two-sided"), "{writes:?}");
        // From the bridge every part is z-pass by then: what is left out would write nothing.
        assert_eq!(of("rectangles"), of("casters left out"));
        assert_eq!(of("closed at the sea"), of("rectangles"));
        assert_eq!(of("volumes kept"), of("closed at the sea"));
        assert!(of("depth bounds") < of("volumes kept"), "{writes:?}");
    }

    #[test]
    fn volumes_of_each_triangle_have_the_mask_of_silhouettes_and_one_side_less_has_not() {
        let scene = Scene::new([10.0, -60.0], [32, 24]).expect("a port");
        for end in [End::Infinite, End::Sea] {
            let mut volume = scene.volume_of_each_triangle(end).expect("above");
            assert_eq!(volume.open_edges(), [] as [Side; 0]);
            let wrong = |volume: &Volume| {
                let whole = |view: &DeckCamera, _: &Truth| vec![scene.whole(view, Rule::Fail)];
                scene.draw_by(volume, whole).wrong
            };
            assert_eq!(wrong(&volume).outside(), 0);
            let caps = volume.triangles.len() / 4;
            volume.triangles.truncate(volume.triangles.len() - caps);
            assert!(wrong(&volume).outside() > 0);
        }
    }
}
