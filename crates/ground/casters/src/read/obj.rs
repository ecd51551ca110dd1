// SPDX-License-Identifier: MIT OR Apache-2.0
//! OBJ by `tobj`, in `f64`: surveyed places of 10⁶ m keep their millimetres.
//!
//! What casts no shadow is blanked before, lines and points among it: `tobj` takes a line of three places
//! for a triangle. Lines that a `\\` continues are joined, comments and a byte order mark cut off. Objects (`o`) are
//! models. Groups (`g`) are not: programs put the sides of one solid into several. Its errors name no line, so the
//! lines that it takes are counted.

use super::model::{Contents, Model, Wrong, wrong};
use super::polygon::triangles;
use glam::DVec3;
use std::collections::BTreeMap;
use std::io::{BufRead, Read};
use tobj::{LoadError, LoadOptions};

/// Keywords that are read.
const READ: [&str; 3] = ["v", "f", "o"];
/// Keywords that make no solid: normals, textures, materials, groups, names of files, lines and points, and what
/// belongs to free-form curves and surfaces, whose own keywords are said.
const HARMLESS: [&str; 34] = [
    "vn",
    "vt",
    "vp",
    "g",
    "s",
    "l",
    "p",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "trace_obj",
    "cstype",
    "deg",
    "bmat",
    "step",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "ctech",
    "stech",
    "curv",
    "curv2",
    "cdp",
    "res",
];

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

pub(super) fn read(bytes: &[u8]) -> Result<Contents, Wrong> {
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        return Err(wrong("first bytes", "UTF-16", "UTF-8 or ASCII"));
    }
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(&text);
    let lines = joined(text);
    let mut contents = Contents::default();
    contents.warnings.extend(not_read(&lines));
    let is_read = |line: &&str| READ.contains(&keyword(line));
    let kept = lines.iter().map(String::as_str);
    let kept = kept.map(|line| Some(line).filter(is_read).unwrap_or_default());
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
    let taken = counted.lines;
    let (loaded, _) = loaded.map_err(|error| at_line(&lines, taken, error))?;
    for model in &loaded {
        let (model, degenerate) = solid(model)?;
        contents.warn_degenerate(&model.name, degenerate);
        contents.models.push(model);
    }
    Ok(contents)
}

fn keyword(line: &str) -> &str {
    line.split_whitespace().next().unwrap_or_default()
}

/// Lines without comments, as many as the text has: one that is continued stands where it begins, and its rest is empty.
fn joined(text: &str) -> Vec<String> {
    // Old files of the Macintosh end lines by a carriage return alone.
    let end = if text.contains('\n') { '\n' } else { '\r' };
    let mut lines: Vec<String> = Vec::new();
    let mut begun: Option<usize> = None;
    for line in text.trim_end_matches(end).split(end) {
        // The name of an object may hold the sign.
        let line = match keyword(line) {
            "o" => line,
            _ => line.split('#').next().unwrap_or_default(),
        };
        let line = line.trim_end();
        let (line, is_continued) = match line.strip_suffix('\\') {
            Some(begin) => (begin, true),
            None => (line, false),
        };
        let own = lines.len();
        lines.push(String::new());
        let at = begun.unwrap_or(own);
        if at < own {
            lines[at].push(' ');
        }
        lines[at].push_str(line);
        begun = is_continued.then_some(at);
    }
    lines
}

/// Says which keywords were passed over that may make a solid.
fn not_read(lines: &[String]) -> Option<String> {
    let mut found: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for (number, line) in lines.iter().enumerate() {
        let keyword = keyword(line);
        if !keyword.is_empty() && !READ.contains(&keyword) && !HARMLESS.contains(&keyword) {
            found.entry(keyword).or_insert((number + 1, 0)).1 += 1;
        }
    }
    let one = |(keyword, (first, count)): (&&str, &(usize, usize))| {
        let keyword: String = keyword.chars().take(20).collect();
        format!("{keyword:?} ({count}, first in line {first})")
    };
    let all: Vec<String> = found.iter().take(10).map(one).collect();
    (!all.is_empty()).then(|| format!("lines that are not read: {}", all.join(", ")))
}

/// What is wrong, at the last line taken or, of an index, where that stands.
fn at_line(lines: &[String], taken: usize, error: LoadError) -> Wrong {
    let (number, allowed) = match error {
        LoadError::PositionParseError => (taken, "v x y z".to_owned()),
        LoadError::ColorParseError => (taken, "v x y z, or v x y z r g b".to_owned()),
        LoadError::ScalingByZeroError => (taken, "a weight that is not 0".to_owned()),
        LoadError::FaceParseError => (
            taken,
            "f and whole numbers, as v, v/vt or v/vt/vn".to_owned(),
        ),
        LoadError::FaceVertexOutOfBounds => missing_vertex(lines)
            .unwrap_or((taken, "faces behind the vertices that they name".to_owned())),
        other => (taken, format!("a line that tobj takes: {other}")),
    };
    let found = lines.get(number.saturating_sub(1));
    let found = found.map(String::as_str).unwrap_or_default();
    wrong(format!("line {number}"), format!("{found:?}"), allowed)
}

