// SPDX-License-Identifier: MIT OR Apache-2.0
//! A user's own casters, named by the setting `casters`: `ship.obj,up=z,unit=0.001,policy=cap`.
//!
//! The middle of the model is laid at the origin, over the same sea as the port; heights stay. Eyes look
//! from four sides, above everything that casts: under a sun above the horizon no eye is in shadow.

use glam::DVec3;
use std::f64::consts::TAU;
use std::path::Path;
use terrafill_casters::{Mesh, ModelFile, Policy, Prepared, Reading, Up, Verdict, verdict};
use terrafill_shadow_views::{DeckCamera, box_of};

/// Name of the setting.
pub(crate) const SETTING: &str = "casters";
/// Sides from which the model is seen, and the first of them, turned from the axes so that no box is seen
/// along a face.
const SIDES: u32 = 4;
const FIRST_DEG: f64 = 20.0;

/// A model ready to cast.
#[derive(Debug, Clone)]
pub(crate) struct Brought {
    /// The file's name.
    pub(crate) name: String,
    pub(crate) policy: Policy,
    /// Of the file, before the policy.
    pub(crate) verdict: Verdict,
    pub(crate) prepared: Prepared,
    /// What was read otherwise than the file says.
    pub(crate) warnings: Vec<String>,
}

/// What has to be said of the model that the setting names: each line names the file. Nothing of one that cannot be
/// read, since the study's plan says why.
#[must_use]
pub fn model_warnings(setting: &str) -> Vec<String> {
    let Ok(Options { file, reading, .. }) = options(setting) else {
        return Vec::new();
    };
    let read = ModelFile::read(Path::new(file), reading);
    let warnings = read.map_or_else(|_| Vec::new(), |read| read.warnings);
    let named = warnings.into_iter().map(|text| format!("{file}: {text}"));
    named.collect()
}

/// Options behind the file's name, at its end.
#[derive(Debug)]
struct Options<'a> {
    file: &'a str,
    reading: Reading,
    policy: Policy,
}

fn options(text: &str) -> Result<Options<'_>, String> {
    let mut options = Options {
        file: text,
        reading: Reading::default(),
        policy: Policy::Refuse,
    };
    // From the end: a file's name may have commas, and even an equals sign before one.
    while let Some((rest, option)) = options.file.rsplit_once(',') {
        let Some((key, value)) = option.split_once('=') else {
            break;
        };
        let wrong = |allowed: &str| {
            Err(format!(
                "--{SETTING}: {key}: found {value:?}, allowed: {allowed}"
            ))
        };
        match key {
            "up" => match value {
                "y" => options.reading.up = Up::Y,
                "z" => options.reading.up = Up::Z,
                _ => return wrong("y, z"),
            },
            "unit" => match value.parse::<f64>() {
                Ok(unit_m) if unit_m.is_finite() && unit_m > 0.0 => options.reading.unit_m = unit_m,
                _ => return wrong("metres above 0"),
            },
            "policy" => match Policy::ALL.iter().find(|policy| policy.name() == value) {
                Some(policy) => options.policy = *policy,
                None => return wrong(&Policy::ALL.map(Policy::name).join(", ")),
            },
            _ => {
                return Err(format!(
                    "--{SETTING}: found {option:?}, allowed: up=…, unit=…, policy=…"
                ));
            }
        }
        options.file = rest;
    }
    Ok(options)
}

impl Brought {
    /// Reads a file as the setting names it.
    pub(crate) fn new(setting: &str) -> Result<Self, String> {
        let options = options(setting)?;
        let path = Path::new(options.file);
        let read = ModelFile::read(path, options.reading).map_err(|error| error.to_string())?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let brought = Self::of(&name, read.mesh, options.policy);
        Ok(Self {
            warnings: read.warnings,
            ..brought.map_err(|error| format!("{}: {error}", options.file))?
        })
    }

