// SPDX-License-Identifier: MIT OR Apache-2.0
//! Level of detail by counted pixels (Gebbie and Bailey, occlusion queries), drawn and counted on devices. A quadtree
//! over a large picture splits and merges by counts that are some frames old.

pub(crate) mod course;
pub(crate) mod device;
pub(crate) mod scene;
mod section;

pub(crate) use section::{SECTION, why_not_settled};

use crate::STUDY;
use crate::list::List;
use crate::metrics::{self, API, COUNTED_BY, DELAY, HYSTERESIS, PATH, SIZE_PX};
use course::{CountedFrame, Course};
use device::{Counters, NODE_TEXELS, PixelCount, SIDE_PX};
use scene::Picture;
use std::collections::BTreeMap;
use terrafill_globe_views::Eye;
use terrafill_maps::{Node, Quadtree, Thresholds};
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged, verified};

/// Name of this part in cases.
pub(crate) const PART: &str = "counts";

/// Frames in which a loop comes to rest or does not.
const FRAMES: usize = 48;
/// Frames of the zoom.
const ZOOM_FRAMES: usize = 60;
/// Heights between which it goes, metres.
const ZOOM_M: [f64; 2] = [8e6, 1e5];
/// Nodes are split no further.
const MAX_LEVEL: u32 = 8;
/// Views that stand still.
const VIEWS: [&str; 4] = ["globe", "nadir-1161km", "oblique-100km", "horizon-2km"];
const HYSTERESES: [f64; 4] = [1.0, 2.0, 4.0, 6.0];
/// Frames from drawing to using a count; the paper's is 1, and 2 or 3 are what mapping a buffer back takes.
const DELAYS: [usize; 2] = [1, 3];
/// The hysteresis at which a still view has no cycle: a split divides the mean by 4.
const ENOUGH: f64 = 4.0;

/// What the eye does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Path {
    Still(&'static str),
    Zoom,
}

#[derive(Debug, Clone, Copy)]
struct Work {
    path: Path,
    way: PixelCount,
    hysteresis: f64,
    delay: usize,
}

/// All work on counts of vertices and pixels, as one group of cases.
pub(crate) struct Counts {
    work: Vec<Work>,
    list: List,
}

impl Counts {
    pub(crate) fn planned(list: &List, is_quick: bool, samples: u32) -> CaseGroup<Self> {
        let mut work = Vec::new();
        let views = VIEWS.iter().take(if is_quick { 2 } else { VIEWS.len() });
        for view in views {
            for way in PixelCount::ALL {
                for hysteresis in HYSTERESES {
                    work.extend(DELAYS.map(|delay| Work {
                        path: Path::Still(view),
                        way,
                        hysteresis,
                        delay,
                    }));
                }
            }
        }
        for way in PixelCount::ALL {
            work.push(Work {
                path: Path::Zoom,
                way,
                hysteresis: ENOUGH,
                delay: 1,
            });
        }
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: work.iter().map(|work| case(work, samples)).collect(),
            warm_up: None,
            work: Self {
                work,
                list: list.clone(),
            },
            open: |group, context| {
                let part = CountPart::new(&group.work, context);
                Ok(Box::new(JudgedOnce::new(part)))
            },
        }
    }

    fn eye(&self, work: &Work, frame: usize) -> Result<Eye, String> {
        let view = match work.path {
            Path::Still(view) => view,
            Path::Zoom => VIEWS[0],
        };
        let mut row = self.list.view(view)?.clone();
        if work.path == Path::Zoom {
            let share = frame as f64 / ZOOM_FRAMES as f64;
            row.height_m = ZOOM_M[0] * (ZOOM_M[1] / ZOOM_M[0]).powf(share.min(1.0));
        }
        Ok(row.eye(SIDE_PX))
    }
}

fn case(work: &Work, samples: u32) -> PlannedCase {
    let path = match work.path {
        Path::Still(view) => view,
        Path::Zoom => "zoom",
    };
    let [api, way] = work.way.names();
    let conditions = [
        (metrics::PART, PART.to_owned()),
        (PATH, path.to_owned()),
        (API, api.to_owned()),
        (COUNTED_BY, way.to_owned()),
        (HYSTERESIS, work.hysteresis.to_string()),
        (DELAY, work.delay.to_string()),
        (SIZE_PX, SIDE_PX.to_string()),
    ];
    let name = format!(
        "{PART}/{path}/{way}/hysteresis={}/delay={}",
        work.hysteresis, work.delay
    );
    PlannedCase {
        id: CaseId::new(STUDY, name, conditions),
        samples,
        may_be_wrong: false,
    }
}

struct CountPart<'a> {
    group: &'a Counts,
    counters: Counters<'a>,
    /// The last frame of each case.
    last: BTreeMap<usize, CountedFrame>,
}

/// A loop.
#[derive(Debug, Clone, Default)]
struct Counted {
    course: Course,
    /// Pixels of all nodes in the last frame.
    pixels: u64,
}

impl<'a> CountPart<'a> {
    fn new(group: &'a Counts, context: Context<'a>) -> Self {
        Self {
            group,
            counters: Counters::new(context.devices),
            last: BTreeMap::new(),
        }
    }

