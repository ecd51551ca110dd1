// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles of a map over the grid on the screen (StuCoSReC 2018, sections 2.4 and 2.5). Each texel holds its own
//! address, so a picture says exactly which texel every pixel shows.

pub(crate) mod cells;
pub(crate) mod choose;
mod device;
mod mesh;
pub(crate) mod options;
pub(crate) mod picture;
mod section;
pub(crate) mod stage;
mod tile_set;
mod truth;

pub(crate) use section::SECTION;

use crate::STUDY;
use crate::clock::FrameWatch;
use crate::list::{Eye, ViewRow};
use crate::metrics::{self, SIZE_PX, VIEW};
use crate::opened::Opened;
use crate::sight::{OTHER_TRIANGLES, fingerprint};
use choose::chosen;
use device::{MapScene, MapTargets};
use mesh::{MapMesh, map_mesh};
use options::Options;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_results::{CaseId, PlannedCase, Verdict, quantile};
use terrafill_study::{CaseGroup, Context, Failure, Figures, Session, judged, verified};
use terrafill_surface::{Surface, SurfaceFrame};
use tile_set::{ADDRESSES, Content, Shown, TileSet};
use truth::{Tile, Truth, body_truths, off_texels, tiles, tiles_of, truths};

/// Name of this part in cases.
pub(crate) const PART: &str = "tiles";
/// The surface under the tiles.
pub(crate) const KIND: &str = "screen-grid";

/// Which tiles a way has at hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TilesOf {
    /// Those that its triangles as drawn ask for.
    Drawn,
    /// Those that the body asks for, so that a view's ways have the same.
    Body,
    /// Those that the grid's corners ask for, chosen anew in each frame.
    Corners,
}

/// A view, and the ways to lay tiles over it.
pub(crate) struct Tiled {
    tiles: TilesOf,
    eye: Eye,
    options: Vec<Options>,
    opened: Rc<Opened>,
}

impl Tiled {
    pub(crate) fn planned(
        view: &ViewRow,
        sizes: (u32, u32),
        options: Vec<Options>,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        Self::of_part((PART, TilesOf::Drawn), view, sizes, options, opened)
    }

    fn of_part(
        (part, tiles): (&'static str, TilesOf),
        view: &ViewRow,
        (side_px, samples): (u32, u32),
        options: Vec<Options>,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let cases = options.iter().map(|options| {
            let own = options.conditions();
            let set = own
                .each_ref()
                .map(|(name, value)| format!("{name}={value}"));
            let text = format!("{part}/{}/{}", view.name, set.join("/"));
            let shared = [
                (metrics::PART, part.to_owned()),
                (VIEW, view.name.clone()),
                (SIZE_PX, side_px.to_string()),
            ];
            PlannedCase {
                id: CaseId::new(STUDY, text, shared.into_iter().chain(own)),
                samples,
                may_be_wrong: options.seam.may_miss(),
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{part}/{}", view.name),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                tiles,
                eye: view.eye(side_px),
                options,
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(TiledPart {
                    group: &group.work,
                    context,
                    targets: None,
                    truths: None,
                    of_body: None,
                    ready: BTreeMap::new(),
                }))
            },
        }
    }

    fn mesh(
        &self,
        surface: &Arc<dyn Surface>,
        options: &Options,
    ) -> Result<(SurfaceFrame, MapMesh), String> {
        let frame = surface.frame(&self.eye.camera, self.eye.size);
        let frame = frame.map_err(|error| error.to_string())?;
        let mesh = map_mesh(&self.eye.body, &self.eye.camera, &frame, options);
        Ok((frame, mesh))
    }
}

struct Ready {
    surface: Arc<dyn Surface>,
    scene: MapScene,
    fingerprint: u64,
}

struct TiledPart<'a> {
    group: &'a Tiled,
    context: Context<'a>,
    targets: Option<MapTargets>,
    /// Of the number of cells that was verified last: those of all would fill gigabytes.
    truths: Option<(u32, Rc<Vec<Option<Truth>>>)>,
    /// Tiles that the body asks for.
    of_body: Option<Vec<Tile>>,
    /// By case.
    ready: BTreeMap<usize, Ready>,
}

