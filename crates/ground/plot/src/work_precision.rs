// SPDX-License-Identifier: MIT OR Apache-2.0
//! Work and precision: one curve for each method through its knob, both axes logarithmic.
//!
//! A point has what it costs across and what it misses upwards, each with its 5–95 % range where it was
//! sampled. A second, open mark below it is the root mean square where the first is a maximum. A point
//! without error stands on a line of its own at the bottom and a failed one on the upper edge: neither
//! has a place on a logarithm, and neither may vanish. A wrong one whose figures are known is the
//! exception, since its error may be the answer. It stands where its figures put it, on its curve, with
//! a cross; of a method that is approximate by nature, with an open mark. A method that is exact and has
//! no knob is a vertical line at its cost. The Pareto front joins only right points and exact methods that
//! keep their place when processes are drawn again (see [`terrafill_results::front_survival`]).

use crate::canvas::{Anchor, Canvas, MARKER_PX, Spot, TEXT_PX, text_width};
use crate::labels::{LEADER_FROM_PX, Rectangle, free_place, free_place_where};
use crate::log_log::{Frame, LINE_OPACITY, apart, draw_across, draw_stairs, draw_up};
use crate::palette::{INK, Palette, Stroke};
use crate::scale::LogScale;
use crate::{PlotError, Reading};
use plotters::prelude::Color as _;
use terrafill_results::threshold::FRONT_SURVIVAL;
use terrafill_results::{Candidate, front_survival};

/// Panel titles stand so far above their panels.
const TITLE_PX: f64 = 36.0;
/// From the upper edge, where failed points stand, to the logarithm.
const EDGE_PX: f64 = 28.0;
/// From the logarithm to the line of points without error, and from there to the end of the panel.
const ZERO_PX: [f64; 2] = [30.0, 14.0];

/// Between labels side by side.
const LABEL_GAP_PX: f64 = 8.0;

/// Stands where the points would, were there an error.
const NO_ERROR: &str = "no point has an error";

/// Costs that differ by less than this factor are hardly different.
const MIN_WORK_MARGIN: f64 = 1.2;
/// Errors that differ by less than this factor are hardly different: keeps one pixel more or less from
/// filling the axis.
const MIN_ERROR_MARGIN: f64 = 2.5;

/// A panel to be.
#[derive(Debug, Clone)]
pub struct WorkPrecision<'a> {
    /// Above the panel.
    pub title: &'a str,
    /// What the horizontal axis shows.
    pub across: &'a str,
    /// What the vertical axis shows.
    pub up: &'a str,
    /// How it is drawn upwards.
    pub upwards: Upwards,
    /// Methods.
    pub curves: Vec<Curve>,
    /// What is known beforehand.
    pub lines: Vec<ReferenceLine>,
}

/// What is drawn upwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Upwards {
    /// Less is better and 0 is reached; failed points have an edge, and there is a front.
    Error,
    /// Something positive that grows.
    Amount,
}

/// One method through its knob.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// As in the palette.
    pub name: String,
    /// In any order.
    pub points: Vec<Point>,
}

/// One value of the knob.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Place along the curve.
    pub knob: f64,
    /// Written beside the point if it is one of several or failed; empty for nothing.
    pub label: String,
    /// Cost.
    pub x: Option<Reading>,
    /// Largest error, or amount.
    pub y: Option<Reading>,
    /// Root mean square of the error.
    pub y_rms: Option<f64>,
    /// What its figures are worth.
    pub standing: PointStanding,
    /// What a reader types to see it; empty for nothing.
    pub command: String,
}

/// What a point's figures are worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointStanding {
    /// They count.
    Right,
    /// They count, and no knob trades them: a vertical line at the cost.
    Exact,
    /// They are known, and too bad: a cross where they put it, and no place on the front.
    Wrong,
    /// They are known, and off by the nature of the method: an open mark where they put it, and no
    /// place on the front.
    Approximate,
    /// There are none, or they count for nothing.
    Failed,
}

