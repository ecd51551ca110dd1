// SPDX-License-Identifier: MIT OR Apache-2.0
//! A drawing in pixels on plotters' SVG backend: the few marks that the plots are made of.

use crate::error::PlotError;
use crate::number::{count, significant};
use crate::palette::{INK, PAPER, Stroke, hex};
use crate::scale::whole;
use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::{Color, DrawingArea, IntoDrawingArea, IntoFont, RGBAColor, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontStyle, FontTransform, RGBColor, ShapeStyle, TextStyle};
use std::cell::RefCell;
use std::collections::BTreeSet;

/// Text height of labels, CSS pixels.
pub(crate) const TEXT_PX: f64 = 12.0;

/// plotters writes this part of the asked size into the SVG.
const FONT_SIZE_RATIO: f64 = 1.24;

/// Mean advance of a sans-serif character over the text height, on the wide side.
const ADVANCE: f64 = 0.56;

/// Half the size of a marker, pixels.
pub(crate) const MARKER_PX: f64 = 4.5;

/// Which point of a text stands at the given position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Left,
    Middle,
    Right,
}

/// Half the size of the part of a drawing that answers to a pointer, pixels: as a finger needs it.
const SPOT_PX: f64 = 10.0;

/// Lines of this opacity, and no others, are dashed.
const DASHED_OPACITY: f64 = 0.75;

/// What plotters writes on each element, and what stands for it: for most it is said once, on the
/// drawing.
const SHORTER: [(&str, &str); 9] = [
    (" font-family=\"sans-serif\" font-size=\"12\"", ""),
    (" fill=\"none\"", ""),
    (" stroke-width=\"1\"", ""),
    (" stroke=\"none\"", ""),
    (" opacity=\"1\"", ""),
    (
        " opacity=\"0.75\"",
        " opacity=\"0.75\" stroke-dasharray=\"5 4\"",
    ),
    (" \"/>", "\"/>"),
    (">\n", ">"),
    ("\n</text>", "</text>"),
];

/// What [`SHORTER`] leaves out.
const COMMON: &str = "font-family=\"sans-serif\" font-size=\"12\" fill=\"none\" stroke-width=\"1\"";

/// A drawing under way.
pub(crate) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
    plot: &'a str,
    /// Elements of the spots.
    spots: RefCell<String>,
    /// Names and values of the spots.
    figures: RefCell<Vec<Figure>>,
}

/// Group and name, then values by their headings.
type Figure = ([String; 2], Vec<(String, f64)>);

/// A mark that says its values to a reader who points at it, and in the drawing's table of figures.
pub(crate) struct Spot<'s> {
    /// Where the mark is.
    pub(crate) at: [f64; 2],
    /// What several marks have in common, such as a view; may be empty.
    pub(crate) group: &'s str,
    /// What it is.
    pub(crate) name: &'s str,
    /// Headings with values.
    pub(crate) values: &'s [(&'s str, f64)],
    /// What a reader types to see it; may be empty.
    pub(crate) command: &'s str,
}

/// Draws into an SVG element of `width` by `height` pixels named `title`.
///
/// # Errors
/// [`PlotError`].
pub(crate) fn svg(
    title: &str,
    width: f64,
    height: f64,
    draw: impl FnOnce(&Canvas<'_>) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let mut text = String::new();
    let (spots, figures);
    {
        let size = (px(width).unsigned_abs(), px(height).unsigned_abs());
        let canvas = Canvas {
            area: SVGBackend::with_string(&mut text, size).into_drawing_area(),
            plot: title,
            spots: RefCell::default(),
            figures: RefCell::default(),
        };
        draw(&canvas)?;
        let finished = canvas.area.present();
        canvas.drawn(finished)?;
        (spots, figures) = (canvas.spots.take(), canvas.figures.take());
    }
    for (long, short) in SHORTER {
        text = text.replace(long, short);
    }
    let label = escaped(title);
    // What is in an image cannot be reached by keyboard.
    let role = if figures.is_empty() { "img" } else { "group" };
    let table = match figures.as_slice() {
        [] => String::new(),
        figures => format!("<metadata>{}</metadata>", escaped(&csv(figures))),
    };
    // Said once for all: there are hundreds.
    let spots = if spots.is_empty() {
        spots
    } else {
        format!("<g pointer-events=\"all\">{spots}</g>")
    };
    if let Some(end) = text.rfind("</svg>") {
        text.insert_str(end, &(spots + &table));
    }
    Ok(text
        .replacen(
            "<svg ",
            &format!("<svg role=\"{role}\" aria-label=\"{label}\" {COMMON} "),
            1,
        )
        .replace(&hex(INK), "currentColor")
        .replace(&hex(PAPER), "var(--paper)"))
}

/// Text that is no markup.
pub(crate) fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('"', "&quot;");
    text.replace('<', "&lt;")
}

