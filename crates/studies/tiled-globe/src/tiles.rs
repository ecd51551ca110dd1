// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles of a map over the grid on the screen (StuCoSReC 2018, sections 2.4 and 2.5). Each texel holds its own
//! address, so a picture says exactly which texel every pixel shows.

pub(crate) mod section;

pub(crate) use section::SECTION;

use crate::choose::chosen;
use crate::device::{MapScene, MapTargets, keys};
use crate::mesh::{MapMesh, map_mesh};
use crate::metrics::{self, SIZE_PX, VIEW};
use crate::options::{Options, Seam};
use crate::steps::{may_lose_texels, step_texels};
use crate::tile_set::{ADDRESSES, Content, Shown, TileSet, shown};
use crate::truth::{
    ALLOWED_TEXELS, Tile, Truth, body_truths, frame_level, off_texels, tiles, tiles_of, truths,
};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;
use terrafill_globe_views::{
    Eye, FrameWatch, OTHER_TRIANGLES, Opened, STUDY, ViewRow, fingerprint, quantiles,
};
use terrafill_results::{CaseId, PlannedCase, Verdict};
use terrafill_study::{CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, judged, verified};
use terrafill_surface::{Surface, SurfaceFrame};

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
    pub(crate) options: Vec<Options>,
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

    pub(crate) fn of_part(
        (part, tiles): (&'static str, TilesOf),
        view: &ViewRow,
        (side_px, samples): (u32, u32),
        options: Vec<Options>,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let eye = view.eye(side_px);
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
                samples: options.drawing.samples(samples),
                may_be_wrong: may_be_wrong(&eye, options.seam),
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{part}/{}", view.name),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                tiles,
                eye,
                options,
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                let part = TiledPart::new(&group.work, context);
                Ok(Box::new(JudgedOnce::new(part)))
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
    /// Hash of the triangles that were verified.
    mesh: String,
}

/// Cells, whether fragments make V', and the level of the frame.
type AskedBy = (u32, bool, Option<u32>);

struct TiledPart<'a> {
    group: &'a Tiled,
    context: Context<'a>,
    targets: Option<MapTargets>,
    /// Of the number of cells that was verified last: those of all would fill gigabytes.
    truths: Option<(u32, Rc<Vec<Option<Truth>>>)>,
    /// Tiles that the body asks for.
    of_body: Option<Vec<Tile>>,
    /// Those that triangles asked for last, by what decides.
    of_drawn: Option<(AskedBy, Vec<Tile>)>,
    /// By case.
    ready: BTreeMap<usize, Ready>,
}

/// How far a picture of tiles is off.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct TiledErrors {
    /// How far outside the texel shown each pixel's place is, by the triangles as drawn; those that hold a pole left
    /// out.
    pub(crate) drawn: Vec<f64>,
    /// By the body.
    body: Vec<f64>,
    pub(crate) seam_px: usize,
    /// Of them, those that show another texel's neighbour but one, or none.
    pub(crate) seam_wrong_px: usize,
    pole_px: usize,
    cap_px: usize,
    pub(crate) missing_px: usize,
    /// Pixels whose tile is at hand and that show a texel off by more than is allowed, or none. Those of triangles that
    /// hold a pole and those beside the outline are left out.
    wrong_px: usize,
    /// Pixels whose ray meets no triangle.
    open_px: usize,
    /// Tiles of which a pixel shows a texel.
    shown: BTreeSet<Tile>,
}

impl TiledErrors {
    /// Adds a pixel that shows the surface.
    ///
    /// - `at_hand`: tiles that the picture was drawn from
    fn add(
        mut self,
        truth: &Truth,
        shown: Shown,
        options: &Options,
        at_hand: &BTreeSet<Tile>,
    ) -> Self {
        let by_fragment = options.by_fragment;
        let off = match shown {
            Shown::Texel(texel) => Some(off_texels(texel, &truth.drawn, by_fragment)),
            Shown::Missing | Shown::Nothing => None,
        };
        self.missing_px += usize::from(off.is_none());
        if let Shown::Texel(texel) = shown {
            self.shown.insert(texel.tile);
        }
        self.cap_px += usize::from(truth.drawn.cap.is_some());
        if truth.holds_pole {
            self.pole_px += 1;
        } else {
            self.drawn.extend(off);
        }
        if truth.is_at_seam && truth.drawn.cap.is_none() {
            self.seam_px += 1;
            self.seam_wrong_px += usize::from(off.is_none_or(|off| off > ALLOWED_TEXELS));
        }
        let is_at_hand = || {
            let [from, to] = truth.levels;
            let mut asked = tiles_of(&truth.drawn, by_fragment, from..=to);
            truth.drawn.cap.is_some()
                || truth.drawn.is_on_map(by_fragment) && asked.all(|tile| at_hand.contains(&tile))
        };
        let snapped = match shown {
            Shown::Texel(texel) => texel.tile.texels() * truth.snapped,
            Shown::Missing | Shown::Nothing => 0.0,
        };
        let is_off = off.is_none_or(|off| off > ALLOWED_TEXELS + snapped);
        let is_judged = !truth.holds_pole && !truth.is_at_outline;
        self.wrong_px += usize::from(is_off && is_judged && is_at_hand());
        if let (Shown::Texel(texel), Some(body)) = (shown, &truth.body) {
            self.body.push(off_texels(texel, body, by_fragment));
        }
        self
    }

