# SPDX-License-Identifier: MIT OR Apache-2.0
"""The edge cases: what is written, and, where that is not the same, what it means."""

import json
import math
from fractions import Fraction

import exact_areas as exact


def box(west, south, east, north):
    """Closed, counter-clockwise, as files write it."""
    return [[west, south], [east, south], [east, north], [west, north], [west, south]]


def rectangle(west, south, east, north):
    """As truth: open, of tuples."""
    return [tuple(vertex) for vertex in box(west, south, east, north)[:-1]]


def parallel(latitude, *longitudes):
    return [[longitude, latitude] for longitude in longitudes]


def rounding(span, at):
    """Relative tolerance where a shape `span` degrees thin lies at a coordinate `at`, of which a
    double holds so and so many digits: that of vertices that split its edges, or of radians."""
    return 4 * math.ulp(at) / span


def polygon_text(coordinates):
    return '{"type":"Polygon","coordinates":' + json.dumps(coordinates) + "}"


def feature(geometry, name="it"):
    return '{"type":"Feature","properties":{"name":"%s"},"geometry":%s}' % (name, geometry)


def collection(*features):
    return '{"type":"FeatureCollection","features":[' + ",".join(features) + "]}"


def all_cases(make):
    poles(make)
    antimeridian(make)
    wide(make)
    small_and_thin(make)
    many_vertices(make)
    holes_and_islands(make)
    ways_of_writing(make)
    crossing(make)
    refusals_of_texts(make)
    refusals_of_shapes(make)


# Poles -----------------------------------------------------------------------------------------


def poles(make):
    north = [rectangle(0, 80, 360, 90)]
    south = [rectangle(0, -90, 360, -70)]
    make.add(
        "north-cap-uncut",
        "ring round the north pole from 0 to 360",
        [parallel(80, 0, 120, 240, 360)],
        truth=north,
        inside=[[0, 90], [77, 80.5], [180, 80.2]],
        outside=[[77, 79.5], [0, -90]],
        loops=1,
    )
    make.add(
        "north-cap-closed-at-180",
        "ring round the north pole that jumps back from 180 to −180",
        [parallel(80, -180, -90, 0, 90, 180, -180)],
        body="mars",
        truth=north,
        inside=[[0, 90], [180, 81]],
        outside=[[180, 79]],
        loops=1,
    )
    make.add(
        "north-cap-to-90",
        "ring cut at ±180 and run up to latitude 90",
        [[[-180, 80], [0, 80], [180, 80], [180, 90], [-180, 90], [-180, 80]]],
        truth=north,
        inside=[[0, 90], [180, 85]],
        outside=[[-180, 79]],
        loops=1,
    )
    make.add(
        "north-cap-as-a-rectangle",
        "four vertices: −180 to 180, latitude 80 to 90",
        [box(-180, 80, 180, 90)],
        truth=north,
        inside=[[0, 90], [180, 85]],
        outside=[[-180, 79]],
        loops=1,
    )
    make.add(
        "south-cap-as-a-rectangle",
        "four vertices: 0 to 360, latitude −90 to −70",
        [box(0, -90, 360, -70)],
        body="moon",
        truth=south,
        inside=[[0, -90], [180, -75]],
        outside=[[-180, -69]],
        loops=1,
    )
    make.add(
        "north-cap-at-540",
        "ring round the north pole from 180 to 540",
        [parallel(80, 180, 300, 420, 540)],
        body="unit-sphere",
        truth=north,
        inside=[[0, 90], [180, 81]],
        outside=[[180, 79]],
        loops=1,
    )
    make.add(
        "south-cap-westwards",
        "ring round the south pole from 0 down to −360",
        [parallel(-70, 0, -100, -200, -300, -360)],
        body="saturn-like",
        truth=south,
        inside=[[0, -90], [10, -75]],
        outside=[[10, -65], [0, 90]],
        loops=1,
    )
    coast = [(-180, -78), (-120, -73), (-60, -64), (0, -70), (60, -67), (120, -66), (180, -78)]
    make.add(
        "south-coast-to-minus-90",
        "coast cut at ±180 and run down to latitude −90, as Antarctica is",
        [[list(p) for p in coast] + [[180, -90], [-180, -90], [-180, -78]]],
        truth=[coast + [(180, -90), (-180, -90)]],
        inside=[[0, -90], [180, -80], [-60, -65]],
        outside=[[-60, -63], [180, -77]],
        loops=1,
    )
    make.add(
        "south-coast-uncut",
        "the same coast, closed by its jump alone",
        [[list(p) for p in coast] + [[-180, -78]]],
        truth=[coast + [(180, -90), (-180, -90)]],
        inside=[[0, -90], [180, -80]],
        outside=[[180, -77]],
        loops=1,
    )
    wave = [(5 * k, 60 + 10 * math.sin(math.radians(15 * k))) for k in range(72)]
    make.add(
        "north-waves",
        "ring of 72 vertices in waves round the north pole, uncut",
        [[list(p) for p in wave] + [[360, 60.0]]],
        body="asteroid-250m",
        truth=[wave + [(360, 60.0), (360, 90), (0, 90)]],
        inside=[[0, 90]],
        outside=[[0, 45]],
        loops=1,
    )
    make.add(
        "zone-of-two-rings",
        "zone between two rings round the pole, the inner one a hole",
        [parallel(60, -180, 0, 180, -180), parallel(80, -180, 0, 180, -180)],
        truth=[rectangle(-180, 60, 180, 80)],
        inside=[[0, 70]],
        outside=[[0, 90], [0, 85], [0, 55]],
        loops=2,
    )
    make.add(
        "cap-with-a-hole-beside-the-pole",
        "ring round the pole with a hole that leaves the pole out",
        [parallel(70, 0, 120, 240, 360), box(10, 75, 40, 80)],
        truth=[rectangle(0, 70, 360, 90), rectangle(10, 75, 40, 80)],
        inside=[[0, 90], [25, 82]],
        outside=[[25, 77]],
        loops=2,
    )
    make.add(
        "north-cap-of-11-metres",
        "ring round the pole at latitude 89.9999",
        [parallel(89.9999, 0, 90, 180, 270, 360)],
        truth=[rectangle(0, 89.9999, 360, 90)],
        tolerance=rounding(1e-4, 90.0),
        inside=[[0, 90], [45, 89.99995]],
        outside=[[45, 89.9998]],
        automatic=False,
        loops=1,
    )
    make.add(
        "arcs-round-the-north-pole",
        "three great ellipses round the north pole",
        [parallel(80, 0, 120, -120)],
        rule="great-ellipse",
        inside=[[0, 90], [60, 86]],
        outside=[[60, 82], [0, 79]],
        loops=1,
    )
    make.add(
        "arcs-round-the-south-pole",
        "five great ellipses round the south pole",
        [[[0, -60], [72, -65], [144, -60], [216, -65], [288, -60]]],
        rule="great-ellipse",
        body="saturn-like",
        inside=[[0, -90]],
        outside=[[36, -60]],
        loops=1,
    )
    make.add(
        "arcs-round-the-pole-11-metres",
        "eight great ellipses round the pole at latitude 89.9999",
        [parallel(89.9999, 0, 45, 90, 135, 180, -135, -90, -45)],
        rule="great-ellipse",
        tolerance=rounding(1e-4, 90.0),
        inside=[[0, 90], [22.5, 89.99995]],
        outside=[[22.5, 89.9998]],
        automatic=False,
        loops=1,
    )
    make.add(
        "edge-over-the-pole",
        "the edge from longitude 0 to 180 runs over the pole",
        [[[0, 60], [90, 60], [180, 60]]],
        rule="great-ellipse",
        inside=[[90, 80], [45, 70]],
        outside=[[-90, 80], [90, 59]],
        loops=1,
    )
    make.add(
        "edge-over-the-pole-slanted-ends",
        "the edge over the pole joins latitudes −40 and −70",
        [[[20, -40], [110, -50], [200, -70]]],
        rule="great-ellipse",
        body="mars",
        inside=[[110, -80]],
        outside=[[-70, -80]],
        loops=1,
    )
    make.add(
        "vertex-at-the-pole-arcs",
        "one vertex at the pole, written at a longitude of its own",
        [[[0, 60], [60, 60], [-33, 90]]],
        rule="great-ellipse",
        inside=[[30, 80]],
        outside=[[-33, 85], [90, 80]],
        loops=1,
    )
    make.add(
        "vertex-at-the-pole-meridians",
        "wedge between two meridians, the pole written twice",
        [[[0, 60], [60, 60], [60, 90], [0, 90], [0, 60]]],
        inside=[[30, 80], [30, 89.9]],
        outside=[[90, 89.9], [30, 59]],
        loops=1,
    )
    make.add(
        "vertex-at-the-pole-planar",
        "planar triangle with one vertex at (30, 90)",
        [[[0, 60], [60, 60], [30, 90]]],
        inside=[[30, 80], [30, 89.9]],
        outside=[[1, 80], [59, 80]],
        loops=1,
    )
    lune = [[10, -90], [10, 0], [10, 90], [40, 90], [40, 0], [40, -90]]
    for rule in ("planar", "great-ellipse"):
        make.add(
            f"lune-{rule}",
            "from pole to pole between two meridians",
            [lune],
            rule=rule,
            truth=[rectangle(10, -90, 40, 90)],
            inside=[[25, 0], [25, 89], [25, -89]],
            outside=[[9, 0], [41, 0], [-155, 89]],
            loops=1,
        )
    make.add(
        "wedge-pair-at-the-pole",
        "two opposite wedges that touch at the pole only",
        [[box(0, 80, 30, 90)], [box(180, 80, 210, 90)]],
        truth=[rectangle(0, 80, 30, 90), rectangle(180, 80, 210, 90)],
        inside=[[15, 85], [195, 85], [-165, 85]],
        outside=[[105, 89], [15, 79]],
    )


