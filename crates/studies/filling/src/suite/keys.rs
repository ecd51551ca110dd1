// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the suite's cases, and what is measured of them.

use terrafill_results::{Kind, Metric, Scope, conditions, metrics};

conditions! {
    shared SCENE, TECHNIQUE, VIEW;
    EXPECTED = "expected", "how the case must end";
    ROLE = "role";
    SCENE_REASON = "scene-reason", "why the scene is extreme";
}

metrics! {
    SUITE_CASE_S = Metric::less(
        "suite_case_s",
        "s",
        Kind::Time,
        "Wall clock of one technique in one view of a suite, with its part of reading, meshing and the reference.",
    ).covering(Scope::PLAN.and(Scope::FRAME).and(Scope::READ_BACK));
    VALIDATION_MESSAGES = Metric::error(
        "validation_messages",
        "",
        "Messages of the Vulkan validation layer while a case was drawn and compared. Absent where the layer was off.",
    );
}
