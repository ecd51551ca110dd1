// SPDX-License-Identifier: MIT OR Apache-2.0
//! Replays the seeds and regressions of the fuzz target `models`; they must reach all its branches.

use terrafill_casters::{Mesh, ModelFile, Reading};
use terrafill_fixtures::fuzz::{models, reached::Reached, replay::assert_replays};

#[test]
fn the_corpus_replays_and_reaches_every_branch() {
    assert_replays("models", models::check, models::BRANCHES);
}

type Damage = fn(&mut Mesh);

#[test]
fn a_corpus_that_misses_a_branch_and_a_broken_mesh_are_noticed() {
    // Negative control: one input reaches one branch.
    let mut reached = Reached::new(models::BRANCHES);
    models::check(&[0], &mut reached).expect("refused as it should be");
    assert_eq!(reached.found(), ["obj_refused"]);
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let read = ModelFile::parse("a.obj", text, Reading::default());
    let right = read.expect("a triangle").mesh;
    models::check_mesh(&right, &mut reached).expect("right");
    // Negative controls: a mesh broken in one place each.
    let broken: [(&str, Damage); 6] = [
        ("no triangles", |mesh| mesh.triangles.clear()),
        ("vertex 0", |mesh| mesh.vertices[0].x = f64::NAN),
        ("planes", |mesh| mesh.planes.clear()),
        ("plane 7", |mesh| mesh.planes[0] = 7),
        ("corner 9", |mesh| mesh.triangles[0][1] = 9),
        ("behind vertex", |mesh| mesh.parts[0].vertices.start = 1),
    ];
    for (find, damage) in broken {
        let mut mesh = right.clone();
        damage(&mut mesh);
        let found = models::check_mesh(&mesh, &mut reached).expect_err(find);
        assert!(found.contains(find), "{found}");
    }
}
