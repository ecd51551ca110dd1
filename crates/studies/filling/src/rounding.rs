// SPDX-License-Identifier: MIT OR Apache-2.0
//! How many pixels a way of storing positions may move a boundary by in one view, by formula.
//!
//! Metres, ECEF axes; pixels of the image. A stored corner, relative to the eye, is off by at most the
//! roundings of its format along each axis ([`VertexFormat::residual_m`]). Everything between two
//! corners by no more than the worse of them, since it is a mixture of both. Off by e at a depth of z, a
//! point moves by at most e·f·√(1 + tan²) / z pixels, where f is a pixel's reciprocal at distance 1
//! and tan the point's distance from the middle of the image there. What the shader computes from the
//! position on is the same in every format, and verified with the default.

use glam::DVec3;
use terrafill_contract::FillInput;
use terrafill_stencil::{FixedPoint, PositionFormat};
use terrafill_texture::VertexFormat;

/// Pixels that rounding may move a boundary by, so that the picture may be expected to be right: a
/// quarter, as for texels.
pub(crate) const ALLOWED_PX: f64 = 0.25;

/// Why a view is not drawn in a format: its roundings may be seen there. `None` where they may not.
pub(crate) fn objection(format: PositionFormat, bound_px: f64) -> Option<String> {
    // Not `>`: a bound that is no number promises nothing.
    let is_right = bound_px <= ALLOWED_PX;
    (!is_right).then(|| {
        format!(
            "{} rounds by up to {bound_px:.2} px here, allowed {ALLOWED_PX}",
            format.name()
        )
    })
}

/// The largest movement of a boundary in sight, pixels; 0 where none is in sight.
pub(crate) fn rounding_px(format: PositionFormat, input: &FillInput) -> f64 {
    let format = match format {
        PositionFormat::Fixed => VertexFormat::RegionFixedPoint,
        PositionFormat::LocalF32 => VertexFormat::RegionLocalF32,
        PositionFormat::EcefF32 => VertexFormat::EcefF32,
        PositionFormat::TwoFloat => VertexFormat::TwoFloat,
    };
    let eye = input.camera.eye_ecef;
    let px_at_1_m = 1.0 / input.camera.pixel_size_m(input.size, 1.0);
    let mut worst_px = 0.0_f64;
    for planned in &input.plan.regions {
        let mesh = &input.scene.meshes[planned.mesh];
        let origin = FixedPoint::for_mesh(mesh).origin_ecef;
        let error_m = |vertex: DVec3| {
            let along = |axis: usize| {
                let radius_m = vertex[axis].abs().max(eye[axis].abs());
                let extent_m = (vertex[axis] - origin[axis]).abs();
                format.residual_m(radius_m, extent_m, (vertex[axis] - eye[axis]).abs())
            };
            DVec3::from_array([0, 1, 2].map(along)).length()
        };
        for ends in mesh.boundary_edges() {
            let [from, to] = ends.map(|end| mesh.vertices_ecef[end as usize]);
            if let Some(nearness) = largest_in_sight(input, from, to) {
                let moved_px = error_m(from).max(error_m(to)) * px_at_1_m * nearness;
                worst_px = worst_px.max(moved_px);
            }
        }
    }
    worst_px
}

