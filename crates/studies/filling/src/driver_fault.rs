// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pixels that a driver is known to lose: expected failures, typed by driver, scene, view, size and
//! variant.

use crate::cases::FillCase;
use crate::subject::Subject;
use terrafill_contract::Frame;
use terrafill_results::Status;
use terrafill_scene::ImageSize;
use terrafill_study::{Driver, DriverFault, LOSES_SLIVERS};
use terrafill_variant::{DepthRuleChoice, FacePasses};

/// What a driver loses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LostPixels {
    fault: DriverFault,
    scene: &'static str,
    view: &'static str,
    size: ImageSize,
    is_hit: fn(&FillCase) -> bool,
    /// Column and row, from the upper left corner.
    pixels: &'static [[u32; 2]],
}

/// Every expectation.
///
/// `countries-50m`, `fill`, pixel (503, 451): Chile, on the far side of the Earth, is drawn there where
/// horizon culling is off. The pixel's centre lies in the top cap of its volume, 0.0002 px outside of
/// the bottom cap, and between them in one wall: two triangles of 1.45 by 0.0004 px, as the test below
/// computes. Front and back faces cancel unless the wall is lost, which takes China's pixel from the
/// picture. `crates/devices/vulkan/tests/culled_faces.rs` has the same fault in a picture of slivers
/// alone.
const KNOWN: [LostPixels; 1] = [LostPixels {
    fault: LOSES_SLIVERS,
    scene: "countries-50m",
    view: "fill",
    size: ImageSize::new(1024, 1024),
    is_hit: draws_each_face_alone,
    pixels: &[[503, 451]],
}];

/// Front and back faces in a pass each, counted behind the surface, the far side of the body included,
/// with walls as lists: strips give a sliver's corners in another order, in which it is not lost.
fn draws_each_face_alone(case: &FillCase) -> bool {
    let Subject::Fill(technique, variant) = &case.subject else {
        return false;
    };
    let has_lists = match technique.name() {
        "vertex" => variant.layout() == "per-triangle" || variant.value("walls") == Some("list"),
        name => ["compute", "instanced"].contains(&name),
    };
    let switches = &variant.switches;
    has_lists
        && switches.faces == FacePasses::TwoPass
        && switches.depth_rule == DepthRuleChoice::Fail
        && !variant.plan.horizon_culling
}