# Antimeridian ----------------------------------------------------------------------------------


def antimeridian(make):
    uncut = [[170, 10], [190, 12], [188, 30], [172, 28]]
    truth = [[tuple(p) for p in uncut]]
    points = dict(
        inside=[[180, 20], [-180, 20], [175, 20], [-175, 20]],
        outside=[[180, 5], [168, 20], [-168, 20], [0, 20]],
        loops=1,
    )
    make.add("antimeridian-past-180", "written from 170 to 190", [uncut], **points)
    west = [[x - 360, y] for x, y in uncut]
    make.add(
        "antimeridian-past-minus-180", "the same, written from −190 to −170", [west], **points
    )
    # The southern and northern edges pass longitude 180 at 11 and 29.
    cut = [
        [[[170, 10], [180, 11], [180, 29], [172, 28]]],
        [[[-180, 11], [-170, 12], [-172, 30], [-180, 29]]],
    ]
    make.add(
        "antimeridian-cut-in-two",
        "the same, cut into two polygons as RFC 7946 asks",
        cut,
        truth=truth,
        **points,
    )
    other = [
        [[[170, 10], [180, 11], [180, 15], [180, 22.3], [180, 29], [172, 28]]],
        [[[-180, 11], [-170, 12], [-172, 30], [-180, 29], [-180, 17]]],
    ]
    make.add(
        "antimeridian-unlike-vertices",
        "the same, with other vertices on either side of the cut",
        other,
        truth=truth,
        **points,
    )
    make.add(
        "antimeridian-arcs",
        "170 to 190 by great ellipses",
        [uncut],
        rule="great-ellipse",
        **points,
    )
    jump = [[170, 10], [-170, 12], [-172, 30], [172, 28]]
    make.add(
        "antimeridian-short-way-arcs",
        "written from 170 to −170: great ellipses take the short way",
        [jump],
        rule="great-ellipse",
        **points,
    )
    make.add(
        "antimeridian-long-way-planar",
        "the same numbers by the planar rule: the long way round",
        [jump],
        inside=[[0, 20]],
        outside=[[180, 20], [-175, 20], [175, 20]],
        warnings=["2 edges span more than 180°"],
        loops=1,
    )
    for side, spelled in ((180, "180"), (-180, "−180")):
        inner = 170 if side > 0 else -170
        make.add(
            f"edge-along-{'plus' if side > 0 else 'minus'}-180",
            f"an edge along the antimeridian, written {spelled}",
            [box(min(side, inner), 0, max(side, inner), 10)],
            inside=[[inner + math.copysign(5, inner), 5]],
            outside=[[-(inner + math.copysign(5, inner)), 5]],
            loops=1,
        )
    make.add(
        "edge-along-180-arcs",
        "an edge along the antimeridian by great ellipses",
        [[[170, -20], [180, -20], [180, 20], [170, 20]]],
        rule="great-ellipse",
        inside=[[175, 0]],
        outside=[[-175, 0]],
        loops=1,
    )
    make.add(
        "edges-along-both-sides",
        "neighbours that share the antimeridian become one region",
        [[box(170, 0, 180, 10)], [box(-180, 0, -170, 10)]],
        truth=[rectangle(170, 0, 190, 10)],
        inside=[[180, 5], [175, 5], [-175, 5]],
        outside=[[180, 11], [-169, 5]],
        loops=1,
    )
    make.add(
        "edges-along-part-of-both-sides",
        "neighbours that share only a part of the antimeridian",
        [[box(170, 0, 180, 10)], [box(-180, 5, -170, 15)]],
        truth=[rectangle(170, 0, 180, 10), rectangle(180, 5, 190, 15)],
        inside=[[175, 5], [-175, 10]],
        outside=[[-175, 2], [175, 12]],
        loops=1,
    )
    make.add(
        "vertex-on-the-antimeridian",
        "a triangle that touches the antimeridian with one vertex",
        [[[170, 0], [180, 5], [170, 10]]],
        inside=[[175, 5], [179, 5]],
        outside=[[-179, 5], [179, 7]],
        loops=1,
    )
    make.add(
        "zigzag-over-the-antimeridian",
        "a ring that passes the antimeridian six times",
        [[[170, 0], [190, 2], [170, 4], [190, 6], [170, 8], [190, 10], [195, 20], [165, 20]]],
        automatic=True,
        loops=1,
    )
    make.add(
        "hole-over-the-antimeridian",
        "hole and shell both over the antimeridian",
        [box(160, -20, 200, 20), box(175, -5, 185, 5)],
        inside=[[170, 0], [-170, 0], [180, 10]],
        outside=[[180, 0], [-178, 2]],
        loops=2,
    )
    make.add(
        "hole-one-turn-away",
        "the shell written past 180, its hole past −180",
        [box(160, -20, 200, 20), box(-185, -5, -175, 5)],
        truth=[rectangle(160, -20, 200, 20), rectangle(175, -5, 185, 5)],
        inside=[[170, 0], [-170, 0]],
        outside=[[180, 0], [-178, 2]],
        loops=2,
    )
    make.add(
        "hole-that-touches-the-antimeridian",
        "a hole with an edge along the antimeridian inside a shell over it",
        [box(160, -20, 200, 20), box(170, -5, 180, 5)],
        inside=[[-175, 0], [165, 0]],
        outside=[[175, 0]],
        loops=2,
    )
    make.add(
        "far-west",
        "longitudes from −540 to −530",
        [box(-540, 40, -530, 50)],
        truth=[rectangle(180, 40, 190, 50)],
        inside=[[-175, 45]],
        outside=[[175, 45]],
        loops=1,
    )
    make.add(
        "far-east",
        "longitudes from 530 to 540",
        [box(530, 40, 540, 50)],
        body="moon",
        truth=[rectangle(170, 40, 180, 50)],
        inside=[[175, 45]],
        outside=[[-175, 45]],
        loops=1,
    )
    make.add(
        "far-east-arcs",
        "longitudes from 535 to 540 by great ellipses",
        [[[535, 40], [540, 40], [540, 50], [535, 50]]],
        rule="great-ellipse",
        inside=[[177, 45]],
        outside=[[-177, 45]],
        loops=1,
    )


