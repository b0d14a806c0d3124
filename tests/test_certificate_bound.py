"""One bound on an outline's error: the residual and the gaps between its edges together."""

from __future__ import annotations

import pytest

from brep_slicer.section import Certificate, Engine


@pytest.mark.parametrize(("residual", "gap"), [(1e-12, 0.038), (0.215, 0.157), (5e-6, 0.0), (0.0, 1e-3)])
def test_a_gap_does_not_hide_behind_a_small_residual(residual, gap):
    certificate = Certificate(engine=Engine.ANALYTIC, residual=residual, jog=gap)
    assert certificate.bound == pytest.approx(residual + gap, rel=1e-15)
    assert certificate.as_dict()["outline_error_mm"] == certificate.bound