    fn run(&mut self, case: usize) -> Result<Counted, Failure> {
        let work = self.group.work[case];
        let frames = match work.path {
            Path::Still(_) => FRAMES,
            Path::Zoom => ZOOM_FRAMES,
        };
        let first = self.group.eye(&work, 0)?;
        let mut picture = Picture::below(&first);
        let texels = f64::from(NODE_TEXELS * NODE_TEXELS);
        let thresholds = Thresholds::new(texels, work.hysteresis);
        let mut tree = Quadtree::new(MAX_LEVEL);
        // Of each leaf, the frame in which it was first drawn.
        let mut since: BTreeMap<Node, usize> = BTreeMap::new();
        let mut counted: Vec<BTreeMap<Node, u64>> = Vec::new();
        let mut looped = Counted::default();
        for frame in 0..frames {
            let eye = self.group.eye(&work, frame)?;
            let drawn = picture.drawn(&eye, tree.leaves());
            let counts = self.counters.by_node(work.way, &eye, &drawn)?;
            since = drawn
                .nodes
                .iter()
                .map(|node| (*node, since.get(node).copied().unwrap_or(frame)))
                .collect();
            looped.pixels = counts.values().sum();
            if frame == 0 || frame + 1 == frames {
                looped.course.ends.push(CountedFrame {
                    eye,
                    drawn,
                    counts: counts.clone(),
                });
            }
            counted.push(counts);
            let has_changed = match (frame + 1).checked_sub(work.delay) {
                // A count may be used so many frames after the one that it is of.
                Some(old) if old <= frame => {
                    let usable = |node: Node| {
                        let is_own = since.get(&node).is_some_and(|first| *first <= old);
                        let count = counted[old].get(&node).filter(|_| is_own);
                        count.map(|count| *count as f64)
                    };
                    tree.update(usable, thresholds)
                }
                _ => false,
            };
            if has_changed {
                looped.course.last_change = Some(frame);
            }
            looped.course.sizes.push(tree.count() as f64);
        }
        let last = looped.course.ends.last().cloned();
        self.last.extend(last.map(|last| (case, last)));
        Ok(looped)
    }
}

fn verdict(work: &Work, looped: &Counted) -> Verdict {
    let leaves = looped.course.sizes.last().copied().unwrap_or(0.0);
    let (mut figures, reason) = looped.course.exactness();
    figures.push(("globe_count_leaves", leaves));
    if looped.pixels > 0 {
        let texels = leaves * f64::from(NODE_TEXELS * NODE_TEXELS);
        let share = texels / looped.pixels as f64;
        figures.push(("globe_count_texels_per_px", share));
    }
    if let Path::Still(_) = work.path {
        figures.extend(looped.course.rest(work.delay));
    }
    judged(reason, figures, vec![("leaves", looped.course.note())])
}

impl Shows for CountPart<'_> {
    type Shown = Counted;

    fn show(&mut self, case: usize) -> Result<(String, Counted), Failure> {
        let looped = self.run(case)?;
        Ok((looped.course.hash(), looped))
    }

    fn judge(&mut self, case: usize, looped: Counted) -> Result<Verdict, Failure> {
        Ok(verdict(&self.group.work[case], &looped))
    }

    /// The last frame with its counts read at once, and without counts.
    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let CountedFrame { eye, drawn, .. } = verified(&mut self.last, case)?;
        Ok(self.counters.time(self.group.work[case].way, eye, drawn)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::ByRays;
    use terrafill_fixtures::on_device::on_device;

    #[test]
    fn devices_count_what_rays_see_and_a_wide_hysteresis_comes_to_rest() {
        on_device(terrafill_gpu::shared_gpu, |context| {
            let list = List::shipped().expect("a list");
            let counts = Counts::planned(&list, true, 1);
            let mut session = CountPart::new(&counts.work, context);
            let mut ends = Vec::new();
            for way in PixelCount::ALL {
                let is_it = |work: &Work| {
                    work.way == way
                        && work.hysteresis == 6.0
                        && work.delay == 1
                        && work.path == Path::Still("nadir-1161km")
                };
                let case = counts.work.work.iter().position(is_it).expect("planned");
                match session.run(case) {
                    Ok(Counted { course, .. }) => {
                        let against_rays = course.against_rays();
                        eprintln!("{way:?}: {:?} {against_rays:?}", course.sizes);
                        assert!(against_rays.1 == 0 && against_rays.2 > 8);
                        assert!(course.settled(1).is_some_and(|frames| frames > 1));
                        ends.push(course.sizes);
                        let CountedFrame { eye, drawn, .. } = &session.last[&case];
                        let rays = ByRays::new(eye, drawn);
                        let counts = rays.counts.iter();
                        let mut fewer: BTreeMap<Node, u64> =
                            counts.map(|(node, count)| (*node, count[0])).collect();
                        assert_eq!(rays.against(&fewer), (0, 0));
                        // Negative control: half of a node's pixels are not counted.
                        let most = fewer.values_mut().max().expect("nodes");
                        *most /= 2;
                        assert_eq!(rays.against(&fewer).1, 1);
                    }
                    // A device without such queries.
                    Err(Failure::Unable(_)) => {}
                    Err(error) => unreachable!("{error:?}"),
                }
            }
            // The same loop from either count.
            assert!(ends.windows(2).all(|pair| pair[0] == pair[1]), "{ends:?}");
        });
    }
}
