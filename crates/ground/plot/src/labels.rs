// SPDX-License-Identifier: MIT OR Apache-2.0
//! Places for labels near their points, where nothing else stands.

use crate::canvas::TEXT_PX;

/// Distances at which a label is tried around its point, nearest first.
const RADII_PX: [f64; 4] = [13.0, 24.0, 38.0, 54.0];

/// From this distance on, a line leads from the label to its point.
pub(crate) const LEADER_FROM_PX: f64 = 20.0;

/// Room that a mark takes up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rectangle {
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
}

impl Rectangle {
    pub(crate) fn around(middle: [f64; 2], width: f64, height: f64) -> Self {
        Self {
            low: [middle[0] - width * 0.5, middle[1] - height * 0.5],
            high: [middle[0] + width * 0.5, middle[1] + height * 0.5],
        }
    }

    pub(crate) fn meets(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.low[axis] < other.high[axis] && other.low[axis] < self.high[axis])
    }

    fn holds(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.low[axis] <= other.low[axis] && other.high[axis] <= self.high[axis])
    }
}

/// The nearest place for a label's middle that is inside `room` and touches no point and no other
/// label, and its distance.
pub(crate) fn free_place(
    at: [f64; 2],
    width: f64,
    room: Rectangle,
    taken: &[Rectangle],
) -> Option<([f64; 2], f64)> {
    free_place_where(at, width, room, taken, |_, _| true)
}

/// The same among the places that `is_free` allows, of middle and distance.
pub(crate) fn free_place_where(
    at: [f64; 2],
    width: f64,
    room: Rectangle,
    taken: &[Rectangle],
    is_free: impl Fn([f64; 2], f64) -> bool,
) -> Option<([f64; 2], f64)> {
    const DIRECTIONS: [[f64; 2]; 8] = [
        [0.7, -0.7],
        [0.7, 0.7],
        [-0.7, -0.7],
        [-0.7, 0.7],
        [0.0, -1.0],
        [0.0, 1.0],
        [1.0, 0.0],
        [-1.0, 0.0],
    ];
    for radius in RADII_PX {
        for [dx, dy] in DIRECTIONS {
            let aside = width * 0.5 * (dx * 1.5).clamp(-1.0, 1.0);
            let middle = [at[0] + dx * radius + aside, at[1] + dy * radius];
            let place = Rectangle::around(middle, width, TEXT_PX);
            let is_clear = room.holds(&place) && !taken.iter().any(|other| other.meets(&place));
            if is_clear && is_free(middle, radius) {
                return Some((middle, radius));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_clear_of_points_and_of_each_other() {
        let at = [300.0, 200.0];
        let room = Rectangle::around(at, 400.0, 300.0);
        let mut taken = vec![Rectangle::around(at, 11.0, 11.0)];
        for _ in 0..9 {
            let (middle, _) = free_place(at, 40.0, room, &taken).expect("room");
            let place = Rectangle::around(middle, 40.0, TEXT_PX);
            assert!(!taken.iter().any(|other| other.meets(&place)));
            taken.push(place);
        }
        // Negative control: where everything is taken, or there is no room, there is no place.
        let full = [Rectangle::around(at, 1000.0, 1000.0)];
        assert!(free_place(at, 40.0, room, &full).is_none());
        let narrow = Rectangle::around(at, 30.0, 300.0);
        assert!(free_place(at, 40.0, narrow, &[]).is_none());
    }

    #[test]
    fn rectangles_meet_or_do_not() {
        let a = Rectangle::around([0.0, 0.0], 10.0, 4.0);
        assert!(a.meets(&Rectangle::around([9.0, 0.0], 10.0, 4.0)));
        assert!(!a.meets(&Rectangle::around([11.0, 0.0], 10.0, 4.0)));
        assert!(!a.meets(&Rectangle::around([0.0, 5.0], 10.0, 4.0)));
    }
}
