// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sessions that judge what they draw. Judging takes longer than drawing, and processes that only time need not repeat
//! it: a hash says that a case shows what it showed when it was verified.

use crate::{Failure, Figures, Session};
use std::collections::BTreeMap;
use terrafill_results::{Status, Verdict};

/// Note of the hash of what a case showed.
const SHOWN: &str = "shown";

/// A session whose cases show something.
pub trait Shows {
    /// What a case showed.
    type Shown;

    /// Prepares a case for its timed frames, and takes what it shows.
    ///
    /// - returns: its hash as well, of everything that is judged and may differ from process to process
    ///
    /// # Errors
    /// [`Failure`], which becomes the case's verdict.
    fn show(&mut self, case: usize) -> Result<(String, Self::Shown), Failure>;

    /// Compares it with the reference.
    ///
    /// # Errors
    /// As [`Shows::show`].
    fn judge(&mut self, case: usize, shown: Self::Shown) -> Result<Verdict, Failure>;

    /// A timed frame of a case that was shown: metric names and values.
    ///
    /// # Errors
    /// [`Failure`], with which the case fails.
    fn time(&mut self, case: usize) -> Result<Figures, Failure>;
}

/// The session of a [`Shows`]. Whatever shows something else than when it was verified is judged again.
#[derive(Debug)]
pub struct JudgedOnce<S> {
    shows: S,
    /// Cases that showed what they did, and were not judged here.
    only_shown: Vec<usize>,
}

impl<S: Shows> JudgedOnce<S> {
    /// Nothing is shown yet.
    pub fn new(shows: S) -> Self {
        Self {
            shows,
            only_shown: Vec::new(),
        }
    }

    /// Judges a case after those before it: ways are held against the first way's picture, which a judge remembers.
    fn judge(&mut self, case: usize, shown: S::Shown) -> Result<Verdict, Failure> {
        for earlier in std::mem::take(&mut self.only_shown) {
            let shown = self.shows.show(earlier);
            let judged = shown.and_then(|(_, shown)| self.shows.judge(earlier, shown));
            judged.map_err(|failure| of_earlier(earlier, failure))?;
        }
        self.shows.judge(case, shown)
    }
}

/// What a case fails with that cannot be compared: its own words, and not those of the case before it alone.
fn of_earlier(earlier: usize, failure: Failure) -> Failure {
    match failure {
        Failure::Ends(error) => Failure::Ends(error),
        Failure::Unable(reason) | Failure::Broken(reason) => Failure::Broken(format!(
            "it was not judged, since case {} of its group, which it is compared with, was not: {reason}",
            earlier + 1
        )),
    }
}

impl<S: Shows> Session for JudgedOnce<S> {
    fn verify(&mut self, case: usize) -> Result<Verdict, Failure> {
        let (hash, shown) = self.shows.show(case)?;
        let mut verdict = self.judge(case, shown)?;
        verdict.notes.push((SHOWN, hash));
        Ok(verdict)
    }

    fn recheck(
        &mut self,
        case: usize,
        status: Status,
        notes: &BTreeMap<String, String>,
    ) -> Result<Verdict, Failure> {
        let (hash, shown) = self.shows.show(case)?;
        if notes.get(SHOWN) == Some(&hash) {
            self.only_shown.push(case);
            return Ok(Verdict {
                status,
                ..Verdict::default()
            });
        }
        self.judge(case, shown)
    }