/// The figures under a header that has each heading once, in order of appearance.
fn csv(figures: &[Figure]) -> String {
    let mut headings: Vec<&str> = Vec::new();
    for (heading, _) in figures.iter().flat_map(|(_, values)| values) {
        if !headings.contains(&heading.as_str()) {
            headings.push(heading);
        }
    }
    let cell = |text: &str| {
        if text.contains([',', '"', '\n']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let header = ["group", "name"]
        .into_iter()
        .chain(headings.iter().copied());
    let mut lines = vec![header.map(cell).collect::<Vec<_>>().join(",")];
    for (names, values) in figures {
        let value = |heading: &&str| {
            let found = values.iter().find(|(known, _)| known == heading);
            found.map_or_else(String::new, |(_, value)| value.to_string())
        };
        let row = names.iter().map(|name| cell(name));
        let row: Vec<String> = row.chain(headings.iter().map(value)).collect();
        lines.push(row.join(","));
    }
    lines.join("\n") + "\n"
}

/// Width of `text` as drawn, about.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * size * ADVANCE
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "coordinates of a drawing are thousands at most"
)]
fn px(value: f64) -> i32 {
    value.round() as i32
}

fn point(x: f64, y: f64) -> (i32, i32) {
    (px(x), px(y))
}

fn font(style: FontStyle, transform: FontTransform) -> FontDesc<'static> {
    let font = ("sans-serif", TEXT_PX * FONT_SIZE_RATIO).into_font();
    font.style(style).transform(transform)
}

