// SPDX-License-Identifier: MIT OR Apache-2.0
//! The routes from a fragment to its texture coordinate: their errors and what they cost.
