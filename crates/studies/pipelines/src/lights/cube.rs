// SPDX-License-Identifier: MIT OR Apache-2.0
//! A cube map of depths and colours around a place above terrain, its six faces by every way to layers.
//!
//! Colours are numbers of triangles. Every way must leave the same depths and colours bit for bit. Texels are held against
//! `f64` rays from the cube's middle, those along the seams all of them. The picture says of each pixel which face sees it,
//! and whether the middle does.

use super::on_vulkan::{LayerParts, OnVulkan};
use super::scene::{LightColumns, LightConstants, ground};
use super::way::LightWay;
use crate::STUDY;
use crate::draws::{LooksUp as _, bits, count, differing};
use crate::images::{of_lights, of_relief, size_px, write};
use crate::metrics::{EXPERIMENT, GRID_CELLS, LAYERS_BY, MAP_TEXELS};
use crate::on_vulkan::{heights, uniform};
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::collections::BTreeMap;
use terrafill_contract::{DeviceError, ids_of};
use terrafill_results::Verdict;
use terrafill_scene::ImageSize;
use terrafill_shapes::grid::{Grid, GridCamera, GridConstants, NEAR_M};
use terrafill_shapes::rays::{BAND_PX, Hit, Judged, Rays, around, within};
use terrafill_study::{
    CaseGroup, Context, Failure, Figures, Group, Session, judged, planned_case, verified,
};

/// Above the highest object, off every symmetry.
const MIDDLE: DVec3 = DVec3::new(1_003.0, 988.0, 240.0);
const CELLS: u32 = 256;
const QUICK_CELLS: u32 = 64;
const SIDES: [u32; 2] = [256, 1_024];
const QUICK_SIDES: [u32; 1] = [128];
/// Texels of a face that are held against rays besides those along its seams: one in so many.
const TEXEL_EVERY: usize = 61;
/// Pixels of the picture that are, about.
const PIXELS: usize = 4_096;
/// What hides a place is nearer by more than this share, in texels of a face. Ground at 1 km is seen 13° above
/// level, where half a texel's diagonal is three of its sides along the ray.
const BIAS_TEXELS: f64 = 4.0;
/// Depths closer than this share are equal: `f32` rounds place, columns and quotient a few times.
const DEPTH_BAND: f64 = 2e-5;

/// A face: axes of its picture, and where it looks.
#[derive(Debug, Clone, Copy)]
struct Face {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

/// Along the axes, both ways each.
fn faces() -> Vec<Face> {
    let face = |forward: DVec3| {
        let aside = if forward.z.abs() > 0.5 {
            DVec3::Y
        } else {
            DVec3::Z
        };
        let right = forward.cross(aside);
        Face {
            right,
            up: right.cross(forward),
            forward,
        }
    };
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    axes.into_iter()
        .flat_map(|axis| [face(axis), face(-axis)])
        .collect()
}

impl Face {
    /// Clip space from metres: 90° both ways, reversed depth.
    fn clip(&self) -> DMat4 {
        let row = |axis: DVec3| axis.extend(-axis.dot(MIDDLE));
        let rows = [
            row(self.right),
            row(self.up),
            DVec4::W * NEAR_M,
            row(self.forward),
        ];
        DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
    }

    /// A place on the face, texels, and how far it is forwards; nowhere for what lies behind.
    fn project(&self, place: DVec3, side: u32) -> (DVec2, f64) {
        let from = place - MIDDLE;
        let away = from.dot(self.forward);
        if away <= 0.0 {
            return (DVec2::INFINITY, f64::INFINITY);
        }
        let across = DVec2::new(from.dot(self.right), from.dot(self.up)) / away;
        ((0.5 * across + 0.5) * f64::from(side), away)
    }

