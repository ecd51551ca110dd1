#!/usr/bin/env python3
# SPDX-License-Identifier: MIT OR Apache-2.0
"""Areas and inside tests for rings on an ellipsoid, in 40 digits and exact fractions.

Degrees in, square metres out. Shares nothing with `core`:

- planar areas: strips between the latitudes of the vertices, in each the alternating sum of the
  edges' longitudes (even-odd by construction, exact fractions) times M N cos(phi), the product of
  the radii of curvature, integrated over the strip by Gauss-Legendre. `core` goes round the
  boundary with the authalic function instead;
- great-ellipse areas: the normals map the body to the unit sphere, and an area of the sphere counts
  M N times on the body (1 / Gaussian curvature). Integrated over the fan of flat triangles between
  a point and the edges; no longitude appears, so poles and the antimeridian are places like any
  other. That the shorter great circle between two normals is the great-ellipse edge follows from
  tan(geodetic) = tan(geocentric) / (1 - e^2), a linear map of space;
- inside and outside: exact parity (planar), sum of azimuths (great ellipse).

Each area is computed with two orders of quadrature that must agree.
"""

import math
from fractions import Fraction

import mpmath
from mpmath import mpf

mpmath.mp.dps = 40
DEG = mpmath.pi / 180

BODIES = {
    "wgs84": ("6378137", "6356752.314245179"),
    "moon": ("1737400", "1737400"),
    "mars": ("3396190", "3376200"),
    "saturn-like": ("60268000", "54364000"),
    "unit-sphere": ("1", "1"),
    "asteroid-250m": ("250", "230"),
}


# Quadrature ------------------------------------------------------------------------------------


def gauss_legendre(n):
    """Nodes and weights on [0, 1]."""
    nodes = []
    for i in range(1, n + 1):
        x = mpmath.cos(mpmath.pi * (i - mpf(1) / 4) / (n + mpf(1) / 2))
        for _ in range(100):
            p0, p1 = mpf(1), x
            for k in range(2, n + 1):
                p0, p1 = p1, ((2 * k - 1) * x * p1 - (k - 1) * p0) / k
            slope = n * (x * p1 - p0) / (x * x - 1)
            step = p1 / slope
            x -= step
            if abs(step) < mpf(10) ** -38:
                break
        nodes.append(((1 + x) / 2, 1 / ((1 - x * x) * slope * slope)))
    return nodes


ORDERS = {n: gauss_legendre(n) for n in (4, 6, 12, 18, 24, 32)}


def agreed(integral, low, high):
    """The integral by the higher order, once the lower one agrees with it."""
    coarse, fine = integral(ORDERS[low]), integral(ORDERS[high])
    if abs(coarse - fine) > mpf(10) ** -14 * abs(fine):
        raise AssertionError(f"quadrature has not converged: {coarse} {fine}")
    return fine


class Body:
    def __init__(self, name):
        a, b = (mpf(text) for text in BODIES[name])
        self.name, self.a, self.b = name, a, b
        self.e2 = 1 - (b / a) ** 2

    def inverse_curvature(self, sin_squared):
        """M N, square metres per steradian of normals."""
        return self.b**2 / (1 - self.e2 * sin_squared) ** 2

    def whole(self):
        e = mpmath.sqrt(self.e2)
        artanh = mpmath.atanh(e) / e if e else mpf(1)
        return 2 * mpmath.pi * (self.a**2 + self.b**2 * artanh)


# Planar rings ----------------------------------------------------------------------------------


def exact(ring):
    return [(Fraction(x), Fraction(y)) for x, y in ring]


def edges_of(rings):
    for ring in rings:
        points = exact(ring)
        yield from zip(points, points[1:] + points[:1])


def crossing(a, b, c, d):
    """Where two segments cross or touch at one point, exactly; None for parallels."""
    r = (b[0] - a[0], b[1] - a[1])
    s = (d[0] - c[0], d[1] - c[1])
    det = r[0] * s[1] - r[1] * s[0]
    if det == 0:
        return None
    q = (c[0] - a[0], c[1] - a[1])
    t = (q[0] * s[1] - q[1] * s[0]) / det
    u = (q[0] * r[1] - q[1] * r[0]) / det
    if 0 <= t <= 1 and 0 <= u <= 1:
        return (a[0] + t * r[0], a[1] + t * r[1])
    return None


def to_mp(fraction):
    return mpf(fraction.numerator) / mpf(fraction.denominator)


