// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases.

terrafill_results::conditions! {
    shared API, SIZE_PX;
}
