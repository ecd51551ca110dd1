// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plots of a section: curves of cases through a knob, as panels side by side.

use crate::cases::{Cases, distinct};
use crate::figure::{Figure, Names};
use terrafill_plot::{
    Arrangement, Curve, Palette, Point, PointStanding, Reading, ReferenceLine, Upwards,
    WorkPrecision, named_aside, panels,
};
use terrafill_results::{Block, Case, ChapterError, Clock, Timer, process_medians, sample_spread};

/// A plot.
#[derive(Debug, Clone, Copy)]
pub struct Drawing<'a> {
    /// What it shows.
    pub caption: &'a str,
    /// One, or several side by side.
    pub panels: &'a [Panel<'a>],
}

/// A panel: a point for each case that has both figures.
#[derive(Debug, Clone, Copy)]
pub struct Panel<'a> {
    /// Above it; empty for the section's title.
    pub title: &'a str,
    /// What is drawn across, and what it is called. The clock of a time is added.
    pub across: (&'a str, Figure),
    /// What is drawn upwards.
    pub up: (&'a str, Figure),
    /// How.
    pub upwards: Upwards,
    /// What names a curve.
    pub curve: Names<'a>,
    /// The place along the curve.
    pub knob: Figure,
    /// Text next to a point.
    pub label: Option<Names<'a>>,
    /// What a point is worth.
    pub standing: fn(&Case) -> PointStanding,
    /// Lines that the curves are compared with.
    pub lines: fn(&[Curve]) -> Vec<ReferenceLine>,
}

impl Panel<'_> {
    /// A panel of amounts whose points all count, without lines.
    pub const EMPTY: Panel<'static> = Panel {
        title: "",
        across: ("", Figure::Computed(|_| None)),
        up: ("", Figure::Computed(|_| None)),
        upwards: Upwards::Amount,
        curve: Names::Joined(&[]),
        knob: Figure::Computed(|_| None),
        label: None,
        standing: |_| PointStanding::Right,
        lines: |_| Vec::new(),
    };

    /// Curves of these cases, each by its rising knob; a knob that is no number comes first.
    #[must_use]
    pub fn curves<'c>(
        &self,
        clock: Clock,
        cases: impl IntoIterator<Item = &'c Case>,
    ) -> Vec<Curve> {
        let mut curves: Vec<Curve> = Vec::new();
        for case in cases {
            let [x, y] = [self.across.1, self.up.1].map(|figure| reading(figure, case, clock));
            let (Some(x), Some(y)) = (x, y) else {
                continue;
            };
            let point = Point {
                knob: self.knob.of(case, clock).unwrap_or(f64::NEG_INFINITY),
                label: self
                    .label
                    .map_or_else(String::new, |label| label.text(case)),
                x: Some(x),
                y: Some(y),
                y_rms: None,
                standing: (self.standing)(case),
                command: String::new(),
            };
            let name = self.curve.text(case);
            match curves.iter_mut().find(|curve| curve.name == name) {
                Some(curve) => curve.points.push(point),
                None => curves.push(Curve {
                    name,
                    points: vec![point],
                }),
            }
        }
        for curve in &mut curves {
            curve.points.sort_by(|a, b| a.knob.total_cmp(&b.knob));
        }
        curves
    }
}

/// A time with its range and its processes, everything else as it is.
fn reading(figure: Figure, case: &Case, clock: Clock) -> Option<Reading> {
    let value = figure.of(case, clock)?;
    let metric = figure
        .metric(clock)
        .filter(|metric| metric.timer().is_some());
    let sampled = metric.and_then(|metric| {
        let replicates: Vec<f64> = process_medians(case, metric).into_values().collect();
        Some(Reading::sampled(sample_spread(case, metric)?, &replicates))
    });
    Some(sampled.unwrap_or_else(|| Reading::exact(value)))
}

/// `frame, ms of the GPU`.
fn axis((text, figure): (&str, Figure), clock: Clock) -> String {
    let timer = match figure {
        Figure::ByClock(..) => figure.metric(clock).and_then(|metric| metric.timer()),
        _ => None,
    };
    let by = match timer {
        Some(Timer::Gpu) => " of the GPU",
        Some(Timer::ProcessCpu) => " of process CPU time",
        Some(Timer::Wall) => " of wall clock",
        None => "",
    };
    format!("{text}{by}")
}

impl Drawing<'_> {
    /// The plot of these cases; `None` where nothing was measured.
    ///
    /// # Errors
    /// [`ChapterError`] when it cannot be drawn.
    pub fn block(&self, title: &str, cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
        let clock = cases.clock();
        let axes = |panel: &Panel<'_>| [panel.across, panel.up].map(|end| axis(end, clock));
        let axes: Vec<[String; 2]> = self.panels.iter().map(axes).collect();
        let panels = self.panels.iter().zip(&axes).map(|(panel, [across, up])| {
            let curves = panel.curves(clock, cases.iter());
            WorkPrecision {
                title: match panel.title {
                    "" => title,
                    own => own,
                },
                across,
                up,
                upwards: panel.upwards,
                lines: (panel.lines)(&curves),
                curves,
            }
        });
        draw(title, self.caption, &panels.collect::<Vec<_>>())
    }
}

/// Panels as a block: a single one has the names of its curves at their ends, several have them below. `None` where no
/// panel has a point.
///
/// # Errors
/// [`ChapterError`] when they cannot be drawn.
pub fn draw(
    title: &str,
    caption: &str,
    plots: &[WorkPrecision<'_>],
) -> Result<Option<Block>, ChapterError> {
    let curves = plots.iter().flat_map(|plot| &plot.curves);
    let names = distinct(curves.map(|curve| curve.name.clone()));
    let palette = Palette::new(names.clone());
    let svg = match plots {
        [only] => named_aside(title, only, &names, &palette)?,
        several => panels(title, several, Arrangement::SideBySide, &palette)?,
    };
    Ok(Block::plot(caption, svg))
}

/// Along it what is drawn upwards grows as what is drawn across: from the lowest first point of all curves.
#[must_use]
pub fn slope_one(curves: &[Curve]) -> Vec<ReferenceLine> {
    let firsts = curves.iter().filter_map(|curve| curve.points.first());
    let firsts = firsts.filter_map(|point| Some((point.x.as_ref()?, point.y.as_ref()?)));
    let firsts = firsts.map(|(x, y)| (x.middle(), y.middle()));
    let lowest = firsts.min_by(|a, b| a.1.total_cmp(&b.1));
    let line = lowest.map(|(x, y)| ReferenceLine {
        label: "slope 1".to_owned(),
        from_x: Some(x),
        y,
        power: 1.0,
    });
    line.into_iter().collect()
}
