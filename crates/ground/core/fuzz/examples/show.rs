// SPDX-License-Identifier: MIT OR Apache-2.0
//! Shows inputs of the fuzz targets: what they draw, what comes of it, which branches they reach.
//!
//! usage: cargo run --release --example show -- geojson|mesh INPUT…

use terrafill_core::{RegionMesh, parse_regions};
use terrafill_fixtures::fuzz::{bytes::Bytes, geojson, mesh, reached::Reached};

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args_os().skip(1);
    let is_mesh = arguments.next().is_some_and(|target| target == "mesh");
    for path in arguments {
        let input = std::fs::read(&path)?;
        println!("file {}", path.display());
        let branches = if is_mesh {
            show_mesh(&input);
            mesh::BRANCHES
        } else {
            println!("{}", String::from_utf8_lossy(&geojson::text_of(&input)));
            geojson::BRANCHES
        };
        let mut reached = Reached::new(branches);
        let check = if is_mesh { mesh::check } else { geojson::check };
        match check(&input, &mut reached) {
            Ok(()) => println!("verdict: no find"),
            Err(find) => println!("verdict: {}", find.lines().next().unwrap_or("a find")),
        }
        println!("reached {}", reached.found().join(" "));
    }
    Ok(())
}

fn show_mesh(input: &[u8]) {
    let case = mesh::decode(&mut Bytes::new(input));
    let text = mesh::text_of(&case.polygons);
    println!("{text}");
    let (body, repair) = (case.body.name(), case.repair);
    println!(
        "{body}, {:?}, {:?}, repair {repair}",
        case.rule, case.options
    );
    let Ok(mut regions) = parse_regions(text.as_bytes(), "input") else {
        println!("unreadable");
        return;
    };
    if repair {
        let crossings = regions[0].split_at_crossings(case.rule);
        println!("{crossings} crossings made vertices");
    }
    match RegionMesh::build(&regions[0], &case.body, case.rule, &case.options) {
        Ok(mesh) => println!(
            "{} vertices, {} triangles, {} m²",
            mesh.vertex_count(),
            mesh.triangle_count(),
            mesh.area_m2
        ),
        Err(error) => println!("{error}"),
    }
}
