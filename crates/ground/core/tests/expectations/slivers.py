#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Areas of slivers between great ellipses, by the even-odd rule, in 50 digits.

usage: slivers.py EQUATORIAL_RADIUS_M POLAR_RADIUS_M < MULTIPOLYGON.json

For rings that do not reach the antimeridian or a pole. On every meridian of a Gauss-Legendre rule the
arcs that cross it are sorted by latitude, and every other gap between them is summed up by the zone
area of the ellipsoid. Arcs may cross and be millimetres apart over a hundred degrees: nothing is split
or triangulated. Two numbers of meridians must agree to a millionth.

The areas in `fuzz_finds.rs` that name this file were printed by it.
"""

import json
import sys

import mpmath
from mpmath import mpf

mpmath.mp.dps = 50


def zone_area(equatorial, polar):
    """Area of one radian of longitude between the equator and a latitude, by its tangent."""
    e2 = 1 - (polar / equatorial) ** 2
    e = mpmath.sqrt(e2)

    def by_tangent(tangent):
        s = tangent / mpmath.sqrt(1 + tangent * tangent)
        return polar**2 / 2 * (s / (1 - e2 * s * s) + mpmath.atanh(e * s) / e)

    return by_tangent


def arcs_of(polygons):
    arcs = []
    for rings in polygons:
        for ring in rings:
            places = [tuple(map(mpf, place)) for place in ring]
            for start, end in zip(places, places[1:] + places[:1]):
                # What runs along a meridian bounds no gap on one.
                if start[0] != end[0]:
                    arcs.append(tuple(sorted((start, end))))
    return arcs


def area(polygons, equatorial, polar, meridians):
    under = zone_area(equatorial, polar)
    arcs = arcs_of(polygons)
    longitudes = sorted({end[0] for arc in arcs for end in arc})
    widest = longitudes[-1] - longitudes[0]
    node = mpmath.sqrt(mpf(3) / 5)
    rule = [(-node, mpf(5) / 9), (mpf(0), mpf(8) / 9), (node, mpf(5) / 9)]
    total = mpf(0)
    for west, east in zip(longitudes, longitudes[1:]):
        curves = []
        for start, end in arcs:
            if start[0] <= west and east <= end[0]:
                span = mpmath.sin(mpmath.radians(end[0] - start[0]))
                tangents = [mpmath.tan(mpmath.radians(p[1])) / span for p in (start, end)]
                curves.append((start[0], end[0], *tangents))
        pieces = max(4, int((east - west) / widest * meridians))
        half = (east - west) / pieces / 2
        for piece in range(pieces):
            for at, weight in rule:
                longitude = west + half * (2 * piece + 1 + at)
                crossed = sorted(
                    from_start * mpmath.sin(mpmath.radians(last - longitude))
                    + from_end * mpmath.sin(mpmath.radians(longitude - first))
                    for first, last, from_start, from_end in curves
                )
                gaps = zip(crossed[::2], crossed[1::2])
                inside = sum(under(north) - under(south) for south, north in gaps)
                total += weight * inside * mpmath.radians(half)
    return total


def main():
    equatorial, polar = map(mpf, sys.argv[1:3])
    # As doubles, which is what a program reads of them.
    polygons = json.load(sys.stdin)["coordinates"]
    coarse, fine = (area(polygons, equatorial, polar, n) for n in (4_000, 20_000))
    if abs(fine - coarse) > fine / 1_000_000:
        sys.exit(f"{coarse} m2 and {fine} m2 differ: more meridians are needed")
    print(mpmath.nstr(fine, 12))


main()
