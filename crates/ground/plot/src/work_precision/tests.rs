// SPDX-License-Identifier: MIT OR Apache-2.0
//! Plots of error against time: what lies where, and labels that keep apart.

use super::*;
use crate::canvas::svg;

const FRAME: Frame = Frame {
    left: 70.0,
    right: 518.0,
    top: 50.0,
    bottom: 366.0,
};

fn point(knob: f64, x: f64, y: f64) -> Point {
    let samples = [0.98, 0.99, 1.0, 1.01, 1.02].map(|factor| factor * x);
    let spread = terrafill_results::spread(&samples).expect("five samples");
    Point {
        knob,
        label: format!("knob {knob}"),
        x: Some(Reading::sampled(spread, &samples)),
        y: Some(Reading::exact(y)),
        y_rms: None,
        standing: PointStanding::Right,
        command: String::new(),
    }
}

fn plot(upwards: Upwards, curves: &[(&str, &[Point])]) -> WorkPrecision<'static> {
    let curve = |(name, points): &(&str, &[Point])| Curve {
        name: (*name).to_owned(),
        points: points.to_vec(),
    };
    WorkPrecision {
        title: "title",
        across: "work",
        up: "error",
        upwards,
        curves: curves.iter().map(curve).collect(),
        lines: Vec::new(),
    }
}

fn drawn(plot: &WorkPrecision<'_>) -> String {
    let panel = Panel::new(plot, FRAME).expect("something to draw");
    let names = plot.curves.iter().map(|curve| curve.name.clone());
    let palette = Palette::new(names.collect());
    svg("test", 600.0, 420.0, |canvas| panel.draw(canvas, &palette)).expect("draws")
}

#[test]
fn failed_points_are_on_the_edge_and_none_is_dropped() {
    let failed = |mut point: Point| {
        point.standing = PointStanding::Failed;
        point
    };
    let mut costless = point(4.0, 1.0, 1.0);
    costless.x = None;
    let points = [
        point(1.0, 1.0, 1e-3),
        failed(point(2.0, 2.0, 1e-6)),
        failed(costless.clone()),
        failed(costless),
    ];
    let plot = plot(Upwards::Error, &[("route", &points)]);
    let panel = Panel::new(&plot, FRAME).expect("something to draw");
    assert_eq!(panel.points.len(), 4);
    assert!(panel.points[0].at[1] > FRAME.top);
    assert!(panel.points[1..].iter().all(|p| p.at[1] <= FRAME.top));
    let [a, b] = [panel.points[2].at[0], panel.points[3].at[0]];
    assert!(a > panel.points[1].at[0] && (a - b).abs() > 2.0 * MARKER_PX);
    assert_eq!(panel.front, [panel.points[0].at]);
    assert!(panel.paths().is_empty(), "one point is no curve");
}

#[test]
fn an_approximate_point_is_open_and_on_no_front() {
    let with = |standing| {
        let best = Point {
            standing,
            ..point(1.0, 0.5, 1e-6)
        };
        plot(Upwards::Error, &[("route", &[best, point(2.0, 1.0, 1e-3)])])
    };
    let approximate = with(PointStanding::Approximate);
    let panel = Panel::new(&approximate, FRAME).expect("something to draw");
    assert_eq!(panel.front, [panel.points[1].at]);
    assert!(
        panel.points[0].at[1] > FRAME.top,
        "where its figures put it"
    );
    assert_eq!(drawn(&approximate).matches("var(--paper)").count(), 1);
    // Negative controls: a right one is full and on the front, a wrong one a cross.
    let right = with(PointStanding::Right);
    let panel = Panel::new(&right, FRAME).expect("something to draw");
    assert_eq!(panel.front, [panel.points[0].at]);
    for standing in [PointStanding::Right, PointStanding::Wrong] {
        assert!(!drawn(&with(standing)).contains("var(--paper)"));
    }
}

#[test]
fn a_panel_without_any_error_says_so() {
    let text = drawn(&plot(Upwards::Error, &[("route", &[point(1.0, 1.0, 0.0)])]));
    assert!(text.contains(NO_ERROR));
    let text = drawn(&plot(
        Upwards::Error,
        &[("route", &[point(1.0, 1.0, 1e-9)])],
    ));
    assert!(!text.contains(NO_ERROR));
}

