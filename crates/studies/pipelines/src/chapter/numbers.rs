// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sections that need no device: error against resolution and against layers, and what holds of them.

use super::cells::of;
use super::series::{curve, draw, finding, plot, range, series, slope, table};
use crate::blur::MOTION_PX;
use crate::keys::{
    BLUR_MAX, BLUR_RMS, CUT, DEPTH, EXPERIMENT, FILTER, FLOOR, GAPS, HARD_AREA_SHARE,
    HARD_DEVIATION_TEXELS, HARD_WRONG_AREA, IMAGE_MAX_M, IMAGE_MAX_PX, IMAGE_NORMAL_DEG,
    IMAGE_OPEN_TEXELS, IMAGE_RMS_M, LAYERS, MOMENTS, RESOLVE, SIGMA, STORED, TEXELS,
    VARIANCE_ABSOLUTE_MAX, VARIANCE_ABSOLUTE_RMS, VARIANCE_BLACK_SHARE, VARIANCE_BLEEDING,
    VARIANCE_DARK_SHARE, VARIANCE_NON_FINITE, VARIANCE_OUTSIDE_SHARE, VARIANCE_RELATIVE_RMS,
};
use crate::variance::worst_bleeding;
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, Cell, ChapterError, Finding, Heading, Metric, Table};

/// Fewest texels from which errors of images fall as they should.
const RESOLVED_TEXELS: u32 = 65;
/// What is asked of a doubling of texels, and of the better cut.
const RATIO: f64 = 4.0;
const RATIO_TOLERANCE: f64 = 0.2;
const BETTER_CUT: f64 = 2.5;
/// Of a factor known to two digits.
const CUT_TOLERANCE: f64 = 0.1;
/// What is asked of the variance with the receiver subtracted.
pub(super) const RELATIVE_NOISE: f64 = 2e-6;
/// Of a straight edge at all angles, mean area between it and the texels whose middles it covers.
pub(super) const EDGE_SHARE: f64 = 0.244;
pub(super) const EDGE_TOLERANCE: f64 = 0.01;
/// By how much a slope over several doublings may be off.
pub(super) const SLOPE_TOLERANCE: f64 = 0.15;

const IMAGES: &str = "A geometry image keeps positions of a closed shape in a square; each cell is cut into two triangles. The \
     shape is an analytic bumpy ball, 2.2 m across, on an octahedral square: no image of the published \
     bunny ships. The published order of vertices cuts every cell from (x + 1, y) to (x, y + 1), which \
     in half of the square crosses the octahedron's folds.";
const SHADOWS: &str = "The published variance shadow sums 25 depths and their squares in f32 and subtracts: near depth 1 the \
     difference is noise. Depths less the receiver's are small numbers, and their variance keeps its \
     digits. On a lit plane every pixel should have all the light; rounding puts the receiver behind \
     its own depth in some, which without a floor under the variance turn dark or black. Subtracting the \
     receiver does not cure that: without noise every such pixel is black, so the floor is needed all the same.";
const HARD: &str = "A hard shadow's map shows texels whose middles are in shadow. Against the disc that casts it the wrong \
     area is about 0.244 of the perimeter times a texel, so it halves with the texel.";
const BLUR: &str = "A bar of 20 pixels moves by 32 while the shutter is open. A picture is the mean of so many layers, each of \
     another moment, and is held against the integral over time in closed form. Layers that show \
     whether a pixel's middle is covered err by one order of their number at best; layers of covered \
     shares by two, from a layer a pixel of motion on, at the middles of parts of the time alone. The \
     published resolve divides by alpha, so that a trail is opaque wherever a layer covers it.";

pub(super) fn findings(cases: &[&Case]) -> Vec<Finding> {
    if of(cases, &[(EXPERIMENT, "geometry-image")]).is_empty() {
        return Vec::new();
    }
    [
        image_ratios(cases),
        better_cut(cases),
        closed_borders(cases),
        subtracted(cases),
        published_noise(cases),
        lit(cases),
        finite(cases),
        edge(cases),
        blur_slope(cases, "point", -1.0),
        blur_slope(cases, "box", -2.0),
    ]
    .into()
}

