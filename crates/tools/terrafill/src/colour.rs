// SPDX-License-Identifier: MIT OR Apache-2.0
//! Whether errors have colours, which is known before the command line is: what is wrong with it is an error, too.

use clap::{ColorChoice, ValueEnum as _};
use std::io::IsTerminal as _;
use std::sync::OnceLock;

static IS_SHOWN: OnceLock<bool> = OnceLock::new();

/// What `--color` says of a command line, for clap; what it cannot say is refused there. From then on
/// [`error_mark`] obeys it.
pub(crate) fn asked(words: &[String]) -> ColorChoice {
    let options = words.iter().take_while(|word| *word != "--");
    let values = options.zip(words.iter().skip(1).map(Some).chain([None]));
    let given = values.filter_map(|(word, next)| match word.strip_prefix("--color")? {
        "" => next.map(String::as_str),
        value => value.strip_prefix('='),
    });
    let choice = given
        .last()
        .and_then(|value| ColorChoice::from_str(value, false).ok());
    let choice = choice.unwrap_or(ColorChoice::Auto);
    let is_plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty())
        || std::env::var_os("TERM").is_some_and(|value| value == "dumb");
    let is_terminal = std::io::stderr().is_terminal();
    IS_SHOWN.get_or_init(|| is_shown(choice, is_terminal && !is_plain));
    choice
}

/// - `by_itself`: standard error is a terminal, and nobody asked for none
fn is_shown(choice: ColorChoice, by_itself: bool) -> bool {
    match choice {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => by_itself,
    }
}

/// What every error begins with, in clap's colour or in none.
pub(crate) fn error_mark() -> String {
    if !IS_SHOWN.get().is_some_and(|is_shown| *is_shown) {
        return "error:".to_owned();
    }
    let styles = clap::builder::Styles::styled();
    let style = styles.get_error();
    format!("{style}error:{style:#}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_decides_before_the_terminal_does() {
        let asked = |line: &str| {
            let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            asked(&words)
        };
        assert_eq!(asked("terrafill mesh f --color never"), ColorChoice::Never);
        assert_eq!(
            asked("terrafill --color=always mesh f"),
            ColorChoice::Always
        );
        // Negative controls: none, no word for it, and arguments of another program.
        for line in [
            "terrafill mesh f",
            "terrafill --color blue",
            "terrafill x -- --color never",
        ] {
            assert_eq!(asked(line), ColorChoice::Auto, "{line}");
        }
        for by_itself in [false, true] {
            assert!(is_shown(ColorChoice::Always, by_itself));
            assert!(!is_shown(ColorChoice::Never, by_itself));
            assert_eq!(is_shown(ColorChoice::Auto, by_itself), by_itself);
        }
    }
}
