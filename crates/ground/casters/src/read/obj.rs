// SPDX-License-Identifier: MIT OR Apache-2.0
//! OBJ by `tobj`, in `f64`: surveyed places of 10⁶ m keep their millimetres.
//!
//! What casts no shadow is blanked before, lines and points among it: `tobj` takes a line of three places
//! for a triangle. Objects (`o`) are models. Groups (`g`) are not: programs put the sides of one solid into
//! several. Its errors name no line, so the lines that it takes are counted.

use super::model::{Model, Wrong, wrong};
use crate::mesh::fan_normal;
use glam::DVec3;
use std::io::{BufRead, Read};
use tobj::{LoadError, LoadOptions};

/// A corner of a polygon may turn back by this share of its edges' lengths, as rounding makes it.
const TURN_SHARE: f64 = 1e-9;

/// Text whose lines are counted as they are taken.
struct Counted<'a> {
    rest: &'a [u8],
    lines: usize,
}

impl Read for Counted<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let count = self.rest.read(into)?;
        self.lines += newlines(&into[..count]);
        Ok(count)
    }
}

impl BufRead for Counted<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        Ok(self.rest)
    }

    fn consume(&mut self, count: usize) {
        let (taken, rest) = self.rest.split_at(count);
        self.lines += newlines(taken);
        self.rest = rest;
    }
}

fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte == b'\n').count()
}

pub(super) fn read(bytes: &[u8]) -> Result<Vec<Model>, Wrong> {
    let text = String::from_utf8_lossy(bytes);
    let casts = |line: &&str| {
        let keyword = line.split_whitespace().next();
        matches!(keyword, Some("v" | "f" | "o"))
    };
    let kept = text
        .lines()
        .map(|line| Some(line).filter(casts).unwrap_or_default());
    let kept: Vec<&str> = kept.collect();
    let kept = kept.join("\n") + "\n";
    let mut counted = Counted {
        rest: kept.as_bytes(),
        lines: 0,
    };
    let options = LoadOptions {
        ignore_points: true,
        ignore_lines: true,
        ..LoadOptions::default()
    };
    let no_materials = |_: &std::path::Path| Err(LoadError::GenericFailure);
    let loaded = tobj::load_obj_buf(&mut counted, &options, no_materials);
    let lines = counted.lines;
    let (models, _) = loaded.map_err(|error| at_line(&text, lines, error))?;
    models.iter().map(model).collect()
}

/// What is wrong, at the last line taken or, of an index, where that stands.
fn at_line(text: &str, taken: usize, error: LoadError) -> Wrong {
    let (number, allowed) = match error {
        LoadError::PositionParseError => (taken, "v x y z".to_owned()),
        LoadError::ColorParseError => (taken, "v x y z, or v x y z r g b".to_owned()),
        LoadError::ScalingByZeroError => (taken, "a weight that is not 0".to_owned()),
        LoadError::FaceParseError => (
            taken,
            "f and whole numbers, as v, v/vt or v/vt/vn".to_owned(),
        ),
        LoadError::FaceVertexOutOfBounds => missing_vertex(text)
            .unwrap_or((taken, "faces behind the vertices that they name".to_owned())),
        other => (taken, format!("a line that tobj takes: {other}")),
    };
    let found = text
        .lines()
        .nth(number.saturating_sub(1))
        .unwrap_or_default();
    wrong(format!("line {number}"), format!("{found:?}"), allowed)
}

