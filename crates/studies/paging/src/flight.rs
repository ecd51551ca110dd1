// SPDX-License-Identifier: MIT OR Apache-2.0
//! A flight frame by frame: each decides with what is known, reads pages within its budget, and draws.

use crate::page_file::PageFile;
use crate::path::{Eye, FRAMES, Path, on_body};
use crate::residency::Residency;
use crate::stage::{DELAY, Look, Stage};
use crate::texture::{PAGE, PAGE_BYTES, Page, Texture};
use std::collections::BTreeMap;
use std::f64::consts::{PI, SQRT_2, TAU};
use terrafill_contract::CpuStopwatch;
use terrafill_core::Ellipsoid;
use terrafill_maps::{Node, Quadtree, Thresholds};
use terrafill_study::Failure;

/// Pages that the device keeps.
pub(crate) const SLOTS: usize = 256;
/// After so many frames without a read an eye that rests has its pages: a tree splits once in [`DELAY`] frames.
const QUIET: usize = 3 * DELAY;
/// A flight that still reads after so many frames ends.
pub(crate) const MOST_FRAMES: usize = 500;
/// A page that distance asks for may be so much farther from the picture's middle than the corner is.
const MARGIN: f64 = 1.1;

terrafill_results::named! {
    /// By what the level of a page is chosen.
    all pub(crate) enum Rule {
        /// Pixels of each leaf of a quadtree are counted, and known some frames later.
        Counted = "counted",
        /// Pixels of each leaf are predicted from its distance, as if it faced the eye.
        Distance = "distance",
        /// Each pixel finds its level by the footprint that derivatives span, and says which page it wants.
        Derivative = "derivative",
    }
}

/// How pages are chosen and read on a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Flight {
    pub(crate) path: Path,
    pub(crate) rule: Rule,
    /// Pixels at which a leaf splits over those at which it merges. The footprint alone has none.
    pub(crate) hysteresis: f64,
    /// Pages that a frame reads at most.
    pub(crate) budget: usize,
}

impl Flight {
    /// - `measures`: whether pages that pixels lack are counted too
    pub(crate) fn look(&self, measures: bool) -> Look {
        Look {
            by_derivative: self.rule == Rule::Derivative,
            counts: measures || self.rule != Rule::Distance,
            measures,
            addresses: false,
        }
    }
}

/// What a frame did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct FrameRecord {
    /// Pages that it wants.
    pub(crate) wanted: usize,
    /// Pages that it read.
    pub(crate) reads: usize,
    /// Pages for which no slot was free.
    pub(crate) without_slot: usize,
    /// Bytes that it sent to the device, pages and all else.
    pub(crate) bytes: u64,
    /// Pixels of the globe, and those of them that show a coarser page than their footprint asks for; where they were
    /// counted.
    pub(crate) pixels: Option<[u64; 2]>,
    /// Process CPU time and wall clock of deciding, reading and sending.
    pub(crate) update_ms: [f64; 2],
    /// The same of drawing.
    pub(crate) draw_ms: [f64; 2],
}

/// Pages and where they are kept.
pub(crate) struct Paged<'a> {
    pub(crate) texture: &'a Texture,
    pub(crate) file: &'a PageFile,
    pub(crate) stage: &'a mut Stage,
    pub(crate) slots: usize,
}

/// What is known while flying.
struct Pilot {
    flight: Flight,
    tree: Quadtree,
    held: Residency,
    /// Of each leaf, the frame from which on it is one.
    since: BTreeMap<Page, usize>,
    /// The most urgent first.
    wanted: Vec<Page>,
}

impl Pilot {
    fn new(flight: Flight, texture: &Texture, slots: usize) -> Self {
        Self {
            flight,
            tree: Quadtree::new(texture.finest),
            held: Residency::new(texture, slots),
            since: BTreeMap::from([(Page::ROOT, 0)]),
            wanted: vec![Page::ROOT],
        }
    }

    fn leaves(&self) -> impl Iterator<Item = Page> {
        self.tree.leaves().map(Page::from)
    }