    /// Where a direction's part forwards is 1, through a place of the face in texels.
    fn direction(&self, texel: DVec2, side: u32) -> DVec3 {
        let across = 2.0 * texel / f64::from(side) - 1.0;
        self.forward + self.right * across.x + self.up * across.y
    }
}

/// Cubes of some sizes by every way.
pub(crate) struct Cubes {
    cells: u32,
    side: u32,
    size: ImageSize,
}

pub(crate) fn cube_groups(is_quick: bool, pictures: (ImageSize, u32)) -> Vec<impl Group> {
    let (cells, sides): (u32, &[u32]) = if is_quick {
        (QUICK_CELLS, &QUICK_SIDES)
    } else {
        (CELLS, &SIDES)
    };
    sides
        .iter()
        .map(|side| group(cells, *side, pictures))
        .collect()
}

fn group(cells: u32, side: u32, (size, samples): (ImageSize, u32)) -> CaseGroup<Cubes> {
    let case = |way: LightWay| {
        let conditions = vec![
            (EXPERIMENT, "cube".to_owned()),
            (LAYERS_BY, way.name().to_owned()),
            (MAP_TEXELS, side.to_string()),
            (GRID_CELLS, cells.to_string()),
        ];
        planned_case(STUDY, samples, conditions, Some(size_px(size)))
    };
    CaseGroup {
        name: format!("{STUDY}/cube/{side}"),
        cases: LightWay::ALL.map(case).into(),
        warm_up: None,
        work: Cubes { cells, side, size },
        open: |group, context| {
            Ok(Box::new(CubeSession {
                group,
                context,
                grid: ground(group.work.cells),
                first: None,
                opened: BTreeMap::new(),
            }))
        },
    }
}

fn open(
    context: Context<'_>,
    way: LightWay,
    grid: &Grid,
    faces: &[Face],
    (side, size): (u32, ImageSize),
) -> Result<OnVulkan, DeviceError> {
    let gpu = terrafill_vulkan::shared_gpu(context.devices)?;
    let constants = GridConstants::new(grid);
    let columns = faces
        .iter()
        .map(|face| LightColumns::of_matrix(&face.clip(), grid.step_m()));
    let columns: Vec<LightColumns> = columns.collect();
    let of_faces = LightConstants::of_columns(&columns, side, bias(side));
    let layers = count(faces);
    let parts = LayerParts {
        way,
        layers,
        side,
        vertex: way.vertex(),
        geometry: way.geometry(layers),
        fragment: Some("native/lights.frag.spv"),
        vertices: [6 * grid.cells * grid.cells; 2],
        resources: vec![
            uniform(&gpu, "grid constants", bytemuck::bytes_of(&constants))?,
            terrafill_vulkan::Resource::Image(heights(&gpu, grid)?),
            uniform(&gpu, "faces", bytemuck::bytes_of(&of_faces))?,
        ],
        behind: None,
        picture: "pipelines/cubed.wgsl",
        size,
    };
    OnVulkan::with(&gpu, parts)
}

/// A share of a distance.
fn bias(side: u32) -> f64 {
    BIAS_TEXELS * 2.0 / f64::from(side)
}

/// Faces and ground, for rays.
struct CubeRays<'a> {
    rays: Rays<'a>,
    faces: Vec<Face>,
    side: u32,
}

/// Texels that no ray allows: along seams and elsewhere by their depths, and all by their colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct JudgedTexels {
    seam: usize,
    seam_wrong: usize,
    inner_wrong: usize,
    colour_wrong: usize,
    coloured: usize,
}

