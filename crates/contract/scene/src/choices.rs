// SPDX-License-Identifier: MIT OR Apache-2.0
//! Names in messages: as many as one reads, and the one that was probably meant.

/// Names of a list at most.
const MAX_NAMES: usize = 10;
/// Characters of a list at most, so that the line that holds it is read at a glance.
const MAX_CHARACTERS: usize = 100;
/// Jaro similarity from which on clap suggests an option: the same of everything else.
const ALIKE: f64 = 0.7;

/// What a message allows in place of `found`: of many `names` the first, and behind them the one that is most like it.
/// What is in a folder is found by its last part, too.
#[must_use]
pub fn choices<'a>(found: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let mut characters = 0;
    let fit = names.iter().take(MAX_NAMES).take_while(|name| {
        characters += name.chars().count() + 2;
        characters <= MAX_CHARACTERS
    });
    let shown = fit.count().max(1).min(names.len());
    let mut list = names[..shown].join(", ");
    if shown < names.len() {
        list += &format!(" … and {} more", names.len() - shown);
    }
    let likeness = |name: &str| {
        let last = name.rsplit('/').next().unwrap_or(name);
        strsim::jaro(found, name).max(strsim::jaro(found, last))
    };
    let rated = names.iter().map(|name| (likeness(name), name));
    let alike = rated.filter(|(likeness, _)| *likeness > ALIKE);
    if let Some((_, name)) = alike.max_by(|a, b| a.0.total_cmp(&b.0)) {
        list += &format!("; did you mean {name:?}?");
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_cut_and_what_is_alike_is_suggested() {
        let names = ["vertex", "compute", "terrain/everest"];
        let all = "vertex, compute, terrain/everest";
        for (found, meant) in [
            ("vertexx", "vertex"),
            ("Compute", "compute"),
            ("everestx", "terrain/everest"),
        ] {
            let expected = format!("{all}; did you mean {meant:?}?");
            assert_eq!(choices(found, names), expected);
        }
        // Negative control: what is like none.
        assert_eq!(choices("moon", names), all);
        let many: Vec<String> = (0..25).map(|number| number.to_string()).collect();
        let many = choices("x", many.iter().map(String::as_str));
        assert_eq!(many, "0, 1, 2, 3, 4, 5, 6, 7, 8, 9 … and 15 more");
        let long = "a".repeat(60);
        assert_eq!(
            choices("x", [&*long, &long]),
            format!("{long} … and 1 more")
        );
        assert_eq!(choices("x", []), "");
    }
}
