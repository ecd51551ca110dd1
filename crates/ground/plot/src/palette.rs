// SPDX-License-Identifier: MIT OR Apache-2.0
//! Colours and markers of the curves: one pair per curve name, the same in every plot of a report.
//!
//! The first two hues are those of Okabe and Ito (2008), "Color universal design". The others were
//! searched for the largest distance between any two in Oklab, as seen with full colour vision and as
//! simulated for the three dichromacies (Machado et al. 2009). Their contrast on the page is 4.5 : 1 or
//! more, as text needs. Each has a counterpart for dark pages. Plots are drawn in the light colours; the page's
//! style sheet swaps them. Twelve hues cannot all be told apart with two kinds of cones, so nothing rests
//! on colour alone: curves of one report differ in their markers too, and neighbours differ in both.

use plotters::style::RGBColor;

/// Ink of axes and text. No such colour is drawn: it becomes `currentColor`, the page's own.
pub(crate) const INK: RGBColor = RGBColor(1, 2, 3);

/// Background of the page behind open markers; becomes the page's own as [`INK`] does.
pub(crate) const PAPER: RGBColor = RGBColor(3, 2, 1);

/// Light and dark counterpart of each hue, in the order that keeps neighbours furthest apart.
const HUES: [[RGBColor; 2]; 12] = [
    [RGBColor(0x00, 0x72, 0xB2), RGBColor(0x56, 0xB4, 0xE9)],
    [RGBColor(0xC0, 0x54, 0x00), RGBColor(0xF2, 0x8B, 0x3C)],
    [RGBColor(0x3E, 0x42, 0x2B), RGBColor(0xA6, 0xF0, 0x48)],
    [RGBColor(0x6A, 0x26, 0xDF), RGBColor(0xB2, 0x7F, 0xFF)],
    [RGBColor(0xB0, 0x08, 0x5D), RGBColor(0xD7, 0x8E, 0xB4)],
    [RGBColor(0x1B, 0x2A, 0x80), RGBColor(0x62, 0x75, 0xFF)],
    [RGBColor(0x00, 0x64, 0x40), RGBColor(0x35, 0xDB, 0x9D)],
    [RGBColor(0x89, 0x16, 0x9A), RGBColor(0xFF, 0x84, 0xFF)],
    [RGBColor(0x80, 0x73, 0x63), RGBColor(0xE8, 0xCB, 0xD0)],
    [RGBColor(0x87, 0x0C, 0x00), RGBColor(0xA3, 0x82, 0x4E)],
    [RGBColor(0x06, 0x6F, 0x7A), RGBColor(0x6D, 0xE9, 0xFF)],
    [RGBColor(0x79, 0x4F, 0x02), RGBColor(0xDC, 0xBD, 0x22)],
];

/// Places of the hues that say faster and slower.
const GREEN: usize = 6;
const ORANGE: usize = 1;

/// Shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
    Plus,
    TriangleDown,
    Hourglass,
}

/// Seven of them and twelve hues have no common factor, so that 84 curves differ.
const MARKERS: [Marker; 7] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
    Marker::Plus,
    Marker::TriangleDown,
    Marker::Hourglass,
];

impl Marker {
    /// Corners around the middle, in half sizes, `y` downwards; `None` for the circle.
    pub(crate) fn corners(self) -> Option<&'static [[f64; 2]]> {
        Some(match self {
            Self::Circle => return None,
            Self::Square => &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
            Self::Triangle => &[[-1.1, 0.9], [1.1, 0.9], [0.0, -1.1]],
            Self::Diamond => &[[-1.3, 0.0], [0.0, 1.3], [1.3, 0.0], [0.0, -1.3]],
            Self::Plus => &[
                [-0.4, -1.2],
                [0.4, -1.2],
                [0.4, -0.4],
                [1.2, -0.4],
                [1.2, 0.4],
                [0.4, 0.4],
                [0.4, 1.2],
                [-0.4, 1.2],
                [-0.4, 0.4],
                [-1.2, 0.4],
                [-1.2, -0.4],
                [-0.4, -0.4],
            ],
            Self::TriangleDown => &[[-1.1, -0.9], [1.1, -0.9], [0.0, 1.1]],
            Self::Hourglass => &[[-1.1, -1.2], [1.1, -1.2], [-1.1, 1.2], [1.1, 1.2]],
        })
    }
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stroke {
    pub(crate) colour: RGBColor,
    pub(crate) marker: Marker,
}

/// A step that made things faster.
pub(crate) const FASTER: Stroke = Stroke {
    colour: HUES[GREEN][0],
    marker: Marker::Circle,
};