# Wide ------------------------------------------------------------------------------------------


def wide(make):
    make.add(
        "band-of-359-degrees",
        "a band 359° wide",
        [box(0.5, -10, 359.5, 10)],
        inside=[[180, 0], [1, 0], [-1, 0]],
        outside=[[0, 0], [0.25, 5], [90, 11]],
        warnings=["2 edges span more than 180°"],
        loops=1,
    )
    make.add(
        "band-of-359-degrees-from-minus-179.5",
        "a band 359° wide that leaves the antimeridian out",
        [box(-179.5, -10, 179.5, 10)],
        inside=[[0, 0], [179, 0], [-179, 0]],
        outside=[[180, 0], [-179.75, 5]],
        loops=1,
    )
    for west in (-180, 0):
        make.add(
            f"band-of-360-degrees-from-{'minus-180' if west else '0'}",
            f"a band all the way round from {'−180' if west else '0'}",
            [box(west, -10, west + 360, 10)],
            inside=[[0, 0], [180, 0], [-90, 5]],
            outside=[[0, 11], [180, -11]],
            loops=2,
        )
    for body in ("wgs84", "saturn-like", "unit-sphere"):
        make.add(
            f"whole-globe-{body}",
            "the whole globe as one rectangle",
            [box(-180, -90, 180, 90)],
            body=body,
            area=exact.Body(body).whole(),
            inside=[[0, 90], [0, -90], [180, 0], [12, 34]],
            automatic=False,
            loops=0,
        )
    make.add(
        "globe-without-a-box",
        "the whole globe with a hole over the antimeridian",
        [box(-180, -90, 180, 90), box(170, -10, 190, 10)],
        truth=[rectangle(0, -90, 360, 90), rectangle(170, -10, 190, 10)],
        inside=[[0, 90], [0, -90], [0, 0]],
        outside=[[180, 0], [-175, 5]],
        loops=1,
    )
    make.add(
        "all-but-a-cap",
        "everything south of latitude 80",
        [box(-180, -90, 180, 80)],
        body="mars",
        inside=[[0, -90], [180, 79], [0, 0]],
        outside=[[0, 90], [33, 81]],
        loops=1,
    )
    make.add(
        "northern-hemisphere-planar",
        "the northern hemisphere as a rectangle",
        [box(-180, 0, 180, 90)],
        inside=[[0, 90], [180, 1], [20, 1]],
        outside=[[0, -90], [180, -1], [20, -1]],
        loops=1,
    )
    make.add(
        "northern-hemisphere-arcs",
        "the equator in four arcs: its mean latitude 0 means north",
        [parallel(0, 0, 90, 180, -90)],
        rule="great-ellipse",
        truth=[rectangle(-180, 0, 180, 90)],
        inside=[[0, 90], [180, 1], [20, 1]],
        outside=[[0, -90], [180, -1], [20, -1]],
        loops=1,
    )
    make.add(
        "eastern-hemisphere",
        "half the globe between two meridians",
        [box(0, -90, 180, 90)],
        inside=[[90, 0], [1, 0], [179, 0]],
        outside=[[-90, 0], [-1, 0], [-179, 0]],
        loops=1,
    )
    around = []
    for k in range(8):
        # 80° from (40, 0) in the direction 45° k.
        c, s = math.cos(math.radians(80)), math.sin(math.radians(80))
        east, north = s * math.cos(math.radians(45 * k)), s * math.sin(math.radians(45 * k))
        around.append(
            [
                round(40 + math.degrees(math.atan2(east, c)), 6),
                round(math.degrees(math.asin(north)), 6),
            ]
        )
    make.add(
        "most-of-a-hemisphere-arcs",
        "eight arcs 80° round a place on the equator",
        [around],
        rule="great-ellipse",
        body="saturn-like",
        inside=[[40, 0], [40, 75], [110, 0]],
        outside=[[-140, 0], [-50, 0.5], [0, 90]],
        loops=1,
    )
    make.both(
        "edge-of-170-degrees",
        "a triangle with an edge that spans 170° of longitude",
        [[[-85, 10], [85, 20], [0, 75]]],
        inside=[],
        outside=[[0, -20]],
    )
    make.both(
        "edges-of-60-degrees",
        "a triangle with edges that span 60°",
        [[[0, 0], [60, 10], [20, 55]]],
        inside=[[25, 20]],
        outside=[[80, 40]],
    )
    make.add(
        "triangle-of-90-degrees",
        "an octant: a quarter of the equator and two meridians",
        [[[0, 0], [90, 0], [0, 90]]],
        rule="great-ellipse",
        area=exact.Body("wgs84").whole() / 8,
        inside=[[45, 45]],
        outside=[[-45, 45], [45, -1]],
        loops=1,
    )


# Small and thin --------------------------------------------------------------------------------