/// Something known to hold the points against, dashed to the right end of the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceLine {
    /// Written at its right end.
    pub label: String,
    /// Where it begins across; `None` at the left end of the axis.
    pub from_x: Option<f64>,
    /// What it begins with upwards.
    pub y: f64,
    /// What it shows grows with this power of the cost: 0 for a floor or a bound.
    pub power: f64,
}

/// A point with its place.
#[derive(Debug)]
pub(crate) struct Placed<'a> {
    pub(crate) name: &'a str,
    pub(crate) point: &'a Point,
    pub(crate) at: [f64; 2],
    /// On the upper edge.
    pub(crate) is_pinned: bool,
}

/// A panel, laid out.
#[derive(Debug)]
pub(crate) struct Panel<'a> {
    plot: &'a WorkPrecision<'a>,
    frame: Frame,
    x: LogScale,
    /// `None` when there is no positive error.
    y: Option<LogScale>,
    pub(crate) points: Vec<Placed<'a>>,
    /// Corners of the front, left to right.
    pub(crate) front: Vec<[f64; 2]>,
    /// Reference lines are named at the right of the panel, and labels keep clear of all that is drawn.
    is_crowded: bool,
}

/// A label with its place.
#[derive(Debug, Clone)]
struct Label<'a> {
    text: &'a str,
    /// Curve whose point it names.
    name: &'a str,
    middle: [f64; 2],
    width: f64,
    /// The point, where a line leads there.
    leader: Option<[f64; 2]>,
}

/// Between a label that has a leader and anything else that is drawn.
const LEADER_CLEARANCE_PX: f64 = 3.0;

/// Between a crowded panel and the names of its reference lines.
const LINE_NAMES_PX: f64 = 8.0;

impl Curve {
    /// Whether it is one vertical line.
    pub(crate) fn is_exact(&self) -> bool {
        let mut points = self.points.iter();
        points.all(|point| point.standing == PointStanding::Exact)
    }
}

impl Point {
    fn is_pinned(&self) -> bool {
        self.standing == PointStanding::Failed || self.x.is_none() || self.y.is_none()
    }
}

impl<'a> Panel<'a> {
    /// Gives every point its place; `None` when no point has a cost.
    pub(crate) fn new(plot: &'a WorkPrecision<'a>, frame: Frame) -> Option<Self> {
        let points = || plot.curves.iter().flat_map(|curve| &curve.points);
        let costs = points().filter_map(|point| point.x.as_ref());
        let x = LogScale::around(
            costs.flat_map(Reading::extent),
            MIN_WORK_MARGIN,
            frame.left,
            frame.right,
        )?;
        let standing = points().filter(|point| !point.is_pinned());
        let heights = standing
            .filter_map(|point| Some((point.y.as_ref()?.extent(), point.y_rms)))
            .flat_map(|(extent, rms)| extent.into_iter().chain(rms))
            .chain(plot.lines.iter().map(|line| line.y));
        let [top, bottom] = plot.upwards.logarithm(frame);
        let margin = match plot.upwards {
            Upwards::Error => MIN_ERROR_MARGIN,
            Upwards::Amount => MIN_WORK_MARGIN,
        };
        let mut panel = Self {
            plot,
            frame,
            x,
            y: LogScale::around(heights, margin, bottom, top),
            points: Vec::new(),
            front: Vec::new(),
            is_crowded: false,
        };
        panel.place();
        panel.front = panel.front_corners();
        Some(panel)
    }

    /// For many curves close to one another. Reference lines are named at the right of the panel, where
    /// no point is. A label stands where it hides no mark, no whisker and no other label; the ends of a
    /// curve are named first, and from afar if need be.
    pub(crate) fn crowded(self) -> Self {
        Self {
            is_crowded: true,
            ..self
        }
    }

    fn place(&mut self) {
        let mut without_cost = 0.0;
        for curve in &self.plot.curves {
            for point in &curve.points {
                let x = if let Some(cost) = &point.x {
                    self.x.px(cost.middle)
                } else {
                    without_cost += 1.0;
                    self.frame.right - (without_cost - 1.0) * 4.0 * MARKER_PX
                };
                let is_pinned = point.is_pinned();
                let y = match &point.y {
                    Some(error) if !is_pinned => self.height(error.middle),
                    _ => self.frame.top,
                };
                self.points.push(Placed {
                    name: &curve.name,
                    point,
                    at: [x, y],
                    is_pinned,
                });
            }
        }
    }