impl CubeRays<'_> {
    /// Depth by a ray through a place of a face.
    fn depth(&self, face: &Face, texel: DVec2) -> f64 {
        let met = self.meet(face, texel);
        met.map_or(0.0, |hit| NEAR_M / hit.away_m)
    }

    fn meet(&self, face: &Face, texel: DVec2) -> Option<Hit> {
        self.rays.follow(MIDDLE, face.direction(texel, self.side))
    }

    /// Whether a texel may show the triangle of a number, as near as vertices are snapped; 0 is none.
    fn allows_colour(&self, face: &Face, middle: DVec2, found: u32) -> bool {
        let meet = |at| self.meet(face, at);
        let project = |place| face.project(place, self.side);
        meet(middle).map_or(0, |hit| hit.number) == found
            || self.rays.may_show(middle, found, meet, project)
    }

    /// Whether a depth is between those of rays as near as vertices are snapped.
    fn allows(&self, face: &Face, middle: DVec2, found: f64) -> bool {
        let is_close = |depth: f64| (found - depth).abs() <= DEPTH_BAND * depth;
        if is_close(self.depth(face, middle)) {
            return true;
        }
        let ring = around(BAND_PX).map(|off| self.depth(face, middle + off));
        let [low, high] = ring.fold([f64::INFINITY, 0.0_f64], |[low, high], depth| {
            [low.min(depth), high.max(depth)]
        });
        found >= low * (1.0 - DEPTH_BAND) && found <= high * (1.0 + DEPTH_BAND)
    }

    /// Holds depths and numbers of all faces, one after the other, against rays.
    fn judge_texels(&self, depths: &[f32], numbers: &[u32]) -> JudgedTexels {
        let mut judged = JudgedTexels::default();
        let side = self.side as usize;
        let texels = depths.chunks(side * side).zip(numbers.chunks(side * side));
        for (face, (depths, colours)) in self.faces.iter().zip(texels) {
            for (number, (depth, colour)) in depths.iter().zip(colours).enumerate() {
                let (x, y) = (number % side, number / side);
                let is_seam = [x, y].iter().any(|at| *at == 0 || *at == side - 1);
                if !is_seam && !number.is_multiple_of(TEXEL_EVERY) {
                    continue;
                }
                let middle = DVec2::new(x as f64, y as f64) + 0.5;
                let is_wrong = !self.allows(face, middle, f64::from(*depth));
                judged.coloured += usize::from(*colour > 0);
                judged.colour_wrong += usize::from(!self.allows_colour(face, middle, *colour));
                judged.seam += usize::from(is_seam);
                judged.seam_wrong += usize::from(is_seam && is_wrong);
                judged.inner_wrong += usize::from(!is_seam && is_wrong);
            }
        }
        judged
    }

    /// What a picture may show of a place: of every face that may be found, seen or not, with what rounding may choose.
    fn may_show(&self, place: DVec3, band: f64) -> Vec<u32> {
        let mut numbers = Vec::new();
        for (number, face) in (0_u32..).zip(&self.faces) {
            let (at, away) = face.project(place, self.side);
            let side = f64::from(self.side);
            let margin = band.max(1e-3);
            if at.min_element() < -margin || at.max_element() > side + margin {
                continue;
            }
            for off in within(band) {
                let texel = (at + off)
                    .floor()
                    .clamp(DVec2::ZERO, DVec2::splat(side - 1.0))
                    + 0.5;
                for edge in within(band) {
                    let nearest = self.depth(face, texel + edge) * away / NEAR_M;
                    for off in [-DEPTH_BAND, DEPTH_BAND] {
                        let is_seen = nearest <= 1.0 + bias(self.side) + off;
                        numbers.push(1 + 2 * number + u32::from(is_seen));
                    }
                }
            }
        }
        numbers
    }

    fn judge_picture(&self, numbers: &[u32]) -> Judged {
        let mut judged = Judged::default();
        let every = (numbers.len() / PIXELS).max(1) | 1;
        for (pixel, at) in self.rays.centres().enumerate().step_by(every) {
            let shown = numbers[pixel];
            let place = self.rays.place(at);
            let may = place.map_or(vec![0], |place| self.may_show(place, 0.0));
            let truth = if may.contains(&shown) {
                shown
            } else {
                may.first().copied().unwrap_or(0)
            };
            judged.add(shown, truth, || {
                around(BAND_PX).any(|off| {
                    let place = self.rays.place(at + off);
                    place.map_or(shown == 0, |place| {
                        self.may_show(place, BAND_PX).contains(&shown)
                    })
                })
            });
        }
        judged
    }
}

/// Numbers of a picture, bits of its depths and colours of its faces, and what rays say of them.
struct FirstCube {
    numbers: Vec<u32>,
    depths: Vec<u32>,
    colours: Vec<u32>,
    texels: JudgedTexels,
    found: Judged,
}

/// Faces as a cross of four across and three down. Those that look level are along the middle, turning right. What is
/// above lies above the second, what is below lies below the fourth, so that all that touch have their seam in common.
fn unfolded(numbers: &[u32], side: u32, size: ImageSize) -> Vec<u32> {
    const AROUND: [u32; 4] = [0, 3, 1, 2];
    let pixel = |at: u32| {
        let [x, y] = [at % size.width, at / size.width].map(|at| 4 * at);
        let [column, row] = [x / size.width, y / size.height];
        let face = match (row, column) {
            (0, 1) => 4,
            (1, _) => AROUND[column as usize % 4],
            (2, 3) => 5,
            _ => return 0,
        };
        // Rows of a face grow upwards.
        let [x, y] = [
            x % size.width * side / size.width,
            y % size.height * side / size.height,
        ];
        numbers[(face * side * side + (side - 1 - y) * side + x) as usize]
    };
    (0..size.width * size.height).map(pixel).collect()
}