pub(super) fn sections(cases: &[&Case]) -> Result<Vec<Block>, ChapterError> {
    let is_there = |experiment| !of(cases, &[(EXPERIMENT, experiment)]).is_empty();
    let mut blocks = Vec::new();
    if is_there("geometry-image") {
        blocks.push(Block::section("Geometry images"));
        blocks.push(Block::Text(IMAGES.to_owned()));
        blocks.extend(image_plot(cases)?);
        blocks.push(Block::Table(image_table(cases)));
    }
    if is_there("variance-noise") {
        blocks.push(Block::section("Variance and hard shadows"));
        blocks.push(Block::Text(SHADOWS.to_owned()));
        blocks.push(Block::Table(noise_table(cases)));
        blocks.push(Block::Table(lit_table(cases)));
        blocks.push(Block::Table(bleeding_table(cases)));
        blocks.push(Block::Text(HARD.to_owned()));
        blocks.extend(hard_plot(cases)?);
        blocks.push(Block::Table(hard_table(cases)));
    }
    if is_there("motion-blur") {
        blocks.push(Block::section("Motion blur"));
        blocks.push(Block::Text(BLUR.to_owned()));
        blocks.extend(blur_plot(cases)?);
        blocks.push(Block::Table(resolve_table(cases)));
    }
    Ok(blocks)
}

fn images(cases: &[&Case], cut: &str, metric: &Metric) -> Vec<(f64, f64)> {
    let conditions = [(EXPERIMENT, "geometry-image"), (CUT, cut), (STORED, "f64")];
    series(cases, &conditions, TEXELS, metric)
}

fn resolved(all: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let is_resolved = |pair: &(f64, f64)| pair.0 >= f64::from(RESOLVED_TEXELS);
    all.into_iter().filter(is_resolved).collect()
}

fn image_ratios(cases: &[&Case]) -> Finding {
    let mut ratios = Vec::new();
    for cut in ["published", "fold"] {
        for metric in [IMAGE_MAX_M, IMAGE_RMS_M] {
            let errors = resolved(images(cases, cut, metric));
            ratios.extend(errors.windows(2).map(|pair| pair[0].1 / pair[1].1));
        }
    }
    let is_right = |ratio: &f64| (ratio - RATIO).abs() <= RATIO_TOLERANCE;
    let range = range(&ratios);
    finding(
        "A geometry image's error falls by 4.0 ± 0.2 a doubling from 65 texels on, whichever way cells are cut",
        (!ratios.is_empty()).then(|| ratios.iter().all(is_right)),
        range.map_or_else(String::new, |range| format!("by {range}")),
    )
}

fn better_cut(cases: &[&Case]) -> Finding {
    let published = resolved(images(cases, "published", IMAGE_MAX_M));
    let fold = resolved(images(cases, "fold", IMAGE_MAX_M));
    let gains: Vec<f64> = published
        .iter()
        .zip(&fold)
        .map(|(p, f)| p.1 / f.1)
        .collect();
    let is_right = |gain: &f64| (gain - BETTER_CUT).abs() <= CUT_TOLERANCE;
    finding(
        "Cells cut along the fold are 2.5 ± 0.1 times as near to the shape as those of the published order",
        (!gains.is_empty()).then(|| gains.iter().all(is_right)),
        range(&gains).map_or_else(String::new, |range| format!("{range} times")),
    )
}

fn closed_borders(cases: &[&Case]) -> Finding {
    let own = of(cases, &[(EXPERIMENT, "geometry-image")]);
    let open: Vec<f64> = own
        .iter()
        .filter_map(|case| case.value(IMAGE_OPEN_TEXELS))
        .collect();
    let most = open.iter().copied().max_by(f64::total_cmp);
    finding(
        "No texel of an image's border lies apart from its partner, however positions are stored",
        most.map(|most| most <= 0.0),
        most.map_or_else(String::new, |most| {
            format!("at most {most} of {} images", open.len())
        }),
    )
}

fn noises(cases: &[&Case], moments: &str, metric: &Metric) -> Vec<(f64, f64)> {
    let conditions = [(EXPERIMENT, "variance-noise"), (MOMENTS, moments)];
    series(cases, &conditions, SIGMA, metric)
}

fn subtracted(cases: &[&Case]) -> Finding {
    let all = noises(cases, "receiver subtracted", VARIANCE_RELATIVE_RMS);
    let most = all.iter().map(|pair| pair.1).max_by(f64::total_cmp);
    finding(
        "With the receiver subtracted the variance is right to 2·10⁻⁶ of itself at every spread",
        most.map(|most| most <= RELATIVE_NOISE),
        most.map(|most| format!("worst {}", significant(most)))
            .unwrap_or_default(),
    )
}