/// √(1 + tan²) / z of the point of an edge that is in the image, on this side of the horizon, and has
/// most; `None` where no point is.
fn largest_in_sight(input: &FillInput, from: DVec3, to: DVec3) -> Option<f64> {
    let camera = &input.camera;
    let [start, end] = [from, to].map(|at| camera.view_from_ecef * (at - camera.eye_ecef));
    let tan_y = camera.tan_half_fov();
    let tan_x = tan_y * input.size.aspect();
    // Distances inside the planes of the frustum, linear along the edge.
    let inside = |at: DVec3| {
        let depth = -at.z;
        [
            depth - camera.near_m,
            depth * tan_x - at.x,
            depth * tan_x + at.x,
            depth * tan_y - at.y,
            depth * tan_y + at.y,
        ]
    };
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (a, b) in inside(start).into_iter().zip(inside(end)) {
        match (a < 0.0, b < 0.0) {
            (true, true) => return None,
            (true, false) => first = first.max(a / (a - b)),
            (false, true) => last = last.min(a / (a - b)),
            (false, false) => {}
        }
    }
    if first > last {
        return None;
    }
    // (x, y, z a²/b²) of a point of an ellipsoid is along its normal.
    let body = &input.scene.body;
    let flattening = body.equatorial_radius_m() / body.polar_radius_m();
    let scale = DVec3::new(1.0, 1.0, flattening * flattening);
    // Largest at an end: the reciprocal of a distance from the eye, or near enough.
    [first, last]
        .into_iter()
        .filter(|along| {
            let at = from.lerp(to, *along);
            (at * scale).dot(camera.eye_ecef - at) > 0.0
        })
        .map(|along| {
            let at = start.lerp(end, along);
            at.length() / (at.z * at.z)
        })
        .reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_contract::PreparedScene;
    use terrafill_core::RegionMesh;
    use terrafill_plan::PlanOptions;
    use terrafill_scene::ImageSize;
    use terrafill_stencil::{two_float, two_float_difference_m};
    use terrafill_surface::EllipsoidKind;

    const SIZE: ImageSize = ImageSize::new(1024, 1024);

    fn inputs(name: &str) -> Vec<FillInput> {
        let scene = terrafill_scene::Scene::open(name, None).expect("ships with the project");
        let meshes =
            RegionMesh::build_all(&scene.regions, &scene.body, scene.edge_rule, &scene.mesh);
        let surface = EllipsoidKind::surface(&scene.body, 60);
        let prepared = PreparedScene::new(&scene, meshes.expect("meshes").into(), surface);
        let views = scene.views.iter();
        views
            .map(|view| FillInput::new(&prepared, view, SIZE, PlanOptions::default()))
            .map(|input| input.expect("a surface"))
            .collect()
    }

    /// A corner relative to the eye as stored and subtracted by the shader, in its arithmetic.
    fn as_stored(
        format: PositionFormat,
        vertex: DVec3,
        eye: DVec3,
        origin: DVec3,
    ) -> Option<DVec3> {
        Some(match format {
            PositionFormat::Fixed => return None,
            PositionFormat::LocalF32 => {
                ((vertex - origin).as_vec3() - (eye - origin).as_vec3()).as_dvec3()
            }
            PositionFormat::EcefF32 => (vertex.as_vec3() - eye.as_vec3()).as_dvec3(),
            PositionFormat::TwoFloat => {
                two_float_difference_m(two_float(vertex), two_float(eye)).as_dvec3()
            }
        })
    }

    /// How far boundaries really move, pixels, at places along them that are in the image.
    fn emulated_px(format: PositionFormat, input: &FillInput) -> Option<f64> {
        let camera = &input.camera;
        let eye = camera.eye_ecef;
        let mut worst = 0.0_f64;
        for planned in &input.plan.regions {
            let mesh = &input.scene.meshes[planned.mesh];
            let origin = FixedPoint::for_mesh(mesh).origin_ecef;
            for ends in mesh.boundary_edges() {
                let exact = ends.map(|end| mesh.vertices_ecef[end as usize]);
                let [from, to] = exact.map(|at| as_stored(format, at, eye, origin));
                let stored = [eye + from?, eye + to?];
                for step in 0..=64 {
                    let [at, moved] =
                        [exact, stored].map(|[from, to]| from.lerp(to, f64::from(step) / 64.0));
                    let px = |at| camera.project_px(input.size, at);
                    if largest_in_sight(input, at, at).is_some()
                        && let (Some([x, y]), Some([u, v])) = (px(at), px(moved))
                    {
                        worst = worst.max((u - x).hypot(v - y));
                    }
                }
            }
        }
        Some(worst)
    }

    #[test]
    fn no_boundary_in_sight_moves_by_more_than_the_bound_and_some_by_a_good_part() {
        let mut closest = [0.0_f64; 3];
        for name in ["square-10m", "square-200km"] {
            for input in inputs(name) {
                for (k, format) in PositionFormat::ALL[1..].iter().enumerate() {
                    let bound_px = rounding_px(*format, &input);
                    let found_px = emulated_px(*format, &input).expect("floats");
                    let (view, format) = (&input.view, format.name());
                    eprintln!("{name}/{view} {format}: {found_px:.3e} of {bound_px:.3e} px");
                    assert!(found_px <= bound_px, "{name}/{view} {format}");
                    closest[k] = closest[k].max(found_px / bound_px);
                }
            }
        }
        // Negative control: a bound an eighth as large would have been noticed in every format.
        assert!(closest.iter().all(|share| *share > 0.125), "{closest:?}");
    }

    #[test]
    fn views_from_close_by_are_not_asked_of_what_rounds_there() {
        let inputs = inputs("square-200km");
        let of = |view: &str, format| {
            let input = inputs.iter().find(|input| input.view == view);
            objection(format, rounding_px(format, input.expect("a view")))
        };
        for (view, naive, local) in [
            ("edge-1m5", true, true),
            ("edge-50m", true, false),
            ("along-50m", true, false),
            ("down-500km", false, false),
        ] {
            let asked = |format| of(view, format).is_some();
            assert_eq!(asked(PositionFormat::EcefF32), naive, "{view}");
            assert_eq!(asked(PositionFormat::LocalF32), local, "{view}");
            assert!(!asked(PositionFormat::Fixed), "{view}");
            assert!(!asked(PositionFormat::TwoFloat), "{view}");
        }
        let reason = of("edge-1m5", PositionFormat::EcefF32).expect("half a metre from 1.5 m");
        assert!(reason.starts_with("ecef-f32 rounds by up to "), "{reason}");
        assert!(reason.ends_with(" px here, allowed 0.25"), "{reason}");
    }

    #[test]
    fn a_bound_at_the_limit_is_asked_and_no_number_is_not() {
        let is_left_out = |px: f64| objection(PositionFormat::LocalF32, px).is_some();
        assert!(!is_left_out(0.0) && !is_left_out(ALLOWED_PX));
        assert!(is_left_out(ALLOWED_PX + 1e-9) && is_left_out(f64::NAN));
    }
}
