// SPDX-License-Identifier: MIT OR Apache-2.0
//! Patterns of cases, as limits and `bless` have them: `*` stands for any characters, also for none.

/// Whether `text` is one that `pattern` names.
#[must_use]
pub fn matches(pattern: &str, text: &str) -> bool {
    let Some((start, rest)) = pattern.split_once('*') else {
        return pattern == text;
    };
    let Some(mut text) = text.strip_prefix(start) else {
        return false;
    };
    let (middle, end) = rest.rsplit_once('*').unwrap_or(("", rest));
    // Each piece where it comes first leaves the most for the others.
    for piece in middle.split('*') {
        match text.find(piece) {
            Some(at) => text = &text[at + piece.len()..],
            None => return false,
        }
    }
    text.ends_with(end)
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn a_star_stands_for_any_characters() {
        for (pattern, text) in [
            ("filling/a", "filling/a"),
            ("filling/*", "filling/a/globe"),
            ("*", ""),
            ("*/doubled", "filling/a/doubled"),
            ("filling/*/globe/*", "filling/a/globe/vertex"),
            ("a*b*c", "abbc"),
            ("a**c", "ac"),
        ] {
            assert!(matches(pattern, text), "{pattern} {text}");
        }
        for (pattern, text) in [
            ("filling/a", "filling/ab"),
            ("filling/*", "fillin"),
            ("*/doubled", "filling/a/doubled-2"),
            ("filling/*/globe/*", "filling/globe/vertex"),
            ("a*b*c", "acb"),
            ("ab*ba", "aba"),
            ("", "a"),
        ] {
            assert!(!matches(pattern, text), "{pattern} {text}");
        }
    }
}