    /// Where `value` stands upwards: on the line for 0 if it is not positive.
    pub(crate) fn height(&self, value: f64) -> f64 {
        match &self.y {
            Some(scale) if value > 0.0 => scale.px(value),
            _ => self.zero(),
        }
    }

    /// Where points without error stand.
    pub(crate) fn zero(&self) -> f64 {
        match self.plot.upwards {
            Upwards::Error => self.frame.bottom - ZERO_PX[1],
            Upwards::Amount => self.frame.bottom,
        }
    }

    fn front_corners(&self) -> Vec<[f64; 2]> {
        if self.plot.upwards != Upwards::Error {
            return Vec::new();
        }
        let judged = self.points.iter().filter_map(|placed| {
            let standing = placed.point.standing;
            let counts = matches!(standing, PointStanding::Right | PointStanding::Exact);
            let (x, y) = (placed.point.x.as_ref()?, placed.point.y.as_ref()?);
            let candidate = Candidate {
                costs: &x.samples,
                error: y.middle,
            };
            counts.then_some((placed.at, candidate))
        });
        let (places, candidates): (Vec<[f64; 2]>, Vec<Candidate<'_>>) = judged.unzip();
        let mut corners: Vec<[f64; 2]> = places
            .into_iter()
            .zip(front_survival(&candidates))
            .filter(|(_, survival)| *survival >= FRONT_SURVIVAL)
            .map(|(at, _)| at)
            .collect();
        corners.sort_by(|a, b| a[0].total_cmp(&b[0]));
        corners
    }

    /// Draws axes, lines, front, curves, points and labels; the names of curves are the caller's.
    ///
    /// # Errors
    /// [`PlotError`].
    pub(crate) fn draw(&self, canvas: &Canvas<'_>, palette: &Palette) -> Result<(), PlotError> {
        self.draw_axes(canvas)?;
        self.draw_lines(canvas)?;
        self.draw_front(canvas)?;
        for (name, path) in self.paths() {
            let colour = palette.stroke(name).colour.mix(LINE_OPACITY);
            canvas.path(&path, colour, 2)?;
        }
        for placed in &self.points {
            self.draw_point(canvas, placed, palette.stroke(placed.name))?;
        }
        self.draw_labels(canvas, palette)
    }

    fn draw_axes(&self, canvas: &Canvas<'_>) -> Result<(), PlotError> {
        let Frame {
            left, right, top, ..
        } = self.frame;
        canvas.heading(self.plot.title, [left, top - TITLE_PX], Anchor::Left)?;
        draw_across(canvas, self.frame, &self.x, self.plot.across)?;
        let reach = self.plot.upwards.logarithm(self.frame);
        draw_up(canvas, self.frame, self.y.as_ref(), reach, self.plot.up)?;
        let zero = self.zero();
        canvas.rule([left, zero], [right, zero], 0.6)?;
        if self.plot.upwards != Upwards::Error {
            return Ok(());
        }
        if self.y.is_none() {
            let [high, low] = reach;
            let middle = [f64::midpoint(left, right), f64::midpoint(high, low)];
            canvas.text(NO_ERROR, middle, Anchor::Middle)?;
        }
        canvas.text("0", [left - 8.0, zero], Anchor::Right)?;
        if !self.points.iter().any(|placed| placed.is_pinned) {
            return Ok(());
        }
        canvas.rule([left, top], [right, top], 0.35)?;
        canvas.text("wrong,", [left - 8.0, top - 7.0], Anchor::Right)?;
        canvas.text("failed", [left - 8.0, top + 7.0], Anchor::Right)
    }

    /// Each with its label above its right end, or beside it.
    fn draw_lines(&self, canvas: &Canvas<'_>) -> Result<(), PlotError> {
        if self.is_crowded {
            return self.draw_lines_named_aside(canvas);
        }
        for line in &self.plot.lines {
            let Some(y) = &self.y else { continue };
            let (from, to) = self.line_ends(line, y);
            canvas.dashes(from, to)?;
            let (middle, _) = self.line_label(line, y);
            canvas.text(&line.label, middle, Anchor::Middle)?;
        }
        Ok(())
    }

    fn draw_lines_named_aside(&self, canvas: &Canvas<'_>) -> Result<(), PlotError> {
        let Some(y) = &self.y else { return Ok(()) };
        let mut lines: Vec<(f64, &str)> = Vec::new();
        for line in &self.plot.lines {
            let (from, to) = self.line_ends(line, y);
            canvas.dashes(from, to)?;
            lines.push((to[1], &line.label));
        }
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        let wanted: Vec<f64> = lines.iter().map(|(y, _)| *y).collect();
        let names = apart(&wanted, [self.frame.top, self.frame.bottom]);
        for ((end, label), at) in lines.into_iter().zip(names) {
            let x = self.frame.right;
            canvas.path(&[[x, end], [x + LINE_NAMES_PX - 2.0, at]], INK.mix(0.5), 1)?;
            canvas.text(label, [x + LINE_NAMES_PX, at], Anchor::Left)?;
        }
        Ok(())
    }

    /// Middle and width of a reference line's label.
    fn line_label(&self, line: &ReferenceLine, y: &LogScale) -> ([f64; 2], f64) {
        let (_, end) = self.line_ends(line, y);
        let width = text_width(&line.label, TEXT_PX);
        ([end[0] - 6.0 - width * 0.5, end[1] - 10.0], width)
    }

    /// Ends of a reference line, cut where the vertical axis ends.
    fn line_ends(&self, line: &ReferenceLine, y: &LogScale) -> ([f64; 2], [f64; 2]) {
        let (x, height) = (line.from_x.unwrap_or(self.x.low()), line.y);
        let mut end = self.x.high();
        if line.power > 0.0 {
            end = end.min(x * (y.high() / height).powf(line.power.recip()));
        }
        let end_height = height * (end / x).powf(line.power);
        let at = |x, height| [self.x.px(x), y.px(height)];
        (at(x, height), at(end, end_height))
    }

    fn draw_front(&self, canvas: &Canvas<'_>) -> Result<(), PlotError> {
        draw_stairs(canvas, &self.front)?;
        for corner in &self.front {
            canvas.ring(*corner)?;
        }
        Ok(())
    }

    /// Through the points with a place of their own, in the order of the knob, where a curve has more
    /// than one.
    pub(crate) fn paths(&self) -> Vec<(&'a str, Vec<[f64; 2]>)> {
        let mut paths = Vec::new();
        for curve in &self.plot.curves {
            let mut own: Vec<&Placed<'a>> = self
                .points
                .iter()
                .filter(|placed| placed.name == curve.name && !placed.is_pinned)
                .collect();
            own.sort_by(|a, b| a.point.knob.total_cmp(&b.point.knob));
            if own.len() > 1 {
                let path = own.iter().map(|placed| placed.at).collect();
                paths.push((curve.name.as_str(), path));
            }
        }
        paths
    }

    fn draw_point(
        &self,
        canvas: &Canvas<'_>,
        placed: &Placed<'_>,
        stroke: Stroke,
    ) -> Result<(), PlotError> {
        let (point, at) = (placed.point, placed.at);
        if point.standing == PointStanding::Exact {
            let foot = [at[0], self.frame.bottom];
            let line = [[at[0], self.frame.top], foot];
            canvas.path(&line, stroke.colour.mix(LINE_OPACITY), 2)?;
            self.add_spot(canvas, placed, foot);
            return canvas.marker(foot, stroke);
        }
        let along_x = |value: f64| [self.x.px(value), at[1]];
        let along_y = |value: f64| [at[0], self.height(value)];
        let axes: [(_, &dyn Fn(f64) -> [f64; 2]); 2] = [(&point.x, &along_x), (&point.y, &along_y)];
        for (reading, place) in axes {
            let Some(reading) = reading.as_ref().filter(|_| !placed.is_pinned) else {
                continue;
            };
            if let Some([from, to]) = reading.range {
                canvas.whisker(place(from), place(to), stroke.colour)?;
                canvas.dots(reading.processes().map(place), stroke.colour)?;
            }
        }
        if let Some(rms) = point.y_rms.filter(|_| !placed.is_pinned) {
            let below = [at[0], self.height(rms)];
            canvas.path(&[at, below], stroke.colour.mix(LINE_OPACITY), 1)?;
            canvas.open_marker(below, stroke.colour)?;
        }
        self.add_spot(canvas, placed, at);
        match point.standing {
            PointStanding::Right => canvas.marker(at, stroke),
            PointStanding::Approximate if !placed.is_pinned => canvas.outlined_marker(at, stroke),
            _ => canvas.cross(at, stroke.colour),
        }
    }

    fn add_spot(&self, canvas: &Canvas<'_>, placed: &Placed<'_>, at: [f64; 2]) {
        let point = placed.point;
        let name = match point.label.as_str() {
            "" => placed.name.to_owned(),
            label => format!("{}, {label}", placed.name),
        };
        let values = [(self.plot.across, &point.x), (self.plot.up, &point.y)];
        let known = values
            .into_iter()
            .filter_map(|(heading, value)| Some((heading, value.as_ref()?.middle)));
        let rms = point.y_rms.map(|rms| ("root mean square", rms));
        canvas.spot(&Spot {
            at,
            group: self.plot.title,
            name: &name,
            values: &known.chain(rms).collect::<Vec<_>>(),
            command: &point.command,
        });
    }

    fn draw_labels(&self, canvas: &Canvas<'_>, palette: &Palette) -> Result<(), PlotError> {
        if self.is_crowded {
            for label in self.labels() {
                let colour = palette.stroke(label.name).colour;
                if let Some(point) = label.leader {
                    canvas.path(&[point, label.middle], colour.mix(0.5), 1)?;
                }
            }
            for label in self.labels() {
                let colour = palette.stroke(label.name).colour;
                canvas.coloured_text(label.text, label.middle, colour)?;
            }
            return Ok(());
        }
        let paths = self.paths();
        let size = 2.0 * MARKER_PX + 2.0;
        let mut taken: Vec<Rectangle> = self
            .points
            .iter()
            .map(|placed| Rectangle::around(placed.at, size, size))
            .collect();
        // Nor does a label stand on the line of points without error.
        let middle = f64::midpoint(self.frame.left, self.frame.right);
        let width = self.frame.right - self.frame.left;
        taken.push(Rectangle::around([middle, self.zero()], width, 2.0));
        for (line, y) in self.plot.lines.iter().zip(self.y.iter().cycle()) {
            let (middle, width) = self.line_label(line, y);
            taken.push(Rectangle::around(middle, width, TEXT_PX + 2.0));
        }
        for placed in &self.points {
            let label = &placed.point.label;
            let on_curve = paths.iter().any(|(name, _)| *name == placed.name);
            if label.is_empty() || !(placed.is_pinned || on_curve) {
                continue;
            }
            let width = text_width(label, TEXT_PX);
            let Some((middle, radius)) = free_place(placed.at, width, self.room(), &taken) else {
                continue;
            };
            if radius >= LEADER_FROM_PX {
                canvas.path(&[placed.at, middle], INK.mix(0.3), 1)?;
            }
            canvas.text(label, middle, Anchor::Middle)?;
            taken.push(Rectangle::around(
                middle,
                width + LABEL_GAP_PX,
                TEXT_PX + 2.0,
            ));
        }
        Ok(())
    }

    /// Room taken by marks, open marks, whiskers and curves.
    fn marks(&self) -> Vec<Rectangle> {
        let size = 2.0 * MARKER_PX + 2.0;
        let mut taken: Vec<Rectangle> = Vec::new();
        for placed in &self.points {
            if placed.point.standing == PointStanding::Exact {
                let [x, _] = placed.at;
                taken.extend(along([x, self.frame.top], [x, self.frame.bottom]));
                continue;
            }
            taken.push(Rectangle::around(placed.at, size, size));
            if placed.is_pinned {
                continue;
            }
            if let Some(rms) = placed.point.y_rms {
                let below = self.height(rms);
                taken.push(Rectangle::around([placed.at[0], below], size, size));
                taken.extend(along(placed.at, [placed.at[0], below]));
            }
            let range = placed.point.x.as_ref().and_then(|x| x.range);
            if let Some([from, to]) = range.map(|range| range.map(|value| self.x.px(value))) {
                taken.extend(along([from, placed.at[1]], [to, placed.at[1]]));
            }
        }
        for (_, path) in self.paths() {
            taken.extend(path.windows(2).flat_map(|ends| along(ends[0], ends[1])));
        }
        let middle = f64::midpoint(self.frame.left, self.frame.right);
        let width = self.frame.right - self.frame.left;
        for (line, y) in self.plot.lines.iter().zip(self.y.iter().cycle()) {
            let (from, to) = self.line_ends(line, y);
            taken.extend(along(from, to));
        }
        taken.push(Rectangle::around([middle, self.zero()], width, 2.0));
        taken
    }

    /// Labels of a crowded panel: the ends of curves and what failed first, with a leader where they
    /// stand off; the others only beside their points.
    fn labels(&self) -> Vec<Label<'a>> {
        let mut taken = self.marks();
        let mut ends: Vec<&Placed<'a>> = Vec::new();
        let mut others: Vec<&Placed<'a>> = Vec::new();
        let paths = self.paths();
        for placed in self.points.iter().filter(|p| !p.point.label.is_empty()) {
            let path = paths.iter().find(|(name, _)| *name == placed.name);
            let is_end = path.is_some_and(|(_, path)| {
                path.first() == Some(&placed.at) || path.last() == Some(&placed.at)
            });
            match path {
                _ if placed.is_pinned || is_end => ends.push(placed),
                Some(_) => others.push(placed),
                None => {}
            }
        }
        let mut labels: Vec<Label<'a>> = Vec::new();
        let named = ends.into_iter().map(|placed| (placed, true));
        for (placed, may_lead) in named.chain(others.into_iter().map(|placed| (placed, false))) {
            let text = placed.point.label.as_str();
            let width = text_width(text, TEXT_PX);
            let is_free = |middle: [f64; 2], radius: f64| {
                radius < LEADER_FROM_PX
                    || (may_lead
                        && !along(placed.at, middle)
                            .any(|piece| labels.iter().any(|label| label.room().meets(&piece))))
            };
            let place = free_place_where(placed.at, width, self.room(), &taken, is_free);
            let Some((middle, radius)) = place else {
                continue;
            };
            let leader = (radius >= LEADER_FROM_PX).then_some(placed.at);
            let label = Label {
                text,
                name: placed.name,
                middle,
                width,
                leader,
            };
            taken.push(label.room());
            taken.extend(leader.into_iter().flat_map(|point| along(point, middle)));
            labels.push(label);
        }
        labels
    }