def small_and_thin(make):
    # 1 m is 9e-6° of latitude and, at 45°, 12.7e-6° of longitude.
    metre = box(10, 45, 10.0000127, 45.000009)
    for rule in ("planar", "great-ellipse"):
        make.add(
            f"one-metre-{rule}",
            "a square of 1 m at latitude 45",
            [metre],
            rule=rule,
            tolerance=rounding(9e-6, 45.0),
            inside=[[10.000006, 45.000004], [10.0000005, 45.0000005]],
            outside=[[9.9999995, 45.000004], [10.000006, 45.0000095]],
            loops=1,
        )
    make.add(
        "one-metre-on-the-antimeridian",
        "a square of 1 m over the antimeridian",
        [box(179.9999955, -0.0000045, 180.0000045, 0.0000045)],
        tolerance=rounding(9e-6, 180.0),
        inside=[[180, 0], [-179.999997, 0.000003]],
        outside=[[-179.999995, 0], [180, 0.000005]],
        loops=1,
    )
    make.add(
        "one-metre-at-the-pole",
        "a square of 1 m with the pole in its middle, by great ellipses",
        [parallel(89.9999937, 0, 90, 180, -90)],
        rule="great-ellipse",
        tolerance=rounding(6.3e-6, 90.0),
        inside=[[0, 90]],
        outside=[[45, 89.99999]],
        automatic=False,
        loops=1,
    )
    make.add(
        "one-millimetre",
        "a square of 1 mm",
        [box(10, 45, 10.0000000127, 45.000000009)],
        tolerance=rounding(9e-9, 45.0),
        inside=[[10.000000006, 45.000000004]],
        outside=[[10.000000013, 45.000000004]],
        automatic=False,
        loops=1,
    )
    make.add(
        "box-on-an-asteroid",
        "a square of 1 m on a body of 250 m",
        [box(-70, 30, -69.7, 30.25)],
        body="asteroid-250m",
        loops=1,
    )
    make.add(
        "sliver-between-meridians",
        "1e-9° wide, 10° high",
        [box(10, 40, 10.000000001, 50)],
        tolerance=rounding(1e-9, 10.0),
        inside=[[10.0000000005, 45], [10.0000000002, 41]],
        outside=[[10.0000000012, 45], [9.9999999998, 45]],
        automatic=False,
        loops=1,
    )
    make.add(
        "sliver-along-the-equator",
        "1e-9° high, 10° wide",
        [box(10, 0, 20, 0.000000001)],
        inside=[[15, 0.0000000005], [11, 0.0000000002]],
        outside=[[15, 0.0000000012], [15, -0.0000000002]],
        automatic=False,
        loops=1,
    )
    make.add(
        "sliver-along-a-parallel",
        "1e-9° high at latitude 45, 10° wide: thinner than its boundary can be drawn",
        [box(10, 45, 20, 45.000000001)],
        tolerance=rounding(1e-9, 45.0),
        exact_inside=[[15, 45.0000000005]],
        exact_outside=[[15, 45.0000000012], [15, 44.9999999998]],
        automatic=False,
    )
    make.add(
        "needle-along-a-meridian",
        "a triangle 10° long with a base of 1e-8°",
        [[[20, 40], [20.00000001, 40], [20.000000005, 50]]],
        tolerance=rounding(1e-8, 20.0),
        inside=[[20.000000005, 42]],
        outside=[[20.000000005, 51], [20.00000001, 42]],
        automatic=False,
        loops=1,
    )
    make.add(
        "needle-of-aspect-a-billion",
        "a slanted triangle 10° long and 1e-8° high",
        [[[0, 45], [10, 45.00000001], [0, 45.00000001]]],
        tolerance=rounding(1e-8, 45.0),
        exact_inside=[[1, 45.000000005]],
        exact_outside=[[9, 45.000000005]],
        automatic=False,
    )
    make.add(
        "spike-without-width",
        "a ring that goes out to (6, 2) and back the same way",
        [[[0, 0], [4, 0], [4, 2], [6, 2], [4, 2], [4, 4], [0, 4], [0, 0]]],
        inside=[[2, 2]],
        outside=[[5, 2], [5, 1.9]],
        loops=1,
    )
    make.add(
        "slit-without-width",
        "a ring that goes in to (2, 2) and back the same way",
        [[[0, 0], [4, 0], [4, 2], [2, 2], [4, 2], [4, 4], [0, 4], [0, 0]]],
        inside=[[3, 1.9], [3, 2.1], [1, 2]],
        outside=[[5, 2]],
        loops=1,
    )


# Many vertices ---------------------------------------------------------------------------------


def circle(longitude, latitude, radius, vertices, inner=1.0):
    """Every second vertex at `inner` of the radius."""
    ring = []
    for k in range(vertices):
        angle = 2.0 * math.pi * k / vertices
        r = radius * (inner if k % 2 else 1.0)
        ring.append((longitude + r * math.cos(angle), latitude + r * math.sin(angle)))
    return ring


def comb(west, south, teeth, pitch, height):
    """Teeth half a pitch wide, pointing north from a back 1° high."""
    ring = [(west, south), (west + teeth * pitch, south)]
    for i in reversed(range(teeth)):
        x = west + i * pitch
        ring += [
            (x + pitch, south + 1.0),
            (x + pitch / 2.0, south + 1.0),
            (x + pitch / 2.0, south + 1.0 + height),
            (x, south + 1.0 + height),
        ]
    return ring


def minkowski(west, south, level, step):
    """Quadratic Koch island: each side replaced by 8, `level` times; as large as its square."""
    turns = [1, 1, 1, 1]
    for _ in range(level):
        # Before each of the eight pieces: keep the old turn, then left, right, right, on, ...
        turns = [t for old in turns for t in (old, 1, -1, -1, 0, 1, 1, -1)]
    x, y, dx, dy = 0, 0, 0, -1
    ring = []
    for turn in turns:
        ring.append((west + x * step, south + y * step))
        if turn == 1:
            dx, dy = -dy, dx
        elif turn == -1:
            dx, dy = dy, -dx
        x, y = x + dx, y + dy
    assert (x, y) == (0, 0)
    return ring


def spiral(longitude, latitude, legs, step):
    """A corridor half a step wide along a square spiral of `legs` legs."""
    x, y, dx, dy = 0, 0, 1, 0
    right, left = [(0.0, -0.25)], [(0.0, 0.25)]
    for leg in range(legs):
        length = leg // 2 + 1
        x, y = x + dx * length, y + dy * length
        if leg + 1 < legs:
            out_x, out_y = -dy, dx
            side_x, side_y = 0.25 * (out_x - dx), 0.25 * (out_y - dy)
            right.append((x - side_x, y - side_y))
            left.append((x + side_x, y + side_y))
            dx, dy = out_x, out_y
        else:
            right.append((x + 0.25 * dy, y - 0.25 * dx))
            left.append((x - 0.25 * dy, y + 0.25 * dx))
    return [(longitude + px * step, latitude + py * step) for px, py in right + left[::-1]]


