// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is measured of textured fill: the comparisons of the 2007 document, and how far each frame's
//! texture coordinates are from the reference's.
//!
//! The document compares a plain fill with its textured one: the world position by an inverse
//! view-projection in `f32`, normalised though nothing needs it, and both angles at the body's centre by
//! the device's own arctangent; then with one picture for all regions or one each, a large picture or a
//! small one, without the normalisation, and, proposed and never built, with arctangents from a 1D
//! texture or a series, or with a texture of spherical coordinates, or by barycentric coordinates in a flat
//! mesh. Each is a row beside the plain fill of the same rounds, and so is this project's route. Angles at the centre are not those by which the
//! picture lies, so that the document's rows may be wrong and are timed all the same. Errors in texels;
//! colours of 0 to 255.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use terrafill_conformance::{TextureErrors, Verdict, compare_texture, texture_verdict};
use terrafill_contract::{FillInput, Frame, NO_REGION, Picture};
use terrafill_reference::ReferenceBackend;
use terrafill_scene::{Scene, SceneTexture, TextureShare, View, checker};
use terrafill_study::Depth;
use terrafill_texture::PositionRoute;
use terrafill_variant::{RouteChoice, Switches, Variant};

/// Scenes over the surfaces of published globes: made for their surfaces and views, not for the comparison of
/// techniques.
const GLOBE_SCENES: [&str; 2] = ["screen-grid", "spiral"];

/// Scenes that are about pictures, which say so themselves: only textured fills are drawn of them, each once.
const PICTURE_SCENES: [&str; 6] = [
    "blue-marble",
    "fade",
    "hatching",
    "shared-picture",
    "window-west",
    "window-east",
];

/// The device's own arctangent, and geodetic latitude.
const NATIVE_ROUTE: &str = "atan2-native";

/// The document's angles.
const ROUTE_OF_2007: &str = "atan2-native+geocentric";

/// What the document proposes instead: a 1D texture, a series, and a texture of spherical coordinates. That
/// one is a cube about the body's centre, which is made once, in place of one that every frame makes anew.
const PROPOSALS_OF_2007: [&str; 3] = [
    "lut-256-r16-linear+geocentric",
    "odd-7+geocentric",
    "cube-512",
];

/// What the document proposes against precision problems. The offset that it starts from is the region's,
/// which has none of its own: what is left is how flat the region is.
const FLAT_MESH_OF_2007: (&str, PositionRoute) = ("barycentric", PositionRoute::EyeRegion);

/// Texels along the side of the document's small picture, and cells of a checker of that size.
const SMALL_PX: u32 = 32;
const SMALL_CELLS: u32 = 16;

/// How much a difference of colours is amplified, so that one level of 255 can be seen.
const AMPLIFIED: i32 = 10;

/// Where a difference has no meaning: not filled by both with the same region.
const NOT_COMPARED: [u8; 3] = [18, 20, 26];

/// Which picture a textured case shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) enum ShownPicture {
    /// The scene's, shared as the scene says.
    #[default]
    Scene,
    /// The scene's, a copy for each region.
    Each,
    /// A checker of 32² texels.
    Small,
}

impl ShownPicture {
    /// `key=value` in the variant; empty for the scene's own.
    #[must_use]
    pub(crate) fn name(self) -> Option<&'static str> {
        match self {
            Self::Scene => None,
            Self::Each => Some("picture=each"),
            Self::Small => Some("picture=32"),
        }
    }

    /// The same view with the picture shown; `None` where the scene has none.
    pub(crate) fn input(self, input: &FillInput) -> Option<FillInput> {
        let texture = input.scene.texture.as_deref()?;
        let shown = match self {
            Self::Scene => return Some(input.clone()),
            Self::Each => SceneTexture {
                share: TextureShare::Each,
                ..texture.clone()
            },
            Self::Small => SceneTexture {
                source: format!("checker {SMALL_PX}² of {SMALL_CELLS}² cells"),
                image: checker(SMALL_PX, SMALL_CELLS)?,
                ..texture.clone()
            },
        };
        let mut changed = input.clone();
        changed.scene.texture = Some(Arc::new(shown));
        Some(changed)
    }
}

/// Whether only textured fills of a scene are drawn.
pub(crate) fn is_picture_scene(scene: &Scene) -> bool {
    scene.textured.alone
}

