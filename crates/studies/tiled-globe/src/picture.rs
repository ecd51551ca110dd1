// SPDX-License-Identifier: MIT OR Apache-2.0
//! A picture of the Earth cut into tiles of the map, laid over the grid on the screen: where there is data, NASA's Blue
//! Marble.
//!
//! Two pictures of each view are drawn, one by tiles that hold their address and one by tiles that hold colours. A pixel
//! must have the colour of the texel that it says it shows, to the byte.

mod section;

pub(crate) use section::SECTION;

use super::device::{MapScene, MapTargets};
use super::mesh::map_mesh;
use super::options::Options;
use super::tile_set::{ADDRESSES, COLOURS, Content, SIDE, Shown, shown};
use super::tiles::grid;
use super::truth::{Texel, Tile, Truth, WrappedPoint, frame_level, tiles, truths};
use crate::metrics::{self, SIZE_PX, VIEW};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_globe_views::{
    Eye, FrameWatch, Opened, STUDY, ViewRow, fingerprint, quantiles, write_png,
};
use terrafill_maps::{CAP_SPAN, MapTile, PictureLevel, cut_cap, cut_tile};
use terrafill_results::{CaseId, PlannedCase, RunInput, Verdict};
use terrafill_scene::{MipChain, Scene};
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, JudgedOnce, Shows, files_read, judged, verified,
};
use terrafill_surface::SurfaceFrame;

/// Name of this part in cases.
pub(crate) const PART: &str = "picture";
/// Whose picture it is: the scene names file and hash.
pub(crate) const SCENE: &str = "blue-marble";
/// Views of a quick run, and of others.
const QUICK_VIEWS: [&str; 2] = ["globe", "globe-antimeridian"];
const VIEWS: [&str; 6] = [
    "globe",
    "globe-antimeridian",
    "globe-pole",
    "nadir-1161km-32.5",
    LEVELS_OF,
    "oblique-100km",
];
/// Cells along each side of the screen: what the map shows is within a few pixels there.
const CELLS: u32 = 40;
/// Whose area is drawn in several levels, as in Figure 1, and by how many each is below the finest that a pixel asks for.
const LEVELS_OF: &str = "italy-1161km";
const LEVELS: [u32; 3] = [4, 3, 0];

/// The picture of the shipped scene, and the files that it was read from.
///
/// # Errors
/// What is missing, with how to get it.
pub(crate) fn blue_marble(
    data_dir: Option<&Path>,
) -> Result<(Arc<MipChain>, Vec<RunInput>), String> {
    let scene = Scene::shipped(SCENE, data_dir).map_err(|error| error.to_string())?;
    let texture = scene.texture.as_ref();
    let texture = texture.ok_or_else(|| format!("scene {SCENE} has no picture"))?;
    Ok((Arc::new(texture.image.clone()), files_read(&scene)))
}

/// Views of the map under a picture.
pub(crate) struct Pictured {
    works: Vec<(ViewRow, Options)>,
    side_px: u32,
    picture: Arc<MipChain>,
    opened: Rc<Opened>,
}

impl Pictured {
    pub(crate) fn planned(
        views: &[ViewRow],
        (side_px, samples): (u32, u32),
        is_quick: bool,
        picture: Arc<MipChain>,
        opened: &Rc<Opened>,
    ) -> CaseGroup<Self> {
        let names: &[&str] = if is_quick { &QUICK_VIEWS } else { &VIEWS };
        let views = views
            .iter()
            .filter(|view| names.contains(&view.name.as_str()));
        let options = Options {
            n: CELLS,
            ..Options::BASE
        };
        let works = views.flat_map(|view| {
            let below: &[u32] = if view.name == LEVELS_OF { &LEVELS } else { &[] };
            let levels = std::iter::once(None).chain(below.iter().copied().map(Some));
            levels.map(|one_level| {
                (
                    view.clone(),
                    Options {
                        one_level,
                        ..options
                    },
                )
            })
        });
        let works: Vec<(ViewRow, Options)> = works.collect();
        let cases = works.iter().map(|(view, options)| {
            let conditions = [
                (metrics::PART, PART.to_owned()),
                (VIEW, view.name.clone()),
                (metrics::CELLS, CELLS.to_string()),
                (metrics::LEVEL, options.level_name()),
                (SIZE_PX, side_px.to_string()),
            ];
            PlannedCase {
                id: CaseId::new(STUDY, name(view, options, "/"), conditions),
                samples,
                may_be_wrong: false,
            }
        });
        CaseGroup {
            name: format!("{STUDY}/{PART}"),
            cases: cases.collect(),
            warm_up: None,
            work: Self {
                works,
                side_px,
                picture,
                opened: Rc::clone(opened),
            },
            open: |group, context| {
                Ok(Box::new(JudgedOnce::new(PicturePart {
                    group: &group.work,
                    context,
                    targets: None,
                    truths: None,
                    ready: BTreeMap::new(),
                })))
            },
        }
    }
}

