// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lines of a terminal.

/// Broken behind spaces and bars.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_inclusive([' ', '|']) {
        match lines.last_mut() {
            Some(last)
                if last.is_empty()
                    || last.chars().count() + word.trim_end().chars().count() <= width =>
            {
                last.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
        .iter()
        .map(|line| line.trim_end().to_owned())
        .collect()
}