/// The textured cases of a technique in one view, from its main variant `plain`.
///
/// - `is_first`: whether it is the technique that the comparisons are made with
pub(crate) fn textured_variants(
    plain: &Variant,
    is_first: bool,
    scene: &Scene,
    view: &View,
    quick: bool,
) -> Vec<(Variant, ShownPicture)> {
    if scene.texture.is_none() {
        return Vec::new();
    }
    let is_quick_view = scene.textured.quick_view.as_ref() == Some(&view.name);
    let by = |choice: RouteChoice| {
        let textured = plain.clone();
        let textured = textured.with_switches(|switches| switches.texture = Some(choice));
        (textured, ShownPicture::Scene)
    };
    let chosen = by(RouteChoice::Chosen);
    let native = RouteChoice::parse(NATIVE_ROUTE).filter(|_| is_first);
    let native = native.map(by);
    if is_picture_scene(scene) {
        return std::iter::once(chosen).chain(native).collect();
    }
    if quick {
        let both = std::iter::once(chosen).chain(native);
        return both.filter(|_| is_quick_view && is_first).collect();
    }
    let mut variants = vec![chosen];
    if let Some(native) = native {
        variants.extend([native, by(RouteChoice::Floor)]);
        variants.extend(document_variants(plain));
    }
    variants
}

/// The document's fill, as it was and with each of its changes.
fn document_variants(plain: &Variant) -> Vec<(Variant, ShownPicture)> {
    let from = |route: &str, position: PositionRoute| {
        plain.clone().with_switches(|switches| {
            switches.texture = RouteChoice::parse(route);
            switches.position = Some(position);
        })
    };
    let by = |route: &str| from(route, PositionRoute::InverseEcef);
    let needed = by(ROUTE_OF_2007);
    let as_it_was = needed
        .clone()
        .with_switches(|s| s.superfluous_normalize = true);
    let proposals = PROPOSALS_OF_2007.map(|route| (by(route), ShownPicture::Scene));
    let changes = [
        (as_it_was.clone(), ShownPicture::Scene),
        (as_it_was.clone(), ShownPicture::Each),
        (as_it_was, ShownPicture::Small),
        (needed, ShownPicture::Scene),
    ];
    let (route, position) = FLAT_MESH_OF_2007;
    let flat_mesh = (from(route, position), ShownPicture::Scene);
    changes
        .into_iter()
        .chain(proposals)
        .chain([flat_mesh])
        .collect()
}

/// Whether a case is one of the document's textured fills.
pub(crate) fn is_of_2007(switches: &Switches) -> bool {
    switches.position.is_some()
}

/// The reference's textured frames of one view: one for each size of picture, drawn when first asked
/// for. How many copies there are changes nothing that is seen.
#[derive(Default)]
pub(crate) struct TexturedReferences {
    known: RefCell<BTreeMap<[u32; 2], KnownReference>>,
}

type KnownReference = Result<Rc<TexturedReference>, String>;

/// What the reference says of a textured frame.
pub(crate) struct TexturedReference {
    frame: Frame,
    rgb: Vec<u8>,
}

impl TexturedReferences {
    fn of(&self, input: &FillInput) -> KnownReference {
        let Some(texture) = &input.scene.texture else {
            return Err("the scene has no picture to compare with".to_owned());
        };
        let mut known = self.known.borrow_mut();
        let draw = || {
            let drawn = ReferenceBackend::textured().judge(input);
            let drawn = drawn.map_err(|error| error.to_string())?;
            let missing = || "the reference drew no picture".to_owned();
            Ok(Rc::new(TexturedReference {
                rgb: drawn.picture.ok_or_else(missing)?,
                frame: drawn.frame,
            }))
        };
        let size = texture.image.size_px();
        known.entry(size).or_insert_with(draw).clone()
    }

    /// Errors of the places that a textured frame's texels come from, and what speaks against them.
    pub(crate) fn compare(
        &self,
        input: &FillInput,
        frame: &Frame,
    ) -> (Option<TextureErrors>, Vec<String>) {
        let compared = self.of(input).and_then(|reference| {
            compare_texture(&reference.frame, frame).map_err(|error| error.to_string())
        });
        match compared {
            Ok(errors) => match texture_verdict(&errors) {
                Verdict::Pass => (Some(errors), Vec::new()),
                Verdict::Fail(reasons) => (Some(errors), reasons),
            },
            Err(error) => (None, vec![error]),
        }
    }