/// Of a case, or of its picture's file.
fn name(view: &ViewRow, options: &Options, between: &str) -> String {
    let name = format!("{PART}{between}{}", view.name);
    match options.one_level {
        None => name,
        Some(_) => format!("{name}{between}level-{}", options.level_name()),
    }
}

struct PicturePart<'a> {
    group: &'a Pictured,
    context: Context<'a>,
    /// Of addresses, and of colours.
    targets: Option<[MapTargets; 2]>,
    /// Of the view that was drawn last.
    truths: Option<(String, Rc<Vec<Option<Truth>>>)>,
    ready: BTreeMap<usize, MapScene>,
}

/// Colours of a tile, cut from a picture.
pub(crate) fn cut(picture: &MipChain, tile: Tile) -> Vec<u8> {
    let levels: Vec<PictureLevel<'_>> = levels(picture);
    match tile {
        Tile::Map { level, row, column } => {
            let tile = MapTile {
                level,
                column: column.into(),
                row: row.into(),
            };
            cut_tile(&levels, tile)
        }
        Tile::Cap { is_south } => cut_cap(&levels, is_south),
    }
}

fn levels(picture: &MipChain) -> Vec<PictureLevel<'_>> {
    let levels = picture.levels().iter();
    levels
        .map(|level| PictureLevel {
            width: level.width,
            height: level.height,
            rgba: &level.rgba,
        })
        .collect()
}

/// How far the colours of a picture are off.
#[derive(Debug, Clone, PartialEq, Default)]
struct ColourErrors {
    /// Pixels that show a texel.
    texels: usize,
    /// Of them, those that have another colour than the texel.
    wrong: usize,
    /// Difference from the whole picture at each pixel's place on the body, the largest channel's, bytes.
    off: Vec<f64>,
}

impl ColourErrors {
    /// Of two parts of a picture.
    fn with(mut self, mut other: Self) -> Self {
        self.texels += other.texels;
        self.wrong += other.wrong;
        self.off.append(&mut other.off);
        self
    }
}

pub(crate) fn colour_of(tiles: &BTreeMap<Tile, Vec<u8>>, texel: Texel) -> Option<[u8; 4]> {
    let texels = tiles.get(&texel.tile)?;
    let at = 4 * (texel.y * SIDE + texel.x) as usize;
    texels.get(at..at + 4)?.try_into().ok()
}

fn judge(
    truths: &[Option<Truth>],
    (shown, colours): (&[Shown], &[[u8; 4]]),
    tiles: &BTreeMap<Tile, Vec<u8>>,
    whole: &PictureLevel<'_>,
) -> ColourErrors {
    let add = |mut found: ColourErrors, ((truth, shown), colour): PixelColour<'_>| {
        let Shown::Texel(texel) = shown else {
            return found;
        };
        found.texels += 1;
        found.wrong += usize::from(colour_of(tiles, *texel) != Some(*colour));
        let body = truth.as_ref().and_then(|truth| truth.body);
        found.off.extend(body.map(|body| {
            let [longitude, latitude] = place(&body);
            let expected = whole.colour(longitude, latitude);
            let channels = (0..3).map(|i| f64::from(colour[i].abs_diff(expected[i])));
            channels.fold(0.0, f64::max)
        }));
        found
    };
    let pixels = truths.par_iter().zip(shown).zip(colours);
    let parts = pixels.fold(ColourErrors::default, add);
    parts.reduce(ColourErrors::default, ColourErrors::with)
}

/// What a pixel should show, what it shows, and its colour.
type PixelColour<'p> = ((&'p Option<Truth>, &'p Shown), &'p [u8; 4]);

/// Longitude and latitude, radians.
fn place(body: &WrappedPoint) -> [f64; 2] {
    match body.cap {
        Some(cap) => {
            let [x, y] = cap.map(|at| (2.0 * at - 1.0) * CAP_SPAN);
            let latitude = std::f64::consts::FRAC_PI_2 - 2.0 * x.hypot(y).atan();
            // V' runs from north to south.
            [y.atan2(x), latitude.copysign(0.5 - body.by_vertex)]
        }
        None => [
            (body.u - 0.5) * TAU,
            (TAU * (0.5 - body.by_vertex)).sinh().atan(),
        ],
    }
}

/// Pictures of a case by both kinds of tiles.
struct ShownPictures {
    addresses: Vec<u32>,
    colours: Vec<[u8; 4]>,
    truths: Rc<Vec<Option<Truth>>>,
    /// Colours of the tiles.
    cut: BTreeMap<Tile, Vec<u8>>,
    triangles: usize,
    sent: u64,
}