/// The first face that names a vertex which there is not: its line and what it may name.
fn missing_vertex(text: &str) -> Option<(usize, String)> {
    let keyword = |line: &str| {
        line.split_whitespace()
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    let all = text.lines().filter(|line| keyword(line) == "v").count();
    let mut before = 0;
    for (number, line) in text.lines().enumerate() {
        match keyword(line).as_str() {
            "v" => before += 1,
            "f" => {
                let vertices = line.split_whitespace().skip(1);
                let mut vertices =
                    vertices.filter_map(|corner| corner.split('/').next()?.parse().ok());
                let is_there = |vertex: i64| match usize::try_from(vertex.unsigned_abs()) {
                    Ok(0) | Err(_) => false,
                    Ok(at) => at <= if vertex < 0 { before } else { all },
                };
                if !vertices.all(is_there) {
                    return Some((number + 1, format!("vertices 1 … {all}, or -{before} … -1")));
                }
            }
            _ => {}
        }
    }
    None
}

fn model(loaded: &tobj::Model) -> Result<Model, Wrong> {
    let mesh = &loaded.mesh;
    let places = mesh.positions.chunks_exact(3);
    let places = places.map(|place| [place[0], place[1], place[2]]);
    let mut model = Model {
        name: loaded.name.clone(),
        places: places.collect(),
        triangles: Vec::new(),
    };
    // Of triangles alone there are no arities.
    let triangles = vec![3; mesh.indices.len() / 3];
    let arities = match mesh.face_arities.is_empty() {
        true => &triangles,
        false => &mesh.face_arities,
    };
    let mut first = 0;
    for (face, arity) in arities.iter().enumerate() {
        let past = first + *arity as usize;
        let ring = mesh.indices.get(first..past).unwrap_or_default();
        let element = || format!("object {:?}, face {face}", model.name);
        let places = ring
            .iter()
            .map(|at| DVec3::from(model.places[*at as usize]));
        let places: Vec<DVec3> = places.collect();
        if ring.len() < 3 {
            return Err(wrong(element(), format!("{arity} corners"), "3 and more"));
        }
        if let Some(corner) = dent(&places) {
            let found = format!("a corner at {} that is dented", places[corner]);
            let allowed = "triangles and convex polygons; most programs triangulate on export";
            return Err(wrong(element(), found, allowed));
        }
        let fan = (1..ring.len() - 1).map(|at| [ring[0], ring[at], ring[at + 1]]);
        model.triangles.extend(fan);
        first = past;
    }
    Ok(model)
}

/// A corner at which a polygon turns the other way; a fan over it would lie beside the polygon.
fn dent(ring: &[DVec3]) -> Option<usize> {
    let up = fan_normal(ring).normalize_or_zero();
    let count = ring.len();
    (0..count).find(|at| {
        let (before, after) = (ring[(at + count - 1) % count], ring[(at + 1) % count]);
        let (way, on) = (ring[*at] - before, after - ring[*at]);
        way.cross(on).dot(up) < -TURN_SHARE * way.length() * on.length()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PYRAMID: &str = "# a pyramid\no roof\nv -1 -1 0 0.5 0.5 0.5\nv 1 -1 0 0.5 0.5 0.5\n\
        v 1 1 0 0.5 0.5 0.5\nv -1 1 0 0.5 0.5 0.5\nv 0 0 1 0.5 0.5 0.5\nvn 0 0 1\nusemtl none\n\
        f 4//1 3//1 2//1 1//1\ng south\nf 1 2 5\nl 1 2 5\ns off\nf -4 -3 -1\nf 3 4 5\nf 4 1 5\n";

    fn text_of(wrong: Wrong) -> String {
        let Wrong {
            element,
            found,
            allowed,
        } = wrong;
        format!("{element}: found {found}, allowed: {allowed}")
    }

    #[test]
    fn polygons_groups_normals_colours_and_relative_indices_are_read() {
        let models = read(PYRAMID.as_bytes()).expect("a pyramid");
        assert_eq!(models.len(), 1, "groups are no models");
        let pyramid = &models[0];
        assert_eq!((pyramid.name.as_str(), pyramid.places.len()), ("roof", 5));
        assert_eq!(pyramid.triangles.len(), 6, "the polyline is no triangle");
        let edges = crate::verdict::edges(pyramid.triangles.iter().copied());
        assert!(edges.values().all(|met| *met == [1, 1]), "{edges:?}");
    }

    #[test]
    fn places_keep_all_their_digits() {
        let text = PYRAMID.replace("v 0 0 1", "v 4096512.0078125 0.1 1e-300");
        let models = read(text.as_bytes()).expect("a pyramid");
        let far: [f64; 3] = [4_096_512.007_812_5, 0.1, 1e-300];
        assert!(models[0].places.contains(&far));
    }

    #[test]
    fn each_broken_line_is_named_with_what_is_allowed() {
        for (from, to, message) in [
            (
                "v 1 -1 0 0.5",
                "v 1 1,5 0 0.5",
                r#"line 4: found "v 1 1,5 0 0.5 0.5 0.5", allowed: v x y z"#,
            ),
            (
                "v 1 1 0 0.5 0.5 0.5",
                "v 1 1 0 0.5 0.5",
                r#"line 5: found "v 1 1 0 0.5 0.5", allowed: v x y z, or v x y z r g b"#,
            ),
            (
                "v 0 0 1 0.5 0.5 0.5",
                "v 0 0 1 0",
                r#"line 7: found "v 0 0 1 0", allowed: a weight that is not 0"#,
            ),
            (
                "f 1 2 5",
                "f 1 two 5",
                r#"line 12: found "f 1 two 5", allowed: f and whole numbers, as v, v/vt or v/vt/vn"#,
            ),
            (
                "f 3 4 5",
                "f 3 4 6",
                r#"line 16: found "f 3 4 6", allowed: vertices 1 … 5, or -5 … -1"#,
            ),
            (
                "f -4 -3 -1",
                "f -4 -3 -6",
                r#"line 15: found "f -4 -3 -6", allowed: vertices 1 … 5, or -5 … -1"#,
            ),
            (
                "f 3 4 5",
                "f 0 4 5",
                r#"line 16: found "f 0 4 5", allowed: vertices 1 … 5, or -5 … -1"#,
            ),
            (
                "v 1 1 0 ",
                "v -0.9 -0.9 0 ",
                "object \"roof\", face 0: found a corner at [-0.9, -0.9, 0] that is dented, allowed: triangles and \
                 convex polygons; most programs triangulate on export",
            ),
            (
                "f 3 4 5",
                "f",
                "object \"roof\", face 3: found 0 corners, allowed: 3 and more",
            ),
        ] {
            assert!(PYRAMID.contains(from), "{from}");
            let broken = read(PYRAMID.replace(from, to).as_bytes());
            assert_eq!(text_of(broken.expect_err(to)), message);
        }
    }
}