/// The first face that names a vertex which there is not: its line and what it may name.
fn missing_vertex(lines: &[String]) -> Option<(usize, String)> {
    let all = lines.iter().filter(|line| keyword(line) == "v").count();
    let mut before = 0;
    for (number, line) in lines.iter().enumerate() {
        match keyword(line) {
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

/// Faces as triangles, and how many had no area.
fn solid(loaded: &tobj::Model) -> Result<(Model, usize), Wrong> {
    let mesh = &loaded.mesh;
    let places = mesh.positions.chunks_exact(3);
    let places = places.map(|place| [place[0], place[1], place[2]]);
    let mut model = Model {
        name: loaded.name.clone(),
        places: places.collect(),
        triangles: Vec::new(),
    };
    // Of triangles alone there are no arities.
    let all_three = vec![3; mesh.indices.len() / 3];
    let arities = if mesh.face_arities.is_empty() {
        &all_three
    } else {
        &mesh.face_arities
    };
    let (mut first, mut degenerate) = (0, 0);
    for (face, arity) in arities.iter().enumerate() {
        let past = first + *arity as usize;
        let ring = mesh.indices.get(first..past).unwrap_or_default();
        first = past;
        let element = || format!("object {:?}, face {face}", model.name);
        if ring.len() < 3 {
            return Err(wrong(element(), format!("{arity} corners"), "3 and more"));
        }
        let mut ring = ring.to_vec();
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        if ring.len() < 3 {
            degenerate += 1;
            continue;
        }
        let places = ring
            .iter()
            .map(|at| DVec3::from(model.places[*at as usize]));
        let places: Vec<DVec3> = places.collect();
        let own = triangles(&places).map_err(|found| {
            let allowed = "a polygon whose edges do not cross; most programs triangulate on export";
            wrong(element(), found, allowed)
        })?;
        let own = own.iter().map(|corners| corners.map(|at| ring[at]));
        model.triangles.extend(own);
    }
    Ok((model, degenerate))
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
        let Contents { models, warnings } = read(PYRAMID.as_bytes()).expect("a pyramid");
        assert_eq!(models.len(), 1, "groups are no models");
        assert!(warnings.is_empty(), "{warnings:?}");
        let pyramid = &models[0];
        assert_eq!((pyramid.name.as_str(), pyramid.places.len()), ("roof", 5));
        assert_eq!(pyramid.triangles.len(), 6, "the polyline is no triangle");
        let edges = crate::verdict::edges(pyramid.triangles.iter().copied());
        assert!(edges.values().all(|met| *met == [1, 1]), "{edges:?}");
    }

    #[test]
    fn places_keep_all_their_digits() {
        let text = PYRAMID.replace("v 0 0 1", "v 4096512.0078125 0.1 1e-300");
        let models = read(text.as_bytes()).expect("a pyramid").models;
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
                "v -2 0 0 ",
                "object \"roof\", face 0: found edges that cross, so that areas of both sides are equal, allowed: a \
                 polygon whose edges do not cross; most programs triangulate on export",
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

    #[test]
    fn lines_are_continued_comments_cut_and_keywords_that_are_not_read_said() {
        let text = PYRAMID.replace("v 1 1 0 ", "v 1 \\\n 1 0 ").replace(
            "f 1 2 5\n",
            "f 1 2 5 # south\ncall other.obj\nsurf 0 1\nsurf 0 2\n",
        );
        let found = read(text.as_bytes()).expect("a pyramid");
        assert_eq!(
            found.models,
            read(PYRAMID.as_bytes()).expect("a pyramid").models
        );
        let words = "lines that are not read: \"call\" (1, first in line 14), \"surf\" (2, first in line 15)";
        assert_eq!(found.warnings, [words]);
        // Lines keep their numbers behind one that is continued.
        let broken = text.replace("f 3 4 5", "f 3 4 6");
        let text = text_of(read(broken.as_bytes()).expect_err("no such vertex"));
        assert!(text.starts_with("line 20: found \"f 3 4 6\""), "{text}");
        for ends in ["\r\n", "\r"] {
            let found = read(PYRAMID.replace('\n', ends).as_bytes()).expect("a pyramid");
            assert_eq!(found.models.len(), 1, "{ends:?}");
            assert_eq!(found.models[0].triangles.len(), 6, "{ends:?}");
        }
        let text = text_of(read(&[0xFF, 0xFE, b'v', 0]).expect_err("UTF-16"));
        assert_eq!(text, "first bytes: found UTF-16, allowed: UTF-8 or ASCII");
    }
}