    pub(crate) fn of(name: &str, mut mesh: Mesh, policy: Policy) -> Result<Self, String> {
        let found = verdict(&mesh);
        let [low, high] = box_of(&mesh.vertices);
        if high.z <= 0.0 {
            return Err(format!(
                "highest place: found {} m, allowed: above the sea, which is at 0",
                high.z
            ));
        }
        let middle = (0.5 * (low + high)).with_z(0.0);
        for place in &mut mesh.vertices {
            *place -= middle;
        }
        let prepared = policy.prepare(mesh).map_err(|error| {
            let others = Policy::ALL.map(Policy::name).join(", ");
            format!("{error}; policies: {others}")
        })?;
        Ok(Self {
            name: name.to_owned(),
            policy,
            verdict: found,
            prepared,
            warnings: Vec::new(),
        })
    }

    /// The model from its sides, so far away that it fills less than the width of a picture.
    pub(crate) fn views(&self, size: [u32; 2]) -> Vec<DeckCamera> {
        let [low, high] = box_of(&self.prepared.mesh.vertices);
        let reach = 0.5 * (high - low).truncate().length();
        // 38.6° hold 0.35 of the distance to either side. The eye is above the top, and 14.7° downwards
        // hold the sea before the model.
        let away = 3.0 * reach + 4.5 * high.z;
        let height = (0.17 * away).max(1.1 * high.z + 0.02 * away);
        let near = (0.01 * away).min(0.5);
        let view = |side: u32| {
            let turn = FIRST_DEG.to_radians() + TAU * f64::from(side) / f64::from(SIDES);
            let (sin, cos) = turn.sin_cos();
            let eye = DVec3::new(away * cos, away * sin, height);
            DeckCamera::level(eye, turn.to_degrees() + 180.0, near, size)
        };
        (0..SIDES).map(view).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::{End, Scene, Scissor};
    use terrafill_casters::{PortSize, hull, port};
    use terrafill_core::{index_u32, nearest_f32};
    use terrafill_shadow_views::{Light, Rule, Wrong, bridge};

    /// Every model as an object of triangles, z up.
    fn obj(mesh: &Mesh) -> String {
        let places = mesh.vertices.iter();
        let places = places.map(|place| format!("v {} {} {}\n", place.x, place.y, place.z));
        let mut text: String = places.collect();
        for caster in &mesh.casters {
            text += &format!("o {}\n", caster.name);
            for part in &mesh.parts[caster.parts.clone()] {
                for corners in &mesh.triangles[part.triangles.clone()] {
                    let [a, b, c] = corners.map(|corner| corner + 1);
                    text += &format!("f {a} {b} {c}\n");
                }
            }
        }
        text
    }

    /// Every model as a node with a mesh of its own, y up, in `f32`.
    fn glb(mesh: &Mesh) -> Vec<u8> {
        let (mut bin, mut nodes, mut meshes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut views, mut accessors) = (Vec::new(), Vec::new());
        for (at, caster) in mesh.casters.iter().enumerate() {
            let parts = &mesh.parts[caster.parts.clone()];
            let [vertices, triangles] = [
                parts[0].vertices.start..parts[parts.len() - 1].vertices.end,
                parts[0].triangles.start..parts[parts.len() - 1].triangles.end,
            ];
            nodes.push(format!(r#"{{"name":"{}","mesh":{at}}}"#, caster.name));
            let (position, corner) = (2 * at, 2 * at + 1);
            meshes.push(format!(
                r#"{{"primitives":[{{"attributes":{{"POSITION":{position}}},"indices":{corner}}}]}}"#
            ));
            let places = &mesh.vertices[vertices.clone()];
            let [low, high] = [DVec3::min, DVec3::max].map(|of| {
                let all = places.iter().copied().reduce(of).expect("vertices");
                let [x, y, z] = [all.x, all.z, -all.y].map(nearest_f32);
                format!("[{x},{y},{z}]")
            });
            for (count, kind, component, size, bounds) in [
                (
                    places.len(),
                    "VEC3",
                    5126,
                    12,
                    format!(r#","min":{low},"max":{high}"#),
                ),
                (3 * triangles.len(), "SCALAR", 5125, 4, String::new()),
            ] {
                let start = match kind {
                    "VEC3" => bin.len(),
                    _ => bin.len() + 12 * places.len(),
                };
                views.push(format!(
                    r#"{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#,
                    size * count
                ));
                accessors.push(format!(
                    r#"{{"bufferView":{},"componentType":{component},"count":{count},"type":"{kind}"{bounds}}}"#,
                    accessors.len()
                ));
            }
            for place in places {
                for value in [place.x, place.z, -place.y] {
                    bin.extend(nearest_f32(value).to_le_bytes());
                }
            }
            let first = u32::try_from(vertices.start).expect("few");
            for corners in &mesh.triangles[triangles] {
                let corners = corners.map(|corner| (corner - first).to_le_bytes());
                bin.extend(corners.concat());
            }
        }
        let all: Vec<String> = (0..nodes.len()).map(|node| node.to_string()).collect();
        let mut json = format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[{}]}}],"nodes":[{}],"meshes":[{}],"accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#,
            all.join(","),
            nodes.join(","),
            meshes.join(","),
            accessors.join(","),
            views.join(","),
            bin.len()
        );
        while json.len() % 4 != 0 {
            json.push(' ');
        }
        let mut bytes = b"glTF".to_vec();
        let lengths = [2, 12 + 8 + json.len() + 8 + bin.len(), json.len()];
        bytes.extend(
            lengths
                .map(|length| index_u32(length).to_le_bytes())
                .concat(),
        );
        bytes.extend(b"JSON");
        bytes.extend(json.into_bytes());
        bytes.extend(index_u32(bin.len()).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(bin);
        bytes
    }

    fn read(name: &str, bytes: &[u8]) -> Result<Mesh, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let reading = Reading {
            up: Up::Z,
            unit_m: 1.0,
        };
        let read = ModelFile::read(&path, reading).map_err(|error| error.to_string());
        read.map(|file| file.mesh)
    }

