// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on who splits triangles across ±180°.

use super::PART;
use crate::keys::{
    GLOBE_MAKE_CPU_MS, GLOBE_TILE_CROSSING, GLOBE_TILE_MISSED, GLOBE_TILE_SEAM_PX,
    GLOBE_TILE_SEAM_WRONG_PX, GLOBE_TILE_TEXELS_MAX, GLOBE_TRIANGLES, LIMIT, SPLIT_BY, VIEW,
};
use crate::table::{by_case, cases, conditions};
use terrafill_results::{Block, Case, Clock, Finding, Run, Standing};

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run, clock: Clock) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    let columns = [
        ("triangles sent", GLOBE_TRIANGLES),
        ("crossing", GLOBE_TILE_CROSSING),
        ("missed", GLOBE_TILE_MISSED),
        ("px at the seam", GLOBE_TILE_SEAM_PX),
        ("off by > ½ texel", GLOBE_TILE_SEAM_WRONG_PX),
        ("texels, largest", GLOBE_TILE_TEXELS_MAX),
        ("frame, ms", crate::clock::whole(clock)),
        ("make, CPU ms", GLOBE_MAKE_CPU_MS),
        ("draw, ms", crate::clock::draw(clock)),
    ];
    let names = ["view", "split by", "where U differs by"];
    let table = by_case(
        "Who splits triangles across ±180°",
        &cases,
        (&names, &conditions(&[VIEW, SPLIT_BY, LIMIT])),
        &columns,
        &|_| "only the shader knows",
    );
    vec![
        Block::section("The seam split by a geometry shader and by the CPU"),
        Block::Text(
            "On Vulkan, 10 × 10 cells; a pixel shows its U in 24 bits. The geometry shader is the published one; the CPU \
             splits by the same rule before vertices are sent."
                .to_owned(),
        ),
        Block::Table(table),
        Block::Finding(finding(&cases)),
    ]
}

fn finding(cases: &[&Case]) -> Finding {
    let wrong = |by: &str, limit: &str| {
        let own = cases
            .iter()
            .filter(|case| case.condition(SPLIT_BY) == by && case.condition(LIMIT) == limit);
        let values: Vec<f64> = own
            .filter_map(|case| case.value(GLOBE_TILE_SEAM_WRONG_PX))
            .collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>())
    };
    let all = [
        ("geometry-shader", "0.7"),
        ("geometry-shader", "0.5"),
        ("cpu", "0.7"),
        ("cpu", "0.5"),
    ];
    let words: Vec<String> = all
        .iter()
        .filter_map(|(by, limit)| Some(format!("{by} at {limit}: {} px wrong", wrong(by, limit)?)))
        .collect();
    let pairs =
        ["0.7", "0.5"].map(|limit| wrong("geometry-shader", limit).zip(wrong("cpu", limit)));
    Finding {
        claim: "The CPU's split is the geometry shader's: the same pixels are right".to_owned(),
        standing: match pairs {
            [Some((a, b)), Some((c, d))] => Standing::holds_if(a == b && c == d),
            _ => Standing::CannotTell,
        },
        because: format!("{}.", words.join("; ")),
    }
}