    /// Of two parts of a picture.
    fn with(mut self, mut other: Self) -> Self {
        self.drawn.append(&mut other.drawn);
        self.body.append(&mut other.body);
        self.shown.append(&mut other.shown);
        self.seam_px += other.seam_px;
        self.seam_wrong_px += other.seam_wrong_px;
        self.pole_px += other.pole_px;
        self.cap_px += other.cap_px;
        self.missing_px += other.missing_px;
        self.wrong_px += other.wrong_px;
        self
    }
}

/// - `at_hand`: as of [`TiledErrors::add`]
pub(crate) fn judge(
    truths: &[Option<Truth>],
    shown: &[Shown],
    options: &Options,
    at_hand: &BTreeSet<Tile>,
) -> TiledErrors {
    let pixels = truths.par_iter().zip(shown);
    let pixels = pixels.filter_map(|(truth, shown)| Some((truth.as_ref()?, *shown)));
    let parts = pixels.fold(TiledErrors::default, |found, (truth, shown)| {
        found.add(truth, shown, options, at_hand)
    });
    TiledErrors {
        open_px: truths.iter().filter(|truth| truth.is_none()).count(),
        ..parts.reduce(TiledErrors::default, TiledErrors::with)
    }
}

/// Whether the error is the question: the seam is left as it is, or `f32` counted from the map's edge loses texels.
pub(crate) fn may_be_wrong(eye: &Eye, seam: Seam) -> bool {
    seam.may_miss() || step_texels(eye, seam).is_some_and(may_lose_texels)
}

/// Why pixels beside the seam are wrong; empty where none is.
///
/// - `step`: texels that a step of `f32` is
pub(crate) fn seam_reason(found: &TiledErrors, step: Option<f64>) -> String {
    let (wrong, beside) = (found.seam_wrong_px, found.seam_px);
    if wrong == 0 {
        return String::new();
    }
    let lost = step.filter(|step| may_lose_texels(*step));
    let cause = lost.map(|step| format!("; a step of f32 is {step} texels there"));
    format!(
        "{wrong} of {beside} pixels beside ±180° show a texel off by more than {ALLOWED_TEXELS} or none, allowed 0{}",
        cause.unwrap_or_default()
    )
}

fn of_mesh(mesh: &MapMesh) -> String {
    fingerprint(&[bytemuck::cast_slice(&mesh.vertices)])
}

/// A picture of addresses, and what it was drawn from.
struct ShownTiles {
    frame: SurfaceFrame,
    mesh: MapMesh,
    addresses: Vec<u32>,
    sent: u64,
}

impl<'a> TiledPart<'a> {
    fn new(group: &'a Tiled, context: Context<'a>) -> Self {
        Self {
            group,
            context,
            targets: None,
            truths: None,
            of_body: None,
            of_drawn: None,
            ready: BTreeMap::new(),
        }
    }

    /// Of a grid's frame, remembered.
    fn truths(&mut self, n: u32, frame: &SurfaceFrame) -> Rc<Vec<Option<Truth>>> {
        let truths = match &self.truths {
            Some((known, truths)) if *known == n => Rc::clone(truths),
            _ => Rc::new(truths(&self.group.eye, frame)),
        };
        self.truths = Some((n, Rc::clone(&truths)));
        truths
    }
}

