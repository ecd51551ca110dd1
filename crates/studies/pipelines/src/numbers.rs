// SPDX-License-Identifier: MIT OR Apache-2.0
//! Figures of formulas alone, which no run changes: `docs/pipeline-numbers.md` holds them, and tests prove them.

mod blurs;
mod shadows;

use crate::blur::Moments as BlurMoments;
use crate::variance::{DepthFormat, Moments};
use blurs::{Filter, blur_error};
use shadows::{NO_FLOOR, bleeding, hard_shadow, lit_plane, noise, worst_bleeding};
use terrafill_fixtures::page::{assert_tables, markdown_table};
use terrafill_plot::number::significant;

fn percent(share: f64) -> String {
    significant(100.0 * share)
}

fn noise_rows() -> Vec<Vec<String>> {
    let all = Moments::ALL
        .into_iter()
        .flat_map(|way| [1e-2, 1e-3, 3e-4, 1e-4].map(|sigma| (way, sigma)));
    let row = |(way, sigma): (Moments, f64)| {
        let noise = noise(way, sigma);
        assert_eq!(noise.non_finite, 0, "{way:?} {sigma}");
        vec![
            way.name().to_owned(),
            format!("{sigma:e}"),
            significant(noise.relative_rms),
            significant(noise.absolute_rms),
            significant(noise.absolute_max),
        ]
    };
    all.map(row).collect()
}

fn lit_rows() -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for way in [Moments::Published, Moments::FromReceiver] {
        for format in DepthFormat::ALL {
            for (floor, name) in [(NO_FLOOR, "none"), (1e-7, "1e-7")] {
                let plane = lit_plane(way, format, floor);
                assert_eq!(plane.non_finite, 0, "{way:?} {format:?} {name}");
                let names = [way.name().to_owned(), format.name(), name.to_owned()];
                let shares = [plane.dark, plane.black, plane.outside].map(percent);
                rows.push(names.into_iter().chain(shares).collect());
            }
        }
    }
    rows
}

fn blur_rows() -> Vec<Vec<String>> {
    let counts = [4, 8, 16, 32, 64, 128, 256, 512];
    let row = |layers: u32| {
        let of = |filter| {
            let rms = move |moments| significant(blur_error(filter, moments, layers).rms);
            BlurMoments::ALL.map(rms)
        };
        let [points, boxes] = [Filter::Point, Filter::Box].map(of);
        let first = std::iter::once(layers.to_string());
        first.chain(points).chain(boxes).collect::<Vec<String>>()
    };
    counts.map(row).into()
}

/// Every table of the page.
fn tables() -> [String; 5] {
    let bleeding = [0.5, 1.0, 2.0, 5.0, 10.0].map(|gaps| {
        let figures = [gaps, bleeding(gaps), worst_bleeding(gaps)];
        figures.map(significant).to_vec()
    });
    let hard = [256, 512, 1_024, 2_048, 4_096].map(|texels| {
        let shadow = hard_shadow(texels, 0.0);
        let figures = [
            shadow.wrong_area,
            shadow.area_share,
            shadow.deviation_texels,
        ];
        let mut row = vec![texels.to_string()];
        row.extend(figures.map(significant));
        row
    });
    [
        table(
            "moments | spread of depths | relative, rms | absolute, rms | absolute, largest",
            noise_rows(),
        ),
        table(
            "moments | depth | floor | below 0.99 of the light, % | below 0.01, % \
             | outside of 0 to 1, %",
            lit_rows(),
        ),
        table("gaps | largest light of 25 taps | (r / (r + 2))²", bleeding),
        table(
            "texels a side | wrong area, share of the map | over perimeter · texel \
             | largest deviation, texels",
            hard,
        ),
        table(
            "layers | point, middle | point, end | point, stratified | point, random \
             | share, middle | share, end | share, stratified | share, random",
            blur_rows(),
        ),
    ]
}

/// - `headings`: as the page's line has them
fn table(headings: &str, rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let headings: Vec<&str> = headings.split(" | ").collect();
    markdown_table(&headings, rows)
}

#[test]
fn the_page_holds_what_the_formulas_give() {
    assert_tables("pipeline-numbers.md", &tables());
}
