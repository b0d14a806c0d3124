"""Solids whose top is nearly level: the graph x = f(y, z) of a polynomial over a rectangle, and the metal below it.

In: f's coefficients. Out: a build123d solid whose top is one B-spline face, and the area of its sections about z by formula.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

DEPTH = 10.0
# Places across the rectangle of which the formula's sum is made.
STRIPS = 200_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Graph:
    """x = sum of power[i][j] * y**i * z**j (mm) for |y| <= wide and 0 <= z <= high; at most quadratic in z."""

    power: tuple[tuple[float, ...], ...]
    wide: float
    high: float

    def height(self, y, z):
        """f(y, z)."""
        return np.polynomial.polynomial.polyval2d(y, z, np.array(self.power))

    def solid(self):
        """The graph and DEPTH mm below it."""
        import build123d as bd

        poles = self._poles()
        n, m = poles.shape
        ys, zs = np.linspace(-self.wide, self.wide, n), np.linspace(0.0, self.high, m)
        points = [[bd.Vector(float(poles[i, j]), float(ys[i]), float(zs[j])) for j in range(m)] for i in range(n)]
        return bd.Solid.extrude(bd.Face.make_bezier_surface(points), bd.Vector(-DEPTH, 0, 0))

    def _poles(self):
        """Heights of the Bezier poles: y = -w + 2 w s and z = h t, power to Bernstein."""
        p = np.array(self.power)
        n, m = p.shape[0] - 1, p.shape[1] - 1
        shift = np.zeros((n + 1, n + 1))
        for i in range(n + 1):
            for k in range(i + 1):
                shift[k, i] = comb(i, k) * (-self.wide) ** (i - k) * (2.0 * self.wide) ** k
        unit = shift @ p @ np.diag(self.high ** np.arange(m + 1))

        def bernstein(d):
            return np.array([[comb(i, k) / comb(d, k) if k <= i else 0.0 for k in range(d + 1)] for i in range(d + 1)])

        return bernstein(n) @ unit @ bernstein(m).T

    def area(self, radius):
        """The integral over y of R / sqrt(R**2 - y**2) * (length of the z at which f(y, z) >= sqrt(R**2 - y**2)), mm**2."""
        y = self.wide * (2.0 * (np.arange(STRIPS) + 0.5) / STRIPS - 1.0)
        x = np.sqrt(radius**2 - y**2)
        c = np.zeros((3, STRIPS))
        for j in range(len(self.power[0])):
            c[j] = np.polynomial.polynomial.polyval(y, [row[j] for row in self.power])
        c[0] -= x
        # where c0 + c1 z + c2 z**2 changes sign, between 0 and `high`; a straight line counts as a very flat parabola
        flat = np.abs(c[2]) < 1e-12
        square = np.where(flat, 1.0, c[2])
        under = c[1] ** 2 - 4.0 * c[0] * square
        root = np.sqrt(np.maximum(under, 0.0))
        q = -0.5 * (c[1] + np.where(c[1] < 0.0, -1.0, 1.0) * root)
        with np.errstate(divide="ignore", invalid="ignore"):
            one = np.where(flat, -c[0] / c[1], np.where(under >= 0.0, q / square, 0.0))
            two = np.where(flat, 0.0, np.where(under >= 0.0, c[0] / q, 0.0))
        cuts = np.sort(np.clip(np.nan_to_num([one, two, np.zeros(STRIPS), np.full(STRIPS, self.high)]), 0.0, self.high), axis=0)
        middle = 0.5 * (cuts[1:] + cuts[:-1])
        above = c[0] + c[1] * middle + c[2] * middle**2 >= 0.0
        return float((radius / x * (np.diff(cuts, axis=0) * above).sum(axis=0)).sum() * 2.0 * self.wide / STRIPS)