impl Shows for TiledPart<'_> {
    type Shown = ShownTiles;

    fn show(&mut self, case: usize) -> Result<(String, ShownTiles), Failure> {
        let (eye, options) = (&self.group.eye, self.group.options[case]);
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let surface = grid(&self.group.opened, options.n)?;
        let (frame, mesh) = self.group.mesh(&surface, &options)?;
        let (all, level) = match self.group.tiles {
            TilesOf::Drawn => {
                let truths = self.truths(options.n, &frame);
                let by = (options.n, options.by_fragment, options.one_level);
                let all = match &self.of_drawn {
                    Some((known, tiles)) if *known == by => tiles.clone(),
                    _ => tiles(&truths, &options),
                };
                self.of_drawn = Some((by, all.clone()));
                (all, frame_level(&truths, &options))
            }
            TilesOf::Body => {
                let of_body = || tiles(&body_truths(eye), &options);
                (self.of_body.get_or_insert_with(of_body).clone(), None)
            }
            TilesOf::Corners => (chosen(eye, &mesh)?.into_iter().collect(), None),
        };
        let targets = &mut self.targets;
        let targets = targets.get_or_insert_with(|| MapTargets::new(&gpu, eye.size, ADDRESSES));
        let mut scene = targets.scene(&options, level, (all, Content::Addresses))?;
        let mut sent = targets.send(&mut scene, eye, &options, &mesh);
        if self.group.tiles == TilesOf::Corners {
            sent += targets.send_tiles(&scene, &scene.set.tiles);
        }
        targets.draw(&scene)?;
        let addresses = targets.addresses()?;
        let keys = keys(&scene.set.tiles);
        let [keys, shown] = [
            bytemuck::cast_slice(&keys),
            bytemuck::cast_slice(&addresses),
        ];
        let hash = format!("{}-{}", of_mesh(&mesh), fingerprint(&[keys, shown]));
        let ready = Ready {
            surface,
            scene,
            mesh: of_mesh(&mesh),
        };
        self.ready.insert(case, ready);
        let shown = ShownTiles {
            frame,
            mesh,
            addresses,
            sent,
        };
        Ok((hash, shown))
    }

    fn judge(&mut self, case: usize, drawn: ShownTiles) -> Result<Verdict, Failure> {
        let options = self.group.options[case];
        let step = step_texels(&self.group.eye, options.seam);
        let truths = self.truths(options.n, &drawn.frame);
        let Ready { scene, .. } = verified(&mut self.ready, case)?;
        let all = &scene.set.tiles;
        let pixels = drawn.addresses.iter();
        let pixels: Vec<Shown> = pixels.map(|address| shown(all, *address)).collect();
        let at_hand = all.iter().copied().collect();
        let found = judge(&truths, &pixels, &options, &at_hand);
        Ok(verdict(
            (found, step),
            self.group.tiles,
            (&drawn.mesh, scene),
            drawn.sent,
        ))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let (eye, options) = (&self.group.eye, self.group.options[case]);
        let ready = verified(&mut self.ready, case)?;
        let targets = self.targets.as_ref();
        let targets = targets.ok_or("it has no targets".to_owned())?;
        let mut watch = FrameWatch::start();
        let (_, mesh) = self.group.mesh(&ready.surface, &options)?;
        watch.ends("globe_make_cpu_ms");
        let is_chosen = self.group.tiles == TilesOf::Corners;
        let tiles = is_chosen.then(|| chosen(eye, &mesh)).transpose()?;
        if is_chosen {
            watch.ends("globe_choose_cpu_ms");
        }
        targets.send(&mut ready.scene, eye, &options, &mesh);
        if let Some(tiles) = &tiles {
            targets.send_tiles(&ready.scene, tiles);
        }
        watch.ends("globe_upload_cpu_ms");
        let gpu_ms = targets.draw(&ready.scene)?;
        let values = watch.drawn(gpu_ms);
        if tiles.is_some_and(|tiles| !tiles.iter().eq(&ready.scene.set.tiles)) {
            let why = "it chose other tiles than when it was verified";
            return Err(Failure::broken(why));
        }
        if of_mesh(&mesh) != ready.mesh {
            return Err(Failure::broken(OTHER_TRIANGLES));
        }
        Ok(values)
    }
}

/// A grid on the screen of `n` × `n` cells.
pub(crate) fn grid(opened: &Opened, n: u32) -> Result<Arc<dyn Surface>, String> {
    opened.get(KIND, [("n", n)])
}

fn verdict(
    (found, step): (TiledErrors, Option<f64>),
    of: TilesOf,
    (mesh, scene): (&MapMesh, &MapScene),
    sent: u64,
) -> Verdict {
    let tiles = scene.set.tiles.len();
    let of_seam = seam_reason(&found, step);
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
    figures.extend(step.map(|step| ("globe_tile_step_texels", step)));
    let [drawn, body] = [found.drawn, found.body];
    figures.extend(quantiles(&[
        ("globe_tile_texels_max", &drawn, 1.0),
        ("globe_tile_texels_p99", &drawn, 0.99),
        ("globe_tile_true_texels_max", &body, 1.0),
        ("globe_tile_true_texels_p99", &body, 0.99),
        ("globe_tile_true_texels_median", &body, 0.5),
    ]));
    if of != TilesOf::Drawn {
        figures.push(("globe_tile_wrong_px", found.wrong_px as f64));
        let spare = tiles - found.shown.len();
        figures.push(("globe_tile_spare", spare as f64));
    }
    let reason = if !of_seam.is_empty() {
        of_seam
    } else if of == TilesOf::Body && found.open_px > 0 {
        let open = found.open_px;
        format!("{open} pixels show no surface, allowed 0: with another number of cells they may")
    } else if of != TilesOf::Drawn && found.wrong_px > 0 && found.open_px == 0 {
        // Near a limb a few are left, 1 of 640² with 10 × 10 cells, whose cause is not separated: counted alone.
        let wrong = found.wrong_px;
        format!("{wrong} pixels show a texel off by more than {ALLOWED_TEXELS} or none, allowed 0")
    } else {
        String::new()
    };
    judged(reason, figures, Vec::new())
}

#[cfg(test)]
mod tests;