    /// Lays a backend's picture beside the reference's.
    ///
    /// # Errors
    /// One sentence: there is no reference, or what lies under a translucent fill shows, which the
    /// reference paints in one colour.
    pub(crate) fn pictures(
        &self,
        input: &FillInput,
        frame: &Frame,
        picture: &Picture,
    ) -> Result<Pictures, String> {
        let reference = self.of(input)?;
        let texture = input.scene.texture.as_deref();
        let is_opaque =
            texture.is_some_and(|texture| texture.alpha >= 1.0 && texture.fade_m.is_none());
        if !is_opaque {
            return Err(
                "no difference of colours: what lies under the fill shows, and the reference \
                 paints it in one colour"
                    .to_owned(),
            );
        }
        let found = picture.rgb();
        Ok(Pictures::new(
            &reference.frame.ids,
            &frame.ids,
            &reference.rgb,
            found,
            input.size.width as usize,
        ))
    }
}

/// A backend's picture, the reference's, and ten times their difference; RGB.
pub(crate) struct Pictures {
    pub(crate) found: Vec<u8>,
    pub(crate) reference: Vec<u8>,
    pub(crate) difference: Vec<u8>,
    /// Largest difference of a channel, and the mean over channels and pixels compared; `None` where
    /// no pixel was.
    pub(crate) largest: Option<u64>,
    pub(crate) mean: Option<f64>,
    /// Column and row of the middle of the pixels compared.
    pub(crate) centre: [usize; 2],
}

impl Pictures {
    /// Pixels count that both fill with the same region: `expected` and `ids` say with which.
    fn new(expected: &[u32], ids: &[u32], reference: &[u8], found: Vec<u8>, width: usize) -> Self {
        let mut difference = Vec::with_capacity(found.len());
        let (mut largest, mut sum, mut count) = (0, 0_u64, 0_u64);
        let pixels = reference.chunks_exact(3).zip(found.chunks_exact(3));
        for ((a, b), (expected, id)) in pixels.zip(expected.iter().zip(ids)) {
            if *id == NO_REGION || id != expected {
                difference.extend(NOT_COMPARED);
                continue;
            }
            for (a, b) in a.iter().zip(b) {
                let apart = (i32::from(*a) - i32::from(*b)).abs();
                let shown = (apart * AMPLIFIED).clamp(0, 255);
                difference.push(u8::try_from(shown).unwrap_or(u8::MAX));
                largest = largest.max(apart.unsigned_abs());
                sum += u64::from(apart.unsigned_abs());
                count += 1;
            }
        }
        let is_compared = count > 0;
        Self {
            found,
            reference: reference.to_vec(),
            difference,
            centre: centre(expected, ids, width),
            largest: is_compared.then_some(u64::from(largest)),
            mean: is_compared.then(|| sum as f64 / count as f64),
        }
    }
}

/// Mean column and row of the pixels that both fill with the same region.
fn centre(expected: &[u32], ids: &[u32], width: usize) -> [usize; 2] {
    let alike = (0..ids.len()).filter(|&at| ids[at] != NO_REGION && ids[at] == expected[at]);
    let (count, columns, rows) = alike.fold((0, 0, 0), |(count, columns, rows), at| {
        (count + 1, columns + at % width, rows + at / width)
    });
    [columns, rows].map(|sum| sum / count.max(1))
}

