// SPDX-License-Identifier: MIT OR Apache-2.0
//! Comparators, tolerances and their negative controls.
