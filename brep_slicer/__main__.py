"""The command as `python -m brep_slicer`.

In: words from a shell. Out: what `brep-slicer` does.
"""

from .cli import run

if __name__ == "__main__":
    run()
