// SPDX-License-Identifier: MIT OR Apache-2.0
//! The way of the eye: through the views of a scene, from the highest to the lowest.

use terrafill_core::Geodetic;
use terrafill_scene::{CameraPose, View};

/// Cameras of a flight of `frames` frames through `views`: places, directions and the logarithm of the height
/// change evenly between one view and the next. The eye stops at the last view for the last `rest` frames.
pub(crate) fn path(views: &[View], frames: u32, rest: u32) -> Vec<View> {
    let mut stops: Vec<CameraPose> = views.iter().map(|view| view.pose).collect();
    stops.sort_by(|a, b| b.eye.height_m.total_cmp(&a.eye.height_m));
    let legs = stops.len().saturating_sub(1).max(1);
    let moving = frames.saturating_sub(rest).max(2);
    (0..frames)
        .map(|frame| {
            let done = f64::from(frame.min(moving - 1)) / f64::from(moving - 1) * legs as f64;
            let leg = (0..legs).rev().find(|leg| *leg as f64 <= done).unwrap_or(0);
            let pose = match (stops.get(leg), stops.get(leg + 1)) {
                (Some(from), Some(to)) => between(from, to, done - leg as f64),
                _ => stops[0],
            };
            View {
                name: format!("frame {frame}"),
                pose,
                note: None,
            }
        })
        .collect()
}

fn between(from: &CameraPose, to: &CameraPose, share: f64) -> CameraPose {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    // The shorter way round.
    let turned = |a: f64, b: f64| {
        let turn = (b - a).rem_euclid(std::f64::consts::TAU);
        let turn = if turn > std::f64::consts::PI {
            turn - std::f64::consts::TAU
        } else {
            turn
        };
        a + turn * share
    };
    let ratio = |a: f64, b: f64| a * (b / a).powf(share);
    CameraPose {
        eye: Geodetic {
            longitude_rad: turned(from.eye.longitude_rad, to.eye.longitude_rad),
            latitude_rad: mix(from.eye.latitude_rad, to.eye.latitude_rad),
            height_m: ratio(from.eye.height_m, to.eye.height_m),
        },
        heading_rad: turned(from.heading_rad, to.heading_rad),
        pitch_rad: mix(from.pitch_rad, to.pitch_rad),
        fov_y_rad: mix(from.fov_y_rad, to.fov_y_rad),
        near_m: ratio(from.near_m, to.near_m),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_scene::Scene;

    #[test]
    fn a_flight_goes_from_the_highest_view_to_the_lowest_and_rests_there() {
        let scene = Scene::shipped("hills", None).expect("it ships");
        let mut views = scene.views.clone();
        let flown = path(&views, 30, 5);
        assert_eq!(flown.len(), 30);
        let heights: Vec<f64> = flown.iter().map(|view| view.pose.eye.height_m).collect();
        assert!(
            heights.windows(2).all(|pair| pair[1] <= pair[0]),
            "{heights:?}"
        );
        assert_eq!(flown[0].pose, scene.views[0].pose);
        for frame in [25, 29] {
            let found = flown[frame].pose.eye;
            let wanted = scene.views[2].pose.eye;
            assert!((found.height_m / wanted.height_m - 1.0).abs() < 1e-12);
            assert!((found.longitude_rad - wanted.longitude_rad).abs() < 1e-12);
        }
        // Negative control: before it rests it moves, whatever the order in which the scene has its views.
        assert_ne!(flown[23].pose, flown[24].pose);
        views.reverse();
        assert_eq!(path(&views, 30, 5)[7].pose, flown[7].pose);
    }
}