impl LostPixels {
    /// The expectation of a case, if there is one.
    pub(crate) fn of(
        driver: Driver<'_>,
        scene: &str,
        view: &str,
        size: ImageSize,
        case: &FillCase,
    ) -> Option<&'static Self> {
        KNOWN.iter().find(|own| {
            own.fault.is_of(driver)
                && (own.scene, own.view, own.size) == (scene, view, size)
                && (own.is_hit)(case)
        })
    }

    /// The frame with the reference's ids in the known pixels, and how many of them differed.
    ///
    /// - `as_mask`: only whether a pixel is filled counts
    pub(crate) fn excused(
        &self,
        frame: &Frame,
        reference: &Frame,
        as_mask: bool,
    ) -> (Frame, usize) {
        let mut excused = frame.clone();
        let compared = |id: u32| if as_mask { id.min(1) } else { id };
        let mut differing = 0;
        for [column, row] in self.pixels {
            let place = *row as usize * self.size.width as usize + *column as usize;
            if let (Some(id), Some(expected)) =
                (excused.ids.get_mut(place), reference.ids.get(place))
            {
                differing += usize::from(compared(*id) != compared(*expected));
                *id = *expected;
            }
        }
        (excused, differing)
    }

    /// How a case with this expectation ends.
    ///
    /// - `reasons`: against its picture as drawn
    /// - `excused`: against the picture with the known pixels mended
    /// - `differing`: how many of the known pixels differed
    pub(crate) fn settle(
        &self,
        reasons: &[String],
        excused: &[String],
        differing: usize,
    ) -> (Status, String) {
        let [objections, excused] = [reasons, excused].map(|all| all.join("; "));
        let known = self.pixels.len();
        self.fault.settle(&objections, &excused, differing, known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::purpose::Purpose;
    use crate::tests::TECHNIQUES;
    use std::sync::Arc;
    use terrafill_contract::{FillInput, PreparedScene};
    use terrafill_core::{RegionMesh, VolumeHeights};
    use terrafill_fixtures::distance_and_width;
    use terrafill_plan::PlanOptions;
    use terrafill_scene::{Overlap, Scene};
    use terrafill_variant::Variant;

    const THIS: Driver<'_> = Driver {
        name: "llvmpipe (LLVM 15.0.6, 256 bits)",
        info: "Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)",
    };

    fn case(technique: usize, parameters: &[(&'static str, &'static str)]) -> FillCase {
        let technique = TECHNIQUES[technique];
        let overlap = Overlap::Disjoint;
        let mut variant = technique.main(overlap);
        for (key, value) in parameters {
            variant = variant.with(key, value);
        }
        variant.switches.faces = FacePasses::TwoPass;
        variant.plan.horizon_culling = false;
        FillCase::new(Subject::Fill(technique, variant), Purpose::Ablation, 0)
    }

    fn expected(driver: Driver<'_>, case: &FillCase) -> bool {
        let size = KNOWN[0].size;
        LostPixels::of(driver, "countries-50m", "fill", size, case).is_some()
    }

    #[test]
    fn an_expectation_is_one_drivers_views_and_variants() {
        let compute = case(1, &[]);
        assert!(expected(THIS, &compute));
        assert!(expected(THIS, &case(0, &[("layout", "per-triangle")])));
        assert!(expected(THIS, &case(0, &[("walls", "list")])));
        // Negative controls: another adapter, view, size and variant.
        let name = "NVIDIA H100";
        assert!(!expected(Driver { name, ..THIS }, &compute));
        let size = KNOWN[0].size;
        let smaller = ImageSize { width: 512, ..size };
        let of = |scene, view, size| LostPixels::of(THIS, scene, view, size, &compute).is_some();
        assert!(!of("countries-50m", "globe", size) && !of("countries-110m", "fill", size));
        assert!(!of("countries-50m", "fill", smaller));
        assert!(!expected(THIS, &case(0, &[])) && !expected(THIS, &case(2, &[])));
        let changes: [fn(&mut Variant); 3] = [
            |variant| variant.plan.horizon_culling = true,
            |variant| variant.switches.faces = FacePasses::TwoSided,
            |variant| variant.switches.depth_rule = DepthRuleChoice::Automatic,
        ];
        for change in changes {
            let mut other = case(1, &[]);
            if let Subject::Fill(_, variant) = &mut other.subject {
                change(variant);
            }
            assert!(!expected(THIS, &other), "{}", other.variant_name());
        }
    }

    #[test]
    fn exactly_the_known_pixels_are_excused() {
        let fault = &KNOWN[0];
        let count = fault.size.pixel_count();
        let reference = Frame {
            size: fault.size,
            ids: vec![42; count],
            surface: vec![true; count],
            non_finite: 0,
            counters: None,
            texture: None,
        };
        let place = 451 * 1024 + 503;
        let drawn = |wrong: &[usize]| {
            let mut frame = reference.clone();
            for &pixel in wrong {
                frame.ids[pixel] = 0;
            }
            frame
        };
        let settled = |wrong: &[usize]| {
            let frame = drawn(wrong);
            let (excused, differing) = fault.excused(&frame, &reference, false);
            let objections = |frame: &Frame| -> Vec<String> {
                let pairs = frame.ids.iter().zip(&reference.ids);
                let wrong = pairs.filter(|(a, b)| a != b).count();
                (wrong > 0)
                    .then(|| format!("{wrong} px"))
                    .into_iter()
                    .collect()
            };
            fault.settle(&objections(&frame), &objections(&excused), differing)
        };
        let (status, reason) = settled(&[place]);
        assert_eq!(status, Status::DriverFault);
        assert!(reason.starts_with("1 px lost by a known fault of llvmpipe: a sliver"));
        // Negative controls: a second pixel, another one instead, and none at all.
        assert_eq!(settled(&[place, 7]), (Status::Wrong, "2 px".to_owned()));
        assert_eq!(settled(&[7]), (Status::Wrong, "1 px".to_owned()));
        let (status, reason) = settled(&[]);
        assert_eq!(status, Status::Failed);
        assert!(reason.starts_with("unexpected success: 0 of 1"), "{reason}");
        // As a mask, another region's id is right.
        let mut other = reference.clone();
        other.ids[place] = 9;
        assert_eq!(fault.excused(&other, &reference, true).1, 0);
        assert_eq!(fault.excused(&other, &reference, false).1, 1);
    }

    #[test]
    #[ignore = "needs data: natural-earth-50m"]
    fn the_known_pixel_lies_in_a_sliver() {
        let fault = &KNOWN[0];
        let data = terrafill_fixtures::data::folder();
        let scene = Arc::new(Scene::shipped(fault.scene, Some(&data)).expect("its data"));
        let view = scene.views.iter().find(|view| view.name == fault.view);
        let view = view.expect("a view").clone();
        let meshes = crate::scenes::build_meshes(&scene, &scene.mesh).expect("meshes");
        let surface = terrafill_surface::open_surface(&[&terrafill_surface::EllipsoidKind], &scene)
            .expect("an ellipsoid");
        let prepared = PreparedScene::new(&scene, meshes, surface);
        let plan = PlanOptions {
            horizon_culling: false,
            frustum_culling: false,
            too_small_culling: false,
            ..PlanOptions::default()
        };
        let input = FillInput::new(&prepared, &view, fault.size, plan);
        let input = input.expect("a frame");
        let slivers = |pixel: [u32; 2]| -> Vec<(String, f64)> {
            let centre = pixel.map(|at| f64::from(at) + 0.5);
            let mut found = Vec::new();
            for planned in &input.plan.regions {
                let mesh = &input.scene.meshes[planned.mesh];
                let walls = walls_px(mesh, &input, &planned.heights);
                let walls = walls.map(|corners| distance_and_width(centre, corners));
                let over = walls.filter(|[away, width]| *away == 0.0 && *width < 1.0 / 128.0);
                found.extend(over.map(|[_, width]| (mesh.name.clone(), width)));
            }
            found
        };
        let [column, row] = fault.pixels[0];
        let found = slivers([column, row]);
        // One of the two triangles of the wall, by either of its diagonals.
        assert_eq!(found.len(), 2, "{found:?}");
        for (name, width_px) in &found {
            assert!(name == "Chile" && *width_px < 4e-4, "{found:?}");
        }
        // Negative control: the pixel beside it.
        assert_eq!(slivers([column + 1, row]), []);
    }

    /// Triangles of the walls of a region's volume in the image, by both diagonals.
    fn walls_px<'a>(
        mesh: &'a RegionMesh,
        input: &'a FillInput,
        heights: &'a VolumeHeights,
    ) -> impl Iterator<Item = [[f64; 2]; 3]> + 'a {
        let at = move |vertex: u32, height_m: f64| {
            let place = mesh.vertices_deg[vertex as usize].map(f64::to_radians);
            let up = input.scene.body.geodetic_surface_normal(place[0], place[1]);
            let ecef = mesh.vertices_ecef[vertex as usize] + up * height_m;
            input.camera.project_px(input.size, ecef)
        };
        let edges = mesh.boundary_loops.iter().flat_map(|of_loop| {
            let next = of_loop.iter().cycle().skip(1);
            of_loop.iter().zip(next)
        });
        edges.flat_map(move |(&from, &to)| {
            let [a, c] = [from, to].map(|vertex| at(vertex, heights.top_m));
            let [b, d] = [from, to].map(|vertex| at(vertex, heights.bottom_m));
            let triangles = [[a, b, c], [b, d, c], [a, b, d], [a, d, c]];
            let whole = triangles.into_iter();
            whole.filter_map(|[a, b, c]| Some([a?, b?, c?]))
        })
    }
}
