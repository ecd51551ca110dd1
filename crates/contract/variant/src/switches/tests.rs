// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which switches go together, and that what is named can be set again.

use super::*;

/// Every switch away from its default, at the first other value that its row lists.
fn all_changed() -> Switches {
    let mut changed = Switches::default();
    for row in TABLE {
        let usual = (row.get)(&changed);
        let mut others = row.values.list().into_iter();
        let other = others.find(|value| *value != usual && row.values.allows(value));
        let other = other.expect(row.key);
        assert_eq!(changed.set(row.key, other), Ok(true), "{}", row.key);
    }
    changed
}

#[test]
fn every_field_has_a_row() {
    let fields = |switches: Switches| -> Vec<String> {
        let text = format!("{switches:?}");
        text.split(", ").map(str::to_owned).collect()
    };
    let unchanged = |switches: Switches| -> Vec<String> {
        let both = fields(switches)
            .into_iter()
            .zip(fields(Switches::default()));
        both.filter(|(one, other)| one == other)
            .map(|(one, _)| one)
            .collect()
    };
    assert_eq!(
        fields(all_changed()).len(),
        fields(Switches::default()).len()
    );
    assert_eq!(unchanged(all_changed()), [""; 0]);
    // Negative control: a field that no row changes.
    let mut forgotten = all_changed();
    forgotten.scissor = false;
    assert_eq!(unchanged(forgotten), ["scissor: false"]);
}

#[test]
fn what_is_named_can_be_set_again() {
    assert_eq!(Switches::default().names(), Vec::<String>::new());
    let changed = all_changed();
    let names = changed.names();
    assert_eq!(names.len(), TABLE.len());
    assert!(names.is_sorted());
    let mut read = Switches::default();
    for name in &names {
        let (key, value) = name.split_once('=').expect("key=value");
        assert_eq!(read.set(key, value), Ok(true), "{name}");
    }
    assert_eq!(read, changed);
}

#[test]
fn unknown_keys_and_values_are_told_apart() {
    let mut switches = Switches::default();
    assert_eq!(switches.set("stensil", "on"), Ok(false));
    let error = switches.set("faces", "three").expect_err("no such value");
    assert_eq!(
        error.to_string(),
        "faces: found three, allowed: two-sided, two-pass"
    );
    assert_eq!(switches, Switches::default());
}

#[test]
fn what_does_not_go_together_is_refused() {
    assert!(Switches::default().check(Overlap::Disjoint).is_ok());
    assert!(Switches::default().check(Overlap::Ordered).is_err());
    let plain = Switches {
        colour: ColourWay::OneColour,
        faces: FacePasses::TwoPass,
        depth_rule: DepthRuleChoice::Automatic,
        bottom_cap: BottomCap::WhereNeeded,
        first_pass: FirstPass::Program,
        scissor: true,
        holds_drawn_meshes: true,
        cover_area: CoverArea::Screen,
        cover_culls_faces: true,
        stencil_clear: StencilClear::ByColour,
        copies_depth: true,
        loads_texture: true,
        bends_footprints: true,
        ..Switches::default()
    };
    assert!(plain.check(Overlap::Ordered).is_ok());
    let kept = Switches {
        kept_stencil_bits: 1,
        ..plain
    };
    assert!(kept.check(Overlap::Ordered).is_err());
    // Nothing is loaded for nothing that is needed anyway, and shared numbers need rectangles.
    let both = Switches {
        loads_texture: true,
        texture: Some(RouteChoice::Chosen),
        ..Switches::default()
    };
    let error = both.check(Overlap::Disjoint).expect_err("needed");
    assert_eq!(error.switch, "texture-code");
    for colour in ColourWay::ALL {
        let everywhere = Switches {
            colour,
            cover_area: CoverArea::Screen,
            ..Switches::default()
        };
        let shares = [
            ColourWay::Xor,
            ColourWay::BitPlanes,
            ColourWay::IdAccumulation,
        ];
        let found = everywhere.check(Overlap::Disjoint);
        assert_eq!(found.is_err(), shares.contains(&colour), "{colour:?}");
    }
    let mixed = Switches {
        stencil_clear: StencilClear::ByColour,
        ..Switches::default()
    };
    assert!(mixed.check(Overlap::Disjoint).is_err());
    for colour in ColourWay::ALL {
        let textured = Switches {
            colour,
            texture: Some(RouteChoice::Chosen),
            ..Switches::default()
        };
        let apart = [ColourWay::Xor, ColourWay::BitPlanes].contains(&colour);
        assert_eq!(
            textured.check(Overlap::Disjoint).is_ok(),
            apart,
            "{colour:?}"
        );
        // The first pass is one of its own only where all regions get one colour.
        let written = Switches {
            colour,
            first_pass: FirstPass::Colour,
            ..Switches::default()
        };
        assert_eq!(
            written.check(Overlap::Disjoint).is_ok(),
            !colour.tells_regions_apart(),
            "{colour:?}"
        );
    }
    let lost = Switches {
        position: Some(PositionRoute::EyeEcef),
        ..Switches::default()
    };
    assert!(lost.check(Overlap::Disjoint).is_err());
    let mut normalised = Switches {
        superfluous_normalize: true,
        ..Switches::default()
    };
    let error = normalised.check(Overlap::Disjoint).expect_err("plain");
    assert_eq!(error.switch, "normalize");
    normalised.texture = Some(RouteChoice::Chosen);
    assert!(normalised.check(Overlap::Disjoint).is_ok());
    let bent = Switches {
        bends_footprints: true,
        ..normalised
    };
    let error = bent.check(Overlap::Disjoint).expect_err("textured");
    assert_eq!(error.switch, "vertices");
}

