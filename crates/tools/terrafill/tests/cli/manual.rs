// SPDX-License-Identifier: MIT OR Apache-2.0
//! What shells complete by, and manual pages.

use crate::harness::Desk;

#[test]
fn every_shell_has_completions_and_no_other_word_does() {
    let desk = Desk::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let text = desk.run(&["completions", shell]).succeeded();
        for word in ["terrafill", "bench", "technique"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
    // Negative control.
    desk.run(&["completions", "fishx"]).refused(&[&[
        "<SHELL>: found \"fishx\", allowed: bash, ",
        "; did you mean \"fish\"?",
    ]]);
}

#[test]
fn every_command_has_a_page_and_what_is_hidden_has_none() {
    let desk = Desk::new();
    desk.run(&["man", "pages/man1"]).succeeded();
    for (page, words) in [
        ("terrafill.1", "Exit codes"),
        ("terrafill-bench.1", "\\-\\-technique"),
        ("terrafill-history-add.1", "\\-\\-store"),
    ] {
        let text = desk.read_text(&format!("pages/man1/{page}"));
        assert!(
            text.contains(".TH ") && text.contains(words),
            "{page}: {text}"
        );
    }
    // Negative controls: a command that only the program starts, and a folder that is none.
    assert!(!desk.path("pages/man1/terrafill-growth-sample.1").exists());
    desk.write("file", "");
    desk.run(&["man", "file"])
        .refused(&[&["file: cannot be written: "]]);
}
