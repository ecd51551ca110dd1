// SPDX-License-Identifier: MIT OR Apache-2.0
//! What `--version` says of the build; `-V` has the number alone.

use std::sync::OnceLock;

/// Number, commit and build, a line each.
pub(crate) fn long() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| of_commit(env!("TERRAFILL_COMMIT")))
}

/// - `commit`: empty where there was no git, such as in an unpacked archive
fn of_commit(commit: &str) -> String {
    let commit = match commit {
        "" => "unknown, built outside git",
        commit => commit,
    };
    let profile = if cfg!(debug_assertions) {
        "debug"
    } else {
        "release"
    };
    format!(
        "{}\ncommit {commit}\n{profile} build, features {}, wgpu {}, ash {}",
        env!("CARGO_PKG_VERSION"),
        env!("TERRAFILL_FEATURES"),
        env!("TERRAFILL_wgpu"),
        env!("TERRAFILL_ash"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_outside_git_says_so() {
        let lines = |commit| of_commit(commit).lines().nth(1).map(str::to_owned);
        let outside = "commit unknown, built outside git".to_owned();
        assert_eq!(lines(""), Some(outside));
        assert_eq!(lines("abc+dirty"), Some("commit abc+dirty".to_owned()));
    }
}