    /// Takes the counts of an old frame, and chooses what this one wants.
    fn decide(&mut self, frame: usize, eye: &Eye, counts: Option<&[u32]>) {
        let thresholds = Thresholds::new(f64::from(PAGE * PAGE), self.flight.hysteresis);
        match self.flight.rule {
            Rule::Counted => {
                let Some(counts) = counts else { return };
                let since = &self.since;
                let known = |page: Page| {
                    let own = since.get(&page).is_some_and(|first| first + DELAY <= frame);
                    own.then(|| f64::from(counts[page.number()]))
                };
                self.tree.update(|node| known(node.into()), thresholds);
                // A new leaf is as urgent as one that has a pixel for each texel.
                let urgency = |page: Page| known(page).unwrap_or_else(|| f64::from(PAGE * PAGE));
                self.wanted = by_urgency(self.leaves(), urgency);
                let leaves = self.leaves();
                let new =
                    leaves.map(|leaf| (leaf, self.since.get(&leaf).copied().unwrap_or(frame)));
                self.since = new.collect();
            }
            Rule::Distance => {
                let predicted = |page| predicted(page, eye);
                let known = |node: Node| Some(predicted(node.into()));
                self.tree.update(known, thresholds);
                self.wanted = by_urgency(self.leaves(), predicted);
            }
            Rule::Derivative => {
                let Some(counts) = counts else { return };
                let pages = &counts[..counts.len() - 1];
                let pages = (0..pages.len()).map(Page::numbered);
                self.wanted = by_urgency(pages, |page| f64::from(counts[page.number()]));
            }
        }
    }
}

/// Pages with pixels, those with the most first.
fn by_urgency(pages: impl Iterator<Item = Page>, pixels: impl Fn(Page) -> f64) -> Vec<Page> {
    let wanted = pages.map(|page| (pixels(page), page));
    let mut wanted: Vec<(f64, Page)> = wanted.filter(|(pixels, _)| *pixels > 0.0).collect();
    wanted.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    wanted.into_iter().map(|(_, page)| page).collect()
}

/// Pixels of a page by the distance of its place that is nearest to the one below the eye; 0 where that is not seen.
fn predicted(page: Page, eye: &Eye) -> f64 {
    let side = 1.0 / f64::from(1_u32 << page.level);
    let middle = [page.x, page.y].map(|at| (f64::from(at) + 0.5) * side);
    let foot = [
        0.5 + eye.place.longitude_rad / TAU,
        0.5 - eye.place.latitude_rad / PI,
    ];
    let mut off = [foot[0] - middle[0], foot[1] - middle[1]];
    off[0] -= off[0].round();
    let nearest = [0, 1].map(|axis| middle[axis] + off[axis].clamp(-0.5 * side, 0.5 * side));
    let place = on_body(nearest);
    let radii = Ellipsoid::WGS84.radii_m();
    let (up, from_eye) = (place / (radii * radii), place - eye.camera.eye_ecef);
    let view = eye.camera.view_from_ecef * from_eye;
    let beside = view.x.hypot(view.y) / -view.z;
    if up.dot(from_eye) >= 0.0 || beside > MARGIN * SQRT_2 * eye.camera.tan_half_fov() {
        return 0.0;
    }
    let latitude = PI * (0.5 - nearest[1]);
    let texel = side / f64::from(PAGE);
    let texel_m2 = (TAU * texel * latitude.cos()) * (PI * texel) * radii.x * radii.x;
    let pixel_m = eye.camera.pixel_size_m(eye.size, from_eye.length());
    f64::from(PAGE * PAGE) * texel_m2 / (pixel_m * pixel_m)
}

