// SPDX-License-Identifier: MIT OR Apache-2.0
//! Textures and pictures of a scene file.

use super::check::Check;
use super::raw::{RawFade, RawPicture, RawPlacement, RawTexture};
use crate::SceneError;
use crate::scene::{TexturedFills, View};
use crate::texture::{
    ImageSource, MAX_SIDE_PX, MIN_HATCH_PERIOD, MipChain, Outside, SceneTexture, TextureAnchor,
    TexturePlacement, TextureShare,
};

impl Check<'_> {
    pub(super) fn textured_fills(
        &self,
        raw: Option<&RawTexture>,
        views: &[View],
    ) -> Result<TexturedFills, SceneError> {
        let Some(raw) = raw else {
            return Ok(TexturedFills::default());
        };
        let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
        match &raw.quick_view {
            Some(found) if !names.contains(&found.as_str()) => {
                let found = format!("{found:?}");
                Err(self.refuse("texture.quick_view", found, names.join(", ")))
            }
            quick_view => Ok(TexturedFills {
                alone: raw.alone,
                quick_view: quick_view.clone(),
            }),
        }
    }

    /// Where a texture's picture comes from, and the texture with it; all values are checked.
    pub(super) fn texture(
        &self,
        raw: RawTexture,
    ) -> Result<(ImageSource, impl FnOnce(MipChain) -> SceneTexture + use<>), SceneError> {
        let picture = RawPicture {
            image: raw.image,
            checker: raw.checker,
            hatch: raw.hatch,
        };
        let image_source = self.image_source("texture", picture)?;
        let source = image_source.name();
        let share = self.choice(
            "texture.share",
            raw.share.as_deref(),
            [TextureShare::One, TextureShare::Each],
            TextureShare::name,
        )?;
        let alpha = self.within("texture.alpha", raw.alpha.unwrap_or(1.0), 0.0..=1.0)?;
        let placement = self.placement(&raw.placement)?;
        let fade_m = raw.fade.map(|fade| self.fade(&fade)).transpose()?;
        let with_picture = move |image| SceneTexture {
            source,
            image,
            share,
            alpha,
            placement,
            fade_m,
        };
        Ok((image_source, with_picture))
    }

    /// - `key`: what holds the three keys
    pub(super) fn image_source(
        &self,
        key: &str,
        raw: RawPicture,
    ) -> Result<ImageSource, SceneError> {
        match (raw.image, raw.checker, raw.hatch) {
            (Some(image), None, None) => {
                self.data_path(&format!("{key}.image.path"), &image.path)?;
                self.hash(&format!("{key}.image.sha256"), &image.sha256)?;
                Ok(ImageSource::File {
                    how: image
                        .how
                        .unwrap_or_else(|| format!("put {} into the data folder", image.path)),
                    path: image.path,
                    sha256: image.sha256,
                })
            }
            (None, Some(checker), None) => {
                // A cell has a colour of its own in steps of 8 bits: 64 are three apart.
                let cells = self.count(&format!("{key}.checker.cells"), checker.cells, 2..=64)?;
                let key = format!("{key}.checker.size");
                let size = self.count(&key, checker.size, 2..=i64::from(MAX_SIDE_PX))?;
                if !size.is_multiple_of(cells) {
                    return Err(self.refuse(key, size, format!("a multiple of {cells} cells")));
                }
                Ok(ImageSource::Checker { size, cells })
            }
            (None, None, Some(hatch)) => {
                let size_key = format!("{key}.hatch.size");
                let size = self.count(&size_key, hatch.size, 4..=i64::from(MAX_SIDE_PX))?;
                let most = i64::from(size / MIN_HATCH_PERIOD);
                let lines = self.count(&format!("{key}.hatch.lines"), hatch.lines, 1..=most)?;
                if !size.is_multiple_of(lines) {
                    let allowed = format!("a multiple of {lines} lines");
                    return Err(self.refuse(size_key, size, allowed));
                }
                Ok(ImageSource::Hatch { size, lines })
            }
            (image, checker, hatch) => {
                let given = [image.is_some(), checker.is_some(), hatch.is_some()];
                let found = if given.contains(&true) {
                    "several"
                } else {
                    "none"
                };
                Err(self.refuse(key, found, "exactly one of image, checker, hatch"))
            }
        }
    }

    pub(super) fn placement(&self, raw: &RawPlacement) -> Result<TexturePlacement, SceneError> {
        match raw {
            RawPlacement::Extents => Ok(TexturePlacement::Extents),
            RawPlacement::Anchor(raw) => {
                let key = |name: &str| format!("texture.placement.anchor.{name}");
                let place = [raw.longitude_deg, raw.latitude_deg, raw.rotation_deg];
                Ok(TexturePlacement::Anchor {
                    anchor: self.texture_anchor(&key, place)?,
                    width_m: self.positive(key("width_m"), raw.width_m)?,
                    height_m: self.positive(key("height_m"), raw.height_m)?,
                    outside: self.choice(
                        &key("outside"),
                        raw.outside.as_deref(),
                        [Outside::Repeat, Outside::Transparent],
                        Outside::name,
                    )?,
                })
            }
            RawPlacement::Pattern(raw) => {
                let key = |name: &str| format!("texture.placement.pattern.{name}");
                let place = [raw.longitude_deg, raw.latitude_deg, raw.rotation_deg];
                // Beyond a thousand texels a pixel, or pixels a texel, nothing can be made out.
                let texels_per_px =
                    self.within(key("texels_per_px"), raw.texels_per_px, 1e-3..=1e3)?;
                Ok(TexturePlacement::Pattern {
                    anchor: self.texture_anchor(&key, place)?,
                    texels_per_px,
                })
            }
        }
    }

    /// An anchor's longitude, latitude and rotation, degrees.
    pub(super) fn texture_anchor(
        &self,
        key: &dyn Fn(&str) -> String,
        [longitude, latitude, rotation]: [f64; 3],
    ) -> Result<TextureAnchor, SceneError> {
        // At a pole a metre east is no longitude, so the picture's middle must keep clear of it.
        let latitude = self.within(key("latitude_deg"), latitude, -89.9..=89.9)?;
        Ok(TextureAnchor {
            longitude_rad: self
                .within(key("longitude_deg"), longitude, -180.0..=180.0)?
                .to_radians(),
            latitude_rad: latitude.to_radians(),
            rotation_rad: self
                .within(key("rotation_deg"), rotation, -360.0..=360.0)?
                .to_radians(),
        })
    }

    pub(super) fn fade(&self, raw: &RawFade) -> Result<[f64; 2], SceneError> {
        let begin_m = raw.begin_m;
        if !(begin_m >= 0.0 && begin_m.is_finite()) {
            return Err(self.refuse("texture.fade.begin_m", begin_m, "0 or more"));
        }
        if !(raw.end_m > begin_m && raw.end_m.is_finite()) {
            let allowed = format!("greater than {begin_m}");
            return Err(self.refuse("texture.fade.end_m", raw.end_m, allowed));
        }
        Ok([begin_m, raw.end_m])
    }
}
