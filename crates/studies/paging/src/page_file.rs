// SPDX-License-Identifier: MIT OR Apache-2.0
//! The preprocessing: all pages of a texture in one file on disk, and reading them back.

use crate::texture::{PAGE_BYTES, Page, Texture};
use rayon::prelude::*;
use std::fs::File;
use std::io::{BufWriter, Read as _, Result, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// Pages that are made at a time: about 17 MB.
const AT_A_TIME: u32 = 256;

/// A file without a name, which goes when it is closed. Pages lie in the order of their numbers.
#[derive(Debug)]
pub(crate) struct PageFile {
    file: File,
}

impl PageFile {
    /// Makes all pages of a texture.
    ///
    /// - `folder`: where the file is
    ///
    /// # Errors
    /// Of the file.
    pub(crate) fn make(texture: &Texture, folder: &Path) -> Result<Self> {
        let mut file = BufWriter::new(tempfile::tempfile_in(folder)?);
        let count = texture.page_count();
        for first in (0..count).step_by(AT_A_TIME as usize) {
            let numbers = first..count.min(first + AT_A_TIME);
            let pages = numbers.into_par_iter();
            let pages = pages.map(|number| texture.page(Page::numbered(number as usize)));
            for page in pages.collect::<Vec<_>>() {
                file.write_all(&page)?;
            }
        }
        Ok(Self {
            file: file.into_inner()?,
        })
    }

    /// Reads a page's bytes, [`PAGE_BYTES`] of them.
    ///
    /// # Errors
    /// Of the file.
    pub(crate) fn read(&self, page: Page, bytes: &mut [u8]) -> Result<()> {
        let mut file = &self.file;
        let at = page.number() as u64 * PAGE_BYTES as u64;
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(bytes)
    }

    /// Bytes of it.
    ///
    /// # Errors
    /// Of the file.
    pub(crate) fn bytes(&self) -> Result<u64> {
        Ok(self.file.metadata()?.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Source;

    #[test]
    fn every_page_is_read_as_it_was_made_and_none_beyond_the_last() {
        let texture = Texture {
            source: Source::Addresses,
            finest: 3,
        };
        let folder = tempfile::tempdir().expect("a folder");
        let file = PageFile::make(&texture, folder.path()).expect("written");
        assert_eq!(file.bytes().expect("a size"), 85 * PAGE_BYTES as u64);
        let mut bytes = vec![0; PAGE_BYTES];
        for number in [84, 0, 21, 5] {
            let page = Page::numbered(number);
            file.read(page, &mut bytes).expect("read");
            assert_eq!(bytes[..], texture.page(page));
        }
        // Negative controls: another page, and one that there is not.
        assert_ne!(bytes[..], texture.page(Page::numbered(6)));
        assert!(file.read(Page::numbered(85), &mut bytes).is_err());
        // Nothing stays.
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("readable").count(),
            0
        );
    }
}
