// SPDX-License-Identifier: MIT OR Apache-2.0
//! Finds quotations, titles and figures of a file of claims that are not in the document's text.

use crate::claims::Paper;

/// Line breaks are spaces, and ligatures the letters that they stand for.
fn normal(text: &str) -> String {
    let ligatures = [
        ("ﬀ", "ff"),
        ("ﬁ", "fi"),
        ("ﬂ", "fl"),
        ("ﬃ", "ffi"),
        ("ﬄ", "ffl"),
    ];
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    ligatures
        .iter()
        .fold(text, |text, (one, letters)| text.replace(one, letters))
}

impl<T> Paper<T> {
    /// Quotations, titles of their sections and figures of tables that are not in the document. A text may have a
    /// table's figures row by row or column by column.
    ///
    /// - `document`: its text, with line breaks and ligatures or without
    #[must_use]
    pub fn misquoted(&self, document: &str) -> Vec<String> {
        let document = normal(document);
        let lower = document.to_lowercase();
        let has_title = |place: &str| {
            // A section's number may be lost where a text was made of pages.
            let title = place.split_once(' ').map_or(place, |(_, title)| title);
            lower.contains(&normal(title).to_lowercase())
        };
        let own = self
            .claims
            .iter()
            .map(|claimed| (claimed.words.as_str(), claimed.place.as_str()));
        let inner = self
            .quoted
            .iter()
            .map(|[words, place]| (words.as_str(), place.as_str()));
        let mut wrong = Vec::new();
        for (words, place) in own.chain(inner) {
            if !document.contains(&normal(words)) {
                wrong.push(format!("{place}: not in the document: {words:?}"));
            }
            if !has_title(place) {
                wrong.push(format!("no section {place:?}"));
            }
        }
        for table in &self.tables {
            if !has_title(&table.place) {
                wrong.push(format!("no section {:?}", table.place));
            }
            let rows: Vec<Vec<f64>> = table
                .ordered()
                .into_iter()
                .map(|(_, row)| row.to_vec())
                .collect();
            let columns = (0..table.columns.len())
                .map(|at| rows.iter().filter_map(|row| row.get(at).copied()).collect());
            let columns: Vec<Vec<f64>> = columns.collect();
            let stand = |lists: &[Vec<f64>]| {
                lists.iter().all(|list| {
                    let figures: Vec<String> = list.iter().map(f64::to_string).collect();
                    format!(" {document} ").contains(&format!(" {} ", figures.join(" ")))
                })
            };
            if !stand(&rows) && !stand(&columns) {
                wrong.push(format!(
                    "figures of {:?} are not in the document",
                    table.name
                ));
            }
        }
        wrong
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::published::published;
    use serde::Deserialize;
    use terrafill_results::Claim;

    #[derive(Debug, Clone, PartialEq, Deserialize)]
    struct Test(String);

    impl crate::Tested for Test {
        fn expects(&self) -> Option<Claim> {
            None
        }

        fn cannot(&self) -> Option<&str> {
            Some(&self.0)
        }
    }

    const PAPER: &str = "source = 'A (2007)'\ndocument = 'a'\nremark = ''\n\
        [[table]]\nname = 'grids'\nplace = '2 Speed'\nunit = 'fps'\ncolumns = ['sent', 'fetched']\n\
        rows = { 1024 = [44, 261], 256 = [705, 1851] }\n\
        [[claim]]\nwords = 'first and fast'\nplace = '2 Speed'\nbasis = 'measured'\n\
        published = [{ table = 'grids', of = ['sent', 'fetched'] }]\ntest = 'no card'\n";

    const DOCUMENT: &str = "2 Speed\nIt is ﬁrst and\nfast. 705 1851 44 261 end";

    fn paper(text: &str) -> Result<Paper<Test>, String> {
        Paper::parse("a.toml", text).map_err(|error| error.to_string())
    }

    #[test]
    fn ratios_within_a_table_are_said_row_by_row_in_the_order_of_sizes() {
        let paper = paper(PAPER).expect("a paper");
        let said = published(&paper.tables, &paper.claims[0].published);
        let expected = "Table “grids”, fetched ÷ sent, fps, row 256: 1851 ÷ 705 = 2.63 ×; row 1024: 261 ÷ 44 = 5.93 ×";
        assert_eq!(said, [expected]);
        // Negative control: operands the other way round.
        let swapped =
            paper_of("of = ['sent', 'fetched']", "of = ['fetched', 'sent']").expect("a paper");
        assert_ne!(
            published(&swapped.tables, &swapped.claims[0].published),
            said
        );
    }

    fn paper_of(from: &str, to: &str) -> Result<Paper<Test>, String> {
        paper(&PAPER.replace(from, to))
    }

    #[test]
    fn a_table_that_is_not_there_or_not_whole_is_refused() {
        for (from, to, said) in [
            ("{ table = 'grids'", "{ table = 'balls'", "names a table"),
            (
                "of = ['sent', 'fetched']",
                "of = ['sent', 'drawn']",
                "names a table",
            ),
            ("[44, 261]", "[44]", "rows are not as long"),
        ] {
            let error = paper_of(from, to).expect_err(said);
            assert!(error.contains(said), "{error}");
        }
    }

    #[test]
    fn what_is_not_in_the_document_is_named() {
        assert_eq!(paper(PAPER).expect("a paper").misquoted(DOCUMENT), [""; 0]);
        // Figures that stand column by column are the table's too.
        let by_column = DOCUMENT.replace("705 1851 44 261", "705 44 1851 261");
        assert_eq!(
            paper(PAPER).expect("a paper").misquoted(&by_column),
            [""; 0]
        );
        // Negative controls: a letter, a title, a figure.
        for (from, to, said) in [
            ("first and fast", "first or fast", "not in the document"),
            (
                "place = '2 Speed'\nbasis",
                "place = '2 Spend'\nbasis",
                "no section",
            ),
            ("[44, 261]", "[44, 262]", "figures of"),
        ] {
            let wrong = paper_of(from, to).expect("a paper").misquoted(DOCUMENT);
            assert!(wrong.len() == 1 && wrong[0].contains(said), "{wrong:?}");
        }
    }
}