def cells(ring, step, every):
    """Middles of some of the lattice cells around a lattice ring, as (inside, outside)."""
    edges = list(exact.edges_of([ring]))
    west, east = min(x for x, _ in ring), max(x for x, _ in ring)
    south, north = min(y for _, y in ring), max(y for _, y in ring)
    columns, rows = round((east - west) / step), round((north - south) / step)
    found = ([], [])
    for cell in range(0, columns * rows, every):
        point = [
            west + (cell % columns + 0.5) * step,
            south + (cell // columns + 0.5) * step,
        ]
        where = found[0 if exact.planar_holds(edges, point) else 1]
        if len(where) < 8:
            where.append(point)
    return dict(inside=found[0], outside=found[1])


def many_vertices(make):
    ring = circle(20.0, 0.0, 5.0, 100_000)
    make.add(
        "circle-of-100000-vertices",
        "100,000 vertices on a circle in the plane of degrees",
        {"kind": "circle", "longitude": 20, "latitude": 0, "radius": 5, "vertices": 100_000},
        truth=[ring],
        area=exact.simple_ring_area(exact.Body("wgs84"), ring),
        inside=[[20, 0], [24.99, 0], [23.5, 3.5]],
        outside=[[25.01, 0], [23.6, 3.6]],
        automatic=False,
        loops=1,
    )
    # A regular polygon of great circles round the pole, by Girard: each of its triangles has
    # tan(E/2) = t² sin γ / (1 + t² cos γ), t = tan(c/2).
    vertices, radius = 100_000, 10 * exact.DEG
    gamma, t = 2 * exact.mpmath.pi / vertices, exact.mpmath.tan(radius / 2)
    excess = 2 * exact.mpmath.atan2(
        t * t * exact.mpmath.sin(gamma), 1 + t * t * exact.mpmath.cos(gamma)
    )
    make.add(
        "cap-of-100000-arcs",
        "100,000 great circles round the pole of the unit sphere at latitude 80",
        {"kind": "parallel", "latitude": 80, "vertices": vertices},
        rule="great-ellipse",
        body="unit-sphere",
        truth=[rectangle(0, 80, 360, 90)],
        area=vertices * excess,
        inside=[[0, 90], [33, 80.01]],
        outside=[[33, 79.99]],
        automatic=False,
        loops=1,
    )
    ring = circle(-100.0, 40.0, 8.0, 2_000, inner=0.25)
    make.add(
        "star-of-1000-spikes",
        "1,000 spikes, each 6° long",
        {
            "kind": "circle",
            "longitude": -100,
            "latitude": 40,
            "radius": 8,
            "vertices": 2_000,
            "inner": 0.25,
        },
        truth=[ring],
        area=exact.simple_ring_area(exact.Body("wgs84"), ring),
        inside=[[-100, 40], [-98.5, 41]],
        outside=[[-100, 48.5], [-91, 40]],
        exact_inside=[[-92.5, 40], [-100, 47.5]],
        exact_outside=[[-100 + 7 * math.cos(0.00314159), 40 + 7 * math.sin(0.00314159)]],
        automatic=False,
        loops=1,
    )
    for level, body in ((3, "moon"), (4, "wgs84")):
        step = 1 / 32
        ring = minkowski(5.0, 3.0, level, step)
        make.add(
            f"fractal-coast-of-{len(ring)}",
            f"quadratic Koch island, {level} times refined: {len(ring)} vertices",
            {"kind": "minkowski", "west": 5, "south": 3, "level": level, "step": step},
            body=body,
            truth=[ring],
            automatic=False,
            loops=1,
            **cells(ring, step, 977),
        )
    ring = comb(5.0, -4.0, 1_000, 1 / 64, 8.0)
    make.add(
        "comb-of-1000-teeth",
        "teeth 0.9 km wide and 890 km long",
        {"kind": "comb", "west": 5, "south": -4, "teeth": 1000, "pitch": 1 / 64, "height": 8},
        truth=[ring],
        inside=[[5 + 1 / 256, 0], [5 + 500 / 64 + 1 / 256, 4.5], [12, -3.5]],
        outside=[[5 + 3 / 256, 0], [5 + 500 / 64 + 3 / 256, 4.5], [4.9, 0]],
        automatic=False,
        loops=1,
    )
    ring = spiral(15.0, 0.0, 80, 1 / 8)
    make.add(
        "spiral-of-80-legs",
        "a corridor of 7 km along a square spiral",
        {"kind": "spiral", "longitude": 15, "latitude": 0, "legs": 80, "step": 1 / 8},
        truth=[ring],
        inside=[[15, 0.0], [15 + 1 / 8, 1 / 16], [15 - 1 / 8, 0], [15, 1 / 8]],
        outside=[[15 + 1 / 16, 1 / 16], [15 - 1 / 16, 0], [15 + 3 / 16, 0]],
        automatic=False,
        loops=1,
    )


# Holes and islands -----------------------------------------------------------------------------


def holes_and_islands(make):
    shell = box(0, 0, 4, 4)
    make.both(
        "hole",
        "a square with a square hole",
        [box(0, 0, 10, 10), box(3, 3, 7, 7)],
        inside=[[1, 1]],
        outside=[[5, 5]],
        loops=2,
    )
    make.add(
        "clockwise-shell-and-hole",
        "both rings clockwise",
        [box(0, 0, 10, 10)[::-1], box(3, 3, 7, 7)[::-1]],
        inside=[[1, 1]],
        outside=[[5, 5]],
        loops=2,
    )
    make.add(
        "hole-touches-shell-at-vertices",
        "a vertex of the hole is a vertex of the shell",
        [shell, [[0, 0], [2, 1], [1, 2], [0, 0]]],
        inside=[[3, 3], [1, 0.1]],
        outside=[[1, 1]],
    )
    make.add(
        "hole-touches-shell-mid-edge",
        "a vertex of the hole lies on an edge of the shell",
        [shell, [[2, 0], [3, 1], [1, 1], [2, 0]]],
        inside=[[3, 3], [2, 2]],
        outside=[[2, 0.7]],
    )
    make.add(
        "hole-cuts-shell-in-two",
        "the hole touches two sides of the shell and parts it",
        [shell, [[2, 0], [3, 2], [2, 4], [1, 2], [2, 0]]],
        inside=[[0.5, 2], [3.5, 2]],
        outside=[[2, 2]],
    )
    make.add(
        "shell-vertex-on-hole-edge",
        "a vertex of the shell lies on an edge of the hole",
        [[[0, 0], [4, 0], [4, 4], [0, 4], [1, 2], [0, 0]], [[1, 1], [2, 2], [1, 3], [1, 1]]],
        inside=[[3, 2], [0.5, 0.5]],
        outside=[[1.5, 2]],
    )
    make.add(
        "holes-touch-at-a-vertex",
        "two holes with a common vertex",
        [box(0, 0, 6, 4), box(1, 1, 3, 3), [[3, 3], [5, 2], [5, 3.5], [3, 3]]],
        inside=[[0.5, 0.5], [4, 1]],
        outside=[[2, 2], [4.5, 3]],
    )
    make.add(
        "holes-share-an-edge",
        "two holes with a common edge are one",
        [box(0, 0, 6, 4), box(1, 1, 3, 3), box(3, 1, 5, 3)],
        inside=[[0.5, 0.5]],
        outside=[[2, 2], [4, 2], [3, 2]],
        loops=2,
    )
    make.add(
        "hole-shares-an-edge-with-the-shell",
        "the hole's edge lies in the shell's",
        [shell, box(1, 0, 3, 2)],
        inside=[[0.5, 1], [2, 3]],
        outside=[[2, 1], [2, 0.1]],
        loops=1,
    )
    make.add(
        "islands-in-lakes-in-islands",
        "five rings in one another, three polygons",
        [
            [box(0, 0, 10, 10), box(1, 1, 9, 9)],
            [box(2, 2, 8, 8), box(3, 3, 7, 7)],
            [box(4, 4, 6, 6)],
        ],
        inside=[[0.5, 5], [2.5, 5], [5, 5]],
        outside=[[1.5, 5], [3.5, 5]],
        loops=5,
    )
    make.add(
        "island-in-the-same-polygon",
        "an island written as a third ring of one polygon",
        [box(0, 0, 10, 10), box(2, 2, 8, 8), box(4, 4, 6, 6)],
        truth=[rectangle(0, 0, 10, 10), rectangle(2, 2, 8, 8), rectangle(4, 4, 6, 6)],
        inside=[[1, 5], [5, 5]],
        outside=[[3, 5]],
        loops=3,
    )
    make.add(
        "polygons-share-an-edge",
        "two polygons of one region side by side",
        [[box(0, 0, 2, 2)], [box(2, 0, 4, 2)]],
        inside=[[2, 1], [1, 1], [3, 1]],
        outside=[[2, 3]],
        loops=1,
    )
    make.add(
        "polygons-touch-at-a-corner",
        "two polygons of one region corner to corner",
        [[box(0, 0, 2, 2)], [box(2, 2, 4, 4)]],
        inside=[[1, 1], [3, 3]],
        outside=[[3, 1], [1, 3]],
    )
    make.add(
        "hundred-holes",
        "a square with 100 holes",
        [box(0, 0, 20, 20)]
        + [box(2 * i + 0.5, 2 * j + 0.5, 2 * i + 1.5, 2 * j + 1.5) for i in range(10) for j in range(10)],
        inside=[[0.25, 1], [10, 10]],
        outside=[[1, 1], [11, 7]],
        automatic=False,
        loops=101,
    )


# Ways of writing -------------------------------------------------------------------------------


def ways_of_writing(make):
    plain = box(0, 0, 4, 4)
    hole = box(1, 1, 2, 2)
    truth = [rectangle(0, 0, 4, 4)]
    points = dict(inside=[[3, 3]], outside=[[5, 5]], loops=1, truth=truth)
    with_hole = dict(
        inside=[[3, 3]], outside=[[1.5, 1.5]], loops=2, truth=[*truth, rectangle(1, 1, 2, 2)]
    )
    heights = [[x, y, 1000.5 * i, 7] for i, (x, y) in enumerate(plain)]
    make.add("three-dimensions", "heights and a fourth number", polygon_text([heights]), **points)
    make.add(
        "byte-order-mark", "a byte order mark before the text", "\ufeff" + polygon_text([plain]), **points
    )
    make.add(
        "crlf",
        "lines that end in carriage return and line feed",
        json.dumps({"type": "Polygon", "coordinates": [plain]}, indent=1).replace("\n", "\r\n"),
        **points,
    )
    member = '{"type":"Point","coordinates":[9,9]}'
    make.add(
        "geometry-collection",
        "a collection of a point, a line and a polygon",
        feature(
            '{"type":"GeometryCollection","geometries":[%s,'
            '{"type":"LineString","coordinates":[[7,7],[8,8]]},%s]}' % (member, polygon_text([plain]))
        ),
        warnings=["2 geometries without area were left out"],
        **points,
    )
    make.add(
        "geometry-collection-nested",
        "a collection in a collection",
        '{"type":"GeometryCollection","geometries":[{"type":"GeometryCollection","geometries":[%s]}]}'
        % polygon_text([plain, hole]),
        **with_hole,
    )
    make.add(
        "feature-with-its-type-last",
        "members in the order that no writer uses",
        '{"geometry":{"coordinates":%s,"type":"Polygon"},"bbox":[0,0,4,4],"properties":null,'
        '"type":"Feature"}' % json.dumps([plain]),
        **points,
    )
    make.add(
        "feature-collection",
        "a feature in a collection, with foreign members",
        '{"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"CRS84"}},"features":[%s]}'
        % feature(polygon_text([plain, hole])),
        **with_hole,
    )
    make.add(
        "numbers-with-exponents",
        "4e0, 40E-1, -0.0 and 0.4e+1",
        '{"type":"Polygon","coordinates":[[[0,-0.0],[4e0,0],[40E-1,0.4e+1],[-0e3,4.000],[0,0]]]}',
        **points,
    )
    make.add(
        "not-closed",
        "the first vertex is not repeated",
        [plain[:-1], hole[:-1]],
        warnings=["2 rings were not closed"],
        **with_hole,
    )
    repeated = [[0, 0], [0, 0], [4, 0], [4, 0], [4, 0], [4, 4], [0, 4], [0, 0], [0, 0]]
    make.add(
        "repeated-vertices",
        "vertices written two and three times",
        [repeated],
        warnings=["repeated position"],
        **points,
    )
    collinear = [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [4, 1], [4, 4], [2, 4], [0, 4], [0, 2]]
    make.add("collinear-vertices", "vertices along straight edges", [collinear], **points)
    back_and_forth = [[0, 0], [4, 0], [1, 0], [3, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
    make.add(
        "back-and-forth-on-one-edge",
        "an edge walked forth, back and forth again",
        [back_and_forth],
        **points,
    )
    make.add(
        "vertex-of-180.00000000000014",
        "a rounding past the antimeridian, as Natural Earth has it",
        [[box(170, 0, 180.00000000000014, 10)], [box(-180, 0, -170, 10)]],
        truth=[rectangle(170, 0, 190, 10)],
        inside=[[179.999, 5], [-179.999, 5], [175, 5], [-175, 5]],
        outside=[[165, 5]],
        loops=1,
    )


# Crossing rings --------------------------------------------------------------------------------

BOW_TIE = [[0, 0], [2, 2], [2, 0], [0, 3], [0, 0]]


def crossing_of(a, b, c, d):
    points = [tuple(Fraction(v) for v in p) for p in (a, b, c, d)]
    return exact.crossing(*points)


def arcs_crossing_of(a, b, c, d):
    a, b, c, d = (exact.normal(p) for p in (a, b, c, d))
    x, y, z = exact.cross(exact.cross(a, b), exact.cross(c, d))
    if exact.dot((x, y, z), a) < 0:
        x, y, z = -x, -y, -z
    mp = exact.mpmath
    return (mp.atan2(y, x) / exact.DEG, mp.atan2(z, mp.hypot(x, y)) / exact.DEG)


def crossing(make):
    bow_tie = BOW_TIE
    make.refuse(
        "bow-tie-planar",
        "a ring that crosses itself",
        [bow_tie],
        ["polygon 0, ring 0, vertex 0", "polygon 0, ring 0, vertex 2"],
        stage="mesh",
        place=(0, 0, 0, 0),
        at=crossing_of(bow_tie[0], bow_tie[1], bow_tie[2], bow_tie[3]),
    )
    at = arcs_crossing_of(bow_tie[0], bow_tie[1], bow_tie[2], bow_tie[3])
    make.refuse(
        "bow-tie-arcs",
        "great ellipses that cross",
        [bow_tie],
        ["polygon 0, ring 0, vertex 0", "polygon 0, ring 0, vertex 2"],
        stage="mesh",
        rule="great-ellipse",
        place=(0, 0, 0, 0),
        at=at,
    )
    make.add(
        "bow-tie-repaired-planar",
        "a ring that crosses itself",
        [bow_tie],
        crosses=True,
        repair=True,
        warnings=["1 crossing of edges"],
        inside=[[1.8, 1], [0.2, 1]],
        outside=[[1, 2], [1, 0.5]],
    )
    at = [float(v) for v in at]
    west = [tuple(bow_tie[0]), tuple(at), tuple(bow_tie[3])]
    east = [tuple(at), tuple(bow_tie[1]), tuple(bow_tie[2])]
    make.add(
        "bow-tie-repaired-arcs",
        "great ellipses that cross",
        [bow_tie],
        rule="great-ellipse",
        sphere_truth=[(1, west), (1, east)],
        crosses=True,
        repair=True,
        warnings=["1 crossing of edges"],
        inside=[[1.8, 1], [0.2, 1]],
        outside=[[1, 2], [1, 0.5]],
    )
    star = [
        [round(10 + 4 * math.cos(0.8 * math.pi * k), 3), round(5 + 4 * math.sin(0.8 * math.pi * k), 3)]
        for k in range(5)
    ]
    make.add(
        "pentagram-repaired",
        "five points filled, the pentagon between them not",
        [star],
        crosses=True,
        repair=True,
        warnings=["5 crossings of edges"],
        inside=[[13, 5]],
        outside=[[10, 5], [14, 7]],
    )
    figure_of_eight = [[0, 0], [1, 1], [2, 0], [2, 2], [1, 1], [0, 2], [0, 0]]
    make.both(
        "figure-of-eight-at-a-vertex",
        "a ring that touches itself at a vertex of both passes",
        [figure_of_eight],
        inside=[[0.2, 1], [1.8, 1]],
        outside=[[1, 0.5], [1, 1.5]],
    )
    touches_own_edge = [[0, 0], [4, 0], [4, 4], [2, 0], [0, 4], [0, 0]]
    make.add(
        "vertex-on-own-edge",
        "a ring with a vertex on one of its own edges",
        [touches_own_edge],
        inside=[[3.5, 1], [0.5, 1]],
        outside=[[2, 2]],
    )
    overlapping = [[box(0, 0, 2, 2)], [box(1, 1, 3, 3)]]
    make.refuse(
        "overlapping-polygons",
        "two polygons of one region that overlap",
        overlapping,
        ["polygon 0, ring 0", "polygon 1, ring 0"],
        stage="mesh",
        place=(0, 0, 0),
    )
    make.add(
        "overlapping-polygons-repaired",
        "filled where an odd number of polygons is",
        overlapping,
        crosses=True,
        repair=True,
        warnings=["2 crossings of edges"],
        inside=[[0.5, 0.5], [2.5, 2.5]],
        outside=[[1.5, 1.5]],
    )
    sticking_out = [box(0, 0, 4, 4), box(3, 1, 5, 3)]
    make.refuse(
        "hole-sticks-out",
        "a hole partly outside its shell",
        sticking_out,
        ["polygon 0, ring 0", "polygon 0, ring 1"],
        stage="mesh",
        place=(0, 0, 0),
    )
    make.add(
        "hole-sticks-out-repaired",
        "a hole partly outside its shell",
        sticking_out,
        truth=[rectangle(0, 0, 4, 4), rectangle(3, 1, 5, 3)],
        crosses=True,
        repair=True,
        warnings=["2 crossings of edges"],
        inside=[[1, 1], [4.5, 2]],
        outside=[[3.5, 2]],
    )
    comb_over_comb = [
        [[0, 0], [9, 1], [0, 2], [9, 3], [0, 4], [9, 5], [0, 6]],
        [[1, -1], [2, 7], [3, -1], [4, 7], [5, -1], [6, 7], [7, -1]],
    ]
    make.add(
        "zigzag-over-zigzag-repaired",
        "two zigzags across one another",
        [[ring] for ring in comb_over_comb],
        crosses=True,
        repair=True,
    )


# Refusals --------------------------------------------------------------------------------------


def refusals_of_texts(make):
    square = polygon_text([box(0, 0, 1, 1)])
    make.refuse("empty-file", "no bytes", "", ["empty"])
    make.refuse("white-space", "only white space", " \r\n\t ", ["empty"])
    make.refuse("truncated", "cut off in the coordinates", square[:40], ["line 1, column", "EOF"])
    make.refuse(
        "not-a-number",
        "NaN for a latitude, on line 2",
        '{"type":"Polygon","coordinates":\n[[[0,0],[1,NaN],[1,1]]]}',
        ["line 2, column 12", "NaN"],
    )
    make.refuse(
        "infinity",
        "-Infinity for a longitude",
        '{"type":"Polygon","coordinates":[[[0,0],[-Infinity,0],[1,1]]]}',
        ["line 1", "-Infinity"],
    )
    make.refuse(
        "overflow",
        "1e999 for a longitude",
        '{"type":"Polygon","coordinates":[[[0,0],[1e999,0],[1,1]]]}',
        ["line 1", "1e999"],
    )
    make.refuse("trailing-text", "a second value after the first", square + square, ["line 1"])
    make.refuse("nested-too-deep", "200 lists in one another", '{"type":"Polygon","coordinates":' + "[" * 200 + "]" * 200 + "}", ["recursion limit"])
    make.refuse(
        "bare-ring-list",
        "rings without an object round them",
        json.dumps([box(0, 0, 1, 1)]),
        ["bare list", "GeoJSON object"],
    )
    make.refuse("not-an-object", "a text", '"Polygon"', ["GeoJSON object"])
    make.refuse("no-type", "an object without a type", '{"coordinates":[]}', ["no \"type\""])
    make.refuse(
        "misspelt-type",
        "Polygone",
        square.replace("Polygon", "Polygone"),
        ["Polygone", "Polygon, MultiPolygon"],
    )
    make.refuse(
        "topology",
        "TopoJSON",
        '{"type":"Topology","objects":{},"arcs":[]}',
        ["Topology", "FeatureCollection"],
    )
    make.refuse(
        "type-is-a-number", "7 for a type", square.replace('"Polygon"', "7"), ["line 1", "string"]
    )
    make.refuse(
        "no-features", "a collection of no features", collection(), ["no features"]
    )
    make.refuse(
        "features-missing",
        "a collection without a list",
        '{"type":"FeatureCollection"}',
        ['no "features"', "FeatureCollection"],
    )
    make.refuse(
        "feature-in-place-of-a-geometry",
        "a geometry listed as a feature",
        collection(square),
        ['type "Polygon"', "Feature"],
        place=(0,),
    )
    make.refuse(
        "no-geometry",
        "a feature whose geometry is null",
        collection(feature(square), feature("null", "Atlantis")),
        ["feature 1 (Atlantis)", 'no "geometry"'],
        place=(1,),
    )
    make.refuse(
        "no-coordinates",
        "a polygon without coordinates",
        feature('{"type":"Polygon"}'),
        ['no "coordinates"', "Polygon"],
        place=(0,),
    )
    make.refuse(
        "several-wrong-features",
        "every problem of a file in one round",
        collection(
            feature(polygon_text([box(0, 0, 1, 91)]), "too high"),
            feature(square, "good"),
            feature(polygon_text([[[0, 0], [1, 0], [0, 0]]]), "too short"),
            feature('{"type":"Point","coordinates":[0,0]}', "a point"),
        ),
        ["feature 0 (too high)", "latitude 91"],
        place=(0, 0, 0, 2),
        others=[
            ["feature 0 (too high)", "vertex 2", "latitude 91"],
            ["feature 0 (too high)", "vertex 3", "latitude 91"],
            ["feature 2 (too short)", "2 distinct positions"],
            ["feature 3 (a point)", "Point"],
        ],
    )


def refusals_of_shapes(make):
    make.refuse(
        "latitude-91",
        "beyond the north pole",
        [[[0, 0], [1, 0], [1, 91], [0, 0]]],
        ["latitude 91", "-90 … 90"],
        place=(0, 0, 0, 2),
    )
    make.refuse(
        "latitude-just-below-minus-90",
        "the next number beyond the south pole",
        [[[0, 0], [1, -90.00000000000001], [1, 1], [0, 0]]],
        ["latitude -90.00000000000001", "-90 … 90"],
        place=(0, 0, 0, 1),
    )
    make.refuse(
        "longitude-541",
        "more than a turn past the antimeridian, in a hole",
        [box(0, 0, 9, 9), [[1, 1], [2, 1], [541, 2], [1, 1]]],
        ["longitude 541", "-540 … 540"],
        place=(0, 0, 1, 2),
    )
    make.refuse(
        "swapped-metres",
        "projected metres for degrees",
        [[[500000, 4649776], [500100, 4649776], [500100, 4649876], [500000, 4649776]]],
        ["longitude 500000", "-540 … 540"],
        place=(0, 0, 0, 0),
        others=[[f"vertex {i}", word] for i in range(4) for word in ("longitude", "latitude")],
    )
    make.refuse(
        "two-point-ring",
        "there and back",
        [[[0, 0], [1, 1], [0, 0]]],
        ["2 distinct positions", "at least 3"],
        place=(0, 0, 0),
    )
    make.refuse(
        "one-point-ring",
        "four times the same position",
        [[[3, 4], [3, 4], [3, 4], [3, 4]]],
        ["1 distinct positions", "at least 3"],
        place=(0, 0, 0),
    )
    make.refuse(
        "two-points-many-times",
        "two positions by turns",
        [[[0, 0], [1, 1], [0, 0], [1, 1], [0, 0]]],
        ["2 distinct positions", "at least 3"],
        place=(0, 0, 0),
    )
    for name, says, text in (
        ("empty-coordinates", "no rings", '{"type":"Polygon","coordinates":[]}'),
        ("empty-ring", "a ring of no positions", '{"type":"Polygon","coordinates":[[]]}'),
        ("empty-multipolygon", "no polygons", '{"type":"MultiPolygon","coordinates":[]}'),
    ):
        make.refuse(name, says, text, ["empty coordinates", "at least 3"], place=(0,))
    make.refuse(
        "empty-position",
        "a position of no numbers",
        '{"type":"Polygon","coordinates":[[[0,0],[],[1,1],[0,1]]]}',
        ["in the coordinates"],
        place=(0, 0, 0, 1),
    )
    make.refuse(
        "position-of-one-number",
        "a longitude without a latitude",
        '{"type":"Polygon","coordinates":[[[0,0],[1],[1,1],[0,1]]]}',
        ["1 number", "two or more numbers"],
        place=(0, 0, 0, 1),
    )
    make.refuse(
        "text-in-a-position",
        "a number in quotation marks",
        '{"type":"Polygon","coordinates":[[[0,0],[1,"2"],[1,1],[0,1]]]}',
        ["\"2\"", "two or more numbers"],
        place=(0, 0, 0, 1),
    )
    make.refuse(
        "rings-missing",
        "positions where rings should be",
        '{"type":"Polygon","coordinates":[[0,0],[1,0],[1,1],[0,0]]}',
        ["a position", "a list of positions"],
        place=(0, 0, 0),
        others=[[f"ring {i}", "a position"] for i in range(4)],
    )
    make.refuse(
        "one-list-too-many",
        "a polygon's coordinates nested as a multipolygon's",
        polygon_text([[box(0, 0, 1, 1)]]),
        ["a list of lists", "two or more numbers"],
        place=(0, 0, 0, 0),
    )
    make.refuse(
        "point",
        "a feature without area",
        feature('{"type":"Point","coordinates":[1,2]}', "Null Island"),
        ["Null Island", "Point", "Polygon or MultiPolygon"],
        place=(0,),
    )
    make.refuse(
        "line",
        "a closed line is not a polygon",
        '{"type":"LineString","coordinates":[[0,0],[1,0],[1,1],[0,0]]}',
        ["LineString", "Polygon"],
    )
    make.refuse(
        "collection-of-lines",
        "a geometry collection without area",
        '{"type":"GeometryCollection","geometries":[{"type":"LineString","coordinates":[[0,0],[1,0]]}]}',
        ["LineString", "Polygon or MultiPolygon"],
        place=(0,),
    )
    make.refuse(
        "empty-collection",
        "a geometry collection of nothing",
        '{"type":"GeometryCollection","geometries":[]}',
        ["empty collection"],
        place=(0,),
    )
    twice = parallel(70, -180, 0, 180, -180) + parallel(75, 0, 180, -180) + parallel(70, -180)
    make.refuse(
        "twice-round-the-pole",
        "a ring that goes round the axis twice",
        [twice],
        ["2 times", "at most 1"],
        place=(0, 0, 0),
    )
    make.refuse(
        "no-area",
        "three positions on one line",
        [[[0, 0], [1, 0], [2, 0], [0, 0]]],
        ["no area"],
        stage="mesh",
        place=(0,),
    )
    make.refuse(
        "hole-equals-shell",
        "a hole that leaves nothing",
        [box(0, 0, 1, 1), box(0, 0, 1, 1)],
        ["no area"],
        stage="mesh",
        place=(0,),
    )
    make.refuse(
        "opposite-ends",
        "a great ellipse between opposite points",
        [[[0, 10], [180, -10], [90, 0]]],
        ["opposite points", "put a vertex between"],
        stage="mesh",
        rule="great-ellipse",
        place=(0, 0, 0, 0),
    )
    make.refuse(
        "from-pole-to-pole",
        "a great ellipse from one pole to the other",
        [[[10, -90], [10, 90], [40, 0]]],
        ["opposite points", "put a vertex between"],
        stage="mesh",
        rule="great-ellipse",
        place=(0, 0, 0, 0),
    )