fn published_noise(cases: &[&Case]) -> Finding {
    let all = noises(cases, "published", VARIANCE_ABSOLUTE_RMS);
    // The narrowest spread: noise alone.
    let least = all.first().map(|pair| pair.1);
    finding(
        "The published sums carry noise of about 2·10⁻⁷ of the range squared",
        least.map(|noise| (1e-7..=4e-7).contains(&noise)),
        least.map(significant).unwrap_or_default(),
    )
}

fn lit(cases: &[&Case]) -> Finding {
    let of_floor = |floor| {
        let own = of(
            cases,
            &[
                (EXPERIMENT, "lit-plane"),
                (MOMENTS, "published"),
                (FLOOR, floor),
            ],
        );
        let of_fine = own.iter().filter(|case| case.condition(DEPTH) != "8 bits");
        let shares = of_fine.filter_map(|case| case.value(VARIANCE_DARK_SHARE));
        shares.max_by(f64::total_cmp)
    };
    let (bare, floored) = (of_floor("none"), of_floor("1e-7"));
    finding(
        "A lit plane has dark pixels as published, and none with a floor of 10⁻⁷ from 16 bits of depth on",
        bare.zip(floored)
            .map(|(bare, floored)| bare > 0.0 && floored <= 0.0),
        bare.zip(floored)
            .map_or_else(String::new, |(bare, floored)| {
                let [bare, floored] = [bare, floored].map(|share| significant(100.0 * share));
                format!("up to {bare} % and {floored} %")
            }),
    )
}

fn finite(cases: &[&Case]) -> Finding {
    let counts: Vec<f64> = cases
        .iter()
        .filter_map(|case| case.value(VARIANCE_NON_FINITE))
        .collect();
    let most = counts.iter().copied().max_by(f64::total_cmp);
    finding(
        "No variance and no light is NaN or infinite",
        most.map(|most| most <= 0.0),
        most.map(|most| format!("at most {most} in {} cases", counts.len()))
            .unwrap_or_default(),
    )
}

fn edge(cases: &[&Case]) -> Finding {
    let all = series(
        cases,
        &[(EXPERIMENT, "hard-shadow")],
        TEXELS,
        HARD_AREA_SHARE,
    );
    let shares: Vec<f64> = all.iter().map(|pair| pair.1).collect();
    let is_right = |share: &f64| (share - EDGE_SHARE).abs() <= EDGE_TOLERANCE;
    finding(
        "A hard shadow's map shows about 0.244 of its perimeter times a texel wrongly",
        (!shares.is_empty()).then(|| shares.iter().all(is_right)),
        range(&shares).unwrap_or_default(),
    )
}

fn blurs(cases: &[&Case], filter: &str, moments: &str) -> Vec<(f64, f64)> {
    let conditions = [
        (EXPERIMENT, "motion-blur"),
        (FILTER, filter),
        (MOMENTS, moments),
    ];
    series(cases, &conditions, LAYERS, BLUR_RMS)
}

fn blur_slope(cases: &[&Case], filter: &str, expected: f64) -> Finding {
    let all = blurs(cases, filter, "middle");
    let fine: Vec<(f64, f64)> = all.into_iter().filter(|pair| pair.0 >= MOTION_PX).collect();
    let slope = slope(&fine);
    finding(
        &format!(
            "From a layer a pixel of motion on, blur of {filter} layers at middles falls with slope {expected}"
        ),
        slope.map(|slope| (slope - expected).abs() <= SLOPE_TOLERANCE),
        slope.map(significant).unwrap_or_default(),
    )
}

fn image_plot(cases: &[&Case]) -> Result<Option<Block>, ChapterError> {
    let of_cuts = |metric| {
        let curves = ["published", "fold"].map(|cut| curve(cut, &images(cases, cut, metric)));
        curves.into()
    };
    let across = "texels a side";
    draw(
        "error of geometry images",
        "Error of a geometry image against its resolution, by the cut of its cells; positions in f64.",
        &[
            plot(
                "distance",
                across,
                "largest distance, m",
                of_cuts(IMAGE_MAX_M),
            ),
            plot(
                "normals",
                across,
                "normals, rms in degrees",
                of_cuts(IMAGE_NORMAL_DEG),
            ),
        ],
    )
}

