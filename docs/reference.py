"""docs/process.md, the reference page of all parameters: python -m docs.reference.

In: nothing. Out: the page, beside this file.
"""

from __future__ import annotations

from pathlib import Path

from brep_slicer.process.reference import reference_page

PAGE = Path(__file__).resolve().parent / "process.md"


def main() -> None:
    PAGE.write_text(reference_page(), encoding="utf-8")


if __name__ == "__main__":
    main()