impl Canvas<'_> {
    fn drawn<T, E: std::fmt::Display>(&self, result: Result<T, E>) -> Result<(), PlotError> {
        result.map(|_| ()).map_err(|error| PlotError {
            plot: self.plot.to_owned(),
            message: error.to_string(),
        })
    }

    /// Lets a mark say its values.
    pub(crate) fn spot(&self, spot: &Spot<'_>) {
        let mut said = match spot.group {
            "" => spot.name.to_owned(),
            group => format!("{group}: {}", spot.name),
        };
        for (heading, value) in spot.values {
            // Pixels, bytes and the like have every digit.
            let value = if value.fract() == 0.0 && *value >= 0.0 {
                count(whole(*value))
            } else {
                significant(*value)
            };
            said.push_str(&format!("\n{heading}: {value}"));
        }
        let command = match spot.command {
            "" => String::new(),
            command => format!(" data-command=\"{}\"", escaped(command)),
        };
        let [x, y] = spot.at.map(|at| px(at - SPOT_PX));
        let side = px(2.0 * SPOT_PX);
        self.spots.borrow_mut().push_str(&format!(
            "<g class=\"spot\" tabindex=\"0\" role=\"img\"{command}><title>{}</title>\
             <rect x=\"{x}\" y=\"{y}\" width=\"{side}\" height=\"{side}\"/></g>",
            escaped(&said)
        ));
        let named = |(heading, value): &(&str, f64)| ((*heading).to_owned(), *value);
        self.figures.borrow_mut().push((
            [spot.group.to_owned(), spot.name.to_owned()],
            spot.values.iter().map(named).collect(),
        ));
    }

    /// A line of the page's ink.
    pub(crate) fn rule(&self, from: [f64; 2], to: [f64; 2], opacity: f64) -> Result<(), PlotError> {
        self.path(&[from, to], INK.mix(opacity), 1)
    }

    /// Dashes between two points.
    pub(crate) fn dashes(&self, from: [f64; 2], to: [f64; 2]) -> Result<(), PlotError> {
        self.path(&[from, to], INK.mix(DASHED_OPACITY), 1)
    }

    /// A polyline.
    pub(crate) fn path(
        &self,
        points: &[[f64; 2]],
        colour: RGBAColor,
        width: u32,
    ) -> Result<(), PlotError> {
        let points: Vec<_> = points.iter().map(|p| point(p[0], p[1])).collect();
        let style = ShapeStyle::from(&colour).stroke_width(width);
        self.drawn(self.area.draw(&PathElement::new(points, style)))
    }

    /// A filled rectangle between two corners.
    pub(crate) fn bar(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        colour: RGBAColor,
    ) -> Result<(), PlotError> {
        let corners = [point(from[0], from[1]), point(to[0], to[1])];
        self.drawn(self.area.draw(&Rectangle::new(corners, colour.filled())))
    }

    /// A line of text in the page's ink.
    pub(crate) fn text(&self, text: &str, at: [f64; 2], anchor: Anchor) -> Result<(), PlotError> {
        let font = font(FontStyle::Normal, FontTransform::None);
        self.draw_text(text, at, anchor, font.color(&INK))
    }

    /// A line of text about its middle in the colour of what it names.
    pub(crate) fn coloured_text(
        &self,
        text: &str,
        at: [f64; 2],
        colour: RGBColor,
    ) -> Result<(), PlotError> {
        let font = font(FontStyle::Normal, FontTransform::None);
        self.draw_text(text, at, Anchor::Middle, font.color(&colour))
    }

    /// The same, bold.
    pub(crate) fn heading(
        &self,
        text: &str,
        at: [f64; 2],
        anchor: Anchor,
    ) -> Result<(), PlotError> {
        let font = font(FontStyle::Bold, FontTransform::None);
        self.draw_text(text, at, anchor, font.color(&INK))
    }

    /// Text that reads upwards, for a vertical axis.
    pub(crate) fn upright_text(&self, text: &str, at: [f64; 2]) -> Result<(), PlotError> {
        let font = font(FontStyle::Normal, FontTransform::Rotate270);
        self.draw_text(text, at, Anchor::Middle, font.color(&INK))
    }

    fn draw_text(
        &self,
        text: &str,
        at: [f64; 2],
        anchor: Anchor,
        style: TextStyle<'_>,
    ) -> Result<(), PlotError> {
        let anchor = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        let style = style.pos(Pos::new(anchor, VPos::Center));
        let text = Text::new(text.to_owned(), point(at[0], at[1]), style);
        self.drawn(self.area.draw(&text))
    }

    fn disc(&self, middle: (i32, i32), radius: f64, style: ShapeStyle) -> Result<(), PlotError> {
        let disc = Circle::new(middle, px(radius), style);
        self.drawn(self.area.draw(&disc))
    }

    /// A point of a curve.
    pub(crate) fn marker(&self, at: [f64; 2], stroke: Stroke) -> Result<(), PlotError> {
        self.sized_marker(at, stroke, MARKER_PX, 1.0)
    }

    /// The same with the page's colour inside.
    pub(crate) fn outlined_marker(&self, at: [f64; 2], stroke: Stroke) -> Result<(), PlotError> {
        self.marker(at, stroke)?;
        let inside = Stroke {
            colour: PAPER,
            ..stroke
        };
        self.sized_marker(at, inside, 0.5 * MARKER_PX, 1.0)
    }

    /// The same with half its size in pixels, and its opacity.
    pub(crate) fn sized_marker(
        &self,
        at: [f64; 2],
        stroke: Stroke,
        r: f64,
        opacity: f64,
    ) -> Result<(), PlotError> {
        let [x, y] = at;
        let colour = stroke.colour.mix(opacity);
        let fill = ShapeStyle::from(&colour).filled();
        match stroke.marker.corners() {
            None => self.disc(point(x, y), r, fill),
            Some(corners) => {
                let points = corners.iter().map(|c| point(x + c[0] * r, y + c[1] * r));
                let shape = Polygon::new(points.collect::<Vec<_>>(), fill);
                self.drawn(self.area.draw(&shape))
            }
        }
    }

    /// A cross: no result, or none that counts.
    pub(crate) fn cross(&self, at: [f64; 2], colour: RGBColor) -> Result<(), PlotError> {
        let [x, y] = at;
        let r = MARKER_PX;
        self.path(&[[x - r, y - r], [x + r, y + r]], colour.mix(1.0), 2)?;
        self.path(&[[x - r, y + r], [x + r, y - r]], colour.mix(1.0), 2)
    }

    /// A ring around a marker.
    pub(crate) fn ring(&self, at: [f64; 2]) -> Result<(), PlotError> {
        let style = ShapeStyle::from(&INK).stroke_width(1);
        self.disc(point(at[0], at[1]), MARKER_PX + 3.5, style)
    }

    /// A small open mark: a second figure of a point.
    pub(crate) fn open_marker(&self, at: [f64; 2], colour: RGBColor) -> Result<(), PlotError> {
        let middle = point(at[0], at[1]);
        self.disc(middle, MARKER_PX - 1.0, colour.filled())?;
        self.disc(middle, MARKER_PX - 2.5, PAPER.filled())
    }

    /// The processes of a value as small dots, one where several would cover each other.
    pub(crate) fn dots(
        &self,
        at: impl Iterator<Item = [f64; 2]>,
        colour: RGBColor,
    ) -> Result<(), PlotError> {
        const RADIUS_PX: f64 = 2.0;
        let places: BTreeSet<(i32, i32)> = at.map(|[x, y]| point(x, y)).collect();
        let mut places = places.into_iter();
        places.try_for_each(|place| self.disc(place, RADIUS_PX, colour.filled()))
    }

    /// A whisker with end caps, along an axis.
    pub(crate) fn whisker(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        colour: RGBColor,
    ) -> Result<(), PlotError> {
        const CAP_PX: f64 = 3.0;
        let colour = colour.mix(0.9);
        self.path(&[from, to], colour, 1)?;
        let is_level = (to[1] - from[1]).abs() < (to[0] - from[0]).abs();
        let cap = if is_level {
            [0.0, CAP_PX]
        } else {
            [CAP_PX, 0.0]
        };
        for [x, y] in [from, to] {
            let ends = [[x - cap[0], y - cap[1]], [x + cap[0], y + cap[1]]];
            self.path(&ends, colour, 1)?;
        }
        Ok(())
    }
}