#[test]
fn the_front_of_counters_is_exact_and_of_times_only_what_survives() {
    let counted = |x, y| Point {
        x: Some(Reading::exact(x)),
        ..point(0.0, x, y)
    };
    let points = [counted(10.0, 1.0), counted(11.0, 0.9), counted(12.0, 0.95)];
    let plot_of = |points: &[Point]| plot(Upwards::Error, &[("route", points)]);
    let counts = plot_of(&points);
    let panel = Panel::new(&counts, FRAME).expect("something to draw");
    assert_eq!(panel.front.len(), 2);
    // Negative control: times that noise does not tell apart keep one of the two only.
    let noisy = [0.7, 0.8, 1.0, 1.2, 1.3].map(|factor| factor * 10.0);
    let spread = terrafill_results::spread(&noisy).expect("five samples");
    let sampled = |y| Point {
        x: Some(Reading::sampled(spread, &noisy)),
        ..point(0.0, 10.0, y)
    };
    let times = plot_of(&[sampled(1.0), sampled(0.9)]);
    let panel = Panel::new(&times, FRAME).expect("something to draw");
    assert_eq!(panel.front.len(), 1);
    let amounts = plot(Upwards::Amount, &[("shape", &points)]);
    let panel = Panel::new(&amounts, FRAME).expect("something to draw");
    assert!(panel.front.is_empty(), "what grows has no front");
}

#[test]
fn the_root_mean_square_is_an_open_mark_below_its_maximum() {
    let mut points = [point(1.0, 1.0, 1e-3), point(2.0, 2.0, 1e-4)];
    let without = drawn(&plot(Upwards::Error, &[("route", &points)]));
    assert_eq!(without.matches("var(--paper)").count(), 0);
    for point in &mut points {
        point.y_rms = point.y.as_ref().map(|max| max.middle / 3.0);
    }
    let with = drawn(&plot(Upwards::Error, &[("route", &points)]));
    assert_eq!(with.matches("var(--paper)").count(), 2);
}

/// Four curves of eight points each, all within a few pixels of one another.
fn crowd(curves: usize) -> Vec<Curve> {
    let curve = |c: usize| Curve {
        name: format!("route {c}"),
        points: (0..8_u8)
            .map(|i| Point {
                label: (2 * i + 1).to_string(),
                y_rms: Some(0.4 * 0.1_f64.powi(i32::from(i))),
                ..point(
                    f64::from(i),
                    1.0 + 0.05 * c as f64 + 0.06 * f64::from(i),
                    0.1_f64.powi(i32::from(i)),
                )
            })
            .collect(),
    };
    (0..curves).map(curve).collect()
}

#[test]
fn labels_of_a_crowd_hide_nothing_and_every_curve_has_one() {
    let mut plot = plot(Upwards::Error, &[]);
    plot.curves = crowd(4);
    plot.lines = vec![ReferenceLine {
        label: "a bound".to_owned(),
        from_x: None,
        y: 1e-3,
        power: 0.0,
    }];
    let panel = Panel::new(&plot, FRAME)
        .expect("something to draw")
        .crowded();
    let labels = panel.labels();
    let marks = panel.marks();
    for (i, label) in labels.iter().enumerate() {
        let room = label.room();
        assert!(!marks.iter().any(|mark| mark.meets(&room)), "{label:?}");
        assert!(
            !labels[..i].iter().any(|other| other.room().meets(&room)),
            "{label:?}"
        );
        let leader = label
            .leader
            .iter()
            .flat_map(|point| along(*point, label.middle));
        let crossed = |piece: &Rectangle| labels[..i].iter().any(|o| o.room().meets(piece));
        assert!(
            !leader.into_iter().any(|piece| crossed(&piece)),
            "{label:?}"
        );
    }
    let named = |curve: &Curve| labels.iter().filter(|l| l.name == curve.name).count();
    assert!(plot.curves.iter().all(|curve| named(curve) >= 1));
    // Negative control: placed beside its point without a search, a label hides a mark.
    let naive = panel.points.iter().map(|placed| {
        let at = [placed.at[0] + 10.0, placed.at[1] - 10.0];
        Rectangle::around(at, 14.0, TEXT_PX)
    });
    let hidden = naive.filter(|room| marks.iter().any(|mark| mark.meets(room)));
    assert!(hidden.count() > 8);
}