/// A step that made things slower.
pub(crate) const SLOWER: Stroke = Stroke {
    colour: HUES[ORANGE][0],
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
        /// Half the size in a box of 12 units.
        const HALF: f64 = 4.5;
        let Stroke { colour, marker } = self.stroke(series);
        let path = match marker.corners() {
            None => "M1 6a5 5 0 1 0 10 0a5 5 0 1 0-10 0z".to_owned(),
            Some(corners) => {
                let at = |corner: &[f64; 2]| {
                    let [x, y] = corner.map(|of| 6.0 + HALF * of);
                    format!("{x:.1} {y:.1}")
                };
                let corners: Vec<String> = corners.iter().map(at).collect();
                format!("M{}z", corners.join("L"))
            }
        };
        format!(
            "<svg class=\"marker\" viewBox=\"0 0 12 12\" aria-hidden=\"true\"><path fill=\"{}\" \
             d=\"{path}\"/></svg>",
            hex(colour)
        )
    }

    /// Where `series` stands. A name that is not in the palette stands where what is before its first comma does, or
    /// first.
    #[must_use]
    pub fn place(&self, series: &str) -> usize {
        let place = |wanted: &str| self.series.iter().position(|name| name == wanted);
        let plain = series.split(',').next().unwrap_or_default();
        place(series).or_else(|| place(plain)).unwrap_or_default()
    }

    /// How `series` is drawn. Curves repeat from the 85th on.
    pub(crate) fn stroke(&self, series: &str) -> Stroke {
        let index = self.place(series);
        Stroke {
            colour: HUES[index % HUES.len()][0],
            marker: MARKERS[index % MARKERS.len()],
        }
    }
}

/// Style sheet rules that swap each drawn colour for its counterpart on a dark page.
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

    /// From sRGB.
    fn linear(value: u8) -> f64 {
        let value = f64::from(value) / 255.0;
        if value <= 0.04045 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    }

    /// WCAG 2.2 relative luminance.
    fn luminance(colour: RGBColor) -> f64 {
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
        // Negative control: the palette's original yellow would not pass on white.
        assert!(contrast(RGBColor(0xF0, 0xE4, 0x42), RGBColor(255, 255, 255)) < 4.5);
    }

    fn strokes(count: usize) -> Vec<Stroke> {
        let names: Vec<String> = (0..count).map(|index| format!("{index:02}")).collect();
        let palette = Palette::new(names.clone());
        names.iter().map(|name| palette.stroke(name)).collect()
    }

    fn has_twice(strokes: &[Stroke]) -> bool {
        let mut rest = strokes;
        while let Some((first, after)) = rest.split_first() {
            if after.contains(first) {
                return true;
            }
            rest = after;
        }
        false
    }

    #[test]
    fn no_two_curves_share_colour_and_shape_and_neighbours_share_neither() {
        let strokes = strokes(84);
        assert!(!has_twice(&strokes));
        for pair in strokes.windows(2) {
            assert_ne!(pair[0].colour, pair[1].colour);
            assert_ne!(pair[0].marker, pair[1].marker);
        }
        // As many as there are hues, and any two differ in colour.
        for (index, stroke) in strokes[..HUES.len()].iter().enumerate() {
            let before = &strokes[..index];
            assert!(before.iter().all(|other| other.colour != stroke.colour));
        }
        // Negative control: one curve more repeats the first.
        assert!(has_twice(&self::strokes(85)));
    }

    /// A hue as somebody sees it who lacks the long, the medium or the short cones, after Machado et al.
    /// (2009), severity 1, in linear light; the first row of matrices is full colour vision.
    fn seen(colour: RGBColor) -> [[f64; 3]; 4] {
        const SIGHT: [[[f64; 3]; 3]; 4] = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [
                [0.152_286, 1.052_583, -0.204_868],
                [0.114_503, 0.786_281, 0.099_216],
                [-0.003_882, -0.048_116, 1.051_998],
            ],
            [
                [0.367_322, 0.860_646, -0.227_968],
                [0.280_085, 0.672_501, 0.047_413],
                [-0.011_820, 0.042_940, 0.968_881],
            ],
            [
                [1.255_528, -0.076_749, -0.178_779],
                [-0.078_411, 0.930_809, 0.147_602],
                [0.004_733, 0.691_367, 0.303_900],
            ],
        ];
        let light = [colour.0, colour.1, colour.2].map(linear);
        SIGHT.map(|sight| oklab(sight.map(|row| dot(row, light).clamp(0.0, 1.0))))
    }

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// Ottosson (2020), from linear sRGB.
    fn oklab(light: [f64; 3]) -> [f64; 3] {
        let cones = [
            [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
            [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
            [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
        ];
        let cones = cones.map(|row| dot(row, light).cbrt());
        [
            [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
            [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
            [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
        ]
        .map(|row| dot(row, cones))
    }

    /// Least distance in Oklab over the kinds of sight.
    fn distance(a: RGBColor, b: RGBColor) -> f64 {
        let pairs = seen(a).into_iter().zip(seen(b));
        let apart = pairs.map(|(a, b)| {
            let difference = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
            dot(difference, difference).sqrt()
        });
        apart.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn neighbours_differ_for_colour_blind_readers() {
        /// Five times the difference in Oklab that is just noticed, 0.02.
        const MIN_DISTANCE: f64 = 0.1;
        let after = HUES.iter().cycle().skip(1);
        for (place, (hue, next)) in HUES.iter().zip(after).enumerate() {
            for (a, b) in hue.iter().zip(next) {
                let apart = distance(*a, *b);
                assert!(apart >= MIN_DISTANCE, "{place}: {apart}");
            }
        }
        // Negative control: red and olive of one lightness.
        let [red, olive] = [RGBColor(0xC0, 0x54, 0x00), RGBColor(0x9C, 0x66, 0x00)];
        assert!(distance(red, olive) < MIN_DISTANCE);
    }
}
