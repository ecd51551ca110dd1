// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pixels that a driver is known to lose: expected failures, typed by driver. A study says in which of its pictures.
//!
//! An expectation excuses exactly its pixels. One wrong pixel more is a wrong picture. A picture in
//! which they are right is a failure as well, since the expectation has to go then.

use terrafill_results::Status;

/// What of an adapter expectations depend on.
#[derive(Debug, Clone, Copy)]
pub struct Driver<'a> {
    /// The adapter's name.
    pub name: &'a str,
    /// The driver's version text, such as `Mesa 25.0.7-2 (LLVM 15.0.6)`.
    pub info: &'a str,
}

impl Driver<'_> {
    fn mesa(self) -> Option<[u32; 3]> {
        let text = self.info.split("Mesa ").nth(1)?;
        let end = text.find(|c: char| c != '.' && !c.is_ascii_digit());
        let mut numbers = text[..end.unwrap_or(text.len())].split('.');
        let mut next = || numbers.next()?.parse().ok();
        Some([next()?, next()?, next()?])
    }
}

/// Which driver it is that loses pixels, and why.
#[derive(Debug, Clone, Copy)]
pub struct DriverFault {
    /// Part of the adapter's name.
    pub adapter: &'static str,
    /// First and last Mesa release that it was seen with.
    pub mesa: [[u32; 3]; 2],
    /// How they are lost.
    pub reason: &'static str,
}

/// What llvmpipe loses where front faces are drawn, and then back faces. How it comes about stands at the head of
/// `crates/devices/vulkan/tests/culled_faces.rs`, which has it in a picture of slivers alone.
pub const LOSES_SLIVERS: DriverFault = DriverFault {
    adapter: "llvmpipe",
    mesa: [[25, 0, 0], [25, 0, 7]],
    reason: "a sliver less than 1/128 px wide is culled as front face and as back face",
};

impl DriverFault {
    /// Whether it is this driver's.
    #[must_use]
    pub fn is_of(&self, driver: Driver<'_>) -> bool {
        let [first, last] = self.mesa;
        driver.name.contains(self.adapter)
            && driver.mesa().is_some_and(|it| (first..=last).contains(&it))
    }

    /// How a case with this expectation ends, and why.
    ///
    /// - `objections`: to its picture as drawn; empty where there is none
    /// - `excused`: to the picture with the known pixels mended
    /// - `differing`: how many of the known pixels differed
    /// - `known`: how many there are
    #[must_use]
    pub fn settle(
        &self,
        objections: &str,
        excused: &str,
        differing: usize,
        known: usize,
    ) -> (Status, String) {
        if !excused.is_empty() {
            return (Status::Wrong, objections.to_owned());
        }
        let Self {
            adapter, reason, ..
        } = self;
        if differing < known {
            let reason = format!(
                "unexpected success: {differing} of {known} pixels differ that {adapter} is known \
                 to lose ({reason}); the expectation can go"
            );
            return (Status::Failed, reason);
        }
        let reason = format!("{known} px lost by a known fault of {adapter}: {reason}");
        (Status::DriverFault, reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAULT: DriverFault = LOSES_SLIVERS;

    #[test]
    fn an_expectation_is_one_drivers() {
        let name = "llvmpipe (LLVM 15.0.6, 256 bits)";
        let info = "Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)";
        assert!(FAULT.is_of(Driver { name, info }));
        // Negative controls: another adapter, later releases, none named.
        for [name, info] in [
            ["NVIDIA H100", info],
            [name, "Mesa 25.1.0 (LLVM 15.0.6)"],
            [name, "Mesa 25.0.8"],
            [name, "535.129"],
        ] {
            assert!(!FAULT.is_of(Driver { name, info }), "{name} {info}");
        }
    }

    #[test]
    fn neither_one_pixel_more_nor_one_less_is_excused() {
        let (status, reason) = FAULT.settle("1 px", "", 1, 1);
        assert_eq!(status, Status::DriverFault);
        let said = "1 px lost by a known fault of llvmpipe: a sliver";
        assert!(reason.starts_with(said), "{reason}");
        // Negative controls: another pixel beside it or instead, and none at all.
        let more = FAULT.settle("2 px", "1 px", 1, 1);
        assert_eq!(more, (Status::Wrong, "2 px".to_owned()));
        let (status, reason) = FAULT.settle("", "", 0, 1);
        assert_eq!(status, Status::Failed);
        assert!(reason.starts_with("unexpected success: 0 of 1"), "{reason}");
    }
}