struct CubeSession<'a> {
    group: &'a CaseGroup<Cubes>,
    context: Context<'a>,
    grid: Grid,
    /// What the first way showed that was drawn.
    first: Option<FirstCube>,
    /// By case.
    opened: BTreeMap<usize, OnVulkan>,
}

impl Session for CubeSession<'_> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let Cubes { side, size, .. } = self.group.work;
        let way = LightWay::ALL[case];
        let mut opened = open(self.context, way, &self.grid, &faces(), (side, size))?;
        let shown = opened.draw()?;
        let numbers = ids_of(&shown.picture);
        let depths = bits(&shown.depths);
        let colours = opened.numbers()?;
        let is_first = self.first.is_none();
        let rays = CubeRays {
            rays: Rays::new(&self.grid, GridCamera::new(), size),
            faces: faces(),
            side,
        };
        let texels = || rays.judge_texels(&shown.depths, &colours);
        let first = self.first.get_or_insert_with(|| FirstCube {
            texels: texels(),
            found: rays.judge_picture(&numbers),
            numbers: numbers.clone(),
            depths: depths.clone(),
            colours: colours.clone(),
        });
        let texels_differ = differing(&depths, &first.depths) + differing(&colours, &first.colours);
        let pixels_differ = differing(&numbers, &first.numbers);
        // What equals the first is judged with it.
        let texels = if texels_differ > 0 {
            texels()
        } else {
            first.texels
        };
        let found = if pixels_differ > 0 {
            rays.judge_picture(&numbers)
        } else {
            first.found.clone()
        };
        let reason = if texels.seam_wrong > 0 {
            format!(
                "{} texels along seams are not those of rays",
                texels.seam_wrong
            )
        } else if texels.inner_wrong > 0 {
            format!(
                "{} texels of faces are not those of rays",
                texels.inner_wrong
            )
        } else if texels.colour_wrong > 0 {
            format!(
                "{} texels have another colour than rays",
                texels.colour_wrong
            )
        } else if texels.coloured == 0 {
            "its faces have no colour".to_owned()
        } else if found.mismatched > 0 {
            let pixels = found.mismatched;
            format!("{pixels} pixels show what the reference does not allow")
        } else if texels_differ + pixels_differ > 0 {
            format!(
                "{texels_differ} depths and colours, and {pixels_differ} pixels differ from the first way's"
            )
        } else {
            String::new()
        };
        let mut figures = vec![
            ("pipeline_mismatched_px", found.mismatched as f64),
            ("pipeline_band_px", found.in_band as f64),
            ("pipeline_differing_px", pixels_differ as f64),
            ("pipeline_shown_px", found.shown as f64),
            ("pipeline_held_bytes", opened.bytes() as f64),
            ("lights_passes", opened.passes() as f64),
            ("lights_depths_differing", texels_differ as f64),
            ("cube_seam_texels", texels.seam as f64),
            ("cube_seam_wrong", texels.seam_wrong as f64),
            ("cube_inner_wrong", texels.inner_wrong as f64),
            ("cube_colour_wrong", texels.colour_wrong as f64),
        ];
        figures.extend(shown.counted.figures());
        self.opened.insert(case, opened);
        let notes = if is_first || !reason.is_empty() {
            let name = &self.group.cases[case].id.name;
            // Seen is light.
            let seen: Vec<u32> = numbers
                .iter()
                .map(|of| of.min(&1) + u32::from(*of > 0 && of % 2 == 0))
                .collect();
            let mut notes = write(self.context.folder, name, size, of_lights(&seen, 1))?;
            let faces = unfolded(&colours, side, size);
            let name = format!("{name}-faces");
            let pixels = of_relief(&faces, &self.grid);
            let written = write(self.context.folder, &name, size, pixels)?;
            notes.extend(written.into_iter().map(|(_, path)| ("faces", path)));
            notes
        } else {
            Vec::new()
        };
        Ok(judged(reason, figures, notes))
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        Ok(verified(&mut self.opened, case)?.time()?.figures())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::images::PICTURE;
    use crate::tested::{Tested, figure};
    use terrafill_results::Status;

    #[test]
    fn faces_cover_every_direction_once_and_meet_at_their_seams() {
        let faces = faces();
        for direction in [
            DVec3::new(0.3, -0.8, 0.1),
            DVec3::new(-0.9, 0.2, 0.4),
            DVec3::new(0.1, 0.2, -0.7),
        ] {
            let inside = faces.iter().filter(|face| {
                let away = direction.dot(face.forward);
                let across = [face.right, face.up].map(|axis| direction.dot(axis).abs());
                away > 0.0 && across.iter().all(|part| *part < away)
            });
            assert_eq!(inside.count(), 1, "{direction}");
        }
        for face in &faces {
            assert!((face.right.cross(face.up) + face.forward).length() < 1e-12);
        }
    }

    #[test]
    fn the_largest_faces_are_those_of_rays() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let context = Context {
            devices: &tested.devices,
            folder: std::path::Path::new(""),
        };
        let (grid, side) = (ground(CELLS), SIDES[1]);
        let rays = CubeRays {
            rays: Rays::new(&grid, GridCamera::new(), PICTURE),
            faces: faces(),
            side,
        };
        let opened = open(context, LightWay::Passes, &grid, &faces(), (side, PICTURE));
        let mut opened = opened.expect("opens");
        let depths = opened.draw().expect("draws").depths;
        let mut colours = opened.numbers().expect("colours");
        let right = rays.judge_texels(&depths, &colours);
        assert_eq!(
            [right.seam_wrong, right.inner_wrong, right.colour_wrong],
            [0; 3]
        );
        // Negative control: another triangle in one texel along a seam.
        colours[0] += 1_000;
        assert_eq!(rays.judge_texels(&depths, &colours).colour_wrong, 1);
    }

    #[test]
    fn every_way_draws_the_same_cube_and_exchanged_or_turned_faces_are_noticed() {
        let Some(tested) = Tested::open() else {
            return;
        };
        let group = group(QUICK_CELLS, QUICK_SIDES[0], (PICTURE, 1));
        let verdicts = tested.verdicts(&group);
        for (at, verdict) in &verdicts {
            let name = &group.cases[*at].id.name;
            assert_eq!(verdict.status, Status::Ok, "{name}: {}", verdict.reason);
            assert!(figure(verdict, "cube_seam_texels") > 3_000.0, "{name}");
        }
        assert!(verdicts.len() >= 3, "{}", verdicts.len());
        // Negative controls: two faces exchanged, one mirrored, one turned by a texel.
        let context = Context {
            devices: &tested.devices,
            folder: std::path::Path::new(""),
        };
        let grid = ground(QUICK_CELLS);
        let side = QUICK_SIDES[0];
        let rays = CubeRays {
            rays: Rays::new(&grid, GridCamera::new(), PICTURE),
            faces: faces(),
            side,
        };
        let judge = |faces: &[Face]| {
            let opened = open(context, LightWay::Passes, &grid, faces, (side, PICTURE));
            let mut opened = opened.expect("opens");
            let shown = opened.draw().expect("draws");
            let pixels = rays.judge_picture(&ids_of(&shown.picture)).mismatched;
            let colours = opened.numbers().expect("colours");
            (rays.judge_texels(&shown.depths, &colours), pixels)
        };
        let (right, pixels) = judge(&faces());
        assert_eq!((right.seam_wrong, right.inner_wrong, pixels), (0, 0, 0));
        assert!(
            right.colour_wrong == 0 && right.coloured > 1_000,
            "{right:?}"
        );
        let mut exchanged = faces();
        exchanged.swap(0, 2);
        let (texels, pixels) = judge(&exchanged);
        assert!(
            texels.seam_wrong > 0
                && texels.inner_wrong > 0
                && texels.colour_wrong > 0
                && pixels > 0,
            "{texels:?} {pixels}"
        );
        let mut mirrored = faces();
        mirrored[5].right = -mirrored[5].right;
        assert!(judge(&mirrored).0.seam_wrong > 0);
        let mut turned = faces();
        let forward = turned[0].forward;
        turned[0].up += forward * (2.0 / f64::from(side));
        assert!(judge(&turned).0.seam_wrong > 0);
    }
}
