"""The `analytic` engine: level sets of rho on every face, joined by the identity of the edges' crossings.

In: a solid's numpy geometry and all radii at once. Out: closed loops of exact curves for each radius, with a certificate.
"""

from .engine import IN_NOISE, sections_by_analysis

__all__ = ["IN_NOISE", "sections_by_analysis"]