    #[test]
    fn a_port_written_and_read_back_casts_the_same_volumes_and_masks() {
        let ours = port(PortSize::named("port-s").expect("named"));
        let from_obj = read("port.obj", obj(&ours).as_bytes()).expect("an OBJ file");
        let from_glb = read("port.glb", &glb(&ours)).expect("a GLB file");
        let mut rounded = ours.clone();
        for place in &mut rounded.vertices {
            *place = place.as_vec3().as_dvec3();
        }
        let from_rounded = read("rounded.obj", obj(&rounded).as_bytes()).expect("an OBJ file");
        for (own, as_read) in [
            (&ours, &from_obj),
            (&rounded, &from_glb),
            (&from_rounded, &from_glb),
        ] {
            // Vertices are numbered as faces name them, so places are compared.
            assert_eq!(own.vertices.len(), as_read.vertices.len());
            for at in 0..own.triangles.len() {
                assert_eq!(own.corners(at), as_read.corners(at), "{at}");
            }
            assert_eq!(own.parts, as_read.parts);
            assert_eq!(own.casters, as_read.casters);
        }
        let view = bridge([64, 48])[4];
        let scene = |mesh: &Mesh| {
            Scene::of(mesh.clone(), [10.0, -60.0], vec![view]).expect("a closed mesh")
        };
        let [ours, from_obj, from_glb, from_rounded] =
            [&ours, &from_obj, &from_glb, &from_rounded].map(scene);
        let mask = |scene: &Scene, rule| {
            let drawn = scene.drawn(End::Sea, rule, Scissor::Off);
            drawn.expect("from above").masks.concat()
        };
        // Triangles by their places, from the least of them on.
        let volume = |scene: &Scene| {
            let volume = scene.volume(End::Sea).expect("from above");
            let places = |corner: u32| {
                let place = volume.vertices[corner as usize];
                place.to_array().map(|value| (value + 0.0).to_bits())
            };
            let triangles = volume.triangles.iter().map(|triangle| {
                let mut corners = triangle.corners.map(places);
                let least = (0..3).min_by_key(|at| corners[*at]).unwrap_or_default();
                corners.rotate_left(least);
                corners
            });
            let mut triangles: Vec<_> = triangles.collect();
            triangles.sort_unstable();
            triangles
        };
        for (own, as_read) in [(&ours, &from_obj), (&from_rounded, &from_glb)] {
            assert_eq!(volume(own), volume(as_read));
            for rule in [Rule::Pass, Rule::Fail] {
                assert_eq!(mask(own, rule), mask(as_read, rule));
            }
        }
        let truth = &ours.truths()[0];
        assert_eq!(Wrong::of(&mask(&from_glb, Rule::Fail), truth).outside(), 0);
        let shadow = truth.count(Light::Shadow);
        assert!(shadow > 50, "{shadow}");
    }

