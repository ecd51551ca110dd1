// SPDX-License-Identifier: MIT OR Apache-2.0
//! Views that tiles lie in, read from `views.toml`.

use serde::Deserialize;
use terrafill_globe_views::ViewRow;

const LIST: &str = include_str!("../views.toml");

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    view: Vec<ViewRow>,
}

/// # Errors
/// What is wrong with the text, with its line.
fn parse(text: &str) -> Result<Vec<ViewRow>, String> {
    let list: List = toml::from_str(text).map_err(|error| error.to_string())?;
    Ok(list.view)
}

/// # Errors
/// As [`parse`].
pub(crate) fn shipped() -> Result<Vec<ViewRow>, String> {
    parse(LIST)
}

/// The shipped view of that name.
#[cfg(test)]
pub(crate) fn tiled_view(name: &str) -> ViewRow {
    let views = shipped().expect("a list");
    let mut views = views.into_iter();
    views.find(|view| view.name == name).expect("the view")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_list_has_no_view_that_is_both_quick_and_full() {
        let views = shipped().expect("a list");
        assert!(views.iter().all(|view| !(view.quick && view.full)));
        assert!(views.iter().any(|view| view.quick) && views.iter().any(|view| view.full));
        // Negative control: a key that there is not.
        let wrong = LIST.replacen("pitch_deg", "pitch", 1);
        assert!(parse(&wrong).is_err_and(|error| error.contains("pitch")));
    }
}