#[test]
fn covers_are_tiles_only_where_they_are_one_draw_of_rectangles() {
    let tiles = Switches {
        merges_draws: true,
        cover_area: CoverArea::Tiles,
        ..Switches::default()
    };
    assert_eq!(tiles.check(Overlap::Disjoint), Ok(()));
    for (key, value) in [
        ("draws", "each"),
        ("colour", "rectangle"),
        ("colour", "id-accumulation"),
        ("texture", "chosen"),
    ] {
        let mut wrong = tiles;
        assert_eq!(wrong.set(key, value), Ok(true));
        let error = wrong.check(Overlap::Disjoint).expect_err(value);
        assert_eq!(error.switch, "cover-area");
        assert!(
            error.to_string().contains(&format!("{key}={value}")),
            "{error}"
        );
        // Negative control: cut to rectangles it is allowed.
        wrong.cover_area = CoverArea::Rectangle;
        assert_eq!(wrong.check(Overlap::Disjoint), Ok(()));
    }
}

#[test]
fn draws_are_merged_only_where_nothing_changes_between_them() {
    let merged = Switches {
        merges_draws: true,
        ..Switches::default()
    };
    assert_eq!(merged.check(Overlap::Disjoint), Ok(()));
    let mut wrong = merged;
    assert_eq!(wrong.set("scissor", "volumes"), Ok(true));
    let error = wrong.check(Overlap::Disjoint).expect_err("cut");
    assert_eq!(error.switch, "draws");
    assert!(error.to_string().contains("scissor=volumes"), "{error}");
    // Negative control: drawn one by one it is allowed.
    wrong.merges_draws = false;
    assert_eq!(wrong.check(Overlap::Disjoint), Ok(()));
}

#[test]
fn what_is_there_without_a_switch_can_be_asked_for() {
    let mut switches = all_changed();
    assert_eq!(switches.set("texture", "plain"), Ok(true));
    assert_eq!(switches.set("position", "eye-region"), Ok(true));
    assert_eq!((switches.texture, switches.position), (None, None));
    assert_eq!(switches.set("texture", "gnomonic-3"), Ok(true));
    assert!(switches.names().contains(&"texture=gnomonic-3".to_owned()));
    let error = switches.set("texture", "odd-4").expect_err("no such route");
    assert!(error.to_string().contains("odd-4"), "{error}");
}
