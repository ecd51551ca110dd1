// SPDX-License-Identifier: MIT OR Apache-2.0
//! Runs cases and writes raw rows.