/// Why a run over all scenes that is not in full depth leaves one out.
pub(crate) fn left_out(name: &str, depth: Depth) -> Option<String> {
    let reason = match depth {
        _ if PICTURE_SCENES.contains(&name) => {
            "its pictures are left out of quick runs over all scenes; name it to see them"
        }
        _ if GLOBE_SCENES.contains(&name) => {
            "only full runs over all scenes draw published globes; name it to measure it"
        }
        // The largest scenes by far: the smaller of them took a sixth of the time of a quick run.
        Depth::Quick if ["countries-50m", "countries-10m"].contains(&name) => {
            "quick runs over all scenes have these regions in countries-110m; name it to measure it"
        }
        _ => return None,
    };
    Some(reason.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::TECHNIQUES;
    use terrafill_scene::Overlap;

    #[test]
    fn scenes_that_are_about_pictures_say_so_themselves() {
        for name in terrafill_scene::shipped_scene_names() {
            let text = terrafill_scene::shipped_scene_text(name).expect("it ships");
            let is_alone = text.lines().any(|line| line == "alone = true");
            assert_eq!(PICTURE_SCENES.contains(&name), is_alone, "{name}");
        }
    }

    fn plain() -> Variant {
        TECHNIQUES[0].main(Overlap::Disjoint)
    }

    fn names(scene: &str, view: usize, quick: bool) -> Vec<String> {
        let scene = Scene::shipped(scene, None).expect("needs no data");
        let view = &scene.views[view];
        textured_variants(&plain(), true, &scene, view, quick)
            .into_iter()
            .map(|(variant, shown)| {
                let shown = shown.name().map(|name| format!(",{name}"));
                variant.name() + &shown.unwrap_or_default()
            })
            .collect()
    }

    #[test]
    fn the_documents_comparisons_are_all_there() {
        let all = names("california", 0, false);
        assert_eq!(
            all,
            [
                "doubled,texture=chosen",
                "doubled,texture=atan2-native+bowring-1",
                "doubled,texture=floor",
                "doubled,normalize=superfluous,position=inverse-ecef,texture=atan2-native+geocentric",
                "doubled,normalize=superfluous,position=inverse-ecef,texture=atan2-native+geocentric,picture=each",
                "doubled,normalize=superfluous,position=inverse-ecef,texture=atan2-native+geocentric,picture=32",
                "doubled,position=inverse-ecef,texture=atan2-native+geocentric",
                "doubled,position=inverse-ecef,texture=lut-256-r16-linear+geocentric",
                "doubled,position=inverse-ecef,texture=odd-7+geocentric",
                "doubled,position=inverse-ecef,texture=cube-512",
                "doubled,texture=barycentric",
            ]
        );
        assert_eq!(names("planet-134", 0, false), all);
    }

    #[test]
    fn a_quick_run_takes_one_view() {
        let views = [0, 1, 2].map(|view| names("california", view, true).len());
        assert_eq!(views, [0, 2, 0]);
        assert_eq!(names("planet-134", 1, true).len(), 0);
    }

    #[test]
    fn a_scene_without_a_picture_has_no_textured_cases() {
        let mut scene = Scene::shipped("california", None).expect("needs no data");
        scene.texture = None;
        let variants = textured_variants(&plain(), true, &scene, &scene.views[0], false);
        assert!(variants.is_empty());
    }

    #[test]
    fn a_difference_of_colours_counts_where_both_fill_alike() {
        // Four pixels: alike, one level apart, another region, none.
        let reference = [100, 100, 100].repeat(4);
        let mut found = reference.clone();
        found[4] = 101;
        found[6] = 0;
        found[9] = 0;
        let pictures = Pictures::new(&[1, 1, 1, 0], &[1, 1, 2, 0], &reference, found.clone(), 2);
        assert_eq!(pictures.difference[..6], [0, 0, 0, 0, 10, 0]);
        assert_eq!(
            pictures.difference[6..],
            [NOT_COMPARED, NOT_COMPARED].concat()
        );
        assert_eq!(
            (pictures.largest, pictures.mean),
            (Some(1), Some(1.0 / 6.0))
        );
        // Negative controls: a difference that the third pixel has counts once it is the same region; with none
        // alike there is no figure, which is not 0.
        let alike = Pictures::new(&[1, 1, 2, 0], &[1, 1, 2, 0], &reference, found.clone(), 2);
        assert_eq!(alike.largest, Some(100));
        let none = Pictures::new(&[1; 4], &[2; 4], &reference, found, 2);
        assert_eq!((none.largest, none.mean), (None, None));
    }

    #[test]
    fn the_centre_lies_in_what_is_filled() {
        assert_eq!(centre(&[0, 1, 0, 1], &[0, 1, 0, 1], 2), [1, 0]);
        assert_eq!(centre(&[0, 0, 2, 2], &[0, 0, 1, 2], 2), [1, 1]);
    }
}
