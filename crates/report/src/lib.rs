// SPDX-License-Identifier: MIT OR Apache-2.0
//! CSV to statistics, plots and HTML; opens no device.
