"""Where the parts are, and what several tests ask of them."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FIXTURES = ROOT / "fixtures" / "step"
REAL = ROOT.parent / "shared" / "step"


@pytest.fixture
def fixture_step():
    """Path of a committed STEP fixture by name."""
    return lambda name: FIXTURES / f"{name}.step"


@pytest.fixture
def real_step():
    """Path of a real part by file name; the test is skipped where the parts are not at hand."""

    def find(name: str) -> Path:
        path = REAL / name
        if not path.exists():
            pytest.skip(f"{name} is not here: real parts are read from {REAL}, not copied into the project")
        return path

    return find