def planar_area(body, rings, crosses):
    edges = [(a, b) for a, b in edges_of(rings) if a != b]
    levels = {y for edge in edges for _, y in edge}
    if crosses:
        for i, (a, b) in enumerate(edges):
            for c, d in edges[:i]:
                at = crossing(a, b, c, d)
                if at:
                    levels.add(at[1])
    levels = sorted(levels)
    # Strips no higher than 6 degrees converge to the last digit.
    cuts = [levels[0]]
    for level in levels[1:]:
        pieces = max(1, math.ceil((level - cuts[-1]) / 6))
        start = cuts[-1]
        cuts += [start + (level - start) * k / pieces for k in range(1, pieces + 1)]

    rising = sorted((min(a[1], b[1]), max(a[1], b[1]), a, b) for a, b in edges if a[1] != b[1])
    strips = []
    active, at = [], 0
    for low, high in zip(cuts, cuts[1:]):
        while at < len(rising) and rising[at][0] <= low:
            active.append(rising[at])
            at += 1
        active = [edge for edge in active if edge[1] > low]

        def longitude(edge, y):
            _, _, a, b = edge
            return a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])

        middle = (low + high) / 2
        order = sorted(active, key=lambda edge: longitude(edge, middle))
        assert len(order) % 2 == 0, "the rings are closed"

        def width(y):
            signed = (longitude(e, y) * (1 if i % 2 else -1) for i, e in enumerate(order))
            return to_mp(sum(signed, Fraction(0))) * DEG

        if order:
            strips.append((to_mp(low) * DEG, to_mp(high) * DEG, width(low), width(high)))

    def integral(rule):
        total = mpf(0)
        for low, high, width_low, width_high in strips:
            for t, weight in rule:
                sin, cos = mpmath.sin(low + (high - low) * t), mpmath.cos(low + (high - low) * t)
                width = width_low + (width_high - width_low) * t
                total += weight * width * body.inverse_curvature(sin * sin) * cos * (high - low)
        return total

    low, high = (4, 6) if len(strips) > 500 else (12, 18)
    return agreed(integral, low, high)


def simple_ring_area(body, ring):
    """For rings of very many short edges: the same integral edge by edge, signed."""
    points = [(mpf(x), mpf(y)) for x, y in ring]
    middle = points[0][0]

    def integral(rule):
        total = mpf(0)
        for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1]):
            part = mpf(0)
            for t, weight in rule:
                y = (y0 + (y1 - y0) * t) * DEG
                sin = mpmath.sin(y)
                x = x0 + (x1 - x0) * t - middle
                part += weight * x * body.inverse_curvature(sin * sin) * mpmath.cos(y)
            total += part * (y1 - y0) * DEG * DEG
        return abs(total)

    return integral(ORDERS[4])


def planar_holds(edges, point):
    """Parity of the edges east of the point, at every whole number of turns.

    A pole is every longitude at once; just before it, it is one.
    """
    inside = False
    almost = 90 - Fraction(1, 10**20)
    y = min(max(Fraction(point[1]), -almost), almost)
    for turn in range(-3, 4):
        x = Fraction(point[0]) + 360 * turn
        for a, b in edges:
            if (a[1] > y) != (b[1] > y):
                at = a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])
                inside ^= at > x
    return inside


# Great circles on the sphere of normals --------------------------------------------------------


def normal(point):
    x, y = mpf(point[0]) * DEG, mpf(point[1]) * DEG
    if abs(point[1]) == 90:
        return (mpf(0), mpf(0), mpf(1 if point[1] > 0 else -1))
    return (mpmath.cos(y) * mpmath.cos(x), mpmath.cos(y) * mpmath.sin(x), mpmath.sin(y))


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def unit(v):
    length = mpmath.sqrt(dot(v, v))
    return tuple(x / length for x in v)


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def centre_of(normals):
    centre = unit(tuple(sum(v[i] for v in normals) for i in range(3)))
    assert all(dot(centre, v) > 0 for v in normals), "a ring must lie in a hemisphere"
    return centre


def subdivide(a, b, most=mpf("0.1")):
    """The arc in pieces of at most `most` radians."""
    if dot(minus(a, b), minus(a, b)) <= most * most:
        return [(a, b)]
    middle = unit(tuple(x + y for x, y in zip(a, b)))
    return subdivide(a, middle, most) + subdivide(middle, b, most)


def sphere_area(body, ring):
    """Signed by the ring's winding."""
    normals = [normal(point) for point in ring]
    apex = centre_of(normals)
    arcs = [
        arc
        for a, b in zip(normals, normals[1:] + normals[:1])
        if a != b
        for arc in subdivide(a, b)
    ]

    def integral(rule):
        total = mpf(0)
        for a, b in arcs:
            volume = dot(apex, cross(a, minus(b, a)))
            part = mpf(0)
            for s, s_weight in rule:
                for t, t_weight in rule:
                    q = tuple(
                        apex[i] + s * (a[i] - apex[i] + t * (b[i] - a[i])) for i in range(3)
                    )
                    squared = dot(q, q)
                    density = body.inverse_curvature(q[2] ** 2 / squared)
                    part += s_weight * t_weight * s * density / squared ** mpf("1.5")
            total += part * volume
        return total

    widest = min(dot(apex, v) for v in normals)
    low, high = (6, 12) if widest > mpf("0.999") else (12, 18) if widest > mpf("0.8") else (24, 32)
    return agreed(integral, low, high)


def sphere_holds(ring, point):
    """Whether azimuths seen from the point add up to a turn."""
    normals = [normal(vertex) for vertex in ring]
    p = normal(point)
    if dot(p, centre_of(normals)) <= 0:
        return False
    total = mpf(0)
    for a, b in zip(normals, normals[1:] + normals[:1]):
        u, v = cross(p, a), cross(p, b)
        total += mpmath.atan2(dot(p, cross(u, v)), dot(u, v))
    return abs(total) > mpmath.pi
