// SPDX-License-Identifier: MIT OR Apache-2.0
//! One optimisation after the other, each on top of those before, and what each costs.
//!
//! Writes of the stencil are counted along the rays of pixels, as a device with this step would make them.

use crate::way::{Bounds, Counting, Cut, DeviceWay, Silhouettes};
use crate::work::{BOUNDS_SHARE, End, Scene};
use terrafill_casters::{EdgeTable, Side, Volume};
use terrafill_contract::CpuStopwatch;
use terrafill_shadow_views::{
    EyeTest, Interface, Pass, Reference, Rule, depths_of_parts, of_parts,
};
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
        silhouettes: Silhouettes::EachTriangle,
        end: End::Infinite,
        faces: FacePasses::TwoPass,
        ..DeviceWay::plain(interface)
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

/// All that can be drawn by every device: the step before depth bounds.
pub(crate) fn optimised(interface: Interface) -> Option<DeviceWay> {
    let steps = steps(interface).into_iter();
    let mut without = steps.filter(|step| step.way.bounds == Bounds::Off);
    without.next_back().map(|step| step.way)
}

impl Scene {
    /// Every triangle that casts a volume of its own.
    pub(crate) fn volume_of_each_triangle(&self, end: End) -> Result<Volume, String> {
        let mut sides: Vec<Side> = Vec::new();
        for (at, &[a, b, c]) in self.mesh().triangles.iter().enumerate() {
            if self.is_lit(at) {
                sides.extend([[a, b], [b, c], [c, a]]);
            } else if self.prepared.is_robust {
                // Turned to the light, as its cap is.
                sides.extend([[a, c], [c, b], [b, a]]);
            }
        }
        self.volume_of(&sides, end)
    }

    fn found(&self, way: DeviceWay, table: &EdgeTable) -> Result<Volume, String> {
        match way.silhouettes {
            Silhouettes::EachTriangle => self.volume_of_each_triangle(way.end),
            // Found anew.
            _ => self.volume_of(&table.sides(&self.prepared, &self.facing), way.end),
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
            Cut::Off | Cut::SeaLevel => None,
            Cut::Culled | Cut::Rectangle => Some(self.volume(End::Sea)?),
        };
        let reference = Reference::new(mesh, self.to_light);
        let count = mesh.parts.len();
        let drawn = self.draw_by(&volume, |view, _| {
            let rectangles = closed.as_ref().map(|closed| of_parts(view, closed, count));
            let depths = depths_of_parts(view, &volume, count, BOUNDS_SHARE);
            let (mut parts, mut bounds) = (vec![None; count], vec![[0.0; 2]; count]);
            let above_sea = self.above_sea(way, view);
            // What is drawn together has a rectangle and a range of depth together: parts of a caster by rule.
            for group in self.groups(way, view, &reference) {
                let rule = match (way.counting.test(), group.is_near) {
                    (Some(_), true) => Rule::Fail,
                    (Some(_), false) => Rule::Pass,
                    (None, _) => way.rule,
                };
                let rectangle = group.rectangle(way, view, rectangles.as_deref(), above_sea);
                let ranges = group.parts.iter().map(|part| depths[*part]);
                let range = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
                for part in group.parts {
                    parts[part] = rectangle.map(|own| (rule, own));
                    bounds[part] = range.unwrap_or_default();
                }
            }
            if way.bounds == Bounds::Off {
                bounds.clear();
            }
            vec![Pass { parts, bounds }]
        });
        Ok(drawn.updates)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_shadow_views::{DeckCamera, Truth};

    #[test]
    fn silhouettes_rules_and_depth_bounds_write_less_and_the_other_steps_as_much() {
        let scene = Scene::new([10.0, -60.0], [64, 48]).expect("a port");
        let steps = steps(Interface::Wgpu);
        let writes = steps.iter().map(|step| scene.writes_of(step.way));
        let writes: Vec<u64> = writes.map(|writes| writes.expect("above")).collect();
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
