// SPDX-License-Identifier: MIT OR Apache-2.0
//! Casters that users bring: an OBJ or a GLB file as a mesh of models and parts.
//!
//! Metres, ENU axes. GLB is y up by its specification; OBJ says nothing, so the reader is given its
//! axis. An object of an OBJ file, and a node with a mesh of a GLB file, is a model. Faces are solids'
//! outsides, counter-clockwise. Materials, normals and textures cast no shadow and are not read.

mod glb;
mod model;
mod obj;
mod polygon;

use self::model::{Contents, Model, Wrong, wrong};
use crate::Mesh;
use crate::mesh::index;
use crate::pieces::pieces;
use glam::DVec3;
use std::path::Path;

/// The axis that points upwards in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Up {
    /// As most programs write OBJ, and as all write GLB: x right, y up, z towards the viewer.
    Y,
    /// As maps have it: x east, y north, z up.
    Z,
}

impl Up {
    fn enu(self, [x, y, z]: [f64; 3]) -> DVec3 {
        match self {
            Self::Y => DVec3::new(x, -z, y),
            Self::Z => DVec3::new(x, y, z),
        }
    }
}

/// What a file does not say of itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Of an OBJ file.
    pub up: Up,
    /// Length of a unit, m.
    pub unit_m: f64,
}

impl Default for Reading {
    fn default() -> Self {
        Self {
            up: Up::Y,
            unit_m: 1.0,
        }
    }
}

/// Why a file is no caster.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It cannot be read at all.
    #[error("{file}: {error}")]
    File {
        /// Path as given.
        file: String,
        /// What the system says.
        error: std::io::Error,
    },
    /// Something in it is not as it has to be.
    #[error("{file}: {element}: found {found}, allowed: {allowed}")]
    Element {
        /// Path as given.
        file: String,
        /// `line 7`, `accessors[2]`.
        element: String,
        /// What stands there.
        found: String,
        /// What may.
        allowed: String,
    },
}

/// A file's models.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFile {
    /// All of them.
    pub mesh: Mesh,
    /// What was read otherwise than the file says, or not at all.
    pub warnings: Vec<String>,
}

impl ModelFile {
    /// The models of an OBJ or GLB file. Each is parted where its triangles hang together no longer.
    ///
    /// # Errors
    /// [`ReadError`] with file, element, what was found and what is allowed.
    pub fn read(path: &Path, reading: Reading) -> Result<Self, ReadError> {
        let file = path.display().to_string();
        // A file that is no model by its name is refused unread, however large it is.
        reader(&file)?;
        let bytes = std::fs::read(path).map_err(|error| ReadError::File {
            file: file.clone(),
            error,
        })?;
        Self::parse(&file, &bytes, reading)
    }

    /// The models of a file's bytes.
    ///
    /// - `file`: its path, for messages; the extension says what the bytes are
    ///
    /// # Errors
    /// As [`ModelFile::read`].
    pub fn parse(file: &str, bytes: &[u8], reading: Reading) -> Result<Self, ReadError> {
        let (read, up) = reader(file)?;
        let named = |problem| named(file, problem);
        let up = up.unwrap_or(reading.up);
        let Contents { models, warnings } = read(bytes).map_err(named)?;
        let mesh = Mesh::of_models(models, |place| up.enu(place) * reading.unit_m);
        Ok(Self {
            mesh: mesh.map_err(named)?,
            warnings,
        })
    }
}

type Reader = fn(&[u8]) -> Result<Contents, Wrong>;

/// What reads a file of this name, and which axis points upwards where the format says so.
fn reader(file: &str) -> Result<(Reader, Option<Up>), ReadError> {
    let extension = Path::new(file).extension().unwrap_or_default();
    let extension = extension.to_string_lossy();
    match extension.to_ascii_lowercase().as_str() {
        "obj" => Ok((obj::read, None)),
        "glb" => Ok((glb::read, Some(Up::Y))),
        _ => {
            let found = format!("{extension:?}");
            Err(named(file, wrong("extension", found, "obj, glb")))
        }
    }
}

fn named(file: &str, problem: Wrong) -> ReadError {
    let Wrong {
        element,
        found,
        allowed,
    } = problem;
    ReadError::Element {
        file: file.to_owned(),
        element,
        found,
        allowed,
    }
}