/// How far a picture of tiles is off.
#[derive(Debug, Clone, PartialEq, Default)]
struct TiledErrors {
    /// How far outside the texel shown each pixel's place is, by the triangles as drawn; those that hold a pole left
    /// out.
    drawn: Vec<f64>,
    /// By the body.
    body: Vec<f64>,
    seam_px: usize,
    /// Of them, those that show another texel's neighbour but one, or none.
    seam_wrong_px: usize,
    pole_px: usize,
    cap_px: usize,
    missing_px: usize,
    /// Pixels whose tile is at hand and that show a texel off by more than is allowed, or none; those of triangles that
    /// hold a pole left out.
    wrong_px: usize,
    /// Tiles of which a pixel shows a texel.
    shown: BTreeSet<Tile>,
}

/// Texels by which a pixel beside the seam may be off.
const ALLOWED_TEXELS: f64 = 0.5;

/// - `at_hand`: tiles that the picture was drawn from
fn judge(
    truths: &[Option<Truth>],
    shown: &[Shown],
    options: &Options,
    at_hand: &BTreeSet<Tile>,
) -> TiledErrors {
    let by_fragment = options.by_fragment;
    let mut found = TiledErrors::default();
    for (truth, shown) in truths.iter().zip(shown) {
        let Some(truth) = truth else { continue };
        let off = match shown {
            Shown::Texel(texel) => Some(off_texels(*texel, &truth.drawn, by_fragment)),
            Shown::Missing | Shown::Nothing => None,
        };
        found.missing_px += usize::from(off.is_none());
        if let Shown::Texel(texel) = shown {
            found.shown.insert(texel.tile);
        }
        found.cap_px += usize::from(truth.drawn.cap.is_some());
        if truth.holds_pole {
            found.pole_px += 1;
        } else {
            found.drawn.extend(off);
        }
        if truth.is_at_seam && truth.drawn.cap.is_none() {
            found.seam_px += 1;
            found.seam_wrong_px += usize::from(off.is_none_or(|off| off > ALLOWED_TEXELS));
        }
        let is_at_hand = || {
            let [from, to] = truth.levels;
            let mut asked = tiles_of(&truth.drawn, by_fragment, from..=to);
            truth.drawn.cap.is_some()
                || truth.drawn.is_on_map(by_fragment) && asked.all(|tile| at_hand.contains(&tile))
        };
        let is_off = off.is_none_or(|off| off > ALLOWED_TEXELS);
        found.wrong_px += usize::from(is_off && !truth.holds_pole && is_at_hand());
        if let (Shown::Texel(texel), Some(body)) = (shown, &truth.body) {
            found.body.push(off_texels(*texel, body, by_fragment));
        }
    }
    found
}

fn of_mesh(mesh: &MapMesh) -> u64 {
    fingerprint(&[bytemuck::cast_slice(&mesh.vertices)])
}