#[test]
fn a_crowded_panel_names_its_lines_where_no_point_is() {
    let mut plot = plot(Upwards::Error, &[]);
    plot.curves = crowd(2);
    let line = |label: &str, y: f64| ReferenceLine {
        label: label.to_owned(),
        from_x: None,
        y,
        power: 0.0,
    };
    plot.lines = vec![line("one bound", 1e-3), line("another", 1.1e-3)];
    let names = plot.curves.iter().map(|curve| curve.name.clone()).collect();
    let palette = Palette::new(names);
    let text = svg("test", 700.0, 420.0, |canvas| {
        let panel = Panel::new(&plot, FRAME).expect("something to draw");
        panel.crowded().draw(canvas, &palette)
    });
    let text = text.expect("draws");
    // Place of a text: x and y of the element before it.
    let place = |label: &str| -> [f64; 2] {
        let end = text.find(label).expect("named");
        let start = text[..end].rfind("<text").expect("an element");
        ["x=\"", "y=\""].map(|key| {
            let from = text[start..].find(key).expect("a place") + start + key.len();
            let to = text[from..].find('"').expect("its end") + from;
            text[from..to].parse().expect("a number")
        })
    };
    let [one, another] = [place("one bound"), place("another")];
    assert!(
        one[0] > FRAME.right && another[0] > FRAME.right,
        "{one:?} {another:?}"
    );
    // Lines of 4 px distance have names a line of text apart.
    assert!(
        (one[1] - another[1]).abs() >= TEXT_PX,
        "{one:?} {another:?}"
    );
    // Negative control: not crowded, they stand on their lines, within the panel.
    let inside = drawn(&plot);
    assert!(inside.contains("one bound") && inside != text);
}

#[test]
fn reference_lines_are_on_the_axis_and_named() {
    let points = [point(1.0, 1.0, 1e-3), point(2.0, 10.0, 1e-2)];
    let mut plot = plot(Upwards::Error, &[("route", &points)]);
    let line = |label: &str, from_x, y, power| ReferenceLine {
        label: label.to_owned(),
        from_x,
        y,
        power,
    };
    plot.lines = vec![
        line("¼ texel", None, 4.0, 0.0),
        line("slope 1", Some(1.0), 1e-3, 1.0),
    ];
    let panel = Panel::new(&plot, FRAME).expect("something to draw");
    let y = panel.y.expect("positive errors");
    let (from, to) = panel.line_ends(&plot.lines[0], &y);
    assert_eq!([from[0], to[0]], [FRAME.left, FRAME.right]);
    assert!((from[1] - to[1]).abs() < 1e-9 && from[1] > FRAME.top + EDGE_PX);
    // On two logarithmic axes it goes through the point ten times as far, ten times as high.
    let (from, to) = panel.line_ends(&plot.lines[1], &y);
    let through = [panel.x.px(10.0), y.px(1e-2)];
    let slope = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]) / (b[0] - a[0]);
    assert!((slope(from, to) - slope(from, through)).abs() < 1e-9);
    let text = drawn(&plot);
    assert!(text.contains("¼ texel") && text.contains("slope 1"));
    // Negative control: without the lines the axis does not reach so far.
    plot.lines.clear();
    let panel = Panel::new(&plot, FRAME).expect("something to draw");
    assert!(panel.y.expect("positive errors").high() < 4.0);
}

#[test]
fn an_exact_method_is_a_line_from_edge_to_edge_and_has_its_place_on_the_front() {
    let traded = [point(1.0, 1.0, 100.0), point(2.0, 4.0, 3.0)];
    let beside = |cost: f64, standing: PointStanding| {
        let other = Point {
            standing,
            ..point(0.0, cost, 3.0)
        };
        plot(Upwards::Error, &[("knob", &traded), ("other", &[other])])
    };
    // The grid has such lines too.
    let lines = |plot: &WorkPrecision<'_>| {
        let top = format!(",{} ", FRAME.top);
        let bottom = format!(",{}\"", FRAME.bottom);
        let svg = drawn(plot);
        let elements = svg.split('<');
        elements
            .filter(|element| element.contains(&top) && element.contains(&bottom))
            .count()
    };
    let on_front = |plot: &WorkPrecision<'_>| {
        let panel = Panel::new(plot, FRAME).expect("something to draw");
        let mut points = panel.points.iter();
        let other = points.find(|placed| placed.name == "other");
        other.is_some_and(|placed| panel.front.contains(&placed.at))
    };
    let exact = beside(2.0, PointStanding::Exact);
    assert!(exact.curves[1].is_exact() && !exact.curves[0].is_exact());
    assert!(on_front(&exact));
    // Negative controls: one that takes longer is on no front, and a point is no line.
    assert!(!on_front(&beside(8.0, PointStanding::Exact)));
    let as_point = beside(2.0, PointStanding::Right);
    assert!(!as_point.curves[1].is_exact());
    assert_eq!(lines(&exact), lines(&as_point) + 1);
}
