#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Every place where two planar edges of a feature cross, decided in exact fractions.

usage: exact_crossings.py FILE...     needs nothing but Python

Shares nothing with `core`, whose refusals it is held against. Two edges cross when each has its ends
strictly on different sides of the other; a touch is no crossing. Lists the edges by the position in
the file that they start at, and by how many metres they cross: the shortest way that one end would
have to move.
"""

import json
import math
import sys
from fractions import Fraction

RADIUS_M = 6371007.2
# An f64 determinant of degrees is surely off by less: four products below 2 * 720**2.
SURE = 1e-9


def geometries(item):
    """Areal parts of a feature's geometry."""
    kind = item["type"]
    if kind == "Polygon":
        return [item["coordinates"]]
    if kind == "MultiPolygon":
        return item["coordinates"]
    if kind == "GeometryCollection":
        return [part for member in item["geometries"] for part in geometries(member)]
    return []


def edges_of(feature):
    for p, polygon in enumerate(geometries(feature["geometry"])):
        for r, ring in enumerate(polygon):
            points = [(float(v[0]), float(v[1])) for v in ring]
            for v, (a, b) in enumerate(zip(points, points[1:] + points[:1])):
                if a != b:
                    yield (p, r, v), a, b


def side(a, b, c):
    det = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if abs(det) < SURE:
        ax, ay, bx, by, cx, cy = (Fraction(x) for x in (*a, *b, *c))
        det = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return (det > 0) - (det < 0)


def cross(a, b, c, d):
    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def place(a, b, c, d):
    ax, ay, bx, by, cx, cy, dx, dy = (Fraction(x) for x in (*a, *b, *c, *d))
    rx, ry, sx, sy = bx - ax, by - ay, dx - cx, dy - cy
    t = ((cx - ax) * sy - (cy - ay) * sx) / (rx * sy - ry * sx)
    return float(ax + t * rx), float(ay + t * ry)


def metres_to_segment(p, a, b):
    scale = math.radians(1) * RADIUS_M
    narrow = math.cos(math.radians(p[1]))
    (ax, ay), (bx, by) = (((q[0] - p[0]) * scale * narrow, (q[1] - p[1]) * scale) for q in (a, b))
    dx, dy = bx - ax, by - ay
    t = min(1.0, max(0.0, -(ax * dx + ay * dy) / (dx * dx + dy * dy)))
    return math.hypot(ax + t * dx, ay + t * dy)


def depth(a, b, c, d):
    return min(
        metres_to_segment(a, c, d),
        metres_to_segment(b, c, d),
        metres_to_segment(c, a, b),
        metres_to_segment(d, a, b),
    )


def crossings_of(feature):
    edges = sorted(edges_of(feature), key=lambda e: min(e[1][0], e[2][0]))
    active = []
    for edge in edges:
        where, a, b = edge
        west, south, north = min(a[0], b[0]), min(a[1], b[1]), max(a[1], b[1])
        active = [e for e in active if e[0] >= west]
        for _, low, high, (other, c, d) in active:
            if low <= north and south <= high and cross(a, b, c, d):
                first, second = sorted((where, other))
                yield first, second, place(a, b, c, d), depth(a, b, c, d)
        active.append((max(a[0], b[0]), south, north, edge))


def main(files):
    for name in files:
        with open(name, encoding="utf-8") as file:
            root = json.load(file)
        features = root.get("features", [root])
        found = 0
        for index, feature in enumerate(features):
            if not feature["geometry"]:
                continue
            for first, second, (x, y), metres in sorted(crossings_of(feature)):
                found += 1
                p, r, v = first
                q, s, w = second
                print(
                    f"feature {index}: polygon {p}, ring {r}, vertex {v} × "
                    f"polygon {q}, ring {s}, vertex {w} at {x:.7f} {y:.7f} by {metres:.3g} m"
                )
        print(f"{name}: {len(features)} features, {found} crossings")


if __name__ == "__main__":
    main(sys.argv[1:])
