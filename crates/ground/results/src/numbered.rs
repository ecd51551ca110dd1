// SPDX-License-Identifier: MIT OR Apache-2.0
//! A small map from numbers, kept sorted in one piece of memory. Most metrics of most cases have one value, which
//! needs no memory of its own here; a node of a tree map takes as much room as eleven.

use smallvec::SmallVec;
use std::ops::Index;

/// Values by number, in rising order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Numbered<V>(SmallVec<[(u32, V); 1]>);

impl<V> Default for Numbered<V> {
    fn default() -> Self {
        Self(SmallVec::new())
    }
}

impl<V> Numbered<V> {
    /// The value of a number.
    #[must_use]
    pub fn get(&self, number: &u32) -> Option<&V> {
        let at = self.find(*number).ok()?;
        Some(&self.0[at].1)
    }

    /// Numbers that have a value.
    pub fn keys(&self) -> impl DoubleEndedIterator<Item = &u32> {
        self.0.iter().map(|(number, _)| number)
    }

    /// Values by rising number.
    pub fn values(&self) -> impl DoubleEndedIterator<Item = &V> {
        self.0.iter().map(|(_, value)| value)
    }

    /// Numbers with their values.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (&u32, &V)> {
        self.0.iter().map(|(number, value)| (number, value))
    }

    /// How many have a value.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether none has.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn insert(&mut self, number: u32, value: V) {
        match self.find(number) {
            Ok(at) => self.0[at].1 = value,
            Err(at) => self.0.insert(at, (number, value)),
        }
    }

    fn find(&self, number: u32) -> Result<usize, usize> {
        // Rows come by rising numbers.
        match self.0.last() {
            Some((last, _)) if *last < number => Err(self.0.len()),
            _ => self.0.binary_search_by_key(&number, |(number, _)| *number),
        }
    }
}

impl<V: Default> Numbered<V> {
    /// The value of a number, made where there is none.
    pub(crate) fn of(&mut self, number: u32) -> &mut V {
        let at = self.find(number).unwrap_or_else(|at| {
            self.0.insert(at, (number, V::default()));
            at
        });
        &mut self.0[at].1
    }
}

impl<V> Index<&u32> for Numbered<V> {
    type Output = V;

    fn index(&self, number: &u32) -> &V {
        self.get(number).expect("a number that has a value")
    }
}

impl<'a, V> IntoIterator for &'a Numbered<V> {
    type Item = (&'a u32, &'a V);
    type IntoIter = std::iter::Map<std::slice::Iter<'a, (u32, V)>, fn(&'a (u32, V)) -> Self::Item>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter().map(|(number, value)| (number, value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn it_holds_what_a_tree_map_holds_in_any_order_of_rows() {
        let mut tree = BTreeMap::new();
        let mut numbered = Numbered::default();
        for row in 0_u32..200 {
            let number = (row * 37) % 90;
            tree.insert(number, row);
            numbered.insert(number, row);
        }
        assert!(numbered.iter().eq(tree.iter()));
        assert_eq!((numbered.len(), numbered.get(&89)), (90, tree.get(&89)));
        // Negative control: a number without a value.
        assert_eq!(numbered.get(&90), None);
        *numbered.of(90) += 7;
        *numbered.of(90) += 7;
        assert_eq!(numbered[&90], 14);
    }
}