    /// Where labels may stand: a little past the panel at the right, and up to its title.
    fn room(&self) -> Rectangle {
        Rectangle {
            low: [self.frame.left - 2.0, self.frame.top - TITLE_PX + 8.0],
            high: [self.frame.right + 20.0, self.frame.bottom + 2.0],
        }
    }
}

impl Label<'_> {
    fn room(&self) -> Rectangle {
        Rectangle::around(self.middle, self.width + 2.0, TEXT_PX + 1.0)
    }
}

/// Squares along a line, close enough that no text slips through.
fn along(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = Rectangle> {
    const STEP_PX: f64 = 5.0;
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    let steps = (length / STEP_PX).ceil().max(1.0);
    std::iter::successors(Some(0.0), move |step| (*step < steps).then_some(step + 1.0)).map(
        move |step| {
            let share = step / steps;
            let at = [0, 1].map(|axis: usize| from[axis] + share * (to[axis] - from[axis]));
            Rectangle::around(at, LEADER_CLEARANCE_PX, LEADER_CLEARANCE_PX)
        },
    )
}

impl Upwards {
    /// As far as the logarithm reaches.
    fn logarithm(self, frame: Frame) -> [f64; 2] {
        match self {
            Self::Error => {
                let below: f64 = ZERO_PX.iter().sum();
                [frame.top + EDGE_PX, frame.bottom - below]
            }
            Self::Amount => [frame.top, frame.bottom],
        }
    }
}

#[cfg(test)]
mod tests;