fn hard_plot(cases: &[&Case]) -> Result<Option<Block>, ChapterError> {
    let all = |metric| series(cases, &[(EXPERIMENT, "hard-shadow")], TEXELS, metric);
    let area = curve("nearest texel", &all(HARD_WRONG_AREA));
    draw(
        "error of a hard shadow",
        "Area that a map of nearest texels shows wrongly against its resolution.",
        &[plot(
            "area",
            "texels a side of the map",
            "wrong area, share of the map",
            vec![area],
        )],
    )
}

fn blur_plot(cases: &[&Case]) -> Result<Option<Block>, ChapterError> {
    let of_filter = |filter| {
        let moments = ["middle", "end", "stratified", "random"];
        let curves = moments.map(|moments| curve(moments, &blurs(cases, filter, moments)));
        curves.into()
    };
    let (across, up) = ("layers", "rms error of the trail");
    draw(
        "error of motion blur",
        "Error of a mean of layers against the integral over time, by the moments that layers show.",
        &[
            plot("a pixel's middle", across, up, of_filter("point")),
            plot("a pixel's covered share", across, up, of_filter("box")),
        ],
    )
}

fn image_table(cases: &[&Case]) -> Table {
    table(
        cases,
        "Geometry images by cut, storage and resolution",
        "geometry-image",
        &[
            ("cut", CUT),
            ("stored in", STORED),
            ("texels a side", TEXELS),
        ],
        &[
            ("largest distance, m", IMAGE_MAX_M),
            ("rms, m", IMAGE_RMS_M),
            ("largest, px of 1,024", IMAGE_MAX_PX),
            ("normals, rms °", IMAGE_NORMAL_DEG),
            ("open texels", IMAGE_OPEN_TEXELS),
        ],
    )
}

fn noise_table(cases: &[&Case]) -> Table {
    table(
        cases,
        "Error of the variance of 25 taps near depth 1, in f32",
        "variance-noise",
        &[("moments", MOMENTS), ("spread of depths", SIGMA)],
        &[
            ("relative, rms", VARIANCE_RELATIVE_RMS),
            ("absolute, rms", VARIANCE_ABSOLUTE_RMS),
            ("absolute, largest", VARIANCE_ABSOLUTE_MAX),
            ("not finite", VARIANCE_NON_FINITE),
        ],
    )
}

fn lit_table(cases: &[&Case]) -> Table {
    table(
        cases,
        "A flat plane that nothing shadows: shares of its pixels",
        "lit-plane",
        &[("moments", MOMENTS), ("depth", DEPTH), ("floor", FLOOR)],
        &[
            ("below 0.99 of the light", VARIANCE_DARK_SHARE),
            ("below 0.01", VARIANCE_BLACK_SHARE),
            ("outside of 0 to 1", VARIANCE_OUTSIDE_SHARE),
            ("not finite", VARIANCE_NON_FINITE),
        ],
    )
}

/// What bleeds through two occluders, beside the formula.
fn bleeding_table(cases: &[&Case]) -> Table {
    let mut table = table(
        cases,
        "Light through two occluders that hide a place wholly, where 0 is right",
        "bleeding",
        &[("gap between them over gap to the receiver", GAPS)],
        &[("largest light of 25 taps", VARIANCE_BLEEDING)],
    );
    let own = of(cases, &[(EXPERIMENT, "bleeding")]);
    for (row, case) in table.rows.iter_mut().zip(own) {
        let gaps: Option<f64> = case.condition(GAPS).parse().ok();
        let most = gaps.map(|gaps| significant(worst_bleeding(gaps)));
        row.cells.push(Cell::or_absent(most, "no number"));
    }
    let heading = Heading::explained("(r / (r + 2))²", "of any number of taps");
    table.headings.push(heading);
    table
}

fn hard_table(cases: &[&Case]) -> Table {
    table(
        cases,
        "A disc's hard shadow by a map of nearest texels",
        "hard-shadow",
        &[("texels a side", TEXELS)],
        &[
            ("wrong area, share of the map", HARD_WRONG_AREA),
            ("over perimeter · texel", HARD_AREA_SHARE),
            ("largest deviation, texels", HARD_DEVIATION_TEXELS),
        ],
    )
}

fn resolve_table(cases: &[&Case]) -> Table {
    table(
        cases,
        "Resolves of layers against a trail that fades linearly with age",
        "blur-resolve",
        &[("resolve", RESOLVE), ("layers", LAYERS)],
        &[("rms", BLUR_RMS), ("largest", BLUR_MAX)],
    )
}
