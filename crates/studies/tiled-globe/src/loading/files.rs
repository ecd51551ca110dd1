// SPDX-License-Identifier: MIT OR Apache-2.0
//! Tiles as files on disk, each a PNG of four bytes a texel, named by its number in a flight's list.

use crate::tile_set::SIDE;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _, ImageFormat};
use rayon::prelude::*;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use tempfile::TempDir;

/// A folder of tiles, which goes with the last reader.
#[derive(Debug)]
pub(crate) struct TileFiles {
    folder: TempDir,
    /// Of all files.
    pub(crate) bytes: u64,
}

fn failed(path: &Path, error: &dyn Display) -> String {
    format!("{}: {error}", path.display())
}

impl TileFiles {
    /// Writes all tiles.
    ///
    /// - `beside`: where their folder is made
    /// - `texels`: of a tile's number
    ///
    /// # Errors
    /// The path, and what the system says.
    pub(crate) fn write(
        beside: &Path,
        count: usize,
        texels: impl Fn(usize) -> Vec<u8> + Sync,
    ) -> Result<Self, String> {
        let folder = tempfile::tempdir_in(beside).map_err(|error| failed(beside, &error))?;
        let mut files = Self { folder, bytes: 0 };
        let bytes = AtomicU64::new(0);
        (0..count).into_par_iter().try_for_each(|number| {
            let path = files.path(number);
            let mut png = Vec::new();
            let (fast, filter) = (CompressionType::Fast, FilterType::Sub);
            PngEncoder::new_with_quality(&mut png, fast, filter)
                .write_image(&texels(number), SIDE, SIDE, ExtendedColorType::Rgba8)
                .map_err(|error| failed(&path, &error))?;
            bytes.fetch_add(png.len() as u64, Ordering::Relaxed);
            std::fs::write(&path, png).map_err(|error| failed(&path, &error))
        })?;
        files.bytes = bytes.into_inner();
        Ok(files)
    }

    fn path(&self, number: usize) -> PathBuf {
        self.folder.path().join(format!("{number}.png"))
    }

    /// Reads and decodes a tile.
    ///
    /// # Errors
    /// The path, and what is wrong with it.
    pub(crate) fn read(&self, number: usize) -> Result<Vec<u8>, String> {
        let path = self.path(number);
        let png = std::fs::read(&path).map_err(|error| failed(&path, &error))?;
        let picture = image::load_from_memory_with_format(&png, ImageFormat::Png);
        let picture = picture.map_err(|error| failed(&path, &error))?;
        let texels = picture.into_rgba8().into_raw();
        if texels.len() != 4 * (SIDE * SIDE) as usize {
            return Err(failed(&path, &"another size than a tile's"));
        }
        Ok(texels)
    }
}
