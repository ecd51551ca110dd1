// SPDX-License-Identifier: MIT OR Apache-2.0
//! Colours and markers of the curves: one pair per curve name, the same in every plot of a report.
//!
//! The hues are those of Okabe and Ito (2008), "Color universal design", told apart under the common
//! colour-vision deficiencies. The light ones are darkened to a contrast of 4.5 : 1 on white, as text needs, and each
//! has a lighter twin for dark pages. Plots are drawn in the light colours; the page's style sheet
//! swaps them. Markers differ between neighbours, so nothing rests on colour alone.

use plotters::style::RGBColor;

/// Ink of axes and text. No such colour is drawn: it becomes `currentColor`, the page's own.
pub(crate) const INK: RGBColor = RGBColor(1, 2, 3);

/// Background of the page behind open markers; becomes the page's own as [`INK`] does.
pub(crate) const PAPER: RGBColor = RGBColor(3, 2, 1);

/// Light and dark twin of each hue.
const HUES: [[RGBColor; 2]; 8] = [
    [RGBColor(0x00, 0x72, 0xB2), RGBColor(0x56, 0xB4, 0xE9)],
    [RGBColor(0xC0, 0x54, 0x00), RGBColor(0xF2, 0x8B, 0x3C)],
    [RGBColor(0x00, 0x7F, 0x5C), RGBColor(0x2F, 0xC7, 0x9C)],
    [RGBColor(0xB2, 0x4C, 0x86), RGBColor(0xE3, 0x96, 0xC2)],
    [RGBColor(0x9C, 0x66, 0x00), RGBColor(0xF0, 0xB4, 0x29)],
    [RGBColor(0x5D, 0x3A, 0x9B), RGBColor(0xB0, 0x96, 0xE6)],
    [RGBColor(0x7A, 0x4A, 0x1E), RGBColor(0xC9, 0x9C, 0x6E)],
    [RGBColor(0x5E, 0x5E, 0x5E), RGBColor(0xAE, 0xAE, 0xAE)],
];

/// Shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
}

const MARKERS: [Marker; 4] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
];

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stroke {
    pub(crate) colour: RGBColor,
    pub(crate) marker: Marker,
}

/// A step that made things faster.
pub(crate) const FASTER: Stroke = Stroke {
    colour: HUES[2][0],
    marker: Marker::Circle,
};

/// A step that made things slower.
pub(crate) const SLOWER: Stroke = Stroke {
    colour: HUES[1][0],
    marker: Marker::Diamond,
};

/// The curves of a report.
#[derive(Debug)]
pub struct Palette {
    series: Vec<String>,
}

impl Palette {
    /// A palette for these curve names; their order fixes the colours.
    #[must_use]
    pub fn new(series: Vec<String>) -> Self {
        Self { series }
    }

    /// The marker of `series` as a drawing of its own, as high as a line of text.
    #[must_use]
    pub fn marker(&self, series: &str) -> String {
        let Stroke { colour, marker } = self.stroke(series);
        let path = match marker {
            Marker::Circle => "M1 6a5 5 0 1 0 10 0a5 5 0 1 0-10 0z",
            Marker::Square => "M1.5 1.5h9v9h-9z",
            Marker::Triangle => "M6 1l5 9.5h-10z",
            Marker::Diamond => "M6 .2l5.8 5.8-5.8 5.8-5.8-5.8z",
        };
        format!(
            "<svg class=\"marker\" viewBox=\"0 0 12 12\" aria-hidden=\"true\"><path fill=\"{}\" \
             d=\"{path}\"/></svg>",
            hex(colour)
        )
    }

    /// How `series` is drawn. Curves repeat from the 33rd on; a name that is not in the palette is
    /// drawn like what stands before its first comma, or like the first.
    pub(crate) fn stroke(&self, series: &str) -> Stroke {
        let place = |wanted: &str| self.series.iter().position(|name| name == wanted);
        let plain = series.split(',').next().unwrap_or_default();
        let index = place(series).or_else(|| place(plain)).unwrap_or_default();
        Stroke {
            colour: HUES[index % HUES.len()][0],
            marker: MARKERS[(index + index / HUES.len()) % MARKERS.len()],
        }
    }
}

/// Style sheet rules that swap each drawn colour for its twin on a dark page.
#[must_use]
pub fn dark_rules() -> String {
    HUES.iter()
        .map(|[light, dark]| {
            let (light, dark) = (hex(*light), hex(*dark));
            format!(
                "svg [fill=\"{light}\"]{{fill:{dark}}}svg [stroke=\"{light}\"]{{stroke:{dark}}}"
            )
        })
        .collect()
}

/// As plotters writes it into SVG.
pub(crate) fn hex(colour: RGBColor) -> String {
    format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// WCAG 2.2 relative luminance.
    fn luminance(colour: RGBColor) -> f64 {
        let linear = |value: u8| {
            let value = f64::from(value) / 255.0;
            if value <= 0.04045 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        };
        0.2126 * linear(colour.0) + 0.7152 * linear(colour.1) + 0.0722 * linear(colour.2)
    }

    fn contrast(a: RGBColor, b: RGBColor) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn every_hue_is_seen_on_its_page() {
        for [light, dark] in HUES {
            assert!(contrast(light, RGBColor(255, 255, 255)) >= 4.5, "{light:?}");
            assert!(
                contrast(dark, RGBColor(0x14, 0x17, 0x1c)) >= 4.5,
                "{dark:?}"
            );
        }
        // Twin: the palette's original yellow would not pass on white.
        assert!(contrast(RGBColor(0xF0, 0xE4, 0x42), RGBColor(255, 255, 255)) < 4.5);
    }

    #[test]
    fn thirty_two_curves_differ() {
        let names: Vec<String> = (0..32).map(|index| format!("{index:02}")).collect();
        let palette = Palette::new(names.clone());
        let strokes: Vec<Stroke> = names.iter().map(|name| palette.stroke(name)).collect();
        for (index, stroke) in strokes.iter().enumerate() {
            assert!(!strokes[..index].contains(stroke), "{index}");
        }
    }
}
