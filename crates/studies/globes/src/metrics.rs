// SPDX-License-Identifier: MIT OR Apache-2.0
//! Conditions of the study's cases, and what it measures of them.

mod parts;
mod surfaces;

pub(crate) use parts::*;
pub(crate) use surfaces::*;
pub(crate) use terrafill_globe_views::{
    GLOBE_DRAW_CPU_MS, GLOBE_DRAW_GPU_MS, GLOBE_MAKE_CPU_MS, GLOBE_TRIANGLES, GLOBE_UPLOAD_BYTES,
    GLOBE_UPLOAD_CPU_MS, GLOBE_VERTICES, GLOBE_WHOLE_CPU_MS, GLOBE_WHOLE_GPU_MS,
};

use terrafill_globe_views as views;
use terrafill_results::Metric;
use terrafill_tiled_globe as tiled;

terrafill_results::conditions! {
    shared API, PART, SIZE_PX, VIEW;
    BUMP_SCALE = "bump_scale", "how many times as steep the bumps are as those that preprocessing makes";
    BUMPS = "bumps", "how bumps are stored: as shares of normal, tangent and binormal, or as normals of object space";
    CELLS = views::CELLS.name(), "cells a side, or vertices a turn";
    CONTROLLER = "controller", "what a rule holds: the radius of the spiral's fan, its outer radius, or both";
    COUNTED_BY = "counted_by", "how the device counts the pixels of each node: by a histogram, or by queries";
    DELAY = "delay", "frames until counts are back on the CPU";
    FAULT = "fault", "what is done wrong on purpose";
    HILL_M = "hill_m", "height of the hill, metres";
    HEIGHTS = "heights", "where heights are looked up";
    HOURS = "hours", "for which clouds have moved";
    HYSTERESIS = "hysteresis", "how many times the pixels at which a node merges it splits at; 1: at the same";
    KNOB = "knob", "what makes a surface finer";
    LATENCY_MS = tiled::LATENCY_MS.name(), "wait that is added to reading each tile, as a network might have, milliseconds";
    LAW = "law", "how vertices stand apart along a spiral";
    LEVEL = tiled::LEVEL.name(), "how a tile's level is chosen";
    LIMIT = tiled::LIMIT.name(), "error that is allowed, pixels";
    LOADING = tiled::LOADING.name(), "when tiles are read: beside frames, by frames that wait, or before the first";
    LOOKUP = "lookup", "how a texel is looked up";
    MERCATOR = tiled::MERCATOR.name(), "where latitude becomes a place in a Web Mercator map";
    PATH = views::PATH.name(), "of the camera";
    PICTURES = views::PICTURES.name(), "which pictures the globe is shaded with";
    PROJECTION = "projection", "shape that a level of detail is drawn with";
    REMOVED = "removed", "which feature of shading is left out";
    RULE = "rule", "what decides on a radius of the spiral";
    SEAM = tiled::SEAM.name(), "how the jump of longitude at ±180° is kept out of the choice of a texel";
    SPIKE_M = "spike_m", "height of the spikes, metres";
    SPLIT_BY = tiled::SPLIT_BY.name(), "by what triangles are split at the seam";
    STEP = "step", "what a rule changes a radius by in a frame: a share of the radius, or a gain over that from which its loop does not settle";
    SURFACE = "surface", "what draws the globe: a family and its knob";
    TILES = tiled::TILES.name(), "how tiles reach shaders: a draw each, an array of textures, or bindless";
    TRANSFERS = tiled::TRANSFERS.name(), "tiles that a frame may send";
    TRIG = "trig", "where sines and cosines are taken";
    VALUE = "value", "of the knob";
    VERTICES = "vertices", "where vertices come from: sent by the CPU, made by compute, from their number, or from one static buffer";
    WANTED = "wanted", "pixels that a triangle should have";
    WHAT = "what", "what is measured";
    "formula" = "a figure computed from parameters alone";
    "ellipsoid" = "triangles of meridians and parallels";
    "grid" = "one grid of heights";
    "screen-grid" = "a grid of the picture, thrown onto the globe";
    "snap" = "vertices outside the body are moved to its edge";
    "ring" = "a ring of vertices lies on the body's edge";
    "spiral" = "triangles along a spiral about the point below the eye";
    "exponential" = "steps of the spiral that grow by a factor";
    "quadratic" = "steps of the spiral that grow by a constant";
    "published" = "as the paper has it";
    "duplicated vertices" = "a vertex for each triangle that has it";
    "shared vertices" = "a vertex for all triangles that have it";
    "ray-cast" = "rays of the fragment shader meet the ellipsoid, without triangles of it";
    "by size" = "tiles by the share of their distance that a cell is wide";
    "U" = "the texture coordinate along longitude";
    "way" = "how the same is drawn";
    "trigonometry" = "where sines and cosines are taken";
    "looked up" = "how a texel is found";
    "spikes" = "thin mountains, which a level of detail may lose";
    "globe" = "the view of the whole globe";
    "zoom" = "a path towards the ground";
    "descent" = "the eye comes down from 3,000 km to 30 km";
    "turn" = "the eye moves along the ground at 40 km and turns by a quarter";
    "background" = "tiles are read by a thread beside frames, which show what has come";
    "foreground" = "tiles are read by the frames that want them, which wait";
    "all-there" = "tiles are read before the first frame";
    "any" = "all that are wanted";
    "latency" = "a wait that is added to reading each tile, as a network might have";
    "given up" = "requests for tiles that no frame wanted any more";
    "frames" = "frames until nothing changes any more";
    "rest" = "an eye that stands still";
    "rising" = "an eye whose height doubles each second of 60 frames";
    "closed form" = "from the view alone, without counts";
    "constant steps" = "the fan grows by a constant where it has too few pixels, and shrinks by it where it has too many";
    "logarithmic" = "the radius changes by a power of the wanted pixels over those counted";
    "trying" = "the outer radius shrinks by a share until pixels are bare, and then grows by it";
    "held" = "which radius the rule decides on; the other one is in closed form";
    "transfer" = "a tile that is sent to the device";
    "triangles" = "triangles of the surface";
    "feature" = "a part of shading, such as clouds or city lights";
    "window" = "pictures of so many pixels a side";
    "removed" = "parts of shading that are left out";
    "saved" = "share of a frame's time that is gone without it";
    "ratio" = "time with it over time without it";
    "tessellation" = "how fine the triangles are that stand for the surface";
    "make" = "work of the CPU that makes triangles";
    "upload" = "sending what changed to the device";
    "draw" = "work of the device for a frame";
    "found" = "as measured, beside what the formula says";
    "ours" = "of this run";
    "shown" = "the view, or the picture that it is shaded with";
    "off the texels" = "difference from the same texels, filtered and shaded in f64";
    "correlation" = "of frame times with numbers of triangles, -1 to 1";
    "µs a triangle" = "how much longer a frame takes for a triangle more, by least squares";
    "Student's 95 % interval" = "of a line's slope, by what its points leave over";
    "by processes" = "by a line in each process, with the interval over them";
    "frame with the most" = "the frame with the most triangles over that with the fewest, both on the line of a process";
}

/// Lists of what is measured, in the order in which reports have them.
const LISTS: [&[Metric]; 4] = [
    &views::METRICS,
    &surfaces::METRICS,
    tiled::METRICS,
    &parts::METRICS,
];

/// Everything that the study measures.
pub(crate) const METRICS: [Metric; count(&LISTS)] = joined(&LISTS);

const fn count(lists: &[&[Metric]]) -> usize {
    let (mut all, mut list) = (0, 0);
    while list < lists.len() {
        all += lists[list].len();
        list += 1;
    }
    all
}

/// `concat`, which constants cannot use.
const fn joined<const N: usize>(lists: &[&[Metric]]) -> [Metric; N] {
    let mut all = [*GLOBE_WHOLE_CPU_MS; N];
    let (mut at, mut list) = (0, 0);
    while list < lists.len() {
        let mut of_list = 0;
        while of_list < lists[list].len() {
            all[at] = lists[list][of_list];
            (at, of_list) = (at + 1, of_list + 1);
        }
        list += 1;
    }
    all
}
