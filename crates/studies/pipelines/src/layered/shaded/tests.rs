// SPDX-License-Identifier: MIT OR Apache-2.0
//! The shadows' scenes themselves.

use super::*;
use terrafill_shaders::struct_layout;

#[test]
fn constants_lie_as_the_shader_reads_them() {
    let layout = struct_layout("pipelines/shaded.wgsl", "Shaded").expect("a struct");
    let offset = |name: &str| layout.offset(name).expect(name);
    use std::mem::offset_of;
    assert_eq!(offset("texels"), offset_of!(ShadedConstants, texels));
    assert_eq!(offset("moments"), offset_of!(ShadedConstants, moments));
    assert_eq!(offset("least"), offset_of!(ShadedConstants, least));
    assert_eq!(offset("bias"), offset_of!(ShadedConstants, bias));
    assert_ne!(offset("shows"), offset_of!(ShadedConstants, moments));
}

#[test]
fn the_disc_hides_its_middle_and_nothing_beyond_its_rim() {
    assert!(is_under([0.5, 0.5]) && is_under([0.79, 0.5]) && is_under([0.5, 0.21]));
    assert!(!is_under([0.81, 0.5]) && !is_under([0.5, 0.19]) && !is_under([0.72, 0.72]));
    let area = (0..1_000_000).filter(|number| {
        let at = |along: u32| (f64::from(along) + 0.5) / 1_000.0;
        is_under([at(number % 1_000), at(number / 1_000)])
    });
    let expected = TAU / 2.0 * RADIUS * RADIUS;
    assert!((area.count() as f64 / 1e6 - expected).abs() < 5e-4);
}
