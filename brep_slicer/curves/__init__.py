"""Curves of an unrolled section: frozen values in the plane (kappa, v), pure numpy, no CAD kernel.

In: the parameters of one edge of a section. Out: points, derivatives, exact integrals, samples to a chord.

Words: *kind*, what a curve is (line, arc, sinusoid, quadric, spline), kept to the end; *range*, the part of its own
parameter that the edge covers; *chord*, how far a sampled polyline may lie off the curve.
"""

from .arc import ArcCurve
from .base import Curve, CurveKind
from .batch import CurveBatch
from .line import LineCurve
from .loop import Loop, with_apex
from .quadric import QuadricCurve
from .sinusoid import SinusoidCurve
from .spline import SplineCurve

__all__ = [
    "ArcCurve",
    "Curve",
    "CurveBatch",
    "CurveKind",
    "LineCurve",
    "Loop",
    "QuadricCurve",
    "SinusoidCurve",
    "SplineCurve",
    "with_apex",
]