impl Session for TiledPart<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let (eye, options) = (&self.group.eye, self.group.options[case]);
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let surface = grid(&self.group.opened, options.n)?;
        let (frame, mesh) = self.group.mesh(&surface, &options)?;
        let truths = match &self.truths {
            Some((n, known)) if *n == options.n => Rc::clone(known),
            _ => Rc::new(truths(eye, &frame)),
        };
        self.truths = Some((options.n, Rc::clone(&truths)));
        let targets = &mut self.targets;
        let targets = targets.get_or_insert_with(|| MapTargets::new(&gpu, eye.size, ADDRESSES));
        let all = match self.group.tiles {
            TilesOf::Drawn => tiles(&truths, &options),
            TilesOf::Body => {
                let of_body = || tiles(&body_truths(eye), &options);
                self.of_body.get_or_insert_with(of_body).clone()
            }
            TilesOf::Corners => chosen(eye, &mesh)?.into_iter().collect(),
        };
        let at_hand = all.iter().copied().collect();
        let mut scene = targets.scene(&options, &truths, (all, Content::Addresses))?;
        let sent = targets.send(&mut scene, eye, &options, &mesh);
        targets.draw(&scene)?;
        let shown = targets.shown(&scene)?;
        let found = judge(&truths, &shown, &options, &at_hand);
        let verdict = verdict(&found, self.group.tiles, (&mesh, &scene), sent);
        let ready = Ready {
            surface,
            scene,
            fingerprint: of_mesh(&mesh),
        };
        self.ready.insert(case, ready);
        Ok(verdict)
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let (eye, options) = (&self.group.eye, self.group.options[case]);
        let ready = verified(&mut self.ready, case)?;
        let mut watch = FrameWatch::start();
        let (_, mesh) = self.group.mesh(&ready.surface, &options)?;
        watch.ends("globe_make_cpu_ms");
        if self.group.tiles == TilesOf::Corners {
            let tiles = chosen(eye, &mesh)?;
            watch.ends("globe_choose_cpu_ms");
            if !tiles.iter().eq(&ready.scene.set.tiles) {
                return Err(Failure::broken(
                    "it chose other tiles than when it was verified",
                ));
            }
        }
        let targets = self.targets.as_ref();
        let targets = targets.ok_or("it has no targets".to_owned())?;
        targets.send(&mut ready.scene, eye, &options, &mesh);
        watch.ends("globe_upload_cpu_ms");
        let gpu_ms = targets.draw(&ready.scene)?;
        let values = watch.drawn(gpu_ms);
        if of_mesh(&mesh) != ready.fingerprint {
            return Err(Failure::broken(OTHER_TRIANGLES));
        }
        Ok(values)
    }
}

/// A grid on the screen of `n` × `n` cells.
fn grid(opened: &Opened, n: u32) -> Result<Arc<dyn Surface>, String> {
    opened.get(KIND, [("n", n)])
}

fn verdict(
    found: &TiledErrors,
    of: TilesOf,
    (mesh, scene): (&MapMesh, &MapScene),
    sent: u64,
) -> Verdict {
    let tiles = scene.set.tiles.len();
    let mut figures = vec![
        ("globe_tile_px", found.drawn.len() as f64),
        ("globe_tile_seam_px", found.seam_px as f64),
        ("globe_tile_seam_wrong_px", found.seam_wrong_px as f64),
        ("globe_tile_pole_px", found.pole_px as f64),
        ("globe_tile_cap_px", found.cap_px as f64),
        ("globe_tile_missing_px", found.missing_px as f64),
        ("globe_tile_crossing", mesh.crossing as f64),
        ("globe_tile_missed", mesh.missed as f64),
        ("globe_tile_count", tiles as f64),
        ("globe_tile_draws", scene.texels.len() as f64),
        (
            "globe_tile_bytes",
            tiles as f64 * TileSet::BYTES_PER_TILE as f64,
        ),
        ("globe_triangles", (mesh.vertices.len() / 3) as f64),
        ("globe_upload_bytes", sent as f64),
    ];
    let mut add = |name, of: &[f64], share| {
        figures.extend(quantile(of, share).map(|value| (name, value)));
    };
    add("globe_tile_texels_max", &found.drawn, 1.0);
    add("globe_tile_texels_p99", &found.drawn, 0.99);
    add("globe_tile_true_texels_max", &found.body, 1.0);
    add("globe_tile_true_texels_p99", &found.body, 0.99);
    add("globe_tile_true_texels_median", &found.body, 0.5);
    // Counted and not judged: coarse grids over the whole globe have some, at 1,024² up to 264, whose cause is not separated.
    if of != TilesOf::Drawn {
        figures.push(("globe_tile_wrong_px", found.wrong_px as f64));
        let spare = tiles - found.shown.len();
        figures.push(("globe_tile_spare", spare as f64));
    }
    let reason = match found.seam_wrong_px {
        0 => String::new(),
        wrong => format!(
            "{wrong} of {} pixels beside ±180° show a texel off by more than {ALLOWED_TEXELS} or none, allowed 0",
            found.seam_px
        ),
    };
    let notes = vec![("triangles", format!("{:016x}", of_mesh(mesh)))];
    judged(reason, figures, notes)
}

#[cfg(test)]
mod tests;