    #[test]
    fn a_port_written_otherwise_is_noticed() {
        let ours = port(PortSize::named("port-xs").expect("named"));
        let found = |mesh: &Mesh| {
            let read = [
                read("a.obj", obj(mesh).as_bytes()),
                read("a.glb", &glb(mesh)),
            ];
            read.map(|mesh| verdict(&mesh.expect("read")).to_string())
        };
        let mut turned = ours.clone();
        turned.triangles[40].swap(1, 2);
        assert_eq!(found(&ours), ["closed"; 2]);
        for found in found(&turned) {
            assert!(found.starts_with("flipped 3 edges"), "{found}");
        }
        // Bytes that are cut off, and a file that says less of itself than it has.
        let whole = glb(&ours);
        let error = read("a.glb", &whole[..whole.len() - 4]).expect_err("cut off");
        assert!(error.contains("length: found"), "{error}");
    }

    #[test]
    fn options_are_read_from_the_end_and_refused_by_name() {
        let read = options("a.obj,b=c").expect_err("b is no option");
        assert_eq!(
            read,
            r#"--casters: found "b=c", allowed: up=…, unit=…, policy=…"#
        );
        let read = options("a, b.obj,up=z,unit=0.3048,policy=cap").expect("read");
        assert_eq!(read.file, "a, b.obj");
        assert_eq!((read.reading.up, read.policy), (Up::Z, Policy::Cap));
        assert_eq!(read.reading.unit_m.to_bits(), 0.3048_f64.to_bits());
        for (text, message) in [
            ("a.obj,up=x", r#"--casters: up: found "x", allowed: y, z"#),
            (
                "a.obj,unit=0",
                r#"--casters: unit: found "0", allowed: metres above 0"#,
            ),
            (
                "a.obj,policy=close",
                r#"--casters: policy: found "close", allowed: refuse, cap, robust, as-is"#,
            ),
        ] {
            assert_eq!(options(text).expect_err(text), message);
        }
    }

    #[test]
    fn eyes_stand_above_everything_and_see_the_model() {
        for mesh in [hull(1_000), port(PortSize::NAMED[0].1)] {
            let brought = Brought::of("a", mesh, Policy::Refuse).expect("closed");
            let [low, high] = box_of(&brought.prepared.mesh.vertices);
            assert!((low + high).truncate().length() < 1e-9 * high.length());
            for view in brought.views([4, 3]) {
                assert!(view.near_corners().iter().all(|corner| corner.z > high.z));
                for place in &brought.prepared.mesh.vertices {
                    let along = *place - view.eye;
                    let depth = along.dot(view.forward);
                    assert!((along.dot(view.right) / depth).abs() < view.tan[0]);
                    assert!(along.dot(view.up) / depth > -view.tan[1] - 0.15);
                }
            }
        }
    }

    #[test]
    fn what_is_below_the_sea_or_open_is_refused_with_what_was_found() {
        let mut sunk = hull(1_000);
        for place in &mut sunk.vertices {
            place.z -= 100.0;
        }
        let error = Brought::of("a", sunk, Policy::Refuse).expect_err("sunk");
        assert!(error.starts_with("highest place: found -"), "{error}");
        let mut open = hull(1_000);
        open.triangles.pop();
        open.planes.pop();
        open.parts[0].triangles.end -= 1;
        let error = Brought::of("a", open.clone(), Policy::Refuse).expect_err("open");
        assert!(error.starts_with("border 3 edges"), "{error}");
        let policies = "policies: refuse, cap, robust, as-is";
        assert!(error.ends_with(policies), "{error}");
        let capped = Brought::of("a", open, Policy::Cap).expect("capped");
        assert_eq!(capped.verdict.border, 3, "as the file has it");
    }
}
