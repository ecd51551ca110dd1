// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on who splits triangles across ±180°.

use super::PART;
use crate::table::{by_case, cases, conditions};
use terrafill_results::{Block, Case, Clock, Finding, Run, Standing};

/// The section; nothing where no case was planned.
pub(crate) fn blocks(run: &Run, clock: Clock) -> Vec<Block> {
    let cases = cases(run, PART);
    if cases.is_empty() {
        return Vec::new();
    }
    let columns = [
        ("triangles sent", "globe_triangles"),
        ("crossing", "globe_tile_crossing"),
        ("missed", "globe_tile_missed"),
        ("px at the seam", "globe_tile_seam_px"),
        ("off by > ½ texel", "globe_tile_seam_wrong_px"),
        ("texels, largest", "globe_tile_texels_max"),
        ("frame, ms", crate::clock::whole(clock)),
        ("make, CPU ms", "globe_make_cpu_ms"),
        ("draw, ms", crate::clock::draw(clock)),
    ];
    let names = ["view", "split by", "where U differs by"];
    let table = by_case(
        "Who splits triangles across ±180°",
        &cases,
        (&names, &conditions(&["view", "split_by", "limit"])),
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
            .filter(|case| case.condition("split_by") == by && case.condition("limit") == limit);
        let values: Vec<f64> = own
            .filter_map(|case| case.value("globe_tile_seam_wrong_px"))
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