impl PicturePart<'_> {
    fn eye(&self, case: usize) -> Eye {
        self.group.works[case].0.eye(self.group.side_px)
    }

    /// Of a case's view, remembered.
    fn truths(&mut self, case: usize, frame: &SurfaceFrame) -> Rc<Vec<Option<Truth>>> {
        let view = &self.group.works[case].0.name;
        let truths = match &self.truths {
            Some((known, truths)) if known == view => Rc::clone(truths),
            _ => Rc::new(truths(&self.eye(case), frame)),
        };
        self.truths = Some((view.clone(), Rc::clone(&truths)));
        truths
    }
}

impl Shows for PicturePart<'_> {
    type Shown = ShownPictures;

    fn show(&mut self, case: usize) -> Result<(String, ShownPictures), Failure> {
        let eye = self.eye(case);
        let gpu = terrafill_gpu::shared_gpu(self.context.devices)?;
        let (_, options) = &self.group.works[case];
        let surface = grid(&self.group.opened, options.n)?;
        let frame = surface.frame(&eye.camera, eye.size)?;
        let mesh = map_mesh(&eye.body, &eye.camera, &frame, options);
        let truths = self.truths(case, &frame);
        let targets = &mut self.targets;
        let [of_addresses, of_colours] = targets.get_or_insert_with(|| {
            [ADDRESSES, COLOURS].map(|format| MapTargets::new(&gpu, eye.size, format))
        });
        let (all, level) = (tiles(&truths, options), frame_level(&truths, options));
        let picture = &self.group.picture;
        let cut: Vec<Vec<u8>> = all.par_iter().map(|tile| cut(picture, *tile)).collect();
        let by_tile = all.iter().copied().zip(cut.iter().cloned()).collect();
        let content = (all.clone(), Content::Addresses);
        let mut scene = of_addresses.scene(options, level, content)?;
        of_addresses.send(&mut scene, &eye, options, &mesh);
        of_addresses.draw(&scene)?;
        let addresses = of_addresses.addresses()?;
        let content = (all, Content::Colours(cut));
        let mut scene = of_colours.scene(options, level, content)?;
        let sent = of_colours.send(&mut scene, &eye, options, &mesh);
        of_colours.draw(&scene)?;
        let colours = of_colours.colours()?;
        self.ready.insert(case, scene);
        let pictures = [bytemuck::cast_slice(&addresses), colours.as_flattened()];
        let hash = fingerprint(&pictures);
        let shown = ShownPictures {
            addresses,
            colours,
            truths,
            cut: by_tile,
            triangles: mesh.vertices.len() / 3,
            sent,
        };
        Ok((hash, shown))
    }

    fn judge(&mut self, case: usize, drawn: ShownPictures) -> Result<Verdict, Failure> {
        let eye = self.eye(case);
        let (view, options) = &self.group.works[case];
        let all: Vec<Tile> = drawn.cut.keys().copied().collect();
        let pixels = drawn.addresses.iter();
        let pixels: Vec<Shown> = pixels.map(|address| shown(&all, *address)).collect();
        let whole = levels(&self.group.picture)[0];
        let pictures = (pixels.as_slice(), drawn.colours.as_slice());
        let found = judge(&drawn.truths, pictures, &drawn.cut, &whole);
        let mut figures = vec![
            ("globe_tile_px", found.texels as f64),
            ("globe_tile_colour_wrong_px", found.wrong as f64),
            ("globe_tile_count", all.len() as f64),
            ("globe_triangles", drawn.triangles as f64),
            ("globe_upload_bytes", drawn.sent as f64),
        ];
        let off = &found.off;
        figures.extend(quantiles(&[
            ("globe_tile_colour_off_median", off, 0.5),
            ("globe_tile_colour_off_p99", off, 0.99),
        ]));
        let reason = match (found.texels, found.wrong) {
            (0, _) => "no pixel shows a texel".to_owned(),
            (_, 0) => String::new(),
            (of, wrong) => format!(
                "{wrong} of {of} pixels have another colour than the texel that they show, allowed 0"
            ),
        };
        let name = name(view, options, "-");
        let size = [eye.size.width, eye.size.height];
        let pixels = drawn.colours.iter().map(|[rgb @ .., _]| *rgb);
        let path = write_png(self.context.folder, &name, size, pixels)?;
        Ok(judged(reason, figures, vec![("picture", path)]))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        let scene = verified(&mut self.ready, case)?;
        let targets = self.targets.as_ref();
        let [_, targets] = targets.ok_or("it has no targets".to_owned())?;
        let watch = FrameWatch::start();
        let gpu_ms = targets.draw(scene)?;
        Ok(watch.drawn(gpu_ms))
    }
}

#[cfg(test)]
mod tests;
