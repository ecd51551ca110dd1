// SPDX-License-Identifier: MIT OR Apache-2.0
//! The bare ellipsoid: the same triangles in every view.

use crate::{
    HeightRange, Parameters, Surface, SurfaceError, SurfaceFrame, SurfaceKind, SurfaceMesh,
};
use std::sync::Arc;
use terrafill_core::{Ellipsoid, Extent};
use terrafill_scene::{Camera, ImageSize};

/// Name in scene files.
const KIND: &str = "ellipsoid";

/// Rows where a scene names none: 1°.
const DEFAULT_ROWS: u32 = 180;

/// Scenes of the bare body: `kind = "ellipsoid"`, `rows` of the grid from pole to pole.
#[derive(Debug, Clone, Copy)]
pub struct EllipsoidKind;

impl EllipsoidKind {
    /// The bare ellipsoid in `rows` rows from pole to pole.
    #[must_use]
    pub fn surface(body: &Ellipsoid, rows: u32) -> Arc<dyn Surface> {
        Arc::new(EllipsoidSurface {
            mesh: SurfaceMesh::ellipsoid(body, rows),
        })
    }
}

impl SurfaceKind for EllipsoidKind {
    fn name(&self) -> &'static str {
        KIND
    }

    fn open(
        &self,
        body: &Ellipsoid,
        parameters: &mut Parameters<'_>,
    ) -> Result<Arc<dyn Surface>, SurfaceError> {
        // Four rows are the fewest that close, 4,096 are 67 million triangles.
        let rows = parameters.count("rows", DEFAULT_ROWS, 4..=4096)?;
        Ok(Self::surface(body, rows))
    }
}

#[derive(Debug)]
struct EllipsoidSurface {
    mesh: SurfaceMesh,
}

impl Surface for EllipsoidSurface {
    fn kind(&self) -> &'static str {
        KIND
    }

    /// The same everywhere: facets hang deepest where the body is most curved.
    fn heights(&self, _extent: &Extent) -> HeightRange {
        self.mesh.heights
    }

    fn true_height_m(&self, _longitude_deg: f64, _latitude_deg: f64) -> Option<f64> {
        Some(0.0)
    }

    fn frame(&self, camera: &Camera, size: ImageSize) -> Result<SurfaceFrame, SurfaceError> {
        self.mesh.frame_by_blocks(KIND, camera, size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open_surface;
    use terrafill_scene::{Scene, SurfaceFile};

    fn opened(surface: &str) -> Result<Arc<dyn Surface>, String> {
        let text = format!(
            "name = \"t\"\ndescription = \"d\"\nbody = \"wgs84\"\n\
             [regions]\nembedded = \"california.geojson\"\n[surface]\n{surface}\n\
             [[views]]\nname = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\n\
             heading_deg = 0\npitch_deg = 0\n"
        );
        let scene = Scene::from_toml(&text, "t.toml", None).expect("a scene");
        open_surface(&[&EllipsoidKind], &scene).map_err(|error| error.to_string())
    }

    #[test]
    fn a_scene_names_its_surface() {
        for text in ["", "kind = \"ellipsoid\"", "rows = 4"] {
            assert_eq!(opened(text).expect(text).kind(), "ellipsoid");
        }
    }

    #[test]
    fn what_is_wrong_with_a_surface_is_named() {
        for (text, wrong) in [
            (
                "kind = \"plane\"",
                "kind: found \"plane\", allowed: ellipsoid",
            ),
            ("rows = 3", "rows: found 3, allowed: 4 to 4096"),
            ("rows = -3", "rows: found -3, allowed: 4 to 4096"),
            ("rows = 4.5", "rows: found 4.5, allowed: 4 to 4096"),
            (
                "rows = \"many\"",
                "rows: found \"many\", allowed: 4 to 4096",
            ),
            (
                "row = 90",
                "row: found 90, allowed: only the keys kind, rows; did you mean \"rows\"?",
            ),
        ] {
            let expected = format!("t.toml: surface.{wrong}");
            assert_eq!(opened(text).expect_err(text), expected);
        }
    }

    #[test]
    fn files_that_a_kind_does_not_take_are_refused() {
        let text = "name = \"t\"\ndescription = \"d\"\nbody = \"wgs84\"\n\
             [regions]\nembedded = \"california.geojson\"\n\
             [[views]]\nname = \"a\"\nlongitude_deg = 0\nlatitude_deg = 0\nheight_m = 1\n\
             heading_deg = 0\npitch_deg = 0\n";
        let mut scene = Scene::from_toml(text, "t.toml", None).expect("a scene");
        assert!(open_surface(&[&EllipsoidKind], &scene).is_ok());
        scene.surface.files = vec![SurfaceFile {
            path: "a.tif".to_owned(),
            bytes: Arc::default(),
        }];
        let error = open_surface(&[&EllipsoidKind], &scene).expect_err("files");
        assert_eq!(
            error.to_string(),
            "t.toml: surface.files: found 1, allowed: none, since surfaces of the kind ellipsoid are \
             made from no file"
        );
    }
}
