// SPDX-License-Identifier: MIT OR Apache-2.0
//! The technique as the contract knows it.

use crate::backend::CesiumBackend;
use crate::browser::Browser;
use crate::way::{CesiumFill, NAME};
use std::path::{Path, PathBuf};
use terrafill_contract::{
    Api, DeviceError, GeometryBytes, OpenedBackend, Role, THIS_MACHINE, Targets, Technique, layouts,
};
use terrafill_core::{EdgeRule, Ellipsoid, RegionMesh};
use terrafill_gpu::shared_targets;
use terrafill_scene::{Overlap, Scene};
use terrafill_surface::{EllipsoidKind, SurfaceKind as _};
use terrafill_variant::{Parameter, SwitchError, Variant};

/// Variable that names the folder into which `ci/peers.sh` has fetched CesiumJS.
pub const FOLDER: &str = "TERRAFILL_PEERS";

/// Variable that names the browser.
const CHROMIUM: &str = "CHROMIUM";

/// Browsers to look for where none is named.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

const API: Api = Api { name: "webgl" };

const PARAMETERS: &[Parameter] = &[
    Parameter::one_of(
        "path",
        &["volumes", "lookup"],
        "its classification volumes, or this project's lookup in it",
    ),
    Parameter::one_of(
        "tiles",
        &["default", "fine"],
        "how fine its terrain is: its default, or errors of a pixel",
    ),
];

/// Error that its tiles may show, pixels (`Globe.maximumScreenSpaceError`): CesiumJS's own default, and two
/// levels finer, by which what is left of an error is told apart from that of the tiles.
const TILES: [(&str, f64); 2] = [("default", 2.0), ("fine", 0.5)];

/// CesiumJS in headless Chromium.
#[derive(Debug)]
pub struct CesiumTechnique;

/// What is needed: the folder of the release build, and the browser.
fn needs() -> Result<(PathBuf, PathBuf), String> {
    let folder = std::env::var_os(FOLDER).ok_or_else(|| {
        format!("CesiumJS ({FOLDER} is not set; ci/peers.sh fetches and measures it)")
    })?;
    let cesium = Path::new(&folder).join("node_modules/cesium/Build/Cesium");
    if !cesium.join("Cesium.js").is_file() {
        return Err(format!(
            "CesiumJS (no {})",
            cesium.join("Cesium.js").display()
        ));
    }
    on_path("node").ok_or("node")?;
    let named = std::env::var_os(CHROMIUM).map(PathBuf::from);
    let chromium = named.or_else(|| BROWSERS.into_iter().find_map(on_path));
    let chromium =
        chromium.ok_or_else(|| format!("Chromium ({CHROMIUM} names another browser)"))?;
    Ok((cesium, chromium))
}

fn on_path(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let mut places = std::env::split_paths(&path).map(|folder| folder.join(program));
    places.find(|place| place.is_file())
}

impl Technique for CesiumTechnique {
    fn name(&self) -> &'static str {
        NAME
    }

    fn api(&self) -> Api {
        API
    }

    fn terms(&self) -> &'static [(&'static str, &'static str)] {
        &[
            (
                "cesium",
                "CesiumJS in headless Chromium, what a user would pick instead",
            ),
            ("volumes", "its own classification volumes"),
            (
                "lookup",
                "its terrain with this project's lookup of regions in it",
            ),
        ]
    }

    fn missing(&self) -> Option<String> {
        needs().err()
    }

    /// Volumes have arcs, the lookup lines that are straight in longitude and latitude.
    fn edge_rule(&self, variant: &Variant, scene: EdgeRule) -> EdgeRule {
        match CesiumFill::of(variant) {
            Ok(CesiumFill::Volumes) => EdgeRule::GreatEllipse,
            Ok(CesiumFill::Lookup) => EdgeRule::Planar,
            Err(_) => scene,
        }
    }

    fn draws_own_surface(&self) -> bool {
        true
    }

    fn parameters(&self) -> &'static [Parameter] {
        PARAMETERS
    }

    /// It draws a globe of the Earth's shape without relief.
    fn variants(&self, scene: &Scene, role: Role) -> Vec<Variant> {
        let is_its_globe =
            scene.body == Ellipsoid::WGS84 && scene.surface.kind == EllipsoidKind.name();
        match role {
            Role::Main if is_its_globe => {
                let fine = self.main(scene.overlap).with("tiles", "fine");
                let ways = layouts(self, scene.overlap).into_iter();
                ways.chain([fine]).collect()
            }
            Role::Quick if is_its_globe => layouts(self, scene.overlap),
            _ => Vec::new(),
        }
    }

    fn check(&self, variant: &Variant, _: Overlap) -> Result<(), SwitchError> {
        variant.choice("tiles", &TILES)?;
        CesiumFill::of(variant).map(drop)
    }

    /// Its geometry is its own affair; what it holds is counted when it is drawn.
    fn bytes(
        &self,
        variant: &Variant,
        _: &RegionMesh,
        _is_drawn: bool,
    ) -> Result<GeometryBytes, SwitchError> {
        CesiumFill::of(variant).map(|_| GeometryBytes::default())
    }

    fn open(&self, targets: &Targets, variant: &Variant) -> OpenedBackend {
        let way = CesiumFill::of(variant)?;
        let tiles_px = variant.choice("tiles", &TILES)?;
        let (cesium, chromium) =
            needs().map_err(|what| DeviceError::unsupported(&what, THIS_MACHINE))?;
        let is_software = shared_targets(targets)?.borrow().gpu().facts.is_software();
        let browser = Browser::start(&cesium, &chromium, targets.size(), is_software)?;
        let backend = CesiumBackend::new(browser, way, tiles_px, targets.size())?;
        Ok(Box::new(backend))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_way_has_its_edges() {
        let of = |way| {
            let variant = CesiumTechnique.main(Overlap::Disjoint).with("path", way);
            CesiumTechnique.edge_rule(&variant, EdgeRule::Planar)
        };
        assert_eq!(of("volumes"), EdgeRule::GreatEllipse);
        assert_eq!(of("lookup"), EdgeRule::Planar);
    }

    #[test]
    fn scenes_with_relief_are_left_out() {
        let variants = |name: &str| {
            let scene = Scene::shipped(name, None).expect("it ships");
            CesiumTechnique.variants(&scene, Role::Main).len()
        };
        assert_eq!(variants("california"), 3);
        assert_eq!(variants("hills"), 0);
    }
}