    fn time(&mut self, case: usize) -> Result<Figures, Failure> {
        self.shows.time(case)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judged;

    /// Shows a number, which is right below ten where it is the first one's.
    #[derive(Default)]
    struct Number {
        shown: u32,
        judged: u32,
        first: Option<u32>,
    }

    impl Shows for Number {
        type Shown = u32;

        fn show(&mut self, _: usize) -> Result<(String, u32), Failure> {
            Ok((self.shown.to_string(), self.shown))
        }

        fn judge(&mut self, _: usize, shown: u32) -> Result<Verdict, Failure> {
            self.judged += 1;
            let first = *self.first.get_or_insert(shown);
            let is_right = shown < 10 && shown == first;
            let reason = if is_right { "" } else { "another number" };
            Ok(judged(reason.to_owned(), Vec::new(), Vec::new()))
        }

        fn time(&mut self, _: usize) -> Result<Figures, Failure> {
            Ok(Vec::new())
        }
    }

    /// The same, whose second case shows one more.
    struct Twice(Number);

    impl Shows for Twice {
        type Shown = u32;

        fn show(&mut self, case: usize) -> Result<(String, u32), Failure> {
            let (_, shown) = self.0.show(case)?;
            let shown = shown + u32::from(case == 1);
            Ok((shown.to_string(), shown))
        }

        fn judge(&mut self, case: usize, shown: u32) -> Result<Verdict, Failure> {
            self.0.judge(case, shown)
        }

        fn time(&mut self, case: usize) -> Result<Figures, Failure> {
            self.0.time(case)
        }
    }

    /// Shows its first case once.
    #[derive(Default)]
    struct Once(u32);

    impl Shows for Once {
        type Shown = ();

        fn show(&mut self, case: usize) -> Result<(String, ()), Failure> {
            self.0 += u32::from(case == 0);
            let is_gone = case == 0 && self.0 > 1;
            if is_gone {
                return Err(Failure::Unable("gone".to_owned()));
            }
            Ok(("3".to_owned(), ()))
        }

        fn judge(&mut self, _: usize, (): ()) -> Result<Verdict, Failure> {
            Ok(judged(String::new(), Vec::new(), Vec::new()))
        }

        fn time(&mut self, _: usize) -> Result<Figures, Failure> {
            Ok(Vec::new())
        }
    }

    #[test]
    fn what_shows_the_same_is_not_judged_again_and_what_does_not_is() {
        let of = |shown| Number {
            shown,
            ..Number::default()
        };
        let mut session = JudgedOnce::new(of(3));
        let verdict = session.verify(0).expect("a verdict");
        assert_eq!(verdict.notes, [(SHOWN, "3".to_owned())]);
        let notes = BTreeMap::from([(SHOWN.to_owned(), "3".to_owned())]);
        let recheck = |shown, notes| {
            let mut session = JudgedOnce::new(of(shown));
            let verdict = session.recheck(0, Status::Ok, notes).expect("a verdict");
            (verdict.status, session.shows.judged)
        };
        assert_eq!(recheck(3, &notes), (Status::Ok, 0));
        // Negative controls: other bits that are right, a wrong picture, and a run without hashes.
        assert_eq!(recheck(4, &notes), (Status::Ok, 1));
        assert_eq!(recheck(10, &notes), (Status::Wrong, 1));
        assert_eq!(recheck(3, &BTreeMap::new()), (Status::Ok, 1));
        // A case behind one that was only shown is held against that one.
        let mut session = JudgedOnce::new(Twice(of(3)));
        let earlier = session.recheck(0, Status::Ok, &notes).expect("a verdict");
        assert_eq!((earlier.status, session.shows.0.judged), (Status::Ok, 0));
        assert_eq!(session.verify(1).expect("a verdict").status, Status::Wrong);
        assert_eq!(session.shows.0.judged, 2);
        // One that breaks when it is shown again is named as what it is to a later one.
        let mut session = JudgedOnce::new(Once::default());
        assert!(session.recheck(0, Status::Ok, &notes).is_ok());
        let failure = session.verify(1).map_err(Failure::reason);
        let failure = failure.expect_err("nothing to compare it with");
        assert!(
            failure.starts_with("it was not judged, since case 1"),
            "{failure}"
        );
        assert!(failure.ends_with("gone"), "{failure}");
        // Negative control: its own failure is its own.
        assert_eq!(
            session
                .verify(0)
                .map_err(Failure::reason)
                .expect_err("again"),
            "gone"
        );
    }
}
