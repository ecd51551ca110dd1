// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a scene of a suite is for and what must come of it, read without the scene itself: a scene that
//! must be refused has a reason and an expectation too.
//!
//! All other keys of the file are left to [`crate::Scene`], which refuses those that mean nothing.

use crate::{ImageSize, SceneError};
use serde::Deserialize;

/// Pixels of a side at most: what the drivers that are known can draw on.
const MAX_SIDE_PX: u32 = 16_384;

/// What must come of a scene or of one of its views.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Expectation {
    /// It is filled, and the picture is right.
    Fills,
    /// It is refused, with these words in the message.
    Refused(String),
}

impl Expectation {
    /// What may stand in a file.
    pub const ALLOWED: &'static str = "\"fills\" or \"refused: WORDS OF THE MESSAGE\"";

    /// From the words of a file; `None` for others.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        if text == "fills" {
            return Some(Self::Fills);
        }
        let words = text.strip_prefix("refused:")?.trim();
        // No words would take any message for the right one.
        (!words.is_empty()).then(|| Self::Refused(words.to_owned()))
    }

    /// As in a file.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::Fills => "fills".to_owned(),
            Self::Refused(words) => format!("refused: {words}"),
        }
    }
}

/// A scene of a suite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SuiteScene {
    /// Name in reports.
    pub name: String,
    /// Why it is in the suite.
    pub reason: String,
    /// What must come of it, unless a view says otherwise.
    pub expect: Expectation,
    /// Its views.
    pub views: Vec<SuiteView>,
}

/// A view of such a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SuiteView {
    /// Name in reports.
    pub name: String,
    /// What must come of it.
    pub expect: Expectation,
    /// Of its picture; that of the run where it has none.
    pub size: Option<ImageSize>,
    /// Switches that are not the technique's defaults, as keys and values.
    pub set: Vec<(String, String)>,
    /// What is hard about it.
    pub note: Option<String>,
}

#[derive(Deserialize)]
struct RawSuiteScene {
    name: String,
    #[serde(default)]
    reason: String,
    expect: Option<String>,
    #[serde(default)]
    views: Vec<RawSuiteView>,
}

#[derive(Deserialize)]
struct RawSuiteView {
    name: String,
    expect: Option<String>,
    size: Option<[u32; 2]>,
    #[serde(default)]
    set: Vec<String>,
    note: Option<String>,
}

impl SuiteScene {
    /// From the text of a scene file; `file` is for messages.
    ///
    /// # Errors
    /// [`SceneError::Syntax`] for what is no TOML, [`SceneError::Value`] for a missing reason or an
    /// expectation, a size or a switch that is none.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, SceneError> {
        let raw: RawSuiteScene = crate::error::parsed(text, file)?;
        let refuse = |key: String, found: String, allowed: &str| SceneError::Value {
            file: file.to_owned(),
            key,
            found,
            allowed: allowed.to_owned(),
        };
        if raw.reason.trim().is_empty() {
            let allowed = "why the scene is in its suite";
            return Err(refuse("reason".to_owned(), "nothing".to_owned(), allowed));
        }
        let expectation = |key: String, found: Option<&str>| {
            let Some(found) = found else {
                return Err(refuse(key, "nothing".to_owned(), Expectation::ALLOWED));
            };
            let parsed = Expectation::parse(found);
            parsed.ok_or_else(|| refuse(key, format!("{found:?}"), Expectation::ALLOWED))
        };
        let expect = expectation("expect".to_owned(), raw.expect.as_deref())?;
        let mut views = Vec::new();
        for (i, view) in raw.views.into_iter().enumerate() {
            let key = |name: &str| format!("views[{i}].{name}");
            let size = match view.size {
                None => None,
                Some([width, height]) => {
                    let is_allowed = |side: u32| (1..=MAX_SIDE_PX).contains(&side);
                    if !(is_allowed(width) && is_allowed(height)) {
                        let allowed = format!("two numbers from 1 to {MAX_SIDE_PX}");
                        return Err(refuse(key("size"), format!("{width} × {height}"), &allowed));
                    }
                    Some(ImageSize { width, height })
                }
            };
            let mut set = Vec::new();
            for switch in view.set {
                match switch.split_once('=') {
                    Some((name, value)) => set.push((name.to_owned(), value.to_owned())),
                    None => return Err(refuse(key("set"), format!("{switch:?}"), "KEY=VALUE")),
                }
            }
            views.push(SuiteView {
                expect: match &view.expect {
                    None => expect.clone(),
                    found => expectation(key("expect"), found.as_deref())?,
                },
                name: view.name,
                size,
                set,
                note: view.note,
            });
        }
        Ok(Self {
            name: raw.name,
            reason: raw.reason,
            expect,
            views,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"name = "t"
reason = "because"
expect = "fills"
body = "wgs84"

[[views]]
name = "a"
size = [7, 3]

[[views]]
name = "b"
expect = "refused: allowed 255"
set = ["colour=one-colour"]
"#;

    #[test]
    fn a_view_has_its_own_expectation_or_its_scenes() {
        let scene = SuiteScene::from_toml(GOOD, "t.toml").expect("valid");
        assert_eq!(scene.expect, Expectation::Fills);
        let [a, b] = &scene.views[..] else {
            panic!("two views")
        };
        assert_eq!(a.expect, Expectation::Fills);
        let size = ImageSize::new(7, 3);
        assert_eq!(a.size, Some(size));
        assert_eq!(b.expect, Expectation::Refused("allowed 255".to_owned()));
        assert_eq!(b.set, [("colour".to_owned(), "one-colour".to_owned())]);
        assert_eq!(b.expect.text(), "refused: allowed 255");
    }

    #[test]
    fn what_is_wrong_is_named_with_file_key_value_and_what_is_allowed() {
        let mistakes = r#"reason = "because" -> reason = ""
    reason: found nothing, allowed: why the scene is in its suite
expect = "fills" -> expect = "draws"
    expect: found "draws", allowed: "fills" or "refused: WORDS OF THE MESSAGE"
refused: allowed 255 -> refused:
    views[1].expect: found "refused:", allowed: "fills" or "refused: WORDS OF THE MESSAGE"
[7, 3] -> [0, 3]
    views[0].size: found 0 × 3, allowed: two numbers from 1 to 16384
colour=one-colour -> colour
    views[1].set: found "colour", allowed: KEY=VALUE"#;
        let mut lines = mistakes.lines();
        while let (Some(change), Some(message)) = (lines.next(), lines.next()) {
            let (from, to) = change.split_once(" -> ").expect(message);
            assert!(GOOD.contains(from), "{from}");
            let text = GOOD.replacen(from, to, 1);
            let error = SuiteScene::from_toml(&text, "t.toml").expect_err(to);
            assert_eq!(error.to_string(), format!("t.toml: {}", message.trim()));
        }
    }
}