/// Flies. First the eye rests until it has its pages, without a record; then it moves. From frame [`FRAMES`] on the flight
/// ends as soon as [`QUIET`] frames have read nothing.
///
/// - `measures`: whether pixels without their page are counted, which no rule needs
/// - `look_at`: called after each frame with its number, whether it is the last, and the page table as it was drawn with
///
/// # Errors
/// Of the device, of the file, and of `look_at`.
pub(crate) fn fly(
    paged: &mut Paged<'_>,
    flight: Flight,
    measures: bool,
    mut look_at: impl FnMut([usize; 2], &Eye, &[u32], &mut Stage) -> Result<(), Failure>,
) -> Result<Vec<FrameRecord>, Failure> {
    let Paged {
        texture,
        file,
        stage,
        slots,
    } = paged;
    let look = flight.look(measures);
    let mut pilot = Pilot::new(flight, texture, *slots);
    let mut page = vec![0; PAGE_BYTES];
    let mut records: Vec<FrameRecord> = Vec::with_capacity(FRAMES);
    // The frame in which the eye sets off, and frames since the last read.
    let (mut start, mut quiet) = (None, 0);
    let mut known = 0_usize;
    stage.restart();
    for frame in 0.. {
        let number = start.map(|start| frame - start);
        let eye = flight.path.eye(number.unwrap_or(0), stage.size.width);
        let budget = number.map_or(usize::MAX, |_| flight.budget);
        let watch = CpuStopwatch::start();
        let arrived = stage.counts(false)?;
        pilot.decide(frame, &eye, arrived.as_deref());
        if flight.rule != Rule::Derivative {
            pilot.held.set_leaves(pilot.tree.leaves().map(Page::from));
        }
        let loads = pilot.held.request(&pilot.wanted, frame, budget);
        for load in &loads.loads {
            file.read(load.page, &mut page).map_err(Failure::broken)?;
            stage.write_page(load.slot, &page);
        }
        stage.write_table(pilot.held.table());
        if !loads.loads.is_empty() {
            stage.flush()?;
        }
        let update_ms = [watch.cpu_ms(), watch.wall_ms()];
        let watch = CpuStopwatch::start();
        stage.draw(&eye, look)?;
        let draw_ms = [watch.cpu_ms(), watch.wall_ms()];
        quiet = if loads.loads.is_empty() { quiet + 1 } else { 0 };
        if let Some(counts) = arrived {
            let of = start.and_then(|start| known.checked_sub(start));
            if let Some(record) = of.and_then(|of| records.get_mut(of)) {
                record.pixels = pixels(&counts);
            }
            known += 1;
        }
        let bytes = stage.sent();
        let Some(number) = number else {
            if quiet == QUIET {
                start = Some(frame + 1);
            } else if frame == MOST_FRAMES {
                return Err(Failure::broken("it does not come to rest where it begins"));
            }
            continue;
        };
        records.push(FrameRecord {
            wanted: pilot.wanted.len(),
            reads: loads.loads.len(),
            without_slot: loads.without_slot,
            bytes,
            pixels: None,
            update_ms,
            draw_ms,
        });
        let is_last = number + 1 == MOST_FRAMES || (number + 1 >= FRAMES && quiet >= QUIET);
        look_at(
            [number, usize::from(is_last)],
            &eye,
            pilot.held.table(),
            stage,
        )?;
        if is_last {
            break;
        }
    }
    // Counts of the last frames are on their way; the newest comes last.
    for record in records.iter_mut().rev() {
        let Some(counts) = stage.counts(true)? else {
            break;
        };
        record.pixels = pixels(&counts);
    }
    Ok(records)
}

/// Pixels of all pages, and those that show a coarser one than their footprint asks for.
pub(crate) fn pixels(counts: &[u32]) -> Option<[u64; 2]> {
    let (missing, pages) = counts.split_last()?;
    let all = pages.iter().map(|count| u64::from(*count)).sum();
    Some([all, u64::from(*missing)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_window_wants_a_finer_level_than_there_is_and_from_farther_down_it_would() {
        let below = |eye: &Eye| {
            let foot = [
                0.5 + eye.place.longitude_rad / TAU,
                0.5 - eye.place.latitude_rad / PI,
            ];
            predicted(Page::at(6, foot), eye) / f64::from(PAGE * PAGE)
        };
        for path in Path::ALL {
            let most = below(&path.eye(FRAMES, 1000));
            assert!(most < 2.0, "{path:?}: {most} pixels a texel");
        }
        // Negative control: twice as many pixels a side.
        assert!(below(&Path::Zoom.eye(FRAMES, 2000)) > 2.0);
    }

    #[test]
    fn what_distance_predicts_is_about_the_picture_below_the_eye_and_none_of_the_far_side() {
        let eye = Eye::over(15.0, 40.0, 1e6, 512);
        let foot = [
            0.5 + eye.place.longitude_rad / TAU,
            0.5 - eye.place.latitude_rad / PI,
        ];
        // The page below the eye, by its neighbours' places on the screen.
        let page = Page::at(6, foot);
        let side = 1.0 / 64.0;
        let corner = |x: u32, y: u32| {
            let uv = [page.x + x, page.y + y].map(|at| f64::from(at) * side);
            let px = eye.camera.project_px(eye.size, on_body(uv));
            glam::DVec2::from(px.expect("in view"))
        };
        let area = (corner(1, 0) - corner(0, 0)).perp_dot(corner(0, 1) - corner(0, 0));
        let found = predicted(page, &eye);
        assert!((found / area.abs() - 1.0).abs() < 0.1, "{found} {area}");
        // Negative control: the other side, and a page far out of the picture.
        assert_eq!(predicted(Page::at(6, [foot[0] - 0.5, 0.7]), &eye), 0.0);
        assert_eq!(predicted(Page::at(6, [foot[0] + 0.1, foot[1]]), &eye), 0.0);
        // Pages that it is a part of are predicted to have more pixels.
        let mut pages = std::iter::successors(Some(page), |page| page.parent());
        assert!(pages.all(|page| predicted(page, &eye) >= found));
        let order = by_urgency(page.children().into_iter(), |child| {
            f64::from(child.x - 2 * page.x)
        });
        assert_eq!(order.len(), 2);
    }
}
