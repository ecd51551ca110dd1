#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Edge cases with their areas and points, computed without any code of `core`.

usage: make_expectations.py    writes expectations.json, and the tables in TESTING.md
needs: pip install mpmath geographiclib

The cases are in case_list.py, the arithmetic in exact_areas.py. What a text means is written down a
second time as its *truth*: planar rings in one frame of longitude that need no cutting and no
closing, or great circles on the sphere of surface normals. On WGS 84 away from the poles, areas are
compared with geographiclib's geodesic areas of densified rings as well.
"""

import json
import math
import random
from pathlib import Path

import mpmath
from geographiclib.geodesic import Geodesic
from mpmath import mpf

import case_list
import exact_areas as exact

HERE = Path(__file__).parent
AUTOMATIC_POINTS = 5
TOLERANCE = 1e-12
TABLE_BEGINS = "<!-- edge cases: written by make_expectations.py -->"
TABLE_ENDS = "<!-- end of edge cases -->"


def geojson(coordinates):
    kind = {3: "Polygon", 4: "MultiPolygon"}[depth_of(coordinates)]
    numbers = json.dumps(coordinates, separators=(",", ":"))
    return f'{{"type":"{kind}","coordinates":{numbers}}}'


def depth_of(coordinates):
    depth = 0
    while isinstance(coordinates, (list, tuple)):
        depth, coordinates = depth + 1, coordinates[0]
    return depth


def opened(ring):
    ring = [tuple(vertex[:2]) for vertex in ring]
    return ring[:-1] if len(ring) > 1 and ring[0] == ring[-1] else ring


def signed_rings(coordinates):
    """`(sign, ring)`: shells count, their holes count off."""
    polygons = coordinates if depth_of(coordinates) == 4 else [coordinates]
    return [
        (-1 if i else 1, opened(ring)) for polygon in polygons for i, ring in enumerate(polygon)
    ]


def distance_rad(rings, rule, point):
    """To the nearest of many points of the rings: good to the spacing of those."""
    p = [float(x) for x in exact.normal(point)]
    nearest = 10.0
    for ring in rings:
        for a, b in zip(ring, ring[1:] + ring[:1]):
            steps = 24 if len(ring) < 200 else 2
            ends = [[float(x) for x in exact.normal(v)] for v in (a, b)]
            for k in range(steps):
                t = k / steps
                if rule == "planar":
                    x, y = (math.radians(a[i] + (b[i] - a[i]) * t) for i in (0, 1))
                    q = (math.cos(y) * math.cos(x), math.cos(y) * math.sin(x), math.sin(y))
                else:
                    q = [ends[0][i] + (ends[1][i] - ends[0][i]) * t for i in range(3)]
                    length = math.hypot(*q)
                    q = [c / length for c in q]
                nearest = min(nearest, math.dist(p, q))
    return nearest


def automatic_points(name, rings, rule, holds):
    """Random places round the region, none so close to its boundary that drawing matters."""
    rng = random.Random(name)
    xs = [x for ring in rings for x, _ in ring]
    ys = [y for ring in rings for _, y in ring]
    west, east, south, north = min(xs), max(xs), min(ys), max(ys)
    if rule == "great-ellipse" and east - west > 180:
        west, east = -180, 180
    width, height = east - west, north - south
    reach = 0.15 * max(width, height)
    if rule == "great-ellipse":
        reach *= 2
    margin = math.radians(min(0.5, 0.02 * math.hypot(width, height)))
    # Short numbers where there is room for them.
    digits = max(0, 4 - math.floor(math.log10(max(width, 1e-12))))
    found = {True: [], False: []}
    for _ in range(300):
        if all(len(points) >= AUTOMATIC_POINTS for points in found.values()):
            break
        x, y = rng.uniform(west - reach, east + reach), rng.uniform(south - reach, north + reach)
        point = [round((x + 180) % 360 - 180, digits), round(y, digits)]
        if abs(point[1]) > 90 or distance_rad(rings, rule, point) < margin:
            continue
        where = found[holds(point)]
        if len(where) < AUTOMATIC_POINTS:
            where.append(point)
    return found[True], found[False]


class Cases:
    """What case_list.py calls."""

    def __init__(self):
        self.cases = []
        self.for_geographiclib = []

    def add(
        self,
        name,
        says,
        text,
        rule="planar",
        body="wgs84",
        truth=None,
        sphere_truth=None,
        area=None,
        tolerance=TOLERANCE,
        inside=(),
        outside=(),
        exact_inside=(),
        exact_outside=(),
        automatic=True,
        repair=False,
        crosses=False,
        locator="agrees",
        warnings=(),
        loops=None,
    ):
        """One accepted case.

        - `text`: GeoJSON, coordinates of it, or parameters from which the test makes the ring
        - `truth`: planar rings; `sphere_truth`: `(sign, ring)` of great circles. Without either,
          the rings of `text` by `rule`
        - `area`: where arithmetic gives it
        - `exact_inside`, `exact_outside`: too close to the boundary for a mesh, not for a locator
        - `locator`: what it says when it refuses, where it promises less than the mesh
        """
        case = {"name": name, "says": says, "body": body, "rule": rule}
        if isinstance(text, dict):
            case["shape"] = text
        else:
            case["text"] = geojson(text) if isinstance(text, list) else text
        signed = None
        if truth is None:
            signed = sphere_truth or signed_rings(text)
        if truth is not None or rule == "planar":
            seen_rule = "planar"
            rings = truth if truth is not None else [ring for _, ring in signed]
            edges = list(exact.edges_of(rings))

            def holds(point):
                return exact.planar_holds(edges, point)

            if area is None:
                area = exact.planar_area(exact.Body(body), rings, crosses)
        else:
            seen_rule = "great-ellipse"
            rings = [ring for _, ring in signed]

            def holds(point):
                return sum(exact.sphere_holds(ring, point) for ring in rings) % 2 == 1

            if area is None:
                area = sum(
                    sign * abs(exact.sphere_area(exact.Body(body), ring)) for sign, ring in signed
                )
        if body == "wgs84" and signed is not None and not crosses:
            self.for_geographiclib.append((name, seen_rule, signed, area))
        points = {
            "inside": [list(p) for p in inside],
            "outside": [list(p) for p in outside],
            "exact_inside": [list(p) for p in exact_inside],
            "exact_outside": [list(p) for p in exact_outside],
        }
        if automatic:
            more_inside, more_outside = automatic_points(name, rings, seen_rule, holds)
            points["inside"] += more_inside
            points["outside"] += more_outside
        for key, list_of_points in points.items():
            for point in list_of_points:
                assert holds(point) == key.endswith("inside"), f"{name}: {key} {point}"
        assert points["inside"] or points["exact_inside"], f"{name}: no point inside"
        case |= {
            "repair": repair,
            "area_m2": float(area),
            "relative_tolerance": tolerance,
            "locator": locator,
        }
        if warnings:
            case["warnings"] = list(warnings)
        if loops is not None:
            case["boundary_loops"] = loops
        self.cases.append(case | points)

    def both(self, name, says, coordinates, **more):
        """The same text by both rules."""
        self.add(f"{name}-planar", says, coordinates, rule="planar", **more)
        self.add(f"{name}-great-ellipse", says, coordinates, rule="great-ellipse", **more)

    def refuse(
        self, name, says, text, parts, stage="read", rule="planar", place=None, at=None, others=()
    ):
        """One refused case: what the message must say, and where it must point.

        - `place`: feature, polygon, ring, vertex, as far as they are known
        - `at`: longitude and latitude of a crossing
        - `others`: parts of further problems that must be told in the same round
        """
        if isinstance(text, list):
            text = geojson(text)
        refusal = {"stage": stage, "parts": list(parts)}
        if place is not None:
            refusal["place"] = dict(zip(("feature", "polygon", "ring", "vertex"), place))
        if at is not None:
            refusal["at"] = [float(x) for x in at]
        if others:
            refusal["others"] = [list(other) for other in others]
        case = {"name": name, "says": says, "body": "wgs84", "rule": rule, "text": text}
        self.cases.append(case | {"refusal": refusal})


# Third opinion ---------------------------------------------------------------------------------


def densified(rule, ring, steps):
    for a, b in zip(ring, ring[1:] + ring[:1]):
        p, q = exact.normal(a), exact.normal(b)
        across = exact.cross(p, q)
        angle = mpmath.atan2(mpmath.sqrt(exact.dot(across, across)), exact.dot(p, q))
        for k in range(steps):
            t = mpf(k) / steps
            if rule == "planar" or angle == 0:
                yield float(a[1] + (b[1] - a[1]) * t), float(a[0] + (b[0] - a[0]) * t)
            else:
                from_a, from_b = mpmath.sin((1 - t) * angle), mpmath.sin(t * angle)
                x, y, z = (from_a * u + from_b * v for u, v in zip(p, q))
                yield (
                    float(mpmath.atan2(z, mpmath.hypot(x, y)) / exact.DEG),
                    float(mpmath.atan2(y, x) / exact.DEG),
                )


def geodesic_area(rule, signed, steps):
    total = 0.0
    for sign, ring in signed:
        polygon = Geodesic.WGS84.Polygon()
        for latitude, longitude in densified(rule, ring, steps):
            polygon.AddPoint(latitude, longitude)
        total += sign * abs(polygon.Compute(False, True)[2])
    return total


def ask_geographiclib(areas):
    worst, asked = 0.0, 0
    for name, rule, signed, area in areas:
        vertices = [vertex for _, ring in signed for vertex in ring]
        width = max(x for x, _ in vertices) - min(x for x, _ in vertices)
        # It knows no rings round a pole, and its sums have absolute rounding of 0.1 m².
        if len(vertices) > 20 or width > 170 or area < 1e8:
            continue
        if max(abs(y) for _, y in vertices) > 85:
            continue
        coarse, fine = (geodesic_area(rule, signed, steps) for steps in (50, 100))
        richardson = fine + (fine - coarse) / 3
        error = abs(richardson / float(area) - 1)
        if error > 1e-7:
            print(f"{name}: geographiclib says {richardson}, not {float(area)}: {error:.1e}")
        worst, asked = max(worst, error), asked + 1
    print(f"geographiclib agrees on {asked} areas within {worst:.1e} relative")
    assert worst < 1e-7 and asked >= 20


# Output ----------------------------------------------------------------------------------------


def table(cases):
    accepted = [case for case in cases if "refusal" not in case]
    refused = [case for case in cases if "refusal" in case]
    lines = [
        f"Accepted: {len(accepted)}. Points are inside or outside ones.",
        "",
        "| name | what | rule | body | area, m² | points |",
        "|---|---|---|---|---|---|",
    ]
    for case in accepted:
        points = sum(len(case[key]) for key in case if key.endswith(("inside", "outside")))
        repaired = ", repaired" if case["repair"] else ""
        lines.append(
            f"| `{case['name']}` | {case['says']}{repaired} | {case['rule']} | {case['body']} "
            f"| {case['area_m2']:.9g} | {points} |"
        )
    lines += [
        "",
        f"Refused: {len(refused)}.",
        "",
        "| name | what | must say |",
        "|---|---|---|",
    ]
    for case in refused:
        parts = " … ".join(f"“{part}”" for part in case["refusal"]["parts"])
        lines.append(f"| `{case['name']}` | {case['says']} | {parts} |")
    return "\n".join(lines)


def write(cases):
    names = [case["name"] for case in cases]
    assert len(names) == len(set(names)), "names are unique"
    lines = ",\n".join(json.dumps(case) for case in cases)
    (HERE / "expectations.json").write_text('{"cases":[\n' + lines + "\n]}\n", encoding="utf-8")
    testing = HERE.parents[3] / "TESTING.md"
    before, rest = testing.read_text(encoding="utf-8").split(TABLE_BEGINS)
    _, after = rest.split(TABLE_ENDS)
    text = f"{before}{TABLE_BEGINS}\n\n{table(cases)}\n\n{TABLE_ENDS}{after}"
    testing.write_text(text, encoding="utf-8")
    print(f"{len(cases)} cases written")


if __name__ == "__main__":
    made = Cases()
    case_list.all_cases(made)
    ask_geographiclib(made.for_geographiclib)
    write(made.cases)
