// SPDX-License-Identifier: MIT OR Apache-2.0
//! What devices are handed of a view: sea and casters, and volumes as a stencil program lists them.
//!
//! The origin is laid on the north pole of a sphere, so that ENU axes are the body's.

use crate::positions::Positions;
use crate::reference::SEA_RADIUS_M;
use crate::sea::surface;
use crate::view::DeckCamera;
use glam::{DMat3, DVec3};
use terrafill_casters::Mesh;
use terrafill_contract::{SurfaceView, ViewId};
use terrafill_core::{Ellipsoid, VolumeHeights};
use terrafill_plan::{DrawnAs, NearRectangle, PixelRect};
use terrafill_scene::Camera;
use terrafill_stencil::{DepthRange, FixedPoint, PositionFormat, VolumeConstants, VolumePlace};
use terrafill_study::Failure;

/// Hands over what a view sees, as devices draw it.
pub fn seen_by<T>(
    positions: Positions,
    view: &DeckCamera,
    mesh: &Mesh,
    use_it: impl FnOnce(SurfaceView<'_>) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let body =
        Ellipsoid::new("sea", SEA_RADIUS_M, SEA_RADIUS_M).ok_or_else(|| "no sphere".to_owned())?;
    use_it(SurfaceView {
        id: ViewId::unique(),
        body: &body,
        camera: &camera(view),
        size: view.image_size(),
        surface: &surface(positions, view, mesh),
        picture: None,
        // Of a lit face that looks away the light cap is drawn too. Beside a rim it is as near as what looks at
        // the eye, and a rounding nearer where the cap's depth must be no nearer than what is seen.
        draws_back_faces: true,
    })
}

fn camera(view: &DeckCamera) -> Camera {
    Camera {
        eye_ecef: view.eye + DVec3::Z * SEA_RADIUS_M,
        view_from_ecef: DMat3::from_cols(view.right, view.up, -view.forward).transpose(),
        fov_y_rad: 2.0 * view.tan[1].atan(),
        near_m: view.near,
    }
}

/// What the cover reads of each volume, and of an empty list one all the same: its colour.
pub fn constants(camera: &Camera, volumes: usize) -> Vec<VolumeConstants> {
    let place = VolumePlace {
        fixed: FixedPoint {
            origin_ecef: camera.eye_ecef,
            unit_m: 1.0,
        },
        first_vertex: 0,
        first_triangle_index: 0,
        first_loop_index: 0,
        triangle_count: 0,
        has_short_indices: false,
    };
    let heights = VolumeHeights {
        top_m: 0.0,
        bottom_m: 0.0,
    };
    let dark = [0.05, 0.06, 0.1, 1.0];
    let one = VolumeConstants::new(
        camera.eye_ecef,
        &place,
        heights,
        PositionFormat::Fixed,
        dark,
    );
    vec![one; volumes.max(1)]
}

/// A volume over the whole depth.
pub fn listed(screen_rect: PixelRect, geometry: usize) -> terrafill_stencil::Volume {
    terrafill_stencil::Volume {
        drawn_as: DrawnAs::Volume,
        screen_rect,
        depth: DepthRange::ANY,
        // The case names its depth rule; only `DepthRuleChoice::Automatic` reads this.
        near_rectangle: NearRectangle::Outside,
        geometry,
    }
}