impl Mesh {
    fn of_models(models: Vec<Model>, enu: impl Fn([f64; 3]) -> DVec3) -> Result<Self, Wrong> {
        let count: usize = models.iter().map(|model| model.places.len()).sum();
        if u32::try_from(count).is_err() {
            return Err(wrong("vertices", count, u32::MAX.to_string()));
        }
        let mut mesh = Self::default();
        for model in models
            .into_iter()
            .filter(|model| !model.triangles.is_empty())
        {
            let places = model.places.iter().map(|place| enu(*place));
            let places: Vec<DVec3> = places.collect();
            if let Some(at) = places.iter().position(|place| !place.is_finite()) {
                let element = format!("object {:?}, vertex {at}", model.name);
                let found = format!("{:?}", model.places[at]);
                return Err(wrong(element, found, "finite numbers"));
            }
            mesh.begin(&model.name);
            for piece in pieces(&places, &model.triangles) {
                let used = piece.iter().flatten().copied();
                let mut used: Vec<u32> = used.collect();
                used.sort_unstable();
                used.dedup();
                let vertices = used.iter().map(|at| places[*at as usize]).collect();
                mesh.push_part(vertices, piece.len(), |mesh, first| {
                    for corners in &piece {
                        // Sorted, and each corner is among them.
                        let own = |at: u32| used.partition_point(|other| *other < at);
                        mesh.push_face(&corners.map(|at| first + index(own(at))));
                    }
                });
            }
        }
        if mesh.triangles.is_empty() {
            Err(wrong("triangles", 0, "at least 1"))
        } else {
            Ok(mesh)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, bytes: &[u8], reading: Reading) -> Result<Mesh, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let read = ModelFile::read(&path, reading);
        read.map(|file| file.mesh).map_err(|error| {
            let text = error.to_string();
            let folder = format!("{}/", folder.path().display());
            assert!(text.starts_with(&folder), "{text}");
            text.replace(&folder, "")
        })
    }

    const TETRAHEDRON: &str =
        "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

    #[test]
    fn axes_and_units_are_as_told_and_the_mesh_stays_right_side_out() {
        let mesh = |up, unit_m| read("a.obj", TETRAHEDRON.as_bytes(), Reading { up, unit_m });
        let z_up = mesh(Up::Z, 1.0).expect("read");
        let y_up = mesh(Up::Y, 0.5).expect("read");
        for (mesh, places) in [
            (z_up, [DVec3::X * 2.0, DVec3::Y * 2.0, DVec3::Z * 2.0]),
            (y_up, [DVec3::X, DVec3::Z, -DVec3::Y]),
        ] {
            // `tobj` numbers them as faces name them.
            assert!(
                places.iter().all(|place| mesh.vertices.contains(place)),
                "{mesh:?}"
            );
            assert_eq!(crate::verdict(&mesh).to_string(), "closed");
        }
    }

    #[test]
    fn a_file_that_is_none_is_refused_by_its_name() {
        let missing = ModelFile::read(Path::new("no/such.glb"), Reading::default());
        let error = missing.expect_err("missing").to_string();
        assert!(error.starts_with("no/such.glb: "), "{error}");
        let text = read("a.stl", b"solid", Reading::default());
        assert_eq!(
            text.expect_err("no mesh"),
            r#"a.stl: extension: found "stl", allowed: obj, glb"#
        );
        let text = read("a.obj", b"# nothing\nv 0 0 0\n", Reading::default());
        assert_eq!(
            text.expect_err("empty"),
            "a.obj: triangles: found 0, allowed: at least 1"
        );
        let far = TETRAHEDRON.replace("v 2 0 0", "v 2 NaN 0");
        let text = read("a.obj", far.as_bytes(), Reading::default());
        assert_eq!(
            text.expect_err("no place"),
            r#"a.obj: object "unnamed_object", vertex 2: found [2.0, NaN, 0.0], allowed: finite numbers"#
        );
    }

    #[test]
    fn bodies_that_touch_are_parts_of_their_own() {
        // The second one shares an edge's places with the first, under numbers of its own.
        let second = "v 0 0 0\nv 0 2 0\nv -2 0 0\nv 0 0 2\nf 5 7 6\nf 5 8 7\nf 7 8 6\nf 6 8 5\n";
        let text = format!("{TETRAHEDRON}{second}");
        let reading = Reading {
            up: Up::Z,
            ..Reading::default()
        };
        let mesh = read("a.obj", text.as_bytes(), reading).expect("read");
        assert_eq!((mesh.casters.len(), mesh.parts.len()), (1, 2));
        assert_eq!(crate::verdict(&mesh).to_string(), "closed");
    }
}
